"""What a person reads at the end of a run."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from lammps_jump.analysis.quantities import main_numbers


def print_summary(summary: dict[str, Any], folder: Path) -> None:
    """The main numbers of a summary, and where to look."""
    discs, seconds = summary["discs"], summary["wall_seconds"]
    rate = summary["disc_steps_per_second"] or 0.0
    print(
        f"discs: {discs['inserted']} inserted = {discs['present']} present + {discs['removed']} removed, "
        f"{discs['lost']} lost\n"
        f"time: build {seconds['build']:.2f} s, run {seconds['run']:.2f} s ({rate / 1e6:.1f} M disc-steps/s), "
        f"analysis {seconds['analysis']:.2f} s"
    )
    for line in main_numbers(summary):
        print(line)
    for warning in summary.get("warnings", []):
        print(f"note: {warning}")
    print(f"look at {folder}/report.html")
