// SPDX-License-Identifier: GPL-2.0-or-later
/* The threads of a simulation of the native engine, and the discs that each has. */

#ifndef JUMP_CORE_THREAD_PARTITION_H
#define JUMP_CORE_THREAD_PARTITION_H

#include "step/pair_search.h"    // before the core: its templates take vectors

#include "step/integrate.h"
#include "step/pair_memory.h"
#include "step/threads.h"
#include "step/rooms.h"
#include "step/thread_part.h"

namespace jump {

/** Number of a list: no two have the same, in this process or, as good as surely, another, so that a state may come from there.

    Those of Python are positive. */
inline int64_t next_list()
{
  static std::atomic<int64_t> last{-(int64_t) std::chrono::system_clock::now().time_since_epoch().count()};
  return --last;
}

/** Room for lists that are made anew. */
struct ListRoom : SearchRoom {
  std::vector<std::vector<int64_t>> copy;    // of each array that is sorted
};

class ThreadPartition {
 public:
  ThreadTuner tuner;
  ListRoom lists;
  Rooms rooms;
  int64_t lists_made = 0;
  bool both_remember = false;    // as of `ThreadPart`
  bool in_blocks = true;         // sums of rows are kept until the end of a block
  std::vector<ThreadPart> parts;
  PairMemory memory;
  std::vector<Dissipated> dissipated;    // of each block of discs

  /** Give each thread its part of the discs and of their list, as these are now. */
  void divide(const jump_state &s)
  {
    const int64_t blocks = (s.n + BLOCK - 1) / BLOCK;
    const int64_t count = std::max<int64_t>(1, std::min<int64_t>(s.grid_first ? 1 : tuner.threads(), blocks));
    const bool known = s.listed_as == listed_as && s.sorted == sorted;
    if (known && divided_as == listed_as && s.n == n && count == pool.size()) return;
    if (!known) know(s);
    divided_as = listed_as;
    n = s.n;
    dissipated.resize((size_t) blocks);
    for (auto *rows : {&at[0], &at[1], &forces}) rows->resize((size_t) (n + others));
    pool.resize((int) count);
    if ((int64_t) parts.size() == count) learn();
    else past.assign((size_t) count, {n, 1.0});
    parts.resize((size_t) count);
    const double all = work(s, blocks);
    int64_t block = 0;
    for (int64_t k = 0; k < count; k++) {
      ThreadPart &part = parts[(size_t) k];
      part.begin = std::min(block * BLOCK, n);
      while (block < blocks && work(s, block) * (double) count < all * (double) (k + 1)) block++;
      part.end = k + 1 == count ? n : std::min(block * BLOCK, n);
      part.sorted = sorted;
      part.both_remember = both_remember;
      part.first = first.data();
      part.memory = &memory;
      part.at = rows();
      part.forces = rows_of(forces);
      part.end_row = std::min(part.end, sorted);
      part.weight = weight(s, part.end) - weight(s, part.begin);
      part.spent = 0.0;
      const int64_t own = std::min(part.begin, sorted);
      part.first_row = reaching(s, own);
      const int64_t inside = part.end < n ? reaching(s, part.end_row) : part.end_row;
      part.end_neighbour = part.end;
      for (int64_t row = inside; row < part.end_row; row++)
        if (s.start[row + 1] > s.start[row]) part.end_neighbour = most<int64_t>(s.neighbours[s.start[row + 1] - 1] + 1, part.end_neighbour);
      cut(s, own, std::max(own, inside), part.blocks);
    }
  }

  /** Call run(part) for each part. */
  template <class Run> void each(const Run &run)
  {
    if (parts.size() == 1) return run(parts[0]);
    pool.run((int) parts.size(), [&](int k) {
      ThreadPart &part = parts[(size_t) k];
      const auto begun = WallClock::now();
      run(part);
      part.spent += std::chrono::duration<double>(WallClock::now() - begun).count();
    });
  }

  /** Call run(k, from, to) for stretches of n things, one for each thread: of as many discs as were divided, its own. */
  template <class Run> void stretches(int64_t count, const Run &run)
  {
    const int of = shares();
    const bool own = !parts.empty() && parts.back().end == count;
    const auto cut = [&](int k) { return own && k < of ? parts[(size_t) k].begin : count * k / of; };
    pool.run(of, [&](int k) { run(k, cut(k), cut(k + 1)); });
  }
  int shares() const { return most((int) parts.size(), 1); }

  /** How far a pair of a sorted row has its second disc after the first, at most. */
  int64_t reach_of(const jump_state &s)
  {
    if (s.listed_as != listed_as || s.sorted != sorted) know(s);
    return reach;
  }

  /** Place and velocity of each disc, as contacts see them; and the rows of the next step. */
  double (*rows())[4] { return rows_of(at[now]); }
  double (*other_rows())[4] { return rows_of(at[1 - now]); }

  /** Rows for so many discs of the state, and then `count` of other ranks. */
  void make_room_for(int64_t discs, int64_t count)
  {
    others = count;
    for (auto *rows : {&at[0], &at[1], &forces}) rows->resize((size_t) (discs + others));
    for (ThreadPart &part : parts) {
      part.at = rows();
      part.forces = rows_of(forces);
    }
  }

  /** Sort the rows as the last search has sorted the discs; those of other ranks stay after them. */
  void sort_rows(int64_t discs)
  {
    const DiscRow *const from = at[now].data();
    DiscRow *const to = at[1 - now].data();
    stretches(discs, [&](int, int64_t begin, int64_t end) {
      for (int64_t i = begin; i < end; i++) to[i] = from[was_at(lists.sorted[(size_t) i])];
    });
    std::copy_n(from + discs, others, to + discs);
    turn_rows();
  }

  /** From here on contacts see the other rows. */
  void turn_rows()
  {
    now = 1 - now;
    for (ThreadPart &part : parts) part.at = rows();
  }

 private:
  struct alignas(32) DiscRow {
    double numbers[4];
  };

  ThreadPool pool;
  int64_t listed_as = -1, sorted = -1;            // the list that is known
  int64_t divided_as = -1, n = -1;                // and that by which discs are divided
  int64_t others = 0;
  int64_t reach = 0;             // a pair of a sorted row has its second disc at most so far after the first
  std::vector<int32_t> first;    // first disc of each pair of sorted rows
  /** Where a part ended that was divided before, and the time of its work over that of all. */
  struct Past {
    int64_t end;
    double rate;
  };
  std::vector<Past> past;
  using DiscRows = std::vector<DiscRow, LineAllocator<DiscRow>>;
  DiscRows at[2], forces;
  int now = 0;    // those that contacts see

  static double (*rows_of(DiscRows &rows))[4] { return reinterpret_cast<double (*)[4]>(rows.data()); }

  /** Look at a list that is new. */
  void know(const jump_state &s)
  {
    listed_as = s.listed_as;
    sorted = s.sorted;
    divided_as = -1;
    first.resize((size_t) (s.sorted > 0 ? s.start[s.sorted] : 0));
    std::vector<int64_t> far((size_t) shares(), 0);
    stretches(s.sorted, [&](int k, int64_t begin, int64_t end) {
      int64_t most_far = 0;
      for (int64_t row = begin; row < end; row++) {
        const int64_t from = s.start[row], to = s.start[row + 1];
        put_four(from, to, s.start[end], (int32_t) row);
        if (to > from) most_far = most<int64_t>(s.neighbours[to - 1] - row, most_far);
      }
      far[(size_t) k] = most_far;
    });
    reach = *std::max_element(far.begin(), far.end());
  }

  /** Write a row's number for each of its pairs, four at a time: what comes after is written next, up to `end`. */
  void put_four(int64_t from, int64_t to, int64_t end, int32_t row)
  {
    int32_t *const at = first.data();
    for (; from < to && from + 4 <= end; from += 4)
      for (int k = 0; k < 4; k++) at[from + k] = row;
    for (; from < to; from++) at[from] = row;
  }

  /** Ends of blocks of rows, each with at most BATCH rows and pairs, or one row; of all of them, where there are no blocks. */
  void cut(const jump_state &s, int64_t from, int64_t to, std::vector<int64_t> &blocks) const
  {
    blocks.assign(1, from);
    for (int64_t row = from; in_blocks && row < to; row++) {
      const int64_t begin = blocks.back();
      if (row > begin && (s.start[row + 1] - s.start[begin] > BATCH || row - begin == BATCH)) blocks.push_back(row);
    }
    if (to > from) blocks.push_back(to);
  }

  /** First of the rows that may have pairs across a cut of the sorted discs. */
  int64_t reaching(const jump_state &s, int64_t cut) const
  {
    for (int64_t row = most<int64_t>(cut - reach, 0); row < cut; row++)
      if (s.start[row + 1] > s.start[row] && s.neighbours[s.start[row + 1] - 1] >= cut) return row;
    return cut;
  }

  /** What the discs before a row take, but for their contacts: motion and sums take as long as some three pairs. */
  double weight(const jump_state &s, int64_t row) const
  {
    return (double) ((sorted > 0 ? s.start[std::min(row, sorted)] : 0) + 3 * row);
  }

  /** Learn from the time that the parts took: where discs touch, each takes longer. */
  void learn()
  {
    double spent = 0.0, of_all = 0.0;
    for (const ThreadPart &part : parts) {
      spent += part.spent;
      of_all += part.weight;
    }
    for (size_t k = 0; k < parts.size(); k++) {
      past[k].end = parts[k].end;
      if (!(spent > 0.0 && parts[k].weight > 0.0)) continue;
      const double found = parts[k].spent / spent * of_all / parts[k].weight;    // a part that had to wait for a core shows more
      past[k].rate = 0.5 * past[k].rate + 0.5 * std::clamp(found, 0.5, 2.0);
    }
  }

  /** Work of the discs before a block. */
  double work(const jump_state &s, int64_t block) const
  {
    const double to = weight(s, std::min(block * BLOCK, s.n));
    double sum = 0.0, from = 0.0;
    for (size_t k = 0; k < past.size(); k++) {
      const double end = k + 1 == past.size() ? to : least(weight(s, std::min(past[k].end, s.n)), to);
      sum += past[k].rate * most(end - from, 0.0);
      from = most(end, from);
    }
    return sum;
  }
};

}    // namespace jump

#endif
