# SPDX-License-Identifier: GPL-2.0-or-later
"""Scenes run in a process of their own: a hang or a crash of an engine is an outcome and does not end the study."""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess

from .scenes import Outcome


def _serve(pipe: Connection) -> None:
    while True:
        function, arguments = pipe.recv()
        try:
            pipe.send(function(*arguments))
        except Exception as error:  # any error is an outcome, and the study continues
            pipe.send(Outcome("bug", f"{type(error).__name__}: {error}"))


class Worker:
    """One child process that works through calls; ended and replaced when a call takes too long.

    Use as a context manager.
    """

    def __init__(self) -> None:
        self._process: BaseProcess | None = None

    def __enter__(self) -> Worker:
        return self

    def __exit__(self, *_: object) -> None:
        self._end()

    def _end(self) -> int | None:
        """End the process where it still runs; returns its exit status."""
        if self._process is None:
            return None
        process, self._process = self._process, None
        process.kill()
        process.join()
        self._pipe.close()
        return process.exitcode

    def call(self, function: Callable[..., Outcome], *arguments: object, timeout: float) -> Outcome:
        """Return what the function returns; an outcome 'hang', 'crash' or 'bug' where it does not.

        Parameters
        ----------
        function : callable
            At the top level of a module.
        arguments
            Picklable.
        timeout : float
            s of wall time.
        """
        if self._process is None:
            context = multiprocessing.get_context("spawn")
            self._pipe, theirs = context.Pipe()
            self._process = context.Process(target=_serve, args=(theirs,), daemon=True)
            self._process.start()
            theirs.close()
        try:
            self._pipe.send((function, arguments))
            if self._pipe.poll(timeout):
                return self._pipe.recv()
        except (EOFError, BrokenPipeError, ConnectionResetError):
            self._process.join(2.0)
            return Outcome("crash", f"the process ended with status {self._end()}")
        self._end()
        return Outcome("hang", f"no answer within {timeout:g} s; the process was ended")
