# SPDX-License-Identifier: GPL-2.0-or-later
"""``lammps-jump stress``: limits of the step, hard scenes, random scenes, a resting bed; resumable."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from functools import partial
from itertools import product
from pathlib import Path

from lammps_jump.engines import usable_kernels
from lammps_jump.files import plain
from lammps_jump.studies.bench.collision import collision_scene, measure_collisions
from lammps_jump.studies.store import Results, Say, Store

from .limits import ARRANGEMENTS, ENGINES, integrator_of, measure_limit, periodic_hexagonal, resting_bed
from .report import draw_map, report
from .scenes import BYPASSED, ENGINE_CHANGES, GOOD, hard_scenes, judge, judge_bypassed, random_case
from .worker import Worker

STRESS_FILE = "stress.json"
TIMEOUT = 120.0
"""s that one scene may take before it counts as hanging; minutes of drowned inlet get ten times that."""


@dataclass(frozen=True)
class Stress:
    """A stress study: where it keeps its pieces, the engines that it uses, how much it does.

    Attributes
    ----------
    store : Store
    kernels : list of str
        That run here.
    say : callable
        Takes a line of progress.
    quick, long : bool
        One restitution, small packings, a few scenes; or 10^7 steps of the bed and minutes of drowned inlet.
    """

    store: Store
    kernels: list[str]
    say: Say
    quick: bool = False
    long: bool = False

    @property
    def engines(self) -> list[str]:
        """Engines of `limits.ENGINES` that run here."""
        return [engine for engine, kernel in ENGINES.items() if kernel == "native" or kernel in self.kernels]

    @property
    def scene_engines(self) -> list[str]:
        """Engines of `scenes.ENGINE_CHANGES` that run here."""
        return [engine for engine in ENGINE_CHANGES if engine.startswith("native") or engine in self.kernels]

    def limits(self) -> list[Results]:
        """Measure limits for arrangements, restitutions, friction and spin on each engine."""
        size = {"steps": 2000, "side": 12, "tolerance": 0.01} if self.quick else {}
        rows = []
        for option, engine in product(limit_options(self.quick), self.engines):
            key = f"limit {sorted(option.items())} {engine} {sorted(size.items())}"
            rows.append(self.store.piece(key, partial(measure_limit, engine=engine, **option, **size)))
            self.say("  " + describe_limit(rows[-1]))
        return rows

    def periodic(self) -> list[Results]:
        """Bracket the closed form on a periodic crystal of stock LAMMPS: 0.280 is stable, 0.285 is not (e = 0.2)."""
        points = [(0.2, 0.28), (0.2, 0.285)]
        points = points if self.quick else [(0.2, 0.275), *points, (1.0, 0.575), (1.0, 0.58)]
        rows = []
        for e, f in points if "stock" in self.kernels else []:
            value = self.store.piece(f"periodic {e} {f}", partial(crystal_growth, e, f))["growth"]
            rows.append({"restitution": e, "fraction": f, "growth": value, "stable": value < 1.0})
            self.say(f"  periodic crystal, e = {e:g}, f = {f:g}: kinetic energy x {value:.3g} in 20,000 steps")
        return rows

    def growth_per_contact(self) -> list[Results]:
        """Measure the relative change of energy of one elastic collision below the limit, over entry phases."""
        fractions = (0.05, 0.2) if self.quick else (0.01, 0.05, 0.1, 0.2, 0.4)
        return [
            {"engine": engine, "fraction": f} | self.store.piece(f"growth {engine} {f}", partial(gain, engine, f))
            for engine, f in product(self.engines, fractions)
        ]

    def scenes(self) -> list[Results]:
        """Run every hard scene on every engine, in a process of its own."""
        few = ("ks 2, e 0.01, spin", "ks 0.5, e 0.5")
        points = [
            (name, f"scene {name} {{}} {longer}", right, judge, case, 10 * TIMEOUT if longer else TIMEOUT)
            for name, (case, right) in hard_scenes(self.long).items()
            for longer in (self.long and name == "inlet drowned",)
            if not (self.quick and name.startswith("ks") and name not in few)
        ]
        points += [
            (name, f"bypassed {name} {{}}", ("stopped",), judge_bypassed, start, TIMEOUT)
            for name, start in BYPASSED.items()
        ]
        rows = []
        with Worker() as worker:
            for name, key, right, function, start, patience in points:
                for engine in self.scene_engines:
                    run = partial(worker.call, function, start, engine, timeout=patience)
                    found = self.store.piece(key.format(engine), lambda run=run: run().stored())
                    rows.append({"scene": name, "engine": engine, **found, "right": found["outcome"] in right})
                    if not rows[-1]["right"]:
                        self.say(f"  BAD: {name} ({engine}): {found['outcome']}: {found['message']}")
                outcomes = sorted({row["outcome"] for row in rows if row["scene"] == name})
                self.say(f"  {name}: {', '.join(outcomes)}")
        return rows

    def random_scenes(self, count: int, seed: int) -> dict:
        """Run `count` random scenes on every engine; only tallies and what ended badly are kept."""
        tally: dict[str, Counter] = {engine: Counter() for engine in self.scene_engines}
        bad, pieces = [], self.store.pieces
        with Worker() as worker:
            for number in range(seed, seed + count):
                case, key = random_case(number), f"random {number}"
                if key not in pieces:
                    pieces[key] = plain({e: worker.call(judge, case, e, timeout=TIMEOUT).stored() for e in tally})
                right = GOOD + (("heated",) if may_heat(case) else ())
                for engine, result in pieces[key].items():
                    tally[engine][result["outcome"]] += 1
                    if result["outcome"] not in right:
                        bad.append({"seed": number, "engine": engine, **result})
                        self.say(f"  BAD: random scene {number} ({engine}): {result['outcome']}: {result['message']}")
                if number % 25 == 24:
                    self.store.save()
        self.store.save()
        self.say(f"  {count} random scenes: " + "; ".join(f"{e} {dict(t)}" for e, t in tally.items()))
        return {"count": count, "first_seed": seed, "tally": {e: dict(t) for e, t in tally.items()}, "bad": bad}

    def beds(self, steps: int) -> list[Results]:
        """Let a settled bed rest on every engine."""
        rows = []
        for engine in self.engines:
            rows.append(self.store.piece(f"bed {engine} {steps}", partial(resting_bed, engine, steps)))
            self.say(f"  resting bed, {engine}, {steps} steps: {rows[-1]['message']}")
        return rows


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
    store = Store(folder / STRESS_FILE, fresh=fresh)
    kernels, notes = usable_kernels()
    for note in notes:
        say(f"note: {note}")
    study = Stress(store, kernels, say, quick, long)
    results: Results = {
        "limits": study.limits(),
        "periodic": study.periodic(),
        "growth": study.growth_per_contact(),
        "scenes": study.scenes(),
        "random": study.random_scenes(random if random is not None else (10 if quick else 200), seed),
        "bed": study.beds(20_000 if quick else (10_000_000 if long else 200_000)),
    }
    found = [(row["scene"], row) for row in results["scenes"] if not row["right"]]
    found += [(f"random scene {row['seed']}", row) for row in results["random"]["bad"]]
    bad = [f"{name} ({row['engine']}): {row['outcome']}: {row['message']}" for name, row in found]
    bad += [f"resting bed ({bed['engine']}): {bed['message']}" for bed in results["bed"] if not bed["right"]]
    store.finish(**results, bad=bad, notes=notes)
    store.write_table(report(store.data))
    draw_map(results["limits"], folder / "stress_map.png")
    return bad


def crystal_growth(restitution: float, fraction: float) -> Results:
    """Return the growth in a periodic crystal; 1e300 stands for infinity."""
    return {"growth": min(periodic_hexagonal(restitution, fraction), 1e300)}


def gain(engine: str, fraction: float) -> Results:
    """Return mean and scatter over entry phases of the relative change of energy of one elastic collision."""
    scene = collision_scene(fraction, 1.0, integrator=integrator_of(engine))
    found = measure_collisions(scene, ENGINES[engine])["restitution"] ** 2 - 1.0
    return {"mean": float(found.mean()), "scatter": float(found.std())}


def limit_options(quick: bool) -> list[dict]:
    """Return arrangement, restitution, friction and spin of every limit to be measured."""
    few = (0.2,) if quick else (1.0, 0.6, 0.2)
    many = (0.2,) if quick else (1.0, 0.9, 0.6, 0.4, 0.2, 0.1, 0.05)
    options: list[dict] = [
        {"arrangement": arrangement, "restitution": e}
        for arrangement in ARRANGEMENTS
        if not (quick and arrangement == "column")
        for e in (many if arrangement == "hexagonal" else few)
    ]
    rough = {"arrangement": "hexagonal", "friction": 0.5}
    turning = [] if quick else [(e, rotation) for e in (0.6, 0.2) for rotation in (False, True)]
    return options + [{**rough, "restitution": e, "rotation": rotation} for e, rotation in turning]


def describe_limit(row: dict) -> str:
    """Return one line on a limit."""
    friction = f", ks = {row['friction']:g}" if row["friction"] else ""
    spin = ", spin" if row["rotation"] else ""
    return (
        f"{row['arrangement']}, e = {row['restitution']:g}{friction}{spin}, {row['engine']}: "
        f"f = {row['measured']:.4f}, closed form {row['predicted']:.4f} ({100 * row['deviation']:+.1f} %)"
    )


def may_heat(case: dict) -> bool:
    """Return whether the step is forced, or heats hard elastic contacts although it is stable."""
    run = case["run"]
    return run["allow_unstable"] or (case["contact"]["restitution"] > 0.9 and run["time_step_fraction"] >= 0.2)
