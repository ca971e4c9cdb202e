"""From a dump to numbers, tables and figures: one pass over the frames feeds every analysis that was asked for."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from lammps_jump.dump.find import find_dump
from lammps_jump.dump.read import open_dump
from lammps_jump.files import plain
from lammps_jump.scene.scene import Scene

from .flow import Flow, from_scene
from .passes import AnalysisRequest, Gathered, gather


def analyze_run(folder: Path, scene: Scene, wanted: AnalysisRequest, *, quiet: bool = False) -> dict:
    """Analyse the dump (and ``forces.csv``) of a run folder; tables and figures are written into it.

    Parameters
    ----------
    folder : Path
    scene : Scene
    wanted : AnalysisRequest
    quiet : bool
        Say nothing while rendering the animation.

    Returns
    -------
    dict
        See `analyze_dump`.
    """
    flow = from_scene(
        scene,
        bin_width=wanted.bin_width,
        window=wanted.window,
        inflow_depth=wanted.inflow_depth,
        inflow_speed=wanted.inflow_speed,
    )
    return analyze_dump(find_dump(folder), flow, wanted, Path(folder), quiet=quiet)


def analyze_dump(path: Path, flow: Flow, request: AnalysisRequest, out: Path, *, quiet: bool = False) -> dict:
    """Analyse a dump file.

    Parameters
    ----------
    path : Path
    flow : Flow
        Of `flow.from_scene` or `guess.from_dump`.
    request : AnalysisRequest
    out : Path
        Folder that gets ``profiles.nc``, ``*.csv``, ``figures/*.png`` and, when asked for, ``animation.mp4``.
        ``forces.csv`` is looked for here and beside the dump.

    Returns
    -------
    dict
        ``profiles`` (what is in profiles.nc), ``jump``, ``front``, ``energy``, ``force`` (absent where not asked
        for), ``files`` (names written) and ``warnings`` (sentences). Plain numbers, text and None; never NaN.

    Raises
    ------
    DumpError
        No frame, a malformed dump, a place that cannot be written.
    """
    out = Path(out)
    warnings: list[str] = []
    gathered = gather(open_dump(path), flow, request, warnings, places=(out, Path(path).parent))
    out.mkdir(parents=True, exist_ok=True)  # only now: a dump that cannot be read leaves nothing behind
    parts, shown = summarise(gathered, request, warnings)
    from .profiles import write_profiles

    files = [write_profiles(gathered.profiles, out / "profiles.nc").name]
    files += _write_tables(gathered, shown, out)
    if request.figures:
        from .result_figures import draw_all

        files += draw_all(gathered, shown, out / "figures", path)
    if request.fields or request.animate or request.exports:
        from .extras import write_extras

        parts["fields"] = write_extras(gathered, request, Path(path), out, files, warnings, quiet=quiet)
    dataset = gathered.profiles
    parts["profiles"] = {
        "file": "profiles.nc",
        "frames": dataset.sizes["time"],
        "bins": dataset.sizes["x"],
        "bin_width": dataset.attrs["bin_width"],
        "first_time": float(dataset["time"][0]),
        "last_time": float(dataset["time"][-1]),
        "window": [dataset.attrs["window_begin"], dataset.attrs["window_end"]],
        "window_frames": dataset.attrs["window_frames"],
    }
    parts["files"] = files
    parts["warnings"] = list(dict.fromkeys(warnings))
    return plain(parts)


def summarise(gathered: Gathered, request: AnalysisRequest, warnings: list[str]) -> tuple[dict, dict]:
    """Summary parts, and the full results of each analysis for tables and figures."""
    parts: dict[str, Any] = {}
    shown: dict[str, Any] = {}
    flow = gathered.flow
    if gathered.energy is not None:
        from .energy import summarise_energy

        parts["energy"] = summarise_energy(gathered.energy, flow)
    if gathered.front is not None:
        from .front import summarise_front

        parts["front"] = summarise_front(gathered.front, flow)
    if request.jump:
        from lammps_jump.analysis.jump.result import analyse_jump
        from lammps_jump.analysis.jump.summary import summarise_jump

        shown["jump"] = analyse_jump(gathered.profiles, flow, gathered.contacts)
        parts["jump"] = summarise_jump(shown["jump"])
    if gathered.forces:
        from lammps_jump.analysis.forces.history import analyse_forces

        shown["force"] = analyse_forces(gathered.forces, flow, gathered.momentum, gathered.profiles)
        parts["force"] = shown["force"].summary
    return parts, shown


def _write_tables(gathered: Gathered, shown: dict, out: Path) -> list[str]:
    """The small tables as CSV (SI units); returns their names."""
    from lammps_jump.dump.exports import write_table

    tables: dict[str, dict[str, np.ndarray]] = {}
    if gathered.energy is not None:
        history = gathered.energy
        tables["energy.csv"] = {
            "time": history.time,
            "kinetic": history.kinetic,
            "rotational": history.rotational,
            "potential": history.potential,
            **({} if history.elastic is None else {"elastic": history.elastic}),
            "total": history.total,
        }
    if gathered.front is not None:
        history = gathered.front
        names = ("time", "bulk", "quantile", "height", "top_speed", "tip_speed")
        tables["front.csv"] = {name: getattr(history, name) for name in names}
    if "jump" in shown:
        tables |= shown["jump"].tables()
    if "force" in shown:
        tables |= shown["force"].tables()
    for name, columns in tables.items():
        write_table(columns, out / name)
    return list(tables)
