# SPDX-License-Identifier: GPL-2.0-or-later
"""Kernels side by side on the developed flow of a case: speed against stock LAMMPS, agreement, and a trial of skins.

The flow is brought to a state full of contacts once, on the native engine. Every variant then starts from the same
discs. The variants take turns, so that ratios hold on a busy machine.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import inf
from pathlib import Path

from lammps_jump import Case
from lammps_jump.engines import usable_kernels
from lammps_jump.errors import SetupError
from lammps_jump.scene.scene import Scene
from lammps_jump.studies.cross_validation.trajectories import (
    CONTACT_STEPS,
    check_scene,
    developed_scene,
    plain_scene,
    separation,
    trajectory,
    with_discs_of,
)
from lammps_jump.studies.runs import execute, kernel_changes
from lammps_jump.studies.settings import SKINS
from lammps_jump.studies.store import Store
from lammps_jump.studies.table import markdown
from lammps_jump.studies.timing import in_turn, middle, versions

WORK, QUICK_WORK = 6e7, 2e6
"""Disc-steps of one timed run: seconds for the slowest, so that starting LAMMPS (0.05 s) does not count."""
ROUNDS = 5


@dataclass(frozen=True)
class Variant:
    """One way to compute the same flow.

    Attributes
    ----------
    name, kernel : str
    changes : dict of str
        Values that differ from the case.
    """

    name: str
    kernel: str
    changes: dict[str, object] = field(default_factory=dict)

    def scene(self, case: Case) -> Scene:
        """Return the scene of a case in this variant."""
        return case.replace({**kernel_changes(self.kernel), **self.changes}).scene()


@dataclass(frozen=True)
class Timed:
    """One timed run: processor seconds, disc-steps, and how it ended."""

    seconds: float
    disc_steps: float
    status: str

    @property
    def rate(self) -> float | None:
        """Disc-steps per second; None for a run that is not complete."""
        return self.disc_steps / self.seconds if self.status == "complete" else None


@dataclass(frozen=True)
class Row:
    """A variant: median disc-steps per second, and median, least and greatest ratio to stock within a round."""

    name: str
    rate: float | None
    ratio: float | None
    least: float | None
    most: float | None


def make_variants(kernels: Sequence[str], friction: float, diameter: float, *, skins: bool = True) -> list[Variant]:
    """Return stock first, then what else runs here; skins in diameters for the kernels of LAMMPS."""
    found = [Variant("stock", "stock")]
    if "compiled" in kernels:
        found += [Variant("compiled", "compiled")]
        found += [Variant("compiled, law sign", "compiled", {"contact.friction_law": "sign"})] if friction > 0 else []
        found += [Variant("compiled, smooth touch", "compiled", {"contact.touch": "smooth"})]
    found += [Variant("native", "native")] if "native" in kernels else []
    for kernel in ("stock", "compiled"):
        if skins and kernel in kernels:
            found += [Variant(f"{kernel}, skin {s:g} d", kernel, {"engine.skin": s * diameter}) for s in SKINS]
    return found


def started_from(developed: Scene, scene: Scene, steps: int, output_steps: int | None = None) -> Scene:
    """Return the scene with the discs of a developed one, for few steps, without probes."""
    return plain_scene(with_discs_of(developed, scene), steps, output_steps or steps)


def bench_speed(case: Case, store: Store, *, quick: bool = False, say: Callable[[str], None] = print) -> str:
    """Time every variant and return the table (``lammps-jump bench CASE --speed``).

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
    developed = developed_scene(Variant("native", "native").scene(case), work=16 * work)
    discs = len(developed.positions)
    steps = max(100, int(work / max(discs, 1)))
    say(f"{case.name}: {discs} discs, {developed.description}; {rounds} rounds of {steps} steps")
    variants = make_variants(kernels, case.fields.contact.friction, developed.diameter, skins=not quick)
    scenes = {v.name: started_from(developed, v.scene(case), steps) for v in variants}
    identity = f"{case.hash} {steps} {versions()}"
    taken: dict[str, list[Timed]] = {v.name: [] for v in variants}
    for number, variant in in_turn(variants, rounds):
        key = f"{variant.name} {number} {identity}"
        run = store.piece(key, lambda v=variant: _timed(scenes[v.name], v.kernel), Timed)
        taken[variant.name].append(run)
        say(f"  {number + 1}/{rounds} {variant.name}: {run.seconds:.2f} s")
    rows = [make_row(v.name, taken[v.name], taken["stock"]) for v in variants]
    agreement = store.piece(f"agreement {identity}", lambda: _agreement(developed, case, variants))
    store.finish(case=case.name, discs=discs, steps=steps, rounds=rounds, rows=rows, agreement=agreement)
    return store.write_table(speed_table(rows, agreement))


def _timed(scene: Scene, kernel: str) -> Timed:
    with tempfile.TemporaryDirectory() as folder:
        result = execute(scene, Path(folder), kernel)
    return Timed(result.cpu_seconds, result.disc_steps, result.status)


def make_row(name: str, runs: list[Timed], stock: list[Timed]) -> Row:
    """Return the medians of a variant; a run that failed counts nowhere."""
    ratios = [run.rate / base.rate for run, base in zip(runs, stock, strict=True) if run.rate and base.rate]
    least, most = min(ratios, default=None), max(ratios, default=None)
    return Row(name, middle(run.rate for run in runs), middle(ratios), least, most)


def _agreement(developed: Scene, case: Case, variants: Sequence[Variant]) -> dict[str, float]:
    """Return the largest separation (d) over `CONTACT_STEPS`: compiled against stock, law sign against native."""
    named = {v.name: v for v in variants}
    if "compiled" not in named:
        return {}
    short = started_from(developed, named["stock"].scene(case), CONTACT_STEPS, 100)
    part = separation(trajectory(short, "stock"), trajectory(short, "compiled"), developed.diameter)
    whole = part.other_discs is None
    found = {"compiled and stock": float(part.largest.max(initial=0.0)) if whole else inf}
    if "compiled, law sign" in named:
        sign = started_from(developed, named["compiled, law sign"].scene(case), CONTACT_STEPS)
        found["compiled and native, law sign"] = check_scene(sign, kernel="compiled").worst
    return found


def speed_table(rows: list[Row], agreement: dict[str, float]) -> str:
    """Return the Markdown table and a line for each agreement."""
    lines = [
        [row.name, f"{row.rate / 1e6:.1f}", f"{row.ratio:.2f} ({row.least:.2f} to {row.most:.2f})"]
        if row.rate is not None else [row.name, "failed", "-"]
        for row in rows
    ]  # fmt: skip
    notes = [
        f"Largest difference of positions after {CONTACT_STEPS} steps, {name}: {inf if d is None else d:.1e} d."
        for name, d in agreement.items()
    ]
    table = markdown(["", "M disc-steps/s", "speed against stock (range)"], "lrr", lines)
    return "\n".join([table, "", *notes]).rstrip() + "\n"
