# SPDX-License-Identifier: GPL-2.0-or-later
"""Work of a process: it runs one start of a point and measures it, or calls a function."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from lammps_jump.errors import CaseError, JumpError, RunInterrupted
from lammps_jump.files import DUMP_NAMES, plain
from lammps_jump.runs.run import open_run
from lammps_jump.sweeps.members import Member, drop_dumps, require_no_links, run_member, state_of

from .find import MEASURE_FILE, load_module
from .point import FAILED, Measure


class Task(NamedTuple):
    """One start of a point, as a worker takes it.

    Attributes
    ----------
    folder : Path
        Of the study.
    measure : str or callable
    options : mapping
        Of that function.
    member : Member or None
        What is run; None for a function without a run.
    store : Path
        Holds ``runs/``.
    dump : bool
        Whether the function reads the dump.
    again : bool
        Run again what is there.
    keep_dump : bool
    """

    folder: Path
    measure: str | Measure
    options: Mapping[str, Any]
    member: Member | None
    store: Path
    dump: bool = True
    again: bool = False
    keep_dump: bool = False


def function_of(task: Task) -> Measure:
    """Return the measuring function; CaseError where the folder has none of this name."""
    if not isinstance(task.measure, str):
        return task.measure
    found: Measure | None = getattr(load_module(task.folder, "measure"), task.measure, None)
    if found is None:
        raise CaseError(f"{task.folder / MEASURE_FILE}: has no function {task.measure}")
    return found


def work(task: Task) -> Any:
    """Return what the measuring function finds; a run that failed is a measurement with the reason alone."""
    function = function_of(task)
    try:
        return plain(function(**task.options) if task.member is None else _measured(task, task.member, function))
    except RunInterrupted:
        raise
    except JumpError as error:
        return failed(str(error))


def failed(reason: str) -> dict[str, str]:
    """Return the measurement that there is not."""
    return {FAILED: reason}


def _measured(task: Task, member: Member, function: Measure) -> object:
    require_no_links([member], task.store)
    folder = member.folder(task.store)
    stage = state_of(member, task.store).stage
    there = stage == "done" and not task.again
    if there and task.dump:
        there = any((folder / name).exists() for name in DUMP_NAMES.values())
    if not there:
        run_member(member, task.store, stage in ("done", "failed"), True)
    found = function(open_run(folder), **task.options)
    if not task.keep_dump:
        drop_dumps(member, task.store)
    return found
