# SPDX-License-Identifier: GPL-2.0-or-later
"""Content of the folder of a study: ``points.json`` with the run folder of every member, and the results of members."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from math import nan
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, Self, get_args

from pydantic import BaseModel, Field, NonNegativeInt, ValidationError, model_validator

import lammps_jump.sweeps as sweeps
from lammps_jump.analysis.statistics import Mean
from lammps_jump.analysis.tables import MeasuredRow, rows_of
from lammps_jump.errors import CaseError
from lammps_jump.files import plain, read_json
from lammps_jump.quoting import echoed
from lammps_jump.runs.run import Run
from lammps_jump.runs.summary import read_summary

from .members import OVER, Member, MemberState, Stage, Start, failure_message, listed_as, plan, run_folders, state_of
from .study import MOST_MEMBERS, MOST_RUNS, Study

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

POINTS_FILE = "points.json"
MOST_UNLISTED = 5_000
"""Members that the status makes of their cases, milliseconds each, where ``points.json`` does not list them."""


class ListedMember(BaseModel, strict=True):
    """A member: number of its point, seed, name of its run folder."""

    point: NonNegativeInt
    seed: NonNegativeInt
    key: str


class Listed(BaseModel, strict=True):
    """Content of ``points.json``."""

    points: list[dict[str, Any]] = Field(max_length=MOST_RUNS)
    members: list[ListedMember] = Field(max_length=MOST_RUNS)

    @model_validator(mode="after")
    def _counts(self) -> Listed:
        counts = Counter(item.point for item in self.members)
        if counts and (last := max(counts)) >= len(self.points):
            raise ValueError(f"a member belongs to point {last}; the points are 0 to {len(self.points) - 1}")
        if (most := max(counts.values(), default=0)) > MOST_MEMBERS:
            raise ValueError(f"a point has {most} members; at most {MOST_MEMBERS} are allowed")
        return self


def read_points(folder: Path) -> Listed | None:
    """The ``points.json`` of a study; None if the file is missing.

    Raises
    ------
    CaseError
        The file cannot be read, or holds something else: the place, what is wrong and what to do.
    """
    path = folder / POINTS_FILE
    try:
        return Listed.model_validate(read_json(path))
    except (FileNotFoundError, NotADirectoryError):
        return None
    except ValidationError as error:
        first = error.errors(include_url=False, include_context=False)[0]
        place = ".".join(map(str, first["loc"]))
        value = "" if first["type"] in ("value_error", "too_long") else f", got {echoed(first['input'])}"
        said = f"{f'{place}: ' if place else ''}{first['msg'].removeprefix('Value error, ')}{value}"
    except (OSError, ValueError) as error:
        said = str(getattr(error, "strerror", None) or error)
    raise CaseError(f"{path}: {said}; delete the file, and the same command writes it again")


class Failure(NamedTuple):
    """A member that is not in the table, and why."""

    point: int
    seed: int
    folder: Path
    message: str


class StudyResults:
    """Members in the folder of a study, and the statistics over them.

    Parameters
    ----------
    study : Study
    folder : Path
    starts : sequence of Start, optional
        Default those that the folder lists, else those of the study.
    """

    def __init__(self, study: Study, folder: Path, starts: Sequence[Start] | None = None):
        self.study, self.folder = study, folder
        self.starts = list(starts if starts is not None else _starts(study, folder))

    @cached_property
    def members(self) -> list[Member]:
        """All members, point by point."""
        return plan(self.study.case, self.starts, self.study.analysis)

    @cached_property
    def states(self) -> dict[str, MemberState]:
        """State of each member in the folder, by its key."""
        return {member.key: state_of(member, self.folder) for member in self.members}

    def left(self, retry: bool) -> list[int]:
        """Numbers of the members that are to be run; with `retry` those too that failed."""
        over = ("done",) if retry else OVER
        return [number for number, member in enumerate(self.members) if self.states[member.key].stage not in over]

    @property
    def runs(self) -> list[Run]:
        """The runs that are done."""
        return [Run(m.folder(self.folder)) for m in self.members if self.states[m.key].stage == "done"]

    @property
    def failed(self) -> list[Failure]:
        """The members that are not in the table although they were run."""
        states = ((member, self.states[member.key]) for member in self.members)
        return [Failure(m.point, m.seed, m.folder(self.folder), failure_message(s)) for m, s in states if s.message]

    @cached_property
    def values(self) -> pd.DataFrame:
        """Collected values of every run that is done: a row each, with ``point`` and ``seed``."""
        import pandas as pd  # 0.3 s

        done = (member for member in self.members if self.states[member.key].stage == "done")
        rows = [
            {"point": member.point, "seed": member.seed, "key": member.key}
            | sweeps.table.row_of(read_summary(member.folder(self.folder)), self.study)
            for member in done
        ]
        columns = [name for item in self.study.collect for name in (item.path, f"{item.path}_error")]
        return pd.DataFrame(rows, columns=None if rows else ["point", "seed", "key", *columns])

    @cached_property
    def table(self) -> xr.Dataset:
        """Statistics over members (`table.STATISTICS`), with the axes as dimensions."""
        return sweeps.table.table_of(self.study, self.values)

    @cached_property
    def summaries(self) -> list[Mapping[str, Any]]:
        """Summaries of the runs that are done."""
        return [run.summary for run in self.runs]

    @cached_property
    def rows(self) -> list[MeasuredRow]:
        """The numbers that readers look for first: means over all runs, with the interval over starts."""
        return rows_of(self.summaries, self.mean)

    def mean(self, values: Sequence[float]) -> Mean:
        """Mean of numbers and half its interval."""
        statistics_of = sweeps.table.statistics(values, [nan] * len(values), self.study.fields.confidence)
        return Mean(statistics_of["mean"], statistics_of["high"] - statistics_of["mean"])

    def needed(self) -> list[int]:
        """Members that each point would need for the intervals of ``until``; 0 if their scatter is not known."""
        needed = [
            [sweeps.table.members_needed(statistic, share) or 0 for statistic in sweeps.table.records(self.table, path)]
            for path, share in self.study.fields.until.items()
        ]
        return [max(counts) for counts in zip([0] * len(self.study.points), *needed, strict=True)]

    def wider(self) -> Self | None:
        """The study with more members at points whose intervals are wider than ``until`` allows; None if no point is.

        A point at most doubles its members, and has ``table.FIRST`` at least.
        """
        more: list[Start] = []
        for point, needed in enumerate(self.needed()):
            seeds = [start.seed for start in self.starts if start.point == point]
            count = min(needed, max(sweeps.table.FIRST, 2 * len(seeds)), self.study.fields.most_members) - len(seeds)
            more += [Start(point, self.study.points[point], max(seeds) + 1 + k) for k in range(count)]
        starts = sorted([*self.starts, *more], key=lambda start: (start.point, start.seed))
        return type(self)(self.study, self.folder, starts) if more else None

    @property
    def summary(self) -> dict[str, Any]:
        """The statistics of each point as plain data: what ``summary.json`` of the folder holds."""
        counts, verdicts = (self.table[name].values.ravel().tolist() for name in ("members", "verdicts"))
        points: list[dict[str, Any]] = [
            {"values": values, "members": count, "verdicts": said, "numbers": {}}
            for values, count, said in zip(self.study.points, counts, verdicts, strict=True)
        ]
        for item in self.study.collect:
            for point, statistic in zip(points, sweeps.table.records(self.table, item.path), strict=True):
                point["numbers"][item.path] = {**statistic, "unit": item.unit}
        about = {"name": self.study.case.name, "description": self.study.case.fields.description}
        failed = [{"point": f.point, "seed": f.seed, "message": f.message} for f in self.failed]
        return {**about, "confidence": self.study.fields.confidence, "points": points, "failed": failed}

    def status(self) -> str:
        """One line: how many runs are done, failed, at work, and still to come."""
        begun = self._begun()
        counts = Counter(state_of(member, self.folder).stage for member in begun or ())
        counts["waiting"] += len(self.starts) - len(begun or ())
        if begun is None:
            counts = Counter(self.states[member.key].stage for member in self.members)
        said = ", ".join(f"{counts[stage]} {stage}" for stage in get_args(Stage) if counts[stage])
        points = f" at {len(self.study.points)} points" if self.study.axes else ""
        return f"{len(self.starts)} runs{points}: {said}"

    def _begun(self) -> list[Member] | None:
        """The members that have a run folder, from ``points.json``; None if all were read or are not listed.

        A member takes milliseconds to be made of its case: of a large study most are not needed.
        """
        if "states" in self.__dict__:
            return None
        there = run_folders(self.folder)
        if not there:
            return []
        listed = read_points(self.folder)
        items = listed.members if listed and listed.points == plain(self.study.points) else []
        if [(item.point, item.seed) for item in items] != [(start.point, start.seed) for start in self.starts]:
            if len(self.starts) > MOST_UNLISTED:
                raise CaseError(
                    f"{self.folder / POINTS_FILE}: does not list these {len(self.starts)} runs, and more than "
                    f"{MOST_UNLISTED} are not looked for without it; `lammps-jump sweep` of the study writes it"
                )
            return None
        pairs = [(start, item.key) for start, item in zip(self.starts, items, strict=True) if item.key in there]
        members = plan(self.study.case, [start for start, _ in pairs], self.study.analysis)
        begun_members = [listed_as(member, key) for member, (_, key) in zip(members, pairs, strict=True)]
        known = [member for member in begun_members if member is not None]
        return known if len(known) == len(begun_members) else None


def _starts(study: Study, folder: Path) -> Iterator[Start]:
    """Members that the study asks for, and those that ``until`` has added before."""
    points = study.points
    apart = max(study.fields.members) if study.fields.starts == "own" else 0
    seeds = {(point, seed + point * apart) for point in range(len(points)) for seed in study.fields.members}
    if study.fields.until and (listed := read_points(folder)) and listed.points == plain(points):
        seeds |= {(item.point, item.seed) for item in listed.members}
    return (Start(point, points[point], seed) for point, seed in sorted(seeds))
