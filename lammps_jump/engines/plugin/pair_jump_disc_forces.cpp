// SPDX-License-Identifier: GPL-2.0-or-later
/* A step of pair_style jump/disc (what it is: pair_jump_disc.h): discs from LAMMPS and back, and the forces of the core. */

#include "contact/no_contraction.h"

#include "contact/simd.h"    // before the core: its templates take vectors

#include "pair_jump_disc.h"

#include "atom.h"
#include "comm.h"
#include "error.h"
#include "modify.h"
#include "neighbor.h"
#include "update.h"

#include <algorithm>
#include <cmath>

using namespace LAMMPS_NS;
using jump::Two;

double PairJumpDisc::largest_squared_speed()
{
  return jump::fastest(rows(), 0, state().n);
}

void PairJumpDisc::find_largest_speed()
{
  double most = largest_squared_speed();
  if (comm->nprocs > 1) MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_DOUBLE, MPI_MAX, world);
  largest_speed = std::sqrt(most);
}

/** Put the discs into the arrays of the state, those of other ranks too, and what they remember into their slots. */
void PairJumpDisc::store()
{
  store_memory();
  jump_state &s = state();
  partition.each([&](jump::ThreadPart &part) { jump::store(s, part.begin, part.end, part.rows()); });
  for (int64_t i = s.n; i < s.n + ring.count(); i++) {
    const double *const row = rows()[i];
    s.x[i] = row[0], s.y[i] = row[1], s.vx[i] = row[2], s.vy[i] = row[3];
  }
}

/** What a new list is made from: places, and on ranks the forces that there are. */
void PairJumpDisc::store_places()
{
  if (ring.is_needed()) return store();
  store_memory();
  jump_state &s = state();
  const auto *const row = rows();
  for (int64_t k = 0; k < s.n; k++) s.x[k] = row[k][0], s.y[k] = row[k][1];
}

/** Put what pairs remember into the slots of the discs. */
void PairJumpDisc::store_memory()
{
  jump::PairMemory &memory = partition.memory;
  if (memory.goes_on) partition.each([&](jump::ThreadPart &part) { memory.end(state(), part); });
  memory.goes_on = false;
}

/** Divide the discs among the threads that there are now; the forces of those from `from` on begin. */
void PairJumpDisc::load(int64_t from)
{
  jump_state &s = state();
  partition.both_remember = ring.is_needed();
  partition.divide(s);
  partition.make_room_for(s.n, ring.count());
  const bool begins = packed || !ring.is_needed();    // contacts of local discs come first on ranks
  partition.each([&](jump::ThreadPart &part) { jump::begin_halves(s, std::max(part.begin, from), part.end, part.rows(), begins); });
  packed = false;
}

/** Take a disc of LAMMPS as the next one. Its force begins with its weight (`load`). */
void PairJumpDisc::take_disc(int i)
{
  jump_state &s = state();
  const int64_t k = s.n++;
  table[0][k] = i;
  s.ids[k] = atom->tag[i];
  double *const row = rows()[k];
  for (int c = 0; c < 2; c++) row[c] = atom->x[i][c], row[2 + c] = atom->v[i][c];
  s.x[k] = row[0], s.y[k] = row[1];
  if (s.radius) s.radius[k] = atom->radius[i];
  if (s.fixed) s.fixed[k] = is_fixed(atom->tag[i]);
  if (s.omega) {
    s.omega[k] = atom->omega[i][2];
    s.torque[k] = 0.0;
  }
}

/** Take over the local discs as they are in LAMMPS. */
void PairJumpDisc::pack()
{
  jump_state &s = state();
  put_slots();
  s.n = s.rows = s.sorted = 0;
  reserve(atom->nlocal);
  partition.make_room_for(atom->nlocal, ring.count());
  for (int i = 0; i < atom->nlocal; i++) take_disc(i);
  take_slots();
  packed = true;
}

/** Take places and velocities from LAMMPS, which has the same discs. */
void PairJumpDisc::take_motion()
{
  jump_state &s = state();
  if (s.n == 0) return;
  const double *const x = atom->x[0], *const v = atom->v[0];
  for (int64_t k = 0; k < s.n; k++) {
    const int64_t i = 3 * origin(k);
    Two *const row = reinterpret_cast<Two *>(rows()[k]);
    row[0] = *reinterpret_cast<const Two *>(x + i);
    row[1] = *reinterpret_cast<const Two *>(v + i);
    if (s.omega) s.omega[k] = atom->omega[0][i + 2];
  }
}

/** Let LAMMPS see the places, and the velocities of the half step. */
void PairJumpDisc::put_motion()
{
  const jump_state &s = state();
  if (s.n == 0) return;
  double *const __restrict x = atom->x[0], *const __restrict v = atom->v[0];
  const int64_t *const __restrict at = table[0], n = s.n;
  const Two *const __restrict row = reinterpret_cast<const Two *>(rows());
  for (int64_t k = 0; k < n; k++) {
    *reinterpret_cast<Two *>(x + 3 * at[k]) = row[2 * k];
    *reinterpret_cast<Two *>(v + 3 * at[k]) = row[2 * k + 1];
  }
  for (int64_t k = 0; s.omega && k < n; k++) atom->omega[0][3 * at[k] + 2] = s.omega[k];
}

/** Let LAMMPS see the places, and the velocities of the step. */
void PairJumpDisc::put_motion_of_step()
{
  const jump_state &s = state();
  if (s.n == 0) return;
  double *const __restrict x = atom->x[0], *const __restrict v = atom->v[0];
  for (int64_t k = 0; k < s.n; k++) {
    const int64_t i = 3 * origin(k);
    const double *const force = partition.parts[0].forces[k];
    const Two *const row = reinterpret_cast<const Two *>(rows()[k]);
    *reinterpret_cast<Two *>(x + i) = row[0];
    *reinterpret_cast<Two *>(v + i) = row[1] + force[jump::HALF_KICK] * *reinterpret_cast<const Two *>(force);
  }
  for (int64_t k = 0; s.omega && k < s.n; k++) atom->omega[0][3 * origin(k) + 2] = jump::AtStep(s, k).spin;
}

/** Let LAMMPS leave its arrays of forces and torques as they are in this step: nothing reads them.

    LAMMPS then clears only the forces of a group. Until the forces are evaluated this group has no disc. */
void PairJumpDisc::keep_uncleared()
{
  first_group = atom->nfirst;
  atom->nfirst = 0;
  neighbor->includegroup = 1;
}

/** Add the forces of this step without the weight to those in LAMMPS' array, which it has cleared at the begin of the step; the
    state keeps what is added. */
void PairJumpDisc::hand_over_forces()
{
  jump_state &s = state();
  for (int64_t k = 0; k < s.n; k++) {
    if (jump::is_fixed(s, k)) continue;
    const int64_t i = origin(k);
    const double square = s.radius ? s.radius[k] * s.radius[k] : 1.0, *const force = partition.parts[0].forces[k];
    atom->f[i][0] += s.fx[k] = force[0] - s.weight_x * square;
    atom->f[i][1] += s.fy[k] = force[1] - s.weight_y * square;
    if (s.omega) atom->torque[i][2] += s.torque[k];
  }
}

/** Take what other fixes have added to the forces of this step in LAMMPS' array. */
void PairJumpDisc::take_forces()
{
  const jump_state &s = state();
  for (int64_t k = 0; k < s.n; k++) {
    if (jump::is_fixed(s, k)) continue;
    const int64_t i = origin(k);
    double *const force = partition.parts[0].forces[k];
    force[0] += atom->f[i][0] - s.fx[k];
    force[1] += atom->f[i][1] - s.fy[k];
    if (s.omega) s.torque[k] = atom->torque[i][2];
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
  // fix jump/step has moved the discs; a reneighbouring may have given them other indices since
  const bool fresh = neighbor->ago == 0 || moved_by_others(), stale = fresh && take_discs();
  if (stale) build_list();
  if (ranks) fresh ? ring.rebuild(*this, halo_cut()) : ring.start(*this);
  if (state().pair.sign_ramp > 0.0) find_largest_speed();
  if (state().partner) {
    jump_state &s = state();
    if (ranks && update->setupflag) share_memory();
    s.memory_step = update->setupflag ? 0.0 : update->dt;
    if (s.corners) s.corners->memory_step = s.memory_step;
  }
  travel(moved_here);
  const bool early = ranks && !fresh && !worn(moved_here);    // contacts of local discs, while the others travel
  if (early) {
    begin_memory();
    forces(jump::SORTED_ROWS);
  }
  if (ranks && !fresh) ring.finish(*this);
  widen_range();
  travel(moved);
  if (!stale && worn(moved)) {
    store_places();
    build_list();
    list_across();
  } else if (fresh) {
    list_across();
  }
  begin_memory();
  forces(early ? jump::ROWS_BEHIND : jump::ALL_ROWS);
}

/** Take what pairs remember out of the slots, where it is there. */
void PairJumpDisc::begin_memory()
{
  const jump_state &s = state();
  if (!s.partner || (partition.memory.goes_on && remembers_list)) return;
  partition.memory.begin(s, partition);
  remembers_list = slots_are_old = walls_unseen = true;
}

void PairJumpDisc::forces(jump::ListRows which)
{
  jump_state &s = state();
  const double sign = slope();
  if (s.partner && partition.parts.size() > 1 && which != jump::ROWS_BEHIND)
    partition.each([&](jump::ThreadPart &part) { jump::borrow(s, part); });
  partition.each([&](jump::ThreadPart &part) { jump::pair_forces<jump::ForcesAlone>(s, sign, part, which); });
  if (s.partner && *s.full)
    error->one(FLERR, "jump/disc: disc {} touches more than the {} others it can remember: contacts are too deep", *s.full, s.slots);
}

/** Take the others' velocities into the range of this step. */
void PairJumpDisc::widen_range()
{
  for (int64_t i = state().n; i < state().n + ring.count(); i++) {
    const double *const row = rows()[i];
    range.widen({{row[2], row[3]}, {row[2], row[3]}});
  }
}

/** Whether the discs may be where fix jump/step did not move them: before a run, or by fixes that act after it. */
bool PairJumpDisc::moved_by_others() const
{
  return update->setupflag || modify->n_post_integrate > 0;
}

/** Add this step to a bound of the way of the discs against one another. */
void PairJumpDisc::travel(double *way) const
{
  for (int c = 0; c < 2; c++) way[c] += update->dt * std::max(range.hi[c] - range.lo[c], 0.0);
}

/** Whether pairs may have come into reach that the list does not hold. */
bool PairJumpDisc::worn(const double *way) const
{
  return !(way[0] * way[0] + way[1] * way[1] < skin * skin);
}
