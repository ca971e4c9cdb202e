# SPDX-License-Identifier: GPL-2.0-or-later
"""A curve of a run, or of the starts of a study, against a curve that a person has measured."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from math import nan
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lammps_jump.analysis.draw.style import drawing, save
from lammps_jump.analysis.statistics import student
from lammps_jump.analysis.tables import Column, markdown, paragraphs
from lammps_jump.calibration.targets import FEWEST, curve_of, measured_of, parse_columns
from lammps_jump.errors import CaseError
from lammps_jump.files import COMPARED_FILES, SUMMARY_FILE, write_json, write_text
from lammps_jump.folders import Marker, publish, require_no_link, results_folder
from lammps_jump.quoting import figure_text, visible
from lammps_jump.runs.summary import Results, open_results, status_of
from lammps_jump.sweeps.members import RUNS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

RUN, MEASURED = "#0b2f6b", "#a02c3c"
Curves = list[tuple[np.ndarray, np.ndarray]]
"""Axis and values of each start."""


@dataclass(frozen=True)
class Distance:
    """Distance of the curve of a run from measured points; units are those of the two columns.

    Attributes
    ----------
    column, measured : str
        ``TABLE.COLUMN`` of the run, and the column of the file.
    points, points_measured : int
        Measured points that lie where all starts have a curve, and all of them.
    starts : int
    mean, mean_interval : float
        Mean of run - measured, and ± of its 95 % interval over starts (Student's t); NaN of one run.
    rms : float
        Root mean square of the difference, of the mean curve of all starts.
    rms_over_range : float
        The same over the range of the measured values.
    """

    column: str
    measured: str
    points: int
    points_measured: int
    starts: int
    mean: float
    mean_interval: float
    rms: float
    rms_over_range: float


def starts_of(folder: Path) -> list[Results]:
    """The results of the runs of a study that are complete, or of the folder itself.

    Raises
    ------
    CaseError
        A folder of neither, or without a complete run.
    DumpError
        A run that is not complete, or a summary that is none.
    SetupError
        A run of the study is a link.
    """
    if not (folder / RUNS).is_dir():
        return [open_results(folder)]
    require_no_link(folder / RUNS)
    results = []
    for path in sorted((folder / RUNS).iterdir()):
        require_no_link(path)
        if (path / SUMMARY_FILE).exists() and status_of(path) == "complete":
            results.append(open_results(path))
    if not results:
        raise CaseError(f"{folder} holds no complete run; name a run folder, or that of the starts of one case")
    return results


def distance(curves: Curves, at: np.ndarray, measured: np.ndarray) -> dict[str, Any]:
    """Deviation of curves (axis, values) of some starts from measured points; keys as of `Distance`.

    Curves are taken at the measured points by straight lines. Points beyond the end of a curve are left out.

    Raises
    ------
    CaseError
        Fewer than `FEWEST` points in common.
    """
    low, high = max(x[0] for x, _ in curves), min(x[-1] for x, _ in curves)
    inside = (at >= low) & (at <= high)
    if inside.sum() < FEWEST:
        raise CaseError(
            f"the run has its curve from {low:zg} to {high:zg}, the points lie from {at.min():zg} to {at.max():zg}: "
            f"{inside.sum()} points in common, {FEWEST} are needed; are the units the same (SI)?"
        )
    off = np.array([np.interp(at[inside], x, y) - measured[inside] for x, y in curves])
    means, n = off.mean(axis=1), len(curves)
    rms, extent = float(np.sqrt(np.mean(off.mean(axis=0) ** 2))), float(np.ptp(measured))
    return {
        "points": int(inside.sum()),
        "points_measured": len(at),
        "starts": n,
        "mean": float(means.mean()),
        "mean_interval": float(student(n - 1, 0.975) * means.std(ddof=1) / np.sqrt(n)) if n > 1 else nan,
        "rms": rms,
        "rms_over_range": rms / extent if extent > 0 else nan,
    }


def compare_with_data(folder: Path, data: Path, columns: str, out: Path | None = None) -> tuple[list[Distance], Path]:
    """Hold curves of a run, or of the starts of a study, against a person's measured ones.

    Parameters
    ----------
    folder : Path
        A run folder, or that of the starts of one case.
    data : Path
        CSV with a line of heads; SI. Lines that begin with # are left out.
    columns : str
        As of `parse_columns`.
    out : Path, optional
        Folder of ``compared.json``, ``compared.md`` and ``compared.png``; unless given, ``<folder>_against_<data>``.

    Returns
    -------
    list of Distance, Path
        One for each pair of columns but the axis, and the folder.

    Raises
    ------
    CaseError
        A table, column or file that is not there, a value that is no number, no points in common.
    DumpError
        A run that is not complete, or whose tables are not as its analysis wrote them.
    SetupError
        `out` holds files of others, or what was compared with another run.
    """
    pairs = parse_columns(columns)
    (axis, own_axis), *wanted = pairs.items()
    given, places = measured_of(data, pairs), starts_of(folder)
    at = given[own_axis]
    distances, drawn = [], []
    for name, own in wanted:
        curves = [curve_of(place, axis, name) for place in places]
        if any(len(x) < FEWEST for x, _ in curves):
            raise CaseError(f"{name}: a run has fewer than {FEWEST} values of it")
        distances.append(Distance(name, own, **distance(curves, at, given[own])))
        drawn.append((name, own, curves))
    out = out or Path(f"{folder.absolute().name}_against_{data.stem}")
    marker = Marker("comparison", COMPARED_FILES, {"of": str(folder.absolute())})
    with results_folder(out, marker, "of") as stage:
        save(drawn_of(drawn, axis, given), stage / "compared.png")
        write_json(stage / "compared.json", [asdict(one) for one in distances])
        write_text(stage / "compared.md", page(distances, folder, data))
        publish(stage, out)
    return distances, out


def drawn_of(drawn: list[tuple[str, str, Curves]], axis: str, given: Mapping[str, np.ndarray]) -> Figure:
    """Each pair of columns in a panel: curves of the starts as lines, measured points, the first of `given` along x."""
    with drawing(7, 3.2 * len(drawn), len(drawn), squeeze=False) as (figure, panels):
        for place, (name, own, curves) in zip(panels[:, 0], drawn, strict=True):
            for number, (x, y) in enumerate(curves):
                place.plot(x, y, color=RUN, lw=1.4, label=None if number else f"run: {figure_text(name)}")
            at = next(iter(given.values()))
            place.plot(at, given[own], "o", ms=4, mfc="white", mec=MEASURED, label=f"measured: {figure_text(own)}")
            place.set_xlabel("time [s]" if axis == "time" else f"{figure_text(axis)} [SI]")
            place.set_ylabel(f"{figure_text(name)} [SI]")
            place.legend()
    return figure


def page(distances: list[Distance], folder: Path, data: Path) -> str:
    """The distances as a page in Markdown."""
    columns: dict[str, Column] = {
        "run": lambda one: cell(one["column"]),
        "measured": lambda one: cell(one["measured"]),
        "points:": "{points} of {points_measured}",
        "mean of run - measured:": lambda one: (
            f"{one['mean']:z.4g}" + (f" ± {one['mean_interval']:z.2g}" if one["starts"] > 1 else "")
        ),
        "root mean square:": "{rms:z.3g}",
        "over the measured range:": lambda one: f"{100 * one['rms_over_range']:z.1f} %",
    }
    starts = distances[0].starts
    sentence = (
        f"± is the 95 % interval over {starts} starts."
        if starts > 1
        else "One run has no interval: repeat it from other starts."
    )
    head = f"# {visible(folder.absolute().name)} against {visible(data.name)}"
    return paragraphs(head, markdown(columns, map(asdict, distances)), sentence, "![the curves](compared.png)")


def cell(text: str) -> str:
    """A text as a cell of a table in Markdown."""
    return visible(text).replace("|", "\\|")
