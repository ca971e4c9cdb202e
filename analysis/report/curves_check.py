# SPDX-License-Identifier: GPL-2.0-or-later
"""Curves that were handed on: what a page takes of the ``curves.json`` of a folder, field by field.

A page draws what it holds, so that a number in the place of a text, or a line without its points, would end its script.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, Field, FiniteFloat, RootModel, ValidationError, model_validator

from lammps_jump.analysis.quantities import captions
from lammps_jump.errors import DumpError
from lammps_jump.files import CURVES, MOST_JSON, read_file
from lammps_jump.quoting import shortened, typed

MOST_LINES, MOST_VALUES, MOST_PANELS = 1_000, 10_000, 100
Number = Annotated[FiniteFloat, Field(ge=-1e300, le=1e300)]
Text = Annotated[str, Field(max_length=500)]
Values = Annotated[list[Number | None], Field(max_length=MOST_VALUES)]
Ends = tuple[Number | None, Number | None]
Labelled = Annotated[list[tuple[Text, Number | None]], Field(max_length=MOST_LINES)]


class _CurvePart(BaseModel, strict=True, extra="forbid"):
    pass


class _Line(_CurvePart):
    label: Text
    look: Literal["first", "second", "third", "sum", "theory", "measured", "fit", "faint", "dots"]
    x: Values | None = None
    y: Values
    error: Values | None = None


class _Panel(_CurvePart):
    y: Text
    x: Text
    lines: Annotated[list[_Line], Field(max_length=MOST_LINES)]
    levels: Labelled
    marks: Labelled
    solids: Annotated[
        list[Annotated[list[tuple[Number, Number]], Field(max_length=MOST_VALUES)]], Field(max_length=MOST_LINES)
    ]
    xlim: Ends
    ylim: Ends
    height: Annotated[FiniteFloat, Field(gt=0, le=100)]

    @model_validator(mode="after")
    def lines_are_whole(self) -> _Panel:
        """Each line has as many places as values, its own or those of the first one."""
        for line in self.lines:
            places = line.x if line.x is not None else self.lines[0].x
            if places is None or len(places) != len(line.y) or len(line.error or line.y) != len(line.y):
                raise ValueError("a line needs as many values as places")
        return self


class _Chart(_CurvePart):
    title: Text
    x: Text
    time: bool
    window: tuple[Number, Number] | None
    panels: Annotated[list[_Panel], Field(max_length=MOST_PANELS)]


class _Bars(_CurvePart):
    title: Text
    x: Text
    bars: Labelled


class _StoredCurves(RootModel[dict[Text, _Chart | _Bars]]):
    pass


def read_curves(folder: Path) -> dict[str, dict[str, Any]]:
    """Figures that a page draws of a folder, by their names; empty where there is no such file.

    Raises
    ------
    DumpError
        It is none that this program has written; with the field.
    """
    path = folder / CURVES
    try:
        stored = _StoredCurves.model_validate_json(read_file(path, MOST_JSON))
    except FileNotFoundError:
        return {}
    except OSError as error:
        raise DumpError(f"{path}: cannot be read ({error.strerror or error})") from None
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        place = ".".join(map(str, first["loc"]))
        raise DumpError(
            f"{path}: {shortened(place)}: {shortened(first['msg'])}; `{typed('analyze', folder)}` makes it again"
        ) from None
    known = captions()
    return {name: one.model_dump(exclude_unset=True) for name, one in stored.root.items() if name in known}
