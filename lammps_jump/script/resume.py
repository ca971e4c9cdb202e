# SPDX-License-Identifier: GPL-2.0-or-later
"""The second script of an interrupted run: ``in.resume.lammps`` continues from a restart file, with the same styles.

LAMMPS' granular forces depend on velocity. A step evaluates them with the velocities of its half step, v_(n-1/2). The
first forces of a new run are evaluated with v_n instead, so that a restarted run differs at once (see LAMMPS'
documentation of `read_restart`; measured: 5e-7 d after fifty steps of a dam break with friction, 1e-4 d after 650).
The restart files of this project therefore hold v_(n-1/2) = v_n - dt F_n / (2 m). The first forces of the next part
then equal the last ones of the part before, up to the order of sums. Half a kick gives v_n back, and the run continues
with those forces (``run … pre no``).
"""

from __future__ import annotations

from pathlib import Path

from lammps_jump.files import DUMP_NAMES
from lammps_jump.scene.scene import Scene

from . import stock
from .assemble import STATE, Options, control, joined, save_at_end

SCRIPT = "in.resume.lammps"
LOG = "log.resume.lammps"
BINARY_PART = "dump.resume.lammpsbin"
"""LAMMPS appends to text and gzip dumps, not to binary ones; these are put together afterwards."""


def continuation_text(scene: Scene, *, step: int, removed: tuple[int, ...], **options) -> str:
    """The script that goes on; further keywords as of `Options`.

    Parameters
    ----------
    scene : Scene
    step : int
        Of the restart file, written after `lammps_jump.script.stock.half_step_back`: behind
        `lammps_jump.script.stock.first_step`, and the end of a window of the probes.
    removed : tuple of int
        Discs that each outlet has taken so far: ``fix evaporate`` keeps no count over a restart.
    """
    how = Options(**options)
    # gates that wait in a scene with inlets are gone by now; those without go on moving out of the way
    gates = [] if scene.inlets else how.style.gates(scene)
    half_step = stock.half_step(scene, how.kernel)
    sizes = how.style.own_sizes(scene)  # the last poured discs may still wait for theirs
    sections = [
        ("settings", how.style.settings(scene, how.ranks)),
        ("state", [f"read_restart    {STATE.format(step=step)}", *stock.size_variables(scene), *stock.molecule(scene)]),
        *how.style.law(scene),
        ("outlets", stock.outlets(scene)),
        *control(scene, how),
        ("output", _output(scene, how.dump_format)),
        ("log", stock.thermo(scene, removed)),
        ("gates and inlets", [*gates, *stock.inlets(scene, sizes), *(sizes if scene.pours else [])]),
        ("forces of the half step, then the velocities of the step", ["run             0 post no", *half_step]),
        ("run", [f"run             {scene.steps} upto pre no", *save_at_end(scene, how.kernel, how.ranks, step)]),
    ]
    return joined(f"{scene.name}: goes on from step {step}", SCRIPT, how, sections)


def _output(scene: Scene, dump_format: str) -> list[str]:
    """Continues the dump behind its last frame; a plain interval would write the frame of this step twice."""
    lines = stock.output(scene, dump_format)
    if dump_format == "binary":
        lines = [line.replace(DUMP_NAMES["binary"], BINARY_PART) for line in lines]
    n = scene.output_steps
    append = "" if dump_format == "binary" else " append yes"
    return [
        f"variable        next_frame equal stride(0,{(scene.steps // n + 2) * n},{n})",
        *lines,
        f"dump_modify     frames every v_next_frame first no{append}",
    ]


def write_continuation(scene: Scene, folder: Path, **options) -> Path:
    """Write ``in.resume.lammps`` (see `continuation_text`) into a run folder; returns its path."""
    path = folder / SCRIPT
    path.write_text(continuation_text(scene, **options))
    return path
