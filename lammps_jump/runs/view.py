"""A case as HTML, for notebooks: its coefficients, and its walls drawn."""

from __future__ import annotations

import html
from dataclasses import asdict

from lammps_jump.scene.scene import Scene
from lammps_jump.scene.walls import Box, Plane, Wall

COEFFICIENTS = {
    "mass": "kg/m",
    "stiffness": "N/m",
    "restitution": "",
    "friction": "",
    "damping": "N s/m",
    "time_step": "s",
    "contact_duration": "s",
}
"""The coefficients that are shown, with their units."""


def case_html(name: str, scene: Scene) -> str:
    """Name, coefficients and a drawing of the walls of a case."""
    values = asdict(scene.coefficients)
    rows = "".join(f"<tr><td>{key}</td><td>{values[key]:.4g} {unit}</td></tr>" for key, unit in COEFFICIENTS.items())
    return f"<p><b>{html.escape(name)}</b>: {html.escape(scene.description)}</p><table>{rows}</table>{_drawing(scene)}"


def _drawing(scene: Scene) -> str:
    """SVG of the walls within the domain, y upwards."""
    (left, right), (bottom, top) = scene.domain
    walls = "".join(_shape(wall, scene.domain) for wall in scene.walls)
    return (
        f"<svg width='640' viewBox='{left:g} {-top:g} {right - left:g} {top - bottom:g}' fill='#bbb' stroke='#333' "
        f"stroke-width='{(right - left) / 500:g}'><g transform='scale(1 -1)'>{walls}</g></svg>"
    )


def _shape(wall: Wall, domain: tuple[tuple[float, float], tuple[float, float]]) -> str:
    (left, right), (bottom, top) = domain
    if isinstance(wall, Plane):
        x1, x2, y1, y2 = (wall.at, wall.at, bottom, top) if wall.axis == "x" else (left, right, wall.at, wall.at)
        return f"<line x1='{x1:g}' x2='{x2:g}' y1='{y1:g}' y2='{y2:g}'/>"
    (x1, x2), (y1, y2) = wall.x, wall.y
    fill = "none" if isinstance(wall, Box) else "#bbb"
    return f"<rect x='{x1:g}' y='{y1:g}' width='{x2 - x1:g}' height='{y2 - y1:g}' fill='{fill}'/>"
