# SPDX-License-Identifier: GPL-2.0-or-later
"""Cross-validation of a case: the same scene on two engines, from single contacts to time means over starts."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from functools import partial
from itertools import product
from math import isfinite, nan
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lammps_jump.engines import choose, usable_kernels
from lammps_jump.errors import RunError, SetupError
from lammps_jump.files import plain, write_json
from lammps_jump.physics.slip import FRICTION_LAWS, Rolling, Springs
from lammps_jump.provenance import usable_cores
from lammps_jump.runs.run import Case
from lammps_jump.scene import Block, Box, InletRow, MovingWall, Outlet, Plane, Scene, Sizes, Wall, gate, handmade_scene
from lammps_jump.scene.scene import Fixed
from lammps_jump.script.stock import lacking
from lammps_jump.studies.points import held_folder
from lammps_jump.studies.runs import KERNELS
from lammps_jump.sweeps import JITTER, Pool, Results, Say, Start, all_versions, run_starts

from . import page, trajectories
from .quantities import CONFIDENCE, FAMILY_ERROR, Comparison, Quantities, compare, measure
from .trajectories import CONTACT_STEPS, DeterministicCheck, Divergence, Growth

DIAMETER = 0.2
DOMAIN = ((-5.0, 10.0), (-5.0, 10.0))
FLOOR = Plane("floor", "y", 0.0, "above")


def _scene(
    name: str,
    description: str,
    positions: ArrayLike,
    velocities: ArrayLike,
    walls: tuple[Wall | MovingWall, ...] = (),
    **others: Any,
) -> Scene:
    settings = {"diameter": DIAMETER, "restitution": 0.5, "impact_speed": 6.0, "domain": DOMAIN, "steps": 3_000}
    settings |= {"skin": 0.3 * DIAMETER, "correct_restitution": True, "name": name, "description": description}
    return handmade_scene(positions, velocities, walls, **{**settings, **others})


def _heap(seed: int, rows: int, x0: float = 0.4) -> np.ndarray:
    """Return places of a heap of four columns, slightly moved by random numbers."""
    i, j = np.meshgrid(np.arange(4), np.arange(rows))
    grid = np.column_stack([x0 + 0.21 * i.ravel(), 0.11 + 0.21 * j.ravel()])
    return grid + np.random.default_rng(seed).uniform(-0.004, 0.004, grid.shape)


def _ring() -> tuple[np.ndarray, np.ndarray]:
    """Return places and velocities of a disc and twelve others around it that are thrown at it."""
    angle = 2 * np.pi * np.arange(12) / 12 + 0.05 * np.sin(np.arange(12) * 2.3)
    out = np.column_stack([np.cos(angle), np.sin(angle)])
    along = np.column_stack([-out[:, 1], out[:, 0]])
    return np.vstack([[0.0, 0.0], 0.62 * out]), np.vstack([[0.3, -0.2], -2.5 * out + 0.4 * along])


def _sliding_heap(name: str, text: str, seed: int, slow: float, range_: float, **contact: Any) -> Scene:
    """Return a heap of twenty discs that slides against a step; speeds (m/s) rise from `slow` by `range_`."""
    velocities = np.column_stack([slow + range_ * np.arange(20) / 20, np.zeros(20)])
    return _scene(name, text, _heap(seed, 5), velocities, (FLOOR, Block("step", (2.0, 2.5), (-1.0, 0.3))), **contact)


def friction_scene(law: str = "viscous") -> Scene:
    """Return a heap that slides and topples with friction, without spin."""
    name = "friction" if law == "viscous" else f"friction ({law} law)"
    text = "a heap that slides and topples against a step, μ = 0.3"
    return _sliding_heap(name, text, 7, 1.5, 0.3, friction=0.3, friction_law=law)


def _channel() -> Scene:
    """Return a layer of discs that slides over a row of fixed ones, in a periodic channel."""
    places = _heap(10, 3, 0.15)
    places[:, 1] += 0.05
    row = np.column_stack([0.11 * np.arange(10), np.zeros(10)])
    n, m = len(places), len(row)
    speeds = np.vstack([np.tile([1.5, 0.0], (n, 1)), 0 * row])
    return _scene(
        "channel", "a layer that slides over fixed discs, periodic, with springs", np.vstack([places, row]), speeds,
        friction=0.5, rotation=True, friction_law="history", springs=Springs(), gravity=(3.0, -9.0),
        domain=((0.0, 1.1), (-5.0, 10.0)), periodic=True, fixed=Fixed(n + 1, n + m),
        sizes=Sizes((1.0,), (DIAMETER,), (DIAMETER,), 1, ((n + 1, n + m, 0.1),)),
    )  # fmt: skip


def micro_scenes() -> tuple[Scene, ...]:
    """Return the scenes that both LAMMPS kernels can run, in the order of the report."""
    none, shut = np.empty((0, 2)), gate(Plane("gate", "x", 0.86, "below"), 600)
    rows = tuple(InletRow(0.0, 0.1 + 0.2 * i, 4.0 + 0.7 * i, 0.0, 1, 260 - 35 * i, 0.999 * DIAMETER) for i in range(2))
    outlets = (Outlet("x", 1.9, "above", 40), Outlet("y", -1.0, "below", 40))
    return (
        _scene("pair", "ring of discs thrown at one in the middle: pair contacts only", *_ring(), gravity=(0.0, 0.0)),
        _scene("wall", "discs that bounce and rest on planes and box faces",
               [[0.0, 0.115], [1.0, 0.2], [2.0, 0.6], [3.19, 1.0]], [[-1.0, 0.0], [0.0, -2.0], [0.3, 3.0], [1.0, 2.5]],
               (FLOOR, Box("box", (-0.3, 3.3), (-1.0, 1.2)))),
        _scene("corner", "discs against the corners of a block",  # normals that turn
               [[-0.03, 0.61], [1.05, 0.62], [0.5, 0.61], [-0.8, 0.55], [1.9, 0.52]],
               [[0.0, -1.0], [-0.4, -1.5], [3.0, 0.0], [4.0, 0.4], [-5.0, 0.6]],
               (Block("step", (0.0, 1.0), (-1.0, 0.5)), FLOOR)),
        friction_scene(),
        _sliding_heap("spin", "the heap with turning discs, μ = 0.5", 8, 1.2, 0.6, friction=0.5, rotation=True),
        _sliding_heap("springs", "the same with tangential and rolling springs", 8, 1.2, 0.6, friction=0.5,
                      rotation=True, friction_law="history", springs=Springs(rolling=Rolling(0.1, 0.1, 1.0))),
        _channel(),
        _scene("elastic box", "five discs, restitution 1, closed box",  # without damping, errors grow fastest
               [[0.3, 0.3], [0.7, 0.35], [0.4, 0.75], [0.8, 0.8], [0.55, 0.5]],
               [[4.0, -3.0], [0.0, 0.0], [0.0, 0.0], [-2.0, 1.0], [0.0, 0.0]],
               (Box("box", (0.0, 1.0), (0.0, 1.0)),), restitution=1.0, gravity=(0.0, 0.0)),
        _scene("gate", "a column behind a gate that opens after 600 steps", _heap(9, 6, 0.11), np.zeros((24, 2)),
               (Plane("back", "x", 0.0, "above"), FLOOR, shut), settle_steps=600),
        _scene("inlet and outlet", "two rows of inflow over a sill into an outlet", none, none,
               (Block("floor", (-4.0, 3.0), (-4.0, 0.0)), Block("sill", (1.2, 1.4), (-4.0, 0.15))),
               inlets=rows, outlets=outlets),
    )  # fmt: skip


# --- LAMMPS and the native engine compared on one case: disc by disc, then by statistics ------------------------------


LABELS = {"stock": "lammps_stock", "compiled": "lammps_compiled", "native": "native", "twin": "twin"}
"""Name of an ensemble in tables, by kernel."""


@dataclass(frozen=True)
class CrossValidation:
    """A cross-validation; its containers are filled part by part.

    Attributes
    ----------
    case : Case
        With the law and integrator that both engines have.
    scene : Scene
    kernel : {'stock', 'compiled'}
        LAMMPS kernel of the ensembles.
    folder : Path
        Keeps the runs of all members.
    pool : Pool
    seeds : tuple of int
        Of the members of each ensemble.
    notes : list of str
    say : callable
    checks, divergence
        Disc by disc.
    members : dict of list of Quantities
        By ensemble.
    laws : dict of str to (text, Comparison)
    """

    case: Case
    scene: Scene
    kernel: str
    folder: Path
    pool: Pool
    seeds: tuple[int, ...]
    notes: list[str]
    say: Say
    checks: list[DeterministicCheck] = field(default_factory=list)
    members: dict[str, list[Quantities]] = field(default_factory=dict)
    laws: dict[str, tuple[str, Comparison]] = field(default_factory=dict)

    def run(self, case: Case, kernel: str, label: str = "") -> str:
        """Run and measure an ensemble of a case; returns its name.

        Raises
        ------
        RunError
            A member that did not complete.
        """
        name = label or LABELS[kernel]
        case = case.replace({**KERNELS[kernel], "analysis.energy": True, "run.dump_format": "binary"})
        new: list[Start] = []
        starts = [Start(0, {}, seed) for seed in self.seeds]
        made = run_starts(case, starts, self.folder, self.pool, said=lambda one: new.append(one.start))
        for start, _, summary, message in made:
            if not summary:
                raise RunError(f"{name}, member {start.seed}: {message}")
            how = f"{summary['wall_seconds']['run']:z.1f} s" if start in new else "was there"
            self.say(f"{name}, member {start.seed}: {how}, {summary['discs']['present']} discs in play at the end")
        self.members[name] = [measure(one.folder, one.summary, case.scene()) for one in made]
        return name

    def compare(self, one: str, two: str, label: str = "") -> Comparison:
        """Compare two ensembles; `label` is the name of the second in the result."""
        return compare((one, label or two), self.members[one], self.members[two], FAMILY_ERROR)


MEMBERS, QUICK_MEMBERS = 6, 3
DIVERGENCE_WORK = 4e7
"""Disc-steps of the run in which the divergence is measured (a few seconds on each engine)."""
QUICK_DIVERGENCE_WORK = 5e6
SEQUENT_LIMIT, SPEED_LIMIT = 0.03, 0.10
"""Between the engines: sequent depth and shock speed of a jump (shares)."""
RESULT_FILE, REPORT_FILE = "cross_validation.json", "cross_validation.html"
Changes = dict[str, object]
VERLET: Changes = {"run.integrator": "velocity_verlet"}
VISCOUS: Changes = {"contact.friction_law": "viscous"}
WITHOUT_SPRINGS: Changes = {
    **VISCOUS, "contact.tangential_ratio": None, "contact.tangential_damping_ratio": None, "contact.rolling": None
}  # fmt: skip
LEAP_FROG: Changes = {"run.integrator": "leapfrog_extrapolated"}
SIGN: Changes = {"contact.friction_law": "sign"}
LAWS: dict[str, tuple[str, Changes]] = {
    "sign": ("friction law: thesis' sign law in place of LAMMPS' ramp", SIGN),
    "leap-frog": ("integrator: thesis' extrapolated leap-frog in place of velocity Verlet", LEAP_FROG),
    "without springs": ("friction law: LAMMPS' ramp in place of springs with memory", WITHOUT_SPRINGS),
    "uncorrected": ("restitution bias of velocity Verlet left in", {"contact.correct_restitution": False}),
    "thesis": ("all as in the thesis: sign law and extrapolated leap-frog", {**SIGN, **LEAP_FROG}),
}
"""Choices whose effect is measured: what differs from viscous friction, or springs, with velocity Verlet."""


def cross_validate(
    case: Case,
    *,
    out: Path | None = None,
    members: int | None = None,
    quick: bool = False,
    kernel: str = "auto",
    engine: str = "native",
    say: Say = print,
) -> dict[str, Any]:
    """Compare the engines on a case and leave ``cross_validation.json``, figures and a report in a folder.

    Parameters
    ----------
    case : Case
    out : Path, optional
        Default ``runs/<name>_cross_validation``. Finished members are kept in it: an interrupted study continues.
    members : int, optional
        Runs in each ensemble, at least 2; default 6, with `quick` 3.
    quick : bool
        Fewer members, a shorter divergence run, no comparison of laws.
    kernel : {'auto', 'stock', 'compiled'}
        LAMMPS kernel of the ensembles. The disc-by-disc part uses every kernel that runs here.
    engine : {'native', 'twin'}
        What LAMMPS' ensemble is compared with. The disc-by-disc part and the comparison of laws are of the native one.
    say : callable
        Takes a line on a result.

    Returns
    -------
    dict
        Content of the JSON file; ``passed`` is False where something that must agree does not.

    Raises
    ------
    CaseError, SetupError
        Before anything runs.
    RunError
        Where a run fails.
    """
    begin = time.perf_counter()
    with held_folder(out or default_folder(case.name), "cross-validate") as folder, Pool(usable_cores()) as pool:
        study = _prepare(case, folder, kernel, members, quick, pool, say)
        divergence = _disc_by_disc(study, QUICK_DIVERGENCE_WORK if quick else DIVERGENCE_WORK)
        comparison = study.compare(study.run(study.case, study.kernel), study.run(study.case, engine))
        for row in comparison.quantities:
            say(f"  {row['name']}: {row['text']}")
        if not quick:
            _laws(study, case)
        limits = criteria(study, comparison)
        report = as_dict(study, divergence, comparison, limits, time.perf_counter() - begin)
        write_json(folder / RESULT_FILE, report)
        chart = page.divergence(study.scene, study.checks, divergence)
        figures = page.draw_all(chart, comparison, study.laws, folder / "figures")
        page.write_report(report, study.scene.description, figures, folder / REPORT_FILE)
        return report


def as_dict(
    study: CrossValidation, divergence: Divergence, comparison: Comparison, criteria: list[Results], seconds: float
) -> dict[str, Any]:
    """Return what goes into ``cross_validation.json``.

    Parameters
    ----------
    study : CrossValidation
    divergence : Divergence
    comparison : Comparison
        Of the engines.
    criteria : list of dict
    seconds : float
        Wall time of the study, s.
    """
    passed = comparison.agrees and all(check.passed for check in study.checks)
    laws = {label: {"what": text, **law.stored()} for label, (text, law) in study.laws.items()}
    runs = {
        label: [{"seed": seed, **member.run} for seed, member in zip(study.seeds, group, strict=True)]
        for label, group in study.members.items()
    }
    return plain({
        "name": study.case.name,
        "passed": passed and all(item["met"] is not False for item in criteria),
        "seconds": seconds,
        "versions": all_versions(),
        "seeds": study.seeds,
        "jitter": JITTER,
        "confidence": CONFIDENCE,
        "family_error": FAMILY_ERROR,
        "time_step_fraction": study.scene.coefficients.time_step_fraction,
        "duration": study.scene.time(study.scene.steps),
        "lammps_kernel": study.kernel,
        "notes": study.notes,
        "disc_by_disc": study.checks,
        "divergence": divergence.found,
        "statistics": comparison.stored(),
        "criteria": criteria,
        "laws": laws,
        "runs": runs,
    })  # fmt: skip


def default_folder(name: str) -> Path:
    """Return the folder of the results where none is named."""
    return Path("runs") / f"{name}_cross_validation"


def _prepare(
    case: Case, folder: Path, kernel: str, members: int | None, quick: bool, pool: Pool, say: Say
) -> CrossValidation:
    """Return the study of a case with the same law and integrator for both engines.

    That is velocity Verlet and viscous friction, or springs where the case has them.
    """
    count = members if members is not None else (QUICK_MEMBERS if quick else MEMBERS)
    if count < 2:
        raise SetupError(f"--members {count}: a spread needs at least 2 members in each engine")
    alone = {"engine.kernel": "auto", "engine.ranks": 1, "run.stop_when_steady": False}
    case = case.replace({"engine.name": "lammps", **VERLET, **law_of(case), **alone})
    scene = case.scene()
    if scene.pours:
        raise SetupError(
            "cross-validate cannot compare a poured scene: the engines draw the places of poured discs from different "
            "random numbers; use a case with initial discs or an inflow of rows"
        )
    setting, notes = choose("lammps", kernel, 1, scene)
    if setting.engine != "lammps":
        raise SetupError(f"cross-validate needs LAMMPS beside the native engine: {notes[-1]}")
    seeds, said = tuple(range(1, count + 1)), [*scene.warnings, *notes]
    study = CrossValidation(case, scene, setting.kernel, folder, pool, seeds, said, say)
    for note in study.notes:
        say(f"note: {note}")
    return study


def law_of(case: Case) -> Changes:
    """Return the change of a case that gives it the friction law which all engines have."""
    return {} if FRICTION_LAWS[case.fields.contact.friction_law].remembers else VISCOUS


def _disc_by_disc(study: CrossValidation, work: float) -> Divergence:
    """Check small scenes and the case on every LAMMPS kernel; returns how the runs of the case part afterwards."""
    left_out = {"native"} | ({"stock"} if lacking(study.scene) else set())
    kernels = [kernel for kernel in usable_kernels()[0] if kernel not in left_out]
    own = (study.scene, trajectories.developed_scene(study.scene, work=10 * work))
    scenes = [*product(micro_scenes(), kernels)]
    scenes += [(friction_scene("sign"), "compiled")] if "compiled" in kernels else []
    for scene, kernel in [*scenes, *product(own, kernels)]:
        check = trajectories.check_scene(scene, kernel=kernel)
        if scene in own:
            check = check.explain(partial(trajectories.perturbed_separation, scene, check.last_step))
        study.checks.append(check)
        word = "agrees" if check.agrees else ("differs as expected" if check.passed else "DIFFERS")
        apart = f"{check.worst:z.1e} d over {CONTACT_STEPS} steps with contacts"
        study.say(f"disc by disc: {check.name} ({kernel}): {apart}, {word}")
    divergence = trajectories.measure_divergence(study.scene, kernels[0], work)
    engines, native = (_per(divergence.found[name]) for name in ("growth", "twin_growth"))
    study.say(f"divergence: grows by e every {engines} s, a perturbed native run every {native} s")
    return divergence


def _per(growth: Growth) -> str:
    return f"{1.0 / growth.rate:z.3g}" if growth.rate > 0 else "?"


def _laws(study: CrossValidation, case: Case) -> None:
    """Measure what each choice changes, on the native engine, which has them all."""
    rubs, elastic = study.scene.coefficients.friction > 0, study.scene.coefficients.restitution == 1
    base = case.replace({"engine.name": "native", **VERLET, **law_of(case), "engine.ranks": 1})
    springs = rubs and not law_of(case)
    rubs = rubs and not springs
    # without velocities in the force the two integrators are the same algebra: identical trajectories
    changing = {"sign": rubs, "thesis": rubs, "uncorrected": not elastic, "without springs": springs}
    changing["leap-frog"] = not springs and (rubs or not elastic)
    for label, (text, changes) in LAWS.items():
        if changing[label]:
            name = study.run(base.replace(changes), "native", f"native_{label}")
            study.laws[label] = text, study.compare("native", name, label)


def criteria(study: CrossValidation, comparison: Comparison) -> list[Results]:
    """Return the limits set beforehand for a jump without friction: sequent depth and shock speed.

    ``met`` is None where a limit is for information only.
    """
    rows: list[Results] = []
    for name, limit in (("sequent depth", SEQUENT_LIMIT), ("shock speed", SPEED_LIMIT)):
        row = comparison.find(name)
        if row is None or not study.case.fields.analysis.jump:
            continue
        share = abs(row["difference"] / row["mean_1"]) if isfinite(row["difference"]) and row["mean_1"] else nan
        met = share <= limit if isfinite(share) and study.scene.coefficients.friction == 0 else None
        rows.append({"name": f"{name} between the engines", "limit": limit, "value": share, "met": met})
    return rows
