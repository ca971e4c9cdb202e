# SPDX-License-Identifier: GPL-2.0-or-later
"""What springs cost: a step of a case beside the frictionless step of the same discs, native and compiled.

Run as ``python benchmarks/springs.py CASE [--set PATH=VALUE] [--quick] [--out DIR]`` with ``LAMMPS_JUMP_THREADS=1``.
The flow is brought to a state full of contacts once, on the native engine. Every variant starts from the same discs;
they take turns. Ratios are of the runs of one turn.
"""

from __future__ import annotations

from functools import partial
from statistics import median

from kernel_speed import run_rate, started_from
from taking_turns import main, timed_in_turn

from lammps_jump import Case
from lammps_jump.analysis.tables import Column, markdown
from lammps_jump.engines import usable_kernels
from lammps_jump.errors import SetupError
from lammps_jump.studies.cross_validation import trajectories
from lammps_jump.studies.runs import KERNELS, middle
from lammps_jump.sweeps import Results, Say, Store

WORK, QUICK_WORK = 1.5e7, 2e6
"""Disc-steps of one timed run: few, so that discs without friction are still packed as they were."""
ROUNDS = 7
LAWS = {
    "springs": {"contact.friction_law": "history"},
    "viscous friction": {"contact.friction_law": "viscous", "contact.rolling": None},
    "frictionless": {
        "contact.friction": 0,
        "contact.friction_law": "viscous",
        "contact.rolling": None,
        "contact.rotation": False,
    },
}
KINDS = ("native", "compiled")


def time_springs(case: Case, store: Store, *, quick: bool, say: Say) -> Results:
    """Time each law on each engine that runs here, all from the same discs.

    Raises
    ------
    SetupError
        The case has no springs.
    """
    if case.fields.contact.friction_law != "history":
        raise SetupError(f"{case.name} has no springs; they are contact.friction_law: history")
    work, rounds = (QUICK_WORK, 1) if quick else (WORK, ROUNDS)
    developed = trajectories.developed_scene(case.replace(KERNELS["native"]).scene(), work=20 * WORK)
    discs = len(developed.positions)
    steps = max(100, int(work / max(discs, 1)))
    say(f"{case.name}: {discs} discs, {developed.description}; {rounds} rounds of {steps} steps")
    kernels = [kernel for kernel in KINDS if kernel in usable_kernels()[0]]
    scenes = {
        (kernel, law): started_from(developed, case.replace({**KERNELS[kernel], **changes}).scene(), steps)
        for kernel in kernels
        for law, changes in LAWS.items()
    }
    calls = {f"{kernel}, {law}": partial(run_rate, scene, kernel) for (kernel, law), scene in scenes.items()}
    found = timed_in_turn(calls, rounds, store, (case.hash, steps), say, "{0[1]:z.2f} s")
    rows = []
    for kernel, law in scenes:
        rates = [rate for rate, _ in found[f"{kernel}, {law}"]]
        bare = [rate for rate, _ in found[f"{kernel}, frictionless"]]
        ratios = [b / a for a, b in zip(rates, bare, strict=True) if a and b]
        rows.append({
            "name": f"{kernel}, {law}",
            "nanoseconds": 1e9 / rate if (rate := middle(rates)) else None,
            "ratio": median(ratios) if ratios else None,
            "least": min(ratios, default=None),
            "most": max(ratios, default=None),
        })  # fmt: skip
    return {"discs": discs, "steps": steps, "rounds": rounds, "rows": rows}


def springs_page(data: Results, folder: object) -> list[str]:
    """Return the table."""
    columns: dict[str, Column] = {
        "": "{name}",
        "ns a disc-step:": lambda row: "failed" if row["nanoseconds"] is None else f"{row['nanoseconds']:z.1f}",
        "over frictionless (range):": lambda row: (
            "-" if row["ratio"] is None else f"{row['ratio']:z.2f} ({row['least']:z.2f} to {row['most']:z.2f})"
        ),
    }
    return [markdown(columns, data["rows"])]


if __name__ == "__main__":
    raise SystemExit(main(__doc__, "springs", time_springs, springs_page))
