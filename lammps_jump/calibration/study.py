# SPDX-License-Identifier: GPL-2.0-or-later
"""The study file of a calibration: a case, the numbers that are varied, and what was measured."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
import yaml
from pydantic import AfterValidator, BeforeValidator, Field, ValidationError

from lammps_jump.analysis.quantities import QUANTITIES, result_files
from lammps_jump.case.base import Strict, Whole
from lammps_jump.case.case import ReadCase
from lammps_jump.case.field_words import explain
from lammps_jump.case.text import CaseSource, read_source
from lammps_jump.errors import CaseError, FieldError
from lammps_jump.files import plain
from lammps_jump.foreign import number_of
from lammps_jump.quoting import echoed, shortened
from lammps_jump.runs.run import Case
from lammps_jump.sweeps import study as sweep_study
from lammps_jump.units import Plain, numbers_of

from .targets import PROFILES, Target, TargetField, parse_target

KIND = "calibrate"
MOST_VARIED = 5
"""Numbers that are varied: more would need hundreds of runs."""
SPARE = 3
"""Points that an emulator needs in addition to one for each varied number."""
OPTIONS = {name: f"--{name}" for name in ("vary", "budget", "members", "seed")} | {"targets": "--target"}
"""Options of the command line, by their fields."""


def _vary(given: object) -> object:
    if not isinstance(given, Mapping) or not 1 <= len(given) <= MOST_VARIED:
        raise ValueError(
            f"{echoed(given)} does not fit; allowed are 1 to {MOST_VARIED} paths with their ranges: "
            "{contact.friction: [0.1, 0.9]}"
        )
    return given


def _rising(given: tuple[float, float]) -> tuple[float, float]:
    if not given[0] < given[1]:
        raise ValueError(f"{given[0]:zg} to {given[1]:zg} is no range; the first number must be the smaller one")
    return given


def _targets(given: object) -> object:
    if isinstance(given, Mapping) and "key" not in given and "data" not in given and "curve" not in given:
        given = [_pair(str(key), value) for key, value in given.items()]
    if not isinstance(given, list | tuple) or not given:
        raise CaseError(f"targets: {echoed(given)} does not fit; allowed is a list such as ['jump.y2=6.7 ± 0.1']")
    return [parse_target(one) if isinstance(one, str) else one.as_field if isinstance(one, Target) else one
            for one in given]  # fmt: skip


def _pair(key: str, value: object) -> object:
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise CaseError(f"targets: {key}: {echoed(value)} does not fit; allowed is [value, error]")
    return {"key": key, "value": value[0], "error": value[1]}


class CalibrationFields(Strict):
    """A study file of the kind calibrate."""

    kind: Literal["calibrate"] = "calibrate"
    case: str | dict[str, Any]
    set: dict[str, Any] = Field(default_factory=dict)
    vary: Annotated[dict[str, Annotated[tuple[Plain, Plain], AfterValidator(_rising)]], BeforeValidator(_vary)]
    targets: Annotated[list[TargetField], BeforeValidator(_targets)]
    budget: Annotated[Whole, Field(ge=1, le=sweep_study.MOST_RUNS)] = 40
    members: Annotated[Whole, Field(ge=1, le=sweep_study.MOST_MEMBERS)] = 2
    seed: Annotated[Whole, Field(ge=0, le=2**31)] = 1


@dataclass(frozen=True)
class Calibration:
    """A calibration that was read and checked.

    Attributes
    ----------
    case : Case
        With the values of ``set``, and the analyses that the targets need.
    vary : dict of str to (float, float)
        Range of each varied number, by its path.
    targets : tuple of Target
    budget : int
        Most runs.
    members : int
        Starts of each point.
    seed : int
        Of the Sobol points.
    """

    case: Case
    vary: dict[str, tuple[float, float]]
    targets: tuple[Target, ...]
    budget: int
    members: int
    seed: int

    @property
    def paths(self) -> list[str]:
        """Paths of the varied numbers."""
        return list(self.vary)

    @property
    def bounds(self) -> np.ndarray:
        """Ranges, shape (varied, 2)."""
        return np.array(list(self.vary.values()), float)

    @property
    def most_points(self) -> int:
        """Points that the budget allows."""
        return self.budget // self.members

    def unit(self, points: np.ndarray) -> np.ndarray:
        """Points as places in the unit cube, shape (n, varied)."""
        return (np.asarray(points, float) - self.bounds[:, 0]) / np.ptp(self.bounds, axis=1)

    def points(self, places: np.ndarray) -> np.ndarray:
        """Places of the unit cube as points, with six digits of each range: a case is to be read."""
        wide = np.ptp(self.bounds, axis=1)
        digits = 5 - np.floor(np.log10(wide)).astype(int)
        whole = self.bounds[:, 0] + np.asarray(places, float) * wide
        rounded = np.array([[round(float(v), int(n)) for v, n in zip(row, digits, strict=True)] for row in whole])
        return np.clip(rounded, self.bounds[:, 0], self.bounds[:, 1])

    def sweep(self, points: list[list[float]]) -> sweep_study.Study:
        """The points as a study of `sweeps`, each with starts of its own."""
        columns = {path: [point[k] for point in points] for k, path in enumerate(self.paths)}
        usual = [item.path for item in sweep_study.read_study(self.case).collect]
        parts = {item.name.split(".")[0].split("_")[0] for item in self.targets if item.axis}
        firsts = [f"{part}.{next(iter(numbers_of(QUANTITIES[part].result)))}" for part in sorted(parts & {*QUANTITIES})
                 if QUANTITIES[part].named is None]  # fmt: skip
        keys = [item.name for item in self.targets if not item.axis]
        collect = list(dict.fromkeys([*keys, *usual, *firsts]))
        study = {"axes": {sweep_study.ZIP: columns}, "members": self.members, "starts": "own", "collect": collect}
        return sweep_study.read_study(self.case, **study)

    def to_yaml(self) -> str:
        """The study as YAML, with the whole case and the measured numbers in it, so that the folder can be moved."""
        data = {
            "kind": KIND,
            "vary": {path: list(pair) for path, pair in self.vary.items()},
            "targets": [target.as_field for target in self.targets],
            "budget": self.budget,
            "members": self.members,
            "seed": self.seed,
            "case": yaml.safe_load(self.case.to_yaml()),
        }
        return yaml.safe_dump(plain(data), sort_keys=False, allow_unicode=True, width=110, default_flow_style=None)


def all_targets(numbers: Sequence[str], files: Sequence[Path], columns: Sequence[str]) -> list[object]:
    """Targets of the command line: texts of ``--target``, and each ``--data`` with its ``--columns``.

    Raises
    ------
    CaseError
        More files than columns, or fewer.
    """
    if len(files) != len(columns):
        raise CaseError(
            f"{len(files)} --data and {len(columns)} --columns: each file needs its columns, for example "
            '--data heap.csv --columns "x=x,heap.depth=depth ± 0.01"'
        )
    curves = zip(files, columns, strict=True)
    return [*numbers, *({"data": str(file.absolute()), "columns": text} for file, text in curves)]


def parse_vary(text: str) -> tuple[str, list[float]]:
    """Path and range of ``--vary PATH=LOW:HIGH``.

    Raises
    ------
    CaseError
        Another text.
    """
    path, sign, bounds = (part.strip() for part in text.partition("="))
    try:
        low, high = map(number_of, bounds.split(":"))
    except ValueError:
        low = high = np.nan
    if not (path and sign and np.isfinite([low, high]).all()):
        raise CaseError(
            f"--vary {shortened(text)}: expected a path and a range, for example --vary contact.friction=0.1:0.9"
        )
    return path, [low, high]


def read_calibration(source: str | Path | Mapping[str, object] | ReadCase, **given: Any) -> Calibration:
    """Read and check a calibration.

    Parameters
    ----------
    source : str, Path, mapping or Case
        A study file, a case file, the folder of a calibration, the fields themselves, or a case.
    given
        Fields in place of those of the source.

    Raises
    ------
    CaseError
        One paragraph with file:line, the field, what is allowed and what to do.
    """
    given = {name: value for name, value in given.items() if value is not None}
    if isinstance(source, ReadCase):
        source = {"case": yaml.safe_load(source.to_yaml())}
    if isinstance(source, Mapping):
        source = source if "case" in source else {"case": source}
        file, place = CaseSource("<study>", plain({**source, **_plain_targets(source)})), Path()
    else:
        path = Path(source) / "study.yaml" if (Path(source) / "study.yaml").is_file() else Path(source)
        file, place = read_source(path), path.parent
        if "case" not in file.data and {"discs", "run"} & file.data.keys():
            file.data = {"case": path.name}
    if isinstance(given.get("set"), Mapping):
        given["set"] = {**(file.data.get("set") or {}), **given["set"]}
    file.data |= plain({**given, **_plain_targets(given)})
    file.options = {name: OPTIONS[name] for name in given if name in OPTIONS and not isinstance(source, Mapping)}
    for name, example in (("vary", "contact.friction=0.1:0.9"), ("targets", "jump.y2=6.7 ± 0.1")):
        if not file.data.get(name):
            word = "--vary" if name == "vary" else "--target (or --data with --columns)"
            raise CaseError(f'{file.file}: no {name}: name what is {_ASKED[name]}, for example {word} "{example}"')
    try:
        fields = CalibrationFields.model_validate(file.data)
    except ValidationError as error:
        raise explain(error, file, CalibrationFields) from None
    whole = fields.case
    case = Case.load(whole, fields.set) if isinstance(whole, dict) else sweep_study.case_in(place / whole, fields.set)
    targets = tuple(target for field in fields.targets for target in field.targets(place))
    try:
        case = _asked(case, targets)
        _require_points(case, fields)
    except FieldError as error:
        raise file.located(error) from None
    return Calibration(case, fields.vary, targets, fields.budget, fields.members, fields.seed)


_ASKED = {"vary": "to be found", "targets": "measured"}


def _plain_targets(data: Mapping[str, Any]) -> dict[str, Any]:
    """Targets that are objects, as fields: plain data takes no object."""
    return {"targets": _targets(data["targets"])} if data.get("targets") else {}


def _asked(case: Case, targets: tuple[Target, ...]) -> Case:
    """The case with the analyses that the targets need; FieldError for a key or table that there is not."""
    names = [target.name for target in targets]
    for name in names:
        if names.count(name) > 1:
            raise FieldError("targets", f"{shortened(name)} stands twice; keep one of them")
    parts = set()
    for target in targets:
        table = target.name.partition(".")[0]
        parts.add(table.split("_")[0])
        if not target.axis:
            sweep_study.collected(target.name, case, "targets")
        elif table != PROFILES and f"{table}.csv" not in result_files() and not table.startswith("force_"):
            known = ", ".join(name[:-4] for name in result_files() if name.endswith(".csv") and "[" not in name)
            raise FieldError("targets", f"{shortened(target.name)}: no run has a table {shortened(table)}; there are "
                             f"{known}, {PROFILES}")  # fmt: skip
    analysis = case.fields.analysis
    off = {f"analysis.{part}": True for part in sorted(parts) if getattr(analysis, part, None) is False}
    return case.replace(off) if off else case


def _require_points(case: Case, fields: CalibrationFields) -> None:
    """FieldError where no point of the ranges can be read as a case, or where the budget is too small."""
    middle = {path: 0.5 * (low + high) for path, (low, high) in fields.vary.items()}
    try:
        case.replace(middle)
    except CaseError as error:
        raise FieldError("vary", f"the middle of the ranges is refused: {error}") from None
    needed = (len(fields.vary) + SPARE + 1) * fields.members
    if fields.budget < needed:
        raise FieldError(
            "budget",
            f"{fields.budget} runs are too few for {len(fields.vary)} varied numbers and {fields.members} "
            f"starts of each point; allowed is {needed} or more",
        )
