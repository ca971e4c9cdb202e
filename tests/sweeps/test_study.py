# SPDX-License-Identifier: GPL-2.0-or-later
"""Study files: what they may say, what they mean, and errors with their place."""

import pytest
import yaml
from made_up import INPUTS

import lammps_jump as lj
from lammps_jump.sweeps import parse_axis, parse_set, parse_until, read_study

STUDY = f"""case: {INPUTS / "quick_jump.yaml"}
set: {{run.duration: 6}}
axes:
  contact.friction: [0, 0.05, 0.1]
  discs.diameter: {{from: 0.1, to: 0.4, count: 3, scale: log}}
  zip: {{run.output_interval: [0.1, 0.2], analysis.bin_width: [0.4, 0.5]}}
members: 2
collect: [jump.y2, force.sill.impulse]
until: {{jump.speed: 3%}}
"""


@pytest.fixture
def study(tmp_path):
    def read(text=STUDY, **given):
        path = tmp_path / "study.yaml"
        path.write_text(text)
        return read_study(path, **given)

    return read


def test_points_are_the_product_of_the_axes(study):
    found = study()
    assert found.shape == (3, 3, 2) and len(found.points) == 18 and found.fields.members == (1, 2)
    assert [axis.name for axis in found.axes] == ["contact.friction", "discs.diameter", "run.output_interval"]
    assert found.axes[1].values == [0.1, 0.2, 0.4]
    assert found.points[1] == {
        "contact.friction": 0, "discs.diameter": 0.1, "run.output_interval": 0.2, "analysis.bin_width": 0.5,
    }  # fmt: skip
    assert found.case.fields.run.duration == 6
    headings = ["Sequent depth, by mass [m]", "Impulse, sill [kN s/m]", "Velocity of the front [m/s]"]
    assert [item.heading for item in found.collect] == headings


def test_what_was_read_is_written_and_read_again(study, tmp_path):
    found = study()
    (tmp_path / "there").mkdir()
    (tmp_path / "there" / "study.yaml").write_text(found.to_yaml())
    again = read_study(tmp_path / "there")
    assert again.points == found.points and again.case == found.case and again.collect == found.collect
    assert again.fields.until == {"jump.speed": 0.03}


def test_only_what_is_collected_is_analysed(study):
    assert study().analysis["analysis.jump"] and not study().analysis["analysis.energy"]
    assert study(collect=["energy.drift"], until={}).analysis["analysis.jump"] is False
    assert study().analysis["analysis.figures"] == "player"
    many = {"discs.density": list(range(500, 601))}
    assert study(axes=many).analysis["analysis.figures"] == "none"
    for path, asked in (("front.speed", True), ("front.martin_moyce.slope", "water")):
        assert study(collect=[path], until={}).analysis["analysis.front"] == asked


def test_without_a_word_the_numbers_of_the_screen_are_collected(study):
    paths = [item.path for item in study(collect=[], until={}).collect]
    assert {"jump.y1", "jump.y2", "jump.speed", "force.sill.peak"} <= set(paths)
    assert "force.sill.peak_time" not in paths  # its interval over eight members holds in 76 of 100 sets


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("acses: {}", "study.yaml:10: acses: unknown field; did you mean 'case'"),
        (
            "confidence: 2",
            r"study.yaml:10: confidence: 2 is out of range; allowed is < 1 and > 0|allowed is > 0 and < 1",
        ),
        ("most_members: 1", "study.yaml:10: most_members"),
    ],
)
def test_wrong_fields_name_their_line(study, line, said):
    with pytest.raises(lj.CaseError, match=said):
        study(STUDY + line + "\n")


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"collect": ["jump.y3"]}, "jump has no number 'y3'; did you mean 'y"),
        ({"collect": ["jmp.y2"]}, "there is no 'jmp' in summary.json; did you mean 'jump'"),
        ({"collect": ["force.wall.peak"]}, "'wall' is no probe of the case; probes there: sill"),
        ({"axes": {"contact.friction": []}}, "allowed is a list of values, or {from"),
        ({"axes": {"contact.friction": [0, 0]}}, "0 stands twice"),
        ({"axes": {"zip": {"run.duration": [1, 2], "run.seed": [1]}}}, "need lists of one length"),
        ({"axes": {"run.seed": {"from": -1, "to": 1, "count": 3, "scale": "log"}}}, "above 0"),
        ({"axes": {"run.seed": {"from": 1, "to": 200000, "count": 90000}}}, "180000 runs; allowed are 100000"),
        ({"members": 0}, "allowed is 1 to 1000, or different seeds"),
        ({"members": [3, 3]}, "different seeds"),
        ({"until": {"jump.speed": 3}}, "accuracy 3 is out of range"),
    ],
)
def test_wrong_values_say_what_is_allowed(study, given, said):
    with pytest.raises(lj.CaseError, match=said):
        study(**given)


@pytest.mark.parametrize(
    ("members", "seeds"), [(3, (1, 2, 3)), ("3", (1, 2, 3)), ("9-11", (9, 10, 11)), ([5, 2], (5, 2))]
)
def test_members_are_seeds(study, members, seeds):
    assert study(members=members).fields.members == seeds


def test_a_point_that_cannot_be_run_is_refused_before_anything_runs(study, tmp_path):
    with pytest.raises(
        lj.CaseError, match=r"contact.friction=-1: contact.friction: -1 is out of range; allowed is >= 0 and <= 1000"
    ):
        lj.sweep({"case": yaml.safe_load(study().case.to_yaml())}, tmp_path / "out", axes={"contact.friction": [0, -1]})
    with pytest.raises(lj.CaseError, match="time_step_fraction"):  # a scene that is unstable
        lj.sweep(study().case, tmp_path / "out", axes={"run.time_step_fraction": [0.05, 0.9]})
    assert not (tmp_path / "out").exists()


def test_words_of_the_command_line():
    assert parse_axis("contact.friction=0, 0.1") == ("contact.friction", [0, 0.1])
    assert parse_axis("walls.sill.y=[[-5, 1], [-5, 2]]") == ("walls.sill.y", [[-5, 1], [-5, 2]])
    assert parse_axis("run.seed={from: 1, to: 5, count: 3}")[1] == {"from": 1, "to": 5, "count": 3}
    assert parse_set("analysis.window=[2, 3]") == ("analysis.window", [2, 3])
    assert parse_until("jump.speed ± 3%") == parse_until("jump.speed=3%") == ("jump.speed", "3%")
    for parse in (parse_axis, parse_set, parse_until):
        with pytest.raises(lj.CaseError, match="for example --"):
            parse("contact.friction")


@pytest.mark.parametrize(
    "text",
    [
        "*SECRET\n",
        "SECRET: hunter\n",
        "a: !!int SECRET\n",
        "SECRET: 1\nSECRET: 2\n",
        "SECRET\n",
        "@SECRET",
        "!SECRET a",
    ],
)
@pytest.mark.fault("text as a command")
def test_nothing_is_told_of_a_file_that_is_no_case(study, tmp_path, text):
    """A study that was received may name any file of the reader's as its case."""
    (tmp_path / "private").write_text(text)
    with pytest.raises(lj.CaseError, match="private: is no case") as caught:
        study("case: private\n")
    assert "SECRET" not in str(caught.value)


LONG = "x" * 100_000


@pytest.mark.parametrize(
    "given",
    [
        {"members": LONG}, {"members": [-5] * 5_000}, {"axes": {"discs.density": LONG}}, {"axes": {LONG: [1]}},
        {"collect": [LONG]}, {"collect": [f"jump.{LONG}"]}, {"collect": [f"force.{LONG}.peak"]}, {LONG: 1},
        {"set": {"discs.diameter": LONG}}, {"set": {f"discs.{LONG}": 1}}, {"set": {f"walls.{LONG}": 1}},
        {"set": {"engine.kernel": LONG}}, {"set": {"name": LONG}}, {"set": {"walls.sill.x": [0] * 5_000}},
        {"set": {"walls.sill.kind": LONG}}, {"until": {"jump.speed": LONG}}, {"confidence": LONG},
    ],
)  # fmt: skip
@pytest.mark.fault("mutants of cases")
def test_a_message_shows_the_start_of_a_long_value(study, given):
    with pytest.raises(lj.CaseError) as caught:
        found = study(**given)
        found.case.replace(found.points[0])
    assert "x" * 201 not in str(caught.value) and len(str(caught.value)) < 3000
