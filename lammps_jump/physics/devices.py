# SPDX-License-Identifier: GPL-2.0-or-later
"""Waves of a paddle, discs through a slot, a drum that turns, a column that falls, a tailgate that holds a flow.

Pure functions, one equation each; SI, per metre of width.
"""

from __future__ import annotations

from math import cosh, nan, pi, radians, sin, sinh, sqrt, tanh
from typing import NamedTuple

import numpy as np

BEVERLOO_K = 1.4
"""Diameters by which a slot is narrower for discs than it is (Beverloo, Leniger & van de Velde 1961)."""
BEVERLOO_FROM = 6.0
"""Narrowest slot in diameters for which the law is used: below it discs form arches that stop the flow
(Mankoc et al. 2007, arXiv 0707.4550; validation/silo)."""


def wave_number(period: float, depth: float, gravity: float) -> float:
    """Wave number k of small waves, 1/m: w^2 = g k tanh(k h), w = 2 pi / period (Airy), by Newton's method."""
    w2 = (2.0 * pi / period) ** 2
    k = max(w2 / gravity, sqrt(w2 / (gravity * depth)))
    for _ in range(50):
        t = tanh(k * depth)
        off = gravity * k * t - w2
        k -= off / (gravity * (t + k * depth * (1.0 - t * t)))
    return k


def piston_wave_height(stroke: float, period: float, depth: float, gravity: float) -> float:
    """Height of the small waves of a piston paddle, m: S 2 (cosh 2kh - 1) / (sinh 2kh + 2kh); S its whole stroke, m.

    Ursell, Dean & Yu 1960, J. Fluid Mech. 7:33.
    """
    twice = 2.0 * wave_number(period, depth, gravity) * depth
    if twice > 100.0:
        return 2.0 * stroke
    return stroke * 2.0 * (cosh(twice) - 1.0) / (sinh(twice) + twice)


def beverloo_number(discharge: float, slot: float, diameter: float, density: float, gravity: float) -> float:
    """Discharge W (kg/s per m) through a slot D (m) over density sqrt(g) (D - k d)^1.5, k = `BEVERLOO_K`.

    The law of Beverloo, Leniger & van de Velde 1961 in two dimensions says that it does not depend on the slot.
    """
    return discharge / (density * sqrt(gravity) * (slot - BEVERLOO_K * diameter) ** 1.5)


def rotation_froude(rate: float, radius: float, gravity: float) -> float:
    """Froude number of a drum, w^2 R / g; rate w in rad/s. Discs roll down steadily from about 1e-4 to 1e-1."""
    return rate * rate * radius / gravity


def run_out_of_sand(aspect: float) -> float:
    """Run-out of a column of sand over its base, (L - L0)/L0: 1.2 a up to a = H0/L0 = 2.3, 1.9 a^(2/3) from 2.8 on.

    Lube, Huppert, Sparks & Freundt 2005, experiments in a channel, as quoted by Staron & Hinch (physics/0501022). NaN
    between the two.
    """
    if aspect < 2.3:
        return 1.2 * aspect
    return 1.9 * aspect ** (2.0 / 3.0) if aspect > 2.8 else nan


def run_out_of_discs(aspect: float) -> float:
    """Run-out of a low column of discs over its base: 2.5 a; NaN from a = 2 on.

    Staron & Hinch 2005, J. Fluid Mech. 545:1, contact dynamics in two dimensions, as quoted by others.
    """
    return 2.5 * aspect if aspect < 2.0 else nan


def run_out_of_rods(aspect: float) -> float:
    """Run-out of a column of aluminium rods over its base: 3.25 a^0.96 for 0.65 < a < 1.5, 3.80 a^0.73 above.

    "Failure mechanism of true 2D granular flows", arXiv 1512.05180; NaN below.
    """
    if aspect <= 0.65:
        return nan
    return 3.25 * aspect**0.96 if aspect < 1.5 else 3.80 * aspect**0.73


def height_of_rods(aspect: float) -> float:
    """Height of such rods at rest over the base of their column: H0/h = 1.42 a^(2/3), h = H0 below a = 0.65.

    The same source.
    """
    return aspect if aspect < 0.65 else aspect / (1.42 * aspect ** (2.0 / 3.0))


def creep_speed(gravity: float, slope: float, damping: float) -> float:
    """Speed at which a contact without a tangential spring creeps down a slope, m/s: g sin(theta) / gamma_t.

    Weight along the slope (degrees) in balance with the dashpot gamma_t (1/s) below sliding.
    """
    return gravity * sin(radians(slope)) / damping if damping > 0 else nan


# --- a tailgate that holds a depth or a front -------------------------------------------------------------------------

GATE_LOOKS = 20
"""Looks of a gate in its response."""
COMING_UP = 0.75
"""Share of a travel there and back in which a wave comes up against the stream: 0.65 after jumps of Froude numbers
from 3 to 9, and some more. With half of it gates in discs swing by 0.2 m in place of 0.1 m (measured)."""
RESET = 2.0
"""Time in which a gate makes up what a front is off, over t of `gate_gains`; the rule has 4. Of a jet of Froude number
5.1 the front was 0.2 m off at 80 s with 4, from either side; with 2 it is back at 21 s, and crests swing alike."""


class Holding(NamedTuple):
    """Quantity that a tailgate measures and its answer, as engines take it.

    Attributes
    ----------
    low, high : float
        Stretch of the channel whose discs are summed, m.
    bins : int
        Equal parts of it.
    target : float
        Mass depth of the stretch, or place of the front, m.
    level : float
        Mass depth at the front, m; 0 where a depth is held.
    proportional : float
        Speed of the gate over the loss of area in a second, 1/m.
    integral : float
        Speed of the gate over the difference from the target, 1/s.
    speed : float
        Largest speed of the gate, m/s.
    lowest, highest : float
        Ends of its way, from where the case has it, m.
    first, every : int
        Steps at which it looks: the first one, and how many lie between two.
    """

    low: float
    high: float
    bins: int
    target: float
    level: float
    proportional: float
    integral: float
    speed: float
    lowest: float
    highest: float
    first: int
    every: int


def gate_gains(response: float, travel: float, length: float, rise: float = 0.0) -> tuple[float, float]:
    """Gains of a gate, proportional (1/m) and integral (1/s), by a response and the travel of a wave, s.

    Depth at a place answers the gate after a travel: the gate moves at (target - depth) / response. A front goes on
    moving while the gate is misplaced, so that this alone would swing ever wider. It also needs the change of the area
    A of the stream before the gate, which answers at once, nearly as A' = (L/T) (z - z of rest). By the rule for such a
    process (Skogestad 2003, J. Process Control 13:291) z' = (T/t) ((front - target) rise/(i t) - A'/L), where t is at
    least the time in which a wave comes up: `COMING_UP` of tau; i is `RESET`.

    Parameters
    ----------
    response, travel : float
        tau and T, s.
    length : float
        L from the front to the gate, m.
    rise : float
        Change of the area a metre that the front moves, over L; 0 where a depth is held.
    """
    if not rise:
        return 0.0, 1.0 / response
    slow = COMING_UP * response
    return travel / slow / length, travel * rise / (RESET * slow**2)


def gate_sees(holding: Holding, areas: np.ndarray) -> tuple[float, float]:
    """Quantity that a gate holds, m, and the area of its stretch, m^2.

    It is the mean mass depth, or the place at which the depth first comes to the level along x: straight between the
    middles of parts, `low` where all is deeper, `high` where nothing is.

    Parameters
    ----------
    areas : ndarray, shape (bins,), m^2
        Mass over density of the discs in each part.
    """
    width = (holding.high - holding.low) / holding.bins
    total = float(np.cumsum(areas)[-1])  # one after the other, as the core sums
    if not holding.level:
        return total / (width * holding.bins), total
    before = 0.0
    for part, area in enumerate(areas.tolist()):
        depth = area / width
        if depth >= holding.level:
            if part == 0:
                return holding.low, total
            share = (holding.level - before) / (depth - before)
            return holding.low + width * (part - 0.5 + share), total
        before = depth
    return holding.high, total


def gate_speed(holding: Holding, place: float, seen: float, lost: float, interval: float) -> float:
    """Speed of a gate up to its next look, m/s: no faster than it can be, and not beyond its way.

    Its place is the only sum that it keeps, so that nothing winds up while it is at an end or moves at its fastest.

    Parameters
    ----------
    place : float
        Displacement of the gate, m.
    seen : float
        What it holds, m.
    lost : float
        Loss of area since the last look, over the time since, m^2/s.
    interval : float
        Time up to the next look, s.
    """
    off = seen - holding.target if holding.level else holding.target - seen
    wanted = holding.integral * off + holding.proportional * lost
    wanted = min(max(wanted, -holding.speed), holding.speed)
    return min(max(wanted, (holding.lowest - place) / interval), (holding.highest - place) / interval)


def gate_areas(holding: Holding, x: np.ndarray, area: np.ndarray) -> np.ndarray:
    """Sum of the areas (m^2) of discs at places x (m) in each part of a stretch, shape (bins,)."""
    scale = holding.bins / (holding.high - holding.low)
    part = np.floor((x - holding.low) * scale)
    inside = (part >= 0) & (part < holding.bins)
    return np.bincount(part[inside].astype(np.int64), area[inside], holding.bins)


def wave_travel(length: float, depth: float, speed: float, gravity: float) -> float:
    """Time of a long wave over a length and back, s, in a stream: L/(c - u) + L/(c + u), c = sqrt(g h).

    Of a stream that lets no wave come up, twice the way at c.
    """
    c = sqrt(gravity * depth)
    return 2.0 * length * c / (c * c - speed * speed) if abs(speed) < c else 2.0 * length / c
