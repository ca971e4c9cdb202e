# SPDX-License-Identifier: GPL-2.0-or-later
"""A bundle to cite: every file of a run or study with its checksum, the case, versions and licence."""

import hashlib
import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from made_up import BOX, call

import lammps_jump as lj
from lammps_jump.errors import CaseError, DumpError, SetupError
from lammps_jump.files import CRATE
from lammps_jump.runs.crate import write_crate

pytestmark = pytest.mark.usefixtures("kept_workers")

HERE = Path(__file__).parents[1]
LICENCE = "https://spdx.org/licenses/CC-BY-4.0"


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    folder = tmp_path_factory.mktemp("crate") / "run"
    lj.load_case(BOX, {"run.duration": 0.02, "analysis.figures": "none", "engine.name": "native"}).run(folder)
    return folder


@pytest.fixture
def run(finished, tmp_path):
    return shutil.copytree(finished, tmp_path / "run")


def entities(folder):
    data = json.loads((folder / CRATE).read_text())
    assert data["@context"] == "https://w3id.org/ro/crate/1.1/context"
    return {one["@id"]: one for one in data["@graph"]}


def named(entity):
    """Names that an entity links to."""
    for value in entity.values():
        for one in value if isinstance(value, list) else [value]:
            if isinstance(one, dict):
                yield one["@id"]


def test_every_file_is_in_it_with_its_checksum_and_every_link_leads_somewhere(run):
    (run / "mine.txt").write_text("a file of a person")
    write_crate(run, "CC-BY-4.0")
    found = entities(run)
    files = {name for name, one in found.items() if one["@type"] == "File"}
    assert files == {path.name for path in run.iterdir() if path.name not in (CRATE, "mine.txt", ".lammps-jump")}
    for name in files:
        data = (run / name).read_bytes()
        assert found[name]["sha256"] == hashlib.sha256(data).hexdigest() and int(found[name]["contentSize"]) == len(
            data
        )
    links = {name for one in found.values() for name in named(one)}
    assert links <= found.keys() | {"https://w3id.org/ro/crate/1.1"}
    summary = json.loads((run / "summary.json").read_text())
    assert found["./"]["identifier"] == summary["case_hash"] and found["./"]["license"] == {"@id": LICENCE}
    assert found["#run"]["object"] == [{"@id": "case.yaml"}] and {"@id": "summary.json"} in found["#run"]["result"]
    assert found["#lammps_jump"]["version"] == summary["versions"]["lammps_jump"]


def test_what_is_no_run_no_licence_or_changed_is_refused(run, tmp_path):
    for wrong in ("", "all rights", "CC BY", "x" * 400, "http://a b", "nonsense/../x", "MIT\u0660", "https://a b"):
        with pytest.raises(CaseError, match="--license"):
            write_crate(run, wrong)
    (tmp_path / "empty").mkdir()
    with pytest.raises(DumpError, match="no run and no study"):
        write_crate(tmp_path / "empty", "CC0-1.0")
    (run / "profiles.nc").write_bytes(b"changed")
    with pytest.raises(DumpError, match=r"profiles\.nc"):
        write_crate(run, "CC0-1.0")
    assert not (run / CRATE).exists()


def test_a_file_of_a_person_stays(run, monkeypatch):
    marker = json.loads((run / ".lammps-jump").read_text())
    marker["files"].remove(CRATE)
    (run / ".lammps-jump").write_text(json.dumps(marker))
    (run / CRATE).write_text("mine")
    with pytest.raises(SetupError, match="stands there already"):
        write_crate(run, "CC0-1.0")
    assert (run / CRATE).read_text() == "mine"


def test_the_command_asks_for_a_licence(run, monkeypatch, capsys, tmp_path):
    status, _, told = call(monkeypatch, capsys, "export", run, "--crate")
    assert status == 2 and "--license" in told
    status, _, told = call(monkeypatch, capsys, "export", run, "--crate", "--license", "CC0-1.0", "--out", tmp_path)
    assert status == 2 and "no --out" in told
    status, out, _ = call(monkeypatch, capsys, "export", run, "--crate", "--license", "CC0-1.0")
    assert status == 0 and CRATE in out


@pytest.mark.long
def test_of_a_study_and_by_a_public_validator(run, tmp_path):
    """rocrate-validator misses nothing that RO-Crate 1.1 requires of both, and finds what is taken away."""
    case = lj.load_case(BOX, {"run.duration": 0.02, "engine.name": "native"})
    study = lj.sweep(case, tmp_path / "study", members=2, jobs=1, collect=["energy.max_deviation"])
    write_crate(study.folder, "CC-BY-4.0")
    found = entities(study.folder)
    assert len([name for name in found if name.startswith("runs/") and name.endswith("case.yaml")]) == 2
    assert found["#run"]["object"] == [{"@id": "study.yaml"}]
    write_crate(run, "CC-BY-4.0")
    own = tmp_path / "venv"
    subprocess.run([sys.executable, "-m", "venv", own], check=True)
    subprocess.run([own / "bin" / "pip", "install", "-q", "roc-validator", "rocrate"], check=True)

    def said(folder):
        command = [own / "bin" / "python", HERE / "validate_crate.py", folder]
        return subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()

    assert said(run) == said(study.folder) == ["0 issues"]
    whole = json.loads((run / CRATE).read_text())
    whole["@graph"] = [one for one in whole["@graph"] if one["@id"] != "./"]
    (run / CRATE).write_text(json.dumps(whole))
    assert said(run) != ["0 issues"]
