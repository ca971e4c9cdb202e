# SPDX-License-Identifier: GPL-2.0-or-later
"""The table of joints in docs/walls.md is what the native engine gives."""

from __future__ import annotations

import re
from dataclasses import replace
from math import cos, hypot, radians, sin, sqrt
from pathlib import Path

import pytest
from single_disc import R, one_disc

from lammps_jump.engines.native import NativeSimulation
from lammps_jump.scene import Chain

PAGE = Path(__file__).parents[2] / "docs" / "walls.md"
STARTS = 8
JOINTS = [(0, 0.01), (0.1, 0.01), (1, 0.01), (5, 0.01), (20, 0.05), (-20, 0.01)]
"""Turn, degrees, and depth at rest, d."""


def crossing(degrees, delta, fraction):
    """Largest error of the energy, of m v^2/2, and largest force, of m g, of a disc that crosses a joint at v = 1."""
    turn, error, force = radians(degrees), 0.0, 0.0
    chain = Chain(((-9.0, 0.0), (0.0, 0.0), (9 * cos(turn), 9 * sin(turn))))
    for k in range(STARTS):  # the step meets the joint at different places
        scene = one_disc((-0.5 - k * 0.0137, R - delta), (1.0, 0.0), chain, fraction=fraction,
                         largest_overlap=sqrt(delta))  # fmt: skip
        simulation = NativeSimulation(replace(scene, probes=("wall",), probe_steps=1))
        before = simulation.energy().total
        simulation.run(round((1.5 if degrees >= 0 else 2.5) / scene.time_step))
        error = max(error, abs(simulation.energy().total - before) / 0.5)
        force = max(force, *(hypot(*row[2:4]) for row in simulation.forces))
    return error, force


def test_the_page_has_every_joint():
    assert [(row[0], row[1]) for row in rows()] == JOINTS


def rows():
    """Rows of the table: turn, depth, errors at f = 0.05 and 0.005, force."""
    found = re.findall(r"^\| (-?[\d.]+)° \| ([\d.]+) d \| (\S+) \| (\S+) \| (\S+) \|$", PAGE.read_text(), re.MULTILINE)
    return [tuple(map(float, row)) for row in found]


@pytest.mark.long
def test_the_numbers_of_the_page_are_measured():
    for degrees, delta, coarse, fine, force in rows():
        found = crossing(degrees, delta, 0.05), crossing(degrees, delta, 0.005)
        for said, (error, largest) in zip((coarse, fine), found, strict=True):
            # two digits are written; round-off of a smooth crossing differs with the machine
            assert error < 1e-12 if said < 1e-12 else error == pytest.approx(said, rel=0.1), degrees
            assert largest == pytest.approx(force, abs=0.01), degrees


if __name__ == "__main__":
    for degrees, delta in JOINTS:
        (coarse, force), (fine, _) = crossing(degrees, delta, 0.05), crossing(degrees, delta, 0.005)
        print(f"| {degrees:g}° | {delta:g} d | {coarse:.1e} | {fine:.1e} | {force:.2f} |")
