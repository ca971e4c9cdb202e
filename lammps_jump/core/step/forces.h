// SPDX-License-Identifier: GPL-2.0-or-later
/* The forces of a step on the discs of a part. */

#ifndef JUMP_CORE_FORCES_H
#define JUMP_CORE_FORCES_H

#include "step/thread_part.h"

namespace jump {

/** How a host sums the forces of pairs: those of a row first, with the part that dashpots and friction take … */
struct WithLosses {
  static constexpr bool LOSSES = true;
  using Batch = struct BatchWithLosses;
};

/** … or each added to its discs as it comes, and nothing of losses: without row sums it takes a sixth less. */
struct ForcesAlone {
  static constexpr bool LOSSES = false;
  using Batch = struct BatchOfForces;
};

/** Rows of the list: those that are sorted, and those behind them, of newcomers and of discs beyond a seam or a cut. */
enum ListRows { ALL_ROWS, SORTED_ROWS, ROWS_BEHIND };

/** Add the forces of touching pairs to the discs of a part; `slope` is that of the sign law (`slope_of`). Discs of other ranks, whose
    numbers are from s.n on, belong to no part. (pair_sums.h) */
template <class Sums> void pair_forces(const jump_state &s, double slope, ThreadPart &part, ListRows which = ALL_ROWS);

/** Read what other parts' discs remember of contacts with those of this part, before anything is written. (pair_sums.h) */
void borrow(const jump_state &s, ThreadPart &part);

/** Take the forces off fixed discs: they stay, and nothing is dissipated on their side. */
void clear_fixed(const jump_state &s, const ThreadPart &part);

/** Put the moving walls where they are at a step; true where one has gone over half the skin since it was listed. */
bool place_walls(const jump_state &s, double step);

/** Move the walls that discs push, and put all that move where they are; true where one has left its list. */
bool move_walls(const jump_state &s, double step);

/** Add the forces of the walls; what walls feel is kept in the part. */
void wall_forces(const jump_state &s, double slope, ThreadPart &part);

/** Sum what walls feel, in the order of the discs. */
void sum_walls(const jump_state &s, const std::vector<ThreadPart> &parts);

/** What forces of a step do on walls that move: their power on discs, and what is due to them in the ledger. */
void end_walls(const jump_state &s);

}    // namespace jump

#endif
