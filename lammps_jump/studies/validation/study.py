# SPDX-License-Identifier: GPL-2.0-or-later
"""``lammps-jump validate``: run the points of published laws, several starts each, and write one page; resumable."""

from __future__ import annotations

import subprocess
from collections.abc import Callable, Mapping, Sequence
from itertools import chain
from pathlib import Path
from typing import Any

from lammps_jump.analysis.draw.style import save
from lammps_jump.files import plain, write_json
from lammps_jump.folders import require_no_link
from lammps_jump.provenance import machine, usable_cores
from lammps_jump.studies.folder import held_folder
from lammps_jump.studies.points.pieces import Piece, failures_of, forget, found_of, measure, pieces_of
from lammps_jump.studies.points.point import FAILED, Found
from lammps_jump.sweeps import Pool, Results, Store, SweepProgress, all_versions

from .law import Law, Row, find_laws, laws_folder
from .page import write_page

RESULTS_FILE, PAGE_FILE = "validation.json", "report.html"


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
        planned = {
            name: pieces_of(name, law.points(quick), folder, place / name, keep_dumps=keep_dumps)
            for name, law in known.items()
        }
        pieces = list(chain.from_iterable(planned.values()))
        store = Store(folder / RESULTS_FILE, fresh=fresh)
        forget(pieces, store)
        with Pool(jobs or usable_cores()) as pool:
            measure(pieces, store, pool, LawsBoard(pieces, store, progress))
        report: Results = {"quick": quick, "commit": commit(place), "versions": all_versions(), "machine": machine()}
        report["laws"] = {
            name: outcome(law, planned[name], store, folder / "figures" / f"{name}.png") for name, law in known.items()
        }
        store.data |= plain(report)
        write_json(store.path, store.data, indent=2)
        write_page(store.data, folder / PAGE_FILE)
        return store.data


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
    found, failures = found_of(pieces, store), failures_of(pieces, store)
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
        if piece.member is not None:
            one.setdefault("runs", []).append(piece.member.key)
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
