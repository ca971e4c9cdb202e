// SPDX-License-Identifier: GPL-2.0-or-later
/* What the native engine sums over contacts: elastic energy, the list of contacts, energy between two stations; and what
   discs that get their own size change. */

#include "contact/no_contraction.h"

#include "step/thread_partition.h"
#include "step/kinds.h"

#include <cstring>

namespace jump {

double slope_of(const jump_state &s, const ContactVelocities &seen) { return slope_of(s, fastest(seen, 0, s.n)); }

/** Discs whose contacts are requested, by a mask; all where it is NULL. A sorted row reaches so many rows on. */
struct Chosen {
  const int8_t *mask = nullptr;
  int64_t reach = 0;

  /** First row from `row` on that may have one of them. */
  int64_t next(const jump_state &s, int64_t row) const
  {
    if (!mask || row >= s.sorted) return row;
    const void *const found = std::memchr(mask + row, 1, (size_t) (s.sorted - row));
    return found ? most(static_cast<const int8_t *>(found) - mask - reach, row) : s.sorted;
  }
};

/** Calls run(x, i, j, dx, dy, apart2, a, b) for each two discs that touch and of which one is chosen. */
template <class Run> static void each_pair(const jump_state &s, const Chosen &of, const Run &run)
{
  const int8_t *const chosen = of.mask;
  for (int64_t row = of.next(s, 0); row < s.rows; row = of.next(s, row + 1)) {
    const int64_t i = s.owner ? s.owner[row] : row;
    const double xi = s.shift ? s.x[i] + s.shift[row] : s.x[i], a = radius_of(s, i);
    const int8_t *const asked = chosen && !chosen[i] ? chosen : nullptr;    // of the others
    for (int64_t p = s.start[row]; p < s.start[row + 1]; p++) {
      const int64_t j = s.neighbours[p];
      if (asked && !asked[j]) continue;
      const double dx = xi - s.x[j], dy = s.y[i] - s.y[j], r2 = dx * dx + dy * dy, b = radius_of(s, j);
      if (r2 < (a + b) * (a + b)) run(xi, i, j, dx, dy, r2, a, b);
    }
  }
}

/** Calls run(view, wall, i, found, px, py) for each contact of a disc with a wall; (px, py): in the wall's own frame. */
template <class Run> static void each_wall_contact(const jump_state &s, const Run &run)
{
  FaceContact found[MOST];
  for (int64_t wall = 0; wall < s.walls; wall++) {
    const WallView view(s, wall);
    for (int64_t row = s.near_rows[wall]; row < s.near_rows[wall + 1]; row++) {
      const int64_t i = s.near_discs[row];
      if (view.passes(s, i)) continue;
      double px = s.x[i], py = s.y[i];
      view.into_frame(px, py);
      const int count = view.touching(s, row, px, py, radius_of(s, i), found);
      for (int c = 0; c < count; c++) run(view, wall, i, found[c], px, py);
    }
  }
}

template <class Law>
static double elastic(const jump_state &s, const Law &law, const Chosen &chosen, double *worst, int64_t *where)
{
  double pairs = 0.0, walls = 0.0;
  const auto note = [&](double overlap, int64_t disc, int64_t wall) {
    if (!(overlap > *worst)) return;
    *worst = overlap;
    where[0] = disc;
    where[1] = wall;
  };
  each_pair(s, chosen, [&](double, int64_t i, int64_t, double, double, double r2, double a, double b) {
    const double overlap = a + b - std::sqrt(r2);
    if (!(overlap > 0.0)) return;
    pairs += stored_energy(law, s.pair, overlap);
    note(overlap, i, -1);
  });
  each_wall_contact(s, [&](const WallView &, int64_t wall, int64_t i, const FaceContact &found, double, double) {
    if (chosen.mask && !chosen.mask[i]) return;
    const double overlap = radius_of(s, i) - found.gap;
    walls += stored_energy(law, s.at_wall[wall], overlap);
    note(overlap, i, wall);
  });
  return pairs + walls;
}

/** The contact of two discs of a row, with what it remembers. */
template <bool SIZES, bool SPIN, class Law>
static PairForce<double> contact_of(const jump_state &s, const Law &law, const ContactVelocities &seen, int64_t i, int64_t j,
                                    const Between &way, double a, double b)
{
  Stretch<double> held{};
  if constexpr (Law::Friction::HAS_HISTORY) {
    const PairHistory memory(s, i, j);
    held = memory.take(s).begin(memory.way);
  }
  return pair_contact<SIZES, SPIN>(law, numbers_of(s.pair, 0.0), pair_of<SIZES, SPIN>(s, seen, i, j, way, a, b), held);
}

template <bool SIZES, bool SPIN, class Law>
static void list_contacts(const jump_state &s, const Law &law, const ContactVelocities &at_step, const ContactVelocities &seen, ContactRows &record)
{
  each_pair(s, {}, [&](double xi, int64_t i, int64_t j, double dx, double dy, double r2, double a, double b) {
    if (j >= s.n && s.ids[i] < s.ids[j]) return;    // the other rank lists it
    const PairForce<double> out = contact_of<SIZES, SPIN>(s, law, seen, i, j, {dx, dy, r2}, a, b);
    const double way = way_to_middle(a, out.overlap), sx = at_step.vx[i] - at_step.vx[j], sy = at_step.vy[i] - at_step.vy[j];
    double power = dissipated_power(out, out.nx, out.ny, sx, sy);
    if constexpr (SPIN) power -= out.on_a * at_step.spin[i] + out.on_b * at_step.spin[j];
    record.add(s.ids[i], s.ids[j], xi - way * out.nx, s.y[i] - way * out.ny, out.fx, out.fy, power);
  });
  each_wall_contact(s, [&](const WallView &view, int64_t wall, int64_t i, const FaceContact &found, double px, double py) {
    const double own = radius_of(s, i), x = s.x[i], y = s.y[i];
    const DiscAtWall disc{i, own, x, y, seen.vx[i], seen.vy[i], SPIN ? seen.spin[i] : 0.0};
    const AtWall<double> at = view.meet(disc, found);
    const WallForce<double> out = wall_force<SIZES, SPIN>(s, law, numbers_of(s.at_wall[wall], 0.0), view, disc, at,
                                                          WallHistory(s, i, found.face, px, py, own));
    const double at_x = x - at.gap * at.nx, at_y = y - at.gap * at.ny;
    const Pose wall_v = view.placed ? view.velocity(view.placed->centred, at_x, at_y) : Pose{0.0, 0.0, 0.0};
    const double sx = at_step.vx[i] - wall_v.x, sy = at_step.vy[i] - wall_v.y;
    double power = dissipated_power(out, at.nx, at.ny, sx, sy);
    if constexpr (SPIN) power -= out.torque * at_step.spin[i];
    record.add(s.ids[i], -1 - wall, at_x, at_y, out.fx, out.fy, power);
  });
}

/** Discs between the stations: what crossed, what they hold, and what forces on them do. */
static void between_discs(const jump_state &s, const jump_stations &at, double *sums, double &push, double &dashpots, double &friction)
{
  const double dt = s.time_step, half = 0.5 * dt;
  double held = 0.0;
  for (int64_t i = 0; i < s.n; i++) {
    const double place = s.x[i] - at.left, w = s.vx[i] - at.speed;
    const int now = (place >= 0.0) + (place >= at.width);
    const int before = (place - dt * w >= 0.0) + (place - dt * w >= at.width);
    if (now != 1 && before == now) continue;
    const double square = s.radius ? s.radius[i] * s.radius[i] : 1.0;
    const double mass = s.mass * square, inertia = s.inertia * square * square;
    double energy = 0.5 * mass * (w * w + s.vy[i] * s.vy[i]);
    energy -= square * (s.weight_x * (place - half * w) + s.weight_y * (s.y[i] - half * s.vy[i]));
    if (s.omega) energy += 0.5 * inertia * s.omega[i] * s.omega[i];
    if (at.moved) {
      sums[MASS_LEFT] += mass * ((now > 0) - (before > 0));
      sums[MASS_RIGHT] += mass * ((now > 1) - (before > 1));
      sums[CARRIED] += energy * ((now == 1) - (before == 1));
    }
    if (now != 1) continue;
    held += energy;
    const double hx = s.vx[i] + half / mass * s.fx[i], hy = s.vy[i] + half / mass * s.fy[i];
    push += s.fx[i] - s.weight_x * square;
    dashpots += s.dashpot_x[i] * hx + s.dashpot_y[i] * hy;
    if (!s.friction_x) continue;
    friction += s.friction_x[i] * hx + s.friction_y[i] * hy;
    if (s.omega) friction += s.torque[i] * (s.omega[i] + half / inertia * s.torque[i]);
  }
  sums[HELD] = held;
}

/** A step of the sums between the stations, which move at `speed`; see StationLedger in engines/native/ledger.py.

    Forces on a disc, F . (v - c), make up what contacts hand on through the stations, F . [(v_i + v_j)/2 - c], half of what
    such a pair dissipates, all of that of pairs inside and of walls, and the power of walls, which move backwards at c
    (docs/theory.md). */
static void between(const jump_state &s, const jump_stations &at, double *sums)
{
  double handed = 0.0, push = 0.0, dashpots = 0.0, friction = 0.0;
  between_discs(s, at, sums, push, dashpots, friction);
  if (!at.pushed) return;
  const ContactVelocities seen = seen_by(s);
  with_law(s, slope_of(s, seen), [&](const auto &law, auto sizes, auto spin) {
    constexpr bool SIZES = decltype(sizes)::value, SPIN = decltype(spin)::value;
    each_pair(s, {}, [&](double, int64_t i, int64_t j, double, double, double r2, double, double) {
      const int64_t a = s.x[i] < s.x[j] ? i : j, b = a == i ? j : i;
      // the stations between the two: 1 for that on the left, -1 for that on the right, 0 for both or none
      const auto parts = [&](double x) { return (s.x[a] < x) && (s.x[b] >= x); };
      const int way = parts(at.left) - parts(at.left + at.width);
      if (way == 0) return;
      const PairForce<double> out = contact_of<SIZES, SPIN>(s, law, seen, b, a, {s.x[b] - s.x[a], s.y[b] - s.y[a], r2},
                                                            radius_of(s, b), radius_of(s, a));
      const AtStep one(s, a), two(s, b);
      const double mx = 0.5 * (one.vx + two.vx), my = 0.5 * (one.vy + two.vy);
      double turn = 0.0;
      if constexpr (SPIN) turn = 0.5 * (out.on_a * two.spin - out.on_b * one.spin);
      friction -= way * (out.tangential * (out.nx * my - out.ny * mx) + turn);
      handed += way * (out.fx * (mx - at.speed) + out.fy * my + turn);
      push -= way * out.fx;
      dashpots -= way * out.dashpot * (out.nx * mx + out.ny * my);
    });
  });
  sums[CONTACTS] += s.time_step * handed;
  sums[WALLS] -= s.time_step * at.speed * push;
  sums[DASHPOTS] -= s.time_step * dashpots;
  sums[FRICTION] -= s.time_step * friction;
}

/** Radii for the discs with ids above `known`, after a step and with its forces; what this gives to the energy.

    The velocities of the step stay: the first half of the step's kick is that of the old mass, the second half that of the
    new one. What it gives: kinetic and gravitational energy, the work that dashpots and friction take in the first half, and,
    in the second, that of the old weight on the new mass. */
static double give_sizes(const jump_state &s, int64_t known, const double *radii)
{
  const double dt = s.time_step;
  double gained = 0.0;
  for (int64_t i = 0; i < s.n; i++) {
    if (s.ids[i] <= known) continue;
    const double now = radii[s.ids[i] - known - 1], old = s.radius[i] * s.radius[i], own = now * now;
    s.radius[i] = now;
    const double before = 0.5 * dt / (s.mass * old), after = 0.5 * dt / (s.mass * own);
    const double fx = s.fx[i], fy = s.fy[i], wx = s.vx[i] + before * fx, wy = s.vy[i] + before * fy;
    s.vx[i] += (before - after) * fx;
    s.vy[i] += (before - after) * fy;
    gained += 0.5 * s.mass * (own - old) * (wx * wx + wy * wy);
    gained -= (own - old) * (s.weight_x * s.x[i] + s.weight_y * s.y[i]);
    const double push_x = 0.5 * dt * (old - own) * s.weight_x, push_y = 0.5 * dt * (old - own) * s.weight_y;
    const double late_x = push_x / own + dt * s.weight_x, late_y = push_y / own + dt * s.weight_y;
    gained += push_x * (wx + after * fx - 0.5 * late_x / s.mass);
    gained += push_y * (wy + after * fy - 0.5 * late_y / s.mass);
    if (s.dashpot_x) gained -= 0.25 * dt * (before - after) * (s.dashpot_x[i] * fx + s.dashpot_y[i] * fy);
    if (s.friction_x) gained -= 0.25 * dt * (before - after) * (s.friction_x[i] * fx + s.friction_y[i] * fy);
    if (!s.omega) continue;
    const double slow = 0.5 * dt / (s.inertia * old * old), fast = 0.5 * dt / (s.inertia * own * own);
    const double torque = s.torque[i], turn = s.omega[i] + slow * torque;
    s.omega[i] += (slow - fast) * torque;
    gained += 0.5 * s.inertia * (own * own - old * old) * turn * turn;
    gained -= 0.25 * dt * (slow - fast) * torque * torque;
  }
  return gained;
}

}    // namespace jump

using namespace jump;

JUMP_SIZE(jump_state)
JUMP_SIZE(jump_grid)
JUMP_SIZE(jump_lists)
JUMP_SIZE(jump_stations)
JUMP_SIZE(jump_pressed)
using jump_velocities = ContactVelocities;
JUMP_SIZE(jump_velocities)

double jump::elastic_of(const jump_state &state, ThreadPartition &partition, const int8_t *mask, double *worst, int64_t *where)
{
  const Chosen chosen{mask, partition.reach_of(state)};
  *worst = 0.0;
  where[0] = where[1] = -1;
  double energy = 0.0;
  with_normal(state.pair, [&](const auto &law) { energy = elastic(state, law, chosen, worst, where); });
  if (state.corners && !mask) energy += body_elastic(state);
  return energy;
}

double jump_elastic(const jump_state *state, ThreadPartition *partition, const int8_t *mask, double *worst, int64_t *where)
{
  return elastic_of(*state, *partition, mask, worst, where);
}

/** List the contacts with the forces of the velocities `seen`; their number, or -1 where there is no room.

    The power that dashpots and friction take is with the velocities at the step: dt times the sum over contacts is what the
    energy balance books for the kick. */
int64_t jump_contacts(const jump_state *state, const ContactVelocities *at_step, const ContactVelocities *seen, int64_t (*who)[2], double (*found)[5],
                      int64_t room)
{
  return jump::list_contacts(*state, slope_of(*state, *seen), *at_step, *seen, {who, found, room});
}

int64_t jump::list_contacts(const jump_state &s, double slope, const ContactVelocities &at_step, const ContactVelocities &seen,
                            ContactRows record)
{
  with_law(s, slope, [&](const auto &law, auto sizes, auto spin) {
    list_contacts<sizes.value, spin.value>(s, law, at_step, seen, record);
  });
  return record.is_short ? -1 : record.count;
}

void jump_between(const jump_state *state, const jump_stations *stations, double *sums) { between(*state, *stations, sums); }

double jump_give_sizes(const jump_state *state, int64_t known, const double *radii)
{
  return give_sizes(*state, known, radii);
}
