# SPDX-License-Identifier: GPL-2.0-or-later
"""Laws of dense flows held against runs: a law, the study of all of them, and its page."""

from __future__ import annotations

import re
import subprocess
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from math import ceil, isfinite, isinf, log10, nan
from pathlib import Path
from typing import Any, Literal

from matplotlib.figure import Figure

from lammps_jump.analysis.draw.style import save
from lammps_jump.analysis.report.page import Items, Mark, Section, Table, Text, picture, render
from lammps_jump.analysis.tables import markdown, paragraphs
from lammps_jump.errors import CaseError
from lammps_jump.files import plain, write_json, write_text
from lammps_jump.folders import require_no_link
from lammps_jump.provenance import machine, usable_cores
from lammps_jump.sweeps import Pool, Results, Store, SweepProgress, all_versions
from lammps_jump.sweeps.table import mean_of as mean_of
from lammps_jump.units import shown

from .points import (
    FAILED,
    LAW_FILE,
    Found,
    StartJob,
    failures_of,
    forget,
    found_of,
    held_folder,
    load_module,
    measure,
    pieces_of,
    source_of,
)
from .points import Point as Point

LOOKED_UP, SECOND_HAND, DERIVED, MEASURED = "looked up", "second hand", "derived here", "measured by us"
KINDS = (LOOKED_UP, SECOND_HAND, DERIVED, MEASURED)
"""Sources of a published value: read at its source, quoted by another text, derived in our documents, measured
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
        A number, or words (``rises``); None where the source has no number, and then there are no limits.
    kind : str
        Of `KINDS`; empty without a published value.
    source : str
        Where the published value is from.
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


# --- the page of a validation, made from ``validation.json`` alone: one table at its top, then a section a law --------


ABSENT = "—"
UNKNOWN = "not known"
"""Said of a value outside whose law does not explain it."""
PARTS = 100
"""A value without an interval is cut to this part of the accepted range: finer digits decide nothing."""
PLAIN = 4
"""Decimal places up to which a zero is written with its places."""
Data = Mapping[str, Any]


def number(value: float | str | None) -> str:
    """A number with four digits, words as they are."""
    if value is None:
        return ABSENT
    return value if isinstance(value, str) else typeset(shown(float(value)))


def typeset(text: str) -> str:
    """A number with a minus sign, and an exponent without zeros before it."""
    return re.sub(r"e([+-])0*(\d)", r"e\1\2", text).replace("e+", "e").replace("-", "−")  # noqa: RUF001


def ours_text(row: Data) -> str:
    """Our value, cut to its interval; without one, to a small part of the accepted range."""
    if row["ours"] is None:
        return ABSENT
    if (row["interval"] or nan) > 0:
        return typeset(shown(row["ours"], error=row["interval"]))
    low, high = row["limits"] or (None, None)
    if low is None or high is None or isinf(high - low):
        return number(row["ours"])
    places = max(0, -ceil(log10((high - low) / PARTS)))
    rounded = round(row["ours"], places)
    if places > PLAIN and not rounded:
        return f"below {typeset(f'{10.0**-places:z.0e}')}"
    return typeset(f"{rounded:z.{places}f}" if abs(rounded) >= 1e-3 or not rounded else shown(rounded, digits=2))


def distance_text(row: Data) -> str:
    """The distance in per cent of the published value; none where the published value is 0."""
    if row["distance"] is None or not row["published"]:
        return ABSENT
    share = 100 * row["distance"]
    if abs(share) < 1e-3:
        return "below 0.001 %"
    return typeset(f"{share:+z.{1 if abs(share) >= 0.1 else 2 if abs(share) >= 0.01 else 3}f} %")


def limits_text(row: Data) -> str:
    """The accepted values."""
    if row["limits"] is None:
        return "no gate"
    low, high = row["limits"]
    if low is None or isinf(low):
        return f"below {number(high)}"
    if high is None or isinf(high):
        return f"above {number(low)}"
    return f"−{number(high)} to {number(high)}" if low == -high else f"{number(low)} to {number(high)}"  # noqa: RUF001


def published_text(row: Data) -> str:
    """The published value with its kind."""
    return ABSENT if row["published"] is None else f"{number(row['published'])} ({row['kind']})"


CLASSES = {"not met": "differ"}


def cells_of(row: Data, *, plain: bool = False) -> list[Any]:
    """Cells of a row of the table at the top."""
    verdict = row["verdict"]
    mark = Mark(verdict, CLASSES[verdict]) if verdict in CLASSES and not plain else verdict
    return [row["quantity"], published_text(row), ours_text(row), distance_text(row), limits_text(row), mark]


HEADER = ("quantity", "published", "ours, 95 % interval", "distance", "accepted", "verdict")


def verdicts(report: Data) -> str:
    """Number of rows with each verdict."""
    count = Counter(row["verdict"] for law in report["laws"].values() for row in law["rows"])
    return ", ".join(f"{count[word]} {word}" for word in ("met", "near", "not met", "fit") if count[word])


def summary_text(report: Data) -> str:
    """Return the table of all laws in Markdown."""
    titles = ("law", *HEADER)
    rows = [
        dict(zip(titles, (name, *cells_of(row, plain=True)), strict=True))
        for name, law in report["laws"].items()
        for row in law["rows"]
    ]
    failed = [f"{name}: {text}" for name, law in report["laws"].items() for text in law["failures"]]
    return paragraphs(markdown(dict.fromkeys(titles, ""), rows), verdicts(report), *failed).rstrip()


def write_page(report: Data, path: Path) -> Path:
    """Writes the page; figures are read from the same folder."""
    rows = [[name, *cells_of(row)] for name, law in report["laws"].items() for row in law["rows"]]
    made = [f"{name} {version}" for name, version in report["versions"].items()]
    about = (
        f"{verdicts(report)}. Met: our value is among the accepted ones. Near: only its interval reaches them. "
        "Not met: neither is. Fit: there is no gate. The section of the law says why. "
        "Where the published value is 0, ours is the distance."
    )
    form = "Short form: fewer and shorter runs; its verdicts mean little. " if report["quick"] else ""
    how = f"{form}Commit {report['commit'] or 'unknown'}; {', '.join(made)}; {report['machine']['processor']}."
    table = Table(rows, ("law", *HEADER))
    sections = [Section("", [Text(about, "verdict"), table, Text(how, "small")])]
    sections += [section_of(law, path.parent) for law in report["laws"].values()]
    return write_text(path, render("Held against published laws", sections))


def section_of(law: Data, folder: Path) -> Section:
    """A law: its question, figure, notes, and each row with source, reason and explanation."""
    blocks: list[Any] = [Text(law["question"]), *(Text(f"Failed: {text}", "bad") for text in law["failures"])]
    if law["figure"]:
        blocks.append(picture(folder / law["figure"], law["title"]))
    if law["table"]:
        heads, *lines = law["table"]
        blocks.append(Table(lines, heads))
    blocks += [Text(note) for note in law["notes"]]
    blocks.append(Items(explained(law["rows"])))
    return Section(law["title"], blocks)


def explained(rows: Sequence[Data]) -> list[str]:
    """Text next to the table: source and reason of the rows, one sentence for those that share them, and why."""
    alike: dict[tuple[str, ...], list[str]] = {}
    for row in rows:
        alike.setdefault((row["source"] if row["published"] is not None else "", row["reason"]), []).append(
            row["quantity"]
        )
    texts = []
    for (source, reason), names in alike.items():
        gated = any(row["limits"] is not None for row in rows if row["quantity"] in names)
        said = f"Source: {source.rstrip('.')}. " if source else ""
        texts.append(f"{'; '.join(names)}. {said}{'Accepted' if gated else 'No gate'}: {reason.rstrip('.')}.")
    outside: dict[str, list[str]] = {}
    for row in rows:
        if row["verdict"] in ("near", "not met"):
            outside.setdefault(row["why"].rstrip(".") or UNKNOWN, []).append(f"{row['quantity']} ({row['verdict']})")
    return texts + [f"Why outside: {'; '.join(names)}: {why}." for why, names in outside.items()]


# --- ``lammps-jump validate``: run the points of published laws, several starts each, and write one -------------------


RESULTS_FILE, PAGE_FILE = "validation.json", "report.html"


def default_folder(quick: bool) -> Path:
    """Return the folder of the results where none is named."""
    return Path("runs") / ("validate_quick" if quick else "validate")


def listing(laws: Path | None = None) -> str:
    """Return names and questions of the laws, a line each."""
    listed = find_laws(laws_folder(laws))
    wide = max(map(len, listed))
    return "\n".join(f"{name:<{wide}}  {law.question}" for name, law in listed.items())


def validate(
    names: Sequence[str] = (),
    out: Path | str | None = None,
    *,
    laws: Path | None = None,
    quick: bool = False,
    jobs: int | None = None,
    fresh: bool = False,
    keep_dumps: bool = False,
    progress: Callable[[SweepProgress], None] = lambda progress: None,
) -> dict[str, Any]:
    """Return what ``validation.json`` holds, after the laws were run, and their page written.

    Parameters
    ----------
    names : sequence of str
        Laws; all where none is named.
    out : Path, optional
        Default ``runs/validate``, quick ``runs/validate_quick``. Runs and results that it holds are not made again.
    laws : Path, optional
        Folder of the laws; default ``validation`` of the source tree.
    quick : bool
        The short form of each law: seconds.
    jobs : int, optional
        Processes at once; default one a usable core.
    fresh : bool
        Measure again what is stored.
    keep_dumps : bool
        Leave the dumps in the run folders, so that another measuring function needs no run.
    progress : callable
        Called with a `SweepProgress`.
    """
    place = laws_folder(laws)
    known = find_laws(place, list(names))
    folder = Path(out) if out else default_folder(quick)
    with held_folder(folder, "validate"):
        planned = {
            name: pieces_of(name, law.points(quick), folder, place / name, keep_dumps=keep_dumps)
            for name, law in known.items()
        }
        pieces = list(chain.from_iterable(planned.values()))
        store = Store(folder / RESULTS_FILE, fresh=fresh)
        forget(pieces, store)
        with Pool(jobs or usable_cores()) as pool:
            measure(pieces, store, pool, LawsBoard(pieces, store, progress))
        report: Results = {"quick": quick, "commit": commit(place), "versions": all_versions(), "machine": machine()}
        report["laws"] = {
            name: outcome(law, planned[name], store, folder / "figures" / f"{name}.png") for name, law in known.items()
        }
        store.data |= plain(report)
        write_json(store.path, store.data, indent=2)
        write_page(store.data, folder / PAGE_FILE)
        return store.data


class LawsBoard:
    """Counts what is done, for the line of progress: runs weighed by their processor time."""

    def __init__(self, pieces: Sequence[StartJob], store: Store, show: Callable[[SweepProgress], None]):
        left = {piece.key: piece for piece in pieces if piece.key not in store.pieces}
        self.weights = {key: piece.point.seconds for key, piece in left.items()}
        self.whole = sum(self.weights.values()) or 1.0
        self.shares: dict[str, float] = {}
        self.steps: dict[str, float] = {}
        self.now = SweepProgress(len(pieces) - len(left), 0, len(pieces), 0.0, 0.0)
        self.show = show

    def heard(self, key: str, news: tuple[float, float, int]) -> None:
        """Take in the progress of a run: share and number of its steps, discs in play."""
        share, step, discs = news
        more = max(0.0, step - self.steps.get(key, step)) * discs
        self.steps[key] = step
        self._tell(key, share, disc_steps=self.now.disc_steps + more)

    def ended(self, key: str, piece: Mapping[str, Any]) -> None:
        """Count a measurement."""
        bad = FAILED in piece
        self._tell(key, 1.0, done=self.now.done + (not bad), failed=self.now.failed + bad)

    def _tell(self, key: str, share: float, **changes: Any) -> None:
        self.shares[key] = share
        done = sum(self.weights[one] * part for one, part in self.shares.items())
        self.now = SweepProgress(**{**vars(self.now), "share": done / self.whole, **changes})
        self.show(self.now)


def outcome(law: Law, pieces: Sequence[StartJob], store: Store, figure: Path) -> dict[str, Any]:
    """Returns rows, measurements and failures of a law, as they are in ``validation.json``; draws its figure."""
    by_law, failures = found_of(pieces, store), failures_of(pieces, store)
    rows: list[Row] = []
    if all(by_law.values()):
        rows = list(law.rows(by_law))
        require_no_link(figure.parent)
        figure.parent.mkdir(parents=True, exist_ok=True)
        save(law.figure(by_law), figure)
    return {
        "title": law.title,
        "question": law.question,
        "notes": law.notes,
        "rows": [{**vars(row), "distance": row.distance, "verdict": row.verdict} for row in rows],
        "failures": failures,
        "figure": f"figures/{figure.name}" if rows else None,
        "table": law.table(by_law) if rows and law.table else None,
        "measured": with_keys(by_law, pieces),
    }


def with_keys(found: Found, pieces: Sequence[StartJob]) -> dict[str, Any]:
    """Return what was measured at each point, with the case and its runs."""
    about: dict[str, Any] = {}
    for piece in pieces:
        one = about.setdefault(piece.point.name, {"case": piece.point.case, "changes": dict(piece.point.changes)})
        if piece.member is not None:
            one.setdefault("runs", []).append(piece.member.key)
    return {name: {**one, "found": found[name]} for name, one in about.items()}


def commit(folder: Path) -> str | None:
    """Return the commit of the source tree that holds a folder; None where there is none."""
    try:
        completed_process = subprocess.run(
            ["git", "-C", str(folder), "describe", "--always", "--dirty", "--abbrev=12"],
            capture_output=True, text=True, timeout=20, check=False,
        )  # fmt: skip
    except OSError:
        return None
    return completed_process.stdout.strip() or None
