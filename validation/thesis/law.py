# SPDX-License-Identifier: GPL-2.0-or-later
"""The thesis T-4359: what it says of its own runs, held against ours."""

from __future__ import annotations

from math import sqrt

import numpy as np
from matplotlib.figure import Figure

from lammps_jump.analysis.draw.style import BLUE, GREY, RED, drawing
from lammps_jump.studies.validation import LOOKED_UP, Found, Law, Point, Row, around, mean_of

SCENES = "../../inputs"
OURS = {"engine.name": "native", "analysis.figures": "none"}
ITS_OWN = {"contact.friction_law": "sign", "run.integrator": "leapfrog_extrapolated"}
"""Friction and scheme of the thesis, 4.3 and 3.5."""
BOXES = {16: (120, 0.014, "4.5, figures 4.10 and 4.11"), 7: (60, 0.0093, "4.5, figures 4.12 and 4.13")}
"""Discs of an energy box: seconds, largest fluctuation of the energy, place in the thesis."""
SHARES = (0.05, 0.1, 0.2)
"""Of the largest stable step that the thesis tried."""
JETS = {15.66: 5.0, 28.19: 9.0}
"""Speed of a jet of 1 m (m/s), and its Froude number."""
HOURS = {"dam break": 4.0, "jump": 100.0}
"""That 5 s of the dam break and 20 s of the jump took."""


def points(quick: bool) -> list[Point]:
    """Boxes, collisions, jets, the dam break, the structure, the jump; quick: without the last two."""
    found = [
        Point(f"box {n}", "box", f"{SCENES}/energy_box_{n}.yaml", {**OURS, "run.duration": seconds}, 8, seconds=1)
        for n, (seconds, *_) in BOXES.items()
    ]
    found += [
        Point(f"step {share:g}", "collision", options={"restitution": 0.2, "fraction": share}) for share in SHARES
    ]
    found += [Point(f"jet {speed:g}", "inflow", options={"speed": speed}) for speed in JETS]
    found.append(Point("dam break", "dam", f"{SCENES}/dam_break.yaml", OURS, seconds=2))
    if not quick:
        found += [
            Point("structure", "wave", f"{SCENES}/wave_structure.yaml", OURS, 3, seconds=20),
            Point("jump", "jump", f"{SCENES}/hydraulic_jump.yaml", {**OURS, **ITS_OWN}, 3, seconds=20),
            Point("jump without friction", "jump", f"{SCENES}/stable_jump.yaml", OURS, 3, seconds=20),
        ]
    return found


def rows(found: Found) -> list[Row]:
    """What the thesis says, in its order."""
    made = [
        Row(f"restitution of two discs, {share:.0%} of the largest stable step", 0.2, LOOKED_UP, "T-4359, 3.4 and 3.5",
            found[f"step {share:g}"][0]["restitution"], limits=around(0.2, 0.02),
            reason="2 %: the thesis used 5 %, and calls results at 10 and 20 % reasonable")
        for share in SHARES
    ]  # fmt: skip
    for speed, froude in JETS.items():
        one = found[f"jet {speed:g}"][0]
        made += [
            Row(f"Froude number of a jet of {speed:g} m/s, 1 m deep", froude, LOOKED_UP, "T-4359, 4.1 and 4.2",
                one["froude"], limits=around(froude, 0.001), reason="the speed has two digits behind the point"),
            Row(f"jet of {speed:g} m/s: discharge of the rows over speed times depth", 1.0, LOOKED_UP,
                "T-4359, 4.2 and figure 5.3", one["carried"], limits=around(1.0, 0.07),
                reason="7 %: touching rows at 1.02 diameters, as the thesis has them"),
        ]  # fmt: skip
    for n, (seconds, published, where) in BOXES.items():
        made.append(
            Row(f"energy box, {n} discs, {seconds} s: largest fluctuation", published, LOOKED_UP, f"T-4359, {where}",
                *mean_of([one["deviation"] for one in found[f"box {n}"]]), (0.0, 2 * published),
                "up to twice: it is that of the deepest of some thousand contacts of one draw",
                "draws scatter by half of their mean; places and velocities are not all told")
        )  # fmt: skip
    dam = found["dam break"][0]
    made += [
        Row("dam break: overlap at the foot of a column / ((n - 1) m g / k)", 1.0, LOOKED_UP, "T-4359, 6.2, figure 6.2",
            dam["overlap"], limits=around(1.0, 1e-3), reason="a start is moved by 1e-6 diameters"),
        Row("dam break: discs", 1201, LOOKED_UP, "T-4359, 6.2", dam["discs"], limits=around(1201, by=1),
            reason="12 m x 4 m of discs of 0.2 m are 60 x 20; where the one more lies is not told"),
        Row("dam break, 5 s: time of the run there over ours", None, "", "", 3600 * HOURS["dam break"] / dam["seconds"],
            reason="4 hours there; another machine, so no gate"),
    ]  # fmt: skip
    return [*made, *_long(found)] if "jump" in found else made


def _long(found: Found) -> list[Row]:
    """Rows of the runs that the short form leaves out."""
    speed, peak = (mean_of([one[key] for one in found["structure"]]) for key in ("speed", "peak"))
    free, rubbing = found["jump without friction"], found["jump"]
    stands, locked = (float(np.mean([one["verdict"] == "jump" for one in ones])) for ones in (free, rubbing))
    seconds = mean_of([one["seconds"] for one in rubbing])[0]
    return [
        Row("structure of 6 m: speed of the wave back, m/s", "below 0", LOOKED_UP, "T-4359, 6.2, 6.13 to 6.21",
            *speed, limits=(-sqrt(9.81 * 12), 0.0), reason="it goes back upstream, no faster than a wave in 12 m"),
        Row("structure of 6 m: largest force over the hydrostatic one", None, "", "", *peak,
            reason="the thesis shows curves without a scale that can be read; no gate"),
        Row("jump, μ 0.1: share of the starts with a hydraulic jump", 1.0, LOOKED_UP, "T-4359, 6.3, 6.22 to 6.34",
            locked, limits=(0.99, 1.0), reason="'a reasonable representation of the profile' is said of one run",
            why="friction locks the discs behind the front: four in five stand still under a slope. The profile "
            "looks like a jump and moves upstream; without friction it is one"),
        Row("jump, μ 0: share of the starts with a hydraulic jump", 1.0, LOOKED_UP, "T-4359, 6.3 and 6.4",
            stands, limits=(0.99, 1.0), reason="the thesis: stability depends on speed, damping and friction"),
        Row("jump, μ 0: depth behind it over Bélanger's, less 1", 0.0, LOOKED_UP, "T-4359, 6.4",
            *mean_of([one["deviation"] for one in free]), (-0.05, 0.05), "5 %: the sequent depth of fluids"),
        Row("jump, μ 0: length over 9.75 (Fr1 - 1)^1.01 y1", 1.0, LOOKED_UP, "T-4359, (4.27)",
            *mean_of([one["length"] for one in free if one["length"]]), around(1.0, 0.2),
            "20 %: scatter of measured lengths",
            "discs lose their speed in one to two depths, water in five to six: no turbulence carries it on"),
        Row("jump, 20 s: time of the run there over ours", None, "", "", 3600 * HOURS["jump"] / seconds,
            reason="100 hours there; another machine, so no gate"),
    ]  # fmt: skip


def figure(found: Found) -> Figure:
    """Draw fluctuations of the boxes, and restitution against the step."""
    with drawing(7.2, 3.4, 1, 2) as (made, axes):
        left, right = np.ravel(axes)
        boxes = [mean_of([one["deviation"] for one in found[f"box {n}"]])[0] for n in BOXES]
        place = np.arange(len(BOXES))
        left.bar(place - 0.2, [100 * BOXES[n][1] for n in BOXES], 0.4, color=GREY, label="thesis")
        left.bar(place + 0.2, 100 * np.array(boxes), 0.4, color=BLUE, hatch="//", edgecolor="white", label="ours")
        left.set_xticks(place, [f"{n} discs" for n in BOXES])
        left.set(ylabel="largest fluctuation of the energy [%]")
        left.legend()
        right.plot(
            SHARES, [found[f"step {share:g}"][0]["restitution"] for share in SHARES], "o-", color=RED, label="ours"
        )
        right.axhline(0.2, color=GREY, ls="--", label="asked")
        right.set(
            xlabel="step over the largest stable one [1]", ylabel="restitution coefficient [1]", ylim=(0.19, 0.21)
        )
        right.legend()
    return made


LAW = Law(
    "The thesis T-4359",
    "Do our runs show what the thesis says of its own?",
    points,
    rows,
    figure,
    ("docs/thesis.md has every figure, table and claim in its order, with what was asked for as further work.",),
)
