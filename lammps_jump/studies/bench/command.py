# SPDX-License-Identifier: GPL-2.0-or-later
"""The ``bench`` command: each benchmark measures rows, keeps them in a JSON file, and makes its page from that."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

from lammps_jump import Case, load_case
from lammps_jump.errors import CaseError
from lammps_jump.files import plain
from lammps_jump.provenance import machine
from lammps_jump.studies.folder import held_folder
from lammps_jump.studies.settings import Axes
from lammps_jump.sweeps import Say, Store

from .collision import collision_page, compare_collisions
from .page import draw_quantity, page
from .skips import measure_skips, skip_page
from .study import measure_settings
from .timing import cell_page, overhead_page, speed_page, time_cells, time_commands, time_kernels

FOLDER = Path("runs") / "bench"
PARTS = {
    "cells": (time_cells, cell_page),
    "skips": (measure_skips, skip_page),
    "speed": (time_kernels, speed_page),
    "overhead": (time_commands, overhead_page),
    "collision": (compare_collisions, collision_page),
}
"""Benchmarks beside that of the settings by the stem of their JSON file: what measures, and what makes the page."""


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
    if case is None:
        part, fresh = "collision", True
    name = case.name if case else part
    measure, show = PARTS.get(part) or (partial(measure_settings, axes=axes, fresh=fresh), settings_page)
    with held_folder(out or FOLDER / name, "bench") as folder:
        store = Store(folder / f"{part}.json", fresh=fresh)
        store.data |= plain(measure(case, store, quick=quick, say=say)) | {"case": name, "machine": machine()}
        store.save()
        return store.finish(show(store.data, folder))


def settings_page(data: dict[str, Any], folder: Path) -> str:
    """Return the page of a benchmark of settings; draws its figures."""
    for name in data["quantities"]:
        draw_quantity(data, name, folder)
    return page(data)


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
        raise CaseError(f"{file}: no finished benchmark is stored there; run `lammps-jump bench {path}` first")
    return page(data)
