# SPDX-License-Identifier: GPL-2.0-or-later
"""Bodies of a case: what is read, derived and refused, and a run with them from file to numbers."""

import json
import re
from dataclasses import replace
from math import pi, radians, sqrt

import numpy as np
import pytest
import yaml

from lammps_jump.case import load_case
from lammps_jump.case.bodies import foreseen_blow, tips_at
from lammps_jump.dump.walls import read_bodies
from lammps_jump.engines.checkpoint import read_checkpoint
from lammps_jump.engines.choice import choose
from lammps_jump.engines.native import NativeSimulation, run_native
from lammps_jump.errors import CaseError, DumpError, RunError, SetupError
from lammps_jump.scene.meeting import corners, stiffness_between
from lammps_jump.scene.motion import STILL, Pose, WallState
from lammps_jump.script.stock import lacking

CASE = """
name: structures
discs: {diameter: 0.2, density: 1000}
contact: {restitution: 0.2, friction: 0.1, largest_overlap: 0.1, impact_speed: 10}
domain: {x: [-1, 30], y: [-1, 12]}
walls:
  - {name: floor, kind: plane, axis: y, at: 0, side: above}
bodies:
  - {name: caisson, kind: block, x: [20, 24], y: [0, 5], density: 2400, friction: 0.5}
  - {name: boulder, kind: polygon, points: [[3, 8], [4, 8.2], [3.6, 9]], density: 2600, velocity: [1, 0], spin: 90}
  - {name: buoy, kind: circle, centre: [9, 3], radius: 0.6, mass: 300, inertia: 60 kg*m^2/m}
  - {name: flap, kind: block, x: [12, 12.2], y: [0.1, 4], density: 800, hinge: [12.1, 4], from: 0.1 s}
initial:
  - {kind: list, positions: [[1, 1], [12.4, 1]]}
run: {duration: 0.2, output_interval: 0.02}
probes: {forces: [flap], interval: 0.01}
engine: {name: native}
"""


@pytest.fixture
def case(tmp_path):
    file = tmp_path / "structures.yaml"
    file.write_text(CASE)
    return load_case(file)


def test_what_follows_from_a_body(case):
    caisson, boulder, buoy, flap = (one.motion.free for one in case.scene().bodies)
    assert (caisson.mass, *caisson.centre) == pytest.approx((48_000.0, 22.0, 2.5), rel=1e-12)
    assert caisson.inertia == pytest.approx(48_000 * (4**2 + 5**2) / 12)
    assert caisson.weight == pytest.approx((0.0, -48_000 * 9.81))
    assert boulder.mass == pytest.approx(2600 * 0.5 * (1.0 * 1.0 - 0.2 * 0.6)) and boulder.spin == pytest.approx(
        radians(90)
    )
    assert (buoy.mass, buoy.inertia) == (300.0, 60.0)
    assert flap.point == (12.1, 4.0) and flap.freedom == (False, False, True) and flap.begin == 0.1
    assert flap.inertia_there == pytest.approx(flap.inertia + flap.mass * 1.95**2)
    assert caisson.corner_radius == pytest.approx(0.05)
    even = case.replace(["bodies.buoy={name: buoy, kind: circle, centre: [9, 3], radius: 0.6, mass: 300}"]).scene()
    assert even.bodies[2].motion.free.inertia == pytest.approx(300 * 0.6**2 / 2)
    tilted = case.replace({"slope": 30}).scene().bodies[0].motion.free
    assert tilted.weight == pytest.approx((48_000 * 9.81 / 2, -48_000 * 9.81 * 3**0.5 / 2))
    assert even.wall_law("caisson").friction == 0.5
    assert pi * 0.6**2 > 1  # the circle is larger than a square metre: density would give it another mass


def test_a_case_with_bodies_is_written_and_read_again_and_one_without_keeps_its_hash(case):
    again = load_case(yaml.safe_load(case.to_yaml()))
    assert again.fields == case.fields and again.hash == case.hash
    without = case.replace({"bodies": [], "probes.forces": []})
    assert "\nbodies:" not in without.to_yaml() and without.hash != case.hash


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ("bodies.0.density=null", r"structures.yaml:9: bodies\[0\]: needs density \(kg/m\^3\) or mass"),
        ("bodies.0.mass=5", r"bodies\[0\]: needs density .* one of the two"),
        ("bodies.0.inertia=5", "inertia: goes with mass"),
        ("bodies.0.free=[]", r"bodies\[0\].free: is empty, so that the body never moves"),
        ("bodies.1.free=[y, turn]", "is without x, and the body has a speed there"),
        ("bodies.3.velocity=[1, 0]", "hinge: the body turns about it only; drop velocity"),
        ("bodies.0.name=floor", "two walls or bodies are called 'floor'"),
        ("bodies.0.kind=plane", "'plane' is not known; allowed is 'block', 'polygon', 'circle'"),
        (
            "bodies.1.points=[[0, 0], [1, 1], [0, 1], [1, 0]]",
            r"bodies\[1\].points\[3\]: the wall meets itself at \(0.5, 0.5\) m",
        ),
        ("bodies.1.points=[[0, 0], [1, 0]]", r"bodies\[1\].points: .* at least 3"),
        ("bodies.0.colour=red", r"bodies\[0\].colour: unknown field"),
        ("initial.0.positions=[[22, 1]]", r"yaml:9: bodies\[0\]: disc 1 at \(22, 1\) starts .* deep in wall 'caisson'"),
        (
            "bodies.0.rolling=0.1",
            r"bodies\[0\].rolling: wall 'caisson' has rolling friction, but contact.rolling is null",
        ),
        ("domain.periodic=x", "bodies: is not there with domain.periodic: x"),
        (
            "bodies.0.y=[-0.1, 5]",
            r"bodies\[0\]: body 'caisson' lies 0.1 m deep in wall 'floor' .* allowed is d/n = 0.02 m",
        ),
        ("bodies.2.centre=[21, 3]", r"bodies\[\d\]: body '(caisson|buoy)' lies .* deep in body '(caisson|buoy)'"),
        ("walls=[{name: rod, kind: block, x: [22, 22.1], y: [1, 2]}]", "body 'caisson' lies .* deep in wall 'rod'"),
        (
            "bodies.3.density=5",
            r"bodies\[3\]: body 'flap' of 3.9 kg/m is lighter .* allowed is .* or more at run.time_step_fraction",
        ),
        ("probes.forces=[flop]", "there is no wall 'flop'"),
        # of 4 m x 5 m, of a thin flap, and of a triangle with sides of 1 m
        (
            "bodies.0.corner_radius=2.01",
            r"yaml:9: bodies\[0\]: corner_radius: 2.01 m rounds more .* allowed is up to 2 m",
        ),
        ("bodies.3.corner_radius=0.11", r"bodies\[3\]: corner_radius: 0.11 m .* allowed is up to 0.1 m"),
        (
            "bodies.1={name: tip, kind: polygon, points: [[3, 8], [4, 8], [3.5, 8.8660254]], density: 900, "
            "corner_radius: 0.3}",
            r"bodies\[1\]: corner_radius: 0.3 m .* allowed is up to 0.2887 m",
        ),
    ],
)
def test_a_body_that_cannot_be_is_refused_with_its_place(case, change, message):
    with pytest.raises(CaseError, match=message):
        case.replace([change]).scene()


def test_corners_are_rounded_up_to_half_of_a_side(case):
    scene = case.replace(["bodies.0.corner_radius=2", "bodies.3.corner_radius=0.1"]).scene()
    radii = [corner.radius for number, corner in corners(scene) if scene.walls[number].wall.name == "caisson"]
    assert radii == pytest.approx([2.0] * 4)


def test_what_is_doubtful_is_told(case):
    def told(*changes):
        return [note for note in case.replace(list(changes)).scene().warnings if "body" in note]

    assert told() == []
    (soft,) = told("bodies.1.stiffness=1e7")
    assert "'boulder' of 1.14e+03 kg/m may meet a wall at 12.6 m/s" in soft and "the run ends at 0.04 m" in soft
    enough = re.search(r"a stiffness of its own of ([\d.e+]+) N/m is enough", soft)[1]
    assert told(f"bodies.1.stiffness={1.02 * float(enough)}") == []
    assert told("bodies.3.hinge=[12.1, 9]") == [
        "the hinge of body 'flap' is 5 m away from it, and the body is 3.91 m large: it swings on an arm without mass, "
        "which pushes nothing"
    ]
    leaning = "bodies.0={name: caisson, kind: polygon, density: 2400, points: [[20, 0], [21, 0], [25, 5], [24, 5]]}"
    (note,) = told(leaning)
    assert note == "body 'caisson' stands with its centre of mass 1.5 m beside its support: it tips at once"
    # wide: it is not foreseen to tip
    (heavy,) = told("bodies.0.density=24000", "bodies.0.stiffness=1e7", "bodies.0.x=[20, 26]")
    assert "'caisson' of 7.2e+05 kg/m stands on its corners, with an overlap of 0.35 m" in heavy


@pytest.mark.parametrize(
    ("change", "speed"),
    [
        ("bodies.0.x=[20, 21]", sqrt(3 * 9.81 * 5)),
        ("bodies.0.x=[20, 26]", 0.0),
        ("bodies.0.x=[20, 25.1]", 0.0),
        ("bodies.0={name: caisson, kind: block, x: [20, 21], y: [0, 5], density: 2400, hinge: [20, 0]}", 0.0),
        ("bodies.0={name: caisson, kind: block, x: [20, 21], y: [0, 5], density: 2400, free: [x, y]}", 0.0),
        ("bodies.0={name: caisson, kind: circle, centre: [22, 2.5], radius: 2.5, density: 2400}", 0.0),
    ],
)
def test_the_speed_of_tipping_is_foreseen_where_a_body_is_taller_than_wide(case, change, speed):
    caisson = case.replace([change]).scene().bodies[0]
    assert tips_at(caisson.wall, caisson.motion.free) == pytest.approx(speed, abs=1e-9)


@pytest.mark.parametrize(("x", "turn", "speed"), [([20, 21], 0.5, 0.0), ([20, 25], -0.5, 12.13), ([20, 21], 1, 12.13)])
def test_a_body_of_an_earlier_run_tips_from_the_pose_it_begins_in(case, x, turn, speed):
    """A post of 1 m by 5 m that lies is not foreseen to tip; a slab that was raised is, though the case has it flat."""
    y = [0, 1] if x[1] == 25 else [0, 5]
    block = {"name": "post", "kind": "block", "x": x, "y": y, "density": 2400}
    (post,) = case.replace({"contact.impact_speed": 2, "bodies": [block], "probes": {}}).scene().bodies
    begun = post._replace(motion=replace(post.motion, went=WallState(Pose(0, 0, turn * pi), STILL)))
    energy, blow = foreseen_blow(begun, 0.0)
    free = post.motion.free
    assert tips_at(begun.first, free) == pytest.approx(speed, abs=0.01)
    if speed:
        assert blow == "tip over and meet the ground at 12.1 m/s"
        assert energy == pytest.approx(free.mass * speed**2 / 3, rel=1e-3)
    else:
        assert "meet a wall" in blow


def test_a_body_that_may_tip_onto_soft_contacts_is_told(case):
    slow = ["contact.impact_speed=2", "bodies=[{name: post, kind: block, x: [20, 21], y: [0, 5], density: 2400}]"]
    (note,) = (note for note in case.replace([*slow, "probes={}"]).scene().warnings if "body" in note)
    assert "body 'post' of 1.2e+04 kg/m may tip over and meet the ground at 12.1 m/s, with an overlap of" in note


def test_check_tells_how_stiff_bodies_are(case):
    report = case.check().walls
    assert "caisson" in report
    scene = case.scene()
    omega = scene.coefficients.omega_wall
    assert f"stiffness {stiffness_between(scene.coefficients, scene.bodies[0]):.3g} N/m with walls" in report["caisson"]
    assert stiffness_between(scene.coefficients, scene.bodies[0]) == pytest.approx(48_000 / 4 * omega**2, rel=0.05)
    own = case.replace(["bodies.0.stiffness=2e7"]).check().walls["caisson"]
    assert "stiffness 2e+07 N/m" in own and "times" not in own


def test_corners_that_are_too_stiff_for_the_step_are_refused(case):
    """A block pressed between walls, with restitution 1: its energy stays at the limit, and grows beyond it."""
    around = {
        "left": ((1, 2), (1, 4)),
        "right": ((2.4, 4), (1, 4)),
        "low": ((2, 2.4), (1, 2)),
        "high": ((2, 2.4), (2.4, 4)),
    }
    walls = [f"{{name: {name}, kind: block, x: {list(x)}, y: {list(y)}}}" for name, (x, y) in around.items()]
    changes = [
        "contact.restitution=1", "contact.friction=0", "gravity=0", "run.time_step_fraction=0.1", "probes={}",
        "initial=[{kind: list, positions: [[9, 9]]}]", f"walls=[{', '.join(walls)}]",
    ]  # fmt: skip

    def growth(stiffness, *more):
        block = f"kind: block, x: [1.995, 2.405], y: [1.995, 2.405], mass: 104, stiffness: {stiffness}"
        body = f"bodies=[{{name: core, {block}, velocity: [0.05, 0], spin: 2}}]"
        simulation = NativeSimulation(case.replace([*changes, body, *more]).scene())
        start = simulation.energy().total
        simulation.run(3000)
        return simulation.energy().total / start

    with pytest.raises(
        CaseError, match=r"'core' of 104 kg/m with 'left' has 5e\+08 N/m, too stiff .* allowed"
    ) as caught:
        growth(5e8)
    allowed = float(re.search(r"allowed is ([\d.e+]+) N/m", str(caught.value))[1])
    assert growth(0.99 * allowed) == pytest.approx(1.0, abs=1e-3)
    with pytest.raises(RunError, match="overlap"):
        growth(1.5 * allowed, "run.allow_unstable=true")


def test_a_body_of_the_least_mass_is_stable_among_discs(case):
    """Touched all round, with restitution 1 and no weight: its energy stays; with a quarter of that mass it grows."""
    ring = 2 * pi * np.arange(9) / 9
    places = [[float(9 + 0.398 * np.cos(a)), float(3 + 0.398 * np.sin(a))] for a in ring]
    changes = [
        "contact.restitution=1", "contact.friction=0", "gravity=0", "run.time_step_fraction=0.1", "probes={}",
        "walls=[{name: around, kind: circle, centre: [9, 3], radius: 0.496, discs: inside}]", "run.duration=2",
        f"initial=[{{kind: list, positions: {places}}}]", "contact.largest_overlap=0.02",
    ]  # fmt: skip

    def growth(mass):
        body = f"bodies=[{{name: core, kind: circle, centre: [9, 3], radius: 0.3, mass: {mass}, velocity: [0.3, 0]}}]"
        scene = case.replace([*changes, body]).scene()
        simulation = NativeSimulation(scene)
        start = simulation.energy().total
        simulation.run(3000)
        return simulation.energy().total / start

    with pytest.raises(CaseError, match=r"allowed is ([\d.]+) kg/m") as caught:
        growth(1e-3)
    least = float(re.search(r"allowed is ([\d.]+) kg/m", str(caught.value))[1])
    assert growth(1.01 * least) < 1.05
    changes += ["run.allow_unstable=true"]
    with pytest.raises(RunError, match="overlap"):
        growth(least / 4)


def test_stock_lammps_refuses_bodies(case):
    with pytest.raises(CaseError, match=r"bodies: are not in stock LAMMPS.*engine.name: native"):
        case.replace(["engine.name=lammps", "engine.kernel=stock"]).scene()
    scene = case.scene()
    assert lacking(scene) == "bodies (body 'caisson', field bodies)"
    with pytest.raises(SetupError, match=r"stock LAMMPS has no bodies .*compiled, or engine.name to native"):
        choose("lammps", "stock", 1, scene)


def test_a_run_tells_where_bodies_are(case, tmp_path):
    result = run_native(case.scene(), tmp_path / "run")
    assert result.status == "complete", result.message
    found = read_bodies(tmp_path / "run" / "bodies.csv")
    assert list(found) == ["caisson", "boulder", "buoy", "flap"]
    for one in found.values():
        assert one.time == pytest.approx(np.linspace(0.0, 0.2, 21), abs=1e-9)
    buoy, boulder, flap = found["buoy"], found["boulder"], found["flap"]
    assert buoy.y == pytest.approx(3.0 - 0.5 * 9.81 * buoy.time**2) and not buoy.angle.any()
    assert boulder.angle == pytest.approx(radians(90) * boulder.time) and boulder.vx == pytest.approx(1.0)
    held = flap.time <= 0.1
    assert not flap.angle[held].any()
    # the row of the centre of mass moves about the hinge
    assert np.hypot(flap.x - 12.1, flap.y - 4.0) == pytest.approx(1.95)
    assert json.dumps(result.ledger["residual"])
    (tmp_path / "bad.csv").write_text("time,body\n1,a\n")
    with pytest.raises(DumpError, match="expected time,body,x,y,angle"):
        read_bodies(tmp_path / "bad.csv")


def test_a_stopped_run_goes_on_to_the_same_files(case, tmp_path):
    scene = case.scene()
    run_native(scene, tmp_path / "whole")
    stopped = run_native(scene, tmp_path / "part", stop_at=scene.steps // 2 + 7, checkpoint_interval=1e9)
    assert stopped.status == "interrupted"
    run_native(scene, tmp_path / "part", resume=read_checkpoint(tmp_path / "part"))
    for name in ("bodies.csv", "walls.csv", "forces.csv", "dump.lammpstrj"):
        assert (tmp_path / "part" / name).read_bytes() == (tmp_path / "whole" / name).read_bytes(), name
