# SPDX-License-Identifier: GPL-2.0-or-later
"""The test for a steady flow: how often it stops wrongly, and that it stops at all."""

import numpy as np
import pytest

from lammps_jump.runs.steady import SteadyDetector, drift_of, flow_state

STEP, WINDOW = 0.1, 10.0


def noise(random, samples, correlation, size):
    """AR(1) series of standard deviation `size`, correlation a sample apart."""
    series = np.empty(samples)
    series[0] = random.standard_normal()
    for i in range(1, samples):
        series[i] = correlation * series[i - 1] + np.sqrt(1 - correlation**2) * random.standard_normal()
    return size * series


def stops(random, *, drift, correlation, size, windows=3.0):
    """Whether a detector stops within `windows` windows of a depth that drifts by `drift` a window."""
    samples = int(windows * WINDOW / STEP)
    time = STEP * np.arange(samples)
    depth = 1.0 + drift * time / WINDOW + noise(random, samples, correlation, size)
    detector = SteadyDetector(WINDOW)
    return any(detector.feed(t, value, 1.0, 5.0) for t, value in zip(time, depth, strict=True))


@pytest.mark.parametrize(
    ("correlation", "size"),
    [pytest.param(0.0, 0.03, marks=pytest.mark.long), pytest.param(0.8, 0.01, marks=pytest.mark.long), (0.95, 0.006)],
)
def test_false_stop_rate(correlation, size):
    random = np.random.default_rng(20261121)
    runs = 400
    # the drift is just what is not allowed: each look may err in 5 % of cases, and two in a row are needed; the
    # relative tolerance and correlations the batches do not show leave some more: 5 % of 400 plus three sigmas is 33
    wrong = sum(stops(random, drift=0.0205, correlation=correlation, size=size) for _ in range(runs))
    assert wrong <= 33, f"{wrong} false stops of {runs}"


def test_a_strong_drift_never_stops_it():
    random = np.random.default_rng(3)
    assert not any(stops(random, drift=0.1, correlation=0.8, size=0.01) for _ in range(200))


def test_a_steady_record_is_found():
    random = np.random.default_rng(4)
    found = sum(stops(random, drift=0.0, correlation=0.5, size=0.006) for _ in range(100))
    assert found >= 90  # margin 0.6 %, standard error 0.4 %: the tolerance of 2 % is 3.5 standard errors beyond


def test_noise_alone_is_no_proof():
    random = np.random.default_rng(5)
    # 20 % of noise cannot show a drift of less than 2 %: a test that only looks for trends would stop nearly always
    assert sum(stops(random, drift=0.0, correlation=0.8, size=0.2) for _ in range(100)) == 0


def test_every_quantity_counts():
    detector = SteadyDetector(WINDOW)
    for i in range(400):
        assert not detector.feed(STEP * i, 1.0, 1.0, 10.0 - 0.1 * STEP * i)  # the toe walks 1 m a window
    assert detector.looks > 4
    assert detector.drifts["toe"].drift == pytest.approx(-1.0, rel=0.02)  # one sample in a hundred more or less


def test_a_toe_that_comes_and_goes_is_never_steady():
    detector = SteadyDetector(WINDOW)
    assert not any(detector.feed(STEP * i, 1.0, 1.0, float("nan") if i % 50 else 5.0) for i in range(400))


def test_without_a_toe_depth_and_discharge_are_enough():
    detector = SteadyDetector(WINDOW)
    assert any(detector.feed(STEP * i, 1.0, 1.0, float("nan")) for i in range(400))
    assert "without a jump" in detector.reason and "toe" not in detector.reason
    rising = SteadyDetector(WINDOW)
    assert not any(rising.feed(STEP * i, 1.0 + 0.01 * STEP * i, 1.0, float("nan")) for i in range(400))


def test_a_discharge_near_zero_is_measured_against_the_inflow():
    random = np.random.default_rng(6)
    ripple = noise(random, 400, 0.5, 0.01)
    for drift, inflow, steady in ((0.0, 0.0, False), (0.0, 6.0, True), (0.5, 6.0, False)):  # m^2/s a window, m^2/s
        detector = SteadyDetector(WINDOW, inflow)
        fed = [detector.feed(STEP * i, 1.0, q + drift * STEP * i / WINDOW, 5.0) for i, q in enumerate(ripple)]
        assert any(fed) is steady


def test_constant_series_stop_with_a_reason():
    detector = SteadyDetector(WINDOW)
    times = [STEP * i for i in range(400) if detector.feed(STEP * i, 2.0, 3.0, 4.0)]
    assert times[0] == pytest.approx(1.5 * WINDOW, abs=2 * STEP)  # first look after a window, second half one later
    assert "depth" in detector.reason and "t tests" in detector.reason


def test_drift_of_a_line_is_exact():
    found = drift_of(np.linspace(0.0, 1.0, 161)[1:] - 1 / 320)
    assert found.drift == pytest.approx(1.0, rel=1e-12)
    assert found.margin < 1e-12
    assert drift_of(np.ones(10)).margin == float("inf")


@pytest.mark.parametrize(("batches", "quantiles"), [(16, (1.7613, 2.1448)), (12, (1.8125, 2.2281))])
def test_margin_grows_with_students_quantile(batches, quantiles):
    """Tables of t at 95 % and 97.5 %, for the degrees of freedom of the fit."""
    noise = np.random.default_rng(1).standard_normal(10 * batches)
    narrow, wide = (drift_of(noise, confidence, batches).margin for confidence in (0.95, 0.975))
    assert wide / narrow == pytest.approx(quantiles[1] / quantiles[0], rel=1e-4)


def test_window_must_be_a_length():
    with pytest.raises(ValueError, match="above 0"):
        SteadyDetector(0.0)


def test_flow_state_of_a_step():
    # 1 m deep up to x = 6, 3 m beyond; discs of 0.01 m^2, all at 2 m/s
    shallow = np.repeat(np.arange(0.05, 6.0, 0.1), 10)
    deep = np.repeat(np.arange(6.05, 10.0, 0.1), 30)
    x = np.concatenate([shallow, deep])
    depth, discharge, toe = flow_state(x, np.full(len(x), 2.0), 10.0, 1000.0, (0.0, 10.0), bins=100)
    assert depth == pytest.approx(0.6 * 1 + 0.4 * 3, rel=1e-12)
    assert discharge == pytest.approx(2 * depth, rel=1e-12)
    assert toe == pytest.approx(6.0, abs=0.15)  # bins of 0.1 m, smoothed over three
    # half of the discs, each of twice the mass
    assert flow_state(x[::2], np.full(len(x) // 2, 2.0), 10.0, 1000.0, (0.0, 10.0), 100, np.full(len(x) // 2, 2.0)) == (
        pytest.approx(depth),
        pytest.approx(discharge),
        pytest.approx(toe),
    )
    assert np.isnan(flow_state(shallow, np.ones(len(shallow)), 10.0, 1000.0, (0.0, 6.0), bins=60)[2])
