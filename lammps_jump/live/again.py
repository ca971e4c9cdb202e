# SPDX-License-Identifier: GPL-2.0-or-later
"""Data by which a page computes a finished run again and holds it against what was stored: its start, and hashes.

Ten frames of the dump are compared to the digits that it has, the end to the last bit. Only the native engine repeats
its runs on every system; LAMMPS sums in another order.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from lammps_jump.analysis.report.page import Player
from lammps_jump.case import ReadCase
from lammps_jump.dump.find import read_dump, read_forces
from lammps_jump.dump.frame import ten_indices
from lammps_jump.dump.side_files.ended import read_ended
from lammps_jump.engines.native import NativeSimulation
from lammps_jump.engines.native.image import image_of
from lammps_jump.files import END_FILE
from lammps_jump.runs.results import player_of
from lammps_jump.runs.summary import read_summary

from .words import WORD

DIGITS = {"text": 10, "gz": 10, "binary": 17}
"""Significant digits of a number in a dump."""
OF_THE_END = ("x", "y", "half_vx", "half_vy")
"""Numbers of a disc at the end, in the order of their hash."""


@dataclass(frozen=True)
class RunAgain:
    """A run that can be computed again.

    Attributes
    ----------
    image : bytes
        The scene at its start.
    head : dict
        ``checks``: step and hash of each frame; ``end``: hash of the end; ``digits`` of a number of a frame.
    """

    image: bytes
    head: dict[str, Any]


@dataclass(frozen=True)
class Recorded:
    """A finished run as a page shows it beside a flow that goes on from it.

    Attributes
    ----------
    player : Player
        Its frames.
    forces : dict
        Of each wall whose force was recorded: times, s, and force along x, N/m.
    """

    player: Player
    forces: dict[str, tuple[np.ndarray, np.ndarray]]


def recorded_run(folder: Path, player: Player | None = None) -> Recorded | None:
    """A run folder as it was recorded; None where no frame holds a disc. `player` is its own, where it is made."""
    player = player or player_of(ReadCase.load(folder), folder)
    if player is None:
        return None
    path = folder / "forces.csv"
    felt = read_forces(path) if path.is_file() else {}
    return Recorded(player, {name: (one.time, one.fx) for name, one in felt.items()})


def run_again(folder: Path) -> RunAgain | str:
    """A run folder as a page computes it again, or the reason why it does not.

    Raises
    ------
    JumpError
        Files of the run that cannot be read.
    """
    summary, case = read_summary(folder), ReadCase.load(folder)
    status = summary.get("status", "it has no summary")
    if status != "complete":
        return f"The run is not complete ({status}), so that there is no end to hold it against."
    if case.fields.engine.name != "native":
        return (
            "The run is one of LAMMPS, which sums in another order: the native engine follows it to about 1e-9 "
            "diameters at first, and drifts apart where contacts amplify that. Runs of the native engine alone are "
            "computed again here."
        )
    scene = case.scene()
    image = image_of(NativeSimulation(scene, ledger=False), scene.steps, WORD)
    digits = DIGITS[case.fields.run.dump_format]
    frames = list(read_dump(folder))
    checks = []
    for frame in (frames[index] for index in ten_indices(len(frames))):
        order = np.argsort(frame.ids)
        checks.append([frame.step, _hash(frame.ids[order], *(one[order] for one in (frame.x, frame.y)))])
    discs = read_ended(folder / END_FILE).discs
    end = _hash(discs["id"], *(discs[name] for name in OF_THE_END))
    fixed = (scene.fixed.first, scene.fixed.last) if scene.fixed else None
    head = {"checks": checks, "end": end, "digits": digits, "steps": scene.steps, "fixed": fixed}
    return RunAgain(image, {**head, "timeStep": scene.time_step})


def _hash(*columns: np.ndarray) -> str:
    """SHA-256 of columns as float64, little-endian, one after the other."""
    return hashlib.sha256(b"".join((column.astype("<f8") + 0.0).tobytes() for column in columns)).hexdigest()
