# SPDX-License-Identifier: GPL-2.0-or-later
"""One pass over the frames of a dump, which feeds every analysis of the case."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from lammps_jump.dump import Dump, ForceHistory
from lammps_jump.dump.frame import Frame, make_frame, require_finite
from lammps_jump.errors import DumpError

from .contacts import ContactSeries
from .flow import Flow, moving, placed, with_images
from .profiles import add_means, bin_frames

if TYPE_CHECKING:
    import xarray as xr

Tables = dict[str, Mapping[str, np.ndarray]]
"""Columns of CSV files by the name of the file."""


class Watcher(Protocol):
    """Consumer of frames, one after the other."""

    def add(self, frame: Frame, time: float) -> None:
        """Take in a frame at a time, s."""


class Collector(Watcher, Protocol):
    """Consumer of frames, one after the other, which gives its history at the end."""

    def result(self) -> object:
        """The history of all frames taken in."""


@dataclass(frozen=True)
class Gathered:
    """Data that one pass over a dump has left: input of the analyses and their figures.

    Attributes
    ----------
    flow : Flow
    profiles : xarray.Dataset
    contacts : ContactSeries or None
        Thrust and bed forces by frame and bin.
    histories : mapping of str to object
        Results of the collectors, by the name of their quantity.
    forces : mapping of str to ForceHistory
        Of ``forces.csv``.
    warnings : tuple of str
        Notes on the flow and of the pass.
    along : Gathered or None
        The same along a sloping stretch of bed (`lammps_jump.analysis.slope`), where there is one.
    pressure : Path or None
        Forces along outlines, where the engine has summed them.
    """

    flow: Flow
    profiles: xr.Dataset
    contacts: ContactSeries | None
    histories: Mapping[str, Any]
    forces: Mapping[str, ForceHistory]
    warnings: tuple[str, ...] = ()
    along: Gathered | None = None
    pressure: Path | None = None

    @property
    def thinned(self) -> xr.Dataset:
        """The profiles with at most 1200 times: a picture has a thousand rows of pixels."""
        return self.profiles.isel(time=slice(None, None, max(1, self.profiles.sizes["time"] // 600)))


def gather(dump: Dump, flow: Flow, collectors: Iterable[Watcher], warnings: list[str]) -> xr.Dataset:
    """Profiles of a dump; every collector is shown every frame on the way.

    Memory holds one frame and what is kept of it (sums over bins), so dumps of any size can be read.

    Parameters
    ----------
    dump : Dump
    flow : Flow
    collectors : iterable of Watcher
        Fed in this order.
    warnings : list of str
        Notes of the pass are added to it.
    """
    frames = with_velocities(dump, flow, warnings)
    profiles = bin_frames(feed(frames, flow, collectors), flow)
    warnings += dump.warnings
    try:
        made = add_means(profiles, flow.window)
    except DumpError as error:
        warnings.append(f"Means are over the second half of the frames instead: {error}")
        made = add_means(profiles)
    wet = made["packing_mean"].values[np.isfinite(made["packing_mean"].values)]
    if not flow.knows_contacts and wet.size and (usual := float(np.median(wet))) > 1:
        warnings.append(
            f"Discs cover {usual:z.3g} times the area below the surface: they lie behind each other or overlap, so no "
            "depth holds. Write a dump of one layer of discs, or give the right diameter (--diameter)."
        )
    return made


def feed(frames: Iterable[Frame], flow: Flow, collectors: Iterable[Watcher]) -> Iterator[Frame]:
    """The same frames, shown to every collector on the way.

    Collectors see the discs that move, those with `sees` "all" the fixed ones too, and those with "images" images
    beyond the ends of a periodic channel, as the profiles do.
    """
    collectors = list(collectors)
    scene = flow.scene
    for frame in frames:
        time, whole = flow.time(frame), placed(frame, scene)
        free = moving(whole, scene)
        views = {"all": whole, "free": free, "images": with_images(free, scene)}
        for collector in collectors:
            collector.add(views[getattr(collector, "sees", "free")], time)
        yield views["images"]


def with_velocities(dump: Dump, flow: Flow, warnings: list[str]) -> Iterator[Frame]:
    """The frames; where the file has no vx, vy they are differences of the positions between two frames.

    In a periodic box they are those to the nearest image: a disc that has gone over its side is at the other one.
    The other frame is the one before or, for a disc that is not in it, the next one. A disc that is in neither has the
    velocity NaN, as have all discs where there are no times.

    Raises
    ------
    DumpError
        A value of the file that is not finite.
    """
    frames = (require_finite(frame, flow.scene.name) for frame in dump)
    if {"vx", "vy"} <= set(dump.columns):
        yield from frames
        return
    made = (
        "velocities are differences of positions between frames; a disc seen once has none, is left out of means, and "
        "is drawn as one at rest"
    )
    if flow.knows_contacts:
        made += ". Forces of contacts take these velocities for dashpots and friction, and 0 of a disc that has none"
    warnings.append(
        f"The dump has no vx, vy: {made if flow.velocities else 'without times there are no velocities'}; write "
        "'dump … custom … id x y vx vy' for better ones."
    )
    before, now = None, next(frames, None)
    while now is not None:
        after = next(frames, None)
        speeds = np.full((2, now.n), np.nan)
        for other in (after, before) if flow.velocities else ():  # what the frame before tells counts
            if other is not None:
                _set_velocities(speeds, now, other, flow, _periods(dump, now, flow))
        yield make_frame(now.step, now.time, now.box, {**now.columns, "vx": speeds[0], "vy": speeds[1]})
        before, now = now, after


def _periods(dump: Dump, frame: Frame, flow: Flow) -> tuple[float | None, float | None]:
    """Lengths along x and y after which places repeat, m: of the scene, else of the dump's box; None where none do."""
    periods: list[float | None] = []
    for axis, periodic, (low, high) in zip("xy", dump.periodic, frame.box, strict=False):
        wrapped = bool({axis, f"{axis}s"} & set(frame.columns))  # others run on over the sides
        periods.append(float(high - low) if periodic and wrapped and high > low else None)
    return flow.scene.period or periods[0], periods[1]


def _set_velocities(
    speeds: np.ndarray, frame: Frame, other: Frame, flow: Flow, periods: tuple[float | None, float | None]
) -> None:
    """Set the velocities of the discs, shape (2, n), that another frame holds too, m/s."""
    span = flow.time(frame) - flow.time(other)
    if span == 0:
        return
    _, here, there = np.intersect1d(frame.ids, other.ids, return_indices=True)
    ways = np.array([frame.x[here] - other.x[there], frame.y[here] - other.y[there]])
    for way, period in zip(ways, periods, strict=True):
        if period is not None:  # a disc that has gone over the seam is at the other end
            way -= period * np.rint(way / period)
    speeds[:, here] = ways / span + 0.0  # no -0
