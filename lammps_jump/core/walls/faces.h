// SPDX-License-Identifier: GPL-2.0-or-later
/* Contact of a disc with a wall of faces: which faces push, and from where.

   docs/walls.md and lammps_jump/scene/faces.py state the rule; tests compare the two. A wall is a view of faces that
   somebody else holds; indices of faces are those of that array. */

#ifndef JUMP_CORE_FACES_H
#define JUMP_CORE_FACES_H

#include "contact/elementary.h"

#include <cstdint>

namespace jump {

enum FaceKind { SEGMENT, ARC };
enum Joint { CONVEX, SMOOTH, CORNER, FREE, ENDLESS };
enum Place { NOWHERE, INSIDE, BEGIN, END };

constexpr int MOST = 16;                                              // contacts of a disc with one wall
constexpr double SMOOTH_TURN = 5.0;                                   // degrees
constexpr double TIE = 1e-9;                                          // radii by which a face behind must be nearer
constexpr double SAME_TURN = SMOOTH_TURN * (PI / 180.0) * (1 + 1e-6);
constexpr double NO_END = HUGE_VAL;

/** A face: the columns of `codes` and `shape` of lammps_jump/scene/chains.py. */
struct Face {
  int64_t kind, wall, run, loop, before, after, at_start, at_end;
  double x0, y0, x1, y1, tx0, ty0, tx1, ty1, cx, cy, radius, phi, sweep, length, arc_length;

  /** Whether the foot of a point lies at or before the start. */
  bool is_before(double px, double py) const
  {
    return at_start != ENDLESS && tx0 * (px - x0) + ty0 * (py - y0) <= 0.0;
  }

  /** Whether it lies at or behind the end. */
  bool is_behind(double px, double py) const
  {
    return at_end != ENDLESS && tx1 * (px - x1) + ty1 * (py - y1) >= 0.0;
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

  /** Whether a point lies in front of the line that touches the face at one end. */
  bool in_front(bool end, double px, double py) const
  {
    return end ? tx1 * (py - y1) - ty1 * (px - x1) >= 0.0 : off_line(px, py) >= 0.0;
  }
};

/** Where a wall may push a disc: place of the foot, signed distance (m), normal; of a contact, tangent angle (rad), face. */
struct FaceContact {
  int place;
  double gap, nx, ny, angle;
  int64_t face;
};

/** Signed distance of a point to one end of a face, and the unit vector from there; the face's normal on the end. */
inline FaceContact at_joint(const Face &f, int64_t index, bool end, bool front, double px, double py)
{
  const double tx = end ? f.tx1 : f.tx0, ty = end ? f.ty1 : f.ty0;
  const double dx = px - (end ? f.x1 : f.x0), dy = py - (end ? f.y1 : f.y0);
  const double r = std::sqrt(dx * dx + dy * dy);
  const int place = end ? END : BEGIN;
  if (r == 0.0) return {place, 0.0, -ty, tx, 0.0, index};
  if (front) return {place, r, dx / r, dy / r, 0.0, index};
  return {place, -r, -dx / r, -dy / r, 0.0, index};
}

inline FaceContact on_arc(const Face &f, int64_t index, double px, double py)
{
  const double dx = px - f.cx, dy = py - f.cy, r = std::sqrt(dx * dx + dy * dy);
  if (r == 0.0) return {NOWHERE, NO_END, 0.0, 0.0, 0.0, index};
  if (f.radius > 0.0) return {INSIDE, f.radius - r, -dx / r, -dy / r, 0.0, index};
  return {INSIDE, r + f.radius, dx / r, dy / r, 0.0, index};
}

/** Arc length of the foot of a point on a face, counted along the chain from its start, m. */
inline double foot_of(const Face &f, double px, double py)
{
  if (f.is_before(px, py)) return f.arc_length;
  if (f.is_behind(px, py)) return f.arc_length + f.length;
  if (f.kind == SEGMENT) return f.arc_length + f.tx0 * (px - f.x0) + f.ty0 * (py - f.y0);
  const double dx = px - f.cx, dy = py - f.cy;
  const double out = f.radius > 0.0 ? f.ty0 * dx - f.tx0 * dy : f.tx0 * dy - f.ty0 * dx;    // along the radius at the start
  return f.arc_length + std::fabs(f.radius) * arctangent(f.tx0 * dx + f.ty0 * dy, out);
}

/** Faces of a wall, and the rule that says which of them push; `deep`: each face on its own, from any depth. */
struct WallFaces {
  const Face *faces;
  bool deep;

  /** Contacts of a disc with the faces near[0 .. count), the deepest first; returns their number. */
  template <class Index>
  int touching(const Index *near, int64_t count, double px, double py, double radius, FaceContact *found) const
  {
    if (deep) return behind(near, count, px, py, radius, found);
    double nearest = NO_END, deepest = NO_END, lowest = NO_END;
    int touch = 0;
    for (int64_t p = 0; p < count; p++) {
      const Face &f = faces[near[p]];
      if (f.out_of_reach(px, py, radius, -radius) || clamps_to_neighbour(f, px, py)) continue;
      const FaceContact c = candidate(near[p], px, py);
      if (c.place == NOWHERE) continue;
      double off = std::fabs(c.gap);
      if (c.gap < 0.0) off += TIE * radius;
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
  template <class Index> int64_t only(const Index *near, int64_t count, double px, double py, double radius) const
  {
    int64_t found = -1;
    for (int64_t p = 0; p < count; p++) {
      const Face &f = faces[near[p]];
      if (f.out_of_reach(px, py, radius, -radius) || clamps_to_neighbour(f, px, py)) continue;
      if (found >= 0) return -1;
      found = near[p];
    }
    return found;
  }

  /** Distance of a point to a face, m; negative behind it, where its foot is inside. */
  double away(int64_t index, double px, double py) const
  {
    const Face &f = faces[index];
    const bool before = f.is_before(px, py), behind = f.is_behind(px, py);
    if (!before && !behind) return candidate(index, px, py).gap;
    const double first = before ? at_joint(f, index, false, true, px, py).gap : NO_END;
    return least(first, behind ? at_joint(f, index, true, true, px, py).gap : NO_END);
  }

  FaceContact candidate(int64_t index, double px, double py) const
  {
    const Face &f = faces[index];
    const bool before = f.is_before(px, py), behind = f.is_behind(px, py);
    if (before || behind) return at_end(index, behind, px, py);
    if (f.kind == ARC) return on_arc(f, index, px, py);
    return on_line(index, px, py);
  }

  /** The contact with a segment that a point faces. */
  FaceContact on_line(int64_t index, double px, double py) const
  {
    const Face &f = faces[index];
    return {INSIDE, f.off_line(px, py), -f.ty0, f.tx0, 0.0, index};
  }

 private:
  /** Whether a point has no candidate at a segment: its foot is an end, of a joint that counts at a neighbour.

      `candidate` finds the same; most faces near a disc have none. */
  bool clamps_to_neighbour(const Face &f, double px, double py) const
  {
    if (f.kind != SEGMENT) return false;
    if (f.is_behind(px, py)) return f.at_end < CORNER && !faces[f.after].is_before(px, py);
    return f.at_start < CORNER && f.is_before(px, py);
  }

  FaceContact at_end(int64_t index, bool behind, double px, double py) const
  {
    const Face &f = faces[index];
    const int64_t joint = behind ? f.at_end : f.at_start;
    const bool front = joint == CONVEX || joint == FREE || f.in_front(behind, px, py);
    bool shared = false;
    // the neighbour answers by the same function: no point falls between two answers
    if (joint != FREE) shared = behind ? faces[f.after].is_before(px, py) : faces[f.before].is_behind(px, py);
    if (joint == FREE || (shared && behind) || (joint == CORNER && front && !shared))
      return at_joint(f, index, behind, front, px, py);
    return {NOWHERE, NO_END, 0.0, 0.0, 0.0, index};
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
    double angle = arctangent(tx * -c.nx - ty * c.ny, tx * c.ny - ty * c.nx);
    if (c.place == END && f.at_end == CONVEX && angle > 0.5 * PI) angle -= 2.0 * PI;
    return phi + angle;
  }

  /** Whether two contacts push each on its own. */
  bool apart(const FaceContact &one, const FaceContact &two) const
  {
    const Face &f = faces[one.face];
    if (f.run != faces[two.face].run) return true;
    double turn = std::fabs(one.angle - two.angle);
    if (f.loop == 1) {
      turn -= 2.0 * PI * std::floor(turn / (2.0 * PI));
      turn = least(turn, 2.0 * PI - turn);
    }
    return turn > SAME_TURN;
  }

  /** Contacts of a disc with a wall that pushes from any depth: each face on its own. */
  template <class Index>
  int behind(const Index *near, int64_t count, double px, double py, double radius, FaceContact *found) const
  {
    int kept = 0;
    for (int64_t p = 0; p < count && kept < MOST; p++) {
      if (faces[near[p]].out_of_reach(px, py, radius, -NO_END)) continue;
      const FaceContact c = candidate(near[p], px, py);
      if (c.place == INSIDE && c.gap < radius) found[kept++] = c;
    }
    return kept;
  }

  /** Contacts of a disc that several candidates touch, in front: the deepest, then those that push on their own. */
  template <class Index>
  int select(const Index *near, int64_t count, double px, double py, double radius, FaceContact *found) const
  {
    int kept = 0;
    for (; kept < MOST; kept++) {
      double best = radius;
      for (int64_t p = 0; p < count; p++) {
        if (faces[near[p]].out_of_reach(px, py, best, -best)) continue;
        FaceContact c = candidate(near[p], px, py);
        if (c.place == NOWHERE || c.gap < 0.0 || c.gap >= best) continue;
        c.angle = tangent(c);
        bool own = true;
        for (int k = 0; k < kept; k++) own = own && found[k].face != c.face && apart(c, found[k]);
        if (own) {
          best = c.gap;
          found[kept] = c;
        }
      }
      if (best == radius) break;
    }
    return kept;
  }
};

/* Which faces of a wall are near a disc: cells that list the faces near them, in the wall's own frame.

   lammps_jump/scene/faces.py states the same; tests compare the two. */

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

/** Whether a point faces a straight face, a margin (m) from its ends: its line is then enough. */
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
