# SPDX-License-Identifier: GPL-2.0-or-later
"""Walls of any shape in stock scripts, standing and moving, against the native engine: places, spin, forces, power."""

from __future__ import annotations

from contextlib import chdir
from dataclasses import dataclass, replace
from math import cos, radians, sin

import numpy as np
import pytest
from made_up import some_long

from lammps_jump.dump.find import read_forces, write_forces
from lammps_jump.dump.read import open_dump
from lammps_jump.engines.checkpoint import read_checkpoint
from lammps_jump.engines.lammps.loader import load_lammps
from lammps_jump.engines.lammps.outputs import gather_forces
from lammps_jump.engines.launch import Setting, run
from lammps_jump.engines.native.simulation import NativeSimulation
from lammps_jump.physics.contact import WallLaw
from lammps_jump.scene import Block, Box, Chain, Motion, MovingWall, Plane, Sizes, Wall, handmade_scene
from lammps_jump.scene.chains import circle
from lammps_jump.scene.scene import InletRow
from lammps_jump.scene.tracks import Oscillate, Rotate, TableMotion, Translate
from lammps_jump.script import write_script

pytestmark = pytest.mark.lammps

D = 0.2
STEPS = 1000
PLACES = np.array([[x, y] for x in np.arange(-1, 1.1, 0.25) for y in (0.45, 0.7, 0.95)])
PLACES = PLACES + np.random.default_rng(1).normal(0, 0.01, PLACES.shape)


def raised(height):
    """The same discs higher, m."""
    return PLACES + np.array([0.0, height])


@dataclass(frozen=True)
class Drawn(Wall):
    """A wall of given chains."""

    kind: str = "drawn"
    name: str = "wall"
    drawn: tuple[Chain, ...] = ()

    def chains(self):
        return self.drawn


def drawn(*points, closed=False):
    return Drawn(drawn=(Chain(points, closed=closed),))


def tilted(angle, x=(-1.5, 1.5), y=(-0.2, 0.3)):
    """A block turned about the origin, degrees."""
    c, s = cos(radians(angle)), sin(radians(angle))
    corners = (x[0], y[0]), (x[0], y[1]), (x[1], y[1]), (x[1], y[0])
    return drawn(*((c * a - s * b, s * a + c * b) for a, b in corners), closed=True)


def scene_of(wall, kind=None, about=(0.0, 0.0), *, positions=PLACES, velocities=None, **others):
    settings = {"friction": 0.3, "rotation": True, "impact_speed": 8.0, "skin": 0.06, "overlap_limit": D}
    settings |= {"probes": (wall.name,), "probe_steps": 50, "steps": STEPS, "output_steps": STEPS}
    settings["domain"] = ((-5.0, 5.0), (-5.0, 5.0))
    places = np.asarray(positions, float)
    start = 0 * places if velocities is None else velocities
    found = handmade_scene(places, start, (), **(settings | others))
    motion = Motion(kind=kind, about=about, ease=0.01, time_step=found.time_step)
    return replace(found, walls=(MovingWall(wall, motion),))


def both(scene, folder):
    """Places, spin and forces of the stock script, and the same of the native engine."""
    text = write_script(scene, folder).read_text()
    assert "No run" not in text
    with chdir(folder):
        engine = load_lammps().lammps(cmdargs=["-log", "none", "-screen", "none", "-nocite"])
        try:
            engine.commands_string(text)
            n = engine.extract_global("nlocal")
            order = np.argsort(np.array(engine.numpy.extract_atom("id")[:n]))
            places = np.array(engine.numpy.extract_atom("x")[:n, :2])[order]
            spin = np.array(engine.numpy.extract_atom("omega")[:n, 2])[order]
        finally:
            engine.close()
    native = NativeSimulation(scene)
    native.run(scene.steps)
    records = []
    if scene.probes:
        gather_forces(scene, folder)
        records.append(read_forces(folder / "forces.csv"))
        write_forces(folder / "native.csv", scene, native.forces)
        records.append(read_forces(folder / "native.csv"))
    return (places, spin), (native.positions, native.spin), records


OSCILLATES = Oscillate(amplitude=(0.1, 0.1), angle=10.0, period=0.3, phase=20.0)
EACH = Oscillate(amplitude=(0.1, 0.2), angle=10.0, period=(0.3, 0.2, 0.5), phase=(20.0, 0.0, -40.0))
TABLE = TableMotion(points=((0.02, 0.02, 0.0, 0.0), (0.05, 0.0, 0.05, 5.0)))
EXACT = {
    "block at an angle": scene_of(tilted(10.0), positions=raised(0.25)),
    "block along a table": scene_of(tilted(7.0), TABLE, (0.2, 0.1), positions=raised(0.16)),
    "block that turns": scene_of(Block("wall", (-1.5, 1.5), (-0.2, 0.3)), Rotate(rate=90.0)),
    "block, each its own": scene_of(Block("wall", (-1.5, 1.5), (-0.2, 0.3)), EACH),
    "block that stops": scene_of(Block("wall", (-1.5, 1.5), (-0.2, 0.3)), Translate(velocity=(1.0, 1.0), until=0.1)),
    "segment": scene_of(drawn((-1.5, 0.1), (1.5, 0.3))),
    "segment that turns": scene_of(drawn((-1.5, 0.1), (1.5, 0.3)), Rotate(rate=-60.0)),
    "leaf": scene_of(Block("wall", (0.8, 0.8), (0.0, 1.5)), Rotate(rate=60.0), (0.8, 0.0)),
    "drum": scene_of(Drawn(drawn=(circle((0.0, 1.5), 1.6, inside=True),)), Rotate(rate=90.0), (0.0, 1.2)),
    "pier": scene_of(Drawn(drawn=(circle((0.0, 0.0), 0.4, inside=False),)), OSCILLATES),
    "box": scene_of(Box("wall", (-1.3, 1.3), (0.2, 2.0)), OSCILLATES, (0.0, 0.5)),
    "plane": scene_of(Plane("wall", "y", 0.3, "above"), OSCILLATES, (0.0, 0.5)),
    "block that stands": scene_of(Block("wall", (-0.5, 1.5), (-0.2, 0.3))),
    "box that stands": scene_of(Box("wall", (-1.3, 1.3), (0.3, 2.0))),
    "plane that stands": scene_of(Plane("wall", "y", 0.3, "above")),
    "own law": replace(
        scene_of(Block("wall", (-1.5, 1.5), (-0.2, 0.3)), friction=0.0),
        own_laws={"wall": WallLaw(4e6, 300.0, 900.0, 0.8)},
    ),
    "own law, sizes": replace(
        scene_of(tilted(10.0), positions=raised(0.16), sizes=Sizes((1.0,), (0.16,), (0.24,), 1)),
        own_laws={"wall": WallLaw(4e6, 300.0, 900.0, 0.8)},
    ),
    "concave corners": scene_of(drawn((-2.0, 0.6), (-0.5, 0.2), (0.3, 0.2), (2.2, 0.7)), probes=()),
}


@pytest.mark.parametrize("name", [some_long(name, number % 3 > 0) for number, name in enumerate(EXACT)])
def test_the_stock_script_is_the_native_engine(name, tmp_path):
    """At most 4e-13 d were measured over 1,000 steps; friction and collisions amplify the last bits."""
    scene = EXACT[name]
    stock, native, records = both(scene, tmp_path)
    assert np.abs(native[0] - scene.positions).max() > 0.1 * D
    assert np.abs(stock[0] - native[0]).max() < 1e-11 * D
    assert np.abs(stock[1] - native[1]).max() < 1e-8
    for written, exact in zip(*(record.values() for record in records), strict=True) if records else ():
        assert np.abs(exact.fy).max() > 100.0
        for column in ("fx", "fy", "moment", *(["power"] if scene.moves else [])):
            one, other = getattr(written, column), getattr(exact, column)
            # ten digits are written
            assert one == pytest.approx(other, rel=1e-8, abs=1e-9 * max(1.0, np.abs(exact.fy).max())), column
        assert (written.power is None) == (not scene.moves)


def test_a_standing_wall_beside_a_moving_one_has_no_power(tmp_path):
    scene = scene_of(Block("wall", (-1.5, 1.5), (-0.2, 0.3)), OSCILLATES)
    box = MovingWall(Box("box", (-2.0, 2.0), (-2.0, 3.0)))
    scene = replace(scene, walls=(*scene.walls, box), probes=("box", "wall"), steps=200)
    _, _, (written, exact) = both(scene, tmp_path)
    assert list(written["box"].power) == [0.0] * 4 == list(exact["box"].power)
    assert written["wall"].power == pytest.approx(exact["wall"].power, rel=1e-8)


HEXAGON = tuple((0.9 * cos(radians(-60 * i - 10)), -0.5 + 0.9 * sin(radians(-60 * i - 10))) for i in range(6))
OCTAGON = tuple((0.04 * cos(radians(-45 * i - 10)), 0.1 + 0.04 * sin(radians(-45 * i - 10))) for i in range(8))


@pytest.mark.parametrize(
    "points, closed, at",
    [
        (HEXAGON, True, [[-0.05, 0.55], [0.35, 0.5], [0.6, 0.4]]),
        (OCTAGON, True, [[-0.02, 0.5], [0.3, 0.3]]),  # thinner than a radius: its far side must not be felt through it
        (((-1.0, 0.2), (0.0, 0.3), (1.0, -0.2)), False, [[-0.4, 0.5], [0.3, 0.4]]),
    ],
    ids=["hexagon", "thin octagon", "crest"],
)
def test_a_polyline_rounds_its_vertices(points, closed, at, tmp_path):
    """A vertex is low by 1e-4 d (sec(theta/2) - 1); 1.2e-4 d was measured where a disc goes round several."""
    velocities = [[0.5, -1.0]] * len(at)
    scene = scene_of(drawn(*points, closed=closed), positions=at, velocities=velocities)
    stock, native, (written, exact) = both(scene, tmp_path)
    assert 0 < np.abs(stock[0] - native[0]).max() < 1e-4 * D
    assert written["wall"].moment == pytest.approx(exact["wall"].moment, rel=1e-2, abs=1e-2 * 3000.0)
    assert np.abs(exact["wall"].fy).max() > 1000.0


def test_a_gate_that_moves_is_gone_at_its_step(tmp_path):
    """Discs lean on a turning leaf; from its last step on they fall as without it."""
    scene = scene_of(tilted(10.0), Rotate(rate=20.0), positions=raised(0.25), probes=())
    (wall, motion), stop = scene.walls[0], 400
    scene = replace(scene, walls=(MovingWall(wall, replace(motion, gone=stop)),))
    stock, native, _ = both(scene, tmp_path)
    assert np.abs(stock[0] - native[0]).max() < 1e-11 * D


def test_an_interrupted_run_keeps_the_speed_of_its_walls(tmp_path):
    """A region's velocity is no part of a restart: without its step before, dashpots see a wall that stands."""
    scene = scene_of(Block("wall", (-1.5, 1.5), (-0.2, 0.3)), OSCILLATES, steps=600, output_steps=50)
    run(scene, tmp_path / "whole", Setting())
    first = run(scene, tmp_path / "parts", Setting(stop_at=310))
    assert first.status == "interrupted"
    last = run(scene, tmp_path / "parts", Setting(), resume=read_checkpoint(tmp_path / "parts"))
    assert last.status == "complete"
    one, two = (open_dump(tmp_path / part / "dump.lammpstrj")[-1] for part in ("whole", "parts"))
    assert np.array_equal(one.x, two.x) and np.array_equal(one.vy, two.vy)
    forces = [read_forces(tmp_path / part / "forces.csv")["wall"] for part in ("whole", "parts")]
    assert np.array_equal(forces[0].power, forces[1].power) and len(forces[0].time) == 12


def test_inlets_that_wait_find_walls_with_their_speed(tmp_path):
    """A second run begins with the inlets, in contact here; with walls that stand at its first step: 3e-2 d."""
    scene = scene_of(Block("wall", (-1.5, 1.5), (-0.2, 0.3)), OSCILLATES)
    row = InletRow(-3.0, 2.0, 3.0, 0.0, first_step=201, every_steps=5000, clearance=D)
    scene = replace(scene, inlets=(row,), steps=800)
    stock, native, (written, exact) = both(scene, tmp_path)
    assert len(stock[0]) == len(PLACES) + 1
    assert np.abs(stock[0] - native[0]).max() < 1e-11 * D
    assert written["wall"].time == pytest.approx(exact["wall"].time)  # a row a window, at the join too
    assert written["wall"].power == pytest.approx(exact["wall"].power, rel=1e-8, abs=1e-5)
