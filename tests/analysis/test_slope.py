# SPDX-License-Identifier: GPL-2.0-or-later
"""A chute in upright gravity against a level bed in tilted gravity, on the native engine: one flow, seen twice."""

from __future__ import annotations

from dataclasses import replace
from math import cos, radians, sin, tan

import numpy as np
import pytest

from lammps_jump.analysis.budgets.head import EnergyFluxes
from lammps_jump.analysis.contacts import ContactCollector
from lammps_jump.analysis.flow import from_scene
from lammps_jump.analysis.forces.impulse import MomentumLedger, impulse_identity
from lammps_jump.analysis.profiles import bin_frames
from lammps_jump.analysis.slope import BedStretch, sloping_stretch, turned_flow
from lammps_jump.dump.find import ForceHistory
from lammps_jump.engines.native.engine import take_frame
from lammps_jump.engines.native.simulation import NativeSimulation
from lammps_jump.scene import Block, handmade_scene
from lammps_jump.scene.walls import Line, Polygon

ANGLE = radians(15.0)
DOWN = np.array([[cos(ANGLE), sin(ANGLE)], [-sin(ANGLE), cos(ANGLE)]])
"""Turns a level bed into one that falls by `ANGLE` towards larger x."""
G, D, LONG = 9.81, 0.2, 24.0
PLACES = np.array([[x, y] for x in np.arange(4.1, 20.0, D) for y in (0.1, 0.3, 0.5)])
PLACES = PLACES + np.random.default_rng(4).uniform(-0.004, 0.004, PLACES.shape)
BEDS = {
    "line": lambda: Line("bed", ((-5.0, 5.0 * tan(ANGLE)), (40.0, -40.0 * tan(ANGLE)))),
    "turned block": lambda: Block("bed", (-5.0, 40.0), (-1.0, 0.0), angle=-np.degrees(ANGLE), pivot=(0.0, 0.0)),
}


def run_of(walls, turn, gravity):
    """Frames of 500 steps, and the record of forces on the bed; discs of a layer that slides and rubs."""
    scene = handmade_scene(
        PLACES @ turn.T, np.zeros_like(PLACES) + turn @ (6.0, 0.0), walls, gravity=gravity, friction=0.2,
        impact_speed=8.0, probes=("bed",), probe_steps=50, domain=((-50.0, 50.0), (-50.0, 50.0)), steps=500,
    )  # fmt: skip
    run, frames = NativeSimulation(scene), []
    for _ in range(11):
        frames.append(take_frame(run))
        run.run(50)
    rows = np.array([[scene.time(row[0]), *row[2:]] for row in run.forces])
    return scene, frames, ForceHistory(*rows.T)


@pytest.fixture(scope="module")
def level():
    return run_of((Block("bed", (-5.0, 40.0), (-1.0, 0.0)),), np.eye(2), (G * sin(ANGLE), -G * cos(ANGLE)))


@pytest.fixture(scope="module", params=BEDS.values(), ids=BEDS)
def chute(request):
    return run_of((request.param(),), DOWN, (0.0, -G))


def test_a_chute_is_a_level_bed_in_tilted_gravity(level, chute):
    """Round-off of 500 steps with contacts; positions of tens of metres."""
    for straight, there in zip(level[1], chute[1], strict=True):
        assert (
            np.abs(np.column_stack([there.x, there.y]) @ DOWN - np.column_stack([straight.x, straight.y])).max()
            < 1e-9 * D
        )
    forces = np.column_stack([chute[2].fx, chute[2].fy]) @ DOWN
    assert forces == pytest.approx(np.column_stack([level[2].fx, level[2].fy]), rel=1e-6)


@pytest.mark.parametrize("axis", ["x", "y"])
def test_the_momentum_identity_closes_on_a_chute_as_on_a_level_bed(level, chute, axis):
    for scene, frames, history in (level, chute):
        flow = from_scene(scene, x_range=(0.0, LONG))
        ledger = MomentumLedger(flow)
        for frame in frames:
            ledger.add(frame, flow.time(frame))
        found = impulse_identity({"bed": history}, ledger.result(), flow, axis)
        # dashpots of the engine see the velocity of the half step, those of the frames at both ends that of the step
        assert found.complete and found.relative < 1e-5
        assert abs(found.wall_impulse) > 100.0


def test_profiles_along_a_chute_are_those_of_the_level_bed(level, chute):
    straight = from_scene(level[0], x_range=(0.0, LONG), bin_width=1.0)
    flow = from_scene(chute[0], x_range=(0.0, LONG), bin_width=1.0)
    along = turned_flow(flow, BedStretch(0.0, 0.0, LONG * cos(ANGLE), -ANGLE))
    assert along.scene.gravity == pytest.approx(level[0].gravity, rel=1e-12)
    one, two = bin_frames(level[1], straight), bin_frames(map(along.turned, chute[1]), along)
    for name in ("mass_depth", "discharge", "momentum_flux", "energy_flux", "surface_depth", "velocity", "bed"):
        np.testing.assert_allclose(two[name].values, one[name].values, rtol=1e-6, atol=1e-8, err_msg=name)
    sums = []
    for frames, seen, turn in ((level[1], straight, lambda frame: frame), (chute[1], along, along.turned)):
        contacts = ContactCollector(seen, np.arange(0.0, LONG + 0.5))
        for frame in frames:
            contacts.add(turn(frame), 0.0)
        sums.append(contacts.result())
    for name in ("thrust", "wall_fx"):
        given = getattr(sums[0], name)
        assert np.abs(given).max() > 1000.0
        np.testing.assert_allclose(getattr(sums[1], name), given, atol=1e-6 * np.abs(given).max())


def test_upright_bins_see_the_depth_over_the_cosine_and_the_same_discharge(level, chute):
    """Depths along the vertical are longer by 1/cos, velocities along x shorter by cos; discharge is the same.

    Means over the middle of the layer; bins cut it along different planes, so that ends of rows differ: 2 %.
    """
    along = bin_frames(level[1], from_scene(level[0], x_range=(8.0, 18.0), bin_width=1.0))
    upright = from_scene(chute[0], x_range=(8.0 * cos(ANGLE), 18.0 * cos(ANGLE)), bin_width=cos(ANGLE))
    found = bin_frames(chute[1], upright)
    for name, factor in (("mass_depth", 1 / cos(ANGLE)), ("surface_depth", 1 / cos(ANGLE)), ("discharge", 1.0),
                         ("velocity", cos(ANGLE))):  # fmt: skip
        assert float(found[name].mean()) == pytest.approx(factor * float(along[name].mean()), rel=0.02), name
    assert found["bed"].values == pytest.approx(-tan(ANGLE) * found["x"].values, abs=1e-9)


def test_the_longest_slope_of_a_bed_is_found():
    chute = Polygon("bed", ((-2.0, 6.0), (0.0, 6.0), (20.0, 1.0), (40.0, 1.0), (40.0, -1.0), (-2.0, -1.0)))
    scene = handmade_scene([(1.0, 6.1)], [(0.0, 0.0)], (chute,), domain=((-2.0, 40.0), (-1.0, 9.0)), steps=10)
    found = sloping_stretch(from_scene(scene, x_range=(-2.0, 39.0), bin_width=0.7))
    assert tan(found.angle) == pytest.approx(-0.25, rel=1e-9)
    assert 0.0 <= found.x < 1.4 and 18.0 < found.x + found.length <= 20.0
    assert found.y == pytest.approx(6.0 - 0.25 * found.x, abs=1e-9)
    assert found.place(found.x + 4.0) == pytest.approx(found.x + 4.0 * cos(found.angle))
    level = replace(scene, walls=(Block("bed", (-2.0, 40.0), (-1.0, 0.0)),))
    assert sloping_stretch(from_scene(level, x_range=(-2.0, 39.0), bin_width=0.7)) is None


def test_energy_along_a_chute_is_that_of_the_level_bed(level, chute):
    """As far as frames count it, which is without friction: carried, handed on, stored and taken by dashpots."""
    found = []
    for scene, frames in (level[:2], chute[:2]):
        scene = replace(scene, coefficients=replace(scene.coefficients, friction=0.0))
        flow = from_scene(scene, x_range=(0.0, LONG), bin_width=1.0)
        if scene.gravity[0] == 0:
            flow = turned_flow(flow, BedStretch(0.0, 0.0, LONG * cos(ANGLE), -ANGLE))
            frames = map(flow.turned, frames)
        fluxes = EnergyFluxes(flow)
        for frame in frames:
            fluxes.add(frame, 0.0)
        found.append(fluxes.result())
    for name, given in found[0].items():
        scale = np.abs(given.values).max()
        assert scale > 0, name
        np.testing.assert_allclose(found[1][name].values, given.values, atol=1e-6 * scale, err_msg=name)
