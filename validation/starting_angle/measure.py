# SPDX-License-Identifier: GPL-2.0-or-later
"""The slope at which a layer at rest begins to flow."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

from lammps_jump import Run, load_case

CASE = Path(__file__).parents[1] / "inclined_flow" / "layer.yaml"
FLOWS = 0.01
"""Mean velocity over sqrt(g d) above which a layer flows: that below which one of `inclined_flow` has stopped."""


def starts(seed: int, slopes: list[float], settle: float, each: float) -> dict:
    """The first slope at which a settled layer flows at the end, and the one before; both in degrees.

    Parameters
    ----------
    seed : int
    slopes : list of float
        The first settles the layer; then they are tried in turn, each with the discs as the one before left them, at
        rest and with springs of zero length.
    settle, each : float
        Time of the first and of each other, s.
    """
    changes = {"slope": slopes[0], "run.seed": seed, "run.duration": settle, "run.output_interval": each / 10}
    window = {"analysis.window": [0.5 * settle, settle], "analysis.figures": "none"}
    case = load_case(CASE, changes | window)
    speeds = []
    with tempfile.TemporaryDirectory() as room:
        for slope in slopes:
            run = case.run(Path(room) / f"{slope:g}")
            speeds.append(_speed(run))
            if speeds[-1] > FLOWS and slope > slopes[0]:
                break
            more = {"slope": slopes[min(len(speeds), len(slopes) - 1)], "run.duration": each}
            case = case.replace({**more, "analysis.window": [0.5 * each, each], "initial": [_discs(run)]})
    last = len(speeds) - 1
    flows = speeds[-1] > FLOWS and last > 0
    return {
        "flows": slopes[last] if flows else None,
        "rests": slopes[last - 1 if flows else last],
        "slopes": slopes[: last + 1],
        "speeds": speeds,
    }


def _speed(run: Run) -> float:
    """Mean velocity along the bed at the end over sqrt(g d)."""
    late = [float(np.mean(frame.column("vx"))) for frame in run.frames()][-3:]
    return float(np.mean(late)) / float(np.sqrt(run.case.fields.gravity * run.scene.diameter))


def _discs(run: Run) -> dict:
    """The discs of the last frame in the order of their ids, so that each keeps its size; without those of the bed."""
    frame = list(run.frames())[-1]
    ids = frame.column("id")
    free = np.argsort(ids)[: len(ids) - int(run.scene.fixed.holds(ids).sum())]
    low, high = run.scene.domain[0]
    x = low + (frame.column("x")[free] - low) % (high - low)
    return {"kind": "list", "positions": np.stack([x, frame.column("y")[free]], axis=1).tolist()}
