# SPDX-License-Identifier: GPL-2.0-or-later
"""What several tests make up: contexts, frames of discs placed by hand, the plugin or a reason to go without."""

from __future__ import annotations

import base64
import json
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from features import BASE, FEATURES
from hypothesis import settings

import lammps_jump as lj
from lammps_jump.analysis.flow import Flow
from lammps_jump.analysis.guess import known_coefficients
from lammps_jump.analysis.pipeline import Deferred
from lammps_jump.cli.app import main
from lammps_jump.dump.check import FrameCheck, damages, force_troubles
from lammps_jump.dump.find import read_dump
from lammps_jump.dump.frame import Frame, make_frame
from lammps_jump.engines.choice import choose
from lammps_jump.engines.native import NativeSimulation
from lammps_jump.engines.native.engine import take_frame
from lammps_jump.engines.setting import Setting
from lammps_jump.errors import DumpError
from lammps_jump.files import END_FILE, SUMMARY_FILE, checksum, plain
from lammps_jump.runs import results, start
from lammps_jump.scene.motion import MovingWall
from lammps_jump.scene.scene import Scene
from lammps_jump.script.stock import lacking
from lammps_jump.sweeps import pool
from lammps_jump.units import as_summary

INPUTS = Path(__file__).parents[1] / "inputs"

SCENES = [path for path in sorted(INPUTS.glob("*.yaml")) if "kind: run" not in path.read_text(encoding="utf-8")]
"""Case files of the scenes, without those that begin from another run."""

BOX = {
    "name": "box", "gravity": 0.0, "discs": {"diameter": 0.2}, "contact": {"restitution": 1.0, "impact_speed": 8},
    "domain": {"x": [-1, 3], "y": [-1, 3]},
    "walls": [{"name": "box", "kind": "box", "x": [0, 2], "y": [0, 2]}],
    "initial": [{"kind": "lattice", "nx": 4, "ny": 4, "spacing": 0.45, "origin": [0.3, 0.3],
                 "velocities": {1: [6.0, 5.0]}}],
    "probes": {"forces": ["box"]},
    "run": {"duration": 0.3, "time_step_fraction": 0.1, "output_interval": 0.05},
    "engine": {"name": "native"},
}  # fmt: skip
"""A case of sixteen discs in a box."""
STUDY = {
    "case": BOX,
    "axes": {"run.time_step_fraction": [0.05, 0.1], "discs.density": [500, 1000]},
    "members": 2,
    "collect": ["energy.max_deviation", "force.box.impulse_x", "discs.present"],
}
"""Four points of two members."""


def some_long(value, long=True):
    """A parameter, or a tuple of several, left out of the default run where it is `long`: others are its kind."""
    values = value if isinstance(value, tuple) else (value,)
    return pytest.param(*values, marks=pytest.mark.long) if long else pytest.param(*values)


def examples(number: int) -> settings:
    """Random examples of a test that wants another number than most; a third in the default run, as of the others."""
    return settings(max_examples=number // 3 if settings.default.derandomize else number)


def run_case(path: Path, folder: Path, changes: Iterable[str] = (), **options) -> dict:
    """Summary of a case run in a folder; `changes` are ``--set`` texts."""
    return dict(lj.load_case(path, changes).run(folder, **options).summary)


def analysed_again(folder: Path) -> dict:
    """Summary of a run folder that is analysed again."""
    start.reanalyse(folder)
    return dict(lj.open_run(folder).summary)


def call(monkeypatch, capsys, *arguments) -> tuple[int, str, str]:
    """Exit status, stdout and stderr of the command line."""
    monkeypatch.setattr(sys, "argv", ["lammps-jump", *map(str, arguments)])
    monkeypatch.setattr(pool, "prepare_workers", lambda: None)  # a second each; most commands run nothing
    with pytest.raises(SystemExit) as stop:
        main()
    captured = capsys.readouterr()
    assert "Traceback" not in captured.err
    return int(stop.value.code or 0), captured.out, captured.err


class Here:
    """A pool without processes."""

    def __init__(self, jobs):
        pass

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    def run(self, calls, *, done, **_):
        for number, call in enumerate(calls):
            try:
                done(number, pool.CallOutcome("done", call()))
            except RuntimeError as error:
                done(number, pool.CallOutcome("bug", f"RuntimeError: {error}"))


def files(folder: Path) -> dict[str, bytes]:
    """Contents of every file below a folder."""
    return {str(path): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


GREY_PIXEL = base64.b64decode(
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAAAAAA6fptVAAAACklEQVR4nGNoAAAAggCBd81ytgAAAABJRU5ErkJggg=="
)

COEFFICIENTS = (
    "mass", "stiffness", "stiffness_wall", "time_step", "restitution", "friction",
    "gamma_tangential", "gamma_tangential_wall",
)  # fmt: skip
FLOW = (
    "x_range", "bin_width", "window", "inflow_depth", "inflow_speed", "notes", "sized", "timed", "water", "poses",
    "layers", "heads_at",
)  # fmt: skip


def flow_context(*, dashpot=0.0, dashpot_wall=0.0, **given) -> Flow:
    """A flow of discs of 0.2 m and 40 kg; at least `domain` and `x_range` are the test's own.

    Fields of Flow, of Scene and of its Coefficients side by side; `dashpot` of a pair, `dashpot_wall` at walls, N s/m.
    """
    given = {"mass": 40.0, "bin_width": 1.0, **given}
    known = {name: given.pop(name) for name in COEFFICIENTS if name in given}
    known.setdefault("stiffness_wall", known.get("stiffness"))
    known |= {"gamma_normal": dashpot / (0.5 * known["mass"]), "gamma_normal_wall": dashpot_wall / known["mass"]}
    flow = {name: given.pop(name) for name in FLOW if name in given}
    walls = (one if isinstance(one, MovingWall) else MovingWall(one) for one in given.pop("walls", ()))
    nothing = {"description": "", "positions": np.empty((0, 2)), "velocities": np.empty((0, 2)), "walls": tuple(walls)}
    law = {"friction_law": "viscous", "rotation": False, "integrator": "velocity_verlet"}
    discs = {"name": "made-up", "diameter": 0.2, "density": 1000.0, "gravity": (0.0, -9.81)}
    return Flow(Scene(**nothing | law | discs | given, coefficients=known_coefficients(**known)), **flow)


def disc_frame(x, y, vx=0.0, vy=0.0, *, box, step=0, time=0.0, **more) -> Frame:
    """Discs 1 … n at (x, y); velocities are numbers or one value a disc, `more` are further columns."""
    x, y = np.asarray(x, float), np.asarray(y, float)
    columns = {"id": np.arange(len(x)) + 1, "x": x, "y": y, "vx": 0 * x + vx, "vy": 0 * x + vy, **more}
    return make_frame(step, time, box, columns)


def numbers(result) -> dict:
    """A result of the analysis as it stands in ``summary.json``."""
    return plain(as_summary(result))


def columns_of_discs(layers, low, high, *, d=0.2, bed=0.0) -> tuple[np.ndarray, np.ndarray]:
    """Centres of touching discs between x = low and high, `layers` high: a number, or a function of the column's x."""
    centres = np.arange(low + d / 2, high, d)
    number = np.broadcast_to(np.round(layers(centres) if callable(layers) else layers), centres.shape).astype(int)
    return np.repeat(centres, number), bed + d * (np.concatenate([np.arange(n) for n in number]) + 0.5)


def collected(collector, frames):
    """What a collector of the analysis (anything with ``add(frame, time)`` and ``result()``) makes of frames."""
    for frame in frames:
        collector.add(frame, frame.time)
    return collector.result()


@contextmanager
def coreless() -> Iterator[None]:
    """As on a machine without a compiler: while the block runs there is no core."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("lammps_jump.core.library._loaded", lambda: (None, "no core while the block runs"))
        yield


def plugin_or_skip() -> Path:
    """The compiled plugin, built where needed; the test is skipped, with the reason, where it cannot be had."""
    from lammps_jump.engines.plugin import plugin_path
    from lammps_jump.errors import SetupError

    try:
        return plugin_path()
    except SetupError as error:
        pytest.skip(f"no compiled kernel here: {error}")


def reseal(folder: Path) -> None:
    """Give the summary of a run the checksum of the end state that is there."""
    path = folder / SUMMARY_FILE
    stored = json.loads(path.read_text())
    stored["outputs"][END_FILE] = checksum(folder / END_FILE)
    path.write_text(json.dumps(stored))


def choose_to_stop_at(step: int):
    """In place of `lammps_jump.engines.choice.choose`: what it chooses, ended as by an interruption at a step."""

    def stopping(*arguments):
        setting, notes = choose(*arguments)
        return replace(setting, stop_at=step), notes

    return stopping


def without_analysis(monkeypatch) -> None:
    """No figures and no tables, which take seconds; the frames are checked all the same."""

    def analyse(case, flow, folder, out, packer, watch=(), gathered=None, report=None):
        (out / "profiles.nc").write_text(f"of {case.name}")
        source = read_dump(folder) if gathered is None else gathered
        for frame in source if gathered is None else ():
            for collector in watch:
                collector.add(frame, frame.time)
        return {"warnings": list(source.warnings)}, None  # what the reader says decides whether a run is complete

    monkeypatch.setattr(results, "analyse", analyse)
    monkeypatch.setattr(results, "write_report", lambda folder, *_, **__: (folder / "report.html").write_text(""))


def blank_figures(names, shown, folder, dump, flow, ending="png", **more) -> None:
    """In place of `lammps_jump.analysis.pipeline.draw_figures`: files of one grey pixel."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in names:
        (folder / f"{name}.{ending}").write_bytes(GREY_PIXEL)


@contextmanager
def on_the_spot(work, *given, **named):
    """In place of `lammps_jump.analysis.pipeline.aside`, whose second process costs more than blank figures."""
    done = Deferred()
    done.value = work(*given, **named)
    yield done


def troubles(folder: Path, run: lj.Run) -> list[str]:
    """What the checks at the end of a run find wrong with frames and forces in a folder, without the rest of a run."""
    scene = run.scene
    check = FrameCheck(scene)
    try:
        dump = read_dump(folder)
        for frame in dump:
            check.add(frame, frame.time)
        found = [*check.result(scene.steps, run.result.present), *damages(dump.warnings)]
    except DumpError as error:
        found = [str(error)]
    return found + force_troubles(folder / "forces.csv", scene, scene.steps)


def engine_setting(engine: str, **options) -> Setting:
    """Setting of 'native', 'compiled' or 'stock', with a binary dump; skips where the plugin cannot be had."""
    kinds = {
        "native": lambda: {"engine": "native", "kernel": "core"},
        "compiled": lambda: {"kernel": "compiled", "plugin": plugin_or_skip()},
        "stock": lambda: {"kernel": "stock"},
    }
    return Setting(dump_format="binary", **kinds[engine](), **options)


def lacks(scene: Scene, engine: str) -> str:
    """What an engine of `engine_setting` lacks of a scene; empty where it has all."""
    return lacking(scene) if engine == "stock" else ""


def scene_of_feature(feature: str, engine: str) -> Scene | None:
    """The scene of one of `features.FEATURES`; None where an engine of `engine_setting` lacks it."""
    fields = {**BASE, **FEATURES[feature], "engine": {"name": "native" if engine == "native" else "lammps"}}
    if engine != "native" and "stations" in fields["probes"]:
        return None  # the case is refused
    scene = lj.load_case(fields).scene()
    return None if lacks(scene, engine) else scene


def native_frames(scene):
    """Frames of a run of the native engine, held in memory."""
    simulation = NativeSimulation(scene, ledger=False)
    yield take_frame(simulation)
    while simulation.step < scene.steps:
        simulation.run(scene.output_steps)
        yield take_frame(simulation)
