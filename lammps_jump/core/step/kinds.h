// SPDX-License-Identifier: GPL-2.0-or-later
/* The kinds of contact of the native engine: which law a state asks for, and its numbers. */

#ifndef JUMP_CORE_KINDS_H
#define JUMP_CORE_KINDS_H

#include "contact/contact.h"
#include "walls/wall.h"
#include "step/native.h"

namespace jump {

/** Velocities that dashpots and friction see: of the half step, or extrapolated. */
inline ContactVelocities seen_by(const jump_state &s)
{
  return s.ux ? ContactVelocities{s.ux, s.uy, s.uomega} : ContactVelocities{s.vx, s.vy, s.omega};
}

/** 1/eps of the thesis' friction, eps = 0.01 v_max (4.20), of these velocities, s/m; 0 of another friction. */
double slope_of(const jump_state &s, const ContactVelocities &seen);

/** The same of the square of the largest velocity, (m/s)^2. */
inline double slope_of(const jump_state &s, double fastest)
{
  if (!(s.pair.sign_ramp > 0.0)) return 0.0;
  const double eps = s.pair.sign_ramp * std::sqrt(fastest);
  return eps > 1e-300 ? 1.0 / eps : 1e300;    // nothing moves: the limit of the law, sat -> sign
}

/** The law that a state asks for. */
inline Choice choice_of(const jump_state &s, double slope)
{
  return choice_of(s.pair, s.partner, slope, s.memory_step);
}

/** Calls run(law, sizes, spin) with the law of a state. */
template <class Run> inline void with_law(const jump_state &s, double slope, const Run &run)
{
  with_law(choice_of(s, slope), s.radius, s.omega, run);
}

inline double radius_of(const jump_state &s, int64_t i) { return s.radius ? s.radius[i] : 0.5 * s.diameter; }
inline bool is_fixed(const jump_state &s, int64_t i) { return s.fixed && s.fixed[i] != 0; }

/** Radius that represents the mass of a disc, m: its partner's mass counts where it is fixed. */
inline double mass_radius(const jump_state &s, int64_t i) { return is_fixed(s, i) ? HUGE_RADIUS : s.radius[i]; }

/** Slots of one disc. */
struct DiscHistory {
  const jump_state &s;
  int64_t first;

  DiscHistory(const jump_state &state, int64_t disc) : s(state), first(disc * state.slot_row) {}
  int count() const { return (int) s.slots; }
  int64_t partner(int at) const { return s.partner[first + at]; }
  double foot(int at) const { return s.sigma[first + at]; }
  bool used(int at) const { return s.used[first + at] == 1; }
  void take(int at, int64_t partner)
  {
    s.partner[first + at] = partner;
    s.spring[first + at] = s.roll[first + at] = 0.0;
  }
  void mark(int at, double foot)
  {
    s.sigma[first + at] = foot;
    s.used[first + at] = 1;
  }
};

/** Empty the slots whose contacts have ended, of discs `begin` to `end`. */
inline void end_contacts(const jump_state &s, int64_t begin, int64_t end)
{
  for (int64_t i = begin; i < end; i++)
    for (int64_t at = i * s.slot_row, last = at + s.slots; at < last; at++) {
      if (s.used[at] == 0 && s.partner[at] != 0) {
        s.partner[at] = 0;
        s.sigma[at] = s.spring[at] = s.roll[at] = 0.0;
      }
      s.used[at] = 0;
    }
}

/** What a disc remembers of one contact: its present state, and that after a step. */
class ContactHistory {
 public:
  ContactHistory(const jump_state &s, int64_t disc) : row(s, disc), id(s.ids[disc]) {}

  void find(int64_t partner, double foot, double limit, double around)
  {
    const bool goes_on = row.s.memory_step > 0.0;
    slot = goes_on ? slot_of(row, partner, foot, limit, around) : held(row, partner, foot, limit, around);
    if (slot == FULL && goes_on) *row.s.full = id;
  }

  /** In its present state; nothing is changed. */
  void look(int64_t partner) { slot = held(row, partner, 0.0, NO_END, 0.0); }

  /** Index of the springs, or FULL. */
  int64_t place() const { return slot == FULL ? FULL : row.first + slot; }

  /** `way`: rolling of this disc over that of the first of the contact. */
  Stretch<double> begin(double way) const
  {
    if (slot == FULL) return {0.0, 0.0};
    return {row.s.spring[row.first + slot], way * row.s.roll[row.first + slot]};
  }

  void end(const Stretch<double> &held, double way) const
  {
    if (slot == FULL || !(row.s.memory_step > 0.0)) return;
    row.s.spring[row.first + slot] = held.slide;
    row.s.roll[row.first + slot] = way * held.roll;
  }

 private:
  DiscHistory row;
  int64_t id;
  int slot = FULL;
};

/** Of two discs the one with the larger id remembers, but none of another rank, whose number is from s.n on; `way` is that of
    rolling (ContactHistory). */
struct PairHistory {
  double way;
  int64_t disc, other, partner;

  PairHistory(const jump_state &s, int64_t i, int64_t j)
      : way((s.ids[i] > s.ids[j] && i < s.n) || j >= s.n ? 1.0 : -1.0), disc(way > 0.0 ? i : j), other(way > 0.0 ? j : i),
        partner(s.ids[other])
  {
  }

  /** The springs, taken where there are none yet and springs go on. */
  ContactHistory take(const jump_state &s) const
  {
    ContactHistory of(s, disc);
    of.find(partner, 0.0, NO_END, 0.0);
    return of;
  }

  /** The springs in their present state. */
  ContactHistory look(const jump_state &s) const
  {
    ContactHistory of(s, disc);
    of.look(partner);
    return of;
  }
};

/** Disc i at a face of a wall; (px, py): its place in the wall's own frame. */
class WallHistory {
 public:
  WallHistory(const jump_state &s, int64_t i, int64_t face, double px, double py, double radius)
      : state(s), of(s, i), face(face), px(px), py(py), radius(radius)
  {
  }
  Stretch<double> begin(double slip)
  {
    const double limit = 0.5 * radius + std::fabs(slip) * state.memory_step;
    of.find(state.chain[face], foot_of(state.faces[face], px, py), limit, state.around[face]);
    return of.begin(1.0);
  }
  void end(const Stretch<double> &held) const { of.end(held, 1.0); }

 private:
  const jump_state &state;
  ContactHistory of;
  int64_t face;
  double px, py, radius;
};

/** From a disc to another: components and square. */
struct Between {
  double dx, dy, apart2;
};

/** The contact of discs i and j of a row of the list; `way` goes from j to i. */
template <bool SIZES, bool SPIN>
inline Pair<double> pair_of(const jump_state &s, const ContactVelocities &seen, int64_t i, int64_t j, const Between &way, double a, double b)
{
  Pair<double> pair;
  pair.dx = way.dx;
  pair.dy = way.dy;
  pair.apart2 = way.apart2;
  pair.vx = seen.vx[i] - seen.vx[j];
  pair.vy = seen.vy[i] - seen.vy[j];
  pair.a = a;
  pair.b = b;
  if constexpr (SIZES) {
    pair.bulk_a = mass_radius(s, i);
    pair.bulk_b = mass_radius(s, j);
  }
  if constexpr (SPIN) {
    pair.spin_a = seen.spin[i];
    pair.spin_b = seen.spin[j];
  }
  return pair;
}

/** A disc that may touch a wall: its number, radius, place, and velocity and spin as contacts see them. */
struct DiscAtWall {
  int64_t number;
  double radius, x, y, vx, vy, spin;
};

/** A wall of a state as a disc meets it. */
struct WallView : WallInPlace {
  int64_t wall;

  WallView(const jump_state &s, int64_t wall) : WallInPlace{{s.faces, s.deep[wall] == 1}, nullptr, 0.0, 0.0}, wall(wall)
  {
    if (!s.moving || s.moving[wall] == STANDS) return;
    placed = s.placed + wall;
    cx = s.centre[wall][0];
    cy = s.centre[wall][1];
    body = s.moving[wall] == BODY;
  }

  /** The contact of a disc. */
  AtWall<double> meet(const DiscAtWall &disc, const FaceContact &found) const
  {
    return at(found, disc.x, disc.y, disc.radius, disc.vx, disc.vy, disc.spin);
  }

  /** Whether the wall and a disc that stays feel each other: a body and a rough bed do. */
  bool passes(const jump_state &s, int64_t i) const { return is_fixed(s, i) && !body; }

  /** Contacts of disc i, which is on this row of the list; (px, py): its place in the wall's own frame. */
  int touching(const jump_state &s, int64_t row, double px, double py, double radius, FaceContact *found) const
  {
    const int64_t *const near = s.near_faces + s.near_last[row];
    if (!s.near_plain[row]) return faces.touching(near, s.near_last[row + 1] - s.near_last[row], px, py, radius, found);
    found[0] = faces.on_line(*near, px, py);    // one straight face whose ends are out of reach
    return found[0].gap < radius && (faces.deep || found[0].gap > -radius);
  }
};

/** The force of a body on a disc, `of` being the numbers of a disc of nominal size at a wall; those of the effective mass of this
    contact count. It is a separate function so that the rest of the loop is that of walls without bodies. */
template <bool SIZES, bool SPIN, class Law>
[[gnu::noinline]] WallForce<double> body_force(const jump_state &s, const Law &law, const Numbers<double> &of, const WallView &view,
                                               const DiscAtWall &body_meets, const AtWall<double> &at, WallHistory history)
{
  const double arm[2] = {body_meets.x - at.radius * at.nx - view.cx - view.placed->now.x,
                         body_meets.y - at.radius * at.ny - view.cy - view.placed->now.y};
  const double mass = SIZES ? s.mass * at.radius * at.radius : s.mass;
  const DiscMass disc{mass, 0.5 * mass * at.radius * at.radius, is_fixed(s, body_meets.number)};
  const Numbers<double> own = numbers_at_body(of, s.mass, disc, s.load[view.wall], s.pushed[view.wall], arm, at);
  return wall_contact<false, SPIN>(law, own, at, history);
}

/** The force of a wall on a disc. */
template <bool SIZES, bool SPIN, class Law>
inline WallForce<double> wall_force(const jump_state &s, const Law &law, const Numbers<double> &of, const WallView &view,
                                    const DiscAtWall &disc, const AtWall<double> &at, const WallHistory &history)
{
  if (view.body) return body_force<SIZES, SPIN>(s, law, of, view, disc, at, history);
  return wall_contact<SIZES, SPIN>(law, of, at, WallHistory(history));
}

}    // namespace jump

#endif
