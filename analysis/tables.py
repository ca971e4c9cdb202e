# SPDX-License-Identifier: GPL-2.0-or-later
# ruff: noqa: RUF001  (minus signs are meant for readers)
"""Rows of numbers for page and screen, and tables of all studies in Markdown.

± is the 95 % interval over starts. One run has none.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from math import isfinite, nan
from string import Formatter
from typing import Any, NamedTuple

from lammps_jump.analysis.report.page import NumberBox, heading
from lammps_jump.units import ABSENT, POWERS, ROUND_OFF, known, numbers_of, shown, sure_of

from .budgets import head
from .quantities import QUANTITIES
from .quantity import HeadlineNumber, Quantity
from .statistics import Mean
from .verdicts import doubts, headline

MOST = 5
FAR = 3.0
"""Factor between a measured number and theory from which on that does not apply."""
ONE_RUN = "one run, ± within it; for error bars: the same command with --members 8"
ONE_DUMP = "one dump; error bars need runs from other starts"
"""In place of error bars."""


class MeasuredRow(NamedTuple):
    """A measured number, theory (at the path `held`) and their difference; NaN where there is none.

    `holds` says what theory is of; it may not apply.
    """

    path: str
    held: str
    label: str
    unit: str
    measured: Mean
    words: str
    theory: Mean
    difference: Mean
    plain: bool
    holds: str
    source: str = ""

    def numbers(self) -> tuple[str, str, str]:
        """Measured number, theory and difference as text."""
        unit = f" {self.unit.translate(POWERS)}" if self.unit else ""
        theory = f"{self.words} {_text(self.theory, alone=True)}{unit}" if isfinite(self.theory.value) else self.words
        return f"{_text(self.measured)}{unit}", theory, self.off()

    @property
    def far(self) -> bool:
        """Tells whether theory is more than `FAR` times off, so that it does not apply."""
        ratio = 1.0 + self.difference.value
        return not self.plain and isfinite(ratio) and bool(self.holds) and not 1 / FAR <= ratio <= FAR

    def reason(self) -> str:
        """Why theory does not apply, as a sentence; empty where it does."""
        if not self.far:
            return ""
        ratio = 1.0 + self.difference.value
        times = f"{ratio:z.2g} times as much" if ratio >= 1 else f"{100 * ratio:z.2g} % of it"
        what, theory = heading(self.label, ""), self.numbers()[1]
        return f"{what}: {theory} does not apply, because it is {self.holds}; measured is {times}."

    def off(self) -> str:
        """The difference as text, with its sign."""
        value, error = self.difference.value, self.difference.error
        if not isfinite(value):
            return ""
        if self.far:
            return "does not apply"
        scale, unit = (1.0, self.unit) if self.plain else (100.0, "%")
        if isfinite(error):
            text = shown(scale * value, error=scale * error)
        elif self.plain:
            text = f"{value:z.{len(_text(self.measured).partition('.')[2])}f}"
        else:
            text = f"{scale * value:z.{1 if abs(scale * value) < 10 else 0}f}"
        return f"{'+' if value > 0 else ''}{text} {unit}".replace("-", "−")


def lone(values: Sequence[float]) -> Mean:
    """The number of one run."""
    return Mean(values[0], nan)


def rows_of(
    summaries: Sequence[Mapping[str, Any]], mean: Callable[[Sequence[float]], Mean] = lone, *, most: int = MOST
) -> list[MeasuredRow]:
    """The numbers of one run, or their means over starts of one case.

    Parameters
    ----------
    summaries : sequence of mapping
        As in ``summary.json``.
    mean : callable
        Mean and half the interval of numbers.
    most : int
        Rows; a number that is held against two theories has two.
    """
    rows = (row for quantity, wanted in _ranked() for row in _rows(quantity, wanted, summaries, mean))
    return [row for row, _ in zip(rows, range(most), strict=False)]


def _ranked() -> list[tuple[Quantity, HeadlineNumber]]:
    """All numbers that may be at the top, with their quantities, in the order of the page."""
    numbers = [(quantity, wanted) for quantity in QUANTITIES.values() for wanted in quantity.headline]
    return sorted(numbers, key=lambda pair: pair[0].rank if pair[1].rank is None else pair[1].rank)


def _rows(
    quantity: Quantity,
    wanted: HeadlineNumber,
    summaries: Sequence[Mapping[str, Any]],
    mean: Callable[[Sequence[float]], Mean],
) -> Iterator[MeasuredRow]:
    first = summaries[0] if summaries else {}
    meaning, unit = quantity.meaning(wanted)
    names = quantity.structures(wanted.key.rpartition(".")[2], first) if "*" in wanted.key else {"": ""}
    for name, component in names.items():
        path = f"{quantity.name}.{wanted.key}".replace("*", name)
        held = wanted.other and component != "fy"  # water at rest pushes along x
        held = held and all(quantity.compares(wanted, name, one) for one in summaries)
        other = f"{quantity.name}.{wanted.other}".replace("*", name) if held else ""
        pairs = [(value_at(one, path), value_at(one, other)) for one in summaries if quantity.is_shown(wanted, one)]
        known = [(value / wanted.scale, theory) for value, theory in pairs if isinstance(value, int | float)]
        if not known:
            continue
        both = [(value, theory / wanted.scale) for value, theory in known if isinstance(theory, int | float)]
        off = [value - theory if wanted.plain else abs(value) / abs(theory) - 1.0 for value, theory in both if theory]
        words, absent = {"name": name, "component": component.replace("f", "F")}, Mean(nan, nan)
        yield MeasuredRow(
            path,
            other,
            meaning.format(**words, **quantity.label_values(first)),
            unit,
            mean([value for value, _ in known]),
            wanted.words if both or not wanted.other else "",
            mean([theory for _, theory in both]) if both else absent,
            mean(off) if off else absent,
            wanted.plain,
            wanted.holds,
            wanted.source,
        )


def value_at(summary: Mapping[str, Any], path: str) -> Any:
    """Value at a path of keys; None where there is nothing."""
    value: object = summary
    for key in path.split("."):
        value = value.get(key) if isinstance(value, Mapping) else None
    return value


def _text(mean: Mean, *, alone: bool = False) -> str:
    """A number in three digits, or cut to its error; `alone` leaves the error out."""
    if isfinite(mean.error) and mean.error > ROUND_OFF * abs(mean.value):
        return shown(mean.value, error=mean.error, alone=alone).replace("-", "−")
    if not isfinite(mean.value):
        return ABSENT
    whole = abs(mean.value) >= 999.5 or not mean.value
    return (f"{mean.value:z.0f}" if whole else f"{mean.value:z#.3g}".rstrip(".")).replace("-", "−")


def tiles(rows: Sequence[MeasuredRow], summary: Mapping[str, Any] | None = None) -> list[NumberBox]:
    """The numbers at the top of a page; a number that is compared with two theories is listed once.

    One run has no interval: its numbers get the standard errors that its `summary` holds. Theory that does not apply is
    left out.
    """
    boxes: dict[str, NumberBox] = {}
    for row in rows:
        against = "" if row.far else ", ".join(filter(None, row.numbers()[1:]))
        source = f"{row.words}: {row.source}" if against and row.source else ""
        if before := boxes.get(row.label):
            boxes[row.label] = before._replace(
                against="; ".join(filter(None, (before.against, against))),
                source="; ".join(filter(None, (before.source, source))),
            )
            continue
        value, _, error = _measured(row, summary).partition(" ± ")
        boxes[row.label] = NumberBox(heading(row.label, ""), value, row.unit.translate(POWERS), error, against, source)
    return list(boxes.values())


def _measured(row: MeasuredRow, summary: Mapping[str, Any] | None) -> str:
    """The number of a row with its error; that within the run where there is no other."""
    if summary is None or isfinite(row.measured.error):
        return _text(row.measured)
    group, _, key = row.path.rpartition(".")
    error, bounds = value_at(summary, f"{row.path}_error"), value_at(summary, f"{group}.lower_bounds")
    stored = value_at(summary, row.path)
    if not isinstance(error, int | float) or not isinstance(stored, int | float) or not stored:
        return _text(row.measured)
    scale = row.measured.value / stored
    bound = isinstance(bounds, Sequence) and key in bounds
    text = shown(row.measured.value, error=abs(scale) * error, bound=bound)
    return text.replace("-", "−")


def table(rows: Sequence[MeasuredRow], width: int) -> list[str]:
    """The numbers as lines of a screen of so many columns."""
    labels = [row.label if k == 0 or row.label != rows[k - 1].label else "" for k, row in enumerate(rows)]
    cells = [("", "measured", "theory", "difference")]
    cells += [
        (label, measured if label else "", theory, off)
        for label, (measured, theory, off) in zip(labels, (row.numbers() for row in rows), strict=True)
    ]
    wide = [max(len(line[k]) for line in cells) for k in range(4)]
    wide[0] = max(8, min(wide[0], width - sum(wide[1:]) - 6))
    cut = [(label if len(label) <= wide[0] else f"{label[: wide[0] - 1]}…", *rest) for label, *rest in cells]
    return ["  ".join(cell.ljust(size) for cell, size in zip(line, wide, strict=True)).rstrip() for line in cut]


def lines(summary: Mapping[str, Any]) -> list[str]:
    """Lines below the numbers at the top."""
    return [line for quantity in QUANTITIES.values() if (line := quantity.line(summary))]


def sure(summary: Mapping[str, Any]) -> str:
    """In place of error bars of one run."""
    return ONE_DUMP if "given" in summary else ONE_RUN


def together(summaries: Sequence[Mapping[str, Any]], mean: Callable[[Sequence[float]], Mean]) -> dict[str, Any]:
    """One summary of starts of one case: means of those with the commonest verdict, errors half intervals.

    ``starts`` holds how many they are, and how many of them have the verdict.
    """
    kinds = [tuple(value_at(one, f"{name}.verdict") for name in QUANTITIES) for one in summaries]
    kind = Counter(kinds).most_common(1)[0][0]
    same = [one for one, its in zip(summaries, kinds, strict=True) if its == kind]
    made = {**_means(same, mean), "starts": (len(same), len(summaries))}
    for name in [name for name in QUANTITIES if isinstance(made.get(name), dict)]:
        if field := QUANTITIES[name].kind:
            results = [one[name] for one in same if isinstance(one.get(name), Mapping)]
            made[name] = {
                wall: _alike([one[wall] for one in results if wall in one], field, mean) for wall in made[name]
            }
    return made


def _alike(parts: Sequence[Mapping[str, Any]], kind: str, mean: Callable[[Sequence[float]], Mean]) -> dict[str, Any]:
    """Means of the results of one wall that are of the commonest kind; ``alike`` tells how many, of how many.

    A kind is what a field says, or of a number whether it is known.
    """
    kinds = [one.get(kind) if not isinstance(one.get(kind), float) else True for one in parts]
    commonest = Counter(kinds).most_common(1)[0][0]
    same = [one for one, its in zip(parts, kinds, strict=True) if its == commonest]
    return {**_means(same, mean), "alike": (len(same), len(parts))}


def _means(parts: Sequence[Mapping[str, Any]], mean: Callable[[Sequence[float]], Mean]) -> dict[str, Any]:
    """Common values of some results: means of the numbers that half of them know, of other values the commonest.

    What holds (a field that is true or false) holds where it does in all of them.
    """
    made: dict[str, Any] = {}
    for key in dict.fromkeys(key for one in parts for key in one):
        if key.endswith("_error"):
            continue
        values = [value for one in parts if (value := one.get(key)) is not None]
        if any(isinstance(value, Mapping) for value in values):
            made[key] = _means([one for one in values if isinstance(one, Mapping)], mean)
        elif any(isinstance(value, float) for value in values):
            numbers = [float(one) for one in values if isinstance(one, int | float)]
            if 2 * len(numbers) < len(parts):
                made[key] = None
                continue
            middle = mean(numbers)
            made |= {key: middle.value, f"{key}_error": middle.error if isfinite(middle.error) else None}
        else:
            made[key] = _commonest(values)
    return made


def _commonest(values: Sequence[Any]) -> Any:
    """Commonest of some values, the first of them where several are as common; None of none."""
    if values and all(isinstance(value, bool) for value in values):
        return all(values)
    same = [sum(one == value for one in values) for value in values]
    return values[same.index(max(same))] if values else None


def main_numbers(summary: Mapping[str, Any]) -> list[str]:
    """The headline of a summary; a line for each quantity: its verdict and its labelled numbers, where it has any."""
    said = headline(summary)
    lines = [said] if said else []
    for name, quantity in QUANTITIES.items():
        entry = summary.get(name)
        if isinstance(entry, Mapping) and quantity.shown(summary) and (texts := _labelled(quantity, entry)):
            lines.append(f"{name}: {', '.join(texts)}")
    below = [quantity.line(summary) for quantity in QUANTITIES.values()]
    lines += filter(None, [*below, head.line(summary)])
    return [*lines, *(f"doubtful: {text}" for text in doubts(summary))]


def _labelled(quantity: Quantity, entry: Mapping[str, Any]) -> list[str]:
    """The verdict of a quantity, and its labelled numbers that the summary has."""
    texts = [f"verdict {entry['verdict']}"] if entry.get("verdict") else []
    for result in quantity.walls(entry).values() if quantity.named is None else ():
        for number in numbers_of(result).values():
            value = getattr(result, number.key)
            if number.label != number.meaning and known(value) and quantity.applies(number.key, result):
                error, bound = sure_of(result, number.key)
                texts.append(f"{number.label} {shown(value, number.unit, error, bound=bound)}")
    return texts


# --- tables and pages of all studies in Markdown, made of records -----------------------------------------------------


Column = str | Callable[[Any], object]


class _Cells(Formatter):
    """Formats the values of a record, with a space before ``%``."""

    def __init__(self, absent: str):
        self.absent = absent

    def format_field(self, value: Any, format_spec: str) -> str:
        return self.absent if value is None else super().format_field(value, format_spec).replace("%", " %")


def filled(template: str, row: Mapping[str, Any], absent: str = "-") -> str:
    """Returns a template, ``{engine}, {share:z.1%}``, with the values of a record; `absent` replaces None."""
    return _Cells(absent).vformat(template, (), row)


def cells(
    columns: Mapping[str, Column], rows: Iterable[Mapping[str, Any]], absent: str = "-"
) -> tuple[list[list[Any]], list[str]]:
    """Return the cells of a table of records, and the titles of its columns.

    Parameters
    ----------
    columns : mapping of str to str or callable
        By the title of a column what makes a cell of a row: a template (``{engine}, {share:z.1%}``) or a function. An
        empty template takes what the row holds under the title. Titles that end with a colon are aligned right.
    rows : iterable of mapping
    absent : str
        Stands for None.
    """

    def cell(title: str, column: Column, row: Mapping[str, Any]) -> object:
        if callable(column):
            return column(row)
        return filled(column, row, absent) if column else row.get(title, absent)

    titled = [(title.removesuffix(":"), column) for title, column in columns.items()]
    return [[cell(*one, row) for one in titled] for row in rows], [title for title, _ in titled]


def markdown(columns: Mapping[str, Column], rows: Iterable[Mapping[str, Any]]) -> str:
    """Return the `cells` of a table in Markdown, without an end of line after its last row."""
    lines, titles = cells(columns, rows)
    first, *others = ("|" + "|".join(f" {c} " if c != "" else " " for c in line) + "|" for line in (titles, *lines))
    rules = ("---:" if title.endswith(":") else "---" for title in columns)
    return "\n".join([first, f"|{'|'.join(rules)}|", *others])


def paragraphs(*parts: str) -> str:
    """Return the page of a study in Markdown: its paragraphs and tables, without those that are empty."""
    return "\n\n".join(part for part in parts if part) + "\n"


def percent(share: float | None) -> str:
    """Return a share in per cent with two decimals below 10 % and none above, ``-`` for None."""
    return "-" if share is None else f"{100 * share:z.{2 if abs(share) < 0.1 else 0}f} %"


def with_error(name: str, digits: int = 2) -> Callable[[Mapping[str, Any]], str]:
    """Returns a column of a number with fixed decimals, followed by ``<name>_error`` where there is one."""

    def cell(row: Mapping[str, Any]) -> str:
        value, error = row[name], row[f"{name}_error"]
        shown = "-" if value is None else f"{value:z.{digits}f}"
        if value is None or error is None:
            return shown
        sure = f"{error:z.{digits}f}"
        return f"{shown} ± {sure}" if float(sure) or not error else f"{shown} ± {error:z.1g}"

    return cell
