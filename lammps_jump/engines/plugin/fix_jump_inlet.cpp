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

using namespace LAMMPS_NS;

FixJumpInlet::FixJumpInlet(LAMMPS *lmp, int narg, char **arg) : Fix(lmp, narg, arg)
{
  constexpr int WORDS = 9;    // of a row, its name included
  if (narg < 5 + WORDS || (narg - 5) % WORDS != 0)
    error->all(FLERR, "fix jump/inlet needs DIAMETER, MASS and rows: row FIRST EVERY MOST NEAR X Y VX VY");
  const auto value = [&](int a) { return utils::numeric(FLERR, arg[a], false, lmp); };
  const auto count = [&](int a) { return utils::bnumeric(FLERR, arg[a], false, lmp); };
  diameter = value(3);
  mass = value(4);
  for (int a = 5; a < narg; a += WORDS) {
    if (strcmp(arg[a], "row") != 0) error->all(FLERR, "fix jump/inlet: '{}' stands where a row begins", arg[a]);
    EntryRow row{count(a + 1), count(a + 2), count(a + 3), 0, value(a + 4), value(a + 5), value(a + 6), value(a + 7), value(a + 8)};
    if (row.every < 1 || row.most < 0 || !(row.near >= 0.0))
      error->all(FLERR, "fix jump/inlet: EVERY is 1 or more, MOST and NEAR are 0 or more");
    if (!(row.x >= domain->boxlo[0] && row.x < domain->boxhi[0] && row.y >= domain->boxlo[1] && row.y < domain->boxhi[1]))
      error->all(FLERR, "fix jump/inlet: the row at ({}, {}) is outside the box", row.x, row.y);
    rows.push_back(row);
  }
  if (!(diameter > 0.0) || !(mass > 0.0)) error->all(FLERR, "fix jump/inlet: DIAMETER and MASS must be above 0");
  if (!atom->radius_flag || !atom->rmass_flag) error->all(FLERR, "fix jump/inlet needs atom_style sphere");
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

/** The next step at which a row lets a disc in, as LAMMPS asks for it; 0 where none will. */
void FixJumpInlet::find_next()
{
  next_reneighbor = 0;
  for (const auto &row : rows) {
    if (row.is_full()) continue;
    const bigint now = update->ntimestep;
    const bigint next = now < row.first ? row.first : row.first + ((now - row.first) / row.every + 1) * row.every;
    next_reneighbor = next_reneighbor == 0 ? next : std::min(next_reneighbor, next);
  }
}

void FixJumpInlet::pre_exchange()
{
  if (next_reneighbor != update->ntimestep) return;
  tagint own = atom->nlocal > 0 ? *std::max_element(atom->tag, atom->tag + atom->nlocal) : 0, highest;
  MPI_Allreduce(&own, &highest, 1, MPI_LMP_TAGINT, MPI_MAX, world);
  for (auto &row : rows)
    if (row.is_due(update->ntimestep) && is_free(row) && insert(row, highest + 1)) {
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
  const double x[3] = {row.x, row.y, 0.0}, v[3] = {row.vx, row.vy, 0.0};
  atom->nghost = 0;    // a new disc takes the place behind the own ones
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
