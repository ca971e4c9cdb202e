# SPDX-License-Identifier: GPL-2.0-or-later
"""The scenes that come with the package (``inputs/``), as starting cases."""

from __future__ import annotations

from pathlib import Path

from lammps_jump.errors import CaseError

from .text import nearest


def scene_folder() -> Path:
    """Where the case files are: inside the package in a wheel, beside it in a checkout."""
    package = Path(__file__).resolve().parents[1]
    inside = package / "inputs"
    return inside if inside.is_dir() else package.parent / "inputs"


def scene_names() -> list[str]:
    """Names that `scene_text` knows."""
    return sorted(path.stem for path in scene_folder().glob("*.yaml"))


def scene_text(name: str) -> str:
    """Text of a scene's case file.

    Raises
    ------
    CaseError
        For a name that is not there, with the nearest that is.
    """
    names = scene_names()
    if name not in names:
        raise CaseError(f"new {name}: there is no such scene; {nearest(name, names)}")
    return (scene_folder() / f"{name}.yaml").read_text()
