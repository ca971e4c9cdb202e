"""One pass over the frames of a dump feeds every analysis that was asked for."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lammps_jump.dump.frame import Frame, make_frame, require_finite
from lammps_jump.dump.read import Dump
from lammps_jump.errors import DumpError

from .flow import Flow

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
    flow : Flow
    profiles : xarray.Dataset
    contacts : ContactSeries or None
        Thrust and bed forces by frame and bin.
    energy : EnergyHistory or None
    front : FrontHistory or None
    momentum : MomentumHistory or None
    forces : dict of str to ForceHistory
    """

    flow: Flow
    profiles: xr.Dataset
    contacts: Any = None
    energy: Any = None
    front: Any = None
    momentum: Any = None
    forces: Any = None


def gather(
    dump: Dump, flow: Flow, request: AnalysisRequest, warnings: list[str], places: tuple[Path, ...] = ()
) -> Gathered:
    """One pass over a dump: profiles and, as asked for, contacts, energy, front and momentum.

    Memory holds one frame and what is kept of it (sums over bins), so dumps of any size can be read.
    """
    from .profiles import add_means, bin_edges, compute_profiles

    warnings += flow.notes
    takers, collectors = [], {}
    edges = bin_edges(flow.x_range, request.bin_width or flow.bin_width)
    if flow.knows_contacts and (request.jump or request.energy):
        from .contact_series import ContactCollector

        collectors["contacts"] = ContactCollector(flow, edges if request.jump else None)
        takers.append(collectors["contacts"])
    if request.energy:
        from .energy import EnergyLedger

        collectors["energy"] = EnergyLedger(flow, collectors.get("contacts"))
        takers.append(collectors["energy"])
    if request.front:
        from .front import FrontTracker

        collectors["front"] = FrontTracker(flow)
        takers.append(collectors["front"])
    forces = _find_forces(places, warnings) if request.forces or flow.scene.probes else {}
    if forces:
        from lammps_jump.analysis.forces.impulse import MomentumLedger

        collectors["momentum"] = MomentumLedger(flow)
        takers.append(collectors["momentum"])
    frames = with_velocities(dump, flow, warnings)
    free = replace(flow, window=None)
    profiles = compute_profiles(_feed(frames, flow, takers), free, bin_width=request.bin_width)
    warnings += dump.warnings
    window = request.window or flow.window
    if window is not None:
        try:
            profiles = add_means(profiles, window)
        except DumpError as error:
            warnings.append(f"Means are over the second half of the frames instead: {error}")
    return Gathered(flow, profiles, forces=forces, **{k: v.result() for k, v in collectors.items()})


def _feed(frames: Iterator[Frame], flow: Flow, takers: list) -> Iterator[Frame]:
    """The same frames, shown to every taker on the way."""
    for frame in frames:
        require_finite(frame, flow.scene.name)
        time = flow.time(frame)
        for taker in takers:
            taker.add(frame, time)
        yield frame


def with_velocities(dump: Dump, flow: Flow, warnings: list[str]) -> Iterator[Frame]:
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
        ids, time = frame.ids, flow.time(frame)
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
