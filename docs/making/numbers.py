# SPDX-License-Identifier: GPL-2.0-or-later
"""The page of all numbers of ``summary.json``, read from the results that the analyses make."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from typing import Any, get_args, get_type_hints

from lammps_jump.analysis.quantities import QUANTITIES
from lammps_jump.units import POWERS, numbers_of

from . import NONE

# ruff: noqa: RUF001  (Greek letters are meant for readers)

HEAD = """\
# All numbers

This page is made from the analyses of the program. It lists the numbers of `summary.json` by their keys.
A number that was not measured is `null`. Where the column ± says *yes*, the key with `_error` behind it holds
the standard error within this run.
[How a jump is measured](../measuring.md) gives the reasons, and [Read and analyse a run](../analysis.md) the practice.
All numbers are per metre of width.

d is the disc diameter, ρ the density of a disc, s the mass depth, h the depth of the free surface.
u is the mean velocity by mass, c the velocity of the front, g gravity across the bed.
Index 1 is upstream of the jump, 2 downstream. The mass depth is N m/(ρ L): the depth of N discs of
mass m = ρd² over a length L, packed in squares.
"""
ENTRY = re.compile(r"^(\S.*?) {2,}(\S.*)$")


def page() -> str:
    """The page, Markdown."""
    return "\n".join([HEAD, *(line for key in QUANTITIES for line in section(key))])


def section(key: str) -> Iterator[str]:
    """Definitions and numbers of one quantity."""
    quantity = QUANTITIES[key]
    yield f"## {quantity.title}\n"
    for text in (quantity.definitions, quantity.beside):
        rows = entries(text)
        if not rows:  # its numbers tell all
            continue
        yield "| word | what it is |\n|---|---|"
        yield from (f"| {cell(word)} | {cell(text)} |" for word, text in rows)
        yield ""
    results = {f"{key}.{quantity.named.path}" if quantity.named else key: quantity.result}
    results |= {f"{key}.{name}": one for name, kind in quantity.parts.items() for one in results_in(kind)}
    for path, result in results.items():
        for inner, kind in within(path, result):
            yield f"Numbers of `{inner}`:\n"
            yield from table(kind)
            yield ""


def results_in(kind: Any) -> list[type]:
    """Results with numbers that a value of this type is, or holds."""
    return [one for one in (kind, *get_args(kind)) if isinstance(one, type) and is_dataclass(one)]


def table(result: type) -> Iterator[str]:
    """Keys, units and meanings of the numbers of a result, a row each; errors are told in the row of their number."""
    numbers = numbers_of(result)
    yield "| key | unit | ± | meaning |\n|---|---|---|---|"
    for key, one in numbers.items():
        if key.removesuffix("_error") == key or key.removesuffix("_error") not in numbers:
            error = "yes" if f"{key}_error" in numbers else NONE
            yield f"| `{key}` | {one.unit.translate(POWERS) or NONE} | {error} | {cell(one.meaning)} |"


def entries(text: str) -> list[tuple[str, str]]:
    """Words of a definition with their texts; a line without a word of its own goes on with the one before."""
    found: list[tuple[str, str]] = []
    for line in text.splitlines():
        entry = ENTRY.match(line)
        if entry:
            found.append((entry[1], entry[2]))
        elif line[:1].isspace():
            found[-1] = (found[-1][0], f"{found[-1][1]} {line.strip()}")
        else:
            found.append((line, ""))
    return found


def within(path: str, result: type) -> Iterator[tuple[str, type]]:
    """A result and the results inside it that stand in ``summary.json``, by their paths."""
    if numbers_of(result):
        yield path, result
    kinds = get_type_hints(result)
    for field in fields(result):
        if field.metadata.get("summary", True):
            for kind in (kinds[field.name], *get_args(kinds[field.name])):
                if is_dataclass(kind) and isinstance(kind, type):
                    yield from within(f"{path}.{field.metadata.get('key', field.name)}", kind)


def cell(text: str) -> str:
    """A text in a table."""
    return text.replace("|", "\\|").replace("*", "\\*").replace("$", "\\$")
