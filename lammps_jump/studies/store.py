# SPDX-License-Identifier: GPL-2.0-or-later
"""One JSON file of finished pieces for each study; an interrupted study continues from it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from lammps_jump.files import plain, read_json, write_json
from lammps_jump.provenance import machine

from .runs import versions

Piece = TypeVar("Piece")
Say = Callable[[str], None]
"""Takes one line of progress."""
Results = dict
"""Results of a study, as they stand in its JSON file: plain data."""


class Store:
    """Finished pieces of a study, each under its key.

    Parameters
    ----------
    path : Path
        JSON file, written after every piece; a second file is written first and renamed, so it is always complete.
    fresh : bool
        Ignore what is stored.
    """

    def __init__(self, path: Path, *, fresh: bool = False):
        self.path = path
        self.data: dict = {}
        if not fresh and path.is_file():
            try:
                self.data = read_json(path)
            except ValueError:
                self.data = {}
        self.data.setdefault("pieces", {})

    @property
    def pieces(self) -> dict:
        """Finished pieces by key, as they stand in the JSON file."""
        return self.data["pieces"]

    def piece(self, key: str, make: Callable[[], Piece], kind: type[Piece] | None = None) -> Piece:
        """Return the stored piece; make and store it where it is missing.

        Parameters
        ----------
        key : str
        make : callable
            Returns the piece, a dataclass or plain data.
        kind : type, optional
            Dataclass of the piece; without it, plain data is returned.
        """
        if key not in self.pieces:
            self.pieces[key] = plain(make())
            self.save()
        found = self.pieces[key]
        return kind(**found) if kind else found

    def save(self) -> None:
        """Write the file; NaN and infinities become null."""
        self.path.parent.mkdir(parents=True, exist_ok=True)
        write_json(self.path, self.data)

    def finish(self, **results: object) -> None:
        """Store results of the whole study beside the pieces, with versions and machine."""
        self.data |= plain(results) | {"versions": versions(), "machine": machine()}
        self.save()

    def write_table(self, text: str) -> str:
        """Write Markdown beside the JSON file, under the same stem; returns the text."""
        self.path.with_suffix(".md").write_text(text)
        return text
