# SPDX-License-Identifier: GPL-2.0-or-later
"""Case to Scene: fields become the numbers that every engine takes. Cases that cannot run are refused."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from lammps_jump.errors import FieldError
from lammps_jump.physics import contact
from lammps_jump.physics.slip import FRICTION_LAWS
from lammps_jump.scene import (
    Beginning,
    InletRow,
    Interval,
    MovingWall,
    Outlet,
    Pour,
    Scene,
    Sizes,
    Stations,
)
from lammps_jump.scene.motion import largest_speed, way
from lammps_jump.scene.schedule import Schedule, fitted_step, plan_stations, plan_steps

from . import checks, walls
from .bodies.checks import check_bodies
from .derived import skipped
from .design import tailgate
from .fields import CaseFields, Column
from .foresight import speeds, ways_out
from .foresight.asked import in_vain, light, radians_given
from .foresight.doubts import doubts, held_deep, jump_doubts
from .foresight.grains import heap_doubts
from .packing import TooSoft, arrange, disc_sizes
from .parts import channel, places
from .parts.beds import beds_of
from .parts.earlier import EarlierRun
from .parts.inflow import PourInflow, RowsInflow
from .parts.rows import Inlet, inlet_back, inlet_of
from .parts.taken import Taken, for_walls, padded, take, with_given
from .text import Runs

INTEGRATORS = {"lammps": "velocity_verlet"} | dict.fromkeys(("native", "twin"), "leapfrog_extrapolated")
"""What ``run.integrator: auto`` means, by engine."""
MAX_SPEED_MARGIN = 2.0
"""Ratio of the speed at which a disc could jump over an outlet to the largest speed that the case implies."""

POUR_RASTER = 100
"""Steps at whose multiples poured discs get their own diameter. To set diameters is free at every 100 steps; at every 8
it takes 30 % of a run with stock styles (measured)."""

TOUCH_STEPS = 2.0
"""Width of a smooth touch in steps at v0. Energy box at f = 0.2: 3.1 % error with 1, 1.3 % with 2 (as a sharp contact
at f = 0.05), 0.6 % with 4, while the largest overlap of an elastic collision at v0 grows by 19, 37 and 69 %."""


LAW = {"restitution", "friction", "correct_restitution", "rotation", "tangential_damping", "touch"}
"""Fields of ``contact`` that the coefficients depend on as they stand."""


def contact_coefficients(
    case: CaseFields, integrator: str, sizes: Sizes | None, time_step_fraction: float | None = None
) -> contact.Coefficients:
    """Contact coefficients of a case, with its own step or another (as a share of 2/omega)."""
    return contact.derive(contact_of(case, integrator, sizes, time_step_fraction))


def contact_of(
    case: CaseFields, integrator: str, sizes: Sizes | None, time_step_fraction: float | None = None
) -> contact.ContactNumbers:
    """What a case says of its contacts."""
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
    """Contact coefficients with the step that suits the times asked for; the fraction of the case is its bound."""
    fraction = case.run.time_step_fraction
    longest = contact_coefficients(case, integrator, sizes).time_step
    step = fitted_step(*_times(case), longest)
    return contact_coefficients(case, integrator, sizes, fraction * (step / longest))


def _times(case: CaseFields) -> tuple[float, float, float | None]:
    """Duration, time between frames and window of the probes, s; None without probes."""
    return (
        case.run.duration,
        case.output_interval,
        case.probes.interval if case.probes.forces or case.probes.groups else None,
    )


def build_scene(case: CaseFields, runs: Runs) -> Scene:
    """The engine-neutral form of a validated case; `runs` hold its discs of earlier runs (`CaseSource.begun`).

    Raises
    ------
    FieldError
        Where the numbers cannot make a scene: unstable step, discs that overlap or stand in a wall, an inlet in
        a wall, no rows, unknown probes, discs outside the domain.
    """
    scene = _scene(case, runs)
    return replace(scene, warnings=(*scene.warnings, *told)) if (told := jump_doubts(case, scene)) else scene


def _scene(case: CaseFields, runs: Runs) -> Scene:
    """`build_scene`, without the notes that need the whole scene."""
    begun, warnings = _beginning(case, runs)
    rows = case.inflow if isinstance(case.inflow, RowsInflow) else None
    inlets, raster, hydrograph = inlet_of(rows, begun, case.run.seed) if rows else Inlet()
    theirs = walls.joined(case)
    given = theirs + walls.lifted(case)
    walls.check_bends(given, begun.largest)
    laws = _own_laws(case, begun, given)
    notes = walls.check_own_laws(case, begun, laws, given, _integrator(case))
    moving = [walls.moving(item, case, begun, laws) for item in given]
    notes += speeds.softness(case, begun)
    notes += walls.wall_doubts(moving, begun, laws, inlets) + heap_doubts(case, begun, moving)
    ways = [way(one, *walls.span(begun)) for one in moving]
    speed = max([_largest_speed(case, begun, inlets), *(largest_speed(one, *walls.span(begun)) for one in moving)])
    domain = _domain(case, begun, inlets, speed, ways)
    outlets = _outlets(case, begun, domain, speed)
    fields = {item.wall.name: item.field for item in theirs}
    moving = tailgate.with_holdings(case, begun, moving, fields, domain, inlets)
    gates = walls.shut_gates(case, begun, domain)
    moving += map(MovingWall, inlet_back(case.inflow, begun.largest))
    own_names = checks.check_names(case, [wall for wall, _ in (*moving[len(theirs) :], *gates)])
    places.check_in_domain(case, begun.positions, inlets, domain)
    places.check_places(case, begun, inlets, (*moving, *gates), fields, case.seam)
    if case.seam:
        channel.check_walls(begun, moving, fields, domain)
        notes += channel.lid_doubts(moving, domain, begun.largest)
    notes += check_bodies(
        begun, (*moving, *gates), fields, laws, _integrator(case),
        unstable=case.run.allow_unstable, ground=speeds.lowest_ground(case) if case.bodies else math.inf,
    )  # fmt: skip
    checks.check_pour(case, domain, begun.largest)
    names = [wall.name for wall, _ in moving]
    probes, groups = _probes(case, names), walls.groups(case, moving, own_names)
    asked = {*probes, *(name for _, members in groups for name in members)}
    reached = [one for one in moving if walls.reachable(one, begun, domain)]
    kept = [one for one in moving if one in reached or one.wall.name in asked]
    notes += ways_out.unguarded(case, begun, inlets, moving, domain, outlets)
    notes += ways_out.unused(moving, reached, [item.wall.name for item in theirs])
    notes += in_vain(case, moving) + radians_given(case) + light(case)
    law, pour = case.contact, case.inflow if isinstance(case.inflow, PourInflow) else None
    rubs = law.friction > 0 or any(own.friction for own in laws.values())
    springs = law.springs if rubs else None
    sharp = law.touch == "sharp"
    _, impact_speed, _ = _stiffness(case)
    earlier = for_walls(begun.earlier, (*kept, *gates), remembers=springs is not None)
    scene = Scene(
        **(vars(begun) | {"overlap_limit": begun.overlap_limit * walls.own_overlap(begun, laws), "earlier": earlier}),
        name=case.name,
        description=case.description,
        density=case.discs.density,
        gravity=case.acceleration,
        friction_law=law.friction_law,
        springs=springs,
        contact_output=springs is not None and (case.engine.name != "lammps" or case.analysis.looks_at_contacts),
        rotation=law.rotation and rubs,
        integrator=_integrator(case),
        domain=domain,
        walls=(*kept, *gates),
        own_laws=laws,
        inlets=inlets,
        hydrograph=hydrograph,
        pours=(Pour(**pour.model_dump(exclude={"kind"})),) if pour else (),
        outlets=outlets,
        probes=probes,
        groups=groups,
        stations=_stations(case, begun, inlets, outlets),
        gauges=places.gauges(case, domain[0]),
        seed=case.run.seed,
        skin=case.engine.skin or 0.3 * begun.diameter,
        touch=law.touch,
        touch_width=0.0 if sharp else law.touch_width or TOUCH_STEPS * impact_speed * begun.time_step,
        cohesion=law.attraction(begun.coefficients.mass, case.gravity),
        periodic=case.seam is not None,
        size_steps=raster if inlets else POUR_RASTER,
        skipped=skipped(case, tuple(wall for wall, _ in moving), [wall for wall, _ in kept], begun, laws.values()),
        warnings=(*warnings, *checks.check_stop(case), *doubts(case, impact_speed, inlets), *notes),
        adapted=checks.adapted(case, begun, inlets),
    )
    checks.check_time(case, scene)
    return replace(scene, warnings=(*scene.warnings, *told)) if (told := held_deep(scene)) else scene


def _own_laws(case: CaseFields, begun: Beginning, given: tuple[walls.CaseWall, ...]) -> dict[str, contact.WallLaw]:
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


def _beginning(case: CaseFields, runs: Runs) -> tuple[Beginning, list[str]]:
    """The discs at the start, their contact and the steps of the run; and what to beware of."""
    checks.check_engine(case)
    channel.check_fields(case)
    random, softness = np.random.default_rng(case.run.seed), _stiffness(case)[0]
    standing = [(item.field, item.wall) for item in (*walls.joined(case), *walls.lifted(case))]
    taken = take(case, runs, standing, case.discs.diameter / softness, random)
    integrator, sizes = _integrator(case), with_given(disc_sizes(case), case.discs.diameter, taken)
    coefficients = _coefficients(case, integrator, sizes)
    warnings = checks.check_stability(case, coefficients, integrator, sizes)
    warnings += checks.check_sizes(case, sizes)
    steps, settle = _steps(case, coefficients.time_step, sizes)
    positions, velocities = _discs(case, coefficients, sizes, random, taken)
    beds = beds_of(case.rough, case.seam, len(positions) + 1, sizes, case.discs.diameter)
    positions = np.concatenate([positions, beds.positions])
    velocities = np.concatenate([velocities, 0.0 * beds.positions])
    return Beginning(
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
        earlier=padded(taken, len(positions), beds.fixed),
    ), warnings


def _largest_speed(case: CaseFields, begun: Beginning, inlets: tuple[InletRow, ...]) -> float:
    """Largest speed that the case implies, m/s: at the start, at the inlet, of an impact, of a column's fall."""
    columns = [item.y[1] - item.y[0] for item in case.initial if isinstance(item, Column)]
    falls = [math.sqrt(2 * case.gravity * height) for height in columns]
    start = float(np.hypot(*begun.velocities.T).max(initial=0.0))
    return max([*(row.vx for row in inlets), _stiffness(case)[1], start, *falls])


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
    random: np.random.Generator, taken: Taken | None,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Positions and velocities at the start, each of shape (n, 2), m and m/s; those of earlier runs come first."""
    positions = [np.empty((0, 2)) if taken is None else taken.positions]
    velocities = [np.empty((0, 2)) if taken is None else taken.velocities]
    first = 1 + len(positions[0])
    for index, item in enumerate(case.initial):
        if isinstance(item, EarlierRun):
            continue
        try:
            place, speed = arrange(item, case.discs, case.gravity, coefficients, random, sizes, first)
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


Rectangle = tuple[Interval, Interval]


def _domain(
    case: CaseFields, begun: Beginning, inlets: tuple[InletRow, ...], speed: float,
    ways: list[Rectangle],
) -> Rectangle:  # fmt: skip
    """The given domain, or one around all that the case names, and the ways of walls."""
    if case.domain is not None:
        domain = case.domain.x, case.domain.y
    else:
        closed = any(wall.hollow for wall in case.walls)
        margin = 2 * begun.largest if closed else 10 * begun.largest + speed * min(case.run.duration, 3.0)
        x, y = ((min(e) - margin, max(e) + margin) for e in (_ends(case, axis, begun, inlets, ways) for axis in "xy"))
        domain = x, y
    checks.check_domain(case, domain)
    return domain


def _ends(
    case: CaseFields, axis: str, begun: Beginning, inlets: tuple[InletRow, ...], ways: list[Rectangle]
) -> list[float]:
    """Coordinates that a domain must hold, m."""
    index = "xy".index(axis)
    values = [*begun.positions[:, index], *(getattr(row, axis) for row in inlets)]
    if isinstance(case.inflow, PourInflow):
        values += getattr(case.inflow, axis)
    values += [end for box in ways for end in box[index] if math.isfinite(end)]
    outlets = (pair for item in case.outflow for pair in item.model_dump(exclude_none=True).items())
    return values + [at for name, at in outlets if name.startswith(axis)]


def _outlets(case: CaseFields, begun: Beginning, domain: tuple[Interval, Interval], speed: float) -> tuple[Outlet, ...]:
    outlets = []
    for index, item in enumerate(case.outflow):
        ((field, at),) = item.model_dump(exclude_none=True).items()
        axis = field[0]
        side = "above" if field in ("x_beyond", "y_above") else "below"
        low, high = domain[0 if axis == "x" else 1]
        room = high - at if side == "above" else at - low
        if room <= begun.largest:
            raise FieldError(
                f"outflow.{index}.{field}",
                f"{at:zg} m leaves no room before the edge of the domain ([{low:zg}, "
                f"{high:zg}]); discs need a few metres to be taken out in: widen domain or move the outlet",
            )
        every = max(1, min(begun.output_steps, int(room / (MAX_SPEED_MARGIN * speed * begun.time_step))))
        outlets.append(Outlet(axis, at, side, every))
    return tuple(outlets)


def _probes(case: CaseFields, names: list[str]) -> tuple[str, ...]:
    for index, name in enumerate(case.probes.forces):
        walls.require_wall(case, f"probes.forces.{index}", name, names)
    return tuple(dict.fromkeys(case.probes.forces))


def _stations(
    case: CaseFields, begun: Beginning, inlets: tuple[InletRow, ...], outlets: tuple[Outlet, ...]
) -> Stations | None:
    """The stations of the energy ledger."""
    asked = case.probes.stations
    if asked is None:
        return None
    places = (*(row.x for row in inlets), *(line.at for line in outlets if line.axis == "x"))
    try:
        return plan_stations(asked.x, asked.speed, asked.window, begun, places)
    except ValueError as error:
        raise FieldError("probes.stations", f"{error}") from None
