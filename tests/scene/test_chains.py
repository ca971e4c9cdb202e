# SPDX-License-Identifier: GPL-2.0-or-later
"""Chains of faces against circles and squares."""

from __future__ import annotations

from math import atan2, cos, pi, sin

import numpy as np
import pytest

from lammps_jump.scene.chains import LENGTH, PHI, SWEEP, X0, Y0, Chain, circle, faces_of_chain, lay, moved
from lammps_jump.scene.shapes import Path, common

SQUARE = Chain(((0.0, 0.0), (0.0, 2.0), (2.0, 2.0), (2.0, 0.0)), closed=True)
"""A solid: clockwise."""


@pytest.mark.parametrize(("turn", "pieces"), [(0.4 * pi, 1), (0.5 * pi, 1), (0.6 * pi, 2), (0.99 * pi, 2)])
def test_an_arc_comes_in_pieces_of_at_most_a_quarter_turn(turn, pieces):
    chain = Chain(((1.0, 0.0), (cos(turn), sin(turn))), bends=(1.0,))
    faces = faces_of_chain(chain)
    assert len(faces) == pieces and all(abs(face.sweep) <= 0.5 * pi * (1 + 1e-9) for face in faces)
    assert sum(face.length for face in faces) == pytest.approx(turn, rel=1e-12)


def test_the_angle_of_a_wall_goes_on_from_face_to_face():
    faces = lay([((SQUARE,), False), ((circle((3.0, 1.0), 0.5, inside=True),), False)])
    square, ring = faces.shape[:4], faces.shape[4:]
    assert square[:, PHI] - square[0, PHI] == pytest.approx(-0.5 * pi * np.arange(4), abs=1e-12)
    assert ring[:, PHI] - ring[0, PHI] == pytest.approx(0.5 * pi * np.arange(4), abs=1e-12)
    assert ring[:, SWEEP].sum() == pytest.approx(2 * pi) and ring[:, LENGTH].sum() == pytest.approx(pi)


def test_a_wall_that_moves_turns_about_its_point():
    (dx, dy, angle), (ax, ay) = (0.3, -0.2, 0.7), (1.0, 0.5)
    shape = moved(lay([((SQUARE,), False)]), (dx, dy, angle), (ax, ay)).shape
    for (x, y), row in zip(SQUARE.points, shape, strict=True):
        far, towards = np.hypot(x - ax, y - ay), atan2(y - ay, x - ax) + angle
        expected = ax + dx + far * cos(towards), ay + dy + far * sin(towards)
        assert (row[X0], row[Y0]) == pytest.approx(expected, abs=1e-12)


def test_the_area_of_half_a_disc():
    half = Path(((-1.0, 0.0), (1.0, 0.0)), (0.0, 1.0), True)
    assert half.area == pytest.approx(0.5 * pi, rel=1e-12)
    assert half.reversed().area == pytest.approx(-0.5 * pi, rel=1e-12)


def test_circles_of_two_sizes_meet_where_both_are():
    one, two = (faces_of_chain(circle((x, 0.0), r, inside=False)) for x, r in ((0.0, 1.0), (1.0, 2**0.5)))
    points = {(round(x, 9), round(y, 9)) for a in one for b in two for x, y in common(a, b, 1e-9)}
    assert {(x + 0.0, y) for x, y in points} == {(0.0, 1.0), (0.0, -1.0)}
