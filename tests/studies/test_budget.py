# SPDX-License-Identifier: GPL-2.0-or-later
"""Budgets of error: what each choice adds, which do not apply, and the sum against choices that are drawn at once."""

import json
from functools import cache

import numpy as np
import pytest
from made_up import BOX, INPUTS, call

from lammps_jump import load_case
from lammps_jump.errors import CaseError
from lammps_jump.studies import budget as budgets
from lammps_jump.studies import points as points_study
from lammps_jump.studies.points import FAILED

SIGMA = 0.03


@cache
def planned():
    """The budget of a coarse jump; it builds a dozen scenes, so tests share it."""
    case = load_case(INPUTS / "quick_jump.yaml", {"discs.diameter": 0.3})
    return budgets.plan_budget(case, "jump.y2", budgets.Design(starts=40, each=30, joint=200))


def log_share(changes, path, middle):
    return np.log(changes.get(path, middle) / middle) / np.log(1.25)


def measured(plan, weights, rng):
    """What the points of a budget find where a number is a sum of its choices, in units of their half ranges."""
    path = plan.of.path

    def value(changes, look):
        found = 3.0 + weights.get("step", 0) * log_share(changes, "run.time_step_fraction", 0.1)
        found += weights.get("size", 0) * log_share(changes, "discs.diameter", 0.3)
        found += weights.get("walls", 0) * log_share(changes, "contact.stiffness_wall", plan_walls)
        return found + weights.get("fit", 0) * np.log(look.get("stretch", 1.0)) / np.log(1.25)

    plan_walls = plan.case.scene().coefficients.stiffness_wall
    found = {}
    for point in plan.points:
        ones = found.setdefault(point.name, [])
        for noise in rng.normal(0, SIGMA, point.starts):
            looks = {name: {path: value(point.changes, look) + noise} for name, look in point.options["looks"].items()}
            ones.append({"numbers": {path: value(point.changes, {}) + noise}, "looks": looks, "outcome": "jump"})
    return found


def rows_of(data):
    return {row["key"]: row for row in data["rows"]}


@pytest.mark.parametrize("weights", [{"step": 0.1, "size": 0.02, "fit": 0.05}, {"walls": 0.06}, {}])
def test_parts_are_found_and_their_sum_is_the_scatter_of_joint_draws(weights):
    """Known parts come out within four standard errors; the joint draws differ from the sum by as little."""
    plan = planned()
    data = budgets.results_of(plan, measured(plan, weights, np.random.default_rng(5)), {})
    rows = rows_of(data)
    for key, row in rows.items():
        true = SIGMA if key == "starts" else weights.get(key, 0.0)
        if row["variance"] is not None:
            assert abs(row["variance"] - true**2) <= 4 * row["variance_error"] + 1e-12, key
            assert (
                key == "starts" or budgets.is_seen(row) == (true > 0.01) or row["variance"] < 4 * row["variance_error"]
            )
    assert abs(data["joint"]["errors_apart"]) < 3
    true_sum = np.sqrt(SIGMA**2 + sum(weight**2 for weight in weights.values()))
    assert data["joint"]["deviation"] == pytest.approx(true_sum, rel=4 / np.sqrt(400))
    assert data["whole_interval"] >= data["interval"]
    for key in ("window", "bins", *([] if "fit" in weights else ["fit"])):
        assert rows[key]["variance"] is None and "to the last digit" in rows[key]["reason"]
    biggest = max(weights, key=weights.get, default="starts")
    assert budgets.largest_of(data["rows"])["key"] == biggest and rows[biggest]["label"] in data["verdict"]


def test_what_is_not_seen_is_a_bound_and_no_zero():
    plan = planned()
    text = budgets.page_of(budgets.results_of(plan, measured(plan, {}, np.random.default_rng(1)), {}))
    (line,) = [line for line in text[2].splitlines() if line.startswith("| disc diameter")]
    assert "below 0." in line or float(line.split("|")[4]) > 0, line


def test_noise_of_starts_is_taken_off():
    """The mean of the estimates over many draws is the true variance, where both sides have few starts."""
    rng, effect = np.random.default_rng(2), 0.5
    found = [
        budgets.spread_of(rng.normal(-effect, 1, 4), rng.normal(effect, 1, 4), paired=False)["effect"] ** 2 - 1 / 8
        for _ in range(4000)
    ]
    assert np.mean(found) == pytest.approx(effect**2, abs=5 * np.std(found) / np.sqrt(4000))


COARSE = {"discs.diameter": 0.3}
SIZES = {"discs.sizes": {"kind": "list", "diameters": [0.2, 0.4], "shares": [0.5, 0.5]}}


@pytest.mark.parametrize(
    ("scene", "changes", "absent"),
    [
        ("energy_box_16", {}, {"size": "one by one"}),
        (
            "quick_jump",
            COARSE | {"run.accuracy": "5%"} | SIZES,
            {"step": "run.accuracy", "size": "the diameters"},
        ),
    ],
)
def test_parts_that_do_not_apply_have_a_reason(scene, changes, absent):
    parts = {part.key: part for part in budgets.parts_of(load_case(INPUTS / f"{scene}.yaml", changes), 1.25)}
    assert list(parts) == ["step", "stiffness", "size", "walls", "window", "bins", "fit"]
    assert {key for key, part in parts.items() if part.reason} == set(absent)
    assert all(text in parts[key].reason for key, text in absent.items())
    assert all(len(part.sides) == 2 for part in parts.values() if not part.reason)


def test_a_step_at_its_limit_is_made_finer_alone():
    case = load_case(INPUTS / "energy_box_16.yaml", {"run.time_step_fraction": 0.5})
    step = budgets.parts_of(case, 1.25)[0]
    tried = [side["run.time_step_fraction"] for side in step.sides]
    assert not step.reason and tried[1] / tried[0] == pytest.approx(1.25**2) and tried[1] == 0.5


def test_runs_that_fail_are_a_reason_and_too_few_numbers_an_error():
    plan = planned()
    found = measured(plan, {}, np.random.default_rng(1))
    found["size upper"] = [{FAILED: "the discs left"}] * 30
    row = rows_of(budgets.results_of(plan, found, {}))["size"]
    assert row["variance"] is None and "the discs left" in row["reason"]
    found["base"] = [{FAILED: "the discs left"}] * 4
    with pytest.raises(CaseError, match=r"0 of 4 starts .* the discs left"):
        budgets.results_of(plan, found, {})


@pytest.mark.parametrize(
    ("of", "said"), [("jump.y9", "has no number 'y9'"), ("cpu_seconds", "no number of an analysis"), ("x.y", "no 'x'")]
)
def test_a_number_that_is_not_there_is_refused(of, said, monkeypatch, capsys, tmp_path):
    status, _, told = call(
        monkeypatch, capsys, "budget", INPUTS / "quick_jump.yaml", "--of", of, "--out", tmp_path / "o"
    )
    assert status == 2 and said in told and not (tmp_path / "o").exists()


def test_a_number_that_no_run_has_is_refused_before_the_first_run(monkeypatch, capsys, tmp_path):
    """An analysis that finds nothing in the scene: neither a budget nor a pilot is run for it."""
    jump, out = INPUTS / "quick_jump.yaml", tmp_path / "o"
    status, _, told = call(monkeypatch, capsys, "budget", jump, "--of", "drum.angle", "--out", out)
    assert status == 2 and "no run of the case has it: no wall turns" in told and not out.exists()
    monkeypatch.chdir(tmp_path)
    status, _, told = call(monkeypatch, capsys, "check", jump, "--of", "drum.angle", "--pilot", "3")
    assert status == 2 and "--of drum.angle: no run of the case has it: no wall turns" in told
    assert not list(tmp_path.iterdir())


def test_a_packed_bed_has_discs_of_other_sizes():
    """Beds of any packing are made with smaller and larger discs; a lattice is not."""
    case = {
        "name": "bed", "discs": {"diameter": 0.1}, "run": {"duration": 1},
        "contact": {"stiffness": 1e6, "restitution": 0.5},
        "walls": [{"kind": "box", "name": "box", "x": [0, 3], "y": [0, 2]}],
        "domain": {"x": [-1, 4], "y": [-1, 3]},
    }  # fmt: skip
    for packing in (0.4, 0.7):
        bed = {"kind": "packed_bed", "x": [0, 3], "y": [0, 1], "packing": packing}
        size = {part.key: part for part in budgets.parts_of(load_case(case | {"initial": [bed]}), 1.25)}["size"]
        assert not size.reason and [*size.settings] == ["0.08", "0.125"]
    lattice = {"kind": "lattice", "nx": 3, "ny": 3, "spacing": 0.2, "origin": [0.5, 0.5]}
    (size,) = (one for one in budgets.parts_of(load_case(case | {"initial": [lattice]}), 1.25) if one.key == "size")
    assert "as a lattice" in size.reason


@pytest.mark.long
def test_a_budget_of_a_box_of_discs_is_kept_and_shown(tmp_path, monkeypatch, capsys):
    case = load_case(BOX)
    told = []
    how = {"starts": 2, "each": 2, "joint": 2, "say": told.append}
    data = budgets.budget(case, "energy.max_deviation", tmp_path / "out", **how)
    rows = rows_of(data)
    assert rows["size"]["reason"] and rows["step"]["variance"] is not None and len(told) == data["runs"] + 1
    stored = json.loads((tmp_path / "out" / "budget.json").read_text())
    assert stored["verdict"] == data["verdict"] and "energy.max_deviation" in (tmp_path / "out/budget.html").read_text()
    monkeypatch.setattr(points_study, "Pool", None)
    with pytest.raises(TypeError):
        budgets.budget(case, "energy.max_deviation", tmp_path / "out", **how)
