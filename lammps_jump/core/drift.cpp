// SPDX-License-Identifier: GPL-2.0-or-later
/* Kick and drift of discs, and the work of dashpots and friction over the kick. */

#include "drift.h"

#include <algorithm>

namespace jump {

constexpr int CHAINS = 4;    // sums and maxima that run beside each other: the ledger's last digits are those of this order

double fastest(const Seen &seen, int64_t begin, int64_t end)
{
  double most_of[CHAINS] = {};
  const double *const __restrict vx = seen.vx, *const __restrict vy = seen.vy;
  const auto see = [&](int64_t i, int chain) {
    most_of[chain] = most(vx[i] * vx[i] + vy[i] * vy[i], most_of[chain]);
  };
  int64_t i = begin;
  for (; i + CHAINS <= end; i += CHAINS)
    for (int chain = 0; chain < CHAINS; chain++) see(i + chain, chain);
  for (; i < end; i++) see(i, 0);
  return most(most(most_of[0], most_of[1]), most(most_of[2], most_of[3]));
}

/** Sum of term(i) over the discs of a block. */
template <class Term> static double sum_over(int64_t begin, int64_t end, const Term &term)
{
  double part[CHAINS] = {};
  int64_t i = begin;
  for (; i + CHAINS <= end; i += CHAINS)
    for (int chain = 0; chain < CHAINS; chain++) part[chain] += term(i + chain);
  for (; i < end; i++) part[0] += term(i);
  return (part[0] + part[1]) + (part[2] + part[3]);
}

/** Sum of p . (v + half f / R^2) over the discs; takes p to zero for the next step. */
template <bool SIZES>
static double power(const jump_state &s, int64_t begin, int64_t end, double *__restrict px, double *__restrict py, double half)
{
  const double *const __restrict vx = s.vx, *const __restrict vy = s.vy, *const __restrict fx = s.fx;
  const double *const __restrict fy = s.fy, *const __restrict radius = s.radius;
  const double sum = sum_over(begin, end, [=](int64_t i) {
    const double kick = SIZES ? half / (radius[i] * radius[i]) : half;
    return px[i] * (vx[i] + kick * fx[i]) + py[i] * (vy[i] + kick * fy[i]);
  });
  std::fill(px + begin, px + end, 0.0);
  std::fill(py + begin, py + end, 0.0);
  return sum;
}

static double fourth(double radius) { return (radius * radius) * (radius * radius); }

/** Sum of torque (omega + half torque / R^4) over the discs. */
template <bool SIZES> static double power_of_torque(const jump_state &s, int64_t begin, int64_t end, double half)
{
  const double *const __restrict torque = s.torque, *const __restrict omega = s.omega, *const __restrict radius = s.radius;
  return sum_over(begin, end, [=](int64_t i) {
    return torque[i] * (omega[i] + (SIZES ? half / fourth(radius[i]) : half) * torque[i]);
  });
}

/** What dashpots and friction take over the whole kick: v_n is the mean of the velocities around it. */
template <bool SIZES> static Dissipated taken_of(const jump_state &s, int64_t begin, int64_t end, double kick)
{
  Dissipated taken{power<SIZES>(s, begin, end, s.dash_x, s.dash_y, 0.5 * kick), 0.0, 0.0};
  if (!s.slide_x) return taken;
  taken.friction = power<SIZES>(s, begin, end, s.slide_x, s.slide_y, 0.5 * kick);
  if (s.omega) taken.turning = power_of_torque<SIZES>(s, begin, end, 0.5 * s.time_step / s.inertia);
  return taken;
}

template <bool SIZES, bool EXTRA> static void kick_spin(const jump_state &s, int64_t begin, int64_t end)
{
  const double turn = s.time_step / s.inertia;
  double *const __restrict omega = s.omega, *const __restrict torque = s.torque, *const __restrict uomega = s.uomega;
  const double *const __restrict radius = s.radius;
  for (int64_t i = begin; i < end; i++) {
    const double old = omega[i], now = old + (SIZES ? turn / fourth(radius[i]) : turn) * torque[i];
    omega[i] = now;
    torque[i] = 0.0;
    if constexpr (EXTRA) uomega[i] = 1.5 * now - 0.5 * old;
  }
}

template <bool SIZES, bool EXTRA> static int64_t kick_drift(const jump_state &s, int64_t begin, int64_t end, double kick)
{
  const double dt = s.time_step, weight_x = s.weight_x, weight_y = s.weight_y, reach2 = s.reach2;
  double *const __restrict x = s.x, *const __restrict y = s.y, *const __restrict vx = s.vx, *const __restrict vy = s.vy;
  double *const __restrict fx = s.fx, *const __restrict fy = s.fy, *const __restrict ux = s.ux, *const __restrict uy = s.uy;
  const double *const __restrict x0 = s.x0, *const __restrict y0 = s.y0, *const __restrict radius = s.radius;
  int64_t moved = 0;
  for (int64_t i = begin; i < end; i++) {
    const double old_x = vx[i], old_y = vy[i], square = SIZES ? radius[i] * radius[i] : 1.0;
    const double each = SIZES ? kick / square : kick;
    const double new_x = old_x + each * fx[i], new_y = old_y + each * fy[i];
    vx[i] = new_x;
    vy[i] = new_y;
    if constexpr (EXTRA) {
      ux[i] = 1.5 * new_x - 0.5 * old_x;
      uy[i] = 1.5 * new_y - 0.5 * old_y;
    }
    const double px = x[i] + dt * new_x, py = y[i] + dt * new_y;
    x[i] = px;
    y[i] = py;
    fx[i] = SIZES ? weight_x * square : weight_x;
    fy[i] = SIZES ? weight_y * square : weight_y;
    const double dx = px - x0[i], dy = py - y0[i];
    moved += !(dx * dx + dy * dy <= reach2);
  }
  return moved;
}

template <bool SIZES, bool EXTRA> static int64_t drift_kind(const jump_state &s, int64_t begin, int64_t end, Dissipated *taken)
{
  const double kick = s.time_step / s.mass;
  if (s.dash_x)
    for (int64_t at = begin; at < end; at += BLOCK)
      taken[at / BLOCK] = taken_of<SIZES>(s, at, std::min(at + BLOCK, end), kick);
  if (s.omega) kick_spin<SIZES, EXTRA>(s, begin, end);
  return kick_drift<SIZES, EXTRA>(s, begin, end, kick);
}

int64_t drift(const jump_state &s, int64_t begin, int64_t end, Dissipated *taken)
{
  if (s.radius) return s.ux ? drift_kind<true, true>(s, begin, end, taken) : drift_kind<true, false>(s, begin, end, taken);
  return s.ux ? drift_kind<false, true>(s, begin, end, taken) : drift_kind<false, false>(s, begin, end, taken);
}

}    // namespace jump
