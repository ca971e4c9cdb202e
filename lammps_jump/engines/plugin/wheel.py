# SPDX-License-Identifier: GPL-2.0-or-later
"""Builds the libraries that a wheel of lammps-jump carries; `make wheel` runs it as a module."""

from __future__ import annotations

import platform
import shutil

from lammps_jump.errors import SetupError

from .build import build_for
from .carried import FOLDER, LEVELS


def build_all() -> None:
    """Build the plugin for each level of `LEVELS`, in place of what stood there.

    Raises
    ------
    SetupError
        The processor is not of the family x86-64, or what `build_for` raises.
    """
    if platform.machine() != "x86_64":
        raise SetupError(f"libraries are carried for x86_64, not for {platform.machine()}: `pip wheel .` makes a wheel")
    shutil.rmtree(FOLDER, ignore_errors=True)
    for level in LEVELS:
        print(build_for(level))


if __name__ == "__main__":
    try:
        build_all()
    except SetupError as error:
        raise SystemExit(str(error)) from None
