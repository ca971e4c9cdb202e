# SPDX-License-Identifier: GPL-2.0-or-later
"""What differs between systems: Linux' way, and the way of macOS with what macOS lacks taken away."""

import ctypes
import errno
import fcntl
import os
import subprocess
import sys
from pathlib import Path

import psutil
import pytest
from made_up import INPUTS

import lammps_jump as lj
from lammps_jump import system
from lammps_jump.files import change_text

ROOT = Path(__file__).parents[1]


def lacks_of_macos(patch):
    """Take away what Python lacks on macOS."""
    patch.setattr(system, "LINUX", False)
    for name in ("sched_getaffinity", "sched_setaffinity", "listxattr", "setxattr", "ST_NOEXEC"):
        patch.delattr(os, name)
    for name in ("F_SETLEASE", "F_SETSIG"):
        patch.delattr(fcntl, name)
    patch.setattr(system, "told", lambda path: "")


@pytest.fixture(params=["Linux", "macOS"])
def either(request, monkeypatch):
    if request.param == "macOS":
        lacks_of_macos(monkeypatch)
    return request.param


def test_a_process_is_told_by_when_it_began(either):
    child = subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE)
    try:
        first = system.started(child.pid)
        assert first > 0 and first == system.started(child.pid) and first >= system.started(os.getpid())
        if either == "macOS":
            assert first == pytest.approx(100 * psutil.Process(child.pid).create_time(), abs=1)
    finally:
        child.communicate(b"\n")
    assert system.started(child.pid) == 0 == system.started(2**22 + 1)
    assert system.boot() == system.boot() != ""


def test_cores_and_libraries(either):
    assert 1 <= len(system.own_cores()) <= os.cpu_count()
    assert system.library("libmpi", "12") == {"Linux": "libmpi.so.12", "macOS": "libmpi.12.dylib"}[either]
    assert system.library("liblammps") == {"Linux": "liblammps.so", "macOS": "liblammps.dylib"}[either]
    assert system.libraries_version()
    with system.only_on(()):
        pass
    if either == "macOS":
        assert not system.shared_memory(".*") and not system.processor_lines() and not system.control_group()
        with pytest.raises(lj.SetupError, match="cannot bind"), system.only_on({0}):
            raise AssertionError


def test_a_lock_is_of_one(either, tmp_path):
    first, second = (os.open(tmp_path, os.O_RDONLY) for _ in range(2))
    try:
        system.lock(first)
        with pytest.raises(BlockingIOError):
            system.lock(second)
        with pytest.raises(BlockingIOError):
            system.lock(second, shared=True)
        os.close(first)
        system.lock(second, shared=True, wait=True)
    finally:
        os.close(second)


class Macos:
    """Stands for the C library of macOS."""

    def __init__(self, code=0):
        self.code, self.calls = code, []

    def renamex_np(self, *given):
        self.calls.append(given)
        if self.code:
            ctypes.set_errno(self.code)
            return -1
        os.rename(given[0], given[0] + b".t")
        os.rename(given[1], given[0])
        os.rename(given[0] + b".t", given[1])
        return 0

    def fcopyfile(self, *given):
        self.calls.append(given)
        return 0


@pytest.mark.parametrize("code, done", [(0, True), (errno.ENOTSUP, False), (errno.EACCES, None)])
def test_files_are_exchanged_by_the_call_of_macos(tmp_path, monkeypatch, code, done):
    library = Macos(code)
    monkeypatch.setattr(system.ctypes, "CDLL", lambda *_, **__: library)
    first, second = tmp_path / "a", tmp_path / "b"
    first.write_text("a"), second.write_text("b")
    if done is None:
        with pytest.raises(PermissionError):
            system.exchanged(first, second)
    else:
        assert system.exchanged(first, second) is done
    assert library.calls == [(bytes(first), bytes(second), 2)]  # RENAME_SWAP
    assert first.read_text() == ("b" if done else "a")


def test_a_file_of_the_user_is_changed(either, tmp_path, monkeypatch):
    path, library = tmp_path / "case.yaml", Macos()
    path.write_text("a: 1\n")
    path.chmod(0o640)
    if either == "macOS":
        monkeypatch.setattr(system.ctypes, "CDLL", lambda *_, **__: library)
    assert change_text(path, "a: 1\n", "a: 2\n") == "a: 2\n"
    assert path.read_text() == "a: 2\n" and path.stat().st_mode & 0o777 == 0o640
    assert [len(call) for call in library.calls] == ([4, 3] if either == "macOS" else [])  # attributes, then exchange
    assert os.listdir(tmp_path) == ["case.yaml"]


TAKEN_AWAY = """
import fcntl, os
import lammps_jump.system as system
system.LINUX, system.told = False, lambda path: ""
for name in ("sched_getaffinity", "sched_setaffinity", "listxattr", "setxattr", "getxattr", "ST_NOEXEC"):
    delattr(os, name)
for name in ("F_SETLEASE", "F_SETSIG"):
    delattr(fcntl, name)
"""


@pytest.mark.long
def test_a_run_from_case_to_report_in_the_way_of_macos(tmp_path):
    """All processes of a run see neither what Python lacks on macOS nor files that Linux makes."""
    (tmp_path / "sitecustomize.py").write_text(TAKEN_AWAY)
    words = ["build-and-run", str(INPUTS / "energy_box_16.yaml"), "--out", str(tmp_path / "run"), "--engine", "native"]
    traced = [sys.executable, "-P", "-m", "lammps_jump", *words]
    environment = {**os.environ, "PYTHONPATH": f"{tmp_path}:{ROOT}", "MPLBACKEND": "Agg"}
    done = subprocess.run(traced, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "run" / "report.html").stat().st_size > 10_000
