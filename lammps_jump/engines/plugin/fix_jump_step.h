// SPDX-License-Identifier: GPL-2.0-or-later
/* fix ID all jump/step [gravity GX GY] [k_wall K gamma_wall GN gammat_wall GT mu_wall MU]
                        [wall NAME X0 Y0 DEEP N FACE... [law K GN GT MU] [roll MUR] [seam] [until STEP]
                              [move CX CY START N ROW...] [lid CX CY START MASS FX FY X Y BEGIN]
                              [hold CX CY START FIRST EVERY LOW HIGH BINS TARGET LEVEL P I SPEED LOWEST HIGHEST]
                              [body CX CY START MASS INERTIA FX FY AX AY X Y TURN BEGIN VX VY SPIN]
                              [went X Y TURN VX VY SPIN HX HY HSPIN] [saw AREA]]...
                        [bodies EVERY FILE LIMIT DAMPING N [X Y R TX0 TY0 TX1 TY1 WALL]... M [V W K C CT LAG MU]...
                         [held N [CORNER PARTNER FOOT SPRING ROLL]...]]
                        [sizes EVERY DENSITY SHIFT TURN N [BEGIN END LOW SLOPE]...] [known ID]
                        [slots S] [contacts EVERY FILE] [poses EVERY FILE]
                        [probe EVERY NAME...]                                   (probe comes last)

   One pass for what a step of discs needs besides the pairs of `pair_style jump/disc` (which must be in use,
   and gives law, touch, spin, masses and diameters):

   - velocity Verlet, as fix nve (with spin: as fix nve/sphere disc, I = m R^2/2); gravity enters the velocities
     here and not the force array;
   - walls: N faces, by the rule of core/walls/faces.h. A face is 22 numbers, the columns of `Faces` in
     lammps_jump/scene/chains.py without the wall's own: kind, run, loop, before, after, at_start, at_end (neighbours
     count from 0 within the wall), then its shape. DEEP 1: a centre behind a face is pushed back from any depth,
     0: from less than its radius. The push goes on growing behind a face. GN, GT in 1/s: force = M GN v.
     With sizes M, GN and GT are of the nominal disc; GN and GT of others are theirs times sqrt(M/m).
     A wall with a `law` has its own in place of that of the other walls, one with `roll` its own friction of rolling, one with `seam` crosses that of a periodic x. One with `until STEP` is felt by the forces of
     the steps before STEP. One with `move` follows N rows of 25 numbers (core/walls/motion.h), turning about (CX, CY); one with
     `lid` is pushed by the discs and by a force, and free along x and y (1) or not (0). t = 0 is at the step START.
     One with `hold` is a tailgate (core/walls/tailgate_controller.h): from the step FIRST on it looks every EVERY steps at the discs between
     LOW and HIGH, and goes along y at a speed up to SPEED, within its way from LOWEST to HIGHEST.
     One with `body` is pushed by what touches it, with a weight that acts at (AX, AY) from the point (CX, CY), free along x and
     y and to turn, released at BEGIN with these velocities. Its law is that of a wall: dashpots are of the
     effective mass of each contact (core/walls/effective.h).
     A lid, gate or body with `went` begins where an earlier run has left it: displaced, with the speeds of its last step and
     of the half step before. A gate has seen AREA then.
   - bodies: N corners of walls as discs, and M contacts of a corner of wall V with faces of W (core/walls/bodies.h). Rows of all bodies
     go to FILE every EVERY steps. An overlap beyond LIMIT ends the run. N contacts of corners are `held` from an earlier run.
   - sizes: discs are inserted with the largest diameter. At the end of a step that is a multiple of EVERY new ones get
     their own diameter d by id, and the mass DENSITY d^2: u is the fraction of (id + SHIFT) TURN, d is
     LOW + SLOPE (u - BEGIN) in the one of N pieces with BEGIN <= u < END. Discs up to ID keep the diameter they have.
   - slots: each disc keeps S of them, of four numbers (disc_slots.h): the array of the fix. The law history needs them.
   - contacts: those of each step that is a multiple of EVERY, with their forces, go to FILE (record.h).
   - poses: a row of time, name, displacement and turn of each lid, tailgate and body goes to FILE at such a step.
   - probes: mean over each window of EVERY steps of the force ON the wall and of its moment (counter-clockwise)
     about (X0, Y0).

   Global scalar: the largest overlap, m. Global vector: for each probe fx, fy (N) and moment (N m), per metre of width;
   where any wall moves, the power of the probed wall on the discs (W) behind them. Behind the probes stands the state of each
   lid, gate and body (`pushed_state`), and what corners remember. A restart begins a new window and keeps the lids. */

#ifndef LMP_FIX_JUMP_STEP_H
#define LMP_FIX_JUMP_STEP_H

#include "disc_law.h"
#include "walls/effective.h"
#include "fix.h"
#include "walls/tailgate_controller.h"
#include "near_faces.h"
#include "contact/history.h"
#include "step_bodies.h"
#include "walls/wall.h"

#include <array>

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
  static constexpr int SLOT = 4;    // numbers of a slot
  static constexpr size_t FEW_NEAR = 128;    // discs beside a wall for which threads are not worth while
  // diameters; of walls of many faces each one more near a disc costs time
  static constexpr double NEAR_MARGIN = 0.5, NEAR_MARGIN_OF_MANY = 0.15;

  /** How a wall moves: along the rows of a track, or pushed by the discs. */
  struct Motion {
    bool moves = false, is_lid = false, is_body = false;
    double cx = 0.0, cy = 0.0;    // point of turning where the case has it, m
    double start = 0.0;           // step of t = 0
    std::vector<jump::TrackRow> track;
    jump::Load load{};
    jump::Pushed pushed{};        // by the discs of all ranks
    bool went = false;            // comes from an earlier run
    double speed[3] = {};         // at the last step of that
    jump::Placed placed{{}, 1.0, 0.0, {}, {}};
    jump::Pose listed{};
  };
  struct Wall {
    std::string name;
    double x0, y0;          // point that the moment is about
    bigint until;           // first step without the wall
    int probe;              // row of the probe, -1 for none
    bool own;               // has a law of its own: k, gamma, gamma_t, mu
    double numbers[4];
    double rolling;         // friction coefficient of rolling, below 0: that of the pairs
    bool seam;              // crosses the seam of a periodic channel: a foot on it repeats with the period
    std::vector<double> chain, around;    // of each face: what stands for its chain in slots, length of a closed one, m
    jump::DiscLaw law;
    Motion motion;
    double far;             // largest distance of a face from the point of turning, m
    std::vector<jump::Face> faces;
    bool deep = false;      // pushes from any depth behind its faces
    jump::NearFaces near;   // discs that can touch it before they have moved by the margin
    double low = 0.0, high = 0.0;    // ends along x of one that discs push, where the case has it, m
    jump::TailgateController hold{};

    jump::WallInPlace in_place() const
    {
      return {{faces.data(), deep}, motion.moves ? &motion.placed : nullptr, motion.cx, motion.cy, motion.is_body};
    }
  };
  /** What disc i remembers of its contact with a face; (x, y): its place in the wall's own frame, m. */
  class AtomWallHistory {
   public:
    AtomWallHistory(const FixJumpStep &fix, const Wall &wall, int i, int face, double x, double y)
        : fix(fix), wall(wall), i(i), face(face), x(x), y(y)
    {
    }
    jump::Stretch<double> begin(double slip);
    void end(const jump::Stretch<double> &) const;

   private:
    const FixJumpStep &fix;
    const Wall &wall;
    int i, face, slot = jump::FULL;
    double x, y;
  };
  /** Discs of one share of all, by number: their diameters lie on a line over the quantile of their ids. */
  struct SizePiece {
    double begin, end, low, slope;
  };

  class PairJumpDisc *pair = nullptr;
  double gx = 0.0, gy = 0.0;
  double k = 0.0, gamma = 0.0, gamma_t = 0.0, mu = 0.0;
  std::vector<Wall> walls;
  bool any_moves = false;
  int columns = 3;            // of a probe
  double density = 0.0, shift = 0.0, turn = 0.0;    // of sizes
  std::vector<SizePiece> pieces;
  tagint known = 0;           // discs up to this id begin with their own size
  tagint sized = 0;           // discs up to this id have their own size
  bool newcomers = true;      // discs have come since the sizes were last looked at
  bigint near_order = -1;
  bool others_push = false;     // other fixes add forces: fix gravity, which pours need
  bool others_look = false;     // other fixes act on the discs in each step
  std::vector<Fix *> renewing, ending;    // fixes that ask for sorted discs; that act at the end of some steps
  bool lammps_is_stale = false;    // its arrays are out of date: the discs are as the pair style has packed them
  bool starts = false;          // the next step is the first of a run
  bigint paced_order = -1;    // of the discs in the step before
  double near_margin = 0.0;    // way of a disc in x or y that lists of near discs allow
  double near_moved = 0.0;    // bound of a disc's displacement in x or y since the lists of near discs

  int probe_every = 1;
  std::vector<int> probed;                    // wall of each probe
  std::vector<double> window, mean;           // this rank: running sums and last full window's mean
  bigint window_steps = 0;
  /** A file, and the steps between what goes there; 0: nothing does. */
  struct OutFile {
    int every = 0;
    std::string file;

    bool is_due(bigint step) const { return every > 0 && step % every == 0; }
  };
  OutFile contacts, poses;
  int chains = 0;                             // of all walls
  jump::StepBodies bodies;

  int add_wall(int, int, char **);
  jump::Face face_of(const Wall &, int, int, char **) const;
  int add_pieces(int, int, char **);
  int add_slots(int, int, char **);
  int add_file(OutFile &, int, int, char **) const;
  int add_contacts(int a, int narg, char **arg) { return add_file(contacts, a, narg, arg); }
  int add_poses(int a, int narg, char **arg) { return add_file(poses, a, narg, arg); }
  int add_probes(int, int, char **);
  void number_chains(Wall &);
  double diameter_of(tagint) const;
  double spin_rate(int) const;
  int add_motion(Wall &, int, int, char **) const;
  int add_lid(Wall &, int, int, char **) const;
  int add_hold(Wall &, int, int, char **) const;
  int add_body(Wall &, int, int, char **) const;
  int add_went(Wall &, int, int, char **) const;
  int add_saw(Wall &, int, int, char **) const;
  int add_held(int, int, char **);
  void step_back(Motion &) const;
  static constexpr int PUSHED_WORDS = 18;
  double pushed_state(int) const;
  int add_corners(int, int, char **);
  double far_of(const Wall &) const;
  void prepare_bodies();
  void find_corners();
  void push_bodies();
  void require_sound_bodies();
  void centre_of(const Wall &, double *) const;
  jump::Numbers<double> numbers_at_body(const Wall &, const jump::Numbers<double> &, int, const jump::AtWall<double> &) const;
  void write_bodies(bool);
  void pack_bodies(std::vector<double> &) const;
  const double *unpack_bodies(const double *);
  void note_ends(Wall &) const;
  void move_gates();
  bool is_there(const Wall &) const;
  void place_walls();
  void require_off_seam(const Wall &) const;
  bool is_worn() const;
  void find_near();
  void push_lids();
  /** Least and largest velocities of some discs, m/s. */
  struct alignas(64) SpeedRange {
    double lo[2], hi[2];
  };
  using Drift = void (FixJumpStep::*)(const int *, int, int, SpeedRange &);
  template <bool SIZES, bool STAYS, bool OWN, bool SEEN> void drift(const int *, int, int, SpeedRange &);
  Drift drift_of(bool, bool) const;
  void watch_others();
  bool is_seen_before_forces() const;
  bool is_seen_at_end() const;
  bool waits() const;
  void end_steps();
  void kick(int, int);
  void turn_discs(const int *, int, int);
  void write_contacts();
  void write_poses();
  void push(Wall &);
  template <class Law> void push(Wall &, const Law &);
  template <class Law> void push(const Wall &, const Law &, int, double *);
  template <class Law>
  void touch(const Wall &, const Law &, int, const jump::FaceContact &, double, double, double *);
};

}    // namespace LAMMPS_NS

#endif
