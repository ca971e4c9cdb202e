# SPDX-License-Identifier: GPL-2.0-or-later
"""A slice of a dump of three dimensions: the bodies whose centres lie near a plane, as a dump of one layer."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from lammps_jump.dump.frame import Frame, make_frame
from lammps_jump.dump.read import open_dump
from lammps_jump.dump.write import DumpWriter
from lammps_jump.errors import CaseError, DumpError

AXES = {"x": ("y", "z"), "y": ("x", "z"), "z": ("x", "y")}
"""Normal of the plane -> what becomes x and y of the slice: z is up, or y in a plane across z."""
KEPT = ("id", "type", "radius", "diameter", "mass")


def write_slice(source: Path, normal: str, at: float, out: Path, thickness: float | None = None) -> tuple[int, float]:
    """Write a slice of a dump as a dump; the largest number of bodies of a frame, and the thickness, m.

    Parameters
    ----------
    source : Path
    normal : {'x', 'y', 'z'}
        Axis across the plane.
    at : float
        Place of the plane along it, m.
    out : Path
        Must not be there.
    thickness : float, optional
        m; default the largest diameter in the dump.

    Raises
    ------
    CaseError, DumpError
        The file is there, no column z, no radius and no thickness, or no body near the plane.
    """
    if out.exists():
        raise CaseError(f"{out}: is there already; name another file with --out")
    dump = open_dump(source)
    frames = [frame for frame in dump if frame.n]
    if not frames or frames[0].z is None:
        raise DumpError(f"{source}: has no column z, so that nothing can be cut; write it with 'dump … custom … z'.")
    if thickness is None:
        sizes = [float(frame.radii.max()) for frame in frames if frame.radii is not None]
        if not sizes:
            raise DumpError(f"{source}: has no radius column; give the thickness of the slice (--thickness).")
        thickness = 2 * max(sizes)
    cut = [_cut(frame, normal, at, thickness) for frame in frames]
    most = max(frame.n for frame in cut)
    if not most:
        low, high = _ends(frames, normal)
        raise DumpError(
            f"{source}: no body lies within {0.5 * thickness:.4g} m of {normal} = {at:g} m; they run from "
            f"{normal} = {low:.4g} to {high:.4g} m."
        )
    with DumpWriter(out, tuple(cut[0].columns), units=dump.units or "si") as writer:
        for frame in cut:
            writer.write_frame(frame)
    return most, thickness


def _ends(frames: list[Frame], axis: str) -> tuple[float, float]:
    places = [getattr(frame, axis) for frame in frames]
    return min(float(some.min()) for some in places), max(float(some.max()) for some in places)


def _cut(frame: Frame, normal: str, at: float, thickness: float) -> Frame:
    """The bodies near a plane, their places and velocities in it."""
    along, up = AXES[normal]
    near = np.abs(np.asarray(getattr(frame, normal)) - at) <= 0.5 * thickness
    columns = {name: frame.columns[name] for name in KEPT if name in frame.columns}
    columns |= {"x": np.asarray(getattr(frame, along)), "y": np.asarray(getattr(frame, up))}
    for name, axis in (("vx", along), ("vy", up)):
        if f"v{axis}" in frame.columns:
            columns[name] = frame.columns[f"v{axis}"]
    box = frame.box[["xyz".index(axis) for axis in (along, up)]]
    return make_frame(frame.step, frame.time, box, {name: values[near] for name, values in columns.items()})
