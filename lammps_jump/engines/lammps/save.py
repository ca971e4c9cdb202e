# SPDX-License-Identifier: GPL-2.0-or-later
"""Checkpoints of a LAMMPS run, written by the first rank while the run pauses."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from lammps_jump.engines.checkpoint import CheckpointWriter
from lammps_jump.engines.result import interruption
from lammps_jump.engines.setting import Job
from lammps_jump.files import BINARY_PART, BODIES, CONTACTS_FILE, DUMP_NAMES, POSES, write_arrays
from lammps_jump.script.probes import raw_forces
from lammps_jump.script.resume import STATE

from .finish import LOG, SteppingOutcome, result_of
from .log import read_log


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
            What is stored beside the restart file.
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
