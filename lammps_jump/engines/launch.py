# SPDX-License-Identifier: GPL-2.0-or-later
"""The one way to run a scene: an engine in a child process, which this process watches.

The child is in a session of its own, so that Ctrl-C comes to this process alone. This process asks the child to save
and end; a second Ctrl-C or SIGTERM kills it. A child without a job is kept for the next run, and ends with this
process.
"""

from __future__ import annotations

import signal
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from lammps_jump import script
from lammps_jump.compiling.cache import open_to_others
from lammps_jump.core.library import core
from lammps_jump.engines.lammps.outputs import SteppingOutcome, conclude, read_log
from lammps_jump.files import SCENE_FILE, delete, write_bytes, write_text
from lammps_jump.folders import writable
from lammps_jump.quoting import typed
from lammps_jump.scene.scene import Scene
from lammps_jump.script import continuation_text, script_text, write_continuation

from . import native
from .checkpoint import Checkpoint, last_saved
from .child import Child, child_for
from .interrupts import handled_by
from .lammps.drive import make_ready
from .result import Progress, ProgressCallback, RunResult, interruption
from .setting import Job, Setting

KILLED = "Killed (signal 9)"
"""Words of mpiexec for a rank that was killed."""


def run(
    scene: Scene,
    folder: Path,
    setting: Setting | None = None,
    *,
    progress: ProgressCallback | None = None,
    should_stop: Callable[[], bool] | None = None,
    resume: Checkpoint | None = None,
) -> RunResult:
    """Run a scene in a folder, and leave there the dump, ``forces.csv`` and the engine's own files.

    Parameters
    ----------
    scene : Scene
    folder : Path
        Made where it is missing. What an earlier run left of the same names is replaced.
    setting : Setting, optional
    progress : callable, optional
        Called with a `Progress` about ten times a second.
    should_stop : callable, optional
        Asked at the same rate; True ends the run as an interruption does.
    resume : Checkpoint, optional
        Go on with the interrupted run that left it in `folder`. The result is of all parts.

    Returns
    -------
    RunResult
        With status 'complete', 'interrupted' or 'failed' and a message. An interrupted run leaves a checkpoint where
        it can.

    Raises
    ------
    SetupError
        The engine cannot be used here, or the folder cannot be written.
    CaseError
        The engine does not know an option of the scene.
    """
    setting = setting or Setting()
    job = Job(scene, Path(folder), setting, Path.cwd(), resume)
    write_inputs(job)
    if setting.engine == "lammps" and open_to_others(job.folder):
        job = replace(job, script=_script_of(job))
    with child_for(job) as child, handled_by(child.signalled):
        run_result = child.run(job, progress, should_stop)
        if run_result is None:
            run_result = _without_result(job, child)
    return run_result


def write_inputs(job: Job) -> None:
    """Write the script of a job, and clear its folder of an earlier run; the native engine needs the folder alone.

    Raises
    ------
    SetupError
        The folder cannot be written.
    """
    scene, setting = job.scene, job.setting
    with writable(job.folder):
        job.folder.mkdir(parents=True, exist_ok=True)
        if setting.engine != "lammps":
            if setting.scripts and job.resume is None:
                about = {"dump_format": setting.dump_format, "header": setting.header}
                write_script(scene, job.folder, kernel="compiled", **about)
            return
        if job.resume is None:
            path = write_script(scene, job.folder, **_options(job))
        else:
            delete(job.folder / "in.resume.lammps")  # it may have other names
            path = write_continuation(scene, job.folder, **_options(job))
        if setting.script is not None:
            write_text(path, setting.script)
        make_ready(job)


def write_script(scene: Scene, folder: Path, **options: Any) -> Path:
    """Write scripts and their side files into a folder; arguments and result as of `script.write_script`.

    Law, walls and bodies of the compiled styles are in a file of their own, the core's image of the scene.
    """
    path = script.write_script(scene, folder, **options)
    if options.get("kernel") == "compiled" and core() is not None:  # else nothing compiled can run it either
        write_bytes(folder / SCENE_FILE, native.WithoutDiscs(scene).file())
    return path


def _options(job: Job) -> dict[str, Any]:
    """Options of the script of a job, other than its scene."""
    setting, resume = job.setting, job.resume
    options: dict[str, Any] = {"dump_format": setting.dump_format, "header": setting.header}
    options |= {"kernel": setting.kernel, "ranks": setting.ranks}
    if resume is not None:
        here = resume.result.present + resume.result.removed
        options |= {"step": resume.step, "removed": resume.removed, "poured": here - len(job.scene.positions)}
    return options


def _script_of(job: Job) -> str:
    """The text of the script that `write_inputs` writes."""
    if job.setting.script is not None:
        return job.setting.script
    make = script_text if job.resume is None else continuation_text
    return make(job.scene, **_options(job))


def _without_result(job: Job, child: Child) -> RunResult:
    """The result of a run whose process was killed, or ended by itself; it may go on from a checkpoint."""
    blamed = [line for line in child.output if "ERROR" in line]
    raised = [line for line in child.output[-1:] if "Error" in line]  # of Python; mpiexec tells it two lines before
    said, log = blamed or raised or child.output[-3:], read_log(job.folder / "log.lammps").error
    status = child.process.returncode
    error = " ".join(said[:1]) or log or (f"the engine's process ended with status {status}" if status else "")
    again, outside = last_saved(job.folder), True
    if job.setting.engine == "lammps":
        run_result = conclude(job, SteppingOutcome(error="" if child.asked else error, interrupted=child.asked > 0))
        outside = not (blamed or log)
    else:
        scene, last = job.scene, child.last or Progress(0, job.scene.steps, 0.0, len(job.scene.positions))
        ended = f"the engine's process ended at t = {last.time:z.4g} s: {error}. What it wrote is kept in {job.folder}."
        if child.asked:
            reason = "it was ended by force, so its state was not saved"
            ended = interruption(scene, last.step, job.folder, again=again, reason=reason)
        how = "interrupted" if child.asked else "failed"
        run_result = RunResult(
            engine=job.setting.engine, kernel=job.setting.kernel, status=how, message=ended, steps=last.step,
            disc_steps=0.0, inserted=last.discs, present=last.discs, removed=0, lost=0, seconds=0.0,
        )  # fmt: skip
    killed = status == -signal.SIGKILL or any(KILLED in line for line in child.output)
    if run_result.status != "failed" or not outside or (again is None and not killed):
        return run_result
    how = "starts it again" if again is None else f"goes on from t = {again:z.4g} s"
    return replace(
        run_result, message=f"{run_result.message} `{typed('run', job.folder, '--resume')}` {how}.", outside=True
    )
