# SPDX-License-Identifier: GPL-2.0-or-later
"""Checkpoints of a LAMMPS run: the restart file of an interrupted part, and the parts put together."""

from __future__ import annotations

import shutil
from pathlib import Path

from lammps_jump.engines.checkpoint import write_checkpoint
from lammps_jump.engines.result import RunResult
from lammps_jump.files import DUMP_NAMES
from lammps_jump.scene.scene import Scene
from lammps_jump.script import resume as continuation
from lammps_jump.script.assemble import STATE
from lammps_jump.script.stock import first_step, half_step_back

from .log import LogSummary

LOG = "log.lammps"


def save_state(engine, scene: Scene, kernel: str, first: int) -> str:
    """Write the restart file of a script that was ended by its timeout; the reason where that cannot be.

    Runs on to the end of the window of the probes (their sums are in no restart file), which is the same motion as
    if nothing had been: ``pre no`` goes on with the forces that are there.

    Parameters
    ----------
    engine : lammps.lammps
    scene : Scene
    kernel : {'stock', 'compiled'}
    first : int
        Nothing is saved up to this step.
    """
    step = engine.extract_global("ntimestep")
    if not first < step < scene.steps:
        return ""
    left = min(-step % scene.probe_steps, scene.steps - step) if scene.probes else 0
    try:
        engine.command("timer timeout off")
        engine.command(f"run {left} pre no post no")
        if engine.extract_global("ntimestep") != step + left:
            return "a second signal ended the run before its state could be saved"
        if step + left < scene.steps:
            for line in half_step_back(scene, kernel):
                engine.command(line)
            engine.command(f"write_restart {STATE.format(step=step + left)}")
    except Exception as error:  # the module raises bare Exception for every ERROR of LAMMPS
        return f"its state could not be saved ({error})"
    return ""


def keep_checkpoint(scene: Scene, folder: Path, log: LogSummary, result: RunResult) -> str:
    """Make a checkpoint of the restart file of an interrupted run; the reason where there is none.

    Parameters
    ----------
    log : LogSummary
        Of all parts; its last line is of the step of the restart file.
    result : RunResult
        Of all parts.
    """
    state = STATE.format(step=log.step)
    if not (folder / state).exists():
        if log.step <= first_step(scene):
            return "it had not got behind its start" + (", where gates open and inlets begin" * bool(scene.inlets))
        return "it was ended by force, so its state was not saved"
    if scene.pours and log.highest_id - len(scene.positions) < sum(item.count for item in scene.pours):
        (folder / state).unlink()
        return "it was still pouring, and LAMMPS' fix pour keeps no state"
    try:
        write_checkpoint(
            scene, folder, state, (LOG, *DUMP_NAMES.values()), result, log.removed_by[: len(scene.outlets)]
        )
    except OSError as error:
        return f"its state could not be saved ({error})"
    return ""


def join_parts(folder: Path) -> None:
    """Put log and binary dump of a continued part behind those of the part before."""
    for part, whole in ((continuation.LOG, LOG), (continuation.BINARY_PART, DUMP_NAMES["binary"])):
        if (folder / part).exists():
            with (folder / part).open("rb") as source, (folder / whole).open("ab") as target:
                shutil.copyfileobj(source, target)
            (folder / part).unlink()


def forget_part(folder: Path) -> None:
    """Delete what an earlier try at the next part has left."""
    for name in (continuation.LOG, continuation.BINARY_PART):
        (folder / name).unlink(missing_ok=True)
