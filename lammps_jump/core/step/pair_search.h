// SPDX-License-Identifier: GPL-2.0-or-later
/* Pairs of discs that are close, found by cells: the lists of the native engine and of the plugin.

   Discs are sorted by cell, so that the candidates of a disc are two stretches of memory. A partition shares the work among its threads;
   the result is the same for any number of them. */

#ifndef JUMP_CORE_PAIR_SEARCH_H
#define JUMP_CORE_PAIR_SEARCH_H

#include "contact/simd.h"

#include "walls/faces.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

namespace jump {

constexpr double CELLS_A_DISC = 16.0;    // cells at most, over the number of discs
constexpr double CELLS_A_SIDE = 1e6;       // along one side
constexpr int64_t MOST_MOVED = 16;       // steps of a disc in its column, in the mean, up to which they are done one by one

/** A list does not fit its room. */
enum : int64_t { NO_ROOM = -2 };

/** Places of discs, and their radii where they have their own (else NULL). */
struct SearchedDiscs {
  int64_t n;
  const double *x, *y, *radius;
};

/** Room for what a search makes on its way. */
struct SearchRoom {
  std::vector<int32_t> cells, columns;          // of each disc
  std::vector<int64_t> ends;                    // of columns
  std::vector<uint64_t> sorted;                 // cells of discs in their order, and where these were
  std::vector<std::vector<int32_t>> rows;       // of the list, those of each thread
};

/** A sorted disc: its cell, and where it was before, in half a word each. */
inline int64_t cell_of(uint64_t disc) { return (int64_t) (disc >> 32); }
inline size_t was_at(uint64_t disc) { return (size_t) (uint32_t) disc; }

/** Smallest box around discs. */
struct BoxOfPlaces {
  double xlo, xhi, ylo, yhi;
};

/** The cells that discs are sorted by. A frame of empty ones surrounds them, rows counted fastest. */
struct SearchCells {
  double x_low, y_low, inverse;
  int64_t columns, rows;
  bool turned;    // x runs along the rows

  /** A few discs far apart get wider cells, so that cells never outnumber discs by much. */
  SearchCells(const BoxOfPlaces &box, double reach, int64_t n) : x_low(box.xlo), y_low(box.ylo)
  {
    const double wide = box.xhi - box.xlo, high = box.yhi - box.ylo;
    const double sparse = std::sqrt(wide * high / most(CELLS_A_DISC * (double) n, 4096.0));
    inverse = 1.0 / most(most(reach, sparse), most(wide / CELLS_A_SIDE, high / CELLS_A_SIDE));
    columns = (int64_t) (wide * inverse) + 1;
    rows = (int64_t) (high * inverse) + 1;
    turned = rows > columns;
    if (turned) std::swap(columns, rows);
  }

  /** With x along the rows, whatever the shape of the flow. */
  static SearchCells along_x(const BoxOfPlaces &box, double reach, int64_t n)
  {
    SearchCells cells(box, reach, n);
    if (!cells.turned) std::swap(cells.columns, cells.rows);
    cells.turned = true;
    return cells;
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

/** Sorted discs go by their numbers. */
struct OwnNumbers {
  int32_t one(int64_t j) const { return (int32_t) j; }
  FourInts four_of(int64_t j) const { return FourInts{one(j), one(j + 1), one(j + 2), one(j + 3)}; }
};

/** … or by those that an array has. */
struct NumbersOf {
  const int32_t *of;

  int32_t one(int64_t j) const { return of[j]; }
  FourInts four_of(int64_t j) const { return four(of + j); }
};

/** Rows of a list for a stretch of the sorted discs. */
template <class Numbers> class RowsOf {
 public:
  const SearchedDiscs s;
  int64_t *const start;

  RowsOf(const SearchedDiscs &discs, const Numbers &numbers, const SearchRoom &work, double reach, int64_t height, int64_t *start)
      : s(discs), start(start), numbers(numbers), work(work), reach(reach), height(height)
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
      start[i + 1] = count;
    }
    return count;
  }

 private:
  const Numbers numbers;
  const SearchRoom &work;
  double reach;    // of centres; of surfaces where discs have radii of their own
  int64_t height;

  int64_t cell(int64_t i) const { return cell_of(work.sorted[(size_t) i]); }

  /** First disc from `from` on in this cell or after it. */
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
      *reinterpret_cast<FourInts *>(list + count) = first_of(numbers.four_of(j), mask);
      count += __builtin_popcount((unsigned) mask);
    }
    for (; j < to; j++) {
      const double dx = px - s.x[j], dy = py - s.y[j], apart = s.radius ? far + s.radius[j] : far;
      list[count] = numbers.one(j);
      count += dx * dx + dy * dy < apart * apart;
    }
  }
};

/** Sort the discs of a column by cell, and those of a cell by their place before. Few have changed their cells. */
inline void sort_column(uint64_t *from, uint64_t *to)
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

/** Cells of the discs in their order, and where each disc was. SCATTERED: discs are not as good as sorted before. */
template <bool SCATTERED, class Partition> void sort_discs(const SearchedDiscs &s, const SearchCells &cells, SearchRoom &work, Partition &partition)
{
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
  const std::vector<int32_t> &keys = SCATTERED ? work.cells : work.columns;
  const int64_t most_key = SCATTERED ? (cells.columns + 1) * cells.height() : cells.columns;
  work.ends.assign((size_t) most_key + 2, 0);
  int64_t *const ends = work.ends.data();
  for (int64_t i = 0; i < s.n; i++) ends[keys[(size_t) i] + 1]++;
  for (int64_t c = 0; c <= most_key; c++) ends[c + 1] += ends[c];
  for (int64_t i = 0; i < s.n; i++)    // ends[c] runs from the first disc of column or cell c to the first of the next one
    work.sorted[(size_t) ends[keys[(size_t) i]]++] = (uint64_t) work.cells[(size_t) i] << 32 | (uint64_t) i;
  if constexpr (SCATTERED) return;
  uint64_t *const sorted = work.sorted.data();
  partition.stretches(cells.columns, [&](int, int64_t from, int64_t to) {
    for (int64_t c = from; c < to; c++) sort_column(sorted + ends[c], sorted + ends[c + 1]);
  });
}

/** List the rows of the sorted discs; false where there is no room. */
template <class Numbers, class Partition>
bool list_rows(const RowsOf<Numbers> &rows, int32_t *neighbours, int64_t room, SearchRoom &work, Partition &partition)
{
  const int count = partition.shares();
  const int64_t n = rows.s.n;
  int64_t *const start = rows.start;
  start[0] = 0;
  if (count == 1) return rows.list(0, n, neighbours, room) >= 0;
  std::vector<std::vector<int32_t>> &own = work.rows;
  std::vector<int64_t> length((size_t) count), before((size_t) count + 1);
  own.resize((size_t) count);
  partition.stretches(n, [&](int k, int64_t from, int64_t to) {
    own[(size_t) k].resize((size_t) (2 * room / count + 64));
    length[(size_t) k] = rows.list(from, to, own[(size_t) k].data(), (int64_t) own[(size_t) k].size());
  });
  for (int k = 0; k < count; k++) {
    if (length[(size_t) k] < 0) return false;
    before[(size_t) k + 1] = before[(size_t) k] + length[(size_t) k];
  }
  if (before.back() > room) return false;
  partition.stretches(n, [&](int k, int64_t from, int64_t to) {
    std::copy_n(own[(size_t) k].data(), length[(size_t) k], neighbours + before[(size_t) k]);
    for (int64_t i = from; i < to; i++) start[i + 1] += before[(size_t) k];
  });
  return true;
}

}    // namespace jump

#endif
