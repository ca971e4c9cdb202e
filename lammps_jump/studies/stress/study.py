# SPDX-License-Identifier: GPL-2.0-or-later
"""``lammps-jump stress``: limits of the step, hard scenes, random scenes, a resting bed; resumable; page and map."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from lammps_jump.analysis.draw.style import drawing, save
from lammps_jump.engines import usable_kernels
from lammps_jump.physics import contact
from lammps_jump.provenance import usable_cores
from lammps_jump.studies.bench.collision import collision_scene, measure_collisions
from lammps_jump.studies.folder import held_folder
from lammps_jump.studies.table import filled, markdown
from lammps_jump.sweeps import Pool, Results, Say, Store

from .limits import ARRANGEMENTS, ENGINES, crystal_growth, integrator_of, measure_limit, resting_bed
from .scenes import BYPASSED, ENGINE_CHANGES, GOOD, Outcome, ended, hard_scenes, judge, judge_bypassed, random_case

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


def report(data: dict[str, Any]) -> str:
    """Return the Markdown page: what ended badly, limits, growth, scenes, random scenes, resting bed."""
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
    return "\n\n".join([*parts, "## Resting bed", "\n".join(map(bed.format_map, data["bed"]))]) + "\n"


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


STRESS_FILE = "stress.json"
LIMIT_SAID = (
    "{arrangement}, e = {restitution:zg}, μ = {friction:zg}, spin {rotation}, {engine}: f = {measured:z.4f}, "
    "closed form {predicted:z.4f} ({deviation:+z.1%})"
)
TIMEOUT = 120.0
"""s that one scene may take before it counts as hanging; minutes of drowned inlet get ten times that."""


@dataclass(frozen=True)
class Stress:
    """A stress study: where it keeps its pieces, the engines that it uses, how much it does.

    Attributes
    ----------
    store : Store
    pool : Pool
    kernels : list of str
        That run here.
    say : callable
        Takes a line of progress.
    quick, long : bool
        One restitution, small packings, a few scenes; or 10^7 steps of the bed and minutes of drowned inlet.
    """

    store: Store
    pool: Pool
    kernels: list[str]
    say: Say
    quick: bool = False
    long: bool = False

    @property
    def engines(self) -> list[str]:
        """Engines of `limits.ENGINES` that run here."""
        return [engine for engine, kernel in ENGINES.items() if kernel in self.kernels]

    def limits(self) -> list[Results]:
        """Measure limits for arrangements, restitutions, friction and spin on each engine."""
        size = {"steps": 2000, "side": 12, "tolerance": 0.01} if self.quick else {}
        points = product(limit_options(self.quick), self.engines)
        calls = [partial(measure_limit, engine=engine, **options, **size) for options, engine in points]
        return self._call(calls, partial(filled, LIMIT_SAID))

    def periodic(self) -> list[Results]:
        """Bracket the closed form on a periodic crystal of stock LAMMPS: 0.280 is stable, 0.285 is not (e = 0.2)."""
        points = [(0.2, 0.28), (0.2, 0.285)]
        points = points if self.quick else [(0.2, 0.275), *points, (1.0, 0.575), (1.0, 0.58)]
        told = (
            "periodic crystal, e = {restitution:zg}, f = {fraction:zg}: kinetic energy x {growth:z.3g} in 20,000 steps"
        )
        calls = [partial(crystal_growth, *point) for point in points if "stock" in self.kernels]
        return self._call(calls, told.format_map)

    def growth_per_contact(self) -> list[Results]:
        """Measure the relative change of energy of one elastic collision below the limit, over entry phases."""
        fractions = (0.05, 0.2) if self.quick else (0.01, 0.05, 0.1, 0.2, 0.4)
        return self.store.call([partial(gain, *point) for point in product(self.engines, fractions)], self.pool)

    def scenes(self) -> list[Results]:
        """Run every hard scene on every engine; a hang or a crash of its process is an outcome."""
        few = ("μ 2, e 0.01, spin", "μ 0.5, e 0.5")
        asked = {
            name: (judge, case, good)
            for name, (case, good) in hard_scenes(self.long).items()
            if not (self.quick and name.startswith("μ") and name not in few)
        } | {name: (judge_bypassed, start, ("stopped",)) for name, start in BYPASSED.items()}
        found = self._judged("scene", {name: one[:2] for name, one in asked.items()})
        rows = [{**row, "right": row["outcome"] in asked[row["scene"]][2]} for row in found]
        for name in dict.fromkeys(row["scene"] for row in rows):
            outcomes = sorted({row["outcome"] for row in rows if row["scene"] == name})
            self.say(f"  {name}: {', '.join(outcomes)}")
        return rows

    def random_scenes(self, count: int, seed: int) -> Results:
        """Run `count` random scenes on every engine; only tallies and what ended badly are kept."""
        cases = {number: random_case(number) for number in range(seed, seed + count)}
        rows = self._judged("seed", {number: (judge, case) for number, case in cases.items()})
        tally = {one["engine"]: Counter(r["outcome"] for r in rows if r["engine"] == one["engine"]) for one in rows}
        good = {number: (*GOOD, "heated") if may_heat(case) else GOOD for number, case in cases.items()}
        bad = [row for row in rows if row["outcome"] not in good[row["seed"]]]
        told = "; ".join(f"{engine} {dict(counts)}" for engine, counts in tally.items())
        self.say(f"  {count} random scenes: {told}")
        return {"count": count, "first_seed": seed, "tally": tally, "bad": bad}

    def beds(self, steps: int) -> list[Results]:
        """Let a settled bed rest on every engine."""
        calls = [partial(resting_bed, engine, steps) for engine in self.engines]
        return self._call(calls, "resting bed, {engine}, {steps} steps: {message}".format_map)

    def _judged(self, kind: str, asked: Mapping[Any, tuple[Callable[..., Outcome], object]]) -> list[Results]:
        """Return rows of scenes, by name what judges and what is judged, on all engines here; `kind` holds the name."""
        points = list(product(asked, [engine for engine in ENGINE_CHANGES if engine.split()[0] in self.kernels]))
        calls = [partial(*asked[name], engine) for name, engine in points]
        patience = 10 * TIMEOUT if self.long else TIMEOUT
        found = self.store.call(calls, self.pool, otherwise=ended, patience=patience)
        return [{kind: name, "engine": e, **row} for (name, e), row in zip(points, found, strict=True)]

    def _call(self, calls: list[partial[Any]], tell: Callable[[Results], str]) -> list[Results]:
        return self.store.call(calls, self.pool, said=lambda piece: self.say("  " + tell(piece)))


def stress(
    out: Path | None = None,
    *,
    quick: bool = False,
    long: bool = False,
    random: int | None = None,
    seed: int = 0,
    fresh: bool = False,
    say: Say = print,
) -> list[str]:
    """Do everything that `lammps-jump stress` does; returns what ended badly.

    Parameters
    ----------
    out : Path, optional
        Default ``runs/stress``.
    quick : bool
        One restitution, small packings, a few scenes: under a minute.
    long : bool
        10^7 steps of the resting bed, two minutes of drowned inlet.
    random : int, optional
        Number of random scenes; default 200 (10 if quick).
    seed : int
        First seed of the random scenes.
    fresh : bool
        Run again what is stored.
    say : callable
    """
    folder = Path(out) if out else Path("runs") / "stress"
    kernels, notes = usable_kernels()
    for note in notes:
        say(f"note: {note}")
    with held_folder(folder, "stress"), Pool(usable_cores()) as pool:
        store = Store(folder / STRESS_FILE, fresh=fresh)
        study = Stress(store, pool, kernels, say, quick, long)
        results: Results = {
            "limits": study.limits(),
            "periodic": study.periodic(),
            "growth": study.growth_per_contact(),
            "scenes": study.scenes(),
            "random": study.random_scenes(random if random is not None else (10 if quick else 200), seed),
            "bed": study.beds(20_000 if quick else (10_000_000 if long else 200_000)),
        }
        ended_badly = [(row["scene"], row) for row in results["scenes"] if not row["right"]]
        ended_badly += [(f"random scene {row['seed']}", row) for row in results["random"]["bad"]]
        bad = [f"{name} ({row['engine']}): {row['outcome']}: {row['message']}" for name, row in ended_badly]
        bad += [f"resting bed ({bed['engine']}): {bed['message']}" for bed in results["bed"] if not bed["right"]]
        results |= {"bad": bad, "notes": notes}
        store.finish(report(results), **results)
        draw_map(results["limits"], folder / "stress_map.png")
        return bad


def gain(engine: str, fraction: float) -> Results:
    """Return mean and scatter over entry phases of the relative change of energy of one elastic collision."""
    scene = collision_scene(fraction, 1.0, integrator=integrator_of(engine))
    found = measure_collisions(scene, ENGINES[engine])["restitution"] ** 2 - 1.0
    return {"engine": engine, "fraction": fraction, "mean": float(found.mean()), "scatter": float(found.std())}


def limit_options(quick: bool) -> list[dict[str, Any]]:
    """Return arrangement, restitution, friction and spin of every limit to be measured."""
    if quick:
        return [{"arrangement": name, "restitution": 0.2} for name in ARRANGEMENTS if name != "column"]
    many, few = (1.0, 0.9, 0.6, 0.4, 0.2, 0.1, 0.05), (1.0, 0.6, 0.2)
    smooth = [{"arrangement": n, "restitution": e} for n in ARRANGEMENTS for e in (many if n == "hexagonal" else few)]
    rough = {"arrangement": "hexagonal", "friction": 0.5}
    return smooth + [{**rough, "restitution": e, "rotation": spin} for e, spin in product(few[1:], (False, True))]


def may_heat(case: dict[str, Any]) -> bool:
    """Return whether the step is forced, or heats hard elastic contacts although it is stable."""
    run = case["run"]
    return run["allow_unstable"] or (case["contact"]["restitution"] > 0.9 and run["time_step_fraction"] >= 0.2)
