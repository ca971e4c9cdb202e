# SPDX-License-Identifier: GPL-2.0-or-later
"""Words of the fields of a case, from the models, and other words that people write; pydantic's errors in sentences.

A sentence says the place, what is wrong, what is allowed and what to do; it knows coefficients given as angles.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import fields, is_dataclass
from functools import cache
from types import UnionType
from typing import Any, NamedTuple, Union, cast, get_args, get_origin, get_type_hints

from pydantic import AfterValidator, BaseModel, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from lammps_jump.errors import CaseError
from lammps_jump.quoting import echoed, shortened
from lammps_jump.units import InUnit, not_backwards, ordered, unit_in_words
from lammps_jump.written import angle_of, is_quantity, odd_blank, tangent

from .fields import CaseFields
from .text import CaseSource, PathKey, dotted_path, nearest

SIGNS = {"gt": ">", "ge": ">=", "lt": "<", "le": "<="}
"""Bounds as pydantic calls them."""


@cache
def fields_of(model: type) -> dict[str, FieldInfo]:
    """Fields of a pydantic model or of a dataclass, by their names in a case."""
    if issubclass(model, BaseModel):
        return {field.alias or name: field for name, field in model.model_fields.items()}
    hints = get_type_hints(model, include_extras=True)
    declared = {
        name: depth
        for depth, base in reversed(list(enumerate(model.__mro__)))
        for name in vars(base).get("__annotations__", {})
    }
    own_first = sorted((item.name for item in fields(cast(Any, model))), key=declared.__getitem__)
    by_name = {name: FieldInfo.from_annotation(hints[name]) for name in own_first}
    return {field.alias or name: field for name, field in by_name.items()}


def models_in(annotation: object) -> list[type]:
    """Pydantic models and dataclasses that an annotation is made of."""
    if isinstance(annotation, type) and (issubclass(annotation, BaseModel) or is_dataclass(annotation)):
        return [annotation]
    return [model for part in get_args(annotation) for model in models_in(part)]


def kind_of(model: type) -> str | None:
    """Value of ``kind`` by which a case means this model."""
    kind = fields_of(model).get("kind")
    return get_args(kind.annotation)[0] if kind else None


def fields_by_name(model: type, group: str = "") -> dict[str, list[FieldInfo]]:
    """Fields of a model and of those in it by their dotted names, those of all kinds; ``kind`` itself left out."""
    by_name: dict[str, list[FieldInfo]] = {}
    for name, field in fields_of(model).items():
        if name != "kind":
            path = f"{group}.{name}".lstrip(".")
            by_name.setdefault(path, []).append(field)
            for inner in models_in(field.annotation):
                for other, several in fields_by_name(inner, path).items():
                    by_name.setdefault(other, []).extend(several)
    return by_name


def fields_at(model: type, location: Iterable[str | int]) -> list[FieldInfo]:
    """The fields that a location in a case may mean, one of each kind that has it.

    Parameters
    ----------
    model : type
        Where the location begins.
    location : iterable of str or int
        Names of fields, names or numbers of items; also kinds and tags (``<one>``), which choose, as in pydantic's.
    """
    around = fields = [_field(model)]
    for part in location:
        if part == "[key]":  # of a mapping, as pydantic calls it
            fields = [_field(get_args(field.annotation)[0]) for field in around]
        else:
            fields, around = [inner for field in fields for inner in _below(field, str(part))], fields
    return fields


def _below(field: FieldInfo, part: str) -> list[FieldInfo]:
    """Fields that a part of a location may mean below a field."""
    if part.startswith("<"):
        return [field]
    origin, parts = get_origin(field.annotation), get_args(field.annotation)
    models = models_in(field.annotation)
    if chosen := [model for model in models if kind_of(model) == part]:
        return list(map(_field, chosen))
    if origin in (Union, UnionType):
        return [inner for kind in parts for inner in _below(_field(kind), part)]
    if origin is dict:
        return [_field(parts[1])]
    if origin is tuple and parts[-1] is Ellipsis:
        return [_field(parts[0])]
    if origin is tuple:
        return [_field(parts[int(part)])] if part.isdigit() and int(part) < len(parts) else []
    return [known[part] for known in map(fields_of, models) if part in known]


def _field(annotation: Any) -> FieldInfo:
    """A field of this type."""
    return FieldInfo.from_annotation(annotation)


def notes_of(field: FieldInfo) -> Iterator[object]:
    """Annotations of a field, its alternatives and its items, groups of fields left out."""
    yield from field.metadata
    waiting = [field.annotation]
    while waiting:
        kind: Any = waiting.pop(0)
        for item in getattr(kind, "__metadata__", ()):
            yield from getattr(item, "metadata", (item,))
        waiting += () if isinstance(kind, type) else get_args(kind)


def _is_number(kind: Any) -> bool:
    return any(isinstance(note, InUnit) for note in notes_of(_field(kind)))


class Vector(NamedTuple):
    """Number of values of a field, and whether they must rise."""

    length: int
    rises: bool


def vector_in(fields: Iterable[FieldInfo]) -> Vector | None:
    """Vector that a field is: a list of so many numbers, or one of its alternatives is; None where there is none."""
    for field in fields:
        rises = any(
            isinstance(note, AfterValidator) and note.func in (ordered, not_backwards) for note in notes_of(field)
        )
        waiting = [field.annotation]
        while waiting:
            kind: Any = waiting.pop(0)
            parts = get_args(kind)
            if get_origin(kind) is not tuple:
                waiting += parts
            elif Ellipsis not in parts and all(_is_number(part) for part in parts):
                return Vector(len(parts), rises)
    return None


def unit_of(fields: Iterable[FieldInfo]) -> str:
    """The SI unit of fields; empty where they have none, or several."""
    units = {note.unit for field in fields for note in notes_of(field) if isinstance(note, InUnit)}
    return units.pop() if len(units) == 1 else ""


def label_of(fields: Iterable[FieldInfo]) -> str:
    """A few words for an axis or a table; empty where the fields have none, or several."""
    labels = {field.title or "" for field in fields}
    return labels.pop() if len(labels) == 1 else ""


def range_of(fields: Iterable[FieldInfo]) -> str:
    """Range of a number, with its unit; empty where there are no bounds."""
    fields = list(fields)
    bounds = (
        (sign, getattr(note, key, None)) for field in fields for note in notes_of(field) for key, sign in SIGNS.items()
    )
    text = " and ".join(dict.fromkeys(f"{sign} {bound:zg}" for sign, bound in bounds if bound is not None))
    unit = unit_of(fields)
    return f"{text} {unit_in_words(unit)}" if text and unit else text


def briefly(fields: Iterable[FieldInfo]) -> str:
    """Label of a field, or the begin of its meaning; and its unit."""
    fields = list(fields)
    meanings = dict.fromkeys(re.split(r"[;.] | \(\w+\.md", field.description or "")[0] for field in fields)
    said = label_of(fields) or " or ".join(filter(None, meanings))
    unit = unit_of(fields)
    return f"{said}, in {unit_in_words(unit)}" if said and unit else said


STEP = "the step follows from the stiffness: give its share of the largest stable one; `check` prints it in s"
MEANT = (
    ("bodies.x", "width base breadth length", "[left, right]; x.1 is its right end, and x.0 its left end"),
    ("bodies.y", "height top", "[underside, top]; y.1 is its top, and y.0 its underside"),
    ("contact.friction", "mu cof coulomb friction_coefficient", ""),
    ("contact.from_material", "E young e_modulus elastic_modulus youngs_modulus young_modulus modulus material",
     "{young: 5 MPa, poisson: 0.3}, in place of stiffness and largest_overlap"),
    ("contact.impact_speed", "v0 speed velocity max_speed vmax reference_speed", ""),
    ("contact.largest_overlap", "n overlap max_overlap penetration penetration_fraction", ""),
    ("contact.restitution", "e cor en e_n damping restitution_coefficient bounce", "0.2 keeps a fifth of the speed"),
    ("contact.rolling", "rolling_friction mu_r rolling_resistance", "{friction: 0.1}, with friction_law: history"),
    ("contact.rotation", "spin rotate", ""),
    ("contact.stiffness", "k kn k_n spring", ""),
    ("discs", "particles particle grains grain disks disk spheres balls atoms", ""),
    ("discs.density", "rho mass_density", ""),
    ("discs.diameter", "radius r size d", "twice the radius"),
    ("discs.sizes", "polydispersity distribution psd", "{kind: uniform, spread: 0.2}"),
    ("domain", "box region simulation_box limits bounds", "{x: [0, 10], y: [0, 5]}"),
    ("domain.periodic", "boundary pbc", ""),
    ("gravity", "g acceleration", ""),
    ("inflow", "inlet source jet inflows", ""),
    ("inflow.depth", "height thickness h y1", ""),
    ("inflow.discharge", "q flow flow_rate rate flux", ""),
    ("inflow.mean_speed", "speed velocity v u va vx", ""),
    ("inflow.table", "rows points times series hydrograph", ""),
    ("initial", "start initial_conditions water fluid column reservoir columns", "a list with a kind: column in it"),
    ("initial.positions", "points coordinates xy", "[[x, y], …]"),
    ("initial.velocity", "speed v u", ""),
    ("outflow", "outlet sink drain outlets", "[{x_beyond: 20}, {y_below: -1}]"),
    ("outflow.x_beyond", "x x_above x_max xmax right", ""),
    ("outflow.x_before", "x_below x_min xmin left", ""),
    ("outflow.y_below", "y y_before y_min ymin bottom", ""),
    ("outflow.y_above", "y_beyond y_max ymax top", ""),
    ("probes", "sensors monitors measure", "{forces: [name of a wall], gauges: [x]}"),
    ("probes.forces", "walls force wall", ""),
    ("probes.gauges", "x points wave_gauges depth depths", ""),
    ("run", "simulation settings time solver", ""),
    ("run.duration", "time end t_end tend t_max tmax end_time total_time length until", ""),
    ("run.output_interval", "output interval dt_out output_step dump_interval save_interval frame_interval "
     "every write_interval", ""),
    ("run.seed", "random random_seed", ""),
    ("run.time_step_fraction", "dt timestep time_step step delta_t cfl steps n_steps", STEP),
    ("engine.ranks", "cores processes np mpi procs processors cpus", "of MPI; engine.threads are those of one process"),
    ("slope", "tilt angle inclination theta incline", ""),
    ("walls", "geometry boundaries wall boundary bed structures obstacles", ""),
    ("walls.x", "width base breadth length", "[left, right]; x.1 is its right end, and x.0 its left end"),
    ("walls.y", "height top crest level", "[underside, top]; y.1 is its top, and y.0 its underside"),
    ("walls.angle", "rotation tilt theta", ""),
    ("walls.at", "position offset x y", ""),
    ("walls.axis", "normal direction", ""),
    ("walls.motion", "movement velocity moving speed", "{kind: translate, velocity: [1, 0]}"),
    ("walls.motion.angle", "angular_amplitude", ""),
    ("walls.motion.from", "start begin t0 start_time", ""),
    ("walls.motion.period", "frequency freq omega f", "one over the frequency"),
    ("walls.motion.points", "rows table times data values positions path", ""),
    ("walls.motion.rate", "omega speed velocity angular_velocity rpm", ""),
    ("walls.motion.until", "end stop t1 end_time", ""),
    ("walls.motion.velocity", "speed v u vx", ""),
    ("walls.points", "vertices coordinates nodes xy path", "[[x, y], …]"),
    ("walls.centre", "middle position origin", ""),
    ("walls.from", "start begin x y", ""),
    ("walls.to", "end stop", ""),
    ("analysis.window", "time interval average averaging from", ""),
    ("analysis.bin_width", "bins bin dx", ""),
)  # fmt: skip
"""Synonyms of fields, with a hint where the meaning differs."""
KINDS = {
    "rectangle rect solid obstacle sill step structure": "block",
    "floor ground bottom side flat infinite": "plane",
    "container tank": "box",
    "segment polyline curve spline bed wall lines polygonal_chain": "line",
    "triangle": "polygon",
    "disc disk arc drum cylinder": "circle",
    "fixed rough_bed bumpy particles": "rough",
    "linear move moving slide velocity constant": "translate",
    "rotation turn spin angular": "rotate",
    "sine sinus sinusoidal harmonic periodic vibration shake wave": "oscillate",
    "points file series list tabulated": "table",
    "lid piston mass force free": "load",
    "tailgate gate weir tailwater control controller regulate": "hold",
    "jet inlet row uniform rows_of_discs": "rows",
    "rain drop fall hopper fill": "pour",
    "block rectangle dam reservoir water fluid": "column",
    "grid array square": "lattice",
    "positions points discs": "list",
    "random range flat_distribution": "uniform",
    "two binary bimodal": "bidisperse",
    "custom table": "list",
}
"""Words for kinds."""


class Meaning(NamedTuple):
    """A field that a word may mean: its group, its name there, and what its value is."""

    group: str
    name: str
    said: str

    @property
    def path(self) -> str:
        """Dotted name of the field."""
        return f"{self.group}.{self.name}".lstrip(".")

    def told(self, said: str) -> Meaning:
        """The same with what its value is, where the word needs no answer of its own."""
        return self if self.said else self._replace(said=said)

    def __str__(self) -> str:
        """The field and its value, for a message."""
        return f"{self.path} ({self.said})" if self.said else self.path


def meanings(word: str) -> list[Meaning]:
    """Fields that a word may mean."""
    spelled = word.lower().replace("-", "_") if len(word) > 1 else word
    pairs = (
        (path, said) for path, words, said in MEANT if spelled in words.split() or spelled == path.rpartition(".")[2]
    )
    return [Meaning(*path.rpartition(".")[::2], said) for path, said in pairs]


def kinds(word: str) -> list[str]:
    """Kinds that a word may mean."""
    return [kind for words, kind in KINDS.items() if word.lower().replace("-", "_") in words.split()]


UNKNOWN = ("extra_forbidden", "unexpected_keyword_argument")
"""Names by which pydantic calls a key that a model or a dataclass does not have."""

CLOSE = 0.75
"""Likeness of spelling from which a word is taken for a misspelt one, before words of the same meaning elsewhere."""
MOST_OTHERS = 6
"""Other problems of a case that a message names."""
MOST_NAMED = 3
"""Fields of other groups that a message names."""


def explain(error: ValidationError, source: CaseSource, model: type[BaseModel]) -> CaseError:
    """The first problem as a `CaseError` with its place in the file, and the number of others; fields of `model`."""
    problems = error.errors(include_url=False)
    # an unknown key often explains a missing one: say the unknown key first
    problems.sort(key=lambda problem: problem["type"] not in UNKNOWN)
    first = problems[0]
    path = _data_path(first["loc"], source.whole)
    if first["type"] == "union_tag_invalid":
        path += ("kind",)
    path += getattr(first.get("ctx", {}).get("error"), "path", ())  # of a `PlaceError`
    if first["type"] == "missing" and isinstance(first["loc"][-1], int):
        path = path[:-1]  # of the vector that lacks it
    more = f" ({len(problems) - 1} more after this one{_others(problems, source)})" if len(problems) > 1 else ""
    return CaseError(f"{source.place(path)}: {_sentence(first, path, model)}{more}")


def _others(problems: Sequence[ErrorDetails], source: CaseSource) -> str:
    """Places of the other problems, as far as they are few."""
    paths = dict.fromkeys(dotted_path(_data_path(problem["loc"], source.whole)) for problem in problems[1:])
    return f": {', '.join(paths)}" if all(paths) and len(paths) <= MOST_OTHERS else ""


def _data_path(location: tuple[Any, ...], data: Any) -> PathKey:
    """Pydantic's location without the tags of discriminated unions, some of which begin with <, and of branches."""
    path: list[str | int] = []
    here = data
    for position, part in enumerate(location):
        last = position == len(location) - 1
        if isinstance(here, dict) and (part in here or (last and part != here.get("kind") and str(part)[:1] != "<")):
            path.append(part)
            here = here.get(part)
        elif isinstance(here, list) and isinstance(part, int):
            path.append(part)
            here = here[part] if part < len(here) else None
    return tuple(path)


def _sentence(problem: ErrorDetails, path: PathKey, model: type[BaseModel]) -> str:
    kind, context, value = problem["type"], problem.get("ctx", {}), problem.get("input")
    if vector := _vector(problem, path, model):
        return vector
    if kind in UNKNOWN:
        if blank := odd_blank(str(path[-1])):
            return f"unknown field, with {blank} in its name; write blanks alone"
        if value is None and re.fullmatch(r"[0-9]+\D*", str(path[-1])):
            return "unknown field; a decimal comma ends a number in braces: decimals have a point, such as 0.2"
        return f"unknown field; {_meant(path, _models_at(problem['loc'][:-1], model), model)}"
    if kind == "missing":
        fields = fields_at(model, problem["loc"])
        words = [repr(word) for field in fields for word in get_args(field.annotation) if isinstance(word, str)]
        known = f"allowed is {', '.join(words)}" if words else "`lammps-jump new hydraulic_jump` shows a whole case"
        said = f" ({said})" if (said := briefly(fields)) else ""
        return f"is required and not there{said}; {known}"
    if kind.startswith(("greater_than", "less_than")):
        broken = " and ".join(f"{SIGNS[key]} {context[key]}" for key in SIGNS if key in context)
        return f"{echoed(value)} is out of range; allowed is {range_of(fields_at(model, problem['loc'])) or broken}"
    if kind == "literal_error":
        return f"{echoed(value)} is not known; allowed is {context['expected']}"
    if kind in ("union_tag_not_found", "union_tag_invalid"):
        return _kind(context.get("tag"), value, [kind_of(item) or "" for item in _models_at(problem["loc"], model)])
    if kind == "value_error":
        return str(context["error"])
    if kind == "string_pattern_mismatch":
        return f"{echoed(value)} is not a usable name; allowed: {briefly(fields_at(model, problem['loc']))}"
    if kind in ("tuple_type", "list_type") and isinstance(value, str | int | float):
        return f"{echoed(value)} is a single value; this field is a list: [{shortened(str(value))}]"
    if kind in ("tuple_type", "list_type", "too_long", "too_short", "missing_argument"):
        written = "point is written [x, y]" if "points" in path else "pair is written [low, high]"
        return f"{echoed(value)} does not fit: {problem['msg'].lower()}; a {written}, a list with dashes"
    if kind in ("model_type", "model_attributes_type", "dataclass_type", "dict_type"):
        if blank := odd_blank(value) if isinstance(value, str) else "":
            return f"{echoed(value)} has {blank}, which YAML takes for a letter of a text; write blanks alone"
        return f"{echoed(value)} is a single value; this field is a group of fields (`lammps-jump new` shows one)"
    return f"{echoed(value)} does not fit: {problem['msg'][0].lower()}{problem['msg'][1:]}"


NUMBER_WORDS = {2: "two", 3: "three", 4: "four"}


def _vector(problem: ErrorDetails, path: PathKey, model: type[BaseModel]) -> str:
    """Lack or surplus of a vector, an interval or a row of numbers; empty where the problem is another."""
    kind, location, value = problem["type"], problem["loc"], problem.get("input")
    if kind == "missing" and isinstance(location[-1], int):
        location = location[:-1]
    elif kind not in ("tuple_type", "list_type", "too_long", "too_short"):
        return ""
    if not (vector := vector_in(fields_at(model, location))):
        return ""
    given = list(value) if isinstance(value, list | tuple) else [value]
    words = NUMBER_WORDS.get(vector.length, str(vector.length))
    example = shortened(", ".join(_example(given, vector)))
    point = " [x, y]" if "points" in path and vector.length == 2 else ""
    needs = f"needs {words} numbers{point}, for example [{example}]"
    if value is None:
        return f"is empty; {needs}"
    if len(given) > vector.length:
        return f"{echoed(value)} has {len(given)} values; {needs} (decimals have a point: 0.5)"
    return f"{echoed(value)} does not fit: {needs}"


def _example(given: list[Any], vector: Vector) -> list[str]:
    """Numbers of a vector, those that were given among them."""
    texts = [f"{one:zg}" for one in given if isinstance(one, int | float) and not isinstance(one, bool)]
    if not texts and given and isinstance(given[0], str):  # 8 m/s, or 8, 0
        parts = given if is_quantity(given[0]) else re.split(r"[\s,;]+", given[0].strip("[]() "))
        texts = [one for one in parts if isinstance(one, str) and is_quantity(one)]
    if vector.rises and len(texts) == 1 and re.match(r"[0-9.]*[1-9]", texts[0]):
        return ["0", *texts]
    last = "1" if vector.rises and texts == ["0"] else "0"
    return [*(texts or ["1"]), *[last] * vector.length][: vector.length]


def _meant(path: PathKey, models: list[type], whole: type[BaseModel]) -> str:
    """Fields that an unknown key may mean: of its group by meaning or spelling, or one of another group."""
    word, known = str(path[-1]), list(_fields(models))
    own = (getattr(item, "NO_FIELDS", {}).get(word) for item in models)
    if hint := next(filter(None, own), None):
        return hint
    group = ".".join(part for part in path[:-1] if isinstance(part, str))
    named = fields_by_name(whole) if whole is CaseFields else {}
    possible = [one.told(briefly(named[one.path])) for one in meanings(word) if named]
    here = [one for one in possible if one.group == group and one.name in known]
    if here or difflib.get_close_matches(word, known, n=1, cutoff=CLOSE):
        return f"write {here[0]}" if here else nearest(word, known)
    away = {one.path: str(one) for one in possible if one.group != group and len(one.name) > 1}  # x and y: of what?
    elsewhere = [other for other in named if other.rpartition(".")[2] == word and other.rpartition(".")[0] != group]
    away |= {other: other for other in elsewhere if other not in away}
    if not away:
        return nearest(word, known)
    texts = list(away.values()) if len(away) == 1 else list(away)[:MOST_NAMED]
    return f"perhaps {' or '.join(texts)} is meant"


def _kind(tag: object, value: object, known: list[str]) -> str:
    """A group whose kind is missing or not known: the kinds, and the one that is meant."""
    allowed = ", ".join(f"'{one}'" for one in known)
    if tag is None:
        typed = " ('type' is called kind here)" if isinstance(value, dict) and "type" in value else ""
        return f"kind is missing{typed}; allowed is {allowed}"
    meant = [one for one in kinds(str(tag)) if one in known]
    meant = meant or difflib.get_close_matches(str(tag), known, n=1)
    hint = f"; did you mean '{meant[0]}'?" if meant else ""
    return f"{echoed(tag)} is not known; allowed is {allowed}{hint}"


def _models_at(location: tuple[Any, ...], model: type) -> list[type]:
    """The models that are allowed at pydantic's location, from `model` on."""
    return [each for field in fields_at(model, location) for each in models_in(field.annotation)]


def _fields(models: list[type]) -> dict[str, FieldInfo]:
    return {name: field for item in models for name, field in fields_of(item).items()}


def slopes_of_angles(data: Any) -> tuple[str, ...]:
    """Sentences on the numbers of a case's data that are tangents of angles, one each, in the order of the data."""
    sentences = []
    for path, text in _texts(data, ()):
        if (angle := angle_of(text)) is None:  # most texts are none, and looking for their fields takes long
            continue
        fields = fields_at(CaseFields, path)
        if any(isinstance(note, InUnit) and note.slope for field in fields for note in notes_of(field)):
            sentences.append(f"{_named(data, path)}: {tangent(angle):z.3g}, the tangent of {echoed(text)}")
    return tuple(sentences)


def _texts(data: Any, path: PathKey) -> Iterator[tuple[PathKey, str]]:
    """Texts in plain data, with their paths."""
    if isinstance(data, str):
        yield path, data
    elif isinstance(data, dict | list):
        for key, value in data.items() if isinstance(data, dict) else enumerate(data):
            yield from _texts(value, (*path, key))


def _named(data: Any, path: PathKey) -> str:
    """A path as ``--set`` takes it, items of lists by their names where they have one: ``walls.bed.friction``."""
    parts: list[str] = []
    for part in path:
        data = data[part]
        own = data.get("name") if isinstance(data, dict) and isinstance(part, int) else None
        parts.append(str(part if own is None else own))
    return dotted_path(tuple(parts))
