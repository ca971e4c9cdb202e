# SPDX-License-Identifier: GPL-2.0-or-later
"""Parts of a law: points that are run or computed, rows that hold them against published values, a figure."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import isfinite, nan
from pathlib import Path
from typing import Literal

from matplotlib.figure import Figure

from lammps_jump.errors import CaseError
from lammps_jump.studies.points import Found as Found
from lammps_jump.studies.points import Point as Point
from lammps_jump.studies.points.find import LAW_FILE, load_module, source_of
from lammps_jump.sweeps.table import mean_of as mean_of

LOOKED_UP, SECOND_HAND, DERIVED, MEASURED = "looked up", "second hand", "derived here", "measured by us"
KINDS = (LOOKED_UP, SECOND_HAND, DERIVED, MEASURED)
"""Where a published value comes from: read at its source, quoted by another text, derived in our documents, measured
with this program before."""
Verdict = Literal["met", "near", "not met", "fit"]


@dataclass(frozen=True)
class Row:
    """One quantity: the published value, ours, and what is accepted.

    Attributes
    ----------
    quantity : str
        With its unit.
    published : float, str or None
        A number, or words (``rises``); None where no number was found, and then there are no limits.
    kind : str
        Of `KINDS`; empty without a published value.
    source : str
        Where the published value stands.
    ours, interval : float
        Mean over the starts, and half of its 95 % interval (NaN where there is one start), as `mean_of` gives them.
    limits : (float, float) or None
        Values of ours that meet the law, as `around` gives them; None: no gate, the row is a fit.
    reason : str
        Why these limits, or why there is no gate.
    why : str
        What explains a value outside; shown where the law is not met.
    """

    quantity: str
    published: float | str | None
    kind: str
    source: str
    ours: float
    interval: float = nan
    limits: tuple[float, float] | None = None
    reason: str = ""
    why: str = ""

    def __post_init__(self) -> None:
        if self.published is None and self.limits is not None:
            raise ValueError(f"{self.quantity}: limits without a published value; leave both out, or give both")
        if self.published is not None and self.kind not in KINDS:
            raise ValueError(f"{self.quantity}: kind is {self.kind!r}; allowed are {', '.join(KINDS)}")
        if not self.reason:
            raise ValueError(f"{self.quantity}: reason is empty; say why these limits, or why none")

    @property
    def verdict(self) -> Verdict:
        """'met' inside the limits, 'near' where only the interval reaches them, 'fit' without limits."""
        if self.limits is None:
            return "fit"
        low, high = self.limits
        if not isfinite(self.ours):
            return "not met"
        if low <= self.ours <= high:
            return "met"
        half = self.interval if isfinite(self.interval) else 0.0
        return "near" if self.ours + half >= low and self.ours - half <= high else "not met"

    @property
    def distance(self) -> float:
        """Ours over the published value minus 1; the plain difference from 0; NaN where it is no number."""
        if not isinstance(self.published, int | float):
            return nan
        return self.ours / self.published - 1 if self.published else self.ours


@dataclass(frozen=True)
class Law:
    """A law: ``LAW`` in ``law.py`` of its folder.

    Attributes
    ----------
    title : str
    question : str
        One sentence.
    points : callable
        ``points(quick)``: what is run. Quick: fewer or shorter runs, seconds in all.
    rows : callable
        ``rows(found)``: what was measured, held against what is published. Pure.
    figure : callable
        ``figure(found)``: a matplotlib figure without pyplot, readable in grey, with units. Pure.
    notes : tuple of str
        Paragraphs for the page: what is stated, what is left out and why.
    table : callable, optional
        ``table(found)``: heads and rows of a table below the figure. Pure.
    """

    title: str
    question: str
    points: Callable[[bool], Sequence[Point]]
    rows: Callable[[Found], Sequence[Row]]
    figure: Callable[[Found], Figure]
    notes: tuple[str, ...] = ()
    table: Callable[[Found], Sequence[Sequence[str]]] | None = None


def around(value: float, share: float = 0.0, *, by: float = 0.0) -> tuple[float, float]:
    """Limits around a value: a share of its size, and `by` in its unit."""
    half = abs(value) * share + by
    return value - half, value + half


def laws_folder(given: Path | None = None) -> Path:
    """Return the folder of the laws: the given one, else that of the source tree; errors as of `source_of`."""
    return source_of("the laws", f"*/{LAW_FILE}", given)


def find_laws(folder: Path, names: Sequence[str] | None = None) -> dict[str, Law]:
    """Return the laws of a folder by name, those that are named or all.

    Raises
    ------
    CaseError
        A name that is not known.
    """
    known = sorted(path.parent.name for path in folder.glob(f"*/{LAW_FILE}"))
    for name in names or ():
        if name not in known:
            raise CaseError(f"there is no law '{name}'; laws in {folder}: {', '.join(known)}")
    return {name: load_law(folder / name) for name in dict.fromkeys(names or known)}


def load_law(folder: Path) -> Law:
    """Return the law of a folder; CaseError where its ``law.py`` names none."""
    law = getattr(load_module(folder, "law"), "LAW", None)
    if not isinstance(law, Law):
        raise CaseError(f"{folder / LAW_FILE}: has no LAW; docs/validation.md says how a law is written")
    return law
