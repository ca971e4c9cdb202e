// SPDX-License-Identifier: GPL-2.0-or-later
/* Lists of the native engine made anew: discs sorted by cell, pairs that are close (pair_search.h), discs near walls. Cells are
   counted along the shorter side of the flow first. */

#ifndef JUMP_CORE_RELIST_H
#define JUMP_CORE_RELIST_H

#include "step/thread_partition.h"

namespace jump {

/** What `list_pairs` returns in place of a disc outside the domain; NO_ROOM is another. */
enum : int64_t { LISTED = -1, AT_SEAM = -3 };

/** Sort the discs by cell and list all pairs closer than the reach, sorted rows alone; the index of a disc outside the
    domain, or LISTED or NO_ROOM. A NaN is outside; then nothing is changed. */
int64_t list_pairs(jump_state &s, const jump_lists &lists, ThreadPartition &partition);

/** Rows behind those of the sorted discs: those of other ranks, `others` of them with numbers from s.n on, that each of the state's
    discs may touch. `at` has the places of all. False where there is no room for the pairs. */
bool list_across(jump_state &s, const jump_lists &lists, int64_t others, const double (*at)[4], Rooms &rooms);

/** All of it where there is room, which grows: discs that go round a channel are let in at its other end, and the corners of
    bodies are listed too. LISTED, a disc outside the domain, or AT_SEAM: a wall that is pushed has come to the ends of a channel. */
int64_t list_all(jump_state &s, ThreadPartition &partition);

/** List the discs and corners near each wall, from where discs were when their pairs were listed; the room grows. */
void list_walls(jump_state &s, Rooms &rooms);

}    // namespace jump

#endif
