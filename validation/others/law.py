# SPDX-License-Identifier: GPL-2.0-or-later
"""Checks that others print, for discs: contacts of MFiX and Kratos, columns, a bore, a jump, a crater."""

from __future__ import annotations

from collections.abc import Sequence
from math import pi, radians, sqrt, tan

import numpy as np
from matplotlib.figure import Figure

from lammps_jump.analysis.draw.style import BLUE, GREY, RED, drawing
from lammps_jump.physics.contact import damping_ratio
from lammps_jump.physics.jump import belanger
from lammps_jump.studies.validation import DERIVED, LOOKED_UP, SECOND_HAND, Found, Law, Point, Row, mean_of

GRAVITY = 9.81
RESTITUTIONS = 0.5, 0.6, 0.8, 1.0
ALUMINA = {"restitution": 0.98, "friction": 0.092}
"""Alumina spheres on glass, Kharaz, Gorham & Salman 2001, as Di Renzo & Di Maio 2004 take them."""
ANGLES = (2.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 40.0, 45.0, 50.0, 60.0, 70.0)
SHARE = 2.0 / 7.0
SPREADS = (1.2, 1.5, 2.0, 3.0, 5.0)
"""Largest over smallest diameter."""
DROPS = (0.25, 0.5, 1.0, 2.0)
"""Of the large grain above the bed, m."""
DEEP, LAYERS = 3.0, (0.36, 0.76)
"""Reservoir and layers, m: 0.12 and 0.253 of it, as 18 and 38 mm below 0.15 m of Jánosi et al. 2004."""
JET = {"speed": 10.0, "depth": 0.6}
MFIX = "MFiX VVUQ manual"


def stoker(still: float) -> tuple[float, float]:
    """Speed of the bore of a dam break over a layer, m/s, and the depth behind it, m; Stoker 1957, section 10.8."""
    low, high = still, DEEP
    for _ in range(200):
        middle = 0.5 * (low + high)
        flows = (middle - still) * sqrt(GRAVITY * (middle + still) / (2 * middle * still))
        low, high = (middle, high) if flows < 2 * (sqrt(GRAVITY * DEEP) - sqrt(GRAVITY * middle)) else (low, middle)
    return sqrt(GRAVITY * low * (low + still) / (2 * still)), low


def slider(angles: Sequence[float], steps: int = 20_000) -> np.ndarray:
    """Speed along a wall after / before impacts at angles (degrees): damped spring, and spring with slider along it.

    A third of the mass of a disc resists a slip, so that a share of 1/3 of what the slip loses is the disc's.
    """
    e, mu = ALUMINA["restitution"], ALUMINA["friction"]
    xi = damping_ratio(e)
    time = np.linspace(0, pi / sqrt(1 - xi * xi), steps + 1)  # over the frequency of the contact
    swing = sqrt(1 - xi * xi)
    overlap = np.exp(-xi * time) * np.sin(swing * time) / swing
    rate = np.exp(-xi * time) * (np.cos(swing * time) - xi * np.sin(swing * time) / swing)
    normal = np.abs(overlap + 2 * xi * rate)
    along = np.array([tan(radians(angle)) for angle in angles])  # over the speed of impact
    slip, stretch, step = along.copy(), np.zeros_like(along), time[1]
    u = along.copy()
    for push in normal[:-1]:
        cap = mu * push / SHARE
        stretch = np.clip(stretch + slip * step, -cap, cap)
        force = SHARE * stretch
        u, slip = u - force * step, slip - 3 * force * step
    return u / along


def points(quick: bool) -> list[Point]:
    """Return all of them; quick: contacts, and one start of the smallest flows."""
    made = [Point(f"fall {e:g}", "falling", options={"restitution": e}) for e in RESTITUTIONS[: 1 if quick else 4]]
    made += [Point(f"stack {e:g}", "stacked", options={"restitution": e}) for e in RESTITUTIONS[: 1 if quick else 4]]
    made.append(Point("oblique", "oblique", options={**ALUMINA, "angles": list(ANGLES)}))
    starts = 1 if quick else 3
    for ratio in SPREADS[:1] if quick else SPREADS:
        ends = [round(0.2 / (1 + ratio), 5), round(0.2 * ratio / (1 + ratio), 5)]
        changes = {"discs.sizes": {"kind": "sieve", "passing": [[ends[0], 0], [ends[1], 1]]}}
        if quick:
            changes |= {"initial.0.x": [0, 1], "initial.0.y": [0, 1]}
        made.append(Point(f"spread {ratio:g}", "heap", "spread.yaml", changes, starts, seconds=15.0))
    for drop in DROPS[:1] if quick else DROPS:
        changes = {"bodies.grain.centre": [3, 2.25 + drop]}
        made.append(Point(f"drop {drop:g}", "sunk_in", "crater.yaml", changes, starts, {"drop": drop}, 5.0))
    for still in LAYERS[:1] if quick else LAYERS:
        changes = {"initial.1.y": [0, still]}
        options = {"still": still, "behind": stoker(still)[1]}
        made.append(Point(f"layer {still:g}", "bore", "wet.yaml", changes, starts, options, 5.0))
    flow, depth = JET["speed"] * JET["depth"], JET["depth"]
    deep = depth * belanger(JET["speed"] / sqrt(GRAVITY * depth))
    sill = deep + (flow / deep) ** 2 / (2 * GRAVITY) - 1.5 * (flow**2 / GRAVITY) ** (1 / 3)
    changes = {
        "walls.sill.y": [-5, round(sill, 2)],
        "initial.1.y": [0, round(deep, 2)],
        "initial.1.velocity": [round(flow / deep, 3), 0],
    }
    return [*made, Point("jump", "jump", "../jumps/jump.yaml", changes, starts, seconds=5.0)]


def of(found: Found, name: str, key: str) -> list[float]:
    """A number of all points of a name."""
    return [one[key] for point, ones in found.items() if point.split()[0] == name for one in ones]


def contacts(found: Found) -> list[Row]:
    """One and two discs against closed forms."""
    one = found["oblique"][0]
    ratio, mu, e = np.array(one["ratio"]), ALUMINA["friction"], ALUMINA["restitution"]
    tangents = np.array([tan(radians(angle)) for angle in one["angles"]])
    slides = np.array(one["angles"]) >= 45
    errors = np.abs(ratio - (1 - mu * (1 + e) / tangents))[slides], np.abs(ratio - slider(one["angles"]))
    return [
        Row("DEM01, disc that falls and bounces: largest error of its height / initial height", 0.0, DERIVED,
            f"{MFIX}, DEM01; the dashpot pulls until the overlap is 0", max(of(found, "fall", "error")),
            limits=(0.0, 0.01), reason="first order in the step, f 0.01"),
        Row("DEM03, two discs between walls: largest error of a height / overlap at a wall", 0.0, DERIVED,
            f"{MFIX}, DEM03; linear system, exactly", max(of(found, "stack", "error")), limits=(0.0, 0.02),
            reason="first order in the step, over seven swings"),
        Row("DEM05, impacts at 45 to 70° that slide: largest error of u after / before", 0.0, DERIVED,
            f"{MFIX}, DEM05; 1 − μ (1 + e)/tan θ, μ 0.092, e 0.98", float(errors[0].max()), limits=(0.0, 0.01),
            reason="1 % of a speed, as the measured ones of Kharaz et al. 2001 scatter"),
        Row("Kratos 4, impacts at 2 to 70°, largest error of u after / before", 0.0, DERIVED,
            "one contact of a damped spring and a spring with a slider, in fine steps: Maw et al. 1976, linear",
            float(errors[1].max()), limits=(0.0, 0.01), reason="first order in the step, f 0.005"),
        Row("largest backward speed of the rim after an impact / (μ v_n)", None, "", "",
            float(-np.min(one["rim"])), reason="Maw et al. 1976 show it for Hertzian spheres: of discs it is larger"),
    ]  # fmt: skip


def flows(found: Found) -> list[Row]:
    """Columns, a bore, a jump and a crater."""
    spread = [mean_of([one["run_out"] for one in ones])[0] for name, ones in found.items() if "spread" in name]
    off = max(abs(one / np.mean(spread) - 1) for one in spread)
    made = [
        Row("dry columns, largest / smallest diameter 1.2 to 5: run-out of a spread off their mean", 0.0, LOOKED_UP,
            "Polanía et al. 2024, JFM 982 A40, abstract: not significantly affected", float(off),
            limits=(0.0, 0.1), reason="10 %: as far as starts of one spread lie apart")
    ] if len(spread) > 1 else []  # fmt: skip
    for name, ones in found.items():
        if name.startswith("layer"):
            still = float(name.split()[1])
            mean, half = mean_of([one["speed"] / stoker(still)[0] for one in ones])
            made.append(
                Row(f"dam break over {still / DEEP:.2f} of its depth: bore / Stoker's", 1.0, DERIVED,
                    "SPHERIC 5 (Jánosi et al. 2004), two of its layers; Stoker 1957", mean, half, (0.85, 1.15),
                    "15 %: fronts of discs are 8 to 11 % ahead of water's on a dry bed")
            )  # fmt: skip
    jumps = found["jump"]
    eta = [one["efficiency"] - efficiency(one["froude"]) for one in jumps]
    logs = [np.polyfit(np.log(of_start("fall", found, k)), np.log(of_start("depth", found, k)), 1)[0]
            for k in range(len(found[f"drop {DROPS[0]:g}"]))] if len(drops(found)) > 1 else []  # fmt: skip
    made += [
        Row("jump: length / y2", 6.0, SECOND_HAND,
            "about 6 (USBR EM 25); Bayon & López-Jiménez 2015, J. Hydroinf. 17:662, of rollers",
            *mean_of([one["length"] for one in jumps]), (4.8, 7.2), "20 %: ends of jumps are read so",
            "discs lose speed by collisions, and in a shorter way than water by eddies"),
        Row("jump: part of the head that is lost, less Bélanger's at its Froude number", 0.0, DERIVED,
            "Bayon & López-Jiménez 2015: above 98 % of measured ones; momentum of a hydrostatic jump", *mean_of(eta),
            (-0.05, 0.05), "0.05: what 10 % of the depth ratio makes"),
    ]  # fmt: skip
    if logs:
        made.append(
            Row("large grain on small ones: exponent of the depth over the whole fall", 1 / 3, LOOKED_UP,
                "Uehara et al. 2003, PRL 90 194301, spheres; check of Chrono::GPU (Processes 2021 9:1813)",
                *mean_of(logs), (0.23, 0.43), "0.1: a fit over a factor of eight, in two dimensions")
        )  # fmt: skip
    return made


def drops(found: Found) -> list[str]:
    """Points at which a grain falls."""
    return [name for name in found if name.startswith("drop")]


def of_start(key: str, found: Found, start: int) -> list[float]:
    """A number of one start at all drops."""
    return [found[name][start][key] for name in drops(found)]


def efficiency(froude: float) -> float:
    """Part of the head that a hydrostatic jump loses, 1 - E2/E1 with Bélanger's depth (Chow 1959, section 15-5)."""
    ratio = belanger(froude)
    return 1.0 - (ratio + froude**2 / (2 * ratio**2)) / (1 + froude**2 / 2)


def rows(found: Found) -> list[Row]:
    """Contacts, then flows."""
    return [*contacts(found), *flows(found)]


def figure(found: Found) -> Figure:
    """Draw impacts against their angle, run-out against the spread, and depth against fall."""
    with drawing(9.6, 3.4, 1, 3) as (made, (left, middle, right)):
        one = found["oblique"][0]
        fine = np.linspace(1, 75, 80)
        left.plot(fine, slider(list(fine), 4000), "-", color=GREY, label="spring and slider")
        left.plot(one["angles"], one["ratio"], "o", color=BLUE, mfc="none", label="ours")
        left.set(xlabel="angle from the normal [°]", ylabel="u after / before [1]", title="impacts, μ 0.092, e 0.98")
        left.legend()
        for name, ones in found.items():
            if name.startswith("spread"):
                out = [run["run_out"] for run in ones]
                middle.plot([float(name.split()[1])] * len(out), out, "o", color=BLUE, mfc="none")
        middle.set(xlabel="largest / smallest diameter [1]", ylabel="run-out / L [1]", title="dry columns",
                   ylim=(0, None))  # fmt: skip
        right.plot(of(found, "drop", "fall"), of(found, "drop", "depth"), "o", color=BLUE, mfc="none")
        fall = np.array(sorted(of(found, "drop", "fall")))
        scale = np.mean(of(found, "drop", "depth")) / np.mean(fall ** (1 / 3))
        right.plot(fall, scale * fall ** (1 / 3), "--", color=RED, label="exponent 1/3")
        right.set(xlabel="whole fall [m]", ylabel="depth [m]", title="large grain on small ones")
        right.legend()
    return made


LAW = Law(
    "Checks that others print",
    "Do discs pass the checks of MFiX, Kratos and Chrono, and what papers say of columns, bores and jumps?",
    points,
    rows,
    figure,
    (
        "Contacts are those of the native engine; chapter Contacts has the others. Spheres of the sources are discs "
        "here, and closed forms are those of discs.",
        "A published number of a measurement was not found for SPHERIC 5, nor for the spreads of Polanía et al.",
    ),
)
