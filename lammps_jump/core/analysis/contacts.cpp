// SPDX-License-Identifier: GPL-2.0-or-later
// Contacts of one frame for the analysis: which discs touch a wall, forces and energy by the law, and their sums.

#include <algorithm>
#include <vector>

#include "api.h"
#include "contact/contact.h"
#include "walls/faces.h"

namespace jump {
namespace {

/** Bins of equal width along x. */
struct Bins {
  double low, width;
  int64_t count;

  int64_t of(double x) const { return static_cast<int64_t>(std::floor((x - low) / width)); }

  /** Calls run(bin, length) for each part of the way between two places that lies in a bin. */
  template <class Run> void between(double a, double b, const Run &run) const
  {
    const double left = std::min(a, b), right = std::max(a, b);
    for (int64_t k = std::max<int64_t>(of(left), 0); k < count; k++) {
      const double begin = low + static_cast<double>(k) * width, end = low + static_cast<double>(k + 1) * width;
      if (!(begin < right)) break;
      const double inside = std::min(right, end) - std::max(left, begin);
      if (inside > 0.0) run(k, inside);
    }
  }
};

}    // namespace
}    // namespace jump

using namespace jump;

#define JUMP_TOUCH_WALL(FIELD) \
  FIELD(int64_t, n) FIELD(const double *, x) FIELD(const double *, y) FIELD(const double *, radius) \
  FIELD(const Face *, faces) FIELD(int64_t, deep) FIELD(const double *, place) FIELD(const int64_t *, cells) \
  FIELD(const int64_t *, start) FIELD(const int64_t *, listed) FIELD(int64_t *, index) FIELD(double *, found) \
  FIELD(int64_t, room)
JUMP_INPUT(jump_touch_wall, JUMP_TOUCH_WALL)

// Contacts of discs with one wall in its own frame: their number, of which what fits into `room` is written. Contact k is
// of disc index[k]; found[k] takes its signed distance and normal. The cells are those of scene/faces.py.
JUMP_API int64_t jump_touch_wall(const jump_touch_wall_input *input)
{
  JUMP_TOUCH_WALL(JUMP_LOCAL)
  const WallFaces wall{faces, deep == 1};
  const NearGrid grid{place[0], place[1], place[2], cells[0], cells[1]};
  FaceContact kept[MOST];
  int64_t number = 0;
  for (int64_t i = 0; i < n; i++) {
    const int64_t cell = cells[2] + grid.cell(x[i], y[i]);
    const int64_t *const near = listed + start[cell];
    const int own = wall.touching(near, start[cell + 1] - start[cell], x[i], y[i], radius[i], kept);
    for (int k = 0; k < own; k++, number++) {
      if (number >= room) continue;
      index[number] = i;
      double *const row = found + 3 * number;
      row[0] = kept[k].gap, row[1] = kept[k].nx, row[2] = kept[k].ny;
    }
  }
  return number;
}

// Of the laws of a scene, that of two discs and then those of its walls, `which` is that of each contact. Its dashpot
// and slope of the viscous ramp are its own.

// Normal force of each contact; opening: speed of parting.
JUMP_API void jump_normal_forces(int64_t n, const LawNumbers *laws, const int64_t *which, const double *overlap,
                                 const double *opening, const double *damping, double *force)
{
  with_normal(*laws, [&](const auto &law) {
    for (int64_t k = 0; k < n; k++)
      force[k] = normal_force(law, Numbers<double>{laws[which[k]], damping[k], 0.0}, overlap[k], opening[k]).whole;
  });
}

// Elastic energy of contacts, J per m of width.
JUMP_API double jump_elastic_sum(int64_t n, const LawNumbers *laws, const int64_t *which, const double *overlap)
{
  double energy = 0.0;
  with_normal(*laws, [&](const auto &law) {
    for (int64_t k = 0; k < n; k++) energy += stored_energy(law, laws[which[k]], overlap[k]);
  });
  return energy;
}

#define JUMP_WHOLE_FORCES(FIELD) \
  FIELD(int64_t, n) FIELD(const LawNumbers *, laws) FIELD(const int64_t *, which) FIELD(const int64_t *, first) \
  FIELD(const int64_t *, second) FIELD(const double *, state) FIELD(int64_t, discs) FIELD(const double *, contact) \
  FIELD(int64_t, has_friction) FIELD(double, slope) FIELD(double *, fx) FIELD(double *, fy)
JUMP_INPUT(jump_whole_forces, JUMP_WHOLE_FORCES)

// Force of each contact on its second disc. state: u, v, rim (radius times spin) of each disc and, after them, of what
// never moves; contact: nx, ny, overlap, dashpot, ramp, velocity of the wall. n contacts each. slope: 1/eps of the sign law,
// s/m; has_friction 0: without friction.
JUMP_API void jump_whole_forces(const jump_whole_forces_input *input)
{
  JUMP_WHOLE_FORCES(JUMP_LOCAL)
  const double *const u = state, *const v = state + discs, *const rim = state + 2 * discs;
  Choice choice = choice_of(*laws, false, slope, 0.0);
  if (!has_friction) choice.tangential = Choice::NONE;
  with_slots(choice, [&](const auto &law) {
    for (int64_t k = 0; k < n; k++) {
      const int64_t i = first[k], j = second[k];
      const auto at = [&](int row) { return contact[row * n + k]; };
      const Numbers<double> of{laws[which[k]], at(3), at(4)};
      Stretch<double> held{};
      const double vx = u[j] - u[i] - at(5), vy = v[j] - v[i] - at(6);
      const Meeting<double> meeting{at(2), at(0), at(1), vx, vy, rim[i] + rim[j], 0.0};
      const ContactForce<double> out = contact_force(law, of, meeting, held);
      fx[k] = out.fx;
      fy[k] = out.fy;
    }
  });
}

#define JUMP_THRUST(FIELD) \
  FIELD(int64_t, n) FIELD(const double *, x) FIELD(const int64_t *, first) FIELD(const int64_t *, second) \
  FIELD(const double *, fx) FIELD(double, low) FIELD(double, width) FIELD(int64_t, bins) FIELD(double *, thrust)
JUMP_INPUT(jump_thrust, JUMP_THRUST)

// Adds the thrust of pairs along x: thrust[b] gains the mean, over the planes x = const of bin b, of the force that the
// discs left of the plane exert on those right of it. A contact acts through the planes between the two centres (method
// of planes, averaged). fx: force on the second disc.
JUMP_API void jump_thrust(const jump_thrust_input *input)
{
  JUMP_THRUST(JUMP_LOCAL)
  const Bins over{low, width, bins};
  for (int64_t p = 0; p < n; p++) {
    const double a = x[first[p]], b = x[second[p]], push = b > a ? fx[p] : -fx[p];
    over.between(a, b, [&](int64_t k, double inside) { thrust[k] += push * inside / width; });
  }
}

#define JUMP_CONTACT_FIELDS(FIELD) \
  FIELD(int64_t, n) FIELD(const LawNumbers *, laws) FIELD(const int64_t *, which) FIELD(const int64_t *, first) \
  FIELD(const int64_t *, second) FIELD(const double *, x) FIELD(const double *, state) FIELD(int64_t, discs) \
  FIELD(const double *, contact) FIELD(int64_t, rounds) FIELD(double, low) FIELD(double, width) FIELD(int64_t, bins) \
  FIELD(double *, fields)
JUMP_INPUT(jump_contact_fields, JUMP_CONTACT_FIELDS)

namespace jump {
namespace {

/** The contacts of a frame, by the law that acts along the normal. */
template <class Law> struct FrameContacts {
  const Law &law;
  const jump_contact_fields_input &in;

  double at(int row, int64_t k) const { return in.contact[row * in.n + k]; }
  Push<double> push(int64_t k, double opening) const
  {
    return normal_force(law, Numbers<double>{in.laws[in.which[k]], at(3, k), 0.0}, at(2, k), opening);
  }
  double opening(int64_t k, const double *u, const double *v) const
  {
    const int64_t i = in.first[k], j = in.second[k];
    return (u[j] - u[i]) * at(0, k) + (v[j] - v[i]) * at(1, k);
  }

  /** Velocities of the half step, from those of the step: once more with the forces that they give. */
  void go_back(std::vector<double> &hu, std::vector<double> &hv) const
  {
    const int64_t discs = in.discs;
    const double *const u = in.state, *const v = u + discs, *const kick = v + discs;
    const double *const weight_x = kick + discs, *const weight_y = weight_x + discs;
    std::vector<double> fx(weight_x, weight_x + discs), fy(weight_y, weight_y + discs);
    for (int64_t k = 0; k < in.n; k++) {
      const int64_t i = in.first[k], j = in.second[k];
      const double force = push(k, opening(k, hu.data(), hv.data())).whole;
      fx[j] += force * at(0, k);
      fy[j] += force * at(1, k);
      fx[i] -= force * at(0, k);
      fy[i] -= force * at(1, k);
    }
    for (int64_t i = 0; i < discs; i++) {
      hu[i] = u[i] - kick[i] * fx[i];
      hv[i] = v[i] - kick[i] * fy[i];
    }
  }

  /** Add contact k, whose force and its lost part are those of the half step. */
  void add(int64_t k, const Push<double> &push, const Bins &over) const
  {
    const double *const u = in.state, *const v = u + in.discs;
    const int64_t i = in.first[k], j = in.second[k], walls = in.discs - 1, bins = in.bins;
    const double ex = at(0, k), ey = at(1, k), share = i == walls ? 1.0 : 0.5;
    const double energy = share * stored_energy(law, in.laws[in.which[k]], at(2, k));
    for (const int64_t disc : {i, j}) {
      const int64_t b = disc < walls ? over.of(in.x[disc]) : -1;
      if (b < 0 || b >= bins) continue;
      in.fields[7 * bins + b] += energy;
      in.fields[8 * bins + b] += energy * u[disc];
      in.fields[9 * bins + b] -= share * push.dashpot * opening(k, u, v);
    }
    if (i == walls) return;
    // what the discs left of a plane do to those right of it
    const double mu = 0.5 * (u[i] + u[j]), mv = 0.5 * (v[i] + v[j]), thrust = push.whole * std::fabs(ex);
    const double power = push.whole * (ex * mu + ey * mv) * (ex > 0 ? 1.0 : -1.0);
    over.between(in.x[i], in.x[j], [&](int64_t b, double inside) {
      in.fields[5 * bins + b] += power * inside;
      in.fields[6 * bins + b] += thrust * inside;
    });
  }
};

}    // namespace
}    // namespace jump

// Adds power, thrust, elastic energy, its flux and dissipation of contacts to rows 5 to 9 of fields. A pair counts half
// at either disc; its force acts through the planes between the centres. state: u, v, kick (half a step over the mass)
// and weight along x and y of each disc, and then of what never moves; contact: nx, ny, overlap, dashpot.
// In each of `rounds` the velocities of the half step follow from the forces that they give.
JUMP_API void jump_contact_fields(const jump_contact_fields_input *input)
{
  const jump_contact_fields_input &in = *input;
  const double *const u = in.state, *const v = u + in.discs;
  with_normal(*in.laws, [&](const auto &law) {
    const FrameContacts<std::decay_t<decltype(law)>> contacts{law, in};
    std::vector<double> hu(u, u + in.discs), hv(v, v + in.discs);
    for (int64_t round = 0; round < in.rounds; round++) contacts.go_back(hu, hv);
    const Bins over{in.low, in.width, in.bins};
    for (int64_t k = 0; k < in.n; k++) contacts.add(k, contacts.push(k, contacts.opening(k, hu.data(), hv.data())), over);
  });
}
