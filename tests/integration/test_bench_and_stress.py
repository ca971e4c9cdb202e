# SPDX-License-Identifier: GPL-2.0-or-later
"""Shortened runs of every study, from the command line's entry functions, with LAMMPS."""

import json

import cell_search
import collisions
import pytest
import script_skips
import taking_turns
from made_up import INPUTS

from lammps_jump import load_case
from lammps_jump.studies import sensitivity
from lammps_jump.studies.bench import run_bench, stored_table
from lammps_jump.studies.points import load_module, run_named, run_study

pytestmark = pytest.mark.lammps


def silent(text):
    pass


@pytest.mark.long
def test_bench_of_the_energy_box(tmp_path):
    case, options = load_case(INPUTS / "energy_box_16.yaml", ("run.duration=4",)), {"quick": True, "say": silent}
    table = run_bench(case, out=tmp_path, **options)
    data = json.loads((tmp_path / "bench.json").read_text())
    assert "energy deviation" in data["quantities"] and "| stock f=0.05 |" in table
    assert all(row["seconds"] >= 0 and not row["failed"] for row in data["rows"])
    assert (tmp_path / "bench_energy_deviation.png").stat().st_size > 5000
    assert "/" not in json.dumps(data["machine"]), "no paths in what is published"
    run_bench(case, out=tmp_path, **options)  # everything is stored: nothing is measured again
    again = json.loads((tmp_path / "bench.json").read_text())
    assert [row["seconds_all"] for row in again["rows"]] == [row["seconds_all"] for row in data["rows"]]
    assert stored_table(INPUTS / "energy_box_16.yaml", tmp_path) == table


@pytest.mark.long
def test_bench_of_collisions(tmp_path):
    collisions.run_collisions(tmp_path / "new", quick=True, say=silent)
    assert (tmp_path / "new" / "bench_collision.png").is_file()
    rows = json.loads((tmp_path / "new" / "collision.json").read_text())["rows"]
    found = {(row["way"], row["restitution"], row["fraction"]): row["restitution_error"] for row in rows}
    # `contact.lagged_restitution` at f = 0.05: 4.7 % low by closed form, gone when corrected (64 phases: 0.5 %)
    assert found["stock, uncorrected", 0.2, 0.05] == pytest.approx(-0.047, abs=0.008)
    assert abs(found["stock, corrected", 0.2, 0.05]) < 0.008


def test_bench_of_cells(tmp_path):
    case = load_case(INPUTS / "dam_break.yaml", {"run.duration": 0.05, "probes.forces": []})
    part = ("cells", cell_search.time_cells, cell_search.cell_page)
    table = taking_turns.run_part(case, *part, out=tmp_path, quick=True, say=silent)
    assert (tmp_path / "cells.png").stat().st_size > 5000 and (tmp_path / "cells.md").read_text() == table
    assert "cells of 2 d" in table and "neighbour list" in table


@pytest.fixture(scope="module")
def column():
    texts = ["run.duration=0.03", "run.output_interval=0.01", "engine.kernel=stock", "probes.forces=[]"]
    return load_case(INPUTS / "dam_break.yaml", texts).scene()


@pytest.fixture(scope="module")
def box():
    return load_case(INPUTS / "energy_box_16.yaml", ["run.duration=0.6", "engine.kernel=stock"]).scene()


@pytest.mark.parametrize("skip", script_skips.SKIPS, ids=lambda skip: skip.name)
def test_skips_change_no_trajectory(skip, column, box):
    scene = box if "gravity" in skip.name else column
    difference = script_skips.compare_skip(scene, skip)
    assert difference is not None, "the edit found nothing to put back in"
    # lists built at other steps or with another skin change the order of sums: round-off, not yet grown
    assert difference <= (0.0 if skip.exact else 1e-12)


def test_periodic_crystal_brackets_the_limit():
    stress_limits = load_module(INPUTS.parent / "validation" / "stress", "limits")
    assert stress_limits.crystal_growth(0.2, 0.280, steps=8000)["stable"]
    assert stress_limits.crystal_growth(0.2, 0.285, steps=8000)["growth"] > 1e3


@pytest.mark.long
def test_stress_quick(tmp_path):
    data, page = run_named("stress", tmp_path, quick=True, random=3, seed=40, say=silent)
    packings = [r for r in data["limits"] if r["engine"] == "stock" and r["arrangement"] in ("square", "hexagonal")]
    assert packings and all(abs(row["deviation"]) < 0.03 for row in packings)
    assert data["bad"] == [] and "## What ended badly\n\nNothing." in page
    assert (tmp_path / "stress_map.png").stat().st_size > 5000 and (tmp_path / "stress.md").read_text() == page


@pytest.mark.long
def test_sensitivity_smoke(tmp_path):
    made = sensitivity.study(quick=True, only="friction")
    data, text = run_study(made, tmp_path, say=silent)
    assert "friction coefficient" in text and (tmp_path / "sensitivity_friction.png").exists()
    said = []
    again, _ = run_study(made, tmp_path, say=said.append)
    assert again["studies"] == data["studies"] and not said, "it was stored"
