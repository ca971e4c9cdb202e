# SPDX-License-Identifier: GPL-2.0-or-later
"""The jump in its own frame: profiles averaged at equal distance from the moving front, states, balances, lengths.

Symbols: c speed of the front, s mass depth, h surface depth, u mean velocity, q discharge; 1 upstream, 2 downstream.
Forces and momentum fluxes are divided by the density: m^3/s^2.
"""

# ruff: noqa: RUF001  (Greek letters, minus signs and dashes are meant for readers)
from __future__ import annotations

from dataclasses import dataclass
from math import nan, sqrt

import numpy as np

from lammps_jump.analysis.statistics import Mean, mean_of
from lammps_jump.physics import jump as theory
from lammps_jump.units import number

TOE_SHARE, END_SHARE = 0.05, 0.95
"""Toe and end of the mean profile: where these shares of the rise are reached."""
UPSTREAM_ZONE, DOWNSTREAM_ZONE = 5.0, 1.5
"""Longest stretches over which the states are averaged, in units of the depth there (four bins at least)."""
COVERED = 0.9
"""Share of the frames that must reach a place behind the jump for it to count."""


@dataclass(frozen=True)
class MovingProfile:
    """Profiles in the frame of the front.

    Attributes
    ----------
    xi : ndarray, shape (bins,), m
        Distance from the front.
    time : ndarray, shape (frames,), s
    fields : dict of ndarray, shape (frames, bins)
        Shifted profiles, NaN outside the reach.
    """

    xi: np.ndarray
    time: np.ndarray
    fields: dict[str, np.ndarray]

    def mean(self, name: str, share: float = 0.5) -> np.ndarray:
        """Mean over the frames, NaN where fewer than this share of them has a value, shape (bins,)."""
        values = self.fields[name]
        return _mean_of_known(values, axis=0, least=share * len(values))


def _mean_of_known(values: np.ndarray, axis: int, least: float = 1) -> np.ndarray:
    """Mean along an axis of what is not NaN; NaN where fewer than `least` values are known, or none."""
    good = np.isfinite(values)
    counts = good.sum(axis=axis)
    total = np.where(good, values, 0.0).sum(axis=axis)
    return np.where(counts >= max(1, least), total / np.maximum(counts, 1), np.nan)


def move_along(
    x: np.ndarray, time: np.ndarray, fields: dict[str, np.ndarray], position: np.ndarray, reach_end: np.ndarray
) -> MovingProfile:
    """Shift profiles so that the front stands at 0, linear between bins.

    Parameters
    ----------
    x : ndarray, shape (bins,), m
    time : ndarray, shape (frames,), s
    fields : dict of ndarray, shape (frames, bins)
    position, reach_end : ndarray, shape (frames,), m
        The front, and where the profile stops to count, frame by frame.
    """
    width = x[1] - x[0]
    low = np.floor((x[0] - position.max()) / width) * width
    high = np.ceil((x[-1] - position.min()) / width) * width
    xi = low + width * np.arange(round((high - low) / width) + 1)
    shifted = {}
    for name, values in fields.items():
        rows = np.full((len(time), len(xi)), np.nan)
        for k, (front, stop) in enumerate(zip(position, reach_end, strict=True)):
            good = np.isfinite(values[k]) & (x < stop)
            if good.sum() >= 2:
                rows[k] = np.interp(xi + front, x[good], values[k, good], left=np.nan, right=np.nan)
        shifted[name] = rows
    return MovingProfile(xi, time, shifted)


def crossing(xi: np.ndarray, values: np.ndarray, level: float, around: float) -> float:
    """Where values rise through a level, linear in between, nearest to `around`; NaN where they do not."""
    up = np.flatnonzero((values[:-1] < level) & (values[1:] >= level))
    if not up.size:
        return nan
    share = (level - values[up]) / (values[up + 1] - values[up])
    places = xi[up] + share * (xi[up + 1] - xi[up])
    return float(places[np.argmin(np.abs(places - around))])


@dataclass(frozen=True)
class State:
    """The flow on one side of the jump.

    Attributes
    ----------
    mass_depth, surface_depth, velocity, discharge, momentum_flux, packing, thrust : Mean
        m, m, m/s, m^2/s, m^3/s^2 (lab frame), 1, m^3/s^2 (contact force over density; NaN where not known).
    froude, froude_relative : float
        u / sqrt(g s) and (u - c) / sqrt(g s).
    zone : (float, float)
        Where it was measured, m from the front.
    """

    mass_depth: Mean
    surface_depth: Mean
    velocity: Mean
    discharge: Mean
    momentum_flux: Mean
    packing: Mean
    thrust: Mean
    froude: float
    froude_relative: float
    zone: tuple[float, float]

    @property
    def bulk_density(self) -> float:
        """Mass depth over surface depth: density of the packed discs over that of the discs' material (rho)."""
        return self.mass_depth.value / self.surface_depth.value

    def relative_flux(self, speed: float) -> float:
        """Momentum flux through a plane that moves at `speed`, m^3/s^2, velocity fluctuations included."""
        return self.momentum_flux.value - 2 * speed * self.discharge.value + speed**2 * self.mass_depth.value

    def uniform_flux(self, speed: float) -> float:
        """The same with the mean velocity everywhere: s (u - c)^2."""
        return self.mass_depth.value * (self.velocity.value - speed) ** 2

    def beta(self, speed: float) -> float:
        """Momentum coefficient in the frame that moves at `speed`: relative over uniform flux."""
        return self.relative_flux(speed) / self.uniform_flux(speed)


def measure_state(moving: MovingProfile, zone: tuple[float, float], speed: float, gravity: float) -> State:
    """Averages over a stretch of the moving frame; the velocity is discharge over mass depth."""
    inside = (moving.xi >= zone[0] - 1e-9) & (moving.xi <= zone[1] + 1e-9)

    def series(name: str) -> np.ndarray:
        return _mean_of_known(moving.fields[name][:, inside], axis=1)

    names = ("mass_depth", "surface_depth", "discharge", "momentum_flux", "packing", "thrust")
    rows = {name: series(name) if name in moving.fields else np.full(len(moving.time), nan) for name in names}
    means = {name: mean_of(values) for name, values in rows.items()}
    ratio = mean_of(rows["discharge"] / rows["mass_depth"])
    depth = means["mass_depth"].value
    velocity = Mean(means["discharge"].value / depth, ratio.error)
    wave = sqrt(gravity * depth)
    return State(velocity=velocity, froude=velocity.value / wave, froude_relative=(velocity.value - speed) / wave,
                 zone=zone, **means)  # fmt: skip


def zones(
    moving: MovingProfile, toe: float, end: float, depth_1: float, depth_2: float
) -> tuple[tuple[float, float], tuple[float, float], bool]:
    """Stretches before the toe and behind the end, and whether the second one is long enough (two bins).

    A bin is left free on both sides; where the profile ends too soon behind the jump its last two bins must do.
    """
    covered = moving.xi[np.isfinite(moving.mean("mass_depth", COVERED))]
    width = moving.xi[1] - moving.xi[0]
    first, last = covered[0], covered[-1]
    before_end = max(toe - width, first)
    before = (max(first, before_end - max(UPSTREAM_ZONE * depth_1, 4 * width)), before_end)
    behind_start = end + width
    enough = behind_start + width <= last + 1e-9
    longest = max(DOWNSTREAM_ZONE * depth_2, 4 * width)
    behind = (behind_start, min(behind_start + longest, last)) if enough else (last - width, last)
    return before, behind, enough


@dataclass(frozen=True)
class Balance:
    """Momentum across the jump in its own frame, m^3/s^2 (times the density: N/m).

    The classical balance takes uniform velocities and hydrostatic pressure of the mass depth (Bélanger); what it
    leaves is the sum of the other terms, each measured on its own, and of what remains unexplained.

    Attributes
    ----------
    upstream, downstream : float
        s (u - c)^2 + g s^2/2.
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

    upstream: float
    downstream: float
    classical: float
    profile: float
    packing: float
    pressure: float
    bed: float
    slope: float
    unsteady: float
    unexplained: float
    pressure_error: float


def balance(moving: MovingProfile, one: State, two: State, speed: float, gravity: float, along: float) -> Balance:
    """Momentum balance between the middles of the two states' zones.

    Parameters
    ----------
    moving : MovingProfile
        With ``mass_depth``, ``discharge`` and, where contacts are known, ``thrust`` and ``bed`` (force of the walls on
        the discs over the bin width and density, m^2/s^2).
    one, two : State
    speed : float
        c, m/s.
    gravity, along : float
        Across and along the bed, m/s^2.
    """

    def still(state: State, depth: float) -> float:
        return 0.5 * gravity * state.mass_depth.value * depth

    start, stop = np.mean(one.zone), np.mean(two.zone)
    upstream = one.uniform_flux(speed) + still(one, one.mass_depth.value)
    downstream = two.uniform_flux(speed) + still(two, two.mass_depth.value)
    uneven = [state.relative_flux(speed) - state.uniform_flux(speed) for state in (one, two)]
    profile = uneven[0] - uneven[1]
    high_1, high_2 = still(one, one.surface_depth.value), still(two, two.surface_depth.value)
    packing = (high_1 - still(one, one.mass_depth.value)) - (high_2 - still(two, two.mass_depth.value))
    pressure = (one.thrust.value - high_1) - (two.thrust.value - high_2)
    momentum = integral(moving, moving.fields["discharge"] - speed * moving.fields["mass_depth"], start, stop)
    unsteady = -growth_rate(moving.time, momentum)
    weight = np.nanmean(integral(moving, moving.fields["mass_depth"], start, stop))
    slope = along * float(weight)
    bed = float(np.nanmean(integral(moving, moving.fields["bed"], start, stop))) if "bed" in moving.fields else 0.0
    classical = upstream - downstream
    known = [classical, profile, packing, pressure, bed, slope, unsteady]
    error = float(np.hypot(one.thrust.error, two.thrust.error))
    unexplained = float(np.nansum(known))
    return Balance(
        upstream, downstream, classical, profile, packing, pressure, bed, slope, unsteady, unexplained, error
    )


def integral(moving: MovingProfile, values: np.ndarray, start: float, stop: float) -> np.ndarray:
    """Integral over the moving frame from start to stop, frame by frame, shape (frames,); NaN where not covered."""
    width = moving.xi[1] - moving.xi[0]
    share = np.clip((np.minimum(moving.xi + width / 2, stop) - np.maximum(moving.xi - width / 2, start)), 0.0, None)
    used = share > 0
    return (values[:, used] * share[used]).sum(axis=1)


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


def mass_balance(moving: MovingProfile, one: State, two: State, speed: float) -> Mass:
    """Mass fluxes through the moving front, their relative difference, storage in between."""
    flux_1 = one.discharge.value - speed * one.mass_depth.value
    flux_2 = two.discharge.value - speed * two.mass_depth.value
    start, stop = np.mean(one.zone), np.mean(two.zone)
    growth = growth_rate(moving.time, integral(moving, moving.fields["mass_depth"], start, stop))
    speed_from_mass = theory.shock_speed_from_mass(
        one.mass_depth.value, one.velocity.value, two.mass_depth.value, two.velocity.value
    )
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


def roller(moving: MovingProfile, speed: float, toe: float, end: float) -> Roller:
    """Extent of the reversed surface.

    The longest run of such bins from a jump's length before the toe to two behind the end.
    """
    surface = moving.mean("surface_velocity")
    width = moving.xi[1] - moving.xi[0]
    length = max(end - toe, width)
    near = (moving.xi > toe - length) & (moving.xi < end + 2 * length)
    found: dict[str, float] = {}
    for name, level in (("", 0.0), ("_in_jump_frame", speed)):
        with np.errstate(invalid="ignore"):
            run = _longest_run(near & (surface < level))
        if len(run):
            found |= {f"length{name}": float(width * len(run))}
            found |= {f"start{name}": float(moving.xi[run[0]] - width / 2 - toe)}
    shifted = moving.fields["surface_velocity"][:, near]
    good = np.isfinite(shifted)
    return Roller(**found, reversed_share=float((shifted[good] < 0).mean()) if good.any() else nan)


def _longest_run(flags: np.ndarray) -> np.ndarray:
    places = np.flatnonzero(flags)
    if not places.size:
        return places
    return max(np.split(places, np.flatnonzero(np.diff(places) > 1) + 1), key=len)
