# SPDX-License-Identifier: GPL-2.0-or-later
"""The Python API: a case as an object, a run as a view of its folder, and what it never does to its caller."""

from __future__ import annotations

import json
import os
import random
import shutil
import signal
import subprocess
import sys
from dataclasses import FrozenInstanceError
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
import yaml
from made_up import INPUTS

import lammps_jump as lj
import lammps_jump.runs.start
from lammps_jump.cli.analyse import export
from lammps_jump.files import plain
from lammps_jump.units import as_summary

pytestmark = pytest.mark.usefixtures("blank_pictures")

NOTEBOOK = Path(__file__).parents[2] / "docs" / "notebooks" / "first_jump.ipynb"
SHORT = {"run.duration": 0.3, "run.output_interval": 0.05, "engine.name": "native", "analysis.window": [0.1, 0.3]}
PUBLIC = """Calibrated Case CaseError Dump DumpError Energy Force Frame Frames Front Jump JumpError Progress ResumeError
Run RunError RunInterrupted RunResult Scene SetupError SteppedRun Sweep __version__ budget calibrate find load_case open
open_run read_dump run sweep""".split()


@pytest.fixture(scope="module")
def case():
    return lj.load_case(INPUTS / "quick_jump.yaml", SHORT)


@pytest.fixture(scope="module")
def finished(case, tmp_path_factory):
    return case.run(tmp_path_factory.mktemp("api") / "run").folder


def contents(folder: Path) -> dict[str, tuple[bytes, int]]:
    """Bytes and time of change of every file."""
    return {str(path): (path.read_bytes(), path.stat().st_mtime_ns) for path in folder.rglob("*") if path.is_file()}


def caller() -> tuple:
    """What a library has no right to change in the process that calls it."""
    handlers = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)]
    numbers = np.random.get_state()  # noqa: NPY002  (the global state is what is looked at)
    state = (random.getstate(), numbers[1].tobytes(), numbers[2])
    return Path.cwd(), dict(os.environ), handlers, state, plt.get_fignums(), plt.get_backend(), dict(plt.rcParams)


def test_public_names():
    assert sorted(lj.__all__) == sorted(PUBLIC)
    assert all(getattr(lj, name) is not None for name in lj.__all__)
    assert dir(lj) == lj.__all__
    assert (
        lj.__version__
        in subprocess.run([sys.executable, "-m", "lammps_jump", "--version"], capture_output=True, text=True).stdout
    )


@pytest.mark.parametrize("eager", ["", pytest.param("1", marks=pytest.mark.long)])
def test_importing_costs_nothing_and_every_lazy_name_is_there(eager):
    code = "import sys, lammps_jump; print(len({'numpy', 'yaml', 'pydantic', 'matplotlib'} & set(sys.modules)))"
    environment = {**os.environ, "EAGER_IMPORT": eager}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == ("4" if eager else "0")


def test_case_is_frozen_and_replaced_as_a_file_is_read(case):
    other = case.replace({"walls.sill.y": [-10, 3], "contact.friction": np.float64(0.3), "discs.diameter": "15 cm"})
    assert type(other) is lj.Case and other.fields.walls[1].y == (-10, 3) and other.fields.contact.friction == 0.3
    assert case.fields.contact.friction != 0.3 and other.hash != case.hash and other.name == case.name
    assert case.replace({}) == case and case.replace({"description": "another"}).hash == case.hash
    with pytest.raises(FrozenInstanceError):
        case.fields = other.fields
    assert case == lj.load_case(INPUTS / "quick_jump.yaml", SHORT)


@pytest.mark.parametrize(
    ("path", "value", "said"),
    [
        ("contact.friktion", 1, "did you mean 'friction'"),
        ("walls.sluice.y", [0, 1], "no item"),
        ("contact.friction", -1, "allowed is >= 0"),
        ("run", object(), "no value of a case"),
    ],
)
def test_wrong_changes_are_refused(case, path, value, said):
    with pytest.raises(lj.CaseError, match=said):
        case.replace({path: value})


def test_case_from_a_mapping_and_from_a_run_folder(case, finished):
    fields = yaml.safe_load(case.to_yaml())
    assert lj.load_case(fields) == case == lj.load_case(finished)
    with pytest.raises(lj.CaseError, match=r"<case>: contact.restitution: 2 is out of range"):
        lj.load_case({**fields, "contact": {"restitution": 2, "stiffness": 1e6}})


def test_check_tells_coefficients_theory_and_skips(case):
    found = case.check()
    assert found.numbers["froude"] == pytest.approx(10 / np.sqrt(9.81 * 0.6))
    assert found.numbers["time_step"] == case.scene().coefficients.time_step
    assert found.skipped == case.scene().skipped and found.warnings == case.scene().warnings
    assert json.loads(json.dumps(found.as_data()))["name"] == "quick_jump" and "time step" in str(found)


@pytest.mark.long
def test_lines_of_the_design(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    shutil.copytree(INPUTS, "inputs")
    case = lj.load_case("inputs/quick_jump.yaml", SHORT)
    run = case.replace({"contact.friction": 0.1}).run("runs/friction")
    print(run.jump.verdict, run.jump.y2, "+/-", run.jump.y2_error, "m")
    run.profiles.mass_depth.plot()
    plt.close("all")
    assert capsys.readouterr().out.startswith("jump 3.") and (tmp_path / "runs/friction/report.html").exists()


def test_a_run_without_figures_has_the_same_numbers(case, finished, tmp_path):
    run = case.replace({"analysis.figures": "none"}).run(tmp_path / "run")
    assert not (run.folder / "figures").exists() and not (run.folder / "report.html").exists()
    whole = lj.open_run(finished).summary
    assert run.summary["key"] == whole["key"] and run.summary["jump"] == whole["jump"]
    assert run.summary["cpu_seconds"] > 0
    made = lj.run(run.case.replace({"analysis.figures": "default"}), run.folder)  # nothing is run again
    assert (run.folder / "report.html").exists()
    assert made.summary["wall_seconds"]["run"] == run.summary["wall_seconds"]["run"]


def test_the_caller_is_left_alone(case, tmp_path, capfd):
    before = caller()
    run = lj.run(case, tmp_path / "run", progress=lambda report: None)
    run.figure()
    assert run.jump.verdict and run.analyse(bin_width=2.0).profiles.attrs["bin_width"] == pytest.approx(2, rel=0.1)
    after = caller()
    assert before == after
    assert capfd.readouterr() == ("", "")
    assert [path.name for path in tmp_path.iterdir()] == ["run"]


def test_looking_at_a_run_writes_nothing(finished):
    before = contents(finished)
    run = lj.open_run(finished)
    assert run.status == "complete" and run.case.name == "quick_jump" and run.scene.steps == run.result.steps
    assert run.summary == json.loads((finished / "summary.json").read_text())
    assert run.profiles.mass_depth.dims == ("time", "x") and np.isnan(run.jump.y2_error)
    assert plain(as_summary(run.jump)) == run.summary["jump"]
    assert set(run.forces) == {"sill"} and run.forces["sill"].history.fx.shape == run.forces["sill"].history.time.shape
    assert run.energy.history.kinetic.shape == run.energy.history.time.shape and run.energy.final > 0  # not asked for
    assert run.front.position > 0 and run.warnings == tuple(run.summary["warnings"])
    assert len(list(run.frames(0, None, 2))) == (len(lj.read_dump(finished)) + 1) // 2
    assert run.figure("depth_map").axes and "<table>" in run._repr_html_() and "<svg" in run.case._repr_html_()
    assert run.analyse(window=(0.2, 0.3)).profiles.attrs["window_begin"] == 0.2
    with pytest.raises(lj.DumpError, match="allowed is one of depth_profile"):
        run.figure("depth")
    assert contents(finished) == before


def test_run_without_its_summary_is_read_from_its_dump(finished, tmp_path):
    folder = Path(shutil.copytree(finished, tmp_path / "run"))
    whole = lj.open_run(folder).summary
    for name in ("summary.json", "profiles.nc"):
        (folder / name).unlink()
    before = contents(folder)
    run = lj.open_run(folder)
    assert run.status == "complete" and "left no summary" in run.result.message
    assert run.summary["discs"] == whole["discs"] and plain(run.summary["jump"]) == whole["jump"]
    assert np.isfinite(run.profiles.mass_depth).any() and contents(folder) == before
    assert run.report(tmp_path / "page.html").read_text().startswith("<!doctype html>") and contents(folder) == before


def test_stored_result_is_returned_at_once(case, finished):
    before = contents(finished)
    assert lj.run(case, finished).folder == finished and contents(finished) == before


def test_stopped_run_is_kept_and_goes_on(case, tmp_path):
    seen = []

    def stop() -> bool:
        seen.append(lj.open_run(tmp_path).status)
        return True

    long = case.replace({"run.duration": 600, "analysis.window": [0, 600]})
    with pytest.raises(lj.RunInterrupted, match="--resume") as caught:
        long.run(tmp_path, should_stop=stop)
    run = caught.value.run
    assert seen == ["running"] and run.status == "interrupted" and run.folder == tmp_path
    assert 0 < run.result.steps < run.scene.steps
    with pytest.raises(lj.RunInterrupted) as again:
        long.run(tmp_path, resume=True, should_stop=lambda: True)
    assert again.value.run.result.steps > run.result.steps and len(again.value.run.result.resumed) == 1
    with pytest.raises(lj.ResumeError, match="differs"):
        case.run(tmp_path, resume=True)


def test_a_folder_without_a_run(tmp_path):
    with pytest.raises(lj.CaseError, match="no run folder"):
        lj.open_run(tmp_path)


def test_dump_is_a_sequence_of_frames(finished):
    dump = lj.read_dump(finished)
    assert len(dump) == len(list(dump)) and dump[0].step == 0 and dump[-1].step == list(dump)[-1].step
    assert [frame.step for frame in dump[::2]] == [frame.step for frame in dump][::2]
    with pytest.raises(IndexError, match=f"holds {len(dump)} frames"):
        dump[len(dump)]
    with pytest.raises(ValueError, match="forwards"):
        dump[::-1]


def test_export_writes_what_other_programs_read(finished, tmp_path, capsys):
    folder = Path(shutil.copytree(finished, tmp_path / "run"))
    export(folder, vtk=True, csv=True, pictures=True)
    told = {Path(line).name for line in capsys.readouterr().out.splitlines()}
    assert {"profiles.csv", "profiles_mean.csv", "picture0.dat", "discs0.vtp", "discs.pvd"} <= told
    assert all((folder / name).exists() for name in told)
    export(folder, csv=True, out=tmp_path / "tables")
    assert sorted(path.name for path in (tmp_path / "tables").iterdir()) == ["profiles.csv", "profiles_mean.csv"]
    with pytest.raises(lj.CaseError, match="--vtk, --csv, --pictures and --crate"):
        export(folder)


@pytest.mark.long
def test_notebook_runs(tmp_path, monkeypatch, capsys):
    """Its five cells one after the other, as a person runs them, in a folder of their own."""
    cells = [cell for cell in json.loads(NOTEBOOK.read_text())["cells"] if cell["cell_type"] == "code"]
    assert len(cells) == 6
    monkeypatch.chdir(tmp_path)
    shutil.copytree(INPUTS, "inputs")
    namespace: dict = {}
    for cell in cells[:-1]:
        exec("".join(cell["source"]), namespace)
    monkeypatch.setattr(lj, "sweep", lambda case, folder, members: (case.name, folder, members))  # seconds
    exec("".join(cells[-1]["source"]), namespace)
    assert namespace["starts"] == ("quick_jump", "runs/notebook_starts", 3)
    plt.close("all")
    assert "y2" in capsys.readouterr().out


def test_an_unknown_option_of_run_is_refused(case, tmp_path):
    with pytest.raises(TypeError, match="'forse'"):
        case.run(tmp_path / "run", forse=True)
    assert not list(tmp_path.iterdir())


def test_a_run_takes_the_case_and_its_scene_as_they_are(tmp_path, monkeypatch):
    """A case that is made anew makes its scene anew, which may take as long as a short run."""
    taken = []
    monkeypatch.setattr(lammps_jump.runs.start, "start", lambda case, *given, **named: taken.append(case))
    case = lj.load_case(INPUTS / "energy_box_7.yaml")
    lj.run(case, tmp_path / "run")
    lj.run(case, tmp_path / "run", engine="twin")
    assert taken[0] is case and taken[1].fields.engine.name == "twin"
