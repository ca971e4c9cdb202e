# SPDX-License-Identifier: GPL-2.0-or-later
"""Case text to plain data, with the line of each value; tables in files next to a case."""

from __future__ import annotations

import difflib
import re
from collections.abc import Mapping
from copy import copy
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import yaml

from lammps_jump.errors import CaseError, FieldError
from lammps_jump.files import read_file
from lammps_jump.foreign import foreign
from lammps_jump.quoting import echoed, shortened
from lammps_jump.scene.tracks import MOST_ROWS
from lammps_jump.units import to_si
from lammps_jump.written import odd_blank

if TYPE_CHECKING:
    from lammps_jump.dump.ended import DiscsAtTime

PathKey = tuple[str | int, ...]


class _Loader(yaml.SafeLoader):
    """Safe loader with YAML 1.2 numbers: ``1e5`` and ``1.e-3`` are floats, ``yes`` and ``on`` are words."""


_Loader.yaml_implicit_resolvers = {
    first: [(tag, pattern) for tag, pattern in pairs if not tag.endswith((":bool", ":float", ":int", ":timestamp"))]
    for first, pairs in yaml.SafeLoader.yaml_implicit_resolvers.items()
}
_Loader.add_implicit_resolver(
    "tag:yaml.org,2002:bool", re.compile(r"^(?:true|True|TRUE|false|False|FALSE)$"), list("tTfF")
)
_Loader.add_implicit_resolver("tag:yaml.org,2002:int", re.compile(r"^[-+]?[0-9]+$"), list("-+0123456789"))
_Loader.add_constructor("tag:yaml.org,2002:int", lambda _, node: int(node.value))  # 010 is 10
_Loader.add_implicit_resolver(
    "tag:yaml.org,2002:float",
    re.compile(
        r"^(?:[-+]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][-+]?[0-9]+)?|[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN))$"
    ),
    list("-+.0123456789"),
)


MOST_DEPTH = 40
MOST_VALUES = 300_000
"""Values of a case, and keys: 100,000 discs of a list, some seconds of reading."""
MOST_BYTES = 100_000_000


class FileTable(NamedTuple):
    """Rows of a file that a field names, with their lines."""

    name: str
    file: str
    rows: list[list[float]]
    lines: list[int]


class StartState(NamedTuple):
    """Discs of an earlier run, with folder and time as a case has them."""

    folder: str
    time: object
    state: DiscsAtTime


Runs = Mapping[PathKey, StartState]
"""Path of an item of ``initial`` -> the discs of the run that it names."""


@dataclass
class CaseSource:
    """The data of a case file and where each value came from.

    Attributes
    ----------
    file : str
        Name as the user gave it.
    data : dict
        Plain data; `override` changes it.
    lines : dict
        Path of keys and indices -> line number (from 1).
    spans : dict
        Path of a single value -> where it begins and ends in the text, letters from 0.
    overrides : dict
        Path -> the ``--set`` text that set it.
    values : int
        Groups, lists and single values read so far, aliases written out.
    left_out : str
        Scene whose description the file had, of another flow than its own; it is left out.
    folder : Path, optional
        Folder of the case file; tables may lie there and below. A case from elsewhere has none.
    tables : dict
        Path of a wall or motion -> the table that its `file` names.
    begun : dict
        Path of an item of ``initial`` -> the discs of the run that it names.
    options : dict
        Field -> the option of the command line that gives it, in place of the file.
    octals : dict
        Path of a whole number with a leading 0 -> its text. It is decimal, as YAML 1.2 has it.
    """

    file: str
    data: dict[str, Any]
    lines: dict[PathKey, int] = field(default_factory=dict)
    spans: dict[PathKey, tuple[int, int]] = field(default_factory=dict)
    overrides: dict[PathKey, str] = field(default_factory=dict)
    values: int = 0
    left_out: str = ""
    folder: Path | None = None
    tables: dict[PathKey, FileTable] = field(default_factory=dict)
    begun: dict[PathKey, StartState] = field(default_factory=dict)
    options: dict[str, str] = field(default_factory=dict)
    octals: dict[PathKey, str] = field(default_factory=dict)

    @property
    def doubts(self) -> tuple[str, ...]:
        """Sentences on values that other readers of YAML take for other ones."""
        sentences = (_of_octal(dotted_path(path), text) for path, text in self.octals.items())
        return tuple(text for text in sentences if text)

    @property
    def whole(self) -> dict[str, Any]:
        """The data with the rows of tables as points, and the keys of the discs of earlier runs."""
        data = self.data
        for path, table in self.tables.items():
            data = _with(data, path, {"points": table.rows})
        for path, begun in self.begun.items():
            data = _with(data, path, {"key": begun.state.key})
        return data

    def value(self, path: PathKey) -> Any:
        """The value at a path."""
        here: Any = self.data
        for key in path:
            here = here[key]
        return here

    def place(self, path: PathKey) -> str:
        """Place of `path`: ``case.yaml:12: contact.friction`` (the nearest line known) or the ``--set`` text."""
        if option := self.options.get(str(path[0]) if path else ""):
            return f"{option} {dotted_path(path[1:])}".rstrip()
        dotted = dotted_path(path)
        for length in range(len(path), 0, -1):
            if path[:length] in self.overrides:
                return f"--set {shortened(self.overrides[path[:length]])}: {dotted}"
        for length in range(len(path), 2, -1):  # a row of a table
            table = self.tables.get(path[: length - 2])
            if table and path[length - 2] == "points":
                return f"{table.file}:{table.lines[int(path[length - 1])]}: {dotted}"
        for length in range(len(path), -1, -1):
            if path[:length] in self.lines:
                return f"{self.file}:{self.lines[path[:length]]}: {dotted}".rstrip(": ")
        return f"{self.file}: {dotted}"

    def located(self, error: FieldError) -> CaseError:
        """The error of a field with its place."""
        key = tuple(int(part) if _is_number(part) else part for part in error.path.split("."))
        return CaseError(f"{self.place(key)}: {error.text}")


def _of_octal(place: str, text: str) -> str:
    """A sentence on a whole number with a leading 0; empty where it is the same to all."""
    digits = text.lstrip("+-")
    other = f"octal, {int(digits, 8)}" if set(digits) <= set("01234567") else "octal, which it is not"
    if other == f"octal, {int(digits)}":
        return ""
    return f"{place}: {text} is read as {int(text)}; other readers of YAML take a leading 0 for {other}: leave it out"


def _with(data: Any, path: PathKey, given: dict[str, Any]) -> Any:
    """A copy along a path whose end has more values; points are there in place of a file."""
    if path:
        key, rest = path[0], path[1:]
        copied = copy(data)
        copied[key] = _with(data[key], rest, given)
        return copied
    return {key: value for key, value in data.items() if key != "file" or "points" not in given} | given


def dotted_path(path: PathKey) -> str:
    """``('walls', 1, 'y')`` as ``walls[1].y``."""
    text = ""
    for part in path:
        text += f"[{part}]" if isinstance(part, int) else f".{part}"
    return shortened(text.lstrip("."))


def nearest(word: str, known: list[str]) -> str:
    """A hint with the most similar known word, or the list of what is known."""
    close = difflib.get_close_matches(word, known, n=1, cutoff=0.5)
    return f"did you mean '{close[0]}'?" if close else f"known here: {', '.join(known)}"


def read_source(path: str | Path) -> CaseSource:
    """Read a case file into data with line numbers.

    Raises
    ------
    CaseError
        As `read_text`, and for an empty or malformed file and repeated keys, with the line.
    """
    source = parse_source(read_text(path), str(path))
    source.folder = Path(path).parent
    return source


def read_text(path: str | Path) -> str:
    """The text of a case file.

    Raises
    ------
    CaseError
        For a missing, unreadable or binary file, a pipe or device, and one that is too large.
    """
    path = Path(path)
    try:
        raw = read_file(path, MOST_BYTES)
    except FileNotFoundError:
        raise CaseError(
            f"{path}: no such case file; start one with `lammps-jump new hydraulic_jump > case.yaml`, or name "
            "one of inputs/"
        ) from None
    except IsADirectoryError:
        raise CaseError(f"{path}: is a folder, not a case file; name a .yaml file") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise CaseError(f"{path}: cannot be read ({reason}); a case is a YAML file that you may read") from None
    try:
        text = raw.decode("utf-8")
    except UnicodeDecodeError as error:
        raise CaseError(f"{path}: is not text (byte {error.start} is not UTF-8); a case is a YAML file") from None
    if "\x00" in text:
        raise CaseError(f"{path}: is a binary file; a case is a YAML text file")
    return text


def parse_source(text: str, file: str = "<case>") -> CaseSource:
    """Parse YAML text; see `read_source`."""
    try:
        node = _compose(text, file)
    except yaml.YAMLError as error:
        raise CaseError(f"{file}{_not_yaml(error, text)}") from None
    if node is None:
        raise CaseError(
            f"{file}: is empty; a case needs at least discs, contact and run (`lammps-jump new` writes one)"
        )
    if not isinstance(node, yaml.MappingNode):
        raise CaseError(f"{file}:1: a case is a mapping of fields (name: …), this is a {getattr(node, 'id', 'value')}")
    source = CaseSource(file=file, data={})
    constructor = _Loader("")
    source.data = _plain(node, (), source, constructor)
    return source


def _not_yaml(error: yaml.YAMLError, text: str) -> str:
    """Line and problem of a text that is no YAML; a tab or another odd blank there is what is wrong."""
    mark, begin = getattr(error, "problem_mark", None), getattr(error, "context_mark", None)
    problem = getattr(error, "problem", None) or str(error).splitlines()[0]
    if mark is None:
        return f": is not YAML ({shortened(problem)}); check indentation, colons and brackets there"
    lines = text.splitlines()
    for number in range(begin.line if begin else max(mark.line - 1, 0), min(mark.line + 1, len(lines))):
        if blank := odd_blank(lines[number].partition(" #")[0]):
            problem = f"it has {blank}, which is no blank to YAML"
            return f":{number + 1}: is not YAML ({problem}); write blanks alone, also in the indentation"
    return f":{mark.line + 1}: is not YAML ({shortened(problem)}); check indentation, colons and brackets there"


def _compose(text: str, file: str) -> yaml.Node | None:
    """Node tree of the text; nesting and values are counted on the way: building the tree recurses and takes long."""
    return _CountingLoader(text, file).get_single_node()


class _CountingLoader(_Loader):
    """Raises a CaseError where there are too many values, or groups too deep, before the tree has them."""

    def __init__(self, text: str, file: str):
        super().__init__(text)
        self.file, self.depth, self.values = file, 0, 0

    def get_event(self) -> Any:
        """The next event."""
        event = super().get_event()  # type: ignore[no-untyped-call]
        self.values += isinstance(event, yaml.NodeEvent)
        if self.values > MOST_VALUES:
            raise CaseError(_too_many(self.file, event))
        self.depth += isinstance(event, yaml.CollectionStartEvent) - isinstance(event, yaml.CollectionEndEvent)
        if self.depth > MOST_DEPTH:
            raise CaseError(_too_deep(self.file, event))
        return event


def _too_deep(file: str, here: Any) -> str:
    return (
        f"{file}:{here.start_mark.line + 1}: groups or lists more than {MOST_DEPTH} deep, or an alias (*) inside of "
        "what it stands for; a case needs five levels: write the values out"
    )


def _too_many(file: str, here: Any) -> str:
    return (
        f"{file}:{here.start_mark.line + 1}: more than {MOST_VALUES:,} values and keys, aliases (*) counted as often "
        "as they stand; write fewer"
    )


def _plain(node: yaml.Node, path: PathKey, source: CaseSource, constructor: _Loader) -> Any:
    """Plain data of a node tree; records lines, refuses repeated keys and endless aliases."""
    source.values += 1
    if source.values > MOST_VALUES:
        raise CaseError(_too_many(source.file, node))
    if len(path) > MOST_DEPTH:
        raise CaseError(_too_deep(source.file, node))
    source.lines[path] = node.start_mark.line + 1
    if isinstance(node, yaml.MappingNode):
        result: dict[str, Any] = {}
        for key_node, value_node in node.value:
            if not isinstance(key_node, yaml.ScalarNode):
                raise CaseError(f"{source.file}:{key_node.start_mark.line + 1}: a key must be a plain word")
            key = key_node.value
            line = key_node.start_mark.line + 1
            if key == "<<":
                raise CaseError(f"{source.file}:{line}: merge keys (<<) are not supported; write the fields out")
            if key in result:
                first = source.lines[(*path, key)]
                raise CaseError(
                    f"{source.file}:{line}: {dotted_path((*path, key))}: stands twice (first on line "
                    f"{first}); keep one of them"
                )
            result[key] = _plain(value_node, (*path, key), source, constructor)
            source.lines[(*path, key)] = line
        return result
    if isinstance(node, yaml.SequenceNode):
        return [_plain(child, (*path, index), source, constructor) for index, child in enumerate(node.value)]
    source.spans[path] = node.start_mark.index, node.end_mark.index
    if node.tag == "tag:yaml.org,2002:int" and re.fullmatch(r"[-+]?0[0-9]+", node.value):
        source.octals[path] = node.value
    try:
        return constructor.construct_object(node)
    except Exception as error:  # of a tag such as !!bool or !!timestamp it may be of any kind
        problem = getattr(error, "problem", None) or error
        raise CaseError(
            f"{source.file}:{node.start_mark.line + 1}: {dotted_path(path)}: cannot be read "
            f"({shortened(str(problem))}); write a number, a text or a list"
        ) from None


def override(source: CaseSource, assignment: str) -> None:
    """Apply one ``path=value`` of ``--set``; list items by index or by their name.

    Raises
    ------
    CaseError
        For text without '=', a value that is not YAML, or a list item that is not there.
    """
    dotted, sign, text = (part.strip() for part in assignment.partition("="))
    place = f"--set {shortened(assignment)}"
    parts = dotted.split(".")
    if not sign or not all(parts):
        raise CaseError(f"{place}: expected path=value, for example --set contact.friction=0")
    try:
        node = _compose(text, place)
    except yaml.YAMLError:
        raise CaseError(f"{place}: the value is not YAML; quote it, for example --set 'walls.sill.y=[-10,3]'") from None
    scratch = CaseSource(file=place, data={})
    value = None if node is None else _plain(node, (), scratch, _Loader(""))
    container: Any = source.data
    path: PathKey = ()
    for depth, part in enumerate(parts, 1):
        key = _key(container, part, place, path)
        path = (*path, key)
        if depth == len(parts):
            container[key] = value
        else:
            if isinstance(container, dict) and container.get(part) is None:
                container[part] = {}
            container = container[key]
    kept = {known: place for known, place in source.overrides.items() if known[: len(path)] != path}
    source.overrides = {**kept, path: assignment}  # the last change comes last
    octals = {known: text for known, text in source.octals.items() if known[: len(path)] != path}
    source.octals = octals | {(*path, *known): text for known, text in scratch.octals.items()}


def value_at(data: Any, dotted: str) -> Any:
    """The value at a path of a case's data; list items by index or by their name.

    Raises
    ------
    CaseError
        A path that is not there; the message has the nearest one.
    """
    place, here = f"case[{shortened(str(dotted))!r}]", data
    path: PathKey = ()
    for part in str(dotted).split("."):
        key = _key(here, part, place, path)
        if isinstance(here, dict) and part not in here:
            inside = f" of {dotted_path(path)}" if path else ""
            raise CaseError(f"{place}: there is no '{shortened(part)}'{inside}; {_hint(data, here, part, path)}")
        here, path = here[key], (*path, key)
    return here


def _hint(data: Any, here: dict[str, Any], part: str, path: PathKey) -> str:
    """The nearest name in a group, or the group of the case that has such a name."""
    groups = [name for name, group in data.items() if isinstance(group, dict) and part in group]
    return f"did you mean '{groups[0]}.{part}'?" if groups and not path else nearest(part, list(here))


def _key(container: Any, part: str, place: str, path: PathKey) -> str | int:
    """Key of a part of a path: in a list the number of the item; CaseError where there can be none of that name."""
    if isinstance(container, list):
        return _item_index(container, part, place, path)
    if not isinstance(container, dict):
        raise CaseError(f"{place}: {dotted_path(path)} is a single value and has no part '{shortened(part)}'")
    return part


def _is_number(part: str) -> bool:
    return part.isascii() and part.isdigit() and len(part) < 10  # ² is a digit, and no number to int()


def _item_index(items: list[Any], part: str, place: str, path: PathKey) -> int:
    if _is_number(part) and int(part) < len(items):
        return int(part)
    names = [str(item["name"]) for item in items if isinstance(item, dict) and "name" in item]
    for index, item in enumerate(items):
        if isinstance(item, dict) and str(item.get("name")) == part:
            return index
    have = f"names there: {shortened(', '.join(names))}" if names else f"it has {len(items)} items, counted from 0"
    raise CaseError(f"{place}: {dotted_path(path)} has no item '{shortened(part)}'; {have}")


MOST_TABLE = 10_000_000
"""Bytes of a table that a case names."""
SHAPE = {"x": "m", "y": "m"}
TABLES = {"line": SHAPE, "polygon": SHAPE, "table": {"t": "s", **SHAPE, "angle": "degree"}}
"""Columns and units of the tables that may replace points, by the kind of their wall or motion."""


def read_tables(source: CaseSource) -> None:
    """Read the tables that walls and their motions name; those that are read already are kept.

    Raises
    ------
    CaseError
        A case without a folder, a file outside of it, no table, points next to the file; with file and line.
    """
    known, source.tables = source.tables, {}
    walls = source.data.get("walls")
    for index, wall in enumerate(walls if isinstance(walls, list) else []):
        if not isinstance(wall, dict):
            continue
        for path, group in ((("walls", index), wall), (("walls", index, "motion"), wall.get("motion"))):
            if not isinstance(group, dict) or not isinstance(name := group.get("file"), str):
                continue
            if (kind := group.get("kind")) in TABLES:
                old = known.get(path)
                source.tables[path] = old if old and old.name == name else _table(source, path, name, TABLES[kind])
                if group.get("points") is not None:
                    raise CaseError(f"{source.place((*path, 'file'))}: points and file are both given; keep one")


def _table(source: CaseSource, path: PathKey, name: str, columns: dict[str, str]) -> FileTable:
    """A table with these columns (name: unit), by name where its first row has words, else in their order."""
    place = source.place((*path, "file"))
    if source.folder is None:
        raise CaseError(f"{place}: {echoed(name)}: the case is of no file, so that it has no folder: give points")
    file = source.folder / name
    with foreign(CaseError, f"{place}: {echoed(name)} cannot be read", "name a CSV file beside the case"):
        heads_read = file.resolve(strict=True)
        if not heads_read.is_relative_to(source.folder.resolve()):
            raise CaseError(f"{place}: {echoed(name)} lies outside the folder of the case; copy it there")
        text = read_file(heads_read, MOST_TABLE).decode("utf-8-sig")
    return FileTable(name, str(file), *_rows(text, columns, str(file), dotted_path(path)))


def _rows(text: str, columns: dict[str, str], file: str, field: str) -> tuple[list[list[float]], list[int]]:
    """Rows of a text, and their line numbers."""
    rows: list[list[float]] = []
    lines: list[int] = []
    order: list[int] = []
    for number, line in enumerate(text.splitlines(), 1):
        cells = _cells(line)
        if not cells:
            continue
        if not order:
            words = [cell.lower() for cell in cells]
            if set(columns) <= set(words):
                order = [words.index(column) for column in columns]
                continue
            order = list(range(len(columns)))
        if len(rows) == MOST_ROWS:
            raise CaseError(f"{file}:{number}: {field}: more than {MOST_ROWS} rows; write fewer")
        rows.append(_row(cells, order, columns, f"{file}:{number}: {field}"))
        lines.append(number)
    if not rows:
        raise CaseError(f"{file}: {field}: holds no row; its columns are {', '.join(columns)}")
    return rows, lines


def _cells(line: str) -> list[str]:
    """Cells of a line between semicolons, else commas, else blanks; none of an empty line or a comment."""
    if not line.strip() or line.lstrip().startswith("#"):
        return []
    sign = next((sign for sign in ";," if sign in line), None)
    return [cell.strip().strip('"') for cell in line.split(sign)]


def _row(cells: list[str], order: list[int], columns: dict[str, str], place: str) -> list[float]:
    if len(cells) <= max(order):
        raise CaseError(
            f"{place}: has {len(cells)} cells; the columns are {', '.join(columns)}, in this order or under their names"
        )
    row = []
    for index, (column, unit) in zip(order, columns.items(), strict=True):
        try:
            row.append(to_si(cells[index], unit))
        except ValueError as error:
            raise CaseError(f"{place}: column {column}: {error}") from None
    return row
