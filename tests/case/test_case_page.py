# SPDX-License-Identifier: GPL-2.0-or-later
"""docs/case.md names every field of a case file, with its default."""

import re
from pathlib import Path
from typing import get_args

import pytest
import yaml

from lammps_jump.case import fields as models
from lammps_jump.case.explain import fields_of
from lammps_jump.scene.tracks import Kind
from lammps_jump.scene.walls import Motions, Wall

PAGE = (Path(__file__).parents[2] / "docs" / "case.md").read_text()
ROWS = dict(re.findall(r"^\| `([\w.]+)` \| ([^|]+) \|", PAGE, re.MULTILINE))
NONE = "\N{EN DASH}"
GROUPS = ("discs", "contact", "run", "engine", "probes", "analysis")


def fields():
    for name, field in models.CaseFields.model_fields.items():
        if name in GROUPS:
            for inner, part in field.annotation.model_fields.items():
                yield f"{name}.{inner}", part
        else:
            yield name, field


@pytest.mark.parametrize(("name", "field"), list(fields()), ids=lambda part: part if isinstance(part, str) else "")
def test_field_and_default(name, field):
    said = ROWS[name].strip()
    if name == "name" or (field.default is None and not field.is_required()):
        assert said == NONE  # a case without a name takes its file's
    elif field.is_required():
        assert said == "needed"
    elif field.get_default(call_default_factory=True) in ((), "", {}):
        assert said in ("none", "empty")
    else:
        assert yaml.safe_load(said) == field.default


KINDS = {
    "of wall": models.WallField,
    "of `motion`": Motions,
    "of `initial`": models.InitialField,
    "of `inflow`": models.InflowField,
    "of `discs.sizes`": models.SizesField,
}
"""Fields with a `kind`, by what the first column of their table says."""


def kinds():
    for heading, union in KINDS.items():
        for model in get_args(get_args(union)[0]):
            yield heading, model


COMMON = {"of wall": ("walls", Wall), "of `motion`": ("walls.motion", Kind)}
"""Fields that every kind has, which stand once, in rows of their own."""


def common():
    """Names of their rows."""
    return {f"{group}.{name}" for group, model in COMMON.values() for name in fields_of(model)}


def test_what_every_wall_and_motion_has_stands_once():
    assert {name for name in ROWS if name.startswith("walls.")} == common()
    assert {name for name in common() if ROWS[name].strip() != NONE} == {"walls.motion.from"}


@pytest.mark.parametrize(("heading", "model"), list(kinds()), ids=lambda part: getattr(part, "__name__", ""))
def test_fields_of_a_kind(heading: str, model: type):
    shared = fields_of(COMMON[heading][1]) if heading in COMMON else {}
    names = {name: field for name, field in fields_of(model).items() if name not in shared}
    (kind,) = get_args(names.pop("kind").annotation)
    table, _, _ = PAGE.partition(f"| `kind` {heading} |")[2].partition("\n\n")
    (row,) = re.findall(rf"^\| `{kind}` \|(.*)$", table, re.MULTILINE)
    names.pop("name", None)  # of every wall, said above the table
    said = re.findall(r"`(\w+)`", row)
    assert set(names) == set(said)
    for name, field in names.items():
        default = re.search(rf"`{name}` \(([^:;)]+)", row)
        if isinstance(field.default, bool | int | float | str) and not field.is_required():
            word = yaml.safe_load(re.split(r"[ ,]", default.group(1))[0])
            assert word == field.default, name


def test_no_row_is_left_of_a_field_that_is_gone():
    known = (
        common()
        | {name for name, _ in fields()}
        | {get_args(fields_of(model)["kind"].annotation)[0] for _, model in kinds()}
    )
    assert set(re.findall(r"^\| `([\w.]+)` \|", PAGE, re.MULTILINE)) == known
