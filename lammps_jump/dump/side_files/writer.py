# SPDX-License-Identifier: GPL-2.0-or-later
"""Writer of a file that grows beside the dump: what it takes is with the system for readers at once."""

from __future__ import annotations

from pathlib import Path

from lammps_jump.files import open_to_write, writes


class SideWriter:
    """Writes a file frame by frame, each before its frame goes to the dump.

    Parameters
    ----------
    path : Path
    append : bool
        Write behind what the file holds.
    head : bytes
        What a new file begins with.

    Raises
    ------
    DumpError
        The file cannot be written.
    """

    def __init__(self, path: Path, *, append: bool = False, head: bytes = b""):
        with writes(path):
            self._file = open_to_write(path, append=append)
            if not append:
                self._file.write(head)

    def put(self, rows: bytes) -> None:
        """Write, and hand it to the system for readers."""
        self._file.write(rows)
        self._file.flush()

    def close(self) -> None:
        """Finish the file."""
        self._file.close()
