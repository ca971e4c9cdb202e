# SPDX-License-Identifier: GPL-2.0-or-later
"""One writer a folder: others are refused with pid and host, readers write nothing, a dead lock is taken over."""

from __future__ import annotations

import errno
import fcntl
import json
import os
import signal
import sys
from pathlib import Path

import pytest
from children import run_child
from made_up import INPUTS

import lammps_jump as lj
from lammps_jump import folders
from lammps_jump.folders import LOCK_FILE, engine_at_work, holder, locked
from lammps_jump.runs import start

SHORT = {"run.duration": 0.1, "run.output_interval": 0.02, "engine.name": "native"}
HELD = """
import os, signal, sys
from pathlib import Path
from lammps_jump.folders import locked
with locked(Path(sys.argv[1])):
    print(os.getpid(), flush=True)
    os.kill(os.getpid(), signal.SIGKILL)
"""


def contents(folder: Path) -> dict[str, bytes]:
    return {str(path): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.fixture
def case():
    return lj.load_case(INPUTS / "quick_jump.yaml", SHORT)


@pytest.mark.fault("folders")
def test_a_second_writer_is_refused_with_pid_and_host_and_changes_nothing(case, tmp_path):
    """Two runs in one folder ended well, each on the other's data; analyze deleted what LAMMPS was writing."""
    seen = []

    def try_others() -> bool:
        before = set(contents(tmp_path / "run"))
        others = [case.run, lambda folder: case.run(folder, force=True), lambda folder: case.run(folder, resume=True)]
        for other in [*others, start.reanalyse, lambda folder: start.build(case, folder)]:
            with pytest.raises(lj.SetupError, match=rf"process {os.getpid()} on '{os.uname().nodename}' writes"):
                other(tmp_path / "run")
        seen.append(lj.open_run(tmp_path / "run").status)
        assert set(contents(tmp_path / "run")) >= before
        return True

    long = case.replace({"run.duration": 50, "analysis.window": [0, 50]})
    with pytest.raises(lj.RunInterrupted):
        long.run(tmp_path / "run", should_stop=try_others)
    assert seen == ["running"] and not (tmp_path / "run" / LOCK_FILE).exists()
    assert lj.open_run(tmp_path / "run").status == "interrupted"


@pytest.mark.fault("folders")
def test_the_lock_of_a_killed_process_is_free(tmp_path):
    status, output = run_child([sys.executable, "-c", HELD, tmp_path])
    assert status == -signal.SIGKILL
    assert json.loads((tmp_path / LOCK_FILE).read_text())["pid"] == int(output.split()[0])
    assert holder(tmp_path) == ""
    with locked(tmp_path):
        assert str(os.getpid()) in holder(tmp_path)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("changes", "alive"),
    [({}, True), ({"started": 1}, False), ({"pid": 2**22 + 1}, False), ({"boot": "before"}, False),
     ({"boot": "x", "host": "elsewhere"}, True), ({"pid": "../x"}, False), ({"boot": None, "host": []}, True)],
)  # fmt: skip
def test_without_flock_the_text_decides(tmp_path, monkeypatch, changes, alive):
    """A pid that was given again is another process; of another machine nothing is known."""

    def no_flock(descriptor, operation):
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr(fcntl, "flock", no_flock)
    (tmp_path / LOCK_FILE).write_text(json.dumps({**folders._this_process(), **changes}))
    if alive:
        with pytest.raises(lj.SetupError, match="writes to this folder"), locked(tmp_path):
            raise AssertionError
    else:
        with locked(tmp_path), pytest.raises(lj.SetupError), locked(tmp_path):
            raise AssertionError


@pytest.mark.parametrize("text", ["", "[]", "{}", "[" * 100_000, "\udcff"])
@pytest.mark.fault("folders")
def test_a_lock_file_of_garbage_is_no_holder(tmp_path, text):
    (tmp_path / LOCK_FILE).write_text(text, errors="surrogateescape")
    assert holder(tmp_path) == ""
    with locked(tmp_path):
        assert holder(tmp_path)


@pytest.mark.fault("folders")
def test_a_link_as_lock_file_is_not_followed(tmp_path):
    (tmp_path / "mine").write_text("of the user")
    (tmp_path / LOCK_FILE).symlink_to("mine")
    with pytest.raises(lj.SetupError, match="cannot be written"), locked(tmp_path):
        raise AssertionError
    assert (tmp_path / "mine").read_text() == "of the user"


def test_the_engine_of_a_killed_run_is_waited_for(tmp_path, monkeypatch):
    monkeypatch.setattr(folders, "ENGINE_PATIENCE", 1)
    with engine_at_work(tmp_path):
        with pytest.raises(lj.SetupError, match="the engine of a run that was killed writes"), locked(tmp_path):
            raise AssertionError
    with locked(tmp_path):
        assert holder(tmp_path)
