# SPDX-License-Identifier: GPL-2.0-or-later
"""The analyses of a run, and how a dump becomes numbers, tables and figures."""

from __future__ import annotations

import sys
from collections.abc import Callable, Collection, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import NamedTuple

from lammps_jump.dump.exports import write_table
from lammps_jump.dump.find import read_forces
from lammps_jump.dump.read import Dump, open_dump
from lammps_jump.errors import DumpError, SetupError
from lammps_jump.files import plain
from lammps_jump.units import as_summary, is_bound, numbers_of, shown

from . import energy, front
from .budgets import inflow, stations
from .contacts import ContactCollector
from .draw.film import NO_FFMPEG, animate
from .draw.snapshots import snapshots
from .draw.style import depth_profile, save, xt_map
from .fields import write_fields
from .flow import Flow
from .forces import figures as forces
from .forces.history import Force, Forces
from .forces.impulse import MomentumLedger
from .jump import head
from .jump import section as jump
from .jump.summary import Jump
from .passes import Collector, Drawings, Gathered, Tables, gather
from .profiles import bin_edges, write_profiles
from .report.headline import belongs, headline
from .report.page import Section


class Quantity(NamedTuple):
    """One analysis of a run.

    Attributes
    ----------
    result : type
        Its numbers, described; labelled ones are shown on the screen.
    collector : callable(flow, contacts) -> Collector, or None
        Takes in the frames; None where profiles and contacts are enough.
    analyse : callable(Gathered) -> result, or None where there is nothing to be said
    tables, figures, section : callable
        CSV tables of the result, figures of result and `Gathered`, section of the report from ``summary.json``.
    summary : callable(result) -> dict
        As the result stands in ``summary.json``.
    """

    result: type
    collector: Callable[[Flow, ContactCollector | None], Collector] | None
    analyse: Callable[[Gathered], object | None]
    tables: Callable[[object], Tables]
    figures: Callable[[object, Gathered], Drawings]
    section: Callable[[Mapping], Section | None]
    summary: Callable[[object], dict[str, object]] = as_summary


QUANTITIES = {
    "inflow": Quantity(
        inflow.Delivery, inflow.InflowCounter, inflow.analyse, lambda _: {}, lambda *_: {}, inflow.section
    ),
    "jump": Quantity(Jump, head.EnergyFluxes, jump.analyse, jump.tables, jump.figures, jump.section),
    "front": Quantity(front.Front, front.FrontTracker, front.analyse, front.tables, front.figures, front.section),
    "force": Quantity(
        Force, MomentumLedger, forces.analyse, Forces.tables, forces.figures, forces.section, Forces.summary
    ),
    "energy": Quantity(
        energy.Energy, energy.EnergyLedger, energy.analyse, energy.tables, energy.figures, energy.section
    ),
}
"""By the key in ``summary.json``, in the order of the report."""
ALWAYS = {"inflow", "force"}
"""Made whether asked for or not, where a scene has rows of inflow or probes."""


def analyse(
    flow: Flow,
    dump: Path,
    out: Path,
    wanted: Collection[str],
    *,
    figures: bool = True,
    film: bool = False,
    quiet: bool = False,
    watch: Sequence[Collector] = (),
    gathered: Gathered | None = None,
) -> dict[str, object]:
    """Analyse a dump file.

    Parameters
    ----------
    flow : Flow
        Of `flow.from_scene` or `guess.from_dump`.
    dump : Path
    out : Path
        Folder that gets ``profiles.nc``, ``*.csv``, ``figures/*.png`` and the film. ``forces.csv`` is looked for here
        and beside the dump.
    wanted : collection of str
        Of `QUANTITIES`, and 'fields' for mean fields on a grid. Profiles are always made, and `ALWAYS`.
    figures, film : bool
        Write ``figures/*.png``; write ``animation.mp4``, or ``animation.gif`` where there is no ffmpeg.
    quiet : bool
        Print nothing while the film is made.
    watch : sequence of Collector
        Are also shown every frame.
    gathered : Gathered, optional
        Of `collect` for the same quantities, where the frames were read before.

    Returns
    -------
    dict
        ``profiles`` (what is in profiles.nc), the quantities, ``files`` (names written) and ``warnings`` (sentences).
        Plain numbers, text and None; never NaN.

    Raises
    ------
    DumpError
        A quantity that is not known, no frame, a malformed dump, a place that cannot be written.
    """
    if unknown := sorted(set(wanted) - {*QUANTITIES, "fields"}):
        known = ", ".join(name for name in QUANTITIES if name != "inflow")
        raise DumpError(f"quantity '{unknown[0]}' is not known: use {known} or fields.")
    gathered = gathered or collect(flow, open_dump(dump), (out, dump.parent), wanted, watch)
    warnings = list(gathered.warnings)
    out.mkdir(parents=True, exist_ok=True)  # only now: a dump that cannot be read leaves nothing behind
    asked = {name: quantity.analyse(gathered) for name, quantity in QUANTITIES.items() if name in {*wanted, *ALWAYS}}
    results = {name: result for name, result in asked.items() if result is not None}
    warnings += results["jump"].notes if "jump" in results else ()
    warnings += getattr(results.get("inflow"), "notes", ())
    parts: dict[str, object] = {name: QUANTITIES[name].summary(result) for name, result in results.items()}
    files = [write_profiles(gathered.profiles, out / "profiles.nc").name]
    for name, result in results.items():
        files += [write_table(columns, out / file).name for file, columns in QUANTITIES[name].tables(result).items()]
    if figures:
        files += _draw(gathered, results, out / "figures", dump)
    if "fields" in wanted:
        written, parts["fields"] = write_fields(gathered.flow, gathered.profiles, open_dump(dump), out, figures)
        files += written
    if film:
        files += _film(gathered, dump, out, warnings, quiet)
    parts |= {"profiles": _about_profiles(gathered), "files": files, "warnings": list(dict.fromkeys(warnings))}
    return plain(parts)


def collect(
    flow: Flow, dump: Dump, places: Sequence[Path], wanted: Collection[str], watch: Sequence[Collector] = ()
) -> Gathered:
    """One pass over a dump with the collectors of the wanted quantities; ``forces.csv`` is looked for in `places`."""
    warnings = list(flow.notes)
    edges = bin_edges(flow.x_range, flow.bin_width) if "jump" in wanted else None
    contacts = ContactCollector(flow, edges) if flow.knows_contacts and {"jump", "energy"} & set(wanted) else None
    forces_asked = bool(flow.scene.probes) or ("force" in wanted and _forces_file(places) is not None)
    there = {"inflow": bool(flow.scene.inlets), "force": forces_asked}
    collectors = {
        name: quantity.collector(flow, contacts)
        for name, quantity in QUANTITIES.items()
        if quantity.collector and there.get(name, name in wanted)
    }
    # contacts first: the energy takes each frame's elastic energy from them
    fed = [*watch, *([contacts] if contacts else []), *collectors.values()]
    profiles = gather(dump, flow, fed, warnings)
    histories = {name: collector.result() for name, collector in collectors.items()}
    forces = {}
    if forces_asked and (table := _forces_file(places)):  # of a run that goes on it is whole only now
        try:
            forces = read_forces(table)
        except DumpError as error:
            warnings.append(str(error))
    return Gathered(flow, profiles, contacts.result() if contacts else None, histories, forces, tuple(warnings))


def _forces_file(places: Sequence[Path]) -> Path | None:
    return next((place / "forces.csv" for place in places if (place / "forces.csv").is_file()), None)


def drawings(gathered: Gathered, results: Mapping[str, object], dump: Path) -> Drawings:
    """Every figure that the results call for."""
    flow, found = gathered.flow, results.get("jump")
    looks = jump.marks(found) if isinstance(found, Jump) else jump.Marks()
    figures: Drawings = {
        "depth_profile.png": partial(depth_profile, gathered.profiles, flow, lines=looks.lines, marks=looks.places),
        "depth_map.png": partial(xt_map, gathered.thinned, toe=looks.track),
        "snapshots.png": lambda: snapshots(open_dump(dump), flow),
    }
    for name, result in results.items():
        figures |= QUANTITIES[name].figures(result, gathered)
    return figures


def _draw(gathered: Gathered, results: Mapping[str, object], folder: Path, dump: Path) -> list[str]:
    """Draw the figures into a folder; their names relative to the run folder."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise DumpError(f"{folder}: cannot be made ({error.strerror}); name another folder.") from error
    drawn = ((name, draw()) for name, draw in drawings(gathered, results, dump).items())
    return [f"{folder.name}/{save(figure, folder / name).name}" for name, figure in drawn if figure is not None]


def _film(gathered: Gathered, dump: Path, out: Path, warnings: list[str], quiet: bool) -> list[str]:
    """The film; without ffmpeg a GIF and a note, and no failure where that cannot be made either."""

    def told(done: int, total: int) -> None:
        print(f"\ranimation: {done} of {total} frames", end="\n" if done == total else "", flush=True)

    progress = None if quiet or not sys.stdout.isatty() else told
    try:
        path = out / "animation.mp4"
        made = animate(open_dump(dump), gathered.flow, path, forces=gathered.forces, progress=progress)
    except SetupError as error:
        warnings.append(f"no animation: {error}")
        return []
    warnings += [NO_FFMPEG] if made != path else []
    return [made.name]


def _about_profiles(gathered: Gathered) -> dict[str, object]:
    profiles = gathered.profiles
    return {
        "file": "profiles.nc",
        "frames": profiles.sizes["time"],
        "axis": "time" if gathered.flow.timed else "step",
        "bins": profiles.sizes["x"],
        "bin_width": profiles.attrs["bin_width"],
        "first_time": float(profiles["time"][0]),
        "last_time": float(profiles["time"][-1]),
        "window": [profiles.attrs["window_begin"], profiles.attrs["window_end"]],
        "window_frames": profiles.attrs["window_frames"],
    }


def main_numbers(summary: Mapping[str, object]) -> list[str]:
    """The headline of a summary; a line for each quantity: its verdict and its labelled numbers that were found."""
    said = headline(summary)
    lines = [said] if said else []
    for name, quantity in QUANTITIES.items():
        found = summary.get(name)
        if not isinstance(found, Mapping):
            continue
        texts = [f"verdict {found['verdict']}"] if found.get("verdict") else []
        for number in numbers_of(quantity.result).values():
            if number.label != number.meaning and found.get(number.key) is not None and belongs(number.key, found):
                value = shown(
                    found[number.key],
                    number.unit,
                    found.get(f"{number.key}_error"),
                    bound=is_bound(found, number.key),
                )
                texts.append(f"{number.label} {value}")
        lines += [f"{name}: {', '.join(texts)}"] if texts else []
    return [*lines, *filter(None, [stations.line(summary)])]
