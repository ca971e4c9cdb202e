# SPDX-License-Identifier: GPL-2.0-or-later
"""Scenes on any kernel: the kernels by name, and one run of a scene without a case."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable
from math import inf
from pathlib import Path
from statistics import median

from lammps_jump.dump import Frame, read_dump
from lammps_jump.engines import NATIVE_KERNELS, RunResult, Setting, plugin, run
from lammps_jump.engines.native import run_native
from lammps_jump.errors import RunError, RunInterrupted
from lammps_jump.scene import Scene

KERNELS = {
    **{kernel: {"engine.name": "lammps", "engine.kernel": kernel} for kernel in ("stock", "compiled")},
    **{name: {"engine.name": name, "engine.kernel": "auto"} for name in NATIVE_KERNELS},
}
"""Values of a case that select a kernel, by its name."""


def execute(
    scene: Scene, folder: Path, kernel: str, *, dump_format: str = "text", script: str | None = None
) -> RunResult:
    """Run a scene in a folder.

    Parameters
    ----------
    scene : Scene
    folder : Path
    kernel : {'stock', 'compiled', 'native', 'twin'}
    dump_format : {'text', 'gz', 'binary'}
    script : str, optional
        Text that replaces the script of the stock kernel.

    Returns
    -------
    RunResult
        Complete or failed. Its times cover the engine alone, without compiling anything.

    Raises
    ------
    RunInterrupted
        The user ended the run.
    """
    if kernel in NATIVE_KERNELS:
        setting = Setting(kernel, NATIVE_KERNELS[kernel], dump_format=dump_format, checkpoint_interval=inf)
        result = run_native(scene, folder, setting)
    else:
        library = plugin.plugin_path() if kernel == "compiled" else None
        setting = Setting(kernel=kernel, plugin=library, dump_format=dump_format, script=script)
        result = run(scene, folder, setting)
    return not_interrupted(result)


def not_interrupted(result: RunResult) -> RunResult:
    """The result of a run that the user let go to its end; that of another is not stored.

    Raises
    ------
    RunInterrupted
        The user ended the run, and so the study.
    """
    if result.status == "interrupted":
        raise RunInterrupted("the study was ended; what it had is kept, and the same command continues from there")
    return result


def run_frames(
    scene: Scene, kernel: str, *, dump_format: str = "text", script: str | None = None, check: bool = True
) -> tuple[RunResult, list[Frame]]:
    """Run a scene in a temporary folder, as `execute`; returns the frames too, discs by id.

    Raises
    ------
    RunError
        A run that is not complete; without `check` it has no frames.
    """
    with tempfile.TemporaryDirectory() as folder:
        result = execute(scene, Path(folder), kernel, dump_format=dump_format, script=script)
        if check and result.status != "complete":
            raise RunError(f"{kernel}, {scene.name}: {result.message}")
        frames: Iterable[Frame] = read_dump(Path(folder)) if result.status == "complete" else ()
        return result, [frame.sorted() for frame in frames]


def middle(values: Iterable[float | None]) -> float | None:
    """Median of the values that are not None; None where there are none."""
    known = [value for value in values if value is not None]
    return float(median(known)) if known else None
