# SPDX-License-Identifier: GPL-2.0-or-later
"""Page of a report: sections of blocks, put into one HTML file that needs no network and no script."""

# ruff: noqa: RUF001  (Greek letters, minus signs and dashes are meant for readers)
from __future__ import annotations

import base64
import io
from collections.abc import Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup, escape

from lammps_jump.units import ABSENT, numbers_of, shown

KINDS = {".png": "image/png", ".gif": "image/gif", ".mp4": "video/mp4"}
Value = float | int | str | None


class Text(NamedTuple):
    """A paragraph; `kind` is '', 'lead', or 'verdict', 'warn', 'bad' for a box, which may start in bold."""

    text: str
    kind: str = ""
    bold: str = ""


class Mark(NamedTuple):
    """Text of a cell with a class of the page's style."""

    text: str
    kind: str


class Table(NamedTuple):
    """A table; columns that hold a number are aligned right."""

    rows: Sequence[Sequence[Value | Mark]]
    header: Sequence[str] = ()

    @property
    def numeric(self) -> list[bool]:
        """Whether a column holds a number, shape (columns,)."""
        columns = max((len(row) for row in self.rows), default=0)
        return [any(len(row) > i and _is_number(row[i]) for row in self.rows) for i in range(columns)]


class Boxes(NamedTuple):
    """Numbers in boxes: (label, value, unit) of each."""

    numbers: Sequence[tuple[str, Value, str]]


class Items(NamedTuple):
    """A list of sentences; with a title they stand in a box."""

    texts: Sequence[str]
    title: str = ""


class Code(NamedTuple):
    """Text as it is; with a summary it is folded away."""

    text: str
    summary: str = ""


class Picture(NamedTuple):
    """A picture or film as a data URI."""

    caption: str
    source: str


class Section(NamedTuple):
    """Part of a page under a heading; without a title the blocks follow what stands before."""

    title: str
    blocks: Sequence[Text | Table | Boxes | Items | Code | Picture]


def render(title: str, sections: Sequence[Section | None], *, tab: str = "") -> str:
    """One self-contained HTML page; `tab` is the browser's title.

    None among the sections, blocks that hold nothing, and sections of such blocks only are left out.
    """
    full = [
        Section(name, [block for block in blocks if block[0] or isinstance(block, Picture)])
        for name, blocks in filter(None, sections)
    ]
    return _template().render(title=title, tab=tab or title, sections=[section for section in full if section.blocks])


@lru_cache(maxsize=1)
def _template():
    loader = FileSystemLoader(Path(__file__).parent)
    environment = Environment(loader=loader, autoescape=True, undefined=StrictUndefined)
    environment.filters["shown"] = text
    environment.tests["a"] = lambda block, kind: type(block).__name__ == kind
    return environment.get_template("page.html.j2")


def _is_number(value: Value | Mark) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def text(value: Value) -> Markup:
    """A value as safe HTML: four digits, powers of ten written out, whole numbers in groups of three."""
    if isinstance(value, int) and not isinstance(value, bool):
        return Markup(f"{value:,}".replace(",", "\u202f").replace("-", "−"))
    plain = shown(value)
    if not isinstance(value, float):
        return escape(plain)
    mantissa, _, exponent = plain.partition("e")
    power = Markup("&thinsp;×&thinsp;10<sup>{}</sup>").format(int(exponent)) if exponent else ""
    return Markup(mantissa if exponent else mantissa.replace("-", "−")) + power


def described(result: type, found: Mapping[str, Value], *keys: str) -> list[tuple[str, Value]]:
    """Rows (meaning with unit, value) of a result's numbers, in words of their descriptions."""
    numbers = numbers_of(result)
    return [(heading(numbers[key].meaning, numbers[key].unit), found.get(key)) for key in keys]


def heading(meaning: str, unit: str) -> str:
    """Head of a row: the meaning, first letter large, with the unit in brackets."""
    first = meaning[:1].upper() if meaning[:1].isascii() else meaning[:1]  # a capital gamma would be another symbol
    return f"{first}{meaning[1:]}" + (f" [{unit}]" if unit else "")


def percent(share: float | None, digits: int = 1) -> str:
    """A share in per cent; with more than one digit its sign is shown."""
    if share is None:
        return shown(None)
    return f"{100 * share:{'+' if digits > 1 else ''}.{digits}f} %"


def with_error(found: Mapping, key: str, scale: float = 1.0) -> str:
    """A number of ``summary.json`` with its standard error within this run, where it has one."""
    value, error = found[key], found.get(f"{key}_error")
    if value is None:
        return ABSENT
    return shown(value / scale, error=None if error is None else error / scale).replace("-", "−")


def picture(path: Path, caption: str) -> Picture:
    """A PNG, GIF or MP4 file for the page; large pictures of discs, which PNG stores badly, become JPEG."""
    data, kind = path.read_bytes(), KINDS[path.suffix]
    if path.suffix == ".png" and len(data) >= 400_000:
        from PIL import Image

        buffer = io.BytesIO()
        Image.open(io.BytesIO(data)).convert("RGB").save(buffer, "JPEG", quality=85, optimize=True)
        if len(buffer.getvalue()) < 0.7 * len(data):
            data, kind = buffer.getvalue(), "image/jpeg"
    return Picture(caption, f"data:{kind};base64,{base64.b64encode(data).decode()}")
