# SPDX-License-Identifier: GPL-2.0-or-later
"""The files of the program: their names, and the one door through which each is read, written and deleted.

Only regular files are read: a pipe or a device may never end. Nothing is written through a link. What is no output of
an engine is written whole or not at all. `tests/test_house.py` refuses other ways.
"""

from __future__ import annotations

import errno
import hashlib
import io
import json
import os
import re
import secrets
import shutil
import stat
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from difflib import SequenceMatcher
from math import prod
from pathlib import Path
from typing import IO, Any

import numpy as np
from pydantic_core import to_jsonable_python

from .errors import DumpError, JumpError
from .foreign import foreign
from .system import exchanged, give_further_attributes, lent, taken_back

DUMP_NAMES = {"text": "dump.lammpstrj", "gz": "dump.lammpstrj.gz", "binary": "dump.lammpsbin"}
"""File of the dump in a run folder, by its format."""
CONTACTS_FILE = "contacts.bin"
"""Contacts of each frame with their forces, where the scene asks for them."""
SCENE_FILE = "scene.image"
"""Law, walls and events of a scene as the core has them, for the compiled styles of LAMMPS."""
CURVES = "curves.json"
"""Curves that the page draws, by the name of the figure."""
PLAYER = "player.json"
"""Header and packed frames of a member, for the page of its study."""
BINARY_PART = "dump.resume.lammpsbin"
"""Binary dump of a part that goes on: LAMMPS appends to text and gzip dumps only."""
POSES, POSES_HEADER = "walls.csv", "time,wall,x,y,angle"
"""Places of walls that the discs push, a row a wall and frame, and its first line."""
BODIES, BODIES_HEADER = "bodies.csv", "time,body,x,y,angle,vx,vy,spin,fx,fy,moment"
"""Places and velocities of bodies, and the force of the discs on them, against time; and its first line."""
PRESSURE_FILE = "pressure.npz"
"""Forces on stretches of outlines against time, as the native engine sums them."""
SUMMARY_FILE = "summary.json"
END_FILE = "end.npz"
"""State of the discs at the end of a run, with all digits."""
START_FILE = "start-{key}.npz"
"""The same of an earlier run, in the folder of a run that goes on from it; named by its hash."""
STAGING = ".analysis.new"
"""Folder of results until they are whole, in the folder that they are for."""
PICTURES = ("png", "pdf", "svg")
"""Formats of figures."""
JOB_FILE = "job.slurm"
RANKS_FILE = ".ranks.job"
"""The job of several ranks, which each of them reads; deleted at the end of the run."""
RUN_FILES = (
    "case.yaml",
    "in.lammps",
    "in.plugin.lammps",
    "scene.image",
    "discs.data",
    "disk.mol",
    "inflow.turns",
    "log.lammps",
    *DUMP_NAMES.values(),
    "forces.csv",
    CONTACTS_FILE,
    POSES,
    BODIES,
    PRESSURE_FILE,
    JOB_FILE,
    "forces_*.raw",
    "checkpoint.json",
    "checkpoint_previous.json",
    "checkpoint-[0-9]*.npz",
    "checkpoint-[0-9]*.restart",
    "in.resume.lammps",
    BINARY_PART,
    "stop.request",
    END_FILE,
    "start-[0-9a-f]*.npz",
    RANKS_FILE,
)
"""Files that the engines read and write in a run folder (names and patterns)."""
CRATE = "ro-crate-metadata.json"
EXPORTS = {
    "csv": ("profiles.csv", "profiles_mean.csv"),
    "vtk": ("discs[0-9].vtp", "discs.pvd", "fields.vti", "walls.vtp", "walls[0-9].vtp", "walls.pvd"),
    "pictures": ("picture[0-9].dat",),
}
"""Names of the files that an export of each kind writes."""
RESULT_FILES = (
    "profiles.nc",
    SUMMARY_FILE,
    CURVES,
    PLAYER,
    "animation.mp4",
    "animation.gif",
    "report.html",
    "live.png",
    "fields.nc",
    CRATE,
    *(name for names in EXPORTS.values() for name in names),
)
"""Files that are made of them, tables and figures of the analyses besides (`lammps_jump.analysis.quantities`)."""
TABLE, FIGURE = re.compile(r"[a-z][a-z0-9_]*\.csv"), re.compile(rf"figures/[a-z0-9_]+\.({'|'.join(PICTURES)})")
"""Names of tables and figures of the analyses."""
ARRAY_FILE = "sweep.slurm"
SWEEP_FILES = (
    "study.yaml", "points.json", "summary.json", "table.csv", "table.nc", "sweep.html", ARRAY_FILE, CRATE,
    *(f"figures/sweep_*.{ending}" for ending in PICTURES),
)  # fmt: skip
"""Files that the folder of a study holds beside ``runs/`` (names and patterns)."""
_BENCHMARKS = ("bench", "cells", "skips", "speed", "overhead", "collision", "page")
STUDY_FILES = {
    "bench": (*(f"{name}.{end}" for name in _BENCHMARKS for end in ("json", "md")), "bench_*.png", "cells.png"),
    "calibrate": (
        "study.yaml",
        "rounds.json",
        "calibration.json",
        "calibration.html",
        "samples.nc",
        "best.yaml",
        *(f"figures/calibration_*.{ending}" for ending in PICTURES),
    ),
    "budget": ("budget.json", "budget.md", "budget.html", "budget.png"),
    "find": ("study.yaml", "find.json", "find.html", "figures/find.png"),
    "cross-validate": ("cross_validation.json", "cross_validation.html", "figures/*.png"),
    "validate": ("validation.json", "report.html", "figures/*.png"),
}
"""Files that the folder of a study holds beside run folders, by the command that makes it (names and patterns), where
that is not as of `study_files`."""
COMPARED_FILES = ("compared.json", "compared.md", "compared.png")
"""Files that the folder of curves against measured ones holds."""
FORCES_HEADER = "time,structure,fx,fy,moment"
"""First line of ``forces.csv`` where all walls are at rest."""


def study_files(command: str) -> tuple[str, ...]:
    """Files in the folder of a study besides run folders: results, page and pictures (names and patterns)."""
    return STUDY_FILES.get(command) or (f"{command}.json", f"{command}.md", f"{command}*.png")


def forces_header(*, power: bool) -> str:
    """First line of ``forces.csv``: with the column of power where walls move."""
    return f"{FORCES_HEADER},power" if power else FORCES_HEADER


MOST_JSON = 100_000_000
"""Bytes of a JSON file that is read."""
MOST_ARRAYS = 200
"""Arrays of a file of `write_arrays`."""
LONGEST_ENTRY, LONGEST_END = 300, 66_000
"""Bytes of an array in the table of contents of a zip file, and of the end of that file; both are less."""
ZIP_END, ZIP_END_64, NOT_HERE = b"PK\5\6", b"PK\6\6", (1 << 32) - 1
"""Marks of the ends of a zip file, and what the first says where the second tells (APPNOTE.TXT 4.3.14, 4.3.16)."""
ENCRYPTED = 1
"""Flag of an encrypted entry of a zip file."""
MOST_TEXT = 2_000_000_000
"""Bytes of a table or log that is read."""
END_OF_LINE = re.compile("\r\n|\r|\n")
"""Ends of lines of a text; a page of a browser turns each into the last."""
NO_ROOM_BESIDE = {errno.EACCES, errno.EPERM, errno.EROFS, errno.EBUSY, errno.ENAMETOOLONG, errno.ENOTSUP, errno.EXDEV}
"""Errors of making a file next to another, or of putting it in its place, though that one may be written."""
WRITER_PATIENCE = 0.5
"""Seconds that a program which has a file open for writing gets to close it."""


def make_own(path: Path) -> None:
    """Give a file that is to be changed in place a body of its own, so that a hard-linked backup stays as it is."""
    if path.is_symlink() or path.stat().st_nlink > 1:
        new = path.with_name(f".{path.name}.new")
        new.unlink(missing_ok=True)
        shutil.copy2(path, new)
        flush(new)
        os.replace(new, path)


@contextmanager
def writes(place: object, kind: type[JumpError] = DumpError, remedy: str = "name another place") -> Iterator[None]:
    """An OSError while the block runs becomes an error of this `kind`, which names the place and the remedy."""
    try:
        yield
    except OSError as error:
        raise kind(f"{place}: cannot be written ({error.strerror or error}); {remedy}") from None


def checksum(path: Path) -> dict[str, int | str]:
    """Size of a file in bytes, and its SHA-256."""
    with open_to_read(path) as file:
        return {"size": os.fstat(file.fileno()).st_size, "sha256": hashlib.file_digest(file, "sha256").hexdigest()}


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
    """`write_bytes` of a text."""
    return write_bytes(path, text.encode("utf-8", "replace"))


def write_bytes(path: Path, data: bytes | memoryview, mode: int | None = None) -> Path:
    """Write a file whole or not at all, with these permissions whatever the umask; see `whole`."""
    with whole(path) as new, _new(new, 0o666) as file:
        file.write(data)
        if mode is not None:
            os.fchmod(file.fileno(), mode)
    return path


def open_to_write(path: str | Path, *, append: bool = False) -> io.BufferedWriter:
    """A file that grows in its place, such as the output of an engine; OSError where a link or no regular file is."""
    return open(path, "ab" if append else "wb", opener=_open_no_link)


def _open_no_link(path: str, flags: int) -> int:
    return open_regular(path, flags | os.O_NOFOLLOW)


def open_to_read(path: str | Path) -> io.BufferedReader:
    """A regular file; OSError for another kind, a pipe or device, which may never end."""
    return open(path, "rb", opener=open_regular)


def delete(*paths: Path) -> None:
    """Delete files that are there; of a link the link alone, and no folder."""
    for path in paths:
        path.unlink(missing_ok=True)


def move(path: Path, target: Path) -> None:
    """Put a file in the place of another, in one move."""
    os.replace(path, target)


def name_again(path: Path, name: Path) -> None:
    """Give a file a second name, which takes the place of another file in one move."""
    new = name.with_name(f".{name.name}.new")
    delete(new)
    os.link(path, new)
    os.replace(new, name)


def write_arrays(path: Path, **arrays: Any) -> None:
    """Write arrays as NPZ into a new file; a hard-linked backup of the old one stays as it is."""
    delete(path)
    with open_to_write(path) as file:
        np.savez(file, **arrays)


def read_arrays(path: Path) -> dict[str, np.ndarray]:
    """The arrays of `write_arrays`, which may not be written to.

    Raises
    ------
    OSError, ValueError
        No such file, no regular file, or one that does not hold such arrays: it is damaged, or made up.
    """
    from zipfile import ZipFile  # 10 ms, which --help need not wait for

    with open_to_read(path) as file, foreign(ValueError):
        size = os.fstat(file.fileno()).st_size
        _require_few(file, size)
        with ZipFile(file) as packed:
            entries = packed.infolist()
            if any(entry.compress_type or entry.flag_bits & ENCRYPTED for entry in entries):
                raise ValueError("its arrays are compressed or encrypted")  # and may be of any size
            if sum(entry.file_size for entry in entries) > size:
                raise ValueError("its arrays are larger than the file")
            if len({entry.filename for entry in entries}) < len(entries):
                raise ValueError("an array stands there twice")
            return {entry.filename.removesuffix(".npy"): _array(packed.read(entry)) for entry in entries}


def _require_few(file: io.BufferedReader, size: int) -> None:
    """ValueError where the table of contents at the end of a zip file is longer than `MOST_ARRAYS` need."""
    file.seek(max(0, size - LONGEST_END))
    end = file.read()
    at = end.rfind(ZIP_END)
    listed = int.from_bytes(end[at + 12 : at + 16], "little") if at >= 0 else 0
    if (far := end.rfind(ZIP_END_64)) >= 0:  # of files above 4 GB
        listed = max(listed if listed < NOT_HERE else 0, int.from_bytes(end[far + 40 : far + 48], "little"))
    if listed > MOST_ARRAYS * LONGEST_ENTRY:
        raise ValueError(f"its table of contents has {listed} bytes; at most {MOST_ARRAYS} arrays are read")


def _array(data: bytes) -> np.ndarray:
    """An array of an npy file, whose head tells kind and shape; ValueError where its numbers are not as many."""
    stream = io.BytesIO(data)
    heads = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}
    shape, turned, kind = heads[np.lib.format.read_magic(stream)](stream)
    count, left = prod(shape), len(data) - stream.tell()
    if kind.hasobject or not kind.itemsize or min(shape, default=0) < 0 or count * kind.itemsize != left:
        raise ValueError(
            f"an array of shape {shape} and {kind.itemsize} bytes a value is not what its {left} bytes hold"
        )
    return np.frombuffer(data, kind, count, stream.tell()).reshape(shape, order="F" if turned else "C")


def cut_to(path: Path, size: int) -> None:
    """Cut a file to so many bytes."""
    with open_to_write(path, append=True) as file:
        file.truncate(size)


@contextmanager
def whole(path: Path) -> Iterator[Path]:
    """A place in the folder of a file, which takes the file's place in one move where the block ends well.

    A link that is at the place of the file is replaced, and nothing is written through it.
    """
    new, staged = path.with_name(f".{path.name}.new"), STAGING in path.parts  # brought to the disk when published
    new.unlink(missing_ok=True)  # of a process that was killed
    try:
        yield new
        if not staged:
            flush(new)
        os.replace(new, path)
    except BaseException:
        new.unlink(missing_ok=True)
        raise
    if not staged:
        flush(path.parent)


def flush(path: Path) -> None:
    """Bring a file or folder from memory to the disk."""
    place = os.open(path, os.O_RDONLY)
    try:
        os.fsync(place)
    finally:
        os.close(place)


def write_json(path: Path, data: object, indent: int | None = 1) -> Path:
    """Write plain data as JSON, NaN and infinities as null; see `plain` and `write_text`."""
    return write_text(path, json.dumps(plain(data), indent=indent, allow_nan=False) + "\n")


def read_json(path: Path) -> Any:
    """The data of a JSON file.

    Raises
    ------
    OSError, ValueError
        No such file, no regular file, or no JSON.
    """
    data = read_file(path, MOST_JSON)
    with foreign(ValueError):
        return json.loads(data)


def read_file(path: Path, most: int) -> bytes:
    """The bytes of a regular file; OSError for another kind (a pipe or device may never end) or more than `most`."""
    data = read_start(path, most + 1)
    if len(data) > most:
        raise OSError(errno.EFBIG, f"more than {most // 1_000_000} MB")
    return data


def read_start(path: Path, most: int) -> bytes:
    """At most so many bytes from the start of a regular file; OSError for another kind."""
    with open_to_read(path) as file:
        return file.read(min(most, os.fstat(file.fileno()).st_size))  # read() makes room for all of it


def text_of(path: Path, errors: str = "strict") -> str:
    """The text of a regular file in UTF-8; DumpError where it cannot be read."""
    try:
        return read_file(path, MOST_TEXT).decode(errors=errors)
    except (OSError, UnicodeDecodeError) as error:
        raise DumpError(f"{path}: cannot be read ({getattr(error, 'strerror', None) or error})") from None


def open_regular(path: str, flags: int) -> int:
    """An `opener` for `open` that refuses all but regular files, and never waits for a pipe."""
    place = os.open(path, flags | os.O_NONBLOCK, 0o666)  # a pipe without a writer would be waited for
    if not stat.S_ISREG(os.fstat(place).st_mode):
        os.close(place)
        kind = errno.EISDIR if os.path.isdir(path) else errno.EINVAL
        raise OSError(kind, os.strerror(kind) if kind == errno.EISDIR else "no regular file")
    return place


def private_file(name: str, text: str) -> Path:
    """A new file that this user alone can read, whose name begins and ends as this one.

    It lies in the current folder where that is this user's own, for a browser in a container sees no other place;
    else in the folder of temporary files.

    Raises
    ------
    OSError
        It can be made in neither.
    """
    here, wanted = os.stat("."), Path(name)
    own = here.st_uid == os.geteuid() and not here.st_mode & 0o022 and os.access(".", os.W_OK)
    folder = Path.cwd() if own else Path(tempfile.gettempdir())
    path = folder / f"{wanted.stem}-{secrets.token_hex(4)}{wanted.suffix}"
    _make(path, text.encode())
    return path


def real_path(path: Path) -> Path:
    """The file that a path leads to, through all links; of links in a circle the path itself."""
    return Path(os.path.realpath(path))


def with_ends_of(before: str, after: str) -> str:
    """A text with the ends (LF, CRLF, CR) that its lines have in the text before; a new line has its neighbour's."""
    ends = END_OF_LINE.findall(before)
    lines = END_OF_LINE.split(after)
    if len(set(ends)) < 2:
        return (ends[0] if ends else "\n").join(lines)
    old, line_ends = END_OF_LINE.split(before), [""] * len(lines)
    for first, here, many in SequenceMatcher(None, old, lines).get_matching_blocks():
        line_ends[here : here + many] = [*ends, ""][first : first + many]
    end = next(filter(None, line_ends), ends[0])
    text = []
    for line, own in zip(lines, line_ends, strict=True):
        end = own or end
        text += [line, end]
    return "".join(text[:-1])


def change_text(path: Path, before: str, after: str) -> str | None:
    """Put another text into a file of the user, unless it holds another one than `before` by now.

    Mode, owner, hard links and further attributes of the file stay, and so do the ends of its lines
    (`with_ends_of`). The file is whole before and after: a new one takes its place in one move. Where that would lose
    hard links or the owner, or another program holds the file open, it is written in its place, with a copy next to it
    until that is done. What another program writes meanwhile is kept. A link that is there is not followed.

    Returns
    -------
    str or None
        The text as it was written; None where nothing was.

    Raises
    ------
    OSError
        It is read-only, or cannot be written; it then holds the text before.
    """
    old, new = before.encode(), with_ends_of(before, after).encode()
    with open(path, "rb", opener=_open_no_link) as file:
        if not _holds(path, file, old):
            return None
        if new == old:
            return before
        status = os.fstat(file.fileno())
        if not status.st_mode & 0o222 or not os.access(path, os.W_OK):
            raise PermissionError(errno.EACCES, "it is read-only", str(path))
        alone = status.st_nlink == 1 and lent(file.fileno())
        done = _put_in_its_place(path, file, old, new) if alone else None
    if done is None:
        done = _written_over(path, old, new)
    return new.decode() if done else None


def _holds(path: Path, file: IO[bytes], data: bytes) -> bool:
    """Tells whether a path still leads to the file that is open, and the file holds these bytes."""
    try:
        same = os.path.samestat(os.stat(path, follow_symlinks=False), os.fstat(file.fileno()))
    except FileNotFoundError:
        return False
    return same and os.pread(file.fileno(), len(data) + 1, 0) == data


def _put_in_its_place(path: Path, file: IO[bytes], old: bytes, new: bytes) -> bool | None:
    """Put a new file in the place of one that is open; whether that held `old` to the end. None: no new file can be."""
    temporary = path.with_name(f".{path.name}.{secrets.token_hex(4)}.new")
    try:
        try:
            _make(temporary, new, like=file)
            if not _holds(path, file, old):
                return False
            exchanged = _exchange(temporary, path)
        except OSError as error:
            if error.errno in NO_ROOM_BESIDE:
                return None
            raise
        if exchanged and not _came_out(temporary, file, old):
            _exchange(temporary, path)
            _keep_meanwhile(path, temporary, new)
            return False
    finally:
        _delete_own(temporary, old, new)
    with suppress(OSError):
        flush(path.parent)
    return True


def _make(path: Path, data: bytes, like: IO[bytes] | None = None) -> None:
    """A new file, brought to the disk; with owner, mode and further attributes of one that is open."""
    with _new(path) as made:
        try:
            made.write(data)
            made.flush()
            if like is not None:
                _give_attributes(made.fileno(), like.fileno())
            os.fsync(made.fileno())
        except BaseException:
            delete(path)
            raise


def _give_attributes(place: int, like: int) -> None:
    """Give an open file owner, mode and further attributes of another."""
    status, here = os.fstat(like), os.fstat(place)
    if (here.st_uid, here.st_gid) != (status.st_uid, status.st_gid):
        os.fchown(place, status.st_uid, status.st_gid)
    give_further_attributes(place, like)
    os.fchmod(place, stat.S_IMODE(status.st_mode))


def _new(path: Path, mode: int = 0o600) -> io.BufferedWriter:
    """A file that was not there, open for writing."""
    return open(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW, mode), "wb")


def _exchange(first: Path, second: Path) -> bool:
    """Exchange two files in one move; False where the system cannot: the first has taken the place of the second."""
    if exchanged(first, second):
        return True
    os.replace(first, second)
    return False


def _came_out(temporary: Path, file: IO[bytes], old: bytes) -> bool:
    """Tells whether what an exchange has brought out is the open file, and no program has written to it."""
    return _left(file) and _holds(temporary, file, old)


def _left(file: IO[bytes]) -> bool:
    """Wait until no other program has a file open for writing; whether they have closed it in time."""
    until = time.monotonic() + WRITER_PATIENCE
    while not (left := lent(file.fileno())) and time.monotonic() < until:
        time.sleep(0.002)
    return left


def _keep_meanwhile(path: Path, temporary: Path, new: bytes) -> None:
    """Keep what a program has written to the new file while that was in the place of the other.

    Raises
    ------
    OSError
        It was more than lines at its end; they are kept in a file, which the message names.
    """
    with open_to_read(temporary) as file:
        alone, data = _left(file), file.read()
    if not alone or not data.startswith(new):
        said = f"other programs write it at once; the text of one of them is in {temporary}"
        raise OSError(errno.EBUSY, said, str(path))
    if more := data.removeprefix(new):
        with open_to_write(path, append=True) as end:
            end.write(more)
    delete(temporary)


def _delete_own(path: Path, *texts: bytes) -> None:
    """Delete a file that holds one of these texts."""
    with suppress(OSError):
        if read_file(path, MOST_TEXT) in texts:
            delete(path)


def _written_over(path: Path, old: bytes, new: bytes) -> bool:
    """Writes a file in its place, with a copy next to it meanwhile; False, and nothing is done, if it is another."""
    copy = path.with_name(f".{path.name}.{secrets.token_hex(4)}.old")
    with open(path, "r+b", opener=_open_no_link) as file:
        place = file.fileno()
        if not _holds(path, file, old):
            return False
        try:
            _make(copy, old)
            copied = True
        except OSError as error:
            copied = False
            if error.errno not in NO_ROOM_BESIDE:
                raise
        lent(place, whole=True)
        if same := _holds(path, file, old):
            try:
                _overwrite(place, new)
            except BaseException:
                _overwrite(place, old)  # if this fails too, the copy stays
                if copied:
                    delete(copy)
                raise
        taken_back(place)
        os.fsync(place)
        if copied:
            delete(copy)
    return same


def _overwrite(place: int, data: bytes) -> None:
    """Write an open file from its start, and cut it there."""
    done = 0
    while done < len(data):
        done += os.pwrite(place, data[done:], done)
    os.ftruncate(place, done)
