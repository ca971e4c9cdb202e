# SPDX-License-Identifier: GPL-2.0-or-later
"""Page and map of a stress study, from what ``stress.json`` holds."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from lammps_jump.analysis.draw.style import drawing, save
from lammps_jump.physics import contact
from lammps_jump.studies.table import markdown

from .limits import ENGINES, integrator_of

PACKINGS = {"pair": ("-", "#33508f"), "square": ("--", "#7d7c78"), "hexagonal": ("-.", "#a08a3c")}
MARKS = {"native": "^", "stock": "o", "compiled": "s"}
TITLES = {
    "velocity_verlet": "velocity Verlet (LAMMPS, native)",
    "leapfrog_extrapolated": "thesis' leap-frog (native)",
}


LIMITS = {
    "arrangement": lambda row: row["arrangement"] + (", spin" if row["rotation"] else ""),
    "e:": "{restitution:g}",
    "ks:": "{friction:g}",
    "engine": "",
    **{f"{name}:": f"{{{name}:.4f}}" for name in ("predicted", "stable", "unstable")},
    "deviation:": "{deviation:+.1%}",
}
GROWTH = {"engine": "", "f:": "{fraction:g}", "mean change:": "{mean:+.3%}",
          "scatter over entry phases:": "{scatter:.2%}"}  # fmt: skip


def report(data: dict) -> str:
    """Return the Markdown page: what ended badly, limits, growth, scenes, random scenes, resting bed."""
    random = data["random"]
    parts = ["## What ended badly", "\n".join(f"- {text}" for text in data["bad"]) or "Nothing."]
    parts += ["## Limits of the step, as a share of 2/omega of a pair", markdown(LIMITS, data["limits"])]
    if data["periodic"]:
        crystal = "- e = {restitution:g}, f = {fraction:g}: kinetic energy x {growth:.3g}"
        parts += ["Periodic hexagonal crystal, 2 % compressed, 20,000 steps of stock LAMMPS:"]
        parts += ["\n".join(map(crystal.format_map, data["periodic"]))]
    parts += ["## Energy of one elastic collision below the limit", markdown(GROWTH, data["growth"])]
    outcomes: dict[str, dict[str, str]] = {}
    for row in data["scenes"]:
        outcomes.setdefault(row["scene"], {"scene": row["scene"]})[row["engine"]] = row["outcome"]
    engines = dict.fromkeys(name for row in outcomes.values() for name in row)
    parts += ["## Hard scenes", markdown(dict.fromkeys(engines, ""), outcomes.values())]
    tally = pd.DataFrame(random["tally"]).T.fillna(0).astype(int).sort_index(axis=1)
    counts = {"engine": "", **{f"{name}:": "" for name in tally}}
    parts += [f"## Random scenes: {random['count']} from seed {random['first_seed']}"]
    parts += [markdown(counts, tally.rename_axis("engine").reset_index().to_dict("records"))]
    bed = "- {engine}, {discs} discs, {steps} steps: {message}"
    return "\n\n".join([*parts, "## Resting bed", "\n".join(map(bed.format_map, data["bed"]))]) + "\n"


def draw_map(limits: list[dict], path: Path) -> Path:
    """Draw restitution against time step: predicted limits as lines, measured ones as marks, a panel an integrator."""
    table = pd.DataFrame([row for row in limits if not row["friction"]])
    grid = np.concatenate([np.linspace(0.02, 0.98, 97), [1.0]])
    with drawing(8.4, 3.8, 1, 2, sharey=True) as (figure, axes):
        for panel, (integrator, title) in zip(axes, TITLES.items(), strict=True):
            for packing, (dash, colour) in PACKINGS.items():
                line = [contact.stable_fraction(contact.damping_ratio(e), integrator, packing) for e in grid]
                panel.plot(grid, line, dash, color=colour, label=f"{packing}, closed form")
                for engine in (name for name in ENGINES if integrator_of(name) == integrator):
                    rows = table[(table.engine == engine) & (table.arrangement == packing)]
                    mark, name = MARKS[ENGINES[engine]], f"measured, {ENGINES[engine]}"
                    label = name if len(rows) and packing == "hexagonal" else None
                    panel.plot(rows.restitution, rows.measured, mark, color=colour, markerfacecolor="none", label=label)
            panel.axhline(0.05, color="#999999", linewidth=0.8)
            panel.annotate("thesis' step", (0.02, 0.055), fontsize=7, color="#666666")
            panel.set(xlabel="restitution coefficient", title=title)
            panel.legend(fontsize=7)
        axes[0].set(ylabel="largest stable step over 2/omega of a pair", ylim=(0, 1.05))
        return save(figure, path)
