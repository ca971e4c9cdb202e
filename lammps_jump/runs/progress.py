"""One live line while a run goes on: simulated time, discs in play, speed, time left."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from math import isnan
from typing import TextIO

from lammps_jump.engines.result import Progress

PLAIN_INTERVAL = 10.0
"""Seconds between lines where the output is no terminal (a log file is not filled with progress)."""


class ProgressLine:
    """Prints `Progress` reports; on a terminal it rewrites one line, elsewhere a line every ten seconds.

    Parameters
    ----------
    end_time : float
        Simulated time at the end of the run, s.
    quiet : bool
        Print nothing.
    stream : file, optional
        Default stderr.
    first_step : int
        Where this part of the run begins.
    clock : callable
        Seconds from any origin.
    """

    def __init__(
        self,
        end_time: float,
        *,
        quiet: bool = False,
        stream: TextIO | None = None,
        first_step: int = 0,
        clock: Callable[[], float] = time.perf_counter,
    ):
        self.end_time = end_time
        self.quiet = quiet
        self.stream = stream or sys.stderr
        self.live = self.stream.isatty()
        self.clock = clock
        self.begin = clock()
        self.shown = self.begin
        self.first_step = first_step
        self.previous = (self.begin, first_step)
        self.rate = 0.0

    def __call__(self, report: Progress) -> None:
        """Show one report."""
        now = self.clock()
        interval = 0.5 if self.live else PLAIN_INTERVAL
        if self.quiet or now - self.shown < interval:
            return
        if now > self.previous[0]:
            self.rate = (report.step - self.previous[1]) * report.discs / (now - self.previous[0])
        self.previous = (now, report.step)
        self.shown = now
        done = report.step / max(report.steps, 1)
        here = report.step - self.first_step
        left = (now - self.begin) * (report.steps - report.step) / here if here > 0 else float("nan")
        text = (
            f"t = {report.time:.3f} of {self.end_time:g} s  {100 * done:3.0f} %  {report.discs} discs  "
            f"{self.rate / 1e6:.1f} M disc-steps/s  {_duration(left)} left"
        )
        self.stream.write(f"\r{text:<78}" if self.live else text + "\n")
        self.stream.flush()

    def finish(self) -> None:
        """Leave the line."""
        if self.live and not self.quiet and self.previous[1]:
            self.stream.write("\n")
            self.stream.flush()


def _duration(seconds: float) -> str:
    if isnan(seconds):
        return "?"
    if seconds < 90:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 5400 else f"{seconds / 3600:.1f} h"
