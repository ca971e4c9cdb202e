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

namespace {
constexpr int FACE_WORDS = 22;
constexpr double ON_FACE = 1e-100;    // m; the square of a smaller distance may be 0
}    // namespace

int FixJumpStep::add_wall(int a, int narg, char **arg)
{
  if (a + 5 > narg) error->all(FLERR, "fix jump/step: a wall needs NAME X0 Y0 DEEP N and N faces");
  Wall wall{arg[a], 0.0, 0.0, MAXBIGINT, -1, {}, {}};
  for (const auto &other : walls)
    if (other.name == wall.name) error->all(FLERR, "fix jump/step: two walls are called '{}'", wall.name);
  wall.x0 = utils::numeric(FLERR, arg[a + 1], false, lmp);
  wall.y0 = utils::numeric(FLERR, arg[a + 2], false, lmp);
  wall.faces.deep = utils::logical(FLERR, arg[a + 3], false, lmp);
  const int n = utils::inumeric(FLERR, arg[a + 4], false, lmp);
  a += 5;
  if (n < 1 || n > (narg - a) / FACE_WORDS)
    error->all(FLERR, "fix jump/step: wall '{}' needs {} numbers for each of {} faces", wall.name, FACE_WORDS, n);
  wall.faces.faces.reserve(n);
  for (int f = 0; f < n; f++, a += FACE_WORDS) wall.faces.faces.push_back(face_of(wall, n, a, arg));
  if (a < narg && strcmp(arg[a], "until") == 0) {
    if (a + 1 >= narg) error->all(FLERR, "fix jump/step: the step at which wall '{}' goes is missing", wall.name);
    wall.until = utils::bnumeric(FLERR, arg[a + 1], false, lmp);
    a += 2;
  }
  walls.push_back(wall);
  return a;
}

/** One of the n faces of a wall, from its words. */
jump::Face FixJumpStep::face_of(const Wall &wall, int n, int a, char **arg) const
{
  auto integer = [&]() { return utils::inumeric(FLERR, arg[a++], false, lmp); };
  auto next = [&]() { return utils::numeric(FLERR, arg[a++], false, lmp); };
  // the words of a list in braces are read in their order
  const jump::Face f{integer(), integer(), integer(), integer(), integer(), integer(), integer(), next(),
                     next(),    next(),    next(),    next(),    next(),    next(),    next(),    next(),
                     next(),    next(),    next(),    next(),    next(),    next()};
  if (f.kind != jump::SEGMENT && f.kind != jump::ARC)
    error->all(FLERR, "fix jump/step: a face of wall '{}' is a segment (0) or an arc (1), not {}", wall.name, f.kind);
  auto check = [&](int joint, int neighbour) {
    if (joint < jump::CONVEX || joint > jump::ENDLESS)
      error->all(FLERR, "fix jump/step: a joint of wall '{}' has the unknown kind {}", wall.name, joint);
    if (joint < jump::FREE && (neighbour < 0 || neighbour >= n))
      error->all(FLERR, "fix jump/step: a joint of wall '{}' has no face {}", wall.name, neighbour);
  };
  check(f.at_start, f.before);
  check(f.at_end, f.after);
  return f;
}

/** Discs that can touch a wall before one of them has moved by the margin. */
void FixJumpStep::find_near()
{
  near_moved = 0.0;
  near_order = pair->order;
  for (auto &wall : walls) {
    if (update->ntimestep < wall.until) wall.near.list(wall.faces, atom->nlocal, pair->disc.data());
    else wall.near.clear();
  }
}

/** Force of a contact on a disc at (dx, dy) from its partner; (to_x, to_y) is the way from the contact to the disc. */
template <Friction FRICTION, Touch TOUCH, class Own>
void FixJumpStep::touch(const Wall &wall, int i, double dx, double dy, double to_x, double to_y, const Own &own,
                        double *on_wall)
{
  const auto &a = pair->disc[i];
  const double rim = jump::has_spin(FRICTION) ? pair->rim[i] : 0.0;
  const ContactForce<double> out = jump::contact_force<FRICTION, TOUCH>(law, own, dx, dy, a.vx, a.vy, rim);
  double *const f = atom->f[i];
  f[0] += out.fx;
  f[1] += out.fy;
  if (jump::has_spin(FRICTION)) atom->torque[i][2] -= pair->radius_of(i) * out.twist;
  on_wall[0] -= out.fx;
  on_wall[1] -= out.fy;
  on_wall[2] -= (a.x - to_x - wall.x0) * out.fy - (a.y - to_y - wall.y0) * out.fx;
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
  jump::FaceContact found[jump::MOST];
  for (const auto &wall : walls) {
    if (update->ntimestep >= wall.until) continue;
    double on_wall[3] = {0.0, 0.0, 0.0};
    const auto &near = wall.near;
    const int rows = (int) near.discs.size();
    for (int r = 0; r < rows; r++) {
      const int i = near.discs[r], first = near.last[r], count = near.last[r + 1] - first;
      const double x = disc[i].x, y = disc[i].y;
      if (SIZES) reach = pair->radii[i];
      const int *const listed = &near.near[first];
      const int only = count == 1 ? listed[0] : wall.faces.deep ? -1 : wall.faces.only(listed, count, x, y, reach);
      if (only >= 0 && wall.faces.faces[only].kind == jump::SEGMENT) {    // most rows; the same as below
        const jump::Face &face = wall.faces.faces[only];
        const double gap = face.off_line(x, y);
        if (gap >= reach) continue;
        if (gap > ON_FACE && face.is_beside(x, y)) {
          const double dx = gap * -face.ty0, dy = gap * face.tx0;
          touch<FRICTION, TOUCH>(wall, i, dx, dy, dx, dy, own(), on_wall);
          continue;
        }
      }
      const int contacts = wall.faces.touching(listed, count, x, y, reach, found);
      for (int c = 0; c < contacts; c++) {
        const auto &at = found[c];
        if (at.gap > ON_FACE) {
          touch<FRICTION, TOUCH>(wall, i, at.dx, at.dy, at.dx, at.dy, own(), on_wall);
        } else {
          // the centre is behind the face: the push back goes on growing (contact of the same overlap in front)
          auto behind = own();
          behind.reach = 2.0 * reach - at.gap;
          touch<FRICTION, TOUCH>(wall, i, reach * at.nx, reach * at.ny, at.gap * at.nx, at.gap * at.ny, behind, on_wall);
        }
      }
    }
    if (wall.probe >= 0)
      for (int c = 0; c < 3; c++) window[3 * wall.probe + c] += on_wall[c];
  }
}

void FixJumpStep::post_force(int)
{
  if (near_order != pair->order || update->setupflag || !(near_moved < near_margin)) find_near();
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
