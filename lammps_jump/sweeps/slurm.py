# SPDX-License-Identifier: GPL-2.0-or-later
"""A study as one array job of Slurm: its file, its submission, and what a task of it does."""

from __future__ import annotations

import re
import subprocess
import sys
from collections import Counter
from collections.abc import Sequence
from math import ceil
from pathlib import Path

from lammps_jump.engines.choice import choose_setting
from lammps_jump.engines.interrupts import terminate_as_interrupt
from lammps_jump.errors import CaseError, JumpError, RunError, RunInterrupted, SetupError
from lammps_jump.files import ARRAY_FILE, write_text
from lammps_jump.script.job import Site, head, needs, run_and_requeue, seconds_of

from .members import failure_message, run_member, state_of
from .study_folder import read_points
from .sweep import Sweep, held_study, open_sweep, prepare

AT_ONCE = 32
"""Tasks at once, where no number is given."""
TASK_SECONDS = 600
"""Short members share a task up to this estimate: Slurm takes up to a second between two tasks."""
MOST_TASKS = 1_000
"""Numbers of tasks that Slurm takes with its default MaxArraySize."""
OUTPUT = "slurm"
"""Folder of what the tasks print."""


def array_text(sweep: Sweep, numbers: Sequence[int], site: Site, *, at_once: int = AT_ONCE, retry: bool = False) -> str:
    """The file of an array job for some members of a study.

    Parameters
    ----------
    sweep : Sweep
    numbers : sequence of int
        Of the members that are left.
    site : Site
    at_once : int
        Tasks at once.
    retry : bool
        The tasks also run again what failed.
    """
    first = {sweep.members[number].point: sweep.members[number].case for number in numbers}
    ranks = max(choose_setting(case)[1].ranks for case in first.values())
    longest = max((case.scene() for case in first.values()), key=lambda scene: seconds_of(scene, ranks))
    fitting = max(1, int(TASK_SECONDS / max(seconds_of(longest, ranks), 1e-3)))
    each = max(min(ceil(len(numbers) / at_once), fitting), ceil(len(sweep.members) / MOST_TASKS))
    tasks = ",".join(str(task) for task in sorted({number // each for number in numbers}))
    options = (*needs(longest, ranks, each), f"--array={tasks}%{at_once}", f"--output={OUTPUT}/%A_%a.out")
    command = f'lammps-jump sweep . --member "$first-$((first + {each - 1}))"{" --retry" if retry else ""}'
    return f"""{head(sweep.study.case.name, options, site)}
# Submit it from the folder of the study, which has a folder {OUTPUT}: sbatch {ARRAY_FILE}.
cd "${{SLURM_SUBMIT_DIR:-$(dirname "$0")}}" || exit 2
first=$((SLURM_ARRAY_TASK_ID * {each}))
{run_and_requeue(command, site)}"""


def submit(sweep: Sweep, site: Site, *, at_once: int = AT_ONCE, retry: bool = False) -> str:
    """Submit one array job for the members of a study that are not done; its number, empty where none is left.

    Where all are done, ``until`` may ask for more.

    Raises
    ------
    CaseError, SetupError
        A point that cannot be run, a folder in use, tasks of the study in the queue; ``sbatch`` is lacking or refuses.
    """
    left = sweep.left(retry)
    if not left and (wider := sweep.wider()):
        sweep, left = wider, wider.left(retry)
    if not left:
        return ""
    if tasks := queued(sweep.folder):
        raise SetupError(
            f"{sweep.folder}: has {tasks.total()} tasks in Slurm's queue; wait until they have ended, or end them with "
            "scancel"
        )
    site = site.model_copy(update={"environment": site.environment or sys.prefix})
    with held_study(sweep.folder):
        prepare(sweep)
        write_text(sweep.folder / ARRAY_FILE, array_text(sweep, left, site, at_once=at_once, retry=retry))
        (sweep.folder / OUTPUT).mkdir(exist_ok=True)
        command = ["sbatch", "--parsable", f"--chdir={sweep.folder.resolve()}", ARRAY_FILE]
        try:
            done = subprocess.run(command, cwd=sweep.folder, capture_output=True, text=True)
        except OSError:
            raise SetupError("sbatch is not installed: submit from a machine of the cluster") from None
    if done.returncode:
        raise SetupError(f"sbatch refuses {sweep.folder / ARRAY_FILE}: {' '.join(done.stderr.split())}; see --site")
    return done.stdout.strip().partition(";")[0]


def queued(folder: Path) -> Counter[str]:
    """Tasks of a study in the queue by their state; none where Slurm is not there or does not answer."""
    try:
        done = subprocess.run(["squeue", "--me", "-h", "-r", "-o", "%T %Z"], capture_output=True, text=True)
    except OSError:
        return Counter()
    tasks = (line.partition(" ") for line in done.stdout.splitlines())
    return Counter(state.lower() for state, _, place in tasks if place == str(folder.resolve()))


def status(sweep: Sweep) -> str:
    """`Sweep.status`, with the tasks that are in the queue."""
    tasks = ", ".join(f"{count} {state}" for state, count in sorted(queued(sweep.folder).items()))
    return sweep.status() + (f"; tasks of Slurm: {tasks}" if tasks else "")


def run_task(folder: Path, members: str, *, retry: bool = False) -> None:
    """Run members of a study that was prepared, in this process: the task of a batch system.

    Only their run folders are written, so that tasks run at once. A member that is done is left as it is; one that was
    interrupted goes on. One that fails does not keep the next from being run.

    Parameters
    ----------
    folder : Path
        Of the study.
    members : str
        Number of a member in ``points.json``, from 0, or a range as ``4-7``; numbers after the last one are left out.
    retry : bool
        Also run again those that failed.

    Raises
    ------
    CaseError
        No study there, or no such member.
    SetupError
        The members here are not those of ``points.json``.
    RunError, RunInterrupted
        Members failed; a signal ended the task, and the same call goes on.
    """
    try:
        with terminate_as_interrupt():
            wrong = _run_each(folder, members, retry)
    except (KeyboardInterrupt, RunInterrupted):
        raise RunInterrupted(f"{folder}, --member {members}: ended by a signal; the same command goes on") from None
    if wrong:
        raise RunError("; ".join(wrong))


def _run_each(folder: Path, members: str, retry: bool) -> list[str]:
    """Run some members, one after the other; what is to be said of those that failed."""
    sweep = open_sweep(folder)
    match = re.fullmatch(r"(\d{1,7})(?:-(\d{1,7}))?", members)
    numbers = range(int(match[1]), min(int(match[2] or match[1]) + 1, len(sweep.members))) if match else ()
    if not numbers:
        raise CaseError(f"--member {members}: {folder} has members 0 to {len(sweep.members) - 1}; a range is 4-7")
    listed = read_points(folder)
    if listed is None or [item.key for item in listed.members] != [member.key for member in sweep.members]:
        raise SetupError(
            f"{folder}: was prepared with another version of lammps-jump or LAMMPS, or another kernel; install "
            "the same versions on all machines, and set engine.kernel"
        )
    wrong = []
    for number in numbers:
        member = sweep.members[number]
        state = state_of(member, folder)
        if state.stage == "failed" and not retry:
            wrong.append(f"member {number}: {failure_message(state)}")
        elif state.stage != "done":
            try:
                run_member(member, folder, state.stage == "failed", True)
            except RunInterrupted:
                raise
            except JumpError as error:
                wrong.append(f"member {number}: {error}")
    return wrong
