// SPDX-License-Identifier: GPL-2.0-or-later
// What Python calls of the core: plain C functions of numbers and of pointers to contiguous arrays.

#ifndef JUMP_CORE_API_H
#define JUMP_CORE_API_H

#include <cstdint>

#define JUMP_API extern "C" __attribute__((visibility("default")))

// A struct that Python knows too: its size is compared with that of Python's copy.
#define JUMP_SIZE(name) \
  JUMP_API int64_t name##_size() { return sizeof(name); }

namespace jump {
// Of the interface; library.py has the same number. Raise both where a function or a struct changes.
constexpr int64_t VERSION = 3;
}    // namespace jump

#endif
