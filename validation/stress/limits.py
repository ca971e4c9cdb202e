# SPDX-License-Identifier: GPL-2.0-or-later
"""Largest stable step, found by bisection on both engines for a pair, a wall, packings and a deep column.

A small compression keeps contacts closed, and a far smaller perturbation is given as velocities. While it stays small
the motion is linear, and the step is stable exactly where the perturbation does not grow. Boxes are not periodic. Their
walls are as stiff as the discs, and the effect of the ends falls with the square of the discs along a side (0.3 % at
20). A hexagonal crystal with periodic boundaries is tried too, in stock LAMMPS.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache, lru_cache
from math import inf, isfinite, sqrt

import numpy as np

from lammps_jump.engines.native import NativeSimulation
from lammps_jump.physics import contact
from lammps_jump.scene import Box, Plane, Scene, handmade_scene
from lammps_jump.script import script_text
from lammps_jump.studies.runs import run_frames
from lammps_jump.sweeps import Results

DIAMETER, DENSITY, STIFFNESS = 0.2, 1000.0, 2.56e7
MASS = contact.disc_mass(DENSITY, DIAMETER)
OMEGA = contact.angular_frequency(STIFFNESS, 0.5 * MASS)
GROWTH = 1e3
"""Energy of the perturbation over its first value that counts as growth; rounding and beating stay below 10."""
BLOW_UP = 1e8
"""The same for scenes that are not linear from the start (a column still settling, friction, which chatters within
Coulomb's bound): the perturbation of 1e-7 d omega has reached 1e-3 d omega, 0.2 m/s."""
LOOKS = 10
ENGINES = {f"native {scheme}": "native" for scheme in ("velocity_verlet", "leapfrog_extrapolated")}
ENGINES |= {"stock": "stock", "compiled": "compiled"}
"""Kernel of each engine that is tried."""
ARRANGEMENTS = ("pair", "wall", "square", "hexagonal", "column")


def integrator_of(engine: str) -> str:
    """Return the integrator of an engine of `ENGINES`; LAMMPS has velocity Verlet."""
    return engine.split()[1] if engine.startswith("native") else "velocity_verlet"


def predicted_limit(arrangement: str, restitution: float, integrator: str) -> float:
    """Return the closed form: packings by `contact.stable_fraction`; at a wall omega is that of a pair over sqrt 2."""
    xi = contact.damping_ratio(restitution)
    if arrangement == "wall":
        return contact.stable_fraction(xi, integrator, "pair") * sqrt(2.0)
    packing = "hexagonal" if arrangement == "column" else arrangement
    return contact.stable_fraction(xi, integrator, packing)


def _scene(positions, velocities, walls=(), **settings) -> Scene:
    """Return discs with closed contacts; restitution is not corrected, so the damping ratio is the nominal one."""
    positions = np.asarray(positions, float)
    low, high = positions.min(axis=0) - 5 * DIAMETER, positions.max(axis=0) + 5 * DIAMETER
    usual = {"name": "stability", "description": "closed contacts, slightly perturbed", "gravity": (0.0, 0.0)}
    usual |= {"diameter": DIAMETER, "density": DENSITY, "skin": 0.3 * DIAMETER, "overlap_limit": 0.5 * DIAMETER}
    usual |= {"domain": tuple(zip(low, high, strict=True))}
    return handmade_scene(positions, velocities, tuple(walls), **{**usual, **settings})


def arrangement_scene(arrangement: str, fraction: float, restitution: float, integrator: str, *, side=16, **surface):
    """Return a perturbed scene with closed contacts.

    Parameters
    ----------
    arrangement : {'pair', 'wall', 'square', 'hexagonal', 'column'}
    fraction, restitution : float
    integrator : str
    side : int
        Discs along a side.
    surface
        ``friction``, a number, and ``rotation``, true or false.
    """
    settings = {"time_step_fraction": fraction, "restitution": restitution, "integrator": integrator, **surface}
    radius = 0.5 * DIAMETER
    if arrangement == "pair":
        overlap, soft = 4e-4 * DIAMETER, 0.4 * DIAMETER  # a soft wall presses them together and hardly stiffens them
        x, speed = 0.5 * (DIAMETER - overlap), 1e-7 * DIAMETER * OMEGA
        walls = [Plane("left", "x", -x - radius + soft, "above"), Plane("right", "x", x + radius - soft, "below")]
        start = [[-x, 0], [x, 0]], [[speed, 0], [-speed, 0]]
        return _scene(*start, walls, stiffness_wall=1e-3 * STIFFNESS, **settings)
    if arrangement == "wall":
        overlap = 0.05 * DIAMETER
        start = [[0.0, radius - overlap]], [[0.0, 1e-6 * DIAMETER * OMEGA]]
        gravity = (0.0, -STIFFNESS * overlap / MASS)
        return _scene(*start, [Plane("floor", "y", 0.0, "above")], gravity=gravity, **settings)
    if arrangement == "square":
        return _scene(*_square(side), **settings)
    positions, walls, gravity = _settled(arrangement, side)
    velocities = 1e-7 * DIAMETER * OMEGA * np.random.default_rng(7).standard_normal(positions.shape)
    return _scene(positions, velocities, walls, gravity=gravity, **settings)


def _square(side: int) -> tuple[np.ndarray, np.ndarray, list[Box]]:
    """Return a square lattice in a box, perturbed by whole columns and rows to leave its weak shear modes alone."""
    overlap = 1e-6 * DIAMETER
    spacing = DIAMETER - overlap
    j, i = np.divmod(np.arange(side**2), side)
    low, high = overlap - 0.5 * DIAMETER, (side - 1) * spacing + 0.5 * DIAMETER - overlap
    columns, rows = np.random.default_rng(7).standard_normal((2, side))
    velocities = 1e-10 * DIAMETER * OMEGA * np.column_stack([columns[i], rows[j]])
    return np.column_stack([i, j]) * spacing, velocities, [Box("box", (low, high), (low, high))]


def _hexagonal(side: int, rows: int, spacing: float, less: int = 0) -> np.ndarray:
    """Return places of a hexagonal crystal, shape (discs, 2), m; every other row has `less` discs less than `side`."""
    height = spacing * sqrt(3.0) / 2
    places = ((i, j) for j in range(rows) for i in range(side - less * (j % 2)))
    return np.array([(spacing * (i + 0.5 * (j % 2)), height * j) for i, j in places])


@lru_cache(maxsize=8)
def _settled(arrangement: str, side: int) -> tuple[np.ndarray, list[Box], tuple[float, float]]:
    """Return positions, box and gravity of a hexagonal crystal in a tight box, or of a deep column under its weight.

    Both have come to rest.
    """
    column, radius = arrangement == "column", 0.5 * DIAMETER
    overlap, gravity, steps = (0.0, (0.0, -9.81), 40_000) if column else (1e-3 * DIAMETER, (0.0, 0.0), 4_000)
    wide, rows = (10, 4 * side) if column else (side, side + 1 - side % 2)
    wall_x, wall_y = 2 * overlap, sqrt(3.0) * overlap
    positions = _hexagonal(wide, rows, DIAMETER - overlap, less=1)
    right, top = positions.max(axis=0)
    high = top + 5 * DIAMETER if column else top + radius - wall_y
    box = Box("box", (wall_x - radius, right + radius - wall_x), (wall_y - radius, high))
    scene = _scene(positions, np.zeros_like(positions), [box], time_step_fraction=0.1, gravity=gravity)
    simulation = NativeSimulation(scene, ledger=False)
    simulation.run(steps)
    return simulation.positions, [box], gravity


def growth(scene: Scene, engine: str, steps: int, looks: int = LOOKS, script: str | None = None) -> float:
    """Return the largest kinetic energy seen, at equal times, over that at the start; infinite where the run fails.

    The last value would not do: discs that have blown up fly apart, and their dashpots may calm them again. `script`
    is as of `run_frames`.
    """
    every = max(1, steps // looks)
    scene = replace(scene, steps=looks * every, output_steps=every)
    with np.errstate(over="ignore", invalid="ignore"):
        frames = run_frames(scene, ENGINES[engine], dump_format="binary", script=script, check=False)[1]
        start, *later = [float((frame.vx**2).sum() + (frame.vy**2).sum()) for frame in frames] or [1.0, inf]
    return max(later) / start if all(map(isfinite, later)) else inf


def bisect(stable: Callable[[float], bool], low: float, high: float, tolerance: float) -> tuple[float, float]:
    """Return (largest stable, smallest unstable) fraction, `tolerance` of their middle apart; widens its bracket."""
    stable = cache(stable)
    for _ in range(24):
        if not stable(low):
            low, high = 0.8 * low, low
        elif stable(high):
            low, high = high, 1.25 * high
        else:
            break
    while (high - low) > tolerance * 0.5 * (high + low):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if stable(middle) else (low, middle)
    return low, high


def measure_limit(
    arrangement: str, engine: str, restitution: float, *, steps: int = 4000, side=16, tolerance=0.005, **surface
) -> Results:
    """Find the largest stable step of one arrangement on one engine by bisection.

    Parameters
    ----------
    arrangement, engine : str
        Of `ARRANGEMENTS` and `ENGINES`.
    restitution : float
    steps, side : int
        Steps of a trial; discs along a side.
    tolerance : float
        Width of the bracket over its middle.
    surface
        As of `arrangement_scene`; smooth discs without spin unless given.

    Returns
    -------
    dict
        The arguments, and as time-step fractions: ``predicted`` by closed form (docs/theory.md; for the column that of
        a hexagonal packing, a lower bound), ``stable``, the largest seen stable, ``unstable``, the smallest seen
        unstable, ``measured``, their middle, and ``deviation``, measured over predicted less 1.
    """
    integrator = integrator_of(engine)
    predicted = predicted_limit(arrangement, restitution, integrator)

    surface = {"friction": 0.0, "rotation": False, **surface}

    def stable(fraction: float) -> bool:
        scene = arrangement_scene(arrangement, fraction, restitution, integrator, side=side, **surface)
        return growth(scene, engine, steps) < (BLOW_UP if surface["friction"] or arrangement == "column" else GROWTH)

    low, high = bisect(stable, 0.96 * predicted, 1.04 * predicted, tolerance)
    middle = 0.5 * (low + high)
    asked = {"arrangement": arrangement, "engine": engine, "restitution": restitution, **surface}
    found = {"predicted": predicted, "stable": low, "unstable": high, "measured": middle}
    return {**asked, **found, "deviation": middle / predicted - 1.0}


def crystal_growth(restitution: float, fraction: float, steps: int = 20000, side: int = 20) -> Results:
    """Return the growth of a 2 % compressed periodic hexagonal crystal, in stock LAMMPS; 1e300 stands for infinity.

    Raises
    ------
    SetupError
        Where LAMMPS cannot be loaded.
    """
    spacing = 0.98 * DIAMETER
    points = _hexagonal(side, side, spacing) + 1e-3
    speeds = 1e-7 * DIAMETER * OMEGA * np.random.default_rng(7).standard_normal(points.shape)
    domain = ((0.0, side * spacing), (0.0, side * spacing * (sqrt(3.0) / 2)))
    options = {"time_step_fraction": fraction, "restitution": restitution, "steps": steps, "output_steps": steps}
    scene = _scene(points, speeds, domain=domain, **options)
    script = script_text(scene, kernel="stock", dump_format="binary").replace("f f p", "p p p", 1)
    found = min(growth(scene, "stock", steps, looks=1, script=script), 1e300)
    return {"restitution": restitution, "fraction": fraction, "growth": found, "stable": found < 1.0}


def resting_bed(engine: str, steps: int) -> Results:
    """Run a settled bed for some steps on one engine of `limits.ENGINES`.

    Returns
    -------
    dict
        Engine, steps, discs, processor time (s), whether it is right, a message; ``kinetic_share``, the largest kinetic
        energy over m g d of all discs, and ``drift`` of the mean height (d), both in the second half, None without.
    """
    fraction = min(0.1, 0.6 * contact.stable_fraction(contact.damping_ratio(0.2), integrator_of(engine)))
    scene = arrangement_scene("column", fraction, 0.2, integrator_of(engine), side=3)
    count, every, rest = len(scene.positions), max(1, steps // 20), np.zeros_like(scene.velocities)
    scene = replace(scene, steps=20 * every, output_steps=every, velocities=rest, overlap_limit=0.04)
    result, frames = run_frames(scene, ENGINES[engine], check=False)
    bed: Results = {"engine": engine, "steps": steps, "discs": count, "seconds": result.cpu_seconds}
    if not frames:
        told = f"{result.status}: {result.message}"
        return {**bed, "right": False, "message": told, "kinetic_share": None, "drift": None}
    late = frames[len(frames) // 2 :]
    kinetic = max(0.5 * scene.mass * float(np.sum(f.vx**2 + f.vy**2)) for f in late)
    share = kinetic / (scene.mass * 9.81 * scene.diameter * count)
    drift = (float(late[-1].y.mean()) - float(late[0].y.mean())) / scene.diameter
    right = bool(share < 1e-9 and abs(drift) < 1e-6 and result.lost == 0 and len(late[-1].x) == count)
    text = f"kinetic energy at most {share:z.1e} of m g d in the second half, mean height drifts {drift:+z.1e} d"
    return bed | {"right": right, "message": text, "kinetic_share": share, "drift": drift}
