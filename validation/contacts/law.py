# SPDX-License-Identifier: GPL-2.0-or-later
"""Contacts of one and two discs against their closed forms, on every engine that runs here."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from math import atan, atan2, cos, degrees, exp, nan, pi, sqrt
from operator import itemgetter
from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure

from lammps_jump.analysis.draw.style import BLACK, BLUE, GOLD, GREY, drawing
from lammps_jump.engines import usable_kernels
from lammps_jump.physics.contact import damping_ratio
from lammps_jump.studies.validation import DERIVED, Found, Law, Point, Row, around, number, ours_text

RESTITUTIONS = (0.2, 0.4, 0.6, 0.8, 1.0)
OBLIQUE = {"restitution": 0.6, "friction": 0.3}
SLIPS = (0.5, 1.0, 2.0, 3.0, 4.0, 6.0, 7.0, 8.0, 10.0, 12.0)
SPUN = (0.2, 0.5, 1.0, 4.0, 6.0, 8.0, 10.0, 12.0)
"""Slips at the first impact, which gives the spin."""
ROLLING, ANGLES = 0.05, (2.8, 3.0, 3.4, 3.8)
RATIO = 2.0 / 7.0
CHUNG = "after Chung & Ooi 2011, Granular Matter 13:643"
MARKS = {"stock": ("o", BLUE, 9), "compiled": ("s", GOLD, 6), "native": ("x", BLACK, 4)}


def points(quick: bool) -> list[Point]:
    """Every test on every engine; quick: on the two fast ones, and one restitution."""
    found = []
    for kernel in usable_kernels()[0]:
        if quick and kernel == "native":
            continue  # the two fast ones are enough
        on = {"kernel": kernel}
        for e in (0.6,) if quick else RESTITUTIONS:
            given = {**on, "restitution": e, "fraction": 0.01}
            found.append(Point(f"pair {e:g} {kernel}", "head_on", options=given))
            found.append(Point(f"floor {e:g} {kernel}", "at_the_floor", options=given))
        found.append(Point(f"sliding {kernel}", "sliding", options={**on, **OBLIQUE, "slips": list(SLIPS)}))
        given = {**on, **OBLIQUE, "slips": list(SPUN)}
        found.append(Point(f"lid {kernel}", "with_spin_at_a_lid", options=given))
        found.append(Point(f"alike {kernel}", "with_spin_at_each_other", options={**given, "alike": True}))
        found.append(Point(f"unlike {kernel}", "with_spin_at_each_other", options={**given, "alike": False}))
        found.append(Point(f"elastic pair {kernel}", "elastic", options={**on, "pair": True}))
        found.append(Point(f"elastic floor {kernel}", "elastic", options={**on, "pair": False}))
        found.append(Point(f"rebound spin {kernel}", "rebound", options={**on, "spin": True}))
        found.append(Point(f"rebound bare {kernel}", "rebound", options={**on, "spin": False}))
        found.append(Point(f"roll {kernel}", "slide_to_roll", options={**on, "friction": 0.3}))
        found.append(Point(f"slope {kernel}", "rest_on_a_slope", options={**on, "degrees": 20.0}))
        found.append(
            Point(f"onset {kernel}", "roll_on_slopes", options={**on, "friction": ROLLING, "degrees": list(ANGLES)})
        )
    return found


def tail_factor(restitution: float) -> float:
    """Impulse of |F_n| over m (1 + e) v: a contact that ends at zero overlap pulls at its end; friction sees |F_n|."""
    xi = damping_ratio(restitution)
    s = sqrt(1.0 - xi**2)
    clipped = exp(-(xi / s) * (pi - atan2(2 * xi * s, 1 - 2 * xi**2)))
    return (1.0 + 2.0 * clipped - restitution) / (1.0 + restitution)


KICK = tail_factor(OBLIQUE["restitution"]) * (1.0 + OBLIQUE["restitution"])
"""Change of the speed along the floor of a disc that slides, over mu times its speed of impact."""


def after(slip: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Speed along the floor and of the rim after an impact, over mu v_n: it slides throughout, or sticks."""
    slides = slip > 3.0 * KICK
    return np.where(slides, slip - KICK, 2.0 * slip / 3.0), np.where(slides, -2.0 * KICK, -2.0 * slip / 3.0)


def kick(slip: np.ndarray, speed: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Change of speed along a wall by the impulse of friction at a speed of impact, and the slip over its unit mu v_n.

    It takes the slip away, a third of it from the speed of the disc, unless friction slides throughout.
    """
    unit = OBLIQUE["friction"] * speed
    return -np.sign(slip) * np.minimum(np.abs(slip) / 3.0, KICK * unit), np.abs(slip) / unit


def clear(slip: np.ndarray) -> np.ndarray:
    """Slips, over mu v_n, at which it is certain whether friction slides throughout (`rows`)."""
    return (slip < 2.0 * KICK) | (slip > 3.3 * KICK)


def lid_off(one: dict[str, Any]) -> float:
    """Largest error over mu v_n of speed and rim behind an impact of spinning discs on a lid."""
    before, after = ({name: np.array(values) for name, values in one[key].items()} for key in ("before", "after"))
    change, slip = kick(before["u"] - before["rim"], before["v"])
    errors = np.array([after["u"] - before["u"] - change, after["rim"] - before["rim"] + 2.0 * change])
    return float(np.abs(errors / (OBLIQUE["friction"] * before["v"]))[:, clear(slip)].max())


def pair_off(one: dict[str, Any]) -> float:
    """Largest error over mu v_n of the velocities along the contact and of the rims behind impacts of two discs."""
    (a, b), (left, right) = (
        [{name: np.array(values) for name, values in state.items()} for state in one[key]]
        for key in ("before", "after")
    )
    (x, y), (u, v) = ([b[name] - a[name] for name in names] for names in (("x", "y"), ("u", "v")))
    square, product = u * u + v * v, x * u + y * v
    time = (-product - np.sqrt(product**2 - square * (x * x + y * y - 1.0))) / square
    nx, ny = x + u * time, y + v * time  # from the one to the other when they touch, of length d = 1
    slip = -(u * ny - v * nx) - a["rim"] - b["rim"]
    change, slips = kick(slip, -(u * nx + v * ny))
    errors = []
    for before, after, sign in ((a, left, 1.0), (b, right, -1.0)):
        along = (after["u"] - before["u"]) * ny - (after["v"] - before["v"]) * nx
        errors += [along - sign * 0.5 * change, after["rim"] - before["rim"] + change]
    unit = -OBLIQUE["friction"] * (u * nx + v * ny)
    return float(np.abs(np.array(errors) / unit)[:, clear(slips)].max())


def left_of_slip(spin: bool) -> float:
    """Speed along the floor after an impact on a bare tangential spring, over that before."""
    share = 3.0 if spin else 1.0
    return 1.0 + (cos(pi * sqrt(share * RATIO)) - 1.0) / share


def of(found: Found, name: str) -> dict[str, Any]:
    """What was measured at the points of a name, by the rest of it: engine, with restitution."""
    return {point[len(name) + 1 :]: ones[0] for point, ones in found.items() if point.startswith(f"{name} ")}


def farthest(values: Iterable[float], exact: float) -> float:
    """The value farthest from the exact one."""
    return max(values, key=lambda value: abs(value - exact))


def oblique_off(one: dict[str, Any], select: Callable[[np.ndarray], np.ndarray]) -> float:
    """Largest deviation from `after` among some of the slips."""
    slip, along, rim = (np.array(one[key]) for key in ("slip", "along", "rim"))
    chosen = select(slip)
    return float(np.abs(np.array([along, rim]) - np.array(after(slip)))[:, chosen].max())


def onset_of(angles: list[float], speeds: list[float]) -> float:
    """Angle at which the line through those that roll has speed 0, degrees; NaN where the first one rolls."""
    if speeds[0] > 1e-9:
        return nan
    slope, offset = np.polyfit(angles[1:], speeds[1:], 1)
    return float(-offset / slope)


class Quantity(NamedTuple):
    """A number with an exact value: by engine, the one among its runs that is farthest from it.

    `test` is that of Chung & Ooi's eight which it stands for.
    """

    name: str
    test: str
    exact: float
    source: str
    ours: Mapping[str, float]
    tolerance: float
    reason: str

    def row(self, value: float) -> Row:
        """The row of a value."""
        limits = around(self.exact, by=self.tolerance)
        source = f"{self.source}; test{'s' * ('and' in self.test)} {self.test} {CHUNG}" if self.test else self.source
        return Row(self.name, self.exact, DERIVED, source, value, limits=limits, reason=self.reason)


def by_engine(found: Found, name: str, take: Callable[[dict[str, Any]], float], exact: float) -> dict[str, float]:
    """The farthest value of each engine at the points of a name."""
    values: dict[str, list[float]] = {}
    for point, one in of(found, name).items():
        values.setdefault(point.split()[-1], []).append(take(one))
    return {engine: farthest(ones, exact) for engine, ones in values.items()}


def quantities(found: Found) -> list[Quantity]:
    """Return what is held against exact values, in the order of the table."""

    def of_runs(name, test, exact, source, runs, take, tolerance, reason) -> Quantity:
        return Quantity(name, test, exact, source, by_engine(found, runs, take, exact), tolerance, reason)

    def oblique(select: Callable[[np.ndarray], np.ndarray]) -> Callable[[dict[str, Any]], float]:
        return lambda one: oblique_off(one, select)

    collision, impulse = "docs/theory.md: one collision, exactly", "impulses of rigid discs (docs/theory.md)"
    return [
        of_runs("two discs, restitution out / in", "3", 1.0, "what comes out is what goes in", "pair",
            itemgetter("restitution"), 0.005, "mean over 64 entry phases at f 0.01; phases alone 0.5 %"),
        of_runs("disc on a floor, restitution out / in", "3", 1.0, "what comes out is what goes in", "floor",
            itemgetter("restitution"), 0.005, "mean over 16 entry phases at f 0.01"),
        of_runs("two discs, duration / closed form", "", 1.0, collision, "pair",
            itemgetter("duration"), 0.01, "a step is 1/350 of the contact"),
        of_runs("two discs, largest overlap / closed form", "", 1.0, collision, "pair",
            itemgetter("overlap"), 0.006, "the dashpot lags by half a step: first order in f"),
        of_runs("oblique impact that slides, largest error over μ v_n", "4 and 5", 0.0, impulse, "sliding",
            oblique(lambda s: s > 3.3 * KICK), 0.05, "1 % of the kick of 1.7 to 3.3 μ v_n"),
        of_runs("oblique impact that sticks, largest error over μ v_n", "4 and 5", 0.0, impulse, "sliding",
            oblique(lambda s: s < 2.0 * KICK), 0.05,
            "slip dies out exponentially; above 2/3 of the limit of sliding it has no time to"),
        of_runs("elastic impact of two discs, overlap off half a sine / largest", "1", 0.0, "a linear spring",
            "elastic pair", itemgetter("overlap"), 5e-4, "second order in the step: 1e-4 at f 0.01"),
        of_runs("elastic impact on a floor, overlap off half a sine / largest", "2", 0.0, "a linear spring",
            "elastic floor", itemgetter("overlap"), 5e-4, "second order in the step: 1e-4 at f 0.01"),
        of_runs("discs with spin on a lid, largest error over μ v_n", "6", 0.0, impulse, "lid", lid_off, 0.05,
            "as for impacts without spin"),
        of_runs("two discs with the same spin, largest error over μ v_n", "7", 0.0, impulse, "alike", pair_off, 0.05,
            "as for impacts on a wall"),
        of_runs("a disc with spin on one without, largest error over μ v_n", "8, with equal discs,", 0.0, impulse,
            "unlike", pair_off, 0.05, "as for impacts on a wall"),
        of_runs("impact on a tangential spring, with spin, u after / before", "", left_of_slip(True),
            "half a swing of the spring", "rebound spin", itemgetter("along"), 3e-3,
            "f 0.005; the contact turns by a thousandth"),
        of_runs("impact on a tangential spring, no spin, u after / before", "", left_of_slip(False),
            "half a swing of the spring", "rebound bare", itemgetter("along"), 3e-3,
            "f 0.005; the contact turns by a thousandth"),
        of_runs("from sliding to rolling, u at the end / start", "", 2 / 3, "2/3 for a disc (5/7 for a sphere)", "roll",
            itemgetter("end"), 4e-4, "the shear dashpot leaves no slip"),
        of_runs("from sliding to rolling, 3 μ g t/u0", "", 1.0, "u falls by μ g a second", "roll", itemgetter("time"),
            0.0057, "half a kick at the first step, and the time in which the spring stretches"),
        of_runs("rest on a slope of 20 degrees, way / (m g sin/kt)", "", 1.0, "weight along the slope in the spring",
            "slope", itemgetter("way"), 1e-3, "six digits of the dump: 1e-4"),
        of_runs("rest on a slope of 20 degrees, speed / sqrt(g d)", "", 0.0, "a spring creeps nowhere", "slope",
            itemgetter("speed"), 1e-9, "rounding"),
        of_runs("angle at which a disc begins to roll, degrees", "", degrees(atan(ROLLING)),
            "tan = rolling friction 0.05", "onset", lambda one: onset_of(one["degrees"], one["speed"]), 0.02,
            "it rests at 2.8 degrees; the speeds at 3.0 to 3.8 degrees are drawn down to 0"),
    ]  # fmt: skip


def rows(found: Found) -> list[Row]:
    """Each quantity at the engine, and the restitution, that is farthest from its exact value."""
    return [one.row(farthest(one.ours.values(), one.exact)) for one in quantities(found)]


def table(found: Found) -> list[list[str]]:
    """Heads and rows: each quantity with its exact value on each engine, and its number in Chung & Ooi's tests."""
    found_ones = quantities(found)
    engines = [engine for engine in MARKS if engine in found_ones[0].ours]
    heads = ["quantity", "Chung & Ooi", "exact", *engines]
    lines = [
        [
            one.name,
            one.test.split(",")[0] or "–",
            number(one.exact),
            *(ours_text(vars(one.row(one.ours[engine]))) for engine in engines),
        ]
        for one in found_ones
    ]
    return [heads, *lines]


def figure(found: Found) -> Figure:
    """Draw restitution, oblique impacts, and a disc that comes to roll."""
    with drawing(9.6, 3.4, 1, 3) as (made, axes):
        for name, one in of(found, "pair").items():
            e, kernel = name.split()
            mark, colour, size = MARKS[kernel]
            label = kernel if e == "0.6" else None
            axes[0].plot(float(e), one["restitution"] * float(e), mark, ms=size, mfc="none", color=colour, label=label)
        axes[0].plot((0, 1), (0, 1), color=GREY, lw=1)
        axes[0].set(xlabel="restitution asked for [1]", ylabel="restitution measured [1]", title="two discs, head-on")
        slip = np.linspace(0, max(SLIPS), 400)
        for line, look in zip(after(slip), ("-", "--"), strict=True):
            axes[1].plot(slip, np.abs(line), look, color=GREY)
        for kernel, one in of(found, "sliding").items():
            mark, colour, size = MARKS[kernel]
            axes[1].plot(one["slip"], one["along"], mark, ms=size, mfc="none", color=colour)
            axes[1].plot(one["slip"], np.abs(one["rim"]), mark, ms=size, mfc="none", color=colour)
        axes[1].annotate("along the floor", (9.0, 7.4), ha="right", fontsize=8)
        axes[1].annotate("of the rim", (9.0, 2.6), ha="right", fontsize=8)
        axes[1].set(xlabel="speed along the floor before / (μ v$_n$) [1]", ylabel="speed after / (μ v$_n$) [1]")
        axes[1].set_title("oblique impact, e 0.6, μ 0.3")
        for kernel, one in of(found, "roll").items():
            mark, colour, size = MARKS[kernel]
            axes[2].plot(one["t"][::4], one["u"][::4], mark, ms=size, mfc="none", color=colour, label=kernel)
        axes[2].plot((0, 1, 3), (1, 2 / 3, 2 / 3), color=GREY, lw=1, label="closed form")
        axes[2].set(xlabel="3 μ g t/u$_0$ [1]", ylabel="speed / u$_0$ [1]", title="from sliding to rolling")
        axes[2].legend()
    return made


LAW = Law(
    "Contacts",
    "Do one and two discs do what the contact law says, on every engine?",
    points,
    rows,
    figure,
    (
        "Lines: closed forms. Marks: engines. The table at the top has the engine, and the restitution, that is "
        "farthest from the closed form. The table here has every engine.",
        "Chung & Ooi published eight tests of single impacts. Their numbers were read in the benchmarks of Kratos, "
        "YADE and PySPH, and not in the paper. The tests are of spheres with Hertz-Mindlin contacts. Here they stand "
        "for discs with linear springs.",
        "A disc has I = m R²/2. So it rolls at 2/3 of its speed, and slides throughout an impact above "
        "3 μ (1 + e) v_n A. A = 1.04 at e 0.6, because a contact that ends at zero overlap pulls at its end.",
        "Tests 1 and 2: elastic impacts. A linear spring gives half a sine in place of Hertz' force. Test 3: "
        "restitution. Tests 4 and 5: oblique impacts at one speed, and at one normal speed. Over μ v_n they are the "
        "same curve, because the law is linear.",
        "Tests 6 and 7: spin before an impact on a wall, and of two equal discs. No scene starts with spin, so a "
        "first impact gives it. What is before the second impact is read from a frame.",
        "Test 8 is of two sizes. Here equal discs differ in their spin: a scene that is made by hand has one size.",
    ),
    table,
)
