// SPDX-License-Identifier: GPL-2.0-or-later
/* The law of one kind of contact as the styles of the plugin are told it, and as the core takes it (core/law.h).

   The styles have dashpots as rates, of nominal discs: c = m_eff gamma. The core has c, of a size of 1 m where discs have
   radii of their own: c of a contact goes by the root of its effective mass, and masses grow as R^2. */

#ifndef JUMP_DISC_LAW_H
#define JUMP_DISC_LAW_H

#include "contact.h"

namespace jump {

/** Share of the largest speed inside which the sign law is a ramp (thesis 4.21). */
constexpr double SIGN_RAMP = 0.01;

/** 1/eps of the sign law, s/m; where nothing moves it is the limit of the law. */
inline double sign_slope(double largest_speed)
{
  const double eps = SIGN_RAMP * largest_speed;
  return eps > 1e-300 ? 1.0 / eps : 1e300;
}

/** Springs with memory, over the stiffness and dashpot of a contact of nominal discs. */
struct Springs {
  bool there = false;
  double ratio = 0.0, rolling = 0.0, rolling_damping = 0.0, rolling_friction = 0.0;
};

struct DiscLaw {
  Numbers<double> of{};
  Rolling rolling;
  Choice choice{Choice::NONE, 0.0, 0.0, {}, 0.0};

  DiscLaw() = default;

  /** `mass` is the effective one of nominal discs, `size` their size, or 1 m where discs are equal. */
  DiscLaw(double k, double gamma, double gamma_t, double mu, double mass, double size, bool sign, double width,
          double pull, const Springs &springs, double rolling_friction)
      : of{k, mass * gamma / size, mass * gamma_t / size, mu},
        rolling{springs.rolling * k, springs.rolling_damping * mass * gamma, rolling_friction}
  {
    const bool rubs = mu > 0.0 && (sign || gamma_t > 0.0);
    choice.tangential = springs.there ? Choice::SLIDER : !rubs ? Choice::NONE : sign ? Choice::SIGN : Choice::RAMP;
    choice.width = width;
    choice.pull = pull;
    choice.slider = {springs.ratio, gamma > 0.0 ? gamma_t / gamma : 0.0, 0.0};
  }
};

}    // namespace jump

#endif
