# SPDX-License-Identifier: GPL-2.0-or-later
"""One wrapper for all that reads what comes from outside: whatever a parser throws becomes one sentence."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from .errors import JumpError
from .quoting import shortened


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
        What to do, behind a semicolon.
    """
    try:
        yield
    except (JumpError, ImportError):
        raise
    except Exception as error:
        why = reason(error)
        raise kind((f"{said} ({why})" if said else why) + (f"; {remedy}" if remedy else "")) from error


def reason(error: BaseException) -> str:
    """Why something could not be read, from an error of any kind: one line."""
    if isinstance(error, RecursionError):
        return "parts inside parts, too deep to be read"
    if isinstance(error, MemoryError):
        return "it asks for more memory than there is"
    if isinstance(error, KeyError):
        return f"{shortened(str(error))} is not in it"
    if isinstance(error, OSError) and error.strerror:
        return error.strerror
    return shortened(" ".join(str(error).split())) or f"a {type(error).__name__} in its reader"
