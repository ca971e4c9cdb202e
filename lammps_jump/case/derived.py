# SPDX-License-Identifier: GPL-2.0-or-later
"""Derived numbers of a case, all that ``lammps-jump check`` shows; its hydraulics, and what the run will leave out.

Numbers of the inflow hold at the inlet. Down a spillway or over steps the jump is at the foot, in another stream:
that there is by energy without loss, with the jump it would make. Of a tailgate: what it measures, how fast it answers.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import asdict, dataclass, replace
from itertools import pairwise
from math import ceil, hypot, isfinite, pi, sqrt
from typing import Any

import numpy as np

from lammps_jump.errors import FieldError
from lammps_jump.files import plain
from lammps_jump.physics import contact, jump
from lammps_jump.physics.contact import WallLaw
from lammps_jump.physics.devices import GATE_LOOKS, Holding, gate_gains, wave_travel
from lammps_jump.physics.inlet import Hydrograph
from lammps_jump.physics.slip import springs_stable_fraction
from lammps_jump.scene import InitialState, InletRow, Interval, MovingWall, Scene, Wall
from lammps_jump.scene.tracks import Held
from lammps_jump.scene.walls import bed_height
from lammps_jump.units import number, numbers_of

from . import speeds
from .checks import twin_seconds
from .discs import GradingCurve, PackedBed
from .fields import CaseFields
from .inflow import RowsInflow
from .speeds import TENTHS
from .walls import words_of_wall

Row = tuple[str, str, float | int | str | None, str]
"""Key, label, value and unit."""


def flow_rows(case: CaseFields, scene: Scene) -> list[Row]:
    """Theory of the inflow at the inlet, and at the foot of a bed that falls; none without rows, or without gravity."""
    inflow = case.inflow
    if not isinstance(inflow, RowsInflow) or case.gravity == 0:
        return []
    depth, speed = inflow.over(*studied(case))
    if not depth:
        return []
    inflow_row = jump.inflow_theory(depth, speed, case.gravity)
    number, y1 = inflow_row.froude, inflow_row.depth
    low, high = jump.velocity_range(y1, case.gravity)
    carried = sum(scene.discharges)
    below = foot_of(scene, depth, speed, case.gravity)
    there = ", at the inlet" if below else ""
    rows: list[Row] = [
        ("froude", f"Froude number Fr1{there}", number, ""),
        (
            "jump_class",
            f"class of jump{there}",
            inflow_row.jump_class if number > 1 else "none: the inflow is subcritical",
            "",
        ),
        ("discharge", f"discharge asked for, {'mean of the window' if inflow.table else 'Va y1'}", speed * y1, "m^2/s"),
        (
            "discharge_rows",
            f"discharge of the rows, {'over the run' if inflow.table else 'in whole steps'}",
            carried,
            "m^2/s",
        ),
        ("mass_flow_rows", "mass flow of the rows", scene.density * carried, "kg/(m s)"),
        ("thesis_speed_low", "mean speed Va of a steady jump, Fr1 = 5", low, "m/s"),
        ("thesis_speed_high", "mean speed Va of a steady jump, Fr1 = 9", high, "m/s"),
    ]
    if number > 1:
        rows += _jump_rows(inflow_row, there)
    return [*rows, *_foot_rows(below)]


def _jump_rows(inflow: jump.Inflow, where: str, key: str = "") -> list[Row]:
    """The jump that a stream would make; `where` follows the labels, `key` precedes the keys."""
    number, y1 = inflow.froude, inflow.depth
    rows: list[Row] = [
        ("belanger_y2", "sequent depth y2 (Bélanger, 4.26)", inflow.belanger_y2, "m"),
        ("downstream_froude", "downstream Froude number", jump.downstream_froude(number), ""),
        ("energy_loss", "energy loss", inflow.energy_loss, "m"),
        ("jump_length", "jump length (4.27)", inflow.length, "m"),
        ("sill", "sill that holds the jump, E2 - 1.5 yc", inflow.sill, "m"),
        ("channel_length", "channel length 1.5 Lj", jump.channel_length(number, y1), "m"),
    ]
    return [(f"{key}{name}", f"{label}{where}", value, unit) for name, label, value, unit in rows]


def _foot_rows(below: Foot | None) -> list[Row]:
    """The stream at the foot of the bed by energy, and its jump; none on a level bed."""
    if below is None:
        return []
    rows: list[Row] = [
        ("foot_x", "foot of the bed at x", below.x, "m"),
        ("foot_fall", "fall of the bed to the foot", below.fall, "m"),
        ("foot_length", "level bed behind the foot", below.length, "m"),
    ]
    stream = below.stream
    if stream is None:
        return rows
    return [
        *rows,
        ("foot_depth", "depth at the foot, by energy without loss", stream.depth, "m"),
        ("foot_speed", "velocity at the foot, the same", stream.velocity, "m/s"),
        ("foot_froude", "Froude number at the foot", stream.froude, ""),
        ("foot_jump_class", "class of jump at the foot", stream.jump_class, ""),
        *_jump_rows(stream, ", at the foot", "foot_"),
    ]


def studied(case: CaseFields) -> tuple[float, float]:
    """Times over which the analysis takes its means, s: for them an inflow against time has its theory."""
    return case.analysis.window or (0.75 * case.run.duration, case.run.duration)


LEVEL = 0.05
"""Slope below which a bed is level: its change of height over a diameter, in diameters."""
LEAST_FALL = 0.5
"""Fall in diameters from which on a bed has a foot."""
POINTS = 4000


@dataclass(frozen=True)
class Foot:
    """The stream at the foot of the bed, and the jump that it would make there."""

    x: float = number("m", "foot of the bed: its longest level stretch begins at x")
    fall: float = number("m", "fall of the bed from the inlet to the foot")
    length: float = number("m", "length of the level bed behind the foot")
    stream: jump.Inflow | None = None


def foot_of(scene: Scene, depth: float, speed: float, gravity: float) -> Foot | None:
    """The foot downstream of rows of a scene with a depth (m) and a speed (m/s); None on a level or tilted bed.

    The depth there is that of the fast stream with the energy at the inlet and the fall: the least that friction and
    impacts would leave. Where the bed rises the stream stays None.
    """
    if not scene.inlets or scene.gravity[0] or not (depth > 0 and speed > 0):
        return None
    start = min(scene.inlets, key=lambda one: one.y).x
    ends = [outlet.at for outlet in scene.outlets if outlet.axis == "x" and outlet.side == "above"]
    x = np.linspace(start, min([scene.domain[0][1], *ends]), POINTS)
    bed = bed_height(scene.permanent, x, scene.smallest)
    with np.errstate(invalid="ignore"):
        breaks = np.flatnonzero(~(np.abs(np.diff(bed)) < LEVEL * np.diff(x))) + 1
    begins, long = np.append(0, breaks), np.diff(breaks, prepend=0, append=POINTS)
    longest = int(np.argmax(np.where(np.isfinite(bed[begins]), long, 0)))
    first, last = begins[longest], begins[longest] + long[longest] - 1
    if long[longest] < 2 or not isfinite(bed[first]) or not isfinite(bed[0]):  # a chute to the end has no foot
        return None
    fall = float(bed[0] - bed[first])
    if fall < LEAST_FALL * scene.diameter:
        return None
    discharge = speed * depth
    energy = jump.specific_energy(depth, speed, gravity) + fall
    y1 = jump.fast_depth(discharge, energy, gravity)
    stream = jump.inflow_theory(y1, discharge / y1, gravity) if isfinite(y1) else None
    return Foot(float(x[first]), fall, float(x[last] - x[first]), stream)


STRETCH = 10
"""Width over which a depth is taken, in diameters; half of it is that of the parts in which a front is looked for."""


def with_holdings(
    case: CaseFields, begun: InitialState, walls: list[MovingWall], fields: dict[str, str],
    domain: tuple[Interval, Interval], inlets: tuple[InletRow, ...],
) -> list[MovingWall]:  # fmt: skip
    """The walls, with what tailgates among them measure.

    Raises
    ------
    FieldError
        A depth or a front where the gate cannot hold it: outside the domain, behind the gate, without inflow.
    """
    moving_walls = []
    for one in walls:
        if isinstance(kind := one.motion.kind, Held):
            field = f"{fields[one.wall.name]}.motion"
            left = max([domain[0][0], *(row.x for row in inlets)])
            holding = _holding(case, begun, one, kind, field, (left, domain[0]))
            one = MovingWall(one.wall, replace(one.motion, holding=holding))
        moving_walls.append(one)
    return moving_walls


def _holding(
    case: CaseFields, begun: InitialState, one: MovingWall, kind: Held, field: str,
    channel: tuple[float, Interval],
) -> Holding:  # fmt: skip
    """Quantity that a gate measures, and its gains."""
    left, domain = channel
    face = one.wall.extent[0][0]
    place, name = (kind.at, "at") if kind.front is None else (kind.front, "front")
    assert place is not None  # one of the two is there
    if not isfinite(face) or not left < face < domain[1]:
        raise FieldError(
            field,
            f"wall '{one.wall.name}' has its side towards the flow at x = {face:zg} m; allowed is a block "
            f"between {left:zg} and {domain[1]:zg} m, in the domain and behind the inlet",
        )
    width = STRETCH * begun.diameter
    half = 0.5 * width if kind.depth is not None else 0.0
    if not left <= place - half <= place + half <= face or place == face:  # a front behind the gate cannot be held
        inner = (left + 0.5 * width, face - 0.5 * width) if kind.depth is not None else (left, face)
        raise FieldError(
            f"{field}.{name}",
            f"{place:zg} m is outside the channel before the gate; allowed is {inner[0]:zg} to "
            f"{inner[1]:zg} m, between its begin and the wall '{one.wall.name}'",
        )
    depth, speed, level, rise = _flow(case, kind, field)
    length = max(face - place, depth)
    travel = wave_travel(length, depth, speed, case.gravity)
    response = travel if kind.response is None else kind.response
    if kind.front is None:
        low, high, bins = place - 0.5 * width, place + 0.5 * width, 1
    else:
        low, high = left, face
        bins = max(2, ceil((face - left) / (0.5 * width)))
    proportional, integral = gate_gains(response, travel, length, rise / length)
    every = max(1, round(response / GATE_LOOKS / begun.time_step))
    first = max(1, begun.settle_steps + ceil(kind.begin / begun.time_step)) if isfinite(kind.begin) else 0
    if one.motion.went is not None:  # the next look of a gate that goes on
        since = one.motion.went.since or 0.0
        first = every - min(round(since / begun.time_step), every - 1)
    return Holding(
        low, high, bins, place if kind.front is not None else depth, level, proportional, integral, kind.speed,
        *kind.range, first, every,
    )  # fmt: skip


def _flow(case: CaseFields, kind: Held, field: str) -> tuple[float, float, float, float]:
    """Depth (m) and speed (m/s) of the stream before the gate, depth at the front, and the rise of depth there, m."""
    stream = case.inflow.over(0.0, case.run.duration) if isinstance(case.inflow, RowsInflow) else (0.0, 0.0)
    y1, u1 = stream
    if case.gravity == 0:
        raise FieldError(field, "a gate holds a depth under gravity, and this case has none; give gravity, m/s^2")
    if kind.depth is not None:
        return kind.depth, y1 * u1 / kind.depth, 0.0, 0.0
    if not y1 or jump.froude(u1, y1, case.gravity) <= 1.0:
        raise FieldError(
            f"{field}.front",
            "a front needs an inflow of rows that is faster than its waves (Froude number above 1); "
            "hold a depth instead, by depth and at",
        )
    y2 = jump.sequent_depth(u1, y1, case.gravity)
    return y2, y1 * u1 / y2, 0.5 * (y1 + y2), y2 - y1


@dataclass(frozen=True)
class Derived:
    """Numbers that `ReadCase.check` derives.

    Attributes
    ----------
    fields : CaseFields
    scene : Scene
    left_out : str
        Scene whose description the case still had although its flow is another one.
    slopes : tuple of str
        Sentences on numbers that the case gives as angles, whose tangents they are.
    """

    fields: CaseFields
    scene: Scene
    left_out: str = ""
    slopes: tuple[str, ...] = ()

    @property
    def tables(self) -> list[tuple[str, list[Row]]]:
        """Groups of (key, label, value, unit)."""
        case, scene = self.fields, self.scene
        contact_rows = _contact_rows(case, scene) + _expected_rows(case, scene)
        time_rows = _time_rows(scene)
        if case.engine.name == "twin":
            time_rows.append(("twin_seconds", "run on the twin takes about", twin_seconds(scene), "s"))
        return [("contact", contact_rows), ("time", time_rows), ("flow", flow_rows(case, scene))]

    @property
    def theory(self) -> dict[str, float | int | str | None] | None:
        """Theory of the inflow by key: Froude number, sequent depth, jump length …; None without inflow rows."""
        return {key: value for key, _, value, _ in flow_rows(self.fields, self.scene)} or None

    @property
    def numbers(self) -> dict[str, float | int | str | None]:
        """Coefficients, times and theory of the inflow by key, SI."""
        return {key: value for _, rows in self.tables for key, _, value, _ in rows}

    @property
    def walls(self) -> dict[str, str]:
        """Motion and contact numbers of walls that have their own, in words, by name."""
        walls_in_words = {one.wall.name: words_of_wall(one, self.scene) for one in self.scene.walls}
        return {name: text for name, text in walls_in_words.items() if text}

    @property
    def begins(self) -> tuple[str, ...]:
        """Origin of the discs at the start, if from earlier runs, and the memory that comes along."""
        return self.scene.earlier.origins if self.scene.earlier else ()

    @property
    def skipped(self) -> tuple[str, ...]:
        """Sentences on what the scene does not need and the run leaves out."""
        return self.scene.skipped

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings, as sentences."""
        return self.scene.warnings

    def as_data(self) -> dict[str, Any]:
        """Plain data of ``check --json``: coefficients, groups of numbers, inflow rows, what is skipped, warnings."""
        scene = self.scene
        groups = {title: {key: value for key, _, value, _ in rows} for title, rows in self.tables}
        rows = [
            {"y": row.y, "speed": row.vx, "every_steps": row.every_steps, "interval": row.every_steps * scene.time_step}
            for row in scene.inlets
        ]
        return plain(
            {
                "name": self.fields.name,
                "verdict": "doubtful" if scene.warnings else "fine",
                "coefficients": asdict(scene.coefficients),
                **groups,
                "inflow_rows": rows,
                "walls": self.walls,
                "begins": list(self.begins),
                "slopes": list(self.slopes),
                "skipped": list(scene.skipped),
                "warnings": list(scene.warnings),
                "adapted": list(scene.adapted),
            }
        )

    def _quarters(self, graph: Hydrograph) -> list[str]:
        """Values of the table of the inflow in each quarter of the run."""
        ends = [0.25 * i * self.fields.run.duration for i in range(5)]
        means = [(begin, end, *graph.means(begin, end)) for begin, end in pairwise(ends)]
        return [f"  t = {a:z.4g} to {b:z.4g} s  depth {h:z.4g} m  discharge {q:z.4g} m^2/s" for a, b, h, q in means]

    def __str__(self) -> str:
        """Text for the screen: the verdict, tables with units, what is skipped and adapted."""
        scene = self.scene
        lines = ["this case is fine"]
        if scene.warnings:
            lines = ["doubtful in this case:", *(f"  - {text}" for text in scene.warnings)]
        lines += ["", f"{self.fields.name}: {self.fields.description}".rstrip(": ")]
        if self.left_out:
            lines.append(
                f"The description is that of {self.left_out}, another flow, and is left out; write one of your own."
            )
        lines += [f"{text[:1].upper()}{text[1:]}." for text in self.begins]
        for title, rows in self.tables:
            if rows:
                lines += ["", title]
                width = max(len(label) for _, label, _, _ in rows)
                lines += [f"  {label:<{width}}  {_show(value):>12} {unit}".rstrip() for _, label, value, unit in rows]
        if scene.hydrograph:
            lines += [
                "",
                "inflow against time (means over a quarter of the run each)",
                *self._quarters(scene.hydrograph),
            ]
        elif scene.inlets:
            lines += ["", "inflow rows (a disc waits while its place is occupied)"]
            lines += [
                f"  y = {row.y:z.4g} m  v = {row.vx:z.3f} m/s  every {row.every_steps} steps = "
                f"{row.every_steps * scene.time_step:z.5f} s"
                for row in scene.inlets
            ]
        if self.slopes:
            lines += ["", "taken from angles", *(f"  {text}" for text in self.slopes)]
        if self.walls:
            width = max(map(len, self.walls))
            lines += ["", "walls with a motion or contact of their own"]
            lines += [f"  {name:<{width}}  {text}" for name, text in self.walls.items()]
        lines += ["", "skipped, because the scene does not need it"]
        lines += [f"  - {text}" for text in scene.skipped]
        if scene.adapted:
            lines += ["", "changed to whole steps", *(f"  - {text}" for text in scene.adapted)]
        return "\n".join(lines)


def _show(value: Any) -> str:
    if value is None:
        return "-"
    if isinstance(value, str | int):
        return str(value)
    return f"{value:z.6g}"


def _described(result: object, keys: str) -> list[Row]:
    """Rows of a result's numbers, in words of their descriptions; `keys` are words of one text."""
    numbers = numbers_of(result)
    return [(key, numbers[key].label, getattr(result, key), numbers[key].unit) for key in keys.split()]


def _size_rows(scene: Scene) -> list[Row]:
    """Discs of several sizes: their range, and the contacts of the smallest and of the largest pairs."""
    if scene.sizes is None:
        return []
    c = scene.coefficients
    rows: list[Row] = [
        ("smallest_diameter", "smallest disc", scene.smallest, "m"),
        ("largest_diameter", "largest disc", scene.largest, "m"),
        ("mean_mass", "mean mass of a disc", scene.mean_mass, "kg/m"),
    ]
    for name, diameter in (("smallest", scene.smallest), ("largest", scene.largest)):
        ratio = diameter / scene.diameter
        rows += [
            (f"contact_duration_{name}", f"contact duration, {name} pair", ratio * c.contact_duration, "s"),
            (f"contact_steps_{name}", f"the same in steps, {name} pair", ratio * c.contact_steps, ""),
        ]
        if scene.touch == "sharp":
            e = c.restitution_of_pair(ratio, scene.integrator)
            rows.append((f"restitution_{name}", f"restitution in steps, {name} pair", e, ""))
    return rows


def _bed_rows(case: CaseFields, scene: Scene) -> list[Row]:
    """Packing of each bed as requested, and as the discs with centres in its rectangle make it."""
    rows: list[Row] = []
    diameters = scene.diameters(np.arange(1, len(scene.positions) + 1))
    for index, bed in enumerate(case.initial):
        if isinstance(bed, PackedBed):
            (left, right), (low, high) = bed.x, bed.y
            x, y = scene.positions.T
            inside = (x > left) & (x < right) & (y > low) & (y < high)
            packing = float(pi / 4 * np.sum(diameters[inside] ** 2) / bed.area)
            rows += [
                (f"packing_{index}_asked", f"packing of initial[{index}], asked", bed.packing, ""),
                (f"packing_{index}", f"packing of initial[{index}], of the discs in it", packing, ""),
            ]
    return rows


def _curve_rows(case: CaseFields, scene: Scene) -> list[Row]:
    """A grading curve: its sizes by mass, and what its finest and its coarsest tenth are in discs."""
    sizes, curve = scene.sizes, case.discs.sizes
    if sizes is None or not isinstance(curve, GradingCurve):
        return []
    nominal = "nominal diameter, d50 by " + curve.by if case.discs.diameter == curve.nominal else "nominal diameter"
    at = curve.size_at if curve.by == "mass" else sizes.diameter_at
    fine, coarse = map(at, TENTHS)
    count, shares = scene.drawn_discs, (float(sizes.passing(fine, 0)), 1.0 - float(sizes.passing(coarse, 0)))
    return [
        ("curve_by", "curve of sizes", f"by {curve.by}", ""),
        ("nominal_diameter", nominal, scene.diameter, "m"),
        ("d10", "d10, by mass", fine, "m"),
        ("d50", "d50, by mass", at(0.5), "m"),
        ("d90", "d90, by mass", coarse, "m"),
        ("uniformity", "uniformity d60/d10, by mass", at(0.6) / fine, ""),
        ("finest_share", "finest tenth of the mass, of the number", shares[0], ""),
        ("finest_discs", "finest tenth of the mass, discs", round(count * shares[0]), ""),
        ("coarsest_share", "coarsest tenth of the mass, of the number", shares[1], ""),
        ("coarsest_discs", "coarsest tenth of the mass, discs", round(count * shares[1]), ""),
    ]


def _contact_rows(case: CaseFields, scene: Scene) -> list[Row]:
    c, fixed = scene.coefficients, scene.fixed.count if scene.fixed else 0
    rows: list[Row] = [
        ("discs_at_start", "discs at the start", len(scene.positions) - fixed, ""),
        *([("fixed_discs", "fixed discs of rough beds", fixed, "")] if fixed else []),
        *([("period", "length of the periodic channel", scene.period, "m")] if scene.period else []),
        *_bed_rows(case, scene),
        *_curve_rows(case, scene),
        *_size_rows(scene),
        *_described(c, "mass stiffness stiffness_wall restitution damping_ratio damping damping_wall"),
        *_described(c, "correction correction_wall gamma_normal gamma_normal_wall friction"),
    ]
    if c.friction:
        rows.append(("friction_law", "friction law", scene.friction_law, ""))
        rows += _described(c, "gamma_tangential gamma_tangential_wall")
        rows += _spring_rows(scene) or _described(c, "slip_speed")
    return [*rows, *_cohesion_rows(scene), *_described(c, "largest_overlap")]


def _cohesion_rows(scene: Scene) -> list[Row]:
    """The attraction of what touches; none where there is none.

    Of two discs that meet at less than `sticking_speed` the restitution e leaves too little to part: the attraction F_c
    gives F_c^2/(2 k) to their way to the balance, and takes it again, v = F_c sqrt((1/e^2 - 1)/(k m*)).
    """
    pull, c = scene.cohesion, scene.coefficients
    if not pull:
        return []
    stick = pull * sqrt((1 / c.restitution**2 - 1) / (c.stiffness * c.mass / 2))
    weight = c.mass * hypot(*scene.gravity)
    bond: list[Row] = [("bond_number", "Bond number: attraction over weight", pull / weight, "")] if weight else []
    return [
        ("cohesion", "attraction of what touches", pull, "N/m"),
        *bond,
        ("cohesion_overlap", "overlap that it alone holds, over d", pull / c.stiffness / scene.diameter, ""),
        ("sticking_speed", "discs that meet at less stick, about", stick, "m/s"),
    ]


def _expected_rows(case: CaseFields, scene: Scene) -> list[Row]:
    """The fastest collision that is foreseen, and how deep a disc goes into a wall then."""
    speed = speeds.expected(case).speed
    share = speeds.overlap_at(speed, scene.coefficients, scene.diameter)
    return [
        ("expected_speed", "fastest collision foreseen", speed, "m/s"),
        ("expected_overlap", "overlap of a wall then, over d", share, ""),
    ]


def _spring_rows(scene: Scene) -> list[Row]:
    """Springs with memory; none where the law has none."""
    c, springs = scene.coefficients, scene.springs
    if springs is None:
        return []
    limit = springs_stable_fraction(c.damping_ratio * c.correction, springs, scene.rotation)
    rows: list[Row] = [
        ("stiffness_tangential", "stiffness of the tangential spring", springs.tangential_ratio * c.stiffness, "N/m"),
        ("stable_fraction_springs", "tangential springs stable up to f =", limit, "of 2/omega"),
    ]
    if roll := springs.rolling:
        rows.append(("rolling_friction", "coefficient of rolling friction", roll.friction, ""))
        rows.append(("stiffness_rolling", "stiffness against rolling", roll.stiffness_ratio * c.stiffness, "N/m"))
    return rows


def _time_rows(scene: Scene) -> list[Row]:
    c = scene.coefficients
    rows: list[Row] = [
        ("integrator", "integrator", scene.integrator, ""),
        *_described(c, "critical_time_step"),
        ("time_step", f"time step, f = {c.time_step_fraction:zg}", c.time_step, "s"),
        *_described(c, "contact_duration contact_steps"),
    ]
    for packing in ("pair", "square", "hexagonal"):
        limit = contact.stable_fraction(c.damping_ratio * c.correction, scene.integrator, packing)
        rows.append((f"stable_fraction_{packing}", f"stable up to f =, {packing}", limit, "of 2/omega"))
    rows += [
        ("steps", "steps", scene.steps, ""),
        ("duration", "simulated time", scene.time(scene.steps), "s"),
        ("output_interval", "time between frames", scene.output_steps * scene.time_step, "s"),
    ]
    if scene.settle_steps:
        rows.append(("settle_time", "settling behind the gate", scene.settle_steps * scene.time_step, "s"))
    return rows


def skipped(
    case: CaseFields, walls: tuple[Wall, ...], kept: Collection[Wall], begun: InitialState, laws: Collection[WallLaw]
) -> tuple[str, ...]:
    """Sentences: what the engines leave out because the scene does not need it, such as walls that are not `kept`.

    `laws` are those of walls that have their own.
    """
    law, rubs = case.contact, case.contact.friction > 0 or any(own.friction for own in laws)
    columns = "z, vz, " + ("" if begun.sizes else "radius, ") + "mass, type, forces"
    columns += "" if law.rotation and rubs else ", spin"
    texts = {
        "friction terms: friction is 0": not rubs,
        "dashpots: restitution is 1": law.restitution == 1 and not any(own.gamma_normal for own in laws),
        "spin: contact.rotation is false, discs do not turn": not law.rotation,
        "spin: without friction nothing turns a disc": law.rotation and not rubs,
        "gravity: it is 0": case.gravity == 0,
        **{f"wall '{wall.name}': nothing inside the domain can reach it": wall not in kept for wall in walls},
        "walls: there are none": not walls,
        "inlet: no inflow": case.inflow is None,
        "outlet: no outflow": not case.outflow,
        "z constraint: nothing pushes out of the plane": True,
        "tangential springs: the contact law has no memory": not (law.springs and rubs),
        f"dump columns {columns}: no analysis reads them": True,
        "wall forces: no probe asks for them": not case.probes.forces,
        "stress fields: analysis.fields is false": case.run.dump_format == "text" and not case.analysis.fields,
    }
    return tuple(text for text, holds in texts.items() if holds)
