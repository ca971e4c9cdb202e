# SPDX-License-Identifier: GPL-2.0-or-later
"""Find the value of a number of a case at which a result comes to what is asked: a range, starts, an answer with its ±.

The points are those of a study in the folder ``points``: nothing is run twice, and an interrupted search goes on.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import floor, isfinite, log10
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import yaml
from pydantic import Field, ValidationError

from lammps_jump.analysis.draw.style import BLACK, BLUE, GREY, RED, drawing, save
from lammps_jump.analysis.report.page import Boxes, NumberBox, Section, Table, Text, picture
from lammps_jump.case.case import ReadCase
from lammps_jump.case.explain import explain
from lammps_jump.case.parts.base import Strict, Whole
from lammps_jump.case.text import CaseSource, read_source
from lammps_jump.errors import CaseError, FieldError
from lammps_jump.files import STUDY_FILES, plain, read_json, write_json, write_text
from lammps_jump.folders import Marker, require_no_link
from lammps_jump.foreign import number_of
from lammps_jump.provenance import usable_cores, versions
from lammps_jump.quoting import shortened
from lammps_jump.runs.folder import run_folder
from lammps_jump.runs.run import Case
from lammps_jump.runs.summary import read_summary
from lammps_jump.units import ABSENT, Plain, shown

from .crossing import Crossed, CrossingSearch, all_on_one_side
from .members import failure_message, run_members
from .page import write_study_page
from .pool import Pool
from .study import MOST_MEMBERS, MOST_RUNS, ZIP, Study, case_in, collected, read_study
from .sweep import Board, Sweep, SweepProgress, held_study, prepare
from .table import number_at
from .words import heading, unit, words

ANSWER, PAGE, POINTS = "find.json", "find.html", "points"
BUDGET, MEMBERS = 30, 3
"""Most runs, and starts of each point, where none are given."""
UNTIL = re.compile(r"\s*([A-Za-z][\w.]*)\s*(>=|<=|≥|≤|>|<)\s*(\S+)\s*")


class Asked(Strict):
    """The part ``find`` of a study file."""

    vary: dict[str, tuple[Plain, Plain]] = Field(min_length=1, max_length=1)
    until: str
    members: Annotated[Whole, Field(ge=1, le=MOST_MEMBERS)] = MEMBERS
    budget: Annotated[Whole, Field(ge=3, le=MOST_RUNS)] = BUDGET
    seed: Annotated[Whole, Field(ge=0)] = 1


class FindFields(Strict):
    """A study file that finds a number."""

    case: str | dict[str, Any]
    set: dict[str, Any] = Field(default_factory=dict)
    find: Asked


@dataclass(frozen=True)
class Wanted:
    """Number that is looked for and what is asked, read and checked.

    Attributes
    ----------
    case : Case
    path : str
        The number that is varied.
    room : (float, float)
        Its range.
    key : str
        The number of ``summary.json``.
    sign : {'>=', '<='}
    number : float
    members, budget : int
        Starts of each point, and most runs.
    seed : int
        Of the first start.
    """

    case: Case
    path: str
    room: tuple[float, float]
    key: str
    sign: str
    number: float
    members: int
    budget: int
    seed: int = 1

    @property
    def until(self) -> str:
        """Condition in the words of the command line."""
        return f"{self.key} {self.sign} {self.number:zg}"

    def study(self, places: Sequence[float]) -> Study:
        """The points as a study, each with starts of its own."""
        axes = {ZIP: {self.path: list(places)}}
        seeds = list(range(self.seed, self.seed + self.members))
        return read_study(self.case, axes=axes, members=seeds, starts="own", collect=[self.key])

    def rounded(self, place: float) -> float:
        """A place with six digits of the range: a case is to be read."""
        digits = 5 - floor(log10(self.room[1] - self.room[0]))
        return min(max(round(place, digits), self.room[0]), self.room[1])

    def to_yaml(self) -> str:
        """The study as YAML, with the whole case in it, so that the folder can be moved."""
        asked = {"vary": {self.path: list(self.room)}, "until": self.until, "members": self.members}
        data = {
            "find": {**asked, "budget": self.budget, "seed": self.seed},
            "case": yaml.safe_load(self.case.to_yaml()),
        }
        return yaml.safe_dump(plain(data), sort_keys=False, allow_unicode=True, width=110, default_flow_style=None)


def parse_condition(text: str) -> tuple[str, str, float]:
    """Key, sign and number of ``KEY >= NUMBER``.

    Raises
    ------
    CaseError
        Another text.
    """
    found = UNTIL.fullmatch(text)
    try:
        number = number_of(found[3]) if found else np.nan
    except ValueError:
        number = np.nan
    if found is None or not isfinite(number):
        raise CaseError(
            f"--until {shortened(text)}: expected a number of summary.json, >= or <=, and a value, for example "
            '--until "stability.tower.sliding_factor_least >= 1.2"'
        )
    return found[1], ">=" if found[2] in (">=", "≥", ">") else "<=", number


def read_find(source: str | Path | Mapping[str, object] | ReadCase, **given: Any) -> Wanted:
    """Read and check what is to be found.

    Parameters
    ----------
    source : str, Path, mapping or Case
        A case, its file, a study file with ``find``, or the folder of an earlier search.
    given
        set, and fields of ``find`` in place of those of the source.

    Raises
    ------
    CaseError
        One paragraph with the field, what is allowed and what to do.
    """
    file, place = _source(source)
    changes = given.pop("set", None)
    file.data["set"] = {**(file.data.get("set") or {}), **(changes or {})}
    asked = file.data.get("find") or {}
    file.data["find"] = {**asked, **{name: value for name, value in given.items() if value is not None}}
    for name, example in (("vary", "contact.friction=0.1:0.9"), ("until", '"jump.y2 >= 2"')):
        if not file.data["find"].get(name):
            raise CaseError(f"{file.file}: no {name}: say what is varied and what is asked, --{name} {example}")
    try:
        fields = FindFields.model_validate(file.data)
    except ValidationError as error:
        raise explain(error, file, FindFields) from None
    whole = fields.case
    case = Case.load(whole, fields.set) if isinstance(whole, dict) else case_in(place / whole, fields.set)
    (path, (low, high)), *_ = fields.find.vary.items()
    key, sign, number = parse_condition(fields.find.until)
    try:
        if not low < high:
            raise FieldError(f"find.vary.{path}", f"{low:zg} to {high:zg} is no range; the first must be the smaller")
        collected(key, case, "until")
        case.replace({path: low}), case.replace({path: high})
    except FieldError as error:
        raise file.located(error) from None
    asked = fields.find
    return Wanted(case, path, (low, high), key, sign, number, asked.members, asked.budget, asked.seed)


def _source(source: str | Path | Mapping[str, object] | ReadCase) -> tuple[CaseSource, Path]:
    """Data of a study, and the folder that its case is relative to."""
    if isinstance(source, ReadCase):
        source = {"case": yaml.safe_load(source.to_yaml())}
    if isinstance(source, Mapping):
        data = dict(source) if "case" in source else {"case": dict(source)}
        return CaseSource("<study>", plain(data)), Path()
    path = Path(source) / "study.yaml" if (Path(source) / "study.yaml").is_file() else Path(source)
    file = read_source(path)
    if "case" not in file.data and {"discs", "run"} & file.data.keys():
        file.data = {"case": path.name}
    return file, path.parent


def find(
    case: str | Path | Mapping[str, Any] | ReadCase,
    vary: Mapping[str, Sequence[float]] | None = None,
    until: str | None = None,
    out: str | Path | None = None,
    *,
    budget: int | None = None,
    jobs: int | None = None,
    progress: Callable[[SweepProgress], None] = lambda progress: None,
    **more: Any,
) -> dict[str, Any]:
    """Find the value of a number at which a result comes to what is asked; what the folder holds is not run again.

    Parameters
    ----------
    case : str, Path, mapping or Case
        A case, its file, a study file with ``find``, or the folder of an earlier search.
    vary : mapping, optional
        The number that is varied, and its range: ``{"bodies.tower.friction": (0.2, 0.9)}``.
    until : str, optional
        ``"stability.tower.sliding_factor_least >= 1.2"``; units are those of ``summary.json``.
    out : str or Path, optional
        Default ``runs/<stem of the file>_find``.
    budget : int, optional
        Most runs; default 30.
    jobs : int, optional
        Processes at once.
    progress : callable, optional
        Called with a `SweepProgress`.
    more
        members, starts of each point, default 3; seed, of the first of them; set, changed values of the case.

    Returns
    -------
    dict
        What ``find.json`` holds: ``value``, ``low`` and ``high`` (95 %), ``held``, ``reason``, ``runs``, ``verdict`` …

    Raises
    ------
    CaseError, SetupError
        Before anything is run: a field that cannot be used, a folder in use.
    RunInterrupted
        Ctrl-C or SIGTERM; the same call goes on.
    """
    wanted = read_find(case, vary=vary, until=until, budget=budget, **more)
    stem = Path(case).stem if isinstance(case, str | Path) else wanted.case.name
    own = isinstance(case, str | Path) and Path(case).is_dir()
    folder = Path(out) if out is not None else Path(str(case)) if own else Path("runs") / f"{stem}_find"
    ranks = wanted.case.fields.engine.ranks
    most = jobs or max(1, usable_cores() // (ranks if isinstance(ranks, int) else 1))
    wanted.study(wanted.room).case.scene()  # what cannot be run is refused before the folder is made
    with run_folder(folder, Marker("find", STUDY_FILES["find"], {})), Pool(min(most, wanted.members)) as pool:
        write_text(folder / "study.yaml", wanted.to_yaml())
        tried, failures = _searched(wanted, folder, pool, progress)
        pool.close()
        return _write(wanted, folder, tried, failures)


def _searched(
    wanted: Wanted, folder: Path, pool: Pool, progress: Callable[[SweepProgress], None]
) -> tuple[dict[float, np.ndarray], list[dict[str, Any]]]:
    """Values at the places that were tried, in their order, and runs without one."""
    search = CrossingSearch(wanted.number, wanted.room, max(3, wanted.budget // wanted.members))
    tried: dict[float, np.ndarray] = {}
    failures: list[dict[str, Any]] = []
    while (place := search.next_place(tried)) is not None:
        if len(tried) == 3 and all_on_one_side(tried, wanted.number):
            break  # both ends and the middle are surely on one side
        place = wanted.rounded(place)
        if place in tried:
            break  # no more digits
        found = Sweep(wanted.study([*tried, place]), folder / POINTS)
        with held_study(found.folder):
            prepare(found)
            board = Board(found, False, lambda now: progress(replace(now, total=wanted.budget)))
            states = found.states
            run_members(found.members, states, found.folder, pool, ended=board.ended, news=board.heard)
        here = [member for member in found.members if member.point == len(tried)]
        values = []
        for member in here:
            state = states[member.key]
            done = state.stage == "done"
            value = number_at(read_summary(member.folder(found.folder)), wanted.key) if done else np.nan
            values.append(value)
            if not isfinite(value):
                why = f"it has no {wanted.key}" if done else failure_message(state) or state.stage
                failures.append({"value": place, "seed": member.seed, "message": why})
        tried[place] = np.array(values)
    return tried, failures


def _write(
    wanted: Wanted, folder: Path, tried: Mapping[float, np.ndarray], failures: list[dict[str, Any]]
) -> dict[str, Any]:
    """Write ``find.json``, the figure and the page; what the first holds."""
    search = CrossingSearch(wanted.number, wanted.room, max(3, wanted.budget // wanted.members))
    answer = search.answer(tried)
    held, reason = isfinite(answer.value), _why_not(wanted, tried, answer)
    above = (wanted.sign == ">=") == answer.rises
    data = plain({
        "path": wanted.path, "range": list(wanted.room), "until": wanted.until, "value": answer.value if held else None,
        "low": answer.low if held else None, "high": answer.high if held else None, "held": held,
        "holds": ("above" if above else "below") if held else None, "reason": reason,
        "verdict": _verdict(wanted, answer, reason), "runs": sum(map(len, tried.values())), "failed": len(failures),
        "failures": failures, "members": wanted.members, "budget": wanted.budget, "seed": wanted.seed,
        "points": [{"value": place, "found": values.tolist()} for place, values in tried.items()],
        "name": wanted.case.name, "description": wanted.case.fields.description, "versions": versions(),
    })  # fmt: skip
    write_json(folder / ANSWER, data, indent=2)
    drawn = _draw(wanted, tried, answer, folder)
    write_study_page(folder / PAGE, "find", wanted.case, data["verdict"], _sections(wanted, data, drawn))
    found: dict[str, Any] = read_json(folder / ANSWER)
    return found


def _why_not(wanted: Wanted, tried: Mapping[float, np.ndarray], answer: Crossed) -> str | None:
    """Why there is no answer, or what to know of it; None where there is nothing to say."""
    known = [values[np.isfinite(values)].mean() for values in tried.values() if np.isfinite(values).any()]
    low, high = (f"{end:zg}" for end in wanted.room)
    if not known:
        return f"no run has {wanted.key}"
    if not isfinite(answer.value):
        told = f"{wanted.key} goes from {min(known):z.4g} to {max(known):z.4g} there"
        return f"the range from {low} to {high} does not hold it: {told}"
    wide = wanted.room[1] - wanted.room[0]
    at_ends = [
        end for end, here in zip(wanted.room, (answer.low, answer.high), strict=True) if abs(here - end) < 1e-9 * wide
    ]
    return f"its 95 % range ends at an end of the range, {at_ends[0]:zg}: give a wider one" if at_ends else None


def _verdict(wanted: Wanted, answer: Crossed, reason: str | None) -> str:
    if not isfinite(answer.value):
        return f"No {wanted.path} with {wanted.until} was found: {reason}."
    above = (wanted.sign == ">=") == answer.rises
    ends = f"{_brief(wanted, answer.low)} to {_brief(wanted, answer.high)}"
    more = f" But {reason}." if reason else ""
    where = f"{'above' if above else 'below'} {_brief(wanted, answer.value)}"
    return f"{wanted.until} holds for {wanted.path} {where} (95 %: {ends}).{more}"


def _brief(wanted: Wanted, value: float) -> str:
    """A place with four digits of the range."""
    return f"{round(value, 3 - floor(log10(wanted.room[1] - wanted.room[0]))):zg}"


def _draw(wanted: Wanted, tried: Mapping[float, np.ndarray], answer: Crossed, folder: Path) -> Path:
    """Draw the values of all runs over the varied number, with the answer."""
    place = folder / "figures"
    require_no_link(place)
    place.mkdir(exist_ok=True)
    with drawing(6.4, 4.0, 1, 1) as (figure, panel):
        x = np.concatenate([np.full(len(values), at) for at, values in tried.items()])
        y = np.concatenate(list(tried.values()))
        panel.plot(x, y, "o", ms=4, mfc="white", color=BLACK, label="runs")
        panel.axhline(wanted.number, color=GREY, lw=1, ls="--", label=wanted.until)
        if isfinite(answer.value):
            panel.axvspan(answer.low, answer.high, color=BLUE, alpha=0.2, lw=0, label="95 %")
            panel.axvline(answer.value, color=RED, lw=1.2, label="answer")
        panel.set(xlabel=heading(wanted.path), ylabel=wanted.key, xlim=wanted.room)
        panel.legend()
        return save(figure, place / "find.png")


def _sections(wanted: Wanted, data: Mapping[str, Any], drawn: Path) -> list[Section]:
    held = data["held"]
    span = f"95 %: {_brief(wanted, data['low'])} to {_brief(wanted, data['high'])}" if held else ""
    value = _brief(wanted, data["value"]) if held else ABSENT
    box = NumberBox(words(wanted.path), value, unit(wanted.path), "", span)
    rows = [
        [one["value"], shown(known.mean()) if known.size else ABSENT, ", ".join(shown(v) for v in one["found"])]
        for one in sorted(data["points"], key=lambda one: one["value"])
        for known in [np.array([v for v in one["found"] if v is not None])]
    ]
    blocks: list[Any] = [Boxes([box]), Text(data["reason"] or "", "warn"), picture(drawn, "All runs, and the answer")]
    failed = [
        Text(f"{wanted.path} = {f['value']:zg}, seed {f['seed']}: {f['message']}", "small") for f in data["failures"]
    ]
    about = f"{data['runs']} runs, {data['members']} starts of each value, of at most {data['budget']}."
    table = Table(rows, (heading(wanted.path), f"{wanted.key}, mean", "starts"))
    return [Section("", blocks), Section("Runs", [table, Text(about, "small"), *failed])]
