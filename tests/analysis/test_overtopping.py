# SPDX-License-Identifier: GPL-2.0-or-later
"""Flow over structures from frames made by hand: volume, discharge, depth and head are known."""

from types import SimpleNamespace

import numpy as np
import pytest
from made_up import disc_frame, flow_context

from lammps_jump.analysis.devices.overtopping import CrestWatch, analyse, figures, section, structures_of, tables
from lammps_jump.analysis.passes import Gathered
from lammps_jump.physics.jump import critical_discharge, gate_discharge
from lammps_jump.scene.walls import Block, Box, Plane

D, U, DT, FRAMES = 0.2, 2.0, 0.05, 60
WEIR = Block("weir", (10.0, 12.0), (0.0, 1.0))
BOX = [[-20.0, 40.0], [-5.0, 20.0]]


@pytest.fixture(autouse=True)
def window(monkeypatch):
    monkeypatch.setattr("lammps_jump.analysis.devices.overtopping.window_of", lambda _: (1.0, 3.0))


def flow_of(*walls, probes=("weir",), **more):
    given = {"domain": ((-20.0, 40.0), (-5.0, 20.0)), "x_range": (-20.0, 40.0)}
    return flow_context(**given | more, walls=walls, probes=probes)


def found_of(flow, frames):
    watch = CrestWatch(flow)
    for k, frame in enumerate(frames):
        watch.add(frame, k * DT)
    profiles = SimpleNamespace(attrs={})
    return analyse(Gathered(flow, profiles, None, {"overtopping": watch.result()}, {}))


def stream(rows, low, sense=1.0):
    """Rows of discs at a distance of a diameter that go along x at U, from this height on."""
    x, y = (grid.ravel() for grid in np.meshgrid(np.arange(-15.0, 11.0, D), low + D * (np.arange(rows) + 0.5)))
    for k in range(FRAMES):
        yield disc_frame(11.0 + sense * (x - 11.0 + U * k * DT), y, sense * U, box=BOX, step=k, time=k * DT)


@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize("rows", [2, 4])
def test_a_stream_over_a_weir_has_its_discharge_depth_and_head(rows, sense):
    """q = u s with s = rows d; the head is that of its upper edge and u^2/2g; both ways."""
    flow = flow_of(WEIR, Plane("floor", "y", 0.0, "above"))
    found = found_of(flow, stream(rows, 1.0, sense))["weir"]
    depth = rows * D
    assert found.side == ("right" if sense > 0 else "left") and found.crest == 1.0
    assert found.discharge == pytest.approx(U * depth, rel=1 / 19)  # whole discs: twenty of a row in the window
    assert found.volume == pytest.approx(U * depth * (FRAMES - 1) * DT, rel=1 / 29)
    assert found.discs == pytest.approx(found.volume / D**2)
    assert found.depth == pytest.approx(depth, rel=0.11)  # whole discs on 2 m
    head = depth + U * U / (2 * 9.81)
    assert found.head == pytest.approx(head, rel=1e-6)
    assert found.discharge_ratio == pytest.approx(found.discharge / critical_discharge(head))
    assert 0.0 < found.since <= 2 * D / U


def test_what_passes_below_the_crest_or_comes_back_does_not_count():
    flow = flow_of(WEIR)
    below = found_of(flow, stream(1, 0.5))["weir"]
    assert below.reason == "nothing has gone over it" and below.discs == 0 and np.isnan(below.volume)
    x = 10.5 + np.abs(np.sin(np.arange(FRAMES) * 0.3))
    there_and_back = [disc_frame([p], [1.3], box=BOX, step=k, time=k * DT) for k, p in enumerate(x)]
    found = found_of(flow, there_and_back)["weir"]
    assert found.discs > 2 and abs(found.volume) <= D**2 and "fewer than 30 discs" in found.reason


def test_only_structures_that_end_are_looked_at():
    flow = flow_of(WEIR, Box("box", (-19.0, 39.0), (-4.0, 19.0)), Plane("floor", "y", 0.0, "above"),
                   Block("other", (20.0, 21.0), (0.0, 1.0)), probes=("weir", "box", "floor"))  # fmt: skip
    assert structures_of(flow) == ("weir",)


def test_table_figure_and_section():
    found = found_of(flow_of(WEIR), stream(2, 1.0))
    (rows,) = tables(found).values()
    assert set(rows) == {"time", "name", "volume", "depth", "brink", "head", "below"} and set(rows["name"]) == {"weir"}
    assert rows["volume"][-1] == pytest.approx(found["weir"].volume)
    assert len(figures(found, None)["overtopping"].panels) == 3 and len(section(found).blocks) == 1


@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize("rows", [2, 5])
def test_what_goes_below_a_gate_has_its_discharge_and_head(rows, sense):
    """q = u s below a gate of 1.2 m; the head is that over the bed, and water has C a sqrt(2 g (H - C a))."""
    gate = Block("gate", (10.0, 12.0), (1.2, 4.0))
    floor = Plane("floor", "y", 0.0, "above")
    found = found_of(flow_of(gate, floor, probes=("gate",)), stream(rows, 0.0, sense))["gate"]
    assert found.side == ("right" if sense > 0 else "left") and found.opening == pytest.approx(1.2)
    assert found.below == pytest.approx(U * rows * D, rel=1 / 19) and found.discs == 0 and found.reason is None
    head = rows * D + U * U / (2 * 9.81)
    assert found.below_head == pytest.approx(head, rel=1e-6)
    jet = 0.61 * 1.2
    water = jet * np.sqrt(2 * 9.81 * (head - jet)) if head > jet else np.nan
    assert found.gate_discharge == pytest.approx(water, nan_ok=True) == gate_discharge(1.2, head, 9.81)
    assert np.isnan(found.discharge) and len(section({"gate": found}).blocks) == 1


def test_a_gap_that_no_disc_passes_is_no_gate():
    gate = Block("gate", (10.0, 12.0), (0.15, 4.0))
    flow = flow_of(gate, Plane("floor", "y", 0.0, "above"), probes=("gate",))
    found = found_of(flow, stream(5, 0.0))["gate"]
    assert np.isnan(found.opening) and np.isnan(found.below) and found.reason == "nothing has gone over it"


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_depth_at_the_brink_is_that_of_the_lower_end(sense):
    """Of a stream of three rows; a free fall of water would have 0.715 critical depths there."""
    found = found_of(flow_of(WEIR, Plane("floor", "y", 0.0, "above")), stream(3, 1.0, sense))["weir"]
    assert found.brink == pytest.approx(3 * D, rel=0.3)  # whole discs on two diameters
    assert found.critical_depth == pytest.approx((found.discharge**2 / 9.81) ** (1 / 3))
    assert found.brink_ratio == pytest.approx(found.brink / (0.715 * found.critical_depth))
