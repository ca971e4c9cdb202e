# SPDX-License-Identifier: GPL-2.0-or-later
"""The wall of docs/extending.md, which the program does not know: case file, engines, kernels, bed and picture."""

import re
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import numpy as np
import pytest
import yaml
from made_up import plugin_or_skip
from pydantic import Field, TypeAdapter, ValidationError

from lammps_jump.analysis.draw.painter import PAPER, SOLID, View, blank, paint_walls
from lammps_jump.analysis.flow import from_scene
from lammps_jump.case.fields import WallField
from lammps_jump.engines.launch import write_script
from lammps_jump.engines.native import NativeSimulation
from lammps_jump.scene import walls
from lammps_jump.scene.motion import Motion, MovingWall
from lammps_jump.scene.scene import handmade_scene
from lammps_jump.scene.tracks import Rotate
from lammps_jump.scene.walls import Block, Line, Plane

PAGE = (Path(__file__).parents[2] / "docs" / "extending.md").read_text()
BLOCK = re.search(r"```python\n(@dataclass\(frozen=True\)\nclass Mound.*?)```", PAGE, re.DOTALL).group(1)
NAMES = {name: getattr(walls, name) for name in dir(walls)}
exec(BLOCK.replace('"mound"', '"tried_mound"'), NAMES)  # a person may have put it into the program
Mound = NAMES["Mound"]
MOUND = Mound("mound", 0.0, 0.0, 1.0)
FLOOR = Plane("floor", "y", 0.0, "above")
STEPS = 600


def shower(**more):
    """Discs that fall on the mound and on the floor beside it."""
    x, y = np.meshgrid(np.arange(-1.5, 1.6, 0.3), np.arange(1.25, 2.0, 0.3))
    positions = np.column_stack([x.ravel(), y.ravel()])
    settings = {"probes": ("mound",), "probe_steps": STEPS, "output_steps": STEPS, "steps": STEPS, "skin": 0.06}
    return handmade_scene(
        positions, np.tile([0.5, -4.0], (len(positions), 1)), (FLOOR, MOUND), domain=((-9, 9), (-9, 9)),
        friction=0.2, rotation=True, **(settings | more),
    )  # fmt: skip


OWN = ["kind", "name", "friction", "restitution", "stiffness", "rolling", "motion"]
"""Fields that every wall has."""


def test_a_case_file_may_name_it():
    kinds = TypeAdapter(Annotated[WallField | Mound, Field(discriminator="kind")])
    data = yaml.safe_load("{kind: tried_mound, name: mound, x: 0, y: 0, radius: 100 cm}")
    assert kinds.validate_python(data) == MOUND
    assert kinds.dump_python(MOUND, exclude_none=True) == data | {"radius": 1.0}
    schema = kinds.json_schema()["$defs"]["Mound"]
    assert list(schema["properties"]) == [*OWN[:2], "x", "y", "radius", *OWN[2:]]
    assert schema["required"] == ["kind", "name", "x", "y", "radius"]
    for wrong in ({"radius": -1}, {"colour": "red"}, {"name": "not a name"}):
        with pytest.raises(ValidationError):
            kinds.validate_python(data | wrong)


def test_the_force_that_the_native_engine_records_changes_the_momentum():
    scene = shower(gravity=(0.0, 0.0))
    simulation = NativeSimulation(replace(scene, walls=(MovingWall(MOUND),)))
    simulation.run(STEPS)
    assert (np.hypot(*simulation.positions.T) > 1.0).all()
    ((_, name, fx, fy, _),) = simulation.forces
    change = scene.mass * (simulation.velocities - scene.velocities).sum(axis=0)
    assert name == "mound" and change[1] > 0
    end = np.array([simulation.discs.fx.sum(), simulation.discs.fy.sum()])  # half of it is still to come
    given = np.array([fx, fy]) * STEPS * scene.time_step
    assert given == pytest.approx(-change - 0.5 * scene.time_step * end, rel=1e-9)


@pytest.mark.lammps
@pytest.mark.parametrize("kernel", ["compiled"])
def test_the_plugin_agrees_with_the_native_engine(kernel, tmp_path, monkeypatch):
    from lammps_jump.engines.lammps.drive import plugin_arguments
    from lammps_jump.engines.lammps.loader import load_lammps

    scene = shower()
    simulation = NativeSimulation(scene)
    simulation.run(STEPS)
    monkeypatch.chdir(tmp_path)
    plugin = plugin_or_skip() if kernel == "compiled" else None
    text = write_script(scene, tmp_path, kernel=kernel).read_text()
    lammps = load_lammps().lammps(cmdargs=["-log", "none", "-screen", "none", *plugin_arguments(plugin)])
    try:
        lammps.commands_string(text)
        order = np.argsort(lammps.numpy.extract_atom("id")[: len(scene.positions)])
        positions = lammps.numpy.extract_atom("x")[order, :2]
        force = [lammps.extract_variable(f"{label}_mound") for label in ("fx", "fy", "mz")]
    finally:
        lammps.close()
    assert np.abs(positions - simulation.positions).max() < 1e-9 * scene.diameter
    (_, _, *expected) = simulation.forces[0]
    assert force == pytest.approx(expected, rel=1e-6)


def test_the_bed_follows_its_arc():
    x = np.linspace(-1.4, 1.4, 57) + 0.003
    flow = from_scene(shower())
    np.testing.assert_allclose(flow.bed_height(x), np.sqrt(np.maximum(1.0 - x**2, 0.0)), atol=1e-14)
    assert flow.mean_bed(np.array([-1.5, -1.2])) == 0.0
    edges = np.linspace(-0.5, 0.5, 11)
    area = 0.5 * (edges * np.sqrt(1 - edges**2) + np.arcsin(edges))
    # two Gauss points a bin: exact to the third power, off by width^4 |f| / 4320 with f < 13 here
    np.testing.assert_allclose(flow.mean_bed(edges), np.diff(area) / 0.1, atol=0.1**4 * 13 / 4320)


def test_it_is_painted_solid():
    view = View((-2.0, 2.0), (-0.5, 1.5), 400, 200)
    picture = blank(view)
    paint_walls(picture, view, (MOUND,))
    colour = {place: picture[int(view.row(place[1])), int(view.column(place[0]))] for place in ((0, 0.5), (1.5, 0.5))}
    assert (colour[0, 0.5] == SOLID).all() and (colour[1.5, 0.5] == PAPER).all()


def test_an_open_line_is_painted_behind_and_a_sheet_on_both_sides():
    view = View((-2.0, 2.0), (-1.0, 1.0), 400, 200)
    picture = blank(view)
    bed = Line("bed", points=((-1.5, 0.5), (-0.5, 0.0), (1.5, 0.0)))
    paint_walls(picture, view, (bed, Line("leaf", points=((-1.8, -0.5), (-1.8, 0.5)), sheet=True)))
    painted = (picture != PAPER).any(axis=2)

    def there(x, y):
        return bool(painted[int(view.row(y)), int(view.column(x))])

    assert there(0.5, -0.03) and not there(0.5, 0.03) and not there(0.5, -0.1)
    assert there(-1.0, 0.22) and not there(-1.0, 0.29)
    assert there(-1.815, 0.0) and there(-1.785, 0.0)


def test_a_wall_that_moves_is_painted_where_it_is_in_a_film_and_in_figures():
    turning = Motion(kind=Rotate(rate=90.0, ease=0.0), about=(0.0, 0.0), time_step=0.01)
    flow = from_scene(
        handmade_scene([(5.0, 5.0)], [(0.0, 0.0)], (MovingWall(Block("arm", (0, 2), (-0.1, 0.1)), turning),))
    )
    flow = replace(flow, scene=replace(flow.scene, coefficients=replace(flow.scene.coefficients, time_step=0.01)))
    (arm,) = flow.standing_at(1.0)
    view = View((-2.0, 2.0), (-1.0, 2.0), 400, 300)
    picture = blank(view)
    paint_walls(picture, view, (arm,))
    solid = (picture != PAPER).any(axis=2)
    assert solid[int(view.row(1.5)), int(view.column(0.0))] and not solid[int(view.row(0.0)), int(view.column(1.5))]
    assert flow.shut_gates(1.0) == () and flow.walls_at(0.0)[0].distance(1.0, 0.0) == pytest.approx(-0.1)


def test_it_sets_the_moment_point_and_extent():
    assert MOUND.extent[0] == pytest.approx((-1.0, 1.0)) and MOUND.extent[1][0] == 0.0
    assert MOUND.moment_point == pytest.approx((-1.0, 0.0))
    assert MOUND.finite and MOUND.room("x") == (-np.inf, np.inf)
