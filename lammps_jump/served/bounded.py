# SPDX-License-Identifier: GPL-2.0-or-later
"""Work that a page asks for, in a process of its own: bounded in time and memory, and left where it is out of date.

What is typed or dropped is anything: a diameter in place of which a tenth of it stands for a moment, a drawing that
never ends. The server answers all else meanwhile.
"""

from __future__ import annotations

import atexit
import traceback
from collections.abc import Callable
from functools import partial
from multiprocessing.connection import wait
from threading import Lock
from typing import Any, NamedTuple

from lammps_jump.errors import JumpError, SetupError
from lammps_jump.foreign import MOST_MEMORY
from lammps_jump.sweeps.pool import CallOutcome, Worker
from lammps_jump.system import within_memory

LOADED = "lammps_jump.served.look"
"""What the process loads before there is work."""

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
        Name of the page, which asks for one thing at a time: its older work is left. Empty: the work stands alone.
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
            The page has asked for something newer meanwhile.
        JumpError
            That of the call; it took too long or too much memory.
        RuntimeError
            An error of this program; its process has told where.
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
