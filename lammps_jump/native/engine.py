"""A whole run of the native engine: stepping, frames, progress, guards, result."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

from ..errors import CaseError, RunError
from ..run_result import Progress, ProgressCallback, RunResult, interruption
from ..scene import Scene
from .cells import CellSimulation
from .output import DumpWriter, Frame, write_forces
from .simulation import NativeSimulation


@dataclass(frozen=True)
class NativeRun:
    """A run held in memory.

    Attributes
    ----------
    result : RunResult
    frames : tuple of Frame
        Empty unless asked for.
    forces : tuple of (step, wall, fx, fy, moment)
        One a window and probed wall.
    """

    result: RunResult
    frames: tuple[Frame, ...]
    forces: tuple[tuple[int, str, float, float, float], ...]


@contextmanager
def deferred_interrupt():
    """Ctrl-C waits until the stepping comes back, so that no array is left half sorted; a second one does not wait.

    Yields a function that tells whether it was pressed. Outside the main thread nothing changes: signals do not come
    there.
    """
    pressed: list[int] = []

    def remember(number, stack) -> None:
        if pressed:
            raise KeyboardInterrupt
        pressed.append(number)

    if threading.current_thread() is not threading.main_thread():
        yield lambda: False
        return
    before = signal.signal(signal.SIGINT, remember)
    try:
        yield lambda: bool(pressed)
    finally:
        signal.signal(signal.SIGINT, before)


def take_frame(simulation) -> Frame:
    """The discs of a simulation now."""
    positions, velocities = simulation.positions, simulation.velocities
    spin = simulation.spin if simulation.scene.rotation else None
    time = simulation.scene.time(simulation.step)
    return Frame(simulation.step, time, simulation.ids, *positions.T, *velocities.T, spin)


def _versions() -> dict[str, str]:
    from importlib.metadata import PackageNotFoundError, version
    from platform import python_version

    found = {"python": python_version()}
    for name in ("lammps-jump", "numba", "numpy"):
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "unknown"
    return found


def simulate(
    scene: Scene,
    folder: Path | None = None,
    *,
    progress: ProgressCallback | None = None,
    should_stop: Callable[[], bool] | None = None,
    dump_format: str = "text",
    report_every: float = 0.5,
    keep_frames: bool = False,
    search: str = "verlet",
    cell_size: float | None = None,
    ledger: bool = True,
) -> NativeRun:
    """Run a scene to its last step; see `run_native` for the parameters."""
    simulation = _make(scene, search, cell_size, ledger)
    if folder is not None:
        Path(folder).mkdir(parents=True, exist_ok=True)
    writer = DumpWriter(folder, scene, dump_format) if folder is not None else None
    frames: list[Frame] = []

    def output() -> None:
        if writer is None and not keep_frames:
            return
        frame = take_frame(simulation)
        if keep_frames:
            frames.append(frame)
        if writer is not None:
            writer.write(frame)

    status, message = "complete", ""
    seconds = writing = 0.0
    try:
        output()
        reported = perf_counter()
        while simulation.step < scene.steps:
            target = min(scene.steps, (simulation.step // scene.output_steps + 1) * scene.output_steps)
            started = perf_counter()
            with deferred_interrupt() as pressed:
                simulation.run_some(target)
            now = perf_counter()
            seconds += now - started
            if pressed():
                raise KeyboardInterrupt
            if simulation.step == target:
                simulation.check()
                if target % scene.output_steps == 0:
                    output()
                    writing += perf_counter() - now
            if now - reported >= report_every:
                reported = now
                if progress is not None:
                    progress(Progress(simulation.step, scene.steps, scene.time(simulation.step), simulation.discs.n))
                if should_stop is not None and should_stop():
                    status = "interrupted"
                    message = interruption(scene.time(simulation.step), scene.time(scene.steps), folder or "memory")
                    break
    except KeyboardInterrupt:
        status = "interrupted"
        message = interruption(scene.time(simulation.step), scene.time(scene.steps), folder or "memory")
    except RunError as error:
        status, message = "failed", str(error)
    finally:
        if writer is not None:
            writer.close()
            if scene.probes:
                write_forces(folder, scene, simulation.forces)
    if progress is not None:
        progress(Progress(simulation.step, scene.steps, scene.time(simulation.step), simulation.discs.n))
    traffic = simulation.traffic
    result = RunResult(
        engine="native",
        kernel="numba",
        status=status,
        message=message,
        steps=simulation.step,
        disc_steps=float(simulation.disc_steps),
        inserted=traffic.inserted,
        present=simulation.discs.n,
        removed=traffic.removed,
        lost=traffic.inserted - traffic.removed - simulation.discs.n,
        seconds=seconds,
        versions=_versions(),
        ledger=simulation.ledger if status != "failed" else None,
        breakdown={
            "forces and motion": seconds - simulation.rebuild_seconds,
            "neighbour": simulation.rebuild_seconds,
            "output": writing,
        },
    )
    return NativeRun(result, tuple(frames), tuple(simulation.forces))


def _make(scene: Scene, search: str, cell_size: float | None, ledger: bool) -> NativeSimulation:
    if search == "verlet":
        return NativeSimulation(scene, ledger=ledger)
    if search == "cells":
        return CellSimulation(scene, cell_size=cell_size, ledger=ledger)
    raise CaseError(f"contact search {search!r} is not known: use 'verlet' or 'cells'")


def run_native(
    scene: Scene,
    folder: Path | None,
    *,
    progress: ProgressCallback | None = None,
    should_stop: Callable[[], bool] | None = None,
    dump_format: str = "text",
    report_every: float = 0.5,
    keep_frames: bool = False,
    search: str = "verlet",
    cell_size: float | None = None,
    ledger: bool = True,
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
        Asked at the same times; True ends the run as 'interrupted'.
    dump_format : {'text', 'gz', 'binary'}
    keep_frames : bool
        Here without effect on the result; see `simulate`, which returns the frames.
    search : {'verlet', 'cells'}
        Neighbour list, or the thesis' own contact search in cells of `cell_size` (m, default 2 d).
    ledger : bool
        Keep the books of dissipated energy; a quarter of the stepping time.

    Returns
    -------
    RunResult
        Status 'failed' with a message where a guard ended the run; what there was is kept.
    """
    return simulate(
        scene,
        folder,
        progress=progress,
        should_stop=should_stop,
        dump_format=dump_format,
        report_every=report_every,
        keep_frames=keep_frames,
        search=search,
        cell_size=cell_size,
        ledger=ledger,
    ).result
