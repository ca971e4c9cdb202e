# SPDX-License-Identifier: GPL-2.0-or-later
"""Groups of walls: their rows in ``forces.csv`` against the same faces as one wall."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_up import BOX, flow_context

import lammps_jump as lj
from lammps_jump.analysis.forces.history import analyse_forces
from lammps_jump.analysis.forces.impulse import MomentumLedger
from lammps_jump.analysis.profiles import bin_frames
from lammps_jump.dump.check import force_troubles
from lammps_jump.dump.find import ForceHistory, read_forces, with_groups
from lammps_jump.engines.lammps.outputs import gather_forces
from lammps_jump.engines.native.engine import run_native, take_frame
from lammps_jump.engines.native.simulation import NativeSimulation
from lammps_jump.errors import CaseError
from lammps_jump.files import FORCES_HEADER
from lammps_jump.scene import Block, Motion, MovingWall, handmade_scene
from lammps_jump.scene.chains import Chain
from lammps_jump.scene.tracks import Loaded, Rotate, Translate
from lammps_jump.scene.walls import Wall

LEFT, RIGHT = Block("left", (-1.5, -0.5), (-0.4, 0.0)), Block("right", (0.2, 1.5), (-0.4, 0.1))
PLACES = np.array([[x, y] for x in np.arange(-1.2, 1.3, 0.25) for y in (0.25, 0.5)])
MOTIONS = {"still": None, "shifted": Translate(velocity=(1.0, 2.0)), "turning": Rotate(rate=90.0)}


class Both(Wall):
    """Both blocks as one wall, with the lower left corner of the first."""

    kind, name, deep = "both", "both", False
    friction = restitution = stiffness = motion = None

    def chains(self) -> tuple[Chain, ...]:
        return *LEFT.chains(), *RIGHT.chains()

    @property
    def moment_point(self) -> tuple[float, float]:
        return LEFT.moment_point


def moving(wall, kind, about=(0.3, -0.2), time_step=1e-4):
    return MovingWall(wall, Motion(kind=kind, about=about, time_step=time_step))


def scene_of(*walls, groups=(("basin", ("left", "right")),), **others):
    settings = {"friction": 0.2, "impact_speed": 8.0, "probe_steps": 100} | others
    return replace(handmade_scene(PLACES, 0 * PLACES + (0.5, -4.0), (), **settings), walls=walls, groups=groups)


@pytest.mark.parametrize("kind", MOTIONS.values(), ids=MOTIONS)
def test_a_group_has_the_force_moment_and_power_of_its_walls_as_one(kind):
    """The walls of the group are not probed by name; what is left is the order of sums."""
    grouped, whole = scene_of(moving(LEFT, kind), moving(RIGHT, kind)), scene_of(moving(Both(), kind), groups=())
    whole = replace(whole, probes=("both",))
    runs = [NativeSimulation(scene) for scene in (grouped, whole)]
    for run in runs:
        run.run(600)
    rows = list(with_groups(runs[0].forces, grouped.groups, grouped.walls))
    found, expected = (np.array([row[2:] for row in part if row[1] == name]) for part, name in
                       ((rows, "basin"), (runs[1].forces, "both")))  # fmt: skip
    assert found.shape == expected.shape == (6, 3 if kind is None else 4)
    assert (np.abs(expected).max(axis=0) > 1.0).all()
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())


def test_each_engine_writes_the_rows_of_groups(tmp_path):
    scene = replace(scene_of(moving(LEFT, None), moving(RIGHT, None)), steps=200, output_steps=100)
    assert scene.probes == ("left", "right")
    run_native(scene, tmp_path)
    native = read_forces(tmp_path / "forces.csv")
    assert list(native) == ["left", "right", "basin"]
    assert force_troubles(tmp_path / "forces.csv", scene, 200) == []
    for name in ("left", "right"):
        lines = [line for line in (tmp_path / "forces.csv").read_text().splitlines() if f",{name}," in line]
        (tmp_path / f"forces_{name}.raw").write_text("\n".join([FORCES_HEADER, f"0,{name},0,0,0", *lines, ""]))
    (tmp_path / "forces.csv").unlink()
    gather_forces(scene, tmp_path)
    other = read_forces(tmp_path / "forces.csv")["basin"]
    assert (other.fx, other.fy) == (pytest.approx(native["basin"].fx), pytest.approx(native["basin"].fy))
    # both sums are rounded to ten digits
    assert other.moment == pytest.approx(native["basin"].moment, rel=1e-8)


@pytest.mark.parametrize(
    ("first", "second"),
    [
        ((None,), (Translate(velocity=(1.0, 0.0)),)),
        ((Translate(velocity=(1.0, 0.0)),), (Translate(velocity=(1.1, 0.0)),)),
        ((Rotate(rate=30.0), (0.0, 0.0)), (Rotate(rate=30.0), (1.0, 0.0))),
        ((Loaded(mass=5.0, force=(0.0, -1.0)),), (Loaded(mass=5.0, force=(0.0, -1.0)),)),
    ],
)
def test_walls_that_do_not_move_as_one_make_no_group(first, second):
    with pytest.raises(CaseError, match=r"probes\.groups\.basin: 'right' does not move with 'left'"):
        scene_of(moving(LEFT, *first), moving(RIGHT, *second))


BASIN = {"walls": [*BOX["walls"], {"name": "left", "kind": "block", "x": [0.2, 0.4], "y": [0, 0.1]},
                   {"name": "right", "kind": "block", "x": [1.2, 1.4], "y": [0, 0.1]}],
         "probes": {"forces": ["box"], "groups": {"basin": ["left", "right"]}}}  # fmt: skip


def test_a_case_names_groups_of_walls_that_need_not_be_probed():
    case = lj.load_case(BOX | BASIN)
    assert case.structures == ("box", "left", "right", "basin")
    scene = case.scene()
    assert (scene.probes, scene.groups) == (("box", "left", "right"), (("basin", ("left", "right")),))
    probed = BOX | BASIN | {"probes": {"forces": ["left"], "interval": 0.02}}
    grouped = BOX | BASIN | {"probes": {"groups": {"basin": ["left"]}, "interval": 0.02}}
    assert lj.load_case(grouped).scene().probe_steps == lj.load_case(probed).scene().probe_steps
    BASIN["walls"][2]["motion"] = {"kind": "translate", "velocity": [0, 1]}
    with pytest.raises(
        CaseError, match=r"probes\.groups\.basin: 'right' does not move with 'left'.*a group of its own"
    ):
        lj.load_case(BOX | BASIN).scene()


def test_the_identity_counts_each_wall_once_and_figures_show_the_group():
    scene = scene_of(moving(LEFT, None), moving(RIGHT, None), gravity=(0.0, -9.81))
    run = NativeSimulation(scene)
    flow = replace(flow_context(domain=scene.domain, x_range=(-2, 2)), scene=scene, window=(0.0, 1.0))
    ledger = MomentumLedger(flow)
    for _ in range(7):
        ledger.add(take_frame(run), scene.time(run.step))
        run.run(100)
    rows = np.array([[scene.time(row[0]), *row[2:]] for row in with_groups(run.forces, scene.groups, scene.walls)])
    histories = {name: ForceHistory(*rows[k::3].T) for k, name in enumerate(("left", "right", "basin"))}
    profiles = bin_frames([take_frame(run)], flow)
    profiles.attrs |= {"window_begin": 0.0, "window_end": 1.0}
    found = analyse_forces(histories, flow, ledger.result(), profiles)
    for identity in found.identities:
        # dashpots of the engine see the velocity of the half step, those of the frames at both ends that of the step
        assert identity.complete and identity.relative < 1e-5
    assert list(found.shown) == ["basin"]
    assert set(found.summary()) >= {"left", "right", "basin"}
