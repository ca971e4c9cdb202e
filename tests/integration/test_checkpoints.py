# SPDX-License-Identifier: GPL-2.0-or-later
"""Runs that are ended by SIGKILL, all their processes or some, go on by the same command with --resume.

What is killed is a program of its own; whole runs and those that go on are called in the process.
"""

from __future__ import annotations

import json
import signal
from pathlib import Path

import numpy as np
import pytest
from children import run_program
from made_up import INPUTS, call

import lammps_jump as lj
from lammps_jump.engines.checkpoint import read_checkpoint

pytestmark = pytest.mark.lammps
SETS = (
    "run.duration=0.2",
    "run.output_interval=0.02",
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


@pytest.fixture
def here(monkeypatch, capsys):
    """Status and all output of the program, called in the process."""

    def called(*words) -> tuple[int, str]:
        status, out, err = call(monkeypatch, capsys, *words)
        return status, out + err

    return called


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Folder of the runs of `whole`."""
    return tmp_path_factory.mktemp("whole")


@pytest.fixture
def whole(made, here):
    """Folders of runs that nothing ends, by engine; made when asked for."""

    def folder(engine: str) -> Path:
        if not (made / engine).exists():
            assert here(*command(made / engine, engine))[0] == 0
        return made / engine

    return folder


@pytest.mark.parametrize(
    ("engine", "who"),
    [
        pytest.param("native", "all", marks=pytest.mark.long),
        pytest.param("native", "engine", marks=pytest.mark.long),
        pytest.param("stock", "all", marks=pytest.mark.long),
        pytest.param("compiled", "engine", marks=pytest.mark.long),
        pytest.param("ranks", "all", marks=pytest.mark.long),
    ],
)
@pytest.mark.fault("killed")
def test_a_killed_run_goes_on_from_its_last_checkpoint(engine, who, whole, here, plugin, tmp_path):
    """SIGKILL left nothing to go on from."""
    folder = tmp_path / "run"
    status = killed(folder, engine, 1000, who, "250,750")
    assert status == (-signal.SIGKILL if who == "all" else 1)
    checkpoint = read_checkpoint(folder)
    assert 750 <= checkpoint.step < 1000
    if who == "engine":
        stored = lj.open_run(folder).summary
        assert (
            stored["status"] == "failed" and f"--resume` goes on from t = {checkpoint.time:.4g} s" in stored["message"]
        )
    status, output = here(*command(folder, engine), "--resume")
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
def test_without_a_checkpoint_it_starts_from_the_beginning_and_says_so(engine, whole, here, tmp_path):
    folder = tmp_path / "run"
    assert killed(folder, engine, 500, "all") == -signal.SIGKILL
    assert read_checkpoint(folder) is None
    status, output = here(*command(folder, engine))
    assert status == 2 and "was interrupted" in output and "--force" in output
    status, output = here(*command(folder, engine), "--resume")
    assert status == 0 and "holds no checkpoint: the run starts from the beginning" in output
    one, two = whole(engine), folder
    assert (one / "dump.lammpstrj").read_bytes() == (two / "dump.lammpstrj").read_bytes()
    assert "resumed_at" not in json.loads((two / "summary.json").read_text())


@pytest.mark.long
def test_a_folder_with_no_run_at_all_starts_one(here, tmp_path):
    status = here(*command(tmp_path / "run", "native"), "--resume", "-q")[0]
    assert status == 0 and lj.open_run(tmp_path / "run").status == "complete"


@pytest.mark.long
@pytest.mark.fault("flipped bits")
def test_a_damaged_checkpoint_leads_to_the_one_before(whole, here, tmp_path):
    folder = tmp_path / "run"
    killed(folder, "stock", 1000, "all", "250,750")
    state = folder / f"checkpoint-{read_checkpoint(folder).step}.restart"
    content = bytearray(state.read_bytes())
    content[len(content) // 2] ^= 4
    state.write_bytes(content)
    status, output = here("run", folder, "--resume")
    assert status == 0 and "its SHA-256 differs" in output and "the checkpoint before it is used" in output
    run = lj.open_run(folder)
    assert run.status == "complete" and run.summary["discs"] == lj.open_run(whole("stock")).summary["discs"]
    assert 250 <= round(run.summary["resumed_at"][0] / run.scene.time_step) < 350


@pytest.mark.long
@pytest.mark.fault("killed")
def test_killed_again_and_again(whole, here, tmp_path):
    """A part that was killed goes on, is killed, goes on: the same bytes in the end."""
    folder = tmp_path / "run"
    killed(folder, "native", 400, "all", "250")
    for step in (650, 900):
        options = {"signal_at": (signal.SIGKILL, step, "all"), "env": {"JUMP_TEST_SAVE": str(step - 100)}}
        assert run_program(*command(folder, "native"), "--resume", **options)[0] == -signal.SIGKILL
    assert here(*command(folder, "native"), "--resume")[0] == 0
    assert (folder / "dump.lammpstrj").read_bytes() == (whole("native") / "dump.lammpstrj").read_bytes()
    assert len(lj.open_run(folder).summary["resumed_at"]) == 3
