# SPDX-License-Identifier: GPL-2.0-or-later
"""Sizes of the discs that were drawn, as a grading curve by mass, and the requested curve.

Discs of rough beds do not count, nor those that an earlier run brought: their sizes are not drawn.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import nan
from typing import Any

import numpy as np

from lammps_jump.analysis.contacts import ContactCollector
from lammps_jump.analysis.draw.chart import Chart, Drawings, Panel, Trace
from lammps_jump.analysis.flow import Flow
from lammps_jump.analysis.passes import Gathered, Tables
from lammps_jump.analysis.quantity import Quantity
from lammps_jump.analysis.report.page import Section, Table, described
from lammps_jump.dump.frame import Frame
from lammps_jump.scene.sizes import Sizes
from lammps_jump.units import number

SAMPLED = 201
"""Diameters at which the curves are shown, evenly in their logarithm, besides the ends of the pieces."""


@dataclass(frozen=True)
class SizeCurve:
    """The curve of the drawn discs and the requested one.

    Attributes
    ----------
    diameter : ndarray, shape (k,), m
    asked, drawn : ndarray, shape (k,)
        Part of the mass that is in discs not larger.
    error : ndarray, shape (k,)
        Counting error of as many discs drawn at random.
    """

    diameter: np.ndarray
    asked: np.ndarray
    drawn: np.ndarray
    error: np.ndarray


@dataclass(frozen=True)
class DrawnSizes:
    """Sizes of the discs that were drawn, by mass."""

    discs: int = number("", "discs whose size was drawn", default=0)
    d10: float = number("m", "size d10 of the drawn discs, by mass", default=nan)
    d50: float = number("m", "size d50 of the drawn discs, by mass", default=nan, label="d50, by mass")
    d90: float = number("m", "size d90 of the drawn discs, by mass", default=nan)
    uniformity: float = number("", "uniformity d60/d10 of the drawn discs", default=nan)
    d50_asked: float = number("m", "size d50 of the curve that was asked for", default=nan)
    difference: float = number("", "largest difference of the two curves, of the mass", default=nan)
    error: float = number("", "counting error of the curve there, as of discs drawn at random", default=nan)
    reason: str | None = None
    curve: SizeCurve | None = field(default=None, metadata={"summary": False})


class HighestId:
    """Collects the highest id of all frames: ids are given in turn, so that all below it were drawn."""

    def __init__(self, flow: Flow, _: ContactCollector | None = None):
        self.flow, self.highest = flow, 0

    def add(self, frame: Frame, time: float) -> None:
        """Take in a frame at a time, s."""
        self.highest = max(self.highest, int(frame.ids.max(initial=0)))

    def result(self) -> int:
        """The highest id."""
        return self.highest


def drawn(sizes: Sizes, highest: int) -> np.ndarray:
    """Diameters of the ids up to the highest that were drawn, m, in rising order."""
    ids = np.arange(1 + len(sizes.given), highest + 1)
    for first, last, _ in sizes.own:
        ids = ids[(ids < first) | (ids > last)]
    return np.sort(sizes.diameters(ids))


def curve_of(diameters: np.ndarray, sizes: Sizes) -> SizeCurve:
    """The curve of diameters (m, rising) and the one that they were drawn from."""
    ends = np.unique([*sizes.low, *sizes.high])
    at = np.unique(np.concatenate([ends, np.geomspace(ends[0], ends[-1], SAMPLED)]))
    mass = np.concatenate([[0.0], np.cumsum(diameters**2)])
    passing = mass[np.searchsorted(diameters, at, side="right")] / mass[-1]
    return SizeCurve(at, sizes.passing(at), passing, sizes.passing_error(at, len(diameters)))


def analyse(gathered: Gathered) -> DrawnSizes | None:
    """Sizes of the discs of a run, with a reason where none was drawn; None without a grading curve."""
    sizes, highest = gathered.flow.scene.sizes, gathered.histories.get("sizes")
    if sizes is None or not isinstance(highest, int):
        return None
    diameters = drawn(sizes, highest)
    if not len(diameters):
        return DrawnSizes(reason="no disc was drawn from the curve: all come from an earlier run or from beds")
    mass = np.cumsum(diameters**2)
    d10, d50, d60, d90 = diameters[np.searchsorted(mass, np.array([0.1, 0.5, 0.6, 0.9]) * mass[-1])].tolist()
    curve = curve_of(diameters, sizes)
    off = np.abs(curve.drawn - curve.asked)
    worst = int(np.argmax(off))
    return DrawnSizes(
        len(diameters), d10, d50, d90, d60 / d10, sizes.diameter_at(0.5), float(off[worst]), float(curve.error[worst]),
        curve=curve,
    )  # fmt: skip


def tables(sizes: DrawnSizes) -> Tables:
    """The curves, a row a diameter."""
    return {} if sizes.curve is None else {"sizes.csv": vars(sizes.curve)}


def figures(sizes: DrawnSizes, gathered: Gathered) -> Drawings:
    """The two curves over the diameter."""
    curve = sizes.curve
    if curve is None:
        return {}
    traces = [
        Trace(f"drawn, {sizes.discs} discs", curve.diameter, 100 * curve.drawn),
        Trace("asked, ± two counting errors", curve.diameter, 100 * curve.asked, "second", 100 * curve.error),
    ]
    return {"sizes": Chart("grading curve", "Diameter d [m]", [Panel("Passing\nby mass [%]", traces, ylim=(0, 100))])}


def section(sizes: DrawnSizes) -> Section:
    """Sizes by mass."""
    if not sizes.discs:
        return Section("Sizes", [])
    keys: Any = ("discs", "d10", "d50", "d90", "uniformity", "d50_asked", "difference", "error")
    return Section("Sizes", [Table(described(sizes, *keys))])


def has_curve(flow: Flow) -> bool:
    """Tells whether the scene has a grading curve."""
    return flow.scene.sizes is not None and flow.scene.sizes.is_curve


QUANTITY = Quantity(
    name="sizes",
    title="Sizes",
    result=DrawnSizes,
    definitions="""\
passing         part of the mass that is in discs not larger; the mass of a disc goes with d²
d10, d50, d90   diameters that 10, 50 and 90 % of the mass are not larger than
counting error  standard error of the curve of so many discs drawn at random; ids draw them more evenly
""",
    collector=HighestId,
    always=has_curve,
    analyse=analyse,
    files={"sizes.csv": "grading curve of the discs beside the one asked for"},
    captions={"sizes": "Grading curve of the discs that were drawn, by mass, beside the one asked for"},
    tables=tables,
    figures=figures,
    section=section,
)
