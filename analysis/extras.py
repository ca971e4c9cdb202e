"""What is made only on request: fields on a grid, the film, exports for other programs."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from lammps_jump.dump.frame import ten_indices
from lammps_jump.dump.read import open_dump
from lammps_jump.errors import DumpError, SetupError

from .passes import AnalysisRequest, Gathered

EXPORTS = ("csv", "vtk", "pictures")
FIELD_FRAMES = 20
"""Frames of the window that the mean fields use at most: contact stress rings, one frame says little."""


def write_extras(
    gathered: Gathered,
    request: AnalysisRequest,
    path: Path,
    out: Path,
    files: list[str],
    warnings: list[str],
    *,
    quiet: bool = True,
) -> dict | None:
    """Fields, film and exports as asked for; names of the files are added to `files`.

    Returns
    -------
    dict or None
        Summary of the fields where they were made.

    Raises
    ------
    DumpError
        An export that is not known, a place that cannot be written.
    """
    unknown = [name for name in request.exports if name not in EXPORTS]
    if unknown:
        raise DumpError(f"export '{unknown[0]}' is not known: use one of {', '.join(EXPORTS)}.")
    summary = _fields(gathered, request, path, out, files) if request.fields else None
    if "csv" in request.exports:
        from lammps_jump.dump.exports import write_profiles_csv

        files += [written.name for written in write_profiles_csv(gathered.profiles, out)]
    if "pictures" in request.exports:
        from lammps_jump.dump.exports import write_pictures

        files += [written.name for written in write_pictures(open_dump(path), out)]
    if "vtk" in request.exports:
        files += _discs_for_paraview(gathered, path, out)
    if request.animate:
        files += _film(gathered, path, out, warnings, quiet)
    return summary


def _fields(gathered: Gathered, request: AnalysisRequest, path: Path, out: Path, files: list[str]) -> dict:
    """Mean fields of the window: fields.nc, maps, bed pressure; fields.vti with the export 'vtk'."""
    from lammps_jump.analysis.draw.maps import bed_pressure, bed_pressure_figure, field_map
    from lammps_jump.analysis.draw.style import save

    from .fields import mean_fields

    flow, profiles = gathered.flow, gathered.profiles
    time = profiles["time"].values
    begin, end = profiles.attrs["window_begin"], profiles.attrs["window_end"]
    indices = np.flatnonzero((time >= begin - 1e-9) & (time <= end + 1e-9))
    if len(indices) > FIELD_FRAMES:
        indices = indices[np.round(np.linspace(0, len(indices) - 1, FIELD_FRAMES)).astype(int)]
    x = (profiles.attrs["x_low"], profiles.attrs["x_high"])
    bed, surface = profiles["bed"].values, profiles["surface_depth"].values[indices] + profiles["bed"].values
    known = surface[np.isfinite(surface)]
    low = float(np.nanmin(bed)) if np.isfinite(bed).any() else flow.scene.domain[1][0]
    high = max(float(known.max(initial=low)), low) + 5 * flow.scene.diameter
    fields = mean_fields(open_dump(path).select(indices.tolist()), flow, x=x, y=(low, high))
    try:
        fields.to_netcdf(out / "fields.nc", engine="h5netcdf")
    except OSError as error:
        raise DumpError(f"{out / 'fields.nc'}: cannot be written ({error.strerror or error}).") from error
    files.append("fields.nc")
    if "vtk" in request.exports:
        from lammps_jump.dump.exports import write_vti

        files.append(write_vti(fields, out / "fields.vti").name)
    stress = "contact_yy" in fields
    if request.figures:
        (out / "figures").mkdir(exist_ok=True)
        for variable in ("density", *(("pressure",) if stress else ())):
            written = save(field_map(fields, flow, variable), out / "figures" / f"field_{variable}.png")
            files.append(f"figures/{written.name}")
        if stress:
            written = save(bed_pressure_figure(fields, flow), out / "figures" / "bed_pressure.png")
            files.append(f"figures/{written.name}")
    summary: dict = {"file": "fields.nc", "frames": len(indices), "reach": float(fields.attrs["reach"])}
    if stress:
        bottom = bed_pressure(fields)
        covered = bottom["hydrostatic"].values > flow.scene.density * flow.g * flow.scene.diameter
        if covered.any():
            ratio = bottom["stress"].values[covered].sum() / bottom["hydrostatic"].values[covered].sum()
            summary["bed_stress_over_weight"] = float(ratio)
    return summary


def _discs_for_paraview(gathered: Gathered, path: Path, out: Path) -> list[str]:
    """Ten frames of discs as .vtp with a .pvd that holds their times."""
    from lammps_jump.dump.exports import write_pvd, write_vtp

    flow = gathered.flow
    dump = open_dump(path)
    written = []
    for number, frame in enumerate(dump.select(ten_indices(dump.count()))):
        name = write_vtp(frame, out / f"discs{number}.vtp", flow.scene.diameter)
        written.append((flow.time(frame), name))
    collection = write_pvd(written, out / "discs.pvd")
    return [*(name.name for _, name in written), collection.name]


def _film(gathered: Gathered, path: Path, out: Path, warnings: list[str], quiet: bool) -> list[str]:
    """animation.mp4; a machine without ffmpeg gets a warning, not a failure."""
    from lammps_jump.analysis.draw.film import animate

    def shown(done: int, total: int) -> None:
        print(f"\ranimation: {done} of {total} frames", end="\n" if done == total else "", flush=True)

    try:
        made = animate(
            open_dump(path),
            gathered.flow,
            out / "animation.mp4",
            forces=gathered.forces or None,
            progress=None if quiet or not sys.stdout.isatty() else shown,
        )
    except SetupError as error:
        warnings.append(f"no animation: {error}")
        return []
    return [made.name]
