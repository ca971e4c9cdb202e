# SPDX-License-Identifier: GPL-2.0-or-later
"""Runs of a calibration in closed form: numbers with scatter over starts in place of flows, and a store of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from made_up import BOX

from lammps_jump.calibration import besides, page
from lammps_jump.calibration.calibrate import calibrate
from lammps_jump.calibration.search import PointResults, Search
from lammps_jump.errors import RunInterrupted
from lammps_jump.identity import short_hash
from lammps_jump.sweeps.members import MemberRun

CASE = {**BOX, "contact": {**BOX["contact"], "friction": 0.5}}
FRICTION, DENSITY, RESTITUTION = "contact.friction", "discs.density", "contact.restitution"
VARY = {FRICTION: [0.1, 0.9], DENSITY: [1000, 2000]}
Numbers = Callable[[Mapping[str, float]], Mapping[str, Any]]
"""Of the values of a point to the numbers and curves of its run."""


def angle_and_run_out(values: Mapping[str, float]) -> dict[str, float]:
    """A repose angle by the sum of two numbers, and a run-out by their difference: alone, each is a ridge."""
    x = (values.get(FRICTION, 0.5) - 0.1) / 0.8
    y = (values.get(DENSITY, 1500.0) - 1000) / 1000
    return {"heap.angle": 10 + 10 * (x + y), "heap.run_out": 3 - 2 * x + 2 * y, "heap.height": 1 + 0.1 * x}


class StandIn:
    """In place of `Search.run`: each start of a point is made once, and kept, as by a store.

    Parameters
    ----------
    numbers : callable
        Of the values of a point to numbers of its run, by key, and curves, each shape (k,); NaN where the run has none.
    scatter : mapping
        Standard deviation over starts, by key.
    stop_at : collection of int
        Counts of runs after which it is interrupted, once each.
    """

    def __init__(self, numbers: Numbers, scatter: Mapping[str, float], stop_at=()):
        self.numbers, self.scatter, self.stop_at = numbers, scatter, set(stop_at)
        self.made: dict[tuple[str, int], dict[str, np.ndarray]] = {}
        self.besides: list[Mapping[str, Any]] = []

    def run_of(self, values: Mapping[str, float], start: int) -> dict[str, np.ndarray]:
        """Numbers of a start, always the same for the same values."""
        key = short_hash(dict(values)), start
        if key not in self.made:
            if len(self.made) in self.stop_at:
                self.stop_at.remove(len(self.made))
                raise RunInterrupted("killed here")
            rng = np.random.default_rng(int(key[0], 16) + start)
            found = self.numbers(values)
            self.made[key] = {
                name: np.atleast_1d(one) + self.scatter.get(name, 0.0) * rng.normal(size=np.size(one))
                for name, one in found.items()
            }
        return self.made[key]

    def starts(self, case: Any, starts: Any, store: Path, pool: Any) -> list[MemberRun]:
        """In place of `run_starts`: the runs that change other numbers of the case."""
        found = []
        for start in starts:
            self.besides.append(start.changes)
            found.append(MemberRun(start, store, nested(self.run_of(start.changes, start.seed)), ""))
        return found

    def __call__(self, search: Search, pool: Any) -> PointResults:
        points = [dict(zip(search.study.paths, point, strict=True)) for point in search.points.tolist()]
        shape = len(points), search.study.members
        seen = PointResults({one.name: np.full((*shape, len(one.measured)), np.nan) for one in search.study.targets})
        search.refused = dict.fromkeys(range(len(points)), "")
        for number, values in enumerate(points):
            for start in range(search.study.members):
                made = self.run_of(values, start)
                if lacking := [one.name for one in search.study.targets if not np.isfinite(made[one.name]).all()]:
                    failure = {"point": number, "values": values, "seed": start, "message": f"no {lacking[0]}"}
                    seen.failures.append(failure)
                    continue
                for one in search.study.targets:
                    seen.values[one.name][number, start] = made[one.name]
                seen.summaries.setdefault(number, []).append(nested(made))
                seen.folders.setdefault(number, []).append(search.folder / "points" / "runs" / "made")
        return seen


def nested(made: Mapping[str, np.ndarray]) -> dict[str, Any]:
    """A summary of numbers by their keys."""
    summary: dict[str, Any] = {}
    for key, one in made.items():
        if len(one) == 1:
            summary.setdefault(key.split(".")[0], {})[key.split(".")[1]] = float(one[0])
    return summary


def calibrated(
    monkeypatch, out: Path, targets, *, numbers=angle_and_run_out, scatter=None, stop_at=(), pictures=False, **given
):
    """A calibration of stand-in runs; more of `given` is as of `calibrate`."""
    runs = StandIn(numbers, scatter if scatter is not None else {"heap.angle": 0.3, "heap.run_out": 0.05}, stop_at)
    monkeypatch.setattr(Search, "run", lambda search, pool: runs(search, pool))
    monkeypatch.setattr(besides, "run_starts", runs.starts)
    if not pictures:
        monkeypatch.setattr(page, "draw", lambda *_: {})
    given = {"vary": VARY, "budget": 40, "members": 2, **given}
    return calibrate(CASE, targets, out=out, **given)
