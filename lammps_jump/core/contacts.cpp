// SPDX-License-Identifier: GPL-2.0-or-later
// Contacts of one frame for the analysis: which discs touch a wall, forces and energy by the law, and their sums.

#include <algorithm>
#include <vector>

#include "api.h"
#include "contact.h"
#include "near.h"

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

// Contacts of discs with one wall in its own frame: their number, of which what fits into `room` is written. Contact k is
// of disc index[k]; found[k] takes its signed distance and normal. The cells are those of scene/near.py.
JUMP_API int64_t jump_touch_wall(int64_t n, const double *x, const double *y, const double *radius, const Face *faces,
                                 int64_t deep, const double *place, const int64_t *cells, const int64_t *start,
                                 const int64_t *listed, int64_t *index, double *found, int64_t room)
{
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

// Of the laws of a scene, that of two discs and those of its walls behind it, `which` is that of each contact. Its dashpot
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

// Force of each contact on its second disc. state: u, v, rim (radius times spin) of each disc and, behind them, of what
// never moves; contact: nx, ny, overlap, dashpot, ramp, velocity of the wall. n contacts each. slope: 1/eps of the sign law,
// s/m; rubs 0: without friction.
JUMP_API void jump_whole_forces(int64_t n, const LawNumbers *laws, const int64_t *which, const int64_t *first,
                                const int64_t *second, const double *state, int64_t discs, const double *contact,
                                int64_t rubs, double slope, double *fx, double *fy)
{
  const double *const u = state, *const v = state + discs, *const rim = state + 2 * discs;
  const auto tangential = !rubs ? Choice::NONE : laws->sign_ramp > 0.0 ? Choice::SIGN : Choice::RAMP;
  with_slots({tangential, laws->touch > 0.0, slope, 0.0}, [&](const auto &law) {
    for (int64_t k = 0; k < n; k++) {
      const int64_t i = first[k], j = second[k];
      const auto at = [&](int row) { return contact[row * n + k]; };
      const Numbers<double> of{laws[which[k]], at(3), at(4)};
      Stretch<double> held{};
      const ContactForce<double> out = contact_force(law, of, at(2), at(0), at(1), u[j] - u[i] - at(5), v[j] - v[i] - at(6),
                                              rim[i] + rim[j], 0.0, held);
      fx[k] = out.fx;
      fy[k] = out.fy;
    }
  });
}

// Adds the thrust of pairs along x: thrust[b] gains the mean, over the planes x = const of bin b, of the force that the
// discs left of the plane exert on those right of it. A contact acts through the planes between the two centres (method
// of planes, averaged). fx: force on the second disc.
JUMP_API void jump_thrust(int64_t n, const double *x, const int64_t *first, const int64_t *second, const double *fx,
                          double low, double width, int64_t bins, double *thrust)
{
  const Bins over{low, width, bins};
  for (int64_t p = 0; p < n; p++) {
    const double a = x[first[p]], b = x[second[p]], push = b > a ? fx[p] : -fx[p];
    over.between(a, b, [&](int64_t k, double inside) { thrust[k] += push * inside / width; });
  }
}

// Adds power, thrust, elastic energy, its flux and dissipation of contacts to rows 5 to 9 of fields. A pair counts half
// at either disc; its force acts through the planes between the centres. state: u, v, kick (half a step over the mass)
// and weight along x and y of each disc, and of what never moves behind them; contact: nx, ny, overlap, dashpot.
// In each of `rounds` the velocities of the half step follow from the forces that they give.
JUMP_API void jump_contact_fields(int64_t n, const LawNumbers *laws, const int64_t *which, const int64_t *first,
                                  const int64_t *second, const double *x, const double *state, int64_t discs,
                                  const double *contact, int64_t rounds, double low, double width, int64_t bins,
                                  double *fields)
{
  const Bins over{low, width, bins};
  const double *const u = state, *const v = u + discs, *const kick = v + discs;
  const double *const weight_x = kick + discs, *const weight_y = weight_x + discs;
  const int64_t walls = discs - 1;
  with_normal(*laws, [&](const auto &law) {
    const auto at = [&](int row, int64_t k) { return contact[row * n + k]; };
    const auto push_of = [&](int64_t k, double opening) {
      return normal_force(law, Numbers<double>{laws[which[k]], at(3, k), 0.0}, at(2, k), opening);
    };
    const auto opening_of = [&](int64_t k, const double *a, const double *b) {
      const int64_t i = first[k], j = second[k];
      return (a[j] - a[i]) * at(0, k) + (b[j] - b[i]) * at(1, k);
    };
    std::vector<double> hu(u, u + discs), hv(v, v + discs);
    for (int64_t round = 0; round < rounds; round++) {
      std::vector<double> fx(weight_x, weight_x + discs), fy(weight_y, weight_y + discs);
      for (int64_t k = 0; k < n; k++) {
        const int64_t i = first[k], j = second[k];
        const double force = push_of(k, opening_of(k, hu.data(), hv.data())).whole;
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
    for (int64_t k = 0; k < n; k++) {
      const int64_t i = first[k], j = second[k];
      const double ex = at(0, k), ey = at(1, k);
      const auto [force, dash] = push_of(k, opening_of(k, hu.data(), hv.data()));
      const double opening = opening_of(k, u, v), share = i == walls ? 1.0 : 0.5;
      const double energy = share * stored_energy(law, laws[which[k]], at(2, k));
      for (const int64_t disc : {i, j}) {
        const int64_t b = disc < walls ? over.of(x[disc]) : -1;
        if (b < 0 || b >= bins) continue;
        fields[7 * bins + b] += energy;
        fields[8 * bins + b] += energy * u[disc];
        fields[9 * bins + b] -= share * dash * opening;
      }
      if (i == walls) continue;
      // what the discs left of a plane do to those right of it
      const double mu = 0.5 * (u[i] + u[j]), mv = 0.5 * (v[i] + v[j]), push = force * std::fabs(ex);
      const double power = force * (ex * mu + ey * mv) * (ex > 0 ? 1.0 : -1.0);
      over.between(x[i], x[j], [&](int64_t b, double inside) {
        fields[5 * bins + b] += power * inside;
        fields[6 * bins + b] += push * inside;
      });
    }
  });
}
