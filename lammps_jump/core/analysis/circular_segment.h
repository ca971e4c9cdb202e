// SPDX-License-Identifier: GPL-2.0-or-later

#ifndef JUMP_CORE_CIRCULAR_SEGMENT_H
#define JUMP_CORE_CIRCULAR_SEGMENT_H

#include <cmath>

namespace jump {

// Share of a unit disc's area left of x = a, exact: 1/2 + (a sqrt(1 - a^2) + asin a) / pi.
inline double circular_segment_area(double a)
{
  if (a <= -1.0) return 0.0;
  if (a >= 1.0) return 1.0;
  return 0.5 + (a * std::sqrt(1.0 - a * a) + std::asin(a)) / 3.14159265358979323846;
}

}    // namespace jump

#endif
