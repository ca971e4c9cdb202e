# SPDX-License-Identifier: GPL-2.0-or-later
"""Every analysis where its condition fails: no bed, a shelf, no disc, one frame, discs outside, discs that stand.

A number that means nothing then is absent, and a reason stands beside it.
"""

from __future__ import annotations

import re
from math import copysign

import numpy as np
import pytest

from lammps_jump.analysis import pipeline, quantities
from lammps_jump.analysis.tables import main_numbers
from lammps_jump.analysis.verdicts import headline, verdict
from lammps_jump.case import parse_case
from lammps_jump.dump.frame import make_frame
from lammps_jump.dump.write import DumpWriter
from lammps_jump.runs import results

BACK = "{name: back, kind: plane, axis: x, at: 0, side: above}"
BEDS = {
    "nothing": "",
    "no bed": BACK,
    "shelf": f"{BACK}, {{name: shelf, kind: block, x: [0, 1], y: [-0.2, 0]}}",
    "floor": f"{BACK}, {{name: floor, kind: plane, axis: y, at: 0, side: above}}",
}
CASE = """\
name: conditions
discs: {diameter: 0.1}
contact: {restitution: 0.5, impact_speed: 6}
domain: {x: [-1, 30], y: [-3, 4]}
walls: [WALLS]
initial: [{kind: column, x: [0, 1], y: [0, 1], hydrostatic: false, gate: false}]
outflow: [{y_below: -2.5}]
run: {duration: 1, output_interval: 0.1}
probes: {gauges: [0.5, 3.0]}
"""
DISCS = ("spreads", "stands", "outside", "none", "none at the end", "one frame")
WANTED = [name for name in quantities.QUANTITIES if name not in ("inflow", "force", "drum", "hopper")]


def frames(scene, discs):
    for k in range(1 if discs == "one frame" else 11):
        x, y = scene.positions.T
        time, speed = 0.1 * k, x if discs == "spreads" else 0 * x
        x = x * (1 + time) if discs == "spreads" else x + 20 * (discs == "outside")
        n = 0 if discs == "none" or (discs == "none at the end" and k > 5) else len(x)
        columns = {"id": np.arange(n) + 1, "x": x[:n], "y": y[:n], "vx": speed[:n], "vy": 0 * x[:n]}
        yield make_frame(k * scene.output_steps, time, scene.domain, columns)


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """Summaries of all analyses, by bed and by what the discs do."""
    summaries = {}
    for bed, walls in BEDS.items():
        case = parse_case(CASE.replace("WALLS", walls), "conditions.yaml")
        for discs in DISCS:
            folder = tmp_path_factory.mktemp("run")
            with DumpWriter(folder / "dump.lammpstrj", ("id", "x", "y", "vx", "vy")) as out:
                for frame in frames(case.scene(), discs):
                    out.write_frame(frame)
            summaries[bed, discs] = pipeline.analyse(
                results.flow_of(case, folder), folder / "dump.lammpstrj", folder, WANTED,
                pictures=pipeline.Pictures("none"),
            )  # fmt: skip
    return summaries


CASES = [(bed, discs) for bed in BEDS for discs in DISCS]


def all_numbers(value, key=""):
    if isinstance(value, dict):
        for name, one in value.items():
            yield from all_numbers(one, f"{key}.{name}")
    elif isinstance(value, list):
        for one in value:
            yield from all_numbers(one, key)
    elif isinstance(value, float):
        yield key, value


@pytest.mark.parametrize("bed, discs", CASES)
def test_no_text_and_no_number_is_empty_of_meaning(found, bed, discs):
    parts = found[bed, discs]
    texts = [headline(parts), verdict(parts), *main_numbers(parts)]
    told = (quantities.QUANTITIES[name] for name in WANTED if name in parts)
    for section in (quantity.section(quantity.read(parts[quantity.name])) for quantity in told):
        texts += [str(block) for block in section.blocks] if section else []
    for text in texts:
        assert not re.search(r"\bnan\b|\binf\b|(?<![\d.])-0(\.0+)?(?![\d.])", text), text
    assert not [key for key, value in all_numbers(parts) if value == 0 and copysign(1, value) < 0]


@pytest.mark.parametrize("bed, discs", CASES)
def test_without_a_bed_nothing_is_measured_above_it(found, bed, discs):
    parts = found[bed, discs]
    front, heap, jump = parts["front"], parts["heap"], parts["jump"]
    assert jump.get("y2") is None and jump["reason"]
    assert front["arrival_time"] is None  # nothing stands in the way on any bed
    if bed != "floor" or discs in ("none", "outside"):
        assert front["ritter"] is None
    if bed in ("nothing", "no bed"):
        for key in ("free_length", "speed", "column_height", "column_depth"):
            assert front[key] is None
        assert front["reason"] and heap["height"] is None and heap["reason"]
    elif bed == "shelf":
        assert front["free_length"] is front["speed"] is None and front["reason"]
        assert (front["column_height"] == pytest.approx(1)) is (discs not in ("none", "outside"))
    if discs == "outside":  # what lies elsewhere is no column at the back wall
        assert front["column_depth"] is None


@pytest.mark.parametrize("bed", BEDS)
def test_without_a_disc_every_analysis_says_so(found, bed):
    counts = ("waves", "state")  # what they say of no disc is that none is there
    parts = {name: part for name, part in found[bed, "none"].items() if name in WANTED and name not in counts}
    assert len(parts) > 5
    for name, part in parts.items():
        assert part.get("reason"), name
        measured = {
            key
            for key, value in all_numbers(part)
            if key not in (".height", ".begin", ".end", ".window", ".share_found")
        }
        assert not measured, (name, measured)
    assert found[bed, "none at the end"]["rest"]["reason"] == "no disc is left in the last frame"


@pytest.mark.parametrize("bed", BEDS)
def test_one_frame_tells_no_change(found, bed):
    parts = found[bed, "one frame"]
    assert parts["energy"]["initial"] > 0 and parts["energy"]["reason"]
    for name, key in (
        ("energy", "max_deviation"), ("energy", "drift"), ("front", "speed"), ("front", "ritter"),
        ("rest", "sinking"), ("rest", "begin"), ("jump", "speed"),
    ):  # fmt: skip
        assert parts[name].get(key) is None, (name, key)
    for discs in ("one frame", "stands"):
        assert "record is shorter" in found[bed, discs]["rest"]["reason"]
