# SPDX-License-Identifier: GPL-2.0-or-later
"""The engine's process: what goes to and fro, what ends it, and what it leaves when its parent is gone."""

from __future__ import annotations

import ctypes
import os
import pickle
import re
import resource
import signal
import sys
from dataclasses import asdict
from json import dumps
from pathlib import Path

import pytest
from children import run_child
from made_up import INPUTS

from lammps_jump.case import load_case
from lammps_jump.engines import child as children
from lammps_jump.engines import launch
from lammps_jump.engines.checkpoint import read_checkpoint
from lammps_jump.engines.child import Child, close_idle, prepare_worker
from lammps_jump.engines.launch import run
from lammps_jump.engines.result import MARK, Progress, RunResult
from lammps_jump.engines.setting import Job, Setting
from lammps_jump.errors import CaseError, SetupError
from lammps_jump.files import RANKS_FILE

pytestmark = pytest.mark.lammps
SETTINGS = {"lammps": Setting(), "native": Setting("native", "core")}
RESULT = RunResult("native", "core", "complete", "", 900, 1.0, 7, 7, 0, 0, 1.0)


@pytest.fixture
def scene():
    return load_case(INPUTS / "energy_box_16.yaml", ["run.duration=2"]).scene()


@pytest.fixture
def endless():
    return load_case(INPUTS / "energy_box_16.yaml", ["run.duration=190000"]).scene()


class FakeProcess:
    """Keeps what it is told."""

    returncode = 0
    pid = 0

    def __init__(self):
        self.heard, write = os.pipe()
        self.stdin = os.fdopen(write, "w")

    def poll(self):
        return 0

    def wait(self, seconds=None):
        return 0

    def told(self) -> list[str]:
        """What it was told; closes it."""
        self.stdin.close()
        with os.fdopen(self.heard) as file:
            return file.read().splitlines()[1:]  # the job apart


def fake_child(monkeypatch, reports=9, ends=True) -> Child:
    lines = [f"{MARK}{dumps({'report': [100 * (k + 1), 7, 2]})}\n" for k in range(reports)]
    lines = [f"{MARK}{dumps({'report': None})}\n", "words of the engine\n", f"{MARK}torn", *lines]
    if ends:
        lines.append(f"{MARK}{dumps({'result': asdict(RESULT)})}\n")
    monkeypatch.setattr(children.subprocess, "Popen", lambda *_, **__: FakeProcess())
    child = Child("native")
    child.messages.close()
    child.messages = iter(lines)
    return child


def job(scene, folder=Path("nowhere")) -> Job:
    return Job(scene, folder, Setting("native", "core"), Path.cwd())


def test_reports_and_result_come_through(scene, monkeypatch):
    child, seen = fake_child(monkeypatch), []
    assert child.run(job(scene), seen.append, None) == RESULT
    assert seen == [Progress(100 * k, scene.steps, scene.time(100 * k), 7, threads=2) for k in range(1, 10)]
    assert child.output == ["words of the engine"] and child.process.told() == []


def test_a_caller_that_wants_an_end_is_asked_until_it_says_so(scene, monkeypatch):
    child, answers = fake_child(monkeypatch), iter([False, False, True])
    assert child.run(job(scene), None, lambda: next(answers)) == RESULT
    assert child.process.told() == ["stop 1"]


def test_the_first_signal_asks_and_a_later_one_kills(scene, monkeypatch):
    child, ended = fake_child(monkeypatch), []
    monkeypatch.setattr(child, "end", lambda: ended.append(True))
    monkeypatch.setattr(children, "ONE_SIGNAL", float("inf"))
    child.run(job(scene), lambda report: child.signalled(15, None), None)  # nine at once, as from `timeout`
    assert child.process.told() == ["stop 1"] and not ended
    monkeypatch.setattr(children, "ONE_SIGNAL", -1.0)
    child.signalled(15, None)
    assert ended


def test_a_process_that_ends_without_a_word_gives_no_result(scene, monkeypatch):
    child = fake_child(monkeypatch, ends=False)
    assert child.run(job(scene), None, None) is None
    assert child.last.step == 900 and child.process.told() == []


# --- real ones -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("engine", SETTINGS)
def test_a_run_leaves_the_callers_process_as_it_was(scene, tmp_path, monkeypatch, engine):
    monkeypatch.chdir(tmp_path)
    before = Path.cwd(), dict(os.environ), signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)
    result = run(scene, Path("run"), SETTINGS[engine])
    assert result.status == "complete" and result.steps == scene.steps and result.present == 16
    assert result.seconds > 0 and result.cpu_seconds > 0
    assert (Path.cwd(), dict(os.environ), signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)) == before
    assert (tmp_path / "run/dump.lammpstrj").exists()


@pytest.mark.parametrize("engine", SETTINGS)
def test_the_process_serves_one_run_after_another(scene, tmp_path, engine):
    prepare_worker(engine)
    [child] = children._idle[engine]
    for name in "ab":
        run(scene, tmp_path / name, SETTINGS[engine])
        assert children._idle[engine] == [child]
    assert (tmp_path / "a/dump.lammpstrj").read_bytes() == (tmp_path / "b/dump.lammpstrj").read_bytes()


@pytest.mark.parametrize("engine", ["lammps", pytest.param("native", marks=pytest.mark.long)])
def test_a_killed_process_is_a_failed_run(endless, tmp_path, engine):
    prepare_worker(engine)
    [child] = children._idle[engine]

    def kill(report: Progress) -> None:
        if report.step:
            child.end()

    result = run(endless, tmp_path, SETTINGS[engine], progress=kill)
    assert result.status == "failed" and "status -9" in result.message and str(tmp_path) in result.message
    assert child not in children._idle[engine]
    assert run(endless, tmp_path, Setting(engine, SETTINGS[engine].kernel, stop_at=1000)).status == "interrupted"


@pytest.mark.parametrize("engine", ["lammps", pytest.param("native", marks=pytest.mark.long)])
def test_a_second_signal_kills_and_the_earlier_checkpoint_stays(endless, tmp_path, engine, monkeypatch):
    monkeypatch.setattr(children, "ONE_SIGNAL", -1.0)
    setting = SETTINGS[engine]
    first = run(endless, tmp_path, Setting(engine, setting.kernel, stop_at=1000))
    monkeypatch.setattr(Child, "_tell", lambda child: None)  # else it may save before the second signal comes

    def press(report: Progress) -> None:
        if report.step > 1000:
            signal.raise_signal(signal.SIGTERM)
            signal.raise_signal(signal.SIGTERM)

    result = run(endless, tmp_path, setting, progress=press, resume=read_checkpoint(tmp_path))
    assert result.status == "interrupted" and f"goes on from t = {endless.time(first.steps):.4g} s" in result.message
    assert read_checkpoint(tmp_path).step == first.steps


def test_errors_of_the_engine_are_the_callers(scene, tmp_path, monkeypatch):
    with pytest.raises(CaseError, match="xyz"):
        run(scene, tmp_path, Setting("native", "core", dump_format="xyz"))
    (tmp_path / "file").touch()
    with pytest.raises(SetupError, match="cannot be written"):
        run(scene, tmp_path / "file" / "run", Setting("native", "core"))


ORPHAN = """
import os, signal, sys
from pathlib import Path
from lammps_jump.case import load_case
from lammps_jump.engines import child
from lammps_jump.engines.launch import Setting, run

case, folder, engine, kernel, ranks = sys.argv[1:]
scene = load_case(case, ["run.duration=190000"]).scene()
made = []
class Noted(child.Child):
    def __init__(self, *arguments):
        super().__init__(*arguments)
        print("engine", self.process.pid, flush=True)
child.Child = Noted
def die(report):
    if report.step:
        os.kill(os.getpid(), signal.SIGKILL)
run(scene, Path(folder), Setting(engine, kernel, ranks=int(ranks)), progress=die)
"""
SUBREAPER = 36


@pytest.mark.parametrize(
    ("engine", "kernel", "ranks"),
    [
        ("lammps", "stock", 1),
        pytest.param("native", "core", 1, marks=pytest.mark.long),
        pytest.param("lammps", "stock", 2, marks=pytest.mark.long),
    ],
)
def test_without_its_parent_a_run_is_saved_and_ends(endless, tmp_path, engine, kernel, ranks):
    libc = ctypes.CDLL(None)
    libc.prctl(SUBREAPER, 1, 0, 0, 0)  # orphans become children of this process, which can wait for them
    try:
        arguments = [INPUTS / "energy_box_16.yaml", tmp_path, engine, kernel, ranks]
        status, output = run_child([sys.executable, "-c", ORPHAN, *arguments])
        assert status == -signal.SIGKILL
        os.waitpid(int(re.search(r"engine (\d+)", output)[1]), 0)
    finally:
        libc.prctl(SUBREAPER, 0, 0, 0, 0)
    checkpoint = read_checkpoint(tmp_path)
    assert 0 < checkpoint.step < endless.steps and checkpoint.result.status == "interrupted"
    setting = Setting(engine, kernel, stop_at=checkpoint.step + 1000)
    result = run(endless, tmp_path, setting, resume=checkpoint)
    assert result.steps == checkpoint.step + 1000 and result.resumed == (endless.time(checkpoint.step),)


def test_the_reason_is_told_where_a_native_run_cannot_write(endless, tmp_path):
    """A line of the traceback was told in place of it."""
    close_idle()  # the next process has the limit of this one
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, hard))
    try:
        result = run(endless, tmp_path, Setting("native", "core"))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert result.status == "failed" and "OSError" in result.message and "File too large" in result.message


@pytest.mark.fault("folders")
def test_the_job_of_several_ranks_stands_in_the_run_folder_and_goes(tmp_path, monkeypatch):
    """A killed run left it in the temporary folder for ever; the next command removes it."""
    seen = []

    class Nothing:
        def __init__(self, engine, ranks, job_file):
            seen.append((Path(job_file), pickle.loads(Path(job_file).read_bytes()).folder))

        def close(self) -> None:
            pass

    monkeypatch.setattr(children, "Child", Nothing)
    monkeypatch.setattr(children, "check_installed", lambda: None)
    victim = tmp_path / "victim"
    victim.write_text("of the user")
    (tmp_path / RANKS_FILE).symlink_to(victim)
    with children.child_for(Job(None, tmp_path, Setting("lammps", "stock", 2), tmp_path, None)):
        assert seen == [(tmp_path / RANKS_FILE, tmp_path)]
    assert victim.read_text() == "of the user" and not os.path.lexists(tmp_path / RANKS_FILE)


@pytest.mark.fault("folders")
def test_the_job_of_several_ranks_lies_where_no_other_user_writes(tmp_path, monkeypatch):
    """A pickle in a folder of a group is code of any of its members."""
    seen = []

    class Nothing:
        def __init__(self, engine, ranks, job_file):
            path = Path(job_file)
            seen.append((path, path.stat().st_mode & 0o777, path.parent.stat().st_mode & 0o777))

        def close(self) -> None:
            pass

    monkeypatch.setattr(children, "Child", Nothing)
    monkeypatch.setattr(children, "check_installed", lambda: None)
    (tmp_path / "shared").mkdir()
    (tmp_path / "shared").chmod(0o2775)
    job = Job(None, tmp_path / "shared" / "run", Setting("lammps", "stock", 2), tmp_path, None)
    job.folder.mkdir(mode=0o755)
    with children.child_for(job):
        ((file, mode, folder_mode),) = seen
        assert file.exists() and (mode, folder_mode) == (0o600, 0o700) and not list(job.folder.iterdir())
    assert not file.parent.exists()
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "shared"))
    with pytest.raises(SetupError, match=r"shared: others may change it.* in the variable TMPDIR, or take one rank"):
        with children.child_for(job):
            pass
    assert len(seen) == 1 and [one.name for one in (tmp_path / "shared").iterdir()] == ["run"]


@pytest.mark.fault("folders")
def test_a_script_that_another_user_changes_is_not_run(scene, tmp_path, monkeypatch):
    """LAMMPS has a command that runs programs; in a folder of a group the script is not read from its file."""
    tmp_path.chmod(0o775)
    monkeypatch.setattr(launch, "make_ready", lambda job: (tmp_path / "in.lammps").write_text("shell touch PWNED\n"))
    result = run(scene, tmp_path, Setting("lammps", "stock"))
    assert result.status == "complete" and not (tmp_path / "PWNED").exists()
    assert (tmp_path / "in.lammps").read_text() == "shell touch PWNED\n"


KILLED = """
import os, re, signal
from lammps_jump.engines.lammps.loader import memory_files, new_engine
engine = new_engine(["-log", "none", "-screen", "none", "-nocite"])
print(*re.findall("/dev/shm/mpich_shm_[0-9a-z_]+", open("/proc/self/maps").read()), flush=True)
os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="MPI keeps its memory in other places there")
def test_a_killed_engine_leaves_no_shared_memory():
    # MPI deletes its file of 1 MB when it ends in order, which a worker that is killed does not; /dev/shm filled
    status, output = run_child([sys.executable, "-c", KILLED])
    names = set(output.split())
    assert status == -signal.SIGKILL and names, output
    assert not [name for name in names if Path(name).exists()]
