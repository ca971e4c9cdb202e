# SPDX-License-Identifier: GPL-2.0-or-later
"""The cache of compiled code: one folder an entry, named by the hash of all that the code depends on; whom it trusts.

An entry counts only with the record written after it, which holds its checksum: a half-written or damaged file is
made again. It is not used where others may change it.
"""

from __future__ import annotations

import hashlib
import json
import os
import pwd
import stat
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import gettempdir
from typing import Any

from platformdirs import user_cache_path

from lammps_jump.errors import SetupError
from lammps_jump.files import delete, read_file, read_json, write_bytes
from lammps_jump.system import forbids_programs, lock

MOST_LINKS = 40
"""Links on the way to a file, as in Linux."""


def require_own(*files: Path) -> None:
    """SetupError where another user owns or may change a file, a folder above it, or a link on the way to it.

    The way ends at the home folder of this user or at the root, as that of ssh does. Who may write to a folder may put
    another in the place of what it holds, except where the folder is sticky, as /tmp is.
    """
    if path := open_to_others(*files):
        raise SetupError(
            f"{path} belongs to another user, or others may change it, so that no library below it is used; "
            f"if it is yours, `chmod go-w` it, else name a folder of your own in the variable LAMMPS_JUMP_CACHE"
        )


def open_to_others(*files: Path) -> Path | None:
    """First file or folder on the way to some files that another user owns or may change (`require_own`), or None."""
    for path in dict.fromkeys(place for file in files for place in _way(file)):
        with suppress(OSError):  # not there yet
            status, itself = path.stat(), path.lstat()
            shared = stat.S_ISDIR(status.st_mode) and status.st_mode & stat.S_ISVTX
            if not {status.st_uid, itself.st_uid} <= {os.getuid(), 0} or (status.st_mode & 0o022 and not shared):
                return path
    return None


def _way(file: Path, links: int = MOST_LINKS) -> Iterator[Path]:
    """A file and the folders above it, up to the home folder or the root; of a link, what it leads to as well."""
    home = _home()
    for path in (file.absolute(), *file.absolute().parents):
        yield path
        if links and path.is_symlink():
            yield from _way(path.parent / path.readlink(), links - 1)
        if home is not None and path.exists() and path.samefile(home):
            return


def _home() -> Path | None:
    """Home folder of this user in the system's list of users, or None. HOME is not used: others may set it."""
    with suppress(KeyError):
        home = Path(pwd.getpwuid(os.getuid()).pw_dir)
        return home if home.is_dir() else None
    return None


@contextmanager
def locked_alone(file: Path) -> Iterator[None]:
    """Hold the lock of a file, which is this user's alone whatever the umask; the system frees it with the process."""
    place = os.open(file, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_CLOEXEC, 0o600)
    try:
        lock(place, wait=True)
        yield
    finally:
        os.close(place)


# --- the cache of compiled code: one folder an entry, named by the hash of all that the code depends on ---------------


VARIABLE = "LAMMPS_JUMP_CACHE"
"""Names the folder of what is kept, in the environment."""
RECORD, LOCK = "build.json", "lock"
MOST_BYTES = 100_000_000

MOST_OBJECTS = 400
"""Objects that are kept: those of some twenty builds, a few MB each."""

Made = tuple[bytes, dict[str, Any]]
"""Code, and what its record says of it."""


def usual_folder() -> Path:
    """Folder of what is kept: LAMMPS_JUMP_CACHE, else XDG_CACHE_HOME/lammps-jump, else ~/.cache/lammps-jump."""
    override = os.environ.get(VARIABLE)
    return Path(override) if override else user_cache_path("lammps-jump")


def cache_folder() -> Path:
    """Folder of the compiled code, in that of what is kept.

    Where programs may not be run there (noexec), as in the home folders of some clusters, it is in the environment of
    Python, which holds libraries itself, or with the temporary files.

    Raises
    ------
    SetupError
        Programs may not be run in any of them, or in the one that the variable names.
    """
    usual = usual_folder()
    others = () if os.environ.get(VARIABLE) else _others()
    for folder in (usual, *others):
        if not is_noexec(folder) and (folder == usual or not open_to_others(folder)):
            return folder / "kernels"
    raise SetupError(
        f"{usual}: programs may not be run on its file system (noexec); name a folder where they may in the variable "
        f"{VARIABLE}"
    )


def why_elsewhere() -> str:
    """Why the compiled code is not in the usual folder, in one sentence; empty where it is."""
    with suppress(SetupError):
        folder, usual = cache_folder(), usual_folder()
        if folder.parent != usual:
            return f"compiled code is kept in {folder}: programs may not be run in {usual} (noexec)"
    return ""


def is_noexec(folder: Path) -> bool:
    """Tells whether no program or library may be loaded from where a folder is, or would be made."""
    there = next(place for place in (folder.absolute(), *folder.absolute().parents) if place.exists())
    return forbids_programs(there)


def _others() -> Iterator[Path]:
    if sys.prefix != sys.base_prefix and os.access(sys.prefix, os.W_OK):
        yield Path(sys.prefix) / "var" / "lammps-jump"
    yield Path(gettempdir()) / f"lammps-jump-{os.getuid()}"


def record_of(code: Path) -> Path:
    """The file that holds the checksum of a file of code."""
    return code.with_name(RECORD)


def checksum(code: bytes) -> str:
    """SHA-256."""
    return hashlib.sha256(code).hexdigest()


def is_whole(code: Path, is_made: Callable[[bytes], bool]) -> bool:
    """Tells whether a file is there, is what it should be, and is the one that its record was written for."""
    try:
        record, data = read_json(record_of(code)), read_file(code, MOST_BYTES)
        return is_made(data) and record["sha256"] == checksum(data)
    except (OSError, ValueError, KeyError, TypeError):
        return False


def write(code: Path, made: Made) -> None:
    """Write code and then its record, each in one move."""
    data, record = made
    for path, text, mode in (
        (code, data, 0o755),  # whatever the umask of this user: nobody else may write
        (record_of(code), json.dumps({**record, "sha256": checksum(data)}, indent=1).encode() + b"\n", 0o644),
    ):
        write_bytes(path, text, mode)


def forget_old(used: Sequence[Path], most: int = MOST_OBJECTS) -> None:
    """Deletes the entries next to these files of code that were used longest ago, but for the `most` used last.

    Files of other names stay, and so does the folder that holds them. An entry that another process has just made or
    used is among the last.
    """
    with suppress(OSError):
        for code in used:
            os.utime(record_of(code))
        entries = [entry for entry in used[0].parent.parent.iterdir() if not entry.is_symlink() and entry.is_dir()]
        dated = sorted((path.stat().st_mtime, path) for entry in entries if (path := entry / RECORD).is_file())
        for _, record in dated[: max(0, len(dated) - most)]:
            with suppress(OSError):
                # the record goes first: without it nothing counts
                delete(record, record.with_name(used[0].name), record.with_name(LOCK))
                record.parent.rmdir()


def kept(code: Path, is_made: Callable[[bytes], bool], make: Callable[[], Made], force: bool = False) -> Path:
    """The file in the cache; `make` makes what is put there where it is not, one process at a time.

    Raises
    ------
    SetupError
        The cache cannot be written, or another user may change it; what `make` raises.
    """
    require_own(code, record_of(code))
    if not force and is_whole(code, is_made):
        return code
    try:
        for folder in reversed(code.parents):
            folder.mkdir(mode=0o700, exist_ok=True)  # whatever the umask, as for the lock: nobody else may write
        with locked_alone(code.parent / LOCK):
            if force or not is_whole(code, is_made):  # another process may have made it meanwhile
                write(code, make())
    except OSError as error:
        advice = "name a writable folder in the variable LAMMPS_JUMP_CACHE"
        raise SetupError(f"compiled code cannot be kept in {code.parent} ({error}); {advice}") from None
    return code
