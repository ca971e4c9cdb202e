# SPDX-License-Identifier: GPL-2.0-or-later
"""Floating bodies among discs: level and density of the discs beside a body, and how deep it lies.

Discs count as a fluid of their bulk density: the mass of those beside the body per area, away from bed and surface. The
level is that of the mass: from a height within the bulk, the mass above it over bulk density and width; the mean over
all such heights.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from lammps_jump.analysis.flow import Flow
from lammps_jump.dump.frame import Frame
from lammps_jump.physics.bodies import depth_of_area
from lammps_jump.scene.walls import Wall

GAP, TOP = 1.0, 2.0
"""Diameters that are left out beside the body, and below the surface and above the bed."""
NARROWEST, LOWEST = 4.0, 3.0
"""Width of a strip beside the body, and height of the bulk in it, diameters, at least."""


class Around(NamedTuple):
    """Discs beside a body: bulk density (kg/m^2), height y of their level and of the lowest point of the body (m)."""

    density: float
    level: float
    keel: float


NOTHING = Around(np.nan, np.nan, np.nan)


def around(frame: Frame, flow: Flow, wall: Wall) -> Around:
    """The discs beside a body of one frame; NaN where too few lie there."""
    outline = _outline(wall)
    if outline is None:
        return NOTHING
    (x0, y0), (x1, _) = outline.min(axis=0), outline.max(axis=0)
    d = flow.scene.diameter
    wide = max(NARROWEST * d, 0.5 * (x1 - x0))
    low, high = flow.x_range
    strips = [(max(low, x0 - GAP * d - wide), x0 - GAP * d), (x1 + GAP * d, min(high, x1 + GAP * d + wide))]
    strips = [(a, b) for a, b in strips if b - a >= NARROWEST * d]
    if not strips:
        return NOTHING
    bed = float(np.nanmax(flow.bed_height(np.array([sum(strip) / 2 for strip in strips])), initial=-np.inf))
    masses = flow.relative_masses(frame) * flow.scene.mass
    weights = sum(_bell(frame.x, *strip) for strip in strips) * masses
    width = sum(0.5 * (b - a) for a, b in strips)  # of the bells
    there = weights > 0
    y, mass = frame.y[there], weights[there]
    bottom = max(bed + TOP * d, float(y.min(initial=np.inf)))
    ceiling = (float(np.quantile(y, 0.99)) if len(y) else -np.inf) - TOP * d
    if not ceiling - bottom >= LOWEST * d:
        return NOTHING
    density = float((mass * _bell(y, bottom, ceiling)).sum() / (width * 0.5 * (ceiling - bottom)))
    if not density > 0:
        return NOTHING
    above = float((mass * np.clip((y - bottom) / (ceiling - bottom), 0.0, 1.0)).sum())
    return Around(density, 0.5 * (bottom + ceiling) + above / (density * width), float(y0))


def _bell(place: np.ndarray, low: float, high: float) -> np.ndarray:
    """Weights sin^2 between two ends, 0 outside; their mean is a half.

    Sharp ends would count a layer of discs or not: an error of up to a layer in so few.
    """
    part = (place - low) / (high - low)
    return np.where((part > 0) & (part < 1), np.sin(np.pi * part) ** 2, 0.0)


def _outline(wall: Wall) -> np.ndarray | None:
    """Corners of a body, shape (n, 2), m."""
    rings = wall.outline((-np.inf, np.inf), (-np.inf, np.inf))
    return np.asarray(rings[0]) if len(rings) == 1 else None


def draught_by_weight(wall: Wall, weight: float, pressure: float) -> float:
    """Depth of the keel below the level at which a body displaces its weight, m; NaN where it would sink.

    Parameters
    ----------
    wall : Wall
        At the turn that it has.
    weight : float
        N/m.
    pressure : float
        Bulk density times gravity, N/m^3.

    Notes
    -----
    Archimedes: the weight of the displaced fluid is that of the body.
    """
    outline = _outline(wall)
    return float("nan") if outline is None else depth_of_area(outline, weight / pressure)
