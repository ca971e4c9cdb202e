# SPDX-License-Identifier: GPL-2.0-or-later
"""What people type by habit from pandas, xarray, MDAnalysis and pathlib: it works, or the error names what to type."""

from __future__ import annotations

import re
import webbrowser

import numpy as np
import pytest
from made_up import INPUTS

import lammps_jump as lj

pytestmark = pytest.mark.usefixtures("blank_pictures", "kept_workers")

SHORT = {"run.duration": 0.3, "run.output_interval": 0.05, "engine.name": "native", "analysis.window": [0.1, 0.3]}


@pytest.fixture(scope="module")
def case():
    return lj.load_case(INPUTS / "quick_jump.yaml", SHORT)


@pytest.fixture(scope="module")
def run(case, tmp_path_factory):
    return case.run(tmp_path_factory.mktemp("habit") / "run")


@pytest.fixture(scope="module")
def study(case, tmp_path_factory):
    folder = tmp_path_factory.mktemp("habit") / "study"
    return lj.sweep(case, folder, axes={"contact.restitution": [0.2, 0.4]}, collect=["force.sill.mean_fx"], jobs=1)


def test_frames_are_a_sequence(run):
    frames = run.frames
    every = list(frames)
    assert len(frames) == len(every) == len(run.times) == 7
    assert np.allclose(run.times, np.arange(7) * 0.05, atol=run.scene.time_step)  # a frame falls on a whole step
    assert [frames[k].step for k in (0, 3, -1)] == [every[k].step for k in (0, 3, -1)]
    assert [one.step for one in frames[1:5:2]] == [every[1].step, every[3].step]
    assert [one.step for one in frames(1, 5, 2)] == [every[1].step, every[3].step]
    assert [frames.at(time).step for time in (0.0, 0.12, 0.13, 0.3)] == [every[k].step for k in (0, 2, 3, 6)]
    with pytest.raises(lj.DumpError, match=r"time 9.0 s; its frames are from 0 to 0\.3"):
        frames.at(9.0)
    with pytest.raises(IndexError, match="holds 7 frames"):
        frames[7]


def test_a_frame_is_a_table_and_an_array(run):
    frame = run.frames[-1]
    table = frame.to_dataframe()
    assert table.index.tolist() == frame.ids.tolist() and table["x"].tolist() == frame.x.tolist()
    assert frame.to_numpy("x", "vy").tolist() == np.column_stack([frame.x, frame.vy]).tolist()
    assert frame.to_numpy().shape == (frame.n, len(frame.columns))


def test_all_frames_as_one_dataset(run):
    whole = run.to_xarray()
    for row, frame in enumerate(run.frames):
        here = whole.isel(time=row).dropna("disc", subset=["x"])
        order = np.argsort(frame.ids)
        assert here.disc.values.tolist() == frame.ids[order].tolist()
        assert here.x.values.tolist() == frame.x[order].tolist() and here.vy.values.tolist() == frame.vy[order].tolist()
    assert whole.time.values.tolist() == run.times.tolist() and whole.x.attrs["units"] == "m"


def test_values_of_a_case(case):
    assert case.run.duration == case["run.duration"] == 0.3
    assert case.discs.diameter == case["discs.diameter"] == case.fields.discs.diameter
    assert case["walls.sill.y"] == list(next(wall for wall in case.walls if wall.name == "sill").y)
    others = [case.set("run.duration", 2), case | {"run.duration": 2}, case.set({"run.duration": 2})]
    others.append(lj.load_case(INPUTS / "quick_jump.yaml", SHORT, run={"duration": 2}))
    assert {one.run.duration for one in others} == {2.0} and len({one.hash for one in others}) == 1
    assert type(others[1]) is lj.Case
    assert case.run.duration == 0.3 and "duration" in dir(case.run) and "contact" in dir(case)


@pytest.mark.parametrize(
    "words, error, hint",
    [
        ("run.frame", AttributeError, "did you mean 'frames'?"),
        ("run.frames.time", AttributeError, "did you mean 'times'?"),
        ("run.frames[0].radii_", AttributeError, "did you mean 'radii'?"),
        ("run.heep", AttributeError, "did you mean 'heap'?"),
        ("case.run.durration", AttributeError, "did you mean 'duration'?"),
        ("case.disc", AttributeError, "did you mean 'discs'?"),
        ("study.tabel", AttributeError, "did you mean 'table'?"),
        ("case['duration']", lj.CaseError, "did you mean 'run.duration'?"),
        ("case['run.durration']", lj.CaseError, "did you mean 'duration'?"),
        ("case['walls.sil.y']", lj.CaseError, "names there: "),
        ("case['slope.x']", lj.CaseError, "is a single value"),
        ("lj.load_case(case.source.file, duration=2)", lj.CaseError, "write run={'duration': 2}"),
        ("lj.load_case(case.source.file, colour=2)", lj.CaseError, "use one of "),
        ("lj.open_run(study.path)", lj.CaseError, "lammps_jump.open("),
        ("lj.open('nowhere')", lj.CaseError, "no such file or folder"),
        ("lj.Sweep(run.path)", lj.CaseError, "lammps-jump sweep"),
        ("run.plot('colour')", lj.DumpError, "use one of depth_profile"),
        ("study.plot('colour')", lj.DumpError, "there are sweep_contact.restitution"),
    ],
)
def test_a_miss_names_what_to_type(run, case, study, words, error, hint):
    with pytest.raises(error) as caught:
        eval(words, {"lj": lj, "run": run, "case": case, "study": study})
    assert hint in str(caught.value)


HABITUAL = {lj.Run: "run", lj.Frame: "frame", lj.Frames: "frames", lj.Case: "case", lj.Sweep: "study"}


@pytest.mark.parametrize("kind", HABITUAL, ids=HABITUAL.get)
def test_what_is_to_be_written_for_a_habit_is_there(run, case, study, kind):
    """Names of the hints exist, and those that they stand for do not."""
    objects = {"run": run, "frame": run.frames[-1], "frames": run.frames, "case": case, "study": study}
    one = objects[HABITUAL[kind]]
    for name, hint in kind.habits.items():
        assert name == "[]" or name not in dir(one)
        for owner, part in re.findall(r"\b(run|frames?|case|study)\.([a-z_]+)", hint):
            assert part in dir(objects[owner]), hint
        with pytest.raises((AttributeError, TypeError), match=re.escape(hint)):
            one["x"] if name == "[]" else getattr(one, name)


@pytest.mark.parametrize("name", lj._HABITS)
def test_what_is_to_be_written_for_a_habit_of_the_package_is_there(name):
    with pytest.raises(AttributeError, match=f"no '{name}'; write") as caught:
        getattr(lj, name)
    named = re.findall(r"\b(?:lammps_jump\.)?(open|load_case|read_dump)\(", str(caught.value))
    assert all(hasattr(lj, one) for one in named) and name not in dir(lj)
    with pytest.raises(AttributeError, match="did you mean 'load_case'"):
        lj.load_cas  # noqa: B018


@pytest.mark.parametrize(
    ("words", "hint"),
    [
        ("lj.Case('my.yaml')", "write load_case('my.yaml')"),
        ("lj.run('my.yaml')", "write load_case('my.yaml').run()"),
        ("run.plot(ax=None)", "run.plot has no ax"),
        ("[one for one in study]", "study.runs"),
    ],
)
def test_calls_by_habit_are_answered(run, study, words, hint):
    with pytest.raises(TypeError, match=re.escape(hint)):
        eval(words, {"lj": lj, "run": run, "study": study})


def test_open_tells_what_a_path_is(run, case, study):
    assert type(lj.open(run.path)) is lj.Run and lj.open(str(run.path)).status == "complete"
    assert type(lj.open(study.path)) is lj.Sweep and lj.Sweep(study.path).status() == study.status()
    assert lj.open(INPUTS / "quick_jump.yaml").name == case.name
    assert len(lj.open(run.path / "dump.lammpstrj")) == len(run.frames)


def test_figures_by_name(run, study):
    drawn = (run.plot(), run.figure(), run.plot("depth_m"))
    labels = [[panel.get_ylabel() for panel in figure.axes] for figure in drawn]
    assert labels[0] == labels[1] != labels[2]
    assert len(study.plot().axes) == 1 and study.plot("restitution").axes[0].get_xlabel().startswith("restitution")


def test_show_opens_the_page(run, study, monkeypatch):
    opened = []
    monkeypatch.setattr(webbrowser, "open", opened.append)
    run.show(), study.show()
    assert opened == [(run.path / "report.html").as_uri(), (study.path / "sweep.html").as_uri()]


@pytest.mark.parametrize("what", ["run", "case", "study", "run.frames", "run.frames[-1]"])
def test_a_notebook_shows_each(run, case, study, what):
    assert "<" in eval(what, {"run": run, "case": case, "study": study})._repr_html_()


def test_what_a_property_lacks_is_said_itself(run, study, monkeypatch):
    """An AttributeError inside a property would else read as if the name were not there."""
    monkeypatch.setattr(lj.Run, "times", property(lambda self: self.summary.colour))
    monkeypatch.setattr(type(study), "runs", property(lambda self: self.folder.colour))
    for one, name in ((run, "times"), (study, "runs")):
        with pytest.raises(AttributeError, match="colour"):
            getattr(one, name)


def test_a_study_that_was_read_needs_its_folder(study):
    with pytest.raises(TypeError, match="needs the folder of its runs"):
        lj.Sweep(study.study)


def test_a_result_is_shown_by_its_numbers_and_not_by_its_tables(run):
    """A prompt shows what is typed there: columns of a record would be thousands of lines."""
    assert len(repr(run.forces["sill"])) < 3000 and "mean_fx=" in repr(run.forces["sill"])
    assert len(repr(run.jump)) < 20_000
