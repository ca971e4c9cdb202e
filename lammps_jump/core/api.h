// SPDX-License-Identifier: GPL-2.0-or-later
// What Python calls of the core: plain C functions of numbers and of pointers to contiguous arrays.

#ifndef JUMP_CORE_API_H
#define JUMP_CORE_API_H

#include <cstdint>

#define JUMP_API extern "C" __attribute__((visibility("default")))

// A struct that Python knows too: its size is compared with that of Python's copy.
#define JUMP_SIZE(name) \
  JUMP_API int64_t name##_size() { return sizeof(name); }

// An entry of many arguments takes one struct, `<entry>_input`, whose fields are in one list: FIELD(type, name) for each.
// Python has the same names in the same order, and compares them before the first call; JUMP_LOCAL makes them variables.
#define JUMP_FIELD(type, name) type name;
#define JUMP_FIELD_NAME(type, name) #name " "
#define JUMP_LOCAL(type, name) type const name = input->name;
#define JUMP_INPUT(entry, FIELDS) \
  struct entry##_input { FIELDS(JUMP_FIELD) }; \
  JUMP_SIZE(entry##_input) \
  JUMP_API const char *entry##_input_fields() { return FIELDS(JUMP_FIELD_NAME); }

namespace jump {
// Of the interface; library.py has the same number. Raise both where a function or a struct changes.
constexpr int64_t VERSION = 8;
}    // namespace jump

#endif
