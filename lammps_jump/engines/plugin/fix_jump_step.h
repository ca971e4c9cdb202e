// SPDX-License-Identifier: GPL-2.0-or-later
/* fix ID all jump/step [gravity GX GY] [walls N NAME...] [went WALL VX VY SPIN]... [sizes COUNT DENSITY] [slots S]
                        [bodies EVERY FILE LIMIT] [contacts EVERY FILE] [poses EVERY FILE]
                        [probe EVERY NAME...]                                   (probe comes last)

   One pass for what a step of discs needs besides the pairs of `pair_style jump/disc`, which must be in use: its file has the walls
   with their faces, laws and motions, the bodies, the tailgates and the sizes of discs that come.

   - velocity Verlet, as fix nve (with spin: as fix nve/sphere disc, I = m R^2/2), by the core (step/integrate.h); gravity is
     among the forces of the core and not in LAMMPS' array;
   - walls: where they are, their forces, lids, bodies and tailgates are those of the core (step/wall_forces.cpp, walls/bodies.h).
     NAMES are those of all of them in the order of the file; a wall that `went` on in an earlier run had these speeds at its end.
   - bodies: a row of each body goes to FILE every EVERY steps. An overlap of bodies beyond LIMIT ends the run.
   - sizes: discs are inserted with the largest diameter. At the end of a step that is a multiple of the interval of the file new
     ones get their own diameter d by id, COUNT of which are known, and the mass DENSITY d^2.
   - slots: each disc keeps S of them, of four numbers: the array of the fix. A row holds S partners (whole numbers of 64 bits), then
     as many arc lengths of the foot, elongations of the tangential and of the rolling spring, m. The law history needs them.
   - contacts: those of each step that is a multiple of EVERY, with their forces, go to FILE (ContactRow).
   - poses: a row of time, name, displacement and turn of each lid, tailgate and body goes to FILE at such a step.
   - probes: mean over each window of EVERY steps of the force ON the wall and of its moment (counter-clockwise).

   Global scalar: the largest overlap, m. Global vector: for each probe fx, fy (N) and moment (N m), per metre of width;
   where any wall moves, then the power of the probed wall on the discs (W). After the probes comes the state of each
   lid, gate and body (`pushed_state`), and what corners remember. A restart begins a new window and keeps the lids. */

#ifndef LMP_FIX_JUMP_STEP_H
#define LMP_FIX_JUMP_STEP_H

#include "step/pair_search.h"    // before the core: its templates take vectors

#include "fix.h"
#include "step/step.h"
#include "step/image.h"

#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

namespace jump {

/* Contacts of a frame with their forces, as lammps_jump/dump/contacts.py reads them. */

/** Id of the disc that the force acts on, that of the other or -1 - w of a wall; point, force, power (not known here). */
struct ContactRow {
  int32_t one, other;
  float x, y, fx, fy, power;
};

/** Whether the rows of a step have been put into a file; the first step begins it anew. */
inline bool put_rows(const std::string &name, int64_t step, const std::vector<ContactRow> &rows)
{
  static_assert(sizeof(ContactRow) == 28, "rows are read in 28 bytes");
  FILE *const file = std::fopen(name.c_str(), step == 0 ? "wb" : "ab");
  if (!file) return false;
  char head[20] = {'L', 'J', 'C', '1'};
  const int64_t count = (int64_t) rows.size();
  std::memcpy(head + 4, &step, 8);
  std::memcpy(head + 12, &count, 8);
  bool done = std::fwrite(head, 1, sizeof head, file) == sizeof head;
  done = done && std::fwrite(rows.data(), sizeof(ContactRow), rows.size(), file) == rows.size();
  return !std::fclose(file) && done;
}

}    // namespace jump

namespace LAMMPS_NS {

class FixJumpStep : public Fix {
 public:
  FixJumpStep(class LAMMPS *, int, char **);
  ~FixJumpStep() override;
  int setmask() override;
  void end_of_step() override;
  void init() override;
  void setup(int) override;
  void initial_integrate(int) override;
  void post_force(int) override;
  void final_integrate() override;
  void post_run() override;
  double compute_scalar() override;
  double compute_vector(int) override;
  void write_restart(FILE *) override;
  void restart(char *) override;
  void grow_arrays(int) override;
  void copy_arrays(int, int, int) override;
  void set_arrays(int) override;
  int pack_exchange(int, double *) override;
  int unpack_exchange(int, double *) override;
  int pack_restart(int, double *) override;
  void unpack_restart(int, int) override;
  int size_restart(int) override { return 1 + size_peratom_cols; }
  int maxsize_restart() override { return 1 + size_peratom_cols; }

 private:
  static constexpr int SLOT = 4, MOST_SLOTS = 64;    // numbers of a slot

  class PairJumpDisc *pair = nullptr;
  jump_state *state = nullptr;    // of the pair style
  jump_events *events = nullptr;
  double gx = 0.0, gy = 0.0;

  // walls
  std::vector<std::string> names;
  std::vector<int64_t> pushed_walls;    // walls that are pushed
  /** Speeds that a wall had at the end of an earlier run. */
  struct Went {
    int wall;
    double speed[3];
  };
  std::vector<Went> went;
  bigint near_order = -1;
  bool walls_left = false;      // a wall has gone further than the lists of near discs allow
  double near_moved = 0.0;      // bound of a disc's way since then, and that which the lists allow, m
  double near_margin = 0.0;
  /** What bodies have felt since the last row of their file: force of the discs. */
  std::vector<jump::Sum> felt;
  int64_t felt_steps = 0;

  // sizes
  double density = 0.0;
  int64_t size_count = 0;     // of ids whose diameter is known
  tagint sized = 0;           // discs up to this id have their own size
  bool newcomers = true;      // discs have come since the sizes were last looked at

  bool others_push = false;     // other fixes add forces: fix gravity, which pours need
  bool others_look = false;     // other fixes act on the discs in each step
  std::vector<Fix *> renewing, ending;    // fixes that ask for sorted discs; that act at the end of some steps
  bool lammps_is_stale = false;    // its arrays are out of date: the discs are as the pair style has packed them
  bool starts = false;          // the next step is the first of a run
  bigint paced_order = -1;    // of the discs in the step before

  int probe_every = 1;
  int columns = 3;                            // of a probe
  std::vector<int> probed;                    // wall of each probe
  std::vector<double> mean;                   // this rank: last full window
  bigint window_steps = 0;
  /** A file, and the steps between what goes there; 0: nothing does. */
  struct OutFile {
    int every = 0;
    std::string file;

    bool is_due(bigint step) const { return every > 0 && step % every == 0; }
  };
  OutFile contacts, poses, rows_of_bodies;
  double body_limit = 0.0;    // largest overlap of bodies, m

  int add_walls(int, int, char **);
  int add_went(int, int, char **);
  int add_sizes(int, int, char **);
  int add_slots(int, int, char **);
  int add_file(OutFile &, int, int, char **) const;
  int add_contacts(int a, int narg, char **arg) { return add_file(contacts, a, narg, arg); }
  int add_poses(int a, int narg, char **arg) { return add_file(poses, a, narg, arg); }
  int add_bodies(int, int, char **);
  int add_probes(int, int, char **);
  int wall_called(const char *) const;

  static constexpr int PUSHED_WORDS = 18;
  double pushed_state(int) const;
  const jump::TailgateController *tailgate_of(int64_t) const;
  template <class Run> void each_number_of_bodies(const Run &);
  bool take_away();
  bool is_worn() const;
  void find_near();
  void push_walls();
  void push_bodies();
  void end_pushed();
  void step_back(const Went &);
  void require_sound_bodies() const;
  void require_off_seam() const;
  void move_gates();
  void centre_of(int64_t, double *) const;
  void write_bodies(bool);
  void list_contacts(std::vector<jump::ContactRow> &);
  void write_contacts();
  void write_poses() const;
  void close_window();

  void watch_others();
  bool is_seen_before_forces() const;
  bool is_seen_at_end() const;
  bool waits() const;
};

}    // namespace LAMMPS_NS

#endif
