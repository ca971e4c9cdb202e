# SPDX-License-Identifier: GPL-2.0-or-later
"""The gallery: every scene of ``inputs/`` with moments of its run, its command, and its report to play.

The build runs the scenes whose engine takes less than 20 s. Results of the others are kept in ``docs/stored`` with the
key of their case; ``make gallery`` makes them again, ``make gallery X=NAME`` one of them. A build stops where a key is
not that of today's case.
"""

from __future__ import annotations

import io
import json
import shutil
import sys
from pathlib import Path

from PIL import Image, ImageOps

import lammps_jump as lj
from lammps_jump.analysis.draw.film import still
from lammps_jump.case.templates import scene_names
from lammps_jump.provenance import versions
from lammps_jump.runs.results import animate, flow_of

DOCS = Path(__file__).parents[1]
FOLDER = DOCS / "stored"
INPUTS = DOCS.parent / "inputs"
STORED: tuple[str, ...] = ("spillway",)
"""Scenes whose engine takes longer than 20 s on a free core."""
HEAD = """\
# Gallery

Every scene of `inputs/`. `lammps-jump new SCENE` prints its case. Pictures are moments of a run, and its report plays
it. The build of this site runs all scenes whose engine takes less than 20 s. Of the others it shows stored results,
and checks that they are of today's case.
"""
FILMED = "quick_jump", {"run.output_interval": 0.04, "analysis.figures": "none"}
"""Scene and changes of the film on the first page."""
CARD = 480, 240
"""Pixels of the pictures on cards."""
COLOURS, WIDTH = 128, 1400
"""Of stored pictures, which git keeps for good."""


def make(docs: Path) -> None:
    """Write the page, its pictures and reports.

    Raises
    ------
    ValueError
        Stored results that are not those of today's cases.
    """
    if old := stale():
        raise ValueError("stored results are of other cases: " + ", ".join(old) + "; make gallery makes them again")
    pictures, reports = docs / "_made" / "gallery", docs / "_made" / "extra" / "reports"
    pictures.mkdir(parents=True, exist_ok=True)
    reports.mkdir(parents=True, exist_ok=True)
    blocks = [HEAD, contents()]
    for name in scene_names():
        case = lj.load_case(INPUTS / f"{name}.yaml")
        said = ""
        if name in STORED:
            shutil.copy(FOLDER / f"{name}.png", pictures)
            fit(FOLDER / f"{name}.png", pictures / f"{name}_small.png")
            shutil.copy(FOLDER / f"{name}.html", reports)
            data = json.loads((FOLDER / f"{name}.json").read_text())
            said = f", stored: {data['seconds']:.0f} s with lammps-jump {data['versions']['lammps_jump']}"
        else:
            folder = run(case, docs / "_made" / "runs" / name).folder
            shutil.copy(folder / "figures" / "snapshots.png", pictures / f"{name}.png")
            shutil.copy(folder / "report.html", reports / f"{name}.html")
            moment(case, folder, pictures / f"{name}_small.png")
        blocks += [
            f"(scene-{name})=",
            f"## {name}\n",
            f"{case.fields.description}\n",
            f"![{name}](_made/gallery/{name}.png)\n",
        ]
        blocks.append(f"```console\n$ lammps-jump build-and-run inputs/{name}.yaml\n```\n")
        blocks.append(f'<a href="reports/{name}.html">Play its report</a>{said}\n')
    (docs / "_made" / "gallery.md").write_text("\n".join(blocks))


def contents() -> str:
    """Cards that lead to all scenes, Markdown."""
    card = ":::{grid-item-card} %s\n:img-top: _made/gallery/%s_small.png\n:link: scene-%s\n:link-type: ref\n:::"
    cards = [card.replace("%s", name) for name in scene_names()]
    return "\n".join(["::::{grid} 2 2 3 3", ":gutter: 2", "", *cards, "::::", ""])


def moment(case: lj.Case, folder: Path, out: Path) -> None:
    """Draw the frame at two thirds of a run."""
    dump = lj.read_dump(folder / "dump.lammpstrj")
    still(dump[2 * len(dump) // 3], flow_of(case), out, width=WIDTH // 2)
    fit(out, out)


def fit(picture: Path, out: Path) -> None:
    """Write a picture as one of a card: all of it, on white."""
    with Image.open(picture) as whole:
        small = ImageOps.pad(whole.convert("RGB"), CARD, color="white")
    small.save(out, optimize=True)


def film(docs: Path) -> None:
    """Write the film of the first page where it is not of the run that is there."""
    name, changes = FILMED
    made = run(lj.load_case(INPUTS / f"{name}.yaml", changes), docs / "_made" / "runs" / "film")
    out, dump = docs / "_made" / "extra" / "film.mp4", made.folder / "dump.lammpstrj"
    if not out.exists() or out.stat().st_mtime < dump.stat().st_mtime:
        out.parent.mkdir(parents=True, exist_ok=True)
        out.unlink(missing_ok=True)
        animate(made.folder, out, fps=20)


def run(case: lj.Case, folder: Path) -> lj.Run:
    """The run of a case; one of another case, or of a build that was ended, is made anew."""
    try:
        return case.run(folder)
    except lj.SetupError:
        return case.run(folder, force=True)


def store(name: str, runs: Path) -> None:
    """Run a scene and keep its picture, its report and the key of its case."""
    case = lj.load_case(INPUTS / f"{name}.yaml")
    made = run(case, runs / name)
    FOLDER.mkdir(exist_ok=True)
    (FOLDER / f"{name}.png").write_bytes(smaller((made.folder / "figures" / "snapshots.png").read_bytes()))
    (FOLDER / f"{name}.html").write_bytes((made.folder / "report.html").read_bytes())
    seconds = round(made.summary["wall_seconds"]["run"], 1)
    data = {"key": case.hash, "seconds": seconds, "versions": versions("lammps")}
    (FOLDER / f"{name}.json").write_text(json.dumps(data, indent=1) + "\n")


def smaller(picture: bytes) -> bytes:
    """A PNG with few colours and at most `WIDTH` pixels a row."""
    with Image.open(io.BytesIO(picture)) as whole:
        small = whole.convert("RGB")
    small.thumbnail((WIDTH, 10 * WIDTH))
    small.quantize(COLOURS).save(made := io.BytesIO(), "PNG", optimize=True)
    return min(made.getvalue(), picture, key=len)


def stale(folder: Path = FOLDER) -> list[str]:
    """Scenes whose stored results are missing or not of today's case."""
    found = []
    for name in STORED:
        path = folder / f"{name}.json"
        key = json.loads(path.read_text())["key"] if path.is_file() else None
        if key != lj.load_case(INPUTS / f"{name}.yaml").hash:
            found.append(name)
    return found


if __name__ == "__main__":
    for one in sys.argv[1:] or STORED:
        store(one, DOCS.parent / "runs" / "gallery")
