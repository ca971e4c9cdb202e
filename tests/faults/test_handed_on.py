# SPDX-License-Identifier: GPL-2.0-or-later
"""A run folder that was handed on is data: nothing in it becomes a command or a path outside; no edit is believed."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from made_up import INPUTS, call, choose_to_stop_at, without_analysis

import lammps_jump as lj
from lammps_jump.analysis import Force, Front, Jump
from lammps_jump.cli.run import print_summary
from lammps_jump.engines import choice
from lammps_jump.engines.checkpoint import CHECKPOINT_FILE, sum_of
from lammps_jump.errors import DumpError, JumpError, ResumeError, RunInterrupted
from lammps_jump.files import plain
from lammps_jump.physics.jump import inflow_theory
from lammps_jump.runs import start
from lammps_jump.runs.summary import read_summary, write_summary
from lammps_jump.units import as_summary

pytestmark = pytest.mark.usefixtures("blank_pictures")

CHANGES = ["run.duration=0.06", "run.output_interval=0.01"]
STEP = 200
NO_RESULTS = {
    "status": "complete", "message": None, "engine": "native", "kernel": "core", "case_hash": "0", "versions": {},
    "steps": 10, "disc_steps": 10.0, "discs": {"inserted": 1, "present": 1, "removed": 0, "lost": 0},
    "wall_seconds": {"build": 0.1, "run": 0.1, "analysis": 0.1}, "breakdown_seconds": None, "ledger": None,
}  # fmt: skip
"""What stands in every summary."""


@pytest.fixture(scope="module", params=["native", pytest.param("stock", marks=pytest.mark.long)])
def stopped(request, tmp_path_factory) -> Path:
    """The folder of a run that was stopped at `STEP`; tests work on copies."""
    folder = tmp_path_factory.mktemp("stopped") / "run"
    setting = {"engine": "native"} if request.param == "native" else {"kernel": "stock"}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(choice, "choose", choose_to_stop_at(STEP))
        with pytest.raises(RunInterrupted):
            lj.load_case(INPUTS / "dam_break.yaml", CHANGES).run(folder, **setting)
    return folder


@pytest.fixture
def folder(stopped, tmp_path) -> Path:
    """A copy of the stopped run, with a file of the user's beside it."""
    shutil.copytree(stopped, tmp_path / "run")
    (tmp_path / "victim.txt").write_text("precious")
    return tmp_path / "run"


def snapshot(place: Path) -> dict[str, bytes]:
    """Every file below a folder."""
    return {str(path): path.read_bytes() for path in place.rglob("*") if path.is_file()}


def resume(folder: Path) -> None:
    """As `lammps-jump run DIR --resume`."""
    found = lj.open_run(folder)
    start.start(found.case, folder, resume=True)


SHELL = "x\nshell touch PWNED"
SUM = {"size": 0, "sha256": hashlib.sha256().hexdigest()}
WRONG = {
    "scene": [None, 3, [], "another", SHELL],
    "step": [-5, 0, 10**9, 2.5, "200", None, True, float("nan")],
    "time": ["now", float("nan"), float("inf"), None],
    "state": [
        {"../victim.txt": SUM},
        {"/etc/passwd": SUM},
        {SHELL: SUM},
        {"": SUM},
        {},
        {"checkpoint-9.npz": SUM},
        {"checkpoint-200.npz\nshell touch PWNED": SUM},
        {"checkpoint-200.npz": {"size": -1, "sha256": 64 * "0"}},
        "checkpoint-200.npz",
        3,
    ],
    "outputs": [
        {"../victim.txt": SUM},
        {"case.yaml": SUM},
        {"forces_../victim.raw": SUM},
        {"dump.lammpstrj": {"size": -1, "sha256": 64 * "0"}},
        {"dump.lammpstrj": {"size": 1, "sha256": SHELL}},
        {"log.lammps": {"size": 10**12, "sha256": 64 * "0"}},
        {SHELL: SUM},
        [],
        7,
    ],
    "removed": [[-1], ["1\nshell touch PWNED"], {}, 5, [0.5]],
    "result": [None, [], {}, {"status": SHELL}, "x"],
    "result.kernel": [SHELL, None, "garbage"],
    "result.steps": [-5, 7, None, float("nan")],
    "result.seconds": ["long", None],
    "result.versions": [{"a": 1}, [], None],
    "result.resumed": ["x", [None], 3],
    "result.ledger": [[], {"a": "b"}],
}


def spoilt(stored: dict, path: str, value: object) -> dict:
    """The data of a JSON file with another value."""
    *groups, key = path.split(".")
    copied = json.loads(json.dumps(stored))
    inner = copied
    for group in groups:
        inner = inner[group]
    inner[key] = value
    copied.pop("sum")
    try:
        return {**copied, "sum": sum_of(copied)}  # by somebody with bad intentions
    except ValueError:
        return copied


@pytest.mark.fault("values in JSON files")
def test_every_field_of_a_checkpoint_is_checked(folder, tried):
    path = folder / CHECKPOINT_FILE
    stored = json.loads(path.read_text())
    assert stored["step"] >= STEP and set(stored) == {"sum", *(name.partition(".")[0] for name in WRONG)}
    before = snapshot(folder.parent)
    texts = [json.dumps(spoilt(stored, name, value)) for name, values in WRONG.items() for value in values]
    texts += [json.dumps({key: stored[key] for key in stored if key != name}) for name in stored]
    texts.append(json.dumps({**stored, "time": stored["time"] + 1}))
    texts += [100_000 * "[" + 100_000 * "]", 100_000 * '{"a":', "", "null", "[]", "3", "\x00", '{"step": 200}']
    for text in texts:
        path.write_text(text)
        with pytest.raises(ResumeError) as caught:
            resume(folder)
        assert "\n" not in str(caught.value) and len(str(caught.value)) < 500, text[:200]
        assert snapshot(folder.parent) == {**before, str(path): text.encode()}, text[:200]
    tried(len(texts))
    path.write_text(json.dumps(stored))
    resume(folder)  # the one that was not touched goes on
    assert lj.open_run(folder).status == "complete"
    assert not list(folder.parent.rglob("PWNED"))


@pytest.mark.fault("folders")
def test_a_link_is_not_followed(folder):
    (name,) = [name for name in ("dump.lammpstrj",) if (folder / name).is_file()]
    outside = folder.parent / "outside"
    shutil.move(folder / name, outside)
    (folder / name).symlink_to(outside)
    before = outside.read_bytes()
    with pytest.raises(ResumeError, match="is a link"):
        resume(folder)
    assert outside.read_bytes() == before


EDITS = [
    ("diameter", "discs"),
    ("dump_format", "run"),
    ("restitution", "contact"),
    ("description", "description"),
]


@pytest.mark.parametrize("field, named", EDITS)
@pytest.mark.fault("folders")
def test_an_edited_case_is_refused_with_what_differs(folder, field, named, monkeypatch, capsys):
    path = folder / "case.yaml"
    text = path.read_text()
    edited = {
        "diameter": lambda: text.replace("diameter: ", "diameter: 1"),
        "dump_format": lambda: text.replace("dump_format: text", "dump_format: gz"),
        "restitution": lambda: text.replace("restitution: 0", "restitution: 0.0"),
        "description": lambda: text.replace("description: ", "description: another "),
    }[field]()
    assert edited != text
    path.write_text(edited)
    before = snapshot(folder)
    for attempt in (resume, start.reanalyse, lambda place: lj.open_run(place).summary):
        with pytest.raises(JumpError, match=f"case.yaml: {named} was changed after") as caught:
            attempt(folder)
        assert "\n" not in str(caught.value)
    assert snapshot(folder) == before
    status, _, said = call(monkeypatch, capsys, "analyze", folder)
    assert status == 2 and "was changed after" in said
    assert snapshot(folder) == before


def test_a_copy_of_the_case_may_be_edited(folder, tmp_path):
    copied = tmp_path / "mine.yaml"
    copied.write_text((folder / "case.yaml").read_text().replace("seed: 1", "seed: 2"))
    assert lj.load_case(copied).fields.run.seed == 2


def test_an_analysis_that_was_asked_for_is_no_edit(folder, monkeypatch):
    without_analysis(monkeypatch)
    resume(folder)
    start.reanalyse(folder, ["analysis.bin_width=0.5"])
    assert lj.open_run(folder).case.fields.analysis.bin_width == 0.5
    start.reanalyse(folder)


SUMMARY_VALUES = [None, -5, float("nan"), "x\nshell touch PWNED", [], {}, 10**400, [[[[]]]]]


@pytest.mark.parametrize("part", [0, *(pytest.param(part, marks=pytest.mark.long) for part in (1, 2))])
@pytest.mark.fault("values in JSON files")
def test_every_field_of_a_summary_is_checked(folder, monkeypatch, tried, part):
    """A summary is believed, refused in a sentence, or left aside: no traceback, nothing outside is touched."""
    without_analysis(monkeypatch)
    resume(folder)
    path = folder / "summary.json"
    stored = json.loads(path.read_text())
    outside = folder.parent / "victim.txt"
    texts = [json.dumps({**stored, name: value}) for name in stored for value in SUMMARY_VALUES]
    texts += [100_000 * "[" + 100_000 * "]", "", "null", "[]", json.dumps({**stored, "files": ["../victim.txt"]})]
    texts = texts[part::3]  # each field with two or three of the eight values
    for text in texts:
        path.write_text(text)
        try:
            found = lj.open_run(folder)
            assert found.status
            assert found.result.steps >= 0
            start.start(found.case, folder)
            print_summary(found.summary, folder)
        except JumpError as error:
            assert "\n" not in str(error), text[:100]
        assert outside.read_text() == "precious"
        if not path.exists() or path.read_text() != text:
            path.write_text(json.dumps(stored))
    assert not list(folder.parent.rglob("PWNED"))
    tried(len(texts))


def leaves(tree, place=()):
    """Places of all values in plain data, of lists that of the first."""
    inner = tree.items() if isinstance(tree, dict) else list(enumerate(tree))[:1] if isinstance(tree, list) else ()
    for key, value in inner:
        yield (*place, key)
        yield from leaves(value, (*place, key))


@pytest.mark.fault("values in JSON files")
def test_results_of_another_kind_are_refused(tmp_path, tried):
    """A text or a list where the report wants a number of the jump, the front or the forces ended in a traceback."""
    jump = as_summary(replace(Jump("jump", "found"), y2=1.5, inflow=inflow_theory(0.6, 10.0, 9.81)))
    force = {"wall": as_summary(Force("wall")), "low_pass": 3.0, "settled": {"wall": {"mean_fx": 2.0}}, "notes": ["x"]}
    front = as_summary(Front(column_base=1.0, column_depth=2.0, position=3.0))
    stored = plain({**NO_RESULTS, "jump": jump, "front": front, "force": force})
    write_summary(tmp_path, stored)
    assert read_summary(tmp_path) == stored
    places, refused = [place for name in ("jump", "front", "force") for place in leaves(stored[name], (name,))], 0
    for place in places:
        for value in ("text", [[7]], {"a": [1]}, 10**400, True):
            changed = json.loads(json.dumps(stored))
            inner = changed
            for key in place[:-1]:
                inner = inner[key]
            inner[place[-1]] = value
            (tmp_path / "summary.json").write_text(json.dumps(changed))
            try:
                found = read_summary(tmp_path)
                print_summary(found, tmp_path)
            except DumpError as error:
                assert "\n" not in str(error) and ": ".join(map(str, place[:2])) in str(error)
                refused += 1
    assert refused > 4 * len(places)
    tried(5 * len(places))


def test_a_summary_that_is_a_pipe_is_not_waited_for(folder):
    (folder / "summary.json").unlink()
    os.mkfifo(folder / "summary.json")
    (folder / CHECKPOINT_FILE).unlink()
    os.mkfifo(folder / CHECKPOINT_FILE)
    with pytest.raises(ResumeError, match="no regular file"):
        resume(folder)
