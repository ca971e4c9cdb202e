# SPDX-License-Identifier: GPL-2.0-or-later
"""The rounds of a calibration: Sobol points over the ranges, points where the posterior is, then the best.

A round is written before its runs are made, so that the same rounds come again after an interruption.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from math import inf
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import BaseModel, FiniteFloat

from lammps_jump.errors import CaseError, DumpError, JumpError
from lammps_jump.files import plain, read_json, write_json, write_text
from lammps_jump.foreign import foreign
from lammps_jump.identity import short_hash
from lammps_jump.runs.summary import read_summary
from lammps_jump.sweeps import Pool, Sweep, held_study, prepare
from lammps_jump.sweeps.members import Member, Start, failure_message, plan, run_members

from .answer import brief, short, unmet
from .besides import NearestEffects, look_besides
from .model import Model, model_of
from .posterior import Posterior, sample, sobol
from .study import SPARE, Calibration

POINTS, ROUNDS_FILE = "points", "rounds.json"
OVER, LIKELY, CHECK = "ranges", "posterior", "best"
"""Kinds of the points of a round: over the ranges, where the posterior is, the best."""
EACH = 8
"""Points over the ranges for each varied number, where the budget has room."""
SHARE = 0.6
"""Most of the budget that they take."""
SHRINK = 0.9
"""A round that leaves every 95 % range wider than this part of the one before is the last."""


NEAR = 1e-6
"""Part of a range by which a point may lie outside of it: points are written with six digits of it."""


class StoredRound(BaseModel, strict=True, extra="forbid"):
    """A round, as ``rounds.json`` has it."""

    of: Literal["ranges", "posterior", "best"]
    points: list[list[FiniteFloat]]


class StoredRounds(BaseModel, strict=True, extra="forbid"):
    """Content of ``rounds.json``."""

    vary: dict[str, list[FiniteFloat]]
    seed: int
    asked: str
    rounds: list[StoredRound]


def design_size(varied: int, most: int, least: int) -> int:
    """Points over the ranges; one of those that the budget allows is kept for the best."""
    return max(least, min(EACH * varied, int(SHARE * most)))


def design(count: int, varied: int, seed: int, *, after: int = 0) -> np.ndarray:
    """Sobol points in the unit cube, shape (count, varied); those from number `after` on."""
    return sobol(after + count, varied, seed)[after:]


def round_size(varied: int, points: int, most: int) -> int:
    """Points of a round: a quarter of the first points; 0 where the budget has no room but for the best."""
    return max(0, min(max(2, EACH * varied // 4), most - 1 - points))


def where_likely(posterior: Posterior, there: np.ndarray, count: int) -> np.ndarray:
    """Places drawn from the posterior, each as far as can be from all others, shape (count, varied).

    Distances are taken in standard deviations of the posterior along each varied number.

    Parameters
    ----------
    posterior : Posterior
    there : ndarray, shape (points, varied)
        Places that have runs.
    count : int
    """
    drawn, sd = posterior.drawn(), np.sqrt(np.diag(posterior.covariance)) + 1e-9
    taken = there
    for _ in range(count):
        apart = np.min(np.sum(((drawn[:, None] - taken[None]) / sd) ** 2, axis=2), axis=1)
        taken = np.vstack([taken, drawn[int(np.argmax(apart))]])
    return taken[len(there) :]


def has_settled(before: list[tuple[float, float]], now: list[tuple[float, float]]) -> bool:
    """Tells whether the 95 % range of every varied number is nearly as wide as a round before."""
    return all(high - low > SHRINK * (top - bottom) for (low, high), (bottom, top) in zip(now, before, strict=True))


@dataclass(frozen=True)
class SearchProgress:
    """Progress of a calibration.

    Attributes
    ----------
    done, failed, budget : int
        Runs.
    share : float
        Of the budget.
    disc_steps : float
        Done so far, in this process.
    best : str
        The best values so far, with their 95 % ranges once there are some.
    """

    done: int
    failed: int
    budget: int
    share: float
    disc_steps: float
    best: str


@dataclass
class PointResults:
    """Results of the runs of some points.

    Attributes
    ----------
    values : dict of str to ndarray, shape (points, starts, k)
        Of each target, NaN where a run has none.
    failures : list of dict
        Runs that are out: ``values``, ``seed``, ``message``.
    summaries : dict of int to list of mapping
        Summaries of the runs of each point that can be used.
    folders : dict of int to list of Path
        Their folders.
    """

    values: dict[str, np.ndarray]
    failures: list[dict[str, Any]] = field(default_factory=list)
    summaries: dict[int, list[Mapping[str, Any]]] = field(default_factory=dict)
    folders: dict[int, list[Path]] = field(default_factory=dict)


class Fit:
    """The model of some points and its posterior; `good` are the numbers of the points that can be used.

    Parameters
    ----------
    study : Calibration
    points : ndarray, shape (points, varied)
    observed : Observed
        Of these points, and perhaps of further ones after them.
    """

    def __init__(self, study: Calibration, points: np.ndarray, observed: PointResults):
        self.study = study
        self.good = [number for number in range(len(points)) if observed.summaries.get(number)]
        self.needed = len(study.vary) + SPARE
        self.model: Model | None = None
        self.posterior: Posterior | None = None
        if len(self.good) >= self.needed:
            values = {name: array[self.good] for name, array in observed.values.items()}
            self.model = model_of(study.unit(points[self.good]), study.targets, values)
            self.posterior = sample(self.model.log_likelihood, len(study.vary))

    @property
    def nearest(self) -> int:
        """Index in `good` of the nearest to the best values, in standard deviations of the posterior."""
        assert self.model is not None and self.posterior is not None
        sd = np.sqrt(np.diag(self.posterior.covariance))
        return int(np.argmin(np.sum(((self.model.places - self.posterior.best) / sd) ** 2, axis=1)))

    @property
    def unmet(self) -> bool:
        """Tells whether no place of the ranges meets the measurements."""
        return self.model is not None and self.posterior is not None and bool(unmet(self.model, self.posterior))

    @property
    def ranges(self) -> list[tuple[float, float]]:
        """95 % ranges in the unit cube; none where there is no posterior."""
        posterior = self.posterior
        return [posterior.range_of(k) for k in range(len(posterior.best))] if posterior is not None else []

    def best_in_words(self) -> str:
        """The best values so far and their ranges; empty without a posterior."""
        posterior, study = self.posterior, self.study
        if posterior is None:
            return ""
        numbers = np.array([[best, low, high] for best, (low, high) in zip(posterior.best, self.ranges, strict=True)]).T
        best, low, high = (study.bounds[:, 0] + row * np.ptp(study.bounds, axis=1) for row in numbers)
        return ", ".join(
            f"{short(path)} {brief(best[k])} ({brief(low[k])} to {brief(high[k])})"
            for k, path in enumerate(study.paths)
        )


class Search:
    """The rounds of a calibration, seen through its folder.

    Parameters
    ----------
    study : Calibration
    folder : Path
    retry : bool
        Runs that failed are made again.
    progress : callable
        Called with a `SearchProgress`.
    """

    def __init__(self, study: Calibration, folder: Path, retry: bool, progress: Callable[[SearchProgress], None]):
        self.study, self.folder, self.retry, self.progress = study, folder, retry, progress
        self.now = SearchProgress(0, 0, study.budget, 0.0, 0.0, "")
        self.rounds: list[dict[str, Any]] = self._stored()
        self.refused: dict[int, str] = {}
        self._least, self._fits = inf, dict[int, Fit]()

    @property
    def points(self) -> np.ndarray:
        """All points so far, shape (points, varied)."""
        listed = [point for one in self.rounds for point in one["points"]]
        return np.array(listed, float).reshape(-1, len(self.study.vary))

    @property
    def _signature(self) -> str:
        request = {"targets": [one.as_field for one in self.study.targets], "budget": self.study.budget}
        return short_hash(plain({**request, "members": self.study.members}))

    def _stored(self) -> list[dict[str, Any]]:
        """Rounds that the folder holds, of the same ranges and seed; with other targets or budget they go on.

        Raises
        ------
        CaseError
            They cannot be read, or hold points outside the ranges.
        """
        path = self.folder / ROUNDS_FILE
        if not os.path.lexists(path):
            return []
        with foreign(CaseError, f"{path}: holds no rounds of this calibration", "put the file back, or delete it"):
            rounds = StoredRounds.model_validate(read_json(path))
            if [rounds.vary, rounds.seed] != [plain(self.study.vary), self.study.seed]:
                return []
            points = np.array([point for one in rounds.rounds for point in one.points], float)
            unit = self.study.unit(points.reshape(-1, len(self.study.vary)))
            if points.shape[1:] not in ((), unit.shape[1:]) or not ((unit > -NEAR) & (unit < 1 + NEAR)).all():
                raise ValueError("a point lies outside the ranges")
        same = rounds.asked == self._signature
        return [{"of": one.of if same or one.of != CHECK else LIKELY, "points": one.points} for one in rounds.rounds]

    def write(self) -> None:
        """Write the study and its rounds so far, before their runs are made."""
        write_text(self.folder / "study.yaml", self.study.to_yaml())
        about = {"vary": self.study.vary, "seed": self.study.seed, "asked": self._signature}
        write_json(self.folder / ROUNDS_FILE, plain({**about, "rounds": self.rounds}))

    def fit(self, observed: PointResults, rounds: int | None = None) -> Fit:
        """The fit to the points of the first rounds; default all."""
        count = sum(len(one["points"]) for one in self.rounds[:rounds])
        if count not in self._fits:
            self._fits[count] = Fit(self.study, self.points[:count], observed)
            self._tell(best=self._fits[count].best_in_words() or self.now.best)
        return self._fits[count]

    def begin(self) -> None:
        """Take the points over the ranges, where the folder holds no round yet."""
        study, varied = self.study, len(self.study.vary)
        if not self.rounds:
            places = design(design_size(varied, study.most_points, varied + SPARE), varied, study.seed)
            self.rounds.append({"of": OVER, "points": study.points(places).tolist()})
        self.write()

    def go_on(self, pool: Pool) -> PointResults:
        """Makes rounds until the answer settles or the budget is used; what their runs gave."""
        self.begin()
        observed = self.run(pool)
        while (next_round := self.next_round(observed)) is not None:
            self.rounds.append(next_round)
            self.write()
            observed = self.run(pool)
        return observed

    def look_besides(self, observed: PointResults, pool: Pool) -> NearestEffects | None:
        """Change other numbers of the case where no place meets the measurements; None where one does."""
        fit = self.fit(observed)
        if not fit.unmet:
            return None
        point = self.points[fit.good[fit.nearest]].tolist()
        used = sum(map(len, observed.folders.values())) + len(observed.failures)
        first = self.study.case.fields.run.seed + self.study.budget  # after the starts of all points
        values = dict(zip(self.study.paths, point, strict=True))
        besides = look_besides(self.study, values, self.folder, pool, used=used, first_seed=first)
        self._tell(done=self.now.done + besides.runs)
        return besides

    def next_round(self, observed: PointResults) -> dict[str, Any] | None:
        """The next round of points; None once the answer has settled or the budget is spent."""
        study, varied, there = self.study, len(self.study.vary), len(self.points)
        most = study.most_points
        if self.rounds[-1]["of"] == CHECK or there >= most:
            return None
        fit, size = self.fit(observed), round_size(varied, there, most)
        if fit.posterior is None:
            places = design(size, varied, study.seed, after=there)
            return {"of": OVER, "points": study.points(places).tolist()} if size else None
        settled = self._in_rounds() and (fit.unmet or has_settled(self.fit(observed, -1).ranges, fit.ranges))
        if size and not settled:  # where nothing meets the data, the runs that are left look besides
            places = where_likely(fit.posterior, study.unit(self.points), size)
            return {"of": LIKELY, "points": study.points(places).tolist()}
        return {"of": CHECK, "points": study.points(fit.posterior.best[None]).tolist()}

    def _in_rounds(self) -> bool:
        return self.rounds[-1]["of"] == LIKELY

    def sweep(self) -> Sweep:
        """The points that are not refused, as a sweep of the folder ``points``; the refused ones are listed."""
        points, study = self.points.tolist(), self.study
        for number in range(len(self.refused), len(points)):
            try:
                plan(study.case, [Start(0, dict(zip(study.paths, points[number], strict=True)), 1)], {})
                self.refused[number] = ""
            except JumpError as error:
                self.refused[number] = str(error)
        kept = [point for number, point in enumerate(points) if not self.refused[number]]
        if not kept:
            first = next(filter(None, self.refused.values()))
            raise CaseError(f"{self.folder}: every point of the ranges is refused; the first one: {first}")
        return Sweep(study.sweep(kept), self.folder / POINTS)

    def run(self, pool: Pool) -> PointResults:
        """Make the runs that are lacking, and collect all."""
        sweep = self.sweep()
        with held_study(sweep.folder):
            prepare(sweep)
            again = ("failed",) if self.retry else ()
            stages = [state.stage for state in sweep.states.values()]
            failed = 0 if self.retry else stages.count("failed")
            self.now = replace(self.now, done=stages.count("done"), failed=failed)
            steps: dict[str, tuple[float, int]] = {}
            by_key = {member.key: member for member in sweep.members}

            def heard(key: str, news: tuple[float, float, int]) -> None:
                before, now = steps.get(key, (news[1], 0))[0], news[1]
                steps[key] = now, news[2]
                self._tell(disc_steps=self.now.disc_steps + max(0.0, now - before) * news[2])

            def ended(key: str, state: Any) -> None:
                good = state.stage == "done"
                if good:
                    self._compare(by_key[key], sweep.folder)
                self._tell(done=self.now.done + good, failed=self.now.failed + (not good))

            members, states = sweep.members, sweep.states
            run_members(members, states, sweep.folder, pool, again=again, ended=ended, news=heard)
            self.retry = False
        return self._observed(sweep)

    def _tell(self, **changes: Any) -> None:
        now = replace(self.now, **changes)
        self.now = replace(now, share=min(1.0, (now.done + now.failed) / now.budget))
        self.progress(self.now)

    def _compare(self, member: Member, store: Path) -> None:
        """Keep the run that is nearest to the measurements, until there is a posterior."""
        if self._fits:
            return
        folder = member.folder(store)
        summary, total = read_summary(folder), 0.0
        for target in self.study.targets:
            off = target.of_run(folder, summary) - target.measured
            scale = np.where(target.error > 0, target.error, np.abs(target.measured).max() + 1e-300)
            total += float(np.mean((off / scale) ** 2))
        if total < self._least:
            self._least = total
            values = ", ".join(f"{short(path)} {brief(value)}" for path, value in self._values(member.point).items())
            self.now = replace(self.now, best=f"nearest run: {values}")

    def _values(self, place: int) -> dict[str, float]:
        """Values of a point that is not refused, by its place among those."""
        kept = [point for number, point in enumerate(self.points.tolist()) if not self.refused[number]]
        return dict(zip(self.study.paths, kept[place], strict=True))

    def _observed(self, sweep: Sweep) -> PointResults:
        """Results of the runs of all points."""
        kept = [number for number in range(len(self.points)) if not self.refused[number]]
        shape = len(self.points), self.study.members
        seen = PointResults({one.name: np.full((*shape, len(one.measured)), np.nan) for one in self.study.targets})
        values = [dict(zip(self.study.paths, point, strict=True)) for point in self.points.tolist()]
        for number, message in self.refused.items():
            if message:
                seen.failures.append({"point": number, "values": values[number], "seed": 0, "message": message})
        for place, member in enumerate(sweep.members):
            number, start = kept[member.point], place % self.study.members
            folder, state, lacking = member.folder(sweep.folder), sweep.states[member.key], ""
            if state.stage == "done":
                summary = read_summary(folder)
                try:
                    numbers = [target.of_run(folder, summary) for target in self.study.targets]
                    lacking = ", ".join(filter(None, (
                        target.lacking(one) for target, one in zip(self.study.targets, numbers, strict=True)
                    )))  # fmt: skip
                except DumpError as error:
                    lacking = str(error)
                if not lacking:
                    for target, one in zip(self.study.targets, numbers, strict=True):
                        seen.values[target.name][number, start] = one
                    seen.summaries.setdefault(number, []).append(summary)
                    seen.folders.setdefault(number, []).append(folder)
                    continue
            failure = {"point": number, "values": values[number], "seed": member.seed}
            seen.failures.append({**failure, "message": lacking or failure_message(state) or state.stage})
        return seen
