"""LAMMPS and the native engine held against each other on one case: disc by disc, then by statistics.

Three parts: the engines must walk the same path over the first thousand steps with contacts (same law, same
integrator, same start); afterwards their ensembles must not differ; and what the choice of friction law, integrator
and restitution correction changes is measured. `docs/cross_validation.md` says how to read the result.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from math import nan
from pathlib import Path
from typing import Any

import numpy as np

from lammps_jump.case import load_case
from lammps_jump.case.to_scene import build_scene
from lammps_jump.errors import SetupError
from lammps_jump.runs.progress import ProgressLine
from lammps_jump.scene.scene import Scene

from .divergence import TWIN_JITTER, measure_divergence
from .ensembles import EngineChoice, Member, perturbed, run_ensemble
from .outcome import Study
from .quantities import Wanted, compare, measure
from .scenes import friction_scene, micro_scenes
from .statistics import FAMILY_ERROR
from .trajectories import CONTACT_STEPS, Growth, check_scene, developed_scene, twin_separation

MEMBERS, QUICK_MEMBERS = 6, 3
DIVERGENCE_WORK = 4e7
"""Disc-steps of the run in which the divergence is measured (a few seconds on each engine)."""
QUICK_DIVERGENCE_WORK = 5e6
SEQUENT_LIMIT, SPEED_LIMIT = 0.03, 0.10
"""Between the engines: sequent depth and shock speed of a jump (shares)."""
RESULT_FILE, REPORT_FILE = "cross_validation.json", "cross_validation.html"

Say = Callable[[str], None]
CHAOS_SHARE = 0.1
CHAOS = "the native engine, started a few last digits off, parts from itself by {:.1e} d in these steps"
"""Why a case may part within the steps compared: where its twin has parted by at least this share of it."""


def cross_validate(
    path: str | Path,
    *,
    out: Path | None = None,
    assignments: list[str] | None = None,
    members: int | None = None,
    quick: bool = False,
    kernel: str = "auto",
    quiet: bool = False,
    say: Say = print,
) -> dict[str, Any]:
    """Compare the engines on a case and leave ``cross_validation.json``, figures and a report in a folder.

    Parameters
    ----------
    path : str or Path
        Case file.
    out : Path, optional
        Default ``runs/<name>_cross_validation``. Finished members are kept in it: an interrupted study goes on.
    assignments : list of str, optional
        ``--set`` texts.
    members : int, optional
        Runs in each ensemble, at least 2; default 6, with `quick` 3.
    quick : bool
        Fewer members, a shorter divergence run, no comparison of laws.
    kernel : {'auto', 'stock', 'compiled'}
        LAMMPS kernel of the ensembles; the disc-by-disc part uses stock, and the compiled one
        where there is one.

    Returns
    -------
    dict
        What is in the JSON file; ``passed`` is False where something that must agree does not.

    Raises
    ------
    CaseError, SetupError
        Before anything runs.
    RunError
        Where a run fails.
    """
    begin = time.perf_counter()
    count = members if members is not None else (QUICK_MEMBERS if quick else MEMBERS)
    if count < 2:
        raise SetupError(f"--members {count}: a spread needs at least 2 members in each engine")
    study = _prepare(path, assignments or [], kernel)
    folder = out or Path("runs") / f"{study.name}_cross_validation"
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise SetupError(f"{folder}: cannot be made ({error.strerror or error}); name another with --out") from None
    for note in study.notes:
        say(f"note: {note}")
    _disc_by_disc(study, say, QUICK_DIVERGENCE_WORK if quick else DIVERGENCE_WORK)
    seeds = list(range(1, count + 1))
    _ensembles(study, seeds, folder, quiet, say)
    if not quick:
        _laws(study, path, assignments or [], seeds, folder, quiet, say)
    study.criteria = criteria(study)
    study.seconds = time.perf_counter() - begin
    from .figures import draw_all
    from .report import as_dict, write_report

    report = as_dict(study, seeds)
    (folder / RESULT_FILE).write_text(json.dumps(report, indent=1, allow_nan=False) + "\n")
    figures = draw_all(study, folder / "figures")
    write_report(study, report, figures, folder / REPORT_FILE)
    return report


def run_command(path: Path, *, out: Path | None, quiet: bool, say: Say, **options) -> bool:
    """`cross_validate` for the command line: prints the outcome; whether everything that must agree does."""
    from .report import verdict_text

    report = cross_validate(path, out=out, quiet=quiet, say=say, **options)
    folder = out or Path("runs") / f"{report['name']}_cross_validation"
    if not quiet or not report["passed"]:
        print(f"{verdict_text(report)}\nlook at {folder / REPORT_FILE}")
    return report["passed"]


def _prepare(path: str | Path, assignments: list[str], kernel: str) -> Study:
    """Same law and integrator for both engines: hooke and velocity Verlet."""
    base = [*assignments, "engine.name=lammps", "run.integrator=velocity_verlet", "contact.friction_law=hooke"]
    loaded = load_case(path, [*base, "engine.kernel=auto", "engine.ranks=1", "run.stop_when_steady=false"])
    scene = build_scene(loaded)
    notes = [*scene.warnings]
    if scene.pours:
        raise SetupError(
            "cross-validate cannot compare a poured scene: the engines draw the places of poured discs from different "
            "random numbers; use a case with initial discs or an inflow of rows"
        )
    engine, more = choose_engine(kernel, scene)
    return Study(
        name=loaded.case.name, scene=scene, loaded=loaded, engine=engine, checks=[], known={},
        divergence=None, members={}, quantities={}, comparison=None, laws={}, criteria=[], notes=[*notes, *more],
    )  # fmt: skip


def choose_engine(kernel: str, scene: Scene) -> tuple[EngineChoice, list[str]]:
    """The LAMMPS kernel of the ensembles.

    Raises
    ------
    SetupError
        No LAMMPS; or the compiled kernel is asked for (or needed by a smooth touch) and not to be had.
    """
    from lammps_jump.engines.lammps.loader import load_lammps
    from lammps_jump.engines.plugin.build import availability, plugin_path

    load_lammps()
    if kernel not in ("auto", "stock", "compiled"):
        raise SetupError(f"--kernel {kernel}: is not known; use auto, stock or compiled")
    smooth = scene.touch == "smooth"
    if kernel == "stock" and smooth:
        raise SetupError("--kernel stock: 'touch: smooth' is not in stock LAMMPS; use --kernel compiled")
    if kernel == "stock":
        return EngineChoice("lammps", "stock"), []
    try:
        status = availability()
        if not status.available:
            raise SetupError(status.reason)
        return EngineChoice("lammps", "compiled", plugin_path()), []
    except SetupError as error:
        if kernel == "compiled" or smooth:
            raise
        return EngineChoice("lammps", "stock"), [f"the ensembles use stock LAMMPS styles: {error}"]


def _kernels(study: Study) -> list[tuple[str, Path | None]]:
    """Kernels for the disc-by-disc part."""
    stock = [] if study.scene.touch == "smooth" else [("stock", None)]
    plugin = study.engine.plugin
    if plugin is None:
        from lammps_jump.engines.plugin.build import availability

        plugin = availability().path
    return stock + ([("compiled", plugin)] if plugin else [])


def _disc_by_disc(study: Study, say: Say, work: float) -> None:
    kernels = _kernels(study)
    scenes = [(scene, kernel) for scene in micro_scenes() for kernel in kernels]
    scenes += [(friction_scene("sign"), kernel) for kernel in kernels if kernel[0] == "compiled"]
    developed = developed_scene(study.scene, work=10 * work)
    scenes += [(scene, kernel) for scene in (study.scene, developed) for kernel in kernels]
    for scene, (kernel, plugin) in scenes:
        check = check_scene(scene, kernel=kernel, plugin=plugin)
        study.checks.append(check)
        if not check.agrees and not check.note and scene.name in (study.scene.name, developed.name):
            own = twin_separation(scene, perturbed(scene, 1, TWIN_JITTER), check.last_step)
            if own >= CHAOS_SHARE * check.worst:
                study.known[(scene.name, kernel)] = CHAOS.format(own)
        word = "agrees" if check.agrees else ("differs as expected" if study.expected(check) else "DIFFERS")
        say(
            f"disc by disc: {check.name} ({kernel}): {check.worst:.1e} d over {CONTACT_STEPS} steps with contacts, "
            f"{word}"
        )
    study.divergence = measure_divergence(study.scene, *kernels[0], work)
    growth, twin = study.divergence.growth, study.divergence.twin_growth
    say(f"divergence: grows by e every {_per(growth)} s, a native twin every {_per(twin)} s")


def _per(growth: Growth) -> str:
    return f"{1.0 / growth.rate:.3g}" if growth.rate > 0 else "?"


def _ensembles(study: Study, seeds: list[int], folder: Path, quiet: bool, say: Say) -> None:
    request = study.loaded.case.analysis
    wanted = wanted_of(study)
    for engine in (study.engine, EngineChoice("native")):
        members = run_ensemble(
            study.scene, seeds, engine, folder / "members", bin_width=request.bin_width, window=request.window,
            before=_before(study.scene, quiet), after=_after(say),
        )  # fmt: skip
        study.members[engine.label] = members
        study.quantities[engine.label] = [
            measure(member, study.scene, wanted, request.bin_width, request.window) for member in members
        ]
    one, two = study.quantities
    study.comparison = compare(one, study.quantities[one], two, study.quantities[two], FAMILY_ERROR)
    for verdict in study.comparison.verdicts:
        say(f"  {verdict.name}: {verdict.text}")


def wanted_of(study: Study) -> Wanted:
    """Which analyses the case asks for."""
    case, scene = study.loaded.case, study.scene
    conservative = scene.coefficients.restitution == 1.0 and not scene.coefficients.friction and not scene.inlets
    return Wanted(case.analysis.front, case.analysis.jump, conservative)


def _before(scene: Scene, quiet: bool):
    line: list[ProgressLine] = []

    def start(name: str, seed: int) -> ProgressLine:
        if line:
            line[0].finish()
        line[:] = [ProgressLine(scene.time(scene.steps), quiet=quiet)]
        return line[0]

    return start


def _after(say: Say):
    def tell(member: Member) -> None:
        result = member.result
        how = f"{result['seconds']:.1f} s" if member.fresh else "was there"
        say(f"{member.engine}, member {member.seed}: {how}, {result['present']} discs in play at the end")

    return tell


LAWS = {
    "sign": ("friction law: thesis' sign law in place of LAMMPS' ramp", ["contact.friction_law=sign"]),
    "leap-frog": ("integrator: thesis' extrapolated leap-frog in place of velocity Verlet",
                  ["run.integrator=leapfrog_extrapolated"]),
    "uncorrected": ("restitution bias of velocity Verlet left in", ["contact.correct_restitution=false"]),
    "thesis": ("all as in the thesis: sign law and extrapolated leap-frog",
               ["contact.friction_law=sign", "run.integrator=leapfrog_extrapolated"]),
}  # fmt: skip


def _laws(study: Study, path, assignments: list[str], seeds: list[int], folder: Path, quiet: bool, say: Say) -> None:
    """What each choice changes, on the native engine, which has them all."""
    case, scene = study.loaded.case, study.scene
    rubs = scene.coefficients.friction > 0
    request = case.analysis
    wanted = wanted_of(study)
    for label, (text, changes) in LAWS.items():
        if (label in ("sign", "thesis") and not rubs) or (label == "uncorrected" and case.contact.restitution == 1):
            continue
        if label == "leap-frog" and case.contact.restitution == 1 and not rubs:
            # without velocities in the force the two integrators are the same algebra: identical trajectories
            continue
        base = [*assignments, "engine.name=native", "run.integrator=velocity_verlet", "contact.friction_law=hooke"]
        other = build_scene(load_case(path, [*base, "engine.ranks=1", *changes]))
        members = run_ensemble(
            other, seeds, EngineChoice("native"), folder / "members", bin_width=request.bin_width,
            window=request.window, label=f"native_{label}", before=_before(other, quiet), after=_after(say),
        )  # fmt: skip
        found = [measure(member, other, wanted, request.bin_width, request.window) for member in members]
        study.members[f"native_{label}"] = members
        study.quantities[f"native_{label}"] = found
        study.laws[label] = text, compare("native", study.quantities["native"], label, found, FAMILY_ERROR)


def criteria(study: Study) -> list[dict[str, Any]]:
    """Limits set beforehand for a jump without friction: sequent depth and shock speed between the engines."""
    rows: list[dict[str, Any]] = []
    if study.comparison is None or not wanted_of(study).jump:
        return rows
    without_friction = study.scene.coefficients.friction == 0
    for name, limit in (("sequent depth", SEQUENT_LIMIT), ("shock speed", SPEED_LIMIT)):
        verdict = study.comparison.find(name)
        if verdict is None:
            continue
        d = verdict.difference
        share = abs(d.difference / d.mean_1) if np.isfinite(d.difference) and d.mean_1 else nan
        met = bool(share <= limit) if np.isfinite(share) and without_friction else None
        rows.append({"name": f"{name} between the engines", "limit": limit, "value": share, "met": met})
    return rows
