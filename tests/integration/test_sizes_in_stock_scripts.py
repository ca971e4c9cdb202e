# SPDX-License-Identifier: GPL-2.0-or-later
"""Generated scripts with discs of several sizes, on stock LAMMPS: every disc has the diameter and mass of its id."""

from __future__ import annotations

import re

import numpy as np
import pytest
from made_up import plugin_or_skip

from lammps_jump import read_dump
from lammps_jump.case import parse_case
from lammps_jump.engines import Setting, run
from lammps_jump.engines.lammps.loader import load_lammps
from lammps_jump.script import continuation_text, script_text, write_script

pytestmark = pytest.mark.lammps

CASE = """\
discs: {diameter: 0.2, sizes: SIZES}
contact: {restitution: 0.2, impact_speed: 16}
domain: {x: [-1, 20], y: [-2, 10]}
walls: [{name: floor, kind: block, x: [-1, 10], y: [-1, 0]}, {name: back, kind: plane, axis: x, at: 0, side: above}]
run: {duration: 0.4, output_interval: 0.1, time_step_fraction: 0.1}
engine: {kernel: stock}
"""
JET = "inflow: {kind: rows, x: 0.2, depth: 1, mean_speed: 16}\noutflow: [{x_beyond: 4}]\n"
POUR = "inflow: {kind: pour, x: [1, 4], y: [1, 3], count: 60, speed_down: 2}\n"
COLUMN = "initial: [{kind: column, x: [0, 2], y: [0, 2], gate: false, hydrostatic: false}]\n"
SIZES = {
    "uniform": "{kind: uniform, spread: 0.2}",
    "bidisperse": "{kind: bidisperse, spread: 0.2, share: 0.3}",
    "list": "{kind: list, diameters: [0.15, 0.2, 0.25], shares: [0.2, 0.3, 0.5]}",
    "sieve": "{kind: sieve, passing: [[0.1, 0 %], [0.16, 20 %], [0.2, 70 %], [0.26, 100 %]]}",
}


@pytest.mark.parametrize(
    ("sizes", "discs"),
    [
        pytest.param(text, discs, id=f"{kind}-{name}", marks=() if alone else pytest.mark.long)
        for name, discs, of in (("jet", JET, "sieve"), ("pour", POUR, "list"), ("column", COLUMN, "uniform bidisperse"))
        for kind, text in SIZES.items()
        for alone in [kind in of.split()]
    ],
)
def test_every_disc_has_the_size_of_its_id(sizes, discs, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    scene = parse_case(CASE.replace("SIZES", sizes) + discs).scene()
    commands = write_script(scene, tmp_path).read_text()
    lmp = load_lammps().lammps(cmdargs=["-log", "none", "-screen", "none"])
    try:
        lmp.commands_string(commands)
        if discs == POUR:  # the last ones get their size at the end of the next hundred steps
            lmp.commands_string("unfix pour_1\nrun 100")
        n = lmp.get_natoms()
        ids = lmp.numpy.extract_atom("id")[:n].copy()
        diameters, masses = 2 * lmp.numpy.extract_atom("radius")[:n], 1 * lmp.numpy.extract_atom("rmass")[:n]
    finally:
        lmp.close()
    assert n > 20
    assert diameters == pytest.approx(scene.diameters(ids), rel=1e-15)
    assert masses == pytest.approx(scene.masses(scene.diameters(ids)), rel=1e-15)
    if discs == COLUMN:
        assert sorted(ids) == list(range(1, len(scene.positions) + 1))
    if discs == JET:  # ids in turn, none refused
        entered = sum((scene.steps - row.first_step) // row.every_steps + 1 for row in scene.inlets)
        assert ids.max() == entered
        carried = np.sum(scene.diameters(np.arange(1, entered + 1)) ** 2) / scene.time(scene.steps)
        assert carried == pytest.approx(16, rel=0.03)  # a whole number of discs in 0.4 s


@pytest.mark.parametrize("kernel", ["compiled", "native"])
def test_a_curve_of_sizes_is_drawn_alike_by_the_other_engines(kernel, tmp_path):
    setting = Setting("native", "core") if kernel == "native" else Setting(kernel="compiled", plugin=plugin_or_skip())
    scene = parse_case(CASE.replace("SIZES", SIZES["sieve"]) + JET).scene()
    run(scene, tmp_path, setting)
    last = read_dump(tmp_path / "dump.lammpstrj")[-1]
    own = last.ids <= last.ids.max() - len(scene.inlets)  # the last ones get theirs behind the next steps
    assert own.sum() > 20
    assert 2 * last.columns["radius"][own] == pytest.approx(scene.diameters(last.ids[own]), rel=1e-9)  # ten digits


@pytest.mark.long
def test_a_pour_packs_alike_on_all_engines(tmp_path):
    """Places differ, because each engine draws its own; the sizes by id do not, nor does the packing beyond chance."""
    plugin = plugin_or_skip()
    text = CASE.replace("SIZES", SIZES["uniform"]).replace("duration: 0.4", "duration: 2.5")
    text = re.sub("walls: .*\n", "walls: [{name: tank, kind: box, x: [0, 2], y: [0, 9]}]\n", text)
    case = parse_case(text + POUR.replace("[1, 4]", "[0.2, 1.8]").replace("[1, 3]", "[4, 8]"))
    heights = []
    for setting in (Setting(), Setting(kernel="compiled", plugin=plugin), Setting("native", "core")):
        for seed in range(1, 5):
            scene = case.replace({"run.seed": seed}).scene()
            run(scene, tmp_path / str(len(heights)), setting)
            last = read_dump(tmp_path / str(len(heights)) / "dump.lammpstrj")[-1]
            radii = last.columns["radius"]
            assert sorted(last.columns["id"]) == list(range(1, 61))
            assert 2 * radii == pytest.approx(scene.diameters(last.columns["id"]), rel=1e-9)  # ten digits
            heights.append(np.average(last.y, weights=radii**2))
    stock, compiled, native = np.reshape(heights, (3, 4))
    for other in (stock, compiled):
        # Welch's t of four starts each: 3.7 is passed by chance once in a hundred times
        assert abs(other.mean() - native.mean()) < 3.7 * np.sqrt((other.var(ddof=1) + native.var(ddof=1)) / 4)
    assert 0.5 < native.mean() < 0.7  # settled: 60 discs of 0.04 m^2 in a tank 2 m wide are 1.2 m high


def test_poured_discs_that_wait_for_their_size_get_it_after_a_resume():
    """`fix set` acts every hundred steps: the script that goes on must hold it, also where all discs are poured."""
    scene = parse_case(CASE.replace("SIZES", SIZES["uniform"]).replace("duration: 0.4", "duration: 1") + POUR).scene()
    assert len(scene.pour_turns(scene.pours[0])) > 1  # discs that are left come at the next turn
    first = script_text(scene)
    (fix,) = [line for line in first.splitlines() if " set 100 " in line]
    for poured in (0, sum(pour.count for pour in scene.pours)):
        goes_on = continuation_text(scene, step=50, removed=(), poured=poured)
        assert goes_on.splitlines().count(fix) == 1 and (" pour " in goes_on) == (poured == 0)
