# SPDX-License-Identifier: GPL-2.0-or-later
"""The page of the files of a run folder, read from where the program defines them."""

from __future__ import annotations

from lammps_jump.analysis.quantities import captions, tables
from lammps_jump.files import RESULT_FILES, RUN_FILES

HEAD = """\
# Files of a run folder

A run folder holds what the engine read and wrote, and what the analyses made of it.
The lists are made from the program. [All numbers](numbers.md) lists the keys of `summary.json`.
"""
FILES = {
    "case.yaml": "the case, with the values of `--set` and every default of a wall's file filled in",
    "in.lammps": "script for LAMMPS with its own styles",
    "in.plugin.lammps": "script for LAMMPS with the compiled styles",
    "discs.data": "discs at the start",
    "disk.mol": "shape that poured discs have in LAMMPS",
    "scene.image": "law, walls and events of the scene as the core has them in memory, for the compiled styles",
    "inflow.turns": "row, step and speed of each disc of an inflow against time, for the compiled styles",
    "log.lammps": "log of LAMMPS",
    "dump.lammpstrj": "the frames: places, velocities and other values of all discs",
    "dump.lammpstrj.gz": "the same, compressed (`run.dump_format: gz`)",
    "dump.lammpsbin": "the same, binary (`run.dump_format: binary`)",
    "forces.csv": "force and moment on each probed wall against time",
    "contacts.bin": "contacts of each frame, with their forces",
    "walls.csv": "where walls are that the discs push",
    "pressure.npz": "force on stretches of outlines, a row a window of the probes (native engine)",
    "end.npz": "state of discs and bodies at the end, with all digits: another case begins from it",
    "start-[0-9a-f]*.npz": "the same of the run that this one began from",
    "job.slurm": "job file for a cluster",
    "forces_*.raw": "forces as LAMMPS writes them",
    "checkpoint.json": "where `--resume` goes on",
    "checkpoint_previous.json": "the checkpoint before it",
    "checkpoint-[0-9]*.npz": "state of the native engine at a checkpoint",
    "checkpoint-[0-9]*.restart": "state of LAMMPS at a checkpoint",
    "in.resume.lammps": "script of the part that goes on",
    "dump.resume.lammpsbin": "binary frames of the part that goes on",
    "stop.request": "asks the engine to stop",
    ".ranks.job": "the job of several ranks, deleted at the end",
    "profiles.nc": "depth, velocity, discharge, momentum flux and packing over time and distance",
    "summary.json": "all numbers of the run",
    "curves.json": "the curves that the report draws",
    "player.json": "the frames that the page of a study plays",
    "animation.mp4": "film",
    "animation.gif": "film, where ffmpeg is missing",
    "report.html": "the report",
    "live.png": "picture of the run while it goes on (`--live`)",
    "bodies.csv": "bodies against time: centre of mass, turn, velocities, and force and moment of the discs",
    "fields.nc": "coarse-grained density, velocity and stress",
    "profiles.csv": "`profiles.nc` as a table (`export --csv`)",
    "profiles_mean.csv": "its means over the window (`export --csv`)",
    "discs[0-9].vtp": "discs of a frame, for ParaView (`export --vtk`)",
    "discs.pvd": "list of these files with their times",
    "fields.vti": "fields, for ParaView",
    "walls.vtp": "walls that stand, for ParaView",
    "walls[0-9].vtp": "walls of a frame, where they move",
    "walls.pvd": "list of these files with their times",
    "picture[0-9].dat": "pictures of the thesis' program (`export --pictures`)",
    "ro-crate-metadata.json": "the folder as a bundle to cite (`export --crate`)",
}
"""What each file holds that no analysis tells of; a name of the program that is missing here stops the build."""


def page() -> str:
    """The page, Markdown."""
    return "\n".join([HEAD, *_files()])


def _files() -> list[str]:
    lines = []
    of_analyses = {**{name: FILES[name] for name in RESULT_FILES}, **tables()}
    for title, files in (
        ("Files of the engine", {name: FILES[name] for name in RUN_FILES}),
        ("Files of the analyses", of_analyses),
    ):
        lines += [f"## {title}\n", "| file | content |", "|---|---|"]
        lines += [f"| `{name}` | {text} |" for name, text in files.items()]
        lines.append("")
    lines += ["## Figures\n", "PNG files; `lammps-jump figures --format` draws them as PDF or SVG.\n"]
    lines += ["| file in `figures/` | picture |", "|---|---|"]
    return [*lines, *(f"| `{name}.png` | {text} |" for name, text in captions().items()), ""]
