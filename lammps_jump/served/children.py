# SPDX-License-Identifier: GPL-2.0-or-later
"""Processes of the server: the runs that it has started, and work that a page asks for.

A run is the command that the page shows. Work is bounded in time and memory, and left where it is out of date.
"""

from __future__ import annotations

import atexit
import signal
import subprocess
import sys
import threading
import traceback
from collections import deque
from collections.abc import Callable
from functools import partial
from multiprocessing.connection import wait
from pathlib import Path
from threading import Lock
from typing import Any, NamedTuple

from lammps_jump.errors import JumpError, RunInterrupted, SetupError
from lammps_jump.foreign import MOST_MEMORY
from lammps_jump.quoting import as_word, typed
from lammps_jump.sweeps.pool import CallOutcome, Worker
from lammps_jump.system import within_memory

MOST_LINES = 40
"""Last lines of a command that are kept."""


class ServedChild:
    """One command.

    Attributes
    ----------
    folder : Path
        What it writes.
    command : str
        As one types it.
    """

    def __init__(self, folder: Path, *words: str | Path):
        self.folder, self.command = folder, typed(*words)
        self._lines: deque[str] = deque(maxlen=MOST_LINES)
        # a session of its own: what ends this server does not end the run half way, see `Children.close`
        self.process = subprocess.Popen(
            [sys.executable, "-P", "-m", "lammps_jump", *map(as_word, words)], stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace", start_new_session=True,
        )  # fmt: skip
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        assert self.process.stdout is not None
        with self.process.stdout as stream:
            for line in stream:
                self._lines.append(line.rstrip())

    @property
    def lines(self) -> list[str]:
        """Last lines that it has printed."""
        return list(self._lines)

    @property
    def status(self) -> int | None:
        """Its exit status; None while it goes on."""
        return self.process.poll()

    @property
    def farewell(self) -> str:
        """Outcome, and the command that goes on with what was stopped."""
        if self.status == RunInterrupted.exit_status:
            return f"stopped, and can go on: {typed('run', self.folder, '--resume')}"
        return f"ended with status {self.status}: {self.command}"

    def stop(self) -> None:
        """Ask it to save its state and end."""
        if self.status is None:
            self.process.send_signal(signal.SIGTERM)

    def wait(self) -> int:
        """Wait for its end, and for what it prints."""
        status = self.process.wait()
        self._reader.join()
        return status


class Children:
    """All of them, by the folder that each writes."""

    def __init__(self) -> None:
        self._of: dict[Path, ServedChild] = {}
        self._lock = threading.Lock()

    def start(self, folder: Path, *words: str | Path) -> ServedChild:
        """Run a command that writes a folder.

        Raises
        ------
        SetupError
            One that was started here writes there already.
        """
        with self._lock:
            before = self.of(folder)
            if before is not None and before.status is None:
                raise SetupError(f"{folder}: a run that was started here still writes there")
            self._of[folder.absolute()] = child = ServedChild(folder, *words)
            return child

    def of(self, folder: Path) -> ServedChild | None:
        """The last command that was started for a folder."""
        return self._of.get(folder.absolute())

    def close(self) -> list[ServedChild]:
        """Ask all that go on to save their state and end, and wait for them; those that were."""
        going = [child for child in self._of.values() if child.status is None]
        for child in going:
            child.stop()
        for child in going:
            child.wait()
        return going


LOADED = "lammps_jump.served.look"
"""Module that the process loads before there is work."""

_spare: list[Worker] = []
"""Processes without work."""


class OutOfDate(Exception):
    """The page has sent something newer."""


class PageWork(NamedTuple):
    """Work for a page.

    Attributes
    ----------
    call : functools.partial
        Of a function at the top level of a module.
    seconds : float
        It is left after so many.
    remedy : str
        What to do then.
    page : str
        Name of the page, which asks for one thing at a time: its older work is left. Empty: independent work.
    """

    call: partial[Any]
    seconds: float
    remedy: str
    page: str = ""


class Bounded:
    """Works for pages, one after the other."""

    def __init__(self) -> None:
        self._turn, self._lock = Lock(), Lock()
        self._newest: dict[str, object] = {}
        self._at_work: tuple[str, Worker] | None = None

    def run(self, work: PageWork) -> Any:
        """Result of the call.

        Raises
        ------
        OutOfDate
            The page has requested something newer meanwhile.
        JumpError
            That of the call; it took too long or too much memory.
        RuntimeError
            An error of this program; its process has reported where.
        """
        mine = object()
        with self._lock:
            if work.page:
                self._newest[work.page] = mine
            if self._at_work is not None and self._at_work[0] == work.page != "":
                self._at_work[1].process.kill()
        with self._turn:
            try:
                return _value(self._outcome(work, mine), work)
            finally:
                with self._lock:
                    if self._newest.get(work.page) is mine:
                        del self._newest[work.page]

    def _outcome(self, work: PageWork, mine: object) -> CallOutcome:
        """Outcome of the call."""
        with self._lock:
            if work.page and self._newest.get(work.page) is not mine:
                raise OutOfDate
            worker = _ready()
            self._at_work = work.page, worker
        outcome = CallOutcome("hang", None)
        try:
            worker.start(0, partial(_within, work.call, work.remedy), work.seconds)
            if wait([worker.pipe], work.seconds):
                outcome = CallOutcome(*worker.pipe.recv())
        except (EOFError, OSError):
            outcome = CallOutcome("crash", None)
        finally:
            with self._lock:
                self._at_work = None
                late = bool(work.page) and self._newest.get(work.page) is not mine
                if outcome.kind in ("hang", "crash") or late:
                    worker.end(kill=True)
                else:
                    _spare.append(worker)
        if late:
            raise OutOfDate
        return outcome

    def close(self) -> None:
        """Leave what is at work."""
        with self._lock:
            if self._at_work is not None:
                self._at_work[1].process.kill()


def prepare() -> None:
    """Start a process before there is work for it: it loads its libraries, a second, while a page opens."""
    _spare.append(Worker(LOADED))


def _ready() -> Worker:
    """A process that waits for work."""
    while _spare:
        worker = _spare.pop()
        if worker.process.poll() is None:
            return worker
        worker.end()
    return Worker(LOADED)


@atexit.register
def _end_spare() -> None:
    while _spare:
        _spare.pop().end(kill=True)


def _value(outcome: CallOutcome, work: PageWork) -> Any:
    if outcome.kind == "done":
        return outcome.value
    if outcome.kind == "hang":
        raise SetupError(f"this took longer than {work.seconds:g} s and was left; {work.remedy}")
    if outcome.kind == "crash":
        raise SetupError(f"the process that worked on this ended; {work.remedy}")
    if outcome.kind == "bug":
        raise RuntimeError(outcome.value)
    raise outcome.error()


def _within(call: Callable[[], Any], remedy: str) -> Any:
    """A call within `MOST_MEMORY`; runs in the process of its own, and tells there where it went wrong."""
    try:
        with within_memory(MOST_MEMORY):
            return call()
    except MemoryError:
        raise SetupError(f"this takes more than {MOST_MEMORY / 1e9:g} GB of memory and was left; {remedy}") from None
    except JumpError:
        raise
    except Exception:
        traceback.print_exc()
        raise
