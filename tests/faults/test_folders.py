# SPDX-License-Identifier: GPL-2.0-or-later
"""Mutants of every JSON and CSV of a run folder, through every command that reads one: a sentence, no traceback."""

from __future__ import annotations

import csv
import io
import json
import os
import random
import shutil
import signal
import traceback
from collections.abc import Callable
from pathlib import Path

import pytest
from fault_table import LONG, many
from made_up import call

import lammps_jump as lj
from lammps_jump.files import checksum

pytestmark = [pytest.mark.usefixtures("blank_pictures"), pytest.mark.fault("mutants of run folders")]

PART, PARTS = many(18, 200), many(1, 10)
"""Mutants of a part, and parts: the long form of 2,000 is spread over workers."""
SEED = 20_000
LIMIT = 300
"""Seconds after which a command hangs; nothing else depends on them."""
CASE = {
    "name": "folder",
    "discs": {"diameter": 0.2},
    "contact": {"restitution": 0.5, "impact_speed": 5, "friction": 0.3, "friction_law": "history"},
    "domain": {"x": [-1, 4], "y": [-1, 4]},
    "walls": [
        {"name": "floor", "kind": "plane", "axis": "y", "at": 0, "side": "above"},
        {"name": "lid", "kind": "block", "x": [2, 2.6], "y": [0.4, 0.6],
         "motion": {"kind": "load", "mass": 50, "force": [0, 0]}},
    ],
    "initial": [{"kind": "column", "x": [0, 1], "y": [0, 1], "gate": False}],
    "run": {"duration": 0.06, "output_interval": 0.01},
    "probes": {"forces": ["floor"], "gauges": [0.5]},
    "engine": {"name": "native"},
    "analysis": {"jump": True, "front": True, "energy": True},
}  # fmt: skip
ODD = (
    None, True, -1, 0, 1e308, -1e308, 10**400, "", "x", "../x", "a\nb", "\x00", 70_000 * "9", [], {}, [None], {"a": 1},
    [[]], "nan", -0.5,
)  # fmt: skip
COMMANDS = {
    "analyze": ("analyze", "RUN"),
    "animate": ("animate", "RUN", "--out", "OUT/film.gif"),
    "compare": ("compare", "RUN", "OTHER", "--out", "OUT/c.html"),
    "compare the other way": ("compare", "OTHER", "RUN", "--out", "OUT/c.html"),
    "compare with data": ("compare", "RUN", "DATA", "--columns", "time=t,force_floor.fy=h", "--out", "OUT/c"),
    "compare energy": ("compare", "RUN", "DATA", "--columns", "time=t,energy.total=h", "--out", "OUT/c"),
    "compare profiles": ("compare", "RUN", "DATA", "--columns", "x=t,profiles.mass_depth_mean=h", "--out", "OUT/c"),
    "compare a study": ("compare", "STUDY", "DATA", "--columns", "time=t,gauges.depth_0.5=h", "--out", "OUT/c"),
    "export": ("export", "RUN", "--csv", "--vtk", "--pictures", "--out", "OUT/e"),
    "figures": ("figures", "RUN"),
    "run": ("run", "RUN"),
    "run --resume": ("run", "RUN", "--resume"),
    "build-and-run": ("build-and-run", "CASE", "--out", "RUN"),
    "show": ("show", "RUN"),
}
"""How each command that reads a run folder is called."""


@pytest.fixture(scope="module")
def finished(tmp_path_factory) -> Path:
    """A folder with a finished run that has all the files that a run may have."""
    place = tmp_path_factory.mktemp("finished")
    case = lj.load_case(CASE)
    (place / "case.yaml").write_text(case.to_yaml())
    lj.load_case(place / "case.yaml").run(place / "run")
    (place / "data.csv").write_text("t,h\n0.01,1\n0.03,2\n0.05,3\n")
    (place / "victim.txt").write_text("precious")
    return place


def files_of(run: Path) -> list[str]:
    """Names of what is changed: every JSON and CSV, and what is read with them."""
    return sorted(
        path.name
        for path in run.iterdir()
        if path.suffix in (".json", ".csv", ".nc", ".bin") or path.name == ".lammps-jump"
    )


def places(data: object, path: tuple = ()) -> list[tuple]:
    """Every place in plain data."""
    items = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    return [path, *(place for key, item in items for place in places(item, (*path, key)))]


def of_json(data: bytes, chance: random.Random) -> bytes:
    """Another value, key or item at a place of a JSON file."""
    whole = json.loads(data)
    for _ in range(chance.choice((1, 1, 1, 3))):
        path = chance.choice(places(whole))
        if not path:
            continue
        place = whole
        for key in path[:-1]:
            place = place[key]
        kind = chance.randrange(4)
        if kind == 0 and isinstance(place, dict):
            del place[path[-1]]
        elif kind == 1 and isinstance(place, dict):
            place[chance.choice(("x", "../x", "", "status"))] = place.pop(path[-1])
        else:
            place[path[-1]] = chance.choice(ODD)
    return json.dumps(whole).encode()


def of_csv(data: bytes, chance: random.Random) -> bytes:
    """Another cell, row or head of a table."""
    rows = list(csv.reader(io.StringIO(data.decode())))
    for _ in range(chance.choice((1, 1, 3))):
        k = chance.randrange(len(rows))
        kind = chance.randrange(7)
        if kind == 0:
            del rows[k]
        elif kind == 1:
            rows.insert(k, rows[k])
        elif kind == 2:
            rows[k] = [*rows[k], "7"]
        elif kind == 3:
            rows[k] = rows[k][:-1]
        elif kind == 4:
            other = chance.randrange(len(rows))
            rows[k], rows[other] = rows[other], rows[k]
        elif rows[k]:
            rows[k] = list(rows[k])
            odd = chance.choice(
                ("", "x", "nan", "inf", "-inf", "1e308", "-1", "2020-01-01", '"', "9" * 140_000, "é\x85", "0")
            )
            rows[k][chance.randrange(len(rows[k]))] = odd
        if not rows:
            return b""
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerows(rows)
    return out.getvalue().encode()


def of_bytes(data: bytes, chance: random.Random) -> bytes:
    """Bytes that were cut off, changed or put in."""
    kind, place = chance.randrange(6), chance.randrange(len(data) + 1)
    if kind == 0:
        return data[:place]
    if kind == 1:
        return data[:place] + bytes([chance.randrange(256)]) + data[place + 1 :]
    if kind == 2:
        return (
            data[:place]
            + chance.choice((b"\xff\xfe", b"\x00", b"[" * 100_000, b"{", b",", b"\n", b"\xe9"))
            + data[place:]
        )
    return chance.choice((b"", b"[]", b"null", b"\n", 100_000 * b"[", data[::-1], data + data))


def change(path: Path, chance: random.Random) -> str:
    """Change a file of a run folder; how."""
    data = path.read_bytes()
    kind = chance.randrange(12)
    if kind < 2:
        path.unlink()
        if kind == 1:
            odd = chance.choice(("pipe", "link", "folder"))
            if odd == "pipe":
                os.mkfifo(path)
            elif odd == "folder":
                path.mkdir()
            else:
                path.symlink_to(chance.choice(("/dev/zero", "nowhere", "../victim.txt")))
            return odd
        return "gone"
    own = of_csv if path.suffix == ".csv" else of_json if path.suffix in (".json", "") else of_bytes
    act: Callable[[bytes, random.Random], bytes] = of_bytes if kind < 5 else own
    path.write_bytes(act(data, chance))
    return act.__name__


def seal(run: Path, name: str) -> None:
    """Give the summary the checksum of a changed file, as who hands on a folder can."""
    try:
        summary = json.loads((run / "summary.json").read_text())
        for group in (summary["outputs"], summary["analysed"]["files"]):
            if name in group:
                group[name] = checksum(run / name)
        (run / "summary.json").write_text(json.dumps(summary))
    except (OSError, ValueError, TypeError, KeyError):
        return


def in_place(words: tuple[str, ...], place: Path) -> list[str]:
    """The words of a command, with names in place of their marks."""
    names = {"RUN": "run", "OTHER": "other", "DATA": "data.csv", "CASE": "case.yaml", "STUDY": "study"}
    return [str(place / names[word]) if word in names else word.replace("OUT", str(place / "out")) for word in words]


def hangs(*_) -> None:
    """End a command that waits for ever."""
    raise AssertionError("the command hangs")


@pytest.mark.parametrize("part", range(PARTS))
def test_every_command_says_what_is_wrong_with_a_changed_folder(finished, tmp_path, monkeypatch, capsys, tried, part):
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    place, names = tmp_path / "at", files_of(finished / "run")
    assert {"summary.json", "curves.json", ".lammps-jump", "walls.csv", "contacts.bin", "energy.csv"} <= set(names)
    commands = [name for name in COMMANDS if LONG or name != "animate"]  # which takes a second
    before, wrong = signal.signal(signal.SIGALRM, hangs), []
    seeds = range(SEED + PART * part, SEED + PART * (part + 1))
    print(f"seeds {seeds[0]} to {seeds[-1]}")
    try:
        for seed in seeds:
            chance = random.Random(seed)
            shutil.rmtree(place, ignore_errors=True)
            shutil.copytree(finished, place)
            shutil.copytree(place / "run", place / "other")
            (place / "out").mkdir()
            name, command = names[seed % len(names)], commands[(seed + seed // len(names)) % len(commands)]
            run = place / "run"
            if command == "compare a study":
                (place / "study" / "runs").mkdir(parents=True)
                run = (place / "run").rename(place / "study" / "runs" / "k")
            how = change(run / name, chance)
            if name != "summary.json" and chance.random() < 0.7:
                seal(run, name)
            told = f"seed {seed}: {command}, {name}: {how}"
            signal.alarm(LIMIT)
            try:
                status, _, err = call(monkeypatch, capsys, *in_place(COMMANDS[command], place))
                if status not in (0, 1, 2, 75) or (status and not 0 < len(err.strip()) < 3_000):
                    wrong.append(f"{told}: exit {status}: {err[:300]}")
            except Exception as error:  # all of them are shown at the end
                where = traceback.extract_tb(error.__traceback__)[-1]
                wrong.append(f"{told}: {error!r:.300} at {where.filename}:{where.lineno}")
            finally:
                signal.alarm(0)
            if (place / "victim.txt").read_text() != "precious":
                wrong.append(f"{told}: a file outside was changed")
    finally:
        signal.signal(signal.SIGALRM, before)
    assert not wrong, "\n".join([f"{len(wrong)} of {PART}", *wrong[:50]])
    tried(PART)


@pytest.mark.parametrize("which", ["first", "second"])
@pytest.mark.parametrize(
    ("damage", "said"),
    [
        (lambda run: spoil(run / "summary.json", status="failed", message="blew up"), "failed, not complete: blew up"),
        (
            lambda run: spoil(run / "curves.json", energy=None),
            r"curves.json: differs from its checksum in summary.json",
        ),
    ],
    ids=["a failed run", "other curves"],
)
def test_a_page_of_two_runs_shows_what_complete_runs_have_left(
    finished, tmp_path, monkeypatch, capsys, which, damage, said
):
    shutil.copytree(finished / "run", tmp_path / "run")
    damage(tmp_path / "run")
    pair = (tmp_path / "run", finished / "run")[:: 1 if which == "first" else -1]
    status, _, told = call(monkeypatch, capsys, "compare", *pair, "--out", tmp_path / "c.html")
    assert status == 2 and said in told and not (tmp_path / "c.html").exists()


def spoil(path: Path, **fields: object) -> None:
    """Change fields of a JSON file; None takes one away."""
    data = json.loads(path.read_text()) | fields
    path.write_text(json.dumps({key: value for key, value in data.items() if value is not None}))
