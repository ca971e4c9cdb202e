// SPDX-License-Identifier: GPL-2.0-or-later
/* Bodies against walls and against each other: corners, as discs, against faces.

   A corner is a disc of its own radius that is fixed to a wall, and meets the faces of others as discs do. Its contact acts at
   the disc's rim on both, so that the two feel no moment together. Contacts of the same two bodies share their effective mass.
   lammps_jump/engines/twin/bodies.py states the same; tests compare the two. */

#ifndef JUMP_CORE_BODIES_H
#define JUMP_CORE_BODIES_H

#include "step/kinds.h"

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

namespace jump {

/** Whether forces move a wall now. */
inline bool gives_way(const jump_state &s, int64_t wall)
{
  return s.moving && s.moving[wall] >= LOADED && gives_way(s.load[wall], s.pushed[wall]);
}

/** What a wall gives way to a push (wall.h). */
inline double yielding(const jump_state &s, int64_t wall, const Sum &push)
{
  return gives_way(s, wall) ? yielding(s.load[wall], s.pushed[wall], push) : 0.0;
}

/** A corner that touches a face: the walls of both, their velocities there, and arms from their points of turning. */
struct BodyContact {
  int64_t corner, wall, face;
  double px, py;          // the corner in the frame of the face's wall, m
  AtWall<double> at;
  double x, y;            // where the two feel each other, m
  double arm[2][2];       // from the points of turning of the corner's wall and of the face's, m
  double along, across;   // what the two give way together along the normal and across it, 1/kg

  double opening() const { return at.vx * at.nx + at.vy * at.ny; }
  double slip() const { return at.vy * at.nx - at.vx * at.ny - at.radius * at.spin; }
};

/** The walls of the corner and of the face. */
inline std::pair<int64_t, int64_t> walls_of(const jump_state &s, const BodyContact &contact)
{
  return {s.corner[contact.corner].wall, contact.wall};
}

/** What the two walls of a contact give way to a force of 1 N along (nx, ny) between them, 1/kg. */
inline double yielding(const jump_state &s, const BodyContact &contact, double nx, double ny)
{
  const auto [own, other] = walls_of(s, contact);
  double sum = 0.0;
  for (int side = 0; side < 2; side++) {
    Sum push;
    push.add(nx, ny, contact.arm[side][0], contact.arm[side][1]);
    sum += yielding(s, side ? other : own, push);
  }
  return sum;
}

/** Calls run(contact) for each contact of a corner with a face that give way to each other. */
template <class Run> inline void each_body_contact(const jump_state &s, const Run &run)
{
  const jump_state &c = *s.corners;
  FaceContact found[MOST];
  for (int64_t wall = 0; wall < s.walls; wall++) {
    WallView view(s, wall);
    view.body = true;    // all meet at the rim, as bodies do
    for (int64_t row = c.near_rows[wall]; row < c.near_rows[wall + 1]; row++) {
      const int64_t i = c.near_discs[row];
      const Corner &corner = s.corner[i];
      const WallView own(s, corner.wall);
      double x = corner.x, y = corner.y;
      own.out_of_frame(x, y);
      double px = x, py = y;
      view.into_frame(px, py);
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
        for (int side = 0; side < 2; side++) {
          const WallView &one = *both[side];
          out.arm[side][0] = out.x - one.cx - (one.placed ? one.placed->now.x : 0.0);
          out.arm[side][1] = out.y - one.cy - (one.placed ? one.placed->now.y : 0.0);
        }
        out.along = yielding(s, out, out.at.nx, out.at.ny);
        out.across = yielding(s, out, -out.at.ny, out.at.nx);
        if (out.along > 0.0) run(out);    // else both are held
      }
    }
  }
}

/** The two that share a contact's mass, the smaller number first; all that is at rest is one, -1. */
inline std::pair<int64_t, int64_t> partners(const jump_state &s, const BodyContact &contact)
{
  auto [one, other] = walls_of(s, contact);
  for (int64_t *const wall : {&one, &other})
    if (!gives_way(s, *wall) && (!s.moving || s.moving[*wall] != FOLLOWS)) *wall = -1;
  return std::minmax(one, other);
}

/** What two give way to all contacts between them at once, as these open or slip: the sum of v_i A_ij v_j over that of v_i^2, with
    the velocity that contact i has from 1 N at contact j as A_ij (1/kg). It is exact where all contacts move as one mode does,
    as where a block falls flat; of one contact it is A_11. */
class Together {
 public:
  /** `second`: whether the corner is of the second of the two. */
  void add(const BodyContact &contact, double speed, double nx, double ny, bool second)
  {
    both[second].add(speed * nx, speed * ny, contact.arm[0][0], contact.arm[0][1]);
    both[!second].add(-speed * nx, -speed * ny, contact.arm[1][0], contact.arm[1][1]);
    squares += speed * speed;
  }

  /** Of one of the contacts, which alone gives way by `alone`; walls that move as they like can make the sum as small as none. */
  double of(const jump_state &s, const std::pair<int64_t, int64_t> &walls, double alone) const
  {
    if (!(squares > std::numeric_limits<double>::min())) return alone;
    const double sum = (walls.first < 0 ? 0.0 : yielding(s, walls.first, both[0])) +
                       (walls.second < 0 ? 0.0 : yielding(s, walls.second, both[1]));
    return most(sum / squares, LEAST * alone);
  }

  /** Least share of what a contact gives way alone: a corner of an even convex outline has a half or more. */
  static constexpr double LEAST = 0.25;

 private:
  Sum both[2];
  double squares = 0.0;
};

/** Calls run(contact, along, across) for each contact, with what the two give way to all between them along the normals and
    across, 1/kg. */
template <class Run> inline void each_shared(const jump_state &s, const Run &run)
{
  std::vector<BodyContact> found;
  each_body_contact(s, [&](const BodyContact &contact) { found.push_back(contact); });
  using Key = std::pair<std::pair<int64_t, int64_t>, size_t>;
  std::vector<Key> order;
  for (size_t k = 0; k < found.size(); k++) order.push_back({partners(s, found[k]), k});
  std::sort(order.begin(), order.end());
  std::vector<std::pair<double, double>> shared(found.size());
  for (size_t first = 0, last; first < order.size(); first = last) {
    const auto walls = order[first].first;
    Together along, across;
    for (last = first; last < order.size() && order[last].first == walls; last++) {
      const BodyContact &contact = found[order[last].second];
      const AtWall<double> &at = contact.at;
      const bool second = s.corner[contact.corner].wall == walls.second;
      along.add(contact, contact.opening(), at.nx, at.ny, second);
      across.add(contact, contact.slip(), -at.ny, at.nx, second);
    }
    for (size_t k = first; k < last; k++) {
      const BodyContact &contact = found[order[k].second];
      shared[order[k].second] = {along.of(s, walls, contact.along), across.of(s, walls, contact.across)};
    }
  }
  for (size_t k = 0; k < found.size(); k++) run(found[k], shared[k].first, shared[k].second);
}

inline const BodyLaw &law_between(const jump_state &s, const BodyContact &contact)
{
  return s.between[s.corner[contact.corner].wall * s.walls + contact.wall];
}

/** Numbers of a contact whose two give way by this much along the normal and across it, 1/kg. */
inline Numbers<double> numbers_between(const BodyLaw &of, double along, double across)
{
  const auto dashpot = [&](double yields) { return most(of.law.damping / std::sqrt(yields) - of.lag, 0.0); };
  const double slips = across > 0.0 ? across : along;    // the latter: no force moves the two that way
  Numbers<double> own{of.law, dashpot(along), of.law.tangential / std::sqrt(slips)};
  own.law.spring_damping = own.damping > 0.0 ? of.law.spring_damping * dashpot(slips) / own.damping : 0.0;
  return own;
}

/** Add a contact to one of its walls: `sense` 1 to that of the corner, -1 to that of the face. */
template <class Force>
inline void add_to_wall(const jump_state &s, int64_t wall, const BodyContact &contact, const Force &out, double sense)
{
  const double *const arm = contact.arm[sense < 0.0];
  const double fx = sense * out.fx, fy = sense * out.fy, dashpot = sense * out.dashpot, tangential = sense * out.tangential;
  if (s.moving && s.moving[wall] != STANDS) {
    WallLoads &loads = s.wall_loads[wall];
    loads.all.add(fx, fy, arm[0], arm[1]);
    // the ledger has these as they act on discs
    loads.dashpots.add(-dashpot * contact.at.nx, -dashpot * contact.at.ny, arm[0], arm[1]);
    loads.friction.add(tangential * contact.at.ny, -tangential * contact.at.nx, arm[0], arm[1]);
  }
  if (s.moving && s.moving[wall] == BODY) return;    // a probe of a body is of discs alone
  const bool moves = s.moving && s.moving[wall] != STANDS;
  const double x_ref = s.about[wall][0] + (moves ? s.placed[wall].now.x : 0.0);
  const double y_ref = s.about[wall][1] + (moves ? s.placed[wall].now.y : 0.0);
  s.wall_sum[wall].force.add(fx, fy, contact.x - x_ref, contact.y - y_ref);
}

/** Forces between bodies, and of bodies and walls, on `wall_loads` and, of walls, `wall_sum`. */
inline void push_bodies(const jump_state &s, double slope)
{
  const jump_state &c = *s.corners;
  with_law(choice_of(s, slope), false, true, [&](const auto &law, auto, auto spin) {
    constexpr bool SPIN = decltype(spin)::value;
    each_shared(s, [&](const BodyContact &contact, double along, double across) {
      const Corner &corner = s.corner[contact.corner];
      const double overlap = corner.radius - contact.at.gap;
      const Numbers<double> numbers = numbers_between(law_between(s, contact), along, across);
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
