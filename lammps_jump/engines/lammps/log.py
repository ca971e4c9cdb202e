# SPDX-License-Identifier: GPL-2.0-or-later
"""What the LAMMPS log tells of a run: disc balance, disc-steps, where the time went, errors."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

from lammps_jump.files import text_of


@dataclass
class LogSummary:
    """Numbers read from a log.

    Attributes
    ----------
    step, time, discs, removed : last values of the log lines
    removed_by : tuple of int
        Discs that each outlet has taken.
    highest_id : int
        Highest disc id ever logged, 0 where the log has no such column.
    disc_steps : float
        Trapezoid of discs over steps.
    breakdown : dict
        Seconds in Pair, Neigh, Comm, Output, Modify, Other.
    error : str
        Text of the first ERROR line, else empty.
    rows : int
        Log lines of the run seen.
    """

    step: int = 0
    time: float = 0.0
    discs: int = 0
    removed: int = 0
    removed_by: tuple[int, ...] = ()
    highest_id: int = 0
    disc_steps: float = 0.0
    breakdown: dict[str, float] = field(default_factory=dict)
    error: str = ""
    rows: int = 0


def read_log(path: Path) -> LogSummary:
    """Parse a log file; a missing one gives an empty summary."""
    summary = LogSummary()
    if not path.exists():
        return summary
    columns: list[str] | None = None
    previous: tuple[int, int] | None = None
    for line in text_of(path, "replace").splitlines():
        words = line.split()
        if words[:2] == ["Step", "Time"]:
            columns = words
            continue
        if line.startswith("Loop time of"):
            columns = None
            continue
        if columns and len(words) == len(columns):
            try:
                values = [float(word) for word in words]
            except ValueError:
                continue
            _take(summary, dict(zip(columns, values, strict=True)))
            if previous is not None:
                summary.disc_steps += 0.5 * (previous[1] + summary.discs) * (summary.step - previous[0])
            previous = (summary.step, summary.discs)
        elif line.startswith("ERROR") and not summary.error:
            summary.error = line
        elif match := re.match(r"(Pair|Neigh|Comm|Output|Modify|Other)\s+\|\s*([\d.eE+-]*)\s*\|\s*([\d.eE+-]+)", line):
            summary.breakdown[match[1].lower()] = summary.breakdown.get(match[1].lower(), 0.0) + float(match[3])
    return summary


def _take(summary: LogSummary, row: dict[str, float]) -> None:
    summary.rows += 1
    summary.step, summary.time, summary.discs = int(row["Step"]), row["Time"], int(row["Atoms"])
    summary.removed_by = tuple(int(value) for name, value in row.items() if name.startswith("f_outlet"))
    summary.removed = sum(summary.removed_by)
    if "c_top" in row and row["c_top"] > 0:
        summary.highest_id = max(summary.highest_id, int(row["c_top"]))
