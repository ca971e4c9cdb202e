# SPDX-License-Identifier: GPL-2.0-or-later
"""`fix jump/inlet` of the plugin: what ``fix deposit`` of LAMMPS inserts, bit for bit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from plugin_scripts import CLOUD, DIAMETER, FLOOR, Run, cloud, scene, start, styles, traffic

from lammps_jump import read_dump
from lammps_jump.case import parse_case
from lammps_jump.engines import Setting
from lammps_jump.engines import run as run_scene
from lammps_jump.scene.scene import InletRow, Outlet
from lammps_jump.scene.walls import Block, Plane
from lammps_jump.script.plugin import TURNS_FILE, inlets, turns_text

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
    return [
        *start(case),
        *styles(case, plugin, folder),
        *outlets,
        *(line.replace(" &\n", " ") for line in inlets(case)),
    ]


def test_the_discs_are_those_of_fix_deposit_to_the_last_bit(lammps, plugin, tmp_path):
    case = crowded()
    names = ("id", "x", "v", "radius", "rmass")
    more = ["atom_modify sort 70 0.3", "run 1000"]
    with Run(lammps, [*start(case), *styles(case, plugin, tmp_path), *traffic(case, tmp_path), *more]) as run:
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
    plug, *rest = styles(case, plugin, tmp_path)
    with Run(lammps, [*start(case), plug, *rest, *inlet]) as run:
        assert [run.do(f"run {n}").engine.get_natoms() - 144 for n in (9, 1, 150)] == [0, 1, 2]
        run.do(f"write_restart {tmp_path / 'half'}")
        assert run.do("run 500").engine.get_natoms() == 147
    lines = [plug, "newton off", f"read_restart {tmp_path / 'half'}", "comm_modify vel yes", "neighbor 0.06 bin"]
    with Run(lammps, [*lines, f"timestep {case.time_step!r}", *rest, *inlet]) as run:
        assert [run.do(f"run {n}").engine.get_natoms() for n in (49, 1, 500)] == [146, 147, 147]


def timed_rows(case, factor=1.0):
    """The rows of a case with the steps and speeds of their turns named, as of an inflow against time."""
    rows = []
    for row in case.inlets:
        turns = tuple(range(row.first_step, case.steps + 1, row.every_steps))
        rows.append(replace(row, turns=turns, speeds=tuple(row.vx * factor for _ in turns)))
    return replace(case, inlets=tuple(rows))


def with_turns(case, folder):
    """The lines of `inlets`, with their file of turns in a folder."""
    (folder / TURNS_FILE).write_text("".join(turns_text(case)))
    return [line.replace(" &\n", " ").replace(TURNS_FILE, str(folder / TURNS_FILE)) for line in inlets(case)]


def test_named_turns_are_those_of_the_interval_to_the_last_bit(lammps, plugin, tmp_path):
    case = crowded()
    names, found = ("id", "x", "v", "radius", "rmass"), []
    outlets = [line for line in traffic(case, tmp_path) if " out" in line]
    for one in (case, timed_rows(case)):
        lines = [*start(one), *styles(one, plugin, tmp_path), *outlets, *with_turns(one, tmp_path)]
        with Run(lammps, [*lines, "atom_modify sort 70 0.3", "run 1000"]) as run:
            found.append([run.discs(name) for name in names])
    assert found[0][0].max() > 87
    for name, one, two in zip(names, *found, strict=True):
        assert np.array_equal(one, two), name


@pytest.mark.long  # test_hosts.py has the same without ranks
@pytest.mark.parametrize("law", ["viscous", "history"])
def test_an_inflow_against_time_is_that_of_the_native_engine(law, plugin, tmp_path):
    """Discs that come at growing and falling speed, with a pause, and sizes by id; on one rank and on two."""
    text = """\
discs: {diameter: 0.1, sizes: {kind: uniform, spread: 0.2}}
contact: {restitution: 0.3, impact_speed: 6, friction: 0.2, friction_law: LAW, rotation: true}
domain: {x: [-1, 6], y: [-1, 3]}
walls: [{name: floor, kind: block, x: [-1, 6], y: [-1, 0]}, {name: sill, kind: block, x: [2, 2.2], y: [-1, 0.15]}]
inflow: {kind: rows, x: 0, table: [[0, 0.3, 3], [0.06, 0.45, 5], [0.1, 0, 5], [0.12, 0, 4], [0.14, 0.3, 4]]}
outflow: [{x_beyond: 4}]
run: {duration: 0.4, output_interval: 0.04, time_step_fraction: 0.1}
engine: {kernel: compiled}
""".replace("LAW", law)
    ends = []
    for name, changes, setting in (
        (
            "native",
            ("engine.name=native", "run.integrator=velocity_verlet"),
            Setting("native", "core", dump_format="binary"),
        ),
        ("compiled", (), Setting(kernel="compiled", plugin=plugin, dump_format="binary")),
        ("ranks", (), Setting(kernel="compiled", plugin=plugin, dump_format="binary", ranks=2)),
    ):
        scene = parse_case(text, "timed.yaml", changes).scene()
        result = run_scene(scene, tmp_path / name, setting)
        frames = [frame.sorted() for frame in read_dump(tmp_path / name / "dump.lammpsbin")]
        assert result.inserted == scene.expected_discs
        ends.append(frames)
    for other in ends[1:]:
        for one, two in zip(ends[0], other, strict=True):
            assert np.array_equal(one.ids, two.ids)
            apart = max(np.abs(one.x - two.x).max(initial=0), np.abs(one.y - two.y).max(initial=0))
            assert one.step > 1000 or apart < 1e-9 * 0.1
    assert sum(frame.step <= 1000 for frame in ends[0]) >= 3 and len(ends[0][-1].ids) > 30


def test_named_turns_go_on_over_a_restart(lammps, plugin, tmp_path):
    case = timed_rows(scene(*CLOUD, FLOOR, inlets=(InletRow(5.0, 5.0, 12.0, 0.0, 10, 100, 0.999 * DIAMETER),)))
    inlet = with_turns(case, tmp_path)
    plug, *rest = styles(case, plugin, tmp_path)
    with Run(lammps, [*start(case), plug, *rest, *inlet]) as run:
        assert [run.do(f"run {n}").engine.get_natoms() - 144 for n in (9, 1, 150)] == [0, 1, 2]
        run.do(f"write_restart {tmp_path / 'half'}")
        assert run.do("run 500").engine.get_natoms() == 151
    lines = [plug, "newton off", f"read_restart {tmp_path / 'half'}", "comm_modify vel yes", "neighbor 0.06 bin"]
    with Run(lammps, [*lines, f"timestep {case.time_step!r}", *rest, *inlet]) as run:
        assert [run.do(f"run {n}").engine.get_natoms() for n in (49, 1, 450)] == [146, 147, 151]


@pytest.mark.parametrize(
    ("turns", "message"),
    [
        (None, "cannot be read"),
        ("1 10 12.0\n1 x 12\n", "line 2: expected a row, a step and a speed"),
        ("2 10 12.0\n", "line 1: row 2 is none of those with EVERY 0"),
        ("1 10 12.0\n1 10 12.0\n", "line 2: the steps of a row rise from 1 on"),
        ("1 0 12.0\n", "line 1: the steps of a row rise from 1 on"),
    ],
)
def test_a_bad_file_of_turns_is_refused(lammps, plugin, tmp_path, turns, message):
    case = scene(*cloud(2, 3, 3), FLOOR)
    if turns is not None:
        (tmp_path / "turns").write_text(turns)
    with Run(lammps, [*start(case), *styles(case, plugin, tmp_path)]) as run, pytest.raises(Exception, match=message):
        run.do(f"fix in all jump/inlet 0.2 40 turns {tmp_path / 'turns'} row 1 0 0 0.2 0 0 1 0")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("0.2 40", "needs DIAMETER, MASS, perhaps turns FILE, and rows"),
        ("0.2 40 row 1 30 0 0.2 0 0 1", "needs DIAMETER, MASS, perhaps turns FILE, and rows"),
        ("0.2 40 line 1 30 0 0.2 0 0 1 0", "'line' stands where a row begins"),
        ("0.2 40 row 1 0 0 0.2 0 0 1 0", "EVERY is 1 or more"),
        ("0.2 40 row 1 30 -1 0.2 0 0 1 0", "MOST and NEAR are 0 or more"),
        ("0.2 40 row 1 30 0 0.2 99 0 1 0", r"the row at \(99, 0\) is outside the box"),
        ("-0.2 40 row 1 30 0 0.2 0 0 1 0", "DIAMETER and MASS must be above 0"),
    ],
)
def test_bad_rows_are_refused(lammps, plugin, tmp_path, words, message):
    case = scene(*cloud(2, 3, 3), FLOOR)
    with Run(lammps, [*start(case), *styles(case, plugin, tmp_path)]) as run, pytest.raises(Exception, match=message):
        run.do(f"fix in all jump/inlet {words}")
