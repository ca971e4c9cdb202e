# SPDX-License-Identifier: GPL-2.0-or-later
"""Page and figure of ``lammps-jump fluid``."""

# ruff: noqa: RUF001  (Greek letters are meant for readers)
from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np

from lammps_jump.analysis.draw.style import BLACK, BLUE, GOLD, GREY, RED, drawing, save
from lammps_jump.analysis.tables.markdown import markdown, paragraphs

from .discs import FluidDiscs, Friction, viscosity
from .flow import FlowScales

WATER = {"viscosity": 1e-6, "sound": 1480.0}
"""Water at 20 degrees Celsius: kinematic viscosity, m^2/s, and speed of sound, m/s."""
RATES = (1.0, 3.0, 10.0)
"""Rates of shear of the table of viscosities, 1/s."""

Numbers = Mapping[str, Any]


def pm(pair: Sequence[float | None], digits: int = 3) -> str:
    """A mean with half its interval, ± where there is one; ``-`` where nothing was measured."""
    mean, half = pair
    if mean is None or not isfinite(mean):
        return "-"
    return f"{mean:z.{digits}g}" + (f" ± {half:z.1g}" if half is not None and isfinite(half) else "")


def law_of(summary: Numbers) -> Friction:
    """Friction law of a summary."""
    return Friction(summary["static"][0], summary["slope"][0], summary["exponent"])


def _viscosity(law: Friction, discs: FluidDiscs, flow: FlowScales, depth: float, rate: float) -> float:
    """Kinematic viscosity of the discs at a depth below the surface (m) and a rate of shear (1/s), m^2/s."""
    return viscosity(law, discs.density * flow.gravity * depth, rate, discs.diameter, discs.density)


def _table_depths(flow: FlowScales) -> tuple[float, float]:
    """Depths of the table of viscosities, m."""
    return 0.25 * flow.depth, flow.depth


def text_of(found: Numbers, discs: FluidDiscs, flow: FlowScales) -> str:
    """The page in Markdown."""
    summary, at = found["summary"], found["flow"]
    numbers = [
        f"- Reynolds number q/ν: **{at['reynolds']:z.2g}** (water: {flow.discharge / WATER['viscosity']:z.1e})",
        f"- Mach number U/c: **{at['mach']:z.2g}**",
        f"- inertial number I: {at['inertial']:z.2g}; there μ = {at['friction']:z.2g}, ν = {at['viscosity']:z.2g} m²/s",
        f"- Froude number: {at['froude']:z.3g}; depth over diameter: {at['discs_deep']:z.3g}",
        f"- a wave lower than {at['least_swing']:z.2g} m at the wall dies in one swing (2.5 μ h)",
    ]
    parts = [
        f"# What fluid the discs of {found['case']} are",
        f"The flow: U = {flow.speed:z.3g} m/s, h = {flow.depth:z.3g} m. "
        f"The numbers hold at half the depth and the rate U/h = {flow.rate:z.3g} /s.",
        "\n".join(numbers),
        *_zones(found["zones"]),
        "## Doubts",
        "\n".join([f"- {text}" for text in found["warnings"]] or ["- none"]),
        "## Water and these discs",
        _beside_water(summary, discs, flow),
        f"## Shear at {flow.pressure(discs.density) / 1e3:z.3g} kPa",
        *_shear(summary, discs, flow),
        f"± is the 95 % interval of the mean over {summary['starts']} starts. The figure is fluid.png.",
    ]
    return paragraphs(*parts)


def _beside_water(summary: Numbers, discs: FluidDiscs, flow: FlowScales) -> str:
    """Table of water beside the discs."""
    law, sound, swing = law_of(summary), summary["sound"], summary["slosh"]
    upper, lower = _table_depths(flow)
    least, most = _viscosity(law, discs, flow, upper, RATES[-1]), _viscosity(law, discs, flow, lower, RATES[0])
    rows = [
        ("viscosity, m²/s", "1e-6", f"{least:z.2g} to {most:z.2g}", "pressure over rate of shear, diameter"),
        ("friction at rest (yield) μs", "0", pm(summary["static"]), "friction and sizes of the discs"),
        ("speed of sound, m/s", "1480", pm(sound["speed"]), "stiffness: k/m"),
        ("the same over n v0 = d √(k/m)", "", pm(sound["ratio"]), "packing, pressure"),
        ("bulk density over ρ, at rest", "1", f"{4 * sound['packing'][0] / np.pi:z.3f}", "packing 4φ/π, ρd² a disc"),
        ("damping of a swing over the critical", "below 0.01", pm(swing["damping"]), "μ h over the swing"),
        ("frequency of a swing over theory", "1", pm(swing["frequency"]), "damping"),
        ("where the swing rests, share of its start", "0", pm(swing["rest"]), "yield"),
    ]
    titles = ("property", "water", "discs", "set by")
    return markdown(dict.fromkeys(titles, ""), [dict(zip(titles, row, strict=True)) for row in rows])


def _shear(summary: Numbers, discs: FluidDiscs, flow: FlowScales) -> tuple[str, str, str]:
    """Table of what was sheared, the law that follows, and the viscosities of that law."""
    law = law_of(summary)
    columns = {
        "I:": lambda row: pm(row["inertial"]),
        "μ:": lambda row: pm(row["friction"]),
        "packing φ:": lambda row: pm(row["packing"]),
    }
    depths = [
        {"depth (m)": f"{h:z.3g}", **{f"{r:zg} /s": f"{_viscosity(law, discs, flow, h, r):z.2g}" for r in RATES}}
        for h in _table_depths(flow)
    ]
    return (
        markdown(columns, summary["shear"]),
        f"μ = {pm(summary['static'])} + {pm(summary['slope'])} I^{law.exponent:z.2f}; ν = μ(I) p/(ρ rate), m²/s:",
        markdown({f"{title}:": "" for title in depths[0]}, depths),
    )


def _zones(zones: Mapping[str, Numbers]) -> list[str]:
    """Section on the parts of a jump; nothing without one."""
    if not zones:
        return []
    columns = {
        "part:": "{part}",
        "depth (m):": "{depth:z.3g}",
        "speed (m/s):": "{speed:z.3g}",
        "Re:": "{reynolds:z.2g}",
        "I:": "{inertial:z.2g}",
        "ν (m²/s):": "{viscosity:z.2g}",
        "Ma:": "{mach:z.2g}",
    }
    return ["## Parts of the jump", markdown(columns, [{"part": name, **one} for name, one in zones.items()])]


def draw(found: Numbers, discs: FluidDiscs, flow: FlowScales, path: Path) -> None:
    """Draw mu(I), packing(I), viscosity over depth and the swing."""
    summary, law = found["summary"], law_of(found["summary"])
    inertial = np.array([row["inertial"][0] for row in summary["shear"]])

    fine = np.geomspace(inertial.min(), inertial.max(), 60)
    with drawing(8.4, 6.0, 2, 2) as (figure, ((mu, phi), (nu, swing))):
        for axes, name in ((mu, "friction"), (phi, "packing")):
            pairs = np.array([row[name] for row in summary["shear"]], float)
            axes.errorbar(inertial, pairs[:, 0], np.nan_to_num(pairs[:, 1]), fmt="o", ms=4, color=BLUE, capsize=2)
            axes.set(xscale="log", xlabel="inertial number I")
        words = f"{law.static:z.3f} + {law.slope:z.3f} I^{law.exponent:z.2f}"
        mu.plot(fine, law.static + law.slope * fine**law.exponent, color=RED, ls=(0, (5, 2)), label=words)
        mu.set(title="Friction: shear stress over pressure", ylim=(0, None))
        mu.legend()
        phi.set(title="Packing: share of the area")
        depths = np.linspace(0.02, 1.0, 60) * flow.depth
        for rate, colour, dash in zip(RATES, (BLUE, GOLD, GREY), ("-", "--", "-."), strict=True):
            values = [_viscosity(law, discs, flow, h, rate) for h in depths]
            nu.plot(depths, values, color=colour, ls=dash, label=f"{rate:zg} /s")
        nu.set(title="Kinematic viscosity (m²/s)", xlabel="depth below the surface (m)", yscale="log")
        nu.legend(title="rate of shear")
        for one in summary["swings"]:
            swing.plot(one["times"], one["swing"], color=BLUE, lw=1.0)
        times = np.linspace(0.0, max(summary["swings"][0]["times"]), 200)
        swing.plot(times, np.cos(2.0 * np.pi * times), color=RED, ls=(0, (5, 2)), lw=1.0, label="water")
        swing.plot([], [], color=BLUE, label=f"discs, {summary['starts']} starts")
        swing.axhline(0.0, color=BLACK, lw=0.6)
        swing.set(title="Swing of a box over its start", xlabel="time over the period of water", ylim=(-1.1, 1.1))
        swing.legend()
        save(figure, path)
