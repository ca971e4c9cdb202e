# SPDX-License-Identifier: GPL-2.0-or-later
"""Cases and results as HTML: for notebooks, and the page of a case before it is run."""

from __future__ import annotations

import base64
import html
from collections.abc import Sequence
from dataclasses import fields
from math import isfinite
from pathlib import Path

from lammps_jump.analysis import draw, report
from lammps_jump.case.case import ReadCase
from lammps_jump.files import read_file, write_text, writes
from lammps_jump.scene.motion import MovingWall
from lammps_jump.scene.scene import Scene
from lammps_jump.scene.walls import Interval
from lammps_jump.units import numbers_of, shown, sure_of

from .folder import default_folder

COEFFICIENTS = ("mass", "stiffness", "restitution", "friction", "damping", "time_step", "contact_duration")
"""The coefficients that are shown."""
MOTION_WORDS = {"begin": "from"}
"""Fields of a motion that a case calls otherwise."""
MOST_PICTURE = 100_000_000
"""Bytes of a picture."""


def case_html(name: str, scene: Scene) -> str:
    """Name, coefficients and the drawing of a case."""
    values = scene.coefficients
    units = {key: number.unit for key, number in numbers_of(values).items()}
    rows = "".join(f"<tr><td>{key}</td><td>{getattr(values, key):z.4g} {units[key]}</td></tr>" for key in COEFFICIENTS)
    drawing = draw.sketch.svg_text(draw.sketch.scene_drawing(scene))
    return f"<p><b>{html.escape(name)}</b>: {html.escape(scene.description)}</p><table>{rows}</table>{drawing}"


def number_table(results: Sequence[object]) -> str:
    """The labelled numbers of some results, at most five, each with its standard error."""
    rows = [
        (number.meaning, shown(value, number.unit, sure_of(result, number.key).value))
        for result in results
        for number in numbers_of(result).values()
        if number.label != number.meaning and (value := getattr(result, number.key)) == value
    ]
    cells = (f"<tr><td>{html.escape(name)}</td><td>{html.escape(text)}</td></tr>" for name, text in rows[:5])
    return f"<table>{''.join(cells)}</table>"


def drawing_of(case: ReadCase, widest: float = draw.sketch.WIDEST) -> draw.sketch.Drawing:
    """Drawing of a case before it is run, at most so many pixels wide.

    Raises
    ------
    CaseError
        A scene that cannot be run.
    """
    found, asked = case.check(), case.fields
    columns = [item for item in asked.initial if item.kind == "column"]
    regions = [
        draw.sketch.NamedRegion("column" if len(columns) == 1 else f"column {number}", item.x, item.y)
        for number, item in enumerate(columns, start=1)
    ]
    expected = found.numbers.get("belanger_y2") if asked.analysis.jump else None
    sequent = expected if isinstance(expected, float) else None
    return draw.sketch.scene_drawing(found.scene, regions, sequent=sequent, widest=widest)


def write_preview(case: ReadCase, folder: str | Path = ".") -> tuple[Path, Path]:
    """Draw a case before it is run; page and picture, ``<stem>.preview.html`` and ``.png`` in the folder.

    Raises
    ------
    CaseError
        A scene that cannot be run.
    DumpError
        The folder cannot be written.
    """
    found, folder = case.check(), Path(folder)
    scene = found.scene
    name = default_folder(case).name
    picture, path = folder / f"{name}.preview.png", folder / f"{name}.preview.html"
    with writes(folder):
        folder.mkdir(parents=True, exist_ok=True)
    draw.save(draw.sketch.figure(drawing_of(case)), picture)
    page, data = report.page, base64.b64encode(read_file(picture, MOST_PICTURE)).decode()
    caption = "At the start, to scale" + ("; dashed shapes and red arrows: how walls move" if scene.moves else "")
    first: list[report.Block] = [
        page.Picture(caption, f"data:{page.PNG};base64,{data}"),
        page.Items(found.begins, "Where it begins"),
    ]
    first.append(page.Items(scene.warnings, "Doubtful"))
    walls = page.Table([_wall_row(one, scene) for one in scene.walls], ("Wall", "kind", "x [m]", "y [m]", "motion"))
    rows = [(label, value, unit) for _, group in found.tables for _, label, value, unit in group]
    numbers = page.Table(rows, ("Number", "value", "unit"), "All numbers that follow from the case")
    title = f"{case.name}: before the run"
    sections = [report.Section("", first), report.Section("", [walls, numbers])]
    text = report.render(title, sections, tab=f"{case.name}: preview", name=scene.description)
    with writes(path):
        return write_text(path, text), picture


def _wall_row(one: MovingWall, scene: Scene) -> tuple[str, ...]:
    """Name, kind, place and motion of a wall, in words."""
    wall, motion = one
    moves = "stands"
    if motion.kind is not None:
        given = {part.name: (getattr(motion.kind, part.name), part.default) for part in fields(motion.kind)}
        told = (
            f"{MOTION_WORDS.get(name, name)} {_plain(value)}"
            for name, (value, default) in given.items()
            if value != default
        )
        moves = f"{motion.kind.kind}: {', '.join(told)}"
    if isfinite(motion.gone):
        moves = f"opens at t = {scene.time(int(motion.gone)):z.4g} s" + (f"; {moves}" if motion.kind else "")
    return wall.name, wall.kind, *map(_ends, wall.extent), moves


def _ends(side: Interval) -> str:
    """An interval in words; of a plane the one number, and nothing where there is no end."""
    low, high = side
    if not (isfinite(low) or isfinite(high)):
        return ""
    text = f"{low:z.4g}" if low == high else f"{low:z.4g} … {high:z.4g}"
    return text.replace("-", "\N{MINUS SIGN}")


def _plain(value: object) -> str:
    """A value of a motion; of a long table its number of rows."""
    if isinstance(value, tuple) and value and isinstance(value[0], tuple):
        return f"{len(value)} rows"
    if isinstance(value, tuple):
        return f"({', '.join(map(_plain, value))})"
    return f"{value:zg}" if isinstance(value, int | float) else str(value)
