# SPDX-License-Identifier: GPL-2.0-or-later
"""For which system and processor compiled code is."""

import platform
import struct
import subprocess
from pathlib import Path

import pytest

from lammps_jump.compiling.compiler import find_compiler
from lammps_jump.compiling.product import MACHINES, is_code, made_for


def head(system, number):
    """The first bytes of a library, by the formats: ELF and Mach-O of 64 bits, and PE behind a head of DOS."""
    return {
        "Linux": lambda: b"\x7fELF\2\1\1" + bytes(9) + struct.pack("<HH", 3, number),
        "Darwin": lambda: struct.pack("<II", 0xFEEDFACF, number),
        "Windows": lambda: (
            b"MZ" + bytes(58) + struct.pack("<I", 128) + bytes(64) + b"PE\0\0" + struct.pack("<H", number)
        ),
    }[system]() + bytes(8)


@pytest.mark.parametrize("system, number", list(MACHINES))
def test_each_system_is_told_by_its_head(system, number):
    code = head(system, number)
    assert made_for(code) == (system, MACHINES[system, number]) and is_code(code)
    assert made_for(head(system, 7)) is None  # another processor


@pytest.mark.parametrize("data", [b"", b"MZ", b"#!/bin/sh", bytes(100), b"MZ" + bytes(100)])
def test_what_is_no_library(data):
    assert made_for(data) is None


@pytest.mark.skipif(platform.system() != "Linux" or find_compiler() is None, reason="needs a compiler")
def test_the_compiler_of_this_machine(tmp_path):
    source, made = tmp_path / "a.cpp", tmp_path / "a.o"
    source.write_text("int one() { return 1; }\n")
    subprocess.run([*find_compiler(), "-c", str(source), "-o", str(made)], check=True)
    assert made_for(Path(made).read_bytes()) == (platform.system(), platform.machine())
