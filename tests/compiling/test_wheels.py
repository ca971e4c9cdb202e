# SPDX-License-Identifier: GPL-2.0-or-later
"""Wheels for other systems: what each holds, and, for Linux on arm64, the bits of its library under qemu."""

import hashlib
import json
import shutil
import struct
import subprocess
import zipfile
from pathlib import Path

import pytest
from bits.elsewhere import state_of
from made_up import INPUTS

from lammps_jump.case import load_case
from lammps_jump.compiling.carried import LEVELS
from lammps_jump.compiling.compiler import PLATFORMS
from lammps_jump.compiling.product import made_for
from lammps_jump.core import CORE
from lammps_jump.engines.native import NativeSimulation
from lammps_jump.engines.native.image import image_of
from lammps_jump.engines.plugin import PLUGIN, PRODUCTS
from lammps_jump.engines.plugin.make import make_wheel

ROOT = Path(__file__).parents[2]
ELSEWHERE = [target for target in PLATFORMS if target.zig]
ARM_LIBRARIES = Path("/usr/aarch64-linux-gnu")
"""Where Debian's package libc6-arm64-cross puts the C library of arm64."""
CARRIED = "lammps_jump/core/carried/"


def test_each_target_has_a_level_of_each_library_that_fits_it():
    assert [target.tag for target in PLATFORMS] == [
        "linux_x86_64",
        "manylinux_2_28_aarch64",
        "macosx_11_0_arm64",
        "macosx_11_0_x86_64",
    ]
    for target in PLATFORMS:
        assert target.levels.keys() <= LEVELS.keys() and set(CORE.levels) & target.levels.keys()
        assert bool(set(PLUGIN.levels) & target.levels.keys()) == (not target.zig)
    assert {level for product in PRODUCTS for level in product.levels} == LEVELS.keys()


@pytest.fixture(scope="module", params=ELSEWHERE, ids=lambda target: target.tag)
def wheel(request, tmp_path_factory):
    """A target, and its wheel, which is made."""
    if subprocess.run([*request.param.compiler[:3], "version"], capture_output=True).returncode != 0:
        pytest.skip("the compiler of zig is not installed: pip install ziglang")
    folder = tmp_path_factory.mktemp("dist")
    return request.param, folder / make_wheel(request.param, folder)[0]


def commands_of_mach(code):
    """(command, its bytes) of a Mach-O file (mach-o/loader.h)."""
    place, found = 32, []
    for _ in range(struct.unpack_from("<I", code, 16)[0]):
        command, size = struct.unpack_from("<II", code, place)
        found.append((command, code[place : place + size]))
        place += size
    return found


@pytest.mark.long
def test_a_wheel_holds_the_core_of_its_system_alone(wheel):
    target, path = wheel
    with zipfile.ZipFile(path) as packed:
        names = packed.namelist()
        (level,) = set(target.levels) & set(CORE.levels)
        carried = [name for name in names if "/carried/" in name]
        assert sorted(carried) == [f"{CARRIED}{level}/build.json", f"{CARRIED}{level}/{CORE.library}"]
        code, record = packed.read(carried[1]), json.loads(packed.read(carried[0]))
        (tags,) = (packed.read(name).decode() for name in names if name.endswith(".dist-info/WHEEL"))
        (needed,) = (packed.read(name).decode() for name in names if name.endswith(".dist-info/METADATA"))
    assert path.name.endswith(f"-py3-none-{target.tag}.whl") and f"Tag: py3-none-{target.tag}\n" in tags
    assert "psutil" in needed
    assert {"lammps_jump/system.py", "lammps_jump/analysis/__init__.py", "lammps_jump/inputs/dam_break.yaml"} <= {
        *names
    }
    assert made_for(code) == (target.system, target.machine) == (record["system"], record["machine"])
    assert record["sha256"] == hashlib.sha256(code).hexdigest() and record["sources"] == CORE.sources()
    assert CORE.is_made(code)
    if target.system == "Darwin":
        commands = dict(commands_of_mach(code))
        built = struct.unpack_from("<4xIII", commands[0x32])  # LC_BUILD_VERSION: platform and oldest system
        assert built[1:] == (1, 11 << 16), "for macOS 11"
        assert target.machine != "arm64" or 0x1D in commands, "signed, which macOS asks of code for arm64"
        libraries = [text[24:].rstrip(b"\0") for command, text in commands_of_mach(code) if command == 0xC]
        assert libraries == [b"/usr/lib/libSystem.B.dylib"]
    else:
        assert b"GLIBC_2.29" not in code and b"libstdc++" not in code


@pytest.mark.long
def test_the_library_of_the_arm64_wheel_has_the_bits_of_native(wheel, tmp_path):
    target, path = wheel
    if (target.system, target.machine) != ("Linux", "aarch64"):
        pytest.skip("no program runs libraries of macOS here")
    if shutil.which("qemu-aarch64") is None or not ARM_LIBRARIES.is_dir():
        pytest.skip("needs Debian's packages qemu-user and libc6-arm64-cross")
    with zipfile.ZipFile(path) as packed:
        (name,) = (name for name in packed.namelist() if name.endswith(f"/{CORE.library}"))
        library = tmp_path / CORE.library
        library.write_bytes(packed.read(name))
    host = tmp_path / "host"
    command = [*target.compiler, "-w", "-std=c++17", "-O1", "-iquote", str(CORE.folder)]
    run_path = f"-Wl,-rpath,{tmp_path}"
    source = ROOT / "tests" / "bits" / "host.cpp"
    subprocess.run([*command, str(source), str(library), run_path, "-o", str(host)], check=True)
    simulation = NativeSimulation(load_case(INPUTS / "drum.yaml", {"engine.name": "native"}).scene())
    simulation.run(200)
    image, out, last = tmp_path / "image", tmp_path / "out", simulation.step + 500
    image.write_bytes(image_of(simulation, last))
    simulation.run(500)
    emulated = ["qemu-aarch64", "-L", str(ARM_LIBRARIES), str(host), str(image), str(last), str(out)]
    subprocess.run(emulated, check=True)
    assert out.read_bytes() == state_of(simulation)
