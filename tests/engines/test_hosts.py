# SPDX-License-Identifier: GPL-2.0-or-later
"""Every host of the step beside the native engine: laws, walls, motions, sizes, discs that come and go.

A scene stands here once and is stepped by each host that has what it needs: the compiled styles, stock LAMMPS by its
generated script, and the twin. Closed forms are in `tests/contacts`; the twin's states are compared one by one in
`test_twin.py`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from hosts import NativeHost, at_end, start
from laws import ROLLING

from lammps_jump.dump.walls import PoseFile
from lammps_jump.files import POSES
from lammps_jump.physics.contact import WallLaw
from lammps_jump.physics.slip import Rolling, Springs
from lammps_jump.scene import Block, Box, InletRow, Motion, MovingWall, Plane, Sizes, gate, handmade_scene
from lammps_jump.scene.scene import Fixed, Outlet, Pour, Scene
from lammps_jump.scene.tracks import Loaded, Oscillate, Rotate, TableMotion, Translate
from lammps_jump.scene.walls import Circle, Line
from lammps_jump.script.stock import lacking

D = 0.2
STEPS = 1000
TWIN_STEPS = 40
"""Plain Python is slow; the last digits differ from the first step on, because sums have another order."""
EQUAL = 1e-9
"""Diameters, after a thousand steps with collisions: what engines promise. Velocities and spins are a digit worse."""
EMPTY = np.zeros((0, 2))

UNIFORM = Sizes((1.0,), (0.16,), (0.24,))
THREE = Sizes((0.5, 0.3, 0.2), (0.16, 0.2, 0.22), (0.16, 0.22, 0.24), seed=5)
FLOOR = (Plane("floor", "y", 0.0, "above"), Plane("left", "x", 0.0, "above"), Plane("lid", "y", 3.2, "below"))
CORNERS = (
    Block("ground", (-2.5, 1.2), (-3.0, 0.1)),
    Block("sill", (1.2, 2.0), (-3.0, 0.25)),
    Box("room", (0.1, 4.0), (-2.0, 3.5)),
)
SHAPES = (
    *CORNERS[2:],
    Line("bed", points=((0.1, 0.3), (0.8, 0.05), (3.0, 0.2)), rolling=0.05),
    Circle("pier", (1.2, 0.15), 0.2, discs="outside"),
    Block("hump", (0.4, 0.8), (-0.3, 0.28), angle=15.0),
)


def scene(positions: Any, velocities: Any, walls: Any, **more: Any) -> Scene:
    """With the coefficients of the hydraulic jump, whose kernels correct the restitution."""
    settings = {
        "steps": STEPS, "output_steps": STEPS, "skin": 0.06, "overlap_limit": D, "correct_restitution": True,
        "domain": ((-3.0, 9.0), (-4.0, 9.0)),
    }  # fmt: skip
    return handmade_scene(positions, velocities, walls, **settings | more)


def cloud(seed: int = 1, nx: int = 8, ny: int = 8, gap: float = 0.01, **more: Any):
    """Discs near a lattice with random velocities, so that many collide within a thousand steps."""
    random, apart = np.random.default_rng(seed), D + gap
    grid = np.array([(0.3 + apart * i, 0.4 + apart * j) for i in range(nx) for j in range(ny)])
    return grid + random.normal(0, 0.002, grid.shape), random.normal(0, 3.0, grid.shape)


def heap(walls: Any, **more: Any) -> Scene:
    """A cloud that falls on walls."""
    return scene(*cloud(gap=0.05 if "sizes" in more else 0.01), walls, **more)


def jet(**more: Any) -> Scene:
    """Rows that shoot at a cloud on a sill; discs leave there."""
    rows = tuple(InletRow(-0.5, 0.25 + 0.25 * i, 12.0, 0.0, 10, 150 - 10 * i, 0.999 * 0.24) for i in range(4))
    walls = (Block("floor", (-2.5, 1.6), (-3.0, 0.0)), Block("sill", (1.0, 1.6), (-3.0, 0.4)))
    places, speeds = cloud(4, 6, 5, gap=0.05)
    free = (places[:, 1] > 0.52) | (places[:, 0] < 0.88)  # a block pushes the centres in it out, LAMMPS does not
    return scene(
        places[free], speeds[free], walls, inlets=rows, outlets=(Outlet("x", 1.4, "above", 50),), size_steps=10, **more
    )


def flood(**more: Any) -> Scene:
    """The jet with turns and speeds of its own for each disc, as of an inflow against time."""
    found = jet(**more)
    rows = []
    for row in found.inlets:
        turns = tuple(range(row.first_step, STEPS + 1, row.every_steps))
        rows.append(replace(row, turns=turns, speeds=tuple(row.vx - 0.3 * k for k in range(len(turns)))))
    return replace(found, inlets=tuple(rows))


def pour(**more: Any) -> Scene:
    """Discs that are dropped: each engine draws its own places, so that the compiled styles are held to stock ones."""
    room = Box("room", (0.0, 2.0), (0.0, 6.0))
    drop = Pour((0.2, 1.8), (0.3, 1.5), 40, 0.5, 4.0)
    return scene(EMPTY, EMPTY, (room,), pours=(drop,), size_steps=100, **{"steps": 4000, **more})


def waits(**more: Any) -> Scene:
    """A cloud behind a gate, and an inlet that waits until it is gone."""
    row = InletRow(6.0, 6.0, 2.0, 0.0, 120, 120, 0.24)
    shut = gate(Plane("gate", "x", 2.2 if "sizes" in more else 1.9, "below"), 119)
    return heap(
        (*FLOOR[:2], shut), inlets=(row,), settle_steps=119, size_steps=8, probe_steps=50, **more,
    )  # fmt: skip


def channel(**more: Any) -> Scene:
    """Periodic, over a rough bed of fixed discs."""
    places = np.array([(0.25 * i + 0.1, 0.22 * j + 0.2) for i in range(16) for j in range(3)])
    speeds = np.random.default_rng(3).normal((3.0, 0.0), 1.0, places.shape)
    bed = np.array([(0.1 * i, 0.0) for i in range(40)])
    n = len(places)
    return scene(
        np.concatenate([places, bed]), np.concatenate([speeds, 0 * bed]), FLOOR[:1], periodic=True,
        domain=((0.0, 4.0), (-1.0, 8.0)), gravity=(3.0, -9.0), fixed=Fixed(n + 1, n + 40),
        **{"sizes": Sizes((1.0,), (0.16,), (D,), 1, ((n + 1, n + 40, 0.1),)), **more},
    )  # fmt: skip


def behind(**more: Any) -> Scene:
    """Centres behind the face of a plane and of a block, which push them out; stock LAMMPS has no force there."""
    walls = Plane("left", "x", 0.0, "above"), Block("block", (2.0, 4.0), (-1.0, 0.0))
    return scene([[-0.05, 1.0], [3.0, -0.05]], [[0.0, 1.0], [1.0, 0.0]], walls, probes=("left", "block"), **more)


BOX, BLOCK = Box("box", (0.1, 2.7), (0.2, 3.0)), Block("block", (1.0, 1.7), (-0.2, 0.35))
OWN = {"block": WallLaw(4e6, 300.0, 900.0, 0.8)}
SHAKE = Oscillate(amplitude=(0.1, 0.2), period=0.3, angle=20.0, phase=30.0)
KINDS = {
    "translate": Translate(velocity=(0.4, 1.0), until=0.05),
    "rotate": Rotate(rate=200.0),
    "oscillate": SHAKE,
    "each its own": Oscillate(amplitude=(0.1, 0.2), period=(0.3, 0.2, 0.5), angle=20.0, phase=(30.0, 0.0, -40.0)),
    "table": TableMotion(points=((0.02, 0.0, 0.1, 0.0), (0.05, 0.05, 0.2, 30.0))),
    "load": Loaded(mass=300.0, force=(0.0, 60000.0), axis="both", begin=0.01),
}


def moved(kind: Any, wall: Any = BLOCK, **more: Any) -> Scene:
    """A block that moves in a box of discs, or the box."""
    settings = {"friction": 0.3, "rotation": True, "impact_speed": 8.0, "probe_steps": 100, "probes": ("box",)}
    places, speeds = cloud(gap=0.05)
    settings["probes"] += ("block",) * (wall is BLOCK)
    still = scene(places, 0 * speeds, (), **settings | more)
    walls = [MovingWall(BOX)] if wall is BLOCK else []
    motion = Motion(kind=kind, about=(1.4, 0.2), ease=0.01, time_step=still.time_step)
    return replace(still, walls=(*walls, MovingWall(wall, motion)))


RUBS: dict[str, Any] = {"friction": 0.3, "rotation": True}
SPRINGS = {**RUBS, "friction": 0.5, "friction_law": "history", "springs": Springs()}
ROLLS = {**SPRINGS, "springs": Springs(0.5, 0.5, Rolling(0.1, 0.1, 0.2))}
# a rolling contact is three times as stiff in friction: with 0.2 the ramp of the sign law would chatter here
# (mu F_n dt 3 / (eps m_eff) > 2) and blow round-off up
SIGN = {"friction": 0.05, "friction_law": "sign"}
SMOOTH = {"touch": "smooth", "touch_width": 0.003}
SCENES: dict[str, Callable[[], Scene]] = {
    "pairs alone": lambda: heap((), gravity=(0.0, 0.0)),
    "planes": lambda: heap(FLOOR),
    "planes, friction": lambda: heap(FLOOR, friction=0.3),
    "planes, friction, spin": lambda: heap(FLOOR, **RUBS),
    "corners, friction, spin": lambda: heap(CORNERS, **RUBS, probes=("ground", "sill"), probe_steps=250),
    "corners, friction, spin, sizes": lambda: heap(CORNERS, sizes=THREE, **RUBS),
    "planes, sizes": lambda: heap(FLOOR, sizes=UNIFORM),
    "sign": lambda: heap(CORNERS[:2], **SIGN, probes=("ground", "sill"), probe_steps=250),
    "sign, spin": lambda: heap(CORNERS[:2], **SIGN, rotation=True),
    "smooth": lambda: heap(FLOOR, **SMOOTH),
    "smooth, narrow": lambda: heap(FLOOR, friction=0.2, touch="smooth", touch_width=2e-4),
    "smooth, spin, sizes": lambda: heap(CORNERS, sizes=UNIFORM, **RUBS, **SMOOTH),
    "behind faces": lambda: behind(**SIGN),
    "springs": lambda: heap(CORNERS, **SPRINGS),
    "rolling, shapes": lambda: heap(SHAPES, **ROLLS),
    "rolling, shapes, sizes": lambda: heap(SHAPES, sizes=UNIFORM, **ROLLS),
    "rolling, planes": lambda: heap(FLOOR, **SPRINGS | {"springs": ROLLING}),
    "cohesion": lambda: heap(FLOOR, cohesion=50.0, **RUBS),
    "jet": lambda: jet(),
    "jet, friction": lambda: jet(friction=0.2),
    "jet, spin, sizes": lambda: jet(sizes=THREE, **RUBS),
    "jet, sign, spin, sizes": lambda: jet(sizes=THREE, **SIGN, rotation=True),
    "jet, springs, sizes": lambda: jet(sizes=THREE, **SPRINGS),
    "flood, springs, sizes": lambda: flood(sizes=UNIFORM, **SPRINGS),
    "waits": lambda: waits(**RUBS),
    "waits, sizes": lambda: waits(sizes=UNIFORM, **RUBS),
    "waits, sign": lambda: waits(**SIGN, probes=("floor", "gate")),
    "channel, springs": lambda: channel(**SPRINGS),
    "channel, rolling": lambda: channel(**ROLLS),
    **{f"moved, {name}": lambda kind=kind: moved(kind) for name, kind in KINDS.items()},
    "moved, the box": lambda: moved(Oscillate(amplitude=(0.1, 0.2), period=0.2), BOX),
    "moved, own law": lambda: replace(moved(KINDS["rotate"]), own_laws=OWN),
    "moved, rough alone": lambda: replace(moved(SHAKE, friction=0.0), own_laws=OWN),
    "moved, sizes": lambda: moved(KINDS["rotate"], sizes=UNIFORM),
    "moved, sign": lambda: moved(SHAKE, friction_law="sign"),
    "moved, springs": lambda: moved(SHAKE, **SPRINGS),
}


@cache
def known(name: str, steps: int) -> NativeHost:
    """The native engine after so many steps, for all hosts."""
    found = NativeHost(SCENES[name](), [])
    found.run(steps)
    return found


def rows():
    """Each scene on each host that has what it needs."""
    lammps = pytest.mark.lammps
    for name, make in SCENES.items():
        yield pytest.param(name, "compiled", marks=lammps)
        case = make()
        if not lacking(case) and not any(row.turns for row in case.inlets):  # those of a case have their table too
            yield pytest.param(name, "stock", marks=lammps)
        yield name, "twin"


@pytest.mark.parametrize(("name", "host"), list(rows()))
def test_every_host_steps_alike(name, host, tmp_path):
    case, steps = SCENES[name](), TWIN_STEPS if host == "twin" else STEPS
    native = known(name, steps)
    found = start(host, case, [], tmp_path) if host == "twin" else at_end(host, case, tmp_path)
    if host == "twin":
        found.run(steps)
    try:
        assert np.array_equal(found.ids, native.ids)
        assert np.array_equal(found.radii, native.radii)
        assert np.abs(found.positions - native.positions).max() < EQUAL * D
        assert np.abs(found.velocities - native.velocities).max() < 1e-8  # m/s, of 10 m/s
        if case.rotation:
            assert np.abs(found.spin - native.spin).max() < 1e-6  # rad/s, of 20 rad/s
        for wall in case.probes if host == "compiled" else ():
            force = native.wall(wall)
            assert found.wall(wall) == pytest.approx(force, rel=1e-7, abs=1e-6 * max(map(abs, force)))
        if case.lids and host == "compiled":
            (lid,) = case.lids
            pose = PoseFile(tmp_path / POSES, case.lids).at(case.time(STEPS))[lid]
            assert pose == pytest.approx(native.simulation.walls.poses()[lid], abs=1e-10) and abs(pose.y) > 0.01
    finally:
        found.close()


@pytest.mark.parametrize("name", SCENES)
def test_in_every_scene_something_happens(name):
    """Discs have moved and collided, have come and gone, turn, and push the walls that are asked for."""
    case, native = SCENES[name](), known(name, STEPS)
    there = np.isin(np.arange(1, len(case.positions) + 1), native.ids)
    moved = native.positions[: there.sum()] - case.positions[there]
    assert np.abs(moved).max() > 0.5 * D
    ledger = native.simulation.ledger
    assert abs(ledger["residual"]) < 1e-2 * ledger["throughput"]  # the error of the step: 5e-3 and less
    assert ledger["dissipated_dashpots"] > 0 and (ledger["dissipated_friction"] > 0) == bool(case.rubs)
    if case.rotation:
        assert np.abs(native.spin).max() > 1.0
    if case.outlets:
        boundaries = native.simulation.boundaries
        assert boundaries.removed > 2 and boundaries.inserted > len(case.positions) + 5
    assert all(any(row[2] or row[3] for row in native.simulation.forces if row[1] == wall) for wall in case.probes)


@pytest.mark.lammps
@pytest.mark.parametrize("rubs", [{}, RUBS], ids=["smooth", "friction"])
def test_a_pour_equals_the_stock_styles(rubs, tmp_path):
    """LAMMPS drops the discs in both; its gravity fix holds the weight, so that no velocity is corrected."""
    case = pour(sizes=UNIFORM, **rubs)
    stock, found = (at_end(host, case, tmp_path / host) for host in ("stock", "compiled"))
    assert np.array_equal(2 * found.radii, case.diameters(found.ids)) and len(found.ids) > 10
    assert found.by_id("f")[:, :2].max() > 100 * case.mass  # discs have landed on each other
    assert np.array_equal(found.ids, stock.ids)
    assert np.abs(found.positions - stock.positions).max() < EQUAL * D
    for host in (stock, found):
        host.close()
