# SPDX-License-Identifier: GPL-2.0-or-later
"""The gallery: scenes of ``inputs/`` with moments of its run, its command, and its report to play.

The build of the site simulates nothing. ``docs/stored`` has pictures of all scenes, the film of the first page and some
reports, with the keys of their cases; outputs of the notebook are kept in it. ``make gallery`` makes them again,
``make gallery X=NAME`` one of them, ``X=film``, ``X=notebook`` and ``X=live``, pages in which scenes run. A build stops
where a key is not that of today.
"""

from __future__ import annotations

import hashlib
import io
import json
import shutil
import subprocess
import sys
from pathlib import Path

from PIL import Image, ImageOps

import lammps_jump as lj
from lammps_jump.analysis.draw.film import still
from lammps_jump.analysis.verdicts import verdict
from lammps_jump.case.case import scene_names
from lammps_jump.live import prepare, write_page
from lammps_jump.provenance import versions
from lammps_jump.runs.results import animate, flow_of

DOCS = Path(__file__).parents[1]
FOLDER = DOCS / "stored"
INPUTS = DOCS.parent / "inputs"
RUNS = DOCS.parent / "runs" / "gallery"
PLAYED = ("quick_jump", "spillway")
"""Scenes whose report git keeps; those of others are where ``make gallery`` has been run."""
NOTEBOOK = DOCS / "notebooks" / "first_jump.ipynb"
HEAD = """\
# Gallery

The scenes of `inputs/`, but for those that begin from the run of another. `lammps-jump new SCENE` prints its case.
Pictures are moments of a run. The line below each is its verdict, and its report plays it. The build of this site shows
stored results, and checks that they are of today's case.
"""
LIVE = "_live.html"
"""Ends the names of live pages, which git does not keep: ``make gallery X=live`` makes them."""
NO_LIVE = "Scenes do not play live in this build: `make wasm` and `make gallery X=live` make their pages.\n"
FIRST = "quick_jump"
FIRST_PAGE = (
    f'<a href="reports/{FIRST}{LIVE}">Raise its sill yourself</a>: the flow runs in your browser, and what you did '
    "becomes a case.\n"
)
NO_FIRST_PAGE = "[A live page](howto/live.md) of it lets a reader raise the sill while the flow runs.\n"
GROUPS = {
    "Water": {
        "stable_jump": "A hydraulic jump that stands",
        "quick_jump": "A hydraulic jump in seconds",
        "tailgate": "A tailgate that finds its height",
        "hydraulic_jump": "The jump of the thesis, with friction",
        "hydraulic_jump_frictionless": "The jump of the thesis, without friction",
        "hydraulic_jump_graded": "A jump of discs of many sizes",
        "dam_break": "A dam break",
        "dam_break_triangle": "A dam break over a triangular sill",
        "spillway": "A spillway and its stilling basin",
        "sluice_gate": "A gate that rises",
        "wave_paddle": "Waves from a paddle",
    },
    "Grains": {
        "heap": "A heap below a hopper",
        "hopper": "A hopper that empties",
        "column_collapse": "A column of grains that collapses",
        "sieved_column": "A column of sieved gravel",
        "settled_bed": "A bed that has settled",
        "inclined_flow": "A layer that flows down a rough bed",
        "drum": "A turning drum",
        "shock": "A stream that falls on a wedge",
        "rockfall": "Boulders against a wall of blocks",
    },
    "Structures": {
        "wave_structure": "A wave against a structure",
        "caisson": "A wave against a caisson",
        "crown_wall": "A wave against the wall on a breakwater",
        "weir_rating": "A weir with a free fall",
        "flap_gate": "A flap on a hinge",
        "floating_box": "A box that floats",
    },
    "Checks": {
        "energy_box_7": "A closed box of 7 discs",
        "energy_box_16": "A closed box of 16 discs",
    },
}
"""Titles of the scenes, by what a reader looks for."""
FILMED = "quick_jump", {"run.output_interval": 0.04, "analysis.figures": "none"}
"""Scene and changes of the film on the first page."""
CARD = 480, 240
"""Pixels of the pictures on cards."""
COLOURS, WIDTH = 128, 1000
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
    extra = docs / "_made" / "extra"
    reports, pictures = extra / "reports", docs / "_made" / "gallery"
    for folder in (reports, pictures):
        folder.mkdir(parents=True, exist_ok=True)
    shutil.copy(FOLDER / "film.mp4", extra)
    live = live_scenes()
    for name in live:
        shutil.copy(FOLDER / f"{name}{LIVE}", reports)
    (docs / "_made" / "live.md").write_text(FIRST_PAGE if FIRST in live else NO_FIRST_PAGE)
    blocks = [HEAD, "" if live else NO_LIVE, contents()]
    for group, titles in GROUPS.items():
        blocks.append(f"## {group}\n")
        for name, title in titles.items():
            for picture in (f"{name}.png", f"{name}_small.png"):
                shutil.copy(FOLDER / picture, pictures)
            blocks += scene_of(name, title, reports, live=name in live)
    (docs / "_made" / "gallery.md").write_text("\n".join(blocks))


def scene_of(name: str, title: str, reports: Path, *, live: bool) -> list[str]:
    """Blocks of one scene, Markdown: picture, verdict, command, report; its report is put into a folder."""
    case, data = lj.load_case(INPUTS / f"{name}.yaml"), json.loads((FOLDER / f"{name}.json").read_text())
    said = f"made with lammps-jump {data['versions']['lammps_jump']}"
    blocks = [
        f"(scene-{name})=",
        f"### {title}\n",
        f"{case.fields.description}\n",
        f"![{title}](_made/gallery/{name}.png)\n",
        f"*{data['verdict']}*\n" if data["verdict"] else "",
        f"```console\n$ lammps-jump build-and-run inputs/{name}.yaml\n```\n",
    ]
    if (report := FOLDER / f"{name}.html").is_file():
        shutil.copy(report, reports)
        blocks.append(f'<a href="reports/{name}.html">Play its report</a>, {said}\n')
    else:
        blocks.append(f"Pictures {said}; `make gallery X={name}` and `make docs` put its report here.\n")
    if live:
        blocks.append(f'<a href="reports/{name}{LIVE}">Play it live</a>, with sliders: it runs in your browser.\n')
    return blocks


def contents() -> str:
    """Cards that lead to all scenes, in their groups, Markdown."""
    card = ":::{grid-item-card} %t\n:img-top: _made/gallery/%s_small.png\n:link: scene-%s\n:link-type: ref\n:::"
    blocks = []
    for group, titles in GROUPS.items():
        cards = [card.replace("%t", title).replace("%s", name) for name, title in titles.items()]
        blocks += [f"**{group}**\n", "::::{grid} 2 2 3 3", ":gutter: 2", "", *cards, "::::", ""]
    return "\n".join(blocks)


def keep_film(made: lj.Run) -> None:
    """Keep the film of a run, an eighth as large as `animate` writes it."""
    from imageio_ffmpeg import get_ffmpeg_exe  # of the extra `test`, which the site does not need

    whole = RUNS / "film.mp4"
    whole.unlink(missing_ok=True)
    animate(made.folder, whole, fps=20)
    small = "-vf scale=800:-2 -preset fast -crf 30 -movflags +faststart".split()
    subprocess.run([get_ffmpeg_exe(), "-y", "-loglevel", "error", "-i", whole, *small, FOLDER / "film.mp4"], check=True)


def fit(picture: Path, out: Path) -> None:
    """Write a picture as one of a card: all of it, on white."""
    with Image.open(picture) as whole:
        small = ImageOps.pad(whole.convert("RGB"), CARD, color="white")
    small.save(out, optimize=True)


def run(case: lj.Case, folder: Path) -> lj.Run:
    """The run of a case; one of another case, or of a build that was ended, is made anew."""
    try:
        return case.run(folder)
    except lj.SetupError:
        return case.run(folder, force=True)


def scenes() -> list[str]:
    """Names of the scenes that can be run by themselves."""
    return [name for name in scene_names() if "kind: run" not in (INPUTS / f"{name}.yaml").read_text(encoding="utf-8")]


def stored() -> list[str]:
    """Names of all that is stored."""
    return [*scenes(), "film", "notebook"]


def store(name: str) -> None:
    """Make what is shown again, and keep it with its key."""
    print(f"{name} …", flush=True)
    FOLDER.mkdir(exist_ok=True)
    data: dict[str, object] = {"key": key_of(name)}
    if name == "notebook":
        execute(NOTEBOOK)
    else:
        made = run(shown(name), RUNS / name)
        data["versions"] = versions("lammps")
        if name == "film":
            keep_film(made)
        else:
            data["verdict"] = verdict(made.summary)
            keep_scene(name, made)
    (FOLDER / f"{name}.json").write_text(json.dumps(data, indent=1) + "\n")


def live_scenes() -> list[str]:
    """Names of the scenes whose live page is there."""
    return [name for name in scenes() if (FOLDER / f"{name}{LIVE}").is_file()]


def keep_live() -> None:
    """Make the live pages of all scenes that can have one."""
    for name in scenes():
        try:
            write_page(prepare(lj.load_case(INPUTS / f"{name}.yaml")), FOLDER / f"{name}{LIVE}")
        except lj.CaseError as error:
            print(f"{name}: no live page, {error}", flush=True)


def keep_scene(name: str, made: lj.Run) -> None:
    """Keep moments of a run, the picture of its card, and its report."""
    (FOLDER / f"{name}.png").write_bytes(smaller((made.folder / "figures" / "snapshots.png").read_bytes()))
    (FOLDER / f"{name}.html").write_bytes((made.folder / "report.html").read_bytes())
    dump, card = lj.read_dump(made.folder / "dump.lammpstrj"), FOLDER / f"{name}_small.png"
    still(dump[2 * len(dump) // 3], flow_of(shown(name)), card, width=WIDTH // 2)
    fit(card, card)


def smaller(picture: bytes) -> bytes:
    """A PNG with few colours and at most `WIDTH` pixels a row."""
    with Image.open(io.BytesIO(picture)) as whole:
        small = whole.convert("RGB")
    small.thumbnail((WIDTH, 10 * WIDTH))
    small.quantize(COLOURS).save(made := io.BytesIO(), "PNG", optimize=True)
    return min(made.getvalue(), picture, key=len)


def execute(path: Path) -> None:
    """Run the notebook and keep its outputs in it, but for the lines of progress."""
    import nbformat  # of the extra `docs`, which the tests do not need
    from nbclient import NotebookClient

    notebook, place = nbformat.read(path, 4), RUNS / "notebook"
    place.mkdir(parents=True, exist_ok=True)
    if not (place / "inputs").exists():
        (place / "inputs").symlink_to(INPUTS, target_is_directory=True)
    quiet = ["--IPKernelApp.log_level=40"]  # no advice of the kernel on its sockets
    NotebookClient(notebook, timeout=600, extra_arguments=quiet, resources={"metadata": {"path": str(place)}}).execute()
    for cell in notebook.cells:
        cell.metadata.clear()  # times of the run
        if "outputs" in cell:
            cell.outputs = [one for one in cell.outputs if one.get("name") != "stderr"]
    nbformat.write(notebook, path)


def shown(name: str) -> lj.Case:
    """The case of a scene or of the film, as it is today."""
    scene, changes = FILMED if name == "film" else (name, {})
    return lj.load_case(INPUTS / f"{scene}.yaml", changes)


def key_of(name: str) -> str:
    """Hash of what is shown, as it is today."""
    if name != "notebook":
        return shown(name).hash
    cells = json.loads(NOTEBOOK.read_text(encoding="utf-8"))["cells"]
    text = json.dumps([shown("quick_jump").hash, *("".join(cell["source"]) for cell in cells)])
    return hashlib.sha256(text.encode()).hexdigest()[:12]


def stale(folder: Path = FOLDER) -> list[str]:
    """Names whose stored results are missing or not of today's case."""
    found = []
    for name in stored():
        path = folder / f"{name}.json"
        if not path.is_file() or json.loads(path.read_text())["key"] != key_of(name):
            found.append(name)
    return found


if __name__ == "__main__":
    for one in sys.argv[1:] or [*stored(), "live"]:
        if one == "live":
            keep_live()
        else:
            store(one)
