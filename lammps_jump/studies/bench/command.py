# SPDX-License-Identifier: GPL-2.0-or-later
"""The ``bench`` command: chooses the benchmark that its options ask for."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

from lammps_jump import Case, load_case
from lammps_jump.errors import CaseError
from lammps_jump.studies.runs import KERNELS
from lammps_jump.studies.store import Store

from .cells import bench_cells
from .collision import bench_collisions
from .skips import bench_skips
from .speed import bench_speed
from .study import BENCH_FILE, Axes, bench_case
from .table import page

FOLDER = Path("runs") / "bench"
PARTS = {"cells": bench_cells, "skips": bench_skips, "speed": bench_speed}
"""Benchmarks beside that of the settings: option, which is also the stem of the JSON file, and function."""


def run_bench(
    case: Case | None,
    *,
    out: Path | None = None,
    part: str | None = None,
    axes: Axes | None = None,
    members: int | None = None,
    quick: bool = False,
    fresh: bool = False,
    say: Callable[[str], None] = print,
) -> str:
    """Run a benchmark and return its table as Markdown.

    Parameters
    ----------
    case : Case or None
        None for two discs against their closed forms.
    out : Path, optional
        Folder; default ``runs/bench/<name>``.
    part : str, optional
        One of `PARTS`; without it, the benchmark of the settings.
    axes, members
        See `study.bench_case`.
    quick, fresh : bool
        Few and short runs; measure again what is stored.
    say : callable

    Raises
    ------
    CaseError
        No such axis or number.
    """
    if case is None:
        return bench_collisions(out or FOLDER / "collision", quick=quick)
    folder = out or FOLDER / case.name
    if part:
        return PARTS[part](case, Store(folder / f"{part}.json", fresh=fresh), quick=quick, say=say)
    store = Store(folder / BENCH_FILE, fresh=fresh)
    return bench_case(case, store, axes=axes or Axes(), quick=quick, members=members, say=say)


def stored_table(path: Path, out: Path | None = None) -> str:
    """Return the table of a finished benchmark of a case file.

    Raises
    ------
    CaseError
        Where there is none.
    """
    file = (out or FOLDER / load_case(path).name) / BENCH_FILE
    try:
        data = json.loads(file.read_text())
    except (OSError, ValueError):
        raise CaseError(f"{file}: no benchmark is stored there; run `lammps-jump bench {path}` first") from None
    if "rows" not in data:
        raise CaseError(f"{file}: the benchmark is not finished; `lammps-jump bench {path}` continues it")
    return page(data)


def read_axes(names: str | None, fractions: str | None, kernels: str | None, diameters: str | None) -> Axes:
    """Return what the options of the command line vary; each is a list with commas between.

    Raises
    ------
    CaseError
        A kernel that does not exist; a value that is no number above 0.
    """
    words = tuple(word.strip() for word in kernels.split(",")) if kernels else None
    if words and not set(words) <= set(KERNELS):
        raise CaseError(f"--kernels {kernels!r}: allowed are stock, compiled and native, with commas between")
    return Axes(names, _numbers("--fractions", fractions), words, _numbers("--diameters", diameters) or ())


def _numbers(option: str, text: str | None) -> tuple[float, ...] | None:
    if not text:
        return None
    try:
        values = tuple(float(word) for word in text.split(","))
    except ValueError:
        raise CaseError(f"{option} {text!r}: expected numbers with commas between, such as 0.1,0.2") from None
    if not all(0 < value < float("inf") for value in values):
        raise CaseError(f"{option} {text!r}: every value must be above 0")
    return values
