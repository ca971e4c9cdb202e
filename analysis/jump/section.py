# SPDX-License-Identifier: GPL-2.0-or-later
"""What the pages, tables and figures of a run show of its jump."""

# ruff: noqa: RUF001  (Greek letters, minus signs and dashes are meant for readers)
from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import isfinite
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from lammps_jump.analysis.budgets import inflow
from lammps_jump.analysis.draw.chart import Drawings
from lammps_jump.analysis.passes import Gathered, Tables
from lammps_jump.analysis.report.headline import COMPARED, Against, belongs
from lammps_jump.analysis.report.page import Section, Table, Text, described, heading, percent_of, with_error
from lammps_jump.analysis.statistics import STUDENT, Mean, propagated
from lammps_jump.units import ABSENT, is_bound, numbers_of, shown

from .certainty import starts_needed
from .figures import balance_bars, frame_chart, head_chart, stream_chart, track_chart
from .frame import Balance
from .head import energy_budget, no_budget, sentence
from .result import analyse_jump
from .summary import ASKED, BEFORE, Jump, Local, summarise_jump
from .verdict import A_JUMP, untimed, worded

STATES = (
    ("y1", "y2"), ("h1", "h2"), ("u1", "u2"), ("packing_1", "packing_2"), ("beta_1", "beta_2"),
    ("momentum_upstream", "momentum_downstream"), ("head_upstream", "head_downstream"),
)  # fmt: skip
"""Numbers that stand side by side in the table of the states."""
FROUDE = ("froude", "froude_downstream")


def analyse(gathered: Gathered) -> Jump:
    """Jump of a run."""
    inlet = inflow.analyse(gathered)
    known = inlet is not None and isfinite(inlet.speed)
    delivered = (Mean.of(inlet, "depth"), Mean.of(inlet, "speed")) if known else None
    measured = analyse_jump(gathered.profiles, gathered.flow, gathered.contacts)
    found = summarise_jump(measured, delivered)
    if not gathered.flow.timed:
        return untimed(found)
    found = worded(found)
    budget = energy_budget(gathered.histories.get("jump"), found.measured)
    if budget is None:
        why = no_budget(gathered.flow) if found.verdict in A_JUMP else ""
        return replace(found, reason=f"{found.reason} {why}".strip())
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
    lines, asked = {}, jump.inflow
    if asked:
        lines[f"inflow asked for y₁ = {asked.depth:.3g} m"] = asked.depth
    if jump.of != BEFORE and isfinite(jump.belanger_y2):
        lines[f"Bélanger of the inflow, front's frame, y₂ = {jump.belanger_y2:.3g} m"] = jump.belanger_y2
    places = {"toe": jump.toe, "end": jump.end} if isfinite(jump.toe) else {}
    track = jump.measured.track
    if track is None or not track.found.any():
        return Marks(lines, places)
    return Marks(lines, places, (track.toe[track.found], track.time[track.found]))


def tables(jump: Jump) -> Tables:
    """The track, the mean profile in the moving frame, and the stream before the jump."""
    result, found = jump.measured, {}
    if result.track is not None:
        columns = {name: values for name, values in _arrays(result.track).items() if name != "reach_end"}
        found["jump_track.csv"] = {**columns, "found": result.track.found.astype(int)}
    if result.moving is not None:
        means = {name: result.moving.mean(name) for name in result.moving.fields}
        found["jump_frame.csv"] = {"distance": result.moving.xi, **means}
    return found | ({"jump_stream.csv": _arrays(result.stream)} if result.stream else {})


def _arrays(result: object) -> dict[str, np.ndarray]:
    return {name: values for name, values in vars(result).items() if isinstance(values, np.ndarray)}


def figures(jump: Jump, gathered: Gathered) -> Drawings:
    """Figures of the jump in time, in its own frame, of its momentum and of the head."""
    track: Drawings = {"jump_track": track_chart(jump)}
    if not gathered.flow.timed:
        return track
    return track | {
        "jump_stream": stream_chart(jump),
        "jump_frame": frame_chart(jump),
        "jump_balance": balance_bars(jump),
        "energy_head": head_chart(gathered.profiles, jump),
    }


def section(jump: Mapping) -> Section:
    """Verdict, states, ratios, momentum balance, lengths; `jump` as in ``summary.json``."""
    blocks = [Text(jump["reason"], "verdict" if jump["verdict"] == "jump" else "warn", jump["verdict"])]
    known = jump.get("y1") is not None and belongs("y1", jump)
    if known and jump["speed"] is None:
        local = Table(described(Local, jump["local"], "sequent_ratio"))
        return Section("Hydraulic jump", [*blocks, _states(jump["local"]), local, _lengths(jump)])
    if not known:
        return Section("Hydraulic jump", [*blocks, _streams(jump)])
    steady = belongs("length", jump)
    blocks += [
        _momentum_table(jump),
        _momentum(jump),
        _streams(jump),
        _sill(jump.get("inflow")),
        _comparisons(jump),
        Text(SHORT if steady else ""),
        certainty(jump),
        _states(jump["local"]),
        _moved(jump["local"]),
        Text(sentence((jump.get("budget") or {}) if steady else {})),
        _roller(jump),
        *_tail(jump.get("tail")),
        *_stream(jump.get("stream")),
    ]
    return Section("Hydraulic jump", blocks)


def _lengths(jump: Mapping) -> Table:
    return Table(described(Jump, jump, "length", "length_mass"))


def _streams(jump: Mapping) -> Table:
    """Every state that theory is asked about: state, frame, Froude number, sequent depth by Bélanger."""
    asked, local = jump.get("inflow"), jump.get("local")
    rows: list[tuple] = []
    if jump.get("froude") is not None and belongs("froude", jump) and jump["of"] != BEFORE:
        rows.append((f"{jump['of']}: the comparison above", "front", *_pair(jump)))
    if local and local["froude"] is not None and belongs("local.froude", jump):
        above = ": the comparison above" if jump["of"] == BEFORE else ""
        rows.append((f"{BEFORE}{above}", "front", *_pair(local)))
        rows.append((BEFORE, "laboratory", with_error(local, "froude_lab"), ABSENT))
    if asked:
        at = f"{ASKED}, {shown(asked['depth'])} m at {shown(asked['velocity'])} m/s, exact"
        rows.append((at, "laboratory", f"{asked['froude']:.2f}", f"{asked['belanger_y2']:.2f}"))
    return Table(rows, ("State", "frame", "Froude number", "sequent depth by Bélanger [m]"))


def _sill(asked: Mapping | None) -> Text:
    """The sill that energy asks for, without loss on a broad crest."""
    sill = (asked or {}).get("sill")
    return Text(f"By energy a sill of {shown(sill)} m holds the jump of the inflow (E₂ − 1.5 y_c)." if sill else "")


def _pair(found: Mapping) -> tuple[str, str]:
    return with_error(found, "froude"), with_error(found, "belanger_y2")


def _states(local: Mapping) -> Table:
    numbers = numbers_of(Local)
    rows = []
    for one, two in STATES:
        label, unit = numbers[one].meaning, numbers[one].unit
        unit, scale = ("kN/m", 1e3) if unit == "N/m" else (unit, 1.0)
        values = [with_error(local, key, scale) for key in (one, two)]
        rows.append((heading(label.removesuffix(" before the toe").removesuffix(","), unit), *values))
    rows.insert(5, ("Froude number, front's frame", *(with_error(local, key) for key in FROUDE)))
    rows = [row for row in rows if set(row[1:]) != {ABSENT}]
    return Table(rows, ("State, measured beside the jump, ± within this run", "before the toe 1", "behind the end 2"))


MOVED = (("y1", "moved_y1"), ("froude", "moved_froude"), ("belanger_y2", "moved_belanger_y2"), ("y2", "moved_y2"))


def _moved(local: Mapping) -> Text:
    """By how much the states move with their stretches."""
    names = {"y1": "s₁", "froude": "Fr", "belanger_y2": "Bélanger's depth", "y2": "s₂"}
    said = [
        f"{names[key]} by {shown(local[moved], numbers_of(Local)[key].unit, digits=2)}"
        for key, moved in MOVED
        if local[moved] is not None
    ]
    text = f"A stretch one depth s₁ further from the jump changes {', '.join(said)}." if said else ""
    return Text(text.replace("-", "−"))


def _momentum_table(jump: Mapping) -> Table:
    """The sequent ratio beside the jump against momentum: the measured thrust first, then what leaves parts out."""
    local = jump["local"]
    against = [
        ("momentum with measured thrust, β, bed, slope", "pressure_relation_ratio"),
        ("momentum with measured density, β, bed, slope", "full_relation_ratio"),
        (f"momentum with density ratio {with_error(local, 'density_ratio')}", "density_relation_ratio"),
        ("Bélanger: hydrostatic, one density", "belanger_ratio"),
    ]
    measured = with_error(local, "sequent_ratio")
    rows = [
        (measured, words, with_error(local, key), _deviation(local, "sequent_ratio", key))
        for words, key in against
        if local[key] is not None
    ]
    return Table(rows, ("s₂/s₁ beside the jump, ± within this run", "against", "", "difference"))


def _comparisons(jump: Mapping) -> Table:
    """The rows of `headline.COMPARED` that go with the verdict."""
    rows = [
        (_place(jump, row.key), with_error(jump, row.key), row.words, *_theory(jump, row))
        for row in COMPARED
        if belongs(row.key, jump) and jump.get(row.key) is not None
    ]
    return Table(rows, ("Measured, ± within this run", "", "against", "", "difference"))


def _theory(jump: Mapping, row: Against) -> tuple[str, str]:
    """What theory says, and how far the measured number lies off it."""
    part, _, key = row.theory.rpartition(".")
    held = jump[part] if part else jump
    if row.key == "y2":
        off, error = jump["belanger_deviation"], jump["belanger_deviation_error"]
        return with_error(held, key), percent_of(off, error, bound=is_bound(jump, "belanger_deviation"))
    other = jump | {"theory": held[key], "theory_error": held.get(f"{key}_error")}
    return with_error(held, key), _deviation(other, row.key, "theory")


def _place(jump: Mapping, key: str) -> str:
    """Head of a row: the meaning, of the head lost with its stations."""
    head = described(Jump, jump, key)[0][0]
    if key == "head_lost" and (budget := jump.get("budget")):
        head += f", {budget['start']:+.1f} to {budget['stop']:+.1f} m from the toe".replace("-", "−")
    return head


def certainty(jump: Mapping) -> Text:
    """How sure the numbers are: what ± means, the drift within the window, and how many starts are needed."""
    if jump["y2_error"] is None:
        return Text(
            "The window holds fewer than 16 frames with a jump: one run cannot tell how sure these numbers are."
        )
    drifts, units = jump["drift"], numbers_of(Jump)
    keys = ("y2", "speed", "length")
    moved = ", ".join(f"{units[key].label} {shown(drifts[key], units[key].unit, digits=2)}" for key in keys)
    needed = starts_needed(jump["members"])
    return Text(
        f"± is one standard error within this run; a 95 % interval is ± {STUDENT:.2f} errors. From the first half "
        f"of the window to the second: {moved.replace('-', '−')}. "
        '"At least": one run cannot tell this error, it misses up to 60 % of the variance between starts. '
        + (f"For a standard error of 3 %, average at least {needed}." if needed else "")
    )


def _deviation(found: Mapping, key: str, other: str) -> str:
    """How far a number lies off another, in per cent, with the errors of both taken as independent."""
    if found[key] is None or not found[other]:
        return ABSENT
    two = (Mean(found[name], found.get(f"{name}_error") or 0.0) for name in (key, other))
    off = propagated(lambda measured, expected: measured / expected - 1.0, *two)
    return percent_of(off.value, off.error or None, bound=is_bound(found, key) or is_bound(found, other))


def _momentum(jump: Mapping) -> Text:
    terms, names = jump["momentum_terms"], numbers_of(Balance)
    known = [key for key in names if key != "pressure_error" and terms[key] is not None]
    local = jump["local"]
    error, unsure = local["momentum_residual_error"], is_bound(local, "momentum_residual")
    residual = percent_of(local["momentum_residual"], error, bound=unsure)
    explained = "; ".join(
        f"{names[key].meaning} {percent_of(terms[key], terms.get(f'{key}_error'), bound=is_bound(terms, key))}"
        for key in known
    )
    return Text(
        f"Mass flux through the moving front: downstream minus upstream {100 * jump['mass']['closure']:+.2f} %, "
        f"{100 * jump['mass']['closure_with_storage']:+.2f} % with what is stored in between. Momentum function "
        f"upstream minus downstream: {residual} of the "
        f"downstream one; measured parts: {explained}. ± is within this run; one run has no error for the others."
    )


def _tail(tail: Mapping | None) -> list[Text]:
    if not tail or tail["length"] is None:
        return []
    return [Text(f"Tail water over {tail['length']:.1f} m: slope of its surface {with_error(tail, 'slope')}.")]


MOST_STRETCHES = 8
"""Rows of the table of the stream; the file has all."""


def _stream(stream: Mapping | None) -> list[Text | Table]:
    """The stream before the jump by stretches."""
    if not stream:
        return []
    count = len(stream["start"])
    chosen = sorted({round(i) for i in np.linspace(0, count - 1, min(count, MOST_STRETCHES))})
    rows = [
        (
            f"{stream['start'][i]:.4g} … {stream['stop'][i]:.4g}".replace("-", "−"),
            *(stream[key][i] for key in ("mass_depth", "velocity", "momentum_flux", "thrust")),
            shown(stream["total"][i], error=stream["total_error"][i]),
            stream["froude"][i],
            percent_of(stream["deviation"][i], None),
        )
        for i in chosen
    ]
    head = ("Stream, x [m]", "s [m]", "u [m/s]", "flux [m³/s²]", "thrust [m³/s²]", "sum [m³/s²]", "Fr",
            "y₂ off Bélanger")  # fmt: skip
    text = (
        "The stream before the jump, laboratory; Fr and Bélanger of each stretch in the front's frame. ± of the sum "
        "is within this run; one run has no errors for the other columns."
    )
    if stream["total_deviation"] is not None:
        text += f" Momentum flux + thrust stays within {100 * stream['total_deviation']:.1f} % of its mean."
    return [Text(text), Table(rows, head)]


def _roller(jump: Mapping) -> Text:
    """The backflow at the surface, in the front's frame and in the laboratory."""
    roller, depth = jump["roller"], jump["y2"]
    if roller["length_in_jump_frame"] is None:
        said = "No roller: nowhere does the mean surface run upstream faster than the front itself."
    else:
        length, start = roller["length_in_jump_frame"], roller["start_in_jump_frame"]
        said = (
            f"Roller: in the front's frame the mean surface runs upstream over {length:.1f} m "
            f"({length / depth:.1f} y₂), from {start:.1f} m behind the toe (no error from one run)."
        )
    if roller["length"] is not None:
        said += f" In the laboratory, where the front's own speed is in it: over {roller['length']:.1f} m."
    return Text(said)


SHORT = (
    "Discs make a short jump, of one to two sequent depths where water needs five to six. They flow like a very "
    "viscous fluid, and contacts dissipate the motion within a few "
    "diameters of the front. A length far below the thesis' and the USBR's is no error of the run."
)
"""Said beside the length."""
