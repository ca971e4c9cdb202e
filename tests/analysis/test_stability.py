# SPDX-License-Identifier: GPL-2.0-or-later
"""Factors of safety of blocks that known forces push, against closed forms."""

from dataclasses import replace
from math import cos, degrees, nan, radians, sin, tan

import numpy as np
import pytest
from free_bodies import TIME, body, history_of, ramp
from made_up import flow_context

from lammps_jump.analysis.devices.stability import (
    KEYS,
    QUANTITY,
    Stability,
    body_loads,
    figures,
    found_of,
    line,
    section,
    summary,
    tables,
    wall_loads,
)
from lammps_jump.analysis.tables import rows_of
from lammps_jump.dump.find import ForceHistory
from lammps_jump.physics.bodies import bearing_pressures, eccentricity
from lammps_jump.scene.motion import MovingWall
from lammps_jump.scene.scene import WallWeight
from lammps_jump.scene.walls import Block, Circle, Plane, Polygon

G = 9.81
WINDOW = (7.5, 10.0)


def plane(slope=0.0):
    """A floor through the origin, as a long thick block that is turned."""
    if slope == 0.0:
        return Plane("floor", "y", 0.0, "above")
    return Block("floor", (-60.0, 60.0), (-5.0, 0.0), angle=slope, pivot=(0.0, 0.0))


def flow_of(*walls, friction=0.6, **more):
    given = {"domain": ((-50.0, 50.0), (-20.0, 20.0)), "x_range": (-50.0, 50.0), "friction": friction}
    return flow_context(**given | more, walls=walls)


def pushed(history, force, at):
    """The history with a force (N/m, parts may change in time) at a point (m)."""
    fx, fy = (np.zeros(len(TIME)) + part for part in force)
    moment = (at[0] - history.x) * fy - (at[1] - history.y) * fx
    return history._replace(fx=fx, fy=fy, moment=moment)


def of_body(one, history, slope=0.0, flow=None, mean=0.1):
    flow = flow or flow_of(plane(slope), one)
    loads, why = body_loads(flow, one, {one.wall.name: history})
    assert loads is not None, why
    return found_of(loads, WINDOW, mean), why


@pytest.mark.parametrize("density", [500.0, 2400.0])
@pytest.mark.parametrize("friction", [0.1, 0.7])
@pytest.mark.parametrize("width", [0.5, 1.5, 6.0])
@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("lift", [0.0, 0.3, -0.2])
def test_a_block_that_a_known_force_pushes_has_its_limits(density, friction, width, side, lift):
    """mu (W - U) / F, and W b/2 over F a + U b/2, exact: a is the height of the force, U the uplift in the middle."""
    wall = Block("post", (4.0, 4.0 + width), (0.0, 3.5))
    one = body(wall, density=density)
    weight, force, height = density * width * 3.5 * G, 0.3 * density * width * 3.5 * G, 2.1
    found, why = of_body(
        one, pushed(history_of(one), (side * force, lift * weight), (4.0 + 0.5 * width, height)),
        flow=flow_of(plane(), one, friction=friction),
    )  # fmt: skip
    assert not why and found.weight == pytest.approx(weight) and found.base == pytest.approx(width)
    slides = friction * (1 - lift) * weight / force
    over = force * height + lift * weight * 0.5 * width
    tips = weight * 0.5 * width / over if over > 0 else nan
    kinds = ("least", "least_mean")
    assert [getattr(found, f"sliding_factor_{kind}") for kind in kinds] == pytest.approx([slides] * 2, rel=1e-9)
    assert found.sliding_factor == pytest.approx(slides, rel=1e-9)
    if over > 0:
        assert [getattr(found, f"tipping_factor_{kind}") for kind in kinds] == pytest.approx([tips] * 2, rel=1e-9)
        assert found.toe == ("right" if side > 0 else "left")
        assert found.moment_about_toe_peak == pytest.approx(over, rel=1e-9)
        assert found.weight_about_toe == pytest.approx(weight * 0.5 * width, rel=1e-9)
    assert found.sliding_factor_time_below_1 == pytest.approx(10.0 if slides < 1 else 0.0)
    assert found.tipping_factor_time_below_1 == pytest.approx(10.0 if over > 0 and tips < 1 else 0.0)
    off = force * height / ((1 - lift) * weight)
    assert found.eccentricity_peak == pytest.approx(off, rel=1e-9)
    if off >= 0.5 * width:
        assert np.isnan(found.toe_pressure_peak) and "leaves the base" in found.reason


@pytest.mark.parametrize("slope", [-20.0, -5.0, 10.0, 25.0])
@pytest.mark.parametrize("begun", [0.0, 0.7])
def test_on_a_slope_its_weight_drives_a_block(slope, begun):
    """mu/tan(slope) without a force; with one along the base the sum; a body may begin turned, from another run."""
    a = radians(slope)
    along, up = np.array([cos(a), sin(a)]), np.array([-sin(a), cos(a)])
    wall = Block("box", (4.0, 6.0), (0.0, 1.0), angle=slope - degrees(begun))
    one = body(wall)
    weight, centre = 2000.0 * G, np.array(one.motion.free.centre)
    under = centre - 0.5 * up
    floor = Block(
        "floor", (under[0] - 40.0, under[0] + 40.0), (under[1] - 5.0, under[1]), angle=slope, pivot=tuple(under)
    )
    flow = flow_of(floor, one)
    history = history_of(one, angle=begun)
    free, _ = of_body(one, history, flow=flow)
    assert free.sliding_factor_least == pytest.approx(0.6 / abs(tan(a)), rel=1e-6)
    force = 0.2 * weight
    there, _ = of_body(one, pushed(history, force * along, centre), flow=flow)
    drives = force - weight * sin(a)
    assert there.sliding_factor_least == pytest.approx(0.6 * weight * cos(a) / abs(drives), rel=1e-6)
    # over the right toe: the weight has the arm b/2 along the base less that of its height
    holds = weight * (1.0 * cos(a) + 0.5 * sin(a))
    assert there.tipping_factor_least == pytest.approx(holds / (0.5 * force), rel=1e-6) and there.toe == "right"


def test_a_force_that_changes_has_its_time_below_one_and_its_moving_mean():
    """A pulse of 1.3 times the limit for 0.5 s, within windows of 0.025 s; a mean over 1 s sees 0.65 of it."""
    wall = Block("post", (4.0, 6.0), (0.0, 3.5))
    one = body(wall, density=2400.0)
    weight = 2400.0 * 7.0 * G
    limit = 0.6 * weight
    on = (TIME > 3.0) & (TIME <= 3.5)
    history = pushed(history_of(one), (np.where(on, 1.3 * limit, 0.0), 0.0), (4.0, 0.5))
    found, _ = of_body(one, history, mean=1.0)
    assert found.sliding_factor_least == pytest.approx(1 / 1.3)
    assert found.sliding_factor_time_below_1 == pytest.approx(0.5)
    samples = 41
    assert found.sliding_factor_least_mean == pytest.approx(samples / 20 / 1.3)
    assert 3.0 < found.sliding_factor_least_at <= 3.525
    assert np.isnan(found.sliding_factor) and found.reason is None  # nothing pushes in the window of the means


def test_what_stands_no_more_has_no_factor():
    """It topples from 4 s on: later forces count nowhere, and the window of the means has none."""
    wall = Block("post", (4.0, 4.7), (0.0, 3.5))
    one = body(wall)
    toppled = history_of(one, angle=ramp(4.0, 5.0, -np.pi / 2), about=(4.7, 0.0))
    weight = 700.0 * 3.5 * G
    history = pushed(toppled, (np.where(TIME < 4.0, 0.1, 5.0) * weight, 0.0), (4.0, 1.0))
    found, _ = of_body(one, history)
    assert found.sliding_factor_least == pytest.approx(0.6 / 5.0)  # the first instants of its fall, still upright
    assert found.sliding_factor_time_below_1 == pytest.approx(1.0 / 6.0, abs=0.05)  # 15 of 90 degrees in 1 s
    assert np.isnan(found.sliding_factor) and "window of the means" in found.reason
    rows = found.table["time"] > 4.2
    assert np.isnan(found.table["driving_force"][rows]).all()


@pytest.mark.parametrize(
    ("wall", "free", "why"),
    [
        (Circle("ball", (4.0, 1.0), 1.0), {}, "no base"),
        (Block("flap", (4.0, 4.5), (0.0, 3.0)), {"hinge": (4.0, 0.0)}, "hinge"),
        (Block("late", (4.0, 6.0), (0.0, 1.0)), {"begin": 11.0}, "held to the end"),
        (Block("high", (4.0, 6.0), (3.0, 4.0)), {}, "no wall is below"),
    ],
)
def test_a_body_without_factors_says_why(wall, free, why):
    one = body(wall, **free)
    loads, said = body_loads(flow_of(plane(), one), one, {wall.name: history_of(one)})
    assert loads is None and why in said


@pytest.mark.parametrize(("gap", "way", "since"), [(0.0, 0.0, 0.0), (1.0, 1.0, 4.0), (1.0, 0.5, None)])
def test_a_body_that_another_one_touches_has_factors_until_then(gap, way, since):
    """The other one comes `way` near from 2 to 4 s."""
    one, two = body(Block("box", (4.0, 6.0), (0.0, 1.0))), body(Block("ram", (6.0 + gap, 7.0 + gap), (0.0, 1.0)))
    histories = {
        "box": pushed(history_of(one), (3000.0, 0.0), (4.0, 0.5)),
        "ram": history_of(two, x=-ramp(2.0, 4.0, way)),
    }
    flow = flow_of(plane(), one, two)
    loads, why = body_loads(flow, one, histories)
    if since == 0.0:
        assert loads is None and "the body ram touches it" in why
    else:
        assert loads is not None and ("ram touches" in why) == (since is not None)
        last = loads.time[loads.stands][-1]
        assert last == pytest.approx(since or 10.0, abs=0.2)


def test_without_friction_nothing_bounds_sliding_and_what_is_unpushed_says_so():
    one = body(Block("box", (4.0, 6.0), (0.0, 1.0)))
    found, _ = of_body(one, history_of(one), flow=flow_of(plane(), one, friction=0.0))
    assert np.isnan([found.sliding_factor_least, found.tipping_factor_least, found.moment_about_toe_peak]).all()
    assert "nothing rubs" in found.reason and "nothing pushes it" in found.reason and found.toe is None
    assert found.toe_pressure_peak == found.heel_pressure_least == pytest.approx(1000.0 * G)


def test_a_wall_with_a_weight_is_looked_at_by_its_record():
    """A trapezoid of concrete, 3 m below, under the water pressure of a depth of 2 m: rho g h^2/2 at h/3."""
    quay = MovingWall(Polygon("quay", ((4.0, 0.0), (7.0, 0.0), (5.5, 3.0), (4.0, 3.0))))
    flow = flow_of(plane(), quay)
    force, height = 1000.0 * G * 2.0, 2.0 / 3.0
    zero = np.zeros(len(TIME))
    record = ForceHistory(TIME, zero + force, zero, zero - force * height)  # about its point, the lower left corner
    loads, why = wall_loads(flow, "quay", WallWeight(2400.0, 0.5), record)
    assert not why
    found = found_of(loads, WINDOW, 0.1)
    area, weight = 6.75, 2400.0 * 6.75 * G
    arm = 7.0 - (1.5 * 3.0 * 4.75 + 0.5 * 1.5 * 3.0 * (5.5 + 0.5)) / area
    assert found.weight == pytest.approx(weight) and found.base == pytest.approx(3.0)
    assert found.sliding_factor_least == pytest.approx(0.5 * weight / force)
    assert found.tipping_factor_least == pytest.approx(weight * arm / (force * height)) and found.toe == "right"
    assert found.state is None and np.isnan(found.slid_by)


@pytest.mark.parametrize("share", [0.0, 0.1, 1 / 6, 0.25, 0.4])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_pressures_below_a_base_carry_the_force_where_it_acts(share, sign):
    """Their integral is the force, and their first moment its eccentricity."""
    base, pressed = 3.0, np.array([5e4])
    off = eccentricity(np.array([-sign * share * base]) * pressed, pressed)
    assert off[0] == pytest.approx(sign * share * base)
    toe, heel = (float(one[0]) for one in bearing_pressures(pressed, off, base))
    wet = base if heel > 0 or share == 1 / 6 else 2 * pressed[0] / toe
    x = np.linspace(0.0, wet, 2001)  # from the toe
    p = toe + (heel - toe) * x / wet
    assert np.trapezoid(p, x) == pytest.approx(pressed[0])
    assert base / 2 - np.trapezoid(p * x, x) / pressed[0] == pytest.approx(share * base, abs=1e-5 * base)


def test_table_figure_and_section_have_every_structure():
    one = body(Block("box", (4.0, 6.0), (0.0, 1.0)))
    found, _ = of_body(one, pushed(history_of(one), (-3000.0, 0.0), (4.0, 0.5)))
    both = {"box": found, "ball": Stability(reason="it has no base to stand on"), "other": replace(found, toe="right")}
    (rows,) = tables(both).values()
    assert list(rows)[:2] == ["time", "name"] and set(rows["name"]) == {"box", "other"}
    assert {len(column) for column in rows.values()} == {2 * len(found.table["time"])}
    chart = figures(both, None)["stability"]
    assert [panel.y.split(":")[0] for panel in chart.panels] == ["box", "box", "other", "other"]
    limit = next(line for line in chart.panels[0].lines if line.look == "theory")
    assert limit.y[0] == pytest.approx(0.6 * found.weight / 1e3)
    # the page has what stands in the summary, without the tables
    said = section(QUANTITY.read(summary(both)))
    assert (
        len(said.blocks) == 4
        and ("Toe", "left") in said.blocks[0].rows
        and "No factor of safety is told for ball" in said.blocks[1].text
    )
    assert set(KEYS) | {"toe", "state", "reason", "table"} == set(Stability.__dataclass_fields__)


def test_averaging_times_stand_beside_factors_and_moments_have_one_unit():
    """Windows of 0.025 s and moving means of 0.1 s: tile, table and line say which; a moment is in kN m/m alone."""
    one = body(Block("block", (0.0, 2.0), (0.0, 1.0)))
    found, _ = of_body(one, pushed(history_of(one), (ramp(1.0, 9.0, 20e3), 0.0), (0.0, 0.5)))
    told = {"stability": summary({"block": replace(found, state="slid")})}
    step = f"{TIME[1] - TIME[0]:z.2g} s"
    rows = {row.label: row for row in rows_of([told])}
    assert f"block, least factor against sliding, {step} means" in rows
    least = f"{found.sliding_factor_least:z.2g} of {step} means"
    assert line(told).startswith(f"block: least factor against sliding {least}")
    assert f"{found.sliding_factor_least_mean:z.2g} of {found.mean_time:z.2g} s means" in line(told)
    table = dict(section({"block": found}).blocks[0].rows)
    heads = list(table)
    least, steady = (next(k for k, head in enumerate(heads) if text in head) for text in ("Least", "holds no peak"))
    assert least < steady and heads[least].endswith(f", {step} means")
    assert table[f"Largest moment of the discs over that toe [kN m/m], {step} means"] == pytest.approx(
        found.moment_about_toe_peak / 1e3
    )
    assert not [head for head in heads if "[N" in head or "[Pa" in head]
