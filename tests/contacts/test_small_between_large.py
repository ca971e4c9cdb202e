# SPDX-License-Identifier: GPL-2.0-or-later
"""Small discs between large ones: velocity Verlet keeps none, whatever the step (Vyas et al. 2025, for spheres).

The scenes are those of the law `small_between_large`, which measures them at length.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_up import INPUTS
from single_disc import R, one_disc

from lammps_jump.engines.native import NativeSimulation
from lammps_jump.physics.slip import Springs
from lammps_jump.scene import Block, Motion, MovingWall
from lammps_jump.scene.scene import Fixed
from lammps_jump.scene.tracks import Rotate
from lammps_jump.studies.points import load_module

FOLDER = INPUTS.parent / "validation" / "small_between_large"
ENGINES = [
    "native",
    pytest.param("twin", marks=pytest.mark.long),
    *(pytest.param(kernel, marks=pytest.mark.lammps) for kernel in ("compiled", "stock")),
]


@pytest.fixture(scope="module")
def measure():
    return load_module(FOLDER, "measure")


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("friction", [pytest.param(0.2, marks=pytest.mark.long), 0.4])
def test_a_nip_lets_a_small_disc_go_above_the_angle_of_friction(measure, engine, friction):
    """Two large circles close on it: it gives way like a spring below arctan μ, and is pushed out above."""
    edge = np.degrees(np.arctan(friction))
    angles = [edge - 2.0, edge - 0.5, edge + 0.5, edge + 2.0]
    rise = measure.nip(engine, 0.1, 8.0, friction, angles)["rise"]
    assert np.all(np.abs(rise[:2]) < 0.02) and np.all(np.array(rise[2:]) > 0.05)


LONG = [("native", 3.0), ("native", 20.0), ("twin", 8.0)]


@pytest.mark.parametrize(
    ("engine", "ratio"), [("native", 8.0), *(pytest.param(*one, marks=pytest.mark.long) for one in LONG)]
)
def test_none_stays_between_two_fixed_discs(measure, engine, ratio):
    """The gap is 1.02 of its diameter."""
    times = measure.three(engine, 0.1, ratio, 1.02, 4 if engine != "twin" else 2, 0.5)["times"]
    assert np.all(np.isfinite(times))


@pytest.mark.parametrize("fraction", [0.1, 0.0125])
def test_a_step_adds_what_the_line_of_the_centres_turns_by(measure, fraction):
    """A disc that glides past a large one: its spring gathers r_n sin(a_n) a step, and r a within half of |dr| |a|."""
    reach = 4.0 + measure.SMALL
    scene = measure.grains(
        [(0.0, 0.0), (0.05, reach)], [8.0, 1.0], seconds=1.0, frames=1, fixed=Fixed(1, 1), time_step_fraction=fraction,
        velocities=[(0.0, 0.0), (1.5, -0.4)], gravity=(0.0, 0.0), friction=1e3,
    )  # fmt: skip
    engine = NativeSimulation(replace(scene, rotation=False, steps=10**6), ledger=False)
    places, springs = [engine.positions[1] - engine.positions[0]], [0.0]
    while len(springs) < 20 or springs[-1]:  # until they have parted again
        engine.run(1)
        places.append(engine.positions[1] - engine.positions[0])
        springs.append(float(engine.discs.spring[1].sum()))
    x, y = np.array(places).T
    r, turn = np.hypot(x, y), np.diff(np.unwrap(np.arctan2(y, x)))
    touches = r[1:] < reach
    assert np.ptp(np.flatnonzero(touches)) + 1 == touches.sum() > 2 / fraction  # one contact
    gathered = np.cumsum(np.where(touches, r[:-1] * np.sin(turn), 0.0))[touches]
    found = np.array(springs[1:])[touches]
    assert found == pytest.approx(gathered, rel=1e-9, abs=1e-15)
    way = np.cumsum(np.where(touches, 0.5 * (r[:-1] + r[1:]) * turn, 0.0))[touches]
    bounds = 0.5 * np.abs(np.diff(r) * turn) + r[1:] * np.abs(turn) ** 3 / 6.0
    bound = np.cumsum(np.where(touches, bounds, 0.0))[touches]
    assert np.all(np.abs(found - way) <= bound + 1e-15)
    assert bound[-1] < 1e-3 * fraction * abs(way[-1])


def test_a_face_that_turns_makes_what_lies_on_it_creep_inwards():
    """By W^2 x dt/2: the face is where the step ends, and has the speed of the half step. First order in the step.

    The disc does not spin, so that it also rolls outwards at W times the distance of its centre from the face.
    """
    rate, place, hold, seconds = 1.0, 2.0, 50.0, 0.8
    found = []
    for fraction in (0.1, 0.0125):
        turns = Motion(kind=Rotate(rate=float(np.degrees(rate)), about=(0.0, 0.0), ease=0.0), about=(0.0, 0.0))
        given = {
            "friction": 1.0, "friction_law": "history", "springs": Springs(2.0 / 7.0, 1.0), "restitution": 0.2,
            "gravity": (0.0, 0.0), "fraction": fraction, "cohesion": hold, "largest_overlap": 0.01,
        }  # fmt: skip
        plate = Block("plate", (-0.5, 5.0), (-0.2, 0.0))
        alone = one_disc((place, R), (0.0, 0.0), walls=(plate,), **given)
        height = R - hold / alone.coefficients.stiffness_wall
        walls = (MovingWall(plate, replace(turns, time_step=alone.time_step)),)
        scene = one_disc((place, height), (-rate * height, rate * place), walls=walls, **given)
        engine, times, along = NativeSimulation(scene, ledger=False), [], []
        every = round(seconds / scene.time_step / 40)
        for number in range(1, 41):
            engine.run(every)
            angle = rate * number * every * scene.time_step
            times.append(angle / rate)
            along.append(np.cos(angle) * engine.positions[0, 0] + np.sin(angle) * engine.positions[0, 1])
        late = np.array(times) > 0.25 * seconds  # the spring has stretched
        found.append((np.polyfit(np.array(times)[late], np.array(along)[late], 1)[0], np.mean(along), scene.time_step))
    (coarse, at, step), (fine, _, finer) = found
    assert coarse - fine == pytest.approx(-0.5 * rate**2 * at * (step - finer), rel=0.05)
