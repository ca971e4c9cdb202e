"""Contacts of one frame, found from positions: who touches whom, how deep, how hard."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .context import FlowContext
from .dump import Frame


@dataclass(frozen=True)
class Contacts:
    """Normal contacts of discs with each other and with walls.

    Attributes
    ----------
    start, end : ndarray, shape (n, 2), m
        The branch of each contact: from the centre of the disc to the other centre, or to the wall's surface.
    normal : ndarray, shape (n, 2)
        Unit vector of the push on the disc at `start`.
    overlap : ndarray, shape (n,), m
    force : ndarray, shape (n,), N per metre of width
        Normal force, spring and dashpot, positive when it pushes apart.
    is_wall : ndarray of bool, shape (n,)
    """

    start: np.ndarray
    end: np.ndarray
    normal: np.ndarray
    overlap: np.ndarray
    force: np.ndarray
    is_wall: np.ndarray


def spring_force(overlap: np.ndarray, stiffness: float, touch: str, touch_width: float) -> np.ndarray:
    """Elastic force, N/m: k delta; with a smooth touch of width s, k delta^2/(2 s) below s, k (delta - s/2) beyond."""
    if touch == "smooth" and touch_width > 0:
        soft = stiffness * overlap**2 / (2 * touch_width)
        return np.where(overlap < touch_width, soft, stiffness * (overlap - 0.5 * touch_width))
    return stiffness * overlap


def find_contacts(frame: Frame, context: FlowContext, *, damping: bool = True) -> Contacts:
    """Contacts of a frame, friction left out.

    F_n = spring (see `spring_force`) + c delta_dot (thesis 3.11), c delta_dot times min(1, delta/s) with a smooth
    touch. The dashpot takes the velocities of the dump, which stand at the full step.

    Parameters
    ----------
    frame : Frame
    context : FlowContext
        ``stiffness`` must be known.
    damping : bool
        Without it (or without velocities in the dump) the elastic force alone.

    Raises
    ------
    DumpError
        The stiffness is not known.
    """
    from scipy.spatial import cKDTree

    from lammps_jump.errors import DumpError

    if context.stiffness is None:
        raise DumpError("contact forces need the stiffness of the discs (N/m): give stiffness=… with the dump.")
    points = np.column_stack([frame.x, frame.y])
    radius, damping = context.radius, damping and "vx" in frame.columns and "vy" in frame.columns
    velocity = np.column_stack([frame.vx, frame.vy]) if damping else np.zeros_like(points)
    smooth = context.touch == "smooth" and context.touch_width > 0

    def normal_force(overlap, closing, stiffness, dashpot):
        ramp = np.minimum(1.0, overlap / context.touch_width) if smooth else 1.0
        force = spring_force(overlap, stiffness, context.touch, context.touch_width)
        return force + dashpot * closing * ramp

    pairs = np.empty((0, 2), int)
    if len(points) > 1:
        pairs = cKDTree(points).query_pairs(context.diameter, output_type="ndarray")
    i, j = pairs.T
    branch = points[i] - points[j]
    distance = np.hypot(*branch.T)
    safe = np.where(distance > 0, distance, 1.0)[:, None]
    normal = np.where(distance[:, None] > 0, branch / safe, [0.0, 1.0])
    overlap = context.diameter - distance
    closing = -np.einsum("ij,ij->i", velocity[i] - velocity[j], normal)
    parts = [
        (
            points[i],
            points[j],
            normal,
            overlap,
            normal_force(overlap, closing, context.stiffness, context.dashpot),
            False,
        )
    ]
    stiffness_wall = context.stiffness if context.stiffness_wall is None else context.stiffness_wall
    for wall in context.walls_at(context.time(frame)):
        for gap, nx, ny in wall.contacts(*points.T):
            touching = (gap > 0) & (gap < radius)
            here, gap, normal = points[touching], gap[touching], np.column_stack([nx, ny])[touching]
            overlap = radius - gap
            closing = -np.einsum("ij,ij->i", velocity[touching], normal)
            force = normal_force(overlap, closing, stiffness_wall, context.dashpot_wall)
            parts.append((here, here - gap[:, None] * normal, normal, overlap, force, True))
    joined = [np.concatenate(column) for column in list(zip(*parts, strict=True))[:5]]
    is_wall = np.concatenate([np.full(len(part[3]), part[5]) for part in parts])
    return Contacts(*joined, is_wall)
