"""What a person reads at the end of a run."""

from __future__ import annotations

from pathlib import Path
from typing import Any


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
    for part, keys in MAIN_NUMBERS.items():
        found = summary.get(part)
        if isinstance(found, dict):
            texts = [f"{label} {_show(found[key])}{unit}" for key, label, unit in keys if found.get(key) is not None]
            if texts:
                print(f"{part}: " + ", ".join(texts))
    for warning in summary.get("warnings", []):
        print(f"note: {warning}")
    print(f"look at {folder}/report.html")


MAIN_NUMBERS = {
    "jump": [
        ("verdict", "", ""),
        ("froude", "Fr1", ""),
        ("y1", "y1", " m"),
        ("y2", "y2", " m"),
        ("belanger_y2", "Bélanger", " m"),
        ("speed", "shock speed", " m/s"),
        ("length", "length", " m"),
    ],
    "front": [("position", "front at", " m"), ("speed", "speed", " m/s")],
    "energy": [("initial", "at the start", " J/m"), ("max_deviation", "largest deviation", ""), ("drift", "drift", "")],
}


def _show(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
