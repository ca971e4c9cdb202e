# SPDX-License-Identifier: GPL-2.0-or-later
"""The table "Where a change goes" of CONTRIBUTING.md: no file beside it knows a wall or a law by its name.

A wall of a new shape and a new motion are made here, outside the program, and run through it. The additions of
docs/extending.md are pasted into a copy of the program.
"""

import ast
import json
import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Annotated, Literal, get_args

import numpy as np
import pytest
import typer
import yaml
from made_up import Here, call
from pydantic import Field

import lammps_jump.case
import lammps_jump.case.case as cases
from lammps_jump import studies
from lammps_jump.analysis.flow import from_scene
from lammps_jump.analysis.quantities import LISTED, ListedAnalysis, captions, result_files
from lammps_jump.analysis.report.run import write_report
from lammps_jump.analysis.tables import main_numbers, rows_of
from lammps_jump.case import field_words
from lammps_jump.case.doubts import facts
from lammps_jump.case.fields import Analysis, CaseFields, Contact, asked_for
from lammps_jump.cli import app as cli_app
from lammps_jump.cli import studies as cli_studies
from lammps_jump.cli import tools
from lammps_jump.cli.options import Commands
from lammps_jump.cli.progress import show_markdown
from lammps_jump.dump.frame import make_frame
from lammps_jump.dump.write import DumpWriter
from lammps_jump.engines.native import NativeSimulation, WithoutDiscs
from lammps_jump.errors import CaseError, SetupError
from lammps_jump.folders import Marker, read_marker, require_ours
from lammps_jump.physics.slip import FRICTION_LAWS
from lammps_jump.runs.results import analyse, flow_of, packer_for
from lammps_jump.scene.chains import Chain
from lammps_jump.scene.motion import Motion, MovingWall
from lammps_jump.scene.scene import handmade_scene
from lammps_jump.scene.tracks import Kind, VelocityChange
from lammps_jump.scene.walls import KINDS, Block, Wall, WallName
from lammps_jump.script.stock import lacking
from lammps_jump.studies import points as points_study
from lammps_jump.sweeps import study
from lammps_jump.sweeps.study import collected
from lammps_jump.sweeps.table import row_of
from lammps_jump.units import Coordinate, Metre, PerSecond

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "docs"))

from making import fields  # noqa: E402

STUDIES = ("lammps_jump/studies/", "lammps_jump/cli/")
"""What runs the program with one choice or another; a new choice changes nothing there."""


@cache
def table() -> dict[str, set[str]]:
    """Files of each row, by its change."""
    text = (ROOT / "CONTRIBUTING.md").read_text().partition("## Where a change goes")[2]
    rows = re.findall(r"^\| ((?:an?|how) [^|]+) \| ([^|]+) \|$", text, re.MULTILINE)
    return {change: {inside(name) for name in re.findall(r"`([\w/.]+)`", files)} for change, files in rows}


def law_files() -> set[str]:
    """Files of a friction law with a name: those of its formula, and those that know the name."""
    return table()["a formula of the contact"] | table()["a friction law with a name of its own"]


def inside(name: str) -> str:
    """Path of a file or folder of the table."""
    return name.rstrip("/") if name.startswith(("analysis/", "validation/")) else f"lammps_jump/{name.rstrip('/')}"


@cache
def texts() -> dict[str, str]:
    """All files of the program but the studies."""
    folders = ("lammps_jump", "analysis")
    paths = (path for folder in folders for end in ("py", "h", "cpp") for path in (ROOT / folder).rglob(f"*.{end}"))
    found = {str(path.relative_to(ROOT)): path.read_text(encoding="utf-8") for path in paths}
    return {file: text for file, text in found.items() if not file.startswith(STUDIES)}


def nodes(words: set[str]):
    """(file, node) of the Python files that hold one of the words."""
    named = re.compile(rf"\b({'|'.join(words)})\b")
    for file, text in texts().items():
        if file.endswith(".py") and named.search(text):
            yield from ((file, node) for node in ast.walk(ast.parse(text)))


def test_the_files_of_the_table_are_there():
    assert len(table()) == 13 and len(table()["an analysis"]) == len(table()["a study"]) == 2
    for files in table().values():
        assert files and all((ROOT / file).exists() for file in files), files


def test_nothing_else_knows_a_wall_by_its_kind():
    """Shapes are chains: other files make walls, and may not ask which one they have."""
    kinds = {kind.__name__ for kind in get_args(KINDS)}
    names = {kind.__dataclass_fields__["kind"].default for kind in get_args(KINDS)}
    assert len(kinds) == len(names) >= 3
    asking = set()
    for file, node in nodes(kinds | names):
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "isinstance":
            found = kinds & {part.id for part in ast.walk(node.args[1]) if isinstance(part, ast.Name)}
        elif isinstance(node, ast.Compare) and getattr(node.left, "attr", "") == "kind":
            found = names & {part.value for part in ast.walk(node) if isinstance(part, ast.Constant)}
        else:
            continue
        asking |= {file} if found else set()
    assert asking <= table()["a wall"], asking - table()["a wall"]


def test_nothing_else_knows_a_friction_law_by_its_name():
    default = Contact.model_fields["friction_law"].default
    names = set(FRICTION_LAWS) - {default}
    assert set(FRICTION_LAWS) == set(get_args(Contact.model_fields["friction_law"].annotation)) and names
    knowing = {file for file, node in nodes(names) if isinstance(node, ast.Constant) and node.value in names}
    quoted = re.compile(f'"({"|".join(names)})"')
    knowing |= {file for file, text in texts().items() if not file.endswith(".py") and quoted.search(text)}
    formulas = {"lammps_jump/physics/law.py", "lammps_jump/core/contact/law.h"}
    assert knowing | formulas == law_files()


def test_few_files_know_a_number_of_the_law_by_its_name():
    """Formula and number of both engines, the scene; the case has a field."""
    knowing = {file for file, text in texts().items() if "cohesion" in text}
    knowing = {file for file in knowing if not file.startswith("lammps_jump/case/")}
    assert knowing == table()["a number of the contact law"] and len(knowing) <= 4


def test_only_one_header_puts_the_slots_of_a_law_together():
    """Another file that asks a slot for its force, energy or part would be a second contact."""
    asks = re.compile(r"\b(normal|damping|tangential)\.(force|energy|pressing|against_rolling)\b")
    assert {file for file, text in texts().items() if asks.search(text)} == {"lammps_jump/core/contact/contact.h"}


PAGE = (ROOT / "docs" / "extending.md").read_text()
PASTED = re.compile(
    r"^`([\w/.]+)`, (?:(above|in place of) `([^\n]+)`|a (new file)):\n\n```[\w+]+\n(.*?)^```", re.MULTILINE | re.DOTALL
)
"""A block of docs/extending.md: file, what is done, the text of the file that it is done to, or that it is new."""
COPIED = re.compile(r"^`([\w/.]+)`, a copy of `([\w/.]+)`$", re.MULTILINE)
NUMBER = "A new number of the contact law"
CONTACT = (
    "A formula of the contact",
    "A friction law with a name of its own",
    "How a contact is put together",
    "A friction law with a formula of its own",
)
ROWS = {
    "a wall": ("A new wall",),
    "a motion of a wall": ("A new motion",),
    "a field of a case": ("A new field of a case",),
    "a formula of the contact": CONTACT[:1],
    "a number of the contact law": (NUMBER,),
    "how a contact is put together: lever, slip, torque, memory": CONTACT[2:3],
    "a friction law with a name of its own": CONTACT[1:2],
    "a friction law with a formula of its own": CONTACT[3:],
    "an analysis": ("A new quantity",),
    "a variable of the profiles": ("A new variable of the profiles",),
    "a verdict, or what makes one doubtful": ("A new verdict",),
    "a study": ("A new study",),
    "a command or an option": ("A new command", "A new option"),
}
"""Sections of docs/extending.md that execute each row of the table."""
BESIDE = {
    "an analysis": {"analysis/spread.py"},
    "a number of the contact law": {"lammps_jump/case/contact.py"},
}
"""Files that a row tells in words: its own file, its field of a case."""


def recipes() -> dict[str, str]:
    """Sections of docs/extending.md with something to paste, by their heading."""
    _, *parts = re.split(r"^## ", PAGE, flags=re.MULTILINE)
    return {head: text for head, _, text in (part.partition("\n") for part in parts) if PASTED.search(text)}


def paste(recipe: str, tree: Path) -> set[str]:
    """Do in a copy of the tree what a person does with a recipe; returns the files."""
    files = set()
    for file, how, there, new, block in PASTED.findall(recipe):
        path, there = tree / file, there.replace("\\n", "\n")
        files.add(file)
        if new:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(block)
            continue
        text = path.read_text()
        assert text.count(there) == 1, (file, there)
        if how == "above":
            apart = "\n\n" if block.startswith(("@", "def ", "class ")) else ""
            text = text.replace(there, f"{block}{apart}{there}")
        else:
            text = text.replace(there, block.rstrip("\n"))
        path.write_text(text)
    for file, source in COPIED.findall(recipe):
        shutil.copy(tree / source, tree / file)
        files.add(file)
    return files


def edited(recipe: str) -> set[str]:
    """Files of the program that a recipe changes or makes."""
    files = {file for file, *_ in PASTED.findall(recipe)} | {file for file, _ in COPIED.findall(recipe)}
    return {file for file in files if not file.startswith(("tests/", "docs/"))}


def test_every_row_of_the_table_is_executed_by_a_section():
    """A recipe edits no file that its row does not name."""
    assert ROWS.keys() == table().keys() and {head for heads in ROWS.values() for head in heads} == recipes().keys()
    for row, heads in ROWS.items():
        files = set().union(*(edited(recipes()[head]) for head in heads))
        may = table()[row] | BESIDE.get(row, set())
        left = {file for file in files - may if not any(file.startswith(f"{folder}/") for folder in may)}
        assert files and not left, (row, left)


def copy_of_tree(tree: Path) -> None:
    """What a person edits, without what is made of it; what mypy knows of it stays, and saves a minute."""
    made = shutil.ignore_patterns("__pycache__", "carried", "*.egg-info", ".pytest_cache", ".ruff_cache")

    def left(folder: str, names: list[str]) -> set[str]:
        top = {".venv", ".git", "build", "runs"} if Path(folder) == ROOT else set()  # lammps_jump/runs is ours
        return made(folder, names) | top & set(names)

    shutil.copytree(ROOT, tree, symlinks=True, ignore=left)


def tried(tree: Path, *command: str, inside: str = ".") -> subprocess.CompletedProcess[str]:
    """A Python program on a copy of the tree, in a folder of it."""
    here = os.environ | {"PYTHONPATH": str(tree), "LAMMPS_JUMP_CACHE": str(tree.parent / "cache")}
    return subprocess.run([sys.executable, *command], cwd=tree / inside, env=here, capture_output=True, text=True)


@pytest.mark.parametrize("head", recipes())
def test_a_recipe_can_be_pasted_and_is_clean(head, tmp_path):
    """What each block is put beside is there once, and ruff finds nothing in what comes of it."""
    recipe = recipes()[head]
    for file in {file for file, *_, new, _ in PASTED.findall(recipe) if not new} | {
        source for _, source in COPIED.findall(recipe)
    }:
        (tmp_path / file).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / file, tmp_path / file)
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    files = [file for file in sorted(paste(recipe, tmp_path)) if file.endswith(".py")]
    for command in (("check",), ("format", "--check")):
        done = tried(tmp_path, "-m", "ruff", *command, "--no-cache", *files)
        assert done.returncode == 0, done.stdout


OTHER_PHYSICS = (CONTACT[0], CONTACT[2])
"""Sections that change what engines compute: tests of closed forms fail, as these say."""


def named_by(head: str) -> set[str]:
    """Tests that a section says that its change meets."""
    (told,) = re.findall(r"^Tests: (.+)\.$", recipes()[head], re.MULTILINE)
    return set(re.findall(r"`([\w/.]+)`", told))


def met() -> list[str]:
    """Tests that all sections name, and those that every change meets; each once, but those of other physics."""
    physics = set().union(*map(named_by, OTHER_PHYSICS))
    named = set().union(*map(named_by, recipes())) - physics
    return sorted({"tests/test_house.py", "tests/docs", "tests/test_where_a_change_goes.py"} | named)


def test_every_section_names_tests_that_are_there():
    for head in recipes():
        assert named_by(head) and all((ROOT / name).exists() for name in named_by(head)), head


NOT_MET = "not recipe and not section and not stands_in_a_place and not new_wall"
"""Left out of them: a recipe cannot be pasted twice; faults of a place are those of the command, not of the recipe."""
STALE = (
    "tests/docs/test_pages.py::test_the_reference_in_the_source_tree_is_that_of_the_program[",
    "tests/faults/test_places.py::test_the_page_shows_what_is_tried",
)
"""Tests that `make reference` mends."""


@pytest.mark.long
def test_recipes_meet_no_failure_that_they_do_not_name(tmp_path):
    """All of them in one copy: lint and types, then the tests; `make reference` mends what fails."""
    tree = tmp_path / "copy"
    copy_of_tree(tree)
    for recipe in recipes().values():
        paste(recipe, tree)
    for command in (["-m", "ruff", "check", "."], ["-m", "ruff", "format", "--check", "."], ["-m", "mypy"]):
        done = tried(tree, *command)
        assert done.returncode == 0, done.stdout
    tests = ["-m", "pytest", "-q", "-n", "0", "-p", "no:cacheprovider", "-m", "not long and not docs", "-k", NOT_MET]
    done = tried(tree, *tests, *met())
    failed = re.findall(r"^(?:FAILED|ERROR) (\S+)", done.stdout, re.MULTILINE)
    unnamed = [test for test in failed if not test.startswith(STALE)]
    assert failed and not unnamed, f"{unnamed}\n{done.stdout}"
    assert tried(tree, "-m", "making.pages", inside="docs").returncode == 0  # make reference
    assert tried(tree, "tests/fault_table.py").returncode == 0
    again = "tests/docs/test_pages.py", "tests/faults/test_places.py", "tests/test_house.py"
    done = tried(tree, *tests, *again)
    assert done.returncode == 0, done.stdout[-3000:]


RUN_OF_IT = """
import importlib.util, sys, tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

tests = Path(sys.argv[1])
sys.path.insert(0, str(tests))
spec = importlib.util.spec_from_file_location("rig", tests / "contacts" / "conftest.py")
rig = sys.modules["rig"] = importlib.util.module_from_spec(spec)
spec.loader.exec_module(rig)

from made_up import disc_frame

from lammps_jump.analysis.contacts import elastic_energy, touching, whole_forces
from lammps_jump.analysis.flow import from_scene
from lammps_jump.engines.native import NativeSimulation
from lammps_jump.engines.twin import Twin
from lammps_jump.scene import Plane, handmade_scene
from lammps_jump.script.stock import lacking

places, more = np.array([[0.0, 0.095], [0.19, 0.2], [0.05, 0.28]]), 2e6
settings = {"friction": 0.3, "restitution": 0.5, "steps": 500, "output_steps": 500, "skin": 0.06}
for touch in ({"touch": "smooth", "touch_width": 0.004}, {}):
    one = handmade_scene(places, 0 * places, (Plane("floor", "y", 0.0, "above"),), made_up=more, **settings, **touch)
    c = one.coefficients
    stiff = replace(c, stiffness=c.stiffness + more, stiffness_wall=c.stiffness_wall + more)
    stiffer = replace(one, made_up=0.0, coefficients=stiff)
    ends, energies = [], []
    for scene in (one, stiffer):
        for loops in (None, Twin()):
            simulation = NativeSimulation(scene, loops=loops)
            energies.append(simulation.ledger["elastic"])
            simulation.run(200)
            ends.append(simulation.positions)
        compiled = rig.start("compiled", scene, [], Path(tempfile.mkdtemp()))
        compiled.run(200)
        ends.append(compiled.positions)
        compiled.close()
        frame, flow = disc_frame(*places.T, box=[[0, 1], [0, 1]]), from_scene(scene)
        energies.append(elastic_energy(touching(frame, flow), flow))
    np.testing.assert_allclose(ends, [ends[-1]] * len(ends), atol=1e-9)
    np.testing.assert_allclose(energies, energies[-1], rtol=1e-12)
from lammps_jump.case.case import ReadCase
from lammps_jump.studies.fluid.cell import discs_of

case = ReadCase.parse(sys.argv[2], changes={"contact.made_up": more})
assert case.scene().law_numbers("bed").made_up == discs_of(case).scene.law_numbers().made_up == more
assert np.abs(ends[0] - places).max() > 1e-3 and lacking(one) == "'contact.made_up'" and not lacking(stiffer)

turned = []
for law in ("steep", "soft"):
    spun = replace(stiffer, rotation=True, friction_law=law)
    ends = []
    for loops in (None, Twin()):
        simulation = NativeSimulation(spun, loops=loops)
        simulation.run(200)
        ends.append(np.column_stack([simulation.positions, simulation.discs.omega[:3]]))
    compiled = rig.start("compiled", spun, [], Path(tempfile.mkdtemp()))
    compiled.run(200)
    np.testing.assert_allclose(compiled.positions, ends[0][:, :2], atol=1e-9)
    compiled.close()
    np.testing.assert_allclose(*ends, atol=1e-9)
    turned.append(np.abs(ends[0][:, 2]).max())
    assert turned[-1] > 1e-3
assert abs(turned[0] - turned[1]) > 1e-3

speeds = np.array([[0.1, 0.2], [0.3, 0.0], [-0.2, 0.1]])
sliding = replace(spun, rotation=False, velocities=speeds, gravity=(0.0, 0.0))
discs, flow = NativeSimulation(sliding).discs, from_scene(sliding)
moving = disc_frame(*places.T, *speeds.T, box=[[0, 1], [0, 1]])
found, total = touching(moving, flow), np.zeros((4, 2))
acting = np.transpose(whole_forces(moving, flow, found))
np.add.at(total, found.second, acting)
np.add.at(total, found.first, -acting)
np.testing.assert_allclose(total[:3], np.transpose([discs.fx[:3], discs.fy[:3]]), rtol=1e-9)
"""


@pytest.mark.long
@pytest.mark.lammps
def test_changes_of_the_contact_act_on_all_engines(tmp_path):
    """A number, a formula, a law with a name and a lever in one copy: native engine, compiled styles and twin agree."""
    tree = tmp_path / "copy"
    copy_of_tree(tree)
    for head in (NUMBER, *CONTACT):
        paste(recipes()[head], tree)
    (tmp_path / "run.py").write_text(RUN_OF_IT)
    plain = "\n".join(line for line in CASE.splitlines() if "arch" not in line)
    done = tried(tree, "-P", str(tmp_path / "run.py"), str(ROOT / "tests"), plain)
    assert done.returncode == 0, done.stdout + done.stderr


@dataclass(frozen=True)
class Arch(Wall):
    """Half a ring that stands on the bed: two arcs and two level feet, solid between them."""

    kind: Literal["arch"] = field(default="arch", kw_only=True, repr=False)
    name: WallName
    x: Coordinate
    outer: Annotated[Metre, Field(ge=1e-6, le=1e6)]
    inner: Annotated[Metre, Field(ge=1e-6, le=1e6)]

    def chains(self):
        """Over the outside from left to right, and back along the inside."""
        far, near = self.outer, self.inner
        corners = [(self.x + dx, 0.0) for dx in (-far, far, near, -near)]
        return (Chain(tuple(corners), (-far, 0.0, near, 0.0), closed=True),)


CASE = """
discs: {diameter: 0.2}
contact: {restitution: 0.4, friction: 0.3, impact_speed: 6}
domain: {x: [-4, 4], y: [-1, 5]}
walls:
  - {name: bed, kind: plane, axis: y, at: 0, side: above}
  - {name: arch, kind: arch, x: 0, outer: 1.2 m, inner: 0.8}
initial:
  - {kind: list, positions: [[0.05, 1.6], [-0.9, 1.4], [0.0, 0.3]], velocities: [[0, -3], [1, -2], [0, 3]]}
probes: {forces: [arch]}
run: {duration: 0.5}
engine: {name: native}
"""


def test_a_wall_of_a_new_shape_runs_without_another_change(monkeypatch):
    class Fields(CaseFields):
        walls: tuple[Annotated[KINDS | Arch, Field(discriminator="kind")], ...] = ()

    monkeypatch.setattr(cases, "CaseFields", Fields)
    case = cases.ReadCase.parse(CASE)
    scene = case.scene()
    arch = scene.wall("arch")
    assert arch == Arch("arch", 0.0, 1.2, 0.8) and str(case.check())
    simulation = NativeSimulation(scene)
    simulation.run(scene.steps)
    above = np.hypot(*simulation.positions.T)
    assert (above[:2] > 1.29).all() and above[2] < 0.71  # on the ring, and below it
    assert {name for _, name, *force in simulation.forces if any(force)} == {"arch"}
    (*_, begin, end), (*_, last) = WithoutDiscs(scene).walls.faces.first, scene.walls
    assert last.wall.name == "arch" and end - begin == len(arch.faces.codes) >= 4
    assert "'arch'" in lacking(scene)
    x = np.array([-0.6, 0.0, 1.0, 2.0])
    bed = [0.0, 0.0, np.sqrt(0.44), 0.0]  # it runs below the arch, and over its foot
    np.testing.assert_allclose(from_scene(scene).bed_height(x), bed, atol=1e-14)


@dataclass(frozen=True)
class Hops(Kind):
    """A wall that jumps up and comes down again."""

    kind: str = field(default="hops", kw_only=True, repr=False)
    speed: float = 1.0

    def corners(self, ease):
        up = (0.0, self.speed, 0.0)
        return [
            VelocityChange(0.1, up, ease),
            VelocityChange(0.3, (0.0, -2 * self.speed, 0.0), ease),
            VelocityChange(0.5, up, ease),
        ]


def test_a_new_motion_runs_without_another_change():
    floor = Block("floor", (-2.0, 2.0), (-1.0, 0.0))
    settings = {"gravity": (0.0, -9.81), "friction": 0.3, "restitution": 0.5, "domain": ((-5, 5), (-5, 5))}
    scene = handmade_scene([(0.0, 0.1)], [(0.0, 0.0)], (), steps=4000, output_steps=200, **settings)
    moving = MovingWall(floor, Motion(kind=Hops(), ease=0.05, time_step=scene.time_step))
    scene = replace(scene, walls=(moving,))
    simulation = NativeSimulation(scene)
    simulation.run(int(0.2 / scene.time_step))
    up = 0.075  # 0.1 s at 1 m/s, of which the ramp takes half of its 0.05 s
    assert simulation.positions[0, 1] == pytest.approx(0.1 + up, abs=2e-3)  # a soft contact gives way
    (wall,) = from_scene(scene).walls_at(scene.time(simulation.step))
    assert wall.extent[1][1] == pytest.approx(up, abs=1e-4)
    found = WithoutDiscs(scene).walls.moves
    assert found is not None and np.array_equal(found.track, moving.motion.track)


class Sticky(Contact):
    """A contact with one more number."""

    grip: Annotated[PerSecond, Field(ge=1e-3, le=50)] | None = Field(
        default=None, title="grip of the discs", description="how soon two discs let go. Without it, at once"
    )


def test_a_new_field_is_told_at_the_field_alone(monkeypatch, capsys):
    """Page, schema of editors, errors, hints and labels of a study: nothing else was told of it."""

    class Fields(CaseFields):
        contact: Sticky = Field(description="what happens when discs touch")

    for module in (cases, field_words, study, fields, lammps_jump.case):
        monkeypatch.setattr(module, "CaseFields", Fields)
    row = "| `grip` | how soon two discs let go. Without it, at once | number | 1/s | ≥ 0.001 and ≤ 50 | \N{EN DASH} |"
    assert row in fields.page() and "contact.grip" in fields.names()
    tools.schema()
    told = json.loads(capsys.readouterr().out)["$defs"]["Sticky"]["properties"]["grip"]
    assert told["title"] == "grip of the discs" and told["default"] is None
    assert told["description"] == "1/s: how soon two discs let go. Without it, at once"
    number = {"type": "number", "minimum": 0.001, "maximum": 50}
    assert told["anyOf"][0] == {"anyOf": [number, {"type": "string"}], "unit": "1/s"}
    assert study.axis_heading("contact.grip") == "grip of the discs [1/s]"
    for given, said in (
        ("grip: 60", "contact.grip: 60 is out of range; allowed is >= 0.001 and <= 50 1/s"),
        ("grip: 3 m", "'3 m' is in meter; expected a number in 1/s, or a string such as '100 1/s'"),
        ("grp: 3", "contact.grp: unknown field; did you mean 'grip'?"),
    ):
        text = "\n".join(line for line in CASE.replace("friction: 0.3", given).splitlines() if "kind: arch" not in line)
        with pytest.raises(CaseError) as caught:
            cases.ReadCase.parse(text)
        assert said in str(caught.value)


SPREAD = ListedAnalysis(
    "made_quantity", "height of the discs", look="Height of the discs", needs={"gravity": ", so that nothing falls"}
)
"""The line of a quantity in the list of them; its own file is ``made_quantity.py``."""
FALL = {
    "discs": {"diameter": 0.2}, "contact": {"restitution": 0.4, "impact_speed": 6},
    "domain": {"x": [-2, 2], "y": [-1, 4]},
    "walls": [{"name": "bed", "kind": "plane", "axis": "y", "at": 0, "side": "above"}],
    "initial": [{"kind": "list", "positions": [[0, 0.2], [0.5, 1.2]]}],
    "run": {"duration": 0.3, "output_interval": 0.01}, "engine": {"name": "native"},
    "analysis": {"spread": True, "figures": "player"},
}  # fmt: skip


ASKING = (
    "analysis/pipeline.py",
    "analysis/quantity.py",
    "analysis/report/",
    "analysis/tables.py",
    *(f"lammps_jump/case/{name}.py" for name in ("asked", "doubts", "speeds", "ways_out")),
)
"""What shows quantities or looks ahead for them, and asks them for all it says."""
OF_MAPS = {
    "analysis/report/frames.py: pressure", "analysis/report/handed_on.py: pressure",
    "analysis/report/page.py: force", "analysis/report/player.py: force",
}  # fmt: skip
"""Names of a map of the player and of a key of its walls, which are also those of quantities."""


def test_what_shows_quantities_knows_none_by_its_name():
    knowing = {
        f"{file}: {node.value}"
        for file, text in texts().items()
        if file.startswith(ASKING) and file.endswith(".py")
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value.partition(".")[0] in LISTED
    }
    assert knowing == OF_MAPS


def test_what_quantities_need_is_looked_for():
    case = cases.ReadCase.parse(yaml.safe_dump(FALL | {"analysis": {}}))
    known = facts(case.fields, ())
    assert {need for one in LISTED.values() for need in one.needs} == known.keys()


def test_a_new_quantity_stands_in_its_file_and_in_the_list(monkeypatch, tmp_path):
    """Field, summary, table, curve, screen, page, errors, column of a study: nothing else was told of it."""
    monkeypatch.setitem(LISTED, "spread", SPREAD)

    class Fields(CaseFields):
        analysis: asked_for(Analysis, {"spread": SPREAD}) = Analysis()

    monkeypatch.setattr(cases, "CaseFields", Fields)
    case = cases.ReadCase.parse(yaml.safe_dump(FALL))
    weightless = cases.ReadCase.parse(yaml.safe_dump(FALL | {"gravity": 0}))
    assert "analysis.spread: gravity is 0, so that nothing falls; drop it" in weightless.scene().warnings
    flow = flow_of(case)
    with DumpWriter(tmp_path / "dump.lammpstrj", ("id", "x", "y", "vx", "vy")) as writer:
        for step in range(0, 200, 10):
            columns = {"id": [1, 2], "x": [0, 0.5], "y": [0.2, 1.2 + 0.01 * step], "vx": [0, 0], "vy": [0, 0]}
            writer.write_frame(make_frame(step, flow.scene.time(step), flow.scene.domain, columns))
    parts, _ = analyse(case, flow, tmp_path, tmp_path / "out", packer_for(case, flow))
    mean = float(np.mean([1.0 + 0.01 * step for step in range(0, 200, 10)]))
    assert parts["spread"]["height"] == pytest.approx(mean) and parts["spread"]["height_error"] > 0
    assert "spread.csv" in parts["files"] and (tmp_path / "out" / "spread.csv").read_text().startswith("time,height")
    assert "figures/spread.png" in result_files() and captions()["spread"] == "Height of the discs"
    summary = {"name": "fall", **parts}
    assert any(line.startswith("spread: spread 1.9") for line in main_numbers(summary))
    assert rows_of([summary])[0].label == "height that the discs are spread over"
    page = write_report(tmp_path / "out", summary).read_text()
    assert page.count("that the discs are spread over") >= 3  # at the top, in its section, among the errors
    assert "from the lowest disc to the highest" in page
    found = collected("spread.height", case)
    row = row_of(summary, SimpleNamespace(collect=[found]))
    assert (
        found.unit == "m"
        and set(row) == {"spread.height", "spread.height_error"}
        and np.isfinite([*row.values()]).all()
    )


@pytest.mark.long
def test_a_program_with_a_new_quantity_runs(tmp_path):
    """The program itself with the two files: one run and a study of two, on the screen and from Python."""
    place = tmp_path / "program" / "lammps_jump"
    (place / "analysis").mkdir(parents=True)
    for folder, source in ((place, ROOT / "lammps_jump"), (place / "analysis", ROOT / "analysis")):
        for path in source.iterdir():
            if path.name not in ("analysis", "quantities.py", "__pycache__"):
                (folder / path.name).symlink_to(path)
    text = (ROOT / "analysis" / "quantities.py").read_text()
    row = '"lammps_jump.analysis.spread", "height of the discs", look="Height of the discs"'
    line = f'    "spread": ListedAnalysis({row}),\n'
    at = text.index('    "tailgate": ListedAnalysis(')
    (place / "analysis" / "quantities.py").write_text(text[:at] + line + text[at:])
    shutil.copy(ROOT / "tests" / "made_quantity.py", place / "analysis" / "spread.py")
    (tmp_path / "fall.yaml").write_text(yaml.safe_dump(FALL))
    script = """
import lammps_jump as lj
case = lj.load_case("fall.yaml")
run = case.run("run")
print(run.spread.height == run.results["spread"].height == run.summary["spread"]["height"])
print(lj.sweep(case, "study", members=2, jobs=1).table["spread.height"].sel(statistic="n").item())
"""
    program = {**os.environ, "PYTHONPATH": str(place.parent)}

    def call(*words):
        done = subprocess.run([sys.executable, *words], cwd=tmp_path, env=program, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return done.stdout

    assert call("-c", script).split() == ["True", "2.0"]
    screen = call("-m", "lammps_jump", "analyze", "run")
    assert "spread: spread" in screen
    assert "--spread" in call("-m", "lammps_jump", "analyze", "--help")
    assert "spread.height" in (tmp_path / "study" / "table.csv").read_text()


STUDY_FILES = {
    "measure.py": """
def height(run):
    frames = list(run.frames())
    return {"highest": float(frames[-1].y.max()), "discs": run.summary["discs"]["present"]}

def twice(value):
    return {"value": 2 * value}
""",
    "study.py": """
from lammps_jump.studies.points import Point, PointStudy
from lammps_jump.analysis.tables import markdown

def study(*, top):
    points = [Point(f"from {top:g} m", "height", "fall.yaml", {"initial.0.positions": [[0, top]]})]
    points += [Point("number", "twice", options={"value": 4})]

    def results(found, stored):
        *falls, number = points
        return {"rows": [{"name": p.name, **found[p.name][0]} for p in falls], "twice": found["number"][0]["value"]}

    def page(results):
        columns = {"fall": "{name}", "highest (m):": "{highest:.3f}"}
        return ["## Falls", markdown(columns, results["rows"]), f"Twice 4 is {results['twice']}."]

    return PointStudy("made-up", points, results, page)
""",
}
"""The folder of a study beside its case."""


def test_a_new_study_is_a_folder_and_a_command(monkeypatch, capsys, tmp_path):
    """Runs, store, JSON, page, progress, marker of the folder, going on: nothing else was told of it."""
    place = tmp_path / "validation" / "made-up"
    place.mkdir(parents=True)
    for name, text in STUDY_FILES.items():
        (place / name).write_text(text)
    fall = {**FALL, "initial": [{"kind": "list", "positions": [[0, 0.2]]}], "analysis": {}}
    (place / "fall.yaml").write_text(yaml.safe_dump({**fall, "run": {"duration": 0.02, "output_interval": 0.01}}))
    monkeypatch.setattr(points_study, "Pool", Here)
    more = typer.Typer(cls=Commands)
    more.add_typer(cli_studies.app)
    monkeypatch.setattr(cli_app, "app", more)  # the commands of studies, and one more

    @more.command("made-up")
    def made_up(out: Path, laws: Path, top: float = 1.0, fresh: bool = False) -> None:
        show_markdown(studies.points.run_named("made-up", out, laws=laws, fresh=fresh, top=top)[1])

    words = ("made-up", tmp_path / "out", place.parent, "--top", "0.8")
    status, screen, _ = call(monkeypatch, capsys, *words)
    assert status == 0 and "## Falls\n\n| fall | highest (m) |\n|---|---:|\n| from 0.8 m | 0.79" in screen
    stored = json.loads((tmp_path / "out" / "made-up.json").read_text())
    assert stored["twice"] == 8 and [row["discs"] for row in stored["rows"]] == [1] and len(stored["pieces"]) == 2
    assert (tmp_path / "out" / "made-up.md").read_text().strip() == screen.strip()
    assert read_marker(tmp_path / "out").kind == "made-up" and len([*(tmp_path / "out" / "runs").iterdir()]) == 1
    monkeypatch.setattr(Here, "run", lambda self, calls, **_: calls and pytest.fail("it was measured again"))
    assert call(monkeypatch, capsys, *words)[:2] == (0, screen)
    with pytest.raises(SetupError, match="holds what `lammps-jump made-up` has made"):
        require_ours(tmp_path / "out", Marker("stress", (), {}))
