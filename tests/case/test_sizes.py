# SPDX-License-Identifier: GPL-2.0-or-later
"""Cases with discs of several sizes: fields, starts, notes and what `check` says."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from made_up import INPUTS, examples

from lammps_jump.case import load_case, parse_case
from lammps_jump.case.packing import deepest_overlap, piled
from lammps_jump.errors import CaseError
from lammps_jump.scene.sizes import Sizes

CASE = """\
discs: {diameter: 0.2, sizes: {kind: uniform, spread: 0.2}}
contact: {restitution: 0.2, impact_speed: 16}
walls: [{name: floor, kind: plane, axis: y, at: 0, side: above}, {name: back, kind: plane, axis: x, at: 0, side: above}]
initial: [{kind: column, x: [0, 4], y: [0, 3], hydrostatic: false}]
run: {duration: 1}
"""
JET = ("initial=[]", "inflow={kind: rows, x: 1, depth: 1, mean_speed: 16}", "analysis.jump=true")


def case(*changes):
    return parse_case(CASE, "graded.yaml", changes)


def overlaps(positions, diameters):
    """Overlap of every pair, negative where they do not touch; shape (n, n), -inf on the diagonal."""
    gap = np.hypot(*(positions[:, None] - positions[None]).transpose(2, 0, 1))
    found = 0.5 * (diameters[:, None] + diameters[None]) - gap
    np.fill_diagonal(found, -np.inf)
    return found


# --- fields -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("sizes", "smallest", "largest", "mean_square"),
    [
        ("{kind: uniform, spread: 0.2}", 0.16, 0.24, 0.04 * (1 + 0.04 / 3)),
        ("{kind: bidisperse, spread: 0.2}", 0.16, 0.24, 0.04 * 1.04),
        ("{kind: bidisperse, spread: 0.2, share: 0.25}", 0.16, 0.24, 0.75 * 0.16**2 + 0.25 * 0.24**2),
        ("{kind: list, diameters: [0.3, 10 cm], shares: [0.6, 0.4]}", 0.1, 0.3, 0.6 * 0.09 + 0.4 * 0.01),
    ],
)
def test_kinds_of_sizes(sizes, smallest, largest, mean_square):
    scene = case(f"discs.sizes={sizes}").scene()
    assert (scene.smallest, scene.largest) == pytest.approx((smallest, largest), rel=1e-15)
    assert scene.mean_mass == pytest.approx(1000 * mean_square, rel=1e-14)
    assert scene.coefficients.critical_time_step == pytest.approx(2 / np.sqrt(2 * 2.56e7 / (1000 * smallest**2)))


def test_no_spread_is_equal_discs():
    equal, none = (case(f"discs.sizes={text}").scene() for text in ("null", "{kind: uniform, spread: 0}"))
    assert equal.sizes is None and none.sizes is None
    assert (equal.positions == none.positions).all()


def test_the_seed_shuffles_the_sizes():
    one, two = (case(f"run.seed={seed}").scene() for seed in (1, 2))
    assert (one.diameters(np.arange(1, 50)) != two.diameters(np.arange(1, 50))).all()


@pytest.mark.parametrize(
    ("sizes", "words"),
    [
        ("{kind: uniform, spred: 0.2}", ["discs.sizes.spred", "spread"]),
        ("{kind: list, diameters: [0.2], share: [1]}", ["discs.sizes.share", "shares"]),
        ("{kind: normal}", ["normal", "uniform", "bidisperse", "list"]),
        ("{spread: 0.2}", ["kind", "uniform"]),
        ("{kind: uniform, spread: 0.6}", ["0.6", "<= 0.5"]),
        ("{kind: list, diameters: [0.2, 0.3], shares: [0.5, 0.6]}", ["1.1", "must be 1"]),
        ("{kind: list, diameters: [0.2, 0.3], shares: [1]}", ["shares", "one for each"]),
        ("{kind: list, diameters: [0.2, 3], shares: [0.5, 0.5]}", ["3 m", "0.8 m"]),
    ],
)
def test_sizes_that_cannot_be(sizes, words):
    with pytest.raises(CaseError) as caught:
        case(f"discs.sizes={sizes}")
    assert all(word in str(caught.value) for word in words), caught.value


# --- starts -----------------------------------------------------------------------------------------------------


def test_a_column_is_a_dense_pile():
    scene = case().scene()
    d = scene.diameters(np.arange(1, len(scene.positions) + 1))
    found = overlaps(scene.positions, d)
    assert found.max() < 1e-9
    x, y = scene.positions.T
    assert (x - d / 2).min() == pytest.approx(0, abs=1e-9) and (y - d / 2).min() == pytest.approx(0, abs=1e-9)
    assert (x + d / 2).max() < 4 + 1e-9 and (y + d / 2).max() < 3 + 1e-9
    # mass depth 3 m would be a square lattice; touches: two below each
    assert (d**2).sum() / 4 > 2.9
    assert (found > -1e-9).sum() / len(d) > 3.5


@examples(40)
@given(
    ratio=st.floats(1.0, 16.0),
    share=st.floats(0.05, 0.95),
    width=st.floats(0.2, 30.0),
    height=st.floats(0.2, 15.0),
    seed=st.integers(1, 1000),
)
def test_any_pile_stays_in_its_rectangle_without_overlaps(ratio, share, width, height, seed):
    sizes = Sizes((share, 1 - share), (1.0, 1.0 / ratio), (1.0, 1.0 / ratio), seed)
    d = sizes.diameters(np.arange(1, 401))
    positions = piled(tuple(d.tolist()), (-1.0, -1.0 + width), (2.0, 2.0 + height), 1.0)
    d = d[: len(positions)]
    if len(d):
        assert overlaps(positions, d).max() < 1e-8
        assert (np.abs(positions - (-1.0 + width / 2, 2.0 + height / 2)) + d[:, None] / 2 < (
            width / 2 + 1e-8, height / 2 + 1e-8,
        )).all()  # fmt: skip
    if width > 5 and height > 5 and ratio < 3 and len(d) < 400:
        assert np.sum(np.pi / 4 * d**2) / width / height > 0.6


def test_a_pile_goes_on_with_the_ids_of_what_came_before():
    both = case("initial=[{kind: list, positions: [[8, 1]]}, {kind: column, x: [0, 4], y: [0, 3]}]").scene()
    d = both.diameters(np.arange(1, len(both.positions) + 1))
    assert overlaps(both.positions, d).max() < 1e-9
    assert both.positions[1] == pytest.approx((d[1] / 2, d[1] / 2), rel=1e-9)


@pytest.mark.parametrize("sizes", ["null", "{kind: uniform, spread: 0.2}"])
def test_all_discs_of_a_column_start_with_its_velocity(sizes):
    still = case(f"discs.sizes={sizes}").scene()
    both = case(f"discs.sizes={sizes}", "initial.0.velocity=[2, '-50 cm/s']").scene()
    assert np.array_equal(both.positions, still.positions) and not still.velocities.any()
    assert np.array_equal(both.velocities, np.tile([2.0, -0.5], (len(both.positions), 1)))


def test_hexagonal_packing_needs_equal_discs():
    with pytest.raises(CaseError, match=r"initial\[0\]: packing: hexagonal .* drop packing"):
        case("initial.0.packing=hexagonal").scene()


def test_a_column_too_narrow_for_its_first_disc_is_refused():
    with pytest.raises(CaseError, match="not one disc"):
        case("initial.0.x=[0,0.1]").scene()


def test_overlaps_at_the_start_are_those_of_the_discs_themselves():
    sizes = "discs.sizes={kind: list, diameters: [0.1, 0.3], shares: [0.5, 0.5]}"
    scene = case(sizes, "initial=[{kind: lattice, nx: 20, ny: 1, spacing: 1, origin: [1, 1]}]").scene()
    large = scene.diameters(np.arange(1, 21)) > 0.2
    i = int(np.flatnonzero(large[:-1] & large[1:])[0]) if (large[:-1] & large[1:]).any() else 0
    first, second = scene.diameters([i + 1, i + 2]).tolist()
    places = [[1.0 + j, 1.0] for j in range(20)]
    reach = (first + second) / 2
    for apart, fits in ((reach - 0.019, True), (reach - 0.021, False)):  # d/n = 0.02
        places[i + 1] = [places[i][0] + apart, 1.0]
        changes = (sizes, f"initial=[{{kind: list, positions: {places}}}]")
        if fits:
            case(*changes).scene()
        else:
            with pytest.raises(CaseError, match=f"discs {i + 1} .* and {i + 2} .* overlap by 0.021 m"):
                case(*changes).scene()
    with pytest.raises(CaseError, match=r"disc 1 .* deep in wall 'back'"):
        case(sizes, f"initial=[{{kind: list, positions: [[{scene.diameters(1) / 2 - 0.021}, 1]]}}]").scene()


@given(seed=st.integers(0, 10_000), n=st.integers(2, 60))
def test_deepest_overlap_is_that_of_all_pairs(seed, n):
    random = np.random.default_rng(seed)
    positions, diameters = random.uniform(0, 3, (n, 2)), random.uniform(0.1, 0.4, n)
    every = overlaps(positions, diameters)
    found = deepest_overlap(positions, diameters)
    if every.max() <= 0:
        assert found is None
    elif every.max() < 0.9 * diameters.min():  # beyond, the search ends early
        assert found[0] == pytest.approx(every.max(), rel=1e-12)
        assert every[found[1:]] == found[0]


# --- checks and notes -------------------------------------------------------------------------------------------


def test_inlet_and_pour_make_room_for_the_largest_disc():
    scene = case(*JET).scene()
    assert [row.y for row in scene.inlets] == pytest.approx([0.24 * (i + 0.5) for i in range(7)], rel=1e-14)
    assert {row.clearance for row in scene.inlets} == {0.999 * scene.largest}
    assert all(row.first_step == scene.size_steps and row.every_steps % scene.size_steps == 0 for row in scene.inlets)
    assert scene.wall("inlet_back").at == pytest.approx(1 - 0.51 * 0.24)
    with pytest.raises(CaseError, match=r"inflow.x: .*0.24 m or more"):
        case("initial=[]", "inflow={kind: pour, x: [1, 1.22], y: [5, 7], count: 20}").scene()
    with pytest.raises(CaseError, match=r"row 1 enters .* deep in wall 'floor'"):
        case(*JET, "inflow.y=-0.01").scene()


def test_friction_without_damping_is_refused():
    with pytest.raises(CaseError, match=r"contact.friction: is 0.1 with restitution 1; .*equal discs"):
        case("contact.friction=0.1", "contact.restitution=1").scene()
    case("contact.friction=0.1", "contact.restitution=1", "discs.sizes=null").scene()


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ((), []),
        (("discs.sizes=null",), ["crystal"]),
        (("contact.friction=0.1",), ["heap"]),
        (("contact.friction=0.1", "discs.sizes=null"), ["crystal", "heap"]),
        (("contact.friction=0.02",), []),
        (("contact.friction=0.1", "slope=6"), []),  # the slope carries what friction holds
    ],
)
def test_jump_scenes_say_whether_they_make_a_level_jump(changes, words):
    notes = case(*JET, *changes).scene().warnings
    assert len(notes) == len(words), notes
    assert all(word in note for word, note in zip(words, notes, strict=True))
    assert not case(*JET, *changes, "analysis.jump=false").scene().warnings


def test_a_graded_column_says_that_it_does_not_carry_its_weight():
    (note,) = case("initial.0.hydrostatic=true").scene().warnings
    assert "initial[0]" in note and "settle" in note
    assert not case("initial.0.hydrostatic=true", "initial.0.settle=1").scene().warnings


@pytest.mark.parametrize(("fraction", "count"), [(0.11, 0), (0.112, 1)])
@pytest.mark.parametrize("sizes", ["null", "{kind: uniform, spread: 0.3}"])
def test_slip_is_judged_by_the_smallest_pair(fraction, count, sizes):
    # 18 f a step in a dense packing: dashpots grow as sqrt(m), and the step as sqrt(m) of the smallest
    changes = ("contact.friction=0.1", f"run.time_step_fraction={fraction}", f"discs.sizes={sizes}")
    assert len([text for text in case(*changes).scene().warnings if "damps by" in text]) == count


def test_check_says_what_sizes_mean():
    found = case(*JET, "run.time_step_fraction=0.05").check()
    numbers = found.numbers
    assert (numbers["smallest_diameter"], numbers["largest_diameter"]) == pytest.approx((0.16, 0.24))
    assert numbers["mean_mass"] == pytest.approx(40 * (1 + 0.04 / 3))
    assert numbers["restitution_smallest"] == pytest.approx(0.1981, abs=0.51e-4)
    assert numbers["restitution_largest"] == pytest.approx(0.2012, abs=0.51e-4)
    assert numbers["contact_duration_largest"] == pytest.approx(1.5 * numbers["contact_duration_smallest"])
    assert numbers["mass_flow_rows"] == pytest.approx(16_000, rel=2e-3)
    assert "smallest disc" in str(found)
    assert "radius" not in " ".join(found.skipped)
    equal = load_case(INPUTS / "hydraulic_jump.yaml").check()
    assert "smallest_diameter" not in equal.numbers and "radius" in " ".join(equal.skipped)


def test_rows_too_close_to_enter_are_named():
    (note,) = case(*JET, "inflow.spacing=1.02").scene().warnings
    assert "inflow.spacing 1.02" in note and "1.1" in note


@pytest.mark.parametrize("sizes", ["{kind: uniform, spread: 0.2}", "null"])
def test_discs_that_jitter_makes_overlap_name_it(sizes):
    """The message said "move them apart" of discs that no field of the case places one by one."""
    text = (
        "name: shaken\ndiscs: {diameter: 0.2}\ncontact: {restitution: 0.5, impact_speed: 5}\n"
        "walls: [{name: floor, kind: plane, axis: y, at: 0, side: above}]\n"
        "initial:\n  - {kind: list, positions: [[9, 3]]}\n"
        "  - {kind: column, x: [0, 2], y: [0, 2], gate: false, jitter: JITTER}\nrun: {duration: 1}\n"
    )

    def shaken(jitter):
        return parse_case(text.replace("JITTER", str(jitter)), "shaken.yaml", [f"discs.sizes={sizes}"])

    with pytest.raises(CaseError, match=r"lower initial\[1\].jitter, which shifts each disc by up to 0.04 m \(0.2 dia"):
        shaken(0.2).scene()
    assert len(shaken(0.0001).scene().positions) > 80  # the remedy helps
