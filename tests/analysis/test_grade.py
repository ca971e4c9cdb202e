# SPDX-License-Identifier: GPL-2.0-or-later
"""The energy grade line on made-up streams with known heads."""

from types import SimpleNamespace

import numpy as np
import pytest
from made_up import columns_of_discs, disc_frame, flow_context

from lammps_jump.analysis.budgets import grade
from lammps_jump.analysis.profiles import compute_profiles
from lammps_jump.dump.frame import make_frame
from lammps_jump.scene.motion import Motion, MovingWall
from lammps_jump.scene.tracks import Translate
from lammps_jump.scene.walls import Block, Plane

D, G = 0.2, 9.81
FLOOR = (Plane("floor", "y", 0.0, "above"),)
BOX = [[-1, 30], [-1, 20]]


def stream(parts, frames=20, drift=lambda k: 1.0):
    """Frames of columns of discs: (from x, to x, layers, bed, speed along x, speed along y)."""
    result = []
    for k in range(frames):
        columns = [(*columns_of_discs(n, low, high, d=D, bed=bed), u, v) for low, high, n, bed, u, v in parts]
        x, y = (np.concatenate([part[i] for part in columns]) for i in (0, 1))
        u, v = (np.concatenate([0 * part[0] + part[i] for part in columns]) for i in (2, 3))
        result.append(disc_frame(x, y, drift(k) * u, drift(k) * v, box=BOX, step=k, time=0.1 * k))
    return result


def grade_of(frames, walls=FLOOR, **flow):
    given = {"domain": ((-1.0, 30.0), (-1.0, 20.0)), "x_range": (0.0, 20.0), "window": (0.0, 5.0)}
    context = flow_context(**given | {"walls": walls, "stiffness": 1e6, "time_step": 0.1} | flow)
    return grade.analyse(SimpleNamespace(flow=context, profiles=compute_profiles(frames, context)))


def test_a_uniform_stream_loses_no_head():
    found = grade_of(stream([(0.0, 20.0, 5, 0.0, 4.0, 0.0)]))
    head = 1.0 + 4.0**2 / (2 * G)
    assert (found.head_upstream, found.head_downstream) == pytest.approx((head, head), rel=1e-9)
    assert found.lost == pytest.approx(0, abs=1e-9) and found.reason is None
    assert (found.upstream, found.downstream) == pytest.approx((0.5, 19.5))


@pytest.mark.parametrize("towards", [1, -1])
def test_heads_of_two_states(towards):
    """1 m at 6 m/s becomes 3 m at 2 m/s: its head rises from 2.83 to 3.20 m (made up), whichever way it runs."""
    fast, slow = (5, 6.0), (15, 2.0)
    left, right = (fast, slow) if towards > 0 else (slow, fast)
    parts = [(0.0, 10.0, left[0], 0.0, towards * left[1], 0.0), (10.0, 20.0, right[0], 0.0, towards * right[1], 0.0)]
    found = grade_of(stream(parts), heads_at=(5.5, 15.5))
    heads = 1.0 + 36 / (2 * G), 3.0 + 4 / (2 * G)
    assert (found.head_upstream, found.head_downstream) == pytest.approx(heads, rel=1e-9)
    assert found.lost == pytest.approx(heads[0] - heads[1], rel=1e-9)
    assert found.upstream == (5.5 if towards > 0 else 15.5)
    assert found.between(found.upstream, found.downstream).lost == found.lost


@pytest.mark.parametrize("begin", [0.0, 0.8])
def test_a_sill_that_has_moved_is_bed_where_it_is(begin):
    """A sill below a stream of one depth goes 10 m, before the window or in it: heads are those of its place."""
    motion = Motion(kind=Translate((10.0, 0.0), begin=begin, until=begin + 1.0), time_step=0.1)
    lows = [3.0 + min(max(k - round(10 * begin), 0), 10) for k in range(20)]
    frames = []
    for k, low in enumerate(lows):
        parts = [(0.0, low, 5, 0.0, 4.0, 0.0), (low, low + 2, 5, 0.4, 4.0, 0.0), (low + 2, 20.0, 5, 0.0, 4.0, 0.0)]
        frames += stream(parts, k + 1)[k:]
    found = grade_of(frames, (*FLOOR, MovingWall(Block("sill", (3, 5), (0, 0.4)), motion)), window=(1.0, 1.9))
    share = np.mean([(found.line.x > low) & (found.line.x < low + 2) for low in lows[10:]], axis=0)
    assert found.line.head == pytest.approx(1.0 + 16 / (2 * G) + 0.4 * share, rel=1e-9)
    assert found.line.bed == pytest.approx(0.4 * share, abs=1e-12)


def test_a_free_jet_has_no_pressure():
    """Discs 2 m above the bed: their head is the height of their centres and v^2/2g."""
    found = grade_of(stream([(0.0, 20.0, 5, 2.0, 4.0, -3.0)]))
    assert found.head_upstream == pytest.approx(2.5 + (16 + 9) / (2 * G), rel=1e-9)


def test_a_step_of_the_bed_is_in_the_head():
    step = Block("step", (-1.0, 10.0), (-1.0, 2.0))
    parts = [(0.0, 10.0, 5, 2.0, 4.0, 0.0), (10.0, 20.0, 5, 0.0, 4.0, 0.0)]
    found = grade_of(stream(parts), (*FLOOR, step), gauges=(4.5, 8.5, 15.5))
    assert [station.x for station in found.stations] == [4.5, 8.5, 15.5]
    assert [station.lost for station in found.stations][1:] == pytest.approx([0.0, 2.0], abs=1e-9)
    assert found.lost == pytest.approx(2.0)
    assert set(grade.figures(found, None)) == {"energy_head"} and "lost" in grade.tables(found)["grade.csv"]
    table = grade.section(found).blocks[0]
    assert len(table.rows) == 3 and table.rows[0][-1] != table.rows[2][-1]


def test_what_is_stored_is_no_loss():
    """A bore of 2 m that runs upstream at 2 m/s stores half of the discharge: no head lost is told, and why."""
    parts = (([(0.0, 16.0 - 0.2 * k, 5, 0.0, 4.0, 0.0), (16.0 - 0.2 * k, 20.0, 10, 0.0, 1.0, 0.0)]) for k in range(20))
    frames = [stream(part, 1)[0] for part in parts]
    frames = [make_frame(k, 0.1 * k, one.box, one.columns) for k, one in enumerate(frames)]
    found = grade_of(frames)
    assert np.isnan(found.lost)
    assert "the flow is not steady in the window, and what it stores (2 m2/s) is no loss" in found.reason
    outside = grade_of(stream([(0.0, 12.0, 5, 0.0, 4.0, 0.0)]), heads_at=(2.5, 18.5))
    assert outside.reason == "no stream runs at x = 18.5 m in the window; take another station"


def test_a_stream_that_discs_leave_is_not_called_unsteady():
    """Half of the discharge leaves through the floor at x = 10 m: nothing is stored."""
    found = grade_of(stream([(0.0, 10.0, 5, 0.0, 4.0, 0.0), (10.0, 20.0, 5, 0.0, 2.0, 0.0)]))
    assert np.isnan(found.lost) and "discs come or go there" in found.reason and "steady" not in found.reason


@pytest.mark.parametrize("speed", [0.0, 1e-3])
def test_where_no_stream_runs_there_is_no_grade_line(speed):
    found = grade_of(stream([(0.0, 20.0, 5, 0.0, speed, 0.0)]))
    assert found.line is None and found.reason == "no stream runs along the bed in the window"
    assert grade.figures(found, None) == {} and grade.tables(found) == {}


def test_a_pour_is_no_stream():
    """Discs that fall at 4 m/s and drift at 0.5 m/s."""
    found = grade_of(stream([(0.0, 20.0, 5, 0.0, 0.5, -4.0)]))
    assert found.line is None and found.reason == "discs move every way in the window, and not along the bed"


def test_an_unsteady_stream_has_an_error():
    found = grade_of(stream([(0.0, 10.0, 5, 0.0, 4.0, 0.0), (10.0, 20.0, 10, 0.0, 2.0, 0.0)], 64,
                            lambda k: 1 + 0.1 * np.sin(k)), window=(0.0, 10.0))  # fmt: skip
    assert 0 < found.lost_error < 0.05
