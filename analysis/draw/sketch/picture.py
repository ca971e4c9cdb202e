# SPDX-License-Identifier: GPL-2.0-or-later
"""A described drawing as a figure of matplotlib."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import EllipseCollection
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch, PathPatch, Polygon
from matplotlib.path import Path as Way
from matplotlib.patheffects import withStroke

from lammps_jump.analysis.draw.style import BLACK, BLUE, GREY, RED, WALL, style
from lammps_jump.quoting import figure_text

from .drawing import BAND, DOTS, HEIGHTS, TEXT, Area, Arrow, Drawing, DrawnDiscs, Shape, Stroke

LEFT, RIGHT, BELOW, ABOVE = 70, 20, 60, 44
"""Pixels around the axes."""
TONES = {"plain": BLACK, "blue": BLUE, "red": RED}
DISC, RIM, EDGE = "#a9c4e4", "#4f7cb3", "#464646"
AREAS: dict[str, dict[str, Any]] = {
    "domain": {"fc": "none", "ec": GREY, "ls": (0, (2, 3)), "lw": 1.0},
    "pour": {"fc": "none", "ec": BLUE, "ls": ":"},
    "ghost": {"fc": WALL, "ec": EDGE, "lw": 0.9, "ls": (0, (4, 2)), "alpha": 0.45},
    "solid": {"fc": WALL, "ec": EDGE, "lw": 1.1},
    "outside": {"fc": WALL, "ec": EDGE, "lw": 1.1},
}
STROKES: dict[str, dict[str, Any]] = {
    "sheet": {"color": EDGE, "lw": 2.4},
    "band": {"color": WALL, "lw": BAND * 72 / DOTS},
    "edge": {"color": EDGE, "lw": 1.6},
    "ghost": {"color": EDGE, "lw": 1.0, "ls": (0, (4, 2)), "alpha": 0.45},
    "outlet": {"color": BLACK, "ls": "-.", "lw": 1.0},
    "level": {"color": RED, "ls": (0, (5, 2)), "lw": 1.5},
    "leader": {"lw": 0.7},
    "mark": {"lw": 1.6},
}


def figure(drawing: Drawing) -> Figure:
    """The figure of a drawing whose labels are placed."""
    (wide, high), (x, y) = drawing.size, (drawing.x, drawing.y)
    size = wide + LEFT + RIGHT, high + ABOVE + BELOW
    with style():
        made = Figure(figsize=(size[0] / DOTS, size[1] / DOTS), dpi=DOTS)
        FigureCanvasAgg(made)
        axes = made.add_axes((LEFT / size[0], BELOW / size[1], wide / size[0], high / size[1]))
        axes.set(xlim=x, ylim=y, xlabel="x [m]", ylabel="y [m]")
        axes.grid(False)
        for shape in drawing.shapes:
            _draw(axes, shape)
        axes.set_title(figure_text(drawing.title), fontsize=11)
        axes.set_title(drawing.aside, fontsize=8.5, color="#555555", loc="right")
    return made


def _draw(axes: Axes, shape: Shape) -> None:
    over = HEIGHTS[shape.look]
    look: dict[str, Any]
    if isinstance(shape, Area):
        look = {**AREAS[shape.look], "zorder": over}
        if len(shape.rings) == 1:
            axes.add_patch(Polygon(shape.rings[0], **look))
        else:
            rings = (Way(np.vstack([ring, ring[:1]]), closed=True) for ring in shape.rings)
            axes.add_patch(PathPatch(Way.make_compound_path(*rings), **look))
    elif isinstance(shape, Stroke):
        look = {"color": TONES[shape.tone], **STROKES[shape.look], "zorder": over, "solid_joinstyle": "round"}
        axes.plot(*shape.points.T, scalex=False, scaley=False, **look)
    elif isinstance(shape, DrawnDiscs):
        look = {"fc": DISC, "ec": RIM, "lw": shape.rim, "zorder": over, "offset_transform": axes.transData}
        sizes, turned = shape.diameters, np.zeros(len(shape.diameters))
        axes.add_collection(EllipseCollection(sizes, sizes, turned, units="xy", offsets=shape.places, **look))
    elif isinstance(shape, Arrow):
        look = {"arrowstyle": "-|>", "mutation_scale": shape.head, "capstyle": "butt", "joinstyle": "miter"}
        look |= {"color": TONES[shape.tone], "lw": shape.width, "zorder": over}
        axes.add_patch(FancyArrowPatch(path=Way(shape.points), **look))
    else:
        halo = [withStroke(linewidth=2.5, foreground="white")]
        look = {"fontsize": TEXT, "path_effects": halo, "va": "bottom", "zorder": over, "color": TONES[shape.tone]}
        axes.text(shape.x, shape.y, figure_text(shape.text), **look)
