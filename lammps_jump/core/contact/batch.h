// SPDX-License-Identifier: GPL-2.0-or-later
/* Touching pairs of discs that are looked at together: selected without a branch, often guessed wrong, and evaluated in
   vectors. The native engine and the plugin sum what comes out, each in its own order. */

#ifndef JUMP_CORE_BATCH_H
#define JUMP_CORE_BATCH_H

#include "contact/simd.h"    // before the law: its templates take vectors

#include "contact/contact.h"

#include <cstdint>

namespace jump {

/** As many numbers as a vector has, from an aligned place. */
inline Lanes &lanes(double *from) { return *reinterpret_cast<Lanes *>(from); }

/** Squares of the lengths of four differences, by their first two numbers. */
inline Four square_of(const Four &a, const Four &b, const Four &c, const Four &d)
{
  const Four aa = a * a, bb = b * b, cc = c * c, dd = d * d;
  const Four ab = JUMP_SHUFFLE(aa, bb, 0, 4, 2, 6) + JUMP_SHUFFLE(aa, bb, 1, 5, 3, 7);
  const Four cd = JUMP_SHUFFLE(cc, dd, 0, 4, 2, 6) + JUMP_SHUFFLE(cc, dd, 1, 5, 3, 7);
  return JUMP_SHUFFLE(ab, cd, 0, 1, 4, 5);
}

/** Contacts that remember nothing. */
struct NoPairMemory {
  static constexpr bool REMEMBERS = false;
};

/** Up to ROOM pairs; each column is a number of each of them, side 0 of the first disc and 1 of the second. */
template <int ROOM> struct ContactBatch {
  int n = 0;
  int32_t one[ROOM + 4], two[ROOM + 4];    // their discs; room for four that are written at once
  int32_t place[ROOM + 4];                 // in the list
  alignas(64) double between[ROOM][4];     // from the second disc to the first: x, y, vx, vy
  alignas(64) double radius[2][ROOM], bulk[2][ROOM], spin[2][ROOM], moment[2][ROOM];
  alignas(64) double slide[ROOM], roll[ROOM];    // springs, before and after the step

  Four &difference(int c) { return *reinterpret_cast<Four *>(between[c]); }

  /** Take those of the pairs first[from] second[from] to `to` that touch; `at` has place and velocity of each disc. With a memory of
      pairs their places are kept, and it sees which touch. */
  template <bool SIZES, class Place, class Memory = NoPairMemory>
  void find(const double (*at)[4], const double *__restrict radii, double diameter, const int32_t *__restrict first,
            const int32_t *__restrict second, Place from, Place to, Memory *memory = nullptr)
  {
    const auto disc = [=](int64_t i) -> const Four & { return *reinterpret_cast<const Four *>(at[i]); };
    const auto apart = [&](Place p) { return disc(first[p]) - disc(second[p]); };
    const auto reach = [=](Place p) { return SIZES ? radii[first[p]] + radii[second[p]] : diameter; };
    int found = 0;
    Place p = from;
    for (; HAS_FOUR && p + 4 <= to; p += 4) {
      const Four reaches = {reach(p), reach(p + 1), reach(p + 2), reach(p + 3)};
      const int mask = bits(square_of(apart(p), apart(p + 1), apart(p + 2), apart(p + 3)) < reaches * reaches);
      *reinterpret_cast<FourInts *>(one + found) = first_of(four(first + p), mask);
      *reinterpret_cast<FourInts *>(two + found) = first_of(four(second + p), mask);
      if constexpr (Memory::REMEMBERS) {
        const int q = (int) p;
        *reinterpret_cast<FourInts *>(place + found) = first_of(FourInts{q, q + 1, q + 2, q + 3}, mask);
        memory->see_four(p, mask);
      }
      found += __builtin_popcount(mask);
    }
    for (; p < to; p++) {    // the last ones, and all of them without AVX
      const Four a = apart(p);
      one[found] = first[p];
      two[found] = second[p];
      const bool touches = a[0] * a[0] + a[1] * a[1] < reach(p) * reach(p);
      if constexpr (Memory::REMEMBERS) {
        place[found] = (int32_t) p;
        memory->see(p, touches);
      }
      found += touches;
    }
    n = found;
  }

  /** Fill the last vector with a contact that nobody reads; `usual` is a radius, m. */
  void fill(double usual)
  {
    for (int c = n; c % LANES != 0 || c % 4 != 0; c++) {
      difference(c) = Four{usual, usual, 0.0, 0.0};
      slide[c] = roll[c] = 0.0;
      for (int side = 0; side < 2; side++) {
        spin[side][c] = 0.0;
        radius[side][c] = bulk[side][c] = usual;
      }
    }
  }

  /** Calls put(c, force) for vectors of contacts, c of the first. HEAVY: radii represent other masses (`bulk`); `usual`: radius
      of equal discs, m. Springs go on, and moments are kept. */
  template <bool SIZES, bool SPIN, class Law, class Put>
  void evaluate(const Law &law, const Numbers<Lanes> &of, bool heavy, double usual, const Put &put)
  {
    constexpr bool HISTORY = Law::Friction::HAS_HISTORY;
    const Lanes half = spread(usual, Lanes{});
    for (int c = 0, count = n; c < count; c += LANES) {
      Lanes gap[4];
      deinterleave(between + c, gap);
      Pair<Lanes> pair;
      pair.dx = gap[0], pair.dy = gap[1], pair.vx = gap[2], pair.vy = gap[3];
      pair.apart2 = pair.dx * pair.dx + pair.dy * pair.dy;
      pair.a = SIZES ? lanes(radius[0] + c) : half;
      pair.b = SIZES ? lanes(radius[1] + c) : half;
      if constexpr (SIZES) {
        pair.bulk_a = heavy ? lanes(bulk[0] + c) : pair.a;
        pair.bulk_b = heavy ? lanes(bulk[1] + c) : pair.b;
      }
      if constexpr (SPIN) {
        pair.spin_a = lanes(spin[0] + c);
        pair.spin_b = lanes(spin[1] + c);
      }
      Stretch<Lanes> held{};
      if constexpr (HISTORY) held = {lanes(slide + c), SPIN ? lanes(roll + c) : Lanes{}};
      const PairForce<Lanes> out = pair_contact<SIZES, SPIN>(law, of, pair, held);
      put(c, out);
      if constexpr (HISTORY) {
        lanes(slide + c) = held.slide;
        if constexpr (SPIN) lanes(roll + c) = held.roll;
      }
      if constexpr (SPIN) {
        lanes(moment[0] + c) = out.on_a;
        lanes(moment[1] + c) = out.on_b;
      }
    }
  }
};

}    // namespace jump

#endif
