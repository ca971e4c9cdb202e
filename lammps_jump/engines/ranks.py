"""How many MPI ranks a scene gets."""

from __future__ import annotations

import os

from lammps_jump.scene.scene import Scene

DISCS_PER_RANK = 2_500
"""Below this another rank waits for a good part of its time, spinning (docs/scaling.md)."""


def free_cores() -> int:
    """Cores this process may use, less those that the load of the last minute takes; at least 1."""
    cores = len(os.sched_getaffinity(0))
    try:
        busy = os.getloadavg()[0]
    except OSError:
        busy = 0.0
    return max(1, cores - round(busy))


def expected_discs(scene: Scene) -> int:
    """Discs in play at the end if none leaves: those at the start and all that the inlets can bring."""
    steps = scene.steps - scene.settle_steps
    brought = sum(row.limit or steps // row.every_steps for row in scene.inlets)
    return len(scene.positions) + brought + sum(item.count for item in scene.pours)


def choose_ranks(wanted: int | str, scene: Scene) -> tuple[int, list[str]]:
    """Number of ranks, and what to tell the user.

    ``auto``: one for small scenes, never more than free cores. A number is obeyed, with a note where cores lack.
    """
    if wanted == "auto":
        return max(1, min(free_cores(), expected_discs(scene) // DISCS_PER_RANK)), []
    cores = len(os.sched_getaffinity(0))
    if wanted > cores:
        return int(wanted), [f"{wanted} ranks on {cores} cores: ranks spin while they wait, fewer would be faster"]
    return int(wanted), []
