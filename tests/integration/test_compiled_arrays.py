# SPDX-License-Identifier: GPL-2.0-or-later
"""LAMMPS' arrays are up to date whenever LAMMPS, another fix or Python looks at them, and who looks on changes no bit.

Between looks the compiled styles keep the discs in arrays of their own.
"""

from __future__ import annotations

import numpy as np
import pytest
from plugin_scripts import CLOUD, FLOOR, Run, compiled, scene

pytestmark = pytest.mark.lammps

STEPS = 230
QUIET = "neigh_modify delay 0 every 10 check yes"  # as in the scripts of cases
LOOKS = {
    "a dump": ["dump look all custom 7 {folder}/look id x y vx vy", "dump_modify look format float %.17g"],
    "each step": ["dump look all custom 1 {folder}/look id x y vx vy"],
    "the end of some steps": ["compute heat all ke", "fix look all ave/time 13 1 13 c_heat"],
    "another fix": ["fix look all enforce2d"],
    "whether to sort, in each step": ["neigh_modify delay 0 every 1 check yes"],
    "a restart file": ["restart 11 {folder}/restart.*"],
    "a halt that does not come": ["variable far equal bound(all,xmax)>1e9", "fix look all halt 17 v_far == 1"],
}
LAWS = {"plain": {}, "spin": dict(friction=0.3, rotation=True), "sign": dict(friction=0.3, law="sign")}

RUBBING = scene(*CLOUD, FLOOR, friction=0.3, rotation=True)


def state(run):
    return np.hstack([run.discs(name) for name in ("x", "v", "omega")])


@pytest.fixture(scope="module")
def undisturbed(lammps, plugin, tmp_path_factory):
    found = {}
    for name, law in LAWS.items():
        with Run(lammps, [*compiled(scene(*CLOUD, FLOOR, **law), plugin, tmp_path_factory.mktemp("a")), QUIET]) as run:
            found[name] = state(run.do(f"run {STEPS}"))
    return found


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("look", LOOKS)
def test_who_looks_on_changes_no_bit(lammps, plugin, tmp_path, undisturbed, look, law):
    lines = [*compiled(scene(*CLOUD, FLOOR, **LAWS[law]), plugin, tmp_path), QUIET]
    lines += [line.format(folder=tmp_path) for line in LOOKS[look]]
    with Run(lammps, lines) as run:
        assert np.array_equal(state(run.do(f"run {STEPS}")), undisturbed[law])


@pytest.mark.parametrize("law", LAWS)
def test_a_run_in_parts_is_one_run(lammps, plugin, tmp_path, undisturbed, law):
    with Run(lammps, [*compiled(scene(*CLOUD, FLOOR, **LAWS[law]), plugin, tmp_path), QUIET]) as run:
        run.do("run 37 post no")
        found = state(run.do(f"run {STEPS - 37} pre no"))
        assert np.array_equal(found, undisturbed[law])


@pytest.fixture(scope="module")
def at_step(lammps, plugin, tmp_path_factory):
    """State and kinetic energy of step 131, at which nobody else looks."""
    lines = [*compiled(RUBBING, plugin, tmp_path_factory.mktemp("b")), QUIET, "compute heat all ke"]
    with Run(lammps, lines) as run:
        return state(run.do("run 131")), run.engine.extract_compute("heat", 0, 0)


def test_a_frame_is_the_state_of_its_step(lammps, plugin, tmp_path, at_step):
    look = [
        f"dump look all custom 131 {tmp_path / 'look'} id x y vx vy",
        "dump_modify look format float %.17g sort id",
        "thermo 1000",
    ]
    with Run(lammps, [*compiled(RUBBING, plugin, tmp_path), QUIET, *look]) as run:
        run.do("run 230")
    frames = (tmp_path / "look").read_text().split("ITEM: TIMESTEP\n")
    rows = np.array([line.split() for line in frames[-1].splitlines()[8:]], float)
    assert frames[-1].startswith("131\n")
    assert np.array_equal(rows[:, 1:3], at_step[0][:, :2]) and np.array_equal(rows[:, 3:5], at_step[0][:, 3:5])


def test_a_fix_at_the_end_of_steps_sees_the_state_of_the_step(lammps, plugin, tmp_path, at_step):
    look = [
        "compute heat all ke",
        "variable heat equal c_heat",
        "variable step equal step",
        f"fix look all print 131 '${{step}} ${{heat}}' file {tmp_path / 'heat'} screen no",
        "thermo 1000",
    ]
    with Run(lammps, [*compiled(RUBBING, plugin, tmp_path), QUIET, *look]) as run:
        run.do("run 230")
    assert np.loadtxt(tmp_path / "heat")[-1] == pytest.approx([131, at_step[1]], rel=1e-6)  # printed with ten digits


def test_a_run_whose_time_is_over_ends_with_the_state_of_its_step(lammps, plugin, tmp_path, at_step):
    with Run(lammps, [*compiled(RUBBING, plugin, tmp_path), QUIET, "thermo 1000"]) as run:

        def call(_, step, count, ids, positions, forces):
            forces[:] = 0.0
            if step == 131:
                run.engine.lib.lammps_force_timeout(run.engine.lmp)

        run.do("fix step_hook all external pf/callback 1 1")  # the id of a fix that reads the step alone
        run.engine.set_fix_external_callback("step_hook", call)
        found = state(run.do("run 230"))
        assert run.engine.extract_global("ntimestep") == 131
    assert np.array_equal(found, at_step[0])


def test_groups_of_neighbour_lists_are_refused(lammps, plugin, tmp_path):
    lines = [*compiled(scene(*CLOUD, FLOOR), plugin, tmp_path), "group some id < 50", "atom_modify first some"]
    with Run(lammps, lines) as run, pytest.raises(Exception, match="no neigh_modify include"):
        run.do("neigh_modify include some", "run 0")
