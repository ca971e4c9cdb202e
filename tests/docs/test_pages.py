# SPDX-License-Identifier: GPL-2.0-or-later
"""Pages name fields that exist, and pages to be read first have short sentences."""

import re
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
sys.path.insert(0, str(DOCS))

from making import fields, folder  # noqa: E402

from lammps_jump.analysis.quantities import QUANTITIES  # noqa: E402
from lammps_jump.files import RESULT_FILES, RUN_FILES  # noqa: E402
from lammps_jump.units import numbers_of  # noqa: E402

PAGES = sorted([*DOCS.glob("*.md"), *DOCS.glob("howto/*.md"), ROOT / "README.md"])
NAMES = fields.names()
GROUPS = {"discs", "contact", "run", "engine", "probes", "analysis", "inflow", "domain"}
"""Fields of a case whose fields are named with a dot; a wall, an item of a list, is named by its own name."""
SUMMARY = {
    "run.summary",
    "run.jump",
    "run.front",
    "run.forces",
    "run.energy",
    "run.profiles",
    "run.frames",
    "run.analyse",
}
"""Of the Python object that pages call ``run``."""
FORMER = {"contact.penetration_fraction"}
"""Told as words of earlier versions."""
OF_SUMMARY = {f"{key}.{name}" for key, quantity in QUANTITIES.items() for name in numbers_of(quantity.result)}
"""Keys of ``summary.json``."""
OF_FOLDERS = {*RUN_FILES, *RESULT_FILES, "contact.py", "contact.derive", "discs.fixed", "probes.groups.structures"}
"""Files, a function, a key of the counts, a group of an example."""
NAMED = re.compile(r"`((?:" + "|".join(sorted(GROUPS)) + r")\.[a-z_]+(?:\.[a-z_]+)?)(?=[`=: ])")
LONGEST = 25


def test_every_field_named_on_a_page_exists():
    unknown = [
        f"{page.name}: {name}"
        for page in PAGES
        for name in NAMED.findall(page.read_text())
        if name not in NAMES | SUMMARY | FORMER | OF_SUMMARY | OF_FOLDERS
    ]
    assert not unknown, sorted(unknown)


def test_a_field_that_is_not_there_is_found():
    assert "contact.lagged_restitution" not in NAMES
    assert NAMED.findall("the field `contact.lagged_restitution` and `run.seed=3`") == [
        "contact.lagged_restitution",
        "run.seed",
    ]


def sentences(text: str) -> list[str]:
    """Sentences of a page; code, tables, pictures and headings are left out, items of lists end like sentences."""
    text = re.sub(r"^(```|:::).*?^\1[`:]*$", "", text, flags=re.MULTILINE | re.DOTALL)
    text = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", text)
    blocks = re.split(r"\n\s*\n|\n(?=- )", re.sub(r"^(#|\||>).*$", "\n", text, flags=re.MULTILINE))
    found = []
    for block in blocks:
        found += re.split(r"(?<=[.!?:;])[\s*]+", " ".join(block.split()))
    return [one for one in found if one]


SIMPLE = [
    *sorted(DOCS.glob("howto/*.md")),
    DOCS / "tutorial.md",
    DOCS / "index.md",
    DOCS / "gallery.md",
    ROOT / "README.md",
]


@pytest.mark.parametrize("page", SIMPLE, ids=lambda page: page.name)
def test_sentences_are_short(page):
    assert not [one for one in sentences(page.read_text()) if len(one.split()) > LONGEST]


def test_every_file_of_a_run_folder_is_explained():
    assert set(folder.FILES) == {name for name in (*RUN_FILES, *RESULT_FILES) if not name.startswith("figures/")}


def test_fields_of_the_models_have_their_limits():
    text = fields.page()
    assert "(thesis 3.3) | number | kg/m³ | ≥ 0.001 and ≤ 1e+06 | 1000 |" in text
    assert "above 0 up to 1 | number | \N{EN DASH} | ≥ 1e-06 and ≤ 1 | needed |" in text
