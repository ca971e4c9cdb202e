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
    lose. They are what steps go on from; arrays of the state have them before and behind. */
struct StepRows {
  double (*at)[4], (*forces)[4];
};

/** Take discs `begin` to `end` from the arrays of the state. */
void load(const jump_state &s, int64_t begin, int64_t end, const StepRows &rows);

/** Put them back. */
void store(const jump_state &s, int64_t begin, int64_t end, const StepRows &rows);

/** Of discs `begin` to `end`: v += dt F/m, x += dt v, F = weight.

    `taken` has a place for each block of all discs; without a ledger it is not used. `next` takes the places and velocities. Returns
    the number of discs further than half the skin from their place in the list. A NaN counts as moved. */
int64_t drift(const jump_state &s, int64_t begin, int64_t end, Dissipated *taken, const StepRows &rows, double (*next)[4]);

/** Largest square of velocities. */
double fastest(const ContactVelocities &seen, int64_t begin, int64_t end);
double fastest(const double (*at)[4], int64_t begin, int64_t end);

}    // namespace jump

#endif
