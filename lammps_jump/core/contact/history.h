// SPDX-License-Identifier: GPL-2.0-or-later
/* What a disc remembers of its contacts; lammps_jump/physics/law.py states it, and tests compare the two.

   A partner is the id of a disc, above 0, or -1 - c for chain c of the walls; 0 in an empty slot. At a chain the arc length
   of the foot tells the contacts apart, and the nearest one goes on.

   Slots are the memory of one disc: `count()`, and of a slot `partner(s)`, `foot(s)`, `used(s)` (whether a contact of this
   step has it), `take(s, partner)` (begins it with springs at 0) and `mark(s, foot)`. */

#ifndef JUMP_CORE_HISTORY_H
#define JUMP_CORE_HISTORY_H

#include "contact/scalar_ops.h"

namespace jump {

/** No slot. */
constexpr int FULL = -1;

/** Way of a foot along a chain, m; `around` is the length of a closed one, else 0. */
inline double way_of(double foot, double before, double around)
{
  const double way = std::fabs(foot - before);
  if (!(around > 0.0)) return way;
  const double rest = std::fmod(way, around);
  return least(rest, around - rest);
}

/** Slot in which a disc remembers a contact whose foot has gone `limit` (m) at most, or FULL; nothing is changed.

    With `anew`, slots that a contact of this step has are left out. */
template <class Slots, class Partner>
inline int held(const Slots &row, Partner partner, double foot, double limit, double around, bool anew = false)
{
  int best = FULL;
  double nearest = limit;
  for (int s = 0; s < row.count(); s++) {
    if (row.partner(s) != partner || (anew && row.used(s))) continue;
    if (!(partner < 0)) return s;    // a disc is in one slot
    const double way = way_of(foot, row.foot(s), around);
    if (way <= nearest) {
      best = s;
      nearest = way;
    }
  }
  return best;
}

/** Slot of a contact in this step: that of its partner, or an empty one with springs at 0; FULL where there is neither. */
template <class Slots, class Partner>
inline int slot_of(Slots &row, Partner partner, double foot, double limit, double around)
{
  int best = held(row, partner, foot, limit, around, true);
  for (int s = 0; best == FULL && s < row.count(); s++)
    if (row.partner(s) == 0) {
      best = s;
      row.take(s, partner);
    }
  if (best != FULL) row.mark(best, foot);
  return best;
}

}    // namespace jump

#endif
