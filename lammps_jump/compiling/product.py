# SPDX-License-Identifier: GPL-2.0-or-later
"""Products of compiling: the libraries of this project, their sources, and for which system compiled code is.

A library is described once, as a `Product`. Every file ``*.cpp`` of its folder and of the folders in there belongs to
it: a new file needs no entry in a list.
"""

from __future__ import annotations

import hashlib
import re
from dataclasses import dataclass
from pathlib import Path

from lammps_jump.errors import SetupError
from lammps_jump.files import MOST_TEXT, read_file
from lammps_jump.provenance import package_version, wheel_file

ELF, MACH, DOS, PE = b"\x7fELF", b"\xcf\xfa\xed\xfe", b"MZ", b"PE\0\0"
"""First bytes of code of Linux, macOS (of 64 bits) and Windows; of Windows' second head."""
MACHINES = {
    ("Linux", 62): "x86_64",
    ("Linux", 183): "aarch64",
    ("Darwin", 0x0100_0007): "x86_64",
    ("Darwin", 0x0100_000C): "arm64",
    ("Windows", 0x8664): "AMD64",
    ("Windows", 0xAA64): "ARM64",
}
"""Words of `platform.machine()` by those of `platform.system()` and the number in the head (ELF e_machine, Mach-O
cputype, PE Machine)."""


def is_code(data: bytes) -> bool:
    """Tells whether a file begins as an object or library does."""
    return data.startswith((ELF, MACH, DOS))


def made_for(code: bytes) -> tuple[str, str] | None:
    """System and machine that an object or library is for, in the words of `platform`; None for other files.

    The object files of Windows have no mark of their own, so that its libraries alone are known.
    """
    if code.startswith(ELF):
        system, number = "Linux", code[18:20]
    elif code.startswith(MACH):
        system, number = "Darwin", code[4:8]
    elif code.startswith(DOS):
        place = int.from_bytes(code[0x3C:0x40], "little")
        system, number = "Windows", code[place + 4 : place + 6] if code[place : place + 4] == PE else b""
    else:
        return None
    machine = MACHINES.get((system, int.from_bytes(number, "little")))
    return (system, machine) if machine else None


# --- products of compiling: the libraries of this project, their sources, and what their sources include --------------


FLAGS = (
    "-std=c++17",
    "-O3",
    "-ffp-contract=off",
    "-fno-math-errno",
    "-fno-trapping-math",
    "-fvisibility=hidden",
    "-fPIC",
    "-pthread",
)
"""No -ffast-math and no contraction: sums keep their order, so that results are the same with every compiler."""

_INCLUDE = re.compile(rb'^[ \t]*#[ \t]*include[ \t]*"([^"]+)"', re.MULTILINE)


@dataclass(frozen=True, slots=True)
class Wheel:
    """A package whose headers a build includes.

    Attributes
    ----------
    package : str
    header : str
        One of its headers, by the end of its path; the others are in the same folder.
    library : str
        What must be loaded before a library that was built with it.
    missing : str
        How a message calls the headers, with its verb.
    """

    package: str
    header: str
    library: str
    missing: str

    @property
    def headers(self) -> Path | None:
        """Folder of the headers, or None."""
        path = wheel_file(self.package, self.header)
        return path.parent if path is not None and path.is_file() else None


@dataclass(frozen=True, slots=True)
class Product:
    """A library that is compiled of sources of the package.

    Attributes
    ----------
    name : str
        The file is ``<name>.so``, on macOS too, as modules of Python are.
    title : str
        How a message calls it.
    folder : Path
        Of its sources.
    export : str
        A name that every whole library of it holds.
    groups : tuple of tuple of str
        Patterns of files that are compiled as one, because they include the same headers. A file that no group has is
        compiled by itself.
    also : tuple of Path
        Further folders of headers of this project.
    wheels : tuple of Wheel
    advice : str
        How to get the wheels.
    levels : tuple of str
        Levels of processors for which a wheel of this project carries it, best first.
    carried_flags : tuple of str
        For the link of a library that is carried to other systems, where this machine's compiler makes it.
    forbidden : str
        Characters that the path of the library must not have.
    """

    name: str
    title: str
    folder: Path
    export: str
    groups: tuple[tuple[str, ...], ...] = ()
    also: tuple[Path, ...] = ()
    wheels: tuple[Wheel, ...] = ()
    advice: str = ""
    levels: tuple[str, ...] = ()
    carried_flags: tuple[str, ...] = ()
    forbidden: str = ""

    @property
    def library(self) -> str:
        """Name of the file."""
        return f"{self.name}.so"

    def is_made(self, code: bytes) -> bool:
        """Tells whether bytes look like a library of this product."""
        return is_code(code) and self.export.encode() in code

    def units(self) -> list[tuple[str, ...]]:
        """Paths in `folder` of the files of each unit of compiling; each file is in one.

        Raises
        ------
        SetupError
            There are no sources.
        """
        left = {path.relative_to(self.folder).as_posix(): path for path in sorted(self.folder.rglob("*.cpp"))}
        if not left:
            raise SetupError(f"the sources of {self.title} are not in {self.folder}; reinstall lammps-jump")
        units = []
        for patterns in self.groups:
            names = [name for pattern in patterns for name in left if left[name].match(pattern)]
            names = list(dict.fromkeys(names))
            units.append(tuple(names))
            left = {name: path for name, path in left.items() if name not in names}
        return [unit for unit in (*units, *((name,) for name in left)) if unit]

    def included(self, unit: tuple[str, ...]) -> dict[str, bytes]:
        """All files of this project that a unit is made of, by name and folder: its own, and what they include."""
        contents: dict[Path, bytes] = {}
        waiting = [self.folder / name for name in unit]
        while waiting:
            path = waiting.pop()
            if path in contents:
                continue
            contents[path] = read_file(path, MOST_TEXT)
            for name in _INCLUDE.findall(contents[path]):
                places = (folder / name.decode() for folder in (path.parent, self.folder, *self.also))
                waiting += [place for place in places if place.is_file()][:1]  # others are the wheels'
        return {f"{path.parent.name}/{path.name}": contents[path] for path in sorted(contents)}

    def versions(self) -> dict[str, str]:
        """Versions of the wheels that a build includes."""
        return {wheel.package: package_version(wheel.package) or "none" for wheel in self.wheels}

    def sources(self) -> str:
        """Hash of all that the library is made of."""
        digest = hashlib.sha256()
        for unit in self.units():
            for name, text in self.included(unit).items():
                add(digest, name.encode(), text)
        return digest.hexdigest()


def add(digest: hashlib._Hash, *parts: bytes) -> None:
    """Add parts to a hash so that their ends count."""
    for part in parts:
        digest.update(str(len(part)).encode() + b"\0" + part)
