# SPDX-License-Identifier: GPL-2.0-or-later
"""Stability of a structure on a plane base: sliding, tipping about both ends of the base, pressure below it.

The checks of a gravity structure, per metre of width: Y. Goda, "Random Seas and Design of Maritime Structures" (2010),
section 4.3. t is the unit vector along the base from its left to its right end, n = (-t_y, t_x) points up from it, and
the force Q is that of the discs and the weight together.
"""

from __future__ import annotations

import numpy as np


def along_and_up(force: np.ndarray, along: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Parts of forces along a base and up from it, N/m, shape (n,): Q t and Q n.

    Parameters
    ----------
    force : ndarray, shape (n, 2), N/m
    along : ndarray, shape (n, 2)
        Unit vectors along the base.
    """
    return np.sum(force * along, axis=1), force[:, 1] * along[:, 0] - force[:, 0] * along[:, 1]


def sliding_limit(friction: float, pressed: np.ndarray) -> np.ndarray:
    """Largest force along the base that its friction bears, N/m: mu N, and 0 where nothing presses (Coulomb).

    Parameters
    ----------
    friction : float
        Coefficient of friction of the base.
    pressed : ndarray, N/m
        Force down on the base: the part of the weight across it, less the uplift.
    """
    return friction * np.maximum(pressed, 0.0)


def moment_about(moment: np.ndarray, arm: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Moment about another point, anticlockwise, N m/m: M + (r - r') x F.

    Parameters
    ----------
    moment : ndarray, shape (n,), N m/m
        About the first point r.
    arm : ndarray, shape (n, 2), m
        r - r'.
    force : ndarray, shape (n, 2), N/m
    """
    return moment + arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0]


def factor(bears: np.ndarray, drives: np.ndarray) -> np.ndarray:
    """Factor of safety: what is borne over what drives; infinite where nothing drives.

    Parameters
    ----------
    bears, drives : ndarray of one shape and unit
    """
    pushed = drives > 0
    return np.where(pushed, bears / np.where(pushed, drives, 1.0), np.inf)


def eccentricity(moment: np.ndarray, pressed: np.ndarray) -> np.ndarray:
    """Distance from the middle of a base to where the force goes through it, m, towards its right end: -M/N.

    NaN where nothing presses.

    Parameters
    ----------
    moment : ndarray, N m/m
        Of all forces about the middle, anticlockwise.
    pressed : ndarray, N/m
    """
    presses = pressed > 0
    return np.where(presses, -moment / np.where(presses, pressed, 1.0), np.nan)


def bearing_pressures(pressed: np.ndarray, off: np.ndarray, base: float) -> tuple[np.ndarray, np.ndarray]:
    """Pressure at the end that the force leans to, and at the other one, Pa: straight between them.

    ``N/b (1 +- 6 e/b)`` where the force is in the middle third. Beyond it the base gapes, as it bears no tension:
    ``2 N/(3 (b/2 - e))`` and 0. NaN where the force is outside the base: nothing balances it.

    Parameters
    ----------
    pressed : ndarray, N/m
    off : ndarray, m
        `eccentricity`.
    base : float
        Width of the base, m.
    """
    e = np.abs(off)
    inside, third = e < 0.5 * base, e <= base / 6.0
    left = np.where(inside, 0.5 * base - e, 1.0)
    toe = np.where(third, pressed / base * (1.0 + 6.0 * e / base), 2.0 * pressed / (3.0 * left))
    heel = np.where(third, pressed / base * (1.0 - 6.0 * e / base), 0.0)
    return np.where(inside, toe, np.nan), np.where(inside, heel, np.nan)
