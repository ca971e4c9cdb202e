"""Blocks that use this project's plugin styles (lammps_jump/engines/plugin) in place of the stock ones."""

from __future__ import annotations

from pathlib import Path

from lammps_jump.files import FORCES_HEADER
from lammps_jump.scene.scene import Scene
from lammps_jump.scene.walls import Block, Plane, Wall

from .stock import GUARDS_PER_FRAME, gravity, inlets, number, raw_forces

GLOBAL_VALUES = 9
"""Length of the fix' vector before the probes' values."""
OVERLAP = 7
ONE_RANK_LOOKS = 10
SORT_CELL = 0.65
"""LAMMPS sorts discs into cells of this many diameters, for the cache's sake: half of d and a skin of 0.3 d."""


def load(plugin: Path | None) -> list[str]:
    """Load the plugin; ``-var plugin FILE`` names another build of it, but not where its path holds blanks."""
    path = str(plugin or "jump_plugin.so")
    if len(path.split()) > 1:  # quoted text stays one word, but a variable in quotes is not replaced
        return [f'plugin          load "{path}"']
    return [f"variable        plugin index {path}", "plugin          load ${plugin}"]


def contact_law(scene: Scene) -> list[str]:
    """Pair style for equal discs; what the scene lacks (friction, spin, soft touch) is not named and not computed."""
    c = scene.coefficients
    words = [
        f"pair_style      jump/disc law {scene.friction_law} k {number(c.stiffness)} gamma {number(c.gamma_normal)}",
        f"gammat {number(c.gamma_tangential)} mu {number(c.friction)} mass {number(c.mass)} diameter "
        f"{number(scene.diameter)} skin {number(scene.skin)} halo yes",
    ]
    if scene.touch == "smooth":
        words.append(f"touch smooth {number(scene.touch_width)} dashpot even")
    if scene.rotation:
        words.append("spin yes")
    return [" ".join(words), "pair_coeff      * *"]


def neighbours(scene: Scene) -> list[str]:
    """How far discs may move before LAMMPS looks where they belong, and how often it asks.

    The plugin keeps a list of its own, with a skin of its own, and brings the discs of other ranks itself
    (`contact_law`). LAMMPS' check serves to find lost discs and discs that must change ranks. A part of the channel is
    never thinner than LAMMPS' skin (fix balance); between two checks no disc may cross one, so that ranks look more
    often the larger the step.
    """
    often = max(1, min(ONE_RANK_LOOKS, int(0.5 / scene.coefficients.time_step_fraction)))
    every = f"$({often}+{ONE_RANK_LOOKS - often}*(extract_setting(world_size)==1))"
    return [
        f"neighbor        {number(scene.diameter)} bin",
        f"atom_modify     sort 1000 {number(SORT_CELL * scene.diameter)}",
        "# ranks look whether discs have moved on; one rank alone needs it for lost discs only",
        f"neigh_modify    delay 0 every {every if often < ONE_RANK_LOOKS else ONE_RANK_LOOKS} check yes",
    ]


def motion_and_walls(scene: Scene) -> list[str]:
    """One fix for integration, gravity, every wall and the force on the probed ones."""
    c = scene.coefficients
    lines = [f"timestep        {number(scene.time_step)}"]
    words = ["fix             motion all jump/step"]
    if scene.pours:  # fix pour wants the stock gravity fix: it reckons the fall from it
        lines += gravity(scene)
    elif any(scene.gravity):
        words.append(f"gravity {number(scene.gravity[0])} {number(scene.gravity[1])}")
    words.append(
        f"k_wall {number(c.stiffness_wall)} gamma_wall {number(c.gamma_normal_wall)} "
        f"gammat_wall {number(c.gamma_tangential_wall)} mu_wall {number(c.friction)}"
    )
    words += [_wall(item) for item in scene.walls]
    words += [f"{_wall(gate.wall)} until {gate.release_step}" for gate in scene.gates]
    if scene.probes:
        words.append(f"probe {scene.probe_steps} {' '.join(scene.probes)}")
    return [*lines, " &\n                ".join(words)]


def _wall(item: Wall) -> str:
    if isinstance(item, Plane):
        return f"wall plane {item.name} {item.axis} {number(item.at)} {item.side}"
    kind = "block" if isinstance(item, Block) else "box"
    return f"wall {kind} {item.name} " + " ".join(number(value) for value in (*item.x, *item.y))


def probes(scene: Scene) -> list[str]:
    """Rows of forces.csv: the fix holds the mean over each window, every step counted, moments too."""
    if not scene.probes:
        return []
    lines = ["variable        clock equal time"]
    for index, name in enumerate(scene.probes):
        first = GLOBAL_VALUES + 3 * index
        lines += [
            f"variable        {label}_{name} equal f_motion[{first + i}]"
            for i, label in enumerate(("fx", "fy", "mz"), 1)
        ]
        row = f"${{clock}},{name},${{fx_{name}}},${{fy_{name}}},${{mz_{name}}}"
        lines += [
            f'fix             write_{name} all print {scene.probe_steps} "{row}" &',
            f'                file {raw_forces(name)} screen no title "{FORCES_HEADER}"',
        ]
    return lines


def guards(scene: Scene) -> list[str]:
    """Ends a run whose discs are too deep in each other; the fix tells the largest overlap, and nothing moves in z."""
    every = max(1, scene.output_steps // GUARDS_PER_FRAME)
    return [
        f"variable        overlap equal f_motion[{OVERLAP}]",
        f"fix             guard_overlap all halt {every} v_overlap > {number(scene.overlap_limit)} error hard",
        # a comparison with NaN is false: the sum of all positions must be a number
        "variable        finite equal xcm(all,x)+xcm(all,y)<1e300",
        f"fix             guard_finite all halt {every} v_finite == 0 error hard",
    ]


def schedule(scene: Scene) -> list[str]:
    """The run; gates open inside the fix, only inlets behind a settling phase need a second run."""
    if scene.settle_steps and scene.inlets:
        return [
            f"run             {scene.settle_steps}",
            *inlets(scene),
            f"run             {scene.steps - scene.settle_steps}",
        ]
    return [*inlets(scene), f"run             {scene.steps}"]
