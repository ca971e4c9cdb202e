# SPDX-License-Identifier: GPL-2.0-or-later
"""The impulse identity: what walls and gravity gave the discs is what their momentum changed by."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import nan
from typing import Any

import numpy as np

from lammps_jump.analysis.budgets.inflow import Arrivals
from lammps_jump.analysis.contacts import ContactCollector, wall_sums, walls_of
from lammps_jump.analysis.flow import Flow
from lammps_jump.dump import ForceHistory, Frame
from lammps_jump.scene.scene import Scene
from lammps_jump.units import number


@dataclass(frozen=True)
class MomentumHistory:
    """Momentum of all discs and the walls' forces at the frames, per metre of width.

    Attributes
    ----------
    time : ndarray, shape (frames,), s
    momentum : ndarray, shape (frames, 2), N s
    discs : ndarray, shape (frames,)
        Mass of all discs over the nominal mass: their number where they are equal.
    same : ndarray of bool, shape (frames,)
        The discs are those of the frame before, and have their masses; with rows of inflow: all others are known.
    brought, carried : ndarray, shape (frames, 2), N s
        Momentum of the discs that rows of inflow have let in since the frame before, at their entry, and of those that
        have left since, at the frame before.
    held : ndarray, shape (frames,), s
        Time since the frame before times the relative mass of the discs that were there: weight over gravity gave them
        this impulse. Discs that left count as gone all the time.
    forces : dict of ndarray, shape (frames, 2), N
        Force on the discs by each probed wall at the frame itself, from positions and velocities.
    unprobed : dict of ndarray of bool, shape (frames, 2)
        Whether an unprobed wall or shut gate pushed along x, along y.
    """

    time: np.ndarray
    momentum: np.ndarray
    discs: np.ndarray
    same: np.ndarray
    brought: np.ndarray
    carried: np.ndarray
    held: np.ndarray
    forces: dict[str, np.ndarray]
    unprobed: dict[str, np.ndarray]


class MomentumLedger:
    """Collects a `MomentumHistory`, for `with_inflow` where discs come in by rows."""

    def __init__(self, flow: Flow, _: ContactCollector | None = None):
        self.flow = flow
        self._rows: list[tuple[Any, ...]] = []
        self._before: tuple[np.ndarray, np.ndarray, np.ndarray] | None = None

    def add(self, frame: Frame, time: float) -> None:
        """Add a frame."""
        flow, before, now = self.flow, self._before, self._discs(frame)
        ids, mass, speeds = now
        discs, carried, held, same = float(mass.sum()), np.zeros(2), 0.0, False
        if before is not None:
            gone = ~np.isin(before[0], ids, assume_unique=True)
            carried = before[1][gone] @ before[2][gone]
            held = float(before[1][~gone].sum()) * (time - self._rows[-1][0])
            # a disc that was poured may have got its own size since
            same = not gone.any() and len(ids) == len(before[0]) and abs(discs - self._rows[-1][2]) < 1e-7 * discs
        forces, unprobed = {}, {}
        # the last frame before a gate opens counts as with the gate, the first one after as without
        for wall in walls_of(frame, flow) if flow.knows_contacts else ():
            sums = wall_sums(frame, wall, flow)
            if wall.name in flow.scene.probes:
                forces[wall.name] = sums.force
            elif sums.index.size:
                pushes_x = sums.sideways or flow.scene.wall_law(wall.name).friction > 0
                unprobed[wall.name] = (pushes_x, bool(np.any(sums.fy != 0)))
        momentum, carried = flow.scene.mass * (mass @ speeds), flow.scene.mass * carried
        self._before = now
        self._rows.append((time, momentum, discs, same, np.zeros(2), carried, held, forces, unprobed))

    def _discs(self, frame: Frame) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Ids, relative masses and velocities (m/s) of the discs, by id.

        Discs that have just entered still have the largest size: with rows of inflow each counts with its own.
        """
        scene, order = self.flow.scene, np.argsort(frame.ids)
        mass = self.flow.relative_masses(frame)
        if scene.inlets:
            mass = (scene.diameters(frame.ids) / scene.diameter) ** 2
        return frame.ids[order], mass[order], np.column_stack([frame.vx, frame.vy])[order]

    def result(self) -> MomentumHistory:
        """The history of all frames added."""
        *columns, forces, unprobed = zip(*self._rows, strict=True)
        time, momentum, discs, same, brought, carried, held = map(np.array, columns)
        walls = _by_wall(forces, float), _by_wall(unprobed, bool)
        return MomentumHistory(time, momentum, discs, same, brought, carried, held, *walls)


def with_inflow(history: MomentumHistory, arrivals: Arrivals, scene: Scene) -> MomentumHistory:
    """The history with the discs that rows of inflow let in: those came in known numbers, from known places."""
    brought = scene.density * arrivals.pushed
    held = history.held + np.nan_to_num(arrivals.age) / scene.diameter**2
    return replace(history, brought=brought, held=held, same=np.append(False, np.isfinite(arrivals.age[1:])))


def _by_wall(frames: tuple[dict[str, tuple[Any, ...]], ...], kind: type) -> dict[str, np.ndarray]:
    """Pairs of each wall, shape (frames, 2); zeros in frames without the wall."""
    names = dict.fromkeys(name for frame in frames for name in frame)
    return {name: np.array([frame.get(name, (0, 0)) for frame in frames], kind) for name in names}


def window_lengths(time: np.ndarray) -> np.ndarray:
    """Length of the averaging window that ends at each time, s; the first one is taken as long as the second."""
    if len(time) < 2:
        return np.zeros(len(time))
    steps = np.diff(time)
    return np.concatenate([[np.median(steps)], steps])


@dataclass(frozen=True)
class Identity:
    """Impulse of all walls and of gravity against the change of the discs' momentum along one axis, N s/m.

    The walls' impulse is that on the discs; half a step's force at both ends is taken off, as velocity Verlet's kicks
    ask. The relative difference is over the sum of the walls' integrals of the force's magnitude and of the momentum
    that discs brought in and carried out. `reason` says what is missing where the identity is not complete.
    """

    axis: str = field(metadata={"summary": False})
    start: float = number("s", "begin of the longest time with the same discs, probes aligned, gates open", default=nan)
    end: float = number("s", "its end", default=nan)
    momentum_change: float = number("N s/m", "momentum change of the discs", default=nan)
    wall_impulse: float = number("N s/m", "impulse of the walls", default=nan)
    gravity_impulse: float = number("N s/m", "impulse of gravity", default=nan)
    brought_in: float = number("N s/m", "momentum of discs that entered, as their rows let them in", default=0.0)
    carried_out: float = number("N s/m", "momentum of discs that left, in the frame before", default=0.0)
    difference: float = number("N s/m", "change of momentum that no impulse explains", default=nan)
    relative: float = number("", "that over the whole impulse", default=nan)
    complete: bool = False
    reason: str | None = None


def impulse_identity(forces: Mapping[str, ForceHistory], momentum: MomentumHistory, flow: Flow, axis: str) -> Identity:
    """Hold the walls' impulse and gravity's against the change of the discs' momentum.

    Over the longest run of frames with the same discs, or with discs that came by rows of inflow, whose ends fall on
    ends of force windows, after all gates have opened. Forces are sums over every step, so the two agree to the digits
    of the files where all walls that push along the axis are probed. Discs that leave are taken at the frame before:
    what hits them after it is missing.

    Parameters
    ----------
    forces : dict of str to ForceHistory
    momentum : MomentumHistory
    flow : Flow
    axis : {'x', 'y'}
    """
    column = 0 if axis == "x" else 1
    if not forces:
        return Identity(axis, reason="no wall was probed")
    first = next(iter(forces.values()))
    forces = {name: history for name, history in forces.items() if name not in dict(flow.scene.groups)}
    span = _common_span(first.time, momentum, flow)
    if not momentum.same.any():
        return Identity(axis, reason="discs enter or leave between all frames")
    if span is None:
        return Identity(axis, reason="no two frames hold the same discs and fall on ends of the force windows")
    a, b = span
    start, end = momentum.time[a], momentum.time[b]
    pushing = [name for name, pushed in momentum.unprobed.items() if pushed[a : b + 1, column].any()]
    reasons = [f"wall '{name}' pushes along {axis} and is not probed" for name in pushing]
    if flow.scene.fixed is not None:
        reasons.append("the discs of a rough bed push, and no record has their force")
    if not flow.knows_contacts:
        reasons.append(f"{flow.no_contacts}, so that nothing tells whether other walls push")
    silent = [wall.name for wall in flow.scene.permanent if wall.name in flow.scene.probes and wall.name not in forces]
    reasons += [f"wall '{name}' has no force record" for name in silent]
    slack = 0.25 * flow.time_step or 1e-9
    walls = scale = 0.0
    for name, history in forces.items():
        lengths = window_lengths(history.time)
        inside = (history.time > start + slack) & (history.time <= end + slack)
        covered = float(lengths[inside].sum())
        if abs(covered - (end - start)) > 1e-6 * (end - start) + slack:
            reasons.append(f"the record of '{name}' covers {covered:z.4g} s of {end - start:z.4g} s")
        values = (history.fx, history.fy)[column]
        walls -= float(np.dot(values[inside], lengths[inside]))
        scale += float(np.dot(np.abs(values[inside]), lengths[inside]))
        if name in momentum.forces and flow.time_step:
            ends = momentum.forces[name][:, column]
            walls += 0.5 * flow.time_step * float(ends[a] - ends[b])
    between = slice(a + 1, b + 1)
    gravity = flow.scene.gravity[column] * flow.scene.mass * float(momentum.held[between].sum())
    change = float(momentum.momentum[b, column] - momentum.momentum[a, column])
    brought, carried = (float(part[between, column].sum()) for part in (momentum.brought, momentum.carried))
    off, scale = change - walls - gravity - brought + carried, scale + abs(brought) + abs(carried)
    relative, reason = abs(off) / scale if scale else nan, "; ".join(dict.fromkeys(reasons))
    begin, until = float(start), float(end)
    return Identity(
        axis, begin, until, change, walls, gravity, brought, carried, off, relative, not reason, reason or None,
    )  # fmt: skip


def _common_span(window_ends: np.ndarray, momentum: MomentumHistory, flow: Flow) -> tuple[int, int] | None:
    """First and last frame of the longest stretch the identity may use."""
    step = flow.time_step
    opened = max((flow.scene.time(gate.motion.gone) for gate in flow.scene.gates), default=-np.inf)
    slack = 0.25 * step or 1e-9
    gap = np.abs(momentum.time[:, None] - window_ends[None, :]).min(axis=1) if len(window_ends) else np.full(1, np.inf)
    lengths = window_lengths(window_ends)
    begin = window_ends[0] - lengths[0] if len(window_ends) else np.inf
    # the record may start at the first frame, with the window that ends later
    aligned = (gap <= slack) | (np.abs(momentum.time - begin) <= slack)
    usable = aligned & (momentum.time >= opened - slack)
    # a frame with other discs than the one before begins a new stretch
    frames, stretch = np.flatnonzero(usable), np.cumsum(~momentum.same)
    parts = np.split(frames, np.flatnonzero(np.diff(stretch[frames])) + 1)
    spans = [(int(part[0]), int(part[-1])) for part in parts if len(part) > 1]
    return max(spans, key=lambda span: momentum.time[span[1]] - momentum.time[span[0]], default=None)


def identity_sentence(identity: Identity) -> str:
    """One sentence for the report."""
    if not identity.complete:
        formed = "incomplete" if np.isfinite(identity.momentum_change) else "not formed"
        return f"Impulse identity along {identity.axis}: {formed}, {identity.reason}."
    given, who, whose = identity.wall_impulse + identity.gravity_impulse, "walls and gravity", "the walls'"
    if identity.brought_in or identity.carried_out:
        given, whose = given + identity.brought_in - identity.carried_out, "their"
        who = "walls, gravity and discs that came and went"
    return (
        f"Impulse identity along {identity.axis}, t = {identity.start:z.3f} to {identity.end:z.3f} s: the discs' "
        f"momentum changes by {identity.momentum_change:z.8g} N s/m, {who} give {given:z.8g} N s/m; they differ by "
        f"{identity.relative:z.1e} of {whose} total impulse."
    )
