// SPDX-License-Identifier: GPL-2.0-or-later
// Rows of decimal numbers of a text dump to doubles, each rounded once.

#include <limits>

#include "api.h"

namespace {

// Whether a row is there, and what stops the reading else; dump/formats.py has the same numbers.
enum { ROWS_DONE, NEED_MORE, NOT_PLAIN, NEW_ITEM };

constexpr int64_t LARGEST = 290;    // exponent of ten in the tables, from -LARGEST on
constexpr int MOST_DIGITS = 18;     // of a mantissa that fits into 64 bits
constexpr int64_t EXACT = int64_t(1) << 53;

// a as two parts of 26 bits, whose products are exact
struct Halves {
  double high, low;

  explicit Halves(double a)
  {
    const double t = 134217729.0 * a;
    high = t - (t - a);
    low = a - high;
  }
};

// mantissa * 10^exponent for |mantissa| < 10^18, rounded once: a product in twice the precision (Dekker 1971).
// `high` and `low` are the powers of ten as unevaluated sums.
double scaled(int64_t mantissa, int64_t exponent, const double *high, const double *low)
{
  if (mantissa < EXACT && -22 <= exponent && exponent <= 22)
    return exponent < 0 ? mantissa / high[LARGEST - exponent] : mantissa * high[LARGEST + exponent];
  const double a = static_cast<double>(mantissa);
  const double a_low = static_cast<double>(mantissa - static_cast<int64_t>(a));
  const double b = high[LARGEST + exponent];
  const double product = a * b;
  const Halves one(a), two(b);
  const double error = ((one.high * two.high - product) + one.high * two.low + one.low * two.high) + one.low * two.low;
  return product + (error + (a * low[LARGEST + exponent] + a_low * b));
}

bool blank(uint8_t c) { return c == ' ' || c == '\t'; }
bool digit(uint8_t c) { return c >= '0' && c <= '9'; }

// A part of a text that is read from its begin on.
struct TextReader {
  const uint8_t *data;
  int64_t place, end;

  bool over() const { return place >= end; }
  uint8_t now() const { return data[place]; }
};

// Reads a number that begins at the place; ROWS_DONE where it is one and ends before the text does.
int number(TextReader &text, const double *high, const double *low, double &value)
{
  const bool negative = text.now() == '-';
  if (negative || text.now() == '+') text.place++;
  int64_t mantissa = 0, exponent = 0;
  int significant = 0, digits = 0;
  bool after_point = false;
  for (; !text.over(); text.place++) {
    const uint8_t c = text.now();
    if (digit(c)) {
      mantissa = mantissa * 10 + (c - '0');
      digits++;
      if (mantissa > 0 && ++significant > MOST_DIGITS) return NOT_PLAIN;
      exponent -= after_point;
    } else if (c == '.' && !after_point) {
      after_point = true;
    } else {
      break;
    }
  }
  if (!text.over() && digits > 0 && (text.now() == 'e' || text.now() == 'E')) {
    text.place++;
    bool minus = false;
    if (!text.over() && (text.now() == '-' || text.now() == '+')) minus = text.data[text.place++] == '-';
    int64_t power = 0;
    int length = 0;
    for (; !text.over() && digit(text.now()); text.place++, length++)
      if (length < 4) power = power * 10 + (text.now() - '0');
    if (!text.over() && (length == 0 || length > 4)) return NOT_PLAIN;
    exponent += minus ? -power : power;
  }
  if (text.over()) return NEED_MORE;
  if (digits == 0 || text.now() > ' ') return NOT_PLAIN;
  value = 0.0;
  if (mantissa != 0) {
    if (exponent < -LARGEST || exponent > LARGEST - 20) return NOT_PLAIN;
    value = scaled(mantissa, exponent, high, low);
  }
  if (negative) value = -value;
  return ROWS_DONE;
}

}    // namespace

#define JUMP_PARSE_ROWS(FIELD) \
  FIELD(const uint8_t *, data) FIELD(int64_t, end) FIELD(int64_t *, at) FIELD(double *, out) FIELD(int64_t, columns) \
  FIELD(int64_t, rows) FIELD(const uint8_t *, is_text) FIELD(const double *, high) FIELD(const double *, low)
JUMP_INPUT(jump_parse_rows, JUMP_PARSE_ROWS)

// Parses rows into out[column * rows + row] from the text on. `at` holds the first row that is wanted and where it
// starts, and takes how far the reading came. A row counts only with its newline.
JUMP_API int64_t jump_parse_rows(const jump_parse_rows_input *input)
{
  JUMP_PARSE_ROWS(JUMP_LOCAL)
  for (; at[0] < rows; at[0]++) {
    TextReader text{data, at[1], end};
    for (int64_t column = 0; column < columns; column++) {
      double &value = out[column * rows + at[0]];
      while (!text.over() && blank(text.now())) text.place++;
      if (text.over()) return NEED_MORE;
      if (is_text[column] && text.now() > ' ') {
        while (!text.over() && text.now() > ' ') text.place++;
        value = std::numeric_limits<double>::quiet_NaN();
        if (text.over()) return NEED_MORE;
        continue;
      }
      if (column == 0 && text.now() == 'I') return NEW_ITEM;    // of ITEM:
      if (const int status = number(text, high, low, value)) return status;
    }
    while (!text.over() && (blank(text.now()) || text.now() == '\r')) text.place++;
    if (text.over()) return NEED_MORE;
    if (text.now() != '\n') return NOT_PLAIN;
    at[1] = text.place + 1;
  }
  return ROWS_DONE;
}
