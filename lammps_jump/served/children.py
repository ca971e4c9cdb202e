# SPDX-License-Identifier: GPL-2.0-or-later
"""Runs that the server has started: each is the command that the page shows, in a process of its own."""

from __future__ import annotations

import signal
import subprocess
import sys
import threading
from collections import deque
from pathlib import Path

from lammps_jump.errors import RunInterrupted, SetupError
from lammps_jump.quoting import as_word, typed

MOST_LINES = 40
"""Last lines of a command that are kept."""


class ServedChild:
    """One command.

    Attributes
    ----------
    folder : Path
        What it writes.
    command : str
        As one types it.
    """

    def __init__(self, folder: Path, *words: str | Path):
        self.folder, self.command = folder, typed(*words)
        self._lines: deque[str] = deque(maxlen=MOST_LINES)
        # a session of its own: what ends this server does not end the run half way, see `Children.close`
        self.process = subprocess.Popen(
            [sys.executable, "-P", "-m", "lammps_jump", *map(as_word, words)], stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace", start_new_session=True,
        )  # fmt: skip
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        assert self.process.stdout is not None
        with self.process.stdout as stream:
            for line in stream:
                self._lines.append(line.rstrip())

    @property
    def lines(self) -> list[str]:
        """Last lines that it has printed."""
        return list(self._lines)

    @property
    def status(self) -> int | None:
        """Its exit status; None while it goes on."""
        return self.process.poll()

    @property
    def farewell(self) -> str:
        """Outcome, and the command that goes on with what was stopped."""
        if self.status == RunInterrupted.exit_status:
            return f"stopped, and can go on: {typed('run', self.folder, '--resume')}"
        return f"ended with status {self.status}: {self.command}"

    def stop(self) -> None:
        """Ask it to save its state and end."""
        if self.status is None:
            self.process.send_signal(signal.SIGTERM)

    def wait(self) -> int:
        """Wait for its end, and for what it prints."""
        status = self.process.wait()
        self._reader.join()
        return status


class Children:
    """All of them, by the folder that each writes."""

    def __init__(self) -> None:
        self._of: dict[Path, ServedChild] = {}
        self._lock = threading.Lock()

    def start(self, folder: Path, *words: str | Path) -> ServedChild:
        """Run a command that writes a folder.

        Raises
        ------
        SetupError
            One that was started here writes there already.
        """
        with self._lock:
            before = self.of(folder)
            if before is not None and before.status is None:
                raise SetupError(f"{folder}: a run that was started here still writes there")
            self._of[folder.absolute()] = child = ServedChild(folder, *words)
            return child

    def of(self, folder: Path) -> ServedChild | None:
        """The last command that was started for a folder."""
        return self._of.get(folder.absolute())

    def close(self) -> list[ServedChild]:
        """Ask all that go on to save their state and end, and wait for them; those that were."""
        going = [child for child in self._of.values() if child.status is None]
        for child in going:
            child.stop()
        for child in going:
            child.wait()
        return going
