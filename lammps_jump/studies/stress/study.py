# SPDX-License-Identifier: GPL-2.0-or-later
"""``lammps-jump stress``: limits of the step, hard scenes, random scenes, a resting bed; resumable."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import product
from pathlib import Path

from lammps_jump.engines import usable_cores, usable_kernels
from lammps_jump.provenance import machine
from lammps_jump.studies.bench.collision import collision_scene, measure_collisions
from lammps_jump.sweeps import Pool
from lammps_jump.sweeps.store import Results, Say, Store

from .limits import ARRANGEMENTS, ENGINES, integrator_of, measure_limit, periodic_hexagonal, resting_bed
from .report import draw_map, report
from .scenes import BYPASSED, ENGINE_CHANGES, GOOD, ended, hard_scenes, judge, judge_bypassed, random_case

STRESS_FILE = "stress.json"
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
        return [engine for engine, kernel in ENGINES.items() if kernel == "native" or kernel in self.kernels]

    @property
    def scene_engines(self) -> list[str]:
        """Engines of `scenes.ENGINE_CHANGES` that run here."""
        return [engine for engine in ENGINE_CHANGES if engine.startswith("native") or engine in self.kernels]

    def limits(self) -> list[Results]:
        """Measure limits for arrangements, restitutions, friction and spin on each engine."""
        size = {"steps": 2000, "side": 12, "tolerance": 0.01} if self.quick else {}
        calls = {
            f"limit {sorted(option.items())} {engine} {sorted(size.items())}": partial(
                measure_limit, engine=engine, **option, **size
            )
            for option, engine in product(limit_options(self.quick), self.engines)
        }
        return [*self._call(calls, describe_limit).values()]

    def periodic(self) -> list[Results]:
        """Bracket the closed form on a periodic crystal of stock LAMMPS: 0.280 is stable, 0.285 is not (e = 0.2)."""
        points = [(0.2, 0.28), (0.2, 0.285)]
        points = points if self.quick else [(0.2, 0.275), *points, (1.0, 0.575), (1.0, 0.58)]
        calls = {f"periodic {e} {f}": partial(crystal_growth, e, f) for e, f in points if "stock" in self.kernels}
        return [*self._call(calls, "periodic crystal, e = {restitution:g}, f = {fraction:g}: kinetic energy "
                                   "x {growth:.3g} in 20,000 steps".format_map).values()]  # fmt: skip

    def growth_per_contact(self) -> list[Results]:
        """Measure the relative change of energy of one elastic collision below the limit, over entry phases."""
        fractions = (0.05, 0.2) if self.quick else (0.01, 0.05, 0.1, 0.2, 0.4)
        return [
            *self._call({f"growth {e} {f}": partial(gain, e, f) for e, f in product(self.engines, fractions)}).values()
        ]

    def scenes(self) -> list[Results]:
        """Run every hard scene on every engine; a hang or a crash of its process is an outcome."""
        few = ("ks 2, e 0.01, spin", "ks 0.5, e 0.5")
        right = {
            name: (good, judge, case)
            for name, (case, good) in hard_scenes(self.long).items()
            if not (self.quick and name.startswith("ks") and name not in few)
        }
        right |= {name: (("stopped",), judge_bypassed, start) for name, start in BYPASSED.items()}
        points = {f"scene {n} {e} {self.long}": (n, e) for n, e in product(right, self.scene_engines)}
        calls = {key: partial(right[name][1], right[name][2], engine) for key, (name, engine) in points.items()}
        rows = []
        for key, found in self._call(calls, patience=10 * TIMEOUT if self.long else TIMEOUT).items():
            name, engine = points[key]
            rows.append({"scene": name, "engine": engine, **found, "right": found["outcome"] in right[name][0]})
        for name in right:
            outcomes = sorted({row["outcome"] for row in rows if row["scene"] == name})
            self.say(f"  {name}: {', '.join(outcomes)}")
        return rows

    def random_scenes(self, count: int, seed: int) -> Results:
        """Run `count` random scenes on every engine; only tallies and what ended badly are kept."""
        tally: dict[str, Counter] = {engine: Counter() for engine in self.scene_engines}
        bad, cases = [], {number: random_case(number) for number in range(seed, seed + count)}
        points = {f"random {number} {engine}": (number, engine) for number, engine in product(cases, tally)}
        calls = {key: partial(judge, cases[number], engine) for key, (number, engine) in points.items()}
        for key, result in self._call(calls, patience=TIMEOUT).items():
            number, engine = points[key]
            tally[engine][result["outcome"]] += 1
            if result["outcome"] not in GOOD + (("heated",) if may_heat(cases[number]) else ()):
                bad.append({"seed": number, "engine": engine, **result})
        self.say(f"  {count} random scenes: " + "; ".join(f"{e} {dict(t)}" for e, t in tally.items()))
        return {"count": count, "first_seed": seed, "tally": {e: dict(t) for e, t in tally.items()}, "bad": bad}

    def beds(self, steps: int) -> list[Results]:
        """Let a settled bed rest on every engine."""
        calls = {f"bed {engine} {steps}": partial(resting_bed, engine, steps) for engine in self.engines}
        return [*self._call(calls, "resting bed, {engine}, {steps} steps: {message}".format_map).values()]

    def _call(
        self, calls: dict[str, partial], tell: Callable[[Results], str] | None = None, patience: float | None = None
    ) -> Results:
        """Make pieces in the pool; what a call with `patience` (s) does not return is an outcome too."""
        said = (lambda key, piece: self.say("  " + tell(piece))) if tell else (lambda key, piece: None)
        lost = {"otherwise": ended, "patience": patience} if patience else {}
        return self.store.call(calls, self.pool, said=said, **lost)


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
    with Pool(usable_cores()) as pool:
        results = everything(Stress(store, pool, kernels, say, quick, long), random, seed)
    found = [(row["scene"], row) for row in results["scenes"] if not row["right"]]
    found += [(f"random scene {row['seed']}", row) for row in results["random"]["bad"]]
    bad = [f"{name} ({row['engine']}): {row['outcome']}: {row['message']}" for name, row in found]
    bad += [f"resting bed ({bed['engine']}): {bed['message']}" for bed in results["bed"] if not bed["right"]]
    results |= {"bad": bad, "notes": notes}
    store.finish(report(results | {"machine": machine()}), **results)
    draw_map(results["limits"], folder / "stress_map.png")
    return bad


def everything(study: Stress, random: int | None, seed: int) -> Results:
    """Do all parts of a study; returns their results by name."""
    quick, long = study.quick, study.long
    return {
        "limits": study.limits(),
        "periodic": study.periodic(),
        "growth": study.growth_per_contact(),
        "scenes": study.scenes(),
        "random": study.random_scenes(random if random is not None else (10 if quick else 200), seed),
        "bed": study.beds(20_000 if quick else (10_000_000 if long else 200_000)),
    }


def crystal_growth(restitution: float, fraction: float) -> Results:
    """Return the growth in a periodic crystal; 1e300 stands for infinity."""
    growth = min(periodic_hexagonal(restitution, fraction), 1e300)
    return {"restitution": restitution, "fraction": fraction, "growth": growth, "stable": growth < 1.0}


def gain(engine: str, fraction: float) -> Results:
    """Return mean and scatter over entry phases of the relative change of energy of one elastic collision."""
    scene = collision_scene(fraction, 1.0, integrator=integrator_of(engine))
    found = measure_collisions(scene, ENGINES[engine])["restitution"] ** 2 - 1.0
    return {"engine": engine, "fraction": fraction, "mean": float(found.mean()), "scatter": float(found.std())}


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
