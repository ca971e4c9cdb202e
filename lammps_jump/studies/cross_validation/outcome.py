# SPDX-License-Identifier: GPL-2.0-or-later
"""What a cross-validation is about and what it has found so far."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

from lammps_jump import Case
from lammps_jump.engines.result import Progress
from lammps_jump.scene.scene import Scene

from .ensembles import Binning, Ensemble, Member, run_member
from .quantities import Comparison, Quantities, Wanted, compare, measure
from .statistics import FAMILY_ERROR
from .trajectories import DeterministicCheck

Say = Callable[[str], None]


class Line(Protocol):
    """A line of progress."""

    def __call__(self, report: Progress) -> None:
        """Show one report."""

    def finish(self) -> None:
        """Leave the line."""


@dataclass(frozen=True)
class Criterion:
    """A limit set beforehand; `met` is None where it is for information only."""

    name: str
    limit: float
    value: float
    met: bool | None


@dataclass(frozen=True)
class Study:
    """A cross-validation; its containers are filled part by part.

    Attributes
    ----------
    case : Case
        With the law and integrator that both engines have.
    scene : Scene
    kernel : {'stock', 'compiled'}
        LAMMPS kernel of the ensembles.
    folder : Path
    seeds : tuple of int
        Of the members of each ensemble.
    notes : list of str
    say : callable
    line : callable or None
        Makes the progress line of a run from its end time, s; None for none.
    checks, divergence
        Disc by disc.
    members, quantities : dict of list
        By ensemble.
    laws : dict of str to (text, Comparison)
    """

    case: Case
    scene: Scene
    kernel: str
    folder: Path
    seeds: tuple[int, ...]
    notes: list[str]
    say: Say
    line: Callable[[float], Line] | None
    checks: list[DeterministicCheck] = field(default_factory=list)
    members: dict[str, list[Member]] = field(default_factory=dict)
    quantities: dict[str, list[Quantities]] = field(default_factory=dict)
    laws: dict[str, tuple[str, Comparison]] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """Name of the case."""
        return self.case.name

    @property
    def wanted(self) -> Wanted:
        """Which analyses the case asks for."""
        asked, c = self.case.fields.analysis, self.scene.coefficients
        return Wanted(asked.front, asked.jump, c.restitution == 1.0 and not c.friction and not self.scene.inlets)

    def run(self, scene: Scene, kernel: str, label: str = "") -> str:
        """Run and measure an ensemble; returns its name."""
        asked = self.case.fields.analysis
        binning = Binning(asked.bin_width, asked.window)
        ensemble = Ensemble(scene, kernel, self.folder / "members", binning, label)
        members: list[Member] = []
        line: Line | None = None
        for seed in self.seeds:
            if line is not None:
                line.finish()
            line = self.line(scene.time(scene.steps)) if self.line else None
            members.append(run_member(ensemble, seed, line))
            how = f"{members[-1].result.seconds:.1f} s" if members[-1].fresh else "was there"
            present = members[-1].result.present
            self.say(f"{ensemble.name}, member {seed}: {how}, {present} discs in play at the end")
        self.members[ensemble.name] = members
        self.quantities[ensemble.name] = [measure(member, scene, self.wanted, binning) for member in members]
        return ensemble.name

    def compare(self, one: str, two: str, label: str = "") -> Comparison:
        """Compare two ensembles; `label` is the name of the second in the result."""
        return compare(one, self.quantities[one], label or two, self.quantities[two], FAMILY_ERROR)
