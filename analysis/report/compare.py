# SPDX-License-Identifier: GPL-2.0-or-later
"""Two runs on one page, side by side: their numbers, their discs at one time, their curves on the same axes."""

# ruff: noqa: RUF001  (minus signs are meant for readers)
from __future__ import annotations

from collections.abc import Iterator, Mapping
from copy import deepcopy
from dataclasses import dataclass
from math import hypot
from typing import Any

from lammps_jump.analysis.quantities import QUANTITIES
from lammps_jump.units import Number, known, numbers_of, shown, sure_of

from .page import Beside, Curve, Player, Section, Table, Text, cut, heading, render


@dataclass(frozen=True)
class Side:
    """One of the runs.

    Attributes
    ----------
    name : str
        Tells the two apart.
    summary : mapping
        As in ``summary.json``.
    curves : mapping of str to Curve
        Of `run.curves`.
    player : Player or None
    """

    name: str
    summary: Mapping[str, Any]
    curves: Mapping[str, Curve]
    player: Player | None


def comparison(left: Side, right: Side) -> str:
    """The page of two runs."""
    names = left.name, right.name
    heads = Beside([Text(name, "sure") for name in names])
    players = [side.player for side in (left, right) if side.player is not None]
    discs = [heads, Beside(players)] if len(players) == 2 else []
    both = [name for name in left.curves if name in right.curves]
    pairs = [Beside(_on_one_scale(left.curves[name], right.curves[name])) for name in both]
    alone = [f"{name}: {curve.caption}" for name, side, other in ((names[0], left, right), (names[1], right, left))
             for key, curve in side.curves.items() if key not in other.curves]  # fmt: skip
    table = Table(list(_rows(left.summary, right.summary)), ("", *names, "difference"))
    sections = [
        Section("", discs),
        Section("Numbers", [table, Text("One run each; for error bars: their commands with --members 8.", "sure")]),
        Section("Curves", [heads, *pairs, Text(f"Of one run alone: {'; '.join(alone)}." if alone else "", "small")]),
    ]
    return render(" and ".join(names), sections, tab=" and ".join(names))


def _rows(left: Mapping[str, Any], right: Mapping[str, Any]) -> Iterator[tuple[str, str, str, str]]:
    """Label, both numbers and their difference, cut to their errors within the runs."""
    for name, quantity in QUANTITIES.items():
        first, second = (quantity.walls(summary.get(name) or {}) for summary in (left, right))
        for part in dict.fromkeys([*first, *second]):
            sides = first.get(part), second.get(part)
            for number in numbers_of(quantity.result).values():
                told = any(
                    known(getattr(side, number.key, None)) and quantity.applies(number.key, side) for side in sides
                )
                if number.label != number.meaning and told:
                    yield _row(part, number, *sides)


def _row(part: str, number: Number, left: object, right: object) -> tuple[str, str, str, str]:
    key, unit = number.key, number.unit
    values: list[Any] = [getattr(side, key, None) for side in (left, right)]
    texts = [shown(None) if side is None else cut(side, key) for side in (left, right)]
    errors = [sure_of(side, key).value for side in (left, right)]
    difference = shown(None)
    if all(known(value) for value in values):
        error = hypot(*(error for error in errors if error is not None)) if None not in errors else None
        difference = shown(values[1] - values[0], error=error, alone=True).replace("-", "−")
    label = heading(number.meaning, unit)
    return f"{part}: {label}" if part else label, texts[0], texts[1], difference


def _on_one_scale(left: Curve, right: Curve) -> list[Curve]:
    """Both curves with the axes of both; panels that only one of them has keep their own."""
    pair = [Curve(curve.caption, deepcopy(dict(curve.data))) for curve in (left, right)]
    for panels in zip(*(curve.data.get("panels", ()) for curve in pair), strict=False):
        for axis, limits in (("x", "xlim"), ("y", "ylim")):
            ends = [_ends(panel, axis, limits) for panel in panels]
            known = [one for one in ends if one]
            if len(known) == len(ends):
                low, high = min(end[0] for end in known), max(end[1] for end in known)
                for panel in panels:
                    panel[limits] = [low, high]
    return pair


def _ends(panel: Mapping[str, Any], axis: str, limits: str) -> tuple[float, float] | None:
    """Least and greatest value on an axis of a panel; None where there is none."""
    faint = len(panel["lines"]) > 1
    values = [value for line in panel["lines"] if not (faint and line["look"] in ("faint", "dots"))
              for value in line.get(axis, ()) if value is not None]  # fmt: skip
    values += [value for _, value in panel["levels"] if value is not None] if axis == "y" else []
    if not values:
        return None
    low, high = panel[limits]
    return min(values) if low is None else low, max(values) if high is None else high
