# SPDX-License-Identifier: GPL-2.0-or-later
"""The page of a calibration: the verdict, measured values next to runs, the posterior, the runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from lammps_jump.analysis.draw.style import BLACK, BLUE, GOLD, GREY, RED, drawing, save
from lammps_jump.analysis.report.page import (
    Boxes,
    Items,
    NumberBox,
    Player,
    PlayerChoice,
    Section,
    Table,
    Text,
    picture,
)
from lammps_jump.folders import require_no_link
from lammps_jump.quoting import typed
from lammps_jump.runs.run import Run
from lammps_jump.sweeps.page import LARGEST, player_of, repeating, write_study_page
from lammps_jump.sweeps.study import axis_heading, axis_unit
from lammps_jump.units import ABSENT, shown

from .answer import brief, named, point_text
from .model import Model
from .posterior import Posterior
from .study import Calibration

PAGE = "calibration.html"
MOST_PLAYED = 6
"""Points whose runs can be watched on the page."""
PARAMETER_HEADS = ("number", "best", "95 % from", "to", "looked for in", "identified")
TARGET_HEADS = ("target", "measured", "error", "at the best values", "scatter over starts", "error of the emulator")
RUN_HEADS = ("point", "round", "distance [errors]", "runs")
BAND = 2.0
"""Standard errors that a band shows to either side."""


def parameter_rows(data: Mapping[str, Any]) -> list[list[Any]]:
    """The varied numbers."""
    return [
        [axis_heading(path), *(shown(one[key], digits=3) for key in ("best", "low", "high")),
         f"{one['prior'][0]:zg} to {one['prior'][1]:zg}", shown(one["identified"])]
        for path, one in data["parameters"].items()
    ]  # fmt: skip


def target_rows(data: Mapping[str, Any]) -> list[list[Any]]:
    """Measured numbers next to those at the best values; of curves how many points there are."""
    rows: list[list[Any]] = []
    for name, one in data["targets"].items():
        loo = shown(data["loo"][name]["emulator"], digits=2)
        if "at" in one:
            rows.append([name, f"{len(one['at'])} points", ABSENT, ABSENT, ABSENT, loo])
        else:
            numbers = (shown(one[key]) for key in ("measured", "error", "at_best", "spread"))
            rows.append([name, *numbers, loo])
    return rows


def run_rows(data: Mapping[str, Any]) -> list[list[Any]]:
    """Points with their distance from the measurements and their run folders, the nearest first."""
    rounds = [one["of"] for one in data["rounds"]]
    return [
        [point_text(one["values"]), rounds[one["round"]], shown(one["distance"], digits=2),
         ", ".join(one["runs"]) or "left out"]
        for one in nearest_first(data)
    ]  # fmt: skip


def nearest_first(data: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """The points, in the order of their distance from the measurements; those without one last."""
    return sorted(data["points"], key=lambda one: np.inf if one["distance"] is None else one["distance"])


def boxes(data: Mapping[str, Any]) -> list[NumberBox]:
    """Best values with their ranges."""
    return [
        NumberBox(named(path), brief(one["best"]) if one["identified"] else ABSENT, axis_unit(path), "",
            f"95 %: {brief(one['low'])} to {brief(one['high'])}")
        for path, one in data["parameters"].items()
        if one["best"] is not None
    ]  # fmt: skip


def players(data: Mapping[str, Any], folder: Path) -> list[PlayerChoice | Text]:
    """Runs of the points that are nearest to the measurements, as many as the page has room for."""
    kept: list[Player] = []
    names: list[str] = []
    room = LARGEST
    for one in nearest_first(data)[:MOST_PLAYED]:
        for start, place in enumerate(one["runs"], 1):
            try:
                player = player_of(Run(folder / place))
            except (OSError, ValueError):  # without discs in its frames, or damaged: the next one will do
                continue
            room -= len(player.frames)
            if room >= 0 or not kept:
                kept.append(player)
                names.append(f"{point_text(one['values'])}, start {start}")
    if not kept:
        return []
    return [
        PlayerChoice(kept, names, 0),
        Text("The runs that are nearest to the measurements, the nearest first.", "small"),
    ]


def sections(
    study: Calibration, data: Mapping[str, Any], folder: Path, pictures: Mapping[str, Sequence[Path]]
) -> list[Section]:
    """The parts of the page; `pictures` are those of ``measured`` and ``posterior``."""
    drawn = {part: [picture(path, CAPTIONS[path.stem]) for path in paths] for part, paths in pictures.items()}
    again = typed("analyze", folder / "RUN", "--set", "analysis.figures=default")
    one = f"`{again}` makes the report of one of these runs."
    sentence = (
        f"{data['runs']} runs of at most {data['budget']}, {data['failed']} left out. All values in a range were "
    )
    return [
        Section("", [Boxes(boxes(data)), Text(f"{sentence}equally likely before.", "sure")]),
        Section("", [Items(data["notes"], "What to know")]),
        Section("Measured, and runs", [*drawn.get("measured", ()), Table(target_rows(data), TARGET_HEADS),
                                       *players(data, folder)]),
        Section("What is likely", [Table(parameter_rows(data), PARAMETER_HEADS), *drawn.get("posterior", ())]),
        Section("Runs", [Table(run_rows(data), RUN_HEADS), Text(one)]),
        repeating(f"calibrate {folder}", study.to_yaml(), "scikit-learn"),
    ]  # fmt: skip


CAPTIONS = {
    "calibration_posterior": "How likely the numbers are. Shaded: the 95 % range; red: the best values; dots: points "
    "with runs; A and B: two places that fit about as well, where numbers hide each other",
    "calibration_targets": "Runs against each varied number. Shaded: measured ± two errors; red: the best values",
    "calibration_curves": "Measured curves, with ± two errors; runs of the point nearest to the best values; emulator "
    "at the best values, with ± two standard deviations",
}


Ridges = Mapping[tuple[str, str], Sequence[Sequence[float]]]
"""Two points of each pair of varied numbers that hide each other, by their paths."""


def ridges(data: Mapping[str, Any]) -> Ridges:
    """The ridges of an answer."""
    return {(path, one["hidden_by"]): one["ridge"] for path, one in data["parameters"].items() if one["ridge"]}


def draw_posterior(
    study: Calibration, posterior: Posterior, points: np.ndarray, path: Path, hidden: Ridges | None = None
) -> Path:
    """Draw the density of each varied number, and samples of each pair, where a ridge is seen with two points on it."""
    pairs = list(combinations(range(len(study.paths)), 2))
    columns = min(len(study.paths) + len(pairs), 3)
    rows = -(-(len(study.paths) + len(pairs)) // columns)
    low, wide = study.bounds[:, 0], np.ptp(study.bounds, axis=1)
    drawn, best = low + posterior.drawn() * wide, low + posterior.best * wide
    with drawing(3.4 * columns, 2.8 * rows, rows, columns, squeeze=False) as (figure, grid):
        panels = list(grid.flat)
        for empty in panels[len(study.paths) + len(pairs) :]:
            empty.axis("off")
        for k, name in enumerate(study.paths):
            panel, (left, right) = panels[k], (low[k] + wide[k] * np.array(posterior.range_of(k)))
            panel.axvspan(left, right, color="#dfe7f2", lw=0)
            values, weights = low[k] + wide[k] * posterior.places[:, k], posterior.weights
            panel.hist(values, 40, range=(low[k], low[k] + wide[k]), weights=weights, color=BLUE, histtype="stepfilled")
            panel.axvline(best[k], color=RED)
            panel.set(xlabel=axis_heading(name), xlim=study.bounds[k], yticks=[], ylabel="likelihood")
        for panel, (i, j) in zip(panels[len(study.paths) :], pairs, strict=False):
            panel.plot(drawn[:, i], drawn[:, j], ".", ms=2, color=BLUE, alpha=0.25)
            panel.plot(points[:, i], points[:, j], "o", ms=4, mfc="white", mec=GREY)
            panel.plot(best[i], best[j], "+", ms=12, mew=2, color=RED)
            panel.set(xlabel=axis_heading(study.paths[i]), ylabel=axis_heading(study.paths[j]))
            panel.set(xlim=study.bounds[i], ylim=study.bounds[j])
            _mark_ridge(panel, (study.paths[i], study.paths[j]), hidden or {})
        return save(figure, path)


def draw_samples(samples: xr.Dataset, parameters: Mapping[str, Mapping[str, Any]]) -> Figure:
    """Histograms of the samples of the posterior, a panel for each varied number, with its 95 % range and its best."""
    columns = min(len(parameters), 3)
    rows = -(-len(parameters) // columns)
    with drawing(3.4 * columns, 2.8 * rows, rows, columns, squeeze=False) as (figure, grid):
        for empty in grid.flat[len(parameters) :]:
            empty.axis("off")
        for panel, (path, one) in zip(grid.flat, parameters.items(), strict=False):
            panel.axvspan(one["low"], one["high"], color="#dfe7f2", lw=0)
            panel.hist(samples[path].values, 40, color=BLUE, histtype="stepfilled")
            panel.axvline(one["best"], color=RED)
            panel.set(xlabel=axis_heading(path), yticks=[], ylabel="likelihood")
        return figure


def _mark_ridge(panel: Any, pair: tuple[str, str], hidden: Ridges) -> None:
    """Mark the two points of a pair that hides each other: those that the notes name."""
    turned = pair not in hidden
    marks = hidden.get((pair[1], pair[0]) if turned else pair, ())
    for mark, place in zip("AB", marks, strict=False):
        x, y = reversed(place) if turned else place
        panel.plot(x, y, "o", ms=13, mfc="white", mec=RED, mew=1.5)
        panel.text(x, y, mark, ha="center", va="center_baseline", fontsize=8, color=BLACK)


def draw_targets(study: Calibration, model: Model, posterior: Posterior, path: Path) -> Path:
    """Draw each measured number against each varied one: points with runs, and the measurement as a band."""
    numbers = [k for k, part in enumerate(model.parts) if not part.target.axis]
    low, wide = study.bounds[:, 0], np.ptp(study.bounds, axis=1)
    rows, columns = len(numbers), len(study.paths)
    with drawing(3.4 * columns, 2.6 * rows, rows, columns, squeeze=False, sharey="row") as (figure, grid):
        for row, k in zip(grid, numbers, strict=True):
            target, values = model.parts[k].target, model.means[k][:, 0]
            band = target.measured[0] + BAND * target.error[0] * np.array([-1, 1])
            for column, panel in enumerate(row):
                panel.axhspan(*band, color="#f0e6c8", lw=0)
                panel.axhline(target.measured[0], color=GOLD, lw=1.2)
                panel.plot(low[column] + wide[column] * model.places[:, column], values, "o", ms=4, color=BLUE)
                if columns == 1:
                    along = np.linspace(0, 1, 101)[:, None]
                    mean, sd = model.target_at(k, along)
                    x = low[0] + wide[0] * along[:, 0]
                    panel.plot(x, mean[:, 0], color=BLACK, lw=1)
                    edges = (mean[:, 0] + sign * BAND * sd[:, 0] for sign in (-1, 1))
                    panel.fill_between(x, *edges, color=GREY, alpha=0.25, lw=0)
                panel.axvline(low[column] + wide[column] * posterior.best[column], color=RED, lw=1)
                panel.set(xlabel=axis_heading(study.paths[column]), xlim=study.bounds[column])
            row[0].set_ylabel(target.name)
        return save(figure, path)


def draw_curves(model: Model, posterior: Posterior, runs: Sequence[np.ndarray], path: Path) -> Path:
    """Draw measured curves, those of the runs (each a row of values of all targets), and the emulator's."""
    curves = [k for k, part in enumerate(model.parts) if part.target.axis]
    with drawing(7.2, 3.0 * len(curves), len(curves), 1, squeeze=False) as (figure, grid):
        for panel, k in zip(grid.flat, curves, strict=True):
            target = model.parts[k].target
            for number, values in enumerate(runs[k]):
                panel.plot(target.at, values, color=GREY, lw=0.9, label=None if number else "runs at the nearest point")
            mean, sd = model.target_at(k, posterior.best[None])
            panel.fill_between(target.at, *(mean[0] + sign * BAND * sd[0] for sign in (-1, 1)), color=BLUE, alpha=0.2)
            panel.plot(target.at, mean[0], color=BLUE, label="emulator at the best values")
            label = "measured" if model.parts[k].possible is None else "measured; error estimated"
            bars = {"fmt": "o", "ms": 4, "mfc": "white", "color": BLACK, "capsize": 2, "label": label}
            panel.errorbar(target.at, target.measured, BAND * target.error, **bars)
            panel.set(xlabel=f"{target.axis} [SI]", ylabel=f"{target.name} [SI]")
            panel.legend()
        return save(figure, path)


def draw(
    study: Calibration, model: Model, posterior: Posterior, near: Sequence[np.ndarray], folder: Path, hidden: Ridges
) -> dict[str, list[Path]]:
    """Draw all figures; `near` holds the values of each target in the runs of the nearest point, shape (starts, k)."""
    place = folder / "figures"
    require_no_link(place)
    place.mkdir(exist_ok=True)
    low, wide = study.bounds[:, 0], np.ptp(study.bounds, axis=1)
    measured = []
    if any(part.target.axis for part in model.parts):
        measured.append(draw_curves(model, posterior, near, place / "calibration_curves.png"))
    if any(not part.target.axis for part in model.parts):
        measured.append(draw_targets(study, model, posterior, place / "calibration_targets.png"))
    points = low + model.places * wide
    likely = draw_posterior(study, posterior, points, place / "calibration_posterior.png", hidden)
    return {"measured": measured, "posterior": [likely]}


def write_page(
    study: Calibration, data: Mapping[str, Any], folder: Path, pictures: Mapping[str, Sequence[Path]]
) -> Path:
    """Write ``calibration.html``."""
    parts = sections(study, data, folder, pictures)
    return write_study_page(folder / PAGE, "calibration", study.case, data["verdict"], parts)
