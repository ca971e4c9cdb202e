# SPDX-License-Identifier: GPL-2.0-or-later
"""What is of the plugin alone: its commands, what it refuses, lists of LAMMPS, ranks, restart, the width of vectors.

That it steps as the other hosts do is in `tests/engines/test_hosts.py`.
"""

from __future__ import annotations

import os
import platform
import shlex
import struct
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from hosts import start
from plugin_scripts import CLOUD, DIAMETER, FLOOR, Run, cloud, compiled, final, scene, styles

from lammps_jump.compiling.compiler import find_compiler
from lammps_jump.engines.child import close_idle
from lammps_jump.engines.launch import write_script
from lammps_jump.engines.plugin import plugin_path
from lammps_jump.physics.slip import Springs
from lammps_jump.scene.scene import InletRow, Outlet, handmade_scene
from lammps_jump.scene.sizes import Sizes
from lammps_jump.scene.walls import Block, Plane
from lammps_jump.studies.runs import run_frames

pytestmark = pytest.mark.lammps

UNIFORM = Sizes((1.0,), (0.16,), (0.24,))
EQUAL = 1e-9  # diameters after 1000 steps: the agreement that is promised
# Sums are taken in another order, so the last digit differs; collisions amplify it some ten-fold each.


@pytest.mark.parametrize("skin", [0.002, 0.3])
def test_the_skin_of_the_list_changes_no_result(lammps, plugin, tmp_path, skin):
    case = scene(*CLOUD, FLOOR, friction=0.1)
    expected = final(lammps, compiled(case, plugin, tmp_path), 600, "x")[0]
    found = final(lammps, compiled(case, plugin, tmp_path, skin=skin), 600, "x")[0]
    assert np.abs(found - expected).max() < EQUAL * DIAMETER


def test_a_restart_goes_on_as_if_never_stopped(lammps, plugin, tmp_path):
    case = scene(*CLOUD, FLOOR, friction=0.3, rotation=True)
    options = dict(probe="probe 100 floor")
    with Run(lammps, compiled(case, plugin, tmp_path, **options)) as run:
        run.do("run 500", f"write_restart {tmp_path / 'half'}", "run 100")
        expected, force = run.discs(), run.vector(3)
    plug, *again = styles(case, plugin, tmp_path, **options)  # no restart file holds them
    lines = [plug, "newton off", f"read_restart {tmp_path / 'half'}", "comm_modify vel yes", "neighbor 0.06 bin"]
    with Run(lammps, [*lines, f"timestep {case.time_step!r}", *again]) as run:
        run.do("run 100")
        found, later = run.discs(), run.vector(3)
    # the dashpot of the step at the cut sees the velocity of the step, not of the half step: LAMMPS recomputes forces
    assert np.abs(found - expected).max() < 1e-4 * DIAMETER
    assert later == pytest.approx(force, rel=0.02, abs=10.0)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ((".image", ".image none"), "takes the file of a scene"),
        ((".image", ".images"), "of the scene cannot be read"),
        (("newton off", "newton on"), "needs newton off, processors"),
        (("boundary f f p", "boundary f p p"), "needs .* no periodic y"),
        (("fix step all jump/step", "#"), "needs fix jump/step"),
        (("walls 2", "walls 1"), "number of walls of the scene, 2, and their names"),
        (("probe 10 floor", "probe 10 roof"), "unknown wall 'roof'"),
        (("probe 10 floor", "probe 0 floor"), "must be above 0"),
        (("probe 10 floor", "went floor 0 0 0"), "wall 'floor' that went is no lid, gate or body"),
        (("probe 10 floor", "bodies 5 file 1"), "a scene that has bodies"),
        (("probe 10 floor", "sizes 9 1"), "a scene with sizes"),
        (("probe 10 floor", "slots 65"), "allowed is 1 to 64"),
        (("fix step all", "fix step part"), "its group is all"),
        (("walls", "doors"), "unknown keyword 'doors'"),
    ],
)
def test_bad_commands_are_refused_by_name(lammps, plugin, tmp_path, change, message):
    case = scene(*cloud(2, 3, 3), FLOOR[:2], friction=0.2)
    lines = compiled(case, plugin, tmp_path, probe="probe 10 floor")
    known = ("pair_style", "fix step", "newton", "boundary")
    changed = [line.replace(*change) if line.startswith(known) else line for line in lines]
    assert changed != lines
    refused(lammps, changed, message)


def refused(lammps, lines, message):
    engine = lammps(cmdargs=["-log", "none", "-screen", "none", "-nocite"])
    try:
        with pytest.raises(Exception, match=message):
            for line in ("region part block 0 1 0 1 -1 1", *lines, "run 1"):
                engine.command(line)
                if line.startswith("create_box"):
                    engine.command("group part region part")
    finally:
        engine.close()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("diameter 0.2", "diameter 0.19"), "has diameter 0.19"),
        (("all mass 4", "all mass 5"), "and mass 5.*, the scene says .* mass 4"),
    ],
)
def test_discs_of_another_scene_are_refused(lammps, plugin, tmp_path, change, message):
    lines = compiled(scene(*cloud(2, 3, 3), FLOOR[:2]), plugin, tmp_path)
    changed = [line.replace(*change) for line in lines]
    assert changed != lines
    refused(lammps, changed, message)


def test_discs_larger_or_lighter_than_the_sizes_of_a_scene_are_refused(tmp_path):
    case = handmade_scene([[0.0, 1.0]], [[0.0, 0.0]], sizes=UNIFORM, steps=1)
    for change in ("diameter 0.25", "mass 1"):
        engine = start("compiled", case, [], tmp_path)
        with pytest.raises(Exception, match=r"disc 1 has diameter .* the scene says up to 0.24"):
            engine.do(f"set atom 1 {change}", "run 1")
        engine.close()


def test_the_script_says_sizes_and_slots_only_where_there_are_some(tmp_path):
    at, still, row = [[0.0, 1.0]], [[0.0, 0.0]], InletRow(5.0, 5.0, 1.0, 0.0, 1, 9, 0.2)
    plain, sizes, slots = (
        write_script(handmade_scene(at, still, **more), tmp_path, kernel="compiled").read_text()
        for more in ({}, {"sizes": UNIFORM, "inlets": (row,), "steps": 9}, {"slots": 3})
    )
    assert " sizes " not in plain and "v_diameter" not in plain and "slots" not in plain
    assert " sizes " in sizes and "fix             size" not in sizes  # at all discs it would cost a third of the run
    assert plain == slots.replace(" &\n                slots 3", "")


@pytest.mark.long
@pytest.mark.skipif(platform.machine() != "x86_64", reason="AVX is of x86-64")
@pytest.mark.parametrize("more", [{"sizes": UNIFORM, "rotation": True}, {}], ids=["sizes, spin", "equal"])
def test_the_width_of_vectors_changes_no_bit(plugin, monkeypatch, request, more):
    """Without AVX there are two numbers in a vector, and pairs are checked one at a time."""
    case = scene(*cloud(4, 9, 9), FLOOR, friction=0.2, **more | {"output_steps": 250})
    ours = run_frames(case, "compiled", dump_format="binary")[1]
    monkeypatch.setenv("CXX", f"{shlex.join(find_compiler())} -mno-avx")
    assert plugin_path() != plugin
    close_idle()  # a process keeps the styles that it has loaded
    request.addfinalizer(close_idle)
    narrow = run_frames(case, "compiled", dump_format="binary")[1]
    assert len(ours) == len(narrow) == 5
    for one, two in zip(ours, narrow, strict=True):
        assert np.array_equal([*one.columns.values()], [*two.columns.values()])


HEAD = {"size": 16, "pointers": 24, "state": 32, "events": 40, "a place": 48}
"""Where numbers of a file of a scene stand: of its head, and the place of its first pointer."""


@pytest.mark.parametrize("change", ["cut", "version", "magic", "longer", *HEAD, "a pointer"])
def test_a_damaged_file_of_the_scene_is_refused(lammps, plugin, tmp_path, change):
    """So that nothing is read or written beyond it."""
    lines = compiled(scene(*cloud(2, 3, 3), FLOOR[:2]), plugin, tmp_path)
    (file,) = tmp_path.glob("*.image")
    data = bytearray(file.read_bytes())
    if change == "version":
        data[-24] ^= 1
    elif change == "magic":
        data[0] ^= 1
    elif change in HEAD:
        data[HEAD[change] : HEAD[change] + 8] = (2**61 + 8).to_bytes(8, "little")
    elif change == "a pointer":
        (count,) = struct.unpack_from("<q", data, HEAD["pointers"])
        begin = HEAD["a place"] + 8 * count + struct.unpack_from("<q", data, HEAD["a place"])[0]
        data[begin : begin + 8] = len(data).to_bytes(8, "little")
    else:
        data = data[:-8] if change == "cut" else data + bytes(8)
    file.write_bytes(data)
    refused(lammps, lines, "is no scene of this version of the plugin")


RANKS_PROGRAM = """
import sys
from lammps_jump.engines.lammps.loader import load_lammps
engine = load_lammps().lammps(cmdargs=["-log", "none", "-screen", "none", "-nocite"])
for line in open(sys.argv[1]):
    engine.command(line.strip())
values = [engine.extract_fix("step", 0, 0), *(engine.extract_fix("step", 0, 1, index) for index in range(3))]
if engine.extract_setting("world_rank") == 0:
    print(*(repr(value) for value in values))
engine.finalize()  # a rank that ends without it is taken for crashed, and mpiexec kills the others
"""


def run_on_ranks(folder, lines, ranks, steps=1000):
    """The lines and so many steps: the finished process, and the final dump as an array, None where there is none."""
    from lammps_jump.engines.lammps.loader import program

    mpiexec = program("mpiexec")
    if mpiexec is None:
        pytest.skip("the mpich wheel brings no mpiexec")
    dump, script, program_file = folder / f"dump{ranks}", folder / f"in{ranks}", folder / "ranks.py"
    write = f"write_dump all custom {dump} id x y modify sort id format float %.17g"
    script.write_text("\n".join([*lines, f"run {steps}", write]) + "\n")
    program_file.write_text(RANKS_PROGRAM)
    command = [str(mpiexec), "-n", str(ranks), sys.executable, str(program_file), str(script)]
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    done = subprocess.run(command, capture_output=True, text=True, timeout=600, env=environment)
    return done, np.loadtxt(dump, skiprows=9) if dump.exists() else None


SIGN, SPRINGS = {"law": "sign"}, {"law": "history", "springs": Springs()}  # of all ranks: largest speed; slots


# four ranks on three columns: parts thinner than a disc, so that discs of the rank after next come into reach
@pytest.mark.parametrize(
    ("ranks", "steps", "columns", "law"),
    [
        (2, 1000, 9, SPRINGS),
        *(pytest.param(*more, SIGN, marks=pytest.mark.long) for more in ((2, 1000, 9), (4, 150, 3))),
    ],
)
def test_ranks_equal_one(plugin, tmp_path, ranks, steps, columns, law):
    rows = (InletRow(2.5, 1.0, -12.0, 0.0, 0, 150, 0.999 * DIAMETER),)
    walls = (Block("ground", (-2.5, 1.2), (-3.0, 0.1)), Plane("left", "x", 0.0, "above"))
    # discs cross the border between the ranks, enter, fall off the ground's end and are taken out
    case = scene(*cloud(4, columns, 9), walls, friction=0.2, rotation=True, inlets=rows, **law)
    case = replace(case, domain=((-1.0, 3.0), (-4.0, 9.0)), outlets=(Outlet("y", 0.15, "below", 50),))
    lines = ["processors * 1 1", *compiled(case, plugin, tmp_path, probe="probe 500 ground")]
    lines.append("fix balance all balance 100 1.0 shift x 20 1.0")
    results = []
    for number in (1, ranks):
        done, frame = run_on_ranks(tmp_path, lines, number, steps)
        assert done.returncode == 0, done.stderr + done.stdout
        results.append((frame, np.array([float(word) for word in done.stdout.split("\n")[0].split()])))
    (one, values), (two, again) = results
    assert len(one) != len(case.positions) or steps < 1000
    assert np.array_equal(one[:, 0], two[:, 0])
    assert np.abs(one[:, 1:] - two[:, 1:]).max() < EQUAL * DIAMETER
    assert again == pytest.approx(values, rel=1e-6, abs=1e-6)


@pytest.mark.long  # that is refused on one rank, above, in the same sentence
def test_ranks_above_each_other_are_refused(plugin, tmp_path):
    lines = ["processors 1 * 1", *compiled(scene(*cloud(4, 9, 9), (), friction=0.2), plugin, tmp_path)]
    done, _ = run_on_ranks(tmp_path, lines, 2)
    assert done.returncode != 0
    assert "needs newton off, processors * 1 1 and no periodic y" in done.stdout + done.stderr


def test_energy_and_virial_are_no_numbers(lammps, plugin, tmp_path):
    """Sums over pairs that the style does not make must not look like results."""
    with Run(lammps, compiled(scene(*CLOUD, FLOOR), plugin, tmp_path)) as run:
        for command in ("run 0", "run 10"):
            run.do(command)
            assert all(np.isnan(run.engine.get_thermo(name)) for name in ("pe", "etotal", "press", "pxx"))
            assert run.engine.get_thermo("ke") > 0


@pytest.mark.parametrize(
    "command", ["stress/atom NULL", "pe/atom", "centroid/stress/atom NULL", "pair/local force", "group/group all"]
)
def test_sums_of_single_discs_are_refused(lammps, plugin, tmp_path, command):
    lines = [*compiled(scene(*CLOUD, FLOOR), plugin, tmp_path), f"compute sum all {command}"]
    with Run(lammps, lines) as run, pytest.raises(Exception, match=r"gives no energy and no virial|does not support"):
        run.do(f"thermo_style custom step{' c_sum' * ('group' in command)}", "run 1")


def test_another_atom_style_is_refused(lammps, plugin, tmp_path):
    lines = ["units si", "dimension 2", "newton off", "boundary f f p", "atom_style atomic"]
    lines += ["region domain block 0 1 0 1 -0.1 0.1", "create_box 1 domain", "mass 1 40"]
    with Run(lammps, [*lines, *styles(scene(*CLOUD, FLOOR), plugin, tmp_path)]) as run:
        with pytest.raises(Exception, match="needs atom_style sphere"):
            run.do("run 0")
