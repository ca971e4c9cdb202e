# SPDX-License-Identifier: GPL-2.0-or-later
"""CPU time against the cell size of the thesis' contact search (its section 6.4 and recommendation 2).

Run as ``python benchmarks/cell_search.py CASE [--set PATH=VALUE] [--quick] [--out DIR]``. The native engine makes its
cells anew at every step and tries each pair in the cell of its contact point. The neighbour list, which this engine
uses otherwise, is timed for comparison. Sizes take turns, so that ratios hold on a busy machine. It draws
``cells.png``.
"""

from __future__ import annotations

import tempfile
from dataclasses import replace
from functools import partial
from pathlib import Path

import pandas as pd
from taking_turns import main, timed_in_turn

from lammps_jump import Case
from lammps_jump.analysis.draw.chart import Chart, Panel, Trace
from lammps_jump.analysis.draw.style import drawn, save
from lammps_jump.analysis.tables import Column, markdown
from lammps_jump.engines.native import run_native
from lammps_jump.scene import Scene
from lammps_jump.studies.runs import middle, not_interrupted
from lammps_jump.sweeps import Results, Say, Store

SIZES = (0.75, 1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 4.0, 6.0, 8.0)
"""Cell sizes in diameters; the thesis used 2."""


def search_name(size: float | None) -> str:
    """Return the name of the contact search with cells of `size` diameters, None for the neighbour list."""
    return "neighbour list" if size is None else f"cells of {size:zg} d"


def cell_time(scene: Scene, size: float | None) -> tuple[float, float]:
    """Return (processor seconds, disc-steps) of a run with cells of `size` diameters, None for the neighbour list."""
    cell_size = None if size is None else size * scene.diameter
    with tempfile.TemporaryDirectory() as folder:
        result = not_interrupted(run_native(scene, Path(folder), ledger=False, cell_size=cell_size))
    return result.cpu_seconds, result.disc_steps


def time_cells(case: Case, store: Store, *, quick: bool, say: Say) -> Results:
    """Time every cell size. A row holds its median seconds and disc-steps per second."""
    case = case.replace({"engine.name": "native"})
    scene, rounds = case.scene(), 3
    sizes: tuple[float | None, ...] = (None, *SIZES)
    if quick:
        steps = min(scene.steps, 2000)
        scene, rounds, sizes = replace(scene, steps=steps, output_steps=steps), 1, (None, 1.0, 2.0, 4.0)
    for size in (None, 2.0):  # compile both searches before the clock starts
        cell_time(replace(scene, steps=2, output_steps=2), size)
    calls = {search_name(size): partial(cell_time, scene, size) for size in sizes}
    times = timed_in_turn(calls, rounds, store, (scene.steps, case.hash), say, "{0[0]:z.2f} s")
    rows = [
        {"size": size, "seconds": middle(s for s, _ in runs), "rate": middle(n / s for s, n in runs if s > 0)}
        for size, runs in zip(sizes, times.values(), strict=True)
    ]
    return {"rows": rows, "rounds": rounds}


def cell_page(data: Results, folder: Path) -> list[str]:
    """Return the table; draws CPU time against cell size, the neighbour list as a line."""
    table = pd.DataFrame(data["rows"]).astype(float)
    cells, lists = table.dropna(subset="size"), table[table["size"].isna()]
    line, levels = Trace("cells", cells["size"], cells.seconds, "measured"), {search_name(None): lists.seconds.min()}
    panel = Panel("CPU time (s)", [line], levels=levels, marks={"thesis": 2.0}, ylim=(0.0, None))
    title, x = "contact search of the native engine", "cell size over disc diameter"
    save(drawn(Chart(title, x, [panel], name=data["case"])), folder / "cells.png")
    columns: dict[str, Column] = {
        "contact search": lambda row: search_name(row["size"]),
        "CPU time (s):": "{seconds:z.2f}",
        "over the best cells:": lambda row: f"{row['seconds'] / cells.seconds.min():z.2f}",
        "M disc-steps/s:": lambda row: f"{row['rate'] / 1e6:z.1f}",
    }
    return [markdown(columns, data["rows"])]


if __name__ == "__main__":
    raise SystemExit(main(__doc__, "cells", time_cells, cell_page))
