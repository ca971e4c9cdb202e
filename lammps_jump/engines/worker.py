# SPDX-License-Identifier: GPL-2.0-or-later
"""Child process in which an engine runs: ``python -m lammps_jump.engines.worker ENGINE [JOB]``.

ENGINE, 'lammps', 'native' or 'twin', is loaded at once, before there is a job. Under ``mpiexec``, JOB names a file
that every rank reads. Else jobs come one after another over standard input, a line of base64 each. Standard input also
brings ``stop N`` (end job N in order). Its end means that the parent is gone: the worker saves the run and ends.

Lines of standard output that begin with `MARK` are messages in JSON; other lines are output of the engine.
"""

from __future__ import annotations

import base64
import importlib
import json
import os
import pickle
import queue
import signal
import sys
import threading
import traceback
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path

from lammps_jump.errors import JumpError
from lammps_jump.files import MOST_TEXT, delete, read_file
from lammps_jump.folders import engine_at_work

from . import (
    interrupts,  # the first two load on first use: LAMMPS takes 0.2 s
    lammps,
    native,
)
from .interrupts import SIGNALS, stop_request
from .result import MARK, Progress, RunResult
from .setting import Job

_LOCK = threading.Lock()


_orphaned = threading.Event()


def say(**message: object) -> None:
    """Send a message to the parent; without a parent, go on."""
    if _orphaned.is_set():
        return
    with suppress(OSError), _LOCK:
        sys.stdout.write(MARK + json.dumps(message) + "\n")
        sys.stdout.flush()


def report(now: Progress | None) -> None:
    """Send a report of progress; None says only that the engine is at work."""
    say(report=[now.step, now.discs, now.threads] if now else None)


class _Inbox:
    """Standard input, read in a thread of its own; iterating waits for jobs."""

    def __init__(self, number: int = 0) -> None:
        self.number = number  # of the job that is served, or waits
        self._jobs: queue.SimpleQueue[Job | None] = queue.SimpleQueue()
        threading.Thread(target=self._read, name="inbox", daemon=True).start()

    def _read(self) -> None:
        for line in _lines():
            if not line.startswith(b"stop "):
                self.number += 1
                stop_request.clear()  # the job before is done, or the parent would not send another
                self._jobs.put(pickle.loads(base64.b64decode(line)))
            elif int(line[5:]) == self.number:
                stop_request.make()
        _orphaned.set()
        stop_request.make()
        self._jobs.put(None)

    def __iter__(self) -> Iterator[Job]:
        return iter(self._jobs.get, None)


def _lines() -> Iterator[bytes]:
    """Lines of standard input, without their ends; a job of many discs comes in thousands of pieces."""
    pieces: list[bytes] = []
    while new := os.read(0, 1 << 20):
        *ended, left = new.split(b"\n")
        for end in ended:
            yield b"".join([*pieces, end])
            pieces.clear()
        pieces.append(left)


def run_job(job: Job) -> RunResult:
    """Run one job to its end."""
    os.chdir(job.home)
    with engine_at_work(job.folder):
        if job.setting.engine == "lammps":
            return lammps.run_lammps(job, report)
        return native.run_native(
            job.scene, job.folder, job.setting, progress=report, should_stop=stop_request.is_made, resume=job.resume
        )


def _load(engine: str) -> None:
    """Import the engine; where that fails, the first job tells."""
    with suppress(JumpError):
        if engine == "lammps":
            lammps.load_lammps()
        importlib.import_module(".lammps.drive" if engine == "lammps" else ".native.engine", __package__)


def _serve(job: Job) -> None:
    try:
        say(result=asdict(run_job(job)))
    except JumpError as error:
        say(error=[type(error).__name__, str(error)])


def _work(engine: str, job_file: str = "") -> None:
    """Serve jobs until standard input ends, or the one job of the ranks."""
    if not job_file:
        inbox = _Inbox()
        _load(engine)
        for job in inbox:
            _serve(job)
        return
    job = pickle.loads(read_file(Path(job_file), MOST_TEXT))
    if os.environ["PMI_RANK"] == "0":
        _Inbox(number=1)
        _serve(job)
        delete(Path(job_file))  # the parent may be gone
    else:
        interrupts.at_step = interrupts.at_step and (lambda step: None)  # the first rank calls it
        os.chdir(job.home)
        with engine_at_work(job.folder):
            lammps.play(job, None)
    lammps.leave_ranks()


def _watch_processor_time() -> None:
    while signal.sigwait([signal.SIGXCPU]):  # the parent has held it back from every thread
        stop_request.make()


def main() -> None:
    """Run the worker. The parent receives signals and requests a stop; each process receives its own XCPU."""
    for number in SIGNALS:
        if number != signal.SIGXCPU:
            signal.signal(number, signal.SIG_IGN)
    threading.Thread(target=_watch_processor_time, name="limit", daemon=True).start()
    status = 0
    try:
        _work(*sys.argv[1:])
    except Exception:
        traceback.print_exc()
        status = 1
    sys.stderr.flush()
    os._exit(status)  # at once: the thread of the inbox still waits


if __name__ == "__main__":
    importlib.import_module("lammps_jump.engines.worker").main()  # under its own name
