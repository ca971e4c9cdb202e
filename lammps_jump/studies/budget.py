# SPDX-License-Identifier: GPL-2.0-or-later
"""``lammps-jump budget``: how much of the ± of a number is due to starts, step, discs, walls and analysis.

Every part is a choice that nobody could call wrong if it were a little other: it is made a factor smaller and larger,
one at a time, and the number is measured at both. Half of the difference is the standard deviation of a choice between
the two. Parts that do not depend on each other add as variances (JCGM 100:2008, 5.1.2); ``joint`` runs draw all choices
at once, and show whether they do. Window, bins and fits change the analysis alone: they are looked at in the same runs.

A `Variation` is what `sensitivity` is made of too.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import inf, isfinite, nan, sqrt
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from lammps_jump.analysis.draw.style import BLACK, BLUE, GREY, drawing, save
from lammps_jump.analysis.quantities import QUANTITIES
from lammps_jump.analysis.report.page import Boxes, NumberBox, Section, Table, Text, picture
from lammps_jump.analysis.statistics import student
from lammps_jump.analysis.tables import Column, cells, markdown
from lammps_jump.case import discs
from lammps_jump.case.discs import GradingCurve
from lammps_jump.errors import CaseError
from lammps_jump.runs.results import looked_at
from lammps_jump.runs.run import Case, Run
from lammps_jump.sweeps import Results, Say
from lammps_jump.sweeps.page import write_study_page
from lammps_jump.sweeps.study import Collected, collected_alone
from lammps_jump.sweeps.table import number_at
from lammps_jump.units import shown

from .points import FAILED, Found, Point, PointStudy, run_study

PAGE = "budget.html"
STRETCH = "stretch"
"""The look that changes the stretches of fits (`Flow.fit_stretch`)."""
SIDES = ("lower", "upper")
ANALYSIS = "a choice of the analysis: no run narrows it; tell which one it was"


class Design(NamedTuple):
    """The runs of a budget.

    Attributes
    ----------
    by : float
        Factor by which each choice is made smaller and larger, 1.01 to 2.
    starts, each : int
        Starts of the case, and of each changed case; 2 or more.
    joint : int
        Runs with all choices drawn at once.
    """

    by: float = 1.25
    starts: int = 8
    each: int = 4
    joint: int = 0


ALLOWED = {"by": (1.01, 2.0), "starts": (2, 1000), "each": (2, 1000), "joint": (0, 1000)}
"""Least and most of each."""


@dataclass(frozen=True)
class Variation:
    """One thing of a case that is varied.

    Attributes
    ----------
    label : str
    settings : mapping
        By a value, or its words, the changed values of the case.
    """

    label: str
    settings: Mapping[Any, Mapping[str, object]]

    def points(self, point: Point, starts: Callable[[Any], int]) -> dict[Any, Point]:
        """The point of each setting, made of one `point` of the case; `starts` tells how many each has."""
        return {
            setting: replace(point, name=f"{point.name} {setting}", changes=changes, starts=starts(setting))
            for setting, changes in self.settings.items()
        }


@dataclass(frozen=True)
class Part(Variation):
    """A part of a budget: its two settings.

    Attributes
    ----------
    key : str
    advice : str
        What narrows it.
    looks : bool
        The settings are looks at the same runs, and change no run.
    reason : str
        Why it does not apply; empty where it does.
    """

    key: str = ""
    advice: str = ""
    looks: bool = False
    reason: str = ""

    @property
    def sides(self) -> list[Mapping[str, object]]:
        """Changed values of both settings; none where the part does not apply."""
        return [*self.settings.values()]


def numbers_of_run(run: Run, paths: Sequence[str], looks: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """Numbers of a run by their paths in ``summary.json``, their values by other looks at it, and its results.

    Parameters
    ----------
    run : Run
    paths : sequence of str
    looks : mapping
        By its name the changed values of the analysis, and `STRETCH`.

    Returns
    -------
    dict
        ``outcome``, ``seconds`` (processor time), ``numbers`` by path, ``looks`` by name and path. None: no number.
    """
    verdict = (run.summary.get(paths[0].partition(".")[0]) or {}).get("verdict")
    seen = {}
    for name, look in looks.items():
        case = run.case.replace({path: value for path, value in look.items() if path != STRETCH})
        parts: dict[str, Any] = {}
        for part in dict.fromkeys(path.partition(".")[0] for path in paths):
            parts |= looked_at(case, run.folder, part, float(look.get(STRETCH, 1.0)))
        seen[name] = {path: number_at(parts, path) for path in paths}
    return {
        "outcome": verdict or "complete",
        "seconds": run.summary.get("cpu_seconds", 0.0),
        "numbers": {path: number_at(run.summary, path) for path in paths},
        "looks": seen,
    }


def parts_of(case: Case, by: float) -> list[Part]:
    """The parts of a budget of a case, but for starts: each with two settings, or the reason why it does not apply."""
    return [make(case, by) for make in (_step, _stiffness, _size, _walls, _window, _bins, _fit)]


def _two(path: str, low: float, high: float) -> dict[str, dict[str, object]]:
    """Settings of one number of a case."""
    return {f"{value:z.3g}": {path: value} for value in (low, high)}


def _usable(case: Case, part: Part) -> Part:
    """The part; with a reason where the case refuses one of its settings."""
    try:
        for side in part.sides:
            case.replace(side).scene()
    except CaseError as error:
        return replace(part, reason=f"the case does not allow it: {error}", settings={})
    return part


def _step(case: Case, by: float) -> Part:
    f, advice = (
        case.fields.run.time_step_fraction,
        "a finer step, run.time_step_fraction; a run takes as many times longer",
    )
    part = partial(Part, "time step over 2/ω", key="step", advice=advice)
    if case.fields.run.accuracy is not None:
        return part({}, reason="run.accuracy chooses the step")
    whole = _usable(case, part(_two("run.time_step_fraction", f / by, f * by)))
    if whole.reason:  # the step is at its limit: both are finer, as far apart
        whole = _usable(case, part(_two("run.time_step_fraction", f / by**2, f)))
    return whole


def _stiffness(case: Case, by: float) -> Part:
    """Both stiffnesses follow from one number of the case; that of walls stays, for `_walls` changes it."""
    contact, coefficients = case.fields.contact, case.scene().coefficients
    path = "contact.from_material.young" if contact.from_material else "contact.stiffness"
    value = contact.from_material.young if contact.from_material else contact.stiffness
    label, advice = "stiffness of discs, N/m", "stiffer discs; the step goes with one over the root of the stiffness"
    if value is None:
        path, value, label = "contact.largest_overlap", contact.largest_overlap or 0.1, "largest overlap over diameter"
    settings = _two(path, value / by, value * by)
    if case.fields.walls:
        settings = {
            name: {**one, "contact.stiffness_wall": coefficients.stiffness_wall} for name, one in settings.items()
        }
    return _usable(case, Part(label, settings, key="stiffness", advice=advice))


def _size(case: Case, by: float) -> Part:
    given = case.fields.discs
    part = partial(
        Part, "disc diameter, m", key="size", advice="smaller discs; a run takes as many times longer, cubed"
    )
    if not all(isinstance(item, discs.Column | discs.PackedBed) for item in case.fields.initial):
        return part({}, reason="the case places its discs one by one or as a lattice, or takes them from a run")
    if isinstance(given.sizes, discs.ListSizes | GradingCurve):
        return part({}, reason="discs.sizes tells the diameters themselves")
    return _usable(case, part(_two("discs.diameter", given.diameter / by, given.diameter * by)))


def _walls(case: Case, by: float) -> Part:
    part = partial(Part, "stiffness of walls, N/m", key="walls", advice="a measured stiffness of the walls")
    if not case.fields.walls:
        return part({}, reason="there are no walls")
    stiffness = case.scene().coefficients.stiffness_wall
    return _usable(case, part(_two("contact.stiffness_wall", stiffness / by, stiffness * by)))


def _look(label: str, key: str, settings: Mapping[str, Mapping[str, object]], advice: str = ANALYSIS) -> Part:
    return Part(label, settings, key=key, advice=advice, looks=True)


def _window(case: Case, by: float) -> Part:
    duration = case.fields.run.duration
    begin, end = case.fields.analysis.window or (0.75 * duration, duration)
    less = (1 - 1 / by) * (end - begin)
    sides = ([begin, end - less], [begin + less, end])
    settings = {f"{one[0]:z.3g} to {one[1]:z.3g}": {"analysis.window": one} for one in sides}
    return _look(
        "window of means, s", "window", settings, "a longer run and window; the part goes with one over its root"
    )


def _bins(case: Case, by: float) -> Part:
    width = case.fields.analysis.bin_width or 5 * case.fields.discs.diameter
    return _look("width of bins, m", "bins", _two("analysis.bin_width", width / by, width * by))


def _fit(case: Case, by: float) -> Part:
    return _look("stretch of fits, over the usual one", "fit", _two(STRETCH, 1 / by, by))


@dataclass(frozen=True)
class PlannedBudget:
    """A budget of one number of a case, before it is run.

    Attributes
    ----------
    case : Case
    of : Collected
    design : Design
    parts : sequence of Part
    """

    case: Case
    of: Collected
    design: Design
    parts: Sequence[Part]

    @property
    def points(self) -> Iterator[Point]:
        """Points: the case with all looks, both sides of each part that changes a run, and the joint draws."""
        looks = {f"{part.key} {side}": one for part in self.parts if part.looks for side, one in _sides(part)}
        plain = Point(
            "base",
            numbers_of_run,
            self.case,
            starts=self.design.starts,
            options={"paths": [self.of.path], "looks": looks},
            judged=True,
        )
        yield plain
        seed = plain.seed + self.design.starts
        for part in self._run_parts:
            for side, changes in _sides(part):
                options = {"paths": [self.of.path], "looks": {}}
                yield replace(
                    plain,
                    name=f"{part.key} {side}",
                    changes=changes,
                    starts=self.design.each,
                    options=options,
                    seed=seed,
                )
                seed += self.design.each
        draws = np.random.default_rng(1).integers(0, 2, (self.design.joint, len(self.parts)))
        for number, draw in enumerate(draws):
            yield self._joint(plain, number, draw, seed + number)

    @property
    def _run_parts(self) -> list[Part]:
        return [part for part in self.parts if not part.looks and not part.reason]

    def _joint(self, plain: Point, number: int, draw: Sequence[int], seed: int) -> Point:
        """A point at which every choice is the smaller or the larger one, by chance."""
        changes: dict[str, object] = {}
        look: dict[str, object] = {}
        for part, side in zip(self.parts, draw, strict=True):
            if not part.reason:
                (look if part.looks else changes).update(part.sides[side])
        options = {"paths": [self.of.path], "looks": {"joint": look}}
        return replace(plain, name=f"joint {number}", changes=changes, starts=1, options=options, seed=seed)


def _sides(part: Part) -> Iterator[tuple[str, Mapping[str, object]]]:
    return zip(SIDES, part.sides, strict=False)


def values_of(measured: Sequence[Mapping[str, Any]], path: str, look: str = "") -> np.ndarray:
    """A number of each start, or what it is by a look; NaN where there is none."""
    values = [one.get("looks", {}).get(look, {}) if look else one.get("numbers", {}) for one in measured]
    return np.array([nan if one.get(path) is None else one[path] for one in values], float)


def spread_of(low: np.ndarray, high: np.ndarray, *, paired: bool) -> dict[str, float]:
    """Scatter that a choice between two settings adds to one run.

    Of other runs, half the difference of the means, squared, less what the starts' scatter makes of it. Of looks at the
    same runs, the mean square of half the difference: it is that of each run.

    Parameters
    ----------
    low, high : ndarray, shape (n,) and (m,)
        Values at the two settings.
    paired : bool
        They are looks at the same runs.

    Returns
    -------
    dict
        ``effect`` (half of upper less lower), ``variance``, ``variance_error`` (its standard error).
    """
    if paired:
        half = 0.5 * (high - low)
        half = half[np.isfinite(half)]
        square = half**2
        error = float(square.std(ddof=1) / sqrt(len(half))) if len(half) > 1 else inf
        return {"effect": float(half.mean()), "variance": float(square.mean()), "variance_error": error}
    low, high = low[np.isfinite(low)], high[np.isfinite(high)]
    effect = 0.5 * float(high.mean() - low.mean())
    noise = 0.25 * (low.var(ddof=1) / len(low) + high.var(ddof=1) / len(high))
    error = sqrt(4 * effect**2 * noise + 2 * noise**2)
    return {"effect": effect, "variance": max(0.0, effect**2 - noise), "variance_error": error}


def results_of(budget: PlannedBudget, found: Found, stored: Results) -> Results:
    """Content of ``budget.json``: the number with its ±, the parts, their total, the joint draws, and the verdict."""
    base = values_of(found["base"], budget.of.path)
    base_known = base[np.isfinite(base)]
    if len(base_known) < 2:
        said = next((one[FAILED] for one in found["base"] if FAILED in one), "its runs do not measure it")
        raise CaseError(f"--of {budget.of.path}: {len(base_known)} of {len(base)} starts have this number: {said}")
    n, mean, var = len(base_known), float(base_known.mean()), float(base_known.var(ddof=1))
    rows = [_starts_row(n, var), *(_row(budget, part, found) for part in budget.parts)]
    variance = sum(row["variance"] or 0.0 for row in rows)
    error = sqrt(sum((row["variance_error"] or 0.0) ** 2 for row in rows))
    choices = variance - var
    half = student(n - 1, 0.975) * sqrt(var / n)
    for row in rows:
        row["at_most"] = None if row["variance"] is None else sqrt(row["variance"] + 2 * row["variance_error"])
        part = var / n if row["key"] == "starts" else row["variance"]
        row["of_the_mean"] = None if part is None else sqrt(part)
        row["share"] = None if part is None or not variance else part / (var / n + choices)
    data = {
        "case": budget.case.name, "of": budget.of.path, "unit": budget.of.unit, "meaning": budget.of.meaning,
        "by": budget.design.by, "starts": n, "each": budget.design.each, "mean": mean, "interval": half, "rows": rows,
        "deviation": sqrt(variance), "deviation_error": 0.5 * error / sqrt(variance) if variance else 0.0,
        "whole_interval": sqrt(half**2 + (1.96**2) * choices),
        "joint": _joint_of(budget, found, variance, error),
        "runs": sum(map(len, found.values())),
    }  # fmt: skip
    return {**data, "verdict": verdict_of(data)}


def _starts_row(n: int, var: float) -> Results:
    return {
        "key": "starts", "label": "starts", "settings": f"{n} starts", "effect": None, "variance": var,
        "variance_error": var * sqrt(2 / (n - 1)), "reason": "", "looks": False,
        "advice": "more starts; the part goes with one over their root",
    }  # fmt: skip


def _row(budget: PlannedBudget, part: Part, found: Found) -> Results:
    """The row of a part: what it adds, or why it does not apply."""
    row: Results = {
        "key": part.key,
        "label": part.label,
        "advice": part.advice,
        "reason": part.reason,
        "looks": part.looks,
    }
    path, empty = budget.of.path, {"settings": "", "effect": None, "variance": None, "variance_error": None}
    if part.reason:
        return {**row, **empty}
    names = [f"{part.key} {side}" for side in SIDES]
    some = [found["base"] if part.looks else found[name] for name in names]
    low, high = (values_of(ones, path, name if part.looks else "") for ones, name in zip(some, names, strict=True))
    row["settings"] = ", ".join(part.settings)
    if part.looks and np.array_equal(low, high, equal_nan=True):
        return {**empty, **row, "reason": f"{path} is the same to the last digit: it takes no such choice"}
    enough = np.isfinite(high - low).sum() if part.looks else min(np.isfinite(low).sum(), np.isfinite(high).sum())
    if enough < 2:
        failed = next((one[FAILED] for ones in some for one in ones if FAILED in one), "the runs do not measure it")
        return {**empty, **row, "reason": f"fewer than two starts have the number at both settings: {failed}"}
    return {**row, **spread_of(low, high, paired=part.looks)}


def _joint_of(budget: PlannedBudget, found: Found, variance: float, error: float) -> Results | None:
    """Scatter of the joint draws and that of the parts, and how many standard errors their variances are apart."""
    draws = [one for name, ones in found.items() if name.startswith("joint ") for one in ones]
    values = values_of(draws, budget.of.path, "joint")
    values = values[np.isfinite(values)]
    if len(values) < 2:
        return None
    var = float(values.var(ddof=1))
    own = var * sqrt(2 / (len(values) - 1))
    off = (var - variance) / sqrt(own**2 + error**2) if own or error else 0.0
    sd = sqrt(var)
    return {
        "draws": len(values),
        "deviation": sd,
        "deviation_error": 0.5 * own / sd if sd else 0.0,
        "errors_apart": off,
    }


def largest_of(rows: Sequence[Results]) -> Results | None:
    """The row that makes most of the ± of the mean, of those that are seen; None where there is none."""
    known = [row for row in rows if row["of_the_mean"] and is_seen(row)]
    return max(known, key=lambda row: row["of_the_mean"], default=None)


def verdict_of(data: Results) -> str:
    """The answer in words: the number, both ±, and what to spend runs on."""
    unit = f" {data['unit']}" if data["unit"] else ""
    said = (
        f"{data['of']} is {shown(data['mean'], error=data['interval'])}{unit} over {data['starts']} starts; with all "
        f"choices of this budget ± {data['whole_interval']:z.2g}{unit}."
    )
    if (most := largest_of(data["rows"])) is None:
        return f"{said} Nothing moves it."
    unseen = [row for row in data["rows"] if row["of_the_mean"] is not None and not is_seen(row)]
    hidden = [row["label"] for row in unseen if row["at_most"] > most["of_the_mean"]]
    sure = f" Not told apart from the scatter of the starts: {', '.join(hidden)}; more --each would." if hidden else ""
    return f"{said} Most of it, {100 * most['share']:z.0f} %, is {most['label']}: {most['advice']}.{sure}"


COLUMNS: dict[str, Column] = {
    "part": "{label}",
    "settings": "{settings}",
    "half of the difference:": "{effect:+z.2g}",
    "standard deviation of one run:": lambda row: _shown(row, row["variance"] and sqrt(row["variance"])),
    "of the mean:": lambda row: _shown(row, row["of_the_mean"]),
    "share:": lambda row: "-" if row["share"] is None or not is_seen(row) else f"{100 * row['share']:z.0f} %",
    "absent, because": "{reason}",
}


def is_seen(row: Results) -> bool:
    """Tells whether a part is above what the scatter of the starts makes of it."""
    return bool(row["key"] == "starts" or (row["variance"] and row["variance"] > row["variance_error"]))


def _shown(row: Results, value: float | None) -> str:
    """A standard deviation; what it is below, at 95 %, where it is not seen."""
    return "-" if value is None else f"{value:z.2g}" if is_seen(row) else f"below {row['at_most']:z.2g}"


def page_of(data: Results) -> list[str]:
    """Paragraphs of the page in Markdown."""
    return [f"## Budget of {data['of']}, {data['case']}", data["verdict"], markdown(COLUMNS, data["rows"]), about(data)]


def about(data: Results) -> str:
    """Meaning of the numbers, and what the joint draws show."""
    unit = f" {data['unit']}" if data["unit"] else ""
    text = (
        f"Each choice is made {data['by']:zg} times smaller and larger. Half of the difference is what it adds to one "
        f"run; starts add their scatter, to the mean that over the root of {data['starts']}. Added as variances, one "
        f"run has a standard deviation of {data['deviation']:z.2g} ± {data['deviation_error']:z.1g}{unit}."
    )
    if joint := data["joint"]:
        text += (
            f" {joint['draws']} runs with all choices drawn at once have {joint['deviation']:z.2g} ± "
            f"{joint['deviation_error']:z.1g}{unit}: {abs(joint['errors_apart']):z.1f} standard errors apart."
        )
    return text


def draw_budget(data: Results, path: Path) -> Path:
    """Draw a bar for each part of the ± of the mean, the total, and the interval of the members."""
    rows = [row for row in data["rows"] if row["of_the_mean"] is not None]
    names = [row["label"] for row in rows] + ["95 %: starts alone", "95 %: with all choices"]
    intervals = [data["interval"], data["whole_interval"]]
    ends = [row["of_the_mean"] if is_seen(row) else row["at_most"] for row in rows] + intervals
    labels = [_shown(row, row["of_the_mean"]) for row in rows] + [f"{value:z.2g}" for value in intervals]
    places = np.arange(len(ends))[::-1]
    with drawing(7.2, 1.0 + 0.3 * len(ends)) as (figure, axes):
        colours = [BLUE] * len(rows) + [GREY, BLACK]
        axes.barh(places, [row["of_the_mean"] for row in rows] + intervals, color=colours, height=0.62)
        unseen = [(place, row) for place, row in zip(places, rows, strict=False) if not is_seen(row)]
        axes.plot([row["at_most"] for _, row in unseen], [place for place, _ in unseen], "|", color=BLACK, ms=9)
        axes.axhline(1.5, color=GREY, lw=0.8)
        axes.set_yticks(places, names)
        axes.grid(axis="y", visible=False)
        unit = f" [{data['unit']}]" if data["unit"] else ""
        axes.set(xlabel=f"± of {data['of']}{unit}: standard deviations of the parts, and two intervals", xlim=(0, None))
        for place, value, label in zip(places, ends, labels, strict=True):
            axes.annotate(label, (value, place), (5, 0), textcoords="offset points", fontsize=8, va="center")
        return save(figure, path)


def write_pages(case: Case, data: Results, folder: Path) -> Path:
    """Draw the bars, and write ``budget.html``."""
    drawn = draw_budget(data, folder / "budget.png")
    unit = data["unit"]
    boxes = Boxes([
        NumberBox(data["meaning"], shown(data["mean"], error=data["interval"]), unit, "", "95 %"),
        NumberBox("± with all choices", f"{data['whole_interval']:z.2g}", unit, "", "95 %"),
    ])  # fmt: skip
    parts = [
        Section("", [boxes, Text(data["verdict"]), picture(drawn, "Parts of the ±, and both intervals")]),
        Section("Parts", [Table(*cells(COLUMNS, data["rows"])), Text(about(data), "small")]),
    ]
    return write_study_page(folder / PAGE, "budget", case, f"Budget of error: {data['of']}", parts)


def default_folder(case: Case, of: str) -> Path:
    """Folder of a budget when none is named."""
    return Path("runs") / f"{case.name}_budget_{of.replace('.', '_')}"


def budget(
    case: Case, of: str, out: str | Path | None = None, *, fresh: bool = False, say: Say = print, **design: Any
) -> Results:
    """Make a budget of the error of one number of a case; writes ``budget.json`` and ``budget.html``.

    Parameters
    ----------
    case : Case
    of : str
        Path of the number in ``summary.json``, such as ``jump.y2``.
    out : str or Path, optional
        Folder; default ``runs/<name>_budget_<number>``.
    fresh : bool
        Measure again what is stored.
    say : callable
        Takes a line of progress.
    **design
        Fields of `Design`: ``by``, ``starts``, ``each``, ``joint``.

    Returns
    -------
    dict
        ``mean``, ``interval``, ``whole_interval`` (halves of 95 % intervals), ``rows``, ``deviation``, ``joint``,
        ``verdict``.

    Raises
    ------
    CaseError
        A number that there is not, or a value out of its range.
    """
    planned = plan_budget(case, of, Design(**design))
    name = f"{len(list(planned.points))} points of {case.name}"
    study = PointStudy(
        "budget",
        list(planned.points),
        partial(results_of, planned),
        page_of,
        lambda found, folder: write_pages(planned.case, found, folder),
        partial(_told, of),
        (f"budget of {of}: {name}",),
    )
    return run_study(study, Path(out) if out else default_folder(case, of), fresh=fresh, say=say)[0]


def _told(of: str, point: Point, start: int, measured: Results) -> str:
    value = measured.get("numbers", {}).get(of)
    return f"{point.name}, start {start}: {measured.get(FAILED) or shown(value)}"


def plan_budget(case: Case, of: str, design: Design) -> PlannedBudget:
    """The budget of a number of a case, checked.

    Raises
    ------
    CaseError
    """
    for name, value in design._asdict().items():
        least, most = ALLOWED[name]
        if not (isfinite(value) and least <= value <= most):
            raise CaseError(f"--{name} {value:zg}: allowed is {least:zg} to {most:zg}")
    number = collected_alone(of, case)
    key = of.partition(".")[0]
    if key not in QUANTITIES:
        raise CaseError(f"--of {of}: is no number of an analysis; allowed are numbers of {', '.join(QUANTITIES)}")
    if getattr(case.fields.analysis, key, None) is False:
        case = case.replace({f"analysis.{key}": True})
    case = case.replace({"analysis.figures": "none", "analysis.animation": False})
    return PlannedBudget(case, number, design, parts_of(case, design.by))
