# SPDX-License-Identifier: GPL-2.0-or-later
"""The twin and the core, which share no line, on random states: every slot of the law, walls, motions, lists, sums."""

from __future__ import annotations

from ctypes import c_void_p
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from laws import LAWS

from lammps_jump.core.library import INTEGER, INTEGERS, REAL, REALS, function
from lammps_jump.engines.native import NativeSimulation
from lammps_jump.engines.native.bound import Core
from lammps_jump.engines.native.simulation import CellSimulation
from lammps_jump.engines.twin import Twin
from lammps_jump.scene import Block, Box, Motion, MovingWall, Plane, handmade_scene
from lammps_jump.scene.chains import Chain, circle, lay, records_of
from lammps_jump.scene.faces import MOST, foot_at, touching
from lammps_jump.scene.scene import Fixed, Stations
from lammps_jump.scene.sizes import Sizes
from lammps_jump.scene.tracks import Loaded, Oscillate, Rotate
from lammps_jump.scene.walls import Circle, Line

core_touching = function("jump_touching", c_void_p, INTEGER, INTEGERS, INTEGER, REALS, REALS, INTEGERS, result=INTEGER)
core_foot = function("jump_foot_at", c_void_p, REAL, REAL, result=REAL)
WALLS = {
    "box": [(Box("box", (-0.47, 0.47), (-0.28, 0.47)), None)],
    "joints": [
        (
            Line("line", points=((-0.52, 0.6), (-0.48, -0.2), (-0.4, -0.29), (0.1, -0.28), (0.45, -0.26), (0.49, 0.6))),
            None,
        )
    ],
    "arcs": [(Circle("drum", (0.0, 0.0), 0.625, discs="inside"), Rotate(rate=200.0))],
    "moving": [
        (Block("arm", (-0.3, 0.2), (-0.8, -0.28)), Oscillate(amplitude=(0.1, 0.05), period=0.1)),
        (Block("lid", (-0.6, 0.6), (0.48, 0.6)), Loaded(mass=20.0, force=(0.0, -200.0))),
    ],
}
STEPS = 25
"""Few enough that collisions do not amplify the last digits: these differ, because sums have another order."""
CLOSE = 1e-9


def state_of(seed, law, walls, *, sized=False, fixed=False, stations=False):
    """A scene of discs that overlap a little, move and turn at random."""
    rng = np.random.default_rng(seed)
    grid = np.array([(0.19 * i, 0.19 * j) for i in range(-2, 3) for j in range(-1, 3)])
    places = grid + rng.normal(0.0, 0.005, grid.shape)
    others = {"sizes": Sizes((1.0,), (0.17,), (0.21,), seed=1 + seed % 100)} if sized else {}
    if fixed:
        others["fixed"] = Fixed(1, 3)
    if stations:
        others["stations"] = Stations((-0.2, 0.2), 1.0, 0, STEPS - 5)
    scene = handmade_scene(
        places,
        rng.normal(0.0, 1.0, places.shape),
        (),
        diameter=0.19,
        impact_speed=8.0,
        overlap_limit=0.0,
        **others,
        **LAWS[law],
    )
    moving = [
        MovingWall(wall, Motion(kind=kind, about=(0.0, 0.0), time_step=scene.time_step)) for wall, kind in WALLS[walls]
    ]
    return replace(scene, walls=tuple(moving))


def close(one, two, what=""):
    """Equal to round-off of the largest."""
    one, two = np.asarray(one, float), np.asarray(two, float)
    scale = max(np.abs(one).max(initial=0.0), 1e-12)
    assert one.shape == two.shape, what
    assert np.abs(one - two).max(initial=0.0) <= CLOSE * scale, what


def by_partner(discs):
    """Order of the slots of each disc by what they remember: which slot has it is the engine's own."""
    partner, sigma = discs.partner[: discs.n], discs.sigma[: discs.n]
    return np.array([np.lexsort((np.round(foot, 6), one)) for one, foot in zip(partner, sigma, strict=True)])


def same(core, twin):
    """All that a simulation hands out, and what its discs remember."""
    assert np.array_equal(core.ids, twin.ids)
    assert np.array_equal(core.discs.ids[: core.discs.n], twin.discs.ids[: twin.discs.n])  # their order in memory
    for name in core.discs.columns:
        a, b = (getattr(one.discs, name)[: one.discs.n] for one in (core, twin))
        if name in ("partner", "sigma", "spring", "roll"):
            a, b = (np.take_along_axis(rows, by_partner(one.discs), 1) for rows, one in ((a, core), (b, twin)))
        close(a, b, name)
    close(core.walls.sums, twin.walls.sums, "sums on walls")
    for name, listed in core.walls.listed.items():
        assert np.array_equal(listed, twin.walls.listed[name]), name
    if core.walls.moves is not None:
        close(core.walls.moves.pushed, twin.walls.moves.pushed, "lids")
    a, b = core.ledger, twin.ledger
    scale = abs(a["throughput"]) + abs(a["kinetic"])
    assert b == pytest.approx(a, abs=CLOSE * scale, nan_ok=True)
    for one, two in zip(core.contacts(), twin.contacts(), strict=True):
        close(one, two, "contacts")
    close(core.stations.sums, twin.stations.sums, "stations")


def both(scene, engine=NativeSimulation, **options):
    """The two after some steps."""
    found = []
    for loops in (Core(), Twin()):
        simulation = engine(scene, loops=loops, **options)
        simulation.run(STEPS)
        found.append(simulation)
    return found


@pytest.mark.parametrize("walls", WALLS)
@pytest.mark.parametrize("law", LAWS)
def test_core_and_twin_agree(law, walls):
    sized = (list(LAWS).index(law) + list(WALLS).index(walls)) % 2 == 0
    core, twin = both(state_of(3, law, walls, sized=sized))
    other = core.contacts()[0][:, 1]
    assert np.count_nonzero(other > 0) > 5 and np.count_nonzero(other < 0) > 0
    same(core, twin)


@pytest.mark.parametrize("law", ["viscous, spin", "rolling"])
def test_fixed_discs(law):
    same(*both(state_of(5, law, "box", sized=True, fixed=True)))


def test_a_contact_goes_on_where_the_numbers_of_a_circle_begin():
    """Its foot jumps by the whole length there; the spring must go on."""
    scene = handmade_scene(
        [[0.535, -5e-4]], [[0.0, 1.0]], (Circle("drum", (0.0, 0.0), 0.625, discs="inside"),), diameter=0.19,
        impact_speed=8.0, overlap_limit=0.0, **LAWS["springs"],
    )  # fmt: skip
    core, twin = both(scene)
    assert core.positions[0, 1] > 5e-4 and core.discs.spring[0].max() > 5e-4
    same(core, twin)


@pytest.mark.parametrize("law", ["frictionless", "sign, spin", "rolling"])
def test_stations(law):
    core, twin = both(state_of(6, law, "box", sized=True, stations=True))
    assert np.count_nonzero(core.stations.sums) >= 5
    same(core, twin)


@pytest.mark.parametrize("sized", [False, True])
def test_search_of_the_thesis(sized):
    same(*both(state_of(7, "viscous, spin", "box", sized=sized), CellSimulation, cell_size=0.25))


@given(
    seed=st.integers(0, 10**6), law=st.sampled_from(list(LAWS)), walls=st.sampled_from(list(WALLS)), sized=st.booleans()
)
def test_random_states(seed, law, walls, sized):
    same(*both(state_of(seed, law, walls, sized=sized)))


def same_rule(faces, wall, points, radii):
    """Which faces of a wall push, from where, and the foot: bit for bit those of the specification; counts."""
    near, records, counts = np.arange(faces.first[wall], faces.first[wall + 1]), records_of(faces), []
    deep = int(faces.deep[wall])
    for (x, y), radius in zip(points, radii, strict=True):
        (found, which), (theirs, faces_of) = ((np.zeros((MOST, 4)), np.zeros(MOST, np.int64)) for _ in range(2))
        count = touching(faces, deep, near, (x, y, radius), found, which)
        of = np.array([x, y, radius])
        assert core_touching(records.ctypes.data, deep, near, len(near), of, theirs, faces_of) == count
        assert np.array_equal(theirs[:count, :3], found[:count, :3])
        assert np.array_equal(faces_of[:count], which[:count])
        for f in which[:count]:
            assert core_foot(records[int(f) : int(f) + 1].ctypes.data, x, y) == foot_at(faces, int(f), x, y)
        counts.append(count)
    return counts


@given(seed=st.integers(0, 10**6))
def test_faces_of_random_chains(seed):
    rng = np.random.default_rng(seed)
    angles = np.pi / 3 * (np.arange(6) + rng.uniform(0.1, 0.9, 6))  # seen from the middle, it goes round once
    points = tuple(
        (float(np.cos(a) * r), float(np.sin(a) * r)) for a, r in zip(angles, rng.uniform(0.5, 1.5, 6), strict=True)
    )
    wall = Line("line", points=points)
    faces = lay([(wall.chains(), False), (Circle("c", (0.3, 0.1), 0.8, discs="outside").chains(), False)])
    places = rng.uniform((-1.6, -1.6, 0.05), (1.6, 1.6, 0.4), (40, 3))
    for one in (0, 1):
        same_rule(faces, one, places[:, :2], places[:, 2])


def bent(*turns, length=0.35):
    """Equal straight faces with these turns (degrees) between them; positive towards the discs."""
    points, angle = [(-0.8, 0.0)], 0.0
    for turn in (*turns, 0.0):
        x, y = points[-1]
        points.append((x + length * float(np.cos(angle)), y + length * float(np.sin(angle))))
        angle += np.radians(turn)
    return Chain(tuple(points))


def ring(count, inside):
    """Polygon with equal sides."""
    at = 2 * np.pi * np.arange(count) / count
    points = tuple((0.6 * float(x), 0.6 * float(y)) for x, y in zip(np.cos(at), np.sin(at), strict=True))
    return Chain(points if inside else points[::-1], closed=True)


CHAINS = {
    "block": Block("wall", (-0.5, 0.6), (-0.4, 0.3)).chains(),
    "block without width": Block("wall", (0.1, 0.1), (-0.4, 0.3)).chains(),
    "box": Box("wall", (-0.5, 0.6), (-0.4, 0.3)).chains(),
    "plane": Plane("wall", "x", 0.1, "above").chains(),
    "concave": (bent(30, 60, 15, 100),),
    "convex": (bent(-30, -60, -15, -100),),
    "smooth joints": (bent(1, 5, 1, 5, 4.9),),
    "both ways": (bent(5, -5, 40, -40, 1, -1),),
    "arcs": (Chain(((-0.6, 0), (-0.2, 0.4), (0.2, 0.4), (0.6, 0.8)), (0.4, 0.0, -0.4)),),
    "a deep slot of arcs": (Chain(((-0.3, 0.3), (-0.3, 0.0), (0.3, 0.0), (0.3, 0.3)), (0.0, 0.3, 0.0)),),
    "circle from inside": (circle((0.1, 0.2), 0.5, inside=True),),
    "circle from outside": (circle((0.1, 0.2), 0.3, inside=False),),
    "sheet": (Chain(((-0.5, 0.0), (0.4, 0.3), (-0.5, 0.0))),),
    "V of 8 degrees": (Chain(((-0.07, 1.0), (0.0, 0.0), (0.07, 1.0))),),
    "slot": (Chain(((-1, 0), (-0.05, 0), (-0.05, -1))), Chain(((0.05, -1), (0.05, 0), (1, 0)))),
    "flat, in 12 pieces": (Chain(tuple((x, 0.0) for x in np.linspace(-1.0, 1.0, 13).tolist())),),
    "72 sides from inside": (ring(72, True),),
    "40 sides from outside": (ring(40, False),),
}


@pytest.mark.parametrize("deep", [False, True])
@pytest.mark.parametrize("name", CHAINS)
def test_faces_of_every_shape(name, deep):
    """Random places, most of them near a face or a joint, some exactly above a joint or on it."""
    faces, rng = lay([(CHAINS[name], deep)]), np.random.default_rng(list(CHAINS).index(name))
    joints = np.concatenate([faces.shape[:, :2], faces.shape[:, 2:4]])
    joints = joints[np.abs(joints).max(axis=1) < 2.0]
    joints = joints if len(joints) else np.array([[0.1, 0.0]])  # a plane has none
    close = rng.uniform(-0.16, 0.16, (150, 2)) * rng.choice([1.0, 1e-6, 0.0], (150, 1))
    places = np.concatenate([joints[rng.integers(len(joints), size=150)] + close, rng.uniform(-0.9, 0.9, (50, 2))])
    counts = same_rule(faces, 0, places, np.full(len(places), 0.1))
    assert {0, 1} <= set(counts)
