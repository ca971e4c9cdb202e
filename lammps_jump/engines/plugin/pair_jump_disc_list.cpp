// SPDX-License-Identifier: GPL-2.0-or-later
/* The neighbour list of pair_style jump/disc (what it is: pair_jump_disc.h). */

#include "contact/no_contraction.h"

#include "contact/simd.h"
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
using jump::Four;
using jump::four;
using jump::FourInts;

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
PairJumpDisc::DiscBox PairJumpDisc::box_around(int n, double cut) const
{
  const int nlocal = atom->nlocal;
  DiscBox box{disc[0].x, disc[0].x, disc[0].y, disc[0].y};
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

/** All pairs whose rims are closer than the skin, from the packed positions.

    Cells are as wide as that distance and numbered along x first, as LAMMPS sorts its discs: pairs that follow each
    other then lie close in memory. What a disc can meet and that comes after it lies in two runs of the sorted discs,
    its own cell with the one beside, and the three cells above. */
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

  const double cut = largest + skin;
  const auto [xlo, xhi, ylo, yhi] = box_around(n, cut);
  double side = cut * (1.0 + 1e-9);    // rounding must not put neighbours two cells apart
  const double most = 16.0 * n + 65536.0;    // far-flung discs must not cost memory: wider cells then
  while (((xhi - xlo) / side + 3.0) * ((yhi - ylo) / side + 1.0) > most) side *= 2.0;
  const double inverse = 1.0 / side;
  const int nx = (int) ((xhi - xlo) * inverse) + 3;    // an empty column left and right: no tests at the rims
  const int ny = (int) ((yhi - ylo) * inverse) + 1;
  const size_t cells = (size_t) (ny + 1) * nx + 1;

  cell_of.resize(n);
  cell_start.assign(cells + 1, 0);
  sorted.resize(n + 8);    // four are read at a time
  sorted_x.resize(n + 8);
  sorted_y.resize(n + 8);
  if (sizes) sorted_radius.resize(n + 8);
  for (int i = 0; i < n; i++) {
    const int c = (int) ((disc[i].y - ylo) * inverse) * nx + (int) ((disc[i].x - xlo) * inverse) + 1;
    cell_of[i] = c;
    cell_start[c + 1]++;
  }
  for (size_t c = 0; c < cells; c++) cell_start[c + 1] += cell_start[c];
  // fill from the back, so that a cell keeps the order of the indices and its start ends where it belongs
  for (int i = n - 1; i >= 0; i--) {
    const int s = --cell_start[cell_of[i] + 1];
    sorted[s] = i;
    sorted_x[s] = disc[i].x;
    sorted_y[s] = disc[i].y;
    if (sizes) sorted_radius[s] = radii[i];
  }
  // now cell_start[c + 1] is where cell c begins: the discs of cell c are [cell_start[c + 1], cell_start[c + 2])
  built = interior = keep_local(find_pairs(n, nx));
  row = nx;
  candidates = interior + first_across.size();
  make_room(candidates, first, second);
  std::copy(first_across.begin(), first_across.end(), first.begin() + interior);
  std::copy(second_across.begin(), second_across.end(), second.begin() + interior);
}

/** Put the pairs of n sorted discs, in rows of nx cells, into the list; returns their number.

    Each thread finds those of a stretch of the sorted discs; put one behind the other they are as one thread finds them. */
size_t PairJumpDisc::find_pairs(int n, int nx)
{
  const auto find = [&](int from, int to, std::vector<int> &one, std::vector<int> &two) {
    return sizes ? find_pairs<true>(from, to, nx, one, two) : find_pairs<false>(from, to, nx, one, two);
  };
  const int count = n < 64 * pool.size() ? 1 : pool.size();
  if (count == 1) return find(0, n, first, second);
  found_first.resize(count);
  found_second.resize(count);
  std::vector<size_t> begin(count + 1, 0);
  pool.run(count, [&](int part) {
    const int from = (int) ((int64_t) n * part / count), to = (int) ((int64_t) n * (part + 1) / count);
    begin[part + 1] = find(from, to, found_first[part], found_second[part]);
  });
  for (int part = 0; part < count; part++) begin[part + 1] += begin[part];
  make_room(begin[count] + 4, first, second);
  pool.run(count, [&](int part) {
    std::copy_n(found_first[part].begin(), begin[part + 1] - begin[part], first.begin() + begin[part]);
    std::copy_n(found_second[part].begin(), begin[part + 1] - begin[part], second.begin() + begin[part]);
  });
  return begin[count];
}

/** Pairs of the sorted discs from one place to another. */
template <bool SIZES>
size_t PairJumpDisc::find_pairs(int from, int to, int nx, std::vector<int> &one, std::vector<int> &two) const
{
  size_t found = 0;
  for (int s = from; s < to; s++) {
    const int i = sorted[s];
    const int c = cell_of[i];
    const double x = sorted_x[s], y = sorted_y[s], rim = SIZES ? sorted_radius[s] + skin : 0.0;
    const int above = c + nx - 1;
    const int runs[2][2] = {{s + 1, cell_start[c + 3]}, {cell_start[above + 1], cell_start[above + 4]}};
    make_room(found + (runs[0][1] - runs[0][0]) + (runs[1][1] - runs[1][0]) + 4, one, two);
    for (const auto &run : runs) {
      for (int t = run[0]; t < run[1]; t += 4) {
        const Four dx = x - four(&sorted_x[t]), dy = y - four(&sorted_y[t]);
        const Four cut = SIZES ? rim + four(&sorted_radius[t]) : largest + skin - Four{};
        const int mask = jump::bits(dx * dx + dy * dy < cut * cut) & (run[1] - t < 4 ? (1 << (run[1] - t)) - 1 : 15);
        *reinterpret_cast<FourInts *>(&one[found]) = i - FourInts{};
        *reinterpret_cast<FourInts *>(&two[found]) = jump::first_of(four(&sorted[t]), mask);
        found += __builtin_popcount(mask);
      }
    }
  }
  return found;
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
  const int n = (int) sorted.size() - 8, nlocal = atom->nlocal, rows = (int) (cell_start.size() - 1) / row - 1;
  const bool upright = row > FLAT * rows;
  const int lines = upright ? row : rows, least = upright ? LEAST_COLUMNS : LEAST_ROWS;
  const int count = std::max(1, std::min(most, lines / least));
  place.resize(disc.size());
  home.resize(disc.size());
  std::vector<int> line_of(disc.size());
  for (int y = 0, c = 0; y < rows; y++)
    for (int x = 0; x < row; x++, c++)
      for (int s = cell_start[c + 1]; s < cell_start[c + 2]; s++) {
        line_of[sorted[s]] = upright ? x : y;
        place[sorted[s]] = s;
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
