// SPDX-License-Identifier: GPL-2.0-or-later
/* Include this first in a unit that computes contacts one at a time.

   GCC 12.0 to 12.2 contract a difference next to a sum, like fx - t ny and fy + t nx, into one rounding in spite of
   -ffp-contract=off (GCC bug 107647), where they make a vector of the two. Results would then depend on what else is in a unit. */

#ifndef JUMP_CORE_NO_CONTRACTION_H
#define JUMP_CORE_NO_CONTRACTION_H

#if defined(__GNUC__) && !defined(__clang__) && __GNUC__ == 12 && __GNUC_MINOR__ < 3
#pragma GCC optimize("no-tree-slp-vectorize")
#endif

#endif
