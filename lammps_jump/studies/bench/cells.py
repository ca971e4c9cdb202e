# SPDX-License-Identifier: GPL-2.0-or-later
"""CPU time against the cell size of the thesis' contact search (its section 6.4 and recommendation 2).

The native engine makes its cells anew at every step and tries each pair in the cell of its contact point. The neighbour
list, which this engine uses otherwise, is timed for comparison.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from lammps_jump import Case
from lammps_jump.analysis.draw.style import drawing, save
from lammps_jump.engines.native import run_native
from lammps_jump.scene.scene import Scene
from lammps_jump.studies.store import Store
from lammps_jump.studies.table import markdown, number
from lammps_jump.studies.timing import in_turn, middle, versions

SIZES = (0.75, 1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 4.0, 6.0, 8.0)
"""Cell sizes in diameters; the thesis used 2."""


@dataclass(frozen=True)
class Row:
    """Median times with one contact search.

    Attributes
    ----------
    size : float or None
        Cell size over disc diameter; None for the neighbour list.
    seconds : float
        Processor time, s.
    rate : float
        Disc-steps per second.
    """

    size: float | None
    seconds: float
    rate: float

    @property
    def name(self) -> str:
        """Name of the search."""
        return "neighbour list" if self.size is None else f"cells of {self.size:g} d"


def cell_time(scene: Scene, size: float | None) -> tuple[float, float]:
    """Return (processor seconds, disc-steps) of a run with cells of `size` diameters, None for the neighbour list."""
    cell_size = None if size is None else size * scene.diameter
    with tempfile.TemporaryDirectory() as folder:
        result = run_native(scene, Path(folder), ledger=False, cell_size=cell_size)
    return result.cpu_seconds, result.disc_steps


def bench_cells(case: Case, store: Store, *, quick: bool = False, say: Callable[[str], None] = print) -> str:
    """Time every cell size; returns the table, draws the figure (``lammps-jump bench CASE --cells``)."""
    case = case.replace({"engine.name": "native"})
    scene = case.scene()
    if quick:
        scene = replace(scene, steps=min(scene.steps, 2000), output_steps=min(scene.steps, 2000))
    sizes: list[float | None] = [None, *((1.0, 2.0, 4.0) if quick else SIZES)]
    rounds = 1 if quick else 3
    for size in (None, 2.0):  # compile both searches before the clock starts
        cell_time(replace(scene, steps=2, output_steps=2), size)
    times: dict[float | None, list[list[float]]] = {size: [] for size in sizes}
    for turn, size in in_turn(sizes, rounds):
        key = f"{size} {turn} {scene.steps} {case.hash} {versions()}"
        times[size].append(store.piece(key, lambda s=size: cell_time(scene, s)))
        say(f"  {Row(size, 0, 0).name}: {times[size][-1][0]:.2f} s")
    rows = [
        Row(size, middle(s for s, _ in runs), middle(steps / s for s, steps in runs if s > 0))
        for size, runs in times.items()
    ]
    store.finish(case=case.name, rows=rows, rounds=rounds)
    draw_cells(rows, case.name, store.path.with_suffix(".png"))
    return store.write_table(cell_table(rows))


def cell_table(rows: list[Row]) -> str:
    """Return the Markdown table."""
    best = min(row.seconds for row in rows if row.size is not None)
    lines = [[row.name, number(row.seconds), number(row.seconds / best), number(row.rate / 1e6, 1)] for row in rows]
    head = ["contact search", "CPU time (s)", "over the best cells", "M disc-steps/s"]
    return markdown(head, "lrrr", lines) + "\n"


def draw_cells(rows: list[Row], name: str, path: Path) -> Path:
    """Draw CPU time against cell size, the neighbour list as a line."""
    cells = [row for row in rows if row.size is not None]
    with drawing(5.6, 3.4) as (figure, axes):
        axes.plot([row.size for row in cells], [row.seconds for row in cells], "o-", color="#33508f", label="cells")
        for row in rows:
            if row.size is None:
                axes.axhline(row.seconds, color="#7d7c78", linestyle="--", label=row.name)
        axes.axvline(2.0, color="#bbbbbb", linewidth=0.8)
        axes.annotate("thesis", (2.0, 0.02), xycoords=("data", "axes fraction"), fontsize=7, color="#666666")
        axes.set_ylim(bottom=0)
        title = f"{name}: contact search of the native engine"
        axes.set(xlabel="cell size over disc diameter", ylabel="CPU time (s)", title=title)
        axes.legend()
        return save(figure, path)
