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

// Integral of circular_segment_area up to a, exact.
inline double circular_segment_area_integral(double a)
{
  if (a <= -1.0) return 0.0;
  if (a >= 1.0) return a;
  const double height = std::sqrt(1.0 - a * a);
  return 0.5 * a + (height * (1.0 - height * height / 3.0) + a * std::asin(a)) / 3.14159265358979323846;
}

// Share left of an edge of a disc of radius r whose centre is anywhere from begin to end with the same chance.
inline double spread_segment_area(double edge, double begin, double end, double r)
{
  const double half = 0.5 * (end - begin) / r, middle = (edge - 0.5 * (begin + end)) / r;
  // a way that is shorter changes the share by less than 1e-9, and rounding would change it more
  if (half < 1e-4) return circular_segment_area(middle);
  if (middle <= -1.0 - half) return 0.0;
  if (middle >= 1.0 + half) return 1.0;
  return (circular_segment_area_integral(middle + half) - circular_segment_area_integral(middle - half)) / (2.0 * half);
}

}    // namespace jump

#endif
