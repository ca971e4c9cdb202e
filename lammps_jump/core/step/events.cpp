// SPDX-License-Identifier: GPL-2.0-or-later
// What happens at certain steps (events.h).

#include "step/events.h"
#include "step/step.h"

#include <algorithm>

namespace jump {
namespace {

constexpr int64_t NEVER = INT64_MAX;

/** First multiple of `every` after a step, counted from `first`. */
int64_t next_of(int64_t first, int64_t every, int64_t step)
{
  return step < first ? first : first + ((step - first) / every + 1) * every;
}

/** First step after `step` at which an inlet tries. */
int64_t next_turn(const jump_events &e, int64_t number, int64_t step)
{
  const jump_inlet &inlet = e.inlet[number];
  if (inlet.limit >= 0 && e.entered[number] >= inlet.limit) return NEVER;
  if (inlet.turns == 0) return next_of(inlet.first, inlet.every, step);
  const int64_t *const first = e.turn_step + inlet.first_turn, *const end = first + inlet.turns;
  const int64_t *const next = std::upper_bound(first, end, step);
  return next < end ? *next : NEVER;
}

/** Speed of a disc that an inlet lets in at a step, m/s. */
double speed_of(const jump_events &e, const jump_inlet &inlet, int64_t step)
{
  if (inlet.turns == 0) return inlet.vx;
  const int64_t *const first = e.turn_step + inlet.first_turn;
  const int64_t by_then = std::upper_bound(first, first + inlet.turns, step) - first;
  return e.turn_speed[inlet.first_turn + most<int64_t>(by_then - 1, 0)];
}

int64_t next_sizes(const jump_events &e, int64_t step)
{
  if (!e.own_radius || e.traffic[SIZED] == e.traffic[INSERTED]) return NEVER;
  return next_of(0, e.size_every, step);
}

int64_t next_change(const jump_state &s, const jump_events &e, int64_t step)
{
  int64_t next = NEVER;
  for (int64_t wall = 0; wall < s.walls; wall++)
    if (e.until[wall] > step) next = least(e.until[wall], next);
  return next;
}

int64_t next_station(const jump_events &e, int64_t step)
{
  return !e.station_sums || step >= e.station_last ? NEVER : most(e.station_first, step + 1);
}

int64_t next_window(const jump_events &e) { return e.window_steps > 0 ? e.window_begin + e.window_steps : NEVER; }

int64_t next_look(const jump_events &e, int64_t step)
{
  int64_t next = NEVER;
  for (int64_t k = 0; k < e.tailgates; k++) next = least(next_of(e.tailgate[k].first, e.tailgate[k].every, step), next);
  return next;
}

int64_t next_between(const jump_state &s, const jump_events &e, int64_t step)
{
  int64_t next = next_change(s, e, step);
  for (int64_t k = 0; k < e.inlets; k++) next = least(next_turn(e, k, step), next);
  for (int64_t k = 0; k < e.outlets; k++) next = least(next_of(0, e.outlet[k].every, step), next);
  return next;
}

/** Mass of a disc, kg per m of width. */
double mass_of(const jump_state &s, int64_t i) { return s.radius ? s.mass * (s.radius[i] * s.radius[i]) : s.mass; }

/** Kinetic and gravitational energy at the step of a disc that feels weight alone, with its velocity of the half step. */
double free_energy(const jump_state &s, const jump_events &e, int64_t i)
{
  const double half = 0.5 * s.time_step, wx = s.vx[i] + half * e.gravity_x, wy = s.vy[i] + half * e.gravity_y;
  return mass_of(s, i) * (0.5 * (wx * wx + wy * wy) - e.gravity_x * s.x[i] - e.gravity_y * s.y[i]);
}

double turning_energy(const jump_state &s, int64_t i)
{
  if (!s.omega) return 0.0;
  const double square = s.radius ? s.radius[i] * s.radius[i] : 1.0;
  return 0.5 * s.inertia * (square * square) * s.omega[i] * s.omega[i];
}

/** Elastic energy of the contacts of marked discs; 0 without a ledger. */
double elastic_of(const jump_state &s, const jump_events &e, ThreadPartition &partition, const std::vector<int8_t> *marks)
{
  double worst;
  int64_t where[2];
  if (e.ledger == 0) return 0.0;
  return jump::elastic_of(s, partition, marks ? marks->data() : nullptr, &worst, where);
}

/** That of discs with ids above `known`. */
double elastic_of_newcomers(const jump_state &s, const jump_events &e, ThreadPartition &partition, int64_t known)
{
  std::vector<int8_t> marks((size_t) s.n);
  for (int64_t i = 0; i < s.n; i++) marks[(size_t) i] = s.ids[i] > known;
  return elastic_of(s, e, partition, &marks);
}

/** Take out the discs that an outlet takes at this step; false where the lists could not be made. */
bool let_leave(jump_state &s, jump_events &e, ThreadPartition &partition)
{
  std::vector<int8_t> leaves;
  int64_t count = 0;
  for (int64_t k = 0; k < e.outlets; k++) {
    const jump_outlet &outlet = e.outlet[k];
    if (e.step % outlet.every != 0) continue;
    leaves.resize((size_t) s.n);
    const double *const place = outlet.axis == 0 ? s.x : s.y;
    for (int64_t i = 0; i < s.n; i++) {
      const bool beyond = outlet.above ? place[i] > outlet.at : place[i] < outlet.at;
      count += beyond && !leaves[(size_t) i];
      leaves[(size_t) i] |= beyond;
    }
  }
  if (count == 0) return true;
  if (e.ledger) {
    for (int64_t i = 0; i < s.n; i++)
      if (leaves[(size_t) i]) e.exchanged[CARRIED_OUT] += free_energy(s, e, i) + turning_energy(s, i);
    e.exchanged[CARRIED_OUT] += elastic_of(s, e, partition, &leaves);
  }
  e.traffic[REMOVED] += count;
  Rooms::keep(s, leaves);
  return relist(s, partition) != LIST_STALE;
}

/** Put a disc after the others, with the largest diameter and a row of the list of its own. */
void append(jump_state &s, jump_events &e, Rooms &rooms, const jump_inlet &inlet)
{
  if (s.n == s.disc_room) rooms.grow_discs(s);
  const int64_t i = s.n;
  const double largest = s.lists->widest;
  Rooms::clear_next(s);
  s.ids[i] = ++e.traffic[INSERTED];
  s.x[i] = s.x0[i] = inlet.x;
  s.y[i] = s.y0[i] = inlet.y;
  s.vx[i] = speed_of(e, inlet, e.step);
  s.vy[i] = inlet.vy;
  s.fx[i] = e.weight_x;
  s.fy[i] = e.weight_y;
  if (s.ux) {
    s.ux[i] = s.vx[i];
    s.uy[i] = s.vy[i];
  }
  if (s.radius) s.radius[i] = 0.5 * largest;
  // the others may have moved half a skin since the list was made
  const double skin = 1.5 * s.lists->skin, reach = s.radius ? skin : largest + skin;
  while (!jump_append_row(i, s.x, s.y, s.radius, reach, s.start, s.neighbours, s.room)) rooms.grow_neighbours(s, s.start[i]);
  s.rows = s.n = i + 1;
}

/** Add the discs that enter at this step. */
void let_enter(jump_state &s, jump_events &e, ThreadPartition &partition)
{
  const int64_t known = e.traffic[INSERTED];
  for (int64_t k = 0; k < e.inlets; k++) {
    const jump_inlet &inlet = e.inlet[k];
    if (next_turn(e, k, e.step - 1) != e.step) continue;
    if (!(jump_closest(s.n, s.x, s.y, inlet.x, inlet.y) >= inlet.clearance * inlet.clearance)) continue;
    e.entered[k]++;
    append(s, e, partition.rooms, inlet);
    e.exchanged[BROUGHT_IN] += free_energy(s, e, s.n - 1);
  }
  if (e.traffic[INSERTED] == known) return;
  list_walls(s, partition.rooms);
  e.exchanged[BROUGHT_IN] += elastic_of_newcomers(s, e, partition, known);
}

/** Lay aside what walls have felt. */
void take_sums(const jump_state &s, jump_events &e)
{
  for (int64_t wall = 0; wall < s.walls; wall++) {
    const SumsOnWall &sum = s.wall_sum[wall];
    const double felt[4] = {sum.force.x, sum.force.y, sum.force.moment, sum.power};
    for (int k = 0; k < 4; k++) e.window_sum[wall][k] += felt[k];
    s.wall_sum[wall] = {};
  }
}

/** Take away the walls that go at this step. */
void change_walls(jump_state &s, jump_events &e, ThreadPartition &partition)
{
  const double before = elastic_of(s, e, partition, nullptr);
  take_sums(s, e);
  for (int64_t wall = 0; wall < s.walls; wall++) {
    s.gone[wall] = e.step >= e.until[wall];
    if (s.gone[wall] && s.moving) s.moving[wall] = STANDS;
  }
  list_walls(s, partition.rooms);
  e.exchanged[RELEASED_BY_GATES] += before - elastic_of(s, e, partition, nullptr);
}

/** Discs of the largest diameter get their own; the energy balance counts the difference as inflow. */
void give_sizes(jump_state &s, jump_events &e, ThreadPartition &partition)
{
  const int64_t known = e.traffic[SIZED];
  const double before = elastic_of_newcomers(s, e, partition, known);
  e.exchanged[BROUGHT_IN] += jump_give_sizes(&s, known, e.own_radius + known);
  e.exchanged[BROUGHT_IN] += elastic_of_newcomers(s, e, partition, known) - before;
  e.traffic[SIZED] = e.traffic[INSERTED];
}

void see_stations(jump_state &s, jump_events &e)
{
  const double left = e.station_left + e.station_speed * (double) (e.step - e.station_first) * s.time_step;
  const jump_stations at{left, e.station_width, e.station_speed, e.step > e.station_first, e.step < e.station_last};
  const double goes_on = s.memory_step;
  s.memory_step = 0.0;    // springs stay as they are
  jump_between(&s, &at, e.station_sums);
  s.memory_step = goes_on;
  if (e.step == e.station_first) e.station_sums[BEGAN] = e.station_sums[HELD];
}

/** End the window with this step, and begin the next one. */
void close_window(const jump_state &s, jump_events &e, std::vector<double> &windows)
{
  take_sums(s, e);
  windows.push_back((double) e.step);
  windows.push_back((double) (e.step - e.window_begin));
  for (int64_t wall = 0; wall < s.walls; wall++) {
    windows.insert(windows.end(), e.window_sum[wall], e.window_sum[wall] + 4);
    const Placed stands{{}, 1.0, 0.0, {}, {}};
    const double *const placed = reinterpret_cast<const double *>(s.placed ? s.placed + wall : &stands);
    windows.insert(windows.end(), placed, placed + sizeof(Placed) / sizeof(double));
    std::fill_n(e.window_sum[wall], 4, 0.0);
  }
  if (s.pressed) {
    double *const sums = reinterpret_cast<double *>(s.pressed->sums), *const end = sums + 3 * s.pressed->stretches;
    windows.insert(windows.end(), sums, end);
    std::fill(sums, end, 0.0);
  }
  e.window_begin = e.step;
}

/** Let the tailgates whose turn it is look at the discs that move, and go on at the speed that follows. */
void look_of_tailgates(const jump_state &s, jump_events &e)
{
  for (int64_t k = 0; k < e.tailgates; k++) {
    jump_tailgate &gate = e.tailgate[k];
    if (!gate.looks(e.step)) continue;
    std::vector<double> areas((size_t) gate.bins);
    for (int64_t i = 0; i < s.n; i++) {
      if (s.fixed && s.fixed[i] != 0) continue;
      gate.add(areas, s.x[i], s.radius ? 4.0 * (s.radius[i] * s.radius[i]) : s.diameter * s.diameter);
    }
    Pushed &wall = s.pushed[e.tailgate_wall[k]];
    wall.speed[1] = gate.look(areas, wall.place[1], s.time_step);
  }
}

}    // namespace

int64_t next_event(const jump_state &s, const jump_events &e)
{
  const int64_t after[] = {next_sizes(e, e.step), next_station(e, e.step), next_window(e), next_look(e, e.step)};
  return least(next_between(s, e, e.step), *std::min_element(std::begin(after), std::end(after)));
}

bool is_between(const jump_state &s, const jump_events &e) { return next_between(s, e, e.step - 1) == e.step; }

bool happen_between(jump_state &s, jump_events &e, ThreadPartition &partition)
{
  if (!let_leave(s, e, partition)) return false;
  let_enter(s, e, partition);
  if (next_change(s, e, e.step - 1) == e.step) change_walls(s, e, partition);
  return true;
}

void happen_after(jump_state &s, jump_events &e, ThreadPartition &partition)
{
  if (next_sizes(e, e.step - 1) == e.step) give_sizes(s, e, partition);
  if (next_station(e, e.step - 1) == e.step) see_stations(s, e);
  if (next_window(e) == e.step) close_window(s, e, partition.rooms.windows);
  look_of_tailgates(s, e);
}

}    // namespace jump
