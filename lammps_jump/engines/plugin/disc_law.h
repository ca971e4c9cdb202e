// SPDX-License-Identifier: GPL-2.0-or-later
/* The law of one kind of contact as the words of the plugin's styles tell it, and as the core takes it (core/contact/law.h).

   The styles have dashpots as rates, of nominal discs: c = m_eff gamma. The core has c, of a size of 1 m where discs have
   radii of their own: c of a contact goes by the root of its effective mass, and masses grow as R^2. */

#ifndef JUMP_DISC_LAW_H
#define JUMP_DISC_LAW_H

#include "contact/contact.h"

namespace jump {

/** Share of the largest speed inside which the sign law is a ramp (thesis 4.21). */
constexpr double SIGN_RAMP = 0.01;

/** 1/eps of the sign law, s/m; where nothing moves it is the limit of the law. */
inline double sign_slope(double largest_speed)
{
  const double eps = SIGN_RAMP * largest_speed;
  return eps > 1e-300 ? 1.0 / eps : 1e300;
}

struct DiscLaw {
  LawNumbers of;
  Choice choice;

  DiscLaw() = default;

  /** `input`: the dashpots are rates, 1/s; stiffness and dashpot against rolling are over those of nominal discs. `mass` is
      the effective one of nominal discs, `size` their size, or 1 m where discs are equal. */
  DiscLaw(const LawNumbers &input, double mass, double size, bool sign, bool springs) : of(input)
  {
    const double gamma = input.damping, gamma_t = input.tangential;
    const bool rubs = input.friction > 0.0 && (sign || gamma_t > 0.0);
    choice.tangential = springs ? Choice::SLIDER : !rubs ? Choice::NONE : sign ? Choice::SIGN : Choice::RAMP;
    choice.smooth = input.touch > 0.0;
    of.damping = mass * gamma / size;
    of.tangential = mass * gamma_t / size;
    of.spring_damping = gamma > 0.0 ? gamma_t / gamma : 0.0;
    of.rolling = input.rolling * input.stiffness;
    of.rolling_damping = input.rolling_damping * mass * gamma;
  }
};

}    // namespace jump

#endif
