// SPDX-License-Identifier: GPL-2.0-or-later
/* Forces of touching pairs, in batches: pairs that touch are gathered without a branch, which would be guessed wrong often,
   their contacts are computed in vectors, and the forces are added in the order of the list. */

#include "contact/batch.h"    // before the core: its templates take vectors

#include "step/forces.h"
#include "step/kinds.h"
#include "step/pair_memory.h"

#include <algorithm>

namespace jump {

namespace {

typedef double Column[BATCH];

/** Touching pairs, and what their contacts give to the sums. */
struct SummedBatch : ContactBatch<BATCH> {
  int64_t row[BATCH];
  alignas(64) Column fx, fy, dashpot_x, dashpot_y, rubbed_x, rubbed_y;
  alignas(64) double given[BATCH][4];      // force and its lost part
};

/** What pairs add to one disc: force and its lost part. */
struct PairGiven {
  Four given{};
};

/** With friction: its part of the force, and the torque. */
struct Rubbed : PairGiven {
  double rubbed_x = 0.0, rubbed_y = 0.0, torque = 0.0;
};

/** Calls run(row, i, p, apart, touches) for the pairs of some rows that have a disc of the part, in their order; `apart` has
    their differences of place and velocity. It reads `at` alone: each line of memory of another part costs. */
template <class Run>
void each_across(const jump_state &s, const ThreadPart &part, int64_t from, int64_t to, const Run &run)
{
  for (int64_t row = from; row < to; row++) {
    const int64_t i = s.owner ? s.owner[row] : row;
    const bool own = part.owns(i);
    Four one = *reinterpret_cast<const Four *>(part.at[i]);
    if (s.shift) one[0] += s.shift[row];
    const double a = radius_of(s, i);
    for (int64_t p = s.start[row]; p < s.start[row + 1]; p++) {
      const int64_t j = s.neighbours[p];
      if (!own && !part.owns(j)) continue;
      const Four apart = one - *reinterpret_cast<const Four *>(part.at[j]);
      const double reach = a + radius_of(s, j);
      run(row, i, p, apart, apart[0] * apart[0] + apart[1] * apart[1] < reach * reach);
    }
  }
}

/** Calls rows(from, to) for the rows of a part that may have pairs across its ends, in the order of the list; between them
    inside() for the blocks of those that have none. */
template <class Rows, class Inside>
void each_stretch(const jump_state &s, const ThreadPart &part, const Rows &rows, const Inside &inside)
{
  rows(part.first_row, part.blocks.front());
  inside();
  rows(part.blocks.back(), part.end_row);
  rows(part.sorted, s.rows);
}

/** Sums the forces of pairs on the discs of a part. */
template <bool SIZES, bool SPIN, class Law> class PairSums {
  static constexpr bool HAS_FRICTION = Law::Friction::HAS_FRICTION, MEMORY = Law::Friction::HAS_HISTORY;
  using Added = std::conditional_t<HAS_FRICTION, Rubbed, PairGiven>;

 public:
  PairSums(const jump_state &s, const Law &law, const ThreadPart &part)
      : s(s), law(law), part(part), seen(seen_by(s)), at(part.at), memory(memory_of(part)), rubs(HAS_FRICTION && s.friction_x),
        rolls(MEMORY && SPIN && s.pair.rolling > 0.0)
  {
  }

  /** Blocks of rows that are the part's own, with second discs behind the first that are its own too. */
  void inside()
  {
    for (size_t block = 0; block + 1 < part.blocks.size(); block++) {
      const int64_t first = part.blocks[block], behind = part.blocks[block + 1], begin = s.start[first], end = s.start[behind];
      if (end - begin > BATCH) {    // one row that is longer
        across(first, behind);
        continue;
      }
      b.template find<SIZES>(at, s.radius, s.diameter, part.first, s.neighbours, begin, end, memory);
      for (int c = 0; c < b.n; c++) b.difference(c) = disc(b.one[c]) - disc(b.two[c]);
      compute();
      add_batch(first);
      add_rows(first, (int) (behind - first));
    }
    b.n = 0;
  }

  /** Any rows, in their order. */
  void across(int64_t from, int64_t to)
  {
    int64_t row_now = -1, disc = 0;
    Added sum;
    const auto end_row = [&]() {
      if (row_now >= 0 && part.owns(disc)) add(disc, sum);
    };
    const auto flush = [&]() {
      compute();
      for (int c = 0; c < b.n; c++) {
        if (b.row[c] != row_now) {
          end_row();
          sum = Added{};
          row_now = b.row[c];
          disc = b.one[c];
        }
        add_pair(c, sum);
      }
      b.n = 0;
    };
    b.n = 0;
    each_across(s, part, from, to, [&](int64_t row, int64_t i, int64_t p, const Four &apart, bool touches) {
      if constexpr (MEMORY)
        if (part.owns(i)) memory->see(p, touches);
      if (!touches) return;
      b.one[b.n] = (int32_t) i;
      b.two[b.n] = s.neighbours[p];
      b.place[b.n] = (int32_t) p;
      b.row[b.n] = row;
      b.difference(b.n) = apart;
      b.n++;
      if (b.n == BATCH) flush();
    });
    flush();
    end_row();
  }

 private:
  const jump_state &s;
  const Law &law;
  const ThreadPart &part;
  const ContactVelocities seen;
  const double (*const at)[4];
  using Memory = std::conditional_t<MEMORY, PairMemory, NoPairMemory>;
  Memory *const memory;
  const bool rubs, rolls;
  size_t remote_history = 0;    // of the part's, those that are read
  SummedBatch b;
  Added rows[BATCH];

  static Memory *memory_of(const ThreadPart &part)
  {
    if constexpr (MEMORY) return part.memory;
    else return nullptr;
  }
  const Four &disc(int64_t i) const { return *reinterpret_cast<const Four *>(at[i]); }
  Four &force(int64_t i) const { return *reinterpret_cast<Four *>(part.forces[i]); }

  /** The forces of the batch. */
  void compute()
  {
    gather();
    b.template evaluate<SIZES, SPIN>(law, numbers_of(s.pair, Lanes{}), s.fixed, 0.5 * s.diameter, [this](int c, const auto &out) {
      lanes(b.fx + c) = out.fx;
      lanes(b.fy + c) = out.fy;
      lanes(b.dashpot_x + c) = out.dashpot * out.nx;
      lanes(b.dashpot_y + c) = out.dashpot * out.ny;
      if constexpr (HAS_FRICTION) {
        lanes(b.rubbed_x + c) = out.tangential * out.ny;
        lanes(b.rubbed_y + c) = out.tangential * out.nx;
      }
    });
    for (int c = 0; c < b.n; c += 4)
      rows_of_four(four(b.fx + c), four(b.fy + c), four(b.dashpot_x + c), four(b.dashpot_y + c), b.given + c);
    if constexpr (MEMORY) remember();
  }

  /** What the contacts read of their discs; the last vector is filled with a contact that nobody reads. */
  void gather()
  {
    const double *const __restrict radius = s.radius;
    for (int c = 0; (SIZES || SPIN || MEMORY) && c < b.n; c++) {
      const int64_t i = b.one[c], j = b.two[c];
      if constexpr (SIZES) {
        b.radius[0][c] = radius[i];
        b.radius[1][c] = radius[j];
        if (s.fixed) {
          b.bulk[0][c] = mass_radius(s, i);
          b.bulk[1][c] = mass_radius(s, j);
        }
      }
      if constexpr (SPIN) {
        b.spin[0][c] = seen.spin[i];
        b.spin[1][c] = seen.spin[j];
      }
      if constexpr (MEMORY) recall(c);
    }
    b.fill(0.5 * s.diameter);
  }

  /** Springs of a contact; those of rows of other parts are borrowed. */
  void recall(int c)
  {
    const bool own = part.owns(b.one[c]);
    const int32_t p = b.place[c];
    b.slide[c] = own ? memory->slides()[p] : part.remote_history[remote_history].slide;
    if (rolls) b.roll[c] = own ? memory->rolls()[p] : part.remote_history[remote_history].roll;
    remote_history += !own;
  }

  void remember() const
  {
    if (!memory->goes_on) return;
    double *const slides = memory->slides(), *const rolls_of = memory->rolls();
    for (int c = 0; c < b.n; c++) {
      if (!part.owns(b.one[c])) continue;
      slides[b.place[c]] = b.slide[c];
      if (rolls) rolls_of[b.place[c]] = b.roll[c];
    }
  }

  /** Take the force of a contact off its second disc. */
  void take_off(int c, int64_t j) const
  {
    force(j) -= *reinterpret_cast<const Four *>(b.given[c]);
    if constexpr (SPIN) s.torque[j] += b.moment[1][c];
    if (!rubs) return;
    s.friction_x[j] += b.rubbed_x[c];
    s.friction_y[j] -= b.rubbed_y[c];
  }

  /** Add it to the sum of its first disc. */
  void put_on(int c, Added &sum) const
  {
    sum.given += *reinterpret_cast<const Four *>(b.given[c]);
    if constexpr (SPIN) sum.torque += b.moment[0][c];
    if constexpr (HAS_FRICTION) {
      sum.rubbed_x -= b.rubbed_x[c];
      sum.rubbed_y += b.rubbed_y[c];
    }
  }

  /** Add the sums of rows to their discs. */
  void add_rows(int64_t first, int count)
  {
    for (int k = 0; k < count; k++) add(first + k, rows[k]);
    std::fill_n(rows, count, Added{});
  }

  void add(int64_t i, const Added &sum) const
  {
    force(i) += sum.given;
    if constexpr (SPIN) s.torque[i] += sum.torque;
    if constexpr (HAS_FRICTION) {
      if (!rubs) return;
      s.friction_x[i] += sum.rubbed_x;
      s.friction_y[i] += sum.rubbed_y;
    }
  }

  /** Add a contact to those of its discs that the part has. */
  void add_pair(int c, Added &sum) const
  {
    put_on(c, sum);
    if (part.owns(b.two[c])) take_off(c, b.two[c]);
  }

  /** Add the batch: to second discs now, to the sums of rows for first ones. */
  void add_batch(int64_t first)
  {
    for (int c = 0; c < b.n; c++) {
      put_on(c, rows[b.one[c] - first]);
      take_off(c, b.two[c]);
    }
  }
};

}    // namespace

/** Ask for what the part reads of others, all at once: it was written by other cores a moment ago. */
static void fetch_others(const ThreadPart &part)
{
  for (int64_t i = part.first_row; i < part.begin; i += 2) __builtin_prefetch(part.at[i]);
  for (int64_t i = part.end; i < part.end_neighbour; i += 2) __builtin_prefetch(part.at[i]);
}

void pair_forces(const jump_state &s, double slope, ThreadPart &part)
{
  fetch_others(part);
  with_law(s, slope, [&](const auto &law, auto sizes, auto spin) {
    PairSums<sizes.value, spin.value, std::decay_t<decltype(law)>> sums(s, law, part);
    each_stretch(s, part, [&](int64_t from, int64_t to) { sums.across(from, to); },
                 [&]() { sums.inside(); });
  });
}

void borrow(const jump_state &s, ThreadPart &part)
{
  part.remote_history.clear();
  const auto take = [&](int64_t from, int64_t to) {
    each_across(s, part, from, to, [&](int64_t, int64_t i, int64_t p, const Four &, bool touches) {
      if (touches && !part.owns(i)) part.remote_history.push_back(part.memory->of(p));
    });
  };
  each_stretch(s, part, take, []() {});
}

}    // namespace jump
