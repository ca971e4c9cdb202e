# SPDX-License-Identifier: GPL-2.0-or-later
"""A run folder: its name, how it is made for a run, what the run in it has done."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from lammps_jump import folders
from lammps_jump.analysis import quantities
from lammps_jump.case.case import ReadCase
from lammps_jump.case.text import read_text as read_case
from lammps_jump.dump.ended import write_ended
from lammps_jump.dump.find import read_dump
from lammps_jump.engines import RunResult, Setting
from lammps_jump.engines.lammps.finish import gather_forces
from lammps_jump.engines.lammps.log import read_log
from lammps_jump.errors import CaseError
from lammps_jump.files import JOB_FILE, RUN_FILES, START_FILE, write_text
from lammps_jump.identity import field_keys, short_hash
from lammps_jump.scene.scene import Scene

LONGEST_NAME = 100
"""Letters of a default folder; behind that a hash stands for the changed values."""
PLAIN_NAME = re.compile(r"[\w.,=+\-\[\]{}:]*", re.ASCII)
MADE = "# The run in this folder is of this case; for another run change a copy. Hashes of the fields:"
"""Begins ``case.yaml`` of a run folder."""


def default_folder(case: ReadCase) -> Path:
    """Folder of a case when none is named: ``runs/<stem of its file>``, its changed values behind that."""
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
    """Content of ``case.yaml`` of a run folder: the case, and hashes by which an edit is found; see `to_yaml`."""
    text = case.to_yaml()
    return f"{MADE} {' '.join(f'{field}={found}' for field, found in field_keys(text).items())}\n{text}"


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
        made, found = dict(pair.partition("=")[::2] for pair in head[len(MADE) :].split()), field_keys(text)
        for field in {**made, **found}:
            if made.get(field) != found.get(field):
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
