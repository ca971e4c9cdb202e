"""CPU time against the cell size of the thesis' contact search (its section 6.4 and recommendation 2).

The native engine with cells made anew at every step, each pair tried in the cell that holds its contact point; for
comparison the neighbour list that this engine uses otherwise.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from lammps_jump.scene.scene import Scene
from lammps_jump.studies.timing import Stopwatch, Store, in_turn, machine, middle, versions

SIZES = (0.75, 1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 4.0, 6.0, 8.0)
"""Cell sizes in diameters; the thesis used 2."""


def cell_time(scene: Scene, size: float | None) -> tuple[float, float]:
    """(processor seconds, disc-steps) of a run with cells of `size` diameters, None for the neighbour list."""
    from lammps_jump.engines.native import run_native

    cell_size = None if size is None else size * scene.diameter
    with tempfile.TemporaryDirectory() as folder, Stopwatch() as watch:
        result = run_native(scene, Path(folder), ledger=False, cell_size=cell_size)
    return watch.cpu, result.disc_steps


def bench_cells(
    case: Path, *, out: Path | None = None, quick: bool = False, assignments: Sequence[str] = (), fresh: bool = False,
    say: Callable[[str], None] = print,
) -> str:  # fmt: skip
    """``lammps-jump bench CASE --cells``: table and figure of CPU time against cell size."""
    from lammps_jump.case import case_hash, load_case
    from lammps_jump.case.to_scene import build_scene

    loaded = load_case(case, [*assignments, "engine.name=native"])
    scene = build_scene(loaded)
    if quick:
        scene = replace(scene, steps=min(scene.steps, 2000), output_steps=min(scene.steps, 2000))
    folder = Path(out) if out else Path("runs") / "bench" / loaded.case.name
    store = Store(folder / "cells.json", fresh=fresh)
    sizes: list[float | None] = [None, *((1.0, 2.0, 4.0) if quick else SIZES)]
    rounds = 1 if quick else 3
    for size in (None, 2.0):  # compile both searches before the clock starts
        cell_time(replace(scene, steps=2, output_steps=2), size)
    times: dict[float | None, list[tuple[float, float]]] = {size: [] for size in sizes}
    for number, size in in_turn(sizes, rounds):
        key = f"{size} {number} {scene.steps} {case_hash(loaded.case)} {versions()}"
        times[size].append(tuple(store.piece(key, lambda s=size: list(cell_time(scene, s)))))
        say(f"  {'neighbour list' if size is None else f'cells of {size:g} d'}: {times[size][-1][0]:.2f} s")
    rows = [
        {
            "size": size,
            "seconds": middle(seconds for seconds, _ in times[size]),
            "rate": middle(steps / seconds for seconds, steps in times[size] if seconds > 0),
        }
        for size in sizes
    ]
    store.data |= {"case": loaded.case.name, "rows": rows, "machine": machine(), "rounds": rounds}
    store.save()
    draw_cells(rows, loaded.case.name, folder / "cells.png")
    table = cell_table(rows)
    (folder / "cells.md").write_text(table)
    return table


def cell_table(rows: list[dict[str, Any]]) -> str:
    """Markdown."""
    best = min(row["seconds"] for row in rows if row["size"] is not None)
    lines = ["| contact search | CPU time (s) | over the best cells | M disc-steps/s |", "|---|---:|---:|---:|"]
    for row in rows:
        name = "neighbour list" if row["size"] is None else f"cells of {row['size']:g} d"
        ratio = row["seconds"] / best
        lines.append(f"| {name} | {row['seconds']:.2f} | {ratio:.2f} | {row['rate'] / 1e6:.1f} |")
    return "\n".join(lines) + "\n"


def draw_cells(rows: list[dict[str, Any]], name: str, path: Path) -> Path:
    """CPU time against cell size, the neighbour list as a line."""
    from lammps_jump.analysis.draw.style import new_figure, save, style

    cells = [row for row in rows if row["size"] is not None]
    with style():
        figure, axes = new_figure(5.6, 3.4)
        axes.plot(
            [row["size"] for row in cells], [row["seconds"] for row in cells], "o-", color="#33508f", label="cells"
        )
        for row in rows:
            if row["size"] is None:
                axes.axhline(row["seconds"], color="#7d7c78", linestyle="--", label="neighbour list")
        axes.axvline(2.0, color="#bbbbbb", linewidth=0.8)
        axes.annotate("thesis", (2.0, 0.02), xycoords=("data", "axes fraction"), fontsize=7, color="#666666")
        axes.set_ylim(bottom=0)
        axes.set_xlabel("cell size over disc diameter")
        axes.set_ylabel("CPU time (s)")
        axes.set_title(f"{name}: contact search of the native engine")
        axes.legend()
        return save(figure, path)
