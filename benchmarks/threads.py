# SPDX-License-Identifier: GPL-2.0-or-later
"""What two threads bring beside two processes at once: both engines, boxes and jets, few and many discs.

Run as ``python benchmarks/threads.py [DISCS ...] [--engines compiled native] [--quick] [--rounds 7] [--out DIR]``.
The box is the column of inputs/dam_break.yaml at its release, the jet inputs/stable_jump.yaml with its inlets, sizes
and outlets. Each way of running is a process that stays: one thread, two threads, ``auto``, and two processes of one
thread at once. They take turns, and each turn does the same steps of the same motion, without output. Printed are
medians of wall time, ns a disc-step, and of the ratios within a round:

- processes: work of two processes at once over that of one, the most that two threads can give on this machine;
- threads: one thread over two threads;
- share: threads over processes;
- auto: one thread over ``auto``.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import pickle
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median
from time import perf_counter
from typing import NamedTuple

import lammps_jump as lj
from lammps_jump.engines.lammps.loader import new_engine
from lammps_jump.engines.launch import write_script
from lammps_jump.engines.native import NativeSimulation
from lammps_jump.engines.native.bound import Core
from lammps_jump.engines.plugin import plugin_path
from lammps_jump.errors import JumpError

INPUTS = Path(__file__).parent.parent / "inputs"
COLUMN, JUMP = 48.0, 241.0
"""m² that the discs of the box and of the jet would fill as squares at the start."""
LONG = 1000.0
"""Duration of the cases, s: longer than any turn."""
WORK, SHORT_WORK = 3e7, 5e6
"""Disc-steps of a turn."""
WAYS = {"one": "1", "two": "2", "auto": "auto:2", "first": "1", "second": "1"}
"""Each process and its threads; the last two run at once."""


class Row(NamedTuple):
    """A row of the table: ns a disc-step, and ratios."""

    engine: str
    flow: str
    discs: int
    one: float
    two: float
    auto: float
    processes: float
    threads: float
    share: float
    auto_over_one: float


def case_of(flow: str, discs: int) -> lj.Case:
    """The box or the jet with about so many discs."""
    shared = {"run.duration": LONG, "run.output_interval": LONG}
    if flow == "jet":
        size = math.sqrt(JUMP / discs)
        return lj.load_case(
            INPUTS / "stable_jump.yaml", {**shared, "discs.diameter": size, "analysis.window": [4, LONG]}
        )
    size = math.sqrt(COLUMN / discs)
    room = {"domain.x": [-1, 40], "domain.y": [-1, 20], "outflow": [{"x_beyond": 35}], "probes": {}}
    return lj.load_case(INPUTS / "dam_break.yaml", {**shared, **room, "discs.diameter": size})


def native_steps(folder: Path, threads: str):
    """A function that does steps on the native engine, and the discs that are there."""
    scene = pickle.loads((folder / "scene").read_bytes())
    simulation = NativeSimulation(scene, loops=Core(threads))
    return simulation.run, lambda: simulation.discs.n


def compiled_steps(folder: Path, threads: str):
    """A function that does steps in LAMMPS with the compiled styles, and the discs that are there."""
    os.environ["LAMMPS_JUMP_THREADS"] = threads
    os.chdir(folder)
    engine = new_engine(["-log", "none", "-screen", "none", "-nocite", "-var", "plugin", f'"{plugin_path()}"'])
    lines = (folder / "in.plugin.lammps").read_text().replace("&\n", " ").splitlines()
    last = max(number for number, line in enumerate(lines) if line.startswith("run"))
    for line in lines[:last]:
        if not line.startswith(("dump", "undump")):
            engine.command(line)
    engine.command("thermo 1000000")
    return lambda steps: engine.command(f"run {steps} pre no post no"), engine.get_natoms


def serve(engine: str, folder: Path, threads: str) -> None:
    """Do as many steps as each line of the input says; answer with seconds and discs."""
    run, discs = (native_steps if engine == "native" else compiled_steps)(folder, threads)
    run(20)
    print("ready", discs(), flush=True)
    for line in sys.stdin:
        begun = perf_counter()
        run(int(line))
        print(perf_counter() - begun, discs(), flush=True)


class Server:
    """A process that does steps."""

    def __init__(self, engine: str, folder: Path, threads: str):
        words = [sys.executable, __file__, "--serve", engine, str(folder), threads]
        self._process = subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def answer(self) -> tuple[str, int]:
        """The next answer."""
        line = self._process.stdout.readline().split()
        if len(line) != 2:
            raise lj.RunError(f"{self._process.args} has ended")
        return line[0], int(line[1])

    def begin(self, steps: int) -> None:
        """Let it do so many steps."""
        self._process.stdin.write(f"{steps}\n")
        self._process.stdin.flush()

    def close(self) -> None:
        """End the process."""
        self._process.stdin.close()
        self._process.wait()


def measure(engine: str, flow: str, wanted: int, asked: argparse.Namespace, room: Path) -> Row:
    """A row of the table."""
    scene = case_of(flow, wanted).scene()
    folder = room / f"{engine}_{flow}_{wanted}"
    write_script(scene, folder, kernel="compiled")
    (folder / "scene").write_bytes(pickle.dumps(scene))
    servers = {}
    try:
        for name, threads in WAYS.items():
            servers[name] = Server(engine, folder, threads)
            _, discs = servers[name].answer()
        steps = max(20, int((SHORT_WORK if asked.quick else WORK) / discs))
        rounds: list[dict[str, float]] = []
        for _ in range(asked.rounds + 1):
            took = {}
            for names in (("one",), ("two",), ("auto",), ("first", "second")):
                for name in names:
                    servers[name].begin(steps)
                for name in names:
                    took[name] = float(servers[name].answer()[0])
            rounds.append(took)
    finally:
        for server in servers.values():
            server.close()
    rounds = rounds[1:]  # memory was new in the first
    both = [2 * one["one"] / max(one["first"], one["second"]) for one in rounds]
    threads_ratio = [one["one"] / one["two"] for one in rounds]
    share = [a / b for a, b in zip(threads_ratio, both, strict=True)]
    ns = [1e9 * median(one[name] for one in rounds) / steps / discs for name in ("one", "two", "auto")]
    auto = median(one["one"] / one["auto"] for one in rounds)
    return Row(engine, flow, discs, *ns, median(both), median(threads_ratio), median(share), auto)


def machine() -> str:
    """Processor, cores and load."""
    names = [
        line.partition(":")[2].strip()
        for line in Path("/proc/cpuinfo").read_text().splitlines()
        if "model name" in line
    ]
    return f"{names[0] if names else 'unknown processor'}, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}"


def main() -> int:
    """Print the table; the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("discs", nargs="*", type=int, default=[5_000, 120_000])
    parser.add_argument("--engines", nargs="+", choices=("compiled", "native"), default=["compiled", "native"])
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--quick", action="store_true", help="turns of a sixth of the length")
    parser.add_argument("--out", type=Path, help="folder for threads.json")
    asked = parser.parse_args()
    print(f"{machine()}; medians of {asked.rounds}\n")
    print("| engine | flow | discs | 1 thread, ns | 2 threads | auto | processes | threads | share | 1 over auto |")
    print("|---|---|---|---|---|---|---|---|---|---|", flush=True)
    rows = []
    with tempfile.TemporaryDirectory() as room:
        for engine in asked.engines:
            for flow in ("box", "jet"):
                for discs in asked.discs:
                    row = measure(engine, flow, discs, asked, Path(room))
                    rows.append(row._asdict())
                    times = " | ".join(f"{ns:.1f}" for ns in row[3:6])
                    ratios = " | ".join(f"{ratio:.2f}" for ratio in row[6:])
                    print(f"| {row.engine} | {row.flow} | {row.discs:,} | {times} | {ratios} |", flush=True)
    if asked.out:
        asked.out.mkdir(parents=True, exist_ok=True)
        (asked.out / "threads.json").write_text(json.dumps(rows))
    return 0


if __name__ == "__main__":
    if sys.argv[1:2] == ["--serve"]:
        serve(sys.argv[2], Path(sys.argv[3]), sys.argv[4])
        sys.exit(0)
    try:
        sys.exit(main())
    except JumpError as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(1)
