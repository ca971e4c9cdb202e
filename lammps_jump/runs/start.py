# SPDX-License-Identifier: GPL-2.0-or-later
"""Run a case: choose the setting, write the folder, run the engine, analyse, summarise, report."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path

from lammps_jump import engines, runs
from lammps_jump.analysis import quantities
from lammps_jump.case.case import ReadCase
from lammps_jump.engines import Checkpoint, Job, ProgressCallback, RunResult, Setting
from lammps_jump.engines.choice import choose_setting, with_header
from lammps_jump.errors import CaseError, RunError, SetupError
from lammps_jump.files import RANKS_FILE, SUMMARY_FILE
from lammps_jump.folders import MARKER_FILE, clear, locked, read_marker, require_unlocked
from lammps_jump.quoting import typed
from lammps_jump.script.job import Site, write_job

from .conclude import AnalysisThread, Conclusion, signals_end
from .folder import (
    difference,
    has_output,
    left_to_do,
    marker_of,
    require_case,
    result_of,
    resumable,
    run_folder,
    write_folder,
)
from .summary import read_summary

log = logging.getLogger(__name__)
"""Says what is done, and notes; the command line prints it."""
StopCallback = Callable[[], bool]
Watchers = tuple[ProgressCallback | None, StopCallback | None]
"""Progress and stop callbacks."""


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
    require_unlocked(folder)
    ask = partial(left_to_do, case, folder, setting, force=force, resume=resume)
    if ask() == "nothing":
        stored = read_summary(folder)
        log.info(
            f"{folder} already holds this run ({stored['steps']} steps, {stored['wall_seconds']['run']:z.1f} s "
            "of computing): nothing to do. --force runs it again."
        )
        return
    ended = f"{folder}: ended by a signal; the same command with --resume goes on"
    with signals_end(ended), run_folder(folder, marker_of(case, setting)):
        left = ask()  # again: another process may have been there
        if left == "run":
            _run(case, folder, setting, notes, resume, begin, (progress, should_stop))
        elif left == "analyse":
            log.info(f"{folder} already holds this run: only its analysis is made. --force runs it again.")
            _reanalyse(case, folder, setting, notes)


def _run(
    case: ReadCase, folder: Path, setting: Setting, notes: tuple[str, ...], resume: bool, begin: float, watch: Watchers
) -> None:
    """Run in a folder that this process holds."""
    clear(folder, [RANKS_FILE])  # of a run that was killed
    scene = case.scene()
    texts = [*(scene.earlier.origins if scene.earlier else ()), *scene.warnings, *scene.adapted, *notes]
    checkpoint = resumable(case, folder, setting) if resume else None
    before: Mapping[str, float] = {}
    if checkpoint is not None:
        done = checkpoint.result
        setting = replace(setting, kernel=done.kernel)
        before = read_summary(folder).get("wall_seconds") or {}
        said = (
            f"goes on at t = {checkpoint.time:z.4g} s of {scene.time(scene.steps):z.4g} s "
            f"(step {checkpoint.step} of {scene.steps})"
        )
        left = sum(item.count for item in scene.pours) + len(scene.positions) - done.present - done.removed
        if scene.pours and left > 0 and done.engine == "lammps":
            texts.append(f"the {left} discs that are still to be poured come from a new random stream")
    else:
        c, ranks = scene.coefficients, f", {setting.ranks} ranks" if setting.ranks > 1 else ""
        said = (
            f"{setting.engine} ({setting.kernel}{ranks}), {scene.steps} steps of {c.time_step:z.4g} s, "
            f"e = {c.restitution:zg}, μ = {c.friction:zg}, k = {c.stiffness:z.4g} N/m"
        )
        if resume:
            texts.append(f"{folder} holds no checkpoint: the run starts from the beginning")
    for note in texts:
        log.info(f"note: {note}")
    log.info(f"{scene.name}: {said} -> {folder}")
    if checkpoint is None:
        write_folder(case, folder, marker_of(case, setting))
        before = {"build": time.perf_counter() - begin}
    with files_at_risk(folder), AnalysisThread(case, folder, setting, whole=checkpoint is None) as ahead:
        result, steady = _run_engine(case, folder, setting, checkpoint, watch)
        runs.known.remember_run(case, setting, result)
        if checkpoint is not None:
            clear(folder, set(quantities.result_files()) - {SUMMARY_FILE})  # those of the part before
        Conclusion(case, folder, setting, result, steady, before, notes, watch[0], ahead).conclude()


def build(case: ReadCase, folder: Path, *, job: Site | None = None, force: bool = False) -> Setting:
    """Write the run folder of a case and stop there, with the job file for a site if one is given; the setting chosen.

    Raises
    ------
    CaseError, SetupError
        Also where the folder holds a run, unless `force` asks to delete it.
    """
    case, setting, _ = choose_setting(case)
    marker = marker_of(case, setting)
    with run_folder(folder, marker):
        if not force and has_output(folder):
            raise SetupError(f"{folder}: holds a run; name another folder with --out, or delete that run with --force")
        write_folder(case, folder, marker)
        engines.write_inputs(Job(case.scene(), folder, with_header(case, setting), Path.cwd()))
        if job is not None:
            write_job(case.scene(), folder, setting.ranks, job)
    return setting


def reanalyse(folder: Path, changes: Sequence[str] = ()) -> None:
    """Analyse a run folder again and rewrite its summary and report.

    Parameters
    ----------
    changes : sequence of str
        ``analysis.…=value``: what else to find in the run.

    Raises
    ------
    CaseError
        No run folder, or a change of the run itself.
    DumpError
        No dump that can be read.
    RunInterrupted
        The analysis was ended by a signal.
    """
    for change in changes:
        if change.split("=")[0].split(".")[0].strip() != "analysis":
            raise CaseError(
                f"--set {change}: belongs to the run, which is done; allowed here is analysis.…: a run with other "
                f"values is a new one: `{typed('build-and-run', folder / 'case.yaml', '--set', change)} --out …`"
            )
    path, marker = require_case(folder), read_marker(folder)
    if marker is None:
        raise SetupError(
            f"{folder}: was not made by lammps-jump (there is no {MARKER_FILE}), so nothing is written to it; "
            f"`{typed('analyze', 'DUMP', '--case', path, '--out', 'OTHER')}` analyses its dump"
        )
    case, setting, notes = choose_setting(ReadCase.load(path, changes))
    if changed := difference(case, None, marker):
        raise CaseError(
            f"{path}: was changed after the run ({changed}); put it back, or run the changed case in another folder"
        )
    with locked(folder):
        _reanalyse(case, folder, setting, notes)


def _reanalyse(case: ReadCase, folder: Path, setting: Setting, notes: tuple[str, ...]) -> None:
    """Analyse a run again in a folder that this process holds."""
    clear(folder, [RANKS_FILE])
    stored = read_summary(folder)
    if stored.get("kernel") in ("stock", "compiled") and setting.engine == "lammps":
        setting = replace(setting, kernel=stored["kernel"])
    with files_at_risk(folder):
        result = result_of(case, folder, stored, setting)
        before = {**(stored.get("wall_seconds") or {}), "analysis": 0.0}
        steady = stored.get("stopped_when_steady") or ""
        Conclusion(case, folder, setting, result, steady, before, notes, stored=stored).conclude()


def _run_engine(
    case: ReadCase, folder: Path, setting: Setting, checkpoint: Checkpoint | None, watch: Watchers
) -> tuple[RunResult, str]:
    """Run; the text says why it was stopped as steady, drowned or at rest, and is empty where it was not."""
    scene, steady, (progress, should_stop) = case.scene(), None, watch
    if case.fields.run.stop_when_steady:
        reach = runs.steady.studied_reach(runs.results.flow_of(case))
        steady = runs.steady.SteadyWatch(scene, folder, reach, setting.dump_format)
    stops = [ask for ask in (steady, should_stop) if ask is not None]
    result = engines.run(
        scene,
        folder,
        with_header(case, setting),
        progress=progress,
        should_stop=(lambda: any([ask() for ask in stops])) if stops else None,
        resume=checkpoint,
    )
    if checkpoint is not None and result.status == "failed" and result.steps <= checkpoint.step:
        raise RunError(f"{result.message} Nothing was added to the run, and its checkpoint is kept.")
    if steady is not None and steady.reason and result.status == "interrupted":
        return replace(result, status="complete", message=""), steady.reason
    return result, ""


@contextmanager
def files_at_risk(folder: Path) -> Iterator[None]:
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
