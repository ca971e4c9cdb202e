# SPDX-License-Identifier: GPL-2.0-or-later
"""Collisions of two discs against their closed forms: restitution, duration, largest overlap, over many entry phases.

All pairs of one run are independent: pair i starts so that first touch falls at another share of a time step.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from lammps_jump.analysis.draw.style import drawing, save
from lammps_jump.analysis.tables.markdown import Column, markdown
from lammps_jump.case.to_scene import TOUCH_STEPS
from lammps_jump.engines import usable_kernels
from lammps_jump.physics import contact
from lammps_jump.provenance import machine
from lammps_jump.scene import Scene, handmade_scene
from lammps_jump.studies.points import Found, Point, PointStudy
from lammps_jump.studies.runs import run_frames
from lammps_jump.sweeps import Results

DIAMETER, DENSITY, SPEED, OVERLAP = 0.2, 1000.0, 16.0, 0.1
PHASES = 64
QUANTITIES = ("restitution", "duration", "overlap")
COLOURS = ("#33508f", "#8aa0c8", "#7d7c78", "#b5a05a", "#111111")


def collision_scene(
    fraction: float, restitution: float, *, correct: bool = True, speed: float = SPEED, phases: int = PHASES, **law: Any
) -> Scene:
    """Return `phases` pairs of discs, 3 d apart from each other, each about to collide head-on at `speed` (m/s).

    It has the corrected dashpot and the width of a smooth touch that a case gets; `law` may hold integrator and touch.
    """
    k = contact.stiffness(DENSITY, OVERLAP, SPEED)
    dt = fraction * contact.critical_time_step(k, contact.disc_mass(DENSITY, DIAMETER))
    gaps = speed * dt * (1.0 + (np.arange(phases) + 0.5) / phases)
    left = np.column_stack([-0.5 * (DIAMETER + gaps), 3 * DIAMETER * np.arange(phases)])
    return handmade_scene(
        np.stack([left, left * [-1, 1]], axis=1), np.tile([[0.5 * speed, 0.0], [-0.5 * speed, 0.0]], (phases, 1)),
        name="collision", description="pairs of discs, head-on", gravity=(0.0, 0.0), diameter=DIAMETER,
        density=DENSITY, largest_overlap=OVERLAP, impact_speed=SPEED, restitution=restitution,
        time_step_fraction=fraction, correct_restitution=correct, skin=0.3 * DIAMETER,
        touch_width=TOUCH_STEPS * SPEED * dt if law.get("touch") == "smooth" else 0.0,
        steps=int(1.6 * expected(restitution)["duration"] / dt) + 8,
        overlap_limit=DIAMETER,  # a single elastic pair may go deeper than a case allows: that is what is measured
        **law,
    )  # fmt: skip


def measure_collisions(scene: Scene, kernel: str) -> dict[str, np.ndarray]:
    """Return restitution, duration (s) and largest overlap (m) of every pair, shape (phases,).

    The overlap is the largest at a step, the duration the number of steps in contact: both are right to a step.
    """
    _, frames = run_frames(scene, kernel)
    x = np.array([frame.x for frame in frames])
    overlap = scene.diameter - (x[:, 1::2] - x[:, 0::2])
    before, after = (frame.vx[1::2] - frame.vx[0::2] for frame in (frames[0], frames[-1]))
    duration = (overlap > 0).sum(axis=0) * scene.time_step
    return {"restitution": -after / before, "duration": duration, "overlap": overlap.max(axis=0)}


def expected(restitution: float, speed: float = SPEED) -> dict[str, float]:
    """Return the closed forms for the same pair (docs/theory.md, one collision, exactly)."""
    k = contact.stiffness(DENSITY, OVERLAP, SPEED)
    omega = contact.angular_frequency(k, 0.5 * contact.disc_mass(DENSITY, DIAMETER))
    return {
        "restitution": restitution,
        "duration": contact.contact_duration(restitution, omega),
        "overlap": contact.largest_overlap(speed, restitution, omega),
    }


def collision_row(way: str, kernel: str, restitution: float, fraction: float, **options: Any) -> Results:
    """Return errors of the mean over all entry phases, and the scatter among them, relative to the closed forms."""
    exact = expected(restitution)
    scene = collision_scene(fraction, restitution, **options)
    row = {"way": way, "restitution": restitution, "fraction": fraction, "steps": scene.coefficients.contact_steps}
    for name, found in measure_collisions(scene, kernel).items():
        row[f"{name}_error"] = float(found.mean() / exact[name] - 1)
        row[f"{name}_scatter"] = float(found.std() / exact[name])
    return row


def collision_study(*, quick: bool = False) -> PointStudy:
    """Return the study of collisions for each restitution, way and stable step (``lammps-jump bench collision``)."""
    kernels, notes = usable_kernels()
    fast = "compiled" if "compiled" in kernels else "native"
    ways: dict[str, tuple[str, dict[str, Any]]] = {
        "stock, corrected": ("stock", {}),
        "stock, uncorrected": ("stock", {"correct": False}),
        "native, thesis scheme": ("native", {"integrator": "leapfrog_extrapolated"}),
        f"{fast}, smooth touch": (fast, {"touch": "smooth"}),
    }
    fractions = (0.05, 0.2) if quick else (0.01, 0.02, 0.05, 0.1, 0.2, 0.4)
    points = []
    for restitution, (way, (kernel, options)) in product((0.2, 1.0) if quick else (0.2, 0.6, 1.0), ways.items()):
        xi, scheme = contact.damping_ratio(restitution), options.get("integrator", "velocity_verlet")
        steps = [f for f in fractions if f <= contact.stable_fraction(xi, scheme, "pair")]
        if kernel in kernels and (restitution < 1 or "correct" not in options):
            for f in steps:
                given = {"way": way, "kernel": kernel, "restitution": restitution, "fraction": f, **options}
                points.append(Point(f"{way}, e {restitution:zg}, f {f:zg}", collision_row, options=given))

    def results(found: Found, stored: Results) -> Results:
        rows = [found[point.name][0] for point in points]
        return {"rows": rows, "notes": notes, "case": "collision", "machine": machine()}

    def draw(results: Results, folder: Path) -> None:
        draw_collisions(results["rows"], folder / "bench_collision.png")

    return PointStudy("collision", points, results, lambda results: [collision_table(results["rows"])], draw)


def collision_table(rows: Iterable[Mapping[str, Any]]) -> str:
    """Return the table: error of the mean and scatter over entry phases, per cent."""

    def error(row: Mapping[str, Any], name: str) -> str:
        return f"{100 * row[f'{name}_error']:+z.2f} ± {100 * row[f'{name}_scatter']:z.2f} %"

    columns: dict[str, Column] = {"e:": "{restitution:zg}", "way": "", "f:": "{fraction:zg}"}
    return markdown(columns | {f"{name}:": partial(error, name=name) for name in QUANTITIES}, rows)


def draw_collisions(rows: Sequence[Results], path: Path) -> None:
    """Draw the error of restitution (mean and scatter) against the step, one panel a restitution coefficient."""
    table = pd.DataFrame(rows)
    looks = dict(zip(table.way.unique(), zip("osD^v", COLOURS, strict=True), strict=False))
    panels = table.groupby("restitution")
    with drawing(3.2 * len(panels) + 1.2, 3.4, 1, len(panels), squeeze=False) as (figure, axes):
        for panel, (e, part) in zip(axes.flat, panels, strict=True):
            for way, group in part.groupby("way", sort=False):
                mark, colour = looks[way]
                error, bars = 100 * group.restitution_error, 100 * group.restitution_scatter
                panel.errorbar(group.fraction, error, yerr=bars, marker=mark, color=colour, label=way, lw=1, capsize=2)
            panel.axhline(0, color="#555555", linewidth=0.8)
            panel.set(xscale="log", xlabel="f, step over 2/omega", title=f"e = {e:zg}")
            panel.legend(fontsize=7)
        axes.flat[0].set_ylabel("error of restitution (%),\nbars: scatter over entry phases")
        save(figure, path)
