# SPDX-License-Identifier: GPL-2.0-or-later
"""What lies in the slots of the plugin's discs stays with the disc: sorts, insertion, removal, ranks, restart."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from lammps_jump.engines.lammps.loader import load_lammps, program
from lammps_jump.engines.launch import write_script
from lammps_jump.scene.build import handmade_scene
from lammps_jump.scene.scene import Outlet
from lammps_jump.scene.walls import Plane

S, DISCS, STEPS = 3, 60, 3000
pytestmark = pytest.mark.lammps
CHILD = """
import sys
sys.path.insert(0, {tests!r})
from test_compiled_slots import between_ranks
between_ranks({plugin!r})
"""


def scene(slots=S):
    """Discs that fall and leave on the right."""
    random = np.random.default_rng(5)
    places = random.permutation([(0.25 * i - 0.7, 0.3 * j + 0.1) for i in range(10) for j in range(6)])
    speeds = random.normal((2.0, 0.0), 2.0, (DISCS, 2))
    return handmade_scene(
        places, speeds, skin=0.06, friction=0.2,
        walls=(Plane("floor", "y", -0.15, "above"),), outlets=(Outlet("x", 2.0, "above", 100),),
        domain=((-3.0, 4.0), (-1.0, 5.0)), slots=slots,
    )  # fmt: skip


def start(plugin):
    """LAMMPS with the script of the current folder, without what writes files and runs."""
    engine = load_lammps().lammps(cmdargs=["-log", "none", "-screen", "none", "-nocite", "-var", "plugin", str(plugin)])
    text = Path("in.plugin.lammps").read_text().replace("&\n", " ").replace("sort 1000", "sort 100")
    left_out = ("dump", "fix             write_", "thermo", "file ", "run", "write_restart")
    for line in text.splitlines():
        if not line.lstrip().startswith(left_out):
            engine.command(line)
    return engine


def held(engine):
    """Array of the fix, in the order of the discs, and their ids."""
    n = engine.extract_global("nlocal")
    return engine.numpy.extract_fix("motion", 1, 2, n, 4 * S), np.array(engine.numpy.extract_atom("id")[:n])


def expected(ids):
    """What `mark` writes: numbers that tell the disc, none for one inserted later."""
    return np.where(ids[:, None] <= DISCS, 1000.0 * ids[:, None] + np.arange(4 * S), 0.0)


def mark(engine):
    engine.command("run 0 post no")
    slots, ids = held(engine)
    slots[:] = expected(ids)


def test_slots_follow_the_discs_of_a_run_and_its_restart(plugin, tmp_path, monkeypatch):
    write_script(scene(), tmp_path, kernel="compiled")
    monkeypatch.chdir(tmp_path)
    engine = start(plugin)
    try:
        mark(engine)
        before = held(engine)[1].tolist()
        engine.command("create_atoms 1 single -2 3 0 units box")
        engine.command("set group all mass 40 diameter 0.2")
        engine.command(f"run {STEPS} post no")
        slots, ids = held(engine)
        assert ids.max() > DISCS > len(set(ids) & set(before))  # inserted, removed
        assert [k for k in ids if k <= DISCS] != [k for k in before if k in ids]  # sorted
        assert np.array_equal(slots, expected(ids))
        engine.command("write_restart one.restart")
    finally:
        engine.close()
    again = load_lammps().lammps(cmdargs=["-log", "none", "-screen", "none", "-nocite"])
    try:
        text = Path("in.plugin.lammps").read_text().replace("&\n", " ").splitlines()
        motion = next(line for line in text if line.split()[1:4] == ["motion", "all", "jump/step"])
        style = next(line for line in text if line.startswith("pair_style"))
        for line in (
            "newton off",
            "processors * 1 1",
            f"plugin load {plugin}",
            "read_restart one.restart",
            style,
            "pair_coeff * *",
            motion,
        ):
            again.command(line)
        again.command("run 0 post no")
        slots, found = held(again)
        assert sorted(found) == sorted(ids) and np.array_equal(slots, expected(found))
    finally:
        again.close()


def between_ranks(plugin):
    """On each rank: mark, run, compare, and say how many discs have come from the other."""
    engine = start(plugin)
    mark(engine)
    mine = set(held(engine)[1].tolist())
    engine.command("run 2000 post no")
    slots, ids = held(engine)
    assert np.array_equal(slots, expected(ids))
    came = sum(1 for k in ids.tolist() if k <= DISCS and k not in mine)
    Path(f"{os.getpid()}.came").write_text(str(came))  # lines of two ranks may be mixed on the screen
    engine.close()


def test_slots_go_with_a_disc_to_another_rank(plugin, tmp_path):
    mpiexec = program("mpiexec")
    if mpiexec is None:
        pytest.skip("the mpich wheel brings no mpiexec")
    write_script(scene(), tmp_path, kernel="compiled")
    code = CHILD.format(tests=str(Path(__file__).parent), plugin=str(plugin))
    command = [str(mpiexec), "-n", "2", sys.executable, "-c", code]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stderr[-2000:]
    came = [int(file.read_text()) for file in tmp_path.glob("*.came")]
    assert len(came) == 2 and sum(came) > 0


def test_without_slots_the_script_has_no_word_of_them(tmp_path):
    for slots in (0, S):
        write_script(scene(slots), tmp_path / str(slots), kernel="compiled")
    texts = [(tmp_path / str(slots) / "in.plugin.lammps").read_text() for slots in (0, S)]
    assert "slots" not in texts[0] and texts[0] == texts[1].replace(f" &\n                slots {S}", "")
