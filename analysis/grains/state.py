# SPDX-License-Identifier: GPL-2.0-or-later
"""State at the end: how many discs, how fast they are, how much room they take; known of every flow."""

from __future__ import annotations

from dataclasses import dataclass
from math import nan, sqrt
from typing import Any

import numpy as np

from lammps_jump.analysis.contacts import ContactCollector
from lammps_jump.analysis.flow import Flow
from lammps_jump.analysis.passes import Gathered
from lammps_jump.analysis.quantity import Quantity
from lammps_jump.dump.frame import Frame
from lammps_jump.units import number

from .rest import RestWatch, rests

MIDDLE = (0.01, 0.99)
"""Shares of the discs between which the room is measured that they take: single discs fly ahead."""


@dataclass(frozen=True)
class DiscState:
    """The discs of the last frame that holds some; NaN where a dump has no velocities."""

    time: float = number("s", "time of the last frame with discs", default=nan)
    discs: int = number("", "discs in it", default=0)
    first_discs: int = number("", "discs in the first frame", default=0)
    speed: float = number("m/s", "median speed of the discs", default=nan)
    speed_over_root_gd: float = number("", "median speed over √(g d)", default=nan)
    along: float = number("m/s", "mean velocity along x, by mass", default=nan)
    mean_speed: float = number("m/s", "mean of the speeds, by mass", default=nan)
    length: float = number("m", "length along x that 98 % of the discs take", default=nan)
    height: float = number("m", "height that 98 % of the discs take", default=nan)
    rest_time: float = number("s", "time from which on the discs rest", default=nan)
    at_rest: bool | None = None
    """None where slow discs have not rested for 20 sqrt(d/g) yet (`rest.rests`)."""


class StateWatch(RestWatch):
    """Collects what rest asks for, and keeps the last frame with discs."""

    def __init__(self, flow: Flow, contacts: ContactCollector | None = None):
        super().__init__(flow, contacts)
        self.last: tuple[Frame | None, float] = (None, nan)
        self.first = -1

    def add(self, frame: Frame, time: float) -> None:
        """Take in a frame at a time, s."""
        super().add(frame, time)
        self.first = frame.n if self.first < 0 else self.first
        if frame.n:
            self.last = frame, time

    def result(self) -> StateWatch:  # type: ignore[override]
        """All that was taken in."""
        return self


def analyse(gathered: Gathered) -> DiscState:
    """Numbers of the last frame that holds discs."""
    flow, watch = gathered.flow, gathered.histories["state"]
    assert isinstance(watch, StateWatch)
    frame, time = watch.last
    if frame is None:
        return DiscState()
    radii, mass = flow.radii(frame), flow.relative_masses(frame)
    room = [float(np.diff(np.quantile(place, MIDDLE))[0] + 2.0 * radii.mean()) for place in (frame.x, frame.y)]
    known: dict[str, Any] = {"time": time if flow.timed else nan, "discs": frame.n, "first_discs": watch.first}
    known |= {"length": room[0], "height": room[1]}
    speeds = np.hypot(frame.vx, frame.vy)
    is_known = np.isfinite(speeds)
    if not is_known.any():
        return DiscState(**known)
    speeds, mass = speeds[is_known], mass[is_known]
    median = float(np.median(speeds))
    rest = RestWatch.result(watch)
    return DiscState(
        **known,
        speed=median,
        speed_over_root_gd=median / sqrt(flow.g * flow.scene.diameter) if flow.g > 0 else nan,
        along=float(np.average(frame.vx[is_known], weights=mass)),
        mean_speed=float(np.average(speeds, weights=mass)),
        rest_time=rest.begin if flow.g > 0 and flow.timed else nan,
        at_rest=rests(rest, flow),
    )


QUANTITY = Quantity(
    name="state",
    title="State at the end",
    result=DiscState,
    definitions="""\
speed         median of the discs of the last frame that holds some;  along: mean velocity along x, by mass
room          length and height that 98 % of the discs take;  rest: as in the section on rest
""",
    always=lambda _: True,
    collector=StateWatch,
    analyse=analyse,
)
