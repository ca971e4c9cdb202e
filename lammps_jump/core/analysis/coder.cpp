// SPDX-License-Identifier: GPL-2.0-or-later
// The range coder of report/frames.py, which says how it works, and the check of frames that it packed.

#include <algorithm>
#include <cstdlib>
#include <vector>

#include "api.h"

namespace {

constexpr int64_t BASE = 124, LEAST = BASE * BASE * BASE, TOP = LEAST * BASE;
constexpr int64_t SLOTS = 32;        // adaptive bits of a context
constexpr int64_t OF_A_KIND = 32;    // contexts of a kind of numbers
constexpr int64_t COLUMNS = 8;       // numbers of a disc in the table of discs
constexpr int64_t MOST_BITS = 31;
constexpr int64_t UNREST = 8;    // of a disc that has just come

int64_t bits_of(int64_t value)
{
  int64_t length = 0;
  while (value >> length) length++;
  return length;
}

// The place in the interval after some digits, and the odds so far; `read` is beyond `size` after what no coder writes.
struct Reader {
  const uint8_t *digits;
  int64_t size, read = 4, place = 0, span = TOP;
  std::vector<int64_t> odds;

  Reader(const uint8_t *digits, int64_t size, int64_t contexts) : digits(digits), size(size), odds(contexts * SLOTS, 2048)
  {
    for (int k = 0; k < 4; k++) place = place * BASE + digits[k];
  }

  bool broken() const { return read > size; }
  void fail() { read = size + 1; }

  // Makes a part of the interval the interval.
  void shrink(int64_t start, int64_t part, int64_t step)
  {
    place -= start * step;
    span = part * step;
    if (place < 0 || place >= span) return fail();
    for (; span < LEAST; span *= BASE, read++) place = place * BASE + (read < size ? digits[read] : 0);
  }

  // The next number.
  int64_t take(int64_t context)
  {
    int64_t slot = SLOTS * context, left = 0, value = 1;
    while (read <= size) {
      const int64_t ones = odds[slot], step = span >> 12;
      if (place >= ones * step) {
        odds[slot] -= ones >> 5;
        shrink(ones, 4096 - ones, step);
        break;
      }
      odds[slot] += (4096 - ones) >> 5;
      shrink(0, ones, step);
      left++, slot++;
      if (left > MOST_BITS) fail();
    }
    if (left == 0 || broken()) return 0;
    while (left) {
      const int64_t bits = std::min<int64_t>(left, 8), step = span >> bits, part = place / step;
      shrink(part, 1, step);
      value = (value << bits) + part;
      left -= bits;
    }
    return value % 2 ? -(value >> 1) : value >> 1;
  }
};

// Whether the numbers of a map come next, each from 0 to 255.
bool holds_map(Reader &reader, int64_t frames, int64_t cells)
{
  std::vector<int64_t> levels(cells, 0);
  for (int64_t frame = 0; frame < frames; frame++)
    for (int64_t &level : levels) {
      level += reader.take(OF_A_KIND * (4 + COLUMNS) + bits_of(level));
      if (reader.broken() || level < 0 || level >= 256) return false;
    }
  return true;
}

}    // namespace

// Digits of numbers in their contexts; `lengths` are their bits without the sign, `odds` SLOTS numbers a context.
// Returns how many digits there are.
JUMP_API int64_t jump_digits(int64_t n, const int64_t *values, const int64_t *contexts, const int64_t *lengths,
                             int64_t *odds, uint8_t *digits)
{
  int64_t written = 0, low = 0, span = TOP;
  // the first digit is below 2 BASE: what is above BASE - 1 is carried at the end
  const auto write = [&] {
    digits[written++] = static_cast<uint8_t>(low / LEAST);
    low = low % LEAST * BASE;
  };
  const auto put = [&](int64_t start, int64_t size, int bits) {
    const int64_t step = span >> bits;
    low += start * step;
    for (span = size * step; span < LEAST; span *= BASE) write();
  };
  for (int64_t number = 0; number < n; number++) {
    const int64_t length = lengths[number];
    const int64_t plain = (2 * std::abs(values[number]) + (values[number] < 0)) ^ (int64_t(1) << length);
    int64_t *slot = odds + SLOTS * contexts[number];
    for (int64_t ahead = length; ahead >= 0; ahead--, slot++) {
      const int64_t ones = *slot;
      if (ahead) {
        *slot += (4096 - ones) >> 5;
        put(0, ones, 12);
      } else {
        *slot -= ones >> 5;
        put(ones, 4096 - ones, 12);
      }
    }
    for (int64_t left = length; left;) {
      const int bits = static_cast<int>(std::min<int64_t>(left, 8));
      left -= bits;
      put((plain >> left) & ((1 << bits) - 1), 1, bits);
    }
  }
  for (int k = 0; k < 4; k++) write();
  for (int64_t last = written - 1; last > 0; last--) {
    digits[last - 1] += digits[last] / BASE;
    digits[last] %= BASE;
  }
  return written;
}

// Whether digits hold `discs` discs of `rows` rows in all in so many frames, a map, and nothing else.
JUMP_API int64_t jump_holds_frames(const uint8_t *digits, int64_t size, int64_t discs, int64_t rows, int64_t frames,
                                   int64_t shades, int64_t cells)
{
  if (size < 4) return 0;
  Reader reader(digits, size, (4 + COLUMNS + 1) * OF_A_KIND);
  std::vector<int64_t> first(discs), life(discs), unrest(discs, UNREST);
  int64_t column[COLUMNS] = {}, all = 0;
  for (int64_t disc = 0; disc < discs; disc++) {
    for (int64_t k = 0; k < COLUMNS; k++) column[k] += reader.take(OF_A_KIND * (4 + k));
    first[disc] = column[1];
    life[disc] = column[2];
    const bool stays = column[1] >= 0 && column[2] > 0 && column[1] + column[2] <= frames;
    if (reader.broken() || !stays || column[5] < 0 || column[5] >= shades) return 0;
    all += life[disc];
  }
  if (all != rows) return 0;
  for (int64_t frame = 0; frame < frames; frame++)
    for (int64_t disc = 0; disc < discs; disc++) {
      if (frame <= first[disc] || frame - first[disc] >= life[disc]) continue;
      int64_t felt = unrest[disc];
      for (int64_t part = 0; part < 4; part++) {
        const int64_t length = bits_of(felt);
        if (length > MOST_BITS) return 0;
        const int64_t amount = std::abs(reader.take(OF_A_KIND * part + length));
        felt += part < 2 ? 2 * amount : amount >> 1;
      }
      unrest[disc] = (felt - unrest[disc]) >> 1;
      if (reader.broken()) return 0;
    }
  return holds_map(reader, frames, cells) && reader.read == reader.size;
}
