# SPDX-License-Identifier: GPL-2.0-or-later
"""The core for browsers: WebAssembly with vectors, compiled by `make wasm`, and part of wheels like the sources.

    python -m lammps_jump.core.browser

It exports what stepping needs. A record next to it names the sources, the compiler and the hash of the code.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

from lammps_jump.compiling.cache import checksum
from lammps_jump.compiling.product import FLAGS
from lammps_jump.errors import SetupError
from lammps_jump.files import read_file, read_json, write_bytes, write_json
from lammps_jump.provenance import package_version

from .library import CORE

ZIG = "0.17.1"
"""Version of ziglang that compiles it: other compilers give the same numbers, but another file."""
HERE = Path(__file__).parent / "browser"
CODE, RECORD = HERE / "core.wasm", HERE / "core.json"
EXPORTS = ("jump_run", "jump_partition", "jump_forget_windows", "aligned_alloc", "free")
UNUSED = ("-fPIC", "-pthread")
"""Flags that the target does not know: it has one thread."""
TARGET = ("-target", "wasm32-wasi", "-msimd128", "-fno-exceptions", "-w")
LINK = ("-mexec-model=reactor", "-Wl,-s", *(f"-Wl,--export={name}" for name in EXPORTS))
MOST_CODE = 50_000_000
"""Bytes of the code; it has less than one million."""
REMEDY = "run `make wasm` in the sources of lammps-jump, or install a wheel that carries it"


class BrowserCore(NamedTuple):
    """Code, its SHA-256 and what compiled it."""

    code: bytes
    sha256: str
    compiler: str


def browser_core() -> BrowserCore:
    """The core for browsers.

    Raises
    ------
    SetupError
        It is not there, damaged, or of other sources than those that are here.
    """
    try:
        record, code = read_json(RECORD), read_file(CODE, MOST_CODE)
        core = BrowserCore(code, record["sha256"], record["compiler"])
        same = record["sources"] == CORE.sources()
    except FileNotFoundError:
        raise SetupError(f"the core for browsers is not there: {REMEDY}") from None
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise SetupError(f"the core for browsers cannot be read ({error}): {REMEDY}") from None
    if checksum(code) != core.sha256:
        raise SetupError(f"the core for browsers, {CODE}, is damaged: {REMEDY}")
    if not same:
        raise SetupError(f"the core for browsers, {CODE}, is of other sources: {REMEDY}")
    return core


def build() -> BrowserCore:
    """Compiles the core for browsers and writes it next to its sources.

    Raises
    ------
    SetupError
        The compiler is not there or of another version, or refuses the sources.
    """
    if (there := package_version("ziglang")) != ZIG:
        raise SetupError(f"ziglang {ZIG} compiles the core for browsers; here is {there or 'none'}: install '.[wasm]'")
    compiler = (sys.executable, "-m", "ziglang", "c++", *TARGET, *(flag for flag in FLAGS if flag not in UNUSED))
    units = sorted(CORE.folder.rglob("*.cpp"))
    with tempfile.TemporaryDirectory() as place, ThreadPoolExecutor(os.cpu_count()) as pool:
        objects = [str(Path(place) / f"{number}.o") for number in range(len(units))]
        commands = [
            (*compiler, "-iquote", str(CORE.folder), "-c", str(unit), "-o", made)
            for unit, made in zip(units, objects, strict=True)
        ]
        list(pool.map(_run, commands))
        linked = Path(place) / CODE.name
        _run((*compiler, *LINK, *objects, "-o", str(linked)))
        code = read_file(linked, MOST_CODE)
    HERE.mkdir(exist_ok=True)
    return write(code)


def write(code: bytes) -> BrowserCore:
    """Write the core, and the record of what it is."""
    core = BrowserCore(code, checksum(code), f"ziglang {ZIG}")
    write_bytes(CODE, code)
    write_json(RECORD, {"sources": CORE.sources(), "sha256": core.sha256, "compiler": core.compiler})
    return core


def _run(command: tuple[str, ...]) -> None:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise SetupError(f"the core for browsers does not compile: {done.stderr.strip()[-2000:]}")


if __name__ == "__main__":
    made = build()
    print(f"{CODE}\n{len(made.code)} bytes, SHA-256 {made.sha256}")
