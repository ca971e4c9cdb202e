# SPDX-License-Identifier: GPL-2.0-or-later
"""Inlets that wait for a step of the raster, or for a gate: the discs at the start feel nothing of the second run."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_up import plugin_or_skip

from lammps_jump.engines.lammps.drive import plugin_arguments
from lammps_jump.engines.lammps.loader import load_lammps
from lammps_jump.engines.launch import write_script
from lammps_jump.scene import InletRow, Plane, Sizes, gate, handmade_scene

pytestmark = pytest.mark.lammps

STEPS, FIRST = 400, 120
ROW = InletRow(60.0, 60.0, 50.0, 0.0, FIRST, 120, 0.24)


def heap(sizes: Sizes | None):
    """Forty discs that fall on a floor and rub on each other, with an inlet far away."""
    random = np.random.default_rng(1)
    i, j = np.meshgrid(np.arange(8), np.arange(5))
    positions = np.column_stack([i.ravel(), j.ravel()]) * 0.245 + (0.2, 0.13)
    return handmade_scene(
        positions, random.uniform(-2, 2, positions.shape), (Plane("floor", "y", 0.0, "above"),),
        sizes=sizes, friction=0.3, rotation=True, inlets=(ROW,), steps=STEPS, output_steps=100, size_steps=8,
        skin=0.05, time_step_fraction=0.1,
    )  # fmt: skip


def end(scene, folder, kernel):
    """Positions, velocities and spin at the end of the generated script, of the discs that were there at the start."""
    plugin = plugin_or_skip() if kernel == "compiled" else None
    folder.mkdir()
    path = write_script(scene, folder, kernel=kernel)
    commands = path.read_text()
    for name in ("discs.data", "disk.mol", "scene.image", "dump.lammpstrj"):
        commands = commands.replace(name, str(folder / name))
    lmp = load_lammps().lammps(cmdargs=["-log", "none", "-screen", "none", *plugin_arguments(plugin)])
    try:
        lmp.commands_string(commands)
        n = lmp.get_natoms()
        order = np.argsort(lmp.numpy.extract_atom("id")[:n])[: len(scene.positions)]
        arrays = (lmp.numpy.extract_atom(name)[:n][order] for name in ("x", "v", "omega"))
        return n, np.concatenate([array.ravel() for array in arrays])
    finally:
        lmp.close()


@pytest.mark.parametrize("gated", [False, True], ids=["raster", "gate"])
@pytest.mark.parametrize("sizes", [None, Sizes((1.0,), (0.16,), (0.24,))], ids=["equal", "sizes"])
@pytest.mark.parametrize("kernel", ["stock", "compiled"])
def test_the_second_run_changes_nothing(kernel, sizes, gated, tmp_path):
    scene = heap(sizes)
    if gated:
        shut = gate(Plane("gate", "x", 2.05, "below"), FIRST - 1)
        scene = replace(scene, walls=(*scene.walls, shut), settle_steps=FIRST - 1)
    alone, apart = end(replace(scene, inlets=()), tmp_path / "alone", kernel), end(scene, tmp_path / "two", kernel)
    assert (alone[0], apart[0]) == (40, 43)
    assert np.abs(apart[1] - alone[1]).max() < 1e-9  # m, m/s, rad/s; 5e-3 and more without the half step
