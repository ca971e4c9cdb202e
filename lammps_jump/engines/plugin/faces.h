// SPDX-License-Identifier: GPL-2.0-or-later
/* Contact of a disc with a wall of faces: which faces push, from where, and how they are found.

   lammps_jump/scene/faces.py and near.py hold the same rule and state it; tests compare the two. The operations and their
   order are the same, so that both find the same contacts to the last bit. */

#ifndef JUMP_FACES_H
#define JUMP_FACES_H

#include <algorithm>
#include <cmath>
#include <vector>

namespace jump {

enum FaceKind { SEGMENT, ARC };
enum Joint { CONVEX, SMOOTH, CORNER, FREE, ENDLESS };
enum Place { NOWHERE, INSIDE, BEGIN, END };

constexpr int MOST = 16;                                              // contacts of a disc with one wall
constexpr double SMOOTH_TURN = 5.0;                                   // degrees
/** Radii by which a face behind must be nearer than one in front. */
constexpr double TIE = 1e-9;
constexpr double SAME_TURN = SMOOTH_TURN * M_PI / 180.0 * (1 + 1e-6);
constexpr int FEW = 8;                                                // faces up to which a wall has no grid
constexpr double MOST_CELLS = 1e6;

/** Whether the foot of a point lies at or before the start of a face, and at or behind its end. */
struct Ends {
  bool before, behind;
};

/** A face: the columns of `Faces` in lammps_jump/scene/chains.py; neighbours are indices within the wall. */
struct Face {
  int kind, run, loop, before, after, at_start, at_end;
  double x0, y0, x1, y1, tx0, ty0, tx1, ty1, cx, cy, radius, phi, sweep, length, arc_length;

  Ends ends(double px, double py) const
  {
    return {at_start != ENDLESS && tx0 * (px - x0) + ty0 * (py - y0) <= 0.0,
            at_end != ENDLESS && tx1 * (px - x1) + ty1 * (py - y1) >= 0.0};
  }

  /** Signed distance to the line of a segment, m. */
  double off_line(double px, double py) const { return tx0 * (py - y0) - ty0 * (px - x0); }

  /** Whether a point is further in front of or behind the line of a segment than this, m: no contact then. */
  bool out_of_reach(double px, double py, double front, double behind) const
  {
    if (kind != SEGMENT) return false;
    const double line = off_line(px, py);
    return line >= front || line <= behind;
  }

  /** Whether the foot of a point lies inside a segment. */
  bool is_beside(double px, double py) const
  {
    const Ends at = ends(px, py);
    return !at.before && !at.behind;
  }
};

/** Arc length of the foot of a point on a face, counted along the chain from its start, m. */
inline double foot_of(const Face &f, double px, double py)
{
  const Ends at = f.ends(px, py);
  if (at.before) return f.arc_length;
  if (at.behind) return f.arc_length + f.length;
  if (f.kind == SEGMENT) return f.arc_length + f.tx0 * (px - f.x0) + f.ty0 * (py - f.y0);
  const double dx = px - f.cx, dy = py - f.cy;
  const double out = f.radius > 0.0 ? f.ty0 * dx - f.tx0 * dy : f.tx0 * dy - f.ty0 * dx;    // along the radius at the start
  return f.arc_length + std::fabs(f.radius) * std::atan2(f.tx0 * dx + f.ty0 * dy, out);
}

struct FaceContact {
  int place;
  int face;
  double gap, nx, ny;    // signed distance, m, and normal
  double dx, dy;         // from the foot to the point, m
  double angle;          // of the wall's tangent, rad; set where several faces touch
};

struct Extent {
  double xlo, xhi, ylo, yhi;

  bool holds(double x, double y) const { return x > xlo && x < xhi && y > ylo && y < yhi; }
  void widen(double by)
  {
    xlo -= by;
    xhi += by;
    ylo -= by;
    yhi += by;
  }
};

/** Faces of one wall, and the rule that says which of them push. */
class WallFaces {
 public:
  std::vector<Face> faces;
  bool deep = false;

  /** Contacts of a disc with the faces near[0 .. count), the deepest first; returns their number. */
  int touching(const int *near, int count, double px, double py, double radius, FaceContact *found) const
  {
    if (deep) return behind(near, count, px, py, radius, found);
    double nearest = HUGE_VAL, deepest = HUGE_VAL, lowest = HUGE_VAL;
    int touch = 0;
    for (int p = 0; p < count; p++) {
      const Face &f = faces[near[p]];
      if (f.out_of_reach(px, py, radius, -radius) || clamps_to_neighbour(f, px, py)) continue;
      const FaceContact c = candidate(near[p], px, py);
      if (c.place == NOWHERE) continue;
      const double off = c.gap < 0.0 ? std::fabs(c.gap) + TIE * radius : c.gap;
      if (off < lowest) {
        nearest = c.gap;
        lowest = off;
        if (c.gap < 0.0) found[0] = c;
      }
      if (c.gap >= 0.0 && c.gap < radius) {
        touch++;
        if (c.gap < deepest) {
          deepest = c.gap;
          if (nearest >= 0.0) found[0] = c;
        }
      }
    }
    if (nearest < 0.0) return -nearest < radius;
    return touch < 2 ? touch : select(near, count, px, py, radius, found);
  }

  /** The one face of a wall that does not push from any depth which can have a candidate in reach; -1: none, or several. */
  int only(const int *near, int count, double px, double py, double radius) const
  {
    int found = -1;
    for (int p = 0; p < count; p++) {
      const Face &f = faces[near[p]];
      if (f.out_of_reach(px, py, radius, -radius) || clamps_to_neighbour(f, px, py)) continue;
      if (found >= 0) return -1;
      found = near[p];
    }
    return found;
  }

  /** Distance of a point to a face, m; negative behind it, where its foot is inside. */
  double away(int f, double px, double py) const
  {
    const Ends at = faces[f].ends(px, py);
    if (!at.before && !at.behind) return candidate(f, px, py).gap;
    const double first = at.before ? at_joint(f, false, true, px, py).gap : HUGE_VAL;
    return std::min(first, at.behind ? at_joint(f, true, true, px, py).gap : HUGE_VAL);
  }

  /** Smallest box of a face; without end where it has none and, if behind, where the wall pushes from any depth. */
  Extent box(int index, bool behind = true) const
  {
    const Face &f = faces[index];
    Extent box = {std::min(f.x0, f.x1), std::max(f.x0, f.x1), std::min(f.y0, f.y1), std::max(f.y0, f.y1)};
    const auto add = [&](double x, double y) {
      box = {std::min(box.xlo, x), std::max(box.xhi, x), std::min(box.ylo, y), std::max(box.yhi, y)};
    };
    const auto endless = [&](double towards_x, double towards_y) {
      if (std::fabs(towards_x) > 1e-12) add(std::copysign(HUGE_VAL, towards_x), f.y0);
      if (std::fabs(towards_y) > 1e-12) add(f.x0, std::copysign(HUGE_VAL, towards_y));
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
    if (deep && behind) endless(f.ty0, -f.tx0);
    return box;
  }

 private:
  FaceContact at_joint(int index, bool end, bool front, double px, double py) const
  {
    const Face &f = faces[index];
    const double tx = end ? f.tx1 : f.tx0, ty = end ? f.ty1 : f.ty0;
    const double dx = px - (end ? f.x1 : f.x0), dy = py - (end ? f.y1 : f.y0);
    const double r = std::sqrt(dx * dx + dy * dy);
    const int place = end ? END : BEGIN;
    if (r == 0.0) return {place, index, 0.0, -ty, tx, dx, dy, 0.0};
    if (front) return {place, index, r, dx / r, dy / r, dx, dy, 0.0};
    return {place, index, -r, -dx / r, -dy / r, dx, dy, 0.0};
  }

  bool in_front(int index, bool end, double px, double py) const
  {
    const Face &f = faces[index];
    if (end) return f.tx1 * (py - f.y1) - f.ty1 * (px - f.x1) >= 0.0;
    return f.off_line(px, py) >= 0.0;
  }

  /** Whether a point has no candidate at a segment: its foot is an end, of a joint that counts at a neighbour.

      `candidate` finds the same; most faces near a disc have none. */
  bool clamps_to_neighbour(const Face &f, double px, double py) const
  {
    if (f.kind != SEGMENT) return false;
    const Ends at = f.ends(px, py);
    if (at.behind) return f.at_end < CORNER && !faces[f.after].ends(px, py).before;
    return at.before && f.at_start < CORNER;
  }

  FaceContact candidate(int index, double px, double py) const
  {
    const Face &f = faces[index];
    const Ends at = f.ends(px, py);
    if (at.before || at.behind) return at_end(index, at.behind, px, py);
    if (f.kind == ARC) return on_arc(index, px, py);
    return inside(index, f.off_line(px, py), -f.ty0, f.tx0);
  }

  static FaceContact nowhere(int index) { return {NOWHERE, index, HUGE_VAL, 0.0, 0.0, 0.0, 0.0, 0.0}; }
  static FaceContact inside(int index, double gap, double nx, double ny)
  {
    return {INSIDE, index, gap, nx, ny, gap * nx, gap * ny, 0.0};
  }

  FaceContact on_arc(int index, double px, double py) const
  {
    const Face &f = faces[index];
    const double dx = px - f.cx, dy = py - f.cy;
    const double r = std::sqrt(dx * dx + dy * dy);
    if (r == 0.0) return nowhere(index);
    return f.radius > 0.0 ? inside(index, f.radius - r, -dx / r, -dy / r) : inside(index, r + f.radius, dx / r, dy / r);
  }

  FaceContact at_end(int index, bool behind, double px, double py) const
  {
    const Face &f = faces[index];
    const int joint = behind ? f.at_end : f.at_start;
    const bool front = joint == CONVEX || joint == FREE || in_front(index, behind, px, py);
    bool shared = false;
    // the neighbour answers by the same function: no point falls between two answers
    if (joint != FREE) shared = behind ? faces[f.after].ends(px, py).before : faces[f.before].ends(px, py).behind;
    if (joint == FREE || (shared && behind) || (joint == CORNER && front && !shared))
      return at_joint(index, behind, front, px, py);
    return nowhere(index);
  }

  /** Angle of the wall's tangent at a candidate, rad, unwrapped along the chain. */
  double tangent(const FaceContact &c) const
  {
    const Face &f = faces[c.face];
    double phi = f.phi;
    if (c.place == INSIDE && f.kind != ARC) return phi;
    double tx = f.tx0, ty = f.ty0;
    if (c.place == END) {
      phi += f.sweep;
      tx = f.tx1;
      ty = f.ty1;
    }
    double angle = std::atan2(tx * -c.nx - ty * c.ny, tx * c.ny - ty * c.nx);
    if (c.place == END && f.at_end == CONVEX && angle > 0.5 * M_PI) angle -= 2.0 * M_PI;
    return phi + angle;
  }

  /** Whether two contacts push each on its own. */
  bool apart(const FaceContact &one, const FaceContact &two) const
  {
    const Face &f = faces[one.face];
    if (f.run != faces[two.face].run) return true;
    double turn = std::fabs(one.angle - two.angle);
    if (f.loop) {
      turn -= 2.0 * M_PI * std::floor(turn / (2.0 * M_PI));
      turn = std::min(turn, 2.0 * M_PI - turn);
    }
    return turn > SAME_TURN;
  }

  /** Contacts of a disc with a wall that pushes from any depth: each face on its own. */
  int behind(const int *near, int count, double px, double py, double radius, FaceContact *found) const
  {
    int kept = 0;
    for (int p = 0; p < count && kept < MOST; p++) {
      if (faces[near[p]].out_of_reach(px, py, radius, -HUGE_VAL)) continue;
      const FaceContact c = candidate(near[p], px, py);
      if (c.place == INSIDE && c.gap < radius) found[kept++] = c;
    }
    return kept;
  }

  /** Contacts of a disc that several candidates touch, in front: the deepest, then those that push on their own. */
  int select(const int *near, int count, double px, double py, double radius, FaceContact *found) const
  {
    int kept = 0;
    for (; kept < MOST; kept++) {
      double best = radius;
      for (int p = 0; p < count; p++) {
        if (faces[near[p]].out_of_reach(px, py, best, -best)) continue;
        FaceContact c = candidate(near[p], px, py);
        if (c.place == NOWHERE || c.gap < 0.0 || c.gap >= best) continue;
        c.angle = tangent(c);
        if (std::all_of(found, found + kept, [&](const FaceContact &k) { return k.face != c.face && apart(c, k); })) {
          best = c.gap;
          found[kept] = c;
        }
      }
      if (best == radius) break;
    }
    return kept;
  }
};

/** Cells that list the faces of a wall near them, and the discs near the wall with the faces near each. */
class NearFaces {
 public:
  std::vector<int> discs, last, near;    // row r: disc discs[r] with the faces near[last[r] .. last[r + 1])

  /** Prepare the search for a wall.

      margin: that from a face's box up to which discs are listed, m. Discs move by as much in x and in y before the
      rows are made anew. Their true distance then changes by sqrt(2) as much. */
  void prepare(const WallFaces &of, double radius, double margin, double cell)
  {
    const int n = (int) of.faces.size();
    reach = radius + M_SQRT2 * margin;
    boxes.clear();
    all = {HUGE_VAL, -HUGE_VAL, HUGE_VAL, -HUGE_VAL};
    for (int f = 0; f < n; f++) {
      boxes.push_back(of.box(f));
      Extent &box = boxes.back();
      box.widen(radius + margin);
      all = {std::min(all.xlo, box.xlo), std::max(all.xhi, box.xhi), std::min(all.ylo, box.ylo),
             std::max(all.yhi, box.yhi)};
    }
    const double width = all.xhi - all.xlo, height = all.yhi - all.ylo;
    columns = rows = 1;
    inverse = 0.0;
    cells.assign(1, {});
    if (n <= FEW || !std::isfinite(width) || !std::isfinite(height)) {
      for (int f = 0; f < n; f++) cells[0].push_back(f);
      return;
    }
    const double side = std::max(cell, std::sqrt(width * height / MOST_CELLS));
    inverse = 1.0 / side;
    columns = (int) (width * inverse) + 1;
    rows = (int) (height * inverse) + 1;
    cells.assign((size_t) columns * rows, {});
    for (int f = 0; f < n; f++) mark(of, f);
  }

  /** List the discs with these places. */
  template <class Disc> void list(const WallFaces &of, int n, const Disc *disc)
  {
    clear();
    for (int i = 0; i < n; i++) {
      const double px = disc[i].x, py = disc[i].y;
      if (!all.holds(px, py)) continue;
      for (const int f : cells[(size_t) column(px) * rows + row(py)]) {
        if (!boxes[f].holds(px, py)) continue;
        const double away = of.away(f, px, py);
        if (away < reach && (of.deep || away > -reach)) near.push_back(f);
      }
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
  double reach = 0.0, inverse = 0.0;
  int columns = 1, rows = 1;
  Extent all;
  std::vector<Extent> boxes;
  std::vector<std::vector<int>> cells;

  int column(double x) const { return inverse > 0.0 ? std::clamp((int) ((x - all.xlo) * inverse), 0, columns - 1) : 0; }
  int row(double y) const { return inverse > 0.0 ? std::clamp((int) ((y - all.ylo) * inverse), 0, rows - 1) : 0; }

  void mark(const WallFaces &of, int f)
  {
    const Extent &box = boxes[f];
    const double far = reach + std::sqrt(0.5) / inverse;
    for (int c = column(box.xlo); c <= column(box.xhi); c++)
      for (int r = row(box.ylo); r <= row(box.yhi); r++) {
        const double px = all.xlo + (c + 0.5) / inverse, py = all.ylo + (r + 0.5) / inverse;
        if (std::fabs(of.away(f, px, py)) <= far) cells[(size_t) c * rows + r].push_back(f);
      }
  }
};

}    // namespace jump

#endif
