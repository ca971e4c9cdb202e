// SPDX-License-Identifier: GPL-2.0-or-later
/* A tailgate that holds a depth or a front: what it sees, and how fast it goes.

   lammps_jump/physics/devices.py (Holding, gate_sees, gate_speed) states the same; tests compare the two. */

#ifndef JUMP_CORE_TAILGATE_CONTROLLER_H
#define JUMP_CORE_TAILGATE_CONTROLLER_H

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace jump {

/** As Holding; `area`: what it saw last, m^2, NaN before its first look. */
struct TailgateController {
  int64_t first = 0, every = 0;    // every 0: the wall holds nothing
  double low = 0.0, high = 0.0;
  int64_t bins = 1;
  double target = 0.0, level = 0.0, proportional = 0.0, integral = 0.0, speed = 0.0, lowest = 0.0, highest = 0.0;
  double area = std::numeric_limits<double>::quiet_NaN();

  bool looks(int64_t step) const { return every > 0 && step >= first && (step - first) % every == 0; }

  /** Add a disc at x to its part of the stretch. */
  void add(std::vector<double> &areas, double x, double disc) const
  {
    const double part = std::floor((x - low) * ((double) bins / (high - low)));
    if (part >= 0.0 && part < (double) bins) areas[(size_t) part] += disc;
  }

  /** What it holds: the mean depth, or where the depth first comes to the level. */
  double seen(const std::vector<double> &areas, double total) const
  {
    const double width = (high - low) / (double) bins;
    if (level == 0.0) return total / (width * (double) bins);
    double before = 0.0;
    for (int64_t part = 0; part < bins; part++) {
      const double depth = areas[part] / width;
      if (depth >= level) {
        if (part == 0) return low;
        return low + width * ((double) part - 0.5 + (level - before) / (depth - before));
      }
      before = depth;
    }
    return high;
  }

  /** Speed up to the next look, of a gate at this place. */
  double look(const std::vector<double> &areas, double place, double dt)
  {
    double total = 0.0;
    for (const double part : areas) total += part;
    const double interval = (double) every * dt, lost = std::isnan(area) ? 0.0 : (area - total) / interval;
    area = total;
    const double now = seen(areas, total), off = level != 0.0 ? now - target : target - now;
    const double wanted = std::min(std::max(integral * off + proportional * lost, -speed), speed);
    return std::min(std::max(wanted, (lowest - place) / interval), (highest - place) / interval);
  }
};

}    // namespace jump

#endif
