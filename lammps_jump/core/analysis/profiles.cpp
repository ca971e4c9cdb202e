// SPDX-License-Identifier: GPL-2.0-or-later
// Sums of discs in bins along the channel, and the free surface; sums of discs and of contacts in layers over the height.

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "api.h"

namespace jump {
namespace {

constexpr double PI = 3.14159265358979323846;

// Share of a unit disc's area left of x = a, exact: 1/2 + (a sqrt(1 - a^2) + asin a) / pi.
double circular_segment_area(double a)
{
  if (a <= -1.0) return 0.0;
  if (a >= 1.0) return 1.0;
  return 0.5 + (a * std::sqrt(1.0 - a * a) + std::asin(a)) / PI;
}

// Integral of circular_segment_area up to a, exact.
double circular_segment_area_integral(double a)
{
  if (a <= -1.0) return 0.0;
  if (a >= 1.0) return a;
  const double height = std::sqrt(1.0 - a * a);
  return 0.5 * a + (height * (1.0 - height * height / 3.0) + a * std::asin(a)) / PI;
}

// Share left of an edge of a disc of radius r whose centre is anywhere from begin to end with the same chance.
double spread_segment_area(double edge, double begin, double end, double r)
{
  const double half = 0.5 * (end - begin) / r, middle = (edge - 0.5 * (begin + end)) / r;
  // a way that is shorter changes the share by less than 1e-9, and rounding would change it more
  if (half < 1e-4) return circular_segment_area(middle);
  if (middle <= -1.0 - half) return 0.0;
  if (middle >= 1.0 + half) return 1.0;
  return (circular_segment_area_integral(middle + half) - circular_segment_area_integral(middle - half)) / (2.0 * half);
}

}    // namespace
}    // namespace jump

#define JUMP_BIN_FRAME(FIELD) \
  FIELD(int64_t, n) FIELD(const double *, start) FIELD(const double *, stop) FIELD(const double *, weight) \
  FIELD(const double *, y) FIELD(const double *, vx) FIELD(const double *, vy) FIELD(const double *, radius) \
  FIELD(const double *, mass) FIELD(double, begin) FIELD(double, end) FIELD(double, low) FIELD(double, width) \
  FIELD(int64_t, bins) FIELD(double *, sums) FIELD(double *, beyond)
JUMP_INPUT(jump_bin_frame, JUMP_BIN_FRAME)

// Adds discs to sums[quantity * bins + bin], and the mass beyond the bins to beyond (left, right), in shares of area.
// Quantities: mass; sum of u, of u^2, of u |v|^2 / 2 and of y, each times the mass; number.
// The centre of a disc is anywhere from start to stop, and the disc counts with its weight. There are no discs before
// `begin` and after `end`, to fill what those between them leave free there: what sticks out is folded back.
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

#define JUMP_TOP_DISCS(FIELD) \
  FIELD(int64_t, n) FIELD(const double *, x) FIELD(const double *, y) FIELD(const double *, radius) \
  FIELD(const uint8_t *, joined) FIELD(double, low) FIELD(double, spacing) FIELD(int64_t, lines) FIELD(int64_t *, top)
JUMP_INPUT(jump_top_discs, JUMP_TOP_DISCS)

// The disc with the highest top edge at each of `lines` vertical lines, -1 where none cuts it; line k is at
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

namespace {

// Rows of the sums, as in grains/layers.py.
enum { AREA, MASS, U, V, Y, UU, VV, UV, UY, VY, YY, FXX, FXY, FYX, FYY };

// Begin and end of the stretch, lowest edge and height of a layer.
struct Where {
  double begin, end, low, height;

  // Layers from one height to another.
  int64_t first(double y) const { return std::max<int64_t>(static_cast<int64_t>(std::floor((y - low) / height)), 0); }
  int64_t last(double y, int64_t layers) const
  {
    return std::min<int64_t>(static_cast<int64_t>(std::floor((y - low) / height)), layers - 1);
  }
};

Where where_of(const double *numbers) { return {numbers[0], numbers[1], numbers[2], numbers[3]}; }

// What lies between two ends of a segment from `start`, `way` long, since and until which parts of it.
void cut(double start, double way, double least, double most, double &since, double &until)
{
  if (way == 0.0) {
    if (start < least || start >= most) until = -1.0;
    return;
  }
  const double one = (least - start) / way, other = (most - start) / way;
  since = std::max(since, std::min(one, other));
  until = std::min(until, std::max(one, other));
}

}    // namespace

#define JUMP_LAYERS_DISCS(FIELD) \
  FIELD(int64_t, n) FIELD(const double *, x) FIELD(const double *, y) FIELD(const double *, u) FIELD(const double *, v) \
  FIELD(const double *, radius) FIELD(const double *, mass) FIELD(const double *, numbers) FIELD(int64_t, layers) \
  FIELD(double *, sums)
JUMP_INPUT(jump_layers_discs, JUMP_LAYERS_DISCS)

// Adds discs; at the ends of the stretch the share in x times that in y replaces the share of the area in both.
JUMP_API void jump_layers_discs(const jump_layers_discs_input *input)
{
  JUMP_LAYERS_DISCS(JUMP_LOCAL)
  const Where where = where_of(numbers);
  const auto below = [](double place, double r, double edge) { return jump::circular_segment_area((edge - place) / r); };
  for (int64_t i = 0; i < n; i++) {
    const double r = radius[i], across = below(x[i], r, where.end) - below(x[i], r, where.begin);
    if (across <= 0.0) continue;
    for (int64_t k = where.first(y[i] - r); k <= where.last(y[i] + r, layers); k++) {
      const double edge = where.low + static_cast<double>(k) * where.height;
      const double part = across * (below(y[i], r, edge + where.height) - below(y[i], r, edge)), m = part * mass[i];
      double *const sum = sums + k;
      sum[AREA * layers] += part * jump::PI * r * r;
      sum[MASS * layers] += m;
      sum[U * layers] += m * u[i];
      sum[V * layers] += m * v[i];
      sum[Y * layers] += m * y[i];
      sum[UU * layers] += m * u[i] * u[i];
      sum[VV * layers] += m * v[i] * v[i];
      sum[UV * layers] += m * u[i] * v[i];
      sum[UY * layers] += m * u[i] * y[i];
      sum[VY * layers] += m * v[i] * y[i];
      sum[YY * layers] += m * y[i] * y[i];
    }
  }
}

#define JUMP_LAYERS_CONTACTS(FIELD) \
  FIELD(int64_t, n) FIELD(const double *, x) FIELD(const double *, y) FIELD(int64_t, count) FIELD(const int64_t *, first) \
  FIELD(const int64_t *, second) FIELD(const double *, contact) FIELD(const double *, numbers) FIELD(int64_t, layers) \
  FIELD(double *, sums)
JUMP_INPUT(jump_layers_contacts, JUMP_LAYERS_CONTACTS)

// Adds force times branch of each contact with the part of the branch in each layer; contact[c] holds the normal towards
// the second disc, the distance of the wall's surface from its centre, and the force on it.
JUMP_API void jump_layers_contacts(const jump_layers_contacts_input *input)
{
  JUMP_LAYERS_CONTACTS(JUMP_LOCAL)
  const Where where = where_of(numbers);
  for (int64_t c = 0; c < count; c++) {
    const double *const found = contact + 5 * c, fx = found[3], fy = found[4];
    const int64_t j = second[c];
    const bool pair = first[c] < n;
    const double x0 = pair ? x[first[c]] : x[j] - found[2] * found[0];
    const double y0 = pair ? y[first[c]] : y[j] - found[2] * found[1];
    const double dx = x[j] - x0, dy = y[j] - y0;
    const int64_t last = where.last(std::max(y0, y[j]), layers);
    for (int64_t k = where.first(std::min(y0, y[j])); k <= last; k++) {
      const double edge = where.low + static_cast<double>(k) * where.height;
      double since = 0.0, until = 1.0;
      cut(x0, dx, where.begin, where.end, since, until);
      cut(y0, dy, edge, edge + where.height, since, until);
      const double part = std::max(until - since, 0.0);
      double *const sum = sums + k;
      sum[FXX * layers] += part * fx * dx;
      sum[FXY * layers] += part * fx * dy;
      sum[FYX * layers] += part * fy * dx;
      sum[FYY * layers] += part * fy * dy;
    }
  }
}
