# SPDX-License-Identifier: GPL-2.0-or-later
"""A bounded pool of worker processes: many calls, one outcome each, whatever becomes of the process."""

from __future__ import annotations

import atexit
import multiprocessing
import os
import signal
import subprocess
import sys
import time
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from multiprocessing.connection import wait
from typing import Any, NamedTuple

from lammps_jump import errors
from lammps_jump.engines.child import ONE_SIGNAL
from lammps_jump.engines.interrupts import handled_by
from lammps_jump.errors import JumpError, RunInterrupted
from lammps_jump.provenance import usable_cores

ENDED = "the study was ended; what it had is kept, and the same command continues from there"


class CallOutcome(NamedTuple):
    """Outcome of a call.

    Attributes
    ----------
    kind : str
        'done'; the name of the error that was raised on purpose; 'bug' for another one, 'crash' where the process
        ended, 'hang' where it did not answer in time.
    value : object
        What the call returned, or a message.
    """

    kind: str
    value: Any

    def error(self) -> JumpError:
        """The error that a call ended with; a `RunError` for a bug, crash or hang."""
        return getattr(errors, self.kind, errors.RunError)(str(self.value))


class Worker:
    """One worker process.

    Parameters
    ----------
    modules : str
        Names of modules that it loads before the first call.

    Attributes
    ----------
    number : int
        Of the last call.
    """

    def __init__(self, *modules: str) -> None:
        self.pipe, theirs = multiprocessing.Pipe()
        command = [sys.executable, "-P", "-m", "lammps_jump.sweeps.worker", str(theirs.fileno()), *modules]
        self.process = subprocess.Popen(
            command, stdin=subprocess.DEVNULL, pass_fds=(theirs.fileno(),), start_new_session=True,
            env={**os.environ, "OMP_NUM_THREADS": "1"},  # more would take the cores of the other workers
        )  # fmt: skip
        theirs.close()
        self.number = -1
        self.deadline = float("inf")

    def start(self, number: int, call: partial[Any], patience: float) -> None:
        """Begin a call."""
        self.number, self.deadline = number, time.monotonic() + patience
        with suppress(OSError):  # it has ended: the pool finds that out
            self.pipe.send(call)

    def ask(self) -> None:
        """Ask the call at work to stop in order: by a signal, and by a word in case it does not listen yet."""
        self.process.send_signal(signal.SIGINT)
        with suppress(OSError):
            self.pipe.send(None)

    def end(self, *, kill: bool = False) -> int:
        """End the process, at once or when it is idle; its exit status."""
        if kill:
            self.process.kill()
        self.pipe.close()
        return self.process.wait()


_ready: list[Worker] = []
"""Workers that no pool has taken yet."""


def prepare_workers() -> None:
    """Start a worker for each core before there is work for them: they load the analysis meanwhile, a second."""
    _ready.extend(Worker("lammps_jump.runs.results") for _ in range(usable_cores()))


@atexit.register
def _end_ready() -> None:
    while _ready:
        _ready.pop().end(kill=True)


class Pool:
    """Worker processes that are started once and end with the ``with`` block.

    Parameters
    ----------
    jobs : int
        Processes at most.
    """

    def __init__(self, jobs: int):
        self.jobs = jobs
        self._idle: list[Worker] = []
        self._busy: list[Worker] = []
        self._asked_at: float | None = None

    def __enter__(self) -> Pool:
        return self

    def __exit__(self, *_: object) -> None:
        for worker in self._busy:
            worker.end(kill=True)
        self.close()
        for worker in self._idle:
            worker.end()

    def close(self) -> None:
        """Let the idle workers end, side by side; there is no work left."""
        for worker in self._idle:
            worker.pipe.close()

    def run(
        self,
        calls: Sequence[partial[Any]],
        *,
        done: Callable[[int, CallOutcome], None] = lambda number, outcome: None,
        news: Callable[[int, Any], None] = lambda number, text: None,
        patience: float = float("inf"),
    ) -> list[CallOutcome]:
        """Work through calls, begun in their order.

        Parameters
        ----------
        calls : sequence of functools.partial
            Of functions at the top level of a module.
        done : callable
            Called with the number of a call and its outcome.
        news : callable
            Called with the number of a call and what it tells by `worker.tell`.
        patience : float
            s of wall time that a call may take.

        Raises
        ------
        RunInterrupted
            Ctrl-C or SIGTERM; the calls at work got a request to save what they had. A second signal ends them at once.
        """
        outcomes: dict[int, CallOutcome] = {}
        waiting = deque(enumerate(calls))
        self._asked_at = None

        def finish(worker: Worker, outcome: CallOutcome) -> None:
            self._busy.remove(worker)
            if outcome.kind in ("crash", "hang"):
                worker.end(kill=True)
            else:
                self._idle.append(worker)
            outcomes[worker.number] = outcome
            done(worker.number, outcome)

        with handled_by(self._signalled):
            while self._busy or (waiting and self._asked_at is None):
                while waiting and len(self._busy) < self.jobs and self._asked_at is None:
                    worker = next((some.pop() for some in (self._idle, _ready) if some), None) or Worker()
                    self._busy.append(worker)
                    worker.start(*waiting.popleft(), patience)
                for worker, kind, value in self._heard():
                    if kind == "news":
                        news(worker.number, value)
                    else:
                        finish(worker, CallOutcome(kind, value))
        if self._asked_at is not None:
            raise RunInterrupted(ENDED)
        return [outcomes[number] for number in range(len(calls))]

    def _heard(self) -> list[tuple[Worker, str, Any]]:
        """News of the workers, waited for; those that have ended, and those that are out of time."""
        first = min(worker.deadline for worker in self._busy)
        ready = wait([worker.pipe for worker in self._busy], None if first == float("inf") else _until(first))
        heard = []
        for worker in self._busy:
            if worker.pipe in ready:
                try:
                    heard.append((worker, *worker.pipe.recv()))
                except (EOFError, OSError):
                    status = worker.process.wait()
                    heard.append((worker, "crash", f"the process ended with status {status}"))
            elif _until(worker.deadline) == 0:
                heard.append((worker, "hang", "no answer in time; the process was ended"))
        return heard

    def _signalled(self, number: int, stack: object) -> None:
        if self._asked_at is None:
            self._asked_at = time.monotonic()
            for worker in self._busy:
                worker.ask()
        elif time.monotonic() - self._asked_at > ONE_SIGNAL:
            for worker in self._busy:
                worker.process.kill()


def _until(moment: float) -> float:
    """Seconds until a moment of the monotonic clock, at least 0."""
    return max(0.0, moment - time.monotonic())
