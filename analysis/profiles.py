# SPDX-License-Identifier: GPL-2.0-or-later
"""Depth profiles along the channel: a dump's frames binned in x, and their means over a window of time.

Every disc is shared among the bins it straddles by the area on each side (exact circular segments), so mass,
discharge and momentum over all bins and what lies outside add up to the discs' to round-off. Where rows of an inlet
let discs in, each counts over the way that it goes from turn to turn (`inlet_rows`).

Discs of a row follow each other at the distance v T, with the time T from turn to turn. Frames whose times are whole
multiples of T see all of them at the same places, again and again: their mean is that of one picture, and a bin that
holds two and a half discs of a row reads two or three. So a disc counts over the way that it goes within T. That is
the mean over this time for all that goes straight on, and shifts nothing by more than v T/2 elsewhere.

At an inlet and at an outlet discs come and go with their centres. Discs before such a plane reach beyond it, and
no disc beyond it reaches back: the sums fold that area back.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from math import inf, nan
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from lammps_jump.core.library import BYTES, INTEGER, INTEGERS, REAL, REALS, core, entry, function
from lammps_jump.dump.frame import Frame
from lammps_jump.errors import DumpError
from lammps_jump.scene import Interval, Scene
from lammps_jump.scene.schedule import MOST_BINS

from .flow import Flow
from .statistics import LEAST_SAMPLES, block_average, known_mean

if TYPE_CHECKING:
    import xarray as xr

NEAR = 0.25
"""Share of the distance of followers by which the last disc of a row may lie off its place, where its row runs."""
FARTHEST = 5.0
"""Distance of followers, in largest diameters, from which on a row rests in between."""


class Ways(NamedTuple):
    """Over which ways the centres of discs count in sums over bins.

    Attributes
    ----------
    start, stop : ndarray, shape (n,), m
        Ends of each way.
    weight : ndarray, shape (n,)
        Share of a disc that counts; 0 of one that is beyond the ends.
    ends : (float, float)
        Planes at which discs come and go, m; infinite where there is none.
    """

    start: np.ndarray
    stop: np.ndarray
    weight: np.ndarray
    ends: Interval = (-inf, inf)

    @classmethod
    def none(cls, x: np.ndarray) -> Ways:
        """Discs count where they are."""
        return cls(x, x, np.ones(len(x)))


class RunningRows(NamedTuple):
    """Rows of an inlet that run at a frame, with the disc of each that comes next, arrays of shape (rows,).

    Attributes
    ----------
    interval : s
        Time from its last disc to the next one.
    x, y, u, v : m, m/s
        Where the next disc would be if it came at its velocity all the way: upstream of the inlet.
    """

    interval: np.ndarray
    x: np.ndarray
    y: np.ndarray
    u: np.ndarray
    v: np.ndarray


NO_ROWS = RunningRows(*np.empty((5, 0)))


class OpenEnds(NamedTuple):
    """Ends of a range: planes at which discs come or go, m, infinite where there is none.

    `inlet` is the one at which they come, NaN without.
    """

    begin: float
    end: float
    inlet: float

    @classmethod
    def of(cls, flow: Flow) -> OpenEnds:
        """Ends of the range of a flow."""
        scene, (low, high) = flow.scene, flow.x_range
        rows = [row for row in scene.inlets if row.vx]
        planes = {(row.x, row.vx > 0) for row in rows}
        planes |= {(one.at, one.side == "below") for one in scene.outlets if one.axis == "x"}
        inlet = next((row.x for row in rows if row.x == (low if row.vx > 0 else high)), nan)
        return cls(low if (low, True) in planes else -inf, high if (high, False) in planes else inf, inlet)

    def ways(self, x: np.ndarray, half: np.ndarray) -> Ways:
        """Ways of discs at x that go `half` a way on either side, m.

        What lies before the inlet is no way: the disc was not there yet. Beyond an outlet others have gone before.
        """
        start, stop, weight = x - half, x + half, np.where((x < self.begin) | (x > self.end), 0.0, 1.0)
        if self.inlet in (self.begin, self.end):
            if self.inlet == self.begin:
                start, passed = np.maximum(start, self.begin), x > self.end
            else:
                stop, passed = np.minimum(stop, self.end), x < self.begin
            goes = (half > 0) & ~passed
            weight = np.where(goes, np.maximum(stop - start, 0.0) / np.where(goes, 2.0 * half, 1.0), weight)
        return Ways(start, stop, weight, (self.begin, self.end))


def running_rows(flow: Flow, frame: Frame) -> RunningRows:
    """Rows that run at a frame: the last disc of each is where its velocity has brought it.

    So it is in no dump of another run, and at no drowned inlet.
    """
    scene, rows = flow.scene, flow.scene.inlets
    if not rows or not flow.time_step:
        return NO_ROWS
    farthest, running = FARTHEST * scene.largest, []
    inlet = np.flatnonzero(np.abs(frame.x - rows[0].x) < farthest)
    x, y = frame.x[inlet], frame.y[inlet]
    for row in rows:
        turns = row.turns_around(frame.step)
        if turns is None or not row.vx:
            continue
        since, ahead = ((frame.step - turn) * flow.time_step for turn in turns)
        last, coming = (row.speed_at(turn) for turn in turns)
        distance = abs(last) * (since - ahead)
        off = np.abs(x - row.x - last * since), np.abs(y - row.y - row.vy * since)
        if distance < farthest and ((off[0] < NEAR * distance) & (off[1] < row.clearance)).any():
            running.append((since - ahead, row.x + coming * ahead, row.y + row.vy * ahead, coming, row.vy))
    return RunningRows(*np.array(running).T) if running else NO_ROWS


def intervals_of(y: np.ndarray, rows: RunningRows) -> np.ndarray:
    """Time from disc to disc of the row nearest to each height (m), s, shape of `y`; 0 where no row runs."""
    if not len(rows.y):
        return np.zeros(len(y))
    order = np.argsort(rows.y)
    heights = rows.y[order]
    return rows.interval[order][np.searchsorted(0.5 * (heights[1:] + heights[:-1]), y)]


VARIABLES = {
    "surface_depth": ("m", "depth of the free surface above the bed"),
    "mass_depth": ("m", "depth by mass, N m / (rho L)"),
    "velocity": ("m s-1", "mean horizontal velocity, by mass"),
    "discharge": ("m2 s-1", "discharge per unit width, sum of m u / (rho L)"),
    "momentum_flux": ("m3 s-2", "momentum flux per unit width and density, sum of m u^2 / (rho L)"),
    "energy_flux": ("m4 s-3", "flux of kinetic energy per unit width and density, sum of m u |v|^2 / (2 rho L)"),
    "packing": ("1", "disc area over the area between bed and free surface"),
    "surface_velocity": ("m s-1", "mean horizontal velocity of the discs that form the free surface"),
    "centroid_height": ("m", "height of the centre of mass above the bed"),
    "count": ("1", "number of discs, those astride an edge in parts"),
}
CARRIED = ("discharge", "momentum_flux", "energy_flux")
"""Fluxes that discs carry: not known in a frame and bin where the velocity of none of them is."""
LINES_PER_DIAMETER = 8
REACH = 2.0
"""Centres up to this many diameters apart are neighbours: a whole disc would fit between two that are not."""

_bin_frame = entry(
    "jump_bin_frame", n=INTEGER, start=REALS, stop=REALS, weight=REALS, y=REALS, vx=REALS, vy=REALS, radius=REALS,
    mass=REALS, begin=REAL, end=REAL, low=REAL, width=REAL, bins=INTEGER, sums=REALS, beyond=REALS,
)  # fmt: skip
_connected = function("jump_connected", INTEGER, REALS, REALS, REALS, REALS, REAL, REAL, BYTES)
_top_discs = entry(
    "jump_top_discs", n=INTEGER, x=REALS, y=REALS, radius=REALS, joined=BYTES, low=REAL, spacing=REAL, lines=INTEGER,
    top=INTEGERS,
)  # fmt: skip


def bin_edges(x_range: Interval, bin_width: float) -> np.ndarray:
    """Edges of equal bins from the left end of `x_range`, m; what is left at the right, less than a bin, is outside.

    Raises
    ------
    DumpError
        A range or a bin width that is not positive.
    """
    low, high = x_range
    if not (np.isfinite(bin_width) and bin_width > 0):
        raise DumpError(f"bin_width = {bin_width} m: it must be above 0.")
    if not (np.isfinite([low, high]).all() and high > low):
        raise DumpError(f"x_range = ({low}, {high}) m: the right end must lie beyond the left.")
    bins = max(1, int(np.floor((high - low) / bin_width + 1e-9)))
    if bins > MOST_BINS:
        raise DumpError(
            f"bin_width = {bin_width} m makes {bins} bins of {high - low:zg} m; at most {MOST_BINS}: widen it."
        )
    return low + bin_width * np.arange(bins + 1)


def compute_profiles(frames: Iterable[Frame], flow: Flow) -> xr.Dataset:
    """`bin_frames`, with `add_means` over the window of the flow, else over the second half of the times."""
    return add_means(bin_frames(frames, flow), flow.window)


def bin_frames(frames: Iterable[Frame], flow: Flow) -> xr.Dataset:
    """Profiles of every frame.

    The free surface is the mean, over eight vertical lines a diameter, of the top edge of the highest disc that the
    line cuts among the discs *connected* to the bed: a chain of centres no further than two diameters apart (of the
    largest disc where sizes differ), whose first has no more than a diameter of air under it. A line that cuts none
    counts as dry. A disc that is splashed up has no such chain and does not count. ``packing`` uses all discs of the
    bin over the area below that surface.

    Parameters
    ----------
    frames : iterable of Frame
        Streamed: one at a time in memory.
    flow : Flow

    Returns
    -------
    xarray.Dataset
        Coordinates ``time`` (s) and ``x`` (bin centres, m); variables of `VARIABLES` with dims (time, x), NaN where
        a bin holds nothing to average or has no bed; ``bed`` (x), and ``bed_at`` (time, x) where a wall of it moves,
        of which ``bed`` is the mean; ``step``, ``discs``, ``mass_total``, ``mass_left``
        and ``mass_right`` of the bins (time), kg per metre of width.

    Raises
    ------
    DumpError
        No frame at all, a missing column, a wrong range or width.
    """
    binner = Binner(flow)
    for frame in frames:
        binner.add(frame, flow.time(frame))
    return binner.result()


class Binner:
    """Collects the profiles that `bin_frames` makes."""

    def __init__(self, flow: Flow):
        self.flow, self.edges = flow, bin_edges(flow.x_range, flow.bin_width)
        bins, width = len(self.edges) - 1, flow.bin_width
        lines = bins * max(1, int(np.ceil(LINES_PER_DIAMETER * width / flow.scene.diameter - 1e-9)))
        self.places = places = self.edges[0] + (np.arange(lines) + 0.5) * (bins * width / lines)
        self.ends = OpenEnds.of(flow)
        self.bed, self.bed_lines = flow.mean_bed(self.edges), flow.bed_height(places)
        self._beds: list[np.ndarray] = []
        # a line at an inlet sees discs on one side of it alone, and none of half of those that it should
        away = 0.5 * flow.scene.largest
        seen = ((places > self.ends.begin + away) & (places < self.ends.end - away)).reshape(bins, -1)
        self.seen = seen | ~seen.any(axis=1, keepdims=True)
        self._kept: list[tuple[Any, ...]] = []

    def add(self, frame: Frame, time: float, intervals: np.ndarray | None = None) -> None:
        """Add a frame; `intervals` as of `inlet_rows.intervals_of`, where its x is not that of the inlet."""
        flow, low, width, bins = self.flow, self.edges[0], self.flow.bin_width, len(self.edges) - 1
        radius, mass = flow.radii(frame), flow.relative_masses(frame)
        discs = FrameDiscs.of(frame.x, frame.y, frame.vx, frame.vy, radius, mass)
        rows = running_rows(flow, frame) if intervals is None else NO_ROWS
        times = intervals_of(discs.y, rows) if intervals is None else intervals
        counted, coming = discs.followed_by(rows, flow.scene), len(rows.x)
        half = 0.5 * np.nan_to_num(np.abs(counted.u)) * np.append(times, rows.interval)
        ways, known = self.ends.ways(counted.x, half), np.isfinite(counted.u)
        sums, beyond = (
            bin_discs(counted, low, width, bins, ways)
            if known.all()
            else bin_known(counted, known, low, width, bins, ways)
        )
        if coming:  # they are upstream of the inlet, and not there
            beyond[0 if rows.u[0] > 0 else 1] -= counted.mass[-coming:].sum()
        if flow.bed_moves:
            self.bed_lines = flow.bed_height(self.places, time)
            self._beds.append(flow.mean_bed(self.edges, time))
        joined = connected(discs, flow.bed_height(discs.x, time), REACH * 2.0 * flow.largest_radius(frame))
        surface = surface_of(discs, joined, self.bed_lines, low, width, bins, self.seen)
        self._kept.append((time, frame.step, frame.n, mass.sum(), beyond, sums, *surface))

    @property
    def frames(self) -> int:
        """Number of frames added."""
        return len(self._kept)

    def result(self) -> xr.Dataset:
        """Profiles of all frames added."""
        if not self._kept:
            raise DumpError("there is no frame to make profiles of.")
        columns = (np.array(part) for part in zip(*self._kept, strict=True))
        times, steps, discs, total, beyond, sums, surface, top_speed = columns
        bed = np.array(self._beds) if self.flow.bed_moves else self.bed
        values = _values(sums, surface, top_speed, bed, self.flow.bin_width, self.flow)
        masses = (self.flow.scene.mass * part for part in (total, *beyond.T))
        return _dataset(values, times, steps, discs, masses, self.edges, bed, self.flow)


def _values(
    sums: np.ndarray, surface: np.ndarray, top_speed: np.ndarray, bed: np.ndarray, width: float, flow: Flow
) -> dict[str, np.ndarray]:
    """The `VARIABLES` of all frames, shape (frames, bins), of their sums over the bins, shape (frames, 6, bins)."""
    mass, speed, momentum, energy, height, count = sums.transpose(1, 0, 2)
    some, wet = mass > 1e-12, surface > 0
    safe, disc_area = np.where(some, mass, 1.0), np.pi * flow.scene.radius**2
    depth_unit = flow.scene.mass / (flow.scene.density * width)
    values = {
        "surface_depth": surface,
        "mass_depth": mass * depth_unit,
        "velocity": np.where(some, speed / safe, np.nan),
        "discharge": speed * depth_unit,
        "momentum_flux": momentum * depth_unit,
        "energy_flux": energy * depth_unit,
        "packing": np.where(wet, mass * disc_area / (width * np.where(wet, surface, 1.0)), np.nan),
        "surface_velocity": top_speed,
        "centroid_height": np.where(some, height / safe, np.nan) - bed,
        "count": count.copy(),  # no view, which would keep all sums
    }
    if not flow.velocities:
        values |= {name: np.full_like(mass, np.nan) for name in values if "s-" in VARIABLES[name][0]}
    return values


def _dataset(
    values: Mapping[str, np.ndarray], times: np.ndarray, steps: np.ndarray, discs: np.ndarray,
    masses: Iterable[np.ndarray], edges: np.ndarray, bed: np.ndarray, flow: Flow,
) -> xr.Dataset:  # fmt: skip
    def described(array: np.ndarray, units: str, long_name: str, dims: tuple[str, ...] = ("time",)) -> Any:
        return dims, array, {"units": units, "long_name": long_name}

    total, left, right = masses
    when = ("s", "simulated time") if flow.timed else ("1", "step")
    variables = {name: described(values[name], *VARIABLES[name], ("time", "x")) for name in VARIABLES}
    if bed.ndim > 1:
        variables["bed_at"] = described(bed, "m", "height of the bed, which moves (mean over the bin)", ("time", "x"))
        bed = bed.mean(axis=0)
    variables |= {
        "bed": described(bed, "m", "height of the bed (mean over the bin)", ("x",)),
        "step": described(steps, "1", "time step of the frame"),
        "discs": described(discs, "1", "discs in the frame"),
        "mass_total": described(total, "kg m-1", "mass of all discs per unit width"),
        "mass_left": described(left, "kg m-1", "mass left of the first bin"),
        "mass_right": described(right, "kg m-1", "mass right of the last bin"),
    }
    import xarray as xr  # 0.3 s

    return xr.Dataset(
        variables,
        coords={
            "time": described(times.astype(float), *when),
            "x": described(0.5 * (edges[1:] + edges[:-1]), "m", "distance along the channel", ("x",)),
        },
        attrs={
            "title": f"depth profiles of {flow.scene.name}",
            "Conventions": "CF-1.8",
            "bin_width": float(edges[1] - edges[0]),
            "x_low": float(edges[0]),
            "x_high": float(edges[-1]),
            "disc_diameter": flow.scene.diameter,
            "disc_mass": flow.scene.mass,
            "density": flow.scene.density,
            "gravity_x": flow.scene.gravity[0],
            "gravity_y": flow.scene.gravity[1],
            "surface_definition": "mean over vertical lines of the top edge of the highest disc connected to the bed; "
            f"{LINES_PER_DIAMETER} lines a diameter; connected: a chain of centres at most 2 diameters apart"
            + (" (of the largest disc)" if flow.sized else ""),
            "notes": " ".join(flow.notes),
        },
    )


def window_of(profiles: xr.Dataset) -> tuple[float, float]:
    """First and last time of the means, s."""
    return profiles.attrs["window_begin"], profiles.attrs["window_end"]


def within(time: np.ndarray, window: tuple[float, float]) -> np.ndarray:
    """Mask of the times in the window, its ends included but for rounding; bool, of the shape of `time`."""
    slack = 1e-9 * max(1.0, abs(window[0]), abs(window[1]))
    return (time >= window[0] - slack) & (time <= window[1] + slack)


def add_means(dataset: xr.Dataset, window: tuple[float, float] | None = None) -> xr.Dataset:
    """The dataset with ``<name>_mean`` and ``<name>_stderr`` (x) over a window of time.

    ``velocity_mean`` is the mean discharge over the mean mass depth, so that their product is the discharge.

    A frame in which nothing is known of the velocities in a bin counts in no mean of what moves there.

    A standard error is NaN where there is such a frame, where the window holds fewer than 8 frames or is too short for
    its blocks to become independent (see `statistics.block_average`).

    Parameters
    ----------
    dataset : xarray.Dataset
        Of `bin_frames`; earlier means are replaced.
    window : (float, float), optional
        s, both ends included; default the second half of the times.

    Raises
    ------
    DumpError
        No frame lies in the window.
    """
    time = dataset["time"].values
    if window is None:
        window = (0.5 * (time[0] + time[-1]), float(time[-1]))
    inside = within(time, window)
    if not inside.any():
        raise DumpError(
            f"no frame between t = {window[0]:zg} and {window[1]:zg} s: "
            f"the dump covers {time[0]:zg} to {time[-1]:zg} s."
        )
    means: dict[str, Any] = {}
    if "bed_at" in dataset:
        means["bed"] = "x", dataset["bed_at"].values[inside].mean(axis=0), dataset["bed"].attrs
    for name, (units, long_name) in VARIABLES.items():
        values = dataset[name].values[inside]
        mean, error = block_average(values)
        if name in CARRIED:
            mean = np.where(np.isnan(mean), known_mean(values), mean)
        attributes = {"units": units, "long_name": f"time mean of {long_name}"}
        if name == "velocity":
            mean, error = _mean_velocity(dataset["discharge"].values[inside], dataset["mass_depth"].values[inside])
            attributes["long_name"] = "mean discharge over mean mass depth"
        means[f"{name}_mean"] = "x", mean, attributes
        means[f"{name}_stderr"] = (
            "x",
            error,
            attributes | {"long_name": f"standard error of the {attributes['long_name']}"},
        )
    averaged = dataset.assign(means)
    averaged.attrs |= {
        "window_begin": float(window[0]),
        "window_end": float(window[1]),
        "window_frames": int(inside.sum()),
        "standard_error": "blocking (Flyvbjerg and Petersen 1989); NaN with fewer than "
        f"{LEAST_SAMPLES} frames or where blocks do not become independent within the window",
    }
    return averaged


def _mean_velocity(discharge: np.ndarray, depth: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mean discharge over mean mass depth, m/s, and its standard error, shape (bins,); NaN where no frame has a disc.

    The mean of the frames' velocities would count a shallow moment as much as a deep one.
    """
    deep = np.where(np.isnan(discharge), 0.0, depth).mean(axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.where(deep > 0, np.nan_to_num(discharge).mean(axis=0) / deep, np.nan)
        return mean, block_average((discharge - mean * depth) / deep)[1]


class FrameDiscs(NamedTuple):
    """Discs of a frame as float64: place (m), velocity (m/s), radius (m), and mass in that of a nominal disc."""

    x: np.ndarray
    y: np.ndarray
    u: np.ndarray
    v: np.ndarray
    radius: np.ndarray
    mass: np.ndarray

    @classmethod
    def of(cls, *columns: np.ndarray) -> FrameDiscs:
        """The same, contiguous."""
        return cls(*(np.ascontiguousarray(column, float) for column in columns))

    def followed_by(self, rows: RunningRows, scene: Scene) -> FrameDiscs:
        """The discs, and after them the next one of each row, of the mean mass."""
        if not len(rows.x):
            return self
        size = np.full(len(rows.x), scene.mean_square)
        coming = rows.x, rows.y, rows.u, rows.v, 0.5 * np.sqrt(size), size / scene.diameter**2
        return FrameDiscs(*map(np.append, self, coming))


def bin_discs(
    discs: FrameDiscs, low: float, width: float, bins: int, ways: Ways | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Sums of discs in bins from `low` on, by the shares of their areas.

    A disc counts over its way, as far as that lies between the planes at which discs come and go; without `ways` where
    it is.

    Returns
    -------
    sums : ndarray, shape (6, bins)
        Mass; sum of u, of u^2, of u |v|^2 / 2 and of y, each times the mass; number.
    beyond : ndarray, shape (2,)
        Mass left and right of the bins.
    """
    sums, beyond = np.zeros((6, bins)), np.zeros(2)
    x, y, u, v, radius, mass = discs
    start, stop, weight, (begin, end) = ways or Ways.none(x)
    if np.isfinite([begin, end]).any():
        away, left = (1.0 - weight) * mass, x < 0.5 * (begin + end)
        beyond += away[left].sum(), away[~left].sum()
    if core() is not None:
        _bin_frame(
            n=len(x), start=start, stop=stop, weight=weight, y=y, vx=u, vy=v, radius=radius, mass=mass, begin=begin,
            end=end, low=low, width=width, bins=bins, sums=sums, beyond=beyond,
        )  # fmt: skip
        return sums, beyond
    place, share = spread_shares((start, stop), radius, (begin, end), low, width, bins)
    share = share * weight
    part, energy = share * mass, 0.5 * (u * u + v * v)
    for row, weight in enumerate((part, part * u, part * u * u, part * u * energy, part * y, share)):
        # all that is outside the range is one bin on either side
        row_sums = np.bincount(place.ravel(), weight.ravel(), bins + 2)
        sums[row] = row_sums[1:-1]
        if row == 0:
            beyond += row_sums[[0, -1]]
    return sums, beyond


def bin_known(
    discs: FrameDiscs, known: np.ndarray, low: float, width: float, bins: int, ways: Ways
) -> tuple[np.ndarray, np.ndarray]:
    """`bin_discs` where velocities are known of some discs only, bool, shape (n,).

    What moves in a bin is the mean of the discs whose velocity is known, by mass, times the mass of all; NaN without.
    """
    still = discs._replace(u=np.zeros(len(known)), v=np.zeros(len(known)))
    sums, beyond = bin_discs(still, low, width, bins, ways)
    some = FrameDiscs.of(*(column[known] for column in discs))
    start, stop, weight, ends = ways
    moved, _ = bin_discs(some, low, width, bins, Ways(start[known], stop[known], weight[known], ends))
    with np.errstate(invalid="ignore", divide="ignore"):
        sums[1:4] = np.where(sums[0] > 0, moved[1:4] * sums[0] / moved[0], 0.0)
    return sums, beyond


def shares(x: np.ndarray, radius: np.ndarray, low: float, width: float, bins: int) -> tuple[np.ndarray, np.ndarray]:
    """Bins in which each disc lies, 0 and bins + 1 for those outside, and its share in each; shape (most, n)."""
    return spread_shares((x, x), radius, (-np.inf, np.inf), low, width, bins)


def spread_shares(
    ways: tuple[np.ndarray, np.ndarray], radius: np.ndarray, ends: Interval, low: float, width: float, bins: int
) -> tuple[np.ndarray, np.ndarray]:
    """The same of discs that are anywhere on a way from one place to another, m, both between the ends (m).

    What sticks out over an end is folded back.
    """
    start, stop = ways
    first = np.clip(np.floor((start - radius - low) / width), -1, bins)
    most = int(np.ceil((stop - start + 2.0 * radius).max(initial=0.0) / width)) + 1
    place = first + np.arange(most)[:, None]
    edge = np.where(place < 0, low, np.where(place >= bins, np.inf, low + (place + 1) * width))
    upto = left_share(edge, start, stop, radius)
    for end, whole in zip(ends, (1.0, 0.0), strict=True):
        if np.isfinite(end):
            upto = upto + left_share(edge, 2.0 * end - stop, 2.0 * end - start, radius) - whole
    upto = np.where(np.isinf(edge), 1.0, upto)
    return np.clip(place, -1, bins).astype(int) + 1, np.diff(upto, axis=0, prepend=0.0)


SHORT = 1e-4
"""Half of a way, in radii, below which it changes no share by more than 1e-9, and rounding would change it more."""


def left_share(edge: np.ndarray, start: np.ndarray, stop: np.ndarray, radius: np.ndarray) -> np.ndarray:
    """Share of a disc's area left of an edge, its centre anywhere from `start` to `stop` with the same chance; m.

    The share of a unit disc left of x = a is 1/2 + (a sqrt(1 - a^2) + asin a) / pi.
    """

    def summed(a: np.ndarray) -> np.ndarray:
        """Integral of the share up to a."""
        b = np.clip(a, -1.0, 1.0)
        height = np.sqrt(1.0 - b * b)
        within = 0.5 * b + (height * (1.0 - height * height / 3.0) + b * np.arcsin(b)) / np.pi
        return np.where(a <= -1.0, 0.0, np.where(a >= 1.0, a, within))

    half, middle = 0.5 * (stop - start) / radius, (edge - 0.5 * (start + stop)) / radius
    a = np.clip(middle, -1.0, 1.0)
    still = 0.5 + (a * np.sqrt(1.0 - a * a) + np.arcsin(a)) / np.pi
    moved = np.where(half < SHORT, SHORT, half)
    far = np.clip(middle, -1.0 - moved, 1.0 + moved)
    spread = (summed(far + moved) - summed(far - moved)) / (2.0 * moved)
    return np.where(half < SHORT, still, np.clip(spread, 0.0, 1.0))


def connected(discs: FrameDiscs, bed: np.ndarray, reach: float) -> np.ndarray:
    """Mask of the discs connected to the bed, shape (n,): by a chain of centres no further apart than `reach`.

    The first of a chain has at most a diameter of air under it, never where `bed` under it is NaN.
    """
    x, y, _, _, radius, _ = discs
    air, joined = reach / REACH, np.zeros(len(x), np.uint8)
    if core() is not None:
        _connected(len(x), x, y, radius, np.ascontiguousarray(bed, float), reach, air, joined)
        return joined
    if not len(x):
        return joined
    from scipy.sparse import coo_array  # 0.1 s
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    pairs = cKDTree(np.column_stack([x, y])).query_pairs(reach * (1.0 + 5e-13), output_type="ndarray")
    links = coo_array((np.ones(len(pairs), np.int8), pairs.T), shape=(len(x), len(x)))
    group = connected_components(links, directed=False)[1]
    low = (y - bed >= -2.0 * radius) & (y - bed <= radius + air)
    return np.isin(group, group[low]).astype(np.uint8)


def surface_of(
    discs: FrameDiscs, joined: np.ndarray, bed_lines: np.ndarray, low: float, width: float, bins: int,
    seen: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Depth of the free surface (m) and mean u of the discs that form it (m/s, NaN where dry), a value a bin.

    `bed_lines` is the bed's height at each line, m; line k of the range is at ``low + (k + 1/2) spacing``. A line
    without a bed makes its bin NaN. Of the lines those count that are `seen`, shape (bins, lines of a bin).
    """
    x, y, u, _, radius, _ = discs
    lines, each = len(bed_lines), len(bed_lines) // bins
    spacing = width / each
    if core() is not None:
        top = np.empty(lines, np.int64)
        _top_discs(n=len(x), x=x, y=y, radius=radius, joined=joined, low=low, spacing=spacing, lines=lines, top=top)
    else:
        top = _top_of_lines(discs, joined, low, spacing, lines)
    cut = top >= 0
    depth = np.where(cut, (y + radius)[top] if len(y) else 0.0, -np.inf) - bed_lines
    dry = np.isnan(bed_lines)
    wet = ~dry & (depth > 0)
    speed = u[top] if len(u) else np.zeros(lines)
    chosen = np.ones(lines, bool) if seen is None else seen.ravel()
    known = wet & np.isfinite(speed) & chosen
    counted = np.where(dry, np.nan, np.where(wet & chosen, depth, 0.0)), np.where(known, speed, 0.0)
    # one line after the other: a sum in pairs would round otherwise
    depths, speeds = (np.cumsum(values.reshape(bins, each), axis=1)[:, -1] for values in counted)
    number = known.reshape(bins, each).sum(axis=1)
    return depths / chosen.reshape(bins, each).sum(axis=1), np.where(number, speeds / np.maximum(number, 1), np.nan)


def _top_of_lines(discs: FrameDiscs, joined: np.ndarray, low: float, spacing: float, lines: int) -> np.ndarray:
    """The disc with the highest top edge at each line, -1 where none cuts it; of two as high the first."""
    index = np.flatnonzero(joined)
    x, radius = discs.x[index], discs.radius[index]
    first = np.maximum(np.ceil((x - radius - low) / spacing - 0.5), 0)
    last = np.minimum(np.floor((x + radius - low) / spacing - 0.5), lines - 1)
    each = np.maximum(last - first + 1, 0).astype(int)
    disc = np.repeat(index, each)
    line = np.repeat(first, each).astype(int) + np.arange(len(disc)) - np.repeat(np.cumsum(each) - each, each)
    order = np.lexsort((-disc, discs.y[disc], (discs.y + discs.radius)[disc], line))
    top = np.full(lines, -1)
    top[line[order]] = disc[order]  # the last of a line stays
    return top
