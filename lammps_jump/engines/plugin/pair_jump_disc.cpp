// SPDX-License-Identifier: GPL-2.0-or-later
/* Settings and checks of pair_style jump/disc (what it is: pair_jump_disc.h). */

#include "pair_jump_disc.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "force.h"
#include "memory.h"
#include "modify.h"
#include "neighbor.h"
#include "update.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <unordered_map>
#include <vector>

using namespace LAMMPS_NS;

PairJumpDisc::PairJumpDisc(LAMMPS *lmp) : Pair(lmp), ring(lmp)
{
  single_enable = 0;
  restartinfo = 0;
  no_virial_fdotr_compute = 1;
  tuner.read(std::getenv("LAMMPS_JUMP_THREADS"));
  pool.resize(tuner.threads());
}

PairJumpDisc::~PairJumpDisc()
{
  if (allocated) {
    memory->destroy(setflag);
    memory->destroy(cutsq);
  }
}

void PairJumpDisc::settings(int narg, char **arg)
{
  if (narg != 1 && !(narg == 4 && strcmp(arg[1], "fixed") == 0))
    error->all(FLERR, "pair_style jump/disc takes the file of a scene, and perhaps fixed FIRST LAST");
  read_scene(arg[0]);
  for (int end = 0; end < 2 && narg > 1; end++) fixed[end] = utils::tnumeric(FLERR, arg[2 + end], false, lmp);
  const jump_state &s = *scene.state;
  sizes = s.radius;
  spin = s.omega;
  springs = s.partner;
  largest = s.diameter;
  mass = sizes ? s.mass * 0.25 * largest * largest : s.mass;
  skin = s.lists->skin;
  if (any_fixed() && !sizes) error->all(FLERR, "pair_style jump/disc: fixed needs discs of sizes of their own");
}

/** Read the file of a scene, on one rank for all. */
void PairJumpDisc::read_scene(const char *name)
{
  std::vector<char> bytes;
  if (comm->me == 0) {
    std::ifstream file(name, std::ios::binary);
    if (!file) error->one(FLERR, "pair_style jump/disc: the file {} of the scene cannot be read", name);
    bytes.assign(std::istreambuf_iterator<char>(file), {});
  }
  bigint size = (bigint) bytes.size();
  MPI_Bcast(&size, 1, MPI_LMP_BIGINT, 0, world);
  bytes.resize(size);
  MPI_Bcast(bytes.data(), (int) size, MPI_BYTE, 0, world);
  if (!scene.take(bytes))
    error->all(FLERR, "pair_style jump/disc: {} is no scene of this version of the plugin: write the script again", name);
  scene.state->pressed = nullptr;    // pressure is asked of the native engine
}

/** Tell the core where the discs are; arrays may have moved. */
void PairJumpDisc::bind()
{
  jump_state &s = *scene.state;
  s.n = atom->nlocal;
  s.ids = ids.data();
  if (sizes) s.radius = radii.data();
  if (spin) {
    s.omega = spins.data();
    s.torque = turns.data();
  }
  s.fixed = any_fixed() ? stays.data() : nullptr;
  if (!springs || !slots) return;
  s.slots = slot_count;
  s.slot_row = 4 * slot_count;
  double *const rows = atom->nlocal > 0 ? (*slots)[0] : nullptr;
  s.partner = reinterpret_cast<int64_t *>(rows);
  s.sigma = rows + slot_count;
  s.spring = rows + 2 * slot_count;
  s.roll = rows + 3 * slot_count;
  if ((int64_t) used.size() < s.n * s.slot_row) used.resize(s.n * s.slot_row + s.n * s.slot_row / 4, 0);
  s.used = used.data();
}

void PairJumpDisc::coeff(int narg, char **arg)
{
  if (narg != 2 || strcmp(arg[0], "*") != 0 || strcmp(arg[1], "*") != 0)
    error->all(FLERR, "pair_coeff of jump/disc takes all types and nothing else: pair_coeff * *");
  const int n = atom->ntypes + 1;
  if (!allocated) {
    memory->create(setflag, n, n, "pair:setflag");
    memory->create(cutsq, n, n, "pair:cutsq");
  }
  allocated = 1;
  std::fill_n(setflag[0], n * n, 1);
  std::fill_n(cutsq[0], n * n, 0.0);
}

void PairJumpDisc::init_style()
{
  if (comm->layout == Comm::LAYOUT_TILED || comm->procgrid[0] != comm->nprocs || domain->yperiodic ||
      force->newton_pair)
    error->all(FLERR, "pair_style jump/disc needs newton off, processors * 1 1 and no periodic y");
  if (!atom->radius_flag || !atom->rmass_flag) error->all(FLERR, "pair_style jump/disc needs atom_style sphere");
  if (modify->get_fix_by_style("^jump/step").empty()) error->all(FLERR, "pair_style jump/disc needs fix jump/step");
  if (neighbor->nex_type || neighbor->nex_group || neighbor->nex_mol || neighbor->includegroup)
    error->all(FLERR, "pair_style jump/disc knows no neigh_modify exclude and no neigh_modify include");
  // no ghosts of LAMMPS' own: their cutoff must not be 0 (a warning), and init_one asks for none
  if (comm->cutghostuser == 0.0) comm->cutghostuser = 1e-6 * largest;
  listed.clear();
  candidates = interior = 0;
}

/** How far from the cuts a disc of another rank can come into touch before LAMMPS reneighbours, m.

    Until LAMMPS looks, a disc moves by half its skin; and on, at most, for the steps between two looks. Its speed then may be
    larger than any now: twice that, and what an overlap of 5 % gives to a disc at rest. */
double PairJumpDisc::halo_cut() const
{
  double most = largest_squared_speed();
  MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_DOUBLE, MPI_MAX, world);
  const double speed = 2.0 * std::sqrt(most) + 0.05 * largest * std::sqrt(2.0 * scene.state->pair.stiffness / mass);
  const int steps = std::max(neighbor->every, neighbor->delay);
  return largest + neighbor->skin + 2.0 * steps * update->dt * speed;
}

/** Called only for a file that holds settings of the style, as earlier versions wrote them. */
void PairJumpDisc::read_restart(FILE *)
{
  error->all(FLERR, "pair_style jump/disc: the restart file is of another version of the plugin: it cannot go on");
}

void PairJumpDisc::reserve(int n)
{
  if ((size_t) n > disc.size()) {
    disc.resize(n + n / 4 + 64);
    pushes.resize(2 * disc.size());
    if (spin) spins.resize(disc.size());
    if (spin) turns.resize(disc.size());
    if (sizes) {
      radii.resize(disc.size());
      inverse_masses.resize(disc.size());
    }
    ids.resize(disc.size());
    if (any_fixed()) stays.resize(disc.size());
    bind();
  }
}

/** Take over the local discs as they are in LAMMPS. */
void PairJumpDisc::pack()
{
  double *const *const x = atom->x, *const *const v = atom->v;
  reserve(atom->nlocal);
  for (int i = 0; i < atom->nlocal; i++) {
    disc[i] = {x[i][0], x[i][1], v[i][0], v[i][1]};
    if (sizes) pack_size(i);
    if (spin) spins[i] = atom->omega[i][2];
    ids[i] = atom->tag[i];
  }
  std::fill_n(pushes.begin(), 2 * (size_t) atom->nlocal, 0.0);
  if (spin) std::fill_n(turns.begin(), atom->nlocal, 0.0);
}

/** Let LAMMPS leave its arrays of forces and torques as they are in this step: nothing reads them.

    LAMMPS then clears only the forces of a group. Until the forces are evaluated this group has no disc. */
void PairJumpDisc::keep_uncleared()
{
  first_group = atom->nfirst;
  atom->nfirst = 0;
  neighbor->includegroup = 1;
}

/** Add the forces of this step to those in LAMMPS' array, which it has cleared at the begin of the step. */
void PairJumpDisc::hand_over_forces()
{
  for (int i = 0; i < atom->nlocal; i++) {
    atom->f[i][0] += pushes[2 * i];
    atom->f[i][1] += pushes[2 * i + 1];
    if (spin) atom->torque[i][2] += turns[i];
  }
}

/** Take the forces of this step from LAMMPS' array, to which other fixes may have added theirs. */
void PairJumpDisc::take_forces()
{
  for (int i = 0; i < atom->nlocal; i++) {
    pushes[2 * i] = atom->f[i][0];
    pushes[2 * i + 1] = atom->f[i][1];
    if (spin) turns[i] = atom->torque[i][2];
  }
}

void PairJumpDisc::pack_size(int i)
{
  radii[i] = atom->radius[i];
  inverse_masses[i] = is_fixed(i) ? 0.0 : 1.0 / atom->rmass[i];
  if (any_fixed()) stays[i] = is_fixed(i);
}

bool PairJumpDisc::is_fixed(int i) const
{
  return atom->tag[i] >= fixed[0] && atom->tag[i] <= fixed[1];
}

/** Refuse discs that the settings do not describe when some may have come in. */
void PairJumpDisc::check_discs(int from, int to)
{
  const double slack = 1e-10;
  const jump_state &s = *scene.state;
  for (int i = from; i < to; i++) {
    const double radius = atom->radius[i], m = atom->rmass[i], right = sizes ? s.mass * radius * radius : s.mass;
    const bool fits = 2.0 * radius < (1.0 + slack) * largest && (sizes || 2.0 * radius > (1.0 - slack) * largest);
    if (!fits || !(radius > 0.0) || !(std::fabs(m - right) < slack * right))
      error->one(FLERR, "jump/disc: disc {} has diameter {} and mass {}, the scene says {}{}, and mass {} at this diameter",
                 atom->tag[i], 2.0 * radius, m, sizes ? "up to " : "", largest, right);
  }
}

/** Both discs of a contact remember it, also where a part of the run was on one rank: there the larger id alone does. */
void PairJumpDisc::share_memory()
{
  constexpr int WORDS = 4;    // a disc, its partner, tangential and rolling spring as the disc has to remember them
  jump_state &s = *scene.state;
  std::unordered_map<int64_t, int> local;
  for (int i = 0; i < atom->nlocal; i++) local[ids[i]] = i;
  const auto put = [&](const double *row) {
    const auto found = local.find((int64_t) row[0]);
    if (found == local.end()) return false;
    jump::DiscHistory own(s, found->second);
    const auto partner = (int64_t) row[1];
    if (jump::held(own, partner, 0.0, 0.0, 0.0) != jump::FULL) return true;
    const int slot = jump::slot_of(own, partner, 0.0, 0.0, 0.0);
    if (slot == jump::FULL) return true;    // compute() tells
    s.spring[own.first + slot] = row[2];
    s.roll[own.first + slot] = row[3];
    s.used[own.first + slot] = 0;    // no mark of this
    return true;
  };
  std::vector<double> away, all;
  for (int i = 0; i < atom->nlocal; i++)
    for (int64_t at = i * s.slot_row, last = at + s.slots; at < last; at++) {
      const double row[WORDS] = {(double) s.partner[at], (double) ids[i], s.spring[at], -s.roll[at]};
      if (s.partner[at] > 0 && !put(row)) away.insert(away.end(), row, row + WORDS);
    }
  const int own = (int) away.size();
  std::vector<int> sizes(comm->nprocs), places(comm->nprocs, 0);
  MPI_Allgather(&own, 1, MPI_INT, sizes.data(), 1, MPI_INT, world);
  for (int rank = 1; rank < comm->nprocs; rank++) places[rank] = places[rank - 1] + sizes[rank - 1];
  all.resize(places.back() + sizes.back());
  MPI_Allgatherv(away.data(), own, MPI_DOUBLE, all.data(), sizes.data(), places.data(), MPI_DOUBLE, world);
  for (size_t n = 0; n < all.size(); n += WORDS) put(&all[n]);
}
