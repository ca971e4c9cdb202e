# SPDX-License-Identifier: GPL-2.0-or-later
"""The page of a validation, made from ``validation.json`` alone: one table at its top, then a section a law."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from math import ceil, isinf, log10, nan
from pathlib import Path
from typing import Any

from lammps_jump.analysis.report.page import Items, Mark, Section, Table, Text, picture, render
from lammps_jump.analysis.tables.markdown import markdown, paragraphs
from lammps_jump.files import write_text
from lammps_jump.units import shown

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
    """Write the page; figures are read from beside it."""
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
    """Text beside the table: source and reason of the rows, one sentence for those that share them, and why."""
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
