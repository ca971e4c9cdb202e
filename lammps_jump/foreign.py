# SPDX-License-Identifier: GPL-2.0-or-later
"""One wrapper for all that reads what comes from outside: whatever a parser throws becomes one sentence."""

from __future__ import annotations

import re
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from .errors import JumpError, SetupError
from .quoting import shortened
from .system import within_memory

NUMBER = re.compile(r"\s*[-+]?(?:(?:\d+(?:\.\d*)?|\.\d+)(?:e[-+]?\d+)?|nan|inf(?:inity)?)\s*", re.ASCII | re.IGNORECASE)
"""A number as files have it."""
WHOLE = re.compile(r"\s*[-+]?\d+\s*", re.ASCII)
MOST_SECONDS = 120.0
"""Processor time that a command may take for a file that was received, s."""
MOST_MEMORY = 4_000_000_000
"""Bytes that such work may take."""


@contextmanager
def foreign(kind: Callable[[str], Exception], said: str = "", remedy: str = "") -> Iterator[None]:
    """Whatever is raised while the block reads foreign data becomes an error of this `kind`.

    A parser (ezdxf, svgelements, json, zipfile, numpy, yaml) answers damaged data with errors of any kind, which no
    list holds. What this program says itself (`JumpError`), and a package that is not installed, pass through.

    Parameters
    ----------
    kind : type of Exception, or callable
        What is made of the sentence.
    said : str
        File and what it is not: ``bed.dxf: is no DXF drawing``. The reason follows in brackets, or is all.
    remedy : str
        What to do, after a semicolon.
    """
    try:
        yield
    except (JumpError, ImportError):
        raise
    except Exception as error:
        why = reason(error)
        raise kind((f"{said} ({why})" if said else why) + (f"; {remedy}" if remedy else "")) from error


class _Late(BaseException):
    """Work has taken too long; parsers that catch every Exception do not catch it."""


@contextmanager
def bounded(what: str, remedy: str) -> Iterator[None]:
    """The block is left where it takes more than `MOST_SECONDS` of processor time or `MOST_MEMORY` bytes.

    For the main thread of a command; a page has a process of its own for such work (`served/children.py`).

    Parameters
    ----------
    what : str
        The file.
    remedy : str
        What to do then.

    Raises
    ------
    SetupError
        It was left.
    """

    def late(*_: object) -> None:
        raise _Late

    with within_memory(MOST_MEMORY):
        before = signal.signal(signal.SIGPROF, late)
        signal.setitimer(signal.ITIMER_PROF, MOST_SECONDS, 1.0)  # again each second: a parser may clean up for long
        try:
            yield
        except _Late:
            raise SetupError(f"{what}: took more than {MOST_SECONDS:g} s and was left; {remedy}") from None
        except MemoryError:
            said = f"{what}: takes more than {MOST_MEMORY / 1e9:g} GB of memory and was left; {remedy}"
            raise SetupError(said) from None
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0.0)
            signal.signal(signal.SIGPROF, before)


def reason(error: BaseException) -> str:
    """Why something could not be read, from an error of any kind: one line."""
    if isinstance(error, RecursionError):
        return "parts inside parts, too deep to be read"
    if isinstance(error, MemoryError):
        return "it asks for more memory than there is"
    if callable(get_errors := getattr(error, "errors", None)):  # of pydantic: the first place that is wrong
        first = get_errors()[0]
        return shortened(f"{'.'.join(map(str, first['loc']))}: {first['msg']}".removeprefix(": "))
    if isinstance(error, UnicodeDecodeError):
        return f"is not text: byte {error.start} is not UTF-8"
    if isinstance(error, KeyError):
        return f"{shortened(str(error))} is not in it"
    if isinstance(error, OSError) and error.strerror:
        return error.strerror
    return shortened(" ".join(str(error).split())) or f"a {type(error).__name__} in its reader"


def number_of(text: str) -> float:
    """The number of a text, NaN and infinities too; ValueError for what else Python reads: 4_0, other digits."""
    if NUMBER.fullmatch(text):
        return float(text)
    raise ValueError(f"{text[:60]!r} is no number")


def whole_of(text: str) -> int:
    """The whole number of a text; ValueError as `number_of`."""
    if WHOLE.fullmatch(text):
        return int(text)
    raise ValueError(f"{text[:60]!r} is no whole number")
