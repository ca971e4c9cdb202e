// SPDX-License-Identifier: GPL-2.0-or-later

#include "api.h"
#include "analysis/cells.h"

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
