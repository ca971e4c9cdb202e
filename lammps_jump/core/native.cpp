// SPDX-License-Identifier: GPL-2.0-or-later
/* The step of the native engine: forces of pairs and walls, kick and drift.

   Time levels. Between steps the arrays hold x_n, v_(n-1/2) and F_n. Velocity Verlet and the thesis' leap-frog differ in
   the velocity that dashpot and friction see: v_(n-1/2), or 1.5 v_(n-1/2) - 0.5 v_(n-3/2) (thesis 3.7-3.9). Where discs have
   radii of their own, constants are those of a radius of 1 m: mass and weight grow as R^2, the moment of inertia as R^4. */

#include "kinds.h"

#include <algorithm>
#include <initializer_list>

namespace jump {

constexpr int CHAINS = 4;    // sums and maxima that run beside each other: the ledger's last digits are those of this order

double slope_of(const jump_state &s, const Seen &seen)
{
  double most_of[CHAINS] = {};
  const double *const __restrict vx = seen.vx, *const __restrict vy = seen.vy;
  const auto see = [&](int64_t i, int chain) {
    most_of[chain] = most(vx[i] * vx[i] + vy[i] * vy[i], most_of[chain]);
  };
  int64_t i = 0;
  for (; i + CHAINS <= s.n; i += CHAINS)
    for (int chain = 0; chain < CHAINS; chain++) see(i + chain, chain);
  for (; i < s.n; i++) see(i, 0);
  const double fastest = most(most(most_of[0], most_of[1]), most(most_of[2], most_of[3]));
  const double eps = s.sign_ramp * std::sqrt(fastest);
  return eps > 1e-300 ? 1.0 / eps : 1e300;    // nothing moves: the limit of the law, sat -> sign
}

/** Add the forces of all touching pairs of the half list. */
template <bool SIZES, bool SPIN, bool LEDGER, class Law> static void pair_forces(const jump_state &s, const Law &law)
{
  constexpr bool SLIDES = LEDGER && Law::Friction::RUBS, MEMORY = Law::Friction::REMEMBERS;
  const Seen seen = seen_by(s);
  const Numbers<double> of = numbers_of_pair(s);
  const Rolling rolling = s.rolling;
  const double half = 0.5 * s.diameter;
  const double *const __restrict x = s.x, *const __restrict y = s.y, *const __restrict radius = s.radius;
  double *const __restrict fx = s.fx, *const __restrict fy = s.fy, *const __restrict torque = s.torque;
  const int32_t *const __restrict neighbours = s.neighbours;
  double *const __restrict dash_x = s.dash_x, *const __restrict dash_y = s.dash_y;
  double *const __restrict slide_x = s.slide_x, *const __restrict slide_y = s.slide_y;
  for (int64_t row = 0; row < s.rows; row++) {
    const int64_t i = s.owner ? s.owner[row] : row;
    const double xi = s.shift ? x[i] + s.shift[row] : x[i], yi = y[i], a = SIZES ? radius[i] : half;
    double sum_x = 0.0, sum_y = 0.0, lost_x = 0.0, lost_y = 0.0, slid_x = 0.0, slid_y = 0.0, turn = 0.0;
    for (int64_t p = s.start[row], last = s.start[row + 1]; p < last; p++) {
      const int64_t j = neighbours[p];
      const double dx = xi - x[j], dy = yi - y[j], r2 = dx * dx + dy * dy, b = SIZES ? radius[j] : a;
      const double reach = a + b;
      if (!(r2 < reach * reach)) continue;
      const Pair<double> pair = pair_of<SIZES, SPIN>(s, seen, i, j, dx, dy, r2, a, b);
      Stretch<double> held{};
      PairForce<double> out;
      if constexpr (MEMORY) {
        const PairMemory memory(s, i, j);
        held = memory.begin();
        out = pair_contact<SIZES, SPIN>(law, of, rolling, pair, held);
        memory.end(held);
      } else {
        out = pair_contact<SIZES, SPIN>(law, of, rolling, pair, held);
      }
      if constexpr (SPIN) {
        turn += out.on_a;
        torque[j] += out.on_b;
      }
      if constexpr (SLIDES) {
        slid_x -= out.rub * out.ny;
        slid_y += out.rub * out.nx;
        slide_x[j] += out.rub * out.ny;
        slide_y[j] -= out.rub * out.nx;
      }
      if constexpr (LEDGER) {
        const double ex = out.dashpot * out.nx, ey = out.dashpot * out.ny;
        lost_x += ex;
        lost_y += ey;
        dash_x[j] -= ex;
        dash_y[j] -= ey;
      }
      sum_x += out.fx;
      sum_y += out.fy;
      fx[j] -= out.fx;
      fy[j] -= out.fy;
    }
    fx[i] += sum_x;
    fy[i] += sum_y;
    if constexpr (SPIN) torque[i] += turn;
    if constexpr (LEDGER) {
      dash_x[i] += lost_x;
      dash_y[i] += lost_y;
    }
    if constexpr (SLIDES) {
      slide_x[i] += slid_x;
      slide_y[i] += slid_y;
    }
  }
}

/** Forces of one wall on the discs near it, and of these on it. Fixed discs feel no wall but bodies. */
template <bool SIZES, bool SPIN, class Law> static void wall_forces(const jump_state &s, const Law &law, int64_t wall)
{
  const Seen seen = seen_by(s);
  const WallView view(s, wall);
  const Numbers<double> of = numbers_of_wall(s, wall);
  const Rolling rolling = Law::Friction::REMEMBERS ? s.rolling_at[wall] : Rolling{};
  const bool moves = view.placed, ledger = s.dash_x, slides = Law::Friction::RUBS && s.slide_x;
  double x_ref = s.about[wall][0], y_ref = s.about[wall][1];
  if (moves) {
    x_ref += view.placed->now.x;
    y_ref += view.placed->now.y;
  }
  Sum on_wall, lost, slid;
  FaceContact found[MOST];
  for (int64_t row = s.near_rows[wall]; row < s.near_rows[wall + 1]; row++) {
    const int64_t i = s.near_discs[row];
    if (view.passes(s, i)) continue;
    const double own = radius_of(s, i), x = s.x[i], y = s.y[i];
    double px = x, py = y;
    view.see(px, py);
    const int count = view.touching(s, row, px, py, own, found);
    for (int c = 0; c < count; c++) {
      const AtWall<double> at = view.meet<SIZES, SPIN>(s, seen, i, found[c], x, y);
      const WallForce<double> out =
          wall_contact<SIZES, SPIN>(law, of, rolling, at, WallMemory(s, i, found[c].face, px, py, own));
      if constexpr (SPIN) s.torque[i] += out.torque;
      if (slides) {
        s.slide_x[i] -= out.rub * at.ny;
        s.slide_y[i] += out.rub * at.nx;
      }
      const double to = view.arm(at.gap, own), to_x = x - to * at.nx, to_y = y - to * at.ny;
      const double rolls = view.bulk > 0.0 ? own * out.resist : 0.0;    // of a body, which feels it too
      if (ledger) {
        s.dash_x[i] += out.dashpot * at.nx;
        s.dash_y[i] += out.dashpot * at.ny;
        if (moves) {
          const double arm_x = to_x - view.cx - view.placed->now.x, arm_y = to_y - view.cy - view.placed->now.y;
          lost.x += out.dashpot * at.nx;
          lost.y += out.dashpot * at.ny;
          lost.moment += out.dashpot * (arm_x * at.ny - arm_y * at.nx);
          slid.x -= out.rub * at.ny;
          slid.y += out.rub * at.nx;
          slid.moment += out.rub * (arm_x * at.nx + arm_y * at.ny) + rolls;
        }
      }
      s.fx[i] += out.fx;
      s.fy[i] += out.fy;
      on_wall.x -= out.fx;
      on_wall.y -= out.fy;
      on_wall.moment += (to_y - y_ref) * out.fx - (to_x - x_ref) * out.fy - rolls;
    }
  }
  double *const sum = s.wall_sum[wall];
  sum[0] += on_wall.x;
  sum[1] += on_wall.y;
  sum[2] += on_wall.moment;
  if (moves) s.taken[wall] = {on_wall, on_wall, lost, slid};
}

/** What forces of a step do on walls that move: their power on discs, and what is due to them in the ledger. */
static void end_walls(const jump_state &s)
{
  const double dt = s.clock[2];
  for (int64_t wall = 0; wall < s.walls; wall++) {
    const int64_t kind = s.moving[wall];
    if (kind == 0) continue;
    const Taken &taken = s.taken[wall];
    Pushed &pushed = s.pushed[wall];
    pushed.force[0] = taken.all.x;
    pushed.force[1] = taken.all.y;
    pushed.force[2] = taken.all.moment;
    if (kind >= LID) centre(s.placed[wall], pushed, s.load[wall], dt);
    const Pose &rate = s.placed[wall].centred;
    s.wall_sum[wall][3] -= taken.of_discs.power(rate);
    s.work[3] += dt * taken.lost.power(rate);
    s.work[4] += dt * taken.slid.power(rate);
    if (kind != LID && kind != BODY) s.work[5] -= dt * taken.all.power(rate);    // the energy of the others is part of the whole
  }
}

/** Take the forces off fixed discs: they stay, and nothing is dissipated on their side. */
static void hold(const jump_state &s)
{
  for (int64_t i = 0; i < s.n; i++) {
    if (s.fixed[i] == 0) continue;
    for (double *const of : {s.fx, s.fy, s.torque, s.dash_x, s.dash_y, s.slide_x, s.slide_y})
      if (of) of[i] = 0.0;
  }
}

/** Empty the slots whose contacts have ended. */
static void end_step(const jump_state &s)
{
  for (int64_t at = 0; at < s.n * s.slots; at++) {
    if (s.used[at] == 0) {
      s.partner[at] = 0;
      s.sigma[at] = s.spring[at] = s.roll[at] = 0.0;
    }
    s.used[at] = 0;
  }
}

static void forces(const jump_state &s)
{
  const double slope = has(s.sign_ramp) ? slope_of(s, seen_by(s)) : 0.0;
  if (s.moving) s.work[3] = s.work[4] = s.work[5] = 0.0;
  with_law(s, slope, [&](const auto &law, auto sizes, auto spin) {
    if (s.dash_x) pair_forces<sizes.value, spin.value, true>(s, law);
    else pair_forces<sizes.value, spin.value, false>(s, law);
    for (int64_t wall = 0; wall < s.walls; wall++) wall_forces<sizes.value, spin.value>(s, law, wall);
  });
  if (s.corners) body_forces(s, slope);
  if (s.moving) end_walls(s);
  if (s.moving)
    for (int c = 0; c < 3; c++) s.work[c] += s.work[3 + c];
  if (s.fixed) hold(s);
  if (s.partner && s.memory_step > 0.0) {
    end_step(s);
    if (s.corners) end_step(*s.corners);
  }
}

/** Sum of term(i) over the discs. */
template <class Term> static double sum_over(int64_t n, const Term &term)
{
  double part[CHAINS] = {};
  int64_t i = 0;
  for (; i + CHAINS <= n; i += CHAINS)
    for (int chain = 0; chain < CHAINS; chain++) part[chain] += term(i + chain);
  for (; i < n; i++) part[0] += term(i);
  return (part[0] + part[1]) + (part[2] + part[3]);
}

/** Sum of p . (v + half f / R^2) over the discs; takes p to zero for the next step. */
template <bool SIZES> static double power(const jump_state &s, double *__restrict px, double *__restrict py, double half)
{
  const double *const __restrict vx = s.vx, *const __restrict vy = s.vy, *const __restrict fx = s.fx;
  const double *const __restrict fy = s.fy, *const __restrict radius = s.radius;
  const double sum = sum_over(s.n, [=](int64_t i) {
    const double kick = SIZES ? half / (radius[i] * radius[i]) : half;
    return px[i] * (vx[i] + kick * fx[i]) + py[i] * (vy[i] + kick * fy[i]);
  });
  std::fill_n(px, s.n, 0.0);
  std::fill_n(py, s.n, 0.0);
  return sum;
}

static double fourth(double radius) { return (radius * radius) * (radius * radius); }

/** Sum of torque (omega + half torque / R^4) over the discs. */
template <bool SIZES> static double power_of_torque(const jump_state &s, double half)
{
  const double *const __restrict torque = s.torque, *const __restrict omega = s.omega, *const __restrict radius = s.radius;
  return sum_over(s.n, [=](int64_t i) {
    return torque[i] * (omega[i] + (SIZES ? half / fourth(radius[i]) : half) * torque[i]);
  });
}

/** The work of dashpots and friction over the whole kick, dt F . v_n: v_n is the mean of the velocities around the kick. */
template <bool SIZES> static void book(const jump_state &s, double kick)
{
  const double dt = s.time_step;
  s.work[0] -= dt * power<SIZES>(s, s.dash_x, s.dash_y, 0.5 * kick);
  if (!s.slide_x) return;
  s.work[1] -= dt * power<SIZES>(s, s.slide_x, s.slide_y, 0.5 * kick);
  if (s.omega) s.work[1] -= dt * power_of_torque<SIZES>(s, 0.5 * dt / s.inertia);
}

template <bool SIZES, bool EXTRA> static void kick_spin(const jump_state &s)
{
  const double turn = s.time_step / s.inertia;
  double *const __restrict omega = s.omega, *const __restrict torque = s.torque, *const __restrict uomega = s.uomega;
  const double *const __restrict radius = s.radius;
  for (int64_t i = 0, n = s.n; i < n; i++) {
    const double old = omega[i], now = old + (SIZES ? turn / fourth(radius[i]) : turn) * torque[i];
    omega[i] = now;
    torque[i] = 0.0;
    if constexpr (EXTRA) uomega[i] = 1.5 * now - 0.5 * old;
  }
}

/** v += dt F/m, x += dt v, F = weight; the number of discs further than half the skin from their place in the list.

    A NaN counts as moved. */
template <bool SIZES, bool EXTRA> static int64_t kick_drift(const jump_state &s, double kick)
{
  const double dt = s.time_step, weight_x = s.weight_x, weight_y = s.weight_y, reach2 = s.reach2;
  double *const __restrict x = s.x, *const __restrict y = s.y, *const __restrict vx = s.vx, *const __restrict vy = s.vy;
  double *const __restrict fx = s.fx, *const __restrict fy = s.fy, *const __restrict ux = s.ux, *const __restrict uy = s.uy;
  const double *const __restrict x0 = s.x0, *const __restrict y0 = s.y0, *const __restrict radius = s.radius;
  int64_t moved = 0;
  for (int64_t i = 0, n = s.n; i < n; i++) {
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

template <bool SIZES, bool EXTRA> static int64_t drift_kind(const jump_state &s)
{
  const double kick = s.time_step / s.mass;
  if (s.dash_x) book<SIZES>(s, kick);
  if (s.omega) kick_spin<SIZES, EXTRA>(s);
  return kick_drift<SIZES, EXTRA>(s, kick);
}

static int64_t drift(const jump_state &s)
{
  if (s.radius) return s.ux ? drift_kind<true, true>(s) : drift_kind<true, false>(s);
  return s.ux ? drift_kind<false, true>(s) : drift_kind<false, false>(s);
}

/** Put the moving walls where they are at a step; true where one has gone over half the skin since it was listed. */
static bool place_walls(const jump_state &s, double step)
{
  const Clock clock{s.clock[1], s.clock[2]};
  bool old = false;
  for (int64_t wall = 0; wall < s.walls; wall++) {
    if (s.moving[wall] == 0) continue;
    const int64_t first = s.track_first[wall];
    if (s.moving[wall] == 1)
      follow(s.placed[wall], s.track + first, s.track_first[wall + 1] - first, clock.time(step), clock.dt);
    else follow(s.placed[wall], s.pushed[wall], s.load[wall], clock, step, s.clock[4] > 0.0 && s.moving[wall] == BODY);
    old = old || !(travel(s.placed[wall].now, s.listed[wall], s.far[wall]) <= s.clock[3]);
  }
  return old;
}

/** Up to `steps` drifts with forces between them, and before them where these are `owed`; without steps these alone.

    The forces after the last drift are left to the caller. Returns the drifts done; `old`: the list has become too old. */
static int64_t advance(jump_state &s, int64_t steps, bool owed, bool &old)
{
  int64_t done = 0;
  old = false;
  while (true) {
    if (owed) {
      if (s.grid_first && !search_cells(s)) {
        old = true;
        return done;
      }
      forces(s);
    }
    if (steps == 0) return 0;
    old = drift(s) > 0;
    done++;
    owed = true;
    if (s.moving) {
      const double step = s.clock[0] + (double) done;
      for (int64_t wall = 0; wall < s.walls; wall++)
        if (s.moving[wall] >= LID) drift(s.pushed[wall], s.load[wall], {s.clock[1], s.clock[2]}, step);
      if (place_walls(s, step)) old = true;
    }
    if (old || done == steps) return done;
  }
}

}    // namespace jump

int64_t jump_advance(jump_state *state, int64_t steps, int64_t owed, int64_t *old)
{
  bool worn;
  const int64_t done = jump::advance(*state, steps, owed != 0, worn);
  *old = worn;
  return done;
}

void jump_place_walls(const jump_state *state, int64_t step) { jump::place_walls(*state, (double) step); }

double jump_slope(const jump_state *state, const double *vx, const double *vy)
{
  return jump::slope_of(*state, {vx, vy, nullptr});
}
