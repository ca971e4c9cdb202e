# SPDX-License-Identifier: GPL-2.0-or-later
"""Members of an ensemble: one scene from slightly different starts, each run reduced to what is compared of it.

Two runs of a chaotic flow never agree disc by disc for long. What they can share is the statistics over starts that
differ by less than any measurement shows.
"""

from __future__ import annotations

import hashlib
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from lammps_jump import analysis
from lammps_jump.case.fields import Analysis
from lammps_jump.engines import native
from lammps_jump.engines.lammps.loader import wheel_version
from lammps_jump.engines.plugin.build import plugin_path
from lammps_jump.engines.result import ProgressCallback
from lammps_jump.errors import RunError
from lammps_jump.scene.scene import Scene
from lammps_jump.script.assemble import data_text, script_text
from lammps_jump.studies.runs import execute

from .quantities import Quantities, measure

JITTER = 1e-6
"""Start positions move by up to this many diameters, row speeds by up to this share of themselves."""
REDUCTION = 4
"""Counts up when what is kept of a run changes; older results are then made anew."""
LABELS = {"stock": "lammps_stock", "compiled": "lammps_compiled", "native": "native"}
"""Name of an ensemble in the store and in tables, by kernel."""


def perturbed(scene: Scene, seed: int, jitter: float = JITTER) -> Scene:
    """Return a copy of the scene with its start shifted by at most `jitter` diameters; seed 0 is the scene itself.

    Positions of discs at the start move by uniform random numbers in ± jitter d. The speed of every inlet row changes
    by a factor 1 ± jitter. Both engines get the same numbers.
    """
    if seed == 0:
        return scene
    rng = np.random.default_rng(seed)
    positions = scene.positions + rng.uniform(-jitter, jitter, scene.positions.shape) * scene.diameter
    positions.setflags(write=False)
    inlets = tuple(replace(row, vx=row.vx * (1.0 + rng.uniform(-jitter, jitter))) for row in scene.inlets)
    return replace(scene, positions=positions, inlets=inlets)


def _sources(package) -> bytes:
    """Return the source text of a folder of this package."""
    return b"".join(path.read_bytes() for path in sorted(Path(package.__path__[0]).glob("*.py")))


def member_key(scene: Scene, kernel: str, asked: Analysis) -> str:
    """Return the hash of all that a member depends on: the numbers of the scene, the code of engine and reduction."""
    # the script holds every number that LAMMPS sees; the native engine gets the same scene
    numbers = script_text(scene, kernel="compiled", dump_format="binary") + data_text(scene)
    numbers += f"{scene.integrator} {scene.friction_law} {scene.steps} {scene.output_steps}"
    if kernel == "native":
        code = _sources(native)
    else:
        # the folder of the plugin is named after the hash of its sources, compiler and flags
        plugin = plugin_path() if kernel == "compiled" else ""
        code = f"{wheel_version()} {kernel} {plugin}{script_text(scene, kernel=kernel, dump_format='binary')}".encode()
    found = hashlib.sha256()
    wanted = f"{REDUCTION} {asked.bin_width} {asked.window} {asked.front} {asked.jump}"
    for part in (wanted.encode(), _sources(analysis), numbers.encode(), code):
        found.update(part + b"\0")
    return found.hexdigest()[:12]


def run_member(
    start: Scene, kernel: str, name: str, asked: Analysis, folder: Path, line: ProgressCallback | None = None
) -> Quantities:
    """Run a scene in a temporary folder inside `folder`; returns what is compared of it.

    Parameters
    ----------
    start : Scene
        Of `perturbed`.
    kernel : {'stock', 'compiled', 'native'}
    name : str
        Of the member, for messages.
    asked : Analysis
        What the case asks of the analysis.
    folder : Path
    line : callable, optional
        Takes reports of progress.

    Raises
    ------
    RunError, RunInterrupted
        Where the run did not complete.
    """
    with tempfile.TemporaryDirectory(prefix="running-", dir=folder) as work:
        result = execute(start, Path(work), kernel, dump_format="binary", progress=line)
        if result.status != "complete":
            raise RunError(f"{name}: {result.message}")
        return measure(Path(work), start, asked, result)
