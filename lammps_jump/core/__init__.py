# SPDX-License-Identifier: GPL-2.0-or-later
"""The core: C++17 without LAMMPS and without Python, called through a plain C interface by ctypes.

Every file ``*.cpp`` of this folder is a unit of the library ``jumpcore.so``; a new file needs no entry in a list. Files
include headers of this folder by ``#include "name.h"``; the plugin for LAMMPS finds the same headers.

- A function that Python calls is declared ``JUMP_API`` (`api.h`). It takes numbers and pointers to contiguous arrays,
  throws nothing, and returns a number or nothing.
- `library.function` binds it to Python with the kinds of its arguments.
- A struct that both sides know has ``JUMP_SIZE(name)`` in C++; `library.Struct` compares the sizes at its first use,
  and the names of the fields where C++ tells them: the numbers of the law (`law.LawNumbers`).
- `library.core` is the library, or None where neither a compiler nor a library of the package is there. What cannot do
  without asks `library.require_core`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
