// SPDX-License-Identifier: GPL-2.0-or-later
/* A wall's faces, and the discs near them, as fix jump/step keeps them (the rules: core/walls/faces.h and near.h). */

#ifndef JUMP_NEAR_FACES_H
#define JUMP_NEAR_FACES_H

#include "walls/near.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace jump {

constexpr int FEW = 8;    // faces up to which a wall has no grid
constexpr double MOST_CELLS = 1e6;

/** Smallest box of a face; without end where it has none and, if `behind`, behind it. */
inline Extent box_of(const Face &f, bool behind)
{
  Extent box = {std::min(f.x0, f.x1), std::max(f.x0, f.x1), std::min(f.y0, f.y1), std::max(f.y0, f.y1)};
  const auto add = [&](double x, double y) {
    box = {std::min(box.xlo, x), std::max(box.xhi, x), std::min(box.ylo, y), std::max(box.yhi, y)};
  };
  const auto endless = [&](double towards_x, double towards_y) {
    if (std::fabs(towards_x) > 1e-12) add(std::copysign(NO_END, towards_x), f.y0);
    if (std::fabs(towards_y) > 1e-12) add(f.x0, std::copysign(NO_END, towards_y));
  };
  if (f.at_start == ENDLESS) {
    endless(f.tx0, f.ty0);
    endless(-f.tx0, -f.ty0);
  }
  if (f.kind == ARC)
    for (const auto &to : {std::pair{1, 0}, {0, 1}, {-1, 0}, {0, -1}}) {
      const double x = f.cx + std::fabs(f.radius) * to.first, y = f.cy + std::fabs(f.radius) * to.second;
      if (f.tx0 * (x - f.x0) + f.ty0 * (y - f.y0) > 0 && 0 > f.tx1 * (x - f.x1) + f.ty1 * (y - f.y1)) add(x, y);
    }
  if (behind) endless(f.ty0, -f.tx0);
  return box;
}

/** Cells that list the faces of a wall near them, and the discs near the wall with the faces near each. */
class NearFaces {
 public:
  std::vector<int> discs, last, near;    // row r: disc discs[r] with the faces near[last[r] .. last[r + 1])

  /** Prepare the search for a wall of n faces.

      margin: that from a face's box up to which discs are listed, m. Discs move by as much in x and in y before the
      rows are made anew. Their true distance then changes by sqrt(2) as much. */
  void prepare(const WallFaces &of, int n, double radius, double margin, double cell)
  {
    reach = radius + M_SQRT2 * margin;
    boxes.clear();
    all = {NO_END, -NO_END, NO_END, -NO_END};
    for (int f = 0; f < n; f++) {
      const Extent face = box_of(of.faces[f], of.deep);
      const double by = radius + margin;
      const Extent box = {face.xlo - by, face.xhi + by, face.ylo - by, face.yhi + by};
      boxes.push_back(box);
      all = {std::min(all.xlo, box.xlo), std::max(all.xhi, box.xhi), std::min(all.ylo, box.ylo),
             std::max(all.yhi, box.yhi)};
    }
    const double width = all.xhi - all.xlo, height = all.yhi - all.ylo;
    grid = {all.xlo, all.ylo, 0.0, 1, 1};
    cells.assign(1, {});
    if (n <= FEW || !std::isfinite(width) || !std::isfinite(height)) {
      for (int f = 0; f < n; f++) cells[0].push_back(f);
      return;
    }
    const double side = std::max(cell, std::sqrt(width * height / MOST_CELLS));
    grid.inverse = 1.0 / side;
    grid.columns = (int64_t) (width * grid.inverse) + 1;
    grid.rows = (int64_t) (height * grid.inverse) + 1;
    cells.assign((size_t) (grid.columns * grid.rows), {});
    for (int f = 0; f < n; f++)
      mark_cells(of, f, boxes[f], grid, reach, [&](int64_t at) { cells[(size_t) at].push_back(f); });
  }

  /** List the discs with these places. */
  template <class Disc> void list(const WallFaces &of, int n, const Disc *disc)
  {
    clear();
    for (int i = 0; i < n; i++) {
      const double px = disc[i].x, py = disc[i].y;
      if (!all.holds(px, py)) continue;
      for (const int f : cells[(size_t) grid.cell(px, py)])
        if (is_near(of, f, boxes[f], px, py, reach)) near.push_back(f);
      if ((int) near.size() > last.back()) {
        discs.push_back(i);
        last.push_back((int) near.size());
      }
    }
  }

  void clear()
  {
    discs.clear();
    near.clear();
    last.assign(1, 0);
  }

 private:
  double reach = 0.0;
  NearGrid grid{0.0, 0.0, 0.0, 1, 1};
  Extent all;
  std::vector<Extent> boxes;
  std::vector<std::vector<int>> cells;
};

}    // namespace jump

#endif
