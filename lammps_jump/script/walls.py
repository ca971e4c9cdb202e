# SPDX-License-Identifier: GPL-2.0-or-later
"""LAMMPS commands of walls and gates.

The styles that come with LAMMPS write what is a region of theirs (`lammps_jump.script.regions`); the plugin takes the
faces of every wall.
"""

from __future__ import annotations

from math import inf, nan, sqrt

from lammps_jump.physics.contact import WallLaw, restitution_of
from lammps_jump.scene import Block, Box, Interval, MovingWall, Plane, Scene, Wall

from .regions import FAR, LammpsRegion, NotInStock, check_motion, clock, joints, level, polyline, single_regions, way
from .regions import number as number
from .regions import numbers as numbers

JOIN = " &\n                "
"""Goes on with a command in the next line."""
BEFORE_ALL = -1e300
"""Time before every other one, s: LAMMPS reads no infinite number."""


def fix_names(lines: list[str]) -> list[str]:
    """Names of the fixes that commands define."""
    return [line.split()[1] for line in lines if line.startswith("fix ")]


def granular_law(stiffness: float, ratio: float, tangential: float, friction: float, springs: str = "") -> str:
    """Words of LAMMPS' granular styles, for discs that are not equal and for springs with memory.

    ``coeff_restitution`` makes the dashpot 2 xi sqrt(k m_eff) of each contact, xi from a restitution coefficient. The
    tangential dashpot is a multiple of it.

    Parameters
    ----------
    stiffness : float
        N/m.
    ratio : float
        Damping ratio xi.
    tangential : float
        Tangential dashpot over the normal one.
    friction : float
        Coefficient.
    springs : str
        Words of the springs (`spring_words`).
    """
    friction_words = springs or f"tangential linear_nohistory {numbers(tangential, friction) if friction else '0 0'}"
    return f"hooke {numbers(stiffness, restitution_of(ratio))} {friction_words} damping coeff_restitution"


def spring_words(scene: Scene, law: WallLaw, effective_mass: float) -> str:
    """Words of the tangential and the rolling spring of a contact; none where it has no memory.

    Parameters
    ----------
    scene : Scene
    law : WallLaw
        Of the contact of nominal discs, or at a wall.
    effective_mass : float
        kg/m.
    """
    springs = scene.springs
    if springs is None:
        return ""
    stiffness = springs.tangential_ratio * law.stiffness
    words = f"tangential linear_history {numbers(stiffness, springs.tangential_damping_ratio, law.friction)}"
    if not stiffness:  # LAMMPS divides by it where the spring slides; without a spring there is nothing to remember
        words = f"tangential linear_nohistory {numbers(springs.tangential_damping_ratio, law.friction)}"
    if (roll := springs.rolling) is None:
        return words
    friction = roll.friction if law.rolling is None else law.rolling
    damping = roll.damping * effective_mass * law.gamma_normal
    return f"{words} rolling sds {numbers(roll.stiffness_ratio * law.stiffness, damping, friction)}"


def wall_law(scene: Scene, name: str) -> str:
    """Contact law of a wall's stock fixes."""
    c, own = scene.coefficients, scene.wall_law(name)
    if scene.sizes or scene.springs:
        ratio, tangential = c.damping_ratio * c.correction_wall, c.tangential_ratio_wall
        if name in scene.own_laws:
            ratio = 0.5 * own.gamma_normal * sqrt(c.mass / own.stiffness)
            tangential = own.gamma_tangential / own.gamma_normal if own.gamma_normal else nan
        return (
            f"granular {granular_law(own.stiffness, ratio, tangential, own.friction, spring_words(scene, own, c.mass))}"
        )
    # the wall fixes divide by gamma_n: zero would give NaN forces
    normal = number(own.gamma_normal) if own.gamma_normal > 0 else "1e-12"
    friction_words = f"{numbers(own.gamma_tangential, own.friction)} 1" if own.friction else "0 0 0"
    return f"hooke {number(own.stiffness)} NULL {normal} {friction_words}"


def stock_walls(scene: Scene) -> list[str]:
    """All walls but gates, with the styles that come with LAMMPS."""
    return [*clock(scene), *(line for moving in scene.standing for line in stock_wall(moving, scene))]


def stock_gates(scene: Scene) -> list[str]:
    """All gates, with the styles that come with LAMMPS."""
    return [line for moving in scene.gates for line in stock_wall(moving, scene)]


def unwritten(scene: Scene) -> str:
    """Walls that the styles of LAMMPS cannot write, with wall and field; empty where they write all."""
    try:
        for moving in scene.walls:
            stock_wall(moving, scene)
    except NotInStock as lack:
        return str(lack)
    return ""


def stock_wall(moving: MovingWall, scene: Scene) -> list[str]:
    """One wall or gate; the fixes of a probed one keep its contacts.

    Raises
    ------
    NotInStock
        The styles of LAMMPS cannot write it.
    """
    wall, motion = moving
    law, name = wall_law(scene, wall.name), wall.name
    tail = " contacts" if name in scene.probes else ""
    if motion.kind is None:
        if plain := (_plain_gate if motion.gone < inf else _plain_wall)(moving, law, tail):
            return plain
    check_motion(moving)
    regions = single_regions(wall, motion.about)
    if not regions:
        return _polyline(moving, scene, law, tail)
    lines = moving_variables(moving)
    for count, region in enumerate(regions, 1):
        more, words = _moved(moving, region, count)
        part = name if len(regions) == 1 else f"{name}_{count}"
        solid, fix = (f"solid_{name}", f"wall_{name}") if len(regions) == 1 else (f"face_{part}",) * 2
        lines += [
            *more,
            f"region          {solid} {region.words}{words}",
            f"fix             {fix} all wall/gran/region {law} region {solid}{tail}",
        ]
    return lines


def _polyline(moving: MovingWall, scene: Scene, law: str, tail: str) -> list[str]:
    """A standing wall of several faces, as an intersection."""
    if scene.springs is not None:
        raise NotInStock(f"springs with memory at a polyline (wall '{moving.wall.name}', field contact.friction_law)")
    wall, motion = moving
    if motion.kind is not None or motion.gone < inf:
        field = "motion" if motion.kind else "gate"
        raise NotInStock(f"polyline that moves (wall '{wall.name}', field {field})")
    if tail and any(turn > 0 for turn in joints(wall)):
        # contacts of a fix hold one contact of each disc; two faces of a corner push at once
        raise NotInStock(f"probe of a polyline with a concave corner (wall '{wall.name}', field probes.forces)")
    return [
        *polyline(wall, scene),
        f"fix             wall_{wall.name} all wall/gran/region {law} region solid_{wall.name}{tail}",
    ]


def moving_variables(moving: MovingWall) -> list[str]:
    """Displacement and turn of a wall at each step, as far as it has them: ``x_NAME``, ``y_NAME``, ``angle_NAME``."""
    name = moving.wall.name
    named = zip(("x", "y", "angle"), way(moving), strict=True)
    return [f"variable        {part}_{name} equal {formula}" for part, formula in named if formula]


def moved(moving: MovingWall, shifts: tuple[str, str] = ("", ""), angle: str = "") -> str:
    """Words that move a region with its wall; `shifts` and `angle` are variables in place of the wall's own."""
    name, motion = moving.wall.name, moving.motion
    own = [f"{part}_{name}" if formula else "" for part, formula in zip(("x", "y", "angle"), way(moving), strict=True)]
    x, y, turn = (other or mine for other, mine in zip((*shifts, angle), own, strict=True))
    words = f" move {' '.join(f'v_{axis}' if axis else 'NULL' for axis in (x, y))} NULL" if x or y else ""
    return words + (f" rotate v_{turn} {numbers(*motion.about)} 0 0 0 1" if turn else "")


def _moved(moving: MovingWall, region: LammpsRegion, count: int) -> tuple[list[str], str]:
    """Variables of one region of a wall, and the words of its motion."""
    (name, motion), lines = (moving.wall.name, moving.motion), []
    there, shifts, turn = way(moving), ["", ""], ""
    if motion.gone < inf:
        out = region.inward if any(region.inward) else (1.0, 0.0)
        for axis, share in enumerate(out):
            if share:
                shifts[axis] = f"open_{'xy'[axis]}_{name}_{count}"
                own = f"v_{'xy'[axis]}_{name}+" if there[axis] else ""
                lines.append(
                    f"variable        {shifts[axis]} equal {own}({number(-share * FAR)})*(step>={motion.gone:g})"
                )
    if region.angle:
        turn = f"turn_{name}"
        own = f"+v_angle_{name}" if there.angle else ""
        lines.append(f"variable        {turn} equal {number(region.angle)}{own}")
    return lines, moved(moving, (shifts[0], shifts[1]), turn)


def _plain_wall(moving: MovingWall, law: str, tail: str) -> list[str]:
    """Planes and boxes along the axes, which push from any depth; nothing for others."""
    wall = moving.wall
    if not wall.deep or not level(wall):
        return []
    if isinstance(wall, Plane):
        ends = f"{number(wall.at)} NULL" if wall.side == "above" else f"NULL {number(wall.at)}"
        return [f"fix             wall_{wall.name} all wall/gran {law} {wall.axis}plane {ends}{tail}"]
    return [
        f"fix             wall_{wall.name}_{axis} all wall/gran {law} {axis}plane {numbers(*ends)}{tail}"
        for axis, ends in zip("xy", wall.extent, strict=True)
    ]


def pushing_extents(wall: Wall) -> list[tuple[Interval, Interval]]:
    """Rectangles (x, y) around what pushes in the styles of LAMMPS, m: a box has four planes."""
    if not isinstance(wall, Box):
        return [wall.extent]
    endless = (-inf, inf)
    return [((x, x), endless) for x in wall.x] + [(endless, (y, y)) for y in wall.y]


def _plain_gate(moving: MovingWall, law: str, tail: str) -> list[str]:
    """The face of a half-space that jumps out of the way at a step; two faces of a block, which both sides feel.

    To remove the fix between two runs would be the shorter text. But a second run computes its first forces anew with
    velocities of the full step, where a run that goes on has those of the half step: an error of 1e-5 d.
    """
    wall, step = moving.wall, moving.motion.gone
    if isinstance(wall, Block) and level(wall):
        x = wall.x[0]
        sides = Plane(wall.name, "x", x, "below"), Plane(f"{wall.name}_far_side", "x", x, "above")
        return [line for side in sides for line in _plain_gate(MovingWall(side, moving.motion), law, tail)]
    if not isinstance(wall, Plane):
        return []
    inward = f"{number(wall.sign)} 0 0" if wall.axis == "x" else f"0 {number(wall.sign)} 0"
    point = f"{number(wall.at)} 0 0" if wall.axis == "x" else f"0 {number(wall.at)} 0"
    away = f"move v_open_{wall.name} NULL NULL" if wall.axis == "x" else f"move NULL v_open_{wall.name} NULL"
    return [
        f"variable        open_{wall.name} equal {number(-wall.sign * FAR)}*(step>={step})",
        f"region          shut_{wall.name} plane {point} {inward} {away}",
        f"fix             wall_{wall.name} all wall/gran/region {law} region shut_{wall.name}",
    ]
