// SPDX-License-Identifier: GPL-2.0-or-later
/* The walls of fix jump/step (what it is: fix_jump_step.h). */

#include "fix_jump_step.h"

#include "pair_jump_disc.h"

#include "atom.h"
#include "error.h"
#include "update.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <type_traits>

using namespace LAMMPS_NS;
using jump::ContactForce;
using jump::Friction;
using jump::Touch;

int FixJumpStep::add_wall(int a, int narg, char **arg)
{
  auto text = [&](int at) -> std::string {
    if (at >= narg) error->all(FLERR, "fix jump/step: a wall is not complete");
    return arg[at];
  };
  auto number = [&](int at) { return utils::numeric(FLERR, text(at), false, lmp); };
  const std::string kind = text(a);
  Wall wall{text(a + 1), 0.0, 0.0, MAXBIGINT, -1};
  for (const auto &other : walls)
    if (other.name == wall.name) error->all(FLERR, "fix jump/step: two walls are called '{}'", wall.name);
  const int index = (int) walls.size();
  auto plane = [&](bool along_x, double at, double sign) {
    faces.push_back({along_x ? PLANE_X : PLANE_Y, index, at, sign, 0.0, 0.0, 0.0, 0.0, {}});
  };
  if (kind == "plane") {
    const std::string axis = text(a + 2), side = text(a + 4);
    if (axis != "x" && axis != "y") error->all(FLERR, "fix jump/step: the axis of a plane is x or y, not '{}'", axis);
    if (side != "above" && side != "below")
      error->all(FLERR, "fix jump/step: the side of a plane is above or below, not '{}'", side);
    const double at = number(a + 3);
    (axis == "x" ? wall.x0 : wall.y0) = at;
    plane(axis == "x", at, side == "above" ? 1.0 : -1.0);
    a += 5;
  } else if (kind == "block" || kind == "box") {
    const double xlo = number(a + 2), xhi = number(a + 3), ylo = number(a + 4), yhi = number(a + 5);
    // a block may be without thickness: a sheet that discs on both sides feel
    if (xlo > xhi || ylo > yhi || (kind == "box" && (xlo == xhi || ylo == yhi)))
      error->all(FLERR, "fix jump/step: wall '{}' has no extent", wall.name);
    wall.x0 = xlo;
    wall.y0 = ylo;
    if (kind == "block") {
      faces.push_back({BLOCK, index, 0.0, 0.0, xlo, xhi, ylo, yhi, {}});
    } else {
      plane(true, xlo, 1.0);
      plane(true, xhi, -1.0);
      plane(false, ylo, 1.0);
      plane(false, yhi, -1.0);
    }
    a += 6;
  } else {
    error->all(FLERR, "fix jump/step: a wall is a plane, block or box, not '{}'", kind);
  }
  if (a < narg && strcmp(arg[a], "until") == 0) {
    wall.until = utils::bnumeric(FLERR, text(a + 1), false, lmp);
    a += 2;
  }
  walls.push_back(wall);
  return a;
}

/** Distance of a place, m, and its vector from the face; below 0 behind a plane, infinite inside a block. */
double FixJumpStep::Face::distance(double x, double y, double &dx, double &dy) const
{
  if (kind == BLOCK) {
    dx = x - std::min(std::max(x, xlo), xhi);
    dy = y - std::min(std::max(y, ylo), yhi);
    const double away = std::sqrt(dx * dx + dy * dy);
    return away > 0.0 ? away : HUGE_VAL;
  }
  dx = kind == PLANE_X ? x - at : 0.0;
  dy = kind == PLANE_Y ? y - at : 0.0;
  return sign * (dx + dy);
}

/** Discs that can reach a face before one of them has moved by the margin. */
void FixJumpStep::find_near()
{
  const double margin = 0.5 * pair->largest + NEAR_MARGIN * pair->diameter;
  near_moved = 0.0;
  near_order = pair->order;
  const int n = atom->nlocal;
  const auto *const disc = pair->disc.data();
  for (auto &face : faces) {
    face.near.clear();
    if (update->ntimestep >= walls[face.wall].until) continue;
    for (int i = 0; i < n; i++) {
      bool close;
      if (face.kind == BLOCK)
        close = disc[i].x > face.xlo - margin && disc[i].x < face.xhi + margin && disc[i].y > face.ylo - margin &&
            disc[i].y < face.yhi + margin;
      else
        close = face.sign * ((face.kind == PLANE_X ? disc[i].x : disc[i].y) - face.at) < margin;
      if (close) face.near.push_back(i);
    }
  }
}

template <Friction FRICTION, Touch TOUCH, class Own>
void FixJumpStep::touch(const Face &face, int i, double dx, double dy, const Own &own, double *on_wall)
{
  const auto &a = pair->disc[i];
  const double rim = jump::has_spin(FRICTION) ? pair->rim[i] : 0.0;
  const ContactForce<double> out = jump::contact_force<FRICTION, TOUCH>(law, own, dx, dy, a.vx, a.vy, rim);
  double *const f = atom->f[i];
  f[0] += out.fx;
  f[1] += out.fy;
  if (jump::has_spin(FRICTION)) atom->torque[i][2] -= pair->radius_of(i) * out.twist;
  const Wall &wall = walls[face.wall];
  on_wall[0] -= out.fx;
  on_wall[1] -= out.fy;
  on_wall[2] -= (a.x - dx - wall.x0) * out.fy - (a.y - dy - wall.y0) * out.fx;
}

template <Friction FRICTION, Touch TOUCH, bool SIZES> void FixJumpStep::push()
{
  double reach = law.reach;
  using Own = std::conditional_t<SIZES, jump::OwnLaw<double>, const jump::Law &>;
  const auto own = [&]() -> Own {
    if constexpr (SIZES) return jump::own_law(law, reach);
    else return law;
  };
  const auto *const disc = pair->disc.data();
  for (const auto &face : faces) {
    const Wall &wall = walls[face.wall];
    if (update->ntimestep >= wall.until) continue;
    double on_wall[3] = {0.0, 0.0, 0.0};
    for (const int i : face.near) {
      if (SIZES) reach = pair->radii[i];
      double dx, dy;
      const double distance = face.distance(disc[i].x, disc[i].y, dx, dy);
      if (distance >= reach) continue;
      if (distance > 0.0) {
        touch<FRICTION, TOUCH>(face, i, dx, dy, own(), on_wall);
      } else {
        // the centre is behind the plane: the push back goes on growing (contact of the same overlap in front)
        auto behind = own();
        behind.reach = 2.0 * reach - distance;
        const double front = face.sign * reach;
        touch<FRICTION, TOUCH>(face, i, face.kind == PLANE_X ? front : 0.0, face.kind == PLANE_Y ? front : 0.0, behind,
                               on_wall);
      }
    }
    if (wall.probe >= 0)
      for (int c = 0; c < 3; c++) window[3 * wall.probe + c] += on_wall[c];
  }
}

void FixJumpStep::post_force(int)
{
  if (near_order != pair->order || update->setupflag || !(near_moved < NEAR_MARGIN * pair->diameter)) find_near();
  law.eps = jump::SIGN_RAMP * pair->largest_speed;
  const std::vector<double> before = update->setupflag ? window : std::vector<double>();
  jump::with_branch(friction, pair->touch, [&](auto f, auto t) {
    constexpr Friction F = decltype(f)::value;
    constexpr Touch T = decltype(t)::value;
    pair->sizes ? push<F, T, true>() : push<F, T, false>();
  });
  if (update->setupflag) {
    // the forces of the start belong to no window; they are what a probe shows at the first step
    if (update->ntimestep == 0)
      for (size_t c = 0; c < window.size(); c++) mean[c] = window[c];
    window = before;
    return;
  }
  if (probed.empty()) return;
  window_steps++;
  if (update->ntimestep % probe_every == 0) {
    for (size_t c = 0; c < window.size(); c++) {
      mean[c] = window[c] / (double) window_steps;
      window[c] = 0.0;
    }
    window_steps = 0;
  }
}
