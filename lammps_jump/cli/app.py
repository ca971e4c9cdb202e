# SPDX-License-Identifier: GPL-2.0-or-later
"""The command line: groups of commands put together, and what becomes of errors."""

from __future__ import annotations

import gc
import importlib
import os
import sys
from pathlib import Path
from typing import Annotated

import typer

import lammps_jump
from lammps_jump.errors import JumpError, SetupError

from . import analyse, run, studies, tools
from .options import Commands
from .startup import patient_output, start_early

app = typer.Typer(
    name="lammps-jump",
    cls=Commands,
    context_settings={"max_content_width": 100},
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
for group in (run, analyse, tools, studies):
    app.add_typer(group.app)


def _version(wanted: bool) -> None:
    if wanted:
        print(f"lammps-jump {lammps_jump.__version__}")
        raise typer.Exit()


@app.callback()
def options(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and stop.")
    ] = False,
) -> None:
    """Free-surface flow with discs: one YAML case in; a LAMMPS script, a run, profiles, figures and a report out."""
    try:
        Path.cwd()
    except FileNotFoundError:
        raise SetupError("the current folder was deleted; change to another folder and try again") from None


def main() -> None:
    """Run the command line; a `JumpError` becomes one paragraph and an exit status, never a traceback."""
    # imports leave a million objects that stay; collecting among them took a tenth of the time of an analysis
    gc.set_threshold(50_000, 20, 50)
    start_early(sys.argv[1:])
    with patient_output() as output:
        drop_unknown_backend()
        status = _status()
        output.flush()
        if output.trouble is not None:
            print(f"error: standard output cannot be written ({output.trouble.strerror})", file=sys.stderr)
            status = status or 1
    gc.freeze()  # collecting at the end takes 0.3 s
    raise SystemExit(status)


def drop_unknown_backend() -> None:
    """Take a value of MPLBACKEND that matplotlib does not know out of the environment: its import would fail."""
    if name := os.environ.pop("MPLBACKEND", None):
        try:
            importlib.import_module("matplotlib").rcParams["backend"] = name
        except ValueError:
            print(f"note: MPLBACKEND={name} is not known to matplotlib and is left aside", file=sys.stderr)
        else:
            os.environ["MPLBACKEND"] = name


def _status() -> int:
    """Run the command; its exit status."""
    try:
        app(standalone_mode=True)
    except SystemExit as stop:
        if stop.code == 130:  # what typer makes of Ctrl-C
            print("\nstopped by Ctrl-C; no further files were written", file=sys.stderr)
        return int(stop.code or 0)
    except JumpError as error:
        print(f"error: {error}", file=sys.stderr)
        return error.exit_status
    except OSError as error:  # a disk that is full, a folder that was taken away
        place = f"{error.filename}: " if error.filename is not None else ""
        print(f"error: {place}{error.strerror or error}; what was written before is kept", file=sys.stderr)
        return 1
    except MemoryError:
        print("error: not enough memory; use fewer discs, frames or bins, or a larger machine", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    main()
