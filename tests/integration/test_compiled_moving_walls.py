# SPDX-License-Identifier: GPL-2.0-or-later
"""Walls that move, with the plugin's fix, against the native engine: places, spin, forces, power, lids."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from lammps_jump.dump.side_files.poses import PoseFile
from lammps_jump.engines.lammps.loader import load_lammps
from lammps_jump.engines.launch import write_script
from lammps_jump.engines.native.simulation import NativeSimulation
from lammps_jump.files import POSES
from lammps_jump.physics.contact import WallLaw
from lammps_jump.scene import Block, Box, Motion, MovingWall, Sizes, handmade_scene
from lammps_jump.scene.tracks import Loaded, Oscillate, Rotate, TableMotion, Translate

D = 0.2
STEPS = 1000
PLACES = np.array([[x, y] for x in np.arange(-1, 1.1, 0.25) for y in (0.5, 0.75, 1.0)])
PLACES = PLACES + np.random.default_rng(1).normal(0, 0.01, PLACES.shape) - [0.0, 0.02]
BOX = Box("box", (-1.3, 1.3), (0.2, 2.0))
BLOCK = Block("block", (-0.4, 0.3), (-0.2, 0.35))
OWN = {"block": WallLaw(4e6, 300.0, 900.0, 0.8)}

pytestmark = pytest.mark.lammps


def scene_of(*walls, **others):
    settings = {
        "skin": 0.06,
        "friction": 0.3,
        "rotation": True,
        "impact_speed": 8.0,
        "domain": ((-5.0, 5.0), (-5.0, 5.0)),
    }
    settings |= {"probe_steps": 100, "steps": STEPS, "output_steps": STEPS, "probes": tuple(w.name for w, _ in walls)}
    found = handmade_scene(PLACES, 0 * PLACES, (), **(settings | others))
    moving = (
        MovingWall(wall, Motion(kind=kind, about=(0.1, 0.2), ease=0.01, time_step=found.time_step))
        for wall, kind in walls
    )
    return replace(found, walls=tuple(moving))


KINDS = {
    "translate": Translate(velocity=(0.4, 1.0), until=0.05),
    "rotate": Rotate(rate=200.0),
    "oscillate": Oscillate(amplitude=(0.1, 0.2), period=0.3, angle=20.0, phase=30.0),
    "each its own": Oscillate(amplitude=(0.1, 0.2), period=(0.3, 0.2, 0.5), angle=20.0, phase=(30.0, 0.0, -40.0)),
    "table": TableMotion(points=((0.02, 0.0, 0.1, 0.0), (0.05, 0.05, 0.2, 30.0))),
    "load": Loaded(mass=300.0, force=(0.0, 60000.0), axis="both", begin=0.01),
}
CASES = {
    **{name: scene_of((BOX, None), (BLOCK, kind)) for name, kind in KINDS.items()},
    "box": scene_of((BOX, Oscillate(amplitude=(0.1, 0.2), period=0.2))),
    "own law": replace(scene_of((BOX, None), (BLOCK, KINDS["rotate"])), own_laws=OWN),
    "a rough wall alone": replace(scene_of((BOX, None), (BLOCK, KINDS["oscillate"]), friction=0.0), own_laws=OWN),
    "sizes": scene_of((BOX, None), (BLOCK, KINDS["rotate"]), sizes=Sizes((1.0,), (0.16,), (0.24,), 1)),
    "sign": scene_of((BOX, None), (BLOCK, KINDS["oscillate"]), friction_law="sign"),
}


@pytest.mark.parametrize("name", CASES)
def test_native_and_plugin_agree(name, plugin, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    scene = CASES[name]
    native = NativeSimulation(scene)
    native.run(STEPS)
    assert any(row[3] for row in native.forces if row[1] != "box") or name == "box"
    engine = load_lammps().lammps(cmdargs=["-log", "none", "-screen", "none", "-nocite", "-var", "plugin", str(plugin)])
    try:
        write_script(scene, tmp_path, kernel="compiled")
        text = (tmp_path / "in.plugin.lammps").read_text().replace("discs.data", str(tmp_path / "discs.data"))
        lines = text.replace("&\n", " ").splitlines()
        written = ("dump", "fix             write_", "thermo", "file ")
        for line in lines:
            if not line.lstrip().startswith(written):
                engine.command(line)
        n = engine.extract_global("nlocal")
        order = np.argsort(np.array(engine.numpy.extract_atom("id")[:n]))
        places = np.array(engine.numpy.extract_atom("x")[:n, :2])[order]
        spin = np.array(engine.numpy.extract_atom("omega")[:n, 2])[order]
        # 1e-9 d over 1,000 steps with contacts is what engines agree to
        assert np.abs(places - native.positions).max() < 1e-9 * D
        assert np.abs(spin - native.spin).max() < 1e-6
        for index, wall in enumerate(scene.probes):
            (last,) = (row for row in native.forces[-len(scene.probes) :] if row[1] == wall)
            found = [engine.extract_fix("motion", 0, 1, 4 * index + column) for column in range(4)]
            assert found == pytest.approx(last[2:], rel=1e-7, abs=1e-6 * max(map(abs, last[2:])))
        if name == "load":
            place = PoseFile(tmp_path / POSES, scene.lids).at(scene.time(STEPS))["block"]
            assert place == pytest.approx(native.walls.poses()["block"], abs=1e-10)
            assert abs(place.y) > 0.01
    finally:
        engine.close()
