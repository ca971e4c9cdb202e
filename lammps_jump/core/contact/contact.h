// SPDX-License-Identifier: GPL-2.0-or-later
/* One contact of two discs and one of a disc with a wall: lever, slip, force, torque, what is lost, memory.

   Nothing else puts a contact together: forces, the ledger, the list of contacts, the analysis and the plugin call these. */

#ifndef JUMP_CORE_CONTACT_H
#define JUMP_CORE_CONTACT_H

#include "contact/elementary.h"
#include "contact/law.h"

namespace jump {

/** Radius that represents the mass of a fixed disc, m: its square is still a number. */
constexpr double HUGE_RADIUS = 1e150;

/** From the centre of a disc to the middle of the overlap, m. */
template <class Number> inline Number way_to_middle(const Number &radius, const Number &overlap)
{
  return radius - 0.5 * overlap;
}

/** Root of the effective mass of two discs over that of a radius of 1 m (m). */
template <class Number> inline Number pair_size(const Number &a, const Number &b) { return a * b / root(a * a + b * b); }

template <class Number> struct ContactForce {
  Number fx, fy;     // on the disc, N per m of width
  Number tangential;        // its tangential part, along (-ny, nx)
  Number dashpot;    // its lost part along the normal
  Number resist;     // against rolling, along the rims
};

/** What acts along the normal, N per m of width, positive where it pushes apart: all of it, and its lost part. */
template <class Number> struct Push {
  Number whole, dashpot;
};

/** opening: speed of parting, m/s. */
template <class Law, class Number>
inline Push<Number> normal_force(const Law &law, const Numbers<Number> &of, const Number &overlap, const Number &opening)
{
  const Number dashpot = law.damping.force(of, opening, overlap);
  return {law.normal.force(of.law, overlap) + dashpot, dashpot};
}

/** What the contact has stored, J per m of width. */
template <class Law, class Number>
inline Number stored_energy(const Law &law, const LawNumbers &of, const Number &overlap)
{
  return law.normal.energy(of, overlap);
}

/** What dashpot and friction take while the centre of the disc moves at (vx, vy) against its partner, W per m of width; the
    work of torques is left out. */
template <class Number>
inline Number dissipated_power(const ContactForce<Number> &of, const Number &nx, const Number &ny, const Number &vx, const Number &vy)
{
  return -of.dashpot * (nx * vx + ny * vy) - of.tangential * (nx * vy - ny * vx);
}

/** How a disc meets what it touches. */
template <class Number> struct Meeting {
  Number overlap;    // m
  Number nx, ny;     // unit vector to the disc from what it touches
  Number vx, vy;     // velocity of its centre against that of its partner, m/s
  Number rim;        // speed of the rims, R_i omega_i + R_j omega_j, m/s
  Number turn;       // speed of rolling, m/s
};

/** The force of a contact on a disc. Friction is bounded by what presses the two together (`pressing`). */
template <class Law, class Number>
inline ContactForce<Number> contact_force(const Law &law, const Numbers<Number> &of, const Meeting<Number> &at,
                                          Stretch<Number> &held)
{
  const Number &overlap = at.overlap, &nx = at.nx, &ny = at.ny, &vx = at.vx, &vy = at.vy;
  ContactForce<Number> out;
  const Push<Number> push = normal_force(law, of, overlap, vx * nx + vy * ny);
  out.dashpot = push.dashpot;
  out.fx = push.whole * nx;
  out.fy = push.whole * ny;
  out.tangential = out.resist = spread(0.0, overlap);
  if constexpr (Law::Friction::HAS_FRICTION) {
    const Number slip = vy * nx - vx * ny - at.rim;
    if constexpr (Law::Friction::HAS_HISTORY) {
      const Number whole = out.fx * nx + out.fy * ny;    // as the components have it, to the last bit
      const Number normal = law.normal.pressing(of.law, whole);
      out.tangential = law.tangential.force(of, normal, slip, held);
      out.resist = law.tangential.against_rolling(of.law, normal, at.turn, held);
    } else {
      out.tangential = law.tangential.force(of, law.normal.pressing(of.law, push.whole), slip);
    }
    out.fx = out.fx - out.tangential * ny;
    out.fy = out.fy + out.tangential * nx;
  }
  return out;
}

/** Two discs that touch: the first is at (dx, dy) from the second and moves at (vx, vy) against it. */
template <class Number> struct Pair {
  Number dx, dy, apart2;    // m, and the square of the distance
  Number vx, vy;            // m/s
  Number a, b;              // radii, m
  Number bulk_a, bulk_b;    // radii that represent the masses, m
  Number spin_a, spin_b;    // rad/s
};

template <class Number> struct PairForce : ContactForce<Number> {
  Number nx, ny, overlap;
  Number lever_a, lever_b;      // of friction, m
  Number on_a, on_b;            // torques, N m per m of width
};

/** The contact of two discs. SIZES: discs have radii of their own, and `of` is of a size of 1 m.

    The lever of friction is R of equal discs. It is R less half the overlap of others and of contacts with memory, as in
    LAMMPS' styles for each. */
template <bool SIZES, bool SPIN, class Law, class Number>
inline PairForce<Number> pair_contact(const Law &law, const Numbers<Number> &of, const Pair<Number> &pair,
                                      Stretch<Number> &held)
{
  constexpr bool MEMORY = Law::Friction::HAS_HISTORY;
  PairForce<Number> out;
  const Number r = root(pair.apart2), inverse = 1.0 / r;
  out.nx = pair.dx * inverse;
  out.ny = pair.dy * inverse;
  out.overlap = pair.a + pair.b - r;
  Numbers<Number> own = of;
  if constexpr (SIZES) {
    const Number size = pair_size(pair.bulk_a, pair.bulk_b);
    own.damping = of.damping * size;
    own.ramp = of.ramp * size;
  }
  const Number zero = spread(0.0, r);
  Number rim = zero, turn = zero, arm = zero;
  if constexpr (SPIN) rim = SIZES ? pair.a * pair.spin_a + pair.b * pair.spin_b : pair.a * (pair.spin_a + pair.spin_b);
  if constexpr (SPIN && MEMORY) {
    arm = pair.a * pair.b / (pair.a + pair.b);
    turn = arm * (pair.spin_a - pair.spin_b);
  }
  static_cast<ContactForce<Number> &>(out) =
      contact_force(law, own, Meeting<Number>{out.overlap, out.nx, out.ny, pair.vx, pair.vy, rim, turn}, held);
  if constexpr (SPIN) {
    out.lever_a = SIZES || MEMORY ? way_to_middle(pair.a, out.overlap) : pair.a;
    out.lever_b = SIZES || MEMORY ? way_to_middle(pair.b, out.overlap) : pair.b;
    const Number rolls = arm * out.resist;
    out.on_a = -out.lever_a * out.tangential + rolls;
    out.on_b = -out.lever_b * out.tangential - rolls;
  }
  return out;
}

/** A disc that touches a wall. */
template <class Number> struct AtWall {
  Number radius, gap;    // gap: signed distance of the centre from the wall, m
  Number nx, ny;         // from the wall to the disc
  Number vx, vy;         // against the wall, m/s
  Number spin;           // rad/s
  Number size;           // of dashpot and ramp where discs have radii of their own, m (`pair_size`): at a wall the radius
  Number turns;          // spin of the wall where it rolls along, rad/s
};

template <class Number> struct WallForce : ContactForce<Number> {
  Number torque;    // on the disc
};

/** The contact of a disc with a wall; the lever of friction is R. SIZES as of two discs.

    `memory(slip)` gives the stretch that the contact begins with, and where it goes on. */
template <bool SIZES, bool SPIN, class Law, class Number, class Memory>
inline WallForce<Number> wall_contact(const Law &law, const Numbers<Number> &of, const AtWall<Number> &at,
                                      Memory &&memory)
{
  WallForce<Number> out;
  Numbers<Number> own = of;
  if constexpr (SIZES) {
    own.damping = of.damping * at.size;
    own.ramp = of.ramp * at.size;
  }
  const Number rim = SPIN ? at.radius * at.spin : spread(0.0, at.radius);
  const Number turn = SPIN ? at.radius * (at.spin - at.turns) : rim;
  Stretch<Number> held{};
  if constexpr (Law::Friction::HAS_HISTORY) held = memory.begin(at.vy * at.nx - at.vx * at.ny - rim);
  static_cast<ContactForce<Number> &>(out) =
      contact_force(law, own, Meeting<Number>{at.radius - at.gap, at.nx, at.ny, at.vx, at.vy, rim, turn}, held);
  if constexpr (Law::Friction::HAS_HISTORY) memory.end(held);
  out.torque = at.radius * (out.resist - out.tangential);
  return out;
}

/* What a disc remembers of its contacts; lammps_jump/physics/law.py states it, and tests compare the two.

   A partner is the id of a disc, above 0, or -1 - c for chain c of the walls; 0 in an empty slot. At a chain the arc length
   of the foot tells the contacts apart, and the nearest one goes on.

   Slots are the memory of one disc: `count()`, and of a slot `partner(s)`, `foot(s)`, `used(s)` (whether a contact of this
   step has it), `take(s, partner)` (begins it with springs at 0) and `mark(s, foot)`. */

/** No slot. */
constexpr int FULL = -1;

/** Way of a foot along a chain, m; `around` is the length of a closed one, else 0. */
inline double way_of(double foot, double before, double around)
{
  const double way = std::fabs(foot - before);
  if (!(around > 0.0)) return way;
  const double rest = std::fmod(way, around);
  return least(rest, around - rest);
}

/** Slot in which a disc remembers a contact whose foot has gone `limit` (m) at most, or FULL; nothing is changed.

    With `anew`, slots that a contact of this step has are left out. */
template <class Slots, class Partner>
inline int held(const Slots &row, Partner partner, double foot, double limit, double around, bool anew = false)
{
  int best = FULL;
  double nearest = limit;
  for (int s = 0; s < row.count(); s++) {
    if (row.partner(s) != partner || (anew && row.used(s))) continue;
    if (!(partner < 0)) return s;    // a disc is in one slot
    const double way = way_of(foot, row.foot(s), around);
    if (way <= nearest) {
      best = s;
      nearest = way;
    }
  }
  return best;
}

/** Slot of a contact in this step: that of its partner, or an empty one with springs at 0; FULL where there is neither. */
template <class Slots, class Partner>
inline int slot_of(Slots &row, Partner partner, double foot, double limit, double around)
{
  int best = held(row, partner, foot, limit, around, true);
  for (int s = 0; best == FULL && s < row.count(); s++)
    if (row.partner(s) == 0) {
      best = s;
      row.take(s, partner);
    }
  if (best != FULL) row.mark(best, foot);
  return best;
}

}    // namespace jump

#endif
