// SPDX-License-Identifier: GPL-2.0-or-later
/* Lists of what is near walls: discs, and corners of bodies. The native engine and the plugin make them. */

#include "step/kinds.h"
#include "step/step.h"
#include "walls/faces.h"

namespace jump {

/** Discs near walls, row by row, and the faces near each (jump_list_near). */
struct NearRows {
  int32_t *discs;
  int8_t *plain;
  int64_t *last, *near, room[2], row, count;
};

/** List the discs near one wall, which place(i, x, y) puts where its frame has them; false where there is no room. */
template <class Place> static bool list_near(const jump_grid &g, int64_t n, NearRows &to, const Place &place)
{
  const WallFaces wall{g.faces, g.deep == 1};
  const NearGrid cells{g.left, g.low, g.inverse, g.columns, g.rows};
  const Extent all{g.xlo, g.xhi, g.ylo, g.yhi};
  const Extent *const box = reinterpret_cast<const Extent *>(g.box);
  for (int64_t i = 0; i < n; i++) {
    double px, py;
    place(i, px, py);
    if (!all.holds(px, py)) continue;
    const int64_t cell = g.first_cell + cells.cell(px, py), first = g.start[cell], end = g.start[cell + 1];
    if (to.row + 1 >= to.room[0] || to.count + end - first > to.room[1]) return false;
    const int64_t begin = to.count;
    for (int64_t p = first; p < end; p++)
      if (is_near(wall, g.listed[p], box[g.listed[p]], px, py, g.reach)) to.near[to.count++] = g.listed[p];
    if (to.count == begin) continue;
    to.discs[to.row] = (int32_t) i;
    to.plain[to.row] = to.count == begin + 1 && is_plain(g.faces[to.near[begin]], px, py, g.reach);
    to.last[++to.row] = to.count;
  }
  return true;
}

/** List what is near each wall that is there; place(view, wall, i, x, y) puts a disc or corner of `s` in the frame of a wall. */
template <class Place>
static bool list_near_walls(const jump_state &walls, jump_state &s, const jump_grid *grids, const int64_t room[2], const Place &place)
{
  NearRows to{s.near_discs, s.near_plain, s.near_last, s.near_faces, {room[0], room[1]}, 0, 0};
  for (int64_t wall = 0; wall < walls.walls; wall++) {
    const WallView view(walls, wall);
    const bool whole = walls.gone[wall] || list_near(grids[wall], s.n, to, [&](int64_t i, double &px, double &py) {
      place(wall, i, px, py);
      view.into_frame(px, py);
    });
    if (!whole) return false;
    s.near_rows[wall + 1] = to.row;
  }
  return true;
}

/** Faces that cells list, in all. */
static int64_t listed_faces(const jump_grid *grids, int64_t walls)
{
  int64_t most_faces = 0;
  for (int64_t wall = 0; wall < walls; wall++) {
    const int64_t cells = grids[wall].first_cell + most<int64_t>(grids[wall].columns * grids[wall].rows, 1);
    most_faces = most(grids[wall].start[cells], most_faces);
  }
  return most_faces;
}

/** List the corners of bodies and walls near each wall. */
static void list_corners(jump_state &s, Rooms &rooms)
{
  jump_lists &l = *s.lists;
  const auto place = [&](int64_t wall, int64_t i, double &px, double &py) {
    const Corner &corner = s.corner[i];
    px = py = NAN;    // near no wall
    if (corner.wall < 0 || s.gone[corner.wall] || !l.meets[corner.wall * s.walls + wall]) return;
    px = corner.x;
    py = corner.y;
    WallView(s, corner.wall).out_of_frame(px, py);
  };
  int64_t room[2] = {l.corner_rows_room, l.corner_faces_room};
  while (!list_near_walls(s, *s.corners, l.corner_grids, room, place))
    rooms.grow_near(*s.corners, room[0], room[1], listed_faces(l.corner_grids, s.walls));
  l.corner_rows_room = room[0];
  l.corner_faces_room = room[1];
}

void list_walls(jump_state &s, Rooms &rooms)
{
  jump_lists &l = *s.lists;
  for (int64_t wall = 0; wall < s.walls; wall++)
    if (s.moving && s.moving[wall] != STANDS) s.listed[wall] = s.placed[wall].now;
  int64_t room[2] = {l.rows_room, l.faces_room};
  const auto place = [&](int64_t, int64_t i, double &px, double &py) {
    px = s.x0[i];
    py = s.y0[i];
  };
  while (!list_near_walls(s, s, l.grids, room, place)) rooms.grow_near(s, room[0], room[1], listed_faces(l.grids, s.walls));
  l.rows_room = room[0];
  l.faces_room = room[1];
  if (s.corners) list_corners(s, rooms);
}

}    // namespace jump

using namespace jump;

#define JUMP_LIST_NEAR(FIELD) \
  FIELD(const jump_grid *, grid) FIELD(int64_t, n) FIELD(const double *, x) FIELD(const double *, y) \
  FIELD(int32_t *, discs) FIELD(int8_t *, plain) FIELD(int64_t *, last) FIELD(int64_t *, near) \
  FIELD(const int64_t *, room) FIELD(int64_t *, found)
JUMP_INPUT(jump_list_near, JUMP_LIST_NEAR)

/** List the discs near one wall and the faces near each.

    Row r of the list is disc discs[r] with the faces near[last[r] .. last[r + 1]). room: of `last` and of `near`; found: rows
    and faces to go on from, and those in the end; faces -1 where there is no room. */
JUMP_API void jump_list_near(const jump_list_near_input *input)
{
  JUMP_LIST_NEAR(JUMP_LOCAL)
  NearRows rows{discs, plain, last, near, {room[0], room[1]}, found[0], found[1]};
  const bool whole = list_near(*grid, n, rows, [=](int64_t i, double &px, double &py) {
    px = x[i];
    py = y[i];
  });
  found[0] = rows.row;
  found[1] = whole ? rows.count : -1;
}

/** Count the faces begin .. end near each cell in start[cell + 1]; with `listed`, list them from there. */
void jump_mark_cells(const jump_grid *g, int64_t begin, int64_t end, int64_t *start, int64_t *listed)
{
  const WallFaces wall{g->faces, false};
  const NearGrid cells{g->left, g->low, g->inverse, g->columns, g->rows};
  const Extent *const box = reinterpret_cast<const Extent *>(g->box);
  for (int64_t f = begin; f < end; f++)
    mark_cells(wall, f, box[f], cells, g->reach, [&](int64_t cell) {
      if (listed) listed[start[cell + 1]] = f;
      start[cell + 1]++;
    });
}
