# SPDX-License-Identifier: GPL-2.0-or-later
"""What an interrupted run leaves so that it can go on: ``checkpoint.json`` beside the engine's own file of its state.

The engine's file is LAMMPS' binary restart file or an npz file of the native engine; its name holds the step, and
``checkpoint.json``, which names it, is put in its place last and in one move: whenever a run is killed there is a whole
checkpoint, the old or the new one. It also holds the lengths of the files that the next part appends to, so that what
a killed part has appended is cut off before the next one.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated

from pydantic import Field, FiniteFloat, NonNegativeInt, TypeAdapter, ValidationError

from lammps_jump.errors import ResumeError
from lammps_jump.files import DUMP_NAMES, MOST_JSON, make_own, read_file, write_json
from lammps_jump.provenance import fingerprint
from lammps_jump.scene.scene import Scene

from .result import RunResult

CHECKPOINT_FILE = "checkpoint.json"
ANEW = "the same command with --force in place of --resume starts a new run"
"""What to do where a run cannot go on."""
STATE_FILES = ("checkpoint-[0-9]*.npz", "checkpoint-[0-9]*.restart")
"""Patterns of the engines' own files."""
STATE_NAME = re.compile(r"checkpoint-([0-9]+)\.(?:npz|restart)")
APPENDED = ("log.lammps", "forces.csv", *DUMP_NAMES.values())
"""Files that a next part may append to."""


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
    step: Annotated[int, Field(gt=0)]
    time: FiniteFloat
    state: str
    sizes: dict[str, NonNegativeInt]
    removed: tuple[NonNegativeInt, ...]
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
        Where it cannot be read or holds what no run writes, or what it names is gone or shorter than it was.
    """
    path = folder / CHECKPOINT_FILE
    if not path.exists():
        return None
    try:
        checkpoint = _checked(read_file(path, MOST_JSON))
    except (OSError, ValueError) as error:
        raise ResumeError(f"{path}: cannot be read ({error}); {ANEW}") from None
    for name, size in {checkpoint.state: 1, **checkpoint.sizes}.items():
        if (folder / name).is_symlink():
            raise ResumeError(f"{folder / name}: is a link; a run goes on only with files in its own folder")
        found = (folder / name).stat().st_size if (folder / name).exists() else 0
        if found < size:
            raise ResumeError(
                f"{folder / name}: {found} bytes, {size} or more were there when the run was interrupted; without "
                f"them it cannot go on; {ANEW}"
            )
    return checkpoint


def _checked(text: bytes) -> Checkpoint:
    """The checkpoint in a file; ValueError where a value is none that a run writes: names become paths and commands."""
    try:
        found = TypeAdapter(Checkpoint).validate_json(text, strict=True)
    except ValidationError as error:
        first = error.errors()[0]
        raise ValueError(f"{'.'.join(map(str, first['loc']))}: {first['msg']}".lstrip(": ")) from None
    named = STATE_NAME.fullmatch(found.state)
    if named is None or int(named[1]) != found.step or found.result.steps != found.step:
        raise ValueError(f"state: {found.state!r} is not the state of step {found.step}")
    if found.result.kernel not in ("stock", "compiled", "numba"):
        raise ValueError(f"result.kernel: {found.result.kernel!r} is not known")
    for name in found.sizes:
        if name not in APPENDED:
            raise ValueError(f"sizes: {name!r} is no file that a run appends to")
    return found


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
