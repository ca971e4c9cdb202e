"""``summary.json``: the numbers of a run, SI floats, null where there is no number."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from lammps_jump.case.derived import coefficients
from lammps_jump.engines.result import RunResult
from lammps_jump.errors import DumpError
from lammps_jump.files import plain
from lammps_jump.provenance import versions
from lammps_jump.scene.scene import Scene

SUMMARY_FILE = "summary.json"
FIELD_TYPES = {
    "status": str, "message": str, "engine": str, "kernel": str, "case_hash": str, "steps": int,
    "disc_steps": int | float, "discs": dict, "wall_seconds": dict, "versions": dict, "ledger": dict,
    "breakdown_seconds": dict, "resumed_at": list,
}  # fmt: skip
"""What is read back of a summary; each may be null or missing."""
NO_SUMMARY = "it is no summary of a run: delete it, and `lammps-jump analyze` makes it anew from what the run wrote"


def compose(
    scene: Scene, result: RunResult, *, case_hash: str, seconds: dict[str, float], parts: dict[str, Any]
) -> dict[str, Any]:
    """All of ``summary.json``.

    Parameters
    ----------
    scene : Scene
    result : RunResult
    case_hash : str
    seconds : dict
        Wall seconds of build, run, analysis.
    parts : dict
        What the analyses found: jump, front, energy, force, profiles, warnings.
    """
    return plain(
        {
            "name": scene.name,
            "description": scene.description,
            "status": result.status,
            "message": result.message or None,
            "engine": result.engine,
            "kernel": result.kernel,
            "integrator": scene.integrator,
            "friction_law": scene.friction_law if scene.coefficients.friction else None,
            "case_hash": case_hash,
            "versions": {**versions(), **result.versions},
            "coefficients": coefficients(scene),
            "steps": result.steps,
            "simulated_time": scene.time(result.steps),
            **({"resumed_at": result.resumed} if result.resumed else {}),
            "wall_seconds": seconds,
            "disc_steps": result.disc_steps,
            "disc_steps_per_second": result.disc_steps / result.seconds if result.seconds > 0 else None,
            "breakdown_seconds": result.breakdown or None,
            "discs": {
                "inserted": result.inserted,
                "present": result.present,
                "removed": result.removed,
                "lost": result.lost,
            },
            "ledger": result.ledger,
            "skipped": list(scene.skipped),
            "warnings": list(scene.warnings),
            **parts,
        }
    )


def write_summary(folder: Path, summary: dict[str, Any]) -> Path:
    """Write the summary; NaN would be an error, not a file that others cannot read."""
    path = folder / SUMMARY_FILE
    path.write_text(json.dumps(plain(summary), indent=2, allow_nan=False) + "\n")
    return path


def read_summary(folder: Path) -> dict[str, Any] | None:
    """The summary of a run folder, None where there is none that can be read.

    Raises
    ------
    DumpError
        Where the file is JSON and no summary of a run.
    """
    path = folder / SUMMARY_FILE
    try:
        found = json.loads(path.read_text())
    except (OSError, ValueError):
        return None
    if not isinstance(found, dict):
        raise DumpError(f"{path}: a {type(found).__name__} where a mapping was expected; {NO_SUMMARY}")
    for name, kind in FIELD_TYPES.items():
        if found.get(name) is not None and not isinstance(found[name], kind):
            raise DumpError(f"{path}: {name} is {str(found[name])[:40]!r}; {NO_SUMMARY}")
    for name in ("discs", "wall_seconds", "breakdown_seconds"):
        for key, value in (found.get(name) or {}).items():
            if value is not None and not isinstance(value, int | float):
                raise DumpError(f"{path}: {name}.{key} is {str(value)[:40]!r}; {NO_SUMMARY}")
    return found
