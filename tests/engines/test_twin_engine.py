# SPDX-License-Identifier: GPL-2.0-or-later
"""The twin as an engine: where it is named, what it refuses, and that other commands take it."""

from __future__ import annotations

import json

import pytest
from made_up import INPUTS, call

import lammps_jump as lj
from lammps_jump.case.checks import MOST_TWIN_HOURS, TWIN_SECONDS
from lammps_jump.engines import choice
from lammps_jump.studies.cross_validation import study as cross_validation

COLUMN = """
name: few
discs: {diameter: 0.2, density: 1000}
contact: {restitution: 0.4, friction: 0, impact_speed: 5}
domain: {x: [-1, 12], y: [-1, 5]}
walls:
  - {name: back, kind: plane, axis: x, at: 0, side: above}
  - {name: floor, kind: plane, axis: y, at: 0, side: above}
initial: [{kind: column, x: [0, 0.6], y: [0, 0.6], hydrostatic: true, gate: true}]
run: {duration: 0.1, time_step_fraction: 0.1, output_interval: 0.02}
analysis: {bin_width: 0.4, figures: none}
"""


def test_a_run_of_hours_is_refused_with_its_time_and_what_to_do(monkeypatch, capsys, tmp_path):
    changes = ("--set", "engine.name=twin", "--set", "run.duration=3")
    scene = lj.load_case(INPUTS / "dam_break.yaml", {"run.duration": 3}).scene()
    hours = TWIN_SECONDS * scene.steps * scene.expected_discs / 3600
    status, _, err = call(monkeypatch, capsys, "check", INPUTS / "dam_break.yaml", *changes)
    assert hours <= MOST_TWIN_HOURS and status == 0
    long = ("--set", "engine.name=twin", "--set", "run.duration=30")
    status, _, err = call(monkeypatch, capsys, "check", INPUTS / "dam_break.yaml", *long)
    assert status == 2 and "engine.name" in err and f"about {10 * hours:.3g} h in plain Python" in err
    assert f"allowed are {MOST_TWIN_HOURS}" in err and "lower run.duration" in err and "engine.name: native" in err
    monkeypatch.chdir(tmp_path)
    status, _, err = call(monkeypatch, capsys, "build-and-run", INPUTS / "dam_break.yaml", *long)
    assert status == 2 and not list(tmp_path.iterdir())


def test_the_native_engine_without_a_core_names_the_twin(monkeypatch, capsys, tmp_path):
    monkeypatch.setattr(choice, "core", lambda: None)
    monkeypatch.setattr(choice, "why_absent", lambda: "c++ is not found")
    (tmp_path / "few.yaml").write_text(COLUMN)
    monkeypatch.chdir(tmp_path)
    status, _, err = call(monkeypatch, capsys, "build-and-run", "few.yaml", "--engine", "native")
    assert status == 2 and "c++ is not found" in err and "`--engine twin` needs none" in err
    assert [path.name for path in tmp_path.iterdir()] == ["few.yaml"]


def test_the_twin_runs_to_the_same_end(tmp_path):
    """As an engine of its own, from case to result: places of the native engine but for round-off."""
    (tmp_path / "few.yaml").write_text(COLUMN)
    case = lj.load_case(tmp_path / "few.yaml")
    found = [case.replace({"engine.name": name}).run(tmp_path / name) for name in ("native", "twin")]
    one, two = (list(run.frames())[-1].sorted() for run in found)
    assert found[1].result.engine == "twin" and found[1].result.kernel == "python"
    assert abs(one.x - two.x).max() < 1e-9 * 0.2 and abs(one.y - two.y).max() < 1e-9 * 0.2


def test_cross_validation_hands_on_the_twin(monkeypatch, tmp_path):
    """The cheap form of the test below: the name goes to the ensemble that LAMMPS is compared with."""
    asked = []

    class Stop(Exception):
        pass

    def run(study, case, kernel):
        asked.append(kernel)
        if len(asked) == 2:
            raise Stop

    monkeypatch.setattr(cross_validation, "_disc_by_disc", lambda *of: None)
    monkeypatch.setattr(cross_validation.CrossValidation, "run", run)
    (tmp_path / "few.yaml").write_text(COLUMN)
    with pytest.raises(Stop):
        cross_validation.cross_validate(
            lj.load_case(tmp_path / "few.yaml"), out=tmp_path / "out", kernel="stock", engine="twin", quick=True
        )
    assert asked == ["stock", "twin"]


@pytest.mark.lammps
@pytest.mark.long
def test_cross_validation_takes_the_twin(monkeypatch, capsys, tmp_path):
    monkeypatch.setattr(cross_validation, "micro_scenes", lambda: [])
    monkeypatch.setattr(cross_validation, "QUICK_DIVERGENCE_WORK", 1e4)
    (tmp_path / "few.yaml").write_text(COLUMN)
    out = tmp_path / "out"
    call(
        monkeypatch, capsys, "cross-validate", tmp_path / "few.yaml", "--out", out, "--quick", "--members", "2",
        "--kernel", "stock", "--engine", "twin",
    )  # fmt: skip
    found = json.loads((out / "cross_validation.json").read_text())
    assert "twin" in json.dumps(found)
    assert "twin" in (out / "cross_validation.html").read_text()
