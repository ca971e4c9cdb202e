# SPDX-License-Identifier: GPL-2.0-or-later
"""State of a run folder for a case: nothing yet, this run, or another one."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, Literal

from lammps_jump.analysis import quantities
from lammps_jump.case.case import ReadCase
from lammps_jump.engines.checkpoint import ANEW, Checkpoint, has_checkpoint, read_checkpoint
from lammps_jump.engines.setting import Setting
from lammps_jump.errors import DumpError, ResumeError, SetupError
from lammps_jump.files import CONTACTS_FILE, DUMP_NAMES, END_FILE, PRESSURE_FILE, RUN_FILES, checksum
from lammps_jump.folders import Marker, force_tables, read_marker, require_ours, standing
from lammps_jump.identity import analysis_key, run_key, scene_key
from lammps_jump.quoting import typed

from .engine import program_of
from .folder import result_of_files
from .summary import read_summary

ToDo = Literal["run", "analyse", "nothing"]
OUTPUTS = (*DUMP_NAMES.values(), "forces.csv", PRESSURE_FILE, CONTACTS_FILE, "log.lammps", END_FILE)
"""What an engine leaves of a run."""
FEWEST = 3
"""Differences that a message names."""


def marker_of(case: ReadCase, setting: Setting) -> Marker:
    """The marker of the folder of a run."""
    probes = case.structures
    program = program_of(setting)
    about = {"key": run_key(case.core, program), "case": case.core, "program": program}
    return Marker(
        "run", (*RUN_FILES, *quantities.result_files(), *force_tables(f"force_{name}.csv" for name in probes)), about
    )


def left_to_do(case: ReadCase, folder: Path, setting: Setting, *, force: bool = False, resume: bool = False) -> ToDo:
    """Work that is left for a case in a folder. Nothing is written.

    Parameters
    ----------
    force : bool
        A run that the folder holds is to be deleted.
    resume : bool
        A run that can go on is to: 'run' from its checkpoint, without one from its beginning.

    Raises
    ------
    SetupError
        The folder is not ours, or holds another run, or one that has not come to its end.
    ResumeError
        The run that is to go on is of another case, or one that failed and would fail again.
    DumpError
        ``summary.json`` is not the summary of a run.
    """
    require_ours(folder, marker_of(case, setting))
    marker = read_marker(folder)
    if force or marker is None or not has_output(folder):
        return "run"
    if resume and not (folder / "case.yaml").exists():
        raise ResumeError(f"{folder}: holds no run that could go on, for its case.yaml is gone; {ANEW}")
    found = difference(case, None if resume else setting, marker)
    if found and resume:
        raise ResumeError(
            f"{folder}: the run there differs from the case that was asked for ({found}), so it cannot go on as that "
            f"case; `{typed('run', folder, '--resume')}` goes on with the one in the folder, --out names another"
        )
    if found:
        raise SetupError(
            f"{folder}: holds another run ({found}); name another folder with --out, or delete that run with --force"
        )
    stored = read_summary(folder)
    status = _status(case, folder, setting, stored)
    if status in ("complete", "unchecked"):
        return "nothing" if is_analysed(case, folder, stored) else "analyse"
    if resume and (status == "interrupted" or stored.get("can_go_on")):
        return "run"
    if resume:
        raise ResumeError(
            f"{folder}: the run has {status} and would fail again from its checkpoint; correct the case and start a "
            "new run"
        )
    goes_on = "--resume goes on with it, " if has_checkpoint(folder) else ""
    was = {"interrupted": "was interrupted", "failed": "failed"}[status]
    raise SetupError(
        f"{folder}: holds a run of this case that {was}; {goes_on}--force deletes it and starts anew, --out names "
        "another folder"
    )


def _status(case: ReadCase, folder: Path, setting: Setting, stored: Mapping[str, Any]) -> str:
    """Status of the run in a folder; where it left no summary, what it wrote tells."""
    if stored.get("status"):
        return str(stored["status"])
    recorded = any(standing(folder, name) for name in ("forces.csv", "forces_*.raw"))
    if has_checkpoint(folder) or (case.structures and not recorded):
        return "interrupted"
    try:
        return result_of_files(case.scene(), folder, setting, write=False).status
    except DumpError:
        return "interrupted"


def has_output(folder: Path) -> bool:
    """Tells whether an engine has written to a folder."""
    return has_checkpoint(folder) or any(standing(folder, name) for name in (*OUTPUTS, "forces_*.raw"))


def outputs_of(folder: Path, names: Iterable[str] = OUTPUTS) -> dict[str, dict[str, int | str]]:
    """Size and SHA-256 of what the engine has left, by name."""
    return {name: checksum(folder / name) for name in names if (folder / name).is_file()}


def without(sums: Mapping[str, Any], name: str) -> dict[str, Any]:
    """Checksums but that of one file."""
    return {other: entry for other, entry in sums.items() if other != name}


def is_analysed(case: ReadCase, folder: Path, stored: Mapping[str, Any]) -> bool:
    """Tells whether a complete run and its analysis stand in a folder as written, the analysis as now asked for."""
    outputs, block = stored.get("outputs"), stored.get("analysed")
    if stored.get("status") != "complete" or outputs is None or block is None:
        return False
    try:
        read = without(outputs, END_FILE)  # which a user may delete
        same_sizes = all((folder / name).stat().st_size == entry["size"] for name, entry in read.items())
        return (
            same_sizes
            and block["key"] == analysis_key(case.rest, outputs)
            and all(checksum(folder / name) == entry for name, entry in block["files"].items())
        )
    except OSError:
        return False


def difference(case: ReadCase, setting: Setting | None, marker: Marker) -> str:
    """Differences between the run of a folder and a case (and its setting), in words; empty where there is none."""
    there, here = dict(_leaves(marker.about.get("case"))), dict(_leaves(case.core))
    if setting is not None:
        there |= dict(_leaves(marker.about.get("program")))
        here |= program_of(setting)
    changed = [name for name in {**there, **here} if there.get(name) != here.get(name)]
    told = [f"{name} is {_short(there.get(name))} there, {_short(here.get(name))} here" for name in changed]
    more = f"; {len(told) - FEWEST} more" if len(told) > FEWEST else ""
    return "; ".join(told[:FEWEST]) + more


def _short(value: object) -> str:
    text = "not given" if value is None else str(value)
    return text if len(text) <= 40 else text[:37] + "…"


def _leaves(tree: object, path: str = "") -> Iterator[tuple[str, object]]:
    """Dotted path and value of everything in plain data."""
    if isinstance(tree, dict | list) and tree:
        for key, item in tree.items() if isinstance(tree, dict) else enumerate(tree):
            yield from _leaves(item, f"{path}.{key}".lstrip("."))
    elif path:
        yield path, tree


def resumable(case: ReadCase, folder: Path, setting: Setting) -> Checkpoint | None:
    """The checkpoint of the run of this very case in a folder; None where there is none, and it starts anew.

    Raises
    ------
    ResumeError
        No checkpoint is whole, or it is of another program, kernel or engine.
    """
    checkpoint = read_checkpoint(folder)
    if checkpoint is None:
        return None
    if checkpoint.scene != scene_key(case.scene()):
        raise ResumeError(
            f"{folder}: this version of lammps-jump makes other numbers of the same case than the one that began the "
            f"run; go on with that version, or start a new run"
        )
    if checkpoint.result.kernel == "compiled" and setting.plugin is None:
        raise ResumeError(
            f"{folder}: began with the compiled kernel, which cannot be used now: see `lammps-jump doctor`"
        )
    if checkpoint.result.engine != setting.engine:
        raise ResumeError(f"{folder}: began on the {checkpoint.result.engine} engine; {ANEW}")
    return checkpoint
