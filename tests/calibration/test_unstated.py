# SPDX-License-Identifier: GPL-2.0-or-later
"""Curves that were measured without an error: what is estimated, how the ranges hold, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from lammps_jump.calibration import answer as words
from lammps_jump.calibration.answer import along, partner, unmet
from lammps_jump.calibration.besides import Change, NearestEffects, movers
from lammps_jump.calibration.model import MOST, MOST_POINTS, alike, model_of, possible_errors, scatter_of
from lammps_jump.calibration.posterior import sample, sobol
from lammps_jump.calibration.targets import Target

SCATTER, OVER = 0.01, 0.3
"""Of a single heap over starts, m, and the length over which it is alike, m."""


def shape(at, place):
    """A heap whose flanks, and with two numbers whose top, are varied."""
    top = 0.25 + (0.15 * place[1] if len(place) == 2 else 0.0)
    return np.maximum(0.0, top - (0.2 + 0.4 * place[0]) * np.abs(at))


class Laboratory:
    """Runs of heaps at some points, and measurements with noise of a size, alike over a length."""

    def __init__(self, varied, points, noise, length, seed):
        self.at, self.noise, self.rng = np.linspace(-0.45, 0.45, points), noise, np.random.default_rng(seed)
        self.own = np.linalg.cholesky(alike(self.at, OVER)) * SCATTER
        self.error = np.linalg.cholesky(alike(self.at, length)) * noise
        self.places = sobol({1: 8, 2: 16}[varied], varied, seed)
        self.values = np.array([[self.run(place) for _ in range(2)] for place in self.places])

    def run(self, place):
        return shape(self.at, place) + self.own @ self.rng.normal(size=len(self.at))

    def model(self, truth, stated, more=0.0):
        measured = self.run(truth) + self.error @ self.rng.normal(size=len(self.at)) + more
        error = np.full(len(self.at), self.noise if stated else np.nan)
        return model_of(self.places, [Target("heap.depth", measured, error, "x", self.at)], {"heap.depth": self.values})


def twins(varied, points, noise, length, *, stated, count, each=2):
    """Whether the truth is in the 95 % range, shape (twins, varied); widths alike; and the errors that were taken."""
    inside, widths, errors = [], [], []
    for seed in range(count // each):
        place = Laboratory(varied, points, noise, length, seed)
        for _ in range(each):
            truth = place.rng.random(varied)
            model = place.model(truth, stated)
            ranges = [sample(model.log_likelihood, varied).range_of(k) for k in range(varied)]
            inside.append([low <= one <= high for (low, high), one in zip(ranges, truth, strict=True)])
            widths.append([high - low for low, high in ranges])
            errors.append(model.parts[0].target.error[0])
    return np.array(inside), np.array(widths), np.array(errors)


def require_coverage(inside):
    """At least nine in ten: the number that the command promises; less four standard errors of 0.95 is below that."""
    assert (inside.mean(axis=0) >= 0.9).all(), inside.mean(axis=0)


def test_the_truth_is_in_the_range_where_no_error_is_told():
    inside, widths, errors = twins(1, 19, 0.02, 0.0, stated=False, count=8)
    told = twins(1, 19, 0.02, 0.0, stated=True, count=4)
    require_coverage(inside)
    assert widths[:4].mean() > told[1].mean()  # what is not told costs width
    # 19 points less the components that the runs span: the error is known to some 1/sqrt(2 x 16) = 18 %, and what of
    # the scatter is beside them may add its 0.01
    assert np.median(errors) == pytest.approx(0.02, rel=0.4)


@pytest.mark.long
@pytest.mark.parametrize("varied", [1, 2])
@pytest.mark.parametrize("points", [5, 19, 100])
@pytest.mark.parametrize(("noise", "length"), [(0.001, 0), (0.004, 0.2), (0.02, 0), (0.02, 0.2), (0.02, 0.45)])
def test_ranges_hold_over_points_sizes_and_lengths(varied, points, noise, length):
    """From noise far below the scatter to twice it, from its own at each point to alike over half of the heap."""
    inside, _, _ = twins(varied, points, noise, length, stated=False, count=40)
    require_coverage(inside)


@pytest.mark.parametrize(
    ("points", "noise"),
    [(19, 0.02)]
    + [pytest.param(points, noise, marks=pytest.mark.long) for points in (10, 100) for noise in (0.004, 0.02, 0.05)],
)
def test_the_estimated_error_is_that_of_the_curve(points, noise):
    found = [Laboratory(1, points, noise, 0.0, seed).model([0.5], stated=False).parts[0].target.error[0]
             for seed in range(9)]  # fmt: skip
    # the median of nine, each known to 1/sqrt(2 (points - 3)) at best; scatter beside the components adds to it
    apart = 3.0 / np.sqrt(2.0 * (points - 3)) / np.sqrt(9)
    assert noise * (1 - apart) < np.median(found) < np.hypot(noise * (1 + apart), SCATTER)


def test_an_error_far_below_the_scatter_is_not_made_larger_than_it():
    """What single runs scatter is known from their starts; below it an error can hardly be told, and hardly matters."""
    labs = [Laboratory(1, 100, 0.0005, 0.0, seed) for seed in range(5)]
    found = [one.model([0.5], stated=False) for one in labs]
    assert np.median([one.parts[0].target.error[0] for one in found]) < SCATTER
    target = {"error": [0.0047], "measured": [0.0, 0.25], "spread": [0.01, 0.01]}
    said = (
        "About 0.0047 is estimated (2 % of the range of the curve; the scatter over starts, 0.01, hides smaller ones)"
    )
    assert said in words.estimated_text("heap.depth", target)
    assert "hides" not in words.estimated_text("heap.depth", {**target, "error": [0.02]})


def test_a_stated_error_is_taken_as_it_is():
    model = Laboratory(1, 19, 0.004, 0.0, 1).model([0.5], stated=True)
    (part,) = model.parts
    assert part.possible is None and model.errors.shape == (1, *model.scatter.shape)
    assert part.error_covariances[0] == pytest.approx(model.errors[0])


def test_possible_errors_are_those_that_explain_what_is_beside():
    at, rng = np.linspace(0, 1, 60), np.random.default_rng(3)
    beside, nothing = np.eye(60), np.zeros((60, 60))
    each = possible_errors(at, np.linspace(0, 1, 60), beside, 0.03 * rng.normal(size=60), nothing)
    assert each.typical == pytest.approx(0.03, rel=0.2) and np.mean(each.lengths == 0) > 0.7
    smooth = np.linalg.cholesky(alike(at, 0.3)) @ rng.normal(size=60) * 0.03
    found = possible_errors(at, np.linspace(0, 1, 60), beside, smooth, nothing)
    assert (found.lengths > 0.1).all() and 0.01 < found.typical < 0.08  # three pieces of news
    assert found.sizes.max() <= MOST
    # sizes grow with the unit
    mm = possible_errors(1e3 * at, np.linspace(0, 1e3, 60), beside, 1e3 * smooth, nothing)
    assert mm.sizes == pytest.approx(1e3 * found.sizes) and mm.lengths == pytest.approx(1e3 * found.lengths)


def test_the_scatter_of_few_starts_is_that_of_a_curve_alike_over_their_length():
    at, rng = np.linspace(0, 1, 80), np.random.default_rng(4)
    true = 0.1**2 * alike(at, 0.25)
    draws = [rng.multivariate_normal(np.zeros(80), true, size=8) for _ in range(10)]
    found = [scatter_of(at, off, 8.0) for off in draws]
    assert min(np.linalg.eigvalsh(one).min() for one in found) > 0
    # 80 starts in all, a variance to some sqrt(2/80) = 16 %: four of that
    assert np.abs(np.mean(found, axis=0) - true).max() < 0.64 * 0.1**2
    off = draws[0]
    assert not scatter_of(at, np.zeros((8, 80)), 8.0).any()
    off[:, :20] = 0.0  # as beside a heap
    assert not scatter_of(at, off, 8.0)[:20].any()


def test_a_curve_of_very_many_points_keeps_some():
    at, places = np.linspace(0, 1, 3001), sobol(8, 1, 1)
    values = places * np.exp(-at) + 1e-3 * np.random.default_rng(1).normal(size=(8, 3001))
    target = Target("h.d", 0.4 * np.exp(-at), np.full(3001, np.nan), "x", at)
    model = model_of(places, [target], {"h.d": values[:, None]})
    (part,) = model.parts
    assert MOST_POINTS / 2 < len(part.target.at) <= MOST_POINTS and part.kept.sum() == len(part.target.at)


def test_two_curves_without_errors_go_together():
    at, rng, places = np.linspace(0, 1, 19), np.random.default_rng(2), sobol(16, 2, 1)
    names, truth = ("a.a", "b.b"), np.array([0.3, 0.6])

    def curves(place):
        return {"a.a": place[0] * np.exp(-at), "b.b": place[1] * at - place[0]}

    values = {name: np.array([[curves(one)[name] + 0.01 * rng.normal(size=19) for _ in range(2)] for one in places])
              for name in names}  # fmt: skip
    measured = {name: curves(truth)[name] + 0.03 * rng.normal(size=19) for name in names}
    unknown = np.full(19, np.nan)
    model = model_of(places, [Target(name, measured[name], unknown, "x", at) for name in names], values)
    assert len(model.errors) == 16 and len({tuple(one.diagonal().round(12)) for one in model.errors}) > 4
    found = sample(model.log_likelihood, 2)
    for k in (0, 1):
        low, high = found.range_of(k)
        assert low <= truth[k] <= high and high - low < 0.3


def test_a_curve_above_all_runs_is_not_explained_by_its_error():
    place = Laboratory(1, 19, 0.004, 0.0, 1)
    model = place.model([0.0], stated=False, more=0.3 + 0.2 * place.at)
    (one,) = unmet(model, sample(model.log_likelihood, 1))
    assert one["curve"] and one["above"] == 19 and one["below"] == 0
    assert "which lies above all runs at 19 of its 19 points" in words.unmet_text(one)
    model = place.model([0.4], stated=False)
    assert not unmet(model, sample(model.log_likelihood, 1))


def test_what_moves_a_curve_is_told_along_its_gap():
    place = Laboratory(1, 19, 0.004, 0.0, 1)
    model = place.model([0.0], stated=True, more=0.4)
    near = int(np.argmin(place.places[:, 0]))
    base = place.values[near].mean(axis=0)
    up, down = base + 0.2, base - 0.1
    values = np.array([[up, up], [down, down], [base, base], [np.full(19, np.nan)] * 2])
    changes = tuple(Change(path, 1.0, 2.0) for path in ("a", "b", "c", "d"))
    told = movers(model, model.parts[0], near, NearestEffects(changes, (), {"heap.depth": values}, 8))
    assert [one["path"] for one in told] == ["a", "b"]
    # the gap is 0.4 and what the steepest run lacks of the truth: up takes about half of it
    assert told[0]["closes"] == pytest.approx(0.5, abs=0.1) and told[1]["closes"] == pytest.approx(-0.25, abs=0.05)
    assert "from_value" not in told[0]


@pytest.mark.parametrize("product", [0.05, 0.15, 0.3])
def test_a_bent_ridge_hides_and_has_two_points_on_it(product):
    """As of friction and rolling friction: x y = const, which a straight line does not follow."""
    found = sample(
        lambda places: -0.5 * ((np.log(places[:, 0] * places[:, 1] + 1e-9) - np.log(product)) / 0.05) ** 2, 2
    )
    other, size = partner(found, 0)
    assert other == 1 and 0.5 < size <= 1
    (x1, y1), (x2, y2) = along(found, 0, 1)
    for x, y in ((x1, y1), (x2, y2)):
        assert np.log(x * y / product) == pytest.approx(0, abs=0.05 * 1.02)  # within one standard deviation: 0.6
    assert x2 - x1 > 0.5


def test_numbers_that_do_not_hide_each_other_have_no_ridge():
    found = sample(lambda places: -0.5 * np.sum(((places - 0.5) / 0.2) ** 2, axis=1), 2)
    assert partner(found, 0) is None and partner(found, 1) is None
