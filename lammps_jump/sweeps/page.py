# SPDX-License-Identifier: GPL-2.0-or-later
"""Page and figures of a study: its numbers against each axis, with the interval over members as a band.

Its players are of the members of a case by a list, or of the points of a study by sliders. A slider for each axis shows
the run there, with its curve and its numbers.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import starmap
from math import ceil, inf, isfinite
from pathlib import Path
from textwrap import wrap
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr
from matplotlib.figure import Figure

from lammps_jump.analysis.budgets.inflow import shortfall
from lammps_jump.analysis.draw.style import BLUE, DASHES, GOLD, GREY, RED, colour_bar, drawing, save
from lammps_jump.analysis.report import run as report
from lammps_jump.analysis.report.handed_on import read_player
from lammps_jump.analysis.report.page import (
    Boxes,
    Code,
    Curve,
    Items,
    NumberBox,
    Player,
    PlayerChoice,
    Section,
    Slider,
    Table,
    Text,
    picture,
    render,
)
from lammps_jump.analysis.report.player import make_player
from lammps_jump.analysis.tables import markdown, tiles, together
from lammps_jump.analysis.verdicts import verdict
from lammps_jump.errors import DumpError
from lammps_jump.files import PLAYER, write_text
from lammps_jump.folders import require_no_link
from lammps_jump.provenance import versions
from lammps_jump.runs.results import flow_of, packed
from lammps_jump.runs.run import Case, Run
from lammps_jump.runs.summary import results_in
from lammps_jump.units import shown, two_digits

from . import rating
from .study import Axis, Collected, Study, axis_heading, axis_unit, axis_words
from .study_folder import StudyResults
from .table import DISAGREE, flat, records, statistics

LARGEST = 10_000_000
"""Bytes of the packed frames on a page: eight members of most scenes."""


def player_of(run: Run) -> Player:
    """The player that a run has kept.

    Raises
    ------
    OSError
        It has none: no frame holds a disc.
    ValueError
        The file is damaged.
    """
    results_in(run.folder, run.summary).require_same(PLAYER)
    return read_player(run.folder / PLAYER)


def by_member(results: StudyResults) -> list[PlayerChoice | Text]:
    """One player for the members of a case, as many as the page has room for; nothing where none has frames.

    Members are in the order of their distance from the means: the sum of squares of ``(number - mean) / sd``.
    """
    numbers = results.values[[item.path for item in results.study.collect]]
    apart = ((numbers - numbers.mean()) / numbers.std()) ** 2
    order = np.argsort(apart.dropna(axis=1, how="all").fillna(inf).sum(axis=1), kind="stable")
    kept: dict[int, Player] = {}
    damaged: list[int] = []
    room = LARGEST
    for number in order:
        seed = int(results.values["seed"][number])
        try:
            player = player_of(results.runs[number])
        except OSError:  # without discs in its frames
            continue
        except ValueError:  # a DumpError is one
            damaged.append(seed)
            continue
        room -= len(player.frames)
        if room >= 0 or not kept:
            kept[seed] = player
        if room <= 0:
            break
    seeds = ", ".join(map(str, sorted(damaged)))
    without = f"Members without a player ({PLAYER} is damaged): {seeds}." if damaged else ""
    if not kept:
        return [Text(without, "small")] if damaged else []
    first, listed = next(iter(kept)), sorted(kept)
    text = f"Member {first} is shown first: its numbers are nearest to the means."
    if left := len(order) - len(kept) - len(damaged):
        text += f" There is no room for {left} of {len(order)} members, those farthest from the means."
    chosen = PlayerChoice([kept[seed] for seed in listed], [f"Member {seed}" for seed in listed], listed.index(first))
    return [chosen, Text(f"{text} {without}".strip(), "small")]


log = logging.getLogger("lammps_jump")


class PlayerPoint(NamedTuple):
    """Point on the page: its number, a run of it, and the player of that run."""

    number: int
    run: Run
    player: Player


def by_point(results: StudyResults) -> list[PlayerChoice | Text]:
    """One player for the points of a study, with a slider for each axis; nothing where no run has frames.

    Each point is shown by the member that is nearest to its means. Where all of them together are larger than
    `LARGEST`, every second frame of each is shown, every third, and so on.
    """
    study = results.study
    chosen = _nearest(results)
    points, damaged = _players(results.runs, chosen)
    if not points:
        return []
    first = len(points) // 2
    axes = [
        Slider(axis_words(axis.name), [shown(value, axis_unit(axis.name)) for value in axis.values])
        for axis in study.axes
    ]
    grid = list(np.ndindex(*(len(axis.values) for axis in study.axes)))
    names = [
        ", ".join(f"{axis.label} {axis.values[i]}" for axis, i in zip(axes, grid[p.number], strict=True))
        for p in points
    ]
    sides = [_side(results, point) for point in points]
    choice = PlayerChoice([p.player for p in points], names, first, axes, [grid[p.number] for p in points], sides)
    said = []
    if len(results.values) > len(chosen):
        said.append("Each point is shown by the start whose numbers are nearest to its means.")
    if missing := len(study.points) - len(points):
        said.append(f"{missing} of {len(study.points)} points have no finished run with frames.")
    if damaged:
        said.append(f"Damaged players, left out: {', '.join(damaged)}.")
    return [choice, *([Text(" ".join(said), "small")] if said else [])]


def _nearest(results: StudyResults) -> dict[int, int]:
    """Row of `StudyResults.values` of the member of each point that is nearest to its means."""
    numbers = results.values.set_index("point")[[item.path for item in results.study.collect]].astype(float)
    apart = ((numbers - numbers.groupby("point").mean()) / numbers.groupby("point").std()) ** 2
    order = np.argsort(apart.sum(axis=1), kind="stable")  # a sum leaves out what is not known
    chosen = {int(numbers.index[row]): int(row) for row in order[::-1]}
    return dict(sorted(chosen.items()))


def _players(runs: Sequence[Run], chosen: dict[int, int]) -> tuple[list[PlayerPoint], list[str]]:
    """The players of the points that have one, and the points whose player is damaged."""
    there, damaged = [], []
    for number, row in chosen.items():
        try:
            there.append(PlayerPoint(number, runs[row], player_of(runs[row])))
        except OSError:  # without discs in its frames
            continue
        except ValueError:  # a DumpError is one
            damaged.append(str(number))
    every = ceil(sum(len(point.player.frames) for point in there) / LARGEST)
    if every > 1:
        there = [point._replace(player=_thinned(point.run, point.player, every)) for point in there]
    return there, damaged


def _thinned(run: Run, player: Player, every: int) -> Player:
    """The player of a run with every n-th of its frames; as it is where its dump is gone."""
    try:
        fewer = make_player(packed(flow_of(run.case, run.folder), run.folder, every), run.folder)
    except DumpError as error:
        log.info(f"note: the player of {run.folder} is not thinned: {error}")
        return player
    return fewer._replace(still=None) if fewer is not None else player


def _side(results: StudyResults, point: PlayerPoint) -> list[Boxes | Curve]:
    """Numbers of a point, means over its starts, and the curves of the run that is shown."""
    study, frame = results.study, flat(results.table, results.study)
    boxes = []
    for item in study.collect:
        mean, high = (item.scale * float(frame[name][point.number]) for name in (item.path, f"{item.path}_high"))
        error = shown(high - mean, digits=2) if np.isfinite(high - mean) else ""
        count = int(frame[f"{item.path}_n"][point.number])
        boxes.append(NumberBox(item.heading, mean if np.isfinite(mean) else None, "", error, f"n = {count}"))
    return [Boxes(boxes), *_curves(point.run.folder)]


def _curves(folder: Path) -> list[Curve]:
    """The curve of a run over the channel, or else its first one; none where they cannot be read."""
    try:
        curves = report.curves(folder)
    except DumpError:
        return []
    return list(curves.values())[:1]


MOST_NAMED = 6
"""Points that a sentence names."""
MOST_LINES = 6
"""Lines of a panel, one for each point of the other axes."""
COLOURS = (BLUE, GOLD, GREY, RED)


def summary_frame(results: StudyResults) -> pd.DataFrame:
    """Mean ± half the interval of each number, with its count: a row for each point, or a number where there is one."""
    study = results.study
    rows = []
    frame = flat(results.table, study)
    for (_, numbers), point in zip(frame.iterrows(), study.points, strict=True):
        row = {axis_heading(path): shown(value) for path, value in point.items()}
        for item in study.collect:
            mean, high = (item.scale * numbers[name] for name in (item.path, f"{item.path}_high"))
            row[item.heading] = f"{shown(mean, error=high - mean)} (n = {numbers[f'{item.path}_n']})"
        rows.append({**row, "found": numbers["verdicts"]} if any(frame["verdicts"]) else row)
    whole = pd.DataFrame(rows)
    return whole if study.axes else whole.T.reset_index().set_axis(["number", "mean ± half the interval"], axis=1)


def table_text(results: StudyResults) -> str:
    """The table of `summary_frame` in Markdown."""
    frame = summary_frame(results)
    return markdown(dict.fromkeys(frame.columns, ""), frame.to_dict("records"))


def figures_of(results: StudyResults) -> Iterator[tuple[str, str, Figure]]:
    """Name, caption and figure of each axis, and of a map of two axes of numbers; without an axis, of the profiles."""
    study = results.study
    axes = [axis for axis in study.axes if results.table[axis.name].dtype.kind in "if" and len(axis.values) > 1]
    for axis in axes:
        caption = f"Against the {axis_words(axis.name)}; band: interval over members"
        yield f"sweep_{axis.name}", caption, draw_lines(results.table, study, axis)
    if len(axes) == len(study.axes) == 2:
        yield "sweep_map", "Means over both axes", draw_map(results.table, study, axes)
    yield from rating.figures(results)
    if not study.axes and results.runs:
        yield "sweep_profiles", "Profiles, mean of the window; thin lines: members", draw_profiles(results)


def draw(results: StudyResults, ending: str = "png") -> dict[Path, str]:
    """Draw the figures of a study into its folder; the captions by file."""
    folder = results.folder / "figures"
    require_no_link(folder)
    folder.mkdir(exist_ok=True)
    return {save(figure, folder / f"{name}.{ending}"): caption for name, caption, figure in figures_of(results)}


def draw_profiles(results: StudyResults) -> Figure:
    """Draw mean profiles of the members of a case: each member as a thin line, the interval of the mean as a band."""
    panels = {"mass_depth_mean": "mass depth [m]", "velocity_mean": "velocity [m/s]"}
    members = [run.profiles for run in results.runs]
    with drawing(7.2, 4.6, 2, 1, sharex=True) as (figure, axes):
        for panel, (name, label) in zip(axes, panels.items(), strict=True):
            lines = np.array([profiles[name] for profiles in members])
            confidence = results.study.fields.confidence
            cells = [statistics(line, np.full(len(line), np.nan), confidence) for line in lines.T]
            mean, low, high = (np.array([cell[key] for cell in cells]) for key in ("mean", "low", "high"))
            panel.plot(members[0].x, lines.T, color=GREY, lw=0.5)
            panel.fill_between(members[0].x, low, high, color=BLUE, alpha=0.3, lw=0, label="interval over members")
            panel.plot(members[0].x, mean, color=BLUE, label=f"mean of {len(lines)} members")
            panel.set_ylabel(label)
        axes[0].legend()
        axes[1].set_xlabel("x [m]")
        return figure


@contextmanager
def _panels(study: Study) -> Iterator[tuple[Any, list[tuple[Any, Collected]]]]:
    """A figure with a panel for each collected number."""
    count = len(study.collect)
    columns = 2 if count == 4 else min(count, 3)
    rows = -(-count // columns)
    with drawing(3.4 * columns, 2.7 * rows, rows, columns, squeeze=False) as (figure, panels):
        for empty in panels.flat[count:]:
            empty.axis("off")
        yield figure, list(zip(panels.flat, study.collect, strict=False))


def draw_lines(table: xr.Dataset, study: Study, axis: Axis) -> Figure:
    """Draw every number against one axis: the mean, and the interval over members as a band."""
    others = [other.name for other in study.axes if other.name != axis.name]
    with _panels(study) as (figure, panels):
        for panel, item in panels:
            whole = item.scale * table[item.path].transpose(axis.name, *others, "statistic")
            lines = whole.values.reshape(len(axis.values), -1, whole.sizes["statistic"])
            labels = list(np.ndindex(*whole.shape[1:-1]))
            shown_lines = np.unique(np.linspace(0, len(labels) - 1, min(len(labels), MOST_LINES)).astype(int))
            for place, line in enumerate(shown_lines):
                said = (
                    f"{axis_heading(name)} {table[name].values[i]}"
                    for name, i in zip(others, labels[line], strict=True)
                )
                cells = dict(zip(whole["statistic"].values, lines[:, line].T, strict=True))
                colour, dash = COLOURS[place % len(COLOURS)], DASHES[place % len(DASHES)]
                panel.plot(axis.values, cells["mean"], dash, marker="o", ms=4, color=colour, label=", ".join(said))
                if np.isfinite(cells["low"]).any():
                    panel.fill_between(axis.values, cells["low"], cells["high"], color=colour, alpha=0.18, lw=0)
            if item.level is not None:
                panel.axhline(item.level, color=RED, lw=1, ls=":")
            panel.set(ylabel="\n".join(wrap(item.heading, 30)))
            name_axis(panel, axis.name)
        if others:
            panels[0][0].legend()
        return figure


def name_axis(panel: Any, path: str) -> None:
    """Put the words of a path at the axis along x, and the path itself below in small."""
    panel.set_xlabel(axis_heading(path))
    if axis_heading(path) != path:
        place = {"xycoords": panel.xaxis.label, "ha": "center", "va": "top", "fontsize": 6, "color": GREY}
        panel.annotate(path, (0.5, -0.1), **place)


def draw_map(table: xr.Dataset, study: Study, axes: list[Axis]) -> Figure:
    """Draw the mean of every number over two axes."""
    y, x = axes
    with _panels(study) as (figure, panels):
        for panel, item in panels:
            cells = item.scale * table[item.path].sel(statistic="mean").transpose(y.name, x.name).values
            image = panel.imshow(cells, origin="lower", aspect="auto")
            panel.set_xticks(range(len(x.values)), [f"{value:zg}" for value in x.values])
            panel.set_yticks(range(len(y.values)), [f"{value:zg}" for value in y.values])
            name_axis(panel, x.name)
            panel.set_ylabel(axis_heading(y.name))
            panel.grid(visible=False)
            bar = colour_bar(figure, image, item.heading, ax=panel)
            if item.level is not None:
                low = item.scale * table[item.path].sel(statistic="low").transpose(y.name, x.name).values
                _draw_level(panel, bar.ax, item.level, cells, low)
        return figure


def _draw_level(panel: Any, bar: Any, level: float, mean: np.ndarray, low: np.ndarray) -> None:
    """Draw where the mean over starts is at a level, and where the lower end of its interval is, in a map."""
    bar.axhline(level, color=RED, lw=1.5)
    for values, look in ((mean, "solid"), (low, "dashed")):
        known = values[np.isfinite(values)]
        if min(values.shape) > 1 and known.size and known.min() < level < known.max():
            panel.contour(values, levels=[level], colors=[RED], linestyles=look)


def holding(results: StudyResults) -> list[str]:
    """Sentences on the points at which structures hold: the lower end of the interval of a factor is 1 or more."""
    study, frame = results.study, flat(results.table, results.study)
    names = [point_name(study, index) for index in range(len(frame))]
    share = f"{100 * study.fields.confidence:zg} %"
    said = []
    for item in study.collect:
        if item.level is None or not study.axes:
            continue
        mean, low = (np.asarray(frame[f"{item.path}{end}"], float) for end in ("", "_low"))
        sure = [name for name, value in zip(names, low, strict=True) if value >= item.level]
        some = [name for name, value, end in zip(names, mean, low, strict=True) if value >= item.level > end]
        more = f"; and {len(sure) - MOST_NAMED} more" if len(sure) > MOST_NAMED else ""
        name = f"{item.heading}, {item.path.split('.')[1]}"
        text = f"{name}: 1 or more, sure to {share}, at {len(sure)} of {len(names)} points"
        text += f" ({'; '.join(sure[:MOST_NAMED])}{more})." if sure else "."
        said.append(text + (f" By the mean alone it is so at {len(some)} more." if some else ""))
    return said


def doubts(results: StudyResults) -> list[str]:
    """Sentences on what the table cannot say by itself."""
    study, frame = results.study, flat(results.table, results.study)
    names = [point_name(study, index) for index in range(len(frame))]
    said = [
        f"{name}: members differ in kind: {words}. Only numbers that go with a verdict are counted."
        for name, words in zip(names, frame["verdicts"], strict=True)
        if ", " in words
    ]
    said += [
        f"{item.heading}: members scatter more than single runs say of themselves (chi2/dof {chi2:z.1f}): use the "
        "interval over members."
        for item in study.collect
        if (chi2 := frame[f"{item.path}_chi2"].median()) > DISAGREE
    ]
    said += [
        f"{names[failure.point]}, member {failure.seed}: left out: {failure.message}" for failure in results.failed
    ]
    for item in study.collect:
        cells = records(results.table, item.path)
        said += [
            f"{name}: {item.path}: the interval over {cell['n']:z.0f} members is wider than the mean: its sign is not "
            "known. More members narrow it (--members)."
            for name, cell in zip(names, cells, strict=True)
            if cell["high"] - cell["mean"] > abs(cell["mean"])
        ]
    said += filter(None, [shortfall(results.summaries)])
    wanted = ", ".join(f"{path} within {100 * share:zg} %" for path, share in study.fields.until.items())
    said += [
        f"{name}: {wanted} would take {needed} members; {have} have run."
        for name, needed, have in zip(names, results.needed(), frame["members"], strict=True)
        if needed > have
    ]
    return said


def point_name(study: Study, index: int) -> str:
    """Values of a point in words."""
    point = study.points[index].items()
    return (
        ", ".join(f"{axis_words(path)} = {shown(value, axis_unit(path))}" for path, value in point) or study.case.name
    )


def interval(results: StudyResults) -> str:
    """Meaning of ±."""
    count = len(results.runs)
    over = f"{count} starts" if not results.study.axes else "the starts of a point"
    return f"± is the {100 * results.study.fields.confidence:zg} % interval of the mean over {over} (Student's t)"


def verdict_of(results: StudyResults) -> str:
    """The verdict on the starts of one case; of a study with axes its name."""
    if results.study.axes or not results.summaries:
        return f"Study: {results.study.case.name}"
    return verdict(together(results.summaries, results.mean)) or results.study.case.name


def sections(results: StudyResults) -> list[Section]:
    """The parts of the page."""
    study, boxes = results.study, tiles(results.rows) if not results.study.axes else []
    varied = f" Varied: {', '.join(axis_words(axis.name) for axis in study.axes)}." if study.axes else ""
    frame = summary_frame(results)
    if boxes:
        paths = {path for row in results.rows for path in (row.path, row.held)} | {"jump.belanger_deviation"}
        top = [item.heading for item in study.collect if item.path in paths]
        frame = frame[~frame["number"].isin(top)]
    held = holding(results)
    numbers = Table(frame.values.tolist(), list(frame.columns))
    return [
        Section("", [Boxes(boxes), Text(f"{interval(results)}. {results.status()}.{varied}", "sure")]),
        Section("", by_point(results) if study.axes else by_member(results)),
        Section("", [Items(doubts(results), "What to know")]),
        Section("Numbers", [numbers, *starmap(picture, draw(results).items())]),
        Section("What holds", [Items(held), Text(HOLDS if held else "", "small")]),
        rating.section(results),
        Section("Errors within single runs", [Table(*_own_errors(results)), Text(OWN_ERRORS)]),
        repeating(f"sweep {results.folder}", study.to_yaml()),
    ]  # fmt: skip


HOLDS = "In the maps the factor is 1 along the solid line, and the lower end of its interval along the dashed line."
OWN_ERRORS = (
    "A single run states an error of its own. chi2/dof compares the scatter of members with it: about 1 to 1.4 where "
    "the errors of single runs hold, above 1.5 where they are too small."
)


def _own_errors(results: StudyResults) -> tuple[list[list[Any]], list[str]]:
    study, frame = results.study, flat(results.table, results.study)
    rows = []
    for index in range(len(frame)):
        for item in study.collect:
            numbers = [float(frame[f"{item.path}_{name}"][index]) for name in ("sd", "own_error", "chi2")]
            if isfinite(numbers[1]):
                sd, own = (
                    two_digits(number) if number > 0 else shown(number)
                    for number in (item.scale * n for n in numbers[:2])
                )
                name = [point_name(study, index)] if study.axes else []
                rows.append([*name, item.heading, sd, own, shown(numbers[2], digits=2)])
    heads = ["number", "standard deviation of members", "standard error within a run", "chi2/dof"]
    return rows, ["point", *heads] if study.axes else heads


def repeating(command: str, study: str, *packages: str) -> Section:
    """Means to repeat a study: versions, also of more packages, its command and its file."""
    versions_text = ", ".join(f"{name} {text}" for name, text in versions(*packages).items())
    again = f"`lammps-jump {command}` goes on with this study, or does nothing where all is there."
    return Section("How to repeat it", [Table([("Versions", versions_text)]), Text(again), Code(study, "study.yaml")])


def write_study_page(path: Path, kind: str, case: Case, verdict: str, parts: Sequence[Section]) -> Path:
    """Write the page of a study of a case; `kind` says what study it is."""
    name = ": ".join(filter(None, (case.name, case.fields.description)))
    return write_text(path, render(verdict, parts, tab=f"{case.name}: {kind}", name=name))


def write_page(results: StudyResults) -> Path:
    """Write ``sweep.html`` and the figures."""
    path = results.folder / "sweep.html"
    return write_study_page(path, "study", results.study.case, verdict_of(results), sections(results))
