# SPDX-License-Identifier: GPL-2.0-or-later
"""Provenance of a result: versions, the machine."""

from __future__ import annotations

import os
import platform
from contextlib import suppress
from functools import cache
from importlib import metadata
from pathlib import Path

from .system import CONTROL_GROUPS, control_group, own_cores, processor_lines, told


@cache
def package_version(package: str) -> str | None:
    """Version of an installed package, None where it is not installed."""
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None


def wheel_file(package: str, name: str) -> Path | None:
    """A file of an installed wheel, by its name or the end of its path; None where either is not there."""
    try:
        files = metadata.files(package) or []
    except metadata.PackageNotFoundError:
        return None
    return next((Path(str(file.locate())).resolve() for file in files if file.match(name)), None)


__version__ = package_version("lammps-jump") or "unknown"


def versions(*more: str) -> dict[str, str]:
    """Versions that a result depends on: of Python, this program, numpy and `more` packages."""
    packages = ("lammps-jump", "numpy", *more)
    version_of = {package.replace("-", "_"): package_version(package) for package in packages}
    return {"python": platform.python_version(), **{name: text for name, text in version_of.items() if text}}


def machine() -> dict[str, str | int | None]:
    """Processor model and number of cores, system; no host name, no paths."""
    model = platform.processor() or platform.machine()
    model = next((line.split(":", 1)[1].strip() for line in processor_lines() if line.startswith("model name")), model)
    return {
        "processor": model,
        "cores": os.cpu_count(),
        "system": platform.system(),
        "architecture": platform.machine(),
    }


def usable_cores(root: Path = CONTROL_GROUPS) -> int:
    """Cores this process may use by its affinity and by the limits of its control groups (version 2); at least 1."""
    cores = float(len(own_cores()))
    own = control_group()
    for folder in (root / own, *(root / own).parents):
        with suppress(OSError, ValueError, IndexError):
            quota, period = told(folder / "cpu.max").split()  # "max 100000" is no limit, and no number
            cores = min(cores, float(quota) / float(period))
        if folder == root:
            break
    return max(1, round(cores))
