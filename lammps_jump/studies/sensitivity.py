# SPDX-License-Identifier: GPL-2.0-or-later
"""``lammps-jump sensitivity``: the jump against disc size, restitution, friction, stiffness, Froude number and sill.

The thesis' recommendation 1: variations as of a budget (`budget.Variation`), over a wide range, as curves. Each changes
one value of a base case, the frictionless ``quick_jump`` (a jet of 0.6 m at 10 m/s against a 1 m sill). It measures the
jump in the frame of its moving front, from a few slightly moved starts. The runs are kept: an interrupted study
continues. The tables are in ``sensitivity.json`` too.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import sqrt
from pathlib import Path
from typing import Any

import pandas as pd

from lammps_jump.analysis.draw.style import BLUE, GREY, RED, drawing, save
from lammps_jump.analysis.tables import Column, markdown, with_error
from lammps_jump.case.case import scene_folder
from lammps_jump.engines import usable_kernels
from lammps_jump.files import plain
from lammps_jump.physics import jump
from lammps_jump.runs.run import Case, load_case
from lammps_jump.sweeps import Results

from .bench import StudySetting, listed, reference_setting, stable
from .budget import Variation, numbers_of_run
from .points import FAILED, Found, Point, PointStudy
from .runs import middle

NUMBERS = ("froude", "y1", "y2", "belanger_y2", "belanger_deviation", "length_over_y2", "length_usbr", "speed")
"""Of a detected jump."""
DEPTH, GRAVITY = 0.6, 9.81
BASE_FROUDE = jump.froude(10.0, DEPTH, GRAVITY)


@dataclass(frozen=True)
class ParameterStudy(Variation):
    """One parameter and its values.

    Attributes
    ----------
    quick : mapping
        Settings of the short form.
    base : float
        Value of the base case.
    costly : float
        From this value on a run takes minutes, and two starts are made at most.
    logarithmic : bool
        Axis of its figure.
    """

    quick: Mapping[float, Mapping[str, object]]
    base: float
    costly: float = float("inf")
    logarithmic: bool = False


def _froude(froude: float) -> dict[str, object]:
    """Return another speed of the same jet in a dry channel; it, time and sill grow with the jump that is expected."""
    speed = froude * sqrt(GRAVITY * DEPTH)
    y2 = jump.sequent_depth(speed, DEPTH, GRAVITY)
    reach = max(20.0, 5.0 * y2)  # jumps of discs are about y2 long; those of water would not fit
    sill = max(0.3, 1.2 * jump.sill_holding_height(speed, DEPTH, GRAVITY) / _HOLDING)
    # the bore travels upstream at about (discharge held back)/(y2 - y1): a third of the channel in this time
    duration = reach / speed + 0.4 * reach * (y2 - DEPTH) / (0.65 * speed * DEPTH)
    return {
        "initial": [],
        "inflow.mean_speed": speed,
        "contact.impact_speed": speed,
        "walls.floor.x": [-5, reach + 0.2],
        "walls.sill.x": [reach, reach + 0.6],
        "walls.sill.y": [-5, sill],
        "domain.x": [-1, reach + 14],
        "domain.y": [-8, 40],
        "outflow.0.x_beyond": reach + 9,
        "run.duration": duration,
        "analysis.window": [0.67 * duration, duration],
        "run.output_interval": duration / 90,
    }


_HOLDING = jump.sill_holding_height(10.0, DEPTH, GRAVITY)


def _parameter(
    label: str,
    changes: Callable[[float], Mapping[str, object]],
    values: Sequence[float],
    quick: float,
    base: float,
    **more: Any,
) -> ParameterStudy:
    """A parameter of the values, with the changes that each makes."""
    return ParameterStudy(label, {value: changes(value) for value in values}, {quick: changes(quick)}, base, **more)


STUDIES = {
    "diameter": _parameter(
        "inflow depth over disc diameter", lambda rows: {"discs.diameter": DEPTH / rows}, (5.0, 10.0, 20.0), 4.0, 4.0,
        costly=20.0, logarithmic=True),
    "restitution": _parameter(
        "restitution coefficient", lambda e: {"contact.restitution": e}, (0.05, 0.2, 0.4, 0.6, 0.8, 0.95), 0.2, 0.2),
    "friction": _parameter(
        "friction coefficient μ", lambda mu: {"contact.friction": mu}, (0.0, 0.01, 0.02, 0.05, 0.1, 0.2), 0.1, 0.0),
    "stiffness": _parameter(
        "diameter over largest overlap, n", lambda n: {"contact.largest_overlap": 1 / n}, (5.0, 10.0, 20.0, 40.0), 5.0,
        10.0, logarithmic=True),
    "froude": _parameter(
        "inflow Froude number", _froude, (2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0), 3.0, BASE_FROUDE, costly=7.0),
    "sill": _parameter(
        "sill height (m)", lambda s: {"walls.sill.y": [-5, s]}, (0.6, 0.8, 1.0, 1.2, 1.4), 1.0, 1.0),
}  # fmt: skip
QUICK_CHANGES = {"discs.diameter": 0.2}


JUMP_CASE = scene_folder() / "quick_jump.yaml"
"""Base case of the studies of the jump."""


def study(*, quick: bool = False, only: str | None = None) -> PointStudy:
    """Return the study of all parameters, or of those named in `only`, comma-separated.

    Quick: one value a parameter, one start in place of four, coarse discs.

    Raises
    ------
    CaseError
        An unknown parameter.
    """
    names = listed("--only", only, list(STUDIES)) or tuple(STUDIES)
    base = load_case(JUMP_CASE, QUICK_CHANGES if quick else {})
    parts = {name: points_of(name, base, quick) for name in names}
    labels = {
        point.name: f"{STUDIES[name].label} = {value:zg}" for name in names for value, point in parts[name].items()
    }

    def results(found: Found, stored: Results) -> Results:
        rows = {name: [row_of(value, found[point.name]) for value, point in parts[name].items()] for name in names}
        return {"studies": {**stored.get("studies", {}), **rows}}

    def page(results: Results) -> list[str]:
        heading, rows = "### {0.label} (base {0.base:z.3g})", results["studies"]
        return [text for name in names for text in (heading.format(STUDIES[name]), markdown(COLUMNS, rows[name]))]

    def draw(results: Results, folder: Path) -> None:
        for name in names:
            draw_study(STUDIES[name], results["studies"][name], folder / f"sensitivity_{name}.png")

    def told(point: Point, start: int, measured: Results) -> str:
        return f"{labels[point.name]}, start {start}: {measured.get(FAILED) or measured['outcome']}"

    points = [point for part in parts.values() for point in part.values()]
    return PointStudy("sensitivity", points, results, page, draw, told)


def points_of(name: str, base: Case, quick: bool) -> dict[float, Point]:
    """Return the point of each value of a parameter; runs of minutes are made twice, many discs scatter less."""
    parameter = STUDIES[name]
    settings = parameter.quick if quick else parameter.settings
    varied = Variation(parameter.label, {value: settled(base, changes) for value, changes in settings.items()})
    options = {"paths": [f"jump.{number}" for number in NUMBERS], "looks": {}}
    seed = base.fields.run.seed
    plain = Point(name, numbers_of_run, base, seed=seed, options=options, dump=False, judged=True)
    return varied.points(plain, lambda value: 1 if quick else 2 if value >= parameter.costly else 4)


def settled(base: Case, changes: Mapping[str, object]) -> dict[str, object]:
    """Return the changes with the quickest kernel at f = 0.1, or less where that is not stable."""
    restitution = base.replace(changes).fields.contact.restitution
    kernel = reference_setting(0.1, [name for name in usable_kernels()[0] if name != "stock"]).kernel
    fast = next(s for s in (StudySetting(kernel, f) for f in (0.1, 0.05, 0.02)) if stable(s, restitution))
    return {**fast.changes(1.0), **changes}


def row_of(value: float, starts: Sequence[Mapping[str, Any]]) -> Results:
    """Returns the row of one value: means over the starts with a jump, with standard errors ``<number>_error``.

    It holds each of `NUMBERS`, ``ratio`` (y2/y1), ``expected`` (that by Bélanger), ``value``, ``verdicts`` (starts by
    verdict), ``seconds`` (median processor time), and ``usbr`` (length of that curve over Bélanger's y2). None: no
    number.
    """
    numbers = [one["numbers"] for one in starts if one.get("outcome") == "jump"]
    table = pd.DataFrame([[one[f"jump.{name}"] for name in NUMBERS] for one in numbers], columns=NUMBERS, dtype=float)
    row: Results = {"value": value, "verdicts": dict(Counter(one.get("outcome", FAILED) for one in starts))}
    row["seconds"] = middle(one.get("seconds", 0.0) for one in starts)
    table["ratio"], table["expected"] = table.y2 / table.y1, table.belanger_y2 / table.y1
    row |= plain({**table.mean(), **table.sem().add_suffix("_error")})
    row["usbr"] = plain((table.length_usbr / table.belanger_y2).mean())
    return row


PANELS = (
    ("ratio", "sequent depths y2/y1", "expected", "Bélanger"),
    ("length_over_y2", "length over y2", "usbr", "USBR curve"),
    ("speed", "speed of the front (m/s)", "", ""),
)
"""Panels of the figure: number, title, and the theory to compare with its label."""
COLUMNS: dict[str, Column] = {
    "value:": "{value:zg}",
    "found": lambda row: ", ".join(f"{count} {word}" for word, count in row["verdicts"].items()),
    "Fr, front's frame:": with_error("froude"),
    "y2/y1:": with_error("ratio"),
    "Bélanger:": with_error("expected"),
    "deviation:": "{belanger_deviation:+z.1%}",
    "L/y2:": with_error("length_over_y2"),
    "USBR:": "{usbr:z.2f}",
    "front (m/s):": with_error("speed"),
    "CPU (s):": "{seconds:z.1f}",
}


def draw_study(study: ParameterStudy, rows: Sequence[Results], path: Path) -> None:
    """Draws three panels with one abscissa; theory for the same (measured) Froude number with each measurement."""
    table = pd.DataFrame(rows).drop(columns="verdicts").astype(float)
    none = table.value[table.ratio.isna()]
    with drawing(8.6, 2.9, 1, 3) as (figure, axes):
        axes[2].axhline(0, color="#999999", linewidth=0.8)
        for panel, (name, title, theory_name, label) in zip(axes, PANELS, strict=True):
            known = table.dropna(subset=name)
            errors = known[f"{name}_error"].fillna(0.0)
            panel.errorbar(known.value, known[name], yerr=errors, fmt="o-", color=BLUE, capsize=2, label="discs")
            if theory_name:
                known = known.dropna(subset=theory_name)
                panel.plot(known.value, known[theory_name], "s--", color=GREY, markerfacecolor="white", label=label)
            panel.set(title=title, xlabel=study.label)
            if study.logarithmic:
                panel.set_xscale("log")
                panel.set_xticks(table.value, [f"{value:zg}" for value in table.value])
                panel.minorticks_off()
            low = panel.get_ylim()[0]
            if len(none):
                panel.plot(none, [low] * len(none), "x", color=RED, clip_on=False, label="no jump found")
            panel.legend()
        save(figure, path)
