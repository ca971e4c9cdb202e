# SPDX-License-Identifier: GPL-2.0-or-later
"""Test for a statistically steady flow, used by ``run.stop_when_steady``, and its use on a dump.

Test: equivalence by two one-sided t tests (D. J. Schuirmann, J. Pharmacokinet. Biopharm. 15 (1987) 657) on the drift
of a series over a window. A straight line is fitted to the means of equal batches; its drift over the window has a
confidence interval, and the series counts as steady only where the *whole* interval lies within a tolerance. (A test
that merely fails to find a trend would call any noisy or short record steady.) Batches that are still correlated widen
the interval: residuals with lag-1 correlation r > 0 inflate the standard error by sqrt((1 + r)/(1 - r)). Depth,
discharge and toe must all be steady at two looks in a row, half a window apart; in a flow without a toe, depth and
discharge. A flow that lets no disc in for a whole window has drowned its inlet, and ends too. Without rows of inflow
a run ends once its discs rest (`lammps_jump.analysis.grains.rest`).

False-stop rate, measured (tests/runs/test_steady.py; 1,500 records of three windows whose depth drifts by the tolerance
a window, 100 samples a window): below 0.1 % with independent noise, 0.3 % with AR(1) noise of 0.8 from sample to
sample, 3.1 % with 0.95.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from math import inf, sqrt
from pathlib import Path

import numpy as np

from lammps_jump.analysis.flow import Flow, from_scene, moving
from lammps_jump.analysis.grains.rest import RestDetector, begin_of, state_of
from lammps_jump.analysis.jump.result import STILL
from lammps_jump.analysis.jump.track import LEAST_RATIO, LEAST_SHARE, fit_ramp
from lammps_jump.analysis.statistics import student
from lammps_jump.dump import DumpTail, Frame
from lammps_jump.files import DUMP_NAMES
from lammps_jump.scene.scene import Scene

PASSAGES = 1.5
"""Length of the tested record in times that the inflow needs for the studied reach."""
FEWEST_FRAMES = 48
"""The detector wants sixteen batches of several frames each."""
BATCHES = 16
TOLERANCES = {"depth": 0.02, "discharge": 0.02, "toe": 0.5}
"""Drift over one window that still counts as none: shares of the window's mean or the inflow's discharge, and m."""
CONFIDENCE = 0.95
"""Of each one-sided test; the two make an interval of confidence 2 `CONFIDENCE` - 1."""


@dataclass(frozen=True)
class SeriesDrift:
    """Drift of a series over a window.

    Attributes
    ----------
    mean : float
    drift : float
        Change over the window by the fitted line.
    margin : float
        Half-width of its confidence interval; infinite where there are too few samples.
    """

    mean: float
    drift: float
    margin: float


def drift_of(values: np.ndarray, confidence: float = CONFIDENCE, batches: int = BATCHES) -> SeriesDrift:
    """Drift of an equally spaced series over its length.

    Parameters
    ----------
    values : ndarray, shape (n,)
    confidence : float
        Of each one-sided test.
    batches : int
        Number of batch means that the line is fitted to.

    Returns
    -------
    Drift
        With an infinite margin where n < 2 `batches` or a value is no number.
    """
    values = np.asarray(values, float)
    size = len(values) // batches
    if size < 2 or not np.isfinite(values).all():
        return SeriesDrift(float("nan"), float("nan"), inf)
    means = values[len(values) - size * batches :].reshape(batches, size).mean(axis=1)
    place = (np.arange(batches) + 0.5) / batches - 0.5
    spread = float(place @ place)
    slope = float(place @ means) / spread
    residual = means - means.mean() - slope * place
    total = float(residual @ residual)
    # the fit of a line pulls the correlation of independent residuals down by about 2/n: put it back
    correlation = float(residual[1:] @ residual[:-1]) / total + 2.0 / batches if total > 0 else 0.0
    correlation = min(max(correlation, 0.0), 0.9)
    error = sqrt(total / (batches - 2) / spread * (1 + correlation) / (1 - correlation))
    whole = len(values) / (batches * size)  # the batches leave out the few samples that do not fill one
    return SeriesDrift(float(means.mean()), whole * slope, whole * student(batches - 2, confidence) * error)


class SteadyDetector:
    """Fed with a flow's depth, discharge and toe, says when all three are steady.

    Parameters
    ----------
    window : float
        Length of record that is tested, s: several times what the flow needs to pass through the studied reach.
    inflow : float
        Discharge of the inflow, m^2/s: the drift of a discharge below it is measured against it.

    Attributes
    ----------
    reason : str
        Empty until steady; then one sentence for the summary.
    looks : int
        Tests made.
    """

    def __init__(self, window: float, inflow: float = 0.0):
        if not 0 < window < inf:
            raise ValueError(f"window {window!r} s: expected a length of time above 0")
        self.window, self.inflow = window, inflow
        self.reason, self.looks = "", 0
        self.drifts: dict[str, SeriesDrift] = {}
        self._rows: deque[tuple[float, float, float, float]] = deque()
        self._next_look = 0.0
        self._passed = 0

    def feed(self, time: float, depth: float, discharge: float, toe: float) -> bool:
        """Add one sample (equally spaced in time); True once all is steady.

        Parameters
        ----------
        time : float
            s.
        depth : float
            Mean mass depth of the studied reach, m.
        discharge : float
            Mean discharge there, m^2/s.
        toe : float
            Position of the toe, m; NaN where there is none. A toe that comes and goes is never steady.
        """
        if self.reason:
            return True
        self._rows.append((time, depth, discharge, toe))
        while self._rows[0][0] < time - self.window:
            self._rows.popleft()
        self._next_look = self._next_look or time + self.window
        if time >= self._next_look - 1e-9 * self.window:
            self._look(time)
        return bool(self.reason)

    def _look(self, time: float) -> None:
        self.looks += 1
        self._next_look = time + 0.5 * self.window
        columns = np.array(self._rows)[:, 1:].T
        series = dict(zip(TOLERANCES, columns, strict=True))
        jump = np.isfinite(series["toe"]).any()
        self.drifts = {name: drift_of(values) for name, values in series.items() if jump or name != "toe"}
        scales = {name: abs(drift.mean) for name, drift in self.drifts.items()} | {"toe": 1.0}
        scales["discharge"] = max(scales["discharge"], self.inflow)
        allowed = {name: TOLERANCES[name] * scale for name, scale in scales.items()}
        good = all(abs(drift.drift) + drift.margin <= allowed[name] for name, drift in self.drifts.items())
        self._passed = self._passed + 1 if good else 0
        if self._passed >= 2:
            drifts = ", ".join(
                f"{name} {drift.drift:+z.2g} ± {drift.margin:z.1g} (allowed {allowed[name]:z.2g})"
                for name, drift in self.drifts.items()
            )
            self.reason = (
                f"statistically steady{'' if jump else ', without a jump,'} at t = {time:z.4g} s: drift over the last "
                f"{self.window:zg} s of {drifts}; two one-sided t tests, {100 * CONFIDENCE:zg} %, twice in a row"
            )


def flow_state(
    x: np.ndarray,
    vx: np.ndarray,
    mass: float,
    density: float,
    reach: tuple[float, float],
    bins: int = 64,
    relative: np.ndarray | float = 1.0,
) -> tuple[float, float, float]:
    """Depth (m), discharge (m^2/s) and toe (m) of one frame, for `SteadyDetector.feed`.

    Depth and discharge are means over the reach; the toe is the middle of the ramp that `fit_ramp` finds in the mass
    depth, NaN where that is no jump: too low a rise, or a ramp that explains too little.

    Parameters
    ----------
    x, vx : ndarray, shape (n,)
        m, m/s; discs outside the reach are left out.
    mass : float
        Of a nominal disc, kg per metre of width.
    density : float
        kg/m^3.
    reach : (float, float)
        m.
    relative : float or ndarray, shape (n,)
        Mass of each disc over the nominal one.
    """
    low, high = reach
    inside = (x >= low) & (x < high)
    relative = np.broadcast_to(relative, x.shape)[inside]
    depth, edges = np.histogram(x[inside], bins, reach, weights=relative)
    ramp = fit_ramp(edges, depth * mass / (density * (edges[1] - edges[0])))
    jump = ramp is not None and ramp.depth_2 >= LEAST_RATIO * ramp.depth_1 and ramp.share >= LEAST_SHARE
    scale = mass / (density * (high - low))
    toe = 0.5 * (ramp.toe + ramp.end) if ramp is not None and jump else float("nan")
    return scale * relative.sum(), scale * (relative * vx[inside]).sum(), toe


def steady_window(scene: Scene, reach: tuple[float, float]) -> float | None:
    """Length of record for the test, s; None for a scene without inflow, whose discs come to rest instead.

    Of an inflow against time its last values count, those that stay.
    """
    graph = scene.hydrograph
    speeds = [row.vx for row in scene.inlets if row.vx] if graph is None else [graph.speeds[-1]]
    if not speeds or (graph is not None and not graph.depths[-1]):
        return None
    passage = (reach[1] - reach[0]) / abs(float(np.mean(speeds)))
    return max(PASSAGES * passage, FEWEST_FRAMES * scene.output_steps * scene.time_step)


def studied_reach(flow: Flow) -> tuple[float, float]:
    """The part of the studied range that has one and the same floor from its upstream end on (up to a sill), m."""
    low, high = flow.x_range
    x = np.linspace(low, high, 2001)[1:-1]
    bed = flow.bed_height(x)
    other = np.flatnonzero(~(np.abs(bed - bed[0]) < 1e-9))
    return (low, float(x[other[0]])) if other.size and np.isfinite(bed[0]) else (low, high)


class SteadyWatch:
    """A ``should_stop`` callback for the engines: the flow is steady, its inlet is drowned, or its discs rest.

    Parameters
    ----------
    scene : Scene
    folder : Path
        Run folder.
    reach : (float, float)
        Studied part of the channel, m.
    dump_format : {'text', 'gz', 'binary'}

    Attributes
    ----------
    reason : str
        Empty until the run may stop; then the sentence for the summary.
    changing : float
        Time until which the inflow changes, s: frames before it do not count.
    """

    def __init__(self, scene: Scene, folder: Path, reach: tuple[float, float], dump_format: str = "text"):
        self.scene, self.flow, self.reach = scene, from_scene(scene), reach
        # absolute: whoever changes the working directory meanwhile
        self.tail = DumpTail(folder.absolute() / DUMP_NAMES[dump_format], dump_format)
        window = steady_window(scene, reach)
        graph = scene.hydrograph
        self.changing = graph.times[-1] if graph is not None and graph.changes else 0.0
        carried = graph.depths[-1] * graph.speeds[-1] if graph is not None else sum(scene.discharges)
        self.detector = SteadyDetector(window, carried) if window else None
        self.rest = None if scene.inlets else RestDetector(self.flow.g, scene.diameter, begin_of(scene))
        self.reason, self._highest, self._entered = "", 0, 0.0

    def __call__(self) -> bool:
        """Take in the frames that are new; True once the flow is steady, or dead, or at rest."""
        if self.detector is None and self.rest is None:
            return False
        for whole in self.tail.new_frames():
            frame = moving(whole, self.scene)
            if not self.reason:
                time = self.flow.time(frame)
                if self.rest is not None:
                    self.reason = self._at_rest(frame, time, self.rest)
                elif frame.n and self.detector is not None and time >= self.changing:
                    self.reason = self._look(frame, time, self.detector)
        return bool(self.reason)

    def _at_rest(self, frame: Frame, time: float, rest: RestDetector) -> str:
        """Why the run may stop at a frame without rows of inflow; empty where it may not."""
        if not rest.feed(time, *state_of(frame, self.flow)):
            return ""
        return (
            f"ended at t = {time:z.4g} s: the discs rest since t = {rest.since:z.4g} s, their median speed is below "
            f"{rest.slow:z.2g} m/s and their top constant"
        )

    def _look(self, frame: Frame, time: float, detector: SteadyDetector) -> str:
        """Why the run may stop at a frame; empty where it may not."""
        discs = frame.x, frame.vx, self.scene.mass, self.scene.density
        depth, discharge, toe = flow_state(*discs, self.reach, relative=self.flow.relative_masses(frame))
        highest = int(frame.ids.max())
        if highest > self._highest:
            self._highest, self._entered = highest, time
        elif time - self._entered >= detector.window:
            speed = float(np.median(np.hypot(frame.vx, frame.vy)))
            still = ", and the discs stand still" if speed < STILL * sqrt(self.flow.g * depth) else ""
            return (
                f"ended at t = {time:z.4g} s: the inlet is drowned, no disc has entered since t = "
                f"{self._entered:z.4g} s{still}"
            )
        detector.feed(time, depth, discharge, toe)
        return detector.reason
