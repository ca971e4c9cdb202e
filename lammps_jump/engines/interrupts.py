# SPDX-License-Identifier: GPL-2.0-or-later
"""Signals that end an engine or an analysis in order: Ctrl-C, and those by which batch systems and terminals say so."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT, signal.SIGUSR1, signal.SIGUSR2, signal.SIGXCPU)
"""Ctrl-C, the end of a job, a closed terminal, Ctrl-\\, a time limit that comes near (two), one of processor time."""


@contextmanager
def handled_by(handler: Callable[..., Any]) -> Iterator[None]:
    """Give the `SIGNALS` to `handler`; nothing changes outside the main thread, which alone receives signals.

    A signal that is ignored stays ignored, as in a job that the shell has put into the background.
    """
    before = {}
    if threading.current_thread() is threading.main_thread():
        handled = {number: signal.getsignal(number) for number in SIGNALS}
        before = {number: old for number, old in handled.items() if old not in (signal.SIG_IGN, None)}
    try:
        for number in before:
            signal.signal(number, handler)
        yield
    finally:
        for number, old in before.items():
            signal.signal(number, old)


@contextmanager
def counted_interrupts(most: float = 1) -> Iterator[Callable[[], int]]:
    """Count the signals, so that none ends a step half way.

    Parameters
    ----------
    most : float
        A signal after so many raises a KeyboardInterrupt at once.

    Yields
    ------
    callable
        Returns the number of signals so far.
    """
    seen = 0

    def count(number: int, stack: object) -> None:
        nonlocal seen
        seen += 1
        if seen > most:
            raise KeyboardInterrupt

    with handled_by(count):
        yield lambda: seen


terminate_as_interrupt = partial(counted_interrupts, most=0)
"""Let all `SIGNALS` raise a KeyboardInterrupt, as Ctrl-C does."""


@contextmanager
def held_back(numbers: Iterable[int]) -> Iterator[None]:
    """Keep signals from this thread while the block runs; a process that it starts never gets them by default."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, numbers)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


class Request(threading.Event):
    """Request to an engine, and whether there was one."""

    _act: Callable[[], None] | None = None

    def make(self) -> None:
        """Ask, and call the function that listens."""
        self.set()
        act = self._act
        if act is not None:
            act()

    is_made = threading.Event.is_set

    @contextmanager
    def calls(self, act: Callable[[], None]) -> Iterator[None]:
        """Call `act` when the request is made, at once where it is made already."""
        self._act = act
        if self.is_made():
            act()
        try:
            yield
        finally:
            self._act = None


stop_request, save_request = Request(), Request()
"""Of this process: to end the run in order, as its parent requested; to write a checkpoint."""


at_step: Callable[[int], None] | None = None
"""Called in the engine's process with the number of the step; of several MPI ranks, the first calls it."""
