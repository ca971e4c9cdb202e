// SPDX-License-Identifier: GPL-2.0-or-later
/* Arrays that have grown within the core. A host finds them by the pointers and rooms of its state, and may take copies into
   arrays of its own before it lets them go (`jump_forget_rooms`). */

#ifndef JUMP_CORE_ROOMS_H
#define JUMP_CORE_ROOMS_H

#include "step/native.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <vector>

namespace jump {

class Rooms {
 public:
  std::vector<int32_t> owner, right;    // of rows across the seam of a channel
  std::vector<double> shift;
  std::vector<double> windows;          // of probes that have ended: see `jump_windows`

  /** Half as much room again for discs and rows of their list. */
  void grow_discs(jump_state &s)
  {
    const int64_t more = s.disc_room + most<int64_t>(s.disc_room / 2, 64);
    for (int64_t k = 0; k < s.lists->all_columns; k++) {
      int64_t *&column = s.lists->column[k];
      const void *const before = column;
      grow(column, s.n * s.lists->width[k], more * s.lists->width[k]);
      each_disc_array(s, [&](auto *&array) {
        if (array == before) array = reinterpret_cast<std::decay_t<decltype(array)>>(column);
      });
    }
    if (s.used) grow(s.used, s.n * s.slot_row, more * s.slot_row);
    grow(s.start, s.rows + 1, more + 1);
    s.disc_room = more;
  }

  /** Twice the room for neighbours, `used` of which are kept. */
  void grow_neighbours(jump_state &s, int64_t used)
  {
    s.room *= 2;
    grow(s.neighbours, used, s.room);
  }

  /** More room for the discs near walls and the faces near these; nothing is kept. `faces` are those of the cells. */
  void grow_near(jump_state &s, int64_t &rows_room, int64_t &faces_room, int64_t faces)
  {
    rows_room = 2 * rows_room + 256;
    faces_room = 2 * faces_room + 4 * faces + 256;
    grow(s.near_discs, 0, rows_room);
    grow(s.near_plain, 0, rows_room);
    grow(s.near_last, 1, rows_room);
    grow(s.near_faces, 0, faces_room);
  }

  /** Keep the discs that do not leave, in their order. */
  static void keep(jump_state &s, const std::vector<int8_t> &leaves)
  {
    int64_t left = 0;
    for (int64_t k = 0; k < s.lists->all_columns; k++) {
      int64_t *to = s.lists->column[k];
      const int64_t *from = to, width = s.lists->width[k];
      for (int64_t i = 0; i < s.n; i++, from += width)
        if (!leaves[(size_t) i]) to = std::copy(from, from + width, to);
    }
    for (int64_t i = 0; i < s.n; i++) left += !leaves[(size_t) i];
    s.n = left;
  }

  /** Zeros in all arrays of the disc after the last. */
  static void clear_next(const jump_state &s)
  {
    for (int64_t k = 0; k < s.lists->all_columns; k++)
      std::fill_n(s.lists->column[k] + s.n * s.lists->width[k], s.lists->width[k], 0);
  }

  void forget()
  {
    grown.clear();
    owner.clear();
    right.clear();
    shift.clear();
  }

 private:
  std::map<const void *, std::vector<char>> grown;    // by where the state has the pointer to it

  template <class T> void grow(T *&array, int64_t used, int64_t room)
  {
    std::vector<char> longer((size_t) room * sizeof(T));
    if (used > 0) std::memcpy(longer.data(), array, (size_t) used * sizeof(T));
    std::vector<char> &held = grown[&array];
    held.swap(longer);
    array = reinterpret_cast<T *>(held.data());
  }

  /** Calls run(array) for the arrays of the discs that a state knows by name, but `used`, which is empty between steps. */
  template <class Run> static void each_disc_array(jump_state &s, const Run &run)
  {
    for (double **const of : {&s.x, &s.y, &s.vx, &s.vy, &s.fx, &s.fy, &s.x0, &s.y0, &s.ux, &s.uy, &s.omega, &s.torque, &s.uomega,
                              &s.dashpot_x, &s.dashpot_y, &s.friction_x, &s.friction_y, &s.radius, &s.sigma, &s.spring, &s.roll})
      run(*of);
    for (int64_t **const of : {&s.ids, &s.fixed, &s.partner}) run(*of);
  }
};

}    // namespace jump

#endif
