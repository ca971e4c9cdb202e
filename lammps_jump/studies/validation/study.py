# SPDX-License-Identifier: GPL-2.0-or-later
"""``lammps-jump validate``: run the points of published laws, several starts each, and write one page; resumable."""

from __future__ import annotations

import subprocess
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from lammps_jump import load_case
from lammps_jump.analysis.draw.style import save
from lammps_jump.files import plain, text_of, write_json
from lammps_jump.folders import require_no_link
from lammps_jump.identity import short_hash
from lammps_jump.provenance import machine, usable_cores
from lammps_jump.studies.folder import held_folder
from lammps_jump.sweeps import Pool, Start, Store, SweepProgress, all_versions, plan
from lammps_jump.sweeps.pool import CallOutcome

from .find import MEASURE_FILE, find_laws, laws_folder
from .law import Found, Law, Point, Row
from .page import write_page
from .work import FAILED, Task, work

RESULTS_FILE, PAGE_FILE = "validation.json", "report.html"


class Piece(NamedTuple):
    """One start of a point of a law: the key of its result, and what makes it."""

    law: str
    point: Point
    key: str
    task: Task


def default_folder(quick: bool) -> Path:
    """Return the folder of the results where none is named."""
    return Path("runs") / ("validate_quick" if quick else "validate")


def listing(laws: Path | None = None) -> str:
    """Return names and questions of the laws, a line each."""
    found = find_laws(laws_folder(laws))
    wide = max(map(len, found))
    return "\n".join(f"{name:<{wide}}  {law.question}" for name, law in found.items())


def validate(
    names: Sequence[str] = (),
    out: Path | str | None = None,
    *,
    laws: Path | None = None,
    quick: bool = False,
    jobs: int | None = None,
    fresh: bool = False,
    keep_dumps: bool = False,
    progress: Callable[[SweepProgress], None] = lambda progress: None,
) -> dict[str, Any]:
    """Return what ``validation.json`` holds, after the laws were run, and their page written.

    Parameters
    ----------
    names : sequence of str
        Laws; all where none is named.
    out : Path, optional
        Default ``runs/validate``, quick ``runs/validate_quick``. Runs and results that it holds are not made again.
    laws : Path, optional
        Folder of the laws; default ``validation`` of the source tree.
    quick : bool
        The short form of each law: seconds.
    jobs : int, optional
        Processes at once; default one a usable core.
    fresh : bool
        Measure again what is stored.
    keep_dumps : bool
        Leave the dumps in the run folders, so that another measuring function needs no run.
    progress : callable
        Called with a `SweepProgress`.
    """
    place = laws_folder(laws)
    known = find_laws(place, list(names))
    folder = Path(out) if out else default_folder(quick)
    with held_folder(folder, "validate"):
        pieces = [piece for name, law in known.items() for piece in pieces_of(place / name, law, quick, folder)]
        store = Store(folder / RESULTS_FILE, fresh=fresh)
        for piece in pieces:
            if FAILED in store.pieces.get(piece.key, ()):
                del store.pieces[piece.key]  # it is tried again
        board = LawsBoard(pieces, store, progress)
        with Pool(jobs or usable_cores()) as pool:
            calls = [partial(work, piece.task._replace(keep_dump=keep_dumps)) for piece in pieces]
            store.call(calls, pool, keys=[piece.key for piece in pieces], watch=board, otherwise=lost)
        report = {"quick": quick, "commit": commit(place), "versions": all_versions(), "machine": machine()}
        figures = folder / "figures"
        report["laws"] = {
            name: outcome(law, [piece for piece in pieces if piece.law == name], store, figures / f"{name}.png")
            for name, law in known.items()
        }
        store.data |= plain(report)
        write_json(store.path, store.data, indent=2)
        write_page(store.data, folder / PAGE_FILE)
        return store.data


def lost(outcome: CallOutcome) -> dict[str, str]:
    """Return the measurement of a call that did not return: the reason alone."""
    return {FAILED: f"{outcome.kind}: {outcome.value}"}


def pieces_of(folder: Path, law: Law, quick: bool, store: Path) -> list[Piece]:
    """Return the pieces of a law. The key holds the run, what measures it, and the text of ``measure.py``."""
    text = text_of(folder / MEASURE_FILE)
    found = []
    for point in law.points(quick):
        about = {"measure": point.measure, "options": plain(point.options), "text": text}
        members: list[Any] = [None]
        if point.case is not None:
            case = load_case(folder / point.case)
            starts = [Start(0, point.changes, seed + 1) for seed in range(point.starts)]
            members = plan(case, starts, {"analysis.figures": "none"})
        for member in members:
            key = short_hash(about) if member is None else f"{member.key}-{short_hash(about)}"
            task = Task(folder, point.measure, point.options, member, store)
            found.append(Piece(folder.name, point, f"{folder.name} {key}", task))
    return found


class LawsBoard:
    """Counts what is done, for the line of progress: runs weighed by their processor time."""

    def __init__(self, pieces: Sequence[Piece], store: Store, show: Callable[[SweepProgress], None]):
        left = {piece.key: piece for piece in pieces if piece.key not in store.pieces}
        self.weights = {key: piece.point.seconds for key, piece in left.items()}
        self.whole = sum(self.weights.values()) or 1.0
        self.shares: dict[str, float] = {}
        self.steps: dict[str, float] = {}
        self.now = SweepProgress(len(pieces) - len(left), 0, len(pieces), 0.0, 0.0)
        self.show = show

    def heard(self, key: str, news: tuple[float, float, int]) -> None:
        """Take in the progress of a run: share and number of its steps, discs in play."""
        share, step, discs = news
        more = max(0.0, step - self.steps.get(key, step)) * discs
        self.steps[key] = step
        self._tell(key, share, disc_steps=self.now.disc_steps + more)

    def ended(self, key: str, piece: Mapping[str, Any]) -> None:
        """Count a measurement."""
        bad = FAILED in piece
        self._tell(key, 1.0, done=self.now.done + (not bad), failed=self.now.failed + bad)

    def _tell(self, key: str, share: float, **changes: Any) -> None:
        self.shares[key] = share
        done = sum(self.weights[one] * part for one, part in self.shares.items())
        self.now = SweepProgress(**{**vars(self.now), "share": done / self.whole, **changes})
        self.show(self.now)


def outcome(law: Law, pieces: Sequence[Piece], store: Store, figure: Path) -> dict[str, Any]:
    """Return rows, measurements and failures of a law, as they stand in ``validation.json``; draw its figure."""
    found: dict[str, list[Any]] = {piece.point.name: [] for piece in pieces}
    failures = []
    for piece in pieces:
        measured = store.pieces[piece.key]
        if FAILED in measured:
            failures.append(f"{piece.point.name}: {measured[FAILED]}")
        else:
            found[piece.point.name].append(measured)
    rows: list[Row] = []
    if all(found.values()):
        rows = list(law.rows(found))
        require_no_link(figure.parent)
        figure.parent.mkdir(parents=True, exist_ok=True)
        save(law.figure(found), figure)
    return {
        "title": law.title,
        "question": law.question,
        "notes": law.notes,
        "rows": [{**vars(row), "distance": row.distance, "verdict": row.verdict} for row in rows],
        "failures": failures,
        "figure": f"figures/{figure.name}" if rows else None,
        "table": law.table(found) if rows and law.table else None,
        "measured": with_keys(found, pieces),
    }


def with_keys(found: Found, pieces: Sequence[Piece]) -> dict[str, Any]:
    """Return what was measured at each point, with the case and its runs."""
    about: dict[str, Any] = {}
    for piece in pieces:
        one = about.setdefault(piece.point.name, {"case": piece.point.case, "changes": dict(piece.point.changes)})
        if piece.task.member is not None:
            one.setdefault("runs", []).append(piece.task.member.key)
    return {name: {**one, "found": found[name]} for name, one in about.items()}


def commit(folder: Path) -> str | None:
    """Return the commit of the source tree that holds a folder; None where there is none."""
    try:
        asked = subprocess.run(
            ["git", "-C", str(folder), "describe", "--always", "--dirty", "--abbrev=12"],
            capture_output=True, text=True, timeout=20, check=False,
        )  # fmt: skip
    except OSError:
        return None
    return asked.stdout.strip() or None
