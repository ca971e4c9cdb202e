# SPDX-License-Identifier: GPL-2.0-or-later
"""What the pages, tables and figures of a run show of its jump."""

# ruff: noqa: RUF001  (Greek letters, minus signs and dashes are meant for readers)
from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from math import isfinite
from types import MappingProxyType
from typing import NamedTuple, cast

import numpy as np

from lammps_jump.analysis.budgets.head import energy_budget, sentence
from lammps_jump.analysis.passes import Drawings, Gathered, Tables
from lammps_jump.analysis.profiles import bin_edges
from lammps_jump.analysis.report.page import Section, Table, Text, described, heading
from lammps_jump.units import ABSENT, numbers_of, shown

from .figures import balance_figure, frame_figure, head_figure, track_figure
from .frame import Balance
from .result import analyse_jump
from .summary import Jump, summarise_jump

STATES = (
    ("y1", "y2"), ("h1", "h2"), ("u1", "u2"), ("packing_1", "packing_2"), ("beta_1", "beta_2"),
    ("momentum_upstream", "momentum_downstream"), ("head_upstream", "head_downstream"),
)  # fmt: skip
"""Numbers that stand side by side in the table of the states."""


def analyse(gathered: Gathered) -> Jump:
    """Jump of a run."""
    found = summarise_jump(analyse_jump(gathered.profiles, gathered.flow, gathered.contacts))
    edges = bin_edges(gathered.flow.x_range, gathered.flow.bin_width)
    budget = energy_budget(cast("np.ndarray | None", gathered.histories.get("jump")), found.measured, edges)
    if budget is None:
        return found
    return replace(found, budget=budget, head_lost=budget.lost, head_lost_error=budget.inflow_error)


class Marks(NamedTuple):
    """What the figures of the profiles show of a jump.

    Attributes
    ----------
    lines : dict of label to depth, m
    places : dict of label to x, m
    track : (ndarray, ndarray) or None
        Places (m) and times (s) of the toe.
    """

    lines: Mapping[str, float] = MappingProxyType({})
    places: Mapping[str, float] = MappingProxyType({})
    track: tuple[np.ndarray, np.ndarray] | None = None


def marks(jump: Jump) -> Marks:
    """Depths of the inflow's theory, toe and end, and the track of the toe."""
    lines, inflow = {}, jump.inflow
    if inflow:
        lines[f"inflow y₁ = {inflow.depth:.3g} m"] = inflow.depth
        lines[f"Bélanger of the inflow y₂ = {inflow.belanger_y2:.3g} m"] = inflow.belanger_y2
    places = {"toe": jump.toe, "end": jump.end} if isfinite(jump.toe) else {}
    track, direction = jump.measured.track, jump.measured.direction
    if track is None or not track.found.any():
        return Marks(lines, places)
    return Marks(lines, places, (direction * track.toe[track.found], track.time[track.found]))


def tables(jump: Jump) -> Tables:
    """The track, and the mean profile in the moving frame."""
    return jump.measured.tables()


def figures(jump: Jump, gathered: Gathered) -> Drawings:
    """Figures of the jump in time, in its own frame, of its momentum and of the head."""
    return {
        "jump_track.png": partial(track_figure, jump),
        "jump_frame.png": partial(frame_figure, jump),
        "jump_balance.png": partial(balance_figure, jump),
        "energy_head.png": partial(head_figure, gathered.profiles, jump),
    }


def section(jump: Mapping) -> Section:
    """Verdict, states, ratios, momentum balance, lengths; `jump` as in ``summary.json``."""
    blocks = [Text(jump["reason"], "verdict" if jump["verdict"] == "jump" else "warn", jump["verdict"])]
    if inflow := jump.get("inflow"):
        blocks.append(
            Text(
                f"Theory for the inflow (y₁ = {shown(inflow['depth'])} m, {shown(inflow['velocity'])} m/s): Froude "
                f"number {inflow['froude']:.2f} ({inflow['class']}), Bélanger depth {inflow['belanger_y2']:.2f} m, "
                f"length by thesis (4.27) {shown(inflow['length'])} m."
            )
        )
    if jump.get("y1") is not None:
        blocks += [
            _states(jump),
            _comparisons(jump),
            Text(sentence(jump.get("budget") or {})),
            _momentum(jump),
            _roller(jump["roller"]),
            *_tail(jump.get("tail")),
        ]
    return Section("Hydraulic jump", blocks)


def _with_error(value: float | None, error: float | None) -> str:
    if value is None:
        return ABSENT
    return f"{value:.3f}{'' if error is None else f' ± {error:.2g}'}".replace("-", "−")


def _states(jump: Mapping) -> Table:
    numbers = numbers_of(Jump)
    rows = []
    for one, two in STATES:
        label, unit, values = numbers[one].meaning, numbers[one].unit, [jump[one], jump[two]]
        if one == "y1":
            values = [_with_error(jump[key], jump[f"{key}_error"]) for key in (one, two)]
        elif unit == "N/m":
            unit, values = "kN/m", [value / 1e3 for value in values]
        rows.append((heading(label.removesuffix(" upstream").removesuffix(","), unit), *values))
    rows.insert(5, (*described(Jump, jump, "froude")[0], jump["froude_downstream"]))
    return Table(rows, ("State, measured beside the jump", "upstream 1", "downstream 2"))


def _comparisons(jump: Mapping) -> Table:
    ratio, from_mass = jump["sequent_ratio"], jump["mass"]["speed_from_mass"]
    against = [
        ("Bélanger, front's frame", "belanger_ratio"),
        (f"with density ratio {jump['density_ratio']:.3f}", "density_relation_ratio"),
        ("and measured bed force and β", "full_relation_ratio"),
        *([("and measured contact pressure", "pressure_relation_ratio")] if jump["pressure_relation_ratio"] else []),
    ]
    rows = [("s₂/s₁", ratio, words, jump[key], _deviation(ratio, jump[key])) for words, key in against]
    speed = _with_error(jump["speed"], jump["speed_error"])
    words = "from mass, (s₂u₂ − s₁u₁)/(s₂ − s₁)"
    rows.append(("Velocity of the front [m/s]", speed, words, from_mass, _deviation(jump["speed"], from_mass)))
    for key, words, other in (
        ("length", "thesis (4.27)", "length_theory"),
        ("length", "USBR curve", "length_usbr"),
        ("head_lost", "Bélanger", "energy_loss_theory"),
        ("energy_loss", "Bélanger", "energy_loss_theory"),
    ):
        rows.append((*described(Jump, jump, key)[0], words, jump[other], _deviation(jump[key], jump[other])))
    return Table(rows, ("Measured", "", "against", "", "difference"))


def _deviation(measured: float | None, expected: float | None) -> str:
    if measured is None or not expected:
        return ABSENT
    return f"{100 * (measured / expected - 1):+.1f} %".replace("-", "−")


def _momentum(jump: Mapping) -> Text:
    terms, names = jump["momentum_terms"], numbers_of(Balance)
    known = [key for key in names if key != "pressure_error" and terms[key] is not None]
    explained = "; ".join(f"{names[key].meaning} {100 * terms[key]:+.1f} %" for key in known)
    return Text(
        f"Mass flux through the moving front: downstream minus upstream {100 * jump['mass']['closure']:+.2f} %, "
        f"{100 * jump['mass']['closure_with_storage']:+.2f} % with what is stored in between. Momentum function "
        f"upstream minus downstream: {100 * jump['momentum_residual']:+.1f} % of the downstream one; measured parts: "
        f"{explained}."
    )


def _tail(tail: Mapping | None) -> list[Text]:
    if not tail or tail["depth"] is None:
        return []
    text = (
        f"Tail water over {tail['length']:.1f} m: mass depth {_with_error(tail['depth'], tail['depth_error'])} m, "
        f"slope of its surface {_with_error(tail['slope'], tail['slope_error'])}."
    )
    if tail["belanger_y2"] is not None:
        text += (
            f" Bélanger gives {tail['belanger_y2']:.3f} m for the inflow in the front's frame: "
            f"{_deviation(tail['depth'], tail['belanger_y2'])}."
        )
    return [Text(text)]


def _roller(roller: Mapping) -> Text:
    where = "nowhere in the mean"
    if roller["length"] is not None:
        where = f"over {roller['length']:.1f} m, from {roller['start']:.1f} m behind the toe"
    return Text(f"Roller: the mean surface velocity is reversed {where}.")
