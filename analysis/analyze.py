"""From a dump to numbers, tables and figures: one pass over the frames feeds every analysis that was asked for."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lammps_jump.dump.find import find_dump
from lammps_jump.dump.read import Dump, Frame, make_frame, open_dump, require_finite
from lammps_jump.engines.result import RunResult
from lammps_jump.errors import DumpError
from lammps_jump.runs.summary import plain
from lammps_jump.scene.scene import Scene

from .flow import FlowContext, from_scene

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True)
class AnalysisRequest:
    """What is asked of a dump.

    Attributes
    ----------
    bin_width : float, optional
        Width of the profile bins, m; default five diameters.
    window : (float, float), optional
        Times of the means, s; default the last quarter of the run.
    jump, energy, front, forces, fields : bool
        Which analyses run; profiles are always made.
    animate : bool
        Write ``animation.mp4``.
    figures : bool
        Write ``figures/*.png``.
    exports : tuple of str
        Of 'csv' (profiles as tables), 'vtk' (discs, and fields where asked for), 'pictures' (the thesis' picture0.dat
        … picture9.dat).
    inflow_depth, inflow_speed : float, optional
        y1, m, and Va, m/s, where the scene does not tell.
    """

    bin_width: float | None = None
    window: tuple[float, float] | None = None
    jump: bool = False
    energy: bool = False
    front: bool = False
    forces: bool = False
    fields: bool = False
    animate: bool = False
    figures: bool = True
    exports: tuple[str, ...] = ()
    inflow_depth: float | None = None
    inflow_speed: float | None = None


@dataclass
class Gathered:
    """What one pass over a dump has left: input of the analyses and their figures.

    Attributes
    ----------
    context : FlowContext
    profiles : xarray.Dataset
    contacts : ContactSeries or None
        Thrust and bed forces by frame and bin.
    energy : EnergyHistory or None
    front : FrontHistory or None
    momentum : MomentumHistory or None
    forces : dict of str to ForceHistory
    """

    context: FlowContext
    profiles: xr.Dataset
    contacts: Any = None
    energy: Any = None
    front: Any = None
    momentum: Any = None
    forces: Any = None


def analyze_run(
    folder: Path, scene: Scene, wanted: AnalysisRequest, *, result: RunResult | None = None, quiet: bool = False
) -> dict:
    """Analyse the dump (and ``forces.csv``) of a run folder; tables and figures are written into it.

    Parameters
    ----------
    folder : Path
    scene : Scene
    wanted : AnalysisRequest
    result : RunResult, optional
        For the engine's name.
    quiet : bool
        Say nothing while rendering the animation.

    Returns
    -------
    dict
        See `analyze_dump`.
    """
    context = from_scene(
        scene,
        bin_width=wanted.bin_width,
        window=wanted.window,
        inflow_depth=wanted.inflow_depth,
        inflow_speed=wanted.inflow_speed,
        engine=None if result is None else result.engine,
    )
    return analyze_dump(find_dump(folder), context, wanted, Path(folder), quiet=quiet)


def analyze_dump(path: Path, context: FlowContext, request: AnalysisRequest, out: Path, *, quiet: bool = False) -> dict:
    """Analyse a dump file.

    Parameters
    ----------
    path : Path
    context : FlowContext
        Of `context.from_scene` or `context_of_dump.from_dump`.
    request : AnalysisRequest
    out : Path
        Folder that gets ``profiles.nc``, ``*.csv``, ``figures/*.png`` and, when asked for, ``animation.mp4``.
        ``forces.csv`` is looked for here and beside the dump.

    Returns
    -------
    dict
        ``profiles`` (what is in profiles.nc), ``jump``, ``front``, ``energy``, ``force`` (absent where not asked
        for), ``files`` (names written) and ``warnings`` (sentences). Plain numbers, text and None; never NaN.

    Raises
    ------
    DumpError
        No frame, a malformed dump, a place that cannot be written.
    """
    out = Path(out)
    warnings: list[str] = []
    gathered = gather(open_dump(path), context, request, warnings, places=(out, Path(path).parent))
    out.mkdir(parents=True, exist_ok=True)  # only now: a dump that cannot be read leaves nothing behind
    parts, shown = summarise(gathered, request, warnings)
    from .profiles import write_profiles

    files = [write_profiles(gathered.profiles, out / "profiles.nc").name]
    files += _write_tables(gathered, shown, out)
    if request.figures:
        from .result_figures import draw_all

        files += draw_all(gathered, shown, out / "figures", path)
    if request.fields or request.animate or request.exports:
        from .extras import write_extras

        parts["fields"] = write_extras(gathered, request, Path(path), out, files, warnings, quiet=quiet)
    dataset = gathered.profiles
    parts["profiles"] = {
        "file": "profiles.nc",
        "frames": dataset.sizes["time"],
        "bins": dataset.sizes["x"],
        "bin_width": dataset.attrs["bin_width"],
        "first_time": float(dataset["time"][0]),
        "last_time": float(dataset["time"][-1]),
        "window": [dataset.attrs["window_begin"], dataset.attrs["window_end"]],
        "window_frames": dataset.attrs["window_frames"],
    }
    parts["files"] = files
    parts["warnings"] = list(dict.fromkeys(warnings))
    return plain(parts)


def gather(
    dump: Dump, context: FlowContext, request: AnalysisRequest, warnings: list[str], places: tuple[Path, ...] = ()
) -> Gathered:
    """One pass over a dump: profiles and, as asked for, contacts, energy, front and momentum.

    Memory holds one frame and what is kept of it (sums over bins), so dumps of any size can be read.
    """
    from .profiles import add_means, bin_edges, compute_profiles

    warnings += context.notes
    takers, collectors = [], {}
    edges = bin_edges(context.x_range, request.bin_width or context.bin_width)
    if context.stiffness is not None and (request.jump or request.energy):
        from .contact_series import ContactCollector

        collectors["contacts"] = ContactCollector(context, edges if request.jump else None)
        takers.append(collectors["contacts"])
    if request.energy:
        from .energy import EnergyLedger

        collectors["energy"] = EnergyLedger(context, collectors.get("contacts"))
        takers.append(collectors["energy"])
    if request.front:
        from .front import FrontTracker

        collectors["front"] = FrontTracker(context)
        takers.append(collectors["front"])
    forces = _find_forces(places, warnings) if request.forces or context.probes else {}
    if forces:
        from lammps_jump.analysis.forces.impulse import MomentumLedger

        collectors["momentum"] = MomentumLedger(context)
        takers.append(collectors["momentum"])
    frames = with_velocities(dump, context, warnings)
    free = replace(context, window=None)
    profiles = compute_profiles(_feed(frames, context, takers), free, bin_width=request.bin_width)
    warnings += dump.warnings
    window = request.window or context.window
    if window is not None:
        try:
            profiles = add_means(profiles, window)
        except DumpError as error:
            warnings.append(f"Means are over the second half of the frames instead: {error}")
    return Gathered(context, profiles, forces=forces, **{k: v.result() for k, v in collectors.items()})


def _feed(frames: Iterator[Frame], context: FlowContext, takers: list) -> Iterator[Frame]:
    """The same frames, shown to every taker on the way."""
    for frame in frames:
        require_finite(frame, context.name)
        time = context.time(frame)
        for taker in takers:
            taker.add(frame, time)
        yield frame


def with_velocities(dump: Dump, context: FlowContext, warnings: list[str]) -> Iterator[Frame]:
    """The frames; where the file has no vx, vy they are differences of the positions since the frame before.

    A disc that was not there before gets velocity 0, as do all discs of the first frame.
    """
    if {"vx", "vy"} <= set(dump.columns):
        yield from dump
        return
    warnings.append(
        "The dump has no vx, vy: velocities are backward differences between frames (0 for discs that were not there "
        "before); write 'dump … custom … id x y vx vy' for better ones."
    )
    before: tuple[np.ndarray, np.ndarray, np.ndarray, float] | None = None
    for frame in dump:
        ids, time = frame.ids, context.time(frame)
        order = np.argsort(ids, kind="stable")
        vx, vy = np.zeros(frame.n), np.zeros(frame.n)
        if before is not None and time > before[3]:
            _, now, then = np.intersect1d(ids, before[0], return_indices=True)
            vx[now] = (frame.x[now] - before[1][then]) / (time - before[3])
            vy[now] = (frame.y[now] - before[2][then]) / (time - before[3])
        before = (ids[order], frame.x[order], frame.y[order], time)
        columns = dict(frame.columns) | {"vx": vx, "vy": vy}
        yield make_frame(frame.step, frame.time, frame.box, columns)


def _find_forces(places: tuple[Path, ...], warnings: list[str]) -> dict:
    from lammps_jump.dump.find import read_forces

    for place in places:
        if (place / "forces.csv").is_file():
            try:
                return read_forces(place / "forces.csv")
            except DumpError as error:
                warnings.append(str(error))
                return {}
    return {}


def summarise(gathered: Gathered, request: AnalysisRequest, warnings: list[str]) -> tuple[dict, dict]:
    """Summary parts, and the full results of each analysis for tables and figures."""
    parts: dict[str, Any] = {}
    shown: dict[str, Any] = {}
    context = gathered.context
    if gathered.energy is not None:
        from .energy import summarise_energy

        parts["energy"] = summarise_energy(gathered.energy, context)
    if gathered.front is not None:
        from .front import summarise_front

        parts["front"] = summarise_front(gathered.front, context)
    if request.jump:
        from lammps_jump.analysis.jump.result import analyse_jump
        from lammps_jump.analysis.jump.summary import summarise_jump

        shown["jump"] = analyse_jump(gathered.profiles, context, gathered.contacts)
        parts["jump"] = summarise_jump(shown["jump"])
    if gathered.forces:
        from lammps_jump.analysis.forces.history import analyse_forces

        shown["force"] = analyse_forces(gathered.forces, context, gathered.momentum, gathered.profiles)
        parts["force"] = shown["force"].summary
    return parts, shown


def _write_tables(gathered: Gathered, shown: dict, out: Path) -> list[str]:
    """The small tables as CSV (SI units); returns their names."""
    from lammps_jump.dump.exports import write_table

    tables: dict[str, dict[str, np.ndarray]] = {}
    if gathered.energy is not None:
        history = gathered.energy
        tables["energy.csv"] = {
            "time": history.time,
            "kinetic": history.kinetic,
            "rotational": history.rotational,
            "potential": history.potential,
            **({} if history.elastic is None else {"elastic": history.elastic}),
            "total": history.total,
        }
    if gathered.front is not None:
        history = gathered.front
        names = ("time", "bulk", "quantile", "height", "top_speed", "tip_speed")
        tables["front.csv"] = {name: getattr(history, name) for name in names}
    if "jump" in shown:
        tables |= shown["jump"].tables()
    if "force" in shown:
        tables |= shown["force"].tables()
    for name, columns in tables.items():
        write_table(columns, out / name)
    return list(tables)
