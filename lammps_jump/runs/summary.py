# SPDX-License-Identifier: GPL-2.0-or-later
"""``summary.json``: the numbers of a run, SI floats, null where there is no number."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, is_dataclass
from dataclasses import fields as fields_of
from functools import cache, reduce
from operator import or_
from pathlib import Path
from types import UnionType
from typing import TYPE_CHECKING, Annotated, Any, Literal, get_args, get_origin, get_type_hints

import numpy as np
from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    FiniteFloat,
    NonNegativeInt,
    PositiveInt,
    TypeAdapter,
    ValidationError,
    create_model,
)  # fmt: skip

from lammps_jump import dump
from lammps_jump.analysis.quantities import QUANTITIES, result_files
from lammps_jump.case.case import ReadCase
from lammps_jump.engines import RunResult, Setting
from lammps_jump.engines.choice import program_of
from lammps_jump.errors import DumpError
from lammps_jump.files import MOST_TEXT, SUMMARY_FILE, plain, read_file, read_json, write_json
from lammps_jump.folders import read_marker, standing
from lammps_jump.identity import run_key, shown_key
from lammps_jump.provenance import versions
from lammps_jump.quoting import echoed, shortened, typed

if TYPE_CHECKING:
    import xarray as xr

    from lammps_jump.dump import TextTable

NO_SUMMARY = (
    "the file is no summary of a run: delete it, and `lammps-jump analyze` makes it again from what the run wrote"
)


class _Discs(BaseModel, strict=True, extra="forbid"):
    inserted: int
    present: int
    removed: int
    lost: int
    fixed: int = 0


class _Seconds(BaseModel, strict=True):
    build: FiniteFloat
    run: FiniteFloat
    analysis: FiniteFloat


class _Sum(BaseModel, strict=True, extra="forbid"):
    size: NonNegativeInt
    sha256: str


class _Analysed(BaseModel, strict=True, extra="forbid"):
    key: str
    files: dict[str, _Sum]


class Stored(BaseModel, strict=True):
    """Content of a summary as it is read back."""

    name: str = ""
    description: str = ""
    status: Literal["complete", "unchecked", "interrupted", "failed"]
    message: str | None
    engine: str
    kernel: str
    case_hash: str
    versions: dict[str, str]
    steps: NonNegativeInt
    disc_steps: FiniteFloat
    disc_steps_per_second: FiniteFloat | None = None
    discs: _Discs
    wall_seconds: _Seconds
    cpu_seconds: FiniteFloat = 0.0
    breakdown_seconds: dict[str, float | None] | None
    ledger: dict[str, float | None] | None
    coefficients: dict[str, FiniteFloat | None] = {}
    skipped: list[str] = []
    ranks: PositiveInt = 1
    resumed_at: list[FiniteFloat] = []
    can_go_on: bool = False
    states: list[Annotated[list[NonNegativeInt | str], Field(min_length=2, max_length=2)]] = []
    warnings: list[str] = []
    begins: list[str] = []
    key: str = ""
    stopped_when_steady: str = ""
    files: list[str] = []
    outputs: dict[str, _Sum] | None = None
    analysed: _Analysed | None = None


@cache
def stored_model(result: type) -> type[BaseModel]:
    """Model of a result in a ``summary.json`` that was handed on; keys may be missing or more.

    Numbers and lists of numbers must be such, or null; texts must be texts.
    """
    kinds, fields = get_type_hints(result), fields_of(result)
    known = {f.metadata.get("key", f.name): kinds[f.name] for f in fields if f.metadata.get("summary", True)}
    config = ConfigDict(strict=True, extra="ignore")
    allowed: Any = {key: (_stored(kind), None) for key, kind in known.items()}
    return create_model(result.__name__, __config__=config, **allowed)


def _stored(kind: Any) -> Any:
    """Type of a value in JSON whose field is of this type."""
    if isinstance(kind, type) and is_dataclass(kind):
        return stored_model(kind) | None
    if isinstance(kind, UnionType):
        return reduce(or_, map(_stored, get_args(kind)))
    if kind is np.ndarray or get_origin(kind) is tuple:
        item: Any = _stored((*get_args(kind), float)[0])
        return list[item] | None
    if get_origin(kind) is dict:
        key, item = get_args(kind)
        return dict[key, _stored(item)] | None  # type: ignore[misc,valid-type]
    return FiniteFloat | None if kind is float else kind | None


@cache
def _adapter(kind: Any) -> TypeAdapter[Any]:
    """Checker of a stored value whose field in Python is of this type."""
    return TypeAdapter(_stored(kind))


def _stored_parts(summary: Mapping[str, Any]) -> Iterator[tuple[str, TypeAdapter[Any], object]]:
    """The results that a summary holds: place, what is allowed there, and what is there."""
    for name, entry in ((name, summary[name]) for name in QUANTITIES if summary.get(name) is not None):
        quantity = QUANTITIES[name]
        if quantity.named and isinstance(entry, Mapping):
            kinds = ((key, quantity.parts.get(key, quantity.result)) for key in entry)
            yield from ((f"{name}: {key}", _adapter(kind), entry[key]) for key, kind in kinds)
        else:
            yield name, _adapter(quantity.result), entry


def compose(
    case: ReadCase,
    setting: Setting,
    result: RunResult,
    *,
    seconds: Mapping[str, float],
    parts: Mapping[str, Any],
    notes: Sequence[str] = (),
) -> dict[str, Any]:
    """All of ``summary.json``.

    Parameters
    ----------
    case : Case
    setting : Setting
    result : RunResult
    seconds : mapping
        Wall seconds of build, run, analysis.
    parts : mapping
        Results of the analyses: jump, front, energy, force, profiles, warnings.
    notes : sequence of str
        Why this setting was chosen; they are among the warnings.
    """
    scene, data = case.scene(), dict(parts)
    discs = {name: getattr(result, name) for name in ("inserted", "present", "removed", "lost")}
    if scene.fixed:
        fixed = scene.fixed.count
        discs = {**discs, "inserted": result.inserted - fixed, "present": result.present - fixed, "fixed": fixed}
    return plain(
        {
            "name": scene.name,
            "description": scene.description,
            "status": result.status,
            "message": result.message or None,
            "engine": result.engine,
            "kernel": result.kernel,
            "integrator": scene.integrator,
            "friction_law": scene.friction_law if scene.rubs else None,
            "case_hash": shown_key(case.core, setting.kernel),
            "key": run_key(case.core, program_of(setting)),
            "versions": {**versions(), **result.versions},
            "coefficients": asdict(scene.coefficients),
            "steps": result.steps,
            "simulated_time": scene.time(result.steps),
            **({"resumed_at": result.resumed} if result.resumed else {}),
            **({"can_go_on": True} if result.outside else {}),
            **({"states": result.states} if result.states else {}),
            "wall_seconds": seconds,
            "cpu_seconds": result.cpu_seconds,
            "disc_steps": result.disc_steps,
            "disc_steps_per_second": result.disc_steps / result.seconds if result.seconds > 0 else None,
            "breakdown_seconds": result.breakdown or None,
            "discs": discs,
            "ledger": result.ledger,
            "skipped": list(scene.skipped),
            **({"begins": list(scene.earlier.origins)} if scene.earlier else {}),
            "warnings": [*scene.warnings, *scene.adapted, *notes, *data.pop("warnings", ())],
            **data,
            "ranks": setting.ranks,
            "theory": case.check().theory,
        }
    )


class _Sums(BaseModel, strict=True):
    status: Literal["complete", "unchecked", "interrupted", "failed"] | None = None
    message: str | None = None
    outputs: dict[str, _Sum] | None = None
    analysed: _Analysed | None = None


@dataclass(frozen=True)
class Results:
    """Files that a whole analysis has left in a folder, and the checksums that its summary has of them.

    Attributes
    ----------
    folder : Path
    sums : mapping, or None
        Size and SHA-256 by the name of a file; None of a version that kept none.
    """

    folder: Path
    sums: Mapping[str, Mapping[str, Any]] | None

    @property
    def tables(self) -> list[str]:
        """Names of the tables, without their ending."""
        names = self.sums or [
            name for pattern in (*result_files(), "force_*.csv") for name in standing(self.folder, pattern)
        ]
        own = {name for name in names if name.endswith(".csv") and "/" not in name} - {"forces.csv"}
        return sorted(name.removesuffix(".csv") for name in own)

    def read(self, name: str) -> bytes:
        """A file as the analysis wrote it.

        Raises
        ------
        DumpError
            Not there, or another one than the summary means.
        """
        path, again = self.folder / name, f"`{typed('analyze', self.folder)}` makes the results again"
        if self.sums is not None and name not in self.sums:
            raise DumpError(f"{path}: is no result of this run; {again}")
        try:
            data = read_file(path, MOST_TEXT)
        except OSError as error:
            raise DumpError(f"{path}: cannot be read ({error.strerror or error}); {again}") from None
        file_sum = {"size": len(data), "sha256": hashlib.sha256(data).hexdigest()}
        if self.sums is not None and file_sum != self.sums[name]:
            raise DumpError(f"{path}: differs from its checksum in {SUMMARY_FILE}, so it was changed; {again}")
        return data

    def table(self, name: str) -> TextTable:
        """A table, by its name without the ending; DumpError as of `read` and `dump.table_of`."""
        return dump.table_of(self.read(f"{name}.csv"), str(self.folder / f"{name}.csv"))

    def dataset(self, name: str = "profiles.nc") -> xr.Dataset:
        """Profiles or fields; DumpError as of `read` and `dump.netcdf_of`."""
        return dump.netcdf_of(self.read(name), self.folder / name)

    def require_same(self, *names: str) -> None:
        """Raise DumpError where one of these files is there, and is not the one of the summary."""
        for name in names:
            if self.sums is not None and name in self.sums and (self.folder / name).exists():
                self.read(name)


def results_in(folder: Path, summary: Mapping[str, Any]) -> Results:
    """The results and outputs of a run of any status, with the checksums that its summary has."""
    block, outputs = summary.get("analysed"), summary.get("outputs")
    return Results(folder, {**(outputs or {}), **block["files"]} if block else outputs)


def results_of(folder: Path) -> Results:
    """As `results_in`, of the summary in the folder; without one nothing is known of the files."""
    known = (folder / SUMMARY_FILE).exists()
    return results_in(folder, _sums_of(folder).model_dump()) if known else Results(folder, None)


def status_of(folder: Path) -> str:
    """Status of a run by its summary; DumpError where it is none."""
    return _sums_of(folder).status or ""


def _sums_of(folder: Path) -> _Sums:
    path = folder / SUMMARY_FILE
    try:
        return _Sums.model_validate(read_json(path))
    except OSError as error:
        raise DumpError(f"{path}: cannot be read ({error.strerror or error}); name a folder with results") from None
    except ValidationError as error:
        first = error.errors()[0]
        raise DumpError(f"{path}: {'.'.join(map(str, first['loc']))}: {first['msg']}; {NO_SUMMARY}") from None
    except ValueError as error:
        raise DumpError(f"{path}: is no JSON ({shortened(str(error))}); {NO_SUMMARY}") from None


def open_results(folder: Path) -> Results:
    """The results of a run that is complete, or of a bare dump.

    Raises
    ------
    DumpError
        No summary, a run that is not complete, or no whole analysis of it.
    """
    file_sums, marker = _sums_of(folder), read_marker(folder)
    if file_sums.status != "complete" and not (
        file_sums.status is None and marker is not None and marker.kind == "analysis"
    ):
        said = f": {shortened(file_sums.message)}" if file_sums.message else ""
        raise DumpError(f"{folder}: the run there is {file_sums.status or 'of no known status'}, not complete{said}")
    if file_sums.analysed is None and "analysed" in file_sums.model_fields_set:
        raise DumpError(f"{folder}: was not analysed to the end; `{typed('analyze', folder)}` does that")
    return results_in(folder, file_sums.model_dump())


def write_summary(folder: Path, summary: Mapping[str, object]) -> Path:
    """Write the summary; NaN would be an error, not a file that others cannot read."""
    return write_json(folder / SUMMARY_FILE, summary, indent=2)


def read_summary(folder: Path) -> dict[str, Any]:
    """The summary of a run folder, empty where there is none that can be read.

    Raises
    ------
    DumpError
        Where the file is JSON and no summary of a run.
    """
    path = folder / SUMMARY_FILE
    try:
        data = read_json(path)
    except (OSError, ValueError):
        return {}
    place = ""
    try:
        Stored.model_validate(data)
        for place, kind, value in _stored_parts(data):  # noqa: B007
            kind.validate_python(value)
    except ValidationError as error:
        first = error.errors()[0]
        place = "".join(f" {name}:" for name in (place, *first["loc"]) if name != "")
        raise DumpError(f"{path}:{place} {first['msg']}, got {echoed(plain(first['input']))}; {NO_SUMMARY}") from None
    return data
