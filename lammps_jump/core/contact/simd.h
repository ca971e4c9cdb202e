// SPDX-License-Identifier: GPL-2.0-or-later
/* Several contacts at a time: a vector of doubles as wide as the machine's, and the operations that the language lacks.

   Written out, because the compiler's own vectors of the same loop take longer (docs/kernels.md). Sums, products and roots
   are rounded as for single numbers: the width changes no result. */

#ifndef JUMP_CORE_SIMD_H
#define JUMP_CORE_SIMD_H

#include "contact/elementary.h"

#include <cstdint>

#ifdef __SSE2__
#include <immintrin.h>
#endif
#ifdef __wasm_simd128__
#include <wasm_simd128.h>
#endif

#pragma GCC diagnostic ignored "-Wpsabi"    // all inline: no vector crosses a library's border

namespace jump {

#if defined(__AVX512F__)
constexpr int LANES = 8;
#elif defined(__AVX__)
constexpr int LANES = 4;
#else
constexpr int LANES = 2;
#endif

typedef double Lanes __attribute__((vector_size(LANES * sizeof(double)), may_alias));

inline Lanes root(const Lanes &x)
{
#if defined(__AVX512F__)
  return (Lanes) _mm512_sqrt_pd((__m512d) x);
#elif defined(__AVX__)
  return (Lanes) _mm256_sqrt_pd((__m256d) x);
#elif defined(__SSE2__)
  return (Lanes) _mm_sqrt_pd((__m128d) x);
#elif defined(__wasm_simd128__)
  return (Lanes) wasm_f64x2_sqrt((v128_t) x);
#else
  return Lanes{std::sqrt(x[0]), std::sqrt(x[1])};
#endif
}

/** The same in every lane. */
inline Lanes spread(double x, const Lanes &) { return x - Lanes{}; }
inline Lanes spread(const Lanes &x, const Lanes &) { return x; }

inline Lanes magnitude(const Lanes &x) { return x < 0.0 ? -x : x; }

#if defined(__has_builtin)
#if __has_builtin(__builtin_shufflevector)
#define JUMP_SHUFFLE(a, b, ...) __builtin_shufflevector(a, b, __VA_ARGS__)
#endif
#endif
#ifndef JUMP_SHUFFLE    // GCC before 12
#define JUMP_SHUFFLE(a, b, ...) __builtin_shuffle(a, b, (decltype((a) < (b))){__VA_ARGS__})
#endif

/** Four numbers or indices at a time, to find pairs that are close: the runs of candidates are too short for eight. */
typedef double Four __attribute__((vector_size(32), may_alias));
typedef int FourInts __attribute__((vector_size(16), aligned(4), may_alias));

/** Two at a time: what x and y of one disc have. */
typedef double Two __attribute__((vector_size(16), aligned(8), may_alias));

/** Four at any place. */
typedef double AnyFour __attribute__((vector_size(32), aligned(8), may_alias));

/** Four that follow each other, from any place. */
inline Four four(const double *from) { return *reinterpret_cast<const AnyFour *>(from); }

inline FourInts four(const int *from) { return *reinterpret_cast<const FourInts *>(from); }

/** Whether four that are compared make bits, and go by them, in a few of the machine's operations. */
#if defined(__AVX__) || defined(__wasm_simd128__)
constexpr bool HAS_FOUR = true;
#else
constexpr bool HAS_FOUR = false;
#endif

/** Truths as the bits of a number, the first as the lowest. */
inline int bits(decltype(Four{} < Four{}) four)
{
#ifdef __AVX__
  return _mm256_movemask_pd((__m256d) four);
#elif defined(__wasm_simd128__)
  const v128_t low = (v128_t) JUMP_SHUFFLE(four, four, 0, 1), high = (v128_t) JUMP_SHUFFLE(four, four, 2, 3);
  return (int) (wasm_i64x2_bitmask(low) | wasm_i64x2_bitmask(high) << 2);
#else
  return (int) ((four[0] & 1) | (four[1] & 2) | (four[2] & 4) | (four[3] & 8));
#endif
}

/** Places of the bits of a number below 16, in their order. */
alignas(16) inline constexpr int PLACES[16][4] = {{}, {0}, {1}, {0, 1}, {2}, {0, 2}, {1, 2}, {0, 1, 2}, {3}, {0, 3},
                                                  {1, 3}, {0, 1, 3}, {2, 3}, {0, 2, 3}, {1, 2, 3}, {0, 1, 2, 3}};

#ifdef __wasm_simd128__
/** Places of their bytes. */
struct BytesOfPlaces {
  alignas(16) uint8_t at[16][16] = {};

  constexpr BytesOfPlaces()
  {
    for (int mask = 0; mask < 16; mask++)
      for (int byte = 0; byte < 16; byte++) at[mask][byte] = (uint8_t) (4 * PLACES[mask][byte / 4] + byte % 4);
  }
};

inline constexpr BytesOfPlaces PLACES_OF_BYTES;
#endif

/** Those of four numbers whose bit is set come first. */
inline FourInts first_of(const FourInts &four, int mask)
{
#ifdef __wasm_simd128__
  return (FourInts) wasm_i8x16_swizzle((v128_t) four, wasm_v128_load(PLACES_OF_BYTES.at[mask]));
#else
  const int *const at = PLACES[mask];
#ifdef __AVX__
  return (FourInts) _mm_permutevar_ps((__m128) four, *reinterpret_cast<const __m128i *>(at));
#else
  return FourInts{four[at[0]], four[at[1]], four[at[2]], four[at[3]]};
#endif
#endif
}

/** Four vectors of four: to[r][c] = column c [r]. */
inline void transpose4(const Four &a, const Four &b, const Four &c, const Four &d, Four (&to)[4])
{
#if defined(__SSE2__) && !defined(__AVX__)    // by halves: the compiler takes the shuffles below apart
  const Four *const from[] = {&a, &b, &c, &d};
  for (int pair = 0; pair < 2; pair++)
    for (int half = 0; half < 2; half++) {
      const __m128d one = reinterpret_cast<const __m128d *>(from[2 * pair])[half];
      const __m128d two = reinterpret_cast<const __m128d *>(from[2 * pair + 1])[half];
      reinterpret_cast<__m128d *>(&to[2 * half])[pair] = _mm_unpacklo_pd(one, two);
      reinterpret_cast<__m128d *>(&to[2 * half + 1])[pair] = _mm_unpackhi_pd(one, two);
    }
#else
  const Four ab0 = JUMP_SHUFFLE(a, b, 0, 4, 2, 6), ab1 = JUMP_SHUFFLE(a, b, 1, 5, 3, 7);
  const Four cd0 = JUMP_SHUFFLE(c, d, 0, 4, 2, 6), cd1 = JUMP_SHUFFLE(c, d, 1, 5, 3, 7);
  to[0] = JUMP_SHUFFLE(ab0, cd0, 0, 1, 4, 5);
  to[1] = JUMP_SHUFFLE(ab1, cd1, 0, 1, 4, 5);
  to[2] = JUMP_SHUFFLE(ab0, cd0, 2, 3, 6, 7);
  to[3] = JUMP_SHUFFLE(ab1, cd1, 2, 3, 6, 7);
#endif
}

/** Four vectors as four rows of four numbers. */
inline void rows_of_four(const Four &a, const Four &b, const Four &c, const Four &d, double (*rows)[4])
{
  Four turned[4];
  transpose4(a, b, c, d, turned);
  for (int r = 0; r < 4; r++) *reinterpret_cast<AnyFour *>(rows[r]) = turned[r];
}

/** Rows of four numbers, one for each lane, as four vectors: column[c][row] = rows[row][c].

    And rows_of_two: two vectors as rows of two numbers. */
#if defined(__AVX512F__)
inline void deinterleave(const double (*rows)[4], Lanes column[4])
{
  const Lanes *const two = reinterpret_cast<const Lanes *>(rows);    // two rows each
  const Lanes xy0 = JUMP_SHUFFLE(two[0], two[1], 0, 4, 8, 12, 1, 5, 9, 13);
  const Lanes xy4 = JUMP_SHUFFLE(two[2], two[3], 0, 4, 8, 12, 1, 5, 9, 13);
  const Lanes uv0 = JUMP_SHUFFLE(two[0], two[1], 2, 6, 10, 14, 3, 7, 11, 15);
  const Lanes uv4 = JUMP_SHUFFLE(two[2], two[3], 2, 6, 10, 14, 3, 7, 11, 15);
  column[0] = JUMP_SHUFFLE(xy0, xy4, 0, 1, 2, 3, 8, 9, 10, 11);
  column[1] = JUMP_SHUFFLE(xy0, xy4, 4, 5, 6, 7, 12, 13, 14, 15);
  column[2] = JUMP_SHUFFLE(uv0, uv4, 0, 1, 2, 3, 8, 9, 10, 11);
  column[3] = JUMP_SHUFFLE(uv0, uv4, 4, 5, 6, 7, 12, 13, 14, 15);
}

inline void rows_of_two(const Lanes &x, const Lanes &y, double (*rows)[2])
{
  Lanes *const four = reinterpret_cast<Lanes *>(rows);    // four rows each
  four[0] = JUMP_SHUFFLE(x, y, 0, 8, 1, 9, 2, 10, 3, 11);
  four[1] = JUMP_SHUFFLE(x, y, 4, 12, 5, 13, 6, 14, 7, 15);
}
#elif defined(__AVX__)
inline void deinterleave(const double (*rows)[4], Lanes column[4])
{
  const Lanes *const row = reinterpret_cast<const Lanes *>(rows);
  const Lanes xu0 = JUMP_SHUFFLE(row[0], row[1], 0, 4, 2, 6), yv0 = JUMP_SHUFFLE(row[0], row[1], 1, 5, 3, 7);
  const Lanes xu2 = JUMP_SHUFFLE(row[2], row[3], 0, 4, 2, 6), yv2 = JUMP_SHUFFLE(row[2], row[3], 1, 5, 3, 7);
  column[0] = JUMP_SHUFFLE(xu0, xu2, 0, 1, 4, 5);
  column[1] = JUMP_SHUFFLE(yv0, yv2, 0, 1, 4, 5);
  column[2] = JUMP_SHUFFLE(xu0, xu2, 2, 3, 6, 7);
  column[3] = JUMP_SHUFFLE(yv0, yv2, 2, 3, 6, 7);
}

inline void rows_of_two(const Lanes &x, const Lanes &y, double (*rows)[2])
{
  Lanes *const two = reinterpret_cast<Lanes *>(rows);    // two rows each
  const Lanes even = JUMP_SHUFFLE(x, y, 0, 4, 2, 6), odd = JUMP_SHUFFLE(x, y, 1, 5, 3, 7);
  two[0] = JUMP_SHUFFLE(even, odd, 0, 1, 4, 5);
  two[1] = JUMP_SHUFFLE(even, odd, 2, 3, 6, 7);
}
#else
inline void deinterleave(const double (*rows)[4], Lanes column[4])
{
  for (int c = 0; c < 4; c++) column[c] = Lanes{rows[0][c], rows[1][c]};
}

inline void rows_of_two(const Lanes &x, const Lanes &y, double (*rows)[2])
{
  for (int lane = 0; lane < LANES; lane++) {
    rows[lane][0] = x[lane];
    rows[lane][1] = y[lane];
  }
}
#endif

}    // namespace jump

#endif
