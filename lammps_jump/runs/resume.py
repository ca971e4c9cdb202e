"""Go on with an interrupted run in its folder: is it the same case, and is there a checkpoint?"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from lammps_jump.case import resolved_yaml
from lammps_jump.engines.checkpoint import CHECKPOINT_FILE, Checkpoint, fingerprint, read_checkpoint
from lammps_jump.errors import CaseError, ResumeError

from . import start as pipeline
from . import summary as summaries
from .reopen import reached_end
from .start import Prepared

ANEW = "the same command without --resume starts anew"


def resume_case(
    path: str | Path,
    *,
    out: Path | None = None,
    assignments: list[str] | None = None,
    quiet: bool = False,
    live: bool = False,
    say: Callable[[str], None] = print,
) -> dict[str, Any]:
    """Go on with the interrupted run of a case; the summary is of the whole run.

    Raises
    ------
    CaseError, SetupError, ResumeError
        Before anything is touched: also where the folder holds no interrupted run of this case.
    RunError, RunInterrupted
        As `lammps_jump.runs.start.build_and_run`.
    """
    return resume_prepared(pipeline.prepare(path, assignments or [], out), quiet=quiet, live=live, say=say)


def resume_prepared(
    prepared: Prepared, *, quiet: bool = False, live: bool = False, say: Callable[[str], None] = print
) -> dict[str, Any]:
    """`resume_case` of a case that is prepared already."""
    checkpoint = resumable(prepared)
    if live and prepared.loaded.case.run.dump_format != "text":
        raise CaseError(f"--live reads text dumps; run.dump_format is {prepared.loaded.case.run.dump_format}")
    prepared = replace(prepared, setting=replace(prepared.setting, kernel=checkpoint.result.kernel))
    for note in (*prepared.scene.warnings, *prepared.notes):
        say(f"note: {note}")
    scene = prepared.scene
    say(
        f"{scene.name}: goes on at t = {checkpoint.time:.4g} s of {scene.time(scene.steps):.4g} s "
        f"(step {checkpoint.step} of {scene.steps}) -> {prepared.folder}"
    )
    stored = summaries.read_summary(prepared.folder) or {}
    before = {name: value or 0.0 for name, value in (stored.get("wall_seconds") or {}).items()}
    return pipeline.run_folder(
        prepared,
        build_seconds=before.get("build", 0.0),
        analysis_seconds=before.get("analysis", 0.0),
        quiet=quiet,
        live=live,
        say=say,
        resume=checkpoint,
    )


def resumable(prepared: Prepared) -> Checkpoint:
    """The checkpoint of the interrupted run of this very case in its folder.

    Raises
    ------
    ResumeError
        No run there, another case, a run that is finished or failed, no checkpoint, one of another program or kernel.
    """
    folder = prepared.folder
    try:
        stored_case = (folder / "case.yaml").read_text()
    except OSError:
        raise ResumeError(f"{folder}: holds no run that could go on; {ANEW}") from None
    if stored_case != resolved_yaml(prepared.loaded.case):
        raise ResumeError(
            f"{folder / 'case.yaml'}: differs from the case that was asked for, so that its run is not this one's "
            f"beginning; `lammps-jump run {folder} --resume` goes on with the one in the folder, --out names another"
        )
    stored = summaries.read_summary(folder)
    status = (stored or {}).get("status", "interrupted")
    if status == "complete":
        raise ResumeError(f"{folder}: the run is finished, nothing is left to do; {ANEW}")
    if stored is None and not (folder / CHECKPOINT_FILE).exists() and reached_end(prepared):
        raise ResumeError(
            f"{folder}: the run reached its end, nothing of it is left to do; only its analysis is missing: "
            f"`lammps-jump analyze {folder}` makes it"
        )
    if status != "interrupted":
        raise ResumeError(f"{folder}: the run has {status}, and would again from there; mend the case and start anew")
    checkpoint = read_checkpoint(folder)
    if checkpoint is None:
        raise ResumeError(f"{folder}: the run left no checkpoint to go on from; {ANEW}")
    if checkpoint.scene != fingerprint(prepared.scene):
        raise ResumeError(
            f"{folder}: this version of lammps-jump makes other numbers of the same case than the one that began the "
            f"run; go on with that one, or start anew"
        )
    kernel = checkpoint.result.kernel
    if kernel == "compiled" and prepared.setting.plugin is None:
        raise ResumeError(
            f"{folder}: began with the compiled kernel, which cannot be used now: see `lammps-jump doctor`"
        )
    if checkpoint.result.engine != prepared.loaded.case.engine.name:
        raise ResumeError(f"{folder}: began on the {checkpoint.result.engine} engine; {ANEW}")
    return checkpoint
