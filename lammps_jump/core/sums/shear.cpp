// SPDX-License-Identifier: GPL-2.0-or-later
/* A box of discs without walls: periodic along x and y, sheared as Lees & Edwards (1972) do, at a held pressure.

   studies/fluid/cell.py has the equations. Time levels are those of LAMMPS: x_n, v_(n-1/2), F_n between steps, and the
   dashpot sees v_(n-1/2). The image of a disc one height further up is `offset` further along x and is faster by rate
   times height. */

#include "step/kinds.h"

#include <algorithm>
#include <numeric>
#include <vector>

/** Slots of the discs, as of `jump_state`. */
struct jump_springs {
  int64_t slots;
  int64_t *ids;
  int64_t *partner, *full;
  double *sigma, *spring, *roll;
  int8_t *used;
  double time_step;
};

JUMP_SIZE(jump_springs)

namespace jump {
namespace {

/** The discs: place, velocity, spin, force, torque, radius; way against the shear since the list. */
struct Swarm {
  int64_t n;
  double *x, *y, *vx, *vy, *omega, *fx, *fy, *torque, *radius, *way;
};

/** Numbers of the box, and what is imposed, in the order of Python. */
struct ShearBox {
  double lx, ly, offset, strain, pressure;
};
struct Control {
  double rate, pressure, gain, cap, time_step, skin, slope, mass, turn;
};

/** Two discs of the list, and the image of the second: boxes up, and along. */
struct ListedPair {
  int32_t i, j, level, column;
};

/** Sums over a step, times the area: stress, and energy of the motion against the shear. */
struct StressSums {
  double xx = 0.0, yy = 0.0, xy = 0.0;
};

/** Puts every disc into the box, with the velocity of its image there; no way since the list. */
void wrap(const Swarm &s, ShearBox &box, double rate)
{
  for (int64_t i = 0; i < s.n; i++) {
    const double level = std::floor(s.y[i] / box.ly);
    s.y[i] -= level * box.ly;
    s.vx[i] -= level * rate * box.ly;
    s.x[i] -= level * box.offset;
    s.x[i] -= box.lx * std::floor(s.x[i] / box.lx);
    s.way[2 * i] = s.way[2 * i + 1] = 0.0;
  }
  box.offset -= box.lx * std::floor(box.offset / box.lx);
}

/** Lists all pairs closer than the skin, surface to surface; their number, or -1 where there is no room.

    Discs are taken by their height, each with those above it, so that the box must be higher than twice the reach. */
int64_t list(const Swarm &s, const ShearBox &box, double skin, ListedPair *pairs, int64_t room)
{
  std::vector<int64_t> order(s.n);
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int64_t a, int64_t b) { return s.y[a] < s.y[b]; });
  const double widest = *std::max_element(s.radius, s.radius + s.n) + skin;
  int64_t count = 0;
  for (int64_t first = 0; first < s.n; first++) {
    const int64_t i = order[first];
    const double reach = s.radius[i] + skin;
    if (count + s.n > room) return -1;
    for (int64_t further = first + 1; further < first + s.n; further++) {
      const int64_t level = further / s.n, j = order[further % s.n];
      const double dy = s.y[i] - s.y[j] - (double) level * box.ly;
      if (dy < -(s.radius[i] + widest)) break;
      double dx = s.x[i] - s.x[j] - (double) level * box.offset;
      const double column = std::nearbyint(dx / box.lx), far = reach + s.radius[j];
      dx -= column * box.lx;
      if (dx * dx + dy * dy < far * far) pairs[count++] = {(int32_t) i, (int32_t) j, (int32_t) level, (int32_t) column};
    }
  }
  return count;
}

/** Forces and torques of all listed pairs; adds the contacts' part of the stress. `state` holds law and memory. */
void forces(const Swarm &s, const ShearBox &box, const Control &c, const jump_state &state, const ListedPair *pairs, int64_t count,
            StressSums &sums)
{
  std::fill(s.fx, s.fx + s.n, 0.0);
  std::fill(s.fy, s.fy + s.n, 0.0);
  std::fill(s.torque, s.torque + s.n, 0.0);
  const double speed = c.rate * box.ly;
  const ContactVelocities seen{s.vx, s.vy, s.omega};
  with_law(state, c.slope, [&](const auto &law, auto sizes, auto spin) {
    using Friction = typename std::decay_t<decltype(law)>::Friction;
    constexpr bool SPIN = decltype(spin)::value;
    if constexpr (decltype(sizes)::value && SPIN == Friction::HAS_FRICTION) {
      for (const ListedPair *p = pairs; p < pairs + count; p++) {
        const int64_t i = p->i, j = p->j;
        const double dx = s.x[i] - s.x[j] - p->level * box.offset - p->column * box.lx;
        const double dy = s.y[i] - s.y[j] - p->level * box.ly, r2 = dx * dx + dy * dy, a = s.radius[i], b = s.radius[j];
        if (r2 >= (a + b) * (a + b)) continue;
        Pair<double> pair = pair_of<true, SPIN>(state, seen, i, j, {dx, dy, r2}, a, b);
        pair.vx -= p->level * speed;
        Stretch<double> held{};
        PairForce<double> out;
        if constexpr (Friction::HAS_HISTORY) {
          const PairHistory of_pair(state, i, j);
          const ContactHistory memory = of_pair.take(state);
          held = memory.begin(of_pair.way);
          out = pair_contact<true, SPIN>(law, numbers_of(state.pair, 0.0), pair, held);
          memory.end(held, of_pair.way);
        } else {
          out = pair_contact<true, SPIN>(law, numbers_of(state.pair, 0.0), pair, held);
        }
        s.fx[i] += out.fx;
        s.fy[i] += out.fy;
        s.fx[j] -= out.fx;
        s.fy[j] -= out.fy;
        if constexpr (SPIN) {
          s.torque[i] += out.on_a;
          s.torque[j] += out.on_b;
        }
        sums.xx += out.fx * dx;
        sums.yy += out.fy * dy;
        sums.xy += out.fx * dy;
      }
    }
  });
}

/** Empties the slots whose contacts have ended. */
void end_step(const jump_springs &of, int64_t n)
{
  for (int64_t at = 0; at < n * of.slots; at++) {
    if (!of.used[at]) {
      of.partner[at] = 0;
      of.sigma[at] = of.spring[at] = of.roll[at] = 0.0;
    }
    of.used[at] = 0;
  }
}

/** Kick and drift of all discs; the largest way against the shear, squared, m^2. */
double move(const Swarm &s, const ShearBox &box, const Control &c, StressSums &kinetic)
{
  const double dt = c.time_step, kick = dt / c.mass, middle = 0.5 * box.ly;
  double far = 0.0;
  for (int64_t i = 0; i < s.n; i++) {
    const double square = s.radius[i] * s.radius[i], mass = c.mass * square;
    s.vx[i] += kick / square * s.fx[i];
    s.vy[i] += kick / square * s.fy[i];
    s.omega[i] += dt * c.turn / (square * square) * s.torque[i];
    const double ux = s.vx[i] - c.rate * (s.y[i] - middle), uy = s.vy[i];
    kinetic.xx += mass * ux * ux;
    kinetic.yy += mass * uy * uy;
    kinetic.xy += mass * ux * uy;
    s.x[i] += dt * s.vx[i];
    s.y[i] += dt * s.vy[i];
    double *const way = s.way + 2 * i;
    way[0] += dt * ux;
    way[1] += dt * uy;
    far = most(far, way[0] * way[0] + way[1] * way[1]);
  }
  return far;
}

/** Twice the mean, by mass, of vx sin(2 pi x / length), m/s: the height of a standing wave. */
double mode(const Swarm &s, const ShearBox &box)
{
  const double wave = 2.0 * PI / box.lx;
  double total = 0.0, mass = 0.0;
  for (int64_t i = 0; i < s.n; i++) {
    const double square = s.radius[i] * s.radius[i];
    total += square * s.vx[i] * std::sin(wave * s.x[i]);
    mass += square;
  }
  return 2.0 * total / mass;
}

/** Law and memory of the discs, as the contacts of the core read them. */
jump_state state_of(const Swarm &s, const LawNumbers &law, const jump_springs *springs)
{
  jump_state state{};
  state.n = s.n;
  state.radius = s.radius;
  state.omega = s.omega;
  state.pair = law;
  if (springs) {
    state.ids = springs->ids;
    state.slots = state.slot_row = springs->slots;
    state.partner = springs->partner;
    state.full = springs->full;
    state.sigma = springs->sigma;
    state.spring = springs->spring;
    state.roll = springs->roll;
    state.used = springs->used;
    state.memory_step = springs->time_step;
  }
  return state;
}

/** The discs in their box, step by step, with the list of pairs. */
struct Shearing {
  const Swarm &s;
  ShearBox &box;
  const Control &c;
  const jump_state &state;
  const jump_springs *springs;
  ListedPair *pairs;
  int64_t room;
  double widest;                          // diameter and skin, m
  double bent = HUGE_VAL, grown = 0.0;    // strains since the list was made; the first step makes one
  int64_t count = 0;

  /** Part by which the box grows in a step under the pressure that is held. */
  double growth() const
  {
    if (!(c.gain > 0.0)) return 0.0;
    return least(most(c.gain * (box.pressure - c.pressure) / state.pair.stiffness, -c.cap), c.cap) * c.time_step;
  }

  /** Shear the box by a step, and let it grow. */
  void deform(double grow)
  {
    box.strain += c.rate * c.time_step;
    box.offset += c.rate * box.ly * c.time_step;
    bent += c.rate * c.time_step;
    grown += grow;
    if (grow == 0.0) return;
    for (int64_t i = 0; i < s.n; i++) {
      s.x[i] *= 1.0 + grow;
      s.y[i] *= 1.0 + grow;
    }
    box.lx *= 1.0 + grow;
    box.ly *= 1.0 + grow;
    box.offset *= 1.0 + grow;
  }

  /** A step: energy of the motion against the shear, and the stress times the area; false where there is no room. */
  bool step(double &kinetic, StressSums &sums)
  {
    const double grow = growth(), far = move(s, box, c, sums);
    kinetic = 0.5 * (sums.xx + sums.yy);
    deform(grow);
    if (!(2.0 * std::sqrt(far) + (std::fabs(bent) + std::fabs(grown)) * widest <= c.skin)) {
      wrap(s, box, c.rate);
      count = list(s, box, c.skin, pairs, room);
      if (count < 0) return false;
      bent = grown = 0.0;
    }
    forces(s, box, c, state, pairs, count, sums);
    if (springs) end_step(*springs, s.n);
    box.pressure = 0.5 * (sums.xx + sums.yy) / (box.lx * box.ly);
    return true;
  }
};

}    // namespace
}    // namespace jump

using namespace jump;

#define JUMP_SHEAR(FIELD) \
  FIELD(int64_t, n) FIELD(double *const *, discs) FIELD(double *, box_numbers) FIELD(const double *, control) \
  FIELD(const LawNumbers *, law) FIELD(const jump_springs *, springs) FIELD(int32_t *, listed) FIELD(int64_t, room) \
  FIELD(double *, record) FIELD(int64_t, rows) FIELD(int64_t, every)
JUMP_INPUT(jump_shear, JUMP_SHEAR)

/** Steps of kick, drift and forces, `every` for each row of `record`, which takes their means: stress (Pa), area (m^2),
    energy of the motion against the shear (J per m), and the height of the first mode at its end (m/s).

    discs: ten arrays of n, the last of 2 n, in the order of `Swarm`. law: that of two discs, of a size of 1 m.
    Returns 0 where there is no room for the pairs. */
JUMP_API int64_t jump_shear(const jump_shear_input *input)
{
  JUMP_SHEAR(JUMP_LOCAL)
  const Swarm s{n, discs[0], discs[1], discs[2], discs[3], discs[4], discs[5], discs[6], discs[7], discs[8], discs[9]};
  ShearBox &box = *reinterpret_cast<ShearBox *>(box_numbers);
  const Control &c = *reinterpret_cast<const Control *>(control);
  ListedPair *const pairs = reinterpret_cast<ListedPair *>(listed);
  const jump_state state = state_of(s, *law, springs);
  Shearing run{s, box, c, state, springs, pairs, room, 2.0 * *std::max_element(s.radius, s.radius + n) + c.skin};
  for (double *row = record; row < record + 6 * rows; row += 6) {
    std::fill(row, row + 6, 0.0);
    for (int64_t step = 0; step < every; step++) {
      double kinetic;
      StressSums sums;
      if (!run.step(kinetic, sums)) return 0;
      const double area = box.lx * box.ly, parts = area * (double) every;
      row[0] += sums.xx / parts;
      row[1] += sums.yy / parts;
      row[2] += sums.xy / parts;
      row[3] += area / (double) every;
      row[4] += kinetic / (double) every;
    }
    row[5] = mode(s, box);
  }
  return 1;
}
