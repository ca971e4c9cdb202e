# SPDX-License-Identifier: GPL-2.0-or-later
"""One word that opens whatever a path is: a run, a study, a calibration, a case or a dump."""

from __future__ import annotations

from pathlib import Path

from lammps_jump.calibration.calibrate import ANSWER, Calibrated
from lammps_jump.dump import Dump, read_dump
from lammps_jump.errors import CaseError
from lammps_jump.files import STUDY_FILES
from lammps_jump.folders import read_marker
from lammps_jump.runs.run import Case, Run, load_case, open_run
from lammps_jump.sweeps import Sweep, runs_of_search

CASE_ENDINGS = (".yaml", ".yml")


def open(path: str | Path) -> Run | Sweep | Calibrated | Case | Dump:
    """Open a path: the folder of a run, a study, a search or a calibration, a case file, or a dump.

    The folder of a search, of ``lammps-jump find``, opens as the study of its runs; `find` gives its answer again.

    Parameters
    ----------
    path : str or Path

    Returns
    -------
    Run, Sweep, Calibrated, Case or Dump

    Raises
    ------
    CaseError
        Nothing there, a case or study that cannot be read, or the folder of a command that leaves a page of its own.
    DumpError
        A file or folder that is none of these, and no dump.
    """
    place = Path(path)
    if (place / ANSWER).is_file():
        return Calibrated(place)
    marker = read_marker(place)
    if marker is not None and marker.kind in STUDY_FILES:
        if (points := runs_of_search(place)) is not None:
            return Sweep(points)
        names = " and ".join(name for name in STUDY_FILES[marker.kind] if name.endswith((".json", ".html")))
        raise CaseError(f"{path}: is a folder of `lammps-jump {marker.kind}`; its numbers and its page are {names}")
    if (place / "study.yaml").is_file():
        return Sweep(place)
    if (place / "case.yaml").is_file():
        return open_run(place)
    if place.suffix in CASE_ENDINGS:
        return load_case(place)
    if not place.exists() and "*" not in place.name:
        raise CaseError(f"{path}: no such file or folder; a run folder, a study, a case file or a dump is opened")
    return read_dump(place)
