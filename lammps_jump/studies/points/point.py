# SPDX-License-Identifier: GPL-2.0-or-later
"""A point of a study, and the study itself: its points, what is made of what they found, its page."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from lammps_jump.runs.run import Case
from lammps_jump.sweeps import Results

FAILED = "failed"
"""Key of a measurement that there is not, with the reason."""
Measure = Callable[..., object]
Found = Mapping[str, Sequence[Mapping[str, Any]]]
"""What was measured: by the name of a point, what the measuring function returned for each of its starts."""


@dataclass(frozen=True)
class Point:
    """One set of values, at which a law or another study is measured.

    Attributes
    ----------
    name : str
        Unique in its study.
    measure : str or callable
        Function at the top level of a module of the program, or name of one in ``measure.py`` of the study's folder.
        With a case it is called ``measure(run, **options)``, else ``measure(**options)``. It returns a dict of plain
        data.
    case : str, Case or None
        Case file, relative to the study's folder, or a case; None for a function without a run.
    changes : mapping
        Values of the case that this point changes, as ``--set``.
    starts : int
        Runs with their discs moved by 1e-6 diameters; 1 for a function.
    options : mapping
        Plain data, handed to the function by name.
    seconds : float
        Processor time of one start, about; weighs the line of progress.
    seed : int
        Of the first start; the others follow.
    dump : bool
        Whether the function reads the dump: a finished run without one is run again.
    judged : bool
        A run or call that fails is a finding too, ``{FAILED: reason}``, and is kept; else it is told and tried again.
    patience : float
        s that one start may take.
    """

    name: str
    measure: str | Measure
    case: str | Case | None = None
    changes: Mapping[str, Any] = field(default_factory=dict)
    starts: int = 1
    options: Mapping[str, Any] = field(default_factory=dict)
    seconds: float = 1.0
    seed: int = 1
    dump: bool = True
    judged: bool = False
    patience: float = float("inf")

    @property
    def measure_name(self) -> str:
        """Name of the measuring function."""
        return self.measure if isinstance(self.measure, str) else self.measure.__name__


@dataclass(frozen=True)
class PointStudy:
    """A study with tables and a page in Markdown.

    Attributes
    ----------
    name : str
        Of its files: ``<name>.json``, ``<name>.md``, pictures ``<name>_*.png``.
    points : sequence of Point
    results : callable
        ``results(found, stored)``: what stands in its JSON file; `stored` is what stands there already. Pure.
    page : callable
        ``page(results)``: paragraphs of its page in Markdown. Pure.
    draw : callable
        ``draw(results, folder)``: draws its figures.
    told : callable
        ``told(point, start, measured)``: a line on a start, counted from 1; an empty one is not shown.
    opening : sequence of str
        Lines that are told first.
    ending : callable
        ``ending(results)``: lines that are told last.
    timed : bool
        Run one start at a time, and each point once before any again: they are timed.
    """

    name: str
    points: Sequence[Point]
    results: Callable[[Found, Results], Results]
    page: Callable[[Results], Sequence[str]]
    draw: Callable[[Results, Path], object] = lambda results, folder: None
    told: Callable[[Point, int, Any], str] = lambda point, start, measured: ""
    opening: Sequence[str] = ()
    ending: Callable[[Results], Sequence[str]] = lambda results: ()
    timed: bool = False
