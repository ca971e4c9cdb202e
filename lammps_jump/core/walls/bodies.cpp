// SPDX-License-Identifier: GPL-2.0-or-later
/* Contacts of bodies on the native engine (bodies.h). */

#include "contact/no_contraction.h"

#include "walls/bodies.h"

void jump::body_forces(const jump_state &s, double slope) { push_bodies(s, slope); }

double jump::body_elastic(const jump_state &s) { return stored_by_bodies(s); }
