# SPDX-License-Identifier: GPL-2.0-or-later
"""Times that README.md tells: ``make times`` measures them, in processor time beside a fixed loop, and writes them.

Seconds of one machine, or of a busy one, tell little. The loop of `budget` takes its share of both.
"""

from __future__ import annotations

import os
import re
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

from budget import BUDGETS, fixed_loop, processor_seconds

ROOT = Path(__file__).parents[1]
BEGIN, END = "<!-- times: `make times` writes them -->", "<!-- end of times -->"
LOOPS = 15
"""Runs of the loop before and after each job; the median counts."""
JOBS = {
    "compiling the C++, once": ("-m", "lammps_jump.engines.plugin.make"),
    "`quick_jump` from case to report": (
        "-m", "lammps_jump", "build-and-run", "inputs/quick_jump.yaml", "--quiet", "--out", "PLACE/run",
    ),
}  # fmt: skip
"""What is measured, and what Python is told to run; the caches are empty before the first."""


def measured() -> tuple[dict[str, float], dict[str, float]]:
    """Processor seconds of each job, and of the loop beside it."""
    seconds, loops = {}, {}
    with tempfile.TemporaryDirectory() as place:
        for name, words in JOBS.items():
            beside = [fixed_loop() for _ in range(LOOPS)]
            before = processor_seconds()
            command = [sys.executable, *(word.replace("PLACE", place) for word in words)]
            subprocess.run(command, cwd=ROOT, check=True, env={**os.environ, "LAMMPS_JUMP_CACHE": f"{place}/cache"})
            seconds[name] = processor_seconds() - before
            beside += [fixed_loop() for _ in range(LOOPS)]
            loops[name] = statistics.median(beside)
    return seconds, loops


def block(seconds: dict[str, float], loops: dict[str, float]) -> str:
    """The table, Markdown."""
    loop = statistics.mean(loops.values())
    times = {name: seconds[name] / loops[name] for name in seconds}
    times |= {f"the tests, {kind}, at most": budget for kind, budget in BUDGETS.items()}
    rows = [
        f"| {name} | {float(f'{number:.2g}'):,.0f} | {float(f'{number * loop:.2g}'):g} s |"
        for name, number in times.items()
    ]
    return "\n".join(
        [
            BEGIN,
            "| processor time of | runs of a fixed loop | on the machine where it was measured |",
            "|---|---|---|",
            *rows,
            "",
            f"The loop took {1000 * loop:.1f} ms there. `.venv/bin/python tests/budget.py` tells what it takes on your",
            "machine. Two free cores need half of the processor time.",
            END,
        ]
    )


def main() -> None:
    """Measure, and write the table into README.md."""
    page = ROOT / "README.md"
    table = block(*measured())
    page.write_text(re.sub(f"{BEGIN}.*{END}", lambda _: table, page.read_text(), flags=re.DOTALL))
    print(table)


if __name__ == "__main__":
    main()
