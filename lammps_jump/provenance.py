# SPDX-License-Identifier: GPL-2.0-or-later
"""What a result depends on: versions, hashes, the machine."""

from __future__ import annotations

import hashlib
import json
import os
import platform
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import fields
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

NO_NUMBERS = ("name", "description", "skipped", "warnings", "adapted")
"""Fields of a scene that change no trajectory."""


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


def short_hash(data: Mapping[str, object]) -> str:
    """Twelve hex digits of plain data, whatever the order of its keys."""
    return hashlib.sha256(json.dumps(data, sort_keys=True).encode()).hexdigest()[:12]


def fingerprint(scene: DataclassInstance) -> str:
    """A hash of every number of a scene: a newer version of the program may make another scene of the same case."""
    found = hashlib.sha256()
    for field in fields(scene):
        value = getattr(scene, field.name)
        if field.name not in NO_NUMBERS:
            found.update(field.name.encode())
            found.update(value.tobytes() if isinstance(value, np.ndarray) else repr(value).encode())
    return found.hexdigest()
