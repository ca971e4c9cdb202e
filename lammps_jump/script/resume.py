"""The second script of an interrupted run: ``in.resume.lammps`` takes it up from a restart file, with the same styles.

LAMMPS' granular forces depend on velocity, and a step evaluates them with the velocities of its half step,
v_(n-1/2). A run that starts evaluates its first forces with v_n instead, so that a restarted run parts from the other
one at once (LAMMPS' documentation of `read_restart` says so; measured here: 5e-7 d after fifty steps of a dam break
with friction, 1e-4 d after 650). The restart files of this project therefore hold v_(n-1/2) = v_n - dt F_n / (2 m),
which is known where the run stops: the first force evaluation of the next part is then the same as the last one of the
part before, up to the order of sums, half a kick gives v_n back, and the run goes on with those forces
(``run … pre no``).
"""

from __future__ import annotations

from pathlib import Path

from lammps_jump.files import DUMP_NAMES
from lammps_jump.scene.scene import Scene

from . import plugin as compiled
from . import stock as blocks
from .assemble import balance, polite_end, save_at_end

SCRIPT = "in.resume.lammps"
LOG = "log.resume.lammps"
BINARY_PART = "dump.resume.lammpsbin"
"""LAMMPS appends to text and gzip dumps, not to binary ones; these are put together afterwards."""


def continuation_text(
    scene: Scene,
    *,
    state: str,
    step: int,
    removed: tuple[int, ...],
    kernel: str = "stock",
    ranks: int = 1,
    dump_format: str = "text",
    header: tuple[str, ...] = (),
    plugin: Path | None = None,
) -> str:
    """The script that goes on; parameters as of `script_text`, and

    Parameters
    ----------
    state : str
        Restart file, written after `lammps_jump.script.stock.half_step_back`.
    step : int
        Its step, behind `lammps_jump.script.assemble.first_step`, and the end of a window of the probes.
    removed : tuple of int
        Discs that each outlet has taken so far: ``fix evaporate`` keeps no count over a restart.
    """
    own = kernel == "compiled"
    style = compiled if own else blocks
    motion = compiled.motion_and_walls(scene) if own else [*blocks.motion(scene), *blocks.walls(scene)]
    # gates that wait in a scene with inlets are gone by now; those without go on moving out of the way
    gates = [] if own or scene.inlets else [line for item in scene.gates for line in blocks.gate(scene, item)]
    sections = [
        ("settings", (compiled.load(plugin) if own else []) + blocks.settings(scene, ranks)),
        ("state", [f"read_restart    {state}", *blocks.molecule(scene)]),
        ("contact law", style.contact_law(scene)),
        ("neighbours", style.neighbours(scene)),
        ("motion and walls", motion),
        ("outlets", blocks.outlets(scene)),
        ("balance of the ranks", balance(scene, ranks)),
        ("force on structures", style.probes(scene)),
        ("guards", style.guards(scene)),
        ("end on request", polite_end(scene, ranks)),
        ("output", _output(scene, dump_format)),
        ("log", blocks.thermo(scene, removed)),
        ("gates and inlets", [*gates, *blocks.inlets(scene)]),
        ("forces of the half step, then the velocities of the step", ["run             0 post no"]),
        ("", blocks.half_step(scene, kernel)),
        ("run", [f"run             {scene.steps} upto pre no", *save_at_end(scene, kernel, ranks, step)]),
    ]
    lines = [f"# {line}" for line in (f"{scene.name}: goes on from step {step}", *header)]
    for title, commands in sections:
        if commands:
            lines += (["", f"# --- {title}"] if title else []) + commands
    return "\n".join(lines) + "\n"


def _output(scene: Scene, dump_format: str) -> list[str]:
    """The dump goes on behind its last frame; a plain interval would write a frame of this step once more."""
    lines = blocks.output(scene, dump_format)
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
