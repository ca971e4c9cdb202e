// SPDX-License-Identifier: GPL-2.0-or-later
/* The native engine's state as Python binds it (engines/native/bound.py): pointers into its arrays, NULL where a scene
   lacks what they are for. Arrays are described where Python makes them, in discs.py, walls.py and arrays.py. */

#ifndef JUMP_CORE_NATIVE_H
#define JUMP_CORE_NATIVE_H

#include "api.h"
#include "walls/faces.h"
#include "contact/law.h"
#include "walls/motion.h"

#include <cstdint>

struct jump_state;

namespace jump {

/** A corner of a wall as a disc, in the wall's own frame (m); of an arc, the directions at its two ends, else 0. */
struct Corner {
  double x, y, radius, tx0, ty0, tx1, ty1;
  int64_t wall;    // -1: it is gone

  /** Whether the wall is there in this direction from the centre. */
  bool holds(double dx, double dy) const
  {
    if (tx0 == 0.0 && ty0 == 0.0) return true;
    return tx0 * dx + ty0 * dy >= 0.0 && tx1 * dx + ty1 * dy < 0.0;
  }
};

/** Contact of a corner with a face: its law, whose dashpot and slope of the viscous ramp are over the root of the effective
    mass, and what the dashpot is less, because it sees the half step. */
struct BodyLaw {
  LawNumbers law;
  double lag;
};

/** Velocities of the discs, m/s, and spins, rad/s (NULL: none). */
struct ContactVelocities {
  const double *vx, *vy, *spin;
};

/** Work that dashpots and friction have taken, and that walls have done, J per m of width. */
struct WorkParts {
  double dashpots, friction, walls;
};

/** All of it since the start, and the last step's part that is due to walls. */
struct Work {
  WorkParts whole, of_walls;
};

/** What `StationLedger` of engines/native/ledger.py sums; it has the same numbers. */
enum StationSum { MASS_LEFT, MASS_RIGHT, CARRIED, CONTACTS, WALLS, DASHPOTS, FRICTION, BEGAN, HELD };

class ThreadPartition;

}    // namespace jump

extern "C" {

/** Stretches of walls: those of a wall are first[wall] .. first[wall + 1); ends along its outline, m; sums of the force on it
    across and along (N/m) and of the first times the place (N). */
struct jump_pressed {
  int64_t stretches;
  const int64_t *first;
  const double (*ends)[2];
  double (*sums)[3];
};

struct jump_grid {
  const jump::Face *faces;
  const double *box;
  const int64_t *start, *listed;
  int64_t deep, columns, rows, first_cell;
  double xlo, xhi, ylo, yhi, left, low, inverse, reach;
};

// what making lists anew takes: the domain, the skin and the diameter of the largest disc (m); all arrays of the discs with their
// words of a disc, those first that a sort takes along; the cells of each wall, and the room of near_last and of near_faces
struct jump_lists {
  double xlo, xhi, ylo, yhi, skin, widest;
  int64_t columns, all_columns;
  int64_t **column;
  const int64_t *width;
  const jump_grid *grids;
  int64_t rows_room, faces_room;
  double *made;    // lists that were made in a step, and the seconds that they took
  double period;   // of a channel that begins at xlo, m; 0: it has none
  double *slope_work;    // takes the work of weight on discs that go round it, J per m of width
  const double (*ends)[2];    // of a channel: ends along x of walls that are pushed, where the case has them, m
  // of bodies: cells that find the faces near corners with their room, and whether those of one wall meet the faces of another
  const jump_grid *corner_grids;
  int64_t corner_rows_room, corner_faces_room;
  const int8_t *meets;
};

struct jump_state {
  // discs, and how many there is room for, in the list too
  int64_t n, disc_room;
  int64_t *ids;
  double *x, *y, *vx, *vy, *fx, *fy, *x0, *y0, *ux, *uy, *omega, *torque, *uomega, *dashpot_x, *dashpot_y, *friction_x, *friction_y,
      *radius;
  int64_t *fixed;
  // pairs: rows in use, those first of them that are sorted, number of the list, disc of each row (NULL: its number), what a row adds to x
  int64_t rows, sorted, listed_as;
  int32_t *owner;
  const double *shift;
  int64_t *start;
  int32_t *neighbours;
  int64_t room;
  // cells of the thesis' search; first NULL: a list
  double grid_x, grid_y, grid_inverse;
  int64_t grid_columns, grid_rows;
  int64_t *grid_first, *grid_used;
  // walls and the discs near them
  int64_t walls;
  const jump::Face *faces;
  const int64_t *deep;
  int8_t *gone;    // 1 of a wall that has been taken away
  const jump::LawNumbers *at_wall;
  const double (*about)[2];
  int64_t *near_rows;
  int32_t *near_discs;
  int8_t *near_plain;
  int64_t *near_last, *near_faces;
  jump::SumsOnWall *wall_sum;
  // moving walls; moving NULL: all are at rest
  const jump::TrackRow *track;
  const int64_t *track_first;
  int64_t *moving;
  const double (*centre)[2];
  jump::Placed *placed;
  jump::Pose *listed;
  const double *far;
  const jump::Load *load;
  jump::Pushed *pushed;
  jump::WallLoads *wall_loads;
  jump::StepClock *clock;
  // law of two discs; its friction is NaN where nothing rubs
  double diameter;
  jump::LawNumbers pair;
  double time_step, mass, inertia, weight_x, weight_y, reach2;
  // memory; partner NULL: none
  int64_t slots, slot_row;    // of a disc; numbers from those of a disc to those of the next
  int64_t *partner;
  double *sigma, *spring, *roll;
  int8_t *used;
  const int64_t *chain;
  const double *around;
  int64_t *full;
  double memory_step;
  jump::Work *work;    // ledger
  // bodies; corners NULL: there are none
  jump_state *corners;            // corners as discs: the walls near them, and what they remember
  const jump::Corner *corner;
  const jump::BodyLaw *between;   // by the walls of a corner and of a face
  double *deepest;                // largest overlap since it was looked at, m, the walls of its corner and of its face
  jump_lists *lists;              // NULL: lists are made anew by the caller alone
  jump_pressed *pressed;          // NULL: no pressure is requested
};

struct jump_stations {
  double left, width, speed;
  int64_t moved, pushed;
};

}

/** Threads of a simulation, by the words of `ThreadTuner::read`; how many there are now. */
JUMP_API jump::ThreadPartition *jump_partition(const char *threads);
JUMP_API void jump_free_partition(jump::ThreadPartition *partition);
JUMP_API int64_t jump_partition_threads(const jump::ThreadPartition *partition);

/** Step: see `advance` in native.cpp. */
JUMP_API int64_t jump_advance(jump_state *state, jump::ThreadPartition *partition, int64_t steps, int64_t forces_pending, int64_t *left);
JUMP_API void jump_place_walls(const jump_state *state, int64_t step);

/** Lists: see lists.cpp. */
JUMP_API int64_t jump_outside(int64_t n, const double *x, const double *y, const double *domain);
JUMP_API int64_t jump_list_pairs(jump_state *state, jump::ThreadPartition *partition);
JUMP_API double jump_closest(int64_t n, const double *x, const double *y, double px, double py);
JUMP_API int64_t jump_append_row(int64_t i, const double *x, const double *y, const double *radius, double reach,
                                 int64_t *start, int32_t *neighbours, int64_t room);
JUMP_API int64_t jump_search_cells(jump_state *state);

/** Walls: contacts of a disc (rows of gap, normal, angle), the foot on a face, cells of faces. */
JUMP_API int64_t jump_touching(const jump::Face *faces, int64_t deep, const int64_t *near, int64_t count, const double *disc,
                               double (*found)[4], int64_t *which);
JUMP_API double jump_foot_at(const jump::Face *face, double px, double py);
JUMP_API void jump_mark_cells(const jump_grid *grid, int64_t begin, int64_t end, int64_t *start, int64_t *listed);

/** Sums: see sums.cpp. */
JUMP_API double jump_elastic(const jump_state *state, jump::ThreadPartition *partition, const int8_t *mask, double *worst, int64_t *where);
JUMP_API int64_t jump_contacts(const jump_state *state, const jump::ContactVelocities *at_step, const jump::ContactVelocities *seen, int64_t (*who)[2],
                               double (*found)[5], int64_t room);
JUMP_API double jump_give_sizes(const jump_state *state, int64_t known, const double *radii);
JUMP_API void jump_between(const jump_state *state, const jump_stations *stations, double *sums);

namespace jump {
/** Rows of contacts with their forces: `who` holds two ids, or -1 - wall, `found` the point, force and power. */
class ContactRows {
 public:
  int64_t count = 0;
  bool is_short = false;

  ContactRows(int64_t (*who)[2], double (*found)[5], int64_t room) : who(who), found(found), room(room) {}

  void add(int64_t one, int64_t other, double x, double y, double fx, double fy, double power)
  {
    if (count == room) {
      is_short = true;
      return;
    }
    who[count][0] = one;
    who[count][1] = other;
    double *const row = found[count++];
    row[0] = x, row[1] = y, row[2] = fx, row[3] = fy, row[4] = power;
  }

 private:
  int64_t (*who)[2];
  double (*found)[5];
  int64_t room;
};

/** What `jump_contacts` does, with the slope of the sign law as it is given. */
int64_t list_contacts(const jump_state &s, double slope, const ContactVelocities &at_step, const ContactVelocities &seen, ContactRows record);

/** Elastic energy, J per m of width; the largest overlap, m, its disc and wall (-1: of two discs).

    With a mask, those of the contacts of these discs alone. Contacts of bodies with walls and each other count where all
    contacts do. */
double elastic_of(const jump_state &state, ThreadPartition &partition, const int8_t *mask, double *worst, int64_t *where);
}    // namespace jump

namespace jump {
/** Touching pairs by the thesis' contact search; false where a disc is outside the grid or the list is short. */
bool search_cells(jump_state &state);
/** Forces between bodies, and of bodies and walls. */
void body_forces(const jump_state &state, double slope);
/** Elastic energy of their contacts, J per m of width. */
double body_elastic(const jump_state &state);
}    // namespace jump

#endif
