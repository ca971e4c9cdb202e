# SPDX-License-Identifier: GPL-2.0-or-later
"""Pages of run folders, each with a number, and of studies; an address names no folder."""

from __future__ import annotations

import hmac
import secrets
from collections.abc import Mapping, Sequence
from functools import partial
from math import inf
from pathlib import Path
from threading import Lock
from typing import Any

from lammps_jump import sweeps
from lammps_jump.case.case import ReadCase
from lammps_jump.errors import SetupError
from lammps_jump.files import MOST_TEXT, read_file
from lammps_jump.quoting import typed
from lammps_jump.sweeps.members import Member, MemberState, failure_message, state_of
from lammps_jump.sweeps.study import axis_heading, axis_unit, axis_words
from lammps_jump.sweeps.study_folder import StudyResults
from lammps_jump.units import shown

from .children import Bounded, Children, OutOfDate, PageWork
from .look import flow_of_run
from .server import FOREIGN, KINDS, LIVE, RefusedRequest, Reply, answer, run_page
from .watched import WatchedRun

REPORT = "report.html"
MOST_FLOWS = 4
"""Live pages that are kept; each has a megabyte."""
FLOW_SECONDS = 40.0
"""Seconds after which the set-up of a flow is left."""
MOST_NAME = 40
"""Letters of the name of a page."""


class LivePages:
    """Live pages that pages have requested, each at an address of its own; the newest few are kept.

    Attributes
    ----------
    bounded : Bounded
        Makes them.
    """

    def __init__(self) -> None:
        self.bounded = Bounded()
        self._pages: dict[str, str] = {}

    def make(self, call: partial[str], page: str, remedy: str) -> Reply:
        """The address of the page of a call; one that the same page requested before is left."""
        try:
            made = self.bounded.run(PageWork(call, FLOW_SECONDS, remedy, f"{page[:MOST_NAME]} flow"))
        except OutOfDate:
            return answer({"refused": "a newer text has come", "left": True}, 409)
        token = secrets.token_urlsafe(32)
        self._pages = dict([*self._pages.items(), (token, made)][-MOST_FLOWS:])
        return answer({"at": f"/{token}/"})

    def with_token(self, token: str) -> Reply | None:
        """The page with this token; None where there is none."""
        pages = [text for own, text in self._pages.items() if hmac.compare_digest(own.encode(), token.encode())]
        return Reply(pages[0].encode(), KINDS[".html"], policy=LIVE) if pages else None


class RunPages:
    """The runs that a page may show."""

    def __init__(self, children: Children, live: LivePages):
        self.children, self._live = children, live
        self._runs: list[WatchedRun] = []
        self._reports: dict[Path, str] = {}
        self._lock = Lock()

    def number(self, folder: Path) -> int:
        """The number of a folder, which may not be there yet."""
        with self._lock:
            known = [one.folder for one in self._runs]
            if folder not in known:
                self._runs.append(WatchedRun(folder))
                return len(known)
            return known.index(folder)

    def expect(self, folder: Path, case: ReadCase) -> None:
        """Shows the start of a case whose run has just been requested."""
        self._runs[self.number(folder)].expect(case)

    def get(self, path: str, query: Mapping[str, str]) -> Reply | None:
        """Page, state, curves or frames of ``<number>/…``, or where its report is."""
        run, part = self._found(path)
        if run is None:
            return None
        if part == "":
            return run_page()
        if part == "state":
            return answer(self._state(run))
        if part == "curves":
            return answer(run.curves())
        if part == "frames":
            first = query.get("first", "")
            if not (first.isascii() and first.isdigit() and len(first) < 9):
                raise RefusedRequest(400, "first is no number")
            return Reply(run.frames(int(first), query.get("of", "")), "application/octet-stream")
        if part == "report":
            return self._to_report(run.folder)
        return None

    def post(self, path: str, asked: Mapping[str, Any]) -> Reply | None:
        """Stop a run that was started here, go on with one that was stopped, or go on differently from a time of it."""
        run, part = self._found(path)
        if run is None:
            return None
        child = self.children.of(run.folder)
        if part == "stop":
            if child is None or child.status is not None:
                raise SetupError(f"{run.folder}: no run that was started here goes on there")
            child.stop()
            return answer({})
        if part == "go-on":
            self.children.start(run.folder, "run", run.folder, "--resume")
            return answer({})
        if part == "differently":
            time = number_in(asked.get("time"), "time")
            remedy = f"`{typed('live', run.folder, '--from', f'{time:.6g}')}` has no such limit"
            return self._live.make(
                partial(flow_of_run, run.folder.absolute(), time), str(asked.get("page", "")), remedy
            )
        return None

    def _found(self, path: str) -> tuple[WatchedRun | None, str]:
        """The run that a path begins with, and what the rest of the path wants of it."""
        number, slash, part = path.partition("/")
        known = bool(slash) and number.isascii() and number.isdigit() and len(number) < 7
        return (self._runs[int(number)] if known and int(number) < len(self._runs) else None), part

    def _state(self, run: WatchedRun) -> dict[str, Any]:
        """State of a run for its page."""
        child = self.children.of(run.folder)
        state = run.update()
        own = child is not None and child.status is None
        state |= {"folder": str(run.folder), "own": own, "log": child.lines if child else []}
        if own and state["status"] != "running":
            if state["status"] in ("none", "interrupted"):
                state |= {"status": "starting", "reached": ""}
        if child is not None and child.status and state["status"] == "none":
            state |= {"status": "refused", "message": "\n".join(child.lines)}
        state["command"] = child.command if child else typed("run", run.folder)
        state["stop"] = f"kill -TERM {child.process.pid}" if child is not None and own else None
        state["go_on"] = typed("run", run.folder, "--resume") if state["status"] == "interrupted" else None
        state["report"] = typed("show", run.folder) if _has_report(run.folder) else None
        ended = state["status"] in ("complete", "interrupted", "unchecked")
        state["differently"] = typed("live", run.folder, "--from", "TIME") if ended else None
        return state

    def _to_report(self, folder: Path) -> Reply | None:
        """Leads to an address with a token of its own: a report reads its address, and may send it anywhere."""
        if not _has_report(folder):
            return None
        with self._lock:
            token = self._reports.setdefault(folder, secrets.token_urlsafe(32))
        return Reply(b"", KINDS[".html"], 303, FOREIGN, f"/{token}/")

    def report(self, token: str) -> Reply | None:
        """The report with this token; None where there is none."""
        with self._lock:
            known = [(folder, own) for folder, own in self._reports.items()]
        paths = [folder for folder, own in known if hmac.compare_digest(own.encode(), token.encode())]
        if not paths or not _has_report(paths[0]):
            return None
        return Reply(read_file(paths[0] / REPORT, MOST_TEXT), KINDS[".html"], policy=LIVE)


def number_in(value: object, name: str) -> float:
    """A finite number that a page sends as `name`; Refused for something else."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < inf:
        raise RefusedRequest(400, f"{name}: is no number")
    return float(value)


def _has_report(folder: Path) -> bool:
    path = folder / REPORT
    return path.is_file() and not path.is_symlink()


class StudyView:
    """The folder of a study that is looked at; nothing is written there.

    Raises
    ------
    CaseError
        The folder holds no study.
    """

    def __init__(self, folder: Path, runs: RunPages):
        self.folder, self.runs = folder, runs
        self._lock = Lock()
        self._held: StudyResults = sweeps.open_sweep(folder)
        self._states: list[MemberState] = []
        self._table: dict[str, Any] = {}

    def state(self) -> dict[str, Any]:
        """State of a study for its page; the table is made again where a run has ended."""
        with self._lock:
            before, states = self._states, [state_of(member, self.folder) for member in self._held.members]
            if _over(states) != _over(before):
                self._held = sweeps.open_sweep(self.folder)  # the study may have more members now
                states = [state_of(member, self.folder) for member in self._held.members]
                self._table = self._numbers(any(state.stage == "done" for state in states))
            self._states = states
            study = self._held.study
            return {
                "name": study.case.name,
                "description": study.case.fields.description,
                "folder": str(self.folder),
                "status": self._held.status(),
                "command": typed("sweep", self.folder),
                "going": any(state.stage == "running" for state in states),
                "axes": [_axis(axis.name, axis.values) for axis in study.axes],
                "runs": [self._run(member, state) for member, state in zip(self._held.members, states, strict=True)],
                **self._table,
            }

    def _numbers(self, some: bool) -> dict[str, Any]:
        """The table of means; nothing before the first run is done."""
        if not some:
            return {"columns": [], "rows": [], "doubts": []}
        frame = sweeps.page.summary_frame(self._held)
        return {"columns": list(frame.columns), "rows": frame.values.tolist(), "doubts": sweeps.page.doubts(self._held)}

    def _run(self, member: Member, state: MemberState) -> dict[str, Any]:
        """One member: its point, seed and stage, and the number of its page."""
        return {
            "number": self.runs.number(member.folder(self.folder)),
            "point": sweeps.page.point_name(self._held.study, member.point),
            "place": list(self._held.study.points[member.point].values()),
            "seed": member.seed,
            "stage": state.stage,
            "message": failure_message(state),
        }


def _axis(name: str, values: Sequence[Any]) -> dict[str, Any]:
    """An axis with its values, and as the slider of a static page shows them."""
    labels = [shown(value, axis_unit(name)) for value in values]
    return {"name": axis_heading(name), "values": list(values), "label": axis_words(name), "shown": labels}


def _over(states: list[MemberState]) -> list[str]:
    """Members that have ended, which the table is made of."""
    return [state.stage if state.stage in ("done", "failed") else "" for state in states]
