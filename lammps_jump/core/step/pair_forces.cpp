// SPDX-License-Identifier: GPL-2.0-or-later
/* Forces of touching pairs as the native engine sums them. */

#include "step/pair_sums.h"

template void jump::pair_forces<jump::WithLosses>(const jump_state &, double, ThreadPart &, ListRows);
