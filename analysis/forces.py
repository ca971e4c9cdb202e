"""Force on structures: history, impulse, peak behind a stated low-pass, estimates, and the impulse identity.

Fx and fy are what the discs do to a structure, N per metre of width.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import nan
from typing import TYPE_CHECKING

import numpy as np

from lammps_jump import theory
from lammps_jump.walls import Block, Plane, Wall

from .contact_sums import wall_sums
from .context import FlowContext
from .dump import Frame
from .reflected_wave import ReflectedWave, track_reflection
from .run_folder import ForceHistory
from .statistics import block_average

if TYPE_CHECKING:
    import xarray as xr

LOW_PASS = 0.05
"""Width of the centred moving mean behind which peaks are quoted, s."""


@dataclass(frozen=True)
class MomentumHistory:
    """Momentum of all discs and the walls' forces at the frames, per metre of width.

    Attributes
    ----------
    time : ndarray, shape (frames,), s
    momentum : ndarray, shape (frames, 2), N s
    discs : ndarray of int, shape (frames,)
    same : ndarray of bool, shape (frames,)
        The discs are those of the frame before.
    forces : dict of ndarray, shape (frames, 2), N
        Force on the discs by each probed wall at the frame itself, from positions and velocities.
    unprobed : dict of ndarray of bool, shape (frames, 2)
        Whether an unprobed wall or shut gate pushed along x, along y.
    """

    time: np.ndarray
    momentum: np.ndarray
    discs: np.ndarray
    same: np.ndarray
    forces: dict[str, np.ndarray]
    unprobed: dict[str, np.ndarray]


class MomentumLedger:
    """Collects a `MomentumHistory`."""

    def __init__(self, context: FlowContext):
        self.context = context
        self._rows: list[tuple] = []
        self._ids: np.ndarray | None = None
        self._forces: dict[str, dict[int, tuple]] = {}
        self._unprobed: dict[str, dict[int, tuple]] = {}

    def add(self, frame: Frame, time: float) -> None:
        """Add a frame."""
        context, k = self.context, len(self._rows)
        ids = np.sort(frame.ids)
        same = self._ids is not None and np.array_equal(ids, self._ids)
        self._ids = ids
        mass = context.mass
        self._rows.append((time, mass * float(frame.vx.sum()), mass * float(frame.vy.sum()), frame.n, same))
        if context.stiffness_wall is None:
            return
        standing = context.walls_at(time)
        # the last frame before a gate opens counts as with the gate, the first one after as without
        for wall in standing:
            sums = wall_sums(frame, wall, context)
            if wall.name in context.probes:
                self._forces.setdefault(wall.name, {})[k] = sums.force
            elif sums.index.size:
                pushes_x = sums.sideways or bool(context.friction)
                self._unprobed.setdefault(wall.name, {})[k] = (pushes_x, bool(np.any(sums.fy != 0)))

    def result(self) -> MomentumHistory:
        """The history of all frames added."""
        rows = np.array(self._rows, float).reshape(-1, 5)
        n = len(rows)

        def spread(sparse: dict[int, tuple], kind) -> np.ndarray:
            dense = np.zeros((n, 2), kind)
            for k, value in sparse.items():
                dense[k] = value
            return dense

        return MomentumHistory(
            rows[:, 0],
            rows[:, 1:3],
            rows[:, 3].astype(int),
            rows[:, 4].astype(bool),
            {name: spread(sparse, float) for name, sparse in self._forces.items()},
            {name: spread(sparse, bool) for name, sparse in self._unprobed.items()},
        )


def moving_mean(values: np.ndarray, samples: int) -> np.ndarray:
    """Centred mean over an odd number of samples (made odd upwards); shorter, still centred, at the ends."""
    half = max(int(samples), 1) // 2
    if half == 0 or len(values) == 0:
        return np.asarray(values, float).copy()
    total = np.concatenate([[0.0], np.cumsum(values)])
    index = np.arange(len(values))
    reach = np.minimum(half, np.minimum(index, len(values) - 1 - index))
    return (total[index + reach + 1] - total[index - reach]) / (2 * reach + 1)


def window_lengths(time: np.ndarray) -> np.ndarray:
    """Length of the averaging window that ends at each time, s; the first one is taken as long as the second."""
    if len(time) < 2:
        return np.zeros(len(time))
    steps = np.diff(time)
    return np.concatenate([[np.median(steps)], steps])


@dataclass(frozen=True)
class StructureForce:
    """History of one structure.

    Attributes
    ----------
    wall : Wall or None
        None where the context does not know the name.
    history : ForceHistory
    smooth : dict of ndarray
        fx, fy, moment behind the low-pass.
    impulse : ndarray, shape (n, 2)
        Running impulse of fx, fy, N s.
    component : {'fx', 'fy'}
        The one with the larger integral of its magnitude.
    depth : ndarray, shape (n,)
        Mass depth in front of the structure, m (NaN where no profile is).
    hydrostatic : ndarray, shape (n,)
        rho g h^2/2 on its face for that depth, N.
    oncoming : ndarray, shape (n,)
        Momentum of the flow two bins in front of it, rho s u^2 + rho g s^2/2 where u runs towards it, N.
    """

    wall: Wall | None
    history: ForceHistory
    smooth: dict[str, np.ndarray]
    impulse: np.ndarray
    component: str
    depth: np.ndarray
    hydrostatic: np.ndarray
    oncoming: np.ndarray


@dataclass(frozen=True)
class Identity:
    """Impulse of all walls and of gravity against the change of the discs' momentum along one axis, N s.

    Attributes
    ----------
    axis : {'x', 'y'}
    start, end : float
        The longest time between frames with the same discs, probes aligned, gates open, s.
    change : float
        Momentum change of the discs.
    walls, gravity : float
        Impulses on the discs; half a step's force at both ends is taken off, as velocity Verlet's kicks ask.
    scale : float
        Sum over walls of the integral of the force's magnitude.
    reason : str
        Empty where the identity could be formed and is complete; else what is missing.
    """

    axis: str
    start: float = nan
    end: float = nan
    change: float = nan
    walls: float = nan
    gravity: float = nan
    scale: float = nan
    reason: str = ""

    @property
    def difference(self) -> float:
        """Change of momentum that no impulse explains."""
        return self.change - self.walls - self.gravity

    @property
    def relative(self) -> float:
        """The difference over the scale."""
        return abs(self.difference) / self.scale if self.scale else nan


@dataclass(frozen=True)
class ForceResult:
    """Everything about forces: see `analyse_forces`."""

    context: FlowContext
    structures: dict[str, StructureForce]
    identities: tuple[Identity, ...]
    reflected: ReflectedWave | None
    summary: dict = field(default_factory=dict)

    def tables(self) -> dict[str, dict[str, np.ndarray]]:
        """CSV tables: one a structure, and the reflected wave."""
        result = {}
        for name, force in self.structures.items():
            result[f"force_{name}.csv"] = {
                "time": force.history.time,
                "fx": force.history.fx,
                "fy": force.history.fy,
                "moment": force.history.moment,
                **{f"{key}_smooth": values for key, values in force.smooth.items()},
                "impulse_x": force.impulse[:, 0],
                "impulse_y": force.impulse[:, 1],
                "depth": force.depth,
                "hydrostatic": force.hydrostatic,
                "oncoming": force.oncoming,
            }
        if self.reflected is not None:
            result["reflected_wave.csv"] = {"time": self.reflected.time, "position": self.reflected.position}
        return result


def analyse_forces(
    forces: dict[str, ForceHistory],
    context: FlowContext,
    momentum: MomentumHistory | None,
    profiles: xr.Dataset,
) -> ForceResult:
    """Histories, peaks, estimates, identities and the reflected wave of a run.

    Parameters
    ----------
    forces : dict of str to ForceHistory
        Of ``forces.csv``.
    context : FlowContext
    momentum : MomentumHistory, optional
    profiles : xarray.Dataset

    Returns
    -------
    ForceResult
        ``summary`` holds a dict for every structure (peak, impulse …) and ``identity``, ``reflected_wave``, ``notes``.
    """
    structures = {name: _structure(name, history, context, profiles) for name, history in forces.items()}
    identities = ()
    if momentum is not None:
        identities = tuple(impulse_identity(forces, momentum, context, axis) for axis in ("x", "y"))
    reflected = _reflected(structures, context, profiles)
    window = (profiles.attrs["window_begin"], profiles.attrs["window_end"])
    summary: dict = {name: _numbers(force, window) for name, force in structures.items()}
    summary |= _settled(structures, context, profiles, momentum)
    notes = [_sentence(identity) for identity in identities]
    if reflected is not None:
        summary["reflected_wave"] = reflected.summary()
        notes.append(reflected.sentence())
    summary["identity"] = {identity.axis: _identity_numbers(identity) for identity in identities}
    summary["low_pass"] = LOW_PASS
    summary["notes"] = notes
    return ForceResult(context, structures, identities, reflected, summary)


def _face(wall: Wall | None) -> tuple[float, float, float, int] | None:
    """Position, foot and top of the face that a stream towards +x (or a fluid right of a back wall) meets; side."""
    if isinstance(wall, Block):
        return wall.x[0], wall.y[0], wall.y[1], -1
    if isinstance(wall, Plane) and wall.axis == "x":
        return wall.at, -np.inf, np.inf, 1 if wall.side == "above" else -1
    return None


def _structure(name: str, history: ForceHistory, context: FlowContext, profiles: xr.Dataset) -> StructureForce:
    try:
        wall = context.wall(name)
    except KeyError:
        wall = None
    lengths = window_lengths(history.time)
    samples = 1 if len(lengths) < 2 else round(LOW_PASS / max(float(np.median(lengths)), 1e-300))
    samples = max(1, samples + (samples + 1) % 2)
    smooth = {key: moving_mean(getattr(history, key), samples) for key in ("fx", "fy", "moment")}
    impulse = np.cumsum(np.column_stack([history.fx, history.fy]) * lengths[:, None], axis=0)
    weight_x, weight_y = np.sum(np.abs(history.fx) * lengths), np.sum(np.abs(history.fy) * lengths)
    component = "fx" if weight_x >= weight_y else "fy"
    nothing = np.full(len(history.time), nan)
    depth, hydrostatic, oncoming = nothing, nothing, nothing
    face = _face(wall)
    gravity = -context.gravity[1]
    if face is not None and gravity > 0:
        at, foot, top, side = face
        near = _station(profiles, at, side, 1, context)
        far = _station(profiles, at, side, 2, context)
        if near is not None:
            bed = float(profiles["bed"].values[near])
            high = top - max(foot, bed)
            depth = _at_times(history.time, profiles, profiles["mass_depth"].values[:, near])
            wetted = np.clip(depth, 0, high)
            hydrostatic = context.density * gravity * wetted * (depth - 0.5 * wetted)
        if far is not None:
            flux = profiles["momentum_flux"].values[:, far]
            towards = side * profiles["discharge"].values[:, far] < 0
            still = 0.5 * gravity * profiles["mass_depth"].values[:, far] ** 2
            oncoming = _at_times(history.time, profiles, context.density * (np.where(towards, flux, 0.0) + still))
    return StructureForce(wall, history, smooth, impulse, component, depth, hydrostatic, oncoming)


def _station(profiles: xr.Dataset, at: float, side: int, bins: int, context: FlowContext) -> int | None:
    """The bin that lies `bins` bins before a face, or None outside the profiles."""
    width = profiles.attrs["bin_width"]
    place = at + side * (bins - 0.5) * width
    index = int(np.floor((place - profiles.attrs["x_low"]) / width))
    inside = 0 <= index < profiles.sizes["x"] and np.isfinite(profiles["bed"].values[index])
    return index if inside else None


def _at_times(time: np.ndarray, profiles: xr.Dataset, values: np.ndarray) -> np.ndarray:
    frames = profiles["time"].values
    return np.interp(time, frames, values, left=nan, right=nan) if len(frames) > 1 else np.full(len(time), nan)


def _window_mean(force: StructureForce, window: tuple[float, float]) -> dict:
    """Mean force over the window of the profiles with its standard error, and the mean hydrostatic estimate."""
    inside = (force.history.time > window[0]) & (force.history.time <= window[1] + 1e-9)
    if not inside.any():
        return {"mean_fx": None, "mean_fy": None}
    numbers = {}
    for key in ("fx", "fy"):
        result = block_average(getattr(force.history, key)[inside])
        error = float(result.standard_error)
        numbers[f"mean_{key}"] = float(result.mean)
        numbers[f"mean_{key}_error"] = error if np.isfinite(error) else float(result.lower_bound)
    known = inside & np.isfinite(force.hydrostatic)
    numbers["mean_hydrostatic"] = float(force.hydrostatic[known].mean()) if known.any() else None
    return numbers


def _numbers(force: StructureForce, window: tuple[float, float]) -> dict:
    history = force.history
    values = force.smooth[force.component]
    live = history.time > 0 if (history.time > 0).any() else np.ones(len(history.time), bool)
    if not live.any():
        return {"peak": None, "impulse": None}

    def biggest(series: np.ndarray) -> tuple[float, float]:
        chosen = np.where(live & np.isfinite(series), np.abs(series), -1.0)
        k = int(np.argmax(chosen))
        return (float(series[k]), float(history.time[k])) if chosen[k] >= 0 else (nan, nan)

    peak, peak_time = biggest(values)
    before = force.impulse[np.flatnonzero(live)[0] - 1] if not live[0] else np.zeros(2)
    after = force.impulse[np.flatnonzero(live)[-1]]
    index = 0 if force.component == "fx" else 1
    return {
        "component": force.component,
        "peak": peak,
        "peak_time": peak_time,
        "peak_unfiltered": biggest(getattr(history, force.component))[0],
        "impulse": float(after[index] - before[index]),
        "impulse_x": float(after[0] - before[0]),
        "impulse_y": float(after[1] - before[1]),
        "peak_fx": biggest(force.smooth["fx"])[0],
        "peak_fy": biggest(force.smooth["fy"])[0],
        "peak_moment": biggest(force.smooth["moment"])[0],
        "hydrostatic": biggest(force.hydrostatic)[0],
        "stagnation": biggest(force.oncoming)[0],
        "largest_depth": biggest(force.depth)[0],
        **_window_mean(force, window),
    }


def _settled(structures: dict, context: FlowContext, profiles: xr.Dataset, momentum: MomentumHistory | None) -> dict:
    """Mean force over the last quarter of the time before the gate opens, against hydrostatics and the weight."""
    times = profiles["time"].values
    gravity = -context.gravity[1]
    if gravity <= 0 or not (times < 0).any():
        return {}
    start = 0.25 * float(times[0])
    result = {}
    frames = (times >= start) & (times <= 0)
    for name, force in structures.items():
        chosen = (force.history.time > start) & (force.history.time <= 0)
        if not chosen.any() or not frames.any():
            continue
        mean_x, mean_y = float(force.history.fx[chosen].mean()), float(force.history.fy[chosen].mean())
        if isinstance(force.wall, Plane) and force.wall.axis == "x":
            index = _station(profiles, *_face(force.wall)[::3], 2, context)
            depth = nan if index is None else float(profiles["mass_depth"].values[frames, index].mean())
            expected = theory.hydrostatic_force(depth, context.density, gravity)
            result[name] = {"force": mean_x, "depth": depth, "hydrostatic": expected, "ratio": abs(mean_x) / expected}
        elif momentum is not None and abs(mean_y) > abs(mean_x):
            weight = context.mass * gravity * float(momentum.discs[frames].mean())
            result[name] = {"force": mean_y, "weight": weight, "ratio": abs(mean_y) / weight}
    return {"settled": result} if result else {}


def impulse_identity(
    forces: dict[str, ForceHistory], momentum: MomentumHistory, context: FlowContext, axis: str
) -> Identity:
    """Hold the walls' impulse and gravity's against the change of the discs' momentum.

    Over the longest run of frames with the same discs, whose ends fall on ends of force windows, after all gates have
    opened. Forces are sums over every step, so the two agree to the digits of the files where all walls that push
    along the axis are probed.

    Parameters
    ----------
    forces : dict of str to ForceHistory
    momentum : MomentumHistory
    context : FlowContext
    axis : {'x', 'y'}
    """
    column = 0 if axis == "x" else 1
    if not forces:
        return Identity(axis, reason="no wall was probed")
    first = next(iter(forces.values()))
    span = _common_span(first.time, momentum, context)
    if not momentum.same.any():
        return Identity(axis, reason="discs enter or leave between all frames")
    if span is None:
        return Identity(axis, reason="no two frames hold the same discs and fall on ends of the force windows")
    a, b = span
    start, end = momentum.time[a], momentum.time[b]
    reasons = []
    for name, pushed in momentum.unprobed.items():
        if pushed[a : b + 1, column].any():
            reasons.append(f"wall '{name}' pushes along {axis} and is not probed")
    if context.stiffness_wall is None:
        reasons.append("without stiffnesses nothing tells whether other walls push")
    reasons += [
        f"wall '{wall.name}' has no force record" for wall in context.walls
        if wall.name in context.probes and wall.name not in forces
    ]  # fmt: skip
    slack = 0.25 * (context.time_step or 0.0) or 1e-9
    walls = scale = 0.0
    for name, history in forces.items():
        lengths = window_lengths(history.time)
        inside = (history.time > start + slack) & (history.time <= end + slack)
        covered = float(lengths[inside].sum())
        if abs(covered - (end - start)) > 1e-6 * (end - start) + slack:
            reasons.append(f"the record of '{name}' covers {covered:.4g} s of {end - start:.4g} s")
        values = (history.fx, history.fy)[column]
        walls -= float(np.dot(values[inside], lengths[inside]))
        scale += float(np.dot(np.abs(values[inside]), lengths[inside]))
        if name in momentum.forces and context.time_step:
            ends = momentum.forces[name][:, column]
            walls += 0.5 * context.time_step * float(ends[a] - ends[b])
    gravity = context.gravity[column] * context.mass * float(momentum.discs[a]) * (end - start)
    change = float(momentum.momentum[b, column] - momentum.momentum[a, column])
    return Identity(axis, float(start), float(end), change, walls, gravity, scale, "; ".join(dict.fromkeys(reasons)))


def _common_span(window_ends: np.ndarray, momentum: MomentumHistory, context: FlowContext) -> tuple[int, int] | None:
    """First and last frame of the longest stretch the identity may use."""
    step = context.time_step or 0.0
    opened = max(((gate.release_step - context.settle_steps) * step for gate in context.gates), default=-np.inf)
    slack = 0.25 * step or 1e-9
    gap = np.abs(momentum.time[:, None] - window_ends[None, :]).min(axis=1) if len(window_ends) else np.full(1, np.inf)
    lengths = window_lengths(window_ends)
    begin = window_ends[0] - lengths[0] if len(window_ends) else np.inf
    # the record may start at the first frame, with the window that ends later
    aligned = (gap <= slack) | (np.abs(momentum.time - begin) <= slack)
    usable = aligned & (momentum.time >= opened - slack)
    best: tuple[int, int] | None = None
    start: int | None = None
    for k in range(len(momentum.time)):
        if start is not None and not momentum.same[k]:
            start = None
        if start is None and usable[k]:
            start = k
        if start is not None and usable[k] and k > start:
            longer = (
                best is None
                or momentum.time[k] - momentum.time[start] > momentum.time[best[1]] - momentum.time[best[0]]
            )
            best = (start, k) if longer else best
    return best


def _identity_numbers(identity: Identity) -> dict:
    return {
        "start": identity.start,
        "end": identity.end,
        "momentum_change": identity.change,
        "wall_impulse": identity.walls,
        "gravity_impulse": identity.gravity,
        "difference": identity.difference,
        "relative": identity.relative,
        "complete": not identity.reason,
        "reason": identity.reason or None,
    }


def _sentence(identity: Identity) -> str:
    if not np.isfinite(identity.change):
        return f"Impulse identity along {identity.axis}: not formed, {identity.reason}."
    text = (
        f"Impulse identity along {identity.axis}, t = {identity.start:.3f} to {identity.end:.3f} s: the discs' "
        f"momentum changes by {identity.change:.8g} N s/m, walls and gravity give "
        f"{identity.walls + identity.gravity:.8g} N s/m; they differ by {identity.relative:.1e} of the walls' total "
        "impulse."
    )
    return text + (f" Incomplete: {identity.reason}." if identity.reason else "")


def _reflected(structures: dict, context: FlowContext, profiles: xr.Dataset) -> ReflectedWave | None:
    """The wave thrown back by the first block that stands in a stream towards +x."""
    blocks = [force.wall for force in structures.values() if isinstance(force.wall, Block) and force.component == "fx"]
    if not blocks or -context.gravity[1] <= 0 or context.inlets:
        return None
    return track_reflection(profiles, min(blocks, key=lambda wall: wall.x[0]), context)
