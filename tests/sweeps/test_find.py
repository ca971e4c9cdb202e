# SPDX-License-Identifier: GPL-2.0-or-later
"""`find`: a known answer, ranges that do not hold it, what is refused before anything is run, and going on."""

import json

import numpy as np
import pytest
import yaml
from made_up import BOX, call

import lammps_jump as lj
from lammps_jump.analysis.budgets.inflow import shortfall
from lammps_jump.errors import CaseError
from lammps_jump.sweeps.crossing import CrossingPlace
from lammps_jump.sweeps.find import (
    RootProblem,
    SearchedPlaces,
    answer_of,
    parse_condition,
    read_find,
    search_for,
    sentence_of,
    write_answer,
)

pytestmark = pytest.mark.usefixtures("kept_workers")

QUICK = {**BOX, "run": {**BOX["run"], "duration": 0.05, "output_interval": 0.01}}
ENERGY = "energy.initial"
"""Of discs in a box, before any contact stores some: one of them moves at (6, 5) m/s, rho d^2 v^2/2 = 1.22 rho J/m."""
KNOWN = {"vary": {"discs.density": (400.0, 1600.0)}, "until": f"{ENERGY} >= 1220", "members": 2, "budget": 12}


def written(folder):
    return {str(path): path.stat().st_mtime_ns for path in (folder / "points" / "runs").rglob("dump*")}


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    folder = tmp_path_factory.mktemp("find") / "box"
    return folder, lj.find(QUICK, out=folder, jobs=1, **KNOWN)


def test_a_known_answer_is_found_and_told(done):
    folder, found = done
    assert found["held"] and found["value"] == pytest.approx(1000.0, rel=1e-3) and found["holds"] == "above"
    assert found["low"] <= 1000.0 <= found["high"] and found["reason"] is None
    assert found["runs"] == 12 and len(found["points"]) == 6 and not found["failures"]
    page = (folder / "find.html").read_text()
    assert found["verdict"] in page.replace("&gt;", ">") and (folder / "figures" / "find.png").is_file()
    assert json.loads((folder / "find.json").read_text()) == found


def test_the_same_command_runs_nothing_again_and_a_larger_budget_goes_on(done):
    folder, found = done
    before = written(folder)
    assert lj.find(folder, jobs=1) == found and written(folder) == before
    more = lj.find(folder, jobs=1, budget=14)
    assert more["runs"] == 14 and before.items() <= written(folder).items()


def test_the_folder_of_a_search_opens_as_the_study_of_its_runs(done, monkeypatch, capsys):
    folder, found = done
    assert lj.open(folder).folder == folder / "points" and len(lj.open(folder).runs) >= found["runs"]
    assert call(monkeypatch, capsys, "show", folder) == (0, f"{folder / 'find.html'}\n", "")


def test_a_seed_gives_other_starts_and_one_leads_to_other_starts_at_each_point():
    """Ten searches of a case differ; no start of a search is used at two of its places."""
    seeds = []
    for seed in (1, 1001):
        study = read_find(QUICK, vary=KNOWN["vary"], until=KNOWN["until"], members=3, seed=seed).study([400.0, 700.0])
        seeds.append(set(study.fields.members))
    assert seeds == [{1, 2, 3}, {1001, 1002, 1003}]
    with pytest.raises(CaseError, match="seed"):
        read_find(QUICK, vary=KNOWN["vary"], until=KNOWN["until"], seed=-1)


def test_a_range_that_does_not_hold_it_ends_after_three_points(tmp_path, monkeypatch, capsys):
    (tmp_path / "box.yaml").write_text(yaml.safe_dump(QUICK))
    asked = ("--vary", "discs.density=400:800", "--until", f"{ENERGY} >= 1220", "--members", "1", "--jobs", "1")
    status, out, _ = call(monkeypatch, capsys, "find", tmp_path / "box.yaml", *asked, "--out", tmp_path / "o", "-q")
    assert status == 1 and "does not hold it" in out and "488" in out and "976" in out
    found = json.loads((tmp_path / "o" / "find.json").read_text())
    assert not found["held"] and found["value"] is None and found["runs"] == 3


def test_a_number_that_no_run_has_ends_after_three_points_with_the_reason_of_a_run(tmp_path):
    wall = {"name": "far", "kind": "block", "x": [20, 21], "y": [0, 1]}
    case = {**QUICK, "walls": [*QUICK["walls"], wall], "domain": {"x": [-1, 22], "y": [-1, 14]}}
    case["probes"] = {"stability": {"far": {"density": 2000, "friction": 0.5}}, "interval": 0.01}
    asked = {"vary": {"gravity": (1.0, 9.0)}, "until": "stability.far.sliding_factor_least >= 1", "members": 1}
    found = lj.find(case, out=tmp_path / "out", jobs=1, **asked)
    assert not found["held"] and found["runs"] == 3 and "No value of gravity with" in found["verdict"]
    assert "at 1, seed 1: it has no stability.far.sliding_factor_least: nothing pushes it" in found["reason"]


def test_a_study_file_says_the_same(tmp_path):
    (tmp_path / "box.yaml").write_text(yaml.safe_dump(QUICK))
    study = {"case": "box.yaml", "find": {"vary": {"discs.density": [400, 1600]}, "until": KNOWN["until"]}}
    (tmp_path / "study.yaml").write_text(yaml.safe_dump(study))
    read = read_find(tmp_path / "study.yaml", budget=9)
    assert (read.path, read.room, read.key, read.sign, read.number) == (
        "discs.density", (400.0, 1600.0), ENERGY, ">=", 1220.0,
    )  # fmt: skip
    assert (read.members, read.budget) == (3, 9) and read.rounded(712.34567891) == pytest.approx(712.35, abs=0.01)


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("jump.y2 >= 6.7", ("jump.y2", ">=", 6.7)), ("jump.y2>=6.7", ("jump.y2", ">=", 6.7)),
        ("jump.y2 ≤ 1e3", ("jump.y2", "<=", 1e3)), ("force.sill.peak < 2", ("force.sill.peak", "<=", 2.0)),
    ],
)  # fmt: skip
def test_conditions(text, found):
    read = parse_condition(text)
    assert (read.key, read.sign, read.number("")) == found


@pytest.mark.parametrize("text", ["jump.y2", ">= 3", ""])
def test_other_conditions_are_refused(text):
    with pytest.raises(CaseError, match=r"--until .*: expected a number of summary\.json, >= or <=, and a value"):
        parse_condition(text)


def test_an_equal_sign_is_answered_by_what_to_write():
    with pytest.raises(CaseError, match=r'write "jump.y2 >= 0.3 m" where more is wanted, or "jump.y2 <= 0.3 m"'):
        parse_condition("jump.y2 = 0.3 m")


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [("b.slid_by <= 30 cm", "m", 0.3), ("b.moment >= 24.7 kN m/m", "N m/m", 24700.0), ("b.c >= 95 %", "", 0.95)],
)
def test_the_limit_of_a_condition_may_have_a_unit(text, unit, value):
    assert parse_condition(text).number(unit) == pytest.approx(value, rel=1e-12)


@pytest.mark.parametrize(("value", "why"), [("3 s", "is in second"), ("much", "is not one number"), ("nan", "nan")])
def test_a_limit_of_another_dimension_is_refused(value, why):
    with pytest.raises(CaseError, match=f"--until b.slid_by >= {value}.*{why}"):
        parse_condition(f"b.slid_by >= {value}").number("m")


def sill(right):
    return {**QUICK, "walls": [*QUICK["walls"], {"name": "sill", "kind": "block", "x": [1, right], "y": [0, 0.3]}]}


@pytest.mark.parametrize(
    ("path", "text"),
    [
        ("walls.sill.x.1", "the end of the sill (walls.sill.x.1) above 1.5 m (95 %: 1.4 to 1.6 m). "
         "That is a width above 0.5 m (95 %: 0.4 to 0.6 m)."),
        ("walls.sill.x.0", "the start of the sill (walls.sill.x.0) above 1.5 m (95 %: 1.4 to 1.6 m). "
         "That is a width below 0.3 m (95 %: 0.2 to 0.4 m)."),
        ("walls.sill.y.1", "That is a height above 1.5 m (95 %: 1.4 to 1.6 m)."),
        ("discs.density", "the density (discs.density) above 1.5 kg/m³ (95 %: 1.4 to 1.6 kg/m³)."),
    ],
)  # fmt: skip
def test_an_edge_is_told_with_its_unit_and_as_a_width(path, text):
    """Where starts scatter, half of them may miss what the mean holds, and the sentence says so."""
    problem = RootProblem(lj.load_case(sill(1.8)), path, (1.0, 2.0), "energy.initial", ">=", 3.0, 3, 30)
    tried = {1.2: np.array([2.0, 2.2, 2.1]), 1.8: np.array([4.0, 4.1, 3.8])}
    said = sentence_of(problem, tried, CrossingPlace(1.5, 1.4, 1.6, rises=True), None)
    assert text in said and "about half of the starts may miss it. --share 95%" in said
    alike = sentence_of(problem, dict.fromkeys(tried, np.array([2.0, 2.0])), CrossingPlace(1.5, 1.4, 1.6), None)
    assert "half of the starts" not in alike


def test_a_width_is_answered_by_the_edges_of_the_block():
    with pytest.raises(CaseError, match=r"write walls.x \(\[left, right\]; x.1 is its right end"):
        read_find(sill(1.8), vary={"walls.sill.width": (0.1, 1.0)}, until=KNOWN["until"])


@pytest.mark.parametrize("sign", [">=", "<="])
def test_a_share_of_the_starts_is_found_with_its_range(sign):
    """Starts scatter by s about x: 95 % are above 1.2 where x is 1.2 + 1.645 s. Of 40 searches 35 or more hold it."""
    problem = RootProblem(lj.load_case(QUICK), "discs.density", (0.2, 2.2), ENERGY, sign, 1.2, 4, 40, 1, 0.95)
    s, held = 0.2, 0
    for seed in range(40):
        rng, tried = np.random.default_rng(seed), {}
        while (place := search_for(problem, tried).next_place(tried)) is not None:
            tried[place] = place + s * rng.standard_normal(4)
        found = answer_of(problem, tried)
        held += found.low <= 1.2 + (1 if sign == ">=" else -1) * 1.6449 * s <= found.high
    assert held >= 35, f"{held} of 40"


def test_a_share_needs_starts_and_is_kept_in_the_study():
    with pytest.raises(CaseError, match="--share: how starts scatter is needed"):
        read_find(QUICK, **{**KNOWN, "members": 1}, share="95%")
    assert yaml.safe_load(read_find(QUICK, **KNOWN, share="95 %").to_yaml())["find"]["share"] == 0.95


def test_a_search_says_where_the_inflow_fell_short(tmp_path):
    """Half of what was asked for went over the weir: the answer is not that of the discharge of the case."""
    weirs = [
        {"inflow": {"asked": 1.0, "delivered": 0.98}, "overtopping": {"weir": {"discharge": q}}} for q in (0.58, 0.67)
    ]
    ran = SearchedPlaces({400.0: np.array([488.0, 488.0]), 1600.0: np.array([1952.0, 1952.0])}, [], weirs)
    found = write_answer(read_find(QUICK, **KNOWN), tmp_path, ran)
    short = "in 2 of 2 runs: 1 m²/s asked for, 0.98 came in, 0.58 to 0.67 passed weir"
    assert short in found["notes"][0] and short in (tmp_path / "find.html").read_text()


@pytest.mark.parametrize(
    ("came", "over", "short"), [(1.0, 0.99, False), (0.98, None, True), (1.0, 0.9, True), (1.0, 1.3, False)]
)
def test_what_falls_short(came, over, short):
    """Within 5 %, or twice its error, of what is asked for is not short; nor where more goes over as it drains."""
    of_weir = {"discharge": over, "discharge_error": 0.01}
    found = {"inflow": {"asked": 1.0, "delivered": came}, "overtopping": {"weir": of_weir}}
    assert bool(shortfall([found])) == short and not shortfall([{"inflow": None}, {}])
    assert not shortfall([found | {"overtopping": {"weir": of_weir | {"discharge_error": 0.06}}}]) or came < 1


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"vary": None}, "no vary"),
        ({"until": None}, "no until"),
        ({"vary": {"discs.density": (800.0, 400.0)}}, "800 to 400 is no range"),
        ({"vary": {"discs.densty": (400.0, 800.0)}}, "densty"),
        ({"vary": {"discs.density": (-1.0, 800.0)}}, "discs.density"),
        ({"until": "energy.initail >= 3"}, "energy has no number 'initail'"),
        ({"until": "stability.tower.sliding_factor >= 3"}, "'tower' is no structure of the case"),
        ({"vary": {"run.seed": (1.0, 9.0)}}, "run.seed: takes whole numbers alone.*sweep --axis"),
        ({"budget": 2}, "budget"),
    ],
)
def test_what_cannot_be_found_is_refused_before_anything_is_made(tmp_path, change, message):
    with pytest.raises(CaseError, match=message):
        lj.find(QUICK, out=tmp_path / "out", **{**KNOWN, **change})
    assert not (tmp_path / "out").exists()
