// SPDX-License-Identifier: GPL-2.0-or-later
/* pair_style jump/disc FILE [fixed FIRST LAST]
   pair_coeff * *

   Contact forces between discs. FILE is the image of a scene without discs (engines/native/image.py): the state of the core with
   the law, the walls and all that belongs to them, as the native engine has it. The discs are LAMMPS'. They are equal, or have radii
   of their own up to half of the largest diameter; their mass is that of the image, and goes by the square of the radius. Discs
   with ids from FIRST to LAST stay where they are. What contacts remember lies in slots of fix jump/step: of two discs the one with
   the larger id remembers; on several ranks or with periodic x both do. `fix jump/step` moves the discs and shares the arrays. The
   style gives no energy and no virial: their sums are NaN, and computes of them for each disc are refused.

   The style keeps a neighbour list of its own (cells of the plane, one flat list of pairs whose rims are closer than
   L) and asks LAMMPS for none. The list holds until the discs can have moved L against one another. That is bounded by
   the sum over the steps of dt times the range of the velocities (all the discs of a jet move together: only the range
   counts). On one rank it also outlives a reneighbouring that only brought new discs.

   On several ranks the style exchanges the discs near the cuts itself (halo.h) and asks LAMMPS for no ghosts. Where x
   is periodic it does the same with the discs near the seam. It needs `processors * 1 1`, newton off and no periodic y;
   it sees to `comm_modify cutoff`. The list is then in two parts: contacts of local discs, which are computed while the
   messages travel, and contacts across the cuts. */

#ifndef LMP_PAIR_JUMP_DISC_H
#define LMP_PAIR_JUMP_DISC_H

#include "step/pair_search.h"    // before the core: its templates take vectors

#include "halo.h"
#include "pair.h"
#include "record.h"
#include "step/image.h"
#include "step/kinds.h"
#include "step/thread_tuner.h"

#include <atomic>

namespace LAMMPS_NS {

class PairJumpDisc : public Pair {
 public:
  /** What a contact reads of a disc, in half a cache line. */
  struct alignas(32) PackedDisc {
    double x, y, vx, vy;
  };

  PairJumpDisc(class LAMMPS *);
  ~PairJumpDisc() override;
  void compute(int, int) override;
  void settings(int, char **) override;
  void coeff(int, char **) override;
  void init_style() override;
  double init_one(int, int) override { return 0.0; }
  void read_restart(FILE *) override;

  // shared with fix jump/step

  jump::ThreadPool pool;
  jump::ThreadTuner tuner;
  jump::SceneImage scene;
  double mass = 0.0, largest = 0.0, skin = 0.0;    // of the largest disc: mass (kg/m) and diameter (m); m
  bool sizes = false, spin = false, springs = false;
  double **const *slots = nullptr;                   // the fix's array of what discs remember, which may move
  int slot_count = 0;                                // of a disc; a row has so many partners, feet, springs, rolling springs
  double largest_speed = 0.0;                        // all ranks, of the last force evaluation, m/s
  std::vector<PackedDisc, jump::LineAllocator<PackedDisc>> disc;         // local discs, then those of other ranks
  std::vector<double> spins;                         // rad/s, with spin
  // forces (x, y of each disc) and moments; not in LAMMPS' array, which it clears in one thread each step
  std::vector<double, jump::LineAllocator<double>> pushes;
  std::vector<double> turns;
  std::vector<double> radii, inverse_masses;         // with sizes; in the order of the discs
  std::vector<int64_t> ids;
  std::vector<int64_t> stays;                        // 1 of fixed discs, where there are some
  std::vector<int8_t> used;                          // whether a contact of this step has a slot
  tagint fixed[2] = {0, -1};                         // first and last id of discs that stay
  bigint order = 0;                                  // counts the changes of what the indices of discs mean
  double range_lo[2] = {0.0, 0.0}, range_hi[2] = {0.0, 0.0};    // least and largest velocity of the discs, this step

  std::vector<jump::ContactRow> *record = nullptr;   // takes the contacts of a frame in place of their forces

  void list_contacts(std::vector<jump::ContactRow> &);
  bool any_fixed() const { return fixed[1] >= fixed[0]; }
  jump_state &state() { return *scene.state; }
  void bind();
  double slope() const { return jump::slope_of(*scene.state, largest_speed * largest_speed); }
  bool goes_on() const { return scene.state->memory_step > 0.0; }
  bool is_fixed(int) const;
  void reserve(int);
  void pack_size(int);
  double largest_overlap() const;
  template <class Run> int in_parts(int, const Run &);
  template <class Run> int in_parts_of_list(const Run &);
  int number_of_parts() const { return divided == pool.size() && divided > 1 ? (int) parts.size() : 0; }
  int part_of(int i) const { return home[i]; }
  void keep_uncleared();
  void hand_over_forces();
  void take_forces();
  double radius_of(int i) const { return sizes ? radii[i] : 0.5 * largest; }
  double reach_of(int i, int j) const { return sizes ? radii[i] + radii[j] : largest; }

 private:
  std::vector<int> first, second;    // candidate pairs, flat, cell by cell
  size_t interior = 0, candidates = 0;    // pairs of local discs, which come first where there are others; and all
  double moved[2] = {0.0, 0.0};      // bound of the relative displacement of all discs since the list was built
  double moved_here[2] = {0.0, 0.0};    // … and of the local ones
  JumpHalo ring;
  std::vector<tagint> listed;        // ids of the local discs in the list, by index
  jump::SearchRoom search;
  int columns_along = 0, rows_up = 0;    // cells along x and y of the list
  std::vector<int> sorted;               // discs of the list in the order of its cells
  std::vector<double> sorted_x, sorted_y, sorted_radius;
  std::vector<int64_t> start;            // of the pairs of each of them
  std::vector<int> first_across, second_across;    // pairs across a cut, while the list is built

  void read_scene(const char *);
  void pack();
  void check_discs(int, int);
  bool keeps_order() const;
  jump::BoxOfPlaces box_around(int, double) const;
  size_t find_pairs(int);
  void build_list();
  size_t keep_local(size_t);
  void append_to_list(int);
  void widen_range();
  bool moved_by_others() const;
  bool worn(const double *) const;
  void update_list();
  void travel(double *) const;
  double halo_cut() const;
  void remember_order();
  double largest_squared_speed() const;
  void find_largest_speed();
  /** A force on a disc that two parts may have. */
  struct Late {
    int disc, order;    // the order is the place of the pair's first disc
    double fx, fy, moment;
  };
  /** A part of the discs, which a thread takes. */
  struct PairPart {
    std::vector<int> discs;            // local ones
    std::vector<int> first, second;    // its pairs
    size_t pairs = 0;
    std::vector<int> edge, across;     // discs of pairs over a cut: its own, those of others
    std::vector<size_t> over;          // such pairs
    std::vector<int> copy_of;          // of each disc of others: -N for the Nth copy
    int copies = 0;                    // the first copy
    std::vector<Late> late[2];         // with springs: at the cuts before and behind the part
  };
  struct PairBatch;
  static constexpr int BATCH = 256;    // contacts evaluated together: their arrays stay in the first-level cache
  static constexpr int LOCKS = 64;
  static constexpr int DISCS_A_LINE = 4;    // of memory, of pushes
  static constexpr int FLAT = 28;           // columns a row from which on parts are of columns (measured)
  static constexpr int LEAST_ROWS = 4, LEAST_COLUMNS = 8;    // of a part: no disc is beside two cuts
  static constexpr int ROOM_FOR_NEW = 1024; // local discs that may come before the list is divided anew
  std::vector<PairPart> parts;
  int divided = 0;                   // for how many threads the list is divided; 0: it is not
  size_t built = 0;                  // pairs that were found together, in the order of the cells; others come behind
  int room = 0;                      // of local discs, before the copies of the parts
  int first_group = 0;               // atom->nfirst, which is 0 while LAMMPS is to clear no forces
  std::vector<int> place;            // of each disc in the order of the cells
  std::vector<uint8_t> home, beside; // of each disc: its part; 1 + the part before the cut it is beside, or 0
  std::atomic_flag locks[LOCKS] = {};

  void evaluate(size_t, size_t);
  void divide(int);
  void fill(PairPart &, int);
  void take_copies(const PairPart &);
  void evaluate_list(size_t, size_t, PairPart *);
  template <bool SIZES, bool SPIN, bool MEMORY> void evaluate_list(size_t, size_t, PairPart *);
  template <bool SIZES, bool SPIN, bool MEMORY> void gather(PairBatch &, const PairPart *);
  template <bool SPIN> void recall(PairBatch &, int, bool, const PairPart *);
  template <bool SPIN> void remember(const PairBatch &);
  template <bool SPIN, bool MEMORY> void scatter(const PairBatch &, PairPart *);
  void add(PairPart &, int, int, const double *, double, double);
  void add_late();
  int64_t remembered(int, int, const PairPart *);
  void share_memory();
  void note(int, int, const double *);
};

/** Call run(from, to, part) for parts of the numbers below n, shared out among the threads; returns how many. */
template <class Run> int PairJumpDisc::in_parts(int n, const Run &run)
{
  const int count = n < 64 * pool.size() ? 1 : pool.size();
  const auto begin = [&](int part) { return (int) ((int64_t) n * part / count); };
  pool.run(count, [&](int part) { run(begin(part), begin(part + 1), part); });
  return count;
}

/** Call run(discs, count, part) for the parts of the discs, if there are some now; returns how many.

    Each thread has the discs whose contacts it sums: they stay in its cache, but for those at the edge. */
template <class Run> int PairJumpDisc::in_parts_of_list(const Run &run)
{
  const int count = number_of_parts();
  if (count == 0) return 0;
  pool.run(count, [&](int part) {
    for (const int i : parts[part].edge) {    // other threads have read them: ask for all at once
      __builtin_prefetch(&disc[i], 1);
      __builtin_prefetch(&pushes[2 * i], 1);
    }
    run(parts[part].discs.data(), (int) parts[part].discs.size(), part);
  });
  return count;
}

}    // namespace LAMMPS_NS

#endif
