# SPDX-License-Identifier: GPL-2.0-or-later
"""``summary.json``: the numbers of a run, SI floats, null where there is no number."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any, Literal

from pydantic import BaseModel, FiniteFloat, NonNegativeInt, PositiveInt, ValidationError

from lammps_jump import analysis
from lammps_jump.case.case import ReadCase
from lammps_jump.engines import RunResult, Setting
from lammps_jump.errors import DumpError
from lammps_jump.files import plain, read_json, write_json
from lammps_jump.provenance import versions

from .engine import full_key, run_key

SUMMARY_FILE = "summary.json"
NO_SUMMARY = (
    "the file is no summary of a run: delete it, and `lammps-jump analyze` makes it again from what the run wrote"
)


ANALYSED = ("inflow", "jump", "front", "energy", "force")
"""What the analyses have found, each checked as it is described there."""


class _Discs(BaseModel, strict=True, extra="forbid"):
    inserted: int
    present: int
    removed: int
    lost: int


class _Seconds(BaseModel, strict=True):
    build: FiniteFloat
    run: FiniteFloat
    analysis: FiniteFloat


class _Sum(BaseModel, strict=True, extra="forbid"):
    size: NonNegativeInt
    sha256: str


class _Analysed(BaseModel, strict=True, extra="forbid"):
    key: str
    files: dict[str, _Sum]


class Stored(BaseModel, strict=True):
    """What is read back of a summary."""

    name: str = ""
    description: str = ""
    status: Literal["complete", "unchecked", "interrupted", "failed"]
    message: str | None
    engine: str
    kernel: str
    case_hash: str
    versions: dict[str, str]
    steps: NonNegativeInt
    disc_steps: FiniteFloat
    disc_steps_per_second: FiniteFloat | None = None
    discs: _Discs
    wall_seconds: _Seconds
    cpu_seconds: FiniteFloat = 0.0
    breakdown_seconds: dict[str, float | None] | None
    ledger: dict[str, float | None] | None
    coefficients: dict[str, FiniteFloat | None] = {}
    skipped: list[str] = []
    ranks: PositiveInt = 1
    resumed_at: list[FiniteFloat] = []
    can_go_on: bool = False
    warnings: list[str] = []
    key: str = ""
    stopped_when_steady: str = ""
    files: list[str] = []
    outputs: dict[str, _Sum] | None = None
    analysed: _Analysed | None = None


def compose(
    case: ReadCase,
    setting: Setting,
    result: RunResult,
    *,
    seconds: Mapping[str, float],
    parts: Mapping[str, Any],
    notes: Sequence[str] = (),
) -> dict[str, Any]:
    """All of ``summary.json``.

    Parameters
    ----------
    case : Case
    setting : Setting
    result : RunResult
    seconds : mapping
        Wall seconds of build, run, analysis.
    parts : mapping
        What the analyses found: jump, front, energy, force, profiles, warnings.
    notes : sequence of str
        Why this setting was chosen; they stand among the warnings.
    """
    scene, found = case.scene(), dict(parts)
    discs = {name: getattr(result, name) for name in ("inserted", "present", "removed", "lost")}
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
            "case_hash": run_key(case, setting),
            "key": full_key(case, setting),
            "versions": {**versions(), **result.versions},
            "coefficients": asdict(scene.coefficients),
            "steps": result.steps,
            "simulated_time": scene.time(result.steps),
            **({"resumed_at": result.resumed} if result.resumed else {}),
            **({"can_go_on": True} if result.outside else {}),
            "wall_seconds": seconds,
            "cpu_seconds": result.cpu_seconds,
            "disc_steps": result.disc_steps,
            "disc_steps_per_second": result.disc_steps / result.seconds if result.seconds > 0 else None,
            "breakdown_seconds": result.breakdown or None,
            "discs": discs,
            "ledger": result.ledger,
            "skipped": list(scene.skipped),
            "warnings": [*scene.warnings, *scene.adapted, *notes, *found.pop("warnings", ())],
            **found,
            "ranks": setting.ranks,
            "theory": case.check().theory,
        }
    )


def write_summary(folder: Path, summary: Mapping[str, object]) -> Path:
    """Write the summary; NaN would be an error, not a file that others cannot read."""
    return write_json(folder / SUMMARY_FILE, summary, indent=2)


def read_summary(folder: Path) -> dict[str, Any]:
    """The summary of a run folder, empty where there is none that can be read.

    Raises
    ------
    DumpError
        Where the file is JSON and no summary of a run.
    """
    path = folder / SUMMARY_FILE
    try:
        found = read_json(path)
    except (OSError, ValueError):
        return {}
    place = ""
    try:
        Stored.model_validate(found)
        for place, kind, value in analysis.quantities.stored_parts(found) if set(ANALYSED) & set(found) else ():  # noqa: B007
            kind.validate_python(value)
    except ValidationError as error:
        first = error.errors()[0]
        place = "".join(f" {name}:" for name in (place, *first["loc"]) if name != "")
        got = str(plain(first["input"]))[:40]
        raise DumpError(f"{path}:{place} {first['msg']}, got {got!r}; {NO_SUMMARY}") from None
    return found
