# SPDX-License-Identifier: GPL-2.0-or-later
"""What a worker process does: it runs one start of a point and measures it, or calls a function."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from lammps_jump import open_run
from lammps_jump.errors import CaseError, JumpError, RunInterrupted
from lammps_jump.files import DUMP_NAMES, plain
from lammps_jump.sweeps.members import Member, drop_dumps, require_no_links, run_member, state_of

from .find import MEASURE_FILE, load_module

FAILED = "failed"
"""Key of a measurement that there is not, with the reason."""


class Task(NamedTuple):
    """One start of a point, as a worker takes it.

    Attributes
    ----------
    folder : Path
        Of the law.
    measure : str
        Function in its ``measure.py``.
    options : mapping
        Of that function.
    member : Member or None
        What is run; None for a function without a run.
    store : Path
        Holds ``runs/``.
    keep_dump : bool
    """

    folder: Path
    measure: str
    options: Mapping[str, Any]
    member: Member | None
    store: Path
    keep_dump: bool = False


def work(task: Task) -> dict[str, Any]:
    """Return what the measuring function finds; a run that failed is a measurement with the reason alone."""
    function = getattr(load_module(task.folder, "measure"), task.measure, None)
    if function is None:
        raise CaseError(f"{task.folder / MEASURE_FILE}: has no function {task.measure}")
    try:
        return plain(function(**task.options) if task.member is None else _measured(task, task.member, function))
    except RunInterrupted:
        raise
    except JumpError as error:
        return {FAILED: str(error)}


def _measured(task: Task, member: Member, function: Any) -> dict[str, Any]:
    require_no_links([member], task.store)
    folder = member.folder(task.store)
    stage = state_of(member, task.store).stage
    dumps = [folder / name for name in DUMP_NAMES.values()]
    if stage != "done" or not any(path.exists() for path in dumps):
        run_member(member, task.store, stage in ("done", "failed"), True)
    found = function(open_run(folder), **task.options)
    if not task.keep_dump:
        drop_dumps(member, task.store)
    return found
