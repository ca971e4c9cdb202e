# SPDX-License-Identifier: GPL-2.0-or-later
"""Case files: units, YAML numbers, --set, defaults, hashes; and round trips of random cases."""

from __future__ import annotations

import json
from math import ceil, sqrt

import pytest
from hypothesis import given
from hypothesis import strategies as st
from made_up import INPUTS, SCENES, examples

from lammps_jump.case import load_case, parse_case
from lammps_jump.case.case import scene_names, scene_text
from lammps_jump.case.to_scene import contact_coefficients
from lammps_jump.errors import CaseError
from lammps_jump.scene import Scene
from lammps_jump.scene.walls import Block, Plane
from lammps_jump.script import script_text

SMALL = """\
discs: {{diameter: {diameter}}}
contact: {{restitution: 0.5, impact_speed: 10}}
initial: [{{kind: lattice, nx: 2, ny: 2, spacing: 1, origin: [0, 0]}}]
run: {{duration: 1}}
"""


def case_with(diameter="0.2", assignments=()):
    return parse_case(SMALL.format(diameter=diameter), "small.yaml", assignments)


@pytest.mark.parametrize(
    "text, metres",
    [
        ("0.2", 0.2),
        ("20 cm", 0.2),
        ("'200 mm'", 0.2),
        ("2e-1", 0.2),
        ("'1e-4 km'", 0.1),
        ("1e0", 1.0),
        (".5", 0.5),
        ("1.", 1.0),
    ],
)
def test_numbers_and_units(text, metres):
    # exact but for the one rounding of the unit's factor
    assert case_with(text).fields.discs.diameter == pytest.approx(metres, rel=1e-15)


@pytest.mark.parametrize(
    "text",
    [
        "2026-01-01",
        "1:30",
        "0.1.2",
        "1 000",
        "1,000",
        "0,2",
        "1 - 0.5",
        "2**3",
        "pi",
        "1_000",
        "1 1 m",
        "0.2.1 m",
        "-",
        "''",
    ],
)
def test_text_is_one_number_with_a_unit_and_never_arithmetic(text):
    with pytest.raises(CaseError, match=r"small.yaml:1: discs.diameter: .*expected a number in m"):
        case_with(text if text == "''" else f"'{text}'")


@pytest.mark.parametrize("text", ["100 1/s", "0.1 kHz", "100 s^-1", "100 s**-1", "+1e2 1/s"])
def test_units_are_products_of_factors(text):
    assert case_with(
        assignments=[f"contact.tangential_damping={text}"]
    ).fields.contact.tangential_damping == pytest.approx(100)


def test_whole_numbers_beyond_doubles_are_refused():
    with pytest.raises(CaseError, match="not a finite number"):
        case_with("1" + 400 * "0")


def test_yaml_exponents_are_numbers():
    loaded = parse_case(SMALL.format(diameter="0.2"), changes=["contact.stiffness=1e7", "contact.impact_speed=1E1"])
    assert loaded.fields.contact.stiffness == 1e7
    assert loaded.fields.contact.impact_speed == 10.0


def test_name_defaults_to_the_file():
    assert case_with().name == "small"


def test_set_by_name_and_index():
    case = load_case(
        INPUTS / "hydraulic_jump.yaml", ["walls.sill.y=[-10,3]", "outflow.0.x_beyond=80", "contact.friction=0"]
    ).fields
    assert case.walls[1].y == (-10.0, 3.0)
    assert case.outflow[0].x_beyond == 80.0
    assert case.contact.friction == 0.0


def test_set_makes_missing_groups():
    assert case_with(assignments=["engine.name=native"]).fields.engine.name == "native"


def test_resolved_case_is_itself_a_case_and_complete():
    for path in SCENES:
        case = load_case(path)
        text = case.to_yaml()
        again = parse_case(text)
        assert again == case and again.hash == case.hash, path.name
        assert "time_step_fraction" in text and "correct_restitution" in text


def test_hash_ignores_what_does_not_change_the_run():
    base = case_with()
    assert base.hash == case_with(assignments=["description=other words", "analysis.energy=true"]).hash
    assert base.hash != case_with(assignments=["run.seed=2"]).hash
    assert base.hash != case_with(assignments=["run.time_step_fraction=0.06"]).hash


def test_frozen():
    with pytest.raises(AttributeError, match=r"do not change; case\.replace"):
        case_with().fields.run.seed = 3


def test_every_scene_is_offered_and_valid():
    names = [path.stem for path in SCENES]
    assert {"hydraulic_jump", "dam_break", "quick_jump"} <= set(names) and {*names, "breach"} == set(scene_names())
    for name in names:
        assert parse_case(scene_text(name)).fields.name == name


def test_schema_names_every_field():
    from lammps_jump.case.fields import CaseFields

    schema = CaseFields.model_json_schema()
    assert set(schema["properties"]) == set(CaseFields.model_fields)
    assert json.dumps(schema)
    accuracy = schema["$defs"]["RunFields"]["properties"]["accuracy"]  # an editor would underline 1 %
    assert {"type": "string"} in accuracy["anyOf"]


def test_thesis_numbers_of_the_hydraulic_jump():
    case = load_case(INPUTS / "hydraulic_jump.yaml")
    scene, c = case.scene(), contact_coefficients(case.fields, "velocity_verlet", None)
    assert c.mass == pytest.approx(40, rel=1e-12)
    assert c.stiffness == pytest.approx(2.56e7, rel=1e-12)
    assert c.time_step == pytest.approx(8.839e-5, rel=1e-4)  # 0.05 x 2/omega, four digits
    # the step of the run divides the 0.01 s of the probes
    assert scene.time_step == pytest.approx(0.01 / 114, rel=1e-12) and 114 == ceil(0.01 / c.time_step)
    assert c.damping == pytest.approx(20634, rel=1e-4)
    assert c.damping_wall == pytest.approx(29181, rel=1e-4)
    assert c.correction == pytest.approx(0.9775, abs=5e-5)
    speeds = [row.vx for row in scene.inlets]
    assert speeds == pytest.approx([13.160, 15.396, 16.562, 17.377, 18.013], abs=5e-4)
    exact = load_case(INPUTS / "hydraulic_jump.yaml", {"inflow.schedule": "exact", "run.seed": 0}).scene().inlets
    assert [row.every_steps for row in exact] == [214, 183, 170, 162, 157, 153]
    assert sum(row.vx for row in exact) / 6 == pytest.approx(16, rel=1e-14)


def test_column_carries_its_weight_from_the_start():
    """Every row's overlap with the row below equals the weight above (thesis figure 6.2)."""
    scene = load_case(INPUTS / "dam_break.yaml").scene()
    c = scene.coefficients
    assert len(scene.positions) == 1200
    column = scene.positions[::20][:, 1]
    overlap = scene.diameter - (column[1:] - column[:-1])
    above = 59 - pytest.importorskip("numpy").arange(59)
    # d - overlap is formed from sums of up to 60 terms of 12 m: 1e-13 m of round-off, 1e-9 of an overlap
    assert overlap == pytest.approx(above * c.mass * 9.81 / c.stiffness, abs=1e-12)
    floor = scene.radius - column[0]
    assert floor * c.stiffness_wall == pytest.approx(60 * c.mass * 9.81, rel=1e-9)


def test_gate_stands_until_time_zero():
    scene = load_case(INPUTS / "wave_structure.yaml").scene()
    (gate,) = scene.gates
    assert gate.wall == Plane("gate", "x", 4.0, "below")
    assert scene.time(gate.motion.gone) == 0.0
    assert gate.motion.gone * scene.time_step >= 2.0
    assert scene.settle_steps % scene.output_steps == 0


WET_BED = """
name: wet_bed
discs: {diameter: 0.1}
contact: {restitution: 0.5, impact_speed: 5}
walls:
  - {name: floor, kind: plane, axis: y, at: 0, side: above}
  - {name: back, kind: plane, axis: x, at: 0, side: above}
initial:
  - {kind: column, x: [0, 1], y: [0, 1], settle: 0.1}
  - {kind: list, positions: [[FAR, 0.05]]}
run: {duration: 0.1, output_interval: 0.1}
"""


def test_gate_with_discs_beyond_it_is_felt_from_both_sides():
    (gate,) = parse_case(WET_BED.replace("FAR", "1.05"), "wet.yaml").scene().gates
    assert isinstance(gate.wall, Block) and gate.wall.x == (1.0, 1.0)
    assert gate.wall.distance([0.95, 1.05], [0.5, 0.5]) == pytest.approx([0.05, 0.05])


def test_disc_in_a_gate_is_refused():
    with pytest.raises(CaseError, match="deep in wall 'gate'"):
        parse_case(WET_BED.replace("FAR, 0.05", "1.02, 2"), "wet.yaml").scene()


def test_frames_and_probe_windows_divide_the_run():
    for path in SCENES:
        case = load_case(path)
        scene, wanted = case.scene(), case.fields.run.duration
        assert scene.steps % scene.output_steps == 0
        assert scene.output_steps % scene.probe_steps == 0
        # the intervals are rounded to whole steps, at most half a step a probe window
        assert scene.time(scene.steps) == pytest.approx(wanted, rel=0.5 / scene.probe_steps + 1e-3)


def test_skips_are_named():
    skipped = " ".join(load_case(INPUTS / "energy_box_16.yaml").scene().skipped)
    for word in ("friction", "dashpots", "spin", "gravity", "inlet", "outlet"):
        assert word in skipped


def test_walls_out_of_reach_are_left_out():
    loaded = parse_case(
        SMALL.format(diameter="0.2"),
        changes=[
            "walls=[{kind: plane, name: far, axis: x, at: 500, side: below}]",
            "domain={x: [-5, 5], y: [-5, 5]}",
        ],
    )
    scene = loaded.scene()
    assert scene.walls == () and any("far" in text for text in scene.skipped)


def test_near_the_limit_is_a_warning_beyond_it_an_error():
    assert not parse_case(SMALL.format(diameter="0.2")).scene().warnings
    close = parse_case(SMALL.format(diameter="0.2"), changes=["run.time_step_fraction=0.37"]).scene()
    assert any("limit of stability" in text for text in close.warnings)
    with pytest.raises(CaseError, match="allow_unstable"):
        parse_case(SMALL.format(diameter="0.2"), changes=["run.time_step_fraction=0.5"]).scene()
    parse_case(SMALL.format(diameter="0.2"), changes=["run.time_step_fraction=0.5", "run.allow_unstable=true"]).scene()


@examples(40)
@given(
    diameter=st.floats(0.01, 1.0),
    restitution=st.floats(0.05, 1.0),
    friction=st.floats(0.0, 2.0),
    duration=st.floats(0.01, 5.0),
    counts=st.tuples(st.integers(1, 5), st.integers(1, 5)),
)
def test_random_cases_survive_the_round_trip(diameter, restitution, friction, duration, counts):
    text = (
        f"discs: {{diameter: {diameter!r}}}\n"
        f"contact: {{restitution: {restitution!r}, friction: {friction!r}, impact_speed: 5}}\n"
        f"initial: [{{kind: lattice, nx: {counts[0]}, ny: {counts[1]}, spacing: {2 * diameter!r}, origin: [0, 0]}}]\n"
        f"run: {{duration: {duration!r}}}\n"
    )
    loaded = parse_case(text)
    again = parse_case(loaded.to_yaml())
    assert again == loaded and again.hash == loaded.hash
    scene = loaded.scene()
    assert len(scene.positions) == counts[0] * counts[1]
    assert scene.steps % scene.output_steps == 0 and scene.steps >= 1


def test_frames_are_no_closer_than_steps():
    loaded = parse_case(SMALL.format(diameter="0.2"), changes=["run.duration=0.01", "run.output_interval=1e-7"])
    scene = loaded.scene()
    assert scene.output_steps == 1
    assert scene.steps * scene.time_step == pytest.approx(0.01, abs=scene.time_step)


def test_a_run_has_no_more_frames_than_are_read(monkeypatch):
    loaded = parse_case(SMALL.format(diameter="0.2"), changes=["run.duration=0.1", "run.output_interval=0.01"])
    scene = loaded.scene()
    frames = scene.steps // scene.output_steps + 1  # with that of the start
    monkeypatch.setattr("lammps_jump.case.checks.MOST_FRAMES", frames)
    loaded.replace({}).scene()
    monkeypatch.setattr("lammps_jump.case.checks.MOST_FRAMES", frames - 1)
    with pytest.raises(CaseError, match=f"make {frames} frames; allowed are {frames - 1}"):
        loaded.replace({}).scene()


@pytest.mark.parametrize("name", [path.stem for path in SCENES])
def test_scenes_that_come_along_are_scenes(name):
    parse_case(scene_text(name), f"{name}.yaml").scene()


def test_discharge_stands_in_place_of_the_mean_speed():
    path = INPUTS / "quick_jump.yaml"
    by_speed, values = load_case(path), ["inflow.mean_speed=null", "inflow.discharge='60000 cm^2/s'"]
    by_discharge = load_case(path, values)
    assert by_discharge.scene().inlets == by_speed.scene().inlets
    assert by_discharge.check().numbers["discharge"] == 6.0
    assert "mean_speed" not in by_discharge.to_yaml()
    for changes in (["inflow.discharge=6"], ["inflow.mean_speed=null"]):
        with pytest.raises(CaseError, match=r"mean_speed .* or discharge .* one of the two"):
            load_case(path, changes)
    with pytest.raises(CaseError, match="over the depth is"):
        load_case(path, [*values[:1], "inflow.discharge=1e12"])


def test_the_seed_gives_another_jet():
    def speeds(seed, *changes):
        rows = load_case(INPUTS / "hydraulic_jump_frictionless.yaml", [f"run.seed={seed}", *changes]).scene().inlets
        return [row.vx for row in rows], [row.every_steps for row in rows]

    (plain, steps), (one, same), (two, _) = (speeds(seed) for seed in (0, 1, 2))
    assert steps == same and len({*plain, *one, *two}) == 18
    shift = [abs(v / v0 - 1) for v, v0 in zip(one, plain, strict=True)]
    assert 0 < min(shift) and max(shift) <= 1e-6
    assert one == speeds(1, "engine.name=native")[0]
    texts = [
        script_text(
            load_case(INPUTS / "quick_jump.yaml", [f"run.seed={seed}", "discs.sizes=null"]).scene()
        ).splitlines()
        for seed in (0, 7)
    ]
    assert [lines[0].rpartition("run.seed = ")[2] for lines in texts] == ["0", "7"]
    differ = [old for old, new in zip(*texts, strict=True) if old != new][1:]
    assert differ and all(line.startswith(("fix             inlet_", "fix             outlet_")) for line in differ)


@pytest.mark.parametrize(
    ("changes", "interval"),
    [
        ((), 0.4 * sqrt(0.2 / 9.81)),
        (("discs.diameter=0.05",), 0.4 * sqrt(0.05 / 9.81)),
        (("run.duration=40",), 40 / 400),
        (("gravity=0",), 0.1),
        (("run.output_interval=0.25",), 0.25),
    ],
)
def test_frames_are_close_enough_for_playing_unless_asked_otherwise(changes, interval):
    case = case_with(assignments=("run.duration=10", *changes))
    scene = case.scene()
    assert case.fields.output_interval == pytest.approx(interval)
    assert scene.output_steps * scene.time_step == pytest.approx(interval, rel=0.02)
    assert scene.steps <= 400 * scene.output_steps


def test_a_front_is_held_against_water_where_the_case_says_so():
    assert load_case(INPUTS / "dam_break.yaml").fields.analysis.front == "water"
    assert load_case(INPUTS / "column_collapse.yaml").fields.analysis.front is True
    with pytest.raises(CaseError, match=r"'watr' is not known; allowed is .*'water'"):
        load_case(INPUTS / "dam_break.yaml", ["analysis.front=watr"])


def test_a_description_tells_what_was_changed():
    """Also of members of a study, whose case was read from a file that held some of the changes."""
    own = load_case(INPUTS / "dam_break.yaml").fields.description
    changes = {
        "walls.structure.y": [-1, 4],
        "analysis.energy": True,
        "initial.0.jitter": 0.001,
        "engine.name": "native",
    }
    case = load_case(INPUTS / "dam_break.yaml", changes)
    assert case.fields.description == f"{own}; changed: walls.structure.y = [-1, 4]"
    whole = f"{own}; changed: walls.structure.y = [-1, 4], discs.diameter = 20 cm, run.seed = 2"
    seed = {"run.seed": 1}
    for base in (case, parse_case(case.to_yaml())):
        member = base.replace({"discs.diameter": "20 cm"}).replace(seed).replace({"run.seed": 2, "run.members": None})
        assert member.fields.description == whole
    assert member.replace({"description": "mine"}).replace(seed).fields.description == "mine; changed: run.seed = 1"
    later = case.replace({"analysis.window": [3, 5]}).fields.description  # all means are of it
    assert later.endswith("walls.structure.y = [-1, 4], analysis.window = [3, 5]")
    many = {"kind": "list", "positions": [[0.2 * k, 1] for k in range(100)]}
    listed = case.replace({"walls.structure.x": [24, 26], "initial": [many]})
    assert listed.fields.description.endswith("; 3 values changed")


def test_the_description_of_a_scene_is_left_out_of_another_flow(tmp_path):
    path, text = tmp_path / "mine.yaml", scene_text("dam_break")
    for changed, said in (
        (text.replace("[0, 12]", "[0, 8]"), True),
        (text.replace("duration: 5", "duration: 1"), False),
    ):
        path.write_text(changed)
        case = load_case(path)
        assert bool(case.fields.description) is not said
        assert ("is that of dam_break, another flow, and is left out" in str(case.check())) is said


def test_a_scene_is_made_once_and_whole(monkeypatch):
    made, finish = [], Scene.__post_init__
    monkeypatch.setattr(Scene, "__post_init__", lambda scene: made.append(scene.domain) or finish(scene))
    scene = load_case(INPUTS / "column_collapse.yaml").scene()
    assert made == [scene.domain] and scene.gates and scene.outlets + scene.walls
