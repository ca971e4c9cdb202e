# SPDX-License-Identifier: GPL-2.0-or-later
"""``lammps-jump sensitivity``: the jump against disc size, restitution, friction, stiffness, Froude number and sill.

The thesis' recommendation 1. Every study changes one value of a base case, the frictionless ``quick_jump`` (a jet of
0.6 m at 10 m/s against a 1 m sill). It measures the jump in the frame of its moving front, from a few slightly moved
starts. The runs are kept: an interrupted study continues. The tables are in ``sensitivity.json`` too.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import sqrt
from pathlib import Path

import pandas as pd

from lammps_jump import Case, load_case
from lammps_jump.analysis.draw.style import BLUE, GREY, RED, drawing, save
from lammps_jump.case.templates import scene_folder
from lammps_jump.engines import usable_kernels
from lammps_jump.files import plain
from lammps_jump.physics import jump
from lammps_jump.provenance import usable_cores
from lammps_jump.studies.folder import held_folder
from lammps_jump.sweeps import MemberRun, Pool, Say, Start, Store, run_starts

from .runs import middle
from .settings import StudySetting, listed, reference_setting, stable
from .table import markdown, with_error

DEPTH, GRAVITY = 0.6, 9.81
BASE_FROUDE = jump.froude(10.0, DEPTH, GRAVITY)


@dataclass(frozen=True)
class ParameterStudy:
    """One parameter and its values.

    Attributes
    ----------
    label : str
    values, quick : tuple of float
    changes : callable
        Parameter's value to changed values of the case.
    base : float
        Value of the base case.
    costly : float
        From this value on a run takes minutes, and two starts are made at most.
    logarithmic : bool
        Axis of its figure.
    """

    label: str
    values: tuple[float, ...]
    quick: tuple[float, ...]
    changes: Callable[[float], dict[str, object]]
    base: float
    costly: float = float("inf")
    logarithmic: bool = False


Row = dict[str, float | dict[str, int] | None]
"""A value of the parameter with what was found: each of `NUMBERS`, ``ratio`` (y2/y1), ``expected`` (that by Bélanger),
means over the starts that found a jump, with their standard errors ``<number>_error``; ``value``, ``verdicts`` (starts
by verdict), ``seconds`` (median processor time), ``usbr`` (length of that curve over Bélanger's y2). None: no number.
"""
NUMBERS = ("froude", "y1", "y2", "belanger_y2", "belanger_deviation", "length_over_y2", "length_usbr", "speed")


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

STUDIES = {
    "diameter": ParameterStudy("inflow depth over disc diameter", (5.0, 10.0, 20.0), (4.0,),
        lambda rows: {"discs.diameter": DEPTH / rows}, 4.0, costly=20.0, logarithmic=True),
    "restitution": ParameterStudy("restitution coefficient", (0.05, 0.2, 0.4, 0.6, 0.8, 0.95), (0.2,),
        lambda e: {"contact.restitution": e}, 0.2),
    "friction": ParameterStudy("friction coefficient μ", (0.0, 0.01, 0.02, 0.05, 0.1, 0.2), (0.1,),
        lambda mu: {"contact.friction": mu}, 0.0),
    "stiffness": ParameterStudy(
        "diameter over largest overlap, n", (5.0, 10.0, 20.0, 40.0), (5.0,),
        lambda n: {"contact.largest_overlap": 1 / n}, 10.0, logarithmic=True),
    "froude": ParameterStudy(
        "inflow Froude number", (2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0), (3.0,), _froude, BASE_FROUDE,
        costly=7.0),
    "sill": ParameterStudy(
        "sill height (m)", (0.6, 0.8, 1.0, 1.2, 1.4), (1.0,), lambda s: {"walls.sill.y": [-5, s]}, 1.0),
}  # fmt: skip
QUICK_CHANGES = {"discs.diameter": 0.2}


JUMP_CASE = scene_folder() / "quick_jump.yaml"
"""Base case of the studies of the jump."""


def run_sensitivity(
    out: Path | None = None, *, quick: bool = False, only: str | None = None, fresh: bool = False, say: Say = print
) -> str:
    """Run all studies, or those named in `only`; returns their tables as Markdown.

    Parameters
    ----------
    out : Path, optional
        Default ``runs/sensitivity``.
    quick : bool
        One value a study, one start in place of four, coarse discs.
    only : str, optional
        Names of `STUDIES`, comma-separated.
    fresh : bool
        Run again what is stored.
    say : callable

    Raises
    ------
    CaseError
        An unknown study.
    """
    names = listed("--only", only, list(STUDIES)) or tuple(STUDIES)
    folder = Path(out) if out else Path("runs") / "sensitivity"
    heading, rows = "### {0.label} (base {0.base:z.3g})\n\n", {}
    with held_folder(folder, "sensitivity"), Pool(usable_cores()) as pool:
        store = Store(folder / "sensitivity.json")
        for name in names:
            rows[name] = run_study(STUDIES[name], folder, pool, quick=quick, fresh=fresh, say=say)
            draw_study(STUDIES[name], rows[name], folder / f"sensitivity_{name}.png")
        tables = (heading.format(STUDIES[name]) + markdown(COLUMNS, found) + "\n" for name, found in rows.items())
        return store.finish("\n".join(tables), studies={**store.data.get("studies", {}), **rows})


def run_study(study: ParameterStudy, folder: Path, pool: Pool, *, quick: bool, fresh: bool, say: Say) -> list[Row]:
    """Return a row for each value of the parameter."""
    base, values = load_case(JUMP_CASE, QUICK_CHANGES if quick else {}), study.quick if quick else study.values

    def said(made: MemberRun) -> None:
        value, member = values[made.start.point], made.start.seed - base.fields.run.seed
        say(f"  {study.label} = {value:zg}, start {member + 1}: {made.message or made.outcome}")

    starts: list[Start] = []
    for point, value in enumerate(values):  # runs of minutes are made twice; large numbers of discs scatter less
        members = 1 if quick else (2 if value >= study.costly else 4)
        starts += starts_of(base, study.changes(value), members, point)
    made = run_starts(base, starts, folder, pool, fresh=fresh, said=said)
    return [summarise_runs(v, [one for one in made if one.start.point == point]) for point, v in enumerate(values)]


def starts_of(base: Case, changes: Mapping[str, object], members: int, point: int = 0) -> list[Start]:
    """Return starts of a changed case on the quickest kernel at f = 0.1, or less where that is not stable."""
    restitution = base.replace(changes).fields.contact.restitution
    kernel = reference_setting(0.1, [name for name in usable_kernels()[0] if name != "stock"]).kernel
    fast = next(s for s in (StudySetting(kernel, f) for f in (0.1, 0.05, 0.02)) if stable(s, restitution))
    seed = base.fields.run.seed
    return [Start(point, {**fast.changes(1.0), **changes}, seed + member) for member in range(members)]


def summarise_runs(value: float, runs: list[MemberRun]) -> Row:
    """Return the row of one value of the parameter."""
    table = pd.DataFrame([run.jump for run in runs if run.jump], columns=NUMBERS, dtype=float)
    row: Row = {"value": value, "verdicts": dict(Counter(run.outcome for run in runs))}
    row["seconds"] = middle(run.summary.get("cpu_seconds", 0.0) for run in runs)
    table["ratio"], table["expected"] = table.y2 / table.y1, table.belanger_y2 / table.y1
    row |= plain({**table.mean(), **table.sem().add_suffix("_error")})
    row["usbr"] = plain((table.length_usbr / table.belanger_y2).mean())
    return row


PANELS = (
    ("ratio", "sequent depths y2/y1", "expected", "Bélanger"),
    ("length_over_y2", "length over y2", "usbr", "USBR curve"),
    ("speed", "speed of the front (m/s)", "", ""),
)
"""Panels of the figure: number, title, and the theory beside it with its label."""
COLUMNS = {
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


def draw_study(study: ParameterStudy, rows: list[Row], path: Path) -> None:
    """Draw three panels with one abscissa; theory for the same (measured) Froude number beside each measurement."""
    table = pd.DataFrame(rows).drop(columns="verdicts").astype(float)
    none = table.value[table.ratio.isna()]
    with drawing(8.6, 2.9, 1, 3) as (figure, axes):
        axes[2].axhline(0, color="#999999", linewidth=0.8)
        for panel, (name, title, theory_name, label) in zip(axes, PANELS, strict=True):
            found = table.dropna(subset=name)
            errors = found[f"{name}_error"].fillna(0.0)
            panel.errorbar(found.value, found[name], yerr=errors, fmt="o-", color=BLUE, capsize=2, label="discs")
            if theory_name:
                found = found.dropna(subset=theory_name)
                panel.plot(found.value, found[theory_name], "s--", color=GREY, markerfacecolor="white", label=label)
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
