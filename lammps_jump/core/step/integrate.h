// SPDX-License-Identifier: GPL-2.0-or-later
/* Kick and drift of a stretch of discs. */

#ifndef JUMP_CORE_INTEGRATE_H
#define JUMP_CORE_INTEGRATE_H

#include "step/native.h"

namespace jump {

/** Discs that have one sum of the ledger: stretches are whole blocks, so that threads do not change the order of sums. */
constexpr int64_t BLOCK = 128;

/** What dashpots and friction did to the discs of a block over a kick: sums of F . v, W per m of width. */
struct Dissipated {
  double dashpots, friction, turning;
};

/** Rows of the discs between the steps of a call: place and velocity as contacts see them, and force with its part that dashpots
    lose. They are what steps go on from; arrays of the state have them before and after. */
struct StepRows {
  double (*at)[4], (*forces)[4];
};

/** Take discs `begin` to `end` from the arrays of the state. */
void load(const jump_state &s, int64_t begin, int64_t end, const StepRows &rows);

/** Put them back. */
void store(const jump_state &s, int64_t begin, int64_t end, const StepRows &rows);

/** Of discs `begin` to `end`: v += dt F/m, x += dt v, F = weight.

    `dissipated` has a place for each block of all discs; without a ledger it is not used. `next` takes the places and velocities. Returns
    the number of discs further than half the skin from their place in the list. A NaN counts as moved. */
int64_t drift(const jump_state &s, int64_t begin, int64_t end, Dissipated *dissipated, const StepRows &rows, double (*next)[4]);

/** Velocities of discs, m/s: least and largest along each axis. */
struct SpeedRange {
  double lo[2] = {1e300, 1e300}, hi[2] = {-1e300, -1e300};

  void widen(const SpeedRange &by)
  {
    for (int c = 0; c < 2; c++) {
      lo[c] = least(by.lo[c], lo[c]);
      hi[c] = most(by.hi[c], hi[c]);
    }
  }
};

/** What a row of forces has after the force where discs go by half kicks: the half kick of 1 N, m/s, and the mass over that of a
    disc of nominal size; 0 of discs that stay. */
enum { HALF_KICK = 2, MASS = 3 };

inline void put_mass(const jump_state &s, int64_t i, double *force)
{
  const double square = s.radius ? s.radius[i] * s.radius[i] : 1.0;
  const bool stays = s.fixed && s.fixed[i] != 0;
  force[HALF_KICK] = stays ? 0.0 : 0.5 * s.time_step / s.mass / square;
  force[MASS] = stays ? 0.0 : square;
}

/** Rows of forces for `drift_by_halves`: the weight alone where a step `begins`, else what the state has. */
void begin_halves(const jump_state &s, int64_t begin, int64_t end, const StepRows &rows, bool begins);

/** The same by half kicks, as LAMMPS does: that of the step before, where `both` is set, and that of this one. Returns the range of
    the new velocities, which bounds how far discs can have come against one another. */
SpeedRange drift_by_halves(const jump_state &s, int64_t begin, int64_t end, bool both, const StepRows &rows);

/** Velocity (m/s) and spin (rad/s) of a disc at the step, half a kick after those of the state. */
struct AtStep {
  double vx, vy, spin;

  AtStep(const jump_state &s, int64_t i)
  {
    const double square = s.radius ? s.radius[i] * s.radius[i] : 1.0, half = 0.5 * s.time_step;
    const double kick = half / s.mass / square;
    vx = s.vx[i] + kick * s.fx[i];
    vy = s.vy[i] + kick * s.fy[i];
    spin = s.omega ? s.omega[i] + half / s.inertia / (square * square) * s.torque[i] : 0.0;
  }
};

/** Largest square of velocities. */
double fastest(const ContactVelocities &seen, int64_t begin, int64_t end);
double fastest(const double (*at)[4], int64_t begin, int64_t end);

}    // namespace jump

#endif
