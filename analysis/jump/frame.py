# SPDX-License-Identifier: GPL-2.0-or-later
"""The jump in its own frame: profiles averaged at equal distance from the moving front, states, balances, lengths.

Symbols: c speed of the front, s mass depth, h surface depth, u mean velocity, q discharge; 1 upstream, 2 downstream.
Forces and momentum fluxes are divided by the density: m^3/s^2.
"""

# ruff: noqa: RUF001  (Greek letters, minus signs and dashes are meant for readers)
from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from math import nan, sqrt
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from lammps_jump.analysis.statistics import Mean, as_fields, known_mean, mean_of
from lammps_jump.physics import jump as theory
from lammps_jump.physics import jump as waves
from lammps_jump.units import number

if TYPE_CHECKING:
    import xarray as xr

TOE_SHARE, END_SHARE = 0.05, 0.95
"""Toe and end of the mean profile: where these shares of the rise are reached."""
UPSTREAM_ZONE, DOWNSTREAM_ZONE = 5.0, 1.5
"""Longest stretches over which the states are averaged, in units of the depth there."""
UPSTREAM_GAP, DOWNSTREAM_GAP = 5.0, 0.25
"""Length that is left free between them and the toe or the end, in the same units: the stream slows down and thickens
over the last five depths before the toe (measured; docs/measuring.md)."""
LEAST_ZONE = 0.2
"""Shortest of these stretches, as a share of the longest; the upstream gap gives way to it."""
SMOOTHED = 0.25
"""Length over which the mean profile is smoothed before toe and end are looked for, in depths after the jump."""
COVERED = 0.9
"""Share of the frames that must reach a place downstream of the jump for it to count."""


class Moving(NamedTuple):
    """Profiles in the frame of the front, NaN outside the reach.

    They are cut and averaged many times, and xarray takes longer for that than the sums do.

    Attributes
    ----------
    time : ndarray, shape (frames,), s
    xi : ndarray, shape (bins,), m
        Distance from the front, equally spaced.
    fields : dict of str to ndarray, shape (frames, bins)
    """

    time: np.ndarray
    xi: np.ndarray
    fields: Mapping[str, np.ndarray]

    def cut(self, frames: slice) -> Moving:
        """The same of some frames."""
        return Moving(self.time[frames], self.xi, {name: values[frames] for name, values in self.fields.items()})

    def mean(self, name: str, share: float = 0.5) -> np.ndarray:
        """Mean profile of a field, NaN where fewer than this share of the frames has a value, shape (bins,)."""
        known = np.isfinite(self.fields[name])
        return np.where(known.mean(axis=0) >= share, known_mean(self.fields[name]), nan)

    def shares(self, start: float, stop: float) -> np.ndarray:
        """Length of each bin between two places, m, shape (bins,)."""
        half = 0.5 * (self.xi[1] - self.xi[0])
        return np.clip(np.minimum(self.xi + half, stop) - np.maximum(self.xi - half, start), 0.0, None)

    def smoothed(self, name: str, length: float) -> np.ndarray:
        """Mean profile of a field as if it had been averaged over this length, m; shape (bins,).

        Bins and the straight lines between them have smoothed it already: they spread a step as far as a box of
        sqrt(3) bins does. A box of the rest is laid over it, shorter at the ends of the profile.
        """
        profile, width = self.mean(name), self.xi[1] - self.xi[0]
        known = np.flatnonzero(np.isfinite(profile))
        box = np.sqrt(max(length**2 - 3 * width**2, 0.0))
        if box == 0 or not len(known):
            return profile
        edges = np.append(self.xi[known] - 0.5 * width, self.xi[known[-1]] + 0.5 * width)
        below = np.append(0.0, np.cumsum(profile[known]) * width)
        low, high = (np.clip(self.xi[known] + side * max(box, width) / 2, edges[0], edges[-1]) for side in (-1, 1))
        result = np.full_like(profile, nan)
        result[known] = (np.interp(high, edges, below) - np.interp(low, edges, below)) / (high - low)
        return result

    def integral(self, values: np.ndarray, start: float, stop: float) -> np.ndarray:
        """Integral of values between two places, m, frame by frame, shape (frames,); NaN where not covered."""
        share = self.shares(start, stop)
        return (values[:, share > 0] * share[share > 0]).sum(axis=1)

    def at(self, place: float, values: np.ndarray) -> np.ndarray:
        """Values at a place, m, linear between bins, frame by frame, shape (frames,); NaN where not covered."""
        xi = self.xi
        if not xi[0] <= place <= xi[-1]:
            return np.full(len(values), nan)
        k = max(1, int(np.searchsorted(xi, place)))
        low, high = values[:, k - 1], values[:, k]
        return low + (high - low) / (xi[k] - xi[k - 1]) * (place - xi[k - 1])


def along_stream(fields: xr.Dataset, direction: int, odd: Sequence[str]) -> xr.Dataset:
    """Fields over x as a stream towards `direction` (+1 or -1) meets them; the `odd` ones change their sign with it."""
    turned = fields.isel(x=slice(None, None, direction))
    turned = turned.assign_coords(x=direction * turned.x)
    return turned.assign(direction * turned[[name for name in odd if name in fields]])


def move_along(stream: xr.Dataset, position: np.ndarray, reach_end: np.ndarray) -> Moving:
    """Shifts profiles so that the front is at 0, linear between bins.

    Parameters
    ----------
    stream : xarray.Dataset
        Dims (time, x): s, m.
    position, reach_end : ndarray, shape (frames,), m
        The front, and where the profile stops to count, frame by frame.

    Returns
    -------
    Moving
    """
    x = stream.x.values
    width = x[1] - x[0]
    low = np.floor((x[0] - position.max()) / width) * width
    high = np.ceil((x[-1] - position.min()) / width) * width
    xi = low + width * np.arange(round((high - low) / width) + 1)

    def shifted(values: np.ndarray) -> np.ndarray:
        rows = np.full((len(values), len(xi)), np.nan)
        for row, known, front, stop in zip(rows, values, position, reach_end, strict=True):
            good = np.isfinite(known) & (x < stop)
            if good.sum() >= 2:
                row[:] = np.interp(xi + front, x[good], known[good], left=np.nan, right=np.nan)
        return rows

    return Moving(stream.time.values, xi, {str(name): shifted(values.values) for name, values in stream.items()})


def crossing(xi: np.ndarray, values: np.ndarray, level: float, around: float) -> float:
    """Place where values rise through a level, linear in between, nearest to `around`; `around` where they do not."""
    up = np.flatnonzero((values[:-1] < level) & (values[1:] >= level))
    if not up.size:
        return around
    share = (level - values[up]) / (values[up + 1] - values[up])
    places = xi[up] + share * (xi[up + 1] - xi[up])
    return float(places[np.argmin(np.abs(places - around))])


@dataclass(frozen=True)
class FlowState:
    """The flow on one side of the jump.

    Attributes
    ----------
    zone : (float, float)
        Where it was measured, m from the front.
    speed, gravity : float
        c, m/s; across the bed, m/s^2.
    velocity, mass_depth, surface_depth, discharge, momentum_flux, packing, thrust : float
        m/s, m, m, m^2/s, m^3/s^2 (lab frame), 1, m^3/s^2 (contact force over density; NaN where not known).
    thrust_error : float
        Its standard error, from the scatter between frames.
    """

    zone: tuple[float, float]
    speed: float
    gravity: float
    velocity: float
    mass_depth: float
    surface_depth: float
    discharge: float
    momentum_flux: float
    packing: float
    thrust: float
    thrust_error: float

    @property
    def middle(self) -> float:
        """Middle of the zone, m from the front."""
        return float(np.mean(self.zone))

    @property
    def froude(self) -> float:
        """Froude number in the laboratory, u / sqrt(g s)."""
        return self.velocity / sqrt(self.gravity * self.mass_depth)

    @property
    def froude_relative(self) -> float:
        """Froude number in the frame of the front, (u - c) / sqrt(g s)."""
        return waves.relative_froude(self.velocity, self.mass_depth, self.speed, self.gravity)

    @property
    def head(self) -> float:
        """Head in the frame of the front, s + (u - c)^2/(2 g), m."""
        return theory.specific_energy(self.mass_depth, self.velocity - self.speed, self.gravity)

    @property
    def bulk_density(self) -> float:
        """Mass depth over surface depth: density of the packed discs over that of the discs' material (rho)."""
        return share(self.mass_depth, self.surface_depth)

    @property
    def mass_flux(self) -> float:
        """Mass flux through the moving front, s (u - c), m^2/s."""
        return self.discharge - self.speed * self.mass_depth

    @property
    def relative_flux(self) -> float:
        """Momentum flux through a plane that moves with the front, m^3/s^2, velocity fluctuations included."""
        return self.momentum_flux - self.speed * (self.discharge + self.mass_flux)

    @property
    def uniform_flux(self) -> float:
        """The same with the mean velocity everywhere: s (u - c)^2."""
        return self.mass_depth * (self.velocity - self.speed) ** 2

    @property
    def beta(self) -> float:
        """Momentum coefficient in the frame of the front: relative over uniform flux."""
        return share(self.relative_flux, self.uniform_flux)

    def still(self, depth: float) -> float:
        """Hydrostatic force under a depth, g s depth/2, m^3/s^2."""
        return 0.5 * self.gravity * self.mass_depth * depth


def share(part: float, whole: float) -> float:
    """A ratio; NaN where the whole is nothing, as where no disc is connected to the bed."""
    return part / whole if whole else nan


def measure_state(moving: Moving, zone: tuple[float, float], speed: float, gravity: float) -> FlowState:
    """Averages over a stretch of the moving frame, m from the front; the velocity is discharge over mass depth."""
    share = moving.shares(*zone)
    chosen = np.flatnonzero(share > 0)
    weight = share[chosen]

    def inside(name: str) -> np.ndarray:
        values = moving.fields[name][:, chosen]
        known = ~np.isnan(values)
        with np.errstate(invalid="ignore"):
            return np.where(known, values, 0.0) @ weight / (known @ weight)

    names = ("mass_depth", "surface_depth", "discharge", "momentum_flux", "packing")
    means = {name: float(known_mean(inside(name))) for name in names}
    thrust = mean_of(inside("thrust")) if "thrust" in moving.fields else Mean(nan, nan)
    velocity = means["discharge"] / means["mass_depth"]
    return FlowState(zone, speed, gravity, velocity, **means, **as_fields(thrust=thrust))


def zones(
    moving: Moving, toe: float, end: float, depth_1: float, depth_2: float
) -> tuple[tuple[float, float], tuple[float, float], bool]:
    """Stretches before the toe and after the end, m from the front, and whether the second one is long enough.

    They are `UPSTREAM_ZONE` and `DOWNSTREAM_ZONE` depths long and are `UPSTREAM_GAP` and `DOWNSTREAM_GAP` depths
    off; depths are those of the two levels, m. Where the profile ends too soon after the jump, its last `LEAST_ZONE`
    of that must do.
    """
    half = 0.5 * (moving.xi[1] - moving.xi[0])
    covered = moving.xi[np.isfinite(moving.mean("mass_depth", COVERED))]
    first, last = covered[0] - half, covered[-1] + half
    longest = UPSTREAM_ZONE * depth_1
    before_end = min(max(toe - UPSTREAM_GAP * depth_1, first + LEAST_ZONE * longest), toe)
    before = (max(first, before_end - longest), before_end) if before_end > first else (first, first + half)
    longest = DOWNSTREAM_ZONE * depth_2
    behind_start = end + DOWNSTREAM_GAP * depth_2
    enough = behind_start + LEAST_ZONE * longest <= last
    behind = (behind_start, min(behind_start + longest, last)) if enough else (last - LEAST_ZONE * longest, last)
    return before, behind, enough


@dataclass(frozen=True)
class Balance:
    """Momentum across the jump in its own frame; all but the first two over the downstream momentum function.

    The classical balance takes uniform velocities and hydrostatic pressure of the mass depth (Bélanger); what it
    leaves is the sum of the other terms, each measured on its own, and of what remains unexplained.

    Attributes
    ----------
    upstream, downstream : float
        Momentum function over the density, s (u - c)^2 + g s^2/2, m^3/s^2.
    classical : float
        upstream - downstream.
    profile : float
        What uneven velocities and fluctuations add (beta), 1 minus 2.
    packing : float
        Hydrostatic force of the surface depth in place of the mass depth, g s h/2 - g s^2/2, 1 minus 2.
    pressure : float
        Contact force over the hydrostatic g s h/2, 1 minus 2 (non-hydrostatic pressure); NaN without a stiffness.
    bed, slope : float
        Force of the walls along x on the discs in between; gravity along the bed.
    unsteady : float
        Growth of the momentum between the two stations, taken off.
    unexplained : float
        Sum of all of them: 0 for a perfect balance; contains the pressure where that is not known.
    pressure_error : float
        Standard error of `pressure` from the scatter between frames.
    """

    upstream: float = field(default=nan, metadata={"summary": False})
    downstream: float = field(default=nan, metadata={"summary": False})
    classical: float = field(default=nan, metadata={"summary": False})
    profile: float = number("", "uneven velocities and their fluctuations", default=nan)
    packing: float = number("", "surface depth in place of mass depth", default=nan)
    pressure: float = number("", "contact pressure beyond hydrostatic", default=nan)
    bed: float = number("", "force of the bed", default=nan)
    slope: float = number("", "gravity along the bed", default=nan)
    unsteady: float = number("", "momentum stored between the stations", default=nan)
    unexplained: float = number("", "left unexplained", default=nan)
    pressure_error: float = number("", "standard error of the pressure's part", default=nan)
    lower_bounds: tuple[str, ...] = ("pressure",)


def balance(moving: Moving, one: FlowState, two: FlowState, along: float) -> Balance:
    """Momentum balance between the middles of the two states' zones.

    Parameters
    ----------
    moving : Moving
        With ``mass_depth``, ``discharge`` and, where contacts are known, ``thrust`` and ``bed`` (force of the walls on
        the discs over the bin width and density, m^2/s^2).
    one, two : FlowState
    along : float
        Gravity along the bed, m/s^2.
    """

    def change(part: Callable[[FlowState], float]) -> float:
        return part(one) - part(two)

    def between(values: np.ndarray) -> np.ndarray:
        return moving.integral(values, one.middle, two.middle)

    fields, depth = moving.fields, moving.fields["mass_depth"]
    upstream, downstream = (state.uniform_flux + state.still(state.mass_depth) for state in (one, two))
    momentum = between(fields["discharge"] - one.speed * depth)
    terms = {
        "classical": upstream - downstream,
        "profile": change(lambda state: state.relative_flux - state.uniform_flux),
        "packing": change(lambda state: state.still(state.surface_depth) - state.still(state.mass_depth)),
        "pressure": change(lambda state: state.thrust - state.still(state.surface_depth)),
        "bed": float(known_mean(between(fields["bed"]))) if "bed" in fields else 0.0,
        "slope": along * float(known_mean(between(depth))),
        "unsteady": -growth_rate(moving.time, momentum),
    }
    terms["unexplained"] = float(np.nansum(list(terms.values())))
    terms["pressure_error"] = float(np.hypot(one.thrust_error, two.thrust_error))
    shares: dict[str, Any] = {name: value / downstream for name, value in terms.items()}
    return Balance(upstream, downstream, **shares)


def growth_rate(time: np.ndarray, amount: np.ndarray) -> float:
    """Mean rate of change between the first and the last frame that have a value: exact for what flowed in between."""
    good = np.flatnonzero(np.isfinite(amount))
    if good.size < 2:
        return 0.0
    return float((amount[good[-1]] - amount[good[0]]) / (time[good[-1]] - time[good[0]]))


@dataclass(frozen=True)
class Mass:
    """Mass through the moving front."""

    upstream: float = number("m^2/s", "mass flux through the front upstream, s₁(u₁ − c)")
    downstream: float = number("m^2/s", "mass flux through the front downstream, s₂(u₂ − c)")
    storage: float = number("m^2/s", "growth of the mass between the stations")
    closure: float = number("", "downstream less upstream, over upstream")
    closure_with_storage: float = number("", "the same with the storage")
    speed_from_mass: float = number("m/s", "from mass, (s₂u₂ − s₁u₁)/(s₂ − s₁)")


def mass_balance(moving: Moving, one: FlowState, two: FlowState) -> Mass:
    """Mass fluxes through the moving front, their relative difference, storage in between."""
    flux_1, flux_2 = one.mass_flux, two.mass_flux
    growth = growth_rate(moving.time, moving.integral(moving.fields["mass_depth"], one.middle, two.middle))
    speed_from_mass = waves.shock_speed_from_mass(one.mass_depth, one.velocity, two.mass_depth, two.velocity)
    return Mass(
        flux_1, flux_2, growth, (flux_2 - flux_1) / flux_1, (flux_2 + growth - flux_1) / flux_1, speed_from_mass
    )


@dataclass(frozen=True)
class Roller:
    """Reversed surface: below 0 in the laboratory, below c in the front's frame; NaN where there is none."""

    length: float = number("m", "length of the reversed surface", default=nan)
    start: float = number("m", "its start behind the toe", default=nan)
    length_in_jump_frame: float = number("m", "length of the reversed surface, front's frame", default=nan)
    start_in_jump_frame: float = number("m", "its start behind the toe, front's frame", default=nan)
    reversed_share: float = number("", "share of frames and bins with a reversed surface", default=nan)


def roller(moving: Moving, speed: float, toe: float, end: float) -> Roller:
    """Extent of the reversed surface.

    The longest run of such bins from a jump's length before the toe to two after the end.
    """
    xi, surface = moving.xi, moving.mean("surface_velocity")
    width = xi[1] - xi[0]
    length = max(end - toe, width)
    near = (xi > toe - length) & (xi < end + 2 * length)
    parts_of_roller: dict[str, float] = {}
    for name, level in (("", 0.0), ("_in_jump_frame", speed)):
        run = _longest_run(near & (surface < level))
        if len(run):
            parts_of_roller |= {
                f"length{name}": float(width * len(run)),
                f"start{name}": float(xi[run[0]] - width / 2 - toe),
            }
    known = moving.fields["surface_velocity"][:, near]
    known = known[np.isfinite(known)]
    return Roller(**parts_of_roller, reversed_share=float((known < 0).mean()) if known.size else nan)


def _longest_run(flags: np.ndarray) -> np.ndarray:
    places = np.flatnonzero(flags)
    if not places.size:
        return places
    return max(np.split(places, np.flatnonzero(np.diff(places) > 1) + 1), key=len)
