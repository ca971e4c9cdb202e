# SPDX-License-Identifier: GPL-2.0-or-later
"""Run a case: choose the setting, write the folder, run the engine, analyse, summarise, report."""

from __future__ import annotations

import importlib
import logging
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import lammps_jump.engines as engines
import lammps_jump.runs as runs
from lammps_jump.case.case import ReadCase, load_case
from lammps_jump.engines.checkpoint import Checkpoint, remove_checkpoint
from lammps_jump.engines.interrupts import terminate_as_interrupt
from lammps_jump.engines.lammps.job import write_job
from lammps_jump.engines.result import ProgressCallback, RunResult
from lammps_jump.engines.setting import Job, Setting
from lammps_jump.errors import CaseError, DumpError, RunError, RunInterrupted
from lammps_jump.files import RESULT_FILES, clear, write_text, writing

from .engine import choose_setting, with_header
from .folder import case_text, require_case, result_of, resumable, stored_result, write_folder
from .summary import compose, read_summary, write_summary

log = logging.getLogger(__name__)
"""Says what is done, and notes; the command line prints it."""
StopCallback = Callable[[], bool]


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
    case, setting, notes = choose_setting(case)
    scene, checkpoint = case.scene(), None
    before: Mapping[str, float] = {}
    if resume:
        checkpoint = resumable(case, folder, setting)
        setting = replace(setting, kernel=checkpoint.result.kernel)
        before = read_summary(folder).get("wall_seconds") or {}
        said = (
            f"goes on at t = {checkpoint.time:.4g} s of {scene.time(scene.steps):.4g} s "
            f"(step {checkpoint.step} of {scene.steps})"
        )
    else:
        if not force and (stored := stored_result(case, folder, setting)):
            log.info(
                f"{folder} already holds this run ({stored['steps']} steps, {stored['wall_seconds']['run']:.1f} s "
                "of computing): nothing to do. --force runs it again."
            )
            return
        c, ranks = scene.coefficients, f", {setting.ranks} ranks" if setting.ranks > 1 else ""
        said = (
            f"{setting.engine} ({setting.kernel}{ranks}), {scene.steps} steps of {c.time_step:.4g} s, "
            f"e = {c.restitution:g}, ks = {c.friction:g}, k = {c.stiffness:.4g} N/m"
        )
    for note in (*scene.warnings, *notes):
        log.info(f"note: {note}")
    log.info(f"{scene.name}: {said} -> {folder}")
    if checkpoint is None:
        write_folder(case, folder)
        before = {"build": time.perf_counter() - begin}
    with writing(folder), _files_at_risk(folder):
        result, steady = _run_engine(case, folder, setting, checkpoint, progress, should_stop)
        if checkpoint is not None:
            clear(folder, RESULT_FILES)  # those of the part before
        _conclude(case, folder, setting, notes, result, steady, before)


def build(case: ReadCase, folder: Path, *, job: bool = False) -> Setting:
    """Write the run folder of a case and stop there; with `job` also a job file for a cluster. The setting chosen.

    Raises
    ------
    CaseError, SetupError
    """
    case, setting, _ = choose_setting(case)
    write_folder(case, folder)
    engines.write_inputs(Job(case.scene(), folder, with_header(case, setting), Path.cwd()))
    if job:
        write_job(case.scene(), folder, setting.ranks)
    return setting


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
    case, setting, notes = choose_setting(load_case(require_case(folder), changes))
    stored = read_summary(folder)
    if stored.get("kernel") in ("stock", "compiled") and setting.kernel != "numba":
        setting = replace(setting, kernel=stored["kernel"])
    begin = time.perf_counter()
    with _analysis_of(folder), writing(folder), _files_at_risk(folder):
        result = result_of(case, folder, stored, setting)
        parts = runs.results.analyse(case, folder)
    seconds = {"build": 0.0, "run": result.seconds, **(stored.get("wall_seconds") or {})}
    seconds["analysis"] = time.perf_counter() - begin
    if result.status in ("interrupted", "complete") and result.message:
        parts.setdefault("warnings", []).append(result.message)
    summary = compose(case, setting, result, seconds=seconds, parts=parts, notes=notes)
    summary["case_hash"] = stored.get("case_hash", summary["case_hash"])
    write_text(folder / "case.yaml", case_text(case))
    write_summary(folder, summary)
    runs.results.write_report(folder, summary, case)


def _run_engine(
    case: ReadCase,
    folder: Path,
    setting: Setting,
    checkpoint: Checkpoint | None,
    progress: ProgressCallback | None,
    should_stop: StopCallback | None,
) -> tuple[RunResult, str]:
    """Run; the text says why it was stopped as steady, and is empty where it was not."""
    scene, watch = case.scene(), None
    if case.fields.run.stop_when_steady:
        watch = runs.steady.SteadyWatch(scene, folder, runs.steady.studied_reach(runs.results.flow_of(case)))
    asked = [ask for ask in (watch, should_stop) if ask is not None]
    threading.Thread(target=_load_analysis).start()  # meanwhile
    result = engines.run(
        scene,
        folder,
        with_header(case, setting),
        progress=progress,
        should_stop=(lambda: any([ask() for ask in asked])) if asked else None,
        resume=checkpoint,
    )
    if checkpoint is not None and result.status == "failed" and result.steps <= checkpoint.step:
        raise RunError(f"{result.message} Nothing was added to the run, and its checkpoint is kept.")
    if watch is not None and watch.reason and result.status == "interrupted":
        return replace(result, status="complete", message=""), watch.reason
    return result, ""


def _load_analysis() -> None:
    """Import what the analysis needs, 0.7 s."""
    for name in ("numba", "xarray", "h5netcdf", "matplotlib.figure", "matplotlib.backends.backend_agg"):
        with suppress(Exception):  # a program that is ending; else the analysis says it
            importlib.import_module(name)


def _conclude(
    case: ReadCase,
    folder: Path,
    setting: Setting,
    notes: tuple[str, ...],
    result: RunResult,
    steady: str,
    before: Mapping[str, float],
) -> None:
    """Analyse a run that has ended, write its summary and report; `before` are seconds that were spent before."""
    begin = time.perf_counter() - (before.get("analysis") or 0.0)
    if result.status != "interrupted":
        remove_checkpoint(folder)
        (folder / "in.resume.lammps").unlink(missing_ok=True)
    parts: dict[str, Any] = {}
    trouble = ""
    try:
        with _analysis_of(folder):
            parts = runs.results.analyse(case, folder)
    except DumpError as error:
        trouble = str(error)
        if result.status != "complete":
            parts = {"warnings": [f"not analysed: {trouble}"]}
    if steady:
        parts["stopped_when_steady"] = steady
        log.info(f"note: {steady}")
    seconds = {"build": before.get("build") or 0.0, "run": result.seconds, "analysis": time.perf_counter() - begin}
    summary = compose(case, setting, result, seconds=seconds, parts=parts, notes=notes)
    write_summary(folder, summary)
    runs.results.write_report(folder, summary, case)
    if result.status == "interrupted":
        raise RunInterrupted(result.message)
    if result.status == "failed":
        raise RunError(result.message)
    if trouble:
        raise RunError(f"the run is complete, its dump could not be analysed: {trouble}")


@contextmanager
def _files_at_risk(folder: Path) -> Iterator[None]:
    """A disk that is full, or a folder that is taken away, while the run goes on: a `RunError` that says so."""
    try:
        yield
    except OSError as error:
        if not folder.is_dir():
            raise RunError(
                f"{folder}: was removed or renamed while the run went on, so that its results cannot be kept there; "
                "the same command runs it anew"
            ) from None
        raise RunError(
            f"{error.filename or folder}: cannot be written ({error.strerror or error}); what was written before is "
            "kept: make room there, then give the command again"
        ) from None


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
