# SPDX-License-Identifier: GPL-2.0-or-later
"""LAMMPS commands that record the force on probed walls: a row of ``forces.csv`` a window."""

from __future__ import annotations

from math import isfinite

from lammps_jump.files import BODIES, BODIES_HEADER, POSES, POSES_HEADER, forces_header
from lammps_jump.scene import MovingWall, Scene

from .regions import number, way
from .walls import fix_names, moved, pushing_extents, stock_wall

MARGIN = 1.01
"""Distance from a face up to which discs are looked at, in largest radii; they touch it within 1."""


def raw_forces(name: str) -> str:
    """File of one wall: LAMMPS buffers, so that two fixes writing to one file would mix their lines."""
    return f"forces_{name}.raw"


def rows(scene: Scene, name: str, force: tuple[str, ...]) -> list[str]:
    """Variables of a wall's force (x and y), moment and, where walls move, power; and the fix that writes its rows."""
    labels = [f"{label}_{name}" for label in ("fx", "fy", "mz", "power")[: len(force)]]
    row = ",".join(["${clock}", name, *(f"${{{label}}}" for label in labels)])
    return [
        *(f"variable        {label} equal {formula}" for label, formula in zip(labels, force, strict=True)),
        f'fix             write_{name} all print {scene.probe_steps} "{row}" &',
        f'                file {raw_forces(name)} screen no title "{forces_header(power=len(force) > 3)}"',
    ]


def stock_probes(scene: Scene) -> list[str]:
    """Force on each probed wall, averaged over a window, every step counted.

    The moment needs a product for each disc, which only an atom-style variable can form. For all discs at every step
    that would take half the time of a run. A dynamic group holds those near the wall: 1 % (measured on quick_jump).
    """
    n = scene.probe_steps
    lines = ["variable        clock equal time"] if scene.probes else []
    for moving in (one for name in scene.probes for one in scene.walls if one.wall.name == name):
        name = moving.wall.name
        x0, y0 = centre(moving)
        parts = [f"f_{fix}" for fix in fix_names(stock_wall(moving, scene))]
        pushes = " ".join(f"{part}[2] {part}[3]" for part in parts)
        arms = "+".join(f"({part}[5]-{x0})*{part}[3]-({part}[6]-{y0})*{part}[2]" for part in parts)
        columns = " ".join(f"c_push_{name}[{i + 1}]" for i in range(2 * len(parts)))
        along = [f"f_mean_{name}[{i + 1}]" for i in range(2 * len(parts))]
        # the columns hold the force on the disc; the wall feels the opposite
        force = [f"-({'+'.join(along[0::2])})", f"-({'+'.join(along[1::2])})", f"-f_mean_{name}[{len(along) + 1}]"]
        work = power(moving, scene, len(parts))
        also = f" v_work_{name}" if work else ""
        if scene.moves:
            force.append(f"f_mean_{name}[{len(along) + 2}]" if work else "0")
        lines += [
            *near(moving, scene),
            f"compute         push_{name} all reduce sum {pushes}",
            f"variable        arm_{name} atom {arms}",
            f"compute         turn_{name} near_{name} reduce sum v_arm_{name}",
            *work,
            f"fix             mean_{name} all ave/time 1 {n} {n} {columns} c_turn_{name}{also}",
            *rows(scene, name, tuple(force)),
        ]
    return lines


def centre(moving: MovingWall) -> tuple[str, str]:
    """Formulas of the point about which the moment on a wall is taken, in brackets."""
    wall, motion = moving
    if motion.kind is None:
        x, y = (f"({number(value)})" for value in wall.moment_point)
        return x, y
    there = zip(motion.about, ("x", "y"), way(moving), strict=False)
    x, y = (f"({number(value)}{f'+v_{part}_{wall.name}' if formula else ''})" for value, part, formula in there)
    return x, y


def power(moving: MovingWall, scene: Scene, parts: int) -> list[str]:
    """Variables up to ``work_NAME``, the power of a moving wall on the discs at a step; none of a wall at rest.

    Its velocity is centred on the step, so that the sum of power is the work that LAMMPS' steps do on the discs.
    """
    name, lines, terms = moving.wall.name, [], []
    pushes = ["+".join(f"c_push_{name}[{2 * i + axis}]" for i in range(parts)) for axis in (1, 2)]
    sums = (*(f"({push})" for push in pushes), f"c_turn_{name}")
    formulas = zip(("x", "y", "angle"), way(moving, "v_after"), way(moving, "v_before"), sums, strict=True)
    for part, after, before, push in formulas:
        if after:
            lines.append(f"variable        rate_{part}_{name} equal ({after}-({before}))/{number(2 * scene.time_step)}")
            terms.append(f"{push}*v_rate_{part}_{name}")
    return [*lines, f"variable        work_{name} equal {'+'.join(terms)}"] if terms else []


def near(moving: MovingWall, scene: Scene) -> list[str]:
    """The group of the discs that a wall's faces may touch, formed anew at every step."""
    wall = moving.wall
    # a union does not see its parts move: all discs of a box that moves
    extents = pushing_extents(wall) if moving.motion.kind is None else [wall.extent]
    margin, name = MARGIN * 0.5 * scene.largest, f"near_{wall.name}"
    regions = []
    for count, around in enumerate(extents, 1):
        ends = [value for low, high in around for value in (low - margin, high + margin)]
        extent = " ".join(number(end) if isfinite(end) else "INF" for end in ends)
        regions.append((f"{name}_{count}", extent))
    lines = [f"region          {region} block {extent} INF INF{moved(moving)}" for region, extent in regions]
    last = regions[0][0]
    if len(regions) > 1:
        last = name
        lines.append(f"region          {name} union {len(regions)} {' '.join(region for region, _ in regions)}")
    return [*lines, f"group           {name} dynamic all region {last}"]


def plugin_probes(scene: Scene) -> list[str]:
    """Force on each probed wall: the fix holds the mean over each window, every step counted, moments and power too.

    The fix also writes the rows of ``walls.csv`` and ``bodies.csv``, after their headers.
    """
    lines = ["variable        clock equal time"] if scene.probes else []
    columns = 4 if scene.moves else 3
    for index, name in enumerate(scene.probes):
        lines += rows(scene, name, tuple(f"f_motion[{columns * index + i + 1}]" for i in range(columns)))
    heads = ((scene.lids, POSES_HEADER, POSES), (scene.bodies, BODIES_HEADER, BODIES))
    return [*lines, *(f'print           "{header}" file {file} screen no' for there, header, file in heads if there)]


def going_on(scene: Scene, text: str) -> str:
    """A script whose files go on after what the part before has written."""
    for name in scene.probes:
        text = text.replace(f" file {raw_forces(name)} ", f" append {raw_forces(name)} ")
    for header, file in ((POSES_HEADER, POSES), (BODIES_HEADER, BODIES)):
        text = text.replace(f'print           "{header}" file {file} screen no\n', "")
    return text
