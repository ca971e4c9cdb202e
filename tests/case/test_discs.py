# SPDX-License-Identifier: GPL-2.0-or-later
"""Curves of sizes: fields, what discs are drawn, what `check` prints and doubts, the report, members, begun runs."""

from __future__ import annotations

import json

import numpy as np
import pytest
import yaml
from made_up import some_long
from scipy.stats import norm

from lammps_jump.analysis.grains.sizes import curve_of, drawn
from lammps_jump.case import parse_case
from lammps_jump.case.discs import WIDEST
from lammps_jump.case.fields import CaseFields
from lammps_jump.errors import CaseError
from lammps_jump.runs.run import Case

CASE = """\
discs: {sizes: SIZES}
contact: {restitution: 0.2, impact_speed: 8}
walls: [{name: box, kind: box, x: [0, WIDTH], y: [0, 9]}]
initial: [{kind: column, x: [0, WIDTH], y: [0, 3], gate: false}]
run: {duration: 0.02, output_interval: 0.01}
engine: {name: native}
"""
SIEVE = "{kind: sieve, passing: [[0.06 m, 0 %], [0.1 m, 40 %], [0.2 m, 100 %]]}"
TABLES = {
    "uniform sand": "[[0.06, 0], [0.085, 10 %], [0.1, 35 %], [0.118, 70 %], [0.15, 95 %], [0.18, 100 %]]",
    "well graded gravel": "[[0.02, 0], [0.04, 12 %], [0.08, 30 %], [0.125, 51 %], [0.16, 65 %], [0.3, 100 %]]",
    "gap graded": "[[0.03, 0], [0.045, 30 %], [0.06, 40 %], [0.2, 40 %], [0.25, 75 %], [0.3, 100 %]]",
}
"""Passing by mass."""


def case(sizes=SIEVE, *changes, width=4):
    return parse_case(CASE.replace("SIZES", sizes).replace("WIDTH", str(width)), "sieved.yaml", changes)


# --- what is drawn ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("axis", ["linear", "log"])
@pytest.mark.parametrize("name", [some_long(name, name != "gap graded") for name in TABLES])
def test_the_drawn_discs_have_the_table_within_their_counting_error(name, axis):
    """At the sieves and between them, for a few hundred discs and for many."""
    sizes = case(f"{{kind: sieve, passing: {TABLES[name]}, axis: {axis}}}").scene().sizes
    table = np.array(yaml.safe_load(TABLES[name].replace(" %", "e-2")), float)
    middle = np.sqrt(table[:-1, 0] * table[1:, 0]) if axis == "log" else 0.5 * (table[:-1, 0] + table[1:, 0])
    at = np.concatenate([table[:, 0], middle])
    asked = np.concatenate([table[:, 1], 0.5 * (table[:-1, 1] + table[1:, 1])])
    assert sizes.passing(table[:, 0]) == pytest.approx(table[:, 1], abs=1e-12)
    assert sizes.passing(middle) == pytest.approx(asked[len(table) :], abs=1.1e-3)
    for count in (300, 3000, 100_000):
        d = sizes.diameters(np.arange(1, count + 1))
        found = np.array([(d[d <= one] ** 2).sum() for one in at]) / (d**2).sum()
        error = sizes.passing_error(at, count)
        assert (np.abs(found - asked) <= 2.0 * error + 1.1e-3 * (error > 0) + 1e-12).all(), (
            count,
            found - asked,
            error,
        )


DRAWN = {name: f"{{kind: sieve, passing: {table}, BY}}" for name, table in TABLES.items()}
DRAWN["log-normal"] = "{kind: log_normal, median: 0.1, spread: 1.5, BY}"


@pytest.mark.parametrize("by", ["mass", "number"])
@pytest.mark.parametrize("name", DRAWN)
def test_drawn_discs_have_the_curve_that_was_asked_as_it_was_asked(name, by):
    """By mass within its counting error; by number within 3/n: ids go through the quantiles evenly."""
    fields = case(DRAWN[name].replace("BY", f"by: {by}")).fields.discs.sizes
    ends, below = fields.ends()
    sizes = case(DRAWN[name].replace("BY", f"by: {by}")).scene().sizes
    for count in (300, 3000):
        d = sizes.diameters(np.arange(1, count + 1))
        weight = d**2 if by == "mass" else np.ones(count)
        found = np.array([weight[d <= one * (1 + 1e-12)].sum() for one in ends]) / weight.sum()
        error = 2.0 * sizes.passing_error(ends, count) if by == "mass" else 3.0 / count
        assert (np.abs(found - below) <= error + 1e-3).all(), (count, found - below)


@pytest.mark.parametrize("by", ["mass", "number"])
@pytest.mark.parametrize(
    ("spread", "cut"),
    [some_long(one, one != (1.7, 2.5)) for one in ((1.1, 2.5), (1.4, 2.5), (1.7, 2.5), (2.5, 1.5), (4, 1))],
)
def test_log_normal_sizes_are_normal_in_their_logarithm(by, spread, cut):
    sizes = case(f"{{kind: log_normal, median: 0.1, spread: {spread}, cut: {cut}, by: {by}}}").scene().sizes
    z = np.linspace(-cut, cut, 501)
    expected = (norm.cdf(z) - norm.cdf(-cut)) / (norm.cdf(cut) - norm.cdf(-cut))
    found = sizes.passing(0.1 * spread**z, 2 if by == "mass" else 0)
    assert found == pytest.approx(expected, abs=1.1e-3)
    assert (sizes.smallest, sizes.largest) == pytest.approx((0.1 * spread**-cut, 0.1 * spread**cut), rel=1e-12)


def test_by_number_the_shares_are_those_of_the_number():
    number, mass = (case(SIEVE[:-1] + f", by: {by}}}").scene().sizes for by in ("number", "mass"))
    at = [0.06, 0.1, 0.2]
    assert number.passing(at, 0) == pytest.approx([0, 0.4, 1], abs=1e-12)
    assert mass.passing(at) == pytest.approx([0, 0.4, 1], abs=1e-12)
    # shares of mass over the mean of d^2 in each, as integrals over 1/d^2: 1/0.06 - 1/0.1 and 1/0.1 - 1/0.2
    finer, coarser = 0.4 / 0.04 * (1 / 0.06 - 1 / 0.1), 0.6 / 0.1 * (1 / 0.1 - 1 / 0.2)
    assert mass.passing(0.1, 0) == pytest.approx(finer / (finer + coarser), rel=1e-3)


# --- the nominal diameter ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("sizes", "nominal"),
    [
        (SIEVE, 0.1 + 0.1 / 6),
        (SIEVE[:-1] + ", axis: log}", 0.1 * 2 ** (1 / 6)),
        (SIEVE[:-1] + ", by: number}", 0.1 + 0.1 / 6),
        ("{kind: log_normal, median: 12 cm, spread: 1.4}", 0.12),
        ("{kind: log_normal, median: 12 cm, spread: 1.4, by: number}", 0.12),
    ],
)
def test_the_nominal_diameter_is_d50(sizes, nominal):
    one = case(sizes)
    assert one.fields.discs.diameter == pytest.approx(nominal, rel=1e-3)
    scene = one.scene()
    assert scene.diameter == one.fields.discs.diameter and scene.smallest < scene.diameter < scene.largest
    again = parse_case(one.to_yaml())
    assert again.fields.discs.diameter == one.fields.discs.diameter and again.hash == one.hash


def test_a_diameter_that_is_given_stays_nominal():
    scene = case(SIEVE, "discs.diameter=0.08").scene()
    assert scene.diameter == 0.08 and scene.sizes.passing(0.1) == pytest.approx(0.4)
    with pytest.raises(
        CaseError, match=r"discs.diameter: 0.3 m is not in the curve of discs.sizes; allowed are 0.06 to 0.2"
    ):
        case(SIEVE, "discs.diameter=0.3")
    assert case(SIEVE, "discs.diameter=0.08", "discs.diameter=null").fields.discs.diameter == pytest.approx(0.116667)


def test_a_changed_curve_changes_the_nominal_diameter():
    first = case("{kind: log_normal, median: 0.1, spread: 1.3}")
    assert first.replace({"discs.sizes.median": 0.2}).fields.discs.diameter == pytest.approx(0.2)


# --- what cannot be ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("sizes", "said"),
    [
        ("{kind: sieve, passing: [[0.1, 40], [0.2, 100]]}", "40 is no share; write 40 % or 0.4"),
        (
            "{kind: sieve, passing: [[0.1, 40 %], [0.2, 90 %]]}",
            "90 % pass the coarsest sieve, 0.2 m, and nothing says how",
        ),
        ("{kind: sieve, passing: [[0.1, 0], [0.1, 1]]}", "openings must grow"),
        ("{kind: sieve, passing: [[0.1, 0], [0.2, 60 %], [0.3, 40 %], [0.4, 1]]}", "what passes must not fall"),
        ("{kind: sieve, passing: [[0.1, 1]]}", "discs.sizes.passing"),
        (
            "{kind: sieve, passing: [[0.01, 0], [0.2, 1]]}",
            "from 0.01 to 0.2 m, a ratio of 20; allowed is 16: leave out",
        ),
        ("{kind: sieve, passing: [[0.1, 0 kg], [0.2, 1]]}", "kg"),
        ("{kind: sieve, passing: [[0.1, 0], [0.2, 140 %]]}", "140 %.*out of range"),
        ("{kind: log_normal, median: 0.1, spread: 1.9}", r"allowed is 16: lower cut to 2.15 or less, or the spread"),
        ("{kind: log_normal, median: 0.1, spread: 0.2}", "0.2 is out of range; allowed is > 1"),
        ("{kind: log_normal, spread: 1.2}", "discs.sizes.median: is required"),
        ("{kind: sieve, pasing: [[0.1, 0], [0.2, 1]]}", "discs.sizes.pasing: unknown field.*passing"),
        ("{kind: uniform, spread: 0.2}", "discs.diameter: is required and not there"),
    ],
)
def test_curves_that_cannot_be_are_refused_with_the_remedy(sizes, said):
    with pytest.raises(CaseError, match=said):
        case(sizes)


def test_what_passes_the_finest_sieve_reaches_down_to_half_of_it_and_is_said():
    one = case("{kind: sieve, passing: [[0.06, 10 %], [0.1, 40 %], [0.2, 100 %]]}")
    assert one.scene().sizes.passing([0.03, 0.06]) == pytest.approx([0, 0.1], abs=1e-12)
    told = " ".join(one.scene().warnings)
    assert "10 % pass the finest sieve, 0.06 m; they are taken to lie between 0.03 and 0.06 m" in told
    assert "finest sieve" not in " ".join(case().scene().warnings)
    # several sieves that nothing passes: the last of them is where discs begin
    assert case("{kind: sieve, passing: [[0.01, 0], [0.06, 0], [0.2, 1]]}").scene().smallest == pytest.approx(0.06)


def test_the_widest_curve_packs():
    scene = case(f"{{kind: sieve, passing: [[{0.4 / WIDEST}, 0], [0.4, 1]]}}", width=3).scene()
    assert scene.largest / scene.smallest == pytest.approx(WIDEST) and len(scene.positions) > 500


# --- check -----------------------------------------------------------------------------------------------------------


def test_check_prints_the_curve_and_what_it_means_in_discs():
    found = Case.load(yaml.safe_load(CASE.replace("SIZES", SIEVE).replace("WIDTH", "4"))).check()
    numbers = found.numbers
    assert [numbers[key] for key in ("d10", "d50", "d90")] == pytest.approx(
        [0.07, 0.1 + 1 / 60, 0.1 + 5 / 60], rel=1e-6
    )
    assert numbers["uniformity"] == pytest.approx((0.1 + 1 / 30) / 0.07, rel=1e-6)
    assert numbers["curve_by"] == "by mass" and "nominal diameter, d50 by mass" in str(found)
    d = np.array(found.scene.diameters(np.arange(1, len(found.scene.positions) + 1)))
    assert numbers["finest_discs"] == pytest.approx((d <= 0.07).sum(), abs=2)
    assert numbers["coarsest_discs"] == pytest.approx((d > 0.1 + 5 / 60).sum(), abs=2)
    assert numbers["finest_share"] == pytest.approx((d <= 0.07).mean(), abs=2 / len(d))
    assert "d10" not in case("{kind: uniform, spread: 0.2}", "discs.diameter=0.1").scene().warnings


@pytest.mark.parametrize(("width", "doubted"), [(0.8, True), (4, False)])
def test_check_doubts_where_the_largest_discs_are_too_few(width, doubted):
    scene = case(width=width).scene()
    coarse = (scene.diameters(np.arange(1, len(scene.positions) + 1)) > 0.1 + 5 / 60).sum()
    told = [one for one in scene.warnings if "the coarsest tenth of the mass" in one]
    assert bool(told) == doubted and (coarse < 10) == doubted
    if told:
        assert "too few for the curve to be met there; 3.5e+02 discs hold 10 of them" in told[0]


# --- runs -----------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def ended(tmp_path_factory):
    """A run of a sieve curve on a rough bed, whose discs have a size of their own."""
    folder = tmp_path_factory.mktemp("sieved")
    monkeypatch = pytest.MonkeyPatch()
    monkeypatch.chdir(folder)
    given = yaml.safe_load(CASE.replace("SIZES", SIEVE).replace("WIDTH", "2"))
    given["walls"].append({"name": "bed", "kind": "rough", "from": [0.1, -0.08], "to": [1.9, -0.08], "diameter": 0.15})
    yield Case.load(given).run(folder / "bed"), given, folder
    monkeypatch.undo()


def test_the_report_shows_the_drawn_curve_beside_the_one_asked_for(ended):
    run, _, _ = ended
    found = run.summary["sizes"]
    scene = run.case.scene()
    discs = len(scene.positions) - scene.fixed.count
    assert found["discs"] == discs == scene.drawn_discs
    assert found["d50_asked"] == pytest.approx(0.1 + 1 / 60, rel=1e-3)
    assert found["difference"] < 2 * found["error"]
    d = np.sort(scene.diameters(np.arange(1, discs + 1)))
    assert found["d50"] == d[np.searchsorted(np.cumsum(d**2), 0.5 * (d**2).sum())]
    rows = np.genfromtxt(run.folder / "sizes.csv", delimiter=",", names=True)
    assert rows["asked"][0] == 0 and rows["drawn"][-1] == pytest.approx(1) and (np.diff(rows["drawn"]) >= 0).all()
    assert np.abs(rows["drawn"] - rows["asked"]).max() == pytest.approx(found["difference"], rel=1e-6)
    page = (run.folder / "report.html").read_text()
    assert "Size d10 of the drawn discs, by mass [m]" in page
    assert "Grading curve of the discs that were drawn" in page


def test_a_run_that_begins_from_it_keeps_its_sizes_and_draws_the_others(ended):
    run, given, folder = ended
    more = [{"kind": "run", "folder": "bed"}, {"kind": "column", "x": [0, 2], "y": [4, 6], "gate": False}]
    given = {**given, "walls": given["walls"][:1], "run": {**given["run"], "seed": 5}}
    given["analysis"] = {"figures": "none"}
    after = Case.load({**given, "initial": more})
    scene = after.scene()
    old = len(scene.sizes.given)
    assert old == run.summary["sizes"]["discs"]
    first = run.case.scene().diameters(np.arange(1, old + 1))
    assert scene.diameters(np.arange(1, old + 1)) == pytest.approx(first, rel=1e-12)
    assert scene.drawn_discs == len(scene.positions) - old > 50
    later = after.run(folder / "more")
    assert later.summary["sizes"]["discs"] == scene.drawn_discs
    alone = Case.load({**given, "initial": more[:1]}).run(folder / "alone")
    assert alone.summary["sizes"]["discs"] == 0 and "no disc was drawn" in alone.summary["sizes"]["reason"]


def test_members_draw_anew():
    one, two = (case(SIEVE, f"run.seed={seed}").scene() for seed in (1, 2))
    ids = np.arange(1, 400)
    assert (one.diameters(ids) != two.diameters(ids)).all()
    for scene in (one, two):
        curve = curve_of(drawn(scene.sizes, 399), scene.sizes)
        assert (np.abs(curve.drawn - curve.asked) <= 3 * curve.error + 1e-9).all()


def test_equal_and_uniform_discs_have_no_section(tmp_path):
    one = Case.load(yaml.safe_load(CASE.replace("SIZES", "{kind: uniform, spread: 0.2}").replace("WIDTH", "1")),
                    {"discs.diameter": 0.2, "analysis.figures": "none"})  # fmt: skip
    assert "sizes" not in one.run(tmp_path / "run").summary


def test_an_editor_is_not_told_that_a_diameter_is_needed():
    schema = CaseFields.model_json_schema()
    assert '"sieve"' in json.dumps(schema) and "diameter" not in schema["$defs"]["Discs"].get("required", [])
