# SPDX-License-Identifier: GPL-2.0-or-later
"""Numbers of a jump in the frame of its front."""

from __future__ import annotations

from lammps_jump import Run


def jump(run: Run) -> dict:
    """Froude number, depth ratio and what Bélanger and momentum with thrust leave over."""
    found = run.summary["jump"]
    if found["verdict"] != "jump" or found.get("momentum_terms") is None or found.get("y1") is None:
        raise ValueError(f"no jump: {found['verdict']}, {found.get('reason')}")
    return {
        "froude": found["froude"],
        "ratio": found["y2"] / found["y1"],
        "belanger_deviation": found["belanger_deviation"],
        "unexplained": found["momentum_terms"]["unexplained"],
        "density_relation_ratio": found["local"]["density_relation_ratio"],
        "speed": found["speed"],
        "share": found["share_found"],
    }
