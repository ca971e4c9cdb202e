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

}    // namespace jump
