# SPDX-License-Identifier: GPL-2.0-or-later
"""Starts of a study that reads their runs itself: each run once, in a folder under its key."""

import json
import shutil

import pytest
from made_up import BOX, INPUTS, STUDY, call, files

import lammps_jump as lj
import lammps_jump.sweeps.study_folder as on_disk
from lammps_jump.engines.child import Child
from lammps_jump.sweeps import Pool, Start, Sweep, held_study, members, open_sweep, prepare, read_study, run_starts
from lammps_jump.sweeps.members import run_member, state_of

pytestmark = pytest.mark.usefixtures("blank_pictures", "kept_workers")


@pytest.fixture(scope="module")
def pool():
    with Pool(1) as pool:
        yield pool


def test_equal_starts_of_two_points_are_one_run(tmp_path, pool):
    said, starts = [], [Start(0, {}, 1), Start(1, {}, 1), Start(2, {}, 2)]
    found = run_starts(lj.load_case(BOX), starts, tmp_path, pool, said=said.append)
    assert [one.start for one in found] == starts and all(one.summary for one in found)
    assert found[0].folder == found[1].folder != found[2].folder and len(said) == 2


def test_what_is_there_is_run_again_only_where_that_is_asked_for(tmp_path, pool):
    case, said = lj.load_case(BOX), []
    # the fast disc leaves the domain through a box that is wider
    starts = [
        Start(0, {}, 1),
        Start(1, {"walls.box.x": [0, 20], "run.duration": 1}, 1),
        Start(2, {"run.duration": -1}, 1),
    ]
    first = run_starts(case, starts, tmp_path, pool, said=said.append)
    assert [bool(one.summary) for one in first] == [True, False, False]
    assert "domain" in first[1].message and "run.duration" in first[2].message and len(said) == 2
    assert run_starts(case, starts, tmp_path, pool, said=said.append) == first and len(said) == 2
    again = run_starts(case, starts, tmp_path, pool, fresh=True, said=said.append)
    assert len(said) == 4 and [one.message for one in again] == [one.message for one in first]


def test_a_run_that_another_study_describes_is_shared_and_one_that_is_analysed_otherwise_is_made_again(tmp_path, pool):
    case, said = lj.load_case(BOX), []
    base, same = {"contact.restitution": case.fields.contact.restitution}, {"run.duration": case.fields.run.duration}
    (first,) = run_starts(case, [Start(0, base, 1)], tmp_path, pool, said=said.append)
    (second,) = run_starts(case, [Start(0, same, 1)], tmp_path, pool, said=said.append)
    assert second.summary == first.summary and second.folder == first.folder and len(said) == 1
    assert not (first.folder / "dump.lammpstrj").exists()
    (third,) = run_starts(
        case.replace({"analysis.bin_width": 0.5}), [Start(0, base, 1)], tmp_path, pool, said=said.append
    )
    assert not third.message and third.summary["key"] == first.summary["key"] and len(said) == 2


@pytest.mark.long
def test_the_setting_of_a_point_is_chosen_once(monkeypatch):
    chosen = []
    real = members.choose_setting
    monkeypatch.setattr(members, "choose_setting", lambda case: chosen.append(case.fields.run.seed) or real(case))
    starts = [Start(point, {"contact.friction": 0.1 * point}, seed) for point in range(2) for seed in (3, 4, 5)]
    found = members.plan(lj.load_case(BOX), starts, {})
    assert chosen == [3, 3] and len({member.key for member in found}) == len(starts)
    alone = [members.plan(lj.load_case(BOX), [start], {})[0].key for start in starts]
    assert [member.key for member in found] == alone


SMALL = {**STUDY, "axes": {}, "members": 1}


@pytest.fixture
def prepared(tmp_path):
    """A study of one member that is written and not run."""
    found = Sweep(read_study(SMALL), tmp_path / "out")
    with held_study(found.folder):
        prepare(found)
    return found


@pytest.fixture(scope="module")
def other_run(tmp_path_factory):
    """A run of a user, which is no member of the study."""
    return lj.load_case(BOX, {"run.duration": 0.1}).run(tmp_path_factory.mktemp("mine") / "run").folder


ONE = {"point": 0, "seed": 1, "key": "a"}


@pytest.mark.parametrize(
    ("listed", "said"),
    [
        ({"members": [{**ONE, "point": 5}]}, "point 5; the points are 0 to 0"),
        ({"members": [{**ONE, "point": -1}]}, "members.0.point"),
        ({"members": [{**ONE, "seed": "1" * 100_000}]}, "members.0.seed"),
        ({"members": [{**ONE, "seed": seed} for seed in range(20_000)]}, "at most 1000 are allowed"),
        ({"members": 3}, "members"),
        ({"points": [3]}, "points.0"),
        ([], "valid dictionary"),
    ],
)
@pytest.mark.fault("values in JSON files")
def test_the_list_of_members_is_checked(tmp_path, monkeypatch, capsys, listed, said):
    study = {**SMALL, "until": {"force.box.impulse_x": "40%"}}
    found = Sweep(read_study(study), tmp_path / "out")
    with held_study(found.folder):
        prepare(found)
    path = found.folder / "points.json"
    stored = json.loads(path.read_text())
    path.write_text(json.dumps({**stored, **listed} if isinstance(listed, dict) else listed))
    for words in (["--status"], ["--member", "0"], []):
        status, _, shown = call(monkeypatch, capsys, "sweep", found.folder, "--jobs", 1, *words)
        assert status == 2 and f"{path}: " in shown and said in shown and "delete the file" in shown
        assert len(shown.strip().splitlines()) == 1 and len(shown) < 600


@pytest.mark.parametrize("linked", ["member", "runs"])
@pytest.mark.fault("folders")
def test_a_link_to_another_run_is_no_member(prepared, other_run, tmp_path, monkeypatch, capsys, linked):
    (member,) = prepared.members
    mine = shutil.copytree(other_run, tmp_path / "mine" / member.key)
    place = member.folder(prepared.folder) if linked == "member" else prepared.folder / "runs"
    place.parent.mkdir(exist_ok=True)
    place.symlink_to(mine if linked == "member" else mine.parent)
    before = files(tmp_path)
    for words in ([], ["--retry"], ["--member", "0"]):
        status, _, said = call(monkeypatch, capsys, "sweep", prepared.folder, "--jobs", 1, *words)
        assert status in (1, 2) and f"{place}: is a link to another place" in said
        assert files(tmp_path) == before


@pytest.mark.parametrize("status", ["complete", "failed"])
@pytest.mark.fault("folders")
def test_another_run_in_the_place_of_a_member_stays(prepared, other_run, tmp_path, status):
    (member,) = prepared.members
    folder = member.folder(prepared.folder)
    shutil.copytree(other_run, folder)
    summary = folder / "summary.json"
    summary.write_text(summary.read_text().replace('"status": "complete"', f'"status": "{status}"'))
    before = files(tmp_path)
    assert state_of(member, prepared.folder).stage == "interrupted"
    for again in (False, True):
        with pytest.raises(lj.SetupError, match="holds another run"):
            run_member(member, prepared.folder, again, True)
    assert files(tmp_path) == before


@pytest.mark.long  # engines that are killed: engines/test_child.py and faults/test_killed.py
@pytest.mark.fault("killed")
def test_a_member_whose_engine_is_killed_is_run_by_the_same_command(prepared, monkeypatch):
    (member,), real = prepared.members, Child.run

    def killed(self, *arguments):
        self.process.kill()
        self.process.wait()
        return real(self, *arguments)

    with monkeypatch.context() as patch:
        patch.setattr(Child, "run", killed)
        with pytest.raises(lj.RunError, match="--resume` starts it again"):
            run_member(member, prepared.folder, False, True)
    assert [state.stage for state in open_sweep(prepared.folder).states.values()] == ["waiting"]
    run_member(member, prepared.folder, False, True)
    assert state_of(member, prepared.folder).stage == "done"


def test_the_status_makes_only_the_members_that_have_a_folder(tmp_path, monkeypatch):
    """Each takes milliseconds: the status of 99,999 runs took minutes."""
    found = Sweep(read_study({**STUDY, "axes": {"analysis.bin_width": [0.5, 1.0]}, "members": 2}), tmp_path / "out")
    with held_study(found.folder):
        prepare(found)
    planned, real = [], members.plan
    monkeypatch.setattr(on_disk, "plan", lambda case, starts, rest: planned.extend(starts) or real(case, starts, rest))
    assert open_sweep(found.folder).status() == "4 runs at 2 points: 4 waiting" and planned == []
    run_member(found.members[2], found.folder, False, True)
    assert open_sweep(found.folder).status() == "4 runs at 2 points: 1 done, 3 waiting" and planned == [found.starts[2]]
    (found.folder / "points.json").unlink()
    planned.clear()
    assert open_sweep(found.folder).status() == "4 runs at 2 points: 1 done, 3 waiting" and len(planned) == 4
    monkeypatch.setattr(on_disk, "MOST_UNLISTED", 3)
    with pytest.raises(lj.CaseError, match="does not list these 4 runs"):
        open_sweep(found.folder).status()


@pytest.mark.long
def test_one_run_fixes_a_gauge_for_a_second_or_so(tmp_path):
    """Discs 1e-12 d apart at the start: after 0.75 s of `dam_break` 0.01 d, and 1 % of the depth at x = 5 m by 1 s."""
    depths = []
    for name, shift in (("one", 0.0), ("other", 2e-13)):
        case = lj.load_case(INPUTS / "dam_break.yaml", {"engine.name": "native", "run.duration": 1.5})
        case = case.set({"analysis.figures": "none", "initial.0.x": [shift, case.fields.initial[0].x[1] + shift]})
        profiles = case.run(tmp_path / name).profiles
        depths.append(profiles.mass_depth.sel(x=5.0, method="nearest"))
    off = abs(depths[0] - depths[1]) / depths[0].mean()
    assert float(off.sel(time=slice(0, 0.4)).max()) < 1e-6 < 0.01 < float(off.sel(time=slice(0.9, 1.5)).max())
