// SPDX-License-Identifier: GPL-2.0-or-later
/* A scene, step by step, with all that happens at its steps: what a host calls.

   Order of a step, LAMMPS' own: half kick, drift, [lists, outlets, arrivals, gates], forces, half kick, [sizes, stations, windows,
   tailgates]. */

#include "step/events.h"
#include "step/forces.h"
#include "step/step.h"

namespace jump {
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
