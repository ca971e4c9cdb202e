// SPDX-License-Identifier: GPL-2.0-or-later
/* The threads of a simulation of the native engine, and the discs that each has. */

#ifndef JUMP_CORE_CREW_H
#define JUMP_CORE_CREW_H

#include "drift.h"
#include "pace.h"
#include "parts.h"

namespace jump {

/** Room for lists that are made anew. */
struct ListRoom {
  std::vector<int32_t> cells, columns;          // of each disc
  std::vector<int64_t> ends;                    // of columns
  std::vector<uint64_t> sorted;                 // cells of discs in their order, and where these were
  std::vector<std::vector<int32_t>> rows;       // of the list, those of each thread
  std::vector<std::vector<int64_t>> scratch;    // of each array that is sorted
};

class Crew {
 public:
  Pace pace;
  ListRoom lists;
  std::vector<Part> parts;
  std::vector<Dissipated> taken;    // of each block of discs

  /** Give each thread its part of the discs and of their list, as these are now. */
  void divide(const jump_state &s)
  {
    const int64_t blocks = (s.n + BLOCK - 1) / BLOCK;
    const int64_t count = std::max<int64_t>(1, std::min<int64_t>(s.grid_first ? 1 : pace.threads(), blocks));
    if (s.listed_as == listed_as && s.n == n && s.sorted == sorted && count == team.size()) return;
    if (s.listed_as != listed_as || s.sorted != sorted) know(s);
    n = s.n;
    taken.resize((size_t) blocks);
    at.resize((size_t) n);
    team.resize((int) count);
    parts.resize((size_t) count);
    int64_t block = 0;
    for (int64_t k = 0; k < count; k++) {
      Part &part = parts[(size_t) k];
      part.begin = std::min(block * BLOCK, n);
      while (block < blocks && weight(s, block) * count < weight(s, blocks) * (k + 1)) block++;
      part.end = k + 1 == count ? n : std::min(block * BLOCK, n);
      part.sorted = sorted;
      part.first = first.data();
      part.at = rows();
      part.behind = std::min(part.end, sorted);
      const int64_t own = std::min(part.begin, sorted), inside = part.end < n ? part.behind - reach : part.behind;
      part.before = std::max<int64_t>(own - reach, 0);
      cut(s, own, std::max(own, inside), part.blocks);
    }
  }

  /** Call run(part) for each part. */
  template <class Run> void each(const Run &run)
  {
    team.run((int) parts.size(), [&](int part) { run(parts[(size_t) part]); });
  }

  /** Call run(k, from, to) for equal stretches of n things, one for each thread. */
  template <class Run> void stretches(int64_t n, const Run &run)
  {
    const int count = shares();
    team.run(count, [&](int k) { run(k, n * k / count, n * (k + 1) / count); });
  }
  int shares() const { return most((int) parts.size(), 1); }

  /** Call run(k) for k below `count`, at most MOST_THREADS. */
  template <class Run> void tasks(int count, const Run &run) { team.run(count, run); }

  /** Number of a list that is made here; those of Python are positive. */
  int64_t next_list() { return --number; }

  /** Place and velocity of each disc, as contacts see them. */
  double (*rows())[4] { return reinterpret_cast<double (*)[4]>(at.data()); }

 private:
  struct alignas(32) DiscRow {
    double numbers[4];
  };

  Team team;
  int64_t number = -1;    // of the list made last
  int64_t listed_as = -1, sorted = -1, n = -1;    // the list that is known, and the discs that are divided
  int64_t reach = 0;             // a pair of a sorted row has its second disc at most so far behind the first
  std::vector<int32_t> first;    // first disc of each pair of sorted rows
  std::vector<DiscRow, LineAllocator<DiscRow>> at;

  /** Look at a list that is new. */
  void know(const jump_state &s)
  {
    listed_as = s.listed_as;
    sorted = s.sorted;
    reach = 0;
    first.resize((size_t) (s.sorted > 0 ? s.start[s.sorted] : 0));
    for (int64_t row = 0; row < s.sorted; row++) {
      const int64_t from = s.start[row], to = s.start[row + 1];
      if (to == from) continue;
      std::fill(first.begin() + from, first.begin() + to, (int32_t) row);
      reach = most<int64_t>(s.neighbours[to - 1] - row, reach);
    }
  }

  /** Ends of blocks of rows, each with at most BATCH rows and pairs, or one row. */
  static void cut(const jump_state &s, int64_t from, int64_t to, std::vector<int64_t> &blocks)
  {
    blocks.assign(1, from);
    for (int64_t row = from; row < to; row++) {
      const int64_t begin = blocks.back();
      if (row > begin && (s.start[row + 1] - s.start[begin] > BATCH || row - begin == BATCH)) blocks.push_back(row);
    }
    if (to > from) blocks.push_back(to);
  }

  /** Work of the discs before a block. */
  static int64_t weight(const jump_state &s, int64_t block)
  {
    const int64_t row = std::min(block * BLOCK, s.n), pairs = s.sorted > 0 ? s.start[std::min(row, s.sorted)] : 0;
    return pairs + 3 * row;    // motion and sums take as long as some three pairs
  }
};

}    // namespace jump

#endif
