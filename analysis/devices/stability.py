# SPDX-License-Identifier: GPL-2.0-or-later
"""Stability of structures: limits of sliding and tipping against time, and factors of safety.

A body that rests on something is looked at by what ``bodies.csv`` has of it, a wall that is given a weight by its
force record. Forces are those of the discs. A body that another body touches has no factor, as no record has that
force.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import hypot, inf, isfinite, nan
from typing import Any, NamedTuple

import numpy as np

from lammps_jump.analysis.draw.chart import TIME, Chart, Drawings, Panel, Trace
from lammps_jump.analysis.flow import Flow
from lammps_jump.analysis.forces.history import moving_mean
from lammps_jump.analysis.forces.impulse import window_lengths
from lammps_jump.analysis.passes import Gathered, Tables
from lammps_jump.analysis.profiles import window_of
from lammps_jump.analysis.quantity import HeadlineNumber, Named, Quantity
from lammps_jump.analysis.report.page import Section, Table, Text, described
from lammps_jump.analysis.verdicts.kinds import part
from lammps_jump.dump.find import ForceHistory
from lammps_jump.dump.walls import BodyHistory, read_bodies
from lammps_jump.errors import DumpError
from lammps_jump.files import BODIES
from lammps_jump.physics.bodies import (
    along_and_up,
    bearing_pressures,
    eccentricity,
    factor,
    moment_about,
    section_of_polygon,
    sliding_limit,
)
from lammps_jump.scene.bodies import Free
from lammps_jump.scene.motion import MovingWall, reference
from lammps_jump.scene.scene import WallWeight
from lammps_jump.scene.schedule import windows_of
from lammps_jump.units import as_summary, from_summary, known, number

from .bodies import BodyResult
from .bodies import analyse as how_bodies_are
from .standing import FLAT, IN_THE_AIR, base_at, placed, standing_of

KILO = 1e3
MOST_POSES = 200
"""Poses at which it is looked whether bodies touch each other."""
BACK = 0.2
"""Share of the limit from which on a force towards the left has its limit drawn."""
NEAR = 0.25
"""Smallest diameters from a body below which another one touches it."""


@dataclass(frozen=True)
class Stability:
    """Stability of one structure; factors of safety are what is borne over what drives.

    `toe` is the end of the base about which the least factor of tipping is, and moments are about it. `state` is that
    of a body at the end. `reason` says why numbers are absent. `table` holds the columns of ``stability.csv``.
    """

    weight: float = number("N/m", "weight per metre of width", default=nan)
    base: float = number("m", "width of its base", default=nan)
    friction: float = number("", "friction of its base", default=nan)
    sliding_factor_least: float = number("", "least factor against sliding", default=nan)
    sliding_factor_least_at: float = number("s", "time of the least factor against sliding", default=nan)
    sliding_factor_least_mean: float = number("", "least factor against sliding of the moving mean", default=nan)
    sliding_factor_time_below_1: float = number("s", "time below 1 of the factor against sliding", default=nan)
    tipping_factor_least: float = number("", "least factor against tipping", default=nan)
    tipping_factor_least_at: float = number("s", "time of the least factor against tipping", default=nan)
    tipping_factor_least_mean: float = number("", "least factor against tipping of the moving mean", default=nan)
    tipping_factor_time_below_1: float = number("s", "time below 1 of the factor against tipping", default=nan)
    sliding_factor: float = number(
        "", "factor against sliding of the mean forces of the analysis window, which holds no peak", default=nan
    )
    tipping_factor: float = number(
        "", "factor against tipping of the mean forces of the analysis window, which holds no peak", default=nan
    )
    window_time: float = number("s", "time of a window of the record, over which single forces are means", default=nan)
    mean_time: float = number("s", "time of the moving mean", default=nan)
    toe: str | None = None
    driving_force_peak: float = number("N/m", "largest force along its base, either way", default=nan)
    moment_about_toe_peak: float = number("N m/m", "largest moment of the discs over that toe", default=nan)
    weight_about_toe: float = number("N m/m", "moment of its weight about that toe, where it stood", default=nan)
    uplift_peak: float = number("N/m", "largest lift of the discs off its base", default=nan)
    eccentricity_peak: float = number(
        "m", "largest eccentricity of the moving mean of the force on its base", default=nan
    )
    toe_pressure_peak: float = number(
        "Pa", "largest pressure below an end of its base, of the moving mean", default=nan
    )
    heel_pressure_least: float = number("Pa", "least pressure below the other end", default=nan)
    state: str | None = None
    slid_by: float = number("m", "way of the middle of its base along it, towards larger x", default=nan)
    reason: str | None = None
    table: Mapping[str, np.ndarray] = field(default_factory=dict, metadata={"summary": False})


class Loads(NamedTuple):
    """Loads on a structure that stands, a row a window of the record.

    Attributes
    ----------
    time, lengths : ndarray, shape (n,), s
        Ends of the windows, and their lengths.
    force : ndarray, shape (n, 2), N/m
        Of the discs.
    moment : ndarray, shape (n,), N m/m
        Of the discs about `point`.
    point, centre, left, right : ndarray, shape (n, 2), m
        Point of the moment, centre of mass, ends of the base.
    along : ndarray, shape (2,)
        Unit vector along what it stands on, from left to right. A body that rocks has it from its release on.
    weight : ndarray, shape (2,), N/m
    friction : float
    stands : ndarray of bool, shape (n,)
        Whether it stands on its base.
    """

    time: np.ndarray
    lengths: np.ndarray
    force: np.ndarray
    moment: np.ndarray
    point: np.ndarray
    centre: np.ndarray
    left: np.ndarray
    right: np.ndarray
    along: np.ndarray
    weight: np.ndarray
    friction: float
    stands: np.ndarray

    @property
    def rubs(self) -> bool:
        """Tells whether friction is known."""
        return isfinite(self.friction)

    @property
    def base(self) -> float:
        """Width of the base, m."""
        return float(hypot(*(self.right[0] - self.left[0])))


class BaseSums(NamedTuple):
    """Forces and moments that decide, at each row, N/m and N m/m.

    Attributes
    ----------
    driving : ndarray
        Along the base, towards its right end.
    pressed, uplift : ndarray
        Down on the base; of the discs off it.
    over_right, over_left, holds_right, holds_left : ndarray
        Moments of the discs over each toe, and of the weight against them.
    middle : ndarray
        Moment of all about the middle of the base, anticlockwise.
    """

    driving: np.ndarray
    pressed: np.ndarray
    uplift: np.ndarray
    over_right: np.ndarray
    over_left: np.ndarray
    holds_right: np.ndarray
    holds_left: np.ndarray
    middle: np.ndarray

    def mean(self, samples: int) -> BaseSums:
        """Moving means over so many rows."""
        return BaseSums(*(moving_mean(values, samples) for values in self))

    def of(self, rows: np.ndarray) -> BaseSums:
        """Their means over some rows, shape (1,)."""
        return BaseSums(*(np.atleast_1d(values[rows].mean()) for values in self))

    def sliding(self, friction: float) -> np.ndarray:
        """Factor of safety against sliding."""
        return factor(sliding_limit(friction, self.pressed), np.abs(self.driving))

    def tipping(self, side: str) -> np.ndarray:
        """Factor of safety against tipping over a toe; 0 where the weight itself tips it."""
        over, holds = getattr(self, f"over_{side}"), getattr(self, f"holds_{side}")
        return np.where(holds > 0, factor(holds, over), np.where(np.isnan(holds), nan, 0.0))


def sums_of(loads: Loads) -> BaseSums:
    """Forces along and across the base, and moments about both its ends."""
    weight = np.broadcast_to(loads.weight, loads.force.shape)
    along = np.broadcast_to(loads.along, loads.force.shape)
    driving, up = along_and_up(loads.force + weight, along)
    uplift = along_and_up(loads.force, along)[1]
    none = np.zeros(len(loads.time))
    of_discs = {
        side: moment_about(loads.moment, loads.point - end, loads.force)
        for side, end in (("left", loads.left), ("right", loads.right))
    }
    of_weight = {
        side: moment_about(none, loads.centre - end, weight)
        for side, end in (("left", loads.left), ("right", loads.right))
    }
    middle = 0.5 * (loads.left + loads.right)
    about = moment_about(loads.moment, loads.point - middle, loads.force)
    about = about + moment_about(none, loads.centre - middle, weight)
    return BaseSums(
        driving, -up, uplift, -of_discs["right"], of_discs["left"], of_weight["right"], -of_weight["left"], about
    )


def found_of(loads: Loads, window: tuple[float, float], mean_time: float) -> Stability:
    """Limits and factors of one structure; least values and times are of the rows at which it stands.

    Parameters
    ----------
    loads : Loads
    window : (float, float)
        Of the means, s.
    mean_time : float
        Of the moving mean, s.
    """
    sums, stands = sums_of(loads), loads.stands
    samples = windows_of(mean_time, float(np.median(loads.lengths)))
    smooth, whole = sums.mean(samples), moving_mean(stands.astype(float), samples) > 1.0 - 1e-9
    single, means = _factors(sums, loads.friction, stands), _factors(smooth, loads.friction, whole)
    toe = min(("right", "left"), key=lambda side: np.nanmin(single[side], initial=inf))
    off = np.where(whole, eccentricity(smooth.middle, smooth.pressed), nan)
    below = bearing_pressures(smooth.pressed, off, loads.base)
    steady, lasts = _of_window(loads, sums, window)
    numbers = {**_numbers("sliding_factor", single["sliding"], means["sliding"], loads)} if loads.rubs else {}
    numbers |= _numbers("tipping_factor", single["tipping"], means["tipping"], loads)
    driven = any(isfinite(numbers.get(f"{kind}_factor_least", nan)) for kind in ("sliding", "tipping"))
    inside = bool(np.isfinite(below[0][whole]).all())
    told_why = ((NO_FRICTION, loads.rubs), (UNPUSHED, driven), (NO_WINDOW, lasts), (BESIDE, inside))
    return Stability(
        weight=hypot(*loads.weight), base=loads.base, friction=loads.friction, **numbers, **steady,
        window_time=float(np.median(loads.lengths)), mean_time=samples * float(np.median(loads.lengths)),
        toe=toe if isfinite(numbers["tipping_factor_least"]) else None,
        driving_force_peak=_most(np.where(stands, np.abs(sums.driving), nan), least=0.0),
        moment_about_toe_peak=_most(np.where(stands, getattr(sums, f"over_{toe}"), nan), least=0.0),
        weight_about_toe=float(getattr(sums, f"holds_{toe}")[0]),
        uplift_peak=_most(np.where(stands, sums.uplift, nan), least=0.0), eccentricity_peak=_most(np.abs(off)),
        toe_pressure_peak=_most(below[0]) if inside else nan,
        heel_pressure_least=-_most(-below[1]) if inside else nan,
        reason="; ".join(why for why, known in told_why if not known) or None,
        table=_table(loads, sums, single, below, (smooth.driving, getattr(smooth, f"over_{toe}"))),
    )  # fmt: skip


def _factors(sums: BaseSums, friction: float, rows: np.ndarray) -> dict[str, np.ndarray]:
    """Factors against sliding, tipping over each toe and over the nearer one, at some rows; else NaN."""
    factors = {"sliding": sums.sliding(friction), "right": sums.tipping("right"), "left": sums.tipping("left")}
    factors["tipping"] = np.fmin(factors["right"], factors["left"])
    return {name: np.where(rows, values, nan) for name, values in factors.items()}


def _of_window(loads: Loads, sums: BaseSums, window: tuple[float, float]) -> tuple[dict[str, Any], bool]:
    """Factors of the mean forces of the window, where they are finite; whether it stands all through it."""
    inside = (loads.time > window[0]) & (loads.time <= window[1] + 1e-9)
    if not inside.any() or not loads.stands[inside].all():
        return {}, False
    factors = _factors(sums.of(inside), loads.friction, np.array([True]))
    factor_values = {f"{kind}_factor": float(factors[kind][0]) for kind in ("sliding", "tipping")}
    return {name: value for name, value in factor_values.items() if isfinite(value)}, True


NO_FRICTION = "nothing rubs in this case, so that nothing bounds sliding"
UNPUSHED = "nothing pushes it"
NO_WINDOW = "it does not stand through the window of the means"
BESIDE = "the force of a moving mean leaves the base, so that no pressure below it balances it"


def _numbers(name: str, values: np.ndarray, means: np.ndarray, loads: Loads) -> dict[str, Any]:
    """Least factor over time and over moving means, and the time below 1 while the structure stands."""
    least, mean = (float(np.nanmin(one, initial=np.inf)) for one in (values, means))
    at = float(loads.time[int(np.nanargmin(values))]) if isfinite(least) else nan
    return {
        f"{name}_least": least if isfinite(least) else nan, f"{name}_least_at": at,
        f"{name}_least_mean": mean if isfinite(mean) else nan,
        f"{name}_time_below_1": float(loads.lengths[values < 1.0].sum()) if loads.stands.any() else nan,
    }  # fmt: skip


def _most(values: np.ndarray, least: float = nan) -> float:
    """Largest value; NaN where none is known, or above `least`."""
    good = values[np.isfinite(values)]
    most = float(good.max()) if good.size else nan
    return nan if most <= least else most


def _table(
    loads: Loads,
    sums: BaseSums,
    factors: Mapping[str, np.ndarray],
    below: Sequence[np.ndarray],
    means: Sequence[np.ndarray],
) -> dict[str, np.ndarray]:
    """Columns of ``stability.csv``; NaN where the structure does not stand."""
    sliding, tipping = (np.where(np.isinf(factors[name]), nan, factors[name]) for name in ("sliding", "tipping"))
    columns = {
        "driving_force": sums.driving, "sliding_limit": sliding_limit(loads.friction, sums.pressed),
        "uplift": sums.uplift, "moment_over_right_toe": sums.over_right, "moment_over_left_toe": sums.over_left,
        "weight_about_right_toe": sums.holds_right, "weight_about_left_toe": sums.holds_left,
        "sliding_factor": sliding, "tipping_factor": tipping, "toe_pressure": below[0], "heel_pressure": below[1],
        "driving_mean": means[0], "moment_mean": means[1],
    }  # fmt: skip
    return {"time": loads.time} | {name: np.where(loads.stands, values, nan) for name, values in columns.items()}


# --- which structures, and what acts on them --------------------------------------------------------------------------


def analyse(gathered: Gathered) -> dict[str, Stability] | None:
    """Stability of each body that stands on something, and of each wall with a weight; None without any."""
    flow = gathered.flow
    if not flow.scene.bodies and not flow.scene.stability:
        return None
    window, mean_time = window_of(gathered.profiles), flow.scene.stability_mean
    stabilities: dict[str, Stability] = {}
    if flow.scene.bodies:
        states, (histories, why) = how_bodies_are(gathered) or {}, _histories(flow)
        for one in flow.scene.bodies:
            name = one.wall.name
            loads = body_loads(flow, one, histories) if name in histories else (None, why)
            state = states.get(name, BodyResult())
            stabilities[name] = replace(_stability(*loads, window, mean_time), state=state.state, slid_by=state.slid_by)
    for name, weighed in flow.scene.stability:
        record = gathered.forces.get(name)
        loads = wall_loads(flow, name, weighed, record) if record else (None, NO_RECORD)
        stabilities[name] = _stability(*loads, window, mean_time)
    return stabilities


NO_RECORD = "forces.csv has no row of it"


def _stability(loads: Loads | None, why: str, window: tuple[float, float], mean_time: float) -> Stability:
    """Stability by loads; with the reason why there is none, or why numbers are absent."""
    if loads is None:
        return Stability(reason=why)
    stability = found_of(loads, window, mean_time)
    return replace(stability, reason="; ".join(filter(None, (why, stability.reason))) or None)


def _histories(flow: Flow) -> tuple[dict[str, BodyHistory], str]:
    """Bodies against time, and why one may be missing."""
    try:
        return read_bodies(flow.poses.path.with_name(BODIES)) if flow.poses else {}, f"{BODIES} has no row of it"
    except DumpError as error:
        return {}, str(error)


def body_loads(flow: Flow, one: MovingWall, histories: Mapping[str, BodyHistory]) -> tuple[Loads | None, str]:
    """Loads on a body from its release on; and why it has no factors, or only up to some time."""
    kind, history = one.motion.kind, histories[one.wall.name]
    assert isinstance(kind, Free)
    standing = standing_of(flow, one, history)
    if standing.state == "left":
        history = BodyHistory(*(column[history.time < standing.since] for column in history))
        if len(history.time) < 2:
            return None, "it has left"
        standing = standing_of(flow, one, history)
    if standing.reason not in (None, IN_THE_AIR):
        return None, standing.reason or ""
    start = max(int(np.searchsorted(history.time, kind.begin, side="right")) - 1, 0)
    base = base_at(one, np.array(flow.scene.gravity), float(history.angle[start]))
    assert base is not None  # else it would not stand
    ends = np.stack([placed(end, kind, history) for end in (base.first, base.last)], axis=1)
    below = wall_below(flow, ends[start])
    if below is None:
        return None, "no wall is below it"
    touched, since = other_body(flow, one, histories)
    if since <= history.time[start]:
        return None, f"the body {touched} touches it, and no record has what bodies hand on"
    rows = slice(start + 1, None)
    is_flat = np.abs(history.angle[rows] - history.angle[start]) <= FLAT
    is_flat &= history.time[rows] < min(since, standing.falls_at if isfinite(standing.falls_at) else inf)
    if not is_flat.any():
        return None, "it never stands on its base"
    centre = np.column_stack([history.x, history.y])[rows]
    loads = Loads(
        history.time[rows], window_lengths(history.time)[rows], np.column_stack([history.fx, history.fy])[rows],
        history.moment[rows], centre, centre, ends[rows, 0], ends[rows, 1],
        (ends[start, 1] - ends[start, 0]) / base.length, np.array(kind.weight),
        friction_between(flow, one, below), is_flat,
    )  # fmt: skip
    said = f"from {since:z.2f} s on the body {touched} touches it, and no record has what bodies hand on"
    return loads, said if isfinite(since) else ""


def wall_loads(flow: Flow, name: str, weighed: WallWeight, record: ForceHistory) -> tuple[Loads | None, str]:
    """Loads on a wall at rest that is given a weight; and why it has no factors."""
    one = next(one for one in flow.scene.walls if one.wall.name == name)
    base = base_at(one, np.array(flow.scene.gravity), 0.0) if flow.g else None
    if base is None:
        return None, "it has no base to stand on" if flow.g else "there is no gravity"
    section = section_of_polygon(outline_of(one))
    live = record.time > 0 if (record.time > 0).any() else np.ones(len(record.time), bool)
    live &= record.time <= (flow.scene.time(one.motion.gone) if isfinite(one.motion.gone) else inf)
    if not live.any():
        return None, NO_RECORD
    count = int(live.sum())
    point, centre, left, right = (
        np.tile(place, (count, 1)) for place in (reference(one), section.centre, base.first, base.last)
    )
    loads = Loads(
        record.time[live], window_lengths(record.time)[live], np.column_stack([record.fx, record.fy])[live],
        record.moment[live], point, centre, left, right, (base.last - base.first) / base.length,
        weighed.density * section.area * np.array(flow.scene.gravity), weighed.friction, np.ones(count, bool),
    )  # fmt: skip
    return loads, ""


def wall_below(flow: Flow, ends: np.ndarray) -> MovingWall | None:
    """The wall that a base stands on, its ends at some places (m), shape (2, 2); None where it stands on none."""
    points = ends[0] + np.linspace(0.0, 1.0, 9)[:, None] * (ends[1] - ends[0])
    walls = [one for one in flow.scene.walls if one.motion.free is None]
    away = [float(np.abs(one.wall.distance(*points.T)).min()) for one in walls]
    nearest = int(np.argmin(away)) if walls else 0
    return walls[nearest] if walls and away[nearest] <= NEAR * flow.scene.smallest else None


def friction_between(flow: Flow, one: MovingWall, two: MovingWall) -> float:
    """Coefficient of friction of a body and the wall below it; NaN where nothing rubs.

    Of two that have their own the smaller one counts, as in their contact.
    """
    if not flow.scene.rubs:
        return nan
    own = [friction for wall, _ in (one, two) if (friction := wall.own_law[2]) is not None]
    return min(own, default=flow.scene.coefficients.friction)


def outline_of(one: MovingWall) -> np.ndarray:
    """Corners of a wall where the case has it, m, shape (n, 2)."""
    return np.asarray(one.wall.outline((-inf, inf), (-inf, inf))[0])


def other_body(flow: Flow, one: MovingWall, histories: Mapping[str, BodyHistory]) -> tuple[str, float]:
    """The body that touches a body first, and since when, s; infinite where none does."""
    name, first = "", inf
    here = _corners_at(one, histories[one.wall.name])
    for other in flow.scene.bodies:
        if other is one or other.wall.name not in histories:
            continue
        there, time = _corners_at(other, histories[other.wall.name]), histories[one.wall.name].time
        every = max(1, len(time) // MOST_POSES)
        count = min(len(here), len(there))
        for row in range(0, count, every):
            if time[row] >= first:
                break
            if _apart(here[row], there[row]) <= NEAR * flow.scene.smallest:
                name, first = other.wall.name, float(time[row])
                break
    return name, first


def _corners_at(one: MovingWall, history: BodyHistory) -> np.ndarray:
    """Corners of a body at each row of its history, m, shape (rows, corners, 2)."""
    kind = one.motion.kind
    assert isinstance(kind, Free)
    return np.stack([placed(corner, kind, history) for corner in outline_of(one)], axis=1)


def _apart(one: np.ndarray, two: np.ndarray) -> float:
    """Distance of two outlines that do not overlap, m: that of a corner of one to a face of the other."""
    return min(_to_faces(one, two), _to_faces(two, one))


def _to_faces(corners: np.ndarray, ring: np.ndarray) -> float:
    way = np.roll(ring, -1, axis=0) - ring
    off = corners[:, None] - ring[None]
    share = np.clip(np.sum(off * way, axis=2) / np.maximum(np.sum(way * way, axis=1), 1e-300), 0.0, 1.0)
    return float(np.sqrt(np.min(np.sum((off - share[..., None] * way) ** 2, axis=2))))


# --- what is shown ----------------------------------------------------------------------------------------------------


def summary(stabilities: Mapping[str, Stability]) -> dict[str, object]:
    """As under ``stability`` in ``summary.json``: the structures by name."""
    return {name: as_summary(one) for name, one in stabilities.items()}


def tables(stabilities: Mapping[str, Stability]) -> Tables:
    """Rows of all structures, one after the other."""
    parts = [(name, one.table) for name, one in stabilities.items() if len(one.table.get("time", ()))]
    if not parts:
        return {}
    names = np.concatenate([np.full(len(table["time"]), name, dtype=object) for name, table in parts])
    columns = {key: np.concatenate([table[key] for _, table in parts]) for key in parts[0][1]}
    return {"stability.csv": {"time": columns.pop("time"), "name": names, **columns}}


def figures(stabilities: Mapping[str, Stability], _: Gathered) -> Drawings:
    """Force along the base and moment over the toe against time, with their limits."""
    panels: list[Panel] = []
    for name, one in stabilities.items():
        table = one.table
        if not len(table.get("time", ())):
            continue
        time, limit = table["time"], table["sliding_limit"] / KILO
        lines = [Trace("along the base", time, table["driving_force"] / KILO, "faint")]
        lines.append(Trace("the same, moving mean", time, table["driving_mean"] / KILO))
        if isfinite(one.friction):
            lines.append(Trace("limit of sliding", time, limit, "theory"))
            if np.nanmin(table["driving_force"], initial=0.0) < -BACK * np.nanmax(limit * KILO, initial=0.0):
                lines.append(Trace("", time, -limit, "theory"))
        side = one.toe or "right"
        over = [Trace(f"over the {side} toe", time, table[f"moment_over_{side}_toe"] / KILO, "faint")]
        over.append(Trace("the same, moving mean", time, table["moment_mean"] / KILO))
        over.append(Trace("what its weight holds", time, table[f"weight_about_{side}_toe"] / KILO, "theory"))
        panels += [Panel(f"{name}: force\n[kN/m]", lines), Panel(f"{name}: moment\n[kN m/m]", over)]
    return {"stability": Chart("what structures bear", TIME, panels)} if panels else {}


def section(stabilities: Mapping[str, Stability]) -> Section:
    """The numbers of each structure, and why some are absent."""
    blocks: list[Table | Text] = []
    for name, one in stabilities.items():
        keys = [key for key in KEYS if known(getattr(one, key))]
        if known(one.weight):
            rows_of_toe = [("Toe", one.toe)] if one.toe else []
            rows = [
                (f"{head}{over_time(one, key)}", value)
                for key, (head, value) in zip(keys, described(one, *keys), strict=True)
            ]
            blocks.append(Table([*rows, *rows_of_toe], (f"Structure {name}", "")))
        if one.reason:
            blocks.append(Text(_reason(name, one), "small" if known(one.weight) else "warn"))
    if any(known(one.weight) for one in stabilities.values()):
        blocks.append(Text(ABOUT, "small"))
    return Section("Stability", blocks)


OF_WINDOWS = (
    "_least", "_least_at", "_time_below_1", "driving_force_peak", "moment_about_toe_peak", "uplift_peak",
)  # fmt: skip
OF_MEANS = ("_least_mean", "eccentricity_peak", "toe_pressure_peak", "heel_pressure_least")
"""Ends of the keys of numbers by single windows of the record, and by the moving mean."""


def over_time(one: Stability, key: str) -> str:
    """Averaging time of the forces of a number, to follow its words; empty where it has none."""
    for ends, time in ((OF_WINDOWS, one.window_time), (OF_MEANS, one.mean_time)):
        if key.endswith(ends) and known(time):
            return f", {time:z.2g} s means"
    return ""


ABOUT = (
    "A factor of safety is what is borne over what drives; below 1 the structure moves. Forces are those of the discs, "
    "means over the windows of the record, and the weight. A moving body may have factors above 1: friction stops it. "
    "Forces over a shorter time have higher peaks: compare what has one averaging time."
)
"""Text below the tables."""


def _reason(name: str, one: Stability) -> str:
    what = "Some numbers are absent for" if known(one.weight) else "No factor of safety is told for"
    return f"{what} {name}: {one.reason}."


KEYS = tuple(key for key in Stability.__dataclass_fields__ if key not in ("toe", "state", "reason", "table"))


def line(summary: Mapping[str, Any]) -> str:
    """Least factors of each structure that was pushed, with their averaging times, as a sentence; empty without any."""
    said = []
    for name in _told("", summary):
        one = from_summary(Stability, part(summary, "stability")[name])
        kinds = []
        for kind in ("sliding", "tipping"):
            ends = ((f"{kind}_factor_least", one.window_time), (f"{kind}_factor_least_mean", one.mean_time))
            texts = [
                f"{getattr(one, key):z.2g}{f' of {time:z.2g} s means' if known(time) else ''}"
                for key, time in ends
                if known(getattr(one, key))
            ]
            kinds += [f"{kind} {', '.join(texts)}"] if texts else []
        said += [f"{name}: least factor against {' and '.join(kinds)}"] if kinds else []
    return "; ".join(said)


def _times(summary: Mapping[str, Any]) -> dict[str, str]:
    """Averaging times for the labels of the numbers at the top."""
    factors = [one for one in part(summary, "stability").values() if isinstance(one, Mapping)]
    words = {}
    for key in ("window_time", "mean_time"):
        times = dict.fromkeys(f"{one[key]:z.2g} s" for one in factors if known(one.get(key)))
        words[key] = " or ".join(times) or "single windows"
    return words


def _told(_: str, summary: Mapping[str, Any]) -> dict[str, str]:
    """Structures that were pushed."""
    return {
        name: "" for name, one in part(summary, "stability").items()
        if isinstance(one, Mapping) and one.get("driving_force_peak") is not None
    }  # fmt: skip


QUANTITY = Quantity(
    name="stability",
    title="Stability",
    result=Stability,
    definitions="""\
factor        of safety: what is borne over what drives, of each window of the force record: least, least of a moving
              mean, time below 1; without a suffix of the mean forces of the window of the means
sliding       friction of the base times the force down on it (weight less uplift) over the force along the base, of
              discs and weight
tipping       moment of the weight about an end of the base, its toe, over that of the discs over it; the least of both
toe           the end of the base where that is least; the moments stand for it
uplift        force of the discs off the base
eccentricity  from the middle of the base to where the moving mean of the force of discs and weight goes through it
pressure      of the moving mean, below the ends of the base, straight between them; where the force leaves the middle
              third the base gapes
time          only as long as the structure stands on its base: turned by less than 15 degrees, not fallen, not left
""",
    always=lambda flow: bool(flow.scene.bodies or flow.scene.stability),
    analyse=analyse,
    files={"stability.csv": "what drives structures and what they bear, against time"},
    captions={"stability": "What structures bear"},
    tables=tables,
    figures=figures,
    section=section,
    summary=summary,
    headline=(
        HeadlineNumber("*.sliding_factor_least", label="{name}, least factor against sliding, {window_time} means"),
        HeadlineNumber("*.tipping_factor_least", label="{name}, least factor against tipping, {window_time} means"),
    ),
    label_values=_times,
    line=line,
    rank=105,
    structures=_told,
    named=Named("structure", "give it a weight in probes.stability, or make it a body", "weighed", "<structure>"),
)
