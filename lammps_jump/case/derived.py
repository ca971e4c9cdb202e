# SPDX-License-Identifier: GPL-2.0-or-later
"""``lammps-jump check``: every derived number of a case, and what the run will leave out."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import asdict, dataclass
from itertools import pairwise
from math import hypot, pi, sqrt
from typing import Any

import numpy as np

from lammps_jump.files import plain
from lammps_jump.physics import contact
from lammps_jump.physics.contact import WallLaw
from lammps_jump.physics.inlet import Hydrograph
from lammps_jump.physics.slip import springs_stable_fraction
from lammps_jump.scene import Beginning, Scene, Wall
from lammps_jump.units import numbers_of

from . import speeds
from .checks import twin_seconds
from .design import Row, flow_rows
from .discs import PackedBed
from .fields import CaseFields
from .parts.grading import GradingCurve
from .speeds import TENTHS
from .walls import words_of_wall


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
        found = {one.wall.name: words_of_wall(one, self.scene) for one in self.scene.walls}
        return {name: text for name, text in found.items() if text}

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
    """Packing of each bed as it was asked for, and as the discs with centres in its rectangle make it."""
    rows: list[Row] = []
    diameters = scene.diameters(np.arange(1, len(scene.positions) + 1))
    for index, bed in enumerate(case.initial):
        if isinstance(bed, PackedBed):
            (left, right), (low, high) = bed.x, bed.y
            x, y = scene.positions.T
            inside = (x > left) & (x < right) & (y > low) & (y < high)
            found = float(pi / 4 * np.sum(diameters[inside] ** 2) / bed.area)
            rows += [
                (f"packing_{index}_asked", f"packing of initial[{index}], asked", bed.packing, ""),
                (f"packing_{index}", f"packing of initial[{index}], of the discs in it", found, ""),
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
    case: CaseFields, walls: tuple[Wall, ...], kept: Collection[Wall], begun: Beginning, laws: Collection[WallLaw]
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
