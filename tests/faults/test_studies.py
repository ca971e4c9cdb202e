# SPDX-License-Identifier: GPL-2.0-or-later
"""Folders of sweeps and calibrations in which one file is another: told in words, by every command that reads them."""

from __future__ import annotations

import shutil
import sys

import pytest
from fault_table import LONG
from made_up import BOX, Here, call
from put_in_place import ends_a_hang, look, put
from serving import send, serving
from stand_in_runs import calibrated

import lammps_jump as lj
from lammps_jump.calibration.search import Search
from lammps_jump.errors import RunInterrupted

pytestmark = [pytest.mark.usefixtures("blank_pictures"), pytest.mark.fault("files in the folder of a study")]
FAULTS = ("absent", "folder", "pipe", "endless", "empty", "garbage", "brackets", "huge", "Latin-1")
FILES = {
    "sweep": (
        "study.yaml",
        "points.json",
        "summary.json",
        "table.csv",
        ".lammps-jump",
        "RUN/summary.json",
        "RUN/case.yaml",
    ),
    "calibrate": ("study.yaml", "rounds.json", "calibration.json", ".lammps-jump"),
}
COMMANDS = {
    "sweep": (("sweep", "@", "--status"), ("sweep", "@", "--table"), ("show", "@"), ("figures", "@")),
    "calibrate": (("calibrate", "@"), ("show", "@"), ("figures", "@")),
}
ALL = [(kind, file, fault) for kind, files in FILES.items() for file in files for fault in FAULTS]
SHORT = [(kind, file, FAULTS[n % len(FAULTS)]) for n, (kind, file, _) in enumerate(ALL[:: len(FAULTS)])]


class OneHere(Here):
    """A pool of this process."""

    def close(self):
        pass


@pytest.fixture(scope="module")
def studies(tmp_path_factory):
    """A finished sweep, and a calibration of stand-in runs."""
    place = tmp_path_factory.mktemp("studies")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys.modules["lammps_jump.sweeps.sweep"], "Pool", OneHere)
        lj.sweep(
            {"case": BOX},
            place / "sweep",
            axes={"contact.restitution": [0.8, 1.0]},
            members=1,
            collect=["discs.present"],
        )
        calibrated(patch, place / "calibrate", [{"key": "heap.angle", "value": 20.0, "error": 0.5}])
    return place


def begins(search, pool):
    """In place of the runs of a calibration."""
    raise RunInterrupted("the runs begin")


@pytest.mark.parametrize(("kind", "file", "fault"), ALL if LONG else SHORT, ids=lambda one: one)
def test_a_file_that_is_another_is_told(studies, tmp_path, monkeypatch, capsys, tried, kind, file, fault):
    folder = tmp_path / "study"
    shutil.copytree(studies / kind, folder)
    run = next((folder / "runs").iterdir()).name if kind == "sweep" else ""
    place = folder / file.replace("RUN", f"runs/{run}")
    place.unlink()
    put(fault, place)
    before = look(place)
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.setattr(Search, "run", begins)
    with ends_a_hang():
        for words in COMMANDS[kind]:
            status, _, err = call(monkeypatch, capsys, *(folder if word == "@" else word for word in words))
            assert status in (0, 1, 2, 75) and len(err.strip()) < 3_000, (words, err)
            assert status == 0 or err.strip(), words
        if kind == "sweep" and place.name != "study.yaml":
            with serving(folder) as server:
                assert send(server, "GET", f"/{server.token}/state")[0] in (200, 404, 422)
    assert look(place) == before or file == "rounds.json"  # a file of the program, which may begin anew
    tried(len(COMMANDS[kind]))
