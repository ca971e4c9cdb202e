# SPDX-License-Identifier: GPL-2.0-or-later
"""Whether velocity Verlet keeps small discs between large ones, as it does small spheres (Vyas et al. 2025)."""

from __future__ import annotations

from collections.abc import Iterable
from math import acos, atan, cos, degrees, isfinite, nan, radians
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from lammps_jump.analysis.draw.style import BLACK, BLUE, GOLD, GREY, drawing
from lammps_jump.engines import usable_kernels
from lammps_jump.studies.validation import DERIVED, LOOKED_UP, Found, Law, Point, Row, around, mean_of

RATIO, COARSE, FINE = 8.0, 0.1, 0.0125
"""Diameter of the large discs over that of the small ones, and the two steps over 2/omega."""
MENDED = "mended"
ENOUGH = 5.0
"""Friction with which a disc rolls and does not slide."""
NIP = {"ratio": RATIO, "friction": 0.4, "degrees": np.arange(16.0, 27.1, 0.5).tolist()}
LET_GO = degrees(atan(0.4))
"""Angle of the contacts above which friction 0.4 does not hold a disc, degrees."""
FALL = {"ratio": RATIO, "gap": 1.02, "count": 24, "friction": 0.5}
SEEDS = (1, 2, 3, 4, 5)
RISES = 0.05
"""Rise by which a small disc has been let go, diameters: one that is held gives way by a quarter of that."""
VYAS = "Vyas et al. 2025, Comput. Phys. Commun. 310, 109524"
MARKS = {"stock": ("o", BLUE, 9), "compiled": ("s", GOLD, 6), "native": ("x", BLACK, 4), MENDED: ("D", GREY, 3)}


def points(quick: bool) -> list[Point]:
    """Each scene at two steps on every engine, and on LAMMPS with the scheme of Vyas et al.; quick: at one, fewer."""
    usable = usable_kernels()[0]
    kernels = [*usable, *([MENDED] if "stock" in usable else [])]
    found = []
    for fraction in (COARSE,) if quick else (COARSE, FINE):
        for kernel in ["twin", *kernels] if fraction == COARSE and not quick else kernels:
            at = {"kernel": kernel, "fraction": fraction}
            where = f"{kernel} {fraction:g}"
            found.append(Point(f"nip {where}", "nip", options={**at, **NIP}))
            found.append(Point(f"moving {where}", "moving", options={**at, **NIP}))
            if not quick:
                found.append(Point(f"rolls {where}", "rolls", options={**at, "ratio": RATIO}, seconds=10))
            if kernel != "twin":
                found.append(Point(f"three {where}", "three", options={**at, **FALL}, seconds=2))
    if "stock" in usable:
        for friction, mended in ((0.2, False), (0.5, False), (0.5, True)):
            given = {"mended": mended, "friction": friction, "step": 1e-6}
            found.append(Point(f"spheres {friction:g} {'mended' if mended else 'stock'}", "spheres", options=given))
    return found if quick else [*found, *finer_rolls(kernels), *silos(kernels)]


def finer_rolls(kernels: list[str]) -> list[Point]:
    """More steps of the disc that rolls off another, of both schemes."""
    given = [{"kernel": kernel, "fraction": f, "ratio": RATIO} for kernel in ("native", MENDED) for f in (0.05, 0.025)]
    return [
        Point(f"rolls {one['kernel']} {one['fraction']:g}", "rolls", options=one, seconds=10)
        for one in given
        if one["kernel"] in kernels
    ]


def silos(kernels: list[str]) -> list[Point]:
    """The silo on every engine, and on the native one at the fine step too."""
    runs = [*((kernel, COARSE) for kernel in kernels), ("native", FINE)]
    return [
        Point(
            f"silo {kernel} {fraction:g} {seed}",
            "silo",
            options={"kernel": kernel, "fraction": fraction, "seed": seed},
            seconds=10 * COARSE / fraction,
        )
        for kernel, fraction in runs
        if kernel in kernels
        for seed in SEEDS
    ]


def of(found: Found, name: str) -> dict[str, Any]:
    """What was measured at the points of a name, by the rest of it: kernel and step."""
    return {point[len(name) + 1 :]: ones[0] for point, ones in found.items() if point.startswith(f"{name} ")}


def farthest(values: Iterable[float], exact: float) -> float:
    """The value farthest from the exact one; NaN where there are none."""
    return max(values, key=lambda value: abs(value - exact), default=nan)


def let_go(one: dict[str, Any]) -> float:
    """Angle of a nip between the last disc that is held and the first that is let go, degrees; NaN where they mix."""
    rises, angles = np.array(one["rise"]) > RISES, np.array(one["degrees"])
    first = int(np.argmax(rises))
    return float(0.5 * (angles[first - 1] + angles[first])) if rises[first:].all() and first else nan


def fell(one: dict[str, Any]) -> np.ndarray:
    """Times to fall through of those that have, s."""
    return np.array([time for time in one["times"] if time is not None and isfinite(time)])


def coarse_over_fine(found: Found, name: str, take) -> list[float]:
    """A number of each engine at the coarse step over that at the fine one; of the mended scheme none."""
    ones = of(found, name)
    pairs = [(ones[key], ones.get(f"{key.split()[0]} {FINE:g}")) for key in ones if key.endswith(f" {COARSE:g}")]
    kept = [key.split()[0] != MENDED for key in ones if key.endswith(f" {COARSE:g}")]
    return [take(one) / take(other) for (one, other), keep in zip(pairs, kept, strict=True) if keep and other]


def leaves_at(begin: float) -> float:
    """Angle at which a disc that rolls off a fixed one leaves it, degrees from the top; begun at rest, there too.

    (3/4) v^2 = g r (cos(begin) - cos(angle)) and v^2 = g r cos(angle).
    """
    return degrees(acos(4.0 / 7.0 * cos(radians(begin))))


def halves(found: Found, kernel: str, fraction: float) -> list[float]:
    """Times until half of a silo is out, s, a seed each."""
    return [one["half"] for name, one in of(found, "silo").items() if name.startswith(f"{kernel} {fraction:g} ")]


def silo_rows(found: Found) -> list[Row]:
    """The silo at two steps, and with the other scheme."""
    made = []
    for words, kernel, fraction, other in (
        ("silo of 1 : 8, time until half is out, f 0.1 over f 0.0125", "native", FINE, "native"),
        ("the same, f 0.1, ours over the scheme of Vyas et al.", MENDED, COARSE, "stock"),
    ):
        ours, theirs = halves(found, other, COARSE), halves(found, kernel, fraction)
        if ours and theirs:
            mean, half = mean_of((np.array(ours) / np.mean(theirs)).tolist())
            reason = "a start differs from another by 2 %; the means of five are known to 2 to 3 %"
            made.append(Row(words, 1.0, DERIVED, "a step changes no flow", mean, half, around(1.0, 0.05), reason))
    return made


def passing_rows(found: Found) -> list[Row]:
    """Whether small discs stay between large ones that stand and that move, and when a nip lets them go."""
    stay = farthest((len(one["times"]) - len(fell(one)) for one in of(found, "three").values()), 0.0)
    left = farthest((float(np.sum(np.array(one["speed"]) < 0.1)) for one in of(found, "moving").values()), 0.0)
    angle = farthest(map(let_go, of(found, "nip").values()), LET_GO)
    half = around(0.0, by=0.5)
    return [
        Row("small discs of 24 that stay between two fixed ones, gap 1.02 d", 0.0, DERIVED, "they fit through", stay,
            limits=half, reason="none may stay"),
        Row("angle of a nip that lets a small disc go, degrees", LET_GO, DERIVED, "arctan μ, μ 0.4", angle,
            limits=around(LET_GO, by=0.25), reason="angles are tried in steps of half a degree"),
        Row("small discs of 23 that stay between two that run at each other", 0.0, DERIVED, "large ones part, e 0.5",
            left, limits=half, reason="none may stay"),
    ]  # fmt: skip


def step_rows(found: Found) -> list[Row]:
    """What an eighth of the step changes."""
    exact, made = "the limit of small steps", []
    if ratios := coarse_over_fine(found, "three", lambda one: fell(one).mean()):
        words = "mean time to fall between two fixed ones, f 0.1 over f 0.0125"
        made.append(
            Row(words, 1.0, DERIVED, exact, farthest(ratios, 1.0), limits=around(1.0, 0.02),
                reason="bounces amplify the error of a step; 24 places")
        )  # fmt: skip
    if ratios := coarse_over_fine(found, "moving", lambda one: np.array(one["speed"])):
        words = "speed of small discs that two others throw out, f 0.1 over f 0.0125"
        made.append(
            Row(words, 1.0, DERIVED, exact, farthest(np.concatenate(ratios), 1.0), limits=around(1.0, 0.05),
                reason="first order in the step; farthest of 23")
        )  # fmt: skip
    return made


def rolling_rows(found: Found) -> list[Row]:
    """Where a disc that rolls off another leaves it, and what the spring of the contact gathers."""
    ones = of(found, "rolls")
    if not ones:
        return []
    made, angle = [], leaves_at(next(iter(ones.values()))["begin"])
    for fraction, limit, reason in (
        (FINE, 0.3, "the contact is 0.5 % deep"),
        (COARSE, 1.5, "the dashpot sees the half step: first order in f, see the notes"),
    ):
        ours = [one["angle"] for key, one in ones.items() if key.endswith(f" {fraction:g}") and MENDED not in key]
        words = f"angle at which a small disc that rolls off a large one leaves it, f {fraction:g}, degrees"
        source, limits = "cos = 4/7 of that at the start", around(angle, by=limit)
        made.append(Row(words, angle, DERIVED, source, farthest(ours, angle), limits=limits, reason=reason))
    excess = farthest((one["excess"] / one["way"] for one in ones.values()), 0.0)
    words, source = "what its spring gathers too much, over the way of the contact", "half of the changes of r, at most"
    made.append(Row(words, 0.0, DERIVED, source, excess, limits=around(0.0, by=1e-6), reason="a step adds r sin(a)"))
    return made


def sphere_rows(found: Found) -> list[Row]:
    """What the scheme does in three dimensions."""
    made = []
    spheres = of(found, "spheres")
    for name, words, published, kind, source in (
        ("0.5 stock", "small sphere that stays between two large ones, scheme of LAMMPS", 1.0, LOOKED_UP, VYAS),
        ("0.5 mended", "the same, scheme of Vyas et al.", 0.0, LOOKED_UP, VYAS),
        ("0.2 stock", "the same, scheme of LAMMPS, μ 0.2", 0.0, DERIVED, "the nip lets go above arctan μ"),
    ):
        if name in spheres:
            height = spheres[name]["height"]
            stays = float(height is not None and isfinite(height))
            limits, reason = around(published, by=0.5), "1: it stays; shows that the measure would see it"
            made.append(Row(words, published, kind, source, stays, limits=limits, reason=reason))
    return made


def rows(found: Found) -> list[Row]:
    """Each quantity at the engine, and the step, that is farthest from its exact value."""
    made = (passing_rows(found), step_rows(found), rolling_rows(found), silo_rows(found), sphere_rows(found))
    return [row for part in made for row in part]


def table(found: Found) -> list[list[str]]:
    """Heads and rows: what each engine gives at each step."""
    lines = [["engine", "f", "stay, of 24", "mean fall, s", "nip, degrees", "leaves at, degrees"]]
    three, nips, rolls = (of(found, name) for name in ("three", "nip", "rolls"))
    for key in nips:
        kernel, fraction = key.split()
        falls = three.get(key)
        lines.append([
            "stock, scheme of Vyas et al." if kernel == MENDED else kernel,
            fraction,
            str(len(falls["times"]) - len(fell(falls))) if falls else "–",
            f"{fell(falls).mean():.3f}" if falls else "–",
            f"{let_go(nips[key]):.2f}",
            f"{rolls[key]['angle']:.2f}" if key in rolls else "–",
        ])  # fmt: skip
    return lines


def figure(found: Found) -> Figure:
    """Draw the nip, the angle at which a disc that rolls leaves, and the silo."""
    with drawing(9.8, 3.5, 1, 3) as (made, axes):
        for draw, place in zip((draw_nip, draw_roll, draw_silo), axes, strict=True):
            draw(found, place)
            if place.get_legend_handles_labels()[1]:
                place.legend(fontsize=8)
    return made


LABELS = {MENDED: "scheme of Vyas et al.", "native": "ours"}


def draw_nip(found: Found, place) -> None:
    """Rise of small discs in nips, of each engine."""
    for key, one in of(found, "nip").items():
        kernel, fraction = key.split()
        mark, colour, size = MARKS.get(kernel, ("+", GREY, 6))
        if fraction == f"{COARSE:g}":
            place.plot(
                one["degrees"],
                one["rise"],
                mark,
                ms=size,
                mfc="none",
                color=colour,
                label=kernel if kernel != MENDED else LABELS[kernel],
            )
    place.axvline(LET_GO, color=GREY, ls="--", lw=1, label="arctan μ")
    place.set(xlabel="angle of the nip, degrees", ylabel="rise of the small disc / d [1]")
    place.set_title(f"two large ones close, f {COARSE:g}")


def draw_roll(found: Found, place) -> None:
    """Angle at which a disc leaves another, against the step, of both schemes."""
    for kernel, line in (("native", "-"), (MENDED, "--")):
        ones = {float(key.split()[1]): one for key, one in of(found, "rolls").items() if key.split()[0] == kernel}
        mark, colour, _ = MARKS[kernel]
        if steps := sorted(ones):
            angles = [ones[f]["angle"] for f in steps]
            place.plot(steps, angles, line + mark, color=colour, mfc="none", label=LABELS[kernel])
            place.axhline(leaves_at(ones[steps[0]]["begin"]), color=GREY, lw=1)
    place.set(xlabel="step over 2/ω, f [1]", ylabel="angle where it leaves, degrees", title="rolling off a large one")
    place.set_xlim(0, None)


def draw_silo(found: Found, place) -> None:
    """Mass in the bin over time, of each seed."""
    drawn = (("native", COARSE, BLUE, "-"), ("native", FINE, BLACK, "--"), (MENDED, COARSE, GOLD, ":"))
    for kernel, fraction, colour, line in drawn:
        for name, one in of(found, "silo").items():
            if name.startswith(f"{kernel} {fraction:g} "):
                label = f"{LABELS[kernel]}, f {fraction:g}" if name.endswith(f" {SEEDS[0]}") else None
                place.plot(one["time"], one["mass"], line, color=colour, lw=1, label=label)
    place.set(xlabel="time, s", ylabel="mass in the bin / at the start [1]", title="silo of 1 : 8")


LAW = Law(
    "Small between large",
    "Does the half step of velocity Verlet keep small discs between large ones, as it does small spheres?",
    points,
    rows,
    figure,
    (
        "Diameters 1 : 8, springs along contacts, spin. f is the step over 2/ω; every engine at 0.1 and 0.0125, the "
        "twin at 0.1. The page on small discs between large ones derives why discs are free of it.",
        "The scheme of Vyas et al. is the word synchronized_verlet of LAMMPS’ pair style granular, in the stock script "
        "of the same scene.",
        "Two fixed discs with a gap; two large circles that close on a small disc, slowly and without turning; two "
        "large free ones that run at each other; a small disc that rolls off a large one; a silo.",
        "Where a disc rolls off another, the dashpot sees an opening speed of v² dt/(2 r) that is not there, and holds "
        "it: by the share ξ ω dt of what bends its way. That is first order in the step, the same at every size ratio.",
        "Spheres: 0.5 mm on two fixed ones of 10 mm that touch, e 0.5. Their nip of 17.8 degrees is below arctan μ for "
        "μ 0.5, so that what pulls them in is held by the friction that it makes. μ 0.2 does not hold it.",
    ),
    table,
)
