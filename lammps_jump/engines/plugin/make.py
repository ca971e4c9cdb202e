# SPDX-License-Identifier: GPL-2.0-or-later
"""Compiles the products while the rest of the environment is installed; `make run` runs it as a module.

It imports little: the packages that `COMPILING` of the Makefile names are enough.
"""

from __future__ import annotations

from lammps_jump.compiling.build import build_all

from .product import PRODUCTS

if __name__ == "__main__":
    for found in build_all(PRODUCTS, tell=print):
        if isinstance(found, str):
            print(found)
