# SPDX-License-Identifier: GPL-2.0-or-later
"""A case as an object: read from a file, text or mapping, changed, checked, turned into a scene; those of `inputs/`."""

from __future__ import annotations

import copy
import json
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Self

import yaml
from pydantic import ValidationError

from lammps_jump.errors import CaseError, FieldError, NearestNames
from lammps_jump.files import plain, text_of
from lammps_jump.folders import MARKER_FILE
from lammps_jump.identity import case_key
from lammps_jump.quoting import LONGEST, echoed, plain_name
from lammps_jump.scene.scene import Scene
from lammps_jump.scene.tracks import Held

from .derived import Derived
from .earlier import from_run, read_runs, with_restart
from .field_words import explain, slopes_of_angles
from .fields import CaseFields
from .text import CaseSource, PathKey, nearest, override, parse_source, read_source, read_tables, value_at
from .to_scene import build_scene

NOT_TOLD = ("name", "analysis", "probes", "engine", "run.members", "run.checkpoint_interval", "run.dump_format")
"""Fields whose change is not mentioned after a description: the flow is the same."""
TOLD = "analysis.window"
"""Field of `analysis` that a description tells: all means are taken over it."""
OF_THE_FLOW = ("gravity", "slope", "discs", "contact", "domain", "walls", "initial", "inflow", "outflow")
"""Fields that a description of a scene may speak of."""
CHANGED = "changed: "


def scene_folder() -> Path:
    """Folder of the case files: inside the package in a wheel, next to it in a checkout."""
    package = Path(__file__).resolve().parents[1]
    inside = package / "inputs"
    return inside if inside.is_dir() else package.parent / "inputs"


def scene_names() -> list[str]:
    """Names that `scene_text` knows."""
    return sorted(path.stem for path in scene_folder().glob("*.yaml"))


def scene_text(name: str) -> str:
    """Text of a scene's case file.

    Raises
    ------
    CaseError
        For a name that is not there, with the nearest that is.
    """
    names = scene_names()
    if name not in names:
        raise CaseError(f"new {name}: there is no such scene; {nearest(name, names)}")
    return text_of(scene_folder() / f"{name}.yaml")


def described(text: str, source: CaseSource) -> str:
    """A description, then the values that ``--set`` or a study has changed; without them where it is too long.

    It names values that an earlier case had changed once: ``a channel; changed: run.seed = 1, contact.friction = 0.1``.
    """
    before, sign, changes_text = text.rpartition(CHANGED)
    changes = dict(re.findall(r"([\w.-]+) = (.*?)(?=, [\w.-]+ = |$)", changes_text)) if sign else {}
    before = before.removesuffix("; ") if changes else text
    for path, assignment in source.overrides.items():
        if path == ("description",):
            changes = {}
        elif (value := source.value(path)) is not None and _is_told(path):
            name = assignment.partition("=")[0].strip()
            changes.pop(name, None)
            changes[name] = value if isinstance(value, str) else json.dumps(value)
    whole = "; ".join(filter(None, [before, CHANGED + ", ".join(map(" = ".join, changes.items())) if changes else ""]))
    return whole if len(whole) <= LONGEST else f"{before[: LONGEST - 40]}; {len(changes)} values changed"


def _is_told(path: PathKey) -> bool:
    dotted = ".".join(map(str, path))
    silent = "jitter" in path or any(f"{dotted}.".startswith(f"{name}.") for name in NOT_TOLD)
    return dotted == TOLD or not silent


def of_another_case(source: CaseSource) -> str:
    """Name of the scene whose description a case still has although its flow is another one; else empty.

    Scenes themselves and run folders are as they were written.
    """
    text, place = source.data.get("description"), Path(source.file).absolute().parent
    if not isinstance(text, str) or place == scene_folder() or (place / MARKER_FILE).exists():
        return ""
    line = " ".join(text.split())
    for name in scene_names():
        if f"\ndescription: {line}\n" in (scene := scene_text(name)):
            try:
                case, own = (CaseFields.model_validate(data) for data in (parse_source(scene).data, source.data))
            except ValidationError:  # the check tells it, with its place
                return ""
            return name if any(getattr(case, key) != getattr(own, key) for key in OF_THE_FLOW) else ""
    return ""


Changes = Mapping[str, object] | Iterable[str]
"""Values by path, ``{"walls.sill.y": [-10, 3]}``, or texts ``path=value`` as of ``--set``."""

NOT_OF_THE_RUN = ("name", "description", "analysis")
WEIGHTS = ("stability", "stability_mean")
"""Fields of ``probes`` that only the analysis reads; of the run the names are, whose forces are recorded."""
"""Fields that change nothing of the run itself."""


@dataclass(frozen=True)
class ReadCase(NearestNames):
    """A validated case; `lammps_jump.Case` adds what runs it.

    Attributes
    ----------
    fields : CaseFields
        The values, every default filled in; frozen.
    source : CaseSource
        Where each value is given, for messages.
    """

    in_words = "a case"
    habits: ClassVar[dict[str, str]] = {
        "save": 'Path("my.yaml").write_text(case.to_yaml())',
        "to_dict": "case.fields.model_dump()",
        "copy": "case.replace({…}), which makes another one; a case does not change",
        "update": "case | {…}, which makes another one",
        "plot": 'case.preview("folder")',
    }

    fields: CaseFields
    source: CaseSource = field(repr=False, compare=False)

    def __new__(cls, fields: object = None, source: object = None) -> Self:
        """A case of what was read; TypeError for the name of a file, which `load` takes."""
        if isinstance(fields, str | Path):
            raise TypeError(f"Case() takes no file; write load_case({str(fields)!r})")
        return super().__new__(cls)

    @classmethod
    def load(cls, source: str | Path | Mapping[str, object], changes: Changes | None = None) -> Self:
        """Read, change and validate a case.

        Parameters
        ----------
        source : str, Path or mapping
            A YAML file, a run folder (its ``case.yaml``), or the fields themselves.
        changes : mapping or iterable of str, optional
            Values by path, ``{"contact.friction": 0.1, "walls.sill.y": [-10, 3]}``: list items by name or index.
            Numbers are SI, texts may carry a unit (``"20 cm"``). Or texts ``path=value``, as of ``--set``.

        Raises
        ------
        CaseError
            One paragraph with file:line, the field, the value, what is allowed and what to do.
        """
        if isinstance(source, Mapping):
            read = CaseSource(file="<case>", data=json.loads(_json_text(dict(source))))
            return cls._read(read, changes or (), "case")
        path = Path(source)
        if (path / "case.yaml").is_file():
            path /= "case.yaml"
        return cls._read(read_source(path), changes or (), path.stem)

    @classmethod
    def parse(cls, text: str, file: str = "<case>", changes: Changes = (), *, folder: Path | None = None) -> Self:
        """As `load`, from YAML text; `file` is its name in messages.

        Tables and runs that it names lie in `folder`.
        """
        read = parse_source(text, file)
        read.folder = folder
        return cls._read(read, changes, Path(file).stem)

    @classmethod
    def _read(cls, source: CaseSource, changes: Changes, default_name: str) -> Self:
        if name := of_another_case(source):
            source.data.pop("description")
            source.left_out = name
        return cls(_validated(source, changes, default_name), source)

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            if name in CaseFields.model_fields:
                return getattr(self.fields, name)
            return self._missing(name)

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *CaseFields.model_fields})

    def __getitem__(self, path: str) -> Any:
        """The value at a path, as a case file has it: ``case["run.duration"]``, ``case["walls.sill.y"]``.

        Raises
        ------
        CaseError
            A path that is not there; the message has the nearest one.
        """
        return value_at(self.fields.model_dump(mode="json"), path)

    @property
    def name(self) -> str:
        """Name of the case."""
        return self.fields.name

    @property
    def structures(self) -> tuple[str, ...]:
        """Names in the force record: the walls requested, those of groups, and the groups."""
        probes = self.fields.probes
        return tuple(dict.fromkeys((*probes.walls, *probes.groups)))

    @property
    def weighed(self) -> tuple[str, ...]:
        """Names of the structures whose stability is looked at: bodies, and walls that are given a weight."""
        return (*self.body_names, *(self.fields.probes.stability or {}))

    @property
    def pressed(self) -> tuple[str, ...]:
        """Names of the walls and bodies whose pressure is recorded, and of their gauges."""
        requested = (self.fields.probes.pressure or {}).items()
        names = ((name, *(f"{name}_{k}" for k in range(1, len(one.points) + 1))) for name, one in requested)
        return tuple(name for group in names for name in group)

    @property
    def overtopped(self) -> tuple[str, ...]:
        """Names of the structures for which overtopping can be computed: bodies and probed walls."""
        return (*self.body_names, *self.fields.probes.walls)

    @property
    def tailgates(self) -> tuple[str, ...]:
        """Names of the walls that hold a depth or a front."""
        return tuple(wall.name for wall in self.fields.walls if isinstance(getattr(wall, "motion", None), Held))

    @property
    def body_names(self) -> tuple[str, ...]:
        """Names of the bodies that move freely."""
        return tuple(body.name for body in self.fields.bodies)

    @cached_property
    def hash(self) -> str:
        """Twelve hex digits, equal for cases that give the same run: name, description and analysis are left out."""
        return case_key(self.core)

    @cached_property
    def core(self) -> dict[str, Any]:
        """Plain data of what decides the run: no name, description, analysis, threads, or how often it is saved."""
        data = {key: value for key, value in self._data.items() if key not in NOT_OF_THE_RUN}
        for group, name in (("run", "checkpoint_interval"), ("engine", "threads")):
            data[group] = {key: value for key, value in data[group].items() if key != name}
        probes = {key: value for key, value in data["probes"].items() if key not in WEIGHTS}
        data["probes"] = probes | {"stability": sorted(names)} if (names := self.fields.probes.stability) else probes
        return data

    @cached_property
    def rest(self) -> dict[str, Any]:
        """Plain data of what changes no run: name, description and analysis."""
        rest_of_data = {key: value for key, value in self._data.items() if key in NOT_OF_THE_RUN}
        weights = {key: value for key, value in self._data["probes"].items() if key in WEIGHTS}
        return rest_of_data | ({"weights": weights} if weights else {})

    @cached_property
    def _data(self) -> dict[str, Any]:
        """Plain data without the empty optional fields, which would only be noise for a reader."""
        data = _kind_first(self.fields.model_dump(mode="json", exclude_none=True))
        return data if self.fields.bodies else {name: value for name, value in data.items() if name != "bodies"}

    def replace(self, changes: Changes) -> Self:
        """The case with other values, validated as a file is.

        Parameters
        ----------
        changes : mapping or iterable of str
            As of `load`.

        Raises
        ------
        CaseError
            A path that is not there, or a value that is not allowed.
        """
        source = copy.deepcopy(self.source)
        return type(self)(_validated(source, changes, self.name), source)

    def after(self, run: object, time: float | str = "last", velocities: Literal["keep", "rest"] = "keep") -> Self:
        """The case with the discs of a run in place of its own at the start.

        Parameters
        ----------
        run : Run, str or Path
            A run that has ended or was stopped, or its folder; anywhere.
        time : float or 'last'
            s: the nearest frame of its dump; or its end, with all digits.
        velocities : {'keep', 'rest'}

        Raises
        ------
        CaseError
            As `load`.
        """
        source = copy.deepcopy(self.source)
        item = from_run(source, Path(str(getattr(run, "folder", run))), time)
        changes = {"initial": [{**item, "velocities": velocities}]}
        return type(self)(_validated(source, changes, self.name), source)

    def scene(self) -> Scene:
        """The engine-neutral numbers of the case, SI.

        Raises
        ------
        CaseError
            A scene that cannot be run: an unstable step, discs inside walls, a domain too large.
        """
        return self._scene

    @cached_property
    def _scene(self) -> Scene:
        try:
            scene = build_scene(self.fields, self.source.begun)
        except FieldError as error:
            raise self.source.located(error) from None
        doubts = self.source.doubts
        return replace(scene, warnings=(*doubts, *scene.warnings)) if doubts else scene

    def check(self) -> Derived:
        """Everything derived from the case: coefficients, theory of the inflow, what is skipped, warnings.

        Raises
        ------
        CaseError
            As `scene`.
        """
        return Derived(self.fields, self.scene(), self.source.left_out, slopes_of_angles(self.source.data))

    def to_yaml(self) -> str:
        """The case as YAML text, every default filled in, in the order of the fields."""
        return yaml.safe_dump(self._data, sort_keys=False, allow_unicode=True, width=110, default_flow_style=None)


def _kind_first(data: Any) -> Any:
    """Plain data whose groups begin with kind and name."""
    if isinstance(data, dict):
        first = {key: data[key] for key in ("kind", "name") if key in data} if "kind" in data else {}
        return {key: _kind_first(value) for key, value in (first | data).items()}
    return [_kind_first(item) for item in data] if isinstance(data, list) else data


load_case = ReadCase.load
parse_case = ReadCase.parse


def _json_text(value: object) -> str:
    """A value as JSON, which is YAML too; CaseError if a case cannot hold the value."""
    try:
        return json.dumps(plain(value))
    except (TypeError, ValueError):
        raise CaseError(
            f"{echoed(value)} is no value of a case; numbers, texts, lists and mappings are allowed"
        ) from None


def _validated(source: CaseSource, changes: Changes, default_name: str) -> CaseFields:
    """The fields of a case after its changes, which are then also in `source`.

    Raises
    ------
    CaseError
        One paragraph with file:line, the field, the value, what is allowed and what to do.
    """
    if isinstance(changes, Mapping):
        changes = [f"{path}={_json_text(value)}" for path, value in changes.items()]
    for assignment in changes:
        override(source, assignment)
    read_tables(source)
    read_runs(source)
    data = dict(source.whole)
    if "name" not in data:
        data["name"] = plain_name(default_name)
    try:
        fields = CaseFields.model_validate(data)
    except ValidationError as error:
        raise explain(error, source, CaseFields) from None
    fields = fields.model_copy(
        update={"description": described(fields.description, source), "initial": with_restart(fields.initial, source)}
    )
    try:
        _check(fields)
    except FieldError as error:
        raise source.located(error) from None
    return fields


def _check(fields: CaseFields) -> None:
    """Refuse walls and bodies of one name, and a case without a disc."""
    places = [
        (f"{field}.{i}", item.name) for field in ("walls", "bodies") for i, item in enumerate(getattr(fields, field))
    ]
    for index, (place, name) in enumerate(places):
        if name in [other for _, other in places[:index]]:
            what = "walls" if place.startswith("walls") else "walls or bodies"
            raise FieldError(f"{place}.name", f"two {what} are called '{name}'; give each its own name")
    if not fields.initial and fields.inflow is None:
        raise FieldError("initial", "there are no discs; give a column, a lattice, a list or a run, or give inflow")
