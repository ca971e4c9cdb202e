# SPDX-License-Identifier: GPL-2.0-or-later
"""Collisions of two discs against their closed forms: restitution, duration, largest overlap, over many entry phases.

All pairs of one run are independent: pair i starts so that first touch falls at another share of a time step.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from lammps_jump import load_case
from lammps_jump.analysis.draw.style import drawing, save
from lammps_jump.dump.read import open_dump
from lammps_jump.engines import usable_kernels
from lammps_jump.physics import contact
from lammps_jump.scene.scene import Scene
from lammps_jump.studies.runs import KERNELS, execute
from lammps_jump.studies.store import Store
from lammps_jump.studies.table import markdown

DIAMETER, DENSITY, SPEED, PENETRATION = 0.2, 1000.0, 16.0, 10.0
PHASES = 64
QUANTITIES = ("restitution", "duration", "overlap")


@dataclass(frozen=True)
class Way:
    """One way to compute a collision."""

    name: str
    kernel: str
    integrator: str
    correct: bool = True
    touch: str = "sharp"


@dataclass(frozen=True)
class Row:
    """Errors of the mean over all entry phases and scatter among them, relative to the closed forms.

    Attributes
    ----------
    way : str
    restitution, fraction : float
    steps : float
        Time steps of one contact.
    """

    way: str
    restitution: float
    fraction: float
    steps: float
    restitution_error: float
    restitution_scatter: float
    duration_error: float
    duration_scatter: float
    overlap_error: float
    overlap_scatter: float


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
    """Return `phases` pairs of discs, 3 d apart from each other, each about to collide head-on at `speed` (m/s).

    The scene is made from a case, so it has the corrected dashpot and the width of a smooth touch that a case gets.
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
    return replace(load_case(case).scene(), overlap_limit=DIAMETER)


def measure_collisions(scene: Scene, kernel: str) -> dict[str, np.ndarray]:
    """Return restitution, duration (s) and largest overlap (m) of every pair, shape (phases,).

    The overlap is the largest at a step, the duration the number of steps in contact: both are right to a step.
    """
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
    """Return the closed forms for the same pair (docs/theory.md, one collision, exactly)."""
    k = contact.stiffness(DENSITY, PENETRATION, SPEED)
    omega = contact.angular_frequency(k, 0.5 * contact.disc_mass(DENSITY, DIAMETER))
    return {
        "restitution": restitution,
        "duration": contact.contact_duration(restitution, omega),
        "overlap": contact.largest_overlap(speed, restitution, omega),
    }


def collision_rows(
    fractions: Iterable[float], restitutions: Iterable[float], kernels: Sequence[str] = KERNELS
) -> list[Row]:
    """Return a row for each restitution, way and stable step."""
    rows = []
    for restitution in restitutions:
        limit = contact.damping_ratio(restitution)
        for way in _ways(kernels, restitution):
            steps = [f for f in fractions if f <= contact.stable_fraction(limit, way.integrator, "pair")]
            rows += [_row(way, restitution, fraction) for fraction in steps]
    return rows


def _row(way: Way, restitution: float, fraction: float) -> Row:
    exact = expected(restitution)
    scene = collision_scene(fraction, restitution, integrator=way.integrator, correct=way.correct, touch=way.touch)
    found = measure_collisions(scene, way.kernel)
    numbers = [
        part
        for name in QUANTITIES
        for part in (float(found[name].mean() / exact[name] - 1), float(found[name].std() / exact[name]))
    ]
    return Row(way.name, restitution, fraction, scene.coefficients.contact_steps, *numbers)


def _ways(kernels: Sequence[str], restitution: float) -> list[Way]:
    verlet, thesis = "velocity_verlet", "leapfrog_extrapolated"
    found = []
    if "stock" in kernels:
        found.append(Way("stock, corrected", "stock", verlet))
        if restitution < 1:
            found.append(Way("stock, uncorrected", "stock", verlet, correct=False))
    found.append(Way("native, thesis scheme", "native", thesis))
    fast = "compiled" if "compiled" in kernels else "native"
    found.append(Way(f"{fast}, smooth touch", fast, verlet, touch="smooth"))
    return found


def bench_collisions(folder: Path, *, quick: bool = False) -> str:
    """Measure collisions; returns the table, draws the figure (``lammps-jump bench collision``)."""
    kernels, notes = usable_kernels()
    store = Store(folder / "collision.json", fresh=True)
    fractions = (0.05, 0.2) if quick else (0.01, 0.02, 0.05, 0.1, 0.2, 0.4)
    rows = collision_rows(fractions, (0.2, 1.0) if quick else (0.2, 0.6, 1.0), kernels)
    store.finish(case="collision", rows=rows, notes=notes)
    draw_collisions(rows, folder / "bench_collision.png")
    return store.write_table(collision_table(rows))


def collision_table(rows: list[Row]) -> str:
    """Return the Markdown table: error of the mean and scatter over entry phases, per cent."""
    lines = []
    for row in rows:
        pairs = [(getattr(row, f"{name}_error"), getattr(row, f"{name}_scatter")) for name in QUANTITIES]
        cells = [f"{100 * error:+.2f} ± {100 * scatter:.2f} %" for error, scatter in pairs]
        lines.append([f"{row.restitution:g}", row.way, f"{row.fraction:g}", *cells])
    return markdown(["e", "way", "f", *QUANTITIES], "rlrrrr", lines) + "\n"


def draw_collisions(rows: list[Row], path: Path) -> Path:
    """Draw the error of restitution (mean and scatter) against the step, one panel a restitution coefficient."""
    values = sorted({row.restitution for row in rows})
    ways = list(dict.fromkeys(row.way for row in rows))
    colours = ("#33508f", "#8aa0c8", "#7d7c78", "#b5a05a", "#111111")
    with drawing(3.2 * len(values) + 1.2, 3.4, 1, len(values), squeeze=False) as (figure, axes):
        for panel, e in zip(axes.flat, values, strict=True):
            for i, way in enumerate(ways):
                group = [row for row in rows if row.way == way and row.restitution == e]
                if group:
                    panel.errorbar(
                        [row.fraction for row in group], [100 * row.restitution_error for row in group],
                        yerr=[100 * row.restitution_scatter for row in group], marker="osD^v*"[i % 6],
                        color=colours[i % 5], label=way, linewidth=1.0, capsize=2,
                    )  # fmt: skip
            panel.axhline(0, color="#555555", linewidth=0.8)
            panel.set(xscale="log", xlabel="f, step over 2/omega", title=f"e = {e:g}")
            panel.legend(fontsize=7)
        axes.flat[0].set_ylabel("error of restitution (%),\nbars: scatter over entry phases")
        return save(figure, path)
