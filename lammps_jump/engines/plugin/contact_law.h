// SPDX-License-Identifier: GPL-2.0-or-later
/* Contact of discs in two dimensions: the force laws, one place for pairs and for walls.

   Symbols: d = sum of the two radii (a wall has none), r = distance of the centres (or of centre and surface),
   delta = d - r overlap, k stiffness, m_eff effective mass (m/2 pair, m wall), v relative velocity of the disc
   against its partner, n unit vector towards the disc, gamma (1/s) damping rate, mu friction coefficient.

   normal     F_n = k delta - m_eff gamma_n (v.n)                 thesis T-4359 (3.11); LAMMPS gran/hooke
   viscous    F_t = min(mu |F_n|, m_eff gamma_t |v_t|)            LAMMPS gran/hooke, opposite to v_t
   sign       F_t = mu |F_n| min(1, |v_t| / eps), eps = v_max/100 thesis (4.18)-(4.21), opposite to v_t
   history    F_t = -kt s - ct v_t with a spring s that grows by v_t dt; held at mu |F_n|, where s keeps what is left of it
              (Cundall & Strack 1979; Luding 2008, eq. 21); rolling resistance is such a spring against rolling
   smooth     k delta -> F = k delta^2/(2 s) below delta = s, k (delta - s/2) beyond; E(delta) its energy; the dashpot
              times F / sqrt(2 k E): in z = sqrt(2 E / k) and the time that runs with dz/ddelta the contact is then
              the linear one, so that restitution is the same at every speed and width (derived in docs/kernels.md)

   Discs of several sizes: the dashpots of a contact go by the root of its effective mass, m_eff gamma = c sqrt(m_eff),
   so that every contact has the same restitution. Masses grow as R^2: c of a pair is that of two nominal discs times
   sqrt(2) R_i R_j / (R sqrt(R_i^2 + R_j^2)), c at a wall that of the nominal disc times R_i / R. With a fixed disc
   m_eff is the mass of the other.

   lammps_jump/physics/law.py holds the same law for the native engine; tests compare the two.

   The tensile tail of F_n is kept, as the thesis keeps it. Every branch is a template argument: a scene pays for
   nothing it lacks. The order of the operations follows gran/hooke, so that results agree with it to round-off
   (compile with contraction off: a fused multiply-add would round differently). A Number is a double (walls) or
   eight of them (pairs, lanes.h). */

#ifndef JUMP_CONTACT_LAW_H
#define JUMP_CONTACT_LAW_H

#include "lanes.h"

#include <cmath>
#include <type_traits>

namespace jump {

enum class Friction { NONE, VISCOUS, VISCOUS_SPIN, SIGN, SIGN_SPIN, SPRING, SPRING_SPIN };

enum class Touch { SHARP, SMOOTH };

constexpr bool has_friction(Friction f) { return f != Friction::NONE; }
constexpr bool has_spin(Friction f) 
{
  return f == Friction::VISCOUS_SPIN || f == Friction::SIGN_SPIN || f == Friction::SPRING_SPIN;
}
constexpr bool is_sign(Friction f) { return f == Friction::SIGN || f == Friction::SIGN_SPIN; }

constexpr bool has_springs(Friction f) { return f == Friction::SPRING || f == Friction::SPRING_SPIN; }

/** Share of the largest speed inside which the sign law is a ramp (thesis 4.21). */
constexpr double SIGN_RAMP = 0.01;

/** Numbers of one kind of contact, SI; of nominal discs where discs are of several sizes. */
struct Law {
  double k = 0.0;           // stiffness, N/m
  double damping = 0.0;     // m_eff gamma_n, N s/m
  double tangential = 0.0;  // m_eff gamma_t, N s/m
  double mu = 0.0;          // mu
  double reach = 0.0;       // distance at touch, m
  double width = 0.0;       // s of the smooth touch, m, and 1/s
  double inverse_width = 0.0;
  double eps = 0.0;         // slip speed of the sign law now, m/s
  double kt = 0.0;          // tangential spring, N/m
  double kr = 0.0, gr = 0.0, mur = 0.0;    // rolling spring, N/m and N s/m, and its friction coefficient
  double dt = 0.0;          // time step, s; 0: springs stay as they are
};

/** Springs with memory, over the stiffness and dashpot of a contact of nominal discs. */
struct Springs {
  bool there = false;
  double ratio = 0.0, rolling = 0.0, rolling_damping = 0.0, rolling_friction = 0.0;

  void put(Law &law, double friction) const
  {
    law.kt = ratio * law.k;
    law.kr = rolling * law.k;
    law.gr = rolling_damping * law.damping;
    law.mur = friction;
  }
};

inline Law make_law(double k, double gamma, double gamma_t, double mu, double m_eff, double reach, double width)
{
  return {k, m_eff * gamma, m_eff * gamma_t, mu, reach, width, width > 0.0 ? 1.0 / width : 0.0, 0.0};
}

/** What a contact has of its own where discs are of several sizes; named as in Law, which stands for it elsewhere. */
template <class Number> struct OwnLaw {
  Number reach, damping, tangential;
};

/** Radius that stands for the mass of a fixed disc, m: its square is still a number. */
constexpr double HUGE_RADIUS = 1e150;

/** Of pairs of discs with a distance at touch and radii that stand for their masses. */
template <class Number> inline OwnLaw<Number> own_law(const Law &law, const Number &reach, const Number &one, const Number &two)
{
  const Number share = one * two * (2.0 * M_SQRT2 / law.reach) / root(one * one + two * two);
  return {reach, law.damping * share, law.tangential * share};
}

/** Of a wall and a disc of this radius. */
inline OwnLaw<double> own_law(const Law &law, double radius)
{
  const double share = radius / law.reach;
  return {radius, law.damping * share, law.tangential * share};
}

inline Friction friction_of(double mu, double gamma_t, bool sign, bool spin, bool springs)
{
  if (springs) return spin ? Friction::SPRING_SPIN : Friction::SPRING;
  if (!(mu > 0.0 && (sign || gamma_t > 0.0))) return Friction::NONE;
  if (sign) return spin ? Friction::SIGN_SPIN : Friction::SIGN;
  return spin ? Friction::VISCOUS_SPIN : Friction::VISCOUS;
}

template <class Number> struct ContactForce {
  Number fx, fy;            // on the disc, N
  Number twist;             // tangential force times its sense: moment on the disc is -(lever) * twist
  Number overlap;
};

/** Springs of a contact: elongations (m), which grow; speed of rolling (m/s); and the force against rolling. */
template <class Number> struct Stretch {
  Number slide, roll, turn, resist;
};

/** Force of a spring and dashpot that slides at a bound; the spring keeps what the bound leaves of it. */
template <class Number>
inline Number slide(Number &stretch, const Number &slip, const Number &bound, double k, const Number &damping)
{
  const Number dash = damping * slip;
  const Number force = -k * stretch - dash;
  const Number limited = force > 0.0 ? bound : -bound;
  const Number kept = -(limited + dash) * (k > 0.0 ? 1.0 / k : 0.0);
  const auto over = magnitude(force) > bound;
  stretch = over ? kept : stretch;
  return over ? limited : force;
}

/** Force on a disc whose centre lies at (dx, dy) from its partner's; (vx, vy) is its relative velocity.

    rim is R_i omega_i + R_j omega_j, the speed of the rims at the contact; own is an OwnLaw, or law where discs are
    equal. */
template <Friction FRICTION, Touch TOUCH, class Own, class Number>
inline ContactForce<Number> contact_force(const Law &law, const Own &own, const Number &dx, const Number &dy,
                                          const Number &vx, const Number &vy, const Number &rim,
                                          Stretch<Number> *held = nullptr)
{
  ContactForce<Number> out;
  const Number rsq = dx * dx + dy * dy;
  const Number r = root(rsq);
  const Number rinv = 1.0 / r;
  const Number rsqinv = rinv * rinv;
  const Number vnnr = vx * dx + vy * dy;
  const Number overlap = own.reach - r;
  Number damp = own.damping * vnnr * rsqinv;
  Number ccel;
  if (TOUCH != Touch::SHARP) {
    const Number share = overlap * law.inverse_width;
    const Number one = spread(1.0, rsq);
    const Number ramp = least(share, one);
    // (F / sqrt(2 k E))^2: 3 delta/(4 s) below s, q^2/(q^2 + s^2/12) with q = delta - s/2 beyond
    const Number q = overlap - 0.5 * law.width;
    const Number beyond = q * q / (q * q + law.width * law.width / 12.0);
    const Number squared = share < one ? 0.75 * share : beyond;
    damp *= root(squared);
    // both branches in one: k (overlap - s ramp/2) ramp is k delta^2/(2 s) below s and k (delta - s/2) beyond
    const Number spring = law.k * ramp * (overlap - 0.5 * law.width * ramp);
    ccel = spring * rinv - damp;
  } else {
    ccel = law.k * overlap * rinv - damp;
  }
  out.overlap = overlap;
  out.fx = dx * ccel;
  out.fy = dy * ccel;
  out.twist = spread(0.0, rsq);
  if constexpr (has_springs(FRICTION)) {
    const Number slip = (vy * dx - vx * dy) * rinv - rim;
    const Number normal = magnitude(ccel * r);
    held->slide += slip * law.dt;
    out.twist = slide(held->slide, slip, law.mu * normal, law.kt, spread(own.tangential, slip));
    out.fx -= out.twist * dy * rinv;
    out.fy += out.twist * dx * rinv;
    held->resist = spread(0.0, rsq);
    if (has_spin(FRICTION) && law.kr > 0.0) {
      held->roll += held->turn * law.dt;
      held->resist = slide(held->roll, held->turn, law.mur * normal, law.kr, spread(law.gr, slip));
    }
  } else if (has_friction(FRICTION)) {
    Number vtx = vx - dx * vnnr * rsqinv;
    Number vty = vy - dy * vnnr * rsqinv;
    if (has_spin(FRICTION)) {
      const Number wr = rim * rinv;
      vtx += dy * wr;
      vty -= dx * wr;
    }
    const Number slip = root(vtx * vtx + vty * vty);
    const Number coulomb = law.mu * magnitude(ccel * r);
    Number rate;    // friction force per slip speed
    if (is_sign(FRICTION)) {
      rate = coulomb / most(slip, spread(law.eps > 1e-300 ? law.eps : 1e-300, slip));
    } else {
      rate = least(coulomb / most(slip, spread(1e-300, slip)), spread(own.tangential, slip));
    }
    const Number fsx = -rate * vtx;
    const Number fsy = -rate * vty;
    out.fx += fsx;
    out.fy += fsy;
    out.twist = rinv * (dx * fsy - dy * fsx);
  }
  return out;
}

/** Call run(friction, touch) with the two that are in use as types, whose `value` a template can take. */
template <class Run> inline void with_branch(Friction friction, Touch touch, const Run &run)
{
  auto with = [&](auto f) {
    if (touch == Touch::SHARP) run(f, std::integral_constant<Touch, Touch::SHARP>{});
    else run(f, std::integral_constant<Touch, Touch::SMOOTH>{});
  };
  switch (friction) {
    case Friction::NONE: with(std::integral_constant<Friction, Friction::NONE>{}); break;
    case Friction::VISCOUS: with(std::integral_constant<Friction, Friction::VISCOUS>{}); break;
    case Friction::VISCOUS_SPIN: with(std::integral_constant<Friction, Friction::VISCOUS_SPIN>{}); break;
    case Friction::SIGN: with(std::integral_constant<Friction, Friction::SIGN>{}); break;
    case Friction::SIGN_SPIN: with(std::integral_constant<Friction, Friction::SIGN_SPIN>{}); break;
    case Friction::SPRING: with(std::integral_constant<Friction, Friction::SPRING>{}); break;
    case Friction::SPRING_SPIN: with(std::integral_constant<Friction, Friction::SPRING_SPIN>{}); break;
  }
}

}    // namespace jump

#endif
