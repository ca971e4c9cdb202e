# SPDX-License-Identifier: GPL-2.0-or-later
"""Speed of kernels and skins against stock LAMMPS, on the developed flow of a case.

Run as ``python benchmarks/kernel_speed.py CASE [--quick] [--out DIR]``. The flow is brought to a state full of
contacts once, on the native engine. Every variant then starts from the same discs. They take turns, so that ratios hold
on a busy machine.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from math import inf
from pathlib import Path

from taking_turns import main, timed_in_turn

from lammps_jump import Case
from lammps_jump.analysis.tables import Column, markdown
from lammps_jump.engines import usable_kernels
from lammps_jump.errors import SetupError
from lammps_jump.scene import Scene
from lammps_jump.studies.bench import SKINS
from lammps_jump.studies.cross_validation import trajectories
from lammps_jump.studies.cross_validation.trajectories import CONTACT_STEPS
from lammps_jump.studies.runs import KERNELS, middle, run_frames
from lammps_jump.sweeps import Results, Say, Store, all_versions

WORK, QUICK_WORK = 6e7, 2e6
"""Disc-steps of one timed run: seconds for the slowest, so that starting LAMMPS (0.05 s) does not count."""
ROUNDS = 5
Variant = tuple[str, dict[str, object]]
"""Kernel, and values that differ from the case."""


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
        raise SetupError("speeds are compared with stock LAMMPS, which does not run here; see `lammps-jump doctor`")
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


if __name__ == "__main__":
    raise SystemExit(main(__doc__, "speed", time_kernels, speed_page))
