# SPDX-License-Identifier: GPL-2.0-or-later
"""Walls of a drawing: strokes that meet are joined, each outline is an entry of a case, which is put into its text.

Crossings of walls.
"""

from __future__ import annotations

import re
import textwrap
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import islice
from math import hypot, sqrt
from typing import Any

import numpy as np
import yaml
from scipy.spatial import cKDTree

from lammps_jump.case.doubts import is_written
from lammps_jump.case.text import parse_source
from lammps_jump.errors import CaseError
from lammps_jump.quoting import LONGEST_NAME, shortened, visible
from lammps_jump.scene.chains import Chain, Face, faces_of_chain
from lammps_jump.scene.shapes import ArcTo, PlaceError, common, flush, over_each_other
from lammps_jump.scene.tracks import MOST_ROWS
from lammps_jump.scene.walls import Circle, Line, Polygon

from .strokes import FileStroke, Layer, LayeredDrawing, Point

SAME = 1e-6
"""Distance over the size of a drawing up to which two ends are one."""
NEARLY = 0.01
"""Distance over the size of a drawing up to which two ends nearly meet."""
LINES_APART = 3
"""Single straight lines of a layer from which on it looks like dimensions or axes."""
DIGITS = 9
"""Digits of the numbers that are written."""
ROUND = 1e-14
"""Round-off of a coordinate over the size of a drawing."""
MOST_WALLS = 1000
"""Walls of a drawing; a case of more takes minutes to check."""
MOST_LOOKED = 200_000
"""Pieces of walls side by side that are looked through for such as lie flush: seconds."""
MOST_TOLD = 20
"""Sentences of one kind on what is doubtful."""


@dataclass(frozen=True)
class LayerChoice:
    """Choices of the user on layers.

    Attributes
    ----------
    names : mapping of str to str
        Layers to take, with the names of their walls; empty: all.
    reverse : collection of str
        Layers whose open lines run the other way, so that the discs are on the other side.
    inside : collection of str
        Layers whose closed outlines hold the discs inside.
    sheet : collection of str
        Layers whose open lines the discs feel from both sides.
    """

    names: Mapping[str, str] = field(default_factory=dict)
    reverse: Sequence[str] = ()
    inside: Sequence[str] = ()
    sheet: Sequence[str] = ()


@dataclass(frozen=True)
class Entry:
    """A wall of a case.

    Attributes
    ----------
    wall : dict
        Fields of the entry.
    layer : str
    facts : tuple of str
        Extent, points and arcs, whether it is closed, and on which side the discs are.
    doubts : tuple of str
        What may be wrong with it alone.
    chosen : bool
        Whether the user has named its layer.
    """

    wall: dict[str, Any]
    layer: str
    facts: tuple[str, ...]
    doubts: tuple[str, ...] = ()
    chosen: bool = False


def entries(drawing: LayeredDrawing, choice: LayerChoice | None = None) -> list[Entry]:
    """The walls of a drawing in metres, a layer each; a layer of several outlines gives name_1, name_2, ...

    Raises
    ------
    CaseError
        A layer that is not there, names that a wall cannot have or that two walls would have.
    """
    choice = choice or LayerChoice()
    known = [layer.name for layer in drawing.layers]
    for name in (*choice.names, *choice.reverse, *choice.inside, *choice.sheet):
        if name not in known:
            there = shortened(", ".join(map(repr, known)))
            raise CaseError(f"{drawing.file}: there is no layer '{shortened(name)}'; it has {there}")
    size = max(*drawing.extent(), 1e-300)
    joined = [
        (layer, *_joined(layer.strokes, SAME * size))
        for layer in drawing.layers if not choice.names or layer.name in choice.names
    ]  # fmt: skip
    count = sum(len(outlines) + len(layer.rings) for layer, outlines, _ in joined)
    if count > MOST_WALLS:
        raise CaseError(
            f"{drawing.file}: has {count:,} lines and circles that do not meet; at most {MOST_WALLS:,} become walls: "
            "join them in the drawing, or take the layers of walls alone (--layer)"
        )
    parts = (_of_layer(layer, choice, outlines, turned, size) for layer, outlines, turned in joined)
    entries = [replace(entry, chosen=bool(choice.names)) for part in parts for entry in part]
    names = [entry.wall["name"] for entry in entries]
    if twice := [name for name, count in Counter(names).items() if count > 1]:
        raise CaseError(f"{drawing.file}: two walls would be called '{twice[0]}'; name them by --layer LAYER=WALL")
    return entries


def _of_layer(
    layer: Layer, choice: LayerChoice, outlines: Sequence[FileStroke], turned: int, size: float
) -> list[Entry]:
    """Entries of one layer of a drawing of this size (m), whose strokes are joined to outlines, some turned round."""
    given = choice.names.get(layer.name)
    name = given or wall_name(layer.name)
    if not re.fullmatch(r"[A-Za-z0-9_]+", name) or len(name) > LONGEST_NAME:
        raise CaseError(
            f"--layer {layer.name}={name}: is no name of a wall; allowed are letters, digits and _, up to "
            f"{LONGEST_NAME} of them"
        )
    count = len(outlines) + len(layer.rings)
    entries = []
    for number, outline in enumerate(outlines, 1):
        own = name if count == 1 else f"{name}_{number}"
        entries.append(_outline(outline, own, (layer.name, size), choice, turned))
    for number, ring in enumerate(layer.rings, len(outlines) + 1):
        own = name if count == 1 else f"{name}_{number}"
        where = "inside" if layer.name in choice.inside else "outside"
        wall = {"name": own, "kind": "circle", "centre": _rounded(ring.centre, size), "radius": _digits(ring.radius)}
        facts = (f"circle of radius {ring.radius:z.4g} m about {_place(ring.centre)}", f"discs {where}")
        entries.append(Entry(wall | ({"discs": where} if where == "inside" else {}), layer.name, facts))
    return entries


def wall_name(layer: str) -> str:
    """A layer's name with the letters that a wall's may have; one that YAML reads as no text gets a word in front."""
    name = re.sub(r"[^A-Za-z0-9_]+", "_", layer).strip("_")[:LONGEST_NAME] or "wall"
    return name if name[0].isalpha() and _is_text(name) else f"layer_{name}"[:LONGEST_NAME]


def _is_text(word: str) -> bool:
    """Tells whether YAML reads a word as a text, and not as a number, true or null."""
    return isinstance(yaml.safe_load(word), str) and isinstance(parse_source(f"a: {word}").data["a"], str)


def _partners(strokes: Sequence[FileStroke], same: float) -> dict[int, int]:
    """The one end that meets each end, by numbers: two of each stroke, -1 where several meet; none where none does."""
    points = np.array([point for stroke in strokes for point in (stroke.points[0], stroke.points[-1])])
    places, which, counts = np.unique(points, axis=0, return_inverse=True, return_counts=True)
    near = cKDTree(places).query(places, k=min(3, len(places)), distance_upper_bound=same)[1].reshape(len(places), -1)
    others = np.where(near == np.arange(len(places))[:, None], len(places), near)  # a place is not its own neighbour
    around = np.append(counts, 0)[others].sum(axis=1) + counts  # ends that meet there, itself among them
    ends: dict[int, list[int]] = {}
    for end, place in enumerate(which.ravel().tolist()):
        ends.setdefault(place, []).append(end)
    partner: dict[int, int] = {}
    for place, here in ends.items():
        if around[place] == 2:
            there = others[place].min()
            two = here if len(here) == 2 else [*here, *ends[int(there)]]
            if len(here) == 2 or around[there] == 2:
                partner |= {two[0]: two[1], two[1]: two[0]}
        elif around[place] > 2:
            partner |= dict.fromkeys(here, -1)
    return partner


def _joined(strokes: Sequence[FileStroke], same: float) -> tuple[list[FileStroke], int]:
    """Strokes put together where two ends meet, and how many were turned round for it.

    Where three ends or more meet nothing is joined there.
    """
    if not strokes:
        return [], 0
    partner = _partners(strokes, same)
    used, file_strokes, turned = set[int](), [], 0
    first_ends = [number for number in range(len(strokes)) if partner.get(2 * number, -1) < 0]
    open_first = set(first_ends)
    last_ends = [
        number for number in range(len(strokes))
        if number not in open_first and partner.get(2 * number + 1, -1) < 0
    ]  # fmt: skip
    open_last = set(last_ends)
    for number in (*first_ends, *last_ends, *range(len(strokes))):
        if number in used:
            continue
        here = 2 * number + 1 if number in open_last else 2 * number
        chain: list[tuple[int, bool]] = []
        while here >= 0 and here // 2 not in used:
            used.add(here // 2)
            chain.append((here // 2, here % 2 == 1))
            here = partner.get(here ^ 1, -1)
        first = min(chain)  # the stroke that was drawn first says which way the outline runs
        if first[1]:
            chain = [(stroke, not back) for stroke, back in reversed(chain)]
        turned += sum(back for _, back in chain)
        parts = [_turned(strokes[stroke]) if back else strokes[stroke] for stroke, back in chain]
        file_strokes.append((first[0], _linked(parts)))
    return [stroke for _, stroke in sorted(file_strokes, key=lambda item: item[0])], turned


def _turned(stroke: FileStroke) -> FileStroke:
    return FileStroke(stroke.points[::-1], tuple(0.0 - bend for bend in stroke.bends[::-1]))


def _linked(strokes: Sequence[FileStroke]) -> FileStroke:
    """Strokes one after the other as one."""
    points = [strokes[0].points[0], *(point for stroke in strokes for point in stroke.points[1:])]
    return FileStroke(tuple(points), tuple(bend for stroke in strokes for bend in stroke.bends))


def _outline(stroke: FileStroke, name: str, of: tuple[str, float], choice: LayerChoice, turned: int) -> Entry:
    """The entry of a line or of a closed outline, of this layer and of a drawing of this size (m)."""
    layer, whole = of
    points, bends = _distinct(stroke)
    size = float(np.ptp(np.array(points), axis=0).max())
    closed = len(points) > 2 and hypot(*np.subtract(points[0], points[-1])) <= SAME * size
    (x0, y0), (x1, y1) = np.min(points, axis=0), np.max(points, axis=0)
    facts = [f"x {x0:z.4g} to {x1:z.4g} m, y {y0:z.4g} to {y1:z.4g} m"]
    wall: dict[str, Any] = {"name": name, "kind": "polygon" if closed else "line"}
    if not closed and layer in choice.reverse:
        points, bends = _turned(FileStroke(points, bends))
    kept = points[:-1] if closed and not bends[-1] else points
    arcs = sum(bend != 0 for bend in bends)
    facts.append(f"{len(points) - closed} points, {arcs} {'arc' if arcs == 1 else 'arcs'}")
    rows: list[Any] = [_rounded(points[0], whole)]
    for point, bend in zip(kept[1:], bends, strict=False):
        place = _rounded(point, whole)
        rows.append({"arc_to": place, "radius": _digits(bend)} if bend else place)
    wall["points"] = rows
    if closed:
        where = "inside" if layer in choice.inside else "outside"
        facts.append(f"closed, discs {where}")
        wall |= {"discs": "inside"} if where == "inside" else {}
    elif layer in choice.sheet:
        facts.append("open, discs on both sides")
        wall["sheet"] = True
    else:
        facts.append(f"open, discs on its left: {_side(points[0], points[-1])}")
    if turned:
        facts.append(f"pieces of the layer that are turned round to join the one drawn first: {turned}")
    return Entry(wall, layer, tuple(facts), tuple(_alone(wall)))


def _alone(wall: dict[str, Any]) -> list[str]:
    """Reason for which a wall of this shape is refused."""
    if len(wall.get("points", ())) > MOST_ROWS:
        return [
            f"{wall['name']}: {len(wall['points']):,} points; a wall of a case has at most {MOST_ROWS:,}: draw it with "
            "fewer, or in several layers"
        ]
    try:
        _wall(wall)
    except PlaceError as error:
        return [f"{wall['name']}: {error}"]
    return []


def _wall(wall: Mapping[str, Any]) -> Circle | Line | Polygon:
    """The wall of an entry."""
    if wall["kind"] == "circle":
        return Circle(wall["name"], tuple(wall["centre"]), wall["radius"], discs=wall.get("discs", "outside"))
    points = tuple(ArcTo(tuple(p["arc_to"]), p["radius"]) if isinstance(p, dict) else tuple(p) for p in wall["points"])
    if wall["kind"] == "line":
        return Line(wall["name"], points, sheet=wall.get("sheet", False))
    return Polygon(wall["name"], points, discs=wall.get("discs", "outside"))


def _side(start: Point, end: Point) -> str:
    """In words, what lies on the left of a way."""
    dx, dy = end[0] - start[0], end[1] - start[1]
    level = abs(dx) >= abs(dy)
    where = ("above it" if dx > 0 else "below it") if level else ("at smaller x" if dy > 0 else "at larger x")
    return f"{where}, as it runs from {_place(start)} to {_place(end)}"


def _place(point: Point) -> str:
    return f"({point[0]:z.4g}, {point[1]:z.4g}) m"


def _distinct(stroke: FileStroke) -> FileStroke:
    """A stroke without points that repeat the one before."""
    size = float(np.ptp(np.array(stroke.points), axis=0).max())
    points, bends = [stroke.points[0]], []
    for point, bend in zip(stroke.points[1:], stroke.bends, strict=True):
        if hypot(*np.subtract(point, points[-1])) > SAME * size:
            points.append(point)
            bends.append(bend)
    return FileStroke(tuple(points), tuple(bends))


def _digits(value: float) -> float:
    return float(f"{value:z.{DIGITS}g}")


def _rounded(point: Point, size: float) -> list[float]:
    """A point with its digits; what is 0 but for round-off in a drawing of this size (m) is 0."""
    return [0.0 if abs(value) <= ROUND * size else _digits(value) for value in point]


def doubts(entries: Sequence[Entry], size: float) -> list[str]:
    """Sentences on walls together: shapes that are refused, ends that nearly meet, walls that cross or lie flush.

    The first of each; and layers that look like what is written on a drawing.

    Parameters
    ----------
    entries : sequence of Entry
    size : float
        Of the drawing, m.
    """
    whole = [entry for entry in entries if not entry.doubts]
    walls = [entry.wall for entry in whole]
    made, crossed = [_wall(wall) for wall in walls], set[tuple[int, int]]()

    def told_of_crossings() -> Iterator[str]:
        for one, two, at in crossings([wall.chains() for wall in made], SAME * size):
            crossed.add((one, two))
            yield f"{made[one].name} and {made[two].name} cross at {_place(at)}"

    try:
        last = _some(told_of_crossings())
    except TooManyFaces as error:
        last = [f"not looked through for walls that cross: {error}"]
    sentences = [*_some(text for entry in entries for text in entry.doubts), *_some(_near_ends(walls, size)), *last]
    return [*sentences, *_some(_flush(made, crossed, SAME * size)), *_some(_written(entries))]


def _flush(
    walls: Sequence[Circle | Line | Polygon], crossed: Collection[tuple[int, int]], near: float
) -> Iterator[str]:
    """Sentences on walls that go on as one, or that lie on each other, but for those that cross."""
    (x0, x1), (y0, y1) = np.moveaxis(np.array([wall.extent for wall in walls]).reshape(-1, 2, 2), 0, 2)
    is_close = (x0 <= x1[:, None] + near) & (y0 <= y1[:, None] + near)
    looked = 0
    for one, two in np.argwhere(np.triu(is_close & is_close.T, 1)).tolist():
        if (one, two) in crossed:
            continue
        looked += len(walls[one].faces.codes) + len(walls[two].faces.codes)
        if looked > MOST_LOOKED:
            yield f"not all looked through for walls that lie flush: more than {MOST_LOOKED:,} pieces lie side by side"
            return
        faces = walls[one].faces, walls[two].faces
        if at := flush(*faces) or over_each_other(*faces):
            yield (
                f"{walls[one].name} and {walls[two].name} meet flush at {_place(at)}: a disc there feels both, up to "
                "twice the force; draw them as one outline in one layer, or give lines the same join in the case"
            )


def _some(texts: Iterable[str]) -> list[str]:
    """The first sentences, and that there are more."""
    some = list(islice(texts, MOST_TOLD + 1))
    return some if len(some) <= MOST_TOLD else [*some[:MOST_TOLD], "and more of this kind"]


def _near_ends(walls: Sequence[Mapping[str, Any]], size: float) -> Iterator[str]:
    """Sentences on ends of lines that nearly meet."""
    ends = [(wall["name"], point) for wall in walls if wall["kind"] == "line" for point in _ends(wall)]
    if not ends:
        return
    tree = cKDTree([point for _, point in ends])
    for number, (one, a) in enumerate(ends):
        for other in sorted(tree.query_ball_point(a, NEARLY * size)):
            two, b = ends[other]
            gap = hypot(a[0] - b[0], a[1] - b[1])
            if other > number and gap > SAME * size:
                what = f"ends of {one} and {two} nearly meet" if one != two else f"{one} is nearly closed"
                yield f"{what}: its gap at {_place(a)} is {gap:z.3g} m"


def _written(entries: Sequence[Entry]) -> list[str]:
    """Sentences on layers that nobody has chosen and that look like dimensions, texts or axes.

    By their names, or because most of a layer are separate single straight lines.
    """
    sentences = []
    for layer in dict.fromkeys(entry.layer for entry in entries if not entry.chosen):
        walls = [entry.wall for entry in entries if entry.layer == layer]
        bare = [wall for wall in walls if wall["kind"] == "line" and len(wall["points"]) == 2 and "sheet" not in wall]
        apart = len(bare) >= LINES_APART and 2 * len(bare) > len(walls)
        if is_written(layer) or apart:
            look = "is named like" if is_written(layer) else f"holds {len(bare)} single lines apart, as do"
            names = ", ".join(wall["name"] for wall in walls[:3]) + (", ..." if len(walls) > 3 else "")
            sentences.append(
                f"layer '{shortened(visible(layer))}' {look} dimensions, texts or axes, and became {names}: if it is "
                "no wall, name the layers that are, --layer LAYER=WALL"
            )
    return sentences


def _ends(wall: Mapping[str, Any]) -> tuple[Point, Point]:
    """Both ends of an open line."""
    first, last = wall["points"][0], wall["points"][-1]
    return tuple(first), tuple(last["arc_to"] if isinstance(last, dict) else last)


def yaml_text(entries: Sequence[Entry], indent: str = "  ") -> str:
    """Entries as items of the list ``walls`` of a case, each after a comment that says what it is."""
    rows = []
    for entry in entries:
        rows.append(f"{indent}# {entry.wall['name']}, layer '{visible(entry.layer)}': {'; '.join(entry.facts)}")
        parts = [f"{key}: {flow(value)}" for key, value in entry.wall.items()]
        rows.append(f"{indent}- {{{', '.join(parts)}}}" if sum(map(len, parts)) < 100 else _long(parts, indent))
    return "\n".join(rows) + "\n"


def _long(parts: Sequence[str], indent: str) -> str:
    """An entry with its fields one below the other."""
    rows = [textwrap.fill(part, 110, subsequent_indent=f"{indent}    ", break_on_hyphens=False) for part in parts]
    return f"{indent}- " + f"\n{indent}  ".join(rows)


def flow(value: Any) -> str:
    """A value in YAML's flow style."""
    if isinstance(value, list):
        return f"[{', '.join(map(flow, value))}]"
    if isinstance(value, dict):
        return f"{{{', '.join(f'{key}: {flow(one)}' for key, one in value.items())}}}"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return value if _is_text(value) else f"'{value}'"
    return f"{value:z.{DIGITS}g}"


MOST_COMPARED = 20_000_000
"""Pairs of faces, next to each other along one axis, that are looked through."""
MOST_CLOSE = 300_000
"""Pairs of faces whose boxes meet, that are held against each other."""


class TooManyFaces(ValueError):
    """Too many faces lie next to each other."""


def crossings(walls: Sequence[Sequence[Chain]], near: float) -> Iterator[tuple[int, int, Point]]:
    """Numbers of two walls that cross, and a place, m; each two once, in their order.

    Ends and corners of both that lie on each other are no crossing.

    Raises
    ------
    TooManyFaces
        More pairs of faces than can be looked at in seconds.
    """
    if len(walls) < 2:
        return
    faces = [(wall, face) for wall, chains in enumerate(walls) for chain in chains for face in faces_of_chain(chain)]
    crossed: dict[tuple[int, int], Point] = {}
    for i, j in _close(faces, near):
        (one, a), (two, b) = faces[i], faces[j]
        if (one, two) not in crossed and (crossing := _cross(a, b, near)):
            crossed[one, two] = crossing
    yield from ((one, two, crossed[one, two]) for one, two in sorted(crossed))


def _cross(a: Face, b: Face, near: float) -> Point | None:
    """A place where two faces cross, m."""
    for point in common(a, b, near):
        if not (_at(point, a.start, a.end, near) and _at(point, b.start, b.end, near)):
            return point
    return None


def _close(faces: Sequence[tuple[int, Face]], near: float) -> Iterator[tuple[int, int]]:
    """Pairs of faces of different walls whose boxes meet, by their numbers, that of the earlier wall first."""
    wall = np.array([number for number, _ in faces])
    box = np.array([_box(face) for _, face in faces])
    box[:, [0, 2]] -= near
    box[:, [1, 3]] += near
    orders = []
    for low in (0, 2):  # along x and along y: that in which fewer lie next to each other
        order = np.argsort(box[:, low], kind="stable")
        ends = np.searchsorted(box[order, low], box[order, low + 1], side="right")
        orders.append((int((ends - np.arange(len(order)) - 1).sum()), low, order, ends))
    pair_count, low, order, ends = min(orders, key=lambda item: item[0])
    if pair_count > MOST_COMPARED:
        raise TooManyFaces(f"{pair_count:,} pairs of faces lie beside each other")
    other, count = 2 - low, 0
    for rank, i in enumerate(order):
        later = order[rank + 1 : ends[rank]]
        meet = (box[later, other] <= box[i, other + 1]) & (box[later, other + 1] >= box[i, other])
        others = later[meet & (wall[later] != wall[i])]
        count += len(others)
        if count > MOST_CLOSE:
            raise TooManyFaces(f"more than {MOST_CLOSE:,} pairs of faces lie close to each other")
        for j in others.tolist():
            yield (int(i), j) if wall[i] < wall[j] else (j, int(i))


def _box(face: Face) -> tuple[float, float, float, float]:
    """A box around a face, m: of an arc that of its chord, wider by its sagitta."""
    (x0, y0), (x1, y1) = face.start, face.end
    half, radius = 0.5 * hypot(x1 - x0, y1 - y0), abs(face.radius)
    wider = radius - sqrt(max(radius * radius - half * half, 0.0)) if radius else 0.0
    return min(x0, x1) - wider, max(x0, x1) + wider, min(y0, y1) - wider, max(y0, y1) + wider


def _at(point: Point, start: Point, end: Point, near: float) -> bool:
    """Tells whether a point is one of two ends."""
    return any(hypot(point[0] - x, point[1] - y) <= 1e3 * near for x, y in (start, end))
