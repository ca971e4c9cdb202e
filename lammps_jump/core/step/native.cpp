// SPDX-License-Identifier: GPL-2.0-or-later
/* The step of the native engine: forces of pairs and walls, kick and drift; and a scene, step by step, with all that
   happens at its steps: what a host calls.

   Time levels. Between steps the arrays hold x_n, v_(n-1/2) and F_n. Velocity Verlet and the thesis' leap-frog differ in
   the velocity that dashpot and friction see: v_(n-1/2), or 1.5 v_(n-1/2) - 0.5 v_(n-3/2) (thesis 3.7-3.9). Where discs have
   radii of their own, constants are those of a radius of 1 m: mass and weight grow as R^2, the moment of inertia as R^4.

   Order of a step, LAMMPS' own: half kick, drift, [lists, outlets, arrivals, gates], forces, half kick, [sizes, stations, windows,
   tailgates]. */

#include "step/events.h"
#include "step/kinds.h"
#include "step/step.h"

#include <algorithm>

namespace jump {

/** Slope of the sign law in this step, or 0. */
static double slope_now(const jump_state &s, ThreadPartition &partition)
{
  if (!(s.pair.sign_ramp > 0.0)) return 0.0;
  partition.each([&](ThreadPart &part) { part.fastest = fastest(part.at, part.begin, part.end); });
  double found = 0.0;
  for (const ThreadPart &part : partition.parts) found = most(part.fastest, found);
  return slope_of(s, found);
}

/** Forces on the discs of a part. */
static void forces_on(const jump_state &s, double slope, ThreadPart &part)
{
  pair_forces<WithLosses>(s, slope, part);
  wall_forces(s, slope, part);
  if (s.fixed) clear_fixed(s, part);
  if (s.partner && part.memory->goes_on) part.memory->each_at_wall(part, [&](int64_t i) { end_contacts(s, i, i + 1); });
}

/** What follows the forces on discs. */
static void end_forces(const jump_state &s, double slope, ThreadPartition &partition)
{
  sum_walls(s, partition.parts);
  if (s.corners) body_forces(s, slope);
  if (s.moving) end_walls(s);
  if (s.corners && s.partner && s.memory_step > 0.0) end_contacts(*s.corners, 0, s.corners->n);
}

/** What goes before them: the slope of the sign law, and what parts read of each other's memory. */
static double begin_forces(const jump_state &s, ThreadPartition &partition)
{
  const double slope = slope_now(s, partition);
  if (s.partner && partition.parts.size() > 1) partition.each([&](ThreadPart &part) { borrow(s, part); });
  return slope;
}

static void forces(const jump_state &s, ThreadPartition &partition)
{
  const double slope = begin_forces(s, partition);
  partition.each([&](ThreadPart &part) { forces_on(s, slope, part); });
  end_forces(s, slope, partition);
}

/** What follows the drift of all discs; the number of those that have gone further than the list allows. */
static int64_t end_drift(const jump_state &s, const ThreadPartition &partition)
{
  int64_t moved = 0;
  for (const ThreadPart &part : partition.parts) moved += part.moved;
  if (!s.dashpot_x) return moved;
  Dissipated all{0.0, 0.0, 0.0};
  for (const Dissipated &block : partition.dissipated) {
    all.dashpots += block.dashpots;
    all.friction += block.friction;
    all.turning += block.turning;
  }
  s.work->whole.dashpots -= s.time_step * all.dashpots;
  if (!s.friction_x) return moved;
  s.work->whole.friction -= s.time_step * all.friction;
  if (s.omega) s.work->whole.friction -= s.time_step * all.turning;
  return moved;
}

static void drift_part(const jump_state &s, ThreadPartition &partition, ThreadPart &part, double (*next)[4])
{
  part.moved = drift(s, part.begin, part.end, partition.dissipated.data(), part.rows(), next);
}

static int64_t drift(const jump_state &s, ThreadPartition &partition)
{
  partition.each([&](ThreadPart &part) { drift_part(s, partition, part, part.at); });
  return end_drift(s, partition);
}

/** Forces, and the drift after them. Threads meet once: what others read of a disc is written to the other rows. */
static int64_t forces_and_drift(const jump_state &s, ThreadPartition &partition)
{
  if (partition.parts.size() == 1 || s.omega || s.corners) {    // spins have no rows
    forces(s, partition);
    return drift(s, partition);
  }
  const double slope = begin_forces(s, partition);
  partition.each([&](ThreadPart &part) {
    forces_on(s, slope, part);
    drift_part(s, partition, part, partition.other_rows());
  });
  partition.turn_rows();
  end_forces(s, slope, partition);
  return end_drift(s, partition);
}

constexpr int64_t LISTS_A_LOOK = 16;

StopReason relist(jump_state &s, ThreadPartition &partition)
{
  if (!s.lists) return LIST_STALE;
  const auto begun = WallClock::now();
  if (list_all(s, partition) != LISTED) return LIST_STALE;
  s.lists->made[0] += 1.0;
  s.lists->made[1] += std::chrono::duration<double>(WallClock::now() - begun).count();
  return ++partition.lists_made % LISTS_A_LOOK == 0 ? CHECK_OVERLAP : DONE;
}

static void store(const jump_state &s, ThreadPartition &partition)
{
  partition.each([&](ThreadPart &part) {
    store(s, part.begin, part.end, part.rows());
    partition.memory.end(s, part);
  });
  partition.memory.goes_on = false;    // slots hold it again
}

static void begin_memory(const jump_state &s, ThreadPartition &partition)
{
  partition.memory.begin(s, partition);
  partition.memory.see_walls(s);
}

static void begin(const jump_state &s, ThreadPartition &partition)
{
  partition.divide(s);
  partition.each([&](ThreadPart &part) { load(s, part.begin, part.end, part.rows()); });
  if (s.partner && !s.grid_first) begin_memory(s, partition);
}

int64_t advance(jump_state &s, ThreadPartition &partition, int64_t steps, bool forces_pending, StopReason &left)
{
  int64_t done = 0;
  left = DONE;
  begin(s, partition);
  while (true) {
    partition.tuner.begin_step((int) s.n);
    const bool whole = forces_pending && steps > 0;
    if (forces_pending && s.grid_first) {
      store(s, partition);
      if (!search_cells(s)) {
        left = LIST_STALE;
        return done;
      }
      if (s.partner) begin_memory(s, partition);
    }
    if (steps == 0) {
      if (forces_pending) forces(s, partition);
      store(s, partition);
      return 0;
    }
    bool old = (forces_pending ? forces_and_drift(s, partition) : drift(s, partition)) > 0;
    done++;
    forces_pending = true;
    if (s.moving && move_walls(s, s.clock->step + (double) done)) old = true;
    const int threads = partition.tuner.threads();
    partition.tuner.end_step(!whole);
    if (old || done == steps) store(s, partition);
    if (old) left = relist(s, partition);
    if (left != DONE || done == steps) return done;
    if (old) begin(s, partition);
    else if (partition.tuner.threads() != threads) partition.divide(s);
  }
}

namespace {

bool is_too_deep(const jump_state &s, const jump_events &e, ThreadPartition &partition)
{
  double worst;
  int64_t where[2];
  if (!(e.overlap_limit > 0.0)) return false;
  elastic_of(s, partition, nullptr, &worst, where);
  return worst > e.overlap_limit;
}

bool has_no_slot(const jump_state &s) { return s.partner && *s.full != 0; }

/** Drift and forces up to the drift of a step. */
RunEnd drift_to(jump_state &s, jump_events &e, ThreadPartition &partition, int64_t stop)
{
  bool forces_pending = false;
  while (e.step < stop) {
    StopReason why;
    if (s.clock) s.clock->step = (double) e.step;
    const int64_t done = advance(s, partition, stop - e.step, forces_pending, why);
    e.step += done;
    e.disc_steps += (double) (done * s.n);
    if (s.clock) s.clock->step = (double) e.step;
    if (why == LIST_STALE) return NO_LISTS;
    if (why == CHECK_OVERLAP && is_too_deep(s, e, partition)) return TOO_DEEP;
    if (has_no_slot(s)) return NO_SLOT;
    forces_pending = true;
  }
  return AT_TARGET;
}

RunEnd run(jump_state &s, jump_events &e, ThreadPartition &partition, int64_t target)
{
  while (e.step < target) {
    const int64_t stop = least(next_event(s, e), target);
    if (const RunEnd end = drift_to(s, e, partition, stop); end != AT_TARGET) return end;
    if (is_between(s, e) && !happen_between(s, e, partition)) return NO_LISTS;
    StopReason why;
    if (s.moving) place_walls(s, (double) e.step);    // a tailgate has a new speed
    advance(s, partition, 0, true, why);
    if (has_no_slot(s)) return NO_SLOT;
    happen_after(s, e, partition);
  }
  return AT_TARGET;
}

}    // namespace
}    // namespace jump

using namespace jump;

JUMP_SIZE(jump_inlet)
JUMP_SIZE(jump_outlet)
JUMP_SIZE(jump_tailgate)
JUMP_SIZE(jump_events)

ThreadPartition *jump_partition(const char *threads)
{
  ThreadPartition *const partition = new ThreadPartition;
  partition->tuner.read(threads);
  return partition;
}

void jump_free_partition(ThreadPartition *partition) { delete partition; }

int64_t jump_partition_threads(const ThreadPartition *partition) { return partition->tuner.threads(); }

int64_t jump_advance(jump_state *state, ThreadPartition *partition, int64_t steps, int64_t forces_pending, int64_t *left)
{
  StopReason found;
  const int64_t done = advance(*state, *partition, steps, forces_pending != 0, found);
  *left = found;
  return done;
}

int64_t jump_list_pairs(jump_state *state, ThreadPartition *partition) { return list_pairs(*state, *state->lists, *partition); }

void jump_place_walls(const jump_state *state, int64_t step) { place_walls(*state, (double) step); }

int64_t jump_run(jump_state *state, jump_events *events, ThreadPartition *partition, int64_t target)
{
  if (state->moving) place_walls(*state, (double) events->step);
  return run(*state, *events, *partition, target);
}

const double *jump_windows(ThreadPartition *partition, int64_t *numbers)
{
  *numbers = (int64_t) partition->rooms.windows.size();
  return partition->rooms.windows.data();
}

void jump_forget_windows(ThreadPartition *partition) { partition->rooms.windows.clear(); }

void jump_forget_rooms(ThreadPartition *partition) { partition->rooms.forget(); }
