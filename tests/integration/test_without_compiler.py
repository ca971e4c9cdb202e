# SPDX-License-Identifier: GPL-2.0-or-later
"""Without a compiler, and with a wheel that carries nothing, the main job runs from case to report all the same."""

import json

import numpy as np
import pytest
from children import run_program
from made_up import INPUTS, call, coreless

import lammps_jump as lj
from lammps_jump.analysis.passes import gather
from lammps_jump.core import core
from lammps_jump.dump.exports import read_netcdf
from lammps_jump.dump.find import read_dump
from lammps_jump.runs.results import flow_of

SHORT = ("--set", "run.duration=0.3", "--set", "run.time_step_fraction=0.2", "--set", "analysis.window=[0.1, 0.3]")


@pytest.fixture(scope="module")
def made_without(tmp_path_factory):
    """Folder of a run of the main job with a PATH that has no compiler and an empty cache, and what it said."""
    pytest.importorskip("lammps", reason="the main job runs on LAMMPS")
    place = tmp_path_factory.mktemp("without")
    (place / "empty").mkdir()
    nowhere = {"PATH": str(place / "empty"), "CXX": "", "LAMMPS_JUMP_CACHE": str(place / "cache")}
    status, said = run_program("build-and-run", INPUTS / "quick_jump.yaml", *SHORT, "--out", place / "run", env=nowhere)
    assert status == 0
    return place / "run", said


@pytest.mark.lammps
def test_the_main_job_runs_to_its_report(made_without):
    folder, said = made_without
    summary = json.loads((folder / "summary.json").read_text())
    assert summary["status"] == "complete" and summary["kernel"] == "stock"
    assert "stock LAMMPS styles are used" in said and "no C++ compiler (c++, g++, clang++) is found" in said
    assert (folder / "report.html").stat().st_size > 100_000
    left_out = [text for text in summary["warnings"] if "are left out" in text]
    assert len(left_out) == 1 and "there is no compiled core" in left_out[0]


@pytest.mark.lammps
def test_its_profiles_are_those_of_the_core(made_without, compiled_core):
    folder, _ = made_without
    assert core()._name == compiled_core._name  # the handle is another where a test has loaded it anew
    case = lj.load_case(folder / "case.yaml")
    again, there = gather(read_dump(folder), flow_of(case, folder), (), []), read_netcdf(folder / "profiles.nc")
    for name in again.data_vars:
        values = again[name].values
        scale = np.nanmax(np.abs(values), initial=1e-300)
        np.testing.assert_allclose(there[name].values, values, rtol=1e-9, atol=1e-12 * scale, err_msg=name)


def test_the_native_engine_says_what_it_needs(monkeypatch, capsys, tmp_path):
    with coreless():
        status, _, said = call(
            monkeypatch,
            capsys,
            "build-and-run",
            INPUTS / "quick_jump.yaml",
            "--engine",
            "native",
            "--out",
            tmp_path / "run",
        )
    assert status == 2 and "the native engine needs" in said and "no core while the block runs" in said
    assert not (tmp_path / "run").exists()
