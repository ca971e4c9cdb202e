# SPDX-License-Identifier: GPL-2.0-or-later
"""A cross-validation and its ensembles: one case from slightly different starts, each run reduced to quantities.

Two runs of a chaotic flow never agree disc by disc for long. What they can share is the statistics over starts that
differ by less than any measurement shows.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from lammps_jump import Case
from lammps_jump.errors import RunError
from lammps_jump.scene.scene import Scene
from lammps_jump.studies.runs import kernel_changes
from lammps_jump.sweeps import Pool, Start, run_starts
from lammps_jump.sweeps.store import Say

from .quantities import Comparison, Quantities, compare, measure
from .statistics import FAMILY_ERROR
from .trajectories import DeterministicCheck

LABELS = {"stock": "lammps_stock", "compiled": "lammps_compiled", "native": "native"}
"""Name of an ensemble in tables, by kernel."""


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
        Keeps the runs of all members.
    pool : Pool
    seeds : tuple of int
        Of the members of each ensemble.
    notes : list of str
    say : callable
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
    pool: Pool
    seeds: tuple[int, ...]
    notes: list[str]
    say: Say
    checks: list[DeterministicCheck] = field(default_factory=list)
    members: dict[str, list[Quantities]] = field(default_factory=dict)
    laws: dict[str, tuple[str, Comparison]] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """Name of the case."""
        return self.case.name

    def run(self, case: Case, kernel: str, label: str = "") -> str:
        """Run and measure an ensemble of a case; returns its name.

        Raises
        ------
        RunError
            A member that did not complete.
        """
        name = label or LABELS[kernel]
        case = case.replace({**kernel_changes(kernel), "analysis.energy": True, "run.dump_format": "binary"})
        new: list[Start] = []
        starts = [Start(0, {}, seed) for seed in self.seeds]
        made = run_starts(case, starts, self.folder, self.pool, said=lambda one: new.append(one.start))
        for start, _, summary, message in made:
            if not summary:
                raise RunError(f"{name}, member {start.seed}: {message}")
            how = f"{summary['wall_seconds']['run']:.1f} s" if start in new else "was there"
            self.say(f"{name}, member {start.seed}: {how}, {summary['discs']['present']} discs in play at the end")
        self.members[name] = [measure(one.folder, one.summary, case.scene()) for one in made]
        return name

    def compare(self, one: str, two: str, label: str = "") -> Comparison:
        """Compare two ensembles; `label` is the name of the second in the result."""
        return compare((one, label or two), self.members[one], self.members[two], FAMILY_ERROR)
