# SPDX-License-Identifier: GPL-2.0-or-later
"""Bodies of a case: what is read, derived and refused, and a run with them from file to numbers."""

import json
import re
from math import pi, radians

import numpy as np
import pytest
import yaml

from lammps_jump.case import load_case
from lammps_jump.dump.side_files.bodies import read_bodies
from lammps_jump.engines.checkpoint import read_checkpoint
from lammps_jump.engines.choice import choose
from lammps_jump.engines.native import NativeSimulation, run_native
from lammps_jump.errors import CaseError, DumpError, RunError, SetupError
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
    ],
)
def test_a_body_that_cannot_be_is_refused_with_its_place(case, change, message):
    with pytest.raises(CaseError, match=message):
        case.replace([change]).scene()


def test_what_is_doubtful_is_told(case):
    def told(*changes):
        return [note for note in case.replace(list(changes)).scene().warnings if "body" in note]

    assert told("bodies.1.stiffness=1.2e8") == []
    assert (
        "'boulder' of 1.14e+03 kg/m may meet a wall at 12.6 m/s" in told()[0] and "the run ends at 0.04 m" in told()[0]
    )
    far = told("bodies.1.stiffness=1.2e8", "bodies.3.hinge=[12.1, 9]")
    assert far == [
        "the hinge of body 'flap' is 5 m away from it, and the body is 3.91 m large: it swings on an arm without mass, "
        "which pushes nothing"
    ]
    leaning = "bodies.0={name: caisson, kind: polygon, density: 2400, points: [[20, 0], [21, 0], [25, 5], [24, 5]]}"
    (note,) = told("bodies.1.stiffness=1.2e8", leaning)
    assert note == "body 'caisson' stands with its centre of mass 1.5 m beside its support: it tips at once"
    heavy = told("bodies.1.stiffness=1.2e8", "bodies.0.density=24000")
    assert "'caisson' of 4.8e+05 kg/m stands on its corners, with an overlap of 0.24 m" in heavy[0]


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
