# SPDX-License-Identifier: GPL-2.0-or-later
"""Each place that a command reads or writes: every command has its rows, and what is put there is refused in words."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import get_type_hints

import pytest
import typer
from fault_table import (
    BEGIN_PLACES,
    END,
    FAULTS,
    FILE,
    FOLDER,
    LONG,
    NAMED,
    NO_PLACE,
    PAGE,
    PLACES,
    RUN,
    places_table,
)
from made_up import call
from put_in_place import ends_a_hang, look, put

import lammps_jump as lj
from lammps_jump.case import CaseFields
from lammps_jump.cli.app import app

pytestmark = pytest.mark.usefixtures("blank_pictures")

CASE = {
    "name": "places",
    "discs": {"diameter": 0.2},
    "contact": {"restitution": 0.5, "impact_speed": 5},
    "domain": {"x": [-1, 4], "y": [-1, 4]},
    "walls": [{"name": "floor", "kind": "plane", "axis": "y", "at": 0, "side": "above"}],
    "initial": [{"kind": "column", "x": [0, 1], "y": [0, 1], "gate": False}],
    "run": {"duration": 0.06, "output_interval": 0.01},
    "probes": {"forces": ["floor"]},
    "engine": {"name": "native"},
    "analysis": {"energy": True},
}
ENDINGS = {
    ("animate", "out"): (".gif",), ("compare", "second"): (".csv",),
    ("import", "drawing"): (".dxf", ".svg", ".geojson", ".csv"),
}  # fmt: skip
"""How the name of a place must end; each is a reader of its own."""


def commands(group: typer.Typer, before: str = "") -> Iterator[tuple[str, Callable]]:
    """Name and function of every command."""
    for one in group.registered_commands:
        yield before + (one.name or one.callback.__name__.replace("_", "-")), one.callback
    for inner in group.registered_groups:
        yield from commands(inner.typer_instance, before + (f"{inner.name} " if inner.name else ""))


def test_every_place_that_a_command_takes_has_its_row():
    places = {
        (name, parameter)
        for name, function in commands(app)
        for parameter, kind in get_type_hints(function).items()
        if "Path" in str(kind)
    }
    assert places == PLACES.keys(), "put each place into PLACES of tests/fault_table.py, with a call of the command"
    assert {name for name, _ in commands(app)} == {name for name, _ in places} | NO_PLACE
    assert {kind for kind, _ in PLACES.values()} == FAULTS.keys()
    for (name, _), (_, words) in PLACES.items():
        assert words[0] == name and words.count("@") == 1


def test_every_place_that_a_case_names_has_its_row():
    """Fields that hold the name of a file or folder, in all kinds of walls, motions, inflows and so on."""
    schema = CaseFields.model_json_schema()
    fields = [name for group in schema["$defs"].values() for name in group.get("properties", {})]
    named = [name for name in fields if name in ("file", "folder")]
    rows = {"folder": ["`initial.folder`"], "file": ["`walls.file`", "`walls.file`", "`walls.motion.file`"]}
    assert {name: named.count(name) for name in set(named)} == {name: len(kinds) for name, kinds in rows.items()}
    assert set(rows["folder"] + rows["file"]) <= NAMED.keys()


def test_the_page_shows_what_is_tried():
    _, begin, rest = PAGE.read_text(encoding="utf-8").partition(BEGIN_PLACES)
    assert begin and rest.partition(END)[0] == places_table(), "make reference writes it"


@pytest.fixture(scope="module")
def finished(tmp_path_factory) -> Path:
    """A folder with a case, its finished run, and the results of its dump."""
    place = tmp_path_factory.mktemp("places")
    (place / "case.yaml").write_text(lj.load_case(CASE).to_yaml())
    lj.load_case(place / "case.yaml").run(place / "run")
    (place / "laws" / "x").mkdir(parents=True)
    (place / "laws" / "x" / "law.py").write_text("LAW = 1\n")
    (place / "bed.csv").write_text("chainage (m),level (m)\n0,0\n4,0\n")
    return place


READERS = [(key, ending) for key in (*PLACES, *NAMED) for ending in ENDINGS.get(key, ("",))]
ROWS = {**{key: (kind, words, {}) for key, (kind, words) in PLACES.items()},
        **{key: (kind, words, named) for key, (kind, named, words) in NAMED.items()}}  # fmt: skip
"""Of each row the kind of place, the call, and what names the place."""
ALL = [(key, fault, ending) for key, ending in READERS for fault in FAULTS[ROWS[key][0]]]
SHORT = [
    (key, (faults := FAULTS[ROWS[key][0]])[number % len(faults)], ending)
    for number, (key, ending) in enumerate(READERS)
]


def naming(named: object, place: str, case: Path) -> object:
    """What names a place, with the place in it."""
    if isinstance(named, dict):
        return {key: naming(value, place, case) for key, value in named.items()}
    if isinstance(named, list):
        return [naming(value, place, case) for value in named]
    return {"@": place, "CASE": str(case)}.get(named, named) if isinstance(named, str) else named


@pytest.mark.fault("places that commands read and write")
@pytest.mark.parametrize(
    ("key", "fault", "ending"), ALL if LONG else SHORT, ids=lambda one: one if isinstance(one, str) else " ".join(one)
)
def test_what_stands_in_a_place_is_refused_and_left(finished, tmp_path, monkeypatch, capsys, key, fault, ending):
    kind, words, named = ROWS[key]
    place = tmp_path / "at" / f"place{ending}"
    if fault == "below a file":
        place = place.parent / "file" / "place"
        place.parent.parent.mkdir()
    else:
        place.parent.mkdir()
    put(fault, place)
    names = {"@": place, "CASE": finished / "case.yaml", "RUN": tmp_path / "run", "DUMPED": tmp_path / "run",
             "DUMP": tmp_path / "run" / "dump.lammpstrj", "OUT": tmp_path / "out", "OUT.html": tmp_path / "out.html",
             "LAWS": finished / "laws", "DRAWING": finished / "bed.csv",
             "NAMER": place.parent / "namer.yaml"}  # fmt: skip
    if named:
        whole = naming(named, place.name, finished / "case.yaml")
        names["NAMER"].write_text(json.dumps(whole if "case" in whole else CASE | whole))
    shutil.copytree(finished / "run", tmp_path / "run")
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    before = look(place)
    with ends_a_hang():
        status, _, err = call(monkeypatch, capsys, *(names.get(word, word) for word in words))
    assert status in (1, 2) and 0 < len(err.strip()) < 3_000, err
    assert look(place) == before
    assert kind in (FOLDER, FILE) or not (tmp_path / "out").exists(), sorted((tmp_path / "out").rglob("*"))
    assert kind != RUN or fault == "absent" or os.path.lexists(place)
