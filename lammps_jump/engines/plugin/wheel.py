# SPDX-License-Identifier: GPL-2.0-or-later
"""Builds the libraries that a wheel of lammps-jump carries; `make wheel` runs it as a module."""

from __future__ import annotations

import platform
import shutil

from lammps_jump.compiling.build import build_for
from lammps_jump.compiling.carried import carried_folder
from lammps_jump.errors import SetupError

from .product import PRODUCTS


def build_all() -> None:
    """Build each product for each of its levels, in place of what stood there.

    Raises
    ------
    SetupError
        The processor is not of the family x86-64, or what `build_for` raises.
    """
    if platform.machine() != "x86_64":
        raise SetupError(f"libraries are carried for x86_64, not for {platform.machine()}: `pip wheel .` makes a wheel")
    for product in PRODUCTS:
        shutil.rmtree(carried_folder(product), ignore_errors=True)
        for level in product.levels:
            print(build_for(product, level))


if __name__ == "__main__":
    try:
        build_all()
    except SetupError as error:
        raise SystemExit(str(error)) from None
