// SPDX-License-Identifier: GPL-2.0-or-later
/* The contact law by slots: normal, damping, tangential, rolling. A new one is one struct here.

   delta overlap (m), k stiffness (N/m), c dashpot (N s/m), mu friction coefficient; forces in N, all per m of width.

   normal      `Spring`: k delta (thesis T-4359, 3.11); `SmoothSpring` of width s: k delta^2/(2 s) below delta = s and
               k (delta - s/2) beyond; each less `pull`, a constant attraction of what touches
   damping     `Dashpot`: -c v_n; `SmoothDashpot`: times F / sqrt(2 k E), F the spring's force and E its energy, so that
               the restitution is that of the linear law at every speed and width (derived in docs/kernels.md)
   tangential  `NoFriction`; `Ramp`: min(mu |F_n|, c_t |v_t|) against the slip (LAMMPS gran/hooke); `Sign`:
               mu |F_n| sat(v_t / eps) (thesis 4.18-4.21); `Slider`: spring and dashpot that slide at mu |F_n| (Cundall &
               Strack 1979)
   rolling     a `Slider` against rolling, of stiffness 0 where there is none

   A Number is a double, or a vector of them: both sides of a choice are then taken. The tensile tail of the normal force is
   kept. lammps_jump/physics/law.py states the same law and shares no line with this; tests compare the two. */

#ifndef JUMP_CORE_LAW_H
#define JUMP_CORE_LAW_H

#include "number.h"

#include <type_traits>

namespace jump {

// --- normal: force of spring and attraction, and their energy --------------------------------------------------

struct Spring {
  double pull;    // N per m of width

  template <class Number> Number force(double k, const Number &overlap) const { return k * overlap - pull; }
  template <class Number> Number energy(double k, const Number &overlap) const
  {
    return k * (0.5 * overlap * overlap) - pull * overlap;
  }
};

struct SmoothSpring {
  double width, pull;    // s, m; N per m of width

  template <class Number> Number force(double k, const Number &overlap) const
  {
    return (overlap < width ? 0.5 * k * overlap * overlap / width : k * (overlap - 0.5 * width)) - pull;
  }
  template <class Number> Number energy(double k, const Number &overlap) const
  {
    return k * (overlap < width ? overlap * overlap * overlap / (6.0 * width)
                                : 0.5 * (overlap * overlap - width * overlap + width * width / 3.0)) - pull * overlap;
  }
};

// --- damping: force of the dashpot at this speed of parting ----------------------------------------------------------

struct Dashpot {
  template <class Number> Number force(const Number &c, const Number &opening, const Number &) const { return -c * opening; }
};

struct SmoothDashpot {
  double width;

  template <class Number> Number force(const Number &c, const Number &opening, const Number &overlap) const
  {
    const Number plain = -c * opening, beyond = overlap - 0.5 * width;
    return overlap < width ? plain * root(0.75 * overlap / width)
                           : plain * beyond / root(beyond * beyond + width * width / 12.0);
  }
};

// --- tangential: force along (-ny, nx) at this slip ------------------------------------------------------------------

/** What a contact with memory holds: elongations of its springs, m, which go on. */
template <class Number> struct Stretch {
  Number slide, roll;
};

/** Numbers of one contact: stiffness, dashpot, slope of the viscous ramp, friction coefficient. */
template <class Number> struct Numbers {
  double k;
  Number damping, ramp;
  double friction;
};

struct NoFriction {
  static constexpr bool RUBS = false, REMEMBERS = false;
};

struct Ramp {
  static constexpr bool RUBS = true, REMEMBERS = false;

  template <class Number> Number force(const Numbers<Number> &of, const Number &normal, const Number &slip) const
  {
    const Number bound = of.friction * magnitude(normal);
    return least(most(-of.ramp * slip, -bound), bound);
  }
};

struct Sign {
  static constexpr bool RUBS = true, REMEMBERS = false;
  double slope;    // 1/eps of this step, s/m

  template <class Number> Number force(const Numbers<Number> &of, const Number &normal, const Number &slip) const
  {
    const Number bound = of.friction * magnitude(normal), one = spread(1.0, slip);
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

/** The rolling spring of a contact: stiffness, dashpot, friction coefficient; stiffness 0: none. */
struct Rolling {
  double k = 0.0, damping = 0.0, friction = 0.0;
};

struct Slider {
  static constexpr bool RUBS = true, REMEMBERS = true;
  double ratio, damping;    // stiffness and dashpot over those of the contact
  double time_step;         // s; 0: springs stay as they are

  template <class Number>
  Number force(const Numbers<Number> &of, const Number &normal, const Number &slip, Stretch<Number> &held) const
  {
    held.slide = held.slide + slip * time_step;
    return slide(held.slide, slip, of.friction * magnitude(normal), ratio * of.k, damping * of.damping);
  }

  /** The force against rolling at this speed of the rims. */
  template <class Number>
  Number against_rolling(const Rolling &of, const Number &normal, const Number &turn, Stretch<Number> &held) const
  {
    if (!(of.k > 0.0)) return spread(0.0, turn);
    held.roll = held.roll + turn * time_step;
    return slide(held.roll, turn, of.friction * magnitude(normal), of.k, spread(of.damping, turn));
  }
};

/** A law: one struct of each slot. */
template <class Normal, class Damping, class Tangential> struct Law {
  Normal normal;
  Damping damping;
  Tangential tangential;
  using Friction = Tangential;
};

/** Which struct of each slot, and its numbers beside those of a contact. */
struct Choice {
  enum Tangential { NONE, RAMP, SIGN, SLIDER } tangential;
  double width;     // of a smooth touch, m; not above 0: a sharp one
  double slope;     // of the sign law, s/m
  Slider slider;
  double pull;      // attraction of what touches, N per m of width
};

/** Calls run(normal, damping) with a touch of this width, m (not above 0: a sharp one), and this attraction. */
template <class Run> inline void with_touch(double width, double pull, const Run &run)
{
  if (width > 0.0) run(SmoothSpring{width, pull}, SmoothDashpot{width});
  else run(Spring{pull}, Dashpot{});
}

/** Calls run(law) with the law that is chosen. */
template <class Run> inline void with_slots(const Choice &choice, const Run &run)
{
  const auto with = [&](const auto &tangential) {
    with_touch(choice.width, choice.pull, [&](const auto &normal, const auto &damping) {
      run(Law<std::decay_t<decltype(normal)>, std::decay_t<decltype(damping)>, std::decay_t<decltype(tangential)>>{
          normal, damping, tangential});
    });
  };
  switch (choice.tangential) {
    case Choice::NONE: return with(NoFriction{});
    case Choice::RAMP: return with(Ramp{});
    case Choice::SIGN: return with(Sign{choice.slope});
    case Choice::SLIDER: return with(choice.slider);
  }
}

/** Calls run(law, sizes, spin) with the law that is chosen and two integral constants; without friction nothing turns. */
template <class Run> inline void with_law(const Choice &choice, bool sizes, bool spin, const Run &run)
{
  with_slots(choice, [&](const auto &law) {
    const auto sized = [&](auto turns) {
      if (sizes) run(law, std::true_type{}, turns);
      else run(law, std::false_type{}, turns);
    };
    if constexpr (std::decay_t<decltype(law)>::Friction::RUBS) {
      if (spin) return sized(std::true_type{});
    }
    sized(std::false_type{});
  });
}

}    // namespace jump

#endif
