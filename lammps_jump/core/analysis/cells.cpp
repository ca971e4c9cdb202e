// SPDX-License-Identifier: GPL-2.0-or-later
// Points sorted into square cells, and what is searched there: pairs that are close, and discs that are connected to the bed.

#include <algorithm>
#include <cmath>
#include <vector>

#include "api.h"

namespace jump {
namespace {

// Cell = column * rows + row; cell c holds order[start[c]] to order[start[c + 1] - 1], in their own order.
struct PointCells {
  int64_t columns = 0, rows = 0;
  std::vector<int64_t> home, start, order;

  // Points closer than `side` are in the same or in adjacent cells, which are coarser where strays would make too
  // many: sparse spray over a large box must not cost memory, so there are at most about 8 cells a point. n > 0.
  PointCells(int64_t n, const double *x, const double *y, double side) : home(n), order(n)
  {
    const double x0 = *std::min_element(x, x + n), y0 = *std::min_element(y, y + n);
    const double wide = *std::max_element(x, x + n) - x0, high = *std::max_element(y, y + n) - y0;
    const double least = std::sqrt((wide + side) * (high + side) / (8.0 * static_cast<double>(n) + 64.0));
    side = least > side ? least : side;
    columns = static_cast<int64_t>(wide / side) + 1;
    rows = static_cast<int64_t>(high / side) + 1;
    start.assign(columns * rows + 1, 0);
    for (int64_t i = 0; i < n; i++) {
      home[i] = static_cast<int64_t>((x[i] - x0) / side) * rows + static_cast<int64_t>((y[i] - y0) / side);
      start[home[i] + 1]++;
    }
    for (int64_t c = 0; c < columns * rows; c++) start[c + 1] += start[c];
    std::vector<int64_t> fill(start.begin(), start.end() - 1);
    for (int64_t i = 0; i < n; i++) order[fill[home[i]]++] = i;
  }
};

}    // namespace
}    // namespace jump

// Pairs of points closer than `reach`, each once; points at one place are no pair, as nothing says which way. Returns
// their number, of which what fits into `room` is written.
JUMP_API int64_t jump_close_pairs(int64_t n, const double *x, const double *y, double reach, int32_t *first,
                                  int32_t *second, int64_t room)
{
  if (n < 2) return 0;
  const jump::PointCells cells(n, x, y, reach);
  const double square = reach * reach;
  static const int ACROSS[] = {0, 0, 1, 1, 1}, UP[] = {0, 1, -1, 0, 1};    // itself and half of the eight around it
  int64_t count = 0;
  for (int64_t column = 0; column < cells.columns; column++)
    for (int64_t row = 0; row < cells.rows; row++) {
      const int64_t own = column * cells.rows + row;
      for (int64_t a = cells.start[own]; a < cells.start[own + 1]; a++) {
        const int64_t i = cells.order[a];
        for (int k = 0; k < 5; k++) {
          if (column + ACROSS[k] >= cells.columns || row + UP[k] < 0 || row + UP[k] >= cells.rows) continue;
          const int64_t other = (column + ACROSS[k]) * cells.rows + row + UP[k];
          for (int64_t b = k ? cells.start[other] : a + 1; b < cells.start[other + 1]; b++) {
            const int64_t j = cells.order[b];
            const double dx = x[j] - x[i], dy = y[j] - y[i], distance2 = dx * dx + dy * dy;
            if (distance2 >= square || distance2 == 0.0) continue;
            if (count < room) {
              first[count] = static_cast<int32_t>(i);
              second[count] = static_cast<int32_t>(j);
            }
            count++;
          }
        }
      }
    }
  return count;
}

// Whether each disc is connected to the bed: a chain of centres no further apart than `reach`, whose first has at most
// `air` of air above the bed under it (NaN: there is none). A search over cells in breadth.
JUMP_API void jump_connected(int64_t n, const double *x, const double *y, const double *radius, const double *bed,
                             double reach, double air, uint8_t *joined)
{
  if (n == 0) return;
  const jump::PointCells cells(n, x, y, reach);
  std::vector<int64_t> queue;
  queue.reserve(n);
  for (int64_t i = 0; i < n; i++) {
    const double above = y[i] - bed[i];
    joined[i] = -2.0 * radius[i] <= above && above <= radius[i] + air;
    if (joined[i]) queue.push_back(i);
  }
  const double limit = reach * reach * (1.0 + 1e-12);
  for (size_t head = 0; head < queue.size(); head++) {
    const int64_t i = queue[head], column = cells.home[i] / cells.rows, row = cells.home[i] % cells.rows;
    for (int64_t c = std::max<int64_t>(column - 1, 0); c < std::min(column + 2, cells.columns); c++)
      for (int64_t r = std::max<int64_t>(row - 1, 0); r < std::min(row + 2, cells.rows); r++) {
        const int64_t cell = c * cells.rows + r;
        for (int64_t m = cells.start[cell]; m < cells.start[cell + 1]; m++) {
          const int64_t j = cells.order[m];
          if (joined[j]) continue;
          const double dx = x[j] - x[i], dy = y[j] - y[i];
          if (dx * dx + dy * dy > limit) continue;
          joined[j] = 1;
          queue.push_back(j);
        }
      }
  }
}
