# SPDX-License-Identifier: GPL-2.0-or-later
"""An inflow against time: the steps and speeds of its discs, and cases that are refused."""

import numpy as np
import pytest
from made_up import INPUTS, native_frames
from scipy.integrate import quad

from lammps_jump.case import load_case, parse_case
from lammps_jump.case.case import ReadCase
from lammps_jump.engines.choice import choose
from lammps_jump.engines.launch import write_script
from lammps_jump.errors import CaseError, SetupError
from lammps_jump.physics.inlet import Hydrograph, entries_of_rows, row_speeds

GIVEN = ("inflow.depth=null", "inflow.mean_speed=null", "inflow.discharge=null")
FLOOD = "inflow.table=[[0.2, 0, 6], [1, 0.6, 10], [2, 0.6, 10], [2.5, 0.2, 8]]"
SHORT = ("run.duration=3", "run.time_step_fraction=0.2", "initial=[]", "analysis.window=[1, 3]")
GRAPH = Hydrograph((0.2, 1.0, 2.0, 2.5), (0.0, 0.6, 0.6, 0.2), (6.0, 10.0, 10.0, 8.0))


def flood(*changes: str) -> ReadCase:
    """`quick_jump` with an inflow that grows, stays and falls."""
    return load_case(INPUTS / "quick_jump.yaml", [*GIVEN, FLOOD, *SHORT, *changes])


def test_integrals_are_those_of_the_straight_lines():
    for end in (0.1, 0.7, 1.0, 2.2, 4.0):
        # a parabola in each piece: the rule of quad is exact there
        carried, _ = quad(lambda t: GRAPH.depth(t) * GRAPH.speed(t), 0, end, points=(0.2, 1.0, 2.0, 2.5), limit=200)
        filled, _ = quad(GRAPH.depth, 0, end, points=(0.2, 1.0, 2.0, 2.5), limit=200)
        assert GRAPH.means(0.0, end) == pytest.approx((filled / end, carried / end), rel=1e-9)
    assert GRAPH.means(1.5, 1.5) == (0.6, 6.0)


@pytest.mark.parametrize("sizes", [(), ("discs.sizes=null",), ("inflow.profile=uniform",)])
def test_no_row_is_off_by_more_than_half_a_disc_at_any_time(sizes):
    scene = flood(*sizes).scene()
    graph = scene.hydrograph
    assert graph == GRAPH
    for time in (0.5, 1.0, 1.7, 2.2, 3.0):
        step = round(time / scene.time_step)
        entered = sum(len(row.turns_until(step)) for row in scene.inlets)
        wanted = graph.means(0.0, time)[1] * time / scene.mean_square
        # half a disc of each row, and what enters in one step
        assert entered == pytest.approx(wanted, abs=0.5 * len(scene.inlets) + 0.1)
    assert scene.expected_discs == sum(len(row.turns) for row in scene.inlets)
    assert sum(scene.discharges) * 3.0 == pytest.approx(scene.mean_square * scene.expected_discs)


def test_a_constant_table_is_the_steady_inflow_with_its_speeds_and_gaps():
    shared = {"mean_square": 0.04, "largest": 0.2}
    rows = entries_of_rows(Hydrograph((0.0,), (1.0,), (16.0,)), 2.0, **shared)
    assert [one.relative[0] * 16 for one in rows] == pytest.approx(row_speeds(6, 16.0), rel=1e-12)
    for one in rows:  # K a / h = 6 * 0.04 / 1
        gaps = np.diff(one.times) * 16 * one.relative[1:]
        assert gaps == pytest.approx(np.full(len(gaps), 0.24), rel=1e-9)


def test_discs_of_a_row_keep_their_gap_while_the_depth_changes():
    graph = Hydrograph((0.0, 1.0, 2.0), (0.0, 1.0, 0.3), (16.0, 16.0, 8.0))
    for one in entries_of_rows(graph, 2.5, mean_square=0.04, largest=0.2):
        speeds = graph.speed(one.times) * one.relative
        # the row slows down by the share that a row more takes, a sixth of the 1/7 profile at most
        assert (np.diff(one.times) * speeds[:-1]).min() > 1.05 * 0.2


def test_the_speed_of_each_disc_is_that_of_the_table_when_it_enters():
    scene = flood("inflow.profile=uniform").scene()
    for row in scene.inlets:
        times = np.array([scene.time(step) for step in row.turns])
        assert row.speeds == pytest.approx(GRAPH.speed(times), rel=2e-6)  # the seed changes them by 1e-6
        assert row.vx == max(row.speeds)


def test_times_count_from_the_end_of_settling():
    column = "initial=[{kind: column, x: [2, 3], y: [0, 1], settle: 0.5}]"
    scene = flood(column, "inflow.table=[[0, 0.6, 10]]").scene()
    assert scene.settle_steps > 0
    assert min(row.first_step for row in scene.inlets) > scene.settle_steps
    scene = flood(column, "inflow.profile=uniform").scene()
    for row in scene.inlets:
        seconds = (np.array(row.turns) - scene.settle_steps) * scene.time_step
        assert row.speeds == pytest.approx(GRAPH.speed(seconds), rel=2e-6)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        (("inflow.depth=1",), "table and depth are both given"),
        (("inflow.mean_speed=1",), "table and mean_speed are both given"),
        (("inflow.discharge=1",), "table and discharge are both given"),
        (("inflow.table=[[0, 1, 2], [0, 1, 3]]",), "t 0 s follows 0 s; times must grow"),
        (("inflow.table=[[0, 0, 2], [1, 0, 3]]",), "every depth is 0"),
        (("inflow.table=[[0, 0.1, 2]]",), "holds no row of discs"),
        (("inflow.table=[[0, 1, 0]]",), "inflow.table"),
        (("inflow.table=null",), "needs depth"),
        (("inflow.schedule=thesis",), "has no table"),
        (
            ("engine.kernel=stock",),
            "inflow.table: is not in stock LAMMPS.*engine.kernel: compiled or engine.name: native",
        ),
    ],
)
def test_what_is_refused(changes, said):
    with pytest.raises(CaseError, match=said):
        flood(*changes).scene()


def test_stock_lammps_does_not_have_it_and_the_compiled_styles_do(tmp_path):
    scene = flood().scene()
    with pytest.raises(SetupError, match=r"stock LAMMPS has no 'inflow.table'; set engine.kernel to compiled, or"):
        choose("lammps", "stock", 1, scene)
    text = write_script(scene, tmp_path).read_text()
    assert "own styles have no `inflow.table`; in.plugin.lammps" in text.splitlines()[1]
    assert text.endswith("quit 1\n") and "fix deposit" not in text and "\nrun " not in text
    text = " ".join(write_script(scene, tmp_path, kernel="compiled").read_text().replace(" &\n", " ").split())
    assert " all jump/inlet " in text and " turns inflow.turns row " in text
    rows = [line.split() for line in (tmp_path / "inflow.turns").read_text().splitlines()]
    assert len(rows) == sum(len(row.turns) for row in scene.inlets)
    first = [(int(step), float(speed)) for row, step, speed in rows if row == "1"]
    assert first == list(zip(scene.inlets[0].turns, scene.inlets[0].speeds, strict=True))  # all digits


def test_a_steady_inflow_has_no_file_of_turns(tmp_path):
    write_script(flood("inflow.table=null", "inflow.depth=0.6", "inflow.mean_speed=10").scene(), tmp_path)
    assert not (tmp_path / "inflow.turns").exists()


def test_check_tells_the_window_and_the_quarters():
    found = flood().check()
    depth, discharge = GRAPH.means(1.0, 3.0)
    assert found.numbers["discharge"] == pytest.approx(discharge)
    assert found.numbers["froude"] == pytest.approx(discharge / depth / np.sqrt(9.81 * depth))
    assert "inflow against time" in str(found) and "depth 0.6 m  discharge 6 m^2/s" not in str(found)
    dry = flood("inflow.table=[[0, 0.6, 10], [0.9, 0, 10]]")
    assert "froude" not in dry.check().numbers
    assert any("no disc flows in during the window" in text for text in dry.scene().warnings)


SPEEDING = """\
name: speeding
discs: {diameter: 0.1}
contact: {restitution: 0.5, impact_speed: 10}
domain: {x: [-1, 40], y: [-1, 4]}
walls: [{name: floor, kind: plane, axis: y, at: 0, side: above}]
inflow: {kind: rows, table: TABLE, profile: PROFILE}
run: {duration: 2, output_interval: 0.1}
engine: {name: native}
"""


def speeding(table, profile="power_law"):
    return parse_case(SPEEDING.replace("TABLE", str(table)).replace("PROFILE", profile), "speeding.yaml")


@pytest.mark.parametrize("profile", ["power_law", pytest.param("uniform", marks=pytest.mark.long)])
def test_an_inflow_that_speeds_up_is_delivered(profile):
    """13 of 599 discs were refused, 2.4 % of the discharge: the rows stood as in a steady inflow."""
    scene = speeding([[0, 0.5, 4], [2, 0.5, 8]], profile).scene()
    asked = scene.hydrograph.means(0.0, 2.0)[1] * 2.0 / scene.mean_square
    entered = list(native_frames(scene))[-1].ids.max()
    assert entered == sum(len(row.turns) for row in scene.inlets)
    assert entered == pytest.approx(asked, rel=5e-3)
    assert not [text for text in scene.warnings if "inflow.table" in text]


def test_rows_stand_wider_where_the_speed_grows():
    """2 r/(1 + r) of the room that a disc needs; where it never grows they are those of a steady inflow."""
    growing, falling = Hydrograph((0, 2), (0.5, 0.5), (4, 8)), Hydrograph((0, 2), (0.5, 0.5), (8, 4))
    assert growing.rise == 2 and growing.least_gap(1.1) == pytest.approx(1.05 * 4 / 3)
    assert falling.rise == 1 and falling.least_gap(1.1) == 1.1 and growing.least_gap(3.0) == 3.0
    assert Hydrograph((0, 1, 2), (1, 1, 1), (4, 2, 6)).rise == 3
    rows = [len(speeding([[0, 0.5, a], [2, 0.5, b]]).scene().inlets) for a, b in ((4, 8), (8, 4), (4, 4))]
    assert rows == [7, 6, 6]


@pytest.mark.parametrize(
    ("table", "ratio"),
    [
        ([[0, 0.5, 4], [1, 0.5, 4], [1.5, 0.5, 8]], 2.0),
        ([[0, 0.5, 2], [1, 0.5, 2], [3, 0.5, 8]], 4.0),
        ([[0, 0.5, 4], [2, 0.5, 8]], None),
        ([[0, 0.5, 8], [0.1, 0.5, 2]], None),
    ],
)
def test_a_speed_that_leaps_is_told_before_the_run(table, ratio):
    said = [text for text in speeding(table).scene().warnings if "inflow.table" in text]
    assert [f"grows {ratio:g}-fold" in text and "refused" in text for text in said] == [True] * (ratio is not None)
