# SPDX-License-Identifier: GPL-2.0-or-later
"""Cases with changed values, the kernels that run here, and one timed run on any of them."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

from lammps_jump.case import CaseFields, ReadCase, load_case
from lammps_jump.engines import Setting, choose, plugin, run
from lammps_jump.engines.native import run_native
from lammps_jump.engines.result import ProgressCallback, RunResult
from lammps_jump.scene.scene import Scene

from .timing import Stopwatch

KERNELS = ("stock", "compiled", "native")


@dataclass(frozen=True)
class StudyCase:
    """A case file, or the data of one, with changed values.

    Attributes
    ----------
    source : Path or mapping
    sets : tuple of str
        ``--set`` texts.
    """

    source: Path | Mapping[str, object]
    sets: tuple[str, ...] = ()

    def replace(self, changes: Mapping[str, object]) -> StudyCase:
        """Return the case with other values, given by dotted path."""
        return StudyCase(self.source, (*self.sets, *set_texts(changes)))

    @cached_property
    def loaded(self) -> ReadCase:
        """The validated case; raises CaseError where it cannot be used."""
        return load_case(self.source, self.sets)

    @property
    def fields(self) -> CaseFields:
        """Fields of the case."""
        return self.loaded.fields

    @property
    def name(self) -> str:
        """Name of the case."""
        return self.fields.name

    @property
    def hash(self) -> str:
        """Twelve hex digits that are equal for cases that give the same run."""
        return self.loaded.hash

    def scene(self) -> Scene:
        """Engine-neutral numbers of the case."""
        return self.loaded.scene()


def set_texts(changes: Mapping[str, object]) -> list[str]:
    """Return changed values as ``--set`` texts."""
    return [f"{path}={value if isinstance(value, str) else json.dumps(value)}" for path, value in changes.items()]


def kernel_changes(kernel: str) -> dict[str, str]:
    """Return the values of a case that select a kernel of `KERNELS`."""
    if kernel == "native":
        return {"engine.name": "native", "engine.kernel": "auto"}
    return {"engine.name": "lammps", "engine.kernel": kernel}


def default_integrator(kernel: str) -> str:
    """Return the integrator that a kernel uses unless the case names one."""
    return "leapfrog_extrapolated" if kernel == "native" else "velocity_verlet"


def choose_kernel(kernel: str, scene: Scene) -> tuple[str, list[str]]:
    """Return the LAMMPS kernel for a wish of 'auto', 'stock' or 'compiled', and notes.

    Raises
    ------
    SetupError
        LAMMPS is missing; or the compiled kernel is asked for, or needed by a smooth touch, and is missing.
    """
    setting, notes = choose("lammps", kernel, 1, scene)
    return setting.kernel, notes


def execute(
    scene: Scene,
    folder: Path,
    kernel: str,
    *,
    ranks: int = 1,
    dump_format: str = "text",
    script: str | None = None,
    progress: ProgressCallback | None = None,
) -> tuple[RunResult, Stopwatch]:
    """Run a scene in a folder.

    Parameters
    ----------
    scene : Scene
    folder : Path
    kernel : {'stock', 'compiled', 'native'}
    ranks : int
        MPI ranks of LAMMPS.
    dump_format : {'text', 'gz', 'binary'}
    script : str, optional
        Text that replaces the script of the stock kernel.
    progress : callable, optional

    Returns
    -------
    RunResult, Stopwatch
        The watch covers the engine alone, without compiling anything.
    """
    if kernel == "native":
        warm_up(scene)
        with Stopwatch() as watch:
            result = run_native(scene, folder, dump_format=dump_format, progress=progress)
        return result, watch
    library = plugin.plugin_path() if kernel == "compiled" else None
    setting = Setting(kernel=kernel, ranks=ranks, plugin=library, dump_format=dump_format, script=script)
    result = run(scene, folder, setting, progress=progress)
    watch = Stopwatch()
    watch.wall, watch.cpu = result.seconds, result.cpu_seconds
    return result, watch


_WARM: set[tuple[object, ...]] = set()


def warm_up(scene: Scene) -> None:
    """Compile the native loops for this kind of scene once, so that no timing holds a compilation."""
    c = scene.coefficients
    kind = (scene.integrator, scene.rotation, scene.friction_law, c.friction > 0, scene.touch, bool(scene.probes))
    if kind not in _WARM:
        run_native(replace(scene, steps=2, output_steps=2, probe_steps=1), None)
        _WARM.add(kind)
