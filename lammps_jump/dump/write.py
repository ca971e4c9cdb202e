# SPDX-License-Identifier: GPL-2.0-or-later
"""Writer of LAMMPS dumps, byte for byte as ``dump custom`` writes them; and a slice of a dump in three dimensions.

Checked against files of LAMMPS 22Jul2025: see ``tests/dump/test_read.py``.
"""

from __future__ import annotations

import gzip
import struct
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from lammps_jump.errors import CaseError, DumpError
from lammps_jump.files import DUMP_NAMES, open_to_write, writes
from lammps_jump.scene.scene import Scene

from .frame import Frame, make_frame
from .read import open_dump

INTEGER_COLUMNS = frozenset({"id", "mol", "type", "proc", "procp1", "ix", "iy", "iz"})
"""Columns that LAMMPS writes as integers in text."""
BOUNDARY = "ff ff pp"
"""LAMMPS' boundary of each axis: discs leave the box along x and y, and are in one plane."""


class DumpWriter:
    """Writes frames one by one; use it in a ``with`` block.

    Parameters
    ----------
    path : str or Path
    columns : sequence of str
        Names in order, ``id`` first by custom.
    fmt : {'text', 'gz', 'binary'}
    precision : str
        Format of a float in text; ``%.17g`` keeps every bit. LAMMPS' own default is ``%g``.
    units : str or None
        Unit style, written with the first frame; None leaves it out.
    append : bool
        Write after the frames that the file holds (gzip: as a further member, which readers take as one stream).

    Raises
    ------
    DumpError
        A format that is not one of the three, or a path that cannot be written.
    """

    def __init__(
        self,
        path: str | Path,
        columns: Sequence[str],
        fmt: str = "text",
        precision: str = "%.10g",
        *,
        units: str | None = "si",
        append: bool = False,
    ):
        if fmt not in ("text", "gz", "binary"):
            raise DumpError(f"format '{fmt}' of {path}: it must be text, gz or binary.")
        if not columns or len(set(columns)) < len(columns):
            raise DumpError(f"columns {list(columns)} of {path}: each name once, at least one.")
        self.path, self.columns, self.fmt = Path(path), tuple(columns), fmt
        self.units = units
        self._row = " ".join("%d" if name in INTEGER_COLUMNS else precision for name in self.columns) + "\n"
        self._first = not append
        with writes(path):
            self._out = open_to_write(path, append=append)
        # mtime 0: the same run gives the same bytes
        packed = gzip.GzipFile(fileobj=self._out, mode="wb", compresslevel=4, mtime=0) if fmt == "gz" else None
        self._file = packed or self._out

    def __enter__(self) -> DumpWriter:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Finish the file."""
        self._file.close()
        self._out.close()

    def write_frame(self, frame: Frame) -> None:
        """Write a frame, which has at least the columns of this writer, and hand it to the system for readers."""
        missing = [name for name in self.columns if name not in frame.columns]
        if missing:
            has = " ".join(frame.columns)
            raise DumpError(f"{self.path}: step {frame.step} lacks column {missing[0]!r}; it has {has}.")
        values = np.column_stack([frame.columns[name] for name in self.columns])
        encoded = self._binary if self.fmt == "binary" else self._text
        self._file.write(encoded(frame, values, self.units or "" if self._first else ""))
        self._first = False
        self._file.flush()

    def _text(self, frame: Frame, values: np.ndarray, units: str) -> bytes:
        head = f"ITEM: UNITS\n{units}\n" if units else ""
        if frame.time is not None:
            head += f"ITEM: TIME\n{frame.time:.16g}\n"
        head += f"ITEM: TIMESTEP\n{frame.step}\nITEM: NUMBER OF ATOMS\n{len(values)}\n"
        head += f"ITEM: BOX BOUNDS {BOUNDARY}\n"
        head += "".join(f"{low:.16e} {high:.16e}\n" for low, high in frame.box)
        head += f"ITEM: ATOMS {' '.join(self.columns)}\n"
        return (head + (self._row * len(values)) % tuple(values.ravel().tolist())).encode()

    def _binary(self, frame: Frame, values: np.ndarray, units: str) -> bytes:
        count, width = values.shape
        names, codes = " ".join(self.columns).encode(), ("pf".index(letter) for letter in BOUNDARY.replace(" ", ""))
        # length of the signature, signature, byte order, revision, step, discs, tilt, boundaries, box, columns, units
        head = struct.pack("<q10siiqqi", -10, b"DUMPCUSTOM", 1, 2, frame.step, count, 0)
        head += struct.pack("<6i6dii", *codes, *frame.box.ravel(), width, len(units)) + units.encode()
        clock = b"\0" if frame.time is None else struct.pack("<bd", 1, frame.time)
        tail = struct.pack("<i", len(names)) + names + struct.pack("<ii", 1, values.size)
        return head + clock + tail + values.astype("<f8").tobytes()


def run_writer(folder: Path, scene: Scene, dump_format: str = "text", *, append: bool = False) -> DumpWriter:
    """Writer of the dump of a run: id x y vx vy, omegaz where discs spin, radius where they are not equal.

    Parameters
    ----------
    folder : Path
        Run folder.
    scene : Scene
    dump_format : {'text', 'gz', 'binary'}
        Of `files.DUMP_NAMES`; text has 10 digits, binary is LAMMPS' revision 2.
    append : bool
        Write after the frames that are there.

    Raises
    ------
    CaseError
        A format that is not known.
    """
    if dump_format not in DUMP_NAMES:
        raise CaseError(f"dump format {dump_format!r} is not known: use one of {', '.join(DUMP_NAMES)}")
    return DumpWriter(folder / DUMP_NAMES[dump_format], scene.dump_columns, dump_format, append=append)


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
