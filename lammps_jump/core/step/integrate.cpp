// SPDX-License-Identifier: GPL-2.0-or-later
/* Kick and drift of discs, and the work of dashpots and friction over the kick. */

#include "contact/simd.h"    // before the core: its templates take vectors

#include "step/integrate.h"

#include <algorithm>

namespace jump {

constexpr int CHAINS = 4;    // sums and maxima that run in parallel: the ledger's last digits are those of this order

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

double fastest(const double (*at)[4], int64_t begin, int64_t end)
{
  double found = 0.0;
  for (int64_t i = begin; i < end; i++) found = most(at[i][2] * at[i][2] + at[i][3] * at[i][3], found);
  return found;
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

static double fourth(double radius) { return (radius * radius) * (radius * radius); }

/** Sum of torque (omega + half torque / R^4) over the discs. */
template <bool SIZES> static double power_of_torque(const jump_state &s, int64_t begin, int64_t end, double half)
{
  const double *const __restrict torque = s.torque, *const __restrict omega = s.omega, *const __restrict radius = s.radius;
  return sum_over(begin, end, [=](int64_t i) {
    return torque[i] * (omega[i] + (SIZES ? half / fourth(radius[i]) : half) * torque[i]);
  });
}

/** Numbers at a place of an array: one, or four; to be written, and read. */
static double &numbers(double, double *from) { return *from; }
static AnyFour &numbers(const Four &, double *from) { return *reinterpret_cast<AnyFour *>(from); }
static double read(double, const double *from) { return *from; }
static Four read(const Four &, const double *from) { return four(from); }

/** How many of them are not at most `limit`; NaN is not. */
static int64_t beyond(double x, double limit) { return !(x <= limit); }
static int64_t beyond(const Four &x, double limit) { return 4 - __builtin_popcount(bits(x <= limit)); }

/** One whole kick a step; lists hold as long as no disc has gone further than half the skin. */
class WholeKicks {
 public:
  int64_t moved = 0;

  explicit WholeKicks(const jump_state &s) : s(s), reach2(s.reach2) {}

  template <class Number> static Number kicked(const Number &old, const Number &each, const Number &, const Number &force)
  {
    return old + each * force;
  }
  template <class Number> void see(int64_t i, const Number &px, const Number &py, const Number &, const Number &)
  {
    const Number dx = px - read(px, s.x0 + i), dy = py - read(py, s.y0 + i);
    moved += beyond(dx * dx + dy * dy, reach2);
  }

 private:
  const jump_state &s;
  const double reach2;
};

/** Two half kicks, or the second of them alone. */
template <bool BOTH> struct HalfKicks {
  template <class Number> static Number kicked(const Number &old, double, double half, const Number &force)
  {
    const Number push = half * force;
    return BOTH ? (old + push) + push : old + push;
  }
};

template <bool SIZES, bool EXTRA, class Kicks> static void kick_spin(const jump_state &s, int64_t begin, int64_t end, const Kicks &kicks)
{
  const double turn = s.time_step / s.inertia;
  double *const __restrict omega = s.omega, *const __restrict torque = s.torque, *const __restrict uomega = s.uomega;
  const double *const __restrict radius = s.radius;
  for (int64_t i = begin; i < end; i++) {
    const double old = omega[i], each = SIZES ? turn / fourth(radius[i]) : turn, now = kicks.kicked(old, each, 0.5 * each, torque[i]);
    omega[i] = now;
    torque[i] = 0.0;
    if constexpr (EXTRA) uomega[i] = 1.5 * now - 0.5 * old;
  }
}

/** Four columns of a row of one disc, or of those of four. */
template <class Number> struct RowColumns {
  Number of[4];
};
static void put_row(const RowColumns<double> &from, double (*row)[4]) { std::copy_n(from.of, 4, *row); }
static void put_row(const RowColumns<Four> &from, double (*rows)[4])
{
  rows_of_four(from.of[0], from.of[1], from.of[2], from.of[3], rows);
}
static RowColumns<double> columns(double, const double (*row)[4]) { return {{(*row)[0], (*row)[1], (*row)[2], (*row)[3]}}; }
static RowColumns<Four> columns(const Four &, const double (*rows)[4])
{
  RowColumns<Four> out;
  transpose4(four(rows[0]), four(rows[1]), four(rows[2]), four(rows[3]), out.of);
  return out;
}

/** Calls run(kind, i) from `begin` to `end`: with a Four for four discs at a time, with a double for the rest. */
template <class Run> static void each_four(int64_t begin, int64_t end, const Run &run)
{
  int64_t i = begin;
  for (; i + 4 <= end; i += 4) run(Four{}, i);
  for (; i < end; i++) run(0.0, i);
}

void load(const jump_state &s, int64_t begin, int64_t end, const StepRows &rows)
{
  const double *const vx = s.ux ? s.ux : s.vx, *const vy = s.ux ? s.uy : s.vy;
  each_four(begin, end, [&](const auto &kind, int64_t i) {
    using Number = std::decay_t<decltype(kind)>;
    const auto from = [&](const double *array) { return array ? read(kind, array + i) : Number{}; };
    put_row(RowColumns<Number>{{from(s.x), from(s.y), from(vx), from(vy)}}, rows.at + i);
    put_row(RowColumns<Number>{{from(s.fx), from(s.fy), from(s.dashpot_x), from(s.dashpot_y)}}, rows.forces + i);
  });
}

void store(const jump_state &s, int64_t begin, int64_t end, const StepRows &rows)
{
  double *const of_place[] = {s.x, s.y, s.ux ? s.ux : s.vx, s.ux ? s.uy : s.vy};
  double *const of_force[] = {s.fx, s.fy, s.dashpot_x, s.dashpot_y};
  each_four(begin, end, [&](const auto &kind, int64_t i) {
    const auto places = columns(kind, rows.at + i), forces = columns(kind, rows.forces + i);
    for (int c = 0; c < 4; c++) {
      numbers(kind, of_place[c] + i) = places.of[c];
      if (of_force[c]) numbers(kind, of_force[c] + i) = forces.of[c];
    }
  });
}

/** Sums of four chains; one further disc is of the first. */
static void add_to(Four &chains, const Four &terms) { chains += terms; }
static void add_to(Four &chains, double term) { chains[0] += term; }
static double sum_of(const Four &chains) { return (chains[0] + chains[1]) + (chains[2] + chains[3]); }

/** What a force of 1 N gives in a step and in half of one, m/s, and the weight of a disc, N; all per m of width. */
template <class Number> struct ByMass {
  Number each, half, fall_x, fall_y;
};
template <bool SIZES, class Number> static ByMass<Number> by_mass(const jump_state &s, const Number &kind, int64_t i)
{
  const double kick = s.time_step / s.mass;
  if constexpr (SIZES) {
    const Number own = read(kind, s.radius + i), square = own * own;
    return {kick / square, 0.5 * kick / square, s.weight_x * square, s.weight_y * square};
  } else {
    const Number zero{};
    return {kick - zero, 0.5 * kick - zero, s.weight_x - zero, s.weight_y - zero};
  }
}

/** Kick and drift of a block. LEDGER: `dissipated` gets what dashpots and friction take over the whole kick: v_n is the mean of the
    velocities around it. */
template <bool SIZES, bool EXTRA, bool LEDGER, class Kicks>
static void kick_drift(const jump_state &s, int64_t begin, int64_t end, const StepRows &rows, double (*next)[4], Dissipated *dissipated, Kicks &kicks)
{
  const double dt = s.time_step;
  double *const friction_x = s.friction_x, *const friction_y = s.friction_y;
  Four dashpots{}, friction{};
  each_four(begin, end, [&](const auto &kind, int64_t i) {
    using Number = std::decay_t<decltype(kind)>;
    const RowColumns<Number> at = columns(kind, rows.at + i), force = columns(kind, rows.forces + i);
    const Number &fx = force.of[0], &fy = force.of[1];
    Number old_x = at.of[2], old_y = at.of[3];
    if constexpr (EXTRA) {
      old_x = read(kind, s.vx + i);
      old_y = read(kind, s.vy + i);
    }
    const auto [each, half, fall_x, fall_y] = by_mass<SIZES>(s, kind, i);
    if constexpr (LEDGER) {
      const Number mean_x = old_x + half * fx, mean_y = old_y + half * fy;
      add_to(dashpots, force.of[2] * mean_x + force.of[3] * mean_y);
      if (friction_x) {
        add_to(friction, read(kind, friction_x + i) * mean_x + read(kind, friction_y + i) * mean_y);
        numbers(kind, friction_x + i) = numbers(kind, friction_y + i) = Number{};
      }
    }
    const Number new_x = kicks.kicked(old_x, each, half, fx), new_y = kicks.kicked(old_y, each, half, fy);
    Number seen_x = new_x, seen_y = new_y;
    if constexpr (EXTRA) {
      numbers(kind, s.vx + i) = new_x;
      numbers(kind, s.vy + i) = new_y;
      seen_x = 1.5 * new_x - 0.5 * old_x;
      seen_y = 1.5 * new_y - 0.5 * old_y;
    }
    const Number px = at.of[0] + dt * new_x, py = at.of[1] + dt * new_y;
    put_row(RowColumns<Number>{{px, py, seen_x, seen_y}}, next + i);
    put_row(RowColumns<Number>{{fall_x, fall_y, Number{}, Number{}}}, rows.forces + i);
    kicks.see(i, px, py, new_x, new_y);
  });
  if constexpr (LEDGER) {
    dissipated->dashpots = sum_of(dashpots);
    dissipated->friction = sum_of(friction);
  }
}

template <bool SIZES, bool EXTRA>
static int64_t drift_kind(const jump_state &s, int64_t begin, int64_t end, Dissipated *dissipated, const StepRows &rows, double (*next)[4])
{
  WholeKicks kicks(s);
  for (int64_t from = begin; from < end; from += BLOCK) {
    const int64_t to = std::min(from + BLOCK, end);
    Dissipated *const of = dissipated + from / BLOCK;
    if (s.friction_x && s.omega) of->turning = power_of_torque<SIZES>(s, from, to, 0.5 * s.time_step / s.inertia);
    if (s.omega) kick_spin<SIZES, EXTRA>(s, from, to, kicks);
    if (s.dashpot_x) kick_drift<SIZES, EXTRA, true>(s, from, to, rows, next, of, kicks);
    else kick_drift<SIZES, EXTRA, false>(s, from, to, rows, next, of, kicks);
  }
  return kicks.moved;
}

void begin_halves(const jump_state &s, int64_t begin, int64_t end, const StepRows &rows, bool begins)
{
  for (int64_t i = begin; i < end; i++) {
    double *const force = rows.forces[i];
    put_mass(s, i, force);
    force[0] = begins ? s.weight_x * force[MASS] : s.fx[i];
    force[1] = begins ? s.weight_y * force[MASS] : s.fy[i];
  }
}

/** Disc by disc: without a ledger this takes three quarters of the time of `kick_drift`, which turns rows into columns and back. */
template <bool SIZES, bool BOTH> static SpeedRange drift_halves(const jump_state &s, int64_t begin, int64_t end, const StepRows &rows)
{
  constexpr HalfKicks<BOTH> kicks;
  if (s.omega) kick_spin<SIZES, false>(s, begin, end, kicks);
  const double dt = s.time_step;
  const Two weight = {s.weight_x, s.weight_y};
  double(*const __restrict at)[4] = rows.at, (*const __restrict forces)[4] = rows.forces;
  Two lo = {1e300, 1e300}, hi = -lo;
  for (int64_t i = begin; i < end; i++) {
    Two *const row = reinterpret_cast<Two *>(at[i]), &force = *reinterpret_cast<Two *>(forces[i]);
    const double kick = forces[i][HALF_KICK], square = forces[i][MASS];
    const Two speed = kicks.kicked(row[1], 0.0, kick, force);
    row[0] += dt * speed;
    row[1] = speed;
    force = weight * square;
    lo = speed < lo ? speed : lo;
    hi = speed > hi ? speed : hi;
  }
  return {{lo[0], lo[1]}, {hi[0], hi[1]}};
}

SpeedRange drift_by_halves(const jump_state &s, int64_t begin, int64_t end, bool both, const StepRows &rows)
{
  if (s.radius) return both ? drift_halves<true, true>(s, begin, end, rows) : drift_halves<true, false>(s, begin, end, rows);
  return both ? drift_halves<false, true>(s, begin, end, rows) : drift_halves<false, false>(s, begin, end, rows);
}

int64_t drift(const jump_state &s, int64_t begin, int64_t end, Dissipated *dissipated, const StepRows &rows, double (*next)[4])
{
  if (s.radius)
    return s.ux ? drift_kind<true, true>(s, begin, end, dissipated, rows, next) : drift_kind<true, false>(s, begin, end, dissipated, rows, next);
  return s.ux ? drift_kind<false, true>(s, begin, end, dissipated, rows, next) : drift_kind<false, false>(s, begin, end, dissipated, rows, next);
}

}    // namespace jump
