# SPDX-License-Identifier: GPL-2.0-or-later
"""Tables and pages of all studies in Markdown, made of records."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from string import Formatter
from typing import Any

Column = str | Callable[[Any], object]


class _Cells(Formatter):
    """Formats the values of a record, with a space before ``%``."""

    def __init__(self, absent: str):
        self.absent = absent

    def format_field(self, value: Any, format_spec: str) -> str:
        return self.absent if value is None else super().format_field(value, format_spec).replace("%", " %")


def filled(template: str, row: Mapping[str, Any], absent: str = "-") -> str:
    """Return a template, ``{engine}, {share:z.1%}``, with the values of a record; `absent` stands for None."""
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
    """Return a column of a number with fixed decimals, and ``<name>_error`` behind it where there is one."""

    def cell(row: Mapping[str, Any]) -> str:
        value, error = row[name], row[f"{name}_error"]
        shown = "-" if value is None else f"{value:z.{digits}f}"
        if value is None or error is None:
            return shown
        sure = f"{error:z.{digits}f}"
        return f"{shown} ± {sure}" if float(sure) or not error else f"{shown} ± {error:z.1g}"

    return cell
