# SPDX-License-Identifier: GPL-2.0-or-later
"""Depth profiles along the channel: a dump's frames binned in x, and their means over a window of time.

Every disc is shared among the bins it straddles by the area on each side (exact circular segments), so mass,
discharge and momentum over all bins and what lies outside add up to the discs' to round-off.
"""

from __future__ import annotations

from collections.abc import Iterable
from math import asin, ceil, floor, pi, sqrt

import numpy as np
import xarray as xr
from numba import njit

from lammps_jump.dump.frame import Frame
from lammps_jump.errors import DumpError
from lammps_jump.scene.schedule import MOST_BINS
from lammps_jump.scene.walls import Interval

from .cell_grid import sort_into_cells
from .flow import Flow
from .statistics import LEAST_SAMPLES, block_average

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
LINES_PER_DIAMETER = 8
REACH = 2.0
"""Centres up to this many diameters apart are neighbours: a whole disc would fit between two that are not."""


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
        a bin holds nothing to average or has no bed; ``bed`` (x); ``step``, ``discs``, ``mass_total``, ``mass_left``
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
        self.bed = flow.mean_bed(self.edges)
        lines = bins * max(1, int(np.ceil(LINES_PER_DIAMETER * width / flow.scene.diameter - 1e-9)))
        self.bed_lines = flow.bed_height(self.edges[0] + (np.arange(lines) + 0.5) * (bins * width / lines))
        self._kept: list[tuple] = []

    def add(self, frame: Frame, time: float) -> None:
        """Add a frame."""
        flow, low, width, bins = self.flow, self.edges[0], self.flow.bin_width, len(self.edges) - 1
        x, y, vx, vy = np.ascontiguousarray(frame.x), np.ascontiguousarray(frame.y), frame.vx, frame.vy
        sums = np.zeros((6, bins))
        beyond = np.zeros(2)
        radius, mass = flow.radii(frame), flow.relative_masses(frame)
        bin_frame(x, y, vx, vy, radius, mass, low, width, sums, beyond)
        reach = REACH * 2.0 * flow.largest_radius(frame)
        surface = surface_frame(x, y, vx, radius, reach, flow.bed_height(x), self.bed_lines, low, width, bins)
        self._kept.append((time, frame.step, frame.n, mass.sum(), beyond, sums, *surface))

    def result(self) -> xr.Dataset:
        """Profiles of all frames added."""
        if not self._kept:
            raise DumpError("there is no frame to make profiles of.")
        columns = (np.array(part) for part in zip(*self._kept, strict=True))
        times, steps, discs, total, beyond, sums, surface, top_speed = columns
        values = _values(sums, surface, top_speed, self.bed, self.flow.bin_width, self.flow)
        masses = (self.flow.scene.mass * part for part in (total, *beyond.T))
        return _dataset(values, times, steps, discs, masses, self.edges, self.bed, self.flow)


def _values(sums, surface, top_speed, bed, width, flow) -> dict[str, np.ndarray]:
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


def _dataset(values, times, steps, discs, masses, edges, bed, flow) -> xr.Dataset:
    def described(array, units, long_name, dims=("time",)):
        return dims, array, {"units": units, "long_name": long_name}

    total, left, right = masses
    when = ("s", "simulated time") if flow.timed else ("1", "step")
    variables = {name: described(values[name], *VARIABLES[name], ("time", "x")) for name in VARIABLES}
    variables |= {
        "bed": described(bed, "m", "height of the bed (mean over the bin)", ("x",)),
        "step": described(steps, "1", "time step of the frame"),
        "discs": described(discs, "1", "discs in the frame"),
        "mass_total": described(total, "kg m-1", "mass of all discs per unit width"),
        "mass_left": described(left, "kg m-1", "mass left of the first bin"),
        "mass_right": described(right, "kg m-1", "mass right of the last bin"),
    }
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
    """Which of the times lie in the window, its ends included but for rounding; bool, of the shape of `time`."""
    slack = 1e-9 * max(1.0, abs(window[0]), abs(window[1]))
    return (time >= window[0] - slack) & (time <= window[1] + slack)


def add_means(dataset: xr.Dataset, window: tuple[float, float] | None = None) -> xr.Dataset:
    """The dataset with ``<name>_mean`` and ``<name>_stderr`` (x) over a window of time.

    ``velocity_mean`` is the mean discharge over the mean mass depth, so that their product is the discharge.

    A standard error is NaN where the window holds fewer than 8 frames or is too short for its blocks to become
    independent (see `statistics.block_average`).

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
    means = {}
    for name, (units, long_name) in VARIABLES.items():
        mean, error = block_average(dataset[name].values[inside])
        told = {"units": units, "long_name": f"time mean of {long_name}"}
        if name == "velocity":
            mean, error = _mean_velocity(dataset["discharge"].values[inside], dataset["mass_depth"].values[inside])
            told["long_name"] = "mean discharge over mean mass depth"
        means[f"{name}_mean"] = "x", mean, told
        means[f"{name}_stderr"] = (
            "x",
            error,
            told | {"long_name": f"standard error of the {told['long_name']}"},
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
    deep = depth.mean(axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.where(deep > 0, discharge.mean(axis=0) / deep, np.nan)
        return mean, block_average((discharge - mean * depth) / deep)[1]


def _left_share_py(a):
    """Share of a unit disc's area left of x = a (exact): 1/2 + (a sqrt(1 - a^2) + asin a) / pi."""
    if a <= -1.0:
        return 0.0
    if a >= 1.0:
        return 1.0
    return 0.5 + (a * sqrt(1.0 - a * a) + asin(a)) / pi


def _bin_frame_py(x, y, vx, vy, radius, mass, low, width, sums, beyond):
    """Add discs to ``sums[quantity, bin]`` and the mass of ``beyond`` (left, right), in shares of area.

    Quantities: mass; sum of u, of u^2, of u |v|^2 / 2 and of y, each times the mass; number.
    """
    bins = sums.shape[1]
    for i in range(len(x)):
        r, m = radius[i], mass[i]
        left = (x[i] - r - low) / width
        if left >= bins:
            beyond[1] += m
            continue
        if (x[i] + r - low) / width <= 0.0:
            beyond[0] += m
            continue
        u = vx[i]
        kinetic = 0.5 * (u * u + vy[i] * vy[i])
        first = max(floor(left), -1)
        done = 0.0
        k = first
        while done < 1.0:
            # everything outside the range is one bin on either side
            upto = 1.0 if k >= bins else _left_share((low + (k + 1) * width - x[i]) / r)
            share = upto - done
            part = share * m
            done = upto
            if k < 0:
                beyond[0] += part
            elif k >= bins:
                beyond[1] += part
            else:
                sums[0, k] += part
                sums[1, k] += part * u
                sums[2, k] += part * u * u
                sums[3, k] += part * u * kinetic
                sums[4, k] += part * y[i]
                sums[5, k] += share
            k += 1


def _connected_py(x, y, radius, reach, bed):
    """Whether each disc is connected to the bed (breadth-first search over a cell grid of side `reach`)."""
    n = len(x)
    joined = np.zeros(n, np.bool_)
    if n == 0:
        return joined
    cell, start, members, nx, ny = sort_into_cells(x, y, reach)
    queue = np.empty(n, np.int64)
    tail = 0
    air = reach / REACH
    for i in range(n):
        # at most a diameter of air below the disc; false where the bed is NaN
        if -2.0 * radius[i] <= y[i] - bed[i] <= radius[i] + air:
            joined[i] = True
            queue[tail] = i
            tail += 1
    head = 0
    limit = reach * reach * (1.0 + 1e-12)
    while head < tail:
        i = queue[head]
        head += 1
        cx, cy = cell[i] // ny, cell[i] % ny
        for kx in range(max(cx - 1, 0), min(cx + 2, nx)):
            for ky in range(max(cy - 1, 0), min(cy + 2, ny)):
                c = kx * ny + ky
                for m in range(start[c], start[c + 1]):
                    j = members[m]
                    if not joined[j]:
                        dx, dy = x[j] - x[i], y[j] - y[i]
                        if dx * dx + dy * dy <= limit:
                            joined[j] = True
                            queue[tail] = j
                            tail += 1
    return joined


def _surface_frame_py(x, y, vx, radius, reach, bed, bed_lines, low, width, bins):
    """Depth of the free surface (m) and mean u of the discs that form it (m/s, NaN where dry), a value a bin.

    `bed` is the floor's height under each disc, `bed_lines` at each line, m; line k of the range stands at
    ``low + (k + 1/2) spacing``. A line without a floor makes its bin NaN.
    """
    joined = _connected(x, y, radius, reach, bed)
    lines = len(bed_lines)
    per_bin = lines // bins
    spacing = width / per_bin
    top = np.full(lines, -1, np.int64)
    top_y, top_radius = np.full(lines, -np.inf), np.zeros(lines)
    for i in range(len(x)):
        if joined[i]:
            r, height = radius[i], y[i]
            first = max(ceil((x[i] - r - low) / spacing - 0.5), 0)
            last = min(floor((x[i] + r - low) / spacing - 0.5), lines - 1)
            for k in range(first, last + 1):
                # the higher top edge, without rounding where discs are equal
                if height - top_y[k] > top_radius[k] - r:
                    top[k], top_y[k], top_radius[k] = i, height, r
    depth = np.zeros(bins)
    speed = np.zeros(bins)
    for b in range(bins):
        wet = 0
        for k in range(b * per_bin, (b + 1) * per_bin):
            if np.isnan(bed_lines[k]):
                depth[b] = np.nan
            elif top_y[k] + top_radius[k] > bed_lines[k]:
                depth[b] += top_y[k] + top_radius[k] - bed_lines[k]
                speed[b] += vx[top[k]]
                wet += 1
        depth[b] /= per_bin
        speed[b] = speed[b] / wet if wet else np.nan
    return depth, speed


_left_share = njit(cache=True)(_left_share_py)
_connected = njit(cache=True)(_connected_py)
bin_frame = njit(cache=True)(_bin_frame_py)
surface_frame = njit(cache=True)(_surface_frame_py)
