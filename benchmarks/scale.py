# SPDX-License-Identifier: GPL-2.0-or-later
"""What a step costs from 10^3 to 10^7 discs, with one thread and with two, beside a plain loop of C.

Run as ``python benchmarks/scale.py [DISCS ...] [--threads 1 2] [--rounds 3] [--same] [--out DIR]``. The scene is the
column of inputs/dam_break.yaml at its release. LAMMPS runs the script of the compiled styles with each number of
threads in turn, and plain_loop.c the same law on as many discs in a square lattice, which at first hardly touch; with
--same on the discs of the case. Printed are medians of nanoseconds a disc-step, without output, and the largest memory
of the process. Times of one thread are processor time. 10^7 discs take some minutes for each round.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
import timed

import lammps_jump as lj
from lammps_jump.engines.launch import write_script
from lammps_jump.engines.plugin import plugin_path

WORK = 6e7
"""Disc-steps of a run, but at least `FEWEST` steps."""
FEWEST = 20
PARTS = ("Pair", "Neigh", "Comm", "Modify", "Other")


def case_of(discs: int, steps: int) -> lj.Case:
    """The dam break with about so many discs, for so many steps and one frame at their end."""
    sets = timed.column(discs, 40, outflow=[{"x_beyond": 35}]) | {"run.duration": 1.0, "run.output_interval": 1.0}
    time = steps * lj.load_case(timed.CASE, sets).scene().coefficients.time_step
    return lj.load_case(timed.CASE, sets | {"run.duration": time, "run.output_interval": time})


def engine(folder: Path, threads: int) -> tuple[float, float, int]:
    """Seconds of a step without output, bytes of the process at most, and discs."""
    words = ("-var", "plugin", plugin_path())
    used, shown = timed.lammps_ended("in.plugin.lammps", folder, *words, LAMMPS_JUMP_THREADS=str(threads))
    steps = discs = 0
    for _, count, atoms in re.findall(r"Loop time of (\S+) on .* for (\d+) steps with (\d+) atoms", shown):
        steps, discs = steps + int(count), int(atoms)
    took = sum(float(one) for part in PARTS for one in re.findall(rf"^{part} +\|[^|]*\| (\S+) ", shown, re.M))
    if threads == 1:
        took *= 0.01 * float(re.findall(r"(\S+)% CPU use", shown)[-1])
    return took / steps, 1024.0 * used.ru_maxrss, discs


def plain(program: Path, case: lj.Case, discs: int, steps: int, same: bool) -> float:
    """Seconds of a step of the plain loop; `same`: with the discs of the case."""
    scene = case.scene()
    law = scene.coefficients
    words = [*map(str, (discs, steps, scene.diameter, law.stiffness, 0.5 * law.mass * law.gamma_normal, law.time_step))]
    if same:
        words.append(f"{program}.start")
        np.column_stack([scene.positions, scene.velocities]).tofile(words[-1])
    shown = subprocess.run([program, *words], capture_output=True, text=True, check=True).stdout
    return float(shown.split()[0]) / steps


def measured(asked: argparse.Namespace) -> Iterator[dict[str, Any]]:
    """Yield a row for each number of discs."""
    source = Path(__file__).parent / "plain_loop.c"
    with tempfile.TemporaryDirectory() as room:
        subprocess.run(["cc", "-O3", "-march=native", "-o", f"{room}/plain", source, "-lm"], check=True)
        for wanted in asked.discs:
            steps = max(FEWEST, int(WORK / wanted))
            case, folder = case_of(int(wanted), steps), Path(room) / f"{wanted:g}"
            folder.mkdir()
            write_script(case.scene(), folder, kernel="compiled")
            times: dict[int, list[float]] = {count: [] for count in (0, *asked.threads)}
            peak = discs = 0.0
            for _ in range(asked.rounds if wanted < 5e6 else 1):
                for count in asked.threads:
                    took, most, discs = engine(folder, count)
                    times[count].append(1e9 * took / discs)
                    peak = max(peak, most)
                times[0].append(1e9 * plain(Path(room) / "plain", case, int(discs), steps, asked.same) / discs)
            middle = {str(count): median(found) for count, found in times.items()}
            yield {"discs": discs, "plain": middle.pop("0"), "threads": middle, "peak": peak}


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("discs", nargs="*", type=float, default=[1e3, 1e4, 1e5, 1e6])
    parser.add_argument("--threads", nargs="+", type=int, default=[1, 2])
    parser.add_argument("--rounds", type=int, default=3, help="of 10^7 discs one")
    parser.add_argument("--same", action="store_true", help="the plain loop begins with the discs of the case")
    sys.exit(timed.tell(parser, measured, "scale.json"))
