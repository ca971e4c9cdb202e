# SPDX-License-Identifier: GPL-2.0-or-later
"""Waves at gauges, the surface in a drum and the discharge of a hopper, on made-up data with known answers."""

from __future__ import annotations

from math import cosh, pi, radians, sinh, sqrt, tan, tanh

import numpy as np
import pytest
import xarray as xr
from made_up import INPUTS, collected, disc_frame, flow_context, numbers

from lammps_jump.analysis.devices import drum, hopper, waves
from lammps_jump.analysis.passes import Gathered
from lammps_jump.analysis.report.headline import headline, verdict
from lammps_jump.analysis.tables.rows import rows_of
from lammps_jump.case import load_case
from lammps_jump.errors import CaseError
from lammps_jump.physics import devices
from lammps_jump.scene.chains import X0, X1, Y0, Y1
from lammps_jump.scene.motion import Motion, MovingWall
from lammps_jump.scene.tracks import Oscillate, Rotate
from lammps_jump.scene.walls import Block, Circle

ROOM = {"domain": ((-5.0, 30.0), (-5.0, 10.0)), "x_range": (0.0, 20.0)}
WINDOW = {"window_begin": 3.0, "window_end": 20.0}


def gathered(flow, times=(0.0, 20.0), places=(5.0,), depth=None, **histories) -> Gathered:
    shape = len(times), len(places)
    values = np.zeros(shape) if depth is None else depth
    profiles = xr.Dataset({"surface_depth": (("time", "x"), values)}, {"time": list(times), "x": list(places)}, WINDOW)
    return Gathered(flow, profiles, None, histories, {})


def paddle_flow(**given):
    motion = Motion(kind=Oscillate(4.0, (0.5, 0.0), begin=3.0))
    return flow_context(**ROOM, walls=[MovingWall(Block("paddle", (-1, 0), (-1, 4)), motion)], **given)


def test_wave_heights_of_a_sine_with_noise():
    time, x = np.arange(0.0, 20.01, 0.1), np.array([4.0, 5.0, 12.0])
    swing = np.sin(2 * pi * time / 4.0)[:, None] * np.array([0.4, 0.2, 0.1])  # 0.3 at x = 4.5
    noise = np.random.default_rng(1).normal(0, 0.02, swing.shape)
    found = waves.analyse(gathered(paddle_flow(gauges=(4.5, 12.0)), time, x, 2.0 + swing + noise))
    # trough to crest of 20 phases, of a mean over four periods: noise 0.02/2 each, twice its largest of few
    assert found.heights == pytest.approx([0.6, 0.2], abs=0.05)
    assert (found.height, found.height_last) == (found.heights[0], found.heights[-1])
    assert found.depths == pytest.approx([2.0, 2.0], abs=0.01)
    assert (found.period, found.periods) == (pytest.approx(4.0), 4)
    # 0.75 s after the paddle's begin at 3 s is no whole period
    assert found.height_piston == pytest.approx(devices.piston_wave_height(1.0, 4.0, found.depth, 9.81))
    assert set(waves.tables(found)["gauges.csv"]) == {"time", "depth_4.5", "depth_12"}
    summary = {"waves": numbers(found)}
    assert verdict(summary).startswith("Waves of 4.0 s are 0.59 m high at x = 4.5 m and 0.20 m") and verdict(
        summary
    ) in headline(summary)
    assert [row.path for row in rows_of([summary])] == ["waves.height", "waves.height_last", "waves.depth"]


def test_gauges_without_a_period():
    assert waves.analyse(gathered(flow_context(**ROOM))) is None
    still = waves.analyse(gathered(flow_context(**ROOM, gauges=(5.0,))))
    assert "no wall oscillates" in still.reason and verdict({"waves": numbers(still)}) == ""
    assert not waves.section(numbers(still)).blocks
    slow = paddle_flow(gauges=(5.0,))
    short = gathered(slow)
    short.profiles.attrs |= {"window_begin": 18.0}
    assert "no whole period" in waves.analyse(short).reason


@pytest.mark.parametrize(("period", "depth"), [(0.5, 2.0), (4.0, 2.0), (60.0, 0.5)])
def test_waves_of_a_piston(period, depth):
    """Airy's dispersion relation holds; a long wave's height is S k h, a short wave's 2 S (Ursell, Dean & Yu 1960)."""
    k, height = devices.wave_number(period, depth, 9.81), devices.piston_wave_height(0.1, period, depth, 9.81)
    assert 9.81 * k * tanh(k * depth) == pytest.approx((2 * pi / period) ** 2, rel=1e-12)
    kh = k * depth
    if kh < 20:
        assert height == pytest.approx(0.1 * 2 * (cosh(2 * kh) - 1) / (sinh(2 * kh) + 2 * kh))
    if kh < 0.1:
        assert height == pytest.approx(0.1 * kh, rel=1e-2)  # next term: 1 + (kh)^2/3 …
    if kh > 20:
        assert height == pytest.approx(0.2, rel=1e-9)


@pytest.mark.parametrize("rate", [20.0, -20.0])
def test_angle_of_a_slope_in_a_drum(rate):
    """Discs below a line of 25 degrees, which rises with the wall; lone discs lie below."""
    wall = Circle("drum", (0.0, 0.0), 2.0, "inside")
    flow = flow_context(**ROOM, steps=100, walls=[MovingWall(wall, Motion(kind=Rotate(rate), time_step=1e-3))])
    flow = flow_context(**ROOM, steps=100, time_step=1e-3, walls=flow.scene.walls)
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(-1.5, 1.5, 0.05), np.arange(-1.5, 1.5, 0.01)))
    rises = tan(radians(25.0)) * np.sign(rate)
    inside = y + 0.1 <= rises * x
    frames = [(disc_frame(x[inside], y[inside], box=ROOM["domain"]), time) for time in np.arange(0.0, 20.1, 1.0)]
    collector = drum.SurfaceAngles(flow)
    for frame, time in frames:
        collector.add(frame, time)
    found = drum.analyse(gathered(flow, drum=collector.result()))
    assert found.angle == pytest.approx(25.0, abs=0.5)  # heights in steps of 0.01 m
    assert found.froude == pytest.approx(radians(20.0) ** 2 * 2.0 / 9.81)
    assert found.turns == pytest.approx(17.0 * 20.0 / 360.0)
    assert set(drum.tables(found)["drum.csv"]) == {"time", "angle"}
    assert "slopes at 24.9 degrees" in verdict({"drum": numbers(found)})


def test_no_drum_and_no_hopper():
    flow = flow_context(**ROOM)
    for part, kind in (("drum", drum), ("hopper", hopper)):
        collector = {"drum": drum.SurfaceAngles, "hopper": hopper.MassAbove}[part](flow)
        collector.add(disc_frame([1.0], [1.0], box=ROOM["domain"]), 0.0)
        found = kind.analyse(gathered(flow, **{part: collector.result()}))
        assert found.reason and kind.tables(found) == {} and kind.figures(found, None) == {}
        assert verdict({part: numbers(found)}) == "" and not kind.section(numbers(found)).blocks


def test_slot_is_the_narrowest_gap():
    shape = np.zeros((4, 15))
    lines = [(-2, 5, -2, 2), (-2, 2, -0.5, 0.5), (0.6, 0.5, 2, 2), (2, 2, 2, 5)]
    shape[:, [X0, Y0, X1, Y1]] = lines
    assert hopper.narrowest(shape, 0.0) == hopper.Slot(-0.5, 0.6, 0.5)
    assert hopper.narrowest(shape[:2], 0.0) is None


def test_discharge_of_a_hopper():
    """40 kg of disc leave every 0.1 s; Beverloo's number of the scene's own slot."""
    scene = load_case(INPUTS / "hopper.yaml", ["initial.0.y=[2, 3]"]).scene()
    slot = hopper.slot_of(scene)
    assert slot == pytest.approx((-0.5, 0.5, 0.5))
    time = np.arange(0.0, 20.01, 0.1)
    mass = 20000.0 - 400.0 * time
    flow = flow_context(**ROOM, positions=scene.positions, outlets=scene.outlets, walls=scene.walls)
    found = hopper.analyse(gathered(flow, hopper=np.array([time, mass]).T))
    assert found.discharge == pytest.approx(400.0) and found.change == pytest.approx(0.0, abs=1e-9)
    assert found.beverloo == pytest.approx(400.0 / (1000.0 * sqrt(9.81) * (1.0 - 1.4 * 0.2) ** 1.5))
    assert verdict({"hopper": numbers(found)}) == "The hopper lets out 0.40 t/s per metre through a slot of 1.0 m."
    rate = hopper.tables(found)["hopper.csv"]["discharge"]
    assert rate[5:-5] == pytest.approx(400.0) and np.isnan(rate[[0, 4, -5, -1]]).all()
    panels = hopper.figures(found, None)["hopper"].panels
    assert panels[1].levels == {"mean of the window": pytest.approx(0.4)}
    assert np.isnan(hopper.discharge_over_time(time[:2], mass[:2])).all()
    collector = hopper.MassAbove(flow)
    history = collected(collector, [disc_frame([0, 0, 0], [-1.0, 0.6, 2.0], box=ROOM["domain"])])
    assert history[:, 1].tolist() == [80.0]


@pytest.mark.parametrize("places, said", [("[3, 300]", "outside the domain"), ("[3, 3]", "there already")])
def test_gauges_that_are_refused(places, said):
    with pytest.raises(CaseError, match=rf"probes.gauges\[1\]: .*{said}"):
        load_case(INPUTS / "wave_paddle.yaml", [f"probes.gauges={places}"]).scene()
