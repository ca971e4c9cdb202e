# SPDX-License-Identifier: GPL-2.0-or-later
"""Cases and results as HTML, for notebooks."""

from __future__ import annotations

import html
from collections.abc import Sequence

from lammps_jump.scene.scene import Scene
from lammps_jump.units import numbers_of, shown

COEFFICIENTS = ("mass", "stiffness", "restitution", "friction", "damping", "time_step", "contact_duration")
"""The coefficients that are shown."""


def case_html(name: str, scene: Scene) -> str:
    """Name, coefficients and a drawing of the walls of a case."""
    values = scene.coefficients
    units = {key: number.unit for key, number in numbers_of(values).items()}
    rows = "".join(f"<tr><td>{key}</td><td>{getattr(values, key):.4g} {units[key]}</td></tr>" for key in COEFFICIENTS)
    return f"<p><b>{html.escape(name)}</b>: {html.escape(scene.description)}</p><table>{rows}</table>{_drawing(scene)}"


def number_table(results: Sequence[object]) -> str:
    """The labelled numbers of some results, at most five, each with its standard error."""
    rows = [
        (number.meaning, shown(value, number.unit, getattr(result, f"{number.key}_error", None)))
        for result in results
        for number in numbers_of(result).values()
        if number.label != number.meaning and (value := getattr(result, number.key)) == value
    ]
    cells = (f"<tr><td>{html.escape(name)}</td><td>{html.escape(text)}</td></tr>" for name, text in rows[:5])
    return f"<table>{''.join(cells)}</table>"


def _drawing(scene: Scene) -> str:
    """SVG of the walls within the domain, y upwards."""
    x, y = scene.domain
    shapes = [
        f"<polygon points='{' '.join(f'{px:g},{py:g}' for px, py in corners)}' fill='{fill}'/>"
        for wall in scene.permanent
        for fill in ("none" if wall.hollow else "#bbb",)
        for corners in wall.outline(x, y)
    ]
    return (
        f"<svg width='640' viewBox='{x[0]:g} {-y[1]:g} {x[1] - x[0]:g} {y[1] - y[0]:g}' stroke='#333' "
        f"stroke-width='{(x[1] - x[0]) / 500:g}'><g transform='scale(1 -1)'>{''.join(shapes)}</g></svg>"
    )
