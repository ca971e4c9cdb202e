// SPDX-License-Identifier: GPL-2.0-or-later
/* Forces of touching pairs, in batches: pairs that touch are gathered without a branch, which would be guessed wrong often,
   their contacts are computed in vectors, and the forces are added in the order of the list. JUMP_SUMS is what a
   host takes (step.h): `WithLosses`, or in the plugin `ForcesAlone`. */

#include "contact/batch.h"    // before the core: its templates take vectors

#include "step/step.h"
#include "step/kinds.h"
#include "step/pair_memory.h"

#include <algorithm>

namespace jump {

/** Touching pairs, and what their contacts give to the sums. */
template <int ROOM> struct SummedBatch : ContactBatch<ROOM> {
  typedef double Column[ROOM];
  int64_t row[ROOM];
};

/** … of which forces and their lost parts are requested. */
struct BatchWithLosses : SummedBatch<BATCH> {
  alignas(64) Column fx, fy, dashpot_x, dashpot_y, tangential_x, tangential_y;
  alignas(64) double given[BATCH][4];      // force and its lost part
};

/** … the forces alone. */
struct BatchOfForces : SummedBatch<2 * BATCH> {
  alignas(64) double given[2 * BATCH][2];
};

/** What pairs add to one disc: force and its lost part. */
struct PairGiven {
  Four given{};
};

/** With friction: its part of the force, and the torque. */
struct PairGivenWithFriction : PairGiven {
  double tangential_x = 0.0, tangential_y = 0.0, torque = 0.0;
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
void each_stretch(const jump_state &s, const ThreadPart &part, ListRows which, const Rows &rows, const Inside &inside)
{
  if (which != ROWS_BEHIND) {
    rows(part.first_row, part.blocks.front());
    inside();
    rows(part.blocks.back(), part.end_row);
  }
  if (which != SORTED_ROWS) rows(part.sorted, s.rows);
}

/** Sums the forces of pairs on the discs of a part. */
template <bool SIZES, bool SPIN, class Law, class Sums> class PairSums {
  static constexpr bool HAS_FRICTION = Law::Friction::HAS_FRICTION, MEMORY = Law::Friction::HAS_HISTORY;
  static constexpr bool LOSSES = Sums::LOSSES;
  using Batch = typename Sums::Batch;
  using Added = std::conditional_t<HAS_FRICTION, PairGivenWithFriction, PairGiven>;

 public:
  PairSums(const jump_state &s, const Law &law, const ThreadPart &part)
      : s(s), law(law), part(part), seen(seen_by(s)), at(part.at), memory(memory_of(part)), sums_friction(HAS_FRICTION && s.friction_x),
        rolls(MEMORY && SPIN && s.pair.rolling > 0.0)
  {
  }

  /** Rows that are the part's own, with second discs after the first that are its own too. */
  void inside()
  {
    if constexpr (LOSSES) return inside_by_rows();
    else {
      const int64_t end = s.start[part.blocks.back()];
      for (int64_t from = s.start[part.blocks.front()]; from < end; from += ROOM) {
        find(from, least<int64_t>(from + ROOM, end));
        add_all();
      }
      b.n = 0;
    }
  }

  /** Any rows, in their order. */
  void across(int64_t from, int64_t to)
  {
    int64_t row_now = -1, disc = 0;
    Added sum;
    const auto end_row = [&]() {
      if constexpr (LOSSES)
        if (row_now >= 0 && part.owns(disc)) add(disc, sum);
    };
    const auto add_contact = [&](int c) {
      if constexpr (LOSSES) {
        if (b.row[c] != row_now) {
          end_row();
          sum = Added{};
          row_now = b.row[c];
          disc = b.one[c];
        }
        add_pair(c, sum);
      } else {
        add_now(c, part.owns(b.one[c]), part.owns(b.two[c]));
      }
    };
    const auto flush = [&]() {
      compute<false>();
      for (int c = 0; c < b.n; c++) add_contact(c);
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
      if (b.n == ROOM) flush();
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
  const bool sums_friction, rolls;
  size_t remote_history = 0;    // of the part's, those that are read
  static constexpr int ROOM = LOSSES ? BATCH : 2 * BATCH;
  Batch b;
  Added rows[LOSSES ? BATCH : 1];

  static Memory *memory_of(const ThreadPart &part)
  {
    if constexpr (MEMORY) return part.memory;
    else return nullptr;
  }
  Four &force(int64_t i) const { return *reinterpret_cast<Four *>(part.forces[i]); }

  /** Blocks of rows: the sum of each is kept until its end. */
  void inside_by_rows()
  {
    for (size_t block = 0; block + 1 < part.blocks.size(); block++) {
      const int64_t first = part.blocks[block], behind = part.blocks[block + 1], begin = s.start[first], end = s.start[behind];
      if (end - begin > BATCH) {    // one row that is longer
        across(first, behind);
        continue;
      }
      find(begin, end);
      add_batch(first);
      add_rows(first, (int) (behind - first));
    }
    b.n = 0;
  }

  /** The contacts of some pairs of the list that are the part's own, and their forces. */
  void find(int64_t from, int64_t to)
  {
    b.template find<SIZES>(at, s.radius, s.diameter, part.first, s.neighbours, from, to, memory);
    compute<true>();
  }

  /** The forces of the batch; FOUND: it has no differences yet. */
  template <bool FOUND> void compute()
  {
    gather<FOUND>();
    if constexpr (LOSSES) with_losses();
    else
      b.template evaluate<SIZES, SPIN>(law, numbers_of(s.pair, Lanes{}), s.fixed, 0.5 * s.diameter, [this](int c, const auto &out) {
        rows_of_two(out.fx, out.fy, b.given + c);
      });
    if constexpr (MEMORY) remember();
  }

  void with_losses()
  {
    b.template evaluate<SIZES, SPIN>(law, numbers_of(s.pair, Lanes{}), s.fixed, 0.5 * s.diameter, [this](int c, const auto &out) {
      lanes(b.fx + c) = out.fx;
      lanes(b.fy + c) = out.fy;
      lanes(b.dashpot_x + c) = out.dashpot * out.nx;
      lanes(b.dashpot_y + c) = out.dashpot * out.ny;
      if constexpr (HAS_FRICTION) {
        lanes(b.tangential_x + c) = out.tangential * out.ny;
        lanes(b.tangential_y + c) = out.tangential * out.nx;
      }
    });
    for (int c = 0; c < b.n; c += 4)
      rows_of_four(four(b.fx + c), four(b.fy + c), four(b.dashpot_x + c), four(b.dashpot_y + c), b.given + c);
  }

  /** What the contacts read of their discs; the last vector is filled with a contact that nobody reads. */
  template <bool FOUND> void gather()
  {
    const auto *const __restrict places = at;
    const double *const __restrict radius = s.radius, *const __restrict spin = seen.spin;
    const bool heavy = s.fixed;
    for (int c = 0, n = b.n; (FOUND || SIZES || SPIN || MEMORY) && c < n; c++) {
      const int32_t i = b.one[c], j = b.two[c];
      if constexpr (FOUND) b.difference(c) = *reinterpret_cast<const Four *>(places[i]) - *reinterpret_cast<const Four *>(places[j]);
      if constexpr (SIZES) {
        b.radius[0][c] = radius[i];
        b.radius[1][c] = radius[j];
        if (heavy) {
          b.bulk[0][c] = mass_radius(s, i);
          b.bulk[1][c] = mass_radius(s, j);
        }
      }
      if constexpr (SPIN) {
        b.spin[0][c] = spin[i];
        b.spin[1][c] = spin[j];
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

  /** Add the forces of the batch to its discs, which are the part's. */
  void add_all() const
  {
    double(*const __restrict forces)[4] = part.forces;
    double *const __restrict torque = s.torque;
    for (int c = 0, n = b.n; c < n; c++) {
      const int32_t i = b.one[c], j = b.two[c];
      const Two push = *reinterpret_cast<const Two *>(b.given[c]);
      *reinterpret_cast<Two *>(forces[i]) += push;
      *reinterpret_cast<Two *>(forces[j]) -= push;
      if constexpr (SPIN) {
        torque[i] += b.moment[0][c];
        torque[j] += b.moment[1][c];
      }
    }
  }

  /** Add the force of a contact to its discs, those of them that the part has. */
  void add_now(int c, bool to_one, bool to_two) const
  {
    const int64_t i = b.one[c], j = b.two[c];
    const Two push = *reinterpret_cast<const Two *>(b.given[c]);
    if (to_one) *reinterpret_cast<Two *>(part.forces[i]) += push;
    if (to_two) *reinterpret_cast<Two *>(part.forces[j]) -= push;
    if constexpr (SPIN) {
      if (to_one) s.torque[i] += b.moment[0][c];
      if (to_two) s.torque[j] += b.moment[1][c];
    }
  }

  /** Take the force of a contact off its second disc. */
  void take_off(int c, int64_t j) const
  {
    force(j) -= *reinterpret_cast<const Four *>(b.given[c]);
    if constexpr (SPIN) s.torque[j] += b.moment[1][c];
    if (!sums_friction) return;
    s.friction_x[j] += b.tangential_x[c];
    s.friction_y[j] -= b.tangential_y[c];
  }

  /** Add it to the sum of its first disc. */
  void put_on(int c, Added &sum) const
  {
    sum.given += *reinterpret_cast<const Four *>(b.given[c]);
    if constexpr (SPIN) sum.torque += b.moment[0][c];
    if constexpr (HAS_FRICTION) {
      sum.tangential_x -= b.tangential_x[c];
      sum.tangential_y += b.tangential_y[c];
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
      if (!sums_friction) return;
      s.friction_x[i] += sum.tangential_x;
      s.friction_y[i] += sum.tangential_y;
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

/** Ask for what the part reads of others, all at once: it was written by other cores a moment ago. */
inline void fetch_others(const ThreadPart &part)
{
  for (int64_t i = part.first_row; i < part.begin; i += 2) __builtin_prefetch(part.at[i]);
  for (int64_t i = part.end; i < part.end_neighbour; i += 2) __builtin_prefetch(part.at[i]);
}

template <class Sums> void pair_forces(const jump_state &s, double slope, ThreadPart &part, ListRows which)
{
  fetch_others(part);
  with_law(s, slope, [&](const auto &law, auto sizes, auto spin) {
    PairSums<sizes.value, spin.value, std::decay_t<decltype(law)>, Sums> sums(s, law, part);
    each_stretch(s, part, which, [&](int64_t from, int64_t to) { sums.across(from, to); }, [&]() { sums.inside(); });
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
  each_stretch(s, part, ALL_ROWS, take, []() {});
}

}    // namespace jump

#ifndef JUMP_SUMS
#define JUMP_SUMS WithLosses
#endif
template void jump::pair_forces<jump::JUMP_SUMS>(const jump_state &, double, ThreadPart &, ListRows);
