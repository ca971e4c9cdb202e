// SPDX-License-Identifier: GPL-2.0-or-later
// Points sorted into square cells: what every search of neighbours in the analysis starts from.

#ifndef JUMP_CORE_CELLS_H
#define JUMP_CORE_CELLS_H

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace jump {

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

}    // namespace jump

#endif
