# SPDX-License-Identifier: GPL-2.0-or-later
"""Start of a command: processes that it will need, and standard output that may be closed, full or ASCII only.

The processes are started before the case is read: they load their libraries meanwhile. Errors in printing never end a
run, and no text commands the terminal.
"""

from __future__ import annotations

import errno
import os
import re
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TextIO

from lammps_jump import engines, sweeps
from lammps_jump.files import read_file
from lammps_jump.quoting import terminal_text

COMMANDS = ("build-and-run", "run", "sweep")
MEMBERS = {"--members", "--until"}
"""Options of a command that runs several members of a case."""
NOTHING = {"--help", "--slurm", "--status", "--table", "--member", "--jobs"}
"""Options of a command that runs nothing in workers, or in as many as it says."""


def start_early(words: list[str]) -> None:
    """Start the engine of a run, or the workers of a study; a wrong guess costs a process that is not used.

    Parameters
    ----------
    words : list of str
        Of the command line, the program's name left out.
    """
    options = {word.partition("=")[0] for word in words}
    if len(words) < 2 or words[0] not in COMMANDS or NOTHING & options:
        return
    if words[0] == "sweep" or MEMBERS & options:
        sweeps.pool.prepare_workers()
        return
    path = Path(words[1]) / "case.yaml" if words[0] == "run" else Path(words[1])
    try:
        named = re.search(rb"(?m)^ *name: *(native|twin)", read_file(path, 1_000_000))
        own = next((name for name in ("native", "twin") if name in words), named and named[1].decode())
    except (OSError, ValueError):
        return  # the command says what is wrong
    engines.prepare_worker(own or "lammps")


class PatientStream:
    """A text stream that ignores what is written after its first error; all else is as of the stream.

    Parameters
    ----------
    stream : file
    shown : callable
        What is written of a text; by default escape sequences are shown, not sent.

    Attributes
    ----------
    trouble : OSError or None
        The first error; None where a reader has closed its end (``| head``).
    """

    def __init__(self, stream: TextIO, shown: Callable[[str], str] = terminal_text):
        self.stream = stream
        self.shown = shown
        self.trouble: OSError | None = None

    def write(self, text: str) -> int:
        """Write; nothing after an error."""
        # bytes are no text: the stream refuses them, by which others tell what kind of stream it is
        self._try(lambda: self.stream.write(self.shown(text) if isinstance(text, str) else text))
        return len(text)

    def flush(self) -> None:
        """Flush; nothing after an error."""
        self._try(self.stream.flush)

    def _try(self, act: Callable[[], object]) -> None:
        try:
            act()
        except OSError as error:
            if error.errno != errno.EPIPE and self.trouble is None:
                self.trouble = error
            with open(os.devnull, "w") as nowhere:
                os.dup2(nowhere.fileno(), self.stream.fileno())  # takes what is still in the buffer

    @property
    def terminal(self) -> PatientStream:
        """The same stream for a program that commands the terminal."""
        return PatientStream(self.stream, str)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.stream, name)


@contextmanager
def patient_output() -> Iterator[PatientStream]:
    """Make stdout and stderr a `PatientStream`, with ``?`` for what their encoding lacks; yield stdout."""
    before = sys.stdout, sys.stderr
    streams = [stream or open(os.devnull, "w") for stream in before]  # None where the shell has closed it
    for stream in streams:
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")
    sys.stdout, sys.stderr = map(PatientStream, streams)
    try:
        yield sys.stdout
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        sys.stdout, sys.stderr = before
