// SPDX-License-Identifier: GPL-2.0-or-later
/* A wall where it is, as a disc meets it, and effective masses of contacts with walls that forces move. */

#ifndef JUMP_CORE_WALL_H
#define JUMP_CORE_WALL_H

#include "contact/contact.h"
#include "walls/faces.h"
#include "walls/motion.h"

namespace jump {

struct WallInPlace {
  WallFaces faces;
  const Placed *placed;    // null where it is at rest
  double cx, cy;           // point of turning where the case has it, m
  bool body = false;       // whether it is felt with its mass, at the rims of discs

  /** Distance from the centre of a disc to the point where both feel their contact, m: of a body the rim of the disc, so that
      what the two feel has no moment. */
  double arm(double gap, double radius) const { return body ? radius : gap; }

  /** The point of a disc in the wall's own frame. */
  void into_frame(double &px, double &py) const
  {
    if (placed) inward(*placed, cx, cy, px, py);
  }

  /** A point of that frame, where it is. */
  void out_of_frame(double &x, double &y) const
  {
    if (!placed) return;
    double dx = x - cx, dy = y - cy;
    outward(*placed, dx, dy);
    x = cx + placed->now.x + dx;
    y = cy + placed->now.y + dy;
  }

  /** The contact of a disc at (x, y) that moves at (vx, vy), as the wall is: `found` is of its own frame. */
  AtWall<double> at(const FaceContact &found, double x, double y, double radius, double vx, double vy, double spin) const
  {
    AtWall<double> out{radius, found.gap, found.nx, found.ny, vx, vy, spin, radius, 0.0};
    if (placed) {
      outward(*placed, out.nx, out.ny);
      const double to = arm(out.gap, radius);
      const Pose v = velocity(placed->rate, x - to * out.nx, y - to * out.ny);
      out.vx -= v.x;
      out.vy -= v.y;
      if (body) out.turns = v.angle;
    }
    return out;
  }

  /** Velocity of the wall at a point, of one of its rates. */
  Pose velocity(const Pose &rate, double x, double y) const
  {
    return {rate.x - rate.angle * (y - cy - placed->now.y), rate.y + rate.angle * (x - cx - placed->now.x), rate.angle};
  }
};

/* Effective masses of contacts with walls that forces move, which are lids and bodies.

   1/m_eff is the sum of what the two give way to a force of 1 N. A body gives way by its mass, by its moment of inertia with the
   arm of the force, and only as it is free to; while it is held it is a wall. A dashpot is 2 xi sqrt(k m_eff), so that the
   restitution is the same wherever a body is hit. lammps_jump/engines/twin/pushed.py states the same; tests compare the two. */

/** Whether forces move a wall that is pushed: not while it is held, nor a tailgate, whose mass is infinite. */
inline bool gives_way(const Load &load, const Pushed &pushed) { return pushed.phase != IS_HELD && std::isfinite(load.mass); }

/** Twice the kinetic energy that a body has from an impulse, J m/(N s)^2 for one of 1 N s. Of a force of 1 N along a normal it is
    what the body gives way there, 1/kg. */
inline double yielding(const Load &load, const Pushed &pushed, const Sum &push)
{
  if (!gives_way(load, pushed)) return 0.0;
  return (load.free[0] * push.x * push.x + load.free[1] * push.y * push.y) / load.mass +
         load.free[2] * push.moment * push.moment / load.inertia;
}

/** The same of a force of 1 N along (nx, ny) that acts at an arm (m) from the point of turning. */
inline double yielding(const Load &load, const Pushed &pushed, const double *arm, double nx, double ny)
{
  Sum push;
  push.add(nx, ny, arm[0], arm[1]);
  return yielding(load, pushed, push);
}

/** What of a disc is in its contact with a body: kg and kg m^2, per m of width. A fixed disc gives way to nothing. */
struct DiscMass {
  double mass, inertia;
  bool fixed;

  /** Root of an effective mass over `unit` (kg), where the body gives way by `yields` (1/kg). */
  double size(double yields, double unit) const
  {
    const double inverse = (fixed ? 0.0 : 1.0 / mass) + yields;
    return inverse > 0.0 ? std::sqrt(1.0 / (inverse * unit)) : std::sqrt(mass / unit);    // the latter: nothing moves that way
  }

  /** Root of what resists rolling over the same at a wall, where the body turns by `turns` rad/s for 1 N m s, 1/(kg m). */
  double rolls(double turns) const
  {
    const double at_wall = 1.0 / inertia, inverse = (fixed ? 0.0 : at_wall) + turns;
    return inverse > 0.0 ? std::sqrt(at_wall / inverse) : 1.0;
  }
};

/** Numbers of a contact of a disc with a body, from those of a disc of the mass `unit` (kg/m) with a wall; `arm` (m): from the
    body's point of turning to where the two feel each other. */
inline Numbers<double> numbers_at_body(const Numbers<double> &of, double unit, const DiscMass &disc, const Load &load,
                                       const Pushed &pushed, const double *arm, const AtWall<double> &at)
{
  const double along = disc.size(yielding(load, pushed, arm, at.nx, at.ny), unit);
  const double across = disc.size(yielding(load, pushed, arm, -at.ny, at.nx), unit);
  Numbers<double> own = of;
  own.damping = of.damping * along;
  own.ramp = of.ramp * across;
  own.law.spring_damping = of.law.spring_damping * (across / along);    // it goes with the dashpot along the normal
  own.law.rolling_damping = of.law.rolling_damping * disc.rolls(yielding(load, pushed, Sum{0.0, 0.0, 1.0}));
  return own;
}

}    // namespace jump

#endif
