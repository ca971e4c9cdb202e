# SPDX-License-Identifier: GPL-2.0-or-later
"""The front on discs placed by hand and on fronts that follow a known law."""

from math import sqrt

import numpy as np
import pytest
from made_up import collected, columns_of_discs, disc_frame, flow_context, numbers

from lammps_jump.analysis.devices.front import (
    FrontHistory,
    FrontTracker,
    analyse_front,
    back_wall,
    bulk_front,
    figures,
    off_curve,
    quantile_front,
    rms,
    section,
    stack_top,
    way,
)
from lammps_jump.analysis.passes import Gathered
from lammps_jump.analysis.tables import rows_of, tiles
from lammps_jump.analysis.verdicts import headline, verdict
from lammps_jump.dump.frame import make_frame
from lammps_jump.physics import jump as waves
from lammps_jump.physics import measured as reference_data
from lammps_jump.scene.walls import Block, Box, Line, Plane

D, G = 0.2, 9.81
WALLS = (Plane("back", "x", 0.0, "above"), Plane("floor", "y", 0.0, "above"))


def context(walls=WALLS, **changes):
    changes = {"water": True, **changes}
    return flow_context(domain=((-1.0, 100.0), (-1.0, 40.0)), x_range=(0.0, 100.0), walls=walls, **changes)


def block(width, height, step=0, time=0.0, velocity=0.0, extra=()):
    x = np.repeat(np.arange(D / 2, width, D), round(height / D))
    y = np.tile(np.arange(D / 2, height, D), round(width / D))
    x = np.concatenate([x, [p[0] for p in extra]])
    y = np.concatenate([y, [p[1] for p in extra]])
    return disc_frame(x, y, velocity, box=[[-1, 100], [-1, 40]], step=step, time=time)


def tracked(frames, flow):
    return collected(FrontTracker(flow), frames)


def test_uniform_block():
    history = tracked([block(4, 12, velocity=1.5)], context())
    assert history.bulk[0] == pytest.approx(4.0, abs=1e-12)
    assert history.height[0] == pytest.approx(12.0, abs=1e-12)
    assert history.column == (pytest.approx(4.0), pytest.approx(12.0))
    assert history.top_speed[0] == pytest.approx(1.5)
    assert history.tip_speed[0] == pytest.approx(1.5)


def test_thrown_off_discs_are_not_the_bulk():
    frame = block(4, 12, extra=[(4.0 + 2.0 * D + 0.11, 0.1), (30.0, 5.0)])
    history = tracked([frame], context())
    assert history.bulk[0] == pytest.approx(4.0)
    assert history.quantile[0] < 4.2  # 2 of 1202 discs are not one per cent
    near = block(4, 12, extra=[(4.0 + 2.0 * D - 0.11, 0.1)])  # gap of centres just below two diameters
    assert tracked([near], context()).bulk[0] == pytest.approx(4.0 + 2 * D - 0.01)


def test_splash_above_the_column_is_not_its_height():
    frame = block(4, 6, extra=[(0.1, 9.0)])
    assert tracked([frame], context()).height[0] == pytest.approx(6.0)
    assert stack_top(np.array([3.0]), D, 0.0) == 0.0


def test_empty_frame_and_one_disc():
    nothing = block(0, 0)
    history = tracked([nothing, nothing], context())
    assert np.isnan(history.bulk).all()
    assert "no frame holds a disc" in numbers(analyse_front(history, context()))["reason"]
    alone = tracked([make_frame(0, 0.0, [[0, 9], [0, 9]], {"id": [1], "x": [0.1], "y": [0.1], "vx": [2.0], "vy": [0]})],
                    context())  # fmt: skip
    assert alone.bulk[0] == pytest.approx(0.2)
    assert alone.height[0] == pytest.approx(0.2)
    summary = numbers(analyse_front(alone, context()))
    assert summary["position"] == pytest.approx(0.2)
    assert summary["martin_moyce"]["rms_bulk"] is None
    assert np.isnan(bulk_front(np.zeros(0), D))
    assert np.isnan(quantile_front(np.zeros(0), D))


def test_falling_column():
    """A block that falls freely while its width grows at a set speed: front and height are known at every time."""
    speed = 3.0
    frames = []
    for k in range(11):
        t = 0.1 * k
        frame = block(4, 4, step=k, time=t)
        x = frame.x * (1 + speed * t / 4)  # stretched: right edge of the last centre
        columns = {**frame.columns, "x": x}
        frames.append(make_frame(k, t, frame.box, columns))
    history = tracked(frames, context())
    expected = (4 - D / 2) * (1 + speed * history.time / 4) + D / 2
    assert history.bulk == pytest.approx(expected, abs=1e-12)
    summary = numbers(analyse_front(history, context()))
    assert summary["speed"] == pytest.approx(speed * (4 - D / 2) / 4, rel=1e-9)
    assert summary["column_depth"] == pytest.approx(4.0)


def made_history(time, bulk, height, column):
    zero = np.zeros_like(time)
    return FrontHistory(time, bulk, bulk, height, zero, zero, 0.0, column)


def test_ritters_front_agrees_with_itself():
    base, depth = 60.0, 12.0
    time = np.linspace(0, 5, 101)
    front = base + np.array([waves.ritter_front(t, depth, G) for t in time])
    summary = numbers(analyse_front(made_history(time, front, depth + 0 * time, (base, depth)), context()))
    ritter = summary["ritter"]
    assert ritter["rms"] == pytest.approx(0.0, abs=1e-12)
    assert ritter["valid_until"] == pytest.approx(60 / sqrt(G * 12))
    assert ritter["frames"] == 100


def test_martin_and_moyces_front_agrees_with_itself():
    base, depth = 4.0, 8.0
    table, tall = reference_data.MARTIN_MOYCE_FRONT, reference_data.MARTIN_MOYCE_HEIGHT
    tau = np.union1d(np.array(table.x) / sqrt(2), tall.x)
    time = tau / sqrt(G / base)
    front = base * np.interp(sqrt(2) * tau, table.x, table.y)
    height = depth * np.interp(tau, tall.x, tall.y)
    summary = numbers(analyse_front(made_history(time, front, height, (base, depth)), context()))["martin_moyce"]
    assert summary["comparable"]
    assert summary["rms_bulk"] == pytest.approx(0.0, abs=1e-12)
    assert summary["rms_height"] == pytest.approx(0.0, abs=1e-12)
    assert summary["points"] == 14  # those beyond T = 0.8
    assert summary["slope"] == pytest.approx(reference_data.MARTIN_MOYCE_FRONT_SLOPE[2], abs=0.05)
    lagging = numbers(analyse_front(made_history(time, 0.9 * front, height, (base, depth)), context()))["martin_moyce"]
    assert lagging["rms_bulk"] == pytest.approx(0.1, rel=1e-9)


def test_each_table_belongs_to_one_shape_of_column():
    """A column of n² = 3 is not held against the tables of n² = 2, one of n² = 1 against the slope of its own."""
    time = np.linspace(0.05, 3, 60)

    def compared(base, depth):
        history = made_history(time, base + 10 * time, depth * np.exp(-time), (base, depth))
        return analyse_front(history, context())

    tall = compared(4.0, 12.0)
    found = numbers(tall)["martin_moyce"]
    assert found["comparable"] is False and found["rms_bulk"] is None and found["slope_of_table"] is None
    assert "No measured curve of water belongs to it: it is 3 times as high as wide" in headline(
        {"front": numbers(tall)}
    )
    assert "Ritter's front, until 0.37 s" in headline({"front": numbers(tall)})
    assert numbers(compared(4.0, 4.0))["martin_moyce"]["slope_of_table"] == 1.4
    assert "water of this shape has 1.40" in headline({"front": numbers(compared(4.0, 4.0))})
    square = compared(4.0, 8.0)
    assert (
        square.martin_moyce.comparable
        and "off Martin & Moyce's water in the mean (a column twice as high as wide)"
        in headline({"front": numbers(square)})
    )


def test_front_stops_to_count_at_an_obstacle():
    walls = (*WALLS, Block("structure", (20, 22), (-1, 6)))
    flow = context(walls)
    time = np.linspace(0, 4, 81)
    front = np.minimum(4 + 10 * time, 20.0)
    history = made_history(time, front, 12 + 0 * time, (4.0, 12.0))
    assert way(flow, history, history.column[0]) == (pytest.approx(20.0), True)
    summary = numbers(analyse_front(history, flow))
    assert summary["arrival_time"] == pytest.approx(1.6, abs=0.06)  # frames every 0.05 s
    assert summary["speed"] == pytest.approx(10.0, rel=1e-9)


def test_back_wall_and_free_length():
    assert back_wall(context()) == 0.0
    assert back_wall(context((Box("tank", (1, 9), (0, 5)),))) == 1.0
    assert back_wall(context((Plane("floor", "y", 0, "above"),))) is None
    history = made_history(np.zeros(1), np.full(1, 2.0), np.ones(1), (2.0, 1.0))
    assert way(context(), history, history.column[0]) == (np.inf, False)
    falls = (Plane("back", "x", 0, "above"), Block("floor", (-5, 30), (-5, 0)))
    # the floor ends; looked at every 5 cm
    assert way(context(falls), history, history.column[0]) == (pytest.approx(30.0, abs=0.1), False)


def on_a_bed(*walls, front=lambda time: 2 + 10 * time):
    """What is said of a column of 2 × 1 m at a back wall whose front runs with a law."""
    flow, time = context((Plane("back", "x", 0, "above"), *walls)), np.linspace(0, 4, 81)
    return analyse_front(made_history(time, front(time), 1 + 0 * time, (2.0, 1.0)), flow)


@pytest.mark.parametrize("end", [1.0, 2.0, 2.01, None])
def test_a_front_without_a_bed_meets_nothing(end):
    """The shelf ends before, under and a little beyond the face of the column, or there is none at all."""
    front = on_a_bed(*([] if end is None else [Block("shelf", (0, end), (-0.2, 0))]))
    found = numbers(front)
    assert found["position"] == pytest.approx(42) and found["column_base"] == 2
    assert found["arrival_time"] is found["free_length"] is found["speed"] is None
    assert "no bed is known under the front" in found["reason"]
    assert "met" not in headline({"front": found}) and "meets" not in verdict({"front": found})
    assert found["reason"] in [block.text for block in section(front).blocks if hasattr(block, "text")]


def test_a_front_that_leaves_its_bed_has_met_no_obstacle():
    shelf = Block("shelf", (0, 22), (-0.2, 0))
    found = numbers(on_a_bed(shelf))
    assert found["free_length"] == pytest.approx(22, abs=0.1) and found["speed"] == pytest.approx(10)
    assert (
        found["arrival_time"] is None and "the bed ends, falls or levels out 22 m from the back wall" in found["reason"]
    )
    assert numbers(on_a_bed(shelf, front=lambda time: 2 + time))["reason"] is None  # it stays on the shelf
    # a step down is no obstacle, a step up and a wall are
    lower = Block("lower", (22, 90), (-0.5, -0.4))
    assert numbers(on_a_bed(shelf, lower))["arrival_time"] is None
    for walls in (
        (shelf, Block("step", (22, 90), (-0.2, 0.1))),
        (Plane("floor", "y", 0, "above"), Plane("end", "x", 22, "below")),
    ):
        found = numbers(on_a_bed(*walls))
        assert found["arrival_time"] == pytest.approx(2.0, abs=0.06) and found["reason"] is None


def test_no_wall_takes_the_columns_own_edge():
    free = context((Plane("floor", "y", 0.0, "above"),))
    frame = block(4, 2)
    shifted = make_frame(0, 0.0, frame.box, {**frame.columns, "x": frame.x + 7.0})
    history = tracked([shifted], free)
    assert history.back == pytest.approx(7.0)
    assert history.bulk[0] == pytest.approx(4.0)


def test_what_runs_the_other_way_is_no_part_of_a_front_without_a_wall():
    """A column of 4 × 2 discs and two discs on either side, 2 m away: the bulk and 99 % of it lie to the right."""
    free, frame = context((Plane("floor", "y", 0.0, "above"),)), block(4, 2)
    left = frame.x.min()
    ran = np.concatenate([frame.x + (frame.x - left > 3.9), [left - 2.0, left - 2.1]])
    columns = {"x": ran, "y": np.append(frame.y, [0.1, 0.1])}
    history = tracked([frame, disc_frame(columns["x"], columns["y"], box=frame.box)], free)
    assert history.bulk[1] >= history.bulk[0] - 0.2 and history.quantile[1] >= history.bulk[1]


def test_a_column_up_to_the_end_of_the_domain_has_no_way_before_it():
    history = made_history(np.zeros(1), np.full(1, 100.0), np.ones(1), (100.0, 1.0))
    assert np.isnan(way(context(), history, 100.0).length)


def test_a_slope_that_levels_out_is_no_obstacle():
    chute = Line("chute", points=((0, 10), (22, 0), (90, 0)))
    found = numbers(on_a_bed(chute))
    assert found["free_length"] == pytest.approx(22, abs=0.1) and found["arrival_time"] is None
    assert "levels out" in found["reason"]
    rises = Line("rises", points=((0, 0), (22, 0), (90, 10)))
    assert numbers(on_a_bed(rises))["arrival_time"] == pytest.approx(2.0, abs=0.06)


def test_unequal_discs_end_at_their_own_edges():
    """Three in a row and one on the first; nominal discs have a radius of 0.1 m."""
    x, y, radius = (np.array(v) for v in ([2.15, 2.4, 2.6, 2.15], [0.15, 0.1, 0.05, 0.35], [0.15, 0.1, 0.08, 0.05]))
    row = disc_frame(x, y, 1.0, box=[[-1, 100], [-1, 40]], radius=radius)
    walls = context(sized=True), context((Plane("floor", "y", 0.0, "above"),), sized=True), context((), sized=True)
    for flow, back in zip(walls, (0.0, 2.0, 2.0), strict=True):
        history = tracked([row], flow)
        assert history.back == pytest.approx(back)
        assert history.bulk[0] == pytest.approx(2.68 - back)
    assert np.isnan(history.height[0]) and np.isnan(history.column[1])  # no floor: the height above it is not known
    assert history.quantile[0] == pytest.approx(0.68, abs=0.01)


def test_no_common_range_gives_no_number():
    assert np.isnan(rms(off_curve(np.array([0.0, 0.1]), np.array([1.0, 1.0]), [2.0, 3.0], [1.0, 1.0])))
    assert np.isnan(rms(off_curve(np.array([0.0]), np.array([np.nan]), [0.0], [1.0])))
    assert off_curve(np.array([0.0, 2.0]), np.array([1.0, 3.0]), [0.0, 1.0], [2.0, 1.0], beyond=0.5) == [1.0]


def test_a_column_of_discs_larger_than_the_nominal_one_has_its_height():
    """Discs of 0.2 and 0.5 m; the nominal one has 0.2 m, and 0.5 m are more than two of it."""
    sizes = np.array([0.2] + [0.5] * 4)
    y = np.cumsum(sizes) - 0.5 * sizes
    x = np.concatenate([[0.1], np.full(4, 0.25), np.full(5, 0.75)])
    columns = {"radius": 0.5 * np.concatenate([sizes, sizes])}
    frame = disc_frame(x, np.concatenate([y, y]), box=[[-1, 100], [-1, 40]], **columns)
    history = tracked([frame], context(sized=True))
    assert history.column == pytest.approx((1.0, 2.2)) and history.height[0] == pytest.approx(2.2)


def test_a_flow_that_discs_enter_has_no_column():
    frames = [block(4, 2), block(5, 2, step=1, time=0.1)]
    found = numbers(analyse_front(tracked(frames, context()), context()))
    assert found["position"] == pytest.approx(5) and found["column_base"] is found["column_depth"] is None
    assert found["ritter"] is found["martin_moyce"] is None


@pytest.mark.parametrize("water", [False, True])
def test_water_is_compared_with_where_that_is_asked_for_alone(water):
    """A column of n² = 2, of which water's tables could say something."""
    time, flow = np.linspace(0.05, 3, 60), context(water=water)
    front = analyse_front(made_history(time, 4 + 10 * time, 8 * np.exp(-time), (4.0, 8.0)), flow)
    found = {"front": numbers(front)}
    assert found["front"]["ritter"]["front_speed"] == pytest.approx(2 * sqrt(8 * G))
    assert verdict(found).startswith("A column collapses: its front runs at 10 m/s")
    drawn = figures(front, Gathered(flow, None, None, {}, {}))
    boxes = tiles(rows_of([found]))
    shown = [verdict(found), headline(found), *(f"{box.label} {box.value} {box.against}" for box in boxes)]
    shown += [str(label) for label, _ in section(front).blocks[0].rows]
    shown += [line.label for line in drawn["front"].panels[0].lines]
    assert any("10" in box.value for box in boxes)
    for name in ("Ritter", "Martin & Moyce"):
        assert any(name in text for text in shown) is water
    assert (drawn["martin_moyce"] is not None) is water


def test_a_column_is_what_a_dump_without_a_jump_is_about():
    front = {"position": 9.2, "time": 3.0, "speed": 3.6, "column_base": 2.0, "column_depth": 4.0}
    jump = {"verdict": "no jump found", "headline": "No hydraulic jump to compare with Bélanger: no jump found."}
    assert verdict({"jump": jump, "front": front}) == "A column collapses: its front runs at 3.6 m/s."
    assert "jump" not in headline({"jump": jump, "front": front})
    still = {**front, "speed": None}
    assert verdict({"jump": jump, "front": still}) == "The front of the discs is at 9.2 m after 3 s."
    assert verdict({"jump": jump, "front": still, "inflow": {}}) == "No hydraulic jump."
    assert "collapsed" not in headline({"jump": jump, "front": still})
    assert "jump" in verdict({"jump": {**jump, "verdict": "jump"}, "front": front})


@pytest.mark.parametrize(("end", "stop"), [(3.0, None), (5.4, None), (6.0, "the end of the domain")])
def test_a_front_that_has_come_to_the_end_of_the_domain_says_so(end, stop):
    column, run = columns_of_discs(10, 0.0, 2.0), columns_of_discs(3, 0.0, end)
    flow = flow_context(
        domain=((-1.0, 6.0), (-1.0, 40.0)), x_range=(0.0, 6.0),
        walls=(Plane("back", "x", 0.0, "above"), Plane("floor", "y", 0.0, "above")),
    )  # fmt: skip
    box = [[-1, 6], [-1, 40]]
    frames = [disc_frame(*column, box=box), disc_frame(*run, box=box, step=1, time=1.0)]
    assert analyse_front(collected(FrontTracker(flow), frames), flow).stopped_by == stop
