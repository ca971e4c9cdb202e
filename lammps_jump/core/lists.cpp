// SPDX-License-Identifier: GPL-2.0-or-later
/* Lists of the native engine: discs sorted by cell, pairs that are close, discs near walls, the thesis' own search.

   Cells are as wide as the list's reach and counted along the shorter side of the flow first. Discs are sorted by cell, so
   that the candidates of a disc are two stretches of memory. */

#include "native.h"
#include "near.h"

#include <cstring>

namespace jump {

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

/** Smallest box around the discs and the index of one outside the domain, or -1; a NaN is outside. */
int64_t jump_extent(int64_t n, const double *x, const double *y, const double *domain, double *box)
{
  double a = domain[1], b = domain[0], c = domain[3], d = domain[2];
  int64_t lost = -1;
  for (int64_t i = 0; i < n; i++) {
    const double px = x[i], py = y[i];
    if (!(px >= domain[0] && px <= domain[1] && py >= domain[2] && py <= domain[3])) lost = i;
    a = least(px, a);
    b = most(px, b);
    c = least(py, c);
    d = most(py, d);
  }
  box[0] = a, box[1] = b, box[2] = c, box[3] = d;
  return lost;
}

/** Counting sort by cell: first disc of each cell, cell of each place, place of each disc.

    grid: x and y of the lower left corner, cells per metre; cells: columns, rows, whether x runs along the rows, size of
    `cell_start`. A frame of empty cells surrounds the grid, rows counted fastest. */
void jump_sort(int64_t n, const double *x, const double *y, const double *grid, const int64_t *cells, int64_t *cell_start,
               int64_t *cell, int64_t *order)
{
  const int64_t columns = cells[0], rows = cells[1], height = rows + 2, size = cells[3];
  std::memset(cell_start, 0, (size_t) size * sizeof(int64_t));
  for (int64_t i = 0; i < n; i++) {
    int64_t cx = (int64_t) ((x[i] - grid[0]) * grid[2]), cy = (int64_t) ((y[i] - grid[1]) * grid[2]);
    if (cells[2]) {
      const int64_t turned = cx;
      cx = cy;
      cy = turned;
    }
    order[i] = (least(cx, columns - 1) + 1) * height + least(cy, rows - 1) + 1;
    cell_start[order[i] + 2]++;
  }
  for (int64_t c = 2; c < size; c++) cell_start[c] += cell_start[c - 1];
  for (int64_t i = 0; i < n; i++) {    // cell_start[c + 1] runs from the first disc of cell c to the first of the next one
    const int64_t c = order[i], place = cell_start[c + 1]++;
    cell[place] = c;
    order[i] = place;
  }
}

/** Rows of `width` words of 8 bytes go to their places. */
void jump_permute(int64_t n, int64_t width, int64_t *source, const int64_t *place, int64_t *scratch)
{
  if (width == 1)
    for (int64_t i = 0; i < n; i++) scratch[place[i]] = source[i];
  else
    for (int64_t i = 0; i < n; i++)
      for (int64_t w = 0; w < width; w++) scratch[place[i] * width + w] = source[i * width + w];
  std::memcpy(source, scratch, (size_t) (n * width) * sizeof(int64_t));
}

/** Half list of all pairs closer than the reach; its length, or -1 where there is no room. */
int64_t jump_pair_list(int64_t n, const double *x, const double *y, const double *radius, double reach, int64_t rows,
                       const int64_t *cell_start, const int64_t *cell, int64_t *start, int32_t *neighbours, int64_t room)
{
  const RowOf list{n, x, y, radius, reach, neighbours};
  const int64_t height = rows + 2;
  int64_t count = 0;
  start[0] = 0;
  for (int64_t i = 0; i < n; i++) {
    const int64_t c = cell[i], low = cell_start[c + height - 1], high = cell_start[c + height + 2];
    const int64_t last = cell_start[c + 2];
    const double xi = x[i], yi = y[i], far = list.reach_of(i);
    if (count + (last - i) + (high - low) > room) return -1;
    for (int64_t j = i + 1; j < last; j++) list.add(count, xi, yi, far, j);
    for (int64_t j = low; j < high; j++) list.add(count, xi, yi, far, j);
    start[i + 1] = count;
  }
  return count;
}

/** Pairs across the seam of a periodic channel: a row for each disc near its left end, behind the n others.

    The row's disc stands a period further on. reach: of the list, the largest of centres, left end, period. `right`
    is room for the discs near the other end. Returns the number of rows, or -1 where there is no room. */
int64_t jump_image_rows(int64_t n, const double *x, const double *y, const double *radius, const double *reach, int64_t *start,
                        int32_t *neighbours, int64_t room, int32_t *owner, double *shift, int32_t *right)
{
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

double jump_away(const Face *faces, int64_t face, double px, double py) { return WallFaces{faces, false}.away(face, px, py); }

/** List the discs near one wall and the faces near each.

    Row r of the list is disc discs[r] with the faces near[last[r] .. last[r + 1]). room: of `last` and of `near`; found: rows
    and faces to go on from, and those in the end; faces -1 where there is no room. */
void jump_list_near(const jump_grid *g, int64_t n, const double *x, const double *y, int32_t *discs, int8_t *plain,
                    int64_t *last, int64_t *near, const int64_t *room, int64_t *found)
{
  const WallFaces wall{g->faces, g->deep == 1};
  const NearGrid cells{g->left, g->low, g->inverse, g->columns, g->rows};
  const Extent all{g->xlo, g->xhi, g->ylo, g->yhi};
  const Extent *const box = reinterpret_cast<const Extent *>(g->box);
  int64_t row = found[0], count = found[1];
  for (int64_t i = 0; i < n; i++) {
    const double px = x[i], py = y[i];
    if (!all.holds(px, py)) continue;
    const int64_t cell = g->first_cell + cells.cell(px, py), first = g->start[cell], end = g->start[cell + 1];
    if (row + 1 >= room[0] || count + end - first > room[1]) {
      found[0] = row;
      found[1] = -1;
      return;
    }
    const int64_t begin = count;
    for (int64_t p = first; p < end; p++)
      if (is_near(wall, g->listed[p], box[g->listed[p]], px, py, g->reach)) near[count++] = g->listed[p];
    if (count == begin) continue;
    discs[row] = (int32_t) i;
    plain[row] = count == begin + 1 && is_plain(g->faces[near[begin]], px, py, g->reach);
    last[++row] = count;
  }
  found[0] = row;
  found[1] = count;
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
