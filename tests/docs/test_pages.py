# SPDX-License-Identifier: GPL-2.0-or-later
"""Pages name fields that exist, have short sentences, and explain words of ours."""

import re
import sys
from pathlib import Path
from typing import get_args

import pytest

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
sys.path.insert(0, str(DOCS))

from making import fields, folder, pages  # noqa: E402

from lammps_jump import Run  # noqa: E402
from lammps_jump.analysis.quantities import QUANTITIES, result_files  # noqa: E402
from lammps_jump.case.fields import CaseFields  # noqa: E402
from lammps_jump.files import RESULT_FILES, RUN_FILES  # noqa: E402
from lammps_jump.units import numbers_of  # noqa: E402

pytestmark = pytest.mark.prose
PAGES = sorted([*DOCS.glob("*.md"), *DOCS.glob("howto/*.md"), ROOT / "README.md"])
NAMES = fields.names()
LISTS = {"walls", "initial", "outflow"}
"""Lists of a case: ``walls.friction`` is a field of each item, ``walls.sill.y`` that of the wall ``sill``."""
GROUPS = {"discs", "contact", "run", "engine", "probes", "analysis", "inflow", "domain", *LISTS}
"""Fields of a case whose fields are named with a dot."""
SUMMARY = {
    "run.summary",
    *(f"run.{name}" for name in dir(Run) if not name.startswith("_")),
} | {f"run.{name}" for name in QUANTITIES}
"""Of the Python object that pages call ``run``."""
OF_SUMMARY = {f"{key}.{name}" for key, quantity in QUANTITIES.items() for name in numbers_of(quantity.result)}
"""Keys of ``summary.json``."""
OF_FOLDERS = {
    *RUN_FILES,
    *result_files(),
    "contact.py",
    "contact.derive",
    "discs.fixed",
    "probes.groups.structures",
} | {
    "walls.py",
    "walls.bed",
}
"""Files, a function, a key of the counts, a group and a wall of examples."""
NAMED = re.compile(r"`((?:" + "|".join(sorted(GROUPS)) + r")\.[a-z_]\w*(?:\.[a-z_]+)*(?:\.\d+)?)(?=[`=: ])")
LONGEST = 25


def exists(name: str) -> bool:
    """Whether there is a field or number of this name; the name or number of an item of a list is left out."""
    name = re.sub(r"\.\d+$", "", name)
    group, _, rest = name.partition(".")
    short = f"{group}.{rest.partition('.')[2]}" if group in LISTS else name
    return bool({name, short} & (NAMES | SUMMARY | OF_SUMMARY | OF_FOLDERS))


def test_every_field_named_on_a_page_exists():
    unknown = [f"{page.name}: {name}" for page in PAGES for name in NAMED.findall(page.read_text()) if not exists(name)]
    assert not unknown, sorted(unknown)


def test_a_field_that_is_not_there_is_found():
    assert "contact.lagged_restitution" not in NAMES
    assert NAMED.findall("the field `contact.lagged_restitution` and `run.seed=3`") == [
        "contact.lagged_restitution",
        "run.seed",
    ]


@pytest.mark.parametrize("name", ["walls.friction", "walls.sill.y.1", "outflow.x_beyond", "walls.lid.motion.mass"])
def test_fields_of_lists_are_known(name):
    assert NAMED.findall(f"`{name}`") == [name] and exists(name)


@pytest.mark.parametrize("name", ["walls.frction", "walls.sill.hight", "outflow.beyond", "initial.gap"])
def test_fields_of_lists_that_are_not_there_are_found(name):
    assert NAMED.findall(f"`{name}`") == [name] and not exists(name)


VALUES = {"friction_law": "contact", "touch": "contact", "kernel": "engine"}
"""Fields whose values are words of ours, and the groups that they are in."""


@pytest.mark.parametrize("field", VALUES)
def test_the_glossary_has_every_value(field):
    group = CaseFields.model_fields[VALUES[field]].annotation.model_fields[field]
    values = [one for kind in (group.annotation, *get_args(group.annotation)) for one in get_args(kind)] or get_args(
        group.annotation
    )
    text = (DOCS / "glossary.md").read_text()
    missing = [one for one in values if isinstance(one, str) and one != "auto" and one not in text]
    assert values and not missing


def sentences(text: str) -> list[str]:
    """Sentences of a page; code, tables, pictures and headings are left out, items of lists end like sentences."""
    text = re.sub(r"^ *(```|:::).*?^ *\1[`:]*$", "", text, flags=re.MULTILINE | re.DOTALL)
    text = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", text)
    blocks = re.split(r"\n\s*\n|\n(?=- )", re.sub(r"^(#|\||>).*$", "\n", text, flags=re.MULTILINE))
    found = []
    for block in blocks:
        found += re.split(r"(?<=[.!?:;])[\s*]+", " ".join(block.split()))
    return [one for one in found if one]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_sentences_are_short(page):
    assert not [one for one in sentences(page.read_text()) if len(one.split()) > LONGEST]


HOUSE = {
    "member": "members?",
    "starts": r"(?:over|between|of|\d+|two|four|eight|ten|twelve|sixteen|several) starts",
    "kernel": "kernels?",
    "f": "f(?= =)",
    "mass depth": "mass depth",
    "touch": "(?:sharp|smooth) touch|touch:",
}
"""Words of ours, to be explained where a reader first meets them."""


def unexplained(text: str) -> list[str]:
    """House words of a page that are used before they stand in italics, where no link leads to the glossary."""
    prose = re.sub(r"`[^`]*`", "", " ".join(sentences(text)))
    found = []
    for word, form in HOUSE.items():
        told = re.search(rf"\*{word.removesuffix('s')}s?\*", prose)
        hit = re.search(rf"\b(?:{form})(?:\b|$)", prose)
        if hit and "glossary.md" not in text and not (told and told.start() < hit.start()):
            found.append(word)
    return found


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_house_words_are_explained(page):
    assert not unexplained(page.read_text())


def test_a_house_word_that_is_not_explained_is_found():
    assert unexplained("Run eight members. A *member* is one start.") == ["member"]
    assert not unexplained("A *member* is one start. Run eight members, `kernel`.")
    assert unexplained("The mean over starts. A *start* is a run with its own seed.") == ["starts"]


def test_every_file_of_a_run_folder_is_explained():
    assert set(folder.FILES) == {*RUN_FILES, *RESULT_FILES}


@pytest.mark.parametrize("name", pages.REFERENCE)
def test_the_reference_in_the_source_tree_is_that_of_the_program(name):
    page = DOCS / "reference" / f"{name}.md"
    assert page.read_text() == pages.REFERENCE[name](), f"{page.name} is stale: `make reference` writes it again"


def test_fields_of_the_models_have_their_limits():
    text = fields.page()
    assert "(thesis 3.3) | number | kg/m³ | ≥ 0.001 and ≤ 1e+06 | 1000 |" in text
    assert "tilts gravity towards larger x | number | degrees | > -90 and < 90 | 0 |" in text  # of the whole case
    assert "of a collision | number | \N{EN DASH} | ≥ 1e-06 and ≤ 1 | needed |" in text
