# SPDX-License-Identifier: GPL-2.0-or-later
"""A whole run of the native engine: stepping, frames, progress, guards, result."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import inf
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

from lammps_jump.dump.contacts import ContactWriter
from lammps_jump.dump.ended import write_ended
from lammps_jump.dump.find import write_forces
from lammps_jump.dump.frame import Frame, make_frame, ten_indices
from lammps_jump.dump.walls import PoseWriter, write_bodies, write_pressure
from lammps_jump.dump.write import DumpWriter, run_writer
from lammps_jump.engines import interrupts
from lammps_jump.engines.checkpoint import Checkpoint, CheckpointWriter, cut_back, remove_checkpoint
from lammps_jump.engines.interrupts import counted_interrupts, save_request
from lammps_jump.engines.result import (
    NATIVE_KERNELS,
    REPORT_SECONDS,
    Progress,
    ProgressCallback,
    RunResult,
    interruption,
)
from lammps_jump.engines.setting import Setting
from lammps_jump.engines.twin import Twin
from lammps_jump.errors import ResumeError, RunError
from lammps_jump.files import BODIES, CONTACTS_FILE, DUMP_NAMES, END_FILE, POSES, PRESSURE_FILE, delete
from lammps_jump.folders import staging
from lammps_jump.provenance import versions
from lammps_jump.scene.scene import Scene

from .bound import Core
from .simulation import CellSimulation, NativeSimulation
from .state import ended_of, fingerprint, load_state, save_state


def take_frame(simulation: NativeSimulation) -> Frame:
    """The discs of a simulation now, sorted by id."""
    scene, (x, y), (vx, vy) = simulation.scene, simulation.positions.T, simulation.velocities.T
    spin = {"omegaz": simulation.spin} if scene.rotation else {}
    radius = {"radius": simulation.radii} if scene.sizes else {}
    columns = {"id": simulation.ids, "x": x, "y": y, "vx": vx, "vy": vy, **spin, **radius}
    box = (*scene.domain, (-scene.radius, scene.radius))
    return make_frame(simulation.step, scene.time(simulation.step), box, columns)


def run_native(
    scene: Scene,
    folder: Path | None,
    setting: Setting | None = None,
    *,
    progress: ProgressCallback | None = None,
    should_stop: Callable[[], bool] | None = None,
    report_every: float = REPORT_SECONDS,
    resume: Checkpoint | None = None,
    **options: Any,
) -> RunResult:
    """Run a scene on the native engine and leave dump and forces.csv in `folder`.

    Parameters
    ----------
    scene : Scene
    folder : Path or None
        Folder for the files, made where it is missing; None writes none.
    setting : Setting, optional
    progress : callable, optional
        Called with a `Progress` every `report_every` seconds of wall time, and once at the end.
    should_stop : callable, optional
        Asked after every tenth of a second of work; True ends the run as 'interrupted'.
    resume : Checkpoint, optional
        Go on with the interrupted run that left it in `folder` (see `lammps_jump.engines.checkpoint`), with the same
        scene, `dump_format` and `ledger`. Its frames are those of an uninterrupted run, bit for bit.
    options
        Fields of `Setting` in place of one. No checkpoint is written before the end, unless they name an interval.

    Returns
    -------
    RunResult
        Status 'failed' with a message where a guard ended the run; what there was is kept.
    """
    setting = setting or replace(Setting("native", "core", checkpoint_interval=inf), **options)
    part = EnginePart(scene, folder, setting, resume)
    simulation = part.simulation

    def report() -> None:
        if progress is not None:
            n, threads = simulation.discs.n, simulation.loops.threads
            progress(Progress(simulation.step, scene.steps, scene.time(simulation.step), n, threads=threads))

    last = scene.steps if setting.stop_at is None else min(setting.stop_at, scene.steps)
    status, message = "complete", ""
    try:
        with counted_interrupts() as pressed:
            if resume is None:
                part.output()
            reported = perf_counter()
            while simulation.step < last:
                now = part.to_next_output(last)
                if now - reported >= report_every:
                    reported = now
                    report()
                if simulation.step < scene.steps:
                    if pressed() or (should_stop is not None and should_stop()):
                        raise KeyboardInterrupt
                    if part.checkpoints is not None and (part.checkpoints.due() or save_request.is_made()):
                        save_request.clear()
                        part.save()
            if simulation.step < scene.steps:
                raise KeyboardInterrupt
    except KeyboardInterrupt:
        status = "interrupted"
    except RunError as error:
        status, message = "failed", str(error)
    finally:
        part.close()
    report()
    return part.ended(status, message)


class EnginePart:
    """A part of a run, from its start or checkpoint to where it ends: stepping, files, clocks.

    Attributes
    ----------
    between_steps : bool
        Whether the stepping is between two steps: an interruption that did not wait may leave arrays half sorted,
        or half a frame.
    """

    def __init__(self, scene: Scene, folder: Path | None, setting: Setting, resume: Checkpoint | None):
        self.engine = setting.engine
        loops = Twin() if setting.engine == "twin" else Core(setting.threads)
        self.scene, self.folder = scene, None if folder is None else Path(folder)
        self.earlier: RunResult | None = resume.result if resume else None
        self.saved: float | None = resume.time if resume else None
        if resume is not None:
            assert self.folder is not None  # that of the checkpoint
            (name,) = resume.state
            self.simulation = load_state(scene, self.folder / name, ledger=setting.ledger, loops=loops)
            if self.simulation.step != resume.step:
                raise ResumeError(f"{self.folder / name}: is the state of another step; start a new run")
            cut_back(self.folder, resume)
        elif setting.cell_size is None:
            self.simulation = NativeSimulation(scene, ledger=setting.ledger, loops=loops)
        else:
            self.simulation = CellSimulation(scene, cell_size=setting.cell_size, ledger=setting.ledger, loops=loops)
        self.writer: DumpWriter | None = None
        self.contacts: ContactWriter | None = None
        self.poses: PoseWriter | None = None
        self.checkpoints: CheckpointWriter | None = None
        self.between_steps, self.reason = True, ""
        self.states: list[tuple[int, str]] = list(resume.result.states) if resume else []
        self.seconds = self.writing = 0.0
        self.processor = process_time()
        if self.folder is None:
            return
        self.folder.mkdir(parents=True, exist_ok=True)
        delete(self.folder / END_FILE)  # of an earlier run or part
        if resume is None:
            remove_checkpoint(self.folder)  # of an earlier run: not this one's beginning
        self.writer = run_writer(self.folder, scene, setting.dump_format, append=resume is not None)
        if scene.contact_output:
            self.contacts = ContactWriter(self.folder / CONTACTS_FILE, append=resume is not None)
        if scene.lids:
            self.poses = PoseWriter(self.folder / POSES, append=resume is not None)
        if setting.cell_size is None:
            asked = {
                "forces.csv": scene.probes,
                CONTACTS_FILE: scene.contact_output,
                POSES: scene.lids,
                BODIES: scene.bodies,
                PRESSURE_FILE: scene.pressure,
            }
            outputs = (DUMP_NAMES[setting.dump_format], *(name for name, wanted in asked.items() if wanted))
            self.checkpoints = CheckpointWriter(scene, self.folder, outputs, setting.checkpoint_interval)

    def output(self) -> None:
        """Write a frame, its contacts and poses first: a reader of a frame finds them."""
        if self.poses is not None:
            self.poses.write(self.scene.time(self.simulation.step), self.simulation.walls.poses())
        if self.contacts is not None:
            self.contacts.write(self.simulation.step, *self.simulation.contacts())
        if self.writer is not None:
            self.writer.write_frame(take_frame(self.simulation))
        every = self.scene.output_steps
        if self.simulation.step // every in ten_indices(self.scene.steps // every + 1):
            self.states.append((self.simulation.step, fingerprint(self.simulation.discs)))

    def to_next_output(self, last: int) -> float:
        """Step towards the next frame, for a tenth of a second at most, write it there; the clock after the steps."""
        simulation, every = self.simulation, self.scene.output_steps
        target = min(last, (simulation.step // every + 1) * every)
        started = perf_counter()
        self.between_steps = False
        if interrupts.at_step is None:
            simulation.run_some(target)
        else:
            simulation.run_some(simulation.step + 1)
            interrupts.at_step(simulation.step)
        now = perf_counter()
        self.seconds += now - started
        if simulation.step == target:
            simulation.check()
            if target % every == 0:
                self.output()
                self.writing += perf_counter() - now
        self.between_steps = True
        return now

    def close(self) -> None:
        """Finish the files."""
        if self.writer is not None:
            self.writer.close()
            if self.contacts is not None:
                self.contacts.close()
            if self.poses is not None:
                self.poses.close()
        if self.folder is not None:
            self._write_forces(self.folder)

    def _write_forces(self, folder: Path) -> None:
        if self.scene.probes:
            write_forces(folder / "forces.csv", self.scene, self.simulation.forces)
        if self.scene.bodies:
            write_bodies(folder / BODIES, self.scene, self.simulation.windows.bodies)
        if self.scene.pressure:
            write_pressure(folder / PRESSURE_FILE, self.scene, self.simulation.windows.pressed)

    def save(self) -> None:
        """Write a checkpoint where there can be one; `reason` says why there is none."""
        folder = self.folder
        if folder is None or self.checkpoints is None or not self.between_steps or not self.simulation.step:
            return
        started, again = perf_counter(), self.scene.time(self.simulation.step)
        self.reason = self.checkpoints.save(lambda: self._state(folder), self.result("interrupted", self._ended(again)))
        self.saved = self.saved if self.reason else again
        self.writing += perf_counter() - started

    def _state(self, folder: Path) -> list[str]:
        self._write_forces(folder)
        name = f"checkpoint-{self.simulation.step}.npz"
        save_state(self.simulation, folder / name)
        return [name]

    def go_on_as(self, scene: Scene) -> None:
        """Go on from here with another scene, whose past is the same; springs, lists and sums stay as they are."""
        assert self.folder is not None and self.between_steps
        self.scene, old = scene, self.simulation
        with staging(self.folder) as stage:  # a state next to the others would take the place of a checkpoint's
            save_state(old, stage / "state.npz")
            self.simulation = load_state(scene, stage / "state.npz", ledger=old.ledger_on, loops=old.loops)
        if self.checkpoints is not None:
            self.checkpoints.scene = scene

    def ended(self, status: str, message: str) -> RunResult:
        """The result of a part that is at its end; state and checkpoint are kept where there can be one."""
        if status != "failed":
            self.keep_end()
        return self.interrupted() if status == "interrupted" else self.result(status, message)

    def keep_end(self) -> None:
        """Write the state from which another run goes on."""
        if self.folder is not None and self.between_steps:
            write_ended(self.folder / END_FILE, ended_of(self.simulation))

    def interrupted(self) -> RunResult:
        """Leave a checkpoint where there can be one; the result, with what to tell the user."""
        if not self.between_steps:
            self.reason = "a second interruption came before the step was done"
        self.save()
        return self.result("interrupted", self._ended(self.saved))

    def _ended(self, again: float | None) -> str:
        folder = self.folder or "memory"
        return interruption(self.scene, self.simulation.step, Path(folder), again=again, reason=self.reason)

    def result(self, status: str, message: str) -> RunResult:
        """The result of all parts; a simulation that was read back counts on by itself, but for the clock."""
        simulation, boundaries, earlier = self.simulation, self.simulation.boundaries, self.earlier
        seconds, writing, processor = self.seconds, self.writing, process_time() - self.processor
        if earlier is not None:
            seconds += earlier.seconds
            writing += earlier.breakdown.get("output") or 0.0
            processor += earlier.cpu_seconds
        return RunResult(
            engine=self.engine,
            kernel=NATIVE_KERNELS[self.engine],
            status=status,
            message=message,
            steps=simulation.step,
            disc_steps=float(simulation.disc_steps),
            inserted=boundaries.inserted,
            present=simulation.discs.n,
            removed=boundaries.removed,
            lost=boundaries.inserted - boundaries.removed - simulation.discs.n,
            seconds=seconds,
            versions=versions(),
            ledger=simulation.ledger if status != "failed" else None,
            breakdown={
                "forces and motion": seconds - simulation.rebuild_seconds,
                "neighbour": simulation.rebuild_seconds,
                "output": writing,
            },
            resumed=(*earlier.resumed, self.scene.time(earlier.steps)) if earlier else (),
            cpu_seconds=processor,
            states=tuple(self.states),
        )
