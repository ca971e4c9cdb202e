# SPDX-License-Identifier: GPL-2.0-or-later
"""``lammps-jump fluid``: what fluid the discs of a case are, measured in three small flows of the same discs.

Shear at a held pressure gives friction, packing and viscosity (`shear`), a standing wave the speed of sound (`sound`),
a box that sloshes frequency and damping (`slosh`). What is measured depends on the discs, the pressure at the depth of
the flow, and that depth alone. It is kept in the cache under their key, where `check` and other cases find it.
"""

from __future__ import annotations

from functools import partial
from math import nan
from pathlib import Path
from typing import Any

import numpy as np

from lammps_jump.errors import CaseError
from lammps_jump.files import write_json, write_text
from lammps_jump.provenance import usable_cores
from lammps_jump.runs.run import Case
from lammps_jump.studies.folder import held_folder
from lammps_jump.sweeps import Pool, Say, Store
from lammps_jump.sweeps.table import mean_of

from . import page, slosh, sound
from .discs import FluidDiscs, discs_of, fit_friction
from .flow import FlowScales, flow_of, zones_of
from .store import Numbers, measured_key, numbers_at, slosh_depth, store_of

STARTS, QUICK_STARTS = 3, 2
QUICK_NUMBERS = (0.3, 0.1, 0.03)
COMPRESSIBLE = 0.2
"""Mach number above which the page calls a flow compressible."""


def shear_start(discs: FluidDiscs, pressure: float, seed: int, numbers: tuple[float, ...]) -> list[Numbers]:
    """`shear.sheared` as plain data, for a worker."""
    return [one._asdict() for one in sound.sheared(discs, pressure, seed, numbers=numbers)]


def sound_start(discs: FluidDiscs, pressure: float, seed: int) -> Numbers:
    """`sound.sound_speed` as plain data, for a worker."""
    return sound.sound_speed(discs, pressure, seed)._asdict()


def slosh_start(discs: FluidDiscs, depth: float, gravity: float, seed: int) -> Numbers:
    """`slosh.slosh_of` as plain data with the swing it is from, for a worker."""
    times, swing, amplitude = slosh.swing_of(discs, depth, gravity, seed)
    return slosh.slosh_of(times, swing, amplitude, depth)._asdict() | {"times": times, "swing": swing}


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
    found, mu = [], discs.coefficients.friction
    if at["mach"] > COMPRESSIBLE:
        softer = at["mach"] / COMPRESSIBLE
        found.append(
            f"the Mach number is {at['mach']:z.2g}, above {COMPRESSIBLE}: the flow is compressible; make the discs "
            f"{softer:z.2g} times as stiff against their speed (a smaller contact.largest_overlap)"
        )
    if discs.sizes is None:
        found.append("the discs are equal and pack into crystals: friction is up to twice as large; set discs.sizes")
    if mu > 0:
        found.append(
            f"contact.friction is {mu:zg}: the discs hold a slope at rest, which water does not; set it to 0 for water"
        )
    if flow.thinnest == flow.depth and 0.5 * flow.depth < at["least_swing"]:
        found.append(
            f"a wave lower than {at['least_swing']:z.2g} m dies in one swing, and half the depth is less; take smaller "
            "discs for waves"
        )
    return found


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
        Two starts in place of three, and three inertial numbers. Nothing of it is found by `store.stored`.
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
        numbers = QUICK_NUMBERS if quick else sound.INERTIAL
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
        found: Numbers = {
            "case": case.name,
            "flow": at,
            "zones": zones,
            "warnings": warnings_of(discs, flow, at),
            "summary": summary,
        }
        found["text"] = page.text_of(found, discs, flow)
        write_json(folder / "fluid.json", {name: one for name, one in found.items() if name != "text"})
        write_text(folder / "fluid.md", found["text"])
        page.draw(found, discs, flow, folder / "fluid.png")
        return found


def _told(piece: Any) -> str:
    """Line on the result of a piece."""
    if isinstance(piece, list):
        return "shear: " + ", ".join(f"mu {one['friction']:z.3f} at I {one['inertial']:z.2g}" for one in piece)
    if "swing" in piece:
        return (
            f"slosh: first opposite swing {_number(piece['opposite']):z.2f} of the start, at rest {piece['rest']:z.2f}"
        )
    return f"sound: {piece['speed']:z.1f} m/s, packing {piece['packing']:z.3f}"
