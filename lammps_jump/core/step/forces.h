// SPDX-License-Identifier: GPL-2.0-or-later
/* The forces of a step on the discs of a part. */

#ifndef JUMP_CORE_FORCES_H
#define JUMP_CORE_FORCES_H

#include "step/thread_part.h"

namespace jump {

/** Add the forces of all touching pairs to the discs of a part; `slope` is that of the sign law (`slope_of`). */
void pair_forces(const jump_state &s, double slope, ThreadPart &part);

/** Read what other parts' discs remember of contacts with those of this part, before anything is written. */
void borrow(const jump_state &s, ThreadPart &part);

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

/** Largest overlap of discs with walls, m; `at` has the places of the discs. */
double deepest_at_walls(const jump_state &s, const double (*at)[4]);

}    // namespace jump

#endif
