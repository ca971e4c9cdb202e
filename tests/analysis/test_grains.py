# SPDX-License-Identifier: GPL-2.0-or-later
"""Layers, heaps and rest, on made-up discs with known answers."""

from __future__ import annotations

from dataclasses import replace
from math import atan, degrees, pi, sqrt

import numpy as np
import pytest
import xarray as xr
from made_up import collected, columns_of_discs, disc_frame, flow_context, numbers

from lammps_jump.analysis.grains import heap, layers, rest, state
from lammps_jump.analysis.passes import Gathered
from lammps_jump.analysis.tables import rows_of
from lammps_jump.analysis.verdicts import doubts, headline, verdict
from lammps_jump.errors import DumpError
from lammps_jump.physics import devices
from lammps_jump.scene.motion import Motion, MovingWall
from lammps_jump.scene.scene import Outlet
from lammps_jump.scene.tracks import Oscillate, Translate
from lammps_jump.scene.walls import Block, Box, Plane

D, MASS, G, STIFFNESS = 0.2, 40.0, 9.81, 1e9
ROOM = {"domain": ((-8.0, 8.0), (-1.0, 4.0)), "x_range": (-8.0, 8.0)}
FLOOR = Plane("floor", "y", 0.0, "above")


def flow_of(**given):
    return flow_context(**ROOM, **{"stiffness": STIFFNESS, "walls": [FLOOR], **given})


def gathered(flow, **histories) -> Gathered:
    profiles = xr.Dataset(attrs={"window_begin": 0.0, "window_end": 100.0})
    return Gathered(flow, profiles, None, histories, {})


def profile(flow, frames):
    sums = collected(layers.LayerSums(flow), frames)
    found = layers.analyse(gathered(flow, layers=sums))
    return found, found.profile


def lattice(rows=6, columns=10):
    """Discs in upright columns that touch, each pressed together by the weight above; from -1 to 1 m."""
    weights = MASS * G * np.arange(rows, 0, -1)  # on the contact below each row
    gaps = np.concatenate([[0.5 * D], np.full(rows - 1, D)]) - weights / STIFFNESS
    x = -1.0 + D * (np.arange(columns) + 0.5)
    return np.tile(x, rows), np.repeat(np.cumsum(gaps), columns)


LATTICE = {"layers": ((-0.8, 0.8), D)}


def test_a_lattice_at_rest_bears_the_weight_above():
    found, made = profile(flow_of(**LATTICE), [disc_frame(*lattice(), box=ROOM["domain"])])
    # discs are pressed together by 1e-6 of a diameter a row
    above = (6 - np.arange(6) - 0.5) * MASS * G / D
    assert made.stress_yy == pytest.approx(above, rel=1e-4)
    assert made.packing == pytest.approx(pi / 4, rel=1e-4)
    assert found.pressure == pytest.approx(above[0], rel=1e-4) and found.layers == 6
    # upright columns that touch: what rounding presses together is next to nothing
    assert made.stress_xx == pytest.approx(0, abs=1e-4 * above[0])
    assert made.stress_xy == pytest.approx(0, abs=1e-6 * above[0])
    assert made.contact_share == pytest.approx(1.0)
    assert made.temperature == pytest.approx(0) and made.shear_rate == pytest.approx(0)


def test_linear_shear_has_one_rate_and_no_temperature():
    x, y = lattice()
    found, made = profile(flow_of(**LATTICE), [disc_frame(x, y, 3.0 + 2.0 * y, box=ROOM["domain"])])
    assert made.shear_rate == pytest.approx(2.0, rel=1e-9)
    assert made.velocity == pytest.approx(3.0 + 2.0 * made.y, abs=1e-4)
    assert made.temperature == pytest.approx(0, abs=1e-12)
    assert made.inertial_number == pytest.approx(2.0 * D * np.sqrt(1000.0 / made.stress_yy))  # m = rho d^2
    assert found.inertial_number > 0 and found.fastest == pytest.approx(made.velocity[-1])


def test_fluctuations_are_temperature_and_stress():
    """Half of the discs are faster by w along x and y, half slower: T = w^2, and m w^2 a disc goes to the stress."""
    x, y = lattice()
    away = np.where(np.arange(len(x)) % 2, 0.3, -0.3)
    flow = flow_of(layers=((-0.8, 0.8), D), stiffness=float("nan"))
    frame = disc_frame(x, y, 2.0 * y + away, away, box=ROOM["domain"])
    found, made = profile(flow, [frame])
    assert made.temperature == pytest.approx(0.09, rel=1e-6)
    assert "stiffness" in found.reason and np.isnan(made.stress_yy).all()
    found, made = profile(replace(flow, scene=flow_of().scene), [frame])
    assert made.stress_xx == pytest.approx(MASS / D**2 * 0.09, rel=1e-2)  # a disc in D^2
    assert made.stress_xy == pytest.approx(-MASS / D**2 * 0.09, rel=1e-2)


def test_layers_of_mirrored_discs_of_several_sizes():
    random = np.random.default_rng(2)
    x, y, u, v = random.uniform(-3, 3, 80), random.uniform(0.15, 1.5, 80), *random.normal(0, 1, (2, 80))
    radius = random.uniform(0.05, 0.15, 80)
    flow = flow_of(sized=True, layers=((-4.0, 4.0), 0.3), friction=0.5, gamma_tangential=50.0, dashpot=200.0)
    pictures = (disc_frame(sign * x, y, sign * u, v, radius=radius, box=ROOM["domain"]) for sign in (1, -1))
    one, other = (profile(flow, [picture])[1] for picture in pictures)
    for name, sign in {"velocity": -1, "stress_xy": -1, "packing": 1, "stress_yy": 1, "temperature": 1}.items():
        ours, theirs = getattr(one, name), getattr(other, name)
        assert ours == pytest.approx(sign * theirs, rel=1e-9, abs=1e-9 * np.abs(ours).max()), name
    # the whole of every disc is in some layer
    assert one.packing.sum() * 8.0 * 0.3 == pytest.approx(pi * np.sum(radius**2))


def test_layers_without_discs_and_too_many_layers():
    flow = flow_of()
    found, _ = profile(flow, [disc_frame([7.0], [0.1], box=ROOM["domain"])])
    assert "no disc" in found.reason and (found.begin, found.end) == (-4.0, 4.0)
    assert layers.tables(found) == {} and layers.figures(found, None) == {}
    assert not layers.section(found).blocks
    with pytest.raises(DumpError, match=r"analysis.layers.height = 1e-06 m makes 4000000 layers"):
        layers.LayerSums(flow_of(layers=(None, 1e-6)))


def heap_of(flow, frames, **histories):
    left = collected(heap.HeapWatch(flow), frames)
    made = gathered(flow, heap=left, **histories)
    return heap.analyse(made), made


def slope(x):
    """Rows of discs of a heap that falls by 0.5 to the left and by 0.25 to the right of x = 0."""
    return 10 - np.where(x < 0, -0.5 * x, 0.25 * x) / D


@pytest.mark.parametrize("sign", [1, -1])
def test_flanks_of_a_heap(sign):
    """Rows are whole discs: the lines are off by a fraction of a degree, and their intervals hold the true slopes."""
    x, y = columns_of_discs(slope, -4.0, 8.0)
    # more discs in the second frame: poured, no column
    found, made = heap_of(flow_of(), [disc_frame(sign * x[:n], y[:n], box=ROOM["domain"], time=n) for n in (1, len(x))])
    steep, flat = ("left", "right")[::sign]
    for side, fall in ((steep, 0.5), (flat, 0.25)):
        angle, interval = getattr(found, f"angle_{side}"), getattr(found, f"angle_{side}_interval")
        assert angle == pytest.approx(degrees(atan(fall)), abs=1.0)
        assert abs(angle - degrees(atan(fall))) < 1.5 * interval < 4.0
    assert found.angle == pytest.approx(0.5 * (found.angle_left + found.angle_right))
    assert found.height == pytest.approx(2.0) and abs(found.top) < 0.5
    assert (sign * getattr(found, steep), sign * getattr(found, flat)) == pytest.approx((-4.0, 7.8), abs=0.21)
    assert np.isnan(found.base) and found.at_rest is None
    said = verdict({"heap": numbers(found)})
    assert said == "A heap of 2.0 m stands, its flanks slope at 20 degrees."
    assert said in headline({"heap": numbers(found)})
    assert heap.figures(found, made)["heap"] is not None


def test_a_tilted_gravity_tilts_the_angles():
    x, y = columns_of_discs(slope, -4.0, 8.0)
    frame = disc_frame(x, y, box=ROOM["domain"])
    level, _ = heap_of(flow_of(), [frame])
    tilted, _ = heap_of(flow_of(gravity=(G * np.sin(0.1), -G * np.cos(0.1))), [frame])
    assert tilted.angle_right - level.angle_right == pytest.approx(degrees(0.1))
    assert tilted.angle_left - level.angle_left == pytest.approx(-degrees(0.1))


@pytest.mark.parametrize("sign", [1, -1])
def test_run_out_of_a_column_that_leans_on_a_wall(sign):
    """A column of 2 m and 2 m falls along 6 m; one disc in 200 flies ahead: it is no part of the bulk."""
    wall = Plane("back", "x", 0.0, "above" if sign > 0 else "below")
    column = columns_of_discs(10, 0.0, 2.0)
    x, y = columns_of_discs(lambda x: np.maximum(1, 5 - x / 1.2), 0.0, 6.0)
    x, y = np.append(x, 7.5)[: len(column[0])], np.append(y, 0.1)[: len(column[0])]
    ids = {"id": np.arange(len(x)) + 1}
    frames = [
        disc_frame(sign * column[0], column[1], box=ROOM["domain"]),
        disc_frame(sign * x, y, box=ROOM["domain"], step=1, time=5.0, **ids),
    ]
    flow = flow_of(walls=[FLOOR, wall])
    found, _ = heap_of(flow, frames, rest=rest.RestHistory(*np.zeros((3, 1)), 4.0))
    assert (found.base, found.aspect) == (pytest.approx(2.0), pytest.approx(1.0))
    assert found.run_out == pytest.approx(4.0) and found.run_out_over_base == pytest.approx(2.0)
    assert 3.5 < found.run_out_99 < 5.6 and found.at_rest
    assert (found.discs, found.sand, found.rods) == pytest.approx((2.5, 1.2, 3.25))
    assert found.height_rods == pytest.approx(1 / 1.42) and np.isnan(found.shape_off)
    summary = {"heap": numbers(found)}
    assert verdict(summary).startswith("The column has run out 2.0 times its base and is at rest")
    rows = rows_of([summary])
    assert [row.held for row in rows[:3]] == ["heap.rods", "heap.sand", "heap.height_rods"]
    assert rows[0].difference.value == pytest.approx(2.0 / 3.25 - 1)


STOPS = {
    "wall 'far'": {"walls": [FLOOR, Plane("far", "x", 6.0, "below")]},
    "a step of the bed": {"walls": [FLOOR, Block("quay", (6.0, 7.0), (-1.0, 2.0))]},
    "an outlet": {"outlets": (Outlet("x", 6.0, "above", 1),)},
    "the end of the domain": {"domain": ((-8.0, 6.0), (-1.0, 4.0))},
}
MIRRORED = {
    "wall 'far'": {"walls": [FLOOR, Plane("far", "x", -6.0, "above")]},
    "a step of the bed": {"walls": [FLOOR, Block("quay", (-7.0, -6.0), (-1.0, 2.0))]},
    "an outlet": {"outlets": (Outlet("x", -6.0, "below", 1),)},
    "the end of the domain": {"domain": ((-6.0, 8.0), (-1.0, 4.0))},
}


@pytest.mark.parametrize("stop", list(STOPS))
@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("end", [3.0, 5.4, 6.0])
def test_a_run_out_ends_at_no_wall(stop, sign, end):
    """A column of 2 m falls to both sides; at 6 m something stops it: with discs up to there it has no run-out."""
    column = columns_of_discs(10, -1.0, 1.0)
    x, y = columns_of_discs(5, -2.0, end)
    frames = [disc_frame(sign * column[0], column[1], box=ROOM["domain"])]
    frames.append(disc_frame(sign * x, y, box=ROOM["domain"], step=1, time=5.0, id=np.arange(len(x)) % 100 + 1))
    flow = flow_context(**{**ROOM, "stiffness": STIFFNESS, "walls": [FLOOR]} | (STOPS if sign > 0 else MIRRORED)[stop])
    found, made = heap_of(flow, frames)
    touches = end == 6.0
    assert np.isnan(found.run_out) == touches and np.isnan(found.rods) == touches
    assert found.no_run_out == (f"the discs have come to {stop}" if touches else None)
    assert getattr(found, "right_at" if sign > 0 else "left_at") == (stop if touches else None)
    assert found.base == pytest.approx(1.0)  # what it was is told all the same
    summary = {"heap": numbers(found)}
    assert verdict(summary).startswith("A bed" if touches else "The column has run out")
    assert any("There is no run-out" in text for text in doubts(summary)) == touches
    assert any("There is no run-out" in block[0] for block in heap.section(found).blocks) == touches
    assert heap.figures(found, made)


def test_a_dump_that_fills_its_box_from_wall_to_wall_has_no_run_out():
    """A column of 2 m at the left end of a box of 8 m, whose discs lie from end to end later."""
    room = {"domain": ((0.0, 8.0), (0.0, 4.0)), "x_range": (0.0, 8.0)}
    walls = [Box("box", (0.0, 8.0), (0.0, 4.0))]
    column, (x, y) = columns_of_discs(16, 0.0, 2.0), columns_of_discs(4, 0.0, 8.0)
    frames = [disc_frame(*column, box=room["domain"]), disc_frame(x, y, box=room["domain"], step=1, time=5.0)]
    found, _ = heap_of(flow_context(**room, stiffness=STIFFNESS, walls=walls), frames)
    assert np.isnan(found.run_out_over_base) and np.isnan(found.run_out_99)
    assert (found.left_at, found.right_at) == ("wall 'box'", "wall 'box'")
    assert verdict({"heap": numbers(found)}) == "A bed of 0.80 m stands."


def test_discs_that_1_per_cent_of_reach_a_wall_have_no_run_out_either():
    """The bulk ends at 4 m, and two of a hundred discs lie at the wall at 6 m."""
    column = columns_of_discs(10, 0.0, 2.0)
    x, y = columns_of_discs(5, 0.0, 4.0)
    x, y = np.append(x[:98], [5.7, 5.9]), np.append(y[:98], [0.1, 0.1])
    frames = [disc_frame(*column, box=ROOM["domain"]), disc_frame(x, y, box=ROOM["domain"], step=1, time=5.0)]
    walls = [FLOOR, Plane("back", "x", 0.0, "above"), Plane("far", "x", 6.0, "below")]
    found, _ = heap_of(flow_of(walls=walls), frames)
    assert found.right_at is None and found.no_run_out == "the discs have come to wall 'far'"


def test_a_column_that_falls_to_both_sides_and_a_published_shape():
    """Aspect 1.4 of half its base: its shape is held against discs by contact dynamics."""
    column = columns_of_discs(14, -2.0, 2.0)
    frames = [disc_frame(*column, box=ROOM["domain"])]
    found, made = heap_of(flow_of(), frames)
    assert (found.base, found.aspect, found.run_out) == pytest.approx((2.0, 1.4, 0.0), abs=1e-9)
    away, theirs = np.array([0.0, 0.5, 1.0, 1.5, 2.0, 3.0]), np.array([0.73, 0.63, 0.51, 0.42, 0.31, 0.16])
    ours = np.where(away < 1.0, 1.4, 0.0)
    ours[2] = 0.7  # between the last bin with discs and the first without
    assert found.shape_off == pytest.approx(np.sqrt(np.mean((ours - theirs) ** 2)), abs=0.02)
    assert "discs by contact dynamics" in [line.label for line in heap.figures(found, made)["heap"].panels[0].lines]
    # a disc that comes in later: nothing fell
    more = disc_frame([0.0], [3.5], box=ROOM["domain"], time=1.0, id=np.array([9999]))
    assert np.isnan(heap_of(flow_of(), [*frames, more])[0].base)


def test_what_is_no_heap():
    nothing, made = heap_of(flow_of(), [disc_frame([], [], box=ROOM["domain"])])
    assert "no frame" in nothing.reason and heap.tables(nothing) == {} and heap.figures(nothing, made) == {}
    floating, _ = heap_of(flow_of(), [disc_frame([0.0], [3.0], box=ROOM["domain"])])
    assert "no disc lies on the bed" in floating.reason
    weightless, _ = heap_of(flow_of(gravity=(0.0, 0.0)), [disc_frame([0.0], [0.1], box=ROOM["domain"])])
    assert "needs gravity" in weightless.reason and verdict({"heap": numbers(weightless)}) == ""


@pytest.mark.parametrize(
    ("aspect", "sand", "rods", "height"),
    [(0.5, 0.6, np.nan, 0.5), (1.0, 1.2, 3.25, 1 / 1.42), (2.5, np.nan, 3.8 * 2.5**0.73, 2.5 ** (1 / 3) / 1.42),
     (8.0, 7.6, 3.8 * 8**0.73, 2 / 1.42)],
)  # fmt: skip
def test_published_run_outs(aspect, sand, rods, height):
    found = devices.run_out_of_sand(aspect), devices.run_out_of_rods(aspect), devices.height_of_rods(aspect)
    assert found == pytest.approx((sand, rods, height), nan_ok=True)
    assert devices.run_out_of_discs(aspect) == pytest.approx(2.5 * aspect if aspect < 2 else np.nan, nan_ok=True)
    assert devices.creep_speed(G, 30.0, 100.0) == pytest.approx(0.5 * G / 100.0)


def fed(detector, until=10.0, speed=0.0, top=1.0, discs=(5, 5), begin=0.0):
    """First time at which a detector is content with frames every 0.1 s; a number or a function of time each."""
    at = [value if callable(value) else (lambda _, value=value: value) for value in (speed, top, discs)]
    times = np.round(np.arange(begin, until, 0.1), 9)
    return next((time for time in times if detector.feed(time, *(value(time) for value in at))), None)


def test_rest_is_found():
    span, scale = rest.SPAN * sqrt(D / G), sqrt(G * D)

    def detector(begin=0.0):
        return rest.RestDetector(G, D, begin)

    def after(time):
        return pytest.approx(time + span, abs=0.1 + 1e-9)

    assert fed(detector()) == after(0.0)
    assert fed(detector(), speed=lambda t: scale * (0.02 if t < 3 else 0.009)) == after(3.0)
    assert fed(detector(), speed=0.011 * scale) is None
    assert fed(detector(), speed=float("nan")) is None
    # a gate opens, a disc comes in, a disc leaves, the top sinks until then
    assert fed(detector(begin=2.0)) == after(2.0)
    assert fed(detector(), discs=lambda t: (6, 6) if t >= 2 else (5, 5)) == after(2.0)
    assert fed(detector(), discs=lambda t: (4, 5) if t >= 2 else (5, 5)) == after(2.0)
    assert fed(detector(), top=lambda t: 1 - 0.1 * min(t, 5.0), until=9.0) == pytest.approx(5.0 + span, abs=0.3)
    assert fed(rest.RestDetector(0.0, D)) is None


def test_frames_far_apart_are_counted():
    detector = rest.RestDetector(G, D)
    assert [detector.feed(time, 0.0, 1.0, (5, 5)) for time in (0.0, 50.0, 100.0, 150.0)] == [False] * 3 + [True]


def test_rest_begins_once_gates_and_walls_have_had_their_turn():
    def begin(*motions):
        walls = [MovingWall(Block(f"w{k}", (0, 1), (0, 1)), motion) for k, motion in enumerate(motions)]
        return rest.begin_of(flow_of(walls=walls, steps=100, time_step=1e-3, settle_steps=10).scene)

    assert begin() == 0.0
    assert begin(Motion(gone=60.0)) == pytest.approx(50 * 1e-3)
    assert begin(Motion(kind=Translate((1.0, 0.0), begin=2.0, until=3.0))) == 3.0
    assert begin(Motion(kind=Oscillate(1.0, (0.5, 0.0), begin=4.0))) == 4.0


def test_rest_of_frames():
    flow = flow_of()
    x, y = lattice()
    times = np.arange(0.0, 9.95, 0.1)
    frames = [disc_frame(x, y, 0.5 if time < 2 else 0.0, box=ROOM["domain"], time=time) for time in times]
    history = collected(rest.RestWatch(flow), frames)
    found = rest.analyse(gathered(flow, rest=history))
    assert found.time == pytest.approx(2.0) and found.speed == 0.0 and found.sinking == pytest.approx(0.0)
    assert found.top == pytest.approx(1.2, abs=1e-4) and found.reason is None
    assert set(rest.tables(found)["rest.csv"]) == {"time", "median_speed", "top"}
    assert rest.figures(found, gathered(flow))["rest"] is not None and len(rest.section(found).blocks) == 2
    moving = rest.analyse(gathered(flow, rest=collected(rest.RestWatch(flow), frames[:5])))
    assert np.isnan(moving.time) and "still move" in moving.reason
    early = rest.analyse(gathered(flow, rest=collected(rest.RestWatch(flow), frames[:25])))
    assert "the record is shorter than the 20" in early.reason and np.isnan(early.sinking)
    later = rest.analyse(gathered(flow, rest=collected(rest.RestWatch(flow), frames[:35])))
    assert "they moved, or their top or number changed" in later.reason and later.sinking == pytest.approx(0.0)
    empty = rest.analyse(gathered(flow, rest=collected(rest.RestWatch(flow), [disc_frame([], [], box=ROOM["domain"])])))
    assert "no frame" in empty.reason and rest.figures(empty, gathered(flow)) == {}
    assert not rest.section(empty).blocks
    assert "gravity" in rest.analyse(gathered(flow_of(gravity=(0.0, 0.0)), rest=history)).reason


def test_a_record_too_short_to_tell_says_nothing_of_rest():
    """At rest, still moving, or not told: the three are apart in the state, the heap and the reason."""
    x, y = columns_of_discs(lambda centres: 0 * centres + 3, -1.0, 1.0)
    span = rest.SPAN * sqrt(D / G)

    def told(speed, end, count=20, flow=None):
        flow = flow or flow_of()
        frames = [disc_frame(x, y, speed, box=ROOM["domain"], time=k * end / (count - 1)) for k in range(count)]
        watch, history = (collected(kind(flow), frames) for kind in (state.StateWatch, rest.RestWatch))
        found = state.analyse(gathered(flow, state=watch))
        assert heap_of(flow, frames, rest=history)[0].at_rest is found.at_rest
        return found.at_rest, rest.analyse(gathered(flow, rest=history)).reason, verdict({"state": numbers(found)})

    still, moves = 0.0, 0.5
    assert told(still, 1.1 * span)[:2] == (True, None)
    assert told(moves, 1.1 * span)[0] is False and told(moves, 0.5 * span)[0] is False
    for end, count in ((0.5 * span, 20), (2.0 * span, 3)):
        rests, reason, said = told(still, end, count)
        assert rests is None and "shorter than" in reason and "are slow, 0.0 m/s" in said
    gate = MovingWall(Block("gate", (2.0, 2.2), (0.0, 2.0)), Motion(gone=1000))
    shut = flow_of(walls=[FLOOR, gate], steps=10_000, time_step=1e-3, settle_steps=0)
    assert told(still, 1.1 * span, flow=shut)[0] is None  # it opens after 1 s: the rest before does not count
