# SPDX-License-Identifier: GPL-2.0-or-later
"""A whole command by phase, over its engine: what a user waits for beside the stepping.

Run as ``python benchmarks/command_overhead.py CASE [--quick] [--out DIR]``.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Collection, Mapping
from functools import partial
from pathlib import Path

from taking_turns import main, timed_in_turn

from lammps_jump import Case
from lammps_jump.analysis.tables import Column, markdown
from lammps_jump.errors import RunError
from lammps_jump.files import SUMMARY_FILE, read_json, write_text
from lammps_jump.studies.runs import middle
from lammps_jump.sweeps import Results, Say, Store
from lammps_jump.system import only_on, own_cores

SHORT, SHORT_ROUNDS, LONG_ROUNDS = 10.0, 7, 3
"""Rounds of a whole command whose engine takes fewer seconds than the first, and of others."""
PHASES = {
    "build": "case, scene, script",
    "engine": "engine: the stepping alone",
    "reading": "frames not yet read when the engine ends",
    "results": "analyses",
    "tables": "profiles, tables, curves, the picture of the depths",
    "player": "packing the frames for the page",
    "figures": "waiting for the picture of the discs",
    "report": "report",
    "else": "starting, the engine's libraries, checksums, putting into place, ending",
}
"""What a whole command consists of, in order."""


def command_time(case: Case, cores: Collection[int] = ()) -> dict[str, float]:
    """Return wall seconds of `PHASES` of ``build-and-run`` in a process of its own, and of the ``whole``.

    With them ``cpu`` and ``engine_cpu``, the processor seconds of all and of the engine. The process gets these `cores`
    only, where some are named.

    Raises
    ------
    RunError
        The command failed.
    """
    with tempfile.TemporaryDirectory() as place, only_on(cores):
        path, folder = write_text(Path(place) / "case.yaml", case.to_yaml()), Path(place) / "run"
        words = ("build-and-run", str(path), "--out", str(folder), "--quiet")
        begin, before = time.perf_counter(), os.times()
        ended = subprocess.run([sys.executable, "-P", "-m", "lammps_jump", *words], capture_output=True, text=True)
        whole, after = time.perf_counter() - begin, os.times()
        if ended.returncode:
            raise RunError(f"{case.name}: the command failed: {ended.stderr.strip()}")
        summary = read_json(folder / SUMMARY_FILE)
    seconds = summary["wall_seconds"]
    known = {"build": seconds["build"], "engine": seconds["run"], **summary["analysis_seconds"]}
    cpu = after.children_user + after.children_system - before.children_user - before.children_system
    spent = {"whole": whole, "cpu": cpu, "engine_cpu": summary["cpu_seconds"]}
    return {**known, "else": whole - sum(known.values()), **spent}


def time_commands(case: Case, store: Store, *, quick: bool, say: Say) -> Results:
    """Time the whole command several times, with all cores and with one in turn, seven times where it is short.

    A row holds the median seconds of a phase with all cores and with one.
    """
    all_cores = own_cores()
    calls = {"all cores": partial(command_time, case), "one core": partial(command_time, case, {min(all_cores)})}
    told = "{0[whole]:z.2f} s, engine {0[engine]:z.2f} s"
    time_all = partial(timed_in_turn, calls, store=store, identity=case.hash, say=say, told=told)
    first = time_all(rounds=1)["all cores"][0]  # it compiles what is compiled on first use, and is not counted
    rounds = 2 if quick else 1 + (SHORT_ROUNDS if first["engine"] < SHORT else LONG_ROUNDS)
    found = {name: runs[1:] for name, runs in time_all(rounds=rounds).items()}
    rows = [
        {"phase": phase, **{name: middle(run.get(phase, 0.0) for run in runs) for name, runs in found.items()}}
        for phase in (*PHASES, "whole", "cpu", "engine_cpu")
    ]
    ratios = {name: middle(run["whole"] / run["engine"] for run in runs) for name, runs in found.items()}
    spent = {name: middle(run["cpu"] / run["engine_cpu"] for run in runs) for name, runs in found.items()}
    return {"rows": rows, "rounds": rounds - 1, "ratios": ratios, "cpu_ratios": spent}


def overhead_page(data: Results, folder: Path) -> list[str]:
    """Return the table, and what it holds."""
    ends = {
        "whole": "**whole command**",
        "cpu": "processor time of the whole command",
        "engine_cpu": "processor time of the engine",
    }
    columns: dict[str, Column] = {data["case"]: lambda row: PHASES.get(row["phase"]) or ends[row["phase"]]}
    for name in data["ratios"]:
        engine = next(row[name] for row in data["rows"] if row["phase"] == "engine")
        columns[f"{name} (s):"] = partial(_shown, name, 1.0)
        columns[f"{name}, over the engine:"] = partial(_shown, name, engine)
    told = [
        f"{name} {ratio:z.2f} (processor time {data['cpu_ratios'][name]:z.2f})"
        for name, ratio in data["ratios"].items()
    ]
    said = f"Medians of {data['rounds']}; whole over engine within a run: {', '.join(told)}."
    return [markdown(columns, data["rows"]), said]


def _shown(name: str, unit: float, row: Mapping[str, float]) -> str:
    return f"{row[name] / unit:z.2f}"


if __name__ == "__main__":
    raise SystemExit(main(__doc__, "overhead", time_commands, overhead_page))
