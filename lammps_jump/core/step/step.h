// SPDX-License-Identifier: GPL-2.0-or-later
/* Steps without events. */

#ifndef JUMP_CORE_STEP_H
#define JUMP_CORE_STEP_H

#include "step/thread_partition.h"

namespace jump {

/** Why steps end: they are done, the list is too old and could not be made here, or overlaps want a look. */
enum StopReason : int64_t { DONE, LIST_STALE, CHECK_OVERLAP };

/** Up to `steps` drifts with forces between them, and before them where `forces_pending`; without steps these alone.

    The forces after the last drift are left to the caller. Returns the drifts done. */
int64_t advance(jump_state &s, ThreadPartition &partition, int64_t steps, bool forces_pending, StopReason &left);

/** Make the lists anew where that can be done here. */
StopReason relist(jump_state &s, ThreadPartition &partition);

}    // namespace jump

#endif
