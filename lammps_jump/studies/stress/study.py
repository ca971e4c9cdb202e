"""``lammps-jump stress``: limits of the step, hard scenes, random scenes, a resting bed; resumable."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

from lammps_jump.errors import CaseError
from lammps_jump.studies.store import Store

from .limits import ARRANGEMENTS, ENGINES, Limit, measure_limit, periodic_hexagonal
from .scenes import ENGINE_TEXTS, GOOD, hard_scenes, judge, random_case

STRESS_FILE = "stress.json"
TIMEOUT = 120.0
"""s that one scene may take before it counts as hanging; minutes of drowned inlet get ten times that."""

Say = Callable[[str], None]


def stress(
    out: Path | None = None,
    *,
    quick: bool = False,
    long: bool = False,
    random: int | None = None,
    seed: int = 0,
    fresh: bool = False,
    figures: bool = True,
    say: Say = print,
) -> dict[str, Any]:
    """Everything that `lammps-jump stress` does.

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
        Forget what is stored.
    figures : bool
    say : callable

    Returns
    -------
    dict
        limits, growth, scenes, random, bed, bad (list of what ended badly), versions, machine.
    """
    from lammps_jump.studies.settings import usable_kernels

    if random is not None and random < 0:
        raise CaseError(f"--random {random}: allowed is 0 or more")
    if seed < 0:
        raise CaseError(f"--seed {seed}: allowed is 0 or more")
    folder = Path(out) if out else Path("runs") / "stress"
    store = Store(folder / STRESS_FILE, fresh=fresh)
    kernels, notes = usable_kernels()
    for note in notes:
        say(f"note: {note}")
    limits = measure_limits(store, kernels, quick, say)
    crystal = periodic(store, quick, say) if "stock" in kernels else []
    growth = growth_per_contact(store, kernels, quick)
    scenes = run_scenes(store, kernels, quick, long, say)
    drawn = run_random(store, kernels, random if random is not None else (10 if quick else 200), seed, say)
    bed = resting_bed(store, kernels, 20_000 if quick else (10_000_000 if long else 200_000), say)
    bad = [
        f"{row['scene']} ({row['engine']}): {row['outcome']}: {row['message']}" for row in scenes if not row["right"]
    ]
    bad += [f"random scene {row['seed']} ({row['engine']}): {row['outcome']}: {row['message']}" for row in drawn["bad"]]
    bad += [f"resting bed ({row['engine']}): {row['message']}" for row in bed if not row["right"]]
    store.data |= {
        "limits": limits, "periodic": crystal, "growth": growth, "scenes": scenes, "random": drawn, "bed": bed,
        "bad": bad, "versions": versions(), "machine": machine(), "notes": notes,
    }  # fmt: skip
    store.save()
    from .report import draw_map, report

    (folder / "stress.md").write_text(report(store.data))
    if figures:
        draw_map(limits, folder / "stress_map.png")
    return store.data


def _engines(kernels: list[str]) -> list[str]:
    return [engine for engine in ENGINES if engine.startswith("native") or engine in kernels]


def measure_limits(store: Store, kernels: list[str], quick: bool, say: Say) -> list[dict[str, Any]]:
    """Bisected limits for arrangements, restitutions, friction and spin on each engine."""
    restitutions = (0.2,) if quick else (1.0, 0.9, 0.6, 0.4, 0.2, 0.1, 0.05)
    options: list[dict[str, Any]] = []
    for arrangement in ARRANGEMENTS:
        if quick and arrangement == "column":
            continue
        values = restitutions if arrangement == "hexagonal" else ((0.2,) if quick else (1.0, 0.6, 0.2))
        options += [{"arrangement": arrangement, "restitution": e} for e in values]
    if not quick:
        options += [
            {"arrangement": "hexagonal", "restitution": e, "friction": 0.5, "rotation": rotation}
            for e in (0.6, 0.2)
            for rotation in (False, True)
        ]
    rows = []
    for option in options:
        for engine in _engines(kernels):
            size = {"steps": 2000, "side": 12, "tolerance": 0.01} if quick else {}

            def make(option=option, engine=engine, size=size) -> dict[str, Any]:
                limit: Limit = measure_limit(engine=engine, **option, **size)
                return asdict(limit) | {"measured": limit.measured, "deviation": limit.deviation}

            row = store.piece(f"limit {sorted(option.items())} {engine} {sorted(size.items())}", make)
            rows.append(row)
            say(
                f"  {row['arrangement']}, e = {row['restitution']:g}"
                + (f", ks = {row['friction']:g}" if row["friction"] else "")
                + (", spin" if row["rotation"] else "")
                + f", {engine}: f = {row['measured']:.4f}, closed form {row['predicted']:.4f} "
                + f"({100 * row['deviation']:+.1f} %)"
            )
    return rows


def periodic(store: Store, quick: bool, say: Say) -> list[dict[str, Any]]:
    """A bracket of the closed form on a periodic crystal: 0.280 stable, 0.285 not (e = 0.2)."""
    rows = []
    points = (
        ((0.2, 0.28), (0.2, 0.285)) if quick else ((0.2, 0.275), (0.2, 0.28), (0.2, 0.285), (1.0, 0.575), (1.0, 0.58))
    )
    for restitution, fraction in points:
        value = store.piece(
            f"periodic {restitution} {fraction}",
            lambda e=restitution, f=fraction: {"growth": min(periodic_hexagonal(e, f), 1e300)},
        )["growth"]
        rows.append({"restitution": restitution, "fraction": fraction, "growth": value, "stable": value < 1.0})
        say(f"  periodic crystal, e = {restitution:g}, f = {fraction:g}: kinetic energy x {value:.3g} in 20,000 steps")
    return rows


def growth_per_contact(store: Store, kernels: list[str], quick: bool) -> list[dict[str, Any]]:
    """Relative change of energy of one elastic collision below the limit: mean and scatter over entry phases."""
    from lammps_jump.studies.bench.collision import collision_scene, measure_collisions

    rows = []
    engines = {"native velocity_verlet": "native", "native leapfrog_extrapolated": "native"}
    engines |= {kernel: kernel for kernel in ("stock", "compiled") if kernel in kernels}
    for engine, kernel in engines.items():
        integrator = engine.split()[1] if " " in engine else "velocity_verlet"
        for fraction in (0.05, 0.2) if quick else (0.01, 0.05, 0.1, 0.2, 0.4):

            def make(fraction=fraction, kernel=kernel, integrator=integrator) -> dict[str, float]:
                scene = collision_scene(fraction, 1.0, integrator=integrator)
                gain = measure_collisions(scene, kernel)["restitution"] ** 2 - 1.0
                return {"mean": float(gain.mean()), "scatter": float(gain.std())}

            rows.append({"engine": engine, "fraction": fraction, **store.piece(f"growth {engine} {fraction}", make)})
    return rows


def run_scenes(store: Store, kernels: list[str], quick: bool, long: bool, say: Say) -> list[dict[str, Any]]:
    """Every hard scene on every engine, in a process of its own."""
    from .worker import Worker

    rows = []
    with Worker() as worker:
        for name, (case, right) in hard_scenes(long).items():
            if quick and name.startswith("ks") and name not in ("ks 2, e 0.01, spin", "ks 0.5, e 0.5"):
                continue
            for engine in _scene_engines(kernels):
                limit = 10 * TIMEOUT if long and name == "inlet drowned" else TIMEOUT
                key = f"scene {name} {engine} {long and name == 'inlet drowned'}"
                result = store.piece(key, lambda c=case, e=engine, t=limit, w=worker: w.call(judge, c, e, timeout=t))
                row = {"scene": name, "engine": engine, **result, "right": result["outcome"] in right}
                rows.append(row)
                if not row["right"]:
                    say(f"  BAD: {name} ({engine}): {result['outcome']}: {result['message']}")
            say(f"  {name}: " + ", ".join(sorted({row["outcome"] for row in rows if row["scene"] == name})))
        rows += _bypassed(store, kernels, worker, say)
    return rows


def _scene_engines(kernels: list[str]) -> list[str]:
    return [engine for engine in ENGINE_TEXTS if engine.startswith("native") or engine in kernels]


def _bypassed(store: Store, kernels: list[str], worker, say: Say) -> list[dict[str, Any]]:
    """Scenes handed to the engines past the case's checks: the guards must end them with a reason."""
    rows = []
    for name, start in BYPASSED.items():
        for engine in _scene_engines(kernels):
            result = store.piece(
                f"bypassed {name} {engine}",
                lambda s=start, e=engine: worker.call(judge_bypassed, s, e, timeout=TIMEOUT),
            )
            row = {"scene": name, "engine": engine, **result, "right": result["outcome"] == "stopped"}
            rows.append(row)
        say(f"  {name}: " + ", ".join(sorted({row["outcome"] for row in rows if row["scene"] == name})))
    return rows


BYPASSED = {
    "past the checks: discs overlapping by half": ((0.5, 2.0), (0.6, 2.0)),
    "past the checks: a disc exactly on another": ((0.5, 2.0), (0.5, 2.0)),
    "past the checks: a position that is no number": ((0.5, 2.0), (float("nan"), 2.0)),
}


def judge_bypassed(positions, engine: str) -> dict[str, Any]:
    """Two discs in a box, without the checks of `build_scene`."""
    from lammps_jump.scene.build import handmade_scene
    from lammps_jump.scene.walls import Box

    from .scenes import judge_scene

    scene = handmade_scene(
        positions, [(0.0, 0.0)] * len(positions), (Box("box", (0, 2), (0, 5)),), domain=((-3, 5), (-3, 8)),
        integrator="leapfrog_extrapolated" if engine == "native" else "velocity_verlet", steps=400, output_steps=20,
        skin=0.06,
    )  # fmt: skip
    return judge_scene(scene, engine)


def run_random(store: Store, kernels: list[str], count: int, seed: int, say: Say) -> dict[str, Any]:
    """`count` random scenes on every engine; only tallies and what ended badly are kept."""
    from .worker import Worker

    tally: dict[str, Counter] = {engine: Counter() for engine in _scene_engines(kernels)}
    bad = []
    with Worker() as worker:
        for number in range(seed, seed + count):
            case = random_case(number)
            results = store.pieces.get(f"random {number}") or {
                engine: worker.call(judge, case, engine, timeout=TIMEOUT) for engine in tally
            }
            store.pieces[f"random {number}"] = results
            right = GOOD + (("heated",) if may_heat(case) else ())
            for engine, result in results.items():
                tally[engine][result["outcome"]] += 1
                if result["outcome"] not in right:
                    bad.append({"seed": number, "engine": engine, **result})
                    say(f"  BAD: random scene {number} ({engine}): {result['outcome']}: {result['message']}")
            if number % 25 == 24:
                store.save()
    store.save()
    say(f"  {count} random scenes: " + "; ".join(f"{e} {dict(t)}" for e, t in tally.items()))
    return {"count": count, "first_seed": seed, "tally": {e: dict(t) for e, t in tally.items()}, "bad": bad}


def may_heat(case: dict[str, Any]) -> bool:
    """Steps that are stable yet heat hard elastic contacts, or that were forced through."""
    run = case["run"]
    return run["allow_unstable"] or (case["contact"]["restitution"] > 0.9 and run["time_step_fraction"] >= 0.2)


def resting_bed(store: Store, kernels: list[str], steps: int, say: Say) -> list[dict[str, Any]]:
    """A settled bed for many steps: kinetic energy does not creep up, the bed's height does not drift, no disc goes."""
    rows = []
    for engine in _engines(kernels):
        row = store.piece(f"bed {engine} {steps}", lambda e=engine: _bed(e, steps))
        rows.append(row)
        say(f"  resting bed, {engine}, {steps} steps: {row['message']}")
    return rows


def _bed(engine: str, steps: int) -> dict[str, Any]:
    import tempfile
    from dataclasses import replace

    import numpy as np

    from lammps_jump.dump.read import open_dump
    from lammps_jump.physics.contact import damping_ratio, stable_fraction
    from lammps_jump.studies.runs import execute

    from .limits import arrangement_scene, integrator_of

    fraction = min(0.1, 0.6 * stable_fraction(damping_ratio(0.2), integrator_of(engine)))
    scene = arrangement_scene("column", fraction, 0.2, integrator_of(engine), side=3)
    every = max(1, steps // 20)
    scene = replace(
        scene, steps=20 * every, output_steps=every, velocities=np.zeros_like(scene.velocities), overlap_limit=0.04
    )
    with tempfile.TemporaryDirectory() as folder:
        kernel = "native" if engine.startswith("native") else engine
        result, watch = execute(scene, Path(folder), kernel)
        frames = list(open_dump(next(Path(folder).glob("dump.*")))) if result.status == "complete" else []
    report = {"engine": engine, "steps": steps, "discs": len(scene.positions), "seconds": watch.cpu}
    if not frames:
        return {**report, "right": False, "message": f"{result.status}: {result.message}"}
    kinetic = [0.5 * scene.mass * float(np.sum(f.vx**2 + f.vy**2)) for f in frames]
    height = [float(f.y.mean()) for f in frames]
    half = len(frames) // 2
    weight_energy = scene.mass * 9.81 * scene.diameter * len(scene.positions)
    drift = (height[-1] - height[half]) / scene.diameter
    share = max(kinetic[half:]) / weight_energy
    right = bool(share < 1e-9 and abs(drift) < 1e-6 and result.lost == 0 and len(frames[-1].x) == len(scene.positions))
    text = f"kinetic energy at most {share:.1e} of m g d in the second half, mean height drifts {drift:+.1e} d"
    return {**report, "right": right, "kinetic_share": share, "drift": drift, "message": text}
