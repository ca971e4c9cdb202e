# SPDX-License-Identifier: GPL-2.0-or-later
"""Unknown fields and kinds are answered by what they mean; options and Python objects tell where to change a case."""

import sys
from pathlib import Path

import pytest
from made_up import INPUTS

import lammps_jump as lj
from lammps_jump.case import field_words
from lammps_jump.errors import CaseError
from lammps_jump.sweeps import read_study

sys.path.insert(0, str(Path(__file__).parents[2] / "docs"))

from making import fields

QUICK = INPUTS / "quick_jump.yaml"
KINDS = {
    "plane", "block", "box", "polygon", "line", "circle", "rough", "translate", "rotate", "oscillate", "table", "load",
    "hold", "rows", "pour", "column", "lattice", "list", "uniform", "bidisperse",
}  # fmt: skip


def said(change: str) -> str:
    with pytest.raises(CaseError) as caught:
        lj.load_case(QUICK, [change])
    return str(caught.value)


def test_every_word_leads_to_a_field_or_kind_that_exists():
    names = fields.names()
    assert not [path for path, _, _ in field_words.MEANT if path not in names]
    assert set(field_words.KINDS.values()) <= KINDS


def test_no_word_is_the_name_of_a_field_beside_the_one_that_it_leads_to():
    names = fields.names()
    for path, words, _ in field_words.MEANT:
        group = path.rpartition(".")[0]
        beside = {name for name in names if name.rpartition(".")[0] == group}
        # fields of one group that belong to other kinds may have the name
        wrong = [word for word in words.split() if f"{group}.{word}".lstrip(".") in beside]
        assert group.partition(".")[0] in ("walls", "initial", "inflow") or not wrong, (path, wrong)


@pytest.mark.parametrize(
    ("change", "answer"),
    [
        ("walls.0.motion={kind: table, rows: [[0, 0, 0, 0]]}", "write walls.motion.points (rows [t, x, y, angle]:"),
        ("inflow.rows=[1]", "write inflow.table (rows [t, depth, mean speed] in place of depth and speed)"),
        ("run.dt=1e-4", "write run.time_step_fraction (the step follows from the stiffness"),
        ("dt=1e-4", "perhaps run.time_step_fraction (the step follows from the stiffness"),
        ("contact.E=1e7", "write contact.from_material ({young: 5 MPa"),
        ("contact.e=0.2", "write contact.restitution"),
        ("discs.radius=0.1", "write discs.diameter (twice the radius)"),
        ("particles=1", "write discs"),
        ("duration=3", "perhaps run.duration (simulated time, in s) is meant"),
        ("friction=0.2", "perhaps contact.friction or contact.rolling.friction or walls.friction is meant"),
        ("contact.frction=0.2", "did you mean 'friction'?"),
        ("foo=1", "known here: name, description"),
        ("walls.0.kind=rectangle", "--set walls.0.kind=rectangle: walls[0].kind: 'rectangle' is not known"),
        ("walls.0.kind=floor", "did you mean 'plane'?"),
        ("walls.0.motion={kind: sine}", "did you mean 'oscillate'?"),
        ("walls.0={name: a, type: block}", "kind is missing ('type' is called kind here); allowed is 'plane'"),
    ],
)
def test_an_unknown_word_is_answered_by_its_meaning(change, answer):
    assert answer in said(change)


@pytest.mark.parametrize(
    ("given", "place"),
    [
        ({"collect": ["jump.y3"]}, "--collect: jump.y3: jump has no number 'y3'; did you mean 'y2'?"),
        ({"until": {"jump.y2": 3}}, "--until jump.y2: "),
        ({"members": 0}, "--members: "),
        ({"axes": {"run.seed": []}}, "--axis: [] does not fit"),
    ],
)
def test_what_an_option_says_wrongly_is_told_of_the_option(given, place):
    with pytest.raises(CaseError) as caught:
        read_study(QUICK, **given)
    assert str(caught.value).startswith(place)


def test_what_a_study_says_wrongly_is_told_of_its_file():
    with pytest.raises(CaseError, match=r"^<study>: collect: jump.y3"):
        read_study({"case": str(QUICK), "collect": ["jump.y3"]})


def test_a_case_in_python_tells_how_it_is_changed():
    case = lj.load_case(QUICK)
    with pytest.raises(AttributeError, match=r"a case has no 'contakt'; did you mean 'contact'\?"):
        case.contakt  # noqa: B018
    with pytest.raises(AttributeError, match=r"duration: the fields of a case do not change; case.replace"):
        case.run.duration = 3
    with pytest.raises(AttributeError, match=r"friction: the fields of a case do not change; case.replace"):
        case.fields.contact.friction = 0.1
    assert case.replace({"contact.friction": 0.1}).fields.contact.friction == 0.1
    assert case.contact.friction == case.fields.contact.friction and not hasattr(case, "contakt")
