// SPDX-License-Identifier: GPL-2.0-or-later
/* Discs that flow in by rows (what the fix does: fix_jump_inlet.h). */

#include "fix_jump_inlet.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "library.h"
#include "update.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <locale>

using namespace LAMMPS_NS;

FixJumpInlet::FixJumpInlet(LAMMPS *lmp, int narg, char **arg) : Fix(lmp, narg, arg)
{
  constexpr int WORDS = 9;    // of a row, its name included
  const bool timed = narg > 6 && strcmp(arg[5], "turns") == 0;
  const int begin = timed ? 7 : 5;
  if (narg < begin + WORDS || (narg - begin) % WORDS != 0)
    error->all(FLERR, "fix jump/inlet needs DIAMETER, MASS, perhaps turns FILE, and rows: row FIRST EVERY MOST NEAR X Y VX VY");
  const auto value = [&](int a) { return utils::numeric(FLERR, arg[a], false, lmp); };
  const auto count = [&](int a) { return utils::bnumeric(FLERR, arg[a], false, lmp); };
  diameter = value(3);
  mass = value(4);
  for (int a = begin; a < narg; a += WORDS) {
    if (strcmp(arg[a], "row") != 0) error->all(FLERR, "fix jump/inlet: '{}' stands where a row begins", arg[a]);
    EntryRow row{count(a + 1), count(a + 2), count(a + 3), 0, value(a + 4), value(a + 5), value(a + 6), value(a + 7), value(a + 8)};
    if (row.every < (timed ? 0 : 1) || row.most < 0 || !(row.near >= 0.0))
      error->all(FLERR, "fix jump/inlet: EVERY is 1 or more, or 0 with turns, MOST and NEAR are 0 or more");
    if (!(row.x >= domain->boxlo[0] && row.x < domain->boxhi[0] && row.y >= domain->boxlo[1] && row.y < domain->boxhi[1]))
      error->all(FLERR, "fix jump/inlet: the row at ({}, {}) is outside the box", row.x, row.y);
    rows.push_back(row);
  }
  if (!(diameter > 0.0) || !(mass > 0.0)) error->all(FLERR, "fix jump/inlet: DIAMETER and MASS must be above 0");
  if (!atom->radius_flag || !atom->rmass_flag) error->all(FLERR, "fix jump/inlet needs atom_style sphere");
  if (timed) read_turns(arg[6]);
  restart_global = 1;
  force_reneighbor = 1;    // discs come while LAMMPS exchanges them
  find_next();
}

int FixJumpInlet::setmask()
{
  return FixConst::PRE_EXCHANGE;
}

void FixJumpInlet::setup_pre_exchange()
{
  find_next();
}

/** The steps and speeds of rows that have no interval, read by one rank for all. */
void FixJumpInlet::read_turns(const std::string &name)
{
  std::vector<bigint> whole;    // row and step of each line
  std::vector<double> speeds;
  if (comm->me == 0) {
    std::ifstream file(name);
    file.imbue(std::locale::classic());
    if (!file) error->one(FLERR, "fix jump/inlet: {} cannot be read", name);
    bigint row, step;
    double speed;
    while (file >> row >> step >> speed) {
      whole.insert(whole.end(), {row, step});
      speeds.push_back(speed);
    }
    if (!file.eof()) error->one(FLERR, "fix jump/inlet: {}, line {}: expected a row, a step and a speed", name, speeds.size() + 1);
  }
  int lines = (int) speeds.size();
  MPI_Bcast(&lines, 1, MPI_INT, 0, world);
  whole.resize(2 * (size_t) lines);
  speeds.resize(lines);
  MPI_Bcast(whole.data(), 2 * lines, MPI_LMP_BIGINT, 0, world);
  MPI_Bcast(speeds.data(), lines, MPI_DOUBLE, 0, world);
  for (int line = 0; line < lines; line++) {
    const bigint number = whole[2 * (size_t) line], step = whole[2 * (size_t) line + 1];
    if (number < 1 || number > (bigint) rows.size() || rows[number - 1].every != 0)
      error->all(FLERR, "fix jump/inlet: {}, line {}: row {} is none of those with EVERY 0", name, line + 1, number);
    auto &row = rows[number - 1];
    if (step < 1 || (!row.steps.empty() && step <= row.steps.back()) || !std::isfinite(speeds[line]))
      error->all(FLERR, "fix jump/inlet: {}, line {}: the steps of a row rise from 1 on, and speeds are finite", name, line + 1);
    row.steps.push_back(step);
    row.speeds.push_back(speeds[line]);
  }
}

/** The first step after one at which a row tries. */
bigint FixJumpInlet::EntryRow::next_after(bigint step) const
{
  if (is_full()) return 0;
  if (every > 0) return step < first ? first : first + ((step - first) / every + 1) * every;
  const auto place = std::upper_bound(steps.begin(), steps.end(), step);
  return place == steps.end() ? 0 : *place;
}

/** The velocity along x that a row gives at one of its steps. */
double FixJumpInlet::EntryRow::speed_at(bigint step) const
{
  if (every > 0) return vx;
  return speeds[std::lower_bound(steps.begin(), steps.end(), step) - steps.begin()];
}

/** The next step at which a row lets a disc in, as LAMMPS asks for it; 0 where none will. */
void FixJumpInlet::find_next()
{
  next_reneighbor = 0;
  for (const auto &row : rows)
    if (const bigint next = row.next_after(update->ntimestep))
      next_reneighbor = next_reneighbor == 0 ? next : std::min(next_reneighbor, next);
}

void FixJumpInlet::pre_exchange()
{
  if (next_reneighbor != update->ntimestep) return;
  tagint own = atom->nlocal > 0 ? *std::max_element(atom->tag, atom->tag + atom->nlocal) : 0, highest;
  MPI_Allreduce(&own, &highest, 1, MPI_LMP_TAGINT, MPI_MAX, world);
  for (auto &row : rows)
    if (row.next_after(update->ntimestep - 1) == update->ntimestep && is_free(row) && insert(row, highest + 1)) {
      row.come++;
      highest++;
    }
  find_next();
}

/** Whether no centre is near the place of a row. */
bool FixJumpInlet::is_free(const EntryRow &row) const
{
  const double *const *const x = atom->x;
  const double period = domain->xperiodic ? domain->prd[0] : 0.0;
  int taken = 0, any;
  for (int i = 0; i < atom->nlocal; i++) {
    double dx = row.x - x[i][0];
    if (period > 0.0) dx -= period * std::round(dx / period);
    const double dy = row.y - x[i][1];
    taken |= dx * dx + dy * dy < row.near * row.near;
  }
  MPI_Allreduce(&taken, &any, 1, MPI_INT, MPI_MAX, world);
  return !any;
}

/** Put a disc there, on the rank whose part of space it is in; whether it came. */
bool FixJumpInlet::insert(const EntryRow &row, tagint id)
{
  const int before = atom->nlocal, type = 1;
  const bigint all = atom->natoms;
  const double x[3] = {row.x, row.y, 0.0}, v[3] = {row.speed_at(update->ntimestep), row.vy, 0.0};
  atom->nghost = 0;    // a new disc takes the place after the own ones
  lammps_create_atoms(lmp, 1, &id, &type, x, v, nullptr, 0);
  if (atom->nlocal > before) {
    atom->radius[before] = 0.5 * diameter;
    atom->rmass[before] = mass;
  }
  return atom->natoms > all;
}

/** How many have come by each row. */
void FixJumpInlet::write_restart(FILE *fp)
{
  if (comm->me != 0) return;
  std::vector<double> come;
  for (const auto &row : rows) come.push_back((double) row.come);
  const int size = (int) (come.size() * sizeof(double));
  fwrite(&size, sizeof(int), 1, fp);
  fwrite(come.data(), sizeof(double), come.size(), fp);
}

void FixJumpInlet::restart(char *buf)
{
  const auto *come = reinterpret_cast<const double *>(buf);
  for (auto &row : rows) row.come = (bigint) *come++;
}
