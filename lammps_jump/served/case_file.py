# SPDX-License-Identifier: GPL-2.0-or-later
"""The case file that is open: read, and written whole, unless another program has changed it meanwhile."""

from __future__ import annotations

import hashlib
import stat
from pathlib import Path
from threading import Lock
from typing import NamedTuple

from lammps_jump.case.text import read_text
from lammps_jump.errors import SetupError
from lammps_jump.files import write_bytes, writes


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
        self.shown, self.path = path, path.resolve()
        self._lock = Lock()
        self.read()

    def read(self) -> HashedText:
        """The text, with plain ends of lines as a page has them."""
        text = read_text(self.path)
        return HashedText(text.replace("\r\n", "\n"), hashlib.sha256(text.encode()).hexdigest())

    def save(self, text: str, key: str) -> HashedText | None:
        """Write a text over the one with this key; None, and nothing is written, where the file holds another one.

        Ends of lines and permissions stay as they are.

        Raises
        ------
        CaseError, SetupError
            The file is gone, or cannot be written.
        """
        with self._lock:
            there = read_text(self.path)
            if hashlib.sha256(there.encode()).hexdigest() != key:
                return None
            written = text.replace("\n", "\r\n") if "\r\n" in there else text
            if written != there:
                with writes(self.shown, SetupError, "correct the permissions of file and folder"):
                    write_bytes(self.path, written.encode(), stat.S_IMODE(self.path.stat().st_mode))
            return self.read()
