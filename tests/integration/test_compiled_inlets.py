# SPDX-License-Identifier: GPL-2.0-or-later
"""`fix jump/inlet` of the plugin: what ``fix deposit`` of LAMMPS inserts, bit for bit."""

from __future__ import annotations

import numpy as np
import pytest
from plugin_scripts import CLOUD, DIAMETER, FLOOR, Run, cloud, scene, start, styles, traffic

from lammps_jump.scene.scene import InletRow, Outlet
from lammps_jump.scene.walls import Block, Plane
from lammps_jump.script.plugin import inlets

pytestmark = pytest.mark.lammps

WALLS = (Block("ground", (-2.5, 1.2), (-3.0, 0.1)), Plane("left", "x", 0.0, "above"))


def crowded(**more):
    """Rows that shoot at a cloud: two are due before their last disc is out of the way, and come at the same steps."""
    rows = (
        InletRow(2.5, 1.0, -12.0, 0.0, 1, 60, 0.999 * DIAMETER),
        InletRow(2.5, 1.25, -12.0, 1.0, 1, 60, 0.999 * DIAMETER),
        InletRow(2.5, 1.5, -12.0, 0.0, 1, 150, 0.999 * DIAMETER),
    )
    return scene(*cloud(4, 9, 9), WALLS, friction=0.2, inlets=rows, outlets=(Outlet("y", 0.15, "below", 50),), **more)


def lines_of(case, plugin, folder):
    """The case with the inlets of the plugin."""
    outlets = [line for line in traffic(case, folder) if " out" in line]
    return [*start(case), *styles(case, plugin), *outlets, *(line.replace(" &\n", " ") for line in inlets(case))]


def test_the_discs_are_those_of_fix_deposit_to_the_last_bit(lammps, plugin, tmp_path):
    case = crowded()
    names = ("id", "x", "v", "radius", "rmass")
    more = ["atom_modify sort 70 0.3", "run 1000"]
    with Run(lammps, [*start(case), *styles(case, plugin), *traffic(case, tmp_path), *more]) as run:
        expected = [run.discs(name) for name in names]
    with Run(lammps, [*lines_of(case, plugin, tmp_path), *more]) as run:
        found = [run.discs(name) for name in names]
        assert run.engine.get_natoms() == len(found[0])
    asked = sum(1000 // row.every_steps + 1 for row in case.inlets)
    came = found[0].max() - 81
    assert 6 < came < asked and len(found[0]) < found[0].max()  # some waited, some have gone
    for name, one, two in zip(names, expected, found, strict=True):
        assert np.array_equal(one, two), name


def test_a_row_lets_in_as_many_as_it_may_over_a_restart(lammps, plugin, tmp_path):
    row = InletRow(5.0, 5.0, 12.0, 0.0, 10, 100, 0.999 * DIAMETER, limit=3)
    case = scene(*CLOUD, FLOOR, inlets=(row,))
    inlet = [line.replace(" &\n", " ") for line in inlets(case)]
    plug, *rest = styles(case, plugin)
    with Run(lammps, [*start(case), plug, *rest, *inlet]) as run:
        assert [run.do(f"run {n}").engine.get_natoms() - 144 for n in (9, 1, 150)] == [0, 1, 2]
        run.do(f"write_restart {tmp_path / 'half'}")
        assert run.do("run 500").engine.get_natoms() == 147
    lines = [plug, "newton off", f"read_restart {tmp_path / 'half'}", "comm_modify vel yes", "neighbor 0.06 bin"]
    with Run(lammps, [*lines, f"timestep {case.time_step!r}", *rest, *inlet]) as run:
        assert [run.do(f"run {n}").engine.get_natoms() for n in (49, 1, 500)] == [146, 147, 147]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("0.2 40", "needs DIAMETER, MASS and rows"),
        ("0.2 40 row 1 30 0 0.2 0 0 1", "needs DIAMETER, MASS and rows"),
        ("0.2 40 line 1 30 0 0.2 0 0 1 0", "'line' stands where a row begins"),
        ("0.2 40 row 1 0 0 0.2 0 0 1 0", "EVERY is 1 or more"),
        ("0.2 40 row 1 30 -1 0.2 0 0 1 0", "MOST and NEAR are 0 or more"),
        ("0.2 40 row 1 30 0 0.2 99 0 1 0", r"the row at \(99, 0\) is outside the box"),
        ("-0.2 40 row 1 30 0 0.2 0 0 1 0", "DIAMETER and MASS must be above 0"),
    ],
)
def test_bad_rows_are_refused(lammps, plugin, words, message):
    case = scene(*cloud(2, 3, 3), FLOOR)
    with Run(lammps, [*start(case), *styles(case, plugin)]) as run, pytest.raises(Exception, match=message):
        run.do(f"fix in all jump/inlet {words}")
