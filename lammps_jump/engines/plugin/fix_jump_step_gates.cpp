// SPDX-License-Identifier: GPL-2.0-or-later
/* Tailgates of fix jump/step (what it is: fix_jump_step.h): lids of infinite mass, whose speed is set from time to time. */

#include "fix_jump_step.h"

#include "pair_jump_disc.h"

#include "atom.h"
#include "error.h"
#include "update.h"

#include <limits>

using namespace LAMMPS_NS;

/** What a wall holds, from its words. */
int FixJumpStep::add_hold(Wall &wall, int a, int narg, char **arg) const
{
  if (a + 15 > narg) error->all(FLERR, "fix jump/step: hold of wall '{}' needs fifteen numbers", wall.name);
  auto next = [&]() { return utils::numeric(FLERR, arg[a++], false, lmp); };
  auto &motion = wall.motion;
  motion.moves = motion.is_lid = true;
  motion.cx = next();
  motion.cy = next();
  motion.start = (double) utils::bnumeric(FLERR, arg[a++], false, lmp);
  motion.load.mass = motion.load.inertia = std::numeric_limits<double>::infinity();
  motion.load.free[1] = 1.0;
  motion.load.begin = -motion.load.mass;
  auto &hold = wall.hold;
  hold.first = utils::bnumeric(FLERR, arg[a++], false, lmp);
  hold.every = utils::bnumeric(FLERR, arg[a++], false, lmp);
  hold.low = next();
  hold.high = next();
  hold.bins = utils::bnumeric(FLERR, arg[a++], false, lmp);
  for (double *const number : {&hold.target, &hold.level, &hold.proportional, &hold.integral, &hold.speed, &hold.lowest,
                               &hold.highest})
    *number = next();
  if (hold.every < 1 || hold.bins < 1 || !(hold.high > hold.low))
    error->all(FLERR, "fix jump/step: hold of wall '{}' needs EVERY and BINS above 0, and LOW below HIGH", wall.name);
  note_ends(wall);
  return a;
}

/** Ends along x of a wall whose way is not known before. */
void FixJumpStep::note_ends(Wall &wall) const
{
  wall.low = 1e300;
  wall.high = -1e300;
  for (const auto &face : wall.faces) {
    const jump::Extent box = jump::box_of(face, false);
    wall.low = std::min(wall.low, box.xlo);
    wall.high = std::max(wall.high, box.xhi);
  }
}

/** Let the gates whose turn it is look at the discs of all ranks. */
void FixJumpStep::move_gates()
{
  for (auto &wall : walls) {
    auto &hold = wall.hold;
    if (!hold.looks(update->ntimestep)) continue;
    std::vector<double> here(hold.bins, 0.0), all(hold.bins);
    for (int i = 0; i < atom->nlocal; i++) {
      if (pair->is_fixed(i)) continue;
      const double diameter = 2.0 * pair->radius_of(i);
      hold.add(here, pair->disc[i].x, diameter * diameter);
    }
    MPI_Allreduce(here.data(), all.data(), (int) hold.bins, MPI_DOUBLE, MPI_SUM, world);
    wall.motion.pushed.speed[1] = hold.look(all, wall.motion.pushed.place[1], update->dt);
  }
}
