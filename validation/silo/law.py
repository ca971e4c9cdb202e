# SPDX-License-Identifier: GPL-2.0-or-later
"""Grains that leave a bin through a slot: outflow against width of the slot, and against fill."""

from __future__ import annotations

from itertools import pairwise
from math import nan
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from lammps_jump.analysis.draw.style import BLUE, GOLD, GREY, RED, drawing
from lammps_jump.studies.validation import LOOKED_UP, SECOND_HAND, Found, Law, Point, Row, mean_of

from .measure import discharge

WIDTH, DIAMETER = 4.2, 0.1
"""Of the bin and of a disc, m."""
SLOTS = (6, 8, 10, 12)
"""Widths of slots, diameters."""
LONG = (8.0, 6.0, 4.5, 3.6)
"""Times of their runs, s: about as many discs leave."""
TALL, TALL_SLOT = 9.0, 9
"""Height of the discs in the bin whose fill is varied, m, and its slot, diameters."""
BEGIN = 1.8
"""Time at which the outflow is steady, s: the slide goes at 1 s."""
EVEN = 1.4
"""Diameters by which a slot is narrower for discs than it is."""
CONTINUUM = ((0.314, 0.298), (0.470, 0.515), (0.627, 0.776), (0.783, 1.067), (0.939, 1.385), (1.095, 1.723))
"""Width of the slot and outflow of a continuum with mu(I) (0.32, 0.28, I0 0.4), d 1/30, g 1: a Basilisk page."""
SPAN = (1.2, 1.8)
"""Fill over the width of the bin, in which the outflow must not change."""


def point(slot: float, height: float, duration: float, starts: int) -> Point:
    """A bin with this slot (diameters), filled to this height (m), that runs out for so long (s)."""
    half = 0.5 * slot * DIAMETER
    changes = {
        "walls.left.points": [[-2.1, 18], [-2.1, 0], [-half, 0]],
        "walls.right.points": [[half, 0], [2.1, 0], [2.1, 18]],
        "initial.0.y": [0.05, height],
        "run.duration": duration,
        "analysis.window": [BEGIN, duration],
    }
    name = f"slot {slot:g}" + (", fill" if height == TALL else "")
    return Point(
        name, "empties", "silo.yaml", changes, starts, {"width": WIDTH, "begin": BEGIN}, seconds=2.5 * duration
    )


def points(quick: bool) -> list[Point]:
    """Four slots, and one bin that empties longer; quick: three slots, less filled, one start each."""
    if quick:
        return [point(slot, 2.5, 2.6, 1) for slot in SLOTS[:3]]
    found = [point(slot, 7.5 if slot < 12 else 8.0, duration, 3) for slot, duration in zip(SLOTS, LONG, strict=True)]
    return [*found, point(TALL_SLOT, TALL, 8.5, 3)]


def by_slot(found: Found) -> dict[float, list[Any]]:
    """Starts by the width of the slot, diameters."""
    return {float(name.split()[1]): list(ones) for name, ones in found.items() if "fill" not in name}


def exponents(found: Found, narrower: float) -> list[float]:
    """Exponent of the outflow over the slot, made narrower by some diameters; one for each start."""
    slots = by_slot(found)
    width = np.log(np.array(list(slots)) - narrower)
    return [
        float(np.polyfit(width, np.log([one["outflow"] for one in ones]), 1)[0])
        for ones in zip(*slots.values(), strict=False)
    ]


def numbers(found: Found) -> list[float]:
    """C of each start and slot, W = C rho_b sqrt(g) (D - 1.4 d)^1.5."""
    return [one["outflow"] / (slot - EVEN) ** 1.5 for slot, ones in by_slot(found).items() for one in ones]


def flow_by_fill(one: dict[str, Any], pieces: int = 5) -> tuple[np.ndarray, np.ndarray]:
    """Fill and outflow in equal times."""
    t, level, mass = (np.array(one[key]) for key in ("time", "level", "mass"))
    edges = np.linspace(BEGIN, t[-1], pieces + 1)
    spans = list(pairwise(edges))
    fills = [float(level[(t >= low) & (t <= high)].mean()) for low, high in spans]
    return np.array(fills), np.array([discharge(t, mass, low, high) for low, high in spans])


def change_with_fill(one: dict[str, Any]) -> float:
    """Outflow in the lower half of `SPAN` over that in its upper half, less 1; NaN where it is short."""
    t, level, mass = (np.array(one[key]) for key in ("time", "level", "mass"))
    inside = t[(t >= BEGIN) & (level > SPAN[0]) & (level < SPAN[1])]
    if len(inside) < 20:
        return nan
    half = 0.5 * (inside[0] + inside[-1])
    return discharge(t, mass, half, inside[-1]) / discharge(t, mass, inside[0], half) - 1


def rows(found: Found) -> list[Row]:
    """Exponent, constant, and what fill does."""
    source = "Beverloo, Leniger & van de Velde 1961 in two dimensions, as in Dunatunga & Kamrin 1411.5447 eq. 4.4"
    made = [
        Row("exponent of outflow over D − 1.4 d", 1.5, SECOND_HAND, source, *mean_of(exponents(found, EVEN)),
            (1.35, 1.65), "k is 1.4 to 1.5 in textbooks; between 1 and 2 it changes the exponent by 0.1"),
    ]  # fmt: skip
    made += [
        Row(f"exponent of outflow over D − {narrower:g} d", None, "", "", *mean_of(exponents(found, narrower)),
            reason="shows what the choice of k does") for narrower in (0.0, 1.0, 2.0)
    ]  # fmt: skip
    made.append(
        Row("C of outflow = C ρ_b √g (D − 1.4 d)^1.5", None, "", "", *mean_of(numbers(found)),
            reason="0.55 to 0.65 is of three dimensions; none was found for discs")
    )  # fmt: skip
    filled = [one for name, ones in found.items() if "fill" in name for one in ones]
    if filled:
        made.append(
            Row("change of the outflow, fill 1.2 to 1.5 widths over 1.5 to 1.8", 0.0, LOOKED_UP,
                "Mankoc et al. 2007, 0707.4550, sec. I: independent above 1.2 widths",
                *mean_of([change_with_fill(one) for one in filled]), (-0.05, 0.05), "5 % was set before the runs",
                "outflow falls a little while the bin empties; three starts do not tell it from none")
        )  # fmt: skip
    return made


def figure(found: Found) -> Figure:
    """Draw outflow against slot, and against fill."""
    slots = by_slot(found)
    with drawing(9.2, 3.8, 1, 2) as (made, (left, right)):
        width = np.linspace(4, 15, 100)
        mean = mean_of(numbers(found))[0]
        left.plot(width, mean * (width - EVEN) ** 1.5, color=GREY, label=f"{mean:.2f} (D/d − 1.4)$^{{1.5}}$")
        for slot, ones in slots.items():
            value, half = mean_of([one["outflow"] for one in ones])
            label = "ours" if slot == SLOTS[0] else None
            left.errorbar(slot, value, yerr=half if half == half else 0, fmt="o", color=BLUE, capsize=2, label=label)
        d = 1 / 30
        theirs = np.array([(w / d, q / d**1.5) for w, q in CONTINUUM[:2]])
        left.plot(*theirs.T, "s", color=GOLD, mfc="none", label="continuum with μ(I), Basilisk")
        left.set(xlabel="width of the slot D/d [1]", ylabel="outflow W / (ρ$_b$ √g d$^{1.5}$) [1]", title="slot")
        left.legend()
        for name, ones in found.items():
            if "fill" not in name:
                continue
            for one, mark in zip(ones, "osD", strict=False):
                right.plot(*flow_by_fill(one), mark, mfc="none", color=BLUE)
        right.axvline(SPAN[0], color=RED, ls="--", lw=1)
        right.annotate("1.2 widths", (SPAN[0], 0.03), (3, 0), xycoords=("data", "axes fraction"),
                       textcoords="offset points", color=RED, fontsize=8)  # fmt: skip
        right.set(xlabel="fill / width of the bin [1]", ylabel="outflow W / (ρ$_b$ √g d$^{1.5}$) [1]")
        right.set_ylim(0, 1.25 * right.get_ylim()[1])
        right.set_title(f"fill, slot {TALL_SLOT} d")
    return made


LAW = Law(
    "Silo",
    "Does the outflow of a bin grow with the slot to the power 1.5, whatever the fill?",
    points,
    rows,
    figure,
    (
        "Discs of ± 20 %, μ 0.5 on discs and walls, e 0.5, spin, springs along contacts; flat floor, bin 42 d wide. "
        "ρ_b is the bulk density measured between 10 and 30 d over the slot; a disc counts with ρ d².",
        "The bin is wider than 2.5 D and than D + 30 d (Mankoc et al. 2007). Slots are 6 d and wider: below, arches "
        "form, and no statistics of them come in seconds.",
        "The continuum flows out twice as fast at the same D/d. Its friction differs, and whether its width is that of "
        "half a slot could not be told: it is no gate.",
    ),
)
