"""One HTML page that needs no other file: sections of text, tables and embedded figures."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import jinja2


@dataclass(frozen=True)
class Text:
    """A paragraph; `kind` is 'p', 'h3' (a heading), 'verdict' or 'bad' (a box)."""

    text: str
    kind: str = "p"


@dataclass(frozen=True)
class Table:
    """A table; cells whose text is in `marked` stand out."""

    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    marked: frozenset[str] = frozenset()


@dataclass(frozen=True)
class Picture:
    """A PNG file with its title."""

    title: str
    path: Path

    @property
    def source(self) -> str:
        """The file as a URL that holds its data."""
        return f"data:image/png;base64,{base64.b64encode(self.path.read_bytes()).decode()}"


@dataclass(frozen=True)
class Section:
    """Blocks under a heading, which may be empty."""

    heading: str
    blocks: Sequence[Text | Table | Picture]


def render(title: str, sections: Sequence[Section]) -> str:
    """Return the page as HTML text; everything in it is escaped."""
    loader = jinja2.FileSystemLoader(Path(__file__).parent)
    template = jinja2.Environment(loader=loader, autoescape=True).get_template("page.html.j2")
    return template.render(title=title, sections=sections)
