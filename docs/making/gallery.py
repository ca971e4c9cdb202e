# SPDX-License-Identifier: GPL-2.0-or-later
"""The gallery: every scene of ``inputs/`` with a picture and its command; short ones are run by the build."""

from __future__ import annotations

import shutil
from pathlib import Path

import lammps_jump as lj
from lammps_jump.case.templates import scene_names

QUICK = ("quick_jump", "dam_break", "dam_break_triangle", "sluice_gate", "drum", "hopper")
"""Scenes that take less than 20 s; a stored run of the same case is taken, not made again."""
HEAD = """\
# Gallery

Every scene of `inputs/`. `lammps-jump new SCENE` prints its case. Pictures of the short scenes are moments of their
run, and their report plays it. The other pictures show the case before it is run.
"""


def make(docs: Path) -> None:
    """Write the page, its pictures, and the reports of the short scenes."""
    place = docs / "_made" / "gallery"
    reports = docs / "_made" / "extra" / "reports"
    reports.mkdir(parents=True, exist_ok=True)
    place.mkdir(parents=True, exist_ok=True)
    blocks = [HEAD]
    for name in scene_names():
        case = lj.load_case(docs.parent / "inputs" / f"{name}.yaml")
        blocks += [f"## {name}\n", f"{case.fields.description}\n"]
        if name in QUICK:
            folder = case.run(docs / "_made" / "runs" / name).folder
            shutil.copy(folder / "figures" / "snapshots.png", place / f"{name}.png")
            shutil.copy(folder / "report.html", reports / f"{name}.html")
        else:
            _, picture = case.preview(place)
            picture.replace(place / f"{name}.png")
        blocks.append(f"![{name}](_made/gallery/{name}.png)\n")
        blocks.append(f"```console\n$ lammps-jump build-and-run inputs/{name}.yaml\n```\n")
        if name in QUICK:
            blocks.append(f'<a href="reports/{name}.html">Play its report</a>\n')
    (docs / "_made" / "gallery.md").write_text("\n".join(blocks))
