# SPDX-License-Identifier: GPL-2.0-or-later
"""Processes that tests start: one way, and none outlives its test."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

from lammps_jump.engines.child import close_idle
from lammps_jump.engines.interrupts import SIGNALS

HOOK = Path(__file__).parent / "hook"
LIMIT = 600
"""Seconds; ends a hang and nothing else."""


def _start_clean() -> None:
    """Signals are heard, also where the tests run in the background of a shell or under nohup, which ignore some."""
    for number in SIGNALS:
        signal.signal(number, signal.SIG_DFL)


@contextmanager
def child(command, **options):
    """A process in a session of its own; whatever happens, it and its children are killed and reaped."""
    process = subprocess.Popen(
        [str(word) for word in command], text=True, start_new_session=True, preexec_fn=_start_clean, **options
    )
    try:
        yield process
    finally:
        try:
            os.killpg(process.pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
        process.wait()


@contextmanager
def engines_that_save_at(*steps: int):
    """Let engines that the test process starts write a checkpoint at these steps; clocks make none so soon."""
    path = os.pathsep.join([str(HOOK), *filter(None, [os.environ.get("PYTHONPATH")])])
    values = {"JUMP_TEST_SAVE": ",".join(map(str, steps)), "PYTHONPATH": path}
    before = {name: os.environ.get(name) for name in values}
    close_idle()
    os.environ.update(values)
    try:
        yield
    finally:
        close_idle()
        for name, value in before.items():
            os.environ.pop(name) if value is None else os.environ.update({name: value})


def run_child(command, *, signal_at: tuple | None = None, env=None, **options) -> tuple[int, str]:
    """Status and output of a command; pytest shows the output where the test fails.

    Parameters
    ----------
    command : sequence
    signal_at : (number, step) or (number, step, who), optional
        The process gets this signal at a step of its engine, or its engine, or both: 'first', 'engine', 'all'.
    env : dict of str, optional
        Added to the environment.
    """
    environment = {**os.environ, **(env or {})}
    environment.pop("JUMP_TEST_PROCESS", None)  # the child is the first process of its own run
    if signal_at is not None:
        environment["JUMP_TEST_SIGNAL"] = "{:d}@{:d}@{}".format(*signal_at, "first")
    environment["PYTHONPATH"] = os.pathsep.join([str(HOOK), *filter(None, [environment.get("PYTHONPATH")])])
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, **options}
    with child(command, env=environment, **pipes) as process:
        output, errors = process.communicate(timeout=LIMIT)
    output = (output or "") + (errors or "")
    print(f"$ {' '.join(str(word) for word in command)}\n{output}[status {process.returncode}]")
    return process.returncode, output


def run_program(*arguments, **options) -> tuple[int, str]:
    """Status and output of the command line program; options as of `run_child`."""
    return run_child([sys.executable, "-m", "lammps_jump", *arguments], **options)
