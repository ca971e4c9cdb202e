# SPDX-License-Identifier: GPL-2.0-or-later
# ruff: noqa: RUF001  (Greek letters are meant for readers)
"""``lammps-jump fluid``: what fluid the discs of a case are, measured in three small flows of the same discs.

Shear at a held pressure gives friction, packing and viscosity (`shear`), a standing wave the speed of sound (`sound`),
a box that sloshes frequency and damping (`slosh`). What is measured depends on the discs, the pressure at the depth of
the flow, and that depth alone. It is kept in the cache under their key, where `check` and other cases find it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from math import isfinite, nan
from pathlib import Path
from typing import Any

import numpy as np

from lammps_jump.analysis.draw.style import BLACK, BLUE, GOLD, GREY, RED, drawing, save
from lammps_jump.analysis.tables import markdown, paragraphs
from lammps_jump.errors import CaseError
from lammps_jump.files import write_json, write_text
from lammps_jump.provenance import usable_cores
from lammps_jump.runs.run import Case
from lammps_jump.studies.points import held_folder
from lammps_jump.sweeps import Pool, Say, Store
from lammps_jump.sweeps.table import mean_of

from .box import INERTIAL, sheared, slosh_of, sound_speed, swing_of
from .cell import FluidDiscs, Friction, discs_of, fit_friction, viscosity
from .flow import FlowScales, Numbers, flow_of, measured_key, numbers_at, slosh_depth, store_of, zones_of

STARTS, QUICK_STARTS = 3, 2
QUICK_NUMBERS = (0.3, 0.1, 0.03)
COMPRESSIBLE = 0.2
"""Mach number above which the page calls a flow compressible."""


def shear_start(discs: FluidDiscs, pressure: float, seed: int, numbers: tuple[float, ...]) -> list[Numbers]:
    """`shear.sheared` as plain data, for a worker."""
    return [one._asdict() for one in sheared(discs, pressure, seed, numbers=numbers)]


def sound_start(discs: FluidDiscs, pressure: float, seed: int) -> Numbers:
    """`sound_speed` as plain data, for a worker."""
    return sound_speed(discs, pressure, seed)._asdict()


def slosh_start(discs: FluidDiscs, depth: float, gravity: float, seed: int) -> Numbers:
    """`slosh_of` as plain data with the swing it is from, for a worker."""
    times, swing, amplitude = swing_of(discs, depth, gravity, seed)
    return slosh_of(times, swing, amplitude, depth)._asdict() | {"times": times, "swing": swing}


def summary_of(sheared: list[list[Numbers]], sounds: list[Numbers], sloshes: list[Numbers]) -> Numbers:
    """Means over the starts with the halves of their 95 % intervals, [mean, half]."""
    common = min(map(len, sheared))
    if common < 3:
        raise CaseError("fluid: the discs expand under shear for ever: they are a gas, whose viscosity is not measured")
    rows = [{name: mean_of([start[i][name] for start in sheared]) for name in sheared[0][i]} for i in range(common)]
    both = ("inertial", "friction")
    columns = [np.array([[one[name] for one in start[:common]] for start in sheared]) for name in both]
    pooled = fit_friction(columns[0].ravel(), columns[1].ravel())
    laws = [fit_friction(i, mu, pooled.exponent) for i, mu in zip(*columns, strict=True)]
    names = ("frequency", "damping", "opposite", "rest", "amplitude", "friction")
    return {
        "starts": len(sheared),
        "shear": rows,
        "static": mean_of([law.static for law in laws]),
        "slope": mean_of([law.slope for law in laws]),
        "exponent": pooled.exponent,
        "sound": {name: mean_of([one[name] for one in sounds]) for name in ("speed", "ratio", "packing")},
        "slosh": {name: mean_of([one[name] for one in sloshes]) for name in names},
        "swings": [{name: one[name] for name in ("times", "swing")} for one in sloshes],
    }


def _number(value: float | None) -> float:
    """NaN for None, as JSON has it."""
    return nan if value is None else value


def warnings_of(discs: FluidDiscs, flow: FlowScales, at: Numbers) -> list[str]:
    """Sentences on what these discs cannot say of water."""
    sentences, mu = [], discs.coefficients.friction
    if at["mach"] > COMPRESSIBLE:
        softer = at["mach"] / COMPRESSIBLE
        sentences.append(
            f"the Mach number is {at['mach']:z.2g}, above {COMPRESSIBLE}: the flow is compressible; make the discs "
            f"{softer:z.2g} times as stiff against their speed (a smaller contact.largest_overlap)"
        )
    if discs.sizes is None:
        sentences.append(
            "the discs are equal and pack into crystals: friction is up to twice as large; set discs.sizes"
        )
    if mu > 0:
        sentences.append(
            f"contact.friction is {mu:zg}: the discs hold a slope at rest, which water does not; set it to 0 for water"
        )
    if flow.thinnest == flow.depth and 0.5 * flow.depth < at["least_swing"]:
        sentences.append(
            f"a wave lower than {at['least_swing']:z.2g} m dies in one swing, and half the depth is less; take smaller "
            "discs for waves"
        )
    return sentences


def default_folder(case: Case) -> Path:
    """Folder of the results, ``runs/<name>_fluid``."""
    return Path("runs") / f"{case.name}_fluid"


def fluid(
    case: Case,
    out: Path | None = None,
    *,
    quick: bool = False,
    fresh: bool = False,
    depth: float | None = None,
    speed: float | None = None,
    say: Say = print,
) -> Numbers:
    """Measure the discs of a case as a fluid; writes ``fluid.json``, ``fluid.md`` and ``fluid.png``.

    Parameters
    ----------
    case : Case
    out : Path, optional
        Folder; default ``runs/<name>_fluid``.
    quick : bool
        Two starts in place of three, and three inertial numbers. Nothing of it is returned by `store.stored`.
    fresh : bool
        Measure again what is stored.
    depth, speed : float, optional
        Of the flow (m, m/s) in place of what the case says (`flow.flow_of`).
    say : callable

    Returns
    -------
    dict
        ``summary`` (`summary_of`), ``flow`` (`store.numbers_at`), ``zones`` (the same of the parts of a jump, with the
        depths of the run in ``runs/<name>`` where it is of this case), ``warnings`` and ``text``, the page in Markdown.
    """
    discs, flow = discs_of(case), flow_of(case, depth=depth, speed=speed)
    with held_folder(Path(out) if out else default_folder(case), "fluid") as folder:
        store = Store(store_of(measured_key(discs, flow)), fresh=fresh)
        pressure, h = flow.pressure(discs.density), slosh_depth(discs, flow)
        seeds = range(1, (QUICK_STARTS if quick else STARTS) + 1)
        numbers = QUICK_NUMBERS if quick else INERTIAL
        calls: list[partial[Any]] = [partial(shear_start, discs, pressure, seed, numbers) for seed in seeds]
        calls += [partial(slosh_start, discs, h, flow.gravity, seed) for seed in seeds]
        calls += [partial(sound_start, discs, pressure, seed) for seed in seeds]
        say(f"{case.name}: {len(calls)} small flows of its discs at {pressure / 1e3:z.3g} kPa, {h:z.3g} m deep")
        with Pool(usable_cores()) as pool:
            pieces = store.call(calls, pool, said=lambda piece: say(f"  {_told(piece)}"))
        n = len(seeds)
        summary = summary_of(pieces[:n], pieces[2 * n :], pieces[n : 2 * n])
        if not quick:
            store.data["summary"] = summary
            write_json(store.path, store.data)
        at = numbers_at(summary, discs, flow)
        zones = {name: numbers_at(summary, discs, zone) for name, zone in zones_of(case, flow).items()}
        result: Numbers = {
            "case": case.name,
            "flow": at,
            "zones": zones,
            "warnings": warnings_of(discs, flow, at),
            "summary": summary,
        }
        result["text"] = text_of(result, discs, flow)
        write_json(folder / "fluid.json", {name: one for name, one in result.items() if name != "text"})
        write_text(folder / "fluid.md", result["text"])
        draw(result, discs, flow, folder / "fluid.png")
        return result


def _told(piece: Any) -> str:
    """Line on the result of a piece."""
    if isinstance(piece, list):
        return "shear: " + ", ".join(f"mu {one['friction']:z.3f} at I {one['inertial']:z.2g}" for one in piece)
    if "swing" in piece:
        return (
            f"slosh: first opposite swing {_number(piece['opposite']):z.2f} of the start, at rest {piece['rest']:z.2f}"
        )
    return f"sound: {piece['speed']:z.1f} m/s, packing {piece['packing']:z.3f}"


# --- page and figure of ``lammps-jump fluid`` -------------------------------------------------------------------------


WATER = {"viscosity": 1e-6, "sound": 1480.0}
"""Water at 20 degrees Celsius: kinematic viscosity, m^2/s, and speed of sound, m/s."""
RATES = (1.0, 3.0, 10.0)
"""Rates of shear of the table of viscosities, 1/s."""


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
    """Table of water and the discs."""
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
