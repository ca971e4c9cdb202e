# SPDX-License-Identifier: GPL-2.0-or-later
"""LAMMPS commands that record the force on probed walls: a row of ``forces.csv`` a window."""

from __future__ import annotations

from math import isfinite

from lammps_jump.files import FORCES_HEADER
from lammps_jump.scene import Scene, Wall

from .walls import fix_names, number, pushing_extents, stock_wall

MARGIN = 1.01
"""Distance from a face up to which discs are looked at, in largest radii; they touch it within 1."""


def raw_forces(name: str) -> str:
    """File of one wall: LAMMPS buffers, so that two fixes writing to one file would mix their lines."""
    return f"forces_{name}.raw"


def rows(scene: Scene, name: str, force: tuple[str, str, str]) -> list[str]:
    """Variables of a wall's force (x and y) and moment, from their formulas, and the fix that writes its rows."""
    labels = [f"{label}_{name}" for label in ("fx", "fy", "mz")]
    row = ",".join(["${clock}", name, *(f"${{{label}}}" for label in labels)])
    return [
        *(f"variable        {label} equal {formula}" for label, formula in zip(labels, force, strict=True)),
        f'fix             write_{name} all print {scene.probe_steps} "{row}" &',
        f'                file {raw_forces(name)} screen no title "{FORCES_HEADER}"',
    ]


def stock_probes(scene: Scene) -> list[str]:
    """Force on each probed wall, averaged over a window, every step counted.

    The moment needs a product for each disc, which only an atom-style variable can form. For all discs at every step
    that would take half the time of a run. A dynamic group holds those near the wall: 1 % (measured on quick_jump).
    """
    n = scene.probe_steps
    lines = ["variable        clock equal time"] if scene.probes else []
    for name in scene.probes:
        wall = scene.wall(name)
        x0, y0 = (f"({number(value)})" for value in wall.moment_point)
        parts = [f"f_{fix}" for fix in fix_names(stock_wall(wall, scene))]
        pushes = " ".join(f"{part}[2] {part}[3]" for part in parts)
        arms = "+".join(f"({part}[5]-{x0})*{part}[3]-({part}[6]-{y0})*{part}[2]" for part in parts)
        columns = " ".join(f"c_push_{name}[{i + 1}]" for i in range(2 * len(parts)))
        along = [f"f_mean_{name}[{i + 1}]" for i in range(2 * len(parts))]
        # the columns hold the force on the disc; the wall feels the opposite
        force = (f"-({'+'.join(along[0::2])})", f"-({'+'.join(along[1::2])})", f"-f_mean_{name}[{len(along) + 1}]")
        lines += [
            *near(wall, scene),
            f"compute         push_{name} all reduce sum {pushes}",
            f"variable        arm_{name} atom {arms}",
            f"compute         turn_{name} near_{name} reduce sum v_arm_{name}",
            f"fix             mean_{name} all ave/time 1 {n} {n} {columns} c_turn_{name}",
            *rows(scene, name, force),
        ]
    return lines


def near(wall: Wall, scene: Scene) -> list[str]:
    """The group of the discs that a wall's faces may touch, formed anew at every step."""
    margin, name = MARGIN * 0.5 * scene.largest, f"near_{wall.name}"
    regions = []
    for count, around in enumerate(pushing_extents(wall), 1):
        ends = [value for low, high in around for value in (low - margin, high + margin)]
        extent = " ".join(number(end) if isfinite(end) else "INF" for end in ends)
        regions.append((f"{name}_{count}", extent))
    lines = [f"region          {region} block {extent} INF INF" for region, extent in regions]
    last = regions[0][0]
    if len(regions) > 1:
        last = name
        lines.append(f"region          {name} union {len(regions)} {' '.join(region for region, _ in regions)}")
    return [*lines, f"group           {name} dynamic all region {last}"]


def plugin_probes(scene: Scene) -> list[str]:
    """Force on each probed wall: the fix holds the mean over each window, every step counted, moments too."""
    lines = ["variable        clock equal time"] if scene.probes else []
    for index, name in enumerate(scene.probes):
        x, y, moment = (f"f_motion[{(4 if scene.moves else 3) * index + i}]" for i in (1, 2, 3))
        lines += rows(scene, name, (x, y, moment))
    return lines
