# SPDX-License-Identifier: GPL-2.0-or-later
"""The C++ compiler of this machine, running it, and the systems for which libraries are built."""

from __future__ import annotations

import json
import os
import platform
import shlex
import shutil
import subprocess
import sys
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from threading import BoundedSemaphore

from lammps_jump.errors import SetupError
from lammps_jump.files import MOST_TEXT, read_file
from lammps_jump.provenance import usable_cores
from lammps_jump.system import processor_lines

COMPILERS = ("c++", "g++", "clang++")
ADVICE = "install a C++17 compiler (Debian: `apt install g++`), or name one in the variable CXX"
SECONDS = 600.0

_places = BoundedSemaphore(usable_cores())
"""One compiler runs on each core, whatever is built."""


def find_compiler() -> tuple[str, ...] | None:
    """The C++ compiler as a command (CXX, c++, g++, clang++), or None."""
    named = shlex.split(os.environ.get("CXX", ""))
    for name, *words in [named] if named else ([name] for name in COMPILERS):
        if program := shutil.which(name):
            return (program, *words)
    return None


@lru_cache(maxsize=4)
def compiler_version(command: tuple[str, ...]) -> str | None:
    """The compiler's own words on its version, None where it does not run."""
    try:
        answer = subprocess.run([*command, "--version"], capture_output=True, text=True, timeout=30, check=True)
    except (OSError, subprocess.SubprocessError):
        return None
    return answer.stdout.strip()


def require_compiler(title: str, command: tuple[str, ...] | None = None) -> tuple[tuple[str, ...], str]:
    """The compiler as a command, that of the system unless another is named, and its version.

    Raises
    ------
    SetupError
        There is none, or it does not run; says what to install.
    """
    command = command or find_compiler()
    if command is None:
        named = os.environ.get("CXX")
        what = (
            f"the compiler CXX={named} is not found" if named else f"no C++ compiler ({', '.join(COMPILERS)}) is found"
        )
        raise SetupError(f"{title} cannot be built: {what}; {ADVICE}")
    version = compiler_version(command)
    if version is None:
        raise SetupError(f"{title} cannot be built: {' '.join(command)} does not run; {ADVICE}")
    return command, version


def run_compiler(command: list[str], product: Path, title: str, version: str) -> bytes:
    """Run the compiler where a core is free for it; the bytes of what it makes.

    Raises
    ------
    SetupError
        It makes nothing; with its words.
    """
    name = version.splitlines()[0]
    try:
        with _places:
            done = subprocess.run(command, capture_output=True, text=True, timeout=SECONDS)
    except (OSError, subprocess.TimeoutExpired) as error:
        raise SetupError(f"{title} could not be built with {name}: {error}") from None
    if done.returncode != 0 or not product.is_file():
        lines = [line for line in done.stderr.splitlines() if "error" in line] or done.stderr.splitlines()
        said = "; ".join(lines[:3]) or f"exit status {done.returncode}"
        raise SetupError(f"{title} could not be built with {name}: {said}; {ADVICE}")
    return read_file(product, MOST_TEXT)


@lru_cache(maxsize=1)
def processor() -> str:
    """Name and abilities of the processor, as far as the system tells."""
    lines = processor_lines()
    properties = {line for line in lines if line.startswith(("model name", "flags", "Features", "CPU part"))}
    return json.dumps([platform.system(), platform.machine(), *(sorted(properties) or [platform.processor()])])


# --- systems for which libraries are built, and wheels are made: this one, and others by the compiler of zig ----------


@dataclass(frozen=True, slots=True)
class Platform:
    """A system with its processor.

    Attributes
    ----------
    system, machine : str
        Words of `platform.system()` and `platform.machine()`.
    tag : str
        Of the wheel for it (PEP 425).
    levels : dict
        Flag of the compiler by the level of the processor (`carried.LEVELS`).
    zig : str
        What zig calls it, with the oldest version of its libraries; empty where this machine's compiler builds for it.
    """

    system: str
    machine: str
    tag: str
    levels: dict[str, str]
    zig: str = ""

    @property
    def compiler(self) -> tuple[str, ...] | None:
        """The command of the compiler, or None without one."""
        return (sys.executable, "-m", "ziglang", "c++", "-g0", "-target", self.zig) if self.zig else find_compiler()

    @property
    def is_here(self) -> bool:
        """Tells whether this machine is one."""
        return (self.system, self.machine) == (platform.system(), platform.machine())


PLATFORMS = (
    Platform(
        "Linux", "x86_64", "linux_x86_64", {level: f"-march={level}" for level in ("x86-64-v4", "x86-64-v3", "x86-64")}
    ),
    Platform("Linux", "aarch64", "manylinux_2_28_aarch64", {"armv8-a": "-mcpu=generic"}, "aarch64-linux-gnu.2.28"),
    Platform("Darwin", "arm64", "macosx_11_0_arm64", {"armv8-a": "-mcpu=apple_m1"}, "aarch64-macos.11.0"),
    Platform("Darwin", "x86_64", "macosx_11_0_x86_64", {"x86-64": "-mcpu=x86_64"}, "x86_64-macos.11.0"),
)
"""Of the wheels that `make wheel` makes. The styles for LAMMPS need its C++ library, which that of zig is not: they are
built by this machine's compiler alone."""
