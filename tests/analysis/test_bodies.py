# SPDX-License-Identifier: GPL-2.0-or-later
"""What is measured of bodies: ways and turns, rest, sliding and tipping, what floats, by histories made up."""

from dataclasses import replace
from math import cos, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from made_up import disc_frame, examples, flow_context

from lammps_jump.analysis.devices import bodies
from lammps_jump.dump.walls import BodyHistory
from lammps_jump.physics.bodies import area_below, depth_of_area, section_of_polygon
from lammps_jump.scene import MovingWall
from lammps_jump.scene.bodies import Free
from lammps_jump.scene.motion import Motion
from lammps_jump.scene.walls import Block

BLOCK = Block("box", (4.0, 6.0), (1.0, 2.0))
TIME = np.linspace(0.0, 10.0, 201)


def body(weight=1000.0, **more) -> MovingWall:
    free = Free(mass=weight / 9.81, inertia=50.0, centre=(5.0, 1.5), weight=(0.0, -weight), **more)
    return MovingWall(BLOCK, Motion(np.inf, free, free.point, 0.0, 0, 1e-3))


def history(x=5.0, y=1.5, angle=0.0, fx=0.0, fy=0.0) -> BodyHistory:
    zero = np.zeros_like(TIME)
    return BodyHistory(TIME, *(zero + value for value in (x, y, angle)), zero, zero, zero, fx + zero, fy + zero, zero)


def found(one, rows, beside=None) -> bodies.BodyResult:
    flow = flow_context(walls=(), domain=((0, 10), (0, 8)), x_range=(0, 10), diameter=0.2)
    return bodies._found(flow, one, rows, np.empty((0, 4)) if beside is None else beside)


def test_a_body_that_slides_and_stops_rests_from_then_on():
    way = np.clip(TIME - 2.0, 0.0, 3.0) * 0.5
    result = found(body(), history(x=5.0 + way, fx=np.where(TIME <= 2.0, 0.0, 100.0)))
    assert result.largest_displacement == pytest.approx(1.5) and result.end_x == pytest.approx(6.5)
    assert result.slides_at == pytest.approx(2.05) and np.isnan(result.tips_at)  # 1 % of 2 m
    assert result.rest and result.rest_since == pytest.approx(5.0)
    assert result.impulse_x == pytest.approx(100.0 * 8.0) and result.peak_force == 100.0
    assert not result.floats and np.isnan(result.draught)


def test_a_body_that_turns_about_its_corner_tips():
    angle = np.clip(TIME - 4.0, 0.0, 1.0) * -0.5  # clockwise, about the corner on the right at (6, 1)
    x = 6.0 - np.cos(angle) - 0.5 * -np.sin(angle) * 1.0
    x = 6.0 + (-1.0 * np.cos(angle) - 0.5 * np.sin(angle))
    y = 1.0 + (-1.0 * np.sin(angle) + 0.5 * np.cos(angle))
    result = found(body(), history(x, y, angle))
    assert result.tips_at == pytest.approx(4.05) and result.largest_turn == pytest.approx(np.degrees(0.5))
    assert np.isnan(result.slides_at) or result.slides_at > result.tips_at


def test_a_body_that_falls_neither_slides_nor_tips():
    fall = np.minimum(4.905 * TIME**2, 1.0)
    result = found(body(), history(x=5.0 + 0.5 * TIME, y=1.5 - fall, angle=0.1 * TIME))
    assert np.isnan(result.slides_at) and np.isnan(result.tips_at) and not result.rest


def test_a_body_that_is_held_to_the_end_does_not_rest():
    assert not found(body(begin=20.0), history()).rest
    hinged = found(body(hinge=(5.0, 2.0)), history(angle=0.3 * np.sin(TIME)))
    assert np.isnan(hinged.slides_at) and not hinged.rest


@examples(40)
@given(st.floats(-3, 3), st.floats(0.3, 3), st.floats(0.3, 3), st.floats(0.01, 0.99))
def test_the_depth_of_an_area_is_that_of_the_polygon(angle, wide, high, share):
    corners = np.array([(-wide, -high), (wide, -high), (wide, high), (-wide, high)]) @ np.array(
        [[cos(angle), sin(angle)], [-sin(angle), cos(angle)]]
    )
    area = section_of_polygon(corners).area
    depth = depth_of_area(corners, share * area)
    assert area_below(corners, corners[:, 1].min() + depth) == pytest.approx(share * area, rel=1e-9)
    assert np.isnan(depth_of_area(corners, 1.01 * area)) and np.isnan(depth_of_area(corners, 0.0))


def crystal(top: float, d: float = 0.2):
    """A hexagonal packing between x = 0 and 10 up to a height."""
    rows = np.arange(0.5 * d, top, d * np.sqrt(0.75))
    x, y = np.meshgrid(np.arange(0.5 * d, 10, d), rows)
    x = x + 0.5 * d * (np.arange(len(rows)) % 2)[:, None]
    return x.ravel(), y.ravel()


@pytest.mark.parametrize("top", [2.4, 2.5, 3.0])
def test_level_and_density_beside_a_body(top):
    """The level of the mass, in a crystal whose layers are a sixth of the draught: to a tenth of a diameter."""
    x, y = crystal(top)
    flow = flow_context(walls=(), domain=((0, 10), (0, 8)), x_range=(0, 10), diameter=0.2)
    beside = bodies.around(disc_frame(x, y, box=[[0, 10], [0, 8]]), flow, BLOCK)
    density = flow.scene.mass / (0.2**2 * np.sqrt(0.75))
    assert beside.density == pytest.approx(density, rel=0.01)
    level = len(np.unique(y)) * 0.2 * np.sqrt(0.75) + (0.1 - 0.1 * np.sqrt(0.75))
    assert beside.level == pytest.approx(level, abs=0.02) and beside.keel == 1.0


def test_too_few_discs_have_no_level():
    flow = flow_context(walls=(), domain=((0, 10), (0, 8)), x_range=(0, 10), diameter=0.2)
    for x, y in ((np.empty(0), np.empty(0)), crystal(0.6)):
        assert np.isnan(bodies.around(disc_frame(x, y, box=[[0, 10], [0, 8]]), flow, BLOCK)).all()
    wide = replace(BLOCK, x=(0.5, 9.5))
    assert np.isnan(bodies.around(disc_frame(*crystal(3.0), box=[[0, 10], [0, 8]]), flow, wide)).all()


def test_what_floats_has_a_draught_and_that_of_its_weight():
    rng = np.random.default_rng(1)
    beside = np.column_stack([TIME, 0 * TIME + 1100.0, 1.5 + 0.01 * rng.standard_normal(len(TIME)), 0 * TIME + 1.0])
    weight = 1100.0 * 9.81 * 2.0 * 0.48
    result = found(body(weight), history(fy=weight), beside)
    assert result.floats and result.draught == pytest.approx(0.5, abs=0.01) and 0 < result.draught_interval < 0.01
    assert result.draught_by_weight == pytest.approx(0.48, rel=1e-3) and result.heel == 0.0
    assert not found(body(2 * weight), history(fy=weight), beside).floats  # a wall carries the rest
    assert np.isnan(found(body(4 * weight), history(fy=4 * weight), beside).draught_by_weight)  # it would sink
    assert not found(body(weight), history(fy=weight), beside[:5]).floats  # too few frames


def test_bodies_without_a_file_have_a_reason():
    (text,) = bodies.notes({"box": bodies.BodyResult(reason="bodies.csv has no row of it")})
    assert text == "Nothing is known of the body box: bodies.csv has no row of it."
    assert bodies.notes(None) == []
