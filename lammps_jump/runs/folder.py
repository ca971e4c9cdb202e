# SPDX-License-Identifier: GPL-2.0-or-later
"""A run folder: its name, how it is made, what its run has done, and what of a case is left to do in it."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal

from lammps_jump import folders
from lammps_jump.analysis import quantities
from lammps_jump.case.case import ReadCase
from lammps_jump.case.text import read_text as read_case
from lammps_jump.dump.ended import write_ended
from lammps_jump.dump.find import read_dump
from lammps_jump.engines import RunResult, Setting
from lammps_jump.engines.checkpoint import ANEW, Checkpoint, has_checkpoint, read_checkpoint
from lammps_jump.engines.choice import program_of
from lammps_jump.engines.lammps.outputs import gather_forces, read_log
from lammps_jump.errors import CaseError, DumpError, ResumeError, SetupError
from lammps_jump.files import (
    CONTACTS_FILE,
    DUMP_NAMES,
    END_FILE,
    JOB_FILE,
    PRESSURE_FILE,
    RUN_FILES,
    START_FILE,
    checksum,
    write_text,
)
from lammps_jump.folders import Marker, force_tables, read_marker, require_ours, standing
from lammps_jump.identity import analysis_key, field_keys, run_key, scene_key, short_hash
from lammps_jump.quoting import typed
from lammps_jump.scene.scene import Scene

from .summary import read_summary

LONGEST_NAME = 100
"""Letters of a default folder; after them a hash represents the changed values."""
PLAIN_NAME = re.compile(r"[\w.,=+\-\[\]{}:]*", re.ASCII)
MADE = "# The run in this folder is of this case; for another run change a copy. Hashes of the fields:"
"""Begins ``case.yaml`` of a run folder."""


def default_folder(case: ReadCase) -> Path:
    """Folder of a case when none is named: ``runs/<stem of its file>``, followed by its changed values."""
    path = Path(case.source.file)
    stem = case.name if str(path) == "<case>" else path.stem
    if path.name == "case.yaml" and (path.parent / folders.MARKER_FILE).exists():
        stem = path.absolute().parent.name
    changed = sorted("".join(text.split()) for text in case.source.overrides.values())
    name = ",".join([stem, *changed]).replace('"', "").replace("'", "")
    if changed and not (len(name) <= LONGEST_NAME and PLAIN_NAME.fullmatch(name.removeprefix(stem))):
        name = f"{stem},{short_hash({'changes': changed})}"
    return Path("runs") / name


@contextmanager
def run_folder(folder: Path, marker: folders.Marker) -> Iterator[None]:
    """Hold a run folder, made where it is missing, as its only writer.

    Raises
    ------
    SetupError
        The folder cannot be made or written, is not ours, or another process writes to it.
    """
    with folders.writable(folder):
        folders.require_ours(folder, marker)
        folder.mkdir(parents=True, exist_ok=True)
    with folders.locked(folder):
        with folders.writable(folder):
            folders.claim(folder, marker)
        yield


def case_text(case: ReadCase) -> str:
    """Content of ``case.yaml`` of a run folder: the case, and hashes that reveal an edit; see `to_yaml`."""
    text = case.to_yaml()
    return f"{MADE} {' '.join(f'{field}={value}' for field, value in field_keys(text).items())}\n{text}"


def own_files(marker: folders.Marker | None) -> list[str]:
    """Names and patterns of a marker that runs and their analyses make; nothing else of it is deleted."""
    known, listed = {*RUN_FILES, *quantities.result_files()}, marker.files if marker else ()
    return [name for name in listed if name in known or folders.FORCE_TABLE.fullmatch(name)]


def write_folder(case: ReadCase, folder: Path, marker: folders.Marker) -> None:
    """Write ``case.yaml`` and the discs of earlier runs; what a run left there is removed.

    The engine's inputs are `write_inputs`'.
    """
    with folders.writable(folder):
        # a job that runs here may be requeued: its file stays
        folders.clear(folder, set(own_files(folders.read_marker(folder))) - {JOB_FILE})
        folders.write_marker(folder, marker)
        for begun in case.source.begun.values():
            write_ended(folder / START_FILE.format(key=begun.state.key), begun.state)
        write_text(folder / "case.yaml", case_text(case))


def require_case(folder: Path) -> Path:
    """The ``case.yaml`` of a run folder, as it was written.

    Raises
    ------
    CaseError
        There is none, or it was edited: its run is of another case.
    """
    path = folder / "case.yaml"
    if not path.exists():
        raise CaseError(f"{folder}: holds no case.yaml, so it is no run folder; make one with `lammps-jump build CASE`")
    text = read_case(path)
    head, _, _ = text.partition("\n")
    if head.startswith(MADE):
        made, keys = dict(pair.partition("=")[::2] for pair in head[len(MADE) :].split()), field_keys(text)
        for field in {**made, **keys}:
            if made.get(field) != keys.get(field):
                raise CaseError(
                    f"{path}: {field} was changed after the folder was made, so that it is no longer the case of the "
                    "run; undo the change, or run a copy of the file: `lammps-jump build-and-run COPY`"
                )
    return path


def result_of(
    case: ReadCase, folder: Path, stored: Mapping[str, Any], setting: Setting, *, write: bool = True
) -> RunResult:
    """The result of a run as its summary holds it, else from what it wrote; see `result_of_files`."""
    if not stored:
        return result_of_files(case.scene(), folder, setting, write=write)
    same = ("engine", "kernel", "status", "steps", "disc_steps", "versions", "ledger")
    counts = dict(stored["discs"])
    fixed = counts.pop("fixed", 0)  # a result counts all discs
    counts |= {name: counts[name] + fixed for name in ("inserted", "present")}
    return RunResult(
        **{name: stored[name] for name in same},
        **counts,
        message=stored["message"] or "",
        seconds=stored["wall_seconds"].get("run", 0.0),
        cpu_seconds=stored.get("cpu_seconds", 0.0),
        breakdown=stored["breakdown_seconds"] or {},
        resumed=tuple(stored.get("resumed_at", ())),
        outside=stored.get("can_go_on", False),
        states=tuple((step, text) for step, text in stored.get("states", ())),
    )


def result_of_files(scene: Scene, folder: Path, setting: Setting, *, write: bool = True) -> RunResult:
    """Result of a run that was killed before it wrote a summary: from its log, else from its dump.

    Parameters
    ----------
    write : bool
        Also make ``forces.csv`` of what LAMMPS has written.
    """
    log = read_log(folder / "log.lammps")
    if log.step:
        if write:
            gather_forces(scene, folder)
        step, disc_steps = log.step, log.disc_steps
        inserted, present, removed = max(len(scene.positions), log.highest_id), log.discs, log.removed
    else:
        step, disc_steps, highest, present = 0, 0.0, len(scene.positions), 0
        for frame in read_dump(folder):
            disc_steps += 0.5 * (present + frame.n) * (frame.step - step)
            step, present = frame.step, frame.n
            highest = max(highest, int(frame.ids.max(initial=0)))
        inserted, removed = highest, highest - present
    whole = step >= scene.steps
    message = (
        "the run reached its end, its analysis did not"
        if whole
        else f"the run was cut off after t = {scene.time(step):z.4g} s of {scene.time(scene.steps):z.4g} s"
    ) + " and left no summary; discs are counted from what it wrote"
    return RunResult(
        engine=setting.engine,
        kernel=setting.kernel,
        status="complete" if whole else "interrupted",
        message=message,
        steps=step,
        disc_steps=disc_steps,
        inserted=inserted,
        present=present,
        removed=removed,
        lost=inserted - present - removed,
        seconds=0.0,
    )


ToDo = Literal["run", "analyse", "nothing"]
OUTPUTS = (*DUMP_NAMES.values(), "forces.csv", PRESSURE_FILE, CONTACTS_FILE, "log.lammps", END_FILE)
"""Files that an engine leaves of a run."""
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
    change = difference(case, None if resume else setting, marker)
    if change and resume:
        raise ResumeError(
            f"{folder}: the run there differs from the case that was asked for ({change}), so it cannot go on as that "
            f"case; `{typed('run', folder, '--resume')}` goes on with the one in the folder, --out names another"
        )
    if change:
        raise SetupError(
            f"{folder}: holds another run ({change}); name another folder with --out, or delete that run with --force"
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
    """Tells whether a complete run and its analysis are in a folder as written, the analysis as now requested."""
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
    differences = [f"{name} is {_short(there.get(name))} there, {_short(here.get(name))} here" for name in changed]
    more = f"; {len(differences) - FEWEST} more" if len(differences) > FEWEST else ""
    return "; ".join(differences[:FEWEST]) + more


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
