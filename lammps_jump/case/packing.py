# SPDX-License-Identifier: GPL-2.0-or-later
"""Discs at the start: columns with hydrostatic overlaps, lattices, lists; and the deepest overlap."""

from __future__ import annotations

from functools import lru_cache
from heapq import heappop, heappush
from math import floor, hypot, pi, sqrt

import numpy as np

from lammps_jump.physics.contact import Coefficients
from lammps_jump.scene import Interval, Sizes

from .base import EarlierRun
from .beds import bed_diameters, bed_positions
from .discs import BidisperseSizes, Column, DiscList, Discs, GradingCurve, Lattice, PackedBed, UniformSizes
from .fields import CaseFields


class TooSoft(ValueError):
    """Contacts that do not bear a column; the caller knows what makes them stiffer.

    Attributes
    ----------
    factor : float
        The largest overlap over a tenth of a diameter.
    """

    factor: float = 1.0


def disc_sizes(case: CaseFields) -> Sizes | None:
    """Distribution of diameters; None where all discs are equal."""
    d, given = case.discs.diameter, case.discs.sizes
    shares: tuple[float, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]
    if given is None:
        return None
    if isinstance(given, GradingCurve):
        shares, low, high = (tuple(one.tolist()) for one in given.pieces)
    elif isinstance(given, UniformSizes | BidisperseSizes):
        small, large = d * (1 - given.spread), d * (1 + given.spread)
        if isinstance(given, UniformSizes):
            shares, low, high = (1.0,), (small,), (large,)
        else:
            shares, low, high = (1.0 - given.share, given.share), (small, large), (small, large)
    else:
        total = sum(given.shares)
        shares, low, high = tuple(share / total for share in given.shares), given.diameters, given.diameters
    sizes = Sizes(shares, low, high, case.run.seed)
    return None if sizes.smallest == sizes.largest == d else sizes


def column_counts(column: Column, diameter: float) -> tuple[int, int]:
    """Discs along x and y of a column that fit its rectangle (touching)."""
    slack = 1e-9
    width = (column.x[1] - column.x[0]) / diameter
    height = (column.y[1] - column.y[0]) / diameter
    if column.packing == "hexagonal":
        rows = int((height - 1.0) / (np.sqrt(3.0) / 2.0) + slack) + 1 if height >= 1 - slack else 0
        return int(width - 0.5 + slack), rows
    return int(width + slack), int(height + slack)


def disc_count(
    item: Column | Lattice | DiscList | PackedBed | EarlierRun, diameter: float, sizes: Sizes | None = None
) -> int:
    """Discs of one item of ``initial``, before any array of them is made; an estimate for those with sizes."""
    if isinstance(item, Column):
        if sizes:
            return int((item.x[1] - item.x[0]) * (item.y[1] - item.y[0]) / sizes.mean_square)
        nx, ny = column_counts(item, diameter)
        return nx * ny
    if isinstance(item, PackedBed):
        return round(item.packing * item.area / (pi / 4 * (sizes.mean_square if sizes else diameter**2)))
    if isinstance(item, EarlierRun):
        return item.found.count
    return item.nx * item.ny if isinstance(item, Lattice) else len(item.positions)


def discs_at_start(case: CaseFields, sizes: Sizes | None) -> int:
    """Discs that a case begins with, before any array of them is made; an estimate where columns have sizes."""
    return sum(disc_count(item, case.discs.diameter, sizes) for item in case.initial)


def column_positions(column: Column, discs: Discs, gravity: float, contact: Coefficients) -> np.ndarray:
    """Centres of a column, shape (n, 2), row by row from the bottom.

    With `hydrostatic` and square packing the overlaps of thesis figure 6.2 carry the weight from the first step:
    vertically (discs above) m g / k, horizontally rho g ((n-1) d + d/2) d / k in the n-th row from the top. Against
    floor and back wall they follow from the stiffness of walls. Without overlaps and jitter a square lattice of
    touching frictionless discs never collapses.
    """
    d, radius = discs.diameter, discs.diameter / 2
    nx, ny = column_counts(column, d)
    x0, y0 = column.x[0], column.y[0]
    if column.packing == "hexagonal":
        i, j = np.meshgrid(np.arange(nx), np.arange(ny))
        x = x0 + radius + d * i + radius * (j % 2)
        y = y0 + radius + d * np.sqrt(3.0) / 2.0 * j
        return np.column_stack([x.ravel(), y.ravel()])
    above = ny - 1 - np.arange(ny)  # discs on top of each row
    weight = contact.mass * gravity if column.hydrostatic else 0.0
    vertical = above * weight / contact.stiffness
    bottom = y0 + radius - ny * weight / contact.stiffness_wall
    y_rows = bottom + np.concatenate([[0.0], np.cumsum(d - vertical[:-1])])
    pressure = discs.density * gravity * (above * d + radius) if column.hydrostatic else 0.0 * above
    deepest = max(vertical.max(initial=0.0), pressure.max(initial=0.0) * d / contact.stiffness)
    if deepest > radius:
        error = TooSoft(
            f"its own weight would press the discs {deepest:z.3g} m into each other; allowed is a radius, {radius:zg} m"
        )
        error.factor = 10.0 * deepest / d
        raise error
    x_rows = []
    for thrust in pressure * d:
        first = x0 + radius - thrust / contact.stiffness_wall
        x_rows.append(first + np.arange(nx) * (d - thrust / contact.stiffness))
    return np.column_stack([np.concatenate(x_rows), np.repeat(y_rows, nx)])


def pile(column: Column, sizes: Sizes, first: int) -> np.ndarray:
    """Centres of a column of discs of several sizes, shape (n, 2): `piled`, from the id `first` on.

    The discs touch. They do not overlap as far as their weight would press them; that needs time behind the gate.
    """
    if column.packing == "hexagonal":
        raise ValueError(
            "packing: hexagonal is for equal discs; discs of several sizes are packed one by one: drop packing, or "
            "discs.sizes"
        )
    most = 2 * disc_count(column, 0.0, sizes) + 1
    diameters = tuple(sizes.diameters(np.arange(first, first + most)).tolist())
    return piled(diameters, column.x, column.y, sizes.largest)


def arrange(
    item: Column | Lattice | DiscList | PackedBed,
    discs: Discs,
    gravity: float,
    contact: Coefficients,
    random: np.random.Generator,
    sizes: Sizes | None = None,
    first: int = 1,
    seed: int = 1,
) -> tuple[np.ndarray, np.ndarray]:
    """Positions and velocities, each of shape (n, 2), of one item of ``initial``, whose ids begin at `first`.

    Raises
    ------
    ValueError
        Where nothing fits or the velocities do not belong to the discs (the caller adds the place).
    """
    if isinstance(item, PackedBed):
        diameters = bed_diameters(item, discs.diameter, sizes, first)
        positions = bed_positions(item, diameters, seed if item.seed is None else item.seed)
        velocities = np.zeros_like(positions)
        random.uniform(size=positions.shape)  # of one seed, the bed began with these: shifts by them would widen it
    elif isinstance(item, Column):
        positions = pile(item, sizes, first) if sizes else column_positions(item, discs, gravity, contact)
        if not len(positions):
            raise ValueError(
                f"not one disc of {discs.diameter:zg} m fits into x [{item.x[0]:zg}, {item.x[1]:zg}], "
                f"y [{item.y[0]:zg}, {item.y[1]:zg}]; make the column wider or higher than one diameter, or "
                'take smaller discs (numbers are in m; text may have a unit, "100 mm")'
            )
        velocities = np.tile(np.array(item.velocity, float), (len(positions), 1))
    elif isinstance(item, Lattice):
        i, j = np.meshgrid(np.arange(item.nx), np.arange(item.ny))
        positions = np.column_stack([i.ravel(), j.ravel()]) * item.spacing + np.array(item.origin)
        velocities = np.tile(np.array(item.velocity, float), (len(positions), 1))
        for number, velocity in item.velocities.items():
            if not 1 <= number <= len(positions):
                raise ValueError(f"velocities names disc {number}; there are discs 1 to {len(positions)}")
            velocities[number - 1] = velocity
    else:
        positions = np.array(item.positions, float).reshape(-1, 2)
        if item.velocities and len(item.velocities) != len(positions):
            raise ValueError(
                f"{len(item.velocities)} velocities for {len(positions)} positions; give one for each, or none"
            )
        velocities = np.array(item.velocities, float) if item.velocities else np.zeros_like(positions)
    if item.jitter:
        positions = positions + random.uniform(-item.jitter, item.jitter, positions.shape) * discs.diameter
    return positions, velocities


def deepest_overlap(positions: np.ndarray, diameters: np.ndarray) -> tuple[float, int, int] | None:
    """The two of `positions` (n, 2) that overlap most: (overlap, i, j), or None where none do.

    Discs are sorted by cells of the largest diameter. Each is compared with its own cell and four of the eight around.
    The search ends at an overlap of nine tenths of the smallest: thousands of discs in one cell would take too long.
    """
    if len(positions) < 2:
        return None
    reach, enough = diameters.max(), 0.9 * diameters.min()
    cells = np.floor((positions - positions.min(axis=0)) / reach).astype(np.int64)
    stride = cells[:, 1].max() + 3
    keys = (cells[:, 0] + 1) * stride + cells[:, 1] + 1
    order = np.argsort(keys, kind="stable")
    keys, points, radii = keys[order], positions[order], 0.5 * diameters[order]
    best: tuple[float, int, int] | None = None
    for shift in (0, 1, stride - 1, stride, stride + 1):
        start = np.searchsorted(keys, keys + shift, "left")
        stop = np.searchsorted(keys, keys + shift, "right")
        if shift == 0:
            start = np.arange(len(keys)) + 1
        for offset in range(int(np.max(stop - start, initial=0))):
            mine = np.flatnonzero(start + offset < stop)
            other = start[mine] + offset
            overlap = radii[mine] + radii[other] - np.hypot(*(points[mine] - points[other]).T)
            worst = int(np.argmax(overlap))
            if overlap[worst] > (best[0] if best else 0.0):
                best = (float(overlap[worst]), int(order[mine[worst]]), int(order[other[worst]]))
                if best[0] > enough:
                    return best
    return best


# --- discs of several sizes: one by one, each into the lowest notch of the pile so far -------------------------------
#
# The surface of the pile is a chain of discs from the left wall to the right one. Two neighbours in it make a notch.
# Where a disc in a notch would overlap another one of the chain, it rests on that one, and what is between leaves it.

LEFT, RIGHT = -1, -2
"""Ends of the chain: the walls."""
SLACK = 1e-9
"""Overlap that counts as touching, in radii."""
MOST_TURNS = 20
"""Pairs of the chain that are tried for a disc before it goes to another notch."""

Place = tuple[float, float]


@lru_cache(maxsize=8)  # of a case that changes most piles stay, and one of 4000 discs takes 0.1 s
def piled(diameters: tuple[float, ...], x: Interval, y: Interval, largest: float) -> np.ndarray:
    """Centres of discs that fill a rectangle from its floor, shape (n, 2), m; touching, without overlaps; read-only.

    Parameters
    ----------
    diameters : tuple of float
        m, in the order of the discs. The pile ends with the first disc for which there is no place.
    x, y : (float, float)
        The rectangle, m.
    largest : float
        Largest diameter of all, m. Heights of notches are those of a disc so large.
    """
    pile = _Pile(x, y, largest)
    for diameter in diameters:
        if not pile.add(0.5 * diameter):
            break
    placed = np.array([disc[:2] for disc in pile.discs]).reshape(-1, 2)
    placed.setflags(write=False)
    return placed


class _Pile:
    def __init__(self, x: Interval, y: Interval, largest: float) -> None:
        self.x, self.y, self.largest = x, y, largest
        self.discs: list[tuple[float, float, float]] = []
        self.cells: dict[tuple[int, int], list[int]] = {}
        self.after = {LEFT: RIGHT}
        self.notches = [(0.0, LEFT, RIGHT)]

    def add(self, radius: float) -> bool:
        """Put a disc into the lowest notch with a place for it; False where there is none."""
        refused = []
        done = False
        while self.notches and not done:
            notch = heappop(self.notches)
            if self.after.get(notch[1]) == notch[2]:  # else the notch has been filled
                done = self._fill(notch[1], notch[2], radius)
                if not done:
                    refused.append(notch)
        for notch in refused:
            heappush(self.notches, notch)
        return done

    def _fill(self, a: int, b: int, radius: float) -> bool:
        """Put a disc between `a` and `b` of the chain, or on others where it would overlap them."""
        for _ in range(MOST_TURNS):
            place = self._between(a, b, radius)
            if place is None:
                return False
            low, high = place[1] - radius * (1 - SLACK), place[1] + radius * (1 - SLACK)
            if low < self.y[0] or high > self.y[1]:
                return False
            obstacle = self._hindrance(place, radius)
            if obstacle is None:
                return self._insert(a, b, place, radius)
            if obstacle >= 0 and obstacle not in self.after:
                return False
            if obstacle == LEFT or (obstacle >= 0 and a != LEFT and (b == RIGHT or self.discs[obstacle][0] < place[0])):
                a = obstacle
            else:
                b = obstacle
        return False

    def _between(self, a: int, b: int, radius: float) -> Place | None:
        """Centre of a disc that rests on two of the chain or touches a wall; None where they are too far apart."""
        (left, right), bottom = self.x, self.y[0]
        if a == LEFT and b == RIGHT:
            return left + radius, bottom + radius
        if a == LEFT or b == RIGHT:
            x0, y0, other = self.discs[b if a == LEFT else a]
            if b == RIGHT and y0 <= bottom + other * (1 + SLACK):
                x_between = x0 + 2.0 * sqrt(radius * other)
                if x_between + radius <= right + SLACK * radius:
                    return x_between, bottom + radius
            x = left + radius if a == LEFT else right - radius
            rise = (radius + other) ** 2 - (x - x0) ** 2
            return (x, y0 + sqrt(rise)) if rise >= 0 else None
        xa, ya, ra = self.discs[a]
        xb, yb, rb = self.discs[b]
        dx, dy = xb - xa, yb - ya
        apart = dx * dx + dy * dy
        along = (apart + (ra + radius) ** 2 - (rb + radius) ** 2) / (2.0 * apart)
        rise = (ra + radius) ** 2 / apart - along * along
        if rise < 0:
            return None
        up = sqrt(rise)
        return xa + along * dx - up * dy, ya + along * dy + up * dx

    def _hindrance(self, place: Place, radius: float) -> int | None:
        """A wall or a disc that overlaps one at this place; None if there is none."""
        x, y = place
        if x < self.x[0] + radius * (1 - SLACK):
            return LEFT
        if x > self.x[1] - radius * (1 - SLACK):
            return RIGHT
        column, row = self._cell(place)
        for i in (column - 1, column, column + 1):
            for j in (row - 1, row, row + 1):
                for k in self.cells.get((i, j), ()):
                    xk, yk, rk = self.discs[k]
                    if hypot(x - xk, y - yk) < radius + rk - SLACK * radius:
                        return k
        return None

    def _cell(self, place: Place) -> tuple[int, int]:
        return floor(place[0] / self.largest), floor(place[1] / self.largest)

    def _insert(self, a: int, b: int, place: Place, radius: float) -> bool:
        """Puts a disc there, and what was between `a` and `b` out of the chain; False where `b` comes before `a`."""
        leave = []
        at = self.after.get(a, RIGHT)
        while at not in (b, RIGHT):
            leave.append(at)
            at = self.after[at]
        if at != b:
            return False
        for gone in leave:
            del self.after[gone]
        new = len(self.discs)
        self.discs.append((*place, radius))
        self.cells.setdefault(self._cell(place), []).append(new)
        self.after[a], self.after[new] = new, b
        for pair in ((a, new), (new, b)):
            notch = self._between(*pair, 0.5 * self.largest)
            if notch is not None:
                heappush(self.notches, (notch[1], *pair))
        return True
