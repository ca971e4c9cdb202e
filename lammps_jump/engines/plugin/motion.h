// SPDX-License-Identifier: GPL-2.0-or-later
/* Where a wall is at a step, and how fast.

   lammps_jump/scene/tracks.py holds the same and states it; tests compare the two. */

#ifndef JUMP_MOTION_H
#define JUMP_MOTION_H

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace jump {

constexpr int TRACK_WORDS = 21;

/** Displacement (m) and turn (rad) of a wall from where the case has it, or their rates. */
struct Pose {
  double x = 0.0, y = 0.0, angle = 0.0;
};

/** A wall that discs push: a mass (kg/m) under a force (N/m), free along x and y or not, released at a time (s). */
struct Lid {
  double mass = 0.0, force[2] = {0.0, 0.0};
  bool free[2] = {false, false};
  double begin = 0.0;
  double place[2] = {0.0, 0.0}, speed[2] = {0.0, 0.0};    // m; of the half step, m/s
  double push[2] = {0.0, 0.0};                            // force of the discs of this step, all ranks, N/m
};

class Motion {
 public:
  bool moves = false, is_lid = false;
  double cx = 0.0, cy = 0.0;        // point of turning where the case has it
  long start = 0;                   // step of t = 0
  std::vector<std::array<double, TRACK_WORDS>> track;
  Lid lid;

  Pose now, listed, rate, centred;  // rate: over the step before; centred: over two, for power and work
  double c = 1.0, s = 0.0;          // of the angle now

  /** Put it where it is at a step. */
  void place(long step, double dt)
  {
    if (!moves) return;
    if (is_lid) {
      now = {lid.place[0], lid.place[1], 0.0};
      rate = {lid.speed[0], lid.speed[1], 0.0};
      return;
    }
    const double time = (double) (step - start) * dt;
    const Pose before = pose(time - dt), behind = pose(time + dt);
    now = pose(time);
    rate = {(now.x - before.x) / dt, (now.y - before.y) / dt, (now.angle - before.angle) / dt};
    centred = {0.5 * (behind.x - before.x) / dt, 0.5 * (behind.y - before.y) / dt,
               0.5 * (behind.angle - before.angle) / dt};
    c = std::cos(now.angle);
    s = std::sin(now.angle);
  }

  /** Kick and drift of a lid to a step, as of a disc; the first kick is half a step long. */
  void drift(long step, double dt)
  {
    if (!is_lid || !((double) (step - start) * dt > lid.begin)) return;
    const bool first = (double) (step - 1 - start) * dt <= lid.begin;
    for (int axis = 0; axis < 2; axis++) {
      if (!lid.free[axis]) continue;
      const double force = lid.push[axis] + lid.force[axis];
      lid.speed[axis] += (first ? 0.5 * dt : dt) * force / lid.mass;
      lid.place[axis] += dt * lid.speed[axis];
    }
  }

  /** Bound of the way of its faces since `listed`, none of which is further than `far` from the point of turning, m. */
  double travel(double far) const
  {
    const double dx = now.x - listed.x, dy = now.y - listed.y;
    return std::sqrt(dx * dx + dy * dy) + (now.angle == listed.angle ? 0.0 : far * std::fabs(now.angle - listed.angle));
  }

  /** A point as the frame has it in which the wall stands. */
  void inward(double &x, double &y) const
  {
    const double dx = x - cx - now.x, dy = y - cy - now.y;
    x = cx + c * dx + s * dy;
    y = cy - s * dx + c * dy;
  }

  /** A direction of that frame as it is. */
  void outward(double &x, double &y) const
  {
    const double dx = x;
    x = c * dx - s * y;
    y = s * dx + c * y;
  }

 private:
  Pose pose(double time) const
  {
    int row = -1;
    while (row + 1 < (int) track.size() && track[row + 1][0] <= time) row++;
    if (row < 0) return {};
    const auto &t = track[row];
    const double since = time - t[0];
    Pose found;
    for (int power = 4; power >= 0; power--) {
      found.x = found.x * since + t[1 + power];
      found.y = found.y * since + t[6 + power];
      found.angle = found.angle * since + t[11 + power];
    }
    if (t[19] != 0.0) {
      const double wave = std::sin(t[19] * since + t[20]);
      found.x += wave * t[16];
      found.y += wave * t[17];
      found.angle += wave * t[18];
    }
    return found;
  }
};

}    // namespace jump

#endif
