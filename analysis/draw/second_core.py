# SPDX-License-Identifier: GPL-2.0-or-later
"""Work on a second core: in a copy of this process, which has everything that the work needs."""

from __future__ import annotations

import gc
import multiprocessing
import threading
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from multiprocessing.connection import Connection
from typing import Any, Generic, ParamSpec, TypeVar

Given = ParamSpec("Given")
Found = TypeVar("Found")


class Later(Generic[Found]):
    """Result of a work, once the block of `aside` is left."""

    value: Found


@contextmanager
def aside(work: Callable[Given, Found], *given: Given.args, **named: Given.kwargs) -> Iterator[Later[Found]]:
    """Do a work that leaves files, while the block goes on; it is done when the block is left.

    Where it fails it is done once more, in this process and with its errors. Beside other threads it is done in this
    process alone: one of them may hold a lock, for which a copy would wait forever.
    """
    done, later = False, Later[Found]()
    if threading.active_count() > 1:
        yield later
    else:
        heard, said = multiprocessing.Pipe(duplex=False)
        process = multiprocessing.get_context("fork").Process(target=_quietly, args=(said, work, given, named))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # of the threads of libraries, which rest
            process.start()
        said.close()
        try:
            yield later
            with suppress(EOFError):  # it failed
                later.value, done = heard.recv(), True
        finally:
            heard.close()
            process.kill()
            process.join()
    if not done:
        later.value = work(*given, **named)


def _quietly(said: Connection, work: Callable[..., Any], given: tuple[Any, ...], named: dict[str, Any]) -> None:
    """Do the work in the copy; the process that does it again tells what fails."""
    gc.disable()  # it would copy all pages of memory that both share
    with suppress(BaseException):
        said.send(work(*given, **named))
