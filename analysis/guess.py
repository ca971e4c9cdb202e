# SPDX-License-Identifier: GPL-2.0-or-later
"""Flow of a bare dump: what is not given is guessed, and every guess is noted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from math import cos, nan, radians, sin

import numpy as np

from lammps_jump.dump.frame import Frame, require_finite
from lammps_jump.dump.read import Dump
from lammps_jump.errors import DumpError
from lammps_jump.physics.contact import Coefficients
from lammps_jump.quoting import visible
from lammps_jump.scene.scene import Scene
from lammps_jump.scene.walls import Interval, Plane, Wall

from .flow import Flow


def from_dump(
    dump: Dump,
    *,
    name: str | None = None,
    diameter: float | None = None,
    density: float | None = None,
    mass: float | None = None,
    gravity: float | tuple[float, float] | None = None,
    slope: float = 0.0,
    floor: float | None = None,
    walls: Sequence[Wall] | None = None,
    x_range: Interval | None = None,
    bin_width: float | None = None,
    window: tuple[float, float] | None = None,
    stiffness: float | None = None,
    stiffness_wall: float | None = None,
    time_step: float | None = None,
) -> Flow:
    """Flow of a bare dump; what is not given is guessed, and said so in ``notes``.

    Parameters
    ----------
    dump : Dump
    diameter : float, optional
        m, of all discs; default from a ``radius`` or ``diameter`` column, else the 1 % quantile of nearest-neighbour
        distances of the frame with the most discs (a lower bound where discs overlap, too large in a dilute gas).
        Where the column's values differ each disc has its own; the nominal diameter is then that of the mean mass.
    density, mass : float, optional
        kg/m^3 (default 1000) and kg per metre of width (default a ``mass`` column, else density diameter^2).
        With unequal discs, of the nominal one: masses go with the square of the diameter.
    gravity : float or (float, float), optional
        Default 9.81 m/s^2 downwards, tilted by `slope` degrees (the flow runs down towards larger x).
    floor : float, optional
        Height of a level floor, m; default the lowest disc's lower edge in any frame looked at. Not used with `walls`.
    walls : sequence of Wall, optional
    stiffness, stiffness_wall : float, optional
        N/m; without them no elastic energy and no contact stress.
    time_step : float, optional
        s, for dumps without ``ITEM: TIME``.

    Raises
    ------
    DumpError
        A dump without any disc, or a value that is not positive.
    """
    given = (("diameter", diameter), ("density", density), ("mass", mass), ("time_step", time_step))
    for what, value in (*given, ("stiffness", stiffness), ("bin_width", bin_width)):
        if value is not None and not (np.isfinite(value) and value > 0):
            raise DumpError(f"{what} = {value}: it must be a number above 0.")
    notes: list[str] = []
    headers = dump.headers()
    if not any(header.n for header in headers):
        raise DumpError(f"{dump.path}: no frame holds a disc; there is nothing to analyse.")
    fullest = max(range(len(headers)), key=lambda i: headers[i].n)
    frames = list(dump.select({0, fullest, len(headers) - 1}))
    for looked_at in frames:
        require_finite(looked_at, dump.path)
    frame = max(frames, key=lambda f: f.n)
    sized = diameter is None and _differ(frame)
    if diameter is None:
        diameter = _guess_diameter(frame, notes)
    if density is None:
        density = 1000.0
        notes.append("Density taken as 1000 kg/m3.")
    if mass is None and "mass" in frame.columns:
        mass = float(np.mean(frame.columns["mass"]) if sized else np.median(frame.columns["mass"]))
        notes.append(f"Mass {mass:.6g} kg from the dump's mass column ({'mean' if sized else 'median'}).")
    elif mass is None:
        mass = density * diameter**2
        notes.append(f"Mass taken as density x diameter^2 = {mass:.6g} kg per metre of width.")
    if gravity is None:
        gravity = 9.81
        notes.append("Gravity taken as 9.81 m/s2.")
    if np.isscalar(gravity):
        gravity = (gravity * sin(radians(slope)), -gravity * cos(radians(slope)))
    occupied = [(f, f.radii if sized else 0.5 * diameter) for f in frames if f.n]
    if walls is None:
        if floor is None:
            floor = float(min((f.y - radius).min() for f, radius in occupied))
            notes.append(f"Floor taken at y = {floor:.6g} m: the lower edge of the lowest disc looked at.")
        walls = (Plane("floor", "y", floor, "above"),)
    if x_range is None:
        low, high = min((f.x - r).min() for f, r in occupied), max((f.x + r).max() for f, r in occupied)
        x_range = (float(low), float(high))
        notes.append(f"Profiles from x = {x_range[0]:.6g} to {x_range[1]:.6g} m: as far as discs were seen.")
    if all(header.time is None for header in headers) and time_step is None:
        notes.append("The dump carries no times and no time step was given: times are step numbers.")
    at_wall = stiffness if stiffness_wall is None else stiffness_wall
    known = {"mass": mass, "stiffness": stiffness, "stiffness_wall": at_wall, "time_step": time_step}
    scene = Scene(
        name=name or visible(dump.path.name.split(".")[0]),
        description="",
        diameter=float(diameter),
        density=float(density),
        gravity=(float(gravity[0]), float(gravity[1])),
        coefficients=known_coefficients(**known),
        friction_law="hooke",
        rotation=False,
        integrator="velocity_verlet",
        domain=tuple((float(low), float(high)) for low, high in frame.box[:2]),
        positions=np.empty((0, 2)),
        velocities=np.empty((0, 2)),
        walls=tuple(walls),
    )
    return Flow(scene, x_range, bin_width or 5 * scene.diameter, window, notes=tuple(notes), sized=sized)


def known_coefficients(**known: float | None) -> Coefficients:
    """Contact coefficients of which only some are known: NaN for the others, 0 for dashpots and friction."""
    values = {field.name: nan for field in fields(Coefficients)}
    values |= dict.fromkeys(("friction", *(name for name in values if name.startswith("gamma"))), 0.0)
    return Coefficients(**values | {name: float(value) for name, value in known.items() if value is not None})


def _differ(frame: Frame) -> bool:
    """Whether the file tells radii that differ."""
    return frame.radii is not None and bool(np.ptp(frame.radii) > 1e-6 * np.max(frame.radii))


def _guess_diameter(frame: Frame, notes: list[str]) -> float:
    if frame.radii is not None:
        sizes = 2 * frame.radii
        notes.append(f"Diameter from the dump's {'radius' if 'radius' in frame.columns else 'diameter'} column.")
        if not _differ(frame):
            return float(np.mean(sizes))
        notes.append(
            f"Discs differ in size ({sizes.min():.6g} to {sizes.max():.6g} m): each has its own; the nominal diameter "
            "is that of the mean mass."
        )
        return float(np.sqrt(np.mean(sizes**2)))
    if frame.n < 2:
        raise DumpError("one disc and no diameter or radius column: give the diameter.")
    from scipy.spatial import cKDTree

    points = np.column_stack([frame.x, frame.y])
    nearest = cKDTree(points).query(points, k=2)[0][:, 1]
    diameter = float(np.quantile(nearest, 0.01))
    if not diameter > 0:
        raise DumpError("discs lie on top of each other: the diameter cannot be guessed; give it.")
    notes.append(f"Diameter guessed as {diameter:.6g} m: 1 % quantile of nearest-neighbour distances.")
    return diameter
