# SPDX-License-Identifier: GPL-2.0-or-later
"""Folders of studies: the one that a study writes to, and those of laws and studies that the wheel does not carry."""

from __future__ import annotations

import hashlib
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from types import ModuleType

from lammps_jump.errors import CaseError, SetupError
from lammps_jump.files import delete, read_json, study_files
from lammps_jump.folders import MARKER_FILE, Marker, read_marker, writable, write_marker
from lammps_jump.provenance import __version__
from lammps_jump.runs.folder import run_folder

TOLD_BY = ("pieces", "disc_by_disc", "zones")
"""Keys of results: one of them shows that a folder without a marker is of a study."""


@contextmanager
def held_folder(folder: Path, command: str) -> Iterator[Path]:
    """Hold the folder of a study, by the name of its command, as `run_folder` does; a new one is not left empty.

    Folders of studies had no marker before: one with results of a study gets it.

    Raises
    ------
    SetupError
        The folder holds files of those names and was not made by this program, holds something else, or is in use.
    """
    marker, new = Marker(command, study_files(command), {}), not folder.exists()
    if read_marker(folder) is None and _is_of_before(folder, command):
        with writable(folder):
            write_marker(folder, marker)
    try:
        with run_folder(folder, marker):
            yield folder
    finally:
        if new and folder.is_dir() and os.listdir(folder) == [MARKER_FILE]:
            delete(folder / MARKER_FILE)
            folder.rmdir()


def _is_of_before(folder: Path, command: str) -> bool:
    """Tells whether results stand there that a study of this program has written."""
    for name in study_files(command):
        if name.endswith(".json") and (folder / name).is_file():
            try:
                found = read_json(folder / name)
            except (OSError, ValueError):
                continue
            if isinstance(found, dict) and any(isinstance(found.get(key), dict | list) for key in TOLD_BY):
                return True
    return False


# --- folders of laws and studies that the wheel does not carry, and how a module of one is loaded ---------------------


LAW_FILE, STUDY_FILE, MEASURE_FILE = "law.py", "study.py", "measure.py"
FOLDER = "validation"
TREE = Path(__file__).parents[2] / FOLDER
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
