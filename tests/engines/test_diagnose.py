# SPDX-License-Identifier: GPL-2.0-or-later
"""What is said of a run that LAMMPS has ended: the disc and the wall that overlap, not two discs that do not."""

import numpy as np
import pytest
from made_up import BOX

import lammps_jump as lj
from lammps_jump.engines.lammps.outputs import explain
from lammps_jump.files import POSES, POSES_HEADER

ERROR = "ERROR: Fix halt condition for fix-id guard_overlap met on step {}"


def said(tmp_path, step, places):
    walls = [*BOX["walls"], {"name": "step", "kind": "block", "x": [-0.5, 0.5], "y": [-0.5, 0.3]}]
    scene = lj.load_case(
        {**BOX, "walls": walls, "initial": [{**BOX["initial"][0], "origin": [0.7, 0.5], "nx": 3, "ny": 3}]}
    ).scene()
    (tmp_path / "log.lammps").write_text("")
    places = np.array([[*place, 0.0] for place in places])
    return explain(ERROR.format(step), scene, tmp_path, (np.arange(len(places)) + 1, places))


@pytest.mark.parametrize(
    ("places", "culprit"),
    [
        ([(1.0, 1.0), (1.19, 1.0), (1.0, 0.04)], "disc 3 and wall 'box' near (1, 0.04) by 0.06 m"),
        ([(1.0, 1.0), (1.19, 1.0), (0.4, 0.35)], "disc 3 and wall 'step' near (0.4, 0.35) by 0.05 m"),
        ([(1.0, 1.0), (1.12, 1.0), (1.0, 0.04)], "discs 1 and 2 near (1, 1) by 0.08 m"),
        # a centre inside a block is pushed out, from one radius deep at most
        ([(1.0, 1.0), (1.19, 1.0), (0.2, 0.25)], "disc 3 and wall 'step' near (0.2, 0.25) by 0.15 m"),
        ([(1.0, 1.0), (1.19, 1.0), (0.2, 0.15)], "discs 1 and 2 near (1, 1) by 0.01 m"),
    ],
)
def test_the_deepest_overlap_is_named(tmp_path, places, culprit):
    text = said(tmp_path, 100, places)
    assert "overlap too deeply at t = " in text and f": {culprit}, allowed is 2 d/n" in text


def test_a_wall_that_discs_have_pushed_is_where_they_have_pushed_it(tmp_path):
    lid = {"name": "lid", "kind": "block", "x": [0.5, 1.5], "y": [2.2, 2.4],
           "motion": {"kind": "load", "mass": 1, "force": [0, -1]}}  # fmt: skip
    scene = lj.load_case({**BOX, "walls": [*BOX["walls"], lid]}).scene()
    (tmp_path / "log.lammps").write_text("")
    (tmp_path / POSES).write_text(f"{POSES_HEADER}\n0,lid,0,0,0\n{scene.time(100)},lid,0,-0.5,0\n")
    state = np.array([1]), np.array([[1.0, 1.65, 0.0]])
    text = explain(ERROR.format(100), scene, tmp_path, state)
    assert "disc 1 and wall 'lid' near (1, 1.65) by 0.05 m" in text
