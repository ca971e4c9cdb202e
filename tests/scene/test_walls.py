# SPDX-License-Identifier: GPL-2.0-or-later
"""walls.py: what a signed distance must be, whatever the wall."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lammps_jump.scene import chains
from lammps_jump.scene.chains import Chain, circle, lay
from lammps_jump.scene.walls import Block, Box, Plane

COORDINATE = st.floats(-5.0, 5.0)
WALLS = (
    Plane("floor", "y", 0.3, "above"),
    Plane("ceiling", "y", 0.3, "below"),
    Plane("left", "x", -1.2, "above"),
    Plane("right", "x", -1.2, "below"),
    Block("sill", (-1.0, 2.0), (-3.0, 0.5)),
    Block("plate", (0.0, 0.01), (-1.0, 1.0)),
    Box("tank", (-2.0, 2.5), (-1.0, 3.0)),
)
ANY_WALL = st.sampled_from(WALLS)


def distance(wall, x, y):
    return float(wall.distance(np.array([x]), np.array([y]))[0])


@given(wall=ANY_WALL, a=st.tuples(COORDINATE, COORDINATE), b=st.tuples(COORDINATE, COORDINATE))
def test_distance_is_one_lipschitz(wall, a, b):
    moved = np.hypot(a[0] - b[0], a[1] - b[1])
    assert abs(distance(wall, *a) - distance(wall, *b)) <= moved + 1e-12  # round-off of values up to 10


@given(x=COORDINATE, y=COORDINATE, corner=st.tuples(COORDINATE, COORDINATE), w=st.floats(0.01, 4), h=st.floats(0.01, 4))
def test_block_equals_the_nearest_point_by_brute_force(x, y, corner, w, h):
    block = Block("b", (corner[0], corner[0] + w), (corner[1], corner[1] + h))
    s = np.linspace(0.0, 1.0, 2001)
    (x0, x1), (y0, y1) = block.x, block.y
    edge_x = np.concatenate([x0 + s * w, x0 + s * w, np.full_like(s, x0), np.full_like(s, x1)])
    edge_y = np.concatenate([np.full_like(s, y0), np.full_like(s, y1), y0 + s * h, y0 + s * h])
    nearest = np.hypot(edge_x - x, edge_y - y).min()
    inside = x0 < x < x1 and y0 < y < y1
    # sampled edges: the nearest sample is at most half a spacing (w or h over 4000) along the edge
    assert distance(block, x, y) == pytest.approx(-nearest if inside else nearest, abs=max(w, h) / 4000 + 1e-12)


@given(x=COORDINATE, y=COORDINATE)
def test_a_box_is_open_inside(x, y):
    box = WALLS[6]
    inside = box.x[0] < x < box.x[1] and box.y[0] < y < box.y[1]
    assert (distance(box, x, y) > 0) == inside
    if inside:
        assert distance(box, x, y) == min(x - box.x[0], box.x[1] - x, y - box.y[0], box.y[1] - y)


@given(x=COORDINATE, y=COORDINATE)
def test_opposite_sides_of_a_plane_mirror_each_other(x, y):
    assert distance(WALLS[0], x, y) == -distance(WALLS[1], x, y)
    assert distance(WALLS[2], x, y) == -distance(WALLS[3], x, y)


@pytest.mark.parametrize("wall", WALLS, ids=lambda wall: wall.name)
def test_shapes_and_integers_are_kept(wall):
    x, y = np.zeros((3, 4)), np.ones((3, 4), dtype=int)
    assert wall.distance(x, y).shape == (3, 4)
    assert all(part.shape == (3, 4) and part.dtype == float for solid in wall.grounds(x) for part in solid)


@pytest.mark.parametrize("wall", WALLS, ids=lambda wall: wall.name)
def test_walls_cannot_be_changed(wall):
    with pytest.raises(AttributeError):
        wall.name = "other"


ENDLESS = (-np.inf, np.inf)


@pytest.mark.parametrize(
    ("wall", "extent", "room", "moment_point", "grounds"),
    [
        (WALLS[0], (ENDLESS, (0.3, 0.3)), ENDLESS, (0.0, 0.3), [(-np.inf, 0.3)]),
        (WALLS[1], (ENDLESS, (0.3, 0.3)), ENDLESS, (0.0, 0.3), []),
        (WALLS[2], ((-1.2, -1.2), ENDLESS), (-1.2, np.inf), (-1.2, 0.0), []),
        (WALLS[3], ((-1.2, -1.2), ENDLESS), (-np.inf, -1.2), (-1.2, 0.0), []),
        (WALLS[4], ((-1.0, 2.0), (-3.0, 0.5)), ENDLESS, (-1.0, -3.0), [(-3.0, 0.5)]),
        (WALLS[6], ((-2.0, 2.5), (-1.0, 3.0)), (-2.0, 2.5), (-2.0, -1.0), [(-np.inf, -1.0)]),
    ],
    ids=lambda value: getattr(value, "name", ""),
)
def test_what_a_wall_answers(wall, extent, room, moment_point, grounds):
    assert wall.extent == extent and wall.room("x") == room
    assert wall.finite == bool(np.isfinite(extent).all())
    assert wall.moment_point == moment_point
    assert [(float(low[0]), float(top[0])) for low, top in wall.grounds(np.array([0.5]))] == grounds
    aside = [top for _, top in wall.grounds(np.array([4.0]))]
    assert all(np.isnan(top[0]) == wall.finite for top in aside)


@pytest.mark.parametrize("wall", WALLS, ids=lambda wall: wall.name)
@pytest.mark.parametrize("view", [((-4.0, 4.0), (-4.0, 4.0)), ((6.0, 7.0), (6.0, 7.0))], ids=["around", "aside"])
def test_outlines_hold_the_solid_and_no_disc(wall, view):
    (polygon,) = wall.outline(*view)
    middle = polygon.mean(axis=0)
    outside = wall.distance(*middle)
    assert outside > 0 if wall.hollow else outside <= 0
    assert np.allclose(wall.distance(*polygon.T).max(), 0.0)


def heights(faces, x):
    """Heights at which one upright line meets faces: (height, whether the face looks up), face by face."""
    for code, row in zip(faces.codes, faces.shape, strict=True):
        if code[chains.KIND] == chains.ARC:
            rho, out = abs(row[chains.RADIUS]), x - row[chains.CX]
            for sign in (1, -1) if abs(out) <= rho else ():
                y = row[chains.CY] + sign * np.sqrt(rho * rho - out * out)
                begin = row[chains.TX0] * (x - row[chains.X0]) + row[chains.TY0] * (y - row[chains.Y0])
                end = row[chains.TX1] * (x - row[chains.X1]) + row[chains.TY1] * (y - row[chains.Y1])
                if begin >= 0 >= end:
                    yield y, (sign > 0) == (row[chains.RADIUS] < 0)
        elif abs(row[chains.TX0]) > 1e-12:
            inside = min(row[chains.X0], row[chains.X1]) <= x <= max(row[chains.X0], row[chains.X1])
            if inside or code[chains.AT_START] == chains.ENDLESS:
                slope = row[chains.TY0] / row[chains.TX0]
                yield row[chains.Y0] + (x - row[chains.X0]) * slope, row[chains.TX0] > 0


def solids_over(faces, x):
    """Solids over one x, by brute force: (underside, top), upwards."""
    met = list(heights(faces, x))
    tops, bottoms, below = sorted(y for y, up in met if up), [y for y, up in met if not up], -np.inf
    for top in tops:
        yield max([y for y in bottoms if below <= y <= top], default=-np.inf), top
        below = top


BEDS = {
    "rough": (Chain(tuple((0.01 * i, 0.03 * np.sin(7.0 * i)) for i in range(300))),),
    "circles": tuple(circle((0.4 * i, 0.1 * i), 0.3, inside=i % 2 == 1) for i in range(8)),
    "overhang": (Chain(((0, 0), (2, 0), (2, 1), (1, 0.6), (0.5, 2), (3, 2), (3, -1), (0, -1)), (), True),),
    "endless slope": (Chain(((0.0, 0.0), (1.0, 0.3)), endless=True),),
    "nothing": (Chain(((0.0, 0.0), (0.0, 1.0))),),
}


@pytest.mark.parametrize("bed", BEDS)
def test_grounds_are_those_of_every_face_at_every_place(bed):
    faces = lay([(BEDS[bed], False)])
    x = np.append(np.random.default_rng(3).uniform(-1.0, 4.0, 300), [0.0, 0.5, 1.0, 2.0, 3.0])
    found = chains.grounds(faces, x)
    for k, place in enumerate(x):
        pairs = [(under[k], top[k]) for under, top in found if not np.isnan(top[k])]
        assert pairs == list(solids_over(faces, place))
