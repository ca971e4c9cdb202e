// SPDX-License-Identifier: GPL-2.0-or-later
/* Which faces of a wall are near a disc: cells that list the faces near them, in the wall's own frame.

   lammps_jump/scene/faces.py states the same; tests compare the two. */

#ifndef JUMP_CORE_NEAR_H
#define JUMP_CORE_NEAR_H

#include "walls/faces.h"

namespace jump {

/** xlo, xhi, ylo, yhi, m. */
struct Extent {
  double xlo, xhi, ylo, yhi;

  bool holds(double x, double y) const { return x > xlo && x < xhi && y > ylo && y < yhi; }
};

/** Cells of one wall; a wall of few faces has one cell, and `inverse` is 0. */
struct NearGrid {
  double xlo, ylo, inverse;    // lower left corner, m, and cells per metre
  int64_t columns, rows;

  int64_t column(double x) const { return inverse > 0.0 ? inside((x - xlo) * inverse, columns) : 0; }
  int64_t row(double y) const { return inverse > 0.0 ? inside((y - ylo) * inverse, rows) : 0; }
  int64_t cell(double x, double y) const { return column(x) * rows + row(y); }

 private:
  static int64_t inside(double place, int64_t count)
  {
    const int64_t found = (int64_t) place;
    return found < 0 ? 0 : found > count - 1 ? count - 1 : found;
  }
};

/** Whether a disc may touch a face before it has moved by the margin that `reach` (m) and the box hold. */
inline bool is_near(const WallFaces &wall, int64_t face, const Extent &box, double px, double py, double reach)
{
  if (!box.holds(px, py)) return false;
  const double away = wall.away(face, px, py);
  return away < reach && (wall.deep || away > -reach);
}

/** Whether a point is beside a straight face and a margin (m) from its ends: its line is then enough. */
inline bool is_plain(const Face &f, double px, double py, double margin)
{
  if (f.kind != SEGMENT) return false;
  return (f.at_start == ENDLESS || f.tx0 * (px - f.x0) + f.ty0 * (py - f.y0) > margin) &&
         (f.at_end == ENDLESS || f.tx1 * (px - f.x1) + f.ty1 * (py - f.y1) < -margin);
}

/** Call mark(cell) for each cell near a face. */
template <class Mark>
inline void mark_cells(const WallFaces &wall, int64_t face, const Extent &box, const NearGrid &grid, double reach, Mark &&mark)
{
  const double far = reach + std::sqrt(0.5) / grid.inverse;
  const auto from = [](double place) { return place > 0.0 ? (int64_t) place : 0; };
  const auto to = [](double place, int64_t count) { return least((int64_t) place + 1, count); };
  const int64_t last_column = to((box.xhi - grid.xlo) * grid.inverse, grid.columns);
  const int64_t last_row = to((box.yhi - grid.ylo) * grid.inverse, grid.rows);
  for (int64_t column = from((box.xlo - grid.xlo) * grid.inverse); column < last_column; column++)
    for (int64_t row = from((box.ylo - grid.ylo) * grid.inverse); row < last_row; row++) {
      const double px = grid.xlo + ((double) column + 0.5) / grid.inverse;
      const double py = grid.ylo + ((double) row + 0.5) / grid.inverse;
      if (std::fabs(wall.away(face, px, py)) <= far) mark(column * grid.rows + row);
    }
}

}    // namespace jump

#endif
