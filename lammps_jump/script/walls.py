# SPDX-License-Identifier: GPL-2.0-or-later
"""LAMMPS commands of walls and gates.

The styles that come with LAMMPS write the walls that have a writer here; the plugin takes the faces of every wall.
"""

from __future__ import annotations

from functools import singledispatch
from math import inf

from lammps_jump.physics.contact import WallLaw, restitution_of
from lammps_jump.scene import Block, Box, Interval, MovingWall, Plane, Scene, Wall
from lammps_jump.scene.chains import WALL

FAR = 1e4
"""Distance that an opened gate is moved away, m."""

JOIN = " &\n                "
"""Goes on with a command in the next line."""


def number(value: float) -> str:
    """Shortest text that LAMMPS reads back as the same double."""
    text = repr(float(value))
    return text[:-2] if text.endswith(".0") else text


def numbers(*values: float) -> str:
    """Several numbers, between blanks."""
    return " ".join(number(value) for value in values)


def fix_names(lines: list[str]) -> list[str]:
    """Names of the fixes that commands define."""
    return [line.split()[1] for line in lines if line.startswith("fix ")]


def granular_law(scene: Scene, stiffness: float, ratio: float, tangential: float) -> str:
    """Words of LAMMPS' granular styles for discs that are not equal.

    ``coeff_restitution`` makes the dashpot 2 xi sqrt(k m_eff) of each contact, xi from a restitution coefficient. The
    tangential dashpot is a multiple of it.

    Parameters
    ----------
    scene : Scene
    stiffness : float
        N/m.
    ratio : float
        Damping ratio xi.
    tangential : float
        Tangential dashpot over the normal one.
    """
    friction = scene.coefficients.friction
    rub = numbers(tangential, friction) if friction else "0 0"
    return (
        f"hooke {numbers(stiffness, restitution_of(ratio))} tangential linear_nohistory {rub} damping coeff_restitution"
    )


def wall_law(scene: Scene) -> str:
    """Contact law of stock wall fixes."""
    c = scene.coefficients
    if scene.sizes:
        ratio = c.damping_ratio * c.correction_wall
        return f"granular {granular_law(scene, c.stiffness_wall, ratio, c.tangential_ratio_wall)}"
    # the wall fixes divide by gamma_n: zero would give NaN forces
    normal = number(c.gamma_normal_wall) if c.gamma_normal_wall > 0 else "1e-12"
    rub = f"{numbers(c.gamma_tangential_wall, c.friction)} 1" if c.friction else "0 0 0"
    return f"hooke {number(c.stiffness_wall)} NULL {normal} {rub}"


def stock_walls(scene: Scene) -> list[str]:
    """All permanent walls, with the styles that come with LAMMPS."""
    return [line for wall in scene.permanent for line in stock_wall(wall, scene)]


def stock_wall(wall: Wall, scene: Scene) -> list[str]:
    """One wall; the fixes of a probed one keep its contacts."""
    return _stock(wall, wall_law(scene), " contacts" if wall.name in scene.probes else "")


def unwritten(scene: Scene) -> tuple[Wall, ...]:
    """Walls that the styles of LAMMPS cannot write."""
    unknown = [wall for wall in scene.permanent if _stock.dispatch(type(wall)) is _stock.dispatch(object)]
    return *unknown, *(gate.wall for gate in scene.gates if not isinstance(gate.wall, Plane | Block))


@singledispatch
def _stock(wall: Wall, law: str, tail: str) -> list[str]:
    raise TypeError(f"wall '{wall.name}': no style of LAMMPS pushes like a {type(wall).__name__}")


@_stock.register
def _(wall: Plane, law: str, tail: str) -> list[str]:
    ends = f"{number(wall.at)} NULL" if wall.side == "above" else f"NULL {number(wall.at)}"
    return [f"fix             wall_{wall.name} all wall/gran {law} {wall.axis}plane {ends}{tail}"]


@_stock.register
def _(wall: Block, law: str, tail: str) -> list[str]:
    # faces in z at infinity: a finite one counts as a contact of its own
    return [
        f"region          solid_{wall.name} block {numbers(*wall.x, *wall.y)} INF INF side out",
        f"fix             wall_{wall.name} all wall/gran/region {law} region solid_{wall.name}{tail}",
    ]


@_stock.register
def _(wall: Box, law: str, tail: str) -> list[str]:
    return [
        f"fix             wall_{wall.name}_{axis} all wall/gran {law} {axis}plane {numbers(*ends)}{tail}"
        for axis, ends in (("x", wall.x), ("y", wall.y))
    ]


def pushing_extents(wall: Wall) -> list[tuple[Interval, Interval]]:
    """Rectangles (x, y) around what pushes in the styles of LAMMPS, m: a box has four planes."""
    if not isinstance(wall, Box):
        return [wall.extent]
    endless = (-inf, inf)
    return [((x, x), endless) for x in wall.x] + [(endless, (y, y)) for y in wall.y]


def stock_gates(scene: Scene) -> list[str]:
    """All gates, with the styles that come with LAMMPS."""
    return [line for wall, motion in scene.gates for line in _stock_gate(wall, motion.gone, wall_law(scene))]


def _stock_gate(wall: Plane | Block, step: float, law: str) -> list[str]:
    """The face of a half-space that jumps out of the way at a step; two faces of a block, which both sides feel.

    To remove the fix between two runs would be the shorter text. But a second run computes its first forces anew with
    velocities of the full step, where a run that goes on has those of the half step: an error of 1e-5 d.
    """
    if isinstance(wall, Block):
        x = wall.x[0]
        sides = Plane(wall.name, "x", x, "below"), Plane(f"{wall.name}_far_side", "x", x, "above")
        return [line for side in sides for line in _stock_gate(side, step, law)]
    inward = f"{number(wall.sign)} 0 0" if wall.axis == "x" else f"0 {number(wall.sign)} 0"
    point = f"{number(wall.at)} 0 0" if wall.axis == "x" else f"0 {number(wall.at)} 0"
    away = f"move v_open_{wall.name} NULL NULL" if wall.axis == "x" else f"move NULL v_open_{wall.name} NULL"
    return [
        f"variable        open_{wall.name} equal {number(-wall.sign * FAR)}*(step>={step})",
        f"region          shut_{wall.name} plane {point} {inward} {away}",
        f"fix             wall_{wall.name} all wall/gran/region {law} region shut_{wall.name}",
    ]


def plugin_walls(scene: Scene) -> list[str]:
    """Words of the plugin's fix for every wall and gate."""
    return [plugin_wall(one, scene.own_laws.get(one.wall.name)) for one in scene.walls]


def plugin_wall(moving: MovingWall, own: WallLaw | None = None) -> str:
    """Words of one wall: its name, moment point and faces, own law and motion (``fix_jump_step.h``)."""
    wall, motion = moving
    codes, shape, _, (deep,) = wall.faces
    kept = [column for column in range(codes.shape[1]) if column != WALL]
    lines = [f"wall {wall.name} {numbers(*wall.moment_point)} {deep} {len(codes)}"]
    lines += [
        f"{' '.join(map(str, code))} {numbers(*row)}" for code, row in zip(codes[:, kept].tolist(), shape, strict=True)
    ]
    lines += [f"law {numbers(*own)}"] if own else []
    lines += [] if motion.gone == inf else [f"until {int(motion.gone)}"]
    if load := motion.load:
        free = f"{int(load.axis != 'y')} {int(load.axis != 'x')}"
        place = f"{numbers(*motion.about)} {motion.start}"
        lines += [f"lid {place} {numbers(load.mass, *load.force)} {free} {number(load.begin)}"]
    elif motion.kind:
        lines += [f"move {numbers(*motion.about)} {motion.start} {len(motion.track)}"]
        lines += [numbers(*row) for row in motion.track]
    return JOIN.join(lines)
