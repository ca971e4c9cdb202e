"""Page and map of a stress study."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any


def report(data: dict[str, Any]) -> str:
    """Markdown: limits, growth, scenes, random scenes, resting bed; what ended badly first."""
    lines = ["## What ended badly", ""]
    lines += [f"- {text}" for text in data["bad"]] or ["Nothing."]
    lines += ["", "## Limits of the step, as a share of 2/omega of a pair", ""]
    lines += [
        "| arrangement | e | ks | engine | predicted | stable | unstable | deviation |",
        "|---|---:|---:|---|---:|---:|---:|---:|",
    ]
    for row in data["limits"]:
        name = row["arrangement"] + (", spin" if row["rotation"] else "")
        lines.append(
            f"| {name} | {row['restitution']:g} | {row['friction']:g} | {row['engine']} | {row['predicted']:.4f} | "
            f"{row['stable']:.4f} | {row['unstable']:.4f} | {100 * row['deviation']:+.1f} % |"
        )
    if data["periodic"]:
        lines += ["", "Periodic hexagonal crystal, 2 % compressed, 20,000 steps of stock LAMMPS:", ""]
        lines += [
            f"- e = {row['restitution']:g}, f = {row['fraction']:g}: kinetic energy x {row['growth']:.3g}"
            for row in data["periodic"]
        ]
    lines += [
        "",
        "## Energy of one elastic collision below the limit",
        "",
        "| engine | f | mean change | scatter over entry phases |",
        "|---|---:|---:|---:|",
    ]
    lines += [
        f"| {row['engine']} | {row['fraction']:g} | {100 * row['mean']:+.3f} % | {100 * row['scatter']:.2f} % |"
        for row in data["growth"]
    ]
    lines += ["", "## Hard scenes", "", "| scene | " + " | ".join(engines(data["scenes"])) + " |"]
    lines += ["|---|" + "---|" * len(engines(data["scenes"]))]
    for scene in dict.fromkeys(row["scene"] for row in data["scenes"]):
        found = {row["engine"]: row["outcome"] for row in data["scenes"] if row["scene"] == scene}
        lines.append(f"| {scene} | " + " | ".join(found.get(engine, "-") for engine in engines(data["scenes"])) + " |")
    random = data["random"]
    lines += ["", f"## Random scenes: {random['count']} from seed {random['first_seed']}", ""]
    names = sorted({name for tally in random["tally"].values() for name in tally})
    lines += ["| engine | " + " | ".join(names) + " |", "|---|" + "---:|" * len(names)]
    for engine, tally in random["tally"].items():
        counted = Counter(tally)
        lines.append(f"| {engine} | " + " | ".join(str(counted[name]) for name in names) + " |")
    lines += ["", "## Resting bed", ""]
    lines += [f"- {row['engine']}, {row['discs']} discs, {row['steps']} steps: {row['message']}" for row in data["bed"]]
    return "\n".join(lines) + "\n"


def engines(scenes: list[dict[str, Any]]) -> list[str]:
    """Engines in the order they were run."""
    return list(dict.fromkeys(row["engine"] for row in scenes))


def draw_map(limits: list[dict[str, Any]], path: Path) -> Path:
    """Restitution against time step: predicted limits as lines, measured ones as marks, one panel an integrator."""
    import numpy as np

    from lammps_jump.analysis.draw.style import new_figure, save, style
    from lammps_jump.physics import contact

    grid = np.concatenate([np.linspace(0.02, 0.98, 97), [1.0]])
    looks = {"pair": ("-", "#33508f"), "square": ("--", "#7d7c78"), "hexagonal": ("-.", "#a08a3c")}
    marks = {"native velocity_verlet": "^", "native leapfrog_extrapolated": "^", "stock": "o", "compiled": "s"}
    titles = {
        "velocity_verlet": "velocity Verlet (LAMMPS, native)",
        "leapfrog_extrapolated": "thesis' leap-frog (native)",
    }
    with style():
        figure, axes = new_figure(8.4, 3.8, 1, 2, sharey=True)
        for panel, (integrator, title) in zip(axes, titles.items(), strict=True):
            for packing, (dash, colour) in looks.items():
                line = [contact.stable_fraction(contact.damping_ratio(e), integrator, packing) for e in grid]
                panel.plot(grid, line, dash, color=colour, label=f"{packing}, closed form")
                for engine, mark in marks.items():
                    mine = (engine.split()[1] if " " in engine else "velocity_verlet") == integrator
                    rows = [
                        row for row in limits
                        if mine and row["engine"] == engine and row["arrangement"] == packing and not row["friction"]
                    ]  # fmt: skip
                    if rows:
                        name = f"measured, {engine.split()[0]}" if packing == "hexagonal" else None
                        panel.plot(
                            [row["restitution"] for row in rows], [row["measured"] for row in rows], mark,
                            color=colour, markerfacecolor="none", label=name,
                        )  # fmt: skip
            panel.axhline(0.05, color="#999999", linewidth=0.8)
            panel.annotate("thesis' step", (0.02, 0.055), fontsize=7, color="#666666")
            panel.set_xlabel("restitution coefficient")
            panel.set_title(title)
            panel.legend(fontsize=7)
        axes[0].set_ylabel("largest stable step over 2/omega of a pair")
        axes[0].set_ylim(0, 1.05)
        return save(figure, path)
