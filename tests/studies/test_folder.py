# SPDX-License-Identifier: GPL-2.0-or-later
"""Folders of studies: marked as ours, and nothing of a person's is replaced in one that is not."""

import json

import pytest
from made_up import INPUTS, call, files

from lammps_jump.errors import SetupError
from lammps_jump.files import STUDY_FILES, study_files
from lammps_jump.folders import locked, read_marker
from lammps_jump.studies.points import held_folder

COMMANDS = sorted({*STUDY_FILES, "fluid", "sensitivity", "stress"})
OF_A_CASE = {"bench", "fluid", "cross-validate"}
OF_A_NUMBER = [INPUTS / "quick_jump.yaml", "--of", "jump.y2"]
OF_A_SEARCH = [INPUTS / "quick_jump.yaml", "--vary", "walls.sill.y.1=0.5:1.5", "--until", "jump.y2 >= 3"]
OF_A_STUDY = {"calibrate": [INPUTS.parent / "validation" / "calibrate" / "like_water.yaml"]}


def standing_names(command):
    return [name.replace("*", "one") for name in study_files(command)]


@pytest.mark.parametrize(
    "command", [name if name in ("bench", "fluid") else pytest.param(name, marks=pytest.mark.long) for name in COMMANDS]
)
def test_a_study_starts_in_no_folder_with_files_of_a_person(command, tmp_path, monkeypatch, capsys):
    given = [INPUTS / "quick_jump.yaml"] if command in OF_A_CASE else OF_A_STUDY.get(command, [])
    given = {"budget": OF_A_NUMBER, "find": OF_A_SEARCH}.get(command, given)
    words = [command, *given, "--out", tmp_path / "out"]
    (tmp_path / "out" / "figures").mkdir(parents=True)
    for name in standing_names(command):
        own = tmp_path / "out" / name
        own.write_text('{"mine": 1}')
        status, _, told = call(monkeypatch, capsys, *words)
        assert status == 2 and "was not made by lammps-jump" in told and name in told and "--out" in told
        assert own.read_text() == '{"mine": 1}' and files(tmp_path) == {str(own): b'{"mine": 1}'}
        own.unlink()


@pytest.mark.parametrize("command", [name for name in COMMANDS if name not in (*OF_A_STUDY, "find")])
def test_results_of_before_are_gone_on_with(command, tmp_path):
    """Studies had no marker at first, save `find`; the names of another study of ours are not theirs."""
    told = {"fluid": {"zones": {}}, "cross-validate": {"disc_by_disc": []}}.get(command, {"pieces": {}})
    (tmp_path / study_files(command)[0]).write_text(json.dumps(told))
    for _ in range(2):
        with held_folder(tmp_path, command):
            assert read_marker(tmp_path).kind == command
    other = "stress" if command != "stress" else "bench"
    with pytest.raises(SetupError, match=f"holds what `lammps-jump {command}` has made"), held_folder(tmp_path, other):
        pass


def test_one_study_at_a_time_and_no_empty_folder(tmp_path):
    with pytest.raises(ZeroDivisionError), held_folder(tmp_path / "a" / "new", "stress"):
        raise ZeroDivisionError
    assert not (tmp_path / "a" / "new").exists()
    with held_folder(tmp_path / "new", "stress") as folder:
        (folder / "stress.json").write_text("{}")
    assert {path.name for path in folder.iterdir()} == {".lammps-jump", "stress.json"}
    with locked(folder), pytest.raises(SetupError, match="writes to this folder"), held_folder(folder, "stress"):
        pass
