# SPDX-License-Identifier: GPL-2.0-or-later
"""Flow of a bare dump: what is not given is guessed, and every guess is noted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields
from itertools import pairwise
from math import ceil, nan
from pathlib import Path
from typing import Any

import numpy as np

from lammps_jump.dump.frame import Frame, require_finite, ten_indices
from lammps_jump.dump.read import Dump
from lammps_jump.errors import DumpError
from lammps_jump.physics import bodies
from lammps_jump.physics.contact import Coefficients
from lammps_jump.quoting import typed, visible
from lammps_jump.scene import Block, Interval, MovingWall, Plane, Scene

from .flow import Flow, radii_of

PACKED, CLOSE, AROUND = 20, 0.15, 1.5
"""So many discs are packed where half of them have their third neighbour within 1.5 times the closest distance, which
may lie 15 % above a diameter that is given."""
GRAVITY = {"cgs": 981.0}
"""Gravity where none is given, by the units that a dump names; 9.81 m/s^2 of others."""
OF_CGS = (0.8, 20.0)
"""Densities of solids and water in g/cm3: a dump whose masses tell one is hardly in kg and m."""
LOOSE = 1.03
"""Half of the discs have no neighbour within so many guessed diameters: equal discs touch, or these are dilute."""


def from_dump(
    dump: Dump,
    *,
    name: str | None = None,
    diameter: float | Mapping[int, float] | None = None,
    density: float | None = None,
    bin_width: float | None = None,
    time_step: float | None = None,
    kind: str | None = None,
    gravity: float | None = None,
) -> Flow:
    """Flow of a bare dump; what is not given is guessed, and said so in ``notes``.

    It has a level floor where most of the channel has its lowest discs, up to a place from which they fall, and gravity
    towards it. The stiffness stays unknown: there is no elastic energy and no contact stress.

    Parameters
    ----------
    dump : Dump
    diameter : float or mapping of int to float, optional
        m, of all discs or of each type; default from a ``radius`` or ``diameter`` column, else the 1 % quantile of
        nearest-neighbour distances of the frame with the most discs (a lower bound where discs overlap, too large in a
        dilute gas).
        Where diameters differ each disc has its own; the nominal diameter is then that of the mean mass.
    density : float, optional
        Of the material, kg/m^3. A ``mass`` column gives the mass, and with the diameters it tells the bodies; a density
        that fits neither is refused. Without that column the mass is that of the bodies, by default density diameter^2
        per metre of width, and the density 1000. Depths by mass count diameter^2 for each disc, whatever its mass.
    bin_width : float, optional
        m; default five diameters, or so that whole bins cover the floor.
    time_step : float, optional
        s, for dumps without ``ITEM: TIME``. Without either, steps replace the times, and nothing is made of them.
    kind : {'spheres', 'cylinders', 'discs'}, optional
        What masses are of, where masses and diameters do not tell it (`lammps_jump.physics.bodies`).
    gravity : float, optional
        m/s^2; default 9.81, and 981 of a dump that names the units cgs.

    Raises
    ------
    DumpError
        A dump without any disc, one of three dimensions, a value that is not positive, masses that fit no body.
    """
    types = dict(diameter) if isinstance(diameter, Mapping) else {}
    _require_positive("diameter", *(types.values() if isinstance(diameter, Mapping) else [diameter]))
    for what, value in (("density", density), ("time_step", time_step), ("bin_width", bin_width), ("gravity", gravity)):
        _require_positive(what, value)
    notes: list[str] = []
    frames = _looked_at(dump)
    frame = max(frames, key=lambda f: f.n)
    nominal, sized = _diameter(frame, diameter, notes)
    _require_a_plane(frames, nominal, dump.path)
    if diameter is not None and not types:
        _require_touch(frame, nominal, dump.path)

    def own_radii(one: Frame) -> Any:
        return radii_of(one, types) if sized else 0.5 * nominal

    diameters = np.broadcast_to(2 * own_radii(frame), frame.n)
    mass = _mass(frame, diameters, density, kind, notes)
    gravity = gravity or _gravity(dump, notes)
    edges = [_edges(f, own_radii(f)) for f in frames if f.n]
    left, low, right = (np.concatenate(part) for part in zip(*edges, strict=True))
    floor = _floor(left, low, right, 5 * nominal, 0.5 * nominal, notes)
    reach, width = _bins((float(left.min()), float(right.max())), floor, bin_width, 5 * nominal)
    notes.append(f"Profiles from x = {reach[0]:z.6g} to {reach[1]:z.6g} m: as far as discs were seen.")
    timed = _timed(dump, time_step, notes)
    return Flow(
        _scene(frame, name or visible(dump.path.name), nominal, mass, gravity, floor, time_step),
        reach,
        width,
        notes=tuple(notes),
        sized=sized,
        diameters=types if sized else {},
        timed=timed,
        velocities=timed or {"vx", "vy"} <= set(dump.columns),
    )


def _require_positive(what: str, *values: float | None) -> None:
    """DumpError where a value that is given is not a number above 0."""
    for value in values:
        if value is not None and not (np.isfinite(value) and value > 0):
            raise DumpError(f"{what} = {value}: it must be a number above 0.")


def _gravity(dump: Dump, notes: list[str]) -> float:
    """Gravity where none is given, by the units of a dump, m/s^2."""
    gravity = GRAVITY.get(dump.units or "", 9.81)
    notes.append(
        f"Gravity taken as {gravity:zg} m/s2, downward: Froude numbers, heads and times of rest hold where that is "
        "right in the dump's units. Give another one by --gravity."
    )
    return gravity


def _scene(
    frame: Frame, name: str, diameter: float, mass: float, gravity: float, floor: Plane | Block,
    time_step: float | None,
) -> Scene:  # fmt: skip
    """A scene of which no more is known than its discs in a frame, with a floor at rest."""
    (x_low, x_high), (y_low, y_high) = frame.box[:2].tolist()
    return Scene(
        name=name,
        description="",
        diameter=diameter,
        density=mass / diameter**2,  # of discs in squares: a depth by mass is one of the same discs
        gravity=(0.0, -gravity),
        coefficients=known_coefficients(mass=mass, time_step=time_step),
        friction_law="viscous",
        rotation=False,
        integrator="velocity_verlet",
        domain=((x_low, x_high), (y_low, y_high)),
        positions=np.empty((0, 2)),
        velocities=np.empty((0, 2)),
        walls=(MovingWall(floor),),
    )


def known_coefficients(**known: float | None) -> Coefficients:
    """Contact coefficients of which only some are known: NaN for the others, 0 for dashpots and friction."""
    values = {field.name: nan for field in fields(Coefficients)}
    values |= dict.fromkeys(("friction", *(name for name in values if name.startswith("gamma"))), 0.0)
    return Coefficients(**values | {name: float(value) for name, value in known.items() if value is not None})


def _looked_at(dump: Dump) -> list[Frame]:
    """Ten frames at equal times, the first and the last among them, and the one with the most discs."""
    headers = dump.headers()
    if not any(header.n for header in headers):
        raise DumpError(f"{dump.path}: no frame holds a disc; there is nothing to analyse.")
    fullest = max(range(len(headers)), key=lambda i: headers[i].n)
    return [require_finite(frame, dump.path) for frame in dump.select({*ten_indices(len(headers)), fullest})]


def _edges(frame: Frame, radius: np.ndarray | float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Left, lower and right edge of each disc, m."""
    return frame.x - radius, frame.y - radius, frame.x + radius


def _require_a_plane(frames: Sequence[Frame], diameter: float, path: Path) -> None:
    """DumpError where the discs of a frame lie further apart in z than a diameter, m."""
    for frame in frames:
        if not frame.n or frame.z is None:
            continue
        low, high = float(frame.z.min()), float(frame.z.max())
        if high - low > diameter:
            raise DumpError(
                f"{path}: step {frame.step}: z runs from {low:z.6g} to {high:z.6g} m, further than a diameter "
                f"({diameter:z.6g} m): this is a flow in three dimensions; allowed is one layer of discs. "
                f"`{typed('slice', path, f'z={0.5 * (low + high):z.3g}')}`, or y=… where z is up, writes a slice one "
                "diameter thick, which can be analysed."
            )


def _floor(
    left: np.ndarray, low: np.ndarray, right: np.ndarray, strip: float, slack: float, notes: list[str]
) -> Plane | Block:
    """The floor under discs of these edges, m: a level plane, or a block that ends where discs fall below it.

    In strips of the channel the lowest disc of all frames lies on what is below. The level at which most strips agree
    within the slack is the floor. Strips with a disc two strips' slack below it are a fall; those without a disc on the
    floor before the fall are a sill.
    """
    place = ((0.5 * (left + right) - left.min()) / strip).astype(int)
    lowest = np.full(place.max() + 1, np.inf)
    np.minimum.at(lowest, place, low)
    known = lowest[np.isfinite(lowest)]
    alike = (np.abs(known[:, None] - known) <= slack).sum(axis=1)
    most = known[alike == alike.max()].min()
    level = float(known[np.abs(known - most) <= slack].min())
    said = f"Floor taken at y = {level:z.6g} m: the lower edge of the lowest disc on it"
    floored, falls = (
        np.flatnonzero(chosen) for chosen in (np.abs(lowest - level) <= slack, lowest < level - 2 * slack)
    )
    if not falls.size or not floored.size:
        notes.append(f"{said}.")
        return Plane("floor", "y", level, "above")
    # the stretch between two falls that has the most strips on the floor
    ends = [-1, *falls, len(lowest)]
    stretches = [floored[(floored > first) & (floored < last)] for first, last in pairwise(ends)]
    stretch = max(stretches, key=len)
    on_it = (np.abs(low - level) <= slack) & (place >= stretch[0]) & (place <= stretch[-1])
    start = float(left[on_it].min() if falls[0] < stretch[0] else left.min())
    end = float(right[on_it].max() if falls[-1] > stretch[-1] else right.max())
    notes.append(f"{said}. It runs from x = {start:z.6g} to {end:z.6g} m; discs fall below it beyond.")
    return Block("floor", (start, end), (level - strip, level))


def _bins(seen: Interval, floor: Plane | Block, given: float | None, usual: float) -> tuple[Interval, float]:
    """The stretch of profiles and the width of their bins, m: a floor that ends is covered by whole bins."""
    if not floor.finite:
        return seen, given or usual
    start, end = floor.extent[0]
    width = given or (end - start) / max(1, round((end - start) / usual))
    return (start - ceil((start - seen[0]) / width) * width, seen[1]), width


def _timed(dump: Dump, time_step: float | None, notes: list[str]) -> bool:
    """Tells whether the times of the frames are known."""
    clocked = all(header.time is not None for header in dump.headers())
    if clocked and time_step is not None:
        notes.append("The dump carries its own times: the time step that was given is not used.")
    elif time_step is None and not clocked:
        notes.append(
            "The dump carries no times and no time step was given: step numbers stand in their place, and no speed of "
            "a front, Froude number or head is made. Give the time step (--time-step)."
        )
    if dump.units not in (None, "si"):
        notes.append(f"The dump is in LAMMPS' units '{visible(dump.units)}': its numbers are taken for m, s and kg.")
    return clocked or time_step is not None


def _mass(frame: Frame, diameters: np.ndarray, density: float | None, given: str | None, notes: list[str]) -> float:
    """Mean mass of a body, kg per metre of width: from the dump, else by density and diameter."""
    nominal, thickness = float(np.sqrt(np.mean(diameters**2))), float(np.mean(diameters))
    if "mass" not in frame.columns:
        if density is None:
            density = 1000.0
            notes.append("Density taken as 1000 kg/m3.")
        kind = given or "discs"
        mass = bodies.per_width(kind, bodies.mass_of(kind, nominal, density), nominal)
        formula = {"spheres": "density x π/6 x diameter^2", "cylinders": "density x π/4 x diameter^2"}
        notes.append(f"Mass taken as {formula.get(kind, 'density x diameter^2')} = {mass:z.6g} kg per metre of width.")
        return mass
    masses = frame.columns["mass"]
    mean = float(np.mean(masses))
    kinds, said = _bodies(masses, diameters, density, given)
    notes.append(f"Mass {mean:z.6g} kg from the dump's mass column (mean).")
    notes.append(said)
    return bodies.per_width(kinds[0], mean, thickness) if len(kinds) == 1 else mean


def _bodies(
    masses: np.ndarray, diameters: np.ndarray, density: float | None, given: str | None
) -> tuple[tuple[str, ...], str]:
    """Bodies of a dump, and a sentence on them.

    Raises
    ------
    DumpError
        Masses, diameters and what is given contradict each other.
    """
    densities = {kind: bodies.density_of(kind, masses, diameters) for kind in bodies.SHAPES}
    listed = ", ".join(f"{kind} of {value:z.4g} kg/m3" for kind, value in densities.items())
    fitting = bodies.kinds_that_fit(masses, diameters, density)
    if density is not None and (not fitting or (given and given not in fitting)):
        raise DumpError(
            f"density = {density:zg} kg/m3{f' of {given}' if given else ''}: masses of {np.mean(masses):z.4g} kg and "
            f"diameters of {np.mean(diameters):z.4g} m are those of {listed}. Give one of these densities, or none; "
            "or give the right diameter (--diameter)."
        )
    kinds = (given,) if given else fitting
    if not kinds:
        cgs = OF_CGS[0] <= densities["spheres"] <= OF_CGS[1]
        units = " In g and cm that is usual: numbers are taken for m, s and kg, so convert the dump." if cgs else ""
        return kinds, (
            f"Masses and diameters are of no body of one material ({listed}).{units} Say which with --bodies; until "
            "then masses count per metre of width. Depths hold: they count diameter^2 for each disc."
        )
    names = " or ".join(f"{kind} of {densities[kind]:z.4g} kg/m3" for kind in kinds)
    how = "as given" if given else "by mass and diameter"
    if "spheres" not in kinds:
        return kinds, f"Bodies: {names}, {how}; masses are per metre of width."
    if len(kinds) > 1:
        return kinds, (
            f"Bodies: {names}: masses and diameters fit these. Say which with --bodies spheres, cylinders or discs; "
            "until then masses count per metre of width. Depths hold: they count diameter^2 for each disc."
        )
    return kinds, (
        f"Bodies: {names}, {how}. Their layer is one mean diameter wide, and masses are per metre of that width."
    )


def _diameter(frame: Frame, diameter: float | Mapping[int, float] | None, notes: list[str]) -> tuple[float, bool]:
    """Nominal diameter, m, and whether discs differ in size."""
    types: Mapping[int, float] = {}
    if isinstance(diameter, Mapping):
        types = diameter
    elif diameter is not None:
        return float(diameter), False
    radii = radii_of(frame, types)
    if radii is None:
        return _guess_diameter(frame, notes), False
    if not types:
        notes.append(f"Diameter from the dump's {'radius' if 'radius' in frame.columns else 'diameter'} column.")
    sizes = np.array(list(types.values())) if types else 2 * radii
    if np.ptp(sizes) <= 1e-6 * np.max(sizes):
        return float(np.mean(sizes)), False
    notes.append(
        f"Discs differ in size ({sizes.min():z.6g} to {sizes.max():z.6g} m): each has its own; the nominal diameter "
        "is that of the mean mass."
    )
    return 2 * float(np.sqrt(np.mean(radii**2))), True


def _nearest(frame: Frame, neighbours: int = 1) -> np.ndarray:
    """Distances of each disc to the nearest ones, m, shape (n, neighbours); infinite where there are fewer."""
    from scipy.spatial import cKDTree

    points = np.column_stack([frame.x, frame.y])
    return cKDTree(points).query(points, k=neighbours + 1)[0][:, 1:]


def _require_touch(frame: Frame, diameter: float, path: Path) -> None:
    """DumpError where discs are packed, each with three others around it, further apart than a diameter (m)."""
    if frame.n < PACKED:
        return
    near = _nearest(frame, 3)
    closest = float(np.quantile(near[:, 0], 0.01))
    if closest > (1.0 + CLOSE) * diameter and float(np.median(near[:, 2])) <= AROUND * closest:
        raise DumpError(
            f"{path}: diameter = {diameter:zg} m: discs lie packed {closest:z.4g} m apart, with air between "
            f"discs of that size. Give their diameter (--diameter {closest:z.4g}), or leave it out."
        )


def _guess_diameter(frame: Frame, notes: list[str]) -> float:
    if frame.n < 2:
        raise DumpError("one disc and no diameter or radius column: give the diameter.")
    nearest = _nearest(frame)[:, 0]
    diameter = float(np.quantile(nearest, 0.01))
    if not diameter > 0:
        raise DumpError("discs lie on top of each other: the diameter cannot be guessed; give it.")
    notes.append(
        f"Diameter guessed as {diameter:z.6g} m: 1 % quantile of nearest-neighbour distances. All discs count as equal."
    )
    if (usual := float(np.median(nearest))) > LOOSE * diameter:
        notes.append(
            f"Half of the discs have no neighbour within {usual:z.6g} m. Where discs differ in size, the guess is that "
            "of the smallest, and mass depths are too small: write a radius column, or give the diameter (--diameter)."
        )
    return diameter
