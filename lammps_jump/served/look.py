# SPDX-License-Identifier: GPL-2.0-or-later
"""Look at the text of a case for its page: errors at their lines, the drawing with its places, derived numbers.

Also the text with the walls of a drawing that is dropped on the page.
"""

from __future__ import annotations

import re
from dataclasses import asdict
from pathlib import Path
from typing import Any, NamedTuple

from lammps_jump import drawings, engines, live, runs
from lammps_jump.analysis.draw.sketch import svg
from lammps_jump.case.case import ReadCase
from lammps_jump.case.packing import disc_sizes, discs_at_start
from lammps_jump.errors import CaseError, JumpError
from lammps_jump.files import plain
from lammps_jump.quoting import typed
from lammps_jump.units import shown

from .places import Places

NARROWEST, WIDEST = 240, 2000
"""Pixels of a drawing."""
MOST_DISCS = 1_000_000
"""Discs of a case that a page draws; a few seconds."""
MOST_DRAWN = 12_000_000
"""Bytes of a drawing that a page sends: with a text of a case beside it, it fits into a request."""


class DroppedFile(NamedTuple):
    """A drawing that a page sends: the name of its file, its bytes, and its unit or scale where one is given."""

    name: str
    data: bytes
    scale: str | None


def look(text: str, file: Path, wide: int) -> dict[str, Any]:
    """Findings of `check` and `preview` in the text of a case file, for a drawing of this width, pixels.

    Of a case that cannot be used it is ``error`` alone: line (or None) and message.
    """
    try:
        case = ReadCase.parse(text, str(file), folder=file.parent)
        many = discs_at_start(case.fields, disc_sizes(case.fields))
        if many > MOST_DISCS:
            raise CaseError(
                f"{file}: {many} discs at the start; this page draws up to {MOST_DISCS}, and `lammps-jump preview` more"
            )
        resolved, chosen = engines.accuracy.with_accuracy(case)
        found = resolved.check()
        widest = min(max(wide, NARROWEST), WIDEST) - svg.LEFT - svg.RIGHT
        drawing = runs.view.drawing_of(resolved, widest)
    except JumpError as error:
        return {"error": located(str(error), str(file))}
    places = Places(case.source, text)
    groups = [(title, [(label, shown(value), unit) for _, label, value, unit in rows]) for title, rows in found.tables]
    return plain(
        {
            "name": case.name,
            "description": case.fields.description,
            "drawing": svg.svg_text(drawing),
            "view": {"left": svg.LEFT, "top": svg.ABOVE, "x": drawing.x, "y": drawing.y, "scale": drawing.scale},
            "numbers": [asdict(one) for one in places.numbers],
            "places": [asdict(one) for one in places.found],
            "derived": [group for group in groups if group[1]],
            "doubtful": [*found.warnings, *chosen],
            "notes": [*found.begins, *found.slopes, *found.skipped],
        }
    )


def flow_page(text: str, file: Path) -> str:
    """A live page of the text of a case file, without sliders of numbers: those take a set-up for each value.

    Raises
    ------
    JumpError
        A text that is no case, or one that a live page cannot have.
    """
    return live.live_page(live.prepare(ReadCase.parse(text, str(file), folder=file.parent), numbers=False))


def flow_of_run(folder: Path, time: float) -> str:
    """A live page of a run from a time on, s, beside the run as it was recorded; without sliders of numbers.

    Raises
    ------
    JumpError
        A run that goes on, or whose files cannot be read; a time outside it; a case that a live page cannot have.
    """
    starts = live.from_times(ReadCase.load(folder), folder, [time], numbers=False)
    return live.live_page(starts, "", live.recorded_run(folder))


def with_drawing(text: str, file: Path, dropped: DroppedFile) -> dict[str, Any]:
    """The text of a case with the walls of a drawing, as ``import --into`` adds them; the file is not touched.

    Returns
    -------
    dict
        ``text``; ``added``: what each wall is; ``notes``: what is left out of the drawing or doubtful in it.

    Raises
    ------
    CaseError
        A text that is no case, a drawing that is too large, and as `read_drawing`, `entries` and `with_walls`.
    """
    name, data, scale = dropped
    if len(data) > MOST_DRAWN:
        raise CaseError(
            f"{name}: has {len(data) / 1e6:.1f} MB; the page takes up to {MOST_DRAWN / 1e6:g} MB, and "
            f"`{typed('import', Path(name), '--into', Path(file.name))}` more"
        )
    ReadCase.parse(text, file.name, folder=file.parent)
    drawing = drawings.read_drawing(name, scale=scale, data=data)
    found = drawings.entries(drawing)
    return {
        "text": drawings.with_walls(text, found, file.name),
        "added": [f"{one.wall['name']}: {', '.join(one.facts)}" for one in found],
        "notes": [*drawing.notes, *drawings.doubts(found, max(drawing.extent()))],
    }


def with_shape(text: str, file: Path, what: str, points: list[tuple[float, float]]) -> dict[str, Any]:
    """The text of a case with a shape that was drawn in its picture; a body has the density of the discs.

    Raises
    ------
    CaseError
        A text that is no case, and as `drawings.with_drawn`.
    """
    case = ReadCase.parse(text, str(file), folder=file.parent)
    return {"text": drawings.with_drawn(text, what, points, case.fields.discs.density, file.name)}


def located(message: str, file: str) -> dict[str, Any]:
    """A message about a case, without the name of its file, and the line that it is about."""
    hit = re.match(rf"{re.escape(file)}(?::(\d+))?: (.*)", message, re.DOTALL)
    return {"line": int(hit[1]) if hit and hit[1] else None, "text": hit[2] if hit else message}
