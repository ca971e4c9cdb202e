# SPDX-License-Identifier: GPL-2.0-or-later
"""Hard scenes, by hand and at random, and their outcomes.

Good outcomes are *stable* (complete, every number finite, every disc counted), *refused* before the run, and *stopped*
with a message that says what went wrong. Bad ones are a run that hangs or crashes, NaN in an output, a disc lost
without a message, an error without a reason.
"""

from __future__ import annotations

import re
import tempfile
from dataclasses import dataclass, replace
from itertools import product
from math import nan
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from lammps_jump import load_case
from lammps_jump.analysis.budgets.energy import EnergyLedger
from lammps_jump.analysis.flow import from_scene
from lammps_jump.analysis.passes import feed, with_velocities
from lammps_jump.dump import open_dump, read_dump
from lammps_jump.engines import RunResult
from lammps_jump.errors import DumpError, JumpError, SetupError
from lammps_jump.files import plain, text_of
from lammps_jump.physics.slip import FRICTION_LAWS
from lammps_jump.scene import Box, Scene, handmade_scene
from lammps_jump.studies.runs import KERNELS, execute

HARD = yaml.safe_load(text_of(Path(__file__).with_name("scenes.yaml")))
"""Scenes by hand: ``base``, and what each of ``scenes`` changes in it."""
GOOD = ("stable", "refused", "stopped")
"""Good outcomes."""
HEATED = 0.1
"""Energy out of nothing beyond this share ends as 'heated': an elastic collision errs by 1 % at f = 0.2,
an elastic box by a few per cent a minute."""
REASONS = re.compile(r"overlap|number|lost|left the domain|left the plane|balance|unstable|blew up|blown up|deep", re.I)
ENGINE_CHANGES = {
    "native": {"engine.name": "native", "run.integrator": "leapfrog_extrapolated"},
    "native verlet": {"engine.name": "native", "run.integrator": "velocity_verlet"},
    "stock": KERNELS["stock"],
    "compiled": KERNELS["compiled"],
}
BYPASSED = {
    "past the checks: discs overlapping by half": ((0.5, 2.0), (0.6, 2.0)),
    "past the checks: a disc exactly on another": ((0.5, 2.0), (0.5, 2.0)),
    "past the checks: a position that is no number": ((0.5, 2.0), (float("nan"), 2.0)),
}
"""Positions that a case cannot have; the engines must stop with a reason."""


@dataclass(frozen=True)
class Outcome:
    """Outcome of a scene.

    Attributes
    ----------
    outcome : str
        One of `GOOD`; 'absent' where the engine is missing; or a bad one: 'nan', 'lost', 'heated', 'wordless', 'hang',
        'crash', 'bug'.
    message : str
    steps : int or None
    seconds : float or None
        Wall time, s; None without a run.
    gain : float or None
        Largest rise of energy over the energy that moved; NaN for open scenes, None for runs that are not complete.
    """

    outcome: str
    message: str
    steps: int | None = None
    seconds: float | None = None
    gain: float | None = None


def ended(reason: str) -> Outcome:
    """Return the outcome of a scene whose process hung, crashed, or met an error that is none of its own."""
    kind, _, message = reason.partition(": ")
    return Outcome(kind, message) if kind in ("hang", "crash", "bug") else Outcome("bug", reason)


def base_case(**changes: object) -> dict[str, Any]:
    """Return a small box of discs under gravity, as data of a case file."""
    case = dict(HARD["base"])
    for key, value in changes.items():
        case[key] = {**case[key], **value} if isinstance(value, dict) and isinstance(case.get(key), dict) else value
    return case


def hard_scenes(long: bool = False) -> dict[str, tuple[dict[str, Any], tuple[str, ...]]]:
    """Return (case data, outcomes that are right for it) by name."""
    scenes = {
        name: (base_case(**{key: value for key, value in changes.items() if key != "right"}), tuple(changes["right"]))
        for name, changes in HARD["scenes"].items()
    }
    if long:
        scenes["inlet drowned"][0]["run"]["duration"] = 120
    for friction, restitution, spin in product((0.0, 0.1, 0.5, 1.0, 2.0), (0.01, 0.1, 0.5, 1.0), (False, True)):
        if friction or not spin:
            name = f"μ {friction:zg}, e {restitution:zg}" + (", spin" if spin else "")
            contact = {"friction": friction, "restitution": restitution, "rotation": spin}
            scenes[name] = (base_case(contact=contact), ("stable",))
    for friction, restitution, rolling in product((0.1, 0.5, 2.0), (0.01, 0.5, 1.0), (None, {"friction": 0.1})):
        name = f"springs, μ {friction:zg}, e {restitution:zg}" + (", rolling" if rolling else "")
        contact = {"friction": friction, "restitution": restitution, "rotation": True, "rolling": rolling}
        scenes[name] = (base_case(contact={**contact, "friction_law": "history"}), ("stable",))
    return scenes


def random_case(seed: int) -> dict[str, Any]:
    """Return a small scene drawn from a seed: contact, walls, discs, inflow, step; many of them are unreasonable.

    Each part draws from the same generator in its turn, so that a seed means the same scene for ever.
    """
    random = np.random.default_rng([20261121, seed])
    d, speed = random.choice((0.05, 0.2, 1.0)), random.choice((1.0, 5.0, 20.0))
    contact = _random_contact(random, np.random.default_rng([20261123, seed]), speed)
    width = d * random.uniform(6, 25)
    kind = random.choice(["box", "planes", "channel"])
    case: dict[str, Any] = {
        "name": f"random_{seed}",
        "contact": contact,
        "domain": {"x": [-4 * d, width + 40 * d], "y": [-8 * d, width + 30 * d]},
        "walls": _random_walls(random, kind, width, d),
        "initial": _random_lattice(random, speed, d) if kind != "channel" or random.random() < 0.5 else [],
        "gravity": random.choice((0.0, 9.81, 50.0)),
        "discs": {"diameter": d, "density": random.choice((1.0, 1000.0))},
    }
    if kind == "channel":
        depth, mean = d * random.uniform(0.8, 4.5), speed * random.uniform(0.2, 1.5)
        case["inflow"] = {"kind": "rows", "x": 0, "y": 0, "depth": depth, "mean_speed": mean}
        case["outflow"] = [{"x_beyond": width + 20 * d}]
    case["run"] = _random_run(random, 2.0**0.5 / contact["largest_overlap"] * speed / d)
    return plain(case)


def _random_contact(random: np.random.Generator, springs: np.random.Generator, speed: float) -> dict[str, Any]:
    """Contact for impacts of this speed (m/s); whether it has springs comes from a generator of its own."""
    contact = {
        "restitution": min(max(random.uniform(-0.1, 1.2), 0.01), 1.0),
        "friction": random.choice((0.0, 0.1, 0.6, 2.0)),
        "largest_overlap": 1 / random.choice((5.0, 10.0, 20.0, 40.0)),
        "impact_speed": speed,
        "rotation": random.random() < 0.4,
    }
    if contact["friction"] and springs.random() < 0.3:
        contact["friction_law"] = "history"
        if contact["rotation"] and springs.random() < 0.5:
            contact["rolling"] = {"friction": springs.choice((0.05, 0.5))}
    return contact


def _random_walls(random: np.random.Generator, kind: str, width: float, d: float) -> list[dict[str, Any]]:
    """A box, or planes with a step on the floor."""
    if kind == "box":
        return [{"name": "box", "kind": "box", "x": [0, width], "y": [0, width]}]
    planes = [("floor", "y"), ("left", "x")] if kind == "planes" else [("floor", "y")]
    step = [width * random.uniform(0.5, 0.8), width * random.uniform(0.85, 1.0)]
    return [
        *({"name": name, "kind": "plane", "axis": axis, "at": 0, "side": "above"} for name, axis in planes),
        {"name": "step", "kind": "block", "x": step, "y": [-d, d * random.uniform(0.5, 6)]},
    ]


def _random_lattice(random: np.random.Generator, speed: float, d: float) -> list[dict[str, Any]]:
    """A few discs, two of which move; some of them overlap."""
    nx, ny = random.integers(1, 7, 2)
    spacing = d * random.choice((0.9, 1.0, 1.05, 1.5), p=[0.1, 0.3, 0.3, 0.3])
    fast = {i: random.normal(0, speed * random.choice([0.5, 3]), 2) for i in (1, 2)}
    lattice = {"kind": "lattice", "nx": nx, "ny": ny, "spacing": spacing, "origin": [0.6 * d, 0.6 * d]}
    return [{**lattice, "jitter": random.choice((0, 0.02)), "velocities": {i: fast[i] for i in fast if i <= nx * ny}}]


def _random_run(random: np.random.Generator, omega: float) -> dict[str, Any]:
    """A few hundred steps of a contact of this frequency, rad/s."""
    fraction = random.choice((0.02, 0.05, 0.1, 0.2, 0.4), p=[0.1, 0.4, 0.3, 0.1, 0.1])
    duration = random.integers(300, 1500) * fraction * 2 / omega
    return {
        "duration": duration,
        "output_interval": duration / 5,
        "time_step_fraction": fraction,
        "seed": random.integers(1, 10**6),
        "allow_unstable": random.random() < 0.1,
    }


def may_heat(case: dict[str, Any]) -> bool:
    """Return whether the step is forced, or heats hard elastic contacts although it is stable."""
    run = case["run"]
    return run["allow_unstable"] or (case["contact"]["restitution"] > 0.9 and run["time_step_fraction"] >= 0.2)


def judge(case: dict[str, Any], engine: str) -> Outcome:
    """Build a case for an engine of `ENGINE_CHANGES`, run it and judge all that it wrote."""
    changes = dict(ENGINE_CHANGES[engine])
    if FRICTION_LAWS[case["contact"].get("friction_law", "viscous")].remembers and engine == "native":
        changes["run.integrator"] = "auto"
    try:
        scene = load_case(case, changes).scene()
    except JumpError as error:
        return told(error, "refused" if str(error).strip() else "wordless")
    return judge_scene(scene, engine)


def told(error: JumpError, outcome: str) -> Outcome:
    """Return the outcome of a scene that ended with an error; 'absent' where an engine is missing."""
    return Outcome("absent" if isinstance(error, SetupError) else outcome, str(error))


def stopped(message: str) -> str:
    """Return the outcome of a run that ended early with a message."""
    return "stopped" if REASONS.search(message) else "wordless"


def judge_bypassed(positions: tuple[tuple[float, float], ...], engine: str) -> Outcome:
    """Judge discs in a box without the checks of a case."""
    scene = handmade_scene(
        positions, [(0.0, 0.0)] * len(positions), (Box("box", (0, 2), (0, 5)),), domain=((-3, 5), (-3, 8)),
        integrator="leapfrog_extrapolated" if engine == "native" else "velocity_verlet", steps=400, output_steps=20,
        skin=0.06,
    )  # fmt: skip
    return judge_scene(scene, engine)


def judge_scene(scene: Scene, engine: str) -> Outcome:
    """Run a scene and judge all that it wrote; the engines must find what the checks of a case would refuse."""
    scene = replace(scene, probe_steps=max(1, scene.probe_steps))
    with tempfile.TemporaryDirectory() as folder, np.errstate(all="ignore"):
        try:
            result = execute(scene, Path(folder), engine.split()[0])
        except JumpError as error:
            return told(error, stopped(str(error)))
        message = result.message.replace(folder, "the run folder")
        done = {"steps": result.steps, "seconds": result.seconds}
        trouble = look_for_trouble(Path(folder), result)
        if trouble:
            return Outcome(trouble[0], trouble[1] + (f" ({message})" if message else ""), **done)
        if result.status != "complete":
            return Outcome(stopped(message), message, **done)
        gain = energy_gain(Path(folder), scene)
    if gain > HEATED:
        return Outcome("heated", f"the energy rose by {100 * gain:z.1f} %", **done, gain=gain)
    return Outcome("stable", message, **done, gain=gain)


def energy_gain(folder: Path, scene: Scene) -> float:
    """Return the largest rise of energy in any frame over the energy that moved; NaN where discs come or go.

    What moved: kinetic and elastic energy at the start, and the largest fall of the gravitational energy.
    """
    if scene.inlets or scene.outlets or scene.pours or not len(scene.positions):
        return nan
    flow = from_scene(scene)
    ledger = EnergyLedger(flow)
    for _ in feed(with_velocities(read_dump(folder), flow, []), flow, [ledger]):
        pass
    energy = ledger.result()
    moved = energy.kinetic[0] + energy.elastic[0] + float(np.ptp(energy.potential))
    return float((energy.total - energy.total[0]).max() / moved) if moved > 0 else 0.0


def look_for_trouble(folder: Path, result: RunResult) -> tuple[str, str] | None:
    """Return ('nan' or 'lost', text) where an output holds NaN or a complete run does not count every disc."""
    if result.status == "complete" and (result.lost or result.inserted != result.present + result.removed):
        return "lost", f"{result.inserted} inserted, {result.present} present, {result.removed} removed"
    for path in folder.glob("dump.*"):
        try:
            for frame in open_dump(path):
                for name, values in frame.columns.items():
                    if not np.isfinite(values).all():
                        return "nan", f"column {name} of the dump at step {frame.step}"
        except DumpError as error:
            if result.status == "complete":
                return "nan", f"the dump cannot be read: {error}"
    forces = folder / "forces.csv"
    if forces.is_file() and re.search(r"nan|inf", text_of(forces), re.I):
        return "nan", "forces.csv"
    return None
