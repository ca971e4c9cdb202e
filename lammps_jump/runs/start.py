# SPDX-License-Identifier: GPL-2.0-or-later
"""Run a case: choose the setting, write the folder, run the engine, analyse, summarise, report."""

from __future__ import annotations

import importlib
import logging
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import lammps_jump.engines as engines
import lammps_jump.runs as runs
from lammps_jump.case.case import ReadCase, load_case
from lammps_jump.engines.accuracy import with_accuracy
from lammps_jump.engines.checkpoint import Checkpoint, remove_checkpoint
from lammps_jump.engines.interrupts import terminate_as_interrupt
from lammps_jump.engines.lammps.job import write_job
from lammps_jump.engines.result import ProgressCallback, RunResult
from lammps_jump.engines.setting import Job, Setting
from lammps_jump.errors import CaseError, DumpError, RunError, RunInterrupted
from lammps_jump.files import RESULT_FILES, clear, writing

from .engine import choose_setting, with_header
from .folder import require_case, result_of, stored_result, write_folder
from .resume import resumable
from .summary import compose, read_summary, write_summary

log = logging.getLogger(__name__)
"""Says what is done, and notes; the command line prints it."""
StopCallback = Callable[[], bool]


@dataclass(frozen=True)
class Order:
    """A run that is asked for: the case with all that was chosen for it, and the callbacks.

    Attributes
    ----------
    case : ReadCase
    folder : Path
    setting : Setting
    notes : tuple of str
        Why this setting was chosen.
    progress, should_stop : callable, optional
        As of `lammps_jump.run`.
    """

    case: ReadCase
    folder: Path
    setting: Setting
    notes: tuple[str, ...]
    progress: ProgressCallback | None = None
    should_stop: StopCallback | None = None


def start(
    case: ReadCase,
    folder: Path,
    *,
    force: bool = False,
    resume: bool = False,
    progress: ProgressCallback | None = None,
    should_stop: StopCallback | None = None,
) -> None:
    """Run a case in a folder and analyse it; nothing is done where the folder already holds the result.

    Parameters as of `lammps_jump.run`, errors too.
    """
    begin = time.perf_counter()
    if resume and force:
        raise CaseError("--resume goes on with a run, --force starts a new one: use one of the two")
    case, chosen = with_accuracy(case)
    setting, notes = choose_setting(case)
    order = Order(case, folder, setting, (*chosen, *notes), progress, should_stop)
    if resume:
        return _go_on(order)
    stored = None if force else stored_result(case, folder, setting)
    if stored is not None:
        log.info(
            f"{folder} already holds this run ({stored['steps']} steps, {stored['wall_seconds']['run']:.1f} s "
            "of computing): nothing to do. --force runs it again."
        )
        return
    _announce(order)
    write_folder(case, folder)
    _execute(order, {"build": time.perf_counter() - begin, "analysis": 0.0})


def build(case: ReadCase, folder: Path, *, job: bool = False) -> Setting:
    """Write the run folder of a case and stop there; with `job` also a job file for a cluster. The setting chosen.

    Raises
    ------
    CaseError, SetupError
    """
    case, _ = with_accuracy(case)
    setting, _ = choose_setting(case)
    write_folder(case, folder)
    engines.write_inputs(Job(case.scene(), folder, with_header(case, setting), Path.cwd()))
    if job:
        write_job(case.scene(), folder, setting.ranks)
    return setting


def run_folder(folder: Path, *, resume: bool = False, progress: ProgressCallback | None = None) -> None:
    """Run what `build` has written, or go on with the interrupted run there; errors as of `start`."""
    case, setting, notes = reopen(folder)
    order = Order(case, folder, setting, notes, progress)
    if resume:
        return _go_on(order)
    write_folder(case, folder)
    _execute(order, {"build": 0.0, "analysis": 0.0})


def reopen(folder: Path, changes: Sequence[str] = ()) -> tuple[ReadCase, Setting, tuple[str, ...]]:
    """The case of a run folder, the setting of its run, and notes on it.

    Raises
    ------
    CaseError
        The folder holds no ``case.yaml``.
    """
    case, chosen = with_accuracy(load_case(require_case(folder), changes))
    setting, notes = choose_setting(case)
    stored = read_summary(folder)
    if stored and stored.get("kernel") in ("stock", "compiled") and setting.kernel != "numba":
        setting = replace(setting, kernel=stored["kernel"])
    return case, setting, (*chosen, *notes)


def reanalyse(folder: Path, changes: Sequence[str] = ()) -> None:
    """Analyse a run folder again and rewrite its summary and report.

    Parameters
    ----------
    changes : sequence of str
        ``analysis.…=value``: what else is asked of the run.

    Raises
    ------
    CaseError
        No run folder, or a change of the run itself.
    DumpError
        No dump that can be read.
    RunInterrupted
        The analysis was ended by Ctrl-C or SIGTERM.
    """
    for change in changes:
        if change.split("=")[0].split(".")[0].strip() != "analysis":
            raise CaseError(
                f"--set {change}: belongs to the run, which is done; allowed here is analysis.…: a run with other "
                f"values is a new one: `lammps-jump build-and-run {folder / 'case.yaml'} --set {change} --out …`"
            )
    case, setting, notes = reopen(folder, changes)
    stored = read_summary(folder)
    begin = time.perf_counter()
    with _analysis_of(folder), writing(folder):
        result = result_of(case, folder, stored, setting)
        parts = runs.results.analyse(case, folder)
    seconds = {"build": 0.0, "run": result.seconds, **((stored or {}).get("wall_seconds") or {})}
    seconds["analysis"] = time.perf_counter() - begin
    if result.status in ("interrupted", "complete") and result.message:
        parts.setdefault("warnings", []).append(result.message)
    summary = compose(case, setting, result, seconds=seconds, parts=parts, notes=notes)
    summary["case_hash"] = (stored or {}).get("case_hash", summary["case_hash"])
    (folder / "case.yaml").write_text(case.to_yaml())
    write_summary(folder, summary)
    runs.results.write_report(folder, summary, case)


def _announce(order: Order) -> None:
    scene, c, setting = order.case.scene(), order.case.scene().coefficients, order.setting
    for note in (*scene.warnings, *order.notes):
        log.info(f"note: {note}")
    ranks = f", {setting.ranks} ranks" if setting.ranks > 1 else ""
    log.info(
        f"{scene.name}: {setting.engine} ({setting.kernel}{ranks}), {scene.steps} steps of {c.time_step:.4g} s, "
        f"e = {c.restitution:g}, ks = {c.friction:g}, k = {c.stiffness:.4g} N/m -> {order.folder}"
    )


def _go_on(order: Order) -> None:
    """Go on with the interrupted run of a case."""
    folder, scene = order.folder, order.case.scene()
    checkpoint = resumable(order.case, folder, order.setting)
    for note in (*scene.warnings, *order.notes):
        log.info(f"note: {note}")
    log.info(
        f"{scene.name}: goes on at t = {checkpoint.time:.4g} s of {scene.time(scene.steps):.4g} s "
        f"(step {checkpoint.step} of {scene.steps}) -> {folder}"
    )
    before = (read_summary(folder) or {}).get("wall_seconds") or {}
    seconds = {name: before.get(name) or 0.0 for name in ("build", "analysis")}
    setting = replace(order.setting, kernel=checkpoint.result.kernel)
    _execute(replace(order, setting=setting), seconds, checkpoint)


def _execute(order: Order, seconds: Mapping[str, float], checkpoint: Checkpoint | None = None) -> None:
    """Run the engine in a folder that is written, analyse and report; `seconds` were spent before."""
    case, folder = order.case, order.folder
    with writing(folder):
        result, steady = _run_engine(order, checkpoint)
        if checkpoint is not None and result.status == "failed" and result.steps <= checkpoint.step:
            raise RunError(f"{result.message} Nothing was added to the run, and its checkpoint is kept.")
        if result.status != "interrupted":
            remove_checkpoint(folder)
            (folder / "in.resume.lammps").unlink(missing_ok=True)
        begin = time.perf_counter() - seconds["analysis"]
        if checkpoint is not None:
            clear(folder, RESULT_FILES)  # those of the part before
        parts: dict[str, Any] = {}
        trouble = ""
        try:
            with _analysis_of(folder):
                parts = runs.results.analyse(case, folder)
        except DumpError as error:
            trouble = str(error)
        if result.status != "complete" and trouble:
            parts.setdefault("warnings", []).append(f"not analysed: {trouble}")
        if steady:
            parts["stopped_when_steady"] = steady
            log.info(f"note: {steady}")
        spent = {"build": seconds["build"], "run": result.seconds, "analysis": time.perf_counter() - begin}
        summary = compose(case, order.setting, result, seconds=spent, parts=parts, notes=order.notes)
        write_summary(folder, summary)
        runs.results.write_report(folder, summary, case)
        spent["analysis"] = time.perf_counter() - begin
        write_summary(folder, {**summary, "wall_seconds": spent})
    if result.status == "interrupted":
        raise RunInterrupted(result.message)
    if result.status == "failed":
        raise RunError(result.message)
    if trouble:
        raise RunError(f"the run is complete, its dump could not be analysed: {trouble}")


def _load_analysis() -> None:
    """Import what the analysis needs, 0.7 s."""
    for name in ("numba", "xarray", "h5netcdf", "matplotlib.figure", "matplotlib.backends.backend_agg"):
        importlib.import_module(name)


def _run_engine(order: Order, checkpoint: Checkpoint | None) -> tuple[RunResult, str]:
    """Run; the text says why it was stopped as steady, and is empty where it was not."""
    case, folder = order.case, order.folder
    watch = steady_watch(case, folder)
    asked = [ask for ask in (watch, order.should_stop) if ask is not None]
    threading.Thread(target=_load_analysis).start()  # meanwhile
    result = engines.run(
        case.scene(),
        folder,
        with_header(case, order.setting),
        progress=order.progress,
        should_stop=(lambda: any([ask() for ask in asked])) if asked else None,
        resume=checkpoint,
    )
    if watch is not None and watch.reason and result.status == "interrupted":
        return replace(result, status="complete", message=""), watch.reason
    return result, ""


def steady_watch(case: ReadCase, folder: Path) -> runs.steady.SteadyWatch | None:
    """The watch of a case with ``run.stop_when_steady``, else None."""
    scene = case.scene()
    if not case.fields.run.stop_when_steady or not scene.inlets:
        return None
    return runs.steady.SteadyWatch(scene, folder, runs.steady.studied_reach(runs.results.flow_of(case)))


@contextmanager
def _analysis_of(folder: Path) -> Iterator[None]:
    """Ctrl-C and SIGTERM during the analysis of a run folder become a `RunInterrupted` that says what is left to do."""
    try:
        with terminate_as_interrupt():
            yield
    except KeyboardInterrupt:
        raise RunInterrupted(
            f"the analysis was stopped; the files of the run are kept, and `lammps-jump analyze {folder}` analyses them"
        ) from None
