# SPDX-License-Identifier: GPL-2.0-or-later
"""What an interrupted run leaves so that it can go on: ``checkpoint.json`` beside the engine's own file of its state.

The engine's file is LAMMPS' binary restart file or an npz file of the native engine; its name holds the step, and
``checkpoint.json``, which names it, is put in its place last and in one move: whenever a run is killed there is a whole
checkpoint, the old or the new one. It also holds the lengths of the files that the next part appends to, so that what
a killed part has appended is cut off before the next one.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from pathlib import Path

from lammps_jump.errors import ResumeError
from lammps_jump.files import make_own, write_json
from lammps_jump.provenance import fingerprint
from lammps_jump.scene.scene import Scene

from .result import RunResult

CHECKPOINT_FILE = "checkpoint.json"
ANEW = "the same command with --force in place of --resume starts a new run"
"""What to do where a run cannot go on."""
STATE_FILES = ("checkpoint-[0-9]*.npz", "checkpoint-[0-9]*.restart")
"""Patterns of the engines' own files."""


@dataclass(frozen=True)
class Checkpoint:
    """Where a run stopped, and what it had done by then.

    Attributes
    ----------
    scene : str
        `lammps_jump.provenance.fingerprint` of the scene that ran.
    step, time : int, float
        Step of the state, and its simulated time (s).
    state : str
        The engine's file.
    sizes : dict of int
        Bytes of the files (dump, log) that the next part appends to.
    removed : tuple of int
        Discs that each outlet has taken.
    result : RunResult
        Everything up to here, earlier parts included.
    """

    scene: str
    step: int
    time: float
    state: str
    sizes: dict[str, int]
    removed: tuple[int, ...]
    result: RunResult


def write_checkpoint(
    scene: Scene, folder: Path, state: str, files: Iterable[str], result: RunResult, removed: tuple[int, ...] = ()
) -> None:
    """Put ``checkpoint.json`` into its place, then delete the states of earlier ones; see `Checkpoint`.

    Parameters
    ----------
    files : iterable of str
        Files that the next part appends to, where they exist.
    """
    sizes = {name: (folder / name).stat().st_size for name in files if (folder / name).exists()}
    step = result.steps
    checkpoint = Checkpoint(fingerprint(scene), step, scene.time(step), state, sizes, removed, result)
    write_json(folder / CHECKPOINT_FILE, asdict(checkpoint))
    for pattern in STATE_FILES:
        for path in folder.glob(pattern):
            if path.name != state:
                path.unlink()


def read_checkpoint(folder: Path) -> Checkpoint | None:
    """The checkpoint of a run folder, None where there is none.

    Raises
    ------
    ResumeError
        Where it cannot be read, or what it names is gone or shorter than it was.
    """
    path = folder / CHECKPOINT_FILE
    if not path.exists():
        return None
    try:
        stored = json.loads(path.read_text())
        result = RunResult.from_json(stored["result"])
        checkpoint = Checkpoint(**{**stored, "removed": tuple(stored["removed"]), "result": result})
    except (OSError, ValueError, TypeError, KeyError) as error:
        raise ResumeError(
            f"{path}: cannot be read ({error}); the same command with --force in place of --resume starts anew"
        ) from None
    for name, size in {checkpoint.state: 1, **checkpoint.sizes}.items():
        found = (folder / name).stat().st_size if (folder / name).exists() else 0
        if found < size:
            raise ResumeError(
                f"{folder / name}: {found} bytes, {size} or more were there when the run was interrupted; without "
                f"them it cannot go on; {ANEW}"
            )
    return checkpoint


def remove_checkpoint(folder: Path) -> None:
    """Delete a checkpoint, the file that makes it one first."""
    (folder / CHECKPOINT_FILE).unlink(missing_ok=True)
    for pattern in STATE_FILES:
        for path in folder.glob(pattern):
            path.unlink()


def cut_back(folder: Path, checkpoint: Checkpoint) -> None:
    """Cut off what a part that was killed has appended since the checkpoint."""
    for name, size in checkpoint.sizes.items():
        make_own(folder / name)
        os.truncate(folder / name, size)
