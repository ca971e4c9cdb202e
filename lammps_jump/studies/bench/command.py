# SPDX-License-Identifier: GPL-2.0-or-later
"""The ``bench`` command: the study of the settings of a case, that of two discs, and benchmarks of time."""

from __future__ import annotations

from pathlib import Path

from lammps_jump import Case, load_case
from lammps_jump.analysis.tables.markdown import paragraphs
from lammps_jump.errors import CaseError
from lammps_jump.files import plain
from lammps_jump.provenance import machine
from lammps_jump.quoting import typed
from lammps_jump.studies.folder import held_folder
from lammps_jump.studies.points import run_study
from lammps_jump.studies.settings import Axes
from lammps_jump.sweeps import Say, Store

from .collision import collision_study
from .overhead import overhead_page, time_commands
from .page import page
from .skips import measure_skips, skip_page
from .study import settings_study
from .timing import cell_page, speed_page, time_cells, time_kernels

FOLDER = Path("runs") / "bench"
PARTS = {
    "cells": (time_cells, cell_page),
    "skips": (measure_skips, skip_page),
    "speed": (time_kernels, speed_page),
    "overhead": (time_commands, overhead_page),
}
"""Benchmarks of time by the stem of their JSON file: what measures rows in turn, and what makes the page."""


def run_bench(
    case: Case | None,
    *,
    out: Path | None = None,
    part: str = "bench",
    axes: Axes | None = None,
    quick: bool = False,
    fresh: bool = False,
    say: Say = print,
) -> str:
    """Run a benchmark and return its table as Markdown.

    Parameters
    ----------
    case : Case or None
        None for two discs against their closed forms.
    out : Path, optional
        Folder; default ``runs/bench/<name>``.
    part : str
        One of `PARTS`, or 'bench' for the benchmark of the settings.
    axes : Axes, optional
        For the settings.
    quick, fresh : bool
        Few and short runs; measure again what is stored.
    say : callable
        Takes one line of progress.

    Raises
    ------
    CaseError
        No such axis or number.
    """
    folder = out or FOLDER / (case.name if case else "collision")
    if case is None:
        return run_study(collision_study(quick=quick), folder, command="bench", fresh=True, say=say)[1]
    if part not in PARTS:
        study = settings_study(case, folder, axes, quick=quick)
        return run_study(study, folder, command="bench", fresh=fresh, say=say)[1]
    measure, show = PARTS[part]
    with held_folder(folder, "bench"):
        store = Store(folder / f"{part}.json", fresh=fresh)
        store.data |= plain(measure(case, store, quick=quick, say=say)) | {"case": case.name, "machine": machine()}
        store.save()
        return store.finish(paragraphs(*show(store.data, folder)))


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
