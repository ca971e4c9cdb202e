# SPDX-License-Identifier: GPL-2.0-or-later
"""The page of a validation, made from ``validation.json`` alone: one table at its top, then a section a law."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from math import isinf
from pathlib import Path
from typing import Any

from lammps_jump.analysis.report.page import Items, Mark, Section, Table, Text, picture, render
from lammps_jump.studies.table import markdown
from lammps_jump.units import shown

ABSENT = "—"
Data = Mapping[str, Any]


def number(value: float | str | None) -> str:
    """A number with four digits, words as they are."""
    if value is None:
        return ABSENT
    return value if isinstance(value, str) else shown(float(value)).replace("-", "−")  # noqa: RUF001


def ours_text(row: Data) -> str:
    """Our value, cut to its interval."""
    if row["ours"] is None:
        return ABSENT
    error = row["interval"]
    return shown(row["ours"], error=error).replace("-", "−") if error else number(row["ours"])  # noqa: RUF001


def distance_text(row: Data) -> str:
    """The distance: per cent of the published value, or the difference where that is 0."""
    if row["distance"] is None:
        return ABSENT
    if not row["published"]:
        return number(row["distance"])
    share = 100 * row["distance"]
    if abs(share) < 1e-3:
        return "below 0.001 %"
    return f"{share:+.{1 if abs(share) >= 0.1 else 2 if abs(share) >= 0.01 else 3}f} %".replace("-", "−")  # noqa: RUF001


def limits_text(row: Data) -> str:
    """The accepted values."""
    if row["limits"] is None:
        return "no gate"
    low, high = row["limits"]
    if low is None or isinf(low):
        return f"below {number(high)}"
    return f"above {number(low)}" if high is None or isinf(high) else f"{number(low)} to {number(high)}"


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
    """How many rows have which verdict."""
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
    parts = [markdown(dict.fromkeys(titles, ""), rows), verdicts(report), *failed]
    return "\n\n".join(part for part in parts if part)


def write_page(report: Data, path: Path) -> Path:
    """Write the page; figures are read from beside it."""
    rows = [[name, *cells_of(row)] for name, law in report["laws"].items() for row in law["rows"]]
    made = [f"{name} {version}" for name, version in report["versions"].items()]
    about = (
        f"{verdicts(report)}. Met: our value is among the accepted ones. Near: only its interval reaches them. "
        "Fit: a value of ours without a gate, because no published number was found."
    )
    form = "Short form: fewer and shorter runs; its verdicts mean little. " if report["quick"] else ""
    how = f"{form}Commit {report['commit'] or 'unknown'}; {', '.join(made)}; {report['machine']['processor']}."
    table = Table(rows, ("law", *HEADER))
    sections = [Section("", [Text(about, "verdict"), table, Text(how, "small")])]
    sections += [section_of(law, path.parent) for law in report["laws"].values()]
    path.write_text(render("Held against published laws", sections), encoding="utf-8")
    return path


def section_of(law: Data, folder: Path) -> Section:
    """A law: its question, figure, notes, and each row with source, reason and explanation."""
    blocks: list[Any] = [Text(law["question"]), *(Text(f"Failed: {text}", "bad") for text in law["failures"])]
    if law["figure"]:
        blocks.append(picture(folder / law["figure"], law["title"]))
    blocks += [Text(note) for note in law["notes"]]
    blocks.append(Items([explained(row) for row in law["rows"]]))
    return Section(law["title"], blocks)


def explained(row: Data) -> str:
    """A row in sentences."""
    parts = [f"{row['quantity']}: {ours_text(row)}, {row['verdict']}."]
    if row["published"] is not None:
        parts.append(f"Published: {published_text(row)}, {row['source']}.")
    accepted = "No gate" if row["limits"] is None else f"Accepted: {limits_text(row)}"
    parts.append(f"{accepted}: {row['reason'].rstrip('.')}.")
    if row["verdict"] in ("near", "not met") and row["why"]:
        parts.append(f"Why: {row['why'].rstrip('.')}.")
    return " ".join(parts)
