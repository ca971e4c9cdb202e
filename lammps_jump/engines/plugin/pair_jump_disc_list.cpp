// SPDX-License-Identifier: GPL-2.0-or-later
/* The neighbour list of pair_style jump/disc (what it is: pair_jump_disc.h). */

#include "contact/no_contraction.h"

#include "step/pair_search.h"    // before the core: its templates take vectors

#include "pair_jump_disc.h"

#include "atom.h"
#include "comm.h"
#include "error.h"
#include "modify.h"
#include "neighbor.h"
#include "update.h"

#include <algorithm>
#include <cmath>
#include <cstring>

using namespace LAMMPS_NS;
/** Whether the local discs that the list knows still have the same indices (more may have come after them). */
bool PairJumpDisc::keeps_order() const
{
  const size_t n = listed.size();
  return n > 0 && (size_t) atom->nlocal >= n && memcmp(listed.data(), atom->tag, n * sizeof(tagint)) == 0;
}

void PairJumpDisc::remember_order()
{
  listed.assign(atom->tag, atom->tag + atom->nlocal);
  order++;
}

namespace {
/** Room for so many pairs. */
void make_room(size_t pairs, std::vector<int> &first, std::vector<int> &second)
{
  if (first.size() >= pairs) return;
  first.resize(pairs + pairs / 2 + 1024);
  second.resize(first.size());
}
}    // namespace

/** Smallest box around the first n packed discs; an error where they are nowhere, or further apart than a number of cells
    of this width can be. */
jump::BoxOfPlaces PairJumpDisc::box_around(int n, double cut) const
{
  const int nlocal = atom->nlocal;
  jump::BoxOfPlaces box{disc[0].x, disc[0].x, disc[0].y, disc[0].y};
  for (int i = 0; i < n; i++) {
    if (!std::isfinite(disc[i].x) || !std::isfinite(disc[i].y))
      error->one(FLERR, "jump/disc: the position of {} {} is not a number: the run has blown up",
                 i < nlocal ? "disc" : "a disc of another rank beside disc", i < nlocal ? atom->tag[i] : nlocal > 0 ? atom->tag[0] : 0);
    box.xlo = std::min(box.xlo, disc[i].x);
    box.xhi = std::max(box.xhi, disc[i].x);
    box.ylo = std::min(box.ylo, disc[i].y);
    box.yhi = std::max(box.yhi, disc[i].y);
  }
  if (!(box.xhi - box.xlo < 1e9 * cut) || !(box.yhi - box.ylo < 1e9 * cut))
    error->one(FLERR, "jump/disc: discs are spread over {} m by {} m: the run has blown up",
               box.xhi - box.xlo, box.yhi - box.ylo);
  return box;
}

namespace {
/** The threads that share a search; few discs are for one. */
struct SearchCrew {
  jump::ThreadPool &pool;
  int count;

  SearchCrew(jump::ThreadPool &pool, int discs) : pool(pool), count(discs < 64 * pool.size() ? 1 : pool.size()) {}
  int shares() const { return count; }
  template <class Run> void stretches(int64_t n, const Run &run)
  {
    pool.run(count, [&](int part) { run(part, n * part / count, n * (part + 1) / count); });
  }
};
}    // namespace

/** Put the pairs of n packed discs into the list, in the order of the cells; returns their number.

    Cells are counted along x first, as LAMMPS sorts its discs: pairs that follow each other then lie close in memory. */
size_t PairJumpDisc::find_pairs(int n)
{
  const double cut = largest + skin;
  const auto cells = jump::SearchCells::along_x(box_around(n, cut), cut, n);
  columns_along = (int) cells.rows;
  rows_up = (int) cells.columns;
  for (auto *const of : {&sorted_x, &sorted_y, &sorted_radius}) of->resize(n);
  sorted.resize(n);
  for (int i = 0; i < n; i++) {
    sorted_x[i] = disc[i].x;
    sorted_y[i] = disc[i].y;
  }
  SearchCrew crew(pool, n);
  const jump::SearchedDiscs discs{n, sorted_x.data(), sorted_y.data(), sizes ? sorted_radius.data() : nullptr};
  jump::sort_discs<true>(discs, cells, search, crew);
  crew.stretches(n, [&](int, int64_t from, int64_t to) {
    for (int64_t s = from; s < to; s++) {
      const size_t i = jump::was_at(search.sorted[s]);
      sorted[s] = (int) i;
      sorted_x[s] = disc[i].x;
      sorted_y[s] = disc[i].y;
      if (sizes) sorted_radius[s] = radii[i];
    }
  });
  start.resize(n + 1);
  second.resize(std::max<size_t>(second.size(), 8 * (size_t) n + 1024));
  const jump::RowsOf rows(discs, jump::NumbersOf{sorted.data()}, search, sizes ? skin : cut, cells.height(), start.data());
  while (!jump::list_rows(rows, second.data(), (int64_t) second.size(), search, crew)) second.resize(2 * second.size());
  first.resize(second.size());
  crew.stretches(n, [&](int, int64_t from, int64_t to) {
    for (int64_t s = from; s < to; s++) std::fill(&first[start[s]], &first[start[s + 1]], sorted[s]);
  });
  return (size_t) start[n];
}

/** All pairs whose rims are closer than the skin, from the packed positions. */
void PairJumpDisc::build_list()
{
  const int nlocal = atom->nlocal;
  const int n = nlocal + ring.count();
  candidates = interior = built = 0;
  divided = 0;
  for (int c = 0; c < 2; c++) moved[c] = moved_here[c] = 0.0;
  first_across.clear();
  second_across.clear();
  check_discs(0, nlocal);
  remember_order();
  if (n == 0) return;
  built = interior = keep_local(find_pairs(n));
  candidates = interior + first_across.size();
  make_room(candidates, first, second);
  std::copy(first_across.begin(), first_across.end(), first.begin() + interior);
  std::copy(second_across.begin(), second_across.end(), second.begin() + interior);
}

/** Keep the pairs of local discs in the list and put the others beside it; returns the number of those that stay. */
size_t PairJumpDisc::keep_local(size_t found)
{
  const int nlocal = atom->nlocal;
  if (ring.count() == 0) return found;
  size_t local = 0;
  for (size_t p = 0; p < found; p++) {
    const int i = std::min(first[p], second[p]), j = std::max(first[p], second[p]);
    if (j < nlocal) {
      first[local] = first[p];
      second[local++] = second[p];
    } else if (i < nlocal) {    // a local disc comes first
      first_across.push_back(i);
      second_across.push_back(j);
    }
  }
  return local;
}

/** Divide the discs, and with them the pairs that were found together, into as many parts for the threads, or fewer.

    A part is a stretch of rows of cells, as the discs lie in memory; of columns in very flat flows, though there each row
    is cut, and what the processor fetches ahead behind a cut belongs to another part. It has all pairs of its discs in
    the order of the list. A pair over a cut is in both parts, each with a copy of the disc of the other, so that a
    part adds to its own discs alone: each sum is in the order of the list, whatever the parts are. Springs know no two
    places of a contact: with them only the part of the first disc has a pair, and what it adds to discs beside a cut is
    kept until all parts have ended. */
void PairJumpDisc::divide(int most)
{
  if (divided == most) return;
  divided = most;
  const int n = (int) sorted.size(), nlocal = atom->nlocal;
  const bool upright = columns_along > FLAT * rows_up;
  const int lines = upright ? columns_along : rows_up, least = upright ? LEAST_COLUMNS : LEAST_ROWS;
  const int count = std::max(1, std::min(most, lines / least));
  place.resize(disc.size());
  home.resize(disc.size());
  std::vector<int> line_of(disc.size());
  const int64_t framed = columns_along + 2;    // a frame of empty cells surrounds the others
  for (int s = 0; s < n; s++) {
    const int i = sorted[s];
    const int64_t cell = jump::cell_of(search.sorted[s]);
    line_of[i] = (int) (upright ? cell % framed : cell / framed) - 1;
    place[i] = s;
  }
  std::vector<size_t> before(lines + 1, 0);    // pairs of the lines before
  for (size_t p = 0; p < built; p++) before[line_of[first[p]] + 1]++;
  for (int l = 0; l < lines; l++) before[l + 1] += before[l];
  std::vector<uint8_t> part_of(lines);
  for (int c = 0, l = 0; c < count; c++) {
    const int even = (int) (std::lower_bound(before.begin(), before.end(), built * (c + 1) / count) - before.begin());
    const int end = c + 1 == count ? lines : std::clamp(even, l + least, lines - least * (count - 1 - c));
    for (; l < end; l++) part_of[l] = (uint8_t) c;
  }
  for (int i = 0; i < n; i++) home[i] = part_of[line_of[i]];
  // discs that share a line of memory are in one part, where they are not at the two ends of a row
  for (int i = 0; i + DISCS_A_LINE <= n; i += DISCS_A_LINE) {
    const auto group = home.begin() + i;
    const auto ends = std::minmax_element(group, group + DISCS_A_LINE);
    if (*ends.second - *ends.first == 1) std::fill_n(group, DISCS_A_LINE, home[i]);
  }
  parts.resize(count);
  if (springs) beside.assign(disc.size(), 0);
  pool.run(count, [&](int c) { fill(parts[c], c); });
  int copies = nlocal + ring.count() + ROOM_FOR_NEW;
  room = copies;
  for (auto &part : parts) {
    copies += DISCS_A_LINE - copies % DISCS_A_LINE;    // its copies begin with a line of memory
    part.copies = copies;
    copies += (int) part.across.size();
  }
  reserve(copies);
  home.resize(disc.size());    // of discs that come later, too
  for (auto &part : parts)
    for (auto *list : {&part.first, &part.second})
      for (const size_t p : part.over)
        if ((*list)[p] < 0) (*list)[p] = part.copies - 1 - (*list)[p];
}

/** The discs and pairs of a part; -1 - N stands for its Nth copy of a disc of another part. */
void PairJumpDisc::fill(PairPart &part, int own)
{
  const uint8_t *const __restrict of = home.data();
  const int n = atom->nlocal;
  part.discs.clear();
  part.edge.clear();
  part.across.clear();
  part.over.clear();
  for (int i = 0; i < n; i++)
    if (of[i] == own) part.discs.push_back(i);
  make_room(built + 4, part.first, part.second);    // four are read at a time
  part.copy_of.assign(home.size(), 0);
  int *const __restrict one = part.first.data();
  int *const __restrict two = part.second.data();
  const auto copy = [&](int i) {
    int &known = part.copy_of[i];
    if (known == 0) {
      part.across.push_back(i);
      known = -(int) part.across.size();
    }
    return known;
  };
  size_t pairs = 0;
  for (size_t p = 0; p < built; p++) {
    const int i = first[p], j = second[p];
    const bool has_i = of[i] == own, has_j = of[j] == own;
    if (!has_i && (!has_j || springs)) continue;
    one[pairs] = i;
    two[pairs] = j;
    if (!has_i || !has_j) {
      part.edge.push_back(has_i ? i : j);
      if (springs) {
        __atomic_store_n(&beside[j], (uint8_t) (std::min(own, (int) of[j]) + 1), __ATOMIC_RELAXED);
      } else {
        part.over.push_back(pairs);
        (has_i ? two : one)[pairs] = copy(has_i ? j : i);
      }
    }
    pairs++;
  }
  part.pairs = pairs;
}

/** New discs at the end, the others as they were: add the pairs of the new ones. */
void PairJumpDisc::append_to_list(int from)
{
  const int n = atom->nlocal;
  check_discs(from, n);
  if (n > room) divided = 0;    // their places are those of copies
  if (divided > 0)
    for (int j = from; j < n; j++) {
      home[j] = (uint8_t) (parts.size() - 1);
      parts.back().discs.push_back(j);
    }
  for (int j = from; j < n; j++) {
    make_room(candidates + j + 1, first, second);
    for (int i = 0; i < j; i++) {
      const double dx = disc[j].x - disc[i].x, dy = disc[j].y - disc[i].y;
      // the others may have moved since the list was built: look as far as they still may
      const double cut = reach_of(i, j) + skin;
      first[candidates] = i;
      second[candidates] = j;
      candidates += dx * dx + dy * dy < cut * cut;
    }
  }
  remember_order();
}

/** Whether the discs may be where fix jump/step did not move and pack them: before a run, or by fixes that act after it. */
bool PairJumpDisc::moved_by_others() const
{
  return update->setupflag || modify->n_post_integrate > 0;
}

/** Add this step to a bound of the way of the discs against one another. */
void PairJumpDisc::travel(double *way) const
{
  for (int c = 0; c < 2; c++) way[c] += update->dt * std::max(range_hi[c] - range_lo[c], 0.0);
}

/** Whether pairs may have come into reach that the list does not hold. */
bool PairJumpDisc::worn(const double *way) const
{
  return !(way[0] * way[0] + way[1] * way[1] < skin * skin);
}

/** Keep the list usable for the positions that are packed now. */
void PairJumpDisc::update_list()
{
  const bool other_indices = neighbor->ago == 0 && !(!ring.is_needed() && keeps_order());
  if (moved_by_others() || other_indices || worn(moved))
    build_list();
  else if (atom->nlocal > (int) listed.size())
    append_to_list((int) listed.size());
}
