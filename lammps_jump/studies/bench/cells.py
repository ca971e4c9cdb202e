# SPDX-License-Identifier: GPL-2.0-or-later
"""CPU time against the cell size of the thesis' contact search (its section 6.4 and recommendation 2).

The native engine makes its cells anew at every step and tries each pair in the cell of its contact point. The neighbour
list, which this engine uses otherwise, is timed for comparison.
"""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path

from lammps_jump import Case
from lammps_jump.analysis.draw.style import drawing, save
from lammps_jump.engines.native import run_native
from lammps_jump.scene.scene import Scene
from lammps_jump.studies.runs import in_turn, middle
from lammps_jump.studies.table import filled, markdown
from lammps_jump.sweeps.store import Results, Say, Store, all_versions

SIZES = (0.75, 1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 4.0, 6.0, 8.0)
"""Cell sizes in diameters; the thesis used 2."""


def search_name(size: float | None) -> str:
    """Return the name of the contact search with cells of `size` diameters, None for the neighbour list."""
    return "neighbour list" if size is None else f"cells of {size:g} d"


def cell_time(scene: Scene, size: float | None) -> tuple[float, float]:
    """Return (processor seconds, disc-steps) of a run with cells of `size` diameters, None for the neighbour list."""
    cell_size = None if size is None else size * scene.diameter
    with tempfile.TemporaryDirectory() as folder:
        result = run_native(scene, Path(folder), ledger=False, cell_size=cell_size)
    return result.cpu_seconds, result.disc_steps


def time_cells(case: Case, store: Store, *, quick: bool, say: Say) -> Results:
    """Time every cell size. A row holds its median seconds and disc-steps per second."""
    case = case.replace({"engine.name": "native"})
    scene = case.scene()
    if quick:
        scene = replace(scene, steps=min(scene.steps, 2000), output_steps=min(scene.steps, 2000))
    rounds = 1 if quick else 3
    for size in (None, 2.0):  # compile both searches before the clock starts
        cell_time(replace(scene, steps=2, output_steps=2), size)

    def timed(size: float | None, turn: int) -> tuple[float, float]:
        key = f"{size} {turn} {scene.steps} {case.hash} {all_versions()}"
        found = store.piece(key, lambda: cell_time(scene, size))
        say(f"  {search_name(size)}: {found[0]:.2f} s")
        return found

    times = in_turn([None, *((1.0, 2.0, 4.0) if quick else SIZES)], rounds, timed)
    rows = [
        {"size": size, "seconds": middle(s for s, _ in runs), "rate": middle(n / s for s, n in runs if s > 0)}
        for size, runs in times.items()
    ]
    return {"rows": rows, "rounds": rounds}


def cell_page(data: Results, folder: Path) -> str:
    """Return the Markdown table; draws CPU time against cell size, the neighbour list as a line."""
    rows = data["rows"]
    cells = [row for row in rows if row["size"] is not None]
    best = min(row["seconds"] for row in cells)
    told = (
        {"name": search_name(r["size"]), "over": r["seconds"] / best, "million": r["rate"] / 1e6, **r} for r in rows
    )
    lines = filled("{name}|{seconds:.2f}|{over:.2f}|{million:.1f}", told)
    with drawing(5.6, 3.4) as (figure, axes):
        axes.plot([row["size"] for row in cells], [row["seconds"] for row in cells], "o-", color="#33508f",
                  label="cells")  # fmt: skip
        for row in rows:
            if row["size"] is None:
                axes.axhline(row["seconds"], color="#7d7c78", linestyle="--", label=search_name(None))
        axes.axvline(2.0, color="#bbbbbb", linewidth=0.8)
        axes.annotate("thesis", (2.0, 0.02), xycoords=("data", "axes fraction"), fontsize=7, color="#666666")
        axes.set_ylim(bottom=0)
        title = f"{data['case']}: contact search of the native engine"
        axes.set(xlabel="cell size over disc diameter", ylabel="CPU time (s)", title=title)
        axes.legend()
        save(figure, folder / "cells.png")
    return markdown(["contact search", "CPU time (s)", "over the best cells", "M disc-steps/s"], "lrrr", lines) + "\n"
