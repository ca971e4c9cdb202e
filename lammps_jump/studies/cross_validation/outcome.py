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
from lammps_jump.studies.store import Say, Store

from .ensembles import LABELS, member_key, perturbed, run_member
from .quantities import Comparison, Quantities, compare
from .statistics import FAMILY_ERROR
from .trajectories import DeterministicCheck

MEMBERS_FILE = "members.json"
"""Store of finished members, each under a hash of all that it depends on."""


class Line(Protocol):
    """A line of progress."""

    def __call__(self, report: Progress) -> None:
        """Show one report."""

    def finish(self) -> None:
        """Leave the line."""


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
    members : dict of list of Quantities
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
    members: dict[str, list[Quantities]] = field(default_factory=dict)
    laws: dict[str, tuple[str, Comparison]] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """Name of the case."""
        return self.case.name

    def run(self, scene: Scene, kernel: str, label: str = "") -> str:
        """Run and measure an ensemble; returns its name."""
        name, asked = label or LABELS[kernel], self.case.fields.analysis
        store, members = Store(self.folder / MEMBERS_FILE), []
        for seed in self.seeds:
            start, said = perturbed(scene, seed), f"{name}, member {seed}"
            key = f"{said}, {member_key(start, kernel, asked)}"
            known = key in store.pieces
            line = self.line(scene.time(scene.steps)) if self.line else None
            store.piece(key, lambda s=start, n=said, p=line: run_member(s, kernel, n, asked, self.folder, p))
            if line is not None:
                line.finish()
            members.append(Quantities.from_json(store.pieces[key]))
            how = "was there" if known else f"{members[-1].run['seconds']:.1f} s"
            self.say(f"{said}: {how}, {members[-1].run['present']} discs in play at the end")
        self.members[name] = members
        return name

    def compare(self, one: str, two: str, label: str = "") -> Comparison:
        """Compare two ensembles; `label` is the name of the second in the result."""
        return compare(one, self.members[one], label or two, self.members[two], FAMILY_ERROR)
