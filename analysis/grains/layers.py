# SPDX-License-Identifier: GPL-2.0-or-later
"""Profiles over y in a stretch of x: velocity, packing, temperature, stress, inertial number, layer by layer.

A disc counts in a layer with the share of its area there. The branch of a contact counts with the share of its length
there (to a wall it ends at the wall), which keeps the stress exact in the mean of the layer: sigma = sum of F l / A.
Definitions: da Cruz, Emam, Prochnow, Roux & Chevoir 2005, Phys. Rev. E 72, 021309; I and mu with P = sigma_yy.
"""

# ruff: noqa: RUF001  (Greek letters, minus signs and dashes are meant for readers)
from __future__ import annotations

from dataclasses import dataclass, field
from math import ceil, nan
from typing import Any

import numpy as np

from lammps_jump.analysis.contacts import ContactCollector, touching, whole_forces
from lammps_jump.analysis.draw.chart import Chart, Drawings, Panel, Trace
from lammps_jump.analysis.flow import Flow
from lammps_jump.analysis.passes import Gathered, Tables
from lammps_jump.analysis.profiles import FrameDiscs, shares, window_of, within
from lammps_jump.analysis.quantity import HeadlineNumber, Quantity
from lammps_jump.analysis.report.page import Section, Table, described
from lammps_jump.core.library import INTEGER, INTEGERS, REALS, core, entry
from lammps_jump.dump.frame import Frame
from lammps_jump.errors import DumpError
from lammps_jump.scene.walls import Interval
from lammps_jump.units import known, number

MOST_LAYERS = 5000
HEIGHT = 2.0
"""Height of a layer in diameters, where the case gives none."""
THIN = 0.1
"""Solid fraction below which single discs fly: I and mu mean nothing there, and are left out."""
AREA, MASS, U, V, Y, UU, VV, UV, UY, VY, YY, FXX, FXY, FYX, FYY = range(15)
"""Rows of the sums of a layer: area of discs (m^2); mass (kg/m), alone and times velocities and places; F l (N)."""

_add_discs = entry(
    "jump_layers_discs", n=INTEGER, x=REALS, y=REALS, u=REALS, v=REALS, radius=REALS, mass=REALS, numbers=REALS,
    layers=INTEGER, sums=REALS,
)  # fmt: skip
_add_contacts = entry(
    "jump_layers_contacts", n=INTEGER, x=REALS, y=REALS, count=INTEGER, first=INTEGERS, second=INTEGERS, contact=REALS,
    numbers=REALS, layers=INTEGER, sums=REALS,
)  # fmt: skip


@dataclass(frozen=True)
class LayerProfiles:
    """Profiles over y in a stretch of x, means of the window; `shear_rate` … are by mass over all layers with discs."""

    layers: int = number("", "layers with discs", default=0)
    height: float = number("m", "height of a layer", default=nan)
    begin: float = number("m", "begin of the stretch of x", default=nan)
    end: float = number("m", "end of the stretch of x", default=nan)
    frames: int = number("", "frames of the window", default=0)
    packing: float = number("", "solid fraction, mean by mass", default=nan, label="solid fraction")
    velocity: float = number("m/s", "velocity along x, mean by mass", default=nan, label="mean velocity")
    fastest: float = number("m/s", "largest velocity along x of a layer", default=nan)
    inertial_number: float = number("", "inertial number I, mean by mass", default=nan, label="inertial number")
    friction: float = number("", "effective friction μ = τ/P, mean by mass", default=nan, label="effective friction")
    change: float = number(
        "", "mean velocity of the second half of the window over that of the first, less one", default=nan
    )
    pressure: float = number("Pa", "normal stress of the lowest layer", default=nan)
    reason: str | None = None
    profile: Profile | None = field(default=None, metadata={"summary": False})


@dataclass(frozen=True)
class Profile:
    """Layer by layer, shape (layers,) each; NaN where a layer holds no disc.

    Attributes
    ----------
    y : ndarray, m
        Middle of the layer.
    velocity, velocity_y : ndarray, m/s
    packing : ndarray
        Area of discs, pi d^2/4 each, over that of the layer.
    temperature : ndarray, m^2/s^2
        Half of the mean square of the velocities about the mean of the layer, its shear taken off.
    shear_rate : ndarray, 1/s
        Between the middles of mass of the layers.
    stress_xx, stress_yy, stress_xy : ndarray, Pa
        Contacts and fluctuations; pressure is positive, xy positive where the upper layer drags the lower along x.
    contact_share : ndarray
        Share of the contacts in stress_yy.
    inertial_number, friction : ndarray
        I = shear rate times root of (m/P), and mu = stress_xy/P, with P = stress_yy.
    """

    y: np.ndarray
    velocity: np.ndarray
    velocity_y: np.ndarray
    packing: np.ndarray
    temperature: np.ndarray
    shear_rate: np.ndarray
    stress_xx: np.ndarray
    stress_yy: np.ndarray
    stress_xy: np.ndarray
    contact_share: np.ndarray
    inertial_number: np.ndarray
    friction: np.ndarray


@dataclass(frozen=True)
class Sums:
    """Sums of each frame: times (s), shape (frames,), and sums, shape (frames, 15, layers); `edges` of layers, m."""

    time: np.ndarray
    sums: np.ndarray
    edges: np.ndarray
    stretch: Interval
    stressed: bool


def stretch_of(flow: Flow) -> Interval:
    """The stretch of x that the flow asks for, else the middle half of the studied range, m."""
    low, high = flow.x_range
    stretch = flow.layers[0] if flow.layers else None
    return stretch or (low + 0.25 * (high - low), high - 0.25 * (high - low))


def edges_of_layers(flow: Flow, stretch: Interval) -> np.ndarray:
    """Edges of the layers, from the lowest bed in the stretch to the top of the domain, m.

    Raises
    ------
    DumpError
        Too many layers.
    """
    height = (flow.layers[1] if flow.layers else None) or HEIGHT * flow.scene.diameter
    bed = flow.bed_height(np.linspace(*stretch, 201)[1:-1])
    low, high = flow.scene.domain[1]
    low = float(np.nanmin(bed)) if np.isfinite(bed).any() else low
    count = max(1, ceil((high - low) / height - 1e-9))
    if count > MOST_LAYERS:
        raise DumpError(
            f"analysis.layers.height = {height:zg} m makes {count} layers of {high - low:zg} m; at most {MOST_LAYERS}: "
            "raise it."
        )
    return low + height * np.arange(count + 1)


class LayerSums:
    """Collects the sums of the layers frame by frame."""

    sees = "images"

    def __init__(self, flow: Flow, _: ContactCollector | None = None):
        self.flow, self.stretch = flow, stretch_of(flow)
        self.edges = edges_of_layers(flow, self.stretch)
        self._times: list[float] = []
        self._sums: list[np.ndarray] = []

    def add(self, frame: Frame, time: float) -> None:
        """Take in a frame at a time, s."""
        flow, sums = self.flow, np.zeros((15, len(self.edges) - 1))
        where = np.array([*self.stretch, self.edges[0], self.edges[1] - self.edges[0]])
        if frame.n:
            mass = flow.scene.mass * flow.relative_masses(frame)
            discs = FrameDiscs.of(frame.x, frame.y, frame.vx, frame.vy, flow.radii(frame), mass)
            add_discs(discs, where, sums)
            if flow.knows_contacts:
                pairs = touching(frame, flow)
                fx, fy = whole_forces(frame, flow, pairs)
                reach = discs.radius[pairs.second] - pairs.overlap
                contacts = np.column_stack([pairs.nx, pairs.ny, reach, fx, fy])
                first, second = pairs.first.astype(np.int64), pairs.second.astype(np.int64)
                _add_contacts(
                    n=frame.n, x=discs.x, y=discs.y, count=len(contacts), first=first, second=second, contact=contacts,
                    numbers=where, layers=sums.shape[1], sums=sums,
                )  # fmt: skip
        self._times.append(time)
        self._sums.append(sums)

    def result(self) -> Sums:
        """The sums of all frames."""
        sums = np.array(self._sums).reshape(-1, 15, len(self.edges) - 1)
        self._sums.clear()
        return Sums(np.array(self._times), sums, self.edges, self.stretch, self.flow.knows_contacts)


def add_discs(discs: FrameDiscs, where: np.ndarray, sums: np.ndarray) -> None:
    """Add discs to the sums of the layers; `where` holds begin and end in x, lowest edge and height of a layer, m.

    At the ends of the stretch the share in x times that in y replaces the share of the area in both. The mass of
    `discs` is in kg/m.
    """
    layers, (x, y, u, v, radius, mass) = sums.shape[1], discs
    if core() is not None:
        _add_discs(n=len(x), x=x, y=y, u=u, v=v, radius=radius, mass=mass, numbers=where, layers=layers, sums=sums)
        return
    begin, end, low, height = where
    place, share = shares(x, radius, begin, end - begin, 1)
    across = np.where(place == 1, share, 0.0).sum(axis=0)
    place, up = shares(y, radius, low, height, layers)
    part = across * up
    m = part * mass
    rows = (
        part * np.pi * radius * radius,
        m,
        m * u,
        m * v,
        m * y,
        m * u * u,
        m * v * v,
        m * u * v,
        m * u * y,
        m * v * y,
    )
    for row, weight in enumerate((*rows, m * y * y)):
        sums[row] += np.bincount(place.ravel(), weight.ravel(), layers + 2)[1:-1]


def profile_of(layer_sums: Sums, inside: np.ndarray, flow: Flow) -> Profile:
    """Profile of the mean of some frames, up to the highest layer with discs.

    Parameters
    ----------
    layer_sums : Sums
    inside : ndarray of bool, shape (frames,)
    flow : Flow
    """
    sums = layer_sums.sums[inside].mean(axis=0)
    count = 1 + int(np.flatnonzero(sums[MASS] > 0).max(initial=0))
    sums, edges = sums[:, :count], layer_sums.edges[: count + 1]
    area = (layer_sums.stretch[1] - layer_sums.stretch[0]) * (edges[1] - edges[0])
    with np.errstate(divide="ignore", invalid="ignore"):
        u, v, y, uu, vv, uv, uy, vy, yy = np.where(sums[MASS] > 0, sums[U : YY + 1] / sums[MASS], nan)
        shear, spread = _slopes(y, u), yy - y * y
        # velocities about the mean of the layer at the height of each disc
        along = uu - u * u - 2 * shear * (uy - u * y) + shear * shear * spread
        mixed = uv - u * v - shear * (vy - v * y)
        across = vv - v * v
        kinetic = sums[MASS] / area * np.array([along, across, mixed])
        contact = np.array([sums[FXX], sums[FYY], 0.5 * (sums[FXY] + sums[FYX])]) / area
        contact = contact if layer_sums.stressed else np.full_like(contact, nan)
        xx, yy_, xy = contact + kinetic
        packing = sums[AREA] / area
        pressure = np.where((yy_ > 0) & (packing >= THIN), yy_, nan)
        inertial = np.abs(shear) * np.sqrt(flow.scene.mass / pressure)
        return Profile(
            0.5 * (edges[1:] + edges[:-1]), u, v, packing, np.maximum(0.5 * (along + across), 0.0), shear,
            xx, yy_, -xy, contact[1] / pressure, inertial, np.abs(xy) / pressure,
        )  # fmt: skip


def _slopes(y: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Slope of u over y, both of shape (n,), without the gaps; 0 for a single layer."""
    there = np.isfinite(u)
    slopes = np.full(len(u), nan)
    slopes[there] = np.gradient(u[there], y[there]) if there.sum() > 1 else 0.0
    return slopes


def analyse(gathered: Gathered) -> LayerProfiles:
    """Profiles over the layers of a run, of the frames in its window."""
    flow, layer_sums = gathered.flow, gathered.histories["layers"]
    assert isinstance(layer_sums, Sums)
    inside = within(layer_sums.time, window_of(gathered.profiles))
    unknown = inside & np.isnan(layer_sums.sums[:, U]).any(axis=1)  # a disc without a velocity lies in a layer
    about: dict[str, Any] = {
        "height": float(layer_sums.edges[1] - layer_sums.edges[0]),
        "begin": layer_sums.stretch[0],
        "end": layer_sums.stretch[1],
    }
    if not layer_sums.sums[inside, MASS].any():
        return LayerProfiles(**about, reason="no disc is in the stretch within the window")
    if unknown.all(where=inside):
        return LayerProfiles(**about, reason="every frame of the window has a disc whose velocity is not known")
    inside &= ~unknown
    profile = profile_of(layer_sums, inside, flow)
    mass = layer_sums.sums[inside, MASS].mean(axis=0)[: len(profile.y)]
    return LayerProfiles(
        layers=int((mass > 0).sum()),
        **about,
        frames=int(inside.sum()),
        packing=_by_mass(profile.packing, mass),
        velocity=_by_mass(profile.velocity, mass),
        fastest=float(profile.velocity[np.nanargmax(np.abs(profile.velocity))]),
        inertial_number=_by_mass(profile.inertial_number, mass),
        friction=_by_mass(profile.friction, mass),
        change=_change(layer_sums.sums[inside]),
        pressure=float(profile.stress_yy[np.flatnonzero(mass > 0)[0]]),
        reason=None if layer_sums.stressed else f"no stress: {flow.no_contacts}",
        profile=profile,
    )


def _change(sums: np.ndarray) -> float:
    """Mean velocity of the second half of the frames over that of the first, less one; NaN where that is none."""
    parts = np.array_split(sums, 2) if len(sums) > 1 else []
    means = [float(part[:, U].sum() / part[:, MASS].sum()) for part in parts if part[:, MASS].any()]
    return means[1] / means[0] - 1.0 if len(means) == 2 and means[0] else nan


def _by_mass(values: np.ndarray, mass: np.ndarray) -> float:
    there = np.isfinite(values) & (mass > 0)
    return float(np.average(values[there], weights=mass[there])) if there.any() else nan


def tables(layers: LayerProfiles) -> Tables:
    """The profile, a row a layer."""
    return {} if layers.profile is None else {"layers.csv": vars(layers.profile)}


def figures(layers: LayerProfiles, gathered: Gathered) -> Drawings:
    """Velocity, packing, stress and inertial number over the height."""
    profile = layers.profile
    if profile is None:
        return {}
    y, scale = profile.y, 1e3
    panels = [
        Panel("Velocity u\nalong x [m/s]", [Trace("", y, profile.velocity)]),
        Panel("Solid\nfraction", [Trace("", y, profile.packing)], ylim=(0.0, None)),
        Panel("Granular\ntemperature\n[m²/s²]", [Trace("", y, profile.temperature)], ylim=(0.0, None)),
    ]
    if np.isfinite(profile.stress_yy).any():
        stresses = (
            Trace("σ_yy", y, profile.stress_yy / scale),
            Trace("σ_xx", y, profile.stress_xx / scale, "second"),
            Trace("τ", y, profile.stress_xy / scale, "third"),
        )
        panels.append(Panel("Stress [kPa]", stresses))
        panels.append(Panel("Inertial\nnumber I", [Trace("", y, profile.inertial_number)], ylim=(0.0, None)))
        panels.append(Panel("Friction\nμ = |τ|/σ_yy", [Trace("", y, profile.friction)], ylim=(0.0, None)))
    stretch = f"x = {layers.begin:z.3g} … {layers.end:z.3g} m"
    return {"layers": Chart(f"layers, {stretch}", "Height y [m]", panels)}


def section(layers: LayerProfiles) -> Section:
    """Section on the layers: where they are, and their means."""
    if not layers.layers:
        return Section("Layers", [])
    keys = ("begin", "end", "height", "layers", "packing", "velocity", "fastest")
    more = [key for key in ("pressure", "inertial_number", "friction") if known(getattr(layers, key))]
    return Section("Layers", [Table(described(layers, *keys, *more))])


QUANTITY = Quantity(
    name="layers",
    title="Layers",
    result=LayerProfiles,
    definitions="""\
layer         discs count with the share of their area in it, contacts with that of the line between the centres
packing       π d²/4 of the discs over the area of the layer
temperature   half of the mean square of the velocities about the mean of the layer, the shear taken off, m²/s²
stress        σ = (∑ F l + ∑ m v′ v′)/area, contacts and fluctuations; τ = −σ_xy: the upper layer drags the lower
I, μ          γ̇ √(m/P) = γ̇ d √(ρ/P) and |τ|/P, with P = σ_yy
""",
    collector=LayerSums,
    analyse=analyse,
    files={"layers.csv": "profiles over the height"},
    captions={"layers": "Profiles over the height, mean of the window"},
    tables=tables,
    figures=figures,
    section=section,
    headline=(
        HeadlineNumber("inertial_number"),
        HeadlineNumber("friction"),
        HeadlineNumber("packing"),
        HeadlineNumber("velocity"),
    ),
    rank=80,
)
