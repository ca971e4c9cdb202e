// SPDX-License-Identifier: GPL-2.0-or-later
/* Settings, checks and restart files of pair_style jump/disc (what it is: pair_jump_disc.h). */

#include "pair_jump_disc.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "force.h"
#include "memory.h"
#include "neighbor.h"
#include "update.h"

#include <algorithm>
#include <map>
#include <set>

using namespace LAMMPS_NS;
using jump::Friction;
using jump::Touch;

namespace {
constexpr int RESTART_FORM = 0x6a640003;    // changes with what the restart file holds
}    // namespace

PairJumpDisc::PairJumpDisc(LAMMPS *lmp) : Pair(lmp), ring(lmp)
{
  single_enable = 0;
  restartinfo = 1;
  writedata = 0;
  no_virial_fdotr_compute = 0;
  finitecutflag = 0;
}

PairJumpDisc::~PairJumpDisc()
{
  if (allocated) {
    memory->destroy(setflag);
    memory->destroy(cutsq);
  }
}

void PairJumpDisc::allocate()
{
  allocated = 1;
  const int n = atom->ntypes + 1;
  memory->create(setflag, n, n, "pair:setflag");
  memory->create(cutsq, n, n, "pair:cutsq");
  std::fill_n(setflag[0], n * n, 0);
  std::fill_n(cutsq[0], n * n, 0.0);
}

void PairJumpDisc::settings(int narg, char **arg)
{
  const std::map<std::string, double *> numbers = {{"k", &k}, {"gamma", &gamma}, {"gammat", &gamma_t}, {"mu", &mu},
                                                   {"mass", &mass}, {"diameter", &diameter}, {"skin", &skin}};
  const std::map<std::string, int *> flags = {{"spin", &spin}, {"ledger", &ledger}, {"halo", &halo}};
  std::set<std::string> seen;
  auto value = [&](int at) -> double {
    if (at >= narg) error->all(FLERR, "pair_style jump/disc: {} needs a value", arg[at - 1]);
    return utils::numeric(FLERR, arg[at], false, lmp);
  };
  for (int a = 0; a < narg; a += 2) {
    const std::string key = arg[a], name = a + 1 < narg ? arg[a + 1] : "";
    if (key == "law") {
      if (name != "hooke" && name != "sign")
        error->all(FLERR, "pair_style jump/disc: law is hooke or sign, not '{}'", name);
      sign = name == "sign";
    } else if (key == "touch") {
      if (name != "sharp" && name != "smooth")
        error->all(FLERR, "pair_style jump/disc: touch is sharp or smooth S, not '{}'", name);
      smooth = name == "smooth";
      if (smooth) width = value(a++ + 2);
    } else if (key == "dashpot") {
      if (name != "even") error->all(FLERR, "pair_style jump/disc: dashpot is even, not '{}'", name);
    } else if (key == "sizes") {
      sizes = 1;
      smallest = value(a + 1);
      largest = value(a++ + 2);
    } else if (auto number = numbers.find(key); number != numbers.end()) {
      *number->second = value(a + 1);
      seen.insert(key);
    } else if (auto flag = flags.find(key); flag != flags.end()) {
      if (name.empty()) error->all(FLERR, "pair_style jump/disc: {} needs yes or no", key);
      *flag->second = utils::logical(FLERR, name, false, lmp);
    } else {
      error->all(FLERR, "pair_style jump/disc: unknown keyword '{}'", key);
    }
  }
  if (seen.count("skin") && !(skin > 0.0)) error->all(FLERR, "pair_style jump/disc: skin must be above 0");
  if (!seen.count("k") || !seen.count("mass") || !seen.count("diameter"))
    error->all(FLERR, "pair_style jump/disc needs k, mass and diameter");
  if (!(k > 0.0) || !(mass > 0.0) || !(diameter > 0.0))
    error->all(FLERR, "pair_style jump/disc: k, mass and diameter must be above 0");
  if (gamma < 0.0 || gamma_t < 0.0 || mu < 0.0)
    error->all(FLERR, "pair_style jump/disc: gamma, gammat and mu must not be negative");
  if (sizes && !(0.0 < smallest && smallest <= largest))
    error->all(FLERR, "pair_style jump/disc: sizes are the smallest and the largest diameter, both above 0");
  if (smooth && !(width > 0.0)) error->all(FLERR, "pair_style jump/disc: the width of a smooth touch must be above 0");
  choose();
}

/** The branch of the kernel that the settings ask for. */
void PairJumpDisc::choose()
{
  friction = jump::friction_of(mu, gamma_t, sign, spin);
  touch = smooth ? Touch::SMOOTH : Touch::SHARP;
  law = jump::make_law(k, gamma, gamma_t, mu, mass * mass / (mass + mass), 0.5 * diameter + 0.5 * diameter, width);
  if (!(skin > 0.0)) skin = 0.3 * diameter;
  if (!sizes) smallest = largest = diameter;
}

void PairJumpDisc::coeff(int narg, char **arg)
{
  if (narg != 2) error->all(FLERR, "pair_coeff of jump/disc takes types only: pair_coeff * *");
  if (!allocated) allocate();
  int ilo, ihi, jlo, jhi;
  utils::bounds(FLERR, arg[0], 1, atom->ntypes, ilo, ihi, error);
  utils::bounds(FLERR, arg[1], 1, atom->ntypes, jlo, jhi, error);
  for (int i = ilo; i <= ihi; i++)
    for (int j = MAX(jlo, i); j <= jhi; j++) setflag[i][j] = 1;
}

void PairJumpDisc::init_style()
{
  if (uses_halo()) {
    if (comm->layout == Comm::LAYOUT_TILED || comm->procgrid[0] != comm->nprocs || domain->xperiodic ||
        domain->yperiodic || force->newton_pair)
      error->all(FLERR, "pair_style jump/disc halo yes needs processors * 1 1, newton off and no periodic x or y");
    // no ghosts of LAMMPS' own: their cutoff must not be 0 (a warning), and init_one asks for none
    if (comm->cutghostuser == 0.0) comm->cutghostuser = 1e-6 * diameter;
  } else if (comm->ghost_velocity == 0 && comm->nprocs > 1)
    error->all(FLERR, "pair_style jump/disc needs comm_modify vel yes on more than one rank");
  if (sizes && (!atom->radius_flag || !atom->rmass_flag))
    error->all(FLERR, "pair_style jump/disc sizes needs atom_style sphere");
  if (sizes && (domain->xperiodic || domain->yperiodic || (comm->nprocs > 1 && !halo)))
    error->all(FLERR, "pair_style jump/disc sizes needs halo yes on more than one rank, and no periodic x or y");
  if (spin && !atom->omega_flag) error->all(FLERR, "pair_style jump/disc spin yes needs atom_style sphere");
  if (spin && !atom->torque_flag) error->all(FLERR, "pair_style jump/disc spin yes needs an atom style with torque");
  if (neighbor->nex_type || neighbor->nex_group || neighbor->nex_mol)
    error->all(FLERR, "pair_style jump/disc knows no neigh_modify exclude");
  if (ledger && force->newton_pair && (comm->nprocs > 1 || domain->xperiodic || domain->yperiodic))
    error->all(FLERR, "pair_style jump/disc ledger yes needs newton off where discs have images on other ranks");
  packed_step = -1;
  stepped = false;
  listed.clear();
  candidates = interior = 0;
}

/** Whether the style itself brings the discs of other ranks. */
bool PairJumpDisc::uses_halo() const
{
  return halo && comm->nprocs > 1;
}

/** Discs of other ranks (or images) behind the local ones. */
int PairJumpDisc::others() const
{
  return uses_halo() ? ring.count() : atom->nghost;
}

/** How far from the cuts a disc of another rank can come into touch before LAMMPS reneighbours, m.

    Until LAMMPS looks, a disc moves by half its skin; and on, at most, for the steps between two looks. Its speed then may be
    larger than any now: twice that, and what an overlap of 5 % gives to a disc at rest. */
double PairJumpDisc::halo_cut() const
{
  double most = largest_squared_speed();
  MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_DOUBLE, MPI_MAX, world);
  const double speed = 2.0 * std::sqrt(most) + 0.05 * diameter * std::sqrt(2.0 * k / mass);
  const int steps = std::max(neighbor->every, neighbor->delay);
  return largest + neighbor->skin + 2.0 * steps * update->dt * speed;
}

double PairJumpDisc::init_one(int i, int j)
{
  if (setflag[i][j] == 0) error->all(FLERR, "pair_coeff of jump/disc is not set for types {} {}", i, j);
  return uses_halo() ? 0.0 : largest;
}

void PairJumpDisc::reserve(int n)
{
  if ((size_t) n > disc.size()) {
    disc.resize(n + n / 4 + 64);
    if (spin) rim.resize(disc.size());
    if (ledger) loss.resize(disc.size());
    if (sizes) {
      radii.resize(disc.size());
      inverse_masses.resize(disc.size());
    }
  }
}

void PairJumpDisc::pack(int from, int to)
{
  double *const *const x = atom->x;
  double *const *const v = atom->v;
  for (int i = from; i < to; i++) disc[i] = {x[i][0], x[i][1], v[i][0], v[i][1]};
  if (sizes) pack_sizes(from, to);
  if (spin) {
    double *const *const omega = atom->omega;
    for (int i = from; i < to; i++) rim[i] = radius_of(i) * omega[i][2];
  }
}

void PairJumpDisc::pack_sizes(int from, int to)
{
  for (int i = from; i < to; i++) {
    radii[i] = atom->radius[i];
    inverse_masses[i] = 1.0 / atom->rmass[i];
  }
}

/** Refuse discs that the settings do not describe when some may have come in. */
void PairJumpDisc::check_discs(int from, int to)
{
  const double slack = 1e-10, density = mass / (diameter * diameter);
  for (int i = from; i < to; i++) {
    const double d = atom->radius ? 2.0 * atom->radius[i] : diameter, right = density * d * d;
    const double m = atom->rmass ? atom->rmass[i] : atom->mass[atom->type[i]];
    if (!(d > (1.0 - slack) * smallest && d < (1.0 + slack) * largest) || !(std::fabs(m - right) < slack * right))
      error->one(FLERR,
                 "jump/disc: disc {} has diameter {} and mass {}, the pair style says {} to {}, and mass {} at {}",
                 atom->tag[i], d, m, smallest, largest, mass, diameter);
  }
}

void PairJumpDisc::write_restart(FILE *fp)
{
  write_restart_settings(fp);
  for (int i = 1; i <= atom->ntypes; i++)
    for (int j = i; j <= atom->ntypes; j++) fwrite(&setflag[i][j], sizeof(int), 1, fp);
}

void PairJumpDisc::read_restart(FILE *fp)
{
  read_restart_settings(fp);
  allocate();
  for (int i = 1; i <= atom->ntypes; i++)
    for (int j = i; j <= atom->ntypes; j++) {
      if (comm->me == 0) utils::sfread(FLERR, &setflag[i][j], sizeof(int), 1, fp, nullptr, error);
      MPI_Bcast(&setflag[i][j], 1, MPI_INT, 0, world);
    }
}

void PairJumpDisc::write_restart_settings(FILE *fp)
{
  fwrite(&RESTART_FORM, sizeof(int), 1, fp);
  fwrite(static_cast<const DiscSettings *>(this), sizeof(DiscSettings), 1, fp);
}

void PairJumpDisc::read_restart_settings(FILE *fp)
{
  DiscSettings *const mine = this;
  if (comm->me == 0) {
    int form;
    utils::sfread(FLERR, &form, sizeof(int), 1, fp, nullptr, error);
    if (form != RESTART_FORM)
      error->one(FLERR, "pair_style jump/disc: the restart file is of another version of the plugin: it cannot go on");
    utils::sfread(FLERR, mine, sizeof(DiscSettings), 1, fp, nullptr, error);
  }
  MPI_Bcast(mine, sizeof(DiscSettings), MPI_BYTE, 0, world);
  choose();
}

double PairJumpDisc::memory_usage()
{
  return ring.memory_usage() + disc.capacity() * sizeof(Disc) +
      (rim.capacity() + radii.capacity() + inverse_masses.capacity() + 4 * loss.capacity() + sorted_x.capacity() +
       sorted_y.capacity() + sorted_radius.capacity()) * sizeof(double) +
      (first.capacity() + second.capacity() + first_across.capacity() + second_across.capacity() + cell_of.capacity() + cell_start.capacity() +
       sorted.capacity() + listed.capacity()) *
      sizeof(int);
}
