# SPDX-License-Identifier: GPL-2.0-or-later
"""The plugin's rule of contact (faces.h) against that of `lammps_jump.scene.faces`, over a table of points.

Each wall is one run of 0 steps. Its discs lie across each other and may: their pairs have next to no stiffness.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from math import cos, pi, radians, sin, tan

import numpy as np
import pytest
from plugin_scripts import styles

from lammps_jump.core.library import CORE
from lammps_jump.scene import faces as rule
from lammps_jump.scene.build import handmade_scene
from lammps_jump.scene.chains import SMOOTH_TURN, Chain, boxes, circle
from lammps_jump.scene.walls import Block, Box, Plane, Wall

D = 0.2
POINTS = 300
STIFFNESS = 1e6
FLAT = Chain(tuple((x, 0.0) for x in np.linspace(-1.0, 1.0, 13)))


@dataclass(frozen=True)
class Drawn(Wall):
    """A wall of chains that are given."""

    kind: str
    drawn: tuple[Chain, ...]
    name: str = "wall"

    def chains(self):
        return self.drawn


@dataclass(frozen=True)
class DeepDrawn(Drawn):
    deep = True


def bent(*turns, length=0.35):
    """Equal straight faces with these turns (degrees) between them; positive towards the discs."""
    points, angle = [(-0.8, 0.0)], 0.0
    for turn in (*turns, 0.0):
        x, y = points[-1]
        points.append((x + length * cos(angle), y + length * sin(angle)))
        angle += radians(turn)
    return Chain(tuple(points))


def vee(degrees):
    """Two faces with this angle between them, open upwards."""
    out = tan(radians(degrees) / 2)
    return Chain(((-out, 1.0), (0.0, 0.0), (out, 1.0)))


def ring(count, *, inside):
    """Polygon with equal sides."""
    points = tuple((0.6 * cos(2 * pi * i / count), 0.6 * sin(2 * pi * i / count)) for i in range(count))
    return Chain(points if inside else points[::-1], closed=True)


WALLS = (
    Block("wall", (-0.5, 0.6), (-0.4, 0.3)),
    Block("wall", (0.1, 0.1), (-0.4, 0.3)),
    Box("wall", (-0.5, 0.6), (-0.4, 0.3)),
    Plane("wall", "x", 0.1, "above"),
    Plane("wall", "y", -0.1, "below"),
    Drawn("concave", (bent(30, 60, 15, 100),)),
    Drawn("convex", (bent(-30, -60, -15, -100),)),
    Drawn("smooth joints", (bent(1, 5, 1, 5, 4.9),)),
    Drawn("both ways", (bent(5, -5, 40, -40, 1, -1),)),
    DeepDrawn("both ways, deep", (bent(5, -5, 40, -40, 1, -1),)),
    Drawn("arcs", (Chain(((-0.6, 0), (-0.2, 0.4), (0.2, 0.4), (0.6, 0.8)), (0.4, 0.0, -0.4)),)),
    Drawn("a deep slot of arcs", (Chain(((-0.3, 0.3), (-0.3, 0.0), (0.3, 0.0), (0.3, 0.3)), (0.0, 0.3, 0.0)),)),
    Drawn("circle from inside", (circle((0.1, 0.2), 0.5, inside=True),)),
    Drawn("circle from outside", (circle((0.1, 0.2), 0.3, inside=False),)),
    Drawn("sheet", (Chain(((-0.5, 0.0), (0.4, 0.3), (-0.5, 0.0))),)),
    Drawn("V of 20 degrees", (vee(20),)),
    Drawn("V of 8 degrees", (vee(8),)),
    Drawn("slot", (Chain(((-1, 0), (-0.05, 0), (-0.05, -1))), Chain(((0.05, -1), (0.05, 0), (1, 0))))),
    Drawn("flat, in 12 pieces", (FLAT,)),
    Drawn("72 sides from inside", (ring(72, inside=True),)),
    Drawn("72 sides from outside", (ring(72, inside=False),)),
    Drawn("40 sides from inside", (ring(40, inside=True),)),
)
pytestmark = pytest.mark.lammps


def points_near(wall, generator):
    """Random places, most of them near a face or a joint, some exactly above a joint or on it."""
    joints = np.concatenate([wall.faces.shape[:, :2], wall.faces.shape[:, 2:4]])
    box = np.clip(boxes(wall.faces, deep=False), -1.0, 1.0)
    anywhere = generator.uniform(box[:, ::2].min(0) - 0.8 * D, box[:, 1::2].max(0) + 0.8 * D, (POINTS // 2, 2))
    which = generator.integers(len(joints), size=POINTS)
    close = joints[which] + generator.uniform(-0.8 * D, 0.8 * D, (POINTS, 2)) * generator.choice(
        [1.0, 1e-6, 0.0], (POINTS, 1)
    )
    above = joints + D * generator.uniform(-0.5, 0.5, (len(joints), 1)) * (0.0, 1.0)
    return np.unique(np.concatenate([anywhere, close, above]), axis=0)


def expected_contacts(wall, points, radius):
    """Contacts of every point with the wall: a list of arrays with rows of gap and normal."""
    flat = wall.faces
    every = np.arange(len(flat.codes))
    found, which = np.empty((rule.MOST, 4)), np.empty(rule.MOST, np.int64)
    answer = []
    for x, y in points:
        kept = rule.touching(flat, flat.deep[0], every, (x, y, radius), found, which)
        answer.append(found[:kept, :3].copy())
    return answer


@pytest.fixture(scope="module")
def evaluate(plugin, tmp_path_factory):
    """A function: force on each point, force and moment on the wall, by the plugin."""
    from lammps_jump.engines.lammps.loader import load_lammps

    module = load_lammps()

    def forces(wall, points):
        scene = handmade_scene(points, np.zeros_like(points), (wall,), diameter=D, gravity=(0.0, 0.0))
        soft = replace(
            scene.coefficients, stiffness=1e-290, stiffness_wall=STIFFNESS, gamma_normal=0.0, gamma_normal_wall=0.0
        )
        scene = replace(scene, coefficients=soft)
        lines = "\n".join(styles(scene, plugin, tmp_path_factory.mktemp("scene"), probe="probe 1 wall"))
        engine = module.lammps(cmdargs=["-log", "none", "-screen", "none", "-nocite"])
        try:
            engine.commands_string("""
                units si\ndimension 2\nnewton off\nboundary f f p\natom_style sphere\ncomm_modify vel yes
                region domain block -9 9 -9 9 -0.1 0.1\ncreate_box 1 domain""")
            x = np.column_stack([points, np.zeros(len(points))])
            engine.create_atoms(len(points), list(range(1, len(points) + 1)), [1] * len(points), x.ravel().tolist())
            engine.commands_string(f"""
                set group all diameter {D} mass {scene.mass!r}\nneighbor {D} bin
                {lines}
                run 0 post no""")
            order = np.argsort(engine.numpy.extract_atom("id")[: len(points)])
            found = engine.numpy.extract_atom("f")[order, :2].copy()
            return found, [engine.extract_fix("step", 0, 1, index) for index in range(3)]
        finally:
            engine.close()

    return forces


@pytest.mark.parametrize("wall", WALLS, ids=lambda wall: f"{wall.kind} {WALLS.index(wall)}")
def test_the_plugins_rule_is_the_packages(evaluate, wall):
    points = points_near(wall, np.random.default_rng(WALLS.index(wall)))
    contacts = expected_contacts(wall, points, 0.5 * D)
    force, moment = np.zeros_like(points), 0.0
    for i, rows in enumerate(contacts):
        for gap, nx, ny in rows:
            push = STIFFNESS * (0.5 * D - gap)
            force[i] += push * nx, push * ny
            arm = points[i] - gap * np.array([nx, ny]) - wall.moment_point
            moment -= push * (arm[0] * ny - arm[1] * nx)
    numbers = {len(rows) for rows in contacts}
    assert {0, 1} <= numbers  # some touch and some do not
    found, (fx, fy, mz) = evaluate(wall, points)
    # round-off of a single force; a contact more or less would be of the order of STIFFNESS times a gap
    assert np.abs(found - force).max() < 1e-12 * STIFFNESS * D
    total = np.abs(force).sum()
    assert [fx, fy, mz] == pytest.approx([*-force.sum(axis=0), moment], abs=1e-12 * total)


@pytest.mark.parametrize("count", [2_000, pytest.param(20_000, marks=pytest.mark.long)])
def test_at_the_border_of_face_and_joint_the_plugin_has_one_contact(evaluate, count):
    """Points within 1e-17 to 1e-8 d of the normals at eighty joints, convex and smooth, in front."""
    rng = np.random.default_rng(9)
    turns = np.tile([-1e-6, -0.02, -0.06, 0.01, 0.05], 16)
    angle = np.append(0.0, np.cumsum(turns))
    ends = np.cumsum(np.vstack([(-8.0, 0.0), D * np.column_stack([np.cos(angle), np.sin(angle)])]), axis=0)
    which = rng.integers(len(turns), size=count)
    at = angle[which + rng.integers(2, size=count)]  # the normal of the face before, or of that behind
    away = rng.uniform(0.01, 0.99, count) * 0.5 * D
    off = D * 10.0 ** rng.uniform(-17, -8, count) * rng.choice([-1, 1], count)
    points = ends[which + 1] + (away * [-np.sin(at), np.cos(at)] + off * [np.cos(at), np.sin(at)]).T
    wall = Drawn("joints", (Chain(tuple(map(tuple, ends))),))
    contacts = expected_contacts(wall, points, 0.5 * D)
    assert {len(rows) for rows in contacts} == {1}
    gap, nx, ny = np.array([rows[0] for rows in contacts]).T
    force, _ = evaluate(wall, points)
    # none would be 0, two twice as much
    expected = STIFFNESS * (0.5 * D - gap) * np.array([nx, ny])
    assert np.abs(force - expected.T).max() < 1e-12 * STIFFNESS * D


def test_constants_of_the_core_are_those_of_the_package():
    header = (CORE.folder / "walls" / "faces.h").read_text()
    value = {name: re.search(rf" {name} = ([^;]+);", header)[1] for name in ("MOST", "SMOOTH_TURN")}
    assert int(value["MOST"]) == rule.MOST
    assert float(value["SMOOTH_TURN"]) * pi / 180.0 * (1 + 1e-6) == rule.SAME_TURN
    assert radians(float(value["SMOOTH_TURN"])) == SMOOTH_TURN
