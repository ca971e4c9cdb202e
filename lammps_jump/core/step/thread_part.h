// SPDX-License-Identifier: GPL-2.0-or-later
/* Stretches of discs that threads take: each thread adds to the discs of its own part alone.

   Discs are sorted by cell, and rows of the list by disc. A part repeats the earlier rows that reach into it, for its own
   discs alone, then does its rows without what falls on later parts' discs, then the rows after those of the sorted
   discs (images, newcomers) as far as they touch its own. So every sum has the order of one thread, for any number of
   parts, and only pairs across a cut are done twice. */

#ifndef JUMP_CORE_THREAD_PART_H
#define JUMP_CORE_THREAD_PART_H

#include "contact/law.h"
#include "step/integrate.h"

#include <vector>

namespace jump {

/** What dashpots and friction of one contact with a wall that moves take. */
struct DissipatedAtWall {
  Sum dashpots, friction;
};

/** The force of one contact on a wall: across it, along its outline, and where, m. */
struct Press {
  int64_t wall;
  double across, along, place;
};

/** Where the contacts with a wall end among those of a part. */
struct Ends {
  size_t push, dissipated;
};

/** Candidates of the list that are looked at together: what belongs to them stays in the first-level cache. */
constexpr int BATCH = 128;

class PairMemory;

struct alignas(128) ThreadPart {
  int64_t begin = 0, end = 0;    // its discs
  int64_t sorted = 0;            // rows of the list that are sorted; others come after them
  int64_t first_row = 0;         // first of the rows that may reach into it
  int64_t end_row = 0;           // where its own sorted rows end
  int64_t end_neighbour = 0;     // after the last disc that these reach
  std::vector<int64_t> blocks;   // ends of blocks of those that reach out of it nowhere
  const int32_t *first = nullptr;       // first disc of each pair of the list
  double (*at)[4] = nullptr;            // place and velocity of each disc, as contacts see them
  double (*forces)[4] = nullptr;        // force on each disc, and its part that dashpots lose
  bool both_remember = false;           // both discs of a contact, as discs go from rank to rank
  PairMemory *memory = nullptr;         // of all pairs of the list
  std::vector<Stretch<double>> remote_history;    // of contacts in rows of other parts, as they begin the step
  std::vector<Sum> on_walls;            // forces of contacts with walls on its discs, wall by wall
  std::vector<DissipatedAtWall> dissipated_at_walls;    // of those with walls that move
  std::vector<Ends> walls_end;
  std::vector<Press> presses;           // of contacts with walls whose pressure is requested
  int64_t moved = 0;                    // discs that have gone further than the list allows
  SpeedRange range;                     // of its discs, for a host that makes lists by it
  double weight = 0.0, spent = 0.0;     // of its discs and their pairs; time that it took since it was cut, s
  double fastest = 0.0;                 // square of the largest velocity, (m/s)^2

  StepRows rows() const { return {at, forces}; }
  bool owns(int64_t disc) const { return disc >= begin && disc < end; }
};

}    // namespace jump

#endif
