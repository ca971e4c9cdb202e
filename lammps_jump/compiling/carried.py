# SPDX-License-Identifier: GPL-2.0-or-later
"""Libraries that a wheel of lammps-jump carries, built for levels of its processor, for machines without a compiler.

`make wheel` builds them. One is taken where the sources, the versions of the wheels that it includes, the processor
and the system's libraries are those that it needs; it is copied into the cache, so that the same checks hold for it as
for a library that was built here.
"""

from __future__ import annotations

import os
import platform
import subprocess
import sys
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from lammps_jump.errors import SetupError
from lammps_jump.files import read_file, read_json
from lammps_jump.provenance import wheel_file
from lammps_jump.system import processor_lines

from .cache import MOST_BYTES, checksum, record_of
from .compiler import Platform
from .product import Product

SECONDS = 60.0

_V3 = frozenset({"avx", "avx2", "bmi1", "bmi2", "f16c", "fma", "abm", "movbe", "xsave"})
LEVELS = {
    "x86-64-v4": _V3 | {"avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"},
    "x86-64-v3": _V3,
    "x86-64": frozenset(),
    "armv8-a": frozenset(),
}
"""Levels of the x86-64 psABI and of Arm's, and the flags that each needs, by the words of Linux."""

_TRIAL = "import ctypes, sys\nfor name in sys.argv[1:]: ctypes.CDLL(name, ctypes.RTLD_GLOBAL)"


@dataclass(frozen=True, slots=True)
class Carried:
    """One library of the wheel.

    Attributes
    ----------
    level : str
        Key of `LEVELS`.
    library : Path
    record : dict
        What it was built from and for; its checksum among it.
    """

    level: str
    library: Path
    record: dict[str, Any]


def carried_folder(product: Product) -> Path:
    """Folder of the package with the libraries of a product, a folder a level."""
    return product.folder / "carried"


def needs(product: Product, built_for: Platform | None = None) -> dict[str, str]:
    """Requirements of a library: what it must have been built from and for to run here, or on another platform."""
    system, machine = (built_for.system, built_for.machine) if built_for else (platform.system(), platform.machine())
    return {**product.versions(), "system": system, "machine": machine, "sources": product.sources()}


@lru_cache(maxsize=1)
def processor_flags() -> frozenset[str]:
    """Abilities of this processor, by the words of Linux; empty where it does not say."""
    lines = processor_lines()
    return frozenset(next((line.partition(":")[2].split() for line in lines if line.startswith("flags")), ()))


def fitting(product: Product) -> tuple[Carried | None, str]:
    """The best library of the wheel for this machine, or None and the reason; looks, loads nothing."""
    folder = carried_folder(product)
    levels = [level for level in product.levels if (folder / level / product.library).is_file()]
    if not levels:
        return None, "the package carries no built library"
    here, reason = needs(product), ""
    for level in levels:
        library = folder / level / product.library
        try:
            record = read_json(record_of(library))
            code = read_file(library, MOST_BYTES)
            wrong = [f"{name} {record[name]} (here {value})" for name, value in here.items() if record[name] != value]
            whole = record["sha256"] == checksum(code)
        except (OSError, ValueError, KeyError, TypeError):
            wrong, whole = [], False
        if not whole:
            reason = f"the carried library {library} is damaged; reinstall lammps-jump"
        elif wrong:
            reason = f"the carried library is built for another {', '.join(wrong)}"
        elif not LEVELS[level] <= processor_flags():
            reason = f"the carried libraries need a processor of level {level}"
        else:
            return Carried(level, library, record), ""
    return None, reason


def check_loads(product: Product, library: Path) -> None:
    """Load a library once in a process of its own: the system's C and C++ libraries may be too old for it.

    Raises
    ------
    SetupError
        With what the system's loader says.
    """
    names = [*(wheel_file(wheel.package, wheel.library) for wheel in reversed(product.wheels)), library]
    command = [sys.executable, "-P", "-c", _TRIAL, *map(str, names)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=SECONDS, env={**os.environ})
    except (OSError, subprocess.TimeoutExpired) as error:
        raise SetupError(f"the carried library cannot be tried: {error}") from None
    if done.returncode != 0:
        said = (done.stderr.strip().splitlines() or [f"exit status {done.returncode}"])[-1]
        raise SetupError(f"the carried library does not load here ({said})")
