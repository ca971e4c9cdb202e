# SPDX-License-Identifier: GPL-2.0-or-later
"""The second script of an interrupted run: ``in.resume.lammps`` continues from a restart file, with the same styles.

LAMMPS' granular forces depend on velocity. A step evaluates them with the velocities of its half step, v_(n-1/2). The
first forces of a new run are evaluated with v_n instead, so that a restarted run differs at once (see LAMMPS'
documentation of `read_restart`; measured: 5e-7 d after fifty steps of a dam break with friction, 1e-4 d after 650).
A checkpoint therefore also holds v_(n-1/2) = v_n - dt F_n / (2 m) of every disc. They are set before the first ``run``
of this script, ``run 0`` (see `lammps_jump.engines.lammps.steps`). Its forces then equal the last ones of the part
before, up to the order of sums. Behind it v_n is set, and the run continues with those forces (``run … pre no``).
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from lammps_jump.files import BINARY_PART, DUMP_NAMES, write_text
from lammps_jump.scene.scene import Pour, Scene

from . import stock
from .assemble import Options, control, joined
from .probes import going_on
from .regions import first_forces

SCRIPT = "in.resume.lammps"
STATE = "checkpoint-{step}.restart"


def continuation_text(scene: Scene, *, step: int, removed: tuple[int, ...], poured: int = 0, **options: Any) -> str:
    """The script that goes on; further keywords as of `Options`.

    Parameters
    ----------
    scene : Scene
    step : int
        Of the restart file; the end of a window of the probes.
    removed : tuple of int
        Discs that each outlet has taken so far: ``fix evaporate`` keeps no count over a restart.
    poured : int
        Discs of the pour that are there: ``fix pour`` keeps no state. The others come from a new random stream.
    """
    how = Options(**options)
    first = stock.first_step(scene)
    inlets = how.style.inlets(scene)
    schedule = stock.schedule(scene, how.style.gates(scene), inlets, how.kernel)
    if step <= first:  # gates are still closed, or inlets wait
        at = schedule.index(f"run             {first}")
        gates, run = schedule[:at], [f"run             {first} upto pre no", *schedule[at + 1 :]]
    else:
        # gates that wait in a scene with inlets are gone by now; those without go on moving out of the way
        gates = [] if scene.inlets else how.style.gates(scene)
        gates += inlets
        run = [*_pours(scene, step, poured, how.kernel), f"run             {scene.steps} upto pre no"]
    sections = [
        ("settings", ["log             log.lammps append", *how.style.settings(scene, how.ranks)]),
        (
            "state",
            [f"read_restart    {STATE.format(step=step)}", *stock.size_variables(scene), *how.style.molecule(scene)],
        ),
        *how.style.law(scene),
        ("outlets", stock.outlets(scene)),
        ("pour", how.style.own_sizes(scene) if scene.pours else []),  # the last discs may still wait for theirs
        *control(scene, how),
        ("output", _output(scene, how.dump_format)),
        ("log", stock.thermo(scene, removed)),
        ("gates and inlets", gates),
        ("forces of the half step", first_forces(scene, how.kernel)),
        ("run", run),
    ]
    text = joined(f"{scene.name}: goes on from step {step}", SCRIPT, how, sections)
    return going_on(scene, text)


MOST_SEED = 900_000_000
"""LAMMPS takes seeds below this."""


def _pours(scene: Scene, step: int, poured: int, kernel: str) -> list[str]:
    """Commands up to the next turn of the pour, at which the discs that are left begin to come; none without any.

    ``fix pour`` lets discs in at the step behind that of its command.
    """
    left = replace(scene, pours=rest_of_pours(scene, poured), seed=(scene.seed + step) % MOST_SEED)
    turns = [turn for pour in left.pours for turn in scene.pour_turns(pour) if turn > step]
    if not turns:
        return []
    wait = [f"run             {turns[0] - 1} upto pre no"] if turns[0] - 1 > step else []
    return [*wait, *stock.between_runs(scene, kernel, stock.pours(left, []))]


def rest_of_pours(scene: Scene, poured: int) -> tuple[Pour, ...]:
    """The pour with the discs that are left, none where all are there."""
    return tuple(replace(item, count=item.count - poured) for item in scene.pours if item.count > poured)


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


def write_continuation(scene: Scene, folder: Path, **options: Any) -> Path:
    """Write ``in.resume.lammps`` (see `continuation_text`) into a run folder; returns its path."""
    path = folder / SCRIPT
    write_text(path, continuation_text(scene, **options))
    return path
