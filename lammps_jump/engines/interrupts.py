"""Ctrl-C and SIGTERM (a batch system whose time is up) while an engine runs: both end it in order, both alike."""

from __future__ import annotations

import signal
import threading
from contextlib import contextmanager


def _in_main_thread() -> bool:
    return threading.current_thread() is threading.main_thread()  # signals come nowhere else


@contextmanager
def terminate_as_interrupt():
    """SIGTERM does what Ctrl-C does, whatever that is at the time; outside the main thread nothing changes."""
    if not _in_main_thread():
        yield
        return

    def hand_on(number, stack) -> None:
        handler = signal.getsignal(signal.SIGINT)
        if not callable(handler):  # ignored, as in a job that the shell put into the background
            raise KeyboardInterrupt
        handler(signal.SIGINT, stack)

    before = signal.signal(signal.SIGTERM, hand_on)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


@contextmanager
def deferred_interrupt():
    """Ctrl-C waits until it is asked about, so that no array is left half sorted; a second one does not wait.

    Yields a function that tells whether it was pressed. Outside the main thread nothing changes.
    """
    pressed: list[int] = []

    def remember(number, stack) -> None:
        if pressed:
            raise KeyboardInterrupt
        pressed.append(number)

    if not _in_main_thread():
        yield lambda: False
        return
    before = signal.signal(signal.SIGINT, remember)
    try:
        yield lambda: bool(pressed)
    finally:
        signal.signal(signal.SIGINT, before)
