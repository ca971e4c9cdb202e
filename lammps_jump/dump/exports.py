# SPDX-License-Identifier: GPL-2.0-or-later
"""Numbers for other programs: NetCDF, CSV tables, VTK for ParaView, the thesis' picture files."""

from __future__ import annotations

import base64
import io
import os
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lammps_jump.errors import DumpError
from lammps_jump.files import EXPORTS, MOST_TEXT, read_file, write_bytes, write_text, writes
from lammps_jump.folders import require_replaceable, standing
from lammps_jump.quoting import csv_cell, shortened, typed
from lammps_jump.scene.shapes import thin
from lammps_jump.scene.walls import Interval, Wall, parts_of

from .find import find_dump, read_dump
from .frame import Frame, ten_indices
from .read import Dump

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

BINARY = 'version="1.0" byte_order="LittleEndian" header_type="UInt64"'
"""Head by which VTK files with arrays say what is in them."""

THREADS = "KMP_DUPLICATE_LIB_OK"
"""Lets two OpenMP libraries into one process; a choice of the caller's."""


def write_table(table: Mapping[str, Sequence[Any]], path: str | Path, units: Mapping[str, str] | None = None) -> Path:
    """A table of equally long columns as CSV: names in the first line (``name [unit]``), 10 digits, empty for NaN.

    Parameters
    ----------
    table : mapping of name to values, shape (n,)
    path : str or Path
    units : mapping of name to unit, optional

    Raises
    ------
    DumpError
        Columns of different length, or a place that cannot be written.
    """
    import pandas as pd  # xarray needs it and brings it, 0.2 s

    units = units or {}
    heads = [f"{name} [{units[name]}]" if units.get(name) not in (None, "", "1") else name for name in table]
    try:
        columns = pd.DataFrame({name: without_minus_zero(values) for name, values in table.items()})
    except ValueError as error:
        raise DumpError(f"{path}: columns of a table must be equally long: {error}.") from error
    return _write(path, csv_text(columns.set_axis(heads, axis=1), float_format="%.10g"))


def without_minus_zero(values: Sequence[Any]) -> Any:
    """The values with 0 in place of -0."""
    numbers = np.asarray(values)
    return numbers + 0.0 if numbers.dtype.kind == "f" else values


def csv_text(table: pd.DataFrame, float_format: str | None = None) -> str:
    """A table as CSV; every text of it, heads too, goes through `quoting.csv_cell`."""
    from pandas.api.types import is_numeric_dtype

    cells = table.rename(columns=csv_cell)
    for place in [k for k, kind in enumerate(cells.dtypes) if not is_numeric_dtype(kind)]:
        cells.isetitem(place, cells.iloc[:, place].map(csv_cell))
    return cells.to_csv(index=False, float_format=float_format, lineterminator="\n")


def export(
    place: str | Path,
    kinds: Collection[str],
    out: str | Path | None = None,
    *,
    walls_at: Callable[[float], Sequence[Wall]] | None = None,
    room: tuple[Interval, Interval] = ((-1.0, 1.0), (-1.0, 1.0)),
) -> list[Path]:
    """Write what lies in a run folder for other programs.

    Parameters
    ----------
    place : str or Path
        A run folder or a folder of results: its dump, ``profiles.nc`` and ``fields.nc`` are read.
    kinds : collection of str
        Of 'csv' (profiles as tables), 'vtk' (discs at ten equal times, and ``fields.nc`` where it is there) and
        'pictures' (the thesis' picture0.dat … picture9.dat).
    out : str or Path, optional
        Folder for the files; default `place`.
    walls_at : callable, optional
        Walls that are there at a time (s), where they are: for ParaView, once or, where they differ, with each frame.
    room : ((float, float), (float, float))
        How far walls without end are drawn, m.

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    DumpError
        A kind that is not known, no dump or no profiles, a place that cannot be written.
    """
    unknown = [kind for kind in kinds if kind not in EXPORTS]
    if unknown:
        raise DumpError(f"export '{unknown[0]}' is not known: use one of {', '.join(EXPORTS)}.")
    place = Path(place)
    if not place.is_dir() and find_dump(place):
        raise DumpError(
            f"{place}: is a dump; allowed is a run folder or the folder of a dump's results: "
            f"`{typed('analyze', place)}` makes one beside it."
        )
    out = place if out is None else Path(out)
    for name in (name for kind in kinds for pattern in EXPORTS[kind] for name in standing(out, pattern)):
        require_replaceable(out, name)
    # what is to be written is read first: without it no folder is made
    profiles = read_netcdf(place / "profiles.nc") if {"csv", "vtk"} & set(kinds) else None
    dump = read_dump(place) if {"pictures", "vtk"} & set(kinds) else None
    with writes(out):
        out.mkdir(parents=True, exist_ok=True)
    written = []
    if profiles is not None and "csv" in kinds:
        with _understood(place / "profiles.nc"):
            written = write_profiles_csv(profiles, out)
    if dump is not None and "pictures" in kinds:
        written += write_pictures(dump, out)
    if profiles is not None and dump is not None and "vtk" in kinds:
        with _understood(place / "profiles.nc"):
            written += _frames_for_paraview(dump, profiles, out, walls_at, room)
        if (place / "fields.nc").is_file():
            with _understood(place / "fields.nc"):
                written.append(write_vti(read_netcdf(place / "fields.nc"), out / "fields.vti"))
    return written


@contextmanager
def _understood(path: Path) -> Iterator[None]:
    """A file in NetCDF that lacks what this program writes there becomes a DumpError."""
    try:
        yield
    except DumpError:
        raise
    except (LookupError, ValueError, TypeError, AttributeError) as error:
        raise _no_netcdf(path, error) from error


def write_netcdf(dataset: xr.Dataset, path: Path) -> Path:
    """Write a NetCDF file (classic, 64-bit offsets), whole or not at all; whole numbers beyond 2^31 as float64.

    NetCDF-4 would be about as large and takes twenty times as long, to write and to read (docs/benchmark.md).

    Raises
    ------
    DumpError
        The place cannot be written.
    """
    most = np.iinfo(np.int32).max
    wide = [name for name, array in dataset.variables.items() if array.dtype.kind in "iu" and (abs(array) > most).any()]
    load_netcdf()
    with writes(path):
        return write_bytes(path, dataset.assign(dataset[wide].astype(float)).to_netcdf(engine="scipy"))


@cache
def load_netcdf() -> None:
    """Load what reads and writes NetCDF, 0.4 s; threadpoolctl among it sets a variable of the caller's environment."""
    there = THREADS in os.environ
    import scipy.io  # noqa: F401
    import xarray  # noqa: F401

    if not there:
        os.environ.pop(THREADS, None)


def read_netcdf(path: Path) -> xr.Dataset:
    """A file of `write_netcdf`, in memory.

    Raises
    ------
    DumpError
        No such file, or another kind.
    """
    try:
        return netcdf_of(read_file(path, MOST_TEXT), path)
    except OSError as error:
        raise _no_netcdf(path, error) from None


def netcdf_of(data: bytes, path: Path) -> xr.Dataset:
    """The dataset of a file of `write_netcdf`, whose name is for messages.

    Raises
    ------
    DumpError
        Another kind of file, or a damaged one.
    """
    import xarray as xr

    load_netcdf()
    try:
        with xr.open_dataset(io.BytesIO(data), engine="scipy") as dataset:
            return dataset.load()
    except Exception as error:  # scipy raises what its reading comes upon: names, types and sizes of any kind
        raise _no_netcdf(path, error) from None


def _no_netcdf(path: Path, error: Exception) -> DumpError:
    said = shortened(getattr(error, "strerror", None) or str(error))
    return DumpError(f"{path}: cannot be read ({said}); `{typed('analyze', path.parent)}` makes it from the dump.")


def _frames_for_paraview(
    dump: Dump,
    profiles: xr.Dataset,
    out: Path,
    walls_at: Callable[[float], Sequence[Wall]] | None,
    room: tuple[Interval, Interval],
) -> list[Path]:
    """Ten frames of discs as .vtp with a .pvd that holds their times, and walls in the same way."""
    diameter = profiles.attrs["disc_diameter"]
    times = dict(zip(profiles.step.values, profiles.time.values, strict=True))
    frames = list(dump.select(ten_indices(dump.count())))
    files = [write_vtp(frame, out / f"discs{number}.vtp", diameter) for number, frame in enumerate(frames)]
    seconds = [float(times.get(frame.step, frame.time or frame.step)) for frame in frames]
    files.append(write_pvd(zip(seconds, files, strict=True), out / "discs.pvd"))
    shown = [tuple(walls_at(time)) for time in seconds] if walls_at else []
    if not any(shown):
        return files
    if all(walls == shown[0] for walls in shown):
        return [*files, write_walls(shown[0], room, out / "walls.vtp")]
    names = [wall.name for wall in shown[0]]  # a gate goes, and the others keep their numbers
    moving = [write_walls(walls, room, out / f"walls{k}.vtp", names) for k, walls in enumerate(shown)]
    return [*files, *moving, write_pvd(zip(seconds, moving, strict=True), out / "walls.pvd")]


def write_profiles_csv(profiles: xr.Dataset, folder: str | Path) -> list[Path]:
    """Profiles as two tables: ``profiles_mean.csv`` (a row a bin) and ``profiles.csv`` (a row a time and bin).

    Returns
    -------
    list of Path
    """
    units = {str(name): array.attrs.get("units", "") for name, array in profiles.variables.items()}
    written = []
    for file, dims in (("profiles_mean.csv", ("x",)), ("profiles.csv", ("time", "x"))):
        names = [name for name, array in profiles.data_vars.items() if array.dims == dims]
        rows = profiles[names].to_dataframe(dim_order=dims).reset_index()
        written.append(write_table(rows, Path(folder) / file, units))
    return written


def write_vti(fields: xr.Dataset, path: str | Path) -> Path:
    """Fields of `compute_fields` as a VTK image (``.vti``): cells of one layer, read by ParaView.

    Velocity becomes a vector; NaN stays NaN (ParaView leaves such cells out with "Threshold").
    """
    x, y = fields.x.values, fields.y.values
    spacing = float(fields.attrs["spacing"])
    arrays = {str(name): array.values.ravel() for name, array in fields.data_vars.items() if array.dims == ("y", "x")}
    if {"velocity_x", "velocity_y"} <= arrays.keys():
        vx, vy = arrays.pop("velocity_x"), arrays.pop("velocity_y")
        arrays["velocity"] = np.column_stack([vx, vy, np.zeros_like(vx)])
    extent = f"0 {len(x)} 0 {len(y)} 0 1"
    origin = f"{x[0] - spacing / 2:.17g} {y[0] - spacing / 2:.17g} 0"
    steps = " ".join([f"{spacing:.17g}"] * 3)
    cells = "".join(_data_array(name, values) for name, values in arrays.items())
    image = f'<ImageData WholeExtent="{extent}" Origin="{origin}" Spacing="{steps}">\n<Piece Extent="{extent}">\n'
    return _vtk(path, f'type="ImageData" {BINARY}', f"{image}<CellData>\n{cells}</CellData>\n</Piece>\n</ImageData>\n")


def write_vtp(frame: Frame, path: str | Path, diameter: float) -> Path:
    """Discs of a frame as VTK points (``.vtp``) with id, velocity and diameter: glyphs in ParaView.

    `diameter` (m) is that of all discs where the frame does not tell theirs.
    """
    points = np.column_stack([frame.x, frame.y, np.zeros(frame.n)])
    diameters = np.full(frame.n, float(diameter)) if frame.radii is None else 2 * frame.radii
    arrays = {"id": frame.ids.astype(float), "diameter": diameters}
    if "vx" in frame.columns and "vy" in frame.columns:
        arrays["velocity"] = np.column_stack([frame.vx, frame.vy, np.zeros(frame.n)])
    data = "".join(_data_array(name, values) for name, values in arrays.items())
    verts = _data_array("connectivity", np.arange(frame.n), "Int64")
    verts += _data_array("offsets", np.arange(1, frame.n + 1), "Int64")
    piece = f'<Piece NumberOfPoints="{frame.n}" NumberOfVerts="{frame.n}">\n<PointData>\n{data}</PointData>\n'
    piece += f"<Points>\n{_data_array('points', points)}</Points>\n<Verts>\n{verts}</Verts>\n</Piece>\n"
    return _vtk(path, f'type="PolyData" {BINARY}', f"<PolyData>\n{piece}</PolyData>\n")


def write_walls(
    walls: Sequence[Wall], room: tuple[Interval, Interval], path: str | Path, names: Sequence[str] = ()
) -> Path:
    """Walls as VTK polygons and lines (``.vtp``), with the number of each wall among `names`, else among the walls.

    What has no area, open lines and outlines of hollow walls are lines.
    """
    lines, polygons, names = [], [], names or [wall.name for wall in walls]
    for number, wall in ((names.index(wall.name), wall) for wall in walls):
        outlines, open_ = parts_of(wall, *room)
        lines += [(number, line) for line in open_]
        for outline in outlines:
            if wall.hollow or thin(outline):
                lines.append((number, np.vstack([outline, outline[:1]])))
            else:
                polygons.append((number, outline))
    cells = lines + polygons  # the order of VTK
    places = np.concatenate([np.empty((0, 2)), *(part for _, part in cells)])
    numbers = _data_array("wall", np.array([number for number, _ in cells]), "Int64")
    piece = f'<Piece NumberOfPoints="{len(places)}" NumberOfLines="{len(lines)}" NumberOfPolys="{len(polygons)}">\n'
    points = _data_array("points", np.column_stack([places, np.zeros(len(places))]))
    piece += f"<CellData>\n{numbers}</CellData>\n<Points>\n{points}</Points>\n"
    begin = 0
    for name, parts in (("Lines", lines), ("Polys", polygons)):
        sizes = np.array([len(part) for _, part in parts], int)
        index = _data_array("connectivity", begin + np.arange(sizes.sum()), "Int64")
        piece += f"<{name}>\n{index}{_data_array('offsets', np.cumsum(sizes), 'Int64')}</{name}>\n"
        begin += sizes.sum()
    return _vtk(path, f'type="PolyData" {BINARY}', f"<PolyData>\n{piece}</Piece>\n</PolyData>\n")


def write_pvd(files: Iterable[tuple[float, str | Path]], path: str | Path) -> Path:
    """A ParaView collection: (time, file) pairs; files next to or below it are named relative to it."""
    folder, sets = Path(path).parent, ""
    for time, name in files:
        name = Path(name).relative_to(folder) if Path(name).is_relative_to(folder) else Path(name)
        sets += f'<DataSet timestep="{time:.10g}" part="0" file="{name.as_posix()}"/>\n'
    return _vtk(path, 'type="Collection" version="0.1"', f"<Collection>\n{sets}</Collection>\n")


def write_pictures(dump: Dump, folder: str | Path) -> list[Path]:
    """The thesis' ``picture0.dat … picture9.dat``: a line ``id x y`` a disc, at ten equal times of the dump.

    The radius follows where the dump has it. A dump of fewer than ten frames gives as many files as it has frames.
    """
    written = []
    for number, frame in enumerate(dump.select(ten_indices(dump.count()))):
        frame = frame.sorted()
        written.append(Path(folder) / f"picture{number}.dat")
        columns = [frame.ids, frame.x, frame.y, *([] if frame.radii is None else [frame.radii])]
        row = " ".join(["%d", *["%.10g"] * (len(columns) - 1)]) + "\n"
        _write(written[-1], "".join(row % disc for disc in zip(*columns, strict=True)))
    return written


def _vtk(path: str | Path, head: str, body: str) -> Path:
    return _write(path, f'<?xml version="1.0"?>\n<VTKFile {head}>\n{body}</VTKFile>\n')


def _data_array(name: str, values: np.ndarray, kind: str = "Float64") -> str:
    """One VTK array, binary in base64: the size in bytes (UInt64), then the values."""
    values = np.ascontiguousarray(values, "<f8" if kind == "Float64" else "<i8")
    components = values.shape[1] if values.ndim == 2 else 1
    raw = base64.b64encode(np.uint64(values.nbytes).tobytes() + values.tobytes()).decode()
    head = f'<DataArray type="{kind}" Name="{name}" NumberOfComponents="{components}" format="binary">'
    return f"{head}\n{raw}\n</DataArray>\n"


def _write(path: str | Path, text: str) -> Path:
    with writes(path):
        return write_text(Path(path), text)
