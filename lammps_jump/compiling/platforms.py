# SPDX-License-Identifier: GPL-2.0-or-later
"""Systems for which libraries are built, and wheels are made: this one, and others by the compiler of zig."""

from __future__ import annotations

import platform
import sys
from dataclasses import dataclass

from .compiler import find_compiler


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
        """The command, None where it is not there."""
        return (sys.executable, "-m", "ziglang", "c++", "-g0", "-target", self.zig) if self.zig else find_compiler()

    @property
    def is_here(self) -> bool:
        """Tells whether this machine is one."""
        return (self.system, self.machine) == (platform.system(), platform.machine())


PLATFORMS = (
    Platform(
        "Linux",
        "x86_64",
        "linux_x86_64",
        {level: f"-march={level}" for level in ("x86-64-v4", "x86-64-v3", "x86-64")},
    ),
    Platform("Linux", "aarch64", "manylinux_2_28_aarch64", {"armv8-a": "-mcpu=generic"}, "aarch64-linux-gnu.2.28"),
    Platform("Darwin", "arm64", "macosx_11_0_arm64", {"armv8-a": "-mcpu=apple_m1"}, "aarch64-macos.11.0"),
    Platform("Darwin", "x86_64", "macosx_11_0_x86_64", {"x86-64": "-mcpu=x86_64"}, "x86_64-macos.11.0"),
)
"""Of the wheels that `make wheel` makes. The styles for LAMMPS need its C++ library, which that of zig is not: they are
built by this machine's compiler alone."""
