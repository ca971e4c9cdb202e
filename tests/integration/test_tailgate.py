# SPDX-License-Identifier: GPL-2.0-or-later
"""A tailgate that holds a flow, from the case to its height: a small channel, and what is refused or cannot be held."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_up import engine_setting

from lammps_jump.analysis.devices import tailgate
from lammps_jump.analysis.draw.preview import scene_drawing
from lammps_jump.analysis.flow import from_scene
from lammps_jump.analysis.passes import Gathered
from lammps_jump.case import load_case
from lammps_jump.dump.read import open_dump
from lammps_jump.dump.walls import PoseFile
from lammps_jump.engines import choice
from lammps_jump.engines.launch import run
from lammps_jump.engines.native.simulation import NativeSimulation
from lammps_jump.engines.native.state import load_state, save_state
from lammps_jump.errors import CaseError, SetupError
from lammps_jump.files import POSES
from lammps_jump.scene.tracks import Held

SMALL = {
    "name": "small",
    "gravity": 9.81,
    "discs": {"diameter": 0.2, "density": 1000, "sizes": {"kind": "uniform", "spread": 0.2}},
    "contact": {"restitution": 0.2, "friction": 0, "largest_overlap": 0.1, "impact_speed": 8},
    "domain": {"x": [-1, 16], "y": [-8, 10]},
    "walls": [
        {"name": "floor", "kind": "block", "x": [-5, 10.2], "y": [-5, 0]},
        {"name": "sill", "kind": "block", "x": [10, 10.6], "y": [-5, 0.6],
         "motion": {"kind": "hold", "front": 4, "speed": 0.3, "range": [-0.6, 2]}},
    ],
    "initial": [
        {"kind": "column", "x": [0.2, 4], "y": [0, 0.6], "velocity": [8, 0], "hydrostatic": False},
        {"kind": "column", "x": [4, 10], "y": [0, 2.4], "velocity": [2, 0], "hydrostatic": False},
    ],
    "inflow": {"kind": "rows", "depth": 0.6, "mean_speed": 8},
    "outflow": [{"x_beyond": 13}, {"y_below": -1}],
    "run": {"duration": 0.4, "time_step_fraction": 0.1, "output_interval": 0.1},
}  # fmt: skip
SETS = {
    "front outside": ("walls.sill.motion.front=99", "99 m is outside the channel before the gate; allowed is 0 to 10"),
    "front behind": ("walls.sill.motion.front=12", "12 m is outside the channel before the gate; allowed is 0 to 10"),
    "front at the gate": ("walls.sill.motion.front=10", "10 m is outside the channel before the gate"),
    "range empty": ("walls.sill.motion.range=[1, 1]", "range: [1, 1] is no way from where the case has the wall"),
    "range beside": ("walls.sill.motion.range=[1, 2]", "low <= 0 <= high"),
    "both": ("walls.sill.motion.depth=2", "one of the two"),
    "no inflow": ("inflow=null", "a front needs an inflow of rows"),
    "no gravity": ("gravity=0", "this case has none"),
    "until": ("walls.sill.motion.until=3", "it stands until from"),
}  # fmt: skip


def holding(scene):
    return next(one.motion.holding for one in scene.walls if one.motion.holding)


@pytest.mark.parametrize(("change", "text"), SETS.values(), ids=SETS)
def test_what_cannot_be_held_is_one_sentence(change, text):
    with pytest.raises(CaseError) as error:
        load_case(SMALL, [change]).scene()
    assert text in str(error.value)


def test_the_preview_draws_the_range_of_a_gate():
    shapes = scene_drawing(load_case(SMALL).scene(), []).shapes
    ghosts = np.concatenate([shape.rings[0] for shape in shapes if shape.look == "ghost"])
    assert (ghosts[:, 0].min(), ghosts[:, 0].max()) == (10.0, 10.6)
    assert ghosts[:, 1].max() == pytest.approx(0.6 + 2.0)


def test_what_is_held_by_a_frozen_flow_has_no_interval():
    flow, time = from_scene(load_case(SMALL).scene()), np.linspace(0.1, 10.0, 80)
    still, swings = 4.0 + 0.0 * time, 4.0 + 0.01 * np.sin(7.0 * time)
    for seen, is_known in ((still, False), (swings, True)):
        record = tailgate.Record(time, 0.6 + 0.0 * time, seen, 0.0 * time)
        found = tailgate.analyse(Gathered(flow, None, None, {"tailgate": {"sill": record}}, {}))["sill"]
        assert found.held == pytest.approx(4.0, abs=1e-3) and np.isnan(found.height_interval)
        assert np.isfinite(found.held_interval) == is_known == (found.no_interval is None)


def test_the_depth_lies_before_the_gate():
    held = {"kind": "hold", "depth": 2, "at": 9.5, "speed": 0.3, "range": [-0.6, 2]}
    case = {**SMALL, "walls": [SMALL["walls"][0], {**SMALL["walls"][1], "motion": held}]}
    with pytest.raises(CaseError, match=r"at: 9.5 m is outside the channel before the gate; allowed is 1 to 9 m"):
        load_case(case).scene()
    found = holding(load_case(case, ["walls.sill.motion.at=8"]).scene())
    assert (found.low, found.high, found.bins, found.level, found.proportional) == (7.0, 9.0, 1, 0.0, 0.0)


def test_the_response_is_the_travel_of_a_wave_there_and_back():
    """From the front to the gate: 6 m under the sequent depth."""
    scene = load_case(SMALL).scene()
    found = holding(scene)
    assert found.every * scene.time_step * 20 == pytest.approx(2.89, rel=0.05)  # 1 look in 60 steps
    slower = holding(load_case(SMALL, ["walls.sill.motion.response=10"]).scene())
    assert slower.every * scene.time_step * 20 == pytest.approx(10.0, rel=0.01)
    assert slower.integral == pytest.approx(found.integral * (found.every / slower.every) ** 2, rel=0.01)


def test_stock_styles_refuse_it_with_the_remedy():
    with pytest.raises(SetupError, match=r"stock LAMMPS has no tailgate that holds a flow .*kind hold"):
        choice.choose("lammps", "stock", 1, load_case(SMALL).scene())


def test_it_goes_on_bit_for_bit_from_the_middle_of_holding(tmp_path):
    scene = load_case(SMALL).scene()
    half = holding(scene).every * 2 + 7  # not at a look
    whole, first = NativeSimulation(scene), NativeSimulation(scene)
    first.run(half)
    save_state(first, tmp_path / "state.npz")
    second = load_state(scene, tmp_path / "state.npz")
    assert 0 < abs(second.walls.poses()["sill"].y) < 0.3
    rest = holding(scene).every * 4 - half
    second.run(rest)
    whole.run(half + rest)
    assert np.array_equal(second.positions, whole.positions)
    assert second.walls.poses() == whole.walls.poses()
    assert second.ledger == whole.ledger


def held_by(setting, folder):
    """The gate's place after 1,000 steps, and those of the discs in the order of their ids, m."""
    case = load_case(SMALL, ["walls.sill.motion.response=0.1", "run.duration=0.1", "run.output_interval=0.05"])
    scene = replace(case.scene(), steps=1000, output_steps=500, integrator="velocity_verlet")
    assert run(scene, folder, setting).status == "complete"
    frame = list(open_dump(next(folder.glob("dump.*"))))[-1].sorted()
    return [PoseFile(folder / POSES, scene.lids).at(scene.time(scene.steps))["sill"].y], frame.x, frame.y


@pytest.mark.lammps
def test_the_compiled_kernel_holds_as_the_native_engine_does(tmp_path):
    """1,000 steps with forty looks, to 1e-9 d."""
    native, compiled = (held_by(engine_setting(engine), tmp_path / engine) for engine in ("native", "compiled"))
    assert 0.005 < abs(native[0][0])
    assert np.abs(np.concatenate(native) - np.concatenate(compiled)).max() < 1e-9 * 0.2


@pytest.mark.long
@pytest.mark.lammps
def test_two_ranks_hold_as_one_does(tmp_path):
    one, two = (held_by(engine_setting("compiled", ranks=ranks), tmp_path / str(ranks)) for ranks in (1, 2))
    assert 0.005 < abs(one[0][0])
    assert np.abs(np.concatenate(one) - np.concatenate(two)).max() < 1e-9 * 0.2


def test_it_moves_no_faster_than_it_can_and_within_its_way():
    scene = load_case(SMALL, ["walls.sill.motion.range=[-0.6, 0.02]", "walls.sill.motion.front=9"]).scene()
    simulation, kind = NativeSimulation(scene, ledger=False), next(
        one.motion.kind for one in scene.walls if isinstance(one.motion.kind, Held)
    )  # fmt: skip
    places = []
    for _ in range(4):
        simulation.run(holding(scene).every)
        places.append(simulation.walls.poses()["sill"].y)
    assert max(np.abs(np.diff([0.0, *places]))) <= kind.speed * holding(scene).every * scene.time_step * (1 + 1e-9)
    assert -0.6 <= min(places) and max(places) <= 0.02 + 1e-12
