// SPDX-License-Identifier: GPL-2.0-or-later
#include "contact/no_contraction.h"

#include "fix_jump_step.h"

#include "pair_jump_disc.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "force.h"
#include "modify.h"
#include "neighbor.h"
#include "output.h"
#include "update.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>

using namespace LAMMPS_NS;
using namespace FixConst;

namespace {
// x and y of a row of LAMMPS' arrays (three numbers a disc) as one
typedef double Vec2 __attribute__((vector_size(16), aligned(8), may_alias));

inline Vec2 &at(double *rows, int i) { return *reinterpret_cast<Vec2 *>(rows + 3 * i); }
// … and of the plugin's own array of forces (two numbers a disc)
inline Vec2 &pushed(double *rows, int i) { return *reinterpret_cast<Vec2 *>(rows + 2 * i); }
inline const Vec2 &pushed(const double *rows, int i) { return *reinterpret_cast<const Vec2 *>(rows + 2 * i); }
inline const Vec2 &at(const double *rows, int i) { return *reinterpret_cast<const Vec2 *>(rows + 3 * i); }
}    // namespace

FixJumpStep::FixJumpStep(LAMMPS *lmp, int narg, char **arg) : Fix(lmp, narg, arg)
{
  if (igroup != 0) error->all(FLERR, "fix jump/step acts on all discs: its group is all");
  int a = 3;
  auto value = [&](int at) -> double {
    if (at >= narg) error->all(FLERR, "fix jump/step: a number is missing at the end");
    return utils::numeric(FLERR, arg[at], false, lmp);
  };
  const std::map<std::string, double *> numbers = {
      {"k_wall", &k}, {"gamma_wall", &gamma}, {"gammat_wall", &gamma_t}, {"mu_wall", &mu}};
  const std::map<std::string, int (FixJumpStep::*)(int, int, char **)> parts = {
      {"wall", &FixJumpStep::add_wall}, {"sizes", &FixJumpStep::add_pieces}, {"slots", &FixJumpStep::add_slots},
      {"bodies", &FixJumpStep::add_corners}, {"contacts", &FixJumpStep::add_contacts}, {"poses", &FixJumpStep::add_poses},
      {"probe", &FixJumpStep::add_probes}};
  while (a < narg) {
    const std::string key = arg[a];
    if (key == "gravity") {
      gx = value(a + 1);
      gy = value(a + 2);
      a += 3;
    } else if (auto number = numbers.find(key); number != numbers.end()) {
      *number->second = value(a + 1);
      a += 2;
    } else if (auto part = parts.find(key); part != parts.end()) {
      a = (this->*part->second)(a + 1, narg, arg);
    } else if (key == "known" && a + 1 < narg) {
      known = utils::tnumeric(FLERR, arg[a + 1], false, lmp);
      a += 2;
    } else {
      error->all(FLERR, "fix jump/step: unknown keyword '{}'", key);
    }
  }
  if (!walls.empty() && !(k > 0.0)) error->all(FLERR, "fix jump/step: walls need k_wall above 0");
  if (gamma < 0.0 || gamma_t < 0.0 || mu < 0.0)
    error->all(FLERR, "fix jump/step: gamma_wall, gammat_wall and mu_wall must not be negative");

  int lids = 0;
  for (const auto &wall : walls) {
    any_moves |= wall.motion.moves;
    lids += wall.motion.is_lid;
  }
  columns = any_moves ? 4 : 3;
  time_integrate = 1;
  scalar_flag = global_freq = 1;
  restart_global = lids > 0;
  window.assign(columns * probed.size(), 0.0);
  mean.assign(columns * probed.size(), 0.0);
  size_vector = (int) (window.size() + PUSHED_WORDS * lids + 4 * bodies.partner.size());
  vector_flag = size_vector > 0;
  extscalar = extvector = 0;
}

/** How often something is written, and where. */
int FixJumpStep::add_file(OutFile &of, int a, int narg, char **arg) const
{
  if (a + 1 >= narg) error->all(FLERR, "fix jump/step: {} needs EVERY and FILE", arg[a - 1]);
  of.every = utils::inumeric(FLERR, arg[a], false, lmp);
  if (of.every < 1) error->all(FLERR, "fix jump/step: {} every {} steps: must be above 0", arg[a - 1], of.every);
  of.file = arg[a + 1];
  return a + 2;
}

/** Walls whose forces are summed: the rest of the words. */
int FixJumpStep::add_probes(int a, int narg, char **arg)
{
  if (a + 1 >= narg) error->all(FLERR, "fix jump/step: probe needs EVERY and a wall's name");
  probe_every = utils::inumeric(FLERR, arg[a], false, lmp);
  if (probe_every < 1) error->all(FLERR, "fix jump/step: probe every {} steps: must be above 0", probe_every);
  for (a++; a < narg; a++) {
    auto found = std::find_if(walls.begin(), walls.end(), [&](const Wall &w) { return w.name == arg[a]; });
    if (found == walls.end()) error->all(FLERR, "fix jump/step: probe of an unknown wall '{}'", arg[a]);
    found->probe = (int) probed.size();
    probed.push_back((int) (found - walls.begin()));
  }
  return a;
}

int FixJumpStep::add_pieces(int a, int narg, char **arg)
{
  if (a + 5 > narg) error->all(FLERR, "fix jump/step: sizes needs EVERY DENSITY SHIFT TURN N and N pieces");
  auto next = [&]() { return utils::numeric(FLERR, arg[a++], false, lmp); };
  nevery = utils::inumeric(FLERR, arg[a++], false, lmp);
  density = next();
  shift = next();
  turn = next();
  const int n = utils::inumeric(FLERR, arg[a++], false, lmp);
  if (nevery < 1 || !(density > 0.0) || n < 1 || a + 4 * n > narg)
    error->all(FLERR, "fix jump/step: sizes needs EVERY and DENSITY above 0, and N pieces of four numbers");
  for (int p = 0; p < n; p++) pieces.push_back({next(), next(), next(), next()});
  create_attribute = 1;    // set_arrays() tells of new discs
  return a;
}

int FixJumpStep::setmask()
{
  return INITIAL_INTEGRATE | POST_FORCE | FINAL_INTEGRATE | POST_RUN | (pieces.empty() ? 0 : END_OF_STEP);
}

void FixJumpStep::init()
{
  pair = dynamic_cast<PairJumpDisc *>(force->pair_match("jump/disc", 1));
  if (!pair) error->all(FLERR, "fix jump/step needs pair_style jump/disc");
  if (domain->dimension != 2) error->all(FLERR, "fix jump/step needs dimension 2");
  if (!pieces.empty() && !pair->sizes) error->all(FLERR, "fix jump/step sizes needs the sizes of pair_style jump/disc");
  sized = known;
  newcomers = true;    // of a state that is read
  const bool many = std::any_of(walls.begin(), walls.end(), [](const Wall &w) { return w.faces.size() > jump::FEW; });
  near_margin = (many ? NEAR_MARGIN_OF_MANY : NEAR_MARGIN) * pair->diameter;
  for (auto &wall : walls) {
    wall.near.prepare(wall.in_place().faces, (int) wall.faces.size(), 0.5 * pair->largest, near_margin, pair->diameter);
    if (!wall.own) wall.numbers[0] = k, wall.numbers[1] = gamma, wall.numbers[2] = gamma_t, wall.numbers[3] = mu;
    jump::LawNumbers input = pair->input_law;
    input.stiffness = wall.numbers[0], input.damping = wall.numbers[1], input.tangential = wall.numbers[2];
    input.friction = wall.numbers[3];
    if (!(wall.rolling < 0.0)) input.rolling_friction = wall.rolling;
    wall.law = {input, pair->mass, pair->sizes ? 0.5 * pair->diameter : 1.0, pair->sign, pair->springs};
  }
  if (pair->springs && !array_atom) error->all(FLERR, "fix jump/step needs slots for the law history");
  prepare_bodies();
  watch_others();
  pair->slots.rows = &array_atom;
  pair->slots.number = array_atom ? size_peratom_cols / SLOT : 0;
}

/** Find out which fixes look at the discs, and when. */
void FixJumpStep::watch_others()
{
  constexpr int EACH_STEP = INITIAL_INTEGRATE | POST_INTEGRATE | PRE_FORCE | PRE_REVERSE | POST_FORCE | FINAL_INTEGRATE;
  others_push = others_look = false;
  renewing.clear();
  ending.clear();
  for (Fix *fix : modify->get_fix_list()) {
    if (fix->force_reneighbor) renewing.push_back(fix);
    if (fix->setmask() & END_OF_STEP) ending.push_back(fix);
    if (fix == this || strcmp(fix->id, "step_hook") == 0) continue;    // the hook of tests reads only the step
    others_push |= (fix->setmask() & POST_FORCE) != 0;
    others_look |= (fix->setmask() & EACH_STEP) != 0;
  }
}

void FixJumpStep::setup(int vflag)
{
  starts = true;
  lammps_is_stale = false;
  post_force(vflag);
}

/** First half kick and drift of some discs; widens the range (lo, hi) of their velocities.

    OWN: they are as the pair style has packed them, and the second half kick of the step before is still to come.
    SEEN: LAMMPS looks at them before the end of this step. */
template <bool SIZES, bool STAYS, bool OWN, bool SEEN>
void FixJumpStep::drift(const int *discs, int from, int to, SpeedRange &range)
{
  double *const __restrict x = atom->x[0];
  double *const __restrict v = atom->v[0];
  double *const __restrict f = pair->pushes.data();
  const double dtv = update->dt, dtf = 0.5 * dtv * force->ftm2v;
  double dtfm = dtf / pair->mass;
  const double *const __restrict inverse_mass = pair->inverse_masses.data();
  const Vec2 kick = {0.5 * dtv * gx, 0.5 * dtv * gy};
  PairJumpDisc::PackedDisc *const __restrict disc = pair->disc.data();
  Vec2 lo = {1e300, 1e300}, hi = {-1e300, -1e300};
  for (int n = from; n < to; n++) {
    const int i = discs ? discs[n] : n;
    if (SIZES) dtfm = dtf * inverse_mass[i];
    const Vec2 half = dtfm * pushed(f, i) + (STAYS && dtfm == 0.0 ? Vec2{} : kick);
    const Vec2 speed = (OWN ? Vec2{disc[i].vx, disc[i].vy} + half : at(v, i)) + half;
    const Vec2 place = (OWN ? Vec2{disc[i].x, disc[i].y} : at(x, i)) + dtv * speed;
    if (SEEN) {
      at(v, i) = speed;
      at(x, i) = place;
    }
    pushed(f, i) = Vec2{};    // for the sums of this step
    disc[i] = {place[0], place[1], speed[0], speed[1]};
    lo = speed < lo ? speed : lo;
    hi = speed > hi ? speed : hi;
  }
  if (pair->spin) {
    if (OWN) turn_discs(discs, from, to);
    turn_discs(discs, from, to);
    for (int n = from; n < to; n++) pair->turns[discs ? discs[n] : n] = 0.0;
  }
  range = {{lo[0], lo[1]}, {hi[0], hi[1]}};
}

/** Whether LAMMPS may look at the discs in this step before their forces: to sort, insert or remove them, or others do. */
bool FixJumpStep::is_seen_before_forces() const
{
  if (others_look || update->ntimestep == output->next) return true;    // restart files ask for sorted discs
  const int ago = neighbor->ago + 1;
  if (ago >= neighbor->delay && ago % neighbor->every == 0) return true;
  return std::any_of(renewing.begin(), renewing.end(), [&](Fix *fix) { return fix->next_reneighbor == update->ntimestep; });
}

/** Whether LAMMPS may look at the discs at the end of this step. */
bool FixJumpStep::is_seen_at_end() const
{
  const bigint step = update->ntimestep;
  if (others_look || step == output->next || step == update->laststep) return true;
  return std::any_of(ending.begin(), ending.end(), [&](Fix *fix) { return step % fix->nevery == 0 && (fix != this || waits()); });
}

/** Whether discs may wait for their own size. On several ranks one may have come from another rank. */
bool FixJumpStep::waits() const
{
  return newcomers || comm->nprocs > 1;
}

/** Spin that a torque of 1 gives to a disc, of inertia m R^2/2, in half a step. */
double FixJumpStep::spin_rate(int i) const
{
  const double radius = pair->radius_of(i);
  if (pair->is_fixed(i)) return 0.0;
  return update->dt * force->ftm2v / (radius * radius * (pair->sizes ? atom->rmass[i] : pair->mass));
}

/** Spin over half a step. */
void FixJumpStep::turn_discs(const int *discs, int from, int to)
{
  double *const __restrict omega = atom->omega[0];
  const double *const __restrict torque = pair->turns.data();
  const double rate = spin_rate(0);
  for (int n = from; n < to; n++) {
    const int i = discs ? discs[n] : n;
    omega[3 * i + 2] += (pair->sizes ? spin_rate(i) : rate) * torque[i];
    pair->spins[i] = omega[3 * i + 2];
  }
}

/** The loop that moves the discs in this step. */
FixJumpStep::Drift FixJumpStep::drift_of(bool own, bool seen) const
{
  const auto of = [&](auto sizes, auto stays) -> Drift {
    constexpr bool SIZES = decltype(sizes)::value, STAYS = decltype(stays)::value;
    if (own) return seen ? &FixJumpStep::drift<SIZES, STAYS, true, true> : &FixJumpStep::drift<SIZES, STAYS, true, false>;
    return seen ? &FixJumpStep::drift<SIZES, STAYS, false, true> : &FixJumpStep::drift<SIZES, STAYS, false, false>;
  };
  using Yes = std::true_type;
  using No = std::false_type;
  return pair->any_fixed() ? of(Yes(), Yes()) : pair->sizes ? of(Yes(), No()) : of(No(), No());
}

void FixJumpStep::initial_integrate(int)
{
  for (auto &wall : walls)
    if (auto &motion = wall.motion; motion.is_lid)
      jump::drift(motion.pushed, motion.load, {motion.start, update->dt}, (double) update->ntimestep);
  pair->tuner.begin_step(atom->nlocal);
  if (others_push && starts) pair->take_forces();
  starts = false;
  if (pair->pool.size() != pair->tuner.threads()) pair->pool.resize(pair->tuner.threads());
  if (atom->nlocal == 0) {
    pair->range_lo[0] = pair->range_lo[1] = 1e300;    // discs of other ranks may widen it
    pair->range_hi[0] = pair->range_hi[1] = -1e300;
    return;
  }
  const bool seen = is_seen_before_forces();
  if (!seen && !is_seen_at_end()) pair->keep_uncleared();
  const auto move = drift_of(lammps_is_stale, seen);
  SpeedRange ranges[jump::MOST_THREADS];
  int parts = pair->in_parts_of_list([&](const int *discs, int count, int part) {
    (this->*move)(discs, 0, count, ranges[part]);
  });
  if (parts == 0)
    parts = pair->in_parts(atom->nlocal, [&](int from, int to, int part) { (this->*move)(nullptr, from, to, ranges[part]); });
  for (int axis = 0; axis < 2; axis++) {
    double &lo = pair->range_lo[axis], &hi = pair->range_hi[axis];
    lo = ranges[0].lo[axis];
    hi = ranges[0].hi[axis];
    for (int part = 1; part < parts; part++) {
      lo = std::min(lo, ranges[part].lo[axis]);
      hi = std::max(hi, ranges[part].hi[axis]);
    }
  }
  near_moved += update->dt * std::max(std::max(-pair->range_lo[0], pair->range_hi[0]),
                                      std::max(-pair->range_lo[1], pair->range_hi[1]));
}

void FixJumpStep::final_integrate()
{
  if (others_push) pair->take_forces();
  lammps_is_stale = !is_seen_at_end();
  if (!lammps_is_stale) end_steps();
  pair->tuner.end_step(paced_order != pair->order);
  paced_order = pair->order;
}

/** LAMMPS ends a run at any step where its time is over. */
void FixJumpStep::post_run()
{
  if (lammps_is_stale) end_steps();
  lammps_is_stale = false;
}

/** Second half kick; LAMMPS' arrays are up to date then. */
void FixJumpStep::end_steps()
{
  if (atom->nlocal > 0) pair->in_parts(atom->nlocal, [this](int from, int to, int) { kick(from, to); });
}

/** The second half kick of some discs. */
void FixJumpStep::kick(int from, int to)
{
  double *const __restrict x = atom->x[0];
  double *const __restrict v = atom->v[0];
  const double *const __restrict f = pair->pushes.data();
  const double dtv = update->dt, dtf = 0.5 * dtv * force->ftm2v, dtfm = dtf / pair->mass;
  const double *const __restrict inverse_mass = pair->inverse_masses.data();
  const Vec2 kick = {0.5 * dtv * gx, 0.5 * dtv * gy};
  const PairJumpDisc::PackedDisc *const __restrict disc = pair->disc.data();
  for (int i = from; i < to; i++) {
    const double rate = pair->sizes ? dtf * inverse_mass[i] : dtfm;
    at(x, i) = Vec2{disc[i].x, disc[i].y};
    at(v, i) = Vec2{disc[i].vx, disc[i].vy} + (rate * pushed(f, i) + (rate == 0.0 ? Vec2{} : kick));
  }
  if (pair->spin) turn_discs(nullptr, from, to);
}

/** Diameter of a disc; the same operations as in lammps_jump/scene/sizes.py, so that both take the same piece. */
double FixJumpStep::diameter_of(tagint id) const
{
  const double turned = ((double) id + shift) * turn;
  const double quantile = turned - std::floor(turned);
  const auto piece = std::find_if(pieces.begin(), pieces.end() - 1, [&](const SizePiece &p) { return quantile < p.end; });
  return piece->low + piece->slope * (quantile - piece->begin);
}

/** Inserted discs get their own size.

    The forces of this step are those of the inserted size, and the next half kick divides them by the own mass. With
    gravity among the forces (`fix set` in LAMMPS) that is gravity of the inserted mass: the velocity gets the rest. */
void FixJumpStep::end_of_step()
{
  if (!waits()) return;
  newcomers = false;
  tagint highest = sized;
  for (int i = 0; i < atom->nlocal; i++) {
    if (atom->tag[i] <= sized || pair->is_fixed(i)) continue;
    highest = std::max(highest, atom->tag[i]);
    const double d = diameter_of(atom->tag[i]), mass = density * d * d;
    const double excess = 0.5 * update->dt * (atom->rmass[i] / mass - 1.0);
    atom->v[i][0] += excess * gx;
    atom->v[i][1] += excess * gy;
    atom->radius[i] = 0.5 * d;
    atom->rmass[i] = mass;
    pair->pack_size(i);
  }
  sized = highest;
}

/** Largest overlap of pairs and walls at the last force evaluation, m. */
double FixJumpStep::compute_scalar()
{
  double here = pair->largest_overlap(), all;
  jump::FaceContact found[jump::MOST];
  for (const auto &wall : walls) {
    if (!is_there(wall)) continue;
    const auto &near = wall.near;
    const auto view = wall.in_place();
    for (size_t r = 0; r < near.discs.size(); r++) {
      const int i = near.discs[r], first = near.last[r];
      if (pair->is_fixed(i)) continue;
      const double radius = pair->radius_of(i);
      double x = pair->disc[i].x, y = pair->disc[i].y;
      view.see(x, y);
      const int contacts = view.faces.touching(&near.near[first], near.last[r + 1] - first, x, y, radius, found);
      for (int c = 0; c < contacts; c++) here = std::max(here, radius - found[c].gap);
    }
  }
  MPI_Allreduce(&here, &all, 1, MPI_DOUBLE, MPI_MAX, world);
  return all;
}

double FixJumpStep::compute_vector(int n)
{
  if (n >= (int) mean.size()) return pushed_state(n - (int) mean.size());    // all ranks have it
  double sum;
  MPI_Allreduce(&mean[n], &sum, 1, MPI_DOUBLE, MPI_SUM, world);
  return sum;
}

/** What of the lids is no function of the step. */
void FixJumpStep::write_restart(FILE *fp)
{
  if (comm->me != 0) return;
  std::vector<double> state;
  for (const auto &wall : walls)
    if (wall.motion.is_lid) {
      const auto &lid = wall.motion.pushed;
      state.insert(state.end(), {lid.place[0], lid.place[1], lid.speed[0], lid.speed[1], lid.force[0], lid.force[1],
                                 wall.hold.area});
    }
  pack_bodies(state);
  const int size = (int) (state.size() * sizeof(double));
  fwrite(&size, sizeof(int), 1, fp);
  fwrite(state.data(), sizeof(double), state.size(), fp);
}

void FixJumpStep::restart(char *buf)
{
  const auto *state = reinterpret_cast<const double *>(buf);
  for (auto &wall : walls)
    if (wall.motion.is_lid) {
      auto &lid = wall.motion.pushed;
      for (double *const to : {lid.place, lid.speed, lid.force})
        for (int axis = 0; axis < 2; axis++) to[axis] = *state++;
      wall.hold.area = *state++;
    }
  unpack_bodies(state);
}
