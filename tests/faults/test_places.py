# SPDX-License-Identifier: GPL-2.0-or-later
"""Each place that a command reads or writes: every command has its rows, and what is put there is refused in words."""

from __future__ import annotations

import os
import shutil
import signal
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import get_type_hints

import pytest
import typer
from fault_table import BEGIN_PLACES, END, FAULTS, FILE, FOLDER, LONG, NO_PLACE, PAGE, PLACES, RUN, places_table
from made_up import call

import lammps_jump as lj
from lammps_jump.cli.app import app

pytestmark = pytest.mark.usefixtures("blank_pictures")

LIMIT = 300
"""Seconds after which a command hangs; nothing else depends on them."""
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
MINE = b"precious"
ENDINGS = {("animate", "out"): ".gif", ("compare", "second"): ".csv", ("import", "drawing"): ".dxf"}
"""How the name of a place must end."""


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


def test_the_page_shows_what_is_tried():
    _, begin, rest = PAGE.read_text(encoding="utf-8").partition(BEGIN_PLACES)
    assert begin and rest.partition(END)[0] == places_table(), "make faults writes it"


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


def put(fault: str, place: Path) -> None:
    """Put something into a place; it needs to be gone."""
    if fault == "folder" or "folder of" in fault or fault == "empty folder":
        place.mkdir()
        for name in ("case.yaml", "summary.json", "dump.lammpstrj", "curves.json", "profiles.nc", "report.html"):
            if fault == "folder of pipes":
                os.mkfifo(place / name)
            elif fault == "folder of links":
                (place / name).symlink_to("/dev/zero")
    elif fault == "pipe":
        os.mkfifo(place)
    elif fault in ("endless", "dangling"):
        place.symlink_to("/dev/zero" if fault == "endless" else "nowhere/at/all")
    elif fault == "huge":
        place.touch()
        os.truncate(place, 3_000_000_000)
    elif fault != "absent":
        texts = {"empty": b"", "garbage": b"\x00\x01: [}", "brackets": 100_000 * b"[", "Latin-1": b"name: caf\xe9,1\n"}
        (place.parent if fault == "below a file" else place).write_bytes(texts.get(fault, MINE))


def look(place: Path) -> tuple:
    """What stands at a place."""
    if place.is_symlink():
        return "link", os.readlink(place)
    if place.is_file():
        with place.open("rb") as file:
            return "file", place.stat().st_size, file.read(100)
    return "folder" if place.is_dir() else "other", sorted(place.rglob("*")) if place.is_dir() else ()


def hangs(*_) -> None:
    """End a command that waits for ever."""
    raise AssertionError("the command hangs")


ALL = [(key, fault) for key, (kind, _) in PLACES.items() for fault in FAULTS[kind]]
SHORT = [(key, FAULTS[kind][number % len(FAULTS[kind])]) for number, (key, (kind, _)) in enumerate(PLACES.items())]


@pytest.mark.fault("places that commands read and write")
@pytest.mark.parametrize(
    ("key", "fault"), ALL if LONG else SHORT, ids=lambda one: one if isinstance(one, str) else " ".join(one)
)
def test_what_stands_in_a_place_is_refused_and_left(finished, tmp_path, monkeypatch, capsys, key, fault):
    kind, words = PLACES[key]
    place = tmp_path / "at" / f"place{ENDINGS.get(key, '')}"
    if fault == "below a file":
        place = place.parent / "file" / "place"
        place.parent.parent.mkdir()
    else:
        place.parent.mkdir()
    put(fault, place)
    names = {"@": place, "CASE": finished / "case.yaml", "RUN": tmp_path / "run", "DUMPED": tmp_path / "run",
             "DUMP": tmp_path / "run" / "dump.lammpstrj", "OUT": tmp_path / "out", "OUT.html": tmp_path / "out.html",
             "LAWS": finished / "laws", "DRAWING": finished / "bed.csv"}  # fmt: skip
    shutil.copytree(finished / "run", tmp_path / "run")
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    before, handler = look(place), signal.signal(signal.SIGALRM, hangs)
    signal.alarm(LIMIT)
    try:
        status, _, err = call(monkeypatch, capsys, *(names.get(word, word) for word in words))
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, handler)
    assert status in (1, 2) and 0 < len(err.strip()) < 3_000, err
    assert look(place) == before
    assert kind in (FOLDER, FILE) or not (tmp_path / "out").exists(), sorted((tmp_path / "out").rglob("*"))
    assert kind != RUN or fault == "absent" or os.path.lexists(place)
