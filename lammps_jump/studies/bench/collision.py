"""Collisions of two discs against their closed forms: restitution, duration, largest overlap, over many entry phases.

All pairs of one run are independent: pair i starts so that first touch falls at another share of a time step.
"""

from __future__ import annotations

import json
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from lammps_jump.case import parse_case
from lammps_jump.case.to_scene import build_scene
from lammps_jump.physics import contact
from lammps_jump.scene.scene import Scene

DIAMETER, DENSITY, SPEED, PENETRATION = 0.2, 1000.0, 16.0, 10.0
PHASES = 64


def collision_scene(
    fraction: float,
    restitution: float,
    *,
    integrator: str = "velocity_verlet",
    correct: bool = True,
    touch: str = "sharp",
    speed: float = SPEED,
    phases: int = PHASES,
) -> Scene:
    """`phases` pairs of discs, 3 d apart from each other, each about to collide head-on at `speed` (m/s).

    Made as a case is: the correction of the dashpot and the width of a smooth touch are those that a case gets.
    """
    k = contact.stiffness(DENSITY, PENETRATION, SPEED)
    dt = fraction * contact.critical_time_step(k, contact.disc_mass(DENSITY, DIAMETER))
    gaps = speed * dt * (1.0 + (np.arange(phases) + 0.5) / phases)
    heights = 3 * DIAMETER * np.arange(phases)
    left = np.column_stack([-0.5 * (DIAMETER + gaps), heights])
    positions = np.stack([left, left * [-1, 1]], axis=1).reshape(-1, 2)
    velocities = np.tile([[0.5 * speed, 0.0], [-0.5 * speed, 0.0]], (phases, 1))
    steps = int(1.6 * expected(restitution)["duration"] / dt) + 8
    case = {
        "name": "collision",
        "description": "pairs of discs, head-on",
        "gravity": 0,
        "discs": {"diameter": DIAMETER, "density": DENSITY},
        "contact": {
            "restitution": restitution, "friction": 0, "penetration_fraction": PENETRATION, "impact_speed": SPEED,
            "correct_restitution": correct, "touch": touch,
        },
        "initial": [{"kind": "list", "positions": positions.tolist(), "velocities": velocities.tolist()}],
        "run": {
            "duration": steps * dt, "output_interval": dt, "time_step_fraction": fraction, "integrator": integrator,
            "allow_unstable": True,
        },
        "engine": {"name": "native"},  # may have any integrator and touch; `measure_collisions` runs on any engine
    }  # fmt: skip
    # a single elastic pair may go deeper than a case allows: that is what is measured
    return replace(build_scene(parse_case(json.dumps(case), "collision")), overlap_limit=DIAMETER)


def measure_collisions(scene: Scene, kernel: str) -> dict[str, np.ndarray]:
    """Restitution, duration (s) and largest overlap (m) of every pair, shape (phases,).

    The overlap is the largest at a step, the duration the number of steps in contact: both are right to a step.
    """
    from lammps_jump.dump.read import open_dump

    from .runs import execute

    with tempfile.TemporaryDirectory() as folder:
        execute(scene, Path(folder), kernel)
        frames = [frame.sorted() for frame in open_dump(Path(folder) / "dump.lammpstrj")]
    x = np.array([frame.x for frame in frames])
    overlap = scene.diameter - (x[:, 1::2] - x[:, 0::2])
    last, first = frames[-1], frames[0]
    parting = (last.vx[1::2] - last.vx[0::2]) / (first.vx[0::2] - first.vx[1::2])
    return {
        "restitution": parting,
        "duration": (overlap > 0).sum(axis=0) * scene.time_step,
        "overlap": overlap.max(axis=0),
    }


def expected(restitution: float, speed: float = SPEED) -> dict[str, float]:
    """Closed forms (docs/theory.md, one collision, exactly) for the same pair."""
    k = contact.stiffness(DENSITY, PENETRATION, SPEED)
    omega = contact.angular_frequency(k, 0.5 * contact.disc_mass(DENSITY, DIAMETER))
    return {
        "restitution": restitution,
        "duration": contact.contact_duration(restitution, omega),
        "overlap": contact.largest_overlap(speed, restitution, omega),
    }


def collision_rows(
    fractions=(0.01, 0.02, 0.05, 0.1, 0.2), restitutions=(0.2, 0.6, 1.0), kernels=("stock", "compiled", "native")
) -> list[dict[str, Any]]:
    """One row a setting: mean errors relative to the closed forms and the scatter over entry phases."""
    rows = []
    for restitution in restitutions:
        exact = expected(restitution)
        for label, kernel, integrator, correct, touch in _ways(kernels, restitution):
            for fraction in fractions:
                if fraction > contact.stable_fraction(contact.damping_ratio(restitution), integrator, "pair"):
                    continue
                scene = collision_scene(fraction, restitution, integrator=integrator, correct=correct, touch=touch)
                found = measure_collisions(scene, kernel)
                row: dict[str, Any] = {"way": label, "restitution": restitution, "fraction": fraction}
                row["steps"] = scene.coefficients.contact_steps
                for name, values in found.items():
                    row[f"{name}_error"] = float(values.mean() / exact[name] - 1)
                    row[f"{name}_scatter"] = float(values.std() / exact[name])
                rows.append(row)
    return rows


def _ways(kernels, restitution: float):
    verlet, thesis = "velocity_verlet", "leapfrog_extrapolated"
    found = []
    if "stock" in kernels:
        found.append(("stock, corrected", "stock", verlet, True, "sharp"))
        if restitution < 1:
            found.append(("stock, uncorrected", "stock", verlet, False, "sharp"))
    found.append(("native, thesis scheme", "native", thesis, True, "sharp"))
    fast = "compiled" if "compiled" in kernels else "native"
    found.append((f"{fast}, smooth touch", fast, verlet, True, "smooth"))
    return found


def bench_collisions(folder: Path, *, quick: bool = False) -> dict[str, Any]:
    """The built-in benchmark ``lammps-jump bench collision``: table, figure and ``collision.json``."""
    from lammps_jump.studies.timing import Store, machine, versions

    from .settings import usable_kernels

    kernels, notes = usable_kernels()
    store = Store(folder / "collision.json", fresh=True)
    fractions = (0.05, 0.2) if quick else (0.01, 0.02, 0.05, 0.1, 0.2, 0.4)
    rows = collision_rows(fractions, (0.2, 1.0) if quick else (0.2, 0.6, 1.0), kernels)
    store.data |= {"case": "collision", "rows": rows, "versions": versions(), "machine": machine(), "notes": notes}
    store.save()
    (folder / "collision.md").write_text(collision_table(rows))
    draw_collisions(rows, folder / "bench_collision.png")
    return store.data


def collision_table(rows: list[dict[str, Any]]) -> str:
    """Markdown: error of the mean and scatter over entry phases, per cent."""
    lines = [
        "| e | way | f | restitution | duration | overlap |",
        "|---:|---|---:|---:|---:|---:|",
    ]
    for row in rows:
        cells = [
            f"{100 * row[f'{name}_error']:+.2f} ± {100 * row[f'{name}_scatter']:.2f} %"
            for name in ("restitution", "duration", "overlap")
        ]
        lines.append(f"| {row['restitution']:g} | {row['way']} | {row['fraction']:g} | " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def draw_collisions(rows: list[dict[str, Any]], path: Path) -> Path:
    """Restitution's error (mean and scatter) against the step, one panel a restitution coefficient."""
    from lammps_jump.analysis.draw.style import new_figure, save, style

    values = sorted({row["restitution"] for row in rows})
    ways = list(dict.fromkeys(row["way"] for row in rows))
    looks = {
        way: ("osD^v*"[i % 6], ("#33508f", "#8aa0c8", "#7d7c78", "#b5a05a", "#111111")[i % 5])
        for i, way in enumerate(ways)
    }
    with style():
        figure, axes = new_figure(3.2 * len(values) + 1.2, 3.4, 1, len(values), squeeze=False)
        for panel, e in zip(axes.flat, values, strict=True):
            for way, (mark, colour) in looks.items():
                group = [row for row in rows if row["way"] == way and row["restitution"] == e]
                if group:
                    panel.errorbar(
                        [row["fraction"] for row in group], [100 * row["restitution_error"] for row in group],
                        yerr=[100 * row["restitution_scatter"] for row in group], marker=mark, color=colour, label=way,
                        linewidth=1.0, capsize=2,
                    )  # fmt: skip
            panel.axhline(0, color="#555555", linewidth=0.8)
            panel.set_xscale("log")
            panel.set_xlabel("f, step over 2/omega")
            panel.set_title(f"e = {e:g}")
            panel.legend(fontsize=7)
        axes.flat[0].set_ylabel("error of restitution (%),\nbars: scatter over entry phases")
        return save(figure, path)
