"""Run folders opened again: to run what `build` wrote, and to analyse what a run left."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path
from typing import Any

from lammps_jump.case import resolved_yaml
from lammps_jump.engines.result import RunResult
from lammps_jump.errors import CaseError, DumpError

from . import summary as summaries
from .start import Prepared, analyse, analysis_of, compose, prepare, report


def reopen(folder: Path, assignments: list[str] | None = None) -> Prepared:
    """The `Prepared` of a folder that `write_folder` made.

    Raises
    ------
    CaseError
        Where it holds no ``case.yaml``.
    """
    case_file = folder / "case.yaml"
    if not case_file.exists():
        raise CaseError(f"{folder}: holds no case.yaml, so it is no run folder; make one with `lammps-jump build CASE`")
    prepared = prepare(case_file, assignments or [], folder)
    stored = summaries.read_summary(folder)
    if stored and stored.get("kernel") in ("stock", "compiled") and prepared.kernel != "numba":
        prepared = replace(prepared, setting=replace(prepared.setting, kernel=stored["kernel"]))
    return prepared


def reanalyse(folder: Path, assignments: list[str], quiet: bool) -> dict[str, Any]:
    """Analyse a run folder again (``--set analysis.…`` may ask for other things) and rewrite summary and report.

    Raises
    ------
    CaseError
        No run folder, or an assignment that would change the run.
    DumpError
    RunInterrupted
        Where the analysis is ended by Ctrl-C or SIGTERM.
    """
    for assignment in assignments:
        if assignment.split("=")[0].split(".")[0].strip() != "analysis":
            raise CaseError(
                f"--set {assignment}: belongs to the run, which is done; allowed here is analysis.…: a run with other "
                f"values is a new one: `lammps-jump build-and-run {folder / 'case.yaml'} --set {assignment} --out …`"
            )
    prepared = reopen(folder, assignments)
    stored = summaries.read_summary(folder)
    begin = time.perf_counter()
    with analysis_of(folder):
        result = _without_summary(prepared) if stored is None else _as_stored(stored, prepared)
        stored = stored or {}
        parts = analyse(prepared, result, quiet)
    seconds = {"build": 0.0, "run": result.seconds, **(stored.get("wall_seconds") or {})}
    seconds["analysis"] = time.perf_counter() - begin
    if result.status in ("interrupted", "complete") and result.message:
        parts.setdefault("warnings", []).append(result.message)
    summary = compose(prepared, result, seconds, parts)
    summary["case_hash"] = stored.get("case_hash", prepared.hash)
    (folder / "case.yaml").write_text(resolved_yaml(prepared.loaded.case))
    summaries.write_summary(folder, summary)
    report(prepared, summary)
    return summary


def _as_stored(stored: dict[str, Any], prepared: Prepared) -> RunResult:
    """The result of the run as its summary holds it."""
    discs = stored.get("discs") or {}
    return RunResult(
        engine=stored.get("engine", prepared.loaded.case.engine.name),
        kernel=stored.get("kernel", prepared.kernel),
        status=stored.get("status", "unknown"),
        message=stored.get("message") or "",
        steps=stored.get("steps", 0),
        disc_steps=stored.get("disc_steps", 0.0),
        inserted=discs.get("inserted", 0),
        present=discs.get("present", 0),
        removed=discs.get("removed", 0),
        lost=discs.get("lost", 0),
        seconds=(stored.get("wall_seconds") or {}).get("run", 0.0),
        versions=stored.get("versions", {}),
        ledger=stored.get("ledger"),
        breakdown=stored.get("breakdown_seconds") or {},
        resumed=tuple(stored.get("resumed_at") or ()),
    )


def reached_end(prepared: Prepared) -> bool:
    """Whether the log, else the dump of a run folder tells of the run's last step."""
    from lammps_jump.dump.find import open_run_dump
    from lammps_jump.engines.lammps.log import read_log

    step = read_log(prepared.folder / "log.lammps").step
    try:
        return (
            step or max((frame.step for frame in open_run_dump(prepared.folder)), default=0)
        ) >= prepared.scene.steps
    except DumpError:
        return False


def _without_summary(prepared: Prepared) -> RunResult:
    """What can be said of a run that was killed before it wrote a summary: from its log, else from its dump."""
    from lammps_jump.dump.find import open_run_dump
    from lammps_jump.engines.lammps.finish import gather_forces
    from lammps_jump.engines.lammps.log import read_log

    scene, folder = prepared.scene, prepared.folder
    log = read_log(folder / "log.lammps")
    if log.step:
        gather_forces(scene, folder)
        step, disc_steps = log.step, log.disc_steps
        inserted, present, removed = max(len(scene.positions), log.highest_id), log.discs, log.removed
    else:
        step, disc_steps, highest, present = 0, 0.0, len(scene.positions), 0
        for frame in open_run_dump(folder):
            disc_steps += 0.5 * (present + frame.n) * (frame.step - step)
            step, present = frame.step, frame.n
            highest = max(highest, int(frame.ids.max(initial=0)))
        inserted, removed = highest, highest - present
    whole = step >= scene.steps
    message = (
        "the run reached its end, its analysis did not"
        if whole
        else f"the run was cut off after t = {scene.time(step):.4g} s of {scene.time(scene.steps):.4g} s"
    ) + " and left no summary; discs are counted from what it wrote"
    return RunResult(
        engine=prepared.loaded.case.engine.name,
        kernel=prepared.kernel,
        status="complete" if whole else "interrupted",
        message=message,
        steps=step,
        disc_steps=disc_steps,
        inserted=inserted,
        present=present,
        removed=removed,
        lost=inserted - present - removed,
        seconds=0.0,
    )
