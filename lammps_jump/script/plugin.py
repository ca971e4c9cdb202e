# SPDX-License-Identifier: GPL-2.0-or-later
"""LAMMPS commands of the plugin's styles (lammps_jump/engines/plugin), in place of the stock ones."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf

from lammps_jump.files import BODIES, CONTACTS_FILE, POSES, SCENE_FILE
from lammps_jump.scene.meeting import LARGEST_OVERLAP, corners
from lammps_jump.scene.scene import Scene

from . import stock
from .probes import plugin_probes
from .walls import JOIN, number, numbers

probes = plugin_probes
TURNS_FILE = "inflow.turns"
"""Steps and speeds of the discs of an inflow against time."""
ONE_RANK_LOOKS = 10
SORT_CELL = 0.65
"""Side of the cells that LAMMPS sorts discs into (for the cache), in diameters: half of d and a skin of 0.3 d."""


def settings(scene: Scene, ranks: int) -> list[str]:
    """Load the plugin, whose path is given by ``-var plugin FILE``: the folder may run on another machine."""
    return ["plugin          load ${plugin}", *stock.settings(scene, ranks)]


def law(scene: Scene) -> list[tuple[str, list[str]]]:
    """Sections of the contact law, neighbours, motion and walls."""
    return [
        ("contact law", contact_law(scene)),
        ("neighbours", neighbours(scene)),
        ("motion, gravity and walls", motion_and_walls(scene)),
    ]


def gates(scene: Scene) -> list[str]:
    """Nothing: the plugin's fix opens the gates."""
    return []


def own_sizes(scene: Scene) -> list[str]:
    """Nothing: the plugin's fix gives inserted discs their own size (`sizes`)."""
    return []


def molecule(scene: Scene) -> list[str]:
    """The disc that pours insert; rows of inflow need none."""
    return stock.molecule(scene) if scene.pours else []


def inlets(scene: Scene) -> list[str]:
    """One fix for all rows: it inserts what ``fix deposit`` of LAMMPS inserts, in less time."""
    if not scene.inlets:
        return []
    disc = numbers(scene.largest, float(scene.masses(scene.largest)))
    rows = [
        f"row {row.first_step} {0 if row.turns else row.every_steps} {row.limit or 0} "
        f"{numbers(row.clearance, row.x, row.y, row.vx, row.vy)}"
        for row in scene.inlets
    ]
    timed = [f"turns {TURNS_FILE}"] if has_turns(scene) else []
    return [JOIN.join([f"fix             inlets all jump/inlet {disc}", *timed, *rows])]


def has_turns(scene: Scene) -> bool:
    """Tells whether rows let discs in at steps of their own: an inflow against time."""
    return any(row.turns for row in scene.inlets)


def turns_text(scene: Scene) -> Iterator[str]:
    """Lines of `TURNS_FILE`: number of the row from 1, step, and the velocity along x (m/s) of each disc."""
    for number_of_row, row in enumerate(scene.inlets, 1):
        for step, speed in zip(row.turns, row.speeds, strict=True):
            yield f"{number_of_row} {step} {speed!r}\n"


def contact_law(scene: Scene) -> list[str]:
    """The plugin's pair style; law, walls and all that belongs to them are in the file next to the script."""
    fixed = f" fixed {scene.fixed.first} {scene.fixed.last}" if scene.fixed else ""
    return [f"pair_style      jump/disc {SCENE_FILE}{fixed}", "pair_coeff      * *"]


def neighbours(scene: Scene) -> list[str]:
    """Distance that discs may move before LAMMPS sorts them to ranks, and how often it checks.

    The plugin has its own list and skin, and fetches the discs of other ranks itself (`contact_law`). LAMMPS' check
    finds lost discs and discs that must change ranks. The part of a rank is never thinner than LAMMPS' skin (fix
    balance). No disc may cross a part between two checks, so that ranks check more often the larger the step.
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
    lines = [f"timestep        {number(scene.time_step)}"]
    words = ["fix             motion all jump/step"]
    if scene.pours:  # fix pour wants the stock gravity fix: it computes the fall from it
        lines += stock.gravity(scene)
    elif any(scene.gravity):
        words.append(f"gravity {numbers(*scene.gravity)}")
    names = [one.wall.name for one in scene.walls]
    words += [" ".join(["walls", str(len(names)), *names])] if names else []
    words += [
        f"went {wall.name} {numbers(*motion.went.speed)}" for wall, motion in scene.walls if motion.went is not None
    ]
    if scene.bodies:
        smallest = min((corner.radius for _, corner in corners(scene)), default=inf)
        limit = min(LARGEST_OVERLAP * smallest, scene.overlap_limit or inf)
        words.append(f"bodies {scene.probe_steps} {BODIES} {number(limit)}")
    if scene.sizes and (scene.inlets or scene.pours):
        words.append(f"sizes {scene.most_discs} {number(scene.density)}")
    words += [f"slots {scene.slots}"] if scene.slots else []
    if scene.contact_output:
        words.append(f"contacts {scene.output_steps} {CONTACTS_FILE}")
    if scene.lids:
        words.append(f"poses {scene.output_steps} {POSES}")
    if scene.probes:
        words.append(f"probe {scene.probe_steps} {' '.join(scene.probes)}")
    return [*lines, JOIN.join(words)]


def guards(scene: Scene) -> list[str]:
    """Guards that end a run that has gone wrong; the fix gives the largest overlap, and nothing moves in z."""
    return stock.guards_of(scene, "f_motion")
