# SPDX-License-Identifier: GPL-2.0-or-later
"""What `check` foresees: edges that discs run over, walls without use, empty windows, analyses in vain, radians."""

import re

import pytest
import yaml
from made_up import INPUTS, SCENES

from lammps_jump.case import load_case
from lammps_jump.errors import CaseError

NOTES = {
    "hydraulic_jump": ("equal discs pack into a crystal", "friction 0.1 on this bed makes a heap"),
    "hydraulic_jump_frictionless": ("equal discs pack into a crystal",),
    "crown_wall": ("initial[0]: discs of several sizes start touching",),
    "rockfall": ("walls 'block_1'", "walls 'block_2'"),
}
"""Beginnings of the notes of the scenes; the others have none."""


def notes(name, **changes):
    return load_case(INPUTS / f"{name}.yaml", changes).scene().warnings


def said(words, *found):
    return [text for text in found if words in text]


@pytest.mark.parametrize("name", [path.stem for path in SCENES])
def test_scenes_have_the_notes_that_they_have(name):
    found = load_case(INPUTS / f"{name}.yaml").scene().warnings
    assert len(found) == len(NOTES.get(name, ()))
    assert all(text.startswith(start) for text, start in zip(found, NOTES.get(name, ()), strict=True))


@pytest.mark.parametrize(
    ("name", "changes", "edge"),
    [
        ("dam_break", {"outflow": [], "domain.x": [-1, 30]}, "discs come to the right edge of the domain, x = 30 m"),
        (
            "dam_break",
            {"walls.back.at": -20, "domain.x": [-9, 110]},
            "discs come to the left edge of the domain, x = -9",
        ),
        ("quick_jump", {"outflow": []}, "nothing holds discs between x = "),
        ("quick_jump", {"outflow": [{"x_beyond": 25}]}, "they fall to the lower edge of the domain, y = -8 m"),
        ("hopper", {"outflow": []}, "nothing holds discs between x = "),
        ("heap", {"walls.bed.to": [0.3, -0.01], "walls.bed.from": [-0.3, -0.01]}, "nothing holds discs between x = "),
        ("sluice_gate", {"outflow": [], "domain.x": [-1, 20]}, "right edge of the domain, x = 20 m"),
    ],
)
def test_an_edge_that_discs_run_over_is_told(name, changes, edge):
    found = load_case(INPUTS / f"{name}.yaml", changes).scene().warnings
    (text,) = [one for one in found if edge in one]
    assert "lost ends the run; add outflow: [{" in text


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("dam_break", {"outflow": [], "domain.x": [-1, 110], "run.duration": 2}),  # too short a run
        ("column_collapse", {"domain.x": [-1, 12], "walls.floor.to": [11.9, -0.05]}),  # friction holds the heap
        ("wave_paddle", {"run.duration": 60}),
        ("drum", {}),
        ("energy_box_7", {}),
    ],
)
def test_edges_that_no_disc_comes_to_are_not_told(name, changes):
    found = load_case(INPUTS / f"{name}.yaml", changes).scene().warnings
    assert not [one for one in found if "lost ends the run" in one]


def test_discs_that_a_slide_throws_off_are_foreseen():
    heap = yaml.safe_load((INPUTS / "heap.yaml").read_text())
    walls = [wall for wall in heap["walls"] if wall["kind"] != "plane"]  # a bed with open ends
    slide = {"name": "slide", "kind": "block", "x": [-0.2, 0.2], "y": [0.41, 0.43]}
    away = {"kind": "translate", "velocity": [3, 0], "from": 1, "until": 1.2}
    for motion, told in ((None, False), (away, True)):
        case = load_case({**heap, "walls": [*walls, {**slide, "motion": motion}]})
        assert bool(said("nothing holds discs between x = 1.", *case.scene().warnings)) is told


def test_a_floor_that_ends_where_a_slide_throws_discs_is_told():
    """A silo whose run ended at 2.5 s: the slide at 1 m/s throws discs over the end of the floor at 1 m."""
    case = {
        "discs": {"diameter": 0.01, "density": 2500, "sizes": {"kind": "uniform", "spread": 0.2}},
        "contact": {
            "restitution": 0.5, "friction": 0.5, "friction_law": "history", "rotation": True,
            "rolling": {"friction": 0.15}, "from_material": {"young": 1e7, "poisson": 0.3},
        },
        "walls": [
            {"name": "floor", "kind": "rough", "from": [-0.8, -0.005], "to": [1.0, -0.005], "diameter": 0.01},
            {"name": "left", "kind": "line", "points": [[-0.3, 1.2], [-0.3, 0.75], [0.05, 0.45]], "sheet": True},
            {"name": "right", "kind": "line", "points": [[0.3, 1.2], [0.3, 0.6], [0.15, 0.45]], "sheet": True},
            {"name": "slide", "kind": "block", "x": [0, 0.2], "y": [0.41, 0.43],
             "motion": {"kind": "translate", "velocity": [1, 0], "from": 0.8, "until": 1.2}},
        ],
        "initial": [{"kind": "column", "x": [-0.29, 0.29], "y": [0.76, 1.15], "gate": False}],
        "run": {"duration": 6},
    }  # fmt: skip
    assert said("nothing holds discs between x = 1", *load_case(case).scene().warnings)
    case["walls"][0]["to"] = [2.5, -0.005]
    assert not load_case(case).scene().warnings


STEPS = {
    "discs": {"diameter": 0.15},
    "contact": {"restitution": 0.2, "friction": 0, "impact_speed": 12},
    "walls": [
        {"name": "bed", "kind": "line", "points": [[-1, 5], [1, 5], [1, 2.5], [4, 2.5], [4, 0], [31.4, 0]]},
        {"name": "sill", "kind": "block", "x": [31, 31.5], "y": [-1, 0.3]},
    ],
    "inflow": {"kind": "rows", "x": 0, "y": 5, "depth": 0.8, "mean_speed": 6.25, "profile": "uniform"},
    "outflow": [{"x_beyond": 36}, {"y_below": -1.5}],
    "run": {"duration": 14},
    "analysis": {"jump": True},
}


def test_a_drowned_basin_is_told_by_the_stream_at_the_foot():
    """q = 5 m2/s with 7.79 m of energy: 0.42 m at 11.9 m/s, and a sequent depth of 3.3 m; at the inlet it is 2.2 m."""
    first = load_case(STEPS).check()
    y2 = first.numbers["foot_belanger_y2"]
    assert y2 == pytest.approx(3.27, abs=0.1) and not said("drown", *first.warnings)
    for depth, told in ((3.0, False), (1.2 * y2, False), (1.3 * y2, True)):
        filled = {**STEPS, "initial": [{"kind": "column", "x": [8, 31], "y": [0, depth]}]}
        assert bool(said("the basin is drowned at the start", *load_case(filled).scene().warnings)) is told
    high = load_case(STEPS, {"walls.sill.y": [-1, 3.5]}).scene().warnings
    assert said("the sill of 3.5 m will drown the jump: the stream at the foot of the bed", *high)


def test_a_sill_that_drowns_a_jump_on_a_level_bed_is_told():
    assert said("the sill of 3 m will drown the jump", *notes("quick_jump", **{"walls.sill.y": [-5, 3]}))
    assert not said("drown", *notes("quick_jump", **{"walls.sill.y": [-5, 1.3]}))


def test_a_wall_that_nothing_touches_is_told():
    outside = notes("quick_jump", **{"walls.sill.x": [40, 41]})
    assert said("wall 'sill' is outside the domain, so that no disc can touch it", *outside)
    within = notes("quick_jump", **{"walls.sill.x": [10, 11], "walls.sill.y": [-3, -1], "analysis.jump": False})
    assert said("wall 'sill' lies within wall 'floor'", *within)


@pytest.mark.parametrize(
    ("name", "analysis", "why"),
    [
        ("hopper", "drum", "no wall turns"),
        ("dam_break", "jump", "no rows flow in"),
        ("quick_jump", "heap", "with a friction below 0.05 discs make no heap"),
        ("energy_box_7", "front", "gravity is 0"),
        ("energy_box_7", "hopper", "gravity is 0"),
        ("drum", "hopper", "no two walls"),
        ("energy_box_16", "heap", "gravity is 0"),
    ],
)
def test_an_analysis_that_the_scene_has_nothing_for_is_told(name, analysis, why):
    (text,) = said(f"analysis.{analysis}: ", *notes(name, **{f"analysis.{analysis}": True}))
    assert why in text and text.endswith("drop it")


@pytest.mark.parametrize(
    ("window", "words"),
    [
        ([7, 9], "analysis.window [7, 9] s holds no frame of the run, which goes from 0 to 6 s"),
        ([-3, -2], "holds no frame"),
        ([3, 3.05], "is shorter than the time between frames, 0.1 s"),
    ],
)
def test_a_window_without_frames_is_told(window, words):
    assert said(words, *notes("quick_jump", **{"analysis.window": window}))


@pytest.mark.parametrize(("value", "right"), [(1.5708, 90), (-1.57, -90), (3.14, 180), (0.5236, 30), (6.2832, 360)])
def test_an_angle_in_radians_is_told(value, right):
    (text,) = notes("wave_paddle", **{"walls.paddle.motion.phase": value})
    assert text.startswith(f"walls[1].motion.phase: {value:g} is in degrees") and text.endswith(f"write {right}")


def test_a_density_in_grams_is_told():
    (text,) = notes("quick_jump", **{"discs.density": 2.5})
    assert text == "discs.density: 2.5 is in kg/m^3; if g/cm^3 are meant, write 2500"


def test_each_end_of_a_floor_is_named():
    case = {
        "discs": {"diameter": 0.1}, "contact": {"restitution": 0.2, "impact_speed": 8}, "run": {"duration": 30},
        "walls": [{"name": "bed", "kind": "line", "points": [[-1, 0], [15, 0]]}],
        "initial": [{"kind": "column", "x": [3, 6], "y": [0, 3], "gate": False}],
    }  # fmt: skip
    (text,) = said("nothing holds discs", *load_case(case).scene().warnings)
    assert re.match(r"nothing holds discs between x = -\S+ and -1\.\d+, between x = 15\S* and \S+ m: they fall", text)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"walls.floor": {"name": "floor", "kind": "plane", "axis": "y", "at": 0}}, "allowed is 'above', 'below'"),
        ({"discs.diameter": 100}, 'take smaller discs (numbers are in m; text may have a unit, "100 mm")'),
        ({"probes.forces": "sill"}, "'sill' is a single value; this field is a list: [sill]"),
        ({"run.dt": 1, "inflow.height": 2}, "(1 more after this one: "),
        (
            {"walls.floor": {"name": "floor", "kind": "line", "points": [[22, 0], [-5, 0]]}},
            "reverse its points if they belong",
        ),
    ],
)
def test_a_beginners_mistake_is_answered_with_what_to_do(changes, words):
    with pytest.raises(CaseError) as caught:
        load_case(INPUTS / "quick_jump.yaml", changes).scene()
    assert words in str(caught.value)


@pytest.mark.parametrize("value", [0, 90, -90, 1, 1.5, 2, 0.5, 5, 6.3, 1.234, 45, 0.26])
def test_degrees_are_not_taken_for_radians(value):
    assert not said("is in degrees", *notes("wave_paddle", **{"walls.paddle.motion.phase": value}))


def weight_notes(**changes):
    given = {"probes.stability": {"structure": {"density": 2400, "friction": 0.6}}, **changes}
    return [text for text in load_case(INPUTS / "dam_break.yaml", given).scene().warnings if "stability" in text]


@pytest.mark.parametrize(
    ("low", "words"),
    [
        (-1.0, "its base lies 1 m inside 'floor'"),
        (-0.15, "its base lies 0.15 m inside 'floor'"),
        (-0.05, ""),
        (0.0, ""),
        (0.15, ""),
        (0.3, "its base lies 0.3 m above 'floor'"),
    ],
)
def test_a_structure_with_a_weight_that_is_drawn_into_the_floor_or_above_it_is_told(low, words):
    """Weight and toes are those of the outline: what lies in the floor weighs too, and has its toes there."""
    found = weight_notes(**{"walls.structure.y": [low, 2]})
    assert len(found) == bool(words) and all(words in text for text in found)


@pytest.mark.parametrize(("windows", "made"), [(0.4, 1), (3, 0), (4, 5), (7.3, 7), (10, 11), (11, 0)])
def test_a_moving_mean_that_windows_round_is_told(windows, made):
    """The mean is over an odd number of windows, from below one on; `check` says which time that makes."""
    base = {"probes.stability": {"structure": {"density": 2400, "friction": 0.6}}}
    scene = load_case(INPUTS / "dam_break.yaml", base).scene()
    window = scene.probe_steps * scene.time_step
    mean = load_case(INPUTS / "dam_break.yaml", base | {"probes.stability_mean": windows * window}).scene()
    said = [text for text in mean.adapted if "stability_mean" in text]
    words = f"probes.stability_mean: {made * window:.4g} s in place of {windows * window:.4g} s"
    assert [text.partition(", because")[0] for text in said] == [words] * bool(made)


def test_a_moving_mean_that_is_longer_than_the_run_is_told():
    (text,) = weight_notes(**{"walls.structure.y": [0, 2], "probes.stability_mean": 100})
    assert "probes.stability_mean: 100 s is longer than the run (5 s)" in text
    assert not weight_notes(**{"walls.structure.y": [0, 2], "probes.stability_mean": 5})
