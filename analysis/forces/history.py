# SPDX-License-Identifier: GPL-2.0-or-later
"""Force on structures: history, impulse, peak after a stated low-pass, estimates, and the impulse identity.

Fx and fy are what the discs do to a structure, N per metre of width.

A moment says nothing without its point. That of a body is recorded about its centre of mass or its hinge, where a
structure is looked at about the toe over which it would turn.
"""

# ruff: noqa: RUF001  (Greek letters, minus signs and dashes are meant for readers)
from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import atan2, degrees, hypot, nan
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from lammps_jump.analysis.devices.standing import FLAT, base_at, placed
from lammps_jump.analysis.flow import Flow
from lammps_jump.analysis.passes import Tables
from lammps_jump.analysis.profiles import window_of
from lammps_jump.analysis.statistics import as_fields, mean_of
from lammps_jump.dump.find import ForceHistory
from lammps_jump.dump.walls import BodyHistory, read_bodies
from lammps_jump.errors import DumpError
from lammps_jump.files import BODIES
from lammps_jump.physics import jump as waves
from lammps_jump.scene.motion import MovingWall, Pose, reference
from lammps_jump.scene.walls import Wall
from lammps_jump.units import Estimates, as_summary, estimate, from_summary, number

from .impulse import Identity, MomentumHistory, identity_sentence, impulse_identity, window_lengths
from .reflection import ReflectedWave, track_reflection

if TYPE_CHECKING:
    import xarray as xr


class MomentPoint(NamedTuple):
    """A point in words, ``its centre of mass``, and where it is at each row of a record, m, arrays of shape (rows,)."""

    words: str
    x: np.ndarray
    y: np.ndarray


class Toes(NamedTuple):
    """Moments about the ends of the base of a body, anticlockwise.

    Attributes
    ----------
    left, right : ndarray, shape (rows,)
        Of the discs, N m/m.
    upright : ndarray of bool, shape (rows,)
        Whether it stands on its base still, turned by at most `FLAT`: else it has no toes.
    weight_left, weight_right : float
        Of its weight at its release, N m/m: what holds it, as long as it stands upright.
    """

    left: np.ndarray
    right: np.ndarray
    upright: np.ndarray
    weight_left: float
    weight_right: float


def point_of(name: str, history: ForceHistory, flow: Flow, bodies: Mapping[str, BodyHistory]) -> MomentPoint | None:
    """Point about which the record has the moment of a structure, or of a group; None: the scene has neither."""
    walls = {one.wall.name: one for one in flow.scene.walls}
    group = dict(flow.scene.groups).get(name)
    one = walls.get(group[0] if group else name)
    if one is None:
        return None
    of = f"the point of {one.wall.name}" if group else ""
    rows = len(history.time)
    if one.motion.kind is None:
        return MomentPoint(of or "its point", *(np.full(rows, place) for place in reference(one)))
    if one.motion.free and one.motion.free.hinge is None:
        body = bodies.get(one.wall.name)
        return body and MomentPoint(of or "its centre of mass", *_at(body, history.time).T)
    where = np.array([_moved(one, flow, float(time)) for time in history.time]).reshape(rows, 2)
    words = "its hinge" if one.motion.free else "the point that it turns about"
    return MomentPoint(of or words, *where.T)


def _moved(one: MovingWall, flow: Flow, time: float) -> tuple[float, float]:
    """The point of turning of a wall at a time (s), m."""
    motion, (x, y) = one.motion, reference(one)
    if motion.free:
        return x, y
    pose = flow.poses.at(time).get(one.wall.name) if motion.is_state and flow.poses else motion.pose(flow.step_at(time))
    pose = pose or Pose()
    return x + pose.x, y + pose.y


def _at(body: BodyHistory, time: np.ndarray) -> np.ndarray:
    """Centre of mass at some times (s), m, shape (times, 2)."""
    return np.column_stack([np.interp(time, body.time, body.x), np.interp(time, body.time, body.y)])


def toes_of(one: MovingWall, flow: Flow, history: ForceHistory, point: MomentPoint, body: BodyHistory) -> Toes | None:
    """Moments about both toes of a body; None of one that turns about a hinge or has no base.

    Notes
    -----
    ``M_toe = M + (r - r_toe) x F``, with the point r of the moment M.
    """
    kind = one.motion.free
    if kind is None or kind.hinge is not None or not flow.g:
        return None
    start = max(int(np.searchsorted(body.time, kind.begin, side="right")) - 1, 0)
    base = base_at(one, np.array(flow.scene.gravity), float(body.angle[start]))
    if base is None:
        return None
    moments, weights = [], []
    for end in (base.first, base.last):
        path = placed(end, kind, body)
        x, y = (np.interp(history.time, body.time, place) for place in path.T)
        moments.append(history.moment + (point.x - x) * history.fy - (point.y - y) * history.fx)
        arm = np.array([body.x[start], body.y[start]]) - path[start]
        weights.append(float(arm[0] * kind.weight[1] - arm[1] * kind.weight[0]))
    turn = np.interp(history.time, body.time, body.angle - body.angle[start])
    return Toes(moments[0], moments[1], np.abs(turn) <= FLAT, weights[0], weights[1])


LOW_PASS = 0.05
"""Width of the centred moving mean after which peaks are quoted, s."""
UNTOUCHED = "nothing touched it"
"""Why a structure has no component."""
PEAK_BLOCK, LEAST_BLOCKS = 0.5, 4
"""The error of a peak is the scatter of the maxima of blocks of 0.5 s; s, blocks."""


def moving_mean(values: np.ndarray, samples: int) -> np.ndarray:
    """Centred mean over an odd number of samples (made odd upwards); NaN where the record ends within half of it."""
    half = max(int(samples), 1) // 2
    mean = np.full(len(values), nan)
    if len(values) > 2 * half:
        total = np.concatenate([[0.0], np.cumsum(values)])
        mean[half : len(values) - half] = (total[2 * half + 1 :] - total[: -2 * half - 1]) / (2 * half + 1)
    return mean


def peak_error(time: np.ndarray, force: np.ndarray) -> float:
    """Standard error of the largest force of a steady stream: scatter of the maxima of blocks; NaN for too few.

    Parameters
    ----------
    time : ndarray, shape (n,), s
        Of the window.
    force : ndarray, shape (n,), N/m
        Behind the low-pass.
    """
    size = np.abs(force[np.isfinite(force)])
    if not size.any():
        return nan
    time = time[np.isfinite(force)]
    index = np.floor((time - time[0]) / PEAK_BLOCK + 1e-9).astype(int)
    maxima = [
        size[index == k].max() for k in range(int((time[-1] - time[0]) / PEAK_BLOCK + 1e-9)) if (index == k).any()
    ]
    return float(np.std(maxima, ddof=1)) if len(maxima) >= LEAST_BLOCKS else nan


@dataclass(frozen=True)
class Force(Estimates):
    """Force of the discs on one structure, per metre of width; peaks are those after the low-pass.

    Where discs flow in all the time, peaks and largest values are those of the window, and `startup_peak` is the
    largest force before it. Else they are those after t = 0.

    `component` is the one with the larger integral of its magnitude: `peak` and `impulse` are of it. It is None where
    nothing touched the structure, as `reason` says. Angles of resultants are to the x axis, anticlockwise, so that -90
    is down. `wall` is None where the flow does not know the name, and of a wall that moves or a group.

    `moment_about` names the point of the moment, anticlockwise positive: the foot of an upright face at the bed; its
    centre of mass or hinge of a body. Of a body that stands, `overturning_right` and `overturning_left` are about the
    ends of its base, and `weight_right` and `weight_left` what its weight holds against them. They are None where the
    scene tells no point, and of what has no base.

    `table` holds the columns of the CSV table, shape (n,), per metre of width: the record (time, s, fx, fy, N, moment,
    N m, and where walls move power, W); the point of the moment (``moment_x``, ``moment_y``, m), and of a body
    ``moment_left_toe`` and ``moment_right_toe``, N m, NaN where it does not stand on its base any more; force and
    moment after the low-pass (``fx_smooth`` …, NaN within half of it of the ends); the running impulse (``impulse_x``,
    ``impulse_y``, N s); the mass depth in front of the structure, m, and the hydrostatic force on its wetted face for
    that depth, N (NaN where no profile is); and ``oncoming``, the momentum of the flow two bins in front of it,
    rho s u^2 + rho g s^2/2 where u runs towards it, N, with its first part alone, ``oncoming_flux``.
    """

    component: str | None = None
    peak: float = estimate("N/m", "peak force", label="peak")
    peak_time: float = number("s", "time of the peak", default=nan, label="at")
    peak_unfiltered: float = number("N/m", "peak of the record without low-pass", default=nan)
    startup_peak: float = number("N/m", "largest force before the window, where discs flow in", default=nan)
    startup_peak_time: float = number("s", "time of that", default=nan)
    impulse: float = number("N s/m", "impulse", default=nan)
    impulse_x: float = number("N s/m", "impulse along x", default=nan)
    impulse_y: float = number("N s/m", "impulse along y", default=nan)
    peak_fx: float = number("N/m", "peak of Fx", default=nan)
    peak_fy: float = number("N/m", "peak of Fy", default=nan)
    peak_moment: float = number("N m/m", "peak moment about that point, anticlockwise", default=nan)
    moment_about: str | None = None
    moment_x: float = number("m", "x of the point of the moment, at the start", default=nan)
    moment_y: float = number("m", "y of the point of the moment, at the start", default=nan)
    overturning_right: float = number("N m/m", "largest moment about its right toe, clockwise", default=nan)
    weight_right: float = number("N m/m", "moment of its weight about that toe at its release", default=nan)
    overturning_left: float = number("N m/m", "largest moment about its left toe, anticlockwise", default=nan)
    weight_left: float = number("N m/m", "moment of its weight about that toe at its release, clockwise", default=nan)
    hydrostatic: float = number("N/m", "hydrostatic force on the wetted face", default=nan)
    stagnation: float = number("N/m", "oncoming momentum, ρsu² + ρgs²/2", default=nan)
    oncoming_flux: float = number("N/m", "momentum flux of the discs that come, ρsu²", default=nan)
    largest_depth: float = number("m", "largest mass depth in front of it", default=nan)
    mean_fx: float = estimate("N/m", "mean Fx of the window")
    mean_fy: float = estimate("N/m", "mean Fy of the window")
    resultant: float = number("N/m", "largest resultant of Fx and Fy", default=nan)
    resultant_angle: float = number("degree", "direction of the largest resultant", default=nan)
    resultant_time: float = number("s", "time of the largest resultant", default=nan)
    mean_resultant: float = number("N/m", "resultant of the mean Fx and Fy of the window", default=nan)
    mean_angle: float = number("degree", "direction of the mean resultant", default=nan)
    mean_hydrostatic: float = number("N/m", "mean hydrostatic force on the wetted face", default=nan)
    mean_power: float = estimate("W/m", "mean power of the structure on the discs, of the window")
    work: float = number("J/m", "its work on the discs after t = 0", default=nan)
    reason: str | None = None
    wall: Wall | None = field(default=None, metadata={"summary": False})
    table: Mapping[str, np.ndarray] = field(default_factory=dict, repr=False, metadata={"summary": False})

    @property
    def history(self) -> ForceHistory:
        """The record: time (s), fx, fy (N/m), moment (N; about the foot of upright faces), shape (n,) each."""
        return ForceHistory(*(self.table[name] for name in ("time", "fx", "fy", "moment")))


BESIDE = ("settled", "reflected_wave", "identity", "low_pass", "notes")
"""Keys under ``force`` in ``summary.json`` that are of no structure alone."""


@dataclass(frozen=True)
class Forces:
    """Forces on all structures, the impulse identities along x and y, the reflected wave.

    `structures` are walls and groups of walls by name, `members` the walls of groups.
    """

    structures: dict[str, Force]
    identities: tuple[Identity, ...]
    reflected: ReflectedWave | None
    settled: dict[str, dict[str, float]]
    members: frozenset[str] = frozenset()

    @property
    def shown(self) -> dict[str, Force]:
        """Histories that figures show: a group in place of its walls, and none that nothing touched."""
        shown = {name: force for name, force in self.structures.items() if name not in self.members}
        return {name: force for name, force in shown.items() if force.component is not None}

    @property
    def notes(self) -> list[str]:
        """Sentences on the identities and the reflected wave."""
        sentences = [identity_sentence(identity) for identity in self.identities]
        return [*sentences, *([self.reflected.sentence()] if self.reflected else [])]

    def summary(self) -> dict[str, Any]:
        """As under ``force`` in ``summary.json``: the structures by name, and what belongs to all of them."""
        return {
            **{name: as_summary(force) for name, force in self.structures.items()},
            **({"settled": self.settled} if self.settled else {}),
            **({"reflected_wave": as_summary(self.reflected)} if self.reflected else {}),
            "identity": {identity.axis: as_summary(identity) for identity in self.identities},
            "low_pass": LOW_PASS,
            "notes": self.notes,
        }

    @classmethod
    def of(cls, summary: Mapping[str, Any]) -> Forces:
        """Histories that are under ``force`` in ``summary.json``."""
        walls = {name: from_summary(Force, one) for name, one in summary.items() if name not in BESIDE}
        axes = (summary.get("identity") or {}).items()
        identities = (replace(from_summary(Identity, one), axis=axis) for axis, one in axes)
        wave = summary.get("reflected_wave")
        reflected = from_summary(ReflectedWave, wave) if wave else None
        return cls(walls, tuple(identities), reflected, summary.get("settled") or {})

    def tables(self) -> Tables:
        """CSV tables: one a structure, and the reflected wave."""
        result: Tables = {f"force_{name}.csv": force.table for name, force in self.structures.items()}
        if self.reflected is not None and self.reflected.time is not None and self.reflected.position is not None:
            result["reflected_wave.csv"] = {"time": self.reflected.time, "position": self.reflected.position}
        return result


def analyse_forces(
    forces: Mapping[str, ForceHistory], flow: Flow, momentum: MomentumHistory | None, profiles: xr.Dataset
) -> Forces:
    """Histories, peaks, estimates, identities and the reflected wave of a run.

    Parameters
    ----------
    forces : mapping of str to ForceHistory
        Of ``forces.csv``.
    flow : Flow
    momentum : MomentumHistory, optional
    profiles : xarray.Dataset
    """
    # there is no depth before a wall that moves away, and its moment is about its own point
    walls = {wall.name: wall for wall, motion in flow.scene.walls if motion.kind is None}
    bodies, free = _bodies(flow), {one.wall.name: one for one in flow.scene.bodies}
    structures = {}
    for name, history in forces.items():
        point = point_of(name, history, flow, bodies)
        toes = toes_of(free[name], flow, history, point, bodies[name]) if point and name in free else None
        structures[name] = _structure(walls.get(name), history, flow, profiles, (point, toes))
    identities: tuple[Identity, ...] = ()
    if momentum is not None:
        identities = tuple(impulse_identity(forces, momentum, flow, axis) for axis in ("x", "y"))
    settled = _settled(structures, flow, profiles, momentum)
    members = frozenset(member for _, group in flow.scene.groups for member in group)
    return Forces(structures, identities, _reflected(structures, flow, profiles), settled, members)


def _bodies(flow: Flow) -> Mapping[str, BodyHistory]:
    """Bodies against time; none where their file is not there or damaged, which the analysis of bodies tells."""
    if not flow.scene.bodies or not flow.poses:
        return {}
    try:
        return read_bodies(flow.poses.path.with_name(BODIES))
    except DumpError:
        return {}


Points = tuple[MomentPoint | None, Toes | None]
"""The point of the moment of a structure, and its moments about its toes."""


def _face(wall: Wall | None) -> tuple[float, float, float, int] | None:
    """Position, foot and top of the face that a stream towards +x (or a fluid right of a back wall) meets; side."""
    if wall is None or wall.hollow:
        return None
    if wall.finite:
        (x, _), (foot, top) = wall.extent
        return x, foot, top, -1
    low, high = wall.room("x")
    if np.isinf(low) and np.isinf(high):
        return None
    return (low, -np.inf, np.inf, 1) if np.isfinite(low) else (high, -np.inf, np.inf, -1)


def _columns(
    wall: Wall | None, history: ForceHistory, flow: Flow, profiles: xr.Dataset, points: Points
) -> tuple[dict[str, np.ndarray], str | None]:
    """The `table` of a `Force`, and what the point of its moment is."""
    (point, toes), words = points, points[0].words if points[0] else None
    where = {"moment_x": point.x, "moment_y": point.y} if point else {}
    lengths, gravity, moment = window_lengths(history.time), flow.gravity, history.moment
    samples = 1 if len(lengths) < 2 else round(LOW_PASS / max(float(np.median(lengths)), 1e-300))
    depth: Any
    hydrostatic: Any
    depth = hydrostatic = oncoming = carried = np.full(len(history.time), nan)
    face = _face(wall) if gravity > 0 else None
    if wall is not None and face is not None:
        at, foot, top, side = face
        near, far = (_station(profiles, at, side, bins) for bins in (1, 2))
        if near is not None:
            bed = float(near["bed"])
            # the record's point is the block's corner, or y = 0 of a plane: moved up to where the face leaves the bed
            moment = history.moment + (max(bed, foot) - wall.moment_point[1]) * history.fx
            words, where["moment_y"] = "its foot", np.full(len(history.time), max(bed, foot))
            high = top - max(foot, bed)
            depth = _at_times(history.time, profiles, near["mass_depth"].values)
            hydrostatic = waves.hydrostatic_force(depth, flow.scene.density, gravity, np.maximum(depth - high, 0))
        if far is not None:
            towards = side * far["discharge"].values < 0
            still = 0.5 * gravity * far["mass_depth"].values ** 2
            flux = np.where(towards, far["momentum_flux"].values, 0.0)
            carried = _at_times(history.time, profiles, flow.scene.density * flux)
            oncoming = carried + _at_times(history.time, profiles, flow.scene.density * still)
    about = {"moment_left_toe": toes.left, "moment_right_toe": toes.right} if toes else {}
    smooth = {"fx": history.fx, "fy": history.fy, "moment": moment, **about}
    own = {name: values for name, values in vars(history).items() if values is not None}
    smoothed = {f"{name}_smooth": moving_mean(values, samples) for name, values in smooth.items()}
    if toes:  # means first: a gap would end them
        about = {name: np.where(toes.upright, values, nan) for name, values in about.items()}
        smoothed |= {f"{name}_smooth": np.where(toes.upright, smoothed[f"{name}_smooth"], nan) for name in about}
    return {
        **own,
        "moment": moment,
        **where,
        **about,
        **smoothed,
        "impulse_x": np.cumsum(history.fx * lengths),
        "impulse_y": np.cumsum(history.fy * lengths),
        "depth": depth,
        "hydrostatic": hydrostatic,
        "oncoming": oncoming,
        "oncoming_flux": carried,
    }, words


def _station(profiles: xr.Dataset, at: float, side: int, bins: int) -> xr.Dataset | None:
    """The profiles of the bin that lies `bins` bins before a face; None outside them."""
    width = profiles.attrs["bin_width"]
    index = int(np.floor((at + side * (bins - 0.5) * width - profiles.attrs["x_low"]) / width))
    inside = 0 <= index < profiles.sizes["x"] and np.isfinite(profiles["bed"].values[index])
    return profiles.isel(x=index) if inside else None


def _at_times(time: np.ndarray, profiles: xr.Dataset, values: np.ndarray) -> np.ndarray:
    frames = profiles["time"].values
    return np.interp(time, frames, values, left=nan, right=nan) if len(frames) > 1 else np.full(len(time), nan)


BIGGEST = {
    "peak_fx": "fx_smooth",
    "peak_fy": "fy_smooth",
    "peak_moment": "moment_smooth",
    "hydrostatic": "hydrostatic",
    "stagnation": "oncoming",
    "oncoming_flux": "oncoming_flux",
    "largest_depth": "depth",
}
"""Number of a structure -> column of its table whose largest value it is."""


def _structure(wall: Wall | None, history: ForceHistory, flow: Flow, profiles: xr.Dataset, points: Points) -> Force:
    """Numbers of one structure; where discs flow in all the time, parts of the record tell of each other."""
    table, about = _columns(wall, history, flow, profiles, points)
    time, window = history.time, window_of(profiles)
    if not len(time):
        return Force(wall=wall, table=table)
    sizes = {name: np.sum(np.abs(table[name]) * window_lengths(time)) for name in ("fx", "fy")}
    component = max(sizes, key=sizes.__getitem__)
    touched = sizes[component] > 0
    main = table[f"{component}_smooth"]
    live = time > 0 if (time > 0).any() else np.ones(len(time), bool)
    inside = (time > window[0]) & (time <= window[1] + 1e-9)
    steady = bool(flow.scene.inlets)

    def biggest(values: np.ndarray, when: np.ndarray = inside if steady else live) -> tuple[float, float]:
        chosen = np.where(when & np.isfinite(values), np.abs(values), -1.0)
        k = int(np.argmax(chosen))
        return (float(values[k]), float(time[k])) if chosen[k] >= 0 else (nan, nan)

    first = int(np.argmax(live))
    given = {axis: table[f"impulse_{axis}"] for axis in "xy"}
    impulse = {axis: float(values[-1] - np.append(0.0, values)[first]) for axis, values in given.items()}
    peak, peak_time = biggest(main)
    startup = biggest(main, live & (time <= window[0])) if steady else (nan, nan)
    means = {f"mean_{name}": mean_of(table[name][inside]) for name in ("fx", "fy")}
    return Force(
        component=component if touched else None,
        reason=None if touched else UNTOUCHED,
        peak=peak,
        **{"peak_error": peak_error(time[inside], main[inside]) if steady else nan},  # a field that `estimate` adds
        peak_time=peak_time,
        peak_unfiltered=biggest(table[component])[0],
        startup_peak=startup[0],
        startup_peak_time=startup[1],
        impulse=impulse[component[1]],
        impulse_x=impulse["x"],
        impulse_y=impulse["y"],
        **{name: biggest(table[column])[0] for name, column in BIGGEST.items()},
        moment_about=about,
        **_about(table, points[1], inside if steady else live),
        **as_fields(**means),
        **(_resultants(table, biggest, [mean.value for mean in means.values()]) if touched else {}),
        mean_hydrostatic=mean_of(table["hydrostatic"][inside]).value,
        **_power(table, inside, live),
        wall=wall,
        table=table,
    )


def _about(table: Mapping[str, np.ndarray], toes: Toes | None, when: np.ndarray) -> dict[str, float]:
    """Fields of the point of the moment, and of the moments about both toes after the low-pass, N m/m."""
    moments = {name: float(table[name][0]) for name in ("moment_x", "moment_y") if name in table}
    if toes is not None:
        over = {"right": -table["moment_right_toe_smooth"], "left": table["moment_left_toe_smooth"]}
        largest = {side: float(np.nanmax(np.where(when, values, nan), initial=0.0)) for side, values in over.items()}
        moments |= {f"overturning_{side}": value for side, value in largest.items() if value > 0}
        moments |= {"weight_right": toes.weight_right, "weight_left": -toes.weight_left}
    return moments


def _resultants(
    table: Mapping[str, np.ndarray], biggest: Callable[[np.ndarray], tuple[float, float]], means: Sequence[float]
) -> dict[str, float]:
    """The largest resultant after the low-pass and that of the means (N/m), with their directions, degrees."""
    fx, fy, time = (table[name] for name in ("fx_smooth", "fy_smooth", "time"))
    largest, when = biggest(np.hypot(fx, fy))
    at = int(np.argmax(time == when))
    return {
        "resultant": largest,
        "resultant_angle": _direction(float(fx[at]), float(fy[at])) if largest > 0 else nan,
        "resultant_time": when,
        "mean_resultant": hypot(*means),
        "mean_angle": _direction(*means) if hypot(*means) > 0 else nan,
    }


def _direction(fx: float, fy: float) -> float:
    """Angle of a force to the x axis, anticlockwise, degrees."""
    return degrees(atan2(fy, fx))


def _power(table: Mapping[str, np.ndarray], inside: np.ndarray, live: np.ndarray) -> dict[str, float]:
    """Mean power of the window and work of a structure; nothing where no wall moves."""
    if "power" not in table:
        return {}
    work = float(np.dot(table["power"][live], window_lengths(table["time"])[live]))
    return {**as_fields(mean_power=mean_of(table["power"][inside])), "work": work}


def _settled(
    structures: Mapping[str, Force], flow: Flow, profiles: xr.Dataset, momentum: MomentumHistory | None
) -> dict[str, dict[str, float]]:
    """Mean force over the last quarter of the time before the gate opens, against hydrostatics and the weight."""
    times = profiles["time"].values
    gravity = flow.gravity
    if gravity <= 0 or not (times < 0).any():
        return {}
    start = 0.25 * float(times[0])
    result = {}
    frames = (times >= start) & (times <= 0)
    for name, force in structures.items():
        chosen = (force.table["time"] > start) & (force.table["time"] <= 0)
        if not chosen.any() or not frames.any():
            continue
        mean_x, mean_y = (float(force.table[name][chosen].mean()) for name in ("fx", "fy"))
        face = _face(force.wall)
        if force.wall is not None and face is not None and not force.wall.finite:
            far = _station(profiles, *face[::3], 2)
            depth = nan if far is None else float(far["mass_depth"].values[frames].mean())
            expected = waves.hydrostatic_force(depth, flow.scene.density, gravity)
            result[name] = {"force": mean_x, "depth": depth, "hydrostatic": expected, "ratio": _ratio(mean_x, expected)}
        elif momentum is not None and abs(mean_y) > abs(mean_x):
            weight = flow.scene.mass * gravity * float(momentum.discs[frames].mean())
            result[name] = {"force": mean_y, "weight": weight, "ratio": _ratio(mean_y, weight)}
    return result


def _ratio(force: float, expected: float) -> float:
    """Size of a force over what was expected; NaN where nothing was: a dry wall, no disc."""
    return abs(force) / expected if expected > 0 else nan


def _reflected(structures: Mapping[str, Force], flow: Flow, profiles: xr.Dataset) -> ReflectedWave | None:
    """The wave thrown back by the first block in a stream towards +x."""
    along = [force.wall for force in structures.values() if force.wall is not None and force.component == "fx"]
    blocks = [wall for wall in along if wall.finite and not wall.hollow]
    if not blocks or flow.gravity <= 0 or flow.scene.inlets:
        return None
    return track_reflection(profiles, min(blocks, key=lambda wall: wall.extent[0][0]), flow)
