"""Scene to a folder that runs alone: ``in.lammps`` and, where needed, ``discs.data`` and ``disk.mol``."""

from __future__ import annotations

from pathlib import Path

from lammps_jump.scene.scene import Scene

from . import plugin as compiled
from . import stock as blocks
from .stock import number

STOP_FILE = "stop.request"
"""A file of this name in the run folder ends a run of more ranks in order."""
STOP_STEPS = 100
STATE = "checkpoint-{step}.restart"


def script_text(
    scene: Scene,
    *,
    kernel: str = "stock",
    ranks: int = 1,
    dump_format: str = "text",
    header: tuple[str, ...] = (),
    plugin: Path | None = None,
) -> str:
    """The LAMMPS input script of a scene.

    Parameters
    ----------
    scene : Scene
    kernel : {'stock', 'compiled'}
        Styles that come with LAMMPS, or this project's plugin.
    ranks : int
        Number of MPI ranks the run will have; more than one adds the cutting along x and its balancing.
    dump_format : {'text', 'gz', 'binary'}
    header : tuple of str
        Comment lines for the top: version, case hash, command.
    plugin : Path, optional
        The plugin's shared object, needed for the compiled kernel; ``-var plugin FILE`` names another one.
    """
    if kernel == "compiled":
        law = [
            ("contact law", compiled.contact_law(scene)),
            ("neighbours", compiled.neighbours(scene)),
            ("motion, gravity and walls", compiled.motion_and_walls(scene)),
        ]
        probes, schedule = compiled.probes(scene), compiled.schedule(scene)
    else:
        law = [
            ("contact law: stiffness, gamma_n = c/m_eff, gamma_t, friction", blocks.contact_law(scene)),
            ("neighbours", blocks.neighbours(scene)),
            ("motion", blocks.motion(scene)),
            ("walls", blocks.walls(scene)),
        ]
        probes, schedule = blocks.probes(scene), blocks.schedule(scene)
    start_time = -scene.settle_steps * scene.time_step
    sections = [
        ("settings", (compiled.load(plugin) if kernel == "compiled" else []) + blocks.settings(scene, ranks)),
        ("box and discs", blocks.box_and_discs(scene)),
        (
            "simulated time before the gate opens",
            [f"reset_timestep  0 time {number(start_time)}"] if start_time else [],
        ),
        *law,
        ("outlets", blocks.outlets(scene)),
        ("pour", blocks.pours(scene)),
        ("balance of the ranks", balance(scene, ranks)),
        ("force on structures", probes),
        ("guards", compiled.guards(scene) if kernel == "compiled" else blocks.guards(scene)),
        ("end on request", polite_end(scene, ranks)),
        ("output", blocks.output(scene, dump_format)),
        ("log", blocks.thermo(scene)),
        ("run", schedule),
        ("state, where the end was asked for", save_at_end(scene, kernel, ranks, first_step(scene))),
    ]
    lines = [f"# {line}" for line in (f"{scene.name}: {scene.description}".rstrip(": "), *header)]
    for title, commands in sections:
        if commands:
            lines += ["", f"# --- {title}", *commands]
    return "\n".join(lines) + "\n"


def balance(scene: Scene, ranks: int) -> list[str]:
    """Even shares of discs along x, moved as the flow fills the channel."""
    if ranks == 1:
        return []
    return [f"fix             balance all balance {max(1, scene.output_steps)} 1.01 shift x 10 1.005"]


def first_step(scene: Scene) -> int:
    """Checkpoints are of later steps only: up to here a script with a second ``run`` command is in its first."""
    return scene.settle_steps if scene.inlets else 0


def polite_end(scene: Scene, ranks: int) -> list[str]:
    """Ranks of their own have no caller who could end them in order: they end where there is a file that asks for it.

    The first rank's answer counts for all.
    """
    if ranks == 1:
        return []
    return [
        f"variable        asked equal is_file({STOP_FILE})",
        f"fix             stop all halt {_stop_steps(scene, ranks)} v_asked != 0 error soft",
    ]


def _stop_steps(scene: Scene, ranks: int) -> int:
    """How often ranks can be stopped: at the ends of windows of the probes, whose sums no restart file keeps."""
    if ranks == 1:
        return 1
    return scene.probe_steps if scene.probes else min(scene.output_steps, STOP_STEPS)


def stop_at_step(script: str, scene: Scene, ranks: int, step: int) -> str:
    """The text of a script that ends at a step as it does on request; ranks go on to the end of the window."""
    every = _stop_steps(scene, ranks)
    step = -(-step // every) * every
    head, run, rest = script.partition("\nrun ")
    # equal, not beyond: what saves the state goes on for some steps
    halt = (
        f"\nvariable        here equal step=={step}\nfix             stop_here all halt {every} v_here != 0 error soft"
    )
    return head + halt + run + rest


def save_at_end(scene: Scene, kernel: str, ranks: int, first: int) -> list[str]:
    """The restart file of ranks that ended on request behind step `first`, and a last line of the log."""
    if ranks == 1:
        return []
    commands = ["timer timeout off", "run 0 pre no post no", *blocks.half_step_back(scene, kernel)]
    commands.append(f"write_restart {STATE.format(step='$(step)')}")
    words = " &\n                ".join(f'"{" ".join(command.split())}"' for command in commands)
    return [f'if "$(step) > {first} && $(step) < {scene.steps}" then &\n                {words}']


def data_text(scene: Scene) -> str:
    """Data file with the discs at the start (full precision)."""
    (xlo, xhi), (ylo, yhi) = scene.domain
    half, d = number(scene.radius), number(scene.diameter)
    lines = [
        f"{len(scene.positions)} discs of {scene.name}; the density column is of spheres, the script sets the mass",
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
    density = number(scene.density)
    lines += [f"{i} 1 {d} {density} {number(x)} {number(y)} 0" for i, (x, y) in enumerate(scene.positions, 1)]
    if scene.velocities.any():
        lines += ["", "Velocities", ""]
        lines += [f"{i} {number(vx)} {number(vy)} 0 0 0 0" for i, (vx, vy) in enumerate(scene.velocities, 1)]
    return "\n".join(lines) + "\n"


def molecule_text(scene: Scene) -> str:
    """One disc as a molecule: fix deposit in single-atom mode would insert a sphere of radius 0.5."""
    d, m = number(scene.diameter), number(scene.mass)
    return (
        f"# one disc of {scene.name}\n\n1 atoms\n\nCoords\n\n1 0 0 0\n\nTypes\n\n1 1\n\n"
        f"Diameters\n\n1 {d}\n\nMasses\n\n1 {m}\n"
    )


def write_script(
    scene: Scene,
    folder: Path,
    *,
    kernel: str = "stock",
    ranks: int = 1,
    dump_format: str = "text",
    header: tuple[str, ...] = (),
    plugin: Path | None = None,
) -> Path:
    """Write the script and its side files into `folder`; returns the path of ``in.lammps``."""
    folder.mkdir(parents=True, exist_ok=True)
    if len(scene.positions):
        (folder / blocks.DATA_FILE).write_text(data_text(scene))
    if scene.inlets or scene.pours:
        (folder / blocks.MOLECULE_FILE).write_text(molecule_text(scene))
    path = folder / "in.lammps"
    text = script_text(scene, kernel=kernel, ranks=ranks, dump_format=dump_format, header=header, plugin=plugin)
    path.write_text(text)
    return path
