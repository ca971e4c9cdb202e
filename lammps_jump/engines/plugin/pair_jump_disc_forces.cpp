// SPDX-License-Identifier: GPL-2.0-or-later
/* The forces of pair_style jump/disc, and what is summed over its pairs (what it is: pair_jump_disc.h). */

#include "contact/simd.h"    // before the core: its templates take vectors

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
/** As many numbers as a vector has, from an aligned place. */
inline Lanes &lanes(double *from) { return *reinterpret_cast<Lanes *>(from); }

inline Four apart(const PairJumpDisc::PackedDisc &a, const PairJumpDisc::PackedDisc &b)
{
  return *reinterpret_cast<const Four *>(&a) - *reinterpret_cast<const Four *>(&b);
}
}    // namespace

/** Contacts that are evaluated together. Their forces alone are compiled for each kind of contact. */
struct PairJumpDisc::ContactBatch {
  int n = 0;                                  // of contacts
  bool stays;                                 // some discs are fixed, and have a bulk
  int one[BATCH + 4], two[BATCH + 4];         // their discs
  alignas(64) double between[BATCH][4];       // place and velocity of the first against the second
  alignas(64) double force[BATCH][2];         // on the first
  alignas(64) double spin[2][BATCH], moment[2][BATCH], radius[2][BATCH], bulk[2][BATCH];
  alignas(64) double slide[BATCH], roll[BATCH];
  double *springs[2][BATCH];                  // where the two discs remember them, or null

  template <bool SIZES> void find(const PackedDisc *, const double *, double, const int *, const int *, size_t, size_t);
  template <bool SIZES, bool SPIN, class Law> void evaluate(const Law &, const jump::Numbers<Lanes> &);
};

/** Those of the pairs first[from] second[from] to `to` that touch. */
template <bool SIZES>
inline void PairJumpDisc::ContactBatch::find(const PackedDisc *__restrict at, const double *__restrict radii, double diameter,
                               const int *__restrict first, const int *__restrict second, size_t from, size_t to)
{
  const auto reach = [&](size_t p) { return SIZES ? radii[first[p]] + radii[second[p]] : diameter; };
  const auto apart = [&](size_t p) { return ::apart(at[first[p]], at[second[p]]); };
  int found = 0;
  // without a branch, which would be guessed wrong often; the last ones, and all of them without AVX, one at a time
  size_t p = from;
  for (; jump::HAS_FOUR && p + 4 <= to; p += 4) {
    Four a = apart(p), b = apart(p + 1), c = apart(p + 2), d = apart(p + 3);
    a *= a, b *= b, c *= c, d *= d;
    const Four ab = JUMP_SHUFFLE(a, b, 0, 4, 2, 6) + JUMP_SHUFFLE(a, b, 1, 5, 3, 7);
    const Four cd = JUMP_SHUFFLE(c, d, 0, 4, 2, 6) + JUMP_SHUFFLE(c, d, 1, 5, 3, 7);
    const Four reaches = {reach(p), reach(p + 1), reach(p + 2), reach(p + 3)};
    const int mask = jump::bits(JUMP_SHUFFLE(ab, cd, 0, 1, 4, 5) < reaches * reaches);
    *reinterpret_cast<FourInts *>(one + found) = jump::first_of(four(first + p), mask);
    *reinterpret_cast<FourInts *>(two + found) = jump::first_of(four(second + p), mask);
    found += __builtin_popcount(mask);
  }
  for (; p < to; p++) {
    const Four a = apart(p);
    one[found] = first[p];
    two[found] = second[p];
    found += a[0] * a[0] + a[1] * a[1] < reach(p) * reach(p);
  }
  n = found;
}

/** Forces and moments of the contacts, in whole vectors. */
template <bool SIZES, bool SPIN, class Law>
__attribute__((noinline)) void PairJumpDisc::ContactBatch::evaluate(const Law &rule, const jump::Numbers<Lanes> &of)
{
  constexpr bool SPRINGS = Law::Friction::HAS_HISTORY;
  const int count = n;
  const bool heavy = stays;
  for (int c = 0; c < count; c += LANES) {
    Lanes gap[4];
    jump::deinterleave(between + c, gap);
    jump::Pair<Lanes> pair;
    pair.dx = gap[0];
    pair.dy = gap[1];
    pair.vx = gap[2];
    pair.vy = gap[3];
    pair.apart2 = pair.dx * pair.dx + pair.dy * pair.dy;
    pair.a = SIZES ? lanes(radius[0] + c) : spread(radius[0][0], Lanes{});
    pair.b = SIZES ? lanes(radius[1] + c) : pair.a;
    if constexpr (SIZES) {
      pair.bulk_a = heavy ? lanes(bulk[0] + c) : pair.a;
      pair.bulk_b = heavy ? lanes(bulk[1] + c) : pair.b;
    }
    if constexpr (SPIN) {
      pair.spin_a = lanes(spin[0] + c);
      pair.spin_b = lanes(spin[1] + c);
    }
    jump::Stretch<Lanes> held{};
    if constexpr (SPRINGS) {
      held.slide = lanes(slide + c);
      if constexpr (SPIN) held.roll = lanes(roll + c);
    }
    const auto out = jump::pair_contact<SIZES, SPIN>(rule, of, pair, held);
    jump::rows_of_two(out.fx, out.fy, force + c);
    if constexpr (SPRINGS) {
      lanes(slide + c) = held.slide;
      if constexpr (SPIN) lanes(roll + c) = held.roll;
    }
    if constexpr (SPIN) {
      lanes(moment[0] + c) = out.on_a;
      lanes(moment[1] + c) = out.on_b;
    }
  }
}

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

/** Take the springs of a pair: those of the disc with the larger id, where both have them those of the first. */
template <bool SPIN> inline void PairJumpDisc::recall(ContactBatch &batch, int c, bool both, const PairPart *part)
{
  const int i = batch.one[c], j = batch.two[c];
  const bool larger = tags[i] > tags[j];
  double *const of_one = both || larger ? remembered(i, j, part) : nullptr;
  double *const of_two = j < atom->nlocal && (both || !larger) ? remembered(j, i, part) : nullptr;
  const double *const held = of_one ? of_one : of_two;
  batch.springs[0][c] = of_one;
  batch.springs[1][c] = of_two;
  batch.slide[c] = held ? *held : 0.0;
  if constexpr (SPIN)    // of disc i against disc j
    batch.roll[c] = !held ? 0.0 : of_one ? held[slots.number] : -held[slots.number];
}

/** Take what the forces of a batch need of its discs. */
template <bool SIZES, bool SPIN, bool MEMORY> inline void PairJumpDisc::gather(ContactBatch &batch, const PairPart *part)
{
  const PackedDisc *const __restrict at = disc.data();
  const double *const __restrict omega = spins.data(), *const __restrict own = radii.data(), *const __restrict heavy = bulk.data();
  const int n = batch.n, whole = (n + LANES - 1) / LANES * LANES;
  const double radius = 0.5 * diameter;
  const bool stays = batch.stays, both = MEMORY && ring.is_needed();
  for (int c = 0; c < n; c++) {
    const int i = batch.one[c], j = batch.two[c];
    *reinterpret_cast<Four *>(batch.between[c]) = apart(at[i], at[j]);
    if constexpr (SPIN) {
      batch.spin[0][c] = omega[i];
      batch.spin[1][c] = omega[j];
    }
    if constexpr (SIZES) {
      batch.radius[0][c] = own[i];
      batch.radius[1][c] = own[j];
      if (stays) {
        batch.bulk[0][c] = heavy[i];
        batch.bulk[1][c] = heavy[j];
      }
    }
    if constexpr (MEMORY) recall<SPIN>(batch, c, both, part);
  }
  for (int c = n; c < whole; c++) {    // the rest of the last vector is filled with a contact that nobody reads
    batch.between[c][0] = batch.between[c][1] = radius;
    batch.between[c][2] = batch.between[c][3] = batch.slide[c] = batch.roll[c] = 0.0;
    for (int side = 0; side < 2; side++) {
      batch.spin[side][c] = 0.0;
      batch.radius[side][c] = batch.bulk[side][c] = radius;
    }
  }
}

/** Put the springs of a batch back, as they go on. */
template <bool SPIN> inline void PairJumpDisc::remember(const ContactBatch &batch) const
{
  for (int c = 0; c < batch.n; c++)
    for (int side = 0; side < 2; side++) {
      double *const to = batch.springs[side][c];
      if (!to) continue;
      to[0] = batch.slide[c];
      if constexpr (SPIN) to[slots.number] = side == 0 ? batch.roll[c] : -batch.roll[c];
    }
}

/** Add the forces of a batch to its discs. */
template <bool SPIN, bool MEMORY> inline void PairJumpDisc::scatter(const ContactBatch &batch, PairPart *part)
{
  const int n = batch.n, nlocal = atom->nlocal;
  if (record) {
    for (int c = 0; c < n; c++) note(batch.one[c], batch.two[c], batch.force[c]);
    return;
  }
  if (MEMORY && part) {
    for (int c = 0; c < n; c++)
      add(*part, batch.one[c], batch.two[c], batch.force[c], SPIN ? batch.moment[0][c] : 0.0, SPIN ? batch.moment[1][c] : 0.0);
    return;
  }
  double *const __restrict f = pushes.data();
  double *const __restrict torque = turns.data();
  for (int c = 0; c < n; c++) {
    const int i = batch.one[c], j = batch.two[c];
    const Vec2 push = *reinterpret_cast<const Vec2 *>(batch.force[c]);
    *reinterpret_cast<Vec2 *>(f + 2 * i) += push;
    if constexpr (SPIN) torque[i] += batch.moment[0][c];
    if (j < nlocal) {
      *reinterpret_cast<Vec2 *>(f + 2 * j) -= push;
      if constexpr (SPIN) torque[j] += batch.moment[1][c];
    }
  }
}

/** Forces of the pairs from one place to another in the list, or in a part of it. */
template <bool SIZES, bool SPIN, bool MEMORY> void PairJumpDisc::evaluate_list(size_t from, size_t to, PairPart *part)
{
  const int *const one = part ? part->first.data() : first.data(), *const two = part ? part->second.data() : second.data();
  const jump::Numbers<Lanes> of = jump::numbers_of(law.of, Lanes{});
  ContactBatch batch;
  batch.stays = any_fixed();
  batch.radius[0][0] = 0.5 * diameter;
  for (size_t begin = from; begin < to; begin += BATCH) {
    batch.find<SIZES>(disc.data(), radii.data(), diameter, one, two, begin, std::min(begin + BATCH, to));
    gather<SIZES, SPIN, MEMORY>(batch, part);
    jump::with_slots(law.choice, [&](const auto &rule) {
      using Law = std::decay_t<decltype(rule)>;
      if constexpr (jump::IS_KIND<Law, SPIN> && Law::Friction::HAS_HISTORY == MEMORY) batch.evaluate<SIZES, SPIN>(rule, of);
    });
    if constexpr (MEMORY)
      if (law.choice.time_step > 0.0) remember<SPIN>(batch);
    scatter<SPIN, MEMORY>(batch, part);
  }
}

void PairJumpDisc::evaluate_list(size_t from, size_t to, PairPart *part)
{
  jump::with_kind(law.choice, sizes, spin, [&](auto own_sizes, auto turns) {
    if (springs) evaluate_list<own_sizes.value, turns.value, true>(from, to, part);
    else evaluate_list<own_sizes.value, turns.value, false>(from, to, part);
  });
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
  const int count = pool.size();
  if (count > 1 && !record && from == 0 && to >= built && built >= FEW_PAIRS * (size_t) count) {
    divide(count);
    pool.run((int) parts.size(), [&](int c) {
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
