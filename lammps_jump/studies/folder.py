# SPDX-License-Identifier: GPL-2.0-or-later
"""The folder that a study of `lammps_jump.studies` writes to: marked, held, and none of a person's files replaced."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from lammps_jump.files import delete, read_json, study_files
from lammps_jump.folders import MARKER_FILE, Marker, read_marker, writable, write_marker
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
