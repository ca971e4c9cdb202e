# SPDX-License-Identifier: GPL-2.0-or-later
"""The hosts of the step behind one face: the native engine, its twin, the compiled styles and stock LAMMPS.

A host has ``run(steps)``, ``ids`` (n,), ``positions``, ``velocities`` (n, 2), ``spin``, ``radii`` (n,) by id, and
``wall(name)``.
"""

from __future__ import annotations

from contextlib import chdir
from pathlib import Path

import numpy as np
from made_up import plugin_or_skip

from lammps_jump.engines.lammps.drive import plugin_arguments
from lammps_jump.engines.lammps.loader import load_lammps
from lammps_jump.engines.launch import write_script
from lammps_jump.engines.native import NativeSimulation
from lammps_jump.engines.native.bound import Core
from lammps_jump.engines.twin import Twin
from lammps_jump.scene.scene import Scene

RUN = "# --- run"
"""Line of a script behind which it steps."""


class LammpsHost:
    """The generated script up to its run, then stepped from here; or to its end."""

    def __init__(self, scene: Scene, spins: list[float], folder: Path, *, compiled: bool, whole: bool = False):
        self.scene, self.folder = scene, folder.absolute()
        plugin = plugin_or_skip() if compiled else None
        script = write_script(scene, folder, kernel="compiled" if compiled else "stock").read_text()
        self.lmp = load_lammps().lammps(
            cmdargs=["-log", "none", "-screen", "none", "-nocite", *plugin_arguments(plugin)]
        )
        if whole:
            self.do(script.replace("sort 1000", "sort 70"))  # so that the memory of contacts goes with its disc
            return
        self.do(script.partition(RUN)[0])
        self.do(*(f"set atom {i} omega 0 0 {spin!r}" for i, spin in enumerate(spins, 1) if spin), "run 0")

    def do(self, *lines: str) -> None:
        """Give commands in the folder of the script, which names its files without one."""
        with chdir(self.folder):
            self.lmp.commands_string("\n".join(lines))

    def run(self, steps: int) -> None:
        self.do(f"run {steps} pre no post no")

    def by_id(self, name: str) -> np.ndarray:
        """An array of the discs in the order of their ids."""
        n = self.lmp.get_natoms()
        order = np.argsort(self.lmp.numpy.extract_atom("id")[:n])
        return self.lmp.numpy.extract_atom(name)[:n][order].copy()

    ids = property(lambda self: self.by_id("id"))
    positions = property(lambda self: self.by_id("x")[:, :2])
    velocities = property(lambda self: self.by_id("v")[:, :2])
    spin = property(lambda self: self.by_id("omega")[:, 2])
    radii = property(lambda self: self.by_id("radius"))

    def wall(self, name: str) -> list[float]:
        """Means over the last whole window: force on a wall, moment, and power where walls move."""
        columns, index = 3 + self.scene.moves, self.scene.probes.index(name)
        return [self.lmp.extract_fix("motion", 0, 1, columns * index + column) for column in range(columns)]

    def close(self) -> None:
        self.lmp.close()


class NativeHost:
    """The native engine, or its twin; spins are put in by hand, because no scene starts with any."""

    def __init__(self, scene: Scene, spins: list[float], loops: Core | Twin | None = None):
        class Spun(NativeSimulation):
            def _start(self) -> None:
                discs = self.discs
                if any(spins):
                    given = np.array(spins)[discs.ids[: discs.n] - 1]
                    for array in (discs.omega, discs.uomega):
                        if array is not None:
                            array[: discs.n] = given
                super()._start()

        self.simulation = Spun(scene, loops=loops or Core())
        self.run = self.simulation.run

    ids = property(lambda self: np.sort(self.simulation.ids))
    positions = property(lambda self: self.simulation.positions)
    velocities = property(lambda self: self.simulation.velocities)
    spin = property(lambda self: self.simulation.spin)
    radii = property(lambda self: self.simulation.radii)

    def wall(self, name: str) -> list[float]:
        """Means over the last whole window: force on a wall, moment, and power where walls move."""
        return next(list(row[2:]) for row in reversed(self.simulation.forces) if row[1] == name)

    def close(self) -> None:
        pass


def start(host: str, scene: Scene, spins: list[float], folder: Path) -> NativeHost | LammpsHost:
    """A host that holds a scene: `native…`, `twin`, `compiled…`; any other is stock LAMMPS."""
    if host.startswith(("native", "twin")):
        return NativeHost(scene, spins, Twin() if host == "twin" else None)
    return LammpsHost(scene, spins, folder, compiled=host.startswith("compiled"))


def at_end(host: str, scene: Scene, folder: Path) -> NativeHost | LammpsHost:
    """A host that has done all steps of a scene, inlets that come later included."""
    if host in ("native", "twin"):
        found = start(host, scene, [], folder)
        found.run(scene.steps)
        return found
    return LammpsHost(scene, [], folder, compiled=host == "compiled", whole=True)
