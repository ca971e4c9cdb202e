// SPDX-License-Identifier: GPL-2.0-or-later
// Discs on grids: sums of their weights for fields, and pictures.

#include <algorithm>
#include <cmath>
#include <vector>

#include "api.h"

#define JUMP_SPREAD(FIELD) \
  FIELD(int64_t, n) FIELD(const double *, points) FIELD(const double *, weights) FIELD(int64_t, quantities) \
  FIELD(const double *, cell_weight) FIELD(int64_t, rows) FIELD(int64_t, columns) FIELD(double, low_x) FIELD(double, low_y) \
  FIELD(double, spacing) FIELD(double, reach) FIELD(double *, sums)
JUMP_INPUT(jump_spread, JUMP_SPREAD)

// Adds the weights of each point to sums[quantity, row, column], per area, over the open cells in reach; cell_weight is
// zero in walls, and the shares of a point add up to one. A point without an open cell in reach gives all to the cell
// that it lies in; one off the grid with nothing in reach gives nothing.
JUMP_API void jump_spread(const jump_spread_input *input)
{
  JUMP_SPREAD(JUMP_LOCAL)
  const double area = spacing * spacing;
  const auto bound = [](double value, int64_t least, int64_t most) {
    return static_cast<int64_t>(std::min(std::max(value, static_cast<double>(least)), static_cast<double>(most)));
  };
  std::vector<double> share;
  for (int64_t i = 0; i < n; i++) {
    const double px = points[2 * i], py = points[2 * i + 1];
    const int64_t c0 = bound(std::ceil((px - reach - low_x) / spacing - 0.5), 0, columns);
    const int64_t c1 = bound(std::floor((px + reach - low_x) / spacing - 0.5) + 1.0, c0, columns);
    const int64_t r0 = bound(std::ceil((py - reach - low_y) / spacing - 0.5), 0, rows);
    const int64_t r1 = bound(std::floor((py + reach - low_y) / spacing - 0.5) + 1.0, r0, rows);
    share.clear();
    double total = 0.0;
    for (int64_t r = r0; r < r1; r++)
      for (int64_t c = c0; c < c1; c++) {
        const double dx = low_x + (static_cast<double>(c) + 0.5) * spacing - px;
        const double dy = low_y + (static_cast<double>(r) + 0.5) * spacing - py;
        const double q = std::min(std::sqrt(dx * dx + dy * dy) / reach, 1.0), left = 1.0 - q;
        const double w = (1.0 + 3.0 * q) * (left * left * left) * cell_weight[r * columns + c];
        share.push_back(w);
        total += w;
      }
    const double c = std::floor((px - low_x) / spacing), r = std::floor((py - low_y) / spacing);
    const bool inside = c >= 0.0 && c < static_cast<double>(columns) && r >= 0.0 && r < static_cast<double>(rows);
    for (int64_t k = 0; k < quantities; k++) {
      double *const sum = sums + k * rows * columns;
      const double weight = weights[i * quantities + k];
      if (total > 0.0) {
        const double *part = share.data();
        for (int64_t row = r0; row < r1; row++)
          for (int64_t column = c0; column < c1; column++) sum[row * columns + column] += *part++ / total / area * weight;
      } else if (inside) {
        sum[static_cast<int64_t>(r) * columns + static_cast<int64_t>(c)] += weight / area;
      }
    }
  }
}

#define JUMP_PAINT_DISCS(FIELD) \
  FIELD(uint8_t *, picture) FIELD(int64_t, height) FIELD(int64_t, width) FIELD(int64_t, n) FIELD(const double *, column) \
  FIELD(const double *, row) FIELD(const double *, radius) FIELD(double, scale) FIELD(const uint8_t *, colours)
JUMP_INPUT(jump_paint_discs, JUMP_PAINT_DISCS)

// Paints discs as anti-aliased circles into picture[row, column, colour]; column and row are in pixels, radii times
// `scale` too. A disc below a pixel keeps its share of the pixel's ink.
JUMP_API void jump_paint_discs(const jump_paint_discs_input *input)
{
  JUMP_PAINT_DISCS(JUMP_LOCAL)
  for (int64_t i = 0; i < n; i++) {
    const double c = column[i], r = row[i];
    double rim = radius[i] * scale, ink = 1.0;
    if (rim < 0.5) {
      ink = (rim / 0.5) * (rim / 0.5);
      rim = 0.5;
    }
    const double around = rim + 1.0;
    if (!(-around <= c && c <= static_cast<double>(width) + around && -around <= r &&
          r <= static_cast<double>(height) + around))
      continue;
    const int64_t top = std::max<int64_t>(static_cast<int64_t>(std::floor(r - rim - 0.5)), 0);
    const int64_t bottom = std::min<int64_t>(static_cast<int64_t>(std::ceil(r + rim + 0.5)), height);
    const int64_t left = std::max<int64_t>(static_cast<int64_t>(std::floor(c - rim - 0.5)), 0);
    const int64_t right = std::min<int64_t>(static_cast<int64_t>(std::ceil(c + rim + 0.5)), width);
    for (int64_t py = top; py < bottom; py++)
      for (int64_t px = left; px < right; px++) {
        const double dy = static_cast<double>(py) + 0.5 - r, dx = static_cast<double>(px) + 0.5 - c;
        double cover = rim + 0.5 - std::sqrt(dx * dx + dy * dy);
        if (cover <= 0.0) continue;
        cover = cover >= 1.0 ? ink : cover * ink;
        uint8_t *const pixel = picture + (py * width + px) * 3;
        for (int k = 0; k < 3; k++)
          pixel[k] = static_cast<uint8_t>(pixel[k] + cover * (static_cast<double>(colours[3 * i + k]) - pixel[k]) + 0.5);
      }
  }
}
