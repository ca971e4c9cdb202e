# SPDX-License-Identifier: GPL-2.0-or-later
"""Walls in scripts: what the styles of LAMMPS cannot write runs with the plugin, or on the native engine."""

from dataclasses import dataclass
from math import cos, pi, sin

import pytest

from lammps_jump.engines import choice
from lammps_jump.engines.choice import choose
from lammps_jump.errors import SetupError
from lammps_jump.scene import Block, Box, Chain, Motion, MovingWall, Plane, Wall, gate, handmade_scene
from lammps_jump.scene.tracks import Loaded, Rotate, TableMotion, Translate
from lammps_jump.script import script_text

VALLEY = Chain(((0.0, 1.0), (1.0, 0.0), (2.0, 1.0)))
STEP = Chain(((0.0, 1.0), (1.0, 1.0), (1.0, 0.0), (2.0, 0.0)))
BENT = Chain(((0.0, 0.0), (1.0, 0.0), (2.0, 1.0)), (0.0, 1.0))
SHAKES = TableMotion(points=tuple((i, i % 2, 0, 0) for i in range(1, 201)))
RING = Chain(tuple((cos(-i * pi / 7), sin(-i * pi / 7)) for i in range(14)), closed=True)


@dataclass(frozen=True)
class Drawn(Wall):
    """A wall of given chains."""

    kind: str = "drawn"
    name: str = "ramp"
    drawn: tuple[Chain, ...] = ()

    def chains(self):
        return self.drawn


def scene_of(*walls, **others):
    return handmade_scene([[0.0, 3.0]], [[0.0, 0.0]], walls, steps=10, output_steps=10, **others)


def turning(*chains, kind=None):
    return MovingWall(Drawn(drawn=chains), Motion(kind=kind or Rotate(rate=10.0)))


REFUSED = {
    "polyline that moves (wall 'ramp', field motion)": turning(STEP),
    "polyline that moves (wall 'ramp', field gate)": gate(Drawn(drawn=(STEP,)), 5),
    "wall that discs push (wall 'ramp', field motion, kind load)": MovingWall(
        Block("ramp", (0, 1), (0, 1)), Motion(kind=Loaded(mass=1.0, force=(0.0, -1.0)))
    ),
    "motion of 402 rows, 200 at most (wall 'ramp', field motion.points)": MovingWall(
        Block("ramp", (0, 1), (0, 1)),
        Motion(kind=SHAKES, ease=0.1),
    ),
    "polyline of 14 faces, 12 at most (wall 'ramp', field points)": Drawn(drawn=(RING,)),
    "arc among faces (wall 'ramp', field points)": Drawn(
        drawn=(Chain(((0.0, 0.0), (1.0, 0.0), (2.0, 1.0)), (0.0, 1.0)),)
    ),
    "vertex sharper than 90 degrees at [1, 1] m (wall 'ramp', field points)": Drawn(
        drawn=(Chain(((0.0, 0.0), (1.0, 1.0), (1.5, 0.0))),)
    ),
    "smooth joint, of 2.86 degrees, at [1, 0] m (wall 'ramp', field points)": Drawn(
        drawn=(Chain(((0.0, 0.0), (1.0, 0.0), (2.0, 0.05))),)
    ),
    "solid that is 0.05 m thick between two faces (wall 'ramp', field points; 0.1 m or more)": Drawn(
        drawn=(Chain(((0.0, 0.0), (0.0, 1.0), (0.05, 1.0), (0.05, 0.0))),)
    ),
    "wall of 2 chains of faces (wall 'ramp', field kind)": Drawn(drawn=(STEP, VALLEY)),
}


@pytest.mark.parametrize("said", REFUSED)
def test_a_wall_that_no_style_of_lammps_has(said):
    scene = scene_of(REFUSED[said])
    stock = script_text(scene).splitlines()
    assert f"no {said}".replace("'", "`") in stock[1]
    assert stock[-1] == "quit 1" and not any(line.startswith("run ") for line in stock)
    assert stock[-2].count("'") == 0  # LAMMPS takes a quote mark for the begin of a text
    assert " ramp" in script_text(scene, kernel="compiled")
    with pytest.raises(SetupError) as error:
        choose("lammps", "stock", 1, scene)
    assert said in str(error.value) and "engine.kernel to compiled, or engine.name to native" in str(error.value)


def test_a_probe_that_contacts_of_a_fix_cannot_give():
    wall = Drawn(drawn=(VALLEY,))
    assert "No run" not in script_text(scene_of(wall))
    text = script_text(scene_of(wall, probes=("ramp",)))
    assert "no probe of a polyline with a concave corner (wall `ramp`, field probes.forces)" in text


def test_without_a_compiler_a_case_that_stock_lacks_runs_on_the_native_engine(monkeypatch):
    def none():
        raise SetupError("no C++ compiler")

    monkeypatch.setattr(choice, "plugin_path", none)
    setting, notes = choose("lammps", "auto", 1, scene_of(turning(STEP)))
    assert (setting.engine, setting.kernel) == ("native", "core")
    assert "native engine" in notes[-1] and "polyline that moves" in notes[-1] and "no C++ compiler" in notes[-1]
    with pytest.raises(SetupError, match="needs the compiled kernel"):
        choose("lammps", "compiled", 1, scene_of(turning(STEP)))
    assert choose("lammps", "auto", 1, scene_of(Drawn(drawn=(STEP,))))[0].engine == "lammps"


def test_walls_that_lammps_has():
    walls = Plane("p", "x", 0.0, "above"), Block("b", (0, 1), (0, 1)), Box("o", (-9, 9), (-9, 9))
    text = script_text(scene_of(*walls, gate(Plane("g", "x", 1.0, "below"), 5), gate(Block("s", (2, 2), (0, 1)), 5)))
    assert "No run" not in text and text.count("wall/gran") == 7


def test_every_region_of_a_wall_has_a_name_of_its_own():
    """A hollow that moves has four planes; the names of no other wall may be theirs."""
    box = MovingWall(Box("a", (-9, 9), (-9, 9)), Motion(kind=Translate(velocity=(1.0, 0.0))))
    others = (MovingWall(Box(f"a_{i}", (-9, 9), (-9, 9)), Motion(kind=Rotate(rate=1.0))) for i in range(1, 5))
    lines = script_text(scene_of(box, *others)).splitlines()
    for word in ("region", "fix", "variable"):
        names = [line.split()[1] for line in lines if line.startswith(f"{word} ")]
        assert len(names) == len(set(names)) > 3, word
