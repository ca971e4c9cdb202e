# SPDX-License-Identifier: GPL-2.0-or-later
"""Verdicts on made-up summaries: what claims the title, what nobody asked for, and what makes each answer doubtful."""

# ruff: noqa: E501  (sentences stand whole)
from __future__ import annotations

from dataclasses import fields

import pytest

from lammps_jump.analysis.quantities import QUANTITIES
from lammps_jump.analysis.statistics import Mean
from lammps_jump.analysis.tables import lines, main_numbers, rows_of, together
from lammps_jump.analysis.verdicts import VERDICTS, doubts, headline, verdict

GATE = {"height": 1.79, "height_interval": 0.03, "settled_at": 30.0, "holds": "front", "target": 30.0, "held": 30.02,
        "held_interval": 0.11}  # fmt: skip
STATE = {"discs": 300, "first_discs": 300, "speed": 0.02, "speed_over_root_gd": 0.05, "along": 0.0, "mean_speed": 0.1,
         "length": 0.6, "height": 0.12, "at_rest": True}  # fmt: skip
NO_JUMP = {"verdict": "no jump found", "reason": "Fewer than eight bins.", "headline": "No hydraulic jump to compare."}
JUMP = {"verdict": "jump", "at": "tail water", "belanger_deviation": -0.01, "speed": 1.0, "y2": 3.0}
HOPPER = {"discharge": 180.0, "slot": 0.1, "gap_x": [0.1], "slot_in_diameters": 10.0, "beverloo": 0.9, "discs": 700,
          "change": 0.01, "pause": 0.01, "usual_pause": 0.002}  # fmt: skip
HEAP = {"height": 0.23, "angle": 21.0, "angle_interval": 2.0, "angle_left": 21.0, "angle_right": 21.0, "at_rest": True,
        "angle_left_interval": 2.0, "angle_right_interval": 2.0, "height_in_diameters": 23.0}  # fmt: skip
DRUM = {"angle": 24.9, "turns": 0.7, "scatter": 2.0, "froude": 0.02, "filling": 0.4}
LAYERS = {"velocity": 0.35, "friction": 0.36, "change": 0.01, "layers": 15}
WAVES = {"period": 4.0, "periods": 4, "height": 0.59, "height_last": 0.4, "gauges": [4.5, 12.0], "heights": [0.59, 0.4]}
FRONT = {"position": 9.2, "position_99": 9.0, "time": 3.0, "speed": 3.6, "column_base": 2.0, "column_depth": 4.0}
RUN_UP = {"highest": 1.9, "run_up": 1.0, "diameters": 10.0, "crest": 2.5, "over": 0.0, "over_discs": 0, "wall": "quay"}
FORCE = {"quay": {"peak": 4690.0, "peak_unfiltered": 5000.0, "stagnation": 1800.0, "hydrostatic": 900.0, "oncoming_flux": 1200.0,
                  "component": "fx", "peak_time": 5.41}}  # fmt: skip
ENERGY = {"conservative": True, "max_deviation": 0.004}
DUMP = {"given": {}, "state": STATE}


@pytest.mark.parametrize(
    ("summary", "said"),
    [
        ({"hopper": HOPPER, "heap": HEAP}, "Discs leave at 0.18 t/s per metre through a gap of 0.10 m at x = 0.1 m. A heap of 0.23 m is at rest, its flanks slope at 21 degrees."),
        ({"drum": DRUM}, "The drum turns, and its surface slopes at 24.9 degrees."),
        ({"layers": LAYERS}, "The layer flows at 0.35 m/s; its effective friction is 0.36."),
        ({"layers": LAYERS, "state": STATE}, "The layer rests on its bed."),
        ({"front": FRONT, "runup": RUN_UP}, "A column collapses: its front runs at 3.6 m/s. The water reaches y = 1.9 m on quay, 1.0 m over the still water; nothing goes over the crest at y = 2.5 m."),
        # a column of 4 m: √(g H) is 6.26 m/s, and 2 % of it is where a front creeps
        ({"front": {**FRONT, "speed": 0.126}}, "A column collapses: its front runs at 0.13 m/s."),
        ({"front": {**FRONT, "speed": 0.124}}, "A column collapses: its front creeps at 0.12 m/s."),
        ({"runup": {**RUN_UP, "over": 0.2, "highest": 3.0}}, "The water reaches y = 3 m on quay, 1.0 m over the still water; 0.20 m² go over the crest at y = 2.5 m."),
        ({"force": FORCE}, "The discs push quay with 4.7 kN/m along x at most, at t = 5.41 s."),
        ({"state": STATE}, "300 discs are at rest; they take 0.60 m along x and 0.12 m in height."),
        ({"state": {**STATE, "at_rest": False}}, "300 discs still move, at 0.020 m/s in the median; they take 0.60 m along x and 0.12 m in height."),
        ({"state": {**STATE, "at_rest": False, "speed_over_root_gd": 0.001}}, "300 discs are slow, 0.020 m/s in the median; they take 0.60 m along x and 0.12 m in height."),
        (DUMP, "A dump of 300 discs, of whose scene nothing is known: they are at rest; they take 0.60 m along x and 0.12 m in height."),
        ({"state": {**STATE, "speed": None, "at_rest": None}}, "How fast the 300 discs move is not known; they take 0.60 m along x and 0.12 m in height."),
    ],
)  # fmt: skip
def test_a_title_belongs_to_what_is_there(summary, said):
    assert verdict(summary) == said and headline(summary)


@pytest.mark.parametrize(
    "summary",
    [
        {**DUMP, "jump": NO_JUMP},  # nobody asked
        {"jump": NO_JUMP, "state": STATE},  # no stream flows in
        {"jump": {**JUMP, "headline": "A jump."}, "inflow": {}, "friction_law": "history", "state": STATE},  # grains
        {"state": STATE},
    ],
)
def test_no_jump_is_spoken_of_where_none_can_be(summary):
    assert "jump" not in verdict(summary).lower() + headline(summary).lower() and "at rest" in verdict(summary)
    asked = "jump" in summary and "given" not in summary
    assert QUANTITIES["jump"].shown(summary) or not asked
    # what a case asks for and cannot have is told with its reason
    assert any("hydraulic jump" in text for text in doubts(summary)) is asked
    assert not any("jump" in line for line in main_numbers(summary) if not asked)


def test_a_jump_that_was_asked_for_is_spoken_of():
    assert verdict({"jump": NO_JUMP, "inflow": {}, "state": STATE}) == "No hydraulic jump."
    found = {**DUMP, "jump": JUMP}
    assert verdict(found).startswith("A hydraulic jump.") and QUANTITIES["jump"].shown(found)
    asked = {**DUMP, "given": {"analyses": ["jump"]}, "jump": NO_JUMP}
    assert QUANTITIES["jump"].shown(asked) and not QUANTITIES["jump"].shown({**DUMP, "jump": NO_JUMP})


def test_a_front_of_a_dump_is_shown_where_discs_run_as_a_stream():
    still = {**FRONT, "speed": None, "column_base": None}
    poured = {**DUMP, "front": still}
    assert not QUANTITIES["front"].shown(poured) and verdict(poured).startswith("A dump of 300 discs")
    stream = {**poured, "state": {**STATE, "along": 0.09}}
    assert QUANTITIES["front"].shown(stream) and verdict(stream).startswith("The front of the discs is at 9.2 m")


def test_a_front_that_met_an_obstacle_is_not_where_it_ran_to():
    said = headline({"front": {**FRONT, "position": 7.0, "time": 6.0, "arrival_time": 1.16}})
    assert "its front ran at 3.60 m/s and met the first obstacle after 1.16 s" in said and "7.00" not in said
    loose = {**FRONT, "column_base": None}  # discs that stood away from the back wall: nothing flows in
    assert headline({"front": loose}).startswith("The front of the discs is at 9.20 m after 3.00 s, mean speed 3.60")


def test_water_at_rest_before_a_wall_does_not_strike_it():
    rests = {"quay": {**FORCE["quay"], "stagnation": 1000.0, "oncoming_flux": 100.0}}
    assert verdict({"force": rests, "state": STATE}).startswith("300 discs")
    assert "push quay" in verdict({"force": rests, "runup": {"wall": "quay"}})  # what climbs it has run against it
    assert verdict({"force": FORCE, "inflow": {}, "state": STATE}).startswith("300 discs")  # a stream has a mean
    # what comes climbs the wall, and is then deeper than it was
    climbs = {"quay": {**FORCE["quay"], "stagnation": 4700.0, "hydrostatic": 8500.0, "oncoming_flux": 3800.0}}
    assert "push quay" in verdict({"force": climbs, "state": STATE})


BODY = {
    "largest_displacement": 1.4, "largest_turn": 0.2, "start_x": 17.5, "end_x": 18.9, "rest": True, "rest_since": 6.6,
    "state": "slid", "side": None, "slid_by": 1.4, "base_way": 1.4, "centre_way": 1.4, "lean": 0.1,
    "slides_at": 1.8, "tips_at": None, "floats": False, "mass": 12000.0, "inertia": 15000.0,
}  # fmt: skip
FLOATS = {"state": "afloat", "floats": True, "draught": 0.5, "draught_interval": 0.02, "draught_by_weight": 0.5}
TOPPLED = {"state": "lies", "side": "right", "state_since": 2.4, "base_way": 1.2, "centre_way": 3.2, "tips_at": 2.0}
NO_STATE = {"state": None, "state_reason": "it turns about a hinge", "slides_at": None}


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({}, "The body box has slid by 1.40 m: it slides from 1.8 s on and rests from 6.6 s on."),
        ({"slid_by": -1.4}, "The body box has slid by 1.40 m: it"),
        (FLOATS, "The body box floats with a draught of 0.50 ± 0.02 m."),
        ({"state": "afloat", "rest": False}, "The body box is afloat."),
        (TOPPLED, "The body box has toppled and lies on its right side: it slides from 1.8 s on, tips at 2.0 s, lies from 2.4 s on and rests from 6.6 s on. Its base came 1.20 m far, its centre of mass 3.20 m."),
        ({**TOPPLED, "tips_at": 1.5, "side": "top"}, "The body box has toppled and lies on its top: it tips at 1.5 s, slides from 1.8 s on,"),
        ({"state": "leans", "side": "left", "lean": 12.3, "state_since": 2.0}, "The body box leans to the left by 12 degrees: it slides from 1.8 s on, leans from 2.0 s on and rests"),
        ({"state": "left", "state_since": 9.0, "falls_at": 8.0, "rest": False}, "The body box has left: it slides from 1.8 s on, falls at 8.0 s and leaves at 9.0 s."),
        ({"state": "stands", "slides_at": None, "rest": False}, "The body box stands."),
        ({"alike": (5, 8), "rest": False}, "The body box has slid by 1.40 m in 5 of 8 starts: it slides from 1.8 s on."),
        ({**NO_STATE, "largest_turn": 48.0}, "The body box comes 1.40 m far and turns by up to 48 degrees, and rests from 6.6 s on."),
        ({**NO_STATE, "largest_displacement": 1e-4, "largest_turn": 0.0}, "The body box stands."),
    ],
)  # fmt: skip
def test_what_a_body_did(changed, said):
    assert verdict({"bodies": {"box": {**BODY, **changed}}}).startswith(said)
    assert verdict({"bodies": {"box": {"reason": "no row"}}, "state": STATE}).startswith("300 discs")
    three = verdict({"bodies": {name: BODY for name in "abc"}})
    assert three.count("has slid") == 2 and "tells of 3 bodies" in three


def test_starts_whose_bodies_end_in_another_way_are_counted_and_left_out():
    ends = [{**BODY, **changed} for changed in ({}, TOPPLED, TOPPLED | {"base_way": 1.6})]
    whole = together([{"bodies": {"box": one}} for one in ends], _mean)
    box = whole["bodies"]["box"]
    assert box["alike"] == (2, 3) and box["base_way"] == pytest.approx(1.4)
    assert "lies on its right side in 2 of 3 starts" in verdict(whole)


GATE = {
    "height": 0.4, "height_interval": 0.03, "held": 10.0, "held_interval": 0.1, "target": 10.0, "holds": "front",
    "water": 0.85, "settled_at": 16.0, "reason": None,
}  # fmt: skip
LOOSE = GATE | {"settled_at": None, "reason": "its front wanders by 1 m", "held": 9.0}


@pytest.mark.parametrize("turn", range(4))
def test_the_title_over_starts_of_a_gate_is_of_all_and_not_of_the_first(turn):
    """Whichever start comes first: means of those that settled, as most did, and a doubt with the number of others."""
    ends = [GATE, GATE | {"settled_at": 20.0}, GATE | {"settled_at": 21.0}, LOOSE]
    whole = together([{"tailgate": {"sill": one}} for one in ends[turn:] + ends[:turn]], _mean)
    assert whole["tailgate"]["sill"]["alike"] == (3, 4)
    assert verdict(whole).startswith("The gate sill holds the front at x = 10.000 ± 0.030 m with its crest at y = 0.40")
    assert "in 3 of 4 starts" in verdict(whole) and "it has settled at 19 s in the mean" in headline(whole)
    assert doubts(whole) == ["The gate sill has not settled in 1 of 4 starts."]


@pytest.mark.parametrize("turn", range(3))
def test_a_gate_that_settles_in_few_starts_has_not_settled(turn):
    ends = [GATE, LOOSE, LOOSE]
    whole = together([{"tailgate": {"sill": one}} for one in ends[turn:] + ends[:turn]], _mean)
    assert "stands with its crest at y = 0.40" in verdict(whole) and "in 2 of 3 starts, where 10 m is" in verdict(whole)
    assert "settled at" not in headline(whole)
    assert doubts(whole) == ["The gate sill has not settled in 2 of 3 starts: its front wanders by 1 m."]


@pytest.mark.parametrize("turn", range(3))
def test_what_happened_to_a_body_is_what_half_of_the_starts_had(turn):
    ends = [BODY | {"tips_at": 3.0}, BODY | {"rest": False, "rest_since": None}, BODY]
    whole = together([{"bodies": {"box": one}} for one in ends[turn:] + ends[:turn]], _mean)
    assert verdict(whole).startswith("The body box has slid by 1.40 m in 3 of 3 starts: it slides from 1.8 s on.")


def _mean(values):
    return Mean(sum(values) / len(values), 0.03)


def test_where_a_body_stands_does_not_decide_whether_it_moved():
    moved = {**BODY, **NO_STATE, "largest_displacement": 0.05, "largest_turn": 0.0}  # of a radius of 1.1 m
    for x in (1.0, 100.0):
        assert "comes 0.05 m far" in verdict({"bodies": {"box": {**moved, "start_x": x, "end_x": x + 0.05}}})


def test_a_run_out_that_ends_at_a_wall_is_a_bed_with_a_doubt():
    """The title told 3.0 times the base of a dump that fills its box from wall to wall."""
    fills = {**HEAP, "angle": None, "base": 2.0, "run_out_over_base": None, "right_at": "the end of the domain",
             "no_run_out": "the discs have come to the end of the domain"}  # fmt: skip
    assert verdict({"heap": fills}) == "A bed of 0.23 m is at rest."
    assert "There is no run-out: the discs have come to the end of the domain." in doubts({"heap": fills})
    leans = {**HEAP, "base": 2.0, "run_out_over_base": 1.5, "left_at": "wall 'back'"}
    assert "has run out 1.5 times" in verdict({"heap": leans})
    assert not any("touches" in text for text in doubts({"heap": leans}))
    arrived = {**FRONT, "stopped_by": "wall 'quay'", "arrival_time": 1.9}
    assert not any("has come to" in text for text in doubts({"front": arrived}))


DOUBTFUL = [
    ({"heap": {**HEAP, "right_at": "wall 'quay'"}}, "the heap touches wall 'quay', so that its height and slope are not its own"),
    ({"front": {**FRONT, "stopped_by": "the end of the domain"}}, "the front has come to the end of the domain at the end"),
    ({"hopper": {**HOPPER, "discs": 40}}, "40 discs pass while the flow is on"),
    ({"hopper": {**HOPPER, "change": -0.3}}, "the discharge changes by 30 % within"),
    ({"hopper": {**HOPPER, "pause": 0.5}}, "no disc passes for 0.50 s, 250 times"),
    ({"hopper": {**HOPPER, "no_beverloo": "it is narrow"}}, "no number of Beverloo: it is narrow"),
    ({"heap": {**HEAP, "at_rest": False}}, "still move"),
    ({"heap": {**HEAP, "angle_interval": 7.0}}, "± 7.0 degrees"),
    ({"heap": {**HEAP, "angle_left": 32.0}}, "32 degrees to the left and 21 to the right"),
    ({"heap": {**HEAP, "height_in_diameters": 6.0}}, "6.0 diameters high"),
    ({"heap": HEAP, "friction_law": "viscous"}, "no memory"),
    ({"drum": {**DRUM, "turns": 0.2}}, "0.20 of a turn"),
    ({"drum": {**DRUM, "scatter": 5.0}}, "swings by 5.0 degrees"),
    ({"drum": {**DRUM, "froude": 0.5}}, "Froude number is 0.50: the surface is bent"),
    ({"drum": {**DRUM, "filling": 0.9}}, "fill 90 % of the drum"),
    ({"layers": {**LAYERS, "change": 0.2}}, "20 % faster"),
    ({"layers": {**LAYERS, "layers": 5}}, "5 layers hold discs"),
    ({"jump": {**JUMP, "filling": True}}, "still fills"),
    ({"jump": {**JUMP, "share_found": 0.5}}, "share of 0.50 of the frames"),
    ({"jump": {**JUMP, "drift": {"y2": 0.3}}}, "changes by 10 % within"),
    ({"jump": {**JUMP, "left_out": ["friction"]}}, "leaves out friction"),
    ({"jump": {**JUMP, "stream": {"at_inlet": True}}}, "compressed up to the inlet"),
    ({"jump": {**JUMP, "frames_in_window": 5}}, "holds 5 frames"),
    ({"jump": JUMP, "inflow": {"deviation": -0.2}}, "inflow is 20 % off"),
    ({"tailgate": {"sill": {**GATE, "height_interval": 0.3}}}, "known to ± 0.30 m only"),
    ({"tailgate": {"sill": {**GATE, "settled_at": None, "reason": "it creeps"}}}, "sill has not settled: it creeps"),
    ({"bodies": {"box": {**BODY, "rest": False}}}, "box still moves at the end"),
    ({"bodies": {"box": {**BODY, **FLOATS, "draught": 0.3}}}, "the draught of box is 0.30 m, that by its weight 0.50 m"),
    ({"waves": {**WAVES, "periods": 2}}, "2 periods only"),
    ({"waves": {**WAVES, "height_last": 0.1}}, "lose 83 %"),
    ({"front": {**FRONT, "position_99": 20.0}}, "end at different places, 9.2 and 20 m"),
    ({"front": {**FRONT, "gate_open": 2.0}}, "takes 2.0 s to open"),
    ({"runup": {**RUN_UP, "reaches_crest": True}}, "reaches the crest"),
    ({"runup": {**RUN_UP, "over": 0.1, "over_discs": 25}}, "scatters by 20 %"),
    ({"overtopping": {"weir": {"discharge": 0.4, "discs": 40}}}, "40 discs make what goes over weir"),
    ({"runup": {**RUN_UP, "diameters": 1.5}}, "1.5 diameters"),
    ({"force": {"quay": {**FORCE["quay"], "peak_unfiltered": 14070.0}}}, "3.0 times as high"),
    ({"force": {**FORCE, "identity": {"x": {"complete": True, "relative": 0.2}}}}, "miss the momentum of the discs by 20 %"),
    ({"energy": {**ENERGY, "max_deviation": 0.05}}, "changes by 5.0 %"),
    ({"state": {**STATE, "at_rest": False, "speed_over_root_gd": 0.001}}, "have not rested"),
    ({"state": {**STATE, "first_discs": 310}}, "10 of 310 discs have left"),
    (DUMP, "not in a dump"),
]  # fmt: skip
"""A summary for every doubt, and what is said of it."""


@pytest.mark.parametrize(("summary", "said"), DOUBTFUL)
def test_a_doubt_is_told(summary, said):
    (one,) = doubts(summary)
    assert said.lower() in one.lower() and one.endswith(".") and one[0] == one[0].upper()
    assert f"doubtful: {one}" in main_numbers(summary)


def test_every_doubt_has_its_summary_and_none_holds_without_a_cause():
    every = [doubt for one in VERDICTS for doubt in one.doubts]
    assert sum(any(doubt.found(summary) for summary, _ in DOUBTFUL) for doubt in every) == len(every) == len(DOUBTFUL)
    sound = {"hopper": HOPPER, "heap": HEAP, "drum": DRUM, "layers": LAYERS, "jump": JUMP, "waves": WAVES}
    sound |= {"front": FRONT, "runup": RUN_UP, "force": FORCE, "energy": ENERGY, "state": STATE}
    sound |= {"tailgate": {"sill": GATE}, "bodies": {"box": BODY, "buoy": {**BODY, **FLOATS}}}
    assert not [doubt.when for doubt in every if doubt.found(sound)]


def test_numbers_of_verdicts_are_those_of_the_program():
    for one in VERDICTS:
        for key in one.numbers:
            quantity, *rest = key.split(".")
            assert rest[-1] in {field.name for field in fields(QUANTITIES[quantity].result)}, key


def test_the_gauges_stand_on_the_first_screen():
    waves = {"gauges": [4.0, 8.0], "means": [0.93, -0.001], "largest": [1.26, 0.0]}
    assert lines({"waves": waves}) == [
        "depth at gauges, mean of the window (largest), m: x = 4 m 0.93 (1.26), x = 8 m 0.00 (0.00)"
    ]
    assert lines({}) == []


@pytest.mark.parametrize(
    ("speed", "said"),
    [(0.26, "moves downstream at 0.26 m/s"), (-0.26, "moves upstream at 0.26 m/s"), (0.24, "creeps downstream"),
     (-0.24, "creeps upstream"), (0.0, "stands")],
)  # fmt: skip
def test_the_front_of_a_jump_creeps_below_two_percent_of_its_stream(speed, said):
    jump = {**JUMP, "speed": speed, "speed_error": 0.01, "local": {"u1": 12.5}, "headline": "A jump."}
    assert f"its front {said}" in verdict({"jump": jump, "inflow": {}}).lower()


WEIR = {"weir": {"discharge": 0.42, "discs": 900, "head": 0.51}, "gate": {"discharge": None, "below": 0.7}}


def test_a_weir_and_a_gate_have_the_title_and_their_numbers_stand_at_the_top():
    """Discs that still move are no answer; the force of a stream over a weir has no comparison with water at rest."""
    force = {
        "weir": {"component": "fx", "mean_fx": 7e3, "mean_hydrostatic": 3e3, "hydrostatic": 4e3, "oncoming_flux": 0.0}
    }
    found = {"overtopping": WEIR, "inflow": {"asked": None}, "state": STATE, "force": force}
    assert verdict(found) == "0.42 m²/s go over weir under a head of 0.51 m; 0.70 m²/s go below gate."
    rows = {row.label: row for row in rows_of([found])}
    assert list(rows)[:3] == ["discharge over weir", "head over the crest of weir", "discharge below gate"]
    assert rows["mean Fx, weir"].off() == ""
    still = {"inflow": {"asked": None}, "force": force}
    assert rows_of([still])[0].off() == "+133 %"
    runs = {"inflow": {"asked": None}, "force": {"weir": {**force["weir"], "oncoming_flux": 2e3}}}
    assert rows_of([runs])[0].off() == ""


def test_a_wall_that_is_overtopped_is_not_doubtful():
    """Of few discs the run-up is asked for, of many the volume; what still comes stands in the title."""
    over = {**RUN_UP, "highest": 6.2, "over": 7.9, "over_discs": 400, "reaches_crest": True, "still_passes": True}
    over = {"runup": over}
    assert doubts(over) == [] and "by the end, and more comes" in verdict(over)


def test_gauges_without_a_depth_are_left_out():
    assert lines({"waves": {"gauges": [4.0], "means": [None], "largest": [None]}}) == []
