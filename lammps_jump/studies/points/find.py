# SPDX-License-Identifier: GPL-2.0-or-later
"""Folders of laws and studies that the wheel does not carry, and how a module of one is loaded."""

from __future__ import annotations

import hashlib
import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType

from lammps_jump.errors import CaseError, SetupError
from lammps_jump.provenance import __version__

LAW_FILE, STUDY_FILE, MEASURE_FILE = "law.py", "study.py", "measure.py"
FOLDER = "validation"
TREE = Path(__file__).parents[3] / FOLDER
"""In the source tree, beside its ``pyproject.toml``; where the package is installed there is none."""


def source_of(what: str, file: str, given: Path | None = None) -> Path:
    """Return the folder of laws and studies: the given one, else that of the source tree.

    They are Python that is run, so none is taken from where a person happens to stand.

    Parameters
    ----------
    what : str
        Is looked for, in words: 'the laws'.
    file : str
        Name or pattern of a file that shows that the folder is the right one.
    given : Path, optional

    Raises
    ------
    CaseError
        The given folder holds no such file.
    SetupError
        There is none.
    """
    known = given or (TREE if (TREE.parent / "pyproject.toml").is_file() else None)
    if known and any(known.glob(file)):
        return known
    if given:
        folder, _, name = file.rpartition("/")
        lacks, needs = (
            ("no law", "a folder for each law") if folder == "*" else (f"nothing of {what}", f"a folder {folder}")
        )
        raise CaseError(f"--laws {given}: holds {lacks}; it needs {needs}, with a {name} in it")
    raise SetupError(
        f"{what} are not installed: they stand in the folder {FOLDER}/ of the source of lammps-jump {__version__}, "
        "which an installed package does not carry; get the source and name that folder with --laws DIR"
    )


def load_module(folder: Path, name: str) -> ModuleType:
    """Return a module of a folder, whose files may import each other: ``from . import measure``."""
    place = folder.resolve()
    package = f"law_{place.name}_{hashlib.sha256(str(place).encode()).hexdigest()[:8]}"
    if package not in sys.modules:
        made = ModuleType(package)
        made.__path__ = [str(place)]
        sys.modules[package] = made
    full = f"{package}.{name}"
    return import_module(full)
