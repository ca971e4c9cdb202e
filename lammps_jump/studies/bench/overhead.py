# SPDX-License-Identifier: GPL-2.0-or-later
"""Time of a whole command around its engine, by phase: what a user waits for beside the stepping."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from lammps_jump import Case
from lammps_jump.errors import RunError
from lammps_jump.files import write_text
from lammps_jump.runs.summary import SUMMARY_FILE
from lammps_jump.studies.runs import in_turn, middle
from lammps_jump.studies.table import filled, markdown
from lammps_jump.sweeps.store import Results, Say, Store, all_versions

ROUNDS = 5
PHASES = {
    "build": "case, scene, script",
    "engine": "engine: the stepping alone",
    "reading": "frames not yet read when the engine ends",
    "results": "analyses",
    "tables": "profiles, tables, curves",
    "figures": "waiting for the two pictures",
    "report": "report",
    "else": "starting, the engine's libraries, checksums, putting into place, ending",
}
"""What a whole command consists of, in order."""


def command_time(case: Case) -> dict[str, float]:
    """Return wall seconds of `PHASES` of ``build-and-run`` in a process of its own, and of the ``whole``.

    Raises
    ------
    RunError
        The command failed.
    """
    with tempfile.TemporaryDirectory() as place:
        path, folder = write_text(Path(place) / "case.yaml", case.to_yaml()), Path(place) / "run"
        command = [sys.executable, "-P", "-m", "lammps_jump.cli.app", "build-and-run", path, "--out", folder, "--quiet"]
        begin = time.perf_counter()
        ended = subprocess.run(command, capture_output=True, text=True)
        whole = time.perf_counter() - begin
        if ended.returncode:
            raise RunError(f"{case.name}: the command failed: {ended.stderr.strip()}")
        summary = json.loads((folder / SUMMARY_FILE).read_text())
    seconds = summary["wall_seconds"]
    known = {"build": seconds["build"], "engine": seconds["run"], **summary["analysis_seconds"]}
    return {**known, "else": whole - sum(known.values()), "whole": whole}


def time_commands(case: Case, store: Store, *, quick: bool, say: Say) -> Results:
    """Time the whole command several times; a row holds the median seconds of a phase, and its share of the engine."""

    def timed(name: str, turn: int) -> dict[str, float]:
        found = store.piece(f"{turn} {case.hash} {all_versions()}", lambda: command_time(case))
        say(f"  whole command {found['whole']:.2f} s, engine {found['engine']:.2f} s")
        return found

    timed(case.name, -1)  # compiles what is compiled on first use
    (runs,) = in_turn([case.name], 1 if quick else ROUNDS, timed).values()
    engine = middle(run["engine"] for run in runs)
    rows = [{"phase": phase, "seconds": middle(run.get(phase, 0.0) for run in runs)} for phase in (*PHASES, "whole")]
    ratios = [run["whole"] / run["engine"] for run in runs]
    return {"rows": rows, "engine": engine, "rounds": len(runs), "ratio": middle(ratios)}


def overhead_page(data: Results, folder: Path) -> str:
    """Return the Markdown table."""
    told = (
        {"name": PHASES.get(row["phase"], "**whole command**"), "share": row["seconds"] / data["engine"], **row}
        for row in data["rows"]
    )
    lines = filled("{name}|{seconds:.2f}|{share:.2f}", told)
    table = markdown([data["case"], "wall time (s)", "over the engine"], "lrr", lines)
    return f"{table}\n\nMedians of {data['rounds']}; whole over engine within a run: {data['ratio']:.2f}.\n"
