// SPDX-License-Identifier: GPL-2.0-or-later
/* The core's forces of pairs as the plugin sums them. */

#define JUMP_SUMS ForcesAlone
#include "step/pair_sums.cpp"
