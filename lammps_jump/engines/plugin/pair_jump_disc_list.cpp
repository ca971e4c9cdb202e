// SPDX-License-Identifier: GPL-2.0-or-later
/* The neighbour list of pair_style jump/disc (what it is: pair_jump_disc.h). */

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

/** All pairs whose rims are closer than the skin, from the packed positions.

    Cells are as wide as that distance and numbered along x first, as LAMMPS sorts its discs: pairs that follow each
    other then lie close in memory. What a disc can meet and that comes after it lies in two runs of the sorted discs,
    its own cell with the one beside, and the three cells above. */
void PairJumpDisc::build_list()
{
  const int nlocal = atom->nlocal;
  const int n = nlocal + ring.count();
  candidates = interior = built = 0;
  parted = false;
  for (int c = 0; c < 2; c++) moved[c] = moved_here[c] = 0.0;
  first_across.clear();
  second_across.clear();
  check_discs(0, nlocal);
  remember_order();
  if (n == 0) return;

  const double cut = largest + skin;
  double xlo = disc[0].x, xhi = xlo, ylo = disc[0].y, yhi = ylo;
  for (int i = 0; i < n; i++) {
    if (!std::isfinite(disc[i].x) || !std::isfinite(disc[i].y))
      error->one(FLERR, "jump/disc: the position of {} {} is not a number: the run has blown up",
                 i < nlocal ? "disc" : "a disc of another rank beside disc", i < nlocal ? atom->tag[i] : nlocal > 0 ? atom->tag[0] : 0);
    xlo = std::min(xlo, disc[i].x);
    xhi = std::max(xhi, disc[i].x);
    ylo = std::min(ylo, disc[i].y);
    yhi = std::max(yhi, disc[i].y);
  }
  if (!(xhi - xlo < 1e9 * cut) || !(yhi - ylo < 1e9 * cut))
    error->one(FLERR, "jump/disc: discs are spread over {} m by {} m: the run has blown up",
               xhi - xlo, yhi - ylo);
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
  const int count = n < 64 * team.size() ? 1 : team.size();
  if (count == 1) return find(0, n, first, second);
  found_first.resize(count);
  found_second.resize(count);
  std::vector<size_t> begin(count + 1, 0);
  team.run(count, [&](int part) {
    const int from = (int) ((int64_t) n * part / count), to = (int) ((int64_t) n * (part + 1) / count);
    begin[part + 1] = find(from, to, found_first[part], found_second[part]);
  });
  for (int part = 0; part < count; part++) begin[part + 1] += begin[part];
  make_room(begin[count] + 4, first, second);
  team.run(count, [&](int part) {
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

/** Divide the pairs that were found together into parts of the same length, for the threads.

    The discs of a part and of those before it end in the row of cells above its last pair: the next part leaves the sums
    on these to the end of the step. */
void PairJumpDisc::divide(int count)
{
  if (parted && (int) parts.size() == count) return;
  parted = true;
  parts.resize(count);
  place.resize(disc.size());
  const int n = (int) sorted.size() - 8;
  in_parts(n, [&](int from, int to, int) {
    for (int s = from; s < to; s++) place[sorted[s]] = s;
  });
  const auto pair_of = [&](int s) {    // the first pair of the discs from place s on
    return std::partition_point(first.begin(), first.begin() + built, [&](int i) { return place[i] < s; }) - first.begin();
  };
  int taken = 0;
  for (int c = 0; c < count; c++) {
    Part &part = parts[c];
    part.begin = c == 0 ? 0 : parts[c - 1].end;
    part.own_end = c + 1 == count ? n : place[first[built * (c + 1) / count]];
    part.end = c + 1 == count ? built : std::max<size_t>(pair_of(part.own_end), part.begin);
    part.taken = taken;
    part.border = std::clamp<size_t>(pair_of(taken), part.begin, part.end);
    if (part.end > part.begin) taken = std::max(taken, cell_start[cell_of[first[part.end - 1]] + row + 3]);
  }
}

/** New discs at the end, the others as they were: add the pairs of the new ones. */
void PairJumpDisc::append_to_list(int from)
{
  const int n = atom->nlocal;
  check_discs(from, n);
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
