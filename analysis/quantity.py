# SPDX-License-Identifier: GPL-2.0-or-later
"""Quantity: one analysis of a run, and all that the program says of it.

The file of each analysis ends with its `QUANTITY`; `quantities.py` lists these files. Summary, report, screen, tables
of a study, Python and the pages of the site ask it for what they show.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from lammps_jump.units import as_summary, from_summary, numbers_of

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr

    from .contacts import ContactCollector
    from .draw.chart import Drawings
    from .flow import Flow
    from .passes import Collector, Gathered, Tables
    from .report.page import Section

NONE: Mapping[str, Any] = MappingProxyType({})
Need = Literal["contacts", "thrust", "slope", "forces"]


class HeadlineNumber(NamedTuple):
    """A number for the top of page and screen, and that of theory which it is held against.

    Attributes
    ----------
    key : str
        Of the number, a path within the quantity; ``*`` represents the names of structures.
    words, other : str
        What theory is, and the path of its number within the quantity. Without a path there are only the words.
    source : str
        Equation of theory, shown where a page is pointed at.
    label : str
        In place of the meaning of the number.
    scale, unit : float, str or None
        In place of those of the description.
    plain : bool
        The difference has the unit of both; else it is a share of theory.
    holds : str
        What theory is of, for flows to which it does not apply. Lengths have none: discs make a short jump, and the
        page says so next to them.
    rank : int or None
        In place of the rank of the quantity.
    result : type or None
        What describes the number, where that is not the result of the quantity.
    """

    key: str
    words: str = ""
    other: str = ""
    label: str = ""
    scale: float = 1.0
    unit: str | None = None
    plain: bool = False
    holds: str = ""
    rank: int | None = None
    result: type | None = None
    source: str = ""


class Marks(NamedTuple):
    """Marks of a result in the figures of the profiles.

    Attributes
    ----------
    lines : dict of label to depth, m
    places : dict of label to x, m
    track : (ndarray, ndarray) or None
        Places (m) and times (s) of the toe of a jump.
    """

    lines: Mapping[str, float] = NONE
    places: Mapping[str, float] = NONE
    track: tuple[np.ndarray, np.ndarray] | None = None


class Named(NamedTuple):
    """Says that a quantity has a result for each of several walls, by their names.

    Attributes
    ----------
    what, remedy : str
        What such a wall is, and how a case gets one.
    walls : str
        Attribute of a case that holds their names.
    path : str
        Where a result is, on the page of all numbers.
    """

    what: str
    remedy: str
    walls: str
    path: str


@dataclass(frozen=True, kw_only=True)
class Quantity:
    """One analysis of a run.

    Attributes
    ----------
    name : str
        Its key in ``summary.json``, and its field of ``analysis`` in a case that may ask for it.
    title : str
        Of its section on the page of all numbers.
    result : type
        Its numbers, described; labelled ones are shown on the screen.
    definitions : str
        What its numbers mean: a word, two spaces or more, a text; for the report and the page of all numbers.
    beside : str
        Definitions that the page of all numbers has too.
    analyse : callable(Gathered) -> result, or None where there is nothing to be said
    collector : callable(flow, contacts) -> Collector, or None
        Takes in the frames; None where profiles and contacts are enough.
    always : callable(flow) -> bool, or None
        Whether a flow has it without a request; None: never.
    needs : set of {'contacts', 'thrust', 'slope', 'forces'}
        What is gathered for it: sums over contacts, their thrust in the bins of the profiles, a slope as if it were
        level, ``forces.csv``.
    files, captions : mapping of str to str
        What each CSV table holds, and the caption of each figure, by their names; in the order of the report.
    tables, datasets, figures, section : callable
        CSV tables and netCDF files of the result by their names, what figures show of result and `Gathered`, section of
        the report.
    linked : str
        Its figure over time that is below the player and shows the time of it; empty where there is none.
    marked : str
        Its figure that shows the places which results mark, as the depth profile does; empty where there is none.
    marks, notes : callable(result)
        What figures of the profiles show of it; sentences for the warnings.
    summary, reads : callable
        A result as it is in ``summary.json``, and the result that is there; of walls by their names, where it
        is `named`.
    headline : tuple of HeadlineNumber
        Numbers for the top of page and screen.
    rank : int
        Place of these among those of other quantities; small ones come first.
    is_shown : callable(HeadlineNumber, summary) -> bool
        Whether such a number is shown.
    compares : callable(HeadlineNumber, name, summary) -> bool
        Whether such a number is held against theory, of the structure of this name.
    label_values : callable(summary) -> mapping
        What the blanks of their labels are filled with.
    structures : callable(key, summary) -> mapping
        Names that replace ``*``, with the component of the force there.
    applies : callable(key, result) -> bool
        Whether a number belongs to the result: no length of a jump where there is none.
    shown : callable(summary) -> bool
        Whether page and screen show the quantity.
    defined : callable(summary) -> str
        Definitions that the report shows after `definitions`.
    line : callable(summary) -> str
        A line below the numbers at the top; empty where there is none.
    errors : callable(result) -> sequence of (str, result or None)
        Results whose standard errors the report lists, with the name of their wall.
    certainty : callable(result) -> tuple of str
        How sure these numbers are, as paragraphs below the table of errors.
    named : Named or None
    kind : str
        Field of a result of a wall that tells of which kind it is, or a number that some have; means over starts are of
        the commonest.
    parts : mapping of str to type
        What is in ``summary.json`` besides the results of the walls, by its key.
    """

    name: str
    title: str
    result: type
    definitions: str
    analyse: Callable[[Gathered], Any]
    beside: str = ""
    collector: Callable[[Flow, ContactCollector | None], Collector] | None = None
    always: Callable[[Flow], bool] | None = None
    needs: frozenset[Need] = frozenset()
    files: Mapping[str, str] = field(default_factory=dict)
    captions: Mapping[str, str] = field(default_factory=dict)
    tables: Callable[[Any], Tables] = lambda _: {}
    datasets: Callable[[Any], Mapping[str, xr.Dataset]] = lambda _: NONE
    figures: Callable[[Any, Gathered], Drawings] = lambda *_: {}
    marked: str = ""
    linked: str = ""
    section: Callable[[Any], Section | None] = lambda _: None
    marks: Callable[[Any], Marks] = lambda _: Marks()
    notes: Callable[[Any], Sequence[str]] = lambda _: ()
    summary: Callable[[Any], dict[str, object]] = as_summary
    reads: Callable[[Mapping[str, Any]], Any] | None = None
    headline: tuple[HeadlineNumber, ...] = ()
    rank: int = 1000
    is_shown: Callable[[HeadlineNumber, Mapping[str, Any]], bool] = lambda *_: True
    compares: Callable[[HeadlineNumber, str, Mapping[str, Any]], bool] = lambda *_: True
    label_values: Callable[[Mapping[str, Any]], Mapping[str, str]] = lambda _: NONE
    structures: Callable[[str, Mapping[str, Any]], Mapping[str, str]] = lambda *_: NONE
    applies: Callable[[str, Any], bool] = lambda *_: True
    shown: Callable[[Mapping[str, Any]], bool] = lambda _: True
    defined: Callable[[Mapping[str, Any]], str] = lambda _: ""
    line: Callable[[Mapping[str, Any]], str] = lambda _: ""
    errors: Callable[[Any], Sequence[tuple[str, object]]] = lambda _: ()
    certainty: Callable[[Any], tuple[str, ...]] = lambda _: ()
    named: Named | None = None
    kind: str = ""
    parts: Mapping[str, Any] = field(default_factory=dict)

    def read(self, part: Mapping[str, Any]) -> Any:
        """The result that is in its part of a summary; of walls by their names, where it is `named`."""
        if self.reads is not None:
            return self.reads(part)
        return self.walls(part) if self.named else from_summary(self.result, part)

    def walls(self, part: Mapping[str, Any]) -> dict[str, Any]:
        """The results of walls by their names, or the one result under no name."""
        if self.named is None:
            return {"": from_summary(self.result, part)}
        parts = {name: one for name, one in part.items() if isinstance(one, Mapping) and name not in self.parts}
        return {name: from_summary(self.result, one) for name, one in parts.items()}

    def meaning(self, wanted: HeadlineNumber) -> tuple[str, str]:
        """Meaning and unit of a number for the top of the page."""
        number = numbers_of(wanted.result or self.result)[wanted.key.rpartition(".")[2]]
        return wanted.label or number.meaning, number.unit if wanted.unit is None else wanted.unit
