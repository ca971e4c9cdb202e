# SPDX-License-Identifier: GPL-2.0-or-later
"""What a result depends on: versions, the machine."""

from __future__ import annotations

import os
import platform
from contextlib import suppress
from functools import cache
from importlib import metadata
from pathlib import Path


@cache
def package_version(package: str) -> str | None:
    """Version of an installed package, None where it is not installed."""
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None


__version__ = package_version("lammps-jump") or "unknown"


def versions(*more: str) -> dict[str, str]:
    """Versions that a result depends on: of Python, this program, numpy, numba and `more` packages."""
    packages = ("lammps-jump", "numpy", "numba", *more)
    found = {package.replace("-", "_"): package_version(package) for package in packages}
    return {"python": platform.python_version(), **{name: text for name, text in found.items() if text}}


def machine() -> dict[str, str | int | None]:
    """Processor model and number of cores, system; no host name, no paths."""
    model = platform.processor() or platform.machine()
    with suppress(OSError):
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        model = next((line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), model)
    return {
        "processor": model,
        "cores": os.cpu_count(),
        "system": platform.system(),
        "architecture": platform.machine(),
    }
