# SPDX-License-Identifier: GPL-2.0-or-later
"""The analysis of a run, while it goes on and at its end: its results are put into their places when all are made.

The summary is written first without an analysis, with status 'unchecked' where the engine came to its end. Whatever
ends the process then, the next one finds a run that is to be analysed. 'complete' is written after the check alone.
"""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, Self

import lammps_jump.runs as runs
from lammps_jump.case.case import ReadCase
from lammps_jump.dump import FrameCheck, damages, force_troubles, read_dump
from lammps_jump.dump.tail import GrowingDump
from lammps_jump.engines import Progress, ProgressCallback, RunResult, Setting
from lammps_jump.engines.checkpoint import remove_checkpoint
from lammps_jump.engines.interrupts import terminate_as_interrupt
from lammps_jump.errors import DumpError, JumpError, RunError, RunInterrupted
from lammps_jump.files import DUMP_NAMES, END_FILE, checksum, delete, text_of, write_text
from lammps_jump.folders import clear, publish, read_marker, staging
from lammps_jump.identity import analysis_key
from lammps_jump.provenance import usable_cores
from lammps_jump.quoting import typed

from .folder import OUTPUTS, case_text, outputs_of, own_files, without
from .summary import compose, write_summary

if TYPE_CHECKING:
    from lammps_jump.analysis.passes import Gathered
    from lammps_jump.analysis.report.frames import FramePacker


class AnalysisThread:
    """A thread that imports the analysis, 0.9 s, and then reads the frames of a run as they are written.

    Frames are read ahead where the engine leaves a core free and its dump can be read while it grows.

    Parameters
    ----------
    case : ReadCase
    folder : Path
        Run folder without a dump of an earlier part.
    setting : Setting
    whole : bool
        The run is not the continuation of another one.
    """

    def __init__(self, case: ReadCase, folder: Path, setting: Setting, *, whole: bool):
        self.check = FrameCheck(case.scene())
        self._case, self._folder = case, folder
        self._gathered: Gathered | None = None
        self.packer: FramePacker
        self._ended = threading.Event()
        kind = setting.dump_format
        self._dump = GrowingDump(folder / DUMP_NAMES[kind], kind, self._ended)
        self._follows = whole and kind in ("text", "binary") and setting.ranks < usable_cores()
        self._thread = threading.Thread(target=self._work, name="analysis")

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *error: object) -> None:
        self._dump.given_up = True
        self._ended.set()
        self._thread.join()

    def _work(self) -> None:
        try:
            self._follow()
        except Exception:  # where the program is at its end, what is still to be loaded cannot be
            if threading.main_thread().is_alive():
                raise

    def _follow(self) -> None:
        with suppress(JumpError, OSError):  # what is wrong with the files is said when they are read again
            runs.results.load(self._case)
            if self._follows:
                flow = runs.results.flow_of(self._case, self._folder)
                self.packer = runs.results.packer_for(self._case, flow)
                watch = (self.packer, self.check) if runs.results.has_player(self._case) else (self.check,)
                self._gathered = runs.results.collect(self._case, flow, self._folder, self._dump, *watch)

    def result(self, outputs: Mapping[str, Mapping[str, int | str]], waiting: Callable[[int], None]) -> Gathered | None:
        """Gathered frames of a run that has ended; None where the dump among its `outputs` is still to be read.

        `waiting` is called with the number of frames read so far.
        """
        found = outputs.get(self._dump.path.name)
        self._dump.given_up = found is None
        self._ended.set()
        while self._thread.is_alive():
            waiting(self.check.frames)
            self._thread.join(0.2)
        same = found is not None and found["sha256"] == self._dump.read.hexdigest()
        return self._gathered if same else None


log = logging.getLogger(__name__)
STOPPED = "the analysis was stopped; the files of the run are kept, and `{}` analyses them"
NOT_ANALYSED = "the run is not analysed yet: `lammps-jump analyze` on its folder does that"


class SummaryOutcome(NamedTuple):
    """Summary of a run, and what the analysis could not do, in words."""

    summary: dict[str, Any]
    trouble: str


@dataclass
class Conclusion:
    """A run that has ended, in a folder that this process holds.

    Attributes
    ----------
    steady : str
        Why the run was stopped before its end, as steady, drowned or at rest; empty where it was not.
    before : mapping
        Seconds that were spent before.
    progress : callable, optional
    ahead : Ahead, optional
        Has read the frames of a run that came to its end undisturbed; None: the run is analysed again.
    stored : mapping
        The summary of a run that is analysed again; empty where there is none.
    """

    case: ReadCase
    folder: Path
    setting: Setting
    result: RunResult
    steady: str
    before: Mapping[str, float]
    notes: tuple[str, ...]
    progress: ProgressCallback | None = None
    ahead: AnalysisThread | None = None
    stored: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.begin = time.perf_counter() - (self.before.get("analysis") or 0.0)
        self.ended = self.result.status in ("complete", "unchecked")  # the engine came to its end
        self.news = self.ahead is not None or self.result.status == "unchecked"  # a failure is not known yet
        self.outputs: Mapping[str, Mapping[str, int | str]] = {}
        self.phases: dict[str, float] = {}
        self.now = ("", time.perf_counter())
        self.steps = self.result.steps if self.steady else self.case.scene().steps

    def conclude(self) -> None:
        """Check, make and publish; of an interrupted run only the summary is written, for time may be short.

        Raises
        ------
        RunError, RunInterrupted
            As the run has ended; also where what it wrote is not what its schedule asks for.
        DumpError
            The files of a run that is analysed again are not those that it wrote; nothing is changed.
        """
        self.check()
        with staging(self.folder) as stage:
            made = self.make(stage)
            self.publish(stage, made.summary, analysed=not made.trouble)
        if self.steady and self.ahead:
            log.info(f"note: {self.steady}")
        if self.result.status == "failed" and self.news:
            raise RunError(self.result.message)
        if made.trouble:
            raise RunError(f"the run is complete, its dump could not be analysed: {made.trouble}")

    def check(self) -> None:
        """Hold what the engine left against the stored summary, or write the first summary, without an analysis.

        Raises
        ------
        RunInterrupted
            The run was interrupted; its summary is written.
        DumpError
            See `conclude`.
        """
        stored, interrupted = self.stored, self.ahead is not None and self.result.status == "interrupted"
        self.outputs = outputs_of(self.folder, (END_FILE,) if interrupted else OUTPUTS)
        if stored:  # whoever begins from the end wants the one that the run wrote; the analysis does not read it
            end = (stored.get("outputs") or {}).get(END_FILE)
            self.outputs = {**without(self.outputs, END_FILE), **({END_FILE: end} if end else {})}
        if stored.get("status") == "complete" and (changed := self._changed(stored)):
            raise DumpError(
                f"{self.folder}: is not what the run wrote: {'; '.join(changed)}. Nothing was changed; put the files "
                "back, or run the case again with --force"
            )
        if self.ahead is not None:
            if self.ended:
                self.result = replace(self.result, status="unchecked")
            self._write(self._summary({"warnings": [NOT_ANALYSED]}), None)
        if interrupted:
            raise RunInterrupted(self.result.message)
        self._forget_checkpoints()

    def _forget_checkpoints(self) -> None:
        """Delete what a run needs to go on, where the summary says that it will not."""
        if self.ended or (self.result.status == "failed" and not self.result.outside):
            remove_checkpoint(self.folder)
            delete(self.folder / "in.resume.lammps")

    def _changed(self, stored: Mapping[str, Any]) -> list[str]:
        """Files that are not as the summary says, and what is wrong with them."""
        known = stored.get("outputs") or {}
        names = [name for name, entry in known.items() if self.outputs.get(name) != entry]
        if not names:
            return []
        check = FrameCheck(self.case.scene())
        try:
            dump = read_dump(self.folder)
            for frame in dump:
                check.add(frame, self.case.scene().time(frame.step) if frame.time is None else frame.time)
            troubles = [*check.result(self.steps, self.result.present), *damages(dump.warnings)]
        except DumpError as error:
            troubles = [str(error)]
        troubles += force_troubles(self.folder / "forces.csv", self.case.scene(), self.steps)
        return [*(f"{name} {'differs' if name in self.outputs else 'is gone'}" for name in names), *troubles]

    def _phase(self, name: str, more: str = "") -> None:
        """Say what is done from now on, and keep the seconds of what was done before."""
        before, since = self.now
        if before:
            self.phases[before] = self.phases.get(before, 0.0) + time.perf_counter() - since
        self.now = (name, time.perf_counter())
        if self.progress is not None and name:
            scene, result = self.case.scene(), self.result
            doing = f"analysis: {name}{more}"
            self.progress(Progress(result.steps, scene.steps, scene.time(result.steps), result.present, doing))

    def _read(self, frames: int) -> None:
        self._phase("reading", f" frame {frames} of {self.steps // self.case.scene().output_steps + 1}")

    def _summary(self, parts: Mapping[str, Any]) -> dict[str, Any]:
        seconds = {"build": self.before.get("build") or 0.0, "run": self.result.seconds}
        seconds["analysis"] = time.perf_counter() - self.begin
        report = {
            "analysis_seconds": self.phases,
            **parts,
            **({"stopped_when_steady": self.steady} if self.steady else {}),
        }
        return compose(self.case, self.setting, self.result, seconds=seconds, parts=report, notes=self.notes)

    def _write(self, summary: Mapping[str, Any], analysis: Mapping[str, Any] | None) -> None:
        write_summary(self.folder, {**summary, "outputs": self.outputs, "analysed": analysis})

    def make(self, stage: Path) -> SummaryOutcome:
        """Analyses the run and judges it; summary and report are made, tables and figures are in `stage`."""
        flow, trouble = runs.results.flow_of(self.case, self.folder), ""
        check, packer = FrameCheck(self.case.scene()), runs.results.packer_for(self.case, flow)
        note = self.result.message if self.ahead is None else ""
        try:
            with signals_end(STOPPED.format(typed("analyze", self.folder))):
                self._phase("reading")
                whole = self.outputs if self.ended and not self.steady else {}
                gathered = self.ahead.result(whole, self._read) if self.ahead else None
                if self.ahead and gathered is not None:
                    check, packer = self.ahead.check, self.ahead.packer
                watch = [check] if self.ended else []
                among = (self.case, flow, self.folder, stage, packer, watch)
                parts, player = runs.results.analyse(*among, gathered, self._phase)
        except DumpError as error:
            if self.ahead is None:
                raise
            trouble = str(error)
            parts = {"warnings": [f"not analysed: {trouble}"]}
            player = runs.results.packed_player(packer, stage)
        parts.setdefault("warnings", [])
        if self.ended:
            self._judge(check, parts["warnings"], trouble)
        if note and self.result.status != "failed":
            parts["warnings"].append(note)
        self._phase("report")
        summary = self._summary(parts) | {key: self.stored[key] for key in ("case_hash", "key") if key in self.stored}
        if runs.results.has_page(self.case):
            runs.results.write_report(
                stage, summary | {"outputs": self.outputs}, self.case, player, run_folder=self.folder
            )
        elif runs.results.has_player(self.case) and player is not None:
            runs.results.write_player(stage, player)
        self._phase("")
        summary["analysis_seconds"] = dict(self.phases)
        return SummaryOutcome(summary, trouble)

    def publish(self, stage: Path, summary: Mapping[str, Any], *, analysed: bool) -> None:
        """Puts what is in `stage` into its place, then writes the summary with the key of its analysis."""
        folder = self.folder
        self._write(summary, None)  # ended between here and the last line: it is analysed again
        clear(folder, {"report.html", *self.stored.get("files", ())} & set(own_files(read_marker(folder))))
        names = publish(stage, folder)
        text, path = case_text(self.case), folder / "case.yaml"
        if not path.exists() or text_of(path, "replace") != text:
            write_text(path, text)
        files = {name: checksum(folder / name) for name in names}
        key = analysis_key(self.case.rest, self.outputs)
        self._write(summary, {"key": key, "files": files} if analysed else None)

    def _judge(self, check: FrameCheck, warnings: list[str], trouble: str) -> None:
        """Call the run complete where it is, else failed, with what is wrong; DumpError where it was complete."""
        result, steps = self.result, self.steps
        troubles = [] if result.steps == steps else [f"{result.steps} of {steps} steps"]
        troubles += [f"dump: {text}" for text in check.result(steps, result.present)]
        troubles += damages(warnings)
        troubles += force_troubles(self.folder / "forces.csv", self.case.scene(), steps)
        if result.lost:
            troubles.append(f"{result.inserted} discs inserted, {result.present} present, {result.removed} removed")
        if not troubles:
            self.result = replace(result, status="complete", message="")
            return
        reason = "; ".join([*troubles, *([trouble] if trouble else [])])
        message = (
            f"the run came to its end, but what it wrote is not whole: {reason}. "
            f"It is kept in {self.folder}; look for a full disk or a program that failed, and run again with --force"
        )
        if result.status == "complete":
            raise DumpError(message)
        self.result = replace(result, status="failed", message=message)


@contextmanager
def signals_end(message: str) -> Iterator[None]:
    """Signals while the block runs become a `RunInterrupted` that says what is left to do."""
    try:
        with terminate_as_interrupt():
            yield
    except KeyboardInterrupt:
        raise RunInterrupted(message) from None
