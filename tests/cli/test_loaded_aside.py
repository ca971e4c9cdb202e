# SPDX-License-Identifier: GPL-2.0-or-later
"""A command that is refused while a thread still loads what would have been needed: its message, and nothing else."""

from __future__ import annotations

import threading
from importlib import import_module

import pytest
from children import run_program
from made_up import BOX

import lammps_jump as lj
from lammps_jump.runs.conclude import AnalysisThread
from lammps_jump.sweeps import Sweep, read_study

sweep = import_module("lammps_jump.sweeps.sweep")
POINTS = (
    "lammps_jump.sweeps.page", "pandas", "pandas._libs", "concurrent.futures.thread", "pandas.io.json", "scipy.special",
)  # fmt: skip
"""Where the thread is when the program ends; one asks the program for a call at its end, which comes too late."""
LINKED = "is a link to another place, where nothing is written"


@pytest.fixture
def words(tmp_path):
    """A command that is refused once the thread has begun: the folder of a member is a link."""
    (tmp_path / "case.yaml").write_text(lj.load_case(BOX).to_yaml())
    given = {"axes": {"contact.restitution": [0.5, 1.0]}, "members": 1}
    found = Sweep(read_study(tmp_path / "case.yaml", **given), tmp_path / "out")
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "out" / "runs").mkdir(parents=True)
    found.members[0].folder(found.folder).symlink_to(tmp_path / "elsewhere")
    axis = ("--axis", "contact.restitution=0.5,1.0")
    return ["sweep", tmp_path / "case.yaml", *axis, "--members", "1", "--jobs", "1", "--out", found.folder]


@pytest.mark.parametrize(
    "point", [pytest.param(one, marks=[] if "futures" in one else pytest.mark.long) for one in POINTS]
)
def test_the_message_stands_alone_wherever_the_thread_is(words, point):
    status, said = run_program(*words, env={"JUMP_TEST_LOADS": point})
    assert status == 2 and LINKED in said and said.startswith("error: ") and len(said.splitlines()) == 1


@pytest.mark.long
@pytest.mark.parametrize(
    "words",
    [
        ["build-and-run", "CASE", "--set", "discs.diameter=-1"],
        ["build-and-run", "CASE", "--members", "2", "--until", "nothing=1%"],
        ["build-and-run", "absent.yaml"],
        ["run", "absent"],
        ["run", "."],
        ["sweep", "absent.yaml"],
        ["sweep", "CASE", "--axis", "discs.diameter=-1,2"],
        ["calibrate", "CASE", "--target", "nothing=1 ± 1", "--vary", "contact.restitution=0.1:0.9"],
        ["cross-validate", "absent.yaml"],
        ["fluid", "absent.yaml"],
        ["open", "absent.yaml"],
    ],
    ids=" ".join,
)
def test_processes_that_were_started_for_nothing_say_nothing(tmp_path, monkeypatch, words):
    """The engine or the workers load their libraries while the command is refused."""
    (tmp_path / "case.yaml").write_text(lj.load_case(BOX).to_yaml())
    monkeypatch.chdir(tmp_path)
    status, said = run_program(*("case.yaml" if word == "CASE" else word for word in words))
    assert status == 2 and len(said.splitlines()) == 1 and said.startswith("error: ")


def test_what_cannot_be_loaded_aside_is_told_where_it_is_needed(monkeypatch):
    told = []
    monkeypatch.setattr(threading, "excepthook", told.append)
    monkeypatch.setattr(sweep, "LOADED_ASIDE", ("no_such_module",))
    thread = threading.Thread(target=sweep._load_page)
    thread.start()
    thread.join()
    assert told == []


@pytest.mark.parametrize("ended", [False, True])
def test_the_analysis_ahead_tells_errors_while_the_program_goes_on(monkeypatch, ended):
    def fail(self):
        raise RuntimeError("can't register atexit after shutdown")

    told, ahead = [], AnalysisThread.__new__(AnalysisThread)
    monkeypatch.setattr(AnalysisThread, "_follow", fail)
    monkeypatch.setattr(threading, "excepthook", told.append)
    if ended:
        monkeypatch.setattr(threading.main_thread(), "is_alive", lambda: False)
    thread = threading.Thread(target=ahead._work)
    thread.start()
    thread.join()
    assert len(told) == (0 if ended else 1)
