# SPDX-License-Identifier: GPL-2.0-or-later
"""The page of all fields gives each field a meaning; the kinds and examples of docs/case.md are those of the models."""

import re
import sys
from pathlib import Path
from typing import get_args

import pytest
import yaml

import lammps_jump as lj
from lammps_jump.case import fields as models
from lammps_jump.case.explain import fields_of
from lammps_jump.scene.walls import Motions

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
sys.path.insert(0, str(DOCS))

from making import fields  # noqa: E402

PAGE = (DOCS / "case.md").read_text()
EXAMPLES = re.findall(r"^```yaml\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)

SHOWN = {
    f"{page.name}, {number}": yaml.safe_load(text)
    for page in (*sorted(DOCS.glob("*.md")), *sorted(DOCS.glob("howto/*.md")))
    for number, text in enumerate(re.findall(r"^```yaml\n(.*?)^```$", page.read_text(), re.MULTILINE | re.DOTALL), 1)
}
"""Examples of all pages."""
OF_CASES = {name: data for name, data in SHOWN.items() if data.keys() <= models.CaseFields.model_fields.keys()}
SCENES = {path.stem: yaml.safe_load(path.read_text()) for path in sorted(ROOT.glob("inputs/*.yaml"))}


def kinds(union: object) -> set[str]:
    return {get_args(fields_of(model)["kind"].annotation)[0] for model in get_args(get_args(union)[0])}


def in_table(head: str) -> set[str]:
    table, _, _ = PAGE.partition(f"| {head} |")[2].partition("\n\n")
    return set(re.findall(r"^\| `(\w+)` \|", table, re.MULTILINE))


def test_every_field_has_a_meaning_and_no_meaning_is_left_over():
    assert fields.keys() == set(fields.MEANINGS)
    assert all(len(text) > 3 for text in fields.MEANINGS.values())


def test_a_field_without_a_meaning_stops_the_build(monkeypatch):
    monkeypatch.delitem(fields.MEANINGS, "contact.friction")
    with pytest.raises(KeyError, match=r"contact\.friction"):
        fields.page()


def test_kinds_of_walls_and_motions_are_told():
    assert in_table("kind") == kinds(models.WallField)
    assert in_table("kind of motion") == kinds(Motions)


@pytest.mark.parametrize("text", EXAMPLES, ids=lambda text: text.split(":")[0])
def test_fields_of_the_examples_exist(text):
    assert set(paths(yaml.safe_load(text))) <= fields.names() | {"walls.kind", "walls.motion.kind"} | KINDS_OF


def test_the_first_example_is_a_whole_case():
    case = lj.load_case(yaml.safe_load(EXAMPLES[0]))
    assert case.fields.inflow.depth == 1


KINDS_OF = {"discs.sizes.kind", "initial.kind", "inflow.kind"}


def paths(value: object, path: str = ""):
    """Dotted names of all fields in a piece of a case."""
    if isinstance(value, dict):
        for name, inner in value.items():
            yield f"{path}.{name}".removeprefix(".")
            yield from paths(inner, f"{path}.{name}")
    elif isinstance(value, list):
        for inner in value:
            yield from paths(inner, path)


def kinds_in(value: object, path: str = ""):
    """Groups of a case with their kinds, as the headings of the page of all fields write them."""
    if isinstance(value, dict):
        if "kind" in value:
            yield f"{path}, kind {value['kind']}"
        for name, inner in value.items():
            yield from kinds_in(inner, f"{path}.{name}".removeprefix("."))
    elif isinstance(value, list):
        for inner in value:
            yield from kinds_in(inner, path)


def test_every_kind_and_every_analysis_has_an_example_in_a_scene_or_page():
    examples = [*SCENES.values(), *OF_CASES.values()]
    shown = {kind for one in examples for kind in kinds_in(one)} | {name for one in examples for name in paths(one)}
    headings = re.findall(r"^## (.*)$", fields.page(), re.MULTILINE)
    wanted = {title for title in headings if ", kind " in title}
    wanted |= {name for name in fields.names() if re.fullmatch(r"analysis\.\w+", name)}
    assert "walls.motion, kind table" in wanted and "analysis.drum" in wanted
    missing = wanted - shown
    assert not missing


@pytest.mark.parametrize("name", [name for name in OF_CASES if "file" not in str(OF_CASES[name])])
def test_examples_of_the_pages_are_taken(name):
    whole = yaml.safe_load(EXAMPLES[0])
    part = OF_CASES[name]
    if part.get("initial"):
        whole.pop("inflow")
        whole.pop("analysis")
    if "probes" in part:  # names walls of its own
        part = part | {"walls": [{"name": one, "kind": "circle", "centre": [9, 9], "radius": 1} for one in named(part)]}
    if any(item["kind"] == "run" for item in part.get("initial") or ()):  # of a run that is not there
        assert models.CaseFields.model_validate({"name": "after_a_run", **whole, **part})
        return
    assert lj.load_case({**whole, **part}).fields


def named(part: dict) -> set[str]:
    return {
        *part["probes"].get("forces", ()),
        *(one for group in part["probes"].get("groups", {}).values() for one in group),
    }
