# SPDX-License-Identifier: GPL-2.0-or-later
"""Files of every kind that is handed on, changed at random: read, or refused in a sentence; nothing is written."""

from __future__ import annotations

import json
import random
import warnings
from collections.abc import Callable
from pathlib import Path

import ezdxf
import numpy as np
import pytest
import xarray as xr
from fault_table import many
from made_up import BOX, INPUTS, files
from mutants import LONGEST, mutant, tree_mutant
from stand_in_runs import CASE, DENSITY, FRICTION, VARY

import lammps_jump as lj
from lammps_jump import sweeps
from lammps_jump.calibration.calibrate import Calibrated
from lammps_jump.calibration.search import Search
from lammps_jump.calibration.study import parse_vary, read_calibration
from lammps_jump.calibration.targets import measured_of, parse_target
from lammps_jump.drawings import doubts, entries, read_drawing, yaml_text
from lammps_jump.dump.exports import write_netcdf
from lammps_jump.dump.find import forces_of, table_of
from lammps_jump.dump.read import open_dump
from lammps_jump.dump.walls import PoseFile
from lammps_jump.errors import CaseError, JumpError
from lammps_jump.files import POSES_HEADER, plain, write_json
from lammps_jump.folders import holder
from lammps_jump.script.job import read_site
from lammps_jump.sweeps import study_folder

# --- what is read -----------------------------------------------------------------------------------------------------

SVG = """<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" width="200mm" height="100mm"
 viewBox="0 0 200 100" preserveAspectRatio="xMidYMid meet"><style>.h {display: none} #g1 {fill: none}</style>
<g id="g1" transform="translate(10,0) rotate(5)"><path d="M 0 90 L 50 90 A 20 20 0 0 1 90 90 L 200 95 Z"/></g>
<circle cx="100" cy="50" r="5"/>
<rect x="10" y="10" width="20" height="10" rx="2"/><ellipse cx="9" cy="9" rx="3" ry="2"/>
<path id="wave" d="M0 20 C 20 0 40 40 60 20 Q 70 0 80 20 h 5 v 3"/><polyline points="1,2 3,4 5,6"/>
<symbol id="s" viewBox="0 0 1 1"><line x1="0" y1="0" x2="1" y2="1"/></symbol>
<use xlink:href="#s" x="5" y="5" width="9" height="9"/><path class="h" d="M0 0L1 1"/><text x="1" y="2">a</text></svg>"""
FEATURES = {
    "type": "FeatureCollection",
    "features": [
        {"type": "Feature", "properties": {"name": "bed"},
         "geometry": {"type": "LineString", "coordinates": [[0, 1], [4, 1.5]]}},
        {"type": "Feature", "id": 7, "properties": None,
         "geometry": {"type": "Polygon", "coordinates": [[[0, 5], [1, 5], [1, 6], [0, 5]]]}},
    ],
}  # fmt: skip


def drawn(path: Path) -> None:
    """A bit of everything that DXF has."""
    document = ezdxf.new("R2010")
    document.header["$INSUNITS"] = 6
    document.layers.add("off").off()
    space, block = document.modelspace(), document.blocks.new("pile")
    block.add_lwpolyline([(0, 0), (0.5, 0), (0.5, 2)], close=True)
    space.add_line((0, 0), (10, 0), dxfattribs={"layer": "bed"})
    space.add_lwpolyline([(10, 0, 0.4), (20, -1, 0)], format="xyb", dxfattribs={"layer": "bed"})
    space.add_circle((12, 3), 0.5)
    space.add_arc((0, 9), 2, 10, 80)
    space.add_ellipse((5, 9), (2, 0), 0.5)
    space.add_spline([(0, 5), (1, 6), (3, 5)], dxfattribs={"layer": "top"})
    space.add_polyline2d([(0, 7), (1, 7), (1, 8)])
    space.add_blockref("pile", (2, 2)).grid((2, 3), (4, 1))
    space.add_text("words")
    document.saveas(path)


def read_walls(path: Path) -> None:
    """All that `import` does with a drawing."""
    drawing = read_drawing(path, scale=None if path.suffix in (".dxf", ".svg", ".csv") else "m")
    found = entries(drawing)
    assert yaml_text(found)
    doubts(found, max(drawing.extent()))


def read_study(path: Path) -> None:
    """All that a study tells of its folder."""
    found = sweeps.open_sweep(path.parent)
    assert found.status() and study_folder.read_points(path.parent)
    _ = found.members, found.states, found.left(retry=True), found.study.to_yaml()


def read_answer(path: Path) -> None:
    """All that Python is told of a calibration."""
    found = Calibrated(path.parent)
    _ = found.verdict, found.notes, found.table, found.correlation, found.samples, found.best, found.runs, repr(found)


def read_rounds(path: Path) -> None:
    """What a calibration that goes on takes of its folder."""
    study = read_calibration(path.parent)
    search = Search(study, path.parent, False, lambda progress: None)
    assert search.points.shape == (len(search.points), len(study.vary))


def held_calibration(folder: Path) -> None:
    """The folder of a calibration with its first round and an answer."""
    study = read_calibration(CASE, targets=["heap.angle=20 ± 0.3", "heap.run_out=3 ± 0.05"], vary=VARY)
    Search(study, folder, False, lambda progress: None).begin()
    one = {"best": 0.5, "low": 0.4, "high": 0.6, "identified": True, "at_edge": False, "prior": [0.1, 0.9]}
    values = {path: low for path, (low, _) in VARY.items()}
    found = {
        "verdict": "The measurements give 0.5.", "notes": ["One run failed."], "parameters": dict.fromkeys(VARY, one),
        "correlation": {FRICTION: {DENSITY: -0.5}, DENSITY: {FRICTION: -0.5}}, "nearest": 0,
        "points": [{"values": values, "round": 0, "runs": ["points/runs/0a1b"], "distance": 0.5}],
    }  # fmt: skip
    write_json(folder / "calibration.json", found)
    dataset = xr.Dataset({path: ("sample", np.linspace(low, high, 9)) for path, (low, high) in VARY.items()})
    write_netcdf(dataset, folder / "samples.nc")
    (folder / "best.yaml").write_text(study.case.to_yaml())


@pytest.fixture(scope="module")
def samples(tmp_path_factory) -> dict[str, tuple[Path, Callable[[Path], object]]]:
    """A file of each kind, and what reads it."""
    place = tmp_path_factory.mktemp("samples")
    for name in ("walls", "study", "calibration", "texts"):
        (place / name).mkdir()
    drawn(place / "walls" / "a.dxf")
    (place / "walls" / "a.svg").write_text(SVG)
    (place / "walls" / "a.geojson").write_text(json.dumps(FEATURES))
    (place / "walls" / "a.csv").write_text(
        "point,chainage (m),level (m)\n" + "".join(f"p,{x},{x * x}\n" for x in range(9))
    )
    data = {"case": BOX, "axes": {"contact.restitution": [0.3, 0.5]}, "members": 2}
    study = sweeps.study.read_study(data)
    (place / "study" / "study.yaml").write_text(study.to_yaml())
    points = {
        "points": study.points,
        "members": [{"point": k // 2, "seed": 1 + k % 2, "key": f"{k}a"} for k in range(4)],
    }
    (place / "study" / "points.json").write_text(json.dumps(plain(points)))
    held_calibration(place / "calibration")
    (place / "texts" / "measured.csv").write_text("t,h\n0,1\n1,1.5\n2,1.7\n")
    (place / "texts" / "site.yaml").write_text(
        "partition: short\naccount: water\ntime: '02:00:00'\noptions: [--qos=a]\n"
    )
    (place / "texts" / "case.yaml").write_text((INPUTS / "dam_break.yaml").read_text())
    walls, texts, answer = place / "walls", place / "texts", place / "calibration"
    readers = {
        **{f"{path.name} drawing": (path, read_walls) for path in walls.iterdir()},
        "calibration.json": (answer / "calibration.json", read_answer),
        "samples.nc": (answer / "samples.nc", read_answer),
        "best.yaml": (answer / "best.yaml", read_answer),
        "rounds.json": (answer / "rounds.json", read_rounds),
        "study.yaml of a calibration": (answer / "study.yaml", read_rounds),
        "study.yaml of a sweep": (place / "study" / "study.yaml", read_study),
        "points.json": (place / "study" / "points.json", read_study),
        "measured points": (texts / "measured.csv", lambda path: measured_of(path, {"a": "t", "b": "h"})),
        "site": (texts / "site.yaml", read_site),
        "case": (texts / "case.yaml", lj.load_case),
    }
    return readers


DRAWINGS = [f"{name} drawing" for name in ("a.dxf", "a.svg", "a.geojson", "a.csv")]
ANSWERS = ["calibration.json", "samples.nc", "best.yaml", "rounds.json", "study.yaml of a calibration"]
STUDIES = [*ANSWERS, "study.yaml of a sweep", "points.json", "measured points", "site"]
KINDS = [
    *(pytest.param(name, marks=pytest.mark.fault("mutants of drawings")) for name in DRAWINGS),
    *(pytest.param(name, marks=pytest.mark.fault("mutants of studies and rounds")) for name in STUDIES),
]


@pytest.mark.parametrize("kind", KINDS)
def test_a_mutant_is_read_or_refused(samples, kind, tried):
    path, read = samples[kind]
    whole, times, refused = path.read_bytes(), many(8, 400), 0
    read(path)  # as it is
    before = files(path.parent)
    try:
        for seed in range(times):
            print(f"seed {seed}")
            change = tree_mutant if path.suffix in (".json", ".geojson") and seed % 2 else mutant
            path.write_bytes(data := change(whole, random.Random(f"{kind} {seed}")))
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                try:
                    read(path)
                except JumpError as error:
                    assert "\n" not in str(error) and 0 < len(str(error)) < LONGEST
                    refused += 1
            assert files(path.parent) == {**before, str(path): data}
    finally:
        path.write_bytes(whole)
    assert refused
    tried(times)


DUMP = """ITEM: TIMESTEP
{step}
ITEM: TIME
{time}
ITEM: NUMBER OF ATOMS
{count}
ITEM: BOX BOUNDS ff ff pp
{side} 9
0 9
0 1
ITEM: ATOMS id x y vx vy
1 1 1 0 0
2 {x} 1 0 0
"""
SOUND = {"step": "0", "time": "0.5", "count": "2", "side": "0", "x": "3"}


def read_one_frame(folder: Path, text: str) -> None:
    (folder / "dump").write_text(text)
    list(open_dump(folder / "dump"))


TEXTS: dict[str, Callable[[Path, str], object]] = {
    **{
        f"{name} of a dump": lambda folder, text, name=name: read_one_frame(folder, DUMP.format(**SOUND | {name: text}))
        for name in SOUND
    },
    "forces": lambda folder, text: forces_of(f"time,structure,fx,fy,moment\n0.1,sill,{text},0,0\n", "forces.csv"),
    "a table of a run": lambda folder, text: table_of(f"a,b\n1,{text}\n".encode(), "a.csv").numbers("b"),
    "measured points": lambda folder, text: measured_of(put(folder, f"t,h\n1,{text}\n2,3\n"), {"a": "t", "b": "h"}),
    "a range": lambda folder, text: parse_vary(f"contact.friction=0.1:{text}"),
    "a target": lambda folder, text: parse_target(f"jump.y2={text} ± 0.1"),
    "a wall's place": lambda folder, text: pose_of(folder, text),
}
"""Where a number stands in a text, and what reads it."""


def put(folder: Path, text: str) -> Path:
    (folder / "a.csv").write_text(text)
    return folder / "a.csv"


def pose_of(folder: Path, text: str) -> None:
    PoseFile(put(folder, f"{POSES_HEADER}\n0.1,lid,{text},0,0\n"), ["lid"]).at(0.1)


@pytest.mark.parametrize("where", TEXTS)
@pytest.mark.fault("wrong tables")
def test_texts_that_python_reads_as_numbers_are_none(where, tmp_path):
    read = TEXTS[where]
    read(tmp_path, "2")
    for text in ("4_0", "\uff14", "1_000", "0x10", "1,5", "12abc", "--2"):
        with pytest.raises(JumpError) as caught:
            read(tmp_path, text)
        assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "text", ['{"pid": 1e999}', '{"pid": [1]}', "[1]", "null", 5000 * "[", "\x00", '{"pid": "1_0"}']
)
@pytest.mark.fault("folders")
def test_a_lock_that_no_run_wrote_is_none(tmp_path, text):
    (tmp_path / ".lock").write_text(text)
    assert holder(tmp_path) == ""


@pytest.mark.parametrize(
    "tag", ["!!timestamp 2001-99-99", "!!float x", "!!bool 7", "!!int a_", "!!binary ?", "!!set {a}"]
)
@pytest.mark.fault("mutants of cases")
def test_a_tag_of_yaml_is_one_sentence(tag):
    with pytest.raises(CaseError) as caught:
        lj.Case.parse(f"name: {tag}\n")
    assert "\n" not in str(caught.value)
