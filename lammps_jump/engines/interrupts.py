"""Ctrl-C and SIGTERM (the time limit of a batch system) while an engine or an analysis runs: both end it in order."""

from __future__ import annotations

import signal
import threading
from contextlib import contextmanager

SIGNALS = (signal.SIGINT, signal.SIGTERM)


@contextmanager
def _handled_by(handler):
    """Give both signals to `handler`; nothing changes outside the main thread, which alone receives signals.

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
def terminate_as_interrupt():
    """Let SIGTERM raise a KeyboardInterrupt, as Ctrl-C does."""

    def interrupt(number, stack) -> None:
        raise KeyboardInterrupt

    with _handled_by(interrupt):
        yield


@contextmanager
def counted_interrupts(most: float = 1):
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

    def count(number, stack) -> None:
        nonlocal seen
        seen += 1
        if seen > most:
            raise KeyboardInterrupt

    with _handled_by(count):
        yield lambda: seen
