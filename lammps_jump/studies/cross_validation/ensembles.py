# SPDX-License-Identifier: GPL-2.0-or-later
"""A cross-validation and its ensembles: one scene from slightly different starts, each run reduced to quantities.

Two runs of a chaotic flow never agree disc by disc for long. What they can share is the statistics over starts that
differ by less than any measurement shows.
"""

from __future__ import annotations

import hashlib
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

from lammps_jump import Case, analysis
from lammps_jump.case.fields import Analysis
from lammps_jump.engines import native
from lammps_jump.engines.lammps.loader import wheel_version
from lammps_jump.engines.plugin.build import plugin_path
from lammps_jump.engines.result import Progress
from lammps_jump.errors import RunError
from lammps_jump.provenance import fingerprint
from lammps_jump.scene.scene import Scene
from lammps_jump.script.assemble import script_text
from lammps_jump.studies.measure import perturbed
from lammps_jump.studies.runs import execute
from lammps_jump.studies.store import Say, Store

from .quantities import Comparison, Quantities, compare, measure
from .statistics import FAMILY_ERROR
from .trajectories import DeterministicCheck

MEMBERS_FILE = "members.json"
"""Store of finished members, each under a hash of all that it depends on."""
LABELS = {"stock": "lammps_stock", "compiled": "lammps_compiled", "native": "native"}
"""Name of an ensemble in the store and in tables, by kernel."""


def _sources(package) -> bytes:
    """Return the source text of a folder of this package."""
    return b"".join(path.read_bytes() for path in sorted(Path(package.__path__[0]).glob("*.py")))


def member_key(scene: Scene, kernel: str, asked: Analysis) -> str:
    """Return the hash of all that a member depends on: the numbers of the scene, the code of engine and reduction."""
    if kernel == "native":
        code = _sources(native)
    else:
        # the folder of the plugin is named after the hash of its sources, compiler and flags
        plugin = plugin_path() if kernel == "compiled" else ""
        code = f"{wheel_version()} {kernel} {plugin}{script_text(scene, kernel=kernel, dump_format='binary')}".encode()
    found = hashlib.sha256()
    wanted = f"{asked.bin_width} {asked.window} {asked.front} {asked.jump} {fingerprint(scene)}"
    reduction = Path(__file__).with_name("quantities.py").read_bytes()
    for part in (wanted.encode(), _sources(analysis), reduction, code):
        found.update(part + b"\0")
    return found.hexdigest()[:12]


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
            store.piece(key, lambda s=start, n=said, p=line: self._member(s, kernel, n, p))
            if line is not None:
                line.finish()
            members.append(Quantities.from_json(store.pieces[key]))
            how = "was there" if known else f"{members[-1].run['seconds']:.1f} s"
            self.say(f"{said}: {how}, {members[-1].run['present']} discs in play at the end")
        self.members[name] = members
        return name

    def compare(self, one: str, two: str, label: str = "") -> Comparison:
        """Compare two ensembles; `label` is the name of the second in the result."""
        return compare((one, label or two), self.members[one], self.members[two], FAMILY_ERROR)

    def _member(self, start: Scene, kernel: str, name: str, line: Line | None) -> Quantities:
        """Run a scene in a temporary folder; returns what is compared of it, RunError where it did not complete."""
        with tempfile.TemporaryDirectory(prefix="running-", dir=self.folder) as work:
            result = execute(start, Path(work), kernel, dump_format="binary", progress=line)
            if result.status != "complete":
                raise RunError(f"{name}: {result.message}")
            return measure(Path(work), start, self.case.fields.analysis, result)
