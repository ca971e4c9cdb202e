// SPDX-License-Identifier: GPL-2.0-or-later
/* What happens at certain steps: discs come and go, get their own size, walls are taken away, tailgates look, windows of probes
   end, stations sum. engines/native/events.py states the same for the twin; tests compare the two.

   A pour is left to the host, whose random numbers its places are: it lets `jump_run` end before the step of one. */

#ifndef JUMP_CORE_EVENTS_H
#define JUMP_CORE_EVENTS_H

#include "step/thread_partition.h"
#include "walls/tailgate_controller.h"

using jump_tailgate = jump::TailgateController;

namespace jump {
/** Energy that discs bring in and carry out, and that gates release, J per m of width. */
enum Exchange { BROUGHT_IN, CARRIED_OUT, RELEASED_BY_GATES };
/** Discs that have come, that have gone, and the last id of those that have their own size. */
enum Traffic { INSERTED, REMOVED, SIZED };
/** Why a run ends: it has come to its step; or the host has to look at what is wrong: lists could not be made (a disc is outside the
    domain, a wall at the seam), discs overlap too much, a disc has no slot left. */
enum RunEnd { AT_TARGET, NO_LISTS, TOO_DEEP, NO_SLOT };
}    // namespace jump

extern "C" {

/** A row of an inlet: as `InletRow` of scene/scene.py. `limit` -1: without one. `turns` steps and speeds of an inflow against
    time begin at `first_turn`. */
struct jump_inlet {
  double x, y, vx, vy, clearance;
  int64_t first, every, limit, first_turn, turns;
};

/** Discs beyond `at` along x (axis 0) or y (1), above or below, are taken out. */
struct jump_outlet {
  double at;
  int64_t axis, above, every;
};

struct jump_events {
  int64_t step;
  double disc_steps;
  // discs that come and go
  int64_t inlets;
  const jump_inlet *inlet;
  const int64_t *turn_step;
  const double *turn_speed;
  int64_t *entered;    // of each inlet
  double weight_x, weight_y;    // of a disc that enters, N per m of width
  int64_t outlets;
  const jump_outlet *outlet;
  int64_t *traffic;    // by Traffic
  // their sizes: of each id (m), given after a step that is a multiple of `size_every`; NULL: all are equal
  const double *own_radius;
  int64_t size_every;
  // steps from which walls are gone
  const int64_t *until;
  // tailgates, and the walls that they are
  int64_t tailgates;
  jump_tailgate *tailgate;
  const int64_t *tailgate_wall;
  // windows of probes: their steps (0: none), the step at which the open one began, and what walls laid aside since then
  int64_t window_steps, window_begin;
  double (*window_sum)[4];
  // stations; sums NULL: none
  double station_left, station_width, station_speed;
  int64_t station_first, station_last;
  double *station_sums;
  // of the ledger; `ledger` 0: elastic energies are not requested
  int64_t ledger;
  double gravity_x, gravity_y;
  double *exchanged;    // by Exchange
  double overlap_limit;    // of a look, m; 0: none
};
}

namespace jump {

/** First step after the present one at which something happens between drift and forces, or after them. */
int64_t next_event(const jump_state &s, const jump_events &e);

/** Whether discs or walls come or go between the drift of this step and its forces. */
bool is_between(const jump_state &s, const jump_events &e);

/** Let what belongs between drift and forces happen; false where lists could not be made. */
bool happen_between(jump_state &s, jump_events &e, ThreadPartition &partition);

/** Let what belongs after the forces happen. */
void happen_after(jump_state &s, jump_events &e, ThreadPartition &partition);

}    // namespace jump

/** Steps up to `target` with all that happens at them; returns a RunEnd. */
JUMP_API int64_t jump_run(jump_state *state, jump_events *events, jump::ThreadPartition *partition, int64_t target);

/** Windows that have ended since they were forgotten: for each the step, its steps, then for each wall the sums of what it felt
    (SumsOnWall) and where it is (Placed), then for each stretch of `jump_pressed` its sums. */
JUMP_API const double *jump_windows(jump::ThreadPartition *partition, int64_t *numbers);
JUMP_API void jump_forget_windows(jump::ThreadPartition *partition);

/** Let go of arrays that have grown: the host has them in its own. */
JUMP_API void jump_forget_rooms(jump::ThreadPartition *partition);

#endif
