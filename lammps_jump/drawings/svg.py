# SPDX-License-Identifier: GPL-2.0-or-later
"""SVG drawings: what they draw, in straight lines, arcs of circles and circles; other curves in straight pieces.

Which parts are drawn, where and how large is settled here; the paths themselves are read by svgelements.
"""

from __future__ import annotations

import importlib
import io
import re
from collections.abc import Callable, Iterator, Mapping
from itertools import pairwise
from math import atan2, cos, pi, sin
from typing import Any, NamedTuple
from xml.etree.ElementTree import Element, iterparse

from lammps_jump.errors import CaseError
from lammps_jump.foreign import foreign
from lammps_jump.quoting import echoed, shortened

from .attributes import NUMBER, NUMBERS, Affine, Styles, numbers, style_of, transform, view_box
from .strokes import (
    MOST_KINDS,
    MOST_PARTS,
    GatheredStrokes,
    LayeredDrawing,
    Measure,
    Point,
    arc,
    pieces_of_arc,
    pieces_of_cubic,
    sampled,
)

INCH = 0.0254
"""Metres of an inch (1959)."""
PIXELS = {"mm": 96 / 25.4, "cm": 96 / 2.54, "q": 96 / 101.6, "in": 96.0, "pt": 96 / 72, "pc": 16.0}
"""Pixels of the units of length that a page may have (CSS Values 3, 6.2)."""
SVG = ("", "http://www.w3.org/2000/svg")
LABEL = "{http://www.inkscape.org/namespaces/inkscape}label"
HREFS = ("href", "{http://www.w3.org/1999/xlink}href")
LENGTH = re.compile(rf"\s*({NUMBER})\s*([A-Za-z]*|%)\s*", re.ASCII)
PATH = re.compile(r"\s*(?:[Mm][\sMmZzLlHhVvCcSsQqTtAa\d.,eE+-]*)?", re.ASCII)
ROUND = 1e-6
"""Difference of the two radii of an ellipse over the larger, up to which it is a circle."""
MOST_DEPTH = 150
"""Groups inside groups, those of parts that are used again among them."""
MOST_ELEMENTS = 1_000_000
"""Elements of a file."""
MOST_NUMBERS = 1_000_000
"""Numbers of all paths."""
MOST_LETTERS = 30_000_000
"""Letters of all attributes that are read, those of copies and of rules among them."""
LONGEST_NUMBER = 100
"""Letters of a length."""
STRAIGHT = {"M": 2, "L": 2, "H": 1, "V": 1, "Z": 0}
"""Commands of a path without curves, and how many numbers each takes."""
NO_EXPONENT = re.compile(r"[eE](?![-+\d])")
COMMANDS = re.compile(r"([MmLlHhVvZz])([^MmLlHhVvZz]*)")
GROUPS = {"g", "a", "svg", "switch"}
SHAPES = {"path", "rect", "circle", "ellipse", "line", "polyline", "polygon"}
NOT_DRAWN = {
    "defs", "symbol", "marker", "mask", "clipPath", "pattern", "linearGradient", "radialGradient", "meshgradient",
    "hatch", "style", "script", "metadata", "title", "desc", "filter", "font", "font-face", "view", "cursor",
}  # fmt: skip
"""Elements that draw nothing by themselves."""


def read_svg(data: bytes, file: str, measure: Measure) -> LayeredDrawing:
    """An SVG drawing in pixels, with y upwards from the bottom of its page.

    Raises
    ------
    CaseError
        A page without a size, numbers that are none, parts inside themselves, or more than is read.
    ImportError
        svgelements is not installed.
    """
    path = importlib.import_module("svgelements").Path
    root = _root(data, file)
    page = _Page.of(root)
    reader = _SvgReader(file, path, measure.tolerance_in(page.unit), Styles.of(root, file))
    reader.index(root)
    reader.count_copies(root)
    reader.inside(root, page.view, 0)
    return LayeredDrawing(file, page.unit, page.told, reader.found.layers(), tuple(reader.notes(measure.tolerance)))


def _root(data: bytes, file: str) -> Element:
    """The outermost element; elements and their depth are counted while they are read."""
    depth = count = 0
    root: Element | None = None
    for event, element in iterparse(io.BytesIO(data), ("start", "end")):
        depth += 1 if event == "start" else -1
        count += event == "start"
        root = element if root is None else root
        if depth > MOST_DEPTH or count > MOST_ELEMENTS:
            raise CaseError(
                f"{file}: has more than {MOST_ELEMENTS:,} elements, or they stand more than {MOST_DEPTH} deep; draw "
                "what are walls alone"
            )
    if root is None or _kind(root) != "svg":
        raise CaseError(f"{file}: is no SVG drawing that can be read: it has no <svg>; save it as plain SVG")
    return root


def _kind(element: Element) -> str:
    """The name of an element of SVG; empty of another language."""
    space, _, name = element.tag.lstrip("{").rpartition("}") if isinstance(element.tag, str) else ("other", "", "")
    return name if space in SVG else ""


def length(text: str | None, whole: float, default: float = 0.0) -> float:
    """A length in pixels; `whole` is what a share is of. ValueError where the text is no length."""
    if text is None or text.strip() == "auto":
        return default
    match = LENGTH.fullmatch(text) if len(text) <= LONGEST_NUMBER else None
    unit = match[2].lower() if match else ""
    if match is None or unit not in ("", "px", "%", *PIXELS):
        raise ValueError(f"{echoed(text)} is no length of a drawing")
    return float(match[1]) * (whole / 100 if unit == "%" else PIXELS.get(unit, 1.0))


def _side(text: str | None) -> tuple[float | None, str]:
    """A side of the page in pixels, and its unit; None where it follows from the other one. ValueError for none."""
    if text is None or text.strip() in ("", "auto"):
        return None, ""
    pixels, match = length(text, 0.0), LENGTH.fullmatch(text)
    word = match[2] if match else ""
    return (None if word == "%" else pixels), word


class Viewport(NamedTuple):
    """Inherited state: the map to the page with y upwards, the size that shares are of, the layer, and styles."""

    onto: Affine
    width: float
    height: float
    layer: str = ""
    style: Mapping[str, str] = {}


class _Page(NamedTuple):
    """A page: metres of a pixel (None: nobody says), what tells it, and how it is seen."""

    unit: float | None
    told: str
    view: Viewport

    @classmethod
    def of(cls, root: Element) -> _Page:
        """That of the outermost element.

        A side that is missing, or a share of the window, follows from the other one and the view box.
        """
        box, unit_note, unit = view_box(root.get("viewBox")), "its width is in pixels, which is no length", None
        sides = []
        for name in ("width", "height"):
            side, word = _side(root.get(name))
            sides.append(side)
            if unit is None and word.lower() in PIXELS:
                unit, unit_note = INCH / 96, f"its {name} is in {word}"
            elif unit is None and word == "%":
                unit_note = f"its {name} is in %, which is no length"
        width, height = sides
        if any(side is not None and side <= 0 for side in sides):
            raise ValueError("its page has a side of no length")
        if box is not None:
            if width is None:
                width = box.width if height is None else height * box.width / box.height
            height = width * box.height / box.width if height is None else height
            seen = box.onto(width, height, root.get("preserveAspectRatio", ""))
        else:
            seen = Affine()
        flip = Affine(d=-1.0, f=height or 0.0)
        shares = (box.width, box.height) if box is not None else (width or 0.0, height or 0.0)
        return cls(unit, unit_note, Viewport(flip.after(seen), *shares))


class _SvgReader:
    """Takes what a page draws; the outermost group that has a name is its layer."""

    def __init__(self, file: str, path: Callable[[str], Any], tolerance: float, styles: Styles) -> None:
        self.file, self.path, self.tolerance, self.styles = file, path, tolerance, styles
        self.found, self.ids, self.numbers, self.letters = GatheredStrokes(file), dict[str, Element](), 0, 0
        self.hidden, self.hidden_layers, self.cut = 0, dict[str, None](), 0

    def index(self, root: Element) -> None:
        """Remember the elements that have an id, the first one of each."""
        for element in root.iter():
            self.ids.setdefault(element.get("id", ""), element)

    def count_copies(self, root: Element) -> None:
        """CaseError where parts that are used again, those in them again, are more than is read; before any is drawn.

        Each element is looked at once: a file of a kilobyte may ask for a milliard of copies.
        """
        counts: dict[int, int | None] = {}

        def inside(group: Element, depth: int) -> int:
            total = 0
            for part in self._parts(group):
                if (total := total + of(part, depth)) > MOST_PARTS:
                    self.found.part(MOST_PARTS + 1)
            return total

        def of(part: Element, depth: int) -> int:
            known = counts.get(id(part), 0)
            if known is None or depth > MOST_DEPTH:
                raise self._too_deep()
            if not known:
                counts[id(part)] = None
                counts[id(part)] = known = 1 + below(part, depth + 1)
            return known

        def below(part: Element, depth: int) -> int:
            kind = _kind(part)
            if kind != "use" and kind not in GROUPS:
                return 0
            if style_of({}, self.styles.given(part, kind))["shown"] == "no":
                return 0
            if kind in GROUPS:
                return inside(part, depth)
            target = self._used(part)
            if target is None:
                return 0
            return inside(target, depth) if _kind(target) in ("symbol", "svg") else of(target, depth)

        inside(root, 0)

    def _too_deep(self) -> CaseError:
        return CaseError(f"{self.file}: groups or parts used again stand more than {MOST_DEPTH} deep, or in themselves")

    def notes(self, tolerance: float) -> Iterator[str]:
        """Notes for the user."""
        yield from self.found.notes(tolerance)
        if self.hidden:
            yield f"parts that are hidden, or have neither line nor fill: {self.hidden} left out"
        yield from (f"layer '{name}' is hidden in the drawing: left out" for name in self.hidden_layers)
        if self.cut:
            yield f"parts that a clip-path or a mask cuts: {self.cut} taken whole"
        yield from self.styles.notes()

    def inside(self, group: Element, view: Viewport, depth: int) -> None:
        """Take what a group holds; of a switch the first part that asks for nothing."""
        for part in self._parts(group):
            self.take(part, view, depth)

    def _parts(self, group: Element) -> Iterator[Element]:
        """Parts of a group, of a switch up to the first part that asks for nothing."""
        for part in group:
            yield part
            if _kind(group) == "switch" and _kind(part) and part.get("requiredExtensions") is None:
                break

    def take(self, part: Element, view: Viewport, depth: int) -> None:
        """Take an element, as its parent is seen."""
        kind = _kind(part)
        self.found.part()
        if not kind or kind in NOT_DRAWN:
            return
        if depth > MOST_DEPTH:
            raise self._too_deep()
        given = self._given(part, kind)
        style = style_of(view.style, given)
        name = view.layer or shortened(part.get(LABEL) or part.get("id") or "")
        if style["shown"] == "no" or (kind in SHAPES and style.get("visibility") in ("hidden", "collapse")):
            if kind in GROUPS and name and not view.layer and len(self.hidden_layers) < MOST_KINDS:
                self.hidden_layers[name] = None
            else:
                self.hidden += 1
            return
        self.cut += any(given.get(name, "none") != "none" for name in ("clip-path", "mask"))
        seen = view._replace(onto=view.onto.after(transform(given.get("transform", ""))), layer=name, style=style)
        if kind == "use":
            self._use(part, given, seen, depth)
        elif kind == "svg":
            self.inside(part, self._viewport(part, given, seen), depth + 1)
        elif kind in GROUPS:
            self.inside(part, seen, depth + 1)
        elif kind not in SHAPES:
            self.found.leave(kind.lower())
        elif style.get("fill") == style.get("stroke") == "none":
            self.hidden += 1
        else:
            pen = _Pen(self, seen, name or "drawing")
            getattr(self, f"_{kind}")(given, pen, seen)
            pen.end()

    def _given(self, part: Element, kind: str) -> dict[str, str]:
        """Attributes and styles of an element; CaseError where those of all are too long."""
        given = self.styles.given(part, kind)
        self.letters += sum(map(len, given.values()))
        if self.letters > MOST_LETTERS:
            raise CaseError(
                f"{self.file}: the attributes of its parts have more than {MOST_LETTERS:,} letters, copies counted; "
                "draw what are walls alone"
            )
        return given

    def _used(self, part: Element) -> Element | None:
        """Element that a part uses again; None where it is not in the file."""
        href = next((part.get(name, "") for name in HREFS if part.get(name)), "")
        return self.ids.get(href[1:]) if href.startswith("#") and len(href) > 1 else None

    def _use(self, part: Element, given: Mapping[str, str], view: Viewport, depth: int) -> None:
        """Take what is used again, where it is put."""
        target = self._used(part)
        if target is None:
            self.found.leave("use of what is not in the file")
            return
        x, y = length(given.get("x"), view.width), length(given.get("y"), view.height)
        put = view._replace(onto=view.onto.after(Affine(e=x, f=y)))
        if _kind(target) in ("symbol", "svg"):
            size = {name: given[name] for name in ("width", "height") if name in given}
            own = self._given(target, _kind(target))
            if target.get("display") != "none":
                self.inside(target, self._viewport(target, {**own, "x": "0", "y": "0", **size}, put), depth + 1)
        else:
            self.take(target, put, depth + 1)

    def _viewport(self, part: Element, given: Mapping[str, str], view: Viewport) -> Viewport:
        """A page inside the page."""
        x, y = length(given.get("x"), view.width), length(given.get("y"), view.height)
        width = length(given.get("width"), view.width, view.width)
        height = length(given.get("height"), view.height, view.height)
        put, box = Affine(e=x, f=y), view_box(part.get("viewBox"))
        if box is not None:
            put = put.after(box.onto(width, height, part.get("preserveAspectRatio", "")))
            width, height = box.width, box.height
        return view._replace(onto=view.onto.after(put), width=width, height=height)

    # --- shapes ---------------------------------------------------------------------------------------------------

    def _line(self, given: Mapping[str, str], pen: _Pen, view: Viewport) -> None:
        x0, x1 = (length(given.get(name), view.width) for name in ("x1", "x2"))
        y0, y1 = (length(given.get(name), view.height) for name in ("y1", "y2"))
        pen.move((x0, y0))
        pen.line((x1, y1))

    def _polyline(self, given: Mapping[str, str], pen: _Pen, view: Viewport) -> None:
        values = numbers(given.get("points", ""))
        if len(values) % 2:
            raise CaseError(f"{self.file}: layer '{pen.layer}': a point has no y; draw it anew")
        points = list(zip(values[::2], values[1::2], strict=True))
        for point in points[:1]:
            pen.move(point)
        for point in points[1:]:
            pen.line(point)

    def _polygon(self, given: Mapping[str, str], pen: _Pen, view: Viewport) -> None:
        self._polyline(given, pen, view)
        pen.close()

    def _rect(self, given: Mapping[str, str], pen: _Pen, view: Viewport) -> None:
        x, width = (length(given.get(name), view.width) for name in ("x", "width"))
        y, height = (length(given.get(name), view.height) for name in ("y", "height"))
        rx = length(given.get("rx"), view.width, -1.0)
        ry = length(given.get("ry"), view.height, -1.0)
        rx, ry = rx if rx >= 0 else max(ry, 0.0), ry if ry >= 0 else max(rx, 0.0)
        rx, ry = min(rx, 0.5 * width), min(ry, 0.5 * height)
        if not (width > 0 and height > 0):
            self.found.leave("rect without area")
            return
        right, low = x + width, y + height
        if not (rx > 0 and ry > 0):
            pen.move((x, y))
            for point in ((right, y), (right, low), (x, low)):
                pen.line(point)
            pen.close()
            return
        pen.move((x + rx, y))
        corners = ((right - rx, y + ry), (right - rx, low - ry), (x + rx, low - ry), (x + rx, y + ry))
        for number, centre in enumerate(corners):
            turned = _Arc(centre, (rx, ry), 0.0, (number - 1) * 0.5 * pi, 0.5 * pi)
            pen.line(turned.at(0.0))
            pen.arc(turned)
        pen.close()

    def _circle(self, given: Mapping[str, str], pen: _Pen, view: Viewport) -> None:
        share = ((view.width**2 + view.height**2) / 2) ** 0.5
        radius = length(given.get("r"), share)
        self._round(given, pen, view, (radius, radius))

    def _ellipse(self, given: Mapping[str, str], pen: _Pen, view: Viewport) -> None:
        rx = length(given.get("rx"), view.width, -1.0)
        ry = length(given.get("ry"), view.height, -1.0)
        self._round(given, pen, view, (rx if rx >= 0 else ry, ry if ry >= 0 else rx))

    def _round(self, given: Mapping[str, str], pen: _Pen, view: Viewport, radii: tuple[float, float]) -> None:
        """A circle whole, where it stays one; else an ellipse."""
        centre = length(given.get("cx"), view.width), length(given.get("cy"), view.height)
        if not min(radii) > 0:
            self.found.leave("circle or ellipse without area")
            return
        whole = _Arc(centre, radii, 0.0, 0.0, 2 * pi)
        if radius := pen.radius(whole):
            self.found.ring(pen.layer, view.onto(*centre), radius)
            return
        pen.move(whole.at(0.0))
        pen.arc(whole)
        pen.close()

    def _path(self, given: Mapping[str, str], pen: _Pen, view: Viewport) -> None:
        text = given.get("d", "")
        self.numbers += sum(1 for _ in NUMBERS.finditer(text))
        if self.numbers > MOST_NUMBERS:
            raise CaseError(
                f"{self.file}: its paths have more than {MOST_NUMBERS:,} numbers; draw what are walls alone"
            )
        with foreign(CaseError, f"{self.file}: layer '{pen.layer}': {echoed(text[:60])} is no path", "draw it anew"):
            if not PATH.fullmatch(text) or NO_EXPONENT.search(text):
                raise ValueError("a path begins with M, and has commands and numbers")
            letters = {letter.upper() for letter in set(text) if letter.isalpha()}
            if letters <= {*STRAIGHT, "E"}:
                _straight(text, pen)
            else:
                for part in self.path(text):
                    self._segment(part, pen)

    def _segment(self, part: Any, pen: _Pen) -> None:
        """Add a part of a path."""
        kind, end = type(part).__name__, part.end
        if kind == "Move":
            pen.move((float(end.x), float(end.y)))
            return
        pen.begin((float(part.start.x), float(part.start.y)))
        if kind == "Close":
            pen.close()
        elif kind == "Arc" and part.rx and part.ry:
            radii = float(part.rx), float(part.ry)
            turned = float(part.get_rotation())
            pen.arc(
                _Arc((part.center.x, part.center.y), radii, turned, float(part.get_start_t()), float(part.sweep)),
                (float(end.x), float(end.y)),
            )
        elif kind in ("QuadraticBezier", "CubicBezier"):
            bend = (part.control,) if kind == "QuadraticBezier" else (part.control1, part.control2)
            pen.curve([(float(p.x), float(p.y)) for p in (part.start, *bend, end)])
        else:
            pen.line((float(end.x), float(end.y)))


class _Arc(NamedTuple):
    """An arc of an ellipse: centre, radii, turn of its axes, begin and sweep as parameters of the ellipse, rad."""

    centre: Point
    radii: tuple[float, float]
    turned: float
    begin: float
    sweep: float

    def at(self, way: float) -> Point:
        """A point of it, from 0 at its begin to 1 at its end."""
        angle, (rx, ry) = self.begin + way * self.sweep, self.radii
        x, y, c, s = rx * cos(angle), ry * sin(angle), cos(self.turned), sin(self.turned)
        return self.centre[0] + c * x - s * y, self.centre[1] + s * x + c * y


class _Pen:
    """Draws the lines of one shape, in its own coordinates, onto the page."""

    def __init__(self, reader: _SvgReader, view: Viewport, layer: str) -> None:
        self.reader, self.onto, self.layer = reader, view.onto, layer
        self.points: list[Point] = []
        self.bends: list[float] = []
        self.first: Point | None = None

    def move(self, point: Point) -> None:
        """Begin a line."""
        self.end()
        self.first = point
        self.points = [self.onto(*point)]

    def begin(self, point: Point) -> None:
        """Goes on from a point, where no line has begun: after one that was closed."""
        if not self.points:
            self.move(point)

    def line(self, point: Point) -> None:
        """Go straight on."""
        self._to(self.onto(*point), 0.0)

    def close(self) -> None:
        """Go back to the begin, and end."""
        if self.first is not None and len(self.points) > 1:
            self._to(self.onto(*self.first), 0.0)
        self.end()

    def end(self) -> None:
        """Hand on what was drawn."""
        if len(self.points) > 1:
            self.reader.found.stroke(self.layer, self.points, self.bends)
        self.points, self.bends = [], []

    def radius(self, part: _Arc) -> float:
        """Radius of the circle that an arc is of on the page; 0 of an ellipse."""
        (rx, ry), (most, least) = part.radii, self.onto.stretches
        same = abs(rx - ry) <= ROUND * max(rx, ry) and most - least <= ROUND * most
        return rx * most if same else 0.0

    def arc(self, part: _Arc, end: Point | None = None) -> None:
        """Go along an arc, exactly to its end where that is given."""
        last = self.onto(*(part.at(1.0) if end is None else end))
        if radius := self.radius(part):
            (x, y), (cx, cy) = self.onto(*part.at(0.0)), self.onto(*part.centre)
            whole = arc((cx, cy), radius, atan2(y - cy, x - cx), -part.sweep if self.onto.turns_over else part.sweep)
            for point, bend in zip((*whole.points[1:-1], last), whole.bends, strict=True):
                self._to(point, bend)
            return
        self.reader.found.flatten("arc of an ellipse")
        longest = max(part.radii) * self.onto.stretches[0]
        count = self.reader.found.pieces(pieces_of_arc(longest, part.sweep, self.reader.tolerance))
        for point in (*sampled(lambda way: self.onto(*part.at(way)), count)[1:-1], last):
            self._to(point, 0.0)

    def curve(self, corners: list[Point]) -> None:
        """Go along a Bézier curve."""
        self.reader.found.flatten("Bézier curve")
        mapped = [self.onto(*corner) for corner in corners]
        count = self.reader.found.pieces(pieces_of_cubic(mapped, self.reader.tolerance))
        for point in (*sampled(lambda way: _bezier(mapped, way), count)[1:-1], mapped[-1]):
            self._to(point, 0.0)

    def _to(self, point: Point, bend: float) -> None:
        """Add a point that is another one than the last."""
        if point != self.points[-1]:
            self.points.append(point)
            self.bends.append(bend)


def _straight(text: str, pen: _Pen) -> None:
    """Draw a path of straight lines: a survey of many points takes a fifth of the time that svgelements takes."""
    here = start = (0.0, 0.0)
    for letter, given in COMMANDS.findall(text):
        values, takes = [float(value) for value in NUMBERS.findall(given)], STRAIGHT[letter.upper()]
        if len(values) % takes if takes else values:
            raise ValueError(f"{letter} has {len(values)} numbers")
        if not takes:
            pen.begin(here)
            pen.close()
            here = start
            continue
        if not values:
            raise ValueError(f"{letter} has no numbers")
        pen.reader.found.room(len(values) // takes)
        for first in range(0, len(values), takes):
            x, y = here if letter.islower() else (0.0, 0.0)
            if letter in "hH":
                here = x + values[first], here[1]
            elif letter in "vV":
                here = here[0], y + values[first]
            else:
                here = x + values[first], y + values[first + 1]
            if letter in "mM" and not first:
                start = here
                pen.move(here)
            else:
                pen.begin(start)
                pen.line(here)


def _bezier(corners: list[Point], way: float) -> Point:
    """A point of a Bézier curve, by de Casteljau's construction."""
    while len(corners) > 1:
        corners = [(a[0] + way * (b[0] - a[0]), a[1] + way * (b[1] - a[1])) for a, b in pairwise(corners)]
    return corners[0]
