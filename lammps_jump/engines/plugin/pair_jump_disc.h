// SPDX-License-Identifier: GPL-2.0-or-later
/* pair_style jump/disc FILE [fixed FIRST LAST]
   pair_coeff * *

   Contact forces between discs. FILE is the image of a scene without discs (engines/native/image.py): the state of the core with
   the law, the walls and all that belongs to them, as the native engine has it. The discs are LAMMPS'. They are equal, or have radii
   of their own up to half of the largest diameter; their mass is that of the image, and goes by the square of the radius. Discs
   with ids from FIRST to LAST stay where they are. What contacts remember lies in slots of fix jump/step: of two discs the one with
   the larger id remembers; on several ranks or with periodic x both do. `fix jump/step` moves the discs. The style gives no energy
   and no virial: their sums are NaN, and computes of them for each disc are refused.

   Between looks of LAMMPS the discs are those of the core's state, in the core's order: search of pairs, forces, drift and threads
   are the core's (core/step/). `origin` says which disc of LAMMPS each is. LAMMPS makes no neighbour list. That of the core
   holds until the discs can have moved the skin against one another. That is bounded by the sum over the steps of dt times the
   range of the velocities (all the discs of a jet move together: only the range counts). On one rank it also outlives a
   reneighbouring that only brought new discs.

   On several ranks the style exchanges the discs near the cuts itself (halo.h) and asks LAMMPS for no ghosts. Where x
   is periodic it does the same with the discs near the seam. It needs `processors * 1 1`, newton off and no periodic y;
   it sees to `comm_modify cutoff`. Contacts across the cuts have rows of their own after the others, which are computed while the
   messages travel. */

#ifndef LMP_PAIR_JUMP_DISC_H
#define LMP_PAIR_JUMP_DISC_H

#include "step/pair_search.h"    // before the core: its templates take vectors

#include "halo.h"
#include "pair.h"
#include "step/step.h"
#include "step/image.h"
#include "step/kinds.h"
#include "step/thread_partition.h"

namespace LAMMPS_NS {

class PairJumpDisc : public Pair {
 public:
  PairJumpDisc(class LAMMPS *);
  ~PairJumpDisc() override;
  void compute(int, int) override;
  void settings(int, char **) override;
  void coeff(int, char **) override;
  void init_style() override;
  double init_one(int, int) override { return 0.0; }
  void read_restart(FILE *) override;

  // shared with fix jump/step

  jump::SceneImage scene;
  jump::ThreadPartition partition;
  double largest = 0.0, skin = 0.0;    // diameter of the largest disc; m
  double largest_speed = 0.0;          // all ranks, of the last force evaluation, m/s
  double **const *slots = nullptr;     // the fix's array of what discs remember, which may move
  bool slots_are_old = false;          // the core has gone on since they were written
  bool walls_unseen = false;           // the memory does not know which discs are near walls
  tagint fixed[2] = {0, -1};           // first and last id of discs that stay
  bigint order = 0;                    // counts the changes of what the indices of discs mean
  jump::SpeedRange range;              // of the discs, this step

  bool any_fixed() const { return fixed[1] >= fixed[0]; }
  jump_state &state() const { return *scene.state; }
  int64_t origin(int64_t k) const { return table[0][k]; }    // the disc of LAMMPS
  double (*rows())[4] { return partition.rows(); }
  double slope() const { return jump::slope_of(*scene.state, largest_speed * largest_speed); }
  bool goes_on() const { return scene.state->memory_step > 0.0; }
  void reserve(int64_t);
  void store();
  void store_places();
  void store_memory();
  void keep_uncleared();
  void hand_over_forces();
  void take_forces();
  void take_motion();
  void put_motion();
  void put_motion_of_step();
  void put_slots();

 private:
  double moved[2] = {0.0, 0.0};      // bound of the relative displacement of all discs since the list was built
  double moved_here[2] = {0.0, 0.0};    // … and of the local ones
  JumpHalo ring;
  std::vector<int64_t *> table;      // arrays of the discs as the core sorts them; the first is `origin`
  std::vector<int64_t> widths, first_origin;
  std::vector<tagint> listed;        // ids of the local discs in the list, by the index of LAMMPS
  bool remembers_list = false;       // what pairs remember is in the order of the list that there is
  bool packed = false;               // the discs are newer in the arrays of the state than in rows
  int first_group = 0;               // atom->nfirst, which is 0 while LAMMPS is to clear no forces

  void read_scene(const char *);
  void take_tables();
  void take_disc(int);
  void take_slots();
  void pack();
  void check_discs(int, int) const;
  bool keeps_order() const;
  bool take_discs();
  void load(int64_t);
  void build_list();
  void list_across();
  void append_to_list(int);
  void widen_range();
  bool moved_by_others() const;
  bool is_fixed(tagint id) const { return id >= fixed[0] && id <= fixed[1]; }
  bool worn(const double *) const;
  void travel(double *) const;
  double halo_cut();
  double largest_squared_speed();
  void find_largest_speed();
  void share_memory();
  void begin_memory();
  void forces(jump::ListRows);
};

}    // namespace LAMMPS_NS

#endif
