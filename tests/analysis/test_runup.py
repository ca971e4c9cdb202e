# SPDX-License-Identifier: GPL-2.0-or-later
"""Run-up on slopes and walls, and what goes over: made-up water whose highest place and volume are known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from made_up import INPUTS, collected, columns_of_discs, disc_frame, flow_context, numbers

from lammps_jump.analysis.devices import runup
from lammps_jump.analysis.passes import Gathered
from lammps_jump.analysis.verdicts import doubts, headline, verdict
from lammps_jump.analysis.verdicts.water import MANY_OVER
from lammps_jump.case import load_case
from lammps_jump.runs.results import flow_of
from lammps_jump.scene.motion import Motion, MovingWall
from lammps_jump.scene.tracks import Oscillate
from lammps_jump.scene.walls import Block, Line

ROOM = {"domain": ((-5.0, 30.0), (-5.0, 10.0)), "x_range": (-5.0, 30.0)}
D = 0.2
X, Y = columns_of_discs(5, 0.0, 10.0)
WATER = X[np.argsort(Y, kind="stable")], np.sort(Y)
"""Still water, 1 m deep, its top discs last."""


def tank(*walls, **given):
    motion = Motion(kind=Oscillate(4.0, (0.5, 0.0), begin=2.0), time_step=1e-3)
    paddle = MovingWall(Block("paddle", (-1, 0), (0, 4)), motion)
    places = np.column_stack(WATER)
    law = {"steps": 10_000, "time_step": 1e-3, "positions": places, "velocities": 0 * places}
    return flow_context(**ROOM, **law | given, walls=[paddle, *walls])


def water(*more, time, lost=0, gone=0):
    """Still water with discs of `more` in place of its last ones, without the first `lost` and the last `gone`."""
    x, y = WATER
    ids = np.arange(len(x)) + 1
    away = len(x) - len(more)
    x = np.append(x[:away], [one for one, _ in more])
    y = np.append(y[:away], [one for _, one in more])
    keep = slice(lost, len(x) - gone)
    return disc_frame(x[keep], y[keep], box=ROOM["domain"], time=time, id=ids[keep])


def found_in(flow, frames):
    watch = collected(runup.RunUpWatch(flow), frames)
    return runup.analyse(Gathered(flow, xr.Dataset(), None, {"runup": watch}, {}))


BEACH = Line(name="beach", points=((-2, 0), (10, 0), (20, 2), (28, 2)))


def test_the_tongue_on_a_slope_ends_before_the_first_gap():
    """Discs lie up to x = 16 m on a slope of 1 in 5; a lone one has run to 18 m, and one flies over all."""
    tongue = [(x, 0.2 * (x - 10) + 0.5 * D) for x in np.arange(10.1, 16.0, D)]
    frames = [water(time=t) for t in (0.0, 1.0, 2.0)]
    frames += [water(*tongue[:10], time=4.0), water(*tongue, (18.0, 1.7), (19.0, 6.0), time=5.0), water(time=6.0)]
    found = found_in(tank(BEACH), frames)
    # ends of discs are round, the place is known to a diameter
    assert found.place == pytest.approx(16.0, abs=D) and found.highest == pytest.approx(1.2, abs=0.2 * D)
    assert (found.still, found.time, found.wall) == (pytest.approx(1.0), 5.0, "beach")
    assert found.run_up == pytest.approx(found.highest - 1.0) and found.diameters == pytest.approx(found.run_up / D)
    assert (found.over, found.crest, found.reaches_crest) == (0.0, pytest.approx(2.0), False)
    summary = {"runup": numbers(found)}
    assert verdict(summary) == (
        "The water reaches y = 1.2 m on beach, 0.20 m over the still water; nothing goes over the crest at y = 2 m."
    )
    assert any("diameters, and the surface is known to about one" in text for text in doubts(summary))
    assert set(runup.tables(found)["runup.csv"]) == {"time", "height", "over", "head", "depth"}
    assert found.freeboard == pytest.approx(1.0) and np.isnan(found.discharge) and found.no_run_up is None
    assert len(runup.figures(found, None)["runup"].panels) == 1 and runup.section(found).blocks


def test_water_that_falls_before_the_motion_is_no_run_up():
    """Discs that lie loosely at the start stand higher than those at rest."""
    high = [(10.0 - 0.1 + 0.2 * k, 1.5) for k in range(10)]
    frames = [water(*high, time=0.0), water(time=1.0), water(time=2.0), water(time=3.0)]
    found = found_in(tank(BEACH), frames)
    assert found.still == pytest.approx(1.0) and np.isnan(found.highest) and np.isnan(found.run_up)
    assert found.no_run_up == "the water has not risen over its still level on it"


def test_what_goes_over_a_wall():
    """Fifteen discs go over a wall of 1.5 m; five of them are taken out behind it, and three before it."""
    flow = tank(Line(name="bed", points=((-2, 0), (28, 0))), Block("wall", (10.0, 10.4), (-1.0, 1.5)))
    stack = [(9.9, 0.1 + D * k) for k in range(7)]  # to 1.4 m, and a lone one over it
    beyond = [(11.0 + D * k, 0.1) for k in range(15)]
    frames = [
        water(time=0.0),
        water(*stack, (9.9, 2.4), time=3.0),
        water(*beyond, time=5.0),
        water(*beyond, time=6.0, lost=3, gone=5),
    ]
    found = found_in(flow, frames)
    assert found.highest == pytest.approx(1.4, abs=0.01) and (found.wall, found.crest) == ("wall", 1.5)
    assert found.over == pytest.approx(15 * D * D) and found.over_discs == 15 and found.reaches_crest
    summary = {"runup": numbers(found)}
    assert "0.60 m² of water go over wall, whose crest is at y = 1.5 m." in headline(summary)
    told = doubts(summary)
    assert any(text.startswith("The water reaches the crest: ") for text in told)
    assert any(text.startswith("15 discs make the volume") for text in told)
    assert np.isnan(found.discharge) and found.no_head == "15 discs have gone over, too few for a discharge"
    assert any("too few" in block[0] for block in runup.section(found).blocks[1:])


BED = Line(name="bed", points=((-2, 0), (28, 0)))
SLOPE = Line(name="sill", points=((-2, 0), (12, 0), (14, 1.2), (16, 1.2), (18, 0), (28, 0)))
"""A weir whose crest is 2 m wide, 1.2 m high."""
RATE = 4
"""Discs that go over it from frame to frame, in 0.1 s."""


def overflow(level, end=12.0, frames=41, depth=2, rate=RATE):
    """Frames of a reservoir up to x = `end` and `level` high, `depth` discs on the crest; `rate` discs pass a frame.

    Those that have not passed yet lie on one another at its far end, so that its level stays.
    """
    x, y = columns_of_discs(round(level / D), 0.0, end)
    on, up = columns_of_discs(depth, 14.0, 16.0, bed=1.2)
    crowd, found = np.arange(frames * rate), []
    ids = np.concatenate([10_000 + np.arange(len(x)), 20_000 + np.arange(len(on)), 1 + crowd])
    for k in range(frames):
        passed = crowd < k * rate
        places = np.where(passed, 17.0 + 0.01 * crowd, 0.1), np.full(len(crowd), 0.1)
        at = np.concatenate([x, on, places[0]]), np.concatenate([y, up, places[1]])
        found.append(disc_frame(*at, box=ROOM["domain"], time=0.1 * k, id=ids))
    return found


def standing(*walls):
    """A tank in which no wall moves."""
    flow = tank(*walls)
    return replace(flow, scene=replace(flow.scene, walls=tuple(map(MovingWall, walls))))


WEIRS = {"slope": ([SLOPE], 12.0), "face": ([BED, Block("sill", (14.0, 16.0), (-1.0, 1.2))], 14.0)}


@pytest.mark.parametrize("weir", list(WEIRS))
@pytest.mark.parametrize("level", [1.4, 2.0, 3.0])
def test_water_that_stands_over_a_crest_has_a_head_and_a_discharge_and_no_run_up(weir, level):
    """Its run-up was told as crest less still water, and its highest water as the crest."""
    walls, end = WEIRS[weir]
    found = found_in(standing(*walls), overflow(level, end))
    assert np.isnan([found.highest, found.run_up, found.place, found.time]).all()
    assert found.no_run_up == "the water stands over the crest from the start"
    assert found.freeboard == pytest.approx(1.2 - level)
    assert found.over_discs == 40 * RATE and found.discharge == pytest.approx(RATE * D * D / 0.1, rel=1e-9)
    assert found.largest_discharge == pytest.approx(found.discharge, rel=1e-6)
    assert found.head == pytest.approx(level - 1.2) == found.largest_head
    assert found.depth == pytest.approx(2 * D) == found.largest_depth
    assert found.critical_discharge == pytest.approx(np.sqrt(9.81) * (2 * (level - 1.2) / 3) ** 1.5, rel=1e-9)
    assert (found.over_since, found.over_until) == pytest.approx((0.0, 4.0)) and found.still_passes
    summary = {"runup": numbers(found)}
    assert verdict(summary).startswith("1.6 m²/s of water go over sill under a head of ")
    assert "in the mean, 6.4 m² in all; its crest is at y = 1.2 m." in verdict(summary)
    assert not any("crest: a higher" in text or "diameters" in text for text in doubts(summary))
    assert len(runup.figures(found, None)["runup"].panels) == 2
    assert not any("ighest" in row[0] for row in runup.section(found).blocks[0].rows)


def test_a_flow_over_a_crest_that_ends_has_the_mean_of_that_time():
    """Four discs a frame for 1 s, none after: the mean is over the time while water goes over."""
    frames = overflow(2.0, frames=11)
    frames += [disc_frame(f.x, f.y, box=ROOM["domain"], time=1.0 + 0.1 * k, id=f.ids) for k in range(1, 30)
               for f in [frames[10]]]  # fmt: skip
    found = found_in(standing(SLOPE), frames)
    assert found.discharge == pytest.approx(1.6) and found.over_until == pytest.approx(1.0) and not found.still_passes


@pytest.mark.parametrize("level", [0.6, 1.0])
def test_a_wave_over_a_slope_that_is_higher_than_the_still_water(level):
    """What goes over is told, with the freeboard; the slope has no highest place, and the crest no head."""
    found = found_in(standing(SLOPE), overflow(level))
    assert np.isnan(found.highest) and found.no_run_up.startswith("the water goes over the crest")
    assert found.freeboard == pytest.approx(1.2 - level) and found.discharge == pytest.approx(1.6)
    assert np.isnan(found.head) and np.isnan(found.critical_discharge) and "below the crest" in found.no_head
    summary = {"runup": numbers(found)}
    assert verdict(summary).startswith("1.6 m²/s of water go over sill in the mean, 6.4 m² in all")
    many = found.over_discs >= MANY_OVER  # it is overtopped, and nobody asks for a run-up
    assert any(text.startswith("The water reaches the crest: ") for text in doubts(summary)) != many


def test_the_depth_on_a_narrow_crest_is_taken_over_two_diameters():
    """A leaf of 0.1 m: six discs fly within 0.4 m behind its face, over its top; water of 1.8 m stands before it."""
    walls = [BED, Block("leaf", (10.0, 10.1), (-1.0, 1.2))]
    x, y = columns_of_discs(9, 0.0, 10.0)
    on = np.repeat([10.1, 10.25, 10.39, 10.6], 2), np.tile([1.3, 1.5], 4)
    ids = np.arange(len(x) + 8) + 1
    frames = [
        disc_frame(np.append(x, on[0]), np.append(y, on[1]), box=ROOM["domain"], time=0.1 * k,
                   id=np.where(ids <= k, 1e6 + ids, ids).astype(int)) for k in range(3)
    ]  # fmt: skip
    watch = collected(runup.RunUpWatch(standing(*walls)), frames)
    (obstacle,) = watch.obstacles
    assert watch.rows[0][0][5] == pytest.approx(6 * D * D / (2 * D)) and obstacle.top == 1.2


def test_still_water_before_a_wall_where_no_wall_moves():
    """A column of 2 m stands beside water of 1 m, which lies before the wall; before a dry wall there is none."""
    x, y = columns_of_discs(lambda at: np.where(at < 2.0, 10, 5), 0.0, 10.0)
    walls = [Line(name="bed", points=((-2, 0), (28, 0))), Block("wall", (10.0, 10.4), (-1.0, 3.0))]
    flow = tank(*walls)
    standing = replace(flow, scene=replace(flow.scene, walls=tuple(map(MovingWall, walls))))
    found = found_in(standing, [disc_frame(x, y, box=ROOM["domain"])])
    assert found.still == pytest.approx(1.0) and found.run_up == pytest.approx(0.0, abs=1e-9)
    dry = x < 8.0
    found = found_in(
        standing, [disc_frame(x[dry], y[dry], box=ROOM["domain"]), disc_frame(x, y, box=ROOM["domain"], time=1.0)]
    )
    assert np.isnan(found.still) and np.isnan(found.run_up) and found.highest == pytest.approx(1.0)


def test_where_no_wave_can_run_up():
    assert found_in(tank(), [water(time=0.0)]) is None
    dry = found_in(
        tank(Block("wall", (20.0, 21.0), (-1.0, 1.5)), Line(name="bed", points=((-2, 0), (28, 0)))), [water(time=0.0)]
    )
    assert dry.reason.startswith("the water has not reached") and verdict({"runup": numbers(dry)}) == ""
    assert not runup.can_run_up(tank(BEACH, friction=0.5)) and not runup.can_run_up(tank(BEACH, gravity=(0.0, 0.0)))


@pytest.mark.parametrize(
    ("scene", "name", "foot", "top"),
    [
        ("wave_paddle", "beach", 20.0, 10 * np.sin(np.radians(18))),
        ("dam_break_triangle", "triangle", 13.0, 1.0),
        ("wave_structure", "structure", 20.0, 6.0),
    ],
)
def test_obstacles_of_scenes(scene, name, foot, top):
    """A beach that is hollow below is one slope up to its end; a gate that lets water pass below is none."""
    flow = flow_of(load_case(INPUTS / f"{scene}.yaml"))
    (found,) = runup.obstacles_of(flow, 3.0)
    d = flow.scene.diameter
    assert (found.name, found.foot, found.top) == (name, pytest.approx(foot, abs=d), pytest.approx(top, abs=1e-3))
