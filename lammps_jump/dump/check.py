# SPDX-License-Identifier: GPL-2.0-or-later
"""Check of the frames and the force record of a run against its schedule: none missing, moved or torn."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from lammps_jump.errors import DumpError
from lammps_jump.scene.scene import Scene

from .find import read_forces
from .formats import CUT_OFF, PASSED_OVER
from .frame import Frame

NEAR = 0.01
"""Part of a time step by which a time may differ from that of its step: it is printed with 15 digits."""


def damages(warnings: Iterable[str]) -> list[str]:
    """Warnings of the reader of dumps that speak of what no run writes: torn or repeated frames, comments."""
    return [text for text in warnings if CUT_OFF in text or PASSED_OVER in text]


class FrameCheck:
    """Compares every frame with the schedule of a scene, along with other collectors of one pass over the dump.

    Parameters
    ----------
    scene : Scene
    """

    sees = "all"

    def __init__(self, scene: Scene):
        self.scene = scene
        self.frames = self.last = 0
        self.first_trouble = ""

    def add(self, frame: Frame, time: float) -> None:
        """Take in the next frame."""
        if not self.first_trouble and (trouble := self._trouble(frame, time)):
            self.first_trouble = f"frame {self.frames + 1}: {trouble}"
        self.frames += 1
        self.last = frame.n

    def _trouble(self, frame: Frame, time: float) -> str:
        scene, step = self.scene, self.frames * self.scene.output_steps
        if frame.step != step:
            return f"step {frame.step} stands where step {step} belongs"
        if abs(time - scene.time(step)) > NEAR * scene.time_step:
            return f"time {time:.10g} s, but its step is at {scene.time(step):.10g} s"
        ids = frame.columns.get("id", np.empty(0))
        if ids.size != frame.n or (ids < 1).any() or (ids % 1 != 0).any():
            return "an id is no positive whole number"
        if _is_repeated(ids):
            return "an id stands there twice"
        for axis, values, (low, high) in zip("xy", (frame.x, frame.y), scene.domain, strict=True):
            outside = np.flatnonzero(~((values >= low - scene.largest) & (values <= high + scene.largest)))
            if outside.size:
                disc = outside[0]
                return f"disc {ids[disc]:.0f} is at {axis} = {values[disc]:.6g} m, outside the domain"
        return ""

    def result(self, steps: int, present: int) -> list[str]:
        """Faults of a run of so many steps and discs at its end, in words; empty where there is none."""
        troubles = [self.first_trouble] if self.first_trouble else []
        expected = steps // self.scene.output_steps + 1
        if self.frames != expected:
            troubles.insert(0, f"{self.frames} of {expected} frames")
        elif steps % self.scene.output_steps == 0 and self.last != present:
            troubles.append(f"{self.last} discs in the last frame, {present} at the end of the run")
        return troubles


def _is_repeated(ids: np.ndarray) -> bool:
    return bool((np.diff(ids) <= 0).any() and np.unique(ids).size != ids.size)


class IdCheck:
    """Refuses a foreign dump by whose ids no disc can be followed, along with other collectors of one pass over it.

    Parameters
    ----------
    path : Path
        Of the dump, for the message.
    """

    sees = "all"

    def __init__(self, path: Path):
        self.path = path

    def add(self, frame: Frame, time: float) -> None:
        """Takes in the next frame; DumpError where an id is negative, no whole number, or occurs twice."""
        ids = frame.columns.get("id", np.empty(0))
        wrong = (ids < 0) | (ids != np.floor(ids))
        if wrong.any():
            trouble = f"{ids[np.argmax(wrong)]:.10g} is no whole number from 0"
        elif _is_repeated(ids):
            once, number = np.unique(ids, return_counts=True)
            trouble = f"{once[np.argmax(number > 1)]:.0f} stands there twice"
        else:
            return
        raise DumpError(f"{self.path}: step {frame.step}: id {trouble}; each disc needs a number of its own there")

    def result(self) -> None:
        """Nothing is kept."""


def force_troubles(path: Path, scene: Scene, steps: int) -> list[str]:
    """Faults of the force record of a run of so many steps, in words: a row a window and probe or group."""
    if not scene.probes:
        return []
    try:
        force_histories = read_forces(path)
    except DumpError as error:
        return [str(error)]
    windows, names = steps // scene.probe_steps, {*scene.probes, *(name for name, _ in scene.groups)}
    wanted = np.array([scene.time(scene.probe_steps * number) for number in range(1, windows + 1)])
    troubles = []
    rows = sum(len(history.time) for history in force_histories.values())
    if rows != windows * len(names) or (rows and set(force_histories) != names):
        troubles.append(f"{rows} of {windows * len(names)} rows of forces")
    for name, history in force_histories.items():
        parts = (part for part in (history.fx, history.fy, history.moment, history.power) if part is not None)
        if not all(np.isfinite(part).all() for part in parts):
            troubles.append(f"a force on {name} is no number")
        elif len(history.time) == windows and (np.abs(history.time - wanted) > NEAR * scene.time_step).any():
            troubles.append(f"times of the forces on {name} are not those of the windows")
    return [f"{path.name}: {trouble}" for trouble in troubles]
