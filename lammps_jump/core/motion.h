// SPDX-License-Identifier: GPL-2.0-or-later
/* Where a wall is at a step, and how fast.

   lammps_jump/scene/tracks.py and engines/twin/ state the same; tests compare the two. */

#ifndef JUMP_CORE_MOTION_H
#define JUMP_CORE_MOTION_H

#include "number.h"

#include <cstdint>

namespace jump {

constexpr int TRACK_WORDS = 25;

/** Kind of a moving wall that discs push. 1 follows a track; 3 goes at the speed that its `Pushed` has: its mass is
    infinite. */
constexpr int64_t LID = 2;

/** Displacement (m) and turn (rad) of a wall from where the case has it, or their rates. */
struct Pose {
  double x, y, angle;
};

/** Where a wall is at a step. */
struct Placed {
  Pose now;
  double c, s;     // cosine and sine of its angle
  Pose rate;       // over the step before
  Pose centred;    // over two steps, for power and work
};

/** A wall that discs push: a mass (kg/m) under a force (N/m), free along x and y or not, released at a time (s). */
struct Lid {
  double mass, force[2], free[2], begin;
};

/** Of such a wall: displacement (m), velocity of the half step (m/s), force of the discs of this step (N/m). */
struct Pushed {
  double place[2], speed[2], force[2];
};

/** Time of a step: t = 0 at step `start`. */
struct Clock {
  double start, dt;

  double time(double step) const { return (step - start) * dt; }
};

/** Pose at a time by the rows of a track; zero before the first. */
inline Pose pose_at(const double (*track)[TRACK_WORDS], int64_t rows, double time)
{
  int64_t row = -1;
  while (row + 1 < rows && track[row + 1][0] <= time) row++;
  Pose found = {0.0, 0.0, 0.0};
  if (row < 0) return found;
  const double *const t = track[row], since = time - t[0];
  for (int power = 4; power >= 0; power--) {
    found.x = found.x * since + t[1 + power];
    found.y = found.y * since + t[6 + power];
    found.angle = found.angle * since + t[11 + power];
  }
  double *const parts[] = {&found.x, &found.y, &found.angle};
  for (int k = 0; k < 3; k++)
    if (t[19 + k] != 0.0) *parts[k] += std::sin(t[19 + k] * since + t[22 + k]) * t[16 + k];
  return found;
}

/** Place a wall that follows a track. */
inline void follow(Placed &wall, const double (*track)[TRACK_WORDS], int64_t rows, double time, double dt)
{
  const Pose before = pose_at(track, rows, time - dt), behind = pose_at(track, rows, time + dt);
  wall.now = pose_at(track, rows, time);
  wall.rate = {(wall.now.x - before.x) / dt, (wall.now.y - before.y) / dt, (wall.now.angle - before.angle) / dt};
  wall.centred = {0.5 * (behind.x - before.x) / dt, 0.5 * (behind.y - before.y) / dt,
                  0.5 * (behind.angle - before.angle) / dt};
  wall.c = std::cos(wall.now.angle);
  wall.s = std::sin(wall.now.angle);
}

/** Place a wall that discs push. */
inline void follow(Placed &wall, const Pushed &pushed)
{
  wall.now.x = pushed.place[0];
  wall.now.y = pushed.place[1];
  wall.rate.x = pushed.speed[0];
  wall.rate.y = pushed.speed[1];
}

/** Kick and drift of a wall that discs push to a step, as of a disc; the first kick is half a step long. */
inline void drift(Pushed &pushed, const Lid &lid, const Clock &clock, double step)
{
  if (!(clock.time(step) > lid.begin)) return;
  const bool first = clock.time(step - 1) <= lid.begin;
  for (int axis = 0; axis < 2; axis++) {
    if (!(lid.free[axis] > 0.0)) continue;
    const double force = pushed.force[axis] + lid.force[axis];
    pushed.speed[axis] += (first ? 0.5 * clock.dt : clock.dt) * force / lid.mass;
    pushed.place[axis] += clock.dt * pushed.speed[axis];
  }
}

/** Velocity of a wall that discs push at a step, with the force of that step. */
inline void centre(Placed &wall, const Pushed &pushed, const Lid &lid, double dt)
{
  const bool free = wall.rate.x != 0.0 || wall.rate.y != 0.0;
  double *const velocity[2] = {&wall.centred.x, &wall.centred.y};
  for (int axis = 0; axis < 2; axis++) {
    const double force = pushed.force[axis] + lid.force[axis], half = 0.5 * dt * force / lid.mass;
    *velocity[axis] = free && lid.free[axis] > 0.0 ? pushed.speed[axis] + half : 0.0;
  }
}

/** Bound of the way of a wall's faces since `listed`, none of which is further than `far` from its centre, m. */
inline double travel(const Pose &now, const Pose &listed, double far)
{
  const double dx = now.x - listed.x, dy = now.y - listed.y;
  const double turned = now.angle != listed.angle ? far * std::fabs(now.angle - listed.angle) : 0.0;
  return std::sqrt(dx * dx + dy * dy) + turned;
}

/** A point as the frame has it in which the wall stands; (cx, cy): point of turning where the case has it, m. */
inline void inward(const Placed &wall, double cx, double cy, double &x, double &y)
{
  const double dx = x - cx - wall.now.x, dy = y - cy - wall.now.y;
  x = cx + wall.c * dx + wall.s * dy;
  y = cy - wall.s * dx + wall.c * dy;
}

/** A direction of that frame as it is. */
inline void outward(const Placed &wall, double &x, double &y)
{
  const double dx = x;
  x = wall.c * dx - wall.s * y;
  y = wall.s * dx + wall.c * y;
}

}    // namespace jump

#endif
