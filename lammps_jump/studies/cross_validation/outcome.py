"""Everything a cross-validation found."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from lammps_jump.case import LoadedCase
from lammps_jump.scene.scene import Scene

from .divergence import Divergence
from .ensembles import EngineChoice, Member
from .quantities import Comparison, Quantities
from .trajectories import DeterministicCheck


@dataclass
class Study:
    """Everything a cross-validation found; figures and report are made from it."""

    name: str
    scene: Scene
    loaded: LoadedCase
    engine: EngineChoice
    checks: list[DeterministicCheck]
    known: dict[tuple[str, str], str]
    divergence: Divergence | None
    members: dict[str, list[Member]]
    quantities: dict[str, list[Quantities]]
    comparison: Comparison | None
    laws: dict[str, tuple[str, Comparison]]
    criteria: list[dict[str, Any]]
    notes: list[str]
    seconds: float = 0.0

    def expected(self, check: DeterministicCheck) -> str | None:
        """Why a check that does not agree need not; None where it must."""
        small = not check.agrees and check.worst <= KNOWN_LIMIT and not check.note
        return self.known.get((check.name, check.kernel)) if small else None

    @property
    def passed(self) -> bool:
        """Nothing that must agree disagrees."""
        checks = all(check.agrees or self.expected(check) for check in self.checks)
        statistics = self.comparison is None or self.comparison.agrees
        return checks and statistics and all(item["met"] is not False for item in self.criteria)


KNOWN_LIMIT = 1e-3
"""A difference that chaos explains is still a failure beyond this many diameters."""
