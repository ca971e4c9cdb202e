# SPDX-License-Identifier: GPL-2.0-or-later
"""Affine maps of the plane as SVG writes them: transforms, and the way from a view box to its page."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from math import cos, hypot, isfinite, radians, sin, tan
from typing import NamedTuple

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
    """Numbers between blanks or commas; ValueError where something else stands there."""
    if NUMBERS.sub(" ", text).strip(" ,\t\r\n") or TWO_COMMAS.search(text):
        raise ValueError(f"{text[:60]!r} are no numbers")
    return [float(value) for value in NUMBERS.findall(text)]


def transform(text: str) -> Affine:
    """The map of an attribute ``transform``; ValueError for what is none."""
    found, place, text = Affine(), 0, text.rstrip()
    while place < len(text):
        single = SINGLE.match(text, place)
        values = numbers(re.sub(r"(?<=[\d.])(?:px|deg)\b", "", single[2])) if single else []
        counts, make = TRANSFORMS.get(single[1] if single else "", ((), None))
        if single is None or make is None or len(values) not in counts:
            raise ValueError(f"transform {text[place : place + 60]!r} is none")
        found = found.after(make(values))
        place = single.end()
    if not all(map(isfinite, found)):
        raise ValueError(f"transform {text[:60]!r} is beyond all numbers")
    return found


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
"""How many numbers each has, and what they mean (SVG 1.1, 7.6)."""


class ViewBox(NamedTuple):
    """The part of the plane that a page shows."""

    x: float
    y: float
    width: float
    height: float

    def onto(self, width: float, height: float, aspect: str) -> Affine:
        """The map onto a page of this size, by ``preserveAspectRatio`` (SVG 1.1, 7.8); ValueError for what is none."""
        told = ASPECT.fullmatch(aspect or "xMidYMid")
        if told is None:
            raise ValueError(f"preserveAspectRatio {aspect[:60]!r} is none")
        sx, sy = width / self.width, height / self.height
        if told[1]:
            sx = sy = (max if told[3] == "slice" else min)(sx, sy)
        across, up = (SHARES.get(part or "Min", 0.0) for part in (told[1], told[2]))
        return Affine(
            sx, 0.0, 0.0, sy,
            across * (width - sx * self.width) - sx * self.x, up * (height - sy * self.height) - sy * self.y,
        )  # fmt: skip


def view_box(text: str | None) -> ViewBox | None:
    """The view box of an attribute, None without one; ValueError for what is none."""
    if text is None:
        return None
    values = numbers(text)
    if len(values) != 4 or not (values[2] > 0 and values[3] > 0):
        raise ValueError(f"viewBox {text[:60]!r} is none")
    return ViewBox(*values)
