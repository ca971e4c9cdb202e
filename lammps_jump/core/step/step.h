// SPDX-License-Identifier: GPL-2.0-or-later
/* What a step is made of: the forces on the discs of a part, lists made anew, and steps without events.

   Lists are discs sorted by cell, pairs that are close (pair_search.h) and discs near walls. Cells are counted along the shorter side
   of the flow first. */

#ifndef JUMP_CORE_STEP_H
#define JUMP_CORE_STEP_H

#include "step/thread_partition.h"

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

/** Rows of the list: those that are sorted, then those of newcomers and of discs beyond a seam or a cut. */
enum ListRows { ALL_ROWS, SORTED_ROWS, ROWS_BEHIND };

/** Add the forces of touching pairs to the discs of a part; `slope` is that of the sign law (`slope_of`). Discs of other ranks, whose
    numbers are from s.n on, belong to no part. (pair_sums.cpp) */
template <class Sums> void pair_forces(const jump_state &s, double slope, ThreadPart &part, ListRows which = ALL_ROWS);

/** Read what other parts' discs remember of contacts with those of this part, before anything is written. (pair_sums.cpp) */
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

/** What `list_pairs` returns in place of a disc outside the domain; NO_ROOM is another. */
enum : int64_t { LISTED = -1, AT_SEAM = -3 };

/** Sort the discs by cell and list all pairs closer than the reach, sorted rows alone; the index of a disc outside the
    domain, or LISTED or NO_ROOM. A NaN is outside; then nothing is changed. */
int64_t list_pairs(jump_state &s, const jump_lists &lists, ThreadPartition &partition);

/** Rows after those of the sorted discs: those of other ranks, `others` of them with numbers from s.n on, that each of the state's
    discs may touch. `at` has the places of all. False where there is no room for the pairs. */
bool list_across(jump_state &s, const jump_lists &lists, int64_t others, const double (*at)[4], Rooms &rooms);

/** All of it where there is room, which grows: discs that go round a channel are let in at its other end, and the corners of
    bodies are listed too. LISTED, a disc outside the domain, or AT_SEAM: a wall that is pushed has come to the ends of a channel. */
int64_t list_all(jump_state &s, ThreadPartition &partition);

/** List the discs and corners near each wall, from where discs were when their pairs were listed; the room grows. */
void list_walls(jump_state &s, Rooms &rooms);

/** Why steps end: they are done, the list is too old and could not be made here, or overlaps want a look. */
enum StopReason : int64_t { DONE, LIST_STALE, CHECK_OVERLAP };

/** Up to `steps` drifts with forces between them, and before them where `forces_pending`; without steps these alone.

    The forces after the last drift are left to the caller. Returns the drifts done. */
int64_t advance(jump_state &s, ThreadPartition &partition, int64_t steps, bool forces_pending, StopReason &left);

/** Make the lists anew where that can be done here. */
StopReason relist(jump_state &s, ThreadPartition &partition);

}    // namespace jump

#endif
