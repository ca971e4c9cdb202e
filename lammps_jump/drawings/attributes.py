# SPDX-License-Identifier: GPL-2.0-or-later
"""Attributes of SVG: transforms and view boxes as affine maps of the plane, and styles.

Styles are read as far as they say what is drawn and where: attributes, ``style``, and rules of style sheets.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from math import cos, hypot, isfinite, radians, sin, tan
from typing import NamedTuple
from xml.etree.ElementTree import Element

from lammps_jump.errors import CaseError
from lammps_jump.quoting import shortened

from .strokes import Point

NUMBER = r"[-+]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][-+]?\d+)?"
NUMBERS = re.compile(NUMBER, re.ASCII)
SINGLE = re.compile(r"\s*([A-Za-z]+)\s*\(([^()]*)\)[\s,]*")
TWO_COMMAS = re.compile(r",\s*,")
ASPECT = re.compile(r"\s*(?:none|x(Min|Mid|Max)Y(Min|Mid|Max)(?:\s+(meet|slice))?)\s*")
SHARES = {"Min": 0.0, "Mid": 0.5, "Max": 1.0}


class Affine(NamedTuple):
    """(x, y) becomes (a x + c y + e, b x + d y + f)."""

    a: float = 1.0
    b: float = 0.0
    c: float = 0.0
    d: float = 1.0
    e: float = 0.0
    f: float = 0.0

    def __call__(self, x: float, y: float) -> Point:
        """Place to which a point is mapped."""
        return self.a * x + self.c * y + self.e, self.b * x + self.d * y + self.f

    def after(self, first: Affine) -> Affine:
        """The map that does `first` before this one."""
        a, b, c, d, e, f = first
        return Affine(
            self.a * a + self.c * b, self.b * a + self.d * b, self.a * c + self.c * d, self.b * c + self.d * d,
            *self(e, f),
        )  # fmt: skip

    @property
    def turns_over(self) -> bool:
        """Tells whether it makes a turn to the left one to the right."""
        return self.a * self.d - self.b * self.c < 0.0

    @property
    def stretches(self) -> tuple[float, float]:
        """Largest and smallest of its stretches, the singular values."""
        plus, minus = hypot(self.a + self.d, self.b - self.c), hypot(self.a - self.d, self.b + self.c)
        return 0.5 * (plus + minus), 0.5 * abs(plus - minus)


def numbers(text: str) -> list[float]:
    """Numbers between blanks or commas; ValueError where there is something else."""
    if NUMBERS.sub(" ", text).strip(" ,\t\r\n") or TWO_COMMAS.search(text):
        raise ValueError(f"{text[:60]!r} are no numbers")
    return [float(value) for value in NUMBERS.findall(text)]


def transform(text: str) -> Affine:
    """The map of an attribute ``transform``; ValueError where its text is no map."""
    affine, place, text = Affine(), 0, text.rstrip()
    while place < len(text):
        single = SINGLE.match(text, place)
        values = numbers(re.sub(r"(?<=[\d.])(?:px|deg)\b", "", single[2])) if single else []
        counts, make = TRANSFORMS.get(single[1] if single else "", ((), None))
        if single is None or make is None or len(values) not in counts:
            raise ValueError(f"transform {text[place : place + 60]!r} is none")
        affine = affine.after(make(values))
        place = single.end()
    if not all(map(isfinite, affine)):
        raise ValueError(f"transform {text[:60]!r} is beyond all numbers")
    return affine


def _rotation(values: Sequence[float]) -> Affine:
    c, s = cos(radians(values[0])), sin(radians(values[0]))
    x, y = values[1:] or (0.0, 0.0)
    return Affine(c, s, -s, c, x - c * x + s * y, y - s * x - c * y)


TRANSFORMS: dict[str, tuple[tuple[int, ...], Callable[[Sequence[float]], Affine] | None]] = {
    "matrix": ((6,), lambda v: Affine(*v)),
    "translate": ((1, 2), lambda v: Affine(e=v[0], f=(*v, 0.0)[1])),
    "scale": ((1, 2), lambda v: Affine(a=v[0], d=v[-1])),
    "rotate": ((1, 3), _rotation),
    "skewX": ((1,), lambda v: Affine(c=tan(radians(v[0])))),
    "skewY": ((1,), lambda v: Affine(b=tan(radians(v[0])))),
}
"""Counts of the numbers that each has, and what they mean (SVG 1.1, 7.6)."""


class ViewBox(NamedTuple):
    """The part of the plane that a page shows."""

    x: float
    y: float
    width: float
    height: float

    def onto(self, width: float, height: float, aspect: str) -> Affine:
        """The map onto a page of this size, by ``preserveAspectRatio`` (SVG 1.1, 7.8); ValueError for other text."""
        match = ASPECT.fullmatch(aspect or "xMidYMid")
        if match is None:
            raise ValueError(f"preserveAspectRatio {aspect[:60]!r} is none")
        sx, sy = width / self.width, height / self.height
        if match[1]:
            sx = sy = (max if match[3] == "slice" else min)(sx, sy)
        across, up = (SHARES.get(part or "Min", 0.0) for part in (match[1], match[2]))
        return Affine(
            sx, 0.0, 0.0, sy,
            across * (width - sx * self.width) - sx * self.x, up * (height - sy * self.height) - sy * self.y,
        )  # fmt: skip


def view_box(text: str | None) -> ViewBox | None:
    """The view box of an attribute, None without one; ValueError for other text."""
    if text is None:
        return None
    values = numbers(text)
    if len(values) != 4 or not (values[2] > 0 and values[3] > 0):
        raise ValueError(f"viewBox {text[:60]!r} is none")
    return ViewBox(*values)


PLACES = {"x", "y", "width", "height", "cx", "cy", "r", "rx", "ry", "transform"}
"""Places that a style may give in place of an attribute."""
INHERITED = ("visibility", "fill", "stroke")
SEEN = {*INHERITED, "display", "opacity", "clip-path", "mask", *PLACES}
"""Properties that are looked at."""
SIMPLE = re.compile(r"([A-Za-z][\w-]*|\*)?((?:[.#][\w-]+)*)")
NOTHING = re.compile(r"\+?0*(?:\.0*)?%?")
MOST_TRIED = 3_000_000
"""Rules that are held against elements, copies counted."""
MOST_TOLD = 3
"""Rules that notes name."""


class Rule(NamedTuple):
    """Condition of a selector without combinators, and what it sets; `rank` says which of two rules wins."""

    rank: tuple[int, int, int, int]
    classes: frozenset[str]
    id: str
    kind: str
    sets: dict[str, str]


class Styles:
    """The rules of the style sheets of a file."""

    def __init__(self, file: str, rules: list[Rule], unknown: list[str]) -> None:
        self.file, self.unknown, self.tried = file, unknown, 0
        self.rules: dict[str, list[Rule]] = {}
        for rule in rules:
            known_by = f"#{rule.id}" if rule.id else f".{min(rule.classes)}" if rule.classes else rule.kind
            self.rules.setdefault(known_by, []).append(rule)

    @classmethod
    def of(cls, root: Element, file: str) -> Styles:
        """Styles of a file. Rules that depend on where an element is are not understood, and are reported."""
        rules: list[Rule] = []
        unknown: list[str] = []
        for element in root.iter():
            if isinstance(element.tag, str) and element.tag.rpartition("}")[2] == "style":
                for selectors, body in _rules("".join(element.itertext())):
                    sets = {name: value for name, value in declared(body).items() if name in SEEN}
                    for selector in selectors.split(",") if sets else ():
                        rule = _rule(selector.strip(), sets, len(rules))
                        rules += [rule] if rule else []
                        unknown += [] if rule else [shortened(" ".join(selector.split()))]
        return cls(file, rules, unknown)

    def given(self, element: Element, kind: str) -> dict[str, str]:
        """Attributes of an element, with what rules and its own style set in their place.

        Raises
        ------
        CaseError
            More rules for the elements than are looked at.
        """
        properties = dict(element.attrib)
        if self.rules:
            names = element.get("class", "").split()
            keys = {f"#{element.get('id', '')}", *(f".{name}" for name in names), kind, "*"}
            near, classes = [rule for key in keys for rule in self.rules.get(key, ())], set(names)
            self.tried += len(near)
            if self.tried > MOST_TRIED:
                raise CaseError(
                    f"{self.file}: its style sheet has so many rules for the same elements that more than "
                    f"{MOST_TRIED:,} are to be held against them; save it as plain SVG"
                )
            fit = [
                rule for rule in near
                if rule.classes <= classes and rule.id in ("", element.get("id")) and rule.kind in ("*", kind)
            ]  # fmt: skip
            for rule in sorted(fit):
                properties |= rule.sets
        own = declared(element.get("style", ""))
        return properties | {name: value for name, value in own.items() if name in SEEN}

    def notes(self) -> Iterator[str]:
        """Sentences on what is not understood."""
        if self.unknown:
            more = f" and {len(self.unknown) - MOST_TOLD} more" if len(self.unknown) > MOST_TOLD else ""
            yield f"rules of the style sheet that are not understood: {'; '.join(self.unknown[:MOST_TOLD])}{more}"


def _rule(selector: str, sets: dict[str, str], order: int) -> Rule | None:
    """The rule of a selector; None of one with combinators, pseudo-classes or attributes."""
    simple = SIMPLE.fullmatch(selector)
    if simple is None or not selector:
        return None
    parts = re.findall(r"[.#][\w-]+", simple[2])
    ids = [part[1:] for part in parts if part[0] == "#"]
    classes = frozenset(part[1:] for part in parts if part[0] == ".")
    if len(set(ids)) > 1:
        return None
    kind = simple[1] or "*"
    return Rule((len(ids), len(classes), kind != "*", order), classes, ids[0] if ids else "", kind, sets)


def _uncommented(text: str) -> str:
    """A style without its comments; one that does not end is none."""
    kept, here = [], 0
    while (begin := text.find("/*", here)) >= 0 and (end := text.find("*/", begin + 2)) >= 0:
        kept.append(text[here:begin])
        here = end + 2
    return " ".join([*kept, text[here:]])


def _rules(text: str) -> Iterator[tuple[str, str]]:
    """Selectors and body of each rule of a style sheet."""
    *bodies, _ = _uncommented(text).split("}")
    for one in bodies:
        head, begin, body = one.rpartition("{")
        if begin:
            yield head.rpartition("{")[2], body


def declared(text: str) -> dict[str, str]:
    """Properties and values of a style, the last of each."""
    pairs = (one.partition(":") for one in _uncommented(text).split(";"))
    return {name.strip().lower(): value.replace("!important", "").strip() for name, colon, value in pairs if colon}


def style_of(parent: Mapping[str, str], given: Mapping[str, str]) -> dict[str, str]:
    """Style that an element and its parts inherit; ``shown`` is ``no`` where nothing is seen, whatever parts say."""
    style = {name: given[name].strip() for name in INHERITED if given.get(name, "inherit").strip() != "inherit"}
    gone = given.get("display", "").strip() == "none" or (
        bool(given.get("opacity", "").strip()) and NOTHING.fullmatch(given["opacity"].strip()) is not None
    )
    shown = "no" if gone or parent.get("shown") == "no" else "yes"
    return {**parent, **style, "shown": shown}
