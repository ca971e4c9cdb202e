# SPDX-License-Identifier: GPL-2.0-or-later
"""A constant attraction while two touch, `contact.cohesion`, against closed forms on three engines."""

from __future__ import annotations

from dataclasses import replace
from math import sqrt

import numpy as np
import pytest

import lammps_jump as lj
from lammps_jump.engines.launch import write_script
from lammps_jump.engines.native import NativeSimulation
from lammps_jump.errors import CaseError
from lammps_jump.files import SCENE_FILE
from lammps_jump.scene import Plane, handmade_scene

D, DENSITY, PULL = 0.2, 1000.0, 50.0
MASS = DENSITY * D * D
CEILING = Plane("ceiling", "y", 0.0, "below")


def scene_of(positions, velocities, walls=(), **others):
    settings = {"gravity": (0.0, 0.0), "restitution": 1.0, "time_step_fraction": 0.01, "impact_speed": 4.0,
                "domain": ((-9, 9), (-9, 9)), "skin": 0.06, "steps": 10**6, "output_steps": 10**6,
                "cohesion": PULL}  # fmt: skip
    return handmade_scene(positions, velocities, walls, diameter=D, density=DENSITY, **(settings | others))


@pytest.mark.parametrize(("share", "parts"), [(0.99, False), (1.01, True)])
def test_two_discs_part_above_the_work_of_the_pull(started, share, parts):
    """From their balance, overlap F_c / k, they part where m* v^2 / 2 is above F_c^2 / (2 k)."""
    k = scene_of([[0, 0]], [[0, 0]]).coefficients.stiffness
    speed = share * PULL / sqrt(k * MASS / 2)
    places = [[0, 0], [D - PULL / k, 0]]
    engine = started(scene_of(places, [[-speed / 2, 0], [speed / 2, 0]]))
    engine.run(3000)  # ten times the half period of a contact
    (a, b), (u, v) = engine.positions, engine.velocities
    assert (b[0] - a[0] > D) == parts
    if parts:  # what is left of the energy
        left = sqrt(speed**2 - 2 * PULL**2 / (k * MASS))
        assert v[0] - u[0] == pytest.approx(left, rel=2e-2)  # f = 0.01: the step at which they part is O(dt) off


@pytest.mark.parametrize(("bond", "hangs"), [(0.9, False), (1.1, True)])
def test_a_disc_hangs_on_a_ceiling_below_the_pull(started, bond, hangs):
    """At rest under a ceiling: k delta = F_c - m g where the pull is above the weight."""
    weight = PULL / bond
    scene = scene_of([[0, -D / 2]], [[0, 0]], (CEILING,), restitution=0.3, gravity=(0.0, -weight / MASS))
    k = scene.coefficients.stiffness_wall
    begin = np.array([[0, -D / 2 + max(PULL - weight, 0.02 * PULL) / k]])
    engine = started(replace(scene, positions=begin))
    engine.run(4000)
    place, speed = engine.positions[0, 1], engine.velocities[0, 1]
    if hangs:
        assert -D / 2 + (PULL - weight) / k == pytest.approx(place, abs=1e-9 * D)
        assert abs(speed) < 1e-9
    else:
        assert place < -D / 2 and speed < 0


CASE = {
    "name": "sticky",
    "discs": {"diameter": D},
    "contact": {"restitution": 0.5, "impact_speed": 4, "cohesion": {"weight": 0.5}},
    "domain": {"x": [-1, 4], "y": [-1, 4]},
    "walls": [{"name": "floor", "kind": "plane", "axis": "y", "at": 0, "side": "above"}],
    "initial": [{"kind": "column", "x": [0, 1], "y": [0, 1], "gate": False}],
    "run": {"duration": 0.1},
}


def test_a_share_of_the_weight_is_a_force_and_check_tells_both():
    case = lj.load_case(CASE)
    assert case.scene().cohesion == pytest.approx(0.5 * MASS * 9.81)
    assert case.replace({"contact.cohesion": 50}).scene().cohesion == 50
    numbers = case.check().numbers
    assert numbers["bond_number"] == pytest.approx(0.5)
    assert numbers["cohesion"] == pytest.approx(0.5 * MASS * 9.81)
    assert "bond_number" not in case.replace({"contact.cohesion": None}).check().numbers


def test_a_pull_that_presses_too_deep_is_doubted_and_wrong_words_are_refused():
    case = lj.load_case(CASE)
    k = case.scene().coefficients.stiffness
    (told,) = [note for note in case.replace({"contact.cohesion": 0.06 * k * D}).scene().warnings if "cohesion" in note]
    assert "0.06" in told and "impact_speed" in told
    assert not [note for note in case.scene().warnings if "cohesion" in note]
    with pytest.raises(CaseError, match="cohesion"):
        case.replace({"contact.cohesion": -1})


def test_stock_refuses_and_its_script_says_so(tmp_path):
    case = lj.load_case(CASE)
    with pytest.raises(CaseError, match=r"cohesion.*compiled"):
        case.replace({"engine.kernel": "stock"}).scene()
    scene = case.replace({"engine.kernel": "compiled"}).scene()
    assert "contact.cohesion" in write_script(scene, tmp_path).read_text().partition("\nrun ")[0]
    write_script(scene, tmp_path, kernel="compiled")
    assert np.float64(scene.cohesion).tobytes() in (tmp_path / SCENE_FILE).read_bytes()


@pytest.mark.long
def test_a_heap_with_a_pull_is_steeper():
    """A column that collapses runs out less far where grains stick: mean distance from the wall, three starts each."""
    reach = []
    for pull in (None, {"weight": 2.0}):
        means = []
        for seed in (1, 2, 3):
            case = lj.load_case(CASE).replace({
                "contact.friction": 0.5, "contact.rotation": True, "contact.cohesion": pull, "run.seed": seed,
                "discs.diameter": 0.05, "run.duration": 3, "domain.x": [-1, 20], "contact.friction_law": "history",
                "walls": [*CASE["walls"], {"name": "back", "kind": "plane", "axis": "x", "at": 0, "side": "above"}],
            })  # fmt: skip
            simulation = NativeSimulation(case.scene(), ledger=False)
            simulation.run(case.scene().steps)
            means.append(simulation.positions[:, 0].mean())
        reach.append(means)
    assert max(reach[1]) < min(reach[0])  # all three below all three: by chance once in twenty times
