# SPDX-License-Identifier: GPL-2.0-or-later
"""Setting of a run: the engine and its options, and the job that goes to the engine's process."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from lammps_jump.scene.scene import Scene

from .checkpoint import Checkpoint


@dataclass(frozen=True)
class Setting:
    """Engine of a run and its options.

    Attributes
    ----------
    engine : {'lammps', 'native', 'twin'}
    kernel : {'stock', 'compiled', 'core', 'python'}
        The first two are of LAMMPS, the others of the native engine and of its twin.
    ranks : int
        MPI ranks, LAMMPS only.
    threads : str
        Threads of the compiled kernel and of the native engine: a number, or ``auto:MOST``, by which steps show how
        many are the quickest.
    plugin : Path, optional
        The plugin's shared object, for the compiled kernel.
    dump_format : {'text', 'gz', 'binary'}
    header : tuple of str
        Comment lines for the top of the LAMMPS script.
    script : str, optional
        Text of the LAMMPS script in place of the one that is made of the scene.
    stop_at : int, optional
        End the run as an interruption does at this step. LAMMPS goes on to the end of a window of the probes, and by at
        least one step.
    checkpoint_interval : float
        Wall time between checkpoints, s.
    ledger : bool
        Native engine: keep the energy ledger, a quarter of the stepping time.
    scripts : bool
        Native engine: also write the scripts of LAMMPS, in whose place it runs.
    cell_size : float, optional
        Native engine: the thesis' own contact search in square cells of this width (m), in place of neighbour lists.
    """

    engine: str = "lammps"
    kernel: str = "stock"
    ranks: int = 1
    threads: str = "1"
    plugin: Path | None = None
    dump_format: str = "text"
    header: tuple[str, ...] = ()
    script: str | None = None
    stop_at: int | None = None
    checkpoint_interval: float = 60.0
    ledger: bool = True
    scripts: bool = False
    cell_size: float | None = None


@dataclass(frozen=True)
class Job:
    """A run as the engine's process gets it.

    Attributes
    ----------
    scene : Scene
    folder : Path
        Of the run.
    setting : Setting
    home : Path
        The working directory, to which `folder` may be relative.
    resume : Checkpoint, optional
        What it goes on from.
    script : str
        Text of LAMMPS' script, which can run programs, where others may change its file; else it is read there.
    """

    scene: Scene
    folder: Path
    setting: Setting
    home: Path
    resume: Checkpoint | None = None
    script: str = ""
