# SPDX-License-Identifier: GPL-2.0-or-later
"""A study of points and tables, run: the points that its store lacks, its JSON file, its page and figures."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from lammps_jump.analysis.tables.markdown import paragraphs
from lammps_jump.errors import CaseError, RunError
from lammps_jump.files import plain
from lammps_jump.provenance import usable_cores
from lammps_jump.studies.folder import held_folder
from lammps_jump.sweeps import Pool, Results, Say, Store

from .find import STUDY_FILE, load_module, source_of
from .pieces import Piece, failures_of, forget, found_of, measure, pieces_of
from .point import FAILED, PointStudy


class Teller:
    """Tells a line for each start that is made."""

    def __init__(self, study: PointStudy, pieces: Sequence[Piece], say: Say):
        self.pieces = {piece.key: piece for piece in reversed(pieces)}  # a run of two points is told of the first
        self.study, self.say = study, say

    def heard(self, key: str, news: object) -> None:
        """Nothing is told of a run on its way."""

    def ended(self, key: str, measured: Any) -> None:
        """Tell what a start has found."""
        piece = self.pieces[key]
        lacks = not piece.point.judged and FAILED in measured
        line = measured[FAILED] if lacks else self.study.told(piece.point, piece.start, measured)
        if line:
            self.say(f"  {line}")


def run_study(
    study: PointStudy,
    folder: Path,
    *,
    source: Path | None = None,
    command: str = "",
    fresh: bool = False,
    say: Say = print,
) -> tuple[Results, str]:
    """Return what the JSON file of a study holds, and its page in Markdown; what is stored is not made again.

    Parameters
    ----------
    study : PointStudy
    folder : Path
        Gets runs, JSON file, page and figures.
    source : Path, optional
        Folder of the study where its functions are not those of the program.
    command : str
        That marks the folder; default the study's name.
    fresh : bool
        Make again what is stored.
    say : callable
        Takes a line of progress.

    Raises
    ------
    CaseError, SetupError
        A point that cannot be run, or a folder that holds something else.
    RunError
        A point that failed and is not judged; the others are kept.
    """
    with held_folder(folder, command or study.name):
        pieces = pieces_of(study.name, study.points, folder, source, fresh=fresh)
        store = Store(folder / f"{study.name}.json")
        for line in study.opening:
            say(line)
        forget(pieces, store, fresh=fresh)
        with Pool(1 if study.timed else usable_cores()) as pool:
            order = list(by_turns(pieces)) if study.timed else pieces
            measure(order, store, pool, Teller(study, pieces, say))
        if failures := failures_of(pieces, store):
            raise RunError(failures[0])
        found: Results = plain(study.results(found_of(pieces, store), store.data))
        for line in study.ending(found):
            say(line)
        study.draw(found, folder)
        text = store.finish(paragraphs(*study.page(found)), **found)
        return store.data, text


def by_turns(pieces: Sequence[Piece]) -> Iterator[Piece]:
    """Yield the pieces start by start, forwards and backwards in turn."""
    for start in range(1, max((piece.start for piece in pieces), default=0) + 1):
        some = [piece for piece in pieces if piece.start == start]
        yield from some if start % 2 else reversed(some)


def study_named(name: str, laws: Path | None = None, **options: Any) -> tuple[PointStudy, Path]:
    """Return a study that the wheel does not carry, with its options, and its folder.

    Raises
    ------
    CaseError
        The folder given has no such study, or it has no function ``study``.
    SetupError
        The source is not there.
    """
    file = f"{name}/{STUDY_FILE}"
    folder = source_of(f"the points of `lammps-jump {name}`", file, laws) / name
    make = getattr(load_module(folder, "study"), "study", None)
    found = make(**options) if callable(make) else None
    if not isinstance(found, PointStudy):
        raise CaseError(
            f"{folder / STUDY_FILE}: has no function study that returns a PointStudy; CONTRIBUTING.md has one"
        )
    return found, folder


def run_named(
    name: str,
    out: Path | None = None,
    *,
    laws: Path | None = None,
    fresh: bool = False,
    say: Say = print,
    **options: Any,
) -> tuple[Results, str]:
    """Run a study that the wheel does not carry, by its name; as `run_study` and `study_named`.

    `out` is ``runs/<name>`` unless given.
    """
    study, source = study_named(name, laws, **options)
    return run_study(study, out or Path("runs") / name, source=source, fresh=fresh, say=say)
