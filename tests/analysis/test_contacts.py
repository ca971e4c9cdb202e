# SPDX-License-Identifier: GPL-2.0-or-later
"""The one neighbour search of the analysis, against trying every pair; and which discs a wall touches."""

from dataclasses import replace

import numpy as np
import pytest
from free_bodies import body, scene_of
from hypothesis import given
from hypothesis import strategies as st
from made_up import disc_frame, examples, flow_context

import lammps_jump as lj
from lammps_jump.analysis import contacts
from lammps_jump.analysis.contacts import (
    close_pairs,
    find_contacts,
    pair_sums,
    touching_pairs,
    wall_contacts,
    wall_sums,
)
from lammps_jump.analysis.flow import from_scene
from lammps_jump.core.columns import PushedColumns
from lammps_jump.engines.native import NativeSimulation
from lammps_jump.physics.contact import WallLaw
from lammps_jump.scene.chains import Chain
from lammps_jump.scene.motion import Motion, MovingWall
from lammps_jump.scene.scene import handmade_scene
from lammps_jump.scene.sizes import Sizes
from lammps_jump.scene.tracks import Rotate, Translate
from lammps_jump.scene.walls import Block, Plane, Wall
from lammps_jump.script import write_script

D, K = 0.2, 1.0e6
BOX = [[-10, 10], [-10, 10]]
FLOOR = Plane("floor", "y", 0.0, "above")


def every_pair(x, y, reach):
    i, j = np.triu_indices(len(x), 1)
    square = (x[i] - x[j]) ** 2 + (y[i] - y[j]) ** 2
    near = (square < reach**2) & (square > 0)
    return set(zip(i[near].tolist(), j[near].tolist(), strict=True))


def as_set(pairs):
    return {(min(pair), max(pair)) for pair in zip(*(part.tolist() for part in pairs), strict=True)}


@examples(60)
@given(seed=st.integers(0, 2**31), count=st.integers(0, 80), width=st.sampled_from([0.1, 1.0, 50.0, 1e6]))
def test_pairs_are_those_of_trying_all(seed, count, width):
    """From all within reach of each other (more pairs than there is room for at first) to far strays."""
    x, y = np.random.default_rng(seed).uniform(-width, width, (2, count))
    found = close_pairs(x, y, D)
    assert as_set(found) == every_pair(x, y, D)
    assert len(found[0]) == len(as_set(found))  # each once


def test_sums_are_those_over_the_contacts_found():
    x, y, vx, vy = np.random.default_rng(6).uniform(0, 1.5, (4, 80))
    frame = disc_frame(x, y, vx, vy, box=BOX)
    sill = Block("sill", (0.4, 0.8), (0.0, 0.5))
    flow = flow_context(
        domain=((-10, 10), (-10, 10)), x_range=(0, 2), walls=(FLOOR, sill), stiffness=K, stiffness_wall=2 * K,
        dashpot=300.0, dashpot_wall=200.0, touch="smooth", touch_width=0.03,
    )  # fmt: skip
    found = find_contacts(frame, flow)
    pairs = ~found.is_wall
    extent = np.abs(found.start[:, 0] - found.end[:, 0])
    thrust = pair_sums(frame, flow, np.linspace(-1, 3, 9)).thrust
    assert len(x) < pairs.sum() < found.is_wall.size
    # bins of half a metre; what is left is the rounding of sums of 1e7 N
    across = found.force * np.abs(found.normal[:, 0])
    assert thrust.sum() * 0.5 == pytest.approx(np.sum((across * extent)[pairs]), rel=1e-10)
    push = sum(np.array(wall_sums(frame, wall, flow).force) for wall in flow.scene.permanent)
    assert push == pytest.approx((found.force[:, None] * found.normal)[found.is_wall].sum(axis=0), rel=1e-12)


def test_contacts_of_a_frame_are_sought_once(monkeypatch):
    """Several analyses ask for the same of one frame; the next frame is another one, also where it looks the same."""
    flow = flow_context(domain=((-10, 10), (-10, 10)), x_range=(0, 2), walls=(FLOOR,), stiffness=K, stiffness_wall=K)
    searches = []
    monkeypatch.setattr(contacts, "close_pairs", lambda *asked: searches.append(1) or close_pairs(*asked))
    first, second = (disc_frame([0.0, 0.15], [0.05, 0.05], box=BOX) for _ in range(2))
    assert touching_pairs(first, flow) is touching_pairs(first, flow)
    assert wall_sums(first, FLOOR, flow) is wall_sums(first, FLOOR, flow)
    assert wall_sums(first, FLOOR, flow, velocity=False) is not wall_sums(first, FLOOR, flow)
    assert touching_pairs(second, flow) is not touching_pairs(first, flow)
    assert len(searches) == 3  # the first frame was forgotten for the second


def sum_of_forces(found, x, y):
    """Force of contacts on each disc, shape (n, 2), N/m."""
    push = found.force[:, None] * found.normal
    total = np.zeros((len(x), 2))
    at = {place: index for index, place in enumerate(zip(x, y, strict=True))}
    np.add.at(total, [at[tuple(place)] for place in found.start], push)
    np.subtract.at(total, [at[tuple(place)] for place in found.end[~found.is_wall]], push[~found.is_wall])
    return total


@pytest.mark.parametrize("width", [0.0, 0.004, 0.05], ids=["sharp", "mostly beyond", "mostly within"])
def test_forces_are_those_of_the_engine(width):
    """Springs and dashpots of a touch, disc by disc, as the native engine has them at the start of a run."""
    rng = np.random.default_rng(8)
    x, y, vx, vy = *rng.uniform(0.08, 1.5, (2, 60)), *rng.normal(0, 2, (2, 60))
    scene = handmade_scene(
        np.column_stack([x, y]), np.column_stack([vx, vy]), (FLOOR, Plane("back", "x", 0.0, "above")),
        gravity=(0.0, 0.0), touch="smooth" if width else "sharp", touch_width=width, overlap_limit=D,
    )  # fmt: skip
    engine = NativeSimulation(scene)
    order = np.argsort(engine.discs.ids[:60])
    expected = np.column_stack([engine.discs.fx[:60], engine.discs.fy[:60]])[order]
    flow, frame = from_scene(scene), disc_frame(x, y, vx, vy, box=BOX)
    total = sum_of_forces(find_contacts(frame, flow), x, y)
    np.testing.assert_allclose(total, expected, atol=1e-10 * np.abs(expected).max())  # sums in another order


def test_friction_at_a_wall_is_that_of_the_engine():
    """A wall has its own viscous ramp, gamma_t of the wall: with that of a pair the force would be 1.4 times this."""
    rng = np.random.default_rng(9)
    x, y, vx = 0.3 * np.arange(20), rng.uniform(0.085, 0.095, 20), rng.normal(0, 2, 20)
    scene = handmade_scene(
        np.column_stack([x, y]), np.column_stack([vx, 0 * vx]), (FLOOR,), gravity=(0.0, 0.0), friction=0.3,
        impact_speed=160.0,
    )  # fmt: skip
    c = scene.coefficients
    assert c.gamma_tangential != c.gamma_tangential_wall
    engine = NativeSimulation(scene)
    expected = float(engine.discs.fx[:20].sum())
    sums = wall_sums(disc_frame(x, y, vx, box=BOX), FLOOR, from_scene(scene))
    assert sums.force[0] == pytest.approx(expected, rel=1e-12)
    ramp = c.mass * c.gamma_tangential_wall * np.abs(vx)
    assert np.any(ramp < 0.3 * np.abs(engine.discs.fy[:20]))  # some discs are below the slip speed


def test_behind_a_plane_a_disc_is_pushed_back_and_inside_a_block_less_than_its_radius_deep():
    frame = disc_frame([0.5, 3.0, 2.0], [-0.01, -0.01, -0.5], box=BOX)
    flow = flow_context(domain=((0, 4), (0, 4)), x_range=(0, 4), stiffness=K)
    behind = wall_contacts(frame, FLOOR, flow)
    assert behind.second.tolist() == [0, 1, 2] and behind.ny.tolist() == [1, 1, 1]
    assert behind.overlap == pytest.approx([0.11, 0.11, 0.6])
    inside = wall_contacts(frame, Block("bed", (0, 4), (-1, 0)), flow)
    assert inside.second.tolist() == [0, 1] and inside.ny.tolist() == [1, 1]
    assert inside.overlap == pytest.approx(0.11)


def turned(x, y, angle):
    """A point turned about the origin."""
    return x * np.cos(angle) - y * np.sin(angle), x * np.sin(angle) + y * np.cos(angle)


def slope_of(points, closed=False):
    """A wall of one chain."""
    return type("Slope", (Wall,), {"name": "slope", "chains": lambda self: (Chain(tuple(points), closed=closed),)})()


def test_a_wall_of_a_thousand_faces_pushes_as_the_line_they_lie_on():
    """Discs in a list that is too short at first; the normals are those of the line."""
    rng, angle = np.random.default_rng(10), 0.3
    places = np.unique(np.append(rng.uniform(-5, 5, 999), (-5.0, 5.0)))
    many, one = (
        slope_of([turned(x, 0.0, angle) for x in places]),
        slope_of([turned(x, 0.0, angle) for x in (-5.0, 5.0)]),
    )
    along, height = rng.uniform(-4.9, 4.9, 300), rng.uniform(-0.05, 0.15, 300)
    frame = disc_frame(*turned(along, height, angle), box=BOX)
    flow = flow_context(domain=((-10, 10), (-10, 10)), x_range=(-5, 5), stiffness=K)
    found, expected = (wall_contacts(frame, wall, flow) for wall in (many, one))
    assert found.second.tolist() == expected.second.tolist() == np.flatnonzero(height < 0.5 * D).tolist()
    np.testing.assert_allclose(found.overlap, expected.overlap, atol=1e-14)
    np.testing.assert_allclose(found.nx, expected.nx, atol=1e-12)


def test_thrust_is_the_whole_contact_force():
    """10 kN of spring along (0.6, 0.8) and 3 kN of friction across go through a plane.

    The rims slide at 3 m/s; turning discs roll on each other at 15 rad/s, and slide the same way at half of it.
    """
    law = {"stiffness": K, "friction": 0.3, "gamma_tangential": 500.0, "rotation": True}
    flow = flow_context(domain=((-10, 10), (-10, 10)), x_range=(0, 2), **law)
    right, edges = (0.19 * 0.6, 0.19 * 0.8), np.array([-0.19 * 0.6, 0.0, 0.19 * 0.6])

    def thrust(x, y, vx, vy, **more):
        return pair_sums(disc_frame(x, y, vx, vy, box=BOX, **more), flow, edges).thrust

    x, y, vx, vy = (0.0, right[0]), (0.0, right[1]), np.array([0.0, -2.4]), np.array([0.0, 1.8])
    assert thrust(x, y, vx, vy) == pytest.approx([0.0, 6000.0 + 2400.0])
    assert thrust(x, y, -vx, -vy) == pytest.approx([0.0, 6000.0 - 2400.0])
    assert thrust(x, y, vx, vy, omegaz=np.full(2, 15.0)) == pytest.approx([0.0, 6000.0])
    assert thrust(x, y, vx, vy, omegaz=np.full(2, 7.5)) == pytest.approx([0.0, 6000.0 + 2400.0])
    # and a third disc on the left, which slides the other way than the mirror of the second
    x, y, vx, vy = (-right[0], *x), (right[1], *y), np.append(-2.4, vx), np.append(-1.8, vy)
    assert thrust(x, y, vx, vy) == pytest.approx([6000.0 - 2400.0, 6000.0 + 2400.0])


def test_discs_at_one_place_are_no_contact():
    frame = disc_frame([1.0, 1.0], [1.0, 1.0], box=BOX)
    flow = flow_context(domain=((0, 4), (0, 4)), x_range=(0, 4), stiffness=K)
    assert find_contacts(frame, flow).force.size == 0


@pytest.mark.lammps
@pytest.mark.parametrize("rotation", [False, True])
def test_forces_of_unequal_discs_are_those_of_lammps(rotation, tmp_path, monkeypatch):
    """Disc by disc at the start of a run, where LAMMPS takes the velocities of the full step."""
    from lammps_jump.engines.lammps.loader import load_lammps

    rng = np.random.default_rng(8)
    if rotation:  # apart from each other on a rough floor
        x, y = 0.4 * np.arange(1, 41), rng.uniform(0.05, 0.1, 40)
    else:
        x, y = rng.uniform(0.08, 1.5, (2, 40))
    vx, vy = rng.normal(0, 2, (2, 40))
    law = {"rotation": True, "friction": 0.3, "impact_speed": 160.0} if rotation else {}
    scene = handmade_scene(
        np.column_stack([x, y]), np.column_stack([vx, vy]), (FLOOR, Plane("back", "x", 0.0, "above")),
        gravity=(0.0, 0.0), overlap_limit=10 * D, skin=0.06, domain=((-5, 20), (-5, 5)),
        sizes=Sizes((0.5, 0.5), (0.1, 0.2), (0.2, 0.4)), **law,
    )  # fmt: skip
    monkeypatch.chdir(tmp_path)
    lammps = load_lammps().lammps(cmdargs=["-log", "none", "-screen", "none"])
    try:
        lammps.commands_string(write_script(scene, tmp_path, kernel="stock").read_text())
        order = np.argsort(lammps.numpy.extract_atom("id")[:40])
        expected, radius = (lammps.numpy.extract_atom(name)[:40][order] for name in ("f", "radius"))
        expected, radius = expected[:, :2].copy(), radius.copy()
    finally:
        lammps.close()
    flow = from_scene(scene)
    # radii from the column, or from the ids
    for frame in (disc_frame(x, y, vx, vy, box=BOX, radius=radius), disc_frame(x, y, vx, vy, box=BOX)):
        np.testing.assert_allclose(flow.radii(frame), radius, rtol=1e-13)
        if rotation:
            sums = wall_sums(frame, FLOOR, flow)
            total = np.zeros((40, 2))
            np.add.at(total, sums.index, np.column_stack([sums.fx, sums.fy]))
        else:
            total = sum_of_forces(find_contacts(frame, flow), x, y)
        np.testing.assert_allclose(total, expected, atol=1e-9 * np.abs(expected).max())


MOTIONS = {
    "still": None,
    "shifted": Translate(velocity=(3.0, -1.0), begin=-0.1),
    "turning": Rotate(rate=200.0, begin=-0.1),
}
LAWS = {"viscous": {}, "sign": {"friction_law": "sign"}, "walls alone rub": {"friction": 0.0}}


OFTEN = {("shifted", "viscous"), ("turning", "sign"), ("turning", "walls alone rub")}
"""Each law once; walls that stand still have tests of their own above."""


@pytest.mark.parametrize(
    ("kind", "law"),
    [
        pytest.param(
            MOTIONS[kind], LAWS[law], id=f"{kind}-{law}", marks=[] if (kind, law) in OFTEN else pytest.mark.long
        )
        for kind in MOTIONS
        for law in LAWS
    ],
)
def test_a_moving_wall_with_numbers_of_its_own_pushes_as_in_the_engine(kind, law):
    """Faces are found where the wall is; dashpot and friction see the velocity of the wall at the contact."""
    rng = np.random.default_rng(12)
    x, y, vx, vy, spin = *rng.uniform(-1.5, 1.5, (2, 400)), *rng.normal(0, 2, (2, 400)), rng.normal(0, 9, 400)
    scene = handmade_scene(
        np.column_stack([x, y]), np.column_stack([vx, vy]), (), gravity=(0.0, 0.0), rotation=True, impact_speed=8.0,
        overlap_limit=9.0, **({"friction": 0.3} | law),
    )  # fmt: skip
    sill, motion = Block("sill", (-0.6, 0.8), (-0.3, 0.4)), Motion(kind=kind, about=(0.5, 0.1), time_step=1e-4)
    own = WallLaw(3e5, 90.0, 70.0, 0.6)
    scene = replace(scene, walls=(MovingWall(sill, motion),), own_laws={"sill": own}, probes=("sill",))
    engine, flow = NativeSimulation(scene), from_scene(scene)
    rows = engine.discs.ids[:400] - 1
    engine.discs.omega[:400], engine.discs.vx[:400], engine.discs.vy[:400] = spin[rows], vx[rows], vy[rows]
    engine.discs.fx[:], engine.discs.fy[:] = 0.0, 0.0
    engine._forces()
    expected = np.column_stack([engine.discs.fx[:400], engine.discs.fy[:400]])[np.argsort(rows)]
    frame = disc_frame(x, y, vx, vy, box=BOX, omegaz=spin, time=0.0)
    found = contacts.touching(frame, flow)
    fx, fy = contacts.whole_forces(frame, flow, found)
    total = np.zeros((401, 2))
    np.add.at(total, found.second, np.column_stack([fx, fy]))
    np.subtract.at(total, found.first, np.column_stack([fx, fy]))
    assert (found.first == 400).sum() > 8
    np.testing.assert_allclose(total[:400], expected, atol=1e-9 * np.abs(expected).max())  # sums in another order
    (wall,) = flow.walls_at(0.0)
    assert wall_sums(frame, wall, flow).force == pytest.approx(-engine.walls.sums[0, :2], rel=1e-9)


@pytest.mark.parametrize(
    "fields",
    [{}, {"hinge": (-0.6, 0.4)}, {"axes": (False, True, True)}, {"axes": (True, False, False)}, {"begin": 9.0}],
    ids=["free", "hinged", "rail y", "rail x", "held"],
)
def test_a_body_pushes_as_in_the_engine_by_the_mass_of_each_contact(fields):
    rng = np.random.default_rng(12)
    x, y, vx, vy, spin = *rng.uniform(-1.5, 1.5, (2, 400)), *rng.normal(0, 2, (2, 400)), rng.normal(0, 9, 400)
    light = body(Block("sill", (-0.6, 0.8), (-0.3, 0.4)), (0.0, 0.0), 100.0, **fields)
    law = {"friction": 0.3, "rotation": True, "impact_speed": 8.0, "overlap_limit": 9.0, "probes": ("sill",)}
    scene = scene_of(light, positions=np.column_stack([x, y]), velocities=np.zeros((400, 2)), gravity=(0.0, 0.0), **law)
    engine, flow = NativeSimulation(scene), from_scene(scene)
    rows = engine.discs.ids[:400] - 1
    engine.discs.omega[:400], engine.discs.vx[:400], engine.discs.vy[:400] = spin[rows], vx[rows], vy[rows]
    engine.discs.fx[:], engine.discs.fy[:] = 0.0, 0.0
    engine.walls.sums[:] = 0.0
    engine.walls.moves.pushed[:, PushedColumns.SPEED] = 0.0  # what the discs of the first step have given it
    engine.walls.place(0)
    engine._forces()
    frame = disc_frame(x, y, vx, vy, box=BOX, omegaz=spin, time=0.0)
    (wall,) = flow.walls_at(0.0)
    assert wall_sums(frame, wall, flow).force == pytest.approx(-engine.walls.sums[0, :2], rel=1e-9)


def test_a_lid_that_discs_push_meets_them_with_its_velocity(tmp_path):
    """It comes down at 2 m/s on a disc at rest: the dashpot pushes as on a disc that comes up at 2 m/s."""
    case = {
        "name": "lid", "discs": {"diameter": 0.2}, "contact": {"restitution": 0.2, "impact_speed": 5},
        "domain": {"x": [-2, 2], "y": [-1, 3]}, "run": {"duration": 1},
        "walls": [{"name": "lid", "kind": "block", "x": [-1, 1], "y": [1, 1.2],
                   "motion": {"kind": "load", "mass": 50, "force": [0, 0]}}],
        "initial": [{"kind": "list", "positions": [[0.0, 0.5]]}],
    }  # fmt: skip
    scene, fallen = lj.load_case(case).scene(), 0.41
    rows = [f"{t},lid,0,{-fallen - 2 * (t - 0.2):.17g},0\n" for t in (0.0, 0.1, 0.2)]
    (tmp_path / "walls.csv").write_text("time,wall,x,y,angle\n" + "".join(rows))
    down = from_scene(scene, folder=tmp_path)
    found = [
        wall_sums(disc_frame([0.0], [0.5], 0.0, speed, box=BOX, time=time), walls_of_lid, down).fy.sum()
        for time, speed in ((0.2, 0.0), (0.2, -2.0))
        for walls_of_lid in down.walls_at(time)
    ]
    c = scene.coefficients
    spring = c.stiffness_wall * 0.01
    assert found == pytest.approx([-(spring + 2.0 * c.gamma_normal_wall * c.mass), -spring], rel=1e-6)
