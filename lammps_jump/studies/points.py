# SPDX-License-Identifier: GPL-2.0-or-later
"""Points of a study: what they are, how each is measured in a process of its own, kept, and made into a page.

Runs, their folder and its marker, the store and going on are the same for all studies. Folders of laws and studies that
the wheel does not carry are found here, too.
"""

from __future__ import annotations

import hashlib
import os
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

from lammps_jump.analysis.tables import paragraphs
from lammps_jump.errors import CaseError, JumpError, RunError, RunInterrupted, SetupError
from lammps_jump.files import delete, plain, read_json, study_files, text_of
from lammps_jump.folders import MARKER_FILE, Marker, read_marker, writable, write_marker
from lammps_jump.identity import short_hash
from lammps_jump.provenance import __version__, usable_cores
from lammps_jump.runs.folder import run_folder
from lammps_jump.runs.run import Case, load_case, open_run
from lammps_jump.sweeps import Pool, Results, Say, Start, Store, plan
from lammps_jump.sweeps.members import Member, drop_dumps, has_dump, require_no_links, run_member, state_of
from lammps_jump.sweeps.pool import CallOutcome
from lammps_jump.sweeps.store import Watch

TOLD_BY = ("pieces", "disc_by_disc", "zones")
"""Keys of results: one of them shows that a folder without a marker is of a study."""


@contextmanager
def held_folder(folder: Path, command: str) -> Iterator[Path]:
    """Hold the folder of a study, by the name of its command, as `run_folder` does; a new one is not left empty.

    Folders of studies had no marker before: one with results of a study gets it.

    Raises
    ------
    SetupError
        The folder holds files of those names and was not made by this program, holds something else, or is in use.
    """
    marker, new = Marker(command, study_files(command), {}), not folder.exists()
    if read_marker(folder) is None and _is_of_before(folder, command):
        with writable(folder):
            write_marker(folder, marker)
    try:
        with run_folder(folder, marker):
            yield folder
    finally:
        if new and folder.is_dir() and os.listdir(folder) == [MARKER_FILE]:
            delete(folder / MARKER_FILE)
            folder.rmdir()


def _is_of_before(folder: Path, command: str) -> bool:
    """Tells whether results are there that a study of this program has written."""
    for name in study_files(command):
        if name.endswith(".json") and (folder / name).is_file():
            try:
                data = read_json(folder / name)
            except (OSError, ValueError):
                continue
            if isinstance(data, dict) and any(isinstance(data.get(key), dict | list) for key in TOLD_BY):
                return True
    return False


# --- folders of laws and studies that the wheel does not carry, and how a module of one is loaded ---------------------


LAW_FILE, STUDY_FILE, MEASURE_FILE = "law.py", "study.py", "measure.py"
FOLDER = "validation"
TREE = Path(__file__).parents[2] / FOLDER
"""In the source tree, next to its ``pyproject.toml``; where the package is installed there is none."""


def source_of(what: str, file: str, given: Path | None = None) -> Path:
    """Return the folder of laws and studies: the given one, else that of the source tree.

    They are Python that is run, so none is taken from the folder in which a person works.

    Parameters
    ----------
    what : str
        Is looked for, in words: 'the laws'.
    file : str
        Name or pattern of a file that shows that the folder is the right one.
    given : Path, optional

    Raises
    ------
    CaseError
        The given folder holds no such file.
    SetupError
        There is none.
    """
    known = given or (TREE if (TREE.parent / "pyproject.toml").is_file() else None)
    if known and any(known.glob(file)):
        return known
    if given:
        folder, _, name = file.rpartition("/")
        lacks, needs = (
            ("no law", "a folder for each law") if folder == "*" else (f"nothing of {what}", f"a folder {folder}")
        )
        raise CaseError(f"--laws {given}: holds {lacks}; it needs {needs}, with a {name} in it")
    raise SetupError(
        f"{what} are not installed: they stand in the folder {FOLDER}/ of the source of lammps-jump {__version__}, "
        "which an installed package does not carry; get the source and name that folder with --laws DIR"
    )


def load_module(folder: Path, name: str) -> ModuleType:
    """Return a module of a folder, whose files may import each other: ``from . import measure``."""
    place = folder.resolve()
    package = f"law_{place.name}_{hashlib.sha256(str(place).encode()).hexdigest()[:8]}"
    if package not in sys.modules:
        made = ModuleType(package)
        made.__path__ = [str(place)]
        sys.modules[package] = made
    full = f"{package}.{name}"
    return import_module(full)


FAILED = "failed"
"""Key of a measurement that there is not, with the reason."""
Measure = Callable[..., object]
Found = Mapping[str, Sequence[Mapping[str, Any]]]
"""Measurements: by the name of a point, what the measuring function returned for each of its starts."""


@dataclass(frozen=True)
class Point:
    """One set of values, at which a law or another study is measured.

    Attributes
    ----------
    name : str
        Unique in its study.
    measure : str or callable
        Function at the top level of a module of the program, or name of one in ``measure.py`` of the study's folder.
        With a case it is called ``measure(run, **options)``, else ``measure(**options)``. It returns a dict of plain
        data.
    case : str, Case or None
        Case file, relative to the study's folder, or a case; None for a function without a run.
    changes : mapping
        Values of the case that this point changes, as ``--set``.
    starts : int
        Runs with their discs moved by 1e-6 diameters; 1 for a function.
    options : mapping
        Plain data, handed to the function by name.
    seconds : float
        Processor time of one start, about; weighs the line of progress.
    seed : int
        Of the first start; the others follow.
    dump : bool
        Whether the function reads the dump: a finished run without one is run again.
    judged : bool
        A run or call that fails is a finding too, ``{FAILED: reason}``, and is kept; else it is shown and tried again.
    patience : float
        s that one start may take.
    """

    name: str
    measure: str | Measure
    case: str | Case | None = None
    changes: Mapping[str, Any] = field(default_factory=dict)
    starts: int = 1
    options: Mapping[str, Any] = field(default_factory=dict)
    seconds: float = 1.0
    seed: int = 1
    dump: bool = True
    judged: bool = False
    patience: float = float("inf")

    @property
    def measure_name(self) -> str:
        """Name of the measuring function."""
        return self.measure if isinstance(self.measure, str) else self.measure.__name__


@dataclass(frozen=True)
class PointStudy:
    """A study with tables and a page in Markdown.

    Attributes
    ----------
    name : str
        Of its files: ``<name>.json``, ``<name>.md``, pictures ``<name>_*.png``.
    points : sequence of Point
    results : callable
        ``results(found, stored)``: the content of its JSON file; `stored` is the content so far. Pure.
    page : callable
        ``page(results)``: paragraphs of its page in Markdown. Pure.
    draw : callable
        ``draw(results, folder)``: draws its figures.
    told : callable
        ``told(point, start, measured)``: a line on a start, counted from 1; an empty one is not shown.
    opening : sequence of str
        Lines that are shown first.
    ending : callable
        ``ending(results)``: lines that are shown last.
    timed : bool
        Run one start at a time, and each point once before any again: they are timed.
    """

    name: str
    points: Sequence[Point]
    results: Callable[[Found, Results], Results]
    page: Callable[[Results], Sequence[str]]
    draw: Callable[[Results, Path], object] = lambda results, folder: None
    told: Callable[[Point, int, Any], str] = lambda point, start, measured: ""
    opening: Sequence[str] = ()
    ending: Callable[[Results], Sequence[str]] = lambda results: ()
    timed: bool = False


# --- work of a process: it runs one start of a point and measures it, or calls a function -----------------------------


class Task(NamedTuple):
    """One start of a point, as a worker takes it.

    Attributes
    ----------
    folder : Path
        Of the study.
    measure : str or callable
    options : mapping
        Of that function.
    member : Member or None
        What is run; None for a function without a run.
    store : Path
        Holds ``runs/``.
    dump : bool
        Whether the function reads the dump.
    again : bool
        Run again what is there.
    keep_dump : bool
    """

    folder: Path
    measure: str | Measure
    options: Mapping[str, Any]
    member: Member | None
    store: Path
    dump: bool = True
    again: bool = False
    keep_dump: bool = False


def function_of(task: Task) -> Measure:
    """Return the measuring function; CaseError where the folder has none of this name."""
    if not isinstance(task.measure, str):
        return task.measure
    function: Measure | None = getattr(load_module(task.folder, "measure"), task.measure, None)
    if function is None:
        raise CaseError(f"{task.folder / MEASURE_FILE}: has no function {task.measure}")
    return function


def work(task: Task) -> Any:
    """Return what the measuring function finds; a run that failed is a measurement with the reason alone."""
    function = function_of(task)
    try:
        return plain(function(**task.options) if task.member is None else _measured(task, task.member, function))
    except RunInterrupted:
        raise
    except JumpError as error:
        return failed(str(error))


def failed(reason: str) -> dict[str, str]:
    """Return the measurement that there is not."""
    return {FAILED: reason}


def _measured(task: Task, member: Member, function: Measure) -> object:
    require_no_links([member], task.store)
    folder = member.folder(task.store)
    stage = state_of(member, task.store).stage
    there = stage == "done" and not task.again
    if there and task.dump:
        there = has_dump(folder)
    if not there:
        run_member(member, task.store, stage in ("done", "failed"), True)
    result = function(open_run(folder), **task.options)
    if not task.keep_dump:
        drop_dumps(member, task.store)
    return result


# --- the starts of all points as pieces of a store: their keys, the calls that make them, the results ----------------


class StartJob(NamedTuple):
    """One start of a point: whose it is, its number from 1, the key of its result, what makes it, the run it is of."""

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
) -> list[StartJob]:
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
    jobs = []
    for point in points:
        about = {"measure": point.measure_name, "options": plain(point.options), "text": text}
        hashed = short_hash(about)
        try:
            members = members_of(point, folder)
        except JumpError as error:
            if not point.judged:
                raise
            request = {**about, "changes": plain(point.changes), "refused": str(error)}
            key = f"{owner} refused {short_hash(request)}"
            refused = partial(failed, str(error))
            jobs += [StartJob(owner, point, start, f"{key} {start}", refused) for start in range(1, point.starts + 1)]
            continue
        for start, member in enumerate(members, 1):
            key = f"{owner} {hashed}" if member is None else f"{owner} {member.key}-{hashed}"
            place, again = folder or Path(), fresh and not point.dump
            task = Task(place, point.measure, point.options, member, store, point.dump, again, keep_dumps)
            jobs.append(StartJob(owner, point, start, key, partial(work, task), member))
    return jobs


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


def forget(pieces: Iterable[StartJob], store: Store, *, fresh: bool = False) -> None:
    """Take out of a store what failed and is no finding, so that it is tried again; with `fresh` all pieces."""
    for piece in pieces:
        if fresh or (not piece.point.judged and FAILED in store.pieces.get(piece.key, ())):
            store.pieces.pop(piece.key, None)


def measure(pieces: Sequence[StartJob], store: Store, pool: Pool, watch: Watch) -> None:
    """Make the pieces that a store lacks, begun in their order; those with the same patience together."""
    for patience in dict.fromkeys(piece.point.patience for piece in pieces):
        some = [piece for piece in pieces if piece.point.patience == patience]
        calls, keys = [piece.call for piece in some], [piece.key for piece in some]
        store.call(calls, pool, keys=keys, watch=watch, otherwise=lost, patience=patience)


def lost(outcome: CallOutcome) -> dict[str, str]:
    """Return the measurement of a call that did not return: the reason alone."""
    return failed(f"{outcome.kind}: {outcome.value}")


def found_of(pieces: Iterable[StartJob], store: Store) -> dict[str, list[Any]]:
    """Return what was measured at each point, starts in their order; `FAILED` ones of judged points among them."""
    by_point: dict[str, list[Any]] = {}
    for piece in pieces:
        measured, ones = store.pieces[piece.key], by_point.setdefault(piece.point.name, [])
        if piece.point.judged or FAILED not in measured:
            ones.append(measured)
    return by_point


def failures_of(pieces: Iterable[StartJob], store: Store) -> list[str]:
    """Return what failed and is no finding, a line each."""
    return [
        f"{piece.point.name}: {measured[FAILED]}"
        for piece in pieces
        if not piece.point.judged and FAILED in (measured := store.pieces[piece.key])
    ]


# --- A study of points and tables, run: the points that its store lacks, its JSON file, its page and figures ----------


class ProgressLines:
    """Tells a line for each start that is made."""

    def __init__(self, study: PointStudy, pieces: Sequence[StartJob], say: Say):
        self.pieces = {piece.key: piece for piece in reversed(pieces)}  # a run of two points is reported for the first
        self.study, self.say = study, say

    def heard(self, key: str, news: object) -> None:
        """Nothing is shown of a run on its way."""

    def ended(self, key: str, measured: Any) -> None:
        """Shows the result of a start."""
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
            measure(order, store, pool, ProgressLines(study, pieces, say))
        if failures := failures_of(pieces, store):
            raise RunError(failures[0])
        summary: Results = plain(study.results(found_of(pieces, store), store.data))
        for line in study.ending(summary):
            say(line)
        study.draw(summary, folder)
        text = store.finish(paragraphs(*study.page(summary)), **summary)
        return store.data, text


def by_turns(pieces: Sequence[StartJob]) -> Iterator[StartJob]:
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
    study = make(**options) if callable(make) else None
    if not isinstance(study, PointStudy):
        raise CaseError(
            f"{folder / STUDY_FILE}: has no function study that returns a PointStudy; CONTRIBUTING.md has one"
        )
    return study, folder


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
