# SPDX-License-Identifier: GPL-2.0-or-later
"""A job file for a SLURM cluster, beside the script it runs."""

from __future__ import annotations

from pathlib import Path

from lammps_jump.engines.choice import expected_discs
from lammps_jump.quoting import shell_word
from lammps_jump.scene.scene import Scene

BYTES_PER_DISC = 3_000
"""Peak of the stock styles 2.2 kB, of the compiled ones 1.4 kB (docs/scaling.md); plus `BASE_BYTES` a rank."""
BASE_BYTES = 200_000_000
DISC_STEPS_PER_SECOND = 10e6
"""Stock script on one core, deliberately low: a job that is killed by its limit costs more than one that ends early."""


def job_text(scene: Scene, ranks: int) -> str:
    """The job file: one task a rank, memory and time from the size of the scene."""
    discs = expected_discs(scene)
    megabytes = -(-(BASE_BYTES + BYTES_PER_DISC * discs // ranks) // 1_000_000)
    minutes = -(-int(1.5 * discs * scene.steps / (DISC_STEPS_PER_SECOND * ranks)) // 60) + 5
    return f"""#!/bin/bash
#SBATCH --job-name={shell_word(scene.name)}
#SBATCH --ntasks={ranks}
#SBATCH --cpus-per-task=1
#SBATCH --mem-per-cpu={megabytes}M
#SBATCH --time={minutes}
#SBATCH --output=slurm-%j.out
# Submit it from this folder: sbatch job.slurm. Needs a LAMMPS with the GRANULAR package (PLUGIN for the compiled
# kernel). LMP names the program where it is not `lmp`, LAUNCH what starts the ranks ("mpiexec -n {ranks}", say).
# For the compiled kernel PLUGIN names a build made on that machine (`lammps-jump kernels build` prints its place).
set -euo pipefail
cd "${{SLURM_SUBMIT_DIR:-$(dirname "$0")}}"
if [ ! -f in.lammps ]; then
    echo "no in.lammps in $PWD: submit the job from the run folder" >&2
    exit 2
fi
export OMP_NUM_THREADS=1
${{LAUNCH:-srun}} "${{LMP:-lmp}}" -in in.lammps -log log.lammps -screen none ${{PLUGIN:+-var plugin "$PLUGIN"}}
# afterwards, where lammps-jump is installed: lammps-jump analyze .
"""


def write_job(scene: Scene, folder: Path, ranks: int) -> Path:
    """Write ``job.slurm`` into a built folder; returns its path."""
    path = folder / "job.slurm"
    path.write_text(job_text(scene, ranks))
    return path
