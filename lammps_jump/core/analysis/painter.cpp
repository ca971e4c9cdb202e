// SPDX-License-Identifier: GPL-2.0-or-later

#include <algorithm>
#include <cmath>

#include "api.h"

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
