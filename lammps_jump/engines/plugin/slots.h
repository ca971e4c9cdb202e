// SPDX-License-Identifier: GPL-2.0-or-later
/* What discs remember of their contacts; lammps_jump/physics/slots.py states it, and tests compare the two.

   A row holds COUNT partners (id of a disc, -1 - c for chain c of the walls, 0: empty), then as many arc lengths of the
   foot, elongations of the tangential and of the rolling spring, m. It is an array of fix jump/step. */

#ifndef JUMP_SLOTS_H
#define JUMP_SLOTS_H

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <vector>

namespace jump {

constexpr int MOST_SLOTS = 64;    // bits of a mark

class Slots {
 public:
  double **const *rows = nullptr;    // the fix's array, which may move
  int count = 0;
  bool grows = false;                // springs go on; else they stay as they are, as in the first forces of a run
  std::atomic<int> full{-1};         // a disc that has no slot left

  void begin(int discs) { marks.assign(discs, 0); }

  double *spring(int i, int slot) const { return (*rows)[i] + 2 * count + slot; }
  double *roll(int i, int slot) const { return (*rows)[i] + 3 * count + slot; }

  /** Slot of disc i for a partner, taken where there is none and springs grow; -1 without one. */
  int of_pair(int i, double partner)
  {
    const double *const row = (*rows)[i];
    for (int s = 0; s < count; s++)
      if (row[s] == partner) return marked(i, s);
    return grows ? take(i, partner) : -1;
  }

  /** The same for a chain of a wall: the one with the nearest foot, at most `limit` away; `around` closes the chain. */
  int of_wall(int i, double partner, double foot, double limit, double around)
  {
    double *const row = (*rows)[i];
    int best = -1;
    for (int s = 0; s < count; s++) {
      if (row[s] != partner || (grows && (marks[i] >> s & 1))) continue;
      double way = std::fabs(foot - row[count + s]);
      if (around > 0.0) {
        way = std::fmod(way, around);
        way = std::min(way, around - way);
      }
      if (way <= limit) {
        best = s;
        limit = way;
      }
    }
    if (best < 0 && grows) best = take(i, partner);
    if (best >= 0 && grows) {
      marked(i, best);
      row[count + best] = foot;
    }
    return best;
  }

  /** Empty the slots of some discs whose contacts have ended. */
  void end(int from, int to)
  {
    for (int i = from; i < to; i++) {
      double *const row = (*rows)[i];
      const uint64_t mark = marks[i];
      for (int s = 0; s < count; s++) row[s] = mark >> s & 1 ? row[s] : 0.0;
      marks[i] = 0;
    }
  }

 private:
  std::vector<uint64_t> marks;    // of slots that a contact of this step has

  int marked(int i, int slot)
  {
    if (grows) marks[i] |= uint64_t{1} << slot;
    return slot;
  }

  int take(int i, double partner)
  {
    double *const row = (*rows)[i];
    for (int s = 0; s < count; s++)
      if (row[s] == 0.0) {
        row[s] = partner;
        *spring(i, s) = *roll(i, s) = 0.0;
        return marked(i, s);
      }
    full = i;
    return -1;
  }
};

}    // namespace jump

#endif
