# SPDX-License-Identifier: GPL-2.0-or-later
"""Figures of a cross-validation: divergence, profiles with bands, histories, what the laws change."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from lammps_jump.analysis.draw.style import BLUE, GOLD, GREY, RED, new_figure, save, style

from .ensembles import Study
from .quantities import Comparison, relative_size
from .trajectories import AGREEMENT, CONTACT_STEPS, Divergence, Growth

SHOWN = {"lammps_stock": "LAMMPS (stock)", "lammps_compiled": "LAMMPS (compiled kernel)", "native": "native engine"}
LABELS = {
    "mass_depth profile": "depth by mass [m]",
    "surface_depth profile": "depth of the surface [m]",
    "velocity profile": "mean velocity [m/s]",
    "discharge profile": "discharge [m²/s]",
    "discs history": "discs in play",
    "kinetic history": "kinetic energy [kJ/m]",
    "gravitational history": "gravitational energy [kJ/m]",
    "front history": "bulk front [m]",
    "99 % front history": "99 % front [m]",
    "jump toe history": "toe of the jump [m]",
}
KILO = ("kinetic history", "gravitational history")


DIVERGENCE = "How the engines part, disc by disc"
LAW_FIGURES = ("What the choice of law, integrator and correction changes", "Depth profiles of the laws")


def draw_all(study: Study, part: Divergence, found: Comparison, folder: Path) -> dict[str, Path]:
    """Draw what the study has; returns file by title, in the order of the report."""
    folder.mkdir(parents=True, exist_ok=True)
    profiles = [name for name in found.bands if name.endswith("profile")]
    times = [name for name in found.bands if found.bands[name][0].axis == "t"]
    leading = [name for name in times if "front" in name or "toe" in name]
    with style():
        drawn = {
            DIVERGENCE: ("divergence", divergence(study, part)),
            "Profiles along the channel, mean over the window": ("profiles", curves(found, profiles)),
        }
        if leading:
            title = "Toe of the jump against time" if "jump toe history" in leading else "Front against time"
            drawn[title] = ("front", curves(found, leading))
        drawn["Histories"] = ("histories", curves(found, [name for name in times if name not in leading]))
        drawn["Differences of all numbers"] = ("differences", forest({"": found}))
        if study.laws:
            laws = {label: comparison for label, (_, comparison) in study.laws.items()}
            drawn[LAW_FIGURES[0]] = ("laws", forest(laws))
            drawn[LAW_FIGURES[1]] = ("law_profiles", law_profiles(laws))
        return {title: save(figure, folder / f"{name}.png") for title, (name, figure) in drawn.items()}


def divergence(study: Study, part: Divergence) -> Figure:
    """Draw separation against time on a logarithmic axis, with its twin and the fitted growth."""
    scene, found = study.scene, part.found
    figure, axes = new_figure(7.2, 4.0)
    rows = (
        (part.engines, found["growth"], BLUE, "-", f"LAMMPS ({found['kernel']}) from native"),
        (part.twin, found["twin_growth"], GOLD, "--", "native from native, start off by the last digits"),
    )
    top = 1.0
    for run, growth, colour, dash, label in rows:
        t = scene.time(0) + run.steps * scene.time_step
        good = run.largest > 0
        axes.semilogy(t[good], run.largest[good], dash, color=colour, lw=1.1, label=f"{label}{_rate(growth)}")
        top = max(top, float(run.largest.max(initial=0.0)))
    axes.axhline(AGREEMENT, color=RED, lw=0.9, ls=":")
    place = {"xycoords": ("axes fraction", "data"), "ha": "right", "va": "bottom", "fontsize": 8}
    axes.annotate("must agree to 1e-9 d", (0.995, AGREEMENT), color=RED, **place)
    own = next((check for check in study.checks if check.name == scene.name), None)
    if own is not None and own.first_contact is not None:
        end = scene.time(own.first_contact + CONTACT_STEPS)
        axes.axvspan(scene.time(own.first_contact), end, color="#e9edf4", zorder=0)
        axes.annotate(f"first {CONTACT_STEPS} steps\nwith contacts", (end, 0.97), xycoords=("data", "axes fraction"),
                      va="top", fontsize=8, color=GREY)  # fmt: skip
    ylabel = "largest distance between\nthe two places of a disc [d]"
    axes.set(ylim=(1e-17, 10 * top), xlabel="time [s]", ylabel=ylabel)
    axes.legend(loc="lower right")
    return figure


def _rate(growth: Growth) -> str:
    return f" (e-fold in {1.0 / growth.rate:.3g} s)" if growth.rate > 0 else ""


def _band(axes, at, middle: np.ndarray, half: np.ndarray, colour: str, alpha: float) -> None:
    axes.fill_between(at, middle - half, middle + half, color=colour, alpha=alpha, lw=0)


def curves(found: Comparison, names: list[str]) -> Figure:
    """Draw the mean of each ensemble with a band of one standard deviation, and the difference with its interval."""
    count = max(1, len(names))
    figure, axes = new_figure(9.6, 2.1 * count + 0.5, rows=count, columns=2, squeeze=False, width_ratios=(3, 2))
    for row, name in zip(axes, names, strict=False):
        curve, band = found.bands[name]
        scale = 1e-3 if name in KILO or curve.unit == "N/m" else 1.0
        kilo = {"J/m": "kJ/m", "N/m": "kN/m"} if scale != 1.0 else {}
        unit = {**kilo, "m2/s": "m²/s", "1": "discs"}.get(curve.unit, curve.unit)
        sides = (
            (found.ensembles[0], band.mean_1, band.deviation_1, BLUE, "-", 0.20),
            (found.ensembles[1], band.mean_2, band.deviation_2, GOLD, "--", 0.30),
        )
        for label, mean, spread, colour, dash, alpha in sides:
            _band(row[0], curve.at, scale * mean, scale * spread, colour, alpha)
            row[0].plot(curve.at, scale * mean, dash, color=colour, marker=".", ms=3, label=SHOWN.get(label, label))
        row[0].set_ylabel(LABELS.get(name, f"{name} [{unit}]"))
        row[1].axhline(0.0, color=GREY, lw=0.8)
        _band(row[1], curve.at, scale * band.difference, scale * band.half_width, GREY, 0.35)
        row[1].plot(curve.at, scale * band.difference, color="#1a1a1a", lw=1.1, marker=".", ms=3)
        row[1].set_ylabel(f"difference [{unit}]")
        for part in row:
            part.set_xlabel("x [m]" if curve.axis == "x" else "time [s]")
    axes[0, 0].legend(loc="best")
    axes[0, 0].set_title("mean of the members, band: ± 1 s.d.")
    axes[0, 1].set_title("native minus LAMMPS, 95 % for all at once")
    return figure


def forest(comparisons: dict[str, Comparison]) -> Figure:
    """Draw the relative difference of every number with its confidence interval."""
    rows = [row for found in comparisons.values() for row in found.quantities if row["kind"] == "scalar"]
    names = list(dict.fromkeys(row["name"] for row in rows))
    figure, axes = new_figure(7.6, 0.26 * len(names) * max(1, 0.6 * len(comparisons)) + 1.2)
    styles = ((BLUE, "o"), (GOLD, "s"), (GREY, "^"), (RED, "D"))
    height, shift = len(names), 0.8 / max(1, len(comparisons))
    widest = 1.0
    for index, (label, found) in enumerate(comparisons.items()):
        colour, mark = styles[index % len(styles)]
        points = []
        for place, name in enumerate(names):
            row = found.find(name)
            size = relative_size(row) if row and np.isfinite(row["half_width"]) else None
            if size:
                share, half = 100 * row["difference"] / size, 100 * row["half_width"] / size
                points.append((height - place - index * shift, share, half, row["verdict"] == "differ"))
        if points:
            y, x, half, differs = np.array(points, float).T
            axes.errorbar(x, y, xerr=half, fmt=mark, color=colour, ms=4, lw=1.1, capsize=2, label=label or None)
            out = differs > 0
            axes.plot(x[out], y[out], mark, ms=9, mfc="none", mec=RED)
            widest = max(widest, float(np.max(np.abs(x) + np.minimum(half, 3 * np.abs(x) + 5))))
    axes.axvline(0.0, color=GREY, lw=0.8)
    axes.set_yticks([height - k - 0.4 * (1 - shift / 0.8) for k in range(len(names))], names)
    xlabel = "difference, % of the quantity, with its 95 % interval (red ring: differs)"
    axes.set(xlim=(-1.1 * widest, 1.1 * widest), xlabel=xlabel)
    if any(comparisons):
        axes.legend(loc="best")
    return figure


def law_profiles(laws: dict[str, Comparison]) -> Figure:
    """Draw depth profiles of the laws beside the one they are compared with."""
    figure, axes = new_figure(7.2, 3.4)
    dashes = ("--", ":", "-.", (0, (5, 1, 1, 1, 1, 1)))
    colours = (GOLD, GREY, RED, "#4c78a8")
    base = next(iter(laws.values())).bands.get("mass_depth profile")
    if base is not None:
        curve, band = base
        _band(axes, curve.at, band.mean_1, band.deviation_1, BLUE, 0.2)
        axes.plot(curve.at, band.mean_1, "-", color=BLUE, label="hooke, velocity Verlet, corrected")
    for (label, found), dash, colour in zip(laws.items(), dashes, colours, strict=False):
        if "mass_depth profile" in found.bands:
            curve, band = found.bands["mass_depth profile"]
            axes.plot(curve.at, band.mean_2, ls=dash, color=colour, label=label)
    axes.set(xlabel="x [m]", ylabel="depth by mass [m]")
    axes.legend(loc="best")
    return figure
