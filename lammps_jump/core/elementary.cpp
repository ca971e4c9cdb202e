// SPDX-License-Identifier: GPL-2.0-or-later
// Elementary functions for who holds them against those of other systems: angles in rad.

#include "api.h"
#include "contact/elementary.h"

JUMP_API double jump_sin(double x) { return jump::sine(x); }
JUMP_API double jump_cos(double x) { return jump::cosine(x); }
JUMP_API double jump_atan2(double y, double x) { return jump::arctangent(y, x); }
