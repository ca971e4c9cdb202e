# SPDX-License-Identifier: GPL-2.0-or-later
"""Kernels side by side on the developed flow of a case: speed against stock LAMMPS, agreement, and a trial of skins.

The flow is brought to a state full of contacts once, on the native engine. Every variant then starts from the same
discs. The variants take turns, so that ratios hold on a busy machine.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import inf
from pathlib import Path

from lammps_jump import Case
from lammps_jump.engines import usable_kernels
from lammps_jump.errors import SetupError
from lammps_jump.scene.scene import Scene
from lammps_jump.studies.cross_validation import trajectories
from lammps_jump.studies.cross_validation.trajectories import CONTACT_STEPS
from lammps_jump.studies.runs import in_turn, kernel_changes, middle, run_frames
from lammps_jump.studies.settings import SKINS
from lammps_jump.studies.table import markdown
from lammps_jump.sweeps.store import Results, Say, Store, all_versions

WORK, QUICK_WORK = 6e7, 2e6
"""Disc-steps of one timed run: seconds for the slowest, so that starting LAMMPS (0.05 s) does not count."""
ROUNDS = 5


Variant = tuple[str, dict[str, object]]
"""Kernel, and values that differ from the case."""


def variant_scene(case: Case, variant: Variant) -> Scene:
    """Return the scene of a case in a variant."""
    kernel, changes = variant
    return case.replace({**kernel_changes(kernel), **changes}).scene()


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
    return found | {f"{k}, skin {s:g} d": (k, {"engine.skin": s * diameter}) for k in lists for s in SKINS}


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
    developed = trajectories.developed_scene(variant_scene(case, ("native", {})), work=16 * work)
    discs = len(developed.positions)
    steps = max(100, int(work / max(discs, 1)))
    say(f"{case.name}: {discs} discs, {developed.description}; {rounds} rounds of {steps} steps")
    variants = make_variants(kernels, case.fields.contact.friction, developed.diameter, skins=not quick)
    scenes = {name: started_from(developed, variant_scene(case, one), steps) for name, one in variants.items()}
    identity = f"{case.hash} {steps} {all_versions()}"

    def timed(name: str, turn: int) -> float | None:
        rate, seconds = store.piece(f"rate {name} {turn} {identity}", lambda: run_rate(scenes[name], variants[name][0]))
        say(f"  {turn + 1}/{rounds} {name}: {seconds:.2f} s")
        return rate

    rates = in_turn(list(variants), rounds, timed)
    rows = [make_row(name, found, rates["stock"]) for name, found in rates.items()]
    agreement = store.piece(f"agreement {identity}", lambda: _agreement(developed, case, variants))
    return {"discs": discs, "steps": steps, "rounds": rounds, "rows": rows, "agreement": agreement}


def run_rate(scene: Scene, kernel: str) -> tuple[float | None, float]:
    """Return disc-steps per second, None for a run that is not complete, and the processor seconds of a run."""
    result, _ = run_frames(scene, kernel)
    return result.disc_steps / result.cpu_seconds if result.status == "complete" else None, result.cpu_seconds


def make_row(name: str, rates: Sequence[float | None], stock: Sequence[float | None]) -> Results:
    """Return median disc-steps per second, and median, least and greatest ratio to stock within a round.

    A run that failed (None) counts nowhere.
    """
    ratios = [rate / base for rate, base in zip(rates, stock, strict=True) if rate and base]
    least, most = min(ratios, default=None), max(ratios, default=None)
    return {"name": name, "rate": middle(rates), "ratio": middle(ratios), "least": least, "most": most}


def _agreement(developed: Scene, case: Case, variants: Mapping[str, Variant]) -> dict[str, float]:
    """Return the largest separation (d) over `CONTACT_STEPS`: compiled against stock, law sign against native."""
    if "compiled" not in variants:
        return {}
    short = started_from(developed, variant_scene(case, variants["stock"]), CONTACT_STEPS, 100)
    paths = [trajectories.trajectory(short, kernel) for kernel in ("stock", "compiled")]
    part = trajectories.separation(*paths, developed.diameter)
    found = {"compiled and stock": part.farthest}
    if "compiled, law sign" in variants:
        sign = started_from(developed, variant_scene(case, variants["compiled, law sign"]), CONTACT_STEPS)
        found["compiled and native, law sign"] = trajectories.check_scene(sign, kernel="compiled").worst
    return found


def speed_page(data: Results, folder: Path) -> str:
    """Return the Markdown table and a line for each agreement."""
    lines = [
        [row["name"], f"{row['rate'] / 1e6:.1f}", f"{row['ratio']:.2f} ({row['least']:.2f} to {row['most']:.2f})"]
        if row["rate"] is not None else [row["name"], "failed", "-"]
        for row in data["rows"]
    ]  # fmt: skip
    notes = [
        f"Largest difference of positions after {CONTACT_STEPS} steps, {name}: {inf if d is None else d:.1e} d."
        for name, d in data["agreement"].items()
    ]
    table = markdown(["", "M disc-steps/s", "speed against stock (range)"], "lrr", lines)
    return "\n".join([table, "", *notes]).rstrip() + "\n"
