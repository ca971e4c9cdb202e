# SPDX-License-Identifier: GPL-2.0-or-later
"""What a run folder holds: made for a run, read again afterwards, gone on with after an interruption."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from lammps_jump.case.case import ReadCase
from lammps_jump.case.text import read_text as read_case
from lammps_jump.dump.find import read_dump
from lammps_jump.engines.checkpoint import CHECKPOINT_FILE, Checkpoint, read_checkpoint
from lammps_jump.engines.lammps.finish import gather_forces
from lammps_jump.engines.lammps.log import read_log
from lammps_jump.engines.result import RunResult
from lammps_jump.engines.setting import Setting
from lammps_jump.errors import CaseError, DumpError, ResumeError, SetupError
from lammps_jump.files import OWN_FILES, clear, locked, write_text
from lammps_jump.provenance import fingerprint
from lammps_jump.scene.scene import Scene

from .engine import run_key
from .summary import read_summary

MADE = "# The run in this folder is of this case; for another run change a copy. Hashes of the fields:"
"""Begins ``case.yaml`` of a run folder."""
ANEW = "the same command without --resume starts a new run"


def default_folder(case: ReadCase) -> Path:
    """Where a case runs when no folder is named."""
    return Path("runs") / case.name


@contextmanager
def run_folder(folder: Path) -> Iterator[None]:
    """Hold a run folder, made where it is missing, as its only writer.

    Raises
    ------
    SetupError
        The folder cannot be made or written, or another process writes to it.
    """
    with _writable(folder):
        folder.mkdir(parents=True, exist_ok=True)
    with locked(folder):
        yield


@contextmanager
def _writable(folder: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise SetupError(
            f"{folder}: cannot be written ({error.strerror or error}); name another folder with --out, or "
            "correct its permissions"
        ) from None


def case_text(case: ReadCase) -> str:
    """What ``case.yaml`` of a run folder holds: the case, and hashes by which an edit is found."""
    text = case.to_yaml()
    return f"{MADE} {' '.join(f'{field}={found}' for field, found in _hashes(text).items())}\n{text}"


def _hashes(text: str) -> dict[str, str]:
    """Hash of the text of each field at the left margin."""
    fields = re.split(r"(?m)^(?=\w+:)", text)[1:]
    return {field.partition(":")[0]: hashlib.sha256(field.encode()).hexdigest()[:12] for field in fields}


def write_folder(case: ReadCase, folder: Path) -> None:
    """Write ``case.yaml``; earlier results are removed. The engine's inputs are `write_inputs`'."""
    with _writable(folder):
        clear(folder, OWN_FILES)
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
        made, found = dict(pair.partition("=")[::2] for pair in head[len(MADE) :].split()), _hashes(text)
        for field in {**made, **found}:
            if made.get(field) != found.get(field):
                raise CaseError(
                    f"{path}: {field} was changed after the folder was made, so that it is no longer the case of the "
                    "run; undo the change, or run a copy of the file: `lammps-jump build-and-run COPY`"
                )
    return path


def stored_result(case: ReadCase, folder: Path, setting: Setting) -> Mapping[str, Any]:
    """The summary of a finished run of the same resolved case in the folder, else nothing."""
    try:
        stored, case_file = read_summary(folder), (folder / "case.yaml").read_text()
    except (DumpError, OSError):
        return {}
    known = stored.get("status") == "complete" and stored["case_hash"] == run_key(case, setting)
    whole = all(any(folder.glob(name)) for name in ("profiles.nc", "report.html", "dump.lammps*"))
    return stored if known and whole and case_file == case_text(case) else {}


def result_of(
    case: ReadCase, folder: Path, stored: Mapping[str, Any], setting: Setting, *, write: bool = True
) -> RunResult:
    """The result of a run as its summary holds it, else from what it wrote; see `result_of_files`."""
    if not stored:
        return result_of_files(case.scene(), folder, setting, write=write)
    same = ("engine", "kernel", "status", "steps", "disc_steps", "versions", "ledger")
    return RunResult(
        **{name: stored[name] for name in same},
        **stored["discs"],
        message=stored["message"] or "",
        seconds=stored["wall_seconds"].get("run", 0.0),
        breakdown=stored["breakdown_seconds"] or {},
        resumed=tuple(stored.get("resumed_at", ())),
    )


def result_of_files(scene: Scene, folder: Path, setting: Setting, *, write: bool = True) -> RunResult:
    """What can be said of a run that was killed before it wrote a summary: from its log, else from its dump.

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
        else f"the run was cut off after t = {scene.time(step):.4g} s of {scene.time(scene.steps):.4g} s"
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


def resumable(case: ReadCase, folder: Path, setting: Setting) -> Checkpoint:
    """The checkpoint of the interrupted run of this very case in a folder.

    Raises
    ------
    ResumeError
        No run there, another case, a run that is finished or failed, no checkpoint, one of another program or kernel.
    """
    try:
        stored_case = (folder / "case.yaml").read_text()
    except OSError:
        raise ResumeError(f"{folder}: holds no run that could go on; {ANEW}") from None
    if stored_case != case_text(case):
        raise ResumeError(
            f"{folder / 'case.yaml'}: differs from the case that was asked for, so its run cannot go on as that case; "
            f"`lammps-jump run {folder} --resume` goes on with the one in the folder, --out names another"
        )
    _require_interrupted(case, folder, setting)
    checkpoint = read_checkpoint(folder)
    if checkpoint is None:
        raise ResumeError(f"{folder}: the run has no checkpoint; {ANEW}")
    if checkpoint.scene != fingerprint(case.scene()):
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


def _require_interrupted(case: ReadCase, folder: Path, setting: Setting) -> None:
    status = read_summary(folder).get("status")
    if status == "complete":
        raise ResumeError(f"{folder}: the run is finished, nothing is left to do; {ANEW}")
    if status is None and not (folder / CHECKPOINT_FILE).exists():
        with suppress(DumpError):  # without a dump the checkpoint is asked for
            status = result_of_files(case.scene(), folder, setting, write=False).status
    if status == "complete":
        raise ResumeError(
            f"{folder}: the run reached its end, nothing of it is left to do; only its analysis is missing: "
            f"`lammps-jump analyze {folder}` makes it"
        )
    if status == "failed":
        raise ResumeError(
            f"{folder}: the run has {status} and would fail again from its checkpoint; correct the case and start a "
            "new run"
        )
