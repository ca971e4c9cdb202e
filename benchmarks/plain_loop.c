/* SPDX-License-Identifier: GPL-2.0-or-later
   What a step of discs costs in a plain loop of C, without an engine round it: the measure beside benchmarks/scale.py.

   A column of discs, three times as high as wide, falls apart on a floor beside a wall, as in inputs/dam_break.yaml: a
   linear spring and a lagged dashpot along the normal, velocity Verlet, a flat list of pairs with a skin of 0.3 d that is made
   anew when the discs can have moved it. One thread, no output, no guards.

   FILE holds x, y, vx, vy of each disc at the start, doubles: a column whose discs touch does more work than one in which
   they are about to.

   cc -O3 -march=native -o plain_loop benchmarks/plain_loop.c -lm
   ./plain_loop DISCS STEPS DIAMETER STIFFNESS DAMPING TIME_STEP [FILE]    (m, N/m, N s/m, s; density 1000 kg/m3, mass of a square as in the cases)

   Prints processor seconds of the steps, and the lists that were made. */

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

typedef struct { double x, y, vx, vy; } Disc;

static int n, pairs, room, lists;
static double d, skin;
static Disc *disc;
static double *force;
static int *one, *two, *start, *sorted, *cell_of;
static size_t cells_room;

static double now(void)
{
  struct timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);    // of one thread: that of the clock, where nothing else runs
  return t.tv_sec + 1e-9 * t.tv_nsec;
}

static void keep(int i, int j)
{
  const double dx = disc[i].x - disc[j].x, dy = disc[i].y - disc[j].y;
  if (dx * dx + dy * dy >= (d + skin) * (d + skin)) return;
  if (pairs == room) {
    room += room / 2 + 1024;
    one = realloc(one, room * sizeof(int));
    two = realloc(two, room * sizeof(int));
  }
  one[pairs] = i;
  two[pairs++] = j;
}

static void make_list(void)
{
  double xlo = disc[0].x, xhi = xlo, ylo = disc[0].y, yhi = ylo;
  for (int i = 1; i < n; i++) {
    xlo = fmin(xlo, disc[i].x), xhi = fmax(xhi, disc[i].x);
    ylo = fmin(ylo, disc[i].y), yhi = fmax(yhi, disc[i].y);
  }
  const double side = (d + skin) * (1.0 + 1e-9);
  const int nx = (int) ((xhi - xlo) / side) + 3, ny = (int) ((yhi - ylo) / side) + 2;
  const size_t cells = (size_t) nx * ny + 4;    // the last row is empty
  if (cells > cells_room) start = realloc(start, (cells_room = cells + cells / 4) * sizeof(int));
  memset(start, 0, cells * sizeof(int));
  for (int i = 0; i < n; i++) {
    cell_of[i] = (int) ((disc[i].y - ylo) / side) * nx + (int) ((disc[i].x - xlo) / side) + 1;
    start[cell_of[i] + 1]++;
  }
  for (size_t c = 1; c < cells; c++) start[c] += start[c - 1];
  for (int i = n - 1; i >= 0; i--) sorted[--start[cell_of[i] + 1]] = i;
  pairs = 0;
  lists++;
  for (int s = 0; s < n; s++) {
    const int i = sorted[s], c = cell_of[i], above = c + nx - 1;
    for (int t = s + 1; t < start[c + 3]; t++) keep(i, sorted[t]);
    for (int t = start[above + 1]; t < start[above + 4]; t++) keep(i, sorted[t]);
  }
}

int main(int argc, char **argv)
{
  if (argc != 7 && argc != 8) {
    fprintf(stderr, "plain_loop DISCS STEPS DIAMETER STIFFNESS DAMPING TIME_STEP [FILE]\n");
    return 2;
  }
  n = atoi(argv[1]);
  const int steps = atoi(argv[2]);
  d = atof(argv[3]);
  const double k = atof(argv[4]), damping = atof(argv[5]), dt = atof(argv[6]);
  const double mass = 1000.0 * d * d, kick = 0.5 * dt / mass, radius = 0.5 * d;
  skin = 0.3 * d;
  disc = malloc(n * sizeof(Disc));
  force = calloc(2 * n, sizeof(double));
  sorted = malloc(n * sizeof(int));
  cell_of = malloc(n * sizeof(int));
  const int columns = (int) ceil(sqrt(n / 3.0));
  for (int i = 0; i < n; i++) disc[i] = (Disc){(i % columns + 0.5) * d, (i / columns + 0.5) * d, 0.0, 0.0};
  FILE *const start_file = argc == 8 ? fopen(argv[7], "rb") : NULL;
  if (argc == 8 && (!start_file || fread(disc, sizeof(Disc), n, start_file) != (size_t) n)) {
    fprintf(stderr, "plain_loop: %s does not hold %d discs\n", argv[7], n);
    return 2;
  }
  make_list();
  lists = 0;
  double moved = 0.0;
  const double began = now();
  for (int step = 0; step < steps; step++) {
    double lo[2] = {1e300, 1e300}, hi[2] = {-1e300, -1e300};
    for (int i = 0; i < n; i++) {
      Disc *const a = &disc[i];
      a->vx += kick * force[2 * i];
      a->vy += kick * force[2 * i + 1] - 0.5 * dt * 9.81;
      a->x += dt * a->vx;
      a->y += dt * a->vy;
      force[2 * i] = force[2 * i + 1] = 0.0;
      lo[0] = a->vx < lo[0] ? a->vx : lo[0], hi[0] = a->vx > hi[0] ? a->vx : hi[0];
      lo[1] = a->vy < lo[1] ? a->vy : lo[1], hi[1] = a->vy > hi[1] ? a->vy : hi[1];
    }
    moved += dt * hypot(hi[0] - lo[0], hi[1] - lo[1]);
    if (moved > skin) {
      make_list();
      moved = 0.0;
    }
    for (int p = 0; p < pairs; p++) {
      const int i = one[p], j = two[p];
      const double dx = disc[i].x - disc[j].x, dy = disc[i].y - disc[j].y, rr = dx * dx + dy * dy;
      if (rr >= d * d) continue;
      const double r = sqrt(rr), inverse = 1.0 / r;
      const double closing = ((disc[i].vx - disc[j].vx) * dx + (disc[i].vy - disc[j].vy) * dy) * inverse;
      const double push = (k * (d - r) - damping * closing) * inverse;
      force[2 * i] += push * dx;
      force[2 * i + 1] += push * dy;
      force[2 * j] -= push * dx;
      force[2 * j + 1] -= push * dy;
    }
    for (int i = 0; i < n; i++) {    // the floor, and the wall at x = 0
      Disc *const a = &disc[i];
      if (a->x < radius) force[2 * i] += k * (radius - a->x) - 2.0 * damping * a->vx;
      if (a->y < radius) force[2 * i + 1] += k * (radius - a->y) - 2.0 * damping * a->vy;
      a->vx += kick * force[2 * i];
      a->vy += kick * force[2 * i + 1] - 0.5 * dt * 9.81;
    }
  }
  const double took = now() - began;
  double highest = 0.0;    // so that nothing is left out by the compiler
  for (int i = 0; i < n; i++) highest = fmax(highest, disc[i].y);
  printf("%.6f s, %d lists, %.2f ns a disc-step, highest disc at %.3f m\n", took, lists, 1e9 * took / steps / n, highest);
  return 0;
}
