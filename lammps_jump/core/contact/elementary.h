// SPDX-License-Identifier: GPL-2.0-or-later
/* Sine, cosine and arctangent with the same bits on every system, within 1 unit in the last place.

   Libraries of systems differ in the last bit of these; sums, products, quotients and roots do not. The argument of sine and
   cosine is reduced by pi/2 with 192 bits of 2/pi (Payne and Hanek 1983, SIGNUM Newsletter 18:19). Sums of two numbers and
   their error are those of Knuth and Dekker (Muller et al. 2018, Handbook of Floating-Point Arithmetic, 4.3 and 4.4).
   physics/elementary.py has the same operations in the same order; tests compare the bits.

   All of the core is compiled without contraction and without `fastmath` (compiling/product.py): every operation is rounded as it
   is written. */

#ifndef JUMP_CORE_ELEMENTARY_H
#define JUMP_CORE_ELEMENTARY_H

#include <cmath>
#include <cstdint>
#include <limits>

namespace jump {

/* Operations of a number, by the names that a vector of numbers has too (simd.h). */

constexpr double PI = 3.14159265358979323846;

inline double root(double x) { return std::sqrt(x); }
inline double magnitude(double x) { return std::fabs(x); }

/** A number in the form of another: itself, or the same in every lane. */
inline double spread(double x, double) { return x; }

template <class Number> inline Number least(const Number &a, const Number &b) { return a < b ? a : b; }
template <class Number> inline Number most(const Number &a, const Number &b) { return a > b ? a : b; }

/** A double, and what it lacks of the number that is meant. */
struct Double {
  double high, low;
};

constexpr Double QUARTER_TURN = {1.5707963267948966, 6.123233995736766e-17};
constexpr double EIGHTH_TURN = 0.7853981633974483;

/** Rounded product, and its error. */
inline Double product(double a, double b)
{
  const double high = a * b;
  double t = 134217729.0 * a;
  const double a1 = t - (t - a), a2 = a - a1;
  t = 134217729.0 * b;
  const double b1 = t - (t - b), b2 = b - b1;
  return {high, ((a1 * b1 - high) + a1 * b2 + a2 * b1) + a2 * b2};
}

/** Rounded sum, and its error. */
inline Double whole_sum(double a, double b)
{
  const double high = a + b, c = high - a;
  return {high, (a - (high - c)) + (b - c)};
}

/** The window of `words` (least first) that begins `begin` digits after the point of 2/pi; 64 digits 0 precede it. */
inline void window_of_two_over_pi(int begin, uint32_t words[6])
{
  static constexpr uint32_t DIGITS[39] = {
      0,          0,          0xa2f9836e, 0x4e441529, 0xfc2757d1, 0xf534ddc0, 0xdb629599, 0x3c439041, 0xfe5163ab, 0xdebbc561,
      0xb7246e3a, 0x424dd2e0, 0x06492eea, 0x09d1921c, 0xfe1deb1c, 0xb129a73e, 0xe88235f5, 0x2ebb4484, 0xe99c7026, 0xb45f7e41,
      0x3991d639, 0x835339f4, 0x9c845f8b, 0xbdf9283b, 0x1ff897ff, 0xde05980f, 0xef2f118b, 0x5a0a6d1f, 0x6d367ecf, 0x27cb09b7,
      0x4f463f66, 0x9e5fea2d, 0x7527bac7, 0xebe5f17b, 0x3d0739f7, 0x8a5292ea, 0x6bfb5fb1, 0x1f8d5d08, 0x56033046};
  const int first = begin / 32, shift = begin % 32;
  for (int i = 0; i < 6; ++i) {
    const uint64_t two = uint64_t(DIGITS[first + i]) << 32 | DIGITS[first + i + 1];
    words[5 - i] = uint32_t(two << shift >> 32);
  }
}

/** x as mantissa · 2^exponent, of a normal x > 0: 53 binary digits. */
inline uint64_t mantissa_of(double x, int &exponent)
{
  const double fraction = std::frexp(x, &exponent);
  exponent -= 53;
  return uint64_t(std::ldexp(fraction, 53));
}

/** What is left of a turn of x > 0: 4 quadrants are 2^192, least words first. */
inline void turn_of(double x, uint32_t turned[6])
{
  int exponent;
  const uint64_t mantissa = mantissa_of(x, exponent);
  uint32_t words[6];
  window_of_two_over_pi(exponent - 2 + 64, words);
  for (int i = 0; i < 6; ++i) turned[i] = 0;
  for (int j = 0; j < 2; ++j) {
    const uint64_t by = j == 0 ? mantissa & 0xffffffffu : mantissa >> 32;
    uint64_t carry = 0;
    for (int i = 0; i + j < 6; ++i) {
      carry += turned[i + j] + by * words[i];
      turned[i + j] = uint32_t(carry);
      carry >>= 32;
    }
  }
}

/** The positive number of 192 binary digits `left` (least words first), with the digit of 2^190 as 1. */
inline Double number_of(const uint32_t left[6])
{
  uint64_t top = uint64_t(left[5]) << 32 | left[4], middle = uint64_t(left[3]) << 32 | left[2],
           last = uint64_t(left[1]) << 32 | left[0];
  int places = 0;
  while (!(top >> 63) && places < 191) {
    top = top << 1 | middle >> 63;
    middle = middle << 1 | last >> 63;
    last <<= 1;
    ++places;
  }
  const double high = std::ldexp(double(top >> 11), 11 - 62 - places);
  return {high, std::ldexp(double((top & 0x7ff) << 42 | middle >> 22), -42 - 62 - places)};
}

/** An angle: quadrant, and what is left of it within ± pi/4. */
struct Reduced {
  int quadrant;
  Double rest;
};

/** Of a finite x > pi/4. */
inline Reduced reduced(double x)
{
  uint32_t left[6];
  turn_of(x, left);
  const int quadrant = int(left[5] >> 30) + int(left[5] >> 29 & 1);
  left[5] &= 0x3fffffffu;
  const bool below = left[5] >> 29;
  if (below) {
    uint64_t carry = 1;
    for (int i = 0; i < 6; ++i) {
      carry += uint32_t(~left[i]);
      left[i] = uint32_t(carry);
      carry >>= 32;
    }
    left[5] &= 0x3fffffffu;
  }
  const Double share = number_of(left);
  Double rest = product(share.high, QUARTER_TURN.high);
  rest.low += share.high * QUARTER_TURN.low + share.low * QUARTER_TURN.high;
  rest = whole_sum(rest.high, rest.low);
  return {quadrant & 3, below ? Double{-rest.high, -rest.low} : rest};
}

/** Sine of a number within ± pi/4: its Taylor series, whose next term is below 1e-19. */
inline double near_sine(const Double &angle)
{
  static constexpr double SERIES[8] = {1.0 / 6,        1.0 / 120,        1.0 / 5040,          1.0 / 362880,
                                       1.0 / 39916800, 1.0 / 6227020800, 1.0 / 1307674368000, 1.0 / 355687428096000};
  const double x = angle.high, z = x * x;
  double series = SERIES[7];
  for (int k = 6; k >= 0; --k) series = SERIES[k] - z * series;
  return x - (x * (z * series) - (angle.low - 0.5 * z * angle.low));
}

/** Cosine of a number within ± pi/4. */
inline double near_cosine(const Double &angle)
{
  static constexpr double SERIES[8] = {1.0 / 24,        1.0 / 720,         1.0 / 40320,          1.0 / 3628800,
                                       1.0 / 479001600, 1.0 / 87178291200, 1.0 / 20922789888000, 1.0 / 6402373705728000};
  const double z = angle.high * angle.high;
  double series = SERIES[7];
  for (int k = 6; k >= 0; --k) series = SERIES[k] - z * series;
  const double half = 0.5 * z, whole = 1.0 - half;
  return whole + (((1.0 - whole) - half) + (z * (z * series) - angle.high * angle.low));
}

/** Sine of x (rad). */
inline double sine(double x)
{
  const double size = std::fabs(x);
  if (!(size < std::numeric_limits<double>::infinity())) return std::numeric_limits<double>::quiet_NaN();
  if (size < 1e-8) return x;
  if (size <= EIGHTH_TURN) return near_sine({x, 0.0});
  const Reduced angle = reduced(size);
  const double value = angle.quadrant & 1 ? near_cosine(angle.rest) : near_sine(angle.rest);
  return (angle.quadrant > 1) != (x < 0.0) ? -value : value;
}

/** Cosine of x (rad). */
inline double cosine(double x)
{
  const double size = std::fabs(x);
  if (!(size < std::numeric_limits<double>::infinity())) return std::numeric_limits<double>::quiet_NaN();
  if (size <= EIGHTH_TURN) return near_cosine({size, 0.0});
  const Reduced angle = reduced(size);
  const double value = angle.quadrant & 1 ? near_sine(angle.rest) : near_cosine(angle.rest);
  return angle.quadrant == 1 || angle.quadrant == 2 ? -value : value;
}

/** Arctangent of a/b, 0 < a <= b, both of moderate size: that of the nearest eighth, and a series for what is left. */
inline Double near_arctangent(double a, double b)
{
  static constexpr double SERIES[6] = {1.0 / 3, 1.0 / 5, 1.0 / 7, 1.0 / 9, 1.0 / 11, 1.0 / 13};
  static constexpr Double EIGHTHS[9] = {
      {0.0, 0.0},
      {0.12435499454676144, -3.1253241424539383e-18},
      {0.24497866312686414, 1.0698755618734451e-17},
      {0.35877067027057225, -2.4623815582638635e-17},
      {0.4636476090008061, 2.2698777452961687e-17},
      {0.5585993153435624, -5.4556305485916264e-18},
      {0.6435011087932844, 1.5834785051444286e-17},
      {0.7188299996216245, -2.1478388444456983e-17},
      {0.7853981633974483, 3.061616997868383e-17}};
  const int eighth = int(8.0 * (a / b) + 0.5);
  const double c = 0.125 * eighth;
  Double part = product(c, b);
  Double top = whole_sum(a, -part.high);
  top.low -= part.low;
  part = product(c, a);
  Double under = whole_sum(b, part.high);
  under.low += part.low;
  const double u = top.high / under.high;
  part = product(u, under.high);
  const double error = ((((top.high - part.high) - part.low) + top.low) - u * under.low) / under.high;
  const double z = u * u;
  double series = SERIES[5];
  for (int k = 4; k >= 0; --k) series = SERIES[k] - z * series;
  const Double turn = whole_sum(EIGHTHS[eighth].high, u);
  return whole_sum(turn.high, turn.low + ((EIGHTHS[eighth].low + error) - u * (z * series)));
}

/** Angle of the point (x, y), whose coordinates are finite and not 0. */
inline double angle_of(double y, double x)
{
  double a = std::fabs(y), b = std::fabs(x);
  const bool steep = a > b;
  if (steep) {
    const double other = a;
    a = b, b = other;
  }
  int over, under;
  std::frexp(a, &over), std::frexp(b, &under);
  if (over - under < -80) {    // what the quotient adds to a right angle is below its last bit
    if (steep) return std::copysign(QUARTER_TURN.high, y);
    return x > 0.0 ? y / x : std::copysign(2.0 * QUARTER_TURN.high, y);
  }
  Double angle = near_arctangent(std::ldexp(a, -under), std::ldexp(b, -under));
  if (steep) {
    const Double turned = whole_sum(QUARTER_TURN.high, -angle.high);
    angle = whole_sum(turned.high, turned.low + (QUARTER_TURN.low - angle.low));
  }
  if (x > 0.0) return std::copysign(angle.high + angle.low, y);
  const Double turned = whole_sum(2.0 * QUARTER_TURN.high, -angle.high);
  return std::copysign(turned.high + (turned.low + (2.0 * QUARTER_TURN.low - angle.low)), y);
}

/** Angle of the point (x, y), rad, from -pi to pi; zeros, infinities and NaN as in C. */
inline double arctangent(double y, double x)
{
  if (y != y || x != x) return std::numeric_limits<double>::quiet_NaN();
  if (std::isinf(y) || std::isinf(x)) {
    y = std::copysign(std::isinf(y) ? 1.0 : 0.0, y);
    x = std::copysign(std::isinf(x) ? 1.0 : 0.0, x);
  }
  if (y == 0.0) return std::signbit(x) ? std::copysign(2.0 * QUARTER_TURN.high, y) : y;
  if (x == 0.0) return std::copysign(QUARTER_TURN.high, y);
  return angle_of(y, x);
}

}    // namespace jump

#endif
