# SPDX-License-Identifier: GPL-2.0-or-later
"""How often each kind of fault is tried, and the table of them in docs/reliability.md, which ``make faults`` writes.

A test marked ``fault("kind")`` counts once, or as often as its fixture `tried` says. The short form runs with all other
tests. The long form (``JUMP_FAULTS=long``) tries more. It writes the table if every test passes; ``JUMP_FAULTS=short``
writes that of the short form.
"""

from __future__ import annotations

import os
from collections import Counter
from pathlib import Path

FORM = os.environ.get("JUMP_FAULTS", "")
LONG = FORM == "long"
PAGE = Path(__file__).parents[1] / "docs" / "reliability.md"
BEGIN, END = "<!-- written by make faults -->\n", "<!-- end -->\n"

KINDS = {
    "killed": ("at most one checkpoint interval", "`--resume` continues; the native engine gives the same bytes"),
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
    "mutants of cases": ("nothing: no file is written", "line, field and what is allowed"),
    "mutants of dumps": ("nothing", "the frame or value that is wrong"),
    "text as a command": ("nothing: no command is run", "the character that is not allowed"),
    "folders": ("nothing of the user's", "what stands there, or which process writes"),
    "surroundings": ("nothing", "a note of what is left aside, or what to install"),
}
"""Kind of fault: what may be lost, what the user sees. The tests of the kind check both."""

tried: Counter[str] = Counter()


def many(short: int, long: int) -> int:
    """How often something is tried in the form that runs."""
    return long if LONG else short


def count(properties: list[tuple[str, object]]) -> None:
    """Take in the properties of a test that passed."""
    found = dict(properties)
    if "fault" in found:
        tried[str(found["fault"])] += int(found.get("times", 1))


def write_table() -> None:
    """Put the table into its place in the page."""
    rows = [f"| {kind} | {tried[kind]:,} | {lost} | {seen} |\n" for kind, (lost, seen) in KINDS.items() if tried[kind]]
    table = "| fault | times tried | what is lost | what the user sees |\n|---|---|---|---|\n" + "".join(rows)
    head, _, rest = PAGE.read_text(encoding="utf-8").partition(BEGIN)
    PAGE.write_text(head + BEGIN + table + END + rest.partition(END)[2], encoding="utf-8")
