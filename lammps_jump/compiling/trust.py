# SPDX-License-Identifier: GPL-2.0-or-later
"""Trust in a library before it runs as code of this user; the lock of those who build one."""

from __future__ import annotations

import os
import pwd
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from lammps_jump.errors import SetupError
from lammps_jump.system import lock

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
    """Part of the way to some files that another user owns or may change, see `require_own`; None where nothing is."""
    for path in dict.fromkeys(place for file in files for place in _way(file)):
        with suppress(OSError):  # not there yet
            found, itself = path.stat(), path.lstat()
            shared = stat.S_ISDIR(found.st_mode) and found.st_mode & stat.S_ISVTX
            if not {found.st_uid, itself.st_uid} <= {os.getuid(), 0} or (found.st_mode & 0o022 and not shared):
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
    """Home folder of this user by the system's list of users, whatever HOME says; None where there is none."""
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
