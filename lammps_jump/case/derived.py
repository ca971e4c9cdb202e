# SPDX-License-Identifier: GPL-2.0-or-later
"""``lammps-jump check``: every derived number of a case, and what the run will leave out."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import asdict, dataclass
from itertools import pairwise
from math import inf

from lammps_jump.files import plain
from lammps_jump.physics import contact, jump
from lammps_jump.physics.contact import WallLaw
from lammps_jump.physics.hydrograph import Hydrograph
from lammps_jump.physics.slip import springs_stable_fraction
from lammps_jump.scene import Beginning, InletRow, Scene, Wall
from lammps_jump.scene.shapes import open_ends
from lammps_jump.units import numbers_of

from .design.flow import Row, flow_rows, studied
from .fields import CaseFields
from .parts.beds import RoughBed
from .parts.inflow import RowsInflow
from .walls import told

FASTEST = 1.25
"""Fastest row over the impact speed above which overlaps are doubtful; the 1/7 profile has 1.12."""
UPSTREAM, DOWNSTREAM = 5.0, 3.5
"""Room for a jump: the stream before it in y1; the jump (1.5) and steady tail water (2) in y2 (measured)."""
LOWEST_SILL = 0.55
"""Height of a sill over that of a broad crest that holds the jump of water. In a dry channel discs of `quick_jump` run
over 0.46 of it without a jump, and make one at 0.65 (measured)."""


@dataclass(frozen=True)
class Derived:
    """What `ReadCase.check` finds.

    Attributes
    ----------
    fields : CaseFields
    scene : Scene
    left_out : str
        Scene whose description the case still had although its flow is another one.
    """

    fields: CaseFields
    scene: Scene
    left_out: str = ""

    @property
    def tables(self) -> list[tuple[str, list[Row]]]:
        """Groups of (key, label, value, unit)."""
        case, scene = self.fields, self.scene
        return [("contact", _contact_rows(scene)), ("time", _time_rows(scene)), ("flow", flow_rows(case, scene))]

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
        found = {one.wall.name: told(one, self.scene) for one in self.scene.walls}
        return {name: text for name, text in found.items() if text}

    @property
    def skipped(self) -> tuple[str, ...]:
        """What the scene does not need and the run leaves out, in sentences."""
        return self.scene.skipped

    @property
    def warnings(self) -> tuple[str, ...]:
        """What to beware of, in sentences."""
        return self.scene.warnings

    def as_data(self) -> dict:
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
                "skipped": list(scene.skipped),
                "warnings": list(scene.warnings),
                "adapted": list(scene.adapted),
            }
        )

    def _quarters(self, graph: Hydrograph) -> list[str]:
        """What is asked for in each quarter of the run."""
        ends = [0.25 * i * self.fields.run.duration for i in range(5)]
        means = [(begin, end, *graph.means(begin, end)) for begin, end in pairwise(ends)]
        return [f"  t = {a:.4g} to {b:.4g} s  depth {h:.4g} m  discharge {q:.4g} m^2/s" for a, b, h, q in means]

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
                f"  y = {row.y:.4g} m  v = {row.vx:.3f} m/s  every {row.every_steps} steps = "
                f"{row.every_steps * scene.time_step:.5f} s"
                for row in scene.inlets
            ]
        if self.walls:
            width = max(map(len, self.walls))
            lines += ["", "walls with a motion or contact of their own"]
            lines += [f"  {name:<{width}}  {text}" for name, text in self.walls.items()]
        lines += ["", "skipped, because the scene does not need it"]
        lines += [f"  - {text}" for text in scene.skipped]
        if scene.adapted:
            lines += ["", "changed to whole steps", *(f"  - {text}" for text in scene.adapted)]
        return "\n".join(lines)


def _show(value) -> str:
    if value is None:
        return "-"
    if isinstance(value, str | int):
        return str(value)
    return f"{value:.6g}"


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


def _contact_rows(scene: Scene) -> list[Row]:
    c, fixed = scene.coefficients, scene.fixed.count if scene.fixed else 0
    rows: list[Row] = [
        ("discs_at_start", "discs at the start", len(scene.positions) - fixed, ""),
        *([("fixed_discs", "fixed discs of rough beds", fixed, "")] if fixed else []),
        *([("period", "length of the periodic channel", scene.period, "m")] if scene.period else []),
        *_size_rows(scene),
        *_described(c, "mass stiffness stiffness_wall restitution damping_ratio damping damping_wall"),
        *_described(c, "correction correction_wall gamma_normal gamma_normal_wall friction"),
    ]
    if c.friction:
        rows.append(("friction_law", "friction law", scene.friction_law, ""))
        rows += _described(c, "gamma_tangential gamma_tangential_wall")
        rows += _spring_rows(scene) or _described(c, "slip_speed")
    return [*rows, *_described(c, "largest_overlap")]


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
        ("time_step", f"time step, f = {c.time_step_fraction:g}", c.time_step, "s"),
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


def doubts(case: CaseFields, impact_speed: float, inlets: tuple[InletRow, ...]) -> list[str]:
    """Sentences on what will probably not come out as asked: window, stiffness, channel, sill.

    Parameters
    ----------
    case : CaseFields
    impact_speed : float
        v0 of (3.20), m/s.
    inlets : tuple of InletRow
    """
    found, window, duration = [], case.analysis.window, case.run.duration
    if window and window[1] > duration * (1 + 1e-3):
        found.append(
            f"analysis.window ends at {window[1]:g} s, the run at {duration:g} s; take a window within the run, or "
            "none for its last quarter"
        )
    elif window and window[1] < 0.5 * duration:
        found.append(
            f"analysis.window ends at {window[1]:g} s and misses the last half of the {duration:g} s; take a later "
            "one, or none for the last quarter"
        )
    fastest = max((row.vx for row in inlets), default=0.0)
    if fastest > FASTEST * impact_speed:
        found.append(
            f"the fastest row has {fastest:.3g} m/s, contact.impact_speed is {impact_speed:.3g} m/s: discs press "
            f"{fastest / impact_speed:.2g} times deeper into each other than largest_overlap says; take "
            f"impact_speed: {fastest:.3g}, or a larger stiffness"
        )
    if isinstance(case.inflow, RowsInflow) and case.analysis.jump and case.gravity:
        found += _jump_doubts(case, case.inflow)
    return found


def _stands(wall: Wall) -> bool:
    """Whether a wall is a solid that may be a sill: it ends, and discs are around it."""
    return wall.finite and not wall.hollow and not open_ends(wall.faces)


def _jump_doubts(case: CaseFields, inflow: RowsInflow) -> list[str]:
    """Sentences on a jump that cannot form, has no room, or is not held by the sill."""
    g, (y1, speed) = case.gravity, inflow.over(*studied(case))
    if not y1:
        return ["no disc flows in during the window of the analysis, so that it finds no jump; take another window"]
    number = jump.froude(speed, y1, g)
    if number <= 1:
        return [f"the inflow is subcritical (Fr = {number:.3g}), so that no jump forms; Fr must be above 1"]
    y2 = y1 * jump.belanger(number)
    steps = [
        (x[0], y[1] - inflow.y)
        for x, y in (wall.extent for wall in case.walls if not isinstance(wall, RoughBed) and _stands(wall))
        if x[0] > inflow.x and y[1] > inflow.y
    ]
    outlets = [(item.x_beyond, 0.0) for item in case.outflow if item.x_beyond is not None]
    end, sill = min(steps or outlets, default=(inf, 0.0))
    found, room = [], UPSTREAM * y1 + DOWNSTREAM * y2
    if end - inflow.x < room:
        found.append(
            f"the channel is {end - inflow.x:.3g} m long from the inlet to the sill or outlet; stream, jump and tail "
            f"water need {room:.3g} m (5 y1 + 3.5 y2; 1.5 Lj of water are {jump.channel_length(number, y1):.3g} m)"
        )
    height = jump.sill_holding_height(speed, y1, g)
    if steps and sill < LOWEST_SILL * height:
        found.append(
            f"the jet will run over the sill of {sill:.3g} m without a jump: a broad crest that holds it has "
            f"{height:.3g} m, and discs need {LOWEST_SILL * height:.3g} m or more"
        )
    return found


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
