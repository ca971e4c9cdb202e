// SPDX-License-Identifier: GPL-2.0-or-later
#include "contact/no_contraction.h"

#include "fix_jump_step.h"

#include "pair_jump_disc.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "force.h"
#include "modify.h"
#include "neighbor.h"
#include "output.h"
#include "update.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>

using namespace LAMMPS_NS;
using namespace FixConst;

FixJumpStep::FixJumpStep(LAMMPS *lmp, int narg, char **arg) : Fix(lmp, narg, arg)
{
  if (igroup != 0) error->all(FLERR, "fix jump/step acts on all discs: its group is all");
  pair = dynamic_cast<PairJumpDisc *>(force->pair_match("jump/disc", 1));
  if (!pair) error->all(FLERR, "fix jump/step needs pair_style jump/disc before it");
  state = pair->scene.state;
  events = pair->scene.events;
  int a = 3;
  const std::map<std::string, int (FixJumpStep::*)(int, int, char **)> words = {
      {"walls", &FixJumpStep::add_walls}, {"went", &FixJumpStep::add_went}, {"sizes", &FixJumpStep::add_sizes},
      {"slots", &FixJumpStep::add_slots}, {"bodies", &FixJumpStep::add_bodies}, {"contacts", &FixJumpStep::add_contacts},
      {"poses", &FixJumpStep::add_poses}, {"probe", &FixJumpStep::add_probes}};
  while (a < narg) {
    const std::string key = arg[a];
    if (key == "gravity" && a + 2 < narg) {
      gx = utils::numeric(FLERR, arg[a + 1], false, lmp);
      gy = utils::numeric(FLERR, arg[a + 2], false, lmp);
      a += 3;
    } else if (auto word = words.find(key); word != words.end()) {
      a = (this->*word->second)(a + 1, narg, arg);
    } else {
      error->all(FLERR, "fix jump/step: unknown keyword '{}'", key);
    }
  }
  state->weight_x = state->mass * gx;
  state->weight_y = state->mass * gy;
  for (int64_t wall = 0; state->moving && wall < state->walls; wall++)
    if (state->moving[wall] >= jump::LOADED) pushed_walls.push_back(wall);
  if (state->walls > 0)    // where walls move, each of the two may go as far
    near_margin = (state->lists->grids[0].reach - 0.5 * state->diameter) / (state->moving ? 2.0 : 1.0);
  columns = state->moving ? 4 : 3;
  time_integrate = 1;
  scalar_flag = global_freq = 1;
  restart_global = !pushed_walls.empty();
  mean.assign(columns * probed.size(), 0.0);
  felt.resize(state->walls);
  const int64_t slots = state->corners ? 4 * state->corners->n * state->corners->slots : 0;
  size_vector = (int) (mean.size() + PUSHED_WORDS * pushed_walls.size() + slots);
  vector_flag = size_vector > 0;
  extscalar = extvector = 0;
}

/** The names of the walls, in the order of the file. */
int FixJumpStep::add_walls(int a, int narg, char **arg)
{
  const int n = a < narg ? utils::inumeric(FLERR, arg[a++], false, lmp) : -1;
  if (n != (int) state->walls || a + n > narg)
    error->all(FLERR, "fix jump/step: walls needs the number of walls of the scene, {}, and their names", state->walls);
  names.assign(arg + a, arg + a + n);
  return a + n;
}

int FixJumpStep::wall_called(const char *name) const
{
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) error->all(FLERR, "fix jump/step: unknown wall '{}'", name);
  return (int) (found - names.begin());
}

/** Speeds at the end of an earlier run. */
int FixJumpStep::add_went(int a, int narg, char **arg)
{
  if (a + 4 > narg) error->all(FLERR, "fix jump/step: went needs a wall and three speeds");
  Went one{wall_called(arg[a]), {}};
  if (!state->moving || state->moving[one.wall] < jump::LOADED)
    error->all(FLERR, "fix jump/step: wall '{}' that went is no lid, gate or body", arg[a]);
  for (int axis = 0; axis < 3; axis++)
    one.speed[axis] = state->load[one.wall].free[axis] * utils::numeric(FLERR, arg[a + 1 + axis], false, lmp);
  went.push_back(one);
  return a + 4;
}

/** How often something is written, and where. */
int FixJumpStep::add_file(OutFile &of, int a, int narg, char **arg) const
{
  if (a + 1 >= narg) error->all(FLERR, "fix jump/step: {} needs EVERY and FILE", arg[a - 1]);
  of.every = utils::inumeric(FLERR, arg[a], false, lmp);
  if (of.every < 1) error->all(FLERR, "fix jump/step: {} every {} steps: must be above 0", arg[a - 1], of.every);
  of.file = arg[a + 1];
  return a + 2;
}

int FixJumpStep::add_bodies(int a, int narg, char **arg)
{
  a = add_file(rows_of_bodies, a, narg, arg);
  if (a >= narg || !state->corners) error->all(FLERR, "fix jump/step: bodies needs a LIMIT, and a scene that has bodies");
  body_limit = utils::numeric(FLERR, arg[a], false, lmp);
  return a + 1;
}

/** Walls whose forces are summed: the rest of the words. */
int FixJumpStep::add_probes(int a, int narg, char **arg)
{
  if (a + 1 >= narg) error->all(FLERR, "fix jump/step: probe needs EVERY and a wall's name");
  probe_every = utils::inumeric(FLERR, arg[a], false, lmp);
  if (probe_every < 1) error->all(FLERR, "fix jump/step: probe every {} steps: must be above 0", probe_every);
  for (a++; a < narg; a++) probed.push_back(wall_called(arg[a]));
  return a;
}

int FixJumpStep::add_sizes(int a, int narg, char **arg)
{
  if (a + 1 >= narg || !events->own_radius || events->size_every < 1)
    error->all(FLERR, "fix jump/step: sizes needs COUNT and DENSITY, and a scene with sizes");
  size_count = utils::bnumeric(FLERR, arg[a], false, lmp);
  density = utils::numeric(FLERR, arg[a + 1], false, lmp);
  nevery = (int) events->size_every;
  create_attribute = 1;    // set_arrays() tells of new discs
  return a + 2;
}

int FixJumpStep::setmask()
{
  return INITIAL_INTEGRATE | POST_FORCE | FINAL_INTEGRATE | POST_RUN | (size_count > 0 ? END_OF_STEP : 0);
}

void FixJumpStep::init()
{
  if (force->pair_match("jump/disc", 1) != pair) error->all(FLERR, "fix jump/step needs pair_style jump/disc before it");
  if (domain->dimension != 2) error->all(FLERR, "fix jump/step needs dimension 2");
  sized = events->traffic[jump::SIZED];
  newcomers = true;    // of a state that is read
  if (state->partner && size_peratom_cols != SLOT * state->slots)
    error->all(FLERR, "fix jump/step needs {} slots for the law history of this scene", state->slots);
  watch_others();
  pair->slots = array_atom ? &array_atom : nullptr;
  state->time_step = update->dt;
}

/** Find out which fixes look at the discs, and when. */
void FixJumpStep::watch_others()
{
  constexpr int EACH_STEP = INITIAL_INTEGRATE | POST_INTEGRATE | PRE_FORCE | PRE_REVERSE | POST_FORCE | FINAL_INTEGRATE;
  others_push = others_look = false;
  renewing.clear();
  ending.clear();
  for (Fix *fix : modify->get_fix_list()) {
    if (fix->force_reneighbor) renewing.push_back(fix);
    if (fix->setmask() & END_OF_STEP) ending.push_back(fix);
    if (fix == this || strcmp(fix->id, "step_hook") == 0) continue;    // the hook of tests reads only the step
    others_push |= (fix->setmask() & POST_FORCE) != 0;
    others_look |= (fix->setmask() & EACH_STEP) != 0;
  }
}

void FixJumpStep::setup(int vflag)
{
  starts = true;
  lammps_is_stale = false;
  post_force(vflag);
}

/** Whether LAMMPS may look at the discs in this step before their forces: to sort, insert or remove them, or others do. */
bool FixJumpStep::is_seen_before_forces() const
{
  if (others_look || update->ntimestep == output->next) return true;    // restart files ask for sorted discs
  const int ago = neighbor->ago + 1;
  if (ago >= neighbor->delay && ago % neighbor->every == 0) return true;
  return std::any_of(renewing.begin(), renewing.end(), [&](Fix *fix) { return fix->next_reneighbor == update->ntimestep; });
}

/** Whether LAMMPS may look at the discs at the end of this step. */
bool FixJumpStep::is_seen_at_end() const
{
  const bigint step = update->ntimestep;
  if (others_look || step == output->next || step == update->laststep) return true;
  return std::any_of(ending.begin(), ending.end(), [&](Fix *fix) { return step % fix->nevery == 0 && (fix != this || waits()); });
}

/** Whether discs may wait for their own size. On several ranks one may have come from another rank. */
bool FixJumpStep::waits() const
{
  return newcomers || comm->nprocs > 1;
}

void FixJumpStep::initial_integrate(int)
{
  if (state->moving) walls_left |= jump::move_walls(*state, (double) update->ntimestep);
  jump::ThreadPartition &partition = pair->partition;
  partition.tuner.begin_step(atom->nlocal);
  if (others_push && starts) pair->take_forces();
  starts = false;
  pair->range = {};    // discs of other ranks may widen it
  if (atom->nlocal == 0) return;
  const bool seen = is_seen_before_forces();
  if (!seen && !is_seen_at_end()) pair->keep_uncleared();
  partition.divide(*state);
  if (!lammps_is_stale) pair->take_motion();
  partition.each([&](jump::ThreadPart &part) {
    part.range = jump::drift_by_halves(*state, part.begin, part.end, lammps_is_stale, part.rows());
  });
  for (const jump::ThreadPart &part : partition.parts) pair->range.widen(part.range);
  if (seen) pair->put_motion();
  const double *const lo = pair->range.lo, *const hi = pair->range.hi;
  near_moved += update->dt * std::hypot(std::max(-lo[0], hi[0]), std::max(-lo[1], hi[1]));
}

void FixJumpStep::final_integrate()
{
  if (others_push) pair->take_forces();
  lammps_is_stale = !is_seen_at_end();
  if (!lammps_is_stale) pair->put_motion_of_step();
  if (update->ntimestep == output->next || update->ntimestep == update->laststep) pair->put_slots();
  pair->partition.tuner.end_step(paced_order != pair->order);
  paced_order = pair->order;
}

/** LAMMPS ends a run at any step where its time is over. */
void FixJumpStep::post_run()
{
  if (lammps_is_stale) pair->put_motion_of_step();
  pair->put_slots();
  lammps_is_stale = false;
}

/** Inserted discs get their own size. The forces of this step are those of the inserted size, and the next half kick divides them
    by the own mass. */
void FixJumpStep::end_of_step()
{
  if (!waits()) return;
  newcomers = false;
  tagint highest = sized;
  for (int64_t k = 0; k < state->n; k++) {
    const tagint id = (tagint) state->ids[k];
    if (id <= sized || jump::is_fixed(*state, k)) continue;
    highest = std::max(highest, id);
    if (id > size_count) error->one(FLERR, "fix jump/step: disc {} has no size of its own", id);
    const double d = 2.0 * events->own_radius[id - 1];
    atom->radius[pair->origin(k)] = state->radius[k] = 0.5 * d;
    jump::put_mass(*state, k, pair->partition.parts[0].forces[k]);
    atom->rmass[pair->origin(k)] = density * d * d;
  }
  sized = highest;
}

/** Largest overlap of pairs and walls at the last force evaluation, m. */
double FixJumpStep::compute_scalar()
{
  double here, all;
  int64_t where[2];
  pair->store();
  jump::elastic_of(*state, pair->partition, nullptr, &here, where);
  MPI_Allreduce(&here, &all, 1, MPI_DOUBLE, MPI_MAX, world);
  return all;
}

double FixJumpStep::compute_vector(int n)
{
  if (n >= (int) mean.size()) return pushed_state(n - (int) mean.size());    // all ranks have it
  double sum;
  MPI_Allreduce(&mean[n], &sum, 1, MPI_DOUBLE, MPI_SUM, world);
  return sum;
}
