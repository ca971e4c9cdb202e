# SPDX-License-Identifier: GPL-2.0-or-later
"""Coarse-grained fields on a grid: density, velocity, kinetic and contact stress.

Definitions: I. Goldhirsch, "Stress, stress asymmetry and couple stress: from discrete particles to continuous
fields", Granular Matter 12 (2010) 239; walls end a contact's branch at their surface as in T. Weinhart et al.,
Granular Matter 14 (2012) 289. Each disc's kernel is normalised over the cells that are not inside a wall, so no
mass, momentum or force moment is lost into walls: sums over the grid equal the discs' to round-off.

Normalising alone would make a uniform fluid look thin at a wall (ln 2 = 0.69 of it at a plane): discs near the wall
lose little to it there, and those further off do not make up for it. So every cell has a weight a, computed by
balancing (R. Sinkhorn, Ann. Math. Statist. 35 (1964) 876): a(r) sum over r' of W(r - r') a(r') = 1 on the open
cells. With it a uniform fluid stays uniform up to the wall, and nothing is lost either.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache
from math import ceil, floor
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from lammps_jump.core.library import INTEGER, REAL, REALS, core, entry
from lammps_jump.dump import Dump, Frame
from lammps_jump.dump.exports import write_netcdf
from lammps_jump.errors import DumpError
from lammps_jump.scene.walls import Interval, Wall

from .contacts import find_contacts
from .draw.chart import Drawings
from .draw.maps import bed_pressure, bed_pressure_chart, field_map
from .flow import Flow
from .profiles import window_of, within

if TYPE_CHECKING:
    import xarray as xr

FIELD_FRAMES = 20
"""Frames of the window that the mean fields use at most: contact stress rings, one frame says little."""
GAUSS = np.polynomial.legendre.leggauss(4)
"""Points along a contact's branch: exact to degree 7 for a polynomial kernel."""

MOST_CELLS = 50_000_000
"""Of a grid with its margin."""

BALANCING_ROUNDS = 12
"""Each round about halves the error of the balance: 12 leave some 1e-4."""

_spread = entry(
    "jump_spread", n=INTEGER, points=REALS, weights=REALS, quantities=INTEGER, cell_weight=REALS, rows=INTEGER,
    columns=INTEGER, low_x=REAL, low_y=REAL, spacing=REAL, reach=REAL, sums=REALS,
)  # fmt: skip

LONG_NAMES = {
    "density": ("kg m-3", "bulk density"),
    "velocity_x": ("m s-1", "horizontal velocity"),
    "velocity_y": ("m s-1", "vertical velocity"),
    "kinetic_xx": ("Pa", "kinetic stress xx, compression positive"),
    "kinetic_xy": ("Pa", "kinetic stress xy, compression positive"),
    "kinetic_yy": ("Pa", "kinetic stress yy, compression positive"),
    "contact_xx": ("Pa", "contact stress xx, compression positive"),
    "contact_xy": ("Pa", "contact stress xy, compression positive"),
    "contact_yy": ("Pa", "contact stress yy, compression positive"),
    "pressure": ("Pa", "half the trace of contact and kinetic stress"),
    "hydrostatic": ("Pa", "weight of the density above, per area"),
}

VELOCITY = ["velocity_x", "velocity_y"]
OF_MOTION = {*VELOCITY, "kinetic_xx", "kinetic_xy", "kinetic_yy", "pressure"}
"""Fields of a frame with velocities alone."""


def compute_fields(
    frame: Frame, flow: Flow, *, x: Interval, y: Interval, spacing: float | None = None, reach: float | None = None
) -> xr.Dataset:
    """Fields of one frame.

    Parameters
    ----------
    frame : Frame
    flow : Flow
    x, y : (float, float)
        Extent of the grid, m.
    spacing : float, optional
        Cell size, m; default half a diameter.
    reach : float, optional
        Where the kernel ends, m; default two diameters. It is Lucy's: W ~ (1 + 3 q)(1 - q)^3, q = r/reach (standard
        deviation 0.37 reach, 2-D).

    Returns
    -------
    xarray.Dataset
        Dims (y, x), cell centres; NaN inside walls, and for velocities where there is no mass. Without velocities in
        the frame there are no ``velocity_*``, ``kinetic_*`` and ``pressure``. ``contact_*`` from normal forces (spring
        and dashpot, no friction), where the stiffness is known. ``hydrostatic`` is the integral of
        density g upwards within the grid, to hold against ``contact_yy + kinetic_yy``.

    Raises
    ------
    DumpError
        Sizes that are not positive, or a grid of too many cells.
    """
    spacing = 0.5 * flow.scene.diameter if spacing is None else spacing
    reach = 2.0 * flow.scene.diameter if reach is None else reach
    if not (spacing > 0 and reach > 0):
        raise DumpError(f"spacing = {spacing} m, reach = {reach} m: both must be above 0.")
    grid = _grid(flow, flow.time(frame), (x, y), spacing, reach)
    fields = _of_motion(frame, flow, grid)
    density = fields["density"]
    if flow.knows_contacts:
        xx, xy, yy = grid.sums(*_force_moments(frame, flow))
        fields |= {"contact_xx": xx, "contact_xy": xy, "contact_yy": yy}
        fields["pressure"] = 0.5 * (xx + yy + fields["kinetic_xx"] + fields["kinetic_yy"])
    if not {"vx", "vy"} <= set(frame.columns):
        fields = {name: values for name, values in fields.items() if name not in OF_MOTION}
    above = np.cumsum(density[::-1], axis=0)[::-1] - 0.5 * density
    fields["hydrostatic"] = above * spacing * abs(flow.gravity)
    rows, columns = grid.asked
    import xarray as xr  # 0.3 s

    return xr.Dataset(
        {name: _described(name, np.where(grid.free, values, np.nan)[grid.asked]) for name, values in fields.items()},
        coords={
            "x": ("x", grid.x[columns], {"units": "m", "long_name": "distance along the channel"}),
            "y": ("y", grid.y[rows], {"units": "m", "long_name": "height"}),
            "time": ((), flow.time(frame), {"units": "s", "long_name": "simulated time"}),
        },
        attrs={
            "kernel": "lucy",
            "reach": float(reach),
            "spacing": float(spacing),
            "title": f"fields of {flow.scene.name}",
        },
    )


class _Grid(NamedTuple):
    """Cells of the fields, and a margin of cells around their extent.

    Attributes
    ----------
    x, y : ndarray
        Centres of columns and rows, m.
    free : ndarray of bool, shape (rows, columns)
        Cells outside the walls.
    weight : ndarray, shape (rows, columns)
        Of `balance`.
    geometry : (float, float, float, float)
        Of `spread`.
    asked : (slice, slice)
        Rows and columns of the extent.
    """

    x: np.ndarray
    y: np.ndarray
    free: np.ndarray
    weight: np.ndarray
    geometry: tuple[float, float, float, float]
    asked: tuple[slice, slice]

    def sums(self, points: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """Weights of points, shape (n, quantities), per area of the cells around them, a plane a quantity."""
        sums = np.zeros((weights.shape[1], *self.free.shape))
        spread(points, weights, self.weight, self.geometry, sums)
        return sums


def _grid(flow: Flow, time: float, extent: tuple[Interval, Interval], spacing: float, reach: float) -> _Grid:
    """The grid at a time (s); its margin is one reach, so that discs outside contribute what they should."""
    margin = ceil(reach / spacing)
    nx, ny = (max(1, round((high - low) / spacing)) for low, high in extent)
    if (nx + 2 * margin) * (ny + 2 * margin) > MOST_CELLS:
        raise DumpError(f"a grid of {nx} x {ny} cells is too fine; raise spacing ({spacing} m).")
    low_x, low_y = (low - margin * spacing for low, _ in extent)
    x = low_x + (np.arange(nx + 2 * margin) + 0.5) * spacing
    y = low_y + (np.arange(ny + 2 * margin) + 0.5) * spacing
    open_ = _open_cells(flow.walls_at(time), tuple(x), tuple(y))
    weight = _cell_weight(open_.tobytes(), open_.shape, spacing, reach)
    inside = slice(margin, margin + ny), slice(margin, margin + nx)
    return _Grid(x, y, open_, weight, (low_x, low_y, spacing, reach), inside)


def _of_motion(frame: Frame, flow: Flow, grid: _Grid) -> dict[str, np.ndarray]:
    """Density, velocity and kinetic stress; without velocities in the frame discs count as at rest."""
    mass, still = flow.scene.mass * flow.relative_masses(frame), np.zeros(frame.n)
    u, v = (frame.columns.get(name, still) for name in ("vx", "vy"))
    weights = mass[:, None] * np.column_stack([np.ones(frame.n), u, v, u * u, u * v, v * v])
    density, *momentum, xx, xy, yy = grid.sums(np.column_stack([frame.x, frame.y]), weights)
    some = density > 0
    vx, vy = (part / np.where(some, density, 1.0) for part in momentum)
    return {
        "density": density,
        "velocity_x": np.where(some, vx, np.nan),
        "velocity_y": np.where(some, vy, np.nan),
        "kinetic_xx": np.maximum(xx - density * vx * vx, 0.0),
        "kinetic_xy": xy - density * vx * vy,
        "kinetic_yy": np.maximum(yy - density * vy * vy, 0.0),
    }


def _described(name: str, values: np.ndarray, of: str = "") -> tuple[Any, ...]:
    """Values over the grid with unit and name, of their mean where `of` says so."""
    units, long_name = LONG_NAMES[name]
    return ("y", "x"), values, {"units": units, "long_name": f"{of}{long_name}"}


def mean_fields(frames: Iterable[Frame], flow: Flow, *, x: Interval, y: Interval, **options: Any) -> xr.Dataset:
    """Time mean of `compute_fields` over frames: what a bed pressure needs, for contact forces ring.

    Velocities are means by mass; stresses are means of each frame's (kinetic stress about each frame's own velocity).

    Parameters
    ----------
    frames : iterable of Frame
    flow : Flow
    x, y : (float, float)
        Extent, m; one grid for all frames.
    **options
        As in `compute_fields`.

    Raises
    ------
    DumpError
        No frame.
    """
    total, count = None, 0
    for frame in frames:
        fields = compute_fields(frame, flow, x=x, y=y, **options).drop_vars("time")
        density = fields["density"]
        components = [name for name in VELOCITY if name in fields]
        fields.update((fields[components] * density).where(density != 0, 0 * density))
        total = fields if total is None else total + fields
        count += 1
    if total is None:
        raise DumpError("there is no frame to make fields of.")
    mean = total / count
    mean.update(mean[components] / mean["density"].where(mean["density"] > 0))
    mean = mean.assign({name: _described(str(name), values.values, "time mean of ") for name, values in mean.items()})
    return mean.assign_attrs(fields.attrs, frames=count)


def write_fields(flow: Flow, profiles: xr.Dataset, dump: Dump, out: Path) -> tuple[dict[str, Any], Drawings]:
    """Mean fields of the window of the profiles: ``fields.nc``, pressure at the bed.

    Returns
    -------
    summary : dict
        As under ``fields`` in ``summary.json``.
    figures : dict of str to Map or Chart

    Raises
    ------
    DumpError
        A place that cannot be written.
    """
    indices = np.flatnonzero(within(profiles["time"].values, window_of(profiles)))
    if len(indices) > FIELD_FRAMES:
        indices = indices[np.round(np.linspace(0, len(indices) - 1, FIELD_FRAMES)).astype(int)]
    bed = profiles["bed"].values
    surface = (profiles["surface_depth"] + profiles.get("bed_at", profiles["bed"])).values[indices]
    low = float(np.nanmin(bed)) if np.isfinite(bed).any() else flow.scene.domain[1][0]
    high = max(float(surface[np.isfinite(surface)].max(initial=low)), low) + 5 * flow.scene.diameter
    extent = {"x": (profiles.attrs["x_low"], profiles.attrs["x_high"]), "y": (low, high)}
    fields = mean_fields(dump.select(indices.tolist()), flow, **extent)
    write_netcdf(fields, out / "fields.nc")
    stress = "pressure" in fields
    named = ("density", "pressure") if stress else ("density",)
    figures: Drawings = {f"field_{name}": field_map(fields, flow, name) for name in named}
    summary: dict[str, Any] = {"file": "fields.nc", "frames": len(indices), "reach": float(fields.attrs["reach"])}
    if stress:
        figures["bed_pressure"] = bed_pressure_chart(fields)
        bottom = bed_pressure(fields)
        covered = bottom["hydrostatic"].values > flow.scene.density * flow.g * flow.scene.diameter
        if covered.any():
            ratio = bottom["stress"].values[covered].sum() / bottom["hydrostatic"].values[covered].sum()
            summary["bed_stress_over_weight"] = float(ratio)
    return summary, figures


def _force_moments(frame: Frame, flow: Flow) -> tuple[np.ndarray, np.ndarray]:
    """Points along the branches of all contacts and what each carries: its share of force (x) branch."""
    contacts = find_contacts(frame, flow)
    branch = contacts.start - contacts.end
    force = contacts.force[:, None] * contacts.normal
    moment = np.column_stack([force[:, 0] * branch[:, 0], force[:, 0] * branch[:, 1], force[:, 1] * branch[:, 1]])
    nodes, weights = 0.5 * (GAUSS[0] + 1), 0.5 * GAUSS[1]
    points = (contacts.end[:, None, :] + nodes[None, :, None] * branch[:, None, :]).reshape(-1, 2)
    return points, (weights[None, :, None] * moment[:, None, :]).reshape(-1, 3)


@lru_cache(maxsize=1)  # the frames of a run share their walls
def _open_cells(walls: tuple[Wall, ...], x: tuple[float, ...], y: tuple[float, ...]) -> np.ndarray:
    """Mask of the cells whose centre is outside all walls, bool, shape (len(y), len(x)). Not to be changed."""
    mesh = np.meshgrid(x, y)
    open_ = np.ones(mesh[0].shape, bool)
    for wall in walls:
        open_ &= wall.distance(*mesh) > 0
    return open_


@lru_cache(maxsize=1)
def _cell_weight(open_: bytes, shape: tuple[int, int], spacing: float, reach: float) -> np.ndarray:
    """`balance` of cells that are open where the bytes say so."""
    cells = np.frombuffer(open_, bool).reshape(shape).copy()
    return balance(cells, _kernel_table(spacing, reach), BALANCING_ROUNDS)


def _kernel_table(spacing: float, reach: float) -> np.ndarray:
    """The kernel between cell centres, summing to 1, shape (2 k + 1, 2 k + 1) with k = floor(reach / spacing)."""
    k = int(reach / spacing)
    steps = np.arange(-k, k + 1) * spacing
    q = np.hypot(*np.meshgrid(steps, steps)) / reach
    table = np.where(q < 1, (1 + 3 * q) * (1 - np.minimum(q, 1)) ** 3, 0.0)
    return table / table.sum()


def balance(open_: np.ndarray, table: np.ndarray, rounds: int) -> np.ndarray:
    """Weights a of the cells with a(r) sum W(r - r') a(r') = 1 on open cells, 0 in walls; 1 off the grid."""
    from scipy.ndimage import maximum_filter  # 0.08 s

    (rows, columns), k = open_.shape, len(table) // 2
    # only a wall's face within three reaches can matter: the other cells stay at 1
    face = ~open_ & maximum_filter(open_, 3)
    row, column = np.nonzero(open_ & maximum_filter(face, 6 * k + 1))
    a = np.pad(np.where(open_, 1.0, 0.0), k, constant_values=1.0)
    for _ in range(rounds):
        total = sum(weight * a[row + i, column + j] for (i, j), weight in np.ndenumerate(table))
        a[row + k, column + k] = np.sqrt(a[row + k, column + k] / total)
    return a[k : k + rows, k : k + columns].copy()


def spread(
    points: np.ndarray, weights: np.ndarray, cell_weight: np.ndarray, geometry: tuple[float, ...], sums: np.ndarray
) -> None:
    """Add each point's weights to ``sums[quantity, row, column]``, per area, over the open cells in reach.

    `cell_weight` is that of `balance`, zero in walls; each point's shares are normalised to one.
    A point without an open cell in reach gives everything to the cell it lies in; one off the grid with nothing in
    reach gives nothing. `geometry` holds the low ends of the grid, spacing and reach, m.
    """
    points, weights = np.ascontiguousarray(points, float), np.ascontiguousarray(weights, float)
    low_x, low_y, spacing, reach = geometry
    rows, columns = cell_weight.shape
    if core() is not None:
        _spread(
            n=len(points), points=points, weights=weights, quantities=weights.shape[1], cell_weight=cell_weight,
            rows=rows, columns=columns, low_x=low_x, low_y=low_y, spacing=spacing, reach=reach, sums=sums,
        )  # fmt: skip
        return
    area = spacing * spacing
    for i in range(len(points)):
        px, py = points[i, 0], points[i, 1]
        c0 = max(ceil((px - reach - low_x) / spacing - 0.5), 0)
        c1 = max(min(floor((px + reach - low_x) / spacing - 0.5) + 1, columns), c0)
        r0 = max(ceil((py - reach - low_y) / spacing - 0.5), 0)
        r1 = max(min(floor((py + reach - low_y) / spacing - 0.5) + 1, rows), r0)
        dx = low_x + (np.arange(c0, c1) + 0.5) * spacing - px
        dy = (low_y + (np.arange(r0, r1) + 0.5) * spacing - py).reshape(-1, 1)
        q = np.minimum(np.sqrt(dx * dx + dy * dy) / reach, 1.0)
        w = (1.0 + 3.0 * q) * (1.0 - q) ** 3 * cell_weight[r0:r1, c0:c1]
        total = w.sum()
        c, r = floor((px - low_x) / spacing), floor((py - low_y) / spacing)
        for k in range(len(sums)):
            if total > 0.0:
                sums[k, r0:r1, c0:c1] += w / total / area * weights[i, k]
            elif 0 <= c < columns and 0 <= r < rows:
                sums[k, r, c] += weights[i, k] / area
