# SPDX-License-Identifier: GPL-2.0-or-later
"""Table of ``lammps-jump validate``, from ``validation.json``, and keys that tell when it is stale."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

from lammps_jump import load_case
from lammps_jump.files import plain
from lammps_jump.identity import short_hash
from lammps_jump.studies.points import LAW_FILE, MEASURE_FILE, TREE
from lammps_jump.studies.validation import Law, find_laws, summary_text

OWN_PAGES = ("thesis", "others")
"""Laws whose rows stand in a table of their own."""
FIGURE = "\ndef figure("
"""What stands before it in a ``law.py`` decides the table: points, closed forms, limits."""


def names(page: str = "") -> list[str]:
    """Laws of the common page, or that of a page of its own."""
    return [page] if page else [name for name in find_laws(TREE) if name not in OWN_PAGES]


def rows(folder: Path, page: str = "") -> Mapping[str, Any]:
    """What the table needs of a study; the rest of its file is curves and single runs.

    Raises
    ------
    ValueError
        The study is the short form, or not of every law, or a run failed.
    """
    found = json.loads((folder / "validation.json").read_text(encoding="utf-8"))
    failed = [f"{name}: {text}" for name, law in found["laws"].items() for text in law["failures"]]
    if found["quick"] or failed or not found["laws"].keys() >= set(names(page)):
        command = f"lammps-jump validate {page}".rstrip()
        raise ValueError(f"{folder}: run `{command}`, all its laws, without --quick; failed: {failed}")
    return {"laws": {name: {"rows": found["laws"][name]["rows"], "failures": []} for name in names(page)}}


def table(data: Mapping[str, Any]) -> str:
    """The table of all laws, Markdown."""
    return summary_text(data)


@cache
def keys(page: str = "") -> dict[str, str]:
    """Hash of what decides the rows of each law, as it is today."""
    return {name: key(TREE / name, law) for name, law in find_laws(TREE, names(page)).items()}


def key(folder: Path, law: Law) -> str:
    """Hash of the cases, options and starts of a law, of its measuring functions, and of what makes rows of them.

    Engines are left out: which of them run differs from machine to machine.
    """
    points = set()
    for point in law.points(False):
        case = load_case(folder / point.case).replace(point.changes).hash if point.case else None
        options = {name: value for name, value in plain(point.options).items() if name != "kernel"}
        points.add(short_hash({"case": case, "measure": point.measure, "options": options, "starts": point.starts}))
    texts = [(folder / name).read_text(encoding="utf-8") for name in (MEASURE_FILE, LAW_FILE)]
    return short_hash({"points": sorted(points), "text": [text.partition(FIGURE)[0] for text in texts]})
