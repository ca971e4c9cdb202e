// SPDX-License-Identifier: GPL-2.0-or-later
/* A wall where it is, as a disc meets it. */

#ifndef JUMP_CORE_WALL_H
#define JUMP_CORE_WALL_H

#include "contact/contact.h"
#include "walls/faces.h"
#include "walls/motion.h"

namespace jump {

struct WallInPlace {
  WallFaces faces;
  const Placed *placed;    // null where it stands
  double cx, cy;           // point of turning where the case has it, m
  bool body = false;       // whether it is felt with its mass, at the rims of discs

  /** Distance from the centre of a disc to the point where both feel their contact, m: of a body the rim of the disc, so that
      what the two feel has no moment. */
  double arm(double gap, double radius) const { return body ? radius : gap; }

  /** The point of a disc in the wall's own frame. */
  void see(double &px, double &py) const
  {
    if (placed) inward(*placed, cx, cy, px, py);
  }

  /** A point of that frame, where it is. */
  void show(double &x, double &y) const
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

}    // namespace jump

#endif
