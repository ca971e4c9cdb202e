# SPDX-License-Identifier: GPL-2.0-or-later
"""One word that opens whatever a path is: a run, a study, a calibration, a case or a dump."""

from __future__ import annotations

from pathlib import Path

from lammps_jump.calibration.calibrate import ANSWER, Calibrated
from lammps_jump.dump import Dump, read_dump
from lammps_jump.errors import CaseError
from lammps_jump.runs.run import Case, Run, load_case, open_run
from lammps_jump.sweeps.sweep import Sweep

CASE_ENDINGS = (".yaml", ".yml")


def open(path: str | Path) -> Run | Sweep | Calibrated | Case | Dump:
    """Open a path: the folder of a run, a study or a calibration, a case file, or a dump.

    Parameters
    ----------
    path : str or Path

    Returns
    -------
    Run, Sweep, Calibrated, Case or Dump

    Raises
    ------
    CaseError
        Nothing there, or a case or study that cannot be read.
    DumpError
        A file or folder that is none of these, and no dump.
    """
    place = Path(path)
    if (place / ANSWER).is_file():
        return Calibrated(place)
    if (place / "study.yaml").is_file():
        return Sweep(place)
    if (place / "case.yaml").is_file():
        return open_run(place)
    if place.suffix in CASE_ENDINGS:
        return load_case(place)
    if not place.exists() and "*" not in place.name:
        raise CaseError(f"{path}: no such file or folder; a run folder, a study, a case file or a dump is opened")
    return read_dump(place)
