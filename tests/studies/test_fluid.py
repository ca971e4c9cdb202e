# SPDX-License-Identifier: GPL-2.0-or-later
"""The discs as a fluid: the box without walls, fits, and what the study makes of its pieces."""

from __future__ import annotations

from math import nan, pi

import numpy as np
import pytest

import lammps_jump as lj
from lammps_jump.errors import CaseError
from lammps_jump.studies import fluid
from lammps_jump.studies.fluid import box as boxes
from lammps_jump.studies.fluid import cell, flow, study
from lammps_jump.sweeps.table import mean_of

CASE = "inputs/hydraulic_jump_graded.yaml"


@pytest.fixture(scope="module")
def case():
    return lj.load_case(CASE)


@pytest.fixture(scope="module")
def discs(case):
    return fluid.discs_of(case)


def two(discs, places, velocities, rate=0.0):
    """A box of two discs at these places, a tenth of their distance apart."""
    box = fluid.Cell(discs, 2, 1, packing=0.01)
    swarm = box.swarm
    swarm.radius[:] = 0.1
    (swarm.x[:], swarm.y[:]), (swarm.vx[:], swarm.vy[:]) = np.transpose(places), np.transpose(velocities)
    swarm.vx[:] += rate * (swarm.y - 0.5 * box.box[1])
    return box


class TestBox:
    """Contacts within the box and across its seams."""

    @pytest.mark.parametrize("seam", ["none", "along", "above"])
    def test_restitution_is_that_of_the_contact(self, discs, seam):
        """Two equal discs that meet head on part with e of their speed, wherever they meet."""
        box = two(discs, [(0, 0), (0, 0)], [(0, 0), (0, 0)])
        length, height = box.box[:2]
        gap = 0.205
        places = {
            "none": [(0.5, 0.5), (0.5 + gap, 0.5)],
            "along": [(length - 0.1, 0.5), (gap - 0.1, 0.5)],
            "above": [(0.5, height - 0.1), (0.5, gap - 0.1)],
        }[seam]
        speed = (1.0, 0.0) if seam != "above" else (0.0, 1.0)
        box = two(discs, places, [speed, (-speed[0], -speed[1])])
        box.advance(0.02, 1)
        swarm = box.swarm
        after = (swarm.vx[1] - swarm.vx[0]) + (swarm.vy[1] - swarm.vy[0])
        # the correction is exact for the mean over the phase of the entry, which scatters by a few per cent
        assert after / 2.0 == pytest.approx(discs.coefficients.restitution, rel=0.1)
        assert swarm.vx.sum() == pytest.approx(0.0, abs=1e-9)
        assert swarm.vy.sum() == pytest.approx(0.0, abs=1e-9)

    def test_images_move_with_the_shear(self, discs):
        """Seen from the stream, two discs that meet across the upper seam do what they do in the middle."""
        rate = 0.5
        found = []
        for low in (1.0, None):
            box = two(discs, [(0, 0), (0, 0)], [(0, 0), (0, 0)])
            below = low or box.box[1] - 0.1
            places = [(0.5, below), (0.5, (below + 0.205) % box.box[1])]
            box = two(discs, places, [(0, 1), (0, -1)], rate)
            box.advance(0.02, 1, rate=rate)
            relative = box.swarm.vx - rate * (box.swarm.y - 0.5 * box.box[1])
            found.append([np.ptp(relative), np.ptp(box.swarm.vy)])
        # the second pair starts where the shear carries it elsewhere, but with the same relative motion
        assert found[1] == pytest.approx(found[0], abs=1e-9)

    def test_pressure_is_held(self, discs):
        box = fluid.Cell(discs, 60, 1)
        box.close(60e3)
        record = box.advance(0.05, 1, pressure=60e3)
        assert 0.5 * record[0, :2].sum() == pytest.approx(60e3, rel=0.05)  # a box at rest follows within STEADY
        assert box.packing == pytest.approx(0.84, abs=0.02)

    def test_too_deep(self, discs):
        box = fluid.Cell(discs, 30, 1, packing=30.0)
        with pytest.raises(lj.RunError, match="blown up"):
            box.advance(0.01, 1)


class TestShear:
    """Friction of sheared discs."""

    def test_friction_and_packing(self, discs):
        """0.254 and 0.811 at I = 0.1 (1,000 discs, three starts); here 200 discs and one start, scatter 0.02."""
        (found,) = boxes.sheared(discs, 60e3, 1, numbers=(0.1,), count=200)
        number = found.inertial
        expected = 0.083 + 0.541 * number**0.5
        assert found.friction == pytest.approx(expected, abs=0.02)
        assert found.packing == pytest.approx(0.811, abs=0.01)

    def test_fit(self):
        inertial = np.geomspace(0.003, 0.3, 5)
        found = cell.fit_friction(inertial, 0.083 + 0.541 * inertial**0.5)
        assert found == pytest.approx((0.083, 0.541, 0.5), rel=1e-6)
        assert cell.fit_friction(inertial, found.static + found.slope * inertial**0.5, 0.5) == pytest.approx(found)

    @pytest.mark.parametrize(("depth", "rate", "nu"), [(1, 1, 2.2), (1, 10, 0.5), (6, 1, 10), (6, 10, 2.1)])
    def test_viscosity(self, depth, rate, nu):
        """nu = mu(I) p/(rho rate), two digits of the trial."""
        friction = cell.Friction(0.083, 0.541, 0.5)
        assert cell.viscosity(friction, 9810.0 * depth, rate, 0.2, 1000.0) == pytest.approx(nu, rel=0.05)

    def test_rate(self):
        assert cell.shear_rate(0.1, 0.2, 1000.0, 60e3) == pytest.approx(0.1 * 60**0.5 / 0.2)


class TestSound:
    """Speed of sound."""

    def test_speed(self, discs):
        """0.6 n v0 in the trial, 0.63 ± 0.02 in longer boxes; one start of a short one scatters by 0.05."""
        found = boxes.sound_speed(discs, 60e3, 1, length=30)
        assert 0.53 < found.ratio < 0.70
        assert found.speed == pytest.approx(found.ratio * 160.0)

    def test_damped_cosine(self):
        times = np.linspace(0.0, 2.0, 100)
        found = boxes.damped_cosine(times, 0.1 + 2.0 * np.exp(-2.0 * times) * np.cos(6.0 * times + 0.3), 7.0)
        assert found == pytest.approx((6.0, 2.0, 0.1), rel=1e-5)
        assert found.damping == pytest.approx(2.0 / 40.0**0.5, rel=1e-5)


class TestSlosh:
    """Sloshing."""

    def test_water(self):
        assert boxes.water_frequency(0.01, 100.0, 9.81) == pytest.approx((9.81 * 0.01) ** 0.5 * pi / 100.0, rel=1e-6)

    def test_friction(self):
        """0.197 of the trial's swing of 3.18 m over 4 m that comes to -0.37."""
        assert boxes.coulomb_friction(3.18, -0.37, 4.0) == pytest.approx(0.197, rel=2e-3)

    def test_numbers(self):
        times = np.linspace(0.0, 1.6, 161)
        swing = np.exp(-2.5 * times) * np.cos(2.0 * pi * times)
        found = boxes.slosh_of(times, swing / swing[0], 3.0, 4.0)
        assert found.frequency == pytest.approx(1.0, rel=1e-4)
        assert found.damping == pytest.approx(2.5 / np.hypot(2.5, 2.0 * pi), rel=1e-4)
        assert found.opposite == pytest.approx(swing.min())

    def test_discs_that_do_not_swing(self):
        times = np.linspace(0.0, 1.6, 161)
        found = boxes.slosh_of(times, 0.4 + 0.6 * np.exp(-times), 3.0, 4.0)
        assert np.isnan(found.frequency)
        assert found.rest > 0.4

    def test_box(self, discs):
        box = boxes.box_of(discs, 2.0, 9.81, 1)
        assert np.hypot(*box.gravity) == pytest.approx(9.81)
        covered = pi / 4.0 * np.sum(box.diameters(np.arange(1, len(box.positions) + 1)) ** 2)
        assert covered / (5.0 * 2.0 * 2.0) == pytest.approx(boxes.PACKED, rel=0.02)


class TestFlow:
    """Scales of the flow of a case."""

    def test_jump(self, case):
        found = fluid.flow_of(case)
        assert found.depth == pytest.approx(6.74, rel=1e-3)  # Bélanger
        assert (found.speed, found.discharge) == (16.0, 16.0)
        assert found.froude == pytest.approx(5.11, rel=1e-3)

    def test_column(self):
        found = fluid.flow_of(lj.load_case("inputs/dam_break.yaml"))
        assert found.depth == pytest.approx(12.0, rel=0.02)
        assert found.speed == pytest.approx((9.81 * found.depth) ** 0.5)

    def test_given(self, case):
        found = fluid.flow_of(case, depth=2.0, speed=3.0)
        assert (found.depth, found.speed, found.rate) == (2.0, 3.0, 1.5)

    def test_no_gravity(self):
        with pytest.raises(CaseError, match="gravity is 0"):
            fluid.flow_of(lj.load_case("inputs/energy_box_16.yaml"))


def pieces():
    """What starts would find."""
    numbers = (0.3, 0.1, 0.03)
    rows = [{"inertial": i, "friction": 0.08 + 0.5 * i**0.5, "packing": 0.84 - 0.2 * i} for i in numbers]
    times = np.linspace(0.0, 1.6, 30).tolist()
    swing = {"frequency": 0.99, "damping": 0.4, "opposite": -0.37, "rest": 0.0, "amplitude": 3.0, "friction": 0.2}
    wave = {"speed": 100.0, "ratio": 0.62, "packing": 0.84}
    swings = [swing | {"times": times, "swing": np.cos(times).tolist()}] * 2
    return [rows, rows], [wave, wave], swings


class TestStudy:
    """What is made of the pieces."""

    def test_page(self, case, discs, tmp_path, monkeypatch):
        monkeypatch.setenv("LAMMPS_JUMP_CACHE", str(tmp_path))
        summary, scales = study.summary_of(*pieces()), flow.flow_of(case)
        assert summary["static"][0] == pytest.approx(0.08)
        at = flow.numbers_at(summary, discs, scales)
        assert at["mach"] == pytest.approx(0.16)
        assert at["reynolds"] == pytest.approx(16.0 / at["viscosity"])
        assert flow.stored(case) is None
        zones = {name: flow.numbers_at(summary, discs, one) for name, one in flow.zones_of(case, scales).items()}
        doubts = study.warnings_of(discs, scales, at)
        found = {"case": case.name, "flow": at, "zones": zones, "warnings": doubts, "summary": summary}
        text = study.text_of(found, discs, scales)
        assert "| middle of the jump |" in text
        assert "| friction at rest (yield) μs | 0 | 0.08 " in text
        assert found["warnings"] == []
        study.draw(found, discs, scales, tmp_path / "fluid.png")
        assert (tmp_path / "fluid.png").stat().st_size > 10_000
        path = flow.store_of(flow.measured_key(discs, scales))
        path.parent.mkdir()
        lj.files.write_json(path, {"summary": summary})
        assert flow.stored(case)["reynolds"] == pytest.approx(at["reynolds"])
        assert "Reynolds number q/nu" in flow.flow_numbers_in_words(at)

    def test_parts_of_a_jump_have_the_depths_of_its_run(self, case, tmp_path):
        scales = flow.flow_of(case)
        parts = flow.zones_of(case, scales, tmp_path)
        assert [one.depth for one in parts.values()] == pytest.approx(
            [scales.thinnest, 0.5 * (scales.thinnest + scales.depth), scales.depth]
        )
        assert all(one.speed * one.depth == pytest.approx(scales.discharge) for one in parts.values())
        summary = {"case_hash": case.hash, "jump": {"y1": 1.1, "y2": 6.5}}
        lj.files.write_json(tmp_path / "summary.json", summary)
        assert [one.depth for one in flow.zones_of(case, scales, tmp_path).values()] == [1.1, 3.8, 6.5]
        lj.files.write_json(tmp_path / "summary.json", summary | {"case_hash": "another"})
        assert flow.zones_of(case, scales, tmp_path) == parts
        column = lj.load_case("inputs/dam_break.yaml")
        assert flow.zones_of(column, flow.flow_of(column), tmp_path) == {}

    def test_key_is_of_the_discs(self, case, discs):
        """The seed, walls and words of a case change nothing; the contact does."""
        scales = flow.flow_of(case)
        other = lj.load_case(CASE, {"run.seed": 7, "description": "another"})
        assert flow.measured_key(fluid.discs_of(other), flow.flow_of(other)) == flow.measured_key(discs, scales)
        stiffer = fluid.discs_of(lj.load_case(CASE, {"contact.largest_overlap": 0.05}))
        assert flow.measured_key(stiffer, scales) != flow.measured_key(discs, scales)

    def test_discs_that_attract_each_other_are_others(self, discs):
        scales = flow.flow_of(lj.load_case(CASE))
        sticky = fluid.discs_of(lj.load_case(CASE, {"contact.cohesion": {"weight": 0.5}}))
        pull = 0.5 * sticky.coefficients.mass * 9.81
        assert sticky.scene.law_numbers(sized=True).cohesion == pytest.approx(pull, rel=1e-3)
        assert flow.measured_key(sticky, scales) != flow.measured_key(discs, scales)

    def test_doubts(self, case):
        equal = lj.load_case(CASE, {"discs": {"diameter": 0.2, "density": 1000}, "contact.friction": 0.1})
        scales = flow.flow_of(equal, speed=40.0)
        summary = study.summary_of(*pieces())
        discs = fluid.discs_of(equal)
        doubts = study.warnings_of(discs, scales, flow.numbers_at(summary, discs, scales))
        assert [text.split()[0:3] for text in doubts] == [
            ["the", "Mach", "number"], ["the", "discs", "are"], ["contact.friction", "is", "0.1:"],
        ]  # fmt: skip

    def test_a_gas_is_refused(self):
        sheared, sounds, swings = pieces()
        with pytest.raises(CaseError, match="a gas"):
            study.summary_of([sheared[0][:1]], sounds, swings)

    def test_interval_without_values(self):
        assert np.isnan(mean_of([nan, nan])).all()


@pytest.mark.long
def test_the_whole_command(tmp_path, monkeypatch):
    monkeypatch.setenv("LAMMPS_JUMP_CACHE", str(tmp_path / "cache"))
    found = study.fluid(lj.load_case("inputs/quick_jump.yaml"), tmp_path / "out", quick=True, say=lambda text: None)
    assert 0.05 < found["summary"]["static"][0] < 0.12
    assert {path.name for path in (tmp_path / "out").iterdir()} == {
        ".lammps-jump",
        "fluid.json",
        "fluid.md",
        "fluid.png",
    }
    assert 3 < found["flow"]["reynolds"] < 22  # the range that the trial found in jumps


@pytest.mark.long
def test_springs_hold_a_slope():
    """Friction 0.5 with springs and spin: the yield is several times that of discs without friction."""
    rough = lj.load_case(CASE, {"contact.friction": 0.5, "contact.friction_law": "history", "contact.rotation": True})
    (found,) = boxes.sheared(fluid.discs_of(rough), 60e3, 1, numbers=(0.1,), count=100)
    assert found.friction > 0.3
