# SPDX-License-Identifier: GPL-2.0-or-later
"""The files of the pages: pages, styles and scripts of this folder and of the report, by their names alone."""

from __future__ import annotations

from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from lammps_jump.analysis.report import page
from lammps_jump.files import MOST_TEXT, read_file

from .server import Reply

KINDS = {
    ".html": "text/html; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
}
HERE, REPORT = Path(__file__).parent, Path(page.__file__).parent
ASSETS = {
    **{
        name: HERE / name
        for name in (
            "open.css",
            "ask.js",
            "case.js",
            "text.js",
            "places.js",
            "drop.js",
            "flow.js",
            "live.js",
            "run.js",
            "study.js",
            "axes.js",
        )
    },
    **{name: REPORT / name for name in ("page.css", *page.SCRIPTS)},
}
"""Nothing else is read for an address."""


def asset(name: str) -> Reply | None:
    """A file of `ASSETS`; None for another name."""
    path = ASSETS.get(name)
    return None if path is None else html(path)


def html(path: Path) -> Reply:
    """A file of this program."""
    return Reply(read_file(path, MOST_TEXT), KINDS[path.suffix])


def run_page() -> Reply:
    """The page of a run: the player of the report, empty."""
    loader = FileSystemLoader([HERE, REPORT])
    template = Environment(loader=loader, autoescape=True, undefined=StrictUndefined).get_template("run.html.j2")
    return Reply(template.render().encode(), KINDS[".html"])
