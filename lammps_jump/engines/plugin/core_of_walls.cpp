// SPDX-License-Identifier: GPL-2.0-or-later
/* What of the core's step the plugin is host to. */

#include "step/wall_forces.cpp"
#include "walls/bodies.cpp"
#include "walls/near_lists.cpp"
