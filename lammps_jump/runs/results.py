"""The analyses of a run behind one door: files into its folder, or results held in memory."""

from __future__ import annotations

import html
import logging
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from lammps_jump.analysis import analyze, extras, guess, passes, profiles, result_figures
from lammps_jump.analysis.draw import film
from lammps_jump.analysis.flow import FlowContext, from_scene
from lammps_jump.analysis.report import page
from lammps_jump.case.case import ReadCase, load_case
from lammps_jump.case.checks import MOST_BINS
from lammps_jump.dump.find import find_dump, read_forces
from lammps_jump.dump.read import open_dump
from lammps_jump.errors import CaseError, DumpError
from lammps_jump.scene.scene import Scene

from .steady import studied_reach
from .summary import write_summary

log = logging.getLogger(__name__)
UNKNOWN = float("nan")


class Numbers(Mapping[str, Any]):
    """Numbers of one analysis, by attribute or by key of ``summary.json``; SI.

    A number that could not be measured is NaN. ``<name>_error`` is the standard error of the mean of ``<name>``, in
    its unit, and NaN where one run cannot tell it. Series over time are arrays, shape (n,).
    """

    SERIES: tuple[str, ...] = ()
    """Attributes that are the series, although the last value stands under the same key."""

    def __init__(self, values: Mapping[str, Any], series: Callable[[], Mapping[str, Any]] = dict):
        self._values, self._series = dict(values), series

    def __getitem__(self, name: str) -> Any:
        return self._values[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        if name in self._values and name not in self.SERIES:
            value = self._values[name]
            return UNKNOWN if value is None else value
        if name.endswith("_error") and name.removesuffix("_error") in self._values:
            return UNKNOWN
        series = self._series()
        if name in series:
            return series[name]
        raise AttributeError(f"{type(self).__name__} has no '{name}'; it has {', '.join([*self._values, *series])}")

    def asdict(self) -> dict[str, Any]:
        """The numbers as they stand in ``summary.json``."""
        return dict(self._values)

    def rows(self) -> list[tuple[str, float | str, float]]:
        """(name, value, error) of the numbers and texts."""
        plain = {name: value for name, value in self._values.items() if isinstance(value, int | float | str)}
        return [
            (name, value, getattr(self, f"{name}_error", UNKNOWN))
            for name, value in plain.items()
            if not name.endswith("_error") and not isinstance(value, bool)
        ]

    def _repr_html_(self) -> str:
        return table(self.rows())

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(f'{name}={value!r}' for name, value, _ in self.rows())})"


class Jump(Numbers):
    """The jump: verdict, reason; y1, y2, h1, h2, length, energy_loss (m); u1, u2, speed (m/s); froude, ratios."""


class Front(Numbers):
    """The front of a collapsing column: position (m), speed (m/s), comparison with theory and measurement."""


class Energy(Numbers):
    """Energy of the discs: initial (J/m), max_deviation, drift; time (s), kinetic, potential, elastic (J/m)."""

    SERIES = ("time", "kinetic", "rotational", "potential", "elastic", "total")


class Force(Numbers):
    """Force on a structure: peak (N/m), impulse (N s/m); time (s), fx, fy (N/m), moment (N)."""

    SERIES = ("time", "fx", "fy", "moment")


@dataclass(frozen=True)
class Found:
    """What the analyses found, in memory.

    Attributes
    ----------
    gathered : Gathered
    parts : dict
        As in ``summary.json``.
    shown : dict
        Full results, for figures.
    warnings : tuple of str
    """

    gathered: passes.Gathered
    parts: dict[str, Any]
    shown: dict[str, Any]
    warnings: tuple[str, ...]


def _request(case: ReadCase) -> passes.AnalysisRequest:
    """What the case asks of the analysis."""
    asked = case.fields.analysis
    inflow = case.fields.inflow
    rows = inflow if inflow is not None and inflow.kind == "rows" else None
    return passes.AnalysisRequest(
        bin_width=asked.bin_width,
        window=asked.window,
        jump=asked.jump,
        energy=asked.energy,
        front=asked.front,
        fields=asked.fields,
        animate=asked.animation,
        forces=bool(case.scene().probes),
        inflow_depth=rows.depth if rows else None,
        inflow_speed=rows.mean_speed if rows else None,
    )


def analyse(case: ReadCase, folder: Path, engine: str) -> dict[str, Any]:
    """Analyse the dump of a run folder as its case asks; the parts of the summary. Tables and figures are written."""
    quiet = not log.isEnabledFor(logging.INFO)
    return analyze.analyze_run(folder, case.scene(), _request(case), engine=engine, quiet=quiet)


def analyse_in_memory(case: ReadCase, folder: Path) -> Found:
    """Every analysis of a run folder, whether the case asks for it or not; nothing is written."""
    asked = _request(case)
    request = passes.AnalysisRequest(
        bin_width=asked.bin_width,
        window=asked.window,
        jump=True,
        energy=True,
        front=True,
        forces=asked.forces,
        inflow_depth=asked.inflow_depth,
        inflow_speed=asked.inflow_speed,
    )
    context = from_scene(
        case.scene(),
        bin_width=request.bin_width,
        window=request.window,
        inflow_depth=request.inflow_depth,
        inflow_speed=request.inflow_speed,
    )
    warnings: list[str] = []
    gathered = passes.gather(open_dump(find_dump(folder)), context, request, warnings, places=(folder,))
    parts, shown = analyze.summarise(gathered, request, warnings)
    return Found(gathered, parts, shown, tuple(dict.fromkeys(warnings)))


def analyse_dump(
    target: Path,
    case: ReadCase | None,
    diameter: float | None,
    density: float | None,
    bin_width: float | None,
    out: Path | None,
) -> tuple[Path, list[str]]:
    """Analyse a dump that is no run's; the folder of the results, and notes on what was guessed.

    Parameters
    ----------
    target : Path
        The dump, or a folder that holds one.
    case : ReadCase, optional
        The case that belongs to it.
    diameter, bin_width : float, optional
        m.
    density : float, optional
        kg/m^3; default 1000.

    Raises
    ------
    CaseError, DumpError
    """
    path = find_dump(target)
    context = _context(path, case, diameter, 1000.0 if density is None else density)
    low, high = context.x_range
    if bin_width is not None and not (high - low) / MOST_BINS <= bin_width <= high - low:
        raise CaseError(
            f"--bin-width {bin_width}: allowed is {(high - low) / MOST_BINS:.2g} to {high - low:.4g} m, the length of "
            f"the channel in {path}"
        )
    folder = out or path.parent / f"{path.name.split('.')[0]}_analysis"
    request = passes.AnalysisRequest(bin_width=bin_width, jump=True, front=True)
    parts = analyze.analyze_dump(path, context, request, folder)
    write_summary(folder, {"name": path.name, **parts})
    return folder, parts["warnings"]


def _context(path: Path, case: ReadCase | None, diameter: float | None = None, density: float = 1000.0) -> FlowContext:
    """The flow of a dump: that of its case, else what can be guessed."""
    if case is None:
        return guess.from_dump(open_dump(path), diameter=diameter, density=density)
    return from_scene(case.scene())


def _case_beside(path: Path) -> ReadCase | None:
    """The case of the run folder that holds a dump, None for a bare dump."""
    return load_case(path.parent) if (path.parent / "case.yaml").exists() else None


def animate(target: Path, out: Path | None, fps: int) -> Path:
    """Write the moving picture of a run folder or dump; its path, by default ``animation.mp4`` beside the dump."""
    path = find_dump(target)
    case, table = _case_beside(path), path.parent / "forces.csv"
    forces = read_forces(table) if case is not None and table.exists() else None
    destination = out or path.parent / "animation.mp4"
    film.animate(open_dump(path), _context(path, case), destination, fps=fps, forces=forces)
    return destination


def export(target: Path, kinds: Sequence[str], out: Path | None = None) -> list[Path]:
    """Write files for other programs; their paths.

    Parameters
    ----------
    target : Path
        Run folder or dump.
    kinds : sequence of {'vtk', 'csv', 'pictures'}
    out : Path, optional
        Folder of the files; default that of the dump.

    Raises
    ------
    DumpError
    """
    path = find_dump(target)
    case, folder = _case_beside(path), out or path.parent
    asked = _request(case) if case is not None else passes.AnalysisRequest()
    request = passes.AnalysisRequest(
        bin_width=asked.bin_width, window=asked.window, fields=asked.fields, figures=False, exports=tuple(kinds)
    )
    warnings: list[str] = []
    files: list[str] = []
    gathered = passes.gather(open_dump(path), _context(path, case), request, warnings)
    folder.mkdir(parents=True, exist_ok=True)
    extras.write_extras(gathered, request, path, folder, files, warnings)
    return [folder / name for name in files]


def series_of(found: Found, part: str, structure: str = "") -> dict[str, np.ndarray]:
    """Series over time of an analysis: 'jump', 'front', 'energy', or 'force' of a structure."""
    if part == "jump":
        result = found.shown["jump"]
        return {"track": result.track, "balance": result.balance}
    history = found.gathered.forces[structure] if part == "force" else getattr(found.gathered, part)
    names = [*vars(history), *(["total"] if part == "energy" else [])]
    return {name: getattr(history, name) for name in names}


def draw(found: Found, folder: Path, name: str) -> Figure:
    """One of the figures of a report, by the name of its file without the ending.

    Raises
    ------
    DumpError
        A name that is not known, or a figure for which the run has no data.
    """
    figures = result_figures.wanted(found.gathered, found.shown, find_dump(folder))
    known = {file.removesuffix(".png"): make for file, make in figures.items()}
    if name not in known:
        raise DumpError(f"figure '{name}' is not known; allowed is one of {', '.join(known)}")
    figure = known[name]()
    if figure is None:
        raise DumpError(f"figure '{name}': the run in {folder} holds no data for it; use another of {', '.join(known)}")
    return figure


def write_report(folder: Path, summary: Mapping[str, Any], case: ReadCase, path: str | Path | None = None) -> Path:
    """Write the report of a run folder, by default as its ``report.html``."""
    name = "report.html" if path is None else str(Path(path).absolute())
    return page.write_report(folder, dict(summary), case.to_yaml(), name=name)


def table(rows: Iterable[tuple[str, float | str, float]]) -> str:
    """HTML table of (name, value, standard error)."""
    cells = ((html.escape(name), html.escape(_text(value, error))) for name, value, error in rows)
    return "<table>" + "".join(f"<tr><td>{name}</td><td>{text}</td></tr>" for name, text in cells) + "</table>"


def _text(value: float | str, error: float) -> str:
    if not isinstance(value, float):
        return str(value)
    return f"{value:.4g}" + (f" ± {error:.2g}" if error == error else "")


def read_profiles(folder: Path) -> xr.Dataset | None:
    """The stored profiles of a run folder, None where there are none."""
    path = folder / "profiles.nc"
    return profiles.read_profiles(path) if path.exists() else None


def level_range(scene: Scene) -> tuple[float, float]:
    """The part of the channel with one and the same floor, m."""
    return studied_reach(from_scene(scene))
