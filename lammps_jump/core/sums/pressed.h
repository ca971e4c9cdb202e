// SPDX-License-Identifier: GPL-2.0-or-later
/* Forces of discs on stretches of outlines, summed over steps: pressure along a face. engines/twin/loops.py states the same. */

#ifndef JUMP_CORE_PRESSED_H
#define JUMP_CORE_PRESSED_H

#include "walls/faces.h"

#include <cstdint>

extern "C" {

/** Stretches of walls: those of a wall are first[wall] .. first[wall + 1); ends along its outline, m; sums of the force on it
    across and along (N/m) and of the first times the place (N). */
struct jump_pressed {
  int64_t stretches;
  const int64_t *first;
  const double (*ends)[2];
  double (*sums)[3];
};
}

namespace jump {

/** The force of one contact on a wall: across it, along its outline, and where, m. */
struct Press {
  int64_t wall;
  double across, along, place;
};

/** The press of a disc at (px, py) in the wall's own frame, on which the wall acts with (fx, fy) and the normal (nx, ny). */
inline Press press_of(int64_t wall, const Face &face, double px, double py, double nx, double ny, double fx, double fy)
{
  return {wall, fx * nx + fy * ny, fy * nx - fx * ny, foot_of(face, px, py)};
}

inline void add_press(const jump_pressed &to, const Press &press)
{
  for (int64_t k = to.first[press.wall]; k < to.first[press.wall + 1]; k++) {
    if (press.place < to.ends[k][0] || press.place >= to.ends[k][1]) continue;
    to.sums[k][0] += press.across;
    to.sums[k][1] += press.along;
    to.sums[k][2] += press.across * press.place;
  }
}

}    // namespace jump

#endif
