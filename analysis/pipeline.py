# SPDX-License-Identifier: GPL-2.0-or-later
"""One pass over a dump: runs the wanted analyses, and writes their numbers, tables and figures."""

from __future__ import annotations

import gc
import multiprocessing
import sys
import threading
import warnings
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, nullcontext, suppress
from dataclasses import replace
from math import isfinite
from multiprocessing.connection import Connection
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, NamedTuple, ParamSpec, TypeVar

from lammps_jump.dump import Dump, open_dump, read_forces
from lammps_jump.dump.contacts import ContactFile
from lammps_jump.dump.exports import write_netcdf, write_table
from lammps_jump.errors import DumpError, SetupError
from lammps_jump.files import CONTACTS_FILE, CURVES, PRESSURE_FILE, plain, write_json

from . import draw
from .contacts import ContactCollector
from .draw.arrows import ForceArrows
from .draw.chart import Bars, Chart, Drawings, Map
from .draw.maps import depth_profile, xt_map
from .fields import write_fields
from .flow import Flow
from .passes import Gathered, Watcher, gather
from .profiles import bin_edges, window_of
from .quantities import LISTED, QUANTITIES
from .quantity import Marks
from .report.page import Picture, Player, smaller
from .report.player import still_of
from .slope import AlongBed, sloping_stretch

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from PIL.Image import Image

Given = ParamSpec("Given")
Found = TypeVar("Found")


class Deferred(Generic[Found]):
    """Result of a work, once the block of `aside` is left."""

    value: Found


@contextmanager
def aside(work: Callable[Given, Found], *given: Given.args, **named: Given.kwargs) -> Iterator[Deferred[Found]]:
    """Do a work that leaves files, while the block goes on; it is done when the block is left.

    Where it fails it is done once more, in this process and with its errors. Beside other threads it is done in this
    process alone: one of them may hold a lock, for which a copy would wait forever.
    """
    done, later = False, Deferred[Found]()
    if threading.active_count() > 1:
        yield later
    else:
        heard, said = multiprocessing.Pipe(duplex=False)
        process = multiprocessing.get_context("fork").Process(target=_quietly, args=(said, work, given, named))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # of the threads of libraries, which rest
            process.start()
        said.close()
        try:
            yield later
            with suppress(EOFError):  # it failed
                later.value, done = heard.recv(), True
        finally:
            heard.close()
            process.kill()
            process.join()
    if not done:
        later.value = work(*given, **named)


def _quietly(said: Connection, work: Callable[..., Any], given: tuple[Any, ...], named: dict[str, Any]) -> None:
    """Do the work in the copy; the process that does it again tells what fails."""
    gc.disable()  # it would copy all pages of memory that both share
    with suppress(BaseException):
        said.send(work(*given, **named))


DISCS = "snapshots"
"""Name of the figure of ten pictures."""
MAIN = ("depth_profile",)
"""Figures that are drawn by default, with `DISCS`. The page draws the curves of all others itself."""


class Pictures(NamedTuple):
    """Pictures to be drawn.

    Attributes
    ----------
    figures : {'none', 'default', 'all'}
        As ``figures/*.png``; default: `MAIN` and `DISCS`.
    film : bool
        Write ``animation.mp4``, or ``animation.gif`` without ffmpeg.
    quiet : bool
        Print nothing while the film is made.
    """

    figures: str = "default"
    film: bool = False
    quiet: bool = False


DEFAULT_PICTURES = Pictures()


class DrawnAside(ExitStack):
    """Pictures that are drawn on a second core until the block is left.

    Attributes
    ----------
    still : Later of Picture, optional
        That of the discs, for a page; None where none is drawn.
    """

    still: Deferred[Picture | None] | None = None

    def shown_in(self, player: Player | None) -> Player | None:
        """A player with the picture of the discs, after the block."""
        return player._replace(still=self.still.value) if player and self.still else player


def analyse(
    flow: Flow,
    dump: Path,
    out: Path,
    wanted: Collection[str],
    *,
    pictures: Pictures = DEFAULT_PICTURES,
    gathered: Gathered | None = None,
    report: Callable[[str], None] | None = None,
    drawing: DrawnAside | None = None,
) -> dict[str, object]:
    """Analyse a dump file.

    Parameters
    ----------
    flow : Flow
        Of `flow.from_scene` or `guess.from_dump`.
    dump : Path
    out : Path
        Folder that gets ``profiles.nc``, ``*.csv``, ``curves.json``, ``figures/*.png`` and the film. ``forces.csv`` is
        looked for here and next to the dump.
    wanted : collection of str
        Of `QUANTITIES`, and 'fields' for mean fields on a grid. Profiles are always made, and what a flow has anyway.
    pictures : Pictures
    gathered : Gathered, optional
        Of `collect` for the same quantities, where the frames were read before.
    report : callable(str), optional
        Called with what is done next: results, tables.
    drawing : DrawnAside, optional
        The pictures are done when its block is left, by default when this function returns.

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
        known = ", ".join(name for name, one in QUANTITIES.items() if one.always is None or one.needs)
        raise DumpError(f"quantity '{unknown[0]}' is not known: use {known} or fields.")
    gathered = gathered or collect(flow, open_dump(dump), (out, dump.parent), wanted)
    report, warnings = report or (lambda phase: None), list(gathered.warnings)
    out.mkdir(parents=True, exist_ok=True)  # only now: a dump that cannot be read leaves no folder
    with nullcontext(drawing) if drawing else DrawnAside() as busy:
        if pictures.figures != "none":
            busy.still = busy.enter_context(aside(draw_discs, out, dump, flow, felt(gathered)))
        report("results")
        names = [name for name, quantity in QUANTITIES.items() if name in wanted or quantity.always is not None]
        analysed = {name: QUANTITIES[name].analyse(gathered) for name in names}
        results = {name: result for name, result in analysed.items() if result is not None}
        warnings += [note for name, result in results.items() for note in QUANTITIES[name].notes(result)]
        parts: dict[str, object] = {name: QUANTITIES[name].summary(result) for name, result in results.items()}
        shown = drawings(gathered, results) if pictures.figures != "none" else {}
        drawn = {"none": (), "default": MAIN, "all": tuple(shown)}[pictures.figures]
        report("tables")
        files = _write(gathered, results, shown if drawn else {}, out)
        if drawn:
            draw_figures(drawn, shown, out / "figures", dump, flow)
        if "fields" in wanted:
            parts["fields"], maps = write_fields(gathered.flow, gathered.profiles, open_dump(dump), out)
            files.append("fields.nc")
            if drawn:
                draw_figures(list(maps), _titled(maps, flow), out / "figures", dump, flow)
                files += [f"figures/{name}.png" for name in maps]
    files += [f"figures/{name}.png" for name in ((*drawn, DISCS) if drawn else ())]
    if pictures.film:
        files += _film(gathered, dump, out, warnings, pictures.quiet)
    parts |= {"profiles": _about_profiles(gathered), "files": files, "warnings": list(dict.fromkeys(warnings))}
    return plain(parts)


def _write(
    gathered: Gathered, results: Mapping[str, object], shown: Mapping[str, Chart | Bars | Map], out: Path
) -> list[str]:
    """Write profiles, tables and what the page draws; the names of the files."""
    files = [write_netcdf(gathered.profiles, out / "profiles.nc").name]
    clock = {} if gathered.flow.timed else {"time": "step"}
    tables = {file: columns for name in results for file, columns in QUANTITIES[name].tables(results[name]).items()}
    for file, columns in tables.items():
        table: dict[str, Any] = {clock.get(name, name): column for name, column in columns.items()}
        files.append(write_table(table, out / file).name)
    sets = {file: data for name in results for file, data in QUANTITIES[name].datasets(results[name]).items()}
    files += [write_netcdf(data, out / file).name for file, data in sets.items()]
    if shown:
        charts = {name: what.plain for name, what in shown.items() if not isinstance(what, Map)}
        files.append(write_json(out / CURVES, charts, None).name)
    return files


def without_friction(flow: Flow, places: Sequence[Path], wanted: Collection[str]) -> list[str]:
    """A note where forces of contacts lack the friction of springs with memory, because the engine wrote none."""
    in_need = {"fields", *(name for name, one in LISTED.items() if one.contacts)} & set(wanted)
    if flow.scene.springs is None or not in_need or any((place / CONTACTS_FILE).is_file() for place in places):
        return []
    return [
        f"Contact forces lack the tangential springs, which no frame tells: {CONTACTS_FILE} is not there. Run with "
        "engine.kernel: compiled or engine.name: native, which write it."
    ]


def without_core(flow: Flow) -> list[str]:
    """A warning where the analysis leaves out what the core alone computes."""
    if flow.knows_contacts or not isfinite(flow.scene.coefficients.stiffness):
        return []
    return [f"Elastic energy, contact forces and pressure are left out: {flow.no_contacts}."]


def collect(
    flow: Flow, dump: Dump, places: Sequence[Path], wanted: Collection[str], watch: Sequence[Watcher] = ()
) -> Gathered:
    """One pass over a dump with the collectors of the wanted quantities.

    ``forces.csv`` and the contacts that the engine wrote are looked for in `places`.
    """
    if flow.scene.contact_output:
        paths = [place / CONTACTS_FILE for place in places]
        there = next((file for file in paths if file.is_file()), paths[-1])
        flow = replace(flow, written=ContactFile(there, flow.scene))
    needs = {need for name, one in QUANTITIES.items() if name in wanted for need in one.needs}
    edges = bin_edges(flow.x_range, flow.bin_width) if "thrust" in needs else None
    contacts = ContactCollector(flow, edges) if flow.knows_contacts and needs & {"contacts", "thrust"} else None
    forces_asked = bool(flow.scene.probes) or ("forces" in needs and _forces_file(places) is not None)
    made = {name for name, one in QUANTITIES.items() if (one.always(flow) if one.always else name in wanted)}
    made |= {name for name, one in QUANTITIES.items() if forces_asked and "forces" in one.needs}
    collectors = {
        name: quantity.collector(flow, contacts)
        for name, quantity in QUANTITIES.items()
        if quantity.collector and name in made
    }
    # contacts first: the energy takes each frame's elastic energy from them
    stretch = sloping_stretch(flow) if "slope" in needs and flow.velocities else None
    along = [AlongBed(flow, stretch)] if stretch else []
    fed = [*watch, *([contacts] if contacts else []), *collectors.values(), *along]
    notes: list[str] = []
    profiles = gather(dump, flow, fed, notes)
    # of a run that goes on, the engine may have made its files only now
    warnings = [*flow.notes, *without_friction(flow, places, wanted), *without_core(flow), *notes]
    histories = {name: collector.result() for name, collector in collectors.items()}
    forces = {}
    if forces_asked and (table := _forces_file(places)):
        try:
            forces = read_forces(table)
        except DumpError as error:
            warnings.append(str(error))
    sums, sloping = contacts.result() if contacts else None, along[0].result() if along else None
    pressed = next((place / PRESSURE_FILE for place in places if (place / PRESSURE_FILE).is_file()), None)
    return Gathered(flow, profiles, sums, histories, forces, tuple(warnings), sloping, pressed)


def _forces_file(places: Sequence[Path]) -> Path | None:
    return next((place / "forces.csv" for place in places if (place / "forces.csv").is_file()), None)


def drawings(gathered: Gathered, results: Mapping[str, object]) -> dict[str, Chart | Bars | Map]:
    """Drawings of the results, by the name of the figure."""
    flow, looks = gathered.flow, _marks(results)
    shown: Drawings = {
        "depth_profile": depth_profile(gathered.profiles, flow, lines=looks.lines, marks=looks.places),
        "depth_map": xt_map(gathered.thinned, toe=looks.track),
    }
    for name, result in results.items():
        shown |= QUANTITIES[name].figures(result, gathered)
        if isinstance(chart := shown.get(marked := QUANTITIES[name].marked), Chart):
            first, *others = chart.panels
            shown[marked] = replace(chart, panels=(replace(first, marks={**first.marks, **looks.places}), *others))
    return _titled(shown, flow)


def _marks(results: Mapping[str, object]) -> Marks:
    """Marks of all results in the figures of the profiles."""
    marks = Marks()
    for lines, places, track in (QUANTITIES[name].marks(result) for name, result in results.items()):
        marks = Marks({**marks.lines, **lines}, {**marks.places, **places}, track or marks.track)
    return marks


def _titled(shown: Drawings, flow: Flow) -> dict[str, Chart | Bars | Map]:
    return {name: replace(what, name=flow.title) for name, what in shown.items() if what is not None}


def figure(
    name: str, shown: Mapping[str, Chart | Bars | Map], dump: Path, flow: Flow, arrows: ForceArrows | None = None
) -> Figure:
    """The matplotlib figure of this name, of `drawings` or the discs themselves; `arrows` are drawn among these."""
    return draw.film.snapshots(open_dump(dump), flow, arrows) if name == DISCS else draw.style.drawn(shown[name])


def felt(gathered: Gathered) -> ForceArrows | None:
    """The forces of a run as arrows on its structures, or None without a record of forces."""
    return ForceArrows.recorded(gathered.flow, gathered.forces, gathered.pressure)


def draw_figures(
    names: Sequence[str],
    shown: Mapping[str, Chart | Bars | Map],
    folder: Path,
    dump: Path,
    flow: Flow,
    ending: str = "png",
    arrows: ForceArrows | None = None,
    use_picture: Callable[[Image], None] | None = None,
) -> None:
    """Draw figures into a folder, as files with this ending; `arrows` as of `figure`, `use_picture` of `style.save`."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise DumpError(f"{folder}: cannot be made ({error.strerror}); name another folder.") from error
    for name in names:
        draw.style.save(figure(name, shown, dump, flow, arrows), folder / f"{name}.{ending}", use_picture)


def draw_discs(folder: Path, dump: Path, flow: Flow, arrows: ForceArrows | None = None) -> Picture | None:
    """Draw the figure of the discs into the figures of a folder; the same for a page."""
    small: list[bytes] = []

    def keep(picture: Image) -> None:
        with suppress(OSError, ValueError):  # the page makes it of the file
            small.append(smaller(picture))

    draw_figures([DISCS], {}, folder / "figures", dump, flow, arrows=arrows, use_picture=keep)
    return still_of(folder, *small)


def _film(gathered: Gathered, dump: Path, out: Path, warnings: list[str], quiet: bool) -> list[str]:
    """The film; without ffmpeg a GIF and a note, and no failure where that cannot be made either."""

    def told(done: int, total: int) -> None:
        print(f"\ranimation: {done} of {total} frames", end="\n" if done == total else "", flush=True)

    progress = None if quiet or not sys.stdout.isatty() else told
    try:
        path = out / "animation.mp4"
        made = draw.film.animate(open_dump(dump), gathered.flow, path, arrows=felt(gathered), progress=progress)
    except SetupError as error:
        warnings.append(f"no animation: {error}")
        return []
    warnings += [draw.film.NO_FFMPEG] if made != path else []
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
        "window": list(window_of(profiles)),
        "window_frames": profiles.attrs["window_frames"],
    }
