# SPDX-License-Identifier: GPL-2.0-or-later
"""A whole run of the native engine: stepping, frames, progress, guards, result."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter, process_time

from lammps_jump.dump.find import write_forces
from lammps_jump.dump.frame import Frame, make_frame
from lammps_jump.dump.write import run_writer
from lammps_jump.engines import step_hook
from lammps_jump.engines.checkpoint import Checkpoint, cut_back, remove_checkpoint, write_checkpoint
from lammps_jump.engines.interrupts import counted_interrupts
from lammps_jump.engines.result import Progress, ProgressCallback, RunResult, interruption
from lammps_jump.errors import RunError
from lammps_jump.files import DUMP_NAMES
from lammps_jump.provenance import versions
from lammps_jump.scene.scene import Scene

from .cells import CellSimulation
from .simulation import NativeSimulation
from .state import load_state, save_state


def take_frame(simulation) -> Frame:
    """The discs of a simulation now, sorted by id."""
    scene, (x, y), (vx, vy) = simulation.scene, simulation.positions.T, simulation.velocities.T
    spin = {"omegaz": simulation.spin} if scene.rotation else {}
    radius = {"radius": simulation.radii} if scene.sizes else {}
    columns = {"id": simulation.ids, "x": x, "y": y, "vx": vx, "vy": vy, **spin, **radius}
    box = (*scene.domain, (-scene.radius, scene.radius))
    return make_frame(simulation.step, scene.time(simulation.step), box, columns)


def make_simulation(scene: Scene, cell_size: float | None = None, ledger: bool = True) -> NativeSimulation:
    """The simulation with neighbour lists, or with the thesis' cells of a width (m); see `run_native`."""
    if cell_size is None:
        return NativeSimulation(scene, ledger=ledger)
    return CellSimulation(scene, cell_size=cell_size, ledger=ledger)


def run_native(
    scene: Scene,
    folder: Path | None,
    *,
    progress: ProgressCallback | None = None,
    should_stop: Callable[[], bool] | None = None,
    stop_at: int | None = None,
    dump_format: str = "text",
    report_every: float = 0.5,
    cell_size: float | None = None,
    ledger: bool = True,
    resume: Checkpoint | None = None,
) -> RunResult:
    """Run a scene on the native engine and leave dump and forces.csv in `folder`.

    Parameters
    ----------
    scene : Scene
    folder : Path or None
        Folder for the files, made where it is missing; None writes none.
    progress : callable, optional
        Called with a `Progress` every `report_every` seconds of wall time, and once at the end.
    should_stop : callable, optional
        Asked after every tenth of a second of work; True ends the run as 'interrupted'.
    stop_at : int, optional
        End the run as 'interrupted' at this step.
    dump_format : {'text', 'gz', 'binary'}
    cell_size : float, optional
        Use the thesis' own contact search in square cells of this width, m, in place of neighbour lists.
    ledger : bool
        Keep the energy ledger; a quarter of the stepping time.
    resume : Checkpoint, optional
        Go on with the interrupted run that left it in `folder` (see `lammps_jump.engines.checkpoint`), with the same
        scene, `dump_format` and `ledger`. Its frames are those of an uninterrupted run, bit for bit.

    Returns
    -------
    RunResult
        Status 'failed' with a message where a guard ended the run; what there was is kept.
    """
    if resume is not None:
        cut_back(folder, resume)
        simulation = load_state(scene, Path(folder) / resume.state, ledger=ledger)
    else:
        simulation = make_simulation(scene, cell_size, ledger)
    if folder is not None:
        Path(folder).mkdir(parents=True, exist_ok=True)
        if resume is None:
            remove_checkpoint(Path(folder))  # of an earlier run: not this one's beginning
    append = resume is not None
    writer = run_writer(Path(folder), scene, dump_format, append=append) if folder is not None else None

    def output() -> None:
        if writer is not None:
            writer.write_frame(take_frame(simulation))

    def report() -> None:
        if progress is not None:
            progress(Progress(simulation.step, scene.steps, scene.time(simulation.step), simulation.discs.n))

    last = scene.steps if stop_at is None else min(stop_at, scene.steps)
    status, message = "complete", ""
    spent = _Spent()
    processor = process_time()
    try:
        with counted_interrupts() as pressed:
            if resume is None:
                output()
            reported = perf_counter()
            while simulation.step < last:
                now = _to_next_output(simulation, last, spent, output)
                if now - reported >= report_every:
                    reported = now
                    report()
                if simulation.step < scene.steps and (pressed() or (should_stop is not None and should_stop())):
                    raise KeyboardInterrupt
            if simulation.step < scene.steps:
                raise KeyboardInterrupt
    except KeyboardInterrupt:
        status = "interrupted"
    except RunError as error:
        status, message = "failed", str(error)
    finally:
        if writer is not None:
            writer.close()
            if scene.probes:
                write_forces(Path(folder) / "forces.csv", scene, simulation.forces)
    report()
    spent.processor = process_time() - processor
    result = _result(scene, simulation, status, message, spent, resume.result if resume else None)
    if status == "interrupted":
        result = _interrupted(simulation, folder, dump_format, result, cell_size is None, spent.between_steps)
    return result


@dataclass
class _Spent:
    """Seconds of stepping, of writing and of the processor, and whether the stepping stands between two steps.

    An interruption that did not wait may leave arrays half sorted, or half a frame.
    """

    seconds: float = 0.0
    writing: float = 0.0
    processor: float = 0.0
    between_steps: bool = False


def _to_next_output(simulation, last: int, spent: _Spent, output: Callable[[], None]) -> float:
    """Step towards the next frame, for a tenth of a second at most, and write it there; the clock after the steps."""
    every = simulation.scene.output_steps
    target = min(last, (simulation.step // every + 1) * every)
    started = perf_counter()
    spent.between_steps = False
    if step_hook.at_step is None:
        simulation.run_some(target)
    else:
        simulation.run_some(simulation.step + 1)
        step_hook.at_step(simulation.step)
    now = perf_counter()
    spent.seconds += now - started
    if simulation.step == target:
        simulation.check()
        if target % every == 0:
            output()
            spent.writing += perf_counter() - now
    spent.between_steps = True
    return now


def _result(scene, simulation, status, message, spent: _Spent, earlier: RunResult | None) -> RunResult:
    """The result of all parts of a run; a simulation that was read back counts on by itself, but for the clock."""
    boundaries = simulation.boundaries
    if earlier is not None:
        spent.seconds += earlier.seconds
        spent.writing += earlier.breakdown.get("output", 0.0)
        spent.processor += earlier.cpu_seconds
    return RunResult(
        engine="native",
        kernel="numba",
        status=status,
        message=message,
        steps=simulation.step,
        disc_steps=float(simulation.disc_steps),
        inserted=boundaries.inserted,
        present=simulation.discs.n,
        removed=boundaries.removed,
        lost=boundaries.inserted - boundaries.removed - simulation.discs.n,
        seconds=spent.seconds,
        versions=versions(),
        ledger=simulation.ledger if status != "failed" else None,
        breakdown={
            "forces and motion": spent.seconds - simulation.rebuild_seconds,
            "neighbour": simulation.rebuild_seconds,
            "output": spent.writing,
        },
        resumed=(*earlier.resumed, scene.time(earlier.steps)) if earlier else (),
        cpu_seconds=spent.processor,
    )


def _interrupted(simulation, folder, dump_format, result, saved, between_steps) -> RunResult:
    """Leave a checkpoint of an interrupted run where there can be one; its result, with what to tell the user."""
    scene = simulation.scene
    now, end = scene.time(simulation.step), scene.time(scene.steps)
    reason = "" if between_steps else "a second interruption came before the step was done"
    if folder is not None and saved and between_steps:
        folder = Path(folder)
        result = replace(result, message=interruption(now, end, folder, again=now))
        state = f"checkpoint-{simulation.step}.npz"
        try:
            save_state(simulation, folder / state)
            write_checkpoint(scene, folder, state, (DUMP_NAMES[dump_format],), result)
            return result
        except OSError as error:
            reason = f"its state could not be saved ({error})"
    return replace(result, message=interruption(now, end, folder or "memory", reason=reason))
