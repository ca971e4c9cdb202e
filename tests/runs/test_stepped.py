# SPDX-License-Identifier: GPL-2.0-or-later
"""A run that Python steps leaves what one command leaves; changes stand in its case, which repeats it to the bit."""

from __future__ import annotations

import filecmp

import numpy as np
import pytest
from made_up import INPUTS

import lammps_jump as lj
from lammps_jump.engines.checkpoint import read_checkpoint
from lammps_jump.identity import scene_key
from lammps_jump.physics.inlet import Hydrograph

pytestmark = pytest.mark.usefixtures("blank_pictures")

SHORT = {
    "run.duration": 0.3, "run.output_interval": 0.05, "engine.name": "native", "analysis.window": [0.1, 0.3],
    "probes.interval": 0.025,
}  # fmt: skip
FILES = ("dump.lammpstrj", "forces.csv")


@pytest.fixture(scope="module")
def case():
    return lj.load_case(INPUTS / "quick_jump.yaml", SHORT)


def same(one, other):
    return all(filecmp.cmp(one / name, other / name, shallow=False) for name in FILES)


def test_without_a_change_it_is_the_run_of_the_command(case, tmp_path):
    with case.start(tmp_path / "steps") as run:
        while run.time < 0.3 - 1e-9:
            run.advance(0.07)  # from no frame to no frame
    whole = case.run(tmp_path / "whole")
    assert same(tmp_path / "steps", whole.folder)
    assert lj.open(tmp_path / "steps").status == "complete"
    assert lj.open(tmp_path / "steps").jump.y2 == whole.jump.y2


def test_changes_stand_in_the_case_and_repeat_the_run(case, tmp_path):
    folder = tmp_path / "steps"
    case = case | {"inflow": {"kind": "rows", "table": [[0, 0.6, 10.0]]}}
    with case.start(folder, moves=["sill"]) as run:
        run.advance(0.1)
        low, high = run.walls["sill"].y
        run.set("walls.sill.y", [low + 0.2, high + 0.2], over=0.05)
        run.set("inflow.mean_speed", 9.0, over=0.02)
        run.advance(to=0.2)
        assert run.walls["sill"].y == pytest.approx((low + 0.2, high + 0.2), abs=1e-12)
        assert run.walls["sill"].x == (22.0, 22.6)
        run.walls["sill"].move(x=-0.05, y=-0.1, angle=3.0, over=0.03)
        run.set("inflow.depth", 0.5)
        assert run.discs.n == len(run.discs.x) and set(run.energy) == {"kinetic", "gravitational", "elastic"}
    stopped = lj.open(folder)
    assert stopped.status == "interrupted" and "--resume" in stopped.result.message
    with stopped.case.start(folder, resume=True) as run:
        assert run.time == pytest.approx(0.2, abs=case.scene().time_step)
        run.advance(to=1.0)  # not beyond the end
        assert run.walls["sill"].angle == pytest.approx(3.0)
        with pytest.raises(lj.RunError, match="is at its end"):
            run.advance(0.1)
    changed = lj.open(folder)
    again = changed.case.run(tmp_path / "again")
    assert changed.status == "complete" and same(folder, again.folder)
    assert not same(folder, case.run(tmp_path / "unchanged").folder)
    inflow = changed.case.fields.inflow.hydrograph
    assert isinstance(inflow, Hydrograph) and (inflow.depths[-1], inflow.speeds[-1]) == (0.5, 9.0)


REFUSED = {
    "so fast that outlets look more often": (lambda run: run.walls["sill"].move(x=-12, over=0.05), "slower change"),
    "contact.friction of the whole run": (lambda run: run.set("contact.friction", 0.2), "belongs to the whole run"),
    "the past of a wall": (
        lambda run: run.set("walls.sill.motion.points", [[0.02, 0, 1, 0]]),
        "would change where wall 'sill' has been",
    ),
    "another wall": (lambda run: run.set("walls.sill.x", [22.0, 22.7], over=1), r"0\.7 m long; allowed is .* 0\.6 m"),
    "a wall at once": (lambda run: run.set("walls.sill.y", [-4, 2]), "give over="),
    "a wall that stands": (lambda run: run.walls["floor"].move(y=1, over=1), r"moves=\['floor'\]"),
    "no such wall": (lambda run: run.set("walls.sil.y", [0, 1], over=1), "did you mean 'sill'"),
    "a time that is none": (lambda run: run.walls["sill"].move(y=0.1, over=0.0), "a time above 0"),
    "not a number": (lambda run: run.walls["sill"].move(y=float("nan"), over=1.0), "allowed is a number"),
    "an inflow that is no table": (lambda run: run.set("inflow.depth", 1.0), "inflow.table"),
    "backwards": (lambda run: run.advance(-1.0), "above 0"),
    "to the past": (lambda run: run.advance(to=0.01), "a time behind"),
    "two of three": (lambda run: run.advance(1.0, steps=3), "one of duration"),
    "none of three": (lambda run: run.advance(), "one of duration"),
    "half a step": (lambda run: run.advance(steps=1.5), "whole number"),
    "for ever": (lambda run: run.advance(float("inf")), "allowed is a number"),
}


def test_a_wall_on_its_way_is_not_moved_again(case, tmp_path):
    with case.start(tmp_path / "run", moves=["sill"]) as run:
        run.walls["sill"].move(y=0.1, over=0.1)
        with pytest.raises(lj.CaseError, match="moves until"):
            run.walls["sill"].move(y=0.1, over=0.1)


@pytest.fixture(scope="module")
def begun(case, tmp_path_factory):
    with case.start(tmp_path_factory.mktemp("steps") / "run", moves=["sill"]) as run:
        run.advance(0.05)
        yield run


@pytest.mark.parametrize("what", REFUSED)
def test_what_cannot_be_is_refused_and_changes_nothing(begun, what):
    act, words = REFUSED[what]
    step = begun.step
    with pytest.raises(lj.CaseError, match=words):
        act(begun)
    assert begun.step == step
    with pytest.raises(KeyError, match="did you mean 'sill'"):
        begun.walls["sil"]
    with pytest.raises(AttributeError, match="did you mean 'advance'"):
        _ = begun.advanced


def test_a_change_leaves_a_checkpoint_of_the_changed_case(case, tmp_path):
    """A process that is killed behind a change goes on with it, at the step of an earlier stop too."""
    folder = tmp_path / "run"
    with case.start(folder, moves=["sill"]) as run:
        run.advance(0.1)
    with lj.open(folder).case.start(folder, resume=True) as run:
        run.walls["sill"].move(y=0.2, over=0.05)
        found, changed = read_checkpoint(folder), lj.load_case(folder / "case.yaml")
        assert found.step == run.step and found.scene == scene_key(changed.scene())


def test_an_error_in_the_block_leaves_a_checkpoint(case, tmp_path):
    with pytest.raises(ZeroDivisionError), case.start(tmp_path / "run") as run:
        run.advance(0.1)
        raise ZeroDivisionError
    with pytest.raises(lj.RunError, match="inside its block"):
        run.advance(0.1)
    assert lj.open(tmp_path / "run").status == "interrupted"
    with pytest.raises(lj.SetupError, match="was interrupted"):
        case.start(tmp_path / "run").__enter__()
    with case.start(tmp_path / "run", force=True) as run:
        assert run.step == 0 and np.isfinite(run.discs.x).all()


def test_a_guard_that_ends_the_run_is_told(case, tmp_path):
    through = {"kind": "table", "points": [[0.1, 0, 0, 0], [0.15, -12, 0, 0]]}  # into the discs, at 240 m/s
    case = case.set("walls.sill.motion", through)
    with pytest.raises(lj.RunError, match="beyond the limit"), case.start(tmp_path / "run") as run:
        run.advance(0.2)
    assert lj.open(tmp_path / "run").status == "failed"
