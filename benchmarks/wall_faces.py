# SPDX-License-Identifier: GPL-2.0-or-later
"""What the faces of a wall cost: a step of 5,000 discs on a bed of 1,000 faces against that on one face.

Run as ``python benchmarks/wall_faces.py [--faces N] [--steps N] [--rounds N]``. The bed is flat, so that both runs
have the same contacts. The runs take turns; printed for each engine are the medians of processor time and the median
of the ratios of neighbours in time. The exit status is 1 where a ratio is above 1.10.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from time import process_time

import numpy as np

from lammps_jump.engines.lammps.drive import plugin_arguments
from lammps_jump.engines.lammps.loader import load_lammps
from lammps_jump.engines.launch import write_script
from lammps_jump.engines.native import NativeSimulation
from lammps_jump.engines.plugin import plugin_path
from lammps_jump.scene.chains import Chain
from lammps_jump.scene.scene import Scene, handmade_scene
from lammps_jump.scene.walls import Wall

MOST = 1.10
"""Largest ratio."""
COLUMNS, ROWS = 250, 20


@dataclass(frozen=True)
class Bed(Wall):
    """A flat bed of pieces of equal length."""

    name: str
    pieces: int

    def chains(self) -> tuple[Chain, ...]:
        """One chain from left to right."""
        return (Chain(tuple((x, 0.0) for x in np.linspace(-1.0, 0.2 * COLUMNS + 1.0, self.pieces + 1))),)


def flow(faces: int) -> Scene:
    """Discs that slide and fall on a bed of so many faces, between two upright walls' distance, with friction."""
    rng = np.random.default_rng(2)
    places = np.array([(0.2 * i + 0.1, 0.1 + 0.2 * j) for j in range(ROWS) for i in range(COLUMNS)])
    return handmade_scene(
        places, rng.normal(0.0, 0.5, places.shape), (Bed("bed", faces),), friction=0.1, skin=0.06, steps=10**8,
        output_steps=10**7, overlap_limit=0.2, domain=((-50.0, 100.0), (-9.0, 20.0)),
    )  # fmt: skip


def native(scene: Scene, _: Path) -> Callable[[int], object]:
    """A function that goes on by so many steps on the native engine."""
    return NativeSimulation(scene, ledger=False).run


def compiled(scene: Scene, folder: Path) -> Callable[[int], object]:
    """A function that goes on by so many steps with the compiled styles."""
    engine = load_lammps().lammps(cmdargs=["-log", "none", "-screen", "none", *plugin_arguments(plugin_path())])
    script = write_script(scene, folder, kernel="compiled").read_text().partition("# --- run")[0]
    for name in ("discs.data", "dump.lammpstrj"):
        script = script.replace(name, str(folder / name))
    engine.commands_string(script)
    engine.command("run 0 post no")
    return lambda steps: engine.command(f"run {steps} pre no post no")


def measure(start: Callable[[Scene, Path], Callable[[int], object]], faces: int, steps: int, rounds: int) -> float:
    """Print the medians of one engine; the ratio."""
    with tempfile.TemporaryDirectory() as one, tempfile.TemporaryDirectory() as many:
        runs = start(flow(1), Path(one)), start(flow(faces), Path(many))
        times = np.empty((rounds + 1, 2))
        for k in range(rounds + 1):
            for side in (0, 1) if k % 2 else (1, 0):
                begun = process_time()
                runs[side](steps)
                times[k, side] = (process_time() - begun) / steps
    times = times[1:]  # the first round warms up
    ratio = median(times[:, 1] / times[:, 0])
    alone, together = 1e6 * np.median(times, axis=0)
    print(f"{start.__name__:9} 1 face {alone:7.1f} us a step, {faces} faces {together:7.1f} us, ratio {ratio:.3f}")
    return ratio


def main() -> None:
    """Measure both engines."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--faces", type=int, default=1000)
    parser.add_argument("--steps", type=int, default=2000, help="steps of a turn")
    parser.add_argument("--rounds", type=int, default=7)
    given = parser.parse_args()
    ratios = [measure(start, given.faces, given.steps, given.rounds) for start in (native, compiled)]
    sys.exit(max(ratios) > MOST)


if __name__ == "__main__":
    main()
