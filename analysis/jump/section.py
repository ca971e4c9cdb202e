# SPDX-License-Identifier: GPL-2.0-or-later
"""Jump of a run on its pages, in tables and figures."""

# ruff: noqa: RUF001  (Greek letters, minus signs and dashes are meant for readers)
from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import isfinite
from typing import Any

import numpy as np

from lammps_jump.analysis.budgets import head, inflow
from lammps_jump.analysis.budgets.head import EnergyFluxes, energy_budget, why_none
from lammps_jump.analysis.draw.chart import PLACE, Bars, Chart, Drawings, Panel, Trace, stairs
from lammps_jump.analysis.flow import Flow
from lammps_jump.analysis.passes import Gathered, Tables
from lammps_jump.analysis.quantity import HeadlineNumber, Marks, Quantity
from lammps_jump.analysis.report.page import Section, SideBySide, Table, Text, cut, described, heading, percent_of
from lammps_jump.analysis.slope import TurnedFlow, in_place
from lammps_jump.analysis.statistics import Mean, as_fields, propagated
from lammps_jump.analysis.verdicts.jump import is_asked
from lammps_jump.analysis.verdicts.kinds import A_JUMP, AT_SILL, applies, part
from lammps_jump.physics.jump import Inflow
from lammps_jump.units import ABSENT, known, numbers_of, shown

from .found import Budget, Jump, Local, MeasuredJump, TrackedJump, starts_needed
from .result import LEVEL, analyse_jump
from .stream import running_median
from .summary import ASKED, BEFORE, summarise_jump, untimed, worded


def track_chart(jump: TrackedJump) -> Chart | None:
    """Toe, end and equal-mass front against time, with the straight lines fitted; None: no frame has a front."""
    track = jump.track
    if track is None or not track.found.any():
        return None
    lines = [
        Trace("toe", track.time, track.toe),
        Trace("end", track.time, track.end, "second"),
        Trace("front of equal mass", track.time, track.position, "sum"),
    ]
    if track.compression is not None and np.isfinite(track.compression).any():
        lines.append(Trace("", track.time, track.compression, "dots"))
        lines.append(Trace("front of the compression", track.time, running_median(track.compression), "third"))
    if isinstance(jump, MeasuredJump):
        ends = np.array(jump.window)
        lines.append(Trace("fit in the window", ends, jump.motion.start + jump.motion.speed * ends, "fit"))
    return Chart(jump.verdict, jump.flow.time_axis, (Panel(PLACE, lines),), jump.window)


def stream_chart(jump: Jump) -> Chart | None:
    """Momentum flux, thrust and their sum along the stream; what Bélanger makes of its state at each place."""
    stream = jump.stream
    if stream is None:
        return None
    edges = np.append(stream.start, stream.stop[-1])
    parts = (
        ("momentum flux + thrust", stream.total, "sum"),
        ("momentum flux ∑ m u²/(ρ L)", stream.momentum_flux, "first"),
        ("thrust, contact force/ρ", stream.thrust, "second"),
    )
    fluxes = [stairs(label, values, edges, look) for label, values, look in parts if np.isfinite(values).all()]
    marks = {"compression": stream.compression} if isfinite(stream.compression) else {}
    off = stairs("y₂ off Bélanger of this state", 100 * stream.deviation, edges)
    panels = (
        Panel("[m³/s²]", fluxes, marks=marks, ylim=(0.0, None), height=1.5),
        Panel("y₂ off Bélanger [%]", [off], marks=marks),
    )
    return Chart("the stream before the jump", PLACE, panels)


def frame_chart(jump: Jump) -> Chart | None:
    """Mean depth, velocity and packing in the frame of the front, with Bélanger's depth."""
    if not isinstance(jump, MeasuredJump):
        return None
    xi, mean = jump.moving.xi, jump.moving.mean
    depth = mean("mass_depth")
    covered = xi[np.isfinite(depth)]
    limits = max(jump.upstream.zone[0] - 2, covered[0]), min(jump.downstream.zone[1] + 2, covered[-1])
    lines = [Trace("free surface h", xi, mean("surface_depth")), Trace("mass depth s", xi, depth, "second")]
    for state, name in ((jump.upstream, "s₁"), (jump.downstream, "s₂")):
        lines.append(Trace(name, np.array(state.zone), np.full(2, state.mass_depth), "fit"))
    levels = {f"Bélanger, {jump.of}": jump.belanger_y2} if jump.belanger_y2 > 0 else {}
    marks = {"toe": jump.surface_toe, "end": jump.surface_end}
    top = 1.1 * max(np.nanmax(depth), np.nan_to_num(jump.belanger_y2))
    with np.errstate(invalid="ignore", divide="ignore"):
        speeds = [
            Trace("mean velocity u", xi, mean("discharge") / depth),
            Trace("at the surface", xi, mean("surface_velocity"), "second"),
        ]
    panels = (
        Panel("Depth [m]", lines, "", levels, marks, (), limits, (0.0, top), 1.8),
        Panel("Velocity [m/s]", speeds, marks=marks, xlim=limits),
    )
    return Chart("front's frame", "Distance from the front [m]", panels)


def balance_bars(jump: Jump) -> Bars | None:
    """Terms of the momentum balance across the jump, in per cent of the downstream momentum function."""
    terms = jump.momentum_terms
    if terms is None:
        return None
    numbers = [number for number in numbers_of(terms).values() if number.key != "pressure_error"]
    rows = {"Bélanger's balance, 1 − 2": terms.classical}
    rows |= {number.meaning: getattr(terms, number.key) for number in numbers}
    return Bars(
        "Momentum across the jump, front's frame: all parts and their sum",
        "Share of the downstream momentum function [%]",
        {name: 100 * value for name, value in rows.items() if isfinite(value)},
    )


STATES = (
    ("y1", "y2"), ("h1", "h2"), ("u1", "u2"), ("packing_1", "packing_2"), ("beta_1", "beta_2"),
    ("momentum_upstream", "momentum_downstream"), ("head_upstream", "head_downstream"),
)  # fmt: skip
"""Numbers that are side by side in the table of the states."""


def analyse(gathered: Gathered) -> TrackedJump:
    """Jump of a run: on level bed, else on the longest stretch of bed with one slope."""
    jump, along = _analysed(gathered, gathered), gathered.along
    if along is None or jump.verdict in (*A_JUMP, AT_SILL) or not isinstance(along.flow, TurnedFlow):
        return jump
    sloping, looked = _analysed(along, gathered), jump.track is not None
    return jump if looked and sloping.verdict not in A_JUMP else in_place(sloping, along.flow.stretch)


def _analysed(gathered: Gathered, whole: Gathered) -> TrackedJump:
    """Jump of a flow; `whole`: with the inflow."""
    inlet, delivered = inflow.analyse(whole), None
    if inlet is not None and isfinite(inlet.speed):
        delivered = Mean.of(inlet, "depth"), Mean.of(inlet, "speed")
    measured = analyse_jump(gathered.profiles, gathered.flow, gathered.contacts)
    if not _on_level_of_inlet(gathered.flow, measured):
        measured, delivered = replace(measured, flow=replace(gathered.flow, inflow_depth=None)), None
    jump = summarise_jump(measured, delivered)
    if not gathered.flow.timed:
        return untimed(jump)
    jump = worded(jump)
    fluxes = gathered.histories.get("jump")
    budget = energy_budget(fluxes, jump)
    if budget is None:
        why = why_none(fluxes, jump) if jump.verdict in A_JUMP else ""
        return replace(jump, reason=f"{jump.reason} {why}".strip())
    lost = as_fields(head_lost=Mean(budget.lost, budget.inflow_error))
    return replace(jump, budget=budget, **lost)


def _on_level_of_inlet(flow: Flow, measured: TrackedJump) -> bool:
    """Tells whether the bed under the toe is as high as at the inlet: else the inflow is no state before the jump."""
    rows, track = flow.scene.inlets, measured.track
    if isinstance(flow, TurnedFlow) or not rows or track is None or not track.found.any():
        return True
    at_inlet, at_toe = flow.bed_height(np.array([rows[0].x, float(np.median(track.toe[track.found]))]))
    return not abs(at_toe - at_inlet) >= LEVEL * flow.scene.diameter


def marks(jump: TrackedJump) -> Marks:
    """Depths of the inflow's theory, toe and end, and the track of the toe."""
    lines, inflow = {}, jump.inflow
    if inflow:
        lines["inflow asked for"] = inflow.depth
    if jump.of != BEFORE and isfinite(jump.belanger_y2):
        lines["Bélanger of the inflow"] = jump.belanger_y2
    places = {"toe": jump.toe, "end": jump.end} if isfinite(jump.toe) else {}
    track = jump.track
    if track is None or not track.found.any():
        return Marks(lines, places)
    return Marks(lines, places, (track.toe[track.found], track.time[track.found]))


def tables(jump: TrackedJump) -> Tables:
    """The track, the mean profile in the moving frame, and the stream before the jump."""
    tables_of_jump = {}
    if jump.track is not None:
        columns = {name: values for name, values in _arrays(jump.track).items() if name != "reach_end"}
        tables_of_jump["jump_track.csv"] = {**columns, "found": jump.track.found.astype(int)}
    if isinstance(jump, MeasuredJump):
        means = {name: jump.moving.mean(name) for name in jump.moving.fields}
        tables_of_jump["jump_frame.csv"] = {"distance": jump.moving.xi, **means}
    return tables_of_jump | ({"jump_stream.csv": _arrays(jump.stream)} if jump.stream else {})


def _arrays(result: object) -> dict[str, np.ndarray]:
    return {name: values for name, values in vars(result).items() if isinstance(values, np.ndarray)}


def figures(jump: TrackedJump, gathered: Gathered) -> Drawings:
    """Figures of the jump in time, in its own frame, of its momentum and of the head."""
    track: Drawings = {"jump_track": track_chart(jump)}
    if not gathered.flow.timed:
        return track
    return track | {
        "jump_stream": stream_chart(jump),
        "jump_frame": frame_chart(jump),
        "jump_balance": balance_bars(jump),
    }


def section(jump: Jump) -> Section:
    """Verdict, streams, states, balances, lengths."""
    verdict, local = Text(jump.reason, "verdict" if jump.verdict == "jump" else "warn", jump.verdict), jump.local
    if local is None or not known(jump.y1) or not applies("y1", jump.verdict):
        return Section("Hydraulic jump", [verdict, _streams(jump)])
    if not known(jump.speed):
        lengths = Table(described(jump, "length", "length_mass"))
        return Section("Hydraulic jump", [verdict, _states(local), Table(described(local, "sequent_ratio")), lengths])
    steady = applies("length", jump.verdict)
    budget = _budget(jump.budget if steady else None)
    tables = [_streams(jump), _states(local), _momentum_table(local), _balances(jump), budget]
    return Section(
        "Hydraulic jump",
        [
            verdict,
            SideBySide([one for one in tables if one.rows]),
            _sill(jump.inflow),
            Text(SHORT if steady else ""),
            _moved(local),
        ],
    )


def _streams(jump: Jump) -> Table:
    """Every state that is compared with theory: state, frame, Froude number, sequent depth by Bélanger."""
    inflow, local, rows = jump.inflow, jump.local, []
    if known(jump.froude) and applies("froude", jump.verdict) and jump.of != BEFORE:
        rows.append((f"{jump.of}: the comparison at the top", "front", *_pair(jump)))
    if local and known(local.froude) and applies("local.froude", jump.verdict):
        above = ": the comparison at the top" if jump.of == BEFORE else ""
        rows.append((f"{BEFORE}{above}", "front", *_pair(local)))
        rows.append((BEFORE, "laboratory", cut(local, "froude_lab"), ABSENT))
    if inflow:
        at = f"{ASKED}, {shown(inflow.depth)} m at {shown(inflow.velocity)} m/s, exact"
        rows.append((at, "laboratory", f"{inflow.froude:z.2f}", f"{inflow.belanger_y2:z.2f}"))
    return Table(rows, ("State", "frame", "Froude number", "sequent depth by Bélanger [m]"))


def _sill(inflow: Inflow | None) -> Text:
    """The sill that energy asks for, without loss on a broad crest."""
    if inflow is None or not known(inflow.sill) or not inflow.sill:
        return Text("")
    return Text(f"By energy a sill of {shown(inflow.sill)} m holds the jump of the inflow (E₂ − 1.5 y_c).")


def _pair(part: Jump | Local) -> tuple[str, str]:
    return cut(part, "froude"), cut(part, "belanger_y2")


def _states(local: Local) -> Table:
    numbers = numbers_of(Local)
    rows = []
    for one, two in STATES:
        label, unit = numbers[one].meaning, numbers[one].unit
        unit, scale = ("kN/m", 1e3) if unit == "N/m" else (unit, 1.0)
        first = heading(label.removesuffix(" before the toe").removesuffix(","), unit)
        rows.append((first, cut(local, one, scale), cut(local, two, scale)))
    rows.append(("Froude number, front's frame", "above", cut(local, "froude_downstream")))
    rows = [row for row in rows if set(row[1:]) != {ABSENT} and row[-1] != ABSENT]
    return Table(rows, ("State, measured beside the jump", "before the toe 1", "behind the end 2"))


MOVED = (("y1", "moved_y1"), ("froude", "moved_froude"), ("belanger_y2", "moved_belanger_y2"), ("y2", "moved_y2"))


def _moved(local: Local) -> Text:
    """By how much the states move with their stretches."""
    names = {"y1": "s₁", "froude": "Fr", "belanger_y2": "Bélanger's depth", "y2": "s₂"}
    said = [
        f"{names[key]} by {shown(getattr(local, moved), numbers_of(Local)[key].unit, digits=2)}"
        for key, moved in MOVED
        if known(getattr(local, moved))
    ]
    text = f"A stretch one depth s₁ further from the jump changes {', '.join(said)}." if said else ""
    return Text(text.replace("-", "−"))


def _momentum_table(local: Local) -> Table:
    """The sequent ratio next to the jump against momentum: measured thrust first, then what leaves parts out."""
    against = [
        ("momentum with measured thrust, β, bed, slope", "pressure_relation_ratio"),
        ("momentum with measured density, β, bed, slope", "full_relation_ratio"),
        (f"momentum with density ratio {cut(local, 'density_ratio')}", "density_relation_ratio"),
        ("Bélanger with the weight of the jump along the bed", "sloping_ratio"),
        ("Bélanger: hydrostatic, one density", "belanger_ratio"),
    ]
    rows = [
        (words, cut(local, key), _deviation(local, "sequent_ratio", key))
        for words, key in against
        if known(getattr(local, key))
    ]
    return Table(rows, (f"s₂/s₁ beside the jump is {cut(local, 'sequent_ratio')}; against", "", "difference"))


def _balances(jump: Jump) -> Table:
    """Mass through the front, tail water, roller and stream; parts of the momentum are in the figure."""
    mass, tail, roller, stream = jump.mass, jump.tail, jump.roller, jump.stream
    shares = [] if mass is None else [mass.closure, mass.closure_with_storage]
    rows = [
        (f"Mass flux through the front, {words} [%]", f"{100 * share:+z.2f}".replace("-", "−"))
        for share, words in zip(shares, ("downstream less upstream", "the same with storage"), strict=False)
        if known(share)
    ]
    if tail and known(tail.length):
        rows.append((f"Slope of the surface of the tail water, over {tail.length:z.1f} m", cut(tail, "slope")))
    lengths = [] if roller is None else [roller.length_in_jump_frame, roller.length]
    rows += [
        (f"Roller: surface that runs upstream, {frame} [m]", shown(length, digits=2))
        for length, frame in zip(lengths, ("front's frame", "laboratory"), strict=False)
        if known(length)
    ]
    if stream and known(stream.total_deviation):
        words = "Momentum flux + thrust of the stream before the jump: largest change [%]"
        rows.append((words, f"{100 * stream.total_deviation:z.1f}"))
    return Table(rows, ("Balances", ""))


def _budget(budget: Budget | None) -> Table:
    """Energy between two stations, as heads; the head lost is at the top."""
    if budget is None:
        return Table(())
    words = numbers_of(Budget)
    keys = ("carried", "contacts", "storage", "dashpots", "residual")
    values = (cut(budget, key) if hasattr(budget, f"{key}_error") else f"{getattr(budget, key):z.3f}" for key in keys)
    rows = [(heading(words[key].meaning, ""), value.replace("-", "−")) for key, value in zip(keys, values, strict=True)]
    head = f"Energy from {budget.start:+z.1f} to {budget.stop:+z.1f} m from the toe, at {budget.speed:+z.2f} m/s [m]"
    return Table(rows, (head.replace("-", "−"), ""))


def certainty(jump: Jump) -> tuple[str, ...]:
    """Certainty of the numbers, in two paragraphs: the drift within the window, and how many starts are needed."""
    drift, units = jump.drift, numbers_of(Jump)
    if drift is None:
        return ()
    if not known(jump.y2_error):
        return ("The window holds fewer than 16 frames with a jump: one run cannot tell how sure these numbers are.",)
    moved = ", ".join(
        f"{words} {shown(getattr(drift, key), units[key].unit, digits=2)}"
        for key, words in (("y2", "sequent depth"), ("speed", "velocity of the front"), ("length", "length"))
    )
    needed = starts_needed(jump.members)
    return (
        '"At least": one run misses up to 60 % of the variance between starts. '
        f"From the first half of the window to the second: {moved.replace('-', '−')}.",
        (f"For a standard error of 3 %, average at least {needed}." if needed else ""),
    )


def _deviation(local: Local, key: str, other: str) -> str:
    """Deviation of a number from another, in per cent, cut to the errors of both taken as independent."""
    one, two = Mean.of(local, key), Mean.of(local, other)
    if not known(one.value) or not two.value:
        return ABSENT
    measured, expected = (Mean(each.value, each.error if known(each.error) else 0.0) for each in (one, two))
    off = propagated(lambda a, b: a / b - 1.0, measured, expected)
    return percent_of(off.value, off.error, alone=True)


SHORT = (
    "Discs make a short jump, of one to two sequent depths where water needs five to six. They flow like a very "
    "viscous fluid, and contacts dissipate the motion within a few "
    "diameters of the front. A length far below the thesis' and the USBR's is no error of the run."
)
"""Note on the length."""


def _jump_is_shown(wanted: HeadlineNumber, summary: Mapping[str, Any]) -> bool:
    return is_asked(summary) and applies(wanted.key, part(summary, "jump").get("verdict", "jump"))


def _with_errors(jump: Jump) -> list[tuple[str, object]]:
    shown = applies("local.y1", jump.verdict)
    return [("", one) for one in (jump, jump.local, jump.budget, jump.tail)] if shown else []


BELANGER = "y₂ = y₁ (√(1 + 8 Fr₁²) − 1)/2, Bélanger 1828"
LEVEL_BED = "of one jump on a level bed, with hydrostatic pressure on both sides"
QUANTITY = Quantity(
    name="jump",
    title="Hydraulic jump",
    result=Jump,
    definitions="""\
front       where a sharp step between the mean depths would hold the same mass; c is its velocity
toe, end    where the mean profile in the front's frame, smoothed over 0.25 s₂, has made 5 % and 95 % of its rise
length      from toe to end on the free surface; thesis: 9.75 s₁ (Fr₁ − 1)^1.01, USBR: curve of EM 25
s           mass depth, N m/(ρ L); h depth of the free surface; u mean velocity by mass
comparison  mass depth of the tail water (else behind the end) against Bélanger's for the delivered inflow (else the
            stream before the toe), in the front's frame; deviation: their ratio less one
1, 2        beside the jump: a stretch of five depths s₁ that ends five depths before the toe; one of 1.5 depths s₂ that
            begins 0.25 depths behind the end
Fr          (u − c)/√(g s); Bélanger: s₂/s₁ = (√(1 + 8 Fr₁²) − 1)/2
head        s + (u − c)²/2g; loss of head: the energy between two stations that move with the front, carried by
            discs and handed on by contacts, in less out less stored;  momentum function: ρ (s (u − c)² + g s²/2)
β           ∑ m (u − c)² over the same with the mean velocity
thrust      contact force through a vertical plane over ρ, hydrostatic pressure in it; flux: ∑ m u²/(ρ L)
packing     area of the discs over that below the surface;  bulk density: ρ s/h
density     ratio of the bulk densities, downstream over upstream
roller      where the mean velocity of the surface discs is below the front's own
parts       of the momentum balance: each over the downstream momentum function, 1 less 2
errors      standard errors within this run, from eight pieces of the window; "at least": one run cannot tell it
tail water  from 1.2 y₂ behind the front to 0.5 y₂ before the sill
""",
    beside=head.DEFINITIONS,
    collector=EnergyFluxes,
    needs=frozenset({"thrust", "slope"}),
    analyse=analyse,
    files={
        "jump_track.csv": "front and toe of the jump against time",
        "jump_frame.csv": "mean profile in the frame of the front",
        "jump_stream.csv": "the stream before the jump",
    },
    captions={
        "jump_track": "The jump in time",
        "jump_stream": "The stream before the jump",
        "jump_frame": "The jump in its own frame",
        "jump_balance": "Where the momentum goes",
    },
    tables=tables,
    figures=figures,
    linked="jump_track",
    section=section,
    marks=marks,
    notes=lambda jump: jump.notes,
    headline=(
        HeadlineNumber("y2", "Bélanger", "belanger_y2", "sequent depth", holds=LEVEL_BED, source=BELANGER),
        HeadlineNumber(
            "speed",
            "by continuity",
            "mass.speed_from_mass",
            "front velocity",
            plain=True,
            source="(s₂u₂ − s₁u₁)/(s₂ − s₁), s the mass depth, u the mean velocity",
        ),
        HeadlineNumber(
            "length", "water", "length_theory", "jump length", source="9.75 (Fr₁ − 1)^1.01 y₁, thesis (4.27)"
        ),
        HeadlineNumber("length", "USBR", "length_usbr", "jump length", source="USBR, Engineering Monograph 25"),
        HeadlineNumber(
            "head_lost", "Bélanger", "head_lost_theory", "head lost in the jump", holds=LEVEL_BED, source=BELANGER
        ),
        HeadlineNumber("froude"),
    ),
    rank=10,
    is_shown=_jump_is_shown,
    applies=lambda key, jump: applies(key, jump.verdict),
    certainty=certainty,
    shown=is_asked,
    errors=_with_errors,
)
