// SPDX-License-Identifier: GPL-2.0-or-later
/* Settings, checks and list of pair_style jump/disc (what it is: pair_jump_disc.h). */

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
  partition.in_blocks = false;
  partition.tuner.read(std::getenv("LAMMPS_JUMP_THREADS"));
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
  largest = state().diameter;
  skin = state().lists->skin;
  if (any_fixed() && !state().radius) error->all(FLERR, "pair_style jump/disc: fixed needs discs of sizes of their own");
  if (any_fixed() != (state().fixed != nullptr)) error->all(FLERR, "pair_style jump/disc: fixed is for a scene with discs that stay");
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
  state().pressed = nullptr;    // pressure is requested from the native engine
  take_tables();
}

/** Let the core sort the arrays of the discs, and with them the numbers that LAMMPS has for the discs. Velocities are in rows, which
    are sorted too, and forces are made anew. */
void PairJumpDisc::take_tables()
{
  const jump_state &s = state();
  jump_lists &l = *s.lists;
  first_origin.assign(s.disc_room, 0);
  table.assign(1, first_origin.data());
  widths.assign(1, 1);
  const auto in_rows = [&](const int64_t *column) {
    const double *const rows[] = {s.vx, s.vy, s.fx, s.fy};
    return std::find(rows, rows + 4, reinterpret_cast<const double *>(column)) != rows + 4;
  };
  const int64_t sorted = l.columns;
  l.columns = 1;
  for (const bool last : {false, true})
    for (int64_t c = 0; c < l.all_columns; c++) {
      if ((c >= sorted || in_rows(l.column[c])) != last) continue;
      table.push_back(l.column[c]);
      widths.push_back(l.width[c]);
      l.columns += !last;
    }
  l.column = table.data();
  l.width = widths.data();
  l.all_columns++;
  if (ring.is_needed()) l.columns = l.all_columns;    // some forces are there when discs are sorted
  const double far = 1e9 * (l.widest + l.skin);    // LAMMPS tells which discs have left the domain
  l.xlo = l.ylo = -far;
  l.xhi = l.yhi = far;
  state().start[0] = 0;
  state().owner = nullptr;    // the seam of a channel is the halo's
  state().shift = nullptr;
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
}

/** How far from the cuts a disc of another rank can come into touch before LAMMPS reneighbours, m.

    Until LAMMPS looks, a disc moves by half its skin; and on, at most, for the steps between two looks. Its speed then may be
    larger than any now: twice that, and what an overlap of 5 % gives to a disc at rest. */
double PairJumpDisc::halo_cut()
{
  const jump_state &s = state();
  const double mass = s.radius ? s.mass * 0.25 * largest * largest : s.mass;
  double most = largest_squared_speed();
  MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_DOUBLE, MPI_MAX, world);
  const double speed = 2.0 * std::sqrt(most) + 0.05 * largest * std::sqrt(2.0 * s.pair.stiffness / mass);
  const int steps = std::max(neighbor->every, neighbor->delay);
  return largest + neighbor->skin + 2.0 * steps * update->dt * speed;
}

/** Called only for a file that holds settings of the style, as earlier versions wrote them. */
void PairJumpDisc::read_restart(FILE *)
{
  error->all(FLERR, "pair_style jump/disc: the restart file is of another version of the plugin: it cannot go on");
}

/** Room for so many discs, those of other ranks among them. */
void PairJumpDisc::reserve(int64_t n)
{
  while (state().disc_room < n) partition.rooms.grow_discs(state());
}

/** Put what discs remember into the array of LAMMPS, a row of each: partners, then feet, springs and rolling springs. */
void PairJumpDisc::put_slots()
{
  const jump_state &s = state();
  if (!slots || !slots_are_old) return;
  store_memory();
  slots_are_old = false;
  for (int64_t k = 0; k < s.n; k++) {
    double *to = (*slots)[origin(k)];
    to = std::copy_n(reinterpret_cast<const double *>(s.partner + k * s.slots), s.slots, to);
    for (const double *const from : {s.sigma, s.spring, s.roll}) to = std::copy_n(from + k * s.slots, s.slots, to);
  }
}

/** Take it from there. */
void PairJumpDisc::take_slots()
{
  const jump_state &s = state();
  if (!s.partner) return;
  for (int64_t k = 0; k < s.n; k++) {
    const double *from = (*slots)[origin(k)];
    std::copy_n(from, s.slots, reinterpret_cast<double *>(s.partner + k * s.slots));
    for (double *const to : {s.sigma, s.spring, s.roll}) std::copy_n(from += s.slots, s.slots, to + k * s.slots);
  }
}

/** Refuse discs that the settings do not describe when some may have come in. */
void PairJumpDisc::check_discs(int from, int to) const
{
  const double slack = 1e-10;
  const jump_state &s = state();
  const bool sizes = s.radius;
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
  jump_state &s = state();
  std::unordered_map<int64_t, int64_t> local;
  for (int64_t i = 0; i < s.n; i++) local[s.ids[i]] = i;
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
  for (int64_t i = 0; i < s.n; i++)
    for (int64_t at = i * s.slot_row, last = at + s.slots; at < last; at++) {
      const double row[WORDS] = {(double) s.partner[at], (double) s.ids[i], s.spring[at], -s.roll[at]};
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

// --- the list: the core's, of LAMMPS' discs

/** Whether the local discs that the list knows still have the same indices (more may have come after them). */
bool PairJumpDisc::keeps_order() const
{
  const size_t n = listed.size();
  return n > 0 && (size_t) atom->nlocal >= n && memcmp(listed.data(), atom->tag, n * sizeof(tagint)) == 0;
}

/** Take the discs of LAMMPS where it may have changed them; whether the list has to be made anew. */
bool PairJumpDisc::take_discs()
{
  if (moved_by_others() || ring.is_needed() || !keeps_order()) {
    check_discs(0, atom->nlocal);
    pack();
    listed.assign(atom->tag, atom->tag + atom->nlocal);
    return true;
  }
  take_motion();
  if (atom->nlocal > (int) listed.size()) append_to_list((int) listed.size());
  return false;
}

/** All pairs of local discs whose rims are closer than the skin, from the arrays of the state. */
void PairJumpDisc::build_list()
{
  jump_state &s = state();
  for (int c = 0; c < 2; c++) moved[c] = moved_here[c] = 0.0;
  s.owner = nullptr;
  int64_t found = jump::NO_ROOM;
  while (found == jump::NO_ROOM) {
    found = jump::list_pairs(s, *s.lists, partition);
    if (found >= 0)
      error->one(FLERR, "jump/disc: the position of disc {}, ({}, {}) m, is not a number or far outside the domain: the run has blown up",
                 s.ids[found], s.x[found], s.y[found]);
    partition.sort_rows(s.n);
    if (!packed) ring.renumber(partition.lists.sorted);
    if (found == jump::NO_ROOM) partition.rooms.grow_neighbours(s, 0);
  }
  order++;
  remembers_list = false;
  load(0);
}

/** Rows of the list after the others, for pairs of a local disc with one of another rank or beyond the seam. */
void PairJumpDisc::list_across()
{
  if (!ring.is_needed()) return;
  while (!jump::list_across(state(), *state().lists, ring.count(), rows(), partition.rooms))
    partition.rooms.grow_neighbours(state(), state().start[state().sorted]);
}

/** New discs at the end, the others as they were: rows of the new ones.

    The others may have moved since the list was built: the rows have those that are as close as they still may be missed. */
void PairJumpDisc::append_to_list(int from)
{
  jump_state &s = state();
  check_discs(from, atom->nlocal);
  reserve(atom->nlocal);
  store_places();
  partition.make_room_for(atom->nlocal, 0);
  for (int i = from; i < atom->nlocal; i++) {
    const int64_t k = s.n;
    jump::Rooms::clear_next(s);
    take_disc(i);
    const double reach = s.radius ? skin : largest + skin;
    while (!jump_append_row(k, s.x, s.y, s.radius, reach, s.start, s.neighbours, s.room)) partition.rooms.grow_neighbours(s, s.start[k]);
    s.rows++;
  }
  listed.assign(atom->tag, atom->tag + atom->nlocal);
  order++;
  remembers_list = false;
  load(from);
}
