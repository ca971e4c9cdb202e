// SPDX-License-Identifier: GPL-2.0-or-later
// Lists of the native engine made anew, shared among threads: the lists are the same for any number of them.

#include "step/pair_search.h"    // before the core: its templates take vectors

#include "step/relist.h"
#include "walls/wall.h"

#include <algorithm>

namespace jump {

namespace {

/** Smallest box around discs, and the last of those outside the domain, or -1. */
struct BoxOfDiscs : BoxOfPlaces {
  int64_t lost = -1;

  explicit BoxOfDiscs(const jump_lists &l) : BoxOfPlaces{l.xhi, l.xlo, l.yhi, l.ylo} {}

  void see(const jump_state &s, const jump_lists &l, int64_t from, int64_t to)
  {
    for (int64_t i = from; i < to; i++) {
      const double px = s.x[i], py = s.y[i];
      if (!(px >= l.xlo && px <= l.xhi && py >= l.ylo && py <= l.yhi)) lost = i;
      xlo = least(px, xlo);
      xhi = most(px, xhi);
      ylo = least(py, ylo);
      yhi = most(py, yhi);
    }
  }

  void join(const BoxOfDiscs &other)
  {
    xlo = least(other.xlo, xlo);
    xhi = most(other.xhi, xhi);
    ylo = least(other.ylo, ylo);
    yhi = most(other.yhi, yhi);
    lost = most(other.lost, lost);
  }
};

/** Put a stretch of the sorted discs of an array, of `width` words of 8 bytes a disc, in its place, from a copy of all. */
void gather(const std::vector<uint64_t> &sorted, const int64_t *from, int64_t *to, int64_t width, int64_t begin, int64_t end)
{
  if (width == 1)
    for (int64_t i = begin; i < end; i++) to[i] = from[was_at(sorted[(size_t) i])];
  else
    for (int64_t i = begin; i < end; i++) std::copy_n(from + was_at(sorted[(size_t) i]) * width, width, to + i * width);
}

/** Sort all arrays of the discs. Each thread has a stretch of all of them, so that its discs stay in its cache. */
void move_discs(const jump_state &s, const jump_lists &l, ThreadPartition &partition)
{
  std::vector<std::vector<int64_t>> &copy = partition.lists.copy;
  copy.resize((size_t) l.columns);
  for (int64_t k = 0; k < l.columns; k++) copy[(size_t) k].resize((size_t) (s.n * l.width[k]));
  partition.stretches(s.n, [&](int, int64_t from, int64_t to) {
    for (int64_t k = 0; k < l.columns; k++)
      std::copy(l.column[k] + from * l.width[k], l.column[k] + to * l.width[k], copy[(size_t) k].data() + from * l.width[k]);
  });
  partition.stretches(s.n, [&](int, int64_t from, int64_t to) {
    for (int64_t k = 0; k < l.columns; k++)
      gather(partition.lists.sorted, copy[(size_t) k].data(), l.column[k], l.width[k], from, to);
    std::copy(s.x + from, s.x + to, s.x0 + from);
    std::copy(s.y + from, s.y + to, s.y0 + from);
  });
}

}    // namespace

int64_t list_pairs(jump_state &s, const jump_lists &l, ThreadPartition &partition)
{
  BoxOfDiscs box(l);
  std::vector<BoxOfDiscs> parts((size_t) partition.shares(), box);
  partition.stretches(s.n, [&](int k, int64_t from, int64_t to) { parts[(size_t) k].see(s, l, from, to); });
  for (const BoxOfDiscs &part : parts) box.join(part);
  if (box.lost >= 0) return box.lost;
  s.rows = s.sorted = s.n;
  s.listed_as = next_list();
  s.start[0] = 0;
  if (s.n == 0) return LISTED;
  const double reach = l.widest + l.skin;
  const SearchCells cells(box, reach, s.n);
  const SearchedDiscs discs{s.n, s.x, s.y, s.radius};
  sort_discs<false>(discs, cells, partition.lists, partition);
  move_discs(s, l, partition);
  const RowsOf rows(discs, OwnNumbers{}, partition.lists, s.radius ? l.skin : reach, cells.height(), s.start);
  return list_rows(rows, s.neighbours, s.room, partition.lists, partition) ? LISTED : NO_ROOM;
}

bool list_across(jump_state &s, const jump_lists &l, int64_t others, const double (*at)[4], Rooms &rooms)
{
  std::vector<int32_t> by_height((size_t) others);
  for (int64_t j = 0; j < others; j++) by_height[(size_t) j] = (int32_t) (s.n + j);
  std::sort(by_height.begin(), by_height.end(), [=](int32_t a, int32_t b) { return at[a][1] < at[b][1]; });
  double left = -HUGE_VAL, right = HUGE_VAL;    // of the others, those next to the discs of the state
  const double reach = l.widest + l.skin;
  double middle = 0.0;
  for (int64_t i = 0; i < s.n; i++) middle += at[i][0] / (double) s.n;
  for (int64_t j = s.n; j < s.n + others; j++)
    if (at[j][0] < middle) left = most(at[j][0], left);
    else right = least(at[j][0], right);
  rooms.owner.resize((size_t) (2 * s.n));
  for (int64_t i = 0; i < s.n; i++) rooms.owner[(size_t) i] = (int32_t) i;
  s.rows = s.sorted;
  int64_t count = s.start[s.sorted];
  for (int64_t i = 0; i < s.n; i++) {
    const double px = at[i][0], py = at[i][1];
    if (px > left + reach && px < right - reach) continue;
    const auto low = std::lower_bound(by_height.begin(), by_height.end(), py - reach, [=](int32_t j, double y) { return at[j][1] < y; });
    const int64_t before = count;
    for (auto j = low; j != by_height.end() && at[*j][1] < py + reach; j++) {
      const double dx = px - at[*j][0], dy = py - at[*j][1], apart = s.radius ? l.skin + s.radius[i] + s.radius[*j] : reach;
      if (!(dx * dx + dy * dy < apart * apart)) continue;
      if (count == s.room) return false;
      s.neighbours[count++] = *j;
    }
    if (count == before) continue;
    rooms.owner[(size_t) s.rows] = (int32_t) i;
    s.start[++s.rows] = count;
  }
  s.owner = rooms.owner.data();
  return true;
}

}    // namespace jump
