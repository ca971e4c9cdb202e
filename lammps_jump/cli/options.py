# SPDX-License-Identifier: GPL-2.0-or-later
"""Options that several commands share."""

from __future__ import annotations

import logging
import os
import sys
import webbrowser
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from lammps_jump.units import to_si


class Commands(TyperGroup):
    """A group of commands whose help lists the whole first sentence of each; click cuts it to one line."""

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the list of commands."""
        with formatter.section("Commands"):
            formatter.write_dl([(name, command.get_short_help_str(1000)) for name, command in self.commands.items()])


def folder_option(text: str) -> Path:
    """A folder or file of ``--out``; an empty text, as of an unset variable of a shell, is refused."""
    if not text.strip():
        raise typer.BadParameter("--out is empty; name a folder, or write `--out .` for the current folder")
    return Path(text)


def place(text: str) -> Any:
    """The option ``--out``, with its help."""
    return typer.Option("--out", parser=folder_option, metavar="PATH", help=text)


def results_place(text: str) -> Any:
    """The option ``--out`` of a study, with its help: a place where no folder can be made is refused at once."""
    return typer.Option("--out", parser=results_folder, metavar="PATH", help=text)


def results_folder(text: str) -> Path:
    """A folder of ``--out`` that is there, or can be made."""
    path = folder_option(text)
    there = next(place for place in (path, *path.absolute().parents) if os.path.lexists(place))
    if not there.is_dir() or not os.access(there, os.W_OK):
        raise typer.BadParameter(f"{there} is no folder that can be written to; name another one")
    return path


def quantity(unit: str, text: str) -> Any:
    """An option for a number above 0 in `unit` or a text with a unit, such as '2 cm'."""

    def parse(given: str) -> float:
        try:
            return positive(given, unit)
        except ValueError as error:
            raise typer.BadParameter(str(error)) from None

    return typer.Option(parser=parse, metavar="NUMBER", help=text)


def positive(given: str, unit: str) -> float:
    """The number of a text in `unit`; ValueError where it is not above 0."""
    number: float = to_si(given, unit)
    if not number > 0:
        raise ValueError(f"{given} is out of range; allowed is > 0 {unit}")
    return number


def diameters(given: str) -> float | dict[int, float]:
    """Diameter of all discs, m, or of each type: ``0.2``, ``2 cm`` or ``1=0.2,2=10 cm``."""
    try:
        if "=" not in given:
            return positive(given, "m")
        pairs = [part.split("=") for part in given.split(",")]
        return {int(kind): positive(diameter, "m") for kind, diameter in pairs}
    except ValueError as error:
        raise typer.BadParameter(f"{error}; for discs of several types write 1=0.2,2=0.1") from None


def places(given: str) -> tuple[float, ...]:
    """Two or more places along x, m: ``2,8.5`` or ``2 m, 850 cm``."""
    try:
        coordinates = tuple(float(to_si(part, "m")) for part in given.split(","))
    except ValueError as error:
        raise typer.BadParameter(f"{error}; write two places or more, such as 2,8.5,17") from None
    if len(coordinates) < 2:
        raise typer.BadParameter(f"{given}: one place; write two or more, such as 2,8.5,17")
    return coordinates


def plane_of(given: str) -> tuple[str, float]:
    """Axis across a plane and its place along it, m: ``y=0.03``."""
    axis, _, place = given.partition("=")
    try:
        if axis not in ("x", "y", "z"):
            raise ValueError(f"{given}: no plane")
        return axis, float(to_si(place, "m"))
    except ValueError as error:
        raise typer.BadParameter(f"{error}; write x, y or z and a place, such as y=0.03") from None


CaseFile = Annotated[
    Path, typer.Argument(help="Case file (YAML); inputs/ holds one for each scene.", show_default=False)
]
Sets = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        help="Change one value: path=value, list items by index or name. May be repeated.",
        metavar="PATH=VALUE",
    ),
]
Out = Annotated[Path | None, place("Folder for the results (default: runs/<stem of the case file>,<changes>).")]
EngineName = Annotated[str | None, typer.Option("--engine", help="lammps, native or twin.")]
Kernel = Annotated[str | None, typer.Option("--kernel", help="auto, stock or compiled (LAMMPS only).")]
Ranks = Annotated[str | None, typer.Option("--ranks", help="Number of MPI ranks, or auto.")]
Accuracy = Annotated[
    str | None,
    typer.Option(
        "--accuracy",
        help="Use the cheapest setting shown to be that accurate, such as 1% (page 'Run time against error').",
    ),
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="No progress, no notes; errors only.")]
Verbose = Annotated[bool, typer.Option("--verbose", help="All numbers at the end, as in a pipe.")]
QuietStudy = Annotated[bool, typer.Option("--quiet", "-q", help="No progress and no notes, only the results.")]
Resume = Annotated[
    bool,
    typer.Option(
        "--resume", help="Continue the interrupted run in the folder; without a checkpoint, start from the beginning."
    ),
]
Force = Annotated[bool, typer.Option("--force", help="Delete the run that the folder holds, and start anew.")]
Jobs = Annotated[
    int | None, typer.Option("--jobs", min=1, help="Runs at once (default: one for each core that may be used).")
]
SlurmSite = Annotated[
    Path | None, typer.Argument(help="Site file for --slurm (YAML; page 'On a cluster').", show_default=False)
]
Slurm = Annotated[
    bool, typer.Option("--slurm", help="Submit what is left as one array job; --jobs limits its tasks at once.")
]
Members = Annotated[str | None, typer.Option(help="Starts of each point: 4, or the seeds 9-16.")]
Collect = Annotated[
    str | None, typer.Option(help="Numbers of summary.json with commas between, such as jump.y2,jump.speed.")
]
Until = Annotated[
    list[str] | None,
    typer.Option("--until", metavar="PATH=SHARE", help="Add members until the interval is as narrow: jump.speed=3%."),
]
Laws = Annotated[
    Path | None, typer.Option("--laws", help="Folder of laws and studies (default: validation/ of the source tree).")
]
Fresh = Annotated[bool, typer.Option("--fresh", help="Measure again what is stored.")]


PATHS = {"engine": "engine.name", "kernel": "engine.kernel", "ranks": "engine.ranks", "accuracy": "run.accuracy"}
"""Fields of a case that have an option."""


def assignments(sets: list[str] | None, **given: str | None) -> list[str]:
    """Texts ``path=value`` of ``--set`` and of the options of `PATHS`."""
    return [*(sets or []), *(f"{PATHS[name]}={value}" for name, value in given.items() if value is not None)]


def open_page(address: str) -> None:
    """Open an address in the browser where there is a display."""
    if has_display():
        webbrowser.open(address)


def has_display() -> bool:
    """Tells whether a browser can be seen here."""
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def sayer(quiet: bool) -> Callable[[str], None]:
    """Function that prints a line, or nothing."""
    return (lambda text: None) if quiet else (lambda text: print(text, flush=True))


@contextmanager
def log_printed(quiet: bool) -> Iterator[None]:
    """Print what the program says while the block runs, unless `quiet`."""
    logger, printer = logging.getLogger("lammps_jump"), logging.StreamHandler(sys.stdout)
    before = logger.level
    if not quiet:
        logger.addHandler(printer)
        logger.setLevel(logging.INFO)
    try:
        yield
    finally:
        logger.removeHandler(printer)
        logger.setLevel(before)
