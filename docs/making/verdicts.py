# SPDX-License-Identifier: GPL-2.0-or-later
"""The page of all verdicts: question, answer, numbers, and when it is doubtful, read from where the verdicts stand."""

from __future__ import annotations

from lammps_jump.analysis.verdicts import VERDICTS

from .numbers import cell

HEAD = """\
# All verdicts

This page is made from the verdicts of the program. The title of a report answers at most two of these questions.
Each answer is made of numbers of `summary.json`, which [All numbers](numbers.md) defines.
Page and screen tell which of the conditions on the right hold in a run.
A question that nobody asked, or that a flow cannot answer, has no title.
Where a case asks and there is no answer, the reason stands among the doubts.

| question | answer, an example | made of | doubtful where |
|---|---|---|---|"""


def page() -> str:
    """The page, Markdown."""
    rows = []
    for verdict in VERDICTS:
        numbers = ", ".join(f"`{key}`" for key in verdict.numbers)
        doubts = "; ".join(doubt.when for doubt in verdict.doubts)
        rows.append(f"| {cell(verdict.question)} | {cell(verdict.answer)} | {numbers} | {cell(doubts)} |")
    return "\n".join([HEAD, *rows, ""])
