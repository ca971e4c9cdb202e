// SPDX-License-Identifier: GPL-2.0-or-later
/* What pairs remember while steps are made: their springs are in the order of the list of pairs, so no step looks for a slot.

   Slots (contact/contact.h) are the form that lasts: hosts, sums and sorting of the discs know them alone. `begin` takes the
   springs of pairs out of the slots, `end` puts them back. Between the two, slots hold contacts with walls alone. */

#ifndef JUMP_CORE_PAIR_MEMORY_H
#define JUMP_CORE_PAIR_MEMORY_H

#include "step/kinds.h"
#include "step/thread_part.h"

#include <algorithm>
#include <cstring>
#include <vector>

namespace jump {

/** Springs of pairs by their places in the list, m. Rolling is that of the first disc of the pair. */
class PairMemory {
 public:
  static constexpr bool REMEMBERS = true;

  /** Whether springs go on: else they stay as they are. */
  bool goes_on = false;

  /** Take what slots remember of the pairs of the list. */
  template <class Partition> void begin(const jump_state &s, Partition &partition)
  {
    goes_on = s.memory_step > 0.0;
    const size_t pairs = (size_t) s.start[s.rows] + 4;    // four are looked at together
    for (auto *const column : {&slide, &roll}) column->resize(pairs);
    touched.resize(pairs);
    partition.stretches(s.rows, [&](int, int64_t from, int64_t to) {
      for (int64_t row = from; row < to; row++) look(s, row);
    });
    if (!goes_on) return;
    has_wall.assign((size_t) s.n, 0);
    partition.stretches(s.n, [&](int, int64_t from, int64_t to) {
      for (int64_t i = from; i < to; i++) has_wall[(size_t) i] = empty_slots(s, i);
    });
    at_walls.clear();
  }

  /** See which discs are near walls, after `begin` and where they are listed anew. */
  void see_walls(const jump_state &s)
  {
    if (!goes_on) return;
    for (int64_t row = 0; row < s.near_rows[s.walls]; row++) has_wall[(size_t) s.near_discs[row]] = 1;
    at_walls.clear();
    for (int64_t i = 0; i < s.n; i++)
      if (has_wall[(size_t) i]) at_walls.push_back((int32_t) i);
  }

  /** Put the springs of the pairs that touch into slots again, those of a part's discs. */
  void end(const jump_state &s, const ThreadPart &part) const
  {
    if (!goes_on) return;
    each_at_wall(part, [&](int64_t i) { sort_slots(s, i); });
    const auto put_rows = [&](int64_t from, int64_t to) {
      for (int64_t row = from; row < to; row++)
        for (int64_t p = s.start[row]; p < s.start[row + 1]; p++)
          if (touched[(size_t) p]) put(s, part, s.owner ? s.owner[row] : row, p);
    };
    put_rows(part.first_row, part.end_row);
    put_rows(part.sorted, s.rows);
  }

  /** Calls run(i) for the discs of a part that are near walls or remember one. */
  template <class Run> void each_at_wall(const ThreadPart &part, const Run &run) const
  {
    for (auto next = std::lower_bound(at_walls.begin(), at_walls.end(), part.begin); next != at_walls.end() && *next < part.end; next++)
      run(*next);
  }

  /** Springs of a pair as the step finds them. */
  Stretch<double> of(int64_t p) const
  {
    return touched[(size_t) p] ? Stretch<double>{slide[(size_t) p], roll[(size_t) p]} : Stretch<double>{0.0, 0.0};
  }

  /** See whether a pair touches in this step: springs begin at 0. */
  void see(int64_t p, bool touches)
  {
    if (!goes_on) return;
    if (touches && !touched[(size_t) p]) clear(p);
    touched[(size_t) p] = touches;
  }

  /** The same of four pairs, whose truths are the bits of a number. */
  void see_four(int64_t p, int touch)
  {
    if (!goes_on) return;
    uint32_t before;
    std::memcpy(&before, touched.data() + p, 4);
    const uint32_t now = BYTES[touch];
    if (now == before) return;
    for (int k = 0; k < 4; k++)
      if ((touch >> k & 1) && !touched[(size_t) (p + k)]) clear(p + k);
    std::memcpy(touched.data() + p, &now, 4);
  }

  double *slides() { return slide.data(); }
  double *rolls() { return roll.data(); }

 private:
  /** Bytes of 1 for the bits of a number below 16, in their order in memory. */
  static constexpr uint32_t BYTES[16] = {0x0,       0x1,       0x100,       0x101,       0x10000,   0x10001,   0x10100,   0x10101,
                                         0x1000000, 0x1000001, 0x1000100,   0x1000101,   0x1010000, 0x1010001, 0x1010100, 0x1010101};

  std::vector<double> slide, roll;
  std::vector<uint8_t> touched;      // whether a pair touched in the step before
  std::vector<uint8_t> has_wall;     // of each disc
  std::vector<int32_t> at_walls;     // discs near walls, or that remember one, in their order

  void clear(int64_t p) { slide[(size_t) p] = roll[(size_t) p] = 0.0; }

  void look(const jump_state &s, int64_t row)
  {
    const int64_t i = s.owner ? s.owner[row] : row;
    for (int64_t p = s.start[row]; p < s.start[row + 1]; p++) {
      const PairHistory memory(s, i, s.neighbours[p]);
      const ContactHistory found = memory.look(s);
      const Stretch<double> held = found.begin(memory.way);
      slide[(size_t) p] = held.slide;
      roll[(size_t) p] = held.roll;
      touched[(size_t) p] = found.place() != FULL;
    }
  }

  /** Empty the slots of a disc that remember discs. Returns whether others remember walls. */
  static bool empty_slots(const jump_state &s, int64_t i)
  {
    bool has_wall = false;
    for (int64_t at = i * s.slot_row, last = at + s.slots; at < last; at++) {
      if (s.partner[at] > 0) clear_slot(s, at);
      has_wall = has_wall || s.partner[at] < 0;
    }
    return has_wall;
  }

  /** Contacts with walls in an order that does not depend on when they began: by wall and place. */
  static void sort_slots(const jump_state &s, int64_t i)
  {
    const int64_t first = i * s.slot_row;
    int64_t end = first;
    for (int64_t at = first; at < first + s.slots; at++) {
      if (s.partner[at] == 0) continue;
      const Slot one{s.partner[at], s.sigma[at], s.spring[at], s.roll[at]};
      clear_slot(s, at);
      int64_t to = end++;
      for (; to > first && one < slot(s, to - 1); to--) set_slot(s, to, slot(s, to - 1));
      set_slot(s, to, one);
    }
  }

  struct Slot {
    int64_t partner;
    double foot, spring, roll;

    bool operator<(const Slot &other) const { return partner > other.partner || (partner == other.partner && foot < other.foot); }
  };
  static Slot slot(const jump_state &s, int64_t at) { return {s.partner[at], s.sigma[at], s.spring[at], s.roll[at]}; }
  static void set_slot(const jump_state &s, int64_t at, const Slot &to)
  {
    s.partner[at] = to.partner;
    s.sigma[at] = to.foot;
    s.spring[at] = to.spring;
    s.roll[at] = to.roll;
  }
  static void clear_slot(const jump_state &s, int64_t at) { set_slot(s, at, Slot{0, 0.0, 0.0, 0.0}); }

  void put(const jump_state &s, const ThreadPart &part, int64_t i, int64_t p) const
  {
    const PairHistory memory(s, i, s.neighbours[p]);
    const double held = slide[(size_t) p], rolling = memory.way * roll[(size_t) p];
    if (part.owns(memory.disc)) put(s, memory.disc, Slot{memory.partner, 0.0, held, rolling});
    if (part.both_remember && part.owns(memory.other)) put(s, memory.other, Slot{s.ids[memory.disc], 0.0, held, -rolling});
  }

  static void put(const jump_state &s, int64_t disc, const Slot &one)
  {
    int64_t at = disc * s.slot_row;
    const int64_t last = at + s.slots;
    while (at < last && s.partner[at] != 0) at++;
    if (at == last) *s.full = s.ids[disc];
    else set_slot(s, at, one);
  }
};

}    // namespace jump

#endif
