# SPDX-License-Identifier: GPL-2.0-or-later
"""Walls in scripts: what the styles of LAMMPS cannot write runs with the plugin alone."""

from dataclasses import dataclass

import pytest

from lammps_jump.engines.choice import choose
from lammps_jump.errors import SetupError
from lammps_jump.scene import Block, Box, Chain, Plane, Wall, gate, handmade_scene
from lammps_jump.script import script_text


@dataclass(frozen=True)
class Ramp(Wall):
    """A wall of one slanted face."""

    kind: str = "ramp"
    name: str = "ramp"

    def chains(self):
        return (Chain(((0.0, 0.0), (1.0, 0.5))),)


def scene_of(*walls):
    return handmade_scene([[0.0, 3.0]], [[0.0, 0.0]], walls, steps=10, output_steps=10)


@pytest.mark.parametrize("wall", [Ramp(), gate(Ramp(), 5), gate(Box("ramp", (0, 1), (0, 1)), 5)])
def test_a_wall_that_no_style_of_lammps_has(wall):
    scene = scene_of(wall)
    stock = script_text(scene).splitlines()
    assert "LAMMPS` own styles have no wall like `ramp`, a" in stock[1]
    assert stock[-1] == "quit 1" and not any(line.startswith("run ") for line in stock)
    assert "wall ramp 0 0 " in script_text(scene, kernel="compiled")
    with pytest.raises(SetupError, match=r"wall like 'ramp', a .* is not in stock LAMMPS; use the compiled kernel"):
        choose("lammps", "stock", 1, scene)


def test_walls_that_lammps_has():
    walls = Plane("p", "x", 0.0, "above"), Block("b", (0, 1), (0, 1)), Box("o", (-9, 9), (-9, 9))
    text = script_text(scene_of(*walls, gate(Plane("g", "x", 1.0, "below"), 5), gate(Block("s", (2, 2), (0, 1)), 5)))
    assert "No run" not in text and text.count("wall/gran") == 7
