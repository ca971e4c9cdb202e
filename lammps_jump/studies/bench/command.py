# SPDX-License-Identifier: GPL-2.0-or-later
"""The ``bench`` command: the study of the settings of a case."""

from __future__ import annotations

from pathlib import Path

from lammps_jump import Case, load_case
from lammps_jump.analysis.tables.markdown import paragraphs
from lammps_jump.errors import CaseError
from lammps_jump.quoting import typed
from lammps_jump.studies.points import run_study
from lammps_jump.studies.settings import Axes
from lammps_jump.sweeps import Say, Store

from .page import page
from .study import settings_study

FOLDER = Path("runs") / "bench"


def run_bench(
    case: Case,
    *,
    out: Path | None = None,
    axes: Axes | None = None,
    quick: bool = False,
    fresh: bool = False,
    say: Say = print,
) -> str:
    """Run the benchmark of the settings of a case and return its table as Markdown.

    Parameters
    ----------
    case : Case
    out : Path, optional
        Folder; default ``runs/bench/<name>``.
    axes : Axes, optional
        Of the settings.
    quick, fresh : bool
        Few and short runs; measure again what is stored.
    say : callable
        Takes one line of progress.

    Raises
    ------
    CaseError
        No such axis or number.
    """
    folder = out or FOLDER / case.name
    study = settings_study(case, folder, axes, quick=quick)
    return run_study(study, folder, command="bench", fresh=fresh, say=say)[1]


def stored_table(path: Path, out: Path | None = None) -> str:
    """Return the table of a finished benchmark of a case file.

    Raises
    ------
    CaseError
        Where there is none.
    """
    file = (out or FOLDER / load_case(path).name) / "bench.json"
    data = Store(file).data
    if "rows" not in data:
        raise CaseError(f"{file}: no finished benchmark is stored there; run `{typed('bench', path)}` first")
    return paragraphs(*page(data))
