// SPDX-License-Identifier: GPL-2.0-or-later
/* Bodies of fix jump/step (what it is: fix_jump_step.h): walls that are pushed as lids are, and meet walls and each other. */

#include "contact/no_contraction.h"

#include "fix_jump_step.h"

#include "pair_jump_disc.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "update.h"

#include <cmath>
#include <cstdio>
#include <limits>

using namespace LAMMPS_NS;

/** Mass, weight, freedom and velocities of a body, from its words. */
int FixJumpStep::add_body(Wall &wall, int a, int narg, char **arg) const
{
  if (a + 16 > narg) error->all(FLERR, "fix jump/step: body '{}' needs sixteen numbers", wall.name);
  auto next = [&]() { return utils::numeric(FLERR, arg[a++], false, lmp); };
  auto &motion = wall.motion;
  motion.moves = motion.is_lid = motion.is_body = true;
  motion.cx = next();
  motion.cy = next();
  motion.start = (double) utils::bnumeric(FLERR, arg[a++], false, lmp);
  auto &load = motion.load;
  load.mass = next();
  load.inertia = next();
  for (double *const part : {&load.force[0], &load.force[1], &load.arm[0], &load.arm[1]}) *part = next();
  for (double &free : load.free) free = utils::logical(FLERR, arg[a++], false, lmp);
  load.begin = next();
  for (int axis = 0; axis < 3; axis++) motion.pushed.speed[axis] = motion.pushed.before[axis] = next();
  if (!(load.mass > 0.0 && load.inertia > 0.0))
    error->all(FLERR, "fix jump/step: body '{}' needs MASS and INERTIA above 0", wall.name);
  wall.far = far_of(wall);
  return a;
}

/** Corners of walls, contacts between them, and the file of bodies, from their words. */
int FixJumpStep::add_corners(int a, int narg, char **arg)
{
  constexpr int CORNER = 8, MEETS = 7;
  auto need = [&](int count) {
    if (a + count > narg) error->all(FLERR, "fix jump/step: bodies needs more numbers");
  };
  auto next = [&]() { return utils::numeric(FLERR, arg[a++], false, lmp); };
  auto whole = [&]() { return utils::inumeric(FLERR, arg[a++], false, lmp); };
  auto number = [&]() {
    const int wall = whole();
    if (wall < 0 || wall >= (int) walls.size()) error->all(FLERR, "fix jump/step: bodies names wall {}", wall);
    return wall;
  };
  need(6);
  bodies.there = true;
  bodies.every = whole();
  bodies.file = arg[a++];
  bodies.limit = next();
  bodies.damping_ratio = next();
  const int n = whole();
  need(n * CORNER + 1);
  for (int i = 0; i < n; i++) {
    jump::Corner corner{};
    for (double *const part : {&corner.x, &corner.y, &corner.radius, &corner.tx0, &corner.ty0, &corner.tx1, &corner.ty1})
      *part = next();
    corner.wall = number();
    bodies.corners.push_back(corner);
  }
  const int m = whole();
  need(m * MEETS);
  bodies.between.assign(walls.size() * walls.size(), {});
  for (int i = 0; i < m; i++) {
    const int one = number(), other = number();
    auto &law = bodies.between[one * walls.size() + other];
    for (double *const part : {&law.law.stiffness, &law.law.damping, &law.law.tangential, &law.lag, &law.law.friction})
      *part = next();
  }
  if (bodies.every < 1) error->all(FLERR, "fix jump/step: bodies every {} steps: must be above 0", bodies.every);
  bodies.make_slots();
  for (const auto &wall : walls)
    if (wall.motion.is_body) bodies.start = wall.motion.start;
  return a < narg && std::string(arg[a]) == "held" ? add_held(a + 1, narg, arg) : a;
}

/** Contacts of corners that an earlier run has left, from their words. */
int FixJumpStep::add_held(int a, int narg, char **arg)
{
  constexpr int HELD = 5;
  const int n = a < narg ? utils::inumeric(FLERR, arg[a++], false, lmp) : -1;
  if (n < 0 || a + n * HELD > narg) error->all(FLERR, "fix jump/step: held needs N and N contacts of five numbers");
  for (int row = 0; row < n; row++) {
    const int corner = utils::inumeric(FLERR, arg[a++], false, lmp);
    if (corner < 0 || corner >= (int) bodies.corners.size())
      error->all(FLERR, "fix jump/step: held names corner {}", corner);
    size_t slot = (size_t) corner * bodies.SLOTS;
    const size_t end = slot + bodies.SLOTS - 1;
    while (bodies.partner[slot] != 0 && slot < end) slot++;
    bodies.partner[slot] = utils::bnumeric(FLERR, arg[a++], false, lmp);
    for (auto *const of : {&bodies.sigma, &bodies.spring, &bodies.roll})
      (*of)[slot] = utils::numeric(FLERR, arg[a++], false, lmp);
  }
  return a;
}

/** The walls as the core takes them, and the cells that find their faces near a corner. */
void FixJumpStep::prepare_bodies()
{
  if (!bodies.there) return;
  auto &b = bodies;
  double largest = 0.0;
  for (const auto &corner : b.corners) largest = std::max(largest, corner.radius);
  b.faces.clear();
  for (auto *const of : {&b.first, &b.deep, &b.moving, &b.chain}) of->clear();
  b.around.clear();
  b.about.clear();
  b.centre.clear();
  b.load.clear();
  b.near.resize(walls.size());
  for (size_t w = 0; w < walls.size(); w++) {
    const Wall &wall = walls[w];
    const auto &motion = wall.motion;
    const int64_t first = (int64_t) b.faces.size();
    for (jump::Face face : wall.faces) {
      face.before += face.before >= 0 ? first : 0;
      face.after += face.after >= 0 ? first : 0;
      b.faces.push_back(face);
    }
    b.first.push_back(first);
    b.deep.push_back(wall.deep);
    b.moving.push_back(motion.is_body ? jump::BODY : motion.is_lid ? jump::LOADED : motion.moves ? jump::FOLLOWS : jump::STANDS);
    for (const double chain : wall.chain) b.chain.push_back((int64_t) chain);
    b.around.insert(b.around.end(), wall.around.begin(), wall.around.end());
    b.about.push_back(motion.moves ? std::array<double, 2>{motion.cx, motion.cy} : std::array<double, 2>{wall.x0, wall.y0});
    b.centre.push_back({motion.cx, motion.cy});
    b.load.push_back(motion.load);
    // two walls may have moved by the margin each since they were listed
    b.near[w].prepare(wall.in_place().faces, (int) wall.faces.size(), largest, 2.0 * near_margin,
                      std::max(pair->diameter, 2.0 * largest));
  }
  for (auto &law : b.between) {    // attraction and rolling are of discs
    law.law.touch = pair->input_law.touch;
    law.law.spring_ratio = pair->input_law.spring_ratio;
    law.law.spring_damping = b.damping_ratio;
  }
  b.placed.resize(walls.size());
  b.pushed.resize(walls.size());
  b.taken.resize(walls.size());
  b.sums.resize(walls.size());
  b.window.assign(walls.size(), {});
}

/** List the corners near each wall. */
void FixJumpStep::find_corners()
{
  struct CornerPlace {
    double x, y;
  };
  constexpr double nowhere = std::numeric_limits<double>::quiet_NaN();
  std::vector<CornerPlace> places;
  for (const auto &corner : bodies.corners) {
    CornerPlace at{corner.x, corner.y};
    walls[corner.wall].in_place().show(at.x, at.y);
    places.push_back(is_there(walls[corner.wall]) ? at : CornerPlace{nowhere, nowhere});
  }
  for (size_t w = 0; w < walls.size(); w++) {
    const auto view = walls[w].in_place();
    std::vector<CornerPlace> seen(places);
    for (size_t i = 0; i < seen.size(); i++) {
      const bool meets = bodies.between[bodies.corners[i].wall * walls.size() + w].law.stiffness > 0.0;
      if (meets) view.see(seen[i].x, seen[i].y);
      else seen[i].x = nowhere;
    }
    if (is_there(walls[w])) bodies.near[w].list(view.faces, (int) seen.size(), seen.data());
    else bodies.near[w].clear();
  }
  bodies.join_lists();
}

/** Forces of bodies on each other and on walls; those of discs are there. */
void FixJumpStep::push_bodies()
{
  auto &b = bodies;
  for (size_t w = 0; w < walls.size(); w++) {
    b.placed[w] = walls[w].motion.placed;
    b.pushed[w] = walls[w].motion.pushed;
    b.taken[w] = {};
    b.sums[w] = {};
  }
  b.bind();
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  bool rubs = false;
  for (const auto &law : b.between) rubs |= law.law.friction > 0.0;
  jump_state &s = b.of_walls;
  s.pair.touch = pair->input_law.touch;
  s.pair.friction = rubs ? 1.0 : none;
  s.pair.sign_ramp = pair->sign ? jump::SIGN_RAMP : 0.0;
  s.partner = pair->springs ? b.partner.data() : nullptr;
  s.memory_step = b.of_corners.memory_step = pair->slots.grows ? update->dt : 0.0;
  jump::push_bodies(s, jump::sign_slope(pair->largest_speed));
  if (pair->springs && pair->slots.grows) b.end_contacts();
  require_sound_bodies();
  for (size_t w = 0; w < walls.size(); w++) {
    if (walls[w].probe < 0 || comm->me != 0) continue;    // the sums of ranks are added later
    double *const row = window.data() + columns * walls[w].probe;
    row[0] += b.sums[w].force.x;
    row[1] += b.sums[w].force.y;
    row[2] += b.sums[w].force.moment;
  }
}

/** End the run where bodies lie in something, or have left the domain. */
void FixJumpStep::require_sound_bodies()
{
  auto &b = bodies;
  const auto name = [&](double wall) { return walls[(size_t) wall].name; };
  if (b.deepest[0] > b.limit)
    error->all(FLERR,
               "fix jump/step: '{}' and '{}' overlap by {:.4g} m on step {}, beyond the limit of {:.4g} m: the contact is "
               "too soft for a body of this mass and speed; give the body or the wall a stiffness of its own, or a larger "
               "corner_radius", name(b.deepest[1]), name(b.deepest[2]), b.deepest[0], update->ntimestep, b.limit);
  b.deepest[0] = 0.0;
  if (b.full) error->all(FLERR, "fix jump/step: a corner touches more than the {} faces that it can remember", b.SLOTS);
  for (size_t w = 0; w < walls.size(); w++) {
    if (!walls[w].motion.is_body) continue;
    double at[2];
    centre_of(walls[w], at);
    for (int axis = 0; axis < 2; axis++)
      if (!(at[axis] >= domain->boxlo[axis] && at[axis] <= domain->boxhi[axis]))
        error->all(FLERR, "fix jump/step: body '{}' has left the domain at ({:.4g}, {:.4g}) m on step {}: widen domain, or "
                   "put a wall there", walls[w].name, at[0], at[1], update->ntimestep);
  }
}

/** Numbers of the contact of disc i with a body, from those of a nominal disc, or of a radius of 1 m. */
jump::Numbers<double> FixJumpStep::numbers_at_body(const Wall &wall, const jump::Numbers<double> &of, int i,
                                                   const jump::AtWall<double> &at) const
{
  const auto &motion = wall.motion;
  const double nominal = 0.5 * pair->diameter, unit = pair->sizes ? pair->mass / (nominal * nominal) : pair->mass;
  const double square = at.radius * at.radius, mass = pair->sizes ? unit * square : unit;
  const jump::DiscMass disc{mass, 0.5 * mass * square, pair->is_fixed(i)};
  const double arm[2] = {pair->disc[i].x - at.radius * at.nx - motion.cx - motion.placed.now.x,
                         pair->disc[i].y - at.radius * at.ny - motion.cy - motion.placed.now.y};
  return jump::numbers_at_body(of, unit, disc, motion.load, motion.pushed, arm, at);
}

/** Centre of mass of a body, m. */
void FixJumpStep::centre_of(const Wall &wall, double *at) const
{
  const auto &motion = wall.motion;
  const auto &now = motion.placed;
  const double *const arm = motion.load.arm;
  at[0] = motion.cx + now.now.x + now.c * arm[0] - now.s * arm[1];
  at[1] = motion.cy + now.now.y + now.s * arm[0] + now.c * arm[1];
}

/** Rows of the file of bodies, where they are due; `of_discs`: force of the discs of all ranks at this step. */
void FixJumpStep::write_bodies(bool again)
{
  auto &b = bodies;
  const bigint step = update->ntimestep;
  const bool starts = update->setupflag;
  if (starts && (again || step > 0)) return;
  if (!starts) b.window_steps++;
  if (step % b.every) return;
  FILE *const file = comm->me == 0 ? std::fopen(b.file.c_str(), "a") : nullptr;
  if (comm->me == 0 && !file) error->one(FLERR, "fix jump/step: the file {} of bodies cannot be written", b.file);
  const double steps = b.window_steps > 0 ? (double) b.window_steps : 1.0;
  for (size_t w = 0; w < walls.size(); w++) {
    const Wall &wall = walls[w];
    const auto &motion = wall.motion;
    if (!motion.is_body) continue;
    double at[2];
    centre_of(wall, at);
    const auto &v = motion.placed.centred;
    const double ax = at[0] - motion.cx - motion.placed.now.x, ay = at[1] - motion.cy - motion.placed.now.y;
    const jump::Sum &sum = b.window[w];
    if (file)
      std::fprintf(file, "%.10g,%s,%.15g,%.15g,%.15g,%.15g,%.15g,%.15g,%.15g,%.15g,%.15g\n",
                   ((double) step - b.start) * update->dt, wall.name.c_str(), at[0], at[1], motion.placed.now.angle,
                   v.x - v.angle * ay, v.y + v.angle * ax, v.angle, sum.x / steps, sum.y / steps, sum.moment / steps);
    b.window[w] = {};
  }
  b.window_steps = 0;
  if (file) std::fclose(file);
}

/** What of bodies is no function of the step. */
void FixJumpStep::pack_bodies(std::vector<double> &state) const
{
  for (const auto &wall : walls)
    if (wall.motion.is_body) {
      const auto &pushed = wall.motion.pushed;
      for (const double *const of : {pushed.place, pushed.speed, pushed.before, pushed.force})
        state.insert(state.end(), of, of + 3);
    }
  for (const int64_t partner : bodies.partner) state.push_back((double) partner);
  for (const auto *const of : {&bodies.sigma, &bodies.spring, &bodies.roll}) state.insert(state.end(), of->begin(), of->end());
}

const double *FixJumpStep::unpack_bodies(const double *state)
{
  for (auto &wall : walls)
    if (wall.motion.is_body) {
      auto &pushed = wall.motion.pushed;
      for (double *const of : {pushed.place, pushed.speed, pushed.before, pushed.force}) {
        std::copy_n(state, 3, of);
        state += 3;
      }
    }
  for (int64_t &partner : bodies.partner) partner = (int64_t) *state++;
  for (auto *const of : {&bodies.sigma, &bodies.spring, &bodies.roll}) {
    std::copy_n(state, of->size(), of->begin());
    state += of->size();
  }
  return state;
}
