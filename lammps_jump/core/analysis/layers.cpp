// SPDX-License-Identifier: GPL-2.0-or-later
// Sums of discs and of contacts in layers over the height, in a stretch of x.

#include <algorithm>
#include <cmath>

#include "api.h"
#include "analysis/circular_segment.h"

namespace {

// Rows of the sums, as in grains/layers.py.
enum { AREA, MASS, U, V, Y, UU, VV, UV, UY, VY, YY, FXX, FXY, FYX, FYY };

constexpr double PI = 3.14159265358979323846;

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

// Adds discs; at the ends of the stretch the share in x times that in y stands for the share of the area in both.
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
      sum[AREA * layers] += part * PI * r * r;
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
