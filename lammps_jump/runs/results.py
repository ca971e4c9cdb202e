# SPDX-License-Identifier: GPL-2.0-or-later
"""The analyses of a run: files into its folder, or results held in memory."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from lammps_jump.analysis import quantities
from lammps_jump.analysis.draw import film
from lammps_jump.analysis.flow import Flow, from_scene
from lammps_jump.analysis.guess import from_dump
from lammps_jump.analysis.passes import Collector, Gathered
from lammps_jump.analysis.report import run as report
from lammps_jump.case.case import ReadCase, load_case
from lammps_jump.case.checks import MOST_BINS
from lammps_jump.dump.find import find_dump, read_forces
from lammps_jump.dump.read import open_dump
from lammps_jump.errors import CaseError, DumpError, SetupError
from lammps_jump.files import RESULT_FILES
from lammps_jump.folders import (
    MARKER_FILE,
    Marker,
    claim,
    clear,
    locked,
    publish,
    read_marker,
    require_ours,
    require_replaceable,
    staging,
)

from .folder import require_case
from .summary import write_summary

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Found:
    """What the analyses found, in memory.

    Attributes
    ----------
    gathered : Gathered
    results : mapping of str to object
        By the name of the quantity.
    warnings : tuple of str
    """

    gathered: Gathered
    results: Mapping[str, object]
    warnings: tuple[str, ...]

    @property
    def parts(self) -> dict[str, Any]:
        """The results as they stand in ``summary.json``."""
        return {name: quantities.QUANTITIES[name].summary(result) for name, result in self.results.items()}


def flow_of(case: ReadCase) -> Flow:
    """The flow of a case, with the bins and the window that it asks for."""
    asked, inflow = case.fields.analysis, case.fields.inflow
    rows = inflow if inflow is not None and inflow.kind == "rows" else None
    return from_scene(
        case.scene(),
        bin_width=asked.bin_width,
        window=asked.window,
        inflow_depth=rows.depth if rows else None,
        inflow_speed=rows.velocity if rows else None,
    )


def analyse(case: ReadCase, folder: Path, out: Path, watch: Sequence[Collector] = ()) -> dict[str, Any]:
    """Analyse the dump of a run folder as its case asks; the parts of the summary. Tables and figures go to `out`.

    `watch` is also shown every frame.
    """
    asked = case.fields.analysis
    wanted = [name for name in (*quantities.QUANTITIES, "fields") if getattr(asked, name, False)]
    quiet = not log.isEnabledFor(logging.INFO)
    options = {"film": asked.animation, "quiet": quiet, "watch": watch}
    return quantities.analyse(flow_of(case), find_dump(folder), out, wanted, **options)


def analyse_in_memory(case: ReadCase, folder: Path) -> Found:
    """Every analysis of a run folder, whether the case asks for it or not; nothing is written."""
    flow = flow_of(case)
    warnings = list(flow.notes)
    gathered = quantities.collect(flow, find_dump(folder), folder, quantities.QUANTITIES, warnings)
    results = {name: quantity.analyse(gathered) for name, quantity in quantities.QUANTITIES.items()}
    known = {name: result for name, result in results.items() if result is not None}
    return Found(gathered, known, tuple(dict.fromkeys(warnings)))


def analyse_dump(
    target: Path,
    case: ReadCase | None,
    diameter: float | None,
    density: float | None,
    bin_width: float | None,
    out: Path | None,
) -> None:
    """Analyse a dump that is no run's.

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
    out : Path, optional
        Folder of the results; default beside the dump.

    Raises
    ------
    CaseError, DumpError
    """
    path = find_dump(target)
    flow = _flow(path, case, diameter, density)
    low, high = flow.x_range
    if bin_width is not None and not (high - low) / MOST_BINS <= bin_width <= high - low:
        raise CaseError(
            f"--bin-width {bin_width}: allowed is {(high - low) / MOST_BINS:.2g} to {high - low:.4g} m, the length of "
            f"the channel in {path}"
        )
    folder = out or path.parent / f"{path.name.split('.')[0]}_analysis"
    flow = replace(flow, bin_width=bin_width or flow.bin_width)
    parts: dict[str, Any] = {}
    with _results_folder(folder, path) as stage:
        if (folder / "forces.csv").is_file():
            (stage / "forces.csv").symlink_to((folder / "forces.csv").absolute())
        parts = quantities.analyse(flow, path, stage, ("jump", "front"))
        write_summary(stage, {"name": path.name, **parts})
        clear(folder, RESULT_FILES)
        publish(stage, folder)
    for note in parts["warnings"]:  # what was guessed is among them
        log.info(f"note: {note}")
    log.info(f"results are in {folder}")


@contextmanager
def _results_folder(folder: Path, dump: Path) -> Iterator[Path]:
    """A `staging` folder in the folder of the results of a dump, made and held; without results nothing is left."""
    marker = Marker("analysis", RESULT_FILES, {"dump": str(dump.absolute())})
    new, fresh = not folder.exists(), False
    try:
        require_ours(folder, marker)
        folder.mkdir(parents=True, exist_ok=True)
        with locked(folder):
            fresh = claim(folder, marker)
            found = read_marker(folder)
            if found is not None and (of := found.about.get("dump")) != marker.about["dump"]:
                raise SetupError(f"{folder}: holds the analysis of {of}; name another folder with --out")
            with staging(folder) as stage:
                yield stage
    except BaseException as error:
        if fresh:
            (folder / MARKER_FILE).unlink(missing_ok=True)
        if new and folder.is_dir():
            folder.rmdir()
        if isinstance(error, OSError):
            raise DumpError(f"{folder}: cannot be written ({error.strerror or error}); name another folder") from None
        raise


def _flow(path: Path, case: ReadCase | None, diameter: float | None = None, density: float | None = None) -> Flow:
    """The flow of a dump: that of its case, else what can be guessed."""
    if case is None:
        return from_dump(open_dump(path), diameter=diameter, density=density or 1000.0)
    return from_scene(case.scene())


def animate(target: Path, out: Path | None, fps: int) -> Path:
    """Write the moving picture of a run folder or dump; its path, by default ``animation.mp4`` beside the dump.

    Without ffmpeg it is a GIF, and a note says so. Only a film that this program made in a run folder is replaced.
    """
    path = find_dump(target)
    case = load_case(require_case(path.parent)) if (path.parent / "case.yaml").exists() else None
    table = path.parent / "forces.csv"
    forces = read_forces(table) if case is not None and table.exists() else None
    destination = out or path.parent / "animation.mp4"
    written = destination if film.has_ffmpeg() else destination.with_suffix(".gif")
    require_replaceable(written)
    with locked(path.parent) if out is None and read_marker(path.parent) else nullcontext():
        film.animate(open_dump(path), _flow(path, case), written, fps=fps, forces=forces)
    if written != destination:
        log.info(f"note: {film.NO_FFMPEG}")
    return written


def draw(found: Found, folder: Path, name: str) -> Figure:
    """One of the figures of a report, by the name of its file without the ending.

    Raises
    ------
    DumpError
        A name that is not known, or a figure for which the run has no data.
    """
    drawings = quantities.drawings(found.gathered, found.results, find_dump(folder))
    known = {file.removesuffix(".png"): make for file, make in drawings.items()}
    if name not in known:
        raise DumpError(f"figure '{name}' is not known; allowed is one of {', '.join(known)}")
    figure = known[name]()
    if figure is None:
        raise DumpError(f"figure '{name}': the run in {folder} holds no data for it; use another of {', '.join(known)}")
    return figure


def write_report(folder: Path, summary: Mapping[str, Any], case: ReadCase, path: str | Path | None = None) -> Path:
    """Write the report of a run folder, by default as its ``report.html``."""
    name = "report.html" if path is None else str(Path(path).absolute())
    return report.write_report(folder, dict(summary), case.to_yaml(), name=name)
