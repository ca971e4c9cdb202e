// SPDX-License-Identifier: GPL-2.0-or-later
/* The forces of pair_style jump/disc, and what is summed over its pairs (what it is: pair_jump_disc.h). */

#include "pair_jump_disc.h"

#include "atom.h"
#include "comm.h"
#include "error.h"
#include "neighbor.h"
#include "update.h"

#include <algorithm>

using namespace LAMMPS_NS;
using jump::Four;
using jump::four;
using jump::FourInts;
using jump::Lanes;
using jump::LANES;
using jump::spread;

namespace {
typedef double Vec2 __attribute__((vector_size(16), aligned(8), may_alias));
constexpr size_t FEW_PAIRS = 512;    // for a thread of its own
constexpr int BATCH = 256;    // contacts evaluated together: their arrays stay in the first-level cache

/** As many numbers as a vector has, from an aligned place. */
inline Lanes &lanes(double *from) { return *reinterpret_cast<Lanes *>(from); }
}    // namespace

double PairJumpDisc::largest_squared_speed() const
{
  const int nlocal = atom->nlocal;
  double most = 0.0;
  for (int i = 0; i < nlocal; i++) {
    const double vsq = disc[i].vx * disc[i].vx + disc[i].vy * disc[i].vy;
    most = vsq > most ? vsq : most;
  }
  return most;
}

void PairJumpDisc::find_largest_speed()
{
  double most = largest_squared_speed();
  if (comm->nprocs > 1) MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_DOUBLE, MPI_MAX, world);
  largest_speed = std::sqrt(most);
  law.choice.slope = jump::sign_slope(largest_speed);
}

/** Where disc i remembers its contact with disc j: its tangential spring, `slots.number` before its rolling one; null: nowhere. */
double *PairJumpDisc::remembered(int i, int j, const PairPart *part)
{
  const bool shared = part && beside[i];
  auto &lock = locks[i % LOCKS];
  if (shared)
    while (lock.test_and_set(std::memory_order_acquire)) {}    // another thread is in the slots of this disc, or one like it
  const int slot = slots.of(i, tags[j]);
  if (shared) lock.clear(std::memory_order_release);
  return slot == jump::FULL ? nullptr : slots.spring(i, slot);
}

/** A row of a contact of two discs; of one across a cut or seam, which is listed twice, the larger id has it. */
void PairJumpDisc::note(int i, int j, const double *push)
{
  const bool across = j >= atom->nlocal;
  if (across && tags[i] < tags[j]) return;
  const auto &a = disc[i], &b = disc[j];
  const double dx = a.x - b.x, dy = a.y - b.y, r = std::sqrt(dx * dx + dy * dy), overlap = reach_of(i, j) - r;
  const double way = jump::way_to_middle(radius_of(i), overlap) / r;
  record->push_back({(int32_t) tags[i], (int32_t) tags[j], (float) (a.x - way * dx), (float) (a.y - way * dy),
                     (float) push[0], (float) push[1], NAN});
}

/** Contacts of the pairs of this rank, with the forces of the last evaluation. */
void PairJumpDisc::list_contacts(std::vector<jump::ContactRow> &rows)
{
  const bool grew = slots.grows;
  double &goes_on = law.choice.time_step;
  const double dt = goes_on;
  slots.grows = false;
  goes_on = 0.0;
  record = &rows;
  evaluate(0, candidates);
  record = nullptr;
  goes_on = dt;
  slots.grows = grew;
}

/** The discs of other parts, as they are in this step. */
void PairJumpDisc::take_copies(const PairPart &part)
{
  int to = part.copies;
  for (const int from : part.across) {
    disc[to] = disc[from];
    pushes[2 * to] = pushes[2 * to + 1] = 0.0;    // of no use
    if (spin) {
      spins[to] = spins[from];
      turns[to] = 0.0;
    }
    if (sizes) radii[to] = radii[from];    // inserted discs change theirs
    if (any_fixed()) bulk[to] = bulk[from];
    to++;
  }
}

/** Add the force of a contact with springs to the discs of a part, but keep that on discs beside a cut. */
void PairJumpDisc::add(PairPart &part, int i, int j, const double *push, double turn_i, double turn_j)
{
  const int own = (int) (&part - parts.data());
  const auto add = [&](int disc, double fx, double fy, double moment) {
    if (beside[disc]) {
      part.late[beside[disc] - 1 == own].push_back({disc, place[i], fx, fy, moment});
      return;
    }
    pushes[2 * disc] += fx;
    pushes[2 * disc + 1] += fy;
    if (spin) turns[disc] += moment;
  };
  add(i, push[0], push[1], turn_i);
  if (j < atom->nlocal) add(j, -push[0], -push[1], turn_j);
}

/** Add what was kept at the cuts, in the order of the list. */
void PairJumpDisc::add_late()
{
  const auto add = [&](const Late &one) {
    pushes[2 * one.disc] += one.fx;
    pushes[2 * one.disc + 1] += one.fy;
    if (spin) turns[one.disc] += one.moment;
  };
  for (size_t c = 0; c + 1 < parts.size(); c++) {
    const auto &behind = parts[c + 1].late[0];
    auto b = behind.begin();
    for (const Late &one : parts[c].late[1]) {
      for (; b != behind.end() && b->order < one.order; b++) add(*b);
      add(one);
    }
    for (; b != behind.end(); b++) add(*b);
  }
}

/** Forces of the pairs from one place to another in the list, or in a part of it. */
template <bool SIZES, bool SPIN, class Law>
void PairJumpDisc::evaluate_list(const Law &rule, size_t from, size_t to, PairPart *part)
{
  const PackedDisc *const __restrict at = disc.data();
  const int *const __restrict one = part ? part->first.data() : first.data();
  const int *const __restrict two = part ? part->second.data() : second.data();
  const double *const __restrict own_radius = radii.data();
  const int nlocal = atom->nlocal;
  const double radius = 0.5 * diameter;
  double *const __restrict f = pushes.data();
  double *const __restrict torque = turns.data();
  const double *const __restrict omega = spins.data();
  const jump::Numbers<Lanes> of = jump::numbers_of(law.of, Lanes{});

  // a batch of candidates at a time: differences of those that touch, then their forces, then the sums
  alignas(64) double between[BATCH][4];
  alignas(64) double force_on[BATCH][2];
  constexpr bool SPRINGS = Law::Friction::REMEMBERS;
  alignas(64) double spin_one[SPIN ? BATCH : 1], spin_two[SPIN ? BATCH : 1], on_one[SPIN ? BATCH : 1], on_two[SPIN ? BATCH : 1];
  alignas(64) double radius_one[SIZES ? BATCH : 1], radius_two[SIZES ? BATCH : 1];
  alignas(64) double bulk_one[SIZES ? BATCH : 1], bulk_two[SIZES ? BATCH : 1];
  alignas(64) double stretch[SPRINGS ? BATCH : 1], bent[SPRINGS ? BATCH : 1];
  double *of_one[SPRINGS ? BATCH : 1], *of_two[SPRINGS ? BATCH : 1];    // springs of the two discs, or null
  const bool both = ring.is_needed(), stays = any_fixed();
  const double *const __restrict own_bulk = bulk.data();
  int i_of[BATCH + 4], j_of[BATCH + 4];    // discs of the pairs that touch
  for (size_t begin = from; begin < to; begin += BATCH) {
    const size_t end = begin + BATCH < to ? begin + BATCH : to;
    int n = 0;
    const auto apart = [&](int i, int j) {
      return *reinterpret_cast<const Four *>(&at[i]) - *reinterpret_cast<const Four *>(&at[j]);
    };
    const auto reach = [&](size_t p) { return SIZES ? own_radius[one[p]] + own_radius[two[p]] : diameter; };
    // without a branch, which would be guessed wrong often; the last ones, and all of them without AVX, one at a time
    size_t p = begin;
    for (; jump::HAS_FOUR && p + 4 <= end; p += 4) {
      Four a = apart(one[p], two[p]), b = apart(one[p + 1], two[p + 1]), c = apart(one[p + 2], two[p + 2]),
           d = apart(one[p + 3], two[p + 3]);
      a *= a, b *= b, c *= c, d *= d;
      const Four ab = JUMP_PICK(a, b, 0, 4, 2, 6) + JUMP_PICK(a, b, 1, 5, 3, 7);
      const Four cd = JUMP_PICK(c, d, 0, 4, 2, 6) + JUMP_PICK(c, d, 1, 5, 3, 7);
      const Four reaches = {reach(p), reach(p + 1), reach(p + 2), reach(p + 3)};
      const int mask = jump::bits(JUMP_PICK(ab, cd, 0, 1, 4, 5) < reaches * reaches);
      *reinterpret_cast<FourInts *>(i_of + n) = jump::first_of(four(one + p), mask);
      *reinterpret_cast<FourInts *>(j_of + n) = jump::first_of(four(two + p), mask);
      n += __builtin_popcount(mask);
    }
    for (; p < end; p++) {
      const Four a = apart(one[p], two[p]);
      i_of[n] = one[p];
      j_of[n] = two[p];
      n += a[0] * a[0] + a[1] * a[1] < reach(p) * reach(p);
    }
    for (int c = 0; c < n; c++) {
      const int i = i_of[c], j = j_of[c];
      *reinterpret_cast<Four *>(between[c]) = apart(i, j);
      if constexpr (SPIN) {
        spin_one[c] = omega[i];
        spin_two[c] = omega[j];
      }
      if (SIZES) {
        radius_one[c] = own_radius[i];
        radius_two[c] = own_radius[j];
        if (stays) {
          bulk_one[c] = own_bulk[i];
          bulk_two[c] = own_bulk[j];
        }
      }
      if constexpr (SPRINGS) {
        const bool larger = tags[i] > tags[j];
        of_one[c] = both || larger ? remembered(i, j, part) : nullptr;
        of_two[c] = j < nlocal && (both || !larger) ? remembered(j, i, part) : nullptr;
        const double *const held = of_one[c] ? of_one[c] : of_two[c];
        stretch[c] = held ? *held : 0.0;
        if constexpr (SPIN)    // of disc i against disc j
          bent[c] = !held ? 0.0 : of_one[c] ? held[slots.number] : -held[slots.number];
      }
    }
    // whole vectors only: the rest of the last one is filled with a contact that nobody reads
    const int whole = (n + LANES - 1) / LANES * LANES;
    for (int c = n; c < whole; c++) {
      between[c][0] = between[c][1] = 0.5 * diameter;
      between[c][2] = between[c][3] = 0.0;
      if constexpr (SPIN) spin_one[c] = spin_two[c] = 0.0;
      if (SIZES) radius_one[c] = radius_two[c] = bulk_one[c] = bulk_two[c] = radius;
      if constexpr (SPRINGS) stretch[c] = bent[c] = 0.0;
    }
    for (int c = 0; c < whole; c += LANES) {
      Lanes gap[4];
      jump::columns(between + c, gap);
      jump::Pair<Lanes> pair;
      pair.dx = gap[0];
      pair.dy = gap[1];
      pair.vx = gap[2];
      pair.vy = gap[3];
      pair.apart2 = pair.dx * pair.dx + pair.dy * pair.dy;
      if constexpr (SIZES) {
        pair.a = lanes(radius_one + c);
        pair.b = lanes(radius_two + c);
        pair.bulk_a = stays ? lanes(bulk_one + c) : pair.a;
        pair.bulk_b = stays ? lanes(bulk_two + c) : pair.b;
      } else {
        pair.a = pair.b = spread(radius, Lanes{});
      }
      if constexpr (SPIN) {
        pair.spin_a = lanes(spin_one + c);
        pair.spin_b = lanes(spin_two + c);
      }
      jump::Stretch<Lanes> held{};
      if constexpr (SPRINGS) {
        held.slide = lanes(stretch + c);
        if constexpr (SPIN) held.roll = lanes(bent + c);
      }
      const auto out = jump::pair_contact<SIZES, SPIN>(rule, of, pair, held);
      jump::rows_of_two(out.fx, out.fy, force_on + c);
      if constexpr (SPRINGS) {
        lanes(stretch + c) = held.slide;
        if constexpr (SPIN) lanes(bent + c) = held.roll;
      }
      if constexpr (SPIN) {
        lanes(on_one + c) = out.on_a;
        lanes(on_two + c) = out.on_b;
      }
    }
    if constexpr (SPRINGS)
      if (rule.tangential.time_step > 0.0)
        for (int c = 0; c < n; c++) {
          if (of_one[c]) of_one[c][0] = stretch[c];
          if (of_two[c]) of_two[c][0] = stretch[c];
          if constexpr (SPIN) {
            if (of_one[c]) of_one[c][slots.number] = bent[c];
            if (of_two[c]) of_two[c][slots.number] = -bent[c];
          }
        }
    if (record) {
      for (int c = 0; c < n; c++) note(i_of[c], j_of[c], force_on[c]);
      continue;
    }
    for (int c = 0; c < n; c++) {
      const int i = i_of[c], j = j_of[c];
      const Vec2 push = *reinterpret_cast<const Vec2 *>(force_on[c]);
      if (SPRINGS && part && (beside[i] || beside[j])) {
        add(*part, i, j, force_on[c], SPIN ? on_one[c] : 0.0, SPIN ? on_two[c] : 0.0);
        continue;
      }
      *reinterpret_cast<Vec2 *>(f + 2 * i) += push;
      if constexpr (SPIN) torque[i] += on_one[c];
      if (j < nlocal) {
        *reinterpret_cast<Vec2 *>(f + 2 * j) -= push;
        if constexpr (SPIN) torque[j] += on_two[c];
      }
    }
  }
}

void PairJumpDisc::compute(int eflag, int vflag)
{
  ev_init(eflag, vflag);
  if (neighbor->includegroup) {    // keep_uncleared
    neighbor->includegroup = 0;
    atom->nfirst = first_group;
  }
  if (eflag_atom || vflag_atom || cvflag_atom || num_tally_compute > 0)
    error->all(FLERR, "pair_style jump/disc gives no energy and no virial: leave out computes of them for each disc");
  eng_vdwl = NAN;    // LAMMPS asks for the sums at steps where nothing may read them: no error then
  std::fill_n(virial, 6, NAN);
  const bool ranks = ring.is_needed();
  // fix jump/step has packed the local discs; a reneighbouring may have moved them to other indices since
  const bool fresh = neighbor->ago == 0 || moved_by_others();
  if (fresh) pack();
  if (ranks) fresh ? ring.rebuild(*this, halo_cut()) : ring.start(*this);
  if (sign) find_largest_speed();
  if (springs) {
    slots.grows = !update->setupflag;
    slots.begin(atom->nlocal);
    if (ranks && update->setupflag) share_memory();
    law.choice.time_step = slots.grows ? update->dt : 0.0;
  }
  travel(moved_here);
  const bool early = ranks && !fresh && !worn(moved_here);    // contacts of local discs, while the others travel
  if (early) evaluate(0, interior);
  if (ranks && !fresh) ring.finish(*this);
  widen_range();
  travel(moved);
  update_list();
  evaluate(early ? interior : 0, candidates);
}

/** Take the others' velocities into the range of this step. */
void PairJumpDisc::widen_range()
{
  for (int i = atom->nlocal; i < atom->nlocal + ring.count(); i++) {
    range_lo[0] = std::min(range_lo[0], disc[i].vx);
    range_hi[0] = std::max(range_hi[0], disc[i].vx);
    range_lo[1] = std::min(range_lo[1], disc[i].vy);
    range_hi[1] = std::max(range_hi[1], disc[i].vy);
  }
}

void PairJumpDisc::evaluate(size_t from, size_t to)
{
  const int count = team.size();
  if (count > 1 && !record && from == 0 && to >= built && built >= FEW_PAIRS * (size_t) count) {
    divide(count);
    team.run((int) parts.size(), [&](int c) {
      PairPart &part = parts[c];
      take_copies(part);
      for (auto &late : part.late) late.clear();
      evaluate_list(0, part.pairs, &part);
    });
    if (springs) add_late();
    from = built;
  }
  evaluate_list(from, to, nullptr);
  if (slots.full >= 0)
    error->one(FLERR, "jump/disc: disc {} touches more than the {} others it can remember: contacts are too deep",
               atom->tag[slots.full], slots.number);
}

void PairJumpDisc::evaluate_list(size_t from, size_t to, PairPart *part)
{
  jump::with_law(law.choice, sizes, spin, [&](const auto &slots, auto own_sizes, auto turns) {
    evaluate_list<own_sizes.value, turns.value>(slots, from, to, part);
  });
}

/** Largest overlap of the pairs of this rank at the last force evaluation, m; 0 where none touch. */
double PairJumpDisc::largest_overlap() const
{
  double most = 0.0;
  for (size_t p = 0; p < candidates; p++) {
    const double dx = disc[first[p]].x - disc[second[p]].x, dy = disc[first[p]].y - disc[second[p]].y;
    most = std::max(most, reach_of(first[p], second[p]) - std::sqrt(dx * dx + dy * dy));
  }
  return most;
}
