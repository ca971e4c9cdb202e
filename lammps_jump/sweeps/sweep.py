# SPDX-License-Identifier: GPL-2.0-or-later
"""Many runs as one: run what a study asks for and is not there yet, and look at what its folder holds."""

from __future__ import annotations

import html
import logging
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from functools import cached_property
from importlib import import_module
from math import nan
from pathlib import Path
from threading import Thread
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, get_args

import lammps_jump.sweeps as sweeps
from lammps_jump.analysis.report.rows import Row, rows_of
from lammps_jump.analysis.statistics import Mean
from lammps_jump.case.case import ReadCase
from lammps_jump.dump.exports import csv_text, write_netcdf
from lammps_jump.engines.choice import usable_cores
from lammps_jump.errors import CaseError, RunInterrupted
from lammps_jump.files import SWEEP_FILES, plain, write_json, write_text
from lammps_jump.folders import Marker, clear
from lammps_jump.runs.folder import run_folder
from lammps_jump.runs.run import Case, Run
from lammps_jump.runs.summary import read_summary

from .listed import POINTS_FILE, read_points
from .members import (
    OVER,
    Member,
    Stage,
    Start,
    State,
    listed_as,
    plan,
    require_no_links,
    run_folders,
    run_members,
    state_of,
    told,
)
from .pool import Pool
from .study import Study, read_study

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

log = logging.getLogger(__name__)
MOST_UNLISTED = 5_000
"""Members that the status makes of their cases, milliseconds each, where ``points.json`` does not list them."""


@dataclass(frozen=True)
class SweepProgress:
    """How far a study has come.

    Attributes
    ----------
    done, failed, total : int
        Runs.
    share : float
        Of all steps that were left to do.
    disc_steps : float
        Done so far, in this process.
    """

    done: int
    failed: int
    total: int
    share: float
    disc_steps: float


class Failure(NamedTuple):
    """A member that is not in the table, and why."""

    point: int
    seed: int
    folder: Path
    message: str


class Board:
    """Counts what the members at work have done.

    Parameters
    ----------
    found : Sweep
    retry : bool
        Those that failed are run again.
    show : callable
        Called with a `SweepProgress` at every change.
    """

    def __init__(self, found: Sweep, retry: bool, show: Callable[[SweepProgress], None]):
        count = Counter(state.stage for state in found.states.values())
        self.now = SweepProgress(count["done"], 0 if retry else count["failed"], len(found.states), 0.0, 0.0)
        self.left, self.show = len(found.left(retry)), show
        self._shares: dict[str, float] = {}
        self._steps: dict[str, float] = {}

    def heard(self, key: str, news: tuple[float, float, int]) -> None:
        """Take in the progress of a member: share and number of its steps, discs in play."""
        share, step, discs = news
        more = max(0.0, step - self._steps.get(key, step)) * discs
        self._steps[key] = step
        self._tell(key, share, disc_steps=self.now.disc_steps + more)

    def ended(self, key: str, state: State) -> None:
        """Count a member."""
        good = state.stage == "done"
        self._tell(key, 1.0, done=self.now.done + good, failed=self.now.failed + (not good))

    def _tell(self, key: str, share: float, **changes: Any) -> None:
        self._shares[key] = share
        self.now = replace(self.now, share=sum(self._shares.values()) / max(self.left, 1), **changes)
        self.show(self.now)


class Sweep:
    """A study, seen through its folder.

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
    def states(self) -> dict[str, State]:
        """What the folder holds of each member, by its key."""
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
        return [Failure(m.point, m.seed, m.folder(self.folder), told(s)) for m, s in states if s.message]

    @cached_property
    def values(self) -> pd.DataFrame:
        """What was collected of every run that is done: a row each, with ``point`` and ``seed``."""
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
    def rows(self) -> list[Row]:
        """The numbers that readers look for first: means over all runs, with the interval over starts."""
        return rows_of(self.summaries, self.mean)

    def mean(self, values: Sequence[float]) -> Mean:
        """Mean of numbers and half its interval."""
        found = sweeps.table.statistics(values, [nan] * len(values), self.study.fields.confidence)
        return Mean(found["mean"], found["high"] - found["mean"])

    def needed(self) -> list[int]:
        """Members that each point would need for the intervals that ``until`` asks for; 0 where that cannot be told."""
        needed = [
            [sweeps.table.members_needed(found, share) or 0 for found in sweeps.table.records(self.table, path)]
            for path, share in self.study.fields.until.items()
        ]
        return [max(counts) for counts in zip([0] * len(self.study.points), *needed, strict=True)]

    def wider(self) -> Sweep | None:
        """The study with more members of points whose intervals are wider than ``until`` allows; None where none is.

        A point at most doubles its members, and has ``table.FIRST`` at least.
        """
        more: list[Start] = []
        for point, needed in enumerate(self.needed()):
            seeds = [start.seed for start in self.starts if start.point == point]
            count = min(needed, max(sweeps.table.FIRST, 2 * len(seeds)), self.study.fields.most_members) - len(seeds)
            more += [Start(point, self.study.points[point], max(seeds) + 1 + k) for k in range(count)]
        starts = sorted([*self.starts, *more], key=lambda start: (start.point, start.seed))
        return Sweep(self.study, self.folder, starts) if more else None

    @property
    def summary(self) -> dict[str, Any]:
        """The statistics of each point as plain data: what ``summary.json`` of the folder holds."""
        counts, verdicts = (self.table[name].values.ravel().tolist() for name in ("members", "verdicts"))
        points: list[dict[str, Any]] = [
            {"values": values, "members": count, "verdicts": said, "numbers": {}}
            for values, count, said in zip(self.study.points, counts, verdicts, strict=True)
        ]
        for item in self.study.collect:
            for point, found in zip(points, sweeps.table.records(self.table, item.path), strict=True):
                point["numbers"][item.path] = {**found, "unit": item.unit}
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
        """The members that have a run folder, found by ``points.json``; None where all were read, or it does not tell.

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
        found = [listed_as(member, key) for member, (_, key) in zip(members, pairs, strict=True)]
        known = [member for member in found if member is not None]
        return known if len(known) == len(found) else None

    def write(self) -> Path:
        """Write table, figures and page into the folder; the path of the page."""
        clear(self.folder, [name for name in SWEEP_FILES if name.startswith("figures/")])
        frame = sweeps.table.flat(self.table, self.study)
        write_text(self.folder / "table.csv", csv_text(frame))
        write_netcdf(self.table, self.folder / "table.nc")
        write_json(self.folder / "summary.json", self.summary, indent=2)
        return sweeps.page.write_page(self)

    def figures(self, ending: Literal["png", "pdf", "svg"] = "png") -> list[Path]:
        """Draw every figure of the study into ``figures`` of its folder, as files with this ending; the paths."""
        with study_folder(self.folder):
            return list(sweeps.page.draw(self, ending))

    def __repr__(self) -> str:
        return f"Sweep({str(self.folder)!r}, {self.status()})"

    def _repr_html_(self) -> str:
        table = sweeps.page.summary_frame(self).to_html(index=False)
        return f"<p><b>{html.escape(self.study.case.name)}</b>: {html.escape(self.status())}</p>{table}"


def _starts(study: Study, folder: Path) -> Iterator[Start]:
    """Members that the study asks for, and those that ``until`` has added before."""
    points = study.points
    seeds = {(point, seed) for point in range(len(points)) for seed in study.fields.members}
    if study.fields.until and (listed := read_points(folder)) and listed.points == plain(points):
        seeds |= {(item.point, item.seed) for item in listed.members}
    return (Start(point, points[point], seed) for point, seed in sorted(seeds))


def study_folder(folder: Path) -> AbstractContextManager[None]:
    """Hold the folder of a study, made where it is missing, as the only process that runs it; see `run_folder`."""
    return run_folder(folder, Marker("sweep", SWEEP_FILES, {}))


def default_folder(study: str | Path | Mapping[str, Any] | ReadCase, case: Case) -> Path:
    """Where a study is kept when no folder is named: ``runs/<stem of its file>``, of a case ``runs/<stem>_sweep``."""
    if not isinstance(study, str | Path):
        return Path("runs") / f"{case.name}_sweep"
    if Path(study).is_dir():
        return Path(study)
    of_a_case = Path(case.source.file) == Path(study)
    return Path("runs") / (f"{Path(study).stem}_sweep" if of_a_case else Path(study).stem)


def open_sweep(folder: str | Path) -> Sweep:
    """The study in a folder, finished or not; nothing is written.

    Raises
    ------
    CaseError
        The folder holds no study.
    """
    if not (Path(folder) / "study.yaml").is_file():
        raise CaseError(
            f"{folder}: holds no study (no study.yaml); `lammps-jump sweep STUDY.yaml --out {folder}` makes one"
        )
    return Sweep(read_study(folder), Path(folder))


def sweep(
    study: str | Path | Mapping[str, Any] | ReadCase,
    folder: str | Path | None = None,
    *,
    jobs: int | None = None,
    retry: bool = False,
    progress: Callable[[SweepProgress], None] = lambda progress: None,
    **given: Any,
) -> Sweep:
    """Run the points and members of a study that its folder does not hold yet, and write table, figures and page.

    Parameters
    ----------
    study : str, Path, mapping or Case
        A study file, the folder of a study, or its fields: ``case``, ``axes``, ``members``, ``collect`` …; or a case,
        whose study is what is `given`.
    folder : str or Path, optional
        Default ``runs/<stem of the file>``.
    jobs : int, optional
        Processes at once; default one for each core that this process may use.
    retry : bool
        Run again what failed.
    progress : callable, optional
        Called with a `SweepProgress`.
    given
        Fields in place of those of the study.

    Raises
    ------
    CaseError, SetupError
        Before anything is run: a field or a point that cannot be used, a folder in use.
    RunInterrupted
        Ctrl-C or SIGTERM; the same call goes on.
    """
    read = read_study(study, **given)
    place = Path(folder) if folder is not None else default_folder(study, read.case)
    found = Sweep(read, place)
    ranks = read.case.fields.engine.ranks
    most = jobs or max(1, usable_cores() // (ranks if isinstance(ranks, int) else 1))
    members = found.members  # what cannot be run is refused before the folder is made
    with study_folder(place), Pool(min(most, len(members))) as pool:
        Thread(target=_load_page).start()
        found = _complete(found, pool, retry, progress)
        pool.close()
        found.write()
    return found


def _load_page() -> None:
    """Load what writes the page, 0.5 s, while the runs go on."""
    for module in ("lammps_jump.sweeps.page", "scipy.special"):
        import_module(module)


def _complete(found: Sweep, pool: Pool, retry: bool, progress: Callable[[SweepProgress], None]) -> Sweep:
    """Run the members of a study, and more of them where ``until`` asks for narrower intervals."""
    while True:
        prepare(found)
        board, again = Board(found, retry, progress), ("failed",) if retry else ()
        states, folder = found.states, found.folder
        try:
            run_members(found.members, states, folder, pool, again=again, ended=board.ended, news=board.heard)
        except RunInterrupted as error:
            raise RunInterrupted(f"{found.folder}: {error}. {Sweep(found.study, found.folder).status()}") from None
        wider = found.wider()
        if wider is None:
            return found
        more = len(wider.starts) - len(found.starts)
        log.info(f"{more} more runs: {', '.join(found.study.fields.until)} is not known well enough yet")
        found = wider


def prepare(found: Sweep) -> None:
    """Write ``study.yaml`` and ``points.json`` into the folder of a study: all that its members need to be run.

    Raises
    ------
    SetupError
        The folder of a member is a link.
    """
    require_no_links(found.members, found.folder)
    write_text(found.folder / "study.yaml", found.study.to_yaml())
    listed = [{"point": member.point, "seed": member.seed, "key": member.key} for member in found.members]
    write_json(found.folder / POINTS_FILE, {"points": found.study.points, "members": listed})
