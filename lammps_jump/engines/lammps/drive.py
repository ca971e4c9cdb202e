# SPDX-License-Identifier: GPL-2.0-or-later
"""LAMMPS in the engine's process: runs a script to its end, reports, and ends in order where it is asked to."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from lammps_jump.engines import step_hook
from lammps_jump.engines.checkpoint import cut_back, remove_checkpoint
from lammps_jump.engines.interrupts import stop_request
from lammps_jump.engines.result import Progress, RunResult
from lammps_jump.engines.setting import Job
from lammps_jump.script import resume as continuation
from lammps_jump.script.assemble import SCRIPTS, STOP_FILE, stop_at_step
from lammps_jump.script.stock import first_step

from .finish import STOPPED_SCRIPT, Outcome, conclude
from .loader import load_lammps
from .save import LOG, forget_part, save_state

REPORT_SECONDS = 0.1


def run_lammps(job: Job, report: Callable[[Progress | None], None]) -> RunResult:
    """Run the script of the kernel in the job's folder, or ``in.resume.lammps`` of a job that goes on.

    An interrupted run leaves a checkpoint (see `lammps_jump.engines.checkpoint`) at the end of the window of the probes
    that it was in. What goes on from there is the motion of an uninterrupted run to within the order of sums (see
    `lammps_jump.script.resume`): the ten digits of a dump are the same for hundreds of steps, until collisions
    have blown up the last digit as they do between any two machines.

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
    begin, processor = time.perf_counter(), time.process_time()
    outcome = _play(job, report)
    outcome.seconds = time.perf_counter() - begin
    outcome.cpu_seconds = (time.process_time() - processor) * job.setting.ranks
    return conclude(job, outcome)


def run_other_rank(job: Job) -> None:
    """Take part in `run_lammps` of the first rank."""
    _play(job, lambda now: None)


def arguments(job: Job) -> list[str]:
    """Command-line arguments of LAMMPS: name of the log, no screen, the plugin's path."""
    log = LOG if job.resume is None else continuation.LOG
    return ["-log", log, "-screen", "none", "-nocite", *plugin_arguments(job.setting.plugin)]


def plugin_arguments(plugin: Path | None) -> list[str]:
    """Arguments of LAMMPS that give a script the path of the plugin; in quotes, a path with blanks is one word."""
    return ["-var", "plugin", f'"{plugin}"'] if plugin else []


def make_ready(job: Job) -> None:
    """Clear the folder of what an earlier run or part has left; write the script of a run that is to stop at a step."""
    folder, setting = job.folder, job.setting
    (folder / STOP_FILE).unlink(missing_ok=True)
    forget_part(folder)
    if job.resume is not None:
        cut_back(folder, job.resume)
    else:
        remove_checkpoint(folder)
        (folder / "forces.csv").unlink(missing_ok=True)
    if setting.stop_at is not None:
        text = stop_at_step((folder / _script(job)).read_text(), job.scene, setting.ranks, setting.stop_at)
        (folder / STOPPED_SCRIPT).write_text(text)


def _script(job: Job) -> str:
    return SCRIPTS[job.setting.kernel] if job.resume is None else continuation.SCRIPT


@contextmanager
def _inside(folder: Path) -> Iterator[None]:
    before = Path.cwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)


def _play(job: Job, report: Callable[[Progress | None], None]) -> Outcome:
    """Run the script to its end, in this thread; another one reports."""
    outcome = Outcome()
    ranks = job.setting.ranks
    with _inside(job.folder):
        engine = load_lammps().lammps(cmdargs=arguments(job))
        outcome.version = str(engine.version())

        def stop() -> None:
            outcome.interrupted = True
            if ranks > 1:
                Path(STOP_FILE).touch()  # their script looks for it
            else:
                engine.lib.lammps_force_timeout(engine.lmp)

        ended = threading.Event()
        reporter = threading.Thread(target=_report, args=(engine, job.scene, outcome, report, ended))
        reporter.start()
        try:
            with stop_request.calls(stop):
                _read_script(engine, _script(job) if job.setting.stop_at is None else STOPPED_SCRIPT)
                if ranks == 1:
                    first = first_step(job.scene) if job.resume is None else job.resume.step
                    outcome.unsaved = save_state(engine, job.scene, job.setting.kernel, first)
        except Exception as error:  # the module raises bare Exception for every ERROR of LAMMPS
            outcome.error = str(error)
            if ranks > 1 and "MPIAbort" in type(error).__name__:  # the others still wait for this rank
                print(error, flush=True)
                os._exit(1)
        ended.set()
        reporter.join()
        if outcome.error and ranks == 1:
            outcome.state = _state(engine)
        engine.close()
    return outcome


def leave_ranks() -> None:
    """End MPI, the last thing that a rank does: mpiexec may drop what a rank prints later."""
    load_lammps().lammps(cmdargs=["-log", "none", "-screen", "none", "-nocite"]).finalize()


def _report(engine, scene, outcome: Outcome, report: Callable, ended: threading.Event) -> None:
    """Report step and discs of the last line of the log until the run has ended."""
    while not ended.wait(REPORT_SECONDS):
        try:
            values = engine.last_thermo()
        except Exception as error:  # LAMMPS tells an error once, to the first thread that asks
            outcome.error = str(error)
            return
        found = None
        if values and "Step" in values:
            step = int(values["Step"])
            found = Progress(step, scene.steps, scene.time(step), int(values["Atoms"]))
        report(found)


def _read_script(engine, script: str) -> None:
    """Run a script; where a test has set a step hook, `fix external` calls it."""
    if step_hook.at_step is None:
        engine.file(script)
        return
    head, run, rest = Path(script).read_text().partition("\nrun ")
    engine.commands_string(head + "\nfix step_hook all external pf/callback 1 1\n")

    def call(_, step, *arrays) -> None:
        step_hook.at_step(step)

    engine.set_fix_external_callback("step_hook", call)
    engine.commands_string(run + rest)


def _state(engine) -> tuple | None:
    """(ids, positions) of what is left after an error, if the engine still answers."""
    count = engine.extract_global("nlocal")
    ids, places = engine.numpy.extract_atom("id"), engine.numpy.extract_atom("x")
    if ids is None or places is None or not count:
        return None
    return ids[:count].copy(), places[:count].copy()
