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
#include <cstring>
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
  single_enable = 1;
  restartinfo = 1;
  writedata = 0;
  no_virial_fdotr_compute = 0;
  finitecutflag = 0;
}

PairJumpDisc::~PairJumpDisc()
{
  if (copymode) return;
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
  for (int i = 0; i < n; i++)
    for (int j = 0; j < n; j++) {
      setflag[i][j] = 0;
      cutsq[i][j] = 0.0;
    }
}

void PairJumpDisc::settings(int narg, char **arg)
{
  const std::map<std::string, double *> numbers = {{"k", &k}, {"gamma", &gamma}, {"gammat", &gamma_t}, {"mu", &mu},
                                                   {"mass", &mass}, {"diameter", &diameter}, {"skin", &skin}};
  const std::map<std::string, bool *> flags = {{"spin", &spin}, {"ledger", &ledger}, {"halo", &halo}};
  std::set<std::string> seen;
  auto value = [&](int at) -> double {
    if (at >= narg) error->all(FLERR, "pair_style jump/disc: {} needs a value", arg[at - 1]);
    return utils::numeric(FLERR, arg[at], false, lmp);
  };
  auto yes = [&](int at) -> bool {
    if (at >= narg) error->all(FLERR, "pair_style jump/disc: {} needs yes or no", arg[at - 1]);
    return utils::logical(FLERR, arg[at], false, lmp) == 1;
  };
  for (int a = 0; a < narg; a += 2) {
    const std::string key = arg[a];
    if (key == "law") {
      const std::string name = a + 1 < narg ? arg[a + 1] : "";
      if (name != "hooke" && name != "sign")
        error->all(FLERR, "pair_style jump/disc: law is hooke or sign, not '{}'", name);
      sign = name == "sign";
    } else if (key == "touch") {
      const std::string name = a + 1 < narg ? arg[a + 1] : "";
      if (name == "sharp") {
        smooth = false;
      } else if (name == "smooth") {
        smooth = true;
        width = value(a + 2);
        a++;
      } else {
        error->all(FLERR, "pair_style jump/disc: touch is sharp or smooth S, not '{}'", name);
      }
    } else if (key == "dashpot") {
      const std::string name = a + 1 < narg ? arg[a + 1] : "";
      if (name != "even") error->all(FLERR, "pair_style jump/disc: dashpot is even, not '{}'", name);
    } else if (key == "sizes") {
      sizes = true;
      smallest = value(a + 1);
      largest = value(a + 2);
      a++;
    } else if (auto number = numbers.find(key); number != numbers.end()) {
      *number->second = value(a + 1);
      seen.insert(key);
    } else if (auto flag = flags.find(key); flag != flags.end()) {
      *flag->second = yes(a + 1);
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
  const double slack = 1e-10;
  int bad = -1;
  if (sizes) {
    const double density = mass / (diameter * diameter);
    for (int i = from; i < to; i++) {
      const double d = 2.0 * radii[i], right = density * d * d;
      if (!(d > (1.0 - slack) * smallest && d < (1.0 + slack) * largest) ||
          !(std::fabs(atom->rmass[i] - right) < slack * right))
        bad = i;
    }
    if (bad >= 0)
      error->one(FLERR,
                 "jump/disc: disc {} has diameter {} and mass {}, the pair style says {} to {}, and mass {} at {}",
                 atom->tag[bad], 2.0 * radii[bad], atom->rmass[bad], smallest, largest, mass, diameter);
    return;
  }
  if (atom->rmass) {
    for (int i = from; i < to; i++)
      if (std::fabs(atom->rmass[i] - mass) > slack * mass) bad = i;
  } else {
    for (int i = from; i < to; i++)
      if (std::fabs(atom->mass[atom->type[i]] - mass) > slack * mass) bad = i;
  }
  if (bad >= 0)
    error->one(FLERR, "jump/disc: disc {} has mass {}, the pair style says {}", atom->tag[bad],
               atom->rmass ? atom->rmass[bad] : atom->mass[atom->type[bad]], mass);
  if (atom->radius) {
    for (int i = from; i < to; i++)
      if (std::fabs(2.0 * atom->radius[i] - diameter) > slack * diameter) bad = i;
    if (bad >= 0)
      error->one(FLERR, "jump/disc: disc {} has diameter {}, the pair style says {}", atom->tag[bad],
                 2.0 * atom->radius[bad], diameter);
  }
}

void *PairJumpDisc::extract(const char *name, int &dim)
{
  dim = 0;
  if (strcmp(name, "diameter") == 0) return (void *) &diameter;
  if (strcmp(name, "mass") == 0) return (void *) &mass;
  if (strcmp(name, "largest_speed") == 0) return (void *) &largest_speed;
  return nullptr;
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
  const double numbers[10] = {k, gamma, gamma_t, mu, mass, diameter, width, skin, smallest, largest};
  const int flags[6] = {sign, smooth, sizes, spin, ledger, halo};
  fwrite(&RESTART_FORM, sizeof(int), 1, fp);
  fwrite(numbers, sizeof(double), 10, fp);
  fwrite(flags, sizeof(int), 6, fp);
}

void PairJumpDisc::read_restart_settings(FILE *fp)
{
  double numbers[10];
  int flags[6];
  if (comm->me == 0) {
    int form;
    utils::sfread(FLERR, &form, sizeof(int), 1, fp, nullptr, error);
    if (form != RESTART_FORM)
      error->one(FLERR, "pair_style jump/disc: the restart file is of another version of the plugin: it cannot go on");
    utils::sfread(FLERR, numbers, sizeof(double), 10, fp, nullptr, error);
    utils::sfread(FLERR, flags, sizeof(int), 6, fp, nullptr, error);
  }
  MPI_Bcast(numbers, 10, MPI_DOUBLE, 0, world);
  MPI_Bcast(flags, 6, MPI_INT, 0, world);
  k = numbers[0];
  gamma = numbers[1];
  gamma_t = numbers[2];
  mu = numbers[3];
  mass = numbers[4];
  diameter = numbers[5];
  width = numbers[6];
  skin = numbers[7];
  smallest = numbers[8];
  largest = numbers[9];
  sign = flags[0];
  smooth = flags[1];
  sizes = flags[2];
  spin = flags[3];
  ledger = flags[4];
  halo = flags[5];
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
