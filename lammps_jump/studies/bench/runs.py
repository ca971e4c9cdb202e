"""One run of a case with one setting from one slightly moved start, timed and measured."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from lammps_jump.case import load_case
from lammps_jump.case.load import LoadedCase
from lammps_jump.case.to_scene import build_scene
from lammps_jump.engines.result import RunResult
from lammps_jump.errors import DumpError, JumpError, RunInterrupted
from lammps_jump.scene.scene import Scene
from lammps_jump.studies.timing import Stopwatch

from .settings import Setting

JITTER = 1e-6
"""Shift of the start, in diameters: small enough to change no mean, large enough that chaos makes runs independent."""

CURVE_POINTS = 20
JUMP_NUMBERS = (
    "froude", "y1", "y2", "sequent_ratio", "belanger_ratio", "density_ratio", "length", "length_over_y2", "length_usbr",
    "speed", "speed_error", "packing_1", "packing_2",
)  # fmt: skip
"""What the studies of sensitivity keep of a jump, in the words of ``summary.json``."""


def jittered(path: str | Path, assignments: list[str], member: int) -> list[str]:
    """Assignments that start member `member` of an ensemble: seed, and a shift of `JITTER` diameters.

    Discs at the start are shifted at random; a jet without any enters so much higher up.
    """
    case = load_case(path, assignments).case
    texts = [f"run.seed={case.run.seed + member}"]
    texts += [f"initial.{i}.jitter={max(item.jitter, JITTER)!r}" for i, item in enumerate(case.initial)]
    if case.inflow is not None and case.inflow.kind == "rows" and member:
        texts.append(f"inflow.y={case.inflow.y + member * JITTER * case.discs.diameter!r}")
    return texts


def run_setting(
    path: str | Path, assignments: list[str], setting: Setting, member: int, work: Path | None = None
) -> dict[str, Any]:
    """Run and measure.

    Parameters
    ----------
    path : path
        Case file.
    assignments : list of str
        ``--set`` texts common to all settings.
    setting : Setting
    member : int
        Number of the slightly moved start.
    work : Path, optional
        Folder for the run's files; a temporary one by default, removed afterwards.

    Returns
    -------
    dict
        status, message, cpu_seconds, wall_seconds, steps, disc_steps, breakdown (s), measures.

    Raises
    ------
    RunInterrupted
        Where the user ended the run.
    """
    own = load_case(path, assignments).case
    texts = [*assignments, *setting.assignments(own.discs.diameter)]
    try:
        texts += jittered(path, texts, member)
        loaded = load_case(path, texts)
        scene = build_scene(loaded)
    except JumpError as error:
        return {"status": "refused", "message": str(error), "measures": {}}
    with tempfile.TemporaryDirectory(dir=work) as folder:
        result, watch = execute(scene, Path(folder), setting.kernel, setting.ranks)
        if result.status == "interrupted":  # no result to be stored: the study ends here
            raise RunInterrupted("the study was ended; what it had is kept, and the same command goes on from there")
        measures: dict[str, Any] = {}
        message = result.message
        if result.status == "complete":
            try:
                measures = measure(Path(folder), scene, loaded, result)
            except DumpError as error:
                message = str(error)
    return {
        "status": result.status,
        "message": message.replace(str(folder), "the run folder"),
        "cpu_seconds": watch.cpu,
        "wall_seconds": watch.wall,
        "steps": result.steps,
        "disc_steps": result.disc_steps,
        "breakdown": dict(result.breakdown),
        "measures": measures,
    }


def execute(
    scene: Scene, folder: Path, kernel: str, ranks: int = 1, *, dump_format: str = "text"
) -> tuple[RunResult, Stopwatch]:
    """Run a scene in `folder`; the watch covers the engine alone, without compiling anything."""
    if kernel == "native":
        from lammps_jump.engines.native import run_native

        warm_up(scene)
        with Stopwatch() as watch:
            result = run_native(scene, folder, dump_format=dump_format)
        return result, watch
    from lammps_jump.engines.launch import Setting, run

    plugin = None
    if kernel == "compiled":
        from lammps_jump.engines.plugin.build import plugin_path

        plugin = plugin_path()
    setting = Setting(kernel=kernel, ranks=ranks, plugin=plugin, dump_format=dump_format)
    result = run(scene, folder, setting)
    watch = Stopwatch()
    watch.wall, watch.cpu = result.seconds, result.cpu_seconds
    return result, watch


_WARM: set[tuple] = set()


def warm_up(scene: Scene) -> None:
    """Compile the native kernels for this kind of scene once, so that no timing holds a compilation."""
    from dataclasses import replace

    from lammps_jump.engines.native import run_native

    c = scene.coefficients
    kind = (scene.integrator, scene.rotation, scene.friction_law, c.friction > 0, scene.touch, bool(scene.probes))
    if kind not in _WARM:
        run_native(replace(scene, steps=2, output_steps=2, probe_steps=1), None)
        _WARM.add(kind)


def measure(folder: Path, scene: Scene, loaded: LoadedCase, result: RunResult) -> dict[str, Any]:
    """What the case asks of a run, as numbers and curves: energy, front, jump, impulse on structures."""
    from lammps_jump.analysis.flow import from_scene
    from lammps_jump.dump.find import open_run_dump, read_forces

    asked = loaded.case.analysis
    context = from_scene(scene, bin_width=asked.bin_width, window=asked.window)
    measures: dict[str, Any] = {}
    dump = open_run_dump(folder)
    if asked.energy:
        measures |= _energy(dump, context)
    if asked.front:
        measures |= _front(dump, context, loaded.case.run.duration)
    if asked.jump:
        measures |= _jump(dump, context)
    if scene.probes and (folder / "forces.csv").is_file():
        for name, history in read_forces(folder / "forces.csv").items():
            window = scene.probe_steps * scene.time_step
            measures[f"impulse {name}"] = float(np.hypot(history.fx.sum(), history.fy.sum()) * window)
    return measures


def _energy(dump, context) -> dict[str, Any]:
    from lammps_jump.analysis.energy import EnergyLedger, summarise_energy

    ledger = EnergyLedger(context)
    for frame in dump:
        ledger.add(frame, context.time(frame))
    summary = summarise_energy(ledger.result(), context)
    return {"energy deviation": summary["max_deviation"]}


def _front(dump, context, duration: float) -> dict[str, Any]:
    from lammps_jump.analysis.front import FrontTracker, summarise_front

    tracker = FrontTracker(context)
    for frame in dump:
        tracker.add(frame, context.time(frame))
    history = tracker.result()
    times = np.linspace(0.1, 1.0, CURVE_POINTS) * duration
    return {
        "front position": np.interp(times, history.time, history.quantile).tolist(),
        "column height": np.interp(times, history.time, history.height).tolist(),
        "martin_moyce": summarise_front(history, context).get("martin_moyce"),
    }


def _jump(dump, context) -> dict[str, Any]:
    from lammps_jump.analysis.jump.result import analyse_jump
    from lammps_jump.analysis.jump.summary import summarise_jump
    from lammps_jump.analysis.profiles import compute_profiles

    profiles = compute_profiles(dump, context)
    summary = summarise_jump(analyse_jump(profiles, context))
    depth = profiles["mass_depth_mean"].values
    good = np.isfinite(depth)
    return {
        "depth profile": np.where(good, depth, 0.0).tolist(),
        "sequent depth": summary["y2"],
        "shock speed": summary["speed"],
        "verdict": summary["verdict"],
        "jump": {name: summary.get(name) for name in JUMP_NUMBERS},
    }
