# SPDX-License-Identifier: GPL-2.0-or-later
"""Cases that were silently wrong and are doubted by `check`; that the scenes are free of it, `test_foresight` shows."""

from __future__ import annotations

import re

import pytest
from made_up import INPUTS, call

from lammps_jump.case import load_case, parse_case
from lammps_jump.engines.native import NativeSimulation
from lammps_jump.errors import CaseError
from lammps_jump.scene import Block, Plane
from lammps_jump.scene.scene import handmade_scene
from lammps_jump.scene.shapes import flush, over_each_other
from lammps_jump.scene.walls import Line, Polygon


def notes(name: str, **changes) -> list[str]:
    return list(load_case(INPUTS / f"{name}.yaml", changes).scene().warnings)


def said(words: str, found) -> bool:
    return any(re.search(words, text) for text in found)


# --- outlets and floors before a wall that stands in the flow ---------------------------------------------------------


@pytest.mark.parametrize("at", [5, 12.0, 18, 21.5])
@pytest.mark.parametrize("filled", [True, False])
def test_an_outlet_inside_the_tail_water_is_told(at, filled):
    """Anywhere before the sill, with water in the basin at the start and without."""
    empty = {} if filled else {"initial": []}
    found = notes("quick_jump", **{"outflow": [{"x_beyond": at}, {"y_below": -1}], **empty})
    assert said(rf"outflow\[0\].x_beyond: {at:g} m lies before wall 'sill' at x = 22 m, in its tail water", found)
    assert said(rf"outflow\[0\].x_beyond: {at:g} m takes \d+ of the 1713 discs out at once", found) == filled


@pytest.mark.parametrize(
    ("name", "outflow", "words"),
    [
        ("tailgate", [{"x_beyond": 40}], "before wall 'sill' at x = 60 m"),
        ("dam_break", [{"x_beyond": 20}], "before wall 'structure' at x = 24 m"),
        ("caisson", [{"x_beyond": 12}], "before wall 'caisson' at x = 16 m"),
        ("spillway", [{"x_beyond": 60}, {"y_below": 0.1}], r"outflow\[1\].y_below: 0.1 m lies before wall 'baffle_1'"),
        ("quick_jump", [{"x_beyond": 25}, {"y_below": 0.1}], r"1 of the 6 rows of the inflow lie beyond it"),
    ],
)
def test_outlets_in_other_flows_are_told(name, outflow, words):
    assert said(words, notes(name, outflow=outflow))


def test_an_outlet_before_a_wall_on_the_other_side_of_the_discs():
    turned = {
        "name": "turned", "discs": {"diameter": 0.2}, "contact": {"restitution": 0.2, "friction": 0, "impact_speed": 9},
        "domain": {"x": [-30, 6], "y": [-5, 9]},
        "walls": [{"name": "back", "kind": "plane", "axis": "x", "at": 4, "side": "below"},
                  {"name": "floor", "kind": "block", "x": [-20, 5], "y": [-2, 0]},
                  {"name": "weir", "kind": "block", "x": [-20.5, -20], "y": [-2, 1]}],
        "initial": [{"kind": "column", "x": [0, 4], "y": [0, 3], "gate": False}],
        "outflow": [{"x_before": -10}, {"y_below": -3}], "run": {"duration": 2},
    }  # fmt: skip
    words = "x_before: -10 m lies before wall 'weir' at x = -20 m"
    assert said(words, load_case(turned).scene().warnings)
    assert not said("lies before", load_case(turned, {"outflow.0.x_before": -22}).scene().warnings)
    gap = load_case(turned, {"walls.floor.x": [-16, 5], "outflow.0.x_before": -22}).scene().warnings
    assert said("the ground ends at x = -16 m, and 4 m are without any before wall 'weir' at x = -20 m", gap)


@pytest.mark.parametrize("outflow", [[{"x_beyond": 22}], [{"x_beyond": 22.6}], [{"x_beyond": 25}, {"y_below": -0.5}]])
def test_outlets_at_and_behind_the_sill_are_not_told(outflow):
    found = notes("quick_jump", outflow=outflow, initial=[])
    assert not said("lies before|lie beyond|takes", found)


@pytest.mark.parametrize("end", [12.5, 18, 21, 21.7])
@pytest.mark.parametrize("filled", [True, False])
def test_a_floor_that_ends_before_the_sill_is_told(end, filled):
    found = notes("quick_jump", **{"walls.floor.x": [-5, end]} | ({} if filled else {"initial": []}))
    hit = [
        re.search(r"the ground ends at x = (\S+) m, and (\S+) m are without any before wall 'sill'", text)
        for text in found
    ]
    (one,) = [(float(match[1]), float(match[2])) for match in hit if match]
    assert one == pytest.approx((end, 22 - end), abs=0.06)


@pytest.mark.parametrize("end", [21.9, 22.0, 22.3])
def test_a_floor_that_comes_to_the_sill_is_not_told(end):
    assert not said("the ground ends", notes("quick_jump", **{"walls.floor.x": [-5, end]}))


# --- times and bins ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("name", "forces"), [("quick_jump", ["sill"]), ("energy_box_7", ["box"])])
def test_an_interval_of_the_probes_longer_than_the_run_is_told(name, forces):
    end = load_case(INPUTS / f"{name}.yaml").fields.run.duration
    long = notes(name, **{"probes.interval": 1.5 * end, "probes.forces": forces})
    assert said(rf"probes.interval: {1.5 * end:g} s is longer than the run of {end:g} s", long)
    for interval in (0.01, 0.5 * end, end):
        assert not said("is longer than the run", notes(name, **{"probes.interval": interval}))
    frames = notes(name, **{"run.output_interval": 2 * end})
    assert said(r"run.output_interval: .* a frame at its start and one at its end", frames)
    adapted = load_case(INPUTS / f"{name}.yaml", {"probes.interval": 1.5 * end}).scene().adapted
    assert not said("set run.output_interval", adapted)


def test_what_begins_behind_the_end_is_told():
    flap = {"name": "flap", "kind": "block", "x": [10, 10.3], "y": [0.05, 4], "density": 1200, "hinge": [10.15, 4]}
    for begin, told in ((0, False), (5.9, False), (6, True), (100, True)):
        found = notes("flap_gate", **{"run.duration": 6, "bodies": [{**flap, "from": begin}]})
        assert said(rf"bodies\[0\].from: body 'flap' is held until {begin:g} s, and the run ends at 6 s", found) == told
    paddle = notes("wave_paddle", **{"walls.paddle.motion.from": 1e3, "walls.paddle.motion.until": None})
    assert said(r"walls\[\d\].motion.from: wall 'paddle' stands until 1000 s", paddle)
    table = [[0, 0, 8], [50, 0, 8], [60, 0.6, 8]]
    inflow = {"kind": "rows", "table": table}
    late = notes(
        "quick_jump", **{"inflow": inflow, "engine.name": "native", "analysis.jump": False, "run.duration": 40}
    )
    assert said("inflow.table lets no disc in before the run ends at 40 s", late)


@pytest.mark.parametrize(("width", "told"), [(0.05, True), (0.17, True), (0.18, False), (0.5, False), (None, False)])
def test_bins_smaller_than_discs_are_told(width, told):
    """Discs of 0.15 m and 20 % more."""
    found = notes("quick_jump", **{"analysis.bin_width": width})
    assert said(r"analysis.bin_width: \S+ m is less than a disc, 0.18 m", found) == told


# --- bodies in the domain ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("x", "y", "words"),
    [
        ([28, 31], [0, 1], r"reaches 1 m beyond the edge of the domain, x = 30 m"),
        ([-2, 1], [0, 1], r"reaches 1 m beyond the edge of the domain, x = -1 m"),
        ([5, 6], [11, 12.5], r"reaches 0.5 m beyond the edge of the domain, y = 12 m"),
        ([29, 33], [0, 1], "refused"),
        ([5, 6], [13, 14], "refused"),
        ([0, 29], [0, 11], ""),
    ],
)
def test_a_body_that_reaches_out_of_the_domain_is_told(x, y, words):
    case = {
        "name": "edge", "discs": {"diameter": 0.2}, "contact": {"restitution": 0.2, "friction": 0, "impact_speed": 15},
        "domain": {"x": [-1, 30], "y": [-1, 12]},
        "walls": [{"name": "floor", "kind": "plane", "axis": "y", "at": 0, "side": "above"}],
        "bodies": [{"name": "raft", "kind": "block", "x": x, "y": y, "density": 500}],
        "initial": [{"kind": "list", "positions": [[29.5, 11.5]]}], "run": {"duration": 0.1},
    }  # fmt: skip
    if words == "refused":
        with pytest.raises(CaseError, match=r"bodies\[0\]: body 'raft' has its centre of mass at . = \S+ m, outside"):
            load_case(case).scene()
    else:
        found = load_case(case).scene().warnings
        assert said(words, found) if words else not said("beyond the edge", found)


# --- numbers of YAML --------------------------------------------------------------------------------------------------

TEXT = """
name: octal
discs: {{diameter: 0.2}}
contact: {{restitution: 0.2, friction: 0, impact_speed: 5}}
domain: {{x: [-1, 9], y: [-1, 9]}}
walls: [{{name: box, kind: box, x: [0, 8], y: [0, 8]}}]
initial: [{{kind: lattice, nx: 2, ny: {ny}, spacing: 0.3, origin: [1, 1]}}]
run: {{duration: {duration}}}
"""


@pytest.mark.parametrize(
    ("text", "value", "words"),
    [
        ("010", 10, "010 is read as 10; other readers of YAML take a leading 0 for octal, 8"),
        ("+0777", 777, "octal, 511"),
        ("08", 8, "octal, which it is not"),
        ("007", 7, ""),
        ("10", 10, ""),
        ("010.5", 10.5, ""),
        ("010 s", 10, ""),
    ],
)
def test_a_leading_zero_is_decimal_and_told(text, value, words):
    case = parse_case(TEXT.format(ny=2, duration=text))
    assert case.fields.run.duration == value
    found = [one for one in case.check().warnings if "leading 0" in one]
    assert bool(found) == bool(words) and all(one.startswith("run.duration: ") and words in one for one in found)


def test_leading_zeros_are_told_wherever_they_stand():
    case = parse_case(TEXT.format(ny="010", duration=1), changes=["run.duration=012"])
    told = [one.partition(" is read")[0] for one in case.check().warnings if "leading 0" in one]
    assert told == ["initial[0].ny: 010", "run.duration: 012"]
    again = case.replace({"run.duration": 2})
    assert [one for one in again.check().warnings if "run.duration" in one and "leading" in one] == []


@pytest.mark.parametrize(
    ("gravity", "words"),
    [
        ([4.9, -8.5], r"gravity: is one number, downwards, .* write gravity: 9.811 and slope: 29.96 \(degrees"),
        ([-1, -1], "gravity: 1.414 and slope: -45"),
        ([0, 9.81], "slope (degrees) tilts it"),
        ([1, 2, -3], "slope (degrees) tilts it"),
    ],
)
def test_gravity_as_a_vector_names_slope(gravity, words):
    with pytest.raises(CaseError) as caught:
        load_case(INPUTS / "quick_jump.yaml", {"gravity": gravity})
    assert re.search(words, str(caught.value)) or words in str(caught.value)


# --- walls that lie on each other, and layers that are none -----------------------------------------------------------

FLOOR = Polygon("floor", ((0, 0), (10, 0), (10, -1), (0, -1)))
PAIRS = {
    "the end of a line on the middle of another": (Line("a", ((0, 0), (10, 0))), Line("b", ((5, 0), (12, 0))), (5, 0)),
    "the same line": (Line("a", ((0, 1), (4, 3))), Line("b", ((0, 1), (4, 3))), (0, 1)),
    "a line on a solid": (FLOOR, Line("b", ((4, 0), (12, 0))), (4, 0)),
    "a block in a solid, flush on top": (FLOOR, Block("b", (3, 5), (-0.5, 0)), (3, 0)),
    "a block in the ground": (Plane("ground", "y", 0, "above"), Block("b", (3, 5), (-0.5, 0)), (3, 0)),
    "sides of stacked blocks": (Block("a", (8, 9), (0, 1.5)), Block("b", (8, 9.5), (0.5, 2)), (8, 0.5)),
    "a sill on the floor": (FLOOR, Block("b", (3, 5), (0, 1)), None),
    "a sill in the ground": (Plane("ground", "y", 0, "above"), Block("b", (3, 5), (-1, 1)), None),
    "lines that run against each other": (Line("a", ((0, 0), (10, 0))), Line("b", ((10, 0), (5, 0))), None),
    "beside each other": (FLOOR, Block("b", (3, 5), (-0.5, 0.001)), None),
    "undersides": (FLOOR, Block("b", (3, 5), (-1, 1)), None),
    "apart on one line": (Line("a", ((0, 0), (4, 0))), Line("b", ((5, 0), (9, 0))), None),
}  # fmt: skip


@pytest.mark.parametrize(("one", "two", "place"), PAIRS.values(), ids=PAIRS)
def test_walls_that_lie_on_each_other_are_found(one, two, place):
    assert over_each_other(one.faces, two.faces) == (None if place is None else pytest.approx(place))
    assert (over_each_other(two.faces, one.faces) is None) == (place is None)
    if place is None:
        assert flush(one.faces, two.faces) is None


@pytest.mark.parametrize("pair", ["a line on a solid", "a block in a solid, flush on top", "a block in the ground"])
def test_a_disc_there_feels_both(pair):
    """It rests half as deep as on one of them."""
    one, two, (x, _) = PAIRS[pair]
    depths = []
    for walls in ((one,), (one, two)):
        scene = handmade_scene([[x + 0.7, 0.0999]], [[0.0, 0.0]], walls, gravity=(0.0, -9.81), friction=0.0)
        simulation = NativeSimulation(scene)
        simulation.run(200_000)
        depths.append(0.1 - simulation.positions[0, 1])
    assert depths[1] == pytest.approx(0.5 * depths[0], rel=1e-3)


def test_check_tells_of_walls_that_lie_on_each_other():
    found = notes("quick_jump", **{"walls.sill": {"name": "sill", "kind": "block", "x": [20, 22], "y": [-5, 0]}})
    assert said("walls 'floor' and 'sill' lie flush on each other at", found)


@pytest.mark.parametrize("name", ["dimensions", "DIM_1", "Bemassung", "A_Text", "cotes_2", "Defpoints", "centerLine"])
def test_a_wall_named_like_dimensions_is_told(name):
    pier = {"name": name, "kind": "line", "points": [[3, 8], [9, 8]], "sheet": True}
    floor = {"name": "floor", "kind": "block", "x": [-5, 22.2], "y": [-5, 0]}
    found = notes("quick_jump", walls=[floor, pier], **{"probes.forces": [], "analysis.jump": False})
    assert said(f"wall '{name}' is named like dimensions, texts or axes of a drawing", found)


@pytest.mark.parametrize("name", ["dam", "dimple", "context", "quay", "diminished", "bed_1", "cottage", "measure"])
def test_other_names_are_not_told(name):
    floor = {"name": name, "kind": "block", "x": [-5, 22.2], "y": [-5, 0]}
    assert not said("named like", notes("quick_jump", walls=[floor], **{"probes.forces": [], "analysis.jump": False}))


LAYERS = """<svg xmlns="http://www.w3.org/2000/svg" width="20mm" height="10mm" viewBox="0 0 20 10">
<g id="bed"><path d="M 0 8 L 10 8"/></g><g id="apron"><path d="M 10 8 L 20 8"/></g>
<g id="{name}"><path d="M 0 9 L 10 9"/><path d="M 0 8.2 L 0 9.4"/><path d="M 10 8.2 L 10 9.4"/></g></svg>"""


@pytest.mark.parametrize(("name", "words"), [("Dimensions", "is named like"), ("L3", "holds 3 single lines apart")])
def test_import_tells_of_layers_that_are_dimensions_and_of_flush_ones(name, words, monkeypatch, capsys, tmp_path):
    (tmp_path / "plan.svg").write_text(LAYERS.format(name=name))
    status, _, told = call(monkeypatch, capsys, "import", tmp_path / "plan.svg", "--scale", "m")
    assert status == 0
    assert f"layer '{name}' {words}" in told and f"became {name}_1, {name}_2, {name}_3" in told
    assert "bed and apron meet flush at (37.8, 7.559) m" in told  # pixels of a page of 96 to an inch
    chosen = ["--layer", "bed=bed", "--layer", f"{name}=baffles"]
    status, _, told = call(monkeypatch, capsys, "import", tmp_path / "plan.svg", "--scale", "m", *chosen)
    assert status == 0 and f"layer '{name}'" not in told and "flush" not in told
