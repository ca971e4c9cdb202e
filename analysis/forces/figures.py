# SPDX-License-Identifier: GPL-2.0-or-later
"""Figures and section of the forces: history, impulse, reflected wave, each with its estimate."""

# ruff: noqa: RUF001  (Greek letters, minus signs and dashes are meant for readers)
from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from lammps_jump.analysis.budgets.inflow import Arrivals
from lammps_jump.analysis.draw.chart import TIME, Chart, Drawings, Map, Panel, Trace
from lammps_jump.analysis.draw.maps import xt_map
from lammps_jump.analysis.passes import Gathered
from lammps_jump.analysis.quantity import HeadlineNumber, Named, Quantity
from lammps_jump.analysis.report import Block
from lammps_jump.analysis.report.page import Section, Table, Text, cut, heading
from lammps_jump.analysis.verdicts.kinds import part
from lammps_jump.analysis.verdicts.water import runs_against
from lammps_jump.units import known, numbers_of, sure_of

from .history import LOW_PASS, Force, Forces, analyse_forces
from .impulse import Identity, MomentumHistory, MomentumLedger, with_inflow
from .reflection import ReflectedWave

if TYPE_CHECKING:
    import xarray as xr

LEAST = 1e-6
"""Share of the largest component below which another one is round-off, and not drawn."""
LOOKS = ("first", "second", "sum", "third", "fit")
"""Of the structures, in turn."""


def analyse(gathered: Gathered) -> Forces | None:
    """Forces of a run; None where nothing was recorded."""
    if not gathered.forces:
        return None
    momentum, arrivals = (gathered.histories.get(name) for name in ("force", "inflow"))
    assert momentum is None or isinstance(momentum, MomentumHistory)
    if momentum is not None and isinstance(arrivals, Arrivals):
        momentum = with_inflow(momentum, arrivals, gathered.flow.scene)
    return analyse_forces(gathered.forces, gathered.flow, momentum, gathered.profiles)


def figures(result: Forces, gathered: Gathered) -> Drawings:
    """Figures of the force in time, its impulse, and the reflected wave."""
    return {
        "forces": history_chart(result),
        "impulse": impulse_chart(result),
        "reflected_wave": reflected_map(result, gathered.thinned),
    }


KILO = 1e3
MEANS = ("mean_fx", "mean_fy", "mean_resultant", "mean_angle", "mean_hydrostatic")
LARGEST = ("peak", "peak_time", "resultant", "resultant_angle", "resultant_time", "hydrostatic", "stagnation")
WHOLE = ("impulse_x", "impulse_y")
MOMENTS = ("peak_moment", "moment_x", "moment_y")
OVERTURNING = ("overturning_right", "weight_right", "overturning_left", "weight_left")
"""Numbers of the tables of the section."""


def section(forces: Forces) -> Section:
    """Forces on the probed structures, the impulse identity, the reflected wave."""
    touched = {name: force for name, force in forces.structures.items() if force.component}
    steady = {name: force for name, force in touched.items() if known(force.startup_peak)}
    untouched = [name for name, force in forces.structures.items() if force.reason]
    blocks: list[Block] = [
        _table("Means of the window", steady, MEANS),
        _table(f"Largest, means over {LOW_PASS:zg} s", touched, LARGEST),
        _table("Whole record", touched, WHOLE),
        _moments(touched),
        _table(
            "Overturning", {name: force for name, force in touched.items() if known(force.weight_right)}, OVERTURNING
        ),
        Text(STANDS if any(known(force.weight_right) for force in touched.values()) else "", "small"),
        Text("Directions are angles to the x axis, anticlockwise: −90 degrees is down." if touched else "", "small"),
        Text(f"Nothing touched {', '.join(untouched)}." if untouched else ""),
    ]
    return Section("Forces", [*blocks, *map(Text, forces.notes)])


def _table(title: str, structures: Mapping[str, Force], keys: Sequence[str]) -> Table:
    """Numbers of structures, with their units; forces in kN/m."""
    numbers, rows = numbers_of(Force), []
    scales = {key: KILO if numbers[key].unit.startswith("N") else 1.0 for key in keys}
    for name, force in structures.items():
        shown_numbers = [
            cut(force, key, scale) if sure_of(force, key).value else _scaled(force, key, scale)
            for key, scale in scales.items()
        ]
        rows.append((name, *([component_of(force)] if "peak" in keys else []), *shown_numbers))
    heads = [heading(numbers[key].meaning, f"{'k' * (scale > 1)}{numbers[key].unit}") for key, scale in scales.items()]
    return Table(rows, (title, *(["component"] if "peak" in keys else []), *heads))


STANDS = (
    "A toe is an end of the base, as long as the body stands on it, turned by less than 15 degrees. What the weight "
    "holds is that of the body as it was released: it becomes less as the body turns over the toe."
)
"""Text below the moments about toes."""


def _moments(structures: Mapping[str, Force]) -> Table:
    """Peak moment of each structure, and what it is about."""
    made = _table("Moments, anticlockwise", structures, MOMENTS)
    rows = [
        (row[0], force.moment_about or "not known", *row[1:])
        for row, force in zip(made.rows, structures.values(), strict=True)
    ]
    return made._replace(rows=rows, header=(made.header[0], "about", *made.header[1:]))


def _scaled(force: Force, key: str, scale: float) -> float | None:
    value = getattr(force, key)
    return value / scale if known(value) else None


def component_of(force: Force) -> str:
    """Name of the component of a force, of which its peak is: Fx or Fy."""
    return (force.component or "").replace("f", "F")


def history_chart(result: Forces) -> Chart | None:
    """Force components against time, one panel a structure: windows of the record in grey, low-passed in colour."""
    panels = [_history_panel(name, force) for name, force in result.shown.items()]
    return Chart("force of the discs", TIME, panels) if panels else None


def _history_panel(name: str, force: Force) -> Panel:
    table, component = force.table, force.component or ""
    time, smooth = table["time"], {key: table[f"{key}_smooth"] / 1e3 for key in ("fx", "fy")}
    named = component.replace("f", "F")
    lines = [Trace(f"{named} as recorded", time, table[component] / 1e3, "faint")]
    largest = {key: float(np.nanmax(np.abs(values), initial=0.0)) for key, values in smooth.items()}
    for (key, values), look in zip(smooth.items(), LOOKS, strict=False):
        if largest[key] > LEAST * max(largest.values()):
            lines.append(Trace(f"{key.replace('f', 'F')}, {LOW_PASS:zg} s mean", time, values, look))
    if force.component == "fx" and np.isfinite(table["hydrostatic"]).any():
        sign = np.sign(force.peak) or 1.0
        lines.append(Trace("hydrostatic, wetted face", time, sign * table["hydrostatic"] / 1e3, "theory"))
        if force.wall is not None and force.wall.finite:
            lines.append(Trace("oncoming, ρsu² + ρgs²/2", time, sign * table["oncoming"] / 1e3, "third"))
    if np.isfinite(force.peak):
        lines.append(Trace(f"peak {named}", np.array([force.peak_time]), np.array([force.peak / 1e3]), "measured"))
    shown = np.concatenate([[0.0], *smooth.values()])
    room = 0.2 * (np.nanmax(shown) - np.nanmin(shown))
    ends = np.nanmin(shown) - 0.5 * room, np.nanmax(shown) + room
    return Panel(f"{name}: force [kN/m]", lines, ylim=ends)


def impulse_chart(result: Forces) -> Chart | None:
    """Running impulse and overturning moment of every structure."""
    if not result.shown:
        return None
    impulses, moments = [], []
    for i, (name, force) in enumerate(result.shown.items()):
        look, table, component = LOOKS[i % len(LOOKS)], force.table, force.component or ""
        time, moment = table["time"], table["moment_smooth"]
        impulses.append(
            Trace(f"{name}, {component.replace('f', 'F')}", time, table[f"impulse_{component[1]}"] / 1e3, look)
        )
        if "moment_right_toe_smooth" in table:
            moments += _about_toes(name, force)
        elif np.isfinite(moment).any() and force.component == "fx":
            about = f"about {force.moment_about}" if force.moment_about else "about a point that is not known"
            moments.append(Trace(f"{name}, {about}, anticlockwise", time, moment / KILO, look))
    panels = [Panel("Running impulse [kN s/m]", impulses)]
    panels += [Panel(f"Moment, {LOW_PASS:zg} s mean [kN m/m]", moments)] if moments else []
    return Chart("impulse and overturning moment", TIME, panels)


def _about_toes(name: str, force: Force) -> list[Trace]:
    """Moments of the discs on a body about both ends of its base, and what its weight holds against them."""
    time, traces, shares = force.table["time"], [], {}
    for side, look in (("right", "first"), ("left", "second")):
        values = force.table[f"moment_{side}_toe_smooth"]
        traces.append(Trace(f"{name}, about its {side} toe, anticlockwise", time, values / KILO, look))
        shares[side] = np.nan_to_num(getattr(force, f"overturning_{side}")) / getattr(force, f"weight_{side}")
    side = max(shares, key=shares.__getitem__)
    bears = (-1.0 if side == "right" else 1.0) * getattr(force, f"weight_{side}") / KILO
    stood = np.flatnonzero(np.isfinite(force.table[f"moment_{side}_toe"]))
    ends = time[stood[[0, -1]]] if stood.size else time[:0]
    return [*traces, Trace(f"what its weight holds over the {side} toe", ends, np.full(len(ends), bears), "theory")]


def reflected_map(result: Forces, profiles: xr.Dataset) -> Map | None:
    """Map of the mass depth with the reflected front and its straight-line fit."""
    wave = result.reflected
    if wave is None or wave.position is None or wave.time is None or wave.frames < 3:
        return None
    good = np.isfinite(wave.position)
    ends = wave.time[good][[0, -1]]
    label = f"fit {wave.speed:+z.2f} m/s; bore theory {wave.bore_speed:+z.2f} m/s"
    shown = xt_map(profiles, "mass_depth", title=f"wave thrown back by {wave.structure}")
    front = Trace("reflected front", wave.position[good], wave.time[good], "measured")
    return replace(shown, lines=(front, Trace(label, wave.start + wave.speed * ends, ends, "theory")))


KILO_NEWTON = "kN/m"


def _touched(key: str, summary: Mapping[str, Any]) -> dict[str, str]:
    """Structures of which a number is shown, and their components: those that something touched.

    A stream has a mean of the component, an impact its peak and its impulse.
    """
    touching_sides = {
        name: str(values.get("component") or "fx")
        for name, values in part(summary, "force").items()
        if isinstance(values, Mapping) and not values.get("reason")
    }
    if not summary.get("inflow"):
        return touching_sides if key in ("peak", "impulse") else {}
    return {name: component for name, component in touching_sides.items() if key == f"mean_{component}"}


def _at_rest(wanted: HeadlineNumber, name: str, summary: Mapping[str, Any]) -> bool:
    """Tells whether the mean force on a structure may be held against water at rest: discs do not run to or over it."""
    over = part(summary, "overtopping").get(name) or {}
    return wanted.key != "*.mean_fx" or not (over.get("discs") or runs_against(part(summary, "force")[name]))


PEAK = f"peak {{component}}, {{name}}, {LOW_PASS:zg} s mean"
AT_REST = "of water at rest before an upright face"
QUANTITY = Quantity(
    name="force",
    title="Forces",
    result=Force,
    definitions="""\
peak          largest mean over 0.05 s, of the component with the larger impulse; per metre of width; in the window
              where discs flow in, after t = 0 elsewhere; start-up: the largest before the window
error         standard error within this run: scatter of the maxima of blocks of 0.5 s; only with an inlet
component     Fx or Fy, whichever has the larger integral of its size; none where nothing touched the structure
resultant     √(Fx² + Fy²) of the means over 0.05 s, largest; direction: its angle to the x axis, anticlockwise
sign          a contact pulls for a moment at the end of an impact, because its dashpot acts until the discs part: short
              windows may show a small force of the other sign
impulse       ∫ F dt after t = 0
moment        anticlockwise positive, about the point that stands beside it: of an upright face its foot at the bed; of
              a body its centre of mass or its hinge; of a wall that moves the point that it turns about; of a group the
              point of its first wall; else the point of the wall (docs/case.md)
toes          ends of the base of a body; overturning: the largest moment about a toe that turns the body over it, to
              be held against what its weight holds about the same toe
identity      change of all discs' momentum against the impulse of walls, weight and discs that came and went
wave          place where the mean velocity falls through half of its largest value upstream; bore: of a wall instead
hydrostatic   on the wetted face, largest: ρg(s² − a²)/2 for the mass depth s in front, a of it above the face
oncoming      largest ρsu² + ρgs²/2 two bins in front
""",
    always=lambda flow: bool(flow.scene.probes),
    collector=MomentumLedger,
    needs=frozenset({"forces"}),
    analyse=analyse,
    files={"reflected_wave.csv": "front of the reflected wave against time"},
    captions={"forces": "Force on the structures", "impulse": "Impulse", "reflected_wave": "The reflected wave"},
    tables=Forces.tables,
    figures=figures,
    linked="forces",
    section=section,
    summary=Forces.summary,
    reads=Forces.of,
    headline=(
        HeadlineNumber(
            "*.mean_fx", "hydrostatic", "*.mean_hydrostatic", "mean Fx, {name}", KILO, KILO_NEWTON, holds=AT_REST
        ),
        HeadlineNumber("*.mean_fy", label="mean Fy, {name}", scale=KILO, unit=KILO_NEWTON),
        HeadlineNumber("*.peak", "hydrostatic", "*.hydrostatic", PEAK, KILO, KILO_NEWTON, holds=AT_REST),
        HeadlineNumber("*.impulse", label="impulse of {component}, {name}", scale=KILO, unit="kN s/m", rank=116),
    ),
    rank=110,
    structures=_touched,
    compares=_at_rest,
    errors=lambda found: [*found.structures.items(), ("", found.reflected)],
    named=Named("probe", "name the wall in probes.forces of the case", "structures", "<wall>"),
    parts={
        "settled": dict[str, dict[str, float]],
        "reflected_wave": ReflectedWave,
        "identity": dict[str, Identity],
        "low_pass": float,
        "notes": list[str],
    },
)
