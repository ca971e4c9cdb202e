# SPDX-License-Identifier: GPL-2.0-or-later
"""The errors a user can meet. Each says the value, what is allowed, where, and what to do."""

from __future__ import annotations

import difflib
from typing import TYPE_CHECKING, Any, ClassVar


class JumpError(Exception):
    """Base of every error that lammps-jump raises on purpose; the command line prints it without a traceback.

    Attributes
    ----------
    exit_status : int
        2 where the input is at fault, 1 where a run failed, 75 where it was interrupted and can go on.
    """

    exit_status = 1


class CaseError(JumpError, ValueError):
    """The case file, a ``--set`` value or a scene made from them cannot be used (exit status 2)."""

    exit_status = 2


class FieldError(CaseError):
    """A field of a case cannot be used. Where the case is read, the place in its file takes that of the path.

    Parameters
    ----------
    path : str
        The field, with dots between its parts: ``walls.2.motion``.
    text : str
        What is wrong, what is allowed and what to do.
    """

    def __init__(self, path: str, text: str):
        super().__init__(f"{path}: {text}")
        self.path, self.text = path, text

    def __reduce__(self) -> tuple[type[FieldError], tuple[str, str]]:
        return type(self), (self.path, self.text)


class ScaleError(CaseError):
    """The unit of a drawing is not known, or the scale that was given is none (exit status 2)."""


class DumpError(JumpError, ValueError):
    """A dump file, or a folder that should hold one, cannot be read (exit status 2)."""

    exit_status = 2


class SetupError(JumpError, RuntimeError):
    """Something is lacking: the engine, a compiler, a folder that may be written to (exit status 2)."""

    exit_status = 2


class ResumeError(JumpError, ValueError):
    """There is no interrupted run of this case to go on with (exit status 2); nothing was touched."""

    exit_status = 2


class RunError(JumpError, RuntimeError):
    """A run that started and failed; what it had is kept (exit status 1).

    Attributes
    ----------
    run : lammps_jump.Run or None
        The run as far as it came; None where it did not start or was not requested through the Python API.
    """

    def __init__(self, message: str = "", run: object | None = None):
        super().__init__(message)
        self.run = run


class RunInterrupted(RunError):
    """A run that the user ended; what it had is kept, and it can go on (exit status 75, EX_TEMPFAIL of sysexits.h)."""

    exit_status = 75


class NearestNames:
    """Answers a name that an object does not have with the nearest one; what a property raised itself passes through.

    Attributes
    ----------
    in_words : str
        What an object of the class is, for the message: "a run".
    habits : dict of str to str
        Names that other libraries have for something of the class, and what is written here. The name ``[]`` is that of
        brackets after the object.
    """

    in_words = "this object"
    habits: ClassVar[dict[str, str]] = {}

    def _missing(self, name: str) -> Any:
        """Raise the AttributeError for a name that is not there."""
        if name.startswith("_") or hasattr(type(self), name):
            return object.__getattribute__(self, name)  # raises what a property lacked
        if name in self.habits:
            raise AttributeError(f"{self.in_words} has no '{name}'; write {self.habits[name]}", name=name, obj=None)
        known = sorted(one for one in dir(self) if not one.startswith("_"))
        close = difflib.get_close_matches(name, known, n=1, cutoff=0.6)
        close = close or [one for one in known if name in one or one in name][:1]
        hint = f"did you mean '{close[0]}'?" if close else f"use one of {', '.join(known)}"
        raise AttributeError(f"{self.in_words} has no '{name}'; {hint}", name=name, obj=None)

    def _no_item(self, key: object) -> Any:
        """Raise the TypeError for brackets, or a loop, where there are none."""
        hint = self.habits.get("[]", "one of its names behind a dot")
        raise TypeError(f"{self.in_words} has no items; write {hint}")

    if not TYPE_CHECKING:
        __getattr__ = _missing
        __getitem__ = _no_item
