"""Contacts of one frame, found from positions: who touches whom, how deep, how hard.

The one place of the analysis where discs and walls are tried for contact; `contact_sums` adds up what is found here.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from lammps_jump.dump.frame import Frame
from lammps_jump.scene.walls import Wall

from .cell_grid import close_pairs
from .flow import FlowContext


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


def dashpot_share(overlap: np.ndarray, touch: str, touch_width: float) -> np.ndarray:
    """Factor on the dashpot as the engines have it, F/sqrt(2 k E): 1 of a sharp touch.

    Of a smooth one of width s, q = delta - s/2: sqrt(3 delta/(4 s)) below s, q/sqrt(q^2 + s^2/12) beyond. The
    restitution coefficient is then the same at every speed (docs/kernels.md).
    """
    if touch == "smooth" and touch_width > 0:
        beyond = overlap - 0.5 * touch_width
        stiff = beyond / np.sqrt(beyond**2 + touch_width**2 / 12.0)
        return np.where(overlap < touch_width, np.sqrt(0.75 * np.maximum(overlap, 0.0) / touch_width), stiff)
    return np.ones_like(overlap)


class FaceContacts(NamedTuple):
    """Discs that touch one face of a wall: their indices, overlaps (m) and the unit normals of the push on them."""

    index: np.ndarray
    overlap: np.ndarray
    nx: np.ndarray
    ny: np.ndarray


def face_contacts(frame: Frame, wall: Wall, radius: float) -> Iterator[FaceContacts]:
    """Contacts of a frame's discs with each face of a wall, faces that nothing touches left out.

    As in the engines a disc behind a plane is pushed back, and one with its centre inside a block feels nothing.
    """
    for distance, nx, ny in wall.contacts(frame.x, frame.y):
        index = np.flatnonzero((distance < radius) & ((nx != 0) | (ny != 0)))
        if index.size:
            yield FaceContacts(index, radius - distance[index], nx[index], ny[index])


def find_contacts(frame: Frame, context: FlowContext, *, damping: bool = True) -> Contacts:
    """Contacts of a frame, friction left out.

    F_n = spring (see `spring_force`) + c delta_dot (thesis 3.11), c times `dashpot_share`. The dashpot takes the
    velocities of the dump, which stand at the full step.

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
    from lammps_jump.errors import DumpError

    if context.stiffness is None:
        raise DumpError("contact forces need the stiffness of the discs (N/m): give stiffness=… with the dump.")
    points = np.column_stack([frame.x, frame.y])
    damping = damping and "vx" in frame.columns and "vy" in frame.columns
    velocity = np.column_stack([frame.vx, frame.vy]) if damping else np.zeros_like(points)
    touch = context.touch, context.touch_width

    def normal_force(overlap, closing, stiffness, dashpot):
        return spring_force(overlap, stiffness, *touch) + dashpot * dashpot_share(overlap, *touch) * closing

    i, j = close_pairs(*(np.ascontiguousarray(values, float) for values in (frame.x, frame.y)), context.diameter)
    branch = points[i] - points[j]
    distance = np.hypot(*branch.T)
    normal = branch / distance[:, None]
    overlap = context.diameter - distance
    closing = -np.einsum("ij,ij->i", velocity[i] - velocity[j], normal)
    force = normal_force(overlap, closing, context.stiffness, context.dashpot)
    parts = [(points[i], points[j], normal, overlap, force, False)]
    stiffness_wall = context.stiffness if context.stiffness_wall is None else context.stiffness_wall
    for wall in context.walls_at(context.time(frame)):
        for face in face_contacts(frame, wall, context.radius):
            here, normal = points[face.index], np.column_stack([face.nx, face.ny])
            closing = -np.einsum("ij,ij->i", velocity[face.index], normal)
            force = normal_force(face.overlap, closing, stiffness_wall, context.dashpot_wall)
            end = here - (context.radius - face.overlap)[:, None] * normal
            parts.append((here, end, normal, face.overlap, force, True))
    joined = [np.concatenate(column) for column in list(zip(*parts, strict=True))[:5]]
    is_wall = np.concatenate([np.full(len(part[3]), part[5]) for part in parts])
    return Contacts(*joined, is_wall)
