# SPDX-License-Identifier: GPL-2.0-or-later
"""The tables of all studies: one Markdown function, and its view on a terminal."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping, Sequence

RULES = {"l": "---", "r": "---:"}


def markdown(head: Sequence[str], align: str, rows: Iterable[Sequence[object]]) -> str:
    """Return a Markdown table, without an end of line after its last row.

    Parameters
    ----------
    head : sequence of str
        Titles of the columns.
    align : str
        ``l`` or ``r`` for each column.
    rows : iterable of sequence
        Cells of each row.
    """
    first, *others = ("|" + "|".join(f" {cell} " if cell != "" else " " for cell in row) + "|" for row in (head, *rows))
    return "\n".join([first, "|" + "|".join(RULES[letter] for letter in align) + "|", *others])


def filled(template: str, rows: Iterable[Mapping[str, object]]) -> list[list[str]]:
    """Return the cells of each row: ``{engine}|{mean:+.1%}`` with the values of the row in it."""
    return [template.format_map(row).replace("%", " %").split("|") for row in rows]


def show(text: str) -> None:
    """Print Markdown: drawn by rich on a terminal, as it is in a file or a pipe."""
    if not sys.stdout.isatty():
        print(text)
        return
    from rich.console import Console  # 0.08 s
    from rich.markdown import Markdown

    Console().print(Markdown(text))


def percent(share: float | None, digits: int | None = None, sign: str = "") -> str:
    """Return a share in per cent, ``-`` for None; two decimals below 10 % and none above where `digits` is None."""
    if share is None:
        return "-"
    if digits is None:
        digits = 2 if abs(share) < 0.1 else 0
    return f"{100 * share:{sign}.{digits}f} %"


def number(value: float | None, digits: int = 2, error: float | None = None) -> str:
    """Return a number with fixed decimals, and its standard error where there is one; ``-`` for None."""
    if value is None:
        return "-"
    return f"{value:.{digits}f}" + ("" if error is None else f" ± {error:.{digits}f}")
