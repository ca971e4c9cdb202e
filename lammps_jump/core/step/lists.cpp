// SPDX-License-Identifier: GPL-2.0-or-later
/* Lists of the native engine made anew, shared among threads: the lists are the same for any number of them. The seam of a channel,
   discs of other ranks, newcomers, the thesis' own search. */

#include "step/step.h"    // first: the templates of its search take vectors

#include "step/kinds.h"

#include <algorithm>
#include <cstring>

namespace jump {

namespace {

/** Smallest box around discs, and the last of those outside the domain, or -1. */
struct BoxOfDiscs : BoxOfPlaces {
  int64_t outside = -1;

  explicit BoxOfDiscs(const jump_lists &l) : BoxOfPlaces{l.xhi, l.xlo, l.yhi, l.ylo} {}

  void see(const jump_state &s, const jump_lists &l, int64_t from, int64_t to)
  {
    for (int64_t i = from; i < to; i++) {
      const double px = s.x[i], py = s.y[i];
      if (!(px >= l.xlo && px <= l.xhi && py >= l.ylo && py <= l.yhi)) outside = i;
      xlo = least(px, xlo);
      xhi = most(px, xhi);
      ylo = least(py, ylo);
      yhi = most(py, yhi);
    }
  }

  void join(const BoxOfDiscs &other)
  {
    xlo = least(other.xlo, xlo);
    xhi = most(other.xhi, xhi);
    ylo = least(other.ylo, ylo);
    yhi = most(other.yhi, yhi);
    outside = most(other.outside, outside);
  }
};

/** Put a stretch of the sorted discs of an array, of `width` words of 8 bytes a disc, in its place, from a copy of all. */
void gather(const std::vector<uint64_t> &sorted, const int64_t *from, int64_t *to, int64_t width, int64_t begin, int64_t end)
{
  if (width == 1)
    for (int64_t i = begin; i < end; i++) to[i] = from[was_at(sorted[(size_t) i])];
  else
    for (int64_t i = begin; i < end; i++) std::copy_n(from + was_at(sorted[(size_t) i]) * width, width, to + i * width);
}

/** Sort all arrays of the discs. Each thread has a stretch of all of them, so that its discs stay in its cache. */
void move_discs(const jump_state &s, const jump_lists &l, ThreadPartition &partition)
{
  std::vector<std::vector<int64_t>> &copy = partition.lists.copy;
  copy.resize((size_t) l.columns);
  for (int64_t k = 0; k < l.columns; k++) copy[(size_t) k].resize((size_t) (s.n * l.width[k]));
  partition.stretches(s.n, [&](int, int64_t from, int64_t to) {
    for (int64_t k = 0; k < l.columns; k++)
      std::copy(l.column[k] + from * l.width[k], l.column[k] + to * l.width[k], copy[(size_t) k].data() + from * l.width[k]);
  });
  partition.stretches(s.n, [&](int, int64_t from, int64_t to) {
    for (int64_t k = 0; k < l.columns; k++)
      gather(partition.lists.sorted, copy[(size_t) k].data(), l.column[k], l.width[k], from, to);
    std::copy(s.x + from, s.x + to, s.x0 + from);
    std::copy(s.y + from, s.y + to, s.y0 + from);
  });
}

}    // namespace

int64_t list_pairs(jump_state &s, const jump_lists &l, ThreadPartition &partition)
{
  BoxOfDiscs box(l);
  std::vector<BoxOfDiscs> parts((size_t) partition.shares(), box);
  partition.stretches(s.n, [&](int k, int64_t from, int64_t to) { parts[(size_t) k].see(s, l, from, to); });
  for (const BoxOfDiscs &part : parts) box.join(part);
  if (box.outside >= 0) return box.outside;
  s.rows = s.sorted = s.n;
  s.listed_as = next_list();
  s.start[0] = 0;
  if (s.n == 0) return LISTED;
  const double reach = l.widest + l.skin;
  const SearchCells cells(box, reach, s.n);
  const SearchedDiscs discs{s.n, s.x, s.y, s.radius};
  sort_discs<false>(discs, cells, partition.lists, partition);
  move_discs(s, l, partition);
  const RowsOf rows(discs, OwnNumbers{}, partition.lists, s.radius ? l.skin : reach, cells.height(), s.start);
  return list_rows(rows, s.neighbours, s.room, partition.lists, partition) ? LISTED : NO_ROOM;
}

bool list_across(jump_state &s, const jump_lists &l, int64_t others, const double (*at)[4], Rooms &rooms)
{
  std::vector<int32_t> by_height((size_t) others);
  for (int64_t j = 0; j < others; j++) by_height[(size_t) j] = (int32_t) (s.n + j);
  std::sort(by_height.begin(), by_height.end(), [=](int32_t a, int32_t b) { return at[a][1] < at[b][1]; });
  double left = -HUGE_VAL, right = HUGE_VAL;    // of the others, those next to the discs of the state
  const double reach = l.widest + l.skin;
  double middle = 0.0;
  for (int64_t i = 0; i < s.n; i++) middle += at[i][0] / (double) s.n;
  for (int64_t j = s.n; j < s.n + others; j++)
    if (at[j][0] < middle) left = most(at[j][0], left);
    else right = least(at[j][0], right);
  rooms.owner.resize((size_t) (2 * s.n));
  for (int64_t i = 0; i < s.n; i++) rooms.owner[(size_t) i] = (int32_t) i;
  s.rows = s.sorted;
  int64_t count = s.start[s.sorted];
  for (int64_t i = 0; i < s.n; i++) {
    const double px = at[i][0], py = at[i][1];
    if (px > left + reach && px < right - reach) continue;
    const auto low = std::lower_bound(by_height.begin(), by_height.end(), py - reach, [=](int32_t j, double y) { return at[j][1] < y; });
    const int64_t before = count;
    for (auto j = low; j != by_height.end() && at[*j][1] < py + reach; j++) {
      const double dx = px - at[*j][0], dy = py - at[*j][1], apart = s.radius ? l.skin + s.radius[i] + s.radius[*j] : reach;
      if (!(dx * dx + dy * dy < apart * apart)) continue;
      if (count == s.room) return false;
      s.neighbours[count++] = *j;
    }
    if (count == before) continue;
    rooms.owner[(size_t) s.rows] = (int32_t) i;
    s.start[++s.rows] = count;
  }
  s.owner = rooms.owner.data();
  return true;
}


/** Puts neighbours into a row of a list; without a branch, which would be guessed wrong often. */
struct RowOf {
  int64_t n;
  const double *x, *y, *radius;
  double reach;    // of centres; of surfaces where discs have radii of their own
  int32_t *neighbours;

  double reach_of(int64_t i) const { return radius ? reach + radius[i] : reach; }
  void add(int64_t &count, double px, double py, double far, int64_t j) const
  {
    const double dx = px - x[j], dy = py - y[j], apart = radius ? far + radius[j] : far;
    neighbours[count] = (int32_t) j;
    count += dx * dx + dy * dy < apart * apart;
  }
};

/** Cells that a disc covers, along one axis, of those from `low` on. */
struct Span {
  int64_t first, last;

  Span(double place, double reach, int64_t end)
      : first((int64_t) most(place - reach, 0.0)), last(least((int64_t) (place + reach), end))
  {
  }
};

/** Work of weight along a channel from x = 0 to where the discs are, J per m of width. */
static double work_of_weight(const jump_state &s)
{
  double sum = 0.0;
  for (int64_t i = 0; i < s.n; i++) sum += (s.radius ? s.radius[i] * s.radius[i] : 1.0) * s.x[i];
  return s.weight_x * sum;
}

/** Let discs that have left a channel in at its other end. */
static void wrap(const jump_state &s, const jump_lists &l)
{
  *l.slope_work += work_of_weight(s);
  for (int64_t i = 0; i < s.n; i++) s.x[i] -= l.period * std::floor((s.x[i] - l.xlo) / l.period);
  *l.slope_work -= work_of_weight(s);
}

/** Whether a wall that is pushed has come to the seam, as `at_seam` of scene/motion.py has it. */
static bool is_at_seam(const jump_state &s, const jump_lists &l)
{
  const double half_skin = s.clock ? s.clock->half_skin : 0.0, margin = most(l.widest, 0.5 * l.widest + half_skin);
  for (int64_t wall = 0; s.moving && wall < s.walls; wall++) {
    const double way = s.pushed[wall].place[0];
    const bool inside = l.ends[wall][0] + way >= l.xlo + margin && l.ends[wall][1] + way <= l.xhi - margin;
    if (s.moving[wall] >= LOADED && !inside) return true;
  }
  return false;
}

bool search_cells(jump_state &s)
{
  const double inverse = s.grid_inverse, half = 0.5 * s.diameter;
  const auto radius = [&](int64_t i) { return s.radius ? s.radius[i] : half; };
  const auto column = [&](double x) { return (x - s.grid_x) * inverse; };
  const auto line = [&](double y) { return (y - s.grid_y) * inverse; };
  int64_t left = s.grid_columns, right = -1, low = s.grid_rows, high = -1;
  for (int64_t i = 0; i < s.n; i++) {
    const double px = column(s.x[i]), py = line(s.y[i]), reach = radius(i) * inverse;
    if (!(px >= 0.0 && px < (double) s.grid_columns && py >= 0.0 && py < (double) s.grid_rows)) return false;
    const Span across(px, reach, s.grid_columns - 1), up(py, reach, s.grid_rows - 1);
    left = least(left, across.first);
    right = most(right, across.last);
    low = least(low, up.first);
    high = most(high, up.last);
  }
  const int64_t rows = most<int64_t>(high - low + 1, 0), cells = rows * most<int64_t>(right - left + 1, 0);
  int64_t *const first = s.grid_first;
  std::memset(first, 0, (size_t) (cells + 2) * sizeof(int64_t));
  const auto each_cell = [&](int64_t i, auto &&run) {
    const double reach = radius(i) * inverse;
    const Span across(column(s.x[i]), reach, right), up(line(s.y[i]), reach, high);
    for (int64_t cx = across.first - left; cx <= across.last - left; cx++)
      for (int64_t cy = up.first - low; cy <= up.last - low; cy++) run(cx * rows + cy);
  };
  for (int64_t i = 0; i < s.n; i++) each_cell(i, [&](int64_t cell) { first[cell + 2]++; });
  for (int64_t c = 2; c < cells + 2; c++) first[c] += first[c - 1];
  for (int64_t i = 0; i < s.n; i++) each_cell(i, [&](int64_t cell) { s.owner[first[cell + 1]++] = (int32_t) i; });
  int64_t count = 0;
  s.start[0] = 0;
  for (int64_t c = 0; c < cells; c++) {
    const int64_t last = first[c + 1];
    for (int64_t a = first[c]; a < last; a++) {
      const int64_t i = s.owner[a];
      if (count + last - a > s.room) return false;
      for (int64_t b = a + 1; b < last; b++) {
        const int64_t j = s.owner[b];
        const double dx = s.x[i] - s.x[j], dy = s.y[i] - s.y[j], ri = radius(i), rj = radius(j);
        if (!(dx * dx + dy * dy < (ri + rj) * (ri + rj))) continue;
        // it counts only in the cell that holds the contact point, which divides the line of centres as the radii
        const double share = s.radius ? rj / (ri + rj) : 0.5;
        const int64_t cx = (int64_t) column(share * s.x[i] + (1.0 - share) * s.x[j]) - left;
        const int64_t cy = (int64_t) line(share * s.y[i] + (1.0 - share) * s.y[j]) - low;
        if (cx * rows + cy == c) s.neighbours[count++] = (int32_t) j;
      }
      s.start[a + 1] = count;
    }
  }
  s.grid_used[0] = s.rows = first[cells];
  return true;
}

}    // namespace jump

using namespace jump;

int64_t jump_search_cells(jump_state *state) { return search_cells(*state) ? state->rows : -1; }

/** Index of a disc outside the domain, or -1; a NaN is outside. */
int64_t jump_outside(int64_t n, const double *x, const double *y, const double *domain)
{
  int64_t outside = -1;
  for (int64_t i = 0; i < n; i++)
    if (!(x[i] >= domain[0] && x[i] <= domain[1] && y[i] >= domain[2] && y[i] <= domain[3])) outside = i;
  return outside;
}

#define JUMP_IMAGE_ROWS(FIELD) \
  FIELD(int64_t, n) FIELD(const double *, x) FIELD(const double *, y) FIELD(const double *, radius) \
  FIELD(const double *, reach) FIELD(int64_t *, start) FIELD(int32_t *, neighbours) FIELD(int64_t, room) \
  FIELD(int32_t *, owner) FIELD(double *, shift) FIELD(int32_t *, right)
JUMP_INPUT(jump_image_rows, JUMP_IMAGE_ROWS)

/** Pairs across the seam of a periodic channel: a row for each disc near its left end, after the n others.

    The row's disc is a period further on. reach: of the list, the largest of centres, left end, period. `right`
    is room for the discs near the other end. Returns the number of rows, or -1 where there is no room. */
JUMP_API int64_t jump_image_rows(const jump_image_rows_input *input)
{
  JUMP_IMAGE_ROWS(JUMP_LOCAL)
  const RowOf list{n, x, y, radius, reach[0], neighbours};
  const double widest = reach[1], low = reach[2], period = reach[3];
  int64_t strip = 0, rows = n, count = start[n];
  for (int64_t i = 0; i < n; i++) {
    owner[i] = (int32_t) i;
    shift[i] = 0.0;
    right[strip] = (int32_t) i;
    strip += x[i] > low + period - widest;
  }
  for (int64_t i = 0; i < n; i++) {
    if (!(x[i] < low + widest)) continue;
    if (count + strip > room) return -1;
    const double far = list.reach_of(i);
    for (int64_t p = 0; p < strip; p++) list.add(count, x[i] + period, y[i], far, right[p]);
    owner[rows] = (int32_t) i;
    shift[rows] = period;
    start[++rows] = count;
  }
  return rows;
}

namespace jump {

/** Rows of the list for pairs across the seam of a channel; false where there is no room for them. */
static bool list_images(jump_state &s, Rooms &rooms)
{
  const jump_lists &l = *s.lists;
  const double widest = l.widest + l.skin, reach[4] = {s.radius ? l.skin : widest, widest, l.xlo, l.period};
  rooms.owner.resize((size_t) (2 * s.n));
  rooms.shift.resize((size_t) (2 * s.n));
  rooms.right.resize((size_t) s.n + 1);
  const jump_image_rows_input of{s.n, s.x, s.y, s.radius, reach, s.start, s.neighbours, s.room, rooms.owner.data(), rooms.shift.data(),
                                 rooms.right.data()};
  const int64_t rows = jump_image_rows(&of);
  if (rows < 0) return false;
  s.rows = rows;
  s.owner = rooms.owner.data();
  s.shift = rooms.shift.data();
  return true;
}

int64_t list_all(jump_state &s, ThreadPartition &partition)
{
  const jump_lists &l = *s.lists;
  const bool goes_round = l.period > 0.0;
  if (goes_round) wrap(s, l);
  while (true) {
    const int64_t found = list_pairs(s, l, partition);
    if (found >= 0) return found;
    if (found == LISTED && (!goes_round || list_images(s, partition.rooms))) break;
    partition.rooms.grow_neighbours(s, 0);
  }
  list_walls(s, partition.rooms);
  return goes_round && is_at_seam(s, l) ? AT_SEAM : LISTED;
}

}    // namespace jump

/** Square of the distance from a point to the closest disc; infinite where there is none. */
double jump_closest(int64_t n, const double *x, const double *y, double px, double py)
{
  double nearest = HUGE_VAL;
  for (int64_t i = 0; i < n; i++) {
    const double dx = px - x[i], dy = py - y[i];
    nearest = least(dx * dx + dy * dy, nearest);
  }
  return nearest;
}

/** List row of disc i, the newest: every older disc within the reach; 0 where there is no room. */
int64_t jump_append_row(int64_t i, const double *x, const double *y, const double *radius, double reach, int64_t *start,
                        int32_t *neighbours, int64_t room)
{
  int64_t count = start[i];
  for (int64_t j = 0; j < i; j++) {
    const double dx = x[i] - x[j], dy = y[i] - y[j], apart = radius ? reach + radius[i] + radius[j] : reach;
    if (!(dx * dx + dy * dy < apart * apart)) continue;
    if (count == room) return 0;
    neighbours[count++] = (int32_t) j;
  }
  start[i + 1] = count;
  return 1;
}

int64_t jump_touching(const Face *faces, int64_t deep, const int64_t *near, int64_t count, const double *disc,
                      double (*found)[4], int64_t *which)
{
  FaceContact at[MOST];
  const int contacts = WallFaces{faces, deep == 1}.touching(near, count, disc[0], disc[1], disc[2], at);
  for (int c = 0; c < contacts; c++) {
    found[c][0] = at[c].gap, found[c][1] = at[c].nx, found[c][2] = at[c].ny, found[c][3] = at[c].angle;
    which[c] = at[c].face;
  }
  return contacts;
}

double jump_foot_at(const Face *face, double px, double py) { return foot_of(*face, px, py); }
