# SPDX-License-Identifier: GPL-2.0-or-later
"""One scene on both engines, disc by disc: how far positions differ, from which step on, and how fast that grows.

The growth is measured of LAMMPS from the native engine, and of the native engine from itself.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import takewhile
from math import inf, nan

import numpy as np
from scipy import stats

from lammps_jump.engines.native import NativeSimulation
from lammps_jump.scene import Scene
from lammps_jump.studies.runs import run_frames
from lammps_jump.sweeps import Results

AGREEMENT = 1e-9
"""Positions that must agree do so to this many diameters."""
CONTACT_STEPS = 1_000
"""They must do so over this many steps from the first contact on."""
EVERY = 10
"""Steps between two comparisons."""
ROUND_OFF = 1e-13
"""Separations (diameters) below this are rounding of the coordinates, not yet growth."""
SATURATED = 1e-2
"""Above this a separation (diameters) is not small against a disc, and its growth slows down."""
KNOWN_LIMIT = 1e-3
"""A difference that chaos explains is still a failure beyond this many diameters."""
CHAOS_SHARE = 0.1
CHAOS = "the native engine, started a few last digits off, parts from itself by {:z.1e} d in these steps"
"""Why a case may part within the steps compared: where a perturbed run has parted by at least this share of it."""

FRAMES = 400
JITTER = 1e-15
"""The perturbed run starts this far off (diameters, and shares of speeds): a few last digits."""
LEVELS = (1e-12, AGREEMENT, 1e-6, 1e-3, 1e-1)

Trajectory = dict[int, tuple[np.ndarray, np.ndarray]]
"""Step -> (ids ascending, positions of shape (n, 2), m)."""


@dataclass(frozen=True)
class Separation:
    """Differences between two trajectories of one scene.

    Attributes
    ----------
    steps : ndarray of int, shape (frames,)
        Frames in which both hold the same discs, up to the first in which they do not.
    largest : ndarray, shape (frames,)
        Largest distance between the two places of a disc, in diameters.
    other_discs : int or None
        First step at which the engines hold different discs; None for never.
    """

    steps: np.ndarray
    largest: np.ndarray
    other_discs: int | None

    @property
    def farthest(self) -> float:
        """Largest separation of all frames, diameters; infinite where the discs differ."""
        return float(self.largest.max(initial=0.0)) if self.other_discs is None else inf


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


def trajectory(scene: Scene, kernel: str) -> Trajectory:
    """Return the trajectory on one kernel, every `scene.output_steps` steps, with all digits.

    Raises
    ------
    RunError
        Where the run is not complete.
    """
    _, frames = run_frames(scene, kernel, dump_format="binary")
    return {frame.step: (frame.ids, np.column_stack([frame.x, frame.y])) for frame in frames}


def separation(one: Trajectory, other: Trajectory, diameter: float) -> Separation:
    """Return the distances between two trajectories in the frames they share.

    Parameters
    ----------
    one, other : Trajectory
    diameter : float
        m; separations are in its units.
    """
    shared = sorted(set(one) & set(other))
    same = list(takewhile(lambda step: np.array_equal(one[step][0], other[step][0]), shared))
    apart = [np.hypot(*(one[step][1] - other[step][1]).T).max(initial=0.0) / diameter for step in same]
    return Separation(np.array(same, int), np.array(apart, float), next(iter(shared[len(same) :]), None))


def perturbed(scene: Scene, seed: int = 1, jitter: float = JITTER) -> Scene:
    """Return the scene perturbed: its start is shifted by at most `jitter` diameters, row speeds by that share."""
    rng = np.random.default_rng(seed)
    positions = scene.positions + rng.uniform(-jitter, jitter, scene.positions.shape) * scene.diameter
    positions.setflags(write=False)
    inlets = tuple(replace(row, vx=row.vx * (1.0 + rng.uniform(-jitter, jitter))) for row in scene.inlets)
    return replace(scene, positions=positions, inlets=inlets)


def first_contact(scene: Scene, limit: int) -> int | None:
    """Return the first step (every tenth is tried) with a contact on the native engine; None up to `limit`."""
    simulation = NativeSimulation(replace(scene, probes=()), ledger=False)
    while simulation.energy().elastic <= 0.0:
        if simulation.step >= limit:
            return None
        simulation.run(min(10, limit - simulation.step))
    return simulation.step


def fit_growth(steps: np.ndarray, values: np.ndarray, time_step: float) -> Growth:
    """Return the rate of growth of a separation: least squares through ln(values) between two levels.

    The frames used run from the last time the values were below `ROUND_OFF` to the first time they reach `SATURATED`.

    Parameters
    ----------
    steps : ndarray of int, shape (frames,)
    values : ndarray, shape (frames,)
        Separations in diameters.
    time_step : float
        s.
    """
    above = np.flatnonzero(values >= SATURATED)
    stop = int(above[0]) + 1 if above.size else len(values)
    below = np.flatnonzero(values[:stop] < ROUND_OFF)
    start = int(below[-1]) + 1 if below.size else 0
    t, v = steps[start:stop] * time_step, values[start:stop]
    if len(v) < 5 or not (v > 0).all() or v[-1] <= v[0]:
        return Growth(nan, ROUND_OFF, SATURATED, None, None, nan)
    fit = stats.linregress(t, np.log(v))
    first, last = int(steps[start]), int(steps[stop - 1])
    return Growth(float(fit.slope), ROUND_OFF, SATURATED, first, last, float(fit.rvalue**2))


def crossing_step(part: Separation, level: float) -> int | None:
    """Return the first step at which the largest separation exceeds a level; None where it never does."""
    beyond = np.flatnonzero(part.largest > level)
    return int(part.steps[beyond[0]]) if beyond.size else None


@dataclass(frozen=True)
class DeterministicCheck:
    """Outcome of one scene: whether both engines follow the same path over the first steps with contacts.

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
    expected_difference : str or None
        Why a scene that does not agree need not; see `explain`.
    """

    name: str
    kernel: str
    discs: int
    first_contact: int | None
    last_step: int
    worst: float
    agrees: bool
    note: str = ""
    expected_difference: str | None = None

    @property
    def passed(self) -> bool:
        """Tells whether it agrees or its difference is expected."""
        return self.agrees or self.expected_difference is not None

    def explain(self, own: Callable[[], float]) -> DeterministicCheck:
        """Return the check with chaos as the reason of a small difference.

        Parameters
        ----------
        own : callable
            Separation (d) of the native engine from a perturbed run, a few last digits off at its start, over the same
            steps.
        """
        if self.agrees or self.note or not self.worst <= KNOWN_LIMIT:
            return self
        apart = own()
        return replace(self, expected_difference=CHAOS.format(apart)) if apart >= CHAOS_SHARE * self.worst else self


def perturbed_separation(scene: Scene, steps: int) -> float:
    """Return the largest separation (d) of a native run and a perturbed one; infinite where the discs differ."""
    one, other = (trajectory(plain_scene(start, steps, EVERY), "native") for start in (scene, perturbed(scene)))
    return separation(one, other, scene.diameter).farthest


def plain_scene(scene: Scene, steps: int, output_steps: int) -> Scene:
    """Return the scene without force probes and with other numbers of steps."""
    return replace(scene, probes=(), steps=steps, output_steps=output_steps)


def developed_scene(scene: Scene, work: float) -> Scene:
    """Return the scene with the discs of the native engine after 60 % of its steps: a start full of contacts.

    Both engines then start from these positions and velocities, without spin. Open gates are removed, and the inlets
    count their intervals from the first step.

    Parameters
    ----------
    scene : Scene
    work : float
        Fewer steps where 60 % would take more than this many disc-steps.
    """
    simulation = NativeSimulation(replace(scene, probes=()), ledger=False)
    goal = max(int(0.6 * scene.steps), scene.settle_steps + 1)
    while simulation.step < goal and (simulation.disc_steps < work or simulation.step <= scene.settle_steps):
        simulation.run(min(500, goal - simulation.step))
    text = f"{scene.description} (from t = {scene.time(simulation.step):z.3g} s on)"
    return with_discs_of(simulation, replace(scene, name=f"{scene.name}, developed", description=text))


def with_discs_of(source: NativeSimulation | Scene, scene: Scene) -> Scene:
    """Return the scene with the discs of another, or of a simulation, at its start; gates are open.

    Ids begin at 1 again. Where sizes differ, discs get the ids whose diameters come in the same order. The diameters
    then change by less than a per cent of their range.
    """
    inlets = tuple(replace(row, first_step=scene.size_steps) for row in scene.inlets)
    places, velocities = source.positions, source.velocities
    if scene.sizes:
        ids = np.arange(1, len(places) + 1)
        was = source.radii if isinstance(source, NativeSimulation) else source.diameters(ids)
        taken = np.empty(len(ids), int)
        taken[np.argsort(scene.diameters(ids), kind="stable")] = np.argsort(was, kind="stable")
        places, velocities = places[taken], velocities[taken]
    return replace(scene, positions=places, velocities=velocities, inlets=inlets, walls=scene.standing, settle_steps=0)


def check_scene(scene: Scene, *, kernel: str = "stock") -> DeterministicCheck:
    """Run a scene on both engines over the first steps with contacts and compare every disc.

    Parameters
    ----------
    scene : Scene
        Its own `steps` bound the search for the first contact.
    kernel : {'stock', 'compiled'}
        LAMMPS kernel to compare with the native engine.
    """
    touched = first_contact(scene, scene.steps)
    if touched is None:
        note = f"no contact in {scene.steps} steps: nothing was tested"
        return DeterministicCheck(scene.name, kernel, len(scene.positions), None, 0, nan, False, note)
    last = -(-(touched + CONTACT_STEPS) // EVERY) * EVERY
    short = plain_scene(scene, last, EVERY)
    native = trajectory(short, "native")
    part = separation(native, trajectory(short, kernel), scene.diameter)
    worst, discs = float(part.largest.max(initial=0.0)), len(native[last][0])
    note = "" if part.other_discs is None else f"the engines hold different discs at step {part.other_discs}"
    return DeterministicCheck(scene.name, kernel, discs, touched, last, worst, not note and worst <= AGREEMENT, note)


@dataclass(frozen=True)
class Divergence:
    """Divergence of two runs of a case after they have agreed.

    Attributes
    ----------
    engines, perturbed : Separation
        LAMMPS from native; native from native with a start a few last digits off.
    found : dict
        What is stored: `Growth` of both, first step beyond each of `LEVELS` (None for never), kernel and others.
    """

    engines: Separation
    perturbed: Separation
    found: Results


def measure_divergence(scene: Scene, kernel: str, work: float) -> Divergence:
    """Compare both engines, and the native engine with a perturbed run, until discs have parted or `work` is done."""
    bare = replace(scene, probes=())
    steps = parting_step(bare, work)
    interval = max(1, steps // FRAMES)
    long = plain_scene(scene, max(interval, steps // interval * interval), interval)
    native = trajectory(long, "native")
    part = separation(native, trajectory(long, kernel), scene.diameter)
    own = separation(native, trajectory(perturbed(long), "native"), scene.diameter)
    dt = scene.time_step
    return Divergence(part, own, {
        "kernel": kernel,
        "time_step": dt,
        "steps": int(part.steps[-1]) if len(part.steps) else 0,
        "growth": fit_growth(part.steps, part.largest, dt),
        "twin_growth": fit_growth(own.steps, own.largest, dt),
        "first_step_beyond": {f"{level:zg}": crossing_step(part, level) for level in LEVELS},
        "other_discs_from_step": part.other_discs,
        "largest_separation": float(part.largest.max(initial=0.0)),
    })  # fmt: skip


def parting_step(scene: Scene, work: float) -> int:
    """Return a step soon after the native engine and a perturbed run have parted by 1 d; at most `work` disc-steps."""
    one, two = (NativeSimulation(s, ledger=False) for s in (scene, perturbed(scene)))
    while one.step < scene.steps and one.disc_steps < work:
        chunk = min(200, scene.steps - one.step)
        one.run(chunk)
        two.run(chunk)
        if not np.array_equal(one.ids, two.ids):
            break
        apart = np.abs(one.positions - two.positions)
        if apart.size and apart.max() > scene.diameter:
            break
    return min(scene.steps, one.step + one.step // 4)
