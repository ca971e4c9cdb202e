# SPDX-License-Identifier: GPL-2.0-or-later
"""How often each kind of fault is tried, and the table of them in docs/reliability.md, which ``make faults`` writes.

A test marked ``fault("kind")`` counts once, or as often as its fixture `tried` says. A test that records a "cell" (row,
column, text) fills one of the second table. The short form runs with all other
tests. The long form (``JUMP_FAULTS=long``) tries more. It writes the table if every test passes; ``JUMP_FAULTS=short``
writes that of the short form.
"""

from __future__ import annotations

import os
from collections import Counter
from pathlib import Path

from features import ENGINES, FEATURES

FORM = os.environ.get("JUMP_FAULTS", "")
LONG = FORM == "long"
PAGE = Path(__file__).parents[1] / "docs" / "reliability.md"
BEGIN, END = "<!-- written by make faults -->\n", "<!-- end -->\n"

KINDS = {
    "killed": ("at most one checkpoint interval", "`--resume` continues; the native engine gives the same bytes"),
    "ended and continued": ("nothing", "the run without an end ([table](#every-feature-on-every-engine))"),
    "signals": ("nothing behind the last step", "a message with the command that continues; exit status 75"),
    "files that cannot be written": (
        "nothing: the old or the new file is whole",
        "the file and the cause; `--resume` continues",
    ),
    "power cut, unsynced writes lost": ("at most one checkpoint interval", "the newest whole checkpoint is used"),
    "full disk": ("what was not written", "status `failed`, never `complete`"),
    "cut files": ("what was cut off", "file, and what is missing"),
    "flipped bits": ("nothing", "the file that differs from its checksum"),
    "wrong frames, discs or forces": ("nothing", "frame, step or row that is wrong"),
    "values in JSON files": ("nothing", "file, field and what is wrong"),
    "wrong tables": ("nothing", "file, line and column, or that a table differs from its checksum"),
    "mutants of cases": ("nothing: no file is written", "line, field and what is allowed"),
    "mutants of dumps": ("nothing", "the frame or value that is wrong"),
    "text as a command": ("nothing: no command is run", "the character that is not allowed"),
    "folders": ("nothing of the user's", "what stands there, or which process writes"),
    "surroundings": ("nothing", "a note of what is left aside, or what to install"),
}
"""Kind of fault: what may be lost, what the user sees. The tests of the kind check both."""

NONE = "\N{EN DASH}"
"""Text of a cell where an engine lacks a feature."""
CELLS_BEGIN, CELLS_END = "<!-- cells written by make faults -->\n", "<!-- end of cells -->\n"

tried: Counter[str] = Counter()
cells: dict[tuple[str, str], str] = {}


def many(short: int, long: int) -> int:
    """How often something is tried in the form that runs."""
    return long if LONG else short


def count(properties: list[tuple[str, object]]) -> None:
    """Take in the properties of a test that passed."""
    found = dict(properties)
    if "cell" in found:
        row, column, text = found["cell"]  # type: ignore[misc]
        cells[row, column] = text
    if "fault" in found:
        tried[str(found["fault"])] += int(found.get("times", 1))


def write_table() -> None:
    """Put the table into its place in the page."""
    rows = [f"| {kind} | {tried[kind]:,} | {lost} | {seen} |\n" for kind, (lost, seen) in KINDS.items() if tried[kind]]
    table = "| fault | times tried | what is lost | what the user sees |\n|---|---|---|---|\n" + "".join(rows)
    _put(BEGIN, table, END)
    if cells:
        rows, columns = (list(dict.fromkeys(names)) for names in zip(*sorted(cells, key=_place), strict=True))
        lines = [f"| {row} | {' | '.join(cells[row, column] for column in columns)} |\n" for row in rows]
        _put(
            CELLS_BEGIN,
            f"| feature | {' | '.join(columns)} |\n|{'---|' * (1 + len(columns))}\n{''.join(lines)}",
            CELLS_END,
        )


def _place(cell: tuple[str, str]) -> tuple[int, int]:
    return list(FEATURES).index(cell[0]), ENGINES.index(cell[1])


def _put(begin: str, table: str, end: str) -> None:
    head, _, rest = PAGE.read_text(encoding="utf-8").partition(begin)
    PAGE.write_text(head + begin + table + end + rest.partition(end)[2], encoding="utf-8")


def cells_of_page() -> dict[tuple[str, str], str]:
    """The second table as it stands in the page: text by row and column."""
    table = PAGE.read_text(encoding="utf-8").partition(CELLS_BEGIN)[2].partition(CELLS_END)[0]
    (_, *columns), _, *rows = ([word.strip() for word in line.split("|")[1:-1]] for line in table.splitlines())
    return {(row, column): text for row, *texts in rows for column, text in zip(columns, texts, strict=True)}
