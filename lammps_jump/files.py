# SPDX-License-Identifier: GPL-2.0-or-later
"""The files of a run folder: their names, how they are cleared and written whole, and the lock of the folder."""

from __future__ import annotations

import errno
import fcntl
import json
import os
import re
import stat
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
from pydantic_core import to_jsonable_python

from lammps_jump.errors import SetupError

DUMP_NAMES = {"text": "dump.lammpstrj", "gz": "dump.lammpstrj.gz", "binary": "dump.lammpsbin"}
"""File of the dump in a run folder, by its format."""
FIGURES = {
    "depth_profile.png": "Depth and velocity along the channel, mean of the window",
    "depth_map.png": "Depth of the free surface over distance and time",
    "jump_track.png": "The jump in time",
    "jump_stream.png": "The stream before the jump",
    "jump_frame.png": "The jump in its own frame",
    "jump_balance.png": "Where the momentum goes",
    "energy_head.png": "Energy head along the channel",
    "front.png": "Front and column",
    "martin_moyce.png": "Against Martin & Moyce (1952)",
    "forces.png": "Force on the structures",
    "impulse.png": "Impulse",
    "reflected_wave.png": "The reflected wave",
    "energy.png": "Energy of the discs",
    "snapshots.png": "Ten equal times, discs coloured by speed",
    "field_density.png": "Density of the flow",
    "field_pressure.png": "Pressure",
    "bed_pressure.png": "Pressure at the bed against the weight above",
}
"""Pictures in ``figures/``, in the order of the report, with their captions there."""
RUN_FILES = (
    "case.yaml",
    "in.lammps",
    "discs.data",
    "disk.mol",
    "log.lammps",
    *DUMP_NAMES.values(),
    "forces.csv",
    "job.slurm",
    "forces_*.raw",
    "checkpoint.json",
    "checkpoint-[0-9]*.npz",
    "checkpoint-[0-9]*.restart",
    "in.resume.lammps",
    "log.resume.lammps",
    "dump.resume.lammpsbin",
    "stop.request",
)
"""What the engines read and write in a run folder (names and patterns)."""
RESULT_FILES = (
    "profiles.nc",
    "summary.json",
    "animation.mp4",
    "animation.gif",
    "report.html",
    "live.png",
    "profiles.csv",
    "profiles_mean.csv",
    "energy.csv",
    "front.csv",
    "jump_track.csv",
    "jump_frame.csv",
    "jump_stream.csv",
    "reflected_wave.csv",
    "fields.nc",
    "fields.vti",
    "discs[0-9].vtp",
    "discs.pvd",
    "picture[0-9].dat",
    *(f"figures/{name}" for name in FIGURES),
)
"""What is made of them; ``force_<structure>.csv`` besides, where the summary says that it was written."""
LOCK_FILE = ".lock"
"""Held by the one process that writes to a folder; says which."""
ENGINE_PATIENCE = 300
"""Tenths of a second that the engine of a killed run gets to save its state."""
FORCES_HEADER = "time,structure,fx,fy,moment"
"""First line of ``forces.csv``."""
OWN_FILES = (*RUN_FILES, *RESULT_FILES)
"""What a run folder may hold of an earlier run (names and patterns); nothing else in it is ever deleted."""


MOST_JSON = 100_000_000
"""Bytes of a JSON file that is read."""


def clear(folder: Path, patterns: tuple[str, ...]) -> None:
    """Delete the files of a folder that the patterns name; with the results those that its summary names as written."""
    written = _force_tables(folder) if "summary.json" in patterns else []
    for name in written:
        (folder / name).unlink(missing_ok=True)
    for pattern in patterns:
        for old in folder.glob(pattern):
            old.unlink()


def _force_tables(folder: Path) -> list[str]:
    try:
        names = read_json(folder / "summary.json")["files"]
    except (OSError, ValueError, KeyError, TypeError):
        return []
    return [name for name in names if re.fullmatch(r"force_[^/\\]+\.csv", str(name))] if isinstance(names, list) else []


def plain(value: Any) -> Any:
    """Dataclasses to dicts, numpy scalars and arrays to Python, NaN and infinities to None, tuples to lists.

    Raises
    ------
    TypeError
        Something else that JSON does not know.
    """
    return to_jsonable_python(value, inf_nan_mode="null", fallback=_python_of)


def _python_of(value: object) -> object:
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} is not JSON serializable")


def write_text(path: Path, text: str) -> Path:
    """Write a file whole or not at all: a second file, in the same folder, takes its place in one move."""
    new = path.with_name(path.name + ".new")
    new.write_text(text, encoding="utf-8")
    os.replace(new, path)
    return path


def write_json(path: Path, data: object, indent: int = 1) -> Path:
    """Write plain data as JSON, NaN and infinities as null; see `plain` and `write_text`."""
    return write_text(path, json.dumps(plain(data), indent=indent, allow_nan=False) + "\n")


def read_json(path: Path) -> Any:
    """The data of a JSON file.

    Raises
    ------
    OSError, ValueError
        No such file, no regular file, no JSON, or brackets too deep for the reader.
    """
    try:
        return json.loads(read_file(path, MOST_JSON))
    except RecursionError:
        raise ValueError("brackets inside brackets, too deep to be read") from None


def read_file(path: Path, most: int) -> bytes:
    """The bytes of a regular file; OSError for another kind (a pipe or device may never end) or more than `most`."""
    with open(path, "rb", opener=_open_regular) as file:
        data = file.read(most + 1)
    if len(data) > most:
        raise OSError(errno.EFBIG, f"more than {most // 1_000_000} MB")
    return data


def _open_regular(path: str, flags: int) -> int:
    place = os.open(path, flags | os.O_NONBLOCK)  # a pipe without a writer would be waited for
    if not stat.S_ISREG(os.fstat(place).st_mode):
        os.close(place)
        kind = errno.EISDIR if os.path.isdir(path) else errno.EINVAL
        raise OSError(kind, os.strerror(kind) if kind == errno.EISDIR else "no regular file")
    return place


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Be the only writer of a folder while the block runs; the lock ends with the process, however that ends.

    ``.lock`` is held by flock and says which process holds it. Where the file system has no flock, what it says
    decides: the lock of a process that is gone is taken over.

    Raises
    ------
    SetupError
        Another process writes to the folder, or nothing can be written there.
    """
    try:
        lock = _take(folder)
    except OSError as error:
        raise SetupError(
            f"{folder}: cannot be written ({error.strerror or error}); correct its permissions, or use another folder"
        ) from None
    try:
        _wait_for_engine(folder)
        yield
    finally:
        with suppress(OSError):
            os.unlink(folder / LOCK_FILE)
        os.close(lock)


def _take(folder: Path) -> int:
    """Descriptor of the lock file, locked, with this process named in it."""
    path = folder / LOCK_FILE
    while True:
        lock = os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o666)
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            taken = False
        except OSError as error:
            taken = isinstance(error, BlockingIOError) or bool(holder(folder))
        if taken:
            os.close(lock)
            raise _in_use(folder, holder(folder))
        with suppress(FileNotFoundError):
            if os.stat(path).st_ino == os.fstat(lock).st_ino:  # else its holder has just deleted it
                os.ftruncate(lock, 0)
                os.pwrite(lock, (json.dumps(_this_process()) + "\n").encode(), 0)
                return lock
        os.close(lock)


def require_unlocked(folder: Path) -> None:
    """SetupError where another process writes to a folder; nothing is written."""
    if text := holder(folder):
        raise _in_use(folder, text)


def _in_use(folder: Path, text: str) -> SetupError:
    return SetupError(
        f"{folder}: {text or 'another process'} writes to this folder; wait until it has ended, or use another folder"
    )


def holder(folder: Path) -> str:
    """The process that writes to a folder, in words; empty where there is none. Nothing is written or locked."""
    try:
        lock = os.open(folder / LOCK_FILE, os.O_RDONLY | os.O_NONBLOCK | os.O_NOFOLLOW)
    except OSError:
        return ""
    try:
        held = json.loads(os.read(lock, 4096))
        pid, begun, boot, host = int(held["pid"]), held["started"], held["boot"], str(held["host"])[:80]
        here = _this_process()
        if boot == here["boot"]:
            alive = _started(pid) == begun
        elif alive := host != here["host"]:  # flock may know; its answer is no more than a look
            with suppress(OSError):
                fcntl.flock(lock, fcntl.LOCK_SH | fcntl.LOCK_NB)
                alive = False
        return f"process {pid} on {host!r}" if alive else ""
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return ""
    finally:
        os.close(lock)


def _this_process() -> dict[str, str | int]:
    boot = Path("/proc/sys/kernel/random/boot_id")
    return {
        "pid": os.getpid(),
        "started": _started(os.getpid()),
        "boot": boot.read_text().strip() if boot.exists() else "",
        "host": os.uname().nodename,
    }


def _started(pid: int) -> int:
    """Start time of a process in ticks since the boot, 0 where there is none: a pid is given again."""
    try:
        return int(Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[19])
    except OSError:
        return 0


@contextmanager
def engine_at_work(folder: Path) -> Iterator[None]:
    """Mark a folder while an engine's process writes to it: it may outlive the process that holds the lock."""
    place = -1
    with suppress(OSError):  # no flock here, or no folder: the engine says so
        place = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
        fcntl.flock(place, fcntl.LOCK_SH)
    try:
        yield
    finally:
        if place >= 0:
            os.close(place)


def _wait_for_engine(folder: Path) -> None:
    """Wait for the engine of a run whose own process was killed: it saves its state and ends."""
    place = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        for _ in range(ENGINE_PATIENCE):
            try:
                fcntl.flock(place, fcntl.LOCK_EX | fcntl.LOCK_NB)
                return
            except BlockingIOError:
                time.sleep(0.1)
            except OSError:
                return
    finally:
        os.close(place)
    raise _in_use(folder, "the engine of a run that was killed")
