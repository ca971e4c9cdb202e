# SPDX-License-Identifier: GPL-2.0-or-later
"""Work on a second core: in a copy of this process, which has everything that the work needs."""

from __future__ import annotations

import multiprocessing
import sys
import threading
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any, ParamSpec

Given = ParamSpec("Given")


@contextmanager
def aside(work: Callable[Given, None], *given: Given.args, **named: Given.kwargs) -> Iterator[None]:
    """Do a work that leaves files, while the block goes on; it is done when the block is left.

    Where it fails it is done once more, in this process and with its errors. Beside other threads it is done in this
    process alone: one of them may hold a lock, for which a copy would wait forever.
    """
    done = False
    if threading.active_count() > 1:
        yield
    else:
        process = multiprocessing.get_context("fork").Process(target=_quietly, args=(work, given, named))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # of the threads of libraries, which rest
            process.start()
        try:
            yield
            process.join()
            done = process.exitcode == 0
        finally:
            process.kill()
            process.join()
    if not done:
        work(*given, **named)


def _quietly(work: Callable[..., Any], given: tuple[Any, ...], named: dict[str, Any]) -> None:
    """Do the work in the copy; the process that does it again tells what fails."""
    with suppress(BaseException):
        work(*given, **named)
        return
    sys.exit(1)
