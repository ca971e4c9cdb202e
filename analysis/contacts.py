# SPDX-License-Identifier: GPL-2.0-or-later
"""Contacts of one frame, computed from positions: pairs, overlaps, forces, their sums. All per metre of width.

Pairs of points that are close to each other.
"""

from __future__ import annotations

from collections.abc import Callable
from ctypes import POINTER, Array
from dataclasses import dataclass
from functools import lru_cache, wraps
from typing import Any, NamedTuple, ParamSpec, TypeVar

import numpy as np
from numpy.ctypeslib import ndpointer

from lammps_jump.core.law import jump_law
from lammps_jump.core.library import INTEGER, INTEGERS, REAL, REALS, SHORTS, core, entry, function
from lammps_jump.dump.frame import Frame
from lammps_jump.errors import DumpError
from lammps_jump.scene.chains import FACE, records_of
from lammps_jump.scene.faces import FaceGrid, grid_of
from lammps_jump.scene.motion import WallAtStep
from lammps_jump.scene.walls import Wall

from .flow import Flow, fixed_discs

_touch_wall = entry(
    "jump_touch_wall", INTEGER, n=INTEGER, x=REALS, y=REALS, radius=REALS, faces=ndpointer(FACE), deep=INTEGER,
    place=REALS, cells=INTEGERS, start=INTEGERS, listed=INTEGERS, index=INTEGERS, found=REALS, room=INTEGER,
)  # fmt: skip
LAWS = POINTER(jump_law)
_normal_forces = function("jump_normal_forces", INTEGER, LAWS, INTEGERS, REALS, REALS, REALS, REALS)
_elastic_sum = function("jump_elastic_sum", INTEGER, LAWS, INTEGERS, REALS, result=REAL)
_whole_forces = entry(
    "jump_whole_forces", n=INTEGER, laws=LAWS, which=INTEGERS, first=INTEGERS, second=INTEGERS, state=REALS,
    discs=INTEGER, contact=REALS, has_friction=INTEGER, slope=REAL, fx=REALS, fy=REALS,
)  # fmt: skip
_thrust = entry(
    "jump_thrust", n=INTEGER, x=REALS, first=INTEGERS, second=INTEGERS, fx=REALS, low=REAL, width=REAL, bins=INTEGER,
    thrust=REALS,
)  # fmt: skip

Arguments = ParamSpec("Arguments")
Answer = TypeVar("Answer")


def once_a_frame(function: Callable[Arguments, Answer]) -> Callable[Arguments, Answer]:
    """The same function of a frame and more, which keeps its answers for the last frame: several analyses ask alike."""
    kept: dict[tuple[Any, ...], tuple[Any, ...]] = {}
    last: list[object] = [None]

    @wraps(function)
    def answer(*given: Arguments.args, **options: Arguments.kwargs) -> Answer:
        if last[0] is not given[0]:
            kept.clear()
            last[0] = given[0]
        key = (*map(id, given), *options.items())
        stored = kept.get(key)
        if stored is None:
            # the arguments are kept too: so nothing else has their ids
            stored = kept[key] = function(*given, **options), given
        return stored[0]

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
    """Contacts of a frame: indices of both discs; of a contact with a wall, `first` is the number of discs.

    Unit vector from the first to the second, overlap (m), dashpot and slope of LAMMPS' viscous friction (N s/m),
    velocity of the wall at the contact (m/s; 0 for pairs), which of `Flow.laws` it has, and id of the first disc, or
    -1 - w for wall w of the scene.
    """

    first: np.ndarray
    second: np.ndarray
    nx: np.ndarray
    ny: np.ndarray
    overlap: np.ndarray
    dashpot: np.ndarray
    ramp: np.ndarray
    wall_u: np.ndarray
    wall_v: np.ndarray
    law: np.ndarray
    partner: np.ndarray


@lru_cache
def _grid(wall: Wall, reach: float) -> FaceGrid:
    """Grid on which discs of radii up to `reach` (m) find the faces of a wall."""
    return grid_of(wall.faces, 2 * reach, reach)


@lru_cache
def _faces(wall: Wall) -> np.ndarray:
    """Faces of a wall as the core has them."""
    return records_of(wall.faces)


@once_a_frame
def walls_of(frame: Frame, flow: Flow) -> tuple[Wall, ...]:
    """Walls that are there at a frame, where they are."""
    return flow.walls_at(flow.time(frame))


@once_a_frame
def wall_contacts(frame: Frame, wall: Wall, flow: Flow) -> Touching:
    """Contacts of a frame's discs with a wall, by the rule of the engines (`lammps_jump.scene.faces`).

    Discs are looked at in the frame in which a moving wall is at rest, so its faces and their grid are made once.
    """
    law, moving = flow.scene.wall_law(wall.name), wall if isinstance(wall, WallAtStep) else None
    body, places = (moving.body, moving.inward(frame.x, frame.y)) if moving else (wall, (frame.x, frame.y))
    x, y, radius = (np.ascontiguousarray(values, float) for values in (*places, flow.radii(frame)))
    wall_faces = _faces(body)
    grid = _grid(body, max(0.5 * flow.scene.largest, flow.largest_radius(frame)))
    count, room = 0, -1
    while count > room:
        room = max(count, 2 * frame.n)
        index, contacts = np.empty(room, np.int64), np.empty((room, 3))
        count = _touch_wall(
            n=frame.n, x=x, y=y, radius=radius, faces=wall_faces, deep=body.faces.deep[0], place=grid.place[0],
            cells=grid.cells[0], start=grid.start, listed=grid.faces, index=index, found=contacts, room=room,
        )  # fmt: skip
    index, (distance, nx, ny), rate = index[:count], contacts[:count].T, (np.zeros(count), np.zeros(count))
    mass, number = flow.scene.mass * flow.relative_masses(frame)[index], flow.number_of(wall)
    along = across = np.sqrt(flow.scene.mass * mass)
    if moving:
        nx, ny = moving.turned(nx, ny)
        free = flow.scene.walls[number].motion.free if number >= 0 else None
        to = distance if free is None else radius[index]  # a body feels it at the rim of the disc
        x, y = frame.x[index] - to * nx, frame.y[index] - to * ny
        rate = moving.velocity(x, y)
        if free is not None and not flow.time(frame) < free.begin:
            arms = np.column_stack([x, y]) - moving.moment_point
            along = along / np.sqrt(1.0 + mass * free.gives_way(arms, np.column_stack([nx, ny])))
            across = across / np.sqrt(1.0 + mass * free.gives_way(arms, np.column_stack([-ny, nx])))
    return Touching(
        np.full(count, frame.n), index, nx, ny, radius[index] - distance, law.gamma_normal * along,
        law.gamma_tangential * across, *rate, np.full(count, 1 + number), np.full(count, -1 - number),
    )  # fmt: skip


@once_a_frame
def touching_pairs(frame: Frame, flow: Flow) -> Touching:
    """Pairs of discs in contact."""
    x, y = (np.ascontiguousarray(values, float) for values in (frame.x, frame.y))
    i, j = close_pairs(x, y, 2 * flow.largest_radius(frame))
    dx, dy, reach = x[j] - x[i], y[j] - y[i], flow.scene.diameter
    c, distance, size = flow.scene.coefficients, np.sqrt(dx * dx + dy * dy), np.ones(len(i))
    if flow.sized:
        radii, mass = flow.radii(frame), flow.relative_masses(frame)
        reach = radii[i] + radii[j]
        # a nominal pair has the effective mass 1/2
        size = np.sqrt(2.0 * mass[i] * mass[j] / (mass[i] + mass[j]))
    still, dashpots = np.zeros(len(i)), (flow.dashpots[0] * size, 0.5 * c.mass * c.gamma_tangential * size)
    law = np.zeros(len(i), np.int64)
    columns = i, j, dx / distance, dy / distance, reach - distance, *dashpots, still, still, law, frame.ids[i]
    touch = distance < reach
    return Touching(*(part[touch] for part in columns))


@once_a_frame
def bed_contacts(frame: Frame, flow: Flow) -> Touching:
    """Contacts of a frame's discs with the fixed ones of rough beds, as with walls: m_eff is the mass of the disc."""
    fixed, c = fixed_discs(frame, flow.scene), flow.scene.coefficients
    x, y, radius = (
        np.concatenate(part)
        for part in ((frame.x, fixed.x), (frame.y, fixed.y), (flow.radii(frame), fixed.column("radius")))
    )
    i, j = close_pairs(x, y, 2 * float(radius.max(initial=flow.scene.radius)))
    across = (i < frame.n) != (j < frame.n)
    disc, bed = np.minimum(i, j)[across], np.maximum(i, j)[across]
    dx, dy = x[disc] - x[bed], y[disc] - y[bed]
    distance = np.sqrt(dx * dx + dy * dy)
    overlap = radius[disc] + radius[bed] - distance
    touch = overlap > 0
    disc, bed = disc[touch], bed[touch]
    size, still = np.sqrt(2.0 * flow.relative_masses(frame)[disc]), np.zeros(len(disc))
    return Touching(
        np.full(len(disc), frame.n), disc, (dx / distance)[touch], (dy / distance)[touch], overlap[touch],
        flow.dashpots[0] * size, 0.5 * c.mass * c.gamma_tangential * size, still, still, np.zeros(len(disc), np.int64),
        fixed.ids[bed - frame.n],
    )  # fmt: skip


@once_a_frame
def touching(frame: Frame, flow: Flow) -> Touching:
    """Pairs of discs in contact, then discs in contact with walls and rough beds."""
    parts = [touching_pairs(frame, flow), *(wall_contacts(frame, wall, flow) for wall in walls_of(frame, flow))]
    if flow.scene.fixed is not None:
        parts.append(bed_contacts(frame, flow))
    return Touching(*map(np.concatenate, zip(*parts, strict=True)))


def find_contacts(frame: Frame, flow: Flow, *, damping: bool = True) -> Contacts:
    """Contacts of a frame, friction left out.

    The law is `lammps_jump.physics.law.normal_force`. The dashpot takes the velocities of the dump, those of the
    full step.

    Parameters
    ----------
    frame : Frame
    flow : Flow
        It must know contacts.
    damping : bool
        Without it (or without velocities in the dump) the elastic force alone.

    Raises
    ------
    DumpError
        The stiffness is not known, or there is no core.
    """
    if not flow.knows_contacts:
        raise DumpError(f"no contact forces: {flow.no_contacts}; analyse a bare dump with its case (--case).")
    pairs = touching(frame, flow)
    first, second, nx, ny, overlap, *_ = pairs
    points, normal, is_wall = np.column_stack([frame.x, frame.y]), np.column_stack([nx, ny]), first == frame.n
    opening = np.zeros_like(overlap)
    if damping and {"vx", "vy"} <= set(frame.columns):
        u, v = (np.append(np.nan_to_num(speed), 0.0) for speed in (frame.vx, frame.vy))
        opening = (u[second] - u[first] - pairs.wall_u) * nx + (v[second] - v[first] - pairs.wall_v) * ny
    force = normal_forces(flow, pairs, opening)
    start, end = points[second], points[np.where(is_wall, 0, first)]
    to_wall = (flow.radii(frame)[second] - overlap)[:, None] * normal
    return Contacts(start, np.where(is_wall[:, None], start - to_wall, end), normal, overlap, force, is_wall)


def normal_forces(flow: Flow, contacts: Touching, opening: np.ndarray) -> np.ndarray:
    """Normal force of each contact at these speeds of parting (m/s), N/m; shape (n,)."""
    force = np.empty(len(opening))
    arrays = (np.ascontiguousarray(values, float) for values in (contacts.overlap, opening, contacts.dashpot))
    _normal_forces(len(force), *_laws(flow, contacts), *arrays, force)
    return force


def _laws(flow: Flow, contacts: Touching) -> tuple[Array[jump_law], np.ndarray]:
    """The laws of a flow, and which one each contact has."""
    return flow.laws, np.ascontiguousarray(contacts.law, np.int64)


def whole_forces(
    frame: Frame, flow: Flow, contacts: Touching, *, velocity: bool = True
) -> tuple[np.ndarray, np.ndarray]:
    """Force (fx, fy) of each contact on its second disc, friction included, N/m; shape (n,) each.

    It is what the engine has written, where it has. Else the laws are those of `lammps_jump.physics.law`, with the
    velocities of the dump, which are those of the full step; springs with memory, which no frame gives, are left out. A
    disc whose velocity is not known (NaN) counts as one at rest.

    Parameters
    ----------
    frame : Frame
    flow : Flow
        With a stiffness.
    contacts : Touching
    velocity : bool
        Without it the springs alone.
    """
    scene, zero = flow.scene, np.zeros(frame.n + 1)
    # the discs are followed by one that never moves: the walls, whose own velocity is given with the contact
    moving = (np.nan_to_num(frame.vx), np.nan_to_num(frame.vy), zero[1:])
    u, v, rim = (np.append(values, 0.0) for values in moving) if velocity else (zero,) * 3
    rubs = velocity and scene.rubs and scene.springs is None
    still = np.zeros(len(contacts.first))
    wall_u, wall_v = (contacts.wall_u, contacts.wall_v) if velocity else (still, still)
    if rubs and scene.rotation and "omegaz" in frame.columns:
        rim = np.append(frame.column("omegaz") * flow.radii(frame), 0.0)
    slope = 1.0 / max(flow.laws[0].sign_ramp * float(np.sqrt(np.max(u**2 + v**2))), 1e-300)
    first, second = contacts.first.astype(np.int64), contacts.second.astype(np.int64)
    numbers = np.array([*contacts[2:7], wall_u, wall_v], float)
    computed = np.empty_like(still), np.empty_like(still)
    laws, which = _laws(flow, contacts)
    _whole_forces(
        n=len(still), laws=laws, which=which, first=first, second=second, state=np.array([u, v, rim]), discs=len(u),
        contact=numbers, has_friction=rubs, slope=slope, fx=computed[0], fy=computed[1],
    )  # fmt: skip
    if flow.written is None or not velocity:
        return computed
    written = flow.written.forces(frame.step, frame.ids[contacts.second], contacts.partner)
    # a contact that begins within the digits of the dump may be in one of the two alone
    fx, fy = (np.where(np.isnan(known), own, known) for known, own in zip(written, computed, strict=True))
    return fx, fy


def elastic_energy(contacts: Touching, flow: Flow) -> float:
    """Elastic energy of contacts, J/m."""
    overlap = np.ascontiguousarray(contacts.overlap, float)
    return _elastic_sum(len(overlap), *_laws(flow, contacts), overlap)


def thrust_of(x: np.ndarray, contacts: Touching, fx: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Thrust of pairs along x in bins of equal width, N/m; `fx` is the force on the second disc of each.

    It is the mean, over the planes x = const of a bin, of the force that the discs left of the plane exert on those
    right of it. A contact acts through the planes between the two centres: it counts with the share of its x-extent
    that lies in the bin over the bin's width (method of planes, averaged).
    """
    thrust = np.zeros(len(edges) - 1)
    low, width = float(edges[0]), float(edges[-1] - edges[0]) / len(thrust)
    _thrust(
        n=len(fx), x=np.array(x, float), first=contacts.first.astype(np.int64), second=contacts.second.astype(np.int64),
        fx=np.ascontiguousarray(fx), low=low, width=width, bins=len(thrust), thrust=thrust,
    )  # fmt: skip
    return thrust


@dataclass(frozen=True)
class ContactSums:
    """Sums over the pairs of a frame.

    Attributes
    ----------
    energy : float
        Elastic energy, J/m.
    contacts : int
    thrust : ndarray, shape (bins,)
        Force passed on through vertical planes, averaged over each bin, N/m; positive in compression. It is the whole
        contact force along x: normal and friction, each with its sign.
    """

    energy: float
    contacts: int
    thrust: np.ndarray


def pair_sums(frame: Frame, flow: Flow, edges: np.ndarray | None = None) -> ContactSums:
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
    ContactSums
    """
    pairs = touching_pairs(frame, flow)
    thrust = np.zeros(0)
    if edges is not None:
        thrust = thrust_of(frame.x, pairs, whole_forces(frame, flow, pairs)[0], edges)
    return ContactSums(elastic_energy(pairs, flow), len(pairs.first), thrust)


@dataclass(frozen=True)
class WallSums:
    """Forces and energies of one wall on the discs of a frame.

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

    The force is that of `whole_forces`: spring, dashpot and friction.
    """
    pairs = wall_contacts(frame, wall, flow)
    fx, fy = whole_forces(frame, flow, pairs, velocity=velocity)
    sideways = bool(np.any(np.abs(pairs.nx) > 1e-9))
    return WallSums(elastic_energy(pairs, flow), (float(fx.sum()), float(fy.sum())), pairs.second, fx, fy, sideways)


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
        """Adds a frame; its elastic energy is in ``latest`` until the next one."""
        flow, edges = self.flow, self.edges
        pairs = pair_sums(frame, flow, edges)
        self.latest = pairs.energy
        push = np.zeros_like(pairs.thrust)
        for wall in walls_of(frame, flow):
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


_close_pairs = function("jump_close_pairs", INTEGER, REALS, REALS, REAL, SHORTS, SHORTS, INTEGER, result=INTEGER)


def close_pairs(x: np.ndarray, y: np.ndarray, reach: float) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of points closer than `reach`, each once; points at one place are no pair (nothing says which way).

    Parameters
    ----------
    x, y : ndarray of float64, contiguous, shape (n,), m
    reach : float
        m.

    Returns
    -------
    first, second : ndarray of int32, shape (pairs,)
        Without the core in another order, and a pair may be reversed.
    """
    if core() is None:
        return _pairs_of_tree(x, y, reach)
    size = 4 * x.size
    while True:
        first, second = np.empty(size, np.int32), np.empty(size, np.int32)
        count = _close_pairs(x.size, x, y, reach, first, second, size)
        if count <= size:
            return first[:count], second[:count]
        size = count


def _pairs_of_tree(x: np.ndarray, y: np.ndarray, reach: float) -> tuple[np.ndarray, np.ndarray]:
    from scipy.spatial import cKDTree  # 0.2 s

    pairs = (
        cKDTree(np.column_stack([x, y])).query_pairs(reach, output_type="ndarray") if x.size else np.empty((0, 2), int)
    )
    first, second = pairs[np.lexsort(pairs.T[::-1])].T.astype(np.int32)
    distance2 = (x[second] - x[first]) ** 2 + (y[second] - y[first]) ** 2
    kept = (distance2 < reach * reach) & (distance2 > 0.0)
    return first[kept], second[kept]
