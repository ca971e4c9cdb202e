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
    assert set(runup.tables(found)["runup.csv"]) == {"time", "height", "over"}
    assert len(runup.figures(found, None)["runup"].panels) == 1 and runup.section(found).blocks


def test_water_that_falls_before_the_motion_is_no_run_up():
    """Discs that lie loosely at the start stand higher than those at rest."""
    high = [(10.0 - 0.1 + 0.2 * k, 1.5) for k in range(10)]
    frames = [water(*high, time=0.0), water(time=1.0), water(time=2.0), water(time=3.0)]
    found = found_in(tank(BEACH), frames)
    assert found.still == pytest.approx(1.0) and found.highest < 0.1


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
