"""Kernels side by side on the developed flow of a case: speed against stock LAMMPS, agreement, and a trial of skins.

The flow is brought to a state full of contacts once, on the native engine. Every variant then starts from the same
discs and they take turns, so that ratios hold on a busy machine.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from lammps_jump.errors import SetupError
from lammps_jump.scene.scene import Scene
from lammps_jump.studies.cross_validation.trajectories import (
    CONTACT_STEPS,
    check_scene,
    developed_scene,
    run_lammps_frames,
    separation,
)
from lammps_jump.studies.timing import Store, in_turn, machine, middle, versions

from .runs import execute
from .settings import SKINS, usable_kernels

WORK, QUICK_WORK = 6e7, 2e6
"""Disc-steps of one timed run: seconds for the slowest, so that starting LAMMPS (0.05 s) does not count."""
ROUNDS = 5


@dataclass(frozen=True)
class Variant:
    """One way to compute the same flow.

    Attributes
    ----------
    name, kernel : str
    assignments : tuple of str
        What differs from the case.
    """

    name: str
    kernel: str
    assignments: tuple[str, ...] = ()


def make_variants(kernels: Sequence[str], friction: float, diameter: float, *, skins: bool = True) -> list[Variant]:
    """Stock first, then what else runs here; skins in diameters for the kernels of LAMMPS."""
    found = [Variant("stock", "stock")]
    if "compiled" in kernels:
        found += [Variant("compiled", "compiled")]
        found += [Variant("compiled, law sign", "compiled", ("contact.friction_law=sign",))] if friction > 0 else []
        found += [Variant("compiled, smooth touch", "compiled", ("contact.touch=smooth",))]
    found += [Variant("native", "native")] if "native" in kernels else []
    for kernel in ("stock", "compiled"):
        if skins and kernel in kernels:
            found += [Variant(f"{kernel}, skin {s:g} d", kernel, (f"engine.skin={s * diameter!r}",)) for s in SKINS]
    return found


def started_from(developed: Scene, scene: Scene, steps: int, output_steps: int | None = None) -> Scene:
    """The scene with the discs of a developed one, for few steps, without probes."""
    return replace(
        scene,
        positions=developed.positions,
        velocities=developed.velocities,
        inlets=tuple(replace(row, first_step=1) for row in scene.inlets),
        gates=(),
        probes=(),
        settle_steps=0,
        steps=steps,
        output_steps=output_steps or steps,
    )


def bench_speed(
    case: Path, *, out: Path | None = None, quick: bool = False, assignments: Sequence[str] = (), fresh: bool = False,
    say: Callable[[str], None] = print,
) -> str:  # fmt: skip
    """``lammps-jump bench CASE --speed``: a markdown table; numbers in ``speed.json``.

    Raises
    ------
    SetupError
        Where LAMMPS does not run here.
    """
    from lammps_jump.case import load_case
    from lammps_jump.case.to_scene import build_scene

    kernels, notes = usable_kernels()
    for note in notes:
        say(f"note: {note}")
    if "stock" not in kernels:
        raise SetupError("bench --speed compares with stock LAMMPS, which does not run here; see `lammps-jump doctor`")

    def scene_of(variant: Variant) -> Scene:
        engine = "native" if variant.kernel == "native" else "lammps"
        kernel = "auto" if engine == "native" else variant.kernel
        texts = [*assignments, f"engine.name={engine}", f"engine.kernel={kernel}", *variant.assignments]
        return build_scene(load_case(case, texts))

    loaded = load_case(case, list(assignments))
    folder = Path(out) if out else Path("runs") / "bench" / loaded.name
    store = Store(folder / "speed.json", fresh=fresh)
    work, rounds = (QUICK_WORK, 1) if quick else (WORK, ROUNDS)
    developed = developed_scene(scene_of(Variant("native", "native")), work=16 * work)
    discs = len(developed.positions)
    steps = max(100, int(work / max(discs, 1)))
    say(f"{loaded.name}: {discs} discs, {developed.description}; {rounds} rounds of {steps} steps")
    variants = make_variants(kernels, loaded.fields.contact.friction, developed.diameter, skins=not quick)
    scenes = {v.name: started_from(developed, scene_of(v), steps) for v in variants}
    identity = f"{loaded.hash} {steps} {versions()}"
    taken: dict[str, list[dict[str, float]]] = {v.name: [] for v in variants}
    for number, variant in in_turn(variants, rounds):
        piece = store.piece(f"{variant.name} {number} {identity}", lambda v=variant: _timed(scenes[v.name], v.kernel))
        taken[variant.name].append(piece)
        say(f"  {number + 1}/{rounds} {variant.name}: {piece['seconds']:.2f} s")
    rows = [_row(v.name, taken[v.name], taken["stock"]) for v in variants]
    agreement = store.piece(f"agreement {identity}", lambda: _agreement(developed, scene_of, variants))
    store.data |= {
        "case": loaded.name, "discs": discs, "steps": steps, "rounds": rounds, "rows": rows,
        "agreement": agreement, "machine": machine(), "versions": versions(),
    }  # fmt: skip
    store.save()
    table = speed_table(rows, agreement)
    (folder / "speed.md").write_text(table)
    return table


def _timed(scene: Scene, kernel: str) -> dict[str, float]:
    with tempfile.TemporaryDirectory() as folder:
        result, watch = execute(scene, Path(folder), kernel)
    return {"seconds": watch.cpu, "disc_steps": result.disc_steps, "status": result.status}


def _row(name: str, runs: list[dict[str, Any]], stock: list[dict[str, Any]]) -> dict[str, Any]:
    """Medians; ratios are those within a round. A run that failed counts nowhere."""
    rates = [run["disc_steps"] / run["seconds"] if run["status"] == "complete" else None for run in runs]
    base = [run["disc_steps"] / run["seconds"] for run in stock]
    ratios = [rate / other for rate, other in zip(rates, base, strict=True) if rate]
    return {
        "name": name,
        "rate": middle(rates),
        "ratio": middle(ratios),
        "least": min(ratios, default=None),
        "most": max(ratios, default=None),
    }


def _agreement(developed: Scene, scene_of: Callable[[Variant], Scene], variants: Sequence[Variant]) -> dict[str, float]:
    """Largest separation (d) over `CONTACT_STEPS` steps: compiled against stock, its ``sign`` against native."""
    names = {v.name for v in variants}
    if "compiled" not in names:
        return {}
    from lammps_jump.engines.plugin.build import plugin_path

    plugin = plugin_path()
    short = started_from(developed, scene_of(Variant("stock", "stock")), CONTACT_STEPS, 100)
    part = separation(run_lammps_frames(short), run_lammps_frames(short, "compiled", plugin), developed.diameter)
    whole = part.other_discs is None
    found = {"compiled and stock": float(part.largest.max(initial=0.0)) if whole else float("inf")}
    if "compiled, law sign" in names:
        sign = started_from(developed, scene_of(Variant("", "compiled", ("contact.friction_law=sign",))), CONTACT_STEPS)
        check = check_scene(sign, kernel="compiled", plugin=plugin)
        found["compiled and native, law sign"] = check.worst
    return found


def speed_table(rows: list[dict[str, Any]], agreement: dict[str, float]) -> str:
    """Markdown."""
    lines = ["| | M disc-steps/s | speed against stock (range) |", "|---|---:|---:|"]
    for row in rows:
        if row["rate"] is None:
            lines.append(f"| {row['name']} | failed | - |")
            continue
        spread = f"{row['ratio']:.2f} ({row['least']:.2f} to {row['most']:.2f})"
        lines.append(f"| {row['name']} | {row['rate'] / 1e6:.1f} | {spread} |")
    lines += ["", *(f"Largest difference of positions after {CONTACT_STEPS} steps, {name}: {value:.1e} d."
                    for name, value in agreement.items())]  # fmt: skip
    return "\n".join(lines).rstrip() + "\n"
