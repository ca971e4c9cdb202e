// SPDX-License-Identifier: GPL-2.0-or-later
/* Kick and drift of discs, and the work of dashpots and friction over the kick. */

#include "contact/simd.h"    // before the core: its templates take vectors

#include "step/integrate.h"

#include <algorithm>

namespace jump {

constexpr int CHAINS = 4;    // sums and maxima that run beside each other: the ledger's last digits are those of this order

double fastest(const ContactVelocities &seen, int64_t begin, int64_t end)
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
  Dissipated taken{power<SIZES>(s, begin, end, s.dashpot_x, s.dashpot_y, 0.5 * kick), 0.0, 0.0};
  if (!s.friction_x) return taken;
  taken.friction = power<SIZES>(s, begin, end, s.friction_x, s.friction_y, 0.5 * kick);
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

/** Numbers from a place of an array: one, or four. */
static double &numbers(double, double *from) { return *from; }
static AnyFour &numbers(const Four &, double *from) { return *reinterpret_cast<AnyFour *>(from); }
static double numbers(double, const double *from) { return *from; }
static Four numbers(const Four &, const double *from) { return four(from); }

/** How many of them are not at most `limit`; NaN is not. */
static int64_t beyond(double x, double limit) { return !(x <= limit); }
static int64_t beyond(const Four &x, double limit) { return 4 - __builtin_popcount(bits(x <= limit)); }

static void put_row(double x, double y, double vx, double vy, double (*rows)[4])
{
  const double row[] = {x, y, vx, vy};
  std::copy_n(row, 4, *rows);
}
static void put_row(const Four &x, const Four &y, const Four &vx, const Four &vy, double (*rows)[4])
{
  rows_of_four(x, y, vx, vy, rows);
}

/** Calls run(kind, i) from `begin` to `end`: with a Four for four discs at a time, with a double for the rest. */
template <class Run> static void each_four(int64_t begin, int64_t end, const Run &run)
{
  int64_t i = begin;
  for (; i + 4 <= end; i += 4) run(Four{}, i);
  for (; i < end; i++) run(0.0, i);
}

void show(const jump_state &s, int64_t begin, int64_t end, double (*rows)[4])
{
  const double *const x = s.x, *const y = s.y, *const vx = s.ux ? s.ux : s.vx, *const vy = s.ux ? s.uy : s.vy;
  each_four(begin, end, [=](const auto &kind, int64_t i) {
    put_row(numbers(kind, x + i), numbers(kind, y + i), numbers(kind, vx + i), numbers(kind, vy + i), rows + i);
  });
}

template <bool SIZES, bool EXTRA>
static int64_t kick_drift(const jump_state &s, int64_t begin, int64_t end, double kick, double (*rows)[4])
{
  const double dt = s.time_step, weight_x = s.weight_x, weight_y = s.weight_y, reach2 = s.reach2;
  double *const x = s.x, *const y = s.y, *const vx = s.vx, *const vy = s.vy, *const fx = s.fx, *const fy = s.fy;
  double *const ux = s.ux, *const uy = s.uy;
  const double *const x0 = s.x0, *const y0 = s.y0, *const radius = s.radius;
  int64_t moved = 0;
  each_four(begin, end, [=, &moved](const auto &kind, int64_t i) {
    using Number = std::decay_t<decltype(kind)>;
    const Number old_x = numbers(kind, vx + i), old_y = numbers(kind, vy + i);
    Number each = kick - Number{}, fall_x = weight_x - Number{}, fall_y = weight_y - Number{};
    if constexpr (SIZES) {
      const Number own = numbers(kind, radius + i), square = own * own;
      each = kick / square;
      fall_x = weight_x * square;
      fall_y = weight_y * square;
    }
    const Number new_x = old_x + each * numbers(kind, fx + i), new_y = old_y + each * numbers(kind, fy + i);
    numbers(kind, vx + i) = new_x;
    numbers(kind, vy + i) = new_y;
    Number seen_x = new_x, seen_y = new_y;
    if constexpr (EXTRA) {
      numbers(kind, ux + i) = seen_x = 1.5 * new_x - 0.5 * old_x;
      numbers(kind, uy + i) = seen_y = 1.5 * new_y - 0.5 * old_y;
    }
    const Number px = numbers(kind, x + i) + dt * new_x, py = numbers(kind, y + i) + dt * new_y;
    numbers(kind, x + i) = px;
    numbers(kind, y + i) = py;
    numbers(kind, fx + i) = fall_x;
    numbers(kind, fy + i) = fall_y;
    put_row(px, py, seen_x, seen_y, rows + i);
    const Number dx = px - numbers(kind, x0 + i), dy = py - numbers(kind, y0 + i);
    moved += beyond(dx * dx + dy * dy, reach2);
  });
  return moved;
}

template <bool SIZES, bool EXTRA>
static int64_t drift_kind(const jump_state &s, int64_t begin, int64_t end, Dissipated *taken, double (*rows)[4])
{
  const double kick = s.time_step / s.mass;
  int64_t moved = 0;
  for (int64_t from = begin; from < end; from += BLOCK) {    // all that is done with a block, while it is in the cache
    const int64_t to = std::min(from + BLOCK, end);
    if (s.dashpot_x) taken[from / BLOCK] = taken_of<SIZES>(s, from, to, kick);
    if (s.omega) kick_spin<SIZES, EXTRA>(s, from, to);
    moved += kick_drift<SIZES, EXTRA>(s, from, to, kick, rows);
  }
  return moved;
}

int64_t drift(const jump_state &s, int64_t begin, int64_t end, Dissipated *taken, double (*rows)[4])
{
  if (s.radius)
    return s.ux ? drift_kind<true, true>(s, begin, end, taken, rows) : drift_kind<true, false>(s, begin, end, taken, rows);
  return s.ux ? drift_kind<false, true>(s, begin, end, taken, rows) : drift_kind<false, false>(s, begin, end, taken, rows);
}

}    // namespace jump
