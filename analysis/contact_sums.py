"""Sums over the contacts of a frame: elastic energy, the force the discs pass on along x, the forces of walls.

The kernel is a plain loop over the pairs that `cell_grid` finds; everything per metre of width.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

from lammps_jump.dump.frame import Frame
from lammps_jump.scene.walls import Wall

from .cell_grid import close_pairs
from .contacts import dashpot_share, face_contacts, spring_force
from .flow import Flow


def _pair_sums_py(x, y, vx, vy, first, second, diameter, stiffness, dashpot, width, low, bin_width, pressure):
    """Elastic energy of overlapping pairs (first[p], second[p]); their thrust along x is added to `pressure`.

    width is the soft start of a smooth touch (0: sharp): U = k delta^3/(6 s) below s, k (delta^2/2 - s delta/2 +
    s^2/6) above; the dashpot is scaled as in `contacts_found.dashpot_share`. pressure[b] gains the mean over the
    planes x = const of bin b of the force that the discs left of the plane exert on those right of it: each contact
    acts along the line of centres, so it counts with the share of its x-extent that lies in the bin over the bin's
    width (method of planes, averaged).
    """
    energy = 0.0
    bins = pressure.size
    for p in range(first.size):
        i, j = first[p], second[p]
        dx, dy = x[j] - x[i], y[j] - y[i]
        distance = np.sqrt(dx * dx + dy * dy)
        overlap = diameter - distance
        share = 1.0
        if width > 0.0 and overlap < width:
            energy += stiffness * overlap**3 / (6.0 * width)
            force = 0.5 * stiffness * overlap * overlap / width
            share = np.sqrt(0.75 * overlap / width)
        else:
            energy += stiffness * (0.5 * overlap**2 - 0.5 * width * overlap + width**2 / 6.0)
            beyond = overlap - 0.5 * width
            force = stiffness * beyond
            if width > 0.0:
                share = beyond / np.sqrt(beyond * beyond + width * width / 12.0)
        if bins == 0:
            continue
        approach = -((vx[j] - vx[i]) * dx + (vy[j] - vy[i]) * dy) / distance
        force += share * dashpot * approach
        push = force * abs(dx) / distance
        left = min(x[i], x[j])
        right = max(x[i], x[j])
        b = max(int(np.floor((left - low) / bin_width)), 0)
        while b < bins and low + b * bin_width < right:
            inside = min(right, low + (b + 1) * bin_width) - max(left, low + b * bin_width)
            if inside > 0.0:
                pressure[b] += push * inside / bin_width
            b += 1
    return energy


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


def pair_sums(frame: Frame, flow: Flow, edges: np.ndarray | None = None) -> PairSums:
    """Elastic energy and thrust of the disc-disc contacts of a frame.

    Parameters
    ----------
    frame : Frame
        With x, y, and vx, vy where `edges` are given.
    flow : Flow
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
    width = flow.touch_width
    first, second = close_pairs(x, y, flow.scene.diameter)
    law = (flow.scene.diameter, flow.scene.coefficients.stiffness, flow.dashpots[0], width)
    energy = _pair_sums(x, y, vx, vy, first, second, *law, low, step, thrust)
    return PairSums(float(energy), len(first), thrust)


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


def wall_sums(frame: Frame, wall: Wall, flow: Flow, *, velocity: bool = True) -> WallSums:
    """Contacts of a frame's discs with one wall, from positions (and velocities where `velocity`).

    Normal force k delta - c v_n, friction min(m gamma_t abs(v_t), ks abs(F_n)) of the `hooke` law or the thesis' ramp
    (4.18-4.21) of the `sign` law.
    """
    c, width = flow.scene.coefficients, flow.touch_width
    energy, indices, fxs, fys, sideways = 0.0, [], [], [], False
    top_speed = None
    for index, overlap, nx, ny in face_contacts(frame, wall, flow.scene.radius):
        normal = spring_force(overlap, c.stiffness_wall, width)
        stored = 0.5 * overlap**2 - 0.5 * width * overlap + width**2 / 6.0
        energy += c.stiffness_wall * float(np.sum(np.where(overlap < width, overlap**3 / (6.0 * width or 1.0), stored)))
        tangential = np.zeros_like(normal)
        if velocity:
            vx, vy = frame.vx[index], frame.vy[index]
            share = dashpot_share(overlap, width)
            normal = normal - share * flow.dashpots[1] * (vx * nx + vy * ny)
            if c.friction:
                slip = -vx * ny + vy * nx
                if flow.scene.rotation and "omegaz" in frame.columns:
                    slip = slip - frame.column("omegaz")[index] * flow.scene.radius
                if flow.scene.friction_law == "sign":
                    if top_speed is None:
                        top_speed = float(np.sqrt(np.max(frame.vx**2 + frame.vy**2)))
                    share = np.clip(slip / max(0.01 * top_speed, 1e-300), -1.0, 1.0)
                    tangential = -c.friction * np.abs(normal) * share
                else:
                    ramp = c.mass * c.gamma_tangential_wall * np.abs(slip)
                    tangential = -np.minimum(ramp, c.friction * np.abs(normal)) * np.sign(slip)
        indices.append(index)
        fxs.append(normal * nx - tangential * ny)
        fys.append(normal * ny + tangential * nx)
        sideways |= bool(np.any(np.abs(nx) > 1e-9))
    if not indices:
        empty = np.zeros(0)
        return WallSums(0.0, (0.0, 0.0), np.zeros(0, int), empty, empty, False)
    fx, fy = np.concatenate(fxs), np.concatenate(fys)
    return WallSums(energy, (float(fx.sum()), float(fy.sum())), np.concatenate(indices), fx, fy, sideways)
