"""The same scene on both engines, disc by disc: how far the positions part, from when on, and how fast."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from math import inf, nan
from pathlib import Path

import numpy as np

from lammps_jump.errors import RunError
from lammps_jump.scene.scene import Scene

AGREEMENT = 1e-9
"""Positions that must agree agree to this many diameters."""
CONTACT_STEPS = 1_000
"""They must do so over this many steps from the first contact on."""
ROUND_OFF = 1e-13
"""Separations (in diameters) below this are the last digits of the coordinates, not yet growth."""
SATURATED = 1e-2
"""Above this a separation is no longer small against a disc and grows no more like a small one."""

Trajectory = dict[int, tuple[np.ndarray, np.ndarray]]
"""Step -> (ids ascending, positions of shape (n, 2), m)."""


@dataclass(frozen=True)
class Separation:
    """Two trajectories of one scene held against each other.

    Attributes
    ----------
    steps : ndarray of int, shape (frames,)
        Frames in which both hold the same discs, up to the first in which they do not.
    largest, rms : ndarray, shape (frames,)
        Largest and root-mean-square distance between the two places of a disc, in diameters.
    worst : ndarray, shape (frames, 3)
        Id of the disc with the largest distance, and where it is (m).
    other_discs : int or None
        First step at which the engines hold different discs; None for never.
    """

    steps: np.ndarray
    largest: np.ndarray
    rms: np.ndarray
    worst: np.ndarray
    other_discs: int | None


@dataclass(frozen=True)
class Growth:
    """Exponential growth of a separation, ln(separation) = rate t + const, fitted between two levels.

    Attributes
    ----------
    rate : float
        1/s; NaN where fewer than five frames lie between the levels.
    low, high : float
        Separations in diameters between which it was fitted.
    start, stop : int or None
        Steps of the fit's first and last frame.
    share : float
        Variance of ln(separation) that the line explains.
    """

    rate: float
    low: float
    high: float
    start: int | None
    stop: int | None
    share: float


def run_native_frames(scene: Scene) -> Trajectory:
    """Trajectory of the native engine, every `scene.output_steps` steps.

    Raises
    ------
    RunError
        Where a guard ended the run.
    """
    from lammps_jump.engines.native import frames

    try:
        return {frame.step: (frame.ids, np.column_stack([frame.x, frame.y])) for frame in frames(scene)}
    except RunError as error:
        raise RunError(f"native engine, {scene.name}: {error}") from None


def run_lammps_frames(
    scene: Scene, kernel: str = "stock", plugin: Path | None = None, folder: Path | None = None
) -> Trajectory:
    """Trajectory of LAMMPS from a binary dump (all digits), every `scene.output_steps` steps.

    Raises
    ------
    RunError
        Where the run failed.
    """
    from lammps_jump.dump.read import open_dump
    from lammps_jump.engines.launch import Setting, run
    from lammps_jump.script.stock import DUMP_NAMES

    with tempfile.TemporaryDirectory(prefix="cross-validation-", dir=folder) as work:
        place = Path(work)
        result = run(scene, place, Setting(kernel=kernel, plugin=plugin, dump_format="binary"))
        if result.status != "complete":
            raise RunError(f"LAMMPS ({kernel}), {scene.name}: {result.message}")
        trajectory: Trajectory = {}
        for frame in open_dump(place / DUMP_NAMES["binary"]):
            ordered = frame.sorted()
            trajectory[frame.step] = (ordered.ids, np.column_stack([ordered.x, ordered.y]))
    return trajectory


def separation(one: Trajectory, other: Trajectory, diameter: float) -> Separation:
    """Distance between two trajectories in the frames they share.

    Parameters
    ----------
    one, other : Trajectory
    diameter : float
        m; separations are in its units.
    """
    rows, other_discs = [], None
    for step in sorted(set(one) & set(other)):
        (ids, places), (other_ids, other_places) = one[step], other[step]
        if not np.array_equal(ids, other_ids):
            other_discs = step
            break
        if not len(ids):
            rows.append((step, 0.0, 0.0, 0, nan, nan))
            continue
        distance = np.hypot(*(places - other_places).T) / diameter
        k = int(np.argmax(distance))
        rows.append((step, float(distance[k]), float(np.sqrt(np.mean(distance**2))), int(ids[k]), *places[k]))
    table = np.array(rows, float).reshape(-1, 6)
    return Separation(table[:, 0].astype(int), table[:, 1], table[:, 2], table[:, 3:], other_discs)


def first_contact(scene: Scene, limit: int) -> int | None:
    """First step (looked at every tenth) at which any disc is in contact on the native engine; None up to `limit`."""
    from lammps_jump.engines.native import NativeSimulation

    simulation = NativeSimulation(replace(scene, probes=()), ledger=False)
    while simulation.energy().elastic <= 0.0:
        if simulation.step >= limit:
            return None
        simulation.run(min(10, limit - simulation.step))
    return simulation.step


def fit_growth(
    steps: np.ndarray, values: np.ndarray, time_step: float, low: float = ROUND_OFF, high: float = SATURATED
) -> Growth:
    """Rate of growth of a separation: least squares through ln(values) between two levels.

    The frames used run from the last time the values were below `low` to the first time they reach `high`.

    Parameters
    ----------
    steps : ndarray of int, shape (frames,)
    values : ndarray, shape (frames,)
        Separations in diameters.
    time_step : float
        s.
    """
    above = np.flatnonzero(values >= high)
    stop = int(above[0]) + 1 if above.size else len(values)
    below = np.flatnonzero(values[:stop] < low)
    start = int(below[-1]) + 1 if below.size else 0
    t, v = steps[start:stop] * time_step, values[start:stop]
    if len(v) < 5 or not (v > 0).all() or v[-1] <= v[0]:
        return Growth(nan, low, high, None, None, nan)
    logs = np.log(v)
    rate, offset = np.polyfit(t, logs, 1)
    rest = logs - rate * t - offset
    share = 1.0 - float(rest.var() / logs.var()) if logs.var() > 0 else nan
    return Growth(float(rate), low, high, int(steps[start]), int(steps[stop - 1]), share)


def crossing_step(part: Separation, level: float) -> int | None:
    """First step at which the largest separation exceeds a level; None where it never does."""
    beyond = np.flatnonzero(part.largest > level)
    return int(part.steps[beyond[0]]) if beyond.size else None


@dataclass(frozen=True)
class DeterministicCheck:
    """Outcome of one scene: do the engines walk the same path over the first steps with contacts?

    Attributes
    ----------
    name, kernel : str
    discs : int
        In the last frame compared.
    first_contact, last_step : int or None
    worst : float
        Largest separation over those steps, in diameters.
    agrees : bool
        ``worst <= AGREEMENT``, the same discs, and there was a contact.
    note : str
    """

    name: str
    kernel: str
    discs: int
    first_contact: int | None
    last_step: int
    worst: float
    agrees: bool
    note: str = ""


def twin_separation(scene: Scene, twin: Scene, steps: int, output_steps: int = 10) -> float:
    """Largest separation (d) of two native runs of a scene and its twin; infinite where their discs become others."""
    runs = [run_native_frames(plain_scene(one, steps, output_steps)) for one in (scene, twin)]
    part = separation(*runs, scene.diameter)
    return float(part.largest.max(initial=0.0)) if part.other_discs is None else inf


def plain_scene(scene: Scene, steps: int, output_steps: int) -> Scene:
    """The scene without force probes, with other numbers of steps."""
    return replace(scene, probes=(), steps=steps, output_steps=output_steps)


def developed_scene(scene: Scene, share: float = 0.6, work: float = 3e8) -> Scene:
    """The scene as it stands on the native engine after a share of its run: a start full of contacts.

    Both engines then start from these positions and velocities (discs without spin); gates that have opened are gone,
    the inlets' turns count anew from the first step.

    Parameters
    ----------
    share : float
        Of the steps; fewer where that would take more than `work` disc-steps.
    """
    from lammps_jump.engines.native import NativeSimulation

    simulation = NativeSimulation(replace(scene, probes=()), ledger=False)
    goal = max(int(share * scene.steps), scene.settle_steps + 1)
    while simulation.step < goal and (simulation.disc_steps < work or simulation.step <= scene.settle_steps):
        simulation.run(min(500, goal - simulation.step))
    inlets = tuple(replace(row, first_step=1) for row in scene.inlets)
    return replace(
        scene,
        name=f"{scene.name}, developed",
        description=f"{scene.description} (from t = {scene.time(simulation.step):.3g} s on)",
        positions=simulation.positions,
        velocities=simulation.velocities,
        inlets=inlets,
        gates=(),
        settle_steps=0,
    )


def check_scene(
    scene: Scene,
    *,
    kernel: str = "stock",
    plugin: Path | None = None,
    contact_steps: int = CONTACT_STEPS,
    output_steps: int = 10,
    native: Callable[[Scene], Trajectory] = run_native_frames,
) -> DeterministicCheck:
    """Run a scene on both engines over the first steps with contacts and compare every disc.

    Parameters
    ----------
    scene : Scene
        Its own `steps` bound the search for the first contact.
    kernel, plugin
        LAMMPS kernel to compare with.
    """
    touched = first_contact(scene, scene.steps)
    if touched is None:
        note = f"no contact in {scene.steps} steps: nothing was tested"
        return DeterministicCheck(scene.name, kernel, len(scene.positions), None, 0, nan, False, note)
    last = -(-(touched + contact_steps) // output_steps) * output_steps
    short = plain_scene(scene, last, output_steps)
    part = separation(native(short), run_lammps_frames(short, kernel, plugin), scene.diameter)
    worst = float(part.largest.max(initial=0.0))
    whole = part.other_discs is None
    note = "" if whole else f"the engines hold different discs at step {part.other_discs}"
    discs = int(np.max(part.worst[:, 0], initial=0))
    return DeterministicCheck(
        scene.name, kernel, max(discs, len(scene.positions)), touched, last, worst, whole and worst <= AGREEMENT, note
    )
