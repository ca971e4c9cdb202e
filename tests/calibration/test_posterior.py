# SPDX-License-Identifier: GPL-2.0-or-later
"""Emulator, likelihood and posterior against closed forms, and the coverage of the 95 % ranges over many twins."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import multivariate_normal, multivariate_t, norm

from lammps_jump.calibration.model import model_of
from lammps_jump.calibration.posterior import emulate, log_t, sample, shortest, sobol
from lammps_jump.calibration.targets import Target


def number(name, value, error):
    return Target(name, np.array([float(value)]), np.array([float(error)]))


def test_log_density_is_that_of_scipy_but_for_a_constant():
    rng = np.random.default_rng(1)
    off, shape = rng.normal(size=(5, 2)), np.array([[2.0, 0.5], [0.5, 1.0]])
    many = np.broadcast_to(shape, (5, 2, 2))
    t = log_t(off, many, np.full(5, 3.0)) - multivariate_t(shape=shape, df=3).logpdf(off)
    normal = log_t(off, many, np.full(5, np.inf)) - multivariate_normal(cov=shape).logpdf(off)
    assert np.ptp(t) < 1e-12 and np.ptp(normal) < 1e-12
    # the constant is one, whatever the degrees of freedom: they differ from place to place
    assert t[0] == pytest.approx(normal[0], abs=1e-12)


def test_posterior_of_a_normal_number_is_its_quantiles():
    found = sample(lambda places: -0.5 * ((places[:, 0] - 0.4) / 0.01) ** 2, 1)
    assert found.best[0] == pytest.approx(0.4, abs=1e-4)
    # 8,192 places in a box of some ten standard deviations: quantiles to 1 % of one
    assert np.array(found.range_of(0)) == pytest.approx([0.4 - 0.0196, 0.4 + 0.0196], abs=2e-4)


def test_a_ridge_is_followed_to_its_ends():
    found = sample(lambda places: -0.5 * ((places.sum(axis=1) - 1.0) / 0.004) ** 2, 2)
    assert found.correlation[0, 1] < -0.99 and found.range_of(0)[0] < 0.05 < 0.95 < found.range_of(0)[1]


def test_a_flat_likelihood_gives_the_prior():
    found = sample(lambda places: np.zeros(len(places)), 2)
    assert [high - low for low, high in map(found.range_of, (0, 1))] == pytest.approx([0.95, 0.95], abs=0.01)
    assert abs(found.correlation[0, 1]) < 0.01


def test_the_shortest_range_holds_its_mass_and_reaches_an_edge():
    values, weights = np.linspace(0, 5, 20001), np.exp(-np.linspace(0, 5, 20001))
    low, high = shortest(values, weights / weights.sum())
    assert low == pytest.approx(0.0, abs=1e-3) and high == pytest.approx(-np.log(1 - 0.95 * (1 - np.exp(-5))), abs=1e-2)


def test_leave_one_out_is_that_of_fits_without_the_point():
    places = sobol(8, 1, 1)
    values, noise = np.sin(3 * places[:, 0]), np.full(8, 1e-4)
    whole = emulate(places, values, noise)
    others = np.arange(8) != 3
    kernel = whole.process.kernel_(places) + np.diag(whole.process.alpha)
    y = (values - whole.centre) / whole.scale
    told = kernel[3, others] @ np.linalg.solve(kernel[np.ix_(others, others)], y[others])
    assert whole.left_out[3] == pytest.approx(whole.scale * (y[3] - told), rel=1e-6)


def f(u):
    return {"a": 10 * u[..., 0] + 3 * u[..., 1] ** 2, "b": 2 * u[..., 0] - 4 * u[..., 1]}


SCATTER, ERROR = {"a": 0.4, "b": 0.2}, 0.1


def measured(truth, rng):
    """An experiment: one start, and an error of measurement."""
    return [
        number(name, one + SCATTER[name] * rng.normal() + ERROR * rng.normal(), ERROR) for name, one in f(truth).items()
    ]


def twins(pools, each, points=12, starts=2):
    """Share of twins whose truth lies in the 95 % range, and widths of the ranges, shape (twins, 2)."""
    inside, widths = [], []
    for seed in range(pools):
        rng = np.random.default_rng(seed)
        places = sobol(points, 2, seed)
        values = {name: one[:, None, None] + SCATTER[name] * rng.normal(size=(points, starts, 1))
                  for name, one in f(places).items()}  # fmt: skip
        model = model_of(places, measured(np.array([0.5, 0.5]), rng), values)
        for _ in range(each):
            truth = rng.random(2)
            own = np.concatenate(
                [part.into(one.measured) for part, one in zip(model.parts, measured(truth, rng), strict=True)]
            )
            found = sample(replace(model, measured=own).log_likelihood, 2)
            ranges = [found.range_of(k) for k in (0, 1)]
            inside.append([low <= one <= high for (low, high), one in zip(ranges, truth, strict=True)])
            widths.append([high - low for low, high in ranges])
    return np.mean(inside, axis=0), np.array(widths)


def coverage(pools, each):
    inside, widths = twins(pools, each)
    # four standard errors of a share of 0.95 among the twins, if all were independent
    apart = 4 * np.sqrt(0.95 * 0.05 / (pools * each))
    assert (np.abs(inside - 0.95) < apart).all(), inside
    # what the scatter of one experiment allows: of a straight model, by its inverse
    slopes, noise = np.array([[10, 3], [2, -4]]), np.array([SCATTER["a"], SCATTER["b"]]) ** 2 + ERROR**2
    best = 2 * norm.ppf(0.975) * np.sqrt(np.diag(np.linalg.inv(slopes.T @ np.diag(1 / noise) @ slopes)))
    assert (widths.mean(axis=0) < 1.6 * best).all() and (widths.mean(axis=0) > 0.9 * best).all(), widths.mean(0) / best


def test_the_truth_is_in_the_range_of_95_percent_of_twins():
    coverage(pools=2, each=14)


@pytest.mark.long
def test_the_truth_is_in_the_range_of_95_percent_of_many_twins():
    coverage(pools=20, each=25)


def test_scatter_that_goes_together_is_one_piece_of_news():
    """Two targets that are the same number, off together: the second one tells nothing new."""
    rng = np.random.default_rng(0)
    places = sobol(24, 1, 1)
    values = 10 * places[:, :1] + 0.4 * rng.normal(size=(24, 2))
    twice = {"a": values[..., None], "b": values[..., None] + 1e-3 * rng.normal(size=(24, 2, 1))}
    one = model_of(places, [number("a", 5, 0.01)], {"a": twice["a"]})
    both = model_of(places, [number("a", 5, 0.01), number("b", 5, 0.01)], twice)
    alone, together = (np.subtract(*reversed(sample(m.log_likelihood, 1).range_of(0))) for m in (one, both))
    # 0.71 of it for two independent ones; 8 % of what goes together is left out, and emulators' errors do not
    assert together > 0.8 * alone


def test_one_start_takes_what_no_smooth_curve_explains_for_the_scatter():
    rng = np.random.default_rng(3)
    places = sobol(32, 1, 1)
    values = {"a": (10 * places + 0.4 * rng.normal(size=(32, 1)))[:, :, None]}
    found = model_of(places, [number("a", 5, 0.1)], values)
    assert found.freedom == 0
    # 30 degrees of freedom: 13 % standard error
    assert np.sqrt(found.scatter[0, 0]) == pytest.approx(0.4, rel=0.4)


def test_a_curve_is_a_few_numbers_and_its_twin_is_found():
    rng = np.random.default_rng(5)
    at, places = np.linspace(0, 1, 30), sobol(16, 2, 2)

    def curve(u):
        return u[..., 0, None] * np.exp(-3 * at) + u[..., 1, None] * at**2

    values = curve(places)[:, None] + 0.02 * rng.normal(size=(16, 2, 30))
    truth = np.array([0.3, 0.7])
    target = Target("heap.depth", curve(truth) + 0.02 * rng.normal(size=30), np.full(30, 0.01), "x", at)
    model = model_of(places, [target], {"heap.depth": values})
    assert 2 <= len(model.measured) <= 4
    found = sample(model.log_likelihood, 2)
    for k in (0, 1):
        low, high = found.range_of(k)
        assert low <= truth[k] <= high and high - low < 0.2
    inside, sd = model.target_at(0, truth[None])
    assert np.abs(inside[0] - curve(truth)).max() < 0.05 and sd.shape == (1, 30)
