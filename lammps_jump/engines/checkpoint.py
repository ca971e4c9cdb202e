# SPDX-License-Identifier: GPL-2.0-or-later
"""State from which a run goes on, whatever ended it: ``checkpoint.json`` next to the engine's files of its state.

The state is LAMMPS' restart file with the velocities of the half step, or an npz file of the native engine; names hold
the step. ``checkpoint.json`` names them and every file that a next part appends to, each with its size and SHA-256. It
is put in its place last and in one move, and the one before stays as ``checkpoint_previous.json``. So there is a whole
checkpoint whenever a run is killed. What a killed part has appended after it is cut off before the next part.
"""

from __future__ import annotations

import hashlib
import json
import logging
import os
import re
import shutil
import sys
import time
import zlib
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass, replace
from math import inf
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, FiniteFloat, NonNegativeInt, StringConstraints, TypeAdapter, ValidationError

from lammps_jump.errors import ResumeError
from lammps_jump.files import (
    BINARY_PART,
    BODIES,
    CONTACTS_FILE,
    DUMP_NAMES,
    POSES,
    cut_to,
    delete,
    flush,
    make_own,
    name_again,
    open_to_read,
    open_to_write,
    plain,
    read_json,
    write_json,
)
from lammps_jump.identity import scene_key
from lammps_jump.quoting import echoed
from lammps_jump.scene.scene import Scene

from .result import KERNELS, RunResult

log = logging.getLogger(__name__)
CHECKPOINT_FILE = "checkpoint.json"
PREVIOUS_FILE = "checkpoint_previous.json"
ANEW = "the same command with --force in place of --resume starts a new run"
"""Remedy where a run cannot go on."""
STATE_FILES = ("checkpoint-[0-9]*.npz", "checkpoint-[0-9]*.restart")
"""Patterns of the engines' own files."""
_NAMES = map(re.escape, ("log.lammps", "forces.csv", CONTACTS_FILE, POSES, BODIES, BINARY_PART, *DUMP_NAMES.values()))
APPENDED = re.compile("|".join([*_NAMES, r"forces_\w+\.raw"]), re.ASCII)
"""Names of the files that a next part may append to."""
SHARE = 0.01
"""Part of a run's time that checkpoints may take; they come more rarely where they take longer."""
CHUNK = 1 << 20


@dataclass(frozen=True)
class FileSum:
    """Size of a file in bytes, and its SHA-256 up to there."""

    size: NonNegativeInt
    sha256: Annotated[str, StringConstraints(pattern=r"^[0-9a-f]{64}$")]


@dataclass(frozen=True)
class Checkpoint:
    """Step at which a run stopped, and what it had done by then.

    Attributes
    ----------
    scene : str
        `lammps_jump.identity.scene_key` of the scene that ran.
    step, time : int, float
        Step of the state, and its simulated time (s).
    state : dict of FileSum
        The engine's files.
    outputs : dict of FileSum
        Files that the next part appends to: dump, log, force record.
    removed : tuple of int
        Discs that each outlet has taken.
    result : RunResult
        Everything up to here, earlier parts included.
    """

    scene: str
    step: Annotated[int, Field(gt=0)]
    time: FiniteFloat
    state: dict[str, FileSum]
    outputs: dict[str, FileSum]
    removed: tuple[NonNegativeInt, ...]
    result: RunResult


class CheckpointWriter:
    """Writes the checkpoints of a part of a run, one in the place of the other.

    Parameters
    ----------
    scene : Scene
    folder : Path
    outputs : iterable of str
        Files that the next part appends to, where they exist. What they have grown by is read once.
    interval : float
        Wall time from one to the next, s; it grows where a checkpoint takes over `SHARE` of it.
    """

    def __init__(self, scene: Scene, folder: Path, outputs: Iterable[str], interval: float = inf):
        self.scene, self.folder, self.interval = scene, folder, interval
        self._outputs = {name: _GrowingFile(folder / name) for name in outputs}
        self.wait()

    def due(self) -> bool:
        """Tell whether it is time for a checkpoint."""
        return time.monotonic() >= self._next

    def wait(self, spent: float = 0.0) -> None:
        """Begin a new interval, after a checkpoint that took so many seconds."""
        self._next = time.monotonic() + max(self.interval, spent / SHARE)

    def save(self, make: Callable[[], Iterable[str]], result: RunResult, removed: tuple[int, ...] = ()) -> str:
        """Make a checkpoint, and begin a new interval; the reason where that cannot be.

        Parameters
        ----------
        make : callable
            Writes the files of the engine's state, whose step is that of `result`, and returns their names.
        """
        started = time.monotonic()
        try:
            self._write(make(), result, removed)
        except OSError as error:
            return f"its state could not be saved ({error})"
        finally:
            self.wait(time.monotonic() - started)
        return ""

    def _write(self, state: Iterable[str], result: RunResult, removed: tuple[int, ...]) -> None:
        """Bring outputs and state to the disk, then put ``checkpoint.json`` in its place, then delete older states."""
        folder, step = self.folder, result.steps
        grown = {name: growing for name, growing in self._outputs.items() if growing.path.exists()}
        states = {name: _GrowingFile(folder / name) for name in state}
        for growing in (*grown.values(), *states.values()):
            flush(growing.path)
        state_sums, sums = ({name: growing.sum() for name, growing in files.items()} for files in (states, grown))
        time = self.scene.time(step)
        put_checkpoint(folder, Checkpoint(scene_key(self.scene), step, time, state_sums, sums, removed, result))
        before = _readable(folder / PREVIOUS_FILE)
        kept = {*states, *(before.state if before else ())}
        for path in _states(folder):
            if path.name not in kept:
                delete(path)


def put_checkpoint(folder: Path, checkpoint: Checkpoint) -> None:
    """Puts ``checkpoint.json`` in its place; the file that is there becomes the previous one."""
    path = folder / CHECKPOINT_FILE
    if path.exists():  # one of the two names always exists
        name_again(path, folder / PREVIOUS_FILE)
    content = plain(asdict(checkpoint))
    write_json(path, {**content, "sum": sum_of(content)})


class _GrowingFile:
    """Checksum of a file that grows: a byte is read once."""

    def __init__(self, path: Path):
        self.path = path
        self._hash = hashlib.sha256()
        self._size = 0

    def sum(self, most: int = sys.maxsize) -> FileSum:
        """Size and checksum of the file, or of so many bytes from its start."""
        with open_to_read(self.path) as file:
            file.seek(self._size)
            while chunk := file.read(min(CHUNK, most - self._size)):
                self._hash.update(chunk)
                self._size += len(chunk)
        return FileSum(self._size, self._hash.hexdigest())


def sum_of(content: dict[str, Any]) -> str:
    """SHA-256 of the other fields of ``checkpoint.json``."""
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def _states(folder: Path) -> list[Path]:
    return [path for pattern in STATE_FILES for path in folder.glob(pattern)]


def has_checkpoint(folder: Path) -> bool:
    """Tell whether there is a checkpoint in a folder, sound or not."""
    return any(os.path.lexists(folder / name) for name in (CHECKPOINT_FILE, PREVIOUS_FILE))


def last_saved(folder: Path) -> float | None:
    """Simulated time of the newest checkpoint, s; None where there is none that can be read."""
    checkpoint = _newest(folder)
    return checkpoint.time if checkpoint else None


def _newest(folder: Path) -> Checkpoint | None:
    """The newest checkpoint that can be read; its files are not looked at."""
    return _readable(folder / CHECKPOINT_FILE) or _readable(folder / PREVIOUS_FILE)


def _readable(path: Path) -> Checkpoint | None:
    """The checkpoint in a file; None where it cannot be read."""
    try:
        return _checked(path)
    except (OSError, ValueError):
        return None


def read_checkpoint(folder: Path) -> Checkpoint | None:
    """The checkpoint of a run folder, None where there is none; the one before where the newest is damaged.

    Raises
    ------
    ResumeError
        None of them is whole: it cannot be read or holds what no run writes, or a file that it names is gone, shorter
        than it was, or another one.
    """
    trouble = None
    for name in (CHECKPOINT_FILE, PREVIOUS_FILE):
        if os.path.lexists(folder / name):
            try:
                checkpoint = _read(folder / name)
            except ResumeError as error:
                trouble = trouble or error
                continue
            if trouble:
                log.info(f"note: {str(trouble).removesuffix(f'; {ANEW}')}; the checkpoint before it is used")
            return checkpoint
    if trouble:
        raise trouble
    return None


def _read(path: Path) -> Checkpoint:
    """A checkpoint whose files are as it says."""
    try:
        checkpoint = _checked(path)
    except (OSError, ValueError) as error:
        raise ResumeError(f"{path}: cannot be read ({error}); {ANEW}") from None
    for name, entry in {**checkpoint.state, **checkpoint.outputs}.items():
        place = path.parent / name
        if place.is_symlink():
            raise ResumeError(f"{place}: is a link; a run goes on only with files in its own folder")
        size = place.stat().st_size if place.exists() else 0
        if size < entry.size or not place.is_file():
            raise ResumeError(
                f"{place}: {size} bytes, {entry.size} or more were there when the run was interrupted; without "
                f"them it cannot go on; {ANEW}"
            )
        if _GrowingFile(place).sum(entry.size) != entry:
            raise ResumeError(f"{place}: is not what the run had written (its SHA-256 differs); {ANEW}")
    return checkpoint


def _checked(path: Path) -> Checkpoint:
    """The checkpoint in a file; ValueError where a value is none that a run writes: names become paths and commands."""
    content = read_json(path)
    if not isinstance(content, dict):
        raise ValueError("it holds no checkpoint")
    stored_sum = content.pop("sum", None)
    try:
        checkpoint = TypeAdapter(Checkpoint).validate_json(json.dumps(content), strict=True)
    except ValidationError as error:
        first = error.errors()[0]
        raise ValueError(f"{'.'.join(map(str, first['loc']))}: {first['msg']}".lstrip(": ")) from None
    kinds = ("npz", "restart") if checkpoint.result.engine == "lammps" else ("npz",)
    if (
        set(checkpoint.state) != {f"checkpoint-{checkpoint.step}.{kind}" for kind in kinds}
        or checkpoint.result.steps != checkpoint.step
    ):
        raise ValueError(f"state: it is not that of step {checkpoint.step}")
    if checkpoint.result.kernel not in KERNELS:
        raise ValueError(f"result.kernel: {echoed(checkpoint.result.kernel)} is not known")
    for name in checkpoint.outputs:
        if not APPENDED.fullmatch(name):
            raise ValueError(f"outputs: {echoed(name)} is no file that a run appends to")
    if stored_sum != sum_of(content):
        raise ValueError("its SHA-256 is not that of its content")
    return checkpoint


def remove_checkpoint(folder: Path) -> None:
    """Delete the checkpoints, the files that make them some first, and the force records of LAMMPS that they name."""
    for name in (CHECKPOINT_FILE, PREVIOUS_FILE):
        delete(folder / name)
    delete(*_states(folder), *folder.glob("forces_*.raw"))


def join_part(folder: Path) -> None:
    """Puts the binary dump of a part that went on after that of the part before; the checkpoint then names it so.

    The file of the part is deleted last: a process that ends before begins again by `cut_back`.
    """
    part, whole = folder / BINARY_PART, folder / DUMP_NAMES["binary"]
    if not part.exists():
        return
    with open_to_read(part) as source, open_to_write(whole, append=True) as target:
        shutil.copyfileobj(source, target)
    flush(whole)
    checkpoint = _newest(folder)
    if checkpoint is not None and BINARY_PART in checkpoint.outputs:
        outputs = dict(checkpoint.outputs)
        size = outputs[whole.name].size + outputs.pop(BINARY_PART).size
        outputs[whole.name] = _GrowingFile(whole).sum(size)
        put_checkpoint(folder, replace(checkpoint, outputs=outputs))
        delete(folder / PREVIOUS_FILE)  # it names the part
    delete(part)


def cut_back(folder: Path, checkpoint: Checkpoint) -> None:
    """Cut off, or delete, what a part that was killed has written since the checkpoint."""
    for name, entry in checkpoint.outputs.items():
        make_own(folder / name)
        cut_to(folder / name, entry.size)
        if name == DUMP_NAMES["gz"]:
            _end_gzip(folder / name)
    for path in folder.iterdir():
        if APPENDED.fullmatch(path.name) and path.name not in (*checkpoint.outputs, "forces.csv", BODIES):
            delete(path)


def _end_gzip(path: Path) -> None:
    """End the last stream of a gzip file that was cut off between two blocks: what is appended begins another one.

    Of RFC 1951 and 1952: an empty last block, the CRC-32 of the data, its length.
    """
    stream, check, length, begun = zlib.decompressobj(31), 0, 0, False
    with open_to_read(path) as file:
        while chunk := file.read(CHUNK):
            while chunk:
                if stream.eof:
                    stream, check, length = zlib.decompressobj(31), 0, 0
                data = stream.decompress(chunk)
                check, length, begun = zlib.crc32(data, check), length + len(data), True
                chunk = stream.unused_data
    if begun and not stream.eof:
        with open_to_write(path, append=True) as file:
            file.write(b"\x03\x00" + check.to_bytes(4, "little") + (length % 2**32).to_bytes(4, "little"))
