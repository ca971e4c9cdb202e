"""Scenes run in a process of their own, so that a hang or a crash of an engine is a result, not the end of a study."""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable
from typing import Any

HANG = {"outcome": "hang", "message": ""}


def _serve(pipe) -> None:
    while True:
        task = pipe.recv()
        if task is None:
            return
        function, arguments = task
        try:
            pipe.send(function(*arguments))
        except Exception as error:  # whatever it is, the study must hear of it and go on
            pipe.send({"outcome": "bug", "message": f"{type(error).__name__}: {error}"})


class Worker:
    """One child process that works through calls; ended and replaced when a call takes too long.

    Use as a context manager.
    """

    def __init__(self) -> None:
        self._context = multiprocessing.get_context("spawn")
        self._process: Any = None
        self._pipe: Any = None

    def __enter__(self) -> Worker:
        return self

    def __exit__(self, *_: object) -> None:
        self._end()

    def _start(self) -> None:
        self._pipe, theirs = self._context.Pipe()
        self._process = self._context.Process(target=_serve, args=(theirs,), daemon=True)
        self._process.start()
        theirs.close()

    def _end(self) -> None:
        if self._process is None:
            return
        try:
            self._pipe.send(None)
            self._process.join(2.0)
        except (OSError, ValueError):
            pass
        if self._process.is_alive():
            self._process.kill()
            self._process.join()
        self._pipe.close()
        self._process = None

    def call(self, function: Callable[..., dict[str, Any]], *arguments: Any, timeout: float) -> dict[str, Any]:
        """What the function returns; an outcome 'hang', 'crash' or 'bug' where it does not.

        Parameters
        ----------
        function : callable
            At the top level of a module; returns a dict.
        arguments
            Picklable.
        timeout : float
            s of wall time.
        """
        if self._process is None or not self._process.is_alive():
            self._start()
        try:
            self._pipe.send((function, arguments))
            if self._pipe.poll(timeout):
                return self._pipe.recv()
        except (EOFError, BrokenPipeError, ConnectionResetError):
            self._process.join(2.0)
            code = self._process.exitcode
            self._process = None
            return {"outcome": "crash", "message": f"the process ended with status {code}"}
        self._process.kill()
        self._process.join()
        self._process = None
        return {**HANG, "message": f"no answer within {timeout:g} s; the process was ended"}
