# SPDX-License-Identifier: GPL-2.0-or-later
"""The page of all fields gives each field a meaning; the kinds and examples of docs/case.md are those of the models."""

import ast
import re
import sys
from pathlib import Path

import pytest
import yaml

import lammps_jump as lj
from lammps_jump.case import fields as models
from lammps_jump.case.field_words import fields_by_name

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


FIELDS = fields_by_name(models.CaseFields)


def test_every_field_has_a_meaning():
    assert len(FIELDS) > 150
    short = {path for path, found in FIELDS.items() if any(len(field.description or "") <= 3 for field in found)}
    assert not short


def test_a_field_without_a_meaning_stops_the_build(monkeypatch):
    class Fields(models.CaseFields):
        untold: int = 0

    monkeypatch.setattr(fields, "CaseFields", Fields)
    with pytest.raises(KeyError, match=r"the case: untold has no description"):
        fields.page()


SOURCES = [
    path
    for pattern in ("lammps_jump/**/*.py", "analysis/**/*.py", "docs/making/*", "docs/**/*.md")
    for path in sorted(ROOT.glob(pattern))
    if path.is_file() and path != DOCS / "reference" / "fields.md"
]


def test_no_meaning_stands_in_a_second_place():
    """Texts of ten words or more: once in the program, and on no page but that of the fields."""
    meanings = {field.description for found in FIELDS.values() for field in found}
    long = {" ".join(text.split()[:10]) for text in meanings if len(text.split()) >= 10}
    joined = {path: re.sub(r'"\s*\n?\s*f?"', "", " ".join(path.read_text().split())) for path in SOURCES}
    places = {text: [str(path.relative_to(ROOT)) for path, whole in joined.items() if text in whole] for text in long}
    assert len(long) > 40 and not {text: files for text, files in places.items() if len(files) > 1}


def tables_of_fields(text: str) -> list[set[str]]:
    """Keys of the dictionaries of a source that give fields of a case, by their dotted names, texts."""
    found = []
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Dict):
            pairs = zip(node.keys, node.values, strict=True)
            texts = {key.value for key, value in pairs if isinstance(key, ast.Constant) and said(value)}
            found.append({key for key in texts if "." in str(key)} & FIELDS.keys())
    return [keys for keys in found if len(keys) > 2]


def said(value: ast.expr) -> bool:
    """Whether a value is a text, or holds one."""
    inner = value.elts if isinstance(value, ast.Tuple) else [value]
    return any(isinstance(one, ast.Constant) and isinstance(one.value, str) for one in inner)


def test_no_table_gives_fields_their_words():
    assert tables_of_fields('{"contact.friction": ("a", ""), "run.seed": "b", "discs.density": "c"}')
    texts = {path.name: path.read_text() for path in SOURCES if path.suffix == ".py"}
    tables = {name for name, text in texts.items() if tables_of_fields(text)}
    # why a channel without ends refuses some fields
    assert tables == {"channel.py"} and not list((DOCS / "making").glob("*.yaml"))


def test_kinds_are_told_by_their_models():
    told = dict(re.findall(r"^## (.*, kind \w+)\n\n(.*)$", fields.page(), re.MULTILINE))
    assert len(told) > 20 and "" not in told.values()
    assert told["walls, kind circle"] == "A circle with discs outside or inside."
    assert told["walls.motion, kind rotate"] == "Steady turning about a point; not of a plane."


@pytest.mark.parametrize("text", EXAMPLES, ids=lambda text: text.split(":")[0])
def test_fields_of_the_examples_exist(text):
    assert set(paths(yaml.safe_load(text))) <= fields.names() | {"walls.kind", "walls.motion.kind"} | KINDS_OF


def test_the_first_example_is_a_whole_case():
    case = lj.load_case(yaml.safe_load(EXAMPLES[0]))
    assert case.fields.inflow.depth == 1


KINDS_OF = {"discs.sizes.kind", "initial.kind", "inflow.kind", "bodies.kind"}


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
