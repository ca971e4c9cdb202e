# SPDX-License-Identifier: GPL-2.0-or-later
"""Waves at gauges, the surface in a drum and the discharge of a hopper, on made-up data with known answers."""

from __future__ import annotations

from dataclasses import replace
from math import cosh, pi, radians, sinh, sqrt, tan, tanh

import numpy as np
import pytest
import xarray as xr
from made_up import INPUTS, collected, disc_frame, flow_context, numbers

from lammps_jump.analysis.devices import drum, hopper, waves
from lammps_jump.analysis.passes import Gathered
from lammps_jump.analysis.tables import rows_of
from lammps_jump.analysis.verdicts import doubts, headline, verdict
from lammps_jump.case import load_case
from lammps_jump.errors import CaseError
from lammps_jump.physics import devices
from lammps_jump.scene.motion import Motion, MovingWall
from lammps_jump.scene.tracks import Oscillate, Rotate
from lammps_jump.scene.walls import Block, Circle, Line, Plane

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
    assert waves.section(still).blocks[0].rows == [("5", "0.000", "0.000", "0.000")]
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


def hopper_of(flow, frames):
    """The outlets of made-up frames, and their tracks."""
    watch = collected(hopper.Crossings(flow), frames)
    profiles = xr.Dataset({}, {"time": [0.0]}, WINDOW)
    return hopper.analyse(Gathered(flow, profiles, None, {"hopper": watch}, {}))


def test_no_drum_and_no_outlet():
    flow = flow_context(**ROOM)
    frame = disc_frame([1.0], [1.0], box=ROOM["domain"])
    found = drum.analyse(gathered(flow, drum=collected(drum.SurfaceAngles(flow), [frame])))
    nothing = hopper_of(flow, [frame])
    for part, kind, one in (("drum", drum, found), ("hopper", hopper, nothing)):
        summary = {part: numbers(one)}
        assert one.reason and kind.tables(one) == {} and kind.figures(one, None) == {}
        # the title says nothing of it; what was asked for is told with its reason
        assert verdict(summary) == "" and one.reason[1:] in doubts(summary)[0]
    assert nothing.reason == "no two walls that stand leave a gap between them"
    assert np.isnan(nothing.discharge) and nothing.gaps == 0


def line(name, *points):
    return Line(name=name, points=points, sheet=True)


SILO = (line("left", (-2, 9), (-2, 4), (1, 1)), line("right", (4, 9), (4, 3), (2, 1)))
"""A silo with a gap of 1 m at x = 1.5 m, off its middle."""


def test_gaps_are_narrow_places_wherever_they_lie():
    found = hopper.gaps_of(flow_context(**ROOM, walls=SILO).scene)
    assert (found[0].width, found[0].middle) == (pytest.approx(1.0), pytest.approx((1.5, 1.0)))
    # corners of the funnel are no narrow places, its open top is one
    assert [one.width for one in found] == pytest.approx([1.0, 6.0])
    between = Block("post", (1.4, 1.6), (0.5, 1.5))
    halves = [one for one in hopper.gaps_of(flow_context(**ROOM, walls=[*SILO, between]).scene) if one.width < 0.5]
    assert sorted(one.middle[0] for one in halves) == pytest.approx([1.2, 1.8])
    moving = MovingWall(between, Motion(kind=Oscillate(1.0, (0.1, 0.0))))
    assert [one.width for one in hopper.gaps_of(flow_context(**ROOM, walls=[*SILO, moving]).scene)] == [1.0, 6.0]


def test_gaps_over_a_floor_without_end_and_round_a_circle():
    walls = [Plane("floor", "y", 0.0, "above"), Block("gate", (3.0, 3.4), (0.6, 5.0)), Circle("pier", (8.0, 3.0), 1.0)]
    found = hopper.gaps_of(flow_context(**ROOM, walls=walls).scene)
    widths = [one.width for one in found]
    assert widths[:2] == pytest.approx([0.6, 0.6])  # below both corners of the gate
    assert 2.0 == pytest.approx(min(one.width for one in found if one.middle[0] > 7), rel=1e-9)  # below the pier


def falling(x, begin, until, step=0.05, speed=2.0, y=3.0):
    """Frames of discs that fall one after the other from (x, y), each from its own time on."""
    times = np.arange(0.0, until, step)
    x, begin = np.asarray(x, float), np.asarray(begin, float)
    for time in times:
        yield disc_frame(x, y - speed * np.maximum(time - begin, 0.0), box=ROOM["domain"], time=time)


def test_the_discharge_runs_from_flow_on_to_flow_off():
    """A disc of 40 kg every 0.1 s passes the gap from t = 2 s to t = 12 s, and none before and after."""
    begin = 1.0 + 0.1 * np.arange(100)  # 2 m down to the gap takes 1 s
    flow = flow_context(**ROOM, walls=SILO, window=(18.0, 20.0))
    found = hopper_of(flow, falling(np.full(100, 1.5), begin, 20.0))
    assert found.discharge == pytest.approx(400.0, rel=0.02) and abs(found.change) < 0.03
    # half of the piece of the record over which a discharge is taken
    assert (found.begin, found.end) == (pytest.approx(2.0, abs=0.6), pytest.approx(12.0, abs=0.6))
    assert found.goes_on is False and found.left < 0.06 and found.pause == pytest.approx(0.1, rel=0.2)
    assert (found.gaps, found.slot, found.slot_in_diameters) == (1, pytest.approx(1.0), pytest.approx(5.0))
    assert (found.gap_x, found.gap_y, found.gap_turn) == ((pytest.approx(1.5),), (pytest.approx(1.0),), (0.0,))
    # five diameters: no law
    assert np.isnan(found.beverloo) and found.no_beverloo.startswith("the gap is 5.0 d wide; the law holds from 6 d")
    summary = {"hopper": numbers(found)}
    assert verdict(summary) == "Discs leave at 0.40 t/s per metre through a gap of 1.0 m at x = 1.5 m."
    assert any("no number of Beverloo: the gap is 5.0 d" in text for text in doubts(summary))
    # a window that is asked for cuts it
    asked = hopper_of(replace(flow, window=(4.0, 8.0), asked_window=True), falling(np.full(100, 1.5), begin, 20.0))
    assert (asked.begin, asked.end) == (pytest.approx(4.0), pytest.approx(8.0))


def test_beverloo_s_number_of_one_wide_gap():
    wide = line("left", (-2, 9), (-2, 4), (0, 1)), SILO[1]
    begin = 0.1 * np.arange(100)
    found = hopper_of(flow_context(**ROOM, walls=wide), falling(np.full(100, 1.5), begin, 20.0))
    expected = found.discharge / (1000.0 * sqrt(9.81) * (2.0 - 1.4 * 0.2) ** 1.5)
    assert found.slot == pytest.approx(2.0) and found.beverloo == pytest.approx(expected) and not found.no_beverloo
    rate = hopper.tables(found)["hopper.csv"]["discharge"]
    assert np.isnan(rate[[0, -1]]).all() and np.nanmedian(rate[40:200]) == pytest.approx(400.0)
    assert set(hopper.tables(found)["hopper.csv"]) == {"time", "mass", "discharge"}
    panels = hopper.figures(found, None)["hopper"].panels
    assert panels[1].levels == {"mean of the window": pytest.approx(found.discharge / 1e3)}


def test_several_gaps_and_one_in_a_wall():
    """Every other disc passes another gap beside the first; together they have the discharge, and no law is asked."""
    bars = [line("a", (-2, 9), (-2, 1), (0, 1)), line("b", (1, 1), (3, 1)), line("c", (4, 1), (6, 1), (6, 9))]
    x, begin = np.where(np.arange(100) % 2, 0.5, 3.5), 0.1 * np.arange(100)
    found = hopper_of(flow_context(**ROOM, walls=bars), falling(x, begin, 20.0))
    assert sorted(found.gap_x) == [pytest.approx(0.5), pytest.approx(3.5)] and found.gaps == 2
    assert found.gap_discharge == (pytest.approx(200.0, rel=0.05),) * 2 and found.gap_discs == (50, 50)
    assert np.isnan(found.slot) and np.isnan(found.beverloo) and "2 gaps beside each other" in found.no_beverloo
    said = "through 2 gaps: 0.20 through 1.0 m at x = 0.5 m, 0.20 through 1.0 m at x = 3.5 m"
    assert said in verdict({"hopper": numbers(found)})
    assert len(hopper.section(found).blocks[1].rows) == 2
    # turned by a right angle: discs run along x through a gap in a wall
    walls = [line("low", (5, -4), (5, 2)), line("high", (5, 4), (5, 9))]
    times = np.arange(0.0, 20.0, 0.05)
    frames = [
        disc_frame(4.0 + 2.0 * np.maximum(t - begin, 0.0), np.full(100, 3.0), box=ROOM["domain"], time=t) for t in times
    ]
    aside = hopper_of(flow_context(**ROOM, walls=walls), frames)
    assert aside.gap_turn == (pytest.approx(90.0),) and aside.slot == pytest.approx(2.0)
    assert aside.discharge > 0 and "at 90 degrees to gravity" in aside.no_beverloo


def test_discs_that_come_back_have_not_left():
    flow = flow_context(**ROOM, walls=SILO)
    times = np.arange(0.0, 5.0, 0.1)
    frames = [
        disc_frame(np.full(9, 1.5), np.full(9, 1.0 + np.cos(np.pi * t)), box=ROOM["domain"], time=t) for t in times
    ]
    assert hopper_of(flow, frames[:-9]).reason == "discs pass no gap between walls that stand"


def test_the_scene_of_a_hopper_has_its_gap():
    scene = load_case(INPUTS / "hopper.yaml", ["initial.0.y=[2, 3]"]).scene()
    first = hopper.gaps_of(scene)[0]
    assert (first.width, first.middle) == (pytest.approx(1.0), pytest.approx((0.0, 0.5)))


@pytest.mark.parametrize(
    "places, said",
    [
        ("[3, 300]", "300 m is outside the domain"),
        ("[3, 3]", "there already"),
        ("[3, END]", "is at the end of the domain"),
    ],
)
def test_gauges_that_are_refused(places, said):
    with pytest.raises(CaseError, match=rf"probes.gauges\[1\]: .*{said}"):
        end = load_case(INPUTS / "wave_paddle.yaml").scene().domain[0][1]
        load_case(INPUTS / "wave_paddle.yaml", [f"probes.gauges={places.replace('END', str(end))}"]).scene()
