# SPDX-License-Identifier: GPL-2.0-or-later
"""Frames of periodic channels and rough beds, as analyses see them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_up import disc_frame

from lammps_jump.analysis.contacts import bed_contacts, touching, whole_forces
from lammps_jump.analysis.flow import fixed_discs, from_scene, moving, placed, with_images
from lammps_jump.analysis.grains.layers import LayerSums
from lammps_jump.analysis.passes import feed
from lammps_jump.scene import Sizes, handmade_scene
from lammps_jump.scene.scene import Fixed

D = 0.2
BOX = ((0.0, 2.0), (-1.0, 5.0))


def channel(places, **more):
    """Discs in a periodic channel of 2 m, above fixed ones at y = 0, one of which is on the seam."""
    n = len(places)
    row = [(D * i, 0.0) for i in range(10)]
    positions = np.concatenate([np.array(places, float).reshape(-1, 2), row])
    sizes = Sizes((1.0,), (D,), (D,), 1, ((n + 1, n + 10, D),))
    scene = handmade_scene(
        positions, 0 * positions, domain=BOX, periodic=True, sizes=sizes, fixed=Fixed(n + 1, n + 10), **more
    )
    radius = np.full(n + 10, D / 2)
    return scene, disc_frame(*positions.T, box=BOX, radius=radius)


def test_discs_are_inside_the_channel_and_fixed_ones_apart():
    scene, frame = channel([(2.05, 1.0), (-0.05, 2.0)])
    inside = placed(frame, scene)
    assert inside.x[:2] == pytest.approx([0.05, 1.95])
    free = moving(inside, scene)
    assert free.ids.tolist() == [1, 2]
    images = with_images(free, scene)
    assert images.x.tolist() == pytest.approx([0.05, 1.95, 2.05, -0.05]) and images.ids.tolist() == [1, 2, 1, 2]
    # the disc at 1.8 m touches none beyond the seam
    assert sorted(fixed_discs(frame, scene).x.round(9)) == [*np.round(D * np.arange(10), 9), 2.0]


def test_what_has_no_such_thing_is_left_alone():
    scene = handmade_scene([(0, 1)], [(0, 0)])
    frame = disc_frame([0.0], [1.0], box=BOX)
    assert all(look(frame, scene) is frame for look in (placed, moving, with_images))


def test_force_of_a_disc_on_the_bed_across_the_seam():
    """It stands between the last disc of the bed and the first, which is beyond the seam."""
    overlap = 0.004
    height = np.sqrt((D - overlap) ** 2 - (D / 2) ** 2)
    scene, frame = channel([(1.9, height)])
    free = moving(frame, scene)
    found = bed_contacts(free, from_scene(scene))
    assert found.overlap == pytest.approx([overlap, overlap]) and set(found.partner) == {2, 11}
    fx, fy = whole_forces(free, from_scene(scene), touching(free, from_scene(scene)))
    assert fx.sum() == pytest.approx(0.0, abs=1e-6)
    assert fy.sum() == pytest.approx(2 * scene.coefficients.stiffness * overlap * height / (D - overlap))
    # the effective mass is that of the disc
    c = scene.coefficients
    assert found.dashpot == pytest.approx(scene.mass * c.gamma_normal / np.sqrt(2))


def test_sums_are_the_same_wherever_the_seam_is():
    """Mass and stress of layers do not change when all discs are shifted along the channel."""
    random = np.random.default_rng(2)
    places = np.array([(0.19 * i + 0.1, 0.18 * j + 0.17) for i in range(10) for j in range(4)])
    places += random.normal(0.0, 0.005, places.shape)
    sums = []
    for shift in (0.0, 0.13, 1.0):
        scene, frame = channel(places)
        frame = disc_frame(frame.x + shift, frame.y, box=BOX, radius=frame.column("radius"))
        positions = scene.positions.copy()
        positions[:, 0] += shift
        flow = replace(from_scene(replace(scene, positions=positions)), layers=((0.0, 2.0), 0.1))
        layers = LayerSums(flow)
        list(feed([frame], flow, [layers]))
        sums.append(layers.result().sums[0])
    assert sums[0][0].sum() == pytest.approx(len(places) * np.pi * D * D / 4)
    assert np.abs(sums[1] - sums[0]).max() < 1e-9 * np.abs(sums[0]).max()
    assert np.abs(sums[2] - sums[0]).max() < 1e-9 * np.abs(sums[0]).max()
