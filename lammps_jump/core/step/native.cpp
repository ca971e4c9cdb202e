// SPDX-License-Identifier: GPL-2.0-or-later
/* The step of the native engine: forces of pairs and walls, kick and drift.

   Time levels. Between steps the arrays hold x_n, v_(n-1/2) and F_n. Velocity Verlet and the thesis' leap-frog differ in
   the velocity that dashpot and friction see: v_(n-1/2), or 1.5 v_(n-1/2) - 0.5 v_(n-3/2) (thesis 3.7-3.9). Where discs have
   radii of their own, constants are those of a radius of 1 m: mass and weight grow as R^2, the moment of inertia as R^4. */

#include "step/thread_partition.h"
#include "step/forces.h"
#include "step/kinds.h"
#include "step/relist.h"
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
  for (const Dissipated &taken : partition.taken) {
    all.dashpots += taken.dashpots;
    all.friction += taken.friction;
    all.turning += taken.turning;
  }
  s.work->whole.dashpots -= s.time_step * all.dashpots;
  if (!s.friction_x) return moved;
  s.work->whole.friction -= s.time_step * all.friction;
  if (s.omega) s.work->whole.friction -= s.time_step * all.turning;
  return moved;
}

static void drift_part(const jump_state &s, ThreadPartition &partition, ThreadPart &part, double (*next)[4])
{
  part.moved = drift(s, part.begin, part.end, partition.taken.data(), part.rows(), next);
}

static int64_t drift(const jump_state &s, ThreadPartition &partition)
{
  partition.each([&](ThreadPart &part) { drift_part(s, partition, part, part.at); });
  return end_drift(s, partition);
}

/** Forces, and the drift behind them. Threads meet once: what others read of a disc is written to the other rows. */
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

}    // namespace jump

using jump::ThreadPartition;

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
  jump::StopReason found;
  const int64_t done = jump::advance(*state, *partition, steps, forces_pending != 0, found);
  *left = found;
  return done;
}

int64_t jump_list_pairs(jump_state *state, ThreadPartition *partition) { return jump::list_pairs(*state, *state->lists, *partition); }

void jump_place_walls(const jump_state *state, int64_t step) { jump::place_walls(*state, (double) step); }
