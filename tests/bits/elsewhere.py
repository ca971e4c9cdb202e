# SPDX-License-Identifier: GPL-2.0-or-later
"""The bits of the native engine on other systems: the core steps the same scenes there, in a host without Python.

    python tests/bits/elsewhere.py                      # all builds that this machine can run
    python tests/bits/elsewhere.py --builds wasm --only drum

Each scene is set up here and written as an image of memory (``engines/native/image.py``). `host.cpp` steps it. It is
compiled by ``ziglang`` for WebAssembly (in node) and for arm64 (by qemu-user), and by this machine's compiler for SSE2
alone. The native engine steps it too. Steps, ids, places, velocities, spins, forces and sums on walls are compared byte
by byte. The exit status is 1 where one differs. pytest does not collect this file; `make bits` runs it.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

from lammps_jump.compiling.product import FLAGS
from lammps_jump.engines.native import NativeSimulation
from lammps_jump.engines.native.image import image_of
from lammps_jump.errors import CaseError

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import same_bits

HERE = Path(__file__).resolve().parent
CORE = HERE.parents[1] / "lammps_jump" / "core"
SETUP, STEPS = 500, 1000
"""Steps of the engine before the image, and of the host after it."""
COLUMNS = ("x", "y", "vx", "vy", "fx", "fy", "omega")
ZIG = (sys.executable, "-m", "ziglang", "c++", "-w")
NODE = ("node", "--no-warnings", str(HERE / "host.mjs"))
WASM = (*ZIG, "-target", "wasm32-wasi", "-fno-exceptions")
BUILDS: dict[str, tuple[tuple[str, ...], tuple[str, ...], int]] = {
    "sse2": (("g++", "-w", "-march=x86-64"), (), 8),
    "wasm": ((*WASM, "-msimd128"), NODE, 4),
    "wasm_scalar": (WASM, NODE, 4),
    "arm64": ((*ZIG, "-target", "aarch64-linux-musl"), ("qemu-aarch64",), 8),
}
"""Compiler, what runs its product, and bytes of a pointer."""
NOT_OF_WASM = ("-fPIC", "-pthread")


def is_there(name: str) -> bool:
    """Whether this machine has what a build needs."""
    compiler, runner, _ = BUILDS[name]
    found = subprocess.run([*compiler, "--version"], capture_output=True).returncode == 0
    return found and (not runner or shutil.which(runner[0]) is not None)


def build(name: str, folder: Path) -> Path:
    """Compile core and host, unit by unit on all cores; the program."""
    compiler, program = BUILDS[name][0], folder / f"host_{name}"
    flags = [flag for flag in FLAGS if not (name.startswith("wasm") and flag in NOT_OF_WASM)]
    units = [*sorted(CORE.rglob("*.cpp")), HERE / "host.cpp"]
    objects = [folder / f"{name}_{number}.o" for number in range(len(units))]

    def compiled(pair: tuple[Path, Path]) -> None:
        command = [*compiler, *flags, "-iquote", str(CORE), "-c", str(pair[0]), "-o", str(pair[1])]
        subprocess.run(command, check=True)

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        list(pool.map(compiled, zip(units, objects, strict=True)))
    subprocess.run([*compiler, *flags, *map(str, objects), "-o", str(program)], check=True)
    return program


def state_of(simulation: NativeSimulation) -> bytes:
    """What the host writes, of the native engine."""
    d = simulation.discs
    columns = [getattr(d, name) for name in COLUMNS]
    parts = [np.array([simulation.step, d.n]), d.ids[: d.n], *(one[: d.n] for one in columns if one is not None)]
    return b"".join(part.tobytes() for part in (*parts, simulation.walls.sums))


def scenes(only: str) -> Iterator[tuple[str, NativeSimulation]]:
    """The entries of `same_bits` that have no pour, set up."""
    for name, source, changes in same_bits.entries():
        if only not in name:
            continue
        try:
            scene = same_bits.scene_of(source, changes)
        except CaseError as error:
            print(f"{name}: left out, {error}"[:200], flush=True)
            continue
        if scene.pours:
            print(f"{name}: left out, its pour is drawn by the engine", flush=True)
            continue
        simulation = NativeSimulation(scene)
        simulation.run(SETUP)
        yield name, simulation


def main() -> int:
    """Build, run and compare."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--builds", nargs="*", default=list(BUILDS), choices=list(BUILDS))
    parser.add_argument("--only", default="", help="a part of the names of entries")
    asked = parser.parse_args()
    there = [name for name in asked.builds if is_there(name)]
    for name in set(asked.builds) - set(there):
        print(f"{name}: left out, this machine lacks its compiler or what runs it", flush=True)
    wrong, count = dict.fromkeys(there, 0), 0
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        programs = {name: build(name, folder) for name in there}
        for entry, simulation in scenes(asked.only):
            target, out, said = simulation.step + STEPS, folder / "out", []
            images = {word: folder / f"image{word}" for word in {BUILDS[name][2] for name in there}}
            for word, path in images.items():
                path.write_bytes(image_of(simulation, target, word))
            simulation.run(STEPS)
            right = state_of(simulation)
            for name in there:
                _, runner, word = BUILDS[name]
                out.write_bytes(b"")
                command = [*runner, str(programs[name]), str(images[word]), str(target), str(out)]
                status = subprocess.run(command, check=False).returncode
                same = status == 0 and out.read_bytes() == right
                wrong[name] += not same
                said.append(f"{name} {'same' if same else f'differs (status {status})'}")
            count += 1
            print(f"{entry}: {', '.join(said)}", flush=True)
    print("; ".join(f"{name}: {wrong[name]} of {count} differ" for name in there))
    return 1 if any(wrong.values()) or not count else 0


if __name__ == "__main__":
    sys.exit(main())
