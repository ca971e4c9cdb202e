// SPDX-License-Identifier: GPL-2.0-or-later
/* The walls of fix jump/step (what it is: fix_jump_step.h). */

#include "contact/no_contraction.h"

#include "fix_jump_step.h"

#include "pair_jump_disc.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "output.h"
#include "update.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>

using namespace LAMMPS_NS;

namespace {
constexpr int FACE_WORDS = 22;
}    // namespace

int FixJumpStep::add_wall(int a, int narg, char **arg)
{
  if (a + 5 > narg) error->all(FLERR, "fix jump/step: a wall needs NAME X0 Y0 DEEP N and N faces");
  Wall wall{arg[a], 0.0, 0.0, MAXBIGINT, -1, false, {}, -1.0, false, {}, {}, {}, {}, 0.0, {}, false, {}};
  for (const auto &other : walls)
    if (other.name == wall.name) error->all(FLERR, "fix jump/step: two walls are called '{}'", wall.name);
  wall.x0 = utils::numeric(FLERR, arg[a + 1], false, lmp);
  wall.y0 = utils::numeric(FLERR, arg[a + 2], false, lmp);
  wall.deep = utils::logical(FLERR, arg[a + 3], false, lmp);
  const int n = utils::inumeric(FLERR, arg[a + 4], false, lmp);
  a += 5;
  if (n < 1 || n > (narg - a) / FACE_WORDS)
    error->all(FLERR, "fix jump/step: wall '{}' needs {} numbers for each of {} faces", wall.name, FACE_WORDS, n);
  wall.faces.reserve(n);
  for (int f = 0; f < n; f++, a += FACE_WORDS) wall.faces.push_back(face_of(wall, n, a, arg));
  const std::map<std::string, int (FixJumpStep::*)(Wall &, int, int, char **) const> motions = {
      {"move", &FixJumpStep::add_motion}, {"lid", &FixJumpStep::add_lid}, {"hold", &FixJumpStep::add_hold},
      {"body", &FixJumpStep::add_body}, {"went", &FixJumpStep::add_went}, {"saw", &FixJumpStep::add_saw}};
  for (; a < narg; ) {
    const std::string key = arg[a];
    if (key == "until") {
      if (a + 1 >= narg) error->all(FLERR, "fix jump/step: the step at which wall '{}' goes is missing", wall.name);
      wall.until = utils::bnumeric(FLERR, arg[a + 1], false, lmp);
      a += 2;
    } else if (key == "law") {
      if (a + 4 >= narg) error->all(FLERR, "fix jump/step: the law of wall '{}' needs four numbers", wall.name);
      wall.own = true;
      for (int n = 0; n < 4; n++) wall.numbers[n] = utils::numeric(FLERR, arg[a + 1 + n], false, lmp);
      if (!(wall.numbers[0] > 0.0) || *std::min_element(wall.numbers, wall.numbers + 4) < 0.0)
        error->all(FLERR, "fix jump/step: the law of wall '{}' needs K above 0 and no negative number", wall.name);
      a += 5;
    } else if (key == "roll") {
      if (a + 1 >= narg) error->all(FLERR, "fix jump/step: the rolling friction of wall '{}' is missing", wall.name);
      wall.rolling = utils::numeric(FLERR, arg[a + 1], false, lmp);
      if (wall.rolling < 0.0) error->all(FLERR, "fix jump/step: the rolling friction of wall '{}' is negative", wall.name);
      a += 2;
    } else if (key == "seam") {
      wall.seam = true;
      a++;
    } else if (const auto motion = motions.find(key); motion != motions.end()) {
      a = (this->*motion->second)(wall, a + 1, narg, arg);
    } else break;
  }
  number_chains(wall);
  walls.push_back(wall);
  return a;
}

/** The way of a wall, from its words. */
int FixJumpStep::add_motion(Wall &wall, int a, int narg, char **arg) const
{
  if (a + 4 > narg) error->all(FLERR, "fix jump/step: move of wall '{}' needs CX CY START N and N rows", wall.name);
  auto next = [&]() { return utils::numeric(FLERR, arg[a++], false, lmp); };
  auto &motion = wall.motion;
  motion.moves = true;
  motion.cx = next();
  motion.cy = next();
  motion.start = (double) utils::bnumeric(FLERR, arg[a++], false, lmp);
  const int n = utils::inumeric(FLERR, arg[a++], false, lmp);
  if (n < 0 || n > (narg - a) / jump::TRACK_WORDS)
    error->all(FLERR, "fix jump/step: move of wall '{}' needs {} numbers for each of {} rows", wall.name,
               jump::TRACK_WORDS, n);
  motion.track.resize(n);
  double *const numbers = reinterpret_cast<double *>(motion.track.data());
  for (int k = 0; k < n * jump::TRACK_WORDS; k++) numbers[k] = next();
  wall.far = far_of(wall);
  return a;
}

/** Largest distance of a wall's faces from its point of turning, m. */
double FixJumpStep::far_of(const Wall &wall) const
{
  double far = 0.0;
  for (const auto &face : wall.faces) {
    const jump::Extent box = jump::box_of(face, false);
    for (const double x : {box.xlo, box.xhi})
      for (const double y : {box.ylo, box.yhi}) far = std::max(far, std::hypot(x - wall.motion.cx, y - wall.motion.cy));
  }
  return far;
}

/** Mass and force of a wall that discs push, from its words. */
int FixJumpStep::add_lid(Wall &wall, int a, int narg, char **arg) const
{
  if (a + 9 > narg) error->all(FLERR, "fix jump/step: lid of wall '{}' needs nine numbers", wall.name);
  auto next = [&]() { return utils::numeric(FLERR, arg[a++], false, lmp); };
  auto &motion = wall.motion;
  auto &lid = motion.load;
  motion.moves = motion.is_lid = true;
  motion.cx = next();
  motion.cy = next();
  motion.start = (double) utils::bnumeric(FLERR, arg[a++], false, lmp);
  lid.mass = lid.inertia = next();
  for (double &force : lid.force) force = next();
  for (double *const free : {&lid.free[0], &lid.free[1]}) *free = utils::logical(FLERR, arg[a++], false, lmp);
  lid.begin = next();
  if (!(lid.mass > 0.0)) error->all(FLERR, "fix jump/step: the mass of wall '{}' must be above 0", wall.name);
  note_ends(wall);
  return a;
}

/** Where an earlier run has left a wall, from its words. */
int FixJumpStep::add_went(Wall &wall, int a, int narg, char **arg) const
{
  if (a + 9 > narg) error->all(FLERR, "fix jump/step: went of wall '{}' needs nine numbers", wall.name);
  if (!wall.motion.is_lid) error->all(FLERR, "fix jump/step: wall '{}' that went is no lid, gate or body", wall.name);
  auto &motion = wall.motion;
  motion.went = true;
  for (double *const of : {motion.pushed.place, motion.speed, motion.pushed.speed})
    for (int axis = 0; axis < 3; axis++) of[axis] = utils::numeric(FLERR, arg[a++], false, lmp);
  for (int axis = 0; axis < 3; axis++) {
    if (!(motion.load.free[axis] > 0.0)) motion.speed[axis] = motion.pushed.speed[axis] = 0.0;
    motion.pushed.before[axis] = motion.pushed.speed[axis];
  }
  return a;
}

/** The area that a gate saw last in an earlier run, m^2. */
int FixJumpStep::add_saw(Wall &wall, int a, int narg, char **arg) const
{
  if (a >= narg) error->all(FLERR, "fix jump/step: what wall '{}' saw is missing", wall.name);
  wall.hold.area = utils::numeric(FLERR, arg[a], false, lmp);
  return a + 1;
}

/** Speeds of the half step before the start, of a wall that goes on, from that of the step and its force there. */
void FixJumpStep::step_back(Motion &motion) const
{
  const auto &load = motion.load;
  auto &pushed = motion.pushed;
  for (int axis = 0; axis < 3; axis++) {
    if (!(load.free[axis] > 0.0)) continue;
    const double force = pushed.force[axis] + load.own(axis, pushed.place[2]);
    pushed.speed[axis] = motion.speed[axis] - 0.5 * update->dt * force / load.resistance(axis);
  }
}

/** What an earlier run gives to one that begins from it: released, place, speeds of the step, of the half step and of the one
    before, force, area and time of a gate's last look; by wall. Behind it the slots of corners. */
double FixJumpStep::pushed_state(int n) const
{
  for (const auto &wall : walls) {
    if (!wall.motion.is_lid) continue;
    if ((n -= PUSHED_WORDS) >= 0) continue;
    n += PUSHED_WORDS;
    const auto &motion = wall.motion;
    const auto &pushed = motion.pushed;
    if (n == 0) return pushed.phase == jump::HAS_MOVED;
    if (n == 16) return wall.hold.area;
    if (n == 17) {
      const auto &hold = wall.hold;
      return hold.every > 0 ? (double) ((update->ntimestep - hold.first) % hold.every) * update->dt : 0.0;
    }
    jump::Placed at = motion.placed;
    jump::centre(at, pushed, motion.load, update->dt);
    const double speed[3] = {at.centred.x, at.centred.y, at.centred.angle};
    const double *const parts[] = {pushed.place, speed, pushed.speed, pushed.before, pushed.force};
    return parts[(n - 1) / 3][(n - 1) % 3];
  }
  const size_t slots = bodies.partner.size(), at = n % slots;
  const std::vector<double> *const values[] = {&bodies.sigma, &bodies.spring, &bodies.roll};
  return n < (int) slots ? (double) bodies.partner[at] : (*values[n / slots - 1])[at];
}

bool FixJumpStep::is_there(const Wall &wall) const { return update->ntimestep < wall.until; }

/** One of the n faces of a wall, from its words. */
jump::Face FixJumpStep::face_of(const Wall &wall, int n, int a, char **arg) const
{
  auto integer = [&]() { return utils::inumeric(FLERR, arg[a++], false, lmp); };
  auto next = [&]() { return utils::numeric(FLERR, arg[a++], false, lmp); };
  // the words of a list in braces are read in their order
  jump::Face f{};
  for (int64_t *const word : {&f.kind, &f.run, &f.loop, &f.before, &f.after, &f.at_start, &f.at_end}) *word = integer();
  for (double *const word : {&f.x0, &f.y0, &f.x1, &f.y1, &f.tx0, &f.ty0, &f.tx1, &f.ty1, &f.cx, &f.cy, &f.radius, &f.phi,
                             &f.sweep, &f.length, &f.arc_length})
    *word = next();
  if (f.kind != jump::SEGMENT && f.kind != jump::ARC)
    error->all(FLERR, "fix jump/step: a face of wall '{}' is a segment (0) or an arc (1), not {}", wall.name, f.kind);
  auto check = [&](int64_t joint, int64_t neighbour) {
    if (joint < jump::CONVEX || joint > jump::ENDLESS)
      error->all(FLERR, "fix jump/step: a joint of wall '{}' has the unknown kind {}", wall.name, joint);
    if (joint < jump::FREE && (neighbour < 0 || neighbour >= n))
      error->all(FLERR, "fix jump/step: a joint of wall '{}' has no face {}", wall.name, neighbour);
  };
  check(f.at_start, f.before);
  check(f.at_end, f.after);
  return f;
}

void FixJumpStep::place_walls()
{
  for (auto &wall : walls) {
    auto &motion = wall.motion;
    if (!motion.moves) continue;
    const jump::Clock clock{motion.start, update->dt};
    if (motion.is_lid) jump::follow(motion.placed, motion.pushed, motion.load, clock, (double) update->ntimestep, false);
    else jump::follow(motion.placed, motion.track.data(), (int64_t) motion.track.size(), clock.time((double) update->ntimestep), update->dt);
    if (motion.is_lid && domain->xperiodic) require_off_seam(wall);
  }
}

/** Walls do not repeat with the period: beyond the seam discs would not feel one that they have pushed there. */
void FixJumpStep::require_off_seam(const Wall &wall) const
{
  const double low = wall.low + wall.motion.placed.now.x, high = wall.high + wall.motion.placed.now.x, margin = pair->largest;
  if (low < domain->boxlo[0] + margin || high > domain->boxhi[0] - margin)
    error->all(FLERR, "fix jump/step: wall '{}' comes to the seam on step {}", wall.name, update->ntimestep);
}

/** Whether discs or walls have moved so far that the lists may miss a contact. */
bool FixJumpStep::is_worn() const
{
  if (near_order != pair->order || update->setupflag || !(near_moved < near_margin)) return true;
  return any_moves && std::any_of(walls.begin(), walls.end(), [&](const Wall &wall) {
    const auto &motion = wall.motion;
    return motion.moves &&
           !(M_SQRT2 * near_moved + jump::travel(motion.placed.now, motion.listed, wall.far) < near_margin);
  });
}

/** Discs that can touch a wall before one of them has moved by the margin. */
void FixJumpStep::find_near()
{
  near_moved = 0.0;
  near_order = pair->order;
  for (auto &wall : walls) {
    const auto view = wall.in_place();
    wall.motion.listed = wall.motion.placed.now;
    if (!is_there(wall)) wall.near.clear();
    else if (!wall.motion.moves) wall.near.list(view.faces, atom->nlocal, pair->disc.data());
    else {
      std::vector<PairJumpDisc::PackedDisc> seen(pair->disc.begin(), pair->disc.begin() + atom->nlocal);
      for (auto &disc : seen) view.see(disc.x, disc.y);
      wall.near.list(view.faces, atom->nlocal, seen.data());
    }
  }
  if (bodies.there) find_corners();
}

/** Force of a contact on a disc and on the wall; (x, y): the disc in the wall's own frame.

    Sizes and spins are looked at here: contacts with walls are few, and compiled once for each law. */
template <class Law>
void FixJumpStep::touch(const Wall &wall, const Law &law, int i, const jump::FaceContact &where, double x, double y,
                        double *on_wall)
{
  const auto &a = pair->disc[i];
  const bool spins = Law::Friction::HAS_FRICTION && pair->spin;
  auto at = wall.in_place().at(where, a.x, a.y, pair->radius_of(i), a.vx, a.vy, spins ? pair->spins[i] : 0.0);
  if (!spins) at.turns = 0.0;
  if (!pair->sizes || wall.motion.is_body) at.size = 1.0;    // the dashpot is that of equal discs, or of this contact
  const double to = wall.in_place().arm(at.gap, at.radius), to_x = to * at.nx, to_y = to * at.ny;
  jump::Numbers<double> of = jump::numbers_of(wall.law.of, 0.0);
  if (wall.motion.is_body) of = numbers_at_body(wall, of, i, at);
  const jump::WallForce<double> out = jump::wall_contact<true, true>(law, of, at,
                                                                     AtomWallHistory(*this, wall, i, (int) where.face, x, y));
  if (pair->record) {
    pair->record->push_back({(int32_t) pair->tags[i], (int32_t) (-1 - (&wall - walls.data())), (float) (a.x - to_x),
                             (float) (a.y - to_y), (float) out.fx, (float) out.fy, NAN});
    return;
  }
  double *const f = &pair->pushes[2 * i];
  f[0] += out.fx;
  f[1] += out.fy;
  if (spins) pair->turns[i] += out.torque;
  const auto &motion = wall.motion;
  const double x0 = motion.moves ? motion.cx + motion.placed.now.x : wall.x0;
  const double y0 = motion.moves ? motion.cy + motion.placed.now.y : wall.y0;
  on_wall[0] -= out.fx;
  on_wall[1] -= out.fy;
  on_wall[2] -= (a.x - to_x - x0) * out.fy - (a.y - to_y - y0) * out.fx;
  if (motion.is_body) on_wall[2] -= at.radius * out.resist;    // what rolls turns the body
}

/** Forces of a wall on its discs, or on those of one part (from 0), and the sums on the wall. */
template <class Law>
void FixJumpStep::push(const Wall &wall, const Law &law, int part, double *on_wall)
{
  const auto *const disc = pair->disc.data();
  const bool stays = pair->any_fixed();
  const jump::WallInPlace view = wall.in_place();
  jump::FaceContact found[jump::MOST];
  const auto &near = wall.near;
  const int rows = (int) near.discs.size();
  for (int r = 0; r < rows; r++) {
    const int i = near.discs[r], first = near.last[r], count = near.last[r + 1] - first;
    if (part >= 0 && pair->part_of(i) != part) continue;
    if (stays && pair->is_fixed(i) && !wall.motion.is_body) continue;    // walls and fixed discs do not feel each other
    double x = disc[i].x, y = disc[i].y;
    view.see(x, y);
    const double radius = pair->radius_of(i);
    const int *const listed = &near.near[first];
    const int64_t only = count == 1 ? listed[0] : wall.deep ? -1 : view.faces.only(listed, count, x, y, radius);
    if (only >= 0 && wall.faces[only].kind == jump::SEGMENT) {    // most rows; the same as below
      const jump::Face &face = wall.faces[only];
      const jump::FaceContact line = view.faces.on_line(only, x, y);
      if (line.gap >= radius) continue;
      if (line.gap > 0.0 && !face.is_before(x, y) && !face.is_behind(x, y)) {
        touch(wall, law, i, line, x, y, on_wall);
        continue;
      }
    }
    const int contacts = view.faces.touching(listed, count, x, y, radius, found);
    for (int c = 0; c < contacts; c++) touch(wall, law, i, found[c], x, y, on_wall);
  }
}

template <class Law> void FixJumpStep::push(Wall &wall, const Law &law)
{
  double on_wall[4] = {0.0, 0.0, 0.0, 0.0};
  const bool sums = wall.probe >= 0 || wall.motion.is_lid || pair->record;    // in the order of the discs
  const bool alone = sums || Law::Friction::HAS_HISTORY || wall.near.discs.size() < FEW_NEAR;
  const int parts = alone ? 0 : pair->number_of_parts();
  if (parts > 0) {
    pair->pool.run(parts, [&](int part) {
      double of_part[4] = {0.0, 0.0, 0.0, 0.0};
      push(wall, law, part, of_part);
    });
    return;
  }
  push(wall, law, -1, on_wall);
  if (pair->record) return;    // the forces of this step are summed already
  wall.motion.pushed.force[0] = on_wall[0];
  wall.motion.pushed.force[1] = on_wall[1];
  wall.motion.pushed.force[2] = on_wall[2];
  const auto &rate = wall.motion.placed.centred;
  // of lids and bodies it is known later (`push_lids`)
  on_wall[3] = wall.motion.is_lid ? 0.0 : -(on_wall[0] * rate.x + on_wall[1] * rate.y + on_wall[2] * rate.angle);
  if (wall.probe >= 0)
    for (int c = 0; c < columns; c++) window[columns * wall.probe + c] += on_wall[c];
}

/** Forces of a wall on its discs, and what a probe sums. */
void FixJumpStep::push(Wall &wall)
{
  auto &choice = wall.law.choice;
  choice.slope = jump::sign_slope(pair->largest_speed);
  choice.time_step = pair->slots.grows ? update->dt : 0.0;
  jump::with_slots(choice, [&](const auto &law) { push(wall, law); });
}

/** Put the contacts of all ranks into the file, with the forces of this step. */
void FixJumpStep::write_contacts()
{
  std::vector<jump::ContactRow> rows, all;
  pair->list_contacts(rows);
  const bool grew = pair->slots.grows;
  pair->slots.grows = false;
  pair->record = &rows;
  for (auto &wall : walls)
    if (is_there(wall)) push(wall);
  pair->record = nullptr;
  pair->slots.grows = grew;
  const int own = (int) (rows.size() * sizeof(jump::ContactRow));
  std::vector<int> sizes(comm->nprocs), places(comm->nprocs, 0);
  MPI_Gather(&own, 1, MPI_INT, sizes.data(), 1, MPI_INT, 0, world);
  for (int rank = 1; rank < comm->nprocs; rank++) places[rank] = places[rank - 1] + sizes[rank - 1];
  all.resize((places.back() + sizes.back()) / sizeof(jump::ContactRow));
  MPI_Gatherv(rows.data(), own, MPI_BYTE, all.data(), sizes.data(), places.data(), MPI_BYTE, 0, world);
  if (comm->me == 0 && !jump::put_rows(contacts.file, update->ntimestep, all))
    error->one(FLERR, "fix jump/step: the file {} of contacts cannot be written", contacts.file);
}

/** Rows of the walls that discs push, behind those that are there. */
void FixJumpStep::write_poses()
{
  if (comm->me != 0) return;
  FILE *const file = std::fopen(poses.file.c_str(), "a");
  if (!file) error->one(FLERR, "fix jump/step: the file {} of poses cannot be written", poses.file);
  for (const auto &wall : walls) {
    if (!wall.motion.is_lid) continue;
    const auto &[x, y, angle] = wall.motion.pushed.place;
    std::fprintf(file, "%.15g,%s,%.17g,%.17g,%.17g\n", ((double) update->ntimestep - wall.motion.start) * update->dt,
                 wall.name.c_str(), x, y, angle);
  }
  std::fclose(file);
}

/** The force on each lid is that of all ranks; its power is that of its velocity at the step. */
void FixJumpStep::push_lids()
{
  for (auto &wall : walls) {
    auto &motion = wall.motion;
    if (!motion.is_lid) continue;
    double *const force = motion.pushed.force;
    const double here[3] = {force[0], force[1], force[2]};
    MPI_Allreduce(here, force, 3, MPI_DOUBLE, MPI_SUM, world);
    if (bodies.there) {
      const size_t number = &wall - walls.data();
      jump::Sum &sum = bodies.window[number];
      sum.x += force[0];
      sum.y += force[1];
      sum.moment += force[2];
      const jump::Sum &more = bodies.taken[number].all;
      force[0] += more.x;
      force[1] += more.y;
      force[2] += more.moment;
      jump::centre(motion.placed, motion.pushed, motion.load, update->dt);
    }
    if (motion.went && update->setupflag && update->ntimestep == 0) {
      step_back(motion);
      jump::centre(motion.placed, motion.pushed, motion.load, update->dt);
    }
    if (wall.probe < 0) continue;
    jump::Placed at = motion.placed;
    jump::centre(at, motion.pushed, motion.load, update->dt);
    window[columns * wall.probe + 3] -= here[0] * at.centred.x;
    window[columns * wall.probe + 3] -= here[1] * at.centred.y;
    if (motion.is_body) window[columns * wall.probe + 3] -= here[2] * at.centred.angle;
  }
}

void FixJumpStep::post_force(int)
{
  if (any_moves) place_walls();
  if (is_worn()) find_near();
  const std::vector<double> before = update->setupflag ? window : std::vector<double>();
  for (auto &wall : walls)
    if (is_there(wall)) push(wall);
  if (pair->slots.grows) pair->in_parts(atom->nlocal, [&](int from, int to, int) { pair->slots.end(from, to); });
  // the first forces of a run that goes on are those of a step whose contacts are in the file
  const bool again = update->setupflag && update->ntimestep > 0;
  if (contacts.is_due(update->ntimestep) && !again) write_contacts();
  if (poses.is_due(update->ntimestep) && !again) write_poses();
  if (bodies.there) push_bodies();
  push_lids();
  if (bodies.there) write_bodies(again);
  if (!update->setupflag) move_gates();
  if (others_push || update->setupflag || update->ntimestep == update->laststep || update->ntimestep == output->next)
    pair->hand_over_forces();
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
