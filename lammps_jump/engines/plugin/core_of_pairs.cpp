// SPDX-License-Identifier: GPL-2.0-or-later
/* The core's forces of pairs as the plugin sums them. */

#include "step/pair_sums.h"

template void jump::pair_forces<jump::ForcesAlone>(const jump_state &, double, ThreadPart &, ListRows);
