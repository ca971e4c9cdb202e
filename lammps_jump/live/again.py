# SPDX-License-Identifier: GPL-2.0-or-later
"""Data by which a page computes a finished run again and holds it against what was stored: its start, and hashes.

Ten frames of the dump are compared to the digits that it has; states at the same times and the end to the last bit.
Only the native engine repeats its runs on every system. LAMMPS sums in another order: of its runs the page tells how
far they part.
"""

from __future__ import annotations

import base64
import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from lammps_jump.analysis.report.page import Player
from lammps_jump.case import ReadCase
from lammps_jump.dump.ended import read_ended
from lammps_jump.dump.find import forces_in, read_dump
from lammps_jump.dump.frame import Frame, ten_indices
from lammps_jump.engines.native import NativeSimulation
from lammps_jump.engines.native.image import image_of
from lammps_jump.files import END_FILE
from lammps_jump.runs.results import player_of
from lammps_jump.runs.summary import read_summary

from .prepare import WORD

DIGITS = {"text": 10, "gz": 10, "binary": 17}
"""Significant digits of a number in a dump."""
OF_THE_END = ("x", "y", "half_vx", "half_vy")
"""Numbers of a disc at the end, in the order of their hash."""


MOST_COMPARED = 2_000
"""Discs of a frame of LAMMPS whose places are compared."""


@dataclass(frozen=True)
class RunAgain:
    """A run that can be computed again.

    Attributes
    ----------
    image : bytes
        The scene at its start.
    head : dict
        Of a run of the native engine ``checks``: step and hash of each frame, and of the state then, where the run kept
        one; ``end``: hash of the end; ``digits`` of a number of a frame. Of one of LAMMPS ``frames``: step, ids and
        places of discs.
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
    return Recorded(player, {name: (one.time, one.fx) for name, one in forces_in(folder).items()})


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
    scene = case.scene()
    image = image_of(NativeSimulation(scene, ledger=False), scene.steps, WORD)
    head = {"steps": scene.steps, "timeStep": scene.time_step}
    frames = list(read_dump(folder))
    chosen = [frames[index] for index in ten_indices(len(frames))]
    if summary["engine"] == "lammps":
        period = scene.domain[0][1] - scene.domain[0][0] if scene.periodic else None
        about = {"frames": [_places(frame) for frame in chosen], "diameter": scene.diameter, "period": period}
        return RunAgain(image, {**head, **about})
    digits = DIGITS[case.fields.run.dump_format]
    states = {step: text for step, text in summary.get("states", ())}
    checks = []
    for frame in chosen:
        order = np.argsort(frame.ids)
        places = _hash(frame.ids[order], *(one[order] for one in (frame.x, frame.y)))
        checks.append([frame.step, places, states.get(frame.step)])
    discs = read_ended(folder / END_FILE).discs
    end = _hash(discs["id"], *(discs[name] for name in OF_THE_END))
    fixed = (scene.fixed.first, scene.fixed.last) if scene.fixed else None
    return RunAgain(image, {**head, "checks": checks, "end": end, "digits": digits, "fixed": fixed})


def _places(frame: Frame) -> dict[str, Any]:
    """Step, ids and places of discs of a frame, every n-th of many, as base64 of int32 and float64."""
    order = np.argsort(frame.ids)[:: -(-frame.n // MOST_COMPARED) or 1]
    columns = (frame.ids.astype("<i4"), frame.x.astype("<f8"), frame.y.astype("<f8"))
    ids, x, y = (base64.b64encode(one[order].tobytes()).decode() for one in columns)
    return {"step": frame.step, "ids": ids, "x": x, "y": y}


def _hash(*columns: np.ndarray) -> str:
    """SHA-256 of columns as float64, little-endian, one after the other."""
    return hashlib.sha256(b"".join((column.astype("<f8") + 0.0).tobytes() for column in columns)).hexdigest()
