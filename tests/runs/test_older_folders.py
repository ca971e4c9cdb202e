# SPDX-License-Identifier: GPL-2.0-or-later
"""Run folders and studies of an earlier version, whose words are old, are analysed and shown, and do not go on."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from made_up import BOX, call

import lammps_jump as lj
from lammps_jump.errors import CaseError, ResumeError
from lammps_jump.identity import field_keys, run_key
from lammps_jump.runs.folder import MADE
from lammps_jump.sweeps.sweep import Sweep, open_sweep, prepare, require_new, study_folder

CONTACT = {"restitution": 0.9, "friction": 0.1, "friction_law": "viscous", "largest_overlap": 0.1, "impact_speed": 8}
CASE = {
    **BOX, "contact": CONTACT, "run": {"duration": 0.05, "output_interval": 0.01},
    "analysis": {"figures": "none", "jump": False, "front": False},
}  # fmt: skip


OLD = {
    "friction_law: viscous": "friction_law: hooke",
    "largest_overlap: 0.1": "penetration_fraction: 10.0",
    '"friction_law": "viscous"': '"friction_law": "hooke"',
    '"largest_overlap": 0.1': '"penetration_fraction": 10.0',
}
"""What the earlier version wrote in place of the text of this one, in YAML and JSON."""


def old(text: str) -> str:
    """Text of this version as the earlier one wrote it."""
    for new, word in OLD.items():
        text = text.replace(new, word)
    return text


def aged(folder: Path) -> str:
    """Make a run folder one of the earlier version; the key of its run."""
    _, _, text = (folder / "case.yaml").read_text().partition("\n")
    text = old(text)
    head = f"{MADE} {' '.join(f'{field}={found}' for field, found in field_keys(text).items())}\n"
    (folder / "case.yaml").write_text(head + text)
    marker, summary = (json.loads((folder / name).read_text()) for name in (".lammps-jump", "summary.json"))
    about = marker["about"]
    about["case"]["contact"] = json.loads(old(json.dumps(about["case"]["contact"])))
    about["key"] = summary["key"] = run_key(about["case"], about["program"])
    summary["friction_law"] = "hooke"
    (folder / ".lammps-jump").write_text(json.dumps(marker))
    (folder / "summary.json").write_text(json.dumps(summary))
    assert "hooke" in text and "penetration_fraction: 10.0" in text
    return about["key"]


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A run of the earlier version."""
    folder = tmp_path_factory.mktemp("older") / "run"
    lj.load_case(CASE).run(folder)
    aged(folder)
    return folder


def test_an_older_run_is_analysed_and_compared(monkeypatch, capsys, run, tmp_path):
    before = (run / "case.yaml").read_bytes(), (run / ".lammps-jump").read_bytes()
    opened = lj.open_run(run)
    assert opened.summary["friction_law"] == opened.case.fields.contact.friction_law == "viscous"
    assert opened.case.fields.contact.largest_overlap == 0.1
    status, _, said = call(monkeypatch, capsys, "analyze", run, "-q")
    assert (status, said) == (0, "")
    assert json.loads((run / "summary.json").read_text())["friction_law"] == "viscous"
    assert ((run / "case.yaml").read_bytes(), (run / ".lammps-jump").read_bytes()) == before
    assert call(monkeypatch, capsys, "compare", run, run, "--out", tmp_path / "both.html")[0] == 0
    assert lj.open_run(run).status == "complete"


def test_an_older_run_with_a_page_is_shown(monkeypatch, capsys, run):
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    (run / "report.html").write_text("page")
    assert call(monkeypatch, capsys, "show", run)[:2] == (0, f"{run / 'report.html'}\n")
    (run / "report.html").unlink()


def test_what_changes_the_analysis_keeps_the_old_words(monkeypatch, capsys, run):
    """Its case is still that of the version that wrote it."""
    assert call(monkeypatch, capsys, "analyze", run, "-q", "--set", "analysis.bin_width=0.5")[0] == 0
    text = (run / "case.yaml").read_text()
    assert "bin_width: 0.5" in text and "friction_law: hooke" in text and "penetration_fraction: 10.0" in text
    assert lj.open_run(run).case.fields.analysis.bin_width == 0.5


def test_an_older_run_does_not_go_on(monkeypatch, capsys, run):
    stored = (run / "summary.json").read_text()
    (run / "summary.json").write_text(json.dumps({**json.loads(stored), "status": "interrupted"}))
    status, _, said = call(monkeypatch, capsys, "run", run, "--resume", "-q")
    assert status == 2 and "only that version can go on with it" in said and str(run) in said
    (run / "summary.json").write_text(stored)
    assert call(monkeypatch, capsys, "run", run, "-q")[0] == 0  # complete: there is nothing to do


def test_an_older_case_runs_anew_in_new_words(monkeypatch, capsys, run, tmp_path):
    assert call(monkeypatch, capsys, "build-and-run", run / "case.yaml", "--out", tmp_path / "new", "-q")[0] == 0
    text = (tmp_path / "new" / "case.yaml").read_text()
    assert "friction_law: viscous" in text and "largest_overlap: 0.1" in text and "hooke" not in text
    study = lj.sweeps.read_study({"case": str(run), "axes": {"run.seed": [1, 2]}, "members": 1})
    assert not study.case.source.translated  # its members are of this version


def test_old_words_beside_an_older_run(monkeypatch, capsys, run):
    """They are read in the folder alone; a change is in new words, and a copy elsewhere is a user's file."""
    again = call(monkeypatch, capsys, "check", run / "case.yaml", "--set", "contact.friction_law=hooke")
    assert again[0] == 2 and "hooke is now viscous" in again[2]
    assert call(monkeypatch, capsys, "check", run / "case.yaml")[0] == 0
    (run.parent / "copy.yaml").write_text((run / "case.yaml").read_text())
    status, _, said = call(monkeypatch, capsys, "check", run.parent / "copy.yaml")
    assert status == 2 and "copy.yaml:" in said and "hooke is now viscous" in said


AXES = {"contact.largest_overlap": [0.1, 0.05]}
COLLECT = ["discs.present"]


def test_an_older_study_is_read_and_does_not_go_on(tmp_path):
    study = lj.sweeps.read_study({"case": CASE, "axes": AXES, "members": 1, "collect": COLLECT})
    found = Sweep(study, tmp_path / "study")
    with study_folder(found.folder):
        prepare(found)
    keys = {}
    for member in found.members:
        member.case.run(member.folder(found.folder))
        text = (member.folder(found.folder) / "case.yaml").read_text()
        if "largest_overlap: 0.1" in text:
            keys[member.key] = aged(member.folder(found.folder))
    for name in ("study.yaml", "points.json"):
        text = old((found.folder / name).read_text()).replace("contact.largest_overlap", "contact.penetration_fraction")
        for key, new in keys.items():
            text = text.replace(key, new)
        (found.folder / name).write_text(text.replace("[0.1, 0.05]", "[10.0, 20.0]"))
    for key, new in keys.items():
        (found.folder / "runs" / key).rename(found.folder / "runs" / new)
    assert "penetration_fraction" in (found.folder / "study.yaml").read_text()
    opened = open_sweep(found.folder)
    assert opened.study.points == found.study.points
    assert [Path(run.folder).name for run in opened.runs] == [*keys.values()]
    with pytest.raises(ResumeError, match="only that version can go on with it"):
        lj.sweep(found.folder)
    with pytest.raises(ResumeError):
        require_new(found.folder)


@pytest.mark.parametrize(
    ("fields", "said"),
    [
        (
            {"axes": {"contact.penetration_fraction": [5, 10]}},
            r"axes.contact.penetration_fraction: \[5, 10\] is n",
        ),
        ({"set": {"contact.friction_law": "hooke"}}, "set.contact.friction_law: hooke is now viscous"),
        (
            {"case": {**CASE, "contact": {**CONTACT, "friction_law": "hooke"}}},
            "case.contact.friction_law: hooke is",
        ),
        ({"axes": {"zip": {"contact.friction_law": ["hooke", "sign"], "run.seed": [1, 2]}}}, "now .viscous, sign."),
    ],
)
def test_old_words_of_a_study_are_refused(fields, said):
    with pytest.raises(CaseError, match=said):
        lj.sweeps.read_study({"case": CASE, **fields})
