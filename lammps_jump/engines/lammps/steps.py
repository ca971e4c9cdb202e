# SPDX-License-Identifier: GPL-2.0-or-later
"""The commands of a script, with pauses of its runs at which the state is saved; all ranks go through them together.

A pause is no part of the motion: ``run … pre no`` goes on with the same forces, lists and fixes. A run with pauses
is the same to the last bit as one without. The restart file is written inside a run (command ``restart``);
``write_restart`` would move discs between ranks and leave lists that no longer suit. A restart file holds v_n. The
velocities of the half step (see `lammps_jump.script.assemble`) are stored next to it, in an npz file.
"""

from __future__ import annotations

import os
import re
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, nullcontext
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from lammps_jump.dump.ended import ended, write_ended
from lammps_jump.dump.walls import PushedWalls, pushed_walls
from lammps_jump.engines import interrupts
from lammps_jump.engines.checkpoint import CheckpointWriter
from lammps_jump.engines.interrupts import save_request, stop_request
from lammps_jump.engines.result import interruption
from lammps_jump.engines.setting import Job
from lammps_jump.files import (
    BINARY_PART,
    BODIES,
    CONTACTS_FILE,
    DUMP_NAMES,
    END_FILE,
    POSES,
    delete,
    move,
    open_to_write,
    read_arrays,
    write_arrays,
)
from lammps_jump.scene.meeting import SLOTS as CORNER_SLOTS
from lammps_jump.scene.meeting import corners
from lammps_jump.script.assemble import STATE, STOP_FILE, stop_at
from lammps_jump.script.probes import raw_forces
from lammps_jump.script.regions import LOOK_BACK

from .outputs import LOG, SteppingOutcome, read_log, result_of


class Saver(CheckpointWriter):
    """Writes checkpoints of a part, in the current folder.

    Parameters
    ----------
    job : Job
    outcome : SteppingOutcome
        Of the part; its clocks are kept up to date.
    """

    def __init__(self, job: Job, outcome: SteppingOutcome):
        files = (LOG, DUMP_NAMES[job.setting.dump_format], BINARY_PART, POSES, BODIES, CONTACTS_FILE)
        outputs = (*files, *map(raw_forces, job.scene.probes))
        super().__init__(job.scene, Path(), outputs, job.setting.checkpoint_interval)
        self.job, self.outcome = job, outcome
        self._begin, self._processor = time.perf_counter(), time.process_time()

    def tick(self) -> None:
        """Bring the clocks of the part up to date."""
        self.outcome.seconds = time.perf_counter() - self._begin
        self.outcome.cpu_seconds = (time.process_time() - self._processor) * self.job.setting.ranks

    def save_at(self, step: int, velocities: dict[str, np.ndarray]) -> str:
        """Make a checkpoint of the restart file that LAMMPS has written; the reason where that cannot be.

        Parameters
        ----------
        step : int
        velocities : dict of ndarray
            What is stored next to the restart file.
        """
        self.tick()
        log = read_log(Path(LOG))
        result = result_of(self.job, replace(self.outcome, interrupted=True), log)
        result = replace(result, message=interruption(self.scene, step, self.job.folder, again=self.scene.time(step)))

        def make() -> list[str]:
            name = f"checkpoint-{step}.npz"
            write_arrays(Path(name), **velocities)
            return [STATE.format(step=step), name]

        return self.save(make, result, log.removed_by[: len(self.scene.outlets)])


HALF_STEP = "checkpoint-{step}.npz"
END, SAVE = "end", "save"
SAVED = ("id", "whole", "half")
"""Columns that lie beside a restart file."""
SLOTS = ("partner", "sigma", "spring", "roll")
"""Order of the numbers that fix `MOTION` of the plugin keeps for a disc."""
MOTION, STEP_HOOK = "motion", "step_hook"
PUSHED_WORDS = 18
"""Numbers of a lid, gate or body that the fix hands out (`pushed_state` of fix_jump_step_walls.cpp)."""
NEVER = 2_000_000_000
"""An interval that is longer than any run: of what happens at its first step alone."""
BED = 1 << 1
"""Bit of the first group that a script with fixed discs defines; bit 0 is that of all discs."""


class Steps:
    """A part of a run, from its script's first command to its last, or to where a request ends it.

    Parameters
    ----------
    engine : lammps.lammps
    job : Job
    saver : Saver or None
        Of the first rank.

    Attributes
    ----------
    ended : bool
        Whether it was ended before its script was.
    unsaved : str
        Why the last pause left no checkpoint; empty where it did.
    """

    def __init__(self, engine: Any, job: Job, saver: Saver | None):
        self.engine, self.scene, self.setting, self.saver = engine, job.scene, job.setting, saver
        self.resume = job.resume
        self.ended, self.unsaved = False, ""
        self._stop_step: float = float("inf")

    def ask(self) -> None:
        """Pause the run soon, for the request that was made; any thread may call this."""
        if self.setting.ranks == 1:
            self.engine.lib.lammps_force_timeout(self.engine.lmp)
            return
        new = Path(f"{STOP_FILE}.{os.getpid()}")
        with open_to_write(new) as file:
            file.write(f"{END if stop_request.is_made() else SAVE}\n".encode())
        move(new, Path(STOP_FILE))

    def play(self, text: str) -> None:
        """Run a script to its end, or until somebody asks for the end."""
        head, *runs = re.split(r"(?m)^(?=run )", text)
        self.engine.commands_string(head)
        if self.setting.stop_at is not None:
            self._stop_step, commands = stop_at(self.scene, self.setting.stop_at)
            self.engine.commands_string("\n".join(commands))
        if interrupts.at_step is not None:
            self._hook()
        elif self.resume is None and self.scene.earlier is not None and self.setting.kernel == "compiled":
            self._go_on()
        velocities = {} if self.resume is None else read_arrays(Path(HALF_STEP.format(step=self.resume.step)))
        still = 0 if not velocities else next(i for i, part in enumerate(runs) if part.split()[1] != "0")
        for number, part in enumerate(runs):
            line, _, rest = part.partition("\n")
            before = (head if number == 0 else runs[number - 1]).rstrip()
            if number == 0 < still:
                self._set_velocities(velocities, "half")
            with self._discs_aside() if before.endswith(LOOK_BACK) else nullcontext():
                self._run(line)
            if number == still - 1:
                self._set_velocities(velocities, "whole")
            if self.ended:
                break
            self.engine.commands_string(rest)
        self._keep_end()

    def _go_on(self) -> None:
        """Start as an earlier run has ended: with its springs, and forces as velocities of its half step give them.

        LAMMPS evaluates the first forces with the velocities that discs have then. Those of the step are set after
        them, by a fix that acts at the start alone; the plugin looks at fixes of its name at no other time.
        """
        assert self.scene.earlier is not None
        earlier, ids = self.scene.earlier, np.arange(1, len(self.scene.positions) + 1)
        whole = np.column_stack([self.scene.velocities, earlier.spins])
        velocities = {"id": ids, "whole": whole, "half": np.where(np.isnan(earlier.half), whole, earlier.half)}
        if self.scene.slots:
            slots = earlier.slots(self.scene.slots)
            partner, *springs = (slots[name] for name in SLOTS)
            rows = np.concatenate([partner.astype(np.int64).view(float), *springs], axis=1)
            n = self.engine.extract_setting("nlocal")
            own = self.engine.numpy.extract_atom("id")[:n] - 1
            self.engine.numpy.extract_fix(MOTION, 1, 2)[:n] = rows[own]  # 1, 2: an array of discs
        self._set_velocities(velocities, "half")

        def call(_: object, step: int, count: int, tags: object, places: object, forces: np.ndarray) -> None:
            forces[:] = 0.0
            self._set_velocities(velocities, "whole")

        self.engine.command(f"fix {STEP_HOOK} all external pf/callback {NEVER} {NEVER}")
        self.engine.set_fix_external_callback(STEP_HOOK, call)

    def _keep_end(self) -> None:
        """Write the state from which another run goes on."""
        state = self._velocities() if self.engine.get_natoms() else {}
        if not state:
            return
        count = 4 * self.scene.slots if self.setting.kernel == "compiled" else 0
        slots = np.array(self.engine.gather_concat(f"f_{MOTION}", 1, count)).reshape(-1, count) if count else None
        if self.saver is None:
            return
        names = ("vx", "vy", "spin")
        columns = {"id": state["id"], "x": state["x"], "y": state["y"], "diameter": 2.0 * state["radius"]}
        columns |= dict(zip(names, state["whole"].T, strict=True))
        columns |= {f"half_{name}": values for name, values in zip(names, state["half"].T, strict=True)}
        parts = None
        if slots is not None:
            partner, *springs = np.split(slots[state["order"]], len(SLOTS), axis=1)
            parts = np.ascontiguousarray(partner).view(np.int64), *springs
        write_ended(Path(END_FILE), ended(self.scene, self._step, columns, parts, walls=self._pushed()))

    def _pushed(self) -> PushedWalls:
        """Walls whose pose is state, as the plugin's fix hands them out after the numbers of the probes."""
        scene = self.scene
        if not scene.lids:
            return PushedWalls()
        behind = (4 if scene.moves else 3) * len(scene.probes)
        corner_count = len(corners(scene)) if scene.bodies and scene.springs is not None else 0
        count = PUSHED_WORDS * len(scene.lids) + len(SLOTS) * CORNER_SLOTS * corner_count
        words = np.array([self.engine.extract_fix(MOTION, 0, 1, behind + k) for k in range(count)])  # 0, 1: a vector
        rows: dict[str, dict[str, Any]] = {}
        pushed_words, held = np.split(words, [PUSHED_WORDS * len(scene.lids)])
        for name, row in zip(scene.lids, pushed_words.reshape(-1, PUSHED_WORDS), strict=True):
            parts = dict(zip(("place", "speed", "half", "before", "force"), np.split(row[1:16], 5), strict=True))
            looked = {} if np.isnan(row[16]) else {"area": row[16], "since": row[17]}
            rows[name] = {"released": bool(row[0]), **parts, **looked}
        slots = None
        if corner_count:
            partner, *values = held.reshape(len(SLOTS), corner_count, CORNER_SLOTS)
            slots = (partner.astype(np.int64), *values)
        return pushed_walls(scene, rows, slots)

    def _hook(self) -> None:
        """Let `fix external` call the step hook of a test."""

        def call(_: object, step: int, count: int, ids: object, positions: object, forces: np.ndarray) -> None:
            forces[:] = 0.0  # LAMMPS leaves those of discs that have just come as they are
            if interrupts.at_step is not None:
                interrupts.at_step(step)

        self.engine.command(f"fix {STEP_HOOK} all external pf/callback 1 1")
        self.engine.set_fix_external_callback(STEP_HOOK, call)

    @property
    def _step(self) -> int:
        return self.engine.extract_global("ntimestep")

    def _run(self, line: str) -> None:
        """One ``run`` of the script, with its pauses."""
        _, number, *words = line.split()
        target = int(number) if "upto" in words else self._step + int(number)
        self.engine.command(line)
        while True:
            self.engine.command("timer timeout off")
            if self._step >= target:
                break
            order = self._order()
            if not self._pause(target):
                break
            if order == END:
                self.ended = True
                return
            self.engine.command(f"run {target} upto pre no")
        if self.saver is not None and (stop_request.is_made() or save_request.is_made()):
            self.ask()  # too late for this run: the next one pauses at once

    def _order(self) -> str:
        """Purpose of the pause; the same on every rank, of which the first alone knows."""
        if self._step == self._stop_step:
            return END
        if self.setting.ranks == 1:
            return END if stop_request.is_made() else SAVE
        self.engine.command(
            f"variable order file {STOP_FILE}"
        )  # LAMMPS reads it on the first rank, and tells the others
        order = self.engine.extract_variable("order")
        self.engine.command("variable order delete")
        if self.saver is not None:
            delete(Path(STOP_FILE))
            if order != END and stop_request.is_made():
                self.ask()
        return order

    def _pause(self, target: int) -> bool:
        """Go on to the next end of a window of the probes and save the state there; False where the run ends before."""
        window = self.scene.probe_steps if self.scene.probes else 1
        step = (self._step // window + 1) * window
        self._go_on_to(min(step, target), save=step < target and not self._reason())
        if step >= target:
            return False
        self.unsaved = self._reason()
        if not self.unsaved:
            arrays = self._velocities()
            self.engine.command("log log.lammps append")  # all of it is in the file then
            if self.saver is not None:
                self.unsaved = self.saver.save_at(step, {name: arrays[name] for name in SAVED})
        elif self.saver is not None:
            self.saver.wait()
        save_request.clear()
        return True

    def _go_on_to(self, step: int, *, save: bool) -> None:
        """Run on to a step, whoever asks for an end meanwhile; with `save`, write the restart file there."""
        if save:
            if self.saver is not None:
                delete(Path(STATE.format(step=step)))  # a hard-linked backup stays as it is
            self.engine.command(f"restart {step} {STATE.format(step='*')}")
        while self._step < step:
            self.engine.command("timer timeout off")
            self.engine.command(f"run {step} upto pre no post no")
        self.engine.command("restart 0")

    def _reason(self) -> str:
        """Why there can be no checkpoint; empty where there can."""
        if self.engine.get_natoms() == 0:
            return "there was no disc yet"
        if len(self.scene.pours) > 1:
            return "it has several pours, and LAMMPS' fix pour keeps no state"
        return ""

    def _velocities(self) -> dict[str, np.ndarray]:
        """Ids, places, radii, velocities and spin of all discs: of the step, and of its half step."""
        shapes = {"x": 3, "v": 3, "f": 3, "omega": 3, "torque": 3, "rmass": 1, "radius": 1}
        state = {
            name: np.array(self.engine.gather_concat(name, 1, count)).reshape(-1, count)
            for name, count in shapes.items()
        }
        ids = np.array(self.engine.gather_concat("id", 0, 1))
        # the compiled kernel keeps gravity out of the forces, unless a pour needs LAMMPS' own
        outside = self.setting.kernel == "compiled" and not self.scene.pours
        gravity = np.array(self.scene.gravity if outside else (0.0, 0.0))
        mass, radius, dt = state["rmass"], state["radius"], self.scene.time_step
        whole = np.column_stack([state["v"][:, :2], state["omega"][:, 2]])
        kick = 0.5 * dt * (state["f"][:, :2] / mass + gravity)
        turn = dt * state["torque"][:, 2:] / (mass * radius**2)  # I = m R^2 / 2
        if not self.scene.rotation:
            turn *= 0.0
        if self.scene.fixed:  # they stay, whatever pushes them
            kick[self.scene.fixed.holds(ids)] = turn[self.scene.fixed.holds(ids)] = 0.0
        order = np.argsort(ids)
        return {
            "order": order,
            **{"id": ids[order], "x": state["x"][order, 0], "y": state["x"][order, 1], "radius": radius[order, 0]},
            **{"whole": whole[order], "half": (whole - np.column_stack([kick, turn]))[order]},
        }

    @contextmanager
    def _discs_aside(self) -> Iterator[None]:
        """No disc is in the group of a wall's fix: a run of no step looks at the walls, and at no contact with them.

        A contact with a wall at the place and speed of another step would cut its spring, or end it. The bits of groups
        are inverted, and back again: discs take theirs along where LAMMPS sorts them meanwhile. The bit of the fixed
        discs stays, by which LAMMPS tells the effective mass of a contact.
        """
        self._invert_groups()
        yield
        self._invert_groups()

    def _invert_groups(self) -> None:
        n = self.engine.extract_setting("nlocal")
        self.engine.numpy.extract_atom("mask")[:n] ^= ~BED if self.scene.fixed else -1

    def _set_velocities(self, velocities: Mapping[str, np.ndarray], kind: str) -> None:
        """Give each disc of this rank its velocity and spin of a checkpoint."""
        n = self.engine.extract_setting("nlocal")
        rows = velocities[kind][np.searchsorted(velocities["id"], self.engine.numpy.extract_atom("id")[:n])]
        self.engine.numpy.extract_atom("v")[:n, :2] = rows[:, :2]
        self.engine.numpy.extract_atom("omega")[:n, 2] = rows[:, 2]
