# SPDX-License-Identifier: GPL-2.0-or-later
"""Figures of a cross-validation: divergence, profiles with bands, histories, what the laws change."""

from __future__ import annotations

from math import isfinite, nan
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from lammps_jump.analysis.draw.chart import PLACE, TIME, Chart, Line, Panel
from lammps_jump.analysis.draw.style import BLUE, GOLD, GREY, RED, drawing, drawn, save

from .ensembles import Study
from .quantities import Comparison, Curve, relative_size
from .trajectories import AGREEMENT, CONTACT_STEPS, Divergence, Growth

SHOWN = {"lammps_stock": "LAMMPS (stock)", "lammps_compiled": "LAMMPS (compiled kernel)", "native": "native engine"}
DIVERGENCE = "How the engines part, disc by disc"
LAW_FIGURES = ("What the choice of law, integrator and correction changes", "Depth profiles of the laws")
DEPTH = "mass_depth profile"


def draw_all(study: Study, part: Divergence, found: Comparison, folder: Path) -> dict[str, Path]:
    """Draw what the study has; returns file by title, in the order of the report."""
    folder.mkdir(parents=True, exist_ok=True)
    profiles = [name for name in found.bands if name.endswith("profile")]
    times = [name for name in found.bands if found.bands[name][0].axis == "t"]
    leading = [name for name in times if "front" in name or "toe" in name]
    figures = {"divergence": divergence(study, part)}
    curves = {
        "profiles": ("Profiles along the channel, mean over the window", profiles),
        "front": ("Toe of the jump" if "jump toe history" in leading else "Front", leading),
        "histories": ("Histories", [name for name in times if name not in leading]),
    }
    for file, (title, names) in curves.items():
        figures |= {file: means(title, found, names), f"{file}_differences": gaps(title, found, names)} if names else {}
    laws = {label: comparison for label, (_, comparison) in study.laws.items()}
    if any(DEPTH in law.bands for law in laws.values()):
        figures["law_profiles"] = law_profiles(laws)
    files = {chart.title: save(drawn(chart), folder / f"{name}.png") for name, chart in figures.items()}
    files["Differences of all numbers"] = save(forest({"": found}), folder / "differences.png")
    return files | ({LAW_FIGURES[0]: save(forest(laws), folder / "laws.png")} if laws else {})


def divergence(study: Study, part: Divergence) -> Chart:
    """Describe separation against time, with its twin, and the stretch in which the engines must agree."""
    scene, found = study.scene, part.found
    rows = (
        (part.engines, found["growth"], "first", f"LAMMPS ({found['kernel']}) from native"),
        (part.twin, found["twin_growth"], "second", "native from native, start off by the last digits"),
    )
    lines = [
        Line(f"{label}{_rate(growth)}", scene.time(0) + run.steps * scene.time_step,
             np.log10(np.where(run.largest > 0, run.largest, nan)), look)
        for run, growth, look, label in rows
    ]  # fmt: skip
    begin = next((check.first_contact for check in study.checks if check.name == scene.name), None)
    steps = {} if begin is None else {"first contact": begin, f"{CONTACT_STEPS} steps later": begin + CONTACT_STEPS}
    y, marks = "log10 of the largest distance\nof a disc's two places [d]", {t: scene.time(s) for t, s in steps.items()}
    limits = -17.0, 1.0 + max(0.0, *(np.nanmax(line.y, initial=0.0) for line in lines))
    agreed = {f"must agree to {AGREEMENT:g} d": np.log10(AGREEMENT)}
    panel = Panel(y, lines, levels=agreed, marks=marks, y_limits=limits)
    return Chart(DIVERGENCE, TIME, [panel])


def _rate(growth: Growth) -> str:
    return f" (e-fold in {1.0 / growth.rate:.3g} s)" if growth.rate > 0 else ""


def _label(name: str, curve: Curve) -> str:
    words = name.removesuffix(" profile").removesuffix(" history").replace("_", " ")
    return f"{words}{' energy' if curve.unit == 'J/m' else ''} [{curve.unit}]".replace(" [1]", "").replace("m2/", "m²/")


def _abscissa(found: Comparison, names: list[str]) -> str:
    return TIME if found.bands[names[0]][0].axis == "t" else PLACE


def means(title: str, found: Comparison, names: list[str]) -> Chart:
    """Describe the mean of each ensemble with a band of one standard deviation: two of a half."""
    panels = []
    for name in names:
        curve, band = found.bands[name]
        sides = ((band.mean_1, band.deviation_1, "first"), (band.mean_2, band.deviation_2, "second"))
        labels = (SHOWN.get(label, label) for label in found.ensembles)
        lines = [
            Line(label, curve.at, mean, look, 0.5 * s) for label, (mean, s, look) in zip(labels, sides, strict=True)
        ]
        panels.append(Panel(_label(name, curve), lines))
    return Chart(f"{title}; band: ± 1 s.d. of the members", _abscissa(found, names), panels)


def gaps(title: str, found: Comparison, names: list[str]) -> Chart:
    """Describe the difference of each curve with its interval, 95 % for all points at once."""
    panels = []
    for name in names:
        curve, band = found.bands[name]
        line = Line("", curve.at, band.difference, "sum", 0.5 * band.half_width)
        panels.append(Panel(_label(name, curve), [line]))
    return Chart(f"{title}: native minus LAMMPS, 95 % for all at once", _abscissa(found, names), panels)


def forest(comparisons: dict[str, Comparison]) -> Figure:
    """Draw the relative difference of every number with its confidence interval."""
    rows = [
        (label, row["name"], row["difference"] / size, row["half_width"] / size, row["verdict"] == "differ")
        for label, found in comparisons.items()
        for row in found.quantities
        if row["kind"] == "scalar" and isfinite(row["half_width"]) and (size := 0.01 * (relative_size(row) or 0.0))
    ]
    table = pd.DataFrame(rows, columns=["label", "name", "share", "half", "differs"])
    names, shift = list(dict.fromkeys(table.name)), 0.8 / len(comparisons)
    looks = ((BLUE, "o"), (GOLD, "s"), (GREY, "^"), (RED, "D"))
    with drawing(7.6, 0.26 * len(names) * max(1, 0.6 * len(comparisons)) + 1.2) as (figure, axes):
        for index, (label, part) in enumerate(table.groupby("label", sort=False)):
            colour, mark = looks[index % len(looks)]
            y = -part.name.map(names.index) - index * shift
            bars = {"xerr": part.half, "fmt": mark, "color": colour, "ms": 4, "lw": 1.1, "capsize": 2}
            axes.errorbar(part.share, y, label=label or None, **bars)
            axes.plot(part.share[part.differs], y[part.differs], mark, ms=9, mfc="none", mec=RED)
        widest = max(1.0, (table.share.abs() + np.minimum(table.half, 3 * table.share.abs() + 5)).max())
        axes.axvline(0.0, color=GREY, lw=0.8)
        axes.set_yticks([-k - 0.4 + 0.5 * shift for k in range(len(names))], names)
        xlabel = "difference, % of the quantity, with its 95 % interval (red ring: differs)"
        axes.set(xlim=(-1.1 * widest, 1.1 * widest), xlabel=xlabel)
        if any(comparisons):
            axes.legend(loc="best")
    return figure


def law_profiles(laws: dict[str, Comparison]) -> Chart:
    """Describe depth profiles of the laws beside the one they are compared with."""
    bands = {label: law.bands[DEPTH] for label, law in laws.items() if DEPTH in law.bands}
    curve, base = next(iter(bands.values()))
    lines = [Line("hooke, velocity Verlet, corrected", curve.at, base.mean_1, "first", 0.5 * base.deviation_1)]
    looks = ("second", "third", "sum", "theory")
    lines += [Line(n, c.at, band.mean_2, look) for look, (n, (c, band)) in zip(looks, bands.items(), strict=False)]
    return Chart(LAW_FIGURES[1], PLACE, [Panel("depth by mass [m]", lines)])
