# SPDX-License-Identifier: GPL-2.0-or-later
"""Commands that look at a run or a dump: analyze, show, compare, animate, figures, export."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

import lammps_jump as lj
from lammps_jump import dump, runs, studies, sweeps
from lammps_jump.analysis.quantities import LISTED
from lammps_jump.errors import CaseError
from lammps_jump.files import STUDY_FILES
from lammps_jump.folders import read_marker
from lammps_jump.quoting import typed

from .options import Quiet, Sets, Verbose, diameters, log_printed, open_page, place, places, plane_of, quantity
from .progress import print_summary

app = typer.Typer(rich_markup_mode=None)
Arrows = Annotated[
    bool, typer.Option("--arrows/--no-arrows", help="Forces and pressure as arrows on the outlines of structures.")
]


def looking(command: Callable[..., None]) -> Callable[..., None]:
    """The command with an option for each analysis available for a bare dump; it gets their names."""
    asks = {one.option or name: name for name, one in LISTED.items() if one.look}

    @wraps(command)
    def looks(**given: Any) -> None:
        analyses = tuple(name for option, name in asks.items() if given.pop(option, False))
        command(**given, analyses=analyses)

    words = {option: LISTED[name].look for option, name in asks.items()}
    options = {
        option: typer.Option(f"--{option}", help=f"{said} (a bare dump without such an option: jump and front).")
        for option, said in words.items()
    }
    own = inspect.signature(command, eval_str=True).parameters
    kinds = {name: one.annotation for name, one in own.items() if name != "analyses"}
    kinds |= {option: Annotated[bool, one] for option, one in options.items()}
    first = {name: one.default for name, one in own.items()}
    keyword = inspect.Parameter.KEYWORD_ONLY
    parameters = [
        inspect.Parameter(name, keyword, default=first.get(name, False), annotation=kind)
        for name, kind in kinds.items()
    ]
    looks.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    return looks


FOLDER = "Run folder, or folder of a dump's results."
OR_STUDY = "Folder of a run, of a study, or of a dump's results."


@app.command()
@looking
def analyze(
    targets: Annotated[
        list[Path],
        typer.Argument(
            help="Run folder, or any LAMMPS custom dump with x y: a file, or 'dump.*.lammps'.",
            metavar="TARGET",
            show_default=False,
        ),
    ],
    out: Annotated[Path | None, place("Folder for the results of a bare dump (default: beside it).")] = None,
    case: Annotated[Path | None, typer.Option("--case", help="Case file that belongs to a bare dump.")] = None,
    diameter: Annotated[
        Any,
        typer.Option(
            parser=diameters,
            metavar="NUMBER",
            help="Disc diameter, m or '2 cm'; of each type: 1=0.2,2=0.1 (of a bare dump; default: guessed).",
        ),
    ] = None,
    density: Annotated[
        float | None,
        quantity("kg/m^3", "Density of the material, kg/m^3 (of a bare dump; default: from its masses, else 1000)."),
    ] = None,
    bodies: Annotated[
        Literal["spheres", "cylinders", "discs"] | None,
        typer.Option("--bodies", help="What its masses are of (of a bare dump; default: told by mass and diameter)."),
    ] = None,
    time_step: Annotated[
        float | None, quantity("s", "Time step, s or '0.1 ms' (of a bare dump without times).")
    ] = None,
    gravity: Annotated[
        float | None, quantity("m/s^2", "Gravity, downward, m/s^2 (of a bare dump; default: 9.81).")
    ] = None,
    bin_width: Annotated[float | None, quantity("m", "Width of a profile bin, m.")] = None,
    stations: Annotated[
        Any,
        typer.Option(
            "--stations",
            parser=places,
            metavar="X,X…",
            help="Places between which the head lost is told, m, such as 2,8.5,17.",
        ),
    ] = None,
    set_: Sets = None,
    quiet: Quiet = False,
    verbose: Verbose = False,
    analyses: tuple[str, ...] = (),
) -> None:
    """Depth profiles, jump, front, forces and figures of a run folder or of any dump."""
    guessed = {"--diameter": diameter, "--density": density, "--time-step": time_step, "--bodies": bodies}
    guessed["--gravity"] = gravity
    of_a_dump = {"--out": out, "--case": case, **guessed}
    target = targets[0]
    if len(targets) == 1 and target.is_dir() and (target / "case.yaml").exists():
        for option, value in of_a_dump.items():
            if value is not None:
                raise CaseError(
                    f"{option} {value}: {target} is a run folder, whose case says all that and whose results stay in "
                    f"it; {option} goes with a bare dump: name the dump file itself to analyse it as one"
                )
        sets = [*(set_ or []), *([f"analysis.bin_width={bin_width}"] * bool(bin_width))]
        sets += [f"analysis.{name}=true" for name in analyses]
        sets += [f"analysis.stations=[{','.join(map(str, stations))}]"] if stations else []
        with log_printed(quiet):
            runs.start.reanalyse(target, sets)
        if not quiet:
            print_summary(lj.open_run(target).summary, target, verbose=verbose)
        return
    if case is None and set_:
        raise CaseError(f"--set {set_[0]}: changes a case, but a bare dump has no case; name one with --case")
    for option, number in guessed.items():
        if case is not None and number is not None:
            raise CaseError(f"{option} {number}: is also given by {case}; use either --case or {option}")
    loaded = None if case is None else lj.load_case(case, set_ or [])
    with log_printed(quiet):
        path = dump.find_dump(*targets)
        given = runs.results.AnalysisInputs(
            diameter, density, time_step, bin_width, bodies, analyses, stations or (), gravity
        )
        summary, folder = runs.results.analyse_dump(path, loaded, given, out)
    if not quiet:
        print_summary(summary, folder, verbose=verbose)


@app.command()
def animate(
    folder: Annotated[
        Path, typer.Argument(help="Run folder, folder of a dump's results, or dump.", show_default=False)
    ],
    out: Annotated[Path | None, place("File (.mp4 or .gif); default animation.mp4 in the folder.")] = None,
    fps: Annotated[int, typer.Option(help="Frames a second.", min=1, max=120)] = 20,
    arrows: Arrows = True,
) -> None:
    """Write a film of a run: discs coloured by speed, forces as arrows on the outlines of structures, time."""
    with log_printed(quiet=False):
        print(runs.results.animate(folder, out, fps, arrows=arrows))


@app.command()
def show(folder: Annotated[Path, typer.Argument(help=OR_STUDY, show_default=False)]) -> None:
    """Open the page of a run or of a study in the browser; prints its path."""
    marker = read_marker(folder)
    kind = marker.kind if marker else ""
    own = [folder / name for name in STUDY_FILES.get(kind, ()) if name.endswith(".html")]
    pages = [*own, *(folder / name for name in ("report.html", "sweep.html", "calibration.html"))]
    path = next((page for page in pages if page.is_file()), pages[0])
    if not path.is_file() and own:
        raise CaseError(f"{path}: there is no page; the command `lammps-jump {kind}` that began it makes it")
    if (folder / "study.yaml").is_file() and not path.is_file():
        page, command = (pages[2], "calibrate") if (folder / "rounds.json").is_file() else (pages[1], "sweep")
        raise CaseError(f"{page}: there is no page; `{typed(command, folder)}` makes it")
    if not path.is_file():
        raise CaseError(f"{path}: there is no report; `{typed('analyze', folder)}` makes the one of a run")
    _open(path)


@app.command()
def compare(
    first: Annotated[Path, typer.Argument(help=FOLDER, show_default=False)],
    second: Annotated[Path, typer.Argument(help="Another one, or a CSV file of your own.", show_default=False)],
    columns: Annotated[
        str | None,
        typer.Option(
            metavar="AXIS=COLUMN,TABLE.COLUMN=COLUMN",
            help="Columns of the run and of your file, SI: time=t,gauges.depth_5=h.",
        ),
    ] = None,
    out: Annotated[
        Path | None, place("Page to write (default: <first>_and_<second>.html), or folder for data.")
    ] = None,
) -> None:
    """Write a page of two runs side by side, or hold curves of a run against measured ones of your own."""
    if second.suffix == ".csv" or columns is not None:
        with log_printed(quiet=False):
            if columns is None:
                raise CaseError(f"{second}: say with --columns which column is what, such as time=t,gauges.depth_5=h")
            distances, folder = studies.compare_with_data(first, second, columns, out)
            print(studies.own_data.page(distances, first, second))
            print(folder)
        return
    path = out or Path(f"{first.absolute().name}_and_{second.absolute().name}.html")
    with log_printed(quiet=False):
        _open(runs.compare_folders(first, second, path))


def _open(path: Path) -> None:
    """Print the path of a page, and open it where there is a display."""
    print(path)
    open_page(path.absolute().as_uri())


@app.command()
def figures(
    folder: Annotated[Path, typer.Argument(help=OR_STUDY, show_default=False)],
    ending: Annotated[Literal["png", "pdf", "svg"], typer.Option("--format", help="Format of the files.")] = "png",
    arrows: Arrows = True,
) -> None:
    """Draw every figure of a run or of a study; prints the names of the files."""
    if (folder / "study.yaml").is_file():
        paths = sweeps.open_sweep(sweeps.runs_of_search(folder) or folder).figures(ending)
    elif runs.results.is_of_a_dump(folder):
        paths = runs.results.draw_dump(folder, ending)
    else:
        paths = lj.open_run(folder).figures(ending, arrows=arrows)
    print(*paths, sep="\n")


@app.command("slice")
def cut(
    target: Annotated[Path, typer.Argument(help="Dump of a flow in three dimensions.", show_default=False)],
    plane: Annotated[
        Any,
        typer.Argument(
            parser=plane_of, metavar="AXIS=PLACE", help="Plane of the slice, such as y=0.03, m.", show_default=False
        ),
    ],
    thickness: Annotated[
        float | None, quantity("m", "Thickness of the slice, m (default: the largest diameter).")
    ] = None,
    out: Annotated[Path | None, place("Dump to write (default: <dump>_slice.lammpstrj beside it).")] = None,
) -> None:
    """Write the bodies near a plane of a dump of three dimensions as a dump of one layer."""
    written = out or target.with_name(f"{target.name.split('.')[0]}_slice.lammpstrj")
    most, thick = dump.write_slice(target, plane[0], plane[1], written, thickness)
    print(f"{written}: at most {most} bodies, {thick:z.4g} m thick; `{typed('analyze', written)}` analyses it")


@app.command()
def export(
    target: Annotated[Path, typer.Argument(help=FOLDER, show_default=False)],
    vtk: Annotated[
        bool, typer.Option("--vtk", help="Discs and walls of ten frames for ParaView; fields where asked for.")
    ] = False,
    csv: Annotated[bool, typer.Option("--csv", help="Profiles as tables.")] = False,
    pictures: Annotated[bool, typer.Option("--pictures", help="picture0.dat … picture9.dat of the thesis.")] = False,
    out: Annotated[Path | None, place("Folder for the files (default: the folder itself).")] = None,
    crate: Annotated[
        bool, typer.Option("--crate", help="ro-crate-metadata.json of a run or study: a bundle to cite.")
    ] = False,
    licence: Annotated[
        str | None, typer.Option("--license", help="Of the bundle: a name of SPDX, such as CC-BY-4.0, or an address.")
    ] = None,
) -> None:
    """Write what other programs read; prints the names of the files."""
    kinds = [name for name, wanted in (("vtk", vtk), ("csv", csv), ("pictures", pictures)) if wanted]
    if not kinds and not crate:
        raise CaseError("export: nothing to write; name one or more of --vtk, --csv, --pictures and --crate")
    if crate and (licence is None or out is not None):
        said = (
            "--license, such as CC-BY-4.0" if licence is None else "no --out: a bundle lies in the folder it describes"
        )
        raise CaseError(f"export --crate: needs {said}")
    written = runs.results.export(target, kinds, out) if kinds else []
    print(*written, *([runs.crate.write_crate(target, licence or "")] if crate else []), sep="\n")
