# SPDX-License-Identifier: GPL-2.0-or-later
"""Page and map of a stress study, from what ``stress.json`` holds."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np
import pandas as pd

from lammps_jump.analysis.draw.style import drawing, save
from lammps_jump.physics import contact
from lammps_jump.studies.table import filled, markdown

from .limits import ENGINES, integrator_of

PACKINGS = {"pair": ("-", "#33508f"), "square": ("--", "#7d7c78"), "hexagonal": ("-.", "#a08a3c")}
MARKS = {"native": "^", "stock": "o", "compiled": "s"}
TITLES = {
    "velocity_verlet": "velocity Verlet (LAMMPS, native)",
    "leapfrog_extrapolated": "thesis' leap-frog (native)",
}


def report(data: dict) -> str:
    """Return the Markdown page: what ended badly, limits, growth, scenes, random scenes, resting bed."""
    random = data["random"]
    crystal = "- e = {restitution:g}, f = {fraction:g}: kinetic energy x {growth:.3g}"
    growth = filled("{engine}|{fraction:g}|{mean:+.3%}|{scatter:.2%}", data["growth"])
    bed = "- {engine}, {discs} discs, {steps} steps: {message}"
    parts = ["## What ended badly", "\n".join(f"- {text}" for text in data["bad"]) or "Nothing."]
    parts += ["## Limits of the step, as a share of 2/omega of a pair", _limits(data["limits"])]
    if data["periodic"]:
        parts += [
            "Periodic hexagonal crystal, 2 % compressed, 20,000 steps of stock LAMMPS:",
            "\n".join(map(crystal.format_map, data["periodic"])),
        ]
    parts += ["## Energy of one elastic collision below the limit"]
    parts += [markdown(["engine", "f", "mean change", "scatter over entry phases"], "lrrr", growth)]
    parts += ["## Hard scenes", _outcomes(data["scenes"])]
    parts += [f"## Random scenes: {random['count']} from seed {random['first_seed']}", _tally(random["tally"])]
    return "\n\n".join([*parts, "## Resting bed", "\n".join(map(bed.format_map, data["bed"]))]) + "\n"


def _limits(limits: list[dict]) -> str:
    law = "{restitution:g}|{friction:g}|{engine}|{predicted:.4f}|{stable:.4f}|{unstable:.4f}|{deviation:+.1%}"
    rows = (row | {"spin": ", spin" if row["rotation"] else ""} for row in limits)
    head = ["arrangement", "e", "ks", "engine", "predicted", "stable", "unstable", "deviation"]
    return markdown(head, "lrrlrrrr", filled("{arrangement}{spin}|" + law, rows))


def _outcomes(scenes: list[dict]) -> str:
    engines = list(dict.fromkeys(row["engine"] for row in scenes))
    found = {(row["scene"], row["engine"]): row["outcome"] for row in scenes}
    names = dict.fromkeys(row["scene"] for row in scenes)
    rows = [[name, *(found.get((name, engine), "-") for engine in engines)] for name in names]
    return markdown(["scene", *engines], "l" * (1 + len(engines)), rows)


def _tally(tally: dict[str, dict[str, int]]) -> str:
    names = sorted({name for counted in tally.values() for name in counted})
    rows = [[engine, *(Counter(counted)[name] for name in names)] for engine, counted in tally.items()]
    return markdown(["engine", *names], "l" + "r" * len(names), rows)


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
