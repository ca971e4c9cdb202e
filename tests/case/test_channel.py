# SPDX-License-Identifier: GPL-2.0-or-later
"""Case fields of periodic channels and rough beds: what they become, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from made_up import INPUTS

from lammps_jump.case import load_case
from lammps_jump.case.beds import RoughBed
from lammps_jump.errors import CaseError

NAME = "inclined_flow"


def case_scene(name, *changes):
    return load_case(INPUTS / f"{name}.yaml", list(changes)).scene()


def test_the_disc_on_the_seam_stands_once():
    def bed_from(x):
        fields = {"kind": "rough", "name": "bed", "from": [x, 0.0], "to": [x + 0.3, 0.0], "diameter": 0.01}
        return RoughBed.model_validate(fields)

    bed = bed_from(0.0)
    assert len(bed.places(None)) == 31 and len(bed.places((0.0, 0.3))) == 30
    shifted = bed_from(0.1).places((0.0, 0.3))
    assert len(shifted) == 30 and shifted[:, 0].min() == pytest.approx(0.0, abs=1e-12) and shifted[:, 0].max() < 0.3
    assert np.diff(np.sort(shifted[:, 0])) == pytest.approx(0.01)


def test_fixed_discs_follow_those_of_the_start():
    scene = case_scene(NAME)
    assert scene.period == pytest.approx(0.3) and scene.fixed is not None
    assert (scene.fixed.last, scene.fixed.count) == (len(scene.positions), 30)
    fixed = scene.fixed.holds(np.arange(1, len(scene.positions) + 1))
    assert not scene.velocities[fixed].any() and not scene.positions[fixed, 1].any()
    assert set(scene.diameters(np.arange(scene.fixed.first, scene.fixed.last + 1))) == {0.01}
    assert np.allclose(scene.gravity, (9.81 * np.sin(np.radians(20)), -9.81 * np.cos(np.radians(20))))
    (bed,) = scene.permanent
    assert bed.extent[1] == (0.005, 0.005)


def test_equal_discs_on_a_rough_bed_of_others():
    """The bed does not change the size of the discs that flow, nor their step."""
    scene = case_scene(NAME, "discs.sizes=null", "walls.0.diameter=0.005")
    assert scene.diameters([1, 2]).tolist() == [0.01, 0.01] and scene.smallest == 0.005
    smooth = case_scene(NAME, "discs.sizes=null", "walls=[{kind: plane, name: bed, axis: y, at: 0, side: above}]")
    assert scene.time_step == smooth.time_step


REFUSED = {
    "inflow": (["inflow={kind: pour, x: [0.1, 0.2], y: [0.3, 0.35], count: 5}"], "inflow: is not there"),
    "outflow along x": (["outflow=[{x_beyond: 0.2}]"], r"outflow\[0\]: is not there along x"),
    "jump": (["analysis.jump=true"], "analysis.jump: is not there"),
    "front": (["analysis.front=true"], "analysis.front: is not there"),
    "energy": (["analysis.energy=true"], "analysis.energy: is not there"),
    "gate": (["initial.0.gate=true", "initial.0.settle=0.1"], r"initial\[0\].gate: a column in a periodic channel"),
    "short": (
        ["domain.x=[0, 0.05]", "walls.0.to=[0.05, 0]", "initial.0.x=[0, 0.05]", "analysis.layers.x=[0, 0.05]"],
        "domain.x: a periodic channel of 0.05 m is too short .* allowed is 0.06 m",
    ),
    "wall at one end": (
        ["walls.0={kind: block, name: bed, x: [-1, 0.1], y: [-1, 0]}"],
        r"walls\[0\]: wall 'bed' is not the same at both ends",
    ),
    "wall that slopes over the seam": (
        ["walls.0={kind: line, name: bed, points: [[-1, -0.01], [1, 0.01]]}"],
        r"walls\[0\]: wall 'bed' is not the same at both ends",
    ),
    "wall that comes to the seam": (
        [
            "walls.0={kind: block, name: bed, x: [0.1, 0.11], y: [-0.02, 0], "
            "motion: {kind: translate, velocity: [0.1, 0]}}"
        ],
        r"walls\[0\].motion: wall 'bed' comes to the seam",
    ),
    "overlap across the seam": (
        ["initial.0={kind: list, positions: [[0.001, 0.1], [0.299, 0.1]]}"],
        "discs 1 .* and 2 .* overlap",
    ),
    "disc in the bed": (["initial.0={kind: list, positions: [[0.1, 0.004]]}"], "initial: discs 1 .* overlap"),
    "bed upon itself": (
        ["walls.0.to=[0.305, 0]", "walls.0.spacing=1.3"],
        "walls: discs .* overlap by",
    ),
    "point": (["walls.0.to=[0, 0]"], "from and to are one point"),
    "spacing": (["walls.0.spacing=0.9"], "walls.0.*spacing.*0.9"),
}  # fmt: skip


@pytest.mark.parametrize("what", REFUSED)
def test_refused(what):
    changes, message = REFUSED[what]
    with pytest.raises(CaseError, match=message):
        case_scene(NAME, *changes)


@pytest.mark.parametrize(
    "wall",
    [
        "{kind: plane, name: bed, axis: y, at: 0, side: above}",
        "{kind: block, name: bed, x: [-1, 1], y: [-1, 0]}",
        "{kind: line, name: bed, points: [[-1, 0], [0.1, 0], [0.15, 0.005], [0.2, 0], [1, 0]]}",
        "{kind: circle, name: bed, centre: [0.15, 0], radius: 0.01}",
    ],
)
def test_walls_that_a_channel_may_have(wall):
    assert case_scene(NAME, f"walls.0={wall}").period
