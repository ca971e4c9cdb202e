# SPDX-License-Identifier: GPL-2.0-or-later
"""The case file that is open: read, and written whole, unless another program has changed it meanwhile."""

from __future__ import annotations

import hashlib
from pathlib import Path
from threading import Lock
from typing import NamedTuple

from lammps_jump.case.text import read_text
from lammps_jump.errors import SetupError
from lammps_jump.files import END_OF_LINE, change_text, real_path, writes


class HashedText(NamedTuple):
    """A text, and a hash that says whether it is still the same."""

    text: str
    key: str


class CaseFile:
    """One case file.

    Parameters
    ----------
    path : Path
        Where it is a link, the file that it leads to is meant.

    Raises
    ------
    CaseError
        As `read_text`.
    """

    def __init__(self, path: Path):
        self.shown, self.path = path, real_path(path)
        self._lock = Lock()
        self.read()

    def read(self) -> HashedText:
        """The text, with the ends of lines that a page has."""
        text = read_text(self.path)
        return HashedText(END_OF_LINE.sub("\n", text), _key(text))

    def save(self, text: str, key: str) -> HashedText | None:
        """Write a text over the one with this key; None, and nothing is written, where the file holds another one.

        See `change_text`.

        Raises
        ------
        CaseError, SetupError
            The file is gone, or cannot be written.
        """
        with self._lock:
            there = read_text(self.path)
            if _key(there) != key:
                return None
            with writes(self.shown, SetupError, "correct the permissions of file and folder"):
                saved = change_text(self.path, there, text)
            return HashedText(text, _key(saved)) if saved is not None else None


def _key(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()
