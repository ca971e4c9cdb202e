# SPDX-License-Identifier: GPL-2.0-or-later
"""A job file for a Slurm cluster: runs the folder it is in, and goes on after a time limit."""

from __future__ import annotations

import shlex
import signal
from pathlib import Path
from typing import Annotated

from pydantic import AfterValidator, BaseModel, StringConstraints, ValidationError

from lammps_jump.case.text import nearest, read_source
from lammps_jump.errors import CaseError
from lammps_jump.files import JOB_FILE, write_text
from lammps_jump.quoting import echoed, one_line, shell_word
from lammps_jump.scene.scene import Scene

MEGABYTES = 600
"""Of the command itself, which also analyses: 430 MB measured."""
MEGABYTES_OF_RANK = 100
BYTES_PER_DISC = 3_000
"""Peak of the stock styles 2.2 kB, of the compiled ones 1.4 kB (docs/scaling.md)."""
DISC_STEPS_PER_SECOND = 10e6
"""Stock script on one core, deliberately low: a run that reaches its limit waits for the queue once more."""
INTERRUPTED = 75
"""Exit status of an interrupted run that can go on."""
KILLED_BY_USR1 = 128 + signal.SIGUSR1
NOTICE = 120
"""Seconds before the time limit at which Slurm sends USR1; it may come 60 s earlier, or 30 s late."""

Word = Annotated[str, StringConstraints(pattern=r"^[\w.,:/+@=-]+$")]
Option = Annotated[str, StringConstraints(pattern=r"^--[a-z-]+(=[\w.,:/+@=-]+)?$")]


class Site(BaseModel, coerce_numbers_to_str=True, extra="forbid", frozen=True):
    """Demands of a cluster on a job.

    Attributes
    ----------
    partition, account, time : str
        As of ``sbatch``; without `time` it is estimated from the size of the scene.
    options : list of str
        Further options of ``sbatch``, such as ``--qos=long``.
    modules : list of str
        Environment modules that are loaded first.
    environment : str
        Folder of the Python environment that lammps-jump is installed in.
    """

    partition: Word | None = None
    account: Word | None = None
    time: Word | None = None
    options: list[Option] = []
    modules: list[Word] = []
    environment: Annotated[str, AfterValidator(one_line)] = ""

    @property
    def head(self) -> list[str]:
        """Lines of options, for the top of a job file."""
        named = [f"--{key}={name}" for key in ("partition", "account", "time") if (name := getattr(self, key))]
        return [f"#SBATCH {option}" for option in (*named, *self.options)]

    @property
    def commands(self) -> list[str]:
        """Commands that make lammps-jump known."""
        place = [f"PATH={shlex.quote(self.environment)}/bin:$PATH"] if self.environment else []
        return [*(f"module load {name}" for name in self.modules), *place]


def read_site(path: Path) -> Site:
    """The options of a site file.

    Raises
    ------
    CaseError
        The file cannot be read, or a field is unknown or not fit for a job file.
    """
    source = read_source(path)
    try:
        return Site.model_validate(source.data)
    except ValidationError as error:
        first = error.errors()[0]
        said = first["msg"]
        if first["type"] == "extra_forbidden":
            said = f"unknown field; {nearest(str(first['loc'][-1]), list(Site.model_fields))}"
        elif first["type"] == "string_pattern_mismatch":
            said = f"{echoed(first['input'])} is not allowed; one word of letters, digits and .,:/+@=- is: correct it"
        raise CaseError(f"{source.place(first['loc'])}: {said}") from None


def job_text(scene: Scene, ranks: int, site: Site | None = None) -> str:
    """The job file of a run folder: one task a rank, memory and time from the size of the scene."""
    site = site or Site()
    options = (*needs(scene, ranks), "--output=slurm-%j.out")
    return f"""{head(scene.name, options, site)}
# Submit it from this folder: sbatch job.slurm. lammps-jump must be known there; the run and its analysis are made here.
cd "${{SLURM_SUBMIT_DIR:-$(dirname "$0")}}" || exit 2
if [ ! -f case.yaml ]; then
    echo "no case.yaml in $PWD: submit the job from the run folder" >&2
    exit 2
fi
{run_and_requeue("lammps-jump run . --resume", site)}"""


def seconds_of(scene: Scene, ranks: int) -> float:
    """Wall time of a run, s: an estimate."""
    return scene.expected_discs * scene.steps / (DISC_STEPS_PER_SECOND * ranks)


def needs(scene: Scene, ranks: int, runs: int = 1) -> tuple[str, ...]:
    """Options for tasks, memory and time of a job that makes some runs of a scene, one after the other."""
    minutes = -(-int(1.5 * runs * seconds_of(scene, ranks)) // 60) + 5
    megabytes = MEGABYTES + MEGABYTES_OF_RANK * ranks + BYTES_PER_DISC * scene.expected_discs // 1_000_000
    return f"--ntasks={ranks}", f"--mem={megabytes}M", f"--time={minutes}"


def head(name: str, options: tuple[str, ...], site: Site) -> str:
    """First lines of a job file that may be requeued; those of the site come last, and win."""
    own = (f"--job-name={shell_word(name)}", "--nodes=1", "--cpus-per-task=1", *options)
    requeue = ("--open-mode=append", "--requeue", f"--signal=B:USR1@{NOTICE}")
    return "\n".join(["#!/bin/bash", *(f"#SBATCH {option}" for option in (*own, *requeue)), *site.head])


def run_and_requeue(command: str, site: Site) -> str:
    """Lines that run a command, hand signals on to it, and requeue the job where its time has ended."""
    return "\n".join(
        [
            f"# USR1 comes before the time limit: the run saves its state, ends with {INTERRUPTED}, is requeued.",
            f"# A program that is still being started ends with {KILLED_BY_USR1}.",
            "# TERM comes from scancel: the run saves its state, and the job ends.",
            "signalled= child=",
            *(f"trap 'signalled={name}; [ -z \"$child\" ] || kill -{name} $child' {name}" for name in ("USR1", "TERM")),
            *site.commands,
            f'if [ -z "$signalled" ]; then {command} & else (exit {INTERRUPTED}) & fi',
            "child=$!",
            '[ -z "$signalled" ] || kill -"$signalled" "$child" 2>/dev/null # it came before the line above',
            'wait "$child"',
            'while kill -0 "$child" 2>/dev/null; do wait "$child"; done',
            'wait "$child" # once more: a signal ends a wait with another status',
            "status=$?",
            f'case "$signalled $status" in "USR1 {INTERRUPTED}" | "USR1 {KILLED_BY_USR1}")',
            '    scontrol requeue "${SLURM_ARRAY_JOB_ID:-$SLURM_JOB_ID}${SLURM_ARRAY_TASK_ID:+_$SLURM_ARRAY_TASK_ID}"',
            "    ;;",
            "esac",
            'exit "$status"',
            "",
        ]
    )


def write_job(scene: Scene, folder: Path, ranks: int, site: Site | None = None) -> Path:
    """Write ``job.slurm`` into a built folder; returns its path."""
    return write_text(folder / JOB_FILE, job_text(scene, ranks, site))
