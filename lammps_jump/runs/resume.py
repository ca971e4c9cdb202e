# SPDX-License-Identifier: GPL-2.0-or-later
"""Whether a run folder holds an interrupted run of a case that can go on."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

from lammps_jump.case.case import ReadCase
from lammps_jump.engines.checkpoint import CHECKPOINT_FILE, Checkpoint, read_checkpoint
from lammps_jump.engines.setting import Setting
from lammps_jump.errors import DumpError, ResumeError
from lammps_jump.provenance import fingerprint

from .folder import result_of_files
from .summary import read_summary

ANEW = "the same command without --resume starts a new run"


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
    if stored_case != case.to_yaml():
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
