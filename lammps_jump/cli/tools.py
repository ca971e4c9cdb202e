# SPDX-License-Identifier: GPL-2.0-or-later
"""Commands about cases and this machine: check, preview, new, schema, doctor, kernels."""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

import lammps_jump.case as cases
from lammps_jump import cli, compiling, engines, files, runs, studies

from .options import Accuracy, CaseFile, Commands, EngineName, Kernel, Sets, assignments, place

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


@app.command()
def check(
    case: CaseFile,
    engine: EngineName = None,
    kernel: Kernel = None,
    accuracy: Accuracy = None,
    set_: Sets = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON instead of a table.")] = False,
    picture: Annotated[bool, typer.Option("--picture", help="Also draw the case, as `preview` does.")] = False,
) -> None:
    """Check a case and print all numbers that follow from it. Runs nothing; writes nothing without --picture."""
    loaded = cases.load_case(case, assignments(set_, engine=engine, kernel=kernel, accuracy=accuracy))
    resolved, chosen = engines.accuracy.with_accuracy(loaded)
    found = resolved.check()
    found = replace(found, scene=replace(found.scene, warnings=(*found.warnings, *chosen)))
    measured = studies.fluid.stored(resolved)
    if as_json:
        data = found.as_data() | ({"fluid": files.plain(measured)} if measured else {})
        print(json.dumps(data, indent=2, allow_nan=False))
    else:
        print(found, *([studies.fluid.told(measured)] if measured else []), sep="\n\n")
    if picture:
        written = runs.view.write_preview(resolved)
        print(*written, sep="\n", file=sys.stderr if as_json else sys.stdout)


@app.command()
def preview(
    case: CaseFile,
    out: Annotated[Path | None, place("Folder for page and picture (default: the current folder).")] = None,
    set_: Sets = None,
) -> None:
    """Draw a case before it is run: walls, motions, discs, inlets, outlets; prints the names of page and picture."""
    print(*runs.view.write_preview(cases.load_case(case, assignments(set_)), out or Path()), sep="\n")


@app.command()
def new(scene: Annotated[str, typer.Argument(help="Scene to start from; without it, the list.")] = "") -> None:
    """Print a starting case of a scene, as in `lammps-jump new dam_break > my_case.yaml`."""
    print(SCHEMA_LINE + cases.scene_text(scene) if scene else "\n".join(cases.scene_names()), end="" if scene else "\n")


@app.command()
def schema() -> None:
    """Print the JSON schema of case files, for editors."""
    draft = {"$schema": "https://json-schema.org/draft/2020-12/schema"}
    print(json.dumps({**draft, **cases.CaseFields.model_json_schema()}, indent=2))


@app.command()
def doctor() -> None:
    """Tell what this machine lacks, and how to install it."""
    text, healthy = cli.doctor.examine()
    print(text)
    if not healthy:
        raise typer.Exit(1)


@kernels.command("build")
def kernels_build(
    force: Annotated[bool, typer.Option("--force", help="Build again even where a whole one is cached.")] = False,
) -> None:
    """Build the plugin for LAMMPS and the core into the cache, for administrators and job files; prints their paths."""
    found = compiling.build_all(engines.plugin.PRODUCTS, force=force, tell=partial(print, file=sys.stderr))
    print(*(path for path in found if isinstance(path, Path)), sep="\n")
    print(*(reason for reason in found if isinstance(reason, str)), sep="\n", end="", file=sys.stderr)
    if not all(isinstance(path, Path) for path in found):
        raise typer.Exit(1)


@kernels.command("status")
def kernels_status() -> None:
    """Tell whether the plugin and the core can be used here."""
    states = {product.title: compiling.availability(product) for product in engines.plugin.PRODUCTS}
    for title, status in states.items():
        print(f"{title}: {status.reason}")
    if not all(status.available for status in states.values()):
        raise typer.Exit(1)
