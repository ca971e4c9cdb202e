# SPDX-License-Identifier: GPL-2.0-or-later
"""Scene to a folder that runs alone; and the script by which an interrupted run goes on.

LAMMPS' granular forces depend on velocity. A step evaluates them with the velocities of its half step, v_(n-1/2). The
first forces of a new run are evaluated with v_n instead, so that a restarted run differs at once (see LAMMPS'
documentation of `read_restart`; measured: 5e-7 d after fifty steps of a dam break with friction, 1e-4 d after 650).
A checkpoint therefore also holds v_(n-1/2) = v_n - dt F_n / (2 m) of every disc. They are set before the first ``run``
of that script, ``run 0`` (see `lammps_jump.engines.lammps.steps`). Its forces then equal the last ones of the part
before, up to the order of sums. Behind it v_n is set, and the run continues with those forces (``run … pre no``).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from lammps_jump.files import BINARY_PART, DUMP_NAMES, write_text
from lammps_jump.quoting import lammps_comment
from lammps_jump.scene.scene import Pour, Scene

from . import plugin, stock
from .probes import going_on
from .regions import first_forces, number

Section = tuple[str, list[str]]
"""Title and commands of a part of a script."""

STOP_FILE = "stop.request"
"""File in the run folder at which a run of several ranks pauses."""
STOP_STEPS = 100
PART = 100_000
"""Discs whose lines of the data file are in memory at one time."""
SCRIPTS = {"stock": "in.lammps", "compiled": "in.plugin.lammps"}
"""Name of the script, by its kernel; the first is always there, for a machine without the plugin."""


@dataclass(frozen=True)
class Options:
    """Options of a script.

    Attributes
    ----------
    kernel : {'stock', 'compiled'}
        Styles that come with LAMMPS, or this project's plugin.
    ranks : int
        Number of MPI ranks of the run; more than one adds the division along x and its balancing.
    dump_format : {'text', 'gz', 'binary'}
    header : tuple of str
        Comment lines for the top: version, case hash, coefficients.
    """

    kernel: str = "stock"
    ranks: int = 1
    dump_format: str = "text"
    header: tuple[str, ...] = ()

    @property
    def style(self) -> ModuleType:
        """The module that writes what differs between the kernels."""
        return plugin if self.kernel == "compiled" else stock


def script_text(scene: Scene, **options: Any) -> str:
    """The LAMMPS input script of a scene; keywords as of `Options`.

    A script of what its kernel lacks says so and ends with status 1.
    """
    how = Options(**options)
    title = f"{scene.name}: {scene.description}".rstrip(": ")
    if how.kernel == "stock" and (lacking := stock.lacking(scene)):
        said = f"No run: LAMMPS' own styles have no {lacking}; {SCRIPTS['compiled']} beside it runs with the plugin"
        how = replace(how, kernel="compiled", header=(said, *how.header))
        return joined(title, SCRIPTS["compiled"], how, [("end", [f'print "{lammps_comment(said)}"', "quit 1"])])
    begin = -scene.settle_steps * scene.time_step
    sections = [
        ("settings", how.style.settings(scene, how.ranks)),
        ("box and discs", [*stock.box_and_discs(scene), *how.style.molecule(scene)]),
        ("simulated time before the gate opens", [f"reset_timestep  0 time {number(begin)}"] if begin else []),
        *how.style.law(scene),
        ("outlets", stock.outlets(scene)),
        ("pour", stock.pours(scene, how.style.own_sizes(scene))),
        *control(scene, how),
        ("output", stock.output(scene, how.dump_format)),
        ("log", stock.thermo(scene)),
        ("run", stock.schedule(scene, how.style.gates(scene), how.style.inlets(scene), how.kernel)),
    ]
    return joined(title, SCRIPTS[how.kernel], how, sections)


def control(scene: Scene, how: Options) -> list[Section]:
    """Sections that balance, record, guard and stop a run.

    Several ranks get equal shares of the discs along x, adapted as the flow fills the channel. They pause if there is a
    file `STOP_FILE`, for which the first rank looks at ends of probe windows: no restart file keeps a window's sums.
    """
    share, stop = [], []
    if how.ranks > 1:
        share = [f"fix             balance all balance {max(1, scene.output_steps)} 1.01 shift x 10 1.005"]
        every = scene.probe_steps if scene.probes else min(scene.output_steps, STOP_STEPS)
        stop = [
            f"variable        asked equal is_file({STOP_FILE})",
            f"fix             stop all halt {every} v_asked != 0 error soft",
        ]
    return [
        ("balance of the ranks", share),
        ("force on structures", how.style.probes(scene)),
        ("guards", how.style.guards(scene)),
        ("end on request", stop),
    ]


def joined(title: str, name: str, how: Options, sections: list[Section]) -> str:
    """The text of the script of that name; sections without commands are left out."""
    needs = " -var plugin FILE (`lammps-jump kernels build` prints FILE)" if how.kernel == "compiled" else ""
    lines = [f"# {lammps_comment(line)}" for line in (title, *how.header, f"run it with: lmp -in {name}{needs}")]
    for name, commands in sections:
        if commands:
            lines += ["", f"# --- {name}", *commands]
    return "\n".join(lines) + "\n"


def stop_at(scene: Scene, step: int) -> tuple[int, list[str]]:
    """The step at which a run with these commands pauses: that before this one, or before the end of its window."""
    window = scene.probe_steps if scene.probes else 1
    step = -(-step // window) * window - 1
    # equal, not beyond: what saves the state goes on to the next step
    return step, [
        f"variable        here equal step=={step}",
        "fix             stop_here all halt 1 v_here != 0 error soft",
    ]


def data_text(scene: Scene) -> Iterator[str]:
    """Parts of the data file with the discs at the start, full precision; one text would take 100 B a disc."""
    (xlo, xhi), (ylo, yhi) = scene.domain
    half = number(stock.half_depth(scene))
    name = lammps_comment(scene.name)
    lines = [
        f"{len(scene.positions)} discs of {name}; the density column is of spheres, the script sets the mass",
        "",
        f"{len(scene.positions)} atoms",
        "1 atom types",
        "",
        f"{number(xlo)} {number(xhi)} xlo xhi",
        f"{number(ylo)} {number(yhi)} ylo yhi",
        f"-{half} {half} zlo zhi",
        "",
        "Atoms # sphere",
        "",
    ]
    yield "\n".join(lines) + "\n"
    density, parts = number(scene.density), range(0, len(scene.positions), PART)
    for first in parts:
        xy = scene.positions[first : first + PART]
        diameters = scene.diameters(np.arange(first + 1, first + 1 + len(xy))).tolist()
        discs = enumerate(zip(diameters, *xy.T.tolist(), strict=True), first + 1)
        yield "".join([f"{i} 1 {d!r} {density} {x!r} {y!r} 0\n" for i, (d, x, y) in discs])
    spins = np.zeros(len(scene.positions)) if scene.earlier is None else scene.earlier.spins
    if scene.velocities.any() or spins.any():
        yield "\nVelocities\n\n"
        for first in parts:
            part = slice(first, first + PART)
            discs = enumerate(zip(scene.velocities[part].tolist(), spins[part].tolist(), strict=True), first + 1)
            yield "".join([f"{i} {vx!r} {vy!r} 0 0 0 {w or 0!r}\n" for i, ((vx, vy), w) in discs])


def molecule_text(scene: Scene) -> str:
    """One disc, the largest, as a molecule: fix deposit in single-atom mode would insert a sphere of radius 0.5."""
    d, m = number(scene.largest), number(float(scene.masses(scene.largest)))
    return (
        f"# one disc of {lammps_comment(scene.name)}\n\n1 atoms\n\nCoords\n\n1 0 0 0\n\nTypes\n\n1 1\n\n"
        f"Diameters\n\n1 {d}\n\nMasses\n\n1 {m}\n"
    )


def write_script(scene: Scene, folder: Path, **options: Any) -> Path:
    """Write the scripts and their side files into `folder`; returns the path of the kernel's script (`SCRIPTS`).

    Keywords are those of `Options`. The stock script is always written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    if len(scene.positions):
        write_text(folder / stock.DATA_FILE, "".join(data_text(scene)))
    if scene.inlets or scene.pours:
        write_text(folder / stock.MOLECULE_FILE, molecule_text(scene))
    if plugin.has_turns(scene):
        write_text(folder / plugin.TURNS_FILE, "".join(plugin.turns_text(scene)))
    for kernel in dict.fromkeys(("stock", Options(**options).kernel)):
        path = folder / SCRIPTS[kernel]
        write_text(path, script_text(scene, **{**options, "kernel": kernel}))
    return path


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

    ``fix pour`` lets discs in at the step after that of its command.
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
    """Continues the dump after its last frame; a plain interval would write the frame of this step twice."""
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
