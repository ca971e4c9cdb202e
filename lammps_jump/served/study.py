# SPDX-License-Identifier: GPL-2.0-or-later
"""Page of a study: its table as it fills, and its runs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from threading import Lock
from typing import Any

from lammps_jump import sweeps
from lammps_jump.quoting import typed
from lammps_jump.sweeps.members import Member, MemberState, failure_message, state_of
from lammps_jump.sweeps.study_folder import StudyResults
from lammps_jump.sweeps.words import heading, unit, words
from lammps_jump.units import shown

from .run_pages import RunPages


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
    told = [shown(value, unit(name)) for value in values]
    return {"name": heading(name), "values": list(values), "label": words(name), "shown": told}


def _over(states: list[MemberState]) -> list[str]:
    """Members that have ended, which the table is made of."""
    return [state.stage if state.stage in ("done", "failed") else "" for state in states]
