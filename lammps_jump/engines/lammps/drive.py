# SPDX-License-Identifier: GPL-2.0-or-later
"""LAMMPS in the engine's process: runs a script to its end, reports, and ends in order on request."""

from __future__ import annotations

import ctypes
import os
import threading
from collections.abc import Callable
from contextlib import chdir
from pathlib import Path
from typing import Any

from lammps_jump.engines.checkpoint import cut_back, join_part, remove_checkpoint
from lammps_jump.engines.interrupts import save_request, stop_request
from lammps_jump.engines.result import REPORT_SECONDS, Progress, RunResult
from lammps_jump.engines.setting import Job
from lammps_jump.files import END_FILE, delete, text_of
from lammps_jump.script import assemble
from lammps_jump.script.assemble import SCRIPTS, STOP_FILE

from .loader import load_lammps, new_engine
from .outputs import LOG, SteppingOutcome, conclude
from .steps import Saver, Steps


def run_lammps(job: Job, report: Callable[[Progress | None], None]) -> RunResult:
    """Run the script of the kernel in the job's folder, or ``in.resume.lammps`` of a job that goes on.

    A run leaves checkpoints (see `lammps_jump.engines.checkpoint`), each at the end of a window of the probes. What
    goes on from there is the motion of an uninterrupted run to within the order of sums (see
    `lammps_jump.script.assemble`): the ten digits of a dump are the same for hundreds of steps, until collisions have
    blown up the last digit as they do between any two machines.

    Parameters
    ----------
    job : Job
    report : callable
        Called ten times a second, with None before the first line of the log.

    Returns
    -------
    RunResult
        With status 'complete', 'interrupted' or 'failed'; never raises for a failed run.

    Raises
    ------
    SetupError
        Where LAMMPS cannot be loaded at all.
    """
    load_lammps()  # before the clock starts
    return conclude(job, play(job, report))


def arguments(job: Job) -> list[str]:
    """Command-line arguments of LAMMPS: name of the log, no screen, the plugin's path."""
    log = LOG if job.resume is None else "none"  # the script goes on with the one that is there
    return ["-log", log, "-screen", "none", "-nocite", *plugin_arguments(job.setting.plugin)]


def plugin_arguments(plugin: Path | None) -> list[str]:
    """Arguments of LAMMPS that give a script the path of the plugin; in quotes, a path with blanks is one word."""
    return ["-var", "plugin", f'"{plugin}"'] if plugin else []


def make_ready(job: Job) -> None:
    """Clears the folder of what an earlier run has left, or of what a part has left after its checkpoint."""
    folder = job.folder
    delete(folder / STOP_FILE, folder / END_FILE)
    if job.resume is not None:
        cut_back(folder, job.resume)
        join_part(folder)
    else:
        remove_checkpoint(folder)
        delete(folder / "forces.csv")


def play(job: Job, report: Callable[[Progress | None], None] | None) -> SteppingOutcome:
    """Run the script to its end, in this thread; another one reports. Ranks but the first have no `report`."""
    outcome = SteppingOutcome()
    ranks = job.setting.ranks
    save_request.clear()
    os.environ["LAMMPS_JUMP_THREADS"] = job.setting.threads  # the plugin reads it
    with chdir(job.folder):
        engine = new_engine(arguments(job))
        outcome.version = str(engine.version())
        saver = Saver(job, outcome) if report is not None else None
        steps = Steps(engine, job, saver)
        ended = threading.Event()
        reporter = threading.Thread(target=_report, args=(engine, job, outcome, report, saver, ended))
        if report is not None:
            reporter.start()
        try:
            with stop_request.calls(steps.ask), save_request.calls(steps.ask):
                script = SCRIPTS[job.setting.kernel] if job.resume is None else assemble.SCRIPT
                steps.play(job.script or text_of(Path(script)))
        except Exception as error:  # the module raises bare Exception for every ERROR of LAMMPS
            outcome.error = str(error)
            if ranks > 1 and "MPIAbort" in type(error).__name__:  # the others still wait for this rank
                print(error, flush=True)
                os._exit(1)
        ended.set()
        if report is not None:
            reporter.join()
        if saver is not None and (steps.unsaved or not steps.ended):
            saver.tick()  # else the clocks are those of the checkpoint
        outcome.interrupted, outcome.unsaved = steps.ended, steps.unsaved
        if outcome.error and ranks == 1:
            outcome.state = _state(engine)
        engine.close()
    return outcome


def leave_ranks() -> None:
    """End MPI, the last thing that a rank does: mpiexec may drop what a rank prints later."""
    new_engine(["-log", "none", "-screen", "none", "-nocite"]).finalize()


def _threads_of(plugin: Path | None) -> Callable[[], int]:
    """Function that says how many threads the plugin takes now; it is loaded already, so that this is the same one."""
    return ctypes.CDLL(str(plugin)).jump_threads if plugin else lambda: 1


def _report(
    engine: Any, job: Job, outcome: SteppingOutcome, report: Callable[..., Any], saver: Saver, ended: threading.Event
) -> None:
    """Report step and discs of the last line of the log until the run has ended; ask for checkpoints when due."""
    scene, threads = job.scene, None
    while not ended.wait(REPORT_SECONDS):
        if saver.due() and not save_request.is_made():
            save_request.make()
        try:
            values = engine.last_thermo()
        except Exception as error:  # LAMMPS tells an error once, to the first thread that asks
            outcome.error = str(error)
            return
        progress = None
        if values and "Step" in values:
            step = int(values["Step"])
            threads = threads or _threads_of(job.setting.plugin)
            progress = Progress(step, scene.steps, scene.time(step), int(values["Atoms"]), threads=threads())
        report(progress)


def _state(engine: Any) -> tuple[Any, ...] | None:
    """(ids, positions) of what is left after an error, if the engine still answers."""
    count = engine.extract_global("nlocal")
    ids, places = engine.numpy.extract_atom("id"), engine.numpy.extract_atom("x")
    if ids is None or places is None or not count:
        return None
    return ids[:count].copy(), places[:count].copy()
