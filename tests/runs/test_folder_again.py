# SPDX-License-Identifier: GPL-2.0-or-later
"""A finished run folder met again: analysed anew, asked to go on, used for another run; the command line's answers."""

from __future__ import annotations

import json
import os
import shutil
import signal
from pathlib import Path

import pytest
from made_up import INPUTS, analysed_again, call, files, run_case

from lammps_jump.case import load_case
from lammps_jump.engines.setting import Setting
from lammps_jump.errors import RunInterrupted
from lammps_jump.runs import start
from lammps_jump.runs.folder import marker_of, write_folder

pytestmark = pytest.mark.usefixtures("blank_pictures")

SHORT = ("run.duration=0.1", "run.output_interval=0.02", "engine.name=native", "analysis.jump=false")


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    folder = tmp_path_factory.mktemp("finished") / "run"
    run_case(INPUTS / "quick_jump.yaml", folder, SHORT)
    return folder


@pytest.fixture
def folder(finished, tmp_path):
    """A copy of a finished run's folder."""
    return Path(shutil.copytree(finished, tmp_path / "run"))


@pytest.mark.parametrize("assignment", ["run.duration=50", "discs.diameter=0.3", "analysis_x=1", "name=other"])
def test_analyze_changes_nothing_of_the_run(monkeypatch, capsys, folder, assignment):
    before = files(folder)
    status, _, message = call(monkeypatch, capsys, "analyze", folder, "--set", assignment)
    assert status == 2 and assignment in message and "build-and-run" in message
    assert files(folder) == before


def test_analyze_takes_what_is_of_the_analysis(monkeypatch, capsys, folder):
    assert call(monkeypatch, capsys, "analyze", folder, "-q", "--set", "analysis.bin_width=2")[0] == 0
    assert json.loads((folder / "summary.json").read_text())["profiles"]["bin_width"] == 2


@pytest.mark.parametrize(
    "options",
    [
        ("--out", "x"), ("--diameter", "0.2"), ("--density", "900"), ("--case", "c.yaml"), ("--bin-width", "0"),
        ("--bin-width", "-1"), ("--bin-width", "nan"), ("--bin-width", "1e9"),
    ],
)  # fmt: skip
def test_options_without_meaning_for_a_run_folder(monkeypatch, capsys, folder, options):
    before = files(folder)
    status, _, message = call(monkeypatch, capsys, "analyze", folder, *options)
    assert status == 2 and (options[0] in message or "analysis.bin_width=1000000000" in message)
    assert files(folder) == before


@pytest.mark.parametrize(
    "options",
    [
        ("--bin-width", "0"), ("--bin-width", "1e9"), ("--bin-width", "1e-9"), ("--density", "0"),
        ("--diameter", "-1"), ("--set", "analysis.bin_width=1"), ("--case", "CASE", "--diameter", "0.2"),
    ],
)  # fmt: skip
def test_options_without_meaning_for_a_dump(monkeypatch, capsys, folder, options):
    before = files(folder)
    options = [str(INPUTS / "quick_jump.yaml") if word == "CASE" else word for word in options]
    status, _, message = call(monkeypatch, capsys, "analyze", folder / "dump.lammpstrj", *options)
    assert status == 2 and options[0] in message
    assert files(folder) == before and not (folder / "dump_analysis").exists()


@pytest.mark.parametrize("text", ["[]", "5", '{"status": 3, "discs": 5}', '{"discs": {"inserted": "x"}}'])
def test_summary_that_is_none(monkeypatch, capsys, folder, text):
    (folder / "summary.json").write_text(text)
    for command in (["analyze", folder], ["run", folder, "--resume"]):
        status, _, message = call(monkeypatch, capsys, *command)
        assert status == 2 and "summary.json" in message and "delete it" in message
    assert (folder / "summary.json").read_text() == text


def test_another_run_leaves_files_of_the_user(folder):
    mine = [
        "figures/mine.png", "figures/depth_profile_of_paper.png", "force_lab.csv", "jump_measured.csv", "discs_lab.vtp",
        "discs10.vtp", "fields_lab.vti", "profiles_lab.csv", "checkpoint-of-mine.npz", "pictures.dat",
    ]  # fmt: skip
    for name in mine:
        (folder / name).write_text("of the user")
    assert {"force_sill.csv", "figures/depth_profile.png"} <= {
        str(path.relative_to(folder)) for path in map(Path, files(folder))
    }
    case = load_case(folder)
    write_folder(case, folder, marker_of(case, Setting("native", "core")))
    left = {str(Path(path).relative_to(folder)) for path in files(folder)}
    assert left == {"case.yaml", ".lammps-jump", *mine}


def test_run_whose_analysis_was_ended(monkeypatch, capsys, folder):
    """SIGTERM in the analysis: a message, and a folder that `analyze`, or the command with `--resume`, makes whole."""
    whole = json.loads((folder / "summary.json").read_text())

    def ended(*arguments, **options):
        os.kill(os.getpid(), signal.SIGTERM)
        raise AssertionError("the signal was not heard")

    (folder / "summary.json").unlink()
    with monkeypatch.context() as patch:
        patch.setattr("lammps_jump.analysis.pipeline.analyse", ended)
        with pytest.raises(RunInterrupted, match=r"analysis was stopped.*lammps-jump analyze"):
            start.reanalyse(folder)
    other = shutil.copytree(folder, folder.parent / "other")
    assert call(monkeypatch, capsys, "run", other, "--resume", "-q")[0] == 0
    assert json.loads((other / "summary.json").read_text())["discs"] == whole["discs"]
    found = analysed_again(folder)
    assert found["status"] == "complete" and found["steps"] == whole["steps"]
    assert found["discs"] == whole["discs"] and found["case_hash"] == whole["case_hash"]
    assert not any("cut off" in text for text in found["warnings"])


def test_a_finished_run_that_is_resumed_stays_as_it_is(monkeypatch, capsys, folder):
    """A job that is started again after its run has ended needs no test for that."""
    before = files(folder)
    status, output, _ = call(monkeypatch, capsys, "run", folder, "--resume")
    assert status == 0 and "nothing to do" in output and files(folder) == before


def test_build_of_a_native_case_names_no_script(monkeypatch, capsys, tmp_path):
    for engine in ("native", "lammps"):
        sets = ["--set", f"engine.name={engine}", "--set", "engine.kernel=auto"]
        status, text, _ = call(
            monkeypatch, capsys, "build", INPUTS / "quick_jump.yaml", "--out", tmp_path / engine, *sets
        )
        assert (
            status == 0 and ("in.lammps" in text) == (engine == "lammps") == (tmp_path / engine / "in.lammps").exists()
        )
