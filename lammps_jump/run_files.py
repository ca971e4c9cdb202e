"""What a run folder may hold of ours, and how it is cleared: nothing else in it is ever deleted."""

from __future__ import annotations

from pathlib import Path

RUN_FILES = (
    "case.yaml",
    "in.lammps",
    "discs.data",
    "disk.mol",
    "log.lammps",
    "dump.lammpstrj",
    "dump.lammpstrj.gz",
    "dump.lammpsbin",
    "forces.csv",
    "job.slurm",
    "forces_*.raw",
    "checkpoint.json",
    "checkpoint-*.npz",
    "checkpoint-*.restart",
    "in.resume.lammps",
    "log.resume.lammps",
    "dump.resume.lammpsbin",
    "stop.request",
)
"""What the engines read and write in a run folder (names and patterns)."""
RESULT_FILES = (
    "profiles.nc",
    "summary.json",
    "animation.mp4",
    "report.html",
    "live.png",
    "profiles*.csv",
    "energy.csv",
    "front.csv",
    "jump_*.csv",
    "force_*.csv",
    "reflected_wave.csv",
    "fields.nc",
    "fields*.vti",
    "discs*.vtp",
    "discs.pvd",
    "picture?.dat",
    "figures/*.png",
)
"""What is made of them."""
OWN_FILES = (*RUN_FILES, *RESULT_FILES)
"""What a run folder may hold of an earlier run (names and patterns); nothing else in it is ever deleted."""


def clear(folder: Path, patterns: tuple[str, ...]) -> None:
    """Delete the files of a folder that the patterns name."""
    for pattern in patterns:
        for old in folder.glob(pattern):
            old.unlink()
