// SPDX-License-Identifier: GPL-2.0-or-later
/* Operations of a number, by the names that a vector of numbers has too (simd.h).

   All of the core is compiled without contraction and without `fastmath` (build.py): every operation is rounded as it is
   written. */

#ifndef JUMP_CORE_SCALAR_OPS_H
#define JUMP_CORE_SCALAR_OPS_H

#include <cmath>

namespace jump {

constexpr double PI = 3.14159265358979323846;

inline double root(double x) { return std::sqrt(x); }
inline double magnitude(double x) { return std::fabs(x); }

/** A number in the form of another: itself, or the same in every lane. */
inline double spread(double x, double) { return x; }

template <class Number> inline Number least(const Number &a, const Number &b) { return a < b ? a : b; }
template <class Number> inline Number most(const Number &a, const Number &b) { return a > b ? a : b; }

}    // namespace jump

#endif
