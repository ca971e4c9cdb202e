# SPDX-License-Identifier: GPL-2.0-or-later
"""Finds the value of a number of a case at which a result meets a given target: a range, starts, an answer with its ±.

The points are those of a study in the folder ``points``: nothing is run twice, and an interrupted search goes on.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import floor, isfinite, log10, nan
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
import yaml
from pydantic import Field, ValidationError

from lammps_jump.analysis.budgets.inflow import shortfall
from lammps_jump.analysis.draw.style import BLACK, BLUE, GREY, RED, drawing, save
from lammps_jump.analysis.report.page import Boxes, NumberBox, Section, Table, Text, picture
from lammps_jump.analysis.tables import value_at
from lammps_jump.case.base import Strict, Whole
from lammps_jump.case.case import ReadCase
from lammps_jump.case.field_words import explain
from lammps_jump.case.text import CaseSource, read_source
from lammps_jump.errors import CaseError, FieldError
from lammps_jump.files import STUDY_FILES, plain, read_json, write_json, write_text
from lammps_jump.folders import Marker, read_marker, require_no_link
from lammps_jump.provenance import usable_cores, versions
from lammps_jump.quoting import shortened
from lammps_jump.runs.folder import run_folder
from lammps_jump.runs.run import Case
from lammps_jump.runs.summary import read_summary
from lammps_jump.units import ABSENT, POWERS, Plain, Share, shown, to_si

from .crossing import CrossingPlace, CrossingSearch, all_on_one_side, normal, scatter_of
from .members import failure_message, run_members
from .page import write_study_page
from .pool import Pool
from .study import (
    MOST_MEMBERS,
    MOST_RUNS,
    ZIP,
    Study,
    axis_heading,
    axis_unit,
    axis_words,
    case_in,
    collected,
    read_study,
)
from .sweep import Board, Sweep, SweepProgress, held_study, prepare
from .table import number_at

ANSWER, PAGE, POINTS = "find.json", "find.html", "points"
BUDGET, MEMBERS = 30, 3
"""Most runs, and starts of each point, where none are given."""
UNTIL = re.compile(r"\s*([A-Za-z][\w.]*)\s*(>=|<=|≥|≤|>|<)\s*(\S.*?)\s*")
EQUAL = re.compile(r"\s*([A-Za-z][\w.]*)\s*==?\s*(\S.*?)\s*")
EDGE = re.compile(r"(bodies|walls)\.(\w+)\.([xy])\.([01])")
SIZES = {"x": "width", "y": "height"}
"""Size of a block along each axis."""


class FindRequest(Strict):
    """The part ``find`` of a study file."""

    vary: dict[str, tuple[Plain, Plain]] = Field(min_length=1, max_length=1)
    until: str
    members: Annotated[Whole, Field(ge=1, le=MOST_MEMBERS)] = MEMBERS
    budget: Annotated[Whole, Field(ge=3, le=MOST_RUNS)] = BUDGET
    seed: Annotated[Whole, Field(ge=0)] = 1
    share: Share | None = None


class FindFields(Strict):
    """A study file that finds a number."""

    case: str | dict[str, Any]
    set: dict[str, Any] = Field(default_factory=dict)
    find: FindRequest


@dataclass(frozen=True)
class RootProblem:
    """Root-finding problem: the number that is varied, and the value that a result is to come to; read and checked.

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
    share : float or None
        Share of the starts that is to hold; None: the mean over starts is.
    unit : str
        Of the number of ``summary.json``.
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
    share: float | None = None
    unit: str = ""

    @property
    def until(self) -> str:
        """Condition in the words of the command line, SI."""
        return f"{self.key} {self.sign} {self.number:zg}"

    @property
    def asked(self) -> str:
        """The same with its unit."""
        return f"{self.key} {self.sign} {shown(self.number, self.unit)}"

    @property
    def where(self) -> str:
        """Share of the starts in which it is to hold, in words; empty for their mean."""
        return f" in {100 * self.share:zg} % of starts" if self.share is not None else ""

    @property
    def across(self) -> float:
        """The other edge of the block whose edge is varied, m; NaN where another number is."""
        found = EDGE.fullmatch(self.path)
        edges = self.case[f"{found[1]}.{found[2]}.{found[3]}"] if found else None
        both = isinstance(edges, Sequence) and not isinstance(edges, str) and len(edges) == 2
        return float(edges[1 - int(found[4])]) if found and both and edges else nan

    def number_for(self, scatter: float) -> float:
        """The number that the mean has to come to, so that the share of starts with this standard deviation holds."""
        if self.share is None:
            return self.number
        return self.number + (1 if self.sign == ">=" else -1) * normal(self.share) * scatter

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
        if self.share is not None:
            data["find"]["share"] = self.share
        return yaml.safe_dump(plain(data), sort_keys=False, allow_unicode=True, width=110, default_flow_style=None)


class Condition(NamedTuple):
    """Condition on a number of ``summary.json``: its key, the sign, and a value that may have a unit."""

    key: str
    sign: str
    value: str

    def number(self, unit: str) -> float:
        """Its value in the unit of the key.

        Raises
        ------
        CaseError
            It is no number, or its unit is of another dimension.
        """
        try:
            return float(to_si(self.value, unit))
        except ValueError as error:
            raise CaseError(f"--until {self.key} {self.sign} {shortened(self.value)}: {error}") from None


def parse_condition(text: str) -> Condition:
    """Read ``KEY >= NUMBER``, where the number may have a unit.

    Raises
    ------
    CaseError
        Another text.
    """
    if match := UNTIL.fullmatch(text):
        return Condition(match[1], ">=" if match[2] in (">=", "≥", ">") else "<=", match[3])
    if equal := EQUAL.fullmatch(text):
        key, value = (shortened(part) for part in equal.groups())
        raise CaseError(
            f"--until {shortened(text)}: what is found is where a number passes a limit; write "
            f'"{key} >= {value}" where more is wanted, or "{key} <= {value}" where less is'
        )
    raise CaseError(
        f"--until {shortened(text)}: expected a number of summary.json, >= or <=, and a value, for example "
        '--until "stability.tower.sliding_factor_least >= 1.2" or --until "stability.tower.slid_by <= 30 cm"'
    )


def read_find(source: str | Path | Mapping[str, object] | ReadCase, **given: Any) -> RootProblem:
    """Reads and checks the target of a search.

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
    request = file.data.get("find") or {}
    file.data["find"] = {**request, **{name: value for name, value in given.items() if value is not None}}
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
    until = parse_condition(fields.find.until)
    try:
        if not low < high:
            raise FieldError(f"find.vary.{path}", f"{low:zg} to {high:zg} is no range; the first must be the smaller")
        unit = collected(until.key, case, "until").unit
        case.replace({path: low}), case.replace({path: high})
        _require_fractions(case, path, (low, high))
    except FieldError as error:
        raise file.located(error) from None
    one, number = fields.find, until.number(unit)
    if one.share is not None and one.members < 2:
        raise CaseError("--share: how starts scatter is needed, so that --members must be 2 or more")
    how = one.members, one.budget, one.seed, one.share
    return RootProblem(case, path, (low, high), until.key, until.sign, number, *how, unit)


def _require_fractions(case: Case, path: str, room: tuple[float, float]) -> None:
    """Refuse a number that takes whole ones alone: the search goes between them, and would end at its first middle.

    Raises
    ------
    FieldError
    """
    between = room[0] + 0.618 * (room[1] - room[0])
    if all(end == int(end) for end in room) and between != int(between):
        try:
            case.replace({path: between})
        except CaseError as error:
            if "fractional part" not in str(error):
                return  # what a value between the ends lacks else is reported where it is tried
            raise FieldError(
                f"find.vary.{path}",
                "takes whole numbers alone, and a search goes between them; "
                f"`sweep --axis {path}={room[0]:zg},…` shows each",
            ) from None


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
    """Finds the value of a number at which a result meets a given target; what the folder holds is not run again.

    Parameters
    ----------
    case : str, Path, mapping or Case
        A case, its file, a study file with ``find``, or the folder of an earlier search.
    vary : mapping, optional
        The number that is varied, and its range: ``{"bodies.tower.friction": (0.2, 0.9)}``.
    until : str, optional
        ``"stability.tower.sliding_factor_least >= 1.2"`` or ``"stability.tower.slid_by <= 30 cm"``; a number without a
        unit has that of ``summary.json``.
    out : str or Path, optional
        Default ``runs/<stem of the file>_find``.
    budget : int, optional
        Most runs; default 30.
    jobs : int, optional
        Processes at once.
    progress : callable, optional
        Called with a `SweepProgress`.
    more
        members, starts of each point, default 3; seed, of the first of them; share, of the starts that is to hold, such
        as 0.95, in place of their mean; set, changed values of the case.

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
    problem = read_find(case, vary=vary, until=until, budget=budget, **more)
    stem = Path(case).stem if isinstance(case, str | Path) else problem.case.name
    own = isinstance(case, str | Path) and Path(case).is_dir()
    folder = Path(out) if out is not None else Path(str(case)) if own else Path("runs") / f"{stem}_find"
    ranks = problem.case.fields.engine.ranks
    most = jobs or max(1, usable_cores() // (ranks if isinstance(ranks, int) else 1))
    problem.study(problem.room).case.scene()  # what cannot be run is refused before the folder is made
    with run_folder(folder, Marker("find", STUDY_FILES["find"], {})), Pool(min(most, problem.members)) as pool:
        write_text(folder / "study.yaml", problem.to_yaml())
        searched = _searched(problem, folder, pool, progress)
        pool.close()
        return write_answer(problem, folder, searched)


def runs_of_search(folder: Path) -> Path | None:
    """The study of its runs in the folder of a search; None where the folder holds something else."""
    marker = read_marker(folder)
    return folder / POINTS if marker is not None and marker.kind == "find" else None


class SearchedPlaces(NamedTuple):
    """Values at the places that were tried, in their order, runs without one, and what came in and went over."""

    tried: dict[float, np.ndarray]
    failures: list[dict[str, Any]]
    waters: list[Mapping[str, Any]]


def search_for(problem: RootProblem, tried: Mapping[float, np.ndarray]) -> CrossingSearch:
    """The search, given what has been tried: with a share of the starts its number goes with their scatter."""
    number = problem.number_for(scatter_of(tried).value)
    return CrossingSearch(number, problem.room, max(3, problem.budget // problem.members))


def _searched(
    problem: RootProblem, folder: Path, pool: Pool, progress: Callable[[SweepProgress], None]
) -> SearchedPlaces:
    """Run what is needed, place by place."""
    tried: dict[float, np.ndarray] = {}
    failures: list[dict[str, Any]] = []
    waters: list[Mapping[str, Any]] = []
    while (place := search_for(problem, tried).next_place(tried)) is not None:
        if len(tried) == 3 and (_none_has_it(tried) or all_on_one_side(tried, search_for(problem, tried).number)):
            break  # both ends and the middle have no number, or are surely on one side
        place = problem.rounded(place)
        if place in tried:
            break  # no more digits
        sweep = Sweep(problem.study([*tried, place]), folder / POINTS)
        with held_study(sweep.folder):
            prepare(sweep)
            board = Board(sweep, False, lambda now: progress(replace(now, total=problem.budget)))
            states = sweep.states
            run_members(sweep.members, states, sweep.folder, pool, ended=board.ended, news=board.heard)
        here = [member for member in sweep.members if member.point == len(tried)]
        values = []
        for member in here:
            state = states[member.key]
            done = state.stage == "done"
            summary = read_summary(member.folder(sweep.folder)) if done else {}
            value = number_at(summary, problem.key)
            waters.append({name: summary.get(name) for name in ("inflow", "overtopping")})
            values.append(value)
            if not isfinite(value):
                why = _why_absent(summary, problem.key) if done else failure_message(state) or state.stage
                failures.append({"value": place, "seed": member.seed, "message": why})
        tried[place] = np.array(values)
    return SearchedPlaces(tried, failures, waters)


def _why_absent(summary: Mapping[str, Any], key: str) -> str:
    """Why a run that is complete has no such number: the reason that is given next to it, where there is one."""
    part = value_at(summary, key.rpartition(".")[0])
    reason = part.get("reason") if isinstance(part, Mapping) else None
    return f"it has no {key}" + (f": {reason}" if isinstance(reason, str) else "")


def _none_has_it(tried: Mapping[float, np.ndarray]) -> bool:
    return not any(np.isfinite(values).any() for values in tried.values())


def answer_of(problem: RootProblem, tried: Mapping[float, np.ndarray]) -> CrossingPlace:
    """The answer by what was tried; for a share of the starts its range holds what is not known of their scatter."""
    scatter = scatter_of(tried)
    searches = [search_for(problem, tried)]
    if problem.share is not None:
        most = searches[0].most
        ends = (problem.number_for(end) for end in (scatter.low, scatter.high))
        searches += [CrossingSearch(end, problem.room, most) for end in ends]
    best, *others = [one.answer(tried) for one in searches]
    if not isfinite(best.value):
        return best
    lows = [one.low if isfinite(one.value) else best.low for one in others]
    highs = [one.high if isfinite(one.value) else best.high for one in others]
    if any(not isfinite(one.value) for one in others):  # with more scatter no place of the range holds
        lows, highs = [*lows, problem.room[0]], [*highs, problem.room[1]]
    return best._replace(low=min([best.low, *lows]), high=max([best.high, *highs]))


def write_answer(problem: RootProblem, folder: Path, ran: SearchedPlaces) -> dict[str, Any]:
    """Write ``find.json``, the figure and the page; what the first holds."""
    tried, failures = ran.tried, ran.failures
    answer = answer_of(problem, tried)
    held, reason = isfinite(answer.value), _why_not(problem, ran, answer)
    above = (problem.sign == ">=") == answer.rises
    short = shortfall(ran.waters)
    data = plain({
        "path": problem.path, "range": list(problem.room), "until": problem.until,
        "value": answer.value if held else None, "low": answer.low if held else None,
        "high": answer.high if held else None, "held": held,
        "holds": ("above" if above else "below") if held else None, "reason": reason,
        "unit": axis_unit(problem.path), "size": _size(problem, answer),
        "verdict": sentence_of(problem, tried, answer, reason),
        "notes": [short] if short else [], "runs": sum(map(len, tried.values())), "failed": len(failures),
        "failures": failures, "members": problem.members, "budget": problem.budget, "seed": problem.seed,
        "share": problem.share,
        "points": [{"value": place, "found": values.tolist()} for place, values in tried.items()],
        "name": problem.case.name, "description": problem.case.fields.description, "versions": versions(),
    })  # fmt: skip
    write_json(folder / ANSWER, data, indent=2)
    drawn = _draw(problem, tried, answer, folder)
    write_study_page(folder / PAGE, "find", problem.case, data["verdict"], _sections(problem, data, drawn))
    found: dict[str, Any] = read_json(folder / ANSWER)
    return found


def _why_not(problem: RootProblem, ran: SearchedPlaces, answer: CrossingPlace) -> str | None:
    """Why there is no answer, or what to know of it; None where there is nothing to say."""
    tried = ran.tried
    known = [values[np.isfinite(values)].mean() for values in tried.values() if np.isfinite(values).any()]
    low, high = (f"{end:zg}" for end in problem.room)
    if not known:
        first = ran.failures[0]
        return f"no run has {problem.key}; at {first['value']:zg}, seed {first['seed']}: {first['message']}"
    if not isfinite(answer.value):
        sentence = f"{problem.key} goes from {min(known):z.4g} to {max(known):z.4g} there"
        return f"the range from {low} to {high} does not hold it: {sentence}"
    wide = problem.room[1] - problem.room[0]
    at_ends = [
        end for end, here in zip(problem.room, (answer.low, answer.high), strict=True) if abs(here - end) < 1e-9 * wide
    ]
    return f"its 95 % range ends at an end of the range, {at_ends[0]:zg}: give a wider one" if at_ends else None


def _size(problem: RootProblem, answer: CrossingPlace) -> dict[str, Any] | None:
    """Size of the block whose edge is the answer, with its range; None where the answer is no edge of one."""
    other, match = problem.across, EDGE.fullmatch(problem.path)
    if match is None or not isfinite(other) or not isfinite(answer.value):
        return None
    low, high = sorted(abs(end - other) for end in (answer.low, answer.high))
    return {"what": SIZES[match[3]], "value": abs(answer.value - other), "low": low, "high": high}


def sentence_of(
    problem: RootProblem, tried: Mapping[float, np.ndarray], answer: CrossingPlace, reason: str | None
) -> str:
    """The answer in words: the value with its unit, the size that it makes, and how sure it is that a start holds."""
    if not isfinite(answer.value):
        return f"No value of {_named(problem.path)} with {problem.asked}{problem.where} was found: {reason}."
    above = (problem.sign == ">=") == answer.rises
    side, more = "above" if above else "below", f" But {reason}." if reason else ""
    ranged = _ranged(problem, *answer[:3], axis_unit(problem.path))
    sentence = f"{problem.asked} holds{problem.where} for {_named(problem.path)} {side} {ranged}."
    if size := _size(problem, answer):
        wider = answer.value > problem.across if above else answer.value < problem.across
        ranged = _ranged(problem, size["value"], size["low"], size["high"], "m")
        sentence += f" That is a {size['what']} {'above' if wider else 'below'} {ranged}."
    return f"{sentence}{_sureness(problem, tried)}{more}"


def _sureness(problem: RootProblem, tried: Mapping[float, np.ndarray]) -> str:
    """Sentence on what the answer means for one start; empty where starts do not differ."""
    scatter = scatter_of(tried)
    if problem.members < 2:
        return " Each value has one start; how starts differ is not known (--members 3)."
    if problem.share is not None or not scatter.value > 0:
        return ""
    return (
        " This is of the mean over starts: at that value about half of the starts may miss it. "
        "--share 95% asks for the value at which 95 % of them hold."
    )


def _named(path: str) -> str:
    """Words of a path, and the path where they are others."""
    return axis_words(path) if axis_words(path) == path else f"the {axis_words(path)} ({path})"


def _ranged(problem: RootProblem, value: float, low: float, high: float, its: str) -> str:
    """A value and its 95 % range, with their unit."""
    unit_text = f" {its.translate(POWERS)}" if its else ""
    return f"{_brief(problem, value)}{unit_text} (95 %: {_brief(problem, low)} to {_brief(problem, high)}{unit_text})"


def _brief(problem: RootProblem, value: float) -> str:
    """A place with four digits of the range."""
    return f"{round(value, 3 - floor(log10(problem.room[1] - problem.room[0]))):zg}"


def _draw(problem: RootProblem, tried: Mapping[float, np.ndarray], answer: CrossingPlace, folder: Path) -> Path:
    """Draw the values of all runs over the varied number, with the answer."""
    place = folder / "figures"
    asked_for = f"{problem.key} [{problem.unit.translate(POWERS)}]" if problem.unit else problem.key
    require_no_link(place)
    place.mkdir(exist_ok=True)
    with drawing(6.4, 4.0, 1, 1) as (figure, panel):
        x = np.concatenate([np.full(len(values), at) for at, values in tried.items()])
        y = np.concatenate(list(tried.values()))
        panel.plot(x, y, "o", ms=4, mfc="white", color=BLACK, label="runs")
        panel.axhline(problem.number, color=GREY, lw=1, ls="--", label=problem.asked)
        if problem.share is not None:
            number = search_for(problem, tried).number
            panel.axhline(number, color=GREY, lw=1, ls=":", label="mean that this asks for")
        if isfinite(answer.value):
            panel.axvspan(answer.low, answer.high, color=BLUE, alpha=0.2, lw=0, label="95 %")
            panel.axvline(answer.value, color=RED, lw=1.2, label="answer")
        panel.set(xlabel=axis_heading(problem.path), ylabel=asked_for, xlim=problem.room)
        panel.legend()
        return save(figure, place / "find.png")


def _sections(problem: RootProblem, data: Mapping[str, Any], drawn: Path) -> list[Section]:
    held = data["held"]
    span = f"95 %: {_brief(problem, data['low'])} to {_brief(problem, data['high'])}" if held else ""
    value = _brief(problem, data["value"]) if held else ABSENT
    boxes = [NumberBox(axis_words(problem.path), value, axis_unit(problem.path), "", span)]
    if size := data["size"]:
        across = f"95 %: {_brief(problem, size['low'])} to {_brief(problem, size['high'])}"
        boxes.append(NumberBox(size["what"], _brief(problem, size["value"]), "m", "", across))
    rows = [
        [one["value"], shown(known.mean()) if known.size else ABSENT, ", ".join(shown(v) for v in one["found"])]
        for one in sorted(data["points"], key=lambda one: one["value"])
        for known in [np.array([v for v in one["found"] if v is not None])]
    ]
    blocks: list[Any] = [
        Boxes(boxes),
        Text(data["reason"] or "", "warn"),
        *(Text(text, "warn") for text in data["notes"]),
        picture(drawn, "All runs, and the answer"),
    ]
    failed = [
        Text(f"{problem.path} = {f['value']:zg}, seed {f['seed']}: {f['message']}", "small") for f in data["failures"]
    ]
    about = f"{data['runs']} runs, {data['members']} starts of each value, of at most {data['budget']}."
    table = Table(rows, (axis_heading(problem.path), f"{problem.key}, mean", "starts"))
    return [Section("", blocks), Section("Runs", [table, Text(about, "small"), *failed])]
