# SPDX-License-Identifier: GPL-2.0-or-later
"""Folders that are ours, by their marker; the lock of the one process that writes to a folder."""

from __future__ import annotations

import json
import os
import re
import shutil
import time
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

from .errors import DumpError, SetupError
from .files import (
    COMPARED_FILES,
    FIGURE,
    RESULT_FILES,
    RUN_FILES,
    STAGING,
    STUDY_FILES,
    SWEEP_FILES,
    TABLE,
    delete,
    flush,
    read_json,
    write_json,
    writes,
)
from .foreign import foreign
from .system import boot, lock, started

MARKER_FILE = ".lammps-jump"
"""Makes a folder ours."""
FORCE_TABLE = re.compile(r"force_[^/\\\n]+\.csv")
LOCK_FILE = ".lock"
"""Held by the one process that writes to a folder; says which."""
HOLDS = {
    "run": "a run",
    "analysis": "the analysis of a dump",
    "sweep": "a study",
    "comparison": "curves of a run against measured ones",
}
"""Content of a folder, by the kind of its marker; other kinds are commands."""
COMMAND = re.compile("[a-z][a-z-]{1,30}")
ENGINE_PATIENCE = 300
"""Tenths of a second that the engine of a killed run gets to save its state."""


writable = partial(writes, kind=SetupError, remedy="name another folder with --out, or correct its permissions")
"""An OSError while the block runs becomes a `SetupError` that names the folder given."""


@dataclass(frozen=True)
class Marker:
    """Content of ``.lammps-jump`` in a folder; without that file no folder is ours.

    Attributes
    ----------
    kind : str
        A key of `HOLDS`, or the command of a study.
    files : tuple of str
        Names and patterns of our files there; nothing else is ever deleted or overwritten.
    about : mapping
        Of a run: ``key``, ``case`` and ``program``; of an analysis: ``dump``; of a comparison: ``of``.
    """

    kind: str
    files: tuple[str, ...]
    about: Mapping[str, Any]


def read_marker(folder: Path) -> Marker | None:
    """The marker of a folder, None where there is none; of its names only such as this program writes.

    Raises
    ------
    SetupError
        The file cannot be read.
    """
    path = folder / MARKER_FILE
    if not os.path.lexists(path):
        return None
    with foreign(SetupError, f"{path}: is no marker that can be read", "name another folder with --out"):
        stored = read_json(path)
        known = {*RUN_FILES, *RESULT_FILES, *SWEEP_FILES, *COMPARED_FILES}.union(*STUDY_FILES.values())
        made = (FORCE_TABLE, TABLE, FIGURE)
        names = [name for name in stored["files"] if name in known or any(one.fullmatch(name) for one in made)]
        return Marker(str(stored["kind"]), tuple(names), dict(stored["about"]))


def require_ours(folder: Path, wanted: Marker) -> None:
    """Raise SetupError if unmarked files carry the names of a run, or if a marked folder holds something else."""
    marker = read_marker(folder)
    if marker is not None:
        if marker.kind != wanted.kind:
            made = f"what `lammps-jump {marker.kind}` has made" if COMMAND.fullmatch(marker.kind) else "something else"
            holds = HOLDS.get(marker.kind, made)
            raise SetupError(f"{folder}: holds {holds}, which would be overwritten; name another folder with --out")
        return
    names = [name for pattern in (*wanted.files, STAGING) for name in standing(folder, pattern)]
    if (folder / "figures").is_symlink():
        names.append("figures")
    if names:
        more = f" and {len(names) - 3} more" if len(names) > 3 else ""
        raise SetupError(
            f"{folder}: was not made by lammps-jump (no {MARKER_FILE} in it) and holds {', '.join(names[:3])}{more}; "
            "nothing there is overwritten: name another folder with --out, or move what stands there"
        )


def claim(folder: Path, marker: Marker) -> bool:
    """Make a folder ours that this process holds (`locked`), see `require_ours`; whether it was not before."""
    require_ours(folder, marker)
    if read_marker(folder) is not None:
        return False
    write_marker(folder, marker)
    return True


def write_marker(folder: Path, marker: Marker) -> None:
    """Write or renew the marker of a folder that is ours."""
    write_json(folder / MARKER_FILE, {"format": 1, **asdict(marker)})


def standing(folder: Path, pattern: str) -> list[str]:
    """Names in a folder that a pattern means, links that lead nowhere included."""
    if "*" in pattern or "[" in pattern:
        return sorted(str(path.relative_to(folder)) for path in folder.glob(pattern))
    return [pattern] if os.path.lexists(folder / pattern) else []


def clear(folder: Path, patterns: Iterable[str]) -> None:
    """Delete the files of a folder that the patterns name, where its marker lists them."""
    marker = read_marker(folder)
    for pattern in set(patterns) & set(marker.files if marker else ()):
        if "/" in pattern and (folder / pattern).parent.is_symlink():
            continue
        for name in standing(folder, pattern):
            if (folder / name).is_symlink() or not (folder / name).is_dir():
                delete(folder / name)


def force_tables(names: Iterable[str]) -> list[str]:
    """Names of the tables of the force on structures, among other names."""
    return [name for name in names if FORCE_TABLE.fullmatch(name)]


@contextmanager
def staging(folder: Path) -> Iterator[Path]:
    """An empty folder in a folder that is ours, for results until they are whole; it is deleted after the block."""
    stage = folder / STAGING
    if stage.is_symlink():
        delete(stage)
    shutil.rmtree(stage, ignore_errors=True)
    stage.mkdir()
    try:
        yield stage
    finally:
        shutil.rmtree(stage, ignore_errors=True)


@contextmanager
def results_folder(folder: Path, marker: Marker, of: str) -> Iterator[Path]:
    """A `staging` folder in a folder of results, made and held; without results nothing is left.

    `of` is the key in ``marker.about`` of what the results are of: a folder with those of another one is refused.
    """
    new, fresh = not folder.exists(), False
    try:
        require_ours(folder, marker)
        folder.mkdir(parents=True, exist_ok=True)
        with locked(folder):
            fresh = claim(folder, marker)
            known = read_marker(folder)
            if known is not None and (there := known.about.get(of)) != marker.about[of]:
                raise SetupError(f"{folder}: holds the {marker.kind} of {there}; name another folder with --out")
            with staging(folder) as stage:
                yield stage
    except BaseException as error:
        if fresh:
            delete(folder / MARKER_FILE)
        if new and folder.is_dir():
            folder.rmdir()
        if isinstance(error, OSError):
            raise DumpError(f"{folder}: cannot be written ({error.strerror or error}); name another folder") from None
        raise


def publish(stage: Path, folder: Path) -> list[str]:
    """Move the files of a `staging` folder into their places, each in one move; their names. Links stay.

    SetupError, before anything is moved, where the path to a place has a link.
    """
    files = sorted(path for path in stage.rglob("*") if path.is_file() and not path.is_symlink())
    names = [str(path.relative_to(stage)) for path in files]
    for name in names:
        _require_inside(folder, name)
    for name in names:
        target = folder / name
        target.parent.mkdir(exist_ok=True)
        flush(stage / name)
        os.replace(stage / name, target)
    return names


def require_no_link(folder: Path) -> None:
    """SetupError where a link is in the place of a folder of this program: it leads to files of others."""
    if folder.is_symlink():
        raise SetupError(f"{folder}: is a link to another place, where nothing is written; delete the link")


def _require_inside(folder: Path, name: str) -> None:
    """SetupError where the folder of a file, in a folder that is ours, is a link."""
    place = (folder / name).parent
    if place != folder:
        require_no_link(place)


def require_replaceable(folder: Path, name: str) -> None:
    """SetupError where a file cannot be put: it exists and is not of this program, or its folder is a link."""
    _require_inside(folder, name)
    path = folder / name
    if os.path.lexists(path):
        marker = read_marker(folder)
        if marker is None or not any(path.match(pattern) for pattern in marker.files):
            raise SetupError(
                f"{path}: stands there already and is not overwritten; delete it, or name another with --out"
            )


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
    with writable(folder):
        place = _take(folder)
    try:
        _wait_for_engine(folder)
        yield
    finally:
        with suppress(OSError):
            os.unlink(folder / LOCK_FILE)
        os.close(place)


def _take(folder: Path) -> int:
    """Descriptor of the lock file, locked, with this process named in it."""
    path = folder / LOCK_FILE
    while True:
        place = os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o666)
        try:
            lock(place)
            taken = False
        except OSError as error:
            taken = isinstance(error, BlockingIOError) or bool(holder(folder))
        if taken:
            os.close(place)
            raise _in_use(folder, holder(folder))
        with suppress(FileNotFoundError):
            if os.stat(path).st_ino == os.fstat(place).st_ino:  # else its holder has just deleted it
                os.ftruncate(place, 0)
                os.pwrite(place, (json.dumps(_this_process()) + "\n").encode(), 0)
                return place
        os.close(place)


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
        place = os.open(folder / LOCK_FILE, os.O_RDONLY | os.O_NONBLOCK | os.O_NOFOLLOW)
    except OSError:
        return ""
    try:
        held = json.loads(os.read(place, 4096))
        pid, begun, boot, host = int(held["pid"]), held["started"], held["boot"], str(held["host"])[:80]
        here = _this_process()
        if boot == here["boot"]:
            alive = started(pid) == begun
        elif alive := host != here["host"]:  # flock may know; its answer is no more than a look
            with suppress(OSError):
                lock(place, shared=True)
                alive = False
        return f"process {pid} on {host!r}" if alive else ""
    except Exception:  # whatever is there was written by no run
        return ""
    finally:
        os.close(place)


def _this_process() -> dict[str, str | int]:
    return {"pid": os.getpid(), "started": started(os.getpid()), "boot": boot(), "host": os.uname().nodename}


@contextmanager
def engine_at_work(folder: Path) -> Iterator[None]:
    """Mark a folder while an engine's process writes to it: it may outlive the process that holds the lock."""
    place = -1
    with suppress(OSError):  # no flock here, or no folder: the engine says so
        place = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
        lock(place, shared=True, wait=True)
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
                lock(place)
                return
            except BlockingIOError:
                time.sleep(0.1)
            except OSError:
                return
    finally:
        os.close(place)
    raise _in_use(folder, "the engine of a run that was killed")
