# SPDX-License-Identifier: GPL-2.0-or-later
"""What a disc-step of a jet costs beside one of the same discs without inlets, own sizes and outlets.

Run as ``python benchmarks/jets.py [--turns 7] [--steps 2200] [--native] [--out DIR]``. inputs/stable_jump.yaml runs to
t = 8 s once. From its end the same discs go on for some steps in turns: in LAMMPS with the compiled styles, with parts
of the script left out, and in the native engine. One thread, no frames; guards, probe and log as in the case. Printed
are medians of the processor time of the steps, ns a disc-step, ratios to the closed box of the same turn, and LAMMPS'
own breakdown. Beside them: what two processes at once do of the work of one, by a loop of C.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from statistics import median
from typing import Any

import timed

import lammps_jump as lj
from lammps_jump.engines.lammps.drive import plugin_arguments
from lammps_jump.engines.lammps.loader import load_lammps
from lammps_jump.engines.launch import write_script
from lammps_jump.engines.native import NativeSimulation
from lammps_jump.engines.plugin import plugin_path

CASE = Path(__file__).parent.parent / "inputs" / "stable_jump.yaml"
BEGIN = 8.0
"""Time of the state, s."""
LATER = {
    "run.duration": 16.0, "run.output_interval": 0.1, "engine.threads": 1, "analysis.window": None, "name": "jet",
    "domain.x": [-5, 110], "domain.y": [-40, 40],
}  # fmt: skip
CLOSED = {"inflow": None, "outflow": []}
GROWTH = r"(?m)^ +sizes [^&\n]*&\n"
"""Words of the plugin's fix that give inserted discs their own size."""
VARIANTS = ("box", "outlets", "inlets", "inlets and sizes", "jet")
PARTS = ("Pair", "Neigh", "Comm", "Modify", "Other")


def case_of(before: lj.Run, variant: str) -> lj.Case:
    """The case that goes on from a run, with what the variant has."""
    case = lj.load_case(CASE, LATER).after(before)
    if variant == "box":
        return case.replace(CLOSED)
    if variant == "outlets":
        return case.replace({"inflow": None})
    return case if variant == "jet" else case.replace({"outflow": []})


def write_folder(before: lj.Run, variant: str, folder: Path) -> None:
    """The script of a variant; who plays it says for how many steps."""
    write_script(case_of(before, variant).scene(), folder, kernel="compiled")
    if variant == "inlets":
        script = folder / "in.plugin.lammps"
        text, count = re.subn(GROWTH, "", script.read_text())
        if count != 1:
            raise lj.RunError(f"{script} has no line of sizes that can be left out")
        script.write_text(text)


def play(folder: Path, steps: int) -> dict[str, float]:
    """Run the script of a folder for so many steps; processor time of a disc-step, s, and shares of LAMMPS' parts."""
    os.chdir(folder)
    engine = load_lammps().lammps(
        cmdargs=["-log", "log", "-screen", "none", "-nocite", *plugin_arguments(plugin_path())]
    )
    head, *runs = re.split(r"(?m)^(?=run )", (folder / "in.plugin.lammps").read_text())
    engine.commands_string(head + "\nundump frames\n")
    for part in runs:
        line, _, rest = part.partition("\n")
        if int(line.split()[1]) > 100:
            line = re.sub(r"run +\d+", f"run {steps}", line)
            first = engine.get_natoms()
            begin = time.process_time()
            engine.command(line)
            took = time.process_time() - begin
            discs = 0.5 * (first + engine.get_natoms())
        else:
            engine.command(line)
        engine.commands_string(rest)
    engine.command("log none")
    shown = (folder / "log").read_text().rpartition("Loop time")[2]
    parts = {name: float(re.search(rf"(?m)^{name} +\|[^|]*\| *(\S+) ", shown)[1]) for name in PARTS}
    whole = sum(parts.values())
    return {"ns": 1e9 * took / steps / discs, "discs": discs, **{name: spent / whole for name, spent in parts.items()}}


def play_native(before: lj.Run, variant: str, steps: int) -> dict[str, float]:
    """The same in the native engine."""
    simulation = NativeSimulation(case_of(before, variant).replace({"engine.name": "native"}).scene())
    simulation.run(100)
    first, begin = simulation.discs.n, time.process_time()
    simulation.run(steps)
    took = time.process_time() - begin
    discs = 0.5 * (first + simulation.discs.n)
    return {"ns": 1e9 * took / steps / discs, "discs": discs}


def child(room: Path, *words: object) -> dict[str, float]:
    """What this program prints in a process of its own."""
    quiet = {"OMP_NUM_THREADS": "1", "LAMMPS_JUMP_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    return json.loads(timed.ended([sys.executable, __file__, *words], room, **quiet)[1].splitlines()[-1])


def siblings(room: Path) -> float:
    """Work of two processes at once over that of one, by the plain loop: 2 where each has a core of its own."""
    loop = Path(room) / "plain"
    source = Path(__file__).parent / "plain_loop.c"
    subprocess.run(["cc", "-O3", "-march=native", "-o", loop, source, "-lm"], check=True)
    words = [str(loop), *map(str, (1200, 20000, 0.2, 2.56e7, 1.97e4, 1.8e-4))]

    def wall(count: int) -> float:
        begin = time.perf_counter()
        for process in [subprocess.Popen(words, stdout=subprocess.DEVNULL) for _ in range(count)]:
            process.wait()
        return time.perf_counter() - begin

    return median(2.0 * wall(1) / wall(2) for _ in range(3))


def turns_of(asked: argparse.Namespace, before: lj.Run, state: Path, room: Path) -> dict[str, list[dict[str, float]]]:
    """What each turn of each variant gave."""
    found: dict[str, list[dict[str, float]]] = {}
    for variant in VARIANTS:
        write_folder(before, variant, room / variant)
    for _ in range(asked.turns):
        for variant in VARIANTS:
            row = child(room, "--play", room / variant, "--steps", asked.steps)
            found.setdefault(variant, []).append(row)
        for variant in ("box", "jet") if asked.native else ():
            row = child(room, "--play-native", variant, "--state", state, "--steps", asked.steps)
            found.setdefault(f"native {variant}", []).append(row)
    return found


def row_of(name: str, turns: list[dict[str, float]], boxes: list[dict[str, float]]) -> dict[str, object]:
    """Medians of the turns, and of the ratios to the box of the same turn."""
    ratios = [turn["ns"] / box["ns"] for turn, box in zip(turns, boxes, strict=True)]
    middle = {key: median(turn[key] for turn in turns) for key in turns[0]}
    return {"variant": name, **middle, "ratio": median(ratios), "least": min(ratios), "most": max(ratios)}


def measured(asked: argparse.Namespace) -> Iterator[dict[str, Any]]:
    """Yield a row for each variant, and one for the machine; in a process of its own, that of one turn."""
    if asked.play:
        yield play(asked.play.resolve(), asked.steps)
        return
    with tempfile.TemporaryDirectory() as text:
        room = Path(text)
        state = (asked.state or room / "state").resolve()
        if not (state / "summary.json").exists():
            lj.load_case(CASE, {**LATER, "run.duration": BEGIN, "run.output_interval": 1.0}).run(state)
        before = lj.open_run(state)
        if asked.play_native:
            yield play_native(before, asked.play_native, asked.steps)
            return
        found = turns_of(asked, before, state, room)
        for name, turns in found.items():
            yield row_of(name, turns, found["box"])
        yield {"two_processes": siblings(room), "load": os.getloadavg()[0], "cores": os.cpu_count()}


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--turns", type=int, default=7)
    parser.add_argument("--steps", type=int, default=2200)
    parser.add_argument("--native", action="store_true", help="the native engine too")
    parser.add_argument("--state", type=Path, help="folder of the run to t = 8 s, made where it is not there")
    parser.add_argument("--play", type=Path, help=argparse.SUPPRESS)
    parser.add_argument("--play-native", help=argparse.SUPPRESS)
    sys.exit(timed.tell(parser, measured, "jets.json"))
