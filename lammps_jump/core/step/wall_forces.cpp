// SPDX-License-Identifier: GPL-2.0-or-later
/* Walls in a step: where they are, their forces on the discs near them, those of bodies on each other, and what they feel. */

#include "contact/no_contraction.h"

#include "step/step.h"
#include "walls/bodies.h"

#include <algorithm>
#include <initializer_list>

namespace jump {

/* Forces of discs on stretches of outlines, summed over steps: pressure along a face. engines/twin/loops.py states the same. */

/** The press of a disc at (px, py) in the wall's own frame, on which the wall acts with (fx, fy) and the normal (nx, ny). */
static Press press_of(int64_t wall, const Face &face, double px, double py, double nx, double ny, double fx, double fy)
{
  return {wall, fx * nx + fy * ny, fy * nx - fx * ny, foot_of(face, px, py)};
}

static void add_press(const jump_pressed &to, const Press &press)
{
  for (int64_t k = to.first[press.wall]; k < to.first[press.wall + 1]; k++) {
    if (press.place < to.ends[k][0] || press.place >= to.ends[k][1]) continue;
    to.sums[k][0] += press.across;
    to.sums[k][1] += press.along;
    to.sums[k][2] += press.across * press.place;
  }
}

/** Rows of the list of one wall whose discs a part has. */
static std::pair<int64_t, int64_t> rows_of(const jump_state &s, int64_t wall, const ThreadPart &part)
{
  const int32_t *const first = s.near_discs + s.near_rows[wall], *const last = s.near_discs + s.near_rows[wall + 1];
  if (part.begin == 0 && part.end == s.n) return {s.near_rows[wall], s.near_rows[wall + 1]};
  return {std::lower_bound(first, last, part.begin) - s.near_discs, std::lower_bound(first, last, part.end) - s.near_discs};
}

/** The point about which the moment on a wall is taken, where it is, m. */
static std::pair<double, double> reference_of(const jump_state &s, int64_t wall, const Placed *placed)
{
  const double x = s.about[wall][0], y = s.about[wall][1];
  return placed ? std::pair{x + placed->now.x, y + placed->now.y} : std::pair{x, y};
}

/** Forces of one wall on the discs of a part, and of these on it. Fixed discs feel no wall but bodies. */
template <bool SIZES, bool SPIN, class Law>
static void forces_of(const jump_state &s, const Law &law, int64_t wall, ThreadPart &part)
{
  const double *const spins = SPIN ? seen_by(s).spin : nullptr;
  const WallView view(s, wall);
  const Numbers<double> of = numbers_of(s.at_wall[wall], 0.0);
  const bool moves = view.placed, slides = Law::Friction::HAS_FRICTION && s.friction_x;
  const auto [x_ref, y_ref] = reference_of(s, wall, view.placed);
  const bool presses = s.pressed && s.pressed->first[wall] < s.pressed->first[wall + 1];
  FaceContact found[MOST];
  const auto [from, to] = rows_of(s, wall, part);
  for (int64_t row = from; row < to; row++) {
    const int64_t i = s.near_discs[row];
    if (view.passes(s, i)) continue;
    const double own = radius_of(s, i), *const row_of = part.at[i], x = row_of[0], y = row_of[1];
    const DiscAtWall disc{i, own, x, y, row_of[2], row_of[3], SPIN ? spins[i] : 0.0};
    double px = x, py = y;
    view.into_frame(px, py);
    const int count = view.touching(s, row, px, py, own, found);
    for (int c = 0; c < count; c++) {
      const AtWall<double> at = view.meet(disc, found[c]);
      const WallForce<double> out =
          wall_force<SIZES, SPIN>(s, law, of, view, disc, at, WallHistory(s, i, found[c].face, px, py, own));
      const double to = view.arm(at.gap, own), to_x = x - to * at.nx, to_y = y - to * at.ny;
      const double rolls = view.body ? own * out.resist : 0.0;    // of a body, which feels it too
      const Sum push{out.fx, out.fy, (to_x - x_ref) * out.fy - (to_y - y_ref) * out.fx + rolls};
      part.on_walls.push_back(push);
      if (presses) part.presses.push_back(press_of(wall, s.faces[found[c].face], px, py, at.nx, at.ny, out.fx, out.fy));
      if constexpr (SPIN) s.torque[i] += out.torque;
      double *const force = part.forces[i];
      force[0] += out.fx;
      force[1] += out.fy;
      if (!s.dashpot_x) continue;    // what is lost is not requested
      force[2] += out.dashpot * at.nx;
      force[3] += out.dashpot * at.ny;
      if (slides) {
        s.friction_x[i] -= out.tangential * at.ny;
        s.friction_y[i] += out.tangential * at.nx;
      }
      if (!moves) continue;
      const double arm_x = to_x - view.cx - view.placed->now.x, arm_y = to_y - view.cy - view.placed->now.y;
      part.dissipated_at_walls.push_back({
          {out.dashpot * at.nx, out.dashpot * at.ny, out.dashpot * (arm_x * at.ny - arm_y * at.nx)},
          {-out.tangential * at.ny, out.tangential * at.nx, out.tangential * (arm_x * at.nx + arm_y * at.ny) + rolls},
      });
    }
  }
  part.walls_end.push_back({part.on_walls.size(), part.dissipated_at_walls.size()});
}

void wall_forces(const jump_state &s, double slope, ThreadPart &part)
{
  part.on_walls.clear();
  part.dissipated_at_walls.clear();
  part.walls_end.clear();
  part.presses.clear();
  with_law(s, slope, [&](const auto &law, auto sizes, auto spin) {
    for (int64_t wall = 0; wall < s.walls; wall++) forces_of<sizes.value, spin.value>(s, law, wall, part);
  });
}

void sum_walls(const jump_state &s, const std::vector<ThreadPart> &parts)
{
  if (s.pressed)
    for (const ThreadPart &part : parts)
      for (const Press &press : part.presses) add_press(*s.pressed, press);
  for (int64_t wall = 0; wall < s.walls; wall++) {
    Sum on_wall, dashpots, friction;
    for (const ThreadPart &part : parts) {
      const Ends first = wall > 0 ? part.walls_end[wall - 1] : Ends{0, 0}, last = part.walls_end[wall];
      for (size_t c = first.push; c < last.push; c++) on_wall -= part.on_walls[c];
      for (size_t c = first.dissipated; c < last.dissipated; c++) {
        dashpots += part.dissipated_at_walls[c].dashpots;
        friction += part.dissipated_at_walls[c].friction;
      }
    }
    s.wall_sum[wall].force += on_wall;
    if (s.moving && s.moving[wall] != STANDS) s.wall_loads[wall] = {on_wall, on_wall, dashpots, friction};
  }
}

/** What forces of a step do on walls that move: their power on discs, and what is due to them in the ledger. */
void end_walls(const jump_state &s)
{
  const double dt = s.clock->dt;
  WorkParts &of_walls = s.work->of_walls, &whole = s.work->whole;
  of_walls = {0.0, 0.0, 0.0};
  for (int64_t wall = 0; wall < s.walls; wall++) {
    const int64_t kind = s.moving[wall];
    if (kind == STANDS) continue;
    const WallLoads &loads = s.wall_loads[wall];
    Pushed &pushed = s.pushed[wall];
    pushed.force[0] = loads.all.x;
    pushed.force[1] = loads.all.y;
    pushed.force[2] = loads.all.moment;
    if (kind >= LOADED) centre(s.placed[wall], pushed, s.load[wall], dt);
    const Pose &rate = s.placed[wall].centred;
    s.wall_sum[wall].power -= loads.of_discs.power(rate);
    of_walls.dashpots += dt * loads.dashpots.power(rate);
    of_walls.friction += dt * loads.friction.power(rate);
    if (kind != LOADED && kind != BODY) of_walls.walls -= dt * loads.all.power(rate);    // the energy of the others is part of the whole
  }
  whole.dashpots += of_walls.dashpots;
  whole.friction += of_walls.friction;
  whole.walls += of_walls.walls;
}

/** Put the moving walls where they are at a step; true where one has gone over half the skin since it was listed. */
bool place_walls(const jump_state &s, double step)
{
  const Clock clock = s.clock->clock();
  bool old = false;
  for (int64_t wall = 0; wall < s.walls; wall++) {
    if (s.moving[wall] == STANDS) continue;
    const int64_t first = s.track_first[wall];
    if (s.moving[wall] == FOLLOWS)
      follow(s.placed[wall], s.track + first, s.track_first[wall + 1] - first, clock.time(step), clock.dt);
    else follow(s.placed[wall], s.pushed[wall], s.load[wall], clock, step, s.clock->extrapolates > 0.0 && s.moving[wall] == BODY);
    old = old || !(travel(s.placed[wall].now, s.listed[wall], s.far[wall]) <= s.clock->half_skin);
  }
  return old;
}

/** Move the walls that discs push, and put all that move where they are; true where one has left its list. */
bool move_walls(const jump_state &s, double step)
{
  for (int64_t wall = 0; wall < s.walls; wall++)
    if (s.moving[wall] >= LOADED) drift(s.pushed[wall], s.load[wall], s.clock->clock(), step);
  return place_walls(s, step);
}

void clear_fixed(const jump_state &s, const ThreadPart &part)
{
  for (int64_t i = part.begin; i < part.end; i++) {
    if (s.fixed[i] == 0) continue;
    std::fill_n(part.forces[i], 4, 0.0);
    for (double *const of : {s.torque, s.friction_x, s.friction_y})
      if (of) of[i] = 0.0;
  }
}

}    // namespace jump

void jump::body_forces(const jump_state &s, double slope) { push_bodies(s, slope); }

double jump::body_elastic(const jump_state &s) { return stored_by_bodies(s); }
