# SPDX-License-Identifier: GPL-2.0-or-later
"""Contacts of one frame, found from positions: pairs, overlaps, forces, and their sums. All per metre of width."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from typing import NamedTuple, ParamSpec, TypeVar

import numpy as np
from numba import njit

from lammps_jump.dump.frame import Frame
from lammps_jump.errors import DumpError
from lammps_jump.physics.law import friction_force, normal_force, stored_energy, watching_law
from lammps_jump.physics.slip import SIGN_RAMP
from lammps_jump.scene.walls import Wall

from .cell_grid import close_pairs
from .flow import Flow

Asked = ParamSpec("Asked")
Answer = TypeVar("Answer")


def once_a_frame(function: Callable[Asked, Answer]) -> Callable[Asked, Answer]:
    """The same function of a frame and more, which keeps its answers for the last frame: several analyses ask alike."""
    kept: dict[tuple, tuple] = {}
    last: list[object] = [None]

    @wraps(function)
    def answer(*asked: Asked.args, **options: Asked.kwargs) -> Answer:
        if last[0] is not asked[0]:
            kept.clear()
            last[0] = asked[0]
        key = (*map(id, asked), *options.items())
        found = kept.get(key)
        if found is None:
            found = kept[key] = function(*asked, **options), asked  # what was asked is held: no other has its id
        return found[0]

    return answer


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


class Touching(NamedTuple):
    """What touches in a frame: indices of both discs; of a contact with a wall, `first` is the number of discs.

    Unit vector from the first to the second, overlap (m), dashpot (N s/m) and stiffness (N/m).
    """

    first: np.ndarray
    second: np.ndarray
    nx: np.ndarray
    ny: np.ndarray
    overlap: np.ndarray
    dashpot: np.ndarray
    stiffness: np.ndarray


@once_a_frame
def wall_contacts(frame: Frame, wall: Wall, flow: Flow) -> tuple[Touching, ...]:
    """Contacts of a frame's discs with each face of a wall; faces that no disc touches are left out.

    As in the engines a disc behind a plane is pushed back, and one with its centre inside a block feels nothing.
    """
    radius, relative_mass, found = flow.radii(frame), flow.relative_masses(frame), []
    for distance, nx, ny in wall.contacts(frame.x, frame.y):
        index = np.flatnonzero((distance < radius) & ((nx != 0) | (ny != 0)))
        if index.size:
            overlap, dashpot = radius[index] - distance[index], flow.dashpots[1] * np.sqrt(relative_mass[index])
            stiffness = np.full(len(index), flow.scene.coefficients.stiffness_wall)
            wall_itself = np.full(len(index), frame.n)
            found.append(Touching(wall_itself, index, nx[index], ny[index], overlap, dashpot, stiffness))
    return tuple(found)


@once_a_frame
def touching_pairs(frame: Frame, flow: Flow) -> Touching:
    """Pairs of discs in contact."""
    x, y = (np.ascontiguousarray(values, float) for values in (frame.x, frame.y))
    i, j = close_pairs(x, y, 2 * flow.largest_radius(frame))
    dx, dy, reach = x[j] - x[i], y[j] - y[i], flow.scene.diameter
    distance, dashpot = np.sqrt(dx * dx + dy * dy), np.full(len(i), flow.dashpots[0])
    if flow.sized:
        radii, mass = flow.radii(frame), flow.relative_masses(frame)
        reach = radii[i] + radii[j]
        # a nominal pair has the effective mass 1/2
        dashpot *= np.sqrt(2.0 * mass[i] * mass[j] / (mass[i] + mass[j]))
    stiffness, touch = np.full(len(i), flow.scene.coefficients.stiffness), distance < reach
    found = (i, j, dx / distance, dy / distance, reach - distance, dashpot, stiffness)
    return Touching(*(part[touch] for part in found))


@once_a_frame
def touching(frame: Frame, flow: Flow) -> Touching:
    """Pairs of discs in contact, then discs in contact with walls."""
    walls = flow.walls_at(flow.time(frame))
    parts = [touching_pairs(frame, flow), *(face for wall in walls for face in wall_contacts(frame, wall, flow))]
    return Touching(*map(np.concatenate, zip(*parts, strict=True)))


def find_contacts(frame: Frame, flow: Flow, *, damping: bool = True) -> Contacts:
    """Contacts of a frame, friction left out.

    The law is `lammps_jump.physics.law.normal_force`. The dashpot takes the velocities of the dump, which stand at the
    full step.

    Parameters
    ----------
    frame : Frame
    flow : Flow
        Its stiffness must be known.
    damping : bool
        Without it (or without velocities in the dump) the elastic force alone.

    Raises
    ------
    DumpError
        The stiffness is not known.
    """
    if not flow.knows_contacts:
        raise DumpError("contact forces need the stiffness of the discs: analyse the dump with its case (--case).")
    first, second, nx, ny, overlap, dashpot, stiffness = touching(frame, flow)
    points, normal, is_wall = np.column_stack([frame.x, frame.y]), np.column_stack([nx, ny]), first == frame.n
    opening = np.zeros_like(overlap)
    if damping and {"vx", "vy"} <= set(frame.columns):
        u, v = (np.append(speed, 0.0) for speed in (frame.vx, frame.vy))
        opening = (u[second] - u[first]) * nx + (v[second] - v[first]) * ny
    force = normal_forces(overlap, opening, stiffness, dashpot, flow.touch_width)
    start, end = points[second], points[np.where(is_wall, 0, first)]
    to_wall = (flow.radii(frame)[second] - overlap)[:, None] * normal
    return Contacts(start, np.where(is_wall[:, None], start - to_wall, end), normal, overlap, force, is_wall)


def _normal_forces_py(overlap, opening, stiffness, damping, touch):
    """Normal force of each contact, N/m; parameters of `law.normal_force`, all but `touch` of shape (n,)."""
    force = np.empty_like(overlap)
    for k in range(overlap.size):
        force[k] = normal_force(overlap[k], opening[k], stiffness[k], damping[k], touch)[0]
    return force


def _friction_forces_py(normal, slip, friction, damping, slope):
    """Friction of each contact, N/m; parameters of `law.friction_force`, normal, slip, damping of shape (n,)."""
    force = np.empty_like(normal)
    for k in range(normal.size):
        force[k] = friction_force(normal[k], slip[k], friction, damping[k], slope)
    return force


def _stored_energies_py(overlap, touch):
    """Elastic energy of each contact over the stiffness, m^2, shape (n,)."""
    energy = np.empty_like(overlap)
    for k in range(overlap.size):
        energy[k] = stored_energy(overlap[k], touch)
    return energy


def _pair_sums_py(x, vx, vy, first, second, nx, ny, overlap, dashpot, stiffness, touch, low, bin_width, pressure):
    """Elastic energy of pairs, of `touching_pairs`; their thrust along x is added to `pressure`.

    pressure[b] gains the mean over the planes x = const of bin b of the force that the discs left of the plane exert on
    those right of it: each contact acts along the line of centres, so it counts with the share of its x-extent that
    lies in the bin over the bin's width (method of planes, averaged).
    """
    energy = 0.0
    bins = pressure.size
    for p in range(first.size):
        i, j = first[p], second[p]
        energy += stiffness[p] * stored_energy(overlap[p], touch)
        if bins == 0:
            continue
        opening = (vx[j] - vx[i]) * nx[p] + (vy[j] - vy[i]) * ny[p]
        push = normal_force(overlap[p], opening, stiffness[p], dashpot[p], touch)[0] * abs(nx[p])
        left = min(x[i], x[j])
        right = max(x[i], x[j])
        b = max(int(np.floor((left - low) / bin_width)), 0)
        while b < bins and low + b * bin_width < right:
            inside = min(right, low + (b + 1) * bin_width) - max(left, low + b * bin_width)
            if inside > 0.0:
                pressure[b] += push * inside / bin_width
            b += 1
    return energy


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
    thrust = np.zeros(0 if edges is None else len(edges) - 1)
    x = np.ascontiguousarray(frame.x, float)
    vx, vy = (x, x) if edges is None else (np.ascontiguousarray(v, float) for v in (frame.vx, frame.vy))
    low, step = (0.0, 1.0) if edges is None else (float(edges[0]), float(edges[-1] - edges[0]) / len(thrust))
    pairs = touching_pairs(frame, flow)
    energy = _pair_sums(x, vx, vy, *pairs, flow.touch_width, low, step, thrust)
    return PairSums(float(energy), len(pairs.first), thrust)


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


@once_a_frame
def wall_sums(frame: Frame, wall: Wall, flow: Flow, *, velocity: bool = True) -> WallSums:
    """Contacts of a frame's discs with one wall, from positions (and velocities where `velocity`).

    Normal force k delta - c v_n, friction min(m gamma_t abs(v_t), ks abs(F_n)) of the `hooke` law or the thesis' ramp
    (4.18-4.21) of the `sign` law.
    """
    c, energy = flow.scene.coefficients, 0.0
    faces = wall_contacts(frame, wall, flow)
    if not faces:
        empty = np.zeros(0)
        return WallSums(0.0, (0.0, 0.0), np.zeros(0, int), empty, empty, False)
    fxs, fys = [], []
    for face in faces:
        _, index, nx, ny, overlap, dashpot, stiffness = face
        leaving = frame.vx[index] * nx + frame.vy[index] * ny if velocity else np.zeros_like(overlap)
        force = normal_forces(overlap, leaving, stiffness, dashpot, flow.touch_width)
        energy += c.stiffness_wall * float(np.sum(stored_energies(overlap, flow.touch_width)))
        rubbing = _wall_friction(frame, flow, face, force) if velocity and c.friction else 0.0
        fxs.append(force * nx - rubbing * ny)
        fys.append(force * ny + rubbing * nx)
    fx, fy = np.concatenate(fxs), np.concatenate(fys)
    sideways = any(bool(np.any(np.abs(face.nx) > 1e-9)) for face in faces)
    index = np.concatenate([face.second for face in faces])
    return WallSums(energy, (float(fx.sum()), float(fy.sum())), index, fx, fy, sideways)


def _wall_friction(frame: Frame, flow: Flow, face: Touching, force: np.ndarray) -> np.ndarray:
    """Friction of each contact of a face along the tangent (-ny, nx), N/m; `force` is the normal one."""
    scene, c = flow.scene, flow.scene.coefficients
    slip = -frame.vx[face.second] * face.ny + frame.vy[face.second] * face.nx
    if scene.rotation and "omegaz" in frame.columns:
        slip = slip - frame.column("omegaz")[face.second] * flow.radii(frame)[face.second]
    slope = None
    if scene.friction_law == "sign":
        top_speed = float(np.sqrt(np.max(frame.vx**2 + frame.vy**2)))
        slope = 1.0 / max(SIGN_RAMP * top_speed, 1e-300)
    damping = c.mass * c.gamma_tangential_wall * np.sqrt(flow.relative_masses(frame)[face.second])
    return friction_forces(force, slip, c.friction, damping, slope)


@dataclass(frozen=True)
class ContactSeries:
    """Sums over contacts, frame by frame.

    Attributes
    ----------
    thrust : ndarray, shape (frames, bins)
        Force through vertical planes, averaged over each bin, N/m, compression positive.
    wall_fx : ndarray, shape (frames, bins)
        Force of all walls on the discs of each bin along x, N per metre of width.
    """

    thrust: np.ndarray
    wall_fx: np.ndarray


class ContactCollector:
    """Collects a `ContactSeries`; with `edges` None only the elastic energy."""

    def __init__(self, flow: Flow, edges: np.ndarray | None):
        self.flow, self.edges = flow, edges
        self.latest = 0.0
        self._bins: list[np.ndarray] = []

    def add(self, frame: Frame, time: float) -> None:
        """Add a frame; its elastic energy stands in ``latest`` until the next one."""
        flow, edges = self.flow, self.edges
        pairs = pair_sums(frame, flow, edges)
        self.latest = pairs.energy
        push = np.zeros_like(pairs.thrust)
        for wall in flow.walls_at(time):
            sums = wall_sums(frame, wall, flow, velocity=edges is not None)
            self.latest += sums.energy
            if edges is not None and sums.index.size:
                place = np.floor((frame.x[sums.index] - edges[0]) / (edges[1] - edges[0])).astype(int)
                inside = (place >= 0) & (place < len(push))
                push += np.bincount(place[inside], sums.fx[inside], len(push))
        self._bins.append(np.array([pairs.thrust, push]))

    def result(self) -> ContactSeries:
        """The series of all frames added; the collector is empty afterwards (long records are held once)."""
        bins = np.array(self._bins).reshape(len(self._bins), 2, -1)
        self._bins.clear()
        return ContactSeries(bins[:, 0], bins[:, 1])


normal_forces = watching_law(njit(cache=True)(_normal_forces_py))
friction_forces = watching_law(njit(cache=True)(_friction_forces_py))
stored_energies = watching_law(njit(cache=True)(_stored_energies_py))
_pair_sums = watching_law(njit(cache=True)(_pair_sums_py))
