"""Sums over the contacts of a frame: elastic energy, the force the discs pass on along x, the forces of walls.

The kernel is a plain loop over a cell grid, jitted at the end of the file; everything per metre of width.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

from lammps_jump.walls import Block, Wall

from .context import FlowContext
from .dump import Frame


def _pair_sums_py(x, y, vx, vy, diameter, stiffness, dashpot, width, low, bin_width, pressure):
    """Elastic energy of all overlapping pairs; their thrust along x is added to `pressure`.

    width is the soft start of a smooth touch (0: sharp): U = k delta^3/(6 s) below s, k (delta^2/2 - s delta/2 +
    s^2/6) above. pressure[b] gains the mean over the planes x = const of bin b of the force that the discs left
    of the plane exert on those right of it: each contact acts along the line of centres, so it counts with the
    share of its x-extent that lies in the bin over the bin's width (method of planes, averaged).
    """
    n = x.size
    energy = 0.0
    contacts = 0
    if n < 2:
        return energy, contacts
    bins = pressure.size
    xmin, xmax, ymin, ymax = x.min(), x.max(), y.min(), y.max()
    cell = diameter
    # sparse spray over a large box must not cost memory: at most about 8 cells a disc
    wanted = np.sqrt((xmax - xmin + cell) * (ymax - ymin + cell) / (8.0 * n + 64.0))
    if wanted > cell:
        cell = wanted
    columns = int((xmax - xmin) / cell) + 1
    rows = int((ymax - ymin) / cell) + 1
    start = np.zeros(columns * rows + 1, np.int64)
    home = np.empty(n, np.int64)
    for i in range(n):
        home[i] = int((x[i] - xmin) / cell) * rows + int((y[i] - ymin) / cell)
        start[home[i] + 1] += 1
    for c in range(columns * rows):
        start[c + 1] += start[c]
    fill = start[:-1].copy()
    order = np.empty(n, np.int64)
    for i in range(n):
        order[fill[home[i]]] = i
        fill[home[i]] += 1
    for cx in range(columns):
        for cy in range(rows):
            c = cx * rows + cy
            for a in range(start[c], start[c + 1]):
                i = order[a]
                for neighbour in range(5):  # itself and half of the eight around it: each pair once
                    ox = 0 if neighbour < 2 else 1
                    oy = (0, 1, -1, 0, 1)[neighbour]
                    if cx + ox >= columns or cy + oy < 0 or cy + oy >= rows:
                        continue
                    other = (cx + ox) * rows + cy + oy
                    first = a + 1 if neighbour == 0 else start[other]
                    for b in range(first, start[other + 1]):
                        j = order[b]
                        dx, dy = x[j] - x[i], y[j] - y[i]
                        square = dx * dx + dy * dy
                        if square >= diameter * diameter or square == 0.0:
                            continue
                        distance = np.sqrt(square)
                        overlap = diameter - distance
                        contacts += 1
                        soft = 1.0
                        if width > 0.0 and overlap < width:
                            soft = overlap / width
                            energy += stiffness * overlap**3 / (6.0 * width)
                            force = 0.5 * stiffness * overlap * soft
                        else:
                            energy += stiffness * (0.5 * overlap**2 - 0.5 * width * overlap + width**2 / 6.0)
                            force = stiffness * (overlap - 0.5 * width)
                        if bins == 0:
                            continue
                        approach = -((vx[j] - vx[i]) * dx + (vy[j] - vy[i]) * dy) / distance
                        force += soft * dashpot * approach
                        push = force * abs(dx) / distance
                        left = min(x[i], x[j])
                        right = max(x[i], x[j])
                        p = max(int(np.floor((left - low) / bin_width)), 0)
                        while p < bins and low + p * bin_width < right:
                            inside = min(right, low + (p + 1) * bin_width) - max(left, low + p * bin_width)
                            if inside > 0.0:
                                pressure[p] += push * inside / bin_width
                            p += 1
    return energy, contacts


_pair_sums = njit(cache=True)(_pair_sums_py)


@dataclass(frozen=True)
class PairSums:
    """Sums over the pairs of a frame.

    Attributes
    ----------
    energy : float
        Elastic energy, J/m.
    contacts : int
    thrust : ndarray, shape (bins,)
        Force passed on through vertical planes, averaged over each bin, N/m; positive in compression. The pull of
        dashpots that part counts as negative, as in the engines.
    """

    energy: float
    contacts: int
    thrust: np.ndarray


def pair_sums(frame: Frame, context: FlowContext, edges: np.ndarray | None = None) -> PairSums:
    """Elastic energy and thrust of the disc-disc contacts of a frame.

    Parameters
    ----------
    frame : Frame
        With x, y, and vx, vy where `edges` are given.
    context : FlowContext
        With a stiffness.
    edges : ndarray, shape (bins + 1,), optional
        Bins of equal width for the thrust, m.

    Returns
    -------
    PairSums
    """
    x, y = (np.ascontiguousarray(values, float) for values in (frame.x, frame.y))
    thrust = np.zeros(0 if edges is None else len(edges) - 1)
    vx, vy = (x, y) if edges is None else (np.ascontiguousarray(v, float) for v in (frame.vx, frame.vy))
    low, step = (0.0, 1.0) if edges is None else (float(edges[0]), float(edges[-1] - edges[0]) / len(thrust))
    width = context.touch_width if context.touch == "smooth" else 0.0
    arguments = (x, y, vx, vy, context.diameter, context.stiffness, context.dashpot, width, low, step, thrust)
    energy, contacts = _pair_sums(*arguments)
    return PairSums(float(energy), int(contacts), thrust)


@dataclass(frozen=True)
class WallSums:
    """What one wall does to the discs of a frame.

    Attributes
    ----------
    energy : float
        Elastic energy, J/m.
    force : (float, float)
        On the discs, N/m (on the wall: the negative).
    index : ndarray of int
        Discs that touch it.
    fx, fy : ndarray
        Force on each of them, N/m.
    sideways : bool
        Whether any contact pushes along x.
    """

    energy: float
    force: tuple[float, float]
    index: np.ndarray
    fx: np.ndarray
    fy: np.ndarray
    sideways: bool


def wall_sums(frame: Frame, wall: Wall, context: FlowContext, *, velocity: bool = True) -> WallSums:
    """Contacts of a frame's discs with one wall, from positions (and velocities where `velocity`).

    Normal force k delta - c v_n, friction min(m gamma_t abs(v_t), ks abs(F_n)) of the `hooke` law or the thesis' ramp
    (4.18-4.21) of the `sign` law. A disc whose centre is inside a block feels nothing, as in the engines.
    """
    x, y, radius = frame.x, frame.y, context.radius
    width = context.touch_width if context.touch == "smooth" else 0.0
    energy, indices, fxs, fys, sideways = 0.0, [], [], [], False
    top_speed = None
    for distance, nx, ny in wall.contacts(x, y):
        touching = distance < radius
        if isinstance(wall, Block):
            touching &= distance > 0
        index = np.flatnonzero(touching)
        if not index.size:
            continue
        nx, ny, overlap = nx[index], ny[index], radius - distance[index]
        soft = np.minimum(1.0, overlap / width) if width else np.ones_like(overlap)
        k = context.stiffness_wall
        inside, beyond = 0.5 * k * overlap * soft, k * (overlap - 0.5 * width)
        normal = np.where(overlap < width, inside, beyond)
        stored = 0.5 * overlap**2 - 0.5 * width * overlap + width**2 / 6.0
        energy += k * float(np.sum(np.where(overlap < width, overlap**3 / (6.0 * width or 1.0), stored)))
        tangential = np.zeros_like(normal)
        if velocity:
            vx, vy = frame.vx[index], frame.vy[index]
            normal = normal - soft * context.dashpot_wall * (vx * nx + vy * ny)
            if context.friction:
                slip = -vx * ny + vy * nx
                if context.rotation and "omegaz" in frame.columns:
                    slip = slip - frame.column("omegaz")[index] * radius
                if context.friction_law == "sign":
                    if top_speed is None:
                        top_speed = float(np.sqrt(np.max(frame.vx**2 + frame.vy**2)))
                    share = np.clip(slip / max(0.01 * top_speed, 1e-300), -1.0, 1.0)
                    tangential = -context.friction * np.abs(normal) * share
                else:
                    ramp = context.mass * context.gamma_tangential * np.abs(slip)
                    tangential = -np.minimum(ramp, context.friction * np.abs(normal)) * np.sign(slip)
        indices.append(index)
        fxs.append(normal * nx - tangential * ny)
        fys.append(normal * ny + tangential * nx)
        sideways |= bool(np.any(np.abs(nx) > 1e-9))
    if not indices:
        empty = np.zeros(0)
        return WallSums(0.0, (0.0, 0.0), np.zeros(0, int), empty, empty, False)
    fx, fy = np.concatenate(fxs), np.concatenate(fys)
    return WallSums(energy, (float(fx.sum()), float(fy.sum())), np.concatenate(indices), fx, fy, sideways)
