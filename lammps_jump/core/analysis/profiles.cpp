// SPDX-License-Identifier: GPL-2.0-or-later
// Sums of discs in bins along the channel, and the free surface.

#include <cmath>
#include <limits>
#include <vector>

#include "api.h"
#include "analysis/cells.h"
#include "analysis/circular_segment.h"

#define JUMP_BIN_FRAME(FIELD) \
  FIELD(int64_t, n) FIELD(const double *, start) FIELD(const double *, stop) FIELD(const double *, weight) \
  FIELD(const double *, y) FIELD(const double *, vx) FIELD(const double *, vy) FIELD(const double *, radius) \
  FIELD(const double *, mass) FIELD(double, begin) FIELD(double, end) FIELD(double, low) FIELD(double, width) \
  FIELD(int64_t, bins) FIELD(double *, sums) FIELD(double *, beyond)
JUMP_INPUT(jump_bin_frame, JUMP_BIN_FRAME)

// Adds discs to sums[quantity * bins + bin], and the mass beyond the bins to beyond (left, right), in shares of area.
// Quantities: mass; sum of u, of u^2, of u |v|^2 / 2 and of y, each times the mass; number.
// The centre of a disc is anywhere from start to stop, and the disc counts with its weight. There are no discs before
// `begin` and behind `end`, to fill what those between them leave free there: what sticks out is folded back.
JUMP_API void jump_bin_frame(const jump_bin_frame_input *input)
{
  JUMP_BIN_FRAME(JUMP_LOCAL)
  for (int64_t i = 0; i < n; i++) {
    const double r = radius[i], from = start[i], to = stop[i], m = weight[i] * mass[i], left = (from - r - low) / width;
    if (left >= static_cast<double>(bins)) {
      beyond[1] += m;
      continue;
    }
    if ((to + r - low) / width <= 0.0) {
      beyond[0] += m;
      continue;
    }
    const auto share_left_of = [=](double edge) {
      double share = jump::spread_segment_area(edge, from, to, r);
      if (from - r < begin) share += jump::spread_segment_area(edge, 2.0 * begin - to, 2.0 * begin - from, r) - 1.0;
      if (to + r > end) share += jump::spread_segment_area(edge, 2.0 * end - to, 2.0 * end - from, r);
      return share;
    };
    const double u = vx[i], kinetic = 0.5 * (u * u + vy[i] * vy[i]);
    double done = 0.0;
    // all that is outside the range is one bin on either side
    for (int64_t k = left < 0.0 ? -1 : static_cast<int64_t>(left); done < 1.0; k++) {
      const double edge = low + static_cast<double>(k + 1) * width;
      const double upto = k >= bins ? 1.0 : share_left_of(edge);
      const double share = upto - done, part = share * m;
      done = upto;
      if (k < 0) {
        beyond[0] += part;
      } else if (k >= bins) {
        beyond[1] += part;
      } else {
        double *const sum = sums + k;
        sum[0] += part;
        sum[bins] += part * u;
        sum[2 * bins] += part * u * u;
        sum[3 * bins] += part * u * kinetic;
        sum[4 * bins] += part * y[i];
        sum[5 * bins] += share * weight[i];
      }
    }
  }
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

#define JUMP_TOP_DISCS(FIELD) \
  FIELD(int64_t, n) FIELD(const double *, x) FIELD(const double *, y) FIELD(const double *, radius) \
  FIELD(const uint8_t *, joined) FIELD(double, low) FIELD(double, spacing) FIELD(int64_t, lines) FIELD(int64_t *, top)
JUMP_INPUT(jump_top_discs, JUMP_TOP_DISCS)

// The disc with the highest top edge at each of `lines` vertical lines, -1 where none cuts it; line k stands at
// low + (k + 1/2) spacing. Discs count that are joined.
JUMP_API void jump_top_discs(const jump_top_discs_input *input)
{
  JUMP_TOP_DISCS(JUMP_LOCAL)
  std::vector<double> height(lines, -std::numeric_limits<double>::infinity()), size(lines, 0.0);
  std::fill(top, top + lines, -1);
  for (int64_t i = 0; i < n; i++) {
    if (!joined[i]) continue;
    const double r = radius[i];
    const double begin = std::ceil((x[i] - r - low) / spacing - 0.5), end = std::floor((x[i] + r - low) / spacing - 0.5);
    if (begin >= static_cast<double>(lines) || end < 0.0) continue;
    const int64_t last = std::min(static_cast<int64_t>(end), lines - 1);
    for (int64_t k = std::max<int64_t>(static_cast<int64_t>(begin), 0); k <= last; k++)
      if (y[i] - height[k] > size[k] - r) {    // the higher top edge, without rounding where discs are equal
        top[k] = i;
        height[k] = y[i];
        size[k] = r;
      }
  }
}
