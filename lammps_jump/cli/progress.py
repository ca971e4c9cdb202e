# SPDX-License-Identifier: GPL-2.0-or-later
"""Progress of a run on the screen: simulated time, discs in play, speed, time left; then its results."""

from __future__ import annotations

import shutil
import sys
import textwrap
import time
from collections.abc import Callable, Mapping, Sequence
from math import floor, isnan, log10
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

from lammps_jump import analysis
from lammps_jump.engines.result import Progress
from lammps_jump.quoting import terminal_text, typed

if TYPE_CHECKING:
    import rich.progress

    from lammps_jump.calibration import SearchProgress as CalibrationProgress
    from lammps_jump.sweeps import SweepProgress

PLAIN_INTERVAL = 10.0
"""Seconds between lines where the output is no terminal, so that a log file is not filled with them."""
LIVE_INTERVAL = 0.5
"""Seconds between pictures of the bar on a terminal."""


class ProgressLine:
    """Prints `Progress` reports: a bar on a terminal, elsewhere a line every ten seconds.

    The first report starts the clock and shows nothing: before it the C++ is compiled, or the engine starts.

    Parameters
    ----------
    end_time : float
        Simulated time at the end of the run, s.
    quiet : bool
        Print nothing.
    stream : file, optional
        Default stderr.
    fixed : int
        Discs of rough beds, which it leaves out.
    clock : callable
        Seconds from any origin.
    """

    def __init__(
        self,
        end_time: float,
        *,
        quiet: bool = False,
        stream: TextIO | None = None,
        fixed: int = 0,
        clock: Callable[[], float] = time.perf_counter,
    ):
        self.end_time, self.quiet, self.fixed, self.clock = end_time, quiet, fixed, clock
        self.stream = stream or sys.stderr
        self.live = self.stream.isatty()
        self.begin = self.shown = clock()
        self.first_step: int | None = None
        self.step = 0
        self.doing = ""
        self._bar: rich.progress.Progress | None = None

    def __call__(self, report: Progress) -> None:
        """Show one report."""
        if self.first_step is None:
            self.first_step = self.step = report.step
            self.begin = self.shown = self.clock()
            if not report.doing:
                return
        news, self.doing = report.doing != self.doing, report.doing
        seconds = self._time_to_show(at_once=news and self.live)
        if not seconds:
            return
        if report.doing:
            self._show(1.0, f"{self._clock_of(report)}  {report.doing}")
            return
        rate = (report.step - self.step) * report.discs / seconds
        self.step = report.step
        here = report.step - self.first_step
        left = (self.shown - self.begin) * (report.steps - report.step) / here if here > 0 else None
        share = report.step / max(report.steps, 1)
        threads = f"  {report.threads} threads" if report.threads > 1 else ""
        self._show(
            share,
            f"{self._clock_of(report)}  {100 * share:z3.0f} %  "
            f"{report.discs - self.fixed} discs  {rate / 1e6:z.1f} M disc-steps/s{threads}"
            f"{'' if left is None else f'  {_duration(left)} left'}",
        )

    def _clock_of(self, report: Progress) -> str:
        decimals = max(3, 3 - floor(log10(self.end_time)))  # a run of small discs lasts less than a millisecond
        return f"t = {report.time:z.{decimals}f} of {self.end_time:zg} s"

    def _time_to_show(self, *, at_once: bool = False) -> float:
        """Seconds since the last picture or line; 0 where it is too early for another."""
        seconds = self.clock() - self.shown
        if self.quiet or (seconds < (LIVE_INTERVAL if self.live else PLAIN_INTERVAL) and not at_once):
            return 0.0
        self.shown += seconds
        return seconds

    def _show(self, share: float, text: str) -> None:
        if self.live:
            self._draw(share, text)
        else:
            print(text, file=self.stream, flush=True)

    def _draw(self, share: float, text: str) -> None:
        if self._bar is None:
            from rich.console import Console  # 40 ms, for terminals only
            from rich.progress import BarColumn, TextColumn
            from rich.progress import Progress as Bar

            columns = BarColumn(bar_width=20), TextColumn("{task.description}", markup=False)
            console = Console(file=getattr(self.stream, "terminal", self.stream))
            self._bar = Bar(*columns, console=console, auto_refresh=False, redirect_stdout=False, redirect_stderr=False)
            self._bar.add_task("", total=1.0)
            self._bar.start()
        self._bar.update(self._bar.task_ids[0], completed=share, description=text, refresh=True)

    def finish(self) -> None:
        """Leave the bar."""
        if self._bar is not None:
            self._bar.stop()
            self._bar = None


class StudyLine(ProgressLine):
    """Prints how far the runs of a study have come, as `ProgressLine` does of one run."""

    def __init__(self, **options: Any):
        super().__init__(0.0, **options)
        self.disc_steps = 0.0

    def __call__(self, report: SweepProgress) -> None:  # type: ignore[override]
        """Show one report."""
        seconds = self._time_to_show()
        if not seconds:
            return
        if report.disc_steps < self.disc_steps:  # members were added, and the count begins again
            self.disc_steps = 0.0
        rate, self.disc_steps = (report.disc_steps - self.disc_steps) / seconds, report.disc_steps
        left = (self.shown - self.begin) * (1 - report.share) / report.share if report.share > 0 else float("nan")
        failed = f", {report.failed} failed" if report.failed else ""
        self._show(
            report.share,
            f"{report.done} of {report.total} runs done{failed}  {rate / 1e6:z.1f} M disc-steps/s  "
            f"{_duration(left)} left",
        )


BESIDE_TEXT = 22
"""Columns of the bar."""


class CalibrationLine(ProgressLine):
    """Prints how far a calibration has come, as `StudyLine` does, with the best values so far and their ranges."""

    def __init__(self, **options: Any):
        super().__init__(0.0, **options)
        self.best = ""

    def __call__(self, report: CalibrationProgress) -> None:  # type: ignore[override]
        """Show one report; other best values at once."""
        news, self.best = report.best != self.best, report.best
        if self._time_to_show(at_once=news):
            failed = f", {report.failed} failed" if report.failed else ""
            best = f"  {report.best}" if report.best else ""
            text = f"{report.done} runs of at most {report.budget}{failed}{best}"
            room = shutil.get_terminal_size().columns - BESIDE_TEXT
            self._show(report.share, f"{text[: room - 1]}…" if self.live and len(text) > room else text)


MOST_LINES = 12
WIDEST = 100
"""Lines and columns of what a terminal shows at the end of a run."""


def print_summary(summary: Mapping[str, Any], folder: Path, *, verbose: bool = False) -> None:
    """Prints the result of a run or a bare dump: on a terminal `ending`; in a pipe, or on request, all numbers."""
    page = folder / "report.html"
    if sys.stdout.isatty() and not verbose:
        rows = analysis.tables.rows_of([summary])
        about = analysis.tables.lines(summary)
        about += [analysis.tables.sure(summary)] if rows else []
        about += filter(None, (row.reason() for row in rows))
        about += [f"doubtful: {text}" for text in analysis.verdicts.doubts(summary)]
        about += [_spent(summary)] if "discs" in summary else []
        said = analysis.verdicts.verdict(summary)
        place = folder if page.exists() else None
        print("\n".join(ending(said, rows, about, place, summary.get("warnings") or [])))
        return
    for line in analysis.main_numbers(summary):
        print(line)
    if "discs" in summary:
        discs, seconds = summary["discs"], summary["wall_seconds"]
        rate = summary.get("disc_steps_per_second") or 0.0
        print(
            f"discs: {discs['inserted']} inserted = {discs['present']} present + {discs['removed']} removed, "
            f"{discs['lost']} lost\n"
            f"time: build {seconds['build']:z.2f} s, run {seconds['run']:z.2f} s ({rate / 1e6:z.1f} M disc-steps/s), "
            f"analysis {seconds['analysis']:z.2f} s"
        )
    for warning in summary.get("warnings", []):
        print(f"note: {warning}")
    if page.exists():
        print(f"report: {page}")


def _spent(summary: Mapping[str, Any]) -> str:
    discs, seconds = summary["discs"], summary["wall_seconds"]
    return (
        f"time: {seconds['run']:z.1f} s run, {seconds['analysis']:z.1f} s analysis; discs: {discs['inserted']} in, "
        f"{discs['removed']} out, {discs['present']} at the end"
    )


def show_markdown(text: str) -> None:
    """Print Markdown: drawn by rich on a terminal, as it is in a file or a pipe. Its own escape sequences are shown."""
    if not sys.stdout.isatty():
        print(text)
        return
    from rich.console import Console  # 0.08 s
    from rich.markdown import Markdown

    console = Console(file=getattr(sys.stdout, "terminal", sys.stdout))
    console.print(Markdown(terminal_text(text)))


def ending(
    said: str, rows: Sequence[Any], about: Sequence[str], folder: Path | None, notes: Sequence[str], width: int = 0
) -> list[str]:
    """The end of a run or study for a terminal: verdict, table, error bars, time, notes, command of the page.

    Parameters
    ----------
    said : str
        Verdict.
    rows : sequence of Row
        Of `analysis.tables`.
    about : sequence of str
        One line each: error bars; time and discs.
    folder : Path or None
        Holds the page.
    notes : sequence of str
        Those without room are counted.
    width : int
        Columns; by default those of the terminal, at most `WIDEST`.
    """
    wide = width or min(WIDEST, shutil.get_terminal_size().columns)
    above = [*textwrap.wrap(said, wide), *(analysis.tables.table(rows, wide) if rows else [])]
    above += [line for text in about for line in textwrap.wrap(text, wide)]
    below = [f"page: {typed('show', folder)}"] if folder is not None else []
    lines = [line for text in notes for line in textwrap.wrap(f"note: {text}", wide, subsequent_indent="  ")]
    if lines and len(above) + len(lines) + len(below) > MOST_LINES:
        count = f"{len(notes)} note{'s' * (len(notes) > 1)}"
        lines = [f"{count} on the page" if folder is not None else f"{count}: --verbose shows more"]
    return [*above, *lines, *below]


def _duration(seconds: float) -> str:
    if isnan(seconds):
        return "?"
    if seconds < 90:
        return f"{seconds:z.0f} s"
    return f"{seconds / 60:z.0f} min" if seconds < 5400 else f"{seconds / 3600:z.1f} h"
