# SPDX-License-Identifier: GPL-2.0-or-later
"""Statistics over members: against scipy, with members that have no number, and against errors of single runs."""

import csv
import subprocess
import sys

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from lammps_jump.dump.exports import csv_text
from lammps_jump.sweeps.table import members_needed, number_at, statistics

NAN = float("nan")


def test_the_interval_is_students():
    values = np.random.default_rng(1).normal(3, 0.5, 6)
    found = statistics(values, [NAN] * 6, 0.9)
    low, high = stats.t.interval(0.9, 5, values.mean(), stats.sem(values))
    assert (found["low"], found["high"]) == pytest.approx((low, high), rel=1e-12)
    assert found["sd"] == pytest.approx(values.std(ddof=1)) and found["n"] == 6
    assert np.isnan([found["own_error"], found["chi2"]]).all()


def test_intervals_cover_the_truth_as_often_as_they_say():
    random = np.random.default_rng(2)
    found = [statistics(random.normal(1, 2, 4), [NAN] * 4, 0.95) for _ in range(2000)]
    inside = sum(one["low"] <= 1 <= one["high"] for one in found)
    assert abs(inside - 1900) < 4 * np.sqrt(2000 * 0.95 * 0.05)


def test_members_without_the_number_are_left_out():
    found = statistics([1.0, NAN, 3.0], [0.1, 0.2, 0.1], 0.95)
    assert (found["mean"], found["n"]) == (2.0, 2)
    alone = statistics([1.0], [0.1], 0.95)
    assert alone["n"] == 1 and np.isnan([alone["sd"], alone["low"], alone["chi2"]]).all()
    assert statistics([], [], 0.95)["n"] == 0


def test_chi2_compares_members_with_their_own_errors():
    random = np.random.default_rng(3)
    right = np.mean([statistics(random.normal(0, 0.3, 8), [0.3] * 8, 0.95)["chi2"] for _ in range(1000)])
    small = np.mean([statistics(random.normal(0, 0.3, 8), [0.1] * 8, 0.95)["chi2"] for _ in range(1000)])
    # the mean of 1000 values of chi2/7, each with a deviation of sqrt(2/7)
    assert right == pytest.approx(1, abs=0.07) and small == pytest.approx(9, abs=0.63)


def test_numbers_that_mean_nothing_beside_their_verdict_are_none():
    summary = {"jump": {"verdict": "no jump found", "y2": 3.0, "toe": 2.0, "drift": {"y2": 0.1}}, "steps": 7}
    assert np.isnan(number_at(summary, "jump.y2")) and number_at(summary, "jump.toe") == 2.0
    assert number_at(summary, "jump.drift.y2") == 0.1 and number_at(summary, "steps") == 7
    assert np.isnan(number_at(summary, "jump.tail.y2")) and np.isnan(number_at(summary, "jump.verdict"))
    assert number_at({"jump": {"verdict": "jump", "y2": 3.0}}, "jump.y2") == 3.0


def test_members_needed_go_with_the_square_of_the_width():
    found = {"mean": -2.0, "high": -1.8, "n": 4.0}
    assert members_needed(found, 0.05) == 16 and members_needed(found, 0.2) == 4
    assert members_needed({"mean": 0.0, "high": 0.1, "n": 4.0}, 0.05) is None
    assert members_needed({"mean": 2.0, "high": NAN, "n": 1.0}, 0.05) == 4  # a first interval


def test_intervals_are_those_of_scipy_stats_which_is_not_loaded():
    for n in (2, 3, 8, 32):
        found = statistics(range(n), [NAN] * n, 0.95)
        assert found["high"] == found["mean"] + stats.t.ppf(0.975, n - 1) * found["se"]
    code = "import sys; from lammps_jump.sweeps.table import statistics; statistics([1, 2], [1, 1], 0.95)"
    done = subprocess.run([sys.executable, "-c", f"{code}; sys.exit('scipy.stats' in sys.modules)"])
    assert done.returncode == 0


@pytest.mark.fault("text as a command")
def test_no_text_of_a_table_is_a_formula_for_a_spreadsheet():
    attack = '=HYPERLINK("http://x","y")'
    table = pd.DataFrame([[attack, 1e-17, attack], ["-5", -0.1, "+1\n=2"]], columns=["@a", "number", "@a"])
    found = list(csv.reader(csv_text(table).splitlines()))
    assert found == [["'@a", "number", "'@a"], [f"'{attack}", "1e-17", f"'{attack}"], ["-5", "-0.1", "'+1 =2"]]
