# SPDX-License-Identifier: GPL-2.0-or-later
"""Case to Scene: fields become the numbers that every engine takes. Cases that cannot run are refused."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from lammps_jump.errors import FieldError
from lammps_jump.physics import contact
from lammps_jump.physics.slip import FRICTION_LAWS
from lammps_jump.scene import InitialState, InletRow, MovingWall, Outlet, Pour, Scene, Sizes, Stations
from lammps_jump.scene.pressed import FaceStretch
from lammps_jump.scene.scene import STABILITY_MEAN, WallWeight
from lammps_jump.scene.schedule import Schedule, fitted_step, plan_stations, plan_steps

from . import channel, checks, derived, speeds, walls, ways_out
from .base import EarlierRun
from .beds import beds_of
from .bodies import check_bodies
from .channel import Inlet, Rectangle, domain_of, implied_speed, inlet_back, inlet_of, outlets_of
from .derived import skipped
from .doubts import (
    behind_the_end,
    doubts,
    held_deep,
    in_vain,
    jump_doubts,
    light,
    never_met,
    radians_given,
    small_bins,
    written_walls,
)
from .earlier import RestartDiscs, for_walls, going_on, load_restart, restart_state, with_given
from .fields import CaseFields
from .inflow import PourInflow, RowsInflow
from .live import check_live, is_live
from .packing import TooSoft, arrange, disc_sizes
from .speeds import curve_doubts, heap_doubts
from .text import Runs

INTEGRATORS = {"lammps": "velocity_verlet"} | dict.fromkeys(("native", "twin"), "leapfrog_extrapolated")
"""Meaning of ``run.integrator: auto``, by engine."""
POUR_RASTER = 100
"""Steps at whose multiples poured discs get their own diameter. To set diameters is free at every 100 steps; at every 8
it takes 30 % of a run with stock styles (measured)."""

TOUCH_STEPS = 2.0
"""Width of a smooth touch in steps at v0. Energy box at f = 0.2: 3.1 % error with 1, 1.3 % with 2 (as a sharp contact
at f = 0.05), 0.6 % with 4, while the largest overlap of an elastic collision at v0 grows by 19, 37 and 69 %."""


LAW = {"restitution", "friction", "correct_restitution", "rotation", "tangential_damping", "touch"}
"""Fields of ``contact`` that the coefficients depend on directly."""


def contact_coefficients(
    case: CaseFields, integrator: str, sizes: Sizes | None, time_step_fraction: float | None = None
) -> contact.Coefficients:
    """Contact coefficients of a case, with its own step or another (as a share of 2/omega)."""
    return contact.derive(contact_of(case, integrator, sizes, time_step_fraction))


def contact_of(
    case: CaseFields, integrator: str, sizes: Sizes | None, time_step_fraction: float | None = None
) -> contact.ContactNumbers:
    """Contact numbers of a case."""
    _, impact_speed, stiffness = _stiffness(case)
    springs = case.contact.springs
    return contact.ContactNumbers(
        **case.discs.model_dump(exclude={"sizes"}),
        **case.contact.model_dump(include=LAW),
        stiffness=stiffness,
        stiffness_wall=case.contact.stiffness_wall or stiffness,
        impact_speed=impact_speed,
        time_step_fraction=time_step_fraction or case.run.time_step_fraction,
        integrator=integrator,
        tangential_damping_ratio=springs.tangential_damping_ratio if springs else None,
        smallest=sizes.smallest if sizes else None,
    )


def _coefficients(case: CaseFields, integrator: str, sizes: Sizes | None) -> contact.Coefficients:
    """Contact coefficients with the step that suits the times requested; the fraction of the case is its bound."""
    fraction = case.run.time_step_fraction
    longest = contact_coefficients(case, integrator, sizes).time_step
    step = fitted_step(*_times(case), longest)
    return contact_coefficients(case, integrator, sizes, fraction * (step / longest))


def _times(case: CaseFields) -> tuple[float, float, float | None]:
    """Duration, time between frames and window of the probes, s; None without probes."""
    return (case.run.duration, case.output_interval, case.probes.interval if case.probes.recorded else None)


def build_scene(case: CaseFields, runs: Runs) -> Scene:
    """The engine-neutral form of a validated case; `runs` hold its discs of earlier runs (`CaseSource.begun`).

    Raises
    ------
    FieldError
        Where the numbers cannot make a scene: unstable step, discs that overlap or are in a wall, an inlet in
        a wall, no rows, unknown probes, discs outside the domain.
    """
    scene = _scene(case, runs)
    return replace(scene, warnings=(*scene.warnings, *texts)) if (texts := jump_doubts(case, scene)) else scene


def _scene(case: CaseFields, runs: Runs) -> Scene:
    """`build_scene`, without the notes that need the whole scene."""
    begun, warnings = _beginning(case, runs)
    geometry = _geometry(case, begun)
    notes = geometry.notes + _check_together(case, begun, geometry)
    seen = _active_walls(case, begun, geometry)
    notes += _foreseen(case, begun, geometry, seen.reached)
    laws, touch = geometry.laws, _touch(case, begun, geometry.laws)
    standing = (*seen.kept, *geometry.gates)
    pour = case.inflow if isinstance(case.inflow, PourInflow) else None
    changed = {
        "overlap_limit": begun.overlap_limit * walls.own_overlap(begun, laws),
        "earlier": for_walls(begun.earlier, standing, remembers=touch["springs"] is not None),
    }
    scene = Scene(
        **(vars(begun) | changed | touch),
        name=case.name,
        description=case.description,
        density=case.discs.density,
        gravity=case.acceleration,
        integrator=_integrator(case),
        domain=geometry.domain,
        walls=standing,
        own_laws=laws,
        inlets=geometry.inlet.rows,
        hydrograph=geometry.inlet.hydrograph,
        pours=(Pour(**pour.model_dump(exclude={"kind"})),) if pour else (),
        outlets=geometry.outlets,
        probes=seen.probes,
        groups=seen.groups,
        stability=seen.weighed,
        pressure=seen.pressed,
        stability_mean=case.probes.stability_mean or STABILITY_MEAN,
        stations=_stations(case, begun, geometry.inlet.rows, geometry.outlets),
        gauges=checks.gauges(case, geometry.domain[0]),
        seed=case.run.seed,
        skin=case.engine.skin or 0.3 * begun.diameter,
        periodic=case.seam is not None,
        size_steps=geometry.inlet.raster if geometry.inlet.rows else POUR_RASTER,
        skipped=skipped(
            case, tuple(one.wall for one in geometry.walls), [one.wall for one in seen.kept], begun, laws.values()
        ),
        warnings=(
            *warnings, *checks.check_stop(case), *doubts(case, _stiffness(case)[1], geometry.inlet.rows), *notes,
        ),
        adapted=checks.adapted(case, begun, geometry.inlet.rows),
    )  # fmt: skip
    checks.check_time(case, scene)
    texts = held_deep(scene) + curve_doubts(case, scene)
    return replace(scene, warnings=(*scene.warnings, *texts)) if texts else scene


class _Geometry(NamedTuple):
    """Geometry around the discs of a scene, and warnings about it.

    Attributes
    ----------
    walls : list of MovingWall
        Of the case, with what raises beds, and the wall behind an inlet.
    gates : tuple of MovingWall
        Those that hold columns until t = 0.
    fields : dict of str to str
        Places in the case of walls that it names, by name.
    names : set of str
        Names that are taken.
    """

    inlet: Inlet
    laws: dict[str, contact.WallLaw]
    walls: list[MovingWall]
    gates: tuple[MovingWall, ...]
    domain: Rectangle
    outlets: tuple[Outlet, ...]
    fields: dict[str, str]
    names: set[str]
    notes: list[str]


def _geometry(case: CaseFields, begun: InitialState) -> _Geometry:
    """Inlet, walls with their contacts and motions, domain and outlets; each is checked by itself."""
    rows = case.inflow if isinstance(case.inflow, RowsInflow) else None
    inlet = inlet_of(rows, begun, case.run.seed) if rows else Inlet()
    theirs = walls.joined(case)
    given = theirs + walls.lifted(case)
    walls.check_bends(given, begun.largest)
    laws = _own_laws(case, begun, given)
    notes = walls.check_own_laws(case, begun, laws, given, _integrator(case))
    moving = [walls.moving(item, case, begun, laws) for item in given]
    notes += speeds.softness(case, begun)
    notes += walls.wall_doubts(moving, begun, laws, inlet.rows) + heap_doubts(case, begun, moving)
    speed = implied_speed(case, begun, inlet.rows, moving, _stiffness(case)[1])
    domain = domain_of(case, begun, inlet.rows, moving, speed)
    outlets = outlets_of(case, begun, domain, speed)
    fields = {item.wall.name: item.field for item in theirs}
    moving = derived.with_holdings(case, begun, moving, fields, domain, inlet.rows)
    gates = walls.shut_gates(case, begun, domain)
    moving += map(MovingWall, inlet_back(case.inflow, begun.largest))
    names = checks.check_names(case, [wall for wall, _ in (*moving[len(theirs) :], *gates)])
    return _Geometry(inlet, laws, moving, gates, domain, outlets, fields, names, notes)


def _check_together(case: CaseFields, begun: InitialState, geometry: _Geometry) -> list[str]:
    """Refuse what does not go together: discs, inlets and walls in each other's place; what to beware of there."""
    standing, rows, notes = (*geometry.walls, *geometry.gates), geometry.inlet.rows, []
    checks.check_in_domain(case, begun.positions, rows, geometry.domain)
    checks.check_places(case, begun, rows, standing, geometry.fields, case.seam)
    if case.seam:
        channel.check_walls(begun, geometry.walls, geometry.fields, geometry.domain)
        notes += channel.lid_doubts(geometry.walls, geometry.domain, begun.largest)
    notes += check_bodies(
        begun, standing, geometry.fields, geometry.laws, _integrator(case),
        unstable=case.run.allow_unstable, ground=speeds.lowest_ground(case) if case.bodies else math.inf,
    )  # fmt: skip
    notes += checks.check_bodies_in_domain(standing, geometry.fields, geometry.domain)
    checks.check_pour(case, geometry.domain, begun.largest)
    return notes


class _ActiveWalls(NamedTuple):
    """Walls that the scene keeps: those that discs reach, and those whose forces are requested."""

    reached: list[MovingWall]
    kept: list[MovingWall]
    probes: tuple[str, ...]
    groups: tuple[tuple[str, tuple[str, ...]], ...]
    weighed: tuple[tuple[str, WallWeight], ...]
    pressed: tuple[FaceStretch, ...]


def _foreseen(case: CaseFields, begun: InitialState, geometry: _Geometry, reached: Sequence[MovingWall]) -> list[str]:
    """Warnings on walls (`reached` by discs), outlets, times and analyses."""
    rows, own = geometry.inlet.rows, list(geometry.fields)
    notes = ways_out.unguarded(case, begun, rows, geometry.walls, geometry.domain, geometry.outlets)
    notes += ways_out.unused(geometry.walls, reached, own) + written_walls(geometry.walls, own)
    notes += walls.weight_doubts(case, geometry.walls, begun)
    notes += never_met(case, begun, rows, geometry.walls, geometry.outlets)
    if case.probes.pressure and case.engine.name == "lammps":
        notes.append("probes.pressure: the native engine alone records it; use engine.name: native")
    notes += in_vain(case, geometry.walls) + radians_given(case) + light(case)
    return notes + behind_the_end(case) + small_bins(case, begun.largest)


def _active_walls(case: CaseFields, begun: InitialState, geometry: _Geometry) -> _ActiveWalls:
    """The walls that matter, and the forces that are requested."""
    probes = _probes(case, [wall.name for wall, _ in geometry.walls])
    groups = walls.groups(case, geometry.walls, geometry.names)
    weighed = walls.weighed(case, geometry.walls)
    required = {*probes, *(name for _, members in groups for name in members), *(name for name, _ in weighed)}
    reached = [
        one for one in geometry.walls if walls.reachable(one, begun, geometry.domain) or is_live(case, one.wall.name)
    ]
    kept = [one for one in geometry.walls if one in reached or one.wall.name in required]
    there = (
        *kept,
        *(one for one in geometry.walls if one not in kept and one.wall.name in (case.probes.pressure or {})),
    )
    return _ActiveWalls(reached, list(there), probes, groups, weighed, walls.pressed(case, there, geometry.domain))


def _touch(case: CaseFields, begun: InitialState, laws: dict[str, contact.WallLaw]) -> dict[str, Any]:
    """Fields of `Scene` on the touch of discs, other than the coefficients."""
    rubs = case.contact.friction > 0 or any(own.friction for own in laws.values())
    width, weight = TOUCH_STEPS * _stiffness(case)[1] * begun.time_step, begun.coefficients.mass * case.gravity
    law = case.contact.law_fields(rubs=rubs, width=width, weight=weight)
    listed = law["springs"] is not None and (case.engine.name != "lammps" or case.analysis.looks_at_contacts)
    return {**law, "contact_output": listed}


def _own_laws(case: CaseFields, begun: InitialState, given: tuple[walls.CaseWall, ...]) -> dict[str, contact.WallLaw]:
    """Contacts of walls that have numbers of their own, by name."""
    stated = contact_of(case, _integrator(case), disc_sizes(case))
    return {
        item.wall.name: contact.own_wall_law(begun.coefficients, item.wall.own_law, stated)
        for item in given
        if any(value is not None for value in item.wall.own_law)
    }


def _integrator(case: CaseFields) -> str:
    if case.run.integrator != "auto":
        return case.run.integrator
    return "velocity_verlet" if FRICTION_LAWS[case.contact.friction_law].remembers else INTEGRATORS[case.engine.name]


def _beginning(case: CaseFields, runs: Runs) -> tuple[InitialState, list[str]]:
    """The discs at the start, their contact and the steps of the run; and what to beware of."""
    checks.check_engine(case)
    channel.check_fields(case)
    check_live(case)
    random, softness = np.random.default_rng(case.run.seed), _stiffness(case)[0]
    pushed = walls.pushed(case)
    going, about = going_on(case, runs, pushed), {one.wall.name: one.about for one in pushed}
    standing = [(item.field, going.placed(item.wall, about)) for item in (*walls.joined(case), *walls.lifted(case))]
    taken = load_restart(case, runs, standing, case.discs.diameter / softness, random, going)
    integrator, sizes = _integrator(case), with_given(disc_sizes(case), case.discs.diameter, taken)
    coefficients = _coefficients(case, integrator, sizes)
    warnings = checks.check_stability(case, coefficients, integrator, sizes)
    warnings += checks.check_sizes(case, sizes)
    steps, settle = _steps(case, coefficients.time_step, sizes)
    positions, velocities = _discs(case, coefficients, sizes, random, taken)
    beds = beds_of(case.rough, case.seam, len(positions) + 1, sizes, case.discs.diameter)
    positions = np.concatenate([positions, beds.positions])
    velocities = np.concatenate([velocities, 0.0 * beds.positions])
    return InitialState(
        diameter=case.discs.diameter,
        sizes=beds.sizes,
        fixed=beds.fixed,
        beds=beds.surfaces,
        coefficients=coefficients,
        overlap_limit=2 * case.discs.diameter / softness,
        stiffer=case.contact.stiffer,
        positions=_frozen(positions),
        velocities=_frozen(velocities),
        steps=settle + steps.run,
        settle_steps=settle,
        output_steps=steps.output,
        probe_steps=steps.probe,
        earlier=restart_state(taken, len(positions), beds.fixed),
    ), warnings


def _frozen(array: np.ndarray) -> np.ndarray:
    array = np.ascontiguousarray(array, float)
    array.setflags(write=False)
    return array


def _stiffness(case: CaseFields) -> tuple[float, float, float]:
    """(n, v0, k): of a given stiffness v0 is the speed that the case states, or leads to, and n that of design."""
    rho, given, k = case.discs.density, case.contact, case.contact.own_stiffness
    if k is None:
        share = given.largest_overlap or speeds.DESIGN
        assert given.impact_speed is not None  # chosen by now
        return 1.0 / share, given.impact_speed, contact.stiffness(rho, share, given.impact_speed)
    through = math.sqrt(k / rho)  # the speed that overlaps by a diameter
    if given.impact_speed is not None:
        return through / given.impact_speed, given.impact_speed, k
    return 1.0 / speeds.DESIGN, speeds.expected(case).speed or speeds.DESIGN * through, k


def _steps(case: CaseFields, dt: float, sizes: Sizes | None) -> tuple[Schedule, int]:
    """Steps of the run, and steps behind the gate before it: whole frames."""
    steps = plan_steps(*_times(case), dt)
    settle = math.ceil(math.ceil(case.settling[0] / dt - 1e-9) / steps.output) * steps.output
    checks.check_size(case, settle, steps.run, steps.output, sizes)
    return steps, settle


def _discs(
    case: CaseFields, coefficients: contact.Coefficients, sizes: Sizes | None,
    random: np.random.Generator, taken: RestartDiscs | None,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Positions and velocities at the start, each of shape (n, 2), m and m/s; those of earlier runs come first."""
    positions = [np.empty((0, 2)) if taken is None else taken.positions]
    velocities = [np.empty((0, 2)) if taken is None else taken.velocities]
    first = 1 + len(positions[0])
    for index, item in enumerate(case.initial):
        if isinstance(item, EarlierRun):
            continue
        try:
            place, speed = arrange(item, case.discs, case.gravity, coefficients, random, sizes, first, case.run.seed)
        except TooSoft as error:
            factor = math.sqrt(error.factor)  # of the speed: overlaps by weight go as 1/k
            enough = case.contact.stiff_for((case.contact.impact_speed or 0.0) * factor, factor)
            raise FieldError(f"initial.{index}", f"{error}: {enough}") from None
        except ValueError as error:
            raise FieldError(f"initial.{index}", f"{error}") from None
        first += len(place)
        positions.append(place)
        velocities.append(speed)
    return np.concatenate(positions), np.concatenate(velocities)


def _probes(case: CaseFields, names: list[str]) -> tuple[str, ...]:
    for index, name in enumerate(case.probes.forces):
        walls.require_wall(case, f"probes.forces.{index}", name, names)
    return tuple(dict.fromkeys(case.probes.forces))


def _stations(
    case: CaseFields, begun: InitialState, inlets: tuple[InletRow, ...], outlets: tuple[Outlet, ...]
) -> Stations | None:
    """The stations of the energy ledger."""
    station_pair = case.probes.stations
    if station_pair is None:
        return None
    places = (*(row.x for row in inlets), *(line.at for line in outlets if line.axis == "x"))
    try:
        return plan_stations(station_pair.x, station_pair.speed, station_pair.window, begun, places)
    except ValueError as error:
        raise FieldError("probes.stations", f"{error}") from None
