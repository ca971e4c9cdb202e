# SPDX-License-Identifier: GPL-2.0-or-later
"""A study: a case, axes of values and their words, members of each point, and what is collected of every run."""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import prod
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
import yaml
from pydantic import AfterValidator, BeforeValidator, Field, ValidationError, model_validator

from lammps_jump.analysis.quantities import QUANTITIES
from lammps_jump.analysis.report.page import heading
from lammps_jump.case import CaseFields, ReadCase
from lammps_jump.case.base import Strict
from lammps_jump.case.doubts import in_vain
from lammps_jump.case.field_words import explain, fields_at, label_of, unit_of
from lammps_jump.case.text import CaseSource, nearest, parse_source, read_source, read_text
from lammps_jump.errors import CaseError, FieldError
from lammps_jump.files import plain
from lammps_jump.quoting import echoed, shortened, typed
from lammps_jump.runs.run import Case
from lammps_jump.units import POWERS, in_kilo, numbers_of, parse_accuracy

ZIP = "zip"
MOST_RUNS = 100_000
MOST_MEMBERS = 1_000
MOST_WATCHED = 100
"""Points of a study up to which its page shows their runs: a player is 1 MB and takes a tenth of a second to make."""
OTHERS = (
    "discs", "steps", "simulated_time", "cpu_seconds", "wall_seconds", "disc_steps", "disc_steps_per_second",
    "coefficients", "ledger", "theory",
)  # fmt: skip
"""Parts of ``summary.json`` other than the analyses whose numbers can be collected."""

OPTIONS = {"axes": "--axis", "most_members": "--most-members"}
"""Options of the command line whose names are not those of their fields."""


class Range(Strict):
    """Equal steps from one value to another; of logarithms, with ``scale: log``."""

    from_: float = Field(alias="from")
    to: float
    count: int = Field(ge=2, le=MOST_RUNS)
    scale: Literal["linear", "log"] = "linear"

    @model_validator(mode="after")
    def _logarithms(self) -> Range:
        if self.scale == "log" and not (self.from_ > 0 and self.to > 0):
            raise ValueError("scale: log needs from and to above 0")
        return self

    def values(self) -> list[float]:
        """The values, rounded to twelve digits."""
        space = np.geomspace if self.scale == "log" else np.linspace
        return [float(f"{value:z.12g}") for value in space(self.from_, self.to, self.count)]


class Axis(NamedTuple):
    """An axis of a study: values of one path of the case, or of several that change together."""

    name: str
    columns: Mapping[str, Sequence[Any]]

    @property
    def values(self) -> Sequence[Any]:
        """Values of the first path."""
        return self.columns[self.name]


def _values(given: object) -> object:
    if isinstance(given, Mapping):
        return Range.model_validate(given).values()
    if not isinstance(given, list | tuple) or not given:
        raise ValueError(f"{echoed(given)} does not fit; allowed is a list of values, or {{from: 0, to: 1, count: 5}}")
    for text, count in Counter(map(str, given)).items():
        if count > 1:
            raise ValueError(f"{shortened(text)} stands twice; keep one of them")
    return list(given)


def _axes(given: object) -> object:
    if not isinstance(given, Mapping):
        return given
    columns_of_axis: dict[str, Any] = {}
    for path, values in given.items():
        if path != ZIP:
            columns_of_axis[path] = {path: _values(values)}
            continue
        if not isinstance(values, Mapping) or not values:
            raise ValueError("zip does not fit; allowed is {path: [values], path: [values]}")
        columns = {name: list(column) if isinstance(column, list) else [] for name, column in values.items()}
        if len({len(column) for column in columns.values()}) != 1 or not all(columns.values()):
            raise ValueError("values that change together need lists of one length")
        columns_of_axis[next(iter(columns))] = columns
    return columns_of_axis


def _seeds(given: object) -> object:
    """Seeds 1 … n of a number, or the seeds themselves as a list or ``9-16``; none of the default, ()."""
    if given == ():
        return ()
    if isinstance(given, str) and (parts := given.split("-"))[0].isdigit() and parts[-1].isdigit() and len(parts) < 3:
        low, high = (int(parts[0]), int(parts[-1])) if len(parts) == 2 else (1, int(parts[0]))
        given = list(range(low, min(high, low + MOST_MEMBERS) + 1))
    if isinstance(given, int) and not isinstance(given, bool):
        given = list(range(1, min(given, MOST_MEMBERS + 1) + 1))
    if not isinstance(given, list | tuple) or not given or len(set(given)) < len(given) or len(given) > MOST_MEMBERS:
        raise ValueError(
            f"{echoed(given)} does not fit; allowed is 1 to {MOST_MEMBERS}, or different seeds: 9-16 or [3, 5]"
        )
    return given


Share = Annotated[float, BeforeValidator(parse_accuracy)]


class StudyFields(Strict):
    """A study file."""

    case: str | dict[str, Any]
    set: dict[str, Any] = Field(default_factory=dict)
    axes: Annotated[dict[str, dict[str, list[Any]]], BeforeValidator(_axes)] = Field(default_factory=dict)
    members: Annotated[tuple[Annotated[int, Field(ge=0)], ...], BeforeValidator(_seeds)] = ()
    collect: Annotated[tuple[str, ...], AfterValidator(lambda names: tuple(dict.fromkeys(names)))] = ()
    confidence: float = Field(default=0.95, gt=0, lt=1)
    until: dict[str, Share] = Field(default_factory=dict)
    starts: Literal["common", "own"] = "common"
    most_members: int = Field(default=32, ge=2, le=MOST_MEMBERS)


class Collected(NamedTuple):
    """A number of ``summary.json`` that is collected: its path there, unit and meaning."""

    path: str
    unit: str
    meaning: str

    @property
    def scale(self) -> float:
        """Factor of what is shown: forces are in kN, pressure in kPa."""
        return 1.0 / in_kilo(self.unit)[0]

    @property
    def level(self) -> float | None:
        """Value at which a structure just holds: 1 of a factor of safety; None of other numbers."""
        part, _, key = self.path.rpartition(".")
        is_factor = part.startswith("stability.") and "_factor" in key and not key.endswith(("_at", "_below_1"))
        return 1.0 if is_factor else None

    @property
    def heading(self) -> str:
        """Heading of a number, in words, and its unit; of a force also the structure."""
        unit = in_kilo(self.unit)[1]
        name = self.path.split(".")[1] if self.path.startswith("force.") else ""
        return heading(f"{self.meaning}, {name}" if name else self.meaning, unit)


@dataclass(frozen=True)
class Study:
    """A study that was read and checked.

    Attributes
    ----------
    fields : StudyFields
    case : Case
        With the values of ``set``.
    collect : tuple of Collected
    """

    fields: StudyFields
    case: Case
    collect: tuple[Collected, ...]

    @property
    def axes(self) -> list[Axis]:
        """The axes, in the order of the file."""
        return [Axis(name, columns) for name, columns in self.fields.axes.items()]

    @property
    def shape(self) -> tuple[int, ...]:
        """Values of each axis."""
        return tuple(len(axis.values) for axis in self.axes)

    @property
    def points(self) -> list[dict[str, Any]]:
        """Changed values of each point, the last axis fastest."""
        indices = itertools.product(*(range(count) for count in self.shape))
        return [
            {path: column[i] for axis, i in zip(self.axes, index, strict=True) for path, column in axis.columns.items()}
            for index in indices
        ]

    @property
    def analysis(self) -> dict[str, object]:
        """Analysis of each run: what the collected numbers need, a player, no pictures and no page."""
        parts = {item.path.partition(".")[0] for item in self.collect}
        flags: dict[str, object] = {
            f"analysis.{name}": name in parts for name in ("jump", "front", "energy", "overtopping")
        }
        if any(item.path.startswith("front.martin_moyce.") for item in self.collect):
            flags["analysis.front"] = "water"
        figures = "player" if len(self.points) <= MOST_WATCHED else "none"
        return {**flags, "analysis.fields": False, "analysis.animation": False, "analysis.figures": figures}

    def to_yaml(self) -> str:
        """The study as YAML, with the whole case in it, so that the folder can be moved."""
        data = {**self.fields.model_dump(mode="json"), "set": {}, "collect": [item.path for item in self.collect]}
        data |= {"case": yaml.safe_load(self.case.to_yaml())}
        axes = {axis.name: list(axis.values) for axis in self.axes if len(axis.columns) == 1}
        zipped = next(({ZIP: axis.columns} for axis in self.axes if len(axis.columns) > 1), {})
        whole = plain({**data, "axes": {**axes, **zipped}})
        return yaml.safe_dump(whole, sort_keys=False, allow_unicode=True, width=110, default_flow_style=None)


def read_study(source: str | Path | Mapping[str, object] | ReadCase, **given: Any) -> Study:
    """Read and check a study.

    Parameters
    ----------
    source : str, Path, mapping or Case
        A study file, the folder of a study, the fields themselves, or a case.
    given
        Fields in place of those of the source.

    Raises
    ------
    CaseError
        One paragraph with file:line, the field, what is allowed and what to do.
    """
    if isinstance(source, ReadCase):
        source = {"case": yaml.safe_load(source.to_yaml())}
    if isinstance(source, Mapping):
        file, place = CaseSource("<study>", plain(dict(source))), Path()
    else:
        path = Path(source) / "study.yaml" if (Path(source) / "study.yaml").is_file() else Path(source)
        file, place = read_source(path), path.parent
        if "case" not in file.data and {"discs", "run"} & file.data.keys():
            file.data = {"case": path.name}
    if isinstance(given.get("set"), Mapping):
        given["set"] = {**(file.data.get("set") or {}), **given["set"]}
    file.data |= given
    if not isinstance(source, Mapping):
        file.options = {name: OPTIONS.get(name, f"--{name}") for name in given if name in StudyFields.model_fields}
    if file.data.get("kind") == "calibrate":
        said = f"this study is a calibration; `{typed('calibrate', Path(file.file))}` runs it"
        raise file.located(FieldError("kind", said))
    try:
        fields = StudyFields.model_validate(file.data)
    except ValidationError as error:
        raise explain(error, file, StudyFields) from None
    case = (
        Case.load(fields.case, fields.set)
        if isinstance(fields.case, dict)
        else case_in(place / fields.case, fields.set)
    )
    if not fields.members:
        seeds = tuple(range(1, (case.fields.run.members or 1) + 1))
        fields = fields.model_copy(update={"members": seeds})
    if (runs := prod(len(next(iter(c.values()))) for c in fields.axes.values()) * len(fields.members)) > MOST_RUNS:
        raise file.located(FieldError("axes", f"{runs} runs; allowed are {MOST_RUNS}"))
    paths = (*fields.collect, *fields.until) or tuple(_usual(case))
    try:
        collect = tuple(collected(path, case) for path in dict.fromkeys(paths))
    except FieldError as error:
        raise file.located(error) from None
    return Study(fields, case, collect)


def case_in(path: Path, changes: Mapping[str, object]) -> Case:
    """The case of a study that names its file. Of a file that is no case it tells nothing: a study may be received.

    Raises
    ------
    CaseError
        As `Case.load`.
    """
    file = path / "case.yaml" if (path / "case.yaml").is_file() else path
    text = read_text(file)
    try:
        known = {"discs", "run"} & parse_source(text, str(file)).data.keys()
    except CaseError:
        known = set()
    if not known:
        raise CaseError(
            f"{file}: is no case; `{typed('check', Path(file))}` says why, and case: in a study names a case"
        )
    return Case.load(path, changes)


def _usual(case: Case) -> Iterator[str]:
    """Paths of what is shown of a case on the screen, but for times of a peak: their means have no interval."""
    analysis = case.fields.analysis
    for name, quantity in QUANTITIES.items():
        keys = [n.key for n in numbers_of(quantity.result).values() if n.label != n.meaning and n.unit != "s"]
        parts = _parts(name, case)
        parents = [name] if parts is None else [f"{name}.{part}" for part in parts]
        if getattr(analysis, name, False) or parts is not None:
            yield from (f"{parent}.{key}" for parent in parents for key in keys)


def _parts(name: str, case: Case) -> tuple[str, ...] | None:
    """Walls whose results a quantity holds by name; None of one that holds its own numbers."""
    named = QUANTITIES[name].named
    return None if named is None else getattr(case, named.walls)


def collected(path: str, case: ReadCase, field: str = "collect") -> Collected:
    """The description of a number that is to be collected; `field` of the study names it.

    Raises
    ------
    FieldError
        No such number.
    """
    name, _, key = path.partition(".")
    if name in OTHERS:
        return Collected(path, "", path)
    if name not in QUANTITIES:
        hint = nearest(name, [*QUANTITIES, *OTHERS])
        raise FieldError(field, f"{shortened(path)}: there is no '{shortened(name)}' in summary.json; {hint}")
    if named := QUANTITIES[name].named:
        parts: tuple[str, ...] = getattr(case, named.walls)
        part, _, key = key.partition(".")
        what, remedy = named.what, named.remedy
        if part not in parts:
            known = ", ".join(parts) or f"none: {remedy}"
            raise FieldError(
                field, f"{shortened(path)}: '{shortened(part)}' is no {what} of the case; {what}s there: {known}"
            )
    numbers = numbers_of(QUANTITIES[name].result)
    if key not in numbers and "." not in key:
        raise FieldError(
            field, f"{shortened(path)}: {name} has no number '{shortened(key)}'; {nearest(key, list(numbers))}"
        )
    number = numbers.get(key)
    return Collected(path, number.unit if number else "", number.meaning if number else path)


def collected_alone(path: str, case: ReadCase) -> Collected:
    """The description of the number that ``--of`` names, for which runs are made.

    Raises
    ------
    CaseError
        No such number, or one that no run of the case has.
    """
    try:
        number = collected(path, case, "--of")
    except FieldError as error:
        raise CaseError(str(error)) from None
    name = path.partition(".")[0]
    if getattr(case.fields.analysis, name, None) is False:
        asked = case.replace({f"analysis.{name}": True})
        for said in in_vain(asked.fields, asked.scene().walls):
            if said.startswith(f"analysis.{name}: "):
                why = said.removeprefix(f"analysis.{name}: ").removesuffix("; drop it")
                raise CaseError(
                    f"--of {path}: no run of the case has it: {why}; change the case, or take another number"
                )
    return number


def parse_axis(text: str) -> tuple[str, object]:
    """Path and values of ``--axis PATH=VALUES``: values with commas between, ``[…]`` or ``{from: …, to: …, count: …}``.

    Raises
    ------
    CaseError
        No path or no values.
    """
    path, values = _pair("--axis", text, "=", "contact.friction=0,0.05,0.1")
    whole = values if values[0] == "{" or values.startswith("[[") else f"[{values}]"
    return path, parse_source(f"values: {whole}", f"--axis {shortened(text)}").data["values"]


def parse_set(text: str) -> tuple[str, object]:
    """Path and value of ``--set PATH=VALUE``."""
    path, value = _pair("--set", text, "=", "contact.friction=0")
    return path, parse_source(f"value: {value}", f"--set {shortened(text)}").data["value"]


def parse_until(text: str) -> tuple[str, str]:
    """Path and share of ``--until``: ``jump.speed=3%`` or ``jump.speed ± 3%``."""
    return _pair("--until", text, "±" if "±" in text else "=", "jump.speed=3%")


def _pair(option: str, text: str, sign: str, example: str) -> tuple[str, str]:
    path, middle, value = (part.strip() for part in text.partition(sign))
    if not (path and middle and value):
        raise CaseError(
            f"{option} {shortened(text)}: expected a path, {sign} and a value, for example {option} {example}"
        )
    return path, value


NAMED = {"walls": "wall", "bodies": "body"}
"""Lists whose items have names, and what an item without one is called."""


def axis_words(path: str) -> str:
    """Label of a field, in a few axis_words; the path where it has none."""
    group, _, rest = path.partition(".")
    label = label_of(fields_at(CaseFields, path.split(".")))
    if not label:
        return path
    if group not in NAMED:
        return path if path[-1].isdigit() else label  # the end of what?
    name = rest.partition(".")[0]
    return f"{label} of the {f'{NAMED[group]} {name}' if name.isdigit() else name.replace('_', ' ')}"


def axis_unit(path: str) -> str:
    """Its SI axis_unit, empty where there is none."""
    return unit_of(fields_at(CaseFields, path.split("."))).replace("degree", "°")


def axis_heading(path: str) -> str:
    """Words and axis_unit, for a table or an axis."""
    return f"{axis_words(path)} [{axis_unit(path).translate(POWERS)}]" if axis_unit(path) else axis_words(path)
