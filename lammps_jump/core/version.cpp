// SPDX-License-Identifier: GPL-2.0-or-later
// What Python compares when it loads the core.

#include "api.h"
#include "contact/law.h"

JUMP_API int64_t jump_core_version() { return jump::VERSION; }

using jump_law = jump::LawNumbers;
JUMP_SIZE(jump_law)

// Names of the numbers of a law in their order, each with a space behind it.
JUMP_API const char *jump_law_fields()
{
#define JUMP_NAME(name) #name " "
  return JUMP_LAW(JUMP_NAME);
#undef JUMP_NAME
}
