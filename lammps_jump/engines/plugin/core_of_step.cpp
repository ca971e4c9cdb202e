// SPDX-License-Identifier: GPL-2.0-or-later
/* What of the core's step the plugin is host to, other than the forces of pairs. */

#include "step/pair_search.h"    // before the core: its templates take vectors

#include "step/integrate.cpp"
#include "contact/no_contraction.h"    // before what takes contacts one at a time
#include "step/lists.cpp"
#include "step/wall_forces.cpp"
#include "sums/sums.cpp"
#include "walls/near_lists.cpp"
