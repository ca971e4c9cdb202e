# SPDX-License-Identifier: GPL-2.0-or-later
"""A described drawing as SVG: some ten milliseconds, small, and sharp at every size.

Each shape has the class of its look, and colours of its own for where there is no style: a page may give others.
"""

from __future__ import annotations

import html
from itertools import pairwise
from math import hypot

import numpy as np

from lammps_jump.quoting import visible

from .drawing import BAND, HEIGHTS, Area, Arrow, Drawing, DrawnDiscs, Shape, Stroke

LEFT, RIGHT, BELOW, ABOVE = 46, 12, 40, 24
"""Pixels around the axes."""
SHADES = 12
"""Sizes of discs that are distinguished."""
APART = 80.0
"""Pixels between the ticks of an axis, about."""
TONES = {"plain": "#1a1a1a", "blue": "#00306f", "red": "#b3263a"}
LOOKS = {
    "domain": 'fill="none" stroke="#8a8a8a" stroke-dasharray="2 3"',
    "pour": 'fill="none" stroke="#00306f" stroke-dasharray="1 2"',
    "solid": 'fill="#c4c4c4" stroke="#464646" stroke-width="1.4" fill-rule="evenodd"',
    "outside": 'fill="#c4c4c4" stroke="#464646" stroke-width="1.4" fill-rule="evenodd"',
    "ghost": 'fill="none" stroke="#464646" stroke-dasharray="5 3" opacity="0.5"',
    "sheet": 'fill="none" stroke="#464646" stroke-width="3.4" stroke-linejoin="round"',
    "band": f'fill="none" stroke="#c4c4c4" stroke-width="{BAND:zg}" stroke-linejoin="round"',
    "edge": 'fill="none" stroke="#464646" stroke-width="2.2" stroke-linejoin="round"',
    "outlet": 'fill="none" stroke="#1a1a1a" stroke-dasharray="7 3 1.5 3"',
    "level": 'fill="none" stroke="#b3263a" stroke-dasharray="6 3" stroke-width="2"',
    "leader": 'fill="none" stroke-width="0.9"',
    "mark": 'fill="none" stroke-width="2"',
}


def svg_text(drawing: Drawing) -> str:
    """Text of the drawing, whose labels are placed; it has a description for readers that do not see."""
    wide, high = drawing.size
    size = wide + LEFT + RIGHT, high + ABOVE + BELOW
    shapes = sorted(drawing.shapes, key=lambda shape: HEIGHTS[shape.look])
    label = html.escape(visible(f"Drawing of {drawing.title}; {drawing.aside}"))
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" class="sketch" role="img" aria-label="{label}" '
        f'width="{size[0]:z.0f}" '
        f'height="{size[1]:z.0f}" viewBox="0 0 {size[0]:z.1f} {size[1]:z.1f}" font-family="system-ui, sans-serif" '
        f'font-size="13"><text class="aside" x="{LEFT + wide:z.1f}" y="15" text-anchor="end" fill="#555555">'
        f'{html.escape(drawing.aside)}</text>{_axes(drawing)}<svg x="{LEFT}" y="{ABOVE}" width="{wide:z.1f}" '
        f'height="{high:z.1f}">{"".join(_shape(drawing, shape) for shape in shapes)}</svg></svg>'
    )


def _pixels(drawing: Drawing, points: np.ndarray) -> np.ndarray:
    """Places within the axes, pixels, y downwards; those far outside are cut, along each axis alone."""
    places = (points - np.array([drawing.x[0], drawing.y[1]])) * drawing.scale * np.array([1, -1])
    return np.clip(places, -1e5, 1e5)


def _path(drawing: Drawing, points: np.ndarray, end: str = "") -> str:
    return f"M{' '.join(f'{x:z.1f},{y:z.1f}' for x, y in _pixels(drawing, points).tolist())}{end}"


def _shape(drawing: Drawing, shape: Shape) -> str:
    if isinstance(shape, Area):
        path = "".join(_path(drawing, ring, "Z") for ring in shape.rings)
        return f'<path class="{shape.look}" {LOOKS[shape.look]} d="{path}"/>'
    if isinstance(shape, Stroke):
        tone = f' stroke="{TONES[shape.tone]}"' if shape.look in ("leader", "mark") else ""
        look = f'class="{shape.look} {shape.tone}" {LOOKS[shape.look]}{tone}'
        return f'<path {look} d="{_path(drawing, shape.points)}"/>'
    if isinstance(shape, DrawnDiscs):
        return _discs(drawing, shape)
    if isinstance(shape, Arrow):
        return _arrow(drawing, shape)
    (x, y), tone = _pixels(drawing, np.array([shape.x, shape.y])).tolist(), TONES[shape.tone]
    look = f'class="label {shape.tone}" fill="{tone}" stroke="#ffffff" stroke-width="3" paint-order="stroke"'
    return f'<text {look} x="{x:z.1f}" y="{y - 4:z.1f}">{html.escape(visible(shape.text))}</text>'


def _discs(drawing: Drawing, discs: DrawnDiscs) -> str:
    """Each size of discs as one path of dots: the rims, then what is within them."""
    places = _pixels(drawing, discs.places)
    inside = ((places > -50) & (places < np.array(drawing.size) + 50)).all(axis=1)
    places, sizes = places[inside], discs.diameters[inside] * drawing.scale
    low, high = sizes.min(initial=np.inf), sizes.max(initial=0.0)
    shade = np.rint((sizes - low) / max(high - low, 1e-12) * (SHADES - 1)) if high > low * 1.001 else 0 * sizes
    made = []
    for one in np.unique(shade):
        own = shade == one
        dots = "".join(f"M{x:z.1f} {y:z.1f}h0" for x, y in places[own].tolist())
        for name, colour, less in (("rim", "#4f7cb3", 0.0), ("disc", "#a9c4e4", 2 * discs.rim * 5 / 3)):
            width = max(float(sizes[own].mean()) - less, 0.5)
            look = f'class="{name}" stroke="{colour}" stroke-width="{width:z.2f}" stroke-linecap="round"'
            made.append(f'<path {look} d="{dots}"/>')
    return "".join(made)


def _arrow(drawing: Drawing, arrow: Arrow) -> str:
    """The line to where the head begins, and the head."""
    points = _pixels(drawing, arrow.points)
    steps = ((a, b) for a, b in pairwise(points[::-1]) if hypot(*(a - b)) > 1e-3)
    end, before = next(steps, (points[-1], points[-1] - np.array([1, 0])))
    tip = points[-1]
    along = (end - before) / hypot(*(end - before))
    long, half = 0.67 * arrow.head, 0.33 * arrow.head
    base, aside = tip - long * along, half * np.array([-along[1], along[0]])
    head = " ".join(f"{x:z.1f},{y:z.1f}" for x, y in (tip, base + aside, base - aside))
    line = " ".join(f"{x:z.1f},{y:z.1f}" for x, y in [*points[:-1], base])
    tone = TONES[arrow.tone]
    return (
        f'<g class="arrow {arrow.tone}" stroke="{tone}" fill="{tone}"><path fill="none" stroke-width="'
        f'{arrow.width * 5 / 3:z.1f}" d="M{line}"/><path stroke="none" d="M{head}Z"/></g>'
    )


def _axes(drawing: Drawing) -> str:
    """Lines, ticks and names of both axes."""
    wide, high = drawing.size
    bottom, marks, names = ABOVE + high, [], []
    for x in _ticks(*drawing.x, drawing.scale):
        at = LEFT + (x - drawing.x[0]) * drawing.scale
        marks.append(f"M{at:z.1f},{bottom:z.1f}v5")
        names.append(f'<text x="{at:z.1f}" y="{bottom + 18:z.1f}" text-anchor="middle">{_number(x)}</text>')
    for y in _ticks(*drawing.y, drawing.scale):
        at = bottom - (y - drawing.y[0]) * drawing.scale
        marks.append(f"M{LEFT},{at:z.1f}h-5")
        names.append(f'<text x="{LEFT - 8}" y="{at + 4:z.1f}" text-anchor="end">{_number(y)}</text>')
    names.append(f'<text x="{LEFT + wide / 2:z.1f}" y="{bottom + 35:z.1f}" text-anchor="middle">x [m]</text>')
    names.append(f'<text x="2" y="{ABOVE - 9}">y [m]</text>')
    return (
        f'<g class="axes"><path stroke="#555555" fill="none" d="M{LEFT},{ABOVE}V{bottom:z.1f}H{LEFT + wide:z.1f}'
        f'{"".join(marks)}"/><g fill="#555555" font-size="12">{"".join(names)}</g></g>'
    )


def _ticks(low: float, high: float, scale: float) -> list[float]:
    """Round numbers between two, about `APART` pixels from each other."""
    least = APART / scale
    unit = 10.0 ** np.floor(np.log10(least))
    step = next(times * unit for times in (1, 2, 5, 10) if times * unit >= least * (1 - 1e-9))
    return [float(k * step) for k in range(int(np.ceil(low / step - 1e-9)), int(np.floor(high / step + 1e-9)) + 1)]


def _number(value: float) -> str:
    return f"{value:z.6g}".replace("-", "\N{MINUS SIGN}")
