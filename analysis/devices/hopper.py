# SPDX-License-Identifier: GPL-2.0-or-later
"""A hopper that empties: mass of discs that pass its slot in a second.

The slot is the narrowest gap between walls that stand, left and right of the middle of the discs at the start. The
discharge is the slope of the mass above it against time, a straight line over the window.
"""

# ruff: noqa: RUF001  (Greek letters, minus signs and dashes are meant for readers)
from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import inf, isfinite, nan
from typing import NamedTuple

import numpy as np

from lammps_jump.analysis.contacts import ContactCollector
from lammps_jump.analysis.draw.chart import TIME, Chart, Drawings, Line, Panel
from lammps_jump.analysis.flow import Flow
from lammps_jump.analysis.passes import Gathered, Tables
from lammps_jump.analysis.profiles import window_of, within
from lammps_jump.analysis.report.page import Section, Table, described, percent
from lammps_jump.dump.frame import Frame
from lammps_jump.physics import devices
from lammps_jump.scene.chains import X0, X1, Y0, Y1
from lammps_jump.scene.scene import Scene
from lammps_jump.units import number

PIECE = 0.05
"""Share of the record over which the discharge at a time is taken."""


class Slot(NamedTuple):
    """Left and right edge and height of a slot, m."""

    left: float
    right: float
    y: float


@dataclass(frozen=True)
class Hopper:
    """Discs that leave a hopper, over the window."""

    discharge: float = number("kg/s/m", "mass of discs through the slot in a second", default=nan, label="discharge")
    change: float = number(
        "", "discharge of the second half of the window over that of the first, less one", default=nan
    )
    slot: float = number("m", "width of the slot", default=nan)
    beverloo: float = number(
        "", "discharge over ρ √g (D − 1.4 d)^1.5, after Beverloo", default=nan, label="over ρ √g (D − 1.4 d)^1.5"
    )
    left: float = number("", "share of the mass that is left above the slot at the end of the window", default=nan)
    reason: str | None = None
    time: np.ndarray | None = field(default=None, metadata={"summary": False})
    mass: np.ndarray | None = field(default=None, metadata={"summary": False})


def narrowest(shape: np.ndarray, middle: float) -> Slot | None:
    """The narrowest gap around x = middle (m) between straight faces; the highest of equal ones; None for none.

    Parameters
    ----------
    shape : ndarray, shape (faces, 15)
        Of `Faces`; arcs count with their chords.
    middle : float
    """
    faces = shape[np.isfinite(shape[:, [X0, Y0, X1, Y1]]).all(axis=1)]
    best: Slot | None = None
    for y in sorted(set(faces[:, [Y0, Y1]].ravel()), reverse=True):
        left, right = -inf, inf
        for x0, y0, x1, y1 in faces[:, [X0, Y0, X1, Y1]]:
            if not min(y0, y1) <= y <= max(y0, y1):
                continue
            ends = (x0, x1) if y0 == y1 else (x0 + (x1 - x0) * (y - y0) / (y1 - y0),)
            left = max([left, *(x for x in ends if x <= middle)])
            right = min([right, *(x for x in ends if x > middle)])
        gap = right - left
        if isfinite(gap) and (best is None or gap < (best.right - best.left) * (1.0 - 1e-9)):
            best = Slot(left, right, float(y))
    return best


def slot_of(scene: Scene) -> Slot | None:
    """Slot of a scene of discs that leave and of none that enter; None where there is none."""
    if scene.inlets or scene.pours or not scene.outlets or not len(scene.positions):
        return None
    shapes = [wall.faces.shape for wall, motion in scene.walls if motion.kind is None and isfinite(wall.extent[0][0])]
    return narrowest(np.concatenate(shapes), float(scene.positions[:, 0].mean())) if shapes else None


class MassAbove:
    """Collects the mass of the discs above the slot, frame by frame."""

    def __init__(self, flow: Flow, _: ContactCollector | None = None):
        self.flow, self.slot = flow, slot_of(flow.scene)
        self._rows: list[tuple[float, float]] = []

    def add(self, frame: Frame, time: float) -> None:
        """Take in a frame at a time, s."""
        if self.slot is not None:
            above = self.flow.relative_masses(frame)[frame.y > self.slot.y]
            self._rows.append((time, self.flow.scene.mass * float(above.sum())))

    def result(self) -> np.ndarray:
        """Times (s) and masses (kg/m), shape (frames, 2)."""
        return np.array(self._rows, float).reshape(-1, 2)


def analyse(gathered: Gathered) -> Hopper:
    """Discharge of a hopper; with a reason where the scene is none."""
    flow, scene = gathered.flow, gathered.flow.scene
    slot = slot_of(scene)
    if slot is None or flow.gravity <= 0:
        return Hopper(reason="no slot between standing walls with an outlet behind it, and without inflow")
    time, mass = gathered.histories["hopper"].T
    window = window_of(gathered.profiles)
    inside = within(time, window)
    width = slot.right - slot.left
    if inside.sum() < 4:
        return Hopper(slot=width, reason="the window holds fewer than four frames", time=time, mass=mass)
    t, m = time[inside], mass[inside]
    half = len(t) // 2
    discharge = -float(np.polyfit(t, m, 1)[0])
    first, second = (-float(np.polyfit(t[part], m[part], 1)[0]) for part in (slice(half), slice(half, None)))
    narrow = width <= devices.BEVERLOO_K * scene.diameter
    return Hopper(
        discharge,
        second / first - 1.0 if first > 0 else nan,
        width,
        nan if narrow else devices.beverloo_number(discharge, width, scene.diameter, scene.density, flow.gravity),
        float(m[-1] / mass[0]) if mass[0] > 0 else nan,
        time=time,
        mass=mass,
    )


def discharge_over_time(time: np.ndarray, mass: np.ndarray) -> np.ndarray:
    """Discharge against time, kg/s/m: mass lost over a `PIECE` of the record around each frame; NaN at its ends.

    Parameters
    ----------
    time : ndarray, shape (frames,), s
    mass : ndarray, shape (frames,), kg/m
    """
    found, reach = np.full(len(time), nan), max(1, round(0.5 * PIECE * len(time)))
    if len(time) > 2 * reach:
        found[reach:-reach] = (mass[: -2 * reach] - mass[2 * reach :]) / (time[2 * reach :] - time[: -2 * reach])
    return found


def tables(hopper: Hopper) -> Tables:
    """Mass above the slot, kg/m, and discharge, kg/s/m, against time."""
    if hopper.time is None or hopper.mass is None:
        return {}
    columns = {"time": hopper.time, "mass": hopper.mass}
    return {"hopper.csv": columns | {"discharge": discharge_over_time(hopper.time, hopper.mass)}}


def figures(hopper: Hopper, gathered: Gathered) -> Drawings:
    """Mass above the slot, and the discharge, against time."""
    if hopper.time is None or hopper.mass is None:
        return {}
    rate = discharge_over_time(hopper.time, hopper.mass)
    mean = {"mean of the window": hopper.discharge / 1e3} if isfinite(hopper.discharge) else {}
    panels = (
        Panel("Mass above the\nslot [t/m]", [Line("", hopper.time, hopper.mass / 1e3)]),
        Panel("Discharge\n[t/s per metre]", [Line("", hopper.time, rate / 1e3)], levels=mean, ylim=(0.0, None)),
    )
    return {"hopper": Chart("hopper", TIME, panels)}


def section(hopper: Mapping) -> Section:
    """Discharge, slot and steadiness."""
    if hopper.get("discharge") is None:
        return Section("Hopper", [])
    rows = described(Hopper, hopper, "discharge", "slot", "beverloo")
    if hopper.get("change") is not None:
        rows.append(("Change from the first half of the window to the second", percent(hopper["change"])))
    return Section("Hopper", [Table(rows)])
