# SPDX-License-Identifier: GPL-2.0-or-later
"""Members of a study: one start of one point each, its run folder, and the run itself in a worker process."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, Literal, NamedTuple

from lammps_jump.engines import Progress, Setting
from lammps_jump.engines.accuracy import with_accuracy
from lammps_jump.engines.choice import choose_setting, program_of
from lammps_jump.errors import DumpError, JumpError, ResumeError, SetupError
from lammps_jump.files import DUMP_NAMES
from lammps_jump.folders import clear, holder, read_marker, require_no_link, require_unlocked
from lammps_jump.identity import analysis_key, member_key, run_key, short_hash
from lammps_jump.runs.folder import has_output
from lammps_jump.runs.run import Case
from lammps_jump.runs.run import run as run_case
from lammps_jump.runs.summary import read_summary

from . import worker
from .pool import CallOutcome, Pool

JITTER = 1e-6
"""Least shift of discs at the start, in diameters. Rows of inflow differ by as much (`physics.inlet.SHIFT`): no mean
changes, and chaos makes the runs independent."""
RUNS = "runs"
Stage = Literal["done", "failed", "running", "interrupted", "waiting"]
OVER = ("done", "failed")
"""Stages of members that are run again with --retry alone."""


class Start(NamedTuple):
    """Recipe of a member: number of its point, values that the point changes, seed."""

    point: int
    changes: Mapping[str, object]
    seed: int


@dataclass(frozen=True)
class Member:
    """One start of one point.

    Attributes
    ----------
    point : int
    seed : int
    case : Case
    key : str
        Name of its run folder.
    run : str
        Key of its run. Members that differ in their analysis alone share it.
    """

    point: int
    seed: int
    case: Case
    key: str
    run: str

    def folder(self, store: Path) -> Path:
        """The run folder in a store."""
        return store / RUNS / self.key


class MemberState(NamedTuple):
    """State of a member in its run folder, and why it failed where it has."""

    stage: Stage
    message: str = ""


def failure_message(state: MemberState) -> str:
    """The message of a member that is not done, with the option that runs it again where the same command does not."""
    return f"{state.message} --retry runs it again." if state.stage == "failed" else state.message


def started(case: Case, seed: int) -> Case:
    """The case with another start, the same on every engine; seed 0 is the case without any shift."""
    changes: dict[str, object] = {"run.seed": seed, "run.members": None}
    if seed:
        changes |= {f"initial.{i}.jitter": max(item.jitter, JITTER) for i, item in enumerate(case.fields.initial)}
    return case.replace(changes)


def plan(case: Case, starts: Iterable[Start], analysis: Mapping[str, object]) -> list[Member]:
    """The members of a study; values of `analysis` say what is made of a run.

    Raises
    ------
    CaseError, SetupError
        A point that cannot be run: nothing is run then.
    """
    cases = [started(case.replace({**analysis, **start.changes}), start.seed) for start in starts]
    settings: dict[int, Setting] = {}  # one for each point: it is chosen from placed discs, which take 0.03 s
    runs = []
    for start, one in zip(starts, cases, strict=True):
        if start.point not in settings:
            settings[start.point] = choose_setting(one)[1]
        runs.append(run_key(with_accuracy(one)[0].core, program_of(settings[start.point])))
    hashes = {(run, short_hash(one.rest)) for run, one in zip(runs, cases, strict=True)}
    shared = Counter(run for run, _ in hashes)  # points that differ in their analysis alone need folders of their own
    keys = [run if shared[run] == 1 else member_key(run, one.rest) for run, one in zip(runs, cases, strict=True)]
    return [
        Member(start.point, start.seed, *made)
        for start, made in zip(starts, zip(cases, keys, runs, strict=True), strict=True)
    ]


def listed_as(member: Member, key: str) -> Member | None:
    """A member that was planned without the others, under its key among all of them; None where that is another's."""
    return replace(member, key=key) if key in (member.run, member_key(member.run, member.case.rest)) else None


def run_folders(store: Path) -> set[str]:
    """Names in the folder of the run folders."""
    try:
        return set(os.listdir(store / RUNS))
    except OSError:
        return set()


def require_no_links(members: Iterable[Member], store: Path) -> None:
    """SetupError where a run folder of a study is a link: what it leads to is no member.

    Raises
    ------
    SetupError
    """
    require_no_link(store / RUNS)
    for member in members:
        require_no_link(member.folder(store))


class MemberRun(NamedTuple):
    """A start that was run, or not: its folder, the summary of a complete run, else why there is none."""

    start: Start
    folder: Path
    summary: Mapping[str, Any]
    message: str

    @property
    def jump(self) -> Mapping[str, Any]:
        """Numbers of the jump, empty where none was found."""
        jump_part = self.summary.get("jump") or {}
        return jump_part if jump_part.get("verdict") == "jump" else {}

    @property
    def outcome(self) -> str:
        """Verdict of the jump where one was looked for, else what became of the run."""
        return (self.summary.get("jump") or {}).get("verdict") or ("complete" if self.summary else "failed")


def run_starts(
    case: Case,
    starts: Sequence[Start],
    store: Path,
    pool: Pool,
    *,
    fresh: bool = False,
    said: Callable[[MemberRun], None] = lambda made: None,
) -> list[MemberRun]:
    """Run the starts that a store lacks, for a study that reads their results itself; dumps are not kept.

    Parameters
    ----------
    case : Case
        Says what is analysed.
    starts : sequence of Start
        Begun in their order. One that cannot be run is no error: its message says why.
    store : Path
    pool : Pool
    fresh : bool
        Run again what is there.
    said : callable
        Called with every start that is made now.
    """
    refused: dict[int, MemberRun] = {}
    planned: dict[int, Member] = {}
    for number, start in enumerate(starts):
        try:
            (planned[number],) = plan(case, [start], {"analysis.figures": "none"})
        except JumpError as error:
            refused[number] = MemberRun(start, store, {}, str(error))
    require_no_links(planned.values(), store)
    numbers = {member.key: number for number, member in planned.items()}

    def made(number: int, state: MemberState) -> MemberRun:
        folder = planned[number].folder(store)
        return MemberRun(starts[number], folder, read_summary(folder) if state.stage == "done" else {}, state.message)

    def ended(key: str, state: MemberState) -> None:
        said(made(numbers[key], state))

    states = {member.key: state_of(member, store, named=False) for member in planned.values()}
    again = ("done", "failed", "interrupted") if fresh else ()
    run_members(planned.values(), states, store, pool, again=again, keep_dumps=False, ended=ended)
    return [refused.get(n) or made(n, states[planned[n].key]) for n in range(len(starts))]


def run_members(
    members: Iterable[Member],
    states: dict[str, MemberState],
    store: Path,
    pool: Pool,
    *,
    again: Sequence[str] = (),
    keep_dumps: bool = True,
    ended: Callable[[str, MemberState], None] = lambda key, state: None,
    news: Callable[[str, Any], None] = lambda key, news: None,
) -> None:
    """Run the members of a store that are neither done nor failed, each once.

    Parameters
    ----------
    members : iterable of Member
    states : dict of str to MemberState
        What is there of each, by its key; brought up to date.
    store : Path
    pool : Pool
    again : sequence of str
        Stages that are run anew.
    keep_dumps : bool
        Leave the dumps in the run folders.
    ended, news : callable
        Called with the key of a member, and what is there of it, or what `run_member` tells.

    Raises
    ------
    RunInterrupted
        Ctrl-C or SIGTERM; members at work have saved their state.
    """
    known = {member.key: member for member in members}
    left = [key for key in known if states[key].stage not in OVER or states[key].stage in again]

    def done(number: int, outcome: CallOutcome) -> None:
        member_state = state_of(known[left[number]], store)
        if outcome.kind != "done" and member_state.stage != "failed":
            member_state = MemberState(
                "interrupted" if member_state.stage == "interrupted" else "waiting", str(outcome.value)
            )
        states[left[number]] = member_state
        ended(left[number], member_state)

    calls = [partial(run_member, known[key], store, states[key].stage in again, keep_dumps) for key in left]
    pool.run(calls, done=done, news=lambda number, news_of_call: news(left[number], news_of_call))


def state_of(member: Member, store: Path, *, named: bool = True) -> MemberState:
    """State of a member by its run folder; nothing is written. Without `named` any name and description will do."""
    folder = member.folder(store)
    if holder(folder):
        return MemberState("running")
    try:
        stored = read_summary(folder)
    except DumpError:
        return MemberState("interrupted")
    own = stored.get("key") == member.run
    if own and stored["status"] == "failed" and not stored.get("can_go_on"):
        return MemberState("failed", stored["message"] or "")
    if own and stored["status"] == "complete" and _is_analysed(member.case, stored, named):
        return MemberState("done")
    return MemberState("interrupted" if has_output(folder) else "waiting")


def _is_analysed(case: Case, stored: Mapping[str, Any], named: bool) -> bool:
    """Tells whether the results are of this analysis, with or without pictures; with a player where one is wanted."""
    if not stored.get("analysed"):
        return False
    words = ["player", "default", "all"] + (["none"] if case.fields.analysis.figures == "none" else [])
    figures = (case.replace({"analysis.figures": word}) for word in words)
    analysed: dict[str, Any] = (
        {} if named else {name: stored[name] for name in ("name", "description") if name in case.rest}
    )
    return stored["analysed"]["key"] in [analysis_key({**one.rest, **analysed}, stored["outputs"]) for one in figures]


def run_member(member: Member, store: Path, again: bool, keep_dump: bool) -> None:
    """Run a member in a worker process, or go on with it; `again` deletes a run of it that failed.

    Where dumps are not kept, a run without one cannot be analysed otherwise: it is run anew.

    Raises
    ------
    JumpError
        As `lammps_jump.run`. Also where its run folder is a link or holds another run: that is left as it is.
    """
    folder = member.folder(store)
    require_no_links([member], store)
    require_unlocked(folder)
    marker = read_marker(folder)
    if marker is not None and (marker.kind, marker.about.get("key")) != ("run", member.run):
        raise SetupError(f"{folder}: holds another run than that of this member; move it out of {store / RUNS}")

    if not keep_dump and read_summary(folder).get("status") == "complete":
        again = again or not has_dump(folder)

    def tell(report: Progress) -> None:
        worker.tell((report.step / max(report.steps, 1), report.step * 1.0, report.discs))

    run = partial(run_case, member.case, folder, progress=tell, should_stop=worker.asked_to_stop)
    try:
        run(resume=not again, force=again)
    except (ResumeError, SetupError, DumpError) as error:
        if again or (isinstance(error, DumpError) and has_dump(folder)):
            raise  # a dump that is gone: another piece of work has run this member and measured it meanwhile
        run(force=True)
    if not keep_dump:
        drop_dumps(member, store)


def has_dump(folder: Path) -> bool:
    """Tells whether a run folder holds its dump, which members do not keep."""
    return any((folder / name).exists() for name in DUMP_NAMES.values())


def drop_dumps(member: Member, store: Path) -> None:
    """Delete the dump of a member's run; SetupError where its folder is a link, to a run that is no member."""
    require_no_links([member], store)
    clear(member.folder(store), DUMP_NAMES.values())
