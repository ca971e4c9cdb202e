# SPDX-License-Identifier: GPL-2.0-or-later
"""``lammps-jump stress``: limits of the step, hard scenes, random scenes, a resting bed; resumable; page and map."""

from __future__ import annotations

from collections import Counter
from itertools import chain, product
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from lammps_jump.analysis.draw.style import drawing, save
from lammps_jump.analysis.tables import filled, markdown
from lammps_jump.engines import usable_kernels
from lammps_jump.physics import contact
from lammps_jump.studies.points import FAILED, Found, Point, PointStudy
from lammps_jump.sweeps import Results

from .limits import ARRANGEMENTS, ENGINES, integrator_of
from .scenes import BYPASSED, ENGINE_CHANGES, GOOD, ended, hard_scenes, may_heat, random_case

PACKINGS = {"pair": ("-", "#33508f"), "square": ("--", "#7d7c78"), "hexagonal": ("-.", "#a08a3c")}
MARKS = {"native": "^", "stock": "o", "compiled": "s"}
TITLES = {
    "velocity_verlet": "velocity Verlet (LAMMPS, native)",
    "leapfrog_extrapolated": "thesis' leap-frog (native)",
}


LIMITS = {
    "arrangement": lambda row: row["arrangement"] + (", spin" if row["rotation"] else ""),
    "e:": "{restitution:zg}",
    "μ:": "{friction:zg}",
    "engine": "",
    **{f"{name}:": f"{{{name}:z.4f}}" for name in ("predicted", "stable", "unstable")},
    "deviation:": "{deviation:+z.1%}",
}
GROWTH = {"engine": "", "f:": "{fraction:zg}", "mean change:": "{mean:+z.3%}",
          "scatter over entry phases:": "{scatter:z.2%}"}  # fmt: skip


def page(data: Results) -> list[str]:
    """Return the paragraphs of the page: what ended badly, limits, growth, scenes, random scenes, resting bed."""
    random = data["random"]
    parts = ["## What ended badly", "\n".join(f"- {text}" for text in data["bad"]) or "Nothing."]
    parts += ["## Limits of the step, as a share of 2/omega of a pair", markdown(LIMITS, data["limits"])]
    if data["periodic"]:
        crystal = "- e = {restitution:zg}, f = {fraction:zg}: kinetic energy x {growth:z.3g}"
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
    return [*parts, "## Resting bed", "\n".join(map(bed.format_map, data["bed"]))]


def draw_map(limits: list[dict[str, Any]], path: Path) -> Path:
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


TOLD = {
    "limits": "{arrangement}, e = {restitution:zg}, μ = {friction:zg}, spin {rotation}, {engine}: f = {measured:z.4f}, "
    "closed form {predicted:z.4f} ({deviation:+z.1%})",
    "periodic": "periodic crystal, e = {restitution:zg}, f = {fraction:zg}: kinetic energy x {growth:z.3g} in 20,000 "
    "steps",
    "bed": "resting bed, {engine}, {steps} steps: {message}",
}
"""Line of progress of a part."""
TIMEOUT = 120.0
"""s that one scene may take before it counts as hanging; minutes of drowned inlet get ten times that."""
FEW = ("μ 2, e 0.01, spin", "μ 0.5, e 0.5")
"""Scenes of many coefficients that are run in the short form."""


def study(*, quick: bool = False, long: bool = False, random: int | None = None, seed: int = 0) -> PointStudy:
    """Return the study of what runs here.

    Parameters
    ----------
    quick : bool
        One restitution, small packings, a few scenes: under a minute.
    long : bool
        10^7 steps of the resting bed, two minutes of drowned inlet.
    random : int, optional
        Number of random scenes; default 200 (10 if quick).
    seed : int
        First seed of the random scenes.
    """
    kernels, notes = usable_kernels()
    engines = [engine for engine, kernel in ENGINES.items() if kernel in kernels]
    judging = [engine for engine in ENGINE_CHANGES if engine.split()[0] in kernels]
    patience = 10 * TIMEOUT if long else TIMEOUT
    scenes = scene_points(quick, long, judging, patience)
    count = random if random is not None else (10 if quick else 200)
    cases = {number: random_case(number) for number in range(seed, seed + count)}
    drawn = {
        (number, engine): judged(f"random {number}", "judge", engine, patience, case=case)
        for (number, case), engine in product(cases.items(), judging)
    }
    parts = {
        "limits": limit_points(quick, engines),
        "periodic": crystal_points(quick) if "stock" in kernels else [],
        "growth": growth_points(quick, engines),
        "bed": bed_points(20_000 if quick else (10_000_000 if long else 200_000), engines),
    }

    def results(found: Found, stored: Results) -> Results:
        rows: Results = {name: [found[point.name][0] for point in points] for name, points in parts.items()}
        rows["scenes"] = [
            {
                "scene": name,
                "engine": engine,
                **(one := outcome_of(found[point.name][0])),
                "right": one["outcome"] in good,
            }
            for (name, engine), (point, good) in scenes.items()
        ]
        ran = [{"seed": n, "engine": e, **outcome_of(found[point.name][0])} for (n, e), point in drawn.items()]
        tally = {e: Counter(row["outcome"] for row in ran if row["engine"] == e) for e in judging if ran}
        good = {number: (*GOOD, "heated") if may_heat(case) else GOOD for number, case in cases.items()}
        bad = [row for row in ran if row["outcome"] not in good[row["seed"]]]
        rows["random"] = {"count": count, "first_seed": seed, "tally": tally, "bad": bad}
        return rows | {"bad": ended_badly(rows), "notes": notes}

    points = [*chain.from_iterable(parts.values()), *(point for point, _ in scenes.values()), *drawn.values()]
    opening = [f"note: {note}" for note in notes]
    return PointStudy("stress", points, results, page, draw, told, opening, ending)


def told(point: Point, start: int, measured: Results) -> str:
    """Return what a point has found, in a line; nothing of growth and scenes."""
    return filled(TOLD.get(point.name.split()[0], ""), measured)


def ending(results: Results) -> list[str]:
    """Return what became of the scenes: a line each, and one of all random ones."""
    found: dict[str, set[str]] = {}
    for row in results["scenes"]:
        found.setdefault(row["scene"], set()).add(row["outcome"])
    random = results["random"]
    tally = "; ".join(f"{engine} {counts}" for engine, counts in random["tally"].items())
    lines = [f"  {name}: {', '.join(sorted(outcomes))}" for name, outcomes in found.items()]
    return [*lines, f"  {random['count']} random scenes: {tally}"]


def draw(results: Results, folder: Path) -> Path:
    """Draw the map of the limits."""
    return draw_map(results["limits"], folder / "stress_map.png")


def ended_badly(rows: Results) -> list[str]:
    """Return the scenes and beds that ended badly, a line each."""
    scenes = [(row["scene"], row) for row in rows["scenes"] if not row["right"]]
    scenes += [(f"random scene {row['seed']}", row) for row in rows["random"]["bad"]]
    bad = [f"{name} ({row['engine']}): {row['outcome']}: {row['message']}" for name, row in scenes]
    return bad + [f"resting bed ({bed['engine']}): {bed['message']}" for bed in rows["bed"] if not bed["right"]]


def outcome_of(measured: Results) -> Results:
    """Return the outcome of a scene, also of one whose process did not answer."""
    return vars(ended(measured[FAILED])) if FAILED in measured else dict(measured)


def named(part: str, measure: str, **options: Any) -> Point:
    """Return a point without a run, named after its part and options."""
    return Point(" ".join([part, *map(str, options.values())]), measure, options=options)


def limit_points(quick: bool, engines: list[str]) -> list[Point]:
    """Limits for arrangements, restitutions, friction and spin on each engine."""
    size = {"steps": 2000, "side": 12, "tolerance": 0.01} if quick else {}
    points = product(limit_options(quick), engines)
    return [named("limits", "measure_limit", engine=engine, **options, **size) for options, engine in points]


def crystal_points(quick: bool) -> list[Point]:
    """The closed form bracketed on a periodic crystal of stock LAMMPS: 0.280 is stable, 0.285 is not (e = 0.2)."""
    points = [(0.2, 0.28), (0.2, 0.285)]
    points = points if quick else [(0.2, 0.275), *points, (1.0, 0.575), (1.0, 0.58)]
    return [named("periodic", "crystal_growth", restitution=e, fraction=f) for e, f in points]


def growth_points(quick: bool, engines: list[str]) -> list[Point]:
    """Relative change of energy of one elastic collision below the limit, over entry phases."""
    fractions = (0.05, 0.2) if quick else (0.01, 0.05, 0.1, 0.2, 0.4)
    return [named("growth", "gain", engine=engine, fraction=f) for engine, f in product(engines, fractions)]


def bed_points(steps: int, engines: list[str]) -> list[Point]:
    """A settled bed that rests, on every engine."""
    return [named("bed", "resting_bed", engine=engine, steps=steps) for engine in engines]


def judged(name: str, measure: str, engine: str, patience: float, **options: Any) -> Point:
    """Return the point of a scene; a hang or a crash of its process is an outcome."""
    options = {**options, "engine": engine}
    return Point(f"{name}, {engine}", measure, options=options, judged=True, patience=patience)


def scene_points(
    quick: bool, long: bool, engines: list[str], patience: float
) -> dict[tuple[str, str], tuple[Point, tuple[str, ...]]]:
    """Return the point of every hard scene on every engine, and the outcomes that are right, by scene and engine."""
    asked: dict[str, tuple[str, dict[str, Any], tuple[str, ...]]] = {
        name: ("judge", {"case": case}, good)
        for name, (case, good) in hard_scenes(long).items()
        if not (quick and name.startswith("μ") and name not in FEW)
    }
    asked |= {name: ("judge_bypassed", {"positions": start}, ("stopped",)) for name, start in BYPASSED.items()}
    return {
        (name, engine): (judged(f"scene {name}", measure, engine, patience, **options), good)
        for (name, (measure, options, good)), engine in product(asked.items(), engines)
    }


def limit_options(quick: bool) -> list[dict[str, Any]]:
    """Return arrangement, restitution, friction and spin of every limit to be measured."""
    if quick:
        return [{"arrangement": name, "restitution": 0.2} for name in ARRANGEMENTS if name != "column"]
    many, few = (1.0, 0.9, 0.6, 0.4, 0.2, 0.1, 0.05), (1.0, 0.6, 0.2)
    smooth = [{"arrangement": n, "restitution": e} for n in ARRANGEMENTS for e in (many if n == "hexagonal" else few)]
    rough = {"arrangement": "hexagonal", "friction": 0.5}
    return smooth + [{**rough, "restitution": e, "rotation": spin} for e, spin in product(few[1:], (False, True))]
