# SPDX-License-Identifier: GPL-2.0-or-later
"""faces.py: which faces of a wall push a disc, and from where."""

from math import acos, asin, cos, hypot, pi, radians, sin, tan

import numpy as np
import pytest
from made_up import some_long

from lammps_jump.scene.chains import Chain, circle, lay
from lammps_jump.scene.faces import MOST, foot_at, grid_of, list_near, touching
from lammps_jump.scene.shapes import flush
from lammps_jump.scene.walls import Block, Box, Plane

R = 0.1


def contacts(chains, x, y, radius=R, *, deep=False):
    """Disc, signed distance and normal of each contact with one wall, shape (contacts, 4)."""
    faces = chains.faces if hasattr(chains, "faces") else lay([(chains, deep)])
    grid, n = grid_of(faces, 2 * radius, 1.3 * radius), len(x)
    discs, plain = np.zeros(n, np.int64), np.zeros(n, np.int8)
    last, near = np.zeros(n + 1, np.int64), np.zeros(200 * n + 200, np.int64)
    rows, count = list_near((n, x, y), 0, faces, grid, (discs, plain, last, near), (0, 0))
    assert count >= 0
    found, which, result = np.empty((MOST, 4)), np.empty(MOST, np.int64), []
    for row, i in enumerate(discs[:rows]):
        kept = touching(faces, faces.deep[0], near[last[row] : last[row + 1]], (x[i], y[i], radius), found, which)
        result += [(i, *found[k, :3]) for k in range(kept)]
    return np.array(result).reshape(-1, 4)


def at(chains, x, y, **more):
    """Contacts of one disc: signed distance and normal, rows."""
    return contacts(chains, np.array([x]), np.array([y]), **more)[:, 1:]


def bent(turn):
    """A floor that turns at the origin by an angle (rad), up where it is positive."""
    return (Chain(((-1.0, 0.0), (0.0, 0.0), (cos(turn), sin(turn)))),)


@pytest.mark.parametrize(
    "turn", [some_long(turn, turn not in (-0.4, 0.01)) for turn in (-1e-6, -0.02, -0.4, -1.2, 0.01, 0.05)]
)
def test_at_the_border_of_face_and_joint_there_is_one_contact(turn):
    """20,000 points within 1e-17 to 1e-8 d of the normals at a joint, in front."""
    rng = np.random.default_rng(1)
    away = rng.uniform(0.01, 0.99, 20_000) * R
    off = 2 * R * 10.0 ** rng.uniform(-17, -8, 20_000) * rng.choice([-1, 1], 20_000)
    angle = np.where(rng.random(20_000) < 0.5, 0.0, turn)
    x, y = -np.sin(angle) * away + np.cos(angle) * off, np.cos(angle) * away + np.sin(angle) * off
    found = contacts(bent(turn), x, y)
    assert np.array_equal(found[:, 0], np.arange(20_000))


def test_a_line_in_four_hundred_pieces_is_one_line():
    rng = np.random.default_rng(2)
    places = np.concatenate([[-3.0], np.sort(rng.uniform(-3, 3, 399)), [3.0]])
    x, y = rng.uniform(-2.9, 2.9, 2000), rng.uniform(-0.9 * R, 1.2 * R, 2000)
    many = contacts((Chain(tuple((p, 0.0) for p in places)),), x, y)
    one = contacts((Chain(((-3.0, 0.0), (3.0, 0.0))),), x, y)
    assert len(one) > 1000
    np.testing.assert_allclose(many, one, atol=1e-15)


def energies_and_forces(chains, x, y):
    """Elastic energy of each disc and its force along x, with k = 1."""
    disc, gap, nx, _ = contacts(chains, x, y).T
    return (np.bincount(disc.astype(int), part, len(x)) for part in (0.5 * (R - gap) ** 2, (R - gap) * nx))


@pytest.mark.parametrize(
    "degrees", [some_long(degrees, degrees not in (5.1, -20.0)) for degrees in (1.0, 4.9, 5.1, 20.0, -1.0, -20.0)]
)
def test_energy_is_continuous_across_a_joint_and_the_force_is_its_slope(degrees):
    """A disc that goes along at one height of its centre; a jump of energy would be a share of R^2/2."""
    chains, turn = bent(radians(degrees)), radians(degrees)
    x = np.linspace(-2 * R, 2 * R, 2001)
    for height in (0.5 * R, 0.9 * R):
        y = height + np.maximum(x, 0) * tan(turn)
        energies, forces = energies_and_forces(chains, x, y)
        # from one place to the next the overlap changes by at most the step
        step = hypot(x[1] - x[0], (x[1] - x[0]) * tan(turn))
        assert np.abs(np.diff(energies)).max() < 1.01 * 2 * R * step
        h = 1e-7
        slope = (next(energies_and_forces(chains, x + h, y)) - next(energies_and_forces(chains, x - h, y))) / (2 * h)
        np.testing.assert_allclose(slope, -forces, atol=1.01 * h)  # half a step beside a place where a contact begins


def test_a_smooth_joint_pushes_once_and_a_corner_twice():
    for degrees, number in ((4.9, 1), (5.1, 2)):
        assert len(at(bent(radians(degrees)), 0.0, 0.5 * R)) == number


def test_both_tips_of_a_slot_push():
    """A disc of 2 R over a slot of half its diameter: each tip pushes along the line to the centre."""
    slot = (Chain(((-1.0, -1.0), (-1.0, 0.0), (-0.5 * R, 0.0), (-0.5 * R, -1.0)), closed=True),
            Chain(((0.5 * R, -1.0), (0.5 * R, 0.0), (1.0, 0.0), (1.0, -1.0)), closed=True))  # fmt: skip
    gap = 0.97 * R
    found = at(slot, 0.0, gap * cos(asin(0.5 / 0.97)))
    assert found[:, 0] == pytest.approx([gap, gap])
    assert sorted(found[:, 1]) == pytest.approx([-0.5 / 0.97, 0.5 / 0.97]) and found[:, 2] == pytest.approx(
        np.sqrt(1 - (0.5 / 0.97) ** 2)
    )


SILL = Block("sill", (-1.0, 2.0), (-3.0, 0.5))


@pytest.mark.parametrize(
    ("x", "y", "d", "nx", "ny"),
    [
        (0.0, 1.0, 0.5, 0, 1),  # above the top
        (2.3, -1.0, 0.3, 1, 0),  # right of the face
        (-1.4, -1.0, 0.4, -1, 0),  # left
        (0.0, -3.2, 0.2, 0, -1),  # below
        (2.3, 0.9, 0.5, 0.6, 0.8),  # off the corner (2, 0.5): 3-4-5
        (0.0, 0.2, -0.3, 0, 1),  # inside, pushed out along the nearest face
    ],
)
def test_faces_and_corner_of_a_block(x, y, d, nx, ny):
    assert at(SILL, x, y, radius=1.0).tolist() == [pytest.approx([d, nx, ny], abs=1e-12)]


def test_a_centre_deep_inside_a_block_feels_nothing_and_behind_a_box_it_is_pushed_back():
    assert not len(at(SILL, 0.5, -1.2))
    box = Box("tank", (-2.0, 2.5), (-1.0, 3.0))
    assert at(box, 0.0, -4.0).tolist() == [pytest.approx([-3.0, 0.0, 1.0])]
    assert len(at(box, -2.0 + 0.5 * R, -1.0 + 0.5 * R)) == 2  # a corner has two faces


def test_points_of_an_arc_lie_at_their_distance_from_it():
    for inside in (True, False):
        wall = (circle((0.3, -0.2), 1.0, inside=inside),)
        angle = np.linspace(0, 2 * pi, 181)
        out = 1.0 + (-0.4 if inside else 0.4) * R
        found = contacts(wall, 0.3 + out * np.cos(angle), -0.2 + out * np.sin(angle))
        assert np.array_equal(found[:, 0], np.arange(181))  # one contact, at the ends of its pieces too
        assert found[:, 1] == pytest.approx(0.4 * R)
        sign = -1 if inside else 1
        np.testing.assert_allclose(found[:, 2:], sign * np.column_stack([np.cos(angle), np.sin(angle)]), atol=1e-12)


def test_the_foot_of_a_contact_is_its_place_along_the_chain():
    """Segment, arc to the left, segment, arc to the right: feet of points beside each place of the chain."""
    wall = (Chain(((0, 0), (1, 0), (2, 1), (2, 1.5), (3, 2.5)), (0.0, 1.0, 0.0, -1.0)),)
    flat = lay([(wall, False)])
    quarter = pi / 2
    places = {  # by arc length: point on the chain and normal there
        0.3: ((0.3, 0.0), (0.0, 1.0)),
        1.0 + 0.2: ((1.0 + sin(0.2), 1.0 - cos(0.2)), (-sin(0.2), cos(0.2))),
        1.0 + quarter + 0.1: ((2.0, 1.1), (-1.0, 0.0)),
        1.5 + quarter + 0.7: ((3.0 - cos(0.7), 1.5 + sin(0.7)), (-cos(0.7), sin(0.7))),
    }
    found, which = np.empty((MOST, 4)), np.empty(MOST, np.int64)
    for sigma, ((x, y), (nx, ny)) in places.items():
        for away in (0.9 * R, -0.5 * R):
            px, py = x + away * nx, y + away * ny
            near = np.arange(len(flat.codes))
            assert touching(flat, 0, near, (px, py, R), found, which) == 1
            assert foot_at(flat, which[0], px, py) == pytest.approx(sigma, abs=1e-14)
    # beyond the ends of a face its foot is the end
    assert foot_at(flat, 0, 1.4, 0.1) == 1.0 and foot_at(flat, 0, -0.2, 0.1) == 0.0


def test_the_sides_of_a_sheet_push_away_from_it():
    sheet = (Chain(((0.0, 0.0), (0.0, 1.0)), closed=True),)
    assert at(sheet, 0.3 * R, 0.5).tolist() == [pytest.approx([0.3 * R, 1.0, 0.0])]
    assert at(sheet, -0.3 * R, 0.5).tolist() == [pytest.approx([0.3 * R, -1.0, 0.0])]
    ((gap, nx, ny),) = at(sheet, 0.3 * R, 1.0 + 0.4 * R)
    assert (gap, nx, ny) == pytest.approx((0.5 * R, 0.6, 0.8)) and acos(ny) > 0


def test_two_walls_that_meet_flush_are_found():
    """Each pushes on its own, so that a disc over the joint feels twice the force; not at a corner, nor a step."""
    left, step = Block("left", (-1.0, 0.0), (-1.0, 0.0)), Block("step", (0.0, 1.0), (-1.0, 0.5))
    assert flush(left.faces, Block("right", (0.0, 1.0), (-1.0, 0.0)).faces) == (0.0, 0.0)
    assert flush(left.faces, step.faces) is None  # their undersides are no matter
    assert flush(left.faces, Block("apart", (0.1, 1.0), (-1.0, 0.0)).faces) is None
    assert flush(left.faces, Plane("ground", "y", 0.0, "above").faces) is None
