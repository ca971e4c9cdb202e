// SPDX-License-Identifier: GPL-2.0-or-later
/* The forces of pair_style jump/disc, and what is summed over its pairs (what it is: pair_jump_disc.h). */

#include "contact/batch.h"    // before the core: its templates take vectors

#include "pair_jump_disc.h"

#include "atom.h"
#include "comm.h"
#include "error.h"
#include "neighbor.h"
#include "update.h"

#include <algorithm>

using namespace LAMMPS_NS;
using jump::Four;
using jump::Lanes;

namespace {
typedef double Vec2 __attribute__((vector_size(16), aligned(8), may_alias));
constexpr size_t FEW_PAIRS = 512;    // for a thread of its own
inline Four apart(const PairJumpDisc::PackedDisc &a, const PairJumpDisc::PackedDisc &b)
{
  return *reinterpret_cast<const Four *>(&a) - *reinterpret_cast<const Four *>(&b);
}
}    // namespace

/** Contacts that are evaluated together. Their forces alone are compiled for each kind of contact. */
struct PairJumpDisc::PairBatch : jump::ContactBatch<BATCH> {
  bool heavy;                              // some discs are fixed, and have a bulk
  alignas(64) double force[BATCH][2];      // on the first
  int64_t slot[2][BATCH];                  // where the two discs remember it, or FULL

  /** Forces and moments of the contacts, in whole vectors; `usual` is the radius of equal discs, m. */
  template <bool SIZES, bool SPIN, class Law>
  __attribute__((noinline)) void forces(const Law &rule, const jump::Numbers<Lanes> &of, double usual)
  {
    evaluate<SIZES, SPIN>(rule, of, heavy, usual, [this](int c, const auto &out) { jump::rows_of_two(out.fx, out.fy, force + c); });
  }
};

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
}

/** Where disc i remembers its contact with disc j among the springs; FULL: nowhere. */
int64_t PairJumpDisc::remembered(int i, int j, const PairPart *part)
{
  const bool shared = part && beside[i];
  auto &lock = locks[i % LOCKS];
  if (shared)
    while (lock.test_and_set(std::memory_order_acquire)) {}    // another thread is in the slots of this disc, or one like it
  jump::ContactHistory of(*scene.state, i);
  of.find(ids[j], 0.0, jump::NO_END, 0.0);
  if (shared) lock.clear(std::memory_order_release);
  return of.place();
}

/** A row of a contact of two discs; of one across a cut or seam, which is listed twice, the larger id has it. */
void PairJumpDisc::note(int i, int j, const double *push)
{
  const bool across = j >= atom->nlocal;
  if (across && ids[i] < ids[j]) return;
  const auto &a = disc[i], &b = disc[j];
  const double dx = a.x - b.x, dy = a.y - b.y, r = std::sqrt(dx * dx + dy * dy), overlap = reach_of(i, j) - r;
  const double way = jump::way_to_middle(radius_of(i), overlap) / r;
  record->push_back({(int32_t) ids[i], (int32_t) ids[j], (float) (a.x - way * dx), (float) (a.y - way * dy),
                     (float) push[0], (float) push[1], NAN});
}

/** Contacts of the pairs of this rank, with the forces of the last evaluation. */
void PairJumpDisc::list_contacts(std::vector<jump::ContactRow> &rows)
{
  const double goes_on = scene.state->memory_step;
  scene.state->memory_step = 0.0;
  record = &rows;
  evaluate(0, candidates);
  record = nullptr;
  scene.state->memory_step = goes_on;
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
    if (any_fixed()) stays[to] = stays[from];
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
template <bool SPIN> inline void PairJumpDisc::recall(PairBatch &batch, int c, bool both, const PairPart *part)
{
  const int i = batch.one[c], j = batch.two[c];
  const bool larger = ids[i] > ids[j];
  const int64_t of_one = both || larger ? remembered(i, j, part) : jump::FULL;
  const int64_t of_two = j < atom->nlocal && (both || !larger) ? remembered(j, i, part) : jump::FULL;
  const int64_t held = of_one != jump::FULL ? of_one : of_two;
  const jump_state &s = *scene.state;
  batch.slot[0][c] = of_one;
  batch.slot[1][c] = of_two;
  batch.slide[c] = held == jump::FULL ? 0.0 : s.spring[held];
  if constexpr (SPIN)    // of disc i against disc j
    batch.roll[c] = held == jump::FULL ? 0.0 : of_one != jump::FULL ? s.roll[held] : -s.roll[held];
}

/** Take what the forces of a batch need of its discs. */
template <bool SIZES, bool SPIN, bool MEMORY> inline void PairJumpDisc::gather(PairBatch &batch, const PairPart *part)
{
  const PackedDisc *const __restrict at = disc.data();
  const double *const __restrict omega = spins.data(), *const __restrict own = radii.data();
  const int n = batch.n;
  const bool heavy = batch.heavy, both = MEMORY && ring.is_needed();
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
      if (heavy) {
        batch.bulk[0][c] = stays[i] ? jump::HUGE_RADIUS : own[i];
        batch.bulk[1][c] = stays[j] ? jump::HUGE_RADIUS : own[j];
      }
    }
    if constexpr (MEMORY) recall<SPIN>(batch, c, both, part);
  }
  batch.fill(0.5 * largest);
}

/** Put the springs of a batch back, as they go on. */
template <bool SPIN> inline void PairJumpDisc::remember(const PairBatch &batch)
{
  jump_state &s = *scene.state;
  for (int c = 0; c < batch.n; c++)
    for (int side = 0; side < 2; side++) {
      const int64_t to = batch.slot[side][c];
      if (to == jump::FULL) continue;
      s.spring[to] = batch.slide[c];
      if constexpr (SPIN) s.roll[to] = side == 0 ? batch.roll[c] : -batch.roll[c];
    }
}

/** Add the forces of a batch to its discs. */
template <bool SPIN, bool MEMORY> inline void PairJumpDisc::scatter(const PairBatch &batch, PairPart *part)
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
  const jump::Numbers<Lanes> of = jump::numbers_of(scene.state->pair, Lanes{});
  const jump::Choice choice = jump::choice_of(*scene.state, slope());
  PairBatch batch;
  batch.heavy = any_fixed();
  for (size_t begin = from; begin < to; begin += BATCH) {
    batch.find<SIZES>(reinterpret_cast<const double (*)[4]>(disc.data()), radii.data(), largest, one, two, begin,
                      std::min(begin + BATCH, to));
    gather<SIZES, SPIN, MEMORY>(batch, part);
    jump::with_slots(choice, [&](const auto &rule) {
      using Law = std::decay_t<decltype(rule)>;
      if constexpr (jump::IS_KIND<Law, SPIN> && Law::Friction::HAS_HISTORY == MEMORY) batch.forces<SIZES, SPIN>(rule, of, 0.5 * largest);
    });
    if constexpr (MEMORY)
      if (goes_on()) remember<SPIN>(batch);
    scatter<SPIN, MEMORY>(batch, part);
  }
}

void PairJumpDisc::evaluate_list(size_t from, size_t to, PairPart *part)
{
  jump::with_kind(jump::choice_of(*scene.state, slope()), sizes, spin, [&](auto own_sizes, auto turns) {
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
  bind();
  if (scene.state->pair.sign_ramp > 0.0) find_largest_speed();
  if (springs) {
    if (ranks && update->setupflag) share_memory();
    jump_state &s = *scene.state;
    s.memory_step = update->setupflag ? 0.0 : update->dt;
    if (s.corners) s.corners->memory_step = s.memory_step;
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
  if (springs && *scene.state->full)
    error->one(FLERR, "jump/disc: disc {} touches more than the {} others it can remember: contacts are too deep",
               *scene.state->full, slot_count);
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
