# SPDX-License-Identifier: GPL-2.0-or-later
"""A dense start of discs of several sizes: one by one, each into the lowest notch of the pile so far.

The surface of the pile is a chain of discs from the left wall to the right one. Two neighbours in it make a notch.
Where a disc in a notch would overlap another one of the chain, it rests on that one, and what is between leaves it.
"""

from __future__ import annotations

from collections.abc import Iterable
from heapq import heappop, heappush
from math import floor, hypot, sqrt

import numpy as np

from lammps_jump.scene.walls import Interval

LEFT, RIGHT = -1, -2
"""Ends of the chain: the walls."""
SLACK = 1e-9
"""Overlap that counts as touching, in radii."""
MOST_TURNS = 20
"""Pairs of the chain that are tried for a disc before it goes to another notch."""

Place = tuple[float, float]


def piled(diameters: Iterable[float], x: Interval, y: Interval, largest: float) -> np.ndarray:
    """Centres of discs that fill a rectangle from its floor, shape (n, 2), m; touching, without overlaps.

    Parameters
    ----------
    diameters : iterable of float
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
    return np.array([disc[:2] for disc in pile.discs]).reshape(-1, 2)


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
            found = self._hindrance(place, radius)
            if found is None:
                return self._insert(a, b, place, radius)
            if found >= 0 and found not in self.after:
                return False
            if found == LEFT or (found >= 0 and a != LEFT and (b == RIGHT or self.discs[found][0] < place[0])):
                a = found
            else:
                b = found
        return False

    def _between(self, a: int, b: int, radius: float) -> Place | None:
        """Centre of a disc that rests on two of the chain or touches a wall; None where they are too far apart."""
        (left, right), bottom = self.x, self.y[0]
        if a == LEFT and b == RIGHT:
            return left + radius, bottom + radius
        if a == LEFT or b == RIGHT:
            x0, y0, other = self.discs[b if a == LEFT else a]
            if b == RIGHT and y0 <= bottom + other * (1 + SLACK):
                beside = x0 + 2.0 * sqrt(radius * other)
                if beside + radius <= right + SLACK * radius:
                    return beside, bottom + radius
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
        """Put a disc there, and what stood between `a` and `b` out of the chain; False where `b` comes before `a`."""
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
            found = self._between(*pair, 0.5 * self.largest)
            if found is not None:
                heappush(self.notches, (found[1], *pair))
        return True
