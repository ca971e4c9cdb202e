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

using namespace LAMMPS_NS;
using jump::ContactForce;
using jump::Friction;
using jump::Lanes;
using jump::LANES;
using jump::Touch;

namespace {
typedef double Vec4 __attribute__((vector_size(32), may_alias));
typedef double Vec2 __attribute__((vector_size(16), aligned(8), may_alias));
constexpr int RESTART_FORM = 0x6a640002;    // changes with what the restart file holds
constexpr int BATCH = 256;    // contacts evaluated together: their arrays stay in the first-level cache
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
  bool seen_k = false, seen_mass = false, seen_diameter = false;
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
    } else if (key == "k") {
      k = value(a + 1);
      seen_k = true;
    } else if (key == "gamma") {
      gamma = value(a + 1);
    } else if (key == "gammat") {
      gamma_t = value(a + 1);
    } else if (key == "mu") {
      mu = value(a + 1);
    } else if (key == "mass") {
      mass = value(a + 1);
      seen_mass = true;
    } else if (key == "diameter") {
      diameter = value(a + 1);
      seen_diameter = true;
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
      if (name != "ramp" && name != "even")
        error->all(FLERR, "pair_style jump/disc: dashpot (of a smooth touch) is ramp or even, not '{}'", name);
      even = name == "even";
    } else if (key == "spin") {
      spin = yes(a + 1);
    } else if (key == "skin") {
      skin = value(a + 1);
      if (!(skin > 0.0)) error->all(FLERR, "pair_style jump/disc: skin must be above 0");
    } else if (key == "ledger") {
      ledger = yes(a + 1);
    } else if (key == "halo") {
      halo = yes(a + 1);
    } else {
      error->all(FLERR, "pair_style jump/disc: unknown keyword '{}'", key);
    }
  }
  if (!seen_k || !seen_mass || !seen_diameter)
    error->all(FLERR, "pair_style jump/disc needs k, mass and diameter");
  if (!(k > 0.0) || !(mass > 0.0) || !(diameter > 0.0))
    error->all(FLERR, "pair_style jump/disc: k, mass and diameter must be above 0");
  if (gamma < 0.0 || gamma_t < 0.0 || mu < 0.0)
    error->all(FLERR, "pair_style jump/disc: gamma, gammat and mu must not be negative");
  if (smooth && !(width > 0.0)) error->all(FLERR, "pair_style jump/disc: the width of a smooth touch must be above 0");
  choose();
}

/** The branch of the kernel that the settings ask for. */
void PairJumpDisc::choose()
{
  const bool rubs = mu > 0.0 && (sign || gamma_t > 0.0);
  friction = !rubs ? Friction::NONE
      : sign       ? (spin ? Friction::SIGN_SPIN : Friction::SIGN)
                   : (spin ? Friction::HOOKE_SPIN : Friction::HOOKE);
  touch = !smooth ? Touch::SHARP : even ? Touch::EVEN : Touch::RAMP;
  const double m_eff = mass * mass / (mass + mass);
  law.k = k;
  law.damping = m_eff * gamma;
  law.tangential = m_eff * gamma_t;
  law.mu = mu;
  law.reach = 0.5 * diameter + 0.5 * diameter;
  law.width = width;
  law.inverse_width = law.width > 0.0 ? 1.0 / law.width : 0.0;
  if (!(skin > 0.0)) skin = 0.3 * diameter;
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
  return law.reach + neighbor->skin + 2.0 * steps * update->dt * speed;
}

double PairJumpDisc::init_one(int i, int j)
{
  if (setflag[i][j] == 0) error->all(FLERR, "pair_coeff of jump/disc is not set for types {} {}", i, j);
  return uses_halo() ? 0.0 : diameter;
}

void PairJumpDisc::reserve(int n)
{
  if ((size_t) n > disc.size()) {
    disc.resize(n + n / 4 + 64);
    if (spin) rim.resize(disc.size());
    if (ledger) loss.resize(disc.size());
  }
}

void PairJumpDisc::pack(int from, int to)
{
  double *const *const x = atom->x;
  double *const *const v = atom->v;
  for (int i = from; i < to; i++) disc[i] = {x[i][0], x[i][1], v[i][0], v[i][1]};
  if (spin) {
    double *const *const omega = atom->omega;
    const double radius = 0.5 * diameter;
    for (int i = from; i < to; i++) rim[i] = radius * omega[i][2];
  }
}

/** Everything here holds for equal discs: refuse others when discs may have come in. */
void PairJumpDisc::check_equal_discs(int from, int to)
{
  const double slack = 1e-10;
  int bad = -1;
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
  law.eps = jump::SIGN_RAMP * largest_speed;
}

/** Forces of the pairs from one place in the list to another. */
template <Friction FRICTION, Touch TOUCH, bool LEDGER> void PairJumpDisc::evaluate(size_t from, size_t to)
{
  const Disc *const __restrict at = disc.data();
  const int *const __restrict one = first.data();
  const int *const __restrict two = second.data();
  const double reach_sq = law.reach * law.reach;
  const jump::Law rule = law;
  const int nlocal = atom->nlocal;
  const bool newton = force->newton_pair;
  const double radius = 0.5 * diameter;
  const bool tally = vflag_atom || num_tally_compute > 0;
  double *const __restrict f = atom->f ? atom->f[0] : nullptr;
  double *const __restrict torque = jump::has_spin(FRICTION) && atom->torque ? atom->torque[0] : nullptr;

  // a batch of candidates at a time: differences of those that touch, then their forces, then the sums
  alignas(64) double between[BATCH][4];
  alignas(64) double rims[BATCH], twist[BATCH], force_on[BATCH][2];
  alignas(64) double dashed[LEDGER ? BATCH : 1][2], rubbed[LEDGER ? BATCH : 1][2];
  int touching[BATCH + 1];
  for (size_t begin = from; begin < to; begin += BATCH) {
    const size_t end = begin + BATCH < to ? begin + BATCH : to;
    int n = 0;
    for (size_t p = begin; p < end; p++) {
      // written whether it touches or not, and counted only if it does: a branch here would be guessed wrong often
      const double dx = at[one[p]].x - at[two[p]].x, dy = at[one[p]].y - at[two[p]].y;
      touching[n] = (int) p;
      n += dx * dx + dy * dy < reach_sq;
    }
    for (int c = 0; c < n; c++) {
      const int i = one[touching[c]], j = two[touching[c]];
      *reinterpret_cast<Vec4 *>(between[c]) =
          *reinterpret_cast<const Vec4 *>(&at[i]) - *reinterpret_cast<const Vec4 *>(&at[j]);
      if (jump::has_spin(FRICTION)) rims[c] = rim[i] + rim[j];
    }
    // whole vectors only: the rest of the last one is filled with a contact that nobody reads
    const int whole = (n + LANES - 1) / LANES * LANES;
    for (int c = n; c < whole; c++) {
      between[c][0] = between[c][1] = 0.5 * rule.reach;
      between[c][2] = between[c][3] = 0.0;
      rims[c] = 0.0;
    }
    for (int c = 0; c < whole; c += LANES) {
      Lanes part[4];
      jump::columns(between + c, part);
      const Lanes rim_speed = jump::has_spin(FRICTION) ? *reinterpret_cast<const Lanes *>(rims + c) : Lanes{};
      const auto out = jump::contact_force<FRICTION, TOUCH>(rule, part[0], part[1], part[2], part[3], rim_speed);
      jump::rows_of_two(out.fx, out.fy, force_on + c);
      if (jump::has_spin(FRICTION)) *reinterpret_cast<Lanes *>(twist + c) = radius * out.twist;
      if (LEDGER) {
        jump::rows_of_two(out.dash_x, out.dash_y, dashed + c);
        jump::rows_of_two(out.rub_x, out.rub_y, rubbed + c);
      }
    }
    if (vflag_global && !tally) {    // with newton on it comes from forces and positions at the end
      for (int c = 0; c < n; c++) {
        const double share = newton || two[touching[c]] < nlocal ? 1.0 : 0.5;
        virial[0] += share * between[c][0] * force_on[c][0];
        virial[1] += share * between[c][1] * force_on[c][1];
        virial[3] += share * between[c][0] * force_on[c][1];
      }
    }
    for (int c = 0; c < n; c++) {
      const int i = one[touching[c]], j = two[touching[c]];
      const Vec2 push = *reinterpret_cast<const Vec2 *>(force_on[c]);
      *reinterpret_cast<Vec2 *>(f + 3 * i) += push;
      if (jump::has_spin(FRICTION)) torque[3 * i + 2] -= twist[c];
      if (newton || j < nlocal) {
        *reinterpret_cast<Vec2 *>(f + 3 * j) -= push;
        if (jump::has_spin(FRICTION)) torque[3 * j + 2] -= twist[c];
      }
      if (LEDGER) {
        const Vec4 taken = {dashed[c][0], dashed[c][1], rubbed[c][0], rubbed[c][1]};
        *reinterpret_cast<Vec4 *>(&loss[i]) += taken;
        if (j < nlocal) *reinterpret_cast<Vec4 *>(&loss[j]) -= taken;
      }
      if (tally)
        ev_tally_xyz(i, j, nlocal, newton, 0.0, 0.0, push[0], push[1], 0.0, between[c][0], between[c][1], 0.0);
    }
  }
}

void PairJumpDisc::compute(int eflag, int vflag)
{
  ev_init(eflag, vflag);
  const int nlocal = atom->nlocal;
  const bool reneighboured = neighbor->ago == 0;
  reserve(nlocal + others());
  // fix jump/step has packed the local discs; a reneighbouring may have moved them to other indices since
  if (reneighboured || packed_step != update->ntimestep) pack(0, nlocal);
  bool travelling = false;    // the discs of other ranks
  if (!uses_halo()) {
    pack(nlocal, nlocal + others());
  } else {
    if (num_tally_compute > 0) error->all(FLERR, "pair_style jump/disc: a tally compute needs halo no");
    if (reneighboured) {
      ring.rebuild(*this, halo_cut());
    } else {
      ring.start(*this);
      travelling = true;
    }
  }
  if (driven()) travel(moved_here);
  if (travelling && (!driven() || worn(moved_here))) {
    ring.finish(*this);
    travelling = false;
  }
  if (!travelling) {
    widen_range(nlocal, nlocal + others());
    if (driven()) travel(moved);
    update_list();
  }
  if (sign) find_largest_speed();
  if (ledger) std::fill(loss.begin(), loss.begin() + nlocal, Loss{0.0, 0.0, 0.0, 0.0});

  if (travelling) {
    evaluate(0, interior);
    ring.finish(*this);
    widen_range(nlocal, nlocal + others());
    travel(moved);
    if (worn(moved)) build_list(skin);
    evaluate(interior, candidates);
  } else {
    evaluate(0, candidates);
  }
  packed_step = update->ntimestep;

  if (eflag_global) eng_vdwl += elastic_energy();
  if (vflag_fdotr) virial_fdotr_compute();
}

/** Take the others' velocities into the range of this step. */
void PairJumpDisc::widen_range(int from, int to)
{
  for (int i = from; i < to; i++) {
    range_lo[0] = std::min(range_lo[0], disc[i].vx);
    range_hi[0] = std::max(range_hi[0], disc[i].vx);
    range_lo[1] = std::min(range_lo[1], disc[i].vy);
    range_hi[1] = std::max(range_hi[1], disc[i].vy);
  }
}

void PairJumpDisc::evaluate(size_t from, size_t to)
{
  auto run = [&](auto touch_tag, auto ledger_tag) {
    constexpr Touch T = decltype(touch_tag)::value;
    constexpr bool L = decltype(ledger_tag)::value;
    switch (friction) {
      case Friction::NONE: evaluate<Friction::NONE, T, L>(from, to); break;
      case Friction::HOOKE: evaluate<Friction::HOOKE, T, L>(from, to); break;
      case Friction::HOOKE_SPIN: evaluate<Friction::HOOKE_SPIN, T, L>(from, to); break;
      case Friction::SIGN: evaluate<Friction::SIGN, T, L>(from, to); break;
      case Friction::SIGN_SPIN: evaluate<Friction::SIGN_SPIN, T, L>(from, to); break;
    }
  };
  auto run_touch = [&](auto touch_tag) {
    ledger ? run(touch_tag, std::true_type{}) : run(touch_tag, std::false_type{});
  };
  switch (touch) {
    case Touch::SHARP: run_touch(std::integral_constant<Touch, Touch::SHARP>{}); break;
    case Touch::RAMP: run_touch(std::integral_constant<Touch, Touch::RAMP>{}); break;
    case Touch::EVEN: run_touch(std::integral_constant<Touch, Touch::EVEN>{}); break;
  }
}

/** Elastic energy of one overlap under the touch in use, J/m. */
double PairJumpDisc::elastic_energy(const jump::Law &rule, double overlap) const
{
  return smooth ? jump::elastic_energy<Touch::RAMP>(rule, overlap) : jump::elastic_energy<Touch::SHARP>(rule, overlap);
}

/** Elastic energy in the pairs of this rank, from the positions of the last force evaluation, J/m. */
double PairJumpDisc::elastic_energy() const
{
  double sum = 0.0;
  const int nlocal = atom->nlocal;
  for (size_t p = 0; p < candidates; p++) {
    const double dx = disc[first[p]].x - disc[second[p]].x, dy = disc[first[p]].y - disc[second[p]].y;
    const double rsq = dx * dx + dy * dy;
    if (rsq >= law.reach * law.reach) continue;
    const double share = force->newton_pair || second[p] < nlocal ? 1.0 : 0.5;
    sum += share * elastic_energy(law, law.reach - std::sqrt(rsq));
  }
  return sum;
}

/** Largest overlap of the pairs of this rank at the last force evaluation, m; 0 where none touch. */
double PairJumpDisc::largest_overlap() const
{
  double least = law.reach * law.reach;
  for (size_t p = 0; p < candidates; p++) {
    const double dx = disc[first[p]].x - disc[second[p]].x, dy = disc[first[p]].y - disc[second[p]].y;
    const double rsq = dx * dx + dy * dy;
    least = rsq < least ? rsq : least;
  }
  return law.reach - std::sqrt(least);
}

double PairJumpDisc::single(int i, int j, int, int, double rsq, double, double, double &fforce)
{
  fforce = 0.0;
  if (rsq >= law.reach * law.reach) return 0.0;
  const double dx = atom->x[i][0] - atom->x[j][0], dy = atom->x[i][1] - atom->x[j][1];
  const double vx = atom->v[i][0] - atom->v[j][0], vy = atom->v[i][1] - atom->v[j][1];
  const ContactForce<double> out = touch == Touch::SHARP
      ? jump::contact_force<Friction::NONE, Touch::SHARP>(law, dx, dy, vx, vy, 0.0)
      : touch == Touch::RAMP ? jump::contact_force<Friction::NONE, Touch::RAMP>(law, dx, dy, vx, vy, 0.0)
                             : jump::contact_force<Friction::NONE, Touch::EVEN>(law, dx, dy, vx, vy, 0.0);
  fforce = (out.fx * dx + out.fy * dy) / rsq;
  const double overlap = law.reach - std::sqrt(rsq);
  return elastic_energy(law, overlap);
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
  const double numbers[8] = {k, gamma, gamma_t, mu, mass, diameter, width, skin};
  const int flags[6] = {sign, smooth, even, spin, ledger, halo};
  fwrite(&RESTART_FORM, sizeof(int), 1, fp);
  fwrite(numbers, sizeof(double), 8, fp);
  fwrite(flags, sizeof(int), 6, fp);
}

void PairJumpDisc::read_restart_settings(FILE *fp)
{
  double numbers[8];
  int flags[6];
  if (comm->me == 0) {
    int form;
    utils::sfread(FLERR, &form, sizeof(int), 1, fp, nullptr, error);
    if (form != RESTART_FORM)
      error->one(FLERR, "pair_style jump/disc: the restart file is of another version of the plugin: it cannot go on");
    utils::sfread(FLERR, numbers, sizeof(double), 8, fp, nullptr, error);
    utils::sfread(FLERR, flags, sizeof(int), 6, fp, nullptr, error);
  }
  MPI_Bcast(numbers, 8, MPI_DOUBLE, 0, world);
  MPI_Bcast(flags, 6, MPI_INT, 0, world);
  k = numbers[0];
  gamma = numbers[1];
  gamma_t = numbers[2];
  mu = numbers[3];
  mass = numbers[4];
  diameter = numbers[5];
  width = numbers[6];
  skin = numbers[7];
  sign = flags[0];
  smooth = flags[1];
  even = flags[2];
  spin = flags[3];
  ledger = flags[4];
  halo = flags[5];
  choose();
}

double PairJumpDisc::memory_usage()
{
  return ring.memory_usage() + disc.capacity() * sizeof(Disc) +
      (rim.capacity() + 4 * loss.capacity() + sorted_x.capacity() + sorted_y.capacity()) * sizeof(double) +
      (first.capacity() + second.capacity() + first_across.capacity() + second_across.capacity() + cell_of.capacity() + cell_start.capacity() +
       sorted.capacity() + listed.capacity()) *
      sizeof(int);
}
