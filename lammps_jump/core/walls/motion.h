// SPDX-License-Identifier: GPL-2.0-or-later
/* Where a wall is at a step, and how fast.

   lammps_jump/scene/tracks.py and engines/twin/ state the same; tests compare the two. */

#ifndef JUMP_CORE_MOTION_H
#define JUMP_CORE_MOTION_H

#include "contact/elementary.h"

#include <cstdint>

namespace jump {

/** How a wall moves: it follows a track; a lid and a body are pushed by what touches them; a tailgate goes at the speed that
    its `Pushed` has, as its mass is infinite. A body is felt with its mass, and by walls too (bodies.h). core/columns.py
    has the same numbers. */
enum WallMotion : int64_t { STANDS, FOLLOWS, LOADED, TAILGATE, BODY };

/** Displacement (m) and turn (rad) of a wall from where the case has it, or their rates. */
struct Pose {
  double x, y, angle;
};

/** A force on a wall or what is lost there: along x and y, and its moment. */
struct Sum {
  double x = 0.0, y = 0.0, moment = 0.0;

  double power(const Pose &rate) const { return x * rate.x + y * rate.y + moment * rate.angle; }

  void operator+=(const Sum &other)
  {
    x += other.x;
    y += other.y;
    moment += other.moment;
  }
  void operator-=(const Sum &other)
  {
    x -= other.x;
    y -= other.y;
    moment -= other.moment;
  }

  /** Add a force that acts at (x, y) from the point of the moment. */
  void add(double fx, double fy, double at_x, double at_y)
  {
    x += fx;
    y += fy;
    moment += at_x * fy - at_y * fx;
  }
};

/** What a wall that moves takes in a step, its moments about the point of turning: force of the discs, of the discs and of
    bodies, and the parts of the latter that dashpots and friction take. */
struct WallLoads {
  Sum of_discs, all, dashpots, friction;
};

/** Sums over steps of what a wall feels, its moment about `about`: force of the discs, and its power on them. */
struct SumsOnWall {
  Sum force;
  double power;
};

/** Where a wall is at a step. */
struct Placed {
  Pose now;
  double c, s;     // cosine and sine of its angle
  Pose rate;       // over the step before
  Pose centred;    // over two steps, for power and work
};

/** A wall that is pushed: mass (kg/m) and moment of inertia about the point of turning (kg m), constant force (N/m), the arm
    from that point to where the force acts (m), freedom along x and y and to turn, and the time of its release (s). */
struct Load {
  double mass, inertia, force[2], arm[2], free[3], begin;

  double resistance(int axis) const { return axis < 2 ? mass : inertia; }

  /** The constant force and its moment, of a wall that is turned. */
  double own(int axis, double angle) const
  {
    if (axis < 2) return force[axis];
    if (arm[0] == 0.0 && arm[1] == 0.0) return 0.0;
    const double c = cosine(angle), s = sine(angle);
    return (c * arm[0] - s * arm[1]) * force[1] - (s * arm[0] + c * arm[1]) * force[0];
  }
};

/** Whether such a wall is held, released at this step, or has moved; core/columns.py has the same numbers. */
enum Phase { IS_HELD, IS_RELEASED, HAS_MOVED };

/** Of such a wall: displacement (m) and turn (rad), velocity of the half step and of the one before (m/s, rad/s), and force of
    what touches it at this step (N/m) with its moment about the point of turning (N). */
struct Pushed {
  double place[3], speed[3], before[3], force[3];
  double phase;
};

/** Time of a step: t = 0 at step `start`. */
struct Clock {
  double start, dt;

  double time(double step) const { return (step - start) * dt; }
};

/** What the native engine knows of time: the step at the call, t = 0, half the skin (m), and 1 where contacts with bodies see
    the extrapolated velocity. */
struct StepClock {
  double step, start, dt, half_skin, extrapolates;

  Clock clock() const { return {start, dt}; }
};

/** A stretch of a track: its begin (s); coefficients of the pose in powers of the time since; amplitudes, rates (rad/s) and
    phases of a wave, along x, along y and as a turn. */
struct TrackRow {
  double begin, x[5], y[5], angle[5], wave[3], rate[3], phase[3];
};
constexpr int TRACK_WORDS = sizeof(TrackRow) / sizeof(double);

/** Pose at a time by the rows of a track; zero before the first. */
inline Pose pose_at(const TrackRow *track, int64_t rows, double time)
{
  int64_t row = -1;
  while (row + 1 < rows && track[row + 1].begin <= time) row++;
  Pose found = {0.0, 0.0, 0.0};
  if (row < 0) return found;
  const TrackRow &t = track[row];
  const double since = time - t.begin;
  for (int power = 4; power >= 0; power--) {
    found.x = found.x * since + t.x[power];
    found.y = found.y * since + t.y[power];
    found.angle = found.angle * since + t.angle[power];
  }
  double *const parts[] = {&found.x, &found.y, &found.angle};
  for (int k = 0; k < 3; k++)
    if (t.rate[k] != 0.0) *parts[k] += sine(t.rate[k] * since + t.phase[k]) * t.wave[k];
  return found;
}

/** Place a wall that follows a track. */
inline void follow(Placed &wall, const TrackRow *track, int64_t rows, double time, double dt)
{
  const Pose before = pose_at(track, rows, time - dt), behind = pose_at(track, rows, time + dt);
  wall.now = pose_at(track, rows, time);
  wall.rate = {(wall.now.x - before.x) / dt, (wall.now.y - before.y) / dt, (wall.now.angle - before.angle) / dt};
  wall.centred = {0.5 * (behind.x - before.x) / dt, 0.5 * (behind.y - before.y) / dt,
                  0.5 * (behind.angle - before.angle) / dt};
  wall.c = cosine(wall.now.angle);
  wall.s = sine(wall.now.angle);
}

/** Kick and drift of a wall that is pushed to a step, as of a disc; the first kick is half a step long. */
inline void drift(Pushed &pushed, const Load &load, const Clock &clock, double step)
{
  if (!(clock.time(step) > load.begin)) return;
  const bool first = clock.time(step - 1) <= load.begin;
  const double angle = pushed.place[2];
  for (int axis = 0; axis < 3; axis++) {
    if (!(load.free[axis] > 0.0)) continue;
    const double force = pushed.force[axis] + load.own(axis, angle);
    pushed.before[axis] = pushed.speed[axis];
    pushed.speed[axis] += (first ? 0.5 * clock.dt : clock.dt) * force / load.resistance(axis);
    pushed.place[axis] += clock.dt * pushed.speed[axis];
  }
}

/** Place a wall that is pushed at a step. EXTRAPOLATED: contacts see 1.5 v_(n-1/2) - 0.5 v_(n-3/2) (thesis 3.7-3.9). */
inline void follow(Placed &wall, Pushed &pushed, const Load &load, const Clock &clock, double step, bool extrapolated)
{
  const double time = clock.time(step);
  pushed.phase = time > load.begin ? HAS_MOVED : time < load.begin ? IS_HELD : IS_RELEASED;
  wall.now = {pushed.place[0], pushed.place[1], pushed.place[2]};
  wall.c = cosine(wall.now.angle);
  wall.s = sine(wall.now.angle);
  double rate[3];
  for (int axis = 0; axis < 3; axis++) {
    rate[axis] = pushed.phase == IS_HELD ? 0.0 : pushed.speed[axis];
    if (extrapolated && pushed.phase == HAS_MOVED) rate[axis] = 1.5 * pushed.speed[axis] - 0.5 * pushed.before[axis];
  }
  wall.rate = {rate[0], rate[1], rate[2]};
}

/** Velocity of a wall that is pushed at a step, with the force of that step. */
inline void centre(Placed &wall, const Pushed &pushed, const Load &load, double dt)
{
  double *const velocity[3] = {&wall.centred.x, &wall.centred.y, &wall.centred.angle};
  for (int axis = 0; axis < 3; axis++) {
    const bool free = load.free[axis] > 0.0 && pushed.phase != IS_HELD;
    const double force = pushed.force[axis] + load.own(axis, pushed.place[2]);
    const double half = pushed.phase == HAS_MOVED ? 0.5 * dt * force / load.resistance(axis) : 0.0;
    *velocity[axis] = free ? pushed.speed[axis] + half : 0.0;
  }
}

/** Bound of the way of a wall's faces since `listed`, none of which is further than `far` from its centre, m. */
inline double travel(const Pose &now, const Pose &listed, double far)
{
  const double dx = now.x - listed.x, dy = now.y - listed.y;
  const double turned = now.angle != listed.angle ? far * std::fabs(now.angle - listed.angle) : 0.0;
  return std::sqrt(dx * dx + dy * dy) + turned;
}

/** A point in the frame in which the wall is at rest; (cx, cy): point of turning where the case has it, m. */
inline void inward(const Placed &wall, double cx, double cy, double &x, double &y)
{
  const double dx = x - cx - wall.now.x, dy = y - cy - wall.now.y;
  x = cx + wall.c * dx + wall.s * dy;
  y = cy - wall.s * dx + wall.c * dy;
}

/** A direction as that frame has it. */
inline void inward(const Placed &wall, double &x, double &y)
{
  const double dx = x;
  x = wall.c * dx + wall.s * y;
  y = -wall.s * dx + wall.c * y;
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
