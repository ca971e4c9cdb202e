# SPDX-License-Identifier: GPL-2.0-or-later
"""The arithmetic of the cross-validation: statistics with known answers, growth rates, small scenes, kept members."""

from dataclasses import replace
from math import comb, exp

import numpy as np
import pytest
import yaml
from scipy import stats

import lammps_jump as lj
from lammps_jump.analysis.jump.found import Jump
from lammps_jump.case import load_case
from lammps_jump.errors import RunError, SetupError
from lammps_jump.studies.cross_validation import quantities as cv_statistics
from lammps_jump.studies.cross_validation import study as cross_validation
from lammps_jump.studies.cross_validation import trajectories
from lammps_jump.studies.cross_validation.page import verdict_text
from lammps_jump.studies.cross_validation.quantities import JUMP_NUMBERS, MemberCurve, Quantities, compare
from lammps_jump.studies.cross_validation.study import CrossValidation, micro_scenes
from lammps_jump.studies.cross_validation.trajectories import (
    AGREEMENT,
    DeterministicCheck,
    check_scene,
    crossing_step,
    first_contact,
    fit_growth,
    perturbed,
    separation,
    trajectory,
)
from lammps_jump.sweeps import Pool
from lammps_jump.sweeps.members import JITTER, started
from lammps_jump.units import numbers_of

pytestmark = pytest.mark.usefixtures("kept_workers")

DROP = """
name: drops
discs: {diameter: 0.2, density: 1000}
contact: {restitution: 0.3, friction: 0, impact_speed: 5}
domain: {x: [-2, 4], y: [-2, 4]}
walls: [{name: floor, kind: plane, axis: y, at: 0, side: above}]
initial: [{kind: lattice, nx: 3, ny: 3, spacing: 0.25, origin: [0.2, 0.3]}]
run: {duration: 0.21, time_step_fraction: 0.1, output_interval: 0.02}
probes: {forces: [floor]}
analysis: {bin_width: 0.5}
"""


def _case(*changes):
    return lj.load_case(yaml.safe_load(DROP), ["run.integrator=velocity_verlet", *changes])


def _scene(*changes):
    return _case(*changes).scene()


def _study(folder, said, pool, *changes):
    case = _case(*changes)
    return CrossValidation(case, case.scene(), "stock", folder, pool, (1,), [], said.append)


class TestWelch:
    def test_equals_scipys_welch_test(self):
        rng = np.random.default_rng(1)
        one, two = rng.normal(5, 1, 6), rng.normal(5.5, 2, 4)
        found = cv_statistics.welch(one, two)
        expected = stats.ttest_ind(two, one, equal_var=False)
        interval = expected.confidence_interval(0.95)
        # the floor of 1e-6 of the size is all that differs
        assert found.p == pytest.approx(expected.pvalue, rel=1e-6)
        assert found.difference == pytest.approx(two.mean() - one.mean(), rel=1e-14)
        assert found.half_width == pytest.approx((interval.high - interval.low) / 2, rel=1e-6)

    @pytest.mark.long
    def test_interval_covers_the_truth_as_often_as_it_says(self):
        rng = np.random.default_rng(2)
        inside = 0
        for _ in range(1000):
            found = cv_statistics.welch(rng.normal(0, 1, 5), rng.normal(1, 3, 5))
            inside += abs(found.difference - 1.0) <= found.half_width
        # 950 expected, standard deviation 7; Welch is a little conservative at n = 5
        assert 925 <= inside <= 985

    def test_identical_constants_agree_and_last_digits_do_not_count(self):
        same = cv_statistics.welch(np.full(4, 7.0), np.full(4, 7.0))
        assert (same.p, same.half_width, same.difference) == (1.0, 0.0, 0.0)
        digits = cv_statistics.welch(np.full(4, 7.0), np.full(4, 7.0 * (1 + 1e-9)))
        assert digits.p > 0.9
        assert cv_statistics.welch(np.full(4, 7.0), np.full(4, 7.001)).p < 1e-3

    def test_single_values_give_no_interval(self):
        found = cv_statistics.welch(np.array([1.0]), np.array([2.0, 3.0]))
        assert found.difference == 1.5 and np.isnan(found.half_width) and np.isnan(found.p)
        assert np.isnan(cv_statistics.welch(np.array([np.nan]), np.array([2.0])).difference)


def test_permutation_p_by_hand_and_against_scipy():
    # the most extreme of C(6, 3) = 20 deals, and its mirror image
    assert cv_statistics.permutation_p(np.array([1.0, 2, 3]), np.array([10.0, 11, 12])) == pytest.approx(2 / 20)
    rng = np.random.default_rng(3)
    one, two = rng.normal(0, 1, 4), rng.normal(0.8, 1, 5)
    expected = stats.permutation_test((one, two), lambda a, b: a.mean() - b.mean(), n_resamples=np.inf)
    low_tie = abs(expected.pvalue - cv_statistics.permutation_p(one, two))
    # scipy doubles the smaller tail, here both tails are counted: equal up to the grain of the test
    assert low_tie <= 12 / comb(9, 4)
    assert np.isnan(cv_statistics.permutation_p(np.zeros(20), np.zeros(20)))


def test_holm_against_the_worked_rule():
    adjusted = cv_statistics.holm({"a": 0.01, "b": 0.04, "c": 0.03, "d": np.nan})
    assert adjusted["a"] == pytest.approx(0.03)
    assert adjusted["c"] == pytest.approx(0.06)
    assert adjusted["b"] == pytest.approx(0.06)  # never below the one before
    assert np.isnan(adjusted["d"])


@pytest.mark.long
def test_false_alarms_over_curves_and_numbers_stay_below_the_family_error():
    rng = np.random.default_rng(4)

    def member():
        values = {f"number {k}": MemberCurve("m", [rng.normal(3, 1)]) for k in range(8)}
        at = np.arange(20.0)
        return Quantities({**values, "curve": MemberCurve("m", rng.normal(0, 1, 20) + at, "x", at)})

    alarms = 0
    for _ in range(150):
        found = compare(("one", "two"), [member() for _ in range(4)], [member() for _ in range(4)], 0.05)
        alarms += not found.agrees
    # at most 5 % = 7.5 of 150 expected (sd 2.7)
    assert alarms <= 15


def test_a_wide_interval_is_no_agreement():
    """The same quantity from 4 members and from as many as the row asks for."""
    rng = np.random.default_rng(8)

    def found(members, mean=2.0):
        sides = [[Quantities({"c": MemberCurve("m/s", [v])}) for v in rng.normal(mean, 0.4, members)] for _ in range(2)]
        return compare(("one", "two"), *sides, 0.01)

    few = found(4).find("c")
    assert few["verdict"] == "not decided" and few["members_needed"] > 4
    assert f"; {few['members_needed']} members would decide" in few["text"] and found(4).agrees
    many = found(few["members_needed"] + 200).find("c")
    assert many["verdict"] == "agree" and many["members_needed"] is None
    nothing = found(4, mean=0.0).find("c")
    assert nothing["verdict"] == "not decided" and nothing["members_needed"] is None
    said = verdict_text({"disc_by_disc": [], "criteria": [], "statistics": {"quantities": [few, many]}})
    assert "in 1 of 2 statistical quantities. 1 are not decided" in said


def test_compare_finds_a_shift_in_one_bin_and_says_where():
    rng = np.random.default_rng(5)
    at = np.linspace(0.5, 9.5, 10)

    def member(shift):
        values = 2.0 + 0.01 * rng.normal(size=10) + shift * (np.arange(10) == 6)
        numbers = {"still": MemberCurve("m", [1.0]), "zero": MemberCurve("m", [0.0])}
        return Quantities({"depth": MemberCurve("m", values, "x", at), **numbers})

    found = compare(("one", "two"), [member(0.0) for _ in range(5)], [member(0.3) for _ in range(5)], 0.01)
    verdict = found.find("depth")
    assert verdict["verdict"] == "differ" and "x = 6.5 m" in verdict["text"]
    assert verdict["difference"] == pytest.approx(0.3, abs=0.03)
    assert not found.agrees and found.find("still")["verdict"] == "agree" and found.find("zero") is None


def test_curves_with_gaps_are_compared_where_all_members_have_values():
    one, two = np.ones((3, 4)), np.ones((3, 4)) + 1e-3 * np.arange(3)[:, None]
    one[1, 2] = np.nan
    band = cv_statistics.compare_curves(one, two)
    assert (
        np.isfinite(band.p).sum() == 3
        and np.isnan(band.difference[2])
        and np.isfinite(band.difference[[0, 1, 3]]).all()
    )


def test_block_means_keep_the_mean():
    values = np.arange(12.0)
    assert np.allclose(cv_statistics.block_means(values, 4), [1, 4, 7, 10])
    assert cv_statistics.block_means(values, 50).shape == (12,)


class TestGrowth:
    def test_rate_of_a_pure_exponential(self):
        steps = np.arange(0, 5000, 10)
        values = np.minimum(1e-15 * np.exp(0.01 * steps), 3.0)
        growth = fit_growth(steps, values, 1e-3)
        assert growth.rate == pytest.approx(10.0, rel=1e-9) and growth.share == pytest.approx(1.0)
        assert values[steps == growth.start][0] >= growth.low

    def test_nothing_to_fit(self):
        steps = np.arange(100)
        assert np.isnan(fit_growth(steps, np.full(100, 1e-16), 1e-3).rate)
        assert np.isnan(fit_growth(steps, np.zeros(100), 1e-3).rate)

    def test_separation_stops_where_the_discs_are_others(self):
        ids, places = np.array([1, 2]), np.array([[0.0, 0.0], [1.0, 0.0]])
        one = {0: (ids, places), 10: (ids, places), 20: (ids, places)}
        two = {0: (ids, places), 10: (ids, places + np.array([[0, 0], [0.03, 0.04]])), 20: (np.array([1, 3]), places)}
        part = separation(one, two, 0.5)
        assert part.steps.tolist() == [0, 10] and part.other_discs == 20
        assert part.largest.tolist() == [0.0, pytest.approx(0.1)]
        assert crossing_step(part, 0.05) == 10 and crossing_step(part, 0.2) is None


class TestScenes:
    @pytest.mark.parametrize("scene", micro_scenes(), ids=lambda scene: scene.name)
    def test_every_small_scene_has_contacts_and_ends_whole(self, scene):
        touched = first_contact(scene, 1000)
        assert touched is not None
        frames = trajectory(replace(scene, steps=touched + 1000, output_steps=100), "native")
        places = np.concatenate([places for _, places in frames.values()])
        assert np.isfinite(places).all() and len(places) > 0

    def test_turning_and_rubbing_scenes_do_rub_and_turn(self):
        named = {scene.name: scene for scene in micro_scenes()}
        for name, changed in (("friction", 0.0), ("spin", 0.0)):
            scene = replace(named[name], steps=800, output_steps=800)
            smooth = replace(scene, coefficients=replace(scene.coefficients, friction=changed))
            part = separation(trajectory(scene, "native"), trajectory(smooth, "native"), scene.diameter)
            assert part.largest[-1] > 1e-2


class TestEnsembles:
    def test_jitter_is_small_reproducible_and_leaves_the_rest_alone(self):
        scene = _scene()
        one, again, other = (perturbed(scene, seed, JITTER) for seed in (1, 1, 2))
        assert np.array_equal(one.positions, again.positions) and not np.array_equal(one.positions, other.positions)
        shift = np.abs(one.positions - scene.positions).max() / scene.diameter
        assert 0 < shift <= JITTER * (1 + 1e-6)
        assert np.array_equal(one.velocities, scene.velocities) and one.steps == scene.steps

    def test_jitter_of_inflow_changes_speeds_only(self):
        scene = load_case("inputs/quick_jump.yaml").scene()
        moved = perturbed(scene, 3, JITTER)
        for before, after in zip(scene.inlets, moved.inlets, strict=True):
            assert 0 < abs(after.vx / before.vx - 1) <= JITTER
            assert replace(after, vx=before.vx) == before

    def test_both_engines_get_the_same_starts(self):
        starts = [
            started(lj.load_case("inputs/quick_jump.yaml", {"engine.name": name}), 3) for name in ("lammps", "native")
        ]
        one, two = (start.scene() for start in starts)
        assert one.inlets == two.inlets and one.sizes == two.sizes

    @pytest.mark.long
    def test_members_are_kept_and_found_again_until_something_changes(self, tmp_path):
        said = []
        with Pool(1) as pool:
            study = _study(tmp_path, said, pool)
            again, changed = (_study(tmp_path, said, pool, *change) for change in ((), ("contact.restitution=0.31",)))
            for one in (study, again, changed):
                one.run(one.case, "native")
        assert ["was there" in text for text in said] == [False, True, False]
        (first,), (second,) = study.members["native"], again.members["native"]
        one, two, other = (
            {name: curve.values for name, curve in member.found.items() if not curve.axis}
            for member in (first, second, changed.members["native"][0])
        )
        assert one == two != other
        assert first.run["present"] == 9 and first.found["impulse on floor, y"].values[0] < 0
        assert len(list((tmp_path / "runs").iterdir())) == 2

    @pytest.mark.long
    def test_energy_of_a_member_is_conserved_but_for_the_dashpots(self, tmp_path):
        with Pool(1) as pool:
            study = _study(tmp_path, [], pool, "contact.restitution=1", "run.time_step_fraction=0.02")
            study.run(study.case, "native")
        # second-order scheme with a kink at first touch, f = 0.02: a few 1e-4
        assert 0 < study.members["native"][0].found["energy, largest deviation"].values[0] < 3e-3

    def test_a_member_that_fails_is_an_error_with_its_reason(self, tmp_path):
        with Pool(1) as pool:
            study = _study(tmp_path, [], pool, "initial.0.velocities={9: [60, 0]}")
            with pytest.raises(RunError, match=r"native, member 1: .*domain"):
                study.run(study.case, "native")


def test_a_wrong_stiffness_is_found_out(monkeypatch):
    """The deterministic check can fail: the other engine's spring is off by one in a million."""
    scene = next(scene for scene in micro_scenes() if scene.name == "wall")

    def on_native(short, kernel, factor=1.0):
        c = short.coefficients
        softer = replace(short, coefficients=replace(c, stiffness_wall=c.stiffness_wall * factor))
        return trajectory(short if kernel == "stock" else softer, "native")

    monkeypatch.setattr(trajectories, "trajectory", on_native)
    same = check_scene(scene)
    monkeypatch.setattr(trajectories, "trajectory", lambda short, kernel: on_native(short, kernel, 1 + 1e-6))
    other = check_scene(scene)
    assert same.agrees and same.worst == 0.0
    assert not other.agrees and other.worst > 10 * AGREEMENT


def test_discs_are_those_of_the_last_frame(monkeypatch):
    """Discs enter and leave: neither the start nor the disc that is farthest off tells their number."""
    scene = next(scene for scene in micro_scenes() if scene.name == "inlet and outlet")
    runs = []
    monkeypatch.setattr(
        trajectories, "trajectory", lambda short, _: runs.append(trajectory(short, "native")) or runs[-1]
    )
    check = check_scene(scene)
    assert check.agrees and check.discs == len(runs[0][check.last_step][0]) > len(scene.positions)


def test_expected_differences_excuse_only_small_ones():
    check = DeterministicCheck("gate", "stock", 24, 180, 1180, 1e-5, False)
    assert check.explain(lambda: 1e-4).passed
    assert "1.0e-04 d" in check.explain(lambda: 1e-4).expected_difference
    assert not check.explain(lambda: 1e-9).passed  # a perturbed run does not part as far
    assert not replace(check, worst=1e-2).explain(lambda: 1.0).passed
    assert not replace(check, note="the engines hold different discs at step 10").explain(lambda: 1.0).passed
    assert replace(check, agrees=True).explain(lambda: 1.0).expected_difference is None


def test_one_member_and_poured_discs_are_refused(tmp_path):
    with pytest.raises(SetupError, match="at least 2"):
        cross_validation.cross_validate(load_case("inputs/energy_box_7.yaml"), out=tmp_path, members=1)
    case = tmp_path / "pour.yaml"
    text = DROP.replace("initial: [{kind: lattice, nx: 3, ny: 3, spacing: 0.25, origin: [0.2, 0.3]}]",
                        "inflow: {kind: pour, x: [0, 1], y: [1, 2], count: 5}")  # fmt: skip
    case.write_text(text)
    with pytest.raises(SetupError, match="poured"):
        cross_validation.cross_validate(load_case(case), out=tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_growth_of_a_perturbed_run_is_the_growth_of_a_collision():
    """Two discs that meet off-centre: a shift across the line of centres grows as geometry says, not otherwise."""
    scene = next(scene for scene in micro_scenes() if scene.name == "pair")
    short = replace(scene, steps=1200, output_steps=20)
    one = separation(trajectory(short, "native"), trajectory(perturbed(short, 1, 1e-9), "native"), 0.2)
    two = separation(trajectory(short, "native"), trajectory(perturbed(short, 1, 1e-11), "native"), 0.2)
    late = one.steps >= 800
    # small separations are linear: a hundredth of the start, a hundredth of the end
    assert np.allclose(one.largest[late] / two.largest[late], 100.0, rtol=0.02)
    assert one.largest[-1] > exp(2) * one.largest[0]


def test_every_number_that_is_compared_is_one_of_a_jump():
    """A ratio that had moved elsewhere ended the study of a jump by a KeyError, after minutes."""
    assert set(JUMP_NUMBERS) <= set(numbers_of(Jump))
