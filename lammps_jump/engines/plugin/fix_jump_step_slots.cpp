// SPDX-License-Identifier: GPL-2.0-or-later
/* Slots of fix jump/step: what a disc remembers of its contacts. They lie in an array of the fix, so that LAMMPS sorts
   them with the discs, sends them to another rank with them, and saves them (what they hold: disc_slots.h). */

#include "fix_jump_step.h"

#include "atom.h"
#include "domain.h"
#include "error.h"
#include "memory.h"
#include "pair_jump_disc.h"

#include <algorithm>

using namespace LAMMPS_NS;

using jump::MOST_SLOTS;

int FixJumpStep::add_slots(int a, int narg, char **arg)
{
  const int slots = a < narg ? utils::inumeric(FLERR, arg[a], false, lmp) : 0;
  if (slots < 1 || slots > MOST_SLOTS)
    error->all(FLERR, "fix jump/step: slots {}; allowed is 1 to {}", slots, MOST_SLOTS);
  size_peratom_cols = maxexchange = SLOT * slots;
  peratom_flag = peratom_freq = create_attribute = restart_peratom = 1;
  FixJumpStep::grow_arrays(atom->nmax);
  for (int i = 0; i < atom->nlocal; i++) FixJumpStep::set_arrays(i);
  for (const int kind : {Atom::GROW, Atom::RESTART}) atom->add_callback(kind);
  return a + 1;
}

FixJumpStep::~FixJumpStep()
{
  if (!array_atom) return;
  for (const int kind : {Atom::GROW, Atom::RESTART}) atom->delete_callback(id, kind);
  memory->destroy(array_atom);
}

/** Number the chains of a wall, behind those of the walls before it. */
void FixJumpStep::number_chains(Wall &wall)
{
  const auto &faces = wall.faces;
  const int n = (int) faces.size();
  for (int first = 0, end; first < n; first = end) {
    double length = faces[first].length;
    for (end = first + 1; end < n && faces[end].before == end - 1; end++) length += faces[end].length;
    wall.chain.insert(wall.chain.end(), end - first, -1.0 - chains++);
    wall.around.insert(wall.around.end(), end - first, wall.seam ? domain->prd[0] : faces[first].before >= 0 ? length : 0.0);
  }
}

jump::Stretch<double> FixJumpStep::AtomWallHistory::begin(double slip)
{
  auto &slots = fix.pair->slots;
  const double foot = jump::foot_of(wall.faces[face], x, y);
  const double limit = 0.5 * fix.pair->radius_of(i) + std::fabs(slip) * wall.law.choice.time_step;
  slot = slots.of(i, wall.chain[face], foot, limit, wall.around[face]);
  if (slot != jump::FULL) return {*slots.spring(i, slot), *slots.roll(i, slot)};
  if (slots.full >= 0)
    fix.error->one(FLERR, "jump/disc: disc {} touches more than the {} others it can remember: contacts are too deep",
                   fix.atom->tag[i], slots.number);
  return {0.0, 0.0};
}

void FixJumpStep::AtomWallHistory::end(const jump::Stretch<double> &held) const
{
  if (slot == jump::FULL || !(wall.law.choice.time_step > 0.0)) return;
  *fix.pair->slots.spring(i, slot) = held.slide;
  *fix.pair->slots.roll(i, slot) = held.roll;
}

void FixJumpStep::grow_arrays(int room)
{
  memory->grow(array_atom, room, size_peratom_cols, "jump/step:slots");
}

void FixJumpStep::copy_arrays(int from, int to, int)
{
  std::copy_n(array_atom[from], size_peratom_cols, array_atom[to]);
}

/** A new disc has no contacts, and waits for its own size. */
void FixJumpStep::set_arrays(int i)
{
  newcomers = true;
  if (array_atom) std::fill_n(array_atom[i], size_peratom_cols, 0.0);
}

int FixJumpStep::pack_exchange(int i, double *to)
{
  std::copy_n(array_atom[i], size_peratom_cols, to);
  return size_peratom_cols;
}

int FixJumpStep::unpack_exchange(int i, double *from)
{
  std::copy_n(from, size_peratom_cols, array_atom[i]);
  return size_peratom_cols;
}

int FixJumpStep::pack_restart(int i, double *to)
{
  *to = size_restart(i);
  pack_exchange(i, to + 1);
  return size_restart(i);
}

/** The numbers of this fix stand behind those of the `nth` fixes before it, each led by its count. */
void FixJumpStep::unpack_restart(int i, int nth)
{
  const double *from = atom->extra[i];
  for (int n = 0; n < nth; n++) from += (int) *from;
  std::copy_n(from + 1, size_peratom_cols, array_atom[i]);
}
