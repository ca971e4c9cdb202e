// SPDX-License-Identifier: GPL-2.0-or-later
/* The list of pair_style jump/disc (what it is: pair_jump_disc.h): the core's, of LAMMPS' discs. */

#include "contact/no_contraction.h"

#include "step/pair_search.h"    // before the core: its templates take vectors

#include "pair_jump_disc.h"
#include "step/relist.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"

#include <algorithm>
#include <cmath>
#include <cstring>

using namespace LAMMPS_NS;

/** Whether the local discs that the list knows still have the same indices (more may have come after them). */
bool PairJumpDisc::keeps_order() const
{
  const size_t n = listed.size();
  return n > 0 && (size_t) atom->nlocal >= n && memcmp(listed.data(), atom->tag, n * sizeof(tagint)) == 0;
}

/** Take the discs of LAMMPS where it may have changed them; whether the list has to be made anew. */
bool PairJumpDisc::take_discs()
{
  if (moved_by_others() || ring.is_needed() || !keeps_order()) {
    check_discs(0, atom->nlocal);
    pack();
    listed.assign(atom->tag, atom->tag + atom->nlocal);
    return true;
  }
  take_motion();
  if (atom->nlocal > (int) listed.size()) append_to_list((int) listed.size());
  return false;
}

/** All pairs of local discs whose rims are closer than the skin, from the arrays of the state. */
void PairJumpDisc::build_list()
{
  jump_state &s = state();
  for (int c = 0; c < 2; c++) moved[c] = moved_here[c] = 0.0;
  s.owner = nullptr;
  int64_t found = jump::NO_ROOM;
  while (found == jump::NO_ROOM) {
    found = jump::list_pairs(s, *s.lists, partition);
    if (found >= 0)
      error->one(FLERR, "jump/disc: the position of disc {}, ({}, {}) m, is not a number or far outside the domain: the run has blown up",
                 s.ids[found], s.x[found], s.y[found]);
    partition.sort_rows(s.n);
    if (!packed) ring.renumber(partition.lists.sorted);
    if (found == jump::NO_ROOM) partition.rooms.grow_neighbours(s, 0);
  }
  order++;
  remembers_list = false;
  load(0);
}

/** Rows of the list behind the others, for pairs of a local disc with one of another rank or beyond the seam. */
void PairJumpDisc::list_across()
{
  if (!ring.is_needed()) return;
  while (!jump::list_across(state(), *state().lists, ring.count(), rows(), partition.rooms))
    partition.rooms.grow_neighbours(state(), state().start[state().sorted]);
}

/** New discs at the end, the others as they were: rows of the new ones.

    The others may have moved since the list was built: the rows have those that are as close as they still may be missed. */
void PairJumpDisc::append_to_list(int from)
{
  jump_state &s = state();
  check_discs(from, atom->nlocal);
  reserve(atom->nlocal);
  store_places();
  partition.make_room_for(atom->nlocal, 0);
  for (int i = from; i < atom->nlocal; i++) {
    const int64_t k = s.n;
    jump::Rooms::clear_next(s);
    take_disc(i);
    const double reach = s.radius ? skin : largest + skin;
    while (!jump_append_row(k, s.x, s.y, s.radius, reach, s.start, s.neighbours, s.room)) partition.rooms.grow_neighbours(s, s.start[k]);
    s.rows++;
  }
  listed.assign(atom->tag, atom->tag + atom->nlocal);
  order++;
  remembers_list = false;
  load(from);
}
