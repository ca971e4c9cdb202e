# SPDX-License-Identifier: GPL-2.0-or-later
"""Bodies that move freely: Archimedes, a block on a slope, sliding against tipping, a pendulum."""

from __future__ import annotations

from math import atan, cos, degrees, radians, sin

import numpy as np
from matplotlib.figure import Figure

from lammps_jump.analysis.draw.style import BLUE, GREY, drawing
from lammps_jump.studies.validation import DERIVED, Found, Law, Point, Row, around, mean_of

DENSITIES = (250.0, 350.0, 450.0, 550.0, 650.0)
SLIDES, TIPS = 0.3, 0.5
"""Friction of a block that slides before it tips, and width over height: the tangent at which it tips."""
SLOPE, FRICTION = 20.0, 0.2
MARGINS = {"sliding": 0.5, "tipping": 2.0}
"""Degrees below and above the limit at which a block stands, and moves: it rocks as it is set down."""


def points(quick: bool) -> list[Point]:
    """Five densities, slopes on both sides of each limit, a pendulum; quick: one of each kind."""
    found = []
    for density in DENSITIES[2:3] if quick else DENSITIES:
        changes = {"bodies.box.density": density, **({"run.duration": 5.0} if quick else {})}
        found.append(Point(f"float {density:g}", "floats", "float.yaml", changes, 1, {"since": 4.0}, seconds=15))
    flat = {"bodies.block.x": [0.0, 2.0], "bodies.block.y": [0.0, 1.0]}
    for name, friction, shape in (("slides", FRICTION, flat), ("rests", 0.5, flat)):
        changes = {"slope": SLOPE, "bodies.block.friction": friction, **shape}
        changes |= {"run.duration": 10.0, "run.output_interval": 0.1} if name == "rests" else {}
        found.append(Point(name, "on_a_slope", "block.yaml", changes, seconds=2))
    for name, friction, limit in (("sliding", SLIDES, SLIDES), ("tipping", 0.8, TIPS)):
        for side in (-1, 1):
            changes = {"slope": degrees(atan(limit)) + side * MARGINS[name], "bodies.block.friction": friction}
            changes |= {"run.duration": 1.0} if name == "tipping" else {}  # before it falls flat
            found.append(
                Point(f"{name} {'above' if side > 0 else 'below'}", "on_a_slope", "block.yaml", changes, seconds=1)
            )
    tilt = radians(5.0)
    centre = (5.0 + sin(tilt), 10.0 - cos(tilt))
    changes = {
        "bodies.block.x": [centre[0] - 0.25, centre[0] + 0.25], "bodies.block.y": [centre[1] - 1.0, centre[1] + 1.0],
        "bodies.block.angle": 5.0, "bodies.block.hinge": [5.0, 10.0], "run.duration": 12.0,
    }  # fmt: skip
    found.append(Point("pendulum", "swings", "block.yaml", changes, seconds=5))
    return found


def rows(found: Found) -> list[Row]:
    """Displaced mass, accelerations, what stands and what does not, period."""
    made = []
    for name, ones in found.items():
        if name.startswith("float"):
            made.append(
                Row(f"displaced mass / mass, {name.split()[1]} kg/m³", 1.0, DERIVED, "Archimedes, at the bulk density",
                    *mean_of([one["share"] for one in ones]), around(1.0, by=0.05), "a third of a diameter of draught",
                    "discs that shake push a body up, and discs at rest carry it as a solid: they are no fluid at rest")
            )  # fmt: skip
    slope = radians(SLOPE)
    exact = sin(slope) - FRICTION * cos(slope)
    one, size = found["slides"][0], 2.0
    made += [
        Row("block on 20 degrees, μ 0.2: acceleration / g (sin - μ cos)", 1.0, DERIVED, "Coulomb",
            one["acceleration"] / exact, limits=around(1.0, by=0.005), reason="the step, and springs of contacts"),
        Row("block on 20 degrees, μ 0.5: way in 5 s / size", 0.0, DERIVED, "a spring creeps nowhere",
            found["rests"][0]["way"] / size, limits=(0.0, 1e-6), reason="rounding"),
    ]  # fmt: skip
    for name, key, limit, moves in (("sliding", "way", SLIDES, 0.1), ("tipping", "turn", TIPS, 5.0)):
        below, above = (found[f"{name} {side}"][0][key] for side in ("below", "above"))
        made.append(
            Row(f"{name}: stands {MARGINS[name]:g} degrees below {degrees(atan(limit)):.1f}, moves as far above",
                "true", DERIVED, "tan of the slope = μ, or width over height",
                float(below < 0.1 * moves and above > moves),
                limits=(0.5, 1.5), reason="1: it stands below and moves above; else 0")
        )  # fmt: skip
    made.append(
        Row("pendulum, period / 2π √(I/(M g l)) (1 + θ²/16)", 1.0, DERIVED, "compound pendulum",
            found["pendulum"][0]["period"], limits=around(1.0, by=0.001), reason="order of the scheme")
    )  # fmt: skip
    return made


def figure(found: Found) -> Figure:
    """Draw displaced mass over mass against the density of the box."""
    with drawing(5.4, 3.6) as (made, axes):
        pairs = [(float(name.split()[1]), ones[0]["share"]) for name, ones in found.items() if name.startswith("float")]
        axes.plot(*np.array(pairs).T, "o-", color=BLUE, label="measured")
        axes.axhline(1.0, color=GREY, ls="--", label="Archimedes")
        axes.set(xlabel="density of the box [kg/m³]", ylabel="displaced mass / mass [1]", ylim=(0, 1.2))
        axes.legend()
    return made


LAW = Law(
    "Bodies",
    "Do bodies float, slide, tip and swing as mechanics says?",
    points,
    rows,
    figure,
    (
        "A box of 2 m x 1.2 m on discs of 0.16 m ± 30 % without friction, over a floor that shakes by 30 mm with a "
        "period of 0.25 s. A block of 1 m x 2 m or 2 m x 1 m on a slope, with a tangential spring. A block on a hinge.",
    ),
)
