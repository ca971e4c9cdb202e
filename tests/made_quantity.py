# SPDX-License-Identifier: GPL-2.0-or-later
"""A quantity that the program does not have: the height over which discs are spread. It is told by this file alone."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import nan
from typing import Any

import numpy as np

from lammps_jump.analysis.draw.chart import TIME, Chart, Panel, Trace
from lammps_jump.analysis.flow import Flow
from lammps_jump.analysis.passes import Gathered
from lammps_jump.analysis.quantity import HeadlineNumber, Quantity
from lammps_jump.analysis.report.page import Section, Table, described
from lammps_jump.analysis.statistics import Mean, as_fields, mean_of
from lammps_jump.dump.frame import Frame
from lammps_jump.units import Estimates, estimate


@dataclass(frozen=True)
class Spread(Estimates):
    """Height from the lowest disc to the highest."""

    height: float = estimate("m", "height that the discs are spread over", label="spread")
    reason: str | None = None
    tables: dict[str, np.ndarray] = field(default_factory=dict, metadata={"summary": False})


class SpreadWatch:
    """Collects the height, frame by frame."""

    def __init__(self, flow: Flow, _: Any):
        self.flow, self.rows = flow, list[tuple[float, float]]()

    def add(self, frame: Frame, time: float) -> None:
        """Take in a frame at a time, s."""
        self.rows.append((time, float(np.ptp(frame.y)) if frame.n else nan))

    def result(self) -> np.ndarray:
        """Times and heights."""
        return np.array(self.rows).T


def analyse(gathered: Gathered) -> Spread:
    """Mean of the record."""
    time, height = gathered.histories["spread"]
    if np.isnan(height).all():
        return Spread(reason="no frame holds a disc")
    found = mean_of(height)
    return Spread(**as_fields(height=Mean(found.value, found.error)), tables={"time": time, "height": height})


QUANTITY = Quantity(
    name="spread",
    title="Spread",
    result=Spread,
    definitions="spread    from the lowest disc to the highest\n",
    collector=SpreadWatch,
    analyse=analyse,
    files={"spread.csv": "height of the discs against time"},
    captions={"spread": "Height of the discs"},
    tables=lambda spread: {"spread.csv": spread.tables},
    figures=lambda spread, _: {"spread": Chart("spread", TIME, [Panel("m", [Trace("", *spread.tables.values())])])},
    section=lambda spread: Section("Spread", [Table(described(spread, "height"))]),
    headline=(HeadlineNumber("height", "asked", rank=1),),
    errors=lambda spread: [("", spread)],
)
