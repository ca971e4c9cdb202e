// SPDX-License-Identifier: GPL-2.0-or-later
// Lists of the native engine made anew, shared among threads: the lists are the same for any number of them.

#include "contact/simd.h"    // before the core: its templates take vectors

#include "step/relist.h"
#include "walls/wall.h"

#include <algorithm>

namespace jump {

namespace {

constexpr double CELLS_A_DISC = 16.0;    // cells at most, over the number of discs
constexpr double MOST_CELLS = 1e6;       // along one side
constexpr int64_t MOST_MOVED = 16;       // steps of a disc in its column, in the mean, up to which they are done one by one

/** A sorted disc: its cell, and where it was before, in half a word each. */
int64_t cell_of(uint64_t disc) { return (int64_t) (disc >> 32); }
size_t was_at(uint64_t disc) { return (size_t) (uint32_t) disc; }

/** Smallest box around discs, and the last of those outside the domain, or -1. */
struct BoxOfDiscs {
  double xlo, xhi, ylo, yhi;
  int64_t lost = -1;

  explicit BoxOfDiscs(const jump_lists &l) : xlo(l.xhi), xhi(l.xlo), ylo(l.yhi), yhi(l.ylo) {}

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

/** The cells that discs are sorted by. A frame of empty ones surrounds them, rows counted fastest. */
struct SearchCells {
  double x_low, y_low, inverse;
  int64_t columns, rows;
  bool turned;    // x runs along the rows

  /** A few discs far apart get wider cells, so that cells never outnumber discs by much. */
  SearchCells(const BoxOfDiscs &box, double reach, int64_t n) : x_low(box.xlo), y_low(box.ylo)
  {
    const double wide = box.xhi - box.xlo, high = box.yhi - box.ylo;
    const double sparse = std::sqrt(wide * high / most(CELLS_A_DISC * (double) n, 4096.0));
    inverse = 1.0 / most(most(reach, sparse), most(wide / MOST_CELLS, high / MOST_CELLS));
    columns = (int64_t) (wide * inverse) + 1;
    rows = (int64_t) (high * inverse) + 1;
    turned = rows > columns;
    if (turned) std::swap(columns, rows);
  }

  int64_t height() const { return rows + 2; }

  /** Column and cell of a disc. */
  std::pair<int64_t, int64_t> of(double x, double y) const
  {
    const int64_t cx = (int64_t) ((x - x_low) * inverse), cy = (int64_t) ((y - y_low) * inverse);
    const int64_t column = least(turned ? cy : cx, columns - 1) + 1;
    return {column, column * height() + least(turned ? cx : cy, rows - 1) + 1};
  }
};

/** Rows of a list for a stretch of the sorted discs. */
class RowsOf {
 public:
  RowsOf(const jump_state &s, const ListRoom &work, double reach, int64_t height) : s(s), work(work), reach(reach), height(height)
  {
  }

  /** List the discs `from` to `to`; start[i + 1] is where the row of disc i ends. Returns the length, or NO_ROOM. */
  int64_t list(int64_t from, int64_t to, int32_t *list, int64_t room) const
  {
    int64_t count = 0, last = from, low = from, high = from;
    if (from < to) low = high = first_from(from, cell(from) + height - 1);
    for (int64_t i = from; i < to; i++) {
      const int64_t own = cell(i);
      while (last < s.n && cell(last) <= own + 1) last++;
      while (low < s.n && cell(low) < own + height - 1) low++;
      high = most(low, high);
      while (high < s.n && cell(high) <= own + height + 1) high++;
      if (count + (last - i) + (high - low) + 4 > room) return NO_ROOM;
      const double far = s.radius ? reach + s.radius[i] : reach;
      add(s.x[i], s.y[i], far, i + 1, last, list, count);
      add(s.x[i], s.y[i], far, low, high, list, count);
      s.start[i + 1] = count;
    }
    return count;
  }

 private:
  const jump_state &s;
  const ListRoom &work;
  double reach;    // of centres; of surfaces where discs have radii of their own
  int64_t height;

  int64_t cell(int64_t i) const { return cell_of(work.sorted[(size_t) i]); }

  /** First disc from `from` on in this cell or behind it. */
  int64_t first_from(int64_t from, int64_t wanted) const
  {
    const auto begin = work.sorted.begin();
    return std::lower_bound(begin + from, begin + s.n, (uint64_t) wanted << 32) - begin;
  }

  /** Put those of a stretch of discs that are close into the list; without a branch, which would be guessed wrong often. */
  void add(double px, double py, double far, int64_t from, int64_t to, int32_t *list, int64_t &count) const
  {
    int64_t j = from;
    for (; HAS_FOUR && j < to && j + 4 <= s.n; j += 4) {
      const Four dx = px - four(s.x + j), dy = py - four(s.y + j);
      const Four apart = s.radius ? far + four(s.radius + j) : far - Four{};
      const int mask = bits(dx * dx + dy * dy < apart * apart) & (to - j < 4 ? (1 << (to - j)) - 1 : 15);
      const int32_t at = (int32_t) j;
      *reinterpret_cast<FourInts *>(list + count) = first_of(FourInts{at, at + 1, at + 2, at + 3}, mask);
      count += __builtin_popcount((unsigned) mask);
    }
    for (; j < to; j++) {
      const double dx = px - s.x[j], dy = py - s.y[j], apart = s.radius ? far + s.radius[j] : far;
      list[count] = (int32_t) j;
      count += dx * dx + dy * dy < apart * apart;
    }
  }
};

/** Sort the discs of a column by cell, and those of a cell by their place before. Few have changed their cells. */
void sort_column(uint64_t *from, uint64_t *to)
{
  int64_t moved = 0;
  for (uint64_t *next = from; next < to && moved <= MOST_MOVED * (to - from); next++) {
    const uint64_t disc = *next;
    uint64_t *at = next;
    for (; at > from && at[-1] > disc; at--) *at = at[-1];
    *at = disc;
    moved += next - at;
  }
  if (moved > MOST_MOVED * (to - from)) std::sort(from, to);
}

/** Cells of the discs in their order, and where each disc was. */
void sort_discs(const jump_state &s, const SearchCells &cells, ThreadPartition &partition)
{
  ListRoom &work = partition.lists;
  work.cells.resize((size_t) s.n);
  work.columns.resize((size_t) s.n);
  work.sorted.resize((size_t) s.n);
  partition.stretches(s.n, [&](int, int64_t from, int64_t to) {
    for (int64_t i = from; i < to; i++) {
      const auto [column, cell] = cells.of(s.x[i], s.y[i]);
      work.columns[(size_t) i] = (int32_t) column;
      work.cells[(size_t) i] = (int32_t) cell;
    }
  });
  work.ends.assign((size_t) cells.columns + 2, 0);
  int64_t *const ends = work.ends.data();
  for (int64_t i = 0; i < s.n; i++) ends[work.columns[(size_t) i] + 1]++;
  for (int64_t c = 0; c <= cells.columns; c++) ends[c + 1] += ends[c];
  for (int64_t i = 0; i < s.n; i++)    // ends[c] runs from the first disc of column c to the first of the next one
    work.sorted[(size_t) ends[work.columns[(size_t) i]]++] = (uint64_t) work.cells[(size_t) i] << 32 | (uint64_t) i;
  uint64_t *const sorted = work.sorted.data();
  partition.stretches(cells.columns, [&](int, int64_t from, int64_t to) {
    for (int64_t c = from; c < to; c++) sort_column(sorted + ends[c], sorted + ends[c + 1]);
  });
}

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

/** List the rows of the sorted discs; false where there is no room. */
bool list_rows(jump_state &s, const RowsOf &rows, ThreadPartition &partition)
{
  const int count = partition.shares();
  s.start[0] = 0;
  if (count == 1) return rows.list(0, s.n, s.neighbours, s.room) >= 0;
  std::vector<std::vector<int32_t>> &own = partition.lists.rows;
  std::vector<int64_t> length((size_t) count), before((size_t) count + 1);
  own.resize((size_t) count);
  partition.stretches(s.n, [&](int k, int64_t from, int64_t to) {
    own[(size_t) k].resize((size_t) (2 * s.room / count + 64));
    length[(size_t) k] = rows.list(from, to, own[(size_t) k].data(), (int64_t) own[(size_t) k].size());
  });
  for (int k = 0; k < count; k++) {
    if (length[(size_t) k] < 0) return false;
    before[(size_t) k + 1] = before[(size_t) k] + length[(size_t) k];
  }
  if (before.back() > s.room) return false;
  partition.stretches(s.n, [&](int k, int64_t from, int64_t to) {
    std::copy_n(own[(size_t) k].data(), length[(size_t) k], s.neighbours + before[(size_t) k]);
    for (int64_t i = from; i < to; i++) s.start[i + 1] += before[(size_t) k];
  });
  return true;
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
  sort_discs(s, cells, partition);
  move_discs(s, l, partition);
  return list_rows(s, RowsOf(s, partition.lists, s.radius ? l.skin : reach, cells.height()), partition) ? LISTED : NO_ROOM;
}

}    // namespace jump
