# SPDX-License-Identifier: GPL-2.0-or-later
"""The page of a study: its table as it fills, whoever runs it, and a page for each run."""

import pytest
from made_up import STUDY
from serving import asked, send, serving

from lammps_jump.errors import CaseError
from lammps_jump.served import pages_of
from lammps_jump.sweeps import Sweep, held_study, prepare, read_study

pytestmark = pytest.mark.usefixtures("blank_pictures")


def test_a_study_fills(tmp_path):
    study = {**STUDY, "axes": {"contact.restitution": [0.5, 0.8]}, "members": 1, "set": {"run.duration": 0.5}}
    found = Sweep(read_study({**study, "collect": ["energy.final"]}), tmp_path / "out")
    with held_study(found.folder):
        prepare(found)
    before = {*found.folder.rglob("*")}
    with serving(found.folder) as server:
        assert server.address.endswith(f"{server.token}/")
        page = send(server, "GET", f"/{server.token}/")[2].decode()
        assert 'id="sliders"' in page and 'src="study.js"' in page
        state = asked(server, "state")
        assert [run["stage"] for run in state["runs"]] == ["waiting", "waiting"] and state["rows"] == []
        assert state["axes"] == [
            {
                "name": "restitution coefficient",
                "values": [0.5, 0.8],
                "label": "restitution coefficient",
                "shown": ["0.5", "0.8"],
            }
        ]
        assert [run["place"] for run in state["runs"]] == [[0.5], [0.8]] and "2 waiting" in state["status"]
        assert asked(server, "run/0/state")["status"] == "none"
        first, _ = found.members
        assert {*found.folder.rglob("*")} == before  # looking writes nothing
        first.case.run(first.folder(found.folder))
        state = asked(server, "state")
        assert [run["stage"] for run in state["runs"]] == ["done", "waiting"]
        assert len(state["rows"]) == 2 and "n = 1" in str(state["rows"][0]) and "n = 0" in str(state["rows"][1])
        run = asked(server, f"run/{state['runs'][0]['number']}/state")
        assert run["status"] == "complete" and run["frames"] > 1


def test_what_is_no_study_is_refused(tmp_path):
    (tmp_path / "study.yaml").write_text("case: nowhere.yaml\n")
    with pytest.raises(CaseError, match="no such case file"):
        pages_of(tmp_path)
