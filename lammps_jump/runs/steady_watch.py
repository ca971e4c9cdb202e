"""Ends a run whose flow has become steady: reads the frames as the engine writes them, asks the detector."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from lammps_jump.dump.tail import Tail
from lammps_jump.scene.scene import Scene

from .steady import SteadyDetector, flow_state

PASSAGES = 1.5
"""Length of the tested record in times that the inflow needs for the studied reach."""
FEWEST_FRAMES = 48
"""The detector wants sixteen batches of several frames each."""


def steady_window(scene: Scene, reach: tuple[float, float]) -> float | None:
    """Length of record for the test, s; None for a scene without inflow, whose flow does not become steady."""
    speeds = [row.vx for row in scene.inlets if row.vx]
    if not speeds:
        return None
    passage = (reach[1] - reach[0]) / abs(float(np.mean(speeds)))
    return max(PASSAGES * passage, FEWEST_FRAMES * scene.output_steps * scene.time_step)


def studied_reach(flow) -> tuple[float, float]:
    """The part of the studied range that has one and the same floor from its upstream end on (up to a sill), m."""
    low, high = flow.x_range
    x = np.linspace(low, high, 2001)[1:-1]
    bed = flow.bed_height(x)
    other = np.flatnonzero(~(np.abs(bed - bed[0]) < 1e-9))
    return (low, float(x[other[0]])) if other.size and np.isfinite(bed[0]) else (low, high)


class SteadyWatch:
    """A ``should_stop`` callback for the engines.

    Parameters
    ----------
    scene : Scene
    folder : Path
        Run folder; the dump must be text (columns id x y vx vy …).
    reach : (float, float)
        Studied part of the channel, m.

    Attributes
    ----------
    reason : str
        Empty until the flow is steady; then the sentence for the summary.
    """

    def __init__(self, scene: Scene, folder: Path, reach: tuple[float, float]):
        self.scene, self.reach = scene, reach
        self.tail = Tail(folder / "dump.lammpstrj")
        window = steady_window(scene, reach)
        self.detector = SteadyDetector(window) if window else None

    @property
    def reason(self) -> str:
        """Why the run may stop, empty while it may not."""
        return self.detector.reason if self.detector else ""

    def __call__(self) -> bool:
        """Take in the frames that are new; True once the flow is steady."""
        if self.detector is None:
            return False
        for frame in self.tail.new_frames():
            if frame.n:
                state = flow_state(frame.x, frame.vx, self.scene.mass, self.scene.density, self.reach)
                self.detector.feed(frame.time, *state)
        return self.detector.steady
