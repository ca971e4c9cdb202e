# SPDX-License-Identifier: GPL-2.0-or-later
"""The pool: every call has its outcome, whatever becomes of its process, and no process is left behind."""

import os
import signal
from functools import partial
from pathlib import Path

import pool_calls
import pytest

from lammps_jump.errors import RunInterrupted
from lammps_jump.provenance import usable_cores
from lammps_jump.sweeps import pool as pools
from lammps_jump.sweeps import worker
from lammps_jump.sweeps.pool import Pool


@pytest.fixture(autouse=True)
def calls_on_the_path_of_workers(monkeypatch):
    monkeypatch.setenv("PYTHONPATH", str(Path(pool_calls.__file__).parent), prepend=os.pathsep)


def alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


def test_calls_end_in_their_order_and_workers_are_reused():
    with Pool(2) as pool:
        found = pool.run([partial(pow, 2, n) for n in range(20)])
        pids = {outcome.value for outcome in pool.run([partial(os.getpid)] * 20)}
        assert [outcome.value for outcome in found] == [2**n for n in range(20)]
        assert len(pids) <= 2 and os.getpid() not in pids and all(map(alive, pids))
    assert not any(map(alive, pids))


def test_workers_prepared_before_are_taken_first_and_the_rest_end_with_the_program(monkeypatch):
    monkeypatch.setattr(pools, "usable_cores", lambda: 2)
    pools.prepare_workers()
    prepared = {one.process.pid for one in pools._ready}
    with Pool(1) as pool:
        assert {outcome.value for outcome in pool.run([partial(os.getpid)] * 3)} < prepared
    pools._end_ready()
    assert not any(map(alive, prepared))


def test_a_hang_a_crash_a_refusal_and_a_bug_are_outcomes_of_their_calls():
    calls = [
        partial(os._exit, 3),
        partial(int, "no"),
        partial(signal.pause),
        partial(pool_calls.refuse, "too much"),
        partial(int, "7"),
    ]
    with Pool(1) as pool:
        crash, bug, hang, refused, good = pool.run(calls, patience=5.0)
    assert crash.kind == "crash" and "status 3" in crash.value
    assert bug.kind == "bug" and bug.value.startswith("ValueError")
    assert hang.kind == "hang" and refused == ("CaseError", "too much") and good == ("done", 7)


def test_a_killed_worker_costs_its_call_alone():
    with Pool(2) as pool:
        killed, *others = pool.run([partial(signal.raise_signal, signal.SIGKILL), *[partial(int, "1")] * 4])
    assert killed.kind == "crash" and str(-signal.SIGKILL) in killed.value
    assert [outcome.value for outcome in others] == [1] * 4


def test_ctrl_c_asks_the_calls_at_work_and_begins_no_other(ctrl_c_heard):
    heard = []
    with Pool(1) as pool, pytest.raises(RunInterrupted, match="continues from there"):
        pool.run([partial(pool_calls.stop_parent), partial(int, "1")], done=lambda *found: heard.append(found))
    assert heard == [(0, ("RunInterrupted", "was ended"))]


def test_news_come_with_the_number_of_their_call():
    heard = []
    with Pool(1) as pool:
        pool.run([partial(worker.tell, "a"), partial(worker.tell, "b")], news=lambda *found: heard.append(found))
    assert heard == [(0, "a"), (1, "b")]


@pytest.mark.parametrize(
    ("text", "cores"), [("max 100000", None), ("150000 100000", 2), ("10000 100000", 1), ("?", None)]
)
def test_cores_of_a_control_group(tmp_path, text, cores):
    (tmp_path / "cpu.max").write_text(text)
    free = len(os.sched_getaffinity(0))
    assert usable_cores(tmp_path) == min(free, cores or free)
