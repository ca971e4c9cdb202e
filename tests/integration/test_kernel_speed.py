# SPDX-License-Identifier: GPL-2.0-or-later
"""Kernels side by side: same start for all, ratios within a round, agreement measured where it must hold."""

import json
from pathlib import Path
from types import SimpleNamespace

import kernel_speed
import pytest
from kernel_speed import make_row, make_variants, speed_page, started_from, time_kernels
from made_up import INPUTS
from taking_turns import run_part

from lammps_jump import load_case
from lammps_jump.studies.cross_validation.trajectories import developed_scene


def test_variants_follow_the_case_and_the_machine():
    names = list(make_variants(("stock", "compiled", "native"), friction=0.1, diameter=0.2))
    assert names[0] == "stock" and "compiled, law sign" in names and "stock, skin 0.1 d" in names
    bare = make_variants(("stock", "native"), friction=0.0, diameter=0.2, skins=False)
    assert list(bare) == ["stock", "native"]
    wide = make_variants(("stock",), friction=0.0, diameter=0.4)
    assert wide["stock, skin 0.5 d"] == ("stock", {"engine.skin": 0.2})


def test_ratios_are_those_within_a_round():
    row = make_row("quick", [12.0, 6.0, 12.0], [3.0, 2.0, 2.0])
    assert (row["least"], row["ratio"], row["most"]) == (3.0, 4.0, 6.0) and row["rate"] == 12.0
    broken = make_row("broken", [None], [3.0])
    assert broken["rate"] is None and broken["ratio"] is None
    table = "\n".join(speed_page({"rows": [row, broken], "agreement": {"a and b": 1e-12}}, Path()))
    assert "| quick | 0.0 | 4.00 (3.00 to 6.00) |" in table and "| broken | failed | - |" in table
    assert "a and b: 1.0e-12 d" in table


@pytest.mark.parametrize(("status", "rate"), [("complete", 4.0), ("failed", None)])
def test_a_run_that_fails_has_no_speed(monkeypatch, status, rate):
    ended = SimpleNamespace(status=status, disc_steps=12.0, cpu_seconds=3.0)
    monkeypatch.setattr(kernel_speed, "run_frames", lambda *_, check: (ended, []))
    assert kernel_speed.run_rate(None, "stock") == (rate, 3.0)


def test_every_variant_starts_from_the_developed_discs():
    scene = load_case(INPUTS / "quick_jump.yaml", ["run.duration=0.3"]).scene()
    developed = developed_scene(scene, work=1e5)
    short = started_from(developed, scene, 50)
    assert len(short.positions) == len(developed.positions) > len(scene.positions)
    assert short.steps == short.output_steps == 50 and not short.probes and not short.gates
    assert all(row.first_step == scene.size_steps for row in short.inlets)


@pytest.mark.long
@pytest.mark.lammps
def test_bench_speed_of_a_jet(tmp_path):
    case = load_case(INPUTS / "quick_jump.yaml", {"contact.friction": 0.1, "run.duration": 1})
    table = run_part(case, "speed", time_kernels, speed_page, out=tmp_path, quick=True, say=lambda text: None)
    stored = json.loads((tmp_path / "speed.json").read_text())
    names = [row["name"] for row in stored["rows"]]
    assert names[0] == "stock" and "native" in names and "| stock |" in table
    assert stored["rows"][0]["ratio"] == 1.0 and all(row["rate"] for row in stored["rows"])
    if "compiled" in names:  # without a compiler there is none
        assert stored["agreement"]["compiled and stock"] < 1e-9
        assert stored["agreement"]["compiled and native, law sign"] < 1e-9
