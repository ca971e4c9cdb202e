# SPDX-License-Identifier: GPL-2.0-or-later
"""What ``lammps-jump sensitivity`` takes from a run."""

from __future__ import annotations

from typing import Any

from lammps_jump import Run

NUMBERS = ("froude", "y1", "y2", "belanger_y2", "belanger_deviation", "length_over_y2", "length_usbr", "speed")


def jump_found(run: Run) -> dict[str, Any]:
    """Numbers of the jump, empty where none was found; its verdict, and the processor time (s)."""
    jump = run.summary.get("jump") or {}
    found = jump if jump.get("verdict") == "jump" else {}
    numbers = {name: found.get(name) for name in NUMBERS} if found else {}
    return {
        "outcome": jump.get("verdict") or "complete",
        "seconds": run.summary.get("cpu_seconds", 0.0),
        "jump": numbers,
    }
