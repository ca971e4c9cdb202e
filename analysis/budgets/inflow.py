# SPDX-License-Identifier: GPL-2.0-or-later
"""Budget of the rows of inflow: what the case lets them carry, and what they delivered, counted by ids."""

# ruff: noqa: RUF001  (Greek letters, minus signs and dashes are meant for readers)
from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import hypot, inf, isfinite, nan
from typing import Any, NamedTuple

import numpy as np

from lammps_jump.analysis.flow import Flow
from lammps_jump.analysis.passes import Gathered
from lammps_jump.analysis.profiles import window_of, within
from lammps_jump.analysis.quantity import HeadlineNumber, Quantity
from lammps_jump.analysis.report.page import Section, Table, Text, Value, cells, cut
from lammps_jump.analysis.statistics import Mean, as_fields, mean_of, propagated
from lammps_jump.dump.frame import Frame
from lammps_jump.physics import jump as theory
from lammps_jump.units import Estimates, estimate, number

LARGEST_LOSS = 5e-3
"""Relative difference of delivered and requested discharge that is not remarked on."""
SHORT = 0.05
"""Share of the requested discharge that may be missing where discs pass a structure, besides twice its error."""
STATION = (1.0, 6.0)
"""Stretch downstream of the inlet over which the stream is averaged, in depths of the inflow."""
MOST_CELLS = 20_000_000
"""Discs times turns between two frames above which refused turns are not listed row by row."""


@dataclass(frozen=True)
class Arrivals:
    """Discs that came in between one frame and the next, and the stream downstream of the inlet at each frame.

    Attributes
    ----------
    time : ndarray, shape (frames,), s
    turns, entered : ndarray of int, shape (frames, rows)
        Turns of each row since the frame before, and discs that entered; -1 where the rows are unknown.
    discs : ndarray of int, shape (frames,)
        Discs that entered since the frame before, all rows together.
    area : ndarray, shape (frames, rows)
        Sum of their squared diameters, m^2.
    age : ndarray, shape (frames,)
        Sum of their squared diameters times their time in the flow at the frame, m^2 s.
    stream : ndarray, shape (frames, 3)
        Mass depth (m), discharge (m^2/s) and momentum flux over density (m^3/s^2) downstream of the inlet.
    pushed : ndarray, shape (frames, 2)
        Sum of the discs' squared diameters times their velocities at their entry, m^3/s.
    """

    time: np.ndarray
    turns: np.ndarray
    entered: np.ndarray
    discs: np.ndarray
    area: np.ndarray
    age: np.ndarray
    stream: np.ndarray
    pushed: np.ndarray


class InflowCounter:
    """Collects `Arrivals`, frame by frame.

    Ids are given in turn. Where as many discs are new as there were turns, each disc's row is known. Where fewer are,
    some turns were refused: discs and turns are matched in their order, so that the heights fit best.
    """

    def __init__(self, flow: Flow, contacts: object = None):
        self.flow, self.rows = flow, flow.scene.inlets
        self._highest, self._step = 0, 0
        self._kept: list[tuple[Any, ...]] = []

    def add(self, frame: Frame, time: float) -> None:
        """Take in a frame at a time, s."""
        highest, rows = int(frame.ids.max(initial=self._highest)), len(self.rows)
        if not self._kept:  # what was there before the first frame is not counted
            self._highest, self._step = highest, frame.step
        steps, turns, speeds = self._turns(frame.step)
        new = np.arange(self._highest + 1, highest + 1)
        taken = self._taken(new, turns, frame)
        known, counts = taken is not None, np.bincount(turns, minlength=rows)
        area = self.flow.scene.diameters(new) ** 2
        entered = np.bincount(turns[taken], minlength=rows) if known else np.full(rows, -1)
        by_row = np.bincount(turns[taken], area, rows) if known else area.sum() * counts / max(1, counts.sum())
        age = float(area @ (frame.step - steps[taken])) * self.flow.time_step if known else nan
        weights = area if known else np.full(len(turns), area.sum() / max(1, len(turns)))
        pushed = weights @ (speeds[taken] if known else speeds)
        self._kept.append((time, counts, entered, len(new), by_row, age, self._stream(frame), pushed))
        self._highest, self._step = highest, frame.step

    def _turns(self, step: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Steps and rows (turns,) and velocities (turns, 2) of the turns after the frame before, in order."""
        until = [[row.turns_until(s) for s in (self._step, step)] for row in self.rows]
        turns = sorted((turn, k) for k, (before, now) in enumerate(until) for turn in now[len(before) :])
        speeds = [(self.rows[k].speed_at(turn), self.rows[k].vy) for turn, k in turns]
        steps, rows = np.array(turns, int).reshape(-1, 2).T
        return steps, rows, np.array(speeds, float).reshape(-1, 2)

    def _taken(self, new: np.ndarray, turns: np.ndarray, frame: Frame) -> np.ndarray | None:
        """Turn at which each new disc entered, shape (discs,); None where that would be guessing."""
        if len(new) == len(turns):
            return np.arange(len(turns))
        if len(new) > len(turns) or len(new) * len(turns) > MOST_CELLS:
            return None
        heights = np.full(len(new), nan)
        here = np.flatnonzero(frame.ids >= self._highest + 1)
        heights[frame.ids[here] - self._highest - 1] = frame.y[here]
        return in_order(heights, np.array([row.y for row in self.rows])[turns])

    def _stream(self, frame: Frame) -> np.ndarray:
        """Depth, discharge and momentum flux downstream of the inlet, shape (3,).

        Each disc counts with the weight 1 - cos(2 pi s) over the stretch, s from 0 to 1: equally spaced discs then give
        their mean at every frame, where sharp ends would count one more or one less.
        """
        inlet, towards = self.rows[0].x, np.sign(self.rows[0].vx)
        begin, end = (share * _reach(self.flow) for share in STATION)
        place = (towards * (frame.x - inlet) - begin) / (end - begin)
        weight = np.where((place > 0) & (place < 1), 1.0 - np.cos(2 * np.pi * place), 0.0)
        mass = self.flow.by_mass(weight, frame) * self.flow.scene.diameter**2 / (end - begin)
        known = np.isfinite(frame.vx)
        part = mass[known] * (mass.sum() / mass[known].sum() if mass[known].any() else nan if mass.any() else 0.0)
        return np.array([mass.sum(), part @ frame.vx[known], part @ frame.vx[known] ** 2])

    def result(self) -> Arrivals:
        """The history of all frames taken in."""
        return Arrivals(*(np.array(column) for column in zip(*self._kept, strict=True)))


def _reach(flow: Flow) -> float:
    """Depth of the inflow that `STATION` counts in, m: the largest where it changes with time."""
    graph = flow.scene.hydrograph
    return max(graph.depths) if graph else flow.inflow_depth or nan


def in_order(heights: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Places of `wanted` that fit `heights` best, in rising order.

    Parameters
    ----------
    heights : ndarray, shape (n,), m
        NaN fits everywhere.
    wanted : ndarray, shape (m,), m >= n

    Returns
    -------
    ndarray of int, shape (n,)
        With the least sum of absolute differences.
    """
    best, taken = np.zeros(len(wanted) + 1), []
    for height in heights:
        cost = best[:-1] + np.nan_to_num(np.abs(wanted - height))
        best = np.minimum.accumulate(np.append(np.inf, cost))
        taken.append(cost <= best[:-1])  # better than every place before it
    places, end = [], len(wanted)
    for better in reversed(taken):
        end = int(np.flatnonzero(better[:end])[-1])
        places.append(end)
    return np.array(places[::-1], int)


@dataclass(frozen=True)
class RowDelivery:
    """One row of the inflow."""

    y: float = number("m", "height of the row")
    speed: float = number("m/s", "speed of its discs")
    interval: float = number("s", "time between turns")
    asked: float = number("m^2/s", "discharge in whole steps")
    delivered: float = number("m^2/s", "discharge delivered in the window", default=nan)
    turns: int = number("", "turns in the whole record", default=0)
    refused: int | None = number("", "turns refused: the place was occupied", default=None)


@dataclass(frozen=True)
class Delivery(Estimates):
    """Inflow as requested and as delivered; means are over the window, counts over the whole record."""

    asked: float = number("m^2/s", "discharge asked for, Va y₁", label="asked")
    planned: float = number("m^2/s", "discharge of the rows, in whole steps")
    delivered: float = number("m^2/s", "discharge delivered, discs counted", default=nan, label="delivered")
    deviation: float = number("", "delivered over asked, less one", default=nan)
    turns: int = number("", "turns of all rows", default=0)
    refused: int = number("", "turns refused: the place was occupied", default=0, label="refused discs")
    depth_asked: float = number("m", "mass depth asked for", default=nan)
    speed_asked: float = number("m/s", "mean speed asked for", default=nan)
    momentum_planned: float = number("m^3/s^2", "momentum flux of the rows over density", default=nan)
    depth: float = estimate("m", "mass depth behind the inlet")
    speed: float = estimate("m/s", "mean speed behind the inlet")
    momentum: float = estimate("m^3/s^2", "momentum flux behind the inlet over density")
    froude: float = estimate("", "Froude number of the delivered stream")
    belanger_y2: float = estimate("m", "sequent depth of the delivered stream, Bélanger")
    station: tuple[float, float] = (nan, nan)
    rows: tuple[RowDelivery, ...] = ()
    notes: tuple[str, ...] = ()


def analyse(gathered: Gathered) -> Delivery | None:
    """Inflow of a run; None without rows."""
    arrivals = gathered.histories.get("inflow")
    if not isinstance(arrivals, Arrivals):
        return None
    return deliver(arrivals, gathered.flow, window_of(gathered.profiles))


def deliver(arrivals: Arrivals, flow: Flow, window: tuple[float, float]) -> Delivery:
    """Numbers of the inflow from what came in; means over a window, s.

    The discharge of a row is the area of its discs over the time of its turns: whole turns, so that no disc is cut off
    at the ends of the window. Against time it is their area over the time between the first and the last frame of the
    window, and what the case asks for is the mean of the table over that time.
    """
    scene, rows = flow.scene, flow.scene.inlets
    inside = within(arrivals.time, window)
    later = inside & (np.cumsum(inside) > 1)  # what came before the window's first frame belongs to the time before
    tries = arrivals.turns[later].sum(axis=0)
    plan = _plan(flow, arrivals.time[inside], tries)
    with np.errstate(invalid="ignore", divide="ignore"):
        delivered = arrivals.area[later].sum(axis=0) / (tries * plan.intervals)
    if scene.hydrograph and later.any():
        delivered[tries == 0] = 0.0  # a row rests while the depth is low
    turns = arrivals.turns.sum(axis=0)
    tried = int(turns.sum())
    lost = tried - int(arrivals.discs.sum())
    is_known = not (arrivals.entered < 0).any()
    refused = turns - arrivals.entered.sum(axis=0)
    depth, discharge, momentum = (mean_of(series) for series in arrivals.stream[inside].T)
    with np.errstate(invalid="ignore", divide="ignore"):
        scatter = mean_of(arrivals.stream[inside, 1] / arrivals.stream[inside, 0]).error
    speed = Mean(discharge.value / depth.value if depth.value > 0 else nan, scatter)
    y1, va = plan.depth, plan.speed
    asked, total, across = y1 * abs(va), float(delivered.sum()), flow.gravity
    of_rows = zip(rows, plan.speeds, plan.intervals, plan.discharges, delivered, turns, refused, strict=True)
    deliveries = [
        RowDelivery(row.y, float(v), float(t), float(q), float(got), int(n), int(no) if is_known else None)
        for row, v, t, q, got, n, no in of_rows
    ]
    low, high = sorted(float(rows[0].x + np.sign(rows[0].vx) * share * _reach(flow)) for share in STATION)
    seconds = float(np.ptp(arrivals.time[inside])) if scene.hydrograph and inside.any() else 0.0
    whole = len(rows) * scene.mean_square / seconds if seconds else 0.0  # a disc of each row in the window
    return Delivery(
        asked=asked,
        planned=float(plan.discharges.sum()),
        delivered=total,
        deviation=total / asked - 1.0 if asked else nan,
        turns=tried,
        refused=lost,
        depth_asked=y1,
        speed_asked=va,
        momentum_planned=float(plan.discharges @ np.abs(plan.speeds)),
        **as_fields(depth=depth, speed=speed, momentum=momentum, **_sequent(depth, speed, across)),
        station=(low, high),
        rows=tuple(deliveries),
        notes=() if abs(total - asked) < whole else _notes(total, asked, lost, tried, _blocked(arrivals)),
    )


class _Plan(NamedTuple):
    """Plan of the case: mean depth (m) and speed (m/s); of each row time between turns, speed, discharge."""

    depth: float
    speed: float
    intervals: np.ndarray
    speeds: np.ndarray
    discharges: np.ndarray


def _plan(flow: Flow, time: np.ndarray, tries: np.ndarray) -> _Plan:
    """Plan of the case in a window whose frames have these times (s), with the turns of its rows in it."""
    scene, rows = flow.scene, flow.scene.inlets
    graph = scene.hydrograph
    if graph is None or len(time) < 2:
        intervals = np.array([row.every_steps * scene.time_step for row in rows])
        y1, va = flow.inflow_depth or nan, flow.inflow_speed or nan
        return _Plan(y1, va, intervals, np.array([row.vx for row in rows]), np.array(scene.discharges))
    first, last = float(time[0]), float(time[-1])
    steps = [scene.settle_steps + round(t / scene.time_step) for t in (first, last)]
    speeds = [row.speeds[len(row.turns_until(steps[0])) : len(row.turns_until(steps[1]))] for row in rows]
    means = np.array([np.mean(some) if some else row.vx for row, some in zip(rows, speeds, strict=True)])
    depth, discharge = graph.means(first, last)
    intervals = (last - first) / np.where(tries > 0, tries, nan)
    speed = discharge / depth if depth else float(graph.speed(last))
    return _Plan(depth, speed, intervals, means, scene.mean_square * tries / (last - first))


def _sequent(depth: Mean, speed: Mean, gravity: float) -> dict[str, Mean]:
    """Froude number and Bélanger's depth in the laboratory, with their errors."""
    if not (depth.value > 0 and gravity > 0):
        return {}
    made = {"froude": theory.froude, "belanger_y2": theory.sequent_depth}
    return {name: propagated(lambda s, u, f=f: f(abs(u), s, gravity), depth, speed) for name, f in made.items()}


def _blocked(arrivals: Arrivals) -> str:
    """Since when no disc has entered, where all turns of the last two frames or more were refused."""
    last = int(np.flatnonzero(arrivals.discs > 0)[-1]) if arrivals.discs.any() else 0
    blocked = (arrivals.turns[last + 1 :].sum(axis=1) > 0).sum() > 1
    return f"; no disc has entered since t = {arrivals.time[last]:z.4g} s" if blocked else ""


def _notes(delivered: float, asked: float, refused: int, turns: int, blocked: str) -> tuple[str, ...]:
    if not isfinite(delivered) or not asked or abs(delivered / asked - 1.0) <= LARGEST_LOSS:
        return ()
    cause = "no turn was refused: the rows carry no more in whole steps"
    if refused:
        cause = (
            f"{refused} of {turns} turns were refused, because the place at the inlet was occupied: the rows stand too "
            "close (inflow.spacing, schedule: thesis), or the flow backs up to the inlet"
        )
    return (
        f"the inflow delivered {delivered:z.4g} m2/s of the {asked:z.4g} m2/s asked for "
        f"({100 * (delivered / asked - 1):+z.1f} %); {cause}{blocked}",
    )


def shortfall(summaries: Sequence[Mapping[str, Any]]) -> str:
    """A sentence that counts the runs with less discharge than requested, at the inlet or past a structure.

    It is empty where no run is short.

    Parameters
    ----------
    summaries : sequence of mapping
        ``inflow`` and ``overtopping`` as in ``summary.json``; each may be absent.
    """
    short = [lack for summary in summaries if (lack := _shortfall_of(summary))]
    if not short:
        return ""
    target, came, _ = zip(*short, strict=True)
    passed: dict[str, list[float]] = {}
    for one in short:
        for name, rate in one.passed.items():
            passed.setdefault(name, []).append(rate)
    runs = f" in {len(short)} of {len(summaries)} runs" if len(summaries) > 1 else ""
    went = "".join(f", {_span(rates)} passed {name}" for name, rates in passed.items())
    why = ". What did not pass is still before it or left elsewhere: run longer, with a later analysis.window"
    return (
        f"the inflow fell short{runs}: {_span(target)} m²/s asked for, {_span(came)} came in{went}{why if went else ''}"
    )


def line(summary: Mapping[str, Any]) -> str:
    """Sentence on a structure that less passed than came in; what did not come in is among the notes."""
    found = _shortfall_of(summary)
    return shortfall([summary]) if found and found.passed else ""


class _Shortfall(NamedTuple):
    """Discharge that was requested and that came in, and of structures that less passed what passed, m^2/s."""

    asked: float
    came: float
    passed: dict[str, float]


def _shortfall_of(summary: Mapping[str, Any]) -> _Shortfall | None:
    """That of one run; None where it is not short, or where nothing is known of its inflow."""
    inflow = summary.get("inflow") or {}
    requested, came = inflow.get("asked"), inflow.get("delivered")
    if not requested or came is None:
        return None
    through = {name: _through(one) for name, one in (summary.get("overtopping") or {}).items()}
    passed = {
        name: rate for name, (rate, error) in through.items() if rate + max(SHORT * requested, 2 * error) < requested
    }
    return _Shortfall(requested, came, passed) if passed or came < (1 - LARGEST_LOSS) * requested else None


def _through(one: Mapping[str, Any]) -> tuple[float, float]:
    """Discharge over and below a structure and its error, m^2/s; infinite where it is not known."""
    rates = [(one.get(key), one.get(f"{key}_error") or 0.0) for key in ("discharge", "below")]
    known = [(rate, error) for rate, error in rates if rate is not None]
    return (sum(rate for rate, _ in known), hypot(*(error for _, error in known))) if known else (inf, 0.0)


def _span(values: Sequence[float]) -> str:
    """The least and the largest of some numbers."""
    ends = dict.fromkeys(f"{end:z.3g}" for end in (min(values), max(values)))
    return " to ".join(ends)


def section(delivery: Delivery) -> Section:
    """Discharge requested and delivered, row by row; the stream downstream of the inlet."""
    stream: list[Sequence[Value]] = [
        ("Discharge [m²/s]", *cells(delivery, "asked", "delivered")),
        ("Mass depth [m]", *cells(delivery, "depth_asked"), cut(delivery, "depth")),
        ("Mean speed [m/s]", *cells(delivery, "speed_asked"), cut(delivery, "speed")),
        ("Momentum flux over ρ [m³/s²]", *cells(delivery, "momentum_planned"), cut(delivery, "momentum")),
        ("Froude number, laboratory", None, cut(delivery, "froude")),
        ("Discs refused", 0, f"{delivery.refused} of {delivery.turns}"),
    ]
    keys = ("y", "speed", "interval", "asked", "delivered", "turns", "refused")
    heads = ("Row at y [m]", "speed [m/s]", "every [s]", "asked [m²/s]", "delivered [m²/s]", "turns", "refused")
    low, high = delivery.station
    return Section(
        "Inflow",
        [
            Table(stream, ("", "asked for", "delivered")),
            Table([cells(row, *keys) for row in delivery.rows], heads, "Rows of the inlet"),
            Text(
                "The discharge is the area of the discs that entered, over whole turns of their rows (over the window "
                "where the inflow changes with time): a count, which has no error. Depth, speed and momentum are means "
                "over the window between "
                f"x = {low:z.3g} and {high:z.3g} m."
            ),
        ],
    )


QUANTITY = Quantity(
    name="inflow",
    title="Inflow",
    result=Delivery,
    definitions="""\
asked       Va y₁, or the mean of the inflow's table over the window; in whole steps: what the rows carry where no disc
            is refused
delivered   area of the discs that entered in the window over the time of their turns; discs are counted by their ids
refused     turns of the whole record at which the place of the disc was occupied
depth, speed, momentum   means of the window from one to six depths behind the inlet, weight 1 − cos 2πs
Froude      u/√(g s) of these, and Bélanger's depth of this stream, in the laboratory
""",
    always=lambda flow: bool(flow.scene.inlets),
    collector=InflowCounter,
    analyse=analyse,
    section=section,
    line=line,
    notes=lambda found: found.notes,
    headline=(
        HeadlineNumber("delivered", "asked", "asked", holds="of an inlet that nothing holds up"),
        HeadlineNumber("froude"),
    ),
    rank=130,
    errors=lambda found: [("", found)],
)
