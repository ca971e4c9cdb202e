# SPDX-License-Identifier: GPL-2.0-or-later
"""The progress line on a terminal of 80 columns, as a person sees it: one line, the newest numbers, no escape codes."""

from __future__ import annotations

import fcntl
import os
import pty
import re
import struct
import termios

import pytest

from lammps_jump.calibration import SearchProgress as CalibrationProgress
from lammps_jump.cli.app import PatientStream
from lammps_jump.cli.progress import CalibrationLine, ProgressLine, StudyLine
from lammps_jump.engines.result import Progress
from lammps_jump.sweeps import SweepProgress

WIDTH = 80


class Terminal:
    """A pseudo-terminal; `stream` is what the command line writes to."""

    def __init__(self) -> None:
        self.screen, end = pty.openpty()
        fcntl.ioctl(end, termios.TIOCSWINSZ, struct.pack("HHHH", 24, WIDTH, 0, 0))
        self.stream = PatientStream(os.fdopen(end, "w", encoding="utf-8"))
        self.sent = ""

    def lines(self) -> list[str]:
        """The lines of the screen after all that was written so far."""
        self.stream.flush()
        os.set_blocking(self.screen, False)
        try:
            while part := os.read(self.screen, 65536):
                self.sent += part.decode()
        except BlockingIOError:
            pass
        rows, place = [""], 0
        for code, letter in re.findall(r"\x1b\[([\d;?]*[A-Za-z])|(.)", self.sent, re.DOTALL):
            if code == "2K":
                rows[-1] = ""
            elif letter == "\r":
                place = 0
            elif letter == "\n":
                rows.append("")
            elif letter:
                rows[-1] = rows[-1][:place].ljust(place) + letter + rows[-1][place + 1 :]
                place += 1
            else:
                assert code[-1] in "mhl", code  # colours and the cursor
        return rows

    def close(self) -> None:
        """Give both ends back."""
        self.stream.stream.close()
        os.close(self.screen)


@pytest.fixture
def terminal(monkeypatch):
    monkeypatch.setenv("TERM", "xterm")
    for name in ("COLUMNS", "LINES", "NO_COLOR", "FORCE_COLOR"):
        monkeypatch.delenv(name, raising=False)
    found = Terminal()
    yield found
    found.close()


def test_a_run_has_one_line_with_its_newest_numbers(terminal):
    seconds = iter(range(0, 100, 10))
    line = ProgressLine(10.0, stream=terminal.stream, clock=lambda: next(seconds))
    for step in (0, 1000, 5000):
        line(Progress(step=step, steps=10_000, time=step / 1000, discs=1_000_000))
    [row] = terminal.lines()
    assert len(row) <= WIDTH and row.startswith("━") and "t = 1.000" not in row
    assert row.endswith("t = 5.000 of 10 s   50 %  1000000 discs  400.0 M disc-steps/s  20 s left")
    line(Progress(step=10_000, steps=10_000, time=10.0, discs=1_000_000, doing="analysis: figures"))
    [row] = terminal.lines()
    assert row.endswith("t = 10.000 of 10 s  analysis: figures") and len(row) <= WIDTH
    line.finish()
    assert [row.endswith("analysis: figures"), *terminal.lines()[1:]] == [True, ""]
    assert terminal.sent.endswith("\x1b[?25h")  # the cursor is back


def test_the_time_of_a_short_run_moves_on_the_screen(terminal):
    seconds = iter(range(0, 100, 10))
    line = ProgressLine(1.91616e-4, stream=terminal.stream, clock=lambda: next(seconds))
    for step in (0, 30):
        line(Progress(step=step, steps=60, time=step * 3.1936e-6, discs=1_000_000))
    [row] = terminal.lines()
    assert "t = 0.0000958 of 0.000191616 s   50 %" in row  # was 0.000
    line.finish()


def test_a_study_has_one_line(terminal):
    seconds = iter(range(0, 100, 10))
    line = StudyLine(stream=terminal.stream, clock=lambda: next(seconds))
    line(SweepProgress(done=1, failed=0, total=8, share=0.125, disc_steps=1e7))
    line(SweepProgress(done=4, failed=1, total=8, share=0.5, disc_steps=5e7))
    line.finish()
    row, rest = terminal.lines()
    assert row.endswith("4 of 8 runs done, 1 failed  4.0 M disc-steps/s  20 s left") and len(row) <= WIDTH and not rest


def test_a_calibration_has_one_line_with_the_best_values_so_far(terminal):
    line = CalibrationLine(stream=terminal.stream)
    ranges = "friction 0.41 (0.2 to 0.63), rolling.friction 0.2 (0.05 to 0.38)"
    line(CalibrationProgress(4, 0, 40, 0.1, 0.0, "nearest run: friction 0.3"))
    line(CalibrationProgress(20, 1, 40, 0.525, 0.0, ranges))
    line.finish()
    (shown,) = [one for one in terminal.lines() if one.strip()]
    assert "20 runs of at most 40, 1 failed  friction 0.41 (0.2 to" in shown and shown.rstrip().endswith("…")
