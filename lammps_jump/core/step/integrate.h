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

/** Of discs `begin` to `end`: v += dt F/m, x += dt v, F = weight.

    `taken` has a place for each block of all discs; without a ledger it is not used. `rows` is as of `show`. Returns the number of discs further
    than half the skin from their place in the list. A NaN counts as moved. */
int64_t drift(const jump_state &s, int64_t begin, int64_t end, Dissipated *taken, double (*rows)[4]);

/** Put place and velocity of these discs, as contacts see them, into a row of each. */
void show(const jump_state &s, int64_t begin, int64_t end, double (*rows)[4]);

/** Largest square of the velocities that contacts see. */
double fastest(const ContactVelocities &seen, int64_t begin, int64_t end);

}    // namespace jump

#endif
