// SPDX-License-Identifier: GPL-2.0-or-later
/* Bodies against walls and against each other: corners, as discs, against faces.

   A corner is a disc of its own radius that is fixed to a wall, and meets the faces of others as discs do. Its contact acts at
   the disc's rim on both, so that the two feel no moment together. The effective mass is that at this point, along the normal.
   lammps_jump/engines/twin/bodies.py states the same; tests compare the two. */

#ifndef JUMP_CORE_BODIES_H
#define JUMP_CORE_BODIES_H

#include "step/kinds.h"

namespace jump {

/** What a wall gives way to a force of 1 N at (ax, ay) from its point of turning, along (nx, ny), 1/kg: 0 of one that does not. */
inline double yielding(const jump_state &s, int64_t wall, double ax, double ay, double nx, double ny)
{
  if (!s.moving || s.moving[wall] < LOADED || s.pushed[wall].phase == IS_HELD) return 0.0;
  const Load &load = s.load[wall];
  const double turn = ax * ny - ay * nx;
  return (load.free[0] * nx * nx + load.free[1] * ny * ny) / load.mass + load.free[2] * turn * turn / load.inertia;
}

/** A corner that touches a face: the walls of both, their velocities there, and arms from their points of turning. */
struct BodyContact {
  int64_t corner, wall, face;
  double px, py;          // the corner in the frame of the face's wall, m
  AtWall<double> at;
  double x, y;            // where the two feel each other, m
  double arm[2][2];       // from the points of turning of the corner's wall and of the face's, m
  double mass;            // effective, kg/m
};

/** Calls run(contact) for each contact of a corner with a face. */
template <class Run> inline void each_body_contact(const jump_state &s, const Run &run)
{
  const jump_state &c = *s.corners;
  FaceContact found[MOST];
  for (int64_t wall = 0; wall < s.walls; wall++) {
    WallView view(s, wall);
    view.bulk = 1.0;    // all meet at the rim, as bodies do
    for (int64_t row = c.near_rows[wall]; row < c.near_rows[wall + 1]; row++) {
      const int64_t i = c.near_discs[row];
      const Corner &corner = s.corner[i];
      const WallView own(s, corner.wall);
      double x = corner.x, y = corner.y;
      own.show(x, y);
      double px = x, py = y;
      view.see(px, py);
      const int count = view.touching(c, row, px, py, corner.radius, found);
      for (int k = 0; k < count; k++) {
        const Pose v = own.placed ? own.velocity(own.placed->rate, x, y) : Pose{0.0, 0.0, 0.0};
        BodyContact out{i, wall, found[k].face, px, py, view.at(found[k], x, y, corner.radius, v.x, v.y, v.angle)};
        double dx = -out.at.nx, dy = -out.at.ny;
        if (own.placed) inward(*own.placed, dx, dy);
        if (!corner.holds(dx, dy)) continue;
        out.x = x - corner.radius * out.at.nx;
        out.y = y - corner.radius * out.at.ny;
        const WallView *const both[2] = {&own, &view};
        double yields = 0.0;
        for (int side = 0; side < 2; side++) {
          const WallView &one = *both[side];
          out.arm[side][0] = out.x - one.cx - (one.placed ? one.placed->now.x : 0.0);
          out.arm[side][1] = out.y - one.cy - (one.placed ? one.placed->now.y : 0.0);
          yields += yielding(s, side ? wall : corner.wall, out.arm[side][0], out.arm[side][1], out.at.nx, out.at.ny);
        }
        if (!(yields > 0.0)) continue;    // both are held
        out.mass = 1.0 / yields;
        run(out);
      }
    }
  }
}

inline const BodyLaw &law_between(const jump_state &s, const BodyContact &contact)
{
  return s.between[s.corner[contact.corner].wall * s.walls + contact.wall];
}

/** Add a contact to one of its walls: `sense` 1 to that of the corner, -1 to that of the face. */
template <class Force>
inline void add_to_wall(const jump_state &s, int64_t wall, const BodyContact &contact, const Force &out, double sense)
{
  const double *const arm = contact.arm[sense < 0.0];
  const double fx = sense * out.fx, fy = sense * out.fy, dashpot = sense * out.dashpot, tangential = sense * out.tangential;
  if (s.moving && s.moving[wall] != STANDS) {
    WallLoads &taken = s.taken[wall];
    taken.all.add(fx, fy, arm[0], arm[1]);
    // the ledger has these as they act on discs
    taken.dashpots.add(-dashpot * contact.at.nx, -dashpot * contact.at.ny, arm[0], arm[1]);
    taken.friction.add(tangential * contact.at.ny, -tangential * contact.at.nx, arm[0], arm[1]);
  }
  if (s.bulk[wall] > 0.0) return;    // a probe of a body is of discs alone
  const bool moves = s.moving && s.moving[wall] != STANDS;
  const double x_ref = s.about[wall][0] + (moves ? s.placed[wall].now.x : 0.0);
  const double y_ref = s.about[wall][1] + (moves ? s.placed[wall].now.y : 0.0);
  s.wall_sum[wall].force.add(fx, fy, contact.x - x_ref, contact.y - y_ref);
}

/** Forces between bodies, and of bodies and walls, on `taken` and, of walls, `wall_sum`. */
inline void push_bodies(const jump_state &s, double slope)
{
  const jump_state &c = *s.corners;
  with_law(choice_of(s, slope), false, true, [&](const auto &law, auto, auto spin) {
    constexpr bool SPIN = decltype(spin)::value;
    each_body_contact(s, [&](const BodyContact &contact) {
      const Corner &corner = s.corner[contact.corner];
      const BodyLaw &of = law_between(s, contact);
      const double size = std::sqrt(contact.mass), overlap = corner.radius - contact.at.gap;
      const Numbers<double> numbers{of.law, most(of.law.damping * size - of.lag, 0.0), of.law.tangential * size};
      const WallForce<double> out = wall_contact<false, SPIN>(
          law, numbers, contact.at,
          WallHistory(c, contact.corner, contact.face, contact.px, contact.py, corner.radius));
      add_to_wall(s, corner.wall, contact, out, 1.0);
      add_to_wall(s, contact.wall, contact, out, -1.0);
      if (overlap > s.deepest[0]) {
        s.deepest[0] = overlap;
        s.deepest[1] = (double) corner.wall;
        s.deepest[2] = (double) contact.wall;
      }
    });
  });
}

/** Elastic energy of these contacts, J per m of width. */
inline double stored_by_bodies(const jump_state &s)
{
  double energy = 0.0;
  with_normal(s.pair, [&](const auto &law) {
    each_body_contact(s, [&](const BodyContact &contact) {
      const double overlap = s.corner[contact.corner].radius - contact.at.gap;
      energy += stored_energy(law, law_between(s, contact).law, overlap);
    });
  });
  return energy;
}

}    // namespace jump

#endif
