// SPDX-License-Identifier: GPL-2.0-or-later
/* The walls, bodies and tailgates of fix jump/step (what it is: fix_jump_step.h): the core's, for the discs of LAMMPS on all ranks. */

#include "fix_jump_step.h"

#include "pair_jump_disc.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "memory.h"
#include "output.h"
#include "update.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

using namespace LAMMPS_NS;

/** Take away the walls whose time is over; whether any went. */
bool FixJumpStep::take_away()
{
  bool any = false;
  for (int64_t wall = 0; wall < state->walls; wall++) {
    if (state->gone[wall] || update->ntimestep < events->until[wall]) continue;
    any = state->gone[wall] = true;
    if (state->moving) state->moving[wall] = jump::STANDS;
  }
  return any;
}

/** Whether discs or walls have moved so far that the lists may miss a contact. */
bool FixJumpStep::is_worn() const
{
  return near_order != pair->order || update->setupflag || walls_left || !(near_moved < near_margin);
}

/** List the discs and corners near walls. */
void FixJumpStep::find_near()
{
  near_moved = 0.0;
  near_order = pair->order;
  walls_left = false;
  for (int64_t k = 0; k < state->n; k++) {
    state->x0[k] = pair->rows()[k][0];
    state->y0[k] = pair->rows()[k][1];
  }
  jump::list_walls(*state, pair->partition.rooms);
  pair->walls_unseen = true;
}

/** Forces of the walls on the discs, and what these do to the walls. */
void FixJumpStep::push_walls()
{
  const jump_state &s = *state;
  const double slope = pair->slope();
  pair->partition.each([&](jump::ThreadPart &part) {
    jump::wall_forces(s, slope, part);
    if (s.fixed) jump::clear_fixed(s, part);
    if (s.partner && part.memory->goes_on) part.memory->each_at_wall(part, [&](int64_t i) { jump::end_contacts(s, i, i + 1); });
  });
  if (s.walls == 0) return;
  jump::sum_walls(s, pair->partition.parts);
  end_pushed();
}

/** Walls that are pushed feel the discs of all ranks, and bodies each other. */
void FixJumpStep::end_pushed()
{
  const jump_state &s = *state;
  for (const int64_t wall : pushed_walls) {
    const jump::Sum here = s.wall_loads[wall].of_discs;
    MPI_Allreduce(&here.x, &s.wall_loads[wall].all.x, 3, MPI_DOUBLE, MPI_SUM, world);
    felt[wall] += s.wall_loads[wall].all;
  }
  if (s.corners) push_bodies();
  if (!s.moving) return;
  const std::vector<jump::SumsOnWall> sums(s.wall_sum, s.wall_sum + s.walls);
  jump::end_walls(s);
  if (went.empty() || !update->setupflag || update->ntimestep > 0) return;
  for (const Went &one : went) step_back(one);
  std::copy(sums.begin(), sums.end(), s.wall_sum);
  jump::end_walls(s);    // with the speeds of the half step before
}

/** Forces of bodies on each other and on walls. */
void FixJumpStep::push_bodies()
{
  const jump_state &s = *state;
  const std::vector<jump::SumsOnWall> sums(s.wall_sum, s.wall_sum + s.walls);
  jump::body_forces(s, pair->slope());
  if (s.partner && pair->goes_on()) jump::end_contacts(*s.corners, 0, s.corners->n);
  if (comm->me != 0) std::copy(sums.begin(), sums.end(), s.wall_sum);    // those of ranks are added later
  require_sound_bodies();
}

/** Speeds of the half step before the start, of a wall that goes on, from that of the step and its force there. */
void FixJumpStep::step_back(const Went &one)
{
  const jump::Load &load = state->load[one.wall];
  jump::Pushed &wall = state->pushed[one.wall];
  for (int axis = 0; axis < 3; axis++) {
    if (!(load.free[axis] > 0.0)) continue;
    const double force = wall.force[axis] + load.own(axis, wall.place[2]);
    wall.speed[axis] = one.speed[axis] - 0.5 * update->dt * force / load.resistance(axis);
  }
}

/** End the run where bodies lie in something, or have left the domain. */
void FixJumpStep::require_sound_bodies() const
{
  const jump_state &s = *state;
  if (s.deepest[0] > body_limit)
    error->all(FLERR,
               "fix jump/step: '{}' and '{}' overlap by {:.4g} m on step {}, beyond the limit of {:.4g} m: the contact is "
               "too soft for a body of this mass and speed; give the body or the wall a stiffness of its own, or a larger "
               "corner_radius", names[(size_t) s.deepest[1]], names[(size_t) s.deepest[2]], s.deepest[0], update->ntimestep,
               body_limit);
  s.deepest[0] = 0.0;
  if (s.corners->full && *s.corners->full)
    error->all(FLERR, "fix jump/step: a corner touches more than the {} faces that it can remember", s.corners->slots);
  for (const int64_t wall : pushed_walls) {
    if (s.moving[wall] != jump::BODY) continue;
    double at[2];
    centre_of(wall, at);
    for (int axis = 0; axis < 2; axis++)
      if (!(at[axis] >= domain->boxlo[axis] && at[axis] <= domain->boxhi[axis]))
        error->all(FLERR, "fix jump/step: body '{}' has left the domain at ({:.4g}, {:.4g}) m on step {}: widen domain, or "
                   "put a wall there", names[wall], at[0], at[1], update->ntimestep);
  }
}

/** Walls do not repeat with the period: beyond the seam discs would not feel one that they have pushed there. */
void FixJumpStep::require_off_seam() const
{
  for (const int64_t wall : pushed_walls) {
    const double way = state->pushed[wall].place[0], *const ends = state->lists->ends[wall];
    if (ends[0] + way < domain->boxlo[0] + pair->largest || ends[1] + way > domain->boxhi[0] - pair->largest)
      error->all(FLERR, "fix jump/step: wall '{}' comes to the seam on step {}", names[wall], update->ntimestep);
  }
}

/** Let the gates whose turn it is look at the discs of all ranks. */
void FixJumpStep::move_gates()
{
  for (int64_t k = 0; k < events->tailgates; k++) {
    jump::TailgateController &gate = events->tailgate[k];
    if (!gate.looks(update->ntimestep)) continue;
    std::vector<double> here(gate.bins, 0.0), all(gate.bins);
    for (int64_t k = 0; k < state->n; k++) {
      if (jump::is_fixed(*state, k)) continue;
      const double diameter = 2.0 * jump::radius_of(*state, k);
      gate.add(here, pair->rows()[k][0], diameter * diameter);
    }
    MPI_Allreduce(here.data(), all.data(), (int) gate.bins, MPI_DOUBLE, MPI_SUM, world);
    jump::Pushed &wall = state->pushed[events->tailgate_wall[k]];
    wall.speed[1] = gate.look(all, wall.place[1], update->dt);
  }
}

const jump::TailgateController *FixJumpStep::tailgate_of(int64_t wall) const
{
  for (int64_t k = 0; k < events->tailgates; k++)
    if (events->tailgate_wall[k] == wall) return events->tailgate + k;
  return nullptr;
}

/** What an earlier run gives to one that begins from it: released, place, speeds of the step, of the half step and of the one
    before, force, area and time of a gate's last look; by wall. Behind it the slots of corners. */
double FixJumpStep::pushed_state(int n) const
{
  if (n >= PUSHED_WORDS * (int) pushed_walls.size()) {
    const jump_state &c = *state->corners;
    const int64_t of = (n - PUSHED_WORDS * (int64_t) pushed_walls.size()) / (c.n * c.slots);
    const int64_t at = (n - PUSHED_WORDS * (int64_t) pushed_walls.size()) % (c.n * c.slots);
    if (!c.partner) return 0.0;
    const double *const values[] = {c.sigma, c.spring, c.roll};
    return of == 0 ? (double) c.partner[at] : values[of - 1][at];
  }
  const int64_t wall = pushed_walls[n / PUSHED_WORDS];
  const jump::Pushed &own = state->pushed[wall];
  const jump::TailgateController *const gate = tailgate_of(wall);
  n %= PUSHED_WORDS;
  if (n == 0) return own.phase == jump::HAS_MOVED;
  if (n == 16) return gate ? gate->area : NAN;
  if (n == 17) return gate ? (double) ((update->ntimestep - gate->first) % gate->every) * update->dt : 0.0;
  const jump::Pose &now = state->placed[wall].centred;
  const double speed[3] = {now.x, now.y, now.angle};
  const double *const all[] = {own.place, speed, own.speed, own.before, own.force};
  return all[(n - 1) / 3][(n - 1) % 3];
}

/** Centre of mass of a body, m. */
void FixJumpStep::centre_of(int64_t wall, double *at) const
{
  const jump::Placed &now = state->placed[wall];
  const double *const arm = state->load[wall].arm;
  at[0] = state->centre[wall][0] + now.now.x + now.c * arm[0] - now.s * arm[1];
  at[1] = state->centre[wall][1] + now.now.y + now.s * arm[0] + now.c * arm[1];
}

/** Rows of the file of bodies, where they are due: the mean force of the discs of all ranks since the last. */
void FixJumpStep::write_bodies(bool again)
{
  const bigint step = update->ntimestep;
  const bool starts_here = update->setupflag;
  if (starts_here && (again || step > 0)) return;
  if (!starts_here) felt_steps++;
  if (!rows_of_bodies.is_due(step)) return;
  FILE *const file = comm->me == 0 ? std::fopen(rows_of_bodies.file.c_str(), "a") : nullptr;
  if (comm->me == 0 && !file)
    error->one(FLERR, "fix jump/step: the file {} of bodies cannot be written", rows_of_bodies.file);
  const double steps = felt_steps > 0 ? (double) felt_steps : 1.0;
  for (const int64_t wall : pushed_walls) {
    if (state->moving[wall] == jump::BODY && file) {
      double at[2];
      centre_of(wall, at);
      const jump::Placed &now = state->placed[wall];
      const jump::Pose &v = now.centred;
      const double ax = at[0] - state->centre[wall][0] - now.now.x, ay = at[1] - state->centre[wall][1] - now.now.y;
      const jump::Sum &sum = felt[wall];
      std::fprintf(file, "%.10g,%s,%.15g,%.15g,%.15g,%.15g,%.15g,%.15g,%.15g,%.15g,%.15g\n",
                   state->clock->clock().time((double) step), names[wall].c_str(), at[0], at[1], now.now.angle,
                   v.x - v.angle * ay, v.y + v.angle * ax, v.angle, sum.x / steps, sum.y / steps, sum.moment / steps);
    }
    felt[wall] = {};
  }
  felt_steps = 0;
  if (file) std::fclose(file);
}

/** The contacts of this rank's discs, with the forces of this step. */
void FixJumpStep::list_contacts(std::vector<jump::ContactRow> &rows)
{
  const double goes_on = state->memory_step;
  state->memory_step = 0.0;
  pair->store();
  const jump::ContactVelocities seen = jump::seen_by(*state);
  std::vector<std::array<int64_t, 2>> who;
  std::vector<std::array<double, 5>> found;
  int64_t count = -1;
  while (count < 0) {
    who.resize(2 * who.size() + 256);
    found.resize(who.size());
    count = jump::list_contacts(*state, pair->slope(), seen, seen,
                                {reinterpret_cast<int64_t (*)[2]>(who.data()), reinterpret_cast<double (*)[5]>(found.data()), (int64_t) who.size()});
  }
  state->memory_step = goes_on;
  for (int64_t c = 0; c < count; c++) {
    const auto &at = found[c];
    rows.push_back({(int32_t) who[c][0], (int32_t) who[c][1], (float) at[0], (float) at[1], (float) at[2], (float) at[3], NAN});
  }
}

/** Put the contacts of all ranks into the file, with the forces of this step. */
void FixJumpStep::write_contacts()
{
  std::vector<jump::ContactRow> rows, all;
  list_contacts(rows);
  const int own = (int) (rows.size() * sizeof(jump::ContactRow));
  std::vector<int> sizes(comm->nprocs), places(comm->nprocs, 0);
  MPI_Gather(&own, 1, MPI_INT, sizes.data(), 1, MPI_INT, 0, world);
  for (int rank = 1; rank < comm->nprocs; rank++) places[rank] = places[rank - 1] + sizes[rank - 1];
  all.resize((places.back() + sizes.back()) / sizeof(jump::ContactRow));
  MPI_Gatherv(rows.data(), own, MPI_BYTE, all.data(), sizes.data(), places.data(), MPI_BYTE, 0, world);
  if (comm->me == 0 && !jump::put_rows(contacts.file, update->ntimestep, all))
    error->one(FLERR, "fix jump/step: the file {} of contacts cannot be written", contacts.file);
}

/** Rows of the walls that discs push, after those that are there. */
void FixJumpStep::write_poses() const
{
  if (comm->me != 0) return;
  FILE *const file = std::fopen(poses.file.c_str(), "a");
  if (!file) error->one(FLERR, "fix jump/step: the file {} of poses cannot be written", poses.file);
  for (const int64_t wall : pushed_walls) {
    const double *const place = state->pushed[wall].place;
    std::fprintf(file, "%.15g,%s,%.17g,%.17g,%.17g\n", state->clock->clock().time((double) update->ntimestep),
                 names[wall].c_str(), place[0], place[1], place[2]);
  }
  std::fclose(file);
}

/** End the window of the probes at its step; the forces of the start are what a probe shows first, and belong to none. */
void FixJumpStep::close_window()
{
  const bool at_start = update->setupflag;
  window_steps += !at_start;
  if (at_start ? update->ntimestep > 0 : update->ntimestep % probe_every != 0) return;
  const double steps = at_start ? 1.0 : (double) window_steps;
  for (size_t probe = 0; probe < probed.size(); probe++) {
    const jump::SumsOnWall &sum = state->wall_sum[probed[probe]];
    const double values[] = {sum.force.x, sum.force.y, sum.force.moment, sum.power};
    for (int c = 0; c < columns; c++) mean[columns * probe + c] = values[c] / steps;
  }
  std::fill_n(state->wall_sum, state->walls, jump::SumsOnWall{});
  window_steps = 0;
}

void FixJumpStep::post_force(int)
{
  const bool again = update->setupflag && update->ntimestep > 0;
  const std::vector<jump::SumsOnWall> before(state->wall_sum, state->wall_sum + state->walls);
  const bool fewer = take_away();
  if (state->moving && update->setupflag) jump::place_walls(*state, (double) update->ntimestep);
  if (domain->xperiodic) require_off_seam();
  if (fewer || is_worn()) find_near();
  if (pair->walls_unseen) pair->partition.memory.see_walls(*state);
  pair->walls_unseen = false;
  push_walls();
  // the first forces of a run that goes on are those of a step whose contacts are in the file
  if (contacts.is_due(update->ntimestep) && !again) write_contacts();
  if (poses.is_due(update->ntimestep) && !again) write_poses();
  if (rows_of_bodies.every > 0) write_bodies(again);
  if (!update->setupflag) move_gates();
  if (others_push || update->setupflag || update->ntimestep == update->laststep || update->ntimestep == output->next)
    pair->hand_over_forces();
  close_window();
  if (update->setupflag) std::copy(before.begin(), before.end(), state->wall_sum);
}

/** Calls run(number) for all that of pushed walls is no function of the step. */
template <class Run> void FixJumpStep::each_number_of_bodies(const Run &run)
{
  for (const int64_t wall : pushed_walls) {
    jump::Pushed &own = state->pushed[wall];
    for (double *const of : {own.place, own.speed, own.before, own.force})
      for (int axis = 0; axis < 3; axis++) run(of[axis]);
  }
  for (int64_t k = 0; k < events->tailgates; k++) run(events->tailgate[k].area);
  const jump_state *const c = state->corners;
  if (!c || !c->partner) return;
  for (int64_t at = 0; at < c->n * c->slots; at++) {
    run(reinterpret_cast<double &>(c->partner[at]));
    for (double *const of : {c->sigma, c->spring, c->roll}) run(of[at]);
  }
}

void FixJumpStep::write_restart(FILE *fp)
{
  if (comm->me != 0) return;
  std::vector<double> numbers;
  each_number_of_bodies([&](double &number) { numbers.push_back(number); });
  const int size = (int) (numbers.size() * sizeof(double));
  fwrite(&size, sizeof(int), 1, fp);
  fwrite(numbers.data(), sizeof(double), numbers.size(), fp);
}

void FixJumpStep::restart(char *buf)
{
  const auto *from = reinterpret_cast<const double *>(buf);
  each_number_of_bodies([&](double &number) { number = *from++; });
}

int FixJumpStep::add_slots(int a, int narg, char **arg)
{
  const int slots = a < narg ? utils::inumeric(FLERR, arg[a], false, lmp) : 0;
  if (slots < 1 || slots > MOST_SLOTS)
    error->all(FLERR, "fix jump/step: slots {}; allowed is 1 to {}", slots, MOST_SLOTS);
  size_peratom_cols = maxexchange = SLOT * slots;
  peratom_flag = peratom_freq = create_attribute = restart_peratom = 1;
  FixJumpStep::grow_arrays(atom->nmax);
  for (int i = 0; i < atom->nlocal; i++) FixJumpStep::set_arrays(i);
  for (const int kind : {Atom::GROW, Atom::RESTART}) atom->add_callback(kind);
  return a + 1;
}

FixJumpStep::~FixJumpStep()
{
  if (!array_atom) return;
  for (const int kind : {Atom::GROW, Atom::RESTART}) atom->delete_callback(id, kind);
  memory->destroy(array_atom);
}

void FixJumpStep::grow_arrays(int room)
{
  memory->grow(array_atom, room, size_peratom_cols, "jump/step:slots");
}

void FixJumpStep::copy_arrays(int from, int to, int)
{
  pair->put_slots();    // before LAMMPS moves the first disc
  std::copy_n(array_atom[from], size_peratom_cols, array_atom[to]);
}

/** A new disc has no contacts, and waits for its own size. */
void FixJumpStep::set_arrays(int i)
{
  newcomers = true;
  if (array_atom) std::fill_n(array_atom[i], size_peratom_cols, 0.0);
}

int FixJumpStep::pack_exchange(int i, double *to)
{
  pair->put_slots();
  std::copy_n(array_atom[i], size_peratom_cols, to);
  return size_peratom_cols;
}

int FixJumpStep::unpack_exchange(int i, double *from)
{
  std::copy_n(from, size_peratom_cols, array_atom[i]);
  return size_peratom_cols;
}

int FixJumpStep::pack_restart(int i, double *to)
{
  *to = size_restart(i);
  pack_exchange(i, to + 1);
  return size_restart(i);
}

/** The numbers of this fix come after those of the `nth` fixes before it, each led by its count. */
void FixJumpStep::unpack_restart(int i, int nth)
{
  const double *from = atom->extra[i];
  for (int n = 0; n < nth; n++) from += (int) *from;
  std::copy_n(from + 1, size_peratom_cols, array_atom[i]);
}
