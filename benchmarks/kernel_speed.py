# SPDX-License-Identifier: GPL-2.0-or-later
"""Benchmarks of time: cell sizes of the contact search, kernels side by side.

What is compared takes turns, so that ratios hold on a busy machine.

- ``--cells``: CPU time against the cell size of the thesis' contact search (its section 6.4 and recommendation 2). The
  native engine makes its cells anew at every step and tries each pair in the cell of its contact point. The neighbour
  list, which this engine uses otherwise, is timed for comparison.
- ``--speed``: kernels and skins against stock LAMMPS on the developed flow of a case. The flow is brought to a
  state full of contacts once, on the native engine. Every variant then starts from the same discs.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from math import inf
from pathlib import Path
from typing import Any

import pandas as pd

from lammps_jump import Case
from lammps_jump.analysis.draw.chart import Chart, Panel, Trace
from lammps_jump.analysis.draw.style import drawn, save
from lammps_jump.analysis.tables.markdown import Column, markdown
from lammps_jump.engines import usable_kernels
from lammps_jump.engines.native import run_native
from lammps_jump.errors import SetupError
from lammps_jump.scene import Scene
from lammps_jump.studies.cross_validation import trajectories
from lammps_jump.studies.cross_validation.trajectories import CONTACT_STEPS
from lammps_jump.studies.runs import KERNELS, in_turn, middle, not_interrupted, run_frames
from lammps_jump.studies.settings import SKINS
from lammps_jump.sweeps import Results, Say, Store, all_versions

SIZES = (0.75, 1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 4.0, 6.0, 8.0)
"""Cell sizes in diameters; the thesis used 2."""
WORK, QUICK_WORK = 6e7, 2e6
"""Disc-steps of one timed run: seconds for the slowest, so that starting LAMMPS (0.05 s) does not count."""
ROUNDS = 5
Variant = tuple[str, dict[str, object]]
"""Kernel, and values that differ from the case."""
Calls = Mapping[str, Callable[[], Any]]


def timed_in_turn(
    calls: Calls, rounds: int, store: Store, identity: object, say: Say, told: str
) -> dict[str, list[Any]]:
    """Return what the calls find, by name, kept in the store; `told` is the line on a round, {0} what it found."""

    def timed(name: str, turn: int) -> Any:
        found = store.piece(f"{name} {turn} {identity} {all_versions()}", calls[name])
        say(f"  {turn + 1}/{rounds} {name}: {told.format(found)}")
        return found

    return in_turn(list(calls), rounds, timed)


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


def make_variants(
    kernels: Sequence[str], friction: float, diameter: float, *, skins: bool = True
) -> dict[str, Variant]:
    """Return by name: stock first, then what else runs here; skins in diameters for the kernels of LAMMPS."""
    found: dict[str, Variant] = {"stock": ("stock", {})}
    if "compiled" in kernels:
        found["compiled"] = ("compiled", {})
        found |= {"compiled, law sign": ("compiled", {"contact.friction_law": "sign"})} if friction > 0 else {}
        found["compiled, smooth touch"] = ("compiled", {"contact.touch": "smooth"})
    found |= {"native": ("native", {})} if "native" in kernels else {}
    lists = [kernel for kernel in ("stock", "compiled") if skins and kernel in kernels]
    return found | {f"{k}, skin {s:zg} d": (k, {"engine.skin": s * diameter}) for k in lists for s in SKINS}


def started_from(developed: Scene, scene: Scene, steps: int, output_steps: int | None = None) -> Scene:
    """Return the scene with the discs of a developed one, for few steps, without probes."""
    return trajectories.plain_scene(trajectories.with_discs_of(developed, scene), steps, output_steps or steps)


def time_kernels(case: Case, store: Store, *, quick: bool, say: Say) -> Results:
    """Time every variant, and measure how far those agree that must.

    Raises
    ------
    SetupError
        Where LAMMPS does not run here.
    """
    kernels, notes = usable_kernels()
    for note in notes:
        say(f"note: {note}")
    if "stock" not in kernels:
        raise SetupError("bench --speed compares with stock LAMMPS, which does not run here; see `lammps-jump doctor`")
    work, rounds = (QUICK_WORK, 1) if quick else (WORK, ROUNDS)
    developed = trajectories.developed_scene(case.replace(KERNELS["native"]).scene(), work=16 * work)
    discs = len(developed.positions)
    steps = max(100, int(work / max(discs, 1)))
    say(f"{case.name}: {discs} discs, {developed.description}; {rounds} rounds of {steps} steps")
    variants = make_variants(kernels, case.fields.contact.friction, developed.diameter, skins=not quick)
    scenes = {name: case.replace({**KERNELS[k], **more}).scene() for name, (k, more) in variants.items()}
    calls = {n: partial(run_rate, started_from(developed, scenes[n], steps), variants[n][0]) for n in variants}
    if "native" in variants:  # compile its loops before the clock starts
        run_rate(started_from(developed, scenes["native"], 2), variants["native"][0])
    found = timed_in_turn(calls, rounds, store, (case.hash, steps), say, "{0[1]:z.2f} s")
    rates = {name: [rate for rate, _ in runs] for name, runs in found.items()}
    rows = [make_row(name, own, rates["stock"]) for name, own in rates.items()]
    agreement = store.piece(f"agreement {case.hash} {steps} {all_versions()}", lambda: _agreement(developed, scenes))
    return {"discs": discs, "steps": steps, "rounds": rounds, "rows": rows, "agreement": agreement}


def run_rate(scene: Scene, kernel: str) -> tuple[float | None, float]:
    """Return disc-steps per second, None for a run that is not complete, and the processor seconds of a run."""
    result, _ = run_frames(scene, kernel, check=False)
    return result.disc_steps / result.cpu_seconds if result.status == "complete" else None, result.cpu_seconds


def make_row(name: str, rates: Sequence[float | None], stock: Sequence[float | None]) -> Results:
    """Return median disc-steps per second, and median, least and greatest ratio to stock within a round.

    A run that failed (None) counts nowhere.
    """
    ratios = [rate / base for rate, base in zip(rates, stock, strict=True) if rate and base]
    least, most = min(ratios, default=None), max(ratios, default=None)
    return {"name": name, "rate": middle(rates), "ratio": middle(ratios), "least": least, "most": most}


def _agreement(developed: Scene, scenes: Mapping[str, Scene]) -> dict[str, float]:
    """Return the largest separation (d) over `CONTACT_STEPS`: compiled against stock, law sign against native."""
    if "compiled" not in scenes:
        return {}
    short = started_from(developed, scenes["stock"], CONTACT_STEPS, 100)
    stock, compiled = (trajectories.trajectory(short, kernel) for kernel in ("stock", "compiled"))
    found = {"compiled and stock": trajectories.separation(stock, compiled, developed.diameter).farthest}
    if sign := scenes.get("compiled, law sign"):
        check = trajectories.check_scene(started_from(developed, sign, CONTACT_STEPS), kernel="compiled")
        found["compiled and native, law sign"] = check.worst
    return found


def speed_page(data: Results, folder: Path) -> list[str]:
    """Return the table and a line for each agreement."""
    ratio = "{ratio:z.2f} ({least:z.2f} to {most:z.2f})"
    columns: dict[str, Column] = {
        "": "{name}",
        "M disc-steps/s:": lambda row: "failed" if row["rate"] is None else f"{row['rate'] / 1e6:z.1f}",
        "speed against stock (range):": lambda row: "-" if row["rate"] is None else ratio.format_map(row),
    }
    notes = [
        f"Largest difference of positions after {CONTACT_STEPS} steps, {name}: {inf if d is None else d:z.1e} d."
        for name, d in data["agreement"].items()
    ]
    return [markdown(columns, data["rows"]), "\n".join(notes)]
