# SPDX-License-Identifier: GPL-2.0-or-later
"""A layer of grains on a slope: Bagnold's profile, friction and packing against the inertial number."""

from __future__ import annotations

from math import radians, tan
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from scipy.optimize import curve_fit

from lammps_jump.analysis.draw.style import BLUE, GOLD, GREY, drawing
from lammps_jump.studies.validation import DERIVED, LOOKED_UP, SECOND_HAND, Found, Law, Point, Row, mean_of

ANGLES = {18: 9.0, 20: 9.0, 22: 9.0, 24: 12.0, 26: 13.0}
"""Slopes, degrees, and times until layers are steady, s."""
THICK, STEEP = (10, 15, 20, 25), 22
"""Thicknesses in diameters whose mean velocities are compared, and their slope, degrees."""
STILL = (14, 15, 16, 17)
"""Slopes among which a layer of 15 diameters stops."""
STOPPED = 0.01
"""Mean velocity over sqrt(g d) below which a layer has stopped."""
GLASS = (0.38, 0.64, 0.28)
"""mu_s, mu_2 and I0 of glass beads."""


def point(angle: float, thick: float, starts: int, duration: float) -> Point:
    """A layer of this thickness (d) on a slope (degrees); the last third of the time counts."""
    changes = {
        "slope": angle,
        "initial.0.y": [0.012, 0.012 + 0.01 * thick],
        "run.duration": duration,
        "analysis.window": [round(duration * 2 / 3, 3), duration],
        "contact.impact_speed": round(max(1.0, (thick / 15) ** 0.5, 1.6 if angle > 25 else 1.0), 3),
    }
    name = f"{angle:g} degrees" + ("" if thick == 15 else f", {thick:g} d")
    return Point(name, "layer", "layer.yaml", changes, starts, seconds=0.06 * duration * thick)


def points(quick: bool) -> list[Point]:
    """Slopes, thicknesses, and slopes at which it stops; quick: two slopes and thicknesses, too short to be steady."""
    if quick:
        return [point(20, 15, 1, 1.5), point(STEEP, 15, 1, 1.5), point(STEEP, 10, 1, 1.5), point(12, 15, 1, 1.5)]
    found = [point(angle, 15, 3, duration) for angle, duration in ANGLES.items()]
    found += [point(STEEP, thick, 3, 12.0 if thick > 15 else 9.0) for thick in THICK if thick != 15]
    return found + [point(angle, 15, 1, 6.0) for angle in STILL]


def flows(found: Found) -> dict[float, list[Any]]:
    """Starts of layers of 15 d that flow, by slope."""
    named = {name: list(ones) for name, ones in found.items() if name.endswith("degrees")}
    return {float(name.split()[0]): ones for name, ones in named.items() if moves(ones)}


def moves(ones: list[Any]) -> bool:
    """Whether a layer flows at the end, with inner layers that were measured."""
    return all(one["velocity"] > STOPPED and one["inertial"] is not None for one in ones)


def thicknesses(found: Found) -> list[list[Any]]:
    """Starts at one slope, by thickness."""
    return [list(ones) for name, ones in found.items() if name.startswith(f"{STEEP} degrees")]


def bagnold(found: Found) -> list[float]:
    """Exponent of the mean velocity over the thickness, one for each start."""
    fits = []
    for ones in zip(*thicknesses(found), strict=False):
        h, u = ([one[key] for one in ones] for key in ("thickness", "velocity"))
        fits.append(float(np.polyfit(np.log(h), np.log(u), 1)[0]))
    return fits


def by_start(found: Found) -> list[dict[float, Any]]:
    """Layers of 15 d that flow steadily, by slope: a mapping for each start."""
    every = flows(found)
    most = max(map(len, every.values()), default=0)
    some = {angle: ones for angle, ones in every.items() if len(ones) == most}
    return [dict(zip(some, ones, strict=True)) for ones in zip(*some.values(), strict=False)]


def line_of(layers: dict[float, Any], key: str) -> tuple[float, float]:
    """Straight line of a number over I: slope and value at I = 0."""
    ones = list(layers.values())
    slope, offset = np.polyfit([one["inertial"] for one in ones], [one[key] for one in ones], 1)
    return float(slope), float(offset)


def friction_of(inertial: Any, still: float, fast: float, middle: float) -> Any:
    """Friction mu(I) of Jop, Forterre & Pouliquen 2006."""
    return still + (fast - still) / (middle / np.maximum(inertial, 1e-9) + 1)


def fit_of(layers: dict[float, Any]) -> tuple[float, ...] | None:
    """Fitted mu_s, mu_2 and I0; None where fewer than four slopes flow."""
    ones = [(one["inertial"], tan(radians(angle))) for angle, one in layers.items()]
    if len(ones) < 4:
        return None
    limits = ([0.05, 0.2, 0.01], [0.6, 3.0, 10.0])
    fitted, _ = curve_fit(friction_of, *zip(*ones, strict=True), p0=GLASS, bounds=limits)
    return tuple(float(value) for value in fitted)


def stops_at(found: Found) -> tuple[float, float]:
    """Angle between the steepest slope at which a layer of 15 d stops and the next one that flows; half of the gap."""
    named = {float(name.split()[0]): ones for name, ones in found.items() if name.endswith("degrees")}
    still = [angle for angle, ones in named.items() if all(one["velocity"] < STOPPED for one in ones)]
    low = max(still, default=float("nan"))
    high = min((angle for angle in named if angle > low), default=float("nan"))
    return 0.5 * (low + high), 0.5 * (high - low)


def rows(found: Found) -> list[Row]:
    """Balance of forces, Bagnold's exponent, and fits."""
    some = {angle: [layers[angle] for layers in by_start(found)] for angle in by_start(found)[0]}
    ratios = [one["friction"] / tan(radians(angle)) for angle, ones in some.items() for one in ones]
    da_cruz = "da Cruz et al. 2005, Phys. Rev. E 72: both are linear; their numbers were not found"
    made = [
        Row("shear over normal stress / tangent of the slope", 1.0, DERIVED, "balance of forces of a steady layer",
            *mean_of(ratios), (0.97, 1.03), "2 % of scatter between layers, and what is left of acceleration"),
        Row("exponent of mean velocity over thickness", 1.5, DERIVED, "Bagnold: the same I at every height",
            *mean_of(bagnold(found)), (1.35, 1.65), "bed and surface are some diameters of layers of 10 to 25"),
        Row("scatter of I over the height / mean I", 0.0, DERIVED, "Bagnold: the same I at every height",
            *mean_of([one["spread"] for ones in some.values() for one in ones]), (0.0, 0.15),
            "without 3 d at the bed and 3 d at the surface"),
    ]  # fmt: skip
    starts = by_start(found)
    signs = {"friction": ("μ", "above 0", (0.0, np.inf)), "packing": ("packing", "below 0", (-np.inf, 0.0))}
    for key, (name, sign, limits) in signs.items():
        slopes, offsets = zip(*(line_of(layers, key) for layers in starts), strict=True)
        made += [
            Row(f"growth of {name} with I", sign, LOOKED_UP, da_cruz, *mean_of(slopes), limits, "sign"),
            Row(f"{name} at I = 0, straight line", None, "", "", *mean_of(offsets),
                reason="no number for discs was found"),
        ]  # fmt: skip
    fits = [fitted for layers in starts if (fitted := fit_of(layers)) is not None]
    if fits:
        for name, values, theirs in zip(("μ_s", "μ_2", "I_0"), zip(*fits, strict=True), GLASS, strict=True):
            made.append(
                Row(f"{name} of μ(I)", theirs, SECOND_HAND, "glass beads, in 3-D: Jop et al. 2006", *mean_of(values),
                    reason="spheres are no discs; up to I 0.25 ours is nearly straight, which leaves μ_2 and I_0 open")
            )  # fmt: skip
    angle, half = stops_at(found)
    made.append(
        Row("slope at which a layer of 15 d stops, degrees", None, "", "", angle, half,
            reason="no number for discs was found; interval: between two slopes that were tried")
    )  # fmt: skip
    return made


def figure(found: Found) -> Figure:
    """Draw a profile of velocity, friction and packing against I, and velocity against thickness."""
    some = {angle: [layers[angle] for layers in by_start(found)] for angle in by_start(found)[0]}
    with drawing(10.2, 3.7, 1, 3) as (made, (one, two, three)):
        for (angle, ones), look in zip(some.items(), ("-", "--", "-.", ":", (0, (5, 1))), strict=False):
            y, u = np.array(ones[0]["y"]), np.array(ones[0]["u"])
            below = y < ones[0]["surface"]
            one.plot(u[below], y[below], ls=look, color=BLUE, label=f"{angle:g}°")
            h = ones[0]["surface"]
            z = np.linspace(3, h, 50)
            top, foot = np.interp(h - 1, y, u), np.interp(3, y, u)
            law = (h - 3) ** 1.5 - (h - z) ** 1.5
            one.plot(foot + (top - foot) * law / ((h - 3) ** 1.5 - 1), z, color=GREY, lw=0.9)
        one.plot([], [], color=GREY, lw=0.9, label="Bagnold")
        one.set(xlabel="velocity / √(g d) [1]", ylabel="height / d [1]", title="velocity over the height")
        one.legend()
        for angle, ones in some.items():
            for start in ones:
                two.plot(start["inertial"], tan(radians(angle)), "o", color=BLUE, mfc="white")
                two.plot(start["inertial"], start["packing"], "s", color=GOLD, mfc="white")
        inertial = np.linspace(0, 0.4, 100)
        two.plot(inertial, friction_of(inertial, *GLASS), ":", color=GREY, label="μ(I), glass beads")
        if (fitted := fit_of(by_start(found)[0])) is not None:
            two.plot(inertial, friction_of(inertial, *fitted), color=BLUE, label="μ(I), fit to ours")
        rise, offset = line_of(by_start(found)[0], "packing")
        two.plot(inertial, offset + rise * inertial, "--", color=GOLD, label="packing, fit to ours")
        two.set(xlabel="inertial number I [1]", ylabel="μ, packing [1]", ylim=(0, 1), title="friction and packing")
        two.legend(loc="lower right")
        h = np.array([mean_of([one["thickness"] for one in ones])[0] for ones in thicknesses(found)])
        u = np.array([mean_of([one["velocity"] for one in ones])[0] for ones in thicknesses(found)])
        three.plot(h, u, "o", color=BLUE, label=f"ours, {STEEP}°")
        long = np.geomspace(h.min(), h.max(), 30)
        three.plot(long, u.mean() / np.mean(h**1.5) * long**1.5, color=GREY, label="exponent 1.5")
        three.set(xlabel="thickness / d [1]", ylabel="mean velocity / √(g d) [1]", title="Bagnold's law")
        three.set(xlim=(0, None), ylim=(0, None))
        three.legend()
    return made


LAW = Law(
    "Flow down a slope",
    "Do layers of grains on a slope follow Bagnold's law, and μ(I)?",
    points,
    rows,
    figure,
    (
        "Discs of ± 20 %, μ 0.5, e 0.5, spin, springs along contacts; rough bed of discs of 1.2 d, periodic channel of "
        "30 d. I = (shear rate) √(m/P), m = ρ d²; packing with π d²/4 for a disc. The last third of each run counts.",
        "The slope at which a layer at rest begins to flow is the law starting_angle.",
    ),
)
