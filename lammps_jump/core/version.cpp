// SPDX-License-Identifier: GPL-2.0-or-later

#include "api.h"

JUMP_API int64_t jump_core_version() { return jump::VERSION; }
