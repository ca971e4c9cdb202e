// SPDX-License-Identifier: GPL-2.0-or-later
/* What discs remember of their contacts, in an array of fix jump/step (the rule: core/contact/history.h).

   A row holds COUNT partners (id of a disc, -1 - c for chain c of the walls, 0: empty), then as many arc lengths of the
   foot, elongations of the tangential and of the rolling spring, m. */

#ifndef JUMP_DISC_SLOTS_H
#define JUMP_DISC_SLOTS_H

#include "contact/law.h"
#include "contact/history.h"

#include <atomic>
#include <cstdint>
#include <vector>

namespace jump {

constexpr int MOST_SLOTS = 64;    // bits of a mark

class DiscSlots {
 public:
  double **const *rows = nullptr;    // the fix's array, which may move
  int number = 0;                    // of slots of a disc
  bool grows = false;                // springs go on; else they stay as they are, as in the first forces of a run
  std::atomic<int> full{-1};         // a disc that has no slot left

  void begin(int discs) { marks.assign(discs, 0); }

  double *spring(int i, int slot) const { return (*rows)[i] + 2 * number + slot; }
  double *roll(int i, int slot) const { return (*rows)[i] + 3 * number + slot; }

  /** Slot of disc i for a partner, taken where there is none and springs grow; FULL without one.

      At a chain of a wall it is the one with the nearest foot, at most `limit` away; `around` closes the chain. */
  int of(int i, double partner, double foot = 0.0, double limit = 0.0, double around = 0.0)
  {
    AtomSlots row{(*rows)[i], number, marks[i]};
    if (!grows) return held(row, partner, foot, limit, around);
    const int slot = slot_of(row, partner, foot, limit, around);
    if (slot == FULL) full = i;
    return slot;
  }

  /** Empty the slots of some discs whose contacts have ended. */
  void end(int from, int to)
  {
    for (int i = from; i < to; i++) {
      double *const row = (*rows)[i];
      const uint64_t mark = marks[i];
      for (int s = 0; s < number; s++) row[s] = mark >> s & 1 ? row[s] : 0.0;
      marks[i] = 0;
    }
  }

 private:
  struct AtomSlots {
    double *row;
    int number;
    uint64_t &marks;    // of slots that a contact of this step has

    int count() const { return number; }
    double partner(int s) const { return row[s]; }
    double foot(int s) const { return row[number + s]; }
    bool used(int s) const { return marks >> s & 1; }
    void take(int s, double partner)
    {
      row[s] = partner;
      row[2 * number + s] = row[3 * number + s] = 0.0;
    }
    void mark(int s, double foot)
    {
      row[number + s] = foot;
      marks |= uint64_t{1} << s;
    }
  };

  std::vector<uint64_t> marks;
};

}    // namespace jump

#endif
