"""One HTML page that needs no other file: sections of text, tables and embedded figures."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from jinja2 import Environment, FileSystemLoader, StrictUndefined


class Text(NamedTuple):
    """A paragraph; `kind` is empty, or 'verdict' or 'bad' for a box."""

    text: str
    kind: str = ""
    block = "text"


class Mark(NamedTuple):
    """Text of a cell with a class of the page's style."""

    text: str
    kind: str


class Table(NamedTuple):
    """A table; a cell is text or a `Mark`."""

    rows: Sequence[Sequence[str | Mark]]
    header: Sequence[str] = ()
    block = "table"


class Picture(NamedTuple):
    """A picture as a data URI."""

    caption: str
    source: str
    block = "picture"


class Section(NamedTuple):
    """Part of a page under a heading; without a title the blocks follow what stands before."""

    title: str
    blocks: Sequence[Text | Table | Picture]


def picture(path: Path, caption: str) -> Picture:
    """Return a PNG file for the page."""
    return Picture(caption, f"data:image/png;base64,{base64.b64encode(path.read_bytes()).decode()}")


def render(title: str, sections: Sequence[Section]) -> str:
    """Return the page as HTML text; everything in it is escaped."""
    loader = FileSystemLoader(Path(__file__).parent)
    environment = Environment(loader=loader, autoescape=True, undefined=StrictUndefined)
    return environment.get_template("page.html.j2").render(title=title, sections=sections)
