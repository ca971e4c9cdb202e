# SPDX-License-Identifier: GPL-2.0-or-later
"""Rest: the discs are slow, their top stays where it is, and none comes or goes.

Discs rest from the first frame after which, up to the last one, the median of their speeds stays below 0.01 sqrt(g d),
the highest edge within 0.05 d, and their number as it is. The stretch must be 20 sqrt(d/g) long: at the allowed speed
the top would move by 0.2 d in it.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf, isfinite, isnan, nan, sqrt

import numpy as np

from lammps_jump.analysis.contacts import ContactCollector
from lammps_jump.analysis.draw.chart import Chart, Drawings, Panel, Trace
from lammps_jump.analysis.flow import Flow
from lammps_jump.analysis.passes import Gathered, Tables
from lammps_jump.analysis.quantity import HeadlineNumber, Quantity
from lammps_jump.analysis.report.page import Section, Table, Text, described
from lammps_jump.dump.frame import Frame
from lammps_jump.scene.scene import Scene
from lammps_jump.units import known, number

SLOW = 0.01
"""Median speed over sqrt(g d) below which discs rest."""
CONSTANT = 0.05
"""Diameters within which the top stays."""
SPAN = 20.0
"""Length of the stretch over sqrt(d/g)."""
LOWEST = 1e-6
"""Least speed over sqrt(g d) that the figure tells apart."""
FEWEST = 4
"""Frames of the stretch."""


@dataclass(frozen=True)
class Rest:
    """Time at which the discs came to rest."""

    time: float = number("s", "time from which on the discs rest", default=nan, label="at rest from")
    speed: float = number("", "median speed at the end over √(g d)", default=nan, label="median speed over √(g d)")
    top: float = number("m", "highest edge of the discs at the end", default=nan)
    sinking: float = number("", "fall of the top over the last 20 √(d/g), in diameters", default=nan)
    reason: str | None = None
    history: RestHistory | None = field(default=None, metadata={"summary": False})


@dataclass(frozen=True)
class RestHistory:
    """Frames against time.

    Attributes
    ----------
    time : ndarray, shape (frames,), s
    speed : ndarray, shape (frames,), m/s
        Median speed of the discs; NaN in a frame without discs, and where no velocity is known.
    top : ndarray, shape (frames,), m
        Highest edge of the discs.
    begin : float
        Time from which the discs rest, s; NaN where they do not.
    """

    time: np.ndarray
    speed: np.ndarray
    top: np.ndarray
    begin: float


class RestDetector:
    """Fed with one frame after the other, says whether the discs rest.

    Parameters
    ----------
    gravity : float
        m/s^2.
    diameter : float
        m.
    begin : float
        Frames before this time (s) do not count: a gate is shut, or a wall has not moved yet.

    Attributes
    ----------
    since : float
        Time since which all holds, s; infinite where it does not.
    """

    def __init__(self, gravity: float, diameter: float, begin: float = -inf):
        self.slow, self.constant = SLOW * sqrt(gravity * diameter), CONSTANT * diameter
        self.span = SPAN * sqrt(diameter / gravity) if gravity > 0 else inf
        self.begin, self.since, self.frames = begin, inf, 0
        self._low = self._high = nan
        self._discs = (-1, -1)

    def feed(self, time: float, speed: float, top: float, discs: tuple[int, int]) -> bool:
        """Add a frame; True where the discs rest in it and have rested for the whole span.

        Parameters
        ----------
        time : float
            s.
        speed : float
            Median speed, m/s; NaN without discs.
        top : float
            Highest edge, m.
        discs : (int, int)
            Number and highest id.
        """
        if not speed < self.slow or time < self.begin:
            self.since, self.frames = inf, 0
            return False
        low, high = min(self._low, top), max(self._high, top)
        if self.frames and discs == self._discs and high - low <= self.constant:
            self.frames, self._low, self._high = self.frames + 1, low, high
        else:
            self.since, self.frames, self._discs = time, 1, discs
            self._low = self._high = top
        return self.frames >= FEWEST and time - self.since >= self.span * (1.0 - 1e-9)


def state_of(frame: Frame, flow: Flow) -> tuple[float, float, tuple[int, int]]:
    """Median speed (m/s), highest edge (m), number and highest id of the discs of a frame, for `RestDetector.feed`."""
    if not frame.n:
        return nan, nan, (0, 0)
    speeds = np.hypot(frame.vx, frame.vy)
    known = speeds[np.isfinite(speeds)]
    speed = float(np.median(known)) if known.size else nan
    return speed, float((frame.y + flow.radii(frame)).max()), (frame.n, int(frame.ids.max()))


def begin_of(scene: Scene) -> float:
    """Time from which on discs can come to rest, s: every gate is open, and walls have begun and ended their motion."""
    times = [0.0, *(scene.time(int(motion.gone)) for _, motion in scene.gates)]
    for _, motion in scene.walls:
        kind = motion.kind
        if kind is not None and not motion.is_state:
            ends = [corner.time for corner in kind.corners(0.0)]
            times += [kind.begin, *ends, *([kind.end] if isfinite(kind.end) else [])]
    return max(times)


class RestWatch:
    """Collects speed and top frame by frame."""

    def __init__(self, flow: Flow, _: ContactCollector | None = None):
        self.flow = flow
        self.detector = RestDetector(flow.g, flow.scene.diameter, begin_of(flow.scene))
        self._rows: list[tuple[float, float, float]] = []
        self._rests = False

    def add(self, frame: Frame, time: float) -> None:
        """Take in a frame at a time, s."""
        speed, top, discs = state_of(frame, self.flow)
        self._rests = self.detector.feed(time, speed, top, discs)
        self._rows.append((time, speed, top))

    def result(self) -> RestHistory:
        """The history of all frames."""
        rows = np.array(self._rows, float).reshape(-1, 3)
        time, speed, top = rows.T
        return RestHistory(time, speed, top, self.detector.since if self._rests else nan)


def analyse(gathered: Gathered) -> Rest:
    """Time at which the discs of a run came to rest; with a reason where they did not."""
    flow, history = gathered.flow, gathered.histories["rest"]
    assert isinstance(history, RestHistory)
    if flow.g <= 0 or not flow.timed or not flow.velocities:
        return Rest(reason="without gravity, times and velocities nothing says what rest is")
    there = np.isfinite(history.top)
    if not there.any():
        return Rest(reason="no frame holds a disc", history=history)
    if not there[-1]:
        return Rest(reason="no disc is left in the last frame", history=history)
    d = flow.scene.diameter
    time, speed, top = (values[there] for values in (history.time, history.speed, history.top))
    begin = time[-1] - SPAN * sqrt(d / flow.g)
    before = float(np.interp(begin, time, top, left=nan))
    slow = float(speed[-1] / sqrt(flow.g * d))
    if isnan(slow):
        return Rest(reason="the velocities of the discs of the last frame are not known", history=history)
    return Rest(
        history.begin,
        slow,
        float(top[-1]),
        float(before - top[-1]) / d,
        None if isfinite(history.begin) else _restless(slow, short=_is_short(history, flow)),
        history,
    )


def rests(history: RestHistory, flow: Flow) -> bool | None:
    """Tells whether the discs rest at the end, or move: their median speed is above 0.01 sqrt(g d).

    None where nothing says what rest is, and where discs are slower and have not rested for the whole stretch: what is
    slower than that does not move, and is not known to stay.
    """
    if isfinite(history.begin):
        return True
    if (
        flow.g <= 0
        or not flow.timed
        or not len(history.time)
        or not history.speed[-1] >= SLOW * sqrt(flow.g * flow.scene.diameter)
    ):
        return None
    return False


def _is_short(history: RestHistory, flow: Flow) -> bool:
    """Tells whether the record is too short to show rest."""
    counted = history.time[history.time >= begin_of(flow.scene)]
    stretch = SPAN * sqrt(flow.scene.diameter / flow.g) * (1.0 - 1e-9)
    return len(counted) < FEWEST or bool(counted[-1] - counted[0] < stretch)


def _restless(speed: float, *, short: bool) -> str:
    if speed >= SLOW:
        return f"the discs still move: their median speed is {speed:z.2g} √(g d), at rest it is below {SLOW:zg}"
    if short:
        return (
            f"the discs are slow, and the record is shorter than the {SPAN:zg} √(d/g) in which rest shows, or has "
            f"fewer than {FEWEST} frames"
        )
    return f"the discs are slow, yet they moved, or their top or number changed, within the last {SPAN:zg} √(d/g)"


def tables(rest: Rest) -> Tables:
    """Median speed (m/s) and highest edge (m) against time."""
    history = rest.history
    if history is None:
        return {}
    return {"rest.csv": {"time": history.time, "median_speed": history.speed, "top": history.top}}


def figures(rest: Rest, gathered: Gathered) -> Drawings:
    """Median speed and top against time."""
    history, flow = rest.history, gathered.flow
    if history is None or not np.isfinite(history.speed).any():
        return {}
    scale = sqrt(flow.g * flow.scene.diameter)
    marks = {"at rest": rest.time} if isfinite(rest.time) else {}
    with np.errstate(divide="ignore", invalid="ignore"):
        digits = np.log10(np.maximum(history.speed / scale, LOWEST))
    panels = (
        Panel("Median speed,\nlog₁₀ of v/√(g d)", [Trace("", history.time, digits)],
              levels={f"rest: {SLOW:zg}": float(np.log10(SLOW))}, marks=marks),
        Panel("Highest edge\nof the discs [m]", [Trace("", history.time, history.top)], marks=marks),
    )  # fmt: skip
    return {"rest": Chart("the discs come to rest", flow.time_axis, panels)}


def section(rest: Rest) -> Section:
    """Section on when the discs came to rest, or why they do not."""
    if not known(rest.speed):
        return Section("Rest", [])
    rows = described(rest, *(["time"] if known(rest.time) else []), "speed", "top", "sinking")
    return Section("Rest", [Text(rest.reason or "", "warn"), Table(rows)])


QUANTITY = Quantity(
    name="rest",
    title="Rest",
    result=Rest,
    definitions="""\
rest          from the first frame on after which, up to the end: median speed below 0.01 √(g d), highest edge within
              0.05 d, number of discs as it is; at least for 20 √(d/g), with all gates open
sinking       fall of the highest edge over the last 20 √(d/g)
""",
    collector=RestWatch,
    analyse=analyse,
    files={"rest.csv": "how fast the discs still move, against time"},
    captions={"rest": "The discs come to rest"},
    tables=tables,
    figures=figures,
    section=section,
    headline=(HeadlineNumber("time"),),
    rank=70,
)
