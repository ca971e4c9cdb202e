# SPDX-License-Identifier: GPL-2.0-or-later
"""Words of the fields of a case: meaning, label, unit and range from the models; other words that people write."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import fields, is_dataclass
from functools import cache
from types import UnionType
from typing import Any, NamedTuple, Union, cast, get_args, get_origin, get_type_hints

from pydantic import AfterValidator, BaseModel
from pydantic.fields import FieldInfo

from lammps_jump.units import InUnit, not_backwards, ordered, unit_in_words

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
    found = {name: FieldInfo.from_annotation(hints[name]) for name in own_first}
    return {field.alias or name: field for name, field in found.items()}


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
    found: dict[str, list[FieldInfo]] = {}
    for name, field in fields_of(model).items():
        if name != "kind":
            path = f"{group}.{name}".lstrip(".")
            found.setdefault(path, []).append(field)
            for inner in models_in(field.annotation):
                for other, several in fields_by_name(inner, path).items():
                    found.setdefault(other, []).extend(several)
    return found


def fields_at(model: type, location: Iterable[str | int]) -> list[FieldInfo]:
    """The fields that a location in a case may mean, one of each kind that has it.

    Parameters
    ----------
    model : type
        Where the location begins.
    location : iterable of str or int
        Names of fields, names or numbers of items; also kinds and tags (``<one>``), which choose, as in pydantic's.
    """
    around = found = [_field(model)]
    for part in location:
        if part == "[key]":  # of a mapping, as pydantic calls it
            found = [_field(get_args(field.annotation)[0]) for field in around]
        else:
            found, around = [inner for field in found for inner in _below(field, str(part))], found
    return found


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


def vector_in(found: Iterable[FieldInfo]) -> Vector | None:
    """Vector that a field is: a list of so many numbers, or one of its alternatives is; None where there is none."""
    for field in found:
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


def unit_of(found: Iterable[FieldInfo]) -> str:
    """The SI unit of fields; empty where they have none, or several."""
    units = {note.unit for field in found for note in notes_of(field) if isinstance(note, InUnit)}
    return units.pop() if len(units) == 1 else ""


def label_of(found: Iterable[FieldInfo]) -> str:
    """A few words for an axis or a table; empty where the fields have none, or several."""
    labels = {field.title or "" for field in found}
    return labels.pop() if len(labels) == 1 else ""


def range_of(found: Iterable[FieldInfo]) -> str:
    """Range of a number, with its unit; empty where there are no bounds."""
    found = list(found)
    bounds = (
        (sign, getattr(note, key, None)) for field in found for note in notes_of(field) for key, sign in SIGNS.items()
    )
    text = " and ".join(dict.fromkeys(f"{sign} {bound:zg}" for sign, bound in bounds if bound is not None))
    unit = unit_of(found)
    return f"{text} {unit_in_words(unit)}" if text and unit else text


def briefly(found: Iterable[FieldInfo]) -> str:
    """Label of a field, or the begin of its meaning; and its unit."""
    found = list(found)
    meanings = dict.fromkeys(re.split(r"[;.] | \(\w+\.md", field.description or "")[0] for field in found)
    said = label_of(found) or " or ".join(filter(None, meanings))
    unit = unit_of(found)
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
    asked = word.lower().replace("-", "_") if len(word) > 1 else word
    found = ((path, said) for path, words, said in MEANT if asked in words.split() or asked == path.rpartition(".")[2])
    return [Meaning(*path.rpartition(".")[::2], said) for path, said in found]


def kinds(word: str) -> list[str]:
    """Kinds that a word may mean."""
    return [kind for words, kind in KINDS.items() if word.lower().replace("-", "_") in words.split()]
