# SPDX-License-Identifier: GPL-2.0-or-later
"""Checks of a case that need more than one field: stability of the step, size, engine, inflow, places in the domain.

Each raises `FieldError` with the remedy.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from math import isinf, pi, radians, tan

import numpy as np

from lammps_jump.errors import FieldError
from lammps_jump.physics import contact
from lammps_jump.physics.inlet import LEAST_GAP, REFUSAL_GAP, TRAVEL
from lammps_jump.physics.slip import FRICTION_LAWS, slip_warnings, spring_warnings
from lammps_jump.scene import InitialState, InletRow, Interval, MovingWall, Scene, Sizes, Wall
from lammps_jump.scene.schedule import MOST_BINS, MOST_FRAMES, rounding_notes, told_of_window, windows_of
from lammps_jump.scene.shapes import open_ends

from .discs import Column, PackedBed
from .fields import CaseFields
from .inflow import PourInflow, RowsInflow
from .packing import deepest_overlap, discs_at_start

MOST_STEPS = 2_000_000_000
"""LAMMPS counts steps of one run and insertions in 32 bits."""
MOST_DISCS = 20_000_000
MOST_CELLS = 500_000_000
"""LAMMPS counts its bins, of about two thirds of a diameter, in 32 bits; they take four bytes each."""
CONTRADICTION = 0.2
"""Share by which depth or velocity of a column at the inlet may differ from the inflow's before a note says so."""
LEVEL_FRICTION = 0.02
"""Largest friction, less the slope of the bed, at which the tail water of a jump became nearly level (measured)."""

TWIN_SECONDS = 3e-5
"""Processor time of the twin for a step of a disc that lies on others, on one core of a Zen 3, s."""
MOST_TWIN_HOURS = 2


def check_size(case: CaseFields, settle_steps: int, steps: int, output_steps: int, sizes: Sizes | None) -> None:
    """Refuse more steps, frames or discs than a run can hold, before arrays are made."""
    if settle_steps and settle_steps + steps > MOST_STEPS >= steps:
        settle, index = case.settling
        raise FieldError(
            f"initial.{index}.settle",
            f"{settle:zg} s behind the gate are {settle_steps:z.3g} steps, with those of "
            f"run.duration {settle_steps + steps:z.3g}; allowed are {MOST_STEPS:z.0e}: shorten it",
        )
    if steps > MOST_STEPS:
        raise FieldError(
            "run.duration",
            f"{case.run.duration:zg} s are {steps:z.3g} steps; allowed are {MOST_STEPS:z.0e}: "
            "shorten it, raise run.time_step_fraction or lower the stiffness",
        )
    frames = (settle_steps + steps) // output_steps + 1  # the first is that of the start
    if frames > MOST_FRAMES:
        raise FieldError(
            "run.output_interval",
            f"{case.output_interval:zg} s make {frames} frames; allowed are {MOST_FRAMES}: write fewer",
        )
    discs = discs_at_start(case, sizes)
    if discs > MOST_DISCS:
        raise FieldError("initial", f"{discs} discs at the start; allowed are {MOST_DISCS}: take larger discs or fewer")


def check_domain(case: CaseFields, domain: tuple[Interval, Interval]) -> None:
    """Refuse a domain too large for neighbour lists, and bins that do not suit it."""
    (xlo, xhi), (ylo, yhi) = domain
    cells = (xhi - xlo) * (yhi - ylo) / case.discs.diameter**2
    if cells > MOST_CELLS:
        raise FieldError(
            "domain",
            f"x [{xlo:zg}, {xhi:zg}], y [{ylo:zg}, {yhi:zg}] has room for {cells:z.3g} discs of "
            f"{case.discs.diameter:zg} m; allowed is room for {MOST_CELLS:z.0e}: give a smaller domain or take larger "
            "discs",
        )
    width = case.analysis.bin_width
    length = xhi - xlo
    if width is not None and length / width > MOST_BINS:
        raise FieldError(
            "analysis.bin_width",
            f"{width:zg} m would make {length / width:z.0f} bins over {length:zg} m; allowed are {MOST_BINS}: widen it",
        )
    if width is not None and width > length:
        raise FieldError(
            "analysis.bin_width",
            f"{width:zg} m is wider than the domain; allowed is up to its {length:zg} m: make the bins narrower",
        )


def check_names(case: CaseFields, made: Iterable[Wall]) -> set[str]:
    """Refuse names of walls that the program gives: to the wall behind an inlet, to gates, to faces of a box.

    Parameters
    ----------
    case : CaseFields
    made : iterable of Wall
        The walls that the program adds.

    Returns
    -------
    set of str
        These names.
    """
    own = {}
    for wall in made:
        gate = "of the gate before a column"
        own[wall.name] = gate if wall.name.startswith("gate") else "of the wall behind the inlet"
        own |= {f"{wall.name}_{part}": "of the far face of a gate" for part in wall.parts}
    for item in case.walls:
        own |= {f"{item.name}_{part}": f"of a face of {item.kind} '{item.name}'" for part in item.parts}
    for index, item in enumerate(case.walls):
        for field, name in (("name", item.name), ("join", getattr(item, "join", None))):
            if name in own:
                raise FieldError(
                    f"walls.{index}.{field}", f"'{name}' is the name {own[name]}; give this wall another one"
                )
    return set(own)


def check_pour(case: CaseFields, domain: tuple[Interval, Interval], largest: float) -> None:
    """Refuse a pour that cannot fall, or whose region does not hold the largest disc or reaches out of the domain."""
    pour = case.inflow
    if not isinstance(pour, PourInflow):
        return
    if case.gravity == 0:
        raise FieldError("gravity", "is 0, so that poured discs do not fall; allowed is > 0 with inflow kind: pour")
    if case.slope != 0:
        raise FieldError(
            "slope", f"is {case.slope:zg} degree; discs are poured straight down: allowed is 0 with inflow kind: pour"
        )
    d = largest
    for axis, (low, high), limits in zip("xy", (pour.x, pour.y), domain, strict=True):
        if high - low < d * (1 - 1e-9):
            raise FieldError(
                f"inflow.{axis}",
                f"[{low:zg}, {high:zg}] is {high - low:zg} m wide; allowed is a disc's {d:zg} m or more: widen it",
            )
        if low < limits[0] or high > limits[1]:
            raise FieldError(
                f"inflow.{axis}",
                f"[{low:zg}, {high:zg}] reaches out of the domain; allowed is within [{limits[0]:zg}, "
                f"{limits[1]:zg}]: move the pour or widen domain.{axis}",
            )
    held = pour.volume_fraction * (pour.x[1] - pour.x[0]) * (pour.y[1] - pour.y[0]) / (pi * d * d / 4)
    if held < 1:
        raise FieldError(
            "inflow.volume_fraction",
            f"{pour.volume_fraction:zg} of the region is {held:z.3g} discs; allowed is "
            "one disc or more: raise it or widen inflow.x or inflow.y",
        )


def twin_seconds(scene: Scene) -> float:
    """Time that a run takes on the twin, about, s."""
    return TWIN_SECONDS * scene.steps * scene.expected_discs


def check_time(case: CaseFields, scene: Scene) -> None:
    """Refuse what would take hours on the twin."""
    hours = twin_seconds(scene) / 3600
    if case.engine.name == "twin" and hours > MOST_TWIN_HOURS:
        raise FieldError(
            "engine.name",
            f"twin: {scene.steps} steps of up to {scene.expected_discs} discs take about "
            f"{hours:z.3g} h in plain Python; allowed are {MOST_TWIN_HOURS}: lower run.duration or the number "
            "of discs, or use engine.name: native",
        )


def check_engine(case: CaseFields) -> None:
    """Refuse what the engine or kernel of the case cannot do."""
    engine, kernel = case.engine.name, case.engine.kernel
    if engine == "lammps" and case.probes.stations:
        raise FieldError(
            "probes.stations", "the energy between stations is kept by the native engine alone; use engine.name: native"
        )
    if engine == "lammps" and case.run.integrator == "leapfrog_extrapolated":
        raise FieldError("run.integrator", "leapfrog_extrapolated is the native engine's; use engine.name: native")
    if case.run.integrator == "leapfrog_extrapolated" and FRICTION_LAWS[case.contact.friction_law].remembers:
        raise FieldError(
            "run.integrator",
            "leapfrog_extrapolated is not there for friction_law: history; use auto or velocity_verlet",
        )
    if engine == "lammps" and kernel == "stock":
        if isinstance(case.inflow, RowsInflow) and case.inflow.table:
            raise FieldError(
                "inflow.table",
                "is not in stock LAMMPS, which inserts discs at one interval and speed; use engine.kernel: compiled or "
                "engine.name: native",
            )
        if case.bodies:
            raise FieldError(
                "bodies",
                "are not in stock LAMMPS, whose walls follow formulas; use engine.kernel: auto or engine.name: native",
            )
        law = case.contact.friction_law
        if case.contact.friction > 0 and not FRICTION_LAWS[law].in_stock:
            known = " or ".join(name for name, one in FRICTION_LAWS.items() if one.in_stock)
            raise FieldError(
                "contact.friction_law",
                f"'{law}' is not in stock LAMMPS; use friction_law: {known}, "
                "engine.kernel: compiled or engine.name: native",
            )
        if case.contact.touch == "smooth":
            raise FieldError(
                "contact.touch", "'smooth' is not in stock LAMMPS; use engine.kernel: compiled or engine.name: native"
            )
        if case.contact.cohesion is not None:
            raise FieldError(
                "contact.cohesion",
                "a constant attraction of discs that touch is not in the styles of stock LAMMPS that "
                "this program writes; use engine.kernel: compiled or engine.name: native",
            )


def _against_inflow(case: CaseFields) -> list[str]:
    """Notes on columns at the inlet whose depth or velocity is not that of the rows that flow in after them."""
    rows, notes = case.inflow, []
    if not isinstance(rows, RowsInflow):
        return []
    for index, item in enumerate(case.initial):
        first, towards = rows.over(0.0, 0.0)
        if not isinstance(item, Column) or item.x[0] - rows.x > first or item.x[1] <= rows.x or not first:
            continue
        depth, speed = item.y[1] - item.y[0], item.velocity[0]
        if abs(depth / first - 1) > CONTRADICTION or abs(speed / towards - 1) > CONTRADICTION:
            notes.append(
                f"initial.{index}: the column at the inlet is {depth:z.3g} m deep at {speed:z.3g} m/s, the inflow "
                f"{first:z.3g} m at {towards:z.3g} m/s: both meet at t = 0 and a wave runs off; give the "
                "column the inflow's depth and velocity, or begin it further down"
            )
    return notes


LEAP = 1.75
"""Growth of an inflow's speed while the stream runs `TRAVEL` depths from which on discs are refused (measured)."""


def check_sizes(case: CaseFields, sizes: Sizes | None) -> list[str]:
    """Refuse a law that discs of several sizes do not have; return notes on what sizes mean for the scene."""
    friction = case.contact.friction
    if sizes and friction and case.contact.restitution == 1 and not case.contact.springs:
        raise FieldError(
            "contact.friction",
            f"is {friction:zg} with restitution 1; with discs.sizes the tangential dashpot is a "
            "multiple of the normal one, which is 0 then: allowed is friction 0, restitution below 1, or equal discs",
        )
    notes = []
    if isinstance(case.inflow, RowsInflow) and case.inflow.spacing < REFUSAL_GAP:
        notes.append(
            f"inflow.spacing {case.inflow.spacing:zg}: discs so close slow each other down and find their places "
            f"occupied, so that some per cent do not enter; take {LEAST_GAP:zg}"
        )
    if isinstance(case.inflow, RowsInflow) and case.analysis.jump:
        if not sizes:
            notes.append(
                "equal discs pack into a crystal behind the front: the tail water becomes a block with steps; for a "
                "level surface spread the sizes, discs.sizes: {kind: uniform, spread: 0.2}"
            )
        if friction - tan(radians(case.slope)) > LEVEL_FRICTION:
            notes.append(
                f"friction {friction:zg} on this bed makes a heap that runs upstream, not a level jump: the bed "
                f"holds a sloping surface; for a hydraulic jump take contact.friction up to {LEVEL_FRICTION:zg}"
            )
    notes += [*_against_inflow(case), *_leaping(case)]
    return notes + _sinking(case, sizes) + _loose_beds(case)


def _leaping(case: CaseFields) -> list[str]:
    """A note on an inflow whose speed grows so fast that the flow backs up to the inlet."""
    if not isinstance(case.inflow, RowsInflow) or not case.inflow.table:
        return []
    ratio, time = case.inflow.hydrograph.leap
    if ratio < LEAP:
        return []
    return [
        f"inflow.table: from t = {time:zg} s on the speed grows {ratio:z.3g}-fold within {TRAVEL:zg} depths of "
        "its way: fast discs run into slow ones, the flow backs up, and discs may be refused at the inlet (0.6 "
        f"% where a speed doubled so, 6 % where it grew fourfold); let it grow less than {LEAP:zg}-fold over that way"
    ]


def _sinking(case: CaseFields, sizes: Sizes | None) -> list[str]:
    """A note on columns of several sizes that would settle behind their gate, if they were given time."""
    sink = [
        f"initial[{index}]"
        for index, item in enumerate(case.initial)
        if isinstance(item, Column) and item.hydrostatic and item.gate and not item.settle and not any(item.velocity)
    ]
    if not (sizes and sink and case.gravity):
        return []
    return [
        f"{', '.join(sink)}: discs of several sizes start touching, without the overlaps of hydrostatic: true, and "
        "sink by 2 to 4 % at first; settle gives them time behind the gate (settle: 2)"
    ]


LOOSE, CARRIES = 0.77, 0.8
"""Packing below which `check` tells that a bed sinks, and that at which it rests. Measured with friction 0.5, ± 20 %,
a rough floor, 2.2 m deep: the centre of mass sinks by 8.3, 3.7, 2.2 and 0.7 % from 0.74, 0.77, 0.79 and 0.81."""


def _loose_beds(case: CaseFields) -> list[str]:
    """A note on beds that are too loose to be at rest."""
    if not (case.gravity and case.initial):
        return []
    return [
        f"initial[{index}]: discs carry each other from a packing of about {CARRIES:zg} on, so that the bed with "
        f"{item.packing:zg} sinks to some {100 * item.packing / CARRIES:z.0f} % of its depth first"
        for index, item in enumerate(case.initial)
        if isinstance(item, PackedBed) and item.packing < LOOSE
    ]


def adapted(case: CaseFields, scene: InitialState, inlets: tuple[InletRow, ...]) -> tuple[str, ...]:
    """Sentences on requested values that whole steps have changed."""
    dt, settle = scene.time_step, case.settling[0]
    requested = {
        "run.duration": (case.run.duration, scene.time(scene.steps)),
        "settle": (settle, scene.settle_steps * dt),
    }
    if case.run.output_interval is not None:
        requested["run.output_interval"] = min(case.output_interval, case.run.duration), scene.output_steps * dt
    notes = rounding_notes(requested)
    if case.probes.recorded and case.probes.interval <= case.run.duration:
        notes += told_of_window(case.probes.interval, scene.probe_steps * dt, case.output_interval)
    mean, window = case.probes.stability_mean, scene.probe_steps * dt
    if mean is not None and mean <= case.run.duration:
        why = f"a moving mean takes an odd number of the windows of the probes, {window:z.4g} s each"
        notes += rounding_notes({"probes.stability_mean": (mean, windows_of(mean, window) * window)}, why=why)
    if not isinstance(case.inflow, RowsInflow) or case.inflow.table:
        return notes
    depth, speed = case.inflow.over(0.0, 0.0)
    carried = sum(scene.discharges_of(inlets))
    return notes + rounding_notes({"discharge of the inflow": (speed * depth, carried)}, "m^2/s")


def check_stop(case: CaseFields) -> list[str]:
    """A warning where `stop_when_steady` has no effect."""
    if case.run.stop_when_steady and case.gravity == 0 and not isinstance(case.inflow, RowsInflow):
        return ["stop_when_steady has no effect: without gravity and without inflow rows discs do not come to rest"]
    return []


def check_stability(
    case: CaseFields, coefficients: contact.Coefficients, integrator: str, sizes: Sizes | None
) -> list[str]:
    """Refuse an unstable step, unless ``run.allow_unstable``; return warnings about a step that is stable but long."""
    fraction, limit = case.run.time_step_fraction, coefficients.stable_fraction
    if fraction > limit and not case.run.allow_unstable:
        # the correction lowers the damping as f grows: the limit without it is safe for every f
        limit = min(limit, contact.stable_fraction(coefficients.damping_ratio, integrator))
        raise FieldError(
            "run.time_step_fraction",
            f"{fraction:zg} is unstable in a dense packing; allowed is up to {limit:z.3f} of "
            f"2/omega for {integrator} at restitution {coefficients.restitution:zg}; lower it (0.05 is the thesis' "
            "value) or set run.allow_unstable: true",
        )
    given = case.contact
    smallest = sizes.smallest / case.discs.diameter if sizes else 1.0
    warnings = slip_warnings(coefficients, given.friction_law, given.rotation, smallest)
    warnings += spring_warnings(coefficients, given.springs, given.rotation)
    if coefficients.restitution > 0.9 and fraction >= 0.2 and given.touch == "sharp":
        warnings.append(
            f"time_step_fraction {fraction:zg} is stable, but at restitution {coefficients.restitution:zg} the kink at "
            "first touch heats the discs from 0.2 on; use 0.1 or less, or contact.touch: smooth"
        )
    if fraction > 0.8 * limit:
        warnings.insert(
            0,
            f"time_step_fraction {fraction:zg} is close to the limit of stability {limit:z.3f} (hexagonal packing, "
            f"{integrator}); energies near it are not to be trusted",
        )
    return warnings


def check_places(
    case: CaseFields,
    scene: InitialState,
    inlets: tuple[InletRow, ...],
    walls: Iterable[MovingWall],
    fields: Mapping[str, str],
    seam: Interval | None,
) -> None:
    """Refuse discs and inlets in a wall at the start, and discs that overlap by more than d/n.

    `fields`: where in the case each wall is given, by name; not for gates and others. `seam`: where a periodic
    channel begins and ends, m.
    """
    positions, allowed = scene.positions, 0.5 * scene.overlap_limit
    diameters = scene.diameters(np.arange(1, len(positions) + 1))
    count = len(positions)
    images = np.flatnonzero(positions[:, 0] < seam[0] + scene.largest) if seam else np.empty(0, int)
    shift = [seam[1] - seam[0], 0.0] if seam else [0.0, 0.0]
    deepest = deepest_overlap(
        np.concatenate([positions, positions[images] + shift]), np.concatenate([diameters, diameters[images]])
    )
    if deepest is not None and deepest[0] > allowed * (1 + 1e-9):
        overlap, *both = deepest
        i, j = sorted(int(one if one < count else images[one - count]) for one in both)
        field = "initial" if scene.fixed is None or not scene.fixed.holds([i + 1, j + 1]).all() else "walls"
        raise FieldError(
            field,
            f"discs {i + 1} at ({positions[i, 0]:zg}, {positions[i, 1]:zg}) and {j + 1} at "
            f"({positions[j, 0]:zg}, {positions[j, 1]:zg}) overlap by {overlap:z.3g} m at the start; allowed is d/n = "
            f"{allowed:z.3g} m; {_less_jitter(case) if field == 'initial' else ''}move them apart",
        )
    if scene.fixed is not None:
        positions, diameters = positions[: scene.fixed.first - 1], diameters[: scene.fixed.first - 1]
    for one in walls:
        field = fields.get(one.wall.name, "initial")
        if wall := one.at(0):
            _check_discs_free_of(wall, field, case, positions, diameters, allowed)
        if isinf(one.motion.gone):
            _check_inlets_free_of(one.wall, inlets, scene.largest)


def gauges(case: CaseFields, room: Interval) -> tuple[float, ...]:
    """Places of the gauges along x (m), in the room of the domain and each once."""
    (low, high), places = room, case.probes.gauges
    for index, place in enumerate(places):
        if not low < place < high:
            where = "at the end of" if place in (low, high) else "outside"
            raise FieldError(
                f"probes.gauges.{index}",
                f"{place:zg} m is {where} the domain; allowed is above {low:zg} m and below "
                f"{high:zg} m: move the gauge or widen the domain",
            )
        if place in places[:index]:
            raise FieldError(f"probes.gauges.{index}", f"{place:zg} m is there already: name each place once")
    return places


def check_in_domain(
    case: CaseFields, positions: np.ndarray, inlets: Sequence[InletRow], domain: Sequence[Interval]
) -> None:
    """Refuse discs and inlets outside the domain."""
    for axis, label in enumerate("xy"):
        low, high = domain[axis]
        on_seam = axis == 0 and case.seam is not None
        outside = np.flatnonzero((positions[:, axis] <= low - on_seam * 1e-9) | (positions[:, axis] >= high))
        if outside.size:
            value = positions[outside[0], axis]
            raise FieldError(
                f"{'domain' if case.domain else 'initial'}",
                f"disc {outside[0] + 1} starts at {label} = {value:zg} m, "
                f"outside the domain [{low:zg}, {high:zg}]; widen domain.{label}",
            )
        for row in inlets:
            if not low < (row.x, row.y)[axis] < high:
                raise FieldError(
                    "inflow",
                    f"the inlet at {label} = {(row.x, row.y)[axis]:zg} m is outside domain.{label} "
                    f"[{low:zg}, {high:zg}]",
                )


def check_bodies_in_domain(
    walls: Iterable[MovingWall], fields: Mapping[str, str], domain: Sequence[Interval]
) -> list[str]:
    """Refuse bodies whose centre of mass is outside the domain at the start; sentences on such as reach out of it."""
    notes = []
    for one in walls:
        free, wall = one.motion.free, one.first
        if free is None:
            continue
        centre = np.ravel(one.placed.outward(*np.array(free.centre).reshape(2, 1)))
        for axis, label in enumerate("xy"):
            (low, high), ends = domain[axis], wall.extent[axis]
            if not low <= centre[axis] <= high:
                raise FieldError(
                    fields[wall.name],
                    f"body '{wall.name}' has its centre of mass at {label} = {centre[axis]:z.4g} m, outside the domain "
                    f"[{low:zg}, {high:zg}]; widen domain.{label}, or move the body",
                )
            for out, end in ((low - ends[0], low), (ends[1] - high, high)):
                if out > 0:
                    notes.append(
                        f"body '{wall.name}' reaches {out:z.3g} m beyond the edge of the domain, {label} = {end:zg} m, "
                        "at the start: discs there are lost, and the run ends where its centre of mass leaves; widen "
                        f"domain.{label}, or move the body"
                    )
    return notes


def _less_jitter(case: CaseFields) -> str:
    """The remedy where discs are shifted at random; empty where none are."""
    jitters = [(f"initial[{k}].jitter", item.jitter) for k, item in enumerate(case.initial) if item.jitter]
    if not jitters:
        return ""
    field, jitter = jitters[0]
    return (
        f"lower {field}, which shifts each disc by up to {jitter * case.discs.diameter:z.3g} m ({jitter:zg} diameters) "
        "along x and y, or "
    )


def _check_discs_free_of(
    wall: Wall, field: str, case: CaseFields, positions: np.ndarray, diameters: np.ndarray, allowed: float
) -> None:
    if not len(positions):
        return
    depth = depths(wall, positions, diameters)
    worst = int(np.argmax(depth))
    turned = (
        "; a line pushes discs on its left: reverse its points if they belong there" if open_ends(wall.faces) else ""
    )
    if depth[worst] > allowed * (1 + 1e-9):
        raise FieldError(
            field,
            f"disc {worst + 1} at ({positions[worst, 0]:zg}, {positions[worst, 1]:zg}) starts "
            f"{depth[worst]:z.3g} m deep in wall '{wall.name}'; allowed is d/n = {allowed:z.3g} m; {_less_jitter(case)}"
            f"move the wall or the discs{turned}",
        )


def depths(wall: Wall, positions: np.ndarray, diameters: np.ndarray) -> np.ndarray:
    """Depth of discs in a wall, m, shape (n,): below 0 outside it, minus infinity where it does not push them."""
    gap = wall.distance(positions[:, 0], positions[:, 1])
    if open_ends(wall.faces):  # it pushes nothing that is a radius behind it
        gap = np.where(gap < -diameters / 2, np.inf, gap)
    return diameters / 2 - gap


def _check_inlets_free_of(wall: Wall, inlets: tuple[InletRow, ...], largest: float) -> None:
    if not inlets:
        return
    distances = wall.distance(*np.array([(row.x, row.y) for row in inlets]).T)
    if open_ends(wall.faces):  # it pushes nothing that is a radius behind it
        distances = np.where(distances < -largest / 2, np.inf, distances)
    for number, (row, distance) in enumerate(zip(inlets, distances.tolist(), strict=True), 1):
        if distance < largest / 2 * (1 - 1e-6):
            raise FieldError(
                "inflow",
                f"row {number} enters at ({row.x:zg}, {row.y:zg}), {largest / 2 - distance:z.3g} m deep in "
                f"wall '{wall.name}'; move the inlet (inflow.x, inflow.y) or the wall",
            )
