# SPDX-License-Identifier: GPL-2.0-or-later
"""Pages name fields that exist, have short sentences, and explain words of ours."""

import re
import shlex
import sys
from itertools import pairwise, takewhile
from pathlib import Path
from typing import get_args

import pytest
import typer

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
sys.path.insert(0, str(DOCS))

from making import fields, folder, numbers, pages  # noqa: E402

from lammps_jump import Run  # noqa: E402
from lammps_jump.analysis.quantities import QUANTITIES, result_files  # noqa: E402
from lammps_jump.case.fields import CaseFields  # noqa: E402
from lammps_jump.cli.app import app  # noqa: E402
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


def test_tests_that_pages_name_are_there():
    """A file, a folder or a function; a file may be named without its folder."""
    files = {str(path.relative_to(ROOT)): path for path in (ROOT / "tests").rglob("*.py")}
    known = {name.rpartition("/")[2] for name in files}
    known |= {name for path in files.values() for name in re.findall(r"def (test_\w+)", path.read_text())}
    missing = {
        (page.name, name)
        for page in {*PAGES, *ROOT.glob("*.md"), *DOCS.rglob("*.md")} - {ROOT / "CHANGELOG.md"}
        for name in re.findall(r"\b(?:tests/[\w/.]*\w|test_\w+(?:\.py)?)", page.read_text())
        if name not in known and not (ROOT / name).exists()
    }
    assert not missing, missing


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


# --- commands, keys and counts that a page prints ---

APP = typer.main.get_command(app)
PRINTED = re.compile(r"(?:^|`|\$ |&& |; )lammps-jump ((?!simulates|writes|needs)[^`\n]*)", re.MULTILINE)
HELD = {path for path in CaseFields.model_fields} | NAMES
KEYS_OF_OPTIONS = {"--collect", "--of", "--until", "--target", "--columns"}
FIELDS_OF_OPTIONS = {"--set", "--axis", "--vary"}
NUMBER_OF = re.compile(r"[a-z_]\w*(?:\.[\w-]+)+")
UNKNOWN_WORDS = {"…", "CASE", "DIR"}


def words_of(line: str) -> list[str]:
    """Words of a command, up to what is meant for the shell."""
    split = shlex.shlex(line, posix=True, punctuation_chars="|><;&")
    split.whitespace_split = True
    return list(takewhile(lambda word: word[0] not in "|><;&" if word else True, split))


def commands(text: str) -> list[list[str]]:
    """Words of the commands of ours that a page prints, without the name of the program."""
    found = PRINTED.findall(re.sub(r"\s*\\\n\s*", " ", text))
    return [words for one in found if (words := words_of(one))]


def keys() -> list[re.Pattern[str]]:
    """Patterns of all keys of ``summary.json``, as the page of numbers has them."""
    found, path = [], ""
    for line in numbers.page().splitlines():
        if begins := re.match(r"Numbers of `(.*)`:", line):
            path = begins[1]
        elif path and (row := re.match(r"\| `(\w+)` \|", line)):
            found.append(f"{path}.{row[1]}")
    parts = (re.sub(r"<[^>]*>", "\0", one) for one in found)
    return [re.compile(re.escape(one).replace("\0", r"[\w-]+") + "(?:_error)?") for one in parts]


KEYS = keys()


def is_field(path: str) -> bool:
    """Whether there is a field of this path; items of lists have names or numbers."""
    parts = [one for one in path.split(".") if not one.isdigit()]
    named = parts[0] in {*LISTS, "bodies"} and len(parts) > 2
    return bool({".".join(parts), ".".join([parts[0], *parts[2:]]) if named else ""} & HELD)


def wrong_in(words: list[str]) -> str:
    """What is wrong in a command that a page prints; empty for nothing."""
    place, name = APP, "lammps-jump"
    while hasattr(place, "commands") and words and not words[0].startswith("-"):
        name, words = words[0], words[1:]
        if name not in place.commands:
            return f"there is no command {name}"
        place = place.commands[name]
    names = {option for one in place.params for option in (*one.opts, *one.secondary_opts)} | {"--help"}
    names |= {"--install-completion", "--show-completion"} if place is APP else set()
    for word, given in pairwise([*words, ""]):
        option, _, value = word.partition("=")
        if not option.startswith("-") or option == "-" or re.match(r"-[\d.]", option):
            continue
        if option not in names:
            return f"{name} has no option {option}"
        told = value or given
        if option in FIELDS_OF_OPTIONS and told not in UNKNOWN_WORDS:
            path = told.partition("=")[0]
            if re.match(r"[a-z]", path) and not is_field(path):
                return f"there is no field {path}"
        if option in KEYS_OF_OPTIONS - {"--columns"} and told not in UNKNOWN_WORDS:
            unknown = [key for key in NUMBER_OF.findall(told) if not any(one.fullmatch(key) for one in KEYS)]
            if unknown:
                return f"there is no number {unknown[0]}"
    scenes = [word for word in words if word.startswith("inputs/")]
    scenes += [f"inputs/{word}.yaml" for word in words[:1] if name == "new"]
    gone = [one for one in scenes if not (ROOT / one).is_file()]
    return f"there is no scene {gone[0]}" if gone else ""


@pytest.mark.parametrize("page", [*PAGES, ROOT / "CONTRIBUTING.md"], ids=lambda page: page.name)
def test_every_command_that_a_page_prints_is_so(page):
    text = page.read_text()
    own = set(re.findall(r"^# (inputs/\S+\.yaml)$", text, re.MULTILINE))  # a page that writes a file of its own
    found = {" ".join(one): said for one in commands(text) if (said := wrong_in(one)) and said.split()[-1] not in own}
    assert not found


@pytest.mark.parametrize(
    ("command", "said"),
    [
        ("chek my.yaml", "no command chek"),
        ("check my.yaml --sett a=1", "no option --sett"),
        ("check my.yaml --set contact.frction=1", "no field contact.frction"),
        ("sweep my.yaml --axis walls.sill.hight.1=1", "no field walls.sill.hight.1"),
        ("sweep my.yaml --collect jump.y3", "no number jump.y3"),
        ("find my.yaml --until 'stability.box.slid >= 1'", "no number stability.box.slid"),
        ("kernels make", "no command make"),
        ("new dam", "no scene inputs/dam.yaml"),
        ("build-and-run inputs/jump.yaml", "no scene inputs/jump.yaml"),
    ],
)
def test_a_command_that_is_not_so_is_found(command, said):
    found = commands(f"$ lammps-jump {command} > out\n`lammps-jump {command}`  # why")
    assert found == [shlex.split(command)] * 2 and said in wrong_in(found[0])


RESULTS = re.compile(r"`((?:" + "|".join(QUANTITIES) + r")\.[a-z]\w*(?:\.[a-z]\w*)*)`")
OTHER_KEYS = {"jump.members", "jump.local", "tailgate.sill.at_limit", "waves.hydrostatic_force", "jump.py", "waves.py"}
"""Parts of the summary that hold no number with a unit, a function, and files."""


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_number_named_on_a_page_is_one_of_the_summary(page):
    named = {key for key in RESULTS.findall(page.read_text()) if not exists(key)}
    kept = {f"{key}.{part}" for key, one in QUANTITIES.items() for part in (*one.parts, "verdict")}
    assert not {key for key in named - kept - OF_FOLDERS - OTHER_KEYS if not any(one.fullmatch(key) for one in KEYS)}


COUNTS = {
    r"folder `inputs/` has (\d+) scenes": lambda: len(list((ROOT / "inputs").glob("*.yaml"))),
    r"`make cross-validation` runs (\w+) scenes": lambda: len(
        re.search(r"for scene in (.*?); do \S* cross-validate", (ROOT / "Makefile").read_text())[1].split()
    ),
}  # fmt: skip
"""Counts that pages print, and what they count."""
WORDS = "no one two three four five six seven eight nine ten eleven twelve".split()


@pytest.mark.parametrize("form", COUNTS)
def test_every_count_that_a_page_prints_is_so(form):
    said = [one for page in PAGES for one in re.findall(form, page.read_text())]
    assert said and {WORDS.index(one) if one in WORDS else int(one) for one in said} == {COUNTS[form]()}
