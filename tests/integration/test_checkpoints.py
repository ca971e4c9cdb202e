# SPDX-License-Identifier: GPL-2.0-or-later
"""Runs that are ended by SIGKILL, all their processes or some, go on by the same command with --resume."""

from __future__ import annotations

import json
import signal
from pathlib import Path

import numpy as np
import pytest
from children import run_program
from made_up import INPUTS

import lammps_jump as lj
from lammps_jump.engines.checkpoint import read_checkpoint

pytestmark = pytest.mark.lammps
SETS = (
    "run.duration=0.75",
    "run.output_interval=0.05",
    "probes.interval=0.01",
    "analysis.jump=false",
    "analysis.window=null",
    "analysis.figures=none",
    "run.checkpoint_interval=1e5",
)
ENGINES = {
    "native": ["--engine", "native"],
    "stock": ["--kernel", "stock"],
    "compiled": ["--kernel", "compiled"],
    "ranks": ["--kernel", "compiled", "--ranks", 2],
}


def command(folder: Path, engine: str) -> list:
    words = ["build-and-run", INPUTS / "quick_jump.yaml", "--out", folder, *ENGINES[engine]]
    return [*words, *(word for text in SETS for word in ("--set", text))]


def killed(folder: Path, engine: str, step: int, who: str, saves: str = "") -> int:
    """Status of a run that is ended by SIGKILL at a step."""
    options = {"signal_at": (signal.SIGKILL, step, who), "env": {"JUMP_TEST_SAVE": saves}}
    return run_program(*command(folder, engine), **options)[0]


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Folders of runs that nothing ends, by engine; made when asked for."""
    made: dict[str, Path] = {}

    def folder(engine: str) -> Path:
        if engine not in made:
            made[engine] = tmp_path_factory.mktemp(engine) / "run"
            assert run_program(*command(made[engine], engine))[0] == 0
        return made[engine]

    return folder


@pytest.mark.parametrize(
    ("engine", "who"),
    [
        ("native", "all"),
        pytest.param("native", "engine", marks=pytest.mark.long),
        pytest.param("stock", "all", marks=pytest.mark.long),
        pytest.param("compiled", "engine", marks=pytest.mark.long),
        pytest.param("ranks", "all", marks=pytest.mark.long),
    ],
)
@pytest.mark.fault("killed")
def test_a_killed_run_goes_on_from_its_last_checkpoint(engine, who, whole, plugin, tmp_path):
    """SIGKILL left nothing to go on from."""
    folder = tmp_path / "run"
    status = killed(folder, engine, 4000, who, "1000,3000")
    assert status == (-signal.SIGKILL if who == "all" else 1)
    checkpoint = read_checkpoint(folder)
    assert 3000 <= checkpoint.step < 4000
    if who == "engine":
        stored = lj.open_run(folder).summary
        assert (
            stored["status"] == "failed" and f"--resume` goes on from t = {checkpoint.time:.4g} s" in stored["message"]
        )
    status, output = run_program(*command(folder, engine), "--resume")
    assert status == 0 and f"(step {checkpoint.step} of" in output
    one, two = lj.open_run(whole(engine)), lj.open_run(folder)
    assert two.status == "complete" and two.summary["resumed_at"] == [checkpoint.time]
    assert two.summary["discs"] == one.summary["discs"] and two.summary["steps"] == one.summary["steps"]
    assert {path.name for path in folder.iterdir()} == {path.name for path in one.folder.iterdir()}
    if engine == "native":
        for name in ("dump.lammpstrj", "forces.csv", "profiles.nc"):
            assert (folder / name).read_bytes() == (one.folder / name).read_bytes()
        return
    for before, after in zip(one.frames(), two.frames(), strict=True):
        assert np.array_equal(np.sort(before.ids), np.sort(after.ids))
        if before.step <= checkpoint.step:
            assert np.array_equal(before.x, after.x)
    forces = [(run.folder / "forces.csv").read_text().splitlines() for run in (one, two)]
    assert len(forces[0]) == len(forces[1]) and [float(row.split(",")[0]) for row in forces[0][1:]] == pytest.approx(
        [float(row.split(",")[0]) for row in forces[1][1:]], abs=1e-12
    )


@pytest.mark.long
@pytest.mark.parametrize("engine", ["native", "stock"])
@pytest.mark.fault("killed")
def test_without_a_checkpoint_it_starts_from_the_beginning_and_says_so(engine, whole, tmp_path):
    folder = tmp_path / "run"
    assert killed(folder, engine, 2000, "all") == -signal.SIGKILL
    assert read_checkpoint(folder) is None
    status, output = run_program(*command(folder, engine))
    assert status == 2 and "was interrupted" in output and "--force" in output
    status, output = run_program(*command(folder, engine), "--resume")
    assert status == 0 and "holds no checkpoint: the run starts from the beginning" in output
    one, two = whole(engine), folder
    assert (one / "dump.lammpstrj").read_bytes() == (two / "dump.lammpstrj").read_bytes()
    assert "resumed_at" not in json.loads((two / "summary.json").read_text())


@pytest.mark.long
def test_a_folder_with_no_run_at_all_starts_one(tmp_path):
    status = run_program(*command(tmp_path / "run", "native"), "--resume", "-q")[0]
    assert status == 0 and lj.open_run(tmp_path / "run").status == "complete"


@pytest.mark.long
@pytest.mark.fault("flipped bits")
def test_a_damaged_checkpoint_leads_to_the_one_before(whole, tmp_path):
    folder = tmp_path / "run"
    killed(folder, "stock", 4000, "all", "1000,3000")
    state = folder / f"checkpoint-{read_checkpoint(folder).step}.restart"
    content = bytearray(state.read_bytes())
    content[len(content) // 2] ^= 4
    state.write_bytes(content)
    status, output = run_program("run", folder, "--resume")
    assert status == 0 and "its SHA-256 differs" in output and "the checkpoint before it is used" in output
    run = lj.open_run(folder)
    assert run.status == "complete" and run.summary["discs"] == lj.open_run(whole("stock")).summary["discs"]
    assert 1000 <= round(run.summary["resumed_at"][0] / run.scene.time_step) < 1100


@pytest.mark.long
@pytest.mark.fault("killed")
def test_killed_again_and_again(whole, tmp_path):
    """A part that was killed goes on, is killed, goes on: the same bytes in the end."""
    folder = tmp_path / "run"
    killed(folder, "native", 1500, "all", "1000")
    for step in (2600, 3700):
        options = {"signal_at": (signal.SIGKILL, step, "all"), "env": {"JUMP_TEST_SAVE": str(step - 100)}}
        assert run_program(*command(folder, "native"), "--resume", **options)[0] == -signal.SIGKILL
    assert run_program(*command(folder, "native"), "--resume")[0] == 0
    assert (folder / "dump.lammpstrj").read_bytes() == (whole("native") / "dump.lammpstrj").read_bytes()
    assert len(lj.open_run(folder).summary["resumed_at"]) == 3
