# SPDX-License-Identifier: GPL-2.0-or-later
"""Small scenes as lines of LAMMPS, with the styles of the plugin, and a run of such lines."""

from __future__ import annotations

from dataclasses import replace
from uuid import uuid4

import numpy as np

from lammps_jump.engines.native import WithoutDiscs
from lammps_jump.files import SCENE_FILE
from lammps_jump.scene.scene import handmade_scene
from lammps_jump.scene.walls import Plane
from lammps_jump.script.plugin import contact_law, motion_and_walls
from lammps_jump.script.walls import JOIN

DIAMETER = 0.2


def scene(positions, velocities, walls, *, law="viscous", fraction=0.05, **more):
    """A scene of discs of 40 kg with the coefficients of the hydraulic jump."""
    settings = {"steps": 1000, "output_steps": 1000, "skin": 0.06, "overlap_limit": DIAMETER, "name": "small"}
    return handmade_scene(
        positions, velocities, walls, friction_law=law, time_step_fraction=fraction, correct_restitution=True,
        domain=((-3.0, 9.0), (-4.0, 9.0)), **{**settings, **more},
    )  # fmt: skip


def cloud(seed, nx=12, ny=12, speed=3.0, at=(0.3, 0.3)):
    """Discs near a lattice with random velocities, so that many collide within 1000 steps."""
    generator = np.random.default_rng(seed)
    grid = np.array([(at[0] + 0.21 * i, at[1] + 0.21 * j) for i in range(nx) for j in range(ny)])
    return grid + generator.normal(0, 0.002, grid.shape), generator.normal(0, speed, grid.shape)


def start(case):
    (xlo, xhi), (ylo, yhi) = case.domain
    lines = [
        "units si",
        "dimension 2",
        "newton off",
        "boundary f f p",
        "atom_style sphere",
        "comm_modify vel yes",
    ]
    lines += [f"region domain block {xlo} {xhi} {ylo} {yhi} -0.1 0.1", "create_box 1 domain"]
    for index, (x, y) in enumerate(case.positions, 1):
        lines.append(f"create_atoms 1 single {float(x)!r} {float(y)!r} 0")
        vx, vy = case.velocities[index - 1]
        lines += [f"group one id {index}", f"velocity one set {float(vx)!r} {float(vy)!r} 0", "group one delete"]
    lines += [f"set group all diameter {case.diameter!r}", f"set group all mass {case.mass!r}"]
    return [*lines, "neighbor 0.06 bin", f"timestep {case.time_step!r}"]


def traffic(case, folder):
    lines = []
    if case.inlets:
        d, m = case.diameter, case.mass
        parts = ["disc", "1 atoms", "Coords", "1 0 0 0", "Types", "1 1", "Diameters", f"1 {d!r}", "Masses", f"1 {m!r}"]
        (folder / "disc.mol").write_text("\n\n".join(parts) + "\n")
        lines.append(f"molecule disc {folder / 'disc.mol'}")
    for index, row in enumerate(case.inlets):
        lines += [
            f"region in{index} block {row.x} {row.x} {row.y} {row.y} 0 0",
            f"fix in{index} all deposit 999 0 {row.every_steps} {7 + index} region in{index} mol disc id max "
            f"near {row.clearance} attempt 1 vx {row.vx} {row.vx} vy {row.vy} {row.vy}",
        ]
    for index, out in enumerate(case.outlets):
        lines += [
            f"region out{index} block INF INF INF {out.at} INF INF",
            f"fix out{index} all evaporate {out.every_steps} 100000 out{index} 3",
        ]
    return lines


def styles(case, plugin, folder, *, probe="", skin=0.3 * DIAMETER):
    """Lines of the plugin's styles, whose file of the scene is in the folder."""
    case = replace(case, skin=skin, probes=())
    scene_file = folder / f"{uuid4()}.image"
    scene_file.write_bytes(WithoutDiscs(case).file())
    style, coefficients = (line.replace(SCENE_FILE, str(scene_file)) for line in contact_law(case))
    *_, words = motion_and_walls(case)
    words = words.replace(JOIN, " ").replace("fix             motion", "fix step")
    return [f"plugin load {plugin}", style, coefficients, f"{words} {probe}"]


def compiled(case, plugin, folder, **options):
    return [*start(case), *styles(case, plugin, folder, **options), *traffic(case, folder)]


class Run:
    """A LAMMPS instance that has done some commands; the discs in the order of their ids."""

    def __init__(self, lammps, lines):
        self.engine = lammps(cmdargs=["-log", "none", "-screen", "none", "-nocite"])
        self.do(*lines)

    def do(self, *lines):
        for line in lines:
            self.engine.command(line)
        return self

    def discs(self, name="x"):
        n = self.engine.extract_global("nlocal")
        order = np.argsort(np.array(self.engine.numpy.extract_atom("id")[:n]))
        return np.array(self.engine.numpy.extract_atom(name)[:n])[order]

    def vector(self, n):
        return np.array([self.engine.extract_fix("step", 0, 1, index) for index in range(n)])

    @property
    def overlap(self):
        return self.engine.extract_fix("step", 0, 0)

    def __enter__(self):
        return self

    def __exit__(self, *error):
        self.engine.close()


def final(lammps, lines, steps, *names):
    with Run(lammps, lines) as run:
        run.do(f"run {steps}")
        return [run.discs(name) for name in names]


CLOUD = cloud(1)
FLOOR = (Plane("floor", "y", 0.0, "above"), Plane("left", "x", 0.0, "above"), Plane("lid", "y", 3.2, "below"))
