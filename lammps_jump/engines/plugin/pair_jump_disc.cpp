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
#include <map>
#include <set>
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
  std::map<std::string, double *> numbers = {
      {"k", &input_law.stiffness}, {"gamma", &input_law.damping}, {"gammat", &input_law.tangential}, {"mu", &input_law.friction},
      {"smooth", &input_law.touch}, {"springs", &input_law.spring_ratio}, {"mass", &mass}, {"diameter", &diameter}, {"skin", &skin}};
  const std::set<const double *> worded = {
      &input_law.stiffness, &input_law.damping, &input_law.tangential, &input_law.friction, &input_law.sign_ramp, &input_law.touch, &input_law.spring_ratio,
      &input_law.spring_damping, &input_law.rolling, &input_law.rolling_damping, &input_law.rolling_friction};
#define JUMP_WORD(name) if (!worded.count(&input_law.name)) numbers.emplace(#name, &input_law.name);    // others go by their names
  JUMP_LAW(JUMP_WORD)
#undef JUMP_WORD
  auto value = [&](int at) -> double {
    if (at >= narg) error->all(FLERR, "pair_style jump/disc: {} needs a value", arg[at - 1]);
    return utils::numeric(FLERR, arg[at], false, lmp);
  };
  for (int a = 0; a < narg; a += 2) {
    const std::string key = arg[a], name = a + 1 < narg ? arg[a + 1] : "";
    if (key == "law") {
      if (name != "viscous" && name != "sign" && name != "history")
        error->all(FLERR, "pair_style jump/disc: law is viscous, sign or history, not '{}'", name);
      sign = name == "sign";
      springs = name == "history";
    } else if (key == "rolling") {
      input_law.rolling = value(a + 1);
      input_law.rolling_damping = value(a + 2);
      input_law.rolling_friction = value(a + 3);
      a += 2;
    } else if (key == "fixed") {
      fixed[0] = (tagint) value(a + 1);
      fixed[1] = (tagint) value(a++ + 2);
    } else if (key == "spin") {
      spin = utils::logical(FLERR, name, false, lmp);
    } else if (key == "sizes") {
      sizes = true;
      smallest = value(a + 1);
      largest = value(a++ + 2);
    } else if (auto number = numbers.find(key); number != numbers.end()) {
      *number->second = value(a + 1);
      if (key == "smooth" && !(input_law.touch > 0.0))
        error->all(FLERR, "pair_style jump/disc: the width of a smooth touch must be above 0");
    } else {
      error->all(FLERR,
                 "pair_style jump/disc: unknown keyword '{}'; there are law, k, gamma, gammat, mu, mass, diameter, skin, "
                 "smooth, spin, sizes, springs, rolling, fixed and further numbers of core/contact/law.h", key);
    }
  }
  require_sound_settings();
  if (!sizes) smallest = largest = diameter;
  law = {input_law, 0.5 * mass, sizes ? jump::pair_size(0.5 * diameter, 0.5 * diameter) : 1.0, sign, springs};
}

/** Refuse numbers of the words that do not go together. */
void PairJumpDisc::require_sound_settings() const
{
  if (!(input_law.stiffness > 0.0) || !(mass > 0.0) || !(diameter > 0.0) || !(skin > 0.0))
    error->all(FLERR, "pair_style jump/disc needs k, mass, diameter and skin, and they must be above 0");
#define JUMP_CHECK(name) if (input_law.name < 0.0) error->all(FLERR, "pair_style jump/disc: " #name " must not be negative");
  JUMP_LAW(JUMP_CHECK)
#undef JUMP_CHECK
  if (sizes && !(0.0 < smallest && smallest <= largest))
    error->all(FLERR, "pair_style jump/disc: sizes are the smallest and the largest diameter, both above 0");
  if (any_fixed() && !sizes) error->all(FLERR, "pair_style jump/disc: fixed needs sizes");
  if (springs && input_law.touch > 0.0) error->all(FLERR, "pair_style jump/disc: the law history has no smooth touch");
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
  if (comm->cutghostuser == 0.0) comm->cutghostuser = 1e-6 * diameter;
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
  const double speed = 2.0 * std::sqrt(most) + 0.05 * diameter * std::sqrt(2.0 * input_law.stiffness / mass);
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
    if (springs) tags.resize(disc.size());
    if (any_fixed()) bulk.resize(disc.size());
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
    if (springs) tags[i] = (double) atom->tag[i];
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
  if (any_fixed()) bulk[i] = is_fixed(i) ? jump::HUGE_RADIUS : radii[i];
}

bool PairJumpDisc::is_fixed(int i) const
{
  return atom->tag[i] >= fixed[0] && atom->tag[i] <= fixed[1];
}

/** Refuse discs that the settings do not describe when some may have come in. */
void PairJumpDisc::check_discs(int from, int to)
{
  const double slack = 1e-10, density = mass / (diameter * diameter);
  for (int i = from; i < to; i++) {
    const double d = 2.0 * atom->radius[i], m = atom->rmass[i], right = density * d * d;
    if (!(d > (1.0 - slack) * smallest && d < (1.0 + slack) * largest) || !(std::fabs(m - right) < slack * right))
      error->one(FLERR,
                 "jump/disc: disc {} has diameter {} and mass {}, the pair style says {} to {}, and mass {} at {}",
                 atom->tag[i], d, m, smallest, largest, mass, diameter);
  }
}

/** Both discs of a contact remember it, also where a part of the run was on one rank: there the larger id alone does. */
void PairJumpDisc::share_memory()
{
  constexpr int WORDS = 4;    // a disc, its partner, tangential and rolling spring as the disc has to remember them
  std::unordered_map<double, int> local;
  for (int i = 0; i < atom->nlocal; i++) local[tags[i]] = i;
  const auto put = [&](const double *row) {
    const auto found = local.find(row[0]);
    if (found == local.end()) return false;
    const int i = found->second;
    if (slots.of(i, row[1]) != jump::FULL) return true;
    slots.grows = true;
    const int slot = slots.of(i, row[1]);
    slots.grows = false;
    if (slot == jump::FULL) return true;    // compute() tells
    *slots.spring(i, slot) = row[2];
    *slots.roll(i, slot) = row[3];
    return true;
  };
  std::vector<double> away, all;
  for (int i = 0; i < atom->nlocal; i++)
    for (int s = 0; s < slots.number; s++) {
      const double partner = (*slots.rows)[i][s];
      const double row[WORDS] = {partner, tags[i], *slots.spring(i, s), -*slots.roll(i, s)};
      if (partner > 0.0 && !put(row)) away.insert(away.end(), row, row + WORDS);
    }
  const int own = (int) away.size();
  std::vector<int> sizes(comm->nprocs), places(comm->nprocs, 0);
  MPI_Allgather(&own, 1, MPI_INT, sizes.data(), 1, MPI_INT, world);
  for (int rank = 1; rank < comm->nprocs; rank++) places[rank] = places[rank - 1] + sizes[rank - 1];
  all.resize(places.back() + sizes.back());
  MPI_Allgatherv(away.data(), own, MPI_DOUBLE, all.data(), sizes.data(), places.data(), MPI_DOUBLE, world);
  for (size_t n = 0; n < all.size(); n += WORDS) put(&all[n]);
  slots.begin(atom->nlocal);    // no mark of this
}
