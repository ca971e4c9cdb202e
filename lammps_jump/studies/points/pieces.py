# SPDX-License-Identifier: GPL-2.0-or-later
"""The starts of all points as pieces of a store: their keys, the calls that make them, what was found of each point."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from lammps_jump.errors import JumpError
from lammps_jump.files import plain, text_of
from lammps_jump.identity import short_hash
from lammps_jump.runs.run import Case, load_case
from lammps_jump.sweeps import Pool, Start, Store, plan
from lammps_jump.sweeps.members import Member
from lammps_jump.sweeps.pool import CallOutcome
from lammps_jump.sweeps.store import Watch

from .find import LAW_FILE, STUDY_FILE
from .point import FAILED, Point
from .work import Task, failed, work


class Piece(NamedTuple):
    """One start of a point: whose it is, its number from 1, the key of its result, what makes it, the run behind it."""

    owner: str
    point: Point
    start: int
    key: str
    call: partial[Any]
    member: Member | None = None


def pieces_of(
    owner: str,
    points: Iterable[Point],
    store: Path,
    folder: Path | None = None,
    *,
    fresh: bool = False,
    keep_dumps: bool = False,
) -> list[Piece]:
    """Return the pieces of a study. A key holds the run, what measures it, and the text of the folder's modules.

    Parameters
    ----------
    owner : str
        Name of the study.
    points : iterable of Point
    store : Path
        Holds ``runs/``.
    folder : Path, optional
        Of the study; none where its functions and cases are those of the program.
    fresh : bool
        Run again what is there, where the measuring function does not read the dump.
    keep_dumps : bool
        Leave the dumps in the run folders.

    Raises
    ------
    CaseError, SetupError
        A point that cannot be run, unless it is judged: nothing is run then.
    """
    text = text_of_measures(folder) if folder else ""
    found = []
    for point in points:
        about = {"measure": point.measure_name, "options": plain(point.options), "text": text}
        hashed = short_hash(about)
        try:
            members = members_of(point, folder)
        except JumpError as error:
            if not point.judged:
                raise
            asked = {**about, "changes": plain(point.changes), "refused": str(error)}
            key = f"{owner} refused {short_hash(asked)}"
            refused = partial(failed, str(error))
            found += [Piece(owner, point, start, f"{key} {start}", refused) for start in range(1, point.starts + 1)]
            continue
        for start, member in enumerate(members, 1):
            key = f"{owner} {hashed}" if member is None else f"{owner} {member.key}-{hashed}"
            place, again = folder or Path(), fresh and not point.dump
            task = Task(place, point.measure, point.options, member, store, point.dump, again, keep_dumps)
            found.append(Piece(owner, point, start, key, partial(work, task), member))
    return found


def text_of_measures(folder: Path) -> str:
    """Return the text of the modules of a study that measure: all but those that plan it and show it."""
    paths = sorted(path for path in folder.glob("*.py") if path.name not in (LAW_FILE, STUDY_FILE))
    return "".join(map(text_of, paths))


def members_of(point: Point, folder: Path | None) -> Sequence[Member | None]:
    """Return the runs of a point; one that is None where it is a function without a run."""
    if point.case is None:
        return [None]
    case = point.case if isinstance(point.case, Case) else load_case((folder or Path()) / point.case)
    starts = [Start(0, point.changes, point.seed + number) for number in range(point.starts)]
    return plan(case, starts, {"analysis.figures": "none"})


def forget(pieces: Iterable[Piece], store: Store, *, fresh: bool = False) -> None:
    """Take out of a store what failed and is no finding, so that it is tried again; with `fresh` all pieces."""
    for piece in pieces:
        if fresh or (not piece.point.judged and FAILED in store.pieces.get(piece.key, ())):
            store.pieces.pop(piece.key, None)


def measure(pieces: Sequence[Piece], store: Store, pool: Pool, watch: Watch) -> None:
    """Make the pieces that a store lacks, begun in their order; those with the same patience together."""
    for patience in dict.fromkeys(piece.point.patience for piece in pieces):
        some = [piece for piece in pieces if piece.point.patience == patience]
        calls, keys = [piece.call for piece in some], [piece.key for piece in some]
        store.call(calls, pool, keys=keys, watch=watch, otherwise=lost, patience=patience)


def lost(outcome: CallOutcome) -> dict[str, str]:
    """Return the measurement of a call that did not return: the reason alone."""
    return failed(f"{outcome.kind}: {outcome.value}")


def found_of(pieces: Iterable[Piece], store: Store) -> dict[str, list[Any]]:
    """Return what was measured at each point, starts in their order; `FAILED` ones of judged points among them."""
    found: dict[str, list[Any]] = {}
    for piece in pieces:
        measured, ones = store.pieces[piece.key], found.setdefault(piece.point.name, [])
        if piece.point.judged or FAILED not in measured:
            ones.append(measured)
    return found


def failures_of(pieces: Iterable[Piece], store: Store) -> list[str]:
    """Return what failed and is no finding, a line each."""
    return [
        f"{piece.point.name}: {measured[FAILED]}"
        for piece in pieces
        if not piece.point.judged and FAILED in (measured := store.pieces[piece.key])
    ]
