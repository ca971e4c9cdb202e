# SPDX-License-Identifier: GPL-2.0-or-later
"""Discs of several sizes in the plugin: closed forms, the stock styles, ranks; whole scripts as they are written."""

from __future__ import annotations

import platform
import shlex
import subprocess
from dataclasses import replace

import numpy as np
import pytest

from lammps_jump.compiling.compiler import find_compiler
from lammps_jump.engines.child import close_idle
from lammps_jump.engines.lammps.drive import plugin_arguments
from lammps_jump.engines.lammps.loader import load_lammps, program
from lammps_jump.engines.launch import write_script
from lammps_jump.engines.native import NativeSimulation
from lammps_jump.engines.plugin import plugin_path
from lammps_jump.errors import SetupError
from lammps_jump.physics import contact, law
from lammps_jump.physics.slip import SIGN_RAMP
from lammps_jump.scene.build import handmade_scene
from lammps_jump.scene.motion import MovingWall
from lammps_jump.scene.scene import InletRow, Outlet, Pour, Scene
from lammps_jump.scene.sizes import Sizes
from lammps_jump.scene.walls import Block, Box, Plane
from lammps_jump.studies.runs import run_frames

pytestmark = pytest.mark.lammps

DIAMETER = 0.2
EQUAL = 1e-9  # diameters after 1000 steps
UNIFORM = Sizes((1.0,), (0.16,), (0.24,))
THREE = Sizes((0.5, 0.3, 0.2), (0.16, 0.2, 0.22), (0.16, 0.22, 0.24), seed=5)


def scene(positions, velocities, walls, *, fraction=0.05, **more):
    """A scene of unequal discs with the coefficients of the hydraulic jump."""
    settings = {"steps": 1000, "output_steps": 1000, "skin": 0.06, "overlap_limit": DIAMETER, "sizes": UNIFORM}
    return handmade_scene(
        positions, velocities, walls, time_step_fraction=fraction, correct_restitution=True,
        domain=((-3.0, 9.0), (-4.0, 9.0)), **{**settings, **more},
    )  # fmt: skip


def cloud(seed, nx=10, ny=10, speed=3.0):
    """Discs near a lattice with random velocities, so that many collide within 1000 steps."""
    generator = np.random.default_rng(seed)
    grid = np.array([(0.3 + 0.25 * i, 0.3 + 0.25 * j) for i in range(nx) for j in range(ny)])
    return grid + generator.normal(0, 0.002, grid.shape), generator.normal(0, speed, grid.shape)


def pair(ratio: float, speed: float, gap: float, **more) -> Scene:
    """Two discs whose masses have this ratio, head-on; id 1 has the small size, id 2 the large one."""
    large = DIAMETER * ratio**0.5
    sizes = Sizes((0.5, 0.5), (DIAMETER, large), (DIAMETER, large), seed=1)
    assert sizes.diameters([1, 2]).tolist() == [DIAMETER, large]
    at = [[0.0, 0.0], [0.5 * (DIAMETER + large) + gap, 0.0]]
    return scene(at, [[0.5 * speed, 0.0], [-0.5 * speed, 0.0]], (), sizes=sizes, gravity=(0.0, 0.0), **more)


@pytest.fixture
def run(plugin, tmp_path, monkeypatch):
    """Runs the script of a scene; returns arrays of the discs at the end, in the order of their ids."""
    try:
        lammps = load_lammps().lammps
    except SetupError as error:
        pytest.skip(str(error))
    monkeypatch.chdir(tmp_path)

    def do(case: Scene, kernel: str = "compiled", more: tuple[str, ...] = ()) -> dict[str, np.ndarray]:
        script = write_script(case, tmp_path, kernel=kernel)
        engine = lammps(cmdargs=["-log", "none", "-screen", "none", "-nocite", *plugin_arguments(plugin)])
        try:
            engine.file(script.name)
            for line in more:
                engine.command(line)
            n = engine.extract_global("nlocal")
            order = np.argsort(engine.numpy.extract_atom("id")[:n])
            names = ("id", "x", "v", "f", "omega", "torque", "radius", "rmass")
            discs = {name: np.array(engine.numpy.extract_atom(name)[:n])[order] for name in names}
            return {**discs, "overlap": engine.extract_variable("overlap")}
        finally:
            engine.close()

    return do


def apart(one, two, name="x"):
    assert np.array_equal(one["id"], two["id"])
    return np.abs(one[name] - two[name]).max()


@pytest.mark.parametrize("ratio", [1.0, 2.0, 10.0, "wall"])
def test_every_mass_ratio_has_the_restitution_of_the_closed_form(run, ratio):
    speed, found = 3.0, []
    for phase in range(15):
        case = pair(2.0 if ratio == "wall" else ratio, speed, 1.0, fraction=0.01, steps=700)
        c, gap = case.coefficients, (phase + 0.5) / 15 * speed * case.time_step
        masses = case.masses(case.diameters([1, 2]))
        at = case.positions + np.array([[0.0, 0.0], [gap - 1.0, 0.0]])
        reduced, stiffness, by_root = masses.prod() / masses.sum(), c.stiffness, c.damping_by_root_mass
        if ratio == "wall":  # the large disc, which is not the nominal one, against a plane; the small one far away
            at = np.array([[-2.0, 5.0], [0.5 * case.diameters(2) + gap, 0.0]])
            case = replace(
                case, walls=(MovingWall(Plane("wall", "x", 0.0, "above")),), velocities=[[0.0, 0.0], [-speed, 0.0]]
            )
            reduced, stiffness, by_root = masses[1], c.stiffness_wall, c.damping_by_root_mass_wall
            case = replace(case, walls=(MovingWall(Block("wall", (-1.0, 0.0), (-3.0, 3.0))),)) if phase % 2 else case
            at[0] = (1.0, 5.0)
        after = run(replace(case, positions=at, velocities=np.asarray(case.velocities)))["v"][:, 0]
        found.append((after[1] - after[0]) / speed)
    xi = by_root / (2 * stiffness**0.5)
    exact = contact.lagged_restitution(xi, (stiffness / reduced) ** 0.5 * case.time_step)
    assert 0.15 < exact < 0.25
    assert np.mean(found) == pytest.approx(exact, rel=0.005)


FLOOR = (Plane("floor", "y", 0.0, "above"), Plane("left", "x", 0.0, "above"), Plane("lid", "y", 3.2, "below"))
CORNERS = (Block("ground", (-2.5, 1.2), (-3.0, 0.1)), Block("sill", (1.2, 2.0), (-3.0, 0.25)))
CASES = {
    "pairs": dict(walls=(), gravity=(0.0, 0.0)),
    "planes": dict(walls=FLOOR),
    "planes, friction": dict(walls=FLOOR, friction=0.3),
    "planes, friction, spin": dict(walls=FLOOR, friction=0.3, rotation=True),
    "corners, friction, spin, three pieces": dict(
        walls=(*CORNERS, Box("room", (0.1, 4.0), (-2.0, 3.5))), friction=0.3, rotation=True, sizes=THREE
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_a_heap_equals_the_stock_styles(run, name):
    case = scene(*cloud(1), **CASES[name])
    expected, found = run(case, "stock"), run(case)
    assert np.abs(expected["x"][:, :2] - case.positions).max() > DIAMETER  # discs have moved and collided
    assert np.array_equal(found["radius"], expected["radius"]) and np.array_equal(found["rmass"], expected["rmass"])
    assert apart(found, expected) < EQUAL * DIAMETER
    assert apart(found, expected, "v") < 1e-8  # m/s, of speeds of 10 m/s: velocities are a digit worse
    if case.rotation:
        assert np.abs(expected["omega"]).max() > 1
        assert apart(found, expected, "omega") < 1e-7  # rad/s, of 20 rad/s


def jet(**more) -> Scene:
    """Rows of a jet that meet a cloud on a short floor behind a sill; discs fall off its end."""
    rows = tuple(InletRow(-0.5, 0.25 + 0.25 * i, 12.0, 0.0, 10, 150 - 10 * i, 0.999 * 0.24) for i in range(4))
    walls = (Block("floor", (-2.5, 1.6), (-3.0, 0.0)), Block("sill", (1.0, 1.6), (-3.0, 0.4)))
    places, speeds = cloud(4, 6, 6)
    outside = places[:, 1] > 0.4 + 0.12  # a centre in a block is pushed out of it; LAMMPS has no force there
    outside |= places[:, 0] < 1.0 - 0.12
    return scene(
        places[outside], speeds[outside], walls, inlets=rows, outlets=(Outlet("y", 0.15, "below", 50),), size_steps=10,
        **{"sizes": THREE, **more},
    )  # fmt: skip


@pytest.mark.parametrize("rubbing", [{}, {"friction": 0.2}, {"friction": 0.2, "rotation": True}])
def test_a_jet_with_inflow_and_outflow_equals_the_stock_styles(run, rubbing):
    case = jet(**rubbing)
    expected, found = run(case, "stock"), run(case)
    ids = found["id"]
    assert ids.max() > 45 and len(ids) < ids.max()  # discs have come and gone
    assert apart(found, expected) < EQUAL * DIAMETER
    settled = ids < ids.max() - 4  # the last ones may have the inserted size
    assert np.array_equal(found["radius"], expected["radius"])
    # the bits of the functions in Python decide which piece a disc belongs to
    assert np.array_equal(2 * found["radius"][settled], case.diameters(ids[settled]))
    assert found["rmass"][settled] == pytest.approx(case.masses(case.diameters(ids[settled])), rel=1e-15)


@pytest.mark.long
@pytest.mark.skipif(platform.machine() != "x86_64", reason="AVX is of x86-64")
@pytest.mark.parametrize("more", [{"friction": 0.2, "rotation": True}, {"sizes": None}], ids=["sizes, spin", "equal"])
def test_the_width_of_vectors_changes_no_bit(plugin, monkeypatch, request, more):
    """Without AVX there are two numbers in a vector, and pairs are checked one at a time."""
    case = jet(output_steps=250, **more)
    ours = run_frames(case, "compiled", dump_format="binary")[1]
    monkeypatch.setenv("CXX", f"{shlex.join(find_compiler())} -mno-avx")
    assert plugin_path() != plugin
    close_idle()  # a process keeps the styles that it has loaded
    request.addfinalizer(close_idle)
    narrow = run_frames(case, "compiled", dump_format="binary")[1]
    assert len(ours) == len(narrow) == 5
    for one, two in zip(ours, narrow, strict=True):
        assert np.array_equal([*one.columns.values()], [*two.columns.values()])


@pytest.mark.parametrize("rubbing", [{}, {"friction": 0.2, "rotation": True}])
def test_a_pour_equals_the_stock_styles(run, rubbing):
    """LAMMPS drops the discs in both; its gravity fix holds the weight, so that no velocity is corrected."""
    room, pour = Box("room", (0.0, 2.0), (0.0, 6.0)), Pour((0.2, 1.8), (0.3, 1.5), 40, 0.5, 4.0)
    case = scene(np.zeros((0, 2)), np.zeros((0, 2)), (room,), pours=(pour,), size_steps=100, steps=4000, **rubbing)
    expected, found = run(case, "stock"), run(case)
    assert np.array_equal(2 * found["radius"], case.diameters(found["id"])) and len(found["id"]) > 10
    assert found["f"][:, :2].max() > 100 * case.mass  # discs have landed on each other
    assert apart(found, expected) < EQUAL * DIAMETER


def test_an_inserted_disc_falls_with_the_gravity_of_its_inserted_mass(run):
    """LAMMPS' `fix set` acts on the mass only: the forces of the step, gravity too, are those of the template."""
    row = InletRow(0.0, 2.0, 1.0, 0.0, 10, 10_000, 0.1, limit=1)
    case = scene(np.zeros((0, 2)), np.zeros((0, 2)), (), inlets=(row,), size_steps=10, steps=11)
    found = run(case)
    dt, (d,) = case.time_step, case.diameters([1])
    assert 2 * found["radius"][0] == d < case.largest
    # half a kick ends the step of the insertion, its forces make half a kick of the next step, own gravity the other
    kick = 0.5 * dt * 9.81
    assert found["v"][0, 1] == pytest.approx(-kick * (1 + (case.largest / d) ** 2 + 1), rel=1e-12)
    assert run(case, "stock")["v"][0, 1] == pytest.approx(found["v"][0, 1], rel=1e-12)


NATIVE = {
    "sign": dict(friction=0.2, friction_law="sign"),
    "sign, spin": dict(friction=0.05, friction_law="sign", rotation=True),  # see test_compiled_kernel
    "sign, smooth touch": dict(friction=0.2, friction_law="sign", touch="smooth", touch_width=0.003),
    "viscous, spin, smooth touch": dict(friction=0.2, rotation=True, touch="smooth", touch_width=0.003),
}


SHORT_RUN = ("sign, spin", "viscous, spin, smooth touch")
"""Every branch once; `test_compiled_kernel` has every law with equal discs."""


@pytest.mark.parametrize(
    "name", [name if name in SHORT_RUN else pytest.param(name, marks=pytest.mark.long) for name in NATIVE]
)
def test_laws_that_stock_styles_lack_equal_the_native_engine(run, name):
    case = jet(**NATIVE[name])
    native = NativeSimulation(case)
    native.run(1000)
    order, found = np.argsort(native.ids), run(case)
    assert np.array_equal(native.ids[order], found["id"])
    assert np.abs(native.positions[order] - found["x"][:, :2]).max() < EQUAL * DIAMETER


@pytest.mark.parametrize("touch", [{}, {"touch": "smooth", "touch_width": 0.01}], ids=["sharp", "smooth"])
@pytest.mark.parametrize("friction_law", ["viscous", "sign"])
def test_the_law_of_unequal_discs_is_the_packages(run, touch, friction_law):
    """Forces and torques of two discs over a grid of overlaps and speeds against `lammps_jump.physics.law`."""
    width = touch.get("touch_width")
    for depth in (1e-6, 0.004, 0.0101):
        for vx, vy in ((0.0, 0.0), (2.0, 0.01), (-3.0, -4.0), (0.3, 1e-4)):
            case = pair(3.0, 0.0, -depth, friction=0.3, friction_law=friction_law, rotation=True, steps=0, **touch)
            case = replace(case, velocities=np.array([[0.0, 0.0], [vx, vy]]))
            found, c = run(case), case.coefficients
            radii, masses = 0.5 * case.diameters([1, 2]), case.masses(case.diameters([1, 2]))
            overlap = radii.sum() - case.positions[1, 0]
            damping = c.damping_by_root_mass * (masses.prod() / masses.sum()) ** 0.5
            slope = 1 / (SIGN_RAMP * np.hypot(vx, vy)) if vx else 1e300
            normal, _ = law.normal_force(overlap, vx, c.stiffness, damping, width)
            slope = slope if friction_law == "sign" else None
            slip = law.friction_force(normal, vy, c.friction, c.tangential_ratio * damping, slope)
            scale = 1e-9 * c.stiffness * overlap
            assert found["f"][1, :2] == pytest.approx([normal, slip], rel=1e-10, abs=scale)
            assert found["f"][0, :2] == pytest.approx(-found["f"][1, :2], rel=1e-14)
            # the contact point is in the middle of the overlap
            assert found["torque"][:, 2] == pytest.approx(-(radii - 0.5 * overlap) * slip, rel=1e-9, abs=scale)
            assert found["overlap"] == pytest.approx(overlap, rel=1e-9)


def test_the_script_says_sizes_only_where_there_are_some(tmp_path):
    equal, graded = (write_script(case, tmp_path, kernel="compiled").read_text() for case in (jet(sizes=None), jet()))
    assert "sizes" not in equal and "v_diameter" not in equal
    assert f" sizes {jet().most_discs} 1000" in graded
    assert "fix             size" not in graded  # at all discs it would cost a third of the run


def test_a_disc_of_another_size_or_mass_is_refused(run):
    case = scene([[0.0, 1.0]], [[0.0, 0.0]], (), steps=1)
    for change in ("diameter 0.25", "mass 1"):
        with pytest.raises(Exception, match=r"disc 1 has diameter .* the scene says up to 0.24"):
            run(case, more=(f"set atom 1 {change}", "run 1"))


@pytest.mark.long  # test_ranks.py has two ranks in the default run
def test_two_ranks_equal_one(plugin, tmp_path):
    mpiexec, lmp = program("mpiexec"), program("lmp")
    if mpiexec is None or lmp is None:
        pytest.skip("the wheels bring no mpiexec or lmp")
    case = replace(jet(friction=0.2, rotation=True), domain=((-1.0, 3.0), (-4.0, 9.0)))
    frames = []
    for ranks in (1, 2):
        folder = tmp_path / str(ranks)
        script = write_script(case, folder, kernel="compiled", ranks=ranks)
        balance = "fix             balance all balance 1000 1.01 shift x 10 1.005"
        text = script.read_text().replace(balance, balance.replace("1000", "100"))
        columns = "id x y vx vy radius modify sort id format float %.17g"
        script.write_text(f"{text}write_dump      all custom end {columns}\n")
        command = [str(mpiexec), "-n", str(ranks), str(lmp), "-in", script.name, "-screen", "none"]
        command += plugin_arguments(plugin)
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=300)
        assert done.returncode == 0, done.stdout + done.stderr
        frames.append(np.loadtxt(folder / "end", skiprows=9))
    one, two = frames
    assert np.array_equal(one[:, [0, 5]], two[:, [0, 5]])
    assert np.abs(one[:, 1:3] - two[:, 1:3]).max() < EQUAL * DIAMETER
