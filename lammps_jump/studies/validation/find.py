# SPDX-License-Identifier: GPL-2.0-or-later
"""Where laws stand, and how one is loaded: folders with a ``law.py``, which the wheel does not carry."""

from __future__ import annotations

import hashlib
import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType

from lammps_jump.errors import CaseError, SetupError
from lammps_jump.provenance import __version__

from .law import Law

LAW_FILE, MEASURE_FILE = "law.py", "measure.py"
FOLDER = "validation"
TREE = Path(__file__).parents[3] / FOLDER
"""In the source tree, beside its ``pyproject.toml``; where the package is installed there is none."""


def laws_folder(given: Path | None = None) -> Path:
    """Return the folder of the laws: the given one, else that of the source tree.

    Laws are Python that is run, so none is taken from where a person happens to stand.

    Raises
    ------
    CaseError
        The given folder holds no law.
    SetupError
        There is none.
    """
    known = given or (TREE if (TREE.parent / "pyproject.toml").is_file() else None)
    if known and any(known.glob(f"*/{LAW_FILE}")):
        return known
    if given:
        raise CaseError(f"--laws {given}: holds no law; it needs a folder for each law, with a {LAW_FILE} in it")
    raise SetupError(
        f"the laws are not installed: they stand in the folder {FOLDER}/ of the source of lammps-jump {__version__}, "
        "which an installed package does not carry; get the source and name that folder with --laws DIR"
    )


def find_laws(folder: Path, names: list[str] | None = None) -> dict[str, Law]:
    """Return the laws of a folder by name, those that are named or all.

    Raises
    ------
    CaseError
        A name that is not known.
    """
    known = sorted(path.parent.name for path in folder.glob(f"*/{LAW_FILE}"))
    for name in names or ():
        if name not in known:
            raise CaseError(f"there is no law '{name}'; laws in {folder}: {', '.join(known)}")
    return {name: load_law(folder / name) for name in dict.fromkeys(names or known)}


def load_law(folder: Path) -> Law:
    """Return the law of a folder; CaseError where its ``law.py`` names none."""
    law = getattr(load_module(folder, "law"), "LAW", None)
    if not isinstance(law, Law):
        raise CaseError(f"{folder / LAW_FILE}: has no LAW; docs/validation.md says how a law is written")
    return law


def load_module(folder: Path, name: str) -> ModuleType:
    """Return a module of a law's folder, whose files may import each other: ``from . import measure``."""
    place = folder.resolve()
    package = f"law_{place.name}_{hashlib.sha256(str(place).encode()).hexdigest()[:8]}"
    if package not in sys.modules:
        made = ModuleType(package)
        made.__path__ = [str(place)]
        sys.modules[package] = made
    full = f"{package}.{name}"
    return import_module(full)
