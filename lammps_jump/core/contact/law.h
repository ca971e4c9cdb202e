// SPDX-License-Identifier: GPL-2.0-or-later
/* The contact law by slots: normal, damping, tangential, rolling. A new one is one struct here.

   delta overlap (m), k stiffness (N/m), c dashpot (N s/m), mu friction coefficient; forces in N, all per m of width.

   normal      `Spring`: k delta (thesis T-4359, 3.11); `SmoothSpring` of width s: k delta^2/(2 s) below delta = s and
               k (delta - s/2) beyond; each less `cohesion`, a constant attraction of what touches
   damping     `Dashpot`: -c v_n; `SmoothDashpot`: times F / sqrt(2 k E), F the spring's force and E its energy, so that
               the restitution is that of the linear law at every speed and width (derived in docs/kernels.md)
   tangential  `NoFriction`; `Ramp`: min(mu |F_n|, c_t |v_t|) against the slip (LAMMPS gran/hooke); `Sign`:
               mu |F_n| sat(v_t / eps) (thesis 4.18-4.21); `SlidingSpring`: spring and dashpot that slide at mu |F_n| (Cundall &
               Strack 1979)
   rolling     a `SlidingSpring` against rolling, of stiffness 0 where there is none

   A Number is a double, or a vector of them: both sides of a choice are then taken. The tensile tail of the normal force is
   kept. lammps_jump/physics/law.py states the same law and shares no line with this; tests compare the two. */

#ifndef JUMP_CORE_LAW_H
#define JUMP_CORE_LAW_H

#include "contact/elementary.h"

#include <type_traits>

namespace jump {

// --- the numbers of a law -----------------------------------------------------------------------------------------

/* Of two discs, or of a disc and a wall, in SI units and per m of width. core/law.py has the same names in the same order
   and says what they are; they are compared where the core is loaded. `damping` and `tangential` are of a size of 1 m where
   discs have radii of their own. */
#define JUMP_LAW(NUMBER) \
  NUMBER(stiffness) NUMBER(damping) NUMBER(tangential) NUMBER(friction) NUMBER(sign_ramp) NUMBER(touch) NUMBER(cohesion) \
  NUMBER(spring_ratio) NUMBER(spring_damping) NUMBER(rolling) NUMBER(rolling_damping) NUMBER(rolling_friction)

struct LawNumbers {
#define JUMP_NUMBER(name) double name = 0.0;
  JUMP_LAW(JUMP_NUMBER)
#undef JUMP_NUMBER
};

/** Numbers of one contact: those of its law, with its own dashpot and slope of the viscous ramp. */
template <class Number> struct Numbers {
  LawNumbers law;
  Number damping, ramp;
};

/** Numbers of contacts of a size of 1 m, or of equal discs; as many as `like` has lanes. */
template <class Number> inline Numbers<Number> numbers_of(const LawNumbers &law, const Number &like)
{
  return {law, spread(law.damping, like), spread(law.tangential, like)};
}

// --- normal: force of spring and attraction, their energy, and what of a push presses the two together ------------

/** Friction is bounded by the normal force without the attraction, which the spring holds (Derjaguin, Muller & Toporov
    1975). */
struct Attraction {
  template <class Number> Number pressing(const LawNumbers &of, const Number &push) const { return push + of.cohesion; }
};

/** Stiffness of the spring along the normal, N/m. */
inline double spring_of(const LawNumbers &of) { return of.stiffness; }

struct Spring : Attraction {
  template <class Number> Number force(const LawNumbers &of, const Number &overlap) const
  {
    return spring_of(of) * overlap - of.cohesion;
  }
  template <class Number> Number energy(const LawNumbers &of, const Number &overlap) const
  {
    return spring_of(of) * (0.5 * overlap * overlap) - of.cohesion * overlap;
  }
};

struct SmoothSpring : Attraction {
  template <class Number> Number force(const LawNumbers &of, const Number &overlap) const
  {
    const double k = spring_of(of), width = of.touch;
    return (overlap < width ? 0.5 * k * overlap * overlap / width : k * (overlap - 0.5 * width)) - of.cohesion;
  }
  template <class Number> Number energy(const LawNumbers &of, const Number &overlap) const
  {
    const double k = spring_of(of), width = of.touch;
    return k * (overlap < width ? overlap * overlap * overlap / (6.0 * width)
                                : 0.5 * (overlap * overlap - width * overlap + width * width / 3.0)) - of.cohesion * overlap;
  }
};

// --- damping: force of the dashpot at this speed of parting ----------------------------------------------------------

struct Dashpot {
  template <class Number> Number force(const Numbers<Number> &of, const Number &opening, const Number &) const
  {
    return -of.damping * opening;
  }
};

struct SmoothDashpot {
  template <class Number> Number force(const Numbers<Number> &of, const Number &opening, const Number &overlap) const
  {
    const double width = of.law.touch;
    const Number plain = -of.damping * opening, beyond = overlap - 0.5 * width;
    return overlap < width ? plain * root(0.75 * overlap / width)
                           : plain * beyond / root(beyond * beyond + width * width / 12.0);
  }
};

// --- tangential: force along (-ny, nx) at this slip ------------------------------------------------------------------

/** What a contact with memory holds: elongations of its springs, m, which go on. */
template <class Number> struct Stretch {
  Number slide, roll;
};

struct NoFriction {
  static constexpr bool HAS_FRICTION = false, HAS_HISTORY = false;
};

struct Ramp {
  static constexpr bool HAS_FRICTION = true, HAS_HISTORY = false;

  template <class Number> Number force(const Numbers<Number> &of, const Number &normal, const Number &slip) const
  {
    const Number bound = of.law.friction * magnitude(normal);
    return least(most(-of.ramp * slip, -bound), bound);
  }
};

struct Sign {
  static constexpr bool HAS_FRICTION = true, HAS_HISTORY = false;
  double slope;    // 1/eps of this step, s/m

  template <class Number> Number force(const Numbers<Number> &of, const Number &normal, const Number &slip) const
  {
    const Number bound = of.law.friction * magnitude(normal), one = spread(1.0, slip);
    return -bound * least(most(slip * slope, -one), one);
  }
};

/** A spring and dashpot that slides at a bound; the stretch keeps what the bound leaves of it (Luding 2008, eq. 21). */
template <class Number>
inline Number slide(Number &stretch, const Number &slip, const Number &bound, double k, const Number &damping)
{
  const Number force = -k * stretch - damping * slip;
  const Number held = force > 0.0 ? bound : -bound;
  const Number left = k > 0.0 ? -(held + damping * slip) / k : spread(0.0, slip);
  const auto over = magnitude(force) > bound;
  stretch = over ? left : stretch;
  return over ? held : force;
}

struct SlidingSpring {
  static constexpr bool HAS_FRICTION = true, HAS_HISTORY = true;
  double time_step;    // s; 0: springs stay as they are

  template <class Number>
  Number force(const Numbers<Number> &of, const Number &normal, const Number &slip, Stretch<Number> &held) const
  {
    const LawNumbers &law = of.law;
    held.slide = held.slide + slip * time_step;
    return slide(held.slide, slip, law.friction * magnitude(normal), law.spring_ratio * law.stiffness,
                 law.spring_damping * of.damping);
  }

  /** The force against rolling at this speed of the rims; the spring of stiffness 0 gives none. */
  template <class Number>
  Number against_rolling(const LawNumbers &of, const Number &normal, const Number &turn, Stretch<Number> &held) const
  {
    if (!(of.rolling > 0.0)) return spread(0.0, turn);
    held.roll = held.roll + turn * time_step;
    return slide(held.roll, turn, of.rolling_friction * magnitude(normal), of.rolling, spread(of.rolling_damping, turn));
  }
};

/** A law: one struct of each slot. */
template <class Normal, class Damping, class Tangential> struct LawOfSlots {
  Normal normal;
  Damping damping;
  Tangential tangential;
  using Friction = Tangential;
};

/** Which struct of each slot, and what of it is of a step. */
struct Choice {
  enum Tangential { NONE, RAMP, SIGN, SLIDER } tangential = NONE;
  bool smooth = false;        // touch
  double slope = 0.0;         // of the sign law, s/m
  double time_step = 0.0;     // of springs, s; 0: they stay as they are

  bool has_friction() const { return tangential != NONE; }
};

/** What these numbers ask for; `remembers`: contacts have springs with memory. A new formula is chosen here alone. */
inline Choice choice_of(const LawNumbers &of, bool remembers, double slope, double time_step)
{
  const auto tangential = remembers                    ? Choice::SLIDER
                          : of.friction != of.friction ? Choice::NONE
                          : of.sign_ramp > 0.0         ? Choice::SIGN
                                                       : Choice::RAMP;
  return {tangential, of.touch > 0.0, slope, time_step};
}

/** Calls run(law) with this friction and a touch that is smooth or sharp. */
template <class Tangential, class Run> inline void with_touch(bool smooth, const Tangential &tangential, const Run &run)
{
  if (smooth) run(LawOfSlots<SmoothSpring, SmoothDashpot, Tangential>{{}, {}, tangential});
  else run(LawOfSlots<Spring, Dashpot, Tangential>{{}, {}, tangential});
}

/** Calls run(law) with the law of these numbers without its friction: what acts along the normal. */
template <class Run> inline void with_normal(const LawNumbers &of, const Run &run)
{
  with_touch(of.touch > 0.0, NoFriction{}, run);
}

/** Calls run(law) with the law that is chosen. */
template <class Run> inline void with_slots(const Choice &choice, const Run &run)
{
  switch (choice.tangential) {
    case Choice::NONE: return with_touch(choice.smooth, NoFriction{}, run);
    case Choice::RAMP: return with_touch(choice.smooth, Ramp{}, run);
    case Choice::SIGN: return with_touch(choice.smooth, Sign{choice.slope}, run);
    case Choice::SLIDER: return with_touch(choice.smooth, SlidingSpring{choice.time_step}, run);
  }
}

/** Calls run(sizes, spin) with two integral constants; without friction nothing turns. */
template <class Run> inline void with_kind(const Choice &choice, bool sizes, bool spin, const Run &run)
{
  const auto sized = [&](auto turns) {
    if (sizes) run(std::true_type{}, turns);
    else run(std::false_type{}, turns);
  };
  if (spin && choice.has_friction()) sized(std::true_type{});
  else sized(std::false_type{});
}

/** Whether there are such contacts. */
template <class Law, bool SPIN> constexpr bool IS_KIND = Law::Friction::HAS_FRICTION || !SPIN;

/** Calls run(law, sizes, spin) with the law that is chosen and the constants of `with_kind`. */
template <class Run> inline void with_law(const Choice &choice, bool sizes, bool spin, const Run &run)
{
  with_slots(choice, [&](const auto &law) {
    with_kind(choice, sizes, spin, [&](auto own_sizes, auto turns) {
      if constexpr (IS_KIND<std::decay_t<decltype(law)>, decltype(turns)::value>) run(law, own_sizes, turns);
    });
  });
}

}    // namespace jump

#endif
