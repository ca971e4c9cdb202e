# SPDX-License-Identifier: GPL-2.0-or-later
"""Differences between operating systems; no other module asks which one this is.

Linux has the first branch of each function, and runs in the tests. The other one is that of macOS, which has POSIX and
`psutil` for the rest: tests run it on Linux, with what macOS lacks taken away. Nobody ran it on macOS. Windows has
neither `fcntl` nor signals of POSIX; `docs/bits.md` lists what is missing there.
"""

from __future__ import annotations

import ctypes
import errno
import fcntl
import os
import platform
import re
import resource
import signal
import sys
from collections.abc import Collection, Iterator
from contextlib import contextmanager, suppress
from itertools import islice
from pathlib import Path

from .errors import SetupError

LINUX = sys.platform == "linux"
CONTROL_GROUPS = Path("/sys/fs/cgroup")
PIECE, MOST_PIECES = 1 << 16, 160
"""Bytes of a piece of what the system tells, such as its processors, and pieces that are read."""
_HERE, _EXCHANGE = -100, 2
"""AT_FDCWD of Linux; RENAME_EXCHANGE of Linux and RENAME_SWAP of macOS."""
_COPY_LISTS_AND_MORE = 1 << 0 | 1 << 2
"""COPYFILE_ACL and COPYFILE_XATTR of macOS."""


def told(path: str | Path) -> str:
    """The text of a file that the system makes, whose size it does not tell; empty where there is none."""
    try:
        with open(path, "rb", buffering=0) as file:  # Linux refuses to read more than 4 MB of some at once
            pieces = islice(iter(lambda: file.read(PIECE), b""), MOST_PIECES)
            return b"".join(pieces).decode(errors="replace")
    except OSError:
        return ""


# processors


def processor_lines() -> list[str]:
    """Lines of Linux on the processors; nothing on other systems."""
    return told("/proc/cpuinfo").splitlines()


def own_cores() -> set[int]:
    """Numbers of the cores that this process may use; all where the system does not know."""
    if hasattr(os, "sched_getaffinity"):
        return os.sched_getaffinity(0)
    return set(range(os.cpu_count() or 1))


@contextmanager
def only_on(wanted: Collection[int]) -> Iterator[None]:
    """Use these cores alone, in this process and those that it starts, while the block runs; all where none is named.

    Raises
    ------
    SetupError
        The system cannot bind a process to cores.
    """
    if not wanted:
        yield
        return
    if not hasattr(os, "sched_setaffinity"):
        raise SetupError(f"{platform.system()} cannot bind a process to cores, which this needs; use Linux for it")
    before = own_cores()
    os.sched_setaffinity(0, wanted)
    try:
        yield
    finally:
        os.sched_setaffinity(0, before)


def control_group() -> str:
    """Path of the control group (version 2) of this process below `CONTROL_GROUPS`; empty where there is none."""
    return told("/proc/self/cgroup").rpartition("::")[2].strip().lstrip("/")


# processes


def boot() -> str:
    """Name of this boot of the machine."""
    if LINUX:
        return told("/proc/sys/kernel/random/boot_id").strip()
    import psutil

    return str(round(psutil.boot_time()))


def started(pid: int) -> int:
    """Start of a process, in ticks of 10 ms; 0 where there is none: a pid is given again."""
    if LINUX:
        return int([*told(f"/proc/{pid}/stat").rpartition(")")[2].split(), *20 * "0"][19])
    import psutil

    try:
        return round(100 * psutil.Process(pid).create_time())
    except psutil.Error:
        return 0


def shared_memory(name: str) -> list[Path]:
    """Files of shared memory that this process uses and whose names, a pattern, are there; none but on Linux."""
    mapped = told("/proc/self/maps")
    return sorted({Path(path) for path in re.findall(rf"(/dev/shm/{name})$", mapped, re.MULTILINE)})


@contextmanager
def within_memory(most: int) -> Iterator[None]:
    """Let this process take at most so many bytes of data while the block runs; a system but Linux may not heed it."""
    before = resource.getrlimit(resource.RLIMIT_DATA)
    refused = () if LINUX else (OSError, ValueError)
    if before[0] == resource.RLIM_INFINITY or before[0] > most:
        with suppress(*refused):
            resource.setrlimit(resource.RLIMIT_DATA, (most, before[1]))
    try:
        yield
    finally:
        with suppress(*refused):
            resource.setrlimit(resource.RLIMIT_DATA, before)


# libraries


def library(name: str, version: str = "") -> str:
    """File of a shared library: ``libmpi.so.12`` of libmpi and 12."""
    parts = [name, "so", version] if LINUX else [name, version, "dylib"]
    return ".".join(filter(None, parts))


def native_flags() -> tuple[str, ...]:
    """Flags by which a compiler makes code for this very processor."""
    return ("-march=native",) if LINUX or platform.machine() == "x86_64" else ("-mcpu=native",)


def plugin_flags() -> tuple[str, ...]:
    """Flags of a link whose missing names the program that loads the library has."""
    return () if LINUX else ("-undefined", "dynamic_lookup")


def libraries_version() -> str:
    """Version of the libraries of the system, which decides what loads."""
    if LINUX:
        with suppress(ValueError, OSError):
            return os.confstr("CS_GNU_LIBC_VERSION") or "unknown"
        return "unknown"
    return platform.release()


# files


def forbids_programs(folder: Path) -> bool:
    """Tells whether no program may be loaded from the file system of a folder; False where it does not tell."""
    return bool(os.statvfs(folder).f_flag & getattr(os, "ST_NOEXEC", 0))


def lock(place: int, *, shared: bool = False, wait: bool = False) -> None:
    """Lock an open file or folder until it is closed.

    Raises
    ------
    BlockingIOError
        Another process has it, and this one does not wait.
    OSError
        The file system has no locks.
    """
    fcntl.flock(place, (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | (0 if wait else fcntl.LOCK_NB))


def lent(place: int, *, whole: bool = False) -> bool:
    """Tells whether no other program has an open file open for writing, or, `whole`, at all.

    With `whole` programs that would open it wait until it is closed here, or `taken_back`. True where the system does
    not know.
    """
    if not hasattr(fcntl, "F_SETLEASE"):
        return True
    try:
        # a program that waits is notified by this signal, which is ignored; the usual one would end this process
        fcntl.fcntl(place, fcntl.F_SETSIG, signal.SIGURG)
        fcntl.fcntl(place, fcntl.F_SETLEASE, fcntl.F_WRLCK if whole else fcntl.F_RDLCK)
        if not whole:
            fcntl.fcntl(place, fcntl.F_SETLEASE, fcntl.F_UNLCK)
    except OSError as error:
        return error.errno != errno.EAGAIN
    return True


def taken_back(place: int) -> None:
    """Let other programs open a file that was `lent` whole."""
    if hasattr(fcntl, "F_SETLEASE"):
        with suppress(OSError):
            fcntl.fcntl(place, fcntl.F_SETLEASE, fcntl.F_UNLCK)


def exchanged(first: Path, second: Path) -> bool:
    """Exchange two files in one move; False where the system cannot, and nothing is done.

    Raises
    ------
    OSError
        The files cannot be exchanged.
    """
    system = ctypes.CDLL(None, use_errno=True)
    names = os.fsencode(first), os.fsencode(second)
    if hasattr(system, "renameat2"):
        done = system.renameat2(_HERE, names[0], _HERE, names[1], _EXCHANGE)
    elif hasattr(system, "renamex_np"):
        done = system.renamex_np(*names, _EXCHANGE)
    else:
        return False
    if done == 0:
        return True
    code = ctypes.get_errno()
    if code not in (errno.EINVAL, errno.ENOSYS, errno.ENOTSUP):
        raise OSError(code, os.strerror(code), str(second))
    return False


def give_further_attributes(place: int, like: int) -> None:
    """Give an open file the attributes of another that are neither owner nor mode; nothing where there are none."""
    if hasattr(os, "listxattr"):
        names: list[str] = []
        with suppress(OSError):  # a file system without them
            names = os.listxattr(like)
        for name in names:
            os.setxattr(place, name, os.getxattr(like, name))
        return
    copy = getattr(ctypes.CDLL(None, use_errno=True), "fcopyfile", None)
    if copy is not None and copy(like, place, None, _COPY_LISTS_AND_MORE) != 0:
        code = ctypes.get_errno()
        raise OSError(code, os.strerror(code))
