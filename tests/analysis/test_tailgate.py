# SPDX-License-Identifier: GPL-2.0-or-later
"""What a tailgate has found, on made-up records: a crest and a front, or a depth, whose course is known."""

from __future__ import annotations

import numpy as np
import pytest
from features import BASE, FEATURES

from lammps_jump.analysis.devices import tailgate
from lammps_jump.analysis.flow import from_scene
from lammps_jump.analysis.passes import Gathered
from lammps_jump.analysis.verdicts import doubts, headline, verdict
from lammps_jump.case import load_case
from lammps_jump.files import plain
from lammps_jump.physics import jump
from lammps_jump.units import as_summary, shown

FRONT, DEPTH = "a tailgate that holds a front", "a tailgate that holds a depth"
TARGET = {FRONT: 0.8, DEPTH: 0.5}
SLACK = {FRONT: 0.1, DEPTH: 0.01}
"""How far a mean may be off beyond its interval, m: a diameter, and a tenth of one."""
NEAR = {FRONT: 0.25 * 0.5 * (0.3 + 0.3 * jump.belanger(jump.froude(4.0, 0.3))), DEPTH: 0.02 * 0.5}
"""How far means over a response may be off, m: a quarter of the mean depth of the jump, 2 % of the depth."""
TIME = np.linspace(0.1, 100.0, 1000)
"""Times of the frames; the response is 1 s."""
CREST = 0.2


def flow_of(what, *changes):
    return from_scene(load_case({**BASE, **FEATURES[what]}, ["walls.gate.motion.response=1", *changes]).scene())


def swings(size, seed=1):
    """Noise that forgets within a second, of this standard deviation."""
    noise = np.convolve(np.random.default_rng(seed).normal(size=len(TIME) + 9), np.ones(10), "valid")
    return size * noise / noise.std()


def found(flow, seen, crest=None, end=None):
    crest = CREST + swings(0.005, seed=2) if crest is None else crest
    record = tailgate.Record(TIME, crest, seen, 0.0 * TIME if end is None else end)
    (one,) = tailgate.analyse(Gathered(flow, None, None, {"tailgate": {"gate": record}}, {})).values()
    return one


@pytest.fixture(scope="module", params=[FRONT, DEPTH])
def gate(request):
    what = request.param
    return flow_of(what), TARGET[what], NEAR[what], SLACK[what]


@pytest.mark.parametrize("seed", range(5))
def test_what_is_at_its_target_has_settled(gate, seed):
    flow, target, near, slack = gate
    one = found(flow, target + swings(0.2 * near, seed))
    assert one.settled_at <= 75.0 and one.reason is None  # of the 95 % intervals of short tails some miss
    assert one.height == pytest.approx(CREST, abs=one.height_interval + 1e-3) and one.height_interval < 0.01
    assert abs(one.held - target) <= max(one.held_interval, slack)


def test_what_comes_in_has_settled_when_it_is_there(gate):
    flow, target, near, _ = gate
    coming = 10.0 * near * np.exp(-TIME / 8.0)  # 18 s until it is near
    one = found(flow, target + coming + swings(0.1 * near))
    assert 18.0 <= one.settled_at <= 60.0
    assert found(flow, target + swings(0.1 * near)).settled_at < 18.0


def test_a_crest_that_stands_with_something_else_has_a_height_and_has_not_settled(gate):
    """For instance 9.73 ± 0.06 m for 10 m."""
    flow, target, _, slack = gate
    off = 1.2 * slack  # of the front this is near
    one = found(flow, target - off + swings(0.1 * slack))
    assert np.isnan(one.settled_at) and one.height == pytest.approx(CREST, abs=0.005)
    assert one.held_interval < 0.1 * off and shown(one.held, "m", one.held_interval) in one.reason
    said = {"tailgate": {"gate": plain(as_summary(one))}}
    assert "stands with its crest at y = 0.20" in verdict(said) and shown(one.held, "m", one.held_interval) in verdict(
        said
    )
    assert f"where {target:g} m is asked for." in verdict(said)
    (doubt,) = doubts(said)
    assert "has not settled: its crest stands" in doubt


@pytest.mark.parametrize("since", [0.0, 40.0])
def test_what_is_far_off_for_long_is_said(gate, since):
    """From another start the crest stands at the right height while the front is far off."""
    flow, target, near, _ = gate
    one = found(flow, target + np.where(TIME > since, 3.0 * near, 0.0) + swings(0.1 * near))
    assert np.isnan(one.settled_at) and one.height == pytest.approx(CREST, abs=0.005)
    assert f"still goes by more than {near:.2g} m off" in one.reason


def test_what_wanders_through_its_target_has_not_settled(gate):
    flow, target, near, _ = gate
    for course in (np.linspace(-2.0, 2.0, len(TIME)), 2.0 * np.sin(TIME / 15.0)):
        one = found(flow, target + near * course)
        assert np.isnan(one.settled_at) and one.reason


def test_what_swings_too_much_to_be_known_has_not_settled(gate):
    flow, target, near, _ = gate
    slow = 0.97 * near * np.where(TIME < 87.5, 1.0, -1.0)  # near all the time, and its mean tells nothing
    one = found(flow, target + slow)
    assert np.isnan(one.settled_at) and "known to no better than" in one.reason


def test_a_crest_that_moves_has_no_height(gate):
    flow, target, near, _ = gate
    one = found(flow, target + swings(0.1 * near), crest=CREST + 0.01 * TIME)
    assert np.isnan(one.height) and np.isnan(one.settled_at) and "its height still changes" in one.reason
    assert one.last_height == pytest.approx(CREST + 1.0)
    said = {"tailgate": {"gate": plain(as_summary(one))}}
    assert verdict(said) == "The gate gate has found no height." and "still changes" in doubts(said)[0]


def test_a_crest_at_an_end_of_its_way_has_no_height(gate):
    flow, target, near, _ = gate
    one = found(flow, target + swings(0.1 * near), end=np.ones_like(TIME))
    assert one.at_limit and np.isnan(one.height) and "stands at the highest end of its way" in one.reason


@pytest.mark.parametrize(("off", "settled"), [(0.0, True), (0.9, True), (-0.9, True), (1.1, False), (-1.1, False)])
def test_what_a_frozen_flow_holds_has_no_interval(gate, off, settled):
    """Beyond the slack a frozen flow holds something else."""
    flow, target, _, slack = gate
    one = found(flow, target + off * slack + 0.0 * TIME, crest=CREST + 0.0 * TIME)
    assert np.isnan(one.held_interval) and np.isnan(one.height_interval) and one.no_interval
    assert np.isfinite(one.settled_at) == settled


def test_water_by_energy_stands_beside_it():
    """A broad crest without loss, E - 1.5 yc, over the bed; no number without a discharge or a level bed."""
    y2 = jump.sequent_depth(4.0, 0.3)
    alone = found(flow := flow_of(FRONT), 0.8 + swings(0.01)).water
    q = flow.inflow_depth * abs(flow.inflow_speed)
    assert q == pytest.approx(1.2, rel=0.02)
    assert alone == pytest.approx(y2 + 1.2**2 / (2 * 9.81 * y2**2) - 1.5 * (1.2**2 / 9.81) ** (1 / 3), rel=0.03)
    raised = flow_of(FRONT, "walls.box.y=[-0.4,0.04]", "inflow.y=0.04")
    assert found(raised, 0.8 + swings(0.01)).water == pytest.approx(alone + 0.04)
    held = "walls.gate.motion={kind: hold, depth: 0.7, at: 0.6, speed: 0.5, range: [-0.15, 0.5], response: 1}"
    deep = found(from_scene(load_case({**BASE, **FEATURES[FRONT]}, [held]).scene()), 0.7 + swings(0.001))
    assert deep.water == pytest.approx(jump.crest_holding_depth(0.7, q)) and deep.holds == "depth"
    without = found(flow_of(DEPTH), 0.5 + swings(0.001))
    assert np.isnan(without.water) and "without an inflow of rows" in without.no_water
    sloping = found(flow_of(FRONT, "slope=2"), 0.8 + swings(0.01))
    assert np.isnan(sloping.water) and "not level" in sloping.no_water
    said = {"tailgate": {"gate": plain(as_summary(deep))}}
    assert f"Water would need a crest at y = {deep.water:.3g} m, by energy without loss." in headline(said)


def test_the_gate_answers_before_the_jump_does():
    one = plain(as_summary(found(flow_of(FRONT), 0.8 + swings(0.01))))
    said = verdict({"tailgate": {"gate": one}, "jump": {"verdict": "jump", "speed": 0.0}, "inflow": {}})
    assert said.startswith("The gate gate holds the front at x = 0.7982 ± 0.0036 m")
    assert "with its crest at y = 0.1996 ± 0.0012 m. " in said and said.endswith("A hydraulic jump. Its front stands.")
