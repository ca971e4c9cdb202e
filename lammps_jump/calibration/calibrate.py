# SPDX-License-Identifier: GPL-2.0-or-later
"""Estimates numbers of a case from measurements: runs at points of their ranges, in rounds, until it has settled."""

from __future__ import annotations

import html
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypedDict, Unpack

import numpy as np
from pydantic import BaseModel, FiniteFloat, NonNegativeInt, StringConstraints, model_validator

from lammps_jump.analysis.report.page import show_page
from lammps_jump.calibration import page
from lammps_jump.case.case import ReadCase
from lammps_jump.dump.exports import read_netcdf, write_netcdf
from lammps_jump.errors import CaseError, NearestNames
from lammps_jump.files import STUDY_FILES, plain, read_json, write_json, write_text
from lammps_jump.folders import Marker
from lammps_jump.foreign import foreign
from lammps_jump.provenance import usable_cores, versions
from lammps_jump.quoting import typed
from lammps_jump.runs.folder import run_folder
from lammps_jump.runs.run import Case, Run
from lammps_jump.sweeps import Pool, Sweep, open_sweep, slurm
from lammps_jump.sweeps.members import RUNS

from .answer import answer, no_answer, unmet, with_words
from .besides import NearestEffects, tried
from .posterior import require_sklearn
from .search import POINTS, Fit, PointResults, Search, SearchProgress
from .study import Calibration, read_calibration

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.figure import Figure

    from lammps_jump.script.job import Site

ANSWER, SAMPLES, BEST = "calibration.json", "samples.nc", "best.yaml"


class CalibrateOptions(TypedDict, total=False):
    """Further options of `calibrate`."""

    seed: int | None
    set: Mapping[str, object] | None
    jobs: int | None
    retry: bool


def calibrate(
    case: str | Path | Mapping[str, Any] | ReadCase,
    targets: object = None,
    vary: Mapping[str, Sequence[float]] | None = None,
    out: str | Path | None = None,
    *,
    budget: int | None = None,
    members: int | None = None,
    progress: Callable[[SearchProgress], None] = lambda progress: None,
    **more: Unpack[CalibrateOptions],
) -> Calibrated:
    """Find numbers of a case from measurements; what the folder holds is not run again.

    Parameters
    ----------
    case : str, Path, mapping or Case
        A case, its file, a study file of the kind calibrate, or the folder of a calibration.
    targets : list or mapping, optional
        What was measured: ``"jump.y2=6.7 ± 0.1"``, ``{"data": "heap.csv", "columns": "x=x,heap.depth=h ± 0.01"}``; or
        ``{"jump.y2": (6.7, 0.1)}``. Units are those of ``summary.json``.
    vary : mapping, optional
        Range of each number that is to be estimated, by its path: ``{"contact.friction": (0.1, 0.9)}``.
    out : str or Path, optional
        Default ``runs/<stem of the file>_calibrate``.
    budget : int, optional
        Most runs; default 40.
    members : int, optional
        Starts of each point; default 2.
    progress : callable, optional
        Called with a `SearchProgress`.
    more
        seed of the points; set, changed values of the case; jobs, processes at once; retry what failed.

    Raises
    ------
    CaseError, SetupError
        Before anything is run: a field that cannot be used, a folder in use, scikit-learn is missing.
    RunInterrupted
        Ctrl-C or SIGTERM; the same call goes on.
    """
    require_sklearn()
    jobs, retry = more.pop("jobs", None), more.pop("retry", False)
    given = {"targets": targets, "vary": vary, "budget": budget, "members": members}
    study = read_calibration(case, **given, **more)
    folder = Path(out) if out is not None else default_folder(case, study.case)
    ranks = study.case.fields.engine.ranks
    most = jobs or max(1, usable_cores() // (ranks if isinstance(ranks, int) else 1))
    with run_folder(folder, Marker("calibrate", STUDY_FILES["calibrate"], {})), Pool(min(most, study.budget)) as pool:
        search = Search(study, folder, retry, progress)
        observed = search.go_on(pool)
        besides = search.look_besides(observed, pool)
        pool.close()
        write(search, observed, besides)
    return Calibrated(folder)


def default_folder(case: str | Path | Mapping[str, Any] | ReadCase, read: Case) -> Path:
    """Folder of a calibration when none is named; a folder of one is its own."""
    if isinstance(case, str | Path) and Path(case).is_dir():
        return Path(case)
    stem = Path(case).stem if isinstance(case, str | Path) else read.name
    return Path("runs") / f"{stem}_calibrate"


def write(search: Search, observed: PointResults, besides: NearestEffects | None) -> None:
    """Write the answer: ``calibration.json``, ``samples.nc``, ``best.yaml``, figures, and the page."""
    study, fit = search.study, search.fit(observed)
    points, folder = len(search.points), search.folder
    listed = _listed(search, observed)
    runs, pictures = sum(map(len, observed.folders.values())) + (besides.runs if besides else 0), {}
    if fit.model is None or fit.posterior is None:
        result = no_answer(study, points, len(fit.good), fit.needed)
    else:
        not_met = unmet(fit.model, fit.posterior, fit.nearest, besides)
        summaries = {number: observed.summaries[number] for number in fit.good}
        result = answer(study, fit.model, fit.posterior, summaries, not_met) | {"besides": tried(besides)}
        for number, distances in zip(fit.good, fit.model.distances_of_points(), strict=True):
            listed[number]["distance"] = float(distances.max())
        result |= {"nearest": fit.good[fit.nearest]}
        write_netcdf(samples_of(study, fit), folder / SAMPLES)
        best = {path: one["best"] for path, one in result["parameters"].items()}
        write_text(folder / BEST, study.case.replace(best).to_yaml())
        values = [one[fit.nearest] for one in fit.model.values]
        pictures = page.draw(study, fit.model, fit.posterior, values, folder, page.ridges(result))
    data = plain(with_words({
        **result, "runs": runs + len(observed.failures), "failed": len(observed.failures),
        "failures": observed.failures, "budget": study.budget, "members": study.members, "seed": study.seed,
        "rounds": [{"of": one["of"], "points": len(one["points"])} for one in search.rounds], "points": listed,
        "name": study.case.name, "description": study.case.fields.description, "versions": versions("scikit-learn"),
    }))  # fmt: skip
    write_json(folder / ANSWER, data, indent=2)
    page.write_page(study, data, folder, pictures)


def _listed(search: Search, observed: PointResults) -> list[dict[str, Any]]:
    """The points: values, number of the round, run folders; the distance from the measurements is not known yet."""
    rounds = [(place, point) for place, one in enumerate(search.rounds) for point in one["points"]]
    folders = ([str(one.relative_to(search.folder)) for one in observed.folders.get(k, [])] for k in range(len(rounds)))
    return [
        {"values": dict(zip(search.study.paths, point, strict=True)), "round": place, "runs": runs, "distance": None}
        for (place, point), runs in zip(rounds, folders, strict=True)
    ]


def samples_of(study: Calibration, fit: Fit) -> xr.Dataset:
    """Samples of the posterior, of equal weight: the varied numbers, and what the emulators make of each target."""
    import xarray as xr  # 0.3 s

    assert fit.posterior is not None and fit.model is not None
    drawn = fit.posterior.drawn()
    whole = study.bounds[:, 0] + drawn * np.ptp(study.bounds, axis=1)
    data: dict[str, Any] = {path: ("sample", whole[:, k]) for k, path in enumerate(study.paths)}
    for number, part in enumerate(fit.model.parts):
        if not part.target.axis and part.target.name not in data:
            data[part.target.name] = ("sample", fit.model.target_at(number, drawn)[0][:, 0])
    return xr.Dataset(data, attrs={"prior": "flat in the ranges"})


class _BestValues(BaseModel, strict=True):
    best: FiniteFloat | None
    low: FiniteFloat | None
    high: FiniteFloat | None
    identified: bool
    at_edge: bool
    prior: list[FiniteFloat]


class _Point(BaseModel, strict=True):
    values: dict[str, FiniteFloat]
    runs: list[Annotated[str, StringConstraints(pattern=rf"^{POINTS}/{RUNS}/[0-9A-Za-z]+$")]]


class StoredAnswer(BaseModel, strict=True):
    """Content of ``calibration.json`` as it is read back; it may have been handed on."""

    verdict: str
    notes: list[str]
    parameters: dict[str, _BestValues]
    correlation: dict[str, dict[str, FiniteFloat | None]]
    points: list[_Point]
    nearest: NonNegativeInt | None = None

    @model_validator(mode="after")
    def _known(self) -> StoredAnswer:
        if self.nearest is not None and self.nearest >= len(self.points):
            raise ValueError(f"nearest: {self.nearest} of {len(self.points)} points")
        return self


class Calibrated(NearestNames):
    """A calibration, seen through its folder.

    Parameters
    ----------
    folder : str or Path

    Attributes
    ----------
    folder : Path
    data : dict
        What ``calibration.json`` holds.

    Raises
    ------
    CaseError
        No answer there.
    """

    in_words = "a calibration"

    def __init__(self, folder: str | Path):
        self.folder = Path(folder)
        again = f"`{typed('calibrate', folder)}` goes on there"
        if not (self.folder / ANSWER).exists():
            raise CaseError(f"{folder}: holds no answer ({ANSWER}); {again}")
        with foreign(CaseError, f"{self.folder / ANSWER}: is no answer of a calibration", again):
            self.data: dict[str, Any] = read_json(self.folder / ANSWER)
            StoredAnswer.model_validate(self.data)

    @property
    def path(self) -> Path:
        """The folder, by the name that pathlib has for it."""
        return self.folder

    @property
    def table(self) -> pd.DataFrame:
        """The varied numbers, a row each: best, low and high (95 %), and whether the data tells it."""
        import pandas as pd  # 0.3 s

        columns = ["best", "low", "high", "identified", "at_edge"]
        return pd.DataFrame.from_dict(self.parameters, orient="index").reindex(columns=columns)

    def plot(self) -> Figure:
        """The samples of the posterior: a panel for each varied number, its range marked; matplotlib, without pyplot.

        Raises
        ------
        CaseError
            No samples: the calibration has no answer yet.
        """
        if not self.samples.sizes.get("sample"):
            raise CaseError(f"{self.folder}: holds no samples to draw; `{typed('calibrate', self.folder)}` goes on")
        return page.draw_samples(self.samples, self.parameters)

    def show(self) -> None:
        """Show the page of the calibration in the browser.

        Raises
        ------
        CaseError
            It is not there.
        """
        written = self.folder / "calibration.html"
        if not written.is_file():
            raise CaseError(f"{written}: is not there; `{typed('calibrate', self.folder)}` writes it")
        show_page(written)

    def _repr_html_(self) -> str:
        return f"<p>{html.escape(self.verdict)}</p>{self.table.to_html()}"

    @property
    def verdict(self) -> str:
        """The answer in a few sentences."""
        return str(self.data["verdict"])

    @property
    def notes(self) -> list[str]:
        """Notes in addition to the answer."""
        return list(self.data["notes"])

    @property
    def parameters(self) -> dict[str, dict[str, Any]]:
        """By path: best, low and high (95 %), prior, identified, at_edge."""
        return dict(self.data["parameters"])

    @property
    def correlation(self) -> dict[str, dict[str, float]]:
        """Between the varied numbers, by their paths."""
        return dict(self.data["correlation"])

    @cached_property
    def samples(self) -> xr.Dataset:
        """Samples of the posterior, of equal weight, over ``sample``: varied numbers and emulated targets."""
        import xarray as xr  # 0.3 s

        if not (self.folder / SAMPLES).is_file():
            return xr.Dataset({path: ("sample", np.zeros(0)) for path in self.parameters})
        return read_netcdf(self.folder / SAMPLES)

    @property
    def best(self) -> Case:
        """The case at the best values."""
        return Case.load(self.folder / BEST)

    @property
    def runs(self) -> list[Run]:
        """The runs of the point that is nearest to the best values."""
        if self.data.get("nearest") is None:
            return []
        return [Run(self.folder / one) for one in self.data["points"][self.data["nearest"]]["runs"]]

    @property
    def sweep(self) -> Sweep:
        """All runs, as a study."""
        return open_sweep(self.folder / POINTS)

    def __repr__(self) -> str:
        return f"Calibrated({str(self.folder)!r}, {self.verdict!r})"


def submit(case: str | Path, out: Path | None, site: Site, *, at_once: int | None = None, **given: Any) -> str:
    """Submit the runs that the present round lacks as an array job of Slurm; its number, empty where none is lacking.

    The same command without Slurm goes on with the next round.
    """
    require_sklearn()
    study = read_calibration(case, **given)
    folder = Path(out) if out is not None else default_folder(case, study.case)
    with run_folder(folder, Marker("calibrate", STUDY_FILES["calibrate"], {})):
        search = Search(study, folder, False, lambda progress: None)
        search.begin()
        return slurm.submit(search.sweep(), site, at_once=at_once or slurm.AT_ONCE)
