# SPDX-License-Identifier: GPL-2.0-or-later
"""The analyses of a run: files into its folder, or results held in memory."""

from __future__ import annotations

import logging
from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, fields, replace
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lammps_jump import folders
from lammps_jump.analysis import Flow, from_dump, from_scene, pipeline, quantities
from lammps_jump.analysis import draw as drawing
from lammps_jump.analysis.budgets import depths
from lammps_jump.analysis.passes import Gathered, Watcher, feed, with_velocities
from lammps_jump.analysis.report import page, run
from lammps_jump.analysis.report import run as report
from lammps_jump.analysis.report.frames import FramePacker
from lammps_jump.analysis.report.player import make_player, member_packer, pack_player
from lammps_jump.case.case import ReadCase
from lammps_jump.case.fields import Layers
from lammps_jump.core.library import core
from lammps_jump.dump import Dump, ForceHistory, find_dump, open_dump, read_dump, read_forces
from lammps_jump.dump import export as write_exports
from lammps_jump.dump.check import IdCheck
from lammps_jump.dump.exports import load_netcdf
from lammps_jump.errors import CaseError, DumpError
from lammps_jump.files import PLAYER, PRESSURE_FILE, SUMMARY_FILE, checksum, read_json, write_json, write_text, writes
from lammps_jump.provenance import versions
from lammps_jump.quoting import visible
from lammps_jump.scene.schedule import MOST_BINS

from .folder import require_case
from .summary import results_of, write_summary

if TYPE_CHECKING:
    from matplotlib.figure import Figure

log = logging.getLogger(__name__)

OF_A_DUMP = tuple(name for name, one in quantities.LISTED.items() if one.bare)
"""Quantities that the analysis of a bare dump looks for where no option names anything."""


@dataclass(frozen=True)
class AnalysisInputs:
    """Inputs that may be given with a bare dump; None, or nothing, where they are not.

    Attributes
    ----------
    diameter : float or mapping of int to float, optional
        m; of each type where it is a mapping.
    density : float, optional
        Of the material, kg/m^3; default 1000, or that of the masses in the dump.
    time_step : float, optional
        s; for a dump without times.
    bin_width : float, optional
        m.
    bodies : str, optional
        spheres, cylinders or discs.
    gravity : float, optional
        m/s^2; default 9.81.
    analyses : tuple of str
        Names of quantities to look for, by default `OF_A_DUMP`.
    stations : tuple of float
        Places between which to tell the head lost, m.
    """

    diameter: float | Mapping[int, float] | None = None
    density: float | None = None
    time_step: float | None = None
    bin_width: float | None = None
    bodies: str | None = None
    analyses: tuple[str, ...] = ()
    stations: tuple[float, ...] = ()
    gravity: float | None = None

    @property
    def wanted(self) -> tuple[str, ...]:
        """Quantities to look for; the depths always."""
        heads = ("grade",) if self.stations or not self.analyses else ()
        return ("depth", *heads, *(self.analyses or OF_A_DUMP))

    @property
    def known(self) -> dict[str, Any]:
        """The inputs that are given, as they are in ``summary.json``."""
        return {name: value for name, value in vars(self).items() if value not in (None, ())}

    @classmethod
    def of(cls, summary: Mapping[str, Any]) -> AnalysisInputs:
        """That of a summary."""
        names = {field.name for field in fields(cls)}
        given = {key: value for key, value in (summary.get("given") or {}).items() if key in names}
        if isinstance(sizes := given.get("diameter"), Mapping):
            given["diameter"] = {int(kind): value for kind, value in sizes.items()}
        return cls(**given | {name: tuple(given.get(name, ())) for name in ("analyses", "stations")})


NO_INPUTS = AnalysisInputs()


@dataclass(frozen=True)
class ResultsInMemory:
    """Results of the analyses, in memory.

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
        """The results as they are in ``summary.json``."""
        return {name: quantities.QUANTITIES[name].summary(result) for name, result in self.results.items()}


def flow_of(case: ReadCase, folder: Path | None = None) -> Flow:
    """The flow of a case, with the bins and the window that it asks for; `folder` is that of its run.

    The contacts of a frame are computed once for all who have the same flow.
    """
    analysis, inflow = case.fields.analysis, case.fields.inflow
    steady = inflow if inflow is not None and inflow.kind == "rows" and inflow.table is None else None
    depth, speed = steady.over(0.0, 0.0) if steady else (None, None)  # one against time is in the scene
    flow = from_scene(
        case.scene(),
        bin_width=analysis.bin_width,
        window=analysis.window,
        inflow_depth=depth,
        inflow_speed=speed,
        water=analysis.front == "water",
        folder=folder,
    )
    flow = replace(flow, heads_at=analysis.stations)
    return (
        replace(flow, layers=(analysis.layers.x, analysis.layers.height))
        if isinstance(analysis.layers, Layers)
        else flow
    )


def load(case: ReadCase) -> None:
    """Load what loads on first use: the core; xarray, 0.4 s; matplotlib, 0.4 s; the page."""
    load_netcdf()
    if has_page(case):
        import_module("lammps_jump.analysis.draw.film")
        page.render("", ())
    core()


def _wanted(case: ReadCase) -> list[str]:
    analysis = case.fields.analysis
    heads = ["grade"] * bool(analysis.stations or analysis.jump or case.fields.inflow)
    return [*heads, *(name for name in (*quantities.QUANTITIES, "fields") if getattr(analysis, name, False))]


def collect(case: ReadCase, flow: Flow, folder: Path, dump: Dump, *watch: Watcher) -> Gathered:
    """Data that one pass over the dump of a run folder gives to the analyses that its case asks for."""
    return pipeline.collect(flow, dump, [folder], _wanted(case), watch)


def analyse(
    case: ReadCase,
    flow: Flow,
    folder: Path,
    out: Path,
    packer: FramePacker,
    watch: Sequence[Watcher] = (),
    gathered: Gathered | None = None,
    report: Callable[[str], None] | None = None,
) -> tuple[dict[str, Any], page.Player | None]:
    """Analyse the dump of a run folder as its case asks; the parts of the summary, and the player of what `packer` got.

    Tables and figures go to `out`. `watch` is also shown every frame. Where they were read before, `gathered` is of
    `collect`. `report` is called with what is done. While the pictures are drawn, the frames are packed.
    """
    analysis = case.fields.analysis
    figures = analysis.figures if has_page(case) else "none"
    report, dump = report or (lambda phase: None), find_dump(folder)
    if gathered is None:
        watch = [*([packer] if has_player(case) else []), *watch]
        gathered = collect(case, flow, folder, open_dump(dump), *watch)
    with pipeline.DrawnAside() as drawing:
        parts = pipeline.analyse(
            flow,
            dump,
            out,
            _wanted(case),
            pictures=pipeline.Pictures(figures, analysis.animation, quiet=not log.isEnabledFor(logging.INFO)),
            gathered=gathered,
            report=report,
            drawing=drawing,
        )
        report("player")
        player = packed_player(packer, out, gathered.forces) if has_player(case) else None
        report("figures")
    return parts, drawing.shown_in(player)


def analyse_in_memory(case: ReadCase, folder: Path) -> ResultsInMemory:
    """Every analysis of a run folder, whether the case asks for it or not; nothing is written."""
    gathered = pipeline.collect(flow_of(case, folder), read_dump(folder), [folder], quantities.QUANTITIES)
    results = {name: quantity.analyse(gathered) for name, quantity in quantities.QUANTITIES.items()}
    known = {name: result for name, result in results.items() if result is not None}
    return ResultsInMemory(gathered, known, tuple(dict.fromkeys(gathered.warnings)))


def looked_at(case: ReadCase, folder: Path, name: str, fit_stretch: float = 1.0) -> dict[str, Any]:
    """One part of the summary of a run, analysed as a case asks; `fit_stretch` as of `Flow`. Nothing is written."""
    gathered = collect(case, replace(flow_of(case, folder), fit_stretch=fit_stretch), folder, read_dump(folder))
    quantity = quantities.QUANTITIES[name]
    result = quantity.analyse(gathered)
    return {} if result is None else {name: quantity.summary(result)}


def analyse_dump(
    target: Path, case: ReadCase | None, given: AnalysisInputs = NO_INPUTS, out: Path | None = None
) -> tuple[dict[str, Any], Path]:
    """Analyse a dump that is no run's; its summary, and the folder that holds the results.

    Parameters
    ----------
    target : Path
        The dump, a folder that holds one, or the pattern of its files.
    case : ReadCase, optional
        The case that belongs to it.
    given : AnalysisInputs
    out : Path, optional
        Folder of the results; default next to the dump.

    Raises
    ------
    CaseError, DumpError
    """
    path = find_dump(target)
    flow = _flow(path, case, given)
    (low, high), width = flow.x_range, given.bin_width
    if width is not None and not (high - low) / MOST_BINS <= width <= high - low:
        raise CaseError(
            f"--bin-width {width}: allowed is {(high - low) / MOST_BINS:z.2g} to {high - low:z.4g} m, the length of "
            f"the channel in {path}"
        )
    stem = path.name.split(".")[0].replace("*", "").strip("_-")
    folder = out or path.parent / f"{stem or 'dump'}_analysis"
    summary: dict[str, Any] = {"name": visible(path.name), "given": given.known, "versions": versions()}
    summary |= {"case_yaml": case.to_yaml()} if case else {}
    marker = folders.Marker("analysis", quantities.result_files(), {"dump": str(path.absolute())})
    with folders.results_folder(folder, marker, "dump") as stage:
        if (folder / "forces.csv").is_file():
            (stage / "forces.csv").symlink_to((folder / "forces.csv").absolute())
        packer = FramePacker(flow)
        places = (stage, path.parent)
        gathered = pipeline.collect(flow, open_dump(path), places, given.wanted, [IdCheck(path), packer])
        if note := depths.require_agreement(gathered):
            gathered = replace(gathered, warnings=(*gathered.warnings, note))
        with pipeline.DrawnAside() as drawing:
            summary |= pipeline.analyse(flow, path, stage, given.wanted, gathered=gathered, drawing=drawing)
            player = pack_player(packer, stage, gathered.forces)
        text = case.to_yaml() if case else ""
        report.write_report(stage, summary, text, player=drawing.shown_in(player))
        files = {str(one.relative_to(stage)): one for one in stage.rglob("*") if one.is_file() and not one.is_symlink()}
        analysed = {"key": "", "files": {name: checksum(one) for name, one in files.items()}}
        write_summary(stage, {**summary, "analysed": analysed})
        folders.clear(folder, quantities.result_files())
        folders.publish(stage, folder)
    return summary, folder


def _flow(path: Path, case: ReadCase | None, given: AnalysisInputs = NO_INPUTS) -> Flow:
    """The flow of a dump: that of its case, else what can be guessed."""
    if case is not None:
        water = case.fields.analysis.front == "water"
        flow = from_scene(case.scene(), bin_width=given.bin_width, water=water, folder=path.parent)
        return replace(flow, heads_at=given.stations or case.fields.analysis.stations)
    flow = from_dump(
        open_dump(path),
        diameter=given.diameter,
        density=given.density,
        bin_width=given.bin_width,
        time_step=given.time_step,
        kind=given.bodies,
        gravity=given.gravity,
    )
    return replace(flow, heads_at=given.stations)


def is_of_a_dump(folder: Path) -> bool:
    """Tells whether a folder holds the results of a bare dump."""
    marker = folders.read_marker(folder)
    return marker is not None and marker.kind == "analysis"


def summary_of_dump(folder: Path) -> dict[str, Any]:
    """The summary of a folder of results of a bare dump.

    Raises
    ------
    DumpError
        No file that can be read.
    """
    try:
        return dict(read_json(folder / SUMMARY_FILE))
    except (OSError, ValueError, TypeError):
        raise DumpError(f"{folder / SUMMARY_FILE}: cannot be read; analyse the dump again") from None


def flow_of_dump(folder: Path) -> Flow:
    """The flow of a folder of results of a bare dump, as it was analysed.

    Raises
    ------
    DumpError
        The dump is gone.
    """
    summary = summary_of_dump(folder)
    case = ReadCase.parse(summary["case_yaml"]) if "case_yaml" in summary else None
    return _flow(find_dump(folder), case, AnalysisInputs.of(summary))


def draw_dump(folder: Path, ending: str = "png") -> list[Path]:
    """Draw every figure of a folder of results of a bare dump into its ``figures``; the paths."""
    with folders.locked(folder):
        names = AnalysisInputs.of(summary_of_dump(folder)).wanted
        wanted = {name: one for name, one in quantities.QUANTITIES.items() if name in names}
        gathered = pipeline.collect(flow_of_dump(folder), read_dump(folder), [folder], names)
        results = {name: result for name, one in wanted.items() if (result := one.analyse(gathered)) is not None}
        return draw_all(ResultsInMemory(gathered, results, ()), folder, ending)


def animate(target: Path, out: Path | None, fps: int, *, arrows: bool = True) -> Path:
    """Write the moving picture of a run folder or dump; its path. Without `arrows` it shows no forces.

    By default it is ``animation.mp4`` next to the dump, or in the folder of a dump's results. Without ffmpeg it is a
    GIF, and a note says so. Only a film that this program made in such a folder is replaced.
    """
    path, analysed = find_dump(target), is_of_a_dump(target)
    home = target if analysed else path.parent
    case = ReadCase.load(require_case(home)) if (home / "case.yaml").exists() else None
    table = home / "forces.csv"
    results_of(home).require_same(table.name)
    forces = read_forces(table) if arrows and case is not None and table.exists() else {}
    destination = out or home / "animation.mp4"
    written = destination if drawing.film.has_ffmpeg() else destination.with_suffix(".gif")
    folders.require_replaceable(written.parent, written.name)
    flow = flow_of_dump(target) if analysed else _flow(path, case)
    with folders.locked(home) if out is None and folders.read_marker(home) else nullcontext():
        pressure = home / PRESSURE_FILE if flow.scene.pressure else None
        felt = drawing.arrows.ForceArrows.recorded(flow, forces, pressure)
        drawing.film.animate(open_dump(path), flow, written, fps=fps, arrows=felt)
    if written != destination:
        log.info(f"note: {drawing.film.NO_FFMPEG}")
    return written


def export(place: Path, kinds: Collection[str], out: Path | None = None) -> list[Path]:
    """Write what lies in a folder of a run, or of a dump's results, for other programs; see `dump.export`."""
    results_of(place).require_same("profiles.nc", "fields.nc")
    if "vtk" not in kinds or not (place / "profiles.nc").is_file():
        return write_exports(place, kinds, out)
    if is_of_a_dump(place):
        flow = flow_of_dump(place)
    elif (place / "case.yaml").is_file():
        flow = flow_of(ReadCase.load(require_case(place)), place)
    else:
        return write_exports(place, kinds, out)
    x, y = ((low - 0.05 * (high - low), high + 0.05 * (high - low)) for low, high in flow.scene.domain)
    return write_exports(place, kinds, out, walls_at=flow.walls_at, room=(x, y))


def draw(results: ResultsInMemory, folder: Path, name: str) -> Figure:
    """One of the figures of a report, by the name of its file without the ending.

    Raises
    ------
    DumpError
        A name that is not known, or a figure for which the run has no data.
    """
    shown = pipeline.drawings(results.gathered, results.results)
    if name not in (known := quantities.captions()):
        raise DumpError(f"figure '{name}' is not known; allowed is one of {', '.join(known)}")
    there = [*shown, pipeline.DISCS]
    if name not in there:
        raise DumpError(f"figure '{name}': the run in {folder} holds no data for it; use another of {', '.join(there)}")
    return pipeline.figure(name, shown, find_dump(folder), results.gathered.flow, pipeline.felt(results.gathered))


def figure_named(results: ResultsInMemory, name: str = "") -> str:
    """Name of the first figure of the page whose name is `name`, begins so or holds it; without a name, of the first.

    Raises
    ------
    DumpError
        None; the message lists those that are there.
    """
    shown = {*pipeline.drawings(results.gathered, results.results), pipeline.DISCS}
    there = [one for one in quantities.captions() if one in shown]
    if not name or name in there:
        return name or there[0]
    fitting = [one for one in there if one.startswith(name)] or [one for one in there if name in one]
    if not fitting:
        raise DumpError(f"figure '{name}': the run has none of that name; use one of {', '.join(there)}")
    return fitting[0]


def draw_all(results: ResultsInMemory, folder: Path, ending: str = "png", *, arrows: bool = True) -> list[Path]:
    """Draw every figure of a run folder into its ``figures``, in a format of `files.PICTURES`; the paths.

    Without `arrows` the discs have no forces on the outlines of structures.
    """
    drawn = pipeline.felt(results.gathered) if arrows else None
    shown = pipeline.drawings(results.gathered, results.results)
    names = [*shown, pipeline.DISCS]
    for name in names:
        folders.require_replaceable(folder, f"figures/{name}.{ending}")
    with folders.staging(folder) as stage:
        place, dump = stage / "figures", find_dump(folder)
        pipeline.draw_figures(names, shown, place, dump, results.gathered.flow, ending, arrows=drawn)
        folders.publish(stage, folder)
    return [folder / "figures" / f"{name}.{ending}" for name in names]


def has_page(case: ReadCase) -> bool:
    """Tells whether a case asks for pictures and a report."""
    return case.fields.analysis.figures in ("default", "all")


def has_player(case: ReadCase) -> bool:
    """Tells whether a case asks for its frames, for the player of its report or of the page of its study."""
    return case.fields.analysis.figures != "none"


def packer_for(case: ReadCase, flow: Flow) -> FramePacker:
    """Packer of the frames of a run for the player of its report, or of the page of its study."""
    scene = case.scene()
    return FramePacker(flow) if has_page(case) else member_packer(flow, scene.steps // scene.output_steps + 1)


def packed_player(
    packer: FramePacker, folder: Path, forces: Mapping[str, ForceHistory] | None = None
) -> page.Player | None:
    """The player of what a packer has taken in, without a picture; None where no frame holds a disc."""
    return pack_player(packer, folder, forces)


def packed(flow: Flow, folder: Path, every: int = 1) -> FramePacker:
    """Every n-th frame of a folder for the player of its report; none where the dump cannot be read."""
    packer = FramePacker(flow, every)
    try:
        dump = read_dump(folder)
        for _ in feed(with_velocities(dump, packer.flow, []), packer.flow, [packer]):
            pass
    except DumpError as error:
        log.info(f"note: the report has no player: {error}")
        return FramePacker(flow)
    return packer


def player_of(case: ReadCase, folder: Path) -> page.Player | None:
    """The player of the frames of a run folder; None where no frame holds a disc, or the dump cannot be read."""
    return make_player(packed(flow_of(case, folder), folder), folder)


def write_comparison(runs: Sequence[tuple[str, Path, Mapping[str, Any], Flow]], path: Path) -> Path:
    """Write the page of two runs or dumps, each given by name, folder, summary and flow.

    Raises
    ------
    DumpError
        The file cannot be written.
    """
    sides = [
        run.Side(name, summary, report.curves(folder), make_player(packed(flow, folder), folder))
        for name, folder, summary, flow in runs
    ]
    with writes(path):
        return write_text(path, run.comparison(*sides))


def write_player(folder: Path, player: page.Player) -> None:
    """Write the player of a member for the page of its study."""
    write_json(folder / PLAYER, player._asdict(), indent=None)


def write_report(
    folder: Path,
    summary: Mapping[str, Any],
    case: ReadCase,
    player: page.Player | None,
    path: str | Path | None = None,
    run_folder: Path | None = None,
    live: page.LivePage | None = None,
) -> Path:
    """Write the report of a run folder, by default as its ``report.html``; the rest as of `report.write_report`."""
    name = "report.html" if path is None else str(Path(path).absolute())
    text, summary = case.to_yaml(), dict(summary)
    return report.write_report(folder, summary, text, name=name, player=player, run_folder=run_folder, live=live)
