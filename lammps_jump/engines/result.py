# SPDX-License-Identifier: GPL-2.0-or-later
"""Result that an engine hands back when it stops, and how it reports on the way: the same for both engines."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from lammps_jump.quoting import typed

if TYPE_CHECKING:
    from lammps_jump.scene.scene import Scene

REPORT_SECONDS = 0.1
"""Time from one report of an engine to the next."""
MARK = "\x1e"
"""Begins the lines of a worker's output that are messages."""


@dataclass(frozen=True, slots=True)
class Progress:
    """One report of a run.

    Attributes
    ----------
    step, steps : int
    time : float
        s.
    discs : int
    doing : str
        What is done now that the engine has come to its end; empty while it runs.
    threads : int
        Of the engine, now; of the first rank.
    """

    step: int
    steps: int
    time: float
    discs: int
    doing: str = ""
    threads: int = 1


ProgressCallback = Callable[[Progress], None]


NATIVE_KERNELS = {"native": "core", "twin": "python"}
"""Kernels of the engines that have one each."""
KERNELS = ("stock", "compiled", *NATIVE_KERNELS.values())


@dataclass(frozen=True)
class RunResult:
    """Result of a run; the trajectory itself is in the dump.

    Attributes
    ----------
    engine, kernel : str
        'lammps', 'native' or 'twin'; 'stock', 'compiled', 'core' or 'python'.
    status : {'complete', 'interrupted', 'failed'}
    message : str
        Empty for a complete run, else one paragraph a person can act on.
    steps : int
        Steps done.
    disc_steps : float
        Sum over steps of the discs in play (trapezoid over reports where the engine cannot count exactly).
    inserted, present, removed, lost : int
        Disc balance, discs at the start counted as inserted.
    seconds : float
        Wall time of the stepping alone.
    versions : dict of str
    ledger : dict of float, or None
        Energy ledger in joules per metre of width where the engine keeps one.
    breakdown : dict of float
        Seconds by kind of work (pair, neighbour, modify, output …) where the engine tells.
    resumed : tuple of float
        Simulated times (s) at which the run went on after an interruption; all other numbers are of all parts.
    outside : bool
        It failed for a cause outside the run: it can go on from its checkpoint, without one it starts again.
    cpu_seconds : float
        Processor time of the stepping, s; of LAMMPS on several ranks, that of the first rank times their number.
    states : tuple of (int, str)
        Step and hash of the state (`fingerprint`) at ten frames, of the native engine.
    """

    engine: str
    kernel: str
    status: str
    message: str
    steps: int
    disc_steps: float
    inserted: int
    present: int
    removed: int
    lost: int
    seconds: float
    versions: dict[str, str] = field(default_factory=dict)
    ledger: Mapping[str, float | None] | None = None
    breakdown: dict[str, float | None] = field(default_factory=dict)
    resumed: tuple[float, ...] = ()
    cpu_seconds: float = 0.0
    outside: bool = False
    states: tuple[tuple[int, str], ...] = ()


def interruption(scene: Scene, step: int, folder: Path, *, again: float | None = None, reason: str = "") -> str:
    """Message to the user of a run that was ended before its end: when, what is kept, how to go on.

    Parameters
    ----------
    scene : Scene
    step : int
        Steps done.
    folder : Path or str
    again : float, optional
        Simulated time of the checkpoint, from which the run can go on.
    reason : str
        Why it cannot, where there is no checkpoint.
    """
    kept = (
        f"the run was ended at t = {scene.time(step):z.4g} s of {scene.time(scene.steps):z.4g} s; the frames up "
        f"to there are kept in {folder}: `{typed('analyze', folder)}` looks at them"
    )
    if again is not None:
        return (
            f"{kept}, `{typed('run', folder, '--resume')}` (or the same command with --resume) goes on from "
            f"t = {again:z.4g} s, with --force in its place it starts anew"
        )
    return f"{kept}, the same command with --force starts anew" + (f"; it cannot go on: {reason}" if reason else "")
