# SPDX-License-Identifier: GPL-2.0-or-later
"""The house keeps its floors: which folder imports which, how large files and folders are.

The tables at the top list what does not keep to the rules yet. They may only shrink: a test fails too where a table
lists what is no longer there.
"""

from __future__ import annotations

import ast
import io
import os
import re
import subprocess
import sys
import tokenize
import tomllib
from collections import Counter
from collections.abc import Iterator
from functools import cache
from itertools import pairwise
from pathlib import Path

import budget
import pytest
import times
from defects import DEFECTS, Defect, places
from edges import Program, base_of, module_of
from function_sizes import Shape, functions

ROOT = Path(__file__).parents[1]

FLOORS = (
    "errors", "quoting", "system", "foreign", "files", "folders", "written", "units", "provenance", "identity",
    "compiling", "core", "physics", "scene", "dump", "analysis", "case", "drawings", "script", "engines", "runs",
    "sweeps", "calibration", "studies", "live", "served", "cli",
)  # fmt: skip
"""What lies in ``lammps_jump``, from the top down: each imports only what stands before it."""
AT_THE_ROOT = {"__init__.py", "__main__.py", *(f"{name}.py" for name in FLOORS[:10])}
CALLERS = {"cli"}
"""What calls the public Python API, ``import lammps_jump``."""
NOT_FOR_ANALYSIS = {"case", "engines"}
MOST_PARAMETERS = 8
"""Parameters of a function, keyword-only ones, ``*args`` and ``**kwargs`` included; options of a command are free."""

LONGEST = 50
"""Lines of code of a function; docstrings, comments and blank lines, and the options of a command, do not count."""

LONG_CALLS: dict[str, int] = {}
"""Functions over `MOST_PARAMETERS`, with their parameters today."""
LONG_FUNCTIONS: dict[str, int] = {}
"""Functions over `LONGEST`, with their lines today."""
LONG_COMPILED: dict[str, int] = {}
"""Functions of C++ and JavaScript over `LONGEST`, with their lines today."""
LONG_C_CALLS: dict[str, int] = {}
"""Functions of C++ over `MOST_PARAMETERS`, with their parameters today."""
TWO_MEANINGS: dict[str, int] = {}
"""Names that several classes of one language have, with their number today."""
PRIVATE_NAMES: set[tuple[str, str]] = set()
"""(file, private name) that a file takes from another."""
IMPORTS_INSIDE: dict[str, int] = {}
"""Imports of our own modules inside functions, by file."""


DOOR = {
    "lammps_jump/files.py": "reads, writes, deletes",
    "lammps_jump/folders.py": "markers, locks and staging folders",
    "lammps_jump/system.py": "files that the system makes, such as those of processes",
    "lammps_jump/compiling/cache.py": "the lock of who builds a library",
    "lammps_jump/engines/plugin/make.py": "clears the folder of the libraries of a wheel that is being made",
    "lammps_jump/cli/app.py": "standard output that was closed",
}
"""The files that may call the system for a file, and for what."""
PAST_THE_DOOR = {
    "open", "read_text", "write_text", "read_bytes", "write_bytes", "unlink", "rmtree", "symlink_to",
    "hardlink_to", "imread", "imsave", "savefig", "savetxt", "loadtxt", "genfromtxt", "fromfile", "tofile", "memmap",
    "savez", "savez_compressed", "open_dataset", "load_dataset", "open_mfdataset", "netcdf_file", "read_csv",
    "read_table", "read_json", "read_excel", "read_pickle", "to_json", "to_pickle", "copyfile", "copy2", "copytree",
    "mkstemp", "NamedTemporaryFile",
}  # fmt: skip
"""Functions that open, make or delete a file, whosever they are."""
OF_A_MODULE = {
    "os": {"open", "replace", "rename", "remove", "unlink", "truncate", "link", "symlink", "mkfifo"},
    "json": {"load", "dump"}, "pickle": {"load", "dump"}, "np": {"load", "save"}, "numpy": {"load", "save"},
    "shutil": {"copy", "move"}, "gzip": {"open"},
}  # fmt: skip
"""Functions of a module that do, whose names are also of others."""
OWN_DOOR = {"read_json", "read_text", "write_text", "write_bytes", "read_table"}
"""Names that functions of the house share with others: called by their bare name, they are ours."""
NO_FILE = {
    ("analysis/draw/style.py", "savefig"): "into memory",
    ("analysis/report/page.py", "open"): "Image.open of bytes in memory; webbrowser.open",
    ("lammps_jump/runs/run.py", "savefig"): "into memory",
    ("lammps_jump/dump/exports.py", "open_dataset"): "of bytes in memory",
    ("lammps_jump/cli/live.py", "imread"): "of bytes in memory",
    ("lammps_jump/cli/options.py", "open"): "webbrowser.open",
    ("lammps_jump/runs/results.py", "symlink_to"): "forces.csv of a dump beside a staging folder of ours",
}
"""(file, function) that goes past the door, and why no file of a folder is read or written there."""


@cache
def trees(pattern: str = "*.py") -> dict[str, ast.Module]:
    """Syntax tree of every file of the program, by its path from the root."""
    paths = [path for name in ("lammps_jump", "analysis") for path in (ROOT / name).rglob(pattern)]
    return {str(path.relative_to(ROOT)): ast.parse(path.read_text()) for path in sorted(paths)}


@cache
def walked(tree: ast.Module) -> list[ast.AST]:
    """All nodes of a tree, found once: a walk through the program takes a second."""
    return list(ast.walk(tree))


@cache
def modules() -> dict[str, str]:
    """File of every module."""
    return {module_of(file): file for file in trees()}


def imported(file: str, node: ast.AST) -> list[tuple[str, str]]:
    """(module, name) of an import of our own modules; the name is empty where the module itself is imported."""
    if isinstance(node, ast.Import):
        return [(alias.name, "") for alias in node.names if alias.name.split(".")[0] == "lammps_jump"]
    if not isinstance(node, ast.ImportFrom) or base_of(file, node).split(".")[0] != "lammps_jump":
        return []
    base = base_of(file, node)
    inside = [(f"{base}.{alias.name}", alias.name) for alias in node.names]
    return [(module, "") if module in modules() else (base, name) for module, name in inside]


@cache
def imports() -> dict[str, set[str]]:
    """Modules that each module uses: imported at its top or inside functions, or loaded through a late-bound name."""
    program = Program(trees(), trees("*.pyi"))
    return {module_of(file): program.edges(file) for file in trees()}


def floor(module: str) -> str:
    """The part of ``lammps_jump`` that a module belongs to."""
    return module.partition(".")[2].partition(".")[0]


def past_the_door(tree: ast.Module) -> Iterator[tuple[str, int]]:
    """Name and line of each call, or function handed on, that opens, makes or deletes a file."""
    for node in walked(tree):
        if isinstance(node, ast.Name) and node.id in PAST_THE_DOOR - OWN_DOOR and isinstance(node.ctx, ast.Load):
            yield node.id, node.lineno
        if not isinstance(node, ast.Attribute):
            continue
        module = node.value.id if isinstance(node.value, ast.Name) else ""
        if node.attr in PAST_THE_DOOR or node.attr in OF_A_MODULE.get(module, ()):
            if (module, node.attr) != ("files", node.attr):
                yield node.attr, node.lineno


def test_files_are_reached_through_one_door():
    found = {
        (file, name): line for file, tree in trees().items() if file not in DOOR for name, line in past_the_door(tree)
    }
    more = [f"{file}:{line}: {name}" for (file, name), line in sorted(found.items()) if (file, name) not in NO_FILE]
    assert not more, "use a function of lammps_jump/files.py or folders.py"
    assert found.keys() == NO_FILE.keys() and trees().keys() >= DOOR.keys()


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("open('a')", ["open"]),
        ("import io\nio.open('a')", ["open"]),
        ("Path('a').read_text()", ["read_text"]),
        ("path.open('rb')", ["open"]),
        ("write_text(path, 'a')", []),
        ("path.write_text('a')", ["write_text"]),
        ("pd.read_csv('a')", ["read_csv"]),
        ("pd.read_table('a')", ["read_table"]),
        ("json.load(file)", ["load"]),
        ("json.loads(text)", []),
        ("np.load('a')", ["load"]),
        ("case.load('a')", []),
        ("list(map(Path.read_text, paths))", ["read_text"]),
        ("os.replace(a, b)", ["replace"]),
        ("text.replace(a, b)", []),
        ("figure.savefig('a.png')", ["savefig"]),
        ("files.read_json('a')", []),
    ],
)
def test_what_goes_past_the_door(text, found):
    assert [name for name, _ in past_the_door(ast.parse(text))] == found


def test_no_python_of_the_current_folder_is_run():
    """A process of Python puts the folder where a person stands first on its path, unless -P says no."""
    lists = [
        [ast.unparse(item) for item in node.elts]
        for tree in trees().values()
        for node in walked(tree)
        if isinstance(node, ast.List)
    ]
    commands = [items for items in lists if "sys.executable" in items]
    assert len(commands) >= 4 and all(items[items.index("sys.executable") + 1] == "'-P'" for items in commands)


NAMES_A_PATH = re.compile(r"lammps-jump [a-z][a-z-]+(?: \S+)* ?$")


def test_commands_that_are_told_can_be_typed():
    """A path with spaces, or one that begins as an option does: `quoting.typed` writes the command."""
    found = [
        f"{file}:{node.lineno}"
        for file, tree in trees().items()
        for node in walked(tree)
        if isinstance(node, ast.JoinedStr)
        for part, behind in pairwise(node.values)
        if isinstance(part, ast.Constant) and isinstance(behind, ast.FormattedValue)
        if NAMES_A_PATH.search(part.value.rpartition("`")[2]) and part.value.count("`") % 2
    ]
    assert not found, "write the command by lammps_jump.quoting.typed"


SHOWN = (
    "analysis/",
    *(
        f"lammps_jump/{name}/"
        for name in ("calibration", "case", "cli", "engines", "runs", "scene", "studies", "sweeps")
    ),
    "lammps_jump/units.py",
)
"""What makes text for readers."""
NUMBER = re.compile(r"(?:.?[<>=^])?[-+ ]?(z?)#?0?\d*,?(?:\.(?:\d+|\?))?[eEfFgG%]")
"""Format of a float; `?` stands for what is inserted."""
FIELD = re.compile(r"\{\w*(?:\[\w+\]|\.\w+)*:([^{}]+)\}")
"""A field of a text for ``str.format``."""


def formats(tree: ast.Module) -> list[tuple[int, str]]:
    """Lines and formats of what a file puts into texts: f-strings, and texts for ``str.format``."""
    found = []
    for node in walked(tree):
        if isinstance(node, ast.FormattedValue) and isinstance(node.format_spec, ast.JoinedStr):
            parts = (part.value if isinstance(part, ast.Constant) else "?" for part in node.format_spec.values)
            found.append((node.lineno, "".join(map(str, parts))))
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            found += [(node.lineno, one) for one in FIELD.findall(node.value)]
    return found


def minus_zero(tree: ast.Module) -> list[int]:
    """Lines whose numbers may be shown as -0."""
    return [line for line, one in formats(tree) if (hit := NUMBER.fullmatch(one.replace("??", "?"))) and not hit[1]]


def test_no_number_is_shown_as_minus_zero():
    """PEP 682: the `z` of a format takes the sign off what is rounded to zero. Write ``f"{value:z.2f}"``."""
    found = [f"{file}:{line}" for file, tree in trees().items() if file.startswith(SHOWN) for line in minus_zero(tree)]
    assert not found, "write z before the precision, as in {value:z.2f}"
    assert f"{-0.001:z.1f}" == "0.0" and f"{-0.0:zg}" == "0"


def test_a_format_that_shows_minus_zero_is_found():
    text = "a = f'{x:.2f} {y:{n}d} {x:z.1f} {x:+.{n}g}'; b = '{q:.1%}'.format(q=1)"
    assert minus_zero(ast.parse(text)) == [1, 1, 1]


def test_what_lies_at_the_root():
    entries = {path.name for path in (ROOT / "lammps_jump").iterdir() if path.name != "__pycache__"}
    folders = {name for name in entries if (ROOT / "lammps_jump" / name).is_dir()}
    assert entries - folders - {"py.typed", "__init__.pyi"} <= AT_THE_ROOT
    # a folder that was moved away may still hold what Python has cached in it
    assert {name for name in folders if list((ROOT / "lammps_jump" / name).glob("*.*"))} <= set(FLOORS)


def test_every_folder_is_packed():
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]
    packages = {name for name, file in modules().items() if file.endswith("__init__.py")}
    assert packages == set(settings["packages"]) - {"lammps_jump.inputs"}
    assert {Path(file).parent for file in modules().values()} == {Path(modules()[name]).parent for name in packages}
    for name in packages:
        if name.startswith("lammps_jump.analysis"):
            assert settings["package-dir"][name] == str(Path(modules()[name]).parent)


def test_imports_lead_to_floors_above():
    upward = [
        f"{module} imports {other}"
        for module, others in imports().items()
        for other in others - ({"lammps_jump"} if floor(module) in CALLERS else set())
        if module not in ("lammps_jump", "lammps_jump.__main__")
        if floor(other) not in FLOORS or FLOORS.index(floor(other)) > FLOORS.index(floor(module))
    ]
    assert not upward


@pytest.mark.long  # it loads all that there is, 4 s; upward imports are found below
@pytest.mark.parametrize("seed", ["1", "2", "3"])
def test_all_can_be_loaded_at_once(seed):
    """In an order that follows from the seed: a folder that is half loaded would lack a name that another asks for."""
    text = "import lammps_jump.cli.app"
    setting = {**os.environ, "EAGER_IMPORT": "1", "PYTHONHASHSEED": seed}
    done = subprocess.run([sys.executable, "-c", text], env=setting, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_analysis_knows_neither_cases_nor_engines():
    wrong = [
        f"{module} imports {other}"
        for module, others in imports().items()
        for other in others
        if floor(module) == "analysis" and floor(other) in NOT_FOR_ANALYSIS
    ]
    assert not wrong


def test_every_module_that_is_used_is_there():
    assert not set().union(*imports().values()) - modules().keys()


@pytest.mark.parametrize(
    ("text", "used"),
    [
        ("from lammps_jump import rooms\nrooms.lamp.glow()", {"rooms", "rooms.lamp"}),
        ("import lammps_jump.rooms as r\ndef f(): return r.glow()", {"rooms", "rooms.lamp"}),
        ("import lammps_jump as lj\nlj.rooms.chair.sit()", {"rooms.chair"}),
        ("from .rooms import glow", {"rooms.lamp"}),
        ("from . import rooms\nuse(rooms)", {"rooms", "rooms.lamp", "rooms.chair"}),
        ("from . import rooms\ngetattr(rooms, name)", {"rooms", "rooms.lamp", "rooms.chair"}),
        ("Worker('lammps_jump.rooms.lamp')", {"rooms.lamp"}),
        ("import_module({1: '.rooms.chair'}[one], __package__)", {"rooms.chair"}),
        ("from lammps_jump import rooms\nlamp = 'rooms.lamp'", {"rooms"}),
    ],
)
def test_late_bound_names_are_edges(text, used):
    files = ("__init__", "house", "rooms/__init__", "rooms/lamp", "rooms/chair")
    trees = {f"lammps_jump/{name}.py": ast.parse(text if name == "house" else "") for name in files}
    stub = ast.parse("from . import chair as chair\nfrom .lamp import glow as glow")
    found = Program(trees, {"lammps_jump/rooms/__init__.pyi": stub}).edges("lammps_jump/house.py")
    assert {name.removeprefix("lammps_jump.") for name in found} - {"lammps_jump"} == used


def test_no_import_runs_in_a_circle():
    left = {module: {other for other in others if other != module} for module, others in imports().items()}
    while True:  # what imports nothing that is left is in no circle
        free = {module for module, others in left.items() if not others & left.keys()}
        if not free:
            break
        left = {module: others for module, others in left.items() if module not in free}
    assert not left, f"these import each other, or what does: {sorted(left)}"


def test_no_private_name_is_taken_from_another_file():
    found = set()
    for file, tree in trees().items():
        nodes = walked(tree)
        aliases = {
            alias.asname or alias.name
            for node in nodes
            if isinstance(node, ast.ImportFrom)
            for alias in node.names
            if (f"{base_of(file, node)}.{alias.name}") in modules()
        }
        taken = [name for node in nodes for _, name in imported(file, node)]
        taken += [
            node.attr
            for node in nodes
            if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id in aliases
        ]
        found |= {(file, name) for name in taken if name.startswith("_") and not name.startswith("__")}
    assert found == PRIVATE_NAMES


def test_own_modules_are_not_imported_inside_functions():
    found = Counter()
    for file, tree in trees().items():
        if not any(node.col_offset for node in walked(tree) if isinstance(node, ast.Import | ast.ImportFrom)):
            continue
        functions = [node for node in walked(tree) if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)]
        inside = {node for function in functions for node in ast.walk(function) if imported(file, node)}
        found[file] = len(inside)
    assert dict(+found) == IMPORTS_INSIDE


def lines_of_code(text: str) -> int:
    """Number of lines that hold code."""
    return len(code_of(text))


def code_of(text: str) -> set[int]:
    """Lines that hold code: no blank line, comment, docstring or other string that stands alone."""
    none = {tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER}
    lines: set[int] = set()
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type not in none:
            lines.update(range(token.start[0], token.end[0] + 1))
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            lines.difference_update(range(node.lineno, node.end_lineno + 1))
    return lines


def over(found: dict[str, int], limit: int) -> dict[str, int]:
    return {name: size for name, size in found.items() if size > limit}


def shrinks(found: dict[str, int], known: dict[str, int]) -> None:
    """Nothing is over its limit but what is known, which is not larger than it was."""
    assert found.keys() == known.keys()
    assert all(size <= known[name] for name, size in found.items()), found


def is_command(function: ast.FunctionDef) -> bool:
    """Whether a function is a command of the command line, whose options are its parameters."""
    calls = [one.func for one in function.decorator_list if isinstance(one, ast.Call)]
    return any(isinstance(one, ast.Attribute) and one.attr == "command" for one in calls)


def parameters(function: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    """How many parameters a function has."""
    given = function.args
    named = [*given.posonlyargs, *given.args, *given.kwonlyargs]
    return len(named) + sum(one is not None for one in (given.vararg, given.kwarg))


def test_functions_have_few_parameters():
    counts = {
        f"{file}:{node.name}": parameters(node)
        for file, tree in trees().items()
        for node in walked(tree)
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and not is_command(node)
        if parameters(node) > MOST_PARAMETERS
    }
    shrinks(counts, LONG_CALLS)


def test_how_parameters_are_counted():
    (function,) = ast.parse("def f(a, /, b, *c, d=1, **e): ...").body
    assert parameters(function) == 5 and not is_command(function)
    assert is_command(ast.parse("@app.command('x')\ndef f(): ...").body[0])


def statements(function: ast.FunctionDef | ast.AsyncFunctionDef, lines: set[int]) -> int:
    """Lines of code of a function without its docstring; of a command without its options."""
    first = function.body[0] if is_command(function) else function
    return len(lines & set(range(first.lineno, (function.end_lineno or 0) + 1)))


def test_functions_are_short():
    counts = {}
    for file, tree in trees().items():
        every = [node for node in walked(tree) if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)]
        if not any((node.end_lineno or 0) - node.lineno >= LONGEST for node in every):
            continue
        lines = code_of((ROOT / file).read_text())
        counts |= {f"{file}:{node.name}": statements(node, lines) for node in every}
    shrinks(over(counts, LONGEST), LONG_FUNCTIONS)


@cache
def compiled() -> dict[str, Shape]:
    """Functions of C++ and JavaScript, by file and name."""
    paths = [
        path
        for name in ("lammps_jump", "analysis")
        for end in ("cpp", "h", "js")
        for path in sorted((ROOT / name).rglob(f"*.{end}"))
        if "carried" not in path.parts
    ]
    found: dict[str, Shape] = {}
    for path in paths:
        for one in functions(path.read_text(encoding="utf-8")):
            name = f"{path.relative_to(ROOT)}:{one.name}"
            known = found.get(name, one)
            found[name] = Shape(one.name, max(one.lines, known.lines), max(one.parameters, known.parameters))
    return found


def test_compiled_functions_are_short_and_take_little():
    assert len(compiled()) > 500
    shrinks(over({name: one.lines for name, one in compiled().items()}, LONGEST), LONG_COMPILED)
    shrinks(over({name: one.parameters for name, one in compiled().items()}, MOST_PARAMETERS), LONG_C_CALLS)


def test_how_compiled_functions_are_counted():
    text = """// int no(int a) {
static int f(int a, std::map<int, int> b) noexcept {
  const char *s = "}{(";
  if (a) { return 1; }

  for (int i = 0; i < 3; i++) { a += i; }
  return 0;  // a comment, } too
}
struct S { explicit S(int a) : b(a) {} int b; };
"""
    assert list(functions(text)) == [Shape("f", 6, 2), Shape("S", 1, 1)]
    assert [one.name for one in functions("class P { draw(a, b) { const g = `}${a}`; } }")] == ["draw"]


CLASS = re.compile(r"\b(?:struct|class)\s+(?:alignas\(\w+\)\s+)?(?:\w+::)*(\w+)(?:\s+final)?\s*(?::(?!:)[^;{()]*)?\{")
"""A class of C++ where it is defined: nested ones, templates and children too."""


def test_a_class_name_has_one_meaning_in_its_language():
    """Two classes of one name are told apart by their files alone, which a reader of a line does not see."""
    ours = Counter(node.name for tree in trees().values() for node in walked(tree) if isinstance(node, ast.ClassDef))
    paths = [path for end in ("cpp", "h") for path in (ROOT / "lammps_jump").rglob(f"*.{end}")]
    texts = (path.read_text(encoding="utf-8") for path in paths if "carried" not in path.parts)
    there = Counter(name for text in texts for name in CLASS.findall(text))
    shrinks(over(ours, 1) | over(there, 1), TWO_MEANINGS)


def test_how_classes_are_found():
    text = "struct Early;\ntemplate <class A> struct B : C<A> {\n  struct alignas(32) D { int x; };\n"
    text += "class E final : F {\nstruct G::H {"
    assert CLASS.findall(text) == ["B", "D", "E", "H"]


ONLY_HERE = re.compile(r"fcntl|resource|msvcrt|sched_\w+affinity|listxattr|setxattr|ST_NOEXEC|confstr|psutil")
"""Modules and names that not every system has."""
PLACES = re.compile(r"/(?:proc|sys|dev/shm)/")


def test_no_other_module_asks_for_the_system():
    found = []
    for path, tree in trees().items():
        for node in walked(tree) if not path.endswith("/system.py") else ():
            names = [node.attr] if isinstance(node, ast.Attribute) else []
            names += [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            found += [f"{path}:{node.lineno}: {name}" for name in names if ONLY_HERE.fullmatch(name)]
            text = node.value if isinstance(node, ast.Constant) and isinstance(node.value, str) else ""
            found += [f"{path}:{node.lineno}: {text}"] if PLACES.search(text) and "\n" not in text else []
    assert not found


MENTIONED = re.compile(r"`([\w./-]+\.(?:py|pyi|h|cpp|js|css|j2|md))`|\]\(([\w./-]+\.md)(?:#[\w-]*)?\)")
"""A source file or a page that a text names in backquotes, or links."""
NOT_OURS = {
    "tools/binary2txt.cpp": "LAMMPS",
    "lammps.js": "of npm",
    "law.py": "of each folder of validation/",
    "analysis/spread.py": "a recipe",
    "validation/falls/measure.py": "a recipe",
    "validation/falls/study.py": "a recipe",
}
"""Files of others, or of a name that several have."""
RESULTS = re.compile(
    r"^(?:bench|stress|compared|fluid|calibrate|collision|sensitivity|cross_validation|validation)\.md$"
)
"""Pages that commands write."""
MODULE = re.compile(r"`(lammps_jump(?:\.\w+)+)`|python -m (lammps_jump(?:\.\w+)+)")
TELLING = (".py", ".pyi", ".h", ".cpp", ".js", ".md")


@cache
def sources() -> dict[str, str]:
    """Texts of the program, its tests and its pages, by their path from the root."""
    folders = ("lammps_jump", "analysis", "tests", "docs", "benchmarks", "validation")
    paths = [path for folder in folders for path in (ROOT / folder).rglob("*") if path.suffix in TELLING]
    paths += [ROOT / "README.md", ROOT / "CONTRIBUTING.md"]
    left_out = {"carried", "_build", "_made", "golden"}
    kept = {str(path.relative_to(ROOT)): path for path in paths if not left_out & set(path.parts)}
    return {file: path.read_text(encoding="utf-8") for file, path in kept.items()}


def is_there(file: str, said: str) -> bool:
    """Whether a text of a file may name this one: from the root, from its own folder, or by the end of its path."""
    if said in NOT_OURS or RESULTS.match(said) or ((ROOT / file).parent / said).exists() or (ROOT / said).exists():
        return True
    return any(f"/{known}".endswith(f"/{said}") for known in sources())


def test_files_that_texts_name_are_there():
    gone = [
        f"{file}: {said}"
        for file, text in sources().items()
        for found in MENTIONED.finditer(text)
        if not is_there(file, said := found[1] or found[2])
    ]
    assert not gone


def is_name(dotted: str) -> bool:
    """Whether dotted words lead to a module, or to a name that a module has."""
    for known in range(len(words := dotted.split(".")), 0, -1):
        if (module := ".".join(words[:known])) in modules():
            rest = words[known : known + 1]
            text = (ROOT / modules()[module]).read_text(encoding="utf-8")
            stub = (ROOT / modules()[module]).with_suffix(".pyi")
            text += stub.read_text(encoding="utf-8") if stub.exists() else ""
            return not rest or re.search(rf"\b{rest[0]}\b", text) is not None
    return False


def test_names_that_texts_tell_are_there():
    gone = [
        f"{file}: {said}"
        for file, text in sources().items()
        for found in MODULE.finditer(text)
        if not is_name(said := (found[1] or found[2]).rstrip("."))
    ]
    assert not gone


OPENS_ILL = re.compile(r"(?:What|Whether|Where|Those|How|Which|Who|When)\b")


def test_docstrings_begin_with_a_noun_or_a_verb():
    """A question word or "those" makes the reader wait for what is meant."""
    ill = [
        f"{file}: {text.partition(chr(10))[0]}"
        for file, tree in trees().items()
        for node in walked(tree)
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef)
        if OPENS_ILL.match(text := ast.get_docstring(node) or "")
    ]
    assert not ill


@pytest.mark.parametrize(("text", "lines"), [('"""Doc."""\n\nx = (\n    1,\n)\n# note\n"""About x."""\n', 3), ("", 0)])
def test_how_lines_are_counted(text, lines):
    assert lines_of_code(text) == lines


def test_readme_tells_the_budget_of_the_tests():
    text = (ROOT / "README.md").read_text()
    table = text[text.index(times.BEGIN) : text.index(times.END)]
    for kind, most in budget.BUDGETS.items():
        assert f"| the tests, {kind}, at most | {most:,} |" in table, "make times writes it"
    assert not re.search(r"\d (s|seconds|minutes|min) on ", text), "times are told in the table alone"


LICENCE = "SPDX-License-Identifier: GPL-2.0-or-later"
COMMENT = {".py": "#", ".pyi": "#", ".cpp": "//", ".h": "//"}
"""Source files, and how a comment begins in them."""


def test_the_first_line_of_every_source_file_names_its_licence():
    folders = ("lammps_jump", "analysis", "tests", "benchmarks", "validation")
    files = [path for folder in folders for path in (ROOT / folder).rglob("*") if path.suffix in COMMENT]
    first = {str(path): path.read_text(encoding="utf-8").partition("\n")[0] for path in files}
    bare = sorted(path for path, line in first.items() if line != f"{COMMENT[Path(path).suffix]} {LICENCE}")
    assert not bare, bare[:3]


def test_contributing_counts_the_seeded_defects():
    """Each row of the table names folders or files, and how many defects lie there; no defect is in two rows."""
    text = (ROOT / "CONTRIBUTING.md").read_text()
    table = re.findall(r"^\| (`.+) \| (\d+) \|$", text[text.index("| changed | defects |") :], re.M)
    told = {tuple(re.findall(r"`([^`]+)`", where)): int(count) for where, count in table}
    assert told == {where: sum(d.file.startswith(where) for d in DEFECTS) for where in told}
    assert sum(told.values()) == len(DEFECTS)


def test_seeded_defects_are_of_todays_program():
    """A defect whose function or piece is gone would be left out of `tests/defects.py` unseen."""
    texts = {d.file: (ROOT / d.file).read_text() for d in DEFECTS}
    missing = [(d.file, d.where, d.old) for d in DEFECTS if len(places(d, texts[d.file])) != 1]
    nowhere = {name for d in DEFECTS for name in d.tests.split() if not (ROOT / "tests" / name).exists()}
    assert missing == [] and nowhere == set()


def test_a_defect_is_found_by_its_function_whatever_stands_around_it():
    text = (
        "K = 2 * a\n\n\nclass A:\n    def f(a):\n        # 2 * a\n        return (2\n                * a + 12 * ab)\n"
    )
    (place,) = places(Defect("", "a.py", "A.f", "(2 * a", "", ""), text)
    assert text[slice(*place)] == "(2\n                * a"
    assert places(Defect("", "a.py", "K", "2 * a", "", ""), text) == [(4, 9)]
    assert not places(Defect("", "a.py", "f", "2 * a", "", ""), text)
    text = "inline double g(double a) { return 2 * a; }\nint h() { if constexpr (b) { return 2 * a; } }\n"
    assert [len(places(Defect("", "a.h", name, "2 * a", "", ""), text)) for name in ("g", "h", "k")] == [1, 1, 0]
